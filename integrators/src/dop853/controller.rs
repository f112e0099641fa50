//! The step-size controller: the step to try next, from the error of the last ones.

use super::step::Step;
use crate::{error::Error, real::Real, system::VectorField};

/// Options of an adaptive run. [`new`](Self::new) sets all but the tolerances to their defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<R> {
    /// Relative tolerance of every component.
    pub rtol: R,
    /// Absolute tolerance of every component, in its unit, which is 1 unless the method is told.
    pub atol: R,
    /// First step to try; by default it is estimated from two slopes.
    pub first_step: Option<R>,
    /// Largest number of trial steps, rejected ones included; of `Regularised`, without the trials
    /// that land on an event.
    pub max_steps: u64,
}

impl<R: Real> Options<R> {
    /// Equal relative and absolute tolerance.
    pub fn new(tolerance: R) -> Self {
        Self { rtol: tolerance, atol: tolerance, first_step: None, max_steps: 1_000_000_000 }
    }

    /// Returns the options if each lies in its range. `floor` is the lower bound of the relative
    /// tolerance in unit round-offs, and `rule` is its wording.
    pub(crate) fn checked(self, (floor, rule): (R, &'static str)) -> Result<Self, Error> {
        let positive = |value: R| value.is_finite() && value > R::zero();
        let rules = [
            ("rtol", Some(self.rtol), self.rtol.is_finite() && self.rtol > floor * round_off::<R>(), rule),
            ("atol", Some(self.atol), positive(self.atol), "an absolute tolerance is finite and above zero"),
            ("first_step", self.first_step, self.first_step.is_none_or(positive), "a step is finite and above zero"),
            ("max_steps", Some(R::of(self.max_steps as f64)), self.max_steps > 0, "at least one step"),
        ];
        match rules.into_iter().find(|&(_, _, holds, _)| !holds) {
            Some((name, value, _, rule)) => Err(Error::Argument { name, value: value.map_or(f64::NAN, R::f64), rule }),
            None => Ok(self),
        }
    }
}

/// The unit round-off of the scalar: that of `f64`, or its square for double-double.
///
/// The `Float::epsilon` of double-double is far below its unit round-off.
pub(crate) fn round_off<R: Real>() -> R {
    let plain = R::of(f64::EPSILON);
    if R::decimal("0.1") == R::of(0.1) { plain } else { plain * plain }
}

/// The verdict on a trial step, with the step to try next.
pub(crate) enum StepOutcome<R> {
    Accept(R),
    Reject(R),
}

/// Chooses the next step from the errors of the last trials.
pub(crate) struct Controller<R> {
    safety: R,
    /// Lower and upper bound of `h / h_next`.
    bounds: (R, R),
    max_step: R,
    /// Whether the last trial was rejected.
    rejected: bool,
}

impl<R: Real> Controller<R> {
    pub(crate) fn new(max_step: R) -> Self {
        Self {
            safety: R::decimal("0.9"),
            bounds: (R::of(6.0).recip(), R::decimal("0.333").recip()),
            max_step,
            rejected: false,
        }
    }

    /// Judges a trial of length `h` by the norm of its error, which must be at most 1.
    pub(crate) fn judge(&mut self, h: R, error: R) -> StepOutcome<R> {
        let (growing, shrinking) = self.bounds;
        let ratio = error.powf(R::of(0.125)) / self.safety;
        if error > R::one() {
            self.rejected = true;
            return StepOutcome::Reject(h / shrinking.min(ratio));
        }
        let next = (h / growing.max(shrinking.min(ratio))).min(self.max_step);
        // After a rejection the next step may not be longer.
        let next = if std::mem::take(&mut self.rejected) { next.min(h) } else { next };
        StepOutcome::Accept(next)
    }
}

impl<R: Real> Step<R> {
    /// The first step from `t`, estimated by Hairer and Wanner's rule from the slope there, which
    /// [`begin`](Self::begin) has computed, and from that after an explicit Euler step.
    pub(crate) fn first<F: VectorField<R>>(&mut self, field: &mut F, t: R, rtol: R, max_step: R) -> R {
        let (unit, tiny) = (self.time_unit(), R::decimal("0.000001"));
        let slope = self.norm(rtol, self.slope(0).iter().copied());
        let size = self.norm(rtol, self.state().iter().copied());
        let least = R::decimal("0.0000000001");
        // The Euler step changes the state by about a hundredth.
        let guess = if slope * (unit * unit) <= least || size <= least {
            tiny * unit
        } else {
            (size / slope).sqrt() * R::decimal("0.01")
        };
        let euler = guess.min(max_step);
        self.euler(field, t, euler);
        let change = self.slope(0).iter().zip(self.slope(1)).map(|(&before, &after)| after - before);
        let second = self.norm(rtol, change).sqrt() / euler;
        // The Euler step may leave the domain of the field.
        let second = if second.is_finite() { second } else { R::zero() };
        // `h^8 max(|y'|, |y''|) = 0.01`, with times in their unit.
        let bend = (second * (unit * unit)).max(slope.sqrt() * unit);
        let h = if bend <= R::decimal("0.000000000000001") {
            (tiny * unit).max(euler * R::decimal("0.001"))
        } else {
            (R::decimal("0.01") / bend).powf(R::of(0.125)) * unit
        };
        (R::of(100.0) * euler).min(h).min(max_step)
    }
}
