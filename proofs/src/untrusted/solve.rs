//! Newton's method in doubles for the coefficients of cosine sums, which makes certificates.
//!
//! Nothing is rigorous here, and nothing in a proof rests on it. The first `K` harmonics are solved
//! for by Newton's method; the others are the fixed point `a_k = C_k n_k`.

use super::choices;
use crate::{
    certificate::{Center, Certificate, Model, Orbit},
    check::{
        Moments, Proof, Refused,
        newton::{Equations, Place, weight},
        system::System,
    },
    exact::Exact,
    interval::Interval,
};
use std::{f64::consts::PI, rc::Rc, slice::from_ref};

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
/// with `first` that of this first harmonic, of which the frequency is found, too; of a breather of
/// the infinite chain with the standing wave of its mean strain. `None` if Newton's method finds
/// none.
pub fn near(near: &Certificate, sizes: Sizes) -> Option<Certificate> {
    let Sizes { block, harmonics, enclosed } = sizes;
    let (to, wide) = (near.to.filter(|_| near.is_to_zero()), enclosed.max(harmonics).max(4 * block));
    let mut it = Certificate { to, block, enclosed: wide, ..near.clone() };
    if let Orbit::Breather { center: Center::Site, .. } | Orbit::Infinite { center: Center::Site, .. } = it.orbit {
        it.a.iter_mut().take(1).flat_map(|a| a.iter_mut().skip(1).step_by(2)).for_each(|a| *a = 0.0);
    }
    it.a.iter_mut().for_each(|a| a.resize(harmonics + 1, 0.0));
    if let Some([first, _]) = near.first {
        it.a[0][1] = approximate(first);
    }
    if let Orbit::Infinite { background, .. } = &mut it.orbit {
        let (orbit, a) = (Orbit::Wave { q_over_pi: Exact::ONE }, vec![std::mem::take(background)]);
        *background = self::near(&Certificate { orbit, a, ..near.clone() }, sizes.times(FINER))?.a.swap_remove(0);
    }
    newton(it, harmonics).map(|found| Certificate { enclosed, ..found })
}

/// Newton's method from the cosine sum of this certificate, by the equations of the checker.
fn newton(mut it: Certificate, harmonics: usize) -> Option<Certificate> {
    let (mut omega, mut smallest) = (approximate(it.model.omega), f64::INFINITY);
    for _ in 0..MOST_STEPS {
        if it.first.is_some() {
            it.model.omega = rounded(omega - DIFFERENCE)?;
            it.to = Some([rounded(omega + DIFFERENCE)?, it.mean]);
        }
        let mut system = System::new(&it).ok()?;
        let free = system.background.unwrap_or(system.a.len());
        let known = |a: &Vec<Interval>| series(a, approximate(it.model.alpha), harmonics.max(2 * it.block));
        system.known = system.a.iter().take(free + 1).map(known).collect();
        let (further, system) = (system.first.map(|first| system.a[0][1] - first[0]), Rc::new(system));
        let block = system.block(free, it.block);
        let defect = |place: &Place| system.defect(*place, system.factors[place.1]);
        let rows = choices::matrix(&block, from_ref(&system.factors)).into_iter();
        let rows = rows.zip(block.all.iter().map(defect).chain(further));
        let steps = choices::solved(rows.map(|(row, one)| row.into_iter().chain([one.mid()]).collect()).collect());
        let mut steps = steps.concat();
        // That of an unknown frequency comes last.
        omega -= steps.drain(block.all.len()..).map(|step| DIFFERENCE * step).sum::<f64>();
        let beyond = system.places(0..free, it.block + 1..harmonics + 1);
        steps.extend(beyond.iter().map(|place| defect(place).mid()));
        for (&(n, k), step) in block.all.iter().chain(&beyond).zip(&steps) {
            let turned = matches!(it.orbit, Orbit::Infinite { center, .. } if center.turns(n, k));
            it.a[n][k] -= if turned { -step } else { *step } / weight(k).mid();
        }
        if it.is_wave() {
            it.a[0][0] = 0.0;
        }
        let size = steps.iter().fold(0.0, |most: f64, step| most.max(step.abs()));
        let first = system.a.iter().fold(0.0, |most: f64, a| most.max(a[1].abs().hi()));
        // Rounding errors: no further progress.
        if size >= 0.5 * smallest && size < 1e-10 * first || size == 0.0 {
            it.model.omega = if it.first.is_some() { rounded(omega)? } else { it.model.omega };
            return Some(Certificate { to: it.to.filter(|_| it.first.is_none()), ..it });
        }
        smallest = size.min(smallest);
    }
    None
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
    let Orbit::Breather { center, .. } = ring.orbit else { return None };
    let mut a = ring.a.clone();
    let far = a.pop()?;
    let sign = |n: usize, k: usize| if center.turns(n, k) { -1.0 } else { 1.0 };
    let background = far.iter().enumerate().map(|(k, x)| sign(a.len(), k) * x).collect();
    let orbit = Orbit::Infinite { center, decay: Exact::ONE, band: 1, background };
    let mut found = near(&Certificate { mean: rounded(far[0])?, orbit, a, ..ring.clone() }, sizes)?;
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
    let Orbit::Infinite { decay, band, .. } = &mut found.orbit else { return None };
    *decay = Exact::new((100.0 * RATE * rate) as i64, 100)?;
    *band = (-CUT.ln() / ((1.0 - RATE) * rate)).ceil() as usize;
    (decay.num() > 0).then_some(found)
}

/// A number as one with few digits, so that the decimal is exact.
pub(super) fn rounded(x: f64) -> Option<Exact> {
    Exact::of_double((x * 1e18).round() / 1e18)
}

/// Length of the first piece of a strip without a multiplier that is tried, as a share of the
/// strip, and of the shortest.
const LENGTHS: [f64; 2] = [1.0 / 16.0, 1.0 / 2048.0];
/// Largest radius of a piece over its radius of uniqueness. Balls of this size that meet lie within
/// the other's ball of uniqueness, if both have the same norm. Where the frequency is unknown they
/// are smaller, since they are to bound it.
const FILLED: [f64; 2] = [1.0 / 3.0, 5.0 / 16.0];

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
        let most = FILLED[usize::from(from.first.is_some())];
        let longer = |filled: f64| 0.9 * (most - most * most) / (filled - filled * filled);
        let (factor, why) = match checked {
            Some((Err(Refused::Stopped), _)) => return Err(Refused::Stopped),
            Some((Ok(proof), piece)) => {
                let filled = proof.radius / proof.uniqueness_radius;
                if filled <= most {
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
        let l = |by: f64| -> Option<f64> {
            let model = Model { omega: rounded(omega + by)?, ..near.model };
            Some(System::new(&Certificate { model, to: None, ..found.clone() }).ok()?.factors[1].mid())
        };
        let slope = (l(DIFFERENCE)? - l(-DIFFERENCE)?) / (2.0 * DIFFERENCE * l(0.0)?);
        let share = (approximate(end[0]) / approximate(middle[0]) - 1.0) / slope;
        let half = ROOM[0] * (before - omega).abs().max((after - omega).abs()) + ROOM[1] * share.abs();
        (from, to) = (rounded(omega - half)?, rounded(omega + half)?);
    }
    let (model, first) = (Model { omega: from, ..near.model }, near.first.map(|_| [start[0], end[0]]));
    Some(Certificate { model, mean: start[1], to: Some([to, end[1]]), first, ..found })
}

fn approximate(x: Exact) -> f64 {
    x.num() as f64 / x.den() as f64
}

/// Approximate coefficients of the force and of its derivative by the overlap, for
/// `X = sum a_k cos k theta`.
fn series(a: &[Interval], alpha: f64, count: usize) -> Moments {
    let [each, squares, most] = SAMPLES;
    let samples = (each * count).max(most.min(squares * count * count)).next_power_of_two();
    let mut samples = vec![(0.0, 0.0); samples];
    let scale = 1.0 / samples.len() as f64;
    samples.iter_mut().zip(a).for_each(|(sample, a)| sample.0 = a.mid());
    fourier(&mut samples);
    for sample in &mut samples {
        let overlap = (-sample.0).max(0.0);
        *sample = (overlap.powf(alpha), alpha * overlap.powf(alpha - 1.0));
    }
    // Even real functions have real transforms.
    fourier(&mut samples);
    let of = |part: fn(&(f64, f64)) -> f64| {
        let term = |(k, sample): (usize, &(f64, f64))| (if k == 0 { 1.0 } else { 2.0 }) * part(sample) * scale;
        samples.iter().take(count + 1).enumerate().map(term).map(Interval::exact).collect()
    };
    let [force, stiffness] = [of(|sample| sample.0), of(|sample| sample.1)];
    Moments { force, stiffness, squares: [Interval::ZERO; 3], pieces: Vec::new() }
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
