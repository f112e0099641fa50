//! The one loop over time: advance, record, stop. Every family of methods is a [`Stepper`] under it.

use crate::{error::Error, real::Real, stats::Stats};
use std::ops::ControlFlow;

/// A method at work on a problem, from its start to a fixed end.
pub trait Stepper<R: Real> {
    /// Number of components of the state.
    fn dim(&self) -> usize;
    /// The time reached.
    fn time(&self) -> R;
    /// Whether the end is reached.
    fn done(&self) -> bool;
    /// One accepted step. Not to be called when [`done`](Self::done).
    ///
    /// # Errors
    /// What the method cannot get over; the state reached stays readable through [`sample`](Self::sample).
    fn step(&mut self) -> Result<(), Error>;
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

    fn sample(&mut self, t: R, y: &mut [R]) {
        (**self).sample(t, y);
    }

    fn stats(&self) -> Stats {
        (**self).stats()
    }
}

/// Somebody who wants to see the run at certain times.
pub trait Observer<R: Real> {
    /// The next time it wants to see; times never decrease. `None`: no more.
    fn next(&self) -> Option<R>;
    /// Takes the state `y` at time `t`, the one asked for last. Must move [`next`](Self::next) on.
    ///
    /// # Errors
    /// Whatever makes going on pointless, such as a state that is not finite.
    fn observe(&mut self, t: R, y: &[R], stats: Stats) -> Result<ControlFlow<()>, Error>;
    /// Whether the run is to end where it is; asked before every step.
    fn stop(&self) -> bool {
        false
    }
}

/// The observer that wants nothing.
pub struct Silent;

impl<R: Real> Observer<R> for Silent {
    fn next(&self) -> Option<R> {
        None
    }
    fn observe(&mut self, _: R, _: &[R], _: Stats) -> Result<ControlFlow<()>, Error> {
        Ok(ControlFlow::Continue(()))
    }
}

/// Why a run ended well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The end of the time span.
    End,
    /// An observer had seen enough.
    Observer,
}

/// Runs `stepper` to its end and leaves the last state in `y`; `observer` sees the times it asks for.
///
/// Allocates nothing itself.
///
/// # Errors
/// The first error of the stepper or of the observer; [`Error::Stopped`] if the latter wants no more. `y` then holds the last state that was reached.
pub fn drive<R, S, O>(stepper: &mut S, observer: &mut O, y: &mut [R]) -> Result<Stop, Error>
where
    R: Real,
    S: Stepper<R> + ?Sized,
    O: Observer<R> + ?Sized,
{
    loop {
        while let Some(t) = observer.next() {
            let time = stepper.time();
            // A time that is the step's end but for rounding is the step's end.
            if t > time + R::of(4.0) * R::epsilon() * time.abs() {
                break;
            }
            stepper.sample(t.min(time), y);
            if observer.observe(t, y, stepper.stats())?.is_break() {
                return Ok(Stop::Observer);
            }
        }
        let outcome = if stepper.done() {
            Some(Ok(Stop::End))
        } else if observer.stop() {
            Some(Err(Error::Stopped { t: stepper.time().f64() }))
        } else {
            stepper.step().err().map(Err)
        };
        if let Some(outcome) = outcome {
            stepper.sample(stepper.time(), y);
            return outcome;
        }
    }
}
