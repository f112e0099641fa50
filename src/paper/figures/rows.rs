//! The figures of the paper, one row each.

use super::{
    Figure, orbits,
    studies::{bounds, branch, bright_run, growth, lifetime_map, limits, waves},
};
use crate::{
    dps::Center::{self, Bond, Site},
    error::Result,
    report::Report,
    study::{
        Barrier, ChainParams, DarkProfiles, Homoclinics, Moving, Progress, Solitary, Wanted, bright_breather,
        bright_history,
    },
    sweep::Engine,
};

const THIRD: f64 = 1.0 / 3.0;
/// Plots of a wave: strains beside the ansatz, and its error; the same of the perturbed wave.
const OWN: &[(usize, usize)] = &[(0, 0), (0, 1), (0, 2)];
const PERTURBED: &[(usize, usize)] = &[(0, 3), (0, 4), (0, 5)];

fn dark(center: Center) -> DarkProfiles {
    let params = ChainParams { rho: THIRD, ..ChainParams::default() };
    DarkProfiles { center, params, omega_b: Some(2.05), ..DarkProfiles::default() }
}

/// Moving breathers of these frequencies and turns, and a kicked one up to a time.
fn moving(omega_b: &[f64], turns: &[u32], until: f64, tell: Progress<'_>) -> Result<Report> {
    let (omega_b, turns) = (omega_b.to_vec(), turns.to_vec());
    Ok(Moving { omega_b, turns, until, ..Moving::default() }.study(&Engine::threads(), tell)?.report())
}

/// All figures, in the order of the paper.
pub const FIGURES: &[Figure] = &[
    Figure {
        name: "theorem-bounds",
        source: "Sec. 3.2, th:dps, which has no such figure",
        title: "Theorem 1 as an experiment: suprema over 0 ≤ t ≤ T ε^(1−α), divided by their powers of ε",
        claim: "With the resonators as heavy as the theorem asks all three stay bounded as ε falls; with lighter ones all three outgrow their powers, by a factor of ε^(1−α).",
        studies: &[
            ("alpha1.5", |tell| bounds(1.5, &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6], tell)),
            ("alpha2", |tell| bounds(2.0, &[1e-1, 1e-2, 1e-3, 1e-4], tell)),
        ],
        columns: &[],
    },
    Figure {
        name: "tw-q15",
        source: "Sec. 4.1, fig:tw_r03_q15pi",
        title: "A travelling wave and its ansatz: q = π/5, ω_tw = ω + 0.001",
        claim: "The chain follows the first-order ansatz for a hundred periods; the errors stay bounded.",
        studies: &[("", |tell| waves("tw-q15", 0.0, tell))],
        columns: &[],
    },
    Figure {
        name: "tw-q15-perturbed",
        source: "Sec. 4.1, fig:tw_r03_q15pi_ptd",
        title: "The same wave, perturbed: q = π/5, ζ = 0.01",
        claim: "The perturbed wave still follows its own ansatz; its distance from the unperturbed wave grows.",
        studies: &[("", |tell| waves("tw-q15", 0.01, tell))],
        columns: &[("", &[(0, 3), (0, 4)]), ("", &[(0, 6), (0, 7)])],
    },
    Figure {
        name: "tw-q45",
        source: "Sec. 4.1, fig:tw_r03_q45pi",
        title: "A short wave of small amplitude: q = 4π/5, ω_tw = ω + 0.001",
        claim: "The ansatz holds for two hundred periods, and a perturbation keeps its size.",
        studies: &[("", |tell| waves("tw-q45", 0.1, tell))],
        columns: &[("unperturbed", OWN), ("perturbed, ζ = 0.1", PERTURBED)],
    },
    Figure {
        name: "tw-breakdown",
        source: "Sec. 4.1, fig:tw_r03_breakdown",
        title: "Waves that depart from their ansatz",
        claim: "The long wave, nine times as high as one that follows its ansatz, has left its own after ten periods; the short one departs within a hundred, though it is lower than that long one.",
        studies: &[
            ("q15", |tell| waves("tw-breakdown-q15", 0.0, tell)),
            ("q45", |tell| waves("tw-breakdown-q45", 0.0, tell)),
        ],
        columns: &[
            ("q = π/5, ω_tw = ω + 0.003, t = 10 T_tw", OWN),
            ("q = 4π/5, ω_tw = ω + 0.009, t = 314", &[(1, 0), (1, 1), (1, 2)]),
        ],
    },
    Figure {
        name: "tw-rho3",
        source: "Sec. 4.2, fig:tw_r3_q15pi",
        title: "A heavier resonator: ρ = 3, q = π/5, ε = 0.01",
        claim: "The ansatz holds for a hundred periods; a perturbation grows.",
        studies: &[("", |tell| waves("tw-rho3", 0.01, tell))],
        columns: &[("unperturbed", OWN), ("perturbed, ζ = 0.01", PERTURBED)],
    },
    Figure {
        name: "tw-rho10-1000",
        source: "Sec. 4.2, fig:tw_r10r1000",
        title: "At and above the critical mass ratio ρ_c = 10: q = π/5, ε = 0.01",
        claim: "The beads follow the ansatz for a hundred periods; the resonators do not.",
        studies: &[("rho10", |tell| waves("tw-rho10", 0.0, tell)), ("rho1000", |tell| waves("tw-rho1000", 0.0, tell))],
        columns: &[("ρ = 10", OWN), ("ρ = 1000", &[(1, 0), (1, 1), (1, 2)])],
    },
    Figure {
        name: "dps-growth",
        source: "Sec. 4, which has no such figure",
        title: "Growth of modulations of a travelling wave",
        claim: "The growth that the linearised modulation equations predict is that of the full chain, the closer the smaller the wave.",
        studies: &[("", |tell| growth(3.0, &[0.01, 0.0025, 0.000625], tell))],
        columns: &[],
    },
    Figure {
        name: "homoclinics",
        source: "Sec. 5, Theorem homoclinic, which has no such figure",
        title: "Profiles of bright breathers: homoclinic solutions of the stationary DpS equations, α = 3/2",
        claim: "Neighbours are in antiphase, and the tails fall doubly exponentially: ln|ln|aₙ|| tends to a line of slope ln α.",
        studies: &[
            ("site", |_| Homoclinics { alpha: 1.5, center: Site }.report()),
            ("bond", |_| Homoclinics { alpha: 1.5, center: Bond }.report()),
        ],
        columns: &[("about a site", &[(0, 0), (0, 1)]), ("about a bond", &[(1, 0), (1, 1)])],
    },
    Figure {
        name: "long-lived-breather",
        source: "Sec. 5, fig:long_lived_bb",
        title: "The long-lived bright breather: i = 2, N = 40, ρ = 1000, ε = 0.01",
        claim: "For as long as the theorem says the norms stay of order one; long after, most of the energy has left the core, and the resonators have a kink.",
        studies: &[("", |tell| {
            let (scene, options) = bright_run()?;
            Ok(bright_breather(&scene, &options, 20, tell)?.report())
        })],
        columns: &[("", &[(0, 0), (0, 1)]), ("", &[(0, 2), (0, 3)])],
    },
    Figure {
        name: "bright-breather-spacetime",
        source: "Sec. 5, which has no such figure",
        title: "The long-lived bright breather over space and time, to 80 T",
        claim: "The oscillation stays almost wholly on four beads for as long as the theorem says, then most of it leaves for either side; the resonators behind it keep a shift, away from the centre.",
        studies: &[("", |tell| {
            let (scene, options) = bright_run()?;
            Ok(bright_history(&scene, &options, tell)?.report())
        })],
        columns: &[],
    },
    Figure {
        name: "lifetime-map",
        source: "Sec. 5, which has no such figure",
        title: "How long bright breathers live, over their size and the mass ratio",
        claim: "Above x = 1, where the theorem applies, breathers outlive its time scale, the longer the heavier the resonators; at x = 1 and below most decay earlier, or split into single beads that oscillate on their own.",
        studies: &[("", |tell| lifetime_map(&[1e-3, 3e-3, 1e-2, 3e-2, 1e-1], &[1e1, 1e2, 1e3, 1e4], 2000.0, tell))],
        columns: &[],
    },
    Figure {
        name: "dark-profiles",
        source: "Sec. 6, fig:sw_anbn, and Sec. 7, fig:sw_xnyn_w205",
        title: "Standing waves with a kink, and the exact dark breathers that come from them: ω_b = 2.05, ρ = 1/3",
        claim: "Neighbours are in antiphase, and at the kink the phase slips by π; there the oscillation is weak and its mean strain bₙ negative, so that every bond bears the same mean force. The exact orbit comes back after a period to rounding; the first-order profile has its shape, but is too high by a quarter in the beads and by a half in the resonators.",
        studies: &[
            ("bond", |_| orbits::profile(Bond, 2.05)),
            ("site", |_| orbits::profile(Site, 2.05)),
            ("dps-bond", |_| dark(Bond).report()),
            ("dps-site", |_| dark(Site).report()),
        ],
        columns: &[
            ("bond-centred", &[(2, 0), (2, 1), (0, 3), (0, 4)]),
            ("site-centred", &[(3, 0), (3, 1), (1, 3), (1, 4)]),
        ],
    },
    Figure {
        name: "floquet-rho03",
        source: "Sec. 7, fig:r03floq",
        title: "Floquet multipliers of dark breathers, ρ = 1/3",
        claim: "About a bond one pair is real from the start and another is negative real between 2.063 and 2.096; about a site there are quartets only, weak ones until a strong one comes near −1. Number and size of the weak quartets depend on the length of the ring.",
        studies: &[
            ("bond", |tell| orbits::family(THIRD, Bond, [0.003, 0.108], (100, true, None), tell)),
            ("site", |tell| orbits::family(THIRD, Site, [0.003, 0.108], (100, true, None), tell)),
            ("bond-2.09", |_| orbits::one(THIRD, Bond, 2.09)),
            ("site-2.09", |_| orbits::one(THIRD, Site, 2.09)),
        ],
        columns: &[("", &[(0, 2), (1, 2)]), ("", &[(2, 2), (3, 2)])],
    },
    Figure {
        name: "site-error",
        source: "Sec. 7, fig:r03sc_relerr",
        title: "Return errors of site-centred dark breathers after 1200 units of time: ρ = 1/3",
        claim: "The error stays below 1e-10 up to the frequency at which the strong quartet appears; there it jumps to the size of the orbit.",
        studies: &[("", |tell| orbits::return_errors([2.003, 2.083], 80, 1200.0, tell))],
        columns: &[("", &[(0, 2)]), ("", &[(0, 3)])],
    },
    Figure {
        name: "site-spacetime",
        source: "Sec. 7, fig:r03sc_evol",
        title: "Site-centred dark breathers over space and time: ρ = 1/3",
        claim: "Below the onset of the strong quartet nothing happens; above it the breather breaks up, and the whole chain with it.",
        studies: &[
            ("site-2.05", |tell| orbits::evolution((THIRD, Site, 2.05), 1200.0, None, tell)),
            ("site-2.09", |tell| orbits::evolution((THIRD, Site, 2.09), 1200.0, None, tell)),
        ],
        columns: &[("site-centred, ω_b = 2.05", &[(0, 0), (0, 1)]), ("site-centred, ω_b = 2.09", &[(1, 0), (1, 1)])],
    },
    Figure {
        name: "bond-spacetime",
        source: "Sec. 7, fig:r03bc_evol",
        title: "The bond-centred dark breather over space and time: ω_b = 2.05, ρ = 1/3",
        claim: "Its real instability sets it in motion: after a long while if only roundings push it, at once if it is kicked along the unstable mode.",
        studies: &[
            ("bond-2.05", |tell| orbits::evolution((THIRD, Bond, 2.05), 2500.0, None, tell)),
            ("bond-2.05-kicked", |tell| orbits::evolution((THIRD, Bond, 2.05), 2500.0, Some(0.01), tell)),
        ],
        columns: &[
            ("bond-centred, ω_b = 2.05", &[(0, 0), (0, 1)]),
            ("bond-centred, ω_b = 2.05, kicked by 0.01", &[(1, 0), (1, 1)]),
        ],
    },
    Figure {
        name: "bond-breakup",
        source: "Sec. 7, fig:r03bc_evol1",
        title: "Bond-centred dark breathers of higher frequency break up: ρ = 1/3",
        claim: "A disturbance grows at the kink and spreads to both sides; then the whole chain is in disorder.",
        studies: &[
            ("bond-2.08", |tell| orbits::evolution((THIRD, Bond, 2.08), 1200.0, None, tell)),
            ("bond-2.1", |tell| orbits::evolution((THIRD, Bond, 2.1), 1200.0, None, tell)),
        ],
        columns: &[("bond-centred, ω_b = 2.08", &[(0, 0), (0, 1)]), ("bond-centred, ω_b = 2.1", &[(1, 0), (1, 1)])],
    },
    Figure {
        name: "period-doubled",
        source: "Sec. 7, fig:PdoubleSln and fig:PdoubleFloq",
        title: "Dark breathers of doubled period, and the mode at the multiplier −1: ρ = 1/3",
        claim: "The mode is odd about the kink and dies out within a few sites; from the breather pushed along it Newton's method finds one of half the frequency. After half its period the orbit is its own reflection, after all of it itself; every orbit of the branch is unstable, and it was followed to 1.056.",
        studies: &[
            ("mode", |_| orbits::doubling(1.032)),
            ("", |_| orbits::doubled(1.032)),
            ("", |tell| orbits::doubled_branch(1.056, tell)),
        ],
        columns: &[("", &[(0, 0), (1, 3), (1, 4)]), ("", &[(2, 2), (1, 2)])],
    },
    Figure {
        name: "rho3-evolution",
        source: "Sec. 7, fig:r3evol",
        title: "Dark breathers with heavier resonators: ρ = 3, ω_b = 1.2547",
        claim: "At the end the site-centred breather has kept its shape and place; the bond-centred one has begun to move.",
        studies: &[
            ("site-1.2547", |tell| orbits::evolution((3.0, Site, 1.2547), 1500.0, None, tell)),
            ("bond-1.2547", |tell| orbits::evolution((3.0, Bond, 1.2547), 1500.0, None, tell)),
        ],
        columns: &[
            ("site-centred, ω_b = 1.2547", &[(0, 4), (0, 5), (0, 0), (0, 1)]),
            ("bond-centred, ω_b = 1.2547", &[(1, 4), (1, 5), (1, 0), (1, 1)]),
        ],
    },
    Figure {
        name: "rho3-floquet",
        source: "Sec. 7, fig:r3floq",
        title: "Floquet multipliers of dark breathers, ρ = 3",
        claim: "About a bond the real pair is far stronger than anything else; about a site there are weak quartets only. Number and size of the weak quartets depend on the length of the ring.",
        studies: &[
            ("bond", |tell| orbits::family(3.0, Bond, [0.001, 0.2], (100, false, None), tell)),
            ("site", |tell| orbits::family(3.0, Site, [0.001, 0.2], (100, false, None), tell)),
            ("bond-1.2547", |_| orbits::one(3.0, Bond, 1.2547)),
            ("site-1.2547", |_| orbits::one(3.0, Site, 1.2547)),
        ],
        columns: &[("", &[(0, 2), (1, 2)]), ("", &[(2, 2), (3, 2)])],
    },
    Figure {
        name: "rho10-floquet",
        source: "Sec. 7, fig:r10floq",
        title: "Floquet multipliers of dark breathers, ρ = 10",
        claim: "Near ω there is a real pair about a bond, and weak quartets; further on the background itself becomes unstable, and whole arcs of quartets leave the circle for both families. Number and size of the weak quartets depend on the length of the ring.",
        studies: &[
            ("bond", |tell| orbits::family(10.0, Bond, [0.001, 0.2], (100, false, Some(0.07)), tell)),
            ("site", |tell| orbits::family(10.0, Site, [0.001, 0.2], (100, false, Some(0.07)), tell)),
            ("bond-1.2", |_| orbits::one(10.0, Bond, 1.2)),
            ("site-1.2", |_| orbits::one(10.0, Site, 1.2)),
        ],
        columns: &[("", &[(0, 2), (1, 2), (1, 3)]), ("", &[(2, 2), (3, 2)])],
    },
    Figure {
        name: "rho-continuation",
        source: "Sec. 7, fig:rhocts",
        title: "Floquet multipliers of dark breathers against the mass ratio, at fixed frequency",
        claim: "Only bond-centred breathers have positive real multipliers; strong quartets come to both families alike, above some mass ratio, and at ω_b = 2.05 for light resonators as well.",
        studies: &[
            ("bond-1.50", |tell| orbits::mass_ratios(Bond, 1.5, 10.0, [80, 40], tell)),
            ("site-1.50", |tell| orbits::mass_ratios(Site, 1.5, 10.0, [80, 40], tell)),
            ("bond-1.75", |tell| orbits::mass_ratios(Bond, 1.75, 10.0, [80, 40], tell)),
            ("site-1.75", |tell| orbits::mass_ratios(Site, 1.75, 10.0, [80, 40], tell)),
            ("bond-2.05", |tell| orbits::mass_ratios(Bond, 2.05, 10.0, [80, 40], tell)),
            ("site-2.05", |tell| orbits::mass_ratios(Site, 2.05, 10.0, [80, 40], tell)),
        ],
        columns: &[
            ("ω_b = 1.50", &[(0, 2), (1, 2)]),
            ("ω_b = 1.75", &[(2, 2), (3, 2)]),
            ("ω_b = 2.05", &[(4, 2), (5, 2)]),
        ],
    },
    Figure {
        name: "exact-wave",
        source: "Sec. 8, which has no such figure",
        title: "Is there an exact wave beside the ansatz? q = π/5, ω_tw = ω + 0.001",
        claim: "Yes: a profile X(qn − ω_tw t) that the chain keeps to rounding, lower than the ansatz by less than a percent. Its Fourier coefficients fall like k^(−α−3), the mark of a force that opens; its modulations grow nearly as the modulation equations say.",
        studies: &[("", |_| Ok(Wanted::of("tw-q15").study()?.report()))],
        columns: &[],
    },
    Figure {
        name: "exact-branches",
        source: "Sec. 8 and 4.1, which have no such figure",
        title: "What becomes of exact waves as they grow, at and beyond the breakdown of the ansatz",
        claim: "Waves of both wave numbers go on where the runs of Sec. 4.1 leave their ansatz (dashed). There the ansatz is still within 5 % of the exact wave. The long wave has multipliers that grow more than fifty times as fast as the modulation equations say; of the short one none grows, so its run departs by what the ansatz is off.",
        studies: &[
            ("tw-q15", |tell| branch("tw-q15", [3e-4, 0.003, 0.01], tell)),
            ("tw-q45", |tell| branch("tw-q45", [3e-4, 0.009, 0.06], tell)),
        ],
        columns: &[("q = π/5", &[(0, 0), (0, 1), (0, 2)]), ("q = 4π/5", &[(1, 0), (1, 1), (1, 2)])],
    },
    Figure {
        name: "exact-limits",
        source: "Sec. 8, which has no such figure",
        title: "Small waves: exact against the modulation equations",
        claim: "Both the distance E_x of the ansatz from the exact wave and the relative difference of their growth rates fall like ε^(α−1).",
        studies: &[("", |_| limits(&[THIRD, 3.0], &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2]))],
        columns: &[],
    },
    Figure {
        name: "solitary",
        source: "Sec. 8, which has no such figure; the limit ρ = 0 of the model",
        title: "What becomes of the Hertz solitary wave as resonators are switched on?",
        claim: "The pulse of the plain chain is an exact wave and falls doubly exponentially. Light resonators give it a tail like exp(−2.94 k) sin²(k/2)/k within a factor of three, k = ω/c; so it has a minimum where k is a multiple of 2π.",
        studies: &[("", |tell| Ok(Solitary::default().study(&Engine::threads(), tell)?.report()))],
        columns: &[],
    },
    Figure {
        name: "barrier",
        source: "Sec. 8, which has no such figure",
        title: "Is there a Peierls–Nabarro barrier for dark breathers?",
        claim: "Yes, a small one: at the same action and length the bond-centred breather has more energy than the site-centred one, by less than a percent of the energy of the kink. The difference does not change its sign, and stabilities do not exchange: only bond-centred breathers have positive real multipliers.",
        studies: &[
            ("rho0.33", |tell| Ok(Barrier::of(THIRD, [2.01, 2.1], 19).study(&Engine::threads(), tell)?.report())),
            ("rho3.00", |tell| Ok(Barrier::of(3.0, [1.165, 1.345], 19).study(&Engine::threads(), tell)?.report())),
        ],
        columns: &[],
    },
    Figure {
        name: "moving",
        source: "Sec. 8, which has no such figure",
        title: "Are there exact moving dark breathers, and does a kicked one become such a wave?",
        claim: "Relative periodic orbits exist over a range of velocities, each with a tail; with twenty and a half periods a site none was found. A kicked breather has nearly the amplitude of the exact one of its velocity, and accelerates along the family, towards the velocities of small tails.",
        studies: &[("", |tell| moving(&[2.05], &[19, 21, 22, 23, 24, 26, 28], 1200.0, tell))],
        columns: &[("", &[(0, 0), (0, 2)]), ("", &[(0, 3), (0, 4)])],
    },
];
