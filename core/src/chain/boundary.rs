//! What holds the ends of the chain.

use hertzchain_integrators::Real;
use serde::{Deserialize, Serialize};

/// The boundary condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// Nothing beyond the ends.
    Free,
    /// A fixed wall at either end, just touching at rest.
    Fixed,
    /// The last bead touches the first: `u_{n+N} = u_n`.
    Ring,
    /// Strains as unknowns, `x_{n+N} = x_n` (eq:HertzS). Their mean is free, so this is *not* a displacement chain on a ring.
    StrainRing,
}

impl Boundary {
    /// The positions beyond the two ends, from those at the ends. An infinite one never touches.
    #[inline(always)]
    pub fn ghosts<R: Real>(self, first: R, last: R) -> (R, R) {
        match self {
            Self::Free => (R::neg_infinity(), R::infinity()),
            Self::Fixed => (R::zero(), R::zero()),
            Self::Ring | Self::StrainRing => (last, first),
        }
    }
}
