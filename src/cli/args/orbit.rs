//! Orbits of scenes as commands.

use crate::{
    cli::runner::StudyCommand,
    study::{Driven, DrivenContinue, FollowMode},
};
use clap::{Args, Subcommand};

#[derive(Args)]
pub(crate) struct OrbitArgs {
    #[command(subcommand)]
    pub(crate) action: OrbitAction,
}

#[derive(Subcommand)]
pub(crate) enum OrbitAction {
    /// Compute the periodic orbit to which a driven scene leads.
    ///
    /// The orbit is a fixed point of the stroboscopic map. Newton's method starts from the state
    /// that the scene has after some periods. Prints the Floquet multipliers, which may lie inside
    /// and outside the unit circle, and compares their product with Liouville's formula. Exit code
    /// 1 if no orbit is found.
    #[command(after_long_help = "\
Examples:
  hertzchain orbit driven granular-crystal
  hertzchain orbit driven granular-crystal --si
  hertzchain orbit driven granular-crystal --turns 2 --json")]
    Driven(StudyCommand<Driven>),
    /// Follow the orbit of a driven scene in one parameter.
    ///
    /// In the drive's amplitude or frequency, or in the damping, past folds; with multipliers,
    /// folds, period doublings and torus bifurcations, and with the branch that crosses at one of
    /// them. It begins with the scene's own value. Exit code 1 if a branch is lost on its way.
    #[command(after_long_help = "\
Examples:
  hertzchain orbit continue granular-crystal --to 1e-5 --out out/branch
  hertzchain orbit continue --resume out/branch --to 2e-5")]
    Continue(StudyCommand<DrivenContinue>),
    /// Follow a normal mode of a conservative scene from its linear mode on.
    ///
    /// Computes the linear modes about the equilibrium, and follows the periodic orbits that begin
    /// as one of them to larger amplitudes, also beyond the amplitude at which contacts open:
    /// frequency, energy, participation number, Floquet multipliers. Exit code 1 if the branch is
    /// lost on its way.
    #[command(after_long_help = "\
Examples:
  hertzchain orbit mode defect --to 1.5
  hertzchain orbit mode precompressed --linear-mode 5 --to 0.2 --out out/mode")]
    Mode(StudyCommand<FollowMode>),
}
