//! The raw flags.

mod breathers;
mod methods;
mod modulation;
mod paper;

pub(super) use breathers::*;
pub(super) use methods::*;
pub(super) use modulation::*;
pub(super) use paper::*;

use crate::dps::Center;
use clap::{Parser, Subcommand, ValueEnum};
use hertzchain_integrators::Instructions;

/// Nonlinear waves in locally resonant Hertzian chains: which integrator buys which error for which run time.
///
/// All quantities are dimensionless, in the units of the paper (bead mass 1, contact constant 1).
#[derive(Parser)]
#[command(version, about, arg_required_else_help = true)]
pub(super) struct Cli {
    /// Vector instructions of inner loops: portable, avx2 or avx512 [default: the widest of this machine]. Loops have the same bits with each.
    #[arg(long, global = true, value_name = "SET", value_parser = instructions, display_order = 1000)]
    pub(super) instructions: Option<Instructions>,
    #[command(subcommand)]
    pub(super) command: Command,
}

fn instructions(text: &str) -> Result<Instructions, String> {
    let named = Instructions::ALL.into_iter().find(|set| set.to_string() == text);
    let set = named.ok_or_else(|| format!("one of {}", Instructions::ALL.map(|set| set.to_string()).join(", ")))?;
    if set.available() { Ok(set) } else { Err("this machine does not have them".to_owned()) }
}

#[derive(Subcommand)]
pub(super) enum Command {
    /// Compare integrators on a scene: error against run time, as a table, a CSV and a PNG.
    Compare(CompareArgs),
    /// Run one scene with one integrator.
    ///
    /// Example, in legs that are kept, and gone on with: hertzchain run tw-q15 --checkpoint 10 --out out/tw; hertzchain run --resume out/tw
    Run(RunArgs),
    /// Measure the order of every method through contacts: crossing them, landing on them, regularised.
    Order(OrderArgs),
    /// Measure run time per bond and period against the number of sites.
    Scaling(ScalingArgs),
    /// Measure how the energy error grows with time.
    Drift(DriftArgs),
    /// The modulation equations of small oscillations, and what follows from them.
    Dps(DpsArgs),
    /// Breathers: the long-lived bright one against its ansatz, and the trivial one, whose beads never touch.
    Breather(BreatherArgs),
    /// Compute a dark breather as an exact periodic orbit, with its Floquet multipliers.
    Dark(DarkBreatherArgs),
    /// Follow a branch of dark breathers in one parameter, with its multipliers and bifurcations.
    ///
    /// Example, stopped after 20 points and gone on with: hertzchain continue --points 20 --out out/branch; hertzchain continue --resume out/branch/branch.npz
    Continue(ContinueArgs),
    /// Follow the branch of doubled period that leaves the bond-centred dark breathers.
    Doubled(DoubledArgs),
    /// Let a dark breather go, kicked along one of its modes or not: does it come back, and where does its kink go?
    ///
    /// Example: hertzchain dark --center bond --omega-b 2.05 --out out/dark; hertzchain evolve out/dark/dark-breather.json --until 1200 --kick 1e-3 --mode 0
    Evolve(EvolveArgs),
    /// Chart the stability of the integrators: light resonators and resonances, contact stiffness, exponent, length, run length.
    ///
    /// Every point is a method on a variant of the chain: stable, drifting or lost, its energy error, the largest step that keeps it below 1e-3 and 1e-6, and
    /// what that costs. All quantities are dimensionless. With --out points are kept as they are computed: a run that was killed goes on where it was.
    /// Example: hertzchain stability --charts light,resonances --integrators verlet,strang-linear,collocation --out out/stability
    Stability(StabilityChartsArgs),
    /// Run a travelling wave on the chain and hold it against its ansatz; perturb it and see whether it is stable.
    Wave(WaveArgs),
    /// Theorem 1 as an experiment that could fail: does the DpS equation describe the chain with heavy resonators as well, and for as long, as it says?
    ///
    /// Runs the chain with kappa = 1 and free ends at each epsilon, takes the suprema over 0 <= t <= T epsilon^(1-alpha) of the four errors (estimu), (estimv) in
    /// l_1, l_2 and l_inf over samples, divides them by epsilon^alpha (u with u', v) and epsilon^(2 alpha-1) (v'), and gives the local slopes d ln sup / d ln
    /// epsilon. All quantities are dimensionless. Exit code 1 if the outcome contradicts the theorem: its law of rho, and the verdict "violated".
    #[command(after_long_help = theorem_help())]
    Theorem(TheoremArgs),
    /// Measure how long the long-lived bright breather u(0) = 2 epsilon a lives, over a map of its size epsilon and the mass ratio rho.
    ///
    /// Three criteria, each with its own time; a run is followed until all are met or to the cap. `energy`: the core, the fewest sites that hold 0.999 of the sum of
    /// a_n^2, has less than 0.9 of the energy. `distance`: |A - A~|_1/|A~|_1 is above 0.5, A = u + i u' of the chain
    /// and of the ansatz u~ = 2 epsilon a cos(Omega_b t); the phase counts, and a drift of it by half a radian suffices, long before anything is radiated. `frequency`: the central bead against its resonator, over four periods,
    /// swings with a frequency nearer to omega = sqrt(1 + 1/rho) than to Omega_b. A run that does not get there says: not before t.
    ///
    /// Each point has a fate. `radiates`: the core falls below 0.9 of the energy while its bonds are at work. `decouples`: before that, bonds of the core come to be
    /// closed less than 1/3 of the time: gaps open, sites swing for themselves, energy stays. `persists`: neither before the cap.
    ///
    /// With --out points are kept as they are computed, in lifetimes.store: a run that was killed goes on where it was, and another criterion or a larger map
    /// computes only what is new. Example: hertzchain lifetimes --epsilons 0.01,0.1 --rhos 1e3,1e4,1e5 --out out/lifetimes
    Lifetimes(LifetimesArgs),
    /// Hold every number in the text of the paper's Sec. 3 to 7 against ours: what it says, what we get, the verdict, and why if they differ.
    ///
    /// Exit code 0: every verdict is the one that is known, also where the paper is known to differ, and our numbers there are what they were. Exit code 1:
    /// one is not, or a run failed.
    Verify(VerifyArgs),
    /// Compute the figures of the paper: pictures, and the numbers behind them as CSV.
    Figures(FiguresArgs),
    /// Run everything in its short form and write one self-contained HTML page: tables, pictures, captions, the machine and the version.
    ///
    /// Example: hertzchain report --out out/report; hertzchain report --only compare,order
    Report(ReportArgs),
    /// List the built-in scenes, or show one as TOML.
    Scenes(ScenesArgs),
    /// List the integrators with order, stages and source.
    Integrators(IntegratorsArgs),
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum CenterArg {
    Site,
    Bond,
}

impl From<CenterArg> for Center {
    fn from(center: CenterArg) -> Self {
        match center {
            CenterArg::Site => Self::Site,
            CenterArg::Bond => Self::Bond,
        }
    }
}
