//! The raw flags.

use crate::{chain::Boundary, dps::Center};
use clap::{Args, Parser, Subcommand, ValueEnum};
use hertzchain_integrators::Instructions;
use std::path::PathBuf;

/// Nonlinear waves in locally resonant Hertzian chains: which integrator buys which error for which run time.
///
/// All quantities are dimensionless, in the units of the paper (bead mass 1, contact constant 1).
#[derive(Parser)]
#[command(version, about, arg_required_else_help = true)]
pub(super) struct Cli {
    /// Vector instructions of inner loops: portable, avx2 or avx512 [default: the widest of this machine]. Loops have the same bits with each.
    #[arg(long, global = true, value_name = "SET", value_parser = instructions, display_order = 1000)]
    pub(super) instructions: Option<Instructions>,
    #[command(subcommand)]
    pub(super) command: Command,
}

fn instructions(text: &str) -> Result<Instructions, String> {
    let named = Instructions::ALL.into_iter().find(|set| set.to_string() == text);
    let set = named.ok_or_else(|| format!("one of {}", Instructions::ALL.map(|set| set.to_string()).join(", ")))?;
    if set.available() { Ok(set) } else { Err("this machine does not have them".to_owned()) }
}

#[derive(Subcommand)]
pub(super) enum Command {
    /// Compare integrators on a scene: error against run time, as a table, a CSV and a PNG.
    Compare(CompareArgs),
    /// Run one scene with one integrator.
    ///
    /// Example, in legs that are kept, and gone on with: hertzchain run tw-q15 --checkpoint 10 --out out/tw; hertzchain run --resume out/tw
    Run(RunArgs),
    /// Measure the order of every method through contacts: crossing them, landing on them, regularised.
    Order(OrderArgs),
    /// Measure run time per bond and period against the number of sites.
    Scaling(ScalingArgs),
    /// Measure how the energy error grows with time.
    Drift(DriftArgs),
    /// The modulation equations of small oscillations, and what follows from them.
    Dps(DpsArgs),
    /// Breathers: the long-lived bright one against its ansatz, and the trivial one, whose beads never touch.
    Breather(BreatherArgs),
    /// Compute a dark breather as an exact periodic orbit, with its Floquet multipliers.
    Dark(DarkBreatherArgs),
    /// Follow a branch of dark breathers in one parameter, with its multipliers and bifurcations.
    ///
    /// Example, stopped after 20 points and gone on with: hertzchain continue --points 20 --out out/branch; hertzchain continue --resume out/branch/branch.npz
    Continue(ContinueArgs),
    /// Follow the branch of doubled period that leaves the bond-centred dark breathers.
    Doubled(DoubledArgs),
    /// Let a dark breather go, kicked along one of its modes or not: does it come back, and where does its kink go?
    ///
    /// Example: hertzchain dark --center bond --omega-b 2.05 --out out/dark; hertzchain evolve out/dark/dark-breather.json --until 1200 --kick 1e-3 --mode 0
    Evolve(EvolveArgs),
    /// Chart the stability of the integrators: light resonators and resonances, contact stiffness, exponent, length, run length.
    ///
    /// Every point is a method on a variant of the chain: stable, drifting or lost, its energy error, the largest step that keeps it below 1e-3 and 1e-6, and
    /// what that costs. All quantities are dimensionless. With --out points are kept as they are computed: a run that was killed goes on where it was.
    /// Example: hertzchain stability --charts light,resonances --integrators verlet,strang-linear,collocation --out out/stability
    Stability(StabilityChartsArgs),
    /// Run a travelling wave on the chain and hold it against its ansatz; perturb it and see whether it is stable.
    Wave(WaveArgs),
    /// Theorem 1 as an experiment that could fail: does the DpS equation describe the chain with heavy resonators as well, and for as long, as it says?
    ///
    /// Runs the chain with kappa = 1 and free ends at each epsilon, takes the suprema over 0 <= t <= T epsilon^(1-alpha) of the four errors (estimu), (estimv) in
    /// l_1, l_2 and l_inf over samples, divides them by epsilon^alpha (u with u', v) and epsilon^(2 alpha-1) (v'), and gives the local slopes d ln sup / d ln
    /// epsilon. All quantities are dimensionless. Exit code 1 if the outcome contradicts the theorem: its law of rho, and the verdict "violated".
    #[command(after_long_help = theorem_help())]
    Theorem(TheoremArgs),
    /// Measure how long the long-lived bright breather u(0) = 2 epsilon a lives, over a map of its size epsilon and the mass ratio rho.
    ///
    /// Three criteria, each with its own time; a run is followed until all are met or to the cap. `energy`: the core, the fewest sites that hold 0.999 of the sum of
    /// a_n^2, has less than 0.9 of the energy. `distance`: |A - A~|_1/|A~|_1 is above 0.5, A = u + i u' of the chain
    /// and of the ansatz u~ = 2 epsilon a cos(Omega_b t); the phase counts, and a drift of it by half a radian suffices, long before anything is radiated. `frequency`: the central bead against its resonator, over four periods,
    /// swings with a frequency nearer to omega = sqrt(1 + 1/rho) than to Omega_b. A run that does not get there says: not before t.
    ///
    /// Each point has a fate. `radiates`: the core falls below 0.9 of the energy while its bonds are at work. `decouples`: before that, bonds of the core come to be
    /// closed less than 1/3 of the time: gaps open, sites swing for themselves, energy stays. `persists`: neither before the cap.
    ///
    /// With --out points are kept as they are computed, in lifetimes.store: a run that was killed goes on where it was, and another criterion or a larger map
    /// computes only what is new. Example: hertzchain lifetimes --epsilons 0.01,0.1 --rhos 1e3,1e4,1e5 --out out/lifetimes
    Lifetimes(LifetimesArgs),
    /// Hold every number in the text of the paper's Sec. 3 to 7 against ours: what it says, what we get, the verdict, and why if they differ.
    ///
    /// Exit code 0: every verdict is the one that is known, also where the paper is known to differ, and our numbers there are what they were. Exit code 1:
    /// one is not, or a run failed.
    Verify(VerifyArgs),
    /// Compute the figures of the paper: pictures, and the numbers behind them as CSV.
    Figures(FiguresArgs),
    /// Run everything in its short form and write one self-contained HTML page: tables, pictures, captions, the machine and the version.
    ///
    /// Example: hertzchain report --out out/report; hertzchain report --only compare,order
    Report(ReportArgs),
    /// List the built-in scenes, or show one as TOML.
    Scenes(ScenesArgs),
    /// List the integrators with order, stages and source.
    Integrators(IntegratorsArgs),
}

#[derive(Args)]
pub(super) struct CompareArgs {
    /// Name of a built-in scene, or a TOML file.
    pub(super) scene: String,
    /// Integrators, separated by commas [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(super) integrators: Vec<String>,
    /// Wall time for the whole comparison, in seconds; rungs that would not fit are left out.
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    pub(super) max_time: f64,
    /// Folder for compare.csv, compare.json and compare.png [default: out/compare-SCENE; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct RunArgs {
    /// Name of a built-in scene, or a TOML file.
    #[arg(required_unless_present = "resume")]
    pub(super) scene: Option<String>,
    /// Integrator; `hertzchain integrators` lists them [default: collocation with --tol or --windows-per-period, strang-linear with steps; without any
    /// of these the exact solution, where one is known, else what the regime asks for: collocation, or strang-linear where omega is above 10^4 times the
    /// frequency of contacts; which and why is said on stderr].
    #[arg(long, value_name = "NAME")]
    pub(super) integrator: Option<String>,
    /// Steps a period of the scene, for splitting schemes [default: 512].
    #[arg(long, value_name = "N", conflicts_with_all = ["step", "tol"], allow_negative_numbers = true)]
    pub(super) steps_per_period: Option<f64>,
    /// Step size, in units of time; made smaller where a whole number of steps must fit the span.
    #[arg(long, value_name = "H", conflicts_with = "tol", allow_negative_numbers = true)]
    pub(super) step: Option<f64>,
    /// Tolerance. For collocation: of the whole run, relative to the size of the state. For dop853: of a step, relative, and absolute
    /// in units of the largest entry of the initial state [default: 1e-10].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) tol: Option<f64>,
    /// Equal windows a period of the scene, for collocation, without control of the error.
    #[arg(long, value_name = "N", conflicts_with_all = ["step", "tol", "steps_per_period"], allow_negative_numbers = true)]
    pub(super) windows_per_period: Option<f64>,
    /// Nodes a panel, with --windows-per-period: 4, 6, .. 16 [default: 10].
    #[arg(long, value_name = "M", requires = "windows_per_period", conflicts_with_all = ["step", "tol", "steps_per_period"])]
    pub(super) nodes: Option<usize>,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) until: Option<f64>,
    /// Folder for summary.json, scene.toml, final.csv, energy.csv, profiles.npz and PNGs [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Run in legs of this length, in units of time, and keep each in checkpoint.npz in the folder of --out when it is done: a run that was stopped goes on by
    /// --resume and ends with the same bits. Every leg starts the method anew.
    #[arg(long, value_name = "D", requires = "out", allow_negative_numbers = true)]
    pub(super) checkpoint: Option<f64>,
    /// Go on from this checkpoint.npz, or the one in this folder, and write the results beside it. A scene or an integrator given with it must be its own.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["checkpoint", "steps_per_period", "step", "tol", "windows_per_period", "nodes", "until", "out", "plan"])]
    pub(super) resume: Option<PathBuf>,
    /// Log every contact: onset, release, speeds, largest overlap, impulse; totals in the summary, and with --out
    /// contacts.csv, contacts.npz and contacts.png.
    #[arg(long)]
    pub(super) events: bool,
    /// Say what this scene needs and what is left out, and stop.
    #[arg(long)]
    pub(super) plan: bool,
    /// Print JSON instead of the summary.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct OrderArgs {
    /// Exponent of the contact force, from 0.5 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// Number of beads of the chain, from 2 to 1000.
    #[arg(long, value_name = "N", default_value_t = 6, allow_negative_numbers = true)]
    pub(super) beads: usize,
    /// Folder for order.csv, order.json, order-state.png and order-tangent.png [default: out/order-ALPHA; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct ScalingArgs {
    /// Numbers of sites, separated by commas: multiples of 10, up to 10^6.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', default_values_t = [50, 500, 5000, 50_000], allow_negative_numbers = true)]
    pub(super) sites: Vec<usize>,
    /// Tolerance of every method, from 1e-15 to 0.1.
    #[arg(long, value_name = "T", default_value_t = 1e-9, allow_negative_numbers = true)]
    pub(super) tol: f64,
    /// Seed of the perturbation.
    #[arg(long, value_name = "K", default_value_t = 1, allow_negative_numbers = true)]
    pub(super) seed: u64,
    /// Wall time for the whole study, in seconds; runs of dop853 that would not fit are left out.
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    pub(super) max_time: f64,
    /// Folder for scaling.csv, scaling.json and scaling.png [default: out/scaling; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct DriftArgs {
    /// Name of a built-in scene, or a TOML file.
    #[arg(default_value = "bright-breather-16")]
    pub(super) scene: String,
    /// Length of the runs, in periods of the scene, from 1 to 10^9.
    #[arg(long, value_name = "P", default_value_t = 1e4, allow_negative_numbers = true)]
    pub(super) periods: f64,
    /// Integrators, separated by commas.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',',
        default_values_t = ["collocation", "strang-linear", "yoshida4-linear"].map(str::to_owned))]
    pub(super) integrators: Vec<String>,
    /// Times that are kept, spaced evenly in their logarithm, from 2 to 10^5.
    #[arg(long, value_name = "K", default_value_t = 200, allow_negative_numbers = true)]
    pub(super) samples: usize,
    /// Folder for drift.csv, drift.json and drift.png [default: out/drift-SCENE; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct StabilityChartsArgs {
    /// Name of a built-in scene, or a TOML file, whose chain and state are varied [default: four spheres between walls, kappa = 1, rho = 1/3, amplitude 1].
    pub(super) scene: Option<String>,
    /// Charts, separated by commas, of light, stiffness, alpha, length, time, resonances [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(super) charts: Vec<String>,
    /// Integrators, separated by commas [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(super) integrators: Vec<String>,
    /// Longest run of the chart `time`, in contact periods 2 pi/sqrt(2 alpha A^(alpha-1)), from 1 to 10^6.
    #[arg(long, value_name = "P", default_value_t = 1e4, allow_negative_numbers = true)]
    pub(super) periods: f64,
    /// Force evaluations times sites that a run may take while steps are looked for, from 10^4 to 10^12.
    #[arg(long, value_name = "W", default_value_t = 4e6, allow_negative_numbers = true)]
    pub(super) work: f64,
    /// Longest chain of the chart `length`, from 1 to 10^6 sites.
    #[arg(long, value_name = "N", default_value_t = 100_000, allow_negative_numbers = true)]
    pub(super) sites: usize,
    /// A third of the points of light, stiffness and alpha, or fewer.
    #[arg(long)]
    pub(super) quick: bool,
    /// Folder for stability.json, a CSV and PNGs a chart, and the stores of points [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct WaveArgs {
    /// Name of a built-in scene, or a TOML file, with an initial state of kind travelling-wave.
    pub(super) scene: String,
    /// Perturb real and imaginary part of each amplitude by up to this share of it, from 0 (none) to below 1 [default: the scene's].
    #[arg(long, value_name = "Z", allow_negative_numbers = true)]
    pub(super) zeta: Option<f64>,
    /// Seed of the perturbation [default: the scene's, else 1].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(super) seed: Option<u64>,
    /// Run this many perturbed waves, from that seed on, on all cores, and give the spread of their growth: from 1 to 10^4 [default: 1].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub(super) seeds: Option<u32>,
    /// An integrator that takes a tolerance; `hertzchain integrators` lists all.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(super) integrator: String,
    /// Tolerance. For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value_t = 1e-10, allow_negative_numbers = true)]
    pub(super) tol: f64,
    /// Samples a period of the wave, from 2 to 1000, for errors in time and their largest value; the end is one of them.
    #[arg(long, value_name = "M", default_value_t = 50, allow_negative_numbers = true)]
    pub(super) samples_per_period: u32,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) until: Option<f64>,
    /// Folder for wave.json, errors.csv, profile.csv, and of perturbed waves envelope.csv, ensemble.csv and spread.csv [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct BreatherArgs {
    #[command(subcommand)]
    pub(super) action: BreatherAction,
}

#[derive(Subcommand)]
pub(super) enum BreatherAction {
    /// The breather of the DpS equation put on the chain: how far the chain gets from it, and what becomes of it.
    ///
    /// Example: hertzchain breather bright --center bond --epsilon 0.01 --rho 1000
    Bright(BrightArgs),
    /// An exact solution whose beads never touch: closed form against an integrator, gaps, mean contact forces.
    ///
    /// Example: hertzchain breather trivial --amplitudes 0.1,0.2,0.1 --phases 0,1.5,3 --gap 0
    Trivial(TrivialArgs),
}

#[derive(Args)]
pub(super) struct BrightArgs {
    /// What the breather is symmetric about: a site (a^1), or the bond of the paper's run (a^2).
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Bond)]
    pub(super) center: CenterArg,
    /// Size: beads start at 2 epsilon a_n. Dimensionless, like all below.
    #[arg(long, value_name = "E", default_value_t = 0.01, allow_negative_numbers = true)]
    pub(super) epsilon: f64,
    /// Mass ratio, positive; inf for resonators at rest.
    #[arg(long, value_name = "R", default_value_t = 1000.0, allow_negative_numbers = true)]
    pub(super) rho: f64,
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// Spring constant of the resonators, positive.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) kappa: f64,
    /// Number of beads; with a bond in the middle if even, with a site if odd.
    #[arg(long, value_name = "N", default_value_t = 40, allow_negative_numbers = true)]
    pub(super) sites: usize,
    /// What holds the ends.
    #[arg(long, value_name = "B", value_enum, default_value_t = EndsArg::Free)]
    pub(super) boundary: EndsArg,
    /// End time, in units of time [default: 80 T, T = 2 pi/omega_0 in units of 1/sqrt(kappa)].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) until: Option<f64>,
    /// Samples a period T_b, from 1 to 1000, for largest values and the time at which energy has left.
    #[arg(long, value_name = "M", default_value_t = 20, allow_negative_numbers = true)]
    pub(super) samples_per_period: u32,
    /// An integrator that takes a tolerance; `hertzchain integrators` lists all.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(super) integrator: String,
    /// Tolerance. For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value_t = 1e-10, allow_negative_numbers = true)]
    pub(super) tol: f64,
    /// Folder for breather.json, norms.csv, periods.csv, profiles.csv and forces.csv [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum EndsArg {
    Free,
    Fixed,
    Ring,
}

impl From<EndsArg> for Boundary {
    fn from(ends: EndsArg) -> Self {
        match ends {
            EndsArg::Free => Self::Free,
            EndsArg::Fixed => Self::Fixed,
            EndsArg::Ring => Self::Ring,
        }
    }
}

#[derive(Args)]
pub(super) struct TrivialArgs {
    /// Name of a built-in scene, or a TOML file, with an initial state of kind trivial-breather or one that is such.
    #[arg(default_value = "trivial-breather")]
    pub(super) scene: String,
    /// Amplitudes a_n, separated by commas, at least zero; as many sites as amplitudes [default: the scene's].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub(super) amplitudes: Vec<f64>,
    /// Phases phi_n, separated by commas, in radians [default: the scene's].
    #[arg(
        long,
        value_name = "A,B,..",
        value_delimiter = ',',
        conflicts_with = "phase_step_over_pi",
        allow_negative_numbers = true
    )]
    pub(super) phases: Vec<f64>,
    /// The same (phi_n - phi_{n-1}) / pi for all sites; 1 for neighbours in antiphase [default: the scene's].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(super) phase_step_over_pi: Option<f64>,
    /// Offsets d_n, separated by commas, nondecreasing: how much the mean positions rise beyond what contacts demand [default: the scene's].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', conflicts_with_all = ["means", "gap"], allow_negative_numbers = true)]
    pub(super) offsets: Vec<f64>,
    /// Mean positions b_n, separated by commas; refused where beads would press [default: the scene's].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', conflicts_with = "gap", allow_negative_numbers = true)]
    pub(super) means: Vec<f64>,
    /// The same gap beyond what contacts demand in all bonds, at least zero [default: the scene's].
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    pub(super) gap: Option<f64>,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) until: Option<f64>,
    /// An integrator that takes a tolerance, to hold the closed form against.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(super) integrator: String,
    /// Its tolerance. For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value_t = 1e-10, allow_negative_numbers = true)]
    pub(super) tol: f64,
    /// Folder for breather.json, sites.csv and deviation.csv [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct VerifyArgs {
    /// One section of the paper: 3, 4, 5, 6 or 7 [default: all].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(super) section: Option<u32>,
    /// Folder for verify.txt, verify.csv and verify.json [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct DpsArgs {
    #[command(subcommand)]
    pub(super) action: DpsAction,
}

#[derive(Subcommand)]
pub(super) enum DpsAction {
    /// The averaged contact force g_alpha(b, r), its harmonic h_alpha(b, r), and their derivatives.
    Integrals(IntegralsArgs),
    /// The homoclinic solutions of the stationary DpS equation: profiles of bright breathers.
    Homoclinic(HomoclinicArgs),
    /// The standing waves with a kink of the generalised DpS equations: profiles of dark breathers, and the strains that start one.
    ///
    /// Example: hertzchain dps dark --center bond --rho 3 --omega-b 1.16
    Dark(DarkArgs),
    /// Which modulations of a travelling wave grow and how fast: in closed form, and measured on the full chain.
    Stability(StabilityArgs),
}

#[derive(Args)]
pub(super) struct HomoclinicArgs {
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// What the profile is symmetric about.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(super) center: CenterArg,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum CenterArg {
    Site,
    Bond,
}

impl From<CenterArg> for Center {
    fn from(center: CenterArg) -> Self {
        match center {
            CenterArg::Site => Self::Site,
            CenterArg::Bond => Self::Bond,
        }
    }
}

#[derive(Args)]
pub(super) struct TheoremArgs {
    /// Exponent of the contact force, above 1 and at most 10 (breathers: from 1.01); 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// T: runs end at t = T epsilon^(1-alpha), at most 1e8; in units of the slow time, up to 1000.
    #[arg(long, value_name = "T", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) horizon: f64,
    /// Mass ratio: eps^-2(alpha-1), the least that the theorem allows; eps^-(alpha-1), which is less; or a number for all epsilon, inf for Newton's cradle.
    #[arg(long, value_name = "LAW", default_value = "eps^-2(alpha-1)", allow_hyphen_values = true)]
    pub(super) rho_law: String,
    /// A(0): the breather about a bond or a site, or (xi_n + i eta_n) e^(-n^2/4) with random xi_n, eta_n in (-1, 1).
    #[arg(long, value_name = "I", value_enum, default_value_t = InitialArg::Bond)]
    pub(super) initial: InitialArg,
    /// C_i: departure of the initial state from the ansatz, in a random direction; on the boundary of the set (condciu), (condciv) in l_1, and so inside it
    /// in all norms. 0: exactly on the ansatz.
    #[arg(long, value_name = "C", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) c_i: f64,
    /// Seed of a generic A(0) and of the departure [default: 1].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(super) seed: Option<u64>,
    /// Sizes between 0 and 1, separated by commas, in any order [default: decades from 0.1 to 1e-6].
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub(super) epsilons: Vec<f64>,
    /// Sites of the chain, up to 1000 [default: those where A(0) is above 1e-16 of its largest value; generic: 21].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(super) sites: Option<usize>,
    /// Folder for theorem.json, theorem.txt, theorem.csv (suprema) and slopes.csv, and for theorem.store, where every size is kept once it was run: the same
    /// study in the same folder goes on where it was [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum InitialArg {
    Bond,
    Site,
    Generic,
}

#[derive(Args)]
pub(super) struct LifetimesArgs {
    /// Sizes, separated by commas: positive, each once; displacements, dimensionless.
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', default_values_t = [1e-3, 3e-3, 1e-2, 3e-2, 1e-1], allow_negative_numbers = true)]
    pub(super) epsilons: Vec<f64>,
    /// Mass ratios resonator to bead, separated by commas: positive, each once.
    #[arg(long, value_name = "R,S,..", value_delimiter = ',', default_values_t = [1e1, 1e2, 1e3, 1e4, 1e5], allow_negative_numbers = true)]
    pub(super) rhos: Vec<f64>,
    /// What ends a life.
    #[arg(long, value_name = "C", value_enum, default_value_t = CriterionArg::Energy)]
    pub(super) criterion: CriterionArg,
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// What the breather is symmetric about.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Bond)]
    pub(super) center: CenterArg,
    /// Sites of every chain, from 20 to 10^5 [default: doubled from 100 until nothing comes back from the ends].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(super) sites: Option<usize>,
    /// Cap: no breather is followed longer, in units of time [default: 25 times the theorem's scale T epsilon^(1-alpha) of each].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) until: Option<f64>,
    /// Folder for lifetimes.csv, lifetimes.json and lifetimes.store [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum CriterionArg {
    Energy,
    Distance,
    Frequency,
}

/// The ring and the breather on it.
#[derive(Args)]
pub(super) struct RingArgs {
    /// Sites of the ring, n = -N .. N: odd, from 3 to 255. Weak quartets, and how many there are, depend on it.
    #[arg(long, value_name = "N", default_value_t = 41, allow_negative_numbers = true)]
    pub(super) sites: usize,
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// Spring constant of the resonators, positive; dimensionless, like all below.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) kappa: f64,
    /// Mass ratio, positive and finite.
    #[arg(long, value_name = "R", default_value_t = 1.0 / 3.0, allow_negative_numbers = true)]
    pub(super) rho: f64,
    /// Vertical centre of the background (eq:center).
    #[arg(long, value_name = "C", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) c_x: f64,
    /// What Newton's method solves.
    #[arg(long, value_name = "F", value_enum, default_value_t = FormulationArg::HalfPeriod)]
    pub(super) formulation: FormulationArg,
    /// Tolerance of the flow, relative to the size of the state, from 1e-15 to 0.1.
    #[arg(long, value_name = "TOL", default_value_t = 1e-13, allow_negative_numbers = true)]
    pub(super) tol: f64,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum FormulationArg {
    /// The velocities vanish after half a period: by reversibility the orbit is then periodic.
    HalfPeriod,
    /// The paper's: the state comes back after a period, with the time average of the first strain given, by least squares.
    FullPeriod,
}

#[derive(Args)]
pub(super) struct DarkBreatherArgs {
    /// Where the kink is: on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(super) center: CenterArg,
    /// Frequency, radians per unit of time, above omega = sqrt(kappa (1 + 1/rho)) [default: 1.025 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(super) omega_b: Option<f64>,
    #[command(flatten)]
    pub(super) ring: RingArgs,
    /// Folder for dark-breather.json [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct ContinueArgs {
    /// Where the kink is: on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(super) center: CenterArg,
    /// What varies: omega_b, rho, kappa, alpha or c_x.
    #[arg(long, value_name = "P", default_value = "omega_b")]
    pub(super) parameter: String,
    /// Where it begins [default for omega_b: 1.005 omega].
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(super) from: Option<f64>,
    /// Where it ends [default for omega_b: 1.05 omega].
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(super) to: Option<f64>,
    /// Its largest change from point to point [default: a hundredth of the range].
    #[arg(long, value_name = "DP", allow_negative_numbers = true)]
    pub(super) step: Option<f64>,
    /// Points at most, old ones too.
    #[arg(long, value_name = "N", default_value_t = 1000, allow_negative_numbers = true)]
    pub(super) points: usize,
    /// Count the way by the parameter and not by the arclength: such a branch ends at a fold.
    #[arg(long)]
    pub(super) natural: bool,
    /// Collisions of multipliers from which no modulus above 1 + WEAK comes are not located.
    #[arg(long, value_name = "WEAK", default_value_t = 0.01, allow_negative_numbers = true)]
    pub(super) weak: f64,
    /// Frequency, where another number varies [default: 1.025 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(super) omega_b: Option<f64>,
    /// Go on with the branch of a file branch.npz from its last point: to another --to, by another --step; multipliers and bifurcations are computed anew.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["center", "parameter", "from", "natural", "weak", "omega_b", "sites", "alpha", "kappa", "rho", "c_x", "formulation", "tol"])]
    pub(super) resume: Option<PathBuf>,
    #[command(flatten)]
    pub(super) ring: RingArgs,
    /// Folder for branch.json, branch.csv and branch.npz; the last is written every 20 points or 10 s as well [default: none is written; with --resume, that of the file].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct EvolveArgs {
    /// File dark-breather.json of `dark`, or branch.npz of `continue` or `doubled` with --point or --at.
    pub(super) orbit: PathBuf,
    /// Point of the branch, counted from 0; from the last, -1, if negative.
    #[arg(long, value_name = "K", conflicts_with = "at", allow_negative_numbers = true)]
    pub(super) point: Option<i64>,
    /// Value of the parameter: the nearest point of the branch.
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(super) at: Option<f64>,
    /// End time, rounded down to whole periods, in units of time.
    #[arg(long, value_name = "T", default_value_t = 1200.0, allow_negative_numbers = true)]
    pub(super) until: f64,
    /// Largest change of the start, in units of the orbit's amplitude, of either sign [default: none].
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true)]
    pub(super) kick: Option<f64>,
    /// Multiplier along whose eigenvector the kick is, counted from 0 as `dark --json` lists them: the largest modulus first.
    #[arg(long, value_name = "K", default_value_t = 0, requires = "kick")]
    pub(super) mode: usize,
    /// Tolerance of the run, relative to the size of the state, from 1e-15 to 0.1.
    #[arg(long, value_name = "TOL", default_value_t = 1e-13, allow_negative_numbers = true)]
    pub(super) tol: f64,
    /// Folder for evolution.json, evolution.csv, evolution-x.csv and evolution-y.csv (largest strains in time), evolution.png [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct DoubledArgs {
    /// Frequency of the whole period where the branch is to end, about half of that of the main branch.
    #[arg(long, value_name = "W", default_value_t = 1.056, allow_negative_numbers = true)]
    pub(super) omega_b: f64,
    /// Where the main branch is left without a period doubling [default: 1.05 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(super) most: Option<f64>,
    /// Largest change of the frequency from point to point of the main branch; half of it on the doubled one.
    #[arg(long, value_name = "DW", default_value_t = 0.002, allow_negative_numbers = true)]
    pub(super) step: f64,
    /// File branch.npz of the main branch, which `continue --center bond` has written [default: it is followed here].
    #[arg(long, value_name = "FILE", conflicts_with_all = ["most", "sites", "alpha", "kappa", "rho", "c_x", "formulation", "tol"])]
    pub(super) branch: Option<PathBuf>,
    #[command(flatten)]
    pub(super) ring: RingArgs,
    /// Folder for branch.json, branch.csv and branch.npz [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct DarkArgs {
    /// Where the kink is: on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(super) center: CenterArg,
    /// Sites of the ring, odd, from 3 to 100001.
    #[arg(long, value_name = "N", default_value_t = 41, allow_negative_numbers = true)]
    pub(super) sites: usize,
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// Spring constant of the resonators, positive; dimensionless, like all below.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) kappa: f64,
    /// Mass ratio, positive and finite.
    #[arg(long, value_name = "R", default_value_t = 1.0 / 3.0, allow_negative_numbers = true)]
    pub(super) rho: f64,
    /// Mean strain of the background at mu = 1.
    #[arg(long, value_name = "C", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) c: f64,
    /// Frequency of the breather, radians per unit of time, above omega = sqrt(kappa (1 + 1/rho)) [default: 1.005 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(super) omega_b: Option<f64>,
    /// Folder for dark.csv and dark.json [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct IntegralsArgs {
    /// Exponent of the contact force, above 0 and at most 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// Spring constant of the resonators, positive; dimensionless, like all below.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) kappa: f64,
    /// Mean strain of the bond -b + 2 kappa r cos t; all values are zero for b >= 2 kappa r.
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    pub(super) b: f64,
    /// Amplitude, at least zero.
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub(super) r: f64,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct StabilityArgs {
    /// A travelling-wave scene, by name or as a TOML file, to take everything below from.
    #[arg(conflicts_with_all = ["alpha", "kappa", "rho", "a", "b", "q_over_pi", "epsilon", "sites"])]
    pub(super) scene: Option<String>,
    /// Exponent of the contact force, above 0 and at most 10.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(super) alpha: f64,
    /// Spring constant of the resonators, positive; dimensionless, like all below.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) kappa: f64,
    /// Mass ratio, positive; inf for the DpS equation of Newton's cradle, with --b 0.
    #[arg(long, value_name = "R", default_value_t = 1.0 / 3.0, allow_negative_numbers = true)]
    pub(super) rho: f64,
    /// Amplitude of the wave, positive.
    #[arg(long, value_name = "A", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) a: f64,
    /// Mean strain of the wave, below 2 kappa a.
    #[arg(long, value_name = "B", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) b: f64,
    /// Wave number over pi, with a whole number of waves on the ring.
    #[arg(long, value_name = "Q", default_value_t = 0.2, allow_negative_numbers = true)]
    pub(super) q_over_pi: f64,
    /// Sizes of the wave, separated by commas: rates per unit of time are those of the first, growth is measured at each.
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', default_values_t = [0.01], allow_negative_numbers = true)]
    pub(super) epsilon: Vec<f64>,
    /// Sites of the ring, from 2 to 10^4; to be measured at most 1000.
    #[arg(long, value_name = "N", default_value_t = 50, allow_negative_numbers = true)]
    pub(super) sites: usize,
    /// Measure the growth on the full chain as well.
    #[arg(long)]
    pub(super) measure: bool,
    /// Wave numbers that are measured, spread over those of the ring; the fastest comes on top.
    #[arg(long, value_name = "M", default_value_t = 12, requires = "measure", allow_negative_numbers = true)]
    pub(super) modes: usize,
    /// Chart the fastest growth over q and b as well.
    #[arg(long)]
    pub(super) chart: bool,
    /// Folder for stability.csv, stability.json and dps-growth.png, with --measure measured.csv, with --chart chart.csv [default: none].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct FiguresArgs {
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', help = figures_help())]
    pub(super) only: Vec<String>,
    /// Folder for NAME.png, the tables NAME-….csv and NAME.json, which says what made them.
    #[arg(long, value_name = "DIR", default_value = "out/figures")]
    pub(super) out: PathBuf,
    /// Print JSON instead of the table: name, source, title, files, caption, wall time.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct ReportArgs {
    /// Parts to make: compare, order, theorem, stability, verify, figures [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(super) only: Vec<String>,
    /// Folder for report.html and report.json.
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    pub(super) out: PathBuf,
    /// Print JSON instead of the table: what was made, wall times, failures.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct ScenesArgs {
    #[command(subcommand)]
    pub(super) action: Option<ScenesAction>,
    /// Print JSON instead of the table.
    #[arg(long, global = true)]
    pub(super) json: bool,
}

#[derive(Subcommand)]
pub(super) enum ScenesAction {
    /// Print the TOML of a scene: a start for your own.
    Show {
        /// Name of a built-in scene, or a TOML file.
        name: String,
    },
}

#[derive(Args)]
pub(super) struct IntegratorsArgs {
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(super) json: bool,
}

/// Names the figures that there are.
fn figures_help() -> String {
    let names: Vec<_> = crate::experiments::PAPER.iter().map(|figure| figure.name).collect();
    format!("Figures, separated by commas, of {} [default: all]", names.join(", "))
}

/// The rule of the verdict, and an example.
fn theorem_help() -> String {
    format!(
        "Verdict of each error in each norm. {}\n\nExample, resonators lighter than the theorem asks for: hertzchain theorem --rho-law 'eps^-(alpha-1)' --alpha 2",
        crate::experiments::Bound::RULE
    )
}
