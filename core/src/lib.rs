//! The chain, and one interface to all methods.
//!
//! | module | what it holds |
//! |---|---|
//! | [`chain`] | parameters, boundary, contact law, state, energy, and the two splittings |
//! | [`dps`] | modulation theory: averages, flows, homoclinics, dark profiles |
//! | [`parts`] | one long chain in parts, which threads move |
//! | [`run`] | a run: chain, state, span and method, and its result; the integrators by name |
//! | [`error`] | the error type |
//! | [`interrupt`] | the flag that asks the process to end |
//! | [`numerics`] | lines and planes through points, bisection, golden sections, extremes |
//! | [`plain`] | plain loops over bonds and sites, as a yardstick |
//! | [`random`] | pseudo-random numbers from a seed |
//!
//! It is a separate package to keep the build short: the code whose speed matters is compiled here
//! at full optimisation, and the studies in `hertzchain` at a lower level. `hertzchain` exports all
//! of this package under the same names.

pub mod chain;
pub mod dps;
pub mod error;
pub mod numerics;
pub mod parts;
pub mod plain;
pub mod random;
pub mod run;

pub use chain::{Boundary, Chain, Params, State};
pub use error::{Error, Result};
pub use hertzchain_integrators as integrators;
pub use hertzchain_integrators::interrupt;
pub use run::{Method, Run, Setting, Trajectory};

/// Kernels that are private otherwise, for the tests of this package: no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::{
        chain::{bonds::sites_awake, gauss::gauss, phase::Phase},
        dps::hypergeometric::{BasePoint, Hypergeometric, Parameters},
    };
}
