//! Error against run time: every integrator over a ladder of steps or tolerances on one scene.

mod report;

use super::{Changes, Progress, Study, Work, fit_line, methods, scene};
use crate::{
    chain::{State, max_norm},
    error::{Error, Result},
    interrupt,
    run::method::{Method, Setting},
    run::{Records, Trajectory},
    scene::{Scene, Theory},
    sweep::map,
};
use hertzchain_integrators::{Silent, Stats, drive};
use std::time::{Duration, Instant};

/// Contact kicks a period on the rungs of the ladder of a splitting scheme: the same work for every
/// scheme.
const KICKS: [f64; 6] = [16.0, 64.0, 256.0, 1024.0, 4096.0, 16384.0];
/// Tolerances on the rungs of an adaptive method.
const TOLERANCES: [f64; 6] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13];
/// The methods that references come from on chains of up to [`FEW_SITES`], with their tolerance: a
/// tenth of a rounding a step, so that rounding is all there is. They share the step and not the
/// variable.
const RESOLVED: [&str; 2] = ["dop853-regularised", "dop853-landed"];
const RESOLVED_TOLERANCE: f64 = 1e-16;
/// The work of a method that stops at every event grows with the square of the chain.
const FEW_SITES: usize = 100;
/// The methods that references come from on longer chains, and the kicks a period, time permitting:
/// eight times the last rung.
const CROSSING: [&str; 2] = ["aba1064-linear", "srkn11-6-linear"];
const CROSSING_KICKS: f64 = 131_072.0;
/// Share of the span that tells what a reference will cost.
const TRIAL_SHARE: f64 = 0.05;
/// Share of the time that references may take.
const REFERENCE_SHARE: f64 = 0.3;
/// Rows nearer to the reference than this many times its error estimate are marked.
const TRUSTED: f64 = 3.0;

/// The comparison of integrators on a scene.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct Compare {
    /// Name of a built-in scene, or a TOML file.
    pub scene: String,
    /// Changes to it.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub set: Changes,
    /// What is compared.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub options: CompareOptions,
}

/// What to compare.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct CompareOptions {
    /// Names of integrators, or `all`; none: those of [`Method::telling`].
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "A,B,..",
            value_delimiter = ',',
            help = INTEGRATORS,
            long_help = integrators_help()
        )
    )]
    pub integrators: Vec<String>,
    /// Wall time for all runs, in seconds; what would not fit is left out.
    #[cfg_attr(feature = "cli", arg(long, value_name = "S", default_value = "60"))]
    pub max_time: f64,
}

#[cfg(feature = "cli")]
const INTEGRATORS: &str = "Integrators, separated by commas, or all [default: the telling ones]";

/// Names the integrators of a comparison by default.
#[cfg(feature = "cli")]
fn integrators_help() -> String {
    let names: Vec<_> = Method::telling().iter().map(Method::name).collect();
    format!(
        "{INTEGRATORS}.\n\nBy default those that are the fastest at some error on a built-in scene, and those that others are \
         measured by: {}.",
        names.join(", ")
    )
}

impl CompareOptions {
    fn methods(&self) -> Result<Vec<Method>> {
        methods(&self.integrators, Method::telling)
    }
}

impl Study for Compare {
    const FILES: &'static str = "Files: compare.csv, compare.json and compare.png.";
    const STOPS: bool = true;

    fn begin(&self) -> Result<Work<'_>> {
        let scene = scene(&self.scene, &self.set)?;
        self.options.methods()?;
        Ok(Box::new(move |_, progress| Ok(Box::new(compare(&scene, &self.options, progress)?))))
    }
}

/// What errors are measured against.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Method and setting, in words.
    pub method: String,
    /// The difference of two references by different methods, relative to the amplitude: an
    /// estimate of the larger error.
    pub error_estimate: f64,
}

/// One method at one setting.
#[derive(Clone, Debug)]
pub struct Row {
    /// The method.
    pub method: Method,
    /// The setting, in words.
    pub setting: String,
    /// Step size; the mean one for adaptive methods.
    pub step: f64,
    /// `max |x - x_ref|` at the end over the amplitude; `None` if the run failed.
    pub error: Option<f64>,
    /// Largest relative energy error; `None` if the run failed or the state has no energy.
    pub energy_error: Option<f64>,
    /// Median wall time of several runs that record nothing, in seconds; `None` if the run failed.
    pub wall: Option<f64>,
    /// Runs behind the median.
    pub repeats: usize,
    /// Work of one such run.
    pub stats: Stats,
    /// Whether the error is too near to that of the reference to be trusted.
    pub below_reference: bool,
    /// Why the run failed.
    pub failure: Option<String>,
}

impl Row {
    /// The row of a run that did not begin.
    fn failed(method: Method, setting: String, why: String) -> Self {
        Self {
            method,
            setting,
            step: f64::NAN,
            error: None,
            energy_error: None,
            wall: None,
            repeats: 0,
            stats: Stats::default(),
            below_reference: false,
            failure: Some(why),
        }
    }
}

/// The outcome of a comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Scene.
    pub scene: Scene,
    /// What errors are divided by.
    pub amplitude: f64,
    /// What they are measured against.
    pub reference: Reference,
    /// Rows, method by method, coarse to fine.
    pub rows: Vec<Row>,
    /// How many rungs the time allowed, out of how many.
    pub rungs: (usize, usize),
}

impl Comparison {
    /// The rows of one method.
    pub fn rows_of(&self, method: &Method) -> Vec<&Row> {
        self.rows.iter().filter(|row| row.method == *method).collect()
    }

    /// The methods, in the order of their first rows.
    pub fn methods(&self) -> Vec<Method> {
        let mut methods: Vec<Method> = Vec::new();
        for row in &self.rows {
            if !methods.contains(&row.method) {
                methods.push(row.method);
            }
        }
        methods
    }

    /// The order that a method shows: the slope of log error against log step, where at least three
    /// rows lie between the trusted floor and 1e-2 and on a line (within a factor of 1.5). Adaptive
    /// methods have none.
    pub fn slope(&self, method: &Method) -> Option<f64> {
        if method.adaptive() {
            return None;
        }
        let points: Vec<(f64, f64)> = self
            .rows_of(method)
            .into_iter()
            .filter(|row| !row.below_reference)
            .filter_map(|row| {
                row.error.filter(|error| (1e-13..1e-2).contains(error)).map(|e| (row.step.log10(), e.log10()))
            })
            .collect();
        fit_line(&points)
            .filter(|(_, residual)| points.len() >= 3 && *residual < 1.5f64.log10())
            .map(|(slope, _)| slope)
    }

    /// The fastest row whose error is certainly at most `error`: its own and that of the reference
    /// together.
    pub fn fastest(&self, error: f64) -> Option<&Row> {
        let reaches = |row: &&Row| row.error.is_some_and(|e| e + self.reference.error_estimate <= error);
        let wall = |row: &Row| row.wall.unwrap_or(f64::MAX);
        self.rows.iter().filter(reaches).min_by(|a, b| wall(a).total_cmp(&wall(b)))
    }
}

/// Compares methods on a scene. `progress` is told the share of the time budget that is used, and
/// what runs.
///
/// Errors and energies come from runs on all cores; wall times from runs that record nothing, one
/// at a time.
///
/// # Errors
/// A budget outside its rule, no method, or references that cannot be had.
pub fn compare(scene: &Scene, options: &CompareOptions, progress: Progress<'_>) -> Result<Comparison> {
    let methods = options.methods()?;
    let budget = options.max_time;
    if !(budget.is_finite() && budget > 0.0) {
        return Err(Error::parameter("max-time", budget, "a finite number of seconds, above zero"));
    }
    let clock = Instant::now();
    let spent = || clock.elapsed().as_secs_f64();
    progress(0.0, "reference");
    let truth = Truth::find(scene, budget * REFERENCE_SHARE)?;
    let mut rows: Vec<(usize, Row)> = Vec::new();
    let mut rungs = 0;
    let mut rung_cost = 0.0;
    for rung in 0..KICKS.len() {
        // A rung costs about four times the one before, and its predecessor was measured.
        if rung > 0 && (spent() + 4.0 * rung_cost > budget || interrupt::asked()) {
            break;
        }
        let before = spent();
        let errors = map(&methods, |method| truth.error_row(scene, *method, rung));
        for (index, mut row) in errors.into_iter().enumerate() {
            progress(spent() / budget, &format!("{} at {}", row.method.name(), row.setting));
            if row.failure.is_none() && interrupt::asked() {
                row.failure = Some("stopped by a signal before it was timed".to_owned());
            }
            if row.failure.is_none() {
                match time(scene, row.method, setting(scene, &row.method, rung), budget - spent()) {
                    Ok((wall, repeats, stats)) => (row.wall, row.repeats, row.stats) = (Some(wall), repeats, stats),
                    Err(why) => row = Row { failure: Some(why.to_string()), error: None, energy_error: None, ..row },
                }
            }
            rows.push((index, row));
        }
        rung_cost = spent() - before;
        rungs = rung + 1;
    }
    rows.sort_by_key(|(index, _)| *index);
    Ok(Comparison {
        scene: scene.clone(),
        amplitude: truth.amplitude,
        reference: Reference { method: truth.method, error_estimate: truth.error_estimate },
        rows: rows.into_iter().map(|(_, row)| row).collect(),
        rungs: (rungs, KICKS.len()),
    })
}

fn setting(scene: &Scene, method: &Method, rung: usize) -> Setting {
    if method.adaptive() {
        Setting::Tolerance(TOLERANCES[rung])
    } else {
        Setting::Steps(steps_for_kicks(scene, method, KICKS[rung]))
    }
}

/// The number of steps over the span that makes about this many kicks a period.
pub(super) fn steps_for_kicks(scene: &Scene, method: &Method, kicks: f64) -> u64 {
    let steps = kicks * scene.end() / scene.period() / method.stages() as f64;
    (steps.round() as u64).max(1)
}

fn wording(method: &Method, rung: usize) -> String {
    if method.adaptive() { format!("tol {:e}", TOLERANCES[rung]) } else { format!("{} kicks/period", KICKS[rung]) }
}

/// Median wall time of runs that record nothing, their number, and their work.
pub(super) fn time(scene: &Scene, method: Method, setting: Setting, left: f64) -> Result<(f64, usize, Stats)> {
    let mut walls = Vec::new();
    let mut y = scene.initial().as_slice().to_vec();
    loop {
        // What a method does before its first step is part of its run: of a tolerance, that may be
        // runs of its own.
        let clock = Instant::now();
        let mut stepper = scene.run().method(method).setting(setting).stepper()?;
        drive(&mut *stepper, &mut Silent, &mut y)?;
        walls.push(clock.elapsed().as_secs_f64());
        let total: f64 = walls.iter().sum();
        let wanted = if total > 0.1 { 3 } else { 7 };
        if walls.len() >= wanted || total + walls[0] > 0.1 * left.max(0.0) {
            walls.sort_by(f64::total_cmp);
            return Ok((walls[walls.len() / 2], walls.len(), stepper.stats()));
        }
    }
}

/// The reference strains at the end, from two methods.
struct Truth {
    method: String,
    /// `(method, strains)`: a row is held against the first that is not of its own method.
    strains: Vec<(String, Vec<f64>)>,
    amplitude: f64,
    error_estimate: f64,
}

/// The end of a run, as a reference.
type End = (String, Vec<f64>);

impl Truth {
    /// The exact solution if there is one; otherwise two runs by different methods.
    fn find(scene: &Scene, budget: f64) -> Result<Self> {
        if let Some(Theory::Breather(breather)) = scene.theory() {
            let exact = State::from_fn(scene.chain(), |n| breather.site(n, scene.end()))?;
            let strains = vec![(String::new(), scene.strains(exact.as_slice()))];
            return Ok(Self::of(scene, "exact solution (uncpl)".to_owned(), strains));
        }
        match resolved(scene, budget)? {
            Some(ends) => {
                let words = format!("{} at tol {RESOLVED_TOLERANCE:e}, checked by {}", ends[0].0, ends[1].0);
                Ok(Self::of(scene, words, ends))
            }
            None => {
                let methods = named(CROSSING)?;
                let kicks = affordable_kicks(scene, &methods, budget)?;
                let words = format!("{} at {kicks} kicks/period, checked by {}", CROSSING[0], CROSSING[1]);
                Ok(Self::of(scene, words, crossing(scene, &methods, kicks)?))
            }
        }
    }

    fn of(scene: &Scene, method: String, strains: Vec<End>) -> Self {
        let largest = max_norm(strains[0].1.iter().copied());
        let amplitude = scene.amplitude().unwrap_or(largest);
        let amplitude = if amplitude > 0.0 { amplitude } else { 1.0 };
        // No better than a few roundings of the strains themselves.
        let roundoff = 4.0 * f64::EPSILON * largest / amplitude;
        let gap = strains.get(1).map_or(0.0, |other| distance(&strains[0].1, &other.1) / amplitude);
        Self { method, strains, amplitude, error_estimate: gap.max(roundoff) }
    }

    /// The row of a method, also of one that cannot even start.
    fn error_row(&self, scene: &Scene, method: Method, rung: usize) -> Row {
        let run = scene.run().method(method).setting(setting(scene, &method, rung));
        let outcome = match run.start() {
            Ok(outcome) => outcome,
            Err(why) => return Row::failed(method, wording(&method, rung), why.to_string()),
        };
        let Trajectory { t, state, energy_error, stats, failure, .. } = outcome;
        let name = method.name();
        let reference = self.strains.iter().find(|(other, _)| *other != name).unwrap_or(&self.strains[0]);
        let error = distance(&scene.strains(&state), &reference.1) / self.amplitude;
        Row {
            method,
            setting: wording(&method, rung),
            step: t / stats.steps.max(1) as f64,
            error: failure.is_none().then_some(error),
            energy_error: energy_error.filter(|_| failure.is_none()),
            wall: None,
            repeats: 0,
            stats,
            below_reference: failure.is_none() && error < TRUSTED * self.error_estimate,
            failure: failure.map(|failure| failure.to_string()),
        }
    }
}

fn named(names: [&str; 2]) -> Result<[Method; 2]> {
    Ok([Method::named(names[0])?, Method::named(names[1])?])
}

fn end(scene: &Scene, method: &Method, setting: Setting) -> Result<End> {
    let outcome = scene.run().method(*method).setting(setting).records(Records::End).start()?.complete()?;
    Ok((method.name(), scene.strains(&outcome.state)))
}

fn crossing(scene: &Scene, methods: &[Method], kicks: f64) -> Result<Vec<End>> {
    let run = |method: &Method| end(scene, method, Setting::Steps(steps_for_kicks(scene, method, kicks)));
    map(methods, run).into_iter().collect()
}

/// References by the methods that resolve contacts, if the chain is short enough, the budget long
/// enough and they succeed.
fn resolved(scene: &Scene, budget: f64) -> Result<Option<Vec<End>>> {
    let tolerance = Setting::Tolerance(RESOLVED_TOLERANCE);
    let methods = named(RESOLVED)?;
    if scene.chain().sites() > FEW_SITES {
        return Ok(None);
    }
    let short = scene.clone().until(TRIAL_SHARE * scene.end())?;
    let trial = short.run().method(methods[1]).setting(tolerance).records(Records::End).start()?;
    if trial.failure.is_some() || trial.wall.as_secs_f64() > TRIAL_SHARE * budget {
        return Ok(None);
    }
    // A run that fails is no reference; the others may do better.
    let ends: Result<Vec<_>> = map(&methods, |method| end(scene, method, tolerance)).into_iter().collect();
    let Ok(mut ends) = ends else { return Ok(None) };
    if ends[0].1 == ends[1].1 {
        // Without events both are the same run: the check comes from another family.
        let other = &named(CROSSING)?[..1];
        ends[1] = crossing(scene, other, affordable_kicks(scene, other, budget)?)?.remove(0);
    }
    Ok(Some(ends))
}

/// Kicks a period that the references can do within the budget, by the time of a short trial.
fn affordable_kicks(scene: &Scene, methods: &[Method], budget: f64) -> Result<f64> {
    let trial = KICKS[2];
    let mut wall = Duration::ZERO;
    for method in methods {
        let steps = Setting::Steps(steps_for_kicks(scene, method, trial));
        wall += scene.run().method(*method).setting(steps).records(Records::End).start()?.wall;
    }
    let affordable = trial * budget / wall.as_secs_f64().max(1e-9);
    let kicks = (affordable / KICKS[0]).log2().floor().exp2() * KICKS[0];
    Ok(kicks.clamp(KICKS[1], CROSSING_KICKS))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    max_norm(a.iter().zip(b).map(|(a, b)| a - b))
}
