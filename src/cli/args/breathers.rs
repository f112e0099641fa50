//! Breathers as commands, bright and dark.

use crate::{
    cli::runner::Told,
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
    /// The long-lived bright breather on the chain, against its ansatz.
    ///
    /// The breather of the DpS equation put on the chain: how far the chain gets from it, and what
    /// becomes of it.
    #[command(after_long_help = "\
Example:
  hertzchain breather bright --center bond --epsilon 0.01 --rho 1000")]
    Bright(Told<Bright>),
    /// An exact solution whose beads never touch.
    ///
    /// Closed form against an integrator, gaps, mean contact forces.
    #[command(after_long_help = "\
Example:
  hertzchain breather trivial --amplitudes 0.1,0.2,0.1 --phases 0,1.5,3 --gap 0")]
    Trivial(Told<Trivial>),
    /// Compute a dark breather as an exact periodic orbit.
    ///
    /// With its Floquet multipliers.
    #[command(after_long_help = "\
Example:
  hertzchain breather dark --center bond --omega-b 2.05 --out out/dark")]
    Dark(Told<Dark>),
    /// Follow a branch of dark breathers in one parameter.
    ///
    /// With its multipliers and bifurcations.
    #[command(after_long_help = "\
Example, stopped after 20 points and gone on with:
  hertzchain breather continue --points 20 --out out/branch
  hertzchain breather continue --resume out/branch/branch.npz")]
    Continue(Told<Continue>),
    /// Follow the branch of doubled period of dark breathers.
    ///
    /// The branch that leaves the bond-centred dark breathers.
    #[command(after_long_help = "Example:\n  hertzchain breather doubled --omega-b 1.056 --out out/doubled")]
    Doubled(Told<Doubled>),
    /// Let a dark breather go, kicked along one of its modes or not.
    ///
    /// Does it come back, and where does its kink go?
    #[command(after_long_help = "\
Example:
  hertzchain breather dark --center bond --omega-b 2.05 --out out/dark
  hertzchain breather evolve out/dark/dark-breather.json --kick 1e-3")]
    Evolve(Told<Evolve>),
    /// The energy barrier between dark breathers about a site and about a bond.
    ///
    /// The Peierls-Nabarro barrier: energies of the two kinks relative to their common background,
    /// at the same frequency, and at the same action and length; their largest multipliers. Exit
    /// code 1 if an orbit is not found.
    #[command(after_long_help = "\
Examples:
  hertzchain breather barrier --from 2.01 --to 2.1 --out out/barrier
  hertzchain breather barrier --rho 3 --from 1.16 --to 1.35")]
    Barrier(Told<Barrier>),
    /// Moving dark breathers as exact orbits, and a kicked one held against them.
    ///
    /// Relative periodic orbits: the chain, moved on by a site, comes back after so many and a half
    /// periods of the background. With tails, relative multipliers, and the run of a kicked
    /// breather at rest. Exit code 1 if an orbit is not found.
    #[command(after_long_help = "\
Examples:
  hertzchain breather moving --turns 16,18,22,26 --out out/moving
  hertzchain breather moving --omega-b 2.088,2.092,2.096 --turns 11 --until 0")]
    Moving(Told<Moving>),
}
