//! Flags of waves and of the modulation equations.

use super::SetArgs;
use crate::dps::Center;
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct WaveArgs {
    #[command(subcommand)]
    pub(crate) action: Option<WaveAction>,
    /// Name of a built-in scene, or a TOML file.
    ///
    /// With an initial state of kind travelling-wave.
    #[arg(required = true)]
    pub(crate) scene: Option<String>,
    #[command(flatten)]
    pub(crate) set: SetArgs,
    /// Perturb each amplitude by up to this share [default: the scene's].
    ///
    /// Real and imaginary part of each, from 0 (none) to below 1.
    #[arg(long, value_name = "Z", allow_negative_numbers = true)]
    pub(crate) zeta: Option<f64>,
    /// Seed of what is drawn at random [default: the scene's, else 1].
    ///
    /// The perturbation of the wave.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Number of perturbed waves, from that seed on [default: 1].
    ///
    /// From 1 to 10^4; they run on all cores and give the spread of their growth.
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub(crate) seeds: Option<u32>,
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
    /// Samples a period, from which largest values are taken.
    ///
    /// Of the wave, from 2 to 1000; the end is one of them.
    #[arg(long, value_name = "M", default_value_t = 50, allow_negative_numbers = true)]
    pub(crate) samples_per_period: u32,
    /// End time, in units of time [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: wave.json, errors.csv, profile.csv, and of perturbed waves envelope.csv, ensemble.csv and spread.csv.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) const WAVE_EXAMPLES: &str = "\
Examples:
  hertzchain wave tw-q15
  hertzchain wave tw-q15 --zeta 0.01 --seeds 20 --out out/wave
  hertzchain wave modulation tw-q15";

#[derive(Subcommand)]
pub(crate) enum WaveAction {
    /// Which modulations of a wave grow, and how fast.
    ///
    /// In closed form, and with --measure on the full chain.
    #[command(after_long_help = "\
Examples:
  hertzchain wave modulation tw-q15
  hertzchain wave modulation --rho 3 --q-over-pi 0.8 --measure --out out/growth")]
    Modulation(ModulationArgs),
}

#[derive(Args)]
pub(crate) struct ModulationArgs {
    /// Name of a built-in scene, or a TOML file.
    ///
    /// With an initial state of kind travelling-wave, to take all numbers of the wave from.
    #[arg(conflicts_with_all = ["alpha", "kappa", "rho", "a", "b", "q_over_pi", "epsilon", "sites"])]
    pub(crate) scene: Option<String>,
    #[command(flatten)]
    pub(crate) set: SetArgs,
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// Above 0 and at most 10.
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive.
    #[arg(long, value_name = "K", default_value = "1", allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Mass ratio resonator to bead, positive.
    ///
    /// inf for the DpS equation of Newton's cradle, with --b 0.
    #[arg(long, value_name = "R", default_value_t = 1.0 / 3.0, allow_negative_numbers = true)]
    pub(crate) rho: f64,
    /// Amplitude of the wave, positive.
    #[arg(long, value_name = "A", default_value = "1", allow_negative_numbers = true)]
    pub(crate) a: f64,
    /// Mean strain.
    ///
    /// Of the wave, below 2 kappa a.
    #[arg(long, value_name = "B", default_value = "1", allow_negative_numbers = true)]
    pub(crate) b: f64,
    /// Wave number over pi, with a whole number of waves on the ring.
    #[arg(long, value_name = "Q", default_value = "0.2", allow_negative_numbers = true)]
    pub(crate) q_over_pi: f64,
    /// Sizes of the wave, separated by commas.
    ///
    /// Rates per unit of time are those of the first, growth is measured at each.
    #[arg(long, value_name = "E,F,..", value_delimiter = ',', default_values = ["0.01"], allow_negative_numbers = true)]
    pub(crate) epsilon: Vec<f64>,
    /// Number of sites.
    ///
    /// Of the ring, from 2 to 10^4; to be measured at most 1000.
    #[arg(long, value_name = "N", default_value_t = 50, allow_negative_numbers = true)]
    pub(crate) sites: usize,
    /// Measure the growth on the full chain as well.
    #[arg(long)]
    pub(crate) measure: bool,
    /// Number of wave numbers that are measured.
    ///
    /// Spread over those of the ring; the fastest comes on top.
    #[arg(long, value_name = "M", default_value_t = 12, requires = "measure", allow_negative_numbers = true)]
    pub(crate) modes: usize,
    /// Chart the fastest growth over q and b as well.
    #[arg(long)]
    pub(crate) chart: bool,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: stability.csv, stability.json and dps-growth.png, with --measure measured.csv, with --chart chart.csv.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
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
    /// The averaged contact force, its harmonic, and their derivatives.
    ///
    /// g_alpha(b, r) and h_alpha(b, r).
    #[command(after_long_help = "Example:\n  hertzchain dps integrals --b 0.5 --r 1 --alpha 2")]
    Integrals(IntegralsArgs),
    /// Homoclinic solutions: profiles of bright breathers.
    ///
    /// Of the stationary DpS equation.
    #[command(after_long_help = "Example:\n  hertzchain dps homoclinic --center bond")]
    Homoclinic(HomoclinicArgs),
    /// Standing waves with a kink: profiles of dark breathers.
    ///
    /// Of the generalised DpS equations, and the strains that start a dark breather.
    #[command(after_long_help = "Example:\n  hertzchain dps dark --center bond --rho 3 --omega-b 1.16")]
    Dark(DarkArgs),
}

#[derive(Args)]
pub(crate) struct HomoclinicArgs {
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 1.01 to 10.
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// What the profile is symmetric about.
    #[arg(long, value_name = "C", value_enum, default_value_t = Center::Site)]
    pub(crate) center: Center,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct DarkArgs {
    /// What the profile is symmetric about.
    ///
    /// The kink is on the site 0, or on the bond between the sites 0 and 1.
    #[arg(long, value_name = "C", value_enum, default_value_t = Center::Site)]
    pub(crate) center: Center,
    /// Number of sites.
    ///
    /// Of the ring, odd, from 3 to 100001.
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
    /// Mean strain of the background at mu = 1.
    #[arg(long, value_name = "C", default_value = "0", allow_negative_numbers = true)]
    pub(crate) c: f64,
    /// Frequency of the breather, in radians per unit of time.
    ///
    /// Above omega = sqrt(kappa (1 + 1/rho)) [default: 1.005 omega].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) omega_b: Option<f64>,
    /// Write the results to this folder; without it, no file is written.
    ///
    /// Files: dark.csv and dark.json.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct IntegralsArgs {
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// Above 0 and at most 10.
    #[arg(long, value_name = "A", default_value = "1.5", allow_negative_numbers = true)]
    pub(crate) alpha: f64,
    /// Spring constant of the resonators, positive.
    #[arg(long, value_name = "K", default_value = "1", allow_negative_numbers = true)]
    pub(crate) kappa: f64,
    /// Mean strain.
    ///
    /// Of the bond -b + 2 kappa r cos t; all values are zero for b >= 2 kappa r.
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    pub(crate) b: f64,
    /// Amplitude, at least zero.
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub(crate) r: f64,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}
