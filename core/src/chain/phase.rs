//! The phase `theta = omega t` of all resonators, and its sine and cosine.
//!
//! A run repeats a few drifts over and over. Sine and cosine are then turned by a stored rotation
//! with twice the working precision. `k` rotations leave an error of about `k 10^-32`: below one
//! rounding for 10^15 of them.

use hertzchain_integrators::{DoubleDouble, Real, Rotation, kernel};

/// Largest number of drifts whose rotations are kept, enough for those that a scheme repeats. A run
/// that lands on contacts has ever new drifts; for drifts beyond this number, sine and cosine are
/// computed anew.
const KEPT: usize = 16;

/// The phase of a chain.
pub(crate) struct Phase<R> {
    pub(crate) omega: DoubleDouble<R>,
    two_pi: DoubleDouble<R>,
    /// The phase at the last count; `turns` holds the drifts since.
    theta: DoubleDouble<R>,
    now: Rotation<R>,
    turns: Vec<Turn<R>>,
    /// Index in `turns` at which the next drift is expected.
    next: usize,
}

/// A drift, the angle by which it turns the phase, and how many times it was made since the last
/// count.
#[derive(Clone)]
struct Turn<R> {
    drift: DoubleDouble<R>,
    angle: DoubleDouble<R>,
    rotation: Rotation<R>,
    count: u64,
}

impl<R: Real> Phase<R> {
    pub(crate) fn new(omega: DoubleDouble<R>) -> Self {
        let turns = Vec::with_capacity(KEPT);
        Self {
            omega,
            two_pi: DoubleDouble::two_pi(),
            theta: DoubleDouble::zero(),
            now: Rotation::none(),
            turns,
            next: 0,
        }
    }

    /// Sets the phase to zero.
    pub(crate) fn reset(&mut self) {
        self.theta = DoubleDouble::zero();
        self.now = Rotation::none();
        self.turns.iter_mut().for_each(|turn| turn.count = 0);
    }

    /// Sets the phase to that of another.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.reset();
        (self.theta, self.now) = (other.theta(), other.now);
    }

    /// `(sin theta, cos theta)`.
    #[inline]
    pub(crate) fn sin_cos(&self) -> (R, R) {
        self.now.sin_cos()
    }

    /// The phase, reduced.
    fn theta(&self) -> DoubleDouble<R> {
        let turned = |theta, turn: &Turn<R>| theta + turn.angle * DoubleDouble::new(R::of(turn.count as f64));
        self.turns.iter().filter(|turn| turn.count > 0).fold(self.theta, turned).reduced(self.two_pi)
    }

    /// Moves the phase on by the time `dt`, with the fused products of the machine.
    #[inline]
    pub(crate) fn advance(&mut self, dt: DoubleDouble<R>) {
        R::run(kernel!(self.advance_inside(dt)));
    }

    /// As [`advance`](Self::advance), inside a kernel: with the fused products that the kernel is
    /// compiled for.
    #[inline(always)]
    pub(crate) fn advance_inside(&mut self, dt: DoubleDouble<R>) {
        match self.turn(dt) {
            Some(k) => {
                let turn = &mut self.turns[k];
                turn.count += 1;
                self.next = k + 1;
                self.now = self.now.then(&turn.rotation);
            }
            None => self.turn_anew(dt),
        }
    }

    /// Index of the kept turn with this drift.
    #[inline(always)]
    fn turn(&self, drift: DoubleDouble<R>) -> Option<usize> {
        let here = if self.next < self.turns.len() { self.next } else { 0 };
        match self.turns.get(here) {
            Some(turn) if turn.drift == drift => Some(here),
            _ => self.turns.iter().position(|turn| turn.drift == drift),
        }
    }

    #[cold]
    fn turn_anew(&mut self, drift: DoubleDouble<R>) {
        let angle = self.omega * drift;
        if self.turns.len() < KEPT {
            let rotation = Rotation::by(angle.reduced(self.two_pi));
            self.turns.push(Turn { drift, angle, rotation, count: 1 });
            self.now = self.now.then(&rotation);
        } else {
            self.theta = (self.theta() + angle).reduced(self.two_pi);
            self.turns.iter_mut().for_each(|turn| turn.count = 0);
            let (sin, cos) = self.theta.sin_cos();
            self.now = Rotation { sin: DoubleDouble::new(sin), cos: DoubleDouble::new(cos) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_rotations_are_one() {
        // Truth: the phase itself to twice the precision, and its sine and cosine.
        let omega = DoubleDouble::<f64>::new(1.3).sqrt();
        let mut phase = Phase::new(omega);
        let drifts = [0.0123, -0.004, 0.02].map(|dt| DoubleDouble::new(dt).over(DoubleDouble::new(3.0)));
        for k in 0..1_000_000 {
            phase.advance(drifts[k % 3]);
        }
        let count = |k: usize| DoubleDouble::new(((1_000_000 + 2 - k) / 3) as f64);
        let time = (0..3).fold(DoubleDouble::zero(), |sum, k| sum + drifts[k] * count(k));
        let theta = (omega * time).reduced(DoubleDouble::two_pi());
        let (sin, cos) = theta.sin_cos();
        let (s, c) = phase.sin_cos();
        assert!((s - sin).abs() < 2e-16 && (c - cos).abs() < 2e-16, "{:e} {:e}", s - sin, c - cos);
        // Measured: 1.3e-28 and 1.8e-27.
        assert!((phase.theta() - theta).hi.abs() < 3e-28);
        let size = phase.now.sin * phase.now.sin + phase.now.cos * phase.now.cos - DoubleDouble::new(1.0);
        assert!(size.hi.abs() < 4e-27, "{size:?}");
        // Its copy, and drifts that are not kept, go on from there.
        let mut copy = Phase::new(omega);
        copy.copy_from(&phase);
        for k in 0..40 {
            copy.advance(DoubleDouble::new(0.001 * f64::from(k)));
        }
        let theta = (theta + omega * DoubleDouble::new(0.78)).reduced(DoubleDouble::two_pi());
        let ((sin, cos), (s, c)) = (theta.sin_cos(), copy.sin_cos());
        assert!((s - sin).abs() < 2e-16 && (c - cos).abs() < 2e-16, "{:e} {:e}", s - sin, c - cos);
    }
}
