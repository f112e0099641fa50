//! The loop over time: advance, record, stop. All methods are [`Stepper`]s under it.

use crate::{error::Error, real::Real, stats::Stats};
use std::ops::ControlFlow;

/// A method that integrates a problem from its start to a fixed end.
pub trait Stepper<R: Real> {
    /// Number of components of the state.
    fn dim(&self) -> usize;
    /// The time reached.
    fn time(&self) -> R;
    /// Whether the end is reached.
    fn done(&self) -> bool;
    /// Makes one accepted step. Must not be called after [`done`](Self::done).
    ///
    /// # Errors
    /// The failure of the method; [`Error::Stopped`] if the work of the thread is
    /// [asked](crate::interrupt) to end. The last state stays readable through
    /// [`sample`](Self::sample).
    fn step(&mut self) -> Result<(), Error>;
    /// Makes one accepted step or a few in a row. No step is made after one that ends at the time
    /// `wanted` or later.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    fn steps(&mut self, _wanted: Option<R>) -> Result<(), Error> {
        self.step()
    }
    /// Writes the state at `t`, a time inside the last step, without changing the run.
    fn sample(&mut self, t: R, y: &mut [R]);
    /// Work done so far.
    fn stats(&self) -> Stats;
}

impl<R: Real, S: Stepper<R> + ?Sized> Stepper<R> for Box<S> {
    fn dim(&self) -> usize {
        (**self).dim()
    }

    fn time(&self) -> R {
        (**self).time()
    }

    fn done(&self) -> bool {
        (**self).done()
    }

    fn step(&mut self) -> Result<(), Error> {
        (**self).step()
    }

    fn steps(&mut self, wanted: Option<R>) -> Result<(), Error> {
        (**self).steps(wanted)
    }

    fn sample(&mut self, t: R, y: &mut [R]) {
        (**self).sample(t, y);
    }

    fn stats(&self) -> Stats {
        (**self).stats()
    }
}

/// An observer of a run at times of its choice.
pub trait Observer<R: Real> {
    /// The next time at which the observer wants the state; times never decrease. `None`: no more.
    fn next(&self) -> Option<R>;
    /// Receives the state `y` at the time `t` that [`next`](Self::next) asked for. After that,
    /// [`next`](Self::next) must return the next time.
    ///
    /// # Errors
    /// A reason to end the run, such as a state that is not finite.
    fn observe(&mut self, t: R, y: &[R], stats: Stats) -> Result<ControlFlow<()>, Error>;
}

/// An observer that asks for no times.
pub struct Silent;

impl<R: Real> Observer<R> for Silent {
    fn next(&self) -> Option<R> {
        None
    }
    fn observe(&mut self, _: R, _: &[R], _: Stats) -> Result<ControlFlow<()>, Error> {
        Ok(ControlFlow::Continue(()))
    }
}

/// The reason for which a run ended without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The end of the time span.
    End,
    /// The observer ended the run.
    Observer,
}

/// Runs `stepper` to its end and writes the last state into `y`; `observer` receives the states at
/// the times it asks for. The loop itself allocates nothing.
///
/// # Errors
/// The first error of the stepper or of the observer. After an error of the stepper, `y` holds the
/// last state reached.
pub fn drive<R, S, O>(stepper: &mut S, observer: &mut O, y: &mut [R]) -> Result<Stop, Error>
where
    R: Real,
    S: Stepper<R> + ?Sized,
    O: Observer<R> + ?Sized,
{
    loop {
        while let Some(t) = observer.next() {
            let time = stepper.time();
            // A time that exceeds the step's end by rounding is taken as the step's end.
            if t > time + R::of(4.0) * R::epsilon() * time.abs() {
                break;
            }
            stepper.sample(t.min(time), y);
            if observer.observe(t, y, stepper.stats())?.is_break() {
                return Ok(Stop::Observer);
            }
        }
        let outcome = if stepper.done() { Some(Ok(Stop::End)) } else { stepper.steps(observer.next()).err().map(Err) };
        if let Some(outcome) = outcome {
            stepper.sample(stepper.time(), y);
            return outcome;
        }
    }
}
