//! The chain, and the one door to every method.
//!
//! | module | what it holds |
//! |---|---|
//! | [`chain`] | parameters, boundary, contact law, state, energy, and the two splittings |
//! | [`run`] | a chain, a state, a span, a method: what they leave behind; the integrators by name |
//! | [`error`] | the one error type |
//! | [`interrupt`] | whether the process was asked to end |
//!
//! It is a package of its own for the sake of the build: what must be fast is compiled at full optimisation here, and the studies above, in which
//! nobody waits, in a fraction of the time. `hertzchain` has all of it under the same names.

pub mod chain;
pub mod error;
pub mod interrupt;
pub mod run;

pub use chain::{Boundary, Chain, Params, State};
pub use error::{Error, Result};
pub use hertzchain_integrators as integrators;
pub use run::{Method, Run, Setting, Trajectory};
