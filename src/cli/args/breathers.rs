//! Flags of breathers, bright and dark.

use super::CenterArg;
use crate::chain::Boundary;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct BreatherArgs {
    #[command(subcommand)]
    pub(crate) action: BreatherAction,
}

#[derive(Subcommand)]
pub(crate) enum BreatherAction {
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
pub(crate) struct BrightArgs {
    /// What the breather is symmetric about: a site (a^1), or the bond of the paper's run (a^2).
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Bond)]
    pub(crate) center: CenterArg,
    /// Size: beads start at 2 epsilon a_n. Dimensionless, like all below.
    #[arg(long, value_name = "E", default_value_t = 0.01, allow_negative_numbers = true)]
    pub(crate) epsilon: f64,
    /// Mass ratio, positive; inf for resonators at rest.
    #[arg(long, value_name = "R", default_value_t = 1000.0, allow_negative_numbers = true)]
    pub(crate) rho: f64,
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Number of beads; with a bond in the middle if even, with a site if odd.
    #[arg(long, value_name = "N", default_value_t = 40, allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// What holds the ends.
    #[arg(long, value_name = "B", value_enum, default_value_t = EndsArg::Free)]
    pub(crate) boundary: EndsArg,
    /// End time, in units of time [default: 80 T, T = 2 pi/omega_0 in units of 1/sqrt(kappa)].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Samples a period T_b, from 1 to 1000, for largest values and the time at which energy has left.
    #[arg(long, value_name = "M", default_value_t = 20, allow_negative_numbers = true)]
    pub(crate) samples_per_period: u32,
    /// An integrator that takes a tolerance; `hertzchain integrators` lists all.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(crate) integrator: String,
    /// Tolerance. For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value_t = 1e-10, allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Folder for breather.json, norms.csv, periods.csv, profiles.csv and forces.csv [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum EndsArg {
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
pub(crate) struct TrivialArgs {
    /// Name of a built-in scene, or a TOML file, with an initial state of kind trivial-breather or one that is such.
    #[arg(default_value = "trivial-breather")]
    pub(crate) scene: String,
    /// Amplitudes a_n, separated by commas, at least zero; as many sites as amplitudes [default: the scene's].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub(crate) amplitudes: Vec<f64>,
    /// Phases phi_n, separated by commas, in radians [default: the scene's].
    #[arg(
        long,
        value_name = "A,B,..",
        value_delimiter = ',',
        conflicts_with = "phase_step_over_pi",
        allow_negative_numbers = true
    )]
    pub(crate) phases: Vec<f64>,
    /// The same (phi_n - phi_{n-1}) / pi for all sites; 1 for neighbours in antiphase [default: the scene's].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) phase_step_over_pi: Option<f64>,
    /// Offsets d_n, separated by commas, nondecreasing: how much the mean positions rise beyond what contacts demand [default: the scene's].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', conflicts_with_all = ["means", "gap"], allow_negative_numbers = true)]
    pub(crate) offsets: Vec<f64>,
    /// Mean positions b_n, separated by commas; refused where beads would press [default: the scene's].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', conflicts_with = "gap", allow_negative_numbers = true)]
    pub(crate) means: Vec<f64>,
    /// The same gap beyond what contacts demand in all bonds, at least zero [default: the scene's].
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    pub(crate) gap: Option<f64>,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// An integrator that takes a tolerance, to hold the closed form against.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(crate) integrator: String,
    /// Its tolerance. For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value_t = 1e-10, allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Folder for breather.json, sites.csv and deviation.csv [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct LifetimesArgs {
    /// Sizes, separated by commas: positive, each once; displacements, dimensionless.
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', default_values_t = [1e-3, 3e-3, 1e-2, 3e-2, 1e-1], allow_negative_numbers = true)]
    pub(crate) epsilons: Vec<f64>,
    /// Mass ratios resonator to bead, separated by commas: positive, each once.
    #[arg(long, value_name = "R,S,..", value_delimiter = ',', default_values_t = [1e1, 1e2, 1e3, 1e4, 1e5], allow_negative_numbers = true)]
    pub(crate) rhos: Vec<f64>,
    /// What ends a life.
    #[arg(long, value_name = "C", value_enum, default_value_t = CriterionArg::Energy)]
    pub(crate) criterion: CriterionArg,
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// What the breather is symmetric about.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Bond)]
    pub(crate) center: CenterArg,
    /// Sites of every chain, from 20 to 10^5 [default: doubled from 100 until nothing comes back from the ends].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) sites: Option<usize>,
    /// Cap: no breather is followed longer, in units of time [default: 25 times the theorem's scale T epsilon^(1-alpha) of each].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Folder for lifetimes.csv, lifetimes.json and lifetimes.store [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum CriterionArg {
    Energy,
    Distance,
    Frequency,
}

/// The ring and the breather on it.
#[derive(Args)]
pub(crate) struct RingArgs {
    /// Sites of the ring, n = -N .. N: odd, from 3 to 255. Weak quartets, and how many there are, depend on it.
    #[arg(long, value_name = "N", default_value_t = 41, allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive; dimensionless, like all below.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Mass ratio, positive and finite.
    #[arg(long, value_name = "R", default_value_t = 1.0 / 3.0, allow_negative_numbers = true)]
    pub(crate) rho: f64,
    /// Vertical centre of the background (eq:center).
    #[arg(long, value_name = "C", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) c_x: f64,
    /// What Newton's method solves.
    #[arg(long, value_name = "F", value_enum, default_value_t = FormulationArg::HalfPeriod)]
    pub(crate) formulation: FormulationArg,
    /// Tolerance of the flow, relative to the size of the state, from 1e-15 to 0.1.
    #[arg(long, value_name = "TOL", default_value_t = 1e-13, allow_negative_numbers = true)]
    pub(crate) tol: f64,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum FormulationArg {
    /// The velocities vanish after half a period: by reversibility the orbit is then periodic.
    HalfPeriod,
    /// The paper's: the state comes back after a period, with the time average of the first strain given, by least squares.
    FullPeriod,
}

#[derive(Args)]
pub(crate) struct DarkBreatherArgs {
    /// Where the kink is: on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(crate) center: CenterArg,
    /// Frequency, radians per unit of time, above omega = sqrt(kappa (1 + 1/rho)) [default: 1.025 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) omega_b: Option<f64>,
    #[command(flatten)]
    pub(crate) ring: RingArgs,
    /// Folder for dark-breather.json [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ContinueArgs {
    /// Where the kink is: on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(crate) center: CenterArg,
    /// What varies: omega_b, rho, kappa, alpha or c_x.
    #[arg(long, value_name = "P", default_value = "omega_b")]
    pub(crate) parameter: String,
    /// Where it begins [default for omega_b: 1.005 omega].
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// Where it ends [default for omega_b: 1.05 omega].
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Its largest change from point to point [default: a hundredth of the range].
    #[arg(long, value_name = "DP", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Points at most, old ones too.
    #[arg(long, value_name = "N", default_value_t = 1000, allow_negative_numbers = true)]
    pub(crate) points: usize,
    /// Count the way by the parameter and not by the arclength: such a branch ends at a fold.
    #[arg(long)]
    pub(crate) natural: bool,
    /// Collisions of multipliers from which no modulus above 1 + WEAK comes are not located.
    #[arg(long, value_name = "WEAK", default_value_t = 0.01, allow_negative_numbers = true)]
    pub(crate) weak: f64,
    /// Frequency, where another number varies [default: 1.025 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) omega_b: Option<f64>,
    /// Go on with the branch of a file branch.npz from its last point: to another --to, by another --step; multipliers and bifurcations are computed anew.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["center", "parameter", "from", "natural", "weak", "omega_b", "sites", "alpha", "kappa", "rho", "c_x", "formulation", "tol"])]
    pub(crate) resume: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) ring: RingArgs,
    /// Folder for branch.json, branch.csv and branch.npz; the last is written every 20 points or 10 s as well [default: none is written; with --resume, that of the file].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct EvolveArgs {
    /// File dark-breather.json of `dark`, or branch.npz of `continue` or `doubled` with --point or --at.
    pub(crate) orbit: PathBuf,
    /// Point of the branch, counted from 0; from the last, -1, if negative.
    #[arg(long, value_name = "K", conflicts_with = "at", allow_negative_numbers = true)]
    pub(crate) point: Option<i64>,
    /// Value of the parameter: the nearest point of the branch.
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// End time, rounded down to whole periods, in units of time.
    #[arg(long, value_name = "T", default_value_t = 1200.0, allow_negative_numbers = true)]
    pub(crate) until: f64,
    /// Largest change of the start, in units of the orbit's amplitude, of either sign [default: none].
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true)]
    pub(crate) kick: Option<f64>,
    /// Multiplier along whose eigenvector the kick is, counted from 0 as `dark --json` lists them: the largest modulus first.
    #[arg(long, value_name = "K", default_value_t = 0, requires = "kick")]
    pub(crate) mode: usize,
    /// Tolerance of the run, relative to the size of the state, from 1e-15 to 0.1.
    #[arg(long, value_name = "TOL", default_value_t = 1e-13, allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Folder for evolution.json, evolution.csv, evolution-x.csv and evolution-y.csv (largest strains in time), evolution.png [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct DoubledArgs {
    /// Frequency of the whole period where the branch is to end, about half of that of the main branch.
    #[arg(long, value_name = "W", default_value_t = 1.056, allow_negative_numbers = true)]
    pub(crate) omega_b: f64,
    /// Where the main branch is left without a period doubling [default: 1.05 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) most: Option<f64>,
    /// Largest change of the frequency from point to point of the main branch; half of it on the doubled one.
    #[arg(long, value_name = "DW", default_value_t = 0.002, allow_negative_numbers = true)]
    pub(crate) step: f64,
    /// File branch.npz of the main branch, which `continue --center bond` has written [default: it is followed here].
    #[arg(long, value_name = "FILE", conflicts_with_all = ["most", "sites", "alpha", "kappa", "rho", "c_x", "formulation", "tol"])]
    pub(crate) branch: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) ring: RingArgs,
    /// Folder for branch.json, branch.csv and branch.npz [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}
