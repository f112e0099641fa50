//! The equations of a wave and of a breather, as one kind of system ("Equations" in `README.md`):
//!
//! `a_nk - l_k sum_m e_nm n_mk = 0` for `k >= 1`, equal mean forces, `sum share_n a_n0 = mean`.
//!
//! A breather of the infinite chain has the sites of one half of it, all mean forces are that of
//! the background, and its coefficients are those of `x_n(t + n T/2)`, so that the background is
//! the same at all sites. The system has the first sites only, in place of the others an end that
//! no constant of the proof depends on.

use super::{
    Moments, Refused, infinite,
    newton::{self, Block, Equations, Place, weight},
    of,
    zero::Descent,
};
use crate::{
    certificate::{Center, Certificate, Model, Orbit},
    exact::Exact,
    interval::Interval,
};
use std::rc::Rc;

/// The equations, and the cosine sum.
#[derive(Clone)]
pub struct System {
    /// `a_nk`, with the mean of a wave as `a_00`.
    pub a: Vec<Vec<Interval>>,
    /// Moments of the force of each site; none at first.
    pub known: Vec<Moments>,
    /// `l_k` for `k` up to `K'`; -1 as `l_0`, but of a wave 0. Of a piece of a branch at its
    /// middle.
    pub factors: Vec<Interval>,
    /// `l'_k`: along a piece the factor is `l_k`, and a number from -1 to 1 times one of these.
    pub slopes: Vec<Interval>,
    /// All values of `l_k`.
    pub ranges: Vec<Interval>,
    /// The parts of the ring that have the strain of a site; none of the infinite chain.
    pub shares: Vec<Interval>,
    /// The mean strain in the middle of a piece, and half of its change.
    pub mean: [Interval; 2],
    /// The same of the frequency.
    pub middle: [Interval; 2],
    /// `c` with `|l_k| <= c/k^2` beyond `K'`; the same for `slopes`.
    pub decay: [Interval; 2],
    /// As `mean`, of an `a_1` that is given. The frequency over half of its change, from the middle
    /// of the piece on, is then one more unknown.
    pub first: Option<[Interval; 2]>,
    /// Of the infinite chain the first site that has the strains of the background.
    pub background: Option<usize>,
    /// The reflection of a breather; of a wave one that leaves its strains alone.
    pub center: Center,
    /// 1 for what has the symmetry of a breather; -1 for perturbations that the reflection maps to
    /// their negative.
    pub parity: f64,
}

impl System {
    /// The equations of a certificate.
    pub fn new(certificate: &Certificate) -> Result<Self, Refused> {
        let Certificate { model, mean, to, first, enclosed, orbit, .. } = certificate;
        let between = |[from, to]: [Exact; 2]| {
            let [start, end] = [from, to].map(|end| end.enclosed() / of(2));
            if from == to { [from.enclosed(), Interval::ZERO] } else { [start + end, end - start] }
        };
        let descent = certificate.is_to_zero().then(|| Descent::new(model)).transpose()?;
        let end = to.filter(|_| descent.is_none()).unwrap_or([model.omega, *mean]);
        let ([omega, half], mean) = (between([model.omega, end[0]]), between([*mean, end[1]]));
        // A piece may go down in frequency.
        let middle = descent.as_ref().map_or([omega, half.abs()], |it| it.middle);
        let (poles, all) = (poles(model), (middle[0] + middle[1].ball()).square());
        // The derivative by the parameter is a/L_k and b times that of 1/L_k by omega^2.
        let [a, b] =
            descent.as_ref().map_or([Interval::ZERO, of(2) * (omega + half.abs().ball()) * half], |it| it.rates);
        let of_all = |k: usize| inverse(&poles, all, k);
        let law = |k: usize| match (k, &descent) {
            (0, _) => [-Interval::ONE, Interval::ZERO],
            (1, Some(_)) => [inverse(&poles, omega.square(), 1)[0], Interval::ZERO],
            (_, None) => [inverse(&poles, omega.square(), k)[0], b * of_all(k)[1]],
            (_, Some(_)) => [of_all(k)[0] / of(2), a * of_all(k)[0] + b * of_all(k)[1]],
        };
        let inverses: Vec<[Interval; 2]> = (0..=*enclosed).map(law).collect();
        let resonant = inverses.iter().position(|it| it.iter().any(|it| it.is_nan()));
        let passed = poles.iter().all(|[_, p, r]| (*r * all * of(enclosed + 1).square() - *p).is_positive());
        if let Some(k) = resonant.or((!passed).then_some(enclosed + 1)) {
            return Err(Refused::Resonance(k));
        }
        // k^2 times a term falls with k from there on, and so does k^2 times its derivative.
        let [value, slope] = of_all(enclosed + 1).map(|it| it.abs() * of(enclosed + 1).square());
        let last = [value, a * value + b.abs() * slope];
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
            Orbit::Infinite { center, band, background, .. } => {
                let (first, mut far) = (a.len(), row(background));
                for (n, row) in a.iter_mut().enumerate() {
                    row.iter_mut().enumerate().filter(|(k, _)| center.turns(n, *k)).for_each(|(_, a)| *a = -*a);
                }
                far[0] = mean[0];
                a.resize(infinite::sites(first, *band), far);
                (1, Vec::new(), *center, Some(first))
            }
        };
        let each = inverses.iter().zip(&lattices).map(|([l, by], lattice)| [*l * *lattice, *by * *lattice]);
        let (factors, slopes): (Vec<_>, Vec<_>) = each.map(<(Interval, Interval)>::from).unzip();
        let ranges = factors.iter().zip(&slopes).map(|(l, by)| *l + by.abs().ball()).collect();
        let decay = last.map(|c| of(most) * c);
        let (first, parity, known) = (first.map(between), 1.0, Vec::new());
        Ok(Self { a, known, factors, slopes, ranges, shares, mean, middle, decay, first, background, center, parity })
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

    /// What the reflection multiplies harmonic `k` by: 1 or -1.
    fn image(&self, k: usize) -> f64 {
        if self.center == Center::Site && k % 2 == 1 { -self.parity } else { self.parity }
    }

    /// A bound of `(sum_{k > K'} l_k^2)^{1/2}`, at most `c/(3 K'^3)^{1/2}`; that for `slopes`.
    pub fn tails(&self) -> [Interval; 2] {
        let enclosed = of(self.factors.len() - 1);
        self.decay.map(|c| (c.square() / (of(3) * enclosed * enclosed * enclosed)).sqrt())
    }

    /// `e_nm` for harmonic `k >= 1`, by `m`; the sum of their moduli is the same for all.
    ///
    /// Left of the first site is its image, or that of the next one (site-centred). Right of the
    /// last site is that of the site before it, or its image (site-centred). Of the infinite chain
    /// neighbours are shifted by half a period.
    pub fn differences(&self, n: usize, k: usize) -> Vec<(usize, usize, f64)> {
        if self.is_wave() {
            return vec![(n, 0, 1.0)];
        }
        let last = self.a.len() - 1;
        let outside = |site, bond| (if self.center == Center::Site { site } else { bond }, 0, -self.image(k));
        let inside = if self.background.is_some() && k % 2 == 1 { 1.0 } else { -1.0 };
        let left = if n > 0 { (n - 1, 0, inside) } else { outside(1, 0) };
        let right = if n < last { (n + 1, 0, inside) } else { outside(last, last - 1) };
        vec![(n, 0, 2.0), left, right]
    }

    /// What `coupled` is for the defect of the cosine sum: mean forces, and forces in the equations
    /// of the background, less those of the background, whose equations hold.
    fn defects(&self, (n, k): Place) -> Vec<(usize, f64)> {
        let all = self.coupled((n, k)).into_iter().map(|(m, _, e)| (m, e));
        match self.background {
            Some(first) if k == 0 || n >= first => {
                all.filter(|(m, _)| *m < first).flat_map(|(m, e)| [(m, e), (first, -e)]).collect()
            }
            _ => all.collect(),
        }
    }

    /// `sum |e_nm| tail_m` by row, as in the defect.
    pub fn rest(&self, tails: &[Interval]) -> Vec<Interval> {
        let of_site = |n| self.defects((n, 2)).into_iter().map(|(m, e)| Interval::exact(e.abs()) * tails[m]).sum();
        (0..self.a.len()).map(of_site).chain([Interval::ZERO]).collect()
    }

    /// The unknowns up to harmonic `last` of the first sites, with `P`. An unknown frequency is one
    /// more, with the column `-l'_k n_k`; the equation of `a_1` has its number.
    pub fn block(self: &Rc<Self>, sites: usize, last: usize) -> Block {
        let mut block = Block::new(self.clone(), sites, last);
        let (all, further) = (&block.all, block.all.len());
        let level = block.index((self.a.len() - 1, 0)).unwrap_or(0);
        let plain = |(i, &(n, k)): (usize, &Place)| match k {
            0 => self.shares.get(n).map(|share| (level, *share / weight(0))).into_iter().collect(),
            1 if self.first.is_some() => vec![(i, Interval::ONE), (further, Interval::ONE)],
            _ => vec![(i, Interval::ONE)],
        };
        let turn = |(i, place): (usize, &Place)| (i, -self.turn(*place));
        let column = self.first.map(|_| all.iter().enumerate().skip(1).map(turn).collect());
        block.plain = all.iter().enumerate().map(plain).chain(column).collect();
        block
    }

    /// `sum_m e_nm n_mk`, as in the defect.
    fn force(&self, (n, k): Place) -> Interval {
        let force = |(m, e): (usize, f64)| Interval::exact(e) * self.known[m].force[k];
        weight(k) * self.defects((n, k)).into_iter().map(force).sum()
    }

    /// The change of `l_k sum_m e_nm n_mk` along one half of a piece.
    pub fn turn(&self, place: Place) -> Interval {
        self.slopes[place.1] * self.force(place)
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
        own.unwrap_or(Interval::ZERO) - l * self.force((n, k))
    }
}

impl Equations for System {
    fn functions(&self) -> usize {
        self.a.len()
    }

    fn has(&self, (n, k): Place) -> bool {
        n != if self.center == Center::Site { 0 } else { self.a.len() - 1 } || self.image(k) > 0.0
    }

    fn entry(&self, m: usize, k: usize, j: usize) -> Interval {
        newton::entry(&self.known[m].stiffness, [k, j], (0, false))
    }

    /// For `k = 0` the equations of the mean forces: that of a site is that of the next one, or
    /// that of the background, which is known.
    fn coupled(&self, (n, k): Place) -> Vec<(usize, usize, f64)> {
        match k {
            0 if self.background.is_some() => vec![(n, 0, 1.0)],
            0 if self.closes(n) => Vec::new(),
            0 => vec![(n, 0, 1.0), (n + 1, 0, -1.0)],
            _ => self.differences(n, k),
        }
    }
}

/// `k q/2` by `q/pi` of few digits, reduced exactly to an angle from 0 to `pi`.
pub(super) fn half_angle(q: Exact, k: i128) -> Interval {
    let [num, den] = [q.num(), q.den()].map(i128::from);
    Interval::exact((k * num).rem_euclid(2 * den) as f64) / Interval::exact((2 * den) as f64) * Interval::PI
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
