//! The result of a run, and the observer that collects it.

use super::{Method, Records, Run, Setting, Warning, extremes::Search, start::start_logged, warning::warnings};
use crate::{
    chain::{Contact, ContactLog, Contacts, Energy, Overlaps, max_norm},
    error::{Failed, Result},
};
use hertzchain_integrators::{
    Error as Failure, Event, Observer, Stats, Stepper, Watch,
    collocation::ContactStepper,
    drive,
    events::{Listener, Part},
};
use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

/// A run is called unstable when its energy exceeds the initial energy by this factor.
const ENERGY_BOUND: f64 = 10.0;
/// A run whose state has no energy is called unstable when its largest entry exceeds the largest
/// entry of the initial state by this factor.
const SIZE_BOUND: f64 = 1e3;

/// Largest number of state components in all profiles together (half a gigabyte, without the
/// strains). Runs that would exceed it keep every k-th sample only.
const MOST_NUMBERS: usize = 1 << 26;

/// Energy at a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time.
    pub t: f64,
    /// Energy by kind; `None` for states of the strain ring that have no energy.
    pub energy: Option<Energy<f64>>,
}

/// Strains and state at a sample time.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Time.
    pub t: f64,
    /// Strains of beads, see [`Chain::strains`](crate::chain::Chain::strains).
    pub x: Vec<f64>,
    /// The whole state.
    pub state: Vec<f64>,
}

/// The result of a run. If the run failed, the result contains all that was recorded before.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// Time reached.
    pub t: f64,
    /// State at this time, in the layout of the chain.
    pub state: Vec<f64>,
    /// Energy at this time, if the state has one.
    pub energy: Option<Energy<f64>>,
    /// Largest sampled `|E(t) - E(0)| / |E(0)|`; absolute where `E(0) = 0`. In the unit, magnets of
    /// beads that are at their places have no energy. For a chain that dissipates or is driven, `E`
    /// is the [balance](Energy::balance), and the unit is the largest sampled energy, dissipated
    /// energy or work.
    pub energy_error: Option<f64>,
    /// Energies at the sample times, the start included.
    pub samples: Vec<Sample>,
    /// Profiles at the sample times.
    pub profiles: Vec<Profile>,
    /// Contacts in the order of their onsets, if a log was asked for.
    pub contacts: Option<Vec<Contact>>,
    /// Time and value of the largest value, by modulus, of each of [`Run::observables`].
    pub extremes: Vec<(f64, f64)>,
    /// Changes of sign of the functions of [`Run::crossings`] that were kept, in order of time.
    pub crossings: Vec<Event<f64>>,
    /// Work of the run; see [`Stats`] for the work of samples.
    pub stats: Stats,
    /// Wall time of the run, samples included.
    pub wall: Duration,
    /// Part of `wall` spent on samples: states at the sample times, energies, strains.
    pub sampling: Duration,
    /// What makes the result doubtful.
    pub warnings: Vec<Warning>,
    /// Why the run stopped before its end, if it did.
    pub failure: Option<Failed>,
}

impl Trajectory {
    /// Returns the trajectory if the run reached its end.
    ///
    /// # Errors
    /// The failure that stopped the run.
    pub fn complete(self) -> Result<Self> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(self),
        }
    }
}

/// A stepper that measures the time spent on samples, and searches its steps for largest values if
/// these are asked for.
struct Timed<'a> {
    run: &'a mut dyn Stepper<f64>,
    search: Option<Search>,
    /// Wall time of all samples so far.
    sampling: Duration,
}

impl Stepper<f64> for Timed<'_> {
    fn dim(&self) -> usize {
        self.run.dim()
    }

    fn time(&self) -> f64 {
        self.run.time()
    }

    fn done(&self) -> bool {
        self.run.done()
    }

    fn step(&mut self) -> std::result::Result<(), Failure> {
        let from = self.run.time();
        self.run.step()?;
        if let Some(search) = &mut self.search {
            let clock = Instant::now();
            search.step(self.run, from);
            self.sampling += clock.elapsed();
        }
        Ok(())
    }

    fn steps(&mut self, wanted: Option<f64>) -> std::result::Result<(), Failure> {
        if self.search.is_some() { self.step() } else { self.run.steps(wanted) }
    }

    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let clock = Instant::now();
        self.run.sample(t, y);
        self.sampling += clock.elapsed();
    }

    fn stats(&self) -> Stats {
        self.run.stats()
    }
}

/// A log of contacts that reports each contact once it has ended.
struct ReportingLog<'a> {
    log: ContactLog,
    count: usize,
    tell: &'a mut dyn FnMut(&Contact),
}

impl<'a> ReportingLog<'a> {
    fn new(log: ContactLog, tell: &'a mut dyn FnMut(&Contact)) -> Self {
        Self { count: log.ended().len(), log, tell }
    }

    fn news(&mut self) {
        let ended = self.log.ended();
        ended[self.count..].iter().for_each(&mut *self.tell);
        self.count = ended.len();
    }
}

impl Listener<f64> for ReportingLog<'_> {
    fn event(&mut self, event: Event<f64>, y: &[f64]) -> ControlFlow<()> {
        let goes_on = self.log.event(event, y);
        self.news();
        goes_on
    }

    fn positive(&mut self, part: &Part<f64>, run: &mut dyn Stepper<f64>) {
        self.log.positive(part, run);
        self.news();
    }
}

/// A method that knows its contacts, together with the log that collects them.
struct Logged<'a> {
    run: Box<dyn ContactStepper + Send>,
    told: ReportingLog<'a>,
}

impl Stepper<f64> for Logged<'_> {
    fn dim(&self) -> usize {
        self.run.dim()
    }

    fn time(&self) -> f64 {
        self.run.time()
    }

    fn done(&self) -> bool {
        self.run.done()
    }

    fn step(&mut self) -> std::result::Result<(), Failure> {
        self.run.step()?;
        let (log, end) = (&mut self.told.log, self.run.time());
        self.run.tell(&mut |piece, start| log.take(piece, (start, end)));
        self.told.news();
        Ok(())
    }

    fn sample(&mut self, t: f64, y: &mut [f64]) {
        self.run.sample(t, y);
    }

    fn stats(&self) -> Stats {
        self.run.stats()
    }
}

/// Everything that a run has recorded up to a time. A run can be continued from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Time reached.
    pub t: f64,
    /// State at this time.
    pub state: Vec<f64>,
    /// Number of samples taken.
    pub taken: usize,
    /// Largest `|E(t) - E(0)|` at samples and at ends of legs, with `E` the
    /// [balance](Energy::balance).
    pub largest: f64,
    /// Energies at the sample times so far.
    pub samples: Vec<Sample>,
    /// Profiles so far.
    pub profiles: Vec<Profile>,
    /// Contacts, if a log was asked for.
    pub contacts: Option<Contacts>,
    /// The largest values of observables so far.
    pub extremes: Vec<(f64, f64)>,
    /// Work so far.
    pub stats: Stats,
    /// Wall time so far.
    pub wall: Duration,
    /// The part of `wall` that samples took.
    pub sampling: Duration,
}

impl Snapshot {
    /// The record of a run at its start.
    pub fn new(run: &Run) -> Self {
        Self {
            t: run.start,
            state: run.initial().as_slice().to_vec(),
            taken: 0,
            largest: 0.0,
            samples: Vec::new(),
            profiles: Vec::new(),
            contacts: run.contacts.then(Contacts::default),
            extremes: Vec::new(),
            stats: Stats::default(),
            wall: Duration::ZERO,
            sampling: Duration::ZERO,
        }
    }
}

/// Number of samples from one profile to the next.
fn stride(run: &Run) -> usize {
    (run.chain.layout().dim() * run.sampling.count()).div_ceil(MOST_NUMBERS).max(1)
}

impl Run {
    /// Runs to the end.
    ///
    /// # Errors
    /// A run that cannot start. A run that fails later returns a [`Trajectory`] with its `failure`
    /// and with all that was recorded before.
    pub fn start(&self) -> Result<Trajectory> {
        self.observe(&mut |_, _| (), &mut |_| ())
    }

    /// As [`start`](Self::start), and calls `seen` with the time of every sample and the state
    /// there, in the layout of the chain, and `told` with each contact of the log once it has
    /// ended. The log must be asked for ([`contacts`](Self::contacts)). `told` is not called with
    /// contacts that are open at the end of the run. It is also called with those that the final
    /// list leaves out as rounding errors in comparison with the largest one.
    ///
    /// ```
    /// # use hertzchain_core::{Boundary, Chain, Params, Run, State};
    /// # let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 5)?;
    /// # let mut state = State::rest(&chain);
    /// state.u_dot_mut()[0] = 1.0;
    /// let run = Run::new(chain, state).until(20.0)?.samples_at(&[0.5, 2.0, 20.0])?.contacts();
    /// let (mut momenta, mut bonds) = (Vec::new(), Vec::new());
    /// run.observe(&mut |_, y| momenta.push(y[5..].iter().sum::<f64>()), &mut |contact| {
    ///     if contact.largest_overlap > 1e-3 {
    ///         bonds.push(contact.bond);
    ///     }
    /// })?;
    /// assert_eq!(momenta.len(), 3);
    /// assert!(momenta.iter().all(|momentum| (momentum - 1.0).abs() < 1e-12));
    /// // The pulse opens one bond after the other; what beads press ahead of it is tiny.
    /// assert_eq!(bonds, [1, 2, 3, 4]);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn observe(&self, seen: &mut dyn FnMut(f64, &[f64]), told: &mut dyn FnMut(&Contact)) -> Result<Trajectory> {
        let ((_, end), (method, setting)) = (self.span()?, self.choice()?);
        let mut recorder = Recorder::new(self, Snapshot::new(self), seen).on_contact(told);
        let failure = recorder.go_on(method, setting, end)?.err();
        Ok(recorder.trajectory(failure))
    }

    /// As [`observe`](Self::observe), by a given stepper in place of a method. Contacts and
    /// crossings are not looked for.
    ///
    /// # Errors
    /// No end, or a state of another chain.
    pub fn observe_by(&self, stepper: &mut impl Stepper<f64>, seen: &mut dyn FnMut(f64, &[f64])) -> Result<Trajectory> {
        self.span()?;
        let mut recorder = Recorder::new(self, Snapshot::new(self), seen);
        let failure = recorder.leg(stepper).err();
        Ok(recorder.trajectory(failure))
    }

    /// Bytes of all that the run records, at least, with a copy of the strains for pictures.
    pub fn record_bytes(&self) -> u64 {
        let (samples, numbers) = (self.sampling.count(), self.chain.layout().dim() + 2 * self.chain.sites());
        let profiles = if self.records == Records::Profiles { samples / stride(self) } else { 0 };
        (samples * size_of::<Sample>() + profiles * (size_of::<Profile>() + size_of::<f64>() * numbers)) as u64
    }
}

/// The stepper of a leg, searched for the changes of sign that the run asks for.
fn searched<'a>(
    method: Method,
    run: &'a Run,
    y: &[f64],
    span: (f64, f64),
    setting: Setting,
    kept: &'a mut Vec<Event<f64>>,
) -> Result<Box<dyn Stepper<f64> + 'a>> {
    let stepper = method.start(run, y, span, setting)?;
    Ok(match &run.crossings {
        Some(crossings) => crossings.watch((run.chain.layout().half(), run.part()), stepper, kept),
        None => stepper,
    })
}

/// The observer of a run. It records the samples and stops runs that are unstable.
pub struct Recorder<'a> {
    run: &'a Run,
    seen: &'a mut dyn FnMut(f64, &[f64]),
    told: Option<&'a mut dyn FnMut(&Contact)>,
    /// Number of samples from one profile to the next.
    stride: usize,
    has_energy: bool,
    initial_energy: Option<f64>,
    initial_size: f64,
    crossings: Vec<Event<f64>>,
    /// Record of the run so far.
    pub kept: Snapshot,
}

impl<'a> Recorder<'a> {
    /// Continues a run from `kept`; `seen` is called with the time of every sample and the state
    /// there.
    pub fn new(run: &'a Run, kept: Snapshot, seen: &'a mut dyn FnMut(f64, &[f64])) -> Self {
        let (chain, y) = (&run.chain, run.initial().as_slice());
        let energy = chain.has_energy(y).then(|| chain.energy(y));
        Self {
            run,
            seen,
            told: None,
            stride: stride(run),
            has_energy: energy.is_some(),
            initial_energy: energy.map(|energy| energy.balance()),
            initial_size: max_norm(y.iter().copied()),
            crossings: Vec::new(),
            kept,
        }
    }

    /// Sets the function that is called with each contact of the log once it has ended.
    #[must_use]
    fn on_contact(mut self, told: &'a mut dyn FnMut(&Contact)) -> Self {
        self.told = Some(told);
        self
    }

    /// Continues the run with a method up to `end`. Contacts are logged if the record has a log.
    ///
    /// # Errors
    /// A leg that cannot start. The inner result is the failure that stopped the leg.
    pub fn go_on(&mut self, method: Method, setting: Setting, end: f64) -> Result<std::result::Result<(), Failed>> {
        let (run, state, start) = (self.run, &self.kept.state, self.kept.t);
        let (span, mut kept) = ((start, end), std::mem::take(&mut self.crossings));
        let Some(contacts) = self.kept.contacts.take() else {
            let mut stepper = searched(method, run, state, span, setting, &mut kept)?;
            let result = self.leg(&mut stepper);
            drop(stepper);
            self.crossings = kept;
            return Ok(result);
        };
        let chain = &run.chain;
        let log = ContactLog::new(chain.clone()).go_on(contacts, start);
        let (told, mut nobody) = (self.told.take(), |_: &Contact| ());
        let told = ReportingLog::new(log, told.unwrap_or(&mut nobody));
        // A run that may end inside a step has the contacts up to there.
        let knows = if run.crossings.is_some() { None } else { start_logged(method, run, state, span, setting)? };
        let (result, told) = if let Some(run) = knows {
            let mut logged = Logged { run, told };
            (self.leg(&mut logged), logged.told)
        } else {
            let stepper = searched(method, run, state, span, setting, &mut kept)?;
            let watch = Watch::new(stepper, Overlaps::new(chain.clone()), told);
            let mut watch = if run.crossings.is_some() { watch.in_parts(run.part()) } else { watch };
            (self.leg(&mut watch), watch.into_listener())
        };
        self.crossings = kept;
        self.kept.contacts = Some(told.log.into_contacts());
        Ok(result)
    }

    /// Continues the run with a stepper that starts from the record.
    fn leg(&mut self, stepper: &mut dyn Stepper<f64>) -> std::result::Result<(), Failed> {
        let mut state = std::mem::take(&mut self.kept.state);
        let clock = Instant::now();
        let (run, extremes) = (self.run, std::mem::take(&mut self.kept.extremes));
        let search = run.observables.as_ref();
        let search =
            search.map(|observables| Search::new(stepper, observables, run.part(), extremes).cut_at_events(&run.chain));
        let mut timed = Timed { run: stepper, search, sampling: Duration::ZERO };
        let driven = drive(&mut timed, self, &mut state).map(|_| ());
        let Timed { run: stepper, search, sampling } = timed;
        self.kept.extremes = search.map_or(Vec::new(), |search| search.largest);
        self.kept.sampling += sampling;
        self.kept.wall += clock.elapsed();
        self.close(driven, stepper.time(), state, stepper.stats())
    }

    /// Takes the end of a leg: its time, state and work.
    pub(super) fn close(
        &mut self,
        driven: std::result::Result<(), Failure>,
        t: f64,
        state: Vec<f64>,
        stats: Stats,
    ) -> std::result::Result<(), Failed> {
        let checked = driven.and_then(|()| self.check(t, &state, stats));
        let h = (stats.steps > 0).then(|| (t - self.kept.t) / stats.steps as f64);
        let result = checked.map(|_| ()).map_err(|cause| self.failed(cause, h, &state));
        self.kept.stats = self.kept.stats + stats;
        (self.kept.t, self.kept.state) = (t, state);
        result
    }

    /// Adds the mean step and the place on the chain to a failure, where they apply.
    fn failed(&self, cause: Failure, h: Option<f64>, y: &[f64]) -> Failed {
        let chain = &self.run.chain;
        let (h, place, largest) = match cause {
            Failure::NotFinite { index, .. } => (h, Some(chain.place(index)), None),
            Failure::Unstable { .. } => {
                let largest = |(i, value): &(usize, &f64), (k, other): &(usize, &f64)| {
                    value.abs().total_cmp(&other.abs()).then(i.cmp(k))
                };
                let (index, largest) = y.iter().enumerate().max_by(largest).unwrap_or((0, &0.0));
                (h, Some(format!("largest is {}", chain.place(index))), Some(Box::new((index, *largest))))
            }
            Failure::NoContraction { bond, .. } => {
                (None, Some(format!("the bond to the left of site {}", Overlaps::new(chain.clone()).bond(bond))), None)
            }
            _ => (None, None, None),
        };
        Failed { cause, h, place, largest, si: false }
    }

    /// The result of the run.
    pub fn trajectory(self, failure: Option<Failed>) -> Trajectory {
        let energy = self.energy(&self.kept.state);
        let Snapshot { t, state, largest, samples, profiles, contacts, extremes, stats, wall, sampling, .. } =
            self.kept;
        let contacts = contacts.map(|contacts| contacts.list());
        let (open, still) = (self.run.chain.open(), self.run.chain.energy_of_magnets());
        // What flows through an open chain may be much more than what it holds.
        let flow =
            samples.iter().filter_map(|sample: &Sample| sample.energy).chain(energy).fold(0.0, |most, energy| {
                energy.driven.abs().max(energy.dissipated).max(energy.total() - still).max(most)
            });
        let unit = if open { flow } else { (self.initial_energy.unwrap_or(1.0) - still).abs() };
        let energy_error = energy.map(|_| if unit == 0.0 { largest } else { largest / unit });
        let warnings = warnings(self.run, energy_error, stats);
        Trajectory {
            t,
            state,
            energy,
            energy_error,
            samples,
            profiles,
            contacts,
            extremes,
            crossings: self.crossings,
            stats,
            wall,
            sampling,
            warnings,
            failure,
        }
    }

    fn energy(&self, y: &[f64]) -> Option<Energy<f64>> {
        self.has_energy.then(|| self.run.chain.energy(y))
    }

    /// Refuses a state that is not finite, or whose energy or size exceeds its bound.
    fn check(&mut self, t: f64, y: &[f64], stats: Stats) -> std::result::Result<Option<Energy<f64>>, Failure> {
        let step = self.kept.stats.steps + stats.steps;
        if let Some(index) = lost(y) {
            return Err(Failure::NotFinite { t, step, index });
        }
        let energy = self.energy(y);
        let (quantity, initial, value, bound) = match (energy, self.initial_energy) {
            (Some(energy), Some(initial)) => ("energy", initial, energy.balance(), ENERGY_BOUND),
            _ => ("largest entry of the state", self.initial_size, max_norm(y.iter().copied()), SIZE_BOUND),
        };
        if energy.is_some() {
            self.kept.largest = self.kept.largest.max((value - initial).abs());
        }
        // An open chain is compared with what flows through it. An energy that overflows exceeds
        // the bound too.
        let scale = energy.map_or(initial, |energy| initial.max(energy.dissipated).max(energy.driven.abs()));
        if !value.is_finite() || initial > 0.0 && value > bound * scale {
            return Err(Failure::Unstable { quantity, initial, value, t, step });
        }
        Ok(energy)
    }
}

/// Length of the blocks in which a state is searched for values that are not finite.
const BLOCK: usize = 512;

/// Index of the first entry that is not finite.
fn lost(y: &[f64]) -> Option<usize> {
    // No branch inside a block, so that the compiler can vectorise the loop.
    let some = |block: &[f64]| block.iter().fold(false, |lost, value| lost | !value.is_finite());
    y.chunks(BLOCK).any(some).then(|| y.iter().position(|value| !value.is_finite()))?
}

impl Observer<f64> for Recorder<'_> {
    fn next(&self) -> Option<f64> {
        self.run.sample_time(self.kept.taken)
    }

    fn observe(&mut self, t: f64, y: &[f64], stats: Stats) -> std::result::Result<ControlFlow<()>, Failure> {
        let clock = Instant::now();
        self.kept.taken += 1;
        let energy = self.check(t, y, stats)?;
        self.kept.samples.push(Sample { t, energy });
        if self.run.records == Records::Profiles && (self.kept.taken - 1).is_multiple_of(self.stride) {
            self.kept.profiles.push(Profile { t, x: self.run.chain.strains(y), state: y.to_vec() });
        }
        (self.seen)(t, y);
        self.kept.sampling += clock.elapsed();
        Ok(ControlFlow::Continue(()))
    }
}
