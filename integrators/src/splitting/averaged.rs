//! Kicks that average the force over a window of time, so that short contacts are not missed.

use crate::{
    clock::Twofold,
    real::Real,
    system::{PathFlow, SplitFlow},
};

/// A flow whose kicks integrate the forces along the drift, for use with
/// [`Splitting`](super::Splitting).
///
/// The kick with share `b_i` acts at the time `c_i`, the sum of the drifts before it. Relative to
/// that time its window is `[B_{i-1} - c_i, B_i - c_i] h`, with `B_i` the sum of the first `i`
/// kicks: the windows tile the step. Such a kick is a symmetric step of order 2 for any drifts. A
/// scheme therefore keeps its order if it is a composition of Strang steps, drift first; other
/// schemes have order 2. Forces `(g)_+^alpha` lower the order to `alpha + 1` with sampled kicks and
/// to `alpha + 2` with averaged kicks.
///
/// The windows follow from the calls: a window begins at the sum of the kicks so far, relative to
/// the sum of the drifts so far.
pub struct Averaged<R, S> {
    flow: S,
    /// Sum of the kicks so far minus sum of the drifts so far, as a time.
    ahead: Twofold<R>,
}

impl<R: Real, S: PathFlow<R>> Averaged<R, S> {
    /// Wraps `flow` at the start of a step.
    pub fn new(flow: S) -> Self {
        Self { flow, ahead: Twofold::zero() }
    }

    fn pass(&mut self, dt: Twofold<R>) {
        self.ahead = self.ahead - dt;
        // At the end of a step only rounding errors remain; they are removed so that they do not
        // add up.
        if self.ahead.value().abs() <= R::of(1e-10) * dt.value().abs() {
            self.ahead = Twofold::zero();
        }
    }
}

impl<R: Real, S: PathFlow<R>> SplitFlow<R> for Averaged<R, S> {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn load(&mut self, y: &[R]) {
        self.flow.load(y);
        self.ahead = Twofold::zero();
    }

    fn store(&self, y: &mut [R]) {
        self.flow.store(y);
    }

    fn duplicate(&self) -> Self {
        Self { flow: self.flow.duplicate(), ahead: self.ahead }
    }

    fn copy_from(&mut self, other: &Self) {
        self.flow.copy_from(&other.flow);
        self.ahead = other.ahead;
    }

    fn drift(&mut self, dt: Twofold<R>) {
        self.flow.drift(dt);
        self.pass(dt);
    }

    fn kick_drift(&mut self, kick: R, drift: Twofold<R>) {
        let after = self.ahead + Twofold::new(kick);
        self.flow.averaged_kick_drift((self.ahead.value(), after.value()), drift);
        self.ahead = after;
        self.pass(drift);
    }
}
