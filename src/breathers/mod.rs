//! Breathers: the trivial ones, whose beads never touch; long-lived bright ones, which are nearly solutions; dark ones, which are exact.

mod bright;
mod dark;
mod trivial;

pub use bright::{BrightBreather, Norms};
pub use dark::DarkBreather;
pub use trivial::{ClosedForm, TrivialBreather};
