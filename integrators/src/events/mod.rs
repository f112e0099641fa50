//! Events: instants at which a scalar function of time and state changes its sign.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g_i(t, y)` | event functions; for a chain, the overlap of bond `i` |
//! | *side* | the sign that `g_i` had when it last left its band; it is stored, not recomputed |
//! | *band* | values `|g_i| <= band` may be rounding errors |
//!
//! An event is a change of side. It happens when `g_i` leaves the band on the other side; its time
//! is the last zero of `g_i` before that. This rule covers the special cases:
//!
//! | case | what happens |
//! |---|---|
//! | starts at zero, moving | an event at the start if it becomes positive; none if negative |
//! | starts at zero, at rest | no event until it leaves the band; then an event at its last zero |
//! | identically zero | no event |
//! | two roots inside a step | both are found: the search is that of a polynomial over the step |
//! | grazing (double root) | two events if the band is left on the other side, otherwise none |
//! | event at the end of a step | belongs to the step that leaves the band; its time is that end |
//! | simultaneous events | each is an event; events within rounding may come in any order |
//!
//! The tail of a breather holds overlaps down to 1e-300 and below, which do not change a bit of the
//! state. Without the band their changes of sign, which are rounding errors, would be events.

pub(crate) mod bernstein;
mod curve;
pub(crate) mod root;
pub(crate) mod sides;
mod watch;

pub use bernstein::{NODES, SHARES};
pub use curve::Curve;
pub use root::bracketed;
pub use watch::{Events, Listener, Part, Search, Searched, Watch, parts};

use crate::real::Real;

/// A change of side of an event function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event<R> {
    /// Index of the function.
    pub index: usize,
    /// Whether the function changes from negative to positive.
    pub rising: bool,
    /// Time.
    pub t: R,
}

/// Scalar functions of time and state whose changes of sign are events.
pub trait EventFunctions<R: Real> {
    /// Number of functions.
    fn count(&self) -> usize;
    /// Writes `g_i(t, y)`.
    fn values(&self, t: R, y: &[R], g: &mut [R]);
    /// Writes `d/dt g_i(t, y(t))` for a solution with `y' = dy`.
    fn rates(&self, t: R, y: &[R], dy: &[R], rates: &mut [R]);
    /// The dead band: values `|g_i|` up to this may be rounding errors of a state of this size.
    fn band(&self, y: &[R]) -> R;
    /// Whether the field begins and ends like a power at each event of function `index`, and not
    /// only where the function is positive.
    fn kinks(&self, _index: usize) -> bool {
        false
    }
    /// Whether the field goes by the signs that it is told ([`VectorField::turn`]), so that a sign
    /// that is wrong for a few steps is an error of the state. Then values inside the band at the
    /// start count as positive, until they are negative by more than the error of a step; and an
    /// event is taken back if its function goes away from zero on the side on which it was. A field
    /// that ignores [`VectorField::turn`] may say false: then a false event costs steps only.
    ///
    /// [`VectorField::turn`]: crate::VectorField::turn
    fn told(&self) -> bool {
        true
    }
}
