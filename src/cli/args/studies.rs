//! Commands that run studies.

use super::{Asked, NONE, Row, StudyCommand, commands, examples};
use crate::study::{
    Bands, Barrier, Bound, Bright, Charts, Continue, ContinueWave, Dark, DarkProfiles, Doubled, Drift, Driven,
    DrivenContinue, Evolve, Exact, FollowMode, Homoclinics, Integrals, LifetimeOptions, Modes, ModulationStudy, Moving,
    OrderOptions, Responses, Solitary, TheoremOptions,
};

commands! {
    STUDIES;

    /// Measure the order of every method through contacts.
    ///
    /// Compares methods that step across contacts, land on them, correct for them, or integrate in
    /// a regularised variable. Measures errors of the state and of its derivative with respect to
    /// the initial state, and prints their slopes beside the orders of theory.
    "order": (StudyCommand<OrderOptions>) => "study order --alpha 2 --out out/order";
    /// Compute the bands of a scene: the frequencies of its linear waves.
    ///
    /// Finds the cell of beads that repeats along the chain, and computes the frequencies of the
    /// waves of the infinite chain, resonators included, about its equilibrium: over the phase
    /// theta from a cell to the next, the edges of the bands and the gaps between them.
    "bands": (StudyCommand<Bands>) => "study bands granular-crystal --out out/bands";
    /// Compute the linear modes of a scene.
    ///
    /// Frequencies, participation numbers and shapes of all linear modes of the finite chain about
    /// its static state, resonators included, also of modes with the same frequency.
    "modes": (StudyCommand<Modes>) => "study modes defect --out out/modes";
    /// Compute the linear response of a scene to a drive at one site.
    ///
    /// Gain and phase of chosen beads over the frequency of the drive, with damping, about the
    /// static state of the finite chain.
    "response": (StudyCommand<Responses>) =>
        "study response granular-crystal --out out/response",
        "study response granular-crystal --from 2e4 --to 6e4 --points 3";
    /// Measure how the energy error grows with time.
    "drift": (StudyCommand<Drift>) => "study drift --periods 1e5 --out out/drift";
    /// Chart the stability of the integrators over extreme chains.
    ///
    /// Varies the mass ratio, the stiffness and the exponent of contacts, and the length of the
    /// chain and of the run. A point is one method on one variant of the chain: stable, drifting or
    /// lost (its energy error exceeds 1, or the run failed), its energy error, the largest steps
    /// that keep the error below 1e-3 and below 1e-6, and their cost.
    "stability": (StudyCommand<Charts>) =>
        "study stability --charts light,stiffness --quick \\\n      \
         --integrators verlet,strang-linear,collocation --out out/stability";
    /// Test Theorem 1 of the paper by numerical experiment.
    ///
    /// Does the DpS equation describe the chain with heavy resonators as well, and for as long, as
    /// the theorem says? Runs the chain with kappa = 1 and free ends at each epsilon, takes the
    /// suprema over 0 <= t <= T epsilon^(1-alpha) of the four errors (estimu), (estimv) in l_1, l_2
    /// and l_inf over samples, divides them by epsilon^alpha (u with u', v) and epsilon^(2 alpha-1)
    /// (v'), and gives the local slopes d ln sup / d ln epsilon. Exit code 1 if the outcome
    /// contradicts the theorem: its law of rho, and the verdict "violated".
    "theorem": (StudyCommand<TheoremOptions>), after theorem_help;
    /// Measure how long bright breathers live, over size and mass ratio.
    ///
    /// Runs the chain from the breather u(0) = 2 epsilon a at every size epsilon and every mass
    /// ratio rho.
    ///
    /// A life ends when the core, the fewest sites that hold 0.999 of the sum of a_n^2, has less
    /// than 0.9 of the energy; where it does not before the cap (--until), the table says: not
    /// before t.
    ///
    /// Each point has a fate. `radiates`: the core falls below 0.9 of the energy while its bonds
    /// are closed at least 1/3 of the time. `decouples`: before that, bonds of the core come to be
    /// closed less than 1/3 of the time: gaps open, each site oscillates on its own, and the energy
    /// stays. `persists`: neither before the cap.
    ///
    /// A larger map computes only what is new.
    "lifetimes": (StudyCommand<LifetimeOptions>) =>
        "study lifetimes --epsilons 0.01,0.1 --rhos 1e3,1e4 --out out/map";
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

commands! {
    WAVES;

    /// Compute which modulations of a wave grow, and how fast.
    ///
    /// Growth rates against the wave number of the modulation, in closed form; with --measure also
    /// those measured on the full chain.
    "modulation": (StudyCommand<ModulationStudy>) =>
        "wave modulation tw-q15",
        "wave modulation --rho 3 --q-over-pi 0.8 --measure --out out/growth";
    /// Compute an exact periodic travelling wave.
    ///
    /// It has the frequency (or the amplitude) and the mean strain of a wave of the modulation
    /// equations. Prints its profile, its Fourier coefficients, its distance from that first-order
    /// ansatz, and its relative multipliers for each Bloch wave number.
    "exact": (StudyCommand<Exact>) =>
        "wave exact tw-q15 --out out/exact",
        "wave exact --q-over-pi 0.8 --amplitude 0.1 --sites 40 --json",
        "wave exact tw-q15 --prove --certificate out/wave.cert";
    /// Follow a branch of exact travelling waves.
    ///
    /// Varies one parameter of the wave or of the chain, past folds. Waves keep their ratio of mean
    /// strain to amplitude unless a mean strain is given. Exit code 1 if the branch is lost before
    /// its end.
    "continue": (StudyCommand<ContinueWave>) =>
        "wave continue tw-q15 --to 2.004 --out out/branch",
        "wave continue tw-q15 --vary rho --mean 0.05 --to 3",
        "wave continue tw-q15 --to 2.0012 --prove --certificate out/branch.cert";
    /// Compute solitary waves, and their tails where resonators move.
    ///
    /// The pulse of the chain without resonators, as an exact wave of a ring and on the infinite
    /// line, and how its overlap decays from the crest; and how strong a wake a pulse leaves in
    /// chains with light resonators. Exit code 1 if a wave is not found.
    "solitary": (StudyCommand<Solitary>) =>
        "wave solitary --out out/solitary",
        "wave solitary --alpha 2 --rhos 0.01,0.02,0.05 --json";
}

commands! {
    BREATHERS;

    /// Run a long-lived bright breather and compare it with its ansatz.
    ///
    /// The chain starts from a breather of the modulation (DpS) equation. Prints how far the chain
    /// departs from this ansatz, and how much of the energy stays in the core.
    "bright": (StudyCommand<Bright>) => "breather bright --center bond --epsilon 0.01 --rho 1000";
    /// Compute a dark breather as an exact periodic orbit.
    ///
    /// Newton's method finds the orbit on a ring; its Floquet multipliers tell whether it is
    /// stable.
    "dark": (StudyCommand<Dark>) => "breather dark --center bond --omega-b 2.05 --out out/dark";
    /// Follow a branch of dark breathers in one parameter.
    ///
    /// Computes the Floquet multipliers of each orbit, and the bifurcations between them.
    "continue": (StudyCommand<Continue>), after || "Example, stopped after 20 points and gone on with:\n  \
        hertzchain breather continue --max-points 20 --out out/branch\n  \
        hertzchain breather continue --resume out/branch/branch.npz".to_owned();
    /// Follow the branch of doubled period of dark breathers.
    ///
    /// The branch starts at the period doubling of the bond-centred dark breathers.
    "doubled": (StudyCommand<Doubled>) => "breather doubled --omega-b 1.056 --out out/doubled";
    /// Run the chain from a dark breather, with or without a kick.
    ///
    /// A kick is along one of the modes of the orbit. After every period the run measures the
    /// return error, which is the distance from the orbit, and the position of the kink.
    "evolve": (StudyCommand<Evolve>) =>
        "breather dark --center bond --omega-b 2.05 --out out/dark",
        "breather evolve out/dark/dark-breather.npz --kick 1e-3";
    /// Compute the energy barrier between site- and bond-centred dark breathers.
    ///
    /// The Peierls-Nabarro barrier: energies of the two kinks relative to their common background,
    /// at the same frequency, and at the same action and length; also their largest multipliers.
    /// Exit code 1 if an orbit is not found.
    "barrier": (StudyCommand<Barrier>) =>
        "breather barrier --from 2.01 --to 2.1 --out out/barrier",
        "breather barrier --rho 3 --from 1.16 --to 1.35";
    /// Compute moving dark breathers as exact orbits, and run a kicked one.
    ///
    /// A moving breather is a relative periodic orbit: after K + 1/2 periods of the background (see
    /// --turns) the chain has its initial state again, moved on by a site. Prints its tails and
    /// relative multipliers, and for comparison the motion of a breather at rest that is kicked.
    /// Exit code 1 if an orbit is not found.
    "moving": (StudyCommand<Moving>) =>
        "breather moving --turns 16,18,22,26 --out out/moving",
        "breather moving --omega-b 2.088,2.092,2.096 --turns 11 --until 0";
}

commands! {
    ORBITS;

    /// Compute the periodic orbit to which a driven scene leads.
    ///
    /// The orbit is a fixed point of the stroboscopic map. Newton's method starts from the state
    /// that the scene has after some periods. Prints the Floquet multipliers, which may lie inside
    /// and outside the unit circle, and compares their product with Liouville's formula. Exit code
    /// 1 if no orbit is found.
    "driven": (StudyCommand<Driven>) =>
        "orbit driven granular-crystal",
        "orbit driven granular-crystal --dimensionless",
        "orbit driven granular-crystal --turns 2 --json";
    /// Follow the orbit of a driven scene in one parameter.
    ///
    /// In the drive's amplitude or frequency, or in the damping, past folds; with multipliers,
    /// folds, period doublings and torus bifurcations, and with the branch that crosses at one of
    /// them. It begins with the scene's own value. Exit code 1 if a branch is lost on its way.
    "continue": (StudyCommand<DrivenContinue>) =>
        "orbit continue granular-crystal --to 1e-7 --out out/branch",
        "orbit continue --resume out/branch --to 2e-7";
    /// Follow a normal mode of a conservative scene from its linear mode on.
    ///
    /// Computes the linear modes about the equilibrium, and follows the periodic orbits that begin
    /// as one of them to larger amplitudes, also beyond the amplitude at which contacts open:
    /// frequency, energy, participation number, Floquet multipliers. Exit code 1 if the branch is
    /// lost on its way.
    "mode": (StudyCommand<FollowMode>) =>
        "orbit mode defect --to 1.5",
        "orbit mode precompressed --linear-mode 5 --to 0.2 --out out/mode";
}

commands! {
    DPS;

    /// Averages of the contact force over an oscillation, and their derivatives.
    ///
    /// g_alpha(b, r) of (eq:aux1), the mean, and h_alpha(b, r) of (eq:aux2), the first harmonic
    /// divided by r.
    "integrals": (StudyCommand<Integrals>) => "dps integrals --b 0.5 --r 1 --alpha 2";
    /// Homoclinic solutions: profiles of bright breathers.
    ///
    /// They solve the stationary DpS equation.
    "homoclinic": (StudyCommand<Homoclinics>) => "dps homoclinic --center bond";
    /// Standing waves with a kink: profiles of dark breathers.
    ///
    /// They solve the generalised DpS equations. Also gives the strains from which a dark breather
    /// starts on the chain, to first order.
    "dark": (StudyCommand<DarkProfiles>) => "dps dark --center bond --rho 3 --omega-b 1.16";
}
