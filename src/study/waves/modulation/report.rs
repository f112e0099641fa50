//! The report of the modulational stability of travelling waves.

use super::{MeasuredGrowth, Rates, StabilityChart, StabilityRow, StabilityStudy};
use crate::{
    number::{format_parameter, format_short, of_pi},
    report::{
        Column, Fixed, GrowthMap, Hidden, Json, Kind, Line, Panel, Panels, Power, Report, Short, Table, fields, number,
    },
    study::params_words,
    waves::Shape,
};
use serde_json::json;
use std::f64::consts::PI;

/// Points of the curve of theory.
const POINTS: usize = 600;

impl StabilityStudy {
    /// The report. Rates `growth`, `frequency`, `Omega` per slow time, `growth_t` per unit of time,
    /// `growth_period` per period of the wave.
    pub fn report(&self) -> Report {
        // The study refuses an empty list of sizes.
        let (options, modulation, rates) = (&self.options, &self.modulation, self.rates[0]);
        let Shape { q, a, b, .. } = options.shape;
        let fastest = modulation.fastest().map(|(p, growth)| StabilityRow { p, growth, frequency: f64::NAN });
        let row = |row: &StabilityRow| stability(std::slice::from_ref(row), rates).json().remove(0);
        let params = json!({
            "alpha": options.params.alpha,
            "kappa": options.params.kappa,
            "rho": number(options.params.rho),
            "q": q,
            "a": a,
            "b": b,
            "sites": options.sites,
            "epsilon": rates.epsilon,
        });
        let chart_json = |chart: &StabilityChart| {
            let factor = |&(rho, factor): &(f64, f64)| json!({ "rho": number(rho), "factor": factor });
            json!({
                "q": chart.q,
                "b": chart.b,
                "growth": chart.growth,
                "long_short_edge": chart.edge,
                "rho": chart.rho.iter().map(factor).collect::<Vec<_>>(),
            })
        };
        let lag = if rates.lag.is_infinite() {
            "rho = inf: the DpS equation of Newton's cradle, which has no mean strain.".to_owned()
        } else {
            format!(
                "(1 + rho) epsilon^(alpha-1) = {:.3}: the theory holds where this is small, so that mean strains follow \
                 at once.",
                rates.lag
            )
        };
        let about = format!(
            "epsilon = {}, omega_tw = {:.9}. lambda and Omega are per slow time; s = d ln sigma / d ln r at constant mean \
             force. {lag}",
            rates.epsilon, rates.omega_tw
        );
        let report = Report::new("stability")
            .fact("params", params)
            .fact("Omega", modulation.slow_frequency())
            .facts(fields!(rates => omega_tw, lag; modulation => sigma(), slope()))
            .fact("verdict", modulation.verdict().words())
            .fact("band", modulation.band().map(|(from, to)| [from, to]))
            .fact("fastest", fastest.as_ref().map(row))
            .fact("fastest_on_ring", self.fastest().map(row))
            .words(self.caption())
            .words(about)
            .table(stability(&self.rows, rates))
            .fact("measured", measured(&self.measured).json())
            .fact("chart", self.chart.as_ref().map(chart_json))
            .picture_named("dps-growth", self.figure(self.caption()));
        let report = options.modes.into_iter().fold(report, |report, _| report.table(measured(&self.measured)));
        self.chart.iter().fold(report, |report, one| report.table(chart(Some(one))))
    }

    /// What grows, in words.
    fn verdict(&self) -> String {
        let modulation = &self.modulation;
        let words = modulation.verdict().words();
        let Some(((from, to), (p, growth))) = modulation.band().zip(modulation.fastest()) else {
            return format!("The wave is {words}: no modulation grows at this order.");
        };
        format!(
            "The wave is {words}: p between {} π and {} π, fastest at {} π with Re λ = {} = {} Ω.",
            format_short(from / PI),
            format_short(to / PI),
            format_short(p / PI),
            format_short(growth),
            format_short(growth / modulation.slow_frequency()),
        )
    }

    /// How growth was measured, in words.
    fn how_measured(&self) -> String {
        if self.measured.is_empty() {
            return String::new();
        }
        let unit = if self.fastest().is_some() { "e-folding times of the ring's fastest mode" } else { "times 1/Ω" };
        format!(
            "Measured: two runs of the full chain by collocation, with and without 10⁻⁶ of the mode; the mode's share of \
             their difference, fitted from 0.5 to 3 {unit}. "
        )
    }

    fn figure(&self, caption: String) -> Panels {
        let (options, modulation) = (&self.options, &self.modulation);
        let points = (0..=POINTS).map(|k| k as f64 / POINTS as f64).map(|p| (p, modulation.growth(PI * p)));
        let measured = |rates: &Rates| {
            let at = self.measured.iter().filter(|at| at.epsilon == rates.epsilon);
            Line::new(
                &format!("chain, ε = {}", format_short(rates.epsilon)),
                at.map(|at| (at.row.p / PI, at.row.growth)),
            )
        };
        let Shape { q, b, .. } = options.shape;
        let title = format!(
            "Growth of modulations of a travelling wave, q = {}, b = {}, ρ = {}",
            of_pi(q),
            format_short(b),
            format_parameter(options.params.rho)
        );
        let of_chain = self.rates.iter().filter(|_| !self.measured.is_empty()).map(measured);
        let lines = [Line::law("DpS", points)].into_iter().chain(of_chain).collect();
        let labels = ["wave number of the modulation, p / π", "growth rate Re λ per slow time τ"];
        let curves = Column::new("", [Panel::new(Kind::Cloud, labels, lines)]);
        let chart = self.chart.iter().map(|chart| Column::new("", [map(self, chart)]));
        Panels { title, columns: [curves].into_iter().chain(chart).collect(), caption }
    }

    fn caption(&self) -> String {
        let (options, modulation) = (&self.options, &self.modulation);
        let (params, Shape { q, a, b, .. }) = (options.params, options.shape);
        format!(
            "Modulational stability of the wave D = a·exp(i(Ωτ − qn)) of the generalised DpS equations, τ = ε^(α−1) t. {}, \
             q = {}, a = {a}, b = {b}, N = {}; Ω = {}, s = {}. {} {}{}",
            params_words(params),
            of_pi(q),
            options.sites,
            format_short(modulation.slow_frequency()),
            format_short(modulation.slope()).replace('-', "−"),
            self.verdict(),
            self.how_measured(),
            self.chart.as_ref().map(chart_words).unwrap_or_default(),
        )
        .trim_end()
        .to_owned()
    }
}

pub(super) fn outline() -> Report {
    let rates = Rates { epsilon: 1.0, slow: 1.0, omega_tw: 1.0, lag: 1.0 };
    let report = Report::new("stability").table(stability(&[], rates)).table(measured(&[])).table(chart(None));
    report.picture_named("dps-growth", crate::report::Panels::default())
}

/// Theory, a row for each wave number.
fn stability(rows: &[StabilityRow], rates: Rates) -> Table {
    Table::of("stability", rows)
        .col("p", Hidden, "wave number of the modulation", |row| row.p)
        .col("p_over_pi", Fixed(4), "wave number of the modulation, over pi", |row| row.p / PI)
        .head("p/pi")
        .col("growth", Power(6), "Re lambda", |row| row.growth)
        .col("frequency", Power(6), "Im lambda", |row| row.frequency)
        .col("growth_t", Power(4), "growth per unit of time", move |row| rates.per_time(row.growth))
        .col("growth_period", Power(4), "growth per period of the wave", move |row| rates.per_period(row.growth))
        .done()
}

/// What was measured, a row for each size and wave number.
fn measured(rows: &[MeasuredGrowth]) -> Table {
    let deviation =
        |at: &MeasuredGrowth| (at.theory.growth > 0.0).then(|| 100.0 * (at.row.growth / at.theory.growth - 1.0));
    Table::of("measured", rows)
        .key("measured")
        .col("epsilon", Short, "size of the wave", |at| at.epsilon)
        .col("p", Hidden, "wave number of the modulation", |at| at.row.p)
        .col("p_over_pi", Fixed(4), "", |at| at.row.p / PI)
        .head("p/pi")
        .col("growth", Power(6), "Re lambda, measured on the full chain", |at| at.row.growth)
        .col("growth_theory", Power(6), "of the linearised modulation equations", |at| at.theory.growth)
        .col("deviation", Fixed(2), "of the growth from theory, in percent", deviation)
        .col("frequency", Power(6), "Im lambda, measured", |at| at.row.frequency)
        .col("frequency_theory", Hidden, "of the linearised modulation equations", |at| at.theory.frequency)
        .col("residual", Power(1), "largest deviation of the logarithm of the mode from the line", |at| at.residual)
        .col("window", Json, "", |at| vec![at.window.0, at.window.1])
        .done()
}

/// The chart, a row for each cell.
fn chart(chart: Option<&StabilityChart>) -> Table {
    let line = |(growth, b): (&Vec<f64>, f64), q: &[f64]| {
        q.iter().zip(growth).map(|(&q, &growth)| [q, b, growth]).collect::<Vec<_>>()
    };
    let rows = chart
        .into_iter()
        .flat_map(|chart| chart.growth.iter().zip(chart.b.iter().copied()).flat_map(|row| line(row, &chart.q)));
    Table::of("chart", &rows.collect::<Vec<_>>())
        .key("")
        .col("q", Hidden, "wave number of the wave", |cell| cell[0])
        .col("b", Hidden, "its mean strain", |cell| cell[1])
        .col("growth", Hidden, "growth of the fastest mode, per slow time", |cell| cell[2])
        .done()
}

fn chart_words(chart: &StabilityChart) -> String {
    let most = chart.growth.iter().flatten().copied().fold(0.0, f64::max);
    let factors: Vec<_> = chart
        .rho
        .iter()
        .map(|&(rho, factor)| format!("{} at ρ = {}", format_short(factor), format_short(rho)))
        .collect();
    format!(
        "Chart: {} × {} waves, largest growth {} per slow time. Growth is proportional to (1 + 1/ρ)^(−3/2), boundaries do not depend on ρ: relative to this chart {}.",
        chart.q.len(),
        chart.b.len(),
        format_short(most),
        factors.join(", ")
    )
}

/// The chart over `q / pi` and `b / (2 kappa a)`.
fn map(study: &StabilityStudy, chart: &StabilityChart) -> GrowthMap {
    let Shape { q, a, b, .. } = study.options.shape;
    let swing = 2.0 * study.options.params.kappa * a;
    let means: Vec<f64> = chart.b.iter().map(|b| b / swing).collect();
    let half = 0.5 * (means[1] - means[0]);
    let (low, high) = (means[0] - half, means[means.len() - 1] + half);
    let edge = chart.edge.iter().zip(&means).map(|(q, &b)| (q / PI, b));
    GrowthMap {
        labels: [
            "wave number of the wave, q / π".to_owned(),
            "mean strain, b / (2κa)".to_owned(),
            format!("fastest growth per τ, ρ = {}", format_parameter(study.options.params.rho)),
        ],
        x: (0.0, 1.0),
        y: (low, high),
        values: chart.growth.concat(),
        columns: chart.q.len(),
        lines: vec![
            Line::new("edge of stability", [(0.5, low), (0.5, high)]),
            Line::new("long waves grow left of it, short ones right", edge),
        ],
        points: Line::new("this wave", [((q / PI).rem_euclid(2.0).min(2.0 - (q / PI).rem_euclid(2.0)), b / swing)]),
    }
}
