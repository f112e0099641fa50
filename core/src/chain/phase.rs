//! The phase `theta = omega t` of all resonators, and its sine and cosine.
//!
//! A run repeats a few drifts over and over. Sine and cosine are then turned by a stored rotation
//! with twice the working precision. `k` rotations leave an error of about `k 10^-32`: below one
//! rounding for 10^15 of them.

use super::lanes::Coefficient;
use hertzchain_integrators::{DoubleDouble, Real, Rotation, Vector, with_registers};

/// Largest number of drifts whose rotations are kept, enough for those that a scheme repeats. A run
/// that lands on contacts has ever new drifts; for drifts beyond this number, sine and cosine are
/// computed anew.
const KEPT: usize = 16;

/// The phase of a chain, or those of chains abreast.
pub(crate) struct Phase<R, K = R> {
    omega: DoubleDouble<K>,
    two_pi: DoubleDouble<R>,
    /// The phase at the last count; `turns` holds the drifts since.
    theta: DoubleDouble<K>,
    now: Rotation<K>,
    turns: Vec<Turn<K>>,
    /// Index in `turns` at which the next drift is expected.
    next: usize,
}

/// A drift, the angle by which it turns the phase, and how many times it was made since the last
/// count.
struct Turn<K> {
    drift: DoubleDouble<K>,
    angle: DoubleDouble<K>,
    rotation: Rotation<K>,
    count: u64,
}

/// The rotations of all lanes.
fn turned<R: Real, K: Coefficient<R>>(rotation: impl Fn(usize) -> Rotation<R>) -> Rotation<K> {
    let [sin, sin_lo, cos, cos_lo] = K::by_lane(|lane| {
        let Rotation { sin, cos } = rotation(lane);
        [sin.hi, sin.lo, cos.hi, cos.lo]
    });
    Rotation { sin: DoubleDouble { hi: sin, lo: sin_lo }, cos: DoubleDouble { hi: cos, lo: cos_lo } }
}

/// What it is computed with.
#[inline(always)]
fn get<R: Real, K: Coefficient<R>, V: Vector<R>>(Rotation { sin, cos }: Rotation<K>) -> Rotation<K::In<V>> {
    Rotation {
        sin: DoubleDouble { hi: sin.hi.get::<V>(), lo: sin.lo.get::<V>() },
        cos: DoubleDouble { hi: cos.hi.get::<V>(), lo: cos.lo.get::<V>() },
    }
}

impl<R: Real, K: Coefficient<R>> Phase<R, K> {
    pub(crate) fn new(omega: DoubleDouble<K>) -> Self {
        let (theta, now) = (K::twofold(|_| DoubleDouble::zero()), turned(|_| Rotation::none()));
        Self { omega, two_pi: DoubleDouble::two_pi(), theta, now, turns: Vec::with_capacity(KEPT), next: 0 }
    }

    /// `omega` of a lane.
    #[inline(always)]
    pub(crate) fn omega(&self, lane: usize) -> R {
        self.omega.hi.lane(lane)
    }

    /// Sets the phase to zero.
    pub(crate) fn reset(&mut self) {
        self.theta = K::twofold(|_| DoubleDouble::zero());
        self.now = turned(|_| Rotation::none());
        self.turns.iter_mut().for_each(|turn| turn.count = 0);
    }

    /// Sets the phase to that of another.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.reset();
        (self.theta, self.now) = (K::twofold(|lane| other.theta(lane)), other.now);
    }

    /// `(sin theta, cos theta)`.
    #[inline]
    pub(crate) fn sin_cos(&self) -> (K, K) {
        self.now.sin_cos()
    }

    /// The phase of a lane, reduced.
    fn theta(&self, at: usize) -> DoubleDouble<R> {
        let turned =
            |theta, turn: &Turn<K>| theta + K::of_lane(turn.angle, at) * DoubleDouble::new(R::of(turn.count as f64));
        self.turns.iter().filter(|turn| turn.count > 0).fold(K::of_lane(self.theta, at), turned).reduced(self.two_pi)
    }

    /// Moves the phase on by the time `dt`, with the fused products of the machine.
    #[inline]
    pub(crate) fn advance(&mut self, dt: DoubleDouble<K>) {
        with_registers!(V<R> => self.advance_inside::<V<R>>(dt));
    }

    /// As [`advance`](Self::advance), inside a kernel: with the fused products that the kernel is
    /// compiled for.
    #[inline(always)]
    pub(crate) fn advance_inside<V: Vector<R>>(&mut self, dt: DoubleDouble<K>) {
        let known = self.turn(dt);
        let Some(k) = (if known.is_some() { known } else { self.turn_anew(dt) }) else { return };
        let turn = &mut self.turns[k];
        turn.count += 1;
        self.next = k + 1;
        let Rotation { sin, cos } = get::<R, K, V>(self.now).then(&get::<R, K, V>(turn.rotation));
        self.now = Rotation {
            sin: DoubleDouble { hi: K::kept::<V>(sin.hi), lo: K::kept::<V>(sin.lo) },
            cos: DoubleDouble { hi: K::kept::<V>(cos.hi), lo: K::kept::<V>(cos.lo) },
        };
    }

    /// Index of the kept turn with this drift.
    #[inline(always)]
    fn turn(&self, drift: DoubleDouble<K>) -> Option<usize> {
        let here = if self.next < self.turns.len() { self.next } else { 0 };
        match self.turns.get(here) {
            Some(turn) if turn.drift == drift => Some(here),
            _ => self.turns.iter().position(|turn| turn.drift == drift),
        }
    }

    /// Index of a new turn with this drift; `None` if there is no room for it, after the drift.
    #[cold]
    fn turn_anew(&mut self, drift: DoubleDouble<K>) -> Option<usize> {
        let (angle, two_pi) = (|at| K::of_lane(self.omega, at) * K::of_lane(drift, at), self.two_pi);
        if self.turns.len() < KEPT {
            let rotation = turned(|at| Rotation::by(angle(at).reduced(two_pi)));
            self.turns.push(Turn { drift, angle: K::twofold(angle), rotation, count: 0 });
            return Some(self.turns.len() - 1);
        }
        let theta = K::twofold(|at| (self.theta(at) + angle(at)).reduced(two_pi));
        self.reset();
        self.theta = theta;
        self.now = turned(|at| {
            let (sin, cos) = K::of_lane(theta, at).sin_cos();
            Rotation { sin: DoubleDouble::new(sin), cos: DoubleDouble::new(cos) }
        });
        None
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
        assert!((phase.theta(0) - theta).hi.abs() < 3e-28);
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
