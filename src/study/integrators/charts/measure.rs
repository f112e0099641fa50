//! One point: a method on a variant, over a ladder of steps or tolerances.

use super::problem::Prepared;
use crate::{
    error::Result,
    named::named,
    run::method::{Method, Setting, Split},
    study::{integrators::drift::energy, run::error_in},
};
use hertzchain_integrators::{DoubleDouble, Stepper};
use serde::{Deserialize, Serialize};
use std::{f64::consts::TAU, time::Instant};

/// The energy errors for which the largest step is looked for.
pub const BOUNDS: [f64; 2] = [1e-3, 1e-6];
/// Number of times at which the energy of a run is evaluated: the most, the most times sites (for
/// long chains), and the least.
const LOOKS: (f64, f64, f64) = (128.0, 4e6, 8.0);
/// Energy error above which a run counts as unbounded.
const BLOWN: f64 = 1e6;
/// Energy errors up to this are rounding.
const ROUNDING: f64 = 1e-12;
/// A drift is a line through the errors that rises over the run by more than this many times its
/// root mean square residual.
const DRIFT: f64 = 4.0;
/// The longest step of a ladder, in radians of the fastest motion; of the contacts, where the
/// linear flow is exact.
const LONGEST: f64 = 12.0;
/// The first and the last tolerance of a ladder, and the ratio of each to the next.
const TOLERANCES: (f64, f64, f64) = (1e-1, 1e-13, 10.0);
/// The usual setting: kicks a period of the fastest motion for a method with fixed steps, and the
/// tolerance of an adaptive method.
const KICKS: f64 = 64.0;
const TOLERANCE: f64 = 1e-9;
/// Force evaluations that a run may take on any chain, in addition to those for which its work is
/// enough: with fixed steps, with adaptive ones, and at the usual setting.
const LEAST_FIXED: f64 = 50.0;
const LEAST_ADAPTIVE: f64 = 1e3;
const LEAST_USUAL: f64 = 1e4;
/// Number of bisections for the step of a [`Limit`], and for the limit of stability.
const BISECTIONS: (usize, usize) = (2, 10);
/// Steps that the chart `light` tries in any case go down to this one, in radians of the fastest
/// motion.
const LEAST_LIGHT: f64 = 0.1;

named! {
    /// The outcome of a run.
    pub enum Behaviour {
        /// The energy error has no trend and is at most 1.
        Stable = "stable",
        /// The energy error has a trend: a line through it rises by more than four of its
        /// residuals. An error below 10^-12 is rounding and counts as none; so does one of contact
        /// collocation below its tolerance.
        Drifting = "drifting",
        /// The energy error is above 1, or the run failed.
        Lost = "lost",
        /// The run was left out or stopped, since it takes more work than it may.
        Dear = "dear",
    }
}

/// A run at one step or tolerance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// The step, the mean one for adaptive methods, in units of time.
    pub step: f64,
    /// The tolerance of an adaptive method.
    pub tol: Option<f64>,
    /// The outcome.
    #[serde(rename = "verdict")]
    pub behaviour: Behaviour,
    /// Largest `|H - H(0)|/|H(0)|` at 128 times; `None` if it was not bounded or the run failed.
    pub error: Option<f64>,
    /// Whether the error passed 10^6.
    pub blown: bool,
    /// Force evaluations a unit of time.
    pub cost: f64,
    /// Wall time in seconds a unit of time, evaluations of the energy included. It depends on the
    /// load of the machine.
    pub wall: f64,
    /// Why it failed.
    pub failure: Option<String>,
}

impl Trial {
    fn meets(&self, bound: f64) -> bool {
        self.error.is_some_and(|error| error < bound)
            && matches!(self.behaviour, Behaviour::Stable | Behaviour::Drifting)
    }
}

/// The largest step that keeps the energy error below a bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The bound.
    pub bound: f64,
    /// The run at that step: the first level of the ladder, from coarse to fine, after the last
    /// that does not meet the bound, refined to 9 % of the step. `None` if no run that is cheap
    /// enough meets the bound.
    pub trial: Option<Trial>,
    /// Whether this is the longest step that was tried, so that a longer one may meet the bound.
    pub longest: bool,
}

/// What was measured at a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// `Omega_c`, radians a unit of time.
    pub contact: f64,
    /// `max(omega, Omega_c)`.
    pub fast: f64,
    /// Length of the runs in units of time.
    pub span: f64,
    /// The run at the usual setting: 64 kicks a period of the fastest motion, or tolerance 10^-9.
    pub usual: Trial,
    /// All others, from coarse to fine.
    pub ladder: Vec<Trial>,
    /// The largest steps for [`BOUNDS`].
    pub limits: Vec<Limit>,
    /// Limit of stability: the step times `fast` above which the energy error passes 10^6, to a
    /// factor of 1.0004. `None` if it was not looked for, or not found between two levels of the
    /// ladder. Smaller unstable steps between two levels, as some compositions have, are missed.
    pub stability: Option<f64>,
}

/// How much work a measurement may take, and how far its ladder goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Force evaluations times sites that a run may take.
    pub(super) work: f64,
    /// Whether the ladder goes on to short steps whatever the error, and the limit of stability is
    /// bracketed.
    pub(super) light: bool,
}

/// A setting by one number: the step, or the tolerance.
type Knob = f64;

pub(super) fn measure(prepared: &Prepared, method: Method, search: Search) -> Result<Measured> {
    let Prepared { scene, contact, fast, .. } = prepared;
    let sites = scene.chain().sites() as f64;
    // The usual run may take 20 times the work of others: it is the run that users make first.
    let usual = trial(prepared, method, usual_knob(&method, *fast), 20.0 * search.work / sites + LEAST_USUAL)?;
    let most = search.work / sites + if method.adaptive() { LEAST_ADAPTIVE } else { LEAST_FIXED };
    let at = |knob: Knob| trial(prepared, method, knob, most);

    let mut levels: Vec<(Knob, Trial)> = Vec::new();
    for knob in knobs(&method, *contact, *fast, scene.end()) {
        let trial = at(knob)?;
        let dear = trial.behaviour == Behaviour::Dear;
        levels.push((knob, trial));
        let settled = levels.len() > 1 && levels[levels.len() - 2..].iter().all(|(_, trial)| trial.meets(BOUNDS[1]));
        let wanted = search.light && !method.adaptive() && knob * fast > LEAST_LIGHT;
        if dear || settled && !wanted {
            break;
        }
    }
    let limits = BOUNDS.into_iter().map(|bound| limit(&levels, bound, &at)).collect::<Result<_>>()?;
    let stability = if search.light && !method.adaptive() { stability(&levels, &at)? } else { None };
    Ok(Measured {
        contact: *contact,
        fast: *fast,
        span: scene.end(),
        usual,
        ladder: levels.into_iter().map(|(_, trial)| trial).collect(),
        limits,
        stability: stability.map(|step| step * fast),
    })
}

fn usual_knob(method: &Method, fast: f64) -> Knob {
    if method.adaptive() { TOLERANCE } else { TAU * method.info().stages as f64 / (KICKS * fast) }
}

/// The ladder: steps from the longest on, each the one before over `sqrt 2`; or tolerances.
fn knobs(method: &Method, contact: f64, fast: f64, span: f64) -> Box<dyn Iterator<Item = Knob>> {
    if method.adaptive() {
        let (first, last, factor) = TOLERANCES;
        let ladder = (0..).map(move |k| first / f64::powi(factor, k)).take_while(move |tol| *tol > 0.9 * last);
        return Box::new(ladder);
    }
    let longest = match method {
        _ if method.split() == Some(Split::Kinetic) || *method == Method::Conserving => LONGEST / fast,
        // Levels are the same for all methods, counted from those of the fastest motion.
        _ => {
            let most = (LONGEST / contact).min(0.5 * span);
            let level = (2.0 * (most * fast / LONGEST).log2()).floor().max(0.0);
            LONGEST / fast * f64::powf(2.0, 0.5 * level)
        }
    };
    Box::new((0..).map(move |k| longest * f64::powf(2.0, -0.5 * f64::from(k))))
}

/// The first level after the last one that does not meet the bound, refined towards the latter.
fn limit(levels: &[(Knob, Trial)], bound: f64, at: &dyn Fn(Knob) -> Result<Trial>) -> Result<Limit> {
    let runs = levels.iter().rposition(|(_, trial)| trial.behaviour != Behaviour::Dear).map_or(0, |last| last + 1);
    let first = levels[..runs].iter().rposition(|(_, trial)| !trial.meets(bound)).map_or(0, |failing| failing + 1);
    let Some((knob, trial)) = levels[..runs].get(first) else {
        return Ok(Limit { bound, trial: None, longest: false });
    };
    let (mut good, mut best) = (*knob, trial.clone());
    if first > 0 {
        let mut bad = levels[first - 1].0;
        for _ in 0..BISECTIONS.0 {
            let middle = (good * bad).sqrt();
            let trial = at(middle)?;
            if trial.meets(bound) {
                (good, best) = (middle, trial);
            } else {
                bad = middle;
            }
        }
    }
    Ok(Limit { bound, trial: Some(best), longest: first == 0 })
}

/// The step above which the energy has no bound.
fn stability(levels: &[(Knob, Trial)], at: &dyn Fn(Knob) -> Result<Trial>) -> Result<Option<f64>> {
    let Some(blown) = levels.iter().rposition(|(_, trial)| trial.blown) else { return Ok(None) };
    let Some((good, _)) = levels.get(blown + 1).filter(|(_, trial)| trial.behaviour != Behaviour::Dear) else {
        return Ok(None);
    };
    let (mut bad, mut good) = (levels[blown].0, *good);
    for _ in 0..BISECTIONS.1 {
        let middle = (good * bad).sqrt();
        *(if at(middle)?.blown { &mut bad } else { &mut good }) = middle;
    }
    Ok(Some((good * bad).sqrt()))
}

/// Makes one run, which may take at most `most` force evaluations.
pub(super) fn trial(prepared: &Prepared, method: Method, knob: Knob, most: f64) -> Result<Trial> {
    let scene = &prepared.scene;
    let span = scene.end();
    let setting = if method.adaptive() {
        Setting::Tolerance(knob)
    } else {
        Setting::Steps((span / knob).round().max(1.0) as u64)
    };
    let mut trial = Trial {
        step: if method.adaptive() { 0.0 } else { span / (span / knob).round().max(1.0) },
        tol: method.adaptive().then_some(knob),
        behaviour: Behaviour::Dear,
        error: None,
        blown: false,
        cost: 0.0,
        wall: 0.0,
        failure: None,
    };
    if let Setting::Steps(steps) = setting
        && steps as f64 * method.info().stages as f64 > most
    {
        trial.cost = steps as f64 * method.info().stages as f64 / span;
        return Ok(trial);
    }
    let clock = Instant::now();
    let mut run = scene.run().method(method).setting(setting).stepper()?;
    let mut look = Look::new(prepared);
    while !run.done() {
        if let Err(failure) = run.step() {
            trial.failure = Some(error_in(failure.into(), scene, prepared.units.as_ref()).to_string());
            break;
        }
        let dear = run.stats().force_evaluations as f64 > most;
        if run.time() >= look.next || run.done() || dear {
            look.at(&mut *run);
        }
        if look.largest > BLOWN || dear {
            break;
        }
    }
    let (t, stats) = (run.time(), run.stats());
    // Force evaluations for samples of the state are not part of the method's cost.
    let evaluations = (stats.force_evaluations as f64 - look.evaluations).max(1.0);
    if stats.steps > 0 {
        trial.step = t / stats.steps as f64;
        (trial.cost, trial.wall) = (evaluations / t, clock.elapsed().as_secs_f64() / t);
    }
    let bounded = if method == Method::Collocation { knob } else { 0.0 };
    trial.blown = look.largest > BLOWN;
    let lost = trial.failure.is_some() || look.largest > 1.0;
    trial.error = (!trial.blown && trial.failure.is_none()).then_some(look.largest);
    trial.behaviour = match () {
        () if lost => Behaviour::Lost,
        () if !run.done() => Behaviour::Dear,
        () if look.largest > ROUNDING.max(bounded) && look.drifts() => Behaviour::Drifting,
        () => Behaviour::Stable,
    };
    Ok(trial)
}

/// Evaluates the energy error at ends of steps.
struct Look<'a> {
    prepared: &'a Prepared,
    y: Vec<f64>,
    initial: DoubleDouble<f64>,
    /// The next evaluation is at the first end of a step from this time on.
    next: f64,
    every: f64,
    largest: f64,
    errors: Vec<(f64, f64)>,
    /// Force evaluations that samples of the state have taken.
    evaluations: f64,
}

impl<'a> Look<'a> {
    fn new(prepared: &'a Prepared) -> Self {
        let y = prepared.scene.initial().as_slice().to_vec();
        let initial = energy(prepared.scene.chain(), &y);
        let looks = (LOOKS.1 / prepared.scene.chain().sites() as f64).clamp(LOOKS.2, LOOKS.0);
        let every = prepared.scene.end() / looks;
        Self { prepared, y, initial, next: every, every, largest: 0.0, errors: Vec::new(), evaluations: 0.0 }
    }

    fn at(&mut self, run: &mut (dyn Stepper<f64> + Send)) {
        let (t, before) = (run.time(), run.stats().force_evaluations);
        run.sample(t, &mut self.y);
        self.evaluations += (run.stats().force_evaluations - before) as f64;
        let error = ((energy(self.prepared.scene.chain(), &self.y) - self.initial).value()) / self.initial.value();
        self.largest = if error.is_finite() { self.largest.max(error.abs()) } else { f64::INFINITY };
        self.errors.push((t, error));
        self.next = self.every * ((t / self.every).floor() + 1.0);
    }

    /// Whether the line through the errors rises by more than four of its residuals.
    fn drifts(&self) -> bool {
        let n = self.errors.len() as f64;
        let (mt, me) = self.errors.iter().fold((0.0, 0.0), |(t, e), at| (t + at.0 / n, e + at.1 / n));
        let (tt, te) = self
            .errors
            .iter()
            .fold((0.0, 0.0), |(tt, te), at| (tt + (at.0 - mt).powi(2), te + (at.0 - mt) * (at.1 - me)));
        let slope = te / tt;
        let rest = self.errors.iter().map(|at| (at.1 - me - slope * (at.0 - mt)).powi(2)).sum::<f64>();
        self.errors.len() > 8 && slope.abs() * self.prepared.scene.end() > DRIFT * (rest / n).sqrt()
    }
}
