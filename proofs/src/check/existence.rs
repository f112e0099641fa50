//! The terms of Newton's argument for a wave or a breather, and what is proved of it. The matrix of
//! the block is `DG`.

use super::{
    Bounds, Proof, Refused, System, bloch,
    fold::Fold,
    infinite::Far,
    moments::{NARROWEST, NARROWEST_ALONG, moments},
    newton::{Block, Derivative, Lines, largest, radii, weight},
};
use crate::{
    certificate::Certificate,
    interval::{Interval, norm},
    untrusted::choices,
};

/// What the bounds are made of, beside the certificate.
pub struct Terms<'a> {
    pub(super) certificate: &'a Certificate,
    /// The equations.
    pub system: System,
    /// `P`, `A` and `A B`.
    pub block: Block,
    /// `e`.
    pub e: Lines,
    /// Tails of the forces beyond `K'`.
    pub tails: Vec<Interval>,
    /// Those of `D` beyond `K' - 2 K`.
    steep_tails: Vec<Interval>,
    /// What a breather of the infinite chain has beside.
    pub far: Option<Far>,
}

impl<'a> Terms<'a> {
    /// Those of a certificate.
    pub fn new(certificate: &'a Certificate, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Self, Refused> {
        let (alpha, last, enclosed) = (certificate.model.alpha, certificate.block, certificate.enclosed);
        let (mut system, [start, end]) = (System::new(certificate)?, certificate.ends());
        let (narrowest, sites) = (if start == end { NARROWEST } else { NARROWEST_ALONG }, system.a.len());
        let far = Far::new(certificate, &|| go_on().is_err())?;
        // Those of the background are all the same.
        let own = system.a.iter().take(system.background.map_or(usize::MAX, |first| first + 1)).map(|a| {
            go_on()?;
            moments(a, alpha, enclosed, narrowest).ok_or(Refused::Moments)
        });
        system.known = own.collect::<Result<_, _>>()?;
        let mut tails: Vec<Interval> = system.known.iter().map(|one| one.force_tail(enclosed)).collect();
        let mut steep_tails: Vec<_> = system.known.iter().map(|one| one.stiffness_tail(enclosed - 2 * last)).collect();
        if let Some(far) = &far {
            far.widen(&mut system.known, [&mut tails, &mut steep_tails], alpha, sites);
        }
        let (mut block, e) = system.block(sites, last);
        let near = choices::matrix(&block, &e, &|k| system.factors[k] / weight(k));
        block.inverse = choices::inverse(&near);
        if let Some(far) = &far {
            far.copy_rows(&mut block);
            far.has_no_kernel(&block, &near)?;
        }
        go_on()?;
        [block.product, block.reach] = block.times(&e, &|k| system.range(k) / weight(k));
        Ok(Self { certificate, system, block, e, tails, steep_tails, far })
    }

    /// Sites whose bounds are those of all sites.
    pub fn rows(&self) -> usize {
        self.far.as_ref().map_or(self.system.a.len(), |far| far.last_row() + 1)
    }

    /// `Y0` by row. Along a piece the block has the change of `G`, too, at the rate of one half of
    /// the piece.
    pub fn y0(&self) -> Vec<Interval> {
        let Self { certificate: Certificate { block: last, .. }, system, block, tails, .. } = self;
        let own = block.image(&system.residual(block), |n| {
            // The sum of moduli is that of all harmonics.
            let defects = if n < block.sites { system.defects(n, 2) } else { Vec::new() };
            let tails: Interval = defects.into_iter().map(|(m, e)| Interval::exact(e.abs()) * tails[m]).sum();
            self.defects_beyond((n, *last), &|_, g| g) + system.tails()[0] * tails
        });
        own.into_iter().zip(block.image(&system.rates(&block.all), |_| Interval::ZERO)).map(|(a, b)| a + b).collect()
    }

    /// Harmonics of a site beyond `last` that are enclosed; none after all sites.
    pub(super) fn harmonics(&self, n: usize, last: usize) -> impl Iterator<Item = usize> {
        (last + 1..=self.certificate.enclosed).filter(move |k| n < self.system.a.len() && self.system.has(n, *k))
    }

    /// The sum of `of(k, |G_nk|)` over harmonics beyond `last`, up to `K'`.
    pub(super) fn defects_beyond(
        &self,
        (n, last): (usize, usize),
        of: &dyn Fn(usize, Interval) -> Interval,
    ) -> Interval {
        self.harmonics(n, last).map(|k| of(k, self.system.defect((n, k), self.system.range(k)).abs())).sum()
    }

    /// `t |e|` by row, for these factors and the tail of those beyond `K'`.
    pub(super) fn beyond(&self, l: &dyn Fn(usize) -> Interval, tail: Interval) -> Vec<Vec<Interval>> {
        let t = norm((self.certificate.block + 1..=self.certificate.enclosed).map(l).chain([tail]));
        (0..=self.block.sites).map(|n| self.system.moduli(n, t)).collect()
    }

    /// The bounds of the derivative, with weights 1.
    fn derivative(&self, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Derivative, Refused> {
        let Self { certificate: Certificate { block: last, enclosed, .. }, system, block, steep_tails, .. } = self;
        let far = self.beyond(&|k| system.range(k), system.tails()[0]);
        let steepest: Vec<Interval> = system.known.iter().map(|one| one.steepest()).collect();
        Derivative::new(block, &far, &steepest, |m| {
            let computed = (0..=enclosed - last).filter(|j| system.has(m, *j)).collect();
            go_on().map(|()| block.columns(m, computed, steep_tails[m]))
        })
    }
}

pub(super) fn check(certificate: &Certificate, stopped: &dyn Fn() -> bool) -> Result<Proof, Refused> {
    let go_on = || if stopped() { Err(Refused::Stopped) } else { Ok(()) };
    let terms = Terms::new(certificate, &go_on)?;
    let (Terms { system, far, .. }, mut derivative) = (&terms, terms.derivative(&go_on)?);
    let (alpha, known, sites) = (certificate.model.alpha, &system.known, system.a.len());
    let perron = || choices::perron(&derivative.contacts[..sites]);
    let weights = far.as_ref().map_or_else(perron, |far| far.weights(sites));
    // At most 1, so that strains change by at most the radius.
    let weights: Vec<Interval> = weights.into_iter().map(|w| w.min(Interval::ONE)).collect();
    derivative.weights = weights.iter().copied().chain([Interval::ONE]).collect();
    derivative.rows = terms.rows();
    let y0 = terms.y0();
    let fold = system.first.map(|_| Fold::new(&terms, y0[0], &mut derivative));
    let bounds = Bounds { y0: derivative.norm(&y0).hi(), z1: derivative.norm(&derivative.within(&[])).hi() };
    let changes = |r: Interval| -> Vec<Interval> { weights.iter().map(|w| *w * r).collect() };
    // The bounds of the derivative of T on a ball, by row.
    let rows = |r: Interval| -> Vec<Interval> {
        let changes: Vec<Interval> = known.iter().zip(changes(r)).map(|(one, by)| one.change(alpha, by)).collect();
        let rows = derivative.within(&changes);
        fold.iter().fold(rows, |rows, fold| fold.changed(rows, &known[0], alpha, r))
    };
    let widest = fold.as_ref().map_or(f64::INFINITY, |it| it.eta.lo());
    let found = radii(derivative.norm(&y0), widest, |r| derivative.norm(&rows(Interval::exact(r))));
    let (radius, uniqueness_radius, q) = found.ok_or(Refused::Bounds(bounds))?;
    // By its own row of T an unknown frequency is nearer to the middle than the radius says.
    let near = || system.middle[0] + (system.middle[1] * (y0[sites] + rows(radius)[sites] * radius)).ball();
    let frequency = if fold.is_some() { near() } else { system.omega() };

    let changes = changes(radius);
    let amplitude = largest(system.a.iter().map(|a| a[1].abs())).lo();
    if !system.a.iter().zip(&changes).any(|(a, change)| (a[1].abs() - *change).is_positive()) {
        return Err(Refused::Rest(radius.hi(), amplitude));
    }
    let (multiplier, growth) = bloch::perturbations(certificate, (system, &changes), &go_on)?;
    let decay = far.as_ref().map(|far| far.decay(system, &weights, radius));
    let zero = Some(&terms).filter(|_| certificate.is_to_zero()).and_then(|it| it.zero(&derivative, [radius, q]));
    let [radius, radius_y, radius_velocity, radius_velocity_y] = terms.distances(radius, &changes);
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
        weights: weights.into_iter().chain(fold.map(|it| it.turn)).map(Interval::hi).collect(),
        multiplier,
        growth,
        decay,
        zero,
    })
}
