//! The study of dimers as text, JSON, CSV and a picture.

use super::{DimerRow, DimerStudy, FIRST_CELL, PUBLISHED};
use crate::{
    error::Result,
    output::csv,
    present::table,
    study::{
        File, Report, named,
        pulses::{METHOD, STEP},
    },
};
use serde_json::{Value, json};

/// The published mass ratio next to one that was found, if it is within a tenth.
fn published(ratio: f64) -> Option<f64> {
    PUBLISHED.into_iter().find(|known| (ratio / known - 1.0).abs() < 0.1)
}

impl Report for DimerStudy {
    fn json(&self) -> Value {
        let row = |row: &DimerRow| json!({"ratio": row.ratio, "first": row.first, "last": row.last, "transmission": row.transmission()});
        let maximum = |found: &DimerRow| {
            let mut value = row(found);
            value["published"] = json!(published(found.ratio));
            value
        };
        json!({
            "cells": self.cells,
            "first_cell": FIRST_CELL,
            "integrator": METHOD,
            "step": STEP,
            "rows": self.rows.iter().map(row).collect::<Vec<Value>>(),
            "maxima": self.maxima.iter().map(maximum).collect::<Vec<Value>>(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let cells = |row: &DimerRow| {
            let known = published(row.ratio).map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.4}"));
            vec![format!("{:.4}", row.ratio), known, format!("{:.5}", row.transmission())]
        };
        let rows: Vec<_> = self.maxima.iter().map(cells).collect();
        let least = self.rows.iter().min_by(|a, b| a.transmission().total_cmp(&b.transmission()));
        let least = least.map_or_else(String::new, |row| {
            format!(
                "Least transmission of {} mass ratios: {:.5} at m = {:.4}.\n",
                self.rows.len(),
                row.transmission(),
                row.ratio
            )
        });
        format!(
            "{}\nMaxima of the transmission F_2/F_1 of a pulse over {} cells of a 1:1 dimer, light mass over heavy mass: solitary \
             waves where it is 1. Published: Jayaprakash, Starosvetsky & Vakakis 2011.\n{least}",
            table(&["mass ratio", "published", "transmission"], &rows),
            self.cells
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let rows = self.rows.iter().map(|row| vec![row.ratio, row.first, row.last, row.transmission()]);
        let table = csv(&["ratio", "first", "last", "transmission"], rows);
        Ok(named([("dimer.csv", table), ("dimer.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("dimer.png", picture(self)?)]))
    }
}

/// The transmission against the mass ratio, with the maxima and the published ratios.
#[cfg(feature = "plot")]
fn picture(study: &DimerStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Kind, Line, Panel, Panels, panels};
    let points = |rows: &[DimerRow]| rows.iter().map(|row| (row.ratio, row.transmission())).collect::<Vec<_>>();
    let range = study.rows.first().zip(study.rows.last());
    let inside = |ratio: &f64| range.is_some_and(|(low, high)| (low.ratio..=high.ratio).contains(ratio));
    let lines = vec![
        Line { name: "computed".to_owned(), points: points(&study.rows) },
        Line { name: "maxima".to_owned(), points: points(&study.maxima) },
        Line {
            name: "published".to_owned(),
            points: PUBLISHED.into_iter().filter(inside).map(|ratio| (ratio, 1.0)).collect(),
        },
    ];
    let panel = Panel::new(Kind::LogCloud, ["mass ratio m, light over heavy", "transmission F₂/F₁"], lines);
    let caption = format!(
        "Largest contact force of a pulse {} cells after the {FIRST_CELL}th cell, over that there, in a 1:1 dimer without \
         precompression, α = 3/2, struck by a heavy bead of speed 1; at T = 1 the pulse is a solitary wave. Published: \
         Jayaprakash, Starosvetsky & Vakakis 2011. Integrator {METHOD}, steps of {STEP}. hertzchain {}.",
        study.cells,
        env!("CARGO_PKG_VERSION")
    );
    let title = format!("A pulse through {} cells of a dimer", study.cells);
    Ok(panels(&Panels::column(title, vec![panel], caption))?)
}
