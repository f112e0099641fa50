//! Travelling waves on the chain, compared with the modulation equations (Sec. 4).
//!
//! | symbol | meaning |
//! |---|---|
//! | `E_x, E_y` | relative errors of an ansatz against the chain (eq:relerr_tw) |
//! | `tilde E_x, tilde E_y` | the same differences between a perturbed wave and the unperturbed one, both run on the chain (eq:relerr_twPtd) |
//! | growth | largest `tilde E_x` of the last period over that of the first |
//! | rate | slope of the logarithm of the largest `tilde E_x` of each period against time, over the second half of the run |

mod report;

use crate::study::{Adaptive, Changes, Progress, Study, Work, fit_line, options::options, scene_json};
use crate::{
    chain::{Site, max_norm},
    dps::{Envelope, project},
    error::{Error, Result, require},
    report::{Report, rows},
    run::state_at,
    scene::{Scene, Theory},
    sweep::{Engine, Grid, map},
    waves::{PerturbedWave, TravellingWave},
};
use hertzchain_integrators::{Dop853, Stats, dop853::Options};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::{
    f64::consts::PI,
    time::{Duration, Instant},
};

const PERTURBED: &str = "a perturbed wave";
/// Most numbers that a run or an ensemble may hold: a gigabyte.
const MOST_NUMBERS: f64 = (1_u64 << 27) as f64;
/// Least and largest tolerance of the modulation equations. That of the run is clamped to this
/// range, so that their error is not the one that is seen.
const FLOW_TOLERANCES: (f64, f64) = (1e-13, 1e-8);

options! {
    /// A travelling wave, from a scene, perturbed or not.
    pub struct Wave {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// The scene must have an initial state of kind travelling-wave.
        scene: Option<String> = None, [required = true];
        /// Changes to it.
        set: Changes = Changes::default();
        /// Perturb each amplitude by up to this share [default: the scene's].
        ///
        /// The share bounds the changes of the real and of the imaginary part of each amplitude.
        /// From 0 (no perturbation) to below 1.
        zeta: Option<f64> = None, "Z";
        /// Seed of the random numbers [default: the scene's, else 1].
        ///
        /// They perturb the wave.
        seed: Option<u64> = None, "S";
        /// How it is run and looked at.
        options: WaveOptions = WaveOptions::default();
        /// End time, in units of time [default: the scene's].
        until: Option<f64> = None, "T", (end);
    }
}

options! {
    /// How a wave is run and looked at.
    ///
    /// Largest values are those of samples: with 50 a period, in the runs of the paper, they are at
    /// most 0.1 % below those with 400.
    pub struct WaveOptions {
        /// Number of perturbed waves, from that seed on [default: 1].
        ///
        /// They run on all cores and give the spread of the growth.
        seeds: Option<u32> = None, "K", (1 to 10_000);
        /// How it is run.
        solver: Adaptive = Adaptive::default();
        /// Samples per period, from which largest values are taken.
        ///
        /// Per period of the wave; the end of the run is one of them.
        samples_per_period: u32 = 50, "M", (2 to 1000);
    }
}

impl Wave {
    fn scene(&self) -> Result<Scene> {
        self.within_ranges()?;
        let mut scene = crate::study::scene(self.scene.as_deref().unwrap_or_default(), &self.set)?;
        if let Some(until) = self.until {
            scene = scene.until(until)?;
        }
        if self.zeta.is_none() && self.seed.is_none() {
            return Ok(scene);
        }
        let (zeta, seed) = match scene.theory() {
            Some(Theory::PerturbedWave(own)) => (own.zeta(), Some(own.seed())),
            _ => (0.0, None),
        };
        match (self.zeta, self.seed) {
            (Some(0.0), Some(seed)) => {
                Err(Error::parameter("seed", seed, "a seed needs a perturbation: give zeta above 0"))
            }
            (Some(0.0), None) => scene.perturbed(0.0, None),
            (zeta_given, seed_given) => scene.perturbed(zeta_given.unwrap_or(zeta), seed_given.or(seed)),
        }
    }
}

impl Study for Wave {
    const FILES: &'static str = "envelope.csv, ensemble.csv, spread.csv and growth.csv are those of perturbed waves. The points of \
                                 the store are the seeds of --seeds.";
    const STORE: &'static str = "ensemble.store";

    fn optional_files() -> Vec<String> {
        ["envelope.csv", "ensemble.csv", "spread.csv", "growth.csv"].map(str::to_owned).into()
    }

    fn outline() -> Option<Report> {
        Some(report::outline())
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = self.scene()?;
        Ok(Box::new(move |engine, progress| Ok(wave(&scene, &self.options, engine, progress)?.report())))
    }
}

/// Numbers of beads and of resonators: strains by site, or errors at the sample times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct XAndY {
    /// Of beads: strains, or `E_x` or `tilde E_x`.
    pub x: Vec<f64>,
    /// Of resonators: strains, or `E_y` or `tilde E_y`.
    pub y: Vec<f64>,
}

impl FromIterator<(f64, f64)> for XAndY {
    fn from_iter<I: IntoIterator<Item = (f64, f64)>>(pairs: I) -> Self {
        let (x, y) = pairs.into_iter().unzip();
        Self { x, y }
    }
}

/// A perturbed wave.
#[derive(Clone, Debug)]
pub struct PerturbedRun {
    /// The wave and its draw.
    pub wave: PerturbedWave,
    /// Strains at the end, on the chain.
    pub strains: XAndY,
    /// Strains at the end, by (eq:xy_app).
    pub ansatz: XAndY,
    /// Chain against ansatz (eq:xy_app).
    pub errors: XAndY,
    /// Perturbed against unperturbed wave (eq:relerr_twPtd).
    pub difference: XAndY,
    /// Relative change of the energy of the modulation equations from the start to the end, which
    /// they conserve.
    pub flow_energy_change: f64,
    /// The envelopes of chain and ansatz a period `2 pi/omega` before the end, if the run has two:
    /// the first by [`project`].
    pub envelopes: Option<Envelopes>,
}

/// The envelope that a chain has and the one that the modulation equations give.
#[derive(Clone, Debug)]
pub struct Envelopes {
    /// Time.
    pub t: f64,
    /// Envelope of the chain.
    pub chain: Envelope,
    /// Envelope by the modulation equations.
    pub flow: Envelope,
}

rows! {
    /// The growth of the perturbation of one seed.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Member {
        /// The seed.
        seed: u64,
        /// Growth of `tilde E_x`; none for runs shorter than two periods.
        growth_x: Option<f64>,
        /// Growth of `tilde E_y`.
        growth_y: Option<f64>,
        /// Exponential rate of `tilde E_x`, per unit of time; none for runs shorter than eight
        /// periods.
        rate: Option<f64>,
        /// Largest distance of the logarithms from the line of that slope: well below the rise
        /// along the line where growth is exponential.
        rate_residual: Option<f64>,
    }
}

/// The spread of a quantity over the ensemble.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Smallest.
    pub low: f64,
    /// First quartile.
    pub lower: f64,
    /// Median.
    pub median: f64,
    /// Third quartile.
    pub upper: f64,
    /// Largest.
    pub high: f64,
}

/// An ensemble of perturbed waves.
#[derive(Clone, Debug)]
pub struct Ensemble {
    /// Members, in the order of their seeds.
    pub members: Vec<Member>,
    /// Number of seeds that were not run because the process was asked to end.
    pub missing: usize,
    /// `tilde E_x` at the sample times.
    pub difference_x: Vec<Spread>,
    /// `tilde E_y` at the sample times.
    pub difference_y: Vec<Spread>,
}

impl Ensemble {
    /// The spread of a number that every member has, or `None`.
    pub fn spread(&self, quantity: impl Fn(&Member) -> Option<f64>) -> Option<Spread> {
        let values: Option<Vec<f64>> = self.members.iter().map(quantity).collect();
        values.map(spread)
    }
}

/// The outcome.
#[derive(Clone, Debug)]
pub struct WaveStudy {
    /// The scene.
    pub scene: Scene,
    /// The wave.
    pub wave: TravellingWave,
    /// Method and setting, in words.
    pub setting: String,
    /// Sample times: from 0 to the end, equally spaced, both included.
    pub t: Vec<f64>,
    /// The unperturbed wave: chain against ansatz (eq:xytw_app).
    pub errors: XAndY,
    /// The unperturbed wave at the end, on the chain.
    pub strains: XAndY,
    /// The unperturbed wave at the end, by (eq:xytw_app).
    pub ansatz: XAndY,
    /// Work of the unperturbed run.
    pub stats: Stats,
    /// The perturbed wave of the scene, if it is perturbed.
    pub perturbed: Option<PerturbedRun>,
    /// The perturbed waves of all seeds (of one seed by default), if the wave is perturbed.
    pub ensemble: Option<Ensemble>,
    /// Wall time of the study.
    pub wall: Duration,
}

/// Runs the wave of a scene, its perturbed one if it has one, and an ensemble of those. `progress`
/// is told the share done. In a folder of the engine members of the ensemble are kept as they are
/// run, and those that are there are not run again.
///
/// Members of the ensemble run on all cores; every number is the same for any number of them.
///
/// # Errors
/// A scene that is no travelling wave, a method that takes no tolerance, an option outside its
/// rule, an ensemble without perturbation, a run that fails; a store of another ensemble, or one
/// that was altered.
pub fn wave(scene: &Scene, options: &WaveOptions, engine: &Engine, progress: Progress<'_>) -> Result<WaveStudy> {
    let clock = Instant::now();
    let wave = *scene.wave()?;
    let times = times(scene, options)?;
    let seeds = seeds(scene, options, times.len())?;

    let alone = [scene.perturbed(0.0, None)?, scene.clone()];
    let alone = if seeds.is_empty() { &alone[..1] } else { &alone };
    let tracks: Vec<Track> = map(alone, |scene| track(scene, options, &times)).into_iter().collect::<Result<_>>()?;
    let tell = |share: f64, words: &str| {
        let others = share * seeds.len().saturating_sub(1) as f64;
        progress((tracks.len() as f64 + others) / (1 + seeds.len()) as f64, words);
    };
    tell(0.0, "");
    let unperturbed = &tracks[0];
    let errors = times.iter().zip(&unperturbed.strains).map(|(&t, now)| wave.errors(t, &now.x, &now.y)).collect();

    let mut perturbed = None;
    let mut ensemble = None;
    if let Some(own) = tracks.get(1) {
        let difference = differences(&wave, own, unperturbed);
        // Of the other seeds only the differences from the unperturbed wave are kept.
        let others = Others { scene, options, times: &times, unperturbed };
        // This comes before the ensemble, which a signal may end with part of its members.
        perturbed = Some(perturbed_run(scene, options, &times, own, &difference)?);
        ensemble = Some(others.ensemble(&seeds, difference, engine, &tell)?);
    }
    Ok(WaveStudy {
        scene: scene.clone(),
        wave,
        setting: options.solver.words(),
        errors,
        strains: unperturbed.last(),
        ansatz: (0..scene.chain().sites()).map(|n| wave.site(n, scene.end())).map(strains_of).collect(),
        stats: unperturbed.stats,
        perturbed,
        ensemble,
        t: times,
        wall: clock.elapsed(),
    })
}

/// The settings of the store: all that differences depend on besides the seed.
fn settings(scene: &Scene, options: &WaveOptions) -> Value {
    let mut file = scene_json(scene);
    file["initial"]["seed"] = Value::Null;
    json!({
        "scene": file,
        "integrator": options.solver.method.name(),
        "tolerance": options.solver.tol,
        "samples_per_period": options.samples_per_period,
    })
}

/// The waves of an ensemble beside that of the scene.
struct Others<'a> {
    scene: &'a Scene,
    options: &'a WaveOptions,
    times: &'a [f64],
    unperturbed: &'a Track,
}

impl Others<'_> {
    /// The ensemble of all seeds, the first of which is that of the scene.
    fn ensemble(&self, seeds: &[u64], first: XAndY, engine: &Engine, progress: Progress<'_>) -> Result<Ensemble> {
        let grid = Grid { store: Wave::STORE, study: "wave", settings: settings(self.scene, self.options) };
        let swept = engine.sweep(&grid, &seeds[1..], progress, |&seed| self.difference(seed))?;
        let mut all = vec![(seeds[0], first)];
        for (&seed, row) in seeds[1..].iter().zip(swept.rows) {
            match row {
                Ok(difference) => all.push((seed, difference)),
                // Not run, or stopped on the way.
                Err(_) if swept.missing > 0 => {}
                Err(why) => return Err(Error::Point { point: format!("seed {seed}"), why }),
            }
        }
        let period = self.scene.period();
        Ok(Ensemble {
            members: all.iter().map(|(seed, errors)| member(*seed, self.times, period, errors)).collect(),
            missing: seeds.len() - all.len(),
            difference_x: spreads(all.iter().map(|(_, errors)| &errors.x[..])),
            difference_y: spreads(all.iter().map(|(_, errors)| &errors.y[..])),
        })
    }

    fn difference(&self, seed: u64) -> Result<XAndY> {
        let Some(Theory::PerturbedWave(first)) = self.scene.theory() else {
            return Err(Error::parameter("scene", self.scene.name(), PERTURBED));
        };
        let scene = self.scene.perturbed(first.zeta(), Some(seed))?;
        Ok(differences(first.wave(), &track(&scene, self.options, self.times)?, self.unperturbed))
    }
}

fn times(scene: &Scene, options: &WaveOptions) -> Result<Vec<f64>> {
    options.solver.check()?;
    options.within_ranges()?;
    // If the number is whole up to rounding, no sample is added.
    let wanted = scene.end() / scene.period() * f64::from(options.samples_per_period);
    let count = (wanted * (1.0 - 1e-12)).ceil().max(1.0);
    let rule = "at most 2^27 strains are kept: a shorter run, or fewer samples a period";
    require((count + 1.0) * 2.0 * scene.chain().sites() as f64 <= MOST_NUMBERS, "samples", count, rule)?;
    Ok((0..=count as u64).map(|k| scene.end() * (k as f64 / count)).collect())
}

/// The seeds of the ensemble; none for a wave that is not perturbed.
fn seeds(scene: &Scene, options: &WaveOptions, samples: usize) -> Result<Vec<u64>> {
    let count = options.seeds.unwrap_or(1);
    let rule = "at most 2^27 differences are kept: fewer seeds, a shorter run, or fewer samples a period";
    require(f64::from(count) * 2.0 * samples as f64 <= MOST_NUMBERS, "seeds", count, rule)?;
    match (scene.theory(), options.seeds) {
        (Some(Theory::PerturbedWave(perturbed)), _) => {
            let first = perturbed.seed();
            let Some(last) = first.checked_add(u64::from(count - 1)) else {
                return Err(Error::parameter("seed", first, "seed + seeds - 1 is below 2^64"));
            };
            Ok((first..=last).collect())
        }
        (_, Some(count)) => {
            Err(Error::parameter("seeds", count, "an ensemble needs a perturbation: give zeta above 0"))
        }
        _ => Ok(Vec::new()),
    }
}

/// The strains of a run at the sample times, and its work.
struct Track {
    strains: Vec<XAndY>,
    stats: Stats,
}

impl Track {
    fn last(&self) -> XAndY {
        self.strains.last().cloned().unwrap_or_default()
    }
}

fn track(scene: &Scene, options: &WaveOptions, times: &[f64]) -> Result<Track> {
    let mut states = options.solver.run(scene)?.at(times)?;
    let strains = states.by_ref().map(|state| Ok(strains(state?.as_slice()))).collect::<Result<_>>()?;
    Ok(Track { strains, stats: states.stats() })
}

fn strains(y: &[f64]) -> XAndY {
    let sites = y.len() / 4;
    XAndY { x: y[..sites].to_vec(), y: y[sites..2 * sites].to_vec() }
}

fn strains_of(site: Site<f64>) -> (f64, f64) {
    (site.u, site.v)
}

/// (eq:relerr_tw) between two sets of strains.
fn distance(wave: &TravellingWave, one: &XAndY, other: &XAndY) -> (f64, f64) {
    let largest = |one: &[f64], other: &[f64]| max_norm(one.iter().zip(other).map(|(a, b)| a - b)) / wave.amplitude();
    (largest(&one.x, &other.x), wave.params().rho * largest(&one.y, &other.y))
}

fn differences(wave: &TravellingWave, one: &Track, other: &Track) -> XAndY {
    one.strains.iter().zip(&other.strains).map(|(one, other)| distance(wave, one, other)).collect()
}

/// Compares the perturbed wave of the scene with its own ansatz, and computes the envelopes.
fn perturbed_run(
    scene: &Scene,
    options: &WaveOptions,
    times: &[f64],
    chain: &Track,
    difference: &XAndY,
) -> Result<PerturbedRun> {
    let Some(Theory::PerturbedWave(perturbed)) = scene.theory() else {
        return Err(Error::parameter("scene", scene.name(), PERTURBED));
    };
    let (wave, constraint) = (perturbed.wave(), perturbed.constraint());
    let (mut ansatz, params) = (perturbed.ansatz(constraint)?, wave.params());
    let tolerance = options.solver.tol.clamp(FLOW_TOLERANCES.0, FLOW_TOLERANCES.1);
    let flow_options = Options { atol: tolerance * wave.shape().a, ..Options::new(tolerance) };
    let flow = || -> Result<_> {
        let span = (0.0, wave.slow_time(scene.end()));
        Ok(Dop853::new(perturbed.flow(constraint)?, perturbed.amplitudes(), span, flow_options)?)
    };
    let mut run = flow()?;
    let mut by_ansatz = |t: f64| -> Result<XAndY> {
        let z = state_at(&mut run, wave.slow_time(t))?;
        Ok(ansatz.sites(t, &z).into_iter().map(strains_of).collect())
    };
    let all = times.iter().map(|&t| by_ansatz(t)).collect::<Result<Vec<_>>>()?;
    let errors = all.iter().zip(&chain.strains).map(|(ansatz, now)| distance(wave, ansatz, now)).collect();

    let mut dps = perturbed.flow(constraint)?;
    let last = state_at(&mut run, wave.slow_time(scene.end()))?;
    let flow_energy_change = dps.energy(&last) / dps.energy(perturbed.amplitudes()) - 1.0;

    let period = 2.0 * PI / params.omega();
    let t = scene.end() - period;
    let envelopes = if t < period {
        None
    } else {
        let mut again = options.solver.run(scene)?.stepper()?;
        let chain = project(params, wave.epsilon(), t, |t| Ok(state_at(&mut again, t)?))?;
        let amplitudes = state_at(&mut flow()?, wave.slow_time(t))?;
        let means = dps.mean_strains(&amplitudes).to_vec();
        Some(Envelopes { t, chain, flow: Envelope { amplitudes, means } })
    };
    Ok(PerturbedRun {
        wave: perturbed.clone(),
        strains: chain.last(),
        ansatz: all.into_iter().next_back().unwrap_or_else(|| chain.last()),
        errors,
        difference: difference.clone(),
        flow_energy_change,
        envelopes,
    })
}

/// The growth of a difference, from its largest values in the periods of the run.
pub fn member(seed: u64, t: &[f64], period: f64, difference: &XAndY) -> Member {
    let end = t[t.len() - 1];
    let growth = |errors: &[f64]| {
        let largest = |from: f64, to: f64| {
            max_norm(t.iter().zip(errors).filter(|(t, _)| (from..=to).contains(*t)).map(|(_, error)| *error))
        };
        (end >= 2.0 * period).then(|| largest(end - period, end) / largest(0.0, period))
    };
    let line = rate(t, period, &difference.x);
    Member {
        seed,
        growth_x: growth(&difference.x),
        growth_y: growth(&difference.y),
        rate: line.map(|line| line.0),
        rate_residual: line.map(|line| line.1),
    }
}

/// Slope of the logarithm of the largest value of each whole period of the second half, and how far
/// the logarithms are from the line.
fn rate(t: &[f64], period: f64, errors: &[f64]) -> Option<(f64, f64)> {
    let end = t[t.len() - 1];
    let count = (0.5 * end / period).floor() as usize;
    let mut largest = vec![0.0f64; count];
    for (&t, &error) in t.iter().zip(errors) {
        let back = ((end - t) / period) as usize;
        if let Some(largest) = largest.get_mut(back) {
            *largest = largest.max(error);
        }
    }
    let points: Vec<(f64, f64)> =
        largest.iter().enumerate().map(|(back, error)| (end - period * (back as f64 + 0.5), error.ln())).collect();
    fit_line(&points).filter(|_| count >= 4)
}

/// Order statistics, those between two values by linear interpolation.
pub fn spread(mut values: Vec<f64>) -> Spread {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let place = share * (values.len() - 1) as f64;
        let (below, above) = (values[place.floor() as usize], values[place.ceil() as usize]);
        below + (above - below) * place.fract()
    };
    Spread { low: at(0.0), lower: at(0.25), median: at(0.5), upper: at(0.75), high: at(1.0) }
}

/// The spread at each time of rows that have all times.
fn spreads<'a>(rows: impl Iterator<Item = &'a [f64]>) -> Vec<Spread> {
    let rows: Vec<&[f64]> = rows.collect();
    let times = rows.first().map_or(0, |row| row.len());
    (0..times).map(|k| spread(rows.iter().map(|row| row[k]).collect())).collect()
}
