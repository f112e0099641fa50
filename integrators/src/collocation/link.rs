//! The constants of bonds and of their sides, as the solver sees them.

use super::{
    chain::{ContactChain, Response, beside},
    flow::Flow,
    open::Open,
};
use crate::{law::BondLaw, regularised::common_power};
use std::sync::Arc;

/// One side of a bond: the [`Response`] of its site, in the form that loops over nodes need.
#[derive(Clone, Debug)]
pub(crate) struct Side {
    pub(crate) m: f64,
    pub(crate) mu: f64,
    pub(crate) mu_per_omega: f64,
    /// Angular frequency; zero if the site has no oscillating part.
    pub(crate) omega: f64,
    /// `1/omega`; zero for `omega = 0`.
    pub(crate) per_omega: f64,
    /// `m + mu`: acceleration by a unit force.
    weight: f64,
    /// The motion of the site, if it is damped.
    flow: Option<Arc<Flow>>,
}

impl Side {
    fn of(response: &Response, flow: Option<Arc<Flow>>) -> Self {
        let Response { m, mu, .. } = *response;
        let omega = if mu == 0.0 { 0.0 } else { response.omega.value() };
        let per_omega = if omega == 0.0 { 0.0 } else { 1.0 / omega };
        Self { m, mu, mu_per_omega: mu * per_omega, omega, per_omega, weight: m + mu, flow }
    }
}

/// The constants of a bond: its law and its sides.
#[derive(Clone, Debug)]
pub(crate) struct Link<const S: usize> {
    pub(crate) law: BondLaw<f64>,
    pub(crate) sides: [Side; S],
    /// Power of the panels' variable near an event, chosen for the forces of the bond and of its
    /// neighbours.
    pub(crate) q: u32,
    /// The largest weight of a side, which is the inverse mass of the lighter site; between a wall
    /// and a site that is moved, which have none, that of the lightest site of the chain.
    lightest: f64,
    /// Whether a site of the bond is damped, whether both are, and whether drag acts on the free
    /// motion of one.
    damped: bool,
    wholly_damped: bool,
    pub(crate) lags: bool,
    /// Whether its panels have the rates of overlaps: the contact or a neighbour's dissipates.
    pub(crate) rated: bool,
}

/// Order for which the power of the variable near an event is chosen. Chosen;
/// `methods panels_cut_at_events_of_neighbours_restore_the_order` measures what it gives.
const ORDER: u32 = 8;

// For S = 1 weights and constants are 1 at compile time.
impl<const S: usize> Link<S> {
    /// The second derivative of the overlap by a unit force on a side.
    #[inline(always)]
    pub(crate) fn weight(&self, side: usize) -> f64 {
        if S == 1 { 1.0 } else { self.sides[side].weight }
    }

    /// Whether a site is damped. The code for damped sites is not inlined into the kernels: there
    /// it would prevent that both sides of other bonds are computed in one register.
    #[inline(always)]
    pub(crate) fn damped(&self) -> bool {
        S != 1 && self.damped
    }

    /// Whether both sites are damped.
    #[inline(always)]
    pub(crate) fn wholly_damped(&self) -> bool {
        S != 1 && self.wholly_damped
    }

    /// The motion of the site on a side, if it is damped.
    #[inline(always)]
    pub(crate) fn flow(&self, side: usize) -> Option<&Flow> {
        if S == 1 || !self.damped { None } else { self.sides[side].flow.as_deref() }
    }

    /// The largest change of velocity by a unit impulse: the inverse mass of the lighter site.
    #[inline(always)]
    pub(crate) fn lightest(&self) -> f64 {
        if S == 1 { 1.0 } else { self.lightest }
    }

    #[inline(always)]
    pub(crate) fn constant(&self) -> f64 {
        if S == 1 { 1.0 } else { self.law.constant }
    }

    /// The force of an overlap, without resistance.
    #[inline(always)]
    pub(crate) fn elastic_force(&self, overlap: f64) -> f64 {
        self.constant() * self.law.power.force(overlap)
    }

    /// The forces of several overlaps.
    #[inline(always)]
    pub(crate) fn forces<const M: usize>(&self, overlaps: &[f64; M]) -> [f64; M] {
        let mut forces = self.law.power.forces(overlaps);
        if S != 1 {
            for force in &mut forces {
                *force *= self.law.constant;
            }
        }
        forces
    }

    /// The derivative of the force.
    #[inline(always)]
    pub(crate) fn stiffness(&self, overlap: f64) -> f64 {
        self.constant() * self.law.power.stiffness(overlap)
    }

    /// Whether the contact dissipates.
    #[inline(always)]
    pub(crate) fn lossy(&self) -> bool {
        S != 1 && self.law.dissipates()
    }

    /// `c(g)`; zero where beads do not overlap.
    pub(crate) fn resistance_if_closed(&self, overlap: f64) -> f64 {
        if overlap > 0.0 { self.law.resistance(overlap) } else { 0.0 }
    }

    /// See [`BondLaw::singular_after`].
    #[inline(always)]
    pub(crate) fn singular_after(&self, overlap: f64, rate: f64) -> f64 {
        if S == 1 { 0.0 } else { self.law.singular_after(overlap, rate) }
    }

    /// The stiffness `f'(g) t^2/m` of an overlap over a time, with the mass `m` of the lighter
    /// site, dimensionless; plus `(c(g) t/m)^2` for a contact that dissipates.
    #[inline(always)]
    pub(crate) fn stiffness_over(&self, overlap: f64, t: f64) -> f64 {
        let stiffness = self.stiffness(overlap) * t * t * self.lightest();
        if !self.lossy() {
            return stiffness;
        }
        let resistance = self.resistance_if_closed(overlap) * t * self.lightest();
        stiffness + resistance * resistance
    }
}

/// The constants of a chain for the solver of windows, which does not know the chain's type.
#[derive(Clone, Debug)]
pub(crate) struct Links<const S: usize> {
    pub(crate) bonds: usize,
    pub(crate) ring: bool,
    /// One for each bond; a single one for all bonds if `S = 1`.
    links: Vec<Link<S>>,
    /// Whether a bond has a positive overlap when all sites are at the origin.
    pub(crate) precompressed: bool,
    /// Damping, drives and dissipation of the chain, if it has any.
    pub(crate) open: Option<Open>,
    /// Whether a contact dissipates. Kept, since the solver asks for each bond of each window.
    lossy: bool,
}

impl<const S: usize> Links<S> {
    pub(crate) fn of<C: ContactChain<S>>(chain: &C) -> Self {
        let bonds = chain.bonds();
        let kinds = if S == 1 { 1 } else { bonds };
        let open = Open::of(chain);
        let mut links: Vec<Link<S>> = (0..kinds).map(|b| link(chain, open.as_ref(), b)).collect();
        let lightest = links.iter().fold(0.0, |most, link| link.lightest.max(most));
        let unheld = links.iter_mut().filter(|link| link.lightest == 0.0);
        unheld.for_each(|link| link.lightest = if lightest > 0.0 { lightest } else { 1.0 });
        Self {
            bonds,
            ring: chain.ring(),
            precompressed: (0..kinds).any(|b| chain.bond(b).rest > 0.0),
            lossy: links.iter().any(Link::lossy),
            links,
            open,
        }
    }

    /// Minus the second derivative of a bond's overlap by a unit force in it: 2 between two sites
    /// of mass 1, 1 at a wall.
    pub(crate) fn mobility<C: ContactChain<S>>(&self, chain: &C, bond: usize) -> f64 {
        let unit = |c: usize| [[f64::from(u8::from(c == bond)); 4]; S];
        // For S = 1 a wall is seen from what the bond pushes; for S = 2 its weight is zero.
        match S {
            1 => -chain.across(bond, |i| chain.push(i, unit))[0][0],
            _ => self.links[bond].sides.iter().map(|side| side.weight).sum(),
        }
    }

    /// The constants of all bonds that differ: of one for `S = 1`, else of each.
    pub(crate) fn each(&self) -> impl Iterator<Item = &Link<S>> {
        self.links.iter()
    }

    /// Whether a contact dissipates.
    pub(crate) fn lossy(&self) -> bool {
        self.lossy
    }

    #[inline(always)]
    pub(crate) fn link(&self, bond: usize) -> &Link<S> {
        &self.links[if S == 1 { 0 } else { bond }]
    }
}

fn link<const S: usize, C: ContactChain<S>>(chain: &C, open: Option<&Open>, bond: usize) -> Link<S> {
    let sides = chain.ends(bond).map(|site| {
        let flow = site.and_then(|i| open.and_then(|open| open.damped(i).cloned()));
        Side::of(&site.map_or(Response::NONE, |i| chain.response(i)), flow)
    });
    let law = chain.bond(bond);
    let powers = |law: &BondLaw<f64>| [Some(law.alpha()), law.power_of_resistance()].into_iter().flatten();
    let mut alphas: Vec<f64> = powers(&law).collect();
    let mut rated = law.dissipates();
    if S > 1 {
        for b in beside(bond, chain.bonds(), chain.ring()).into_iter().flatten() {
            let beside = chain.bond(b);
            alphas.extend(powers(&beside));
            rated |= beside.dissipates();
        }
    }
    Link {
        law,
        q: common_power(&alphas, ORDER),
        lightest: sides.iter().fold(0.0, |most, side| side.weight.max(most)),
        damped: sides.iter().any(|side| side.flow.is_some()),
        wholly_damped: sides.iter().all(|side| side.flow.is_some()),
        lags: sides.iter().any(|side| side.flow.as_ref().is_some_and(|flow| flow.lags())),
        rated,
        sides,
    }
}
