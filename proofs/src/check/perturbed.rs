//! Chapter: the linearised equations of a dark breather or of a wave, with one more unknown `g`
//! ("Multipliers" in `README.md`).
//!
//! Unknowns are the coefficients of cosines and of sines. For -1 both have equations of their own.
//! Those of a wave are complex: the index `n` is 0 for real parts and 1 for imaginary ones.

use super::{
    Moments, Refused, System,
    newton::{Block, Derivative, Place, dot, kronecker, product},
    of,
    system::poles,
};
use crate::{
    certificate::{Certificate, Multiplier},
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

/// `0`.
pub(super) const ZERO: Complex = [Interval::ZERO; 2];

/// A multiple.
pub(super) fn scaled(by: Interval, of: Complex) -> Complex {
    of.map(|it| by * it)
}

/// Their sum.
pub(super) fn plus([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a + c, b + d]
}

/// Their product.
pub(super) fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

/// `1/z`.
pub(super) fn inverse([a, b]: Complex) -> Complex {
    let size = a.square() + b.square();
    [a / size, -b / size]
}

/// The coefficient of a place.
pub(crate) fn own_of(p: &Field, (n, k, sine): Place) -> Interval {
    p[2 * n + usize::from(sine)].get(k).copied().unwrap_or(Interval::ZERO)
}

/// The equations of the perturbations.
#[derive(Clone)]
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
    /// and those of this multiplier of a breather, or of a wave.
    pub fn new(
        certificate: &'a Certificate,
        system: &'a System,
        sizes: [usize; 2],
        multiplier: Option<&Multiplier>,
    ) -> Self {
        let (odd, parts): (_, &[bool]) = match multiplier {
            Some(Multiplier::Growing(_)) | None => (0, &[false, true]),
            Some(Multiplier::Doubling { sine: false }) => (1, &[false]),
            Some(Multiplier::Doubling { sine: true }) => (1, &[true]),
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
    pub(crate) fn all(&self, last: usize) -> Vec<Place> {
        (0..self.system.a.len()).flat_map(|n| self.places(n, last)).collect()
    }

    fn has(&self, (n, k, sine): Place) -> bool {
        n < self.system.a.len() && self.system.has(n, k) && (k + self.odd > 0 || !sine)
    }

    /// `l_k` of a breather up to `K'`, for these growth rates.
    pub fn factors(&self, growth: Interval) -> Factors {
        let poles = poles(&self.certificate.model);
        let factor = |k: usize, sign: f64| {
            let frequency = Interval::exact(0.5 * sign) * of(2 * k + self.odd) * self.system.omega();
            let term = |&[c, p, r]: &[Interval; 3]| {
                let square = scaled(r, times([growth, frequency], [growth, frequency]));
                scaled(c, inverse(plus(square, [p, Interval::ZERO])))
            };
            poles.iter().map(term).fold(ZERO, plus)
        };
        (0..self.system.factors.len()).map(|k| [1.0, -1.0].map(|sign| factor(k, sign))).collect()
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

    /// `v` times the root of the sum of `|l_k|^2`, or of `|l_{-k}|^2`, beyond a harmonic, with that
    /// of the harmonics that are not computed.
    pub fn beyond(&self, l: &Factors, last: usize, tail: Interval) -> Interval {
        let most = l[last + 1..].iter().map(|l| norm(l[0]).max(norm(l[1])));
        of(self.parts.len()).sqrt() * norm(most.chain([tail]))
    }

    /// Coefficients at these places, and 0 at others, up to harmonic `last`.
    pub fn field(&self, all: &[Place], values: &[f64], last: usize) -> Field {
        let mut field = vec![vec![Interval::ZERO; last + 1]; 2 * self.system.a.len()];
        for (&(n, k, sine), value) in all.iter().zip(values) {
            field[2 * n + usize::from(sine)][k] = Interval::exact(*value);
        }
        field
    }

    /// `l D p` at a place.
    pub fn force(&self, l: &Factors, p: &Field, place: Place) -> Interval {
        let force = |((m, k, part), factor): (Place, Interval)| {
            let d = &self.system.known[m].stiffness;
            let all = p[2 * m + usize::from(part)].iter().enumerate();
            factor * all.map(|(j, p)| product(d, k, j, (self.odd, part)) * *p).sum()
        };
        self.forces(l, place).into_iter().map(force).sum()
    }

    /// Left-hand side less right-hand side of the equation of a place.
    pub fn defect(&self, l: &Factors, (p, g): (&Field, &[Interval]), place: Place) -> Interval {
        let g = self.pinned.iter().zip(g).filter(|(pinned, _)| place == **pinned).map(|(_, g)| *g);
        own_of(p, place) + self.force(l, p, place) - g.sum()
    }

    /// `K`.
    pub fn last(&self) -> usize {
        self.sizes[0]
    }

    /// How many harmonics an approximate solution has, and of how many equations its defects are
    /// computed.
    pub fn counts(&self) -> [usize; 2] {
        let harmonics = self.sizes[1] / SHARE;
        [harmonics, self.sizes[1] - harmonics - 1]
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
    /// `sqrt 2 |D h|_{L2}` is at most this for `|h| <= 1`.
    pub steepest: Vec<Interval>,
}

impl<'a> Terms<'a> {
    /// Those of these factors, and of these columns of further unknowns in the rows of the block,
    /// where strains differ by at most these changes. Without columns the unknown is `g`.
    pub fn new(it: Equations<'a>, l: Factors, columns: Option<Vec<Vec<Interval>>>, changes: &[Interval]) -> Self {
        let (all, alpha) = (it.all(it.sizes[0]), it.certificate.model.alpha);
        // The rows of the coefficients that are given.
        let given = |place: &Place| {
            let own = it.pinned.iter().zip(all.len()..).filter(move |(pinned, _)| *pinned == place);
            own.map(|(_, i)| (i, Interval::ONE)).collect::<Vec<_>>()
        };
        let column = |(i, place): (usize, &Place)| [vec![(i, Interval::ONE)], given(place)].concat();
        let minus = |pinned: &Place| all.iter().map(|place| -kronecker(place == pinned)).collect();
        let further = columns.unwrap_or_else(|| it.pinned.iter().map(minus).collect());
        let further = further.into_iter().map(|column| column.into_iter().enumerate().collect());
        let plain = all.iter().enumerate().map(column).chain(further).collect();
        let mut block = Block { all, sites: it.system.a.len(), odd: it.odd, plain, ..Block::default() };
        let b = block.rows(|place| it.forces(&l, place));
        block.inverse = choices::inverse(&choices::matrix(&block, &b, &it.system.known));
        [block.product, block.reach] = block.times(&b);
        let changed = it.system.known.iter().zip(changes.iter().cycle());
        let changed = changed.map(|(one, by)| one.change(alpha, *by)).collect();
        let steepest = it.system.known.iter().map(|one| one.steepest(alpha)).collect();
        Self { it, l, block, changed, steepest }
    }

    /// `v t |e|` by row.
    pub fn far(&self, t: Interval) -> Vec<Vec<Interval>> {
        (0..=self.block.sites).map(|n| self.it.system.moduli(n).into_iter().map(|e| t * e).collect()).collect()
    }

    /// The derivative of `T`, `1 - A M`, with these columns of the further unknowns, without their
    /// weight.
    pub fn derivative(
        &self,
        further: &[Interval],
        go_on: &dyn Fn() -> Result<(), Refused>,
    ) -> Result<Derivative, Refused> {
        let Self { it: it @ Equations { system, sizes: [last, enclosed], .. }, block, l, .. } = self;
        let (far, computed) = (self.far(it.beyond(l, *last, system.tails()[0])), enclosed / SHARE);
        let derivative = Derivative::new(block, &far, &self.steepest, further, |m| {
            let (places, known) = (it.places(m, computed + last), &system.known[m]);
            go_on().map(|()| block.columns(m, places, &known.stiffness, known.stiffness_tail(computed)))
        })?;
        Ok(Derivative { weights: vec![Interval::ONE; block.sites], ..derivative })
    }

    /// The norm in a row of what is linear in an approximate solution of these sizes, but for the
    /// rows of the block: with values at other places, `v t` beyond them, and what one unit of
    /// `sqrt 2 |g|_{L2}` at each site does.
    pub fn beyond(
        &self,
        n: usize,
        value: &dyn Fn(Place) -> Interval,
        (sizes, contacts): (&[Interval], &[Vec<Interval>]),
        t: Interval,
    ) -> Interval {
        let Self { it: it @ Equations { system, .. }, changed, .. } = self;
        let [harmonics, computed] = it.counts();
        let tail = |(size, known): (&Interval, &Moments)| *size * known.stiffness_tail(computed - harmonics);
        let tails: Vec<Interval> = sizes.iter().zip(&system.known).map(tail).collect();
        let moved: Vec<Interval> = sizes.iter().zip(changed).map(|(size, change)| *size * *change).collect();
        let own = it.places(n, computed).into_iter().filter(|place| place.1 > it.last());
        own.map(|place| value(place).abs()).sum::<Interval>()
            + t * dot(&system.moduli(n), &tails)
            + dot(&contacts[n], &moved)
    }

    /// `g` at a growth rate of a breather: near that of an approximate solution `(p, g)`, by the
    /// row of `g`.
    pub fn g(&self, rate: Interval, derivative: &Derivative) -> Vec<Interval> {
        let Self { it, block, .. } = self;
        let (l, [_, computed]) = (it.factors(rate), it.counts());
        let (p, g) = choices::perturbation(self, &l, None);
        let (sizes, t) = (sizes_of(&p), it.beyond(&self.l, computed, it.system.tails()[0]));
        let value = |place| it.defect(&l, (&p, &g), place);
        let y0 = block
            .image(&it.head(&l, (&p, &g), &block.all), |n| self.beyond(n, &value, (&sizes, &derivative.contacts), t));
        let rows = derivative.within(&self.changed);
        let radius = derivative.norm(&y0) / (Interval::ONE - derivative.norm(&rows));
        g.into_iter().map(|g| g + (y0[block.sites] + rows[block.sites] * radius).ball()).collect()
    }
}

/// The sums of the moduli of all coefficients of each site.
pub(super) fn sizes_of(p: &Field) -> Vec<Interval> {
    p.chunks(2).map(|both| both.iter().flatten().map(|p| p.abs()).sum()).collect()
}
