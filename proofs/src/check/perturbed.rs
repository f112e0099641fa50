//! Chapter: the linearised equations of a dark breather or of a wave, and Newton's argument for
//! them with further unknowns ("Multipliers" in `README.md`).
//!
//! Unknowns are the coefficients `z_k` of `e^{i k theta}`, harmonic `k` has the number `MIDDLE + k`.
//! The imaginary parts of the coefficients of a site are those of a further site. Of real
//! perturbations unknowns are `2 z_k`, `k >= 1`, and `sqrt 2 z_0`.

use super::{
    Refused, System,
    newton::{Block, Derivative, Place, dot, kronecker},
    of,
};
use crate::{
    exact::Exact,
    interval::{Interval, norm},
    untrusted::choices,
};

/// `K'` over the columns of `1 - A M` that are computed beyond `K`, and over the harmonics of the
/// approximate solution.
const SHARE: usize = 4;
/// The number of harmonic 0, even.
pub(crate) const MIDDLE: usize = 1 << 16;

/// Real and imaginary part.
pub(crate) type Complex = [Interval; 2];
/// Coefficients of each site by harmonic, as many of both signs.
pub(crate) type Field = Vec<Vec<Interval>>;
/// `l_k` by harmonic, as many of both signs.
pub(crate) type Factors = Vec<Complex>;

/// The entry of a harmonic, if there is one.
pub(crate) fn at<T: Copy>(all: &[T], k: usize) -> Option<T> {
    all.get((k + all.len() / 2).wrapping_sub(MIDDLE)).copied()
}

/// The matrices of `D`.
#[derive(Clone)]
struct Stiffness {
    /// `d_0, d_1/2, d_2/2, ...` of each site, the coefficients of `e^{i l theta}`.
    each: Vec<Vec<Interval>>,
    /// Whether perturbations are real functions.
    real: bool,
}

impl Stiffness {
    fn entry(&self, m: usize, k: usize, j: usize) -> Interval {
        let (d, sines) = (&self.each[m % self.each.len()], m >= self.each.len());
        let near = d[k.abs_diff(j)];
        match (self.real, k == MIDDLE, j == MIDDLE) {
            (true, false, false) if sines => near - d[k + j - 2 * MIDDLE],
            (true, false, false) => near + d[k + j - 2 * MIDDLE],
            (true, false, true) | (true, true, false) => near * of(2).sqrt(),
            _ => near,
        }
    }
}

/// The equations of the perturbations.
#[derive(Clone)]
pub struct Equations<'a> {
    system: &'a System,
    alpha: Exact,
    d: Stiffness,
    /// `K` and `K'`.
    pub sizes: [usize; 2],
    /// Sites with those of the imaginary parts.
    pub sites: usize,
    /// For each further unknown the coefficients of which the sum is given: 1 and, of its imaginary
    /// part, 0.
    pub pinned: Vec<Vec<Place>>,
}

impl System {
    /// That of perturbations: of a breather of those that the reflection maps to their negative.
    pub fn perturbed(&self) -> Self {
        Self { parity: if self.is_wave() { 1.0 } else { -1.0 }, ..self.clone() }
    }
}

impl<'a> Equations<'a> {
    /// The equations with these numbers of harmonics, `K` and `K'`, and for each further unknown
    /// these coefficients; of real functions, or else with coefficients that are real if there is
    /// one such unknown.
    pub fn new(system: &'a System, alpha: Exact, sizes: [usize; 2], (real, pinned): (bool, Vec<Vec<Place>>)) -> Self {
        let half = |(l, d): (usize, &Interval)| if l == 0 { *d } else { *d / of(2) };
        let each = system.known.iter().map(|one| one.stiffness.iter().enumerate().map(half).collect()).collect();
        let sites = if real { 2 } else { pinned.len() } * system.a.len();
        Self { system, alpha, d: Stiffness { each, real }, sizes, sites, pinned }
    }

    /// The first harmonic of a site.
    fn first(&self, n: usize) -> usize {
        if self.d.real { MIDDLE + n / self.system.a.len() } else { 0 }
    }

    fn has(&self, (n, k): Place) -> bool {
        let sites = self.system.a.len();
        self.system.has(n % sites, k) && k >= self.first(n)
    }

    /// What `sqrt 2` times the root of the mean square of a function is at least as a multiple of
    /// the root of the sum of squares of coefficients.
    fn unit(&self) -> Interval {
        if self.d.real { Interval::ONE } else { of(2).sqrt() }
    }

    /// The unknowns up to harmonic `last` of a site.
    pub fn places(&self, n: usize, last: usize) -> Vec<Place> {
        (MIDDLE - last..=MIDDLE + last).map(|k| (n, k)).filter(|place| self.has(*place)).collect()
    }

    /// Those of all sites.
    pub(crate) fn all(&self, last: usize) -> Vec<Place> {
        (0..self.sites).flat_map(|n| self.places(n, last)).collect()
    }

    /// The places of `D p` in the equation of a place, and their factors: a product of complex
    /// numbers.
    pub fn forces(&self, l: &Factors, (n, k): Place) -> Vec<(Place, Interval)> {
        let sites = self.system.a.len();
        let [re, im] = at(l, k).unwrap_or([Interval::exact(f64::NAN); 2]);
        let both = if n < sites { [re, -im] } else { [im, re] };
        let of_site = |(m, e): (usize, f64)| [0, 1].map(|i| ((m + i * sites, k), Interval::exact(e) * both[i]));
        let all = self.system.coupled(n % sites, k).into_iter().flat_map(of_site);
        all.filter(|(place, _)| place.0 < self.sites && self.has(*place)).collect()
    }

    /// The root of the sum of `|l_k|^2` beyond a harmonic, with a bound `tail` of that of one sign
    /// of the harmonics that are not computed.
    pub fn beyond(&self, l: &Factors, last: usize, tail: Interval) -> Interval {
        let (before, after) = l.split_at(l.len() / 2);
        let of = |l: &[Complex]| norm(l.iter().map(|l| norm(*l)).chain([tail]));
        let (above, below) = (of(&after[last + 1..]), of(&before[..before.len() - last]));
        if self.d.real { above } else { norm([above, below]) }
    }

    /// `l D p` at a place.
    pub fn force(&self, l: &Factors, p: &Field, place: Place) -> Interval {
        let force = |((m, k), factor): (Place, Interval)| {
            let all = p[m].iter().zip(MIDDLE - p[m].len() / 2..).filter(|(_, j)| *j >= self.first(m));
            factor * all.map(|(p, j)| self.d.entry(m, k, j) * *p).sum()
        };
        self.forces(l, place).into_iter().map(force).sum()
    }

    /// Whether a coefficient is one of those that are given, for each further unknown.
    pub(crate) fn is_pinned(&self, place: Place) -> impl Iterator<Item = Interval> {
        self.pinned.iter().map(move |own| kronecker(own.contains(&place)))
    }

    /// Left-hand side less right-hand side of the equation of a place, with these `g`.
    pub fn defect(&self, l: &Factors, (p, g): (&Field, &[Interval]), place: Place) -> Interval {
        let g: Interval = self.is_pinned(place).zip(g).map(|(own, g)| own * *g).sum();
        at(&p[place.0], place.1).unwrap_or(Interval::ZERO) + self.force(l, p, place) - g
    }

    /// Sums of the coefficients that are given.
    pub fn given(&self, p: &Field) -> Vec<Interval> {
        self.pinned.iter().map(|own| own.iter().filter_map(|(n, k)| at(&p[*n], *k)).sum()).collect()
    }

    /// How many harmonics an approximate solution has, and of how many equations its defects are
    /// computed.
    pub fn counts(&self) -> [usize; 2] {
        let harmonics = self.sizes[1] / SHARE;
        [harmonics, self.sizes[1] - harmonics]
    }
}

/// What the bounds are made of.
pub struct Terms<'a> {
    /// The equations.
    pub it: Equations<'a>,
    /// All values of their factors.
    pub l: Factors,
    /// `M` and `A`.
    pub block: Block,
    /// Bounds of the change of `D` in the ball.
    pub changed: Vec<Interval>,
    /// The forces `D h` are at most this for `|h| <= 1`.
    pub steepest: Vec<Interval>,
}

impl<'a> Terms<'a> {
    /// Those of these factors, and of these columns of further unknowns in the rows of the block,
    /// where strains differ by at most these changes. Without columns the unknowns are `g`.
    pub fn new(it: Equations<'a>, l: Factors, columns: Option<Vec<Vec<Interval>>>, changes: &[Interval]) -> Self {
        let (all, known) = (it.all(it.sizes[0]), &it.system.known);
        let lines =
            |column: Vec<Interval>, from| column.into_iter().enumerate().map(|(i, it)| (i + from, it)).collect();
        let own = |(i, place): (usize, &Place)| -> Vec<(usize, Interval)> {
            let given: Vec<_> = lines(it.is_pinned(*place).collect(), all.len());
            [vec![(i, Interval::ONE)], given].concat()
        };
        let minus = |own: &Vec<Place>| all.iter().map(|place| -kronecker(own.contains(place))).collect();
        let further = columns.unwrap_or_else(|| it.pinned.iter().map(minus).collect());
        let further = further.into_iter().map(|column| lines(column, 0));
        let plain = all.iter().enumerate().map(own).chain(further).collect();
        let (none, d) = (Vec::new, it.d.clone());
        let entry = Box::new(move |m, k, j| d.entry(m, k, j));
        let mut block = Block { all, sites: it.sites, entry, plain, inverse: none(), product: none(), reach: none() };
        let b = block.rows(|place| it.forces(&l, place));
        block.inverse = choices::inverse(&choices::matrix(&block, &b, &|_| Interval::ONE));
        [block.product, block.reach] = block.times(&b, &|_| Interval::ONE);
        let every = || (0..it.sites).map(|n| n % known.len());
        let changed = |n: usize| known[n].change(it.alpha, changes[n % changes.len()]) / it.unit();
        let changed = every().map(changed).collect();
        let steepest = every().map(|n| known[n].steepest() / it.unit()).collect();
        Self { it, l, block, changed, steepest }
    }

    /// `t |e|` by row.
    pub fn far(&self, t: Interval) -> Vec<Vec<Interval>> {
        let (system, parts) = (self.it.system, self.it.sites / self.it.system.a.len());
        let row = |n: usize| system.moduli(if n < self.it.sites { n % system.a.len() } else { system.a.len() }, t);
        (0..=self.it.sites).map(|n| row(n).repeat(parts)).collect()
    }

    /// The norm in a row of what is linear in an approximate solution, but for the rows of the
    /// block: with values at other places, `t` beyond them, and what forces do.
    pub fn beyond(
        &self,
        n: usize,
        value: &dyn Fn(Place) -> Interval,
        (p, contacts): (&Field, &[Vec<Interval>]),
        t: Interval,
    ) -> Interval {
        let (it, [harmonics, computed]) = (&self.it, self.it.counts());
        let sizes = p.iter().map(|p| p.iter().map(|p| p.abs()).sum::<Interval>());
        let (known, rest) = (it.system.known.iter().cycle(), |tail: Interval| tail / of(2).sqrt());
        let tails: Vec<Interval> = sizes
            .clone()
            .zip(known)
            .map(|(size, known)| size * rest(known.stiffness_tail(computed - harmonics)))
            .collect();
        let moved: Vec<Interval> = sizes.zip(&self.changed).map(|(size, change)| size * *change).collect();
        let places = if n < it.sites { it.places(n, computed) } else { Vec::new() };
        let own = places.into_iter().filter(|place| place.1.abs_diff(MIDDLE) > it.sizes[0]);
        own.map(|place| value(place).abs()).sum::<Interval>()
            + dot(&self.far(t)[n], &tails)
            + contacts.get(n).map_or(Interval::ZERO, |row| dot(row, &moved))
    }

    /// The radius of a ball about an approximate solution that holds one solution, in the further
    /// unknowns, if it is at most `radius`; and `q`. `p` has all values of its coefficients,
    /// `value` is its defect at a place, and `given` are the sums of those that are given.
    pub fn solved(
        &self,
        (p, value, given): (&Field, &dyn Fn(Place) -> Interval, &[Interval]),
        (bent, radius): (&Bent, Interval),
        go_on: &dyn Fn() -> Result<(), Refused>,
    ) -> Result<[Interval; 2], Refused> {
        let Self { it, block, l, changed, .. } = self;
        let ([last, enclosed], [_, computed]) = (it.sizes, it.counts());
        let mut derivative =
            Derivative::new(block, &self.far(it.beyond(l, last, it.system.tails()[0])), &self.steepest, |m| {
                let (all, known) = (it.places(m, enclosed / SHARE + last), &it.system.known[m % it.system.a.len()]);
                let harmonics = all.into_iter().map(|place| place.1).collect();
                go_on().map(|()| block.columns(m, harmonics, known.stiffness_tail(enclosed / SHARE) / it.unit()))
            })?;
        let of_unknown = |i: usize| -> Vec<Interval> {
            let near = block.by_site(&|row| block.kept(row, block.all.len() + i).abs()).into_iter().enumerate();
            let far = |n| self.beyond(n, &|place| (bent.value)(i, place), (p, &bent.contacts), bent.late);
            near.map(|(n, near)| near + far(n)).collect()
        };
        let larger = |a: Vec<Interval>, b: Vec<Interval>| a.into_iter().zip(b).map(|(a, b)| a.max(b)).collect();
        let column = (0..it.pinned.len()).map(of_unknown).fold(vec![Interval::ZERO; it.sites + 1], larger);
        // Strains and coefficients in the ball.
        for (row, contacts) in derivative.entries.iter_mut().zip(&bent.contacts) {
            let steep = self.steepest.iter().zip(changed).zip(contacts).map(|((a, b), by)| radius * (*a + *b) * *by);
            row.iter_mut().zip(steep).for_each(|(entry, by)| *entry = *entry + by);
        }
        let given = given.iter().zip(0..).map(|(sum, which)| *sum - kronecker(which == 0));
        let head: Vec<Interval> = block.all.iter().map(|place| value(*place)).chain(given).collect();
        let t = it.beyond(l, computed, it.system.tails()[0]);
        let y0 = block.image(&head, |n| self.beyond(n, value, (p, &derivative.contacts), t));
        let weight = choices::narrowest(&derivative.within(changed), &column, &y0);
        derivative.entries.iter_mut().zip(column).for_each(|(row, entry)| row.push(entry));
        derivative.weights[it.sites] = weight;
        let q = derivative.norm(&derivative.within(changed));
        Ok([weight * derivative.norm(&y0) / (Interval::ONE - q), q])
    }
}

/// What factors that depend on the further unknowns do.
pub struct Bent<'a> {
    /// For each of these unknowns `l' D p` at a place.
    pub value: &'a dyn Fn(usize, Place) -> Interval,
    /// `R' + t' |e|`, if there is something.
    pub contacts: Vec<Vec<Interval>>,
    /// `t'` beyond the harmonics of `value`.
    pub late: Interval,
}
