//! Reports of the figures of the paper: captions, tables, pictures.

mod heavy;
mod orbits;

use super::{
    bright_tables,
    dps::{center_word, of_sites},
    lifetimes_csv,
    stability::{caption as growth_caption, shown, stability_tables},
    table,
    wave::wave_tables,
};
use crate::{
    dps::{DarkProfile, Homoclinic},
    error::Error,
    experiments::{PaperData, PaperFigure, WaveColumn, WavePanel, WaveRun, WaveStudy},
    output::{csv, to_json},
};
use serde_json::{Value, json};
use std::{f64::consts::PI, time::Duration};

/// What became of a figure.
#[derive(Debug)]
pub struct Drawn {
    /// The figure.
    pub figure: &'static PaperFigure,
    /// Its caption and its files, or why there is none.
    pub outcome: Result<(String, Vec<String>), Error>,
    /// Wall time.
    pub wall: Duration,
}

/// What made a figure and its tables, as JSON: `name`, `source`, `title`, `caption` with all parameters, `version`.
pub fn paper_origin(figure: &PaperFigure, caption: &str) -> String {
    to_json(&json!({
        "name": figure.name,
        "source": figure.source,
        "title": figure.title,
        "caption": caption,
        "version": env!("CARGO_PKG_VERSION"),
    }))
}

/// The figures as JSON, an object each: `name`, `source`, `title`, `files`, `caption`, `wall_s`, `failure`.
pub fn paper_json(drawn: &[Drawn]) -> String {
    let row = |Drawn { figure, outcome, wall }: &Drawn| {
        let done = outcome.as_ref().ok();
        json!({
            "name": figure.name,
            "source": figure.source,
            "title": figure.title,
            "files": done.map_or(&[][..], |(_, files)| &files[..]),
            "caption": done.map(|(caption, _)| caption),
            "wall_s": wall.as_secs_f64(),
            "failure": outcome.as_ref().err().map(ToString::to_string),
        })
    };
    to_json(&json!({ "figures": drawn.iter().map(row).collect::<Vec<Value>>(), "version": env!("CARGO_PKG_VERSION") }))
}

/// The figures as a table.
pub fn paper_table(drawn: &[Drawn]) -> String {
    let row = |Drawn { figure, outcome, wall }: &Drawn| {
        let files = match outcome {
            Ok((_, files)) => files.len().to_string(),
            Err(_) => "FAILED".to_owned(),
        };
        let wall = format!("{:.2}", wall.as_secs_f64());
        vec![figure.name.to_owned(), files, wall, figure.source.to_owned(), figure.title.to_owned()]
    };
    table(&["figure", "files", "wall (s)", "source", "title"], &drawn.iter().map(row).collect::<Vec<_>>())
}

/// The caption: what can be seen, what was run and how, and what was measured.
pub fn paper_caption(figure: &PaperFigure, data: &PaperData) -> String {
    let what = match data {
        PaperData::Waves(columns, runs) => waves_caption(columns, runs),
        PaperData::Growth(study) => growth_caption(study),
        PaperData::Dark(profiles) => dark_caption(profiles),
        PaperData::Bounds(pairs) => heavy::bounds_caption(pairs),
        PaperData::Homoclinics(both) => heavy::homoclinics_caption(both),
        PaperData::Bright(study) => heavy::bright_caption(study),
        PaperData::BrightHistory(history) => heavy::history_caption(history),
        PaperData::Lifetimes(study) => heavy::lifetimes_caption(study),
        PaperData::Orbits(data) => orbits::orbit_caption(data),
    };
    format!("{} {what} Paper: {}.", figure.claim, figure.source)
}

/// The tables behind a figure, `(file name, CSV)`: those that the command of its data writes, or its profiles.
pub fn paper_tables(figure: &PaperFigure, data: &PaperData) -> Vec<(String, Vec<u8>)> {
    let named = |tag: &str, tables: Vec<(&str, Vec<u8>)>| {
        let dash = if tag.is_empty() { "" } else { "-" };
        let name = |table: &str| format!("{}{dash}{tag}-{table}", figure.name);
        tables.into_iter().map(|(table, bytes)| (name(table), bytes)).collect::<Vec<_>>()
    };
    match data {
        PaperData::Waves(_, runs) => runs.iter().flat_map(|(run, study)| named(run.tag, wave_tables(study))).collect(),
        PaperData::Growth(study) => named("", stability_tables(study)),
        PaperData::Dark(profiles) => {
            profiles.iter().flat_map(|one| named(center_word(one.center()), vec![dark_csv(one)])).collect()
        }
        PaperData::Bounds(pairs) => {
            let tables = |study| named(&heavy::bounds_tag(study), heavy::bounds_csv(study));
            pairs.iter().flatten().flat_map(tables).collect()
        }
        PaperData::Homoclinics(both) => {
            let table = |one| named(center_word(Homoclinic::center(one)), vec![heavy::homoclinic_csv(one)]);
            both.iter().flat_map(table).collect()
        }
        PaperData::Bright(study) => named("", bright_tables(study)),
        PaperData::BrightHistory(history) => named("", heavy::history_csv(history)),
        PaperData::Lifetimes(study) => vec![(format!("{}.csv", figure.name), lifetimes_csv(study))],
        PaperData::Orbits(data) => {
            orbits::orbit_tables(data).into_iter().flat_map(|(tag, tables)| named(&tag, tables)).collect()
        }
    }
}

fn dark_csv(profile: &DarkProfile) -> (&'static str, Vec<u8>) {
    ("profile.csv", csv(&["n", "a", "b"], profile.sites().map(|n| vec![n as f64, profile.a(n), profile.b(n)])))
}

fn dark_caption(profiles: &[DarkProfile]) -> String {
    let words = |profile: &DarkProfile| {
        let least = of_sites(profile, |n| profile.b(n)).into_iter().fold(f64::INFINITY, f64::min);
        format!(
            "{}-centred: δ⁻a₁ = {}, least δ⁻bₙ = {}; Newton's method from (eq:an_ini) times the amplitude of the background, {} steps, residual {:.0e}. ",
            center_word(profile.center()),
            shown(profile.a(1)),
            shown(least),
            profile.newton().len() - 1,
            profile.residual(),
        )
    };
    let Some(one) = profiles.first() else { return String::new() };
    let (params, (a, c)) = (one.params(), one.background());
    format!(
        "Solutions of (eq:DpSsw2), renormalised to μ = 1, on a ring of {} sites; a breather of frequency ω_b has the strains μ^(1/(α−1)) (δ⁻bₙ + 2κ δ⁻aₙ cos ω_b t), \
         μ = 2ω³(ω_b − ω). α = {}, κ = {}, δ⁻b_(−N) = c = {c}; background δ⁻a = ±{}. {}hertzchain {}.",
        one.sites().count(),
        params.alpha,
        params.kappa,
        shown(a),
        profiles.iter().map(words).collect::<String>(),
        env!("CARGO_PKG_VERSION")
    )
    .replace("= -", "= −")
}

/// A share as percent, to three digits.
fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let digits = (2 - value.abs().max(1e-6).log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$} %")
}

/// Last and largest of two series.
fn ends(x: &[f64], y: &[f64]) -> String {
    let last = |values: &[f64]| percent(values.last().copied().unwrap_or(f64::NAN));
    let most = |values: &[f64]| percent(values.iter().copied().fold(0.0, f64::max));
    format!("{} and {} at the end, at most {} and {}", last(x), last(y), most(x), most(y))
}

fn waves_caption(columns: &[WaveColumn], runs: &[(&WaveRun, WaveStudy)]) -> String {
    let shows = |wanted: &[WavePanel]| columns.iter().flat_map(|c| c.panels).any(|panel| wanted.contains(panel));
    let mut text =
        String::from("E_x, E_y: chain against ansatz (eq:xytw_app), in percent of the amplitude (eq:relerr_tw). ");
    if shows(&[WavePanel::PerturbedX, WavePanel::PerturbedY]) {
        text += "Ẽ_x, Ẽ_y: perturbed (eq:dA0_ptb) against unperturbed wave (eq:relerr_twPtd); ansatz of the perturbed wave: (eq:xy_app). ";
    }
    for (run, study) in runs {
        text += &run_words(run, study);
    }
    let mut common: Vec<String> = runs.iter().map(|(_, study)| common_words(study)).collect();
    common.dedup();
    text + &common.join("; ") + &format!(". hertzchain {}.", env!("CARGO_PKG_VERSION"))
}

/// What runs of one figure may differ in, and what was measured.
fn run_words(run: &WaveRun, study: &WaveStudy) -> String {
    let (wave, scene) = (&study.wave, &study.scene);
    let mut text = format!(
        "{}: ρ = {}, q = {} π, ε = {}, ω_tw = {:.6}, ω = {:.6}, t = {} = {} T_tw; E_x, E_y {}. ",
        run.scene,
        shown(wave.params().rho),
        shown(wave.shape().q / PI),
        shown(wave.epsilon()),
        wave.omega_tw(),
        wave.params().omega(),
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

/// What runs of one figure mostly share.
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

/// The picture.
///
/// # Errors
/// A picture that cannot be drawn.
#[cfg(feature = "plot")]
pub fn paper_png(figure: &PaperFigure, data: &PaperData) -> crate::error::Result<Vec<u8>> {
    use crate::figures::{Column, Panels, growth, maps, panels};
    let caption = paper_caption(figure, data);
    match data {
        PaperData::Dark(profiles) => {
            let columns = profiles.iter().map(dark_column).collect();
            Ok(panels(&Panels { title: figure.title.to_owned(), columns, caption })?)
        }
        PaperData::Bounds(pairs) => Ok(panels(&heavy::bounds_panels(figure.title, pairs, caption))?),
        PaperData::Homoclinics(both) => Ok(panels(&heavy::homoclinic_panels(figure.title, both, caption))?),
        PaperData::Bright(study) => Ok(panels(&heavy::bright_panels(figure.title, study, caption))?),
        PaperData::BrightHistory(history) => Ok(panels(&heavy::history_panels(figure.title, history, caption))?),
        PaperData::Lifetimes(study) => Ok(maps(&heavy::lifetime_maps(figure.title, study, caption))?),
        PaperData::Orbits(data) => Ok(panels(&orbits::orbit_panels(figure.title, data, caption))?),
        PaperData::Growth(study) => Ok(growth(&super::stability::figure(study, caption))?),
        PaperData::Waves(columns, runs) => {
            let column = |column: &WaveColumn| {
                Column::new(column.heading, column.panels.iter().map(|panel| wave_panel(*panel, &runs[column.run].1)))
            };
            let columns = columns.iter().map(column).collect();
            Ok(panels(&Panels { title: figure.title.to_owned(), columns, caption })?)
        }
    }
}

/// Amplitudes and mean strains of a dark profile.
#[cfg(feature = "plot")]
fn dark_column(profile: &DarkProfile) -> crate::figures::Column {
    use crate::figures::{Column, Line, Panel};
    let line = |name: &str, values: Vec<f64>| Line {
        name: name.to_owned(),
        points: profile.sites().map(|n| n as f64).zip(values).collect(),
    };
    let lines = vec![
        line("amplitude δ⁻aₙ", of_sites(profile, |n| profile.a(n))),
        line("mean δ⁻bₙ", of_sites(profile, |n| profile.b(n))),
    ];
    let panel =
        Panel { x_label: "site n".to_owned(), y_label: "strain at μ = 1".to_owned(), lines, ..Panel::default() };
    Column::new(format!("{}-centred", center_word(profile.center())), [panel])
}

/// A panel; of a run without perturbation, what needs one is empty.
#[cfg(feature = "plot")]
fn wave_panel(panel: WavePanel, study: &WaveStudy) -> crate::figures::Panel {
    use crate::{
        experiments::{Errors, Spread, Strains},
        figures::{Band, Inset, Kind, Line, Panel},
    };
    let line = |name: &str, points: Vec<(f64, f64)>| Line { name: name.to_owned(), points };
    let profile = |symbol: &str, numerical: &[f64], ansatz: &[f64]| {
        let sites = |values: &[f64]| values.iter().enumerate().map(|(n, &x)| (n as f64, x)).collect();
        Panel {
            x_label: "site n".to_owned(),
            y_label: format!("strain {symbol}"),
            lines: vec![line("numerical", sites(numerical)), line("ansatz", sites(ansatz))],
            ..Panel::default()
        }
    };
    let in_time = |values: &[f64]| study.t.iter().zip(values).map(|(&t, e)| (t, 100.0 * e)).collect::<Vec<_>>();
    let time = |label: &str, lines: Vec<Line>| Panel {
        kind: Kind::Time,
        x_label: "time t".to_owned(),
        y_label: format!("{label} (%)"),
        lines,
        ..Panel::default()
    };
    let pair = |label: &str, names: [&str; 2], errors: &Errors| {
        time(label, vec![line(names[0], in_time(&errors.x)), line(names[1], in_time(&errors.y))])
    };
    let spread = |name: &str, of: fn(&Errors) -> &Vec<f64>, spreads: &[Spread]| {
        let Some(run) = &study.perturbed else { return time(name, vec![]) };
        let count = study.ensemble.as_ref().map_or(0, |ensemble| ensemble.members.len());
        let own = line(&format!("seed {}", run.wave.seed()), in_time(of(&run.difference)));
        let median: Vec<f64> = spreads.iter().map(|spread| spread.median).collect();
        let range = study.t.iter().zip(spreads).map(|(&t, spread)| (t, 100.0 * spread.low, 100.0 * spread.high));
        let band = Band { name: format!("range of {count} seeds"), points: range.collect() };
        let lines = vec![own, line("median", in_time(&median))];
        Panel { bands: vec![band], ..time(name, lines) }
    };
    let (perturbed, ensemble) = (study.perturbed.as_ref(), study.ensemble.as_ref());
    let strains = |of: fn(&Strains) -> &Vec<f64>, symbol: &str| match perturbed {
        Some(run) => profile(symbol, of(&run.strains), of(&run.ansatz)),
        None => profile(symbol, &[], &[]),
    };
    let errors = || pair("error", ["E_x", "E_y"], &study.errors);
    match panel {
        WavePanel::X => profile("xₙ", &study.strains.x, &study.ansatz.x),
        WavePanel::Y => profile("yₙ", &study.strains.y, &study.ansatz.y),
        WavePanel::PerturbedX => strains(|strains| &strains.x, "xₙ"),
        WavePanel::PerturbedY => strains(|strains| &strains.y, "yₙ"),
        WavePanel::Errors => errors(),
        WavePanel::ErrorsEnlarged => Panel { inset: Some(Inset { label: "E_x (%)".to_owned(), line: 0 }), ..errors() },
        WavePanel::Differences => match perturbed {
            Some(run) => pair("difference", ["Ẽ_x", "Ẽ_y"], &run.difference),
            None => time("difference", vec![]),
        },
        WavePanel::SpreadX => spread("Ẽ_x", |errors| &errors.x, ensemble.map_or(&[], |e| &e.difference_x)),
        WavePanel::SpreadY => spread("Ẽ_y", |errors| &errors.y, ensemble.map_or(&[], |e| &e.difference_y)),
    }
}
