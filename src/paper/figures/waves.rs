//! Travelling waves on the chain, and the growth of their modulations.

use super::INTEGRATOR;
use crate::{
    chain::Params,
    error::Result,
    number::{of_pi, written},
    run::method::Method,
    scene::Scene,
    study::{Adaptive, Progress, StabilityOptions, StabilityStudy, WaveOptions, WaveStudy, shown, stability, wave},
    sweep::Engine,
    waves::Shape,
};
use std::f64::consts::PI;

/// Tolerance of the runs, and samples per period.
const TOLERANCE: f64 = 1e-10;
const SAMPLES_PER_PERIOD: u32 = 50;
/// Number of perturbed waves in the statistics; the one that is drawn has seed 1.
const SEEDS: u32 = 12;

/// A run of a figure of travelling waves.
#[derive(Debug)]
pub struct WaveRun {
    /// Name of a built-in scene.
    pub scene: &'static str,
    /// Size of the perturbation (eq:dA0_ptb); 0 for none.
    pub zeta: f64,
    /// Part of the names of the run's files; empty if the figure has one run.
    pub tag: &'static str,
}

/// A column of panels of one run.
#[derive(Debug)]
pub struct WaveColumn {
    /// Heading of the column; may be empty.
    pub heading: &'static str,
    /// Index of the run.
    pub run: usize,
    /// The panels, from the top.
    pub panels: &'static [WavePanel],
}

/// The contents of a panel. Profiles are those at the end of the run.
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
    /// `E_x` and `E_y` against time (eq:relerr_tw).
    Errors,
    /// `E_x` and `E_y` against time, with `E_x` enlarged in an inset.
    ErrorsEnlarged,
    /// `tilde E_x` and `tilde E_y` against time (eq:relerr_twPtd).
    Differences,
    /// `tilde E_x` with median and range over the seeds.
    SpreadX,
    /// `tilde E_y` with median and range over the seeds.
    SpreadY,
}

impl WaveRun {
    fn study(&self, progress: Progress<'_>) -> Result<WaveStudy> {
        let scene = Scene::load(self.scene)?.perturbed(self.zeta, None)?;
        let options = WaveOptions {
            solver: Adaptive { method: Method::named(INTEGRATOR)?, tol: TOLERANCE },
            samples_per_period: SAMPLES_PER_PERIOD,
            seeds: (self.zeta > 0.0).then_some(SEEDS),
        };
        wave(&scene, &options, &Engine::threads(), progress)
    }
}

pub(super) fn studies(
    runs: &'static [WaveRun],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<(&'static WaveRun, WaveStudy)>> {
    let study = |(k, run): (usize, &'static WaveRun)| {
        let tell = |share: f64, _: &str| progress((k as f64 + share) / runs.len() as f64);
        Ok((run, run.study(&tell)?))
    };
    runs.iter().enumerate().map(study).collect()
}

/// Growth of the modulations of the wave `q = pi/5`, `a = b = 1`.
pub(super) fn growth(rho: f64, epsilons: &[f64], progress: &(dyn Fn(f64) + Sync)) -> Result<StabilityStudy> {
    let options = StabilityOptions {
        params: Params { alpha: 1.5, kappa: 1.0, rho },
        shape: Shape { q: 0.2 * PI, a: 1.0, b: 1.0, phi: 0.0 },
        epsilons: epsilons.to_vec(),
        sites: 50,
        modes: Some(12),
        chart: true,
    };
    stability(&options, &Engine::threads(), &|share, _| progress(share))
}

/// A number to six decimals, without zeros at the end.
fn decimals(value: f64) -> String {
    format!("{value:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A share as text in percent, with three digits.
fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let digits = (2 - value.abs().max(1e-6).log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$} %")
}

/// Last and largest values of two series, as text.
fn ends(x: &[f64], y: &[f64]) -> String {
    let last = |values: &[f64]| percent(values.last().copied().unwrap_or(f64::NAN));
    let most = |values: &[f64]| percent(values.iter().copied().fold(0.0, f64::max));
    format!("{} and {} at the end, at most {} and {}", last(x), last(y), most(x), most(y))
}

pub(super) fn waves_caption(columns: &[WaveColumn], runs: &[(&WaveRun, WaveStudy)]) -> String {
    let shows = |wanted: &[WavePanel]| columns.iter().flat_map(|c| c.panels).any(|panel| wanted.contains(panel));
    let mut text =
        String::from("E_x, E_y: chain against ansatz (eq:xytw_app), in percent of the amplitude (eq:relerr_tw). ");
    if shows(&[WavePanel::PerturbedX, WavePanel::PerturbedY]) {
        text += "Ẽ_x, Ẽ_y: perturbed (eq:dA0_ptb) against unperturbed wave (eq:relerr_twPtd); ansatz of the perturbed wave: (eq:xy_app). ";
    }
    for (run, study) in runs {
        text += &run_words(run, study);
    }
    if shows(&[WavePanel::SpreadX, WavePanel::SpreadY]) {
        text += "Ẽ_x, Ẽ_y are drawn at multiples of T_tw. ";
    }
    let mut common: Vec<String> = runs.iter().map(|(_, study)| common_words(study)).collect();
    common.dedup();
    text + &common.join("; ") + &format!(". hertzchain {}.", env!("CARGO_PKG_VERSION"))
}

/// The numbers in which runs of one figure can differ, and the measurements, as text.
fn run_words(run: &WaveRun, study: &WaveStudy) -> String {
    let (wave, scene) = (&study.wave, &study.scene);
    let mut text = format!(
        "{}: ρ = {}, q = {}, ε = {}, ω_tw = {}, ω = {}, t = {} = {} T_tw; E_x, E_y {}. ",
        run.scene,
        written(wave.params().rho),
        of_pi(wave.shape().q),
        shown(wave.epsilon()),
        decimals(wave.omega_tw()),
        decimals(wave.params().omega()),
        shown(scene.end()),
        shown(scene.end() / scene.period()),
        ends(&study.errors.x, &study.errors.y),
    );
    if let Some(run) = &study.perturbed {
        text += &format!(
            "ζ = {}, seed {}: E_x, E_y {}; Ẽ_x, Ẽ_y {}",
            run.wave.zeta(),
            run.wave.seed(),
            ends(&run.errors.x, &run.errors.y),
            ends(&run.difference.x, &run.difference.y),
        );
    }
    let growth = study.ensemble.as_ref().and_then(|ensemble| Some((ensemble, ensemble.spread(|m| m.growth_x)?)));
    if let Some((ensemble, growth)) = growth {
        text += &format!(
            "; growth of Ẽ_x (largest of the last period over that of the first) over {} seeds from {}: median {}, {} to {}. ",
            ensemble.members.len(),
            ensemble.members.first().map_or(0, |member| member.seed),
            shown(growth.median),
            shown(growth.low),
            shown(growth.high),
        );
    }
    text
}

/// The numbers that runs of one figure mostly share, as text.
fn common_words(study: &WaveStudy) -> String {
    let (chain, shape) = (study.scene.chain(), study.wave.shape());
    let params = chain.params();
    format!(
        "N = {}, α = {}, κ = {}, a = {}, b = {}, φ = {}; integrator {}",
        chain.sites(),
        params.alpha,
        params.kappa,
        shape.a,
        shape.b,
        shape.phi,
        study.setting
    )
}

#[cfg(feature = "plot")]
pub(super) use pictures::wave_panels;

#[cfg(feature = "plot")]
mod pictures {
    use super::{WaveColumn, WavePanel, WaveRun};
    use crate::{
        figures::{Band, Column, Inset, Kind, Line, Panel, Panels},
        study::{Errors, Spread, WaveStudy},
    };

    pub(in super::super) fn wave_panels(
        title: &str,
        columns: &[WaveColumn],
        runs: &[(&WaveRun, WaveStudy)],
        caption: String,
    ) -> Panels {
        let column = |column: &WaveColumn| {
            Column::new(column.heading, column.panels.iter().map(|one| panel(*one, &runs[column.run].1)))
        };
        Panels { title: title.to_owned(), columns: columns.iter().map(column).collect(), caption }
    }

    /// A panel of a run. A panel about perturbations is empty if the run has none.
    fn panel(which: WavePanel, study: &WaveStudy) -> Panel {
        let ensemble = study.ensemble.as_ref();
        let errors = || pair(study, "error", ["E_x", "E_y"], &study.errors);
        let profile = |label, numerical, ansatz| {
            let lines = [("numerical", numerical), ("ansatz", ansatz)];
            study.tables()[1].panel(Kind::Sites, ["site n", label], "n", &lines)
        };
        match which {
            WavePanel::X => profile("strain xₙ", "x", "x_ansatz"),
            WavePanel::Y => profile("strain yₙ", "y", "y_ansatz"),
            WavePanel::Errors => errors(),
            WavePanel::ErrorsEnlarged => {
                Panel { inset: Some(Inset { label: "E_x (%)".to_owned(), line: 0 }), ..errors() }
            }
            WavePanel::Differences => match &study.perturbed {
                Some(run) => pair(study, "difference", ["Ẽ_x", "Ẽ_y"], &run.difference),
                None => in_time("difference", vec![]),
            },
            _ if study.perturbed.is_none() => Panel::default(),
            WavePanel::PerturbedX => profile("strain xₙ", "x_perturbed", "x_perturbed_ansatz"),
            WavePanel::PerturbedY => profile("strain yₙ", "y_perturbed", "y_perturbed_ansatz"),
            WavePanel::SpreadX => spread(study, "Ẽ_x", |errors| &errors.x, ensemble.map_or(&[], |e| &e.difference_x)),
            WavePanel::SpreadY => spread(study, "Ẽ_y", |errors| &errors.y, ensemble.map_or(&[], |e| &e.difference_y)),
        }
    }

    fn line(name: &str, points: Vec<(f64, f64)>) -> Line {
        Line { name: name.to_owned(), points }
    }

    /// Lines in percent against time.
    fn in_time(label: &str, lines: Vec<Line>) -> Panel {
        Panel {
            kind: Kind::Time,
            x_label: "time t".to_owned(),
            y_label: format!("{label} (%)"),
            lines,
            ..Panel::default()
        }
    }

    /// Values at the times of the study, in percent.
    fn percents(study: &WaveStudy, values: &[f64]) -> Vec<(f64, f64)> {
        study.t.iter().zip(values).map(|(&t, e)| (t, 100.0 * e)).collect()
    }

    fn pair(study: &WaveStudy, label: &str, names: [&str; 2], errors: &Errors) -> Panel {
        let lines = [line(names[0], percents(study, &errors.x)), line(names[1], percents(study, &errors.y))];
        in_time(label, lines.into())
    }

    /// The difference of the one perturbed wave, and median and range over all seeds, at multiples
    /// of the period: in between they oscillate.
    fn spread(study: &WaveStudy, name: &str, of: fn(&Errors) -> &Vec<f64>, spreads: &[Spread]) -> Panel {
        let Some(run) = &study.perturbed else { return in_time(name, vec![]) };
        let count = study.ensemble.as_ref().map_or(0, |ensemble| ensemble.members.len());
        let own = line(&format!("seed {}", run.wave.seed()), percents(study, of(&run.difference)));
        let median: Vec<f64> = spreads.iter().map(|spread| spread.median).collect();
        let range = study.t.iter().zip(spreads).map(|(&t, spread)| (t, 100.0 * spread.low, 100.0 * spread.high));
        let period = study.scene.period();
        let whole = |t: f64| (t / period - (t / period).round()).abs() < 1e-6;
        let band =
            Band { name: format!("range of {count} seeds"), points: range.filter(|point| whole(point.0)).collect() };
        let mut lines = vec![own, line("median", percents(study, &median))];
        lines.iter_mut().for_each(|line| line.points.retain(|point| whole(point.0)));
        Panel { bands: vec![band], ..in_time(name, lines) }
    }
}
