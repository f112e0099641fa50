//! The charts of stability as text, JSON, CSV and pictures.

use super::struck::TOLERANCES;
#[cfg(feature = "plot")]
use super::struck::{EXPONENTS, MASS_RATIOS};
use super::{
    BOUNDS, Chart, ChartPoint, ChartStudy, Limit, Measured, ResonancePoint, StruckPoint, Trial, Variant,
    Verdict as ChartVerdict, kick_sum,
};
use crate::{
    error::Result,
    present::{machine_json, table},
    run::method::Method,
    study::{File, Report},
};
use serde_json::{Value, json};
use std::fmt::Write;

impl Report for ChartStudy {
    /// `wall` is seconds a unit of time, and depends on the load of the machine.
    fn json(&self) -> Value {
        let chain = self.problem.chain();
        json!({
            "scene": self.problem.name(),
            "chain": chain,
            "amplitude": self.problem.amplitude(),
            "bounds": BOUNDS,
            "work": self.work,
            "points": self.points.iter().map(point_json).collect::<Vec<_>>(),
            "resonances": self.resonances.iter().map(resonance_json).collect::<Vec<_>>(),
            "struck": self.struck.iter().map(struck_json).collect::<Vec<_>>(),
            "regimes": regimes(self).iter().map(Cheapest::json).collect::<Vec<_>>(),
            "computed": computed(self),
            "resumed": self.resumed,
            "wall_s": self.wall.as_secs_f64(),
            "machine": machine_json(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// The verdict and the error of every method at its usual step, the resonances, and the
    /// cheapest method of every regime.
    fn text(&self) -> String {
        let mut text = format!(
            "{}: {} sites, alpha = {}, kappa = {}, rho = {}, amplitude {}\n",
            self.problem.name(),
            self.problem.chain().sites,
            self.problem.chain().alpha,
            self.problem.chain().kappa,
            self.problem.chain().rho,
            self.problem.amplitude()
        );
        for &chart in &self.charts {
            text += &format!("\n{}\n\n", heading(chart));
            text += &match chart {
                Chart::Resonances => resonances_table(self),
                Chart::Struck => struck_table(self),
                _ => errors_table(self, chart),
            };
        }
        let regimes = regimes(self);
        if !regimes.is_empty() {
            text += "\nFewest force evaluations for an energy error below\n\n";
            text += &regimes_table(&regimes);
            text += "\nh Omega: step times max(omega, Omega_c); >: no longer step was tried; tol: of an adaptive method, h is then its mean step. Cost: force\n\
                 evaluations a unit of time.\n";
        }
        text += &format!(
            "\n{} points computed, {} resumed, {:.1} s\n",
            computed(self),
            self.resumed,
            self.wall.as_secs_f64()
        );
        text
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = vec![("stability.json".to_owned(), json.into())];
        files.extend(csv_files(self));
        Ok(files)
    }

    /// Heat maps of every chart.
    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        let mut pictures = Vec::new();
        for &chart in &self.charts {
            let name = chart.name();
            if chart == Chart::Resonances {
                if !self.resonances.is_empty() {
                    pictures.push((format!("{name}.png"), crate::figures::matrix(&resonance_matrix(self))?));
                }
                continue;
            }
            if chart == Chart::Struck {
                if !self.struck.is_empty() {
                    pictures.push((format!("{name}.png"), crate::figures::maps(&struck_map(self))?));
                }
                continue;
            }
            pictures.push((format!("{name}.png"), crate::figures::matrix(&error_matrix(self, chart))?));
            let maps: Vec<(String, String, crate::figures::CellMap)> = match chart {
                Chart::Light => shown(self).iter().filter_map(|method| step_map(self, method)).collect(),
                Chart::Stiffness => shown(self).iter().map(|method| stiffness_map(self, method)).collect(),
                _ => Vec::new(),
            };
            for (title, caption, map) in maps {
                let file = format!("{name}-{}.png", title.split(':').next().unwrap_or_default());
                let caption = format!("{} {caption}", provenance(self, chart));
                let figure = crate::figures::Maps { title, maps: vec![map], caption };
                pictures.push((file, crate::figures::maps(&figure)?));
            }
        }
        Ok(pictures)
    }
}

/// Number of points that were computed, not read from stores.
fn computed(study: &ChartStudy) -> usize {
    study.points.len() + study.resonances.len() + study.struck.len() - study.resumed
}

fn point_json(point: &ChartPoint) -> Value {
    let mut value = json!({"chart": point.chart, "integrator": point.method.name()});
    for (name, given) in values(&point.variant) {
        value[name] = json!(given);
    }
    match &point.measured {
        Ok(Measured { contact, fast, span, usual, ladder, limits, stability }) => {
            value["contact_frequency"] = json!(contact);
            value["fast_frequency"] = json!(fast);
            value["span"] = json!(span);
            value["verdict"] = json!(usual.verdict);
            value["energy_error"] = json!(usual.error);
            value["usual"] = json!(usual);
            value["limits"] = json!(limits);
            value["stability_limit"] = json!(stability);
            value["ladder"] = json!(ladder);
        }
        Err(why) => value["refused"] = json!(why),
    }
    value
}

fn resonance_json(point: &ResonancePoint) -> Value {
    let mut value = json!({
        "integrator": point.method.name(),
        "k": point.k,
        "amplitude": point.amplitude,
        "kick_sum": kick_sum(&point.method, point.k),
    });
    match &point.resonance {
        Ok(found) => {
            value["resonance"] = json!(found);
            value["width"] = json!(found.as_ref().map(|found| found.edges[1] - found.edges[0]));
        }
        Err(why) => value["refused"] = json!(why),
    }
    value
}

fn struck_json(point: &StruckPoint) -> Value {
    let mut value = json!({"sites": point.sites, "alpha": point.alpha, "rho": point.rho});
    match &point.runs {
        Ok(measured) => {
            value["until"] = json!(measured.until);
            value["amplification"] = json!(measured.amplification);
            let run = |run| {
                let mut value = json!(run);
                value["ratio"] = json!(measured.ratio(run));
                value
            };
            value["runs"] = measured.runs.iter().map(run).collect();
        }
        Err(why) => value["refused"] = json!(why),
    }
    value
}

/// What a variant changes, by name.
fn values(variant: &Variant) -> Vec<(&'static str, f64)> {
    let Variant { rho, kappa, alpha, amplitude, sites, periods } = *variant;
    [
        ("rho", rho),
        ("kappa", kappa),
        ("alpha", alpha),
        ("amplitude", amplitude),
        ("sites", sites.map(|n| n as f64)),
        ("periods", periods),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name, value?)))
    .collect()
}

/// The parameters that tell the variants of a chart apart.
fn axes(chart: Chart) -> &'static [&'static str] {
    match chart {
        Chart::Light => &["rho"],
        Chart::Stiffness => &["amplitude", "kappa"],
        Chart::Alpha => &["alpha"],
        Chart::Length => &["sites"],
        Chart::Time => &["periods"],
        Chart::Resonances => &["sites", "amplitude"],
        Chart::Struck => &[],
    }
}

fn place(chart: Chart, variant: &Variant) -> Vec<f64> {
    let values = values(variant);
    axes(chart)
        .iter()
        .filter_map(|name| values.iter().find(|(other, _)| other == name).map(|(_, value)| *value))
        .collect()
}

/// The charts as CSV files by name: a line a point. Charts of variants have the runs of their
/// ladders in a second file. A cell is empty if there is no value.
fn csv_files(study: &ChartStudy) -> Vec<File> {
    let mut files = Vec::new();
    for &chart in &study.charts {
        let name = chart.name();
        if chart == Chart::Resonances {
            files.push((format!("{name}.csv"), resonances_csv(study)));
            continue;
        }
        if chart == Chart::Struck {
            files.push((format!("{name}.csv"), struck_csv(study)));
            continue;
        }
        files.push((format!("{name}.csv"), points_csv(study, chart)));
        files.push((format!("{name}-ladder.csv"), ladder_csv(study, chart)));
    }
    files
}

fn cell(value: Option<f64>) -> String {
    value.map(|value| format!("{value:e}")).unwrap_or_default()
}

fn word(verdict: ChartVerdict) -> &'static str {
    match verdict {
        ChartVerdict::Stable => "stable",
        ChartVerdict::Drifting => "drifting",
        ChartVerdict::Lost => "lost",
        ChartVerdict::Dear => "dear",
    }
}

fn points_csv(study: &ChartStudy, chart: Chart) -> Vec<u8> {
    let mut text = format!(
        "integrator,{},contact_frequency,fast_frequency,span,verdict,energy_error,step,cost,step_1e-3,cost_1e-3,step_1e-6,cost_1e-6,stability_limit,why\n",
        axes(chart).join(",")
    );
    for point in study.of(chart) {
        let place: Vec<String> = place(chart, &point.variant).into_iter().map(|value| format!("{value:e}")).collect();
        let _ = write!(text, "{},{},", point.method.name(), place.join(","));
        match &point.measured {
            Ok(measured) => {
                let usual = &measured.usual;
                let limits = measured.limits.iter().flat_map(|limit| {
                    let of = |value: fn(&Trial) -> f64| cell(limit.trial.as_ref().map(value));
                    [of(|trial| trial.step), of(|trial| trial.cost)]
                });
                let cells: Vec<String> = [
                    format!("{:e}", measured.contact),
                    format!("{:e}", measured.fast),
                    format!("{:e}", measured.span),
                    word(usual.verdict).to_owned(),
                    cell(usual.error),
                    format!("{:e}", usual.step),
                    format!("{:e}", usual.cost),
                ]
                .into_iter()
                .chain(limits)
                .chain([cell(measured.stability), usual.failure.clone().unwrap_or_default().replace(',', ";")])
                .collect();
                text += &(cells.join(",") + "\n");
            }
            Err(why) => {
                let _ = writeln!(text, ",,,refused,,,,,,,,,{}", why.replace(',', ";"));
            }
        }
    }
    text.into_bytes()
}

fn ladder_csv(study: &ChartStudy, chart: Chart) -> Vec<u8> {
    let mut text = format!("integrator,{},step,tol,h_fast,verdict,energy_error,cost\n", axes(chart).join(","));
    for point in study.of(chart) {
        let Ok(measured) = &point.measured else { continue };
        let place: Vec<String> = place(chart, &point.variant).into_iter().map(|value| format!("{value:e}")).collect();
        for trial in &measured.ladder {
            let cells = [
                point.method.name(),
                place.join(","),
                format!("{:e}", trial.step),
                cell(trial.tol),
                format!("{:e}", trial.step * measured.fast),
                word(trial.verdict).to_owned(),
                cell(trial.error),
                format!("{:e}", trial.cost),
            ];
            text += &(cells.join(",") + "\n");
        }
    }
    text.into_bytes()
}

fn resonances_csv(study: &ChartStudy) -> Vec<u8> {
    let mut text =
        String::from("integrator,k,amplitude,kick_sum,lower,upper,centre,width,growth,error_inside,error_beside,why\n");
    for point in &study.resonances {
        let _ = write!(
            text,
            "{},{},{:e},{},",
            point.method.name(),
            point.k,
            point.amplitude,
            cell(kick_sum(&point.method, point.k))
        );
        let line = match &point.resonance {
            Ok(Some(found)) => format!(
                "{:e},{:e},{:e},{:e},{:e},{},{},",
                found.edges[0],
                found.edges[1],
                found.centre,
                found.edges[1] - found.edges[0],
                found.growth,
                cell(found.inside),
                cell(found.beside)
            ),
            Ok(None) => ",,,,,,,none found that stands apart and grows by more than 1e-6 a step".to_owned(),
            Err(why) => format!(",,,,,,,{}", why.replace(',', ";")),
        };
        text += &(line + "\n");
    }
    text.into_bytes()
}

fn struck_csv(study: &ChartStudy) -> Vec<u8> {
    let mut text = String::from("sites,alpha,rho,until,amplification,tol,error,ratio,windows,force_evaluations,why\n");
    for point in &study.struck {
        let StruckPoint { sites, alpha, rho, .. } = point;
        match &point.runs {
            Ok(measured) => {
                for run in &measured.runs {
                    let cells = [measured.until, measured.amplification, run.tol].map(|value| format!("{value:e}"));
                    let errors = [cell(run.error), cell(measured.ratio(run))];
                    let work = format!("{},{}", run.windows, run.force_evaluations);
                    let why = if run.error.is_some() { "" } else { "failed" };
                    let _ =
                        writeln!(text, "{sites},{alpha},{rho},{},{},{work},{why}", cells.join(","), errors.join(","));
                }
            }
            Err(why) => {
                let _ = writeln!(text, "{sites},{alpha},{rho},,,,,,,,{}", why.replace(',', ";"));
            }
        }
    }
    text.into_bytes()
}

/// The cells of the chart of struck chains: number of beads, tolerance, and the largest error in
/// units of tolerance times amplification over the chains of that length; `None` where a run
/// failed.
fn struck_cells(study: &ChartStudy) -> Vec<(usize, f64, Option<f64>)> {
    let mut cells = Vec::new();
    for points in study.struck.chunk_by(|a, b| a.sites == b.sites) {
        for (k, &tol) in TOLERANCES.iter().enumerate() {
            let ratio = |point: &StruckPoint| {
                let measured = point.runs.as_ref().ok()?;
                measured.ratio(&measured.runs[k])
            };
            let worst = points.iter().try_fold(0.0f64, |worst, point| Some(worst.max(ratio(point)?)));
            cells.push((points[0].sites, tol, worst));
        }
    }
    cells
}

fn struck_table(study: &ChartStudy) -> String {
    let cells = struck_cells(study);
    let names: Vec<String> = TOLERANCES.iter().map(|tol| format!("tol {tol:e}")).collect();
    let head: Vec<&str> = ["N"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let word = |ratio: Option<f64>| ratio.map_or_else(|| "failed".to_owned(), |ratio| format!("{ratio:.0e}"));
    let row = |cells: &[(usize, f64, Option<f64>)]| {
        [cells[0].0.to_string()].into_iter().chain(cells.iter().map(|cell| word(cell.2))).collect()
    };
    let rows: Vec<Vec<String>> = cells.chunk_by(|a, b| a.0 == b.0).map(row).collect();
    table(&head, &rows)
        + "The largest error over all exponents and mass ratios, in units of tolerance times amplification: how many times larger the motion makes an error.\n"
}

/// The cheapest method for a variant, and its step.
struct Cheapest {
    chart: Chart,
    variant: Variant,
    /// For each bound: the method, its limit, `Omega_c` and `max(omega, Omega_c)`; `None` if no
    /// method meets the bound.
    best: Vec<Option<(Method, Limit, f64, f64)>>,
}

impl Cheapest {
    fn json(&self) -> Value {
        let best = |entry: &Option<(Method, Limit, f64, f64)>| {
            entry.as_ref().map(|(method, limit, _, fast)| {
                let trial = limit.trial.as_ref();
                json!({
                    "bound": limit.bound,
                    "integrator": method.name(),
                    "step": trial.map(|trial| trial.step),
                    "h_fast": trial.map(|trial| trial.step * fast),
                    "tol": trial.and_then(|trial| trial.tol),
                    "cost": trial.map(|trial| trial.cost),
                    "longest": limit.longest,
                })
            })
        };
        let mut value = json!({"chart": self.chart, "best": self.best.iter().map(best).collect::<Vec<_>>()});
        for (name, given) in values(&self.variant) {
            value[name] = json!(given);
        }
        value
    }
}

fn regimes(study: &ChartStudy) -> Vec<Cheapest> {
    let mut regimes = Vec::new();
    for &chart in &study.charts {
        for variant in study.variants(chart) {
            let best = |nth: usize| {
                let (method, limit, _) = study.cheapest(chart, &variant, nth)?;
                let measured = study.point(chart, &variant, &method)?.measured.as_ref().ok()?;
                Some((method, limit.clone(), measured.contact, measured.fast))
            };
            regimes.push(Cheapest { chart, variant, best: (0..BOUNDS.len()).map(best).collect() });
        }
    }
    regimes
}

fn parameters(variant: &Variant) -> String {
    values(variant).iter().map(|(name, value)| format!("{name} {}", plain(*value))).collect::<Vec<_>>().join(", ")
}

fn plain(value: f64) -> String {
    if (1e-2..1e4).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

fn heading(chart: Chart) -> &'static str {
    match chart {
        Chart::Light => {
            "light: energy error at 64 kicks a period of the fastest motion (adaptive: tol 1e-9) against rho; then the step above which the energy has no bound, at the lightest"
        }
        Chart::Stiffness => {
            "stiffness: the worst energy error at 64 kicks a period (adaptive: tol 1e-9) over all kappa, against the amplitude A"
        }
        Chart::Alpha => "alpha: energy error at 64 kicks a period (adaptive: tol 1e-9) against the exponent",
        Chart::Length => "length: energy error at 64 kicks a period (adaptive: tol 1e-9) against the number of sites",
        Chart::Time => {
            "time: energy error at 64 kicks a period (adaptive: tol 1e-9) against the length of the run in contact periods"
        }
        Chart::Resonances => {
            "resonances of schemes on the exact linear flow, one bead pressed between walls: width in h omega and growth a step"
        }
        Chart::Struck => {
            "struck: error of collocation on free chains at rest whose first bead is struck, against the number of beads and the tolerance"
        }
    }
}

/// The error with a `d` if it drifts, or a word if there is none.
fn error_cell(point: &ChartPoint) -> String {
    match &point.measured {
        Err(_) => "refused".to_owned(),
        Ok(measured) => {
            let usual = &measured.usual;
            let letter = match usual.verdict {
                ChartVerdict::Stable => "",
                ChartVerdict::Drifting => "d",
                ChartVerdict::Lost => return "lost".to_owned(),
                ChartVerdict::Dear => return "dear".to_owned(),
            };
            usual.error.map(|error| format!("{error:.0e}{letter}")).unwrap_or_default()
        }
    }
}

/// A rank that is larger for a worse point: the table shows the worst point of a cell.
fn badness(point: &ChartPoint) -> f64 {
    match &point.measured {
        Err(_) => f64::INFINITY,
        Ok(measured) if measured.usual.verdict == ChartVerdict::Dear => 1e9,
        Ok(measured) => measured.usual.error.unwrap_or(1e8),
    }
}

fn errors_table(study: &ChartStudy, chart: Chart) -> String {
    let mut columns: Vec<f64> = study.variants(chart).iter().map(|variant| place(chart, variant)[0]).collect();
    columns.dedup();
    let names: Vec<String> = columns.iter().map(|&value| plain(value)).collect();
    let mut head = vec!["integrator"];
    head.extend(names.iter().map(String::as_str));
    if chart == Chart::Light {
        head.extend(["h omega", "h Omega_c"]);
    }
    let rows: Vec<Vec<String>> = study
        .methods
        .iter()
        .map(|method| {
            let of_method: Vec<&ChartPoint> = study.of(chart).filter(|point| point.method == *method).collect();
            let worst = |&column: &f64| {
                let points = of_method.iter().filter(|point| place(chart, &point.variant)[0] == column);
                points
                    .max_by(|a, b| badness(a).total_cmp(&badness(b)))
                    .map(|point| error_cell(point))
                    .unwrap_or_default()
            };
            let lightest = of_method.first().and_then(|point| point.measured.as_ref().ok());
            let limit = |measured: &Measured| {
                Some((measured.stability?, measured.stability? * measured.contact / measured.fast))
            };
            let limits = lightest.and_then(limit).map_or([String::new(), String::new()], |limit| {
                [format!("{:.3}", limit.0), format!("{:.1e}", limit.1)]
            });
            let last = if chart == Chart::Light { limits.to_vec() } else { Vec::new() };
            [method.name()].into_iter().chain(columns.iter().map(worst)).chain(last).collect()
        })
        .collect();
    table(&head, &rows)
        + "d: drifting, of collocation only above its tolerance. lost: above 1, or failed. dear: not finished within twenty times the work of a run.\n"
}

fn resonances_table(study: &ChartStudy) -> String {
    let mut rows = Vec::new();
    for points in study.resonances.chunk_by(|a, b| a.method == b.method && a.k == b.k) {
        let cell = |point: &ResonancePoint| match &point.resonance {
            Ok(Some(found)) => format!("{:.1e} {:.1e}", found.edges[1] - found.edges[0], found.growth),
            Ok(None) => "–".to_owned(),
            Err(_) => "failed".to_owned(),
        };
        let first = &points[0];
        let sum = kick_sum(&first.method, first.k).map(|sum| format!("{sum:.3}")).unwrap_or_default();
        rows.push(
            [first.method.name(), format!("{}", first.k), sum].into_iter().chain(points.iter().map(cell)).collect(),
        );
    }
    let mut amplitudes: Vec<f64> = study.resonances.iter().map(|point| point.amplitude).collect();
    amplitudes.sort_by(f64::total_cmp);
    amplitudes.dedup();
    let names: Vec<String> = amplitudes.iter().map(|a| format!("A = {a:e}")).collect();
    let mut head = vec!["integrator", "k", "|S_k|"];
    head.extend(names.iter().map(String::as_str));
    table(&head, &rows)
        + "Near h omega = k pi, at a static overlap A. –: none found that stands apart and grows by more than 1e-6 a step. |S_k|: the sum of the kicks b_j e^(2 pi i k c_j).\n"
}

fn regimes_table(regimes: &[Cheapest]) -> String {
    let rows: Vec<Vec<String>> = regimes
        .iter()
        .map(|regime| {
            let best = regime.best.iter().flat_map(|best| match best {
                None => ["none".to_owned(), String::new(), String::new()],
                Some((method, limit, _, fast)) => {
                    let Some(trial) = &limit.trial else { return Default::default() };
                    let more = if limit.longest { ">" } else { "" };
                    let step = match trial.tol {
                        Some(tol) => format!("tol {tol:.0e}, h Omega {:.2}", trial.step * fast),
                        None => format!("{more}{:.3}", trial.step * fast),
                    };
                    [method.name(), step, format!("{:.1e}", trial.cost)]
                }
            });
            [regime.chart.name().to_owned(), parameters(&regime.variant)].into_iter().chain(best).collect()
        })
        .collect();
    table(&["chart", "regime", "1e-3", "h Omega", "cost", "1e-6", "h Omega", "cost"], &rows)
}

/// The methods that have maps of their own: of these four those that were charted, else the first
/// three.
#[cfg(feature = "plot")]
fn shown(study: &ChartStudy) -> Vec<Method> {
    const NAMES: [&str; 4] = ["verlet", "strang-linear", "aba1064-linear", "collocation"];
    let methods = &study.methods;
    let known: Vec<Method> = methods.iter().copied().filter(|method| NAMES.contains(&method.name().as_str())).collect();
    if known.is_empty() { methods.iter().copied().take(3).collect() } else { known }
}

/// The parameters that a chart does not vary.
#[cfg(feature = "plot")]
fn provenance(study: &ChartStudy, chart: Chart) -> String {
    let chain = study.problem.chain();
    let all = [
        ("sites", "N", chain.sites as f64),
        ("alpha", "α", chain.alpha),
        ("kappa", "κ", chain.kappa),
        ("rho", "ρ", chain.rho),
        ("amplitude", "A", study.problem.amplitude()),
    ];
    let fixed = all.iter().filter(|(name, _, _)| !axes(chart).contains(name));
    let words: Vec<String> =
        fixed.map(|(_, symbol, value)| format!("{symbol} = {}", crate::number::written(*value))).collect();
    format!("Scene {}: {}. hertzchain {}.", study.problem.name(), words.join(", "), env!("CARGO_PKG_VERSION"))
}

/// The error as a value on the colour scale, from 1e-16 (rounding) to 10 (lost); 0 (grey) for a run
/// that was not finished.
#[cfg(feature = "plot")]
fn shade(trial: &Trial) -> f64 {
    match (trial.verdict, trial.error) {
        (ChartVerdict::Dear, _) => 0.0,
        (ChartVerdict::Lost, _) | (_, None) => 10.0,
        (_, Some(error)) => error.clamp(1e-16, 10.0),
    }
}

/// Minus the decimal logarithm of the error, rounded, with a `d` if it drifts.
#[cfg(feature = "plot")]
fn note(point: &ChartPoint) -> String {
    match &point.measured {
        Err(_) => "–".to_owned(),
        Ok(measured) => match (measured.usual.verdict, measured.usual.error) {
            (ChartVerdict::Lost, _) | (_, None) => "lost".to_owned(),
            (ChartVerdict::Dear, _) => "dear".to_owned(),
            (verdict, Some(error)) => {
                let letter = if verdict == ChartVerdict::Drifting { "d" } else { "" };
                format!("{:.0}{letter}", (-error.clamp(1e-16, 1.0).log10()).abs())
            }
        },
    }
}

#[cfg(feature = "plot")]
fn error_matrix(study: &ChartStudy, chart: Chart) -> crate::figures::Matrix {
    let variants = study.variants(chart);
    let column = |variant: &Variant| {
        let words: Vec<String> = place(chart, variant).into_iter().map(plain).collect();
        words.join(", ")
    };
    let (mut values, mut notes) = (Vec::new(), Vec::new());
    for method in &study.methods {
        for variant in &variants {
            let point = study.point(chart, variant, method);
            values.push(
                point.and_then(|point| point.measured.as_ref().ok()).map_or(0.0, |measured| shade(&measured.usual)),
            );
            notes.push(point.map(note).unwrap_or_default());
        }
    }
    let (title, label) = match chart {
        Chart::Light => ("Light and heavy resonators", "mass ratio ρ"),
        Chart::Stiffness => ("Stiffness of contacts and springs", "amplitude A, spring constant κ"),
        Chart::Alpha => ("Exponent of the contact force", "exponent α"),
        Chart::Length => ("Length of the chain", "number of sites N"),
        Chart::Time => ("Length of the run", "contact periods"),
        Chart::Resonances | Chart::Struck => ("", ""),
    };
    crate::figures::Matrix {
        title: format!("{title}: energy error at 64 kicks a period of the fastest motion, or tolerance 10⁻⁹"),
        rows: study.methods.iter().map(Method::name).collect(),
        columns: variants.iter().map(column).collect(),
        labels: [label.to_owned(), "largest |H − H(0)|/|H(0)|".to_owned()],
        values,
        notes,
        caption: format!(
            "{} In cells: −log₁₀ of the error; d: drifting, of collocation only above its tolerance, which bounds the sum of all local errors; lost: above 1 or failed; dear: not finished within twenty times the work of a run; –: not tried.",
            provenance(study, chart)
        ),
    }
}

/// Rows of the map of steps: `h Omega` from 12 down to 0.1, each the one before over `sqrt 2`.
#[cfg(feature = "plot")]
const STEP_ROWS: i32 = 14;

/// Title, caption and map of the energy error over mass ratio and step; none for adaptive methods.
#[cfg(feature = "plot")]
fn step_map(study: &ChartStudy, method: &Method) -> Option<(String, String, crate::figures::CellMap)> {
    use std::f64::consts::PI;
    let rung = |h_fast: f64| (2.0 * (12.0 / h_fast).log2()).round() as i32;
    let variants = study.variants(Chart::Light);
    let x: Vec<f64> = variants.iter().filter_map(|variant| variant.rho).collect();
    let rows = || (0..STEP_ROWS).rev();
    let value = |row: i32, variant: &Variant| {
        let measured = study.point(Chart::Light, variant, method)?.measured.as_ref().ok()?;
        measured.ladder.iter().find(|trial| rung(trial.step * measured.fast) == row).map(shade)
    };
    let mut values = Vec::new();
    for row in rows() {
        values.extend(variants.iter().map(|variant| value(row, variant).unwrap_or(0.0)));
    }
    let (first, last) = (x.first().copied()?, x.last().copied()?);
    let line = |name: &str, height: f64| crate::figures::Line {
        name: format!("hΩ = {name}"),
        points: vec![(first, height), (last, height)],
    };
    let lines = match method {
        Method::Splitting(_, crate::run::method::Split::Kinetic)
        | Method::Corrected(_, crate::run::method::Split::Kinetic)
        | Method::Conserving => {
            vec![line("2", 2.0)]
        }
        _ => vec![line("π", PI), line("2π", 2.0 * PI), line("3π", 3.0 * PI)],
    };
    let map = crate::figures::CellMap {
        labels: ["mass ratio ρ", "step hΩ", "largest |H − H(0)|/|H(0)|"].map(str::to_owned),
        notes: vec![String::new(); values.len()],
        y: rows().map(|row| 12.0 * f64::powf(2.0, -0.5 * f64::from(row))).collect(),
        lines,
        x,
        values,
        apart: Vec::new(),
    };
    let caption =
        "Ω is the larger of ω and Ω_c. Top of the scale: lost. Grey: more work than a run may take.".to_owned();
    (!method.adaptive()).then(|| (format!("{}: energy error over step and mass ratio", method.name()), caption, map))
}

/// Title, caption and map of the energy error over amplitude and spring constant, with the cost in
/// the cells.
#[cfg(feature = "plot")]
fn stiffness_map(study: &ChartStudy, method: &Method) -> (String, String, crate::figures::CellMap) {
    let variants = study.variants(Chart::Stiffness);
    let distinct = |of: fn(&Variant) -> Option<f64>| {
        let mut values: Vec<f64> = variants.iter().filter_map(of).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (x, y) = (distinct(|variant| variant.amplitude), distinct(|variant| variant.kappa));
    let (mut values, mut notes) = (Vec::new(), Vec::new());
    for &kappa in &y {
        for &amplitude in &x {
            let variant = Variant { amplitude: Some(amplitude), kappa: Some(kappa), ..Variant::default() };
            let point = study.point(Chart::Stiffness, &variant, method);
            let measured = point.and_then(|point| point.measured.as_ref().ok());
            values.push(measured.map_or(0.0, |measured| shade(&measured.usual)));
            let cost = |measured: &Measured| {
                let trial = measured.limits.get(1)?.trial.as_ref()?;
                let a_period = trial.cost * std::f64::consts::TAU / measured.contact;
                Some(if a_period < 1e4 { format!("{a_period:.0}") } else { format!("{a_period:.0e}") })
            };
            notes.push(measured.and_then(cost).unwrap_or_else(|| "–".to_owned()));
        }
    }
    let map = crate::figures::CellMap {
        labels: ["amplitude A", "spring constant κ", "largest |H − H(0)|/|H(0)|"].map(str::to_owned),
        x,
        y,
        values,
        notes,
        ..crate::figures::CellMap::default()
    };
    let title = format!("{}: energy error over amplitude and spring constant, and what 10⁻⁶ costs", method.name());
    let caption = "Colour: at 64 kicks a period of the fastest motion, or tolerance 10⁻⁹, over ten contact periods 2π/Ω_c. In cells: force evaluations a contact period \
                   for an error below 10⁻⁶; –: more than a run may take.";
    (title, caption.to_owned(), map)
}

#[cfg(feature = "plot")]
fn resonance_matrix(study: &ChartStudy) -> crate::figures::Matrix {
    let mut methods: Vec<Method> = study.resonances.iter().map(|point| point.method).collect();
    methods.dedup();
    let first: Vec<&ResonancePoint> =
        study.resonances.iter().filter(|point| Some(&point.method) == methods.first()).collect();
    let found = |point: &ResonancePoint| point.resonance.as_ref().ok().cloned().flatten();
    let note = |point: &ResonancePoint| {
        found(point).map_or_else(|| "–".to_owned(), |found| format!("{:.1}", found.growth.log10()).replace('-', "−"))
    };
    crate::figures::Matrix {
        title: "Resonances of the exact linear flow near hω = kπ: growth a step".to_owned(),
        rows: methods.iter().map(Method::name).collect(),
        columns: first.iter().map(|point| format!("k = {}, A = {}", point.k, plain(point.amplitude))).collect(),
        labels: ["multiple k of π and static overlap A".to_owned(), "growth a step, ln |λ|".to_owned()],
        values: study.resonances.iter().map(|point| found(point).map_or(0.0, |found| found.growth)).collect(),
        notes: study.resonances.iter().map(note).collect(),
        caption: format!(
            "{} One bead between walls, pressed by A: spectral radius of the matrix of a step. In cells: decimal logarithm of the growth; –: none found that stands apart and grows by more than 10⁻⁶ a step.",
            provenance(study, Chart::Resonances)
        ),
    }
}

/// A number to two digits.
#[cfg(feature = "plot")]
fn two_digits(x: f64) -> String {
    crate::number::shown(format!("{x:.1e}").parse().unwrap_or(x))
}

#[cfg(feature = "plot")]
fn struck_map(study: &ChartStudy) -> crate::figures::Maps {
    let cells = struck_cells(study);
    let mut x: Vec<f64> = cells.iter().map(|cell| cell.0 as f64).collect();
    x.dedup();
    let y: Vec<f64> = TOLERANCES.iter().rev().copied().collect();
    let of = |sites: f64, tol: f64| cells.iter().find(|cell| cell.0 as f64 == sites && cell.1 == tol);
    let (mut values, mut notes) = (Vec::new(), Vec::new());
    for &tol in &y {
        for &sites in &x {
            let ratio = of(sites, tol).and_then(|cell| cell.2);
            values.push(ratio.unwrap_or(0.0).max(if ratio.is_some() { f64::MIN_POSITIVE } else { 0.0 }));
            notes.push(ratio.map_or_else(|| "failed".to_owned(), two_digits));
        }
    }
    let label = ["number of beads N", "tolerance", "error/(tolerance × amplification)"].map(str::to_owned);
    let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    crate::figures::Maps {
        title: "collocation: free chains at rest whose first bead is struck".to_owned(),
        maps: vec![crate::figures::CellMap {
            labels: label,
            x,
            y,
            values,
            notes,
            lines: Vec::new(),
            apart: Vec::new(),
        }],
        caption: format!(
            "The largest over α = {} and ρ = {}, κ = {}, until t = N/5; error of the state relative to its largest position or velocity, against tolerance 10⁻¹². \
             Amplification: how many times larger the motion makes an error of velocities, made at the start or half way. hertzchain {}.",
            list(&EXPONENTS),
            list(&MASS_RATIOS),
            study.problem.chain().kappa,
            env!("CARGO_PKG_VERSION")
        ),
    }
}
