//! The report of the charts of stability.

use super::{BOUNDS, Behaviour, Chart, ChartPoint, ChartStudy, Measured, Trial, Variant};
use crate::{
    numerics::{extremes, largest_by},
    present::machine_json,
    report::{CellMap, Fixed, Hidden, Json, Line, Matrix, Panels, Power, Report, Rows, Short, Table},
    run::method::{Method, Split},
};
use serde::Serialize;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// What a variant may change.
const VARIED: [&str; 6] = ["rho", "kappa", "alpha", "amplitude", "sites", "periods"];
/// The names of the bounds in columns.
const BOUND_NAMES: [&str; 2] = ["1e-3", "1e-6"];

impl ChartStudy {
    /// The report. Wall times depend on the load of the machine.
    pub fn report(&self) -> Report {
        let (chain, problem) = (&self.problem.chain, &self.problem);
        let regimes = regimes(self);
        let computed = self.points.len() - self.resumed;
        let (wall, amplitude) = (self.wall.as_secs_f64(), problem.amplitude);
        let mut report = Report::new("stability")
            .si(self.si.as_ref())
            .fact("scene", &problem.name)
            .fact("chain", chain)
            .fact("amplitude", amplitude)
            .fact("bounds", BOUNDS)
            .fact("work", self.work)
            .fact("points", json!([]))
            .words(format!(
                "{}: {} sites, alpha = {}, kappa = {}, rho = {}, amplitude {amplitude}",
                problem.name, chain.sites, chain.alpha, chain.kappa, chain.rho,
            ));
        let mut all = Vec::new();
        for &chart in &self.charts {
            let (title, against, _) = words(chart);
            let how = "the worst energy error at 64 kicks a period of the fastest motion, or tolerance 1e-9";
            report = report.words(format!("{}. {title}: {how}, against {against}.", chart.name()));
            let points = points(self, chart);
            all.extend(points.json());
            report = report.table(errors(self, chart)).table(points).table(ladder(self, chart));
        }
        let marks: String = MARKS[..3].iter().map(|(mark, meaning)| format!("{mark}: {meaning}. ")).collect();
        let last = "Fewest force evaluations for an energy error below 1e-3 and below 1e-6; >: no longer step was \
                    tried; tol: of an adaptive method, its mean step follows:";
        report = report
            .words(marks + last)
            .table(regimes_table(&regimes))
            .fact("points", all)
            .fact("computed", computed)
            .fact("resumed", self.resumed)
            .fact("wall_s", wall)
            .fact("machine", machine_json())
            .words(format!("{computed} points computed, {} resumed, {wall:.1} s", self.resumed));
        self.pictures(report)
    }

    fn pictures(&self, mut report: Report) -> Report {
        for &chart in &self.charts {
            let name = chart.name();
            report = report.picture_named(name, error_matrix(self, chart));
            let (title, caption, map): (_, _, fn(&Self, &Method) -> Option<CellMap>) = match chart {
                Chart::Light => (
                    "energy error over step and mass ratio",
                    "Ω is the larger of ω and Ω_c. Top of the scale: lost. Grey: more work than a run may take.",
                    step_map,
                ),
                Chart::Stiffness => (
                    "energy error over amplitude and spring constant, and what 10⁻⁶ costs",
                    "Colour: at HOW, over ten contact periods 2π/Ω_c. In cells: force evaluations a contact period for an \
                     error below 10⁻⁶.",
                    stiffness_map,
                ),
                _ => continue,
            };
            for method in resolved(self) {
                let Some(map) = map(self, &method) else { continue };
                let (file, title) = (format!("{name}-{}", method.name()), format!("{}: {title}", method.name()));
                let costs = map.notes.iter().filter_map(|note| note.parse::<f64>().ok());
                let how =
                    if method.adaptive() { "tolerance 10⁻⁹" } else { "64 kicks a period of the fastest motion" };
                let (caption, most) = (caption.replace("HOW", how), extremes(map.values.iter().copied()).1);
                let [x, y] = [&map.x, &map.y].map(|all| format!("{:e} to {:e}", all[0], all[all.len() - 1]));
                let mut caption = format!(
                    "{} {caption} From left to right {x}, upwards {y}. The largest error is {most:.1e}",
                    provenance(self, chart)
                );
                if let (low, high @ 1.0..) = extremes(costs) {
                    caption += &format!("; the evaluations are {low} to {high:e}");
                }
                caption +=
                    if map.notes.iter().any(|note| note == "–") { ". –: more than a run may take." } else { "." };
                report = report.picture_named(&file, Panels::column(title, vec![map], caption));
            }
        }
        report
    }
}

/// What a variant changes, by name.
fn value(name: &str, variant: &Variant) -> Option<f64> {
    json!(variant)[name].as_f64()
}

/// The parameters that tell the variants of a chart apart.
fn axes(chart: Chart) -> &'static [&'static str] {
    words(chart).2
}

fn place(chart: Chart, variant: &Variant) -> Vec<f64> {
    axes(chart).iter().filter_map(|name| value(name, variant)).collect()
}

/// Columns for what tells the variants of a chart apart; JSON has all that they change.
fn varied<'a, T>(mut table: Rows<'a, T>, chart: Chart, variant: fn(&T) -> &Variant) -> Rows<'a, T> {
    let others = VARIED.iter().filter(|name| !axes(chart).contains(name));
    for (name, digits) in axes(chart).iter().map(|name| (name, Hidden)).chain(others.map(|name| (name, Json))) {
        table = table.col(*name, digits, "", |row| value(name, variant(row)));
    }
    table
}

fn points(study: &ChartStudy, chart: Chart) -> Table {
    fn of(value: fn(&Measured) -> Option<f64>) -> impl Fn(&&ChartPoint) -> Option<f64> {
        move |point| point.measured.as_ref().ok().and_then(value)
    }
    fn nested(value: fn(&Measured) -> Value) -> impl Fn(&&ChartPoint) -> Value {
        move |point| point.measured.as_ref().map_or(Value::Null, value)
    }
    let points: Vec<&ChartPoint> = study.of(chart).collect();
    let table = Table::of(chart.name(), &points).key("").col("chart", Json, "", |point| point.chart.name()).col(
        "integrator",
        Hidden,
        "",
        |point| point.method.name(),
    );
    let mut table = varied(table, chart, |point| &point.variant)
        .col("contact_frequency", Hidden, "Omega_c", of(|measured| Some(measured.contact)))
        .col("fast_frequency", Hidden, "frequency of the fastest motion", of(|measured| Some(measured.fast)))
        .col("span", Hidden, "length of the runs", of(|measured| Some(measured.span)))
        .col("verdict", Hidden, "at the usual step or tolerance", |point| {
            point.measured.as_ref().map_or("refused", |measured| measured.usual.behaviour.name())
        })
        .col("energy_error", Hidden, "the same", of(|measured| measured.usual.error))
        .col("step", Hidden, "the usual step", of(|measured| Some(measured.usual.step)))
        .col("cost", Hidden, "force evaluations a unit of time", of(|measured| Some(measured.usual.cost)));
    for (nth, bound) in BOUND_NAMES.iter().enumerate() {
        let trial = move |point: &ChartPoint| point.measured.as_ref().ok()?.limits.get(nth)?.trial.clone();
        table = table
            .col(format!("step_{bound}"), Hidden, format!("largest step with an energy error below {bound}"), |point| {
                trial(point).map(|trial| trial.step)
            })
            .col(format!("cost_{bound}"), Hidden, "its cost", |point| trial(point).map(|trial| trial.cost));
    }
    table
        .col("stability_limit", Hidden, "limit of stability of the step times the fast frequency", {
            of(|measured| measured.stability)
        })
        .col("why", Hidden, "why nothing was measured, or why the run failed", |point| {
            point.measured.as_ref().map_or_else(|why| Some(why.clone()), |measured| measured.usual.failure.clone())
        })
        .col("usual", Json, "", nested(|measured| json!(measured.usual)))
        .col("limits", Json, "", nested(|measured| json!(measured.limits)))
        .col("ladder", Json, "", nested(|measured| json!(measured.ladder)))
        .col("refused", Json, "", |point| point.measured.as_ref().err().cloned())
        .done()
}

fn ladder(study: &ChartStudy, chart: Chart) -> Table {
    let measured = study.of(chart).filter_map(|point| Some((point, point.measured.as_ref().ok()?)));
    let rows: Vec<(&ChartPoint, f64, &Trial)> =
        measured.flat_map(|(point, it)| it.ladder.iter().map(move |trial| (point, it.fast, trial))).collect();
    let table = Table::of(format!("{}-ladder", chart.name()), &rows)
        .key("")
        .col("integrator", Hidden, "", |row| row.0.method.name());
    varied(table, chart, |row| &row.0.variant)
        .col("step", Hidden, "the mean one for adaptive methods", |row| row.2.step)
        .col("tol", Hidden, "tolerance", |row| row.2.tol)
        .col("h_fast", Hidden, "step times the fast frequency", |row| row.1 * row.2.step)
        .col("verdict", Hidden, "stable, drifting, lost or dear", |row| row.2.behaviour.name())
        .col("energy_error", Hidden, "largest |H - H(0)|/|H(0)|", |row| row.2.error)
        .col("cost", Hidden, "force evaluations a unit of time", |row| row.2.cost)
        .done()
}

/// The worst error of every method at each value of the first parameter.
fn errors(study: &ChartStudy, chart: Chart) -> Table {
    let mut columns: Vec<f64> = study.variants(chart).iter().map(|variant| place(chart, variant)[0]).collect();
    columns.dedup();
    let of = |method: Method| study.of(chart).filter(move |point| point.method == method);
    let mut table = Table::of(format!("{}-errors", chart.name()), &study.methods).key("").col(
        "integrator",
        Short,
        "",
        Method::name,
    );
    for column in columns {
        table = table.col(plain(column), Short, "", |method| {
            let points = of(*method).filter(|point| place(chart, &point.variant)[0] == column);
            largest_by(points, |point| badness(point))
                .map(|point| cell(point, "refused", |error| format!("{error:.0e}")))
        });
        table = table.head(plain(column));
    }
    if chart == Chart::Light {
        let limit = |method: &Method| {
            let measured = of(*method).next()?.measured.as_ref().ok()?;
            Some((measured.stability?, measured.contact / measured.fast))
        };
        let second = |method: &Method| limit(method).map(|(limit, ratio)| limit * ratio);
        table = table
            .col("h_omega", Fixed(3), "step above which the energy has no bound, at the lightest", |method| {
                limit(method).map(|(limit, _)| limit)
            })
            .col("h_contact", Power(1), "the same times Omega_c over the fast frequency", second)
            .head("h Omega_c");
    }
    table.done()
}

fn regimes_table(regimes: &[Regime]) -> Table {
    let mut table = Table::of("regimes", regimes)
        .key("regimes")
        .col("chart", Short, "", |regime| regime.chart.name())
        .col("regime", Short, "", |regime| parameters(&regime.variant));
    for name in VARIED {
        table = table.col(name, Json, "", |regime| value(name, &regime.variant));
    }
    table = table.col("best", Json, "", |regime| json!(regime.best));
    for (nth, bound) in BOUND_NAMES.iter().enumerate() {
        table = table
            .col(format!("integrator_{bound}"), Short, "", |regime| {
                regime.best[nth].as_ref().map_or("none".to_owned(), |best| best.integrator.clone())
            })
            .head(*bound)
            .col(format!("h_fast_{bound}"), Short, "", |regime| regime.best[nth].as_ref().map(Cheapest::words))
            .head("h Omega")
            .col(format!("cost_{bound}"), Power(1), "", |regime| regime.best[nth].as_ref().map(|best| best.cost))
            .head("cost");
    }
    table.done()
}

/// A variant, and for each bound the cheapest method that meets it, if one does.
struct Regime {
    chart: Chart,
    variant: Variant,
    best: Vec<Option<Cheapest>>,
}

/// The method that meets a bound with the fewest force evaluations, and its step.
#[derive(Serialize)]
struct Cheapest {
    bound: f64,
    integrator: String,
    step: f64,
    /// The step times `max(omega, Omega_c)`.
    h_fast: f64,
    tol: Option<f64>,
    cost: f64,
    longest: bool,
}

impl Cheapest {
    /// Its step and its tolerance, in words.
    fn words(&self) -> String {
        let (step, more) = (self.h_fast, if self.longest { ">" } else { "" });
        self.tol.map_or_else(|| format!("{more}{step:.3}"), |tol| format!("tol {tol:.0e}: {step:.2}"))
    }
}

fn regimes(study: &ChartStudy) -> Vec<Regime> {
    let of = |&chart: &Chart| study.variants(chart).into_iter().map(move |variant| (chart, variant));
    let regime = |(chart, variant): (Chart, Variant)| {
        let best = |nth: usize| {
            let (method, limit, &Trial { step, tol, cost, .. }) = study.cheapest(chart, &variant, nth)?;
            let fast = study.point(chart, &variant, &method)?.measured.as_ref().ok()?.fast;
            let (bound, longest) = (limit.bound, limit.longest);
            Some(Cheapest { bound, integrator: method.name(), step, h_fast: step * fast, tol, cost, longest })
        };
        Regime { chart, variant, best: (0..BOUNDS.len()).map(best).collect() }
    };
    study.charts.iter().flat_map(of).map(regime).collect()
}

fn parameters(variant: &Variant) -> String {
    let given = VARIED.iter().filter_map(|name| Some(format!("{name} {}", plain(value(name, variant)?))));
    given.collect::<Vec<_>>().join(", ")
}

fn plain(value: f64) -> String {
    if (1e-2..1e4).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

/// The title of a chart, what it is against, and the parameters that tell its variants apart.
fn words(chart: Chart) -> (&'static str, &'static str, &'static [&'static str]) {
    match chart {
        Chart::Light => ("Light and heavy resonators", "mass ratio ρ", &["rho"]),
        Chart::Stiffness => {
            ("Stiffness of contacts and springs", "amplitude A, spring constant κ", &["amplitude", "kappa"])
        }
        Chart::Alpha => ("Exponent of the contact force", "exponent α", &["alpha"]),
        Chart::Length => ("Length of the chain", "number of sites N", &["sites"]),
        Chart::Time => ("Length of the run", "contact periods", &["periods"]),
    }
}

/// The error of a point, with a `d` if it drifts, or a word if there is none.
fn cell(point: &ChartPoint, refused: &str, number: fn(f64) -> String) -> String {
    let Ok(measured) = &point.measured else { return refused.to_owned() };
    match (measured.usual.behaviour, measured.usual.error) {
        (Behaviour::Dear, _) => "dear".to_owned(),
        (Behaviour::Lost, _) | (_, None) => "lost".to_owned(),
        (Behaviour::Drifting, Some(error)) => number(error) + "d",
        (Behaviour::Stable, Some(error)) => number(error),
    }
}

/// A rank that is larger for a worse point: the table shows the worst point of a cell.
fn badness(point: &ChartPoint) -> f64 {
    match &point.measured {
        Err(_) => f64::INFINITY,
        Ok(measured) if measured.usual.behaviour == Behaviour::Dear => 1e9,
        Ok(measured) => measured.usual.error.unwrap_or(1e8),
    }
}

/// The methods that have maps of their own: of these four those that were charted, else the first
/// three.
fn resolved(study: &ChartStudy) -> Vec<Method> {
    const NAMES: [&str; 4] = ["verlet", "strang-linear", "aba1064-linear", "collocation"];
    let methods = &study.methods;
    let known: Vec<Method> = methods.iter().copied().filter(|method| NAMES.contains(&method.name().as_str())).collect();
    if known.is_empty() { methods.iter().copied().take(3).collect() } else { known }
}

/// The parameters that a chart does not vary.
fn provenance(study: &ChartStudy, chart: Chart) -> String {
    let chain = &study.problem.chain;
    let all = [
        ("sites", "N", chain.sites as f64),
        ("alpha", "α", chain.alpha),
        ("kappa", "κ", chain.kappa),
        ("rho", "ρ", chain.rho),
        ("amplitude", "A", study.problem.amplitude),
    ];
    let fixed = all.iter().filter(|(name, _, _)| !axes(chart).contains(name));
    let words: Vec<String> =
        fixed.map(|(_, symbol, value)| format!("{symbol} = {}", crate::number::format_parameter(*value))).collect();
    format!("Chain {}: {}.", study.problem.name, words.join(", "))
}

/// The error as a value on the colour scale, from 1e-16 (rounding) to 10 (lost); 0 (grey) for a run
/// that was not finished.
fn shade(trial: &Trial) -> f64 {
    match (trial.behaviour, trial.error) {
        (Behaviour::Dear, _) => 0.0,
        (Behaviour::Lost, _) | (_, None) => 10.0,
        (_, Some(error)) => error.clamp(1e-16, 10.0),
    }
}

/// The shade of the usual run of a point.
fn usual(point: Option<&ChartPoint>) -> f64 {
    point.and_then(|point| point.measured.as_ref().ok()).map_or(0.0, |measured| shade(&measured.usual))
}

/// Marks in cells, and their meaning.
const MARKS: [(&str, &str); 4] = [
    ("d", "drifting, of collocation only above its tolerance"),
    ("lost", "above 1 or failed"),
    ("dear", "not finished within twenty times the work of a run"),
    ("–", "not tried"),
];

fn error_matrix(study: &ChartStudy, chart: Chart) -> Matrix {
    let variants = study.variants(chart);
    let column = |variant: &Variant| {
        let words: Vec<String> = place(chart, variant).into_iter().map(plain).collect();
        words.join(", ")
    };
    let exponent = |error: f64| format!("{:.0}", (-error.clamp(1e-16, 1.0).log10()).abs());
    let at = |method| variants.iter().map(move |variant| study.point(chart, variant, method));
    let points: Vec<Option<&ChartPoint>> = study.methods.iter().flat_map(at).collect();
    let note = |point: &Option<&ChartPoint>| point.map(|point| cell(point, "–", exponent)).unwrap_or_default();
    let notes: Vec<String> = points.iter().map(note).collect();
    let seen = MARKS.iter().filter(|(mark, _)| notes.iter().any(|note| note.ends_with(mark)));
    let seen: String = seen.map(|(mark, meaning)| format!("; {mark}: {meaning}")).collect();
    let (title, label, _) = words(chart);
    Matrix {
        title: format!("{title}: energy error at 64 kicks a period of the fastest motion, or tolerance 10⁻⁹"),
        rows: study.methods.iter().map(Method::name).collect(),
        columns: variants.iter().map(column).collect(),
        labels: [label, ERROR].map(str::to_owned),
        values: points.iter().map(|point| usual(*point)).collect(),
        notes,
        caption: format!("{} In cells: −log₁₀ of the error{seen}.", provenance(study, chart)),
    }
}

/// Rows of the map of steps: `h Omega` from 12 down to 0.1, each the one before over `sqrt 2`.
const STEP_ROWS: i32 = 14;
/// What the colours of maps show.
const ERROR: &str = "largest |H − H(0)|/|H(0)|";

/// The energy error over mass ratio and step; none for adaptive methods.
fn step_map(study: &ChartStudy, method: &Method) -> Option<CellMap> {
    let level = |h_fast: f64| (2.0 * (12.0 / h_fast).log2()).round() as i32;
    let x: Vec<f64> = study.variants(Chart::Light).iter().filter_map(|variant| variant.rho).collect();
    let y: Vec<f64> = (0..STEP_ROWS).rev().map(|row| 12.0 * f64::powf(2.0, -0.5 * f64::from(row))).collect();
    let error = |rho: f64, h_fast: f64| {
        let variant = Variant { rho: Some(rho), ..Variant::default() };
        let measured = study.point(Chart::Light, &variant, method)?.measured.as_ref().ok()?;
        measured.ladder.iter().find(|trial| level(trial.step * measured.fast) == level(h_fast)).map(shade)
    };
    let (first, last) = (*x.first()?, *x.last()?);
    let line = |(name, height): &(&str, f64)| Line::new(&format!("hΩ = {name}"), [(first, *height), (last, *height)]);
    let heights: &[(&str, f64)] = match method {
        _ if method.split() == Some(Split::Kinetic) || *method == Method::Conserving => &[("2", 2.0)],
        _ => &[("π", PI), ("2π", 2.0 * PI), ("3π", 3.0 * PI)],
    };
    let lines = heights.iter().map(line).collect();
    let cell = |rho, h_fast| (error(rho, h_fast).unwrap_or(0.0), String::new());
    let map = CellMap { lines, ..CellMap::new(["mass ratio ρ", "step hΩ", ERROR], [x, y], cell) };
    (!method.adaptive()).then_some(map)
}

/// The energy error over amplitude and spring constant, with the cost in the cells.
fn stiffness_map(study: &ChartStudy, method: &Method) -> Option<CellMap> {
    let variants = study.variants(Chart::Stiffness);
    let distinct = |of: fn(&Variant) -> Option<f64>| {
        let mut values: Vec<f64> = variants.iter().filter_map(of).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let axes = [distinct(|variant| variant.amplitude), distinct(|variant| variant.kappa)];
    let cost = |point: &ChartPoint| {
        let measured = point.measured.as_ref().ok()?;
        let a_period = measured.limits.get(1)?.trial.as_ref()?.cost * TAU / measured.contact;
        Some(if a_period < 1e4 { format!("{a_period:.0}") } else { format!("{a_period:.0e}") })
    };
    Some(CellMap::new(["amplitude A", "spring constant κ", ERROR], axes, |amplitude, kappa| {
        let variant = Variant { amplitude: Some(amplitude), kappa: Some(kappa), ..Variant::default() };
        let point = study.point(Chart::Stiffness, &variant, method);
        (usual(point), point.and_then(cost).unwrap_or_else(|| "–".to_owned()))
    }))
}
