//! Nonlinear waves in locally resonant Hertzian chains.
//!
//! Beads push each other only while in contact, with force (overlap)_+^alpha, and each may carry a linear resonator
//! (Liu, James, Kevrekidis, Vainchtein, *Nonlinear waves in a strongly nonlinear resonant granular chain*; equation
//! labels in this documentation are those of that paper).
//!
//! | module | what it holds |
//! |---|---|
//! | [`chain`] | parameters, boundary, contact law, energy, and the two splittings |
//! | [`error`] | the one error type |

pub mod chain;
pub mod error;

pub use error::{Error, Result};
pub use hertzchain_integrators as integrators;
