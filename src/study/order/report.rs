//! The order study as text, JSON, CSV and pictures.

use super::{OrderRow, OrderStudy, Quantity};
use crate::{
    error::Result,
    present::table,
    study::{File, Report, named},
};
use serde_json::{Value, json};

impl Report for OrderStudy {
    /// Errors of runs that failed, and slopes that cannot be fitted, are null.
    fn json(&self) -> Value {
        let rows: Vec<Value> = self
            .rows
            .iter()
            .map(|row| {
                json!({
                    "method": row.method.name(),
                    "mode": row.mode.name(),
                    "quantity": row.quantity.name(),
                    "slope": row.slope,
                    "slope_theory": row.theory,
                    "errors": row.errors,
                    "steps": row.steps,
                })
            })
            .collect();
        let event = |event: &crate::integrators::Event<f64>| json!({"t": event.t, "bond": event.index + 1, "kind": if event.rising { "onset" } else { "release" }});
        json!({
            "alpha": self.alpha,
            "beads": self.beads,
            "kappa": self.params.kappa,
            "rho": self.params.rho,
            "t": self.end,
            "events": self.events.len(),
            "event_times": self.events.iter().map(event).collect::<Vec<_>>(),
            "q": self.q,
            "reference_error": {"state": self.floor.0, "tangent": self.floor.1},
            "rows": rows,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// The slopes, mode by mode, with the error at the finest rung.
    fn text(&self) -> String {
        let finest = |row: &OrderRow| row.errors.last().map(|error| format!("{error:.1e}")).unwrap_or_default();
        let slope = |row: &OrderRow| row.slope.map_or_else(|| "–".to_owned(), |slope| format!("{slope:.2}"));
        let states = self.rows.iter().filter(|row| row.quantity == Quantity::State);
        let rows: Vec<Vec<String>> = states
            .filter_map(|state| {
                let same = |row: &&OrderRow| {
                    row.method == state.method && row.mode == state.mode && row.quantity == Quantity::Tangent
                };
                let tangent = self.rows.iter().find(same)?;
                Some(vec![
                    state.mode.name().to_owned(),
                    state.method.name(),
                    slope(state),
                    format!("{}", state.theory),
                    slope(tangent),
                    format!("{}", tangent.theory),
                    state.steps.last().map(u64::to_string).unwrap_or_default(),
                    finest(state),
                    finest(tangent),
                ])
            })
            .collect();
        let head = ["mode", "method", "state", "theory", "tangent", "theory", "steps", "error", "tangent error"];
        format!(
            "{}\nalpha = {}, {} beads, {} events; slopes of log error against log steps, over the six finest runs whose\n\
         error is above that of the reference ({:.1e} for the state, {:.1e} for the tangent).\n",
            table(&head, &rows),
            self.alpha,
            self.beads,
            self.events.len(),
            self.floor.0,
            self.floor.1,
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        Ok(named([("order.csv", csv(self)), ("order.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        let (state, tangent) = ((Quantity::State, self.floor.0), (Quantity::Tangent, self.floor.1));
        Ok(named([("order-state.png", picture(self, state)?), ("order-tangent.png", picture(self, tangent)?)]))
    }
}

/// A line a run.
fn csv(study: &OrderStudy) -> Vec<u8> {
    let mut text = String::from("method,mode,quantity,slope,slope_theory,steps,error\n");
    for row in &study.rows {
        let slope = row.slope.map_or_else(|| "nan".to_owned(), |slope| format!("{slope:e}"));
        for (steps, error) in row.steps.iter().zip(&row.errors) {
            let (method, mode, quantity) = (row.method.name(), row.mode.name(), row.quantity.name());
            text += &format!("{method},{mode},{quantity},{slope},{:e},{steps},{error:e}\n", row.theory);
        }
    }
    text.into_bytes()
}

/// The methods in the picture: more curves would hide each other.
#[cfg(feature = "plot")]
const PICTURED: [&str; 7] =
    ["verlet", "strang-linear", "yoshida4-linear", "aba1064-linear", "kahan-li8-linear", "corrected", "dop853"];

/// Errors of the state or of the tangent against steps.
#[cfg(feature = "plot")]
fn picture(study: &OrderStudy, (quantity, floor): (Quantity, f64)) -> Result<crate::figures::Picture> {
    use crate::{
        figures::{Curve, Point, WorkPrecision, work_precision},
        study::Mode,
    };
    let limit = if quantity == Quantity::State { study.alpha + 1.0 } else { study.alpha };
    let pictured = |row: &&OrderRow| row.quantity == quantity && PICTURED.contains(&row.method.name().as_str());
    let curve = |row: &OrderRow| Curve {
        name: row.method.name(),
        family: Mode::ALL.iter().position(|mode| *mode == row.mode).unwrap_or(0),
        slope: row.slope,
        points: row
            .steps
            .iter()
            .zip(&row.errors)
            .map(|(&steps, &error)| Point { work: steps as f64, error, below_reference: error < 3.0 * floor })
            .collect(),
    };
    let words = match quantity {
        Quantity::State => "Largest error of a component of the state",
        Quantity::Tangent => "Largest error of a component of the derivative by the initial state, in one direction,",
    };
    let figure = WorkPrecision {
        title: format!("α = {}: order through contacts, {}", study.alpha, quantity.name()),
        work_label: "steps of the run".to_owned(),
        error_label: format!("error of the {} at the end", quantity.name()),
        curves: study.rows.iter().filter(pictured).map(curve).collect(),
        floor: Some(floor),
        caption: format!(
            "{words} at t = 12 on a free chain of {} beads with resonators (κ = 1, ρ = 1/3) and {} onsets and releases. \
             Crossing a contact limits the order to {} whatever the method; landing on it {}; kicks whose error at events is taken back have order 4; a variable in which the solution is smooth (power q = {}) lifts the limit. Each \
             point of the crossing and landing methods is a root mean square over seven neighbouring numbers of steps, of corrected kicks the median. hertzchain {}.",
            study.beads,
            study.events.len(),
            limit,
            if study.alpha.fract() == 0.0 {
                "is enough for an integer exponent"
            } else {
                "makes only the constant smaller"
            },
            study.q,
            env!("CARGO_PKG_VERSION")
        ),
        families: Mode::ALL.map(|mode| mode.name().to_owned()).into(),
        grey: None,
        guides: vec![(limit, format!("order {limit}"))],
    };
    Ok(work_precision(&figure)?)
}
