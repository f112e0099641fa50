//! A run: the one door to every method.
//!
//! | file | what it holds |
//! |---|---|
//! | `mod` | [`Run`]: chain, initial state, span, method, setting, and what is kept on the way |
//! | `method` | [`Method`]: the integrators by name; [`Setting`]: how finely they work |
//! | `record` | [`Trajectory`]: what a run leaves behind; the guards on the way |
//! | `states` | [`States`]: the states at given times, one by one |
//! | `regime` | [`regime`]: which method a chain asks for |

pub mod method;
mod record;
mod regime;
mod states;

pub use method::{Method, Setting};
pub use record::{Kept, Recorder};
pub use record::{Profile, Records, Sample, Trajectory};
pub use regime::{Regime, regime};
pub use regime::{contact_frequency, overlap_scale};
pub use states::States;
pub use states::state_at;

use crate::{
    chain::{Chain, State},
    error::{Error, Result},
};
use hertzchain_integrators::Stepper;
use std::f64::consts::PI;

/// Tolerances that a run may ask for; a method may refuse more of them.
const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-15..=0.1;
/// Samples of the energy, if nobody says how many.
const SAMPLES: usize = 400;
/// Most samples.
pub const MOST_SAMPLES: usize = 1_000_000;

/// A chain, where it starts, until when it runs, by which method, and what is kept on the way.
///
/// Times start at zero. Scenes, studies and sweeps build runs; so can you:
///
/// ```
/// use hertzchain_core::{Boundary, Chain, Method, Params, Run, State};
/// // Ten beads without resonators (alpha = 3/2, kappa = rho = 0), the first one struck.
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 10)?;
/// let mut state = State::rest(&chain);
/// state.u_dot_mut()[0] = 1.0;
/// let run = Run::new(chain, state).until(30.0)?.method(Method::Collocation).tolerance(1e-10)?.contacts();
/// let end = run.start()?;
/// assert!(end.energy_error.unwrap() < 1e-10);
/// // Each bond has closed at least once.
/// assert!(end.contacts.unwrap().len() >= 9);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Run {
    chain: Chain<f64>,
    initial: State<f64>,
    end: f64,
    period: f64,
    method: Option<Method>,
    setting: Option<Setting>,
    records: Records,
    samples: usize,
    contacts: bool,
}

impl Run {
    /// A run of `chain` from `initial`. Its end must be given, by [`until`](Self::until).
    ///
    /// Unless others are named, method and setting are those of [`regime`], the energy is recorded 400 times, and contacts are not logged.
    pub fn new(chain: Chain<f64>, initial: State<f64>) -> Self {
        let omega = chain.params().omega();
        let period = if omega > 0.0 { 2.0 * PI / omega } else { 1.0 };
        Self {
            chain,
            initial,
            end: f64::NAN,
            period,
            method: None,
            setting: None,
            records: Records::Energy,
            samples: SAMPLES,
            contacts: false,
        }
    }

    /// The end of the run, which starts at time zero.
    ///
    /// # Errors
    /// A time that is not finite or not positive.
    pub fn until(mut self, end: f64) -> Result<Self> {
        if !(end.is_finite() && end > 0.0) {
            return Err(Error::parameter("until", end, "finite and positive"));
        }
        self.end = end;
        Ok(self)
    }

    /// The method.
    #[must_use]
    pub fn method(mut self, method: Method) -> Self {
        self.method = Some(method);
        self
    }

    /// The tolerance: of the whole run for [`Method::Collocation`] and [`Method::CORRECTED`], of a step for the others that take one. Without a
    /// [`method`](Self::method) collocation takes it.
    ///
    /// # Errors
    /// A tolerance outside 1e-15 .. 0.1.
    pub fn tolerance(self, tol: f64) -> Result<Self> {
        if !TOLERANCES.contains(&tol) {
            return Err(Error::parameter("tol", tol, "from 1e-15 to 0.1"));
        }
        Ok(self.setting(Setting::Tolerance(tol)))
    }

    /// Equal steps of the length `h` or a little shorter, so that a whole number of them fits the span. Without a [`method`](Self::method)
    /// contact-corrected splitting takes them.
    ///
    /// # Errors
    /// A step that is not finite or not positive, or of which more than 10^15 fill the span; no end given before.
    pub fn step(self, h: f64) -> Result<Self> {
        if !(h.is_finite() && h > 0.0) {
            return Err(Error::parameter("step", h, "finite and positive"));
        }
        let steps = Setting::steps(self.end()? / h)?;
        Ok(self.setting(steps))
    }

    /// How finely the method works.
    #[must_use]
    pub fn setting(mut self, setting: Setting) -> Self {
        self.setting = Some(setting);
        self
    }

    /// What is kept on the way.
    #[must_use]
    pub fn records(mut self, records: Records) -> Self {
        self.records = records;
        self
    }

    /// At how many times, beside the start, evenly spaced: the last is the end.
    ///
    /// # Errors
    /// More than 10^6.
    pub fn samples(mut self, samples: usize) -> Result<Self> {
        if samples > MOST_SAMPLES {
            return Err(Error::parameter("samples", samples, "at most 10^6"));
        }
        self.samples = samples;
        Ok(self)
    }

    /// Logs all contacts.
    #[must_use]
    pub fn contacts(mut self) -> Self {
        self.contacts = true;
        self
    }

    /// The unit of "steps per period": that of the resonators, or 1 without any, unless a scene knows better.
    pub fn with_period(mut self, period: f64) -> Self {
        self.period = period;
        self
    }

    /// The chain.
    pub fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    /// The initial state.
    pub fn initial(&self) -> &State<f64> {
        &self.initial
    }

    /// The period that steps are counted by.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// How many samples are taken, beside the start.
    pub fn sample_count(&self) -> usize {
        self.samples
    }

    /// The end.
    ///
    /// # Errors
    /// None was given.
    pub fn end(&self) -> Result<f64> {
        if self.end.is_nan() {
            return Err(Error::parameter("until", "nothing", "a run needs an end: Run::until"));
        }
        Ok(self.end)
    }

    /// The span, of a state that is one of the chain.
    fn span(&self) -> Result<(f64, f64)> {
        if self.initial.layout() != self.chain.layout() {
            let given = self.initial.as_slice().len();
            return Err(Error::parameter("state", given, "as many numbers as the chain has"));
        }
        Ok((0.0, self.end()?))
    }

    /// Method and setting: those that were given, or what they ask for.
    ///
    /// # Errors
    /// No end was given where the choice needs it.
    pub fn choice(&self) -> Result<(Method, Setting)> {
        Ok(match (self.method, self.setting) {
            (Some(method), Some(setting)) => (method, setting),
            (None, Some(setting @ Setting::Steps(_))) => (Method::CORRECTED, setting),
            (None, Some(setting)) => (Method::Collocation, setting),
            (Some(method), None) if method.tolerant() => (method, Setting::Tolerance(regime::TOLERANCE)),
            (Some(method), None) => (method, Setting::steps(regime::STEPS_PER_PERIOD * self.end()? / self.period)?),
            (None, None) => {
                let Regime { method, setting, .. } = regime(self)?;
                (method, setting)
            }
        })
    }

    /// The method at work, for those who want to take the steps themselves.
    ///
    /// # Errors
    /// No end; a state of another chain; a setting of the wrong kind for the method, or outside its rule.
    pub fn stepper(&self) -> Result<Box<dyn Stepper<f64> + Send>> {
        let (span, (method, setting)) = (self.span()?, self.choice()?);
        method.start(self, self.initial.as_slice(), span, setting)
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// A run that cannot start. One that fails on the way is a [`Trajectory`] with a `failure`, and has all that was kept.
    pub fn start(&self) -> Result<Trajectory> {
        self.start_with(&mut |_| ())
    }

    /// The same; `progress` is told the time at every sample.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn start_with(&self, progress: &mut dyn FnMut(f64)) -> Result<Trajectory> {
        let ((_, end), (method, setting)) = (self.span()?, self.choice()?);
        let mut recorder = Recorder::new(self, Kept::new(self), progress);
        let failure = recorder.go_on(method, setting, end)?.err();
        Ok(recorder.trajectory(failure))
    }

    /// The same by a stepper of your own in place of a method; contacts are not looked for.
    ///
    /// # Errors
    /// No end, or a state of another chain.
    pub fn start_by(&self, stepper: &mut impl Stepper<f64>, progress: &mut dyn FnMut(f64)) -> Result<Trajectory> {
        self.span()?;
        let mut recorder = Recorder::new(self, Kept::new(self), progress);
        let failure = recorder.leg(stepper).err();
        Ok(recorder.trajectory(failure))
    }

    /// The states at these times, one by one as they are asked for; times ascend, and none is after the end.
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
    /// A run that cannot start; times outside their rule. Items are errors where the run fails on the way or the process is asked to end.
    pub fn at(&self, times: &[f64]) -> Result<States> {
        States::new(self, times)
    }
}
