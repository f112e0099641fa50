//! Waves and the modulation equations as commands.

use crate::{
    cli::runner::StudyCommand,
    study::{ContinueWave, DarkProfiles, Homoclinics, Integrals, ModulationStudy, Solitary, Wanted, Wave},
};
use clap::{Args, Subcommand};

#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct WaveArgs {
    #[command(subcommand)]
    pub(crate) action: Option<WaveAction>,
    #[command(flatten)]
    pub(crate) told: StudyCommand<Wave>,
}

pub(super) const WAVE_EXAMPLES: &str = "\
Examples:
  hertzchain wave tw-q15
  hertzchain wave tw-q15 --zeta 0.01 --seeds 20 --out out/wave
  hertzchain wave modulation tw-q15
  hertzchain wave exact tw-q15";

#[derive(Subcommand)]
pub(crate) enum WaveAction {
    /// Compute which modulations of a wave grow, and how fast.
    ///
    /// Growth rates against the wave number of the modulation, in closed form; with --measure also
    /// those measured on the full chain.
    #[command(after_long_help = "\
Examples:
  hertzchain wave modulation tw-q15
  hertzchain wave modulation --rho 3 --q-over-pi 0.8 --measure --out out/growth")]
    Modulation(StudyCommand<ModulationStudy>),
    /// Compute an exact periodic travelling wave.
    ///
    /// It has the frequency (or the amplitude) and the mean strain of a wave of the modulation
    /// equations. Prints its profile, its Fourier coefficients, its distance from that first-order
    /// ansatz, and its relative multipliers for each Bloch wave number.
    #[command(after_long_help = "\
Examples:
  hertzchain wave exact tw-q15 --out out/exact
  hertzchain wave exact --q-over-pi 0.8 --amplitude 0.1 --sites 40 --json")]
    Exact(StudyCommand<Wanted>),
    /// Follow a branch of exact travelling waves.
    ///
    /// Varies one parameter of the wave or of the chain, past folds. Waves keep their ratio of mean
    /// strain to amplitude unless a mean strain is given. Exit code 1 if the branch is lost before
    /// its end.
    #[command(after_long_help = "\
Examples:
  hertzchain wave continue tw-q15 --to 2.004 --out out/branch
  hertzchain wave continue tw-q15 --vary rho --mean 0.05 --to 3")]
    Continue(StudyCommand<ContinueWave>),
    /// Compute solitary waves, and their tails where resonators move.
    ///
    /// The pulse of the chain without resonators, as an exact wave of a ring and on the infinite
    /// line, and how its overlap decays from the crest; and how strong a wake a pulse leaves in
    /// chains with light resonators. Exit code 1 if a wave is not found.
    #[command(after_long_help = "\
Examples:
  hertzchain wave solitary --out out/solitary
  hertzchain wave solitary --alpha 2 --rhos 0.01,0.02,0.05 --json")]
    Solitary(StudyCommand<Solitary>),
}

#[derive(Args)]
pub(crate) struct DpsArgs {
    #[command(subcommand)]
    pub(crate) action: DpsAction,
}

#[derive(Subcommand)]
pub(crate) enum DpsAction {
    /// Averages of the contact force over an oscillation, and their derivatives.
    ///
    /// g_alpha(b, r) of (eq:aux1), the mean, and h_alpha(b, r) of (eq:aux2), the first harmonic
    /// divided by r.
    #[command(after_long_help = "Example:\n  hertzchain dps integrals --b 0.5 --r 1 --alpha 2")]
    Integrals(StudyCommand<Integrals>),
    /// Homoclinic solutions: profiles of bright breathers.
    ///
    /// They solve the stationary DpS equation.
    #[command(after_long_help = "Example:\n  hertzchain dps homoclinic --center bond")]
    Homoclinic(StudyCommand<Homoclinics>),
    /// Standing waves with a kink: profiles of dark breathers.
    ///
    /// They solve the generalised DpS equations. Also gives the strains from which a dark breather
    /// starts on the chain, to first order.
    #[command(after_long_help = "Example:\n  hertzchain dps dark --center bond --rho 3 --omega-b 1.16")]
    Dark(StudyCommand<DarkProfiles>),
}
