//! How fast modulations of a travelling wave grow: in theory, and on the full chain.

mod report;

use crate::study::{Changes, Progress, Study, Work, fit_line, options::options};
use crate::{
    chain::{Boundary, Chain, Params, Resonators, State},
    error::{Error, Result, refuse, require},
    numerics::largest_by,
    report::Report,
    run::state_at,
    scene::Theory,
    sweep::{Engine, Grid, map},
    waves::{Mode, Modulation, Shape, Size, TravellingWave, strains},
};
use hertzchain_integrators::collocation::StepControl;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::f64::consts::PI;

/// Sites of rings that may be asked for, and most sites of rings that are integrated.
const MOST_MEASURED_SITES: usize = 1000;
/// Size of the mode at the start, relative to the wave.
const SEED: f64 = 1e-6;
/// Tolerance of the runs. The error that it leaves in the growth of a perturbation of that size is
/// its square root.
const TOLERANCE: f64 = 1e-11;
/// The window of the fit, in e-folding times of the fastest mode of the ring (of a neutral wave: in
/// `1/Omega`), and samples in it.
const WINDOW: (f64, f64) = (0.5, 3.0);
const SAMPLES: usize = 240;
/// Longest runs in periods of the wave.
const MOST_PERIODS: f64 = 1e5;
/// Cells of the chart in `q` and in `b / (2 kappa a)`, and the range of the latter.
const CELLS: (usize, usize) = (120, 120);
const MEANS: (f64, f64) = (-3.0, 1.0);
/// Mass ratios for which the chart gives the factor of its growth rates.
const RHOS: [f64; 4] = [1.0 / 3.0, 1.0, 3.0, 10.0];

options! {
    /// Modulations of a wave, from a scene or from numbers.
    pub struct ModulationStudy {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// The scene must have an initial state of kind travelling-wave. All numbers of the wave
        /// are taken from it, in place of the flags.
        scene: Option<String> = None,
            [conflicts_with_all = ["alpha", "kappa", "rho", "a", "b", "q_over_pi", "epsilon", "sites"]];
        /// Changes to it.
        set: Changes = Changes::default();
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (above 0 to 10);
        /// Spring constant of the resonators.
        kappa: f64 = 1.0, "K", (positive);
        /// Mass ratio resonator to bead.
        ///
        /// Above 0; inf for Newton's cradle (its DpS equation), with --b 0.
        rho: f64 = 1.0 / 3.0, "R";
        /// Amplitude of the wave.
        a: f64 = 1.0, "A", (positive);
        /// Mean strain.
        ///
        /// Mean strain b of the wave, in the units of the modulation equations; below 2 kappa a.
        b: f64 = 1.0, "B";
        /// Wave number over pi, with a whole number of waves on the ring.
        q_over_pi: f64 = 0.2, "Q", (-1 to 1);
        /// Sizes of the wave, separated by commas.
        ///
        /// Rates per unit of time are computed for the first size. With --measure, growth is
        /// measured at each of them.
        epsilon: Vec<f64> = vec![0.01], "E,F,..", (above 0 below 1);
        /// Number of sites.
        ///
        /// Length of the ring; with --measure at most 1000.
        sites: usize = 50, "N", (2 to 10_000);
        /// Measure the growth on the full chain as well.
        measure: bool = false;
        /// Number of wave numbers at which growth is measured.
        ///
        /// They are spread over the wave numbers of the ring; that of the fastest growth is added.
        modes: usize = 12, "M", (1 or more), [requires = "measure"];
        /// Chart the fastest growth over wave number and mean strain as well.
        chart: bool = false;
    }
}

impl ModulationStudy {
    /// The wave of the scene, or that of the numbers.
    fn options(&self) -> Result<StabilityOptions> {
        self.within_ranges()?;
        let &Self { alpha, kappa, rho, a, b, q_over_pi, sites, measure, modes, chart, .. } = self;
        let modes = measure.then_some(modes);
        let Some(name) = &self.scene else {
            refuse("set", self.set.set.first(), "it changes a scene: name one")?;
            let shape = Shape { q: q_over_pi * PI, a, b, phi: 0.0 };
            let (params, epsilons) = (Params { alpha, kappa, rho }, self.epsilon.clone());
            return Ok(StabilityOptions { params, shape, epsilons, sites, modes, chart });
        };
        let scene = crate::study::scene(name, &self.set)?;
        let Some(Theory::Wave(wave)) = scene.theory() else {
            return Err(Error::parameter("scene", name, "a scene that starts from a travelling wave"));
        };
        let (params, shape, epsilons) = (wave.params(), wave.shape(), vec![wave.epsilon()]);
        Ok(StabilityOptions { params, shape, epsilons, sites: scene.chain().sites(), modes, chart })
    }
}

impl Study for ModulationStudy {
    const FILES: &'static str =
        "The picture is dps-growth.png. measured.csv and the store come with --measure, chart.csv with --chart.";
    const STORE: &'static str = "growth.store";

    fn outline() -> Option<Report> {
        Some(report::outline())
    }

    fn optional_files() -> Vec<String> {
        ["measured.csv", "chart.csv"].map(str::to_owned).into()
    }

    fn begin(&self) -> Result<Work<'_>> {
        let options = self.options()?;
        Ok(Box::new(move |engine, progress| Ok(stability(&options, engine, progress)?.report())))
    }
}

/// What to compute.
#[derive(Clone, Debug)]
pub struct StabilityOptions {
    /// The chain.
    pub params: Params,
    /// The wave, all but its size.
    pub shape: Shape,
    /// Sizes of the wave: rates per unit of time are those of the first, and growth is measured at
    /// each.
    pub epsilons: Vec<f64>,
    /// Sites of the ring.
    pub sites: usize,
    /// Wave numbers at which growth is measured on the full chain, spread over those of the ring;
    /// the fastest comes on top. None: nothing is measured.
    pub modes: Option<usize>,
    /// Whether the largest growth is charted over `q` and `b`.
    pub chart: bool,
}

/// Factors that convert rates per slow time, for a wave of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// `epsilon`.
    pub epsilon: f64,
    /// `epsilon^{alpha-1}`: slow time per unit of time.
    pub slow: f64,
    /// `omega_tw` (eq:w_tw).
    pub omega_tw: f64,
    /// `(1 + rho) epsilon^{alpha-1}`: the theory holds where it is small, so that mean strains
    /// follow at once. Infinite with `rho`, where there are none.
    pub lag: f64,
}

impl Rates {
    fn new(params: Params, modulation: &Modulation, epsilon: f64) -> Self {
        let slow = epsilon.powf(params.alpha - 1.0);
        Self {
            epsilon,
            slow,
            omega_tw: params.omega() + slow * modulation.slow_frequency(),
            lag: (1.0 + params.rho) * slow,
        }
    }

    /// A rate per slow time, per unit of time.
    pub fn per_time(&self, rate: f64) -> f64 {
        self.slow * rate
    }

    /// A rate per slow time, per period of the wave.
    pub fn per_period(&self, rate: f64) -> f64 {
        self.per_time(rate) * 2.0 * PI / self.omega_tw
    }
}

/// Theory at one wave number of the ring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StabilityRow {
    /// Wave number of the perturbation.
    pub p: f64,
    /// Growth rate per slow time.
    pub growth: f64,
    /// Frequency of the mode that grows, per slow time, in the frame of the wave's phase.
    pub frequency: f64,
}

/// A growth that was measured on the full chain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredGrowth {
    /// Size of the wave.
    pub epsilon: f64,
    /// What was measured; rates per slow time.
    pub row: StabilityRow,
    /// The rates of theory.
    pub theory: StabilityRow,
    /// Largest deviation of the logarithm of the mode's size from the line that was fitted.
    pub residual: f64,
    /// First and last time of the fit, in units of `t`.
    pub window: (f64, f64),
}

/// The largest growth over wave numbers and mean strains of waves.
#[derive(Clone, Debug)]
pub struct StabilityChart {
    /// Wave numbers, the middles of cells that fill `[0, pi]`.
    pub q: Vec<f64>,
    /// Mean strains, the middles of cells that fill `2 kappa a [-3, 1]`.
    pub b: Vec<f64>,
    /// A row of cells each `b`: the growth rate per slow time of the fastest mode on an infinite
    /// chain, zero where none grows.
    pub growth: Vec<Vec<f64>>,
    /// For each `b` the `q` at which `cos q + s cos^2(q/2)` vanishes: long waves grow below it,
    /// short ones from there to `pi/2`.
    pub edge: Vec<f64>,
    /// Mass ratios, each with the factor by which all growth rates are larger there.
    pub rho: Vec<(f64, f64)>,
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct StabilityStudy {
    /// The options.
    pub options: StabilityOptions,
    /// The linear problem.
    pub modulation: Modulation,
    /// The sizes of the wave.
    pub rates: Vec<Rates>,
    /// A row for each `p = 2 pi j / N`, `j` from 0 to `N/2`.
    pub rows: Vec<StabilityRow>,
    /// What was measured, by size and wave number.
    pub measured: Vec<MeasuredGrowth>,
    /// The chart.
    pub chart: Option<StabilityChart>,
}

impl StabilityStudy {
    /// The fastest of the ring's modes, if one grows.
    pub fn fastest(&self) -> Option<&StabilityRow> {
        largest_by(self.rows.iter().filter(|row| row.growth > 0.0), |row| row.growth)
    }
}

/// Computes the growth rates of theory, and the chart and the measurements that the options ask
/// for. Each size at which growth is measured is a point of a grid. `progress` is told the share
/// done.
///
/// # Errors
/// An option outside its rule, or a run that fails.
pub fn stability(options: &StabilityOptions, engine: &Engine, progress: Progress<'_>) -> Result<StabilityStudy> {
    let &StabilityOptions { params, shape, sites, .. } = options;
    let modulation = Modulation::new(params, shape)?;
    check(options)?;
    let rates = options.epsilons.iter().map(|&epsilon| Rates::new(params, &modulation, epsilon)).collect();
    let rows = (0..=sites / 2).map(|j| theory(&modulation, 2.0 * PI * j as f64 / sites as f64)).collect();
    let mut study =
        StabilityStudy { options: options.clone(), modulation, rates, rows, measured: Vec::new(), chart: None };
    if let Some(modes) = options.modes {
        study.measured = measure(&study, modes, engine, progress)?;
    }
    if options.chart {
        study.chart = Some(chart(params, shape)?);
    }
    Ok(study)
}

fn check(options: &StabilityOptions) -> Result<()> {
    let StabilityOptions { params, shape, epsilons, sites, modes, chart } = options;
    let defaults = ModulationStudy::default();
    let (epsilon, modes_or) = (epsilons.clone(), modes.unwrap_or(defaults.modes));
    ModulationStudy { epsilon, sites: *sites, modes: modes_or, ..defaults }.within_ranges()?;
    let waves = shape.q * *sites as f64 / (2.0 * PI);
    let rule = "a whole number of waves fits the ring: q sites / (2 pi) is an integer";
    require((waves - waves.round()).abs() <= 1e-9 * waves.abs().max(1.0), "sites", sites, rule)?;
    let (moving, theory_only) = (params.resonators() != Resonators::Fixed, modes.is_none());
    let rule = "growth is measured and charted for moving resonators: rho < inf";
    require(moving || theory_only && !chart, "rho", params.rho, rule)?;
    let rule = "growth is measured on rings of at most 1000 sites";
    require(theory_only || *sites <= MOST_MEASURED_SITES, "sites", sites, rule)
}

fn theory(modulation: &Modulation, p: f64) -> StabilityRow {
    let first = modulation.eigenvalues(p)[0];
    StabilityRow { p, growth: first.growth, frequency: first.frequency }
}

/// The chart of the largest growth of waves of the same amplitude, for all `q` and `b`.
fn chart(params: Params, shape: Shape) -> Result<StabilityChart> {
    let middles = |(from, to): (f64, f64), count: usize| -> Vec<f64> {
        (0..count).map(|k| from + (to - from) * (k as f64 + 0.5) / count as f64).collect()
    };
    let swing = 2.0 * params.kappa * shape.a;
    let q = middles((0.0, PI), CELLS.0);
    let b = middles((swing * MEANS.0, swing * MEANS.1), CELLS.1);
    let (mut growth, mut edge) = (Vec::new(), Vec::new());
    for &b in &b {
        let waves = Modulation::new(params, Shape { b, ..shape })?;
        let s = waves.slope();
        edge.push((-s / (2.0 + s)).acos());
        growth.push(q.iter().map(|&q| waves.at(q).fastest().map_or(0.0, |(_, growth)| growth)).collect());
    }
    let slowness = |rho: f64| (1.0 + rho.recip()).powf(1.5);
    let rho = RHOS.iter().map(|&rho| (rho, slowness(params.rho) / slowness(rho))).collect();
    Ok(StabilityChart { q, b, growth, edge, rho })
}

/// The largest growth rate per slow time; the frequency of slow motion where nothing grows.
fn fastest(study: &StabilityStudy) -> f64 {
    study.fastest().map_or(study.modulation.slow_frequency(), |row| row.growth)
}

/// What all runs of one size share.
struct Bench {
    rates: Rates,
    wave: TravellingWave,
    chain: Chain<f64>,
    times: Vec<f64>,
    /// The amplitudes `D_n` of the wave alone, at each time.
    amplitudes: Vec<Vec<Complex64>>,
}

impl Bench {
    fn new(study: &StabilityStudy, rates: Rates) -> Result<Self> {
        let &StabilityOptions { params, shape, sites, .. } = &study.options;
        let wave = TravellingWave::new(params, shape, Size::Epsilon(rates.epsilon))?;
        let chain = Chain::new(params, Boundary::StrainRing, sites)?;
        let rate = rates.per_time(fastest(study));
        let share = |k: usize| k as f64 / (SAMPLES - 1) as f64;
        let times = (0..SAMPLES).map(|k| (WINDOW.0 + (WINDOW.1 - WINDOW.0) * share(k)) / rate).collect();
        let mut bench = Self { rates, wave, chain, times, amplitudes: Vec::new() };
        bench.amplitudes = bench.run(&State::from_fn(&bench.chain, |n| wave.site(n, 0.0))?)?;
        Ok(bench)
    }

    /// The amplitudes at each of `times` along a run.
    fn run(&self, initial: &State<f64>) -> Result<Vec<Vec<Complex64>>> {
        let end = self.times.last().copied().unwrap_or_default();
        let mut run = self.chain.collocation(initial.as_slice(), (0.0, end), StepControl::Tolerance(TOLERANCE))?;
        self.times.iter().map(|&t| Ok(strains(&self.wave, t, quarters(&state_at(&mut run, t)?)))).collect()
    }

    /// The growth of a mode that is added to the wave.
    fn growth(&self, mode: &Mode, theory: StabilityRow) -> Result<MeasuredGrowth> {
        let initial = State::from_fn(&self.chain, |n| mode.site(&self.wave, SEED, n))?;
        let share = |(wave, changed): (&Vec<_>, Vec<_>)| mode.share(wave, &changed);
        let shares: Vec<Complex64> = self.amplitudes.iter().zip(self.run(&initial)?).map(share).collect();
        let slow = |t: &f64| self.rates.slow * t;
        let line = |values: &[f64]| {
            let points: Vec<_> = self.times.iter().map(slow).zip(values.iter().copied()).collect();
            fit_line(&points).unwrap_or((f64::NAN, f64::NAN))
        };
        let (growth, residual) = line(&shares.iter().map(|share| share.norm().ln()).collect::<Vec<_>>());
        let (frequency, _) = line(&unwrapped(&shares));
        let row = StabilityRow { growth, frequency, ..theory };
        let window = (self.times[0], self.times[SAMPLES - 1]);
        Ok(MeasuredGrowth { epsilon: self.rates.epsilon, row, theory, residual, window })
    }
}

/// `[x, y, x', y']` of a state.
fn quarters(y: &[f64]) -> [&[f64]; 4] {
    let n = y.len() / 4;
    [0, 1, 2, 3].map(|k| &y[k * n..(k + 1) * n])
}

/// Arguments of complex numbers, each within half a turn of the one before.
pub fn unwrapped(z: &[Complex64]) -> Vec<f64> {
    let mut turned = 0.0;
    let steps = z.windows(2).map(|pair| (pair[1] / pair[0]).arg());
    std::iter::once(0.0)
        .chain(steps.map(|step| {
            turned += step;
            turned
        }))
        .collect()
}

/// The growth of some modes of the ring at every size of the wave: two runs each, one of them the
/// wave alone.
fn measure(
    study: &StabilityStudy,
    count: usize,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<Vec<MeasuredGrowth>> {
    let modes: Vec<(StabilityRow, Mode)> =
        chosen(study, count).into_iter().filter_map(|row| Some((row, Mode::new(&study.modulation, row.p)?))).collect();
    let StabilityOptions { params, shape, sites, epsilons, .. } = &study.options;
    let slow = |rates: &&Rates| {
        let periods = WINDOW.1 / rates.per_time(fastest(study)) * rates.omega_tw / (2.0 * PI);
        periods.is_nan() || periods > MOST_PERIODS
    };
    let rule = "growth that takes more than 10^5 periods of the wave is not measured";
    refuse("epsilon", study.rates.iter().find(slow).map(|slow| slow.epsilon), rule)?;
    let settings = json!({"params": params, "shape": shape, "sites": sites, "modes": count});
    let grid = Grid { store: ModulationStudy::STORE, study: "modulation", settings };
    let work = |&epsilon: &f64| {
        let bench = Bench::new(study, Rates::new(*params, &study.modulation, epsilon))?;
        map(&modes, |(row, mode)| bench.growth(mode, *row)).into_iter().collect::<Result<Vec<_>>>()
    };
    let swept = engine.sweep(&grid, epsilons, progress, work)?;
    Ok(swept.all(epsilons, |epsilon| format!("epsilon = {epsilon}"))?.concat())
}

/// `count` rows spread over the ring's wave numbers without zero, the last one included; and the
/// row that grows fastest.
fn chosen(study: &StabilityStudy, count: usize) -> Vec<StabilityRow> {
    let last = study.rows.len() - 1;
    let count = count.min(last);
    let mut indices: Vec<usize> = (1..=count).map(|k| k * last / count).collect();
    indices.extend(study.fastest().and_then(|fastest| study.rows.iter().position(|row| row == fastest)));
    indices.sort_unstable();
    indices.dedup();
    indices.into_iter().map(|j| study.rows[j]).collect()
}
