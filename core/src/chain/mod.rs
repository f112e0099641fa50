//! The chain: beads, contacts, resonators (eq:Hertz), (eq:HertzS), (eq:NC).
//!
//! | symbol | meaning |
//! |---|---|
//! | `u, v` | displacements of beads and resonators; their velocities `u', v'` |
//! | `x, y` | strains `x_n = u_n - u_{n-1}`, `y_n = v_n - v_{n-1}` (strain ring) |
//! | `g, f` | overlap and contact force `f = (g)_+^alpha` of a bond |
//! | `alpha, kappa, rho` | exponent, spring constant, mass ratio |
//! | `omega` | `sqrt(kappa (1 + 1/rho))`, the frequency of a bead against its resonator |

mod aligned;
pub(crate) mod bonds;
mod boundary;
mod contact_chain;
pub(crate) mod contacts;
mod details;
mod divisible;
mod energy;
mod equilibrium;
mod field;
pub(crate) mod gauss;
mod kinetic;
mod lanes;
mod law;
mod layout;
mod linear;
mod mean_force;
mod modes;
pub(crate) mod natural;
mod params;
pub(crate) mod phase;
mod rows;
mod state;
mod sweep;
mod topology;
mod variations;

pub use bonds::CorrectedSplit;
pub use boundary::Boundary;
pub use contacts::{Contact, ContactLog, Contacts, Overlaps, TOUCH};
pub use details::{
    Course, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, HeterogeneousChain, Joint, Kind, Parameter,
    Signal, SitewiseBonds, SitewiseFlow, Spline, Table, Term,
};
pub use divisible::{Divisible, Split};
pub use energy::Energy;
pub use field::Field;
pub use kinetic::KineticFlow;
pub use law::ContactLaw;
pub use layout::{Layout, Ledger};
pub use linear::LinearFlow;
pub use mean_force::MeanForces;
pub use modes::Modes;
pub use params::{Params, Resonators};
pub use state::{Site, State};
pub use topology::{Pushed, Topology};
pub use variations::{Variations, Varied};

pub use crate::numerics::max_norm;

use crate::error::{Result, require};
use details::CheckedDetails;
use hertzchain_integrators::Real;
use std::sync::Arc;

/// A chain of `sites` beads: its parameters, boundary and contact law, without a state.
#[derive(Clone, Debug)]
pub struct Chain<R> {
    params: Params,
    topology: Topology,
    modes: Modes<R>,
    layout: Layout,
    precompression: R,
    law: ContactLaw<R>,
    details: Option<Arc<CheckedDetails<R>>>,
    /// Of chains [abreast](Self::abreast): the single ones. None for a chain alone.
    members: Vec<Self>,
}

impl<R: Real> Chain<R> {
    /// A chain without precompression.
    ///
    /// # Errors
    /// `sites = 0`, or `params` outside their rules.
    pub fn new(params: Params, boundary: Boundary, sites: usize) -> Result<Self> {
        params.validate()?;
        require(sites > 0, "sites", sites, "a chain has at least one bead")?;
        let layout = Layout::new(sites, params.resonators() == Resonators::Moving);
        let topology = Topology::new(boundary, sites);
        Ok(Self {
            params,
            topology,
            modes: Modes::new(params),
            layout,
            precompression: R::zero(),
            law: ContactLaw::new(params.alpha),
            details: None,
            members: Vec::new(),
        })
    }

    /// The same chain with a static overlap `delta_0` in every bond:
    /// `g_n = delta_0 + u_{n-1} - u_n`.
    ///
    /// # Errors
    /// `delta_0` negative or not finite; or not zero on a chain with a free end (which would fly
    /// apart: it is an initial condition there) or on a strain ring (whose mean strain is an
    /// initial condition).
    pub fn precompressed(mut self, delta_0: f64) -> Result<Self> {
        require(delta_0.is_finite() && delta_0 >= 0.0, "precompression", delta_0, "a finite overlap, at least zero")?;
        let held = delta_0 <= 0.0 || matches!(self.boundary(), Boundary::Fixed | Boundary::Ring);
        let rule = "only two walls or a ring can hold a precompression; elsewhere it is an initial condition";
        require(held, "precompression", delta_0, rule)?;
        self.precompression = R::of(delta_0);
        Ok(self)
    }

    /// A part of the chain, `sites` neighbouring sites, as a chain of its own: of displacements
    /// with the walls of the chain, or of strains on a ring.
    /// Where the chain was cut, contact forces on the outermost sites are wrong.
    pub(crate) fn cut(&self, sites: usize) -> Self {
        let boundary = match self.boundary() {
            Boundary::Ring => Boundary::Free,
            other => other,
        };
        self.with_sites(boundary, sites)
    }

    fn with_sites(&self, boundary: Boundary, sites: usize) -> Self {
        let layout = Layout::new(sites, self.layout.resonators());
        Self { topology: Topology::new(boundary, sites), layout, ..self.clone() }
    }

    /// The parameters.
    pub fn params(&self) -> Params {
        self.params
    }

    /// The boundary condition at the ends.
    pub fn boundary(&self) -> Boundary {
        self.topology.boundary()
    }

    /// The topology: which bond joins which sites.
    pub fn topology(&self) -> Topology {
        self.topology
    }

    /// Number of beads (bonds, on a strain ring).
    pub fn sites(&self) -> usize {
        self.layout.sites()
    }

    /// The places of the arrays `u, v, u', v'` in a state.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Name of an entry of a state in words, such as `u of site 3`, counted from 0; strains and
    /// their rates on a strain ring.
    pub fn place(&self, entry: usize) -> String {
        let (n, ring) = (self.sites(), self.topology.strains());
        let names = if ring { ["x", "y", "x'", "y'"] } else { ["u", "v", "u'", "v'"] };
        if entry >= 2 * self.layout.half() {
            return "the work of dampers and drives".to_owned();
        }
        let array = entry / n * if self.layout.resonators() { 1 } else { 2 };
        format!("{} of site {}", names[array.min(3)], entry % n)
    }

    /// The details, checked and completed, for loops of this crate.
    pub(crate) fn parts(&self) -> Option<&CheckedDetails<R>> {
        self.details.as_deref()
    }

    /// The two independent motions of a site between contacts.
    pub fn modes(&self) -> Modes<R> {
        self.modes
    }

    /// Whether site `i` has a resonator that moves.
    pub fn resonator_moves(&self, i: usize) -> bool {
        match self.parts() {
            Some(parts) => parts.sites[i].resonators == Resonators::Moving,
            None => self.layout.resonators(),
        }
    }

    /// Masses of bead `i` and of its resonator; zero for a resonator that does not move.
    pub fn masses(&self, i: usize) -> [R; 2] {
        match self.parts() {
            Some(parts) => [parts.sites[i].mass, parts.sites[i].resonator()],
            None if self.layout.resonators() => [R::one(), R::of(self.params.rho)],
            None => [R::one(), R::zero()],
        }
    }

    /// The contact law; with [`Details`], the law of a contact that has the parameters of the
    /// chain.
    pub fn law(&self) -> ContactLaw<R> {
        self.law
    }

    /// The static overlap of every bond; zero with [`Details`], which have one for each.
    pub fn precompression(&self) -> R {
        self.precompression
    }

    /// The bonds that can ever touch: an outer one can if it joins a wall.
    pub fn touching(&self) -> std::ops::Range<usize> {
        self.topology.touching()
    }

    /// A quantity of the site to the left of a bond minus that of the site to its right; zero for
    /// walls.
    pub fn across(&self, bond: usize, quantity: impl Fn(usize) -> R) -> R {
        self.topology.across(bond, |i| [quantity(i)])[0]
    }

    /// The dead band of overlaps at such positions: 64 roundings of the largest position or, if
    /// larger, of the largest static overlap. Overlaps up to it may be rounding errors. A gap does
    /// not count: where it closes, positions are as large.
    ///
    /// The search for events takes them neither for a contact nor for a gap. Their force is still
    /// computed; it is at most `(1.4e-14 max|u|)^alpha`, for spheres 2e-21 of the force of an
    /// overlap as large as `u`. The tail of a breather, whose overlaps go down to 1e-300, therefore
    /// has no events.
    pub fn dead_band(&self, positions: impl Iterator<Item = R>) -> R {
        let largest = max_norm(positions.map(|u| u.f64())).max(self.largest_rest());
        R::of(64.0 * f64::EPSILON * largest)
    }

    /// The largest static overlap; zero without one.
    pub(crate) fn largest_rest(&self) -> f64 {
        self.parts().map_or(self.precompression.f64(), CheckedDetails::largest_rest)
    }

    /// The overlaps of all bonds at the positions `q` (displacements, or strains on a strain ring).
    ///
    /// Bond `n` lies to the left of site `n`; on a free or walled chain a last bond, `sites`, lies
    /// to the right of the last one. An outer bond without a wall has the overlap `-inf`.
    pub fn overlaps(&self, q: &[R]) -> Vec<R> {
        if let Some(parts) = self.parts() {
            return self.between(q).zip(&parts.bonds).map(|(g, bond)| g + bond.rest).collect();
        }
        if self.topology.strains() { q.iter().map(|&x| -x).collect() } else { self.between(q).collect() }
    }

    /// The overlaps of all bonds from left to right, at these displacements.
    pub(super) fn between<'a>(&self, q: &'a [R]) -> impl Iterator<Item = R> + 'a {
        let (rest, n) = (self.precompression, q.len());
        let (left, right) = self.topology.ghosts(q[0], q[n - 1]);
        // On a ring the bond after the last site is the first bond.
        let last = (!self.topology.ring()).then(|| rest + (q[n - 1] - right));
        let inner = q.windows(2).map(move |pair| rest + (pair[0] - pair[1]));
        std::iter::once(rest + (left - q[0])).chain(inner).chain(last)
    }

    /// The strains of a state: `x_n` on a strain ring, else `x_n = u_n - u_{n-1}` of every bond
    /// that can close, those with walls included. A single free bead has no strain; its
    /// displacement is returned.
    pub fn strains(&self, y: &[R]) -> Vec<R> {
        let u = self.layout.u(y);
        let strains: Vec<R> = match self.boundary() {
            Boundary::StrainRing => u.to_vec(),
            // Static overlaps are in the details, and `between` leaves them out.
            _ if self.details.is_some() => self.between(u).filter(|g| g.is_finite()).map(|g| R::zero() - g).collect(),
            _ => self.overlaps(u).into_iter().filter(|g| g.is_finite()).map(|g| self.precompression - g).collect(),
        };
        if strains.is_empty() { u.to_vec() } else { strains }
    }

    /// The stretches `u_n - v_n` of the springs of resonators, of each site that has one.
    pub fn stretches(&self, y: &[R]) -> Vec<R> {
        let (u, v, parts) = (self.layout.u(y), self.layout.v(y), self.parts());
        let tied = |&n: &usize| match parts {
            Some(parts) => parts.sites[n].resonators != Resonators::None,
            None => self.params.resonators() != Resonators::None,
        };
        (0..u.len()).filter(tied).map(|n| v.map_or(u[n], |v| u[n] - v[n])).collect()
    }

    /// Total momentum `sum u' + rho v'` of a state (eq:Hertz); conserved on a free chain and on a
    /// ring, unless the resonators are fixed.
    pub fn momentum(&self, y: &[R]) -> R {
        let layout = self.layout;
        if let Some(parts) = self.parts() {
            let (u_dot, v_dot) = (layout.u_dot(y), layout.v_dot(y).unwrap_or_default());
            let momentum = |i: usize, site: &details::SiteData<R>| {
                site.mass * u_dot[i] + v_dot.get(i).map_or(R::zero(), |&v_dot| site.resonator() * v_dot)
            };
            return parts.sites.iter().enumerate().fold(R::zero(), |sum, (i, site)| sum + momentum(i, site));
        }
        let sum = |slice: &[R]| slice.iter().fold(R::zero(), |a, &b| a + b);
        let beads = sum(layout.u_dot(y));
        match layout.v_dot(y) {
            Some(v_dot) => beads + R::of(self.params.rho) * sum(v_dot),
            None => beads,
        }
    }
}
