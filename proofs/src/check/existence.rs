//! The terms of Newton's argument for a wave or a breather, and what is proved of it. The matrix of
//! the block is `DG`.

use super::{
    Bounds, Proof, Refused, System, bloch,
    fold::Fold,
    infinite::Far,
    moments::{NARROWEST, NARROWEST_ALONG, moments},
    multiplier,
    newton::{Block, Derivative, Place, largest, radii},
    of,
};
use crate::{certificate::Certificate, interval::Interval, untrusted::choices};
use std::{rc::Rc, slice::from_ref};

/// What the bounds are made of, beside the certificate.
pub struct Terms<'a> {
    pub(super) certificate: &'a Certificate,
    /// The equations.
    pub system: Rc<System>,
    /// `P` and `A`.
    pub block: Block,
    /// Tails of the forces beyond `K'`.
    pub tails: Vec<Interval>,
    /// Those of `D` beyond `K' - 2 K`.
    steep_tails: Vec<Interval>,
    /// What is known of the background of the infinite chain.
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
        let own = system
            .a
            .iter()
            .take(system.background.map_or(usize::MAX, |first| first + 1))
            .map(|a| go_on().and_then(|()| moments(a, alpha, enclosed, narrowest).ok_or(Refused::Moments)));
        system.known = own.collect::<Result<_, _>>()?;
        let mut tails: Vec<Interval> = system.known.iter().map(|one| one.force_tail(enclosed)).collect();
        let mut steep_tails: Vec<_> = system.known.iter().map(|one| one.stiffness_tail(enclosed - 2 * last)).collect();
        if let Some(far) = &far {
            far.widen(&mut system.known, [&mut tails, &mut steep_tails], alpha, sites);
        }
        let system = Rc::new(system);
        let mut block = system.block(sites, last);
        let near = choices::matrix(&block, from_ref(&system.factors));
        block.inverse = choices::inverse(&near);
        if let Some(far) = &far {
            far.copy_rows(&mut block);
            far.has_no_kernel(&block, &near)?;
        }
        Ok(Self { certificate, system, block, tails, steep_tails, far })
    }

    /// Sites whose bounds are those of all sites.
    pub fn rows(&self) -> usize {
        self.far.as_ref().map_or(self.system.a.len(), |far| far.last_row() + 1)
    }

    /// `Y0` by row. Along a piece the block has the change of `G`, too, at the rate of one half of
    /// the piece; beyond the block all values of `l_k` are meant.
    pub fn y0(&self) -> Vec<Interval> {
        let Self { system, block, tails, .. } = self;
        let (last, enclosed) = (self.certificate.block, self.certificate.enclosed);
        let l = |k: usize| if k <= last { system.factors[k] } else { system.ranges[k] };
        let value = |place: Place| system.defect(place, l(place.1));
        let rate = |(n, k): Place| match k {
            0 if system.closes(n) => -system.mean[1],
            _ if system.first.is_some() => Interval::ZERO,
            _ => -system.turn((n, k)),
        };
        let rest: Vec<_> = system.rest(tails).into_iter().map(|tails| system.tails()[0] * tails).collect();
        let own = block.image(&value, system.first.map(|it| system.a[0][1] - it[0]));
        let own = block.with(own, &value, (enclosed, &rest));
        let turned = block.image(&rate, system.first.map(|it| -it[1]));
        own.into_iter().zip(turned).map(|(own, turned)| own + turned).collect()
    }

    /// The bounds of the derivative, with weights 1.
    fn derivative(&self, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Derivative, Refused> {
        let (Certificate { block: last, enclosed, model, .. }, system) = (self.certificate, &self.system);
        let steepest: Vec<Interval> = system.known.iter().map(|one| one.steepest(model.alpha)).collect();
        let factors = (from_ref(&system.ranges), system.tails()[0]);
        self.block.derivative(factors, (enclosed - last, &self.steep_tails, &steepest), go_on)
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
    // At the centre D does not change.
    let bounds = Bounds { y0: derivative.norm(&y0).hi(), z1: derivative.norm(&derivative.within(&[])).hi() };
    let changes = |r: Interval| -> Vec<Interval> { weights.iter().map(|w| *w * r).collect() };
    // The bounds of the derivative of T on a ball, by row.
    let rows = |r: Interval| -> Vec<Interval> {
        let changes: Vec<Interval> = known.iter().zip(changes(r)).map(|(one, by)| one.change(alpha, by)).collect();
        let rows = derivative.within(&changes);
        fold.iter().fold(rows, |rows, fold| fold.changed(rows, known[0].force_change(alpha, r)))
    };
    let widest = fold.as_ref().map_or(f64::INFINITY, |fold| fold.eta.lo());
    let found = radii(derivative.norm(&y0), widest, |r| derivative.norm(&rows(Interval::exact(r))));
    let (radius, uniqueness_radius, q) = found.ok_or(Refused::Bounds(bounds))?;
    // An unknown frequency is nearer than the radius says, by its own row of T.
    let near = || system.middle[0] + (system.middle[1] * (y0[sites] + rows(radius)[sites] * radius)).ball();
    let frequency = if fold.is_some() { near() } else { system.omega() };

    let changes = changes(radius);
    let amplitude = largest(system.a.iter().map(|a| a[1].abs())).lo();
    if !system.a.iter().zip(&changes).any(|(a, change)| (a[1].abs() - *change).is_positive()) {
        return Err(Refused::Rest(radius.hi(), amplitude));
    }
    let of_line = |line| multiplier::check(certificate, line, (system, &changes), &go_on);
    let multiplier = certificate.multiplier.as_ref().map(of_line).transpose()?;
    for piece in &certificate.bloch {
        bloch::check(certificate, piece, (&system.perturbed(), &changes), &go_on)?;
    }
    let growth = bloch::growth(&certificate.bloch).map(|all| all.map(|it| [it.lo(), it.hi()]));
    let size = |rate: f64| (Interval::exact(rate) * of(2) * Interval::PI / system.omega()).exp();
    let multiplier = multiplier.or(growth.map(|[_, [from, to], _]| [size(from).lo(), size(to).hi()]));
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
