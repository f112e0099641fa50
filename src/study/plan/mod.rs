//! A sweep of your own: a scene, run at every point of a grid that a file describes.
//!
//! | word | meaning |
//! |---|---|
//! | *plan* | a TOML file: scene, axes, quantities; see [`Plan::TEMPLATE`] |
//! | *axis* | keys of the scene that change together, and their values |
//! | *quantity* | a number or an array of numbers that the report of a run has, as in `run --json` |
//!
//! Rows stay in the store: tables are written from there line by line. In memory are the numbers of
//! the columns, 8 bytes each.

mod file;
mod report;

pub use file::{Axis, Plan, Point, Reported};

use super::{Progress, RunView, Signals, Study, Work, in_units, options::options};
use crate::{
    error::{Error, Result},
    output::Folder,
    report::Report,
    run::{Recorder, Records, Run, Snapshot, Trajectory, groups, start_all},
    scene::Scene,
    sweep::{self, Engine, Grid, Job, Row, Rows, STOPPED, cores, counted},
};
use file::in_json;
use hertzchain_integrators::real::MOST_LANES;
use serde_json::Value;
use std::{
    io::{self, BufWriter, Write},
    path::PathBuf,
    time::{Duration, Instant},
};

/// The table with a line a point.
const CSV: &str = "sweep.csv";
/// Largest number of points without a result whose reasons are shown.
const SHOWN: usize = 10;

options! {
    /// A sweep of your own.
    pub struct PlanFile {
        /// Name of a built-in plan, or a TOML file; `hertzchain sweep --template` prints one.
        plan: Option<PathBuf> = None, [required_unless_present = "template"];
        /// Print a plan: a start for your own.
        ///
        /// The plan that is named, otherwise one with every key, each explained.
        template: bool = false;
    }
}

impl Study for PlanFile {
    const FILES: &'static str = "Files: sweep.csv (a line a point, also failures), sweep.npz (a column a quantity), sweep.json, sweep.png (one or two axes), and for an axis of seeds seeds.csv (median, quartiles, least and largest of each number).";
    const STORE: &'static str = "sweep.store";

    fn optional_files() -> Vec<String> {
        ["sweep.png", "seeds.csv"].map(str::to_owned).into()
    }

    fn begin(&self) -> Result<Work<'_>> {
        if self.template {
            let text = self.plan.as_deref().map_or_else(|| Ok(Plan::TEMPLATE.to_owned()), Plan::source)?;
            let report = Report::new("plan").fact("template", &text).lines(text.clone());
            return Ok(Box::new(|_, _| Ok(report.file("plan.toml", text.into()))));
        }
        let plan = Plan::load(self.plan.as_deref().unwrap_or("".as_ref()))?;
        Ok(Box::new(move |engine, progress| planned(&plan, engine, progress)?.report()))
    }
}

/// The numbers of a key or of a quantity, point by point.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberColumn {
    /// The key or the quantity.
    pub name: String,
    /// The numbers, `width` for each point; not-a-number where there is none.
    pub numbers: Vec<f64>,
    /// Numbers for each point.
    pub width: usize,
}

/// The outcome of a plan.
#[derive(Clone, Debug)]
pub struct PlanStudy {
    /// The plan.
    pub plan: Plan,
    /// The columns of numbers: keys first, then quantities.
    pub columns: Vec<NumberColumn>,
    /// Number of points that failed.
    pub failures: usize,
    /// The first points without a result, failed or not run, with the reasons.
    pub failed: Vec<(usize, String)>,
    /// How many points were not run because the process was asked to end.
    pub missing: usize,
    /// Number of points that were read from the store.
    pub resumed: usize,
    /// Wall time.
    pub wall: Duration,
}

/// Runs a plan. In a folder of the engine points are kept as they are run, and tables are written.
/// `progress` is told the share done.
///
/// A point that fails is a row of its own.
///
/// ```
/// use hertzchain::{study::{Plan, planned}, sweep::Engine};
/// let plan = r#"
///     scene = "impact"
///     set = ["chain.sites=5", "span.until=3"]
///     axis = [{ key = "chain.alpha", values = [1.5, 2.0] }]
/// "#;
/// let study = planned(&Plan::parse(plan, "plan.toml".as_ref())?, &Engine::threads(), &|_, _| ())?;
/// assert!(study.columns[1].name == "energy_error" && study.columns[1].numbers.iter().all(|error| *error < 1e-8));
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A store of another plan, or one that was altered; errors of the system.
pub fn planned(plan: &Plan, engine: &Engine, progress: Progress<'_>) -> Result<PlanStudy> {
    let clock = Instant::now();
    let grid = Grid { store: PlanFile::STORE, study: "plan", settings: plan.settings() };
    let work = |ks: &[usize]| {
        let points: Vec<Point> = ks.iter().map(|&k| plan.point(k)).collect();
        run(plan, &points).into_iter().map(sweep::text).collect()
    };
    let swept = |rows: &mut Rows<'_>| {
        let mut table = Table::new(plan);
        let missing = match engine.folder() {
            Some(folder) => written(folder, rows, &mut table)?,
            None => rows.each(&|k, row| (k, row), &mut |(k, row)| {
                table.take(k, row);
                Ok(())
            })?,
        };
        Ok((table, missing))
    };
    let job = Job {
        count: plan.points(),
        key: &|k| sweep::key(&plan.point(k)),
        work: &work,
        together: together(plan),
        check: sweep::check::<Vec<Value>>,
        progress: &counted(progress),
    };
    let ((table, missing), resumed) = engine.each(&grid, &job, swept)?;
    Ok(PlanStudy {
        plan: plan.clone(),
        columns: table.columns,
        failures: table.failures,
        failed: table.failed,
        missing,
        resumed,
        wall: clock.elapsed(),
    })
}

/// The report of a run of a scene at time zero, with a log of contacts: it has the names of all
/// that a run reports.
fn before_its_first_step(scene: &Scene) -> Value {
    let run = scene.run().records(Records::Energy).contacts();
    let trajectory = Recorder::new(&run, Snapshot::new(&run), &mut |_, _| ()).trajectory(None);
    reported(scene, trajectory, Signals::new(scene))
}

/// The report of a run, whose outcome is in the units of its scene.
fn reported(scene: &Scene, outcome: Trajectory, signals: Option<Signals>) -> Value {
    let (si, reason, amplification) = (scene.units(), None, None);
    let signals = signals.map(|signals| signals.reported(&outcome, si));
    let (outcome, signals) = (&outcome, signals.as_ref());
    let (integrator, setting, conditions, files) = ("", "", &[], &[]);
    serde_json::json!(RunView {
        scene,
        integrator,
        setting,
        reason,
        outcome,
        amplification,
        si,
        signals,
        conditions,
        files
    })
}

fn run_of(plan: &Plan, point: &Point) -> Result<(Scene, Run)> {
    let scene = plan.scene(point)?;
    let run = scene.observed_run(Records::Energy)?;
    let run = if plan.contacts() { run.contacts() } else { run };
    Ok((scene, run))
}

/// Number of points that follow each other and are to be run at once: as many as of the first ones
/// can be made side by side.
fn together(plan: &Plan) -> usize {
    let first = (0..plan.points().min(MOST_LANES)).filter_map(|k| run_of(plan, &plan.point(k)).ok());
    let runs: Vec<Run> = first.map(|(_, run)| run).collect();
    groups(&runs, plan.points().div_ceil(cores())).iter().map(|group| group.len()).max().unwrap_or(1)
}

/// Runs points: the quantities that the plan keeps of each.
fn run(plan: &Plan, points: &[Point]) -> Vec<Result<Vec<Value>>> {
    let begun: Vec<Result<(Scene, Run)>> = points.iter().map(|point| run_of(plan, point)).collect();
    let (scenes, runs): (Vec<_>, Vec<_>) = begun.iter().flatten().cloned().unzip();
    let mut signals: Vec<Option<Signals>> = scenes.iter().map(Signals::new).collect();
    let mut ends = start_all(&runs, &mut |k, t, y| {
        signals[k].iter_mut().for_each(|signals| signals.take(&scenes[k], t, y));
    })
    .into_iter()
    .zip(signals);
    let rows = begun.into_iter().map(|begun| {
        let (scene, _) = begun?;
        let (outcome, signals) = ends.next().expect("a run for each scene");
        let trajectory = in_units(outcome?, scene.chain().layout(), scene.units()).complete()?;
        if let Some(doubt) = trajectory.warnings.iter().find(|warning| warning.fatal()) {
            return Err(doubt.clone().into());
        }
        let report = reported(&scene, trajectory, signals);
        plan.keep.iter().map(|quantity| quantity.of(&report)).collect()
    });
    rows.collect()
}

/// The columns of a plan while rows come in.
struct Table<'a> {
    plan: &'a Plan,
    columns: Vec<NumberColumn>,
    failures: usize,
    failed: Vec<(usize, String)>,
}

impl<'a> Table<'a> {
    fn new(plan: &'a Plan) -> Self {
        let column = |name: &String| NumberColumn { name: name.clone(), numbers: Vec::new(), width: 1 };
        let columns = plan.keys().map(column).chain(plan.keep.iter().map(|kept| column(&kept.name))).collect();
        Self { plan, columns, failures: 0, failed: Vec::new() }
    }

    fn take(&mut self, k: usize, row: Row<Vec<Value>>) {
        let point = self.plan.point(k);
        let keys = point.0.iter().map(|(_, value)| in_json(value));
        let values = row.unwrap_or_else(|why| {
            if why != STOPPED {
                self.failures += 1;
            }
            if self.failed.len() < SHOWN {
                self.failed.push((k, why));
            }
            vec![Value::Null; self.plan.keep.len()]
        });
        for (column, value) in self.columns.iter_mut().zip(keys.chain(values)) {
            column.take(k, &value);
        }
    }
}

impl NumberColumn {
    /// Adds the value of a point. Arrays that are longer than all before widen the column.
    fn take(&mut self, points: usize, value: &Value) {
        let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        let array = value.as_array().map(Vec::as_slice);
        let wanted = array.map_or(1, <[Value]>::len);
        if wanted > self.width {
            let widened = self.numbers.chunks(self.width).flat_map(|row| {
                row.iter().copied().chain(std::iter::repeat_n(f64::NAN, wanted - row.len())).collect::<Vec<_>>()
            });
            self.numbers = widened.collect();
            self.width = wanted;
        }
        let values = array.unwrap_or(std::slice::from_ref(value));
        self.numbers.extend(values.iter().map(number));
        self.numbers.resize((points + 1) * self.width, f64::NAN);
    }
}

/// Takes all rows into a table and writes them line by line. Returns the number of missing rows.
fn written(folder: &Folder, rows: &Rows<'_>, table: &mut Table<'_>) -> Result<usize> {
    let (plan, mut missing) = (table.plan, 0);
    let make = |k: usize, row: Row<Vec<Value>>| (csv_line(plan, k, row.clone()), k, row);
    let failed = |source| Error::File { path: folder.path().join(CSV), source };
    let all = folder.write_with(CSV, |csv| {
        let mut csv = BufWriter::new(csv);
        csv.write_all(csv_head(plan).as_bytes())?;
        let all = rows.each(&make, &mut |(cells, k, row)| {
            csv.write_all(cells.as_bytes()).map_err(failed)?;
            table.take(k, row);
            Ok(())
        });
        missing = all.map_err(io::Error::other)?;
        csv.flush()
    });
    all.map(|_| missing).map_err(|error| match error {
        // The error of a row is inside that of writing the file.
        Error::File { path, source } => source.downcast().unwrap_or_else(|source| Error::File { path, source }),
        other => other,
    })
}

fn csv_head(plan: &Plan) -> String {
    let names: Vec<&str> =
        plan.keys().map(String::as_str).chain(plan.keep.iter().map(|kept| kept.name.as_str())).collect();
    format!("{},failure\n", names.join(","))
}

/// A cell for each key and quantity, and the reason of a failure. Of an array the cell has only the
/// length; its numbers are in the other files.
fn csv_line(plan: &Plan, k: usize, row: Row<Vec<Value>>) -> String {
    let (values, why) = match row {
        Ok(values) => (values, Value::Null),
        Err(why) => (vec![Value::Null; plan.keep.len()], Value::from(why.replace('\n', ";"))),
    };
    let cell = |value: Value| match value {
        Value::Array(values) => format!("{} numbers", values.len()),
        value => crate::report::text::cell(&value, ""),
    };
    let keys = plan.point(k).0.into_iter().map(|(_, value)| in_json(&value));
    keys.chain(values).chain([why]).map(cell).collect::<Vec<_>>().join(",") + "\n"
}
