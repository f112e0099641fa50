//! The boundary conditions of the chain.

use serde::{Deserialize, Serialize};
use std::fmt;

/// The boundary condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Boundary {
    /// Nothing beyond the ends.
    Free,
    /// A fixed wall at either end, just touching at rest.
    Fixed,
    /// A fixed wall before the first bead, just touching at rest; nothing beyond the last.
    LeftWall,
    /// A fixed wall after the last bead, just touching at rest; nothing beyond the first.
    RightWall,
    /// The last bead touches the first: `u_{n+N} = u_n`.
    Ring,
    /// Strains as unknowns, `x_{n+N} = x_n` (eq:HertzS). Their mean is free, so this is *not* a
    /// displacement chain on a ring.
    // Commands that take a boundary take a chain of displacements.
    #[cfg_attr(feature = "cli", value(skip))]
    StrainRing,
}

impl Boundary {
    /// All boundary conditions.
    pub const ALL: [Self; 6] = [Self::Free, Self::Fixed, Self::Ring, Self::StrainRing, Self::LeftWall, Self::RightWall];

    /// Whether there is a wall before the first bead, and one after the last.
    #[inline(always)]
    pub fn walls(self) -> [bool; 2] {
        match self {
            Self::Fixed => [true; 2],
            Self::LeftWall => [true, false],
            Self::RightWall => [false, true],
            Self::Free | Self::Ring | Self::StrainRing => [false; 2],
        }
    }
}

/// As scenes spell it.
impl fmt::Display for Boundary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}
