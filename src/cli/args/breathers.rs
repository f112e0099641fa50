//! Breathers as commands, bright and dark.

use crate::{
    cli::runner::StudyCommand,
    study::{Barrier, Bright, Continue, Dark, Doubled, Evolve, Moving, Trivial},
};
use clap::{Args, Subcommand};

#[derive(Args)]
pub(crate) struct BreatherArgs {
    #[command(subcommand)]
    pub(crate) action: BreatherAction,
}

#[derive(Subcommand)]
pub(crate) enum BreatherAction {
    /// Run a long-lived bright breather and compare it with its ansatz.
    ///
    /// The chain starts from a breather of the modulation (DpS) equation. Prints how far the chain
    /// departs from this ansatz, and how much of the energy stays in the core.
    #[command(after_long_help = "\
Example:
  hertzchain breather bright --center bond --epsilon 0.01 --rho 1000")]
    Bright(StudyCommand<Bright>),
    /// Run an exact breather whose beads never touch.
    ///
    /// Compares the closed form with an integrator; prints gaps and mean contact forces.
    #[command(after_long_help = "\
Example:
  hertzchain breather trivial --amplitudes 0.1,0.2,0.1 --phases 0,1.5,3 --gap 0")]
    Trivial(StudyCommand<Trivial>),
    /// Compute a dark breather as an exact periodic orbit.
    ///
    /// Newton's method finds the orbit on a ring; its Floquet multipliers tell whether it is
    /// stable.
    #[command(after_long_help = "\
Example:
  hertzchain breather dark --center bond --omega-b 2.05 --out out/dark")]
    Dark(StudyCommand<Dark>),
    /// Follow a branch of dark breathers in one parameter.
    ///
    /// Computes the Floquet multipliers of each orbit, and the bifurcations between them.
    #[command(after_long_help = "\
Example, stopped after 20 points and gone on with:
  hertzchain breather continue --max-points 20 --out out/branch
  hertzchain breather continue --resume out/branch/branch.npz")]
    Continue(StudyCommand<Continue>),
    /// Follow the branch of doubled period of dark breathers.
    ///
    /// The branch starts at the period doubling of the bond-centred dark breathers.
    #[command(after_long_help = "Example:\n  hertzchain breather doubled --omega-b 1.056 --out out/doubled")]
    Doubled(StudyCommand<Doubled>),
    /// Run the chain from a dark breather, with or without a kick.
    ///
    /// A kick is along one of the modes of the orbit. After every period the run measures the
    /// return error, which is the distance from the orbit, and the position of the kink.
    #[command(after_long_help = "\
Example:
  hertzchain breather dark --center bond --omega-b 2.05 --out out/dark
  hertzchain breather evolve out/dark/dark-breather.json --kick 1e-3")]
    Evolve(StudyCommand<Evolve>),
    /// Compute the energy barrier between site- and bond-centred dark breathers.
    ///
    /// The Peierls-Nabarro barrier: energies of the two kinks relative to their common background,
    /// at the same frequency, and at the same action and length; also their largest multipliers.
    /// Exit code 1 if an orbit is not found.
    #[command(after_long_help = "\
Examples:
  hertzchain breather barrier --from 2.01 --to 2.1 --out out/barrier
  hertzchain breather barrier --rho 3 --from 1.16 --to 1.35")]
    Barrier(StudyCommand<Barrier>),
    /// Compute moving dark breathers as exact orbits, and run a kicked one.
    ///
    /// A moving breather is a relative periodic orbit: after K + 1/2 periods of the background (see
    /// --turns) the chain has its initial state again, moved on by a site. Prints its tails and
    /// relative multipliers, and for comparison the motion of a breather at rest that is kicked.
    /// Exit code 1 if an orbit is not found.
    #[command(after_long_help = "\
Examples:
  hertzchain breather moving --turns 16,18,22,26 --out out/moving
  hertzchain breather moving --omega-b 2.088,2.092,2.096 --turns 11 --until 0")]
    Moving(StudyCommand<Moving>),
}
