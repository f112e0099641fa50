//! The modulational stability of travelling waves as text, JSON, CSV and a picture.

use super::{MeasuredGrowth, Rates, StabilityChart, StabilityRow, StabilityStudy};
use crate::{
    error::Result,
    number::shown,
    output::csv,
    present::table,
    study::{File, Report},
    waves::Shape,
};
use serde_json::{Value, json};
use std::f64::consts::PI;

impl Report for StabilityStudy {
    /// Rates `growth`, `frequency`, `Omega` per slow time, `growth_t` per unit of time,
    /// `growth_period` per period of the wave.
    fn json(&self) -> Value {
        let (options, modulation, rates) = (&self.options, &self.modulation, rates(self));
        let Shape { q, a, b, .. } = options.shape;
        let with = |p: f64, growth: f64, frequency: Option<f64>| {
            let mut row = json!({ "p": p, "growth": growth, "growth_t": rates.per_time(growth), "growth_period": rates.per_period(growth) });
            if let Some(frequency) = frequency {
                row["frequency"] = json!(frequency);
            }
            row
        };
        let row = |row: &StabilityRow| with(row.p, row.growth, Some(row.frequency));
        let measured = |at: &MeasuredGrowth| {
            json!({
                "epsilon": at.epsilon,
                "p": at.row.p,
                "growth": at.row.growth,
                "frequency": at.row.frequency,
                "growth_theory": at.theory.growth,
                "frequency_theory": at.theory.frequency,
                "residual": at.residual,
                "window": [at.window.0, at.window.1],
            })
        };
        let chart = |chart: &StabilityChart| {
            json!({
                "q": chart.q,
                "b": chart.b,
                "growth": chart.growth,
                "long_short_edge": chart.edge,
                "rho": chart.rho.iter().map(|&(rho, factor)| json!({ "rho": number(rho), "factor": factor })).collect::<Vec<_>>(),
            })
        };
        json!({
            "params": {
                "alpha": options.params.alpha,
                "kappa": options.params.kappa,
                "rho": number(options.params.rho),
                "q": q,
                "a": a,
                "b": b,
                "sites": options.sites,
                "epsilon": rates.epsilon,
            },
            "Omega": modulation.slow_frequency(),
            "omega_tw": rates.omega_tw,
            "lag": rates.lag,
            "sigma": modulation.sigma(),
            "slope": modulation.slope(),
            "verdict": modulation.verdict().words(),
            "band": modulation.band().map(|(from, to)| [from, to]),
            "fastest": modulation.fastest().map(|(p, growth)| with(p, growth, None)),
            "fastest_on_ring": self.fastest().map(row),
            "rows": self.rows.iter().map(row).collect::<Vec<Value>>(),
            "measured": self.measured.iter().map(measured).collect::<Vec<Value>>(),
            "chart": self.chart.as_ref().map(chart),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let (rates, modulation, params) = (rates(self), &self.modulation, self.options.params);
        let Shape { q, a, b, .. } = self.options.shape;
        let cells = |row: &StabilityRow| {
            vec![
                format!("{:.4}", row.p / PI),
                format!("{:.6e}", row.growth),
                format!("{:.6e}", row.frequency),
                format!("{:.4e}", rates.per_time(row.growth)),
                format!("{:.4e}", rates.per_period(row.growth)),
            ]
        };
        let rows: Vec<_> = self.rows.iter().map(cells).collect();
        let mut text = table(&["p/pi", "Re lambda", "Im lambda", "growth per t", "per period"], &rows);
        text += &format!(
            "\nalpha = {}, kappa = {}, rho = {}, q = {} pi, a = {a}, b = {b}, epsilon = {}, N = {}: Omega = {:.6e}, omega_tw = {:.9}, s = {:.6}.\n\
         lambda and Omega per slow time epsilon^(alpha-1) t; s = d ln sigma / d ln r at constant mean force.\n\
         {}\n{}\n",
            params.alpha,
            params.kappa,
            params.rho,
            shown(q / PI),
            rates.epsilon,
            self.options.sites,
            modulation.slow_frequency(),
            rates.omega_tw,
            modulation.slope(),
            lag(rates.lag),
            verdict(self),
        );
        if !self.measured.is_empty() {
            text += &format!("\n{}\n{}\n", measured_table(self), how_measured(self));
        }
        if let Some(chart) = &self.chart {
            text += &format!("\n{}\n", chart_words(chart));
        }
        text
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = vec![("stability.json".to_owned(), json.into())];
        files.extend(tables(self).into_iter().map(|(name, csv)| (name.to_owned(), csv)));
        Ok(files)
    }

    /// Growth against wave number with what was measured, and the chart.
    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        let png = crate::figures::growth(&figure(self, caption(self)))?;
        Ok(crate::study::named([("dps-growth.png", png)]))
    }
}

/// The factors of the first size of the wave, by which rates are given per unit of time.
fn rates(study: &StabilityStudy) -> Rates {
    // The study refuses an empty list of sizes.
    study.rates[0]
}

/// A number; as text if it is not finite, since JSON has no number for it.
fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { json!(x.to_string()) }
}

/// Theory as CSV, a line a wave number.
fn rates_csv(study: &StabilityStudy) -> Vec<u8> {
    let rates = rates(study);
    let row = |row: &StabilityRow| {
        vec![row.p, row.growth, rates.per_time(row.growth), rates.per_period(row.growth), row.frequency]
    };
    csv(&["p", "growth", "growth_t", "growth_period", "frequency"], study.rows.iter().map(row))
}

/// All tables, `(file name, CSV)`: `stability.csv`, with measurements `measured.csv`, with a chart
/// `chart.csv`.
pub(crate) fn tables(study: &StabilityStudy) -> Vec<(&'static str, Vec<u8>)> {
    let mut tables = vec![("stability.csv", rates_csv(study))];
    tables.extend(study.options.modes.map(|_| ("measured.csv", measured_growth_csv(study))));
    tables.extend(study.chart.as_ref().map(|chart| ("chart.csv", chart_csv(chart))));
    tables
}

/// What was measured as CSV, a line a size and wave number.
fn measured_growth_csv(study: &StabilityStudy) -> Vec<u8> {
    let row = |at: &MeasuredGrowth| {
        let (row, theory) = (at.row, at.theory);
        vec![at.epsilon, row.p, row.growth, theory.growth, row.frequency, theory.frequency, at.residual]
    };
    let names = ["epsilon", "p", "growth", "growth_theory", "frequency", "frequency_theory", "residual"];
    csv(&names, study.measured.iter().map(row))
}

/// The chart as CSV, a line a cell.
fn chart_csv(chart: &StabilityChart) -> Vec<u8> {
    let line = |(&b, growth): (&f64, &Vec<f64>)| {
        let cells = chart.q.iter().zip(growth).map(|(&q, &growth)| vec![q, b, growth]);
        cells.collect::<Vec<_>>()
    };
    csv(&["q", "b", "growth"], chart.b.iter().zip(&chart.growth).flat_map(line))
}

/// Where the theory holds, in words.
fn lag(lag: f64) -> String {
    if lag.is_infinite() {
        return "rho = inf: the DpS equation of Newton's cradle, which has no mean strain.".to_owned();
    }
    format!(
        "(1 + rho) epsilon^(alpha-1) = {lag:.3}: the theory holds where this is small, so that mean strains follow at once."
    )
}

/// What grows, in words.
fn verdict(study: &StabilityStudy) -> String {
    let modulation = &study.modulation;
    let words = modulation.verdict().words();
    let Some(((from, to), (p, growth))) = modulation.band().zip(modulation.fastest()) else {
        return format!("The wave is {words}: no modulation grows at this order.");
    };
    format!(
        "The wave is {words}: p between {} pi and {} pi, fastest at {} pi with Re lambda = {} = {} Omega.",
        shown(from / PI),
        shown(to / PI),
        shown(p / PI),
        shown(growth),
        shown(growth / modulation.slow_frequency()),
    )
}

fn measured_table(study: &StabilityStudy) -> String {
    let cells = |at: &MeasuredGrowth| {
        let deviation = at.row.growth / at.theory.growth - 1.0;
        vec![
            at.epsilon.to_string(),
            format!("{:.4}", at.row.p / PI),
            format!("{:.6e}", at.theory.growth),
            format!("{:.6e}", at.row.growth),
            if at.theory.growth > 0.0 { format!("{:+.2} %", 100.0 * deviation) } else { "–".to_owned() },
            format!("{:.6e}", at.row.frequency),
            format!("{:.1e}", at.residual),
        ]
    };
    let head = ["epsilon", "p/pi", "Re lambda", "measured", "deviation", "measured Im", "residual"];
    table(&head, &study.measured.iter().map(cells).collect::<Vec<_>>())
}

fn how_measured(study: &StabilityStudy) -> String {
    let unit = if study.fastest().is_some() { "e-folding times of the ring's fastest mode" } else { "times 1/Omega" };
    format!(
        "Measured: two runs of the full chain by collocation, with and without 10^-6 of the mode; the mode's share of their difference, fitted from 0.5 to 3 {unit}.\n\
         Residual: largest deviation of its logarithm from the line; where it is not small, more than this mode grows."
    )
}

fn chart_words(chart: &StabilityChart) -> String {
    let most = chart.growth.iter().flatten().copied().fold(0.0, f64::max);
    let factors: Vec<_> =
        chart.rho.iter().map(|&(rho, factor)| format!("{} at rho = {}", shown(factor), shown(rho))).collect();
    format!(
        "Chart: {} x {} waves, largest growth {} per slow time. rho is a factor of all of it, (1 + 1/rho)^(-3/2), and moves no boundary: times {}.",
        chart.q.len(),
        chart.b.len(),
        shown(most),
        factors.join(", ")
    )
}

/// Points of the curve of theory.
#[cfg(feature = "plot")]
const POINTS: usize = 600;

/// The picture as numbers and words.
#[cfg(feature = "plot")]
pub(crate) fn figure(study: &StabilityStudy, caption: String) -> crate::figures::Growth {
    use crate::figures::{Growth, Line};
    let (options, modulation) = (&study.options, &study.modulation);
    let points = (0..=POINTS).map(|k| k as f64 / POINTS as f64).map(|p| (p, modulation.growth(PI * p)));
    let measured = |rates: &Rates| {
        let at = study.measured.iter().filter(|at| at.epsilon == rates.epsilon);
        Line {
            name: format!("full chain, ε = {}", rates.epsilon),
            points: at.map(|at| (at.row.p / PI, at.row.growth)).collect(),
        }
    };
    let Shape { q, b, .. } = options.shape;
    Growth {
        title: format!(
            "Growth of modulations of a travelling wave, q = {}, b = {}, ρ = {}",
            crate::number::of_pi(q),
            shown(b),
            crate::number::written(options.params.rho)
        ),
        wave_label: "wave number of the modulation, p / π".to_owned(),
        growth_label: "growth rate Re λ per slow time τ".to_owned(),
        theory: Line { name: "linearised DpS".to_owned(), points: points.collect() },
        measured: if study.measured.is_empty() { Vec::new() } else { study.rates.iter().map(measured).collect() },
        map: study.chart.as_ref().map(|chart| map(study, chart)),
        caption,
    }
}

/// The caption of the picture.
pub(crate) fn caption(study: &StabilityStudy) -> String {
    let (options, modulation) = (&study.options, &study.modulation);
    let (params, Shape { q, a, b, .. }) = (options.params, options.shape);
    let how = if study.measured.is_empty() {
        String::new()
    } else {
        how_measured(study).lines().next().unwrap_or_default().replace("Omega", "Ω").replace("10^-6", "10⁻⁶") + " "
    };
    let chart = study
        .chart
        .as_ref()
        .map(|chart| chart_words(chart).replace("rho", "ρ").replace("^(-3/2)", "^(−3/2)").replace(" x ", " × ") + " ");
    format!(
        "Modulational stability of the wave D = a exp(i(Ωτ − qn)) of the generalised DpS equations, τ = ε^(α−1) t. {}, \
             q = {}, a = {a}, b = {b}, N = {}; Ω = {}, s = {}. {}. {how}{}hertzchain {}.",
        crate::study::params_words(params),
        crate::number::of_pi(q),
        options.sites,
        shown(modulation.slow_frequency()),
        shown(modulation.slope()).replace('-', "−"),
        verdict(study).trim_end_matches('.').replace("Re lambda", "Re λ").replace("Omega", "Ω").replace(" pi", " π"),
        chart.unwrap_or_default(),
        env!("CARGO_PKG_VERSION")
    )
}

/// The chart over `q / pi` and `b / (2 kappa a)`.
#[cfg(feature = "plot")]
fn map(study: &StabilityStudy, chart: &StabilityChart) -> crate::figures::GrowthMap {
    use crate::figures::{GrowthMap, Line};
    let Shape { q, a, b, .. } = study.options.shape;
    let swing = 2.0 * study.options.params.kappa * a;
    let means: Vec<f64> = chart.b.iter().map(|b| b / swing).collect();
    let half = 0.5 * (means[1] - means[0]);
    let (low, high) = (means[0] - half, means[means.len() - 1] + half);
    let edge = chart.edge.iter().zip(&means).map(|(q, &b)| (q / PI, b)).collect();
    GrowthMap {
        labels: [
            "wave number of the wave, q / π".to_owned(),
            "mean strain, b / (2κa)".to_owned(),
            format!("fastest growth per τ, ρ = {}", crate::number::written(study.options.params.rho)),
        ],
        x: (0.0, 1.0),
        y: (low, high),
        values: chart.growth.concat(),
        columns: chart.q.len(),
        lines: vec![
            Line { name: "edge of stability (white)".to_owned(), points: vec![(0.5, low), (0.5, high)] },
            Line { name: "long | short waves grow".to_owned(), points: edge },
        ],
        points: Line {
            name: "this wave".to_owned(),
            points: vec![((q / PI).rem_euclid(2.0).min(2.0 - (q / PI).rem_euclid(2.0)), b / swing)],
        },
    }
}
