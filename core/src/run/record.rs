//! What a run leaves behind, and the observer that keeps it.

use super::{Method, Run, Setting, method::start_logged};
use crate::{
    chain::{Contact, ContactLog, Energy, Overlaps, join, max_norm},
    error::{Failed, Result},
    interrupt,
};
use hertzchain_integrators::{Error as Failure, Observer, Stats, Stepper, Watch, collocation::ContactStepper, drive};
use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

/// A run is called unstable when its energy exceeds the initial one by this factor: no accurate run comes near it.
const ENERGY_BOUND: f64 = 10.0;
/// The same for the largest entry of a state that has no energy.
const SIZE_BOUND: f64 = 1e3;

/// Most numbers that profiles may hold (half a gigabyte); longer runs of longer chains keep every k-th sample.
const MOST_NUMBERS: usize = 1 << 26;

/// Numbers of a state that are looked at together.
const BLOCK: usize = 512;

/// What to keep on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Records {
    /// Nothing but the end; nothing is checked on the way either.
    End,
    /// Energies at the sample times.
    Energy,
    /// Energies and strain profiles.
    Profiles,
}

/// Energy at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time.
    pub t: f64,
    /// Energy by kind; `None` where the strain ring has none.
    pub energy: Option<Energy<f64>>,
}

/// Positions at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Time.
    pub t: f64,
    /// Strains of beads, see [`Chain::strains`](crate::chain::Chain::strains).
    pub x: Vec<f64>,
    /// The whole state.
    pub state: Vec<f64>,
}

/// What a run leaves behind. A run that failed keeps all it had.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// Time reached.
    pub t: f64,
    /// State there, in the chain's layout.
    pub state: Vec<f64>,
    /// Energy there, if the state has one.
    pub energy: Option<Energy<f64>>,
    /// Largest `|E(t) - E(0)| / |E(0)|` seen (absolute where `E(0) = 0`).
    pub energy_error: Option<f64>,
    /// Energies on the way, the start included.
    pub samples: Vec<Sample>,
    /// Profiles on the way.
    pub profiles: Vec<Profile>,
    /// Contacts in the order of their onsets, if they were asked for.
    pub contacts: Option<Vec<Contact>>,
    /// Work of the run, samples included.
    pub stats: Stats,
    /// Wall time of the run, samples included.
    pub wall: Duration,
    /// The part of it that samples took: states brought to the sample times, energies, strains.
    pub sampling: Duration,
    /// Why it stopped before the end, if it did.
    pub failure: Option<Failed>,
}

impl Trajectory {
    /// The same, if the run got to its end.
    ///
    /// # Errors
    /// Why it did not.
    pub fn complete(self) -> Result<Self> {
        match self.failure {
            Some(failure) => Err(failure.into()),
            None => Ok(self),
        }
    }
}

/// A stepper whose samples are timed.
struct Timed<'a, S: ?Sized> {
    run: &'a mut S,
    /// What its samples have taken.
    sampling: Duration,
}

impl<S: Stepper<f64> + ?Sized> Stepper<f64> for Timed<'_, S> {
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
        self.run.step()
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

/// A method that knows its contacts, and hands what they do to a log.
struct Logged {
    run: Box<dyn ContactStepper + Send>,
    log: ContactLog,
}

impl Stepper<f64> for Logged {
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
        let log = &mut self.log;
        self.run.tell(&mut |piece, start| log.take(piece, start));
        Ok(())
    }

    fn sample(&mut self, t: f64, y: &mut [f64]) {
        self.run.sample(t, y);
    }

    fn stats(&self) -> Stats {
        self.run.stats()
    }
}

fn nonzero(energy: f64) -> f64 {
    if energy == 0.0 { 1.0 } else { energy.abs() }
}

/// All that a run has at a time: it goes on from there.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Time reached.
    pub t: f64,
    /// State there.
    pub state: Vec<f64>,
    /// Samples taken.
    pub taken: usize,
    /// Largest `|E(t) - E(0)|`.
    pub largest: f64,
    /// Energies so far.
    pub samples: Vec<Sample>,
    /// Profiles so far.
    pub profiles: Vec<Profile>,
    /// Contacts, if they are asked for.
    pub contacts: Option<Vec<Contact>>,
    /// Work so far.
    pub stats: Stats,
    /// Wall time so far.
    pub wall: Duration,
    /// The part of `wall` that samples took.
    pub sampling: Duration,
}

impl Kept {
    /// The start.
    pub fn new(run: &Run) -> Self {
        Self {
            t: 0.0,
            state: run.initial.as_slice().to_vec(),
            taken: 0,
            largest: 0.0,
            samples: Vec::new(),
            profiles: Vec::new(),
            contacts: run.contacts.then(Vec::new),
            stats: Stats::default(),
            wall: Duration::ZERO,
            sampling: Duration::ZERO,
        }
    }
}

/// The observer of a run: keeps what was asked for, and stops what has blown up.
pub struct Recorder<'a> {
    run: &'a Run,
    progress: &'a mut dyn FnMut(f64),
    /// Samples from one kept profile to the next.
    stride: usize,
    has_energy: bool,
    initial_energy: Option<f64>,
    initial_size: f64,
    /// What is kept.
    pub kept: Kept,
}

impl<'a> Recorder<'a> {
    /// Goes on with a run from what is kept; `progress` is told the time at every sample.
    pub fn new(run: &'a Run, kept: Kept, progress: &'a mut dyn FnMut(f64)) -> Self {
        let y = run.initial.as_slice();
        let has_energy = run.chain.has_energy(y);
        Self {
            run,
            progress,
            stride: (y.len() * (run.samples + 1)).div_ceil(MOST_NUMBERS),
            has_energy,
            initial_energy: has_energy.then(|| run.chain.energy(y).total()),
            initial_size: max_norm(y.iter().copied()),
            kept,
        }
    }

    /// Goes on by a method up to `end`, watched for contacts if they are kept.
    ///
    /// # Errors
    /// A leg that cannot start; inside, why it stopped on the way.
    pub fn go_on(&mut self, method: Method, setting: Setting, end: f64) -> Result<std::result::Result<(), Failed>> {
        let (run, state, start) = (self.run, &self.kept.state, self.kept.t);
        let span = (start, end);
        if self.kept.contacts.is_none() {
            let mut stepper = method.start(run, state, span, setting)?;
            return Ok(self.leg(&mut stepper));
        }
        let chain = &run.chain;
        let log = ContactLog::new(chain.clone());
        let (result, log) = if let Some(run) = start_logged(method, run, state, span, setting)? {
            let mut logged = Logged { run, log };
            (self.leg(&mut logged), logged.log)
        } else {
            let stepper = method.start(run, state, span, setting)?;
            let mut watch = Watch::new(stepper, Overlaps::new(chain.clone()), log);
            (self.leg(&mut watch), watch.into_listener())
        };
        // Contacts that are there at the start of the run have no onset, those at the start of a later leg had theirs before.
        let (before, after) = (self.kept.contacts.take().unwrap_or_default(), log.contacts());
        self.kept.contacts = Some(if start > 0.0 { join(before, after, start) } else { after });
        Ok(result)
    }

    /// Goes on with a stepper that starts from what is kept.
    pub(super) fn leg(&mut self, stepper: &mut impl Stepper<f64>) -> std::result::Result<(), Failed> {
        let mut state = std::mem::take(&mut self.kept.state);
        let clock = Instant::now();
        let mut timed = Timed { run: stepper, sampling: Duration::ZERO };
        let driven = drive(&mut timed, self, &mut state);
        let Timed { run: stepper, sampling } = timed;
        self.kept.sampling += sampling;
        self.kept.wall += clock.elapsed();
        let (from, t, stats) = (self.kept.t, stepper.time(), stepper.stats());
        let checked = driven.and_then(|_| self.check(t, &state, stats));
        let h = (stats.steps > 0).then(|| (t - from) / stats.steps as f64);
        let result = checked.map(|_| ()).map_err(|cause| self.failed(cause, h, &state));
        self.kept.stats = self.kept.stats + stats;
        (self.kept.t, self.kept.state) = (t, state);
        result
    }

    /// Where that was, as far as it has a place.
    fn failed(&self, cause: Failure, h: Option<f64>, y: &[f64]) -> Failed {
        let chain = &self.run.chain;
        let (h, place) = match cause {
            Failure::NotFinite { index, .. } => (h, Some(chain.place(index))),
            Failure::Unstable { .. } => {
                let largest = (0..y.len()).max_by(|&a, &b| y[a].abs().total_cmp(&y[b].abs()));
                (h, largest.map(|index| format!("largest is {} = {:e}", chain.place(index), y[index])))
            }
            Failure::NoContraction { bond, .. } => {
                (None, Some(format!("the bond to the left of site {}", Overlaps::new(chain.clone()).bond(bond))))
            }
            _ => (None, None),
        };
        Failed { cause, h, place }
    }

    /// What the run leaves behind.
    pub fn trajectory(self, failure: Option<Failed>) -> Trajectory {
        let energy = self.energy(&self.kept.state);
        let Kept { t, state, largest, samples, profiles, contacts, stats, wall, sampling, .. } = self.kept;
        let energy_error = energy.map(|_| largest / self.initial_energy.map_or(1.0, nonzero));
        Trajectory { t, state, energy, energy_error, samples, profiles, contacts, stats, wall, sampling, failure }
    }

    fn energy(&self, y: &[f64]) -> Option<Energy<f64>> {
        self.has_energy.then(|| self.run.chain.energy(y))
    }

    /// Refuses a state that is not finite or that only an unstable method reaches.
    fn check(&mut self, t: f64, y: &[f64], stats: Stats) -> std::result::Result<Option<Energy<f64>>, Failure> {
        let step = self.kept.stats.steps + stats.steps;
        // Block by block without a branch: the first look at a long state is a loop over vectors.
        let lost = |block: &[f64]| block.iter().fold(false, |lost, value| lost | !value.is_finite());
        if y.chunks(BLOCK).any(lost) {
            let index = y.iter().position(|value| !value.is_finite()).unwrap_or_default();
            return Err(Failure::NotFinite { t, step, index });
        }
        let energy = self.energy(y);
        let (quantity, initial, value, bound) = match (energy, self.initial_energy) {
            (Some(energy), Some(initial)) => ("energy", initial, energy.total(), ENERGY_BOUND),
            _ => ("largest entry of the state", self.initial_size, max_norm(y.iter().copied()), SIZE_BOUND),
        };
        if energy.is_some() {
            self.kept.largest = self.kept.largest.max((value - initial).abs());
        }
        // An energy that overflows is beyond every bound.
        if !value.is_finite() || initial > 0.0 && value > bound * initial {
            return Err(Failure::Unstable { quantity, initial, value, t, step });
        }
        Ok(energy)
    }
}

impl Observer<f64> for Recorder<'_> {
    fn next(&self) -> Option<f64> {
        let (samples, taken) = (self.run.samples, self.kept.taken);
        let wanted = self.run.records != Records::End && samples > 0 && taken <= samples;
        wanted.then(|| self.run.end * (taken as f64 / samples as f64))
    }

    fn observe(&mut self, t: f64, y: &[f64], stats: Stats) -> std::result::Result<ControlFlow<()>, Failure> {
        let clock = Instant::now();
        self.kept.taken += 1;
        let energy = self.check(t, y, stats)?;
        self.kept.samples.push(Sample { t, energy });
        if self.run.records == Records::Profiles && (self.kept.taken - 1).is_multiple_of(self.stride) {
            self.kept.profiles.push(Profile { t, x: self.run.chain.strains(y), state: y.to_vec() });
        }
        (self.progress)(t);
        self.kept.sampling += clock.elapsed();
        Ok(ControlFlow::Continue(()))
    }

    fn stop(&self) -> bool {
        interrupt::asked()
    }
}
