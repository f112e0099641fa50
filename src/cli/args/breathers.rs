//! Flags of breathers, bright and dark.

use super::SetArgs;
use crate::{chain::Boundary, dps::Center, orbits::Formulation};
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct BreatherArgs {
    #[command(subcommand)]
    pub(crate) action: BreatherAction,
}

#[derive(Subcommand)]
pub(crate) enum BreatherAction {
    /// The long-lived bright breather on the chain, against its ansatz.
    ///
    /// The breather of the DpS equation put on the chain: how far the chain gets from it, and what becomes of it.
    #[command(after_long_help = "\
Example:
  hertzchain breather bright --center bond --epsilon 0.01 --rho 1000")]
    Bright(BrightArgs),
    /// An exact solution whose beads never touch.
    ///
    /// Closed form against an integrator, gaps, mean contact forces.
    #[command(after_long_help = "\
Example:
  hertzchain breather trivial --amplitudes 0.1,0.2,0.1 --phases 0,1.5,3 --gap 0")]
    Trivial(TrivialArgs),
    /// Compute a dark breather as an exact periodic orbit.
    ///
    /// With its Floquet multipliers.
    #[command(after_long_help = "\
Example:
  hertzchain breather dark --center bond --omega-b 2.05 --out out/dark")]
    Dark(DarkBreatherArgs),
    /// Follow a branch of dark breathers in one parameter.
    ///
    /// With its multipliers and bifurcations.
    #[command(after_long_help = "\
Example, stopped after 20 points and gone on with:
  hertzchain breather continue --points 20 --out out/branch
  hertzchain breather continue --resume out/branch/branch.npz")]
    Continue(ContinueArgs),
    /// Follow the branch of doubled period of dark breathers.
    ///
    /// The branch that leaves the bond-centred dark breathers.
    #[command(after_long_help = "Example:\n  hertzchain breather doubled --omega-b 1.056 --out out/doubled")]
    Doubled(DoubledArgs),
    /// Let a dark breather go, kicked along one of its modes or not.
    ///
    /// Does it come back, and where does its kink go?
    #[command(after_long_help = "\
Example:
  hertzchain breather dark --center bond --omega-b 2.05 --out out/dark
  hertzchain breather evolve out/dark/dark-breather.json --kick 1e-3")]
    Evolve(EvolveArgs),
}

#[derive(Args)]
pub(crate) struct BrightArgs {
    /// What the profile is symmetric about.
    ///
    /// A site (a^1), or the bond of the paper's run (a^2).
    #[arg(long, value_name = "C", value_enum, default_value_t = Center::Bond)]
    pub(crate) center: Center,
    /// Size: beads start at 2 epsilon a_n.
    #[arg(long, value_name = "E", default_value = "0.01", allow_negative_numbers = true)]
    pub(crate) epsilon: f64,
    /// Mass ratio resonator to bead, positive.
    ///
    /// inf for resonators at rest.
    #[arg(long, value_name = "R", default_value = "1000", allow_negative_numbers = true)]
    pub(crate) rho: f64,
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 1.01 to 10.
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive.
    #[arg(long, value_name = "K", default_value = "1", allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Number of sites.
    ///
    /// With a bond in the middle if even, with a site if odd.
    #[arg(long, value_name = "N", default_value_t = 40, allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// What holds the ends.
    #[arg(long, value_name = "B", value_enum, default_value_t = Boundary::Free)]
    pub(crate) boundary: Boundary,
    /// End time, in units of time [default: 80 T].
    ///
    /// T = 2 pi/omega_0 in units of 1/sqrt(kappa).
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Samples a period, from which largest values are taken.
    ///
    /// Of T_b, from 1 to 1000; also for the time at which energy has left.
    #[arg(long, value_name = "M", default_value_t = 20, allow_negative_numbers = true)]
    pub(crate) samples_per_period: u32,
    /// Integrator; `hertzchain integrators` lists all.
    ///
    /// One that takes a tolerance.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(crate) integrator: String,
    /// Tolerance, from 1e-15 to 0.1.
    ///
    /// For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value = "1e-10", allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: breather.json, norms.csv, periods.csv, profiles.csv and forces.csv.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct TrivialArgs {
    /// Name of a built-in scene, or a TOML file.
    ///
    /// With an initial state of kind trivial-breather, or one that is such.
    #[arg(default_value = "trivial-breather")]
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) set: SetArgs,
    /// Amplitudes a_n, separated by commas [default: the scene's].
    ///
    /// At least zero; as many sites as amplitudes.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub(crate) amplitudes: Vec<f64>,
    /// Phases phi_n, separated by commas [default: the scene's].
    ///
    /// In radians.
    #[arg(
        long,
        value_name = "A,B,..",
        value_delimiter = ',',
        conflicts_with = "phase_step_over_pi",
        allow_negative_numbers = true
    )]
    pub(crate) phases: Vec<f64>,
    /// The same (phi_n - phi_{n-1}) / pi for all [default: the scene's].
    ///
    /// 1 for neighbours in antiphase.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) phase_step_over_pi: Option<f64>,
    /// Offsets d_n, separated by commas [default: the scene's].
    ///
    /// Nondecreasing: how much the mean positions rise beyond what contacts demand.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', conflicts_with_all = ["means", "gap"], allow_negative_numbers = true)]
    pub(crate) offsets: Vec<f64>,
    /// Mean positions b_n, separated by commas [default: the scene's].
    ///
    /// Refused where beads would press.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', conflicts_with = "gap", allow_negative_numbers = true)]
    pub(crate) means: Vec<f64>,
    /// The same gap in all bonds [default: the scene's].
    ///
    /// Beyond what contacts demand, at least zero.
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    pub(crate) gap: Option<f64>,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Integrator; `hertzchain integrators` lists all.
    ///
    /// One that takes a tolerance, to hold the closed form against.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(crate) integrator: String,
    /// Tolerance, from 1e-15 to 0.1.
    ///
    /// For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value = "1e-10", allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: breather.json, sites.csv and deviation.csv.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The ring and the breather on it.
#[derive(Args)]
pub(crate) struct RingArgs {
    /// Number of sites.
    ///
    /// Of the ring, n = -N .. N: odd, from 3 to 255. Weak quartets, and how many there are, depend on it.
    #[arg(long, value_name = "N", default_value_t = 41, allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 1.01 to 10.
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive.
    #[arg(long, value_name = "K", default_value = "1", allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Mass ratio resonator to bead, positive.
    ///
    /// Finite.
    #[arg(long, value_name = "R", default_value_t = 1.0 / 3.0, allow_negative_numbers = true)]
    pub(crate) rho: f64,
    /// Vertical centre of the background (eq:center).
    #[arg(long, value_name = "C", default_value = "0", allow_negative_numbers = true)]
    pub(crate) c_x: f64,
    /// What Newton's method solves.
    #[arg(long, value_name = "F", value_enum, default_value_t = Formulation::HalfPeriod)]
    pub(crate) formulation: Formulation,
    /// Tolerance, from 1e-15 to 0.1.
    ///
    /// Of the flow, relative to the size of the state.
    #[arg(long, value_name = "T", default_value = "1e-13", allow_negative_numbers = true)]
    pub(crate) tol: f64,
}

#[derive(Args)]
pub(crate) struct DarkBreatherArgs {
    /// What the profile is symmetric about.
    ///
    /// The kink is on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = Center::Site)]
    pub(crate) center: Center,
    /// Frequency of the breather, in radians per unit of time.
    ///
    /// Above omega = sqrt(kappa (1 + 1/rho)) [default: 1.025 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) omega_b: Option<f64>,
    #[command(flatten)]
    pub(crate) ring: RingArgs,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// File: dark-breather.json.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ContinueArgs {
    /// What the profile is symmetric about.
    ///
    /// The kink is on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = Center::Site)]
    pub(crate) center: Center,
    /// What varies: omega_b, rho, kappa, alpha or c_x.
    #[arg(long, value_name = "P", default_value = "omega_b")]
    pub(crate) parameter: String,
    /// Where it begins [default for omega_b: 1.005 omega].
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// Where it ends [default for omega_b: 1.05 omega].
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Its largest change from point to point.
    ///
    /// [default: a hundredth of the range]
    #[arg(long, value_name = "DP", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Points at most, old ones too.
    #[arg(long, value_name = "N", default_value_t = 1000, allow_negative_numbers = true)]
    pub(crate) points: usize,
    /// Count the way by the parameter, not by the arclength.
    ///
    /// Such a branch ends at a fold.
    #[arg(long)]
    pub(crate) natural: bool,
    /// Do not locate collisions of multipliers that stay below 1 + WEAK.
    ///
    /// In modulus.
    #[arg(long, value_name = "WEAK", default_value = "0.01", allow_negative_numbers = true)]
    pub(crate) weak: f64,
    /// Frequency of the breather, in radians per unit of time.
    ///
    /// Where another parameter varies [default: 1.025 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) omega_b: Option<f64>,
    /// Go on with what this file, or the file in this folder, has kept.
    ///
    /// A file branch.npz, from its last point: to another --to, by another --step; multipliers and bifurcations are computed
    /// anew. The results are written beside it unless --out says where.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["center", "parameter", "from", "natural", "weak", "omega_b", "sites", "alpha", "kappa", "rho", "c_x", "formulation", "tol"])]
    pub(crate) resume: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) ring: RingArgs,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: branch.json, branch.csv and branch.npz; the last is written every 20 points or 10 s as well. With --resume and
    /// without --out, the files go to the folder of the file that is gone on with.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct DoubledArgs {
    /// Frequency of the breather, in radians per unit of time.
    ///
    /// Of the whole period where the branch is to end, about half of that of the main branch.
    #[arg(long, value_name = "W", default_value = "1.056", allow_negative_numbers = true)]
    pub(crate) omega_b: f64,
    /// Where the main branch is left without a period doubling.
    ///
    /// [default: 1.05 omega]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) most: Option<f64>,
    /// Largest change of the frequency from point to point.
    ///
    /// Of the main branch; half of it on the doubled one.
    #[arg(long, value_name = "DW", default_value = "0.002", allow_negative_numbers = true)]
    pub(crate) step: f64,
    /// File branch.npz of the main branch [default: it is followed here].
    ///
    /// One which `breather continue --center bond` has written.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["most", "sites", "alpha", "kappa", "rho", "c_x", "formulation", "tol"])]
    pub(crate) branch: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) ring: RingArgs,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: branch.json, branch.csv and branch.npz.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct EvolveArgs {
    /// File dark-breather.json or branch.npz.
    ///
    /// dark-breather.json of `breather dark`, or branch.npz of `breather continue` or `breather doubled` with --point or
    /// --at.
    pub(crate) orbit: PathBuf,
    /// Point of the branch, counted from 0; from the last, -1, if negative.
    #[arg(long, value_name = "K", conflicts_with = "at", allow_negative_numbers = true)]
    pub(crate) point: Option<i64>,
    /// Value of the parameter: the nearest point of the branch.
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// End time, in units of time.
    ///
    /// Rounded down to whole periods.
    #[arg(long, value_name = "T", default_value = "1200", allow_negative_numbers = true)]
    pub(crate) until: f64,
    /// Largest change of the start along a mode [default: none].
    ///
    /// In units of the orbit's amplitude, of either sign.
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true)]
    pub(crate) kick: Option<f64>,
    /// Multiplier along whose eigenvector the kick is.
    ///
    /// Counted from 0 as `breather dark --json` lists them: the largest modulus first.
    #[arg(long, value_name = "K", default_value_t = 0, requires = "kick")]
    pub(crate) mode: usize,
    /// Tolerance, from 1e-15 to 0.1.
    ///
    /// Of the run, relative to the size of the state.
    #[arg(long, value_name = "T", default_value = "1e-13", allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: evolution.json, evolution.csv, evolution-x.csv and evolution-y.csv (largest strains in time), evolution.png.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}
