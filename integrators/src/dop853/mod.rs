//! DOP853: the explicit Runge-Kutta method of order 8 by Dormand and Prince, with error estimators
//! of order 5 and 3 and dense output of order 7, controlled as by Hairer and Wanner.
//!
//! E. Hairer, S. P. Norsett and G. Wanner, *Solving Ordinary Differential Equations I*, 2nd ed.,
//! Springer 1993, sections II.4 to II.6 and II.10.

pub(crate) mod controller;
pub(crate) mod dense;
pub(crate) mod step;
pub mod tableau;

pub use controller::Options;

use crate::{
    clock::{Breaks, DoubleDouble},
    drive::Stepper,
    error::Error,
    interrupt,
    real::Real,
    stats::Stats,
    system::VectorField,
};
use controller::{Controller, StepOutcome};
use dense::Dense;
use step::{Leap, Step};

/// DOP853 on `y' = f(t, y)`.
pub struct Dop853<R, F> {
    field: F,
    step: Step<R>,
    dense: Dense<R>,
    step_size: StepSize<R>,
    /// Start of the span, or of the stretch since the last break.
    start: R,
    end: R,
    /// Times at which the field is not smooth, and the end of the stretch up to the next one.
    breaks: Breaks,
    stop: DoubleDouble<R>,
    time: DoubleDouble<R>,
    /// The last step, until the next trial.
    last: Option<Leap<R>>,
    round_off: R,
    /// A step is stretched to the end of the span if it covers the rest of it up to this factor.
    stretch: R,
    begun: bool,
    trials: u64,
    stats: Stats,
}

/// Refuses a span or a state that cannot be integrated.
pub(crate) fn check_start<R: Real>(dim: usize, y0: &[R], (start, end): (R, R)) -> Result<(), Error> {
    let argument = |name, value: R, rule| Err(Error::Argument { name, value: value.f64(), rule });
    if !start.is_finite() {
        return argument("start", start, "a time is finite");
    }
    if !(end.is_finite() && end >= start) {
        return argument("end", end, "the end is finite and not before the start");
    }
    if y0.is_empty() || y0.len() != dim {
        return argument("y0", R::of(y0.len() as f64), "as many components as the field, at least one");
    }
    if let Some(&value) = y0.iter().find(|value| !value.is_finite()) {
        return argument("y0", value, "every component of the state is finite");
    }
    Ok(())
}

/// The rule for step lengths.
enum StepSize<R> {
    /// Steps by error control; `next` is the step to try next.
    Controlled { options: Options<R>, controller: Controller<R>, next: R },
    /// A given number of equal steps.
    Equal { h: DoubleDouble<R>, steps: u64 },
}

impl<R: Real, F: VectorField<R>> Dop853<R, F> {
    /// Integrates `field` from `y0` at `start` to `end`, with steps as long as the tolerances
    /// allow.
    ///
    /// # Errors
    /// `end < start`, times or a state that are not finite, a state of the wrong length, options
    /// outside their ranges.
    pub fn new(field: F, y0: &[R], (start, end): (R, R), options: Options<R>) -> Result<Self, Error> {
        let options = options.checked((R::of(10.0), "a relative tolerance is finite and above 10 unit round-offs"))?;
        let controller = Controller::new(end - start);
        let breaks = Breaks::new(field.breaks());
        let step_size = StepSize::Controlled { options, controller, next: R::zero() };
        Ok(Self { breaks, ..Self::with_step_size(field, y0, (start, end), step_size)? })
    }

    /// Integrates `field` in `steps` equal steps, without error control.
    ///
    /// # Errors
    /// As [`new`](Self::new), or no step for a span that is not empty.
    pub fn fixed(field: F, y0: &[R], (start, end): (R, R), steps: u64) -> Result<Self, Error> {
        if steps == 0 && end > start {
            return Err(Error::Argument { name: "steps", value: 0.0, rule: "at least one step" });
        }
        let span = DoubleDouble::new(end) - DoubleDouble::new(start);
        let h = span.over(DoubleDouble::new(R::of(steps.max(1) as f64)));
        Self::with_step_size(field, y0, (start, end), StepSize::Equal { h, steps })
    }

    fn with_step_size(field: F, y0: &[R], (start, end): (R, R), step_size: StepSize<R>) -> Result<Self, Error> {
        check_start(field.dim(), y0, (start, end))?;
        let atol = match &step_size {
            StepSize::Controlled { options, .. } => options.atol,
            StepSize::Equal { .. } => R::one(),
        };
        let step = Step::new(y0, atol);
        Ok(Self {
            field,
            dense: Dense::new(step.padded()),
            step,
            step_size,
            start,
            end,
            breaks: Breaks::new(Vec::new()),
            stop: DoubleDouble::new(end),
            time: DoubleDouble::new(start),
            last: None,
            round_off: controller::round_off(),
            stretch: R::decimal("1.01"),
            begun: false,
            trials: 0,
            stats: Stats::default(),
        })
    }

    /// The same run with absolute tolerances, and the guess of the first step, in these units of
    /// the components and of time: it takes the same steps in all units.
    #[must_use]
    pub fn in_units(mut self, units: &[R], time: R) -> Self {
        self.step.in_units(units, time);
        self
    }

    /// Number of trial steps so far: accepted and rejected, those before the first accepted step
    /// included.
    pub fn trials(&self) -> u64 {
        self.trials
    }

    fn not_finite(&self, index: usize) -> Error {
        Error::NotFinite { t: self.time.value().f64(), step: self.stats.steps, index }
    }

    /// Computes the first slope of the run, or after a time at which the field is not smooth, and,
    /// if none is given, the first step.
    fn begin(&mut self) -> Result<(), Error> {
        let t = self.time.value();
        if t > self.start {
            self.field.complete(self.start, t, self.step.state_mut());
            self.start = t;
        }
        self.stop = self.breaks.or_end(t, DoubleDouble::new(self.end));
        self.step.begin(&mut self.field, t);
        self.stats.force_evaluations += 1;
        self.step.check(0).map_err(|index| self.not_finite(index))?;
        if let StepSize::Controlled { options, controller, next } = &mut self.step_size {
            let max_step = self.end - self.start;
            *controller = Controller::new(max_step);
            *next = match options.first_step {
                Some(h) => h.min(max_step),
                None => {
                    self.stats.force_evaluations += 1;
                    let guess = self.step.first(&mut self.field, t, options.rtol, max_step);
                    // Late in a long run the least guess is below what times resolve.
                    guess.max(R::of(100.0) * t.abs() * self.round_off)
                }
            };
        }
        self.begun = true;
        Ok(())
    }

    /// The next trial step.
    fn propose(&self) -> Result<Leap<R>, Error> {
        let (from, end) = (self.time, self.stop);
        let t = from.value();
        let (h, to) = match &self.step_size {
            StepSize::Controlled { options, next, .. } => {
                if self.trials >= options.max_steps {
                    return Err(Error::TooManySteps { t: t.f64(), steps: self.trials });
                }
                // Avoids a tiny last step: a step that nearly reaches the end is stretched to it.
                let last = t + self.stretch * *next > end.value();
                (*next, if last { end } else { from + DoubleDouble::new(*next) })
            }
            StepSize::Equal { h, steps } => {
                let taken = self.stats.steps + 1;
                let to = DoubleDouble::new(self.start) + *h * DoubleDouble::new(R::of(taken as f64));
                (h.value(), if taken == *steps { end } else { to })
            }
        };
        if h * R::of(0.1) <= t.abs() * self.round_off {
            return Err(Error::StepUnderflow { t: t.f64(), h: h.f64() });
        }
        Ok(Leap { from, to, h: if to == end { (end - from).value() } else { h }, share_3: R::one() })
    }
}

impl<R: Real, F: VectorField<R>> Stepper<R> for Dop853<R, F> {
    fn dim(&self) -> usize {
        self.step.dim()
    }

    fn time(&self) -> R {
        self.time.value()
    }

    fn done(&self) -> bool {
        self.time.value() >= self.end
    }

    /// Makes one accepted step, after the trials that are rejected.
    ///
    /// After an error only the last state reached can be sampled, not the inside of the last step.
    fn step(&mut self) -> Result<(), Error> {
        if !self.begun {
            self.last = None;
            self.dense.clear();
            self.begin()?;
        }
        loop {
            interrupt::check(self.time().f64())?;
            let leap = self.propose()?;
            if self.last.take().is_some() {
                self.step.advance();
                self.dense.clear();
            }
            self.trials += 1;
            self.stats.force_evaluations += 11;
            let rtol = match &self.step_size {
                StepSize::Controlled { options, .. } => Some(options.rtol),
                StepSize::Equal { .. } => None,
            };
            let trial = self.step.attempt(&mut self.field, leap, rtol);
            let error = trial.map_err(|index| self.not_finite(index))?;
            if let StepSize::Controlled { controller, next, .. } = &mut self.step_size {
                match controller.judge(leap.h, error) {
                    StepOutcome::Accept(h) => *next = h,
                    StepOutcome::Reject(h) => {
                        *next = h;
                        // Rejections before the first accepted step are not counted, as in the
                        // authors' code.
                        self.stats.rejected += u64::from(self.stats.steps > 0);
                        continue;
                    }
                }
            }
            self.stats.force_evaluations += 1;
            let accepted = self.step.accept(&mut self.field, leap.to.value());
            accepted.map_err(|index| self.not_finite(index))?;
            self.stats.steps += 1;
            self.time = leap.to;
            self.begun = leap.to != self.stop;
            self.last = Some(leap);
            return Ok(());
        }
    }

    /// Inside the last step the state is that of dense output; the first such sample of a step
    /// costs three evaluations. For other times it is the state at the nearer end of the step.
    fn sample(&mut self, t: R, y: &mut [R]) {
        let t = match self.last {
            Some(leap) if t <= leap.from.value() => {
                y.copy_from_slice(self.step.before());
                leap.from.value()
            }
            Some(leap) if t < leap.to.value() => {
                self.stats.force_evaluations += self.dense.prepare(&mut self.step, &mut self.field, leap);
                let share = (DoubleDouble::new(t) - leap.from).over(DoubleDouble::new(leap.h)).value();
                self.dense.eval(self.step.before(), share, y);
                t
            }
            _ => {
                y.copy_from_slice(self.step.state());
                self.time.value()
            }
        };
        self.field.complete(self.start, t, y);
    }

    fn stats(&self) -> Stats {
        self.stats
    }
}
