//! Studies as commands.

use crate::{
    cli::runner::StudyCommand,
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
    /// Compares methods that step across contacts, land on them, correct for them, or integrate in
    /// a regularised variable. Measures errors of the state and of its derivative with respect to
    /// the initial state, and prints their slopes beside the orders of theory.
    #[command(after_long_help = "Example:\n  hertzchain study order --alpha 2 --out out/order")]
    Order(StudyCommand<OrderOptions>),
    /// Measure run time per bond and period against the number of sites.
    #[command(after_long_help = "Example:\n  hertzchain study scaling --sites 50,500 --out out/scaling")]
    Scaling(StudyCommand<ScalingOptions>),
    /// Measure how the energy error grows with time.
    #[command(after_long_help = "Example:\n  hertzchain study drift --periods 1e5 --out out/drift")]
    Drift(StudyCommand<Drift>),
    /// Chart the stability of the integrators over extreme chains.
    ///
    /// Varies the mass ratio, the stiffness and the exponent of contacts, and the length of the
    /// chain and of the run; also charts resonances. A point is one
    /// method on one variant of the chain: stable, drifting or lost (its energy error exceeds 1, or
    /// the run failed), its energy error, the largest steps that keep the error below 1e-3 and
    /// below 1e-6, and their cost.
    #[command(after_long_help = "\
Example:
  hertzchain study stability --charts light,resonances --quick \\
      --integrators verlet,strang-linear,collocation --out out/stability")]
    Stability(StudyCommand<Charts>),
    /// Test Theorem 1 of the paper by numerical experiment.
    ///
    /// Does the DpS equation describe the chain with heavy resonators as well, and for as long, as
    /// the theorem says? Runs the chain with kappa = 1 and free ends at each epsilon, takes the
    /// suprema over 0 <= t <= T epsilon^(1-alpha) of the four errors (estimu), (estimv) in l_1, l_2
    /// and l_inf over samples, divides them by epsilon^alpha (u with u', v) and epsilon^(2 alpha-1)
    /// (v'), and gives the local slopes d ln sup / d ln epsilon. Exit code 1 if the outcome
    /// contradicts the theorem: its law of rho, and the verdict "violated".
    #[command(after_long_help = theorem_help())]
    Theorem(StudyCommand<TheoremOptions>),
    /// Measure how long bright breathers live, over size and mass ratio.
    ///
    /// Runs the chain from the breather u(0) = 2 epsilon a at every size epsilon and every mass
    /// ratio rho.
    ///
    /// Three criteria give one lifetime each; a run ends when all three are met, or at the cap
    /// (--until). `energy`: the core, the fewest sites that hold 0.999 of the sum of a_n^2, has
    /// less than 0.9 of the energy. `distance`: |A - A~|_1/|A~|_1 is above 0.5, where A = u + i u'
    /// is that of the chain, and A~ that of the ansatz u~ = 2 epsilon a cos(Omega_b t). The phase
    /// counts: a drift of it by half a radian suffices, long before anything is radiated.
    /// `frequency`: over four periods, the central bead oscillates against its resonator with a
    /// frequency nearer to omega = sqrt(1 + 1/rho) than to Omega_b. Where a run does not meet a
    /// criterion, the table says: not before t.
    ///
    /// Each point has a fate. `radiates`: the core falls below 0.9 of the energy while its bonds
    /// are closed at least 1/3 of the time. `decouples`: before that, bonds of the core come to be
    /// closed less than 1/3 of the time: gaps open, each site oscillates on its own, and the energy
    /// stays. `persists`: neither before the cap.
    ///
    /// Another criterion or a larger map computes only what is new.
    #[command(after_long_help = "\
Example:
  hertzchain study lifetimes --epsilons 0.01,0.1 --rhos 1e3,1e4 --out out/map")]
    Lifetimes(StudyCommand<LifetimeOptions>),
    /// Measure how a pulse decays in dimers, over the mass ratio.
    ///
    /// A chain of alternating heavy and light beads is struck at one end. The transmission is the
    /// largest contact force far from that end, divided by the one near it. A mass ratio at which
    /// it has a maximum of 1 has a solitary wave.
    #[command(after_long_help = "Example:\n  hertzchain study dimer --from 0.3 --to 0.4 --points 20 --out out/dimer")]
    Dimer(StudyCommand<DimerOptions>),
    /// Measure how one bead of another mass scatters a solitary wave.
    ///
    /// For every mass of the bead: the shares of the energy that are behind the bead, before it and
    /// in it long after the wave has passed, and the frequency at which a light bead oscillates
    /// between its neighbours.
    #[command(
        after_long_help = "Example:\n  hertzchain study impurity --from 0.1 --to 10 --points 20 --out out/impurity"
    )]
    Impurity(StudyCommand<ImpurityOptions>),
    /// Measure how a pulse grows in tapered chains.
    ///
    /// Spheres of one material whose radii are a geometric sequence, shrinking or growing: the
    /// growth of the velocity from sphere to sphere, and the share of its energy that the pulse
    /// keeps.
    #[command(after_long_help = "Example:\n  hertzchain study taper --from 0.95 --to 1 --points 11 --out out/taper")]
    Taper(StudyCommand<TaperOptions>),
    /// Measure how a pulse decays in chains with masses drawn at random.
    ///
    /// The energy of a solitary wave against distance, over many chains, for several strengths of
    /// the disorder.
    #[command(
        after_long_help = "Example:\n  hertzchain study disorder --strengths 0.2,0.4 --chains 50 --out out/disorder"
    )]
    Disorder(StudyCommand<DisorderOptions>),
    /// Search for dark breathers in damped chains driven at both ends.
    ///
    /// Chains with resonators, drag and dashpots, whose end beads move in phase or in antiphase, at
    /// frequencies above omega. The periodic orbit of each is followed from small drive amplitudes
    /// on, past folds. The table says from which amplitude on orbits are dark breathers, from which
    /// on they are stable, and whether a chain that starts at rest reaches them.
    #[command(after_long_help = "\
Example:
  hertzchain study end-driven --lengths 10 --omegas 2.05 --out out/end-driven")]
    EndDriven(StudyCommand<EndDriven>),
    /// Launch travelling waves into a chain from one end.
    ///
    /// The first bead of a chain under static overlap is moved at frequencies above omega. The wave
    /// number measured along the chain is compared with that of the first-order wave of the paper
    /// with the same frequency, amplitude and mean strain.
    #[command(after_long_help = "\
Example:
  hertzchain study boundary-wave --omegas 2.006 --drive 0.02 --out out/boundary-wave")]
    BoundaryWave(StudyCommand<BoundaryWave>),
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
