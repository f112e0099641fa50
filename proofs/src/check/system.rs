//! The equations of a wave and of a breather, as one kind of system ("Equations" in `README.md`):
//!
//! `a_nk - l_k sum_m e_nm n_mk = 0` for `k >= 1`, equal mean forces, `sum share_n a_n0 = mean`.

use super::{
    Moments, Refused,
    newton::{Block, Lines, Place, cosines, weight},
    of, zero,
};
use crate::{
    certificate::{Center, Certificate, Model, Orbit},
    exact::Exact,
    interval::Interval,
};

/// The equations, and the cosine sum.
#[derive(Clone)]
pub struct System {
    /// `a_nk`, with the mean of a wave as `a_00`.
    pub a: Vec<Vec<Interval>>,
    /// Moments of the force of each site; none at first.
    pub known: Vec<Moments>,
    /// `l_k` for `k` up to `K'`; -1 as `l_0`. Of a piece of a branch at its middle.
    pub factors: Vec<Interval>,
    /// `l'_k`: along a piece the factor is `l_k`, and a number from -1 to 1 times one of these.
    pub slopes: Vec<Interval>,
    /// The parts of the ring that have the strain of a site; none of the infinite chain.
    pub shares: Vec<Interval>,
    /// The mean strain in the middle of a piece, and half of its change.
    pub mean: [Interval; 2],
    /// The same of the frequency.
    pub middle: [Interval; 2],
    /// `c` with `|l_k| <= c/k^2` beyond `K'`; the same for `slopes`.
    pub decay: [Interval; 2],
    /// As `mean`, of an `a_1` that is given (`fold.rs`).
    pub first: Option<[Interval; 2]>,
    /// The first site that has the strains of the background (`infinite.rs`).
    pub background: Option<usize>,
    /// The reflection of a breather; of a wave one that leaves its strains alone.
    pub center: Center,
    /// 1 for what has the symmetry of a breather; -1 for perturbations that the reflection maps to
    /// their negative (`perturbed.rs`).
    pub parity: f64,
}

/// `1/L_k` along a piece.
pub(super) struct Factors {
    /// The middle of the frequencies, and half of their range.
    pub middle: [Interval; 2],
    /// For each `k` that in the middle, and its change as in `slopes`; -1 and 0 for `k = 0`.
    pub each: Vec<[Interval; 2]>,
    /// `c` for the largest `|e_nm|` 1, as in `decay`.
    pub decay: [Interval; 2],
}

impl System {
    /// The equations of a certificate.
    pub fn new(certificate: &Certificate) -> Result<Self, Refused> {
        let Certificate { model, mean, to, first, enclosed, orbit, .. } = certificate;
        let end = to.filter(|_| !certificate.is_to_zero()).unwrap_or([model.omega, *mean]);
        let mean = between([*mean, end[1]]);
        let Factors { middle, each, decay } = match certificate.is_to_zero() {
            true => zero::factors(model, *enclosed)?,
            false => along(model, end[0], *enclosed)?,
        };
        let row = |a: &Vec<f64>| a.iter().map(|a| Interval::exact(*a)).collect::<Vec<_>>();
        let mut a: Vec<Vec<Interval>> = certificate.a.iter().map(row).collect();
        let mut lattices = vec![Interval::ONE; *enclosed + 1];
        let (most, shares, center, background) = match orbit {
            Orbit::Wave { q_over_pi } => {
                let lattice = |k| of(4) * half_angle(*q_over_pi, k).sin_cos()[0].square();
                lattices = (0..).map(lattice).take(enclosed + 1).collect();
                a[0][0] = mean[0];
                (4, vec![Interval::ONE], Center::Bond, None)
            }
            Orbit::Breather { sites, center } => {
                let alone = if *center == Center::Site { 0 } else { a.len() - 1 };
                let share = |n: usize| of(if n == alone { 1 } else { 2 }) / of(*sites);
                (1, (0..a.len()).map(share).collect(), *center, None)
            }
            Orbit::Infinite { center, background, .. } => {
                let (first, mut far) = (a.len(), row(background));
                far[0] = mean[0];
                center.unfold(&mut a);
                a.resize(certificate.sites(), far);
                (1, Vec::new(), *center, Some(first))
            }
        };
        let [factors, slopes] = [0, 1].map(|i| each.iter().zip(&lattices).map(|(l, by)| l[i] * *by).collect());
        let decay = decay.map(|c| of(most) * c);
        let (first, parity, known) = (first.map(between), 1.0, Vec::new());
        Ok(Self { a, known, factors, slopes, shares, mean, middle, decay, first, background, center, parity })
    }

    /// Whether it is of a wave.
    pub fn is_wave(&self) -> bool {
        self.shares.len() == 1
    }

    /// The frequency; along a piece all of its values.
    pub fn omega(&self) -> Interval {
        self.middle[0] + self.middle[1].ball()
    }

    /// Whether a site is the last one of a ring, which has the equation of the mean strain.
    pub fn closes(&self, n: usize) -> bool {
        self.background.is_none() && n + 1 == self.a.len()
    }

    /// Whether harmonic `k` of a site is unknown.
    pub fn has(&self, n: usize, k: usize) -> bool {
        n != if self.center == Center::Site { 0 } else { self.a.len() - 1 } || self.image(k) > 0.0
    }

    /// What the reflection multiplies harmonic `k` by: 1 or -1.
    fn image(&self, k: usize) -> f64 {
        if self.center == Center::Site && k % 2 == 1 { -self.parity } else { self.parity }
    }

    /// All values of `l_k`.
    pub fn range(&self, k: usize) -> Interval {
        self.factors[k] + self.slopes[k].abs().ball()
    }

    /// A bound of `(sum_{k > K'} l_k^2)^{1/2}`, at most `c/(3 K'^3)^{1/2}`; that for `slopes`.
    pub fn tails(&self) -> [Interval; 2] {
        let enclosed = of(self.factors.len() - 1);
        self.decay.map(|c| (c.square() / (of(3) * enclosed * enclosed * enclosed)).sqrt())
    }

    /// `e_nm` for harmonic `k`, by `m`; the sum of their moduli is the same for all `k >= 1`.
    ///
    /// Left of the first site is its image, or that of the next one (site-centred). Right of the
    /// last site is that of the site before it, or its image (site-centred). Of the infinite chain
    /// neighbours are shifted by half a period.
    pub fn coupled(&self, n: usize, k: usize) -> Vec<(usize, f64)> {
        if self.is_wave() {
            return vec![(n, 1.0)];
        }
        let last = self.a.len() - 1;
        let outside = |site, bond| (if self.center == Center::Site { site } else { bond }, -self.image(k));
        let inside = if self.background.is_some() && k % 2 == 1 { 1.0 } else { -1.0 };
        let left = if n > 0 { (n - 1, inside) } else { outside(1, 0) };
        let right = if n < last { (n + 1, inside) } else { outside(last, last - 1) };
        vec![(n, 2.0), left, right]
    }

    /// `factor sum |e_nm|` by `m`, of all harmonics that a site has; 0 for the row after all sites.
    pub fn moduli(&self, n: usize, factor: Interval) -> Vec<Interval> {
        let mut moduli = vec![Interval::ZERO; self.a.len()];
        if n < self.a.len() && (0..2).any(|k| self.has(n, k)) {
            self.coupled(n, 0).into_iter().for_each(|(m, e)| moduli[m] = moduli[m] + factor * Interval::exact(e.abs()));
        }
        moduli
    }

    /// The same as `coupled` with the equations of the mean forces for `k = 0`: that of a site is
    /// that of the next one, or that of the background, which is known.
    pub(super) fn forces(&self, n: usize, k: usize) -> Vec<(usize, f64)> {
        match k {
            0 if self.background.is_some() => vec![(n, 1.0)],
            0 if self.closes(n) => Vec::new(),
            0 => vec![(n, 1.0), (n + 1, -1.0)],
            _ => self.coupled(n, k),
        }
    }

    /// The unknowns up to harmonic `last` of the first sites, with `P`, and `e`, which is `B` but
    /// for the factors.
    pub fn block(&self, sites: usize, last: usize) -> (Block, Lines) {
        let places = (0..sites).flat_map(|n| (0..=last).map(move |k| (n, k)));
        let all: Vec<Place> = places.filter(|(n, k)| self.has(*n, *k)).collect();
        let level = all.iter().position(|place| *place == (self.a.len() - 1, 0)).unwrap_or(0);
        let plain = |(i, &(n, k)): (usize, &Place)| match k {
            0 => self.shares.get(n).map(|share| (level, *share / weight(0))).into_iter().collect(),
            _ => vec![(i, Interval::ONE)],
        };
        let mut plain = all.iter().enumerate().map(plain).collect();
        self.border(&all, &mut plain);
        let (none, d) = (Vec::new, self.known.iter().map(|one| one.stiffness.clone()).collect::<Vec<_>>());
        let entry = Box::new(move |m: usize, k, j| cosines(&d[m], k, j));
        let block = Block { all, sites, entry, plain, inverse: none(), product: none(), reach: none() };
        let of = |(n, k)| self.forces(n, k).into_iter().map(|(m, e)| ((m, k), Interval::exact(e))).collect();
        let e = block.rows(of);
        (block, e)
    }

    /// `sum_m e_nm n_mk`, as in the defect.
    pub(super) fn force(&self, n: usize, k: usize) -> Interval {
        self.defects(n, k).into_iter().map(|(m, e)| Interval::exact(e) * self.known[m].force[k]).sum()
    }

    /// `G_nk` for these factors.
    pub fn defect(&self, (n, k): Place, l: Interval) -> Interval {
        let own = match k {
            0 if self.closes(n) => {
                Some(self.shares.iter().zip(&self.a).map(|(s, a)| *s * a[0]).sum::<Interval>() - self.mean[0])
            }
            1.. if self.background.is_none_or(|first| n < first) => self.a[n].get(k).copied(),
            _ => None,
        };
        own.unwrap_or(Interval::ZERO) - l * self.force(n, k)
    }

    /// `G` in the rows of a block.
    pub fn residual(&self, block: &Block) -> Vec<Interval> {
        let own = block.all.iter().map(|place| self.defect(*place, self.factors[place.1]));
        own.chain(self.first.map(|first| self.a[0][1] - first[0])).collect()
    }
}

/// The middle between two numbers, and half of the way from one to the other.
fn between([from, to]: [Exact; 2]) -> [Interval; 2] {
    let [start, end] = [from, to].map(|end| end.enclosed() / of(2));
    if from == to { [from.enclosed(), Interval::ZERO] } else { [start + end, end - start] }
}

/// Those of a piece along which the frequency is linear; of a single orbit both ends are one.
fn along(model: &Model, end: Exact, enclosed: usize) -> Result<Factors, Refused> {
    let ([omega, half], poles) = (between([model.omega, end]), poles(model));
    let all = (omega + half.abs().ball()).square();
    // The change of omega^2, at any frequency of the piece.
    let by = of(2) * (omega + half.abs().ball()) * half;
    let law = |k: usize| [inverse(&poles, omega.square(), k)[0], by * inverse(&poles, all, k)[1]];
    let [value, slope] = edge(&poles, all, enclosed)?;
    let each = each(enclosed, law)?;
    Ok(Factors { middle: [omega, half.abs()], each, decay: [value, by.abs() * slope] })
}

/// The factors by this law.
pub(super) fn each(enclosed: usize, law: impl Fn(usize) -> [Interval; 2]) -> Result<Vec<[Interval; 2]>, Refused> {
    let each: Vec<_> = (0..=enclosed).map(|k| if k == 0 { [-Interval::ONE, Interval::ZERO] } else { law(k) }).collect();
    let resonant = each.iter().position(|it| it.iter().any(|it| it.is_nan()));
    resonant.map_or(Ok(each), |k| Err(Refused::Resonance(k)))
}

/// Bounds of `k^2/|L_k|` beyond `K'`, and of `k^2` times its derivative by `omega^2`, for these
/// squares of the frequency: where no `k omega` is the free frequency both fall with `k`.
pub(super) fn edge(poles: &[[Interval; 3]], all: Interval, enclosed: usize) -> Result<[Interval; 2], Refused> {
    let square = of(enclosed + 1).square();
    let passed = poles.iter().all(|[_, p, r]| (*r * all * square - *p).is_positive());
    let edge = inverse(poles, all, enclosed + 1).map(|it| it.abs() * square);
    if passed { Ok(edge) } else { Err(Refused::Resonance(enclosed + 1)) }
}

/// `k q/2` by `q/pi`, reduced exactly to an angle from 0 to `pi`.
pub(super) fn half_angle(q: Exact, k: i128) -> Interval {
    let [num, den] = [q.num(), q.den()].map(i128::from);
    Interval::of_integer((k * num).rem_euclid(2 * den)) / Interval::of_integer(2 * den) * Interval::PI
}

/// `c`, `p` and `r` of the terms of `1/L(s) = sum c/(p + r s^2)`.
pub(super) fn poles(model: &Model) -> Vec<[Interval; 3]> {
    let (kappa, one) = (model.kappa.enclosed(), Interval::ONE);
    let Some(rho) = model.rho else { return vec![[one, kappa, one]] };
    let (all, resonators) = (one + rho.enclosed(), (rho.num() > 0).then_some(rho.enclosed()));
    let resonators = resonators.map(|rho| [rho.square() / all, kappa * all, rho]);
    [[one / all, Interval::ZERO, one]].into_iter().chain(resonators).collect()
}

/// `1/L_k` and its derivative by `omega^2`, for these squares of the frequency.
pub(super) fn inverse(poles: &[[Interval; 3]], square: Interval, k: usize) -> [Interval; 2] {
    let by = |r: Interval| r * of(k).square();
    let term = |i: usize, &[c, p, r]: &[Interval; 3]| {
        let den = p - by(r) * square;
        if i == 0 { c / den } else { c * by(r) / den.square() }
    };
    [0, 1].map(|i| poles.iter().map(|pole| term(i, pole)).sum())
}
