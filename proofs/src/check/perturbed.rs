//! Chapter: the linearised equations of a dark breather or of a wave, with one more unknown `g`
//! ("Multipliers" in `README.md`).
//!
//! Unknowns are the coefficients of cosines and of sines. For -1 both have equations of their own.
//! Those of a wave are complex: the index `n` is 0 for real parts and 1 for imaginary ones.

use super::{
    Moments, Refused, System,
    newton::{Block, Derivative, Place, dot, kronecker, product},
    of,
    system::{lattice, poles},
};
use crate::{
    certificate::{Certificate, Multiplier, Orbit},
    interval::{Interval, norm},
    untrusted::choices,
};

/// `K'` over the columns of `1 - A M` that are computed beyond `K`, and over the harmonics of the
/// approximate solution.
const SHARE: usize = 4;

/// Real and imaginary part.
pub(crate) type Complex = [Interval; 2];
/// Coefficients by harmonic, of the cosines and of the sines of each site in turn.
pub(crate) type Field = Vec<Vec<Interval>>;
/// `l_k` and `l_{-k}`, by harmonic.
pub(crate) type Factors = Vec<[Complex; 2]>;

/// The coefficient of a place.
fn own_of(p: &Field, (n, k, sine): Place) -> Interval {
    p[2 * n + usize::from(sine)].get(k).copied().unwrap_or(Interval::ZERO)
}

/// The equations of the perturbations.
pub struct Equations<'a> {
    certificate: &'a Certificate,
    system: &'a System,
    /// `K` and `K'`.
    sizes: [usize; 2],
    /// `sigma`.
    odd: usize,
    /// Which parts there are: cosines (`false`), sines.
    parts: &'static [bool],
    /// The coefficients that are given: that is 1, and of waves its imaginary part is 0.
    pub pinned: Vec<Place>,
}

impl<'a> Equations<'a> {
    /// The equations with these numbers of harmonics, `K` and `K'`.
    pub fn new(certificate: &'a Certificate, system: &'a System, sizes: [usize; 2], multiplier: &Multiplier) -> Self {
        let (odd, parts): (_, &[bool]) = match multiplier {
            Multiplier::Growing(_) | Multiplier::Bloch { .. } => (0, &[false, true]),
            Multiplier::Doubling { sine: false } => (1, &[false]),
            Multiplier::Doubling { sine: true } => (1, &[true]),
        };
        let pinned = choices::pinned(certificate, system, multiplier, sizes[0]);
        Self { certificate, system, sizes, odd, parts, pinned }
    }

    /// The coefficients up to harmonic `last` of a site, or of a real or an imaginary part.
    pub fn places(&self, n: usize, last: usize) -> Vec<Place> {
        let each = (0..=last).flat_map(|k| self.parts.iter().map(move |sine| (n, k, *sine)));
        each.filter(|place| self.has(*place)).collect()
    }

    /// Those of all sites.
    fn all(&self, last: usize) -> Vec<Place> {
        (0..self.system.a.len()).flat_map(|n| self.places(n, last)).collect()
    }

    fn has(&self, (n, k, sine): Place) -> bool {
        n < self.system.a.len() && self.system.has(n, k) && (k + self.odd > 0 || !sine)
    }

    /// `l_k` up to `K' + 1`.
    ///
    /// Beyond, `|s|` is at least `(k - 1) omega`, so that the sum of `|l_k|^2` is at most that of a
    /// periodic orbit beyond `K'`.
    pub fn factors(&self, lambda: Complex) -> Factors {
        let Certificate { model, orbit, multiplier, .. } = self.certificate;
        let (poles, [growth, turn]) = (poles(model), lambda);
        let factor = |k: usize, sign: i128| {
            let frequency = turn + Interval::of_integer(sign) * of(2 * k + self.odd) / of(2) * self.system.omega();
            let square = [growth.square() - frequency.square(), of(2) * growth * frequency];
            let term = |i: usize, &[c, p, r]: &[Interval; 3]| {
                let den = [p + r * square[0], -r * square[1]];
                c / (den[0].square() + den[1].square()) * den[i]
            };
            let lattice = match (orbit, multiplier) {
                (Orbit::Wave { q_over_pi }, Some(Multiplier::Bloch { p_over_pi, .. })) => {
                    lattice(*p_over_pi, *q_over_pi, -sign * k as i128)
                }
                _ => Interval::ONE,
            };
            [0, 1].map(|i| lattice * poles.iter().map(|pole| term(i, pole)).sum())
        };
        (0..=self.system.factors.len()).map(|k| [1, -1].map(|sign| factor(k, sign))).collect()
    }

    /// The places of `D p` in the equation of a place, and their factors: `l` takes `c`, `s` to
    /// `a c - b s`, `b c + a s` with `2 a = l_k + l_{-k}`, `2 b = i (l_k - l_{-k})`. For breathers
    /// these are real; for waves their imaginary parts are between real and imaginary parts.
    pub fn forces(&self, l: &Factors, (n, k, sine): Place) -> Vec<(Place, Interval)> {
        let factor = |m: usize, part: bool| {
            let turn = |[re, im]: Complex| if self.system.is_wave() && m != n { [im, -re] } else { [re, im] };
            let [[re, im], [other_re, other_im]] = l[k].map(turn);
            let twice = match (sine, part) {
                (false, true) => im - other_im,
                (true, false) => other_im - im,
                _ => re + other_re,
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
        let most = l[last + 1..].iter().map(|l| norm(l[0]).max(norm(l[1])));
        of(self.parts.len()).sqrt() * norm(most.chain([self.system.tails()[0]]))
    }

    /// Coefficients at these places, and 0 at others, up to harmonic `last`.
    pub fn field(&self, all: &[Place], values: &[f64], last: usize) -> Field {
        let mut field = vec![vec![Interval::ZERO; last + 1]; 2 * self.system.a.len()];
        for (&(n, k, sine), value) in all.iter().zip(values) {
            field[2 * n + usize::from(sine)][k] = Interval::exact(*value);
        }
        field
    }

    /// Left-hand side less right-hand side of the equation of a place.
    pub fn defect(&self, l: &Factors, (p, g): (&Field, &[Interval]), place: Place) -> Interval {
        let force = |((m, k, part), factor): (Place, Interval)| {
            let d = &self.system.known[m].stiffness;
            let all = p[2 * m + usize::from(part)].iter().enumerate();
            factor * all.map(|(j, p)| product(d, k, j, (self.odd, part)) * *p).sum()
        };
        let g = self.pinned.iter().zip(g).filter(|(pinned, _)| place == **pinned).map(|(_, g)| *g);
        own_of(p, place) + self.forces(l, place).into_iter().map(force).sum() - g.sum()
    }

    /// Defects of these places, and those of the coefficients that are given.
    pub fn head(&self, l: &Factors, (p, g): (&Field, &[Interval]), all: &[Place]) -> Vec<Interval> {
        let given = self.pinned.iter().zip(0..).map(|(own, which)| own_of(p, *own) - kronecker(which == 0));
        all.iter().map(|place| self.defect(l, (p, g), *place)).chain(given).collect()
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
    /// Bounds of the change of `D` in the ball.
    pub changed: Vec<Interval>,
}

impl<'a> Terms<'a> {
    /// Those of some growth rates, where strains differ by at most these changes.
    pub fn new(it: Equations<'a>, rates: Complex, changes: &[Interval]) -> Self {
        let (l, all, alpha) = (it.factors(rates), it.all(it.sizes[0]), it.certificate.model.alpha);
        // g has the column -phi, and the row of the coefficient that is given.
        let given = |place: &Place, i: usize| {
            let all = it.pinned.iter().zip(i..).filter(move |(pinned, _)| *pinned == place);
            all.map(|(_, i)| (i, Interval::ONE)).collect::<Vec<_>>()
        };
        let column = |(i, place): (usize, &Place)| [vec![(i, Interval::ONE)], given(place, all.len())].concat();
        let own = |pinned: &Place| all.iter().position(|place| place == pinned).map(|i| (i, -Interval::ONE));
        let further = it.pinned.iter().map(|pinned| own(pinned).into_iter().collect());
        let plain = all.iter().enumerate().map(column).chain(further).collect();
        let mut block = Block { all, sites: it.system.a.len(), odd: it.odd, plain, ..Block::default() };
        let b = block.rows(|place| it.forces(&l, place));
        block.inverse = choices::inverse(&choices::matrix(&block, &b, &it.system.known));
        [block.product, block.reach] = block.times(&b);
        let changed = it.system.known.iter().zip(changes.iter().cycle());
        let changed = changed.map(|(one, by)| one.change(alpha, *by)).collect();
        Self { it, l, block, changed }
    }

    /// The derivative of `T`: `1 - A M`.
    pub fn derivative(&self, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Derivative, Refused> {
        let Self { it: it @ Equations { system, sizes: [last, enclosed], .. }, block, changed, l } = self;
        let (t, alpha, computed) = (it.beyond(l, *last), it.certificate.model.alpha, enclosed / SHARE);
        let far = |n: usize| system.moduli(n).into_iter().map(|e| t * e).collect();
        let far: Vec<Vec<Interval>> = (0..=block.sites).map(far).collect();
        let steepest: Vec<Interval> = system.known.iter().map(|one| one.steepest(alpha)).collect();
        let mut derivative = Derivative::new(block, &far, &steepest, &block.further_columns(), |m| {
            let (places, known) = (it.places(m, computed + last), &system.known[m]);
            go_on().map(|()| block.columns(m, places, &known.stiffness, known.stiffness_tail(computed)))
        })?;
        derivative.weights = vec![Interval::ONE; block.sites];
        derivative.weights.push(choices::lightest(&derivative.within(changed)));
        Ok(derivative)
    }

    /// `g` at a growth rate: near that of an approximate solution `(p, g)`, by the row of `g`.
    pub fn g(&self, rate: Complex, derivative: &Derivative) -> Vec<Interval> {
        let Self { it: it @ Equations { system, sizes: [last, enclosed], .. }, block, changed, .. } = self;
        let (l, harmonics) = (it.factors(rate), enclosed / SHARE);
        let (all, computed) = (it.all(harmonics), enclosed - harmonics - 1);
        let [p, g] = choices::perturbation(it, block, &l, (&all, harmonics));
        let (p, g) = (it.field(&all, &p, harmonics), g.into_iter().map(Interval::exact).collect::<Vec<_>>());
        let sizes: Vec<Interval> = p.chunks(2).map(|p| p.iter().flatten().map(|p| p.abs()).sum()).collect();
        let tail = |(size, known): (&Interval, &Moments)| *size * known.stiffness_tail(computed - harmonics);
        let tails: Vec<Interval> = sizes.iter().zip(&system.known).map(tail).collect();
        let moved: Vec<Interval> = sizes.iter().zip(changed).map(|(size, change)| *size * *change).collect();
        let t = it.beyond(&self.l, computed);
        let y0 = block.image(&it.head(&l, (&p, &g), &block.all), |n| {
            let beyond = it.places(n, computed).into_iter().filter(|place| place.1 > *last);
            let beyond: Interval = beyond.map(|place| it.defect(&l, (&p, &g), place).abs()).sum();
            beyond + t * dot(&system.moduli(n), &tails) + dot(&derivative.contacts[n], &moved)
        });
        let rows = derivative.within(changed);
        let radius = derivative.norm(&y0) / (Interval::ONE - derivative.norm(&rows));
        g.into_iter().map(|g| g + (y0[block.sites] + rows[block.sites] * radius).ball()).collect()
    }
}
