//! Flags of studies.

use super::SetArgs;
use crate::{
    dps::Center,
    experiments::{Bound, Criterion, Initial},
};
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct StudyArgs {
    #[command(subcommand)]
    pub(crate) action: StudyAction,
}

#[derive(Subcommand)]
pub(crate) enum StudyAction {
    /// Measure the order of every method through contacts.
    ///
    /// Methods that cross contacts, land on them, correct for them, and that are regularised: errors of the state and of its
    /// derivative by the initial state, and their slopes beside theory.
    #[command(after_long_help = "Example:\n  hertzchain study order --alpha 2 --out out/order")]
    Order(OrderArgs),
    /// Measure run time per bond and period against the number of sites.
    #[command(after_long_help = "Example:\n  hertzchain study scaling --sites 50,500 --out out/scaling")]
    Scaling(ScalingArgs),
    /// Measure how the energy error grows with time.
    #[command(after_long_help = "Example:\n  hertzchain study drift --periods 1e5 --out out/drift")]
    Drift(DriftArgs),
    /// Chart the stability of the integrators over extreme chains.
    ///
    /// Over light resonators and resonances, contact stiffness, exponent, length and run length. Every point is a method on
    /// a variant of the chain: stable, drifting or lost, its energy error, the largest step that keeps it below 1e-3 and
    /// 1e-6, and what that costs. With --out points are kept as they are computed: a run that was killed goes on where it
    /// was.
    #[command(after_long_help = "\
Example:
  hertzchain study stability --charts light,resonances --quick \\
      --integrators verlet,strang-linear,collocation --out out/stability")]
    Stability(StabilityChartsArgs),
    /// Theorem 1 as an experiment that could fail.
    ///
    /// Does the DpS equation describe the chain with heavy resonators as well, and for as long, as it says? Runs the chain
    /// with kappa = 1 and free ends at each epsilon, takes the suprema over 0 <= t <= T epsilon^(1-alpha) of the four errors
    /// (estimu), (estimv) in l_1, l_2 and l_inf over samples, divides them by epsilon^alpha (u with u', v) and
    /// epsilon^(2 alpha-1) (v'), and gives the local slopes d ln sup / d ln epsilon. Exit code 1 if the outcome contradicts
    /// the theorem: its law of rho, and the verdict "violated".
    #[command(after_long_help = theorem_help())]
    Theorem(TheoremArgs),
    /// Measure how long bright breathers live, over a map.
    ///
    /// The breather u(0) = 2 epsilon a, over its size epsilon and the mass ratio rho.
    ///
    /// Three criteria, each with its own time; a run is followed until all are met or to the cap. `energy`: the core, the
    /// fewest sites that hold 0.999 of the sum of a_n^2, has less than 0.9 of the energy. `distance`: |A - A~|_1/|A~|_1 is
    /// above 0.5, A = u + i u' of the chain and of the ansatz u~ = 2 epsilon a cos(Omega_b t); the phase counts, and a drift
    /// of it by half a radian suffices, long before anything is radiated. `frequency`: the central bead against its
    /// resonator, over four periods, swings with a frequency nearer to omega = sqrt(1 + 1/rho) than to Omega_b. A run that
    /// does not get there says: not before t.
    ///
    /// Each point has a fate. `radiates`: the core falls below 0.9 of the energy while its bonds are at work. `decouples`:
    /// before that, bonds of the core come to be closed less than 1/3 of the time: gaps open, sites swing for themselves,
    /// energy stays. `persists`: neither before the cap.
    ///
    /// With --out points are kept as they are computed, in lifetimes.store: a run that was killed goes on where it was, and
    /// another criterion or a larger map computes only what is new.
    #[command(after_long_help = "\
Example:
  hertzchain study lifetimes --epsilons 0.01,0.1 --rhos 1e3,1e4 --out out/map")]
    Lifetimes(LifetimesArgs),
}

#[derive(Args)]
pub(crate) struct OrderArgs {
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 0.5 to 10.
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Number of beads of the chain, from 2 to 1000.
    #[arg(long, value_name = "N", default_value_t = 6, allow_negative_numbers = true)]
    pub(crate) beads: usize,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: order.csv, order.json, order-state.png and order-tangent.png.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ScalingArgs {
    /// Numbers of sites, separated by commas.
    ///
    /// Multiples of 10, up to 10^6.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', default_values = ["50", "500", "5000", "50000"], allow_negative_numbers = true)]
    pub(crate) sites: Vec<usize>,
    /// Tolerance, from 1e-15 to 0.1.
    ///
    /// The same for every method.
    #[arg(long, value_name = "T", default_value = "1e-9", allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Seed of what is drawn at random.
    ///
    /// The perturbation of the wave.
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Wall time for all runs, in seconds; what would not fit is left out.
    ///
    /// Left out are runs of dop853.
    #[arg(long, value_name = "S", default_value = "60", allow_negative_numbers = true)]
    pub(crate) max_time: f64,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: scaling.csv, scaling.json and scaling.png.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct DriftArgs {
    /// Name of a built-in scene, or a TOML file.
    #[arg(default_value = "bright-breather-16")]
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) set: SetArgs,
    /// Length of the longest run, in periods.
    ///
    /// Of the scene; all runs have this length, from 1 to 10^9.
    #[arg(long, value_name = "P", default_value = "1e4", allow_negative_numbers = true)]
    pub(crate) periods: f64,
    /// Integrators, separated by commas, or all.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',',
        default_values = ["collocation", "corrected", "strang-linear", "yoshida4-linear"])]
    pub(crate) integrators: Vec<String>,
    /// Number of times that are kept.
    ///
    /// Spaced evenly in their logarithm, from 2 to 10^5.
    #[arg(long, value_name = "K", default_value_t = 200, allow_negative_numbers = true)]
    pub(crate) samples: usize,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: drift.csv, drift.json and drift.png.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct StabilityChartsArgs {
    /// Name of a built-in scene, or a TOML file.
    ///
    /// Its chain and state are varied [default: four spheres between walls, kappa = 1, rho = 1/3, amplitude 1].
    pub(crate) scene: Option<String>,
    #[command(flatten)]
    pub(crate) set: SetArgs,
    /// Charts, separated by commas [default: all].
    ///
    /// Of light, stiffness, alpha, length, time, resonances.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(crate) charts: Vec<String>,
    /// Integrators, separated by commas, or all [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(crate) integrators: Vec<String>,
    /// Length of the longest run, in periods.
    ///
    /// Of the chart `time`, in contact periods 2 pi/sqrt(2 alpha A^(alpha-1)), from 1 to 10^6.
    #[arg(long, value_name = "P", default_value = "1e4", allow_negative_numbers = true)]
    pub(crate) periods: f64,
    /// Work of a run while steps are looked for.
    ///
    /// Force evaluations times sites, from 10^4 to 10^12.
    #[arg(long, value_name = "W", default_value = "4e6", allow_negative_numbers = true)]
    pub(crate) work: f64,
    /// Number of sites.
    ///
    /// Of the longest chain of the chart `length`, from 1 to 10^6.
    #[arg(long, value_name = "N", default_value = "100000", allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// A third of the points of light, stiffness and alpha, or fewer.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: stability.json, a CSV and PNGs a chart, and the stores of points.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct TheoremArgs {
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// Above 1 and at most 10 (breathers: from 1.01).
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// T: runs end at t = T epsilon^(1-alpha), at most 1e8.
    ///
    /// In units of the slow time, up to 1000.
    #[arg(long, value_name = "T", default_value = "1", allow_negative_numbers = true)]
    pub(crate) horizon: f64,
    /// Law of the mass ratio, or a number for all epsilon.
    ///
    /// eps^-2(alpha-1), the least that the theorem allows; eps^-(alpha-1), which is less; or a number, inf for Newton's
    /// cradle.
    #[arg(long, value_name = "LAW", default_value = "eps^-2(alpha-1)", allow_hyphen_values = true)]
    pub(crate) rho_law: String,
    /// What A(0) is.
    ///
    /// The breather about a bond or a site, or (xi_n + i eta_n) e^(-n^2/4) with random xi_n, eta_n in (-1, 1).
    #[arg(long, value_name = "I", value_enum, default_value_t = Initial::Bond)]
    pub(crate) initial: Initial,
    /// C_i: departure of the initial state from the ansatz.
    ///
    /// In a random direction, on the boundary of the set (condciu), (condciv) in l_1, and so inside it in all norms. 0:
    /// exactly on the ansatz.
    #[arg(long, value_name = "C", default_value = "0", allow_negative_numbers = true)]
    pub(crate) c_i: f64,
    /// Seed of what is drawn at random [default: 1].
    ///
    /// A generic A(0) and the departure from the ansatz.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Sizes, separated by commas [default: decades from 0.1 to 1e-6].
    ///
    /// Between 0 and 1, in any order.
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub(crate) epsilons: Vec<f64>,
    /// Number of sites.
    ///
    /// Up to 1000 [default: those where A(0) is above 1e-16 of its largest value; generic: 21].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) sites: Option<usize>,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: theorem.json, theorem.txt, theorem.csv (suprema) and slopes.csv, and theorem.store, where every size is kept
    /// once it was run: the same study in the same folder goes on where it was.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The rule of the verdict, and an example.
fn theorem_help() -> String {
    format!(
        "Verdict of each error in each norm. {}\n\n\
         Example, resonators lighter than the theorem asks for:\n  \
         hertzchain study theorem --rho-law 'eps^-(alpha-1)' --alpha 2",
        Bound::RULE
    )
}

#[derive(Args)]
pub(crate) struct LifetimesArgs {
    /// Sizes, separated by commas.
    ///
    /// Positive, each once; displacements.
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', default_values = ["1e-3", "3e-3", "0.01", "0.03", "0.1"], allow_negative_numbers = true)]
    pub(crate) epsilons: Vec<f64>,
    /// Mass ratios resonator to bead, separated by commas.
    ///
    /// Positive, each once.
    #[arg(long, value_name = "R,S,..", value_delimiter = ',', default_values = ["10", "100", "1e3", "1e4", "1e5"], allow_negative_numbers = true)]
    pub(crate) rhos: Vec<f64>,
    /// What ends a life.
    #[arg(long, value_name = "C", value_enum, default_value_t = Criterion::Energy)]
    pub(crate) criterion: Criterion,
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 1.01 to 10.
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// What the profile is symmetric about.
    #[arg(long, value_name = "C", value_enum, default_value_t = Center::Bond)]
    pub(crate) center: Center,
    /// Number of sites.
    ///
    /// Of every chain, from 20 to 10^5 [default: doubled from 100 until nothing comes back from the ends].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) sites: Option<usize>,
    /// End time, in units of time.
    ///
    /// No breather is followed longer [default: 25 times the theorem's scale T epsilon^(1-alpha) of each].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: lifetimes.csv, lifetimes.json and lifetimes.store.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}
