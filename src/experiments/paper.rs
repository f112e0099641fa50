//! The figures of the paper: what each of them shows, and the data behind it.
//!
//! A figure is an entry of [`PAPER`]; its numbers come from [`PaperFigure::data`], its picture and its tables from `report`.

mod orbits;

pub use orbits::{DoublingData, EvolutionRun, FloquetData, MassRatioData, OrbitData, OrbitRecipe, ProfileData};

use super::{
    BreatherOptions, BrightHistory, BrightStudy, Criterion, LifetimeOptions, LifetimeStudy, RhoLaw, StabilityOptions,
    StabilityStudy, TheoremOptions, TheoremStudy, WaveOptions, WaveStudy, bright_breather, bright_history, lifetimes,
    stability, theorem, wave,
};
use crate::{
    chain::Params,
    dps::{Center, DarkProfile, Homoclinic},
    error::{Error, Result},
    run::method::Method,
    scene::Scene,
    waves::Shape,
};
use std::f64::consts::PI;

/// Integrator, tolerance and samples a period of the waves.
const INTEGRATOR: &str = "collocation";
const TOLERANCE: f64 = 1e-10;
const SAMPLES_PER_PERIOD: u32 = 50;
/// Draws of a perturbed wave: the one shown has seed 1.
const SEEDS: u32 = 12;
/// The scene of Sec. 5, its tolerance, and samples a period.
const BRIGHT: &str = "bright-breather";
const BRIGHT_TOLERANCE: f64 = 1e-12;
const BRIGHT_SAMPLES: u32 = 20;
/// The laws of the mass ratio, side by side.
pub(crate) const LAWS: [RhoLaw; 2] = [RhoLaw::Heavy, RhoLaw::Light];
/// Tolerance of the runs of a map of lifetimes.
const LIFETIME_TOLERANCE: f64 = 1e-9;

/// A figure of the paper.
#[derive(Debug)]
pub struct PaperFigure {
    /// Short name: of the figure on the command line, and of its files.
    pub name: &'static str,
    /// Where in the paper.
    pub source: &'static str,
    /// Title.
    pub title: &'static str,
    /// What can be seen, in a sentence or two.
    pub claim: &'static str,
    /// How it is computed.
    pub recipe: Recipe,
}

/// How a figure is computed, and how it is laid out.
#[derive(Debug)]
pub enum Recipe {
    /// Travelling waves on the chain.
    Waves {
        /// What is run.
        runs: &'static [WaveRun],
        /// What is shown of it.
        columns: &'static [WaveColumn],
    },
    /// Growth of the modulations of the wave `q = pi/5`, `a = b = 1`, on rings of 50 sites.
    Growth {
        /// Mass ratio.
        rho: f64,
        /// Sizes at which it is measured on the full chain.
        epsilons: &'static [f64],
    },
    /// Dark profiles at `alpha = 3/2, kappa = 1`, with the kink on a site and on a bond.
    Dark {
        /// Sites of the ring.
        sites: usize,
        /// Mean strain of the background.
        c: f64,
    },
    /// Suprema of Theorem 1 for the breather about a bond, `T = 1`, with either law of the mass ratio.
    Bounds {
        /// Exponents, and the sizes of each.
        cases: &'static [(f64, &'static [f64])],
    },
    /// Homoclinic solutions about a site and about a bond.
    Homoclinics {
        /// Exponent.
        alpha: f64,
    },
    /// The long-lived bright breather of Sec. 5 against its ansatz.
    Bright,
    /// The same breather over space and time.
    BrightHistory,
    /// How long bright breathers about a bond live at `alpha = 3/2`, by energy.
    Lifetimes {
        /// Sizes.
        epsilons: &'static [f64],
        /// Mass ratios.
        rhos: &'static [f64],
        /// No breather is followed longer.
        until: f64,
    },
    /// Dark breathers as exact orbits.
    Orbits(OrbitRecipe),
}

/// A run of a figure.
#[derive(Debug)]
pub struct WaveRun {
    /// A built-in scene.
    pub scene: &'static str,
    /// Size of the perturbation (eq:dA0_ptb); 0 for none.
    pub zeta: f64,
    /// What tells its files from those of the other runs of the figure; nothing if there is but one.
    pub tag: &'static str,
}

/// A column of panels, all of one run.
#[derive(Debug)]
pub struct WaveColumn {
    /// What it shows, or nothing.
    pub heading: &'static str,
    /// Which run.
    pub run: usize,
    /// From above.
    pub panels: &'static [WavePanel],
}

/// What a panel shows of a run. Profiles are those at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WavePanel {
    /// Strains of beads.
    X,
    /// Strains of resonators.
    Y,
    /// Strains of beads of the perturbed wave.
    PerturbedX,
    /// Strains of resonators of the perturbed wave.
    PerturbedY,
    /// `E_x` and `E_y` in time (eq:relerr_tw).
    Errors,
    /// The same with `E_x` again, enlarged.
    ErrorsEnlarged,
    /// `tilde E_x` and `tilde E_y` in time (eq:relerr_twPtd).
    Differences,
    /// `tilde E_x` with median and range over the seeds.
    SpreadX,
    /// `tilde E_y` with median and range over the seeds.
    SpreadY,
}

/// The numbers behind a figure.
#[derive(Debug)]
pub enum PaperData {
    /// Travelling waves, a study a run.
    Waves(&'static [WaveColumn], Vec<(&'static WaveRun, WaveStudy)>),
    /// Growth of modulations.
    Growth(Box<StabilityStudy>),
    /// Dark profiles.
    Dark(Vec<DarkProfile>),
    /// Suprema of Theorem 1: for each exponent a study a law.
    Bounds(Vec<[TheoremStudy; 2]>),
    /// Homoclinic solutions, about a site and about a bond.
    Homoclinics([Homoclinic; 2]),
    /// The bright breather.
    Bright(Box<BrightStudy>),
    /// The bright breather over space and time.
    BrightHistory(Box<BrightHistory>),
    /// Lifetimes.
    Lifetimes(Box<LifetimeStudy>),
    /// Exact orbits.
    Orbits(Box<OrbitData>),
}

use WavePanel::{Differences, Errors, ErrorsEnlarged, PerturbedX as Px, PerturbedY as Py, SpreadX, SpreadY, X, Y};

/// A run without a tag.
const fn run(scene: &'static str, zeta: f64) -> WaveRun {
    WaveRun { scene, zeta, tag: "" }
}

const fn column(heading: &'static str, run: usize, panels: &'static [WavePanel]) -> WaveColumn {
    WaveColumn { heading, run, panels }
}

/// All figures, in the order of the paper.
pub const PAPER: &[PaperFigure] = &[
    PaperFigure {
        name: "theorem-bounds",
        source: "Sec. 3.2, th:dps, which has no such figure",
        title: "Theorem 1 as an experiment: suprema over 0 ≤ t ≤ T ε^(1−α), divided by their powers of ε",
        claim: "With the resonators as heavy as the theorem asks all three stay bounded as ε falls; with lighter ones all three outgrow their powers, by a factor of ε^(1−α).",
        recipe: Recipe::Bounds {
            cases: &[(1.5, &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]), (2.0, &[1e-1, 1e-2, 1e-3, 1e-4])],
        },
    },
    PaperFigure {
        name: "tw-q15",
        source: "Sec. 4.1, fig:tw_r03_q15pi",
        title: "A travelling wave and its ansatz: q = π/5, ω_tw = ω + 0.001",
        claim: "The chain follows the first-order ansatz for a hundred periods; the errors stay bounded.",
        recipe: Recipe::Waves {
            runs: &[run("tw-q15", 0.0)],
            columns: &[column("", 0, &[X, Y]), column("", 0, &[Errors])],
        },
    },
    PaperFigure {
        name: "tw-q15-perturbed",
        source: "Sec. 4.1, fig:tw_r03_q15pi_ptd",
        title: "The same wave, perturbed: q = π/5, ζ = 0.01",
        claim: "The perturbed wave still follows its own ansatz; its distance from the unperturbed wave grows.",
        recipe: Recipe::Waves {
            runs: &[run("tw-q15", 0.01)],
            columns: &[column("", 0, &[Px, Py]), column("", 0, &[SpreadX, SpreadY])],
        },
    },
    PaperFigure {
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
    PaperFigure {
        name: "tw-breakdown",
        source: "Sec. 4.1, fig:tw_r03_breakdown",
        title: "Where the ansatz fails",
        claim: "The long wave, nine times as high as in tw-q15, leaves its ansatz at once; the short one departs from its own within a hundred periods, though it is lower \
                than the long one of tw-q15.",
        recipe: Recipe::Waves {
            runs: &[
                WaveRun { tag: "q15", ..run("tw-breakdown-q15", 0.0) },
                WaveRun { tag: "q45", ..run("tw-breakdown-q45", 0.0) },
            ],
            columns: &[
                column("q = π/5, ω_tw = ω + 0.003, t = 10 T_tw", 0, &[X, Y]),
                column("q = 4π/5, ω_tw = ω + 0.009, t = 314", 1, &[X, Y]),
            ],
        },
    },
    PaperFigure {
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
    PaperFigure {
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
    PaperFigure {
        name: "dps-growth",
        source: "Sec. 4, which has no such figure",
        title: "Growth of modulations of a travelling wave",
        claim: "The growth that the linearised modulation equations predict is that of the full chain, the closer the smaller the wave.",
        recipe: Recipe::Growth { rho: 3.0, epsilons: &[0.01, 0.0025, 0.000625] },
    },
    PaperFigure {
        name: "homoclinics",
        source: "Sec. 5, Theorem homoclinic, which has no such figure",
        title: "Profiles of bright breathers: homoclinic solutions of (dpsstat), α = 3/2",
        claim: "Neighbours are in antiphase, and the tails fall doubly exponentially: ln|ln|aₙ|| is a line of slope ln α.",
        recipe: Recipe::Homoclinics { alpha: 1.5 },
    },
    PaperFigure {
        name: "long-lived-breather",
        source: "Sec. 5, fig:long_lived_bb",
        title: "The long-lived bright breather: i = 2, N = 40, ρ = 1000, ε = 0.01",
        claim: "For as long as the theorem says the norms stay of order one; long after, energy has been radiated and what is left is a kink in the resonators.",
        recipe: Recipe::Bright,
    },
    PaperFigure {
        name: "bright-breather-spacetime",
        source: "Sec. 5, which has no such figure",
        title: "The long-lived bright breather over space and time, to 80 T",
        claim: "The oscillation stays on four beads for as long as the theorem says, then most of it leaves for either side; the resonators behind it keep a shift, away from the centre.",
        recipe: Recipe::BrightHistory,
    },
    PaperFigure {
        name: "lifetime-map",
        source: "Sec. 5, which has no such figure",
        title: "How long bright breathers live, over their size and the mass ratio",
        claim: "Above the line, where the theorem applies, breathers outlive its time scale, the longer the heavier the resonators; well below it they are gone before, or come apart into beads that swing alone.",
        recipe: Recipe::Lifetimes {
            epsilons: &[1e-3, 3e-3, 1e-2, 3e-2, 1e-1],
            rhos: &[1e1, 1e2, 1e3, 1e4],
            until: 2000.0,
        },
    },
    PaperFigure {
        name: "dps-dark",
        source: "Sec. 6, fig:sw_anbn",
        title: "Standing waves with a kink: profiles of dark breathers, μ = 1, c = 0",
        claim: "Neighbours are in antiphase, and at the kink the phase slips by π; there the oscillation is weak and the mean strain is negative, so that every bond bears the same mean force.",
        recipe: Recipe::Dark { sites: 41, c: 0.0 },
    },
    PaperFigure {
        name: "dark-profiles",
        source: "Sec. 7, fig:sw_xnyn_w205",
        title: "Exact dark breathers and the DpS profiles they come from: ω_b = 2.05, ρ = 1/3",
        claim: "The exact orbit comes back after a period to rounding; the first-order profile has its shape, but is too high by a quarter in the beads and by a half in the resonators.",
        recipe: Recipe::Orbits(OrbitRecipe::Profiles { rho: THIRD, omega_b: 2.05 }),
    },
    PaperFigure {
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
    PaperFigure {
        name: "site-error",
        source: "Sec. 7, fig:r03sc_relerr",
        title: "When site-centred dark breathers begin to leave themselves: ρ = 1/3",
        claim: "The return error after 1200 units of time is a rounding that has grown a little, up to where the strong quartet is born; there it jumps to the size of the orbit.",
        recipe: Recipe::Orbits(OrbitRecipe::ReturnErrors { omega_b: [2.003, 2.083], points: 80, until: 1200.0 }),
    },
    PaperFigure {
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
    PaperFigure {
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
    PaperFigure {
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
    PaperFigure {
        name: "period-doubling-mode",
        source: "Sec. 7, fig:PdoubleSln",
        title: "The mode at the multiplier −1, and the orbit of doubled period: ρ = 1/3",
        claim: "The mode is odd about the kink and dies out within a few sites; pushed along it, the breather becomes one of half the frequency.",
        recipe: Recipe::Orbits(OrbitRecipe::Doubling { omega_b: 1.032 }),
    },
    PaperFigure {
        name: "period-doubled",
        source: "Sec. 7, fig:PdoubleFloq",
        title: "Dark breathers of doubled period: ρ = 1/3",
        claim: "After half its period the orbit is its own reflection, after all of it itself; every orbit of the branch is unstable, and it goes on beyond 1.051.",
        recipe: Recipe::Orbits(OrbitRecipe::Doubled { omega_b: 1.032, to: 1.056 }),
    },
    PaperFigure {
        name: "rho3-evolution",
        source: "Sec. 7, fig:r3evol",
        title: "Dark breathers with heavier resonators: ρ = 3, ω_b = 1.2547",
        claim: "The site-centred breather is still there at the end, the bond-centred one has set out.",
        recipe: Recipe::Orbits(OrbitRecipe::Evolutions {
            rho: 3.0,
            runs: &[let_go(Center::Site, 1.2547, 1500.0), let_go(Center::Bond, 1.2547, 1500.0)],
            profiles: true,
        }),
    },
    PaperFigure {
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
    PaperFigure {
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
    PaperFigure {
        name: "rho-continuation",
        source: "Sec. 7, fig:rhocts",
        title: "Floquet multipliers of dark breathers against the mass ratio, at fixed frequency",
        claim: "Only bond-centred breathers have positive real multipliers; strong quartets come to both families alike, above some mass ratio, and at ω_b = 2.05 near ρ = 0.45 as well.",
        recipe: Recipe::Orbits(OrbitRecipe::MassRatios { omega_b: &[1.50, 1.75, 2.05], to: 10.0, points: [80, 40] }),
    },
];

const THIRD: f64 = 1.0 / 3.0;

/// A run without a kick.
const fn let_go(center: Center, omega_b: f64, until: f64) -> EvolutionRun {
    EvolutionRun { center, omega_b, until, kick: None }
}

impl PaperFigure {
    /// A figure by its name.
    ///
    /// # Errors
    /// An unknown name, with the nearest one.
    pub fn named(name: &str) -> Result<&'static Self> {
        let known = || PAPER.iter().map(|figure| figure.name);
        PAPER.iter().find(|figure| figure.name == name).ok_or_else(|| Error::unknown("figure", name, known()))
    }

    /// Computes what the figure shows; `progress` is told the share that is done. The same numbers on any number of cores.
    ///
    /// # Errors
    /// A run that fails.
    pub fn data(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<PaperData> {
        match self.recipe {
            Recipe::Orbits(ref recipe) => Ok(PaperData::Orbits(Box::new(recipe.data(progress)?))),
            Recipe::Waves { runs, columns } => {
                let study = |(k, run): (usize, &'static WaveRun)| {
                    let tell = |done, total| progress((k as f64 + done as f64 / total as f64) / runs.len() as f64);
                    Ok((run, run.study(&tell)?))
                };
                Ok(PaperData::Waves(columns, runs.iter().enumerate().map(study).collect::<Result<_>>()?))
            }
            Recipe::Dark { sites, c } => {
                // The profile does not depend on rho.
                let params = Params { alpha: 1.5, kappa: 1.0, rho: 1.0 / 3.0 };
                let profile = |center| DarkProfile::new(params, center, sites, c);
                Ok(PaperData::Dark([Center::Site, Center::Bond].map(profile).into_iter().collect::<Result<_>>()?))
            }
            Recipe::Bounds { cases } => {
                let study = |k: usize, alpha: f64, epsilons: &[f64], rho_law: RhoLaw| {
                    let tell = |share: f64| progress((k as f64 + share) / (LAWS.len() * cases.len()) as f64);
                    theorem(
                        &TheoremOptions { alpha, rho_law, epsilons: epsilons.to_vec(), ..Default::default() },
                        None,
                        &tell,
                    )
                };
                let pair = |(k, (alpha, epsilons)): (usize, &(f64, &[f64]))| {
                    let [heavy, light] = LAWS;
                    Ok([study(2 * k, *alpha, epsilons, heavy)?, study(2 * k + 1, *alpha, epsilons, light)?])
                };
                Ok(PaperData::Bounds(cases.iter().enumerate().map(pair).collect::<Result<_>>()?))
            }
            Recipe::Homoclinics { alpha } => Ok(PaperData::Homoclinics([
                Homoclinic::new(alpha, Center::Site)?,
                Homoclinic::new(alpha, Center::Bond)?,
            ])),
            Recipe::Bright => {
                let (scene, options) = bright()?;
                let study = bright_breather(&scene, &options, BRIGHT_SAMPLES, &mut |share| progress(share))?;
                Ok(PaperData::Bright(Box::new(study)))
            }
            Recipe::BrightHistory => {
                let (scene, options) = bright()?;
                Ok(PaperData::BrightHistory(Box::new(bright_history(&scene, &options, &mut |share| progress(share))?)))
            }
            Recipe::Lifetimes { epsilons, rhos, until } => {
                let options = LifetimeOptions {
                    alpha: 1.5,
                    center: Center::Bond,
                    criterion: Criterion::Energy,
                    epsilons: epsilons.to_vec(),
                    rhos: rhos.to_vec(),
                    sites: None,
                    until: Some(until),
                    method: Method::named(INTEGRATOR)?,
                    tolerance: LIFETIME_TOLERANCE,
                };
                let study = lifetimes(&options, None, &|done, total| progress(done as f64 / total as f64))?;
                Ok(PaperData::Lifetimes(Box::new(study)))
            }
            Recipe::Growth { rho, epsilons } => {
                let options = StabilityOptions {
                    params: Params { alpha: 1.5, kappa: 1.0, rho },
                    shape: Shape { q: 0.2 * PI, a: 1.0, b: 1.0, phi: 0.0 },
                    epsilons: epsilons.to_vec(),
                    sites: 50,
                    modes: Some(12),
                    chart: true,
                };
                Ok(PaperData::Growth(Box::new(stability(&options, &|share, _| progress(share))?)))
            }
        }
    }
}

/// The breather of Sec. 5, and how it is run.
fn bright() -> Result<(Scene, BreatherOptions)> {
    Ok((Scene::load(BRIGHT)?, BreatherOptions { method: Method::named(INTEGRATOR)?, tolerance: BRIGHT_TOLERANCE }))
}

impl WaveRun {
    fn study(&self, progress: &(dyn Fn(u64, u64) + Sync)) -> Result<WaveStudy> {
        let scene = Scene::load(self.scene)?.perturbed(self.zeta, None)?;
        let options = WaveOptions {
            method: Method::named(INTEGRATOR)?,
            tolerance: TOLERANCE,
            samples_per_period: SAMPLES_PER_PERIOD,
            seeds: (self.zeta > 0.0).then_some(SEEDS),
        };
        wave(&scene, &options, progress)
    }
}
