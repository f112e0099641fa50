//! Solutions of the chain, computed as such: periodic orbits, waves and breathers, with their
//! stability and their branches.
//!
//! | module | contents |
//! |---|---|
//! | [`orbits`] | periodic orbits: shooting, Floquet multipliers, continuation, bifurcations |
//! | [`waves`], [`breathers`] | families of solutions, and where their orbits begin |

pub mod breathers;
pub mod orbits;
pub mod waves;

pub use hertzchain_core::{Error, Params, Result, chain, dps, error, interrupt, numerics, random, run};

use hertzchain_report::{named, output};

/// Kernels that are private otherwise, for the tests of this package: no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::{
        breathers::moving::centre,
        orbits::{
            arclength::{BranchState, FARTHEST, Family, follow, strays},
            eigen::{eigenvalues, solve_quasi_triangular},
        },
        waves::exact::eigen::eigen as complex_eigen,
    };
}
