//! Theorem 1 (th:dps) as an experiment: does the DpS equation describe the chain with heavy
//! resonators as well, and for as long, as it says?
//!
//! | symbol | meaning |
//! |---|---|
//! | `epsilon` | size of the oscillation; `tau = epsilon^{alpha-1} t` is the slow time, `T` the horizon: runs end at `t = T epsilon^{1-alpha}` |
//! | `A(tau)` | a solution of the DpS equation (eq:DpSlr) at `kappa = 1` |
//! | `C_i` | size of the departure of the initial state from the ansatz, (condciu) and (condciv) |
//! | `u, v, v'` | the three errors: `norm(u - 2 epsilon Re A e^{it}) + norm(u' + 2 epsilon Im A e^{it})` (estimu), `norm(v)`, `norm(v')` (estimv) |
//! | powers | what the theorem bounds their suprema with: `epsilon^alpha, epsilon^alpha, epsilon^{2 alpha-1}` |
//! | local slope | `d ln sup / d ln epsilon` between neighbouring sizes |
//!
//! The suprema over time are those of samples, see [`Sampling`]; the verdict is a rule on the local
//! slopes, see [`Bound`].

mod report;

pub(crate) mod slopes;
pub(crate) mod start;
pub(crate) mod suprema;

pub use slopes::{Bound, TheoremSlope};
pub use suprema::{Errors, Norm, Sampling};

use crate::study::{
    Progress, Study, Work,
    options::{one, options},
};
use crate::{
    error::{Error, Result, refuse, require},
    named::named,
    report::Report,
    sweep::{Engine, Grid},
};
use serde::{Deserialize, Serialize};
use serde_json::json;
use start::Start;
use std::time::{Duration, Instant};

/// Default seed of random numbers.
const SEED: u64 = 1;
/// Tolerance of the runs over `epsilon^{alpha-1}`.
const ACCURACY: f64 = 1e-6;

/// Longest run, `T epsilon^{1-alpha}`.
const LONGEST: f64 = 1e8;

/// How the mass ratio follows the size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RhoLaw {
    /// `rho = epsilon^{-2(alpha-1)}`: the least that the theorem allows.
    Heavy,
    /// `rho = epsilon^{-(alpha-1)}`: less than it allows.
    Light,
    /// The same at all sizes; infinite for Newton's cradle.
    Value(f64),
}

impl RhoLaw {
    /// Names of the two laws.
    pub const NAMES: [&'static str; 2] = ["eps^-2(alpha-1)", "eps^-(alpha-1)"];

    /// The law of this name, or the value that it is.
    ///
    /// # Errors
    /// A text that is neither.
    pub fn named(text: &str) -> Result<Self> {
        let rule = "the laws are eps^-2(alpha-1), eps^-(alpha-1), or a positive number (inf for Newton's cradle)";
        match text.parse::<f64>() {
            _ if text == Self::NAMES[0] => Ok(Self::Heavy),
            _ if text == Self::NAMES[1] => Ok(Self::Light),
            Ok(value) if value > 0.0 => Ok(Self::Value(value)),
            _ => Err(Error::parameter("rho-law", text, rule)),
        }
    }

    /// Its name.
    pub fn name(self) -> String {
        match self {
            Self::Heavy => Self::NAMES[0].to_owned(),
            Self::Light => Self::NAMES[1].to_owned(),
            Self::Value(rho) => rho.to_string(),
        }
    }

    /// `gamma` of `rho = epsilon^{-gamma}`; `None` for a constant.
    fn exponent(self, alpha: f64) -> Option<f64> {
        match self {
            Self::Heavy => Some(2.0 * (alpha - 1.0)),
            Self::Light => Some(alpha - 1.0),
            Self::Value(_) => None,
        }
    }

    /// `rho` at a size.
    pub fn rho(self, alpha: f64, epsilon: f64) -> f64 {
        match self {
            Self::Value(rho) => rho,
            law => epsilon.powf(-law.exponent(alpha).unwrap_or(0.0)),
        }
    }

    /// Whether `1/rho <= C_r epsilon^{2(alpha-1)}` with one `C_r` for all sizes, as the theorem
    /// asks.
    pub fn allowed(self) -> bool {
        matches!(self, Self::Heavy | Self::Value(f64::INFINITY))
    }
}

named! {
    /// What `A(0)` is.
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    pub enum Initial {
        /// The breather about a site, `a^1` of (dpsstat): `A(tau) = a e^{i omega_0 tau}`.
        Site = "site",
        /// The breather about a bond, `a^2`.
        Bond = "bond",
        /// `A_n(0) = (xi_n + i eta_n) e^{-n^2/4}`, with `xi_n, eta_n` random in (-1, 1).
        Generic = "generic",
    }
}
one!(Initial);
one!(RhoLaw: RhoLaw::named);

options! {
    /// Theorem 1 as a study.
    #[derive(PartialEq)]
    pub struct TheoremOptions {
        /// Exponent of the contact force; 1.5 for spheres.
        ///
        /// For breathers from 1.01.
        alpha: f64 = 1.5, "A", (above 1 to 10);
        /// T: runs end at t = T epsilon^(1-alpha), at most 1e8.
        ///
        /// The horizon of the theorem in units of the slow time.
        horizon: f64 = 1.0, "T", (above 0 to 1000);
        /// Law of the mass ratio, or a number for all epsilon.
        ///
        /// eps^-2(alpha-1), the smallest ratio that the theorem allows; eps^-(alpha-1), which is
        /// smaller; or one number for all epsilon, inf for Newton's cradle.
        rho_law: RhoLaw = RhoLaw::Heavy, "LAW", [default_value = "eps^-2(alpha-1)", allow_hyphen_values = true];
        /// Initial amplitudes A(0) of the DpS equation.
        ///
        /// A breather about a bond or a site, or (xi_n + i eta_n) e^(-n^2/4) with random xi_n,
        /// eta_n in (-1, 1).
        initial: Initial = Initial::Bond, "I";
        /// C_i: departure of the initial state from the ansatz.
        ///
        /// The departure has a random direction and lies on the boundary of the set (condciu),
        /// (condciv) in l_1, and so inside it in all norms. 0: the run starts exactly on the
        /// ansatz.
        c_i: f64 = 0.0, "C", (from 0);
        /// Seed of the random numbers [default: 1].
        ///
        /// They give a generic A(0) and the direction of the departure from the ansatz.
        seed: Option<u64> = None, "S";
        /// Sizes epsilon of the oscillation, separated by commas [default: decades from 0.1 to
        /// 1e-6].
        ///
        /// In any order.
        epsilons: Vec<f64> = vec![1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6], "E,F,..", (above 0 below 1), [hide_default_value = true];
        /// Number of sites [default: the sites where A(0) is above 1e-16 of its largest value; for
        /// generic: 21].
        ///
        /// At least the default, up to 1000.
        sites: Option<usize> = None, "N";
    } with {
        /// The times at which errors are sampled for the suprema.
        sampling: Sampling = Sampling::default();
        /// Tolerance of the runs, as a share of `epsilon^{alpha-1}`, the relative size of what is
        /// measured.
        accuracy: f64 = ACCURACY;
    }
}

impl TheoremOptions {
    /// The seed of a generic `A(0)` and of the departure.
    fn seed(&self) -> u64 {
        self.seed.unwrap_or(SEED)
    }

    /// Whether something is drawn at random.
    fn random(&self) -> bool {
        self.initial == Initial::Generic || self.c_i > 0.0
    }
}

impl Study for TheoremOptions {
    const FILES: &'static str = "theorem.txt has what is printed.";
    const STORE: &'static str = "theorem.store";

    fn outline() -> Option<Report> {
        Some(TheoremStudy::default().report())
    }

    fn begin(&self) -> Result<Work<'_>> {
        checked(self)?;
        Ok(Box::new(|engine, progress| Ok(theorem(self, engine, progress)?.report())))
    }
}

/// The run of one size.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TheoremRun {
    /// Size.
    #[serde(skip)]
    pub epsilon: f64,
    /// Mass ratio.
    #[serde(skip)]
    pub rho: f64,
    /// End time, `T epsilon^{1-alpha}`.
    #[serde(skip)]
    pub end: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of windows of the integrator.
    pub windows: u64,
    /// Suprema, in the order of [`Norm::ALL`].
    pub suprema: [Errors; 3],
    /// The share of each supremum that samples may miss: an eighth of the second differences at the
    /// largest sample, see [`Sampling`].
    pub sampling_errors: [Errors; 3],
}

impl TheoremRun {
    /// The largest share of a supremum in this norm that samples miss.
    pub fn sampling_error(&self, norm: Norm) -> f64 {
        self.sampling_errors[norm.index()].0.into_iter().fold(0.0, f64::max)
    }
}

/// The outcome.
#[derive(Clone, Debug, Default)]
pub struct TheoremStudy {
    /// The options, with the sizes that were run, from large to small.
    pub options: TheoremOptions,
    /// Sites of the chain.
    pub sites: usize,
    /// Runs, from large to small sizes.
    pub runs: Vec<TheoremRun>,
    /// The slopes of each error in each norm.
    pub slopes: Vec<TheoremSlope>,
    /// Number of runs that were read from the store.
    pub resumed: usize,
    /// Number of sizes that were not run, since the process was asked to end.
    pub missing: usize,
    /// Wall time.
    pub wall: Duration,
}

impl TheoremStudy {
    /// The powers of `epsilon` that bound the three errors: `alpha, alpha, 2 alpha - 1`.
    pub fn powers(&self) -> [f64; 3] {
        powers(self.options.alpha)
    }

    /// The suprema of a run over the powers of `epsilon` that bound them.
    pub fn scaled(&self, run: &TheoremRun, norm: Norm) -> Errors {
        let (powers, errors) = (self.powers(), run.suprema[norm.index()]);
        Errors(std::array::from_fn(|k| errors.0[k] / run.epsilon.powf(powers[k])))
    }

    /// The verdict over all norms of one error (`u, v, v'` are 0, 1, 2).
    pub fn bound(&self, quantity: usize) -> Bound {
        let of = self.slopes.iter().filter(|slope| slope.quantity == quantity).map(|slope| slope.bound);
        of.fold(Bound::Bounded, Bound::max)
    }

    /// The verdict over all norms and errors: violated if one is; otherwise undecided if one is;
    /// otherwise bounded.
    pub fn verdict(&self) -> Bound {
        (0..3).map(|quantity| self.bound(quantity)).fold(Bound::Bounded, Bound::max)
    }

    /// Whether the outcome contradicts the theorem: the law of `rho` is allowed, but an error is
    /// not bounded.
    pub fn contradicts(&self) -> bool {
        self.options.rho_law.allowed() && self.verdict() == Bound::Violated
    }
}

fn powers(alpha: f64) -> [f64; 3] {
    [alpha, alpha, 2.0 * alpha - 1.0]
}

/// Runs the chain at all sizes, on all cores, and holds it against the DpS equation. With a folder,
/// each size is kept there as soon as it was run, and is not run again. `progress` is told the
/// share that is done now.
///
/// If the process is asked to end, the outcome is that of the sizes that were run.
///
/// # Errors
/// An option outside its rule, a run that fails; a store of another study, or one that was altered.
pub fn theorem(options: &TheoremOptions, engine: &Engine, progress: Progress<'_>) -> Result<TheoremStudy> {
    let clock = Instant::now();
    let mut options = checked(options)?;
    let start = Start::new(&options)?;
    let end = |epsilon: f64| options.horizon * epsilon.powf(1.0 - options.alpha);
    let total: f64 = options.epsilons.iter().map(|&epsilon| end(epsilon)).sum();
    let shares = std::sync::Mutex::new(0.0);
    let tell = |dt: f64| {
        if let Ok(mut done) = shares.lock() {
            *done += dt / total;
            progress(*done, "");
        }
    };
    // The longest run first, so that no core waits for it at the end.
    let ascending: Vec<f64> = options.epsilons.iter().rev().copied().collect();
    let grid = Grid { store: TheoremOptions::STORE, study: "theorem", settings: settings(&options) };
    let swept = engine.sweep(&grid, &ascending, &|_, _| (), |&epsilon| start.run(&options, epsilon, &tell))?;
    let (resumed, missing) = (swept.resumed, swept.missing);
    let measured = swept.values(&ascending, |epsilon| format!("epsilon = {epsilon}"))?;
    // The store has no number that follows from the size.
    let run = |(&epsilon, run): (&f64, TheoremRun)| {
        let rho = options.rho_law.rho(options.alpha, epsilon);
        TheoremRun { epsilon, rho, end: end(epsilon), ..run }
    };
    let runs: Vec<TheoremRun> = measured.into_iter().rev().map(run).collect();
    options.epsilons = runs.iter().map(|run| run.epsilon).collect();
    let slopes = slopes::of_all(&options, &runs);
    Ok(TheoremStudy { sites: start.sites(), runs, slopes, resumed, missing, wall: clock.elapsed(), options })
}

/// The settings of the store: all that a run depends on besides its size.
fn settings(options: &TheoremOptions) -> serde_json::Value {
    let TheoremOptions { alpha, horizon, rho_law, initial, c_i, sites, sampling, accuracy, .. } = options;
    json!({
        "alpha": alpha,
        "horizon": horizon,
        "rho_law": rho_law.name(),
        "initial": initial.name(),
        "c_i": c_i,
        "seed": options.seed(),
        "sites": sites,
        "sampling": sampling,
        "accuracy": accuracy,
    })
}

/// The options with their sizes in order.
fn checked(options: &TheoremOptions) -> Result<TheoremOptions> {
    let &TheoremOptions { alpha, horizon, .. } = options;
    options.within_ranges()?;
    let rule = "a seed needs something random: --initial generic, or --c-i above 0";
    refuse("seed", options.seed.filter(|_| !options.random()), rule)?;
    if let RhoLaw::Value(rho) = options.rho_law {
        require(rho > 0.0, "rho-law", rho, "a mass ratio is positive, or inf")?;
    }
    let mut epsilons = options.epsilons.clone();
    epsilons.sort_by(|a, b| b.total_cmp(a));
    let longest = epsilons.iter().map(|epsilon| horizon * epsilon.powf(1.0 - alpha)).fold(0.0, f64::max);
    let rule = "runs are at most 1e8 long: a larger epsilon, or a shorter horizon";
    require(longest <= LONGEST, "T epsilon^(1-alpha)", longest, rule)?;
    options.sampling.checked()?;
    Ok(TheoremOptions { epsilons, ..options.clone() })
}
