//! Breathers: the trivial ones, whose beads never touch, and long-lived bright ones, which are nearly solutions.

mod bright;
mod trivial;

pub use bright::{BrightBreather, Norms};
pub use trivial::TrivialBreather;
