//! The reference that errors are measured against: the exact solution, or two runs, contact
//! collocation at [`FINEST`] and a method of another family, whose difference is the error
//! estimate.

use super::{Candidate, ErrorNorm, REFERENCE_SHARE};
use crate::{
    breathers::TrivialBreather,
    chain::{State, max_norm},
    error::{Error, Failed, Result},
    interrupt::{self, Token},
    run::{
        Records,
        method::{Method, Setting},
    },
    scene::{Scene, Theory},
    sweep::map,
};
use hertzchain_integrators::Error as Failure;
use std::time::Duration;

/// The number of steps over the span that makes about this many kicks a period of the fastest
/// motion, of a method with so many kicks a step.
pub(crate) fn steps(scene: &Scene, stages: usize, kicks: f64) -> u64 {
    let steps = kicks * scene.end() / scene.fast_period() / stages as f64;
    (steps.round() as u64).max(1)
}

/// The method of references, and its tolerance.
const FINEST: (&str, f64) = ("collocation", 1e-14);
/// The method that checks references on chains of up to [`FEW_SITES`]. Its tolerance of a step is
/// below a rounding, so that only rounding errors remain.
const RESOLVED: (&str, f64) = ("dop853-regularised", 1e-16);
/// The work of a method that stops at every event grows with the square of the chain.
const FEW_SITES: usize = 100;
/// Methods with fixed steps for longer chains: the first that can run checks a reference. If
/// collocation cannot run, the first two that can are the reference and its check.
const STEPPED: [&str; 3] = ["corrected", "aba1064-linear", "srkn11-6-linear"];
/// Methods for chains whose contacts dissipate, which no method with fixed steps can run: the first
/// two that can run are the reference and its check.
const TOLERANT: [&str; 3] = ["collocation", "dop853-regularised", "dop853"];
/// Tolerances of these: the finest that fits the budget, or else the last one.
const TOLERANCES: [f64; 5] = [1e-14, 1e-12, 1e-10, 1e-8, 1e-6];
/// Kicks a period of the methods with fixed steps: of a trial, at least and at most.
const TRIAL_KICKS: f64 = 256.0;
const FEWEST_KICKS: f64 = 64.0;
const MOST_KICKS: f64 = 131_072.0;
/// Share of the span of a trial run, from which the cost of a reference is estimated.
const TRIAL_SHARE: f64 = 0.05;
/// Rows nearer to the reference than this many times its error estimate are marked.
pub(super) const TRUSTED: f64 = 3.0;
/// Largest error that the list of the fastest methods begins with.
pub(super) const COARSEST: f64 = 0.1;

/// Parts of the span at whose ends the largest values of a reference are looked for: a prime, so
/// that runs of many whole periods are seen at all phases.
const LOOKS: usize = 101;

/// The largest of each of the [`parts`], and the least and the largest strain.
type Looked = ([f64; 3], [f64; 2]);

/// The end of a run, as a reference.
#[derive(Clone, Debug, PartialEq)]
struct End {
    method: String,
    setting: String,
    state: Vec<f64>,
    /// The largest of each of the [`parts`] at the looks.
    largest: [f64; 3],
    /// The least and the largest strain at the looks.
    strains: [f64; 2],
    energy_error: Option<f64>,
}

/// Strains, velocities of beads and stretches of resonators of a state.
fn parts(scene: &Scene, y: &[f64]) -> [Vec<f64>; 3] {
    let chain = scene.chain();
    [chain.strains(y), chain.layout().u_dot(y).to_vec(), chain.stretches(y)]
}

/// Widens the largest values and the range of strains to those of a state.
fn look((largest, [least, most]): &mut Looked, scene: &Scene, y: &[f64]) {
    let now = parts(scene, y);
    (*least, *most) = now[0].iter().fold((*least, *most), |(least, most), x| (least.min(*x), most.max(*x)));
    let now = now.map(max_norm);
    *largest = std::array::from_fn(|k| largest[k].max(now[k]));
}

const UNSEEN: Looked = ([0.0; 3], [f64::INFINITY, f64::NEG_INFINITY]);

impl End {
    fn of(scene: &Scene, method: &Method, setting: Setting, words: String) -> Result<Self> {
        let mut looked = UNSEEN;
        let run = scene.run().method(*method).setting(setting).records(Records::Energy).samples(LOOKS)?;
        let ran = run.observe(&mut |_, y| look(&mut looked, scene, y), &mut |_| ())?.complete()?;
        let (state, energy_error) = (ran.state, ran.energy_error);
        let (largest, strains) = looked;
        Ok(Self { method: method.name(), setting: words, state, largest, strains, energy_error })
    }

    /// The exact solution.
    fn exact(scene: &Scene, breather: &TrivialBreather) -> Result<Self> {
        let at = |t: f64| Result::Ok(State::from_fn(scene.chain(), |n| breather.site(n, t))?.as_slice().to_vec());
        let mut looked = UNSEEN;
        for k in 0..=LOOKS {
            look(&mut looked, scene, &at(scene.end() * k as f64 / LOOKS as f64)?);
        }
        let (method, setting) = (String::new(), String::new());
        let (largest, strains) = looked;
        Ok(Self { method, setting, state: at(scene.end())?, largest, strains, energy_error: Some(0.0) })
    }

    /// The end of a run with this method and tolerance.
    fn by_tolerance(scene: &Scene, (method, tolerance): (&str, f64)) -> Result<Self> {
        Self::of(scene, &Method::named(method)?, Setting::Tolerance(tolerance), format!("tol {tolerance:e}"))
    }

    fn by_kicks(scene: &Scene, method: &Method, kicks: f64) -> Result<Self> {
        let steps = Setting::Steps(steps(scene, method.info().stages, kicks));
        Self::of(scene, method, steps, format!("{kicks} kicks a period"))
    }
}

/// The reference state at the end.
pub struct ReferenceState {
    /// Methods and settings, in words.
    pub method: String,
    /// The ends of the reference runs. An error is measured against the first of another method.
    ends: Vec<End>,
    pub(super) norm: ErrorNorm,
    pub(super) error_estimate: f64,
}

impl ReferenceState {
    /// The exact solution if there is one, or two runs by different methods.
    pub fn find(scene: &Scene, norm: ErrorNorm, budget: f64, tell: &(dyn Fn(&str) + Sync)) -> Result<Self> {
        if let Some(Theory::Breather(breather)) = scene.theory() {
            let ends = vec![End::exact(scene, breather)?];
            return Ok(Self::of(scene, norm, "exact solution (uncpl)".to_owned(), ends));
        }
        tell("reference");
        let ends = computed(scene, budget)?;
        let words = |end: &End| format!("{} at {}", end.method, end.setting);
        let method = format!("{}, checked by {}", words(&ends[0]), words(&ends[1]));
        Ok(Self::of(scene, norm, method, ends))
    }

    fn of(scene: &Scene, norm: ErrorNorm, method: String, ends: Vec<End>) -> Self {
        let mut found = Self { method, ends, norm, error_estimate: 0.0 };
        let gap = match norm {
            ErrorNorm::Energy => found.ends[0].energy_error,
            _ => found.ends.get(1).map(|other| found.distance(scene, &found.ends[0].state, &other.state)),
        };
        // No better than a few roundings of the values themselves.
        found.error_estimate = gap.unwrap_or(0.0).max(4.0 * f64::EPSILON);
        found
    }

    /// The largest of each of the [`parts`], by which errors are divided.
    pub(super) fn largest(&self) -> [f64; 3] {
        self.ends[0].largest
    }

    /// Whether some contact is open and some closed: forces are not smooth.
    pub(super) fn opens(&self) -> bool {
        let [least, most] = self.ends[0].strains;
        least < 0.0 && most >= 0.0
    }

    /// The largest difference of two states in the parts of the norm.
    fn distance(&self, scene: &Scene, a: &[f64], b: &[f64]) -> f64 {
        let (a, b) = (parts(scene, a), parts(scene, b));
        let unit = |k: usize| if self.largest()[k] > 0.0 { self.largest()[k] } else { 1.0 };
        self.norm.parts().map(|k| distance(&a[k], &b[k]) / unit(k)).fold(0.0, f64::max)
    }

    /// Refuses references that contradict each other: with them no row shows an error of
    /// [`COARSEST`].
    pub(super) fn good(&self) -> Result<()> {
        if TRUSTED * self.error_estimate <= COARSEST {
            return Ok(());
        }
        let (point, gap) = ("reference".to_owned(), self.error_estimate);
        let why = format!(
            "{} differ by {gap:.1e} in {}: no error can be measured; end the scene earlier",
            self.method.replace(", checked by ", " and "),
            self.norm.words()
        );
        Err(Error::Point { point, why })
    }

    /// The error of a state at the end.
    pub(super) fn error(&self, scene: &Scene, candidate: &Candidate, state: &[f64]) -> f64 {
        let name = candidate.name();
        let reference = self.ends.iter().find(|end| end.method != name).unwrap_or(&self.ends[0]);
        self.distance(scene, state, &reference.state)
    }
}

/// Two runs by methods of different families, as fine as the budget allows.
fn computed(scene: &Scene, budget: f64) -> Result<Vec<End>> {
    let fine: Vec<(&str, f64)> = [FINEST, RESOLVED]
        .into_iter()
        .filter(|run| run.0 == FINEST.0 || scene.chain().sites() <= FEW_SITES)
        .filter(|run| affordable(scene, *run, budget))
        .collect();
    // A run that fails is no reference; the others may do better.
    let ends = Token::timed(2.0 * budget).within(|| map(&fine, |run| End::by_tolerance(scene, *run)));
    let ends: Vec<End> = ends.into_iter().filter_map(Result::ok).collect();
    if ends.len() == 2 {
        return Ok(ends);
    }
    if scene.chain().dissipative_contacts() {
        return by_tolerances(scene, budget);
    }
    let stepped = by_steps(scene, 2 - ends.len(), budget)?;
    Ok(ends.into_iter().chain(stepped).collect())
}

/// Whether a run to a tolerance fits, by the time of a short trial.
fn affordable(scene: &Scene, (method, tolerance): (&str, f64), budget: f64) -> bool {
    let trial = || {
        // The run is shortened, not the scene: a scene would refuse to end before its drives have
        // their full amplitude.
        let run = scene.run().until(TRIAL_SHARE * scene.end())?.samples(0)?;
        run.method(Method::named(method)?).setting(Setting::Tolerance(tolerance)).records(Records::End).start()
    };
    Token::timed(TRIAL_SHARE * budget)
        .within(trial)
        .is_ok_and(|trial| trial.failure.is_none() && trial.wall.as_secs_f64() <= TRIAL_SHARE * budget)
}

/// Runs by the first two of [`TOLERANT`] that can, as fine as the budget allows.
fn by_tolerances(scene: &Scene, budget: f64) -> Result<Vec<End>> {
    let finest = |name: &'static str| {
        let fits = |tolerance: &f64| affordable(scene, (name, *tolerance), budget);
        let tolerance = TOLERANCES.into_iter().find(fits).unwrap_or(TOLERANCES[TOLERANCES.len() - 1]);
        End::by_tolerance(scene, (name, tolerance))
    };
    let (mut ends, mut why) = (Vec::new(), None);
    for name in TOLERANT {
        match Token::timed(2.0 * budget).within(|| finest(name)) {
            Ok(end) => ends.push(end),
            Err(error) => why = Some(error),
        }
        if ends.len() == 2 {
            return Ok(ends);
        }
    }
    Err(why.expect("of three methods two or more failed"))
}

/// `count` runs with fixed steps, by the first methods that can run, with as many kicks as fit the
/// budget.
fn by_steps(scene: &Scene, count: usize, budget: f64) -> Result<Vec<End>> {
    let mut methods = Vec::new();
    let mut wall = Duration::ZERO;
    let mut why = None;
    for name in STEPPED {
        let method = Method::named(name)?;
        let steps = Setting::Steps(steps(scene, method.info().stages, TRIAL_KICKS));
        let trial = || scene.run().method(method).setting(steps).records(Records::End).start();
        match Token::timed(budget).within(trial).and_then(crate::run::Trajectory::complete) {
            Ok(trial) => {
                wall += trial.wall;
                methods.push(method);
            }
            Err(Error::Run(Failed { cause: Failure::Stopped { .. }, .. })) if !interrupt::asked() => {
                let rule = "no run that could be a reference ends in its share of this time";
                return Err(Error::parameter("max-time", budget / REFERENCE_SHARE, rule));
            }
            Err(error) => why = Some(error),
        }
        if methods.len() == count {
            break;
        }
    }
    if let (true, Some(why)) = (methods.len() < count, why) {
        return Err(why);
    }
    let affordable = TRIAL_KICKS * budget / wall.as_secs_f64().max(1e-9);
    let kicks = affordable.log2().floor().exp2().clamp(FEWEST_KICKS, MOST_KICKS);
    map(&methods, |method| End::by_kicks(scene, method, kicks)).into_iter().collect()
}

/// The largest difference of two lists.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    max_norm(a.iter().zip(b).map(|(a, b)| a - b))
}
