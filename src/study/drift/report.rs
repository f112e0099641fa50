//! The drift study as text, JSON, CSV and a picture.

use super::{DriftRow, DriftStudy};
use crate::{
    error::Result,
    present::table,
    study::{File, Report, named, scene_json},
};
use serde_json::{Value, json};

impl Report for DriftStudy {
    /// A slope that cannot be fitted is null.
    fn json(&self) -> Value {
        let row = |row: &DriftRow| {
            json!({
                "integrator": row.method.name(),
                "setting": row.setting,
                "t": row.t,
                "energy_error": row.energy_error,
                "slope": row.slope,
                "wall": row.wall,
                "steps": row.stats.steps,
                "rejected": row.stats.rejected,
                "force_evaluations": row.stats.force_evaluations,
                "failure": row.failure,
            })
        };
        json!({
            "scene": self.scene.name(),
            "period": self.scene.period(),
            "periods": self.periods,
            "rows": self.rows.iter().map(row).collect::<Vec<Value>>(),
            "scene_file": scene_json(&self.scene),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// The error at a hundredth of the time and at the end, and the slope between.
    fn text(&self) -> String {
        let cells = |row: &DriftRow| {
            let early = 0.01 * self.scene.end() * (1.0 + 1e-9);
            let error = |error: Option<&f64>| error.map(|error| format!("{error:.1e}")).unwrap_or_default();
            vec![
                row.method.name(),
                row.setting.clone(),
                error(row.t.iter().rposition(|&t| t <= early).map(|k| &row.energy_error[k])),
                error(row.energy_error.last()),
                row.slope.map_or_else(|| "–".to_owned(), |slope| format!("{slope:.2}")),
                row.stats.steps.to_string(),
                row.stats.force_evaluations.to_string(),
                format!("{:.2e}", row.wall),
                row.failure.clone().unwrap_or_default(),
            ]
        };
        let rows: Vec<_> = self.rows.iter().map(cells).collect();
        let head =
            ["integrator", "setting", "error at 1 %", "at the end", "slope", "steps", "forces", "wall s", "failure"];
        format!(
            "{}\nscene {}: {}\nerror: largest |E(t) - E(0)| / |E(0)| so far, at 1 % and at the end of {} periods of {:.6}; slope: of its \
         logarithm against that of t, in between.\n",
            table(&head, &rows),
            self.scene.name(),
            self.scene.file().summary,
            self.periods,
            self.scene.period(),
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        Ok(named([("drift.csv", csv(self)), ("drift.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("drift.png", picture(self)?)]))
    }
}

/// A line a time.
fn csv(study: &DriftStudy) -> Vec<u8> {
    let mut text = String::from("integrator,setting,t,energy_error\n");
    for row in &study.rows {
        let (method, setting) = (row.method.name(), &row.setting);
        for (t, error) in row.t.iter().zip(&row.energy_error) {
            text += &format!("{method},{setting},{t:e},{error:e}\n");
        }
    }
    text.into_bytes()
}

/// Points of a curve in the picture, at most: more markers would hide the line.
#[cfg(feature = "plot")]
const MOST_POINTS: usize = 40;

/// Every k-th point of a row, with the last point included. Each has the largest error so far, so
/// that points left out hide no error.
#[cfg(feature = "plot")]
fn points(row: &DriftRow) -> Vec<crate::figures::Point> {
    let stride = row.t.len().div_ceil(MOST_POINTS).max(1);
    let all = row.t.iter().zip(&row.energy_error).rev().step_by(stride);
    let mut points: Vec<_> =
        all.map(|(&t, &error)| crate::figures::Point { work: t, error, below_reference: false }).collect();
    points.reverse();
    points
}

/// Largest relative error of the energy up to `t` against `t`.
#[cfg(feature = "plot")]
fn picture(study: &DriftStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Curve, WorkPrecision, work_precision};
    let methods: Vec<_> = study.rows.iter().map(|row| row.method).collect();
    let (families, family_of) = crate::study::families(&methods);
    let curve = |(nth, row): (usize, &DriftRow)| {
        let failed = if row.failure.is_some() { ": failed" } else { "" };
        Curve {
            name: format!("{}, {}{failed}", row.method.name(), row.setting),
            family: family_of[nth],
            points: points(row),
            slope: None,
        }
    };
    let how = "The energy is looked at every 0.618 periods, and its largest error so far is shown. One run a method: \
               the curves say how large errors get, not by which law they grow.";
    let periods = if study.periods < 1e4 { study.periods.to_string() } else { format!("{:e}", study.periods) };
    let figure = WorkPrecision {
        title: format!("{}: error of the energy over {} periods", study.scene.name(), periods),
        work_label: format!("time t (dimensionless; a period is {:.4})", study.scene.period()),
        error_label: "largest |E − E(0)| / |E(0)| up to t".to_owned(),
        curves: study.rows.iter().enumerate().map(curve).collect(),
        caption: crate::study::provenance(&study.scene, how),
        floor: None,
        families,
        grey: None,
        guides: Vec::new(),
    };
    Ok(work_precision(&figure)?)
}
