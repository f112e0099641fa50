//! Breathers: trivial ones without contact force, long-lived bright ones, which are approximate,
//! and dark ones, which are exact.

mod bright;
mod dark;
mod trivial;

pub use bright::{BrightBreather, Norms};
pub use dark::DarkBreather;
pub use trivial::{ClosedForm, TrivialBreather};
