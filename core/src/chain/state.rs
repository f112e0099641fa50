//! A state as a structure of arrays in one piece of memory.

use super::{Chain, details::LEDGER};
use crate::error::{Error, Result};
use hertzchain_integrators::Real;

/// The places of the arrays of a state: `[u, v, u', v']`, or `[u, u']` without moving resonators.
///
/// On a strain ring read `x, y` for `u, v`. Velocities, not momenta: `p_u = u'`, `p_v = rho v'`.
/// The state of a chain that dissipates or is driven ends with its [`Ledger`](super::Ledger).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    sites: usize,
    resonators: bool,
    ledger: bool,
}

impl Layout {
    pub(crate) fn new(sites: usize, resonators: bool) -> Self {
        Self { sites, resonators, ledger: false }
    }

    pub(crate) fn with_ledger(self, ledger: bool) -> Self {
        Self { ledger, ..self }
    }

    /// Whether a state has a ledger at its end.
    pub fn has_ledger(self) -> bool {
        self.ledger
    }

    /// Number of positions, which is also the number of velocities.
    pub fn half(self) -> usize {
        if self.resonators { 2 * self.sites } else { self.sites }
    }

    /// Number of sites.
    pub fn sites(self) -> usize {
        self.sites
    }

    /// Whether resonators move.
    pub fn resonators(self) -> bool {
        self.resonators
    }

    /// Number of entries of a state.
    pub fn dim(self) -> usize {
        2 * self.half() + if self.ledger { LEDGER } else { 0 }
    }

    /// Displacements of the beads (strains, on a strain ring).
    pub fn u<R>(self, y: &[R]) -> &[R] {
        &y[..self.sites]
    }

    /// Displacements of the resonators, if they move.
    pub fn v<R>(self, y: &[R]) -> Option<&[R]> {
        self.resonators.then(|| &y[self.sites..2 * self.sites])
    }

    /// Velocities of the beads.
    pub fn u_dot<R>(self, y: &[R]) -> &[R] {
        let start = self.half();
        &y[start..start + self.sites]
    }

    /// Velocities of the resonators, if they move.
    pub fn v_dot<R>(self, y: &[R]) -> Option<&[R]> {
        self.resonators.then(|| &y[3 * self.sites..4 * self.sites])
    }

    /// The arrays `[u, v, u', v']`; `v` and `v'` are empty unless resonators move.
    pub fn arrays<R>(self, y: &[R]) -> [&[R]; 4] {
        let none = &y[..0];
        [self.u(y), self.v(y).unwrap_or(none), self.u_dot(y), self.v_dot(y).unwrap_or(none)]
    }

    /// Index in the whole state of a site's entry in the array `[u, v, u', v'][array]`.
    pub fn entry(self, array: usize, site: usize) -> usize {
        [0, self.sites, self.half(), self.half() + self.sites][array] + site
    }

    /// The arrays `[u, v, u', v']`, to be changed.
    pub fn arrays_mut<R>(self, y: &mut [R]) -> [&mut [R]; 4] {
        let (positions, velocities) = y.split_at_mut(self.dim() / 2);
        let ((u, v), (u_dot, v_dot)) = (positions.split_at_mut(self.sites), velocities.split_at_mut(self.sites));
        [u, v, u_dot, v_dot]
    }
}

/// `max |y_i|`; NaN entries are left out.
pub fn max_norm(y: impl IntoIterator<Item = f64>) -> f64 {
    y.into_iter().fold(0.0, |largest, value| value.abs().max(largest))
}

/// A state of a chain.
#[derive(Clone, Debug, PartialEq)]
pub struct State<R> {
    layout: Layout,
    y: Vec<R>,
}

impl<R: Real> State<R> {
    /// The chain at rest.
    pub fn rest(chain: &Chain<R>) -> Self {
        Self { layout: chain.layout(), y: vec![R::zero(); chain.layout().dim()] }
    }

    /// A state from its sites; `v` and `v_dot` of a site are left out where no resonator moves.
    ///
    /// # Errors
    /// A value that is not finite, by name and site.
    pub fn from_fn(chain: &Chain<R>, mut site: impl FnMut(usize) -> Site<R>) -> Result<Self> {
        let mut state = Self::rest(chain);
        let (n, half) = (chain.sites(), chain.layout().half());
        for i in 0..n {
            let site = site(i);
            for (name, value) in [("u", site.u), ("v", site.v), ("u'", site.u_dot), ("v'", site.v_dot)] {
                if !value.is_finite() {
                    return Err(Error::parameter(name, format!("{value} at site {i}"), "a state is finite"));
                }
            }
            state.y[i] = site.u;
            state.y[half + i] = site.u_dot;
            if chain.resonator_moves(i) {
                state.y[n + i] = site.v;
                state.y[half + n + i] = site.v_dot;
            }
        }
        Ok(state)
    }

    /// The state in which the beads that drives move have the position and velocity of their drive
    /// at time 0.
    #[must_use]
    pub fn driven(self, chain: &Chain<R>) -> Self {
        self.driven_at(chain, R::zero())
    }

    /// As [`driven`](Self::driven), at time `t`.
    #[must_use]
    pub fn driven_at(mut self, chain: &Chain<R>, t: R) -> Self {
        chain.follow(t, &mut self.y);
        self
    }

    /// The layout.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Displacements of the beads (strains, on a strain ring).
    pub fn u(&self) -> &[R] {
        self.layout.u(&self.y)
    }

    /// Displacements of the resonators, if they move.
    pub fn v(&self) -> Option<&[R]> {
        self.layout.v(&self.y)
    }

    /// Velocities of the beads.
    pub fn u_dot(&self) -> &[R] {
        self.layout.u_dot(&self.y)
    }

    /// Velocities of the resonators, if they move.
    pub fn v_dot(&self) -> Option<&[R]> {
        self.layout.v_dot(&self.y)
    }

    /// Displacements of the beads, to be changed.
    pub fn u_mut(&mut self) -> &mut [R] {
        let n = self.layout.sites;
        &mut self.y[..n]
    }

    /// Velocities of the beads, to be changed.
    pub fn u_dot_mut(&mut self) -> &mut [R] {
        let (n, half) = (self.layout.sites, self.layout.half());
        &mut self.y[half..half + n]
    }

    /// All entries.
    pub fn as_slice(&self) -> &[R] {
        &self.y
    }

    /// All entries, to be changed.
    pub fn as_mut_slice(&mut self) -> &mut [R] {
        &mut self.y
    }
}

/// One site of a state: `u, v, u', v'` (or `x, y, x', y'`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site<R> {
    /// Bead.
    pub u: R,
    /// Resonator.
    pub v: R,
    /// Velocity of the bead.
    pub u_dot: R,
    /// Velocity of the resonator.
    pub v_dot: R,
}
