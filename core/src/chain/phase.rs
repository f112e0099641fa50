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
pub struct Phase<R> {
    omega: DoubleDouble<R>,
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
struct Turn<R> {
    drift: DoubleDouble<R>,
    angle: DoubleDouble<R>,
    rotation: Rotation<R>,
    count: u64,
}

impl<R: Real> Phase<R> {
    /// The phase zero, that turns with `omega`.
    pub fn new(omega: DoubleDouble<R>) -> Self {
        let (theta, now) = (DoubleDouble::zero(), Rotation::none());
        Self { omega, two_pi: DoubleDouble::two_pi(), theta, now, turns: Vec::with_capacity(KEPT), next: 0 }
    }

    #[inline(always)]
    pub(crate) fn omega(&self) -> R {
        self.omega.hi
    }

    /// Sets the phase to zero.
    pub(crate) fn reset(&mut self) {
        (self.theta, self.now) = (DoubleDouble::zero(), Rotation::none());
        self.turns.iter_mut().for_each(|turn| turn.count = 0);
    }

    /// Sets the phase to that of another.
    pub fn copy_from(&mut self, other: &Self) {
        self.reset();
        (self.theta, self.now) = (other.theta(), other.now);
    }

    /// `(sin theta, cos theta)`.
    #[inline]
    pub fn sin_cos(&self) -> (R, R) {
        self.now.sin_cos()
    }

    /// The phase, reduced.
    pub fn theta(&self) -> DoubleDouble<R> {
        let turned = |theta, turn: &Turn<R>| theta + turn.angle * DoubleDouble::new(R::of(turn.count as f64));
        self.turns.iter().filter(|turn| turn.count > 0).fold(self.theta, turned).reduced(self.two_pi)
    }

    /// Moves the phase on by the time `dt`, with the fused products of the machine.
    #[inline]
    pub fn advance(&mut self, dt: DoubleDouble<R>) {
        R::run(kernel!(self.advance_inside(dt)));
    }

    /// As [`advance`](Self::advance), inside a kernel: with the fused products that the kernel is
    /// compiled for.
    #[inline(always)]
    pub(crate) fn advance_inside(&mut self, dt: DoubleDouble<R>) {
        let known = self.turn(dt);
        let Some(k) = (if known.is_some() { known } else { self.turn_anew(dt) }) else { return };
        let turn = &mut self.turns[k];
        turn.count += 1;
        self.next = k + 1;
        self.now = self.now.then(&turn.rotation);
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

    /// Index of a new turn with this drift; `None` if there is no room for it, after the drift.
    #[cold]
    fn turn_anew(&mut self, drift: DoubleDouble<R>) -> Option<usize> {
        let angle = self.omega * drift;
        if self.turns.len() < KEPT {
            let rotation = Rotation::by(angle.reduced(self.two_pi));
            self.turns.push(Turn { drift, angle, rotation, count: 0 });
            return Some(self.turns.len() - 1);
        }
        let theta = (self.theta() + angle).reduced(self.two_pi);
        self.reset();
        let (sin, cos) = theta.sin_cos();
        (self.theta, self.now) = (theta, Rotation { sin: DoubleDouble::new(sin), cos: DoubleDouble::new(cos) });
        None
    }
}
