//! Events: instants at which a scalar function of time and state changes its sign.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g_i(t, y)` | event functions; for a chain, the overlap of bond `i` |
//! | *side* | the sign that `g_i` had when it last left its band: remembered, not recomputed |
//! | *band* | values `|g_i| <= band` say nothing: rounding alone makes them |
//!
//! An event is a change of side. It happens when `g_i` leaves the band on the other side, and its time is the last zero of
//! `g_i` before that. From this one rule follows what happens in every odd case:
//!
//! | case | what happens |
//! |---|---|
//! | starts on its surface, moving | an event at the start if it moves to the positive side; to the negative side, none |
//! | starts on its surface, at rest | nothing until it leaves the band; then an event at its last zero |
//! | identically zero | no event, ever |
//! | two roots inside a step | both are found: a step is searched as a polynomial, not by its ends |
//! | grazing (double root) | an event only if the far side of the band is reached, and then two |
//! | event on a step's end | belongs to the step in which the band is left; its time is the step's end |
//! | ties | every one is an event; within rounding their order says nothing |
//!
//! Why the band: the tail of a breather holds overlaps down to 1e-300 and beyond. Nothing that they do changes a bit of the
//! state, but a search for their zeros would never end.

mod bernstein;
mod linear_path;
pub(crate) mod root;
pub(crate) mod sides;
mod watch;

pub use bernstein::Polynomial;
pub use linear_path::LinearPath;
pub use watch::{Listener, Part, Watch};

use crate::real::Real;

/// A change of side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event<R> {
    /// Index of the function.
    pub index: usize,
    /// From negative to positive.
    pub rising: bool,
    /// Time.
    pub t: R,
}

/// Scalar functions of time and state whose changes of sign are events.
pub trait EventFunctions<R: Real> {
    /// How many.
    fn count(&self) -> usize;
    /// Writes `g_i(t, y)`.
    fn values(&self, t: R, y: &[R], g: &mut [R]);
    /// Writes `d/dt g_i(t, y(t))` for a solution with `y' = dy`.
    fn rates(&self, t: R, y: &[R], dy: &[R], rates: &mut [R]);
    /// The dead band: `|g_i|` up to this is rounding of a state of this size.
    fn band(&self, y: &[R]) -> R;
}
