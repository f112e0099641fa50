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

impl Run {
    /// The states at the given times, as an iterator that integrates on demand. Times must ascend,
    /// and none may lie after the end.
    ///
    /// ```
    /// # use hertzchain_core::{Boundary, Chain, Params, Run, State};
    /// # let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Ring, 5)?;
    /// # let mut state = State::rest(&chain);
    /// state.u_dot_mut().copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 0.0]);
    /// let run = Run::new(chain, state).until(2.0)?;
    /// for state in run.at(&[0.5, 1.0, 2.0])? {
    ///     // Momentum is conserved.
    ///     assert!((state?.u_dot().iter().sum::<f64>() - 1.0).abs() < 1e-12);
    /// }
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// A run that cannot start; times that break these rules. An item is an error if the run fails
    /// on its way or the process is asked to end.
    pub fn at(&self, times: &[f64]) -> Result<States> {
        self.checked_times(times)?;
        Ok(States { stepper: self.stepper()?, times: Vec::from(times).into_iter(), state: self.initial().clone() })
    }
}

impl States {
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
        run.steps(Some(t))?;
    }
    let mut y = vec![0.0; run.dim()];
    run.sample(t.min(run.time()), &mut y);
    match y.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(Failure::NotFinite { t, step: run.stats().steps, index }),
        None => Ok(y),
    }
}
