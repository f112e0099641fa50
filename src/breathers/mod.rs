//! Breathers: so far the trivial ones, whose beads never touch.

mod trivial;

pub use trivial::TrivialBreather;
