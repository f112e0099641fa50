//! What a method may ask of a problem.

use crate::{clock::Twofold, real::Real};

/// A first-order system `y' = f(t, y)`.
pub trait VectorField<R: Real> {
    /// Number of components of `y`.
    fn dim(&self) -> usize;
    /// Writes `f(t, y)` into `dy`; both slices have [`dim`](Self::dim) entries.
    fn eval(&mut self, t: R, y: &[R], dy: &mut [R]);
}

/// A system split into two exactly solvable flows, holding its own state in whatever variables suit them.
///
/// The *drift* is solved exactly for any duration; the *kick* changes momenta by forces that depend on positions only.
pub trait SplitFlow<R: Real> {
    /// Number of components of the state as others see it.
    fn dim(&self) -> usize;
    /// Takes over the state `y` at time 0 of the flow.
    fn load(&mut self, y: &[R]);
    /// Writes the state as others see it.
    fn store(&self, y: &mut [R]);
    /// An independent copy.
    fn duplicate(&self) -> Self
    where
        Self: Sized;
    /// Takes over the state of `other`, without allocating.
    fn copy_from(&mut self, other: &Self);
    /// The exact flow of the drift over `dt`.
    fn drift(&mut self, dt: Twofold<R>);
    /// The flow of the kick over `kick`, then the drift over `drift`: one sweep over the state where that is faster.
    fn kick_drift(&mut self, kick: R, drift: Twofold<R>);
}

/// A split system whose forces act in bonds: each depends on one overlap only.
pub trait ContactFlow<R: Real>: SplitFlow<R> {
    /// Number of bonds that can ever touch.
    fn bonds(&self) -> usize;
    /// Writes overlap and rate of each bond, now, and returns the dead band: overlaps up to it are rounding.
    fn overlaps(&self, overlaps: &mut [R], rates: &mut [R]) -> R;
}

/// A split system that can average its kick over a window of time.
pub trait PathFlow<R: Real>: SplitFlow<R> {
    /// The kick whose Hamiltonian is the potential integrated along the drift from `window.0` to `window.1`, two times relative to
    /// now (backwards if they descend), by the implicit midpoint rule; then the drift over `drift`.
    ///
    /// Symplectic, and undone by the same kick with the window reversed. Where the potential is zero, it does nothing.
    fn averaged_kick_drift(&mut self, window: (R, R), drift: Twofold<R>);
}
