//! Ladders of settings that all methods refine together, level by level.
//!
//! Levels go in factors of two for steps and of ten for tolerances. A ladder ends early for one of
//! three reasons: the reference resolves no smaller error; the time is up; or a run of the next
//! level takes more than a 400th of all time and is expected to be dominated: some row of another
//! method has an error that is not larger in a time that is not longer. The expected error is the
//! last one times the better of the last two gains of the ladder (the nominal one counts while
//! there are fewer), and the expected time is that of the last level. So a level that is left out
//! would have had to gain more than its ladder did lately.

use super::{
    Candidate, ErrorNorm, Progress, Row,
    reference::{ReferenceState, TRUSTED, steps},
};
use crate::{
    error::Result,
    interrupt::{self, Token},
    plain::{Loop, Sites},
    run::{
        Trajectory,
        method::{Method, Setting},
    },
    scene::Scene,
    study::run::error_in_file,
    sweep::map,
};
use hertzchain_integrators::{Error as Failure, Silent, Stats, drive};
use std::time::Instant;

/// Contact kicks a period of the fastest motion on the first level of a method with fixed steps:
/// the same work for every scheme. Each level has twice those of the one before.
const KICKS: f64 = 8.0;
/// Tolerances on the levels of an adaptive method; every ladder has as many levels.
const TOLERANCES: [f64; 12] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];
/// A level whose run takes a smaller share of the time than this is never left out.
const CHEAP: f64 = 1.0 / 400.0;
/// Approximate cost of a level in runs: one for its error, and those that are timed.
const RUNS: f64 = 4.0;
/// Growth of the cost from level to level, at most.
const GROWTH: f64 = 2.0;
/// Number of last gains from which the error of the next level is expected.
const GAINS: usize = 2;

#[derive(Clone, Copy)]
pub(super) struct Level(usize);

impl Level {
    fn kicks(self) -> f64 {
        KICKS * (self.0 as f64).exp2()
    }

    fn tolerance(self) -> f64 {
        TOLERANCES[self.0]
    }

    fn setting(self, scene: &Scene, method: &Method) -> Setting {
        if method.adaptive() {
            Setting::Tolerance(self.tolerance())
        } else {
            Setting::Steps(steps(scene, method.info().stages, self.kicks()))
        }
    }

    fn words(self, candidate: &Candidate) -> String {
        if candidate.adaptive() { format!("tol {:e}", self.tolerance()) } else { format!("{} kicks", self.kicks()) }
    }
}

/// Median wall time of runs that record nothing, their number, and their work.
pub(in crate::study) fn time(
    scene: &Scene,
    method: Method,
    setting: Setting,
    left: f64,
) -> Result<(f64, usize, Stats)> {
    let mut y = scene.initial().as_slice().to_vec();
    median(left, || {
        // The set-up of a method is part of its run: to meet a tolerance it may make runs of its
        // own.
        let mut stepper = scene.run().method(method).setting(setting).stepper()?;
        drive(&mut *stepper, &mut Silent, &mut y)?;
        Ok(stepper.stats())
    })
}

fn median(left: f64, mut run: impl FnMut() -> Result<Stats>) -> Result<(f64, usize, Stats)> {
    let mut walls = Vec::new();
    loop {
        let clock = Instant::now();
        let stats = run()?;
        walls.push(clock.elapsed().as_secs_f64());
        let total: f64 = walls.iter().sum();
        let wanted = if total > 0.05 { 3 } else { 7 };
        if walls.len() >= wanted || total + walls[0] > 0.1 * left.max(0.0) {
            walls.sort_by(f64::total_cmp);
            return Ok((walls[walls.len() / 2], walls.len(), stats));
        }
    }
}

/// A run of a plain loop: the state at the end, and the work.
fn plain(scene: &Scene, plain: Loop, level: Level) -> (Vec<f64>, Stats) {
    let steps = steps(scene, plain.kicks(), level.kicks());
    let mut sites = Sites::new(scene.chain(), scene.initial().as_slice());
    plain.run(&mut sites, scene.end() / steps as f64, steps);
    (sites.state(), Stats { steps, force_evaluations: plain.evaluations(steps), rejected: 0 })
}

/// At least so many seconds of a plain loop: a nanosecond for each kick of a site.
fn plain_seconds(scene: &Scene, plain: Loop, level: Level) -> f64 {
    1e-9 * scene.chain().sites() as f64 * plain.kicks() as f64 * steps(scene, plain.kicks(), level.kicks()) as f64
}

/// Why a run has no row.
const OVER: &str = "--max-time was over, or a signal came, before this run ended";

/// The levels of a candidate so far.
pub struct Ladder {
    /// What runs.
    pub candidate: Candidate,
    /// A row a level, coarse to fine.
    pub rows: Vec<Row>,
    /// Why it does not go on.
    pub stopped: Option<String>,
}

impl Ladder {
    fn new(candidate: Candidate) -> Self {
        Self { candidate, rows: Vec::new(), stopped: None }
    }

    /// The smallest error that the next level is expected to have.
    pub fn expected(&self) -> Option<f64> {
        let last = self.rows.last()?.error?;
        let nominal = match self.candidate {
            Candidate::Method(method) if method.adaptive() => 0.1,
            Candidate::Method(method) => 0.5f64.powi(method.info().order as i32),
            Candidate::Plain(_) => 0.25,
        };
        let gains: Vec<f64> =
            self.rows.windows(2).rev().take(GAINS).filter_map(|pair| Some(pair[1].error? / pair[0].error?)).collect();
        let nominal = (gains.len() < GAINS).then_some(nominal);
        Some(last * gains.into_iter().chain(nominal).fold(1.0, f64::min))
    }

    fn last_wall(&self) -> Option<f64> {
        self.rows.last()?.wall
    }
}

/// All ladders, which are refined together.
pub struct Refinement<'a> {
    scene: &'a Scene,
    /// One a candidate.
    pub ladders: Vec<Ladder>,
    budget: f64,
    clock: Instant,
    progress: Progress<'a>,
}

impl<'a> Refinement<'a> {
    /// The clock of the budget starts here.
    pub fn new(scene: &'a Scene, candidates: Vec<Candidate>, budget: f64, progress: Progress<'a>) -> Self {
        let ladders = candidates.into_iter().map(Ladder::new).collect();
        Self { scene, ladders, budget, clock: Instant::now(), progress }
    }

    fn spent(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }

    pub(super) fn run(&mut self, reference: &ReferenceState) {
        for level in (0..TOLERANCES.len()).map(Level) {
            let going = self.going(reference);
            if going.is_empty() || (level.0 > 0 && interrupt::asked()) {
                break;
            }
            let candidates: Vec<Candidate> = going.iter().map(|&index| self.ladders[index].candidate).collect();
            // The first level of a long run may take longer than all of the time.
            let left = self.budget - self.spent();
            let rows = Token::timed(left)
                .within(|| map(&candidates, |candidate| reference.row(self.scene, *candidate, level, left)));
            for (index, row) in going.into_iter().zip(rows) {
                (self.progress)(self.spent() / self.budget, &format!("{} at {}", row.candidate.name(), row.setting));
                let row = self.timed(row, level);
                self.ladders[index].rows.push(row);
            }
        }
    }

    pub(super) fn finish(self) -> (Vec<Row>, Vec<(Candidate, String)>) {
        let stopped = |ladder: &Ladder| Some((ladder.candidate, ladder.stopped.clone()?));
        let stopped = self.ladders.iter().filter_map(stopped).collect();
        (self.ladders.into_iter().flat_map(|ladder| ladder.rows).collect(), stopped)
    }

    /// The indices of the ladders that have a next level. The others store why they have none.
    fn going(&mut self, reference: &ReferenceState) -> Vec<usize> {
        let mut left = self.budget - self.spent();
        let mut going = Vec::new();
        for index in 0..self.ladders.len() {
            if self.ladders[index].stopped.is_some() {
                continue;
            }
            let cost = RUNS * GROWTH * self.ladders[index].last_wall().unwrap_or(0.0);
            let stopped = self.dominated(index, reference).or_else(|| {
                let over = !self.ladders[index].rows.is_empty() && cost > left;
                over.then(|| "--max-time leaves no time for the next level".to_owned())
            });
            if stopped.is_none() {
                left -= cost;
                going.push(index);
            }
            self.ladders[index].stopped = stopped;
        }
        going
    }

    /// Why the next level of a ladder is left out; `None` if it takes little time or may show
    /// something.
    pub fn dominated(&self, index: usize, reference: &ReferenceState) -> Option<String> {
        let ladder = &self.ladders[index];
        let (expected, wall) = (ladder.expected()?, ladder.last_wall()?);
        if GROWTH * wall < CHEAP * self.budget {
            return None;
        }
        if ladder.rows.last()?.below_reference {
            return Some("the reference resolves no smaller error".to_owned());
        }
        let floor = TRUSTED * reference.error_estimate;
        let better = |row: &&Row| {
            row.error.is_some_and(|error| error.max(floor) <= expected.max(floor))
                && row.wall.is_some_and(|other| other <= wall)
        };
        let others = self.ladders.iter().filter(|other| other.candidate != ladder.candidate);
        let best =
            others.flat_map(|other| &other.rows).filter(better).min_by(|a, b| a.wall.partial_cmp(&b.wall).unwrap())?;
        Some(format!("beaten by {} at {}; next error {expected:.1e}", best.candidate.name(), best.setting))
    }

    fn timed(&self, mut row: Row, level: Level) -> Row {
        if row.failure.is_none() && interrupt::asked() {
            row.failure = Some("stopped by a signal before it was timed".to_owned());
        }
        if row.failure.is_some() {
            return row;
        }
        let (scene, left) = (self.scene, self.budget - self.spent());
        let timed = match row.candidate {
            Candidate::Method(method) => time(scene, method, level.setting(scene, &method), left),
            Candidate::Plain(of) => median(left, || Ok(plain(scene, of, level).1)),
        };
        match timed {
            Ok((wall, repeats, stats)) => Row { wall: Some(wall), repeats, stats, ..row },
            Err(why) => Row { failure: Some(why.to_string()), error: None, energy_error: None, ..row },
        }
    }
}

impl ReferenceState {
    /// The row of a method or loop, also of one that cannot even start; not yet timed.
    fn row(&self, scene: &Scene, candidate: Candidate, level: Level, left: f64) -> Row {
        match candidate {
            Candidate::Plain(of) if plain_seconds(scene, of, level) > left => {
                Row::failed(candidate, level.words(&candidate), OVER.to_owned())
            }
            Candidate::Method(method) => self.row_of_method(scene, method, level),
            Candidate::Plain(of) => {
                let (state, stats) = plain(scene, of, level);
                let row = Row::failed(candidate, level.words(&candidate), String::new());
                let row = Row { step: scene.end() / stats.steps as f64, stats, ..row };
                if state.iter().all(|value| value.is_finite()) {
                    self.judged(row, Some(self.error(scene, &candidate, &state)))
                } else {
                    Row { failure: Some("the state is not finite: the step is too long".to_owned()), ..row }
                }
            }
        }
    }

    fn row_of_method(&self, scene: &Scene, method: Method, level: Level) -> Row {
        let candidate = Candidate::Method(method);
        let run = scene.run().method(method).setting(level.setting(scene, &method));
        let outcome = match run.start() {
            Ok(outcome) => outcome,
            Err(why) => return Row::failed(candidate, level.words(&candidate), why.to_string()),
        };
        let Trajectory { t, state, energy_error, stats, failure, .. } = outcome;
        let words = failure.as_ref().map_or(String::new(), |failure| match failure.cause {
            Failure::Stopped { .. } => OVER.to_owned(),
            _ => error_in_file(failure.clone().into(), scene).to_string(),
        });
        let row = Row {
            step: t / stats.steps.max(1) as f64,
            stats,
            ..Row::failed(candidate, level.words(&candidate), words)
        };
        if failure.is_some() {
            return row;
        }
        let error = match self.norm {
            ErrorNorm::Energy => energy_error,
            _ => Some(self.error(scene, &candidate, &state)),
        };
        self.judged(Row { energy_error, ..row }, error)
    }

    fn judged(&self, row: Row, error: Option<f64>) -> Row {
        let below_reference = error.is_some_and(|error| error < TRUSTED * self.error_estimate);
        Row { error, below_reference, failure: None, ..row }
    }
}
