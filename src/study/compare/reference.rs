//! The reference that errors are measured against: the exact solution, a stored reference, or two
//! runs.
//!
//! Built-in scenes come with a stored reference (`stored/`), which is used while chain, initial
//! state and span of the scene are those it was made for. Any other scene computes its own in the
//! same way: contact collocation at [`FINEST`], and a run by a method of another family, whose
//! difference is the error estimate.

use super::{Candidate, REFERENCE_SHARE};
use crate::{
    chain::{State, max_norm},
    error::{Error, Failed, Result},
    interrupt::{self, Token},
    run::{
        Records,
        method::{Method, Setting},
    },
    scene::{Scene, Theory},
    study::{compare::steps_for_kicks, scene_json},
    sweep::map,
};
use hertzchain_integrators::Error as Failure;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::time::Duration;

/// The method of references, and its tolerance.
pub const FINEST: (&str, f64) = ("collocation", 1e-14);
/// The method that checks references on chains of up to [`FEW_SITES`]. Its tolerance of a step is
/// below a rounding, so that only rounding errors remain.
pub const RESOLVED: (&str, f64) = ("dop853-regularised", 1e-16);
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

/// The stored references, by name of scene.
pub const STORED: [(&str, &str); 14] = [
    ("tw-q15", include_str!("stored/tw-q15.json")),
    ("tw-q45", include_str!("stored/tw-q45.json")),
    ("tw-breakdown-q15", include_str!("stored/tw-breakdown-q15.json")),
    ("tw-breakdown-q45", include_str!("stored/tw-breakdown-q45.json")),
    ("tw-rho3", include_str!("stored/tw-rho3.json")),
    ("tw-rho10", include_str!("stored/tw-rho10.json")),
    ("tw-rho1000", include_str!("stored/tw-rho1000.json")),
    ("impact", include_str!("stored/impact.json")),
    ("cradle", include_str!("stored/cradle.json")),
    ("precompressed", include_str!("stored/precompressed.json")),
    ("bright-envelope", include_str!("stored/bright-envelope.json")),
    ("bright-breather", include_str!("stored/bright-breather.json")),
    ("bright-breather-site", include_str!("stored/bright-breather-site.json")),
    ("bright-breather-16", include_str!("stored/bright-breather-16.json")),
];
/// Two initial states are the same if they differ by less than this share of their size: libraries
/// of two systems round sines differently.
const SAME_START: f64 = 1e-13;

/// The end of a run, as a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// Name of the method.
    pub method: String,
    /// Its setting, in words.
    pub setting: String,
    /// The strains.
    pub strains: Vec<f64>,
}

impl End {
    fn of(scene: &Scene, method: &Method, setting: Setting, words: String) -> Result<Self> {
        let outcome = scene.run().method(*method).setting(setting).records(Records::End).start()?.complete()?;
        Ok(Self { method: method.name(), setting: words, strains: scene.strains(&outcome.state) })
    }

    /// The end of a run with this method and tolerance.
    pub fn by_tolerance(scene: &Scene, (method, tolerance): (&str, f64)) -> Result<Self> {
        Self::of(scene, &Method::named(method)?, Setting::Tolerance(tolerance), format!("tol {tolerance:e}"))
    }

    fn by_kicks(scene: &Scene, method: &Method, kicks: f64) -> Result<Self> {
        let steps = Setting::Steps(steps_for_kicks(scene, method, kicks));
        Self::of(scene, method, steps, format!("{kicks} kicks/period"))
    }
}

/// A reference that is kept.
#[derive(Debug, Serialize, Deserialize)]
pub struct Stored {
    /// How it was made.
    pub provenance: String,
    /// Chain, initial state and span of the scene.
    pub scene: Value,
    /// The initial state itself, as one number.
    pub start: f64,
    /// The two runs.
    pub ends: Vec<End>,
}

impl Stored {
    /// The stored reference, if it was made for this chain, initial state and span.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (_, text) = STORED.iter().find(|(name, _)| *name == scene.name())?;
        let stored: Self = serde_json::from_str(text).ok()?;
        let (start, size) = start(scene);
        (stored.scene == what(scene) && (stored.start - start).abs() <= SAME_START * size).then_some(stored)
    }
}

/// The parts of a scene that determine its motion.
pub fn what(scene: &Scene) -> Value {
    let scene = scene_json(scene);
    json!({"chain": scene["chain"], "initial": scene["initial"], "span": scene["span"]})
}

/// The initial state as one number, which changes with every entry, and the size of its terms.
pub fn start(scene: &Scene) -> (f64, f64) {
    let terms = scene.initial().as_slice().iter().enumerate().map(|(i, y)| y * (1.0 + 0.618 * i as f64).cos());
    let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
    (sum, size)
}

/// The reference strains at the end.
pub struct ReferenceState {
    /// Methods and settings, in words.
    pub method: String,
    /// The ends of the reference runs. An error is measured against the first of another method.
    pub ends: Vec<End>,
    /// What errors are divided by.
    pub amplitude: f64,
    /// Difference of the two ends, or a few roundings.
    pub error_estimate: f64,
}

impl ReferenceState {
    /// The exact solution if there is one, or what is stored, or two runs by different methods.
    pub fn find(scene: &Scene, budget: f64, tell: &(dyn Fn(&str) + Sync)) -> Result<Self> {
        if let Some(Theory::Breather(breather)) = scene.theory() {
            let exact = State::from_fn(scene.chain(), |n| breather.site(n, scene.end()))?;
            let (method, setting) = (String::new(), String::new());
            let ends = vec![End { method, setting, strains: scene.strains(exact.as_slice()) }];
            return Ok(Self::of(scene, "exact solution (uncpl)".to_owned(), ends));
        }
        let (ends, from) = match Stored::of(scene) {
            Some(stored) => (stored.ends, "stored: "),
            None => {
                tell("reference");
                (computed(scene, budget)?, "")
            }
        };
        let words = |end: &End| format!("{} at {}", end.method, end.setting);
        let method = format!("{from}{}, checked by {}", words(&ends[0]), words(&ends[1]));
        Ok(Self::of(scene, method, ends))
    }

    fn of(scene: &Scene, method: String, ends: Vec<End>) -> Self {
        let largest = max_norm(ends[0].strains.iter().copied());
        let amplitude = scene.amplitude().unwrap_or(largest);
        let amplitude = if amplitude > 0.0 { amplitude } else { 1.0 };
        // No better than a few roundings of the strains themselves.
        let roundoff = 4.0 * f64::EPSILON * largest / amplitude;
        let gap = ends.get(1).map_or(0.0, |other| distance(&ends[0].strains, &other.strains) / amplitude);
        Self { method, ends, amplitude, error_estimate: gap.max(roundoff) }
    }

    /// Refuses references that contradict each other: with them no row shows an error of
    /// [`COARSEST`].
    pub(super) fn good(&self) -> Result<()> {
        if TRUSTED * self.error_estimate <= COARSEST {
            return Ok(());
        }
        let (point, gap) = ("reference".to_owned(), self.error_estimate);
        let why = format!(
            "{} differ by {gap:.1e} of the amplitude: no error can be measured; end the scene earlier",
            self.method.replace(", checked by ", " and ")
        );
        Err(Error::Point { point, why })
    }

    /// The error of a state at the end.
    pub(super) fn error(&self, scene: &Scene, candidate: &Candidate, state: &[f64]) -> f64 {
        let name = candidate.name();
        let reference = self.ends.iter().find(|end| end.method != name).unwrap_or(&self.ends[0]);
        distance(&scene.strains(state), &reference.strains) / self.amplitude
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
        let steps = Setting::Steps(steps_for_kicks(scene, &method, TRIAL_KICKS));
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
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    max_norm(a.iter().zip(b).map(|(a, b)| a - b))
}
