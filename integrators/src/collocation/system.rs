//! The interface between contact collocation and a problem: [`ContactChain`], a chain with exact
//! linear paths of its sites and contacts between neighbours.
//!
//! The two sites of a bond may have different kernels. The number `S` of kernels of a bond is known
//! at compile time. It is 1 if all sites are alike and all bonds have one law; else 2, the kernel
//! of the site before the bond and that of the site after it.

use super::{flow::Flow, open::Open};
use crate::{clock::DoubleDouble, law::BondLaw, regularised::common_power};
use std::sync::Arc;

/// The response of a site to an impulse `j`: `q'` jumps by `j/mass`. A part `m j` of this velocity
/// belongs to the free motion and a part `mu j` to the oscillation, so that `q(t) = j K(t)` with
/// `K(t) = m t + mu sin(omega t)/omega`.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Share of the free part.
    pub m: f64,
    /// Share of the oscillating part; `m + mu = 1/mass`, and 1 where all sites are alike.
    pub mu: f64,
    /// Angular frequency of the oscillation; positive if `mu` is.
    pub omega: DoubleDouble<f64>,
}

impl Response {
    /// The response of a wall: zero.
    const NONE: Self = Self { m: 0.0, mu: 0.0, omega: DoubleDouble { hi: 0.0, lo: 0.0 } };
}

/// The motion of a site without forces, `q(t) = r + v t + c cos(omega t) + s sin(omega t)`, as
/// `[r, v, c, s]`.
pub type Path = [f64; 4];

/// Phases below this are small: a sine is then bounded by its phase, above by 1. Chosen; held by
/// `methods springs_go_over_into_the_free_flight`.
const SMALL: f64 = 1e-3;

/// A bound of `|sin x|` for `x` up to a phase. With a spring that is weak for the time of a run,
/// `s = v/omega` is far above the displacements `s sin(omega t)` that occur.
#[inline(always)]
pub(crate) fn swing(phase: f64) -> f64 {
    if phase < SMALL { phase } else { 1.0 }
}

/// A drive of a site from outside, see [`ContactChain::signal`].
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Index of the site.
    pub site: usize,
    /// Whether the signal is the position of the site; else it is a force on the site.
    pub moved: bool,
    /// A bound of the absolute value of the signal.
    pub size: f64,
    /// The scale of the time derivative of the signal.
    pub rate: f64,
    /// The scale of the velocities that the drive causes.
    pub speed: f64,
    /// Start and end of the ramp or burst of the signal; both zero without.
    pub varies: [f64; 2],
}

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
    /// The largest weight of a side, which is the inverse mass of the lighter site; 1 if both
    /// weights are zero, between a wall and a site that is moved.
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
    pub(crate) fn singular_after(&self, rate: f64) -> f64 {
        if S == 1 { 0.0 } else { self.law.singular_after(rate) }
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
        let links: Vec<Link<S>> = (0..kinds).map(|b| link(chain, open.as_ref(), b)).collect();
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
        lightest: match sides.iter().fold(0.0, |most, side| side.weight.max(most)) {
            0.0 => 1.0,
            most => most,
        },
        damped: sides.iter().any(|side| side.flow.is_some()),
        wholly_damped: sides.iter().all(|side| side.flow.is_some()),
        lags: sides.iter().any(|side| side.flow.as_ref().is_some_and(|flow| flow.lags())),
        rated,
        sides,
    }
}

/// The neighbours of bond `b` among `n` bonds in a row, whose ends are neighbours of each other on
/// a ring.
#[inline(always)]
pub(crate) fn beside(b: usize, n: usize, ring: bool) -> [Option<usize>; 2] {
    let (first, last) = if ring { (Some(0), Some(n - 1)) } else { (None, None) };
    [if b > 0 { Some(b - 1) } else { last }, if b + 1 < n { Some(b + 1) } else { first }]
}

/// A chain of sites that move along exact linear paths and push each other in bonds between
/// neighbours.
///
/// The overlap of a bond is `g = rest + across(q)`, a difference of positions; bond `b` shares a
/// site with `b - 1` and `b + 1` only, the last with the first on a ring. Its force is that of its
/// [`BondLaw`].
///
/// `S` is 1 for a chain whose sites are all alike, and whose bonds are: `bond` and `response` then
/// give the same for all of them, with `m + mu = 1`, the constant 1 and no dissipation. `S` is 2
/// for other chains, where quantities of the site before a bond and of the site after it are kept
/// separate.
pub trait ContactChain<const S: usize = 1>: Send + Sync {
    /// Number of components of the state vector `y`.
    fn dim(&self) -> usize;
    /// Number of sites.
    fn sites(&self) -> usize;
    /// Number of bonds that can ever touch.
    fn bonds(&self) -> usize;
    /// Whether the last bond and the first share a site.
    fn ring(&self) -> bool;
    /// The law of a bond, with the overlap where all positions are zero. A viscoelastic one has an
    /// exponent above 1.
    fn bond(&self, bond: usize) -> BondLaw<f64>;
    /// The response of a site to an impulse.
    fn response(&self, site: usize) -> Response;
    /// The sites whose responses count for a bond: any one of its sites, or for `S = 2` the site
    /// before it and the site after it, with `None` for a wall.
    fn ends(&self, bond: usize) -> [Option<usize>; S];
    /// The difference of a quantity over a bond, as the overlap has it: `q_{n-1} - q_n`, or its two
    /// terms `[q_{n-1}, -q_n]` for `S = 2`.
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> Path) -> [Path; S];
    /// The sum of the forces of bonds on a site, `f_n - f_{n+1}`: minus the transpose of
    /// [`across`](Self::across). For `S = 2` a bond has one force for each of its sites, and each
    /// site takes the one that is its own.
    fn push(&self, site: usize, force: impl Fn(usize) -> [Path; S]) -> Path;
    /// The path of a site, from a state at `t = 0`.
    fn path(&self, y: &[f64], site: usize) -> Path;
    /// Writes a site into a state, from the free part of its position, its rate, the oscillating
    /// part, and its rate: `[r, r', p, p']`.
    fn place(&self, parts: [f64; 4], site: usize, y: &mut [f64]);
    /// The rounding error of an overlap whose terms are at most `largest`: overlaps up to it count
    /// as zero.
    fn dead_band(&self, largest: f64) -> f64;
    /// Damping `[drag, slip]` of a site, for `S = 2`: drag, a force over the velocity of the site;
    /// and the rate at which a dashpot damps the oscillating part, `p'' = -omega^2 p - slip p'`.
    fn damping(&self, _site: usize) -> [f64; 2] {
        [0.0; 2]
    }
    /// The drives, one for each driven site, for `S = 2`. A site that is moved has the response
    /// zero and the [`path`](Self::path) zero.
    fn drives(&self) -> Vec<Drive> {
        Vec::new()
    }
    /// The signal of a drive at time `t`, with its first and second derivative: the position of the
    /// site, or a force.
    fn signal(&self, _site: usize, _t: f64) -> [f64; 3] {
        [0.0; 3]
    }
    /// Times at which signals are not smooth.
    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }
    /// The ledger of a state at a time: energies dissipated by drag, by dashpots and by contacts,
    /// and the work of drives. The work on sites that are moved is without their kinetic energy.
    fn ledger(&self, _y: &[f64], _t: f64) -> Path {
        [0.0; 4]
    }
    /// Writes the ledger, and the sites that are moved, into a state.
    fn complete(&self, _ledger: Path, _t: f64, _y: &mut [f64]) {}
}

/// Sorts by time. Not inlined, so that it is compiled once for all numbers of nodes.
#[inline(never)]
pub(super) fn sort_by_time<T>(list: &mut [(f64, T)]) {
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
}
