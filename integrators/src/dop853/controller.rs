//! The step-size controller: the step to try next, from the error of the last ones.

use super::step::Scale;
use crate::{error::Error, real::Real};

/// Options of an adaptive run. [`new`](Self::new) sets all but the tolerances to their defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<R> {
    /// Relative tolerance of every component.
    pub rtol: R,
    /// Absolute tolerance of every component.
    pub atol: R,
    /// First step to try; by default it is estimated from two slopes.
    pub first_step: Option<R>,
    /// Longest step; by default the whole span.
    pub max_step: Option<R>,
    /// Largest number of trial steps, rejected ones included; of `Regularised`, without the trials
    /// that land on an event.
    pub max_steps: u64,
    /// Stabilisation of the step size (Lund). The default is 0, none; useful values are up to 0.04.
    pub stabilisation: R,
}

impl<R: Real> Options<R> {
    /// Equal relative and absolute tolerance.
    pub fn new(tolerance: R) -> Self {
        Self {
            rtol: tolerance,
            atol: tolerance,
            first_step: None,
            max_step: None,
            max_steps: 1_000_000_000,
            stabilisation: R::zero(),
        }
    }

    /// Returns the options if each lies in its range. `floor` is the lower bound of the relative
    /// tolerance in unit round-offs, and `rule` is its wording.
    pub(crate) fn checked(self, (floor, rule): (R, &'static str)) -> Result<Self, Error> {
        let positive = |value: R| value.is_finite() && value > R::zero();
        let rules = [
            ("rtol", Some(self.rtol), self.rtol.is_finite() && self.rtol > floor * round_off::<R>(), rule),
            ("atol", Some(self.atol), positive(self.atol), "an absolute tolerance is finite and above zero"),
            ("first_step", self.first_step, self.first_step.is_none_or(positive), "a step is finite and above zero"),
            ("max_step", self.max_step, self.max_step.is_none_or(positive), "a step is finite and above zero"),
            ("max_steps", Some(R::of(self.max_steps as f64)), self.max_steps > 0, "at least one step"),
            (
                "stabilisation",
                Some(self.stabilisation),
                self.stabilisation >= R::zero() && self.stabilisation <= R::decimal("0.2"),
                "the stabilisation lies in [0, 0.2]",
            ),
        ];
        match rules.into_iter().find(|&(_, _, holds, _)| !holds) {
            Some((name, value, _, rule)) => Err(Error::Argument { name, value: value.map_or(f64::NAN, R::f64), rule }),
            None => Ok(self),
        }
    }

    pub(crate) fn scale(&self) -> Scale<R> {
        Scale { atol: self.atol, rtol: self.rtol }
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
    exponent: R,
    stabilisation: R,
    max_step: R,
    /// Error of the last accepted step, at least `floor`.
    memory: R,
    floor: R,
    /// Whether the last trial was rejected.
    rejected: bool,
}

impl<R: Real> Controller<R> {
    pub(crate) fn new(options: &Options<R>, span: R) -> Self {
        Self {
            safety: R::decimal("0.9"),
            bounds: (R::of(6.0).recip(), R::decimal("0.333").recip()),
            exponent: R::of(0.125) - options.stabilisation * R::decimal("0.2"),
            stabilisation: options.stabilisation,
            max_step: options.max_step.unwrap_or(span),
            memory: R::decimal("0.0001"),
            floor: R::decimal("0.0001"),
            rejected: false,
        }
    }

    /// Judges a trial of length `h` by the norm of its error, which must be at most 1.
    pub(crate) fn judge(&mut self, h: R, error: R) -> StepOutcome<R> {
        let (growing, shrinking) = self.bounds;
        let plain = error.powf(self.exponent);
        if error > R::one() {
            self.rejected = true;
            return StepOutcome::Reject(h / shrinking.min(plain / self.safety));
        }
        let stable = plain / self.memory.powf(self.stabilisation);
        let next = (h / growing.max(shrinking.min(stable / self.safety))).min(self.max_step);
        self.memory = error.max(self.floor);
        // After a rejection the next step may not be longer.
        let next = if std::mem::take(&mut self.rejected) { next.min(h) } else { next };
        StepOutcome::Accept(next)
    }

    /// Longest step.
    pub(crate) fn max_step(&self) -> R {
        self.max_step
    }
}

/// Estimate of the first step, before and after an explicit Euler step.
pub(crate) struct Guess<R> {
    scale: Scale<R>,
    max_step: R,
    slope: R,
    /// Length of the Euler step.
    pub(crate) euler: R,
}

impl<R: Real> Guess<R> {
    /// The length of the Euler step, from state and slope at the start: it changes the state by
    /// about a hundredth.
    pub(crate) fn new(scale: Scale<R>, max_step: R, y: &[R], slope: &[R]) -> Self {
        let square = norm(scale, y, slope.iter().copied());
        let size = norm(scale, y, y.iter().copied());
        let tiny = R::decimal("0.0000000001");
        let guess = if square <= tiny || size <= tiny {
            R::decimal("0.000001")
        } else {
            (size / square).sqrt() * R::decimal("0.01")
        };
        Self { scale, max_step, slope: square.sqrt(), euler: guess.min(max_step) }
    }

    /// The first step, from the slope after the Euler step: `h^8 max(|y'|, |y''|) = 0.01`, and at
    /// most a hundred Euler steps.
    pub(crate) fn refine(self, y: &[R], slope: &[R], after: &[R]) -> R {
        let change = slope.iter().zip(after).map(|(&before, &after)| after - before);
        let second = norm(self.scale, y, change).sqrt() / self.euler;
        // The Euler step may leave the domain of the field.
        let second = if second.is_finite() { second } else { R::zero() };
        let bend = second.max(self.slope);
        let h = if bend <= R::decimal("0.000000000000001") {
            R::decimal("0.000001").max(self.euler * R::decimal("0.001"))
        } else {
            (R::decimal("0.01") / bend).powf(R::of(0.125))
        };
        (R::of(100.0) * self.euler).min(h).min(self.max_step)
    }
}

/// The sum of squares of `x` in units of the tolerance at `y`.
fn norm<R: Real>(scale: Scale<R>, y: &[R], x: impl Iterator<Item = R>) -> R {
    let shares = y.iter().zip(x).map(|(&y, x)| x / scale.at(y.abs()));
    shares.fold(R::zero(), |sum, share| sum + share * share)
}
