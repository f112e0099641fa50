//! The long-lived bright breather on the chain (Sec. 5) compared with its ansatz, and its decay.
//!
//! | symbol | meaning |
//! |---|---|
//! | `E_u, E_u', E_v, E_v'` | rescaled distances from the ansatz (diff_u_l1norm), (diff_v_l1norm) |
//! | `T_b, T` | period of the breather; `2 pi/omega_0` |
//! | participation | `(sum e_n)^2 / sum e_n^2` of the site energies, half of a contact's at either bead |
//! | share | energy of the core, the sites that hold the breather at first, over the energy of the chain |
//! | `Fbar_n` | mean contact force over a period (Theorem nobreath) |

mod report;

use crate::study::{Adaptive, Progress, Study, Work, options::options};

use crate::{
    breathers::{BrightBreather, Norms},
    chain::{Boundary, Chain, Layout, MeanForces, Params, max_norm},
    dps::Center,
    error::{Error, Result, require},
    numerics::extremes,
    report::Report,
    run::state_at,
    scene::{ChainSection, Initial, Record, Scene, SceneFile, Span, Theory},
};
use hertzchain_integrators::{Stats, collocation::StepControl};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Default end of a run of a bright breather in units of `T`, as in the paper.
const SLOW_PERIODS: f64 = 80.0;
/// Largest number of samples of a run, and of periods of a history.
const MOST_SAMPLES: f64 = 1e7;
/// The paper shows a profile after this many periods.
const SHOWN_PERIOD: f64 = 30.0;
/// Part of its initial share of the energy that the core has lost at the time `tenth_left`.
const GONE: f64 = 0.1;
/// Number of times in each period at which a history looks at the state.
const PARTS: u32 = 32;

options! {
    /// The long-lived bright breather on the chain.
    pub struct Bright {
        /// What the profile is symmetric about.
        ///
        /// A site (solution a^1), or a bond (solution a^2), as in the paper's run.
        center: Center = Center::Bond, "C";
        /// Size of the breather: beads start at 2 epsilon a_n.
        epsilon: f64 = 0.01, "E", (end);
        /// Mass ratio resonator to bead.
        ///
        /// Above 0; inf for resonators that stay at rest.
        rho: f64 = 1000.0, "R";
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (1.01 to 10);
        /// Spring constant of the resonators.
        kappa: f64 = 1.0, "K", (positive);
        /// Number of sites.
        ///
        /// At most a share of 10^-6 of the breather may lie beyond the ends. The middle of the
        /// chain is a bond if the number is even, a site if it is odd.
        sites: usize = 40, "N";
        /// Boundary condition at the ends of the chain.
        boundary: Boundary = Boundary::Free, "B";
        /// End time, in units of time [default: 80 T].
        ///
        /// T = 2 pi/omega_0 in units of 1/sqrt(kappa) is the period of the envelope in slow time.
        /// The run has at most 10^7 samples.
        until: Option<f64> = None, "T";
        /// Samples per period, from which largest values are taken.
        ///
        /// Per period T_b of the breather. The time at which energy has left the core is also found
        /// from them.
        samples_per_period: u32 = 20, "M", (1 to 1000);
        /// How it is run.
        solver: Adaptive = Adaptive::default();
    }
}

impl Bright {
    /// The scene of these numbers.
    fn scene(&self) -> Result<Scene> {
        self.within_ranges()?;
        let &Self { center, boundary, epsilon, rho, alpha, kappa, sites, .. } = self;
        let until = match self.until {
            Some(until) => until,
            None => {
                let params = Params { alpha, kappa, rho };
                SLOW_PERIODS * BrightBreather::new(params, center, epsilon, sites)?.slow_period()
            }
        };
        Scene::build(SceneFile {
            name: "bright-breather".to_owned(),
            summary: "a long-lived bright breather, from a homoclinic solution of the stationary DpS equation"
                .to_owned(),
            chain: ChainSection { sites, alpha, kappa, rho, boundary, precompression: 0.0, gravity: None, tilt: None },
            beads: None,
            bonds: None,
            drives: Vec::new(),
            units: None,
            initial: Initial::BrightBreather { center, epsilon },
            span: Span { periods: None, until: Some(until), period: None },
            method: None,
            record: Record::of(0),
        })
    }
}

impl Study for Bright {
    fn outline() -> Option<Report> {
        Some(report::tables(&[], &[], &[], &[]).into_iter().fold(Report::new("breather"), Report::table))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = self.scene()?;
        Ok(Box::new(move |_, progress| {
            Ok(bright_breather(&scene, &self.solver, self.samples_per_period, progress)?.report())
        }))
    }
}

/// A bright breather at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrightSample {
    /// Time.
    pub t: f64,
    /// Rescaled distances from the ansatz.
    pub norms: Norms,
    /// Participation number.
    pub participation: f64,
    /// Share of the energy in the core.
    pub share: f64,
    /// Energy.
    pub energy: f64,
}

/// A step from one end of the chain to the other in the positions of beads and resonators.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Kink {
    /// `max u_n - min u_n`.
    pub height_u: f64,
    /// `max v_n - min v_n`.
    pub height_v: f64,
    /// Difference of `v` across the centre, right less left: of the two sites in the middle, or of
    /// the neighbours of the middle site.
    pub jump_v: f64,
    /// `u` of the last bead less that of the first: zero until waves from the breather reach the
    /// ends.
    pub between_ends_u: f64,
    /// `v` of the last bead less that of the first.
    pub between_ends_v: f64,
}

/// The whole state at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Time.
    pub t: f64,
    /// State.
    pub state: Vec<f64>,
}

/// The outcome for a bright breather.
#[derive(Clone, Debug)]
pub struct BrightStudy {
    /// The scene.
    pub scene: Scene,
    /// The breather.
    pub breather: BrightBreather,
    /// Method and setting, in words.
    pub setting: String,
    /// From 0 to the end: equally spaced in each period `T_b`, and the horizon and the end as well.
    pub samples: Vec<BrightSample>,
    /// States at 0, at 30 `T_b` if the run goes there, and at the end.
    pub profiles: Vec<Shown>,
    /// The kink at the end of the run.
    pub kink: Kink,
    /// Time at which the share of the core first falls to 0.9 of its initial value, interpolated
    /// between samples; `None` if it does not.
    pub tenth_left: Option<f64>,
    /// Largest relative change of the energy.
    pub energy_error: f64,
    /// `Fbar_n` over the first `T_b`.
    pub first_forces: MeanForces,
    /// `Fbar_n` over one period `T_b` that begins at the end of the run.
    pub last_forces: MeanForces,
    /// Work of the run, samples included.
    pub stats: Stats,
    /// Wall time of the study.
    pub wall: Duration,
}

impl BrightStudy {
    /// The sample at time `t`, if `t` is a sample time, such as a multiple of `T_b`, the horizon or
    /// the end.
    pub fn at(&self, t: f64) -> Option<&BrightSample> {
        self.samples.binary_search_by(|sample| sample.t.total_cmp(&t)).ok().map(|k| &self.samples[k])
    }

    /// The samples at multiples of `T_b`.
    pub fn periods(&self) -> impl Iterator<Item = &BrightSample> {
        let period = self.breather.period();
        (0_u32..).map_while(move |k| self.at(period * f64::from(k)))
    }

    /// The largest norms of all samples in `[from, to]`.
    pub fn largest(&self, from: f64, to: f64) -> Norms {
        let within = self.samples.iter().filter(|sample| (from..=to).contains(&sample.t));
        within.fold(Norms::default(), |largest, sample| largest.max(&sample.norms))
    }

    /// 30 `T_b`.
    pub fn shown_time(&self) -> f64 {
        SHOWN_PERIOD * self.breather.period()
    }
}

/// Runs the bright breather of a scene. `progress` is told the share of the run that is done.
///
/// `samples_per_period`, from 1 to 1000, are for largest values and the time at which energy has
/// left: with 20, in the run of the paper, largest norms are at most 0.6 % below those with 400,
/// and the time is the same to four digits.
///
/// # Errors
/// A scene of another kind, a method that takes no tolerance, an option outside its rule, a run
/// that fails.
pub fn bright_breather(
    scene: &Scene,
    options: &Adaptive,
    samples_per_period: u32,
    progress: Progress<'_>,
) -> Result<BrightStudy> {
    let clock = Instant::now();
    let breather = bright_of(scene)?;
    options.check()?;
    let times = bright_times(breather, scene.end(), samples_per_period)?;
    let shown_times = [0.0, SHOWN_PERIOD * breather.period(), scene.end()];
    let chain = scene.chain();
    let mut states = options.run(scene)?.at(&times)?;
    let (mut samples, mut profiles) = (Vec::with_capacity(times.len()), Vec::new());
    for (t, state) in times.into_iter().zip(states.by_ref()) {
        let y = state?.as_slice().to_vec();
        samples.push(bright_sample(breather, chain, t, &y));
        if shown_times.contains(&t) {
            profiles.push(Shown { t, state: y });
        }
        progress(t / scene.end(), "");
    }
    let stats = states.stats();
    let last = &profiles[profiles.len() - 1].state;
    let initial = samples[0].energy;
    let control = StepControl::Tolerance(options.tol);
    let forces = |y: &[f64]| chain.mean_contact_forces(y, breather.period(), control);
    Ok(BrightStudy {
        scene: scene.clone(),
        breather: breather.clone(),
        setting: options.words(),
        kink: kink(breather, chain.layout(), last),
        tenth_left: falls_to(&samples, 1.0 - GONE),
        energy_error: max_norm(samples.iter().map(|sample| sample.energy / initial - 1.0)),
        first_forces: forces(scene.initial().as_slice())?,
        last_forces: forces(last)?,
        samples,
        profiles,
        stats,
        wall: clock.elapsed(),
    })
}

/// A bright breather over space and time: a row of sites for each period `T_b`.
#[derive(Clone, Debug)]
pub struct BrightHistory {
    /// The scene.
    pub scene: Scene,
    /// The breather.
    pub breather: BrightBreather,
    /// Method and setting, in words.
    pub setting: String,
    /// Middle of each period.
    pub t: Vec<f64>,
    /// Half of `max u_n - min u_n` in the period, at 32 times: up to half a percent too small for a
    /// sine.
    pub swing: Vec<f64>,
    /// Mean of `v_n` over the period.
    pub v: Vec<f64>,
}

/// Looks at every site of the bright breather of a scene, period by period. `progress` is told the
/// share of the run that is done.
///
/// # Errors
/// A scene of another kind or shorter than a period, a method that takes no tolerance, a run that
/// fails.
pub fn bright_history(scene: &Scene, options: &Adaptive, progress: Progress<'_>) -> Result<BrightHistory> {
    let breather = bright_of(scene)?;
    options.check()?;
    let (period, layout, sites) = (breather.period(), scene.chain().layout(), scene.chain().sites());
    let periods = (scene.end() / period).floor();
    require((1.0..=MOST_SAMPLES).contains(&periods), "until", scene.end(), "from one to 10^7 periods of the breather")?;
    let mut run = options.run(scene)?.stepper()?;
    let (mut t, mut swing, mut mean) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..periods as u64 {
        let (mut low, mut high) = (vec![f64::INFINITY; sites], vec![f64::NEG_INFINITY; sites]);
        let mut sum = vec![0.0; sites];
        for part in 0..PARTS {
            let y = state_at(&mut run, period * (k as f64 + f64::from(part) / f64::from(PARTS)))?;
            let v = layout.v(&y);
            for (n, &u) in layout.u(&y).iter().enumerate() {
                (low[n], high[n]) = (low[n].min(u), high[n].max(u));
                sum[n] += v.map_or(0.0, |v| v[n]);
            }
        }
        t.push(period * (k as f64 + 0.5));
        swing.extend(low.iter().zip(&high).map(|(low, high)| 0.5 * (high - low)));
        mean.extend(sum.iter().map(|sum| sum / f64::from(PARTS)));
        progress((k + 1) as f64 / periods, "");
    }
    Ok(BrightHistory { scene: scene.clone(), breather: breather.clone(), setting: options.words(), t, swing, v: mean })
}

fn bright_of(scene: &Scene) -> Result<&BrightBreather> {
    let rule = "a scene whose initial state is of kind bright-breather";
    match scene.theory() {
        Some(Theory::Bright(breather)) => Ok(breather),
        _ => Err(Error::parameter("scene", scene.name(), rule)),
    }
}

/// Sample times: equal parts of periods, the horizon if the run goes there, and the end.
fn bright_times(breather: &BrightBreather, end: f64, per_period: u32) -> Result<Vec<f64>> {
    Bright { samples_per_period: per_period, ..Bright::default() }.within_ranges()?;
    let (period, parts) = (breather.period(), f64::from(per_period));
    let count = (end / period * parts).floor();
    require(count <= MOST_SAMPLES, "samples", count, "at most 10^7: a shorter run, or fewer samples a period")?;
    let mut times: Vec<f64> = (0..=count as u64).map(|k| period * (k as f64 / parts)).collect();
    times.extend([breather.horizon(), end]);
    times.retain(|t| *t <= end);
    times.sort_by(f64::total_cmp);
    times.dedup();
    Ok(times)
}

fn bright_sample(breather: &BrightBreather, chain: &Chain<f64>, t: f64, y: &[f64]) -> BrightSample {
    BrightSample {
        t,
        norms: breather.norms(t, chain.layout(), y),
        participation: chain.participation(y),
        share: breather.core_share(chain, y),
        energy: chain.energy(y).total(),
    }
}

/// Time at which the share of the core first falls to `part` of its first value.
pub fn falls_to(samples: &[BrightSample], part: f64) -> Option<f64> {
    let bound = part * samples[0].share;
    let two = samples.windows(2).find(|two| two[1].share <= bound)?;
    let (before, after) = (two[0], two[1]);
    Some(before.t + (after.t - before.t) * (before.share - bound) / (before.share - after.share))
}

fn kink(breather: &BrightBreather, layout: Layout, y: &[f64]) -> Kink {
    let height = |x: &[f64]| {
        let (low, high) = extremes(x.iter().copied());
        high - low
    };
    let (u, v) = (layout.u(y), layout.v(y));
    let last = u.len() - 1;
    let core = breather.core();
    let middle = (core.start + core.end - 1) / 2;
    let before = if core.len().is_multiple_of(2) { middle } else { middle.saturating_sub(1) };
    Kink {
        height_u: height(u),
        height_v: v.map_or(0.0, height),
        jump_v: v.map_or(0.0, |v| v[(middle + 1).min(last)] - v[before]),
        between_ends_u: u[last] - u[0],
        between_ends_v: v.map_or(0.0, |v| v[last] - v[0]),
    }
}
