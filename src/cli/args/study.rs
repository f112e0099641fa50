//! Studies as commands.

use crate::{
    cli::runner::Told,
    study::{
        Bound, BoundaryWave, Charts, DimerOptions, DisorderOptions, Drift, EndDriven, ImpurityOptions, LifetimeOptions,
        OrderOptions, ScalingOptions, TaperOptions, TheoremOptions,
    },
};
use clap::{Args, Subcommand};

#[derive(Args)]
pub(crate) struct StudyArgs {
    #[command(subcommand)]
    pub(crate) action: StudyAction,
}

#[derive(Subcommand)]
pub(crate) enum StudyAction {
    /// Measure the order of every method through contacts.
    ///
    /// Methods that cross contacts, land on them, correct for them, and that are regularised:
    /// errors of the state and of its derivative by the initial state, and their slopes beside
    /// theory.
    #[command(after_long_help = "Example:\n  hertzchain study order --alpha 2 --out out/order")]
    Order(Told<OrderOptions>),
    /// Measure run time per bond and period against the number of sites.
    #[command(after_long_help = "Example:\n  hertzchain study scaling --sites 50,500 --out out/scaling")]
    Scaling(Told<ScalingOptions>),
    /// Measure how the energy error grows with time.
    #[command(after_long_help = "Example:\n  hertzchain study drift --periods 1e5 --out out/drift")]
    Drift(Told<Drift>),
    /// Chart the stability of the integrators over extreme chains.
    ///
    /// Over light resonators and resonances, contact stiffness, exponent, length and run length.
    /// Every point is a method on a variant of the chain: stable, drifting or lost, its energy
    /// error, the largest step that keeps it below 1e-3 and 1e-6, and what that costs. With --out
    /// points are kept as they are computed: a run that was killed goes on where it was.
    #[command(after_long_help = "\
Example:
  hertzchain study stability --charts light,resonances --quick \\
      --integrators verlet,strang-linear,collocation --out out/stability")]
    Stability(Told<Charts>),
    /// Theorem 1 as an experiment that could fail.
    ///
    /// Does the DpS equation describe the chain with heavy resonators as well, and for as long, as
    /// it says? Runs the chain with kappa = 1 and free ends at each epsilon, takes the suprema over
    /// 0 <= t <= T epsilon^(1-alpha) of the four errors (estimu), (estimv) in l_1, l_2 and l_inf
    /// over samples, divides them by epsilon^alpha (u with u', v) and epsilon^(2 alpha-1) (v'), and
    /// gives the local slopes d ln sup / d ln epsilon. Exit code 1 if the outcome contradicts the
    /// theorem: its law of rho, and the verdict "violated".
    #[command(after_long_help = theorem_help())]
    Theorem(Told<TheoremOptions>),
    /// Measure how long bright breathers live, over a map.
    ///
    /// The breather u(0) = 2 epsilon a, over its size epsilon and the mass ratio rho.
    ///
    /// Three criteria, each with its own time; a run is followed until all are met or to the cap.
    /// `energy`: the core, the fewest sites that hold 0.999 of the sum of a_n^2, has less than 0.9
    /// of the energy. `distance`: |A - A~|_1/|A~|_1 is above 0.5, A = u + i u' of the chain and of
    /// the ansatz u~ = 2 epsilon a cos(Omega_b t); the phase counts, and a drift of it by half a
    /// radian suffices, long before anything is radiated. `frequency`: the central bead against its
    /// resonator, over four periods, swings with a frequency nearer to omega = sqrt(1 + 1/rho) than
    /// to Omega_b. A run that does not get there says: not before t.
    ///
    /// Each point has a fate. `radiates`: the core falls below 0.9 of the energy while its bonds
    /// are at work. `decouples`: before that, bonds of the core come to be closed less than 1/3 of
    /// the time: gaps open, sites swing for themselves, energy stays. `persists`: neither before
    /// the cap.
    ///
    /// With --out points are kept as they are computed, in lifetimes.store: a run that was killed
    /// goes on where it was, and another criterion or a larger map computes only what is new.
    #[command(after_long_help = "\
Example:
  hertzchain study lifetimes --epsilons 0.01,0.1 --rhos 1e3,1e4 --out out/map")]
    Lifetimes(Told<LifetimeOptions>),
    /// Measure how a pulse decays in dimers, over the mass ratio.
    ///
    /// A chain of alternating heavy and light beads, struck at one end. The transmission is the
    /// largest contact force far from that end over the one near it. Where it has a maximum of 1
    /// there is a solitary wave.
    #[command(after_long_help = "Example:\n  hertzchain study dimer --from 0.3 --to 0.4 --ratios 20 --out out/dimer")]
    Dimer(Told<DimerOptions>),
    /// Measure how one bead of another mass scatters a solitary wave.
    ///
    /// Shares of its energy behind the bead, before it and in it, long after it has passed, over the
    /// mass; and the frequency with which a light bead rings between its neighbours.
    #[command(
        after_long_help = "Example:\n  hertzchain study impurity --from 0.1 --to 10 --ratios 20 --out out/impurity"
    )]
    Impurity(Told<ImpurityOptions>),
    /// Measure how a pulse grows in tapered chains.
    ///
    /// Spheres of one material whose radii are a geometric sequence, from growing to shrinking ones:
    /// growth of the velocity from sphere to sphere, and what the pulse keeps of its energy.
    #[command(after_long_help = "Example:\n  hertzchain study taper --from 0.95 --to 1 --tapers 11 --out out/taper")]
    Taper(Told<TaperOptions>),
    /// Measure how a pulse decays in chains with masses drawn at random.
    ///
    /// The energy of a solitary wave against distance, over many chains, for several strengths of the
    /// disorder.
    ///
    /// With --out every chain is kept as soon as it was run, in disorder.store: a run that was killed
    /// goes on where it was.
    #[command(
        after_long_help = "Example:\n  hertzchain study disorder --strengths 0.2,0.4 --chains 50 --out out/disorder"
    )]
    Disorder(Told<DisorderOptions>),
    /// Search for dark breathers in damped chains driven at both ends.
    ///
    /// Chains with resonators, drag and dashpots, whose end beads move in phase or in antiphase, at
    /// frequencies above omega. Each is followed as a periodic orbit from small drive amplitudes,
    /// past folds; the table says from which amplitude on orbits are dark breathers, from which on
    /// they are stable, and whether a chain at rest comes to them.
    #[command(after_long_help = "\
Example:
  hertzchain study end-driven --lengths 10 --omegas 2.05 --out out/end-driven")]
    EndDriven(Told<EndDriven>),
    /// Launch travelling waves into a chain from one end.
    ///
    /// A chain under a static overlap whose first bead is moved at frequencies above omega. The wave
    /// number that is measured along the chain is held against that of the first-order wave of the
    /// paper with the same frequency, amplitude and mean strain.
    #[command(after_long_help = "\
Example:
  hertzchain study boundary-wave --omegas 2.006 --drive 0.02 --out out/boundary-wave")]
    BoundaryWave(Told<BoundaryWave>),
}

/// The rule of the verdict, and an example.
fn theorem_help() -> String {
    format!(
        "Verdict of each error in each norm. {}\n\n\
         Example, resonators lighter than the theorem asks for:\n  \
         hertzchain study theorem --rho-law 'eps^-(alpha-1)' --alpha 2",
        Bound::RULE
    )
}
