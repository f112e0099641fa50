//! Charts of stability: in which regimes each method is stable, at which step, and at what cost.
//!
//! | symbol | meaning |
//! |---|---|
//! | `A` | amplitude: the largest overlap that the state can make |
//! | `Omega_c` | `sqrt(2 alpha (A + delta_0)^{alpha-1})`, the stiffness of the contacts of a bead; a *contact period* is `2 pi/Omega_c` |
//! | `omega` | `sqrt(kappa (1 + 1/rho))`, the frequency of a bead against its resonator |
//! | *fast* | `max(omega, Omega_c)`, the fastest motion |
//! | *error* | largest `|H - H(0)|/|H(0)|` at 128 times of a run (fewer on long chains) |
//! | *cost* | force evaluations a unit of time |
//!
//! A point is a method on a variant of the problem: another mass ratio, another amplitude and
//! spring constant, another exponent, length or span. It runs over ten contact periods, at most
//! 10^4 periods of the fastest motion, over a ladder of steps, each the one before over `sqrt 2`,
//! or of tolerances. A run that would take more work than it may is left out or stopped, and is
//! marked so. A ladder may step over resonances of steps with periods.
//!
//! Measured on the built-in problem: kinetic splits lose stability where the harmonic oscillator
//! does (Verlet at `h omega = 2`); every scheme on the exact linear flow has resonances;
//! collocation at tolerance 10^-9 is stable at all points, with an error of at most `4.3 10^-10`,
//! at `A = 10^-12`, `kappa = 10^8`. Of the looser tolerances, from 0.1 on, its error exceeds one at
//! one point: `10^-7`, by 3.4 times.

mod report;

mod measure;
mod problem;

pub use measure::{BOUNDS, Behaviour, Limit, Measured, Trial};
pub use problem::{Problem, Variant};

use crate::study::{
    Changes, Progress, ResultUnits, Study, Work, methods,
    options::{one, options},
    run::error_in,
    scene,
};
use crate::{
    error::{Error, Result, refuse},
    named::named,
    number::rounded,
    numerics::least_by,
    report::Report,
    run::method::{Contacts, Method},
    scene::{Quantity, Units},
    sweep::{Engine, Grid, Row},
};
use measure::{Search, measure};
use serde::Serialize;
use serde_json::json;
use std::time::{Duration, Instant};

/// Length of runs in contact periods.
const PERIODS: f64 = 10.0;
/// Most sites on which methods that stop the whole chain at every event are tried.
const STOPPING_SITES: usize = 1000;
/// Sites times contact periods of the runs on long chains.
const SITE_PERIODS: f64 = 1e4;
/// Runs of more contact periods than this may take more work, up to ten times.
const LONG: f64 = 1e3;

named! {
    /// One chart.
    pub enum Chart {
        /// (a) mass ratios from 1e-8 to 1e8, with steps from 12/omega down.
        Light = "light",
        /// (b) amplitudes from 1e-12 to 1e3 against spring constants from 1e-8 to 1e8.
        Stiffness = "stiffness",
        /// (c) exponents from 0.5 to 10.
        Alpha = "alpha",
        /// (d) numbers of beads from 1 to 10^6.
        Length = "length",
        /// (e) lengths of runs.
        Time = "time",
    }
}

impl Chart {
    /// The chart of this name.
    ///
    /// # Errors
    /// An unknown name, with the nearest one.
    pub fn named(name: &str) -> Result<Self> {
        let known = Self::ALL.into_iter().find(|chart| chart.name() == name);
        known.ok_or_else(|| Error::unknown("chart", name, Self::ALL.map(Self::name)))
    }

    fn variants(self, options: &ChartOptions) -> Vec<Variant> {
        let none = Variant::default();
        let thin = |fine: usize| if options.quick { 2 * fine } else { fine };
        let decades = |from: i32, to: i32, by: usize| (from..=to).step_by(by).map(|k| 10f64.powi(k));
        // Powers of ten, and the last number if it is none.
        let up_to = |last: f64| {
            let most = (last.log10() + 1e-9).floor() as i32;
            decades(0, most, 1).chain((10f64.powi(most) < last).then_some(last))
        };
        match self {
            Self::Light => decades(-8, 8, if options.quick { 4 } else { 1 })
                .map(|rho| Variant { rho: Some(rho), ..none })
                .collect(),
            Self::Stiffness => {
                let kappas = || decades(-8, 8, thin(4));
                let at = |a| kappas().map(move |kappa| Variant { amplitude: Some(a), kappa: Some(kappa), ..none });
                decades(-12, 3, if options.quick { 5 } else { 3 }).flat_map(at).collect()
            }
            Self::Alpha => [0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 5.0, 7.0, 10.0]
                .into_iter()
                .step_by(if options.quick { 5 } else { 1 })
                .map(|alpha| Variant { alpha: Some(alpha), ..none })
                .collect(),
            Self::Length => up_to(options.sites as f64)
                .map(|sites| {
                    let periods = Some((SITE_PERIODS / sites).clamp(1.0, PERIODS));
                    Variant { sites: Some(sites as usize), periods, ..none }
                })
                .collect(),
            Self::Time => up_to(options.periods).map(|periods| Variant { periods: Some(periods), ..none }).collect(),
        }
    }
}

options! {
    /// Charts of the built-in chain, or of a scene.
    pub struct Charts {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// The chain and the state that are varied [default: four spheres between walls, kappa = 1,
        /// rho = 1/3, amplitude 1].
        scene: Option<String> = None;
        /// Changes to it.
        set: Changes = Changes::default();
        /// What is charted.
        options: ChartOptions = ChartOptions::default();
        /// The units of results.
        results: ResultUnits = ResultUnits::default();
    }
}

options! {
    /// What to chart.
    pub struct ChartOptions {
        /// Charts, separated by commas [default: all].
        ///
        /// The charts are light (mass ratios), stiffness (amplitudes and spring constants), alpha
        /// (exponents), length (numbers of beads) and time (lengths of runs).
        charts: Vec<Chart> = vec![], "A,B,..";
        /// Integrators, separated by commas, or all [default: all].
        integrators: Vec<String> = vec![], "A,B,..";
        /// Length of the longest run, in periods.
        ///
        /// For the chart `time`, in contact periods 2 pi/sqrt(2 alpha A^(alpha-1)).
        periods: f64 = 1e4, "P", (1 to 1e6);
        /// Largest work of a run while a step is searched for.
        ///
        /// In force evaluations times sites.
        work: f64 = 4e6, "W", (1e4 to 1e12);
        /// Number of sites.
        ///
        /// Length of the longest chain in the chart `length`.
        sites: usize = 100_000, "N", (1 to 1_000_000);
        /// Compute fewer points.
        ///
        /// At most a third of the points of light, stiffness and alpha.
        quick: bool = false;
    }
}

one!(Chart: |name: &str| Chart::named(name.trim()));

impl ChartOptions {
    /// The charts that are named; all if none is.
    fn charts(&self) -> Vec<Chart> {
        if self.charts.is_empty() { Chart::ALL.to_vec() } else { self.charts.clone() }
    }

    fn methods(&self) -> Result<Vec<Method>> {
        methods(&self.integrators, Method::all)
    }
}

impl Study for Charts {
    const FILES: &'static str = "A chart has pictures of its own, CHART.png.";
    const STORE: &'static str = "stability.store";

    fn optional_files() -> Vec<String> {
        let of_chart =
            |chart: Chart| ["", "-ladder", "-errors", "-widths"].map(|part| format!("{}{part}", chart.name()));
        let of_method = |method: Method| ["light", "stiffness"].map(|chart| format!("{chart}-{}", method.name()));
        let tables = Chart::ALL.into_iter().flat_map(of_chart);
        let maps = Method::all().into_iter().flat_map(of_method);
        let names = |stem: String| [format!("{stem}.csv"), format!("{stem}.png")];
        tables.chain(maps).chain(["regimes".to_owned()]).flat_map(names).collect()
    }

    fn outline() -> Option<Report> {
        Some(ChartStudy { charts: Chart::ALL.to_vec(), ..ChartStudy::default() }.report())
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = self.scene.as_ref().map(|name| scene(name, &self.set)).transpose()?;
        let problem = match (&scene, self.set.set.first()) {
            (Some(scene), _) => Problem::of(scene)?,
            (None, Some(change)) => return Err(Error::parameter("set", change, "it changes a scene: name one")),
            (None, None) => Problem::built_in(),
        };
        let (options, si) = (&self.options, scene.as_ref().and_then(|scene| self.results.of(scene)));
        options.methods()?;
        let doubts = scene.map(|scene| scene.doubts()).unwrap_or_default();
        Ok(Box::new(move |engine, progress| {
            let study = charts(&problem, options, engine, progress)?;
            Ok(study.in_units(si.as_ref()).report().warnings(doubts))
        }))
    }
}

/// A method on a variant.
#[derive(Clone, Debug)]
pub struct ChartPoint {
    /// The chart.
    pub chart: Chart,
    /// The variant.
    pub variant: Variant,
    /// The method.
    pub method: Method,
    /// What was measured, or why nothing was.
    pub measured: Row<Measured>,
}

/// The charts.
#[derive(Clone, Debug, Default)]
pub struct ChartStudy {
    /// The charts that were made.
    pub charts: Vec<Chart>,
    /// The methods that were tried.
    pub methods: Vec<Method>,
    /// Force evaluations times sites that a run may take.
    pub work: f64,
    /// The chain and the state that were varied.
    pub problem: Problem,
    /// The points of charts of variants, ordered by chart, then by variant, then by method.
    pub points: Vec<ChartPoint>,
    /// Number of points that were read from stores instead of computed.
    pub resumed: usize,
    /// Wall time.
    pub wall: Duration,
    /// The units of the scene, if all numbers are in SI units.
    pub si: Option<Units>,
}

impl ChartStudy {
    /// The study in SI units: amplitudes, spring constants, times and what is counted a unit of
    /// time.
    #[must_use]
    pub fn in_units(mut self, units: Option<&Units>) -> Self {
        let Some(units) = units else { return self };
        self.si = Some(*units);
        self.problem = self.problem.in_units(units);
        for ChartPoint { variant: Variant { amplitude, kappa, .. }, measured, .. } in &mut self.points {
            // Rounded: they name the columns of pictures and tables.
            amplitude.iter_mut().for_each(|x| *x = rounded(units.to_si(Quantity::Length, *x)));
            kappa.iter_mut().for_each(|x| *x = rounded(units.to_si(Quantity::Stiffness, *x)));
            let Ok(Measured { contact, fast, span, usual, ladder, limits, .. }) = measured else { continue };
            [contact, fast].into_iter().for_each(|x| *x = units.to_si(Quantity::Omega, *x));
            *span *= units.time_s;
            let limits = limits.iter_mut().filter_map(|limit| limit.trial.as_mut());
            for Trial { step, cost, wall, .. } in ladder.iter_mut().chain(limits).chain([usual]) {
                *step *= units.time_s;
                [cost, wall].into_iter().for_each(|x| *x /= units.time_s);
            }
        }
        self
    }

    /// The points of a chart.
    pub fn of(&self, chart: Chart) -> impl Iterator<Item = &ChartPoint> {
        self.points.iter().filter(move |point| point.chart == chart)
    }

    /// The variants of a chart, in order.
    pub fn variants(&self, chart: Chart) -> Vec<Variant> {
        let mut variants: Vec<Variant> = self.of(chart).map(|point| point.variant).collect();
        variants.dedup();
        variants
    }

    /// The point of a method on a variant.
    pub fn point(&self, chart: Chart, variant: &Variant, method: &Method) -> Option<&ChartPoint> {
        self.of(chart).find(|point| point.variant == *variant && point.method == *method)
    }

    /// The method that meets [`BOUNDS`]`[nth]` on a variant with the fewest force evaluations, with
    /// its run.
    pub fn cheapest(&self, chart: Chart, variant: &Variant, nth: usize) -> Option<(Method, &Limit, &Trial)> {
        let candidates = self.of(chart).filter(|point| point.variant == *variant).filter_map(|point| {
            let limit = point.measured.as_ref().ok()?.limits.get(nth)?;
            Some((point.method, limit, limit.trial.as_ref()?))
        });
        least_by(candidates, |one| one.2.cost)
    }
}

/// A point of a chart.
#[derive(Serialize)]
struct Point {
    chart: Chart,
    variant: Variant,
    #[serde(rename = "integrator")]
    method: Method,
}

/// Measures all points of the charts, on all cores. In a folder of the engine they are kept as they
/// are computed, and those that are there are not computed again. `progress` is told the share
/// done.
///
/// # Errors
/// An option outside its rule; a store of another study, or one that was altered; a signal, on
/// which points are kept. A point that fails is a row of its own.
pub fn charts(
    problem: &Problem,
    options: &ChartOptions,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<ChartStudy> {
    let clock = Instant::now();
    options.within_ranges()?;
    let methods = options.methods()?;
    let charted = options.charts();
    let variants = charted.iter().flat_map(|&chart| chart.variants(options).into_iter().map(move |one| (chart, one)));
    let of = |(chart, variant)| methods.iter().map(move |&method| Point { chart, variant, method });
    let places: Vec<Point> = variants.flat_map(of).collect();
    let settings = json!({"problem": problem.source, "work": options.work, "bounds": BOUNDS});
    let grid = Grid { store: Charts::STORE, study: "stability", settings };
    let swept = engine.sweep(&grid, &places, progress, |place| measured(problem, options, place))?;
    if swept.missing > 0 {
        return Err(swept.stopped());
    }
    let point = |(Point { chart, variant, method }, measured)| ChartPoint { chart, variant, method, measured };
    Ok(ChartStudy {
        points: places.into_iter().zip(swept.rows).map(point).collect(),
        work: options.work,
        problem: problem.clone(),
        resumed: swept.resumed,
        charts: charted,
        methods,
        wall: clock.elapsed(),
        si: None,
    })
}

fn measured(problem: &Problem, options: &ChartOptions, place: &Point) -> Result<Measured> {
    let Point { chart, variant, method } = place;
    let stops = matches!(method, Method::Dop853(Contacts::Landed | Contacts::Regularised));
    let rule =
        "a method that stops the whole chain at every event is tried on up to 10^3: its work grows with the square";
    refuse("sites", variant.sites.filter(|sites| stops && *sites > STOPPING_SITES), rule)?;
    let longer = (variant.periods.unwrap_or(PERIODS) / LONG).clamp(1.0, 10.0);
    let search = Search { work: longer * options.work, light: *chart == Chart::Light };
    let prepared = problem.prepare(variant)?;
    measure(&prepared, *method, search).map_err(|error| error_in(error, &prepared.scene, prepared.units.as_ref()))
}
