//! Run time per bond and period against the number of sites.
//!
//! The wave of the scene `tw-q15`, on a ring as long as is asked for, perturbed so that all
//! contacts begin and end at times of their own. Contact collocation works bond by bond and costs
//! the same per bond on every ring; a method that takes one step for the whole chain pays for each
//! event with a step of the whole chain.

use super::{Progress, Study, Work, compare::time, families, options::options};
use crate::{
    error::{Result, refuse},
    present::machine_json,
    random::uniform,
    report::{
        Curve,
        Digits::{Power, Short},
        Point, Report, WorkPrecision, rows,
    },
    run::method::{Contacts, Method, Setting},
    scene::{Scene, SceneFile},
    sweep::{Engine, Grid, Row, locked, on_one_thread},
};
use hertzchain_integrators::Stats;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{sync::Mutex, time::Instant};

/// The scene whose wave runs on rings of all lengths, and the sites that one wave takes there.
const SCENE: &str = "tw-q15";
const WAVE: usize = 10;
/// Length of the runs in periods of the wave.
const PERIODS: f64 = 3.0;
/// Size of the perturbation, relative to the largest entry of its kind.
const PERTURBATION: f64 = 0.1;
/// Sites of a trial run, from which the run time on a first ring with more sites is predicted.
const TRIAL_SITES: usize = 50;

options! {
    /// The scaling study.
    pub struct ScalingOptions {
        /// Numbers of sites, separated by commas.
        ///
        /// Each a multiple of 10.
        sites: Vec<usize> = vec![50, 100, 200, 500, 1000, 5000, 50_000], "A,B,..", (10 to 1_000_000);
        /// Tolerance.
        ///
        /// The same tolerance for every method.
        tol: f64 = 1e-9, "T", (CROSSED);
        /// Seed of the random numbers.
        ///
        /// They perturb the wave.
        seed: u64 = 1, "S";
        /// Wall time for all runs, in seconds; what would not fit is left out.
        ///
        /// Runs of collocation are never left out.
        max_time: f64 = 60.0, "S", (positive);
    }
}

impl Study for ScalingOptions {
    const STORE: &'static str = "scaling.store";
    const ENGINE: fn() -> Engine = Engine::in_turn;

    fn outline() -> Option<Report> {
        Some(Report::new("scaling").table(ScalingRow::table("scaling", &[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        Ok(Box::new(|engine, progress| Ok(scaling(self, engine, progress)?.report())))
    }
}

rows! {
    /// One method on one ring.
    #[derive(Clone, Debug, Default, Serialize, Deserialize)]
    pub struct ScalingRow {
        /// Name of the method.
        integrator: String => Short,
        /// Number of sites, and of bonds.
        sites: usize => Short,
        /// Median wall time of several runs, in seconds.
        wall: Option<f64> => Power(2),
        /// Wall time for each bond and period, in seconds.
        per_bond_period: Option<f64> => Power(2),
        /// Runs whose median is the wall time.
        runs: usize => Short,
        /// Steps of a run.
        steps: u64 => Short,
        /// Rejected steps.
        rejected: u64 => Short,
        /// Force evaluations of the whole chain; each bond makes at most this many.
        force_evaluations: u64 => Short,
        /// Why there is no time: the run failed, or was left out.
        failure: Option<String> => Short,
    }
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct ScalingStudy {
    /// The scene whose wave runs.
    pub scene: &'static str,
    /// Tolerance of every method.
    pub tol: f64,
    /// Length of the runs in periods of the wave.
    pub periods: f64,
    /// Size of the perturbation, relative to the largest entry of its kind.
    pub perturbation: f64,
    /// Seed of the perturbation.
    pub seed: u64,
    /// Rows, method by method, short to long.
    pub rows: Vec<ScalingRow>,
}

impl ScalingStudy {
    /// The methods of the study: collocation, contact-corrected splitting, whose equal steps are
    /// those of the whole chain, and two adaptive ones that step the whole chain.
    pub fn methods() -> [Method; 4] {
        [
            Method::Collocation,
            Method::CORRECTED,
            Method::Dop853(Contacts::Crossed),
            Method::Dop853(Contacts::Regularised),
        ]
    }

    /// The rows of one method.
    pub fn rows_of(&self, method: &Method) -> Vec<&ScalingRow> {
        self.rows.iter().filter(|row| row.integrator == method.name()).collect()
    }

    /// The report; times are in seconds.
    pub fn report(&self) -> Report {
        let Self { scene, tol, periods, perturbation, seed, rows } = self;
        let how = format!(
            "Median wall time of runs that record nothing, on one thread, over {periods} periods of the wave of scene {scene} \
             (strain ring, q = π/5, α = 1.5, κ = 1, ρ = 1/3), every entry of the initial state moved by up to {perturbation} \
             of the largest of its kind (seed {seed}); tolerance {tol:e}: of the sum of all local errors for collocation, of \
             the end for corrected (whose trial runs count), of a step for dop853, in the mean over all sites, so that on a \
             long ring no single contact counts: equal tolerances are not equal errors."
        );
        let methods = Self::methods();
        let (families, family_of) = families(&methods);
        let point = |row: &ScalingRow| {
            Some(Point { work: row.sites as f64, error: 1e9 * row.per_bond_period?, below_reference: false })
        };
        let curve = |(method, family): (&Method, usize)| {
            let points = self.rows_of(method).into_iter().filter_map(point).collect();
            Curve { name: method.name(), family, points, slope: None }
        };
        let picture = WorkPrecision {
            title: format!("Run time per bond and period, tolerance {tol:e}"),
            work_label: "number of sites N".to_owned(),
            error_label: "run time per bond and period (ns)".to_owned(),
            curves: methods.iter().zip(family_of).map(curve).collect(),
            caption: format!(
                "{how} Collocation alone would use all cores on chains of more than 256 bonds; here it has one, too. \
                 The dashed line grows like N: the run time of the whole chain like N²."
            ),
            families,
            guides: vec![(-1.0, "grows like N".to_owned())],
            ..WorkPrecision::default()
        };
        Report::new("scaling")
            .fact("tol", tol)
            .fact("periods", periods)
            .fact("perturbation", perturbation)
            .fact("seed", seed)
            .fact("scene", scene)
            .table(ScalingRow::table("scaling", rows))
            .words(how)
            .fact("machine", machine_json())
            .picture(picture)
    }
}

/// Times every method on every ring: collocation on every ring first, then the others ring by ring,
/// as long as they fit the time that is left.
///
/// An engine that computes points [in turn](Engine::in_turn) times one run at a time.
///
/// # Errors
/// A number of sites, a tolerance or a budget outside its rule; the process was asked to end before
/// a run was timed.
pub fn scaling(options: &ScalingOptions, engine: &Engine, progress: Progress<'_>) -> Result<ScalingStudy> {
    let (sizes, methods) = (checked(options)?, ScalingStudy::methods());
    let ScalingOptions { tol, seed, max_time, .. } = *options;
    let first = sizes.iter().map(|&sites| (0, sites));
    let cases: Vec<(usize, usize)> =
        first.chain(sizes.iter().flat_map(|&sites| (1..methods.len()).map(move |method| (method, sites)))).collect();
    let grid = Grid { store: ScalingOptions::STORE, study: "scaling", settings: json!([tol, seed, max_time]) };
    let timer = Timer { options, clock: Instant::now(), known: Mutex::default() };
    // Collocation would otherwise use all cores on long chains, and the others one.
    let work = |&(k, sites): &(usize, usize)| on_one_thread(|| timer.row(k, methods[k], sites))?;
    let swept = engine.sweep(&grid, &cases, progress, work)?;
    if swept.missing == cases.len() {
        return Err(swept.stopped());
    }
    let row = |(&(k, sites), row): (&(usize, usize), Row<ScalingRow>)| {
        let row = row.unwrap_or_else(|why| ScalingRow { failure: Some(why), ..ScalingRow::default() });
        (k, ScalingRow { integrator: methods[k].name(), sites, ..row })
    };
    let mut rows: Vec<(usize, ScalingRow)> = cases.iter().zip(swept.rows).map(row).collect();
    rows.sort_by_key(|(k, _)| *k);
    let rows = rows.into_iter().map(|(_, row)| row).collect();
    Ok(ScalingStudy { scene: SCENE, tol, periods: PERIODS, perturbation: PERTURBATION, seed, rows })
}

/// The numbers of sites in ascending order, if all options keep their rules.
fn checked(options: &ScalingOptions) -> Result<Vec<usize>> {
    options.within_ranges()?;
    let mut sizes = options.sites.clone();
    sizes.sort_unstable();
    sizes.dedup();
    let odd = sizes.iter().find(|sites| !sites.is_multiple_of(WAVE));
    refuse("sites", odd, "a multiple of 10, so that whole waves fit the ring").map(|()| sizes)
}

/// What run times are measured and predicted with.
struct Timer<'a> {
    options: &'a ScalingOptions,
    clock: Instant,
    /// Sites and wall time of the last run, by method.
    known: Mutex<[Option<(usize, f64)>; 4]>,
}

impl Timer<'_> {
    /// Median wall time of several runs on a ring, their number, and their work.
    fn time(&self, method: Method, sites: usize, left: f64) -> Result<(f64, usize, Stats)> {
        time(&perturbed(sites, self.options.seed)?, method, Setting::Tolerance(self.options.tol), left)
    }

    /// The row of the `k`-th method on a ring. A method other than the first is left out if its run
    /// does not fit the time that is left. Its wall time is predicted from the last run; before the
    /// first run on a long ring, from a trial on a short one.
    fn row(&self, k: usize, method: Method, sites: usize) -> Result<ScalingRow> {
        let left = || self.options.max_time - self.clock.elapsed().as_secs_f64();
        let mut known = locked(&self.known)[k];
        if k > 0 && known.is_none() && sites > TRIAL_SITES {
            known = self.time(method, TRIAL_SITES, 0.0).ok().map(|(wall, ..)| (TRIAL_SITES, wall));
        }
        let predicted = known.map(|(known, wall)| wall * (sites as f64 / known as f64).powf(growth(&method)));
        if let Some(wall) = predicted.filter(|wall| k > 0 && *wall > left()) {
            let failure = Some(format!("left out: it would take about {wall:.0e} s, more than --max-time leaves"));
            return Ok(ScalingRow { failure, ..ScalingRow::default() });
        }
        let (wall, runs, stats) = self.time(method, sites, left())?;
        locked(&self.known)[k] = Some((sites, wall));
        let Stats { steps, rejected, force_evaluations } = stats;
        let per_bond_period = Some(wall / (sites as f64 * PERIODS));
        Ok(ScalingRow {
            wall: Some(wall),
            per_bond_period,
            runs,
            steps,
            rejected,
            force_evaluations,
            ..ScalingRow::default()
        })
    }
}

/// The power of the number of sites that a run time grows like, at most: events come in proportion
/// to the sites, and a method that stops at each pays with the whole chain; any other slows down
/// where its state no longer fits the cache.
fn growth(method: &Method) -> f64 {
    match method {
        Method::Collocation => 1.0,
        Method::Dop853(Contacts::Landed | Contacts::Regularised) => 2.0,
        _ => 1.25,
    }
}

/// The wave on a ring of `sites` sites, every entry perturbed; the means do not change, so that the
/// ring keeps its energy.
fn perturbed(sites: usize, seed: u64) -> Result<Scene> {
    let mut file = SceneFile::parse(&Scene::source(SCENE)?, SCENE)?;
    file.chain.sites = sites;
    let wave = Scene::build(file)?;
    let mut random = uniform(seed);
    let mut arrays = wave.initial().as_slice().chunks(sites).map(|array| shaken(array, &mut random));
    let mut next = || arrays.next().unwrap_or_default();
    wave.from_state(next(), next(), next(), next())?.until(PERIODS * wave.period())
}

fn shaken(array: &[f64], random: &mut impl FnMut() -> f64) -> Vec<f64> {
    let size = PERTURBATION * crate::chain::max_norm(array.iter().copied());
    let shifts: Vec<f64> = array.iter().map(|_| size * random()).collect();
    let mean = shifts.iter().sum::<f64>() / shifts.len() as f64;
    array.iter().zip(shifts).map(|(value, shift)| value + (shift - mean)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_perturbed_ring_differs_in_every_entry_and_has_an_energy() {
        let (scene, same, other) = (perturbed(50, 1).unwrap(), perturbed(50, 1).unwrap(), perturbed(50, 2).unwrap());
        let wave = Scene::load(SCENE).unwrap();
        let [y, unperturbed] = [&scene, &wave].map(|scene| scene.initial().as_slice());
        assert!(y.iter().zip(unperturbed).all(|(a, b)| a != b));
        assert!(scene.chain().has_energy(y));
        assert_eq!(y, same.initial().as_slice());
        assert_ne!(y, other.initial().as_slice());
        assert_eq!(scene.end(), PERIODS * wave.period());
    }
}
