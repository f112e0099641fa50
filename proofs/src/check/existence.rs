//! The terms of Newton's argument for a wave or a breather, and what is proved of it.
//!
//! The matrix of the block is `DG`. Its further unknown is the frequency of a piece that fixes
//! `a_1`; the equation of `a_1` has its index.

use super::{
    Bounds, Moments, Proof, Refused, System,
    fold::Fold,
    infinite::Far,
    moments::{NARROWEST, NARROWEST_ALONG, moments},
    multiplier,
    newton::{Block, Derivative, Place, dot, largest, radii},
    of,
};
use crate::{
    certificate::{Certificate, Model},
    interval::{Interval, norm},
    untrusted::choices,
};

/// What the bounds are made of, beside the certificate.
pub struct Terms<'a> {
    pub(super) certificate: &'a Certificate,
    /// The equations.
    pub system: System,
    /// `M` and `A`.
    pub block: Block,
    /// `R'` along a piece, by site of the column.
    pub(super) turned: Vec<Vec<Interval>>,
    /// The roots of the sums of `l_k^2` beyond `K`, and of their changes along a piece.
    pub(super) beyond_block: [Interval; 2],
    /// Tails of the forces beyond `K'`, and of `D` beyond `K' - 2 K`.
    pub tails: Vec<[Interval; 2]>,
    /// What is known of the background of the infinite chain.
    pub far: Option<Far>,
}

impl<'a> Terms<'a> {
    /// Those of a certificate.
    pub fn new(certificate: &'a Certificate, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Self, Refused> {
        let Certificate { model: Model { alpha, .. }, block: last, enclosed, .. } = *certificate;
        let (mut system, [start, end]) = (System::new(certificate)?, certificate.ends());
        let (narrowest, sites) = (if start == end { NARROWEST } else { NARROWEST_ALONG }, system.a.len());
        let far = Far::new(certificate, &|| go_on().is_err())?;
        // Those of the background are all the same.
        let own = system.a.iter().take(system.background.map_or(usize::MAX, |first| first + 1)).map(|a| {
            let own = moments(a, alpha, enclosed, narrowest, &|| go_on().is_err());
            go_on()?;
            own.ok_or(Refused::Moments)
        });
        system.known = own.collect::<Result<_, _>>()?;
        let tail = |one: &Moments| [one.force_tail(enclosed), one.stiffness_tail(enclosed - 2 * last)];
        let mut tails: Vec<[Interval; 2]> = system.known.iter().map(tail).collect();
        if let Some(far) = &far {
            far.widen((&mut system.known, &mut tails), alpha, sites);
        }
        let beyond =
            |l: &dyn Fn(usize) -> Interval, i: usize| norm((last + 1..=enclosed).map(l).chain([system.tails()[i]]));
        let beyond_block = [beyond(&|k| system.range(k), 0), beyond(&|k| system.slopes[k], 1)];
        let (mut block, b) = system.block(sites, last);
        let near = choices::matrix(&block, &b, &system.known);
        block.inverse = choices::inverse(&near);
        if let Some(far) = &far {
            far.copy_rows(&mut block);
            far.has_no_kernel(&block, &near)?;
        }
        go_on()?;
        block.multiply(&b);
        let (_, turned) = block.times(&system.b(&block, &system.slopes));
        Ok(Self { certificate, system, block, turned, beyond_block, tails, far })
    }

    /// Sites whose bounds are those of all sites.
    pub fn rows(&self) -> usize {
        self.far.as_ref().map_or(self.system.a.len(), |far| far.last_row() + 1)
    }

    /// `Y0` by row. Along a piece the block has the change of `G`, too, at the rate of one half of
    /// the piece.
    pub fn y0(&self) -> Vec<Interval> {
        let Self { certificate: Certificate { block: last, .. }, system, block, tails, .. } = self;
        let rate = |&(n, k, _): &Place| match k {
            0 if system.level(n).is_none() => -system.mean[1],
            _ if system.first.is_some() => Interval::ZERO,
            _ => -(system.slopes[k] * system.force(n, k)),
        };
        let residual = system.residual(block);
        let rates: Vec<Interval> = block.all.iter().map(rate).chain(system.first.map(|it| -it[1])).collect();
        let head = |i: usize| [&residual, &rates].map(|of| dot(&block.inverse[i], of).abs());
        let mut y0 = block.by_site(&|i| head(i).into_iter().sum());
        for (n, y0) in y0.iter_mut().enumerate().take(block.sites) {
            let tails = system.defects(n, 0).into_iter().map(|(m, e)| Interval::exact(e.abs()) * tails[m][0]);
            *y0 = *y0 + self.beyond((n, *last), &|_, g| g) + system.tails()[0] * tails.sum();
        }
        y0
    }

    /// The sum of `of(k, |G_nk|)` over harmonics beyond `last`, up to `K'`.
    fn beyond(&self, (n, last): (usize, usize), of: &dyn Fn(usize, Interval) -> Interval) -> Interval {
        let all = (last + 1..=self.certificate.enclosed).filter(|k| self.system.has(n, *k));
        all.map(|k| of(k, self.system.defect((n, k), self.system.range(k)).abs())).sum()
    }

    /// Bounds of the velocities ("Resonators and velocities" in `README.md`); of `y_n` with a factor
    /// `share` for each harmonic. `changes` are those of the strains of each site.
    fn velocity(&self, changes: &[Interval], share: &dyn Fn(usize) -> Interval) -> Interval {
        let Self { certificate: Certificate { model, enclosed, .. }, system, tails, .. } = self;
        let root = share(enclosed + 1) * (system.decay[0].square() / of(*enclosed)).sqrt();
        let factor = |k: usize| of(k) * share(k);
        let steep = norm((1..=*enclosed).map(|k| factor(k) * system.range(k)).chain([root]));
        let force = |((one, tail), change): ((&Moments, &[Interval; 2]), &Interval)| {
            root * tail[0] + steep * one.force_change(model.alpha, *change)
        };
        let forces: Vec<Interval> = system.known.iter().zip(tails).zip(changes).map(force).collect();
        let of_site = |n: usize| self.beyond((n, 0), &|k, g| factor(k) * g) + dot(&system.moduli(n), &forces);
        system.omega() * largest((0..self.rows()).map(of_site))
    }

    /// Bounds of `|x_n - xbar_n|`, `|y_n - ybar_n|` and of their velocities, from those of the strains
    /// of each site; infinite where they are not known. The background of the infinite chain is as
    /// near to its own sum as its proof says.
    fn distances(&self, radius: Interval, changes: &[Interval]) -> [f64; 4] {
        let Self { certificate: Certificate { model, to, enclosed, .. }, system, far, .. } = self;
        let kappa = model.kappa.enclosed();
        let moved = |k: usize| (system.omega() * of(k)).square();
        // |b_k/a_k|; NaN where it is not known to be finite. The mean of a single wave is exact.
        let share =
            |k: usize| model.rho.map_or(Interval::ZERO, |rho| (kappa / (kappa - rho.enclosed() * moved(k))).abs());
        let mean = if system.is_wave() && to.is_none() { Interval::ZERO } else { Interval::ONE };
        let most = (1..=enclosed + 1).map(share).fold(mean, Interval::max);
        let velocities = [self.velocity(changes, &|_| Interval::ONE), self.velocity(changes, &share)];
        let background = far.as_ref().map_or([0.0; 4], |Far { background: it, .. }| {
            [it.radius, it.radius_y, it.radius_velocity, it.radius_velocity_y]
        });
        let own = [radius, radius * most, velocities[0], velocities[1]];
        [0, 1, 2, 3].map(|i| {
            let bound = own[i] + Interval::exact(background[i]);
            if bound.is_nan() { f64::INFINITY } else { bound.hi() }
        })
    }
}

pub(super) fn check(certificate: &Certificate, stopped: &dyn Fn() -> bool) -> Result<Proof, Refused> {
    let go_on = || if stopped() { Err(Refused::Stopped) } else { Ok(()) };
    let terms = Terms::new(certificate, &go_on)?;
    let Terms { system, block, turned, far, .. } = &terms;
    let (alpha, known, sites) = (certificate.model.alpha, &system.known, system.a.len());
    let beyond = |n: usize| -> Vec<Interval> {
        let turned = turned.iter().map(|turned| turned[n]);
        turned.zip(system.moduli(n)).map(|(turned, e)| turned + terms.beyond_block[0] * e).collect()
    };
    let beyond: Vec<Vec<Interval>> = (0..=sites).map(beyond).collect();
    let perron = || choices::perron(&block.contacts(&beyond)[..sites]);
    let weights = far.as_ref().map_or_else(perron, |far| far.weights(sites));
    // At most 1, so that strains change by at most the radius.
    let weights: Vec<Interval> = weights.into_iter().map(|w| w.min(Interval::ONE)).collect();
    let steepest: Vec<Interval> = known.iter().map(|one| one.steepest(alpha)).collect();
    let mut derivative = Derivative::new(block, &beyond, (&steepest, &weights), |m| {
        let computed = (0..=certificate.enclosed - certificate.block).filter(|j| system.has(m, *j));
        let places = computed.map(|j| (m, j, false)).collect();
        go_on().map(|()| block.columns(m, places, &known[m].stiffness, terms.tails[m][1]))
    })?;
    derivative.rows = terms.rows();
    let y0 = terms.y0();
    let fold = Fold::new(&terms, y0[0]);
    derivative.further(Interval::ONE / fold.eta, &terms.column_of_last());
    let bounds = Bounds { y0: derivative.norm(&y0).hi(), z1: derivative.norm(&derivative.z1).hi() };
    let changes = |r: Interval| -> Vec<Interval> { weights.iter().map(|w| *w * r).collect() };
    // The bounds of the derivative of T on a ball, by row.
    let rows = |r: f64| -> Vec<Interval> {
        let r = Interval::exact(r);
        let changes: Vec<Interval> = known.iter().zip(changes(r)).map(|(one, by)| one.change(alpha, by)).collect();
        let rows = derivative.changed(&changes).into_iter().enumerate();
        rows.map(|(n, row)| row + terms.change_of_last(n, r) / fold.eta).collect()
    };
    let found = radii(derivative.norm(&y0), fold.widest, |r| derivative.norm(&rows(r)));
    let (radius, uniqueness_radius, q) = found.ok_or(Refused::Bounds(bounds))?;
    // An unknown frequency is nearer than the radius says, by its own row of T.
    let frequency = fold.frequency(system, y0[sites] + rows(radius.hi())[sites] * radius);

    let changes = changes(radius);
    let amplitude = largest(system.a.iter().map(|a| a[1].abs())).lo();
    if !system.a.iter().zip(&changes).any(|(a, change)| (a[1].abs() - *change).is_positive()) {
        return Err(Refused::Rest(radius.hi(), amplitude));
    }
    let of_line = |line| multiplier::check(certificate, line, (system, &changes), &go_on);
    let multiplier = certificate.multiplier.as_ref().map(of_line).transpose()?;
    let decay = far.as_ref().map(|far| far.decay(system, &weights, radius));
    let zero = Some(&terms).filter(|_| certificate.is_to_zero()).and_then(|it| it.zero(&derivative, [radius, q]));
    let [radius, radius_y, radius_velocity, radius_velocity_y] = terms.distances(radius, &changes);
    let weights = weights.into_iter().chain(fold.turn).map(Interval::hi).collect();
    Ok(Proof {
        radius,
        radius_y,
        radius_velocity,
        radius_velocity_y,
        uniqueness_radius,
        frequency: [frequency.lo(), frequency.hi()],
        amplitude,
        bounds,
        contraction: q.hi(),
        weights,
        multiplier,
        decay,
        zero,
    })
}
