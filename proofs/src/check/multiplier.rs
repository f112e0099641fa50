//! Floquet multipliers: a real one of a dark breather, above 1 or -1, and one of a wave, outside
//! the unit circle.
//!
//! Perturbations `e^{lambda t} p_n(t)` of its strains that the reflection maps to their negative,
//! `p_n = sum_k c_nk cos (k + sigma/2) omega t + s_nk sin (k + sigma/2) omega t`, obey with `g = 0`
//!
//! `z_nk + l_k sum_m e_nm (D_m p_m)_k = g phi_nk`, `z = c - i s`,
//! `l_k = 1/L(lambda + i (k + sigma/2) omega)`.
//!
//! `sigma` is 0 for a multiplier `e^{lambda T}`. For -1 it is 1, `lambda` is 0, and sines and
//! cosines have equations of their own. Here `g` is an unknown, one coefficient of `p` is 1, and
//! `phi` is 1 in the equation of this coefficient and 0 in all others. If `|1 - A M| < 1` for the
//! matrix `M` of these linear equations and some `A`, they have one solution, and `g` is a
//! continuous function of all parameters.
//!
//! A wave has perturbations `e^{i p n + lambda t} w(phi)`, `phi = omega t - q n`, with the same
//! series and complex coefficients. Here the index `n` of the unknowns is 0 for real parts and 1
//! for imaginary ones, and `g` has both. Harmonics `e^{i k phi}`, `k` of both signs, have
//! `l_k = 4 sin^2((p - k q)/2)/L(lambda + i k omega)`, which for breathers are conjugates.

use super::{
    Moments, Refused, System,
    block::{Block, Place, dot, kronecker, largest, product},
    of,
    system::{lattice, poles},
};
use crate::{
    certificate::{Certificate, Multiplier, Orbit, WIDER},
    exact::Exact,
    interval::{Complex, Interval, norm},
};
use std::ops::Add;

/// `K` of this proof, at most that of the certificate: this, or a share of `K'`.
const BLOCK: [usize; 2] = [8, 32];
/// `K` and `K'` of this proof for a wave, at most an eighth of that of the certificate, and that.
const OF_WAVE: [usize; 2] = [32, 512];
/// `K'` over the number of columns of `1 - A M` that are computed beyond `K`, and over that of the
/// harmonics of the approximate solution.
const SHARE: usize = 4;
/// Corrections of the approximate solution.
const CORRECTIONS: usize = 3;

/// Coefficients by harmonic, of the cosines and of the sines of each site in turn.
type Field = Vec<Vec<Interval>>;
/// `l_k` and `l_{-k}`, by harmonic.
pub type Factors = Vec<[Complex; 2]>;

fn entry(field: &Field, (n, k, sine): Place) -> Interval {
    field[2 * n + usize::from(sine)][k]
}

/// The equations of the perturbations.
pub struct Equations<'a> {
    certificate: &'a Certificate,
    system: &'a System,
    known: &'a [Moments],
    /// `K` and `K'`.
    block: usize,
    enclosed: usize,
    /// `sigma`.
    odd: usize,
    /// Which parts there are: cosines (`false`), sines.
    parts: &'static [bool],
    /// The coefficients that are given: that is 1, and of waves its imaginary part is 0.
    pub pinned: Vec<Place>,
}

impl<'a> Equations<'a> {
    /// The equations with these numbers of harmonics, `K` and `K'`.
    pub fn new(
        certificate: &'a Certificate,
        (system, known): (&'a System, &'a [Moments]),
        [block, enclosed]: [usize; 2],
        multiplier: &Multiplier,
    ) -> Self {
        let (odd, parts): (_, &[bool]) = match multiplier {
            Multiplier::Growing(_) | Multiplier::Bloch { .. } => (0, &[false, true]),
            Multiplier::Doubling { sine: false } => (1, &[false]),
            Multiplier::Doubling { sine: true } => (1, &[true]),
        };
        let pinned = match (multiplier, &certificate.orbit) {
            (Multiplier::Growing(_), Orbit::Breather(it)) => {
                // Near the centre the harmonic of the background is least.
                let k = it.background();
                let own = |n: &usize| it.a[*n].get(k).copied().unwrap_or(0.0).abs();
                let sites = (0..it.a.len()).filter(|n| system.has(*n, k));
                sites.min_by(|n, m| own(n).total_cmp(&own(m))).map(|n| (n, k.min(block), false)).into_iter().collect()
            }
            (Multiplier::Doubling { sine }, _) => vec![(0, 0, *sine)],
            _ => [0, 1].map(|n| (n, 1, false)).to_vec(),
        };
        Self { certificate, system, known, block, enclosed, odd, parts, pinned }
    }

    /// The coefficients of a site up to harmonic `last`.
    fn places(&self, n: usize, last: usize) -> Vec<Place> {
        let each = (0..=last).flat_map(|k| self.parts.iter().map(move |sine| (n, k, *sine)));
        each.filter(|place| self.has(*place)).collect()
    }

    fn has(&self, (n, k, sine): Place) -> bool {
        n < self.known.len() && self.system.has(n, k) && (k + self.odd > 0 || !sine)
    }

    /// `l_k` up to `K' + 1`.
    ///
    /// Beyond, `|s|` is at least `(k - 1) omega`, so that the sum of `|l_k|^2` is at most that of a
    /// periodic orbit beyond `K'`.
    pub fn factors(&self, lambda: Complex) -> Factors {
        let Certificate { model, orbit, multiplier, .. } = self.certificate;
        let poles = poles(model);
        let factor = |k: usize, sign: i128| {
            let frequency = lambda.im + Interval::of_integer(sign) * of(2 * k + self.odd) / of(2) * self.system.omega();
            let square = Complex { re: lambda.re.square() - frequency.square(), im: of(2) * lambda.re * frequency };
            let term = |&[c, p, r]: &[Interval; 3]| {
                let den = Complex { re: p + r * square.re, im: r * square.im };
                let scale = c / (den.re.square() + den.im.square());
                Complex { re: den.re * scale, im: -den.im * scale }
            };
            let re = match (orbit, multiplier) {
                (Orbit::Wave(wave), Some(Multiplier::Bloch { p_over_pi, .. })) => {
                    lattice(*p_over_pi, wave.q_over_pi, -sign * k as i128)
                }
                _ => Interval::ONE,
            };
            let zero = Complex { re: Interval::ZERO, im: Interval::ZERO };
            poles.iter().map(term).fold(zero, Complex::add) * Complex { re, im: Interval::ZERO }
        };
        (0..=self.system.factors.len()).map(|k| [1, -1].map(|sign| factor(k, sign))).collect()
    }

    /// The places of `D p` in the equation of a place, and their factors: `l` takes `c`, `s` to
    /// `a c - b s`, `b c + a s` with `2 a = l_k + l_{-k}`, `2 b = i (l_k - l_{-k})`. For breathers
    /// these are real; for waves their imaginary parts are between real and imaginary parts.
    pub fn forces(&self, l: &Factors, (n, k, sine): Place) -> Vec<(Place, Interval)> {
        let factor = |m: usize, part: bool| {
            let turn = |z: Complex| if self.system.is_wave() && m != n { Complex { re: z.im, im: -z.re } } else { z };
            let [l, other] = l[k].map(turn);
            let twice = match (sine, part) {
                (false, true) => l.im - other.im,
                (true, false) => other.im - l.im,
                _ => l.re + other.re,
            };
            twice / of(2)
        };
        let factor = &factor;
        let of_site = |(m, e): (usize, f64)| {
            self.parts.iter().map(move |part| ((m, k, *part), Interval::exact(e) * factor(m, *part)))
        };
        let all = self.system.coupled(n, k).into_iter().flat_map(of_site);
        all.filter(|(place, _)| self.has(*place)).collect()
    }

    /// `v` times the root of the sum of `|l_k|^2`, or of `|l_{-k}|^2`, beyond a harmonic.
    pub fn beyond(&self, l: &Factors, last: usize) -> Interval {
        let most = l[last + 1..].iter().map(|l| l[0].abs().max(l[1].abs()));
        of(self.parts.len()).sqrt() * norm(most.chain([self.system.beyond()]))
    }

    /// Left-hand sides less right-hand sides of the equations up to harmonic `last`.
    fn defect(&self, l: &Factors, (p, g): (&Field, &[Interval]), last: usize) -> Field {
        let force = |(i, row): (usize, &Vec<Interval>), k: usize| {
            let d = &self.known[i / 2].stiffness;
            row.iter().enumerate().map(|(j, p)| product(d, k, j, (self.odd, i % 2 == 1)) * *p).sum()
        };
        let products: Field = p.iter().enumerate().map(|row| (0..=last).map(|k| force(row, k)).collect()).collect();
        let mut defect = p.clone();
        defect.iter_mut().for_each(|row| row.resize(last + 1, Interval::ZERO));
        for place in (0..self.known.len()).flat_map(|n| self.places(n, last)) {
            let forces = self.forces(l, place).into_iter().map(|(place, factor)| factor * entry(&products, place));
            let g = self.pinned.iter().zip(g).filter(|(pinned, _)| place == **pinned).map(|(_, g)| *g);
            let own = &mut defect[2 * place.0 + usize::from(place.2)][place.1];
            *own = *own + forces.sum() - g.sum();
        }
        defect
    }
}

/// What the bounds are made of, for all growth rates of the certificate.
pub struct Terms<'a> {
    /// The equations.
    pub it: Equations<'a>,
    /// Their factors.
    pub l: Factors,
    /// `M` and `A`.
    pub block: Block,
    /// `v t |e|`, by row.
    pub far: Vec<Vec<Interval>>,
    /// `R` with `far`.
    pub contacts: Vec<Vec<Interval>>,
    /// Bounds of the change of `D` in the ball.
    pub changed: Vec<Interval>,
}

impl<'a> Terms<'a> {
    /// Those of some growth rates, where strains differ by at most these changes.
    pub fn new(it: Equations<'a>, rates: Complex, changes: &[Interval]) -> Self {
        let (l, sites) = (it.factors(rates), it.known.len());
        let all: Vec<Place> = (0..sites).flat_map(|n| it.places(n, it.block)).collect();
        let further = |place: &Place| it.pinned.iter().position(|pinned| pinned == place).map(|i| all.len() + i);
        let column = |(i, place): (usize, &Place)| [i].into_iter().chain(further(place)).map(|i| (i, Interval::ONE));
        let own = |pinned: &Place| all.iter().position(|place| place == pinned).map(|i| (i, -Interval::ONE));
        let plain = all.iter().enumerate().map(|one| column(one).collect());
        let plain = plain.chain(it.pinned.iter().map(|pinned| own(pinned).into_iter().collect())).collect();
        let mut block = Block::new(all, sites, it.odd, plain);
        let b = block.rows(|place| it.forces(&l, place));
        block.invert(&b, it.known);
        block.multiply(&b);
        let t = it.beyond(&l, it.block);
        let far: Vec<Vec<Interval>> =
            (0..=sites).map(|n| it.system.moduli(n).into_iter().map(|e| t * e).collect()).collect();
        let contacts = block.contacts(&far);
        let alpha = it.certificate.model.alpha;
        let changed =
            it.known.iter().zip(changes.iter().cycle()).map(|(one, change)| one.change(alpha, *change)).collect();
        Self { it, l, block, far, contacts, changed }
    }

    /// `eta`, the row of `g` in `Z1`, and `1 - Z1`.
    pub fn z1(&self, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<[Interval; 3], Refused> {
        let Self { it, block, changed, .. } = self;
        let (alpha, sites) = (it.certificate.model.alpha, it.known.len());
        let steepest: Vec<Interval> = it.known.iter().map(|one| one.steepest(alpha)).collect();
        let computed = it.enclosed / SHARE;
        let near = block.z1(&self.far, &steepest, |m| {
            let (places, known) = (it.places(m, computed + it.block), &it.known[m]);
            go_on().map(|()| block.columns(m, places, &known.stiffness, known.stiffness_tail(computed)))
        })?;
        let z1: Vec<Interval> = near.iter().zip(&self.contacts).map(|(z1, row)| *z1 + dot(row, changed)).collect();
        // The weight eta of g makes its row at most half as large as the largest.
        let (most, own) = (largest(&z1[..sites]), z1[sites]);
        let eta = Interval::exact((0.5 * most.mid() / own.hi()).max(f64::MIN_POSITIVE));
        let z1: Vec<Interval> = z1.iter().zip(block.further_columns()).map(|(z1, of_g)| *z1 + of_g / eta).collect();
        let (most, own) = (largest(&z1[..sites]), z1[sites]);
        Ok([eta, own, Interval::ONE - most.max(eta * own)])
    }

    /// `g` at a growth rate.
    pub fn g(&self, rate: Complex, [eta, own, rest]: [Interval; 3]) -> Vec<Interval> {
        let Self { it, block, .. } = self;
        let (all, inverse) = (&block.all, &block.inverse);
        let (l, sites, harmonics) = (it.factors(rate), it.known.len(), it.enclosed / SHARE);
        let computed = it.enclosed - harmonics - 1;
        let mut p: Field = vec![vec![Interval::ZERO; harmonics + 1]; 2 * sites];
        let mut g = vec![Interval::ZERO; it.pinned.len()];
        let head = |defect: &Field, p: &Field| -> Vec<Interval> {
            let given = it.pinned.iter().zip(0..).map(|(own, which)| entry(p, *own) - kronecker(which == 0));
            all.iter().map(|place| entry(defect, *place)).chain(given).collect()
        };
        for _ in 0..CORRECTIONS {
            let defect = it.defect(&l, (&p, &g), harmonics);
            let head = head(&defect, &p);
            let step = |i: usize| dot(&inverse[i], &head).mid();
            for place in (0..sites).flat_map(|n| it.places(n, harmonics)) {
                let step = block.index(place).map_or_else(|| entry(&defect, place).mid(), step);
                let p = &mut p[2 * place.0 + usize::from(place.2)][place.1];
                *p = Interval::exact(p.mid() - step);
            }
            g.iter_mut().zip(all.len()..).for_each(|(g, i)| *g = Interval::exact(g.mid() - step(i)));
        }
        let defect = it.defect(&l, (&p, &g), computed);
        let head = head(&defect, &p);
        let times = |of: &dyn Fn(usize) -> Interval| -> Vec<Interval> {
            let all = p.chunks(2).map(|p| p.iter().flatten().map(|p| p.abs()).sum::<Interval>());
            all.enumerate().map(|(m, all)| all * of(m)).collect()
        };
        let tails = times(&|m| it.known[m].stiffness_tail(computed - harmonics));
        let (moved, t) = (times(&|m| self.changed[m]), it.beyond(&self.l, computed));
        let mut error = block.by_site(&|i| dot(&inverse[i], &head).abs());
        for (n, error) in error.iter_mut().enumerate() {
            let beyond = it.places(n, computed).into_iter().filter(|place| place.1 > it.block);
            let beyond: Interval = beyond.map(|place| entry(&defect, place).abs()).sum();
            *error = *error + beyond + t * dot(&it.system.moduli(n), &tails) + dot(&self.contacts[n], &moved);
        }
        let (most, own_error) = (largest(&error[..sites]), error[sites]);
        let error = (own_error + own * most.max(eta * own_error) / rest).ball();
        g.into_iter().map(|g| g + error).collect()
    }
}

/// Bounds of `|e^{lambda T}|` of a multiplier that grows, and of `g` for -1, where the strains of
/// the orbit differ by at most `changes` from the cosine sums.
pub fn check(
    certificate: &Certificate,
    multiplier: &Multiplier,
    (known, changes): (&[Moments], &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let (Certificate { block, enclosed, .. }, system) = (certificate, System::new(certificate)?.perturbed());
    // The second site of a wave has the imaginary parts.
    let known: Vec<Moments> = known.iter().cycle().take(system.a.len()).cloned().collect();
    let (rates, im, wide) = match multiplier {
        Multiplier::Growing(rates) => (rates.map(Exact::enclosed), Interval::ZERO, Interval::ZERO),
        Multiplier::Doubling { .. } => ([Interval::ZERO; 2], Interval::ZERO, Interval::ZERO),
        Multiplier::Bloch { rate, radius, .. } => {
            let [re, im, radius] = [rate[0], rate[1], *radius].map(Exact::enclosed);
            ([re - radius, re + radius], im, (of(WIDER) * radius).ball())
        }
    };
    let sizes = match multiplier {
        Multiplier::Bloch { .. } => [OF_WAVE[0].min(enclosed / 8), OF_WAVE[1].min(*enclosed)],
        _ => [(*block).min(BLOCK[0].max(enclosed / BLOCK[1])), *enclosed],
    };
    let equations = Equations::new(certificate, (&system, &known), sizes, multiplier);
    let all = Complex { re: Interval::new(rates[0].lo(), rates[1].hi()) + wide, im: im + wide };
    let terms = Terms::new(equations, all, changes);
    let constants = terms.z1(go_on)?;
    let refused = |g| Err(Refused::Multiplier { z1: (Interval::ONE - constants[2]).hi(), g });
    if !constants[2].is_positive() {
        return refused(None);
    }
    let g = |re: Interval| terms.g(Complex { re, im }, constants);
    let (bounds, vanishes) = match multiplier {
        Multiplier::Growing(_) => {
            let bounds = rates.map(|rate| g(rate)[0]);
            (bounds, (-(bounds[0] * bounds[1])).is_positive())
        }
        Multiplier::Doubling { .. } => ([g(rates[0])[0]; 2], true),
        Multiplier::Bloch { rate, .. } => {
            let [own, beside] = [rate[0].enclosed(), rates[1]].map(g);
            let change = norm(beside.iter().zip(&own).map(|(a, b)| *a - *b));
            // Terms of Taylor's series from the second one on, by Cauchy's bounds.
            let rest = norm(terms.g(all, constants)) / of(WIDER * (WIDER - 1));
            let bounds = [norm(own), change - of(2) * rest];
            (bounds, (bounds[1] - bounds[0]).is_positive())
        }
    };
    let ends = match multiplier {
        Multiplier::Doubling { .. } => bounds,
        _ if vanishes => rates.map(|rate| (rate * of(2) * Interval::PI / system.omega()).exp()),
        _ => [Interval::exact(f64::NAN); 2],
    };
    let [from, to] = [ends[0].lo(), ends[1].hi()];
    if from <= to { Ok([from, to]) } else { refused(Some(bounds.map(|g| [g.lo(), g.hi()]))) }
}
