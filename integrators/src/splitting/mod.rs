//! Splitting schemes: const data, and one loop that runs them all.
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_i`, `b_i` | shares of the step given to the i-th drift and the i-th kick |
//! | `gamma_i` | shares given to the Strang steps of a symmetric composition |
//!
//! Every scheme is turned into pairs (kick, drift). Where two steps meet, the last pair of one and the first of the next
//! are merged, so that a drift-first scheme with s kicks costs s sweeps a step, and one that kicks first costs one less
//! than it has kicks.
//!
//! [`Splitting`] steps across contacts, [`Landed`] ends steps on them, and [`Averaged`] is a flow whose kicks integrate
//! the force instead of sampling it.

mod averaged;
pub mod corrected;
mod landed;
mod scheme;
mod stepper;
pub mod tables;

pub use averaged::Averaged;
pub use corrected::{Corrected, Parts, hurwitz};
pub use landed::Landed;
pub use scheme::{Coefficients, First, Scheme};
pub use stepper::Splitting;
