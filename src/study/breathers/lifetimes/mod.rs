//! Lifetimes of the long-lived bright breather over a map of its size and the mass ratio (Sec. 5).
//!
//! | symbol | meaning |
//! |---|---|
//! | `Omega_b, T_b` | frequency and period of the ansatz (time-periodic_osc) |
//! | `x` | `rho epsilon^{2(alpha-1)}`; the theorem wants it bounded from below |
//! | horizon | `T epsilon^{1-alpha}`, the time scale of the theorem |
//! | core | the central sites, [`BrightBreather::core`] |
//! | contact | share of the last ten `T_b` in which a bond of the core is closed, on average over its bonds: 1/2 as long as neighbours swing in antiphase about no gap |
//!
//! A run starts from (ini_num) and is sampled at least 16 times a `T_b`. It ends when the core has
//! less than 0.9 of the energy, or at the cap. The lifetime is the first time at which a sample has
//! so little, located on the dense output to `10^-8 T_b`; the share oscillates a little within a
//! period.
//!
//! The [`Fate`] of a breather depends on what comes first: less than 0.9 of the energy in the core,
//! or less contact than 1/3.

mod report;

use crate::study::{Adaptive, Progress, Study, Work, options::options};

use crate::{
    breathers::BrightBreather,
    chain::{Boundary, Chain, Params, State},
    dps::Center,
    error::{Result, require},
    interrupt,
    named::named,
    numerics::{fit_line, fit_plane},
    report::Report,
    run::Run,
    sweep::{Engine, Grid, Row},
};
use hertzchain_integrators::{Error as Failure, Stepper};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{
    collections::VecDeque,
    ops::{Range, RangeInclusive},
    time::{Duration, Instant},
};

/// Share of the energy in the core, below which the breather has radiated.
const CORE_SHARE: f64 = 0.9;
/// Contact, below which bonds are open twice as long as they are closed.
const CONTACT: f64 = 1.0 / 3.0;
/// Samples a period at least.
const SAMPLES: f64 = 16.0;
/// Periods over which contact is measured.
const CONTACT_PERIODS: f64 = 10.0;
/// Accuracy of a crossing, in periods.
const RESOLUTION: f64 = 1e-8;
/// Default end of a run, the cap, in horizons.
const CAP: f64 = 25.0;
/// Share of the energy at which an end of the chain counts as reached.
const REACHED: f64 = 1e-9;
/// Sites of a chain at first, and at most after it was doubled, unless they are given.
const SITES: RangeInclusive<usize> = 100..=25_600;
/// Most periods of a run.
const MOST_PERIODS: f64 = 1e6;
/// `x` from which lifetimes are fitted.
const FITTED_FROM: f64 = 10.0;
/// Largest ratio of a lifetime to its fit that a power law may have.
const HONEST: f64 = 1.25;

named! {
    /// The fate of a breather.
    #[derive(Default)]
    pub enum Fate {
        /// The core has less than 0.9 of the energy before contact falls below 1/3.
        Radiates = "radiates",
        /// Contact falls below 1/3 first: gaps open between the central sites, until each
        /// oscillates on its own as in a trivial breather (uncpl).
        Decouples = "decouples",
        /// Neither before the cap.
        #[default]
        Persists = "persists",
    }
}

options! {
    /// The map of lifetimes.
    pub struct LifetimeOptions {
        /// Sizes epsilon of the oscillation, separated by commas.
        ///
        /// Displacements start at 2 epsilon a_n. Each is named once.
        epsilons: Vec<f64> = vec![1e-3, 3e-3, 0.01, 0.03, 0.1], "E,F,..", (above 0 below 1);
        /// Mass ratios resonator to bead, separated by commas.
        ///
        /// Each is named once.
        rhos: Vec<f64> = vec![10.0, 100.0, 1e3, 1e4, 1e5], "R,S,..", (positive);
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (1.01 to 10);
        /// What the profile is symmetric about.
        center: Center = Center::Bond, "C";
        /// Number of sites.
        ///
        /// Length of every chain. By default it is doubled from 100 on, up to 25600, until no wave
        /// comes back from the ends.
        sites: Option<usize> = None, "N", (20 to 100_000);
        /// End time, in units of time [default: for each breather 25 times the theorem's time
        /// scale, T epsilon^(1-alpha)].
        ///
        /// No breather is followed longer.
        until: Option<f64> = None, "T", (positive);
    } with {
        /// How the chains are run.
        solver: Adaptive = Adaptive { tol: 1e-9, ..Adaptive::default() };
    }
}

impl Study for LifetimeOptions {
    const STORE: &'static str = "lifetimes.store";

    fn outline() -> Option<Report> {
        Some(Report::new("lifetimes").table(report::points(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        Ok(Box::new(|engine, progress| Ok(lifetimes(self, engine, progress)?.report())))
    }
}

/// The life of one breather.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Life {
    /// The lifetime; `None`: not before `end`.
    pub lifetime: Option<f64>,
    /// Time until which it was followed.
    pub end: f64,
    /// Its fate.
    pub fate: Fate,
    /// Time at which contact fell below 1/3, if it did.
    pub decoupled: Option<f64>,
    /// Share of the energy in the core at the end.
    pub core_share: f64,
    /// Contact at the end.
    pub contact: f64,
    /// Sites of the chain.
    pub sites: usize,
    /// Time from which the ends of the chain may be felt: twice the time at which they were
    /// reached.
    pub ends_felt: Option<f64>,
}

/// A point of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct LifetimePoint {
    /// Size.
    pub epsilon: f64,
    /// Mass ratio.
    pub rho: f64,
    /// `x = rho epsilon^{2(alpha-1)}`.
    pub x: f64,
    /// `T epsilon^{1-alpha}`.
    pub horizon: f64,
    /// `Omega_b`.
    pub omega_b: f64,
    /// The life of the breather, or why there is none.
    pub life: Row<Life>,
}

/// `lifetime = factor rho^rho_power epsilon^epsilon_power` where `x >= 10` and breathers radiate,
/// by least squares of logarithms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerLaw {
    /// Points it is fitted to.
    pub points: usize,
    /// The factor.
    pub factor: f64,
    /// The power of `rho`.
    pub rho_power: f64,
    /// The power of `epsilon`.
    pub epsilon_power: f64,
    /// Largest ratio of a lifetime to its fit, or of the fit to the lifetime.
    pub largest_ratio: f64,
    /// The power of `x` in `lifetime = factor horizon x^power`, fitted to the same points:
    /// lifetimes as a function of `x` alone, in the theorem's time scale.
    pub x_power: f64,
    /// The largest ratio of that.
    pub x_largest_ratio: f64,
}

impl PowerLaw {
    /// Whether it describes its points: the largest ratio is at most 1.25.
    pub fn holds(&self) -> bool {
        self.largest_ratio <= HONEST
    }
}

/// The map.
#[derive(Clone, Debug)]
pub struct LifetimeStudy {
    /// The options.
    pub options: LifetimeOptions,
    /// All points: sizes one after the other, in each all mass ratios.
    pub points: Vec<LifetimePoint>,
    /// The power law; `None` with fewer than four points, or if they lie on a line.
    pub fit: Option<PowerLaw>,
    /// Number of points that were read from the store.
    pub resumed: usize,
    /// Number of points that were computed now.
    pub computed: usize,
    /// Wall time.
    pub wall: Duration,
}

/// Follows every breather of the map to its end. In a folder of the engine points are kept as they
/// are computed, and those that are there are not computed again. `progress` is told the share
/// done.
///
/// A point that fails is a row of its own. Points run on all cores; every number is the same for
/// any number of them.
///
/// # Errors
/// An option outside its rule; a store of another study, or one that was altered.
pub fn lifetimes(options: &LifetimeOptions, engine: &Engine, progress: Progress<'_>) -> Result<LifetimeStudy> {
    let clock = Instant::now();
    let places = checked(options)?;
    let grid = Grid { store: LifetimeOptions::STORE, study: "lifetimes", settings: settings(options) };
    let swept = engine.sweep(&grid, &places, progress, |place| place.life(options))?;
    let (resumed, computed) = (swept.resumed, swept.computed());
    let points = places.iter().zip(swept.rows).map(|(place, life)| place.point(options, life));
    let points = points.collect::<Result<Vec<_>>>()?;
    let fit = power_law(&points);
    Ok(LifetimeStudy { options: options.clone(), points, fit, resumed, computed, wall: clock.elapsed() })
}

/// The settings of the store: all that a life depends on besides size and mass ratio.
fn settings(options: &LifetimeOptions) -> serde_json::Value {
    let LifetimeOptions { alpha, center, sites, until, solver, .. } = options;
    json!({
        "alpha": alpha,
        "center": center,
        "sites": sites,
        "until": until,
        "integrator": solver.method.name(),
        "tolerance": solver.tol,
        "levels": [CORE_SHARE, CONTACT],
        "looks": [SAMPLES, CAP, REACHED],
    })
}

/// The places of the map, if all options keep their rules.
fn checked(options: &LifetimeOptions) -> Result<Vec<Point>> {
    let LifetimeOptions { epsilons, rhos, solver, .. } = options;
    options.within_ranges()?;
    solver.check()?;
    let at = |epsilon: &f64| rhos.iter().map(|&rho| Point { epsilon: *epsilon, rho }).collect::<Vec<_>>();
    let places: Vec<Point> = epsilons.iter().flat_map(at).collect();
    for place in &places {
        let breather = place.breather(options, place.sites(options))?;
        let cap = options.until.unwrap_or(CAP * breather.horizon());
        let rule = "a run has at most 10^6 periods of the breather: give an earlier --until";
        require(cap <= MOST_PERIODS * breather.period(), "until", cap, rule)?;
    }
    Ok(places)
}

/// A point of the map that is to be computed.
#[derive(Clone, Copy, Debug, Serialize)]
struct Point {
    epsilon: f64,
    rho: f64,
}

impl Point {
    /// Sites to begin with: symmetric about the centre.
    fn sites(&self, options: &LifetimeOptions) -> usize {
        options.sites.unwrap_or(match options.center {
            Center::Bond => *SITES.start(),
            Center::Site => *SITES.start() + 1,
        })
    }

    fn breather(&self, options: &LifetimeOptions, sites: usize) -> Result<BrightBreather> {
        BrightBreather::new(Params::new(options.alpha, 1.0, self.rho)?, options.center, self.epsilon, sites)
    }

    fn point(&self, options: &LifetimeOptions, life: Row<Life>) -> Result<LifetimePoint> {
        let breather = self.breather(options, self.sites(options))?;
        let (horizon, omega_b) = (breather.horizon(), breather.omega_b());
        Ok(LifetimePoint {
            epsilon: self.epsilon,
            rho: self.rho,
            x: breather.mass_condition().recip(),
            horizon,
            omega_b,
            life,
        })
    }

    /// The life, on a chain that is doubled until nothing comes back from its ends during the run.
    fn life(&self, options: &LifetimeOptions) -> Result<Life> {
        let mut sites = self.sites(options);
        loop {
            let may_grow = options.sites.is_none() && 2 * sites <= *SITES.end();
            if let Some(life) = self.follow(options, sites, may_grow)? {
                return Ok(life);
            }
            // Odd lengths stay odd.
            sites = 2 * sites - sites % 2;
        }
    }

    /// The life on a chain of `sites` sites; `None` once its ends may be felt, if a longer chain is
    /// allowed.
    fn follow(&self, options: &LifetimeOptions, sites: usize, may_grow: bool) -> Result<Option<Life>> {
        let breather = self.breather(options, sites)?;
        let chain = Chain::new(breather.params(), Boundary::Free, sites)?;
        let start = State::from_fn(&chain, |i| breather.site(i, 0.0))?;
        let run = Run::new(chain.clone(), start).until(options.until.unwrap_or(CAP * breather.horizon()))?;
        let mut run = run.method(options.solver.method).tolerance(options.solver.tol)?.stepper()?;
        let mut watch = Watch::new(&breather, &chain);
        while !run.done() && watch.life.lifetime.is_none() {
            if may_grow && watch.ends_felt() {
                return Ok(None);
            }
            let from = run.time();
            if interrupt::asked() {
                return Err(Failure::Stopped { t: from }.into());
            }
            run.step()?;
            let (h, longest) = (run.time() - from, breather.period() / SAMPLES);
            let parts = (h / longest).ceil().max(1.0);
            for k in 1..=parts as u64 {
                let t = if k as f64 == parts { run.time() } else { from + h * (k as f64 / parts) };
                watch.look(t, &mut *run)?;
            }
        }
        Ok(Some(watch.life()))
    }
}

/// What is measured of a state at one time.
#[derive(Clone, Copy)]
struct Measured {
    t: f64,
    /// Share of the energy in the core.
    core: f64,
    /// Share of the energy in the two beads at the ends.
    ends: f64,
    /// Share of the bonds of the core that are closed.
    closed: f64,
}

/// Measures samples of a run, and keeps what is known of the life.
struct Watch<'a> {
    breather: &'a BrightBreather,
    chain: &'a Chain<f64>,
    core: Range<usize>,
    y: Vec<f64>,
    last: Measured,
    /// Times of samples of the last ten periods, each with the time up to it in which bonds of the
    /// core were closed, on average over bonds.
    closed: VecDeque<(f64, f64)>,
    /// The times that are known; what belongs to the end comes last.
    life: Life,
}

impl<'a> Watch<'a> {
    fn new(breather: &'a BrightBreather, chain: &'a Chain<f64>) -> Self {
        let mut watch = Self {
            breather,
            chain,
            core: breather.core(),
            y: vec![0.0; chain.layout().dim()],
            last: Measured { t: 0.0, core: 1.0, ends: 0.0, closed: 0.0 },
            closed: VecDeque::from([(0.0, 0.0)]),
            life: Life { sites: chain.sites(), ..Life::default() },
        };
        for i in 0..chain.sites() {
            watch.y[i] = breather.site(i, 0.0).u;
        }
        watch.last = watch.sight(0.0);
        watch
    }

    /// The measures of the state `y` at time `t`.
    fn sight(&self, t: f64) -> Measured {
        let (chain, y, n) = (self.chain, &self.y, self.chain.sites());
        let u = chain.layout().u(y);
        let energies = chain.site_energies(y);
        let total: f64 = energies.iter().sum();
        let bonds = self.core.start + 1..self.core.end;
        let closed = bonds.clone().filter(|&i| u[i - 1] > u[i]).count();
        Measured {
            t,
            core: energies[self.core.clone()].iter().sum::<f64>() / total,
            ends: (energies[0] + energies[n - 1]) / total,
            closed: closed as f64 / bonds.len() as f64,
        }
    }

    fn sight_of(&mut self, t: f64, run: &mut dyn Stepper<f64>) -> Result<Measured> {
        run.sample(t, &mut self.y);
        match self.y.iter().position(|value| !value.is_finite()) {
            Some(index) => Err(Failure::NotFinite { t, step: run.stats().steps, index }.into()),
            None => Ok(self.sight(t)),
        }
    }

    /// Measures the state at time `t` of the last step, which also holds the time of the sample
    /// before.
    fn look(&mut self, t: f64, run: &mut dyn Stepper<f64>) -> Result<()> {
        let (before, now) = (self.last, self.sight_of(t, run)?);
        if self.life.lifetime.is_none() && now.core < CORE_SHARE {
            self.life.lifetime = Some(self.crossing(before.t, t, run)?);
        }
        if self.life.ends_felt.is_none() && now.ends > REACHED {
            // Waves from the ends take at least as long as they took to the ends.
            self.life.ends_felt = Some(2.0 * t);
        }
        self.touched(before, now);
        self.last = now;
        Ok(())
    }

    /// The time between two times at which the core loses its share, by bisection.
    fn crossing(&mut self, mut before: f64, mut after: f64, run: &mut dyn Stepper<f64>) -> Result<f64> {
        while after - before > RESOLUTION * self.breather.period() {
            let middle = 0.5 * (before + after);
            if self.sight_of(middle, run)?.core < CORE_SHARE { after = middle } else { before = middle }
        }
        Ok(after)
    }

    /// Adds the contact between two samples, and checks whether it fell below 1/3.
    fn touched(&mut self, before: Measured, now: Measured) {
        let sum = self.closed.back().map_or(0.0, |last| last.1);
        self.closed.push_back((now.t, sum + 0.5 * (before.closed + now.closed) * (now.t - before.t)));
        let window = CONTACT_PERIODS * self.breather.period();
        while self.closed.len() > 2 && self.closed[1].0 <= now.t - window {
            self.closed.pop_front();
        }
        if self.life.decoupled.is_none() && now.t >= window && self.contact() < CONTACT {
            self.life.decoupled = Some(now.t);
        }
    }

    /// Contact over the last ten periods, or since the start.
    fn contact(&self) -> f64 {
        match (self.closed.front(), self.closed.back()) {
            (Some(first), Some(last)) if last.0 > first.0 => (last.1 - first.1) / (last.0 - first.0),
            _ => self.last.closed,
        }
    }

    /// Whether waves from the ends may be back.
    fn ends_felt(&self) -> bool {
        self.life.ends_felt.is_some_and(|felt| self.last.t > felt)
    }

    fn life(self) -> Life {
        let fate = match (self.life.lifetime, self.life.decoupled) {
            (Some(energy), decoupled) if decoupled.is_none_or(|decoupled| energy <= decoupled) => Fate::Radiates,
            (_, Some(_)) => Fate::Decouples,
            _ => Fate::Persists,
        };
        Life { end: self.last.t, fate, core_share: self.last.core, contact: self.contact(), ..self.life }
    }
}

/// The power law of the breathers that radiate, where `x` is large.
fn power_law(points: &[LifetimePoint]) -> Option<PowerLaw> {
    let logarithms = |point: &LifetimePoint| {
        let life = point.life.as_ref().ok().filter(|life| life.fate == Fate::Radiates && point.x >= FITTED_FROM)?;
        let lifetime = life.lifetime?;
        Some([point.rho, point.epsilon, lifetime, point.x, lifetime / point.horizon].map(f64::ln))
    };
    let all: Vec<[f64; 5]> = points.iter().filter_map(logarithms).collect();
    let plane: Vec<[f64; 3]> = all.iter().map(|&[rho, epsilon, lifetime, ..]| [rho, epsilon, lifetime]).collect();
    let line: Vec<(f64, f64)> = all.iter().map(|&[.., x, scaled]| (x, scaled)).collect();
    let ([constant, rho_power, epsilon_power], residual) = fit_plane(&plane)?;
    let (x_power, x_residual) = fit_line(&line)?;
    Some(PowerLaw {
        points: all.len(),
        factor: constant.exp(),
        rho_power,
        epsilon_power,
        largest_ratio: residual.exp(),
        x_power,
        x_largest_ratio: x_residual.exp(),
    })
}
