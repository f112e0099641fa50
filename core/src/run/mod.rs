//! A run: one interface to all methods. Each file uses only those below it in this list.
//!
//! | file | what it holds |
//! |---|---|
//! | `amplification` | by how much a small change of the initial state has grown at the end |
//! | `many` | [`start_all`]: several runs, those that are alike in the lanes of a register |
//! | `states` | [`States`]: an iterator over the states at given times |
//! | `record` | [`Trajectory`]: the result of a run; checks for unstable states during the run |
//! | `warning` | [`Warning`]: what makes the result of a run doubtful, such as its energy error |
//! | `start` | the stepper of a method for a run |
//! | `tolerance` | the number of steps of contact-corrected splitting for a tolerance |
//! | `within` | runs that end where an overlap gets beyond the table of its contact law |
//! | `regime` | [`regime`]: the default method and setting for a chain and its initial state |
//! | `mod` | [`Run`]: chain, initial state, span, method, setting, and what is recorded |
//! | `crossings` | changes of sign of functions of the state, which may end the run |
//! | `extremes` | [`Observables`]: such functions, and the search for their largest values |
//! | `method` | [`Method`]: the integrators by name; [`Setting`]: steps, tolerance or windows |

mod amplification;
mod crossings;
mod extremes;
mod many;
pub mod method;
mod record;
mod regime;
mod start;
mod states;
mod tolerance;
mod warning;
mod within;

pub use crate::error::Warning;
pub use amplification::deviation;
pub use crossings::Crossed;
pub use extremes::Observables;
pub use many::{groups, start_all};
pub use method::{Method, Setting};
pub use record::{Profile, Recorder, Sample, Snapshot, Trajectory};
pub use regime::{Regime, contact_frequency, overlap_scale, regime};
pub use states::{States, state_at};
pub use tolerance::perturb;

use crate::{
    chain::{Chain, State},
    error::{Error, NOTHING, Result, positive, refuse, require},
};
use crossings::Crossings;
use hertzchain_integrators::Event;
use std::{f64::consts::PI, sync::Arc};

/// Default number of samples.
const SAMPLES: usize = 400;
/// Largest number of samples.
pub const MOST_SAMPLES: usize = 1_000_000;

/// A chain, its initial state, the end time, the method, and what is recorded.
///
/// Times start at zero, unless [`starting_at`](Run::starting_at) says otherwise. Example:
///
/// ```
/// use hertzchain_core::{Boundary, Chain, Method, Params, Run, State};
/// // Ten beads without resonators (alpha = 3/2, kappa = rho = 0), the first one struck.
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 10)?;
/// let mut state = State::rest(&chain);
/// state.u_dot_mut()[0] = 1.0;
/// let run = Run::new(chain, state).until(30.0)?;
/// let run = run.method(Method::Collocation).tolerance(1e-10)?.contacts();
/// let end = run.start()?;
/// assert!(end.energy_error.unwrap() < 1e-10);
/// // Each bond has closed at least once.
/// assert!(end.contacts.unwrap().len() >= 9);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Run {
    chain: Chain<f64>,
    /// Shared with clones of the run, and with the caller that gave it.
    initial: Arc<State<f64>>,
    start: f64,
    end: f64,
    period: f64,
    method: Option<Method>,
    setting: Option<Setting>,
    records: Records,
    sampling: Sampling,
    contacts: bool,
    observables: Option<Observables>,
    crossings: Option<Crossings>,
    threads: Option<usize>,
}

/// What a run records at its sample times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Records {
    /// Nothing: only the final state is kept, and only the final state is checked.
    End,
    /// Energies at the sample times.
    Energy,
    /// Energies at the sample times; strains and states at every k-th of them.
    Profiles,
}

/// The times of samples.
#[derive(Clone, Debug, PartialEq)]
enum Sampling {
    /// The start, and the ends of this many equal parts of the span; no samples for zero.
    Equal(usize),
    /// The given times, in ascending order.
    At(Vec<f64>),
}

impl Sampling {
    /// Number of samples.
    fn count(&self) -> usize {
        match self {
            Self::Equal(0) => 0,
            Self::Equal(samples) => samples + 1,
            Self::At(times) => times.len(),
        }
    }

    /// Time of the sample after `taken` of them, in a run from `start` to `end`.
    fn time(&self, taken: usize, (start, end): (f64, f64)) -> Option<f64> {
        match self {
            Self::Equal(samples) if taken == *samples && taken > 0 => Some(end),
            Self::Equal(samples) => {
                (taken < self.count()).then(|| start + (end - start) * (taken as f64 / *samples as f64))
            }
            Self::At(times) => times.get(taken).copied(),
        }
    }
}

/// The rule of the end of a run that does not start at zero.
pub const AFTER_START: &str = "the end of a run is after its start";

/// The end of a run, if methods can reach it.
///
/// # Errors
/// As [`Run::until`].
pub fn checked_end(end: f64) -> Result<f64> {
    if (1e-100..=1e100).contains(&end) {
        return Ok(end);
    }
    let value = format!("{end:?}");
    Err(Error::parameter("until", value.trim_end_matches(".0"), "the end of a run is from 1e-100 to 1e100"))
}

impl Run {
    /// A run of `chain` from the state `initial`. Its end must be given by [`until`](Self::until).
    /// An [`Arc`] of a state is shared, so that a long chain has it in memory once.
    ///
    /// Defaults: method and setting of [`regime`], 400 samples of the energy, no log of contacts.
    pub fn new(chain: Chain<f64>, initial: impl Into<Arc<State<f64>>>) -> Self {
        let omega = chain.params().omega();
        let period = if omega > 0.0 && chain.details().is_none() { 2.0 * PI / omega } else { 1.0 };
        Self {
            chain,
            initial: initial.into(),
            start: 0.0,
            end: f64::NAN,
            period,
            method: None,
            setting: None,
            records: Records::Energy,
            sampling: Sampling::Equal(SAMPLES),
            contacts: false,
            observables: None,
            crossings: None,
            threads: None,
        }
    }

    /// Sets the end time.
    ///
    /// # Errors
    /// A time outside 1e-100 .. 1e100: powers of shorter or longer times leave the range of a
    /// double. A time that is not after the [start](Self::starting_at).
    pub fn until(mut self, end: f64) -> Result<Self> {
        self.end = checked_end(end)?;
        require(end > self.start, "until", end, AFTER_START)?;
        Ok(self)
    }

    /// Sets the time at which the run starts, from the initial state: drives act as at this time,
    /// and beads that they move must be where they are then. The end must have been given; steps
    /// and sample times are given after it, since they are counted from it.
    ///
    /// # Errors
    /// A time that is negative or not before the end; no end given before.
    pub fn starting_at(mut self, start: f64) -> Result<Self> {
        let rule = "the start of a run is at least zero, and before its end";
        require((0.0..self.end()?).contains(&start), "start", start, rule)?;
        self.start = start;
        Ok(self)
    }

    /// Sets the method.
    #[must_use]
    pub fn method(mut self, method: Method) -> Self {
        self.method = Some(method);
        self
    }

    /// Sets the tolerance: of the sum of the errors of all windows for [`Method::Collocation`], of
    /// the state at the end for [`Method::CORRECTED`], of a step for the other methods that take
    /// one. Without a [`method`](Self::method), it is that of [`Method::by_tolerance`].
    ///
    /// # Errors
    /// A tolerance that the method does not accept, see [`Method::tolerances`].
    pub fn tolerance(self, tol: f64) -> Result<Self> {
        let tol = self.method.unwrap_or(Method::by_tolerance(&self.chain)).tolerances().check(tol)?;
        Ok(self.setting(Setting::Tolerance(tol)))
    }

    /// Sets equal steps of length `h`, or slightly shorter so that a whole number of them fits the
    /// span. Without a [`method`](Self::method), the method is contact-corrected splitting, or
    /// `strang-linear` for a chain that it cannot run.
    ///
    /// # Errors
    /// A step that is not finite or not positive, or that fits the span more than 10^15 times; no
    /// end given before.
    pub fn step(self, h: f64) -> Result<Self> {
        positive("step", h)?;
        let steps = Setting::steps(self.length()? / h)?;
        Ok(self.setting(steps))
    }

    /// Sets the number of steps, the tolerance or the windows of the method.
    #[must_use]
    pub fn setting(mut self, setting: Setting) -> Self {
        self.setting = Some(setting);
        self
    }

    /// Sets what is recorded.
    #[must_use]
    pub fn records(mut self, records: Records) -> Self {
        self.records = records;
        self
    }

    /// Sets the number of samples, not counting the initial state. Sample times are equally spaced;
    /// the last one is the end.
    ///
    /// # Errors
    /// More than 10^6.
    pub fn samples(mut self, samples: usize) -> Result<Self> {
        require(samples <= MOST_SAMPLES, "samples", samples, "at most 10^6")?;
        self.sampling = Sampling::Equal(samples);
        Ok(self)
    }

    /// Sets the times of the samples: ascending, and none after the end of the run.
    ///
    /// # Errors
    /// Times that break these rules; more than 10^6 + 1 of them; no end given before.
    pub fn samples_at(mut self, times: &[f64]) -> Result<Self> {
        self.checked_times(times)?;
        require(times.len() <= MOST_SAMPLES + 1, "times", times.len(), "at most 10^6 + 1")?;
        let end = self.end()?;
        self.sampling = Sampling::At(times.iter().map(|t| t.min(end)).collect());
        Ok(self)
    }

    /// Refuses times that do not ascend or are not on the span. For rounding, they may exceed its
    /// end by four units of the last place.
    fn checked_times(&self, times: &[f64]) -> Result<()> {
        let last = self.end()? * (1.0 + 4.0 * f64::EPSILON);
        let rule = "from zero to the end of the run";
        let rule = if self.start > 0.0 { "from the start to the end of the run" } else { rule };
        refuse("times", times.iter().find(|&&t| !(self.start..=last).contains(&t)), rule)?;
        let back = times.windows(2).find(|pair| pair[0] > pair[1]);
        refuse("times", back.map(|pair| pair[1]), "in ascending order")
    }

    /// Asks for a log of all contacts.
    #[must_use]
    pub fn contacts(mut self) -> Self {
        self.contacts = true;
        self
    }

    /// Looks for the largest values, by modulus, of functions of the state, also between steps.
    ///
    /// They are found as well as the method has its states between steps, by polynomials through
    /// eight samples of a 16th of [`fast_period`](Self::fast_period), or of a step if that is
    /// shorter. Of several maxima in such a part one is found, and a step has at most 256 parts.
    #[must_use]
    pub fn observables(mut self, observables: Observables) -> Self {
        self.observables = Some(observables);
        self
    }

    /// Looks for changes of sign of functions of the state, and calls `then` with each and the
    /// state there. One that [`Ends`](Crossed::Ends) the run is its last time.
    ///
    /// The time is a zero of the function along the states that the method has between steps: its
    /// dense output; for splittings, a shorter step. The signs are those at 32 times in a period of
    /// the fastest motion or more, and at the minimum between three of them of a modulus that comes
    /// near to zero, so that two changes between them are found; of three one is. A change leaves a
    /// band about zero on the other side: 64 roundings of the largest position for functions of
    /// kind 0, of the largest velocity for other kinds, see [`Observables::of_kinds`], and of the
    /// larger of both for functions without kinds. A
    /// function that begins in this band, or at a zero as exactly as its time is known, has no
    /// change when it leaves it, so that a run which goes on from its last change does not find it
    /// again. Contacts, if they are [logged](Self::contacts), are looked for in parts of steps,
    /// with any method. The end has the state of the run without functions, but for roundings of
    /// methods that land on contacts.
    ///
    /// ```
    /// # use hertzchain_core::{Boundary, Chain, Params, Run, State, run::{Crossed, Observables}};
    /// // A bead that is free moves with speed 2 and is at 3 at time 1.5.
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 1)?;
    /// let mut state = State::rest(&chain);
    /// state.u_dot_mut()[0] = 2.0;
    /// let at_three = Observables::new(|y, to| to.push(y[0] - 3.0));
    /// let run = Run::new(chain, state).until(5.0)?.crossings(at_three, |_, _| Crossed::Ends);
    /// let end = run.start()?;
    /// assert!((end.t - 1.5).abs() < 1e-15 && end.crossings[0].rising);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    #[must_use]
    pub fn crossings(
        mut self,
        functions: Observables,
        then: impl Fn(&Event<f64>, &[f64]) -> Crossed + Send + Sync + 'static,
    ) -> Self {
        self.crossings = Some(Crossings { functions, then: Arc::new(then) });
        self
    }

    /// Moves the chain on this many threads, with the same bits: exactly so many
    /// [`parts`](crate::parts) by splitting schemes, at most so many by collocation. What
    /// [`Method::takes`] refuses is refused when the run starts. Without a number, collocation
    /// solves blocks of a long chain on all threads of the process, and other methods take one
    /// thread.
    ///
    /// ```
    /// use hertzchain_core::{Boundary, Chain, Method, Params, Run, State};
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Ring, 100)?;
    /// let mut state = State::rest(&chain);
    /// state.u_dot_mut()[0] = 1.0;
    /// let run = Run::new(chain, state).until(30.0)?.method(Method::named("verlet")?).step(0.1)?;
    /// let [one, three] = [run.clone(), run.threads(3)].map(|run| run.start());
    /// assert_eq!(one?.state, three?.state);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    #[must_use]
    pub fn threads(mut self, count: impl Into<Option<usize>>) -> Self {
        self.threads = count.into();
        self
    }

    /// Sets the unit of time in "steps per period". The default is the period of the resonators, or
    /// 1 without resonators and for a chain with details.
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

    /// Unit of time in "steps per period".
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Number of equal parts of the span at whose ends samples are taken; 0 if the times of samples
    /// were given.
    pub fn sample_count(&self) -> usize {
        match self.sampling {
            Sampling::Equal(samples) => samples,
            Sampling::At(_) => 0,
        }
    }

    /// Time of the sample after `taken` of them.
    fn sample_time(&self, taken: usize) -> Option<f64> {
        let sampled = self.records != Records::End;
        sampled.then(|| self.sampling.time(taken, (self.start, self.end))).flatten()
    }

    /// The end time.
    ///
    /// # Errors
    /// No end was given.
    pub fn end(&self) -> Result<f64> {
        require(!self.end.is_nan(), "until", NOTHING, "a run needs an end: Run::until")?;
        Ok(self.end)
    }

    /// The length of the time span.
    ///
    /// # Errors
    /// No end was given.
    fn length(&self) -> Result<f64> {
        Ok(self.end()? - self.start)
    }

    /// The time span. Refuses an initial state that has another layout than the chain, or in which
    /// a bead that a drive moves does not begin with its drive.
    fn span(&self) -> Result<(f64, f64)> {
        let initial = self.initial();
        if initial.layout() != self.chain.layout() {
            let given = initial.as_slice().len();
            return Err(Error::parameter("state", given, "as many numbers as the chain has"));
        }
        let apart = self.chain.follows_drives(initial.as_slice(), self.start).err();
        let rule = "a bead that is moved begins where its drive does, with its speed: State::driven";
        refuse("state", apart.map(|site| format!("at site {site}")), rule)?;
        Ok((self.start, self.end()?))
    }
}
