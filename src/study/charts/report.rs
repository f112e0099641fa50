//! The report of the charts of stability.

use super::{
    BOUNDS, Chart, ChartPoint, ChartStudy, Limit, Measured, ResonancePoint, Trial, Variant, Verdict as ChartVerdict,
    kick_sum,
};
use crate::{
    present::machine_json,
    report::{
        CellMap,
        Digits::{Fixed, Hidden, Power, Short},
        Line, Maps, Matrix, Report, Rows, Table,
    },
    run::method::Method,
};
use serde_json::{Value, json};

/// The verdict and the error of every method at its usual step, the resonances, and the cheapest
/// method of every regime. `wall` is seconds a unit of time, and depends on the load of the machine.
pub(super) fn report(study: &ChartStudy) -> Report {
    let chain = study.problem.chain();
    let regimes = regimes(study);
    let mut report = Report::new("stability")
        .fact("scene", study.problem.name())
        .fact("chain", chain)
        .fact("amplitude", study.problem.amplitude())
        .fact("bounds", BOUNDS)
        .fact("work", study.work)
        .fact("points", study.points.iter().map(point_json).collect::<Vec<_>>())
        .fact("resonances", study.resonances.iter().map(resonance_json).collect::<Vec<_>>())
        .fact("regimes", regimes.iter().map(Cheapest::json).collect::<Vec<_>>())
        .fact("computed", computed(study))
        .fact("resumed", study.resumed)
        .fact("wall_s", study.wall.as_secs_f64())
        .fact("machine", machine_json())
        .words(format!(
            "{}: {} sites, alpha = {}, kappa = {}, rho = {}, amplitude {}",
            study.problem.name(),
            chain.sites,
            chain.alpha,
            chain.kappa,
            chain.rho,
            study.problem.amplitude()
        ));
    for &chart in &study.charts {
        report = report.words(heading(chart));
        report = match chart {
            Chart::Resonances => report.table(resonances(study)).words(RESONANCES),
            _ => {
                report.table(errors(study, chart)).words(ERRORS).table(points(study, chart)).table(ladder(study, chart))
            }
        };
        for (name, figure) in pictures(study, chart) {
            report = report.picture_named(&name, figure);
        }
    }
    if !regimes.is_empty() {
        report = report.words("Fewest force evaluations for an energy error below 1e-3 and below 1e-6:");
        report = report.table(cheapest(&regimes)).words(CHEAPEST);
    }
    let [computed, seconds] = [computed(study).to_string(), format!("{:.1}", study.wall.as_secs_f64())];
    report.words(format!("{computed} points computed, {} resumed, {seconds} s", study.resumed))
}

const ERRORS: &str = "d: drifting, of collocation only above its tolerance. lost: above 1, or failed. dear: not finished within twenty times the work of a run.";
const RESONANCES: &str =
    "Near h omega = k pi, at a static overlap A; kick_sum: |S_k|, the sum of the kicks b_j e^(2 pi i k c_j).";
const CHEAPEST: &str = "h Omega: step times max(omega, Omega_c); >: no longer step was tried; tol: of an adaptive method, h is then its mean step. Cost: force evaluations a unit of time.";

/// Number of points that were computed, not read from stores.
fn computed(study: &ChartStudy) -> usize {
    study.points.len() + study.resonances.len() - study.resumed
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
    }
}

fn place(chart: Chart, variant: &Variant) -> Vec<f64> {
    let values = values(variant);
    axes(chart)
        .iter()
        .filter_map(|name| values.iter().find(|(other, _)| other == name).map(|(_, value)| *value))
        .collect()
}

/// Columns for the parameters of a chart, and one for the method before them.
fn placed<T>(table: Rows<'_, T>, chart: Chart, point: impl Fn(&T) -> &ChartPoint + Copy) -> Rows<'_, T> {
    let table = table.key("").col("integrator", Hidden, "method", move |row| point(row).method.name());
    axes(chart).iter().enumerate().fold(table, |table, (k, name)| {
        table.col(*name, Hidden, "parameter of the chart", move |row| place(chart, &point(row).variant)[k])
    })
}

/// The points of a chart, a row each.
fn points(study: &ChartStudy, chart: Chart) -> Table {
    let points: Vec<&ChartPoint> = study.of(chart).collect();
    let of = |get: fn(&Measured) -> f64| move |point: &&ChartPoint| point.measured.as_ref().ok().map(get);
    let usual = |point: &&ChartPoint| point.measured.as_ref().ok().and_then(|measured| measured.usual.error);
    let limit = |nth: usize, get: fn(&Trial) -> f64| {
        move |point: &&ChartPoint| {
            let measured = point.measured.as_ref().ok()?;
            measured.limits.get(nth)?.trial.as_ref().map(get)
        }
    };
    let verdict =
        |point: &&ChartPoint| point.measured.as_ref().map_or("refused", |measured| word(measured.usual.verdict));
    let why = |point: &&ChartPoint| match &point.measured {
        Ok(measured) => measured.usual.failure.clone(),
        Err(why) => Some(why.clone()),
    };
    placed(Table::of(chart.name(), &points), chart, |point| point)
        .col("contact_frequency", Hidden, "Omega_c", of(|measured| measured.contact))
        .col("fast_frequency", Hidden, "max(omega, Omega_c)", of(|measured| measured.fast))
        .col("span", Hidden, "length of the runs", of(|measured| measured.span))
        .col("verdict", Hidden, "stable, drifting, lost, dear or refused", verdict)
        .col("energy_error", Hidden, "largest |H - H(0)|/|H(0)| at the usual step", usual)
        .col("step", Hidden, "the usual step", of(|measured| measured.usual.step))
        .col("cost", Hidden, "force evaluations a unit of time with it", of(|measured| measured.usual.cost))
        .col("step_1e-3", Hidden, "largest step with an error below 1e-3", limit(0, |trial| trial.step))
        .col("cost_1e-3", Hidden, "cost of that step", limit(0, |trial| trial.cost))
        .col("step_1e-6", Hidden, "largest step with an error below 1e-6", limit(1, |trial| trial.step))
        .col("cost_1e-6", Hidden, "cost of that step", limit(1, |trial| trial.cost))
        .col("stability_limit", Hidden, "step times the fast frequency above which the error has no bound", |point| {
            point.measured.as_ref().ok().and_then(|measured| measured.stability)
        })
        .col("why", Hidden, "why there is no result", why)
        .done()
}

/// All steps of the points of a chart, a row each.
fn ladder(study: &ChartStudy, chart: Chart) -> Table {
    let rows: Vec<(&ChartPoint, &Trial, f64)> = study
        .of(chart)
        .filter_map(|point| Some((point, point.measured.as_ref().ok()?)))
        .flat_map(|(point, measured)| measured.ladder.iter().map(move |trial| (point, trial, measured.fast)))
        .collect();
    placed(Table::of(format!("{}-ladder", chart.name()), &rows), chart, |row| row.0)
        .col("step", Hidden, "step, of an adaptive method the mean one", |row| row.1.step)
        .col("tol", Hidden, "tolerance of an adaptive method", |row| row.1.tol)
        .col("h_fast", Hidden, "step times the fast frequency", |row| row.1.step * row.2)
        .col("verdict", Hidden, "stable, drifting, lost or dear", |row| word(row.1.verdict))
        .col("energy_error", Hidden, "largest |H - H(0)|/|H(0)|", |row| row.1.error)
        .col("cost", Hidden, "force evaluations a unit of time", |row| row.1.cost)
        .done()
}

fn word(verdict: ChartVerdict) -> &'static str {
    match verdict {
        ChartVerdict::Stable => "stable",
        ChartVerdict::Drifting => "drifting",
        ChartVerdict::Lost => "lost",
        ChartVerdict::Dear => "dear",
    }
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

/// The errors of all methods: a column for each value of the first parameter of the chart.
fn errors(study: &ChartStudy, chart: Chart) -> Table {
    let mut values: Vec<f64> = study.variants(chart).iter().map(|variant| place(chart, variant)[0]).collect();
    values.dedup();
    let of = |method: &Method| study.of(chart).filter(|point| point.method == *method).collect::<Vec<_>>();
    let rows: Vec<(&Method, Vec<&ChartPoint>)> = study.methods.iter().map(|method| (method, of(method))).collect();
    let mut table = Table::of(format!("{}-methods", chart.name()), &rows).key("");
    table = table.col("integrator", Short, "", |row| row.0.name());
    for value in values {
        let worst = move |row: &(&Method, Vec<&ChartPoint>)| {
            let points = row.1.iter().filter(|point| place(chart, &point.variant)[0] == value);
            points.max_by(|a, b| badness(a).total_cmp(&badness(b))).map(|point| error_cell(point))
        };
        table = table.col(plain(value), Short, "", worst);
    }
    if chart == Chart::Light {
        let limit = |factor: fn(&Measured) -> f64| {
            move |row: &(&Method, Vec<&ChartPoint>)| {
                let lightest = row.1.first()?.measured.as_ref().ok()?;
                Some(lightest.stability? * factor(lightest))
            }
        };
        table = table.col("h_omega", Fixed(3), "", limit(|_| 1.0)).col(
            "h_Omega_c",
            Power(1),
            "",
            limit(|measured| measured.contact / measured.fast),
        );
    }
    table.done()
}

/// The resonances, a row each.
fn resonances(study: &ChartStudy) -> Table {
    let found = |point: &ResonancePoint| point.resonance.as_ref().ok().cloned().flatten();
    let edge = |k: usize| move |point: &ResonancePoint| found(point).map(|found| found.edges[k]);
    let why = |point: &ResonancePoint| match &point.resonance {
        Ok(Some(_)) => None,
        Ok(None) => Some("none found that stands apart and grows by more than 1e-6 a step".to_owned()),
        Err(why) => Some(why.clone()),
    };
    Table::of("resonances", &study.resonances)
        .key("")
        .col("integrator", Short, "", |point| point.method.name())
        .col("k", Short, "", |point| u64::from(point.k))
        .col("amplitude", Power(0), "static overlap A", |point| point.amplitude)
        .col("kick_sum", Fixed(3), "", |point| kick_sum(&point.method, point.k))
        .col("lower", Hidden, "h omega at the lower edge", edge(0))
        .col("upper", Hidden, "h omega at the upper edge", edge(1))
        .col("centre", Fixed(6), "h omega of the largest growth", |point| found(point).map(|found| found.centre))
        .col("width", Power(1), "of the interval of h omega", |point| {
            found(point).map(|found| found.edges[1] - found.edges[0])
        })
        .col("growth", Power(1), "largest growth a step, ln |lambda|", |point| found(point).map(|found| found.growth))
        .col("error_inside", Hidden, "energy error of the charted chain at the centre", |point| {
            found(point).and_then(|found| found.inside)
        })
        .col("error_beside", Hidden, "the same half-way to the resonance before", |point| {
            found(point).and_then(|found| found.beside)
        })
        .col("why", Hidden, "why there is none", why)
        .done()
}

/// The cheapest methods.
fn cheapest(regimes: &[Cheapest]) -> Table {
    let limit = |nth: usize| move |regime: &Cheapest| regime.best[nth].as_ref().map(|best| best.0.name());
    let step = |nth: usize| {
        move |regime: &Cheapest| {
            let (_, limit, _, fast) = regime.best[nth].as_ref()?;
            let trial = limit.trial.as_ref()?;
            let more = if limit.longest { ">" } else { "" };
            Some(match trial.tol {
                Some(tol) => format!("tol {tol:.0e}, h Omega {:.2}", trial.step * fast),
                None => format!("{more}{:.3}", trial.step * fast),
            })
        }
    };
    let cost = |nth: usize| move |regime: &Cheapest| Some(regime.best[nth].as_ref()?.1.trial.as_ref()?.cost);
    let mut table = Table::of("regimes", regimes).key("");
    table = table.col("chart", Short, "", |regime| regime.chart.name());
    table = table.col("regime", Short, "", |regime| parameters(&regime.variant));
    for (nth, bound) in BOUNDS.iter().enumerate() {
        table = table
            .col(format!("integrator_{bound:e}"), Short, "", limit(nth))
            .head(format!("{bound:e}"))
            .col(format!("step_{bound:e}"), Short, "", step(nth))
            .head("h Omega")
            .col(format!("cost_{bound:e}"), Power(1), "", cost(nth))
            .head("cost");
    }
    table.done()
}

/// The pictures of a chart by name: heat maps.
fn pictures(study: &ChartStudy, chart: Chart) -> Vec<(String, crate::report::Figure)> {
    let name = chart.name();
    if chart == Chart::Resonances {
        let some = (!study.resonances.is_empty()).then(|| (name.to_owned(), resonance_matrix(study).into()));
        return some.into_iter().collect();
    }
    let maps: Vec<(String, String, CellMap)> = match chart {
        Chart::Light => shown(study).iter().filter_map(|method| step_map(study, method)).collect(),
        Chart::Stiffness => shown(study).iter().map(|method| stiffness_map(study, method)).collect(),
        _ => Vec::new(),
    };
    let map = |(title, caption, map): (String, String, CellMap)| {
        let file = format!("{name}-{}", title.split(':').next().unwrap_or_default());
        let caption = format!("{} {caption}", provenance(study, chart));
        (file, Maps { title, maps: vec![map], caption }.into())
    };
    [(name.to_owned(), error_matrix(study, chart).into())].into_iter().chain(maps.into_iter().map(map)).collect()
}

/// The methods that have maps of their own: of these four those that were charted, else the first
/// three.
fn shown(study: &ChartStudy) -> Vec<Method> {
    const NAMES: [&str; 4] = ["verlet", "strang-linear", "aba1064-linear", "collocation"];
    let methods = &study.methods;
    let known: Vec<Method> = methods.iter().copied().filter(|method| NAMES.contains(&method.name().as_str())).collect();
    if known.is_empty() { methods.iter().copied().take(3).collect() } else { known }
}

/// The parameters that a chart does not vary.
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
    format!("Scene {}: {}.", study.problem.name(), words.join(", "))
}

/// The error as a value on the colour scale, from 1e-16 (rounding) to 10 (lost); 0 (grey) for a run
/// that was not finished.
fn shade(trial: &Trial) -> f64 {
    match (trial.verdict, trial.error) {
        (ChartVerdict::Dear, _) => 0.0,
        (ChartVerdict::Lost, _) | (_, None) => 10.0,
        (_, Some(error)) => error.clamp(1e-16, 10.0),
    }
}

/// Minus the decimal logarithm of the error, rounded, with a `d` if it drifts.
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

fn error_matrix(study: &ChartStudy, chart: Chart) -> Matrix {
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
        Chart::Resonances => ("", ""),
    };
    Matrix {
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
const STEP_ROWS: i32 = 14;

/// Title, caption and map of the energy error over mass ratio and step; none for adaptive methods.
fn step_map(study: &ChartStudy, method: &Method) -> Option<(String, String, CellMap)> {
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
    let line =
        |name: &str, height: f64| Line { name: format!("hΩ = {name}"), points: vec![(first, height), (last, height)] };
    let lines = match method {
        Method::Splitting(_, crate::run::method::Split::Kinetic)
        | Method::Corrected(_, crate::run::method::Split::Kinetic)
        | Method::Conserving => {
            vec![line("2", 2.0)]
        }
        _ => vec![line("π", PI), line("2π", 2.0 * PI), line("3π", 3.0 * PI)],
    };
    let map = CellMap {
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
fn stiffness_map(study: &ChartStudy, method: &Method) -> (String, String, CellMap) {
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
    let map = CellMap {
        labels: ["amplitude A", "spring constant κ", "largest |H − H(0)|/|H(0)|"].map(str::to_owned),
        x,
        y,
        values,
        notes,
        ..CellMap::default()
    };
    let title = format!("{}: energy error over amplitude and spring constant, and what 10⁻⁶ costs", method.name());
    let caption = "Colour: at 64 kicks a period of the fastest motion, or tolerance 10⁻⁹, over ten contact periods 2π/Ω_c. In cells: force evaluations a contact period \
                   for an error below 10⁻⁶; –: more than a run may take.";
    (title, caption.to_owned(), map)
}

fn resonance_matrix(study: &ChartStudy) -> Matrix {
    let mut methods: Vec<Method> = study.resonances.iter().map(|point| point.method).collect();
    methods.dedup();
    let first: Vec<&ResonancePoint> =
        study.resonances.iter().filter(|point| Some(&point.method) == methods.first()).collect();
    let found = |point: &ResonancePoint| point.resonance.as_ref().ok().cloned().flatten();
    let note = |point: &ResonancePoint| {
        found(point).map_or_else(|| "–".to_owned(), |found| format!("{:.1}", found.growth.log10()).replace('-', "−"))
    };
    Matrix {
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
