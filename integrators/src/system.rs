//! The interfaces between methods and problems.

use crate::{clock::DoubleDouble, real::Real};

/// A first-order system `y' = f(t, y)`.
pub trait VectorField<R: Real> {
    /// Number of components of `y`.
    fn dim(&self) -> usize;
    /// Writes `f(t, y)` into `dy`; both slices have [`dim`](Self::dim) entries.
    fn eval(&mut self, t: R, y: &[R], dy: &mut [R]);
    /// Times at which the field is not smooth in `t`. Methods that choose their steps end one at
    /// each, and choose the next one as at the start of a run.
    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Adds to a state at time `t` what is known without integration of the time since `start`.
    /// Methods call it for states that they hand out. At [`breaks`](Self::breaks) they go on from
    /// the completed state, with the break as the new `start`.
    fn complete(&self, _start: R, _t: R, _y: &mut [R]) {}
    /// Learns from a method that stops at events that event function `index` is positive from here
    /// on, or no longer. At the start of a run all functions that are positive are told, in the
    /// order of their indices. Returns whether field or state have changed; `y` may change.
    ///
    /// A field that jumps at an event decides by what it was told, not by the sign of a value that
    /// is zero up to rounding: then it is smooth from event to event, ends of steps included.
    fn turn(&mut self, _index: usize, _positive: bool, _y: &mut [R]) -> bool {
        false
    }
}

/// A system split into two exactly solvable flows. It holds its state in variables of its own
/// choice.
///
/// The *drift* is solved exactly for any duration; the *kick* changes momenta by forces that depend
/// on positions only.
pub trait SplitFlow<R: Real> {
    /// Number of components of the state `y`.
    fn dim(&self) -> usize;
    /// Number of components that one thread moves in a kick: all, unless the flow is divided into
    /// parts.
    fn moved(&self) -> usize {
        self.dim()
    }
    /// Sets the state to `y`, at time 0 of the flow.
    fn load(&mut self, y: &[R]);
    /// Writes the state into `y`.
    fn store(&self, y: &mut [R]);
    /// Makes an independent copy.
    fn duplicate(&self) -> Self
    where
        Self: Sized;
    /// Copies the state of `other`, without allocating.
    fn copy_from(&mut self, other: &Self);
    /// The exact flow of the drift over `dt`.
    fn drift(&mut self, dt: DoubleDouble<R>);
    /// The flow of the kick over `kick`, then the drift over `drift`. A flow may do both in one
    /// sweep over the state.
    fn kick_drift(&mut self, kick: R, drift: DoubleDouble<R>);
    /// Kicks and drifts one after the other. A flow may do several in one sweep over the state,
    /// with the same bits.
    fn kick_drifts(&mut self, pairs: &[(R, DoubleDouble<R>)]) {
        pairs.iter().for_each(|&(kick, drift)| self.kick_drift(kick, drift));
    }
}
