//! Flags of waves and of the modulation equations.

use super::CenterArg;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct WaveArgs {
    /// Name of a built-in scene, or a TOML file, with an initial state of kind travelling-wave.
    pub(crate) scene: String,
    /// Perturb real and imaginary part of each amplitude by up to this share of it, from 0 (none) to below 1 [default: the scene's].
    #[arg(long, value_name = "Z", allow_negative_numbers = true)]
    pub(crate) zeta: Option<f64>,
    /// Seed of the perturbation [default: the scene's, else 1].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Run this many perturbed waves, from that seed on, on all cores, and give the spread of their growth: from 1 to 10^4 [default: 1].
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub(crate) seeds: Option<u32>,
    /// An integrator that takes a tolerance; `hertzchain integrators` lists all.
    #[arg(long, value_name = "NAME", default_value = "collocation")]
    pub(crate) integrator: String,
    /// Tolerance. For collocation: of the whole run, relative to the size of the state. For dop853: of a step.
    #[arg(long, value_name = "T", default_value_t = 1e-10, allow_negative_numbers = true)]
    pub(crate) tol: f64,
    /// Samples a period of the wave, from 2 to 1000, for errors in time and their largest value; the end is one of them.
    #[arg(long, value_name = "M", default_value_t = 50, allow_negative_numbers = true)]
    pub(crate) samples_per_period: u32,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Folder for wave.json, errors.csv, profile.csv, and of perturbed waves envelope.csv, ensemble.csv and spread.csv [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct DpsArgs {
    #[command(subcommand)]
    pub(crate) action: DpsAction,
}

#[derive(Subcommand)]
pub(crate) enum DpsAction {
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
pub(crate) struct HomoclinicArgs {
    /// Exponent of the contact force, from 1.01 to 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// What the profile is symmetric about.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(crate) center: CenterArg,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct TheoremArgs {
    /// Exponent of the contact force, above 1 and at most 10 (breathers: from 1.01); 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// T: runs end at t = T epsilon^(1-alpha), at most 1e8; in units of the slow time, up to 1000.
    #[arg(long, value_name = "T", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) horizon: f64,
    /// Mass ratio: eps^-2(alpha-1), the least that the theorem allows; eps^-(alpha-1), which is less; or a number for all epsilon, inf for Newton's cradle.
    #[arg(long, value_name = "LAW", default_value = "eps^-2(alpha-1)", allow_hyphen_values = true)]
    pub(crate) rho_law: String,
    /// A(0): the breather about a bond or a site, or (xi_n + i eta_n) e^(-n^2/4) with random xi_n, eta_n in (-1, 1).
    #[arg(long, value_name = "I", value_enum, default_value_t = InitialArg::Bond)]
    pub(crate) initial: InitialArg,
    /// C_i: departure of the initial state from the ansatz, in a random direction; on the boundary of the set (condciu), (condciv) in l_1, and so inside it
    /// in all norms. 0: exactly on the ansatz.
    #[arg(long, value_name = "C", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) c_i: f64,
    /// Seed of a generic A(0) and of the departure [default: 1].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Sizes between 0 and 1, separated by commas, in any order [default: decades from 0.1 to 1e-6].
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', allow_negative_numbers = true)]
    pub(crate) epsilons: Vec<f64>,
    /// Sites of the chain, up to 1000 [default: those where A(0) is above 1e-16 of its largest value; generic: 21].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) sites: Option<usize>,
    /// Folder for theorem.json, theorem.txt, theorem.csv (suprema) and slopes.csv, and for theorem.store, where every size is kept once it was run: the same
    /// study in the same folder goes on where it was [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum InitialArg {
    Bond,
    Site,
    Generic,
}

#[derive(Args)]
pub(crate) struct DarkArgs {
    /// Where the kink is: on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = CenterArg::Site)]
    pub(crate) center: CenterArg,
    /// Sites of the ring, odd, from 3 to 100001.
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
    /// Mean strain of the background at mu = 1.
    #[arg(long, value_name = "C", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) c: f64,
    /// Frequency of the breather, radians per unit of time, above omega = sqrt(kappa (1 + 1/rho)) [default: 1.005 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) omega_b: Option<f64>,
    /// Folder for dark.csv and dark.json [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct IntegralsArgs {
    /// Exponent of the contact force, above 0 and at most 10; 1.5 for spheres.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive; dimensionless, like all below.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Mean strain of the bond -b + 2 kappa r cos t; all values are zero for b >= 2 kappa r.
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    pub(crate) b: f64,
    /// Amplitude, at least zero.
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub(crate) r: f64,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct StabilityArgs {
    /// A travelling-wave scene, by name or as a TOML file, to take everything below from.
    #[arg(conflicts_with_all = ["alpha", "kappa", "rho", "a", "b", "q_over_pi", "epsilon", "sites"])]
    pub(crate) scene: Option<String>,
    /// Exponent of the contact force, above 0 and at most 10.
    #[arg(long, value_name = "A", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive; dimensionless, like all below.
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Mass ratio, positive; inf for the DpS equation of Newton's cradle, with --b 0.
    #[arg(long, value_name = "R", default_value_t = 1.0 / 3.0, allow_negative_numbers = true)]
    pub(crate) rho: f64,
    /// Amplitude of the wave, positive.
    #[arg(long, value_name = "A", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) a: f64,
    /// Mean strain of the wave, below 2 kappa a.
    #[arg(long, value_name = "B", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) b: f64,
    /// Wave number over pi, with a whole number of waves on the ring.
    #[arg(long, value_name = "Q", default_value_t = 0.2, allow_negative_numbers = true)]
    pub(crate) q_over_pi: f64,
    /// Sizes of the wave, separated by commas: rates per unit of time are those of the first, growth is measured at each.
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', default_values_t = [0.01], allow_negative_numbers = true)]
    pub(crate) epsilon: Vec<f64>,
    /// Sites of the ring, from 2 to 10^4; to be measured at most 1000.
    #[arg(long, value_name = "N", default_value_t = 50, allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// Measure the growth on the full chain as well.
    #[arg(long)]
    pub(crate) measure: bool,
    /// Wave numbers that are measured, spread over those of the ring; the fastest comes on top.
    #[arg(long, value_name = "M", default_value_t = 12, requires = "measure", allow_negative_numbers = true)]
    pub(crate) modes: usize,
    /// Chart the fastest growth over q and b as well.
    #[arg(long)]
    pub(crate) chart: bool,
    /// Folder for stability.csv, stability.json and dps-growth.png, with --measure measured.csv, with --chart chart.csv [default: none].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The rule of the verdict, and an example.
pub(crate) fn theorem_help() -> String {
    format!(
        "Verdict of each error in each norm. {}\n\nExample, resonators lighter than the theorem asks for: hertzchain theorem --rho-law 'eps^-(alpha-1)' --alpha 2",
        crate::experiments::Bound::RULE
    )
}
