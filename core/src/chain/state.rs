//! A state as a structure of arrays in one piece of memory.

use super::{Chain, Layout};
use crate::error::{Error, Result};
use hertzchain_integrators::Real;

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
        let n = self.layout.sites();
        &mut self.y[..n]
    }

    /// Velocities of the beads, to be changed.
    pub fn u_dot_mut(&mut self) -> &mut [R] {
        let (n, half) = (self.layout.sites(), self.layout.half());
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
