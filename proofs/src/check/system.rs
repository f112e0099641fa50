//! The equations of a wave and of a breather, as one kind of system: for some sites `n`,
//!
//! `a_nk - l_k sum_m e_nm n_mk = 0` for `k >= 1`,
//!
//! with factors `l_k` of order `1/k^2` and whole numbers `e_nm`. For `k = 0` the mean forces of
//! neighbours are the same, and the last equation is `sum share_n a_n0 = mean`. A wave has one site,
//! `l_k = C_k` and `e = 1`. A breather has the sites of half a ring, of which the reflection makes
//! the other half, `l_k = 1/L_k`, and the second difference as `e`.
//!
//! A breather of the infinite chain has the sites of one half of it, and all mean forces are that of
//! the background. Its coefficients are those of `x_n(t + n T/2)`, `(-1)^{kn} a_nk`, so that the
//! background is the same at all sites. The system has the first sites only, in place of the others
//! an end that no constant of the proof depends on.

use super::{Refused, of};
use crate::{
    certificate::{Breather, Center, Certificate, Model, Orbit},
    exact::Exact,
    interval::Interval,
};

/// The equations, and the cosine sum.
pub(super) struct System {
    /// `a_nk`, with the mean of a wave as `a_00`.
    pub(super) a: Vec<Vec<Interval>>,
    /// Whether it is of a wave.
    pub(super) wave: bool,
    /// `l_k` for `k` up to `K'`; -1 as `l_0`. Of a piece of a branch at its middle.
    pub(super) factors: Vec<Interval>,
    /// Along a piece `l_k` is the factor, and a number from -1 to 1 times one in this interval.
    pub(super) slopes: Vec<Interval>,
    /// The parts of the ring that have the strain of a site; none of the infinite chain.
    pub(super) shares: Vec<Interval>,
    /// The mean strain in the middle of a piece, and half of its change.
    pub(super) mean: [Interval; 2],
    /// The frequency; along a piece all of its values.
    pub(super) omega: Interval,
    /// The frequency in the middle of a piece, and half of its change.
    pub(super) middle: [Interval; 2],
    /// `|b_k/a_k|` for `k` up to `K' + 1`, the coefficients of `y_n` over those of `x_n`; less
    /// beyond.
    pub(super) resonators: Vec<Interval>,
    /// `c` with `|l_k| <= c/k^2` beyond; the same for what `slopes` has.
    pub(super) decay: [Interval; 2],
    /// The same of `a_1` where it is given, and `(omega - omega_m)/half` one more unknown, `omega_m`
    /// in the middle of the piece. So the factors of the piece are `l_k` plus the unknown times one
    /// in `slopes`.
    pub(super) first: Option<[Interval; 2]>,
    /// Of the infinite chain the first site that has the strains of the background.
    pub(super) background: Option<usize>,
    /// The reflection of a breather; of a wave one that leaves its strains alone.
    pub(super) center: Center,
    /// 1 for what has the symmetry of a breather; -1 for perturbations that the reflection maps to
    /// their negative.
    pub(super) parity: f64,
}

impl System {
    pub(super) fn new(certificate: &Certificate) -> Result<Self, Refused> {
        let Certificate { model, mean, to, first, enclosed, orbit, .. } = certificate;
        let between = |from: Exact, to: Exact| {
            let [from, to] = [from, to].map(|end| end.enclosed() / of(2));
            [from + to, to - from]
        };
        let [[omega, half], mean] = match to {
            None => [model.omega, *mean].map(|one| [one.enclosed(), Interval::ZERO]),
            Some(to) => [between(model.omega, to[0]), between(*mean, to[1])],
        };
        let ([mut factors, mut slopes], mut decay) = inverses(model, [omega, half], *enclosed)?;
        let middle = [omega, half.abs()];
        let omega = omega + half.abs().ball();
        let resonators = resonators(model, omega, enclosed + 1);
        let row = |a: &[f64]| a.iter().map(|a| Interval::exact(*a)).collect::<Vec<_>>();
        let (mut background, with_mean) = (None, |a: &[f64]| [&mean[..1], row(a).as_slice()].concat());
        let (a, shares, center) = match orbit {
            Orbit::Wave(wave) => {
                for (k, (l, slope)) in (0..).zip(factors.iter_mut().zip(&mut slopes)) {
                    let lattice = lattice(Exact::ONE.less_one(), wave.q_over_pi, k);
                    (*l, *slope) = (*l * lattice, *slope * lattice);
                }
                decay = decay.map(|c| of(4) * c);
                (vec![with_mean(&wave.a)], vec![Interval::ONE], Center::Bond)
            }
            Orbit::Breather(Breather { sites, center, a }) => {
                let alone = if *center == Center::Site { 0 } else { a.len() - 1 };
                let share = |n: usize| of(if n == alone { 1 } else { 2 }) / of(*sites);
                (a.iter().map(|a| row(a)).collect(), (0..a.len()).map(share).collect(), *center)
            }
            Orbit::Infinite(infinite) => {
                background = Some(infinite.a.len());
                let shifted = |(n, a): (usize, &Vec<f64>)| -> Vec<Interval> {
                    let odd = (n + usize::from(infinite.center == Center::Bond)) % 2 == 1;
                    row(a).into_iter().enumerate().map(|(k, a)| if odd && k % 2 == 1 { -a } else { a }).collect()
                };
                let mut a: Vec<Vec<Interval>> = infinite.a.iter().enumerate().map(shifted).collect();
                a.resize(infinite.section(), with_mean(&infinite.background));
                (a, Vec::new(), infinite.center)
            }
        };
        let (first, parity, wave) = (first.map(|[from, to]| between(from, to)), 1.0, a.len() == 1);
        Ok(Self {
            a,
            wave,
            factors,
            slopes,
            shares,
            mean,
            omega,
            middle,
            resonators,
            decay,
            first,
            background,
            center,
            parity,
        })
    }

    /// That of the perturbations which [`multiplier`](super::multiplier) looks for. Those of a wave
    /// are complex: their real part is one site, their imaginary part a second one.
    pub(super) fn perturbed(mut self) -> Self {
        if self.wave {
            self.a.push(self.a[0].clone())
        } else {
            self.parity = -1.0
        }
        self
    }

    /// The site whose mean force that of a site is: the next one, or the background. `None` for the
    /// last site of a ring, which has the equation of the mean strain.
    pub(super) fn level(&self, n: usize) -> Option<usize> {
        Some(self.background.unwrap_or(n + 1)).filter(|m| *m < self.a.len())
    }

    /// Whether a site has the strains of the background of the infinite chain.
    pub(super) fn is_background(&self, n: usize) -> bool {
        self.background.is_some_and(|first| n >= first)
    }

    /// Whether harmonic `k` of a site is unknown.
    pub(super) fn has(&self, n: usize, k: usize) -> bool {
        let fixed = if self.center == Center::Site { 0 } else { self.a.len() - 1 };
        n != fixed || self.image(k) > 0.0
    }

    /// What the reflection multiplies harmonic `k` by: 1 or -1.
    fn image(&self, k: usize) -> f64 {
        if self.center == Center::Site && k % 2 == 1 { -self.parity } else { self.parity }
    }

    /// All values of `l_k`.
    pub(super) fn range(&self, k: usize) -> Interval {
        self.factors[k] + self.slopes[k].abs().ball()
    }

    /// A bound of `(sum_{k > K'} l_k^2)^{1/2}`.
    pub(super) fn beyond(&self) -> Interval {
        self.tails()[0]
    }

    /// The same; and that for what `slopes` has.
    pub(super) fn tails(&self) -> [Interval; 2] {
        let enclosed = of(self.factors.len() - 1);
        self.decay.map(|c| (c.square() / (of(3) * enclosed * enclosed * enclosed)).sqrt())
    }

    /// `e_nm` for harmonic `k`, by `m`; their moduli are largest in sum for `k = 0`.
    ///
    /// Left of the first site is its image, or that of the next one (site-centred). Right of the
    /// last site is that of the site before it, or its image (site-centred). Of the infinite chain
    /// neighbours are shifted by half a period.
    pub(super) fn coupled(&self, n: usize, k: usize) -> Vec<(usize, f64)> {
        if self.wave {
            return (0..self.a.len()).map(|m| (m, if m > n { -1.0 } else { 1.0 })).collect();
        }
        let last = self.a.len() - 1;
        let outside = |site, bond| (if self.center == Center::Site { site } else { bond }, self.image(k));
        let inside = if self.background.is_some() && k % 2 == 1 { -1.0 } else { 1.0 };
        let left = if n > 0 { (n - 1, inside) } else { outside(1, 0) };
        let right = if n < last { (n + 1, inside) } else { outside(last, last - 1) };
        vec![(n, 2.0), (left.0, -left.1), (right.0, -right.1)]
    }

    /// `sum |e_nm|` by `m`, of all harmonics that a site has; 0 for the row after all sites.
    pub(super) fn moduli(&self, n: usize) -> Vec<Interval> {
        let mut moduli = vec![Interval::ZERO; self.a.len()];
        if n < self.a.len() && (0..2).any(|k| self.has(n, k)) {
            self.coupled(n, 0).into_iter().for_each(|(m, e)| moduli[m] = moduli[m] + e.abs().into());
        }
        moduli
    }

    /// The same as `coupled` for the defect of the cosine sum. At a site of the background the
    /// forces of its own are taken away: its equation holds with them.
    pub(super) fn defects(&self, n: usize, k: usize) -> Vec<(usize, f64)> {
        let all = self.coupled(n, k);
        if !self.is_background(n) {
            return all;
        }
        let others = all.into_iter().filter(|(m, _)| !self.is_background(*m));
        others.flat_map(|(m, e)| [(m, e), (n, -e)]).collect()
    }
}

/// `kappa/|kappa - rho omega^2 k^2|` for `k` up to `count`, or 0 for resonators that do not move.
/// NaN where it is not known to be finite.
fn resonators(model: &Model, omega: Interval, count: usize) -> Vec<Interval> {
    let (kappa, rho) = (model.kappa.enclosed(), model.rho.map(Exact::enclosed));
    let share = |rho: Interval, k: usize| (kappa / (kappa - rho * (omega * of(k)).square())).abs();
    (0..=count).map(|k| rho.map_or(Interval::ZERO, |rho| share(rho, k))).collect()
}

/// `4 sin^2((p + k q)/2)` by `p/pi` and `q/pi`, with the angle reduced exactly.
pub(super) fn lattice(p: Exact, q: Exact, k: i128) -> Interval {
    let (num, den) = (p.num() * q.den() + k * q.num() * p.den(), p.den() * q.den());
    let share = Interval::of_integer(num.rem_euclid(2 * den)) / Interval::of_integer(2 * den);
    of(4) * (share * Interval::PI).sin_cos()[0].square()
}

/// `1/L_k` for `k` up to `count` (-1 for `k = 0`) at `omega`; its derivative by `omega` times
/// `half`, on the piece that is `half` longer on both sides; and for each of both `c` with `c/k^2`
/// as a bound beyond, there.
///
/// As a function of `w = (omega k)^2`, `1/L_k = (-1/w + rho^2/den_k)/(1 + rho)`, which increases.
/// Beyond, `k^2` times its derivative by `omega` falls with `k`, since `w/|den_k|` does.
fn inverses(
    model: &Model,
    [omega, half]: [Interval; 2],
    count: usize,
) -> Result<([Vec<Interval>; 2], [Interval; 2]), Refused> {
    let (kappa, one, all) = (model.kappa.enclosed(), Interval::ONE, omega + half.abs().ball());
    let square = |omega: Interval, k: usize| (omega * of(k)).square();
    // The value, and the derivative by w.
    let inverse = |omega: Interval, k: usize| match (square(omega, k), model.rho) {
        _ if k == 0 => [-Interval::ONE, Interval::ZERO],
        (w, None) => [one / (kappa - w), one / (kappa - w).square()],
        (w, Some(rho)) if rho.num() == 0 => [-one / w, one / w.square()],
        (w, Some(rho)) => {
            let rho = rho.enclosed();
            let den = kappa * (one + rho) - rho * w;
            let slope = one / w.square() + rho * (rho / den).square();
            [-one / w + rho.square() / den, slope].map(|it| it / (one + rho))
        }
    };
    let factors: Vec<Interval> = (0..=count).map(|k| inverse(omega, k)[0]).collect();
    let slope = |k: usize| half * inverse(all, k)[1] * of(2) * all * of(k) * of(k);
    let slopes: Vec<Interval> = (0..=count).map(slope).collect();
    if let Some(k) = factors.iter().zip(&slopes).position(|(one, slope)| one.is_nan() || slope.is_nan()) {
        return Err(Refused::Resonance(k));
    }
    // L_k over -omega^2 k^2 is (1 + added/over)^{-1} for k = count + 1, and nearer to 1 beyond.
    let (added, over) = match model.rho {
        Some(rho) if rho.num() == 0 => (Interval::ZERO, one),
        Some(rho) => {
            let rho = rho.enclosed();
            (kappa * rho, rho * square(all, count + 1) - kappa * (one + rho))
        }
        None => (kappa, square(all, count + 1) - kappa),
    };
    match over {
        over if over.is_positive() => {
            let turn = slope(count + 1).abs() * of(count + 1).square();
            Ok(([factors, slopes], [(one + added / over) / all.square(), turn]))
        }
        over if (-over).is_positive() => Err(Refused::Below(count)),
        _ => Err(Refused::Resonance(count + 1)),
    }
}
