//! The terms of Newton's argument for a wave or a breather, and what is proved of it.
//!
//! The matrix of the block is `DG`. Its further unknown is the frequency of a piece that fixes
//! `a_1`; the equation of `a_1` has its index.

use super::{
    Bounds, Proof, Refused, System, bloch,
    fold::Fold,
    infinite::Far,
    moments::{NARROWEST, NARROWEST_ALONG, moments},
    multiplier,
    newton::{Block, Derivative, Place, dot, largest, radii, sums},
    of,
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
    /// `M` and `A`.
    pub block: Block,
    /// `R' + t |e|`, and `R' + t' |e|`, by row: what contacts do beyond the block, and along a
    /// piece.
    pub(super) beyond: [Vec<Vec<Interval>>; 2],
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
        let (mut block, b) = system.block(sites, last);
        let near = choices::matrix(&block, &b, &system.known);
        block.inverse = choices::inverse(&near);
        if let Some(far) = &far {
            far.copy_rows(&mut block);
            far.has_no_kernel(&block, &near)?;
        }
        go_on()?;
        [block.product, block.reach] = block.times(&b);
        let [_, turned] = block.times(&system.b(&block, &system.slopes));
        let beyond = |l: &dyn Fn(usize) -> Interval, tail: Interval| {
            let t = norm((last + 1..=enclosed).map(l).chain([tail]));
            let far: Vec<Vec<_>> = (0..=sites).map(|n| system.moduli(n).into_iter().map(|e| t * e).collect()).collect();
            sums(&turned, &far)
        };
        let edge = system.tails();
        let beyond = [beyond(&|k| system.range(k), edge[0]), beyond(&|k| system.slopes[k], edge[1])];
        Ok(Self { certificate, system, block, beyond, tails, steep_tails, far })
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
            0 if system.closes(n) => -system.mean[1],
            _ if system.first.is_some() => Interval::ZERO,
            _ => -system.turn(n, k),
        };
        let rates: Vec<Interval> = block.all.iter().map(rate).chain(system.first.map(|it| -it[1])).collect();
        let own = block.image(&system.residual(block), |n| {
            // The sum of moduli is that of all harmonics.
            let defects = if n < block.sites { system.defects(n, 2) } else { Vec::new() };
            let tails: Interval = defects.into_iter().map(|(m, e)| Interval::exact(e.abs()) * tails[m]).sum();
            self.defects_beyond((n, *last), &|_, g| g) + system.tails()[0] * tails
        });
        own.into_iter().zip(block.image(&rates, |_| Interval::ZERO)).map(|(own, rate)| own + rate).collect()
    }

    /// Harmonics of a site beyond `last` that are enclosed; none after all sites.
    fn harmonics(&self, n: usize, last: usize) -> impl Iterator<Item = usize> {
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

    /// The norm of `l' e n` of a site beyond the block.
    pub(super) fn turned_beyond(&self, n: usize) -> Interval {
        let own: Interval = self.harmonics(n, self.certificate.block).map(|k| self.system.turn(n, k).abs()).sum();
        own + self.system.tails()[1] * dot(&self.system.moduli(n), &self.tails)
    }
}

pub(super) fn check(certificate: &Certificate, stopped: &dyn Fn() -> bool) -> Result<Proof, Refused> {
    let go_on = || if stopped() { Err(Refused::Stopped) } else { Ok(()) };
    let terms = Terms::new(certificate, &go_on)?;
    let Terms { system, block, far, steep_tails, .. } = &terms;
    let (alpha, known, sites) = (certificate.model.alpha, &system.known, system.a.len());
    let steepest: Vec<Interval> = known.iter().map(|one| one.steepest(alpha)).collect();
    let mut derivative = Derivative::new(block, &terms.beyond[0], &steepest, &terms.column_of_last(), |m| {
        let computed = (0..=certificate.enclosed - certificate.block).filter(|j| system.has(m, *j));
        let places = computed.map(|j| (m, j, false)).collect();
        go_on().map(|()| block.columns(m, places, &known[m].stiffness, steep_tails[m]))
    })?;
    let perron = || choices::perron(&derivative.contacts[..sites]);
    let weights = far.as_ref().map_or_else(perron, |far| far.weights(sites));
    // At most 1, so that strains change by at most the radius.
    let weights: Vec<Interval> = weights.into_iter().map(|w| w.min(Interval::ONE)).collect();
    let y0 = terms.y0();
    let fold = Fold::new(&terms, y0[0]);
    derivative.weights = weights.iter().copied().chain([Interval::ONE / fold.eta]).collect();
    derivative.rows = terms.rows();
    let bounds = Bounds { y0: derivative.norm(&y0).hi(), z1: derivative.norm(&derivative.within(&[])).hi() };
    let changes = |r: Interval| -> Vec<Interval> { weights.iter().map(|w| *w * r).collect() };
    // The bounds of the derivative of T on a ball, by row.
    let rows = |r: Interval| -> Vec<Interval> {
        let changes: Vec<Interval> = known.iter().zip(changes(r)).map(|(one, by)| one.change(alpha, by)).collect();
        let rows = derivative.within(&changes).into_iter().enumerate();
        rows.map(|(n, row)| row + terms.change_of_last(n, r) / fold.eta).collect()
    };
    let found = radii(derivative.norm(&y0), fold.widest, |r| derivative.norm(&rows(Interval::exact(r))));
    let (radius, uniqueness_radius, q) = found.ok_or(Refused::Bounds(bounds))?;
    // An unknown frequency is nearer than the radius says, by its own row of T.
    let frequency = fold.frequency(system, y0[sites] + rows(radius)[sites] * radius);

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
        weights: weights.into_iter().chain(fold.turn).map(Interval::hi).collect(),
        multiplier,
        growth,
        decay,
        zero,
    })
}
