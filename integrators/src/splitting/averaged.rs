//! Kicks that average the force over a window of time: no contact begins or ends unseen.

use crate::{
    clock::Twofold,
    real::Real,
    system::{PathFlow, SplitFlow},
};

/// A flow whose kicks integrate the forces along the drift instead of sampling them, under [`Splitting`](super::Splitting).
///
/// The kick with share `b_i` acts at the time `c_i`, the sum of the drifts before it. Its window is
/// `[B_{i-1} - c_i, B_i - c_i] h` relative to that, with `B_i` the sum of the first `i` kicks: the windows tile the step.
/// Such a kick is a symmetric step of order 2 whatever the drifts are, so that a scheme keeps its order if it is a
/// composition of Strang steps, drift first; any other has order 2. Forces `(g)_+^alpha` lower the order of a scheme with
/// sampled kicks to `alpha + 1`, of one with averaged kicks to `alpha + 2`.
///
/// It finds the windows by itself: a window begins where the kicks so far end, seen from where the drifts so far end.
pub struct Averaged<R, S> {
    flow: S,
    /// Kicks so far less drifts so far, in time.
    ahead: Twofold<R>,
}

impl<R: Real, S: PathFlow<R>> Averaged<R, S> {
    /// The flow at the start of a step.
    pub fn new(flow: S) -> Self {
        Self { flow, ahead: Twofold::zero() }
    }

    fn pass(&mut self, dt: Twofold<R>) {
        self.ahead = self.ahead - dt;
        // Nothing is left at a step's end but rounding, which must not add up.
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
