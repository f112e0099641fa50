//! The states of a run at given times.

use super::Run;
use crate::{chain::State, error::Result};
use hertzchain_integrators::{Error as Failure, Stats, Stepper};

/// An iterator over the states of a run at given times, from [`Run::at`].
pub struct States {
    stepper: Box<dyn Stepper<f64> + Send>,
    times: std::vec::IntoIter<f64>,
    /// Buffer with the layout of the chain.
    state: State<f64>,
}

impl States {
    pub(super) fn new(run: &Run, times: &[f64]) -> Result<Self> {
        run.checked_times(times)?;
        Ok(Self { stepper: run.stepper()?, times: Vec::from(times).into_iter(), state: run.initial().clone() })
    }

    /// Work done so far.
    pub fn stats(&self) -> Stats {
        self.stepper.stats()
    }
}

impl Iterator for States {
    type Item = Result<State<f64>>;

    fn next(&mut self) -> Option<Self::Item> {
        let t = self.times.next()?;
        Some(match state_at(&mut *self.stepper, t) {
            Ok(y) => {
                self.state.as_mut_slice().copy_from_slice(&y);
                Ok(self.state.clone())
            }
            Err(failure) => {
                // The iterator ends after a failure.
                self.times = Vec::new().into_iter();
                Err(failure.into())
            }
        })
    }
}

/// The state at time `t`. The stepper must not have passed the step that contains `t`.
pub fn state_at(run: &mut (impl Stepper<f64> + ?Sized), t: f64) -> std::result::Result<Vec<f64>, Failure> {
    while run.time() < t && !run.done() {
        run.step()?;
    }
    let mut y = vec![0.0; run.dim()];
    run.sample(t.min(run.time()), &mut y);
    match y.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(Failure::NotFinite { t, step: run.stats().steps, index }),
        None => Ok(y),
    }
}
