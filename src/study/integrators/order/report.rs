//! The report of the study of orders.

use super::{Mode, OrderRow, OrderStudy, Quantity};
use crate::report::{Curve, Fixed, Hidden, Json, Point, Power, Report, Short, Table, WorkPrecision, fields};
use crate::run::Method;
use serde_json::{Value, json};

/// The curves in the pictures, which the captions speak of: more would hide each other.
const PICTURED: [(Mode, &str); 8] = [
    (Mode::Plain, "verlet"),
    (Mode::Plain, "strang-linear"),
    (Mode::Plain, "aba1064-linear"),
    (Mode::Plain, "kahan-li8-linear"),
    (Mode::Plain, "dop853"),
    (Mode::Landed, "dop853"),
    (Mode::Corrected, "corrected"),
    (Mode::Regularised, "dop853"),
];

/// The slopes, with the error at the finest level.
pub(super) fn orders(rows: &[OrderRow]) -> Table {
    Table::of("slopes", rows)
        .col("mode", Short, "", |row| row.mode.name())
        .col("method", Short, "", |row| row.method.name())
        .col("quantity", Short, "", |row| row.quantity.name())
        .col("slope", Fixed(2), "of log error against log steps", |row| row.slope)
        .col("slope_theory", Short, "the slope by theory", |row| row.theory)
        .head("theory")
        .col("errors", Json, "", |row| json!(row.errors))
        .col("steps", Json, "", |row| json!(row.steps))
        .col("most_steps", Short, "of the finest run", |row| row.steps.last().map(|&steps| steps as f64))
        .col("least_error", Power(1), "of the finest run, the largest of a component at the end", |row| {
            row.errors.last().copied()
        })
        .done()
}

pub(super) fn runs(rows: &[OrderRow]) -> Table {
    let of = |row| move |(&steps, &error)| (row, steps, error);
    let runs: Vec<(&OrderRow, u64, f64)> =
        rows.iter().flat_map(|row| row.steps.iter().zip(&row.errors).map(of(row))).collect();
    Table::of("order", &runs)
        .key("")
        .col("method", Hidden, "", |run| run.0.method.name())
        .col("mode", Hidden, "how it meets contacts", |run| run.0.mode.name())
        .col("quantity", Hidden, "state, or tangent: its derivative by the initial state", |run| run.0.quantity.name())
        .col("slope", Hidden, "order that it shows", |run| run.0.slope)
        .col("slope_theory", Hidden, "the slope by theory", |run| run.0.theory)
        .col("steps", Hidden, "", |run| run.1)
        .col("error", Hidden, "largest error of a component at the end", |run| run.2)
        .done()
}

impl OrderStudy {
    /// The report. Errors of runs that failed, and slopes that cannot be fitted, are null.
    pub fn report(&self) -> Report {
        let event = |event: &crate::integrators::Event<f64>| json!({"t": event.t, "bond": event.index + 1, "kind": if event.rising { "onset" } else { "release" }});
        let (state, tangent) = self.floor;
        Report::new("order")
            .facts(fields!(self => alpha, beads; self.params => kappa, rho))
            .fact("t", self.end)
            .fact("events", self.events.len())
            .fact("event_times", self.events.iter().map(event).collect::<Value>())
            .fact("q", self.q)
            .fact("reference_error", json!({"state": state, "tangent": tangent}))
            .table(orders(&self.rows))
            .words(format!(
                "alpha = {}, {} beads, {} events; slopes over the six finest runs whose error is above that of the \
                 reference ({state:.1e} for the state, {tangent:.1e} for the tangent).",
                self.alpha,
                self.beads,
                self.events.len(),
            ))
            .table(runs(&self.rows))
            .picture_named("order-state", self.picture(Quantity::State, state))
            .picture_named("order-tangent", self.picture(Quantity::Tangent, tangent))
    }

    /// Errors of the state or of the tangent against steps.
    fn picture(&self, quantity: Quantity, floor: f64) -> WorkPrecision {
        let pictured =
            |row: &&OrderRow| row.quantity == quantity && PICTURED.contains(&(row.mode, row.method.name().as_str()));
        let curve = |row: &OrderRow| Curve {
            name: match row.mode {
                Mode::Plain | Mode::Corrected => row.method.name(),
                mode => format!("{}-{}", row.method.name(), mode.name()),
            },
            note: format!(", order {}", row.theory),
            group: row.mode.name().to_owned(),
            points: row
                .steps
                .iter()
                .zip(&row.errors)
                .map(|(&steps, &error)| Point { work: steps as f64, error, below_reference: error < 3.0 * floor })
                .collect(),
        };
        let (lost, words) = match quantity {
            Quantity::State => (0.0, "Largest error of a component of the state"),
            Quantity::Tangent => {
                (1.0, "Largest error of a component of the derivative by the initial state, in one direction,")
            }
        };
        let limit = self.alpha + 1.0 - lost;
        let corrected = super::theory(Method::CORRECTED, self.alpha, Mode::Corrected, quantity);
        let landing = if self.alpha.fract() == 0.0 {
            "is enough for an integer exponent"
        } else {
            "makes only the constant smaller"
        };
        WorkPrecision {
            title: format!("α = {}: order through contacts, {}", self.alpha, quantity.name()),
            work_label: "steps of the run".to_owned(),
            error_label: format!("error of the {} at the end", quantity.name()),
            curves: self.rows.iter().filter(pictured).map(curve).collect(),
            floor: Some(floor),
            caption: format!(
                "{words} at t = 12 on a free chain of {} beads with resonators (κ = 1, ρ = 1/3) and {} onsets and releases. \
                 Crossing a contact limits the order of a plain method to {limit}; landing on it {landing}; kicks whose error \
                 at events is taken back have order {corrected}; a variable in which the solution is smooth (power q = {}) lifts the \
                 limit. Each point of the crossing and landing methods is a root mean square over seven neighbouring numbers \
                 of steps, of corrected kicks the median. Orders in the legend are those of theory.",
                self.beads,
                self.events.len(),
                self.q,
            ),
        }
    }
}
