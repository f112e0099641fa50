//! Splitting schemes: const data, and the loop that runs them.
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_i`, `b_i` | shares of the step given to the i-th drift and the i-th kick |
//! | `gamma_i` | shares given to the Strang steps of a symmetric composition |
//!
//! Every scheme is converted to pairs (kick, drift). Where two steps meet, the last pair of one and
//! the first pair of the next are merged. A drift-first scheme with s kicks therefore costs s
//! sweeps a step; a kick-first scheme costs one sweep less than it has kicks.
//!
//! [`Splitting`] steps across contacts, and [`Corrected`] adds corrections at contacts that begin or
//! end.

pub mod corrected;
mod scheme;
mod stepper;
pub(crate) mod steps;
pub mod tables;

pub use corrected::{Corrected, Parts, hurwitz};
pub use scheme::{Coefficients, First, Scheme};
pub use stepper::Splitting;
