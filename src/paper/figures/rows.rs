//! The figures of the paper, one row each.

use super::{
    EvolutionRun, ExactRecipe, Figure, OrbitRecipe, Recipe, WaveColumn, WavePanel,
    WavePanel::{Differences, Errors, ErrorsEnlarged, PerturbedX as Px, PerturbedY as Py, SpreadX, SpreadY, X, Y},
    WaveRun,
};
use crate::dps::Center;

const THIRD: f64 = 1.0 / 3.0;

/// A run without a tag in its file names.
const fn run(scene: &'static str, zeta: f64) -> WaveRun {
    WaveRun { scene, zeta, tag: "" }
}

const fn column(heading: &'static str, run: usize, panels: &'static [WavePanel]) -> WaveColumn {
    WaveColumn { heading, run, panels }
}

/// An evolution without a kick.
const fn let_go(center: Center, omega_b: f64, until: f64) -> EvolutionRun {
    EvolutionRun { center, omega_b, until, kick: None }
}

/// All figures, in the order of the paper.
pub const FIGURES: &[Figure] = &[
    Figure {
        name: "theorem-bounds",
        source: "Sec. 3.2, th:dps, which has no such figure",
        title: "Theorem 1 as an experiment: suprema over 0 ≤ t ≤ T ε^(1−α), divided by their powers of ε",
        claim: "With the resonators as heavy as the theorem asks all three stay bounded as ε falls; with lighter ones all three outgrow their powers, by a factor of ε^(1−α).",
        recipe: Recipe::Bounds {
            cases: &[(1.5, &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]), (2.0, &[1e-1, 1e-2, 1e-3, 1e-4])],
        },
    },
    Figure {
        name: "tw-q15",
        source: "Sec. 4.1, fig:tw_r03_q15pi",
        title: "A travelling wave and its ansatz: q = π/5, ω_tw = ω + 0.001",
        claim: "The chain follows the first-order ansatz for a hundred periods; the errors stay bounded.",
        recipe: Recipe::Waves {
            runs: &[run("tw-q15", 0.0)],
            columns: &[column("", 0, &[X, Y]), column("", 0, &[Errors])],
        },
    },
    Figure {
        name: "tw-q15-perturbed",
        source: "Sec. 4.1, fig:tw_r03_q15pi_ptd",
        title: "The same wave, perturbed: q = π/5, ζ = 0.01",
        claim: "The perturbed wave still follows its own ansatz; its distance from the unperturbed wave grows.",
        recipe: Recipe::Waves {
            runs: &[run("tw-q15", 0.01)],
            columns: &[column("", 0, &[Px, Py]), column("", 0, &[SpreadX, SpreadY])],
        },
    },
    Figure {
        name: "tw-q45",
        source: "Sec. 4.1, fig:tw_r03_q45pi",
        title: "A short wave of small amplitude: q = 4π/5, ω_tw = ω + 0.001",
        claim: "The ansatz holds for two hundred periods, and a perturbation keeps its size.",
        recipe: Recipe::Waves {
            runs: &[run("tw-q45", 0.1)],
            columns: &[
                column("unperturbed", 0, &[X, Y, Errors]),
                column("perturbed, ζ = 0.1", 0, &[Px, Py, Differences]),
            ],
        },
    },
    Figure {
        name: "tw-breakdown",
        source: "Sec. 4.1, fig:tw_r03_breakdown",
        title: "Waves that depart from their ansatz",
        claim: "The long wave, nine times as high as in tw-q15, has left its ansatz after ten periods; the short one departs from its own within a hundred, though it is lower \
                than the long one of tw-q15.",
        recipe: Recipe::Waves {
            runs: &[
                WaveRun { tag: "q15", ..run("tw-breakdown-q15", 0.0) },
                WaveRun { tag: "q45", ..run("tw-breakdown-q45", 0.0) },
            ],
            columns: &[
                column("q = π/5, ω_tw = ω + 0.003, t = 10 T_tw", 0, &[X, Y, Errors]),
                column("q = 4π/5, ω_tw = ω + 0.009, t = 314", 1, &[X, Y, Errors]),
            ],
        },
    },
    Figure {
        name: "tw-rho3",
        source: "Sec. 4.2, fig:tw_r3_q15pi",
        title: "A heavier resonator: ρ = 3, q = π/5, ε = 0.01",
        claim: "The ansatz holds for a hundred periods; a perturbation grows.",
        recipe: Recipe::Waves {
            runs: &[run("tw-rho3", 0.01)],
            columns: &[
                column("unperturbed", 0, &[X, Y, Errors]),
                column("perturbed, ζ = 0.01", 0, &[Px, Py, Differences]),
            ],
        },
    },
    Figure {
        name: "tw-rho10-1000",
        source: "Sec. 4.2, fig:tw_r10r1000",
        title: "At and above the critical mass ratio ρ_c = 10: q = π/5, ε = 0.01",
        claim: "The beads follow the ansatz for a hundred periods; the resonators do not.",
        recipe: Recipe::Waves {
            runs: &[
                WaveRun { tag: "rho10", ..run("tw-rho10", 0.0) },
                WaveRun { tag: "rho1000", ..run("tw-rho1000", 0.0) },
            ],
            columns: &[column("ρ = 10", 0, &[X, Y, ErrorsEnlarged]), column("ρ = 1000", 1, &[X, Y, ErrorsEnlarged])],
        },
    },
    Figure {
        name: "dps-growth",
        source: "Sec. 4, which has no such figure",
        title: "Growth of modulations of a travelling wave",
        claim: "The growth that the linearised modulation equations predict is that of the full chain, the closer the smaller the wave.",
        recipe: Recipe::Growth { rho: 3.0, epsilons: &[0.01, 0.0025, 0.000625] },
    },
    Figure {
        name: "homoclinics",
        source: "Sec. 5, Theorem homoclinic, which has no such figure",
        title: "Profiles of bright breathers: homoclinic solutions of (dpsstat), α = 3/2",
        claim: "Neighbours are in antiphase, and the tails fall doubly exponentially: ln|ln|aₙ|| is a line of slope ln α.",
        recipe: Recipe::Homoclinics { alpha: 1.5 },
    },
    Figure {
        name: "long-lived-breather",
        source: "Sec. 5, fig:long_lived_bb",
        title: "The long-lived bright breather: i = 2, N = 40, ρ = 1000, ε = 0.01",
        claim: "For as long as the theorem says the norms stay of order one; long after, energy has been radiated and what is left is a kink in the resonators.",
        recipe: Recipe::Bright,
    },
    Figure {
        name: "bright-breather-spacetime",
        source: "Sec. 5, which has no such figure",
        title: "The long-lived bright breather over space and time, to 80 T",
        claim: "The oscillation stays on four beads for as long as the theorem says, then most of it leaves for either side; the resonators behind it keep a shift, away from the centre.",
        recipe: Recipe::BrightHistory,
    },
    Figure {
        name: "lifetime-map",
        source: "Sec. 5, which has no such figure",
        title: "How long bright breathers live, over their size and the mass ratio",
        claim: "Above x = 1, where the theorem applies, breathers outlive its time scale, the longer the heavier the resonators; well below it they decay earlier, or split into single beads that oscillate on their own.",
        recipe: Recipe::Lifetimes {
            epsilons: &[1e-3, 3e-3, 1e-2, 3e-2, 1e-1],
            rhos: &[1e1, 1e2, 1e3, 1e4],
            until: 2000.0,
        },
    },
    Figure {
        name: "dps-dark",
        source: "Sec. 6, fig:sw_anbn",
        title: "Standing waves with a kink: profiles of dark breathers, μ = 1, c = 0",
        claim: "Neighbours are in antiphase, and at the kink the phase slips by π; there the oscillation is weak and the mean strain is negative, so that every bond bears the same mean force.",
        recipe: Recipe::Dark { sites: 41, c: 0.0 },
    },
    Figure {
        name: "dark-profiles",
        source: "Sec. 7, fig:sw_xnyn_w205",
        title: "Exact dark breathers and the DpS profiles they come from: ω_b = 2.05, ρ = 1/3",
        claim: "The exact orbit comes back after a period to rounding; the first-order profile has its shape, but is too high by a quarter in the beads and by a half in the resonators.",
        recipe: Recipe::Orbits(OrbitRecipe::Profiles { rho: THIRD, omega_b: 2.05 }),
    },
    Figure {
        name: "floquet-rho03",
        source: "Sec. 7, fig:r03floq",
        title: "Floquet multipliers of dark breathers, ρ = 1/3",
        claim: "About a bond one pair is real from the start and another makes an arc through −1; about a site there are quartets only, weak ones until a strong one comes near −1.",
        recipe: Recipe::Orbits(OrbitRecipe::Floquet {
            rho: THIRD,
            above: [0.003, 0.108],
            points: 100,
            at: 2.09,
            zoom: None,
            bifurcations: true,
        }),
    },
    Figure {
        name: "site-error",
        source: "Sec. 7, fig:r03sc_relerr",
        title: "Return errors of site-centred dark breathers after 1200 units of time: ρ = 1/3",
        claim: "The error stays below 1e-10 up to the frequency at which the strong quartet appears; there it jumps to the size of the orbit.",
        recipe: Recipe::Orbits(OrbitRecipe::ReturnErrors { omega_b: [2.003, 2.083], points: 80, until: 1200.0 }),
    },
    Figure {
        name: "site-spacetime",
        source: "Sec. 7, fig:r03sc_evol",
        title: "Site-centred dark breathers over space and time: ρ = 1/3",
        claim: "Below the onset of the strong quartet nothing happens; above it the breather breaks up, and the whole chain with it.",
        recipe: Recipe::Orbits(OrbitRecipe::Evolutions {
            rho: THIRD,
            runs: &[let_go(Center::Site, 2.05, 1200.0), let_go(Center::Site, 2.09, 1200.0)],
            profiles: false,
        }),
    },
    Figure {
        name: "bond-spacetime",
        source: "Sec. 7, fig:r03bc_evol",
        title: "The bond-centred dark breather over space and time: ω_b = 2.05, ρ = 1/3",
        claim: "Its real instability sets it in motion: after a long while if only roundings push it, at once if it is kicked along the unstable mode.",
        recipe: Recipe::Orbits(OrbitRecipe::Evolutions {
            rho: THIRD,
            runs: &[
                let_go(Center::Bond, 2.05, 2500.0),
                EvolutionRun { kick: Some(0.01), ..let_go(Center::Bond, 2.05, 2500.0) },
            ],
            profiles: false,
        }),
    },
    Figure {
        name: "bond-breakup",
        source: "Sec. 7, fig:r03bc_evol1",
        title: "Bond-centred dark breathers of higher frequency break up: ρ = 1/3",
        claim: "The kink moves for a moment, then the chain is in disorder.",
        recipe: Recipe::Orbits(OrbitRecipe::Evolutions {
            rho: THIRD,
            runs: &[let_go(Center::Bond, 2.08, 1200.0), let_go(Center::Bond, 2.10, 1200.0)],
            profiles: false,
        }),
    },
    Figure {
        name: "period-doubling-mode",
        source: "Sec. 7, fig:PdoubleSln",
        title: "The mode at the multiplier −1, and the orbit of doubled period: ρ = 1/3",
        claim: "The mode is odd about the kink and dies out within a few sites; pushed along it, the breather becomes one of half the frequency.",
        recipe: Recipe::Orbits(OrbitRecipe::Doubling { omega_b: 1.032 }),
    },
    Figure {
        name: "period-doubled",
        source: "Sec. 7, fig:PdoubleFloq",
        title: "Dark breathers of doubled period: ρ = 1/3",
        claim: "After half its period the orbit is its own reflection, after all of it itself; every orbit of the branch is unstable, and it goes on beyond 1.051.",
        recipe: Recipe::Orbits(OrbitRecipe::Doubled { omega_b: 1.032, to: 1.056 }),
    },
    Figure {
        name: "rho3-evolution",
        source: "Sec. 7, fig:r3evol",
        title: "Dark breathers with heavier resonators: ρ = 3, ω_b = 1.2547",
        claim: "At the end the site-centred breather has kept its shape and place; the bond-centred one has begun to move.",
        recipe: Recipe::Orbits(OrbitRecipe::Evolutions {
            rho: 3.0,
            runs: &[let_go(Center::Site, 1.2547, 1500.0), let_go(Center::Bond, 1.2547, 1500.0)],
            profiles: true,
        }),
    },
    Figure {
        name: "rho3-floquet",
        source: "Sec. 7, fig:r3floq",
        title: "Floquet multipliers of dark breathers, ρ = 3",
        claim: "About a bond the real pair is far stronger than anything else; about a site there are weak quartets only.",
        recipe: Recipe::Orbits(OrbitRecipe::Floquet {
            rho: 3.0,
            above: [0.001, 0.2],
            points: 100,
            at: 1.2547,
            zoom: None,
            bifurcations: false,
        }),
    },
    Figure {
        name: "rho10-floquet",
        source: "Sec. 7, fig:r10floq",
        title: "Floquet multipliers of dark breathers, ρ = 10",
        claim: "Near ω as at ρ = 3; further on the background itself becomes unstable, and whole arcs of quartets leave the circle for both families.",
        recipe: Recipe::Orbits(OrbitRecipe::Floquet {
            rho: 10.0,
            above: [0.001, 0.2],
            points: 100,
            at: 1.2,
            zoom: Some(0.07),
            bifurcations: false,
        }),
    },
    Figure {
        name: "rho-continuation",
        source: "Sec. 7, fig:rhocts",
        title: "Floquet multipliers of dark breathers against the mass ratio, at fixed frequency",
        claim: "Only bond-centred breathers have positive real multipliers; strong quartets come to both families alike, above some mass ratio, and at ω_b = 2.05 near ρ = 0.45 as well.",
        recipe: Recipe::Orbits(OrbitRecipe::MassRatios { omega_b: &[1.50, 1.75, 2.05], to: 10.0, points: [80, 40] }),
    },
    Figure {
        name: "exact-wave",
        source: "Sec. 8, which has no such figure",
        title: "Is there an exact wave beside the ansatz? q = π/5, ω_tw = ω + 0.001",
        claim: "Yes: a profile X(qn − ω_tw t) that the chain keeps to rounding, lower than the ansatz by less than a percent. Its Fourier coefficients fall like k^(−α−3), the mark of a \
                force that opens; its modulations grow nearly as the modulation equations say.",
        recipe: Recipe::Exact(ExactRecipe::Wave { scene: "tw-q15" }),
    },
    Figure {
        name: "exact-branches",
        source: "Sec. 8 and 4.1, which have no such figure",
        title: "What becomes of exact waves as they grow, at and beyond the breakdown of the ansatz",
        claim: "Waves of both wave numbers go on where the runs of Sec. 4.1 leave their ansatz (ω + 0.003 and ω + 0.009). There the ansatz is still within 5 % of the exact wave. The long \
                wave has multipliers that grow more than fifty times as fast as the modulation equations say; of the short one none grows, so its run departs by what the ansatz is off.",
        recipe: Recipe::Exact(ExactRecipe::Branches {
            runs: &[("tw-q15", "q = π/5", [3e-4, 0.01]), ("tw-q45", "q = 4π/5", [3e-4, 0.06])],
        }),
    },
    Figure {
        name: "exact-limits",
        source: "Sec. 8, which has no such figure",
        title: "Small waves: exact against the modulation equations",
        claim: "Both the distance of the ansatz from the exact wave and the relative difference of their growth rates fall like ε^(α−1).",
        recipe: Recipe::Exact(ExactRecipe::Limits { rhos: &[THIRD, 3.0], epsilons: &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2] }),
    },
    Figure {
        name: "solitary",
        source: "Sec. 8 has no such figure; the limit ρ = 0 of the model",
        title: "What becomes of the Hertz solitary wave as resonators are switched on?",
        claim: "The pulse of the plain chain is an exact wave, c = C g^(1/4), and falls double-exponentially. Light resonators give it a tail that falls exponentially with the phase ω/c of a resonator a site, \
                and vanishes where this is a multiple of 2π.",
        recipe: Recipe::Exact(ExactRecipe::Solitary),
    },
    Figure {
        name: "barrier",
        source: "Sec. 8, which has no such figure",
        title: "Is there a Peierls–Nabarro barrier for dark breathers?",
        claim: "Yes, a small one: at the same action and length the bond-centred breather has more energy than the site-centred one, by less than a percent of the energy of the kink. The difference does not change its sign, \
                and stabilities do not exchange: only bond-centred breathers have real multipliers.",
        recipe: Recipe::Exact(ExactRecipe::Barrier { runs: &[(THIRD, [2.01, 2.1], 19), (3.0, [1.165, 1.345], 19)] }),
    },
    Figure {
        name: "moving",
        source: "Sec. 8, which has no such figure",
        title: "Are there exact moving dark breathers, and does a kicked one become such a wave?",
        claim: "Relative periodic orbits exist over a range of velocities, each with a tail that does not fall with the length of the ring: a moving breather radiates. \
                A kicked breather is at each time as deep as the exact one of its velocity, and accelerates along the family, towards the velocities of small tails.",
        recipe: Recipe::Exact(ExactRecipe::Moving {
            runs: &[
                (&[2.05], &[19, 21, 22, 23, 24, 26, 28], 1200.0),
                (&[2.09, 2.091, 2.092, 2.093, 2.094, 2.095, 2.096, 2.097, 2.098, 2.099, 2.1], &[11], 0.0),
            ],
        }),
    },
];
