//! How the error of the energy grows with time.
//!
//! If the errors of a method have random signs, the energy makes a random walk and its error grows
//! like the square root of time. With a bias it grows like time. With a symplectic method on a
//! smooth problem it does not grow at all.

use crate::study::{
    Changes, Progress, Study, Work, fit_line,
    integrators::compare::{has_energy, steps},
    methods,
    options::options,
    run::error_in_file,
    scene, scene_caption, scene_json,
    si::Scale,
};
use crate::{
    chain::Chain,
    error::{Error, Result},
    report::{Curve, Fixed, Hidden, Json, Point, Power, Quantity, Report, Short, Table, Units, WorkPrecision},
    run::method::{Method, Setting},
    scene::Scene,
    sweep::{Engine, Grid},
};
use hertzchain_integrators::{DoubleDouble, Error as Failure, Observer, Stats, drive};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{ops::ControlFlow, time::Instant};

/// Contact kicks of splitting schemes in a period of the fastest motion.
const KICKS: f64 = 64.0;
/// Tolerance of adaptive methods.
const TOLERANCE: f64 = 1e-13;
/// Periods between two evaluations of the energy: the golden ratio, so that evaluations meet all
/// phases of the motion evenly.
const LOOK: f64 = 0.618_033_988_749_894_9;
/// A slope is fitted from the last time over this factor to the last time.
const FITTED: f64 = 100.0;
/// Points of a curve in the picture, at most: more markers would hide the line.
const MOST_POINTS: usize = 40;
/// A run is unstable when its energy exceeds the initial one by this factor.
const ENERGY_BOUND: f64 = 10.0;

options! {
    /// The drift study of a scene.
    pub struct Drift {
        /// Name of a built-in scene, or a TOML file.
        scene: String = "bright-breather-16".to_owned();
        /// Changes to it.
        set: Changes = Changes::default();
        /// What is measured.
        options: DriftOptions = DriftOptions::default();
    }
}

options! {
    /// What to measure.
    pub struct DriftOptions {
        /// Length of the longest run, in periods.
        ///
        /// All runs have this length, in periods of the scene.
        periods: f64 = 1e4, "P", (1 to 1e9);
        /// Integrators, separated by commas, or all.
        integrators: Vec<String> =
            ["collocation", "corrected", "strang-linear", "yoshida4-linear"].map(String::from).into(), "A,B,..";
        /// Number of sample times.
        ///
        /// Spaced evenly in the logarithm of time.
        samples: usize = 200, "K", (2 to 100_000);
    }
}

impl Study for Drift {
    const STORE: &'static str = "drift.store";

    fn outline() -> Option<Report> {
        Some(tables(Report::new("drift"), &[], (0.0, None)))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = scene(&self.scene, &self.set)?;
        methods(&self.options.integrators, Method::all)?;
        Ok(Box::new(move |engine, progress| Ok(drift(&scene, &self.options, engine, progress)?.report())))
    }
}

/// One method.
#[derive(Clone, Debug)]
pub struct DriftRow {
    /// The method.
    pub method: Method,
    /// Its setting, in words.
    pub setting: String,
    /// Times, up to the end or to where the run failed.
    pub t: Vec<f64>,
    /// Its run.
    pub run: DriftRun,
    /// Slope of `log energy_error` against `log t` over the last two decades, if the run covers
    /// them and did not fail.
    pub slope: Option<f64>,
}

/// The run of a method, as the store keeps it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DriftRun {
    /// Largest `|E - E(0)| / |E(0)|` up to each time (absolute where `E(0) = 0`); the energy is
    /// evaluated more than once a period.
    pub energy_error: Vec<f64>,
    /// Wall time in seconds, evaluations of the energy included.
    pub wall: f64,
    /// Steps, rejected steps, and force evaluations, those of the energy included.
    pub work: [u64; 3],
    /// Why it stopped before the end, if it did.
    pub failure: Option<String>,
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct DriftStudy {
    /// The scene, whose span is that of the runs.
    pub scene: Scene,
    /// Length of the runs in periods of the scene.
    pub periods: f64,
    /// A row a method.
    pub rows: Vec<DriftRow>,
}

impl DriftRow {
    /// Every k-th point, with the last one included. Each has the largest error so far, so that
    /// points left out hide no error.
    fn points(&self, scene: &Scene) -> Vec<Point> {
        let stride = self.t.len().div_ceil(MOST_POINTS).max(1);
        let all = self.t.iter().zip(&self.run.energy_error).rev().step_by(stride);
        let point = |(&t, &error)| Point { work: scene.in_file(Quantity::Time, t), error, below_reference: false };
        let mut points: Vec<_> = all.map(point).collect();
        points.reverse();
        points
    }
}

impl DriftStudy {
    /// The report.
    pub fn report(&self) -> Report {
        let Self { scene, periods, rows } = self;
        let (scale, period) = (Scale(scene.units()), scene.in_file(Quantity::Time, scene.period()));
        let curve = |row: &DriftRow| {
            let failed = if row.run.failure.is_some() { ": failed" } else { "" };
            let note = format!(", {}{failed}", row.setting);
            Curve {
                name: row.method.name(),
                note,
                group: row.method.info().family.to_owned(),
                points: row.points(scene),
            }
        };
        let last = |row: &DriftRow| {
            Some(format!("{} ({}) {:.1e}", row.method.name(), row.setting, row.run.energy_error.last()?))
        };
        let how = format!(
            "The energy is looked at every 0.618 periods, and its largest error so far is shown; at the end: {}. One run a \
             method: the curves say how large errors get, not by which law they grow.",
            rows.iter().filter_map(last).collect::<Vec<_>>().join(", ")
        );
        let length = if *periods < 1e4 { periods.to_string() } else { format!("{periods:e}") };
        let picture = WorkPrecision {
            title: format!("{}: error of the energy over {length} periods", scene.name()),
            work_label: match scale.0 {
                None => format!("time t (dimensionless; a period is {period:.4})"),
                Some(_) => format!("{} (a period is {period:.4e} s)", scale.label("time t", Quantity::Time)),
            },
            error_label: "largest |E − E(0)| / |E(0)| up to t".to_owned(),
            curves: rows.iter().map(curve).collect(),
            caption: scene_caption(scene, &how),
            ..WorkPrecision::default()
        };
        let report = Report::new("drift").fact("scene", scene.name()).fact("period", period).fact("periods", periods);
        tables(report.si(scale.0), rows, (scene.end(), scale.0))
            .words(format!(
                "scene {}; the end is that of {periods} periods of {}",
                scene.title(),
                scale.shown(Quantity::Time, scene.period(), 6)
            ))
            .fact("scene_file", scene_json(scene))
            .warnings(scene.doubts())
            .picture(picture)
    }
}

/// The table of the methods and that of all times, added to a report.
fn tables(report: Report, rows: &[DriftRow], (end, si): (f64, Option<&Units>)) -> Report {
    let early = 0.01 * end * (1.0 + 1e-9);
    let points = |row: &DriftRow| {
        let (method, setting) = (row.method.name(), row.setting.clone());
        let all = row.t.iter().zip(&row.run.energy_error);
        all.map(|(&t, &error)| (method.clone(), setting.clone(), t, error)).collect::<Vec<_>>()
    };
    let points: Vec<_> = rows.iter().flat_map(points).collect();
    let methods = Table::of("methods", rows)
        .col("integrator", Short, "", |row| row.method.name())
        .col("setting", Short, "", |row| row.setting.clone())
        .col("t", Json, "", |row| Scale(si).all(Quantity::Time, &row.t))
        .col("energy_error", Json, "", |row| row.run.energy_error.clone())
        .col("early_error", Power(1), "largest |E(t) - E(0)| / |E(0)| up to 1 % of the time", |row| {
            row.t.iter().rposition(|&t| t <= early).map(|k| row.run.energy_error[k])
        })
        .col("last_error", Power(1), "the same up to the end", |row| row.run.energy_error.last().copied())
        .col("slope", Fixed(2), "of the logarithm of the error against that of t", |row| row.slope)
        .col("wall", Power(2), "wall time, in seconds", |row| row.run.wall)
        .col("steps", Short, "", |row| row.run.work[0])
        .col("rejected", Hidden, "rejected steps", |row| row.run.work[1])
        .col("force_evaluations", Short, "", |row| row.run.work[2])
        .col("failure", Short, "", |row| row.run.failure.clone());
    let all = Table::of("drift", &points)
        .key("")
        .si(si)
        .col("integrator", Hidden, "", |row| row.0.clone())
        .col("setting", Hidden, "", |row| row.1.clone())
        .col("t", Hidden, "time", |row| row.2)
        .kind(Quantity::Time)
        .col("energy_error", Hidden, "largest |E - E(0)| / |E(0)| up to t", |row| row.3);
    report.table(methods).table(all)
}

/// Runs the methods, each a point of a grid. `progress` is told the share done.
///
/// # Errors
/// An option outside its rule, a scene without an energy, or a run that cannot start; the process
/// was asked to end.
pub fn drift(scene: &Scene, options: &DriftOptions, engine: &Engine, progress: Progress<'_>) -> Result<DriftStudy> {
    let DriftOptions { periods, samples, .. } = options;
    let methods = methods(&options.integrators, Method::all)?;
    options.within_ranges()?;
    has_energy(scene)?;
    let scene = scene.clone().until(periods * scene.period())?;
    let times = spaced(scene.period(), scene.end(), *samples);
    let settings = json!({"scene": scene_json(&scene), "times": samples, "kicks": KICKS, "tolerance": TOLERANCE});
    let grid = Grid { store: Drift::STORE, study: "drift", settings };
    let swept = engine.sweep(&grid, &methods, progress, |&method| run(&scene, method, &times))?;
    let all = swept.all(&methods, Method::name)?;
    let rows = methods.iter().zip(all).map(|(&method, run)| row_of(&scene, method, &times, run));
    Ok(DriftStudy { rows: rows.collect::<Result<_>>()?, scene, periods: *periods })
}

/// `count` times from `first` to `last`, both included, spaced evenly in their logarithm.
pub fn spaced(first: f64, last: f64, count: usize) -> Vec<f64> {
    let step = (last / first).ln() / (count - 1) as f64;
    let inner = (0..count - 1).map(|k| (first * (step * k as f64).exp()).min(last));
    inner.chain([last]).collect()
}

fn setting(scene: &Scene, method: &Method) -> (Setting, String) {
    if method.adaptive() {
        (Setting::Tolerance(TOLERANCE), format!("tol {TOLERANCE:e}"))
    } else {
        (Setting::Steps(steps(scene, method.info().stages, KICKS)), format!("{KICKS} kicks"))
    }
}

fn run(scene: &Scene, method: Method, times: &[f64]) -> Result<DriftRun> {
    let mut stepper = scene.run().method(method).setting(setting(scene, &method).0).stepper()?;
    let mut state = scene.initial().as_slice().to_vec();
    let mut look = Look::new(scene, times);
    let clock = Instant::now();
    let failure = drive(&mut *stepper, &mut look, &mut state).err();
    if let Some(stopped @ Failure::Stopped { .. }) = failure {
        return Err(stopped.into());
    }
    let Stats { steps, rejected, force_evaluations } = stepper.stats();
    Ok(DriftRun {
        energy_error: look.errors,
        wall: clock.elapsed().as_secs_f64(),
        work: [steps, rejected, force_evaluations],
        failure: failure.map(|failure| error_in_file(failure.into(), scene).to_string()),
    })
}

fn row_of(scene: &Scene, method: Method, times: &[f64], run: DriftRun) -> Result<DriftRow> {
    let t = times.get(..run.energy_error.len()).map(<[f64]>::to_vec);
    let t = t.ok_or_else(|| Error::Point { point: method.name(), why: "more errors than times".to_owned() })?;
    let slope = slope(&t, &run.energy_error).filter(|_| run.failure.is_none());
    Ok(DriftRow { method, setting: setting(scene, &method).1, t, run, slope })
}

/// The slope over the last two decades of `t`.
pub fn slope(t: &[f64], errors: &[f64]) -> Option<f64> {
    let from = t.last()? / FITTED;
    // The first time may be `from` itself, up to rounding.
    let covered = *t.first()? <= from * (1.0 + 1e-9);
    let fitted = t.iter().zip(errors).filter(|(t, _)| **t >= from * (1.0 - 1e-9));
    let points: Vec<(f64, f64)> = fitted.map(|(t, error)| (t.log10(), error.log10())).collect();
    let good = covered && points.len() >= 3 && points.iter().all(|point| point.1.is_finite());
    fit_line(&points).filter(|_| good).map(|(slope, _)| slope)
}

/// The energy of a state, its sites added up to twice the working precision: a long chain loses no
/// digit that a short one has.
pub(crate) fn energy(chain: &Chain<f64>, y: &[f64]) -> DoubleDouble<f64> {
    chain.site_energies(y).into_iter().fold(DoubleDouble::zero(), |sum, site| sum + DoubleDouble::new(site))
}

/// Observer that evaluates the energy at regular times and keeps the largest error so far at each
/// of `times`.
struct Look<'a> {
    scene: &'a Scene,
    times: &'a [f64],
    /// Number of regular evaluations so far, without those at `times`.
    looks: u64,
    initial: DoubleDouble<f64>,
    /// Largest error so far.
    largest: f64,
    /// Largest error up to each of `times` that has passed.
    errors: Vec<f64>,
}

impl<'a> Look<'a> {
    fn new(scene: &'a Scene, times: &'a [f64]) -> Self {
        let initial = energy(scene.chain(), scene.initial().as_slice());
        Self { scene, times, looks: 0, initial, largest: 0.0, errors: Vec::new() }
    }

    /// Time of the next regular evaluation.
    fn regular(&self) -> f64 {
        LOOK * self.scene.period() * (self.looks + 1) as f64
    }
}

impl Observer<f64> for Look<'_> {
    fn next(&self) -> Option<f64> {
        self.times.get(self.errors.len()).map(|time| time.min(self.regular()))
    }

    fn observe(&mut self, t: f64, y: &[f64], stats: Stats) -> std::result::Result<ControlFlow<()>, Failure> {
        let kept = self.times[self.errors.len()] <= self.regular();
        let (now, initial) = (energy(self.scene.chain(), y), self.initial.value());
        if !now.value().is_finite() {
            let index = y.iter().position(|value| !value.is_finite()).unwrap_or(0);
            return Err(Failure::NotFinite { t, step: stats.steps, index });
        }
        if initial > 0.0 && now.value() > ENERGY_BOUND * initial {
            let value = now.value();
            return Err(Failure::Unstable { quantity: "energy", initial, value, t, step: stats.steps });
        }
        let motion = initial - self.scene.chain().energy_of_magnets();
        let scale = if motion == 0.0 { 1.0 } else { motion.abs() };
        self.largest = self.largest.max(((now - self.initial).value() / scale).abs());
        if kept {
            self.errors.push(self.largest);
        } else {
            self.looks += 1;
        }
        Ok(ControlFlow::Continue(()))
    }
}
