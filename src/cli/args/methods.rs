//! Flags of what compares and runs integrators.

use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct CompareArgs {
    /// Name of a built-in scene, or a TOML file.
    pub(crate) scene: String,
    /// Integrators, separated by commas [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(crate) integrators: Vec<String>,
    /// Wall time for the whole comparison, in seconds; rungs that would not fit are left out.
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    pub(crate) max_time: f64,
    /// Folder for compare.csv, compare.json and compare.png [default: out/compare-SCENE; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct RunArgs {
    /// Name of a built-in scene, or a TOML file.
    #[arg(required_unless_present = "resume")]
    pub(crate) scene: Option<String>,
    /// Integrator; `hertzchain integrators` lists them [default: collocation with --tol or --windows-per-period, strang-linear with steps; without any
    /// of these the exact solution, where one is known, else what the regime asks for: collocation, or strang-linear where omega is above 10^4 times the
    /// frequency of contacts; which and why is said on stderr].
    #[arg(long, value_name = "NAME")]
    pub(crate) integrator: Option<String>,
    /// Steps a period of the scene, for splitting schemes [default: 512].
    #[arg(long, value_name = "N", conflicts_with_all = ["step", "tol"], allow_negative_numbers = true)]
    pub(crate) steps_per_period: Option<f64>,
    /// Step size, in units of time; made smaller where a whole number of steps must fit the span.
    #[arg(long, value_name = "H", conflicts_with = "tol", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Tolerance. For collocation: of the whole run, relative to the size of the state. For corrected and corrected-kinetic: of the state at the end, from 1e-13 to
    /// 0.1; steps come from runs over the whole span. For dop853: of a step, relative, and absolute in units of the largest entry of the initial state [default:
    /// 1e-10].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) tol: Option<f64>,
    /// Equal windows a period of the scene, for collocation, without control of the error.
    #[arg(long, value_name = "N", conflicts_with_all = ["step", "tol", "steps_per_period"], allow_negative_numbers = true)]
    pub(crate) windows_per_period: Option<f64>,
    /// Nodes a panel, with --windows-per-period: 4, 6, 8, 10 or 12 [default: 10].
    #[arg(long, value_name = "M", requires = "windows_per_period", conflicts_with_all = ["step", "tol", "steps_per_period"])]
    pub(crate) nodes: Option<usize>,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Folder for summary.json, scene.toml, final.csv, energy.csv, profiles.npz and PNGs [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Run in legs of this length, in units of time, and keep each in checkpoint.npz in the folder of --out when it is done: a run that was stopped goes on by
    /// --resume and ends with the same bits. Every leg starts the method anew.
    #[arg(long, value_name = "D", requires = "out", allow_negative_numbers = true)]
    pub(crate) checkpoint: Option<f64>,
    /// Go on from this checkpoint.npz, or the one in this folder, and write the results beside it. A scene or an integrator given with it must be its own.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["checkpoint", "steps_per_period", "step", "tol", "windows_per_period", "nodes", "until", "out", "plan"])]
    pub(crate) resume: Option<PathBuf>,
    /// Log every contact: onset, release, speeds, largest overlap, impulse; totals in the summary, and with --out
    /// contacts.csv, contacts.npz and contacts.png.
    #[arg(long)]
    pub(crate) events: bool,
    /// Say what this scene needs and what is left out, and stop.
    #[arg(long)]
    pub(crate) plan: bool,
    /// Print JSON instead of the summary.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct OrderArgs {
    /// Exponent of the contact force, from 0.5 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Number of beads of the chain, from 2 to 1000.
    #[arg(long, value_name = "N", default_value_t = 6, allow_negative_numbers = true)]
    pub(crate) beads: usize,
    /// Folder for order.csv, order.json, order-state.png and order-tangent.png [default: out/order-ALPHA; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ScalingArgs {
    /// Numbers of sites, separated by commas: multiples of 10, up to 10^6.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', default_values_t = [50, 500, 5000, 50_000], allow_negative_numbers = true)]
    pub(crate) sites: Vec<usize>,
    /// Tolerance of every method, from 1e-15 to 0.1.
    #[arg(long, value_name = "T", default_value_t = 1e-9, allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Seed of the perturbation.
    #[arg(long, value_name = "K", default_value_t = 1, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Wall time for the whole study, in seconds; runs of dop853 that would not fit are left out.
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    pub(crate) max_time: f64,
    /// Folder for scaling.csv, scaling.json and scaling.png [default: out/scaling; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct DriftArgs {
    /// Name of a built-in scene, or a TOML file.
    #[arg(default_value = "bright-breather-16")]
    pub(crate) scene: String,
    /// Length of the runs, in periods of the scene, from 1 to 10^9.
    #[arg(long, value_name = "P", default_value_t = 1e4, allow_negative_numbers = true)]
    pub(crate) periods: f64,
    /// Integrators, separated by commas.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',',
        default_values_t = ["collocation", "corrected", "strang-linear", "yoshida4-linear"].map(str::to_owned))]
    pub(crate) integrators: Vec<String>,
    /// Times that are kept, spaced evenly in their logarithm, from 2 to 10^5.
    #[arg(long, value_name = "K", default_value_t = 200, allow_negative_numbers = true)]
    pub(crate) samples: usize,
    /// Folder for drift.csv, drift.json and drift.png [default: out/drift-SCENE; with --json: none].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct StabilityChartsArgs {
    /// Name of a built-in scene, or a TOML file, whose chain and state are varied [default: four spheres between walls, kappa = 1, rho = 1/3, amplitude 1].
    pub(crate) scene: Option<String>,
    /// Charts, separated by commas, of light, stiffness, alpha, length, time, resonances [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(crate) charts: Vec<String>,
    /// Integrators, separated by commas [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(crate) integrators: Vec<String>,
    /// Longest run of the chart `time`, in contact periods 2 pi/sqrt(2 alpha A^(alpha-1)), from 1 to 10^6.
    #[arg(long, value_name = "P", default_value_t = 1e4, allow_negative_numbers = true)]
    pub(crate) periods: f64,
    /// Force evaluations times sites that a run may take while steps are looked for, from 10^4 to 10^12.
    #[arg(long, value_name = "W", default_value_t = 4e6, allow_negative_numbers = true)]
    pub(crate) work: f64,
    /// Longest chain of the chart `length`, from 1 to 10^6 sites.
    #[arg(long, value_name = "N", default_value_t = 100_000, allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// A third of the points of light, stiffness and alpha, or fewer.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Folder for stability.json, a CSV and PNGs a chart, and the stores of points [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}
