//! Studies of figures whose options take more than a line: waves, Theorem 1, exact waves.

use crate::{
    chain::Params,
    error::Result,
    number::format_parameter,
    report::{Column, Hidden, Kind, Line, Panel, Panels, Report, Table},
    scene::{Initial, Scene},
    study::{
        Adaptive, BranchOptions, ContinueWave, LifetimeOptions, Norm, Progress, RhoLaw, StabilityOptions, Study,
        TheoremOptions, TheoremStudy, Wanted, WaveOptions, WaveStudy, exact_study, fit_line, lifetimes, stability,
        theorem, wave,
    },
    sweep::Engine,
    waves::{Given, MeanStrain, Search, Shape, Size, TravellingWave, WaveNumber, WaveSetting},
};
use std::f64::consts::PI;

/// Sites of the ring for waves of decreasing size, `q = pi/5`.
const SITES: usize = 10;

/// The wave of a scene, with another mean strain, a perturbation and so many seeds of it if these
/// are given.
pub(in super::super) fn wave_study(
    scene: &str,
    mean_strain: Option<f64>,
    perturbed: Option<(f64, u32)>,
    progress: Progress<'_>,
) -> Result<WaveStudy> {
    let mut file = Scene::load(scene)?.file().clone();
    if let (Initial::TravellingWave { b, .. }, Some(mean_strain)) = (&mut file.initial, mean_strain) {
        *b = mean_strain;
    }
    let scene = Scene::build(file)?.perturbed(perturbed.map_or(0.0, |(zeta, _)| zeta), None)?;
    let seeds = perturbed.map(|(_, seeds)| seeds);
    wave(&scene, &WaveOptions { seeds, ..WaveOptions::default() }, &Engine::threads(), progress)
}

/// The wave of a scene, and 12 perturbed ones if `zeta` is not zero; that of seed 1 is drawn.
pub(super) fn waves(scene: &str, zeta: f64, tell: Progress<'_>) -> Result<Report> {
    Ok(wave_study(scene, None, (zeta > 0.0).then_some((zeta, 12)), tell)?.report())
}

/// Growth of the modulations of the wave `q = pi/5`, `a = b = 1`, on rings of 50 sites.
pub(super) fn growth(rho: f64, epsilons: &[f64], tell: Progress<'_>) -> Result<Report> {
    let options = StabilityOptions {
        params: Params { alpha: 1.5, kappa: 1.0, rho },
        shape: Shape { q: 0.2 * PI, a: 1.0, b: 1.0, phi: 0.0 },
        epsilons: epsilons.to_vec(),
        sites: 50,
        modes: Some(12),
        chart: true,
    };
    Ok(stability(&options, &Engine::threads(), tell)?.report())
}

/// Suprema of Theorem 1 for the breather about a bond, `T = 1`, with both laws of the mass ratio:
/// the least that the theorem allows, and a smaller one.
pub(super) fn bounds(alpha: f64, epsilons: &[f64], tell: Progress<'_>) -> Result<Report> {
    let laws = [("heavy", "ρ = ε^(−2(α−1))", RhoLaw::Heavy), ("light", "ρ = ε^(−(α−1))", RhoLaw::Light)];
    let study = |(k, (.., rho_law)): (usize, &(&str, &str, RhoLaw))| {
        let options =
            TheoremOptions { alpha, rho_law: *rho_law, epsilons: epsilons.to_vec(), ..TheoremOptions::default() };
        theorem(&options, &Engine::threads(), &|share, _| tell(0.5 * (k as f64 + share), ""))
    };
    let studies: Vec<TheoremStudy> = laws.iter().enumerate().map(study).collect::<Result<_>>()?;
    let both = || laws.iter().zip(&studies);
    let panel = |k: usize, label: &str| {
        let line = |((_, law, _), study): (&(&str, &str, RhoLaw), &TheoremStudy)| {
            Line::new(law, study.runs.iter().map(|run| (run.epsilon, study.scaled(run, Norm::One).0[k])))
        };
        Panel::new(Kind::LogLog, ["size ε", label], both().map(line).collect())
    };
    let panels = [panel(0, "error of u, u′ / ε^α"), panel(1, "sup ‖v‖₁ / ε^α"), panel(2, "sup ‖v′‖₁ / ε^(2α−1)")];
    let words: Vec<String> = both().map(|((_, law, _), study)| format!("{law}: {}", study.slopes_in_words())).collect();
    let caption = format!(
        "Breather about a bond, A(0) = the bond-centred homoclinic solution, T = 1 of slow time, κ = 1. Slopes in l₁ of the errors over the two smallest sizes: {}",
        words.join(" ")
    );
    let report = both().fold(Report::new("bounds"), |report, ((tag, ..), study)| {
        study.report().parts(&[tag]).0.into_iter().fold(report, Report::table)
    });
    let columns = vec![Column::new(format!("α = {alpha}"), panels)];
    Ok(report.picture(Panels { columns, caption, ..Panels::default() }))
}

/// The scene of the breather of Sec. 5, and the options of its run.
pub(super) fn bright_run() -> Result<(Scene, Adaptive)> {
    Ok((Scene::load("bright-breather")?, Adaptive { tol: 1e-12, ..Adaptive::default() }))
}

/// Lifetimes about a bond, at `alpha = 3/2`.
pub(super) fn lifetime_map(epsilons: &[f64], rhos: &[f64], until: f64, tell: Progress<'_>) -> Result<Report> {
    let options = LifetimeOptions {
        epsilons: epsilons.to_vec(),
        rhos: rhos.to_vec(),
        until: Some(until),
        ..LifetimeOptions::default()
    };
    Ok(lifetimes(&options, &Engine::threads(), tell)?.report())
}

/// The branch between two differences of `omega_tw` from `omega`, with the ratio of mean strain to
/// amplitude of a scene; the difference of the run of Sec. 4.1 is marked.
pub(super) fn branch(scene: &str, [from, run, to]: [f64; 3], tell: Progress<'_>) -> Result<Report> {
    let omega = Scene::load(scene)?.chain().params().omega();
    let wanted = Wanted { omega_tw: Some(omega + from), ..Wanted::of(scene) };
    let (to, step) = (Some(omega + to), Some((to - from) / 100.0));
    let branch = BranchOptions { to, step, ..BranchOptions::default() };
    let report = ContinueWave { wanted, branch, ..ContinueWave::default() }.begin()?(&Engine::threads(), tell)?;
    Ok(report.marked("run of Sec. 4.1", &[omega + run]))
}

/// An exact wave against the modulation equations.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct LimitWave {
    /// Mass ratio, and `epsilon` of the ansatz.
    rho: f64,
    epsilon: f64,
    /// `E_x` and `E_y` of the ansatz.
    pub(in super::super) errors: [f64; 2],
    /// Growth at the Bloch wave number `pi`, per unit of time, and by the modulation equations.
    growth: f64,
    modulation: f64,
}

impl LimitWave {
    /// Relative difference of the growth from that of the modulation equations.
    pub(in super::super) fn apart(&self) -> f64 {
        self.growth / self.modulation - 1.0
    }
}

/// The exact companion of the wave `q = pi/5`, `a = b = 1`, `alpha = 3/2`, `kappa = 1` of this
/// size.
pub(in super::super) fn limit_wave(rho: f64, epsilon: f64) -> Result<LimitWave> {
    let (params, q, search) = (Params::new(1.5, 1.0, rho)?, WaveNumber::on_ring(0.2, SITES)?, Search::default());
    let shape = Shape { q: q.q(), a: 1.0, b: 1.0, phi: 0.0 };
    let wave = TravellingWave::new(params, shape, Size::Epsilon(epsilon))?;
    let setting = WaveSetting { params, q, omega_tw: wave.omega_tw(), mean: MeanStrain::Value(epsilon) };
    let (exact, ansatz) = search.wave(&setting, Given::Frequency)?;
    let study = exact_study("", exact, ansatz, SITES, &search)?;
    let last = study.growth.last().copied();
    let growth = last.map_or(f64::NAN, |row| row.exact);
    let modulation = last.and_then(|row| row.modulation).unwrap_or(f64::NAN);
    Ok(LimitWave { rho, epsilon, errors: study.errors.unwrap_or([f64::NAN; 2]), growth, modulation })
}

/// Exact waves of decreasing size against the modulation equations.
pub(super) fn limits(rhos: &[f64], epsilons: &[f64]) -> Result<Report> {
    let both = rhos.iter().flat_map(|&rho| epsilons.iter().map(move |&epsilon| (rho, epsilon)));
    let waves: Vec<LimitWave> = both.map(|(rho, epsilon)| limit_wave(rho, epsilon)).collect::<Result<_>>()?;
    let table = Table::of("limits", &waves)
        .key("")
        .col("rho", Hidden, "mass ratio", |wave| wave.rho)
        .col("epsilon", Hidden, "size of the ansatz", |wave| wave.epsilon)
        .col("e_x", Hidden, "error of the ansatz, beads", |wave| wave.errors[0])
        .col("e_y", Hidden, "error of the ansatz, resonators", |wave| wave.errors[1])
        .col("growth", Hidden, "growth at the Bloch wave number pi, per unit of time", |wave| wave.growth)
        .col("modulation", Hidden, "the same by the modulation equations", |wave| wave.modulation);
    let by_rho = || waves.chunk_by(|a, b| a.rho == b.rho);
    let name = |waves: &[LimitWave]| format!("ρ = {}", format_parameter(waves[0].rho));
    let panel = |label: &str, of: fn(&LimitWave) -> f64| {
        let line = |waves: &[LimitWave]| Line::new(&name(waves), waves.iter().map(|wave| (wave.epsilon, of(wave))));
        let root = Line::law("√ε/10", epsilons.iter().map(|epsilon| (*epsilon, 0.1 * epsilon.sqrt())));
        Column::new("", [Panel::new(Kind::LogLog, ["size ε", label], by_rho().map(line).chain([root]).collect())])
    };
    let columns = vec![
        panel("E_x of the ansatz", |wave| wave.errors[0]),
        panel("|growth / DpS growth − 1| at p = π", |wave| wave.apart().abs()),
    ];
    let slope = |waves: &[LimitWave], of: fn(&LimitWave) -> f64| {
        let points: Vec<_> = waves.iter().map(|wave| (wave.epsilon.ln(), of(wave).ln())).collect();
        fit_line(&points).map_or(f64::NAN, |(slope, _)| slope)
    };
    let slopes = |waves: &[LimitWave]| {
        let of: [fn(&LimitWave) -> f64; 2] = [|one| one.errors[0], |one| one.apart().abs()];
        format!("{}: {}", name(waves), of.map(|of| format!("{:.3}", slope(waves, of))).join(", "))
    };
    let caption = format!(
        "q = π/5, a = b = 1, α = 3/2, κ = 1, ring of {SITES} sites. Slopes of E_x and of the difference of the growth at \
         p = π: {}.",
        by_rho().map(slopes).collect::<Vec<_>>().join("; ")
    );
    Ok(Report::new("limits").table(table).picture(Panels { columns, caption, ..Panels::default() }))
}
