//! Long chains at rest that are struck: the errors of contact collocation at loose tolerances.
//!
//! In a chain at rest only contacts that are yet to begin limit the first windows. An error is
//! compared with the tolerance times the *amplification*: the factor by which an error of
//! velocities, made at the start or half way, is larger at the end; at least 1.

use crate::{
    Run,
    chain::{Boundary, Chain, Params, State, max_norm},
    error::Result,
    run::{
        Records, deviation,
        method::{Method, Setting},
        perturb,
    },
};
use serde::{Deserialize, Serialize};

/// Numbers of beads, and tolerances.
pub(super) const SITES: [usize; 4] = [250, 500, 1000, 2000];
pub(super) const TOLERANCES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// Exponents and mass ratios of the chains.
pub(super) const EXPONENTS: [f64; 3] = [1.2, 1.5, 2.5];
pub(super) const MASS_RATIOS: [f64; 2] = [0.0, 1.0];
/// Time until which a chain of `N` beads runs, in units of `N`.
const SPAN: f64 = 0.2;
/// Relative size of a perturbation. The runs that are compared have a tolerance of [`FINE`].
const PERTURBATION: f64 = 1e-7;
/// The tolerance of the runs that others are compared with.
const FINE: f64 = 1e-12;

/// A chain with an initial state, and the end of its runs.
#[derive(Clone, Debug)]
pub struct Struck {
    run: Run,
    end: f64,
}

/// A run at one tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StruckRun {
    /// The tolerance.
    pub tol: f64,
    /// The error at the end, see [`deviation`]; `None` for a run that failed.
    pub error: Option<f64>,
    /// Number of windows.
    pub windows: u64,
    /// Number of force evaluations.
    pub force_evaluations: u64,
}

/// The runs of a chain at all tolerances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StruckRuns {
    /// End time of the runs.
    pub until: f64,
    /// Factor by which an error of velocities is larger at the end, at least 1.
    pub amplification: f64,
    /// A run for each tolerance.
    pub runs: Vec<StruckRun>,
}

/// The state with perturbed velocities: those that are not small, with signs that depend on their
/// index.
fn perturbed(state: &State<f64>) -> State<f64> {
    let mut out = state.clone();
    let half = state.as_slice().len() / 2;
    let velocities = &mut out.as_mut_slice()[half..];
    let size = max_norm(velocities.iter().copied());
    perturb(velocities, PERTURBATION * size, 1e-3 * size);
    out
}

impl Struck {
    /// A chain with an initial state, to run until `end`.
    pub fn new(chain: Chain<f64>, state: State<f64>, end: f64) -> Self {
        Self { run: Run::new(chain, state).method(Method::Collocation).records(Records::End), end }
    }

    /// A free chain of which the first bead is struck.
    pub(super) fn free(params: Params, sites: usize) -> Result<Self> {
        let chain = Chain::new(params, Boundary::Free, sites)?;
        let mut state = State::rest(&chain);
        state.u_dot_mut()[0] = 1.0;
        Ok(Self::new(chain, state, SPAN * sites as f64))
    }

    /// The state at a time `time` after `from`, by a run with tolerance [`FINE`].
    fn fine(&self, from: &State<f64>, time: f64) -> Result<State<f64>> {
        let run = Run::new(self.run.chain().clone(), from.clone()).until(time)?.method(Method::Collocation);
        let end = run.setting(Setting::Tolerance(FINE)).records(Records::End).start()?.complete()?.state;
        let mut state = from.clone();
        state.as_mut_slice().copy_from_slice(&end);
        Ok(state)
    }

    /// The factor by which errors of velocities, made at the start or half way, are larger at the
    /// end, at least 1; and the state at the end.
    ///
    /// # Errors
    /// A fine run that fails.
    pub fn amplification(&self) -> Result<(f64, State<f64>)> {
        let start = self.run.initial();
        let half = self.fine(start, 0.5 * self.end)?;
        let end = self.fine(&half, 0.5 * self.end)?;
        let grown = |from: &State<f64>, time: f64| -> Result<f64> {
            Ok(deviation(self.fine(&perturbed(from), time)?.as_slice(), end.as_slice()) / PERTURBATION)
        };
        Ok((grown(start, self.end)?.max(grown(&half, 0.5 * self.end)?).max(1.0), end))
    }

    /// Runs every tolerance.
    pub(super) fn measure(&self) -> Result<StruckRuns> {
        let (amplification, end) = self.amplification()?;
        let run = |&tol: &f64| -> Result<StruckRun> {
            let trajectory = self.run.clone().until(self.end)?.setting(Setting::Tolerance(tol)).start()?;
            let stats = trajectory.stats;
            let error = trajectory.failure.is_none().then(|| deviation(&trajectory.state, end.as_slice()));
            Ok(StruckRun { tol, error, windows: stats.steps, force_evaluations: stats.force_evaluations })
        };
        let runs = TOLERANCES.iter().map(run).collect::<Result<_>>()?;
        Ok(StruckRuns { until: self.end, amplification, runs })
    }
}

impl StruckRuns {
    /// The error of a run in units of its tolerance times the amplification.
    pub fn ratio(&self, run: &StruckRun) -> Option<f64> {
        Some(run.error? / (run.tol * self.amplification))
    }
}
