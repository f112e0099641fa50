//! Newton's method in doubles for the coefficients of cosine sums, which makes certificates.
//!
//! Nothing is rigorous here, and nothing in a proof rests on it. The first `K` harmonics are solved
//! for by Newton's method; the others are the fixed point `a_k = C_k n_k`.

use crate::{
    certificate::{Breather, Center, Certificate, Infinite, Model, Orbit, Wave},
    check::{Proof, Refused},
    exact::Exact,
    untrusted::choices::solved,
};
use std::f64::consts::PI;

/// Samples of a period: for each harmonic at least, and for each square of their number up to the
/// third, since a cosine sum of few harmonics is less near to a solution.
const SAMPLES: [usize; 3] = [64, 4, 1 << 15];
/// Difference of frequencies by which derivatives are approximated.
const DIFFERENCE: f64 = 1e-7;
/// Most steps of Newton's method.
const MOST_STEPS: usize = 60;

/// The sizes of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// `K`: harmonics in the block.
    pub block: usize,
    /// `H`: harmonics of the cosine sum.
    pub harmonics: usize,
    /// `K'`: harmonics that are enclosed.
    pub enclosed: usize,
}

impl Sizes {
    /// Those of waves.
    pub const WAVE: Self = Self { block: 16, harmonics: 512, enclosed: 512 };
    /// Those of breathers.
    pub const BREATHER: Self = Self { block: 16, harmonics: 256, enclosed: 256 };
    /// Those of pieces of branches of waves.
    pub const WAVE_PIECE: Self = Self { block: 12, harmonics: 32, enclosed: 48 };
    /// Those of pieces of branches of breathers.
    pub const BREATHER_PIECE: Self = Self { block: 8, harmonics: 12, enclosed: 32 };
    /// The same of doubled period.
    pub const DOUBLED_PIECE: Self = Self { block: 16, harmonics: 24, enclosed: 64 };

    /// As many times the harmonics, with the same block.
    #[must_use]
    pub fn times(self, times: usize) -> Self {
        Self { harmonics: times * self.harmonics, enclosed: times * self.enclosed, ..self }
    }
}

/// The certificate with the solution near the cosine sum of this one, and its multiplier; of a wave
/// with `first` that of this first harmonic, of which the frequency is found, too. `None` if
/// Newton's method finds none.
pub fn near(near: &Certificate, sizes: Sizes) -> Option<Certificate> {
    let (model, mean, first) = (near.model, near.mean, near.first);
    let found = match &near.orbit {
        Orbit::Wave(Wave { q_over_pi, a }) => wave_of(model, *q_over_pi, mean, a, sizes, first.map(|[first, _]| first)),
        Orbit::Breather(Breather { sites, center, a }) => breather(model, (mean, *sites), *center, a, sizes),
        Orbit::Infinite(near) => infinite(model, mean, near, sizes),
    };
    found.map(|found| Certificate { first, multiplier: near.multiplier, ..found })
}

/// The certificate of a single orbit.
fn point(model: Model, mean: Exact, Sizes { block, enclosed, .. }: Sizes, orbit: Orbit) -> Certificate {
    Certificate { model, mean, to: None, first: None, block, enclosed, orbit, multiplier: None }
}

/// Distance of neighbours, as a share of the background, from which on strains are those of the
/// background; and that from which on it decays exponentially.
const FAR: [f64; 2] = [1e-13, 1e-2];
/// Harmonics of the background, over those of the sites: all of them feel its error.
const FINER: usize = 4;
/// Rate of decay that is proved, over the one computed.
const RATE: f64 = 0.5;
/// Weight of the last sites that `A` couples, over that of the first ones.
const CUT: f64 = 1e-3;

/// The certificate of the breather of the infinite chain near this one of a ring, with the mean
/// strain of its far end. `None` if Newton's method finds none, or if it does not decay.
pub fn unrolled(ring: &Certificate, sizes: Sizes) -> Option<Certificate> {
    let (model, Orbit::Breather(Breather { center, a, .. })) = (ring.model, &ring.orbit) else { return None };
    let (center, mut a, first) = (*center, a.clone(), usize::from(*center == Center::Bond));
    let far = a.pop()?;
    let sign = |n: usize, k: usize| if (n + first) * k % 2 == 1 { -1.0 } else { 1.0 };
    let background = far.iter().enumerate().skip(1).map(|(k, x)| sign(a.len(), k) * x).collect();
    let near = Infinite { center, decay: Exact::ONE, band: 1, background, a };
    let mut certificate = infinite(model, rounded(far[0])?, &near, sizes)?;
    let Orbit::Infinite(found) = &mut certificate.orbit else { return None };
    // Distances of neighbours, since the background has more harmonics than they have.
    let apart = |(n, pair): (usize, &[Vec<f64>])| -> f64 {
        let of = |(k, (a, b)): (usize, (&f64, &f64))| (sign(n, k) * a - sign(n + 1, k) * b).abs();
        pair[0].iter().zip(&pair[1]).enumerate().map(of).sum()
    };
    let apart: Vec<f64> = found.a.windows(2).enumerate().map(apart).collect();
    let before = |share: f64| apart.iter().take_while(|apart| **apart > share * far[1].abs()).count();
    let [end, start] = FAR.map(before);
    let rate = (apart.get(start)? / apart.get(end.checked_sub(1)?)?).ln() / (end - 1).checked_sub(start)? as f64;
    if end < apart.len() {
        found.a.truncate(end);
    }
    found.decay = Exact::new((100.0 * RATE * rate) as i64, 100)?;
    found.band = (-CUT.ln() / ((1.0 - RATE) * rate)).ceil() as usize;
    (found.decay.num() > 0).then_some(certificate)
}

/// A number as one with few digits, so that the decimal is exact.
fn rounded(x: f64) -> Option<Exact> {
    Exact::of_double((x * 1e18).round() / 1e18)
}

/// The certificate of the breather of the infinite chain near this one.
fn infinite(model: Model, mean: Exact, near: &Infinite, sizes: Sizes) -> Option<Certificate> {
    let Orbit::Wave(Wave { a: background, .. }) =
        wave(model, Exact::ONE, mean, &near.background, sizes.times(FINER))?.orbit
    else {
        return None;
    };
    let last = near.a.len() + usize::from(near.center == Center::Bond);
    let turned = |(k, x): (usize, &f64)| if last % 2 == 1 && k % 2 == 0 { -x } else { *x };
    let far = [approximate(mean)].into_iter().chain(background.iter().enumerate().map(turned)).collect();
    let rows = [near.a.as_slice(), &[far]].concat();
    let mut a = half(model, (mean, 2 * rows.len() - 1), near.center, &rows, sizes, true)?;
    a.pop();
    Some(point(model, mean, sizes, Orbit::Infinite(Infinite { background, a, ..near.clone() })))
}

/// Length of the first piece of a strip without a multiplier that is tried, as a share of the
/// strip, and of the shortest.
const LENGTHS: [f64; 2] = [1.0 / 16.0, 1.0 / 1024.0];
/// Largest radius of a piece over its radius of uniqueness. Balls of this size that meet lie within
/// the other's ball of uniqueness, if both have the same norm.
const FILLED: f64 = 1.0 / 3.0;

/// Half of the range of an unknown frequency on a piece, over its change from the middle to an end;
/// and, relative to `l_1/l_1'`, over the relative change of the first harmonic.
const ROOM: [f64; 2] = [5.0, 2.0];

/// The proved pieces of a strip of a branch, and where and why they end before it does.
#[derive(Clone, Debug)]
pub struct Strip {
    /// The pieces, one after the other.
    pub pieces: Vec<(Certificate, Proof)>,
    /// Frequency, or first harmonic, at which they end, and why the next piece is not proved.
    pub stop: Option<(Exact, String)>,
}

/// The strip of a branch between two certificates near solutions, along which frequency and mean
/// strain are linear, in pieces as long as can be proved, and with the multiplier that both have.
/// Where both have `first`, the first harmonic is linear, and the frequency unknown.
///
/// # Errors
/// [`Refused::Stopped`].
pub fn strip(
    [from, to]: [&Certificate; 2],
    sizes: Sizes,
    check: &dyn Fn(&Certificate) -> Result<Proof, Refused>,
) -> Result<Strip, Refused> {
    let ends = [from, to].map(|it| it.ends()[0]);
    let at = |s: f64| -> Option<[Exact; 2]> {
        let between = |i: usize| {
            let [from, to] = ends.map(|end| approximate(end[i]));
            rounded(from + s * (to - from))
        };
        if s >= 1.0 { Some(ends[1]) } else { Some([between(0)?, between(1)?]) }
    };
    let mut strip = Strip { pieces: Vec::new(), stop: None };
    let multiplier = from.multiplier.filter(|it| to.multiplier == Some(*it));
    let first = if multiplier.is_some() { 1.0 } else { LENGTHS[0] };
    let (mut near, mut start, mut s, mut length) = (from.clone(), ends[0], 0.0, first);
    while s < 1.0 {
        let rest = ((1.0 - s) / length).ceil();
        let end = if rest > 1.0 { s + (1.0 - s) / rest } else { 1.0 };
        let piece =
            at(0.5 * (s + end)).zip(at(end)).and_then(|(middle, end)| piece(&near, [start, middle, end], sizes));
        let piece = piece.map(|piece| Certificate { multiplier, ..piece });
        let checked = piece.map(|piece| (check(&piece), piece));
        // A ball of a piece of length h has a radius r with h about r - r^2, in units of that of
        // uniqueness.
        let longer = |filled: f64| 0.9 * (FILLED - FILLED * FILLED) / (filled - filled * filled);
        let (factor, why) = match checked {
            Some((Err(Refused::Stopped), _)) => return Err(Refused::Stopped),
            Some((Ok(proof), piece)) => {
                let filled = proof.radius / proof.uniqueness_radius;
                if filled <= FILLED {
                    length = (end - s) * longer(filled).clamp(0.9, 4.0);
                    (s, start) = (end, piece.ends()[1]);
                    near = Certificate { to: None, ..piece.clone() };
                    strip.pieces.push((piece, proof));
                    continue;
                }
                let why = "the balls of pieces are too wide for their radii of uniqueness".to_owned();
                (if filled < 0.5 { longer(filled).min(0.9) } else { 0.5 }, why)
            }
            Some((Err(why), _)) => (0.5, why.to_string()),
            None => (0.5, "no cosine sum near the solution is found".to_owned()),
        };
        length = factor * (end - s);
        if length < LENGTHS[1] {
            strip.stop = Some((start[0], why));
            break;
        }
    }
    Ok(strip)
}

/// The piece between the first and the last of these parameters, about the solution at the second.
fn piece(near: &Certificate, ends: [[Exact; 2]; 3], sizes: Sizes) -> Option<Certificate> {
    let [start, middle, end] = ends;
    let at = |[parameter, mean]: [Exact; 2]| {
        let first = near.first.map(|_| [parameter; 2]);
        let omega = if first.is_some() { near.model.omega } else { parameter };
        self::near(&Certificate { model: Model { omega, ..near.model }, mean, first, ..near.clone() }, sizes)
    };
    let found = at(middle)?;
    let [mut from, mut to] = [start[0], end[0]];
    if near.first.is_some() {
        let [omega, before, after] = [Some(&found), at(start).as_ref(), at(end).as_ref()]
            .map(|it| it.map_or(f64::NAN, |it| approximate(it.model.omega)));
        let l = |by: f64| inverse(&near.model, omega + by, 1);
        let slope = (l(DIFFERENCE) - l(-DIFFERENCE)) / (2.0 * DIFFERENCE * l(0.0));
        let share = (approximate(end[0]) / approximate(middle[0]) - 1.0) / slope;
        let half = ROOM[0] * (before - omega).abs().max((after - omega).abs()) + ROOM[1] * share.abs();
        (from, to) = (rounded(omega - half)?, rounded(omega + half)?);
    }
    let (model, first) = (Model { omega: from, ..near.model }, near.first.map(|_| [start[0], end[0]]));
    Some(Certificate { model, mean: start[1], to: Some([to, end[1]]), first, ..found })
}

/// The certificate of the wave near `X = mean + sum guess_k cos k theta`, `guess = a_1, a_2, ...`.
/// `None` if Newton's method finds none.
pub fn wave(model: Model, q_over_pi: Exact, mean: Exact, guess: &[f64], sizes: Sizes) -> Option<Certificate> {
    wave_of(model, q_over_pi, mean, guess, sizes, None)
}

/// The same, or the wave with this first harmonic and a frequency near that of the model.
fn wave_of(
    mut model: Model,
    q_over_pi: Exact,
    mean: Exact,
    guess: &[f64],
    sizes: Sizes,
    first: Option<Exact>,
) -> Option<Certificate> {
    let (q, mut omega) = (PI * approximate(q_over_pi), approximate(model.omega));
    let lattice = |k: usize| 2.0 - 2.0 * (q * k as f64).cos();
    let Sizes { block, harmonics, .. } = sizes;
    let mut a = vec![approximate(mean)];
    a.extend(guess.iter().take(harmonics));
    a.resize(harmonics + 1, 0.0);
    if let Some(first) = first {
        a[1] = approximate(first);
    }
    let mut smallest = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let [force, stiffness] = series(&a, approximate(model.alpha), harmonics.max(2 * block));
        let at = |omega: f64| (0..=harmonics).map(|k| lattice(k) * inverse(&model, omega, k)).collect::<Vec<f64>>();
        let [c, below, above] = [0.0, -DIFFERENCE, DIFFERENCE].map(|by| at(omega + by));
        let entry = |k: usize, j: usize| match first {
            Some(_) if j == 1 => -(above[k] - below[k]) / (2.0 * DIFFERENCE) * force[k],
            _ => f64::from(k == j) + c[k] * cosine_product(&stiffness, k, j),
        };
        let rows = (1..=block).map(|k| (1..=block).map(|j| entry(k, j)).chain([a[k] - c[k] * force[k]]).collect());
        let mut steps = solved(rows.collect()).concat();
        steps.extend((block + 1..=harmonics).map(|k| a[k] - c[k] * force[k]));
        let size: f64 = steps.iter().map(|step| step.abs()).sum();
        if first.is_some() {
            omega -= std::mem::take(&mut steps[0]);
        }
        a[1..].iter_mut().zip(&steps).for_each(|(a, step)| *a -= step);
        // Rounding errors: no further progress.
        if size >= 0.5 * smallest && size < 1e-10 * a[1].abs() || size == 0.0 {
            a.remove(0);
            if first.is_some() {
                model.omega = rounded(omega)?;
            }
            return Some(point(model, mean, sizes, Orbit::Wave(Wave { q_over_pi, a })));
        }
        smallest = size.min(smallest);
    }
    None
}

/// The certificate of the dark breather near `x_n = sum guess_{nk} cos k omega t`, with a row of
/// the guess for each site of the half, as in [`Breather::a`], on a ring of this many sites. `None`
/// if Newton's method finds none.
pub fn breather(
    model: Model,
    (mean, sites): (Exact, usize),
    center: Center,
    guess: &[Vec<f64>],
    sizes: Sizes,
) -> Option<Certificate> {
    let a = half(model, (mean, sites), center, guess, sizes, false)?;
    Some(point(model, mean, sizes, Orbit::Breather(Breather { sites, center, a })))
}

/// The coefficients of half of a ring; or, with the far end `held`, those of the sites before it,
/// of which the mean forces are that of the far end.
fn half(
    model: Model,
    (mean, sites): (Exact, usize),
    center: Center,
    guess: &[Vec<f64>],
    sizes: Sizes,
    held: bool,
) -> Option<Vec<Vec<f64>>> {
    let Sizes { block, harmonics, .. } = sizes;
    let (half, width, site) = (guess.len(), block + 1, center == Center::Site);
    let free = half - usize::from(held);
    let (mean, omega) = (approximate(mean), approximate(model.omega));
    let inverses: Vec<f64> = (0..=harmonics).map(|k| inverse(&model, omega, k)).collect();
    // Row of a site of the ring, and whether its strain is that of half a period later.
    let row = |n: usize| {
        let n = n % sites;
        let last = if site { half } else { half + 1 };
        if n < last && (site || n > 0) {
            (n - usize::from(!site), false)
        } else if site {
            (sites - n, true)
        } else {
            ((sites + 1 - n) % sites - 1, false)
        }
    };
    let ring = |i: usize| i + usize::from(!site) + sites;
    // The second difference of harmonic k: rows and factors.
    let difference = |i: usize, k: usize| {
        [(0, 2.0), (1, -1.0), (sites - 1, -1.0)].map(|(step, factor)| {
            let (row, turned) = row(ring(i) + step);
            (row, if turned && k % 2 == 1 { -factor } else { factor })
        })
    };
    let share: Vec<f64> =
        (0..half).map(|i| (0..sites).filter(|n| row(*n).0 == i).count() as f64 / sites as f64).collect();
    let mut a: Vec<Vec<f64>> = guess.to_vec();
    a.iter_mut().for_each(|a| a.resize(harmonics + 1, 0.0));
    let (mut smallest, unknowns) = (f64::INFINITY, free * width);
    for _ in 0..MOST_STEPS {
        let known: Vec<[Vec<f64>; 2]> =
            a.iter().map(|a| series(a, approximate(model.alpha), harmonics.max(2 * block))).collect();
        let defect = |i: usize, k: usize| {
            let sum: f64 = difference(i, k).iter().map(|(m, factor)| factor * known[*m][0][k]).sum();
            a[i][k] - inverses[k] * sum
        };
        let mut rows = vec![vec![0.0; unknowns + 1]; unknowns];
        for i in 0..free {
            for k in 0..width {
                let row = &mut rows[i * width + k];
                // Mean forces of neighbours are the same; the last equation is that of the mean strain.
                let level = [(i, -1.0), ((i + 1) % half, 1.0), (i, 0.0)];
                let (terms, factor) = match k {
                    0 if i + 1 == half => {
                        (0..half).for_each(|m| row[m * width] = share[m]);
                        row[unknowns] = a.iter().zip(&share).map(|(a, share)| a[0] * share).sum::<f64>() - mean;
                        continue;
                    }
                    0 => {
                        row[unknowns] = known[i][0][0] - known[i + 1][0][0];
                        (level, 1.0)
                    }
                    _ => {
                        (row[unknowns], row[i * width + k]) = (defect(i, k), 1.0);
                        (difference(i, k), inverses[k])
                    }
                };
                for (m, term) in terms.into_iter().filter(|(m, _)| *m < free) {
                    for j in 0..width {
                        row[m * width + j] += factor * term * cosine_product(&known[m][1], k, j);
                    }
                }
            }
        }
        let steps = solved(rows).concat();
        let beyond: Vec<Vec<f64>> = (0..free).map(|i| (width..=harmonics).map(|k| defect(i, k)).collect()).collect();
        for ((a, near), far) in a.iter_mut().zip(steps.chunks(width)).zip(&beyond) {
            a.iter_mut().zip(near.iter().chain(far)).for_each(|(a, step)| *a -= step);
        }
        let size = steps.iter().chain(beyond.iter().flatten()).fold(0.0, |most: f64, step| most.max(step.abs()));
        let first = a.iter().fold(0.0, |most: f64, a| most.max(a[1].abs()));
        if size >= 0.5 * smallest && size < 1e-10 * first || size == 0.0 {
            if site {
                a[0].iter_mut().skip(1).step_by(2).for_each(|a| *a = 0.0);
            }
            return Some(a);
        }
        smallest = size.min(smallest);
    }
    None
}

/// The coefficient of `cos k theta` in `cos j theta` times a cosine sum.
fn cosine_product(d: &[f64], k: usize, j: usize) -> f64 {
    let h = |l: usize| if l == 0 { d[0] } else { 0.5 * d[l] };
    match (k, j) {
        (_, 0) => d[k],
        (0, _) => h(j),
        _ => h(k.abs_diff(j)) + h(k + j),
    }
}

fn approximate(x: Exact) -> f64 {
    x.num() as f64 / x.den() as f64
}

/// `1/L_k` at a frequency; 0 for `k = 0`.
fn inverse(model: &Model, omega: f64, k: usize) -> f64 {
    let (kappa, square) = (approximate(model.kappa), (omega * k as f64).powi(2));
    match model.rho.map(approximate) {
        _ if k == 0 => 0.0,
        None => 1.0 / (kappa - square),
        Some(0.0) => -1.0 / square,
        Some(rho) => -(kappa - rho * square) / (square * (kappa * (1.0 + rho) - rho * square)),
    }
}

/// Coefficients of the force and of its derivative by the overlap, for `X = sum a_k cos k theta`.
fn series(a: &[f64], alpha: f64, count: usize) -> [Vec<f64>; 2] {
    let [each, squares, most] = SAMPLES;
    let samples = (each * count).max(most.min(squares * count * count)).next_power_of_two();
    let mut samples = vec![(0.0, 0.0); samples];
    let scale = 1.0 / samples.len() as f64;
    samples.iter_mut().zip(a).for_each(|(sample, a)| sample.0 = *a);
    fourier(&mut samples);
    for sample in &mut samples {
        let overlap = (-sample.0).max(0.0);
        *sample = (overlap.powf(alpha), alpha * overlap.powf(alpha - 1.0));
    }
    // Even real functions have real transforms.
    fourier(&mut samples);
    let of = |part: fn(&(f64, f64)) -> f64| {
        let term = |(k, sample): (usize, &(f64, f64))| (if k == 0 { 1.0 } else { 2.0 }) * part(sample) * scale;
        samples.iter().take(count + 1).enumerate().map(term).collect()
    };
    [of(|sample| sample.0), of(|sample| sample.1)]
}

/// The transform `sum_j f_j e^{-2 pi i j k/n}` of a power of two of complex numbers.
fn fourier(values: &mut [(f64, f64)]) {
    let n = values.len();
    for i in 0..n {
        let j = i.reverse_bits() >> (n.leading_zeros() + 1);
        if i < j {
            values.swap(i, j);
        }
    }
    let turns: Vec<(f64, f64)> = (0..n / 2).map(|k| (-2.0 * PI * k as f64 / n as f64).sin_cos()).collect();
    let mut half = 1;
    while half < n {
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let (sin, cos) = turns[k * (n / (2 * half))];
                let turned = (b.0 * cos - b.1 * sin, b.0 * sin + b.1 * cos);
                (*a, *b) = ((a.0 + turned.0, a.1 + turned.1), (a.0 - turned.0, a.1 - turned.1));
            }
        }
        half *= 2;
    }
}
