//! The scaling study as text, JSON, CSV and a picture.

use super::{ScalingRow, ScalingStudy};
use crate::{
    error::Result,
    present::{machine_json, rows_csv, table},
    study::{File, Report, named},
};
use serde_json::{Value, json};

/// Columns of the CSV: keys of the rows.
const COLUMNS: &str = "integrator,sites,wall,per_bond_period,runs,steps,rejected,force_evaluations,failure";

/// The text of a cell of the CSV without a value.
fn missing(key: &str) -> &'static str {
    if key == "failure" { "" } else { "nan" }
}

impl Report for ScalingStudy {
    /// Times are in seconds, null where a run failed or was left out.
    fn json(&self) -> Value {
        json!({
            "tol": self.tol,
            "periods": self.periods,
            "perturbation": self.perturbation,
            "seed": self.seed,
            "scene": self.scene,
            "rows": rows(self),
            "machine": machine_json(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// With the times per bond and period in nanoseconds.
    fn text(&self) -> String {
        let cells = |(nth, row): (usize, &&ScalingRow)| {
            let count = |count: u64| if row.wall.is_some() { count.to_string() } else { String::new() };
            vec![
                if nth == 0 { row.method.name() } else { String::new() },
                row.sites.to_string(),
                row.wall.map(|wall| format!("{wall:.2e}")).unwrap_or_default(),
                row.per_bond_period.map(|time| format!("{:.0}", 1e9 * time)).unwrap_or_default(),
                count(row.repeats as u64),
                count(row.stats.steps),
                count(row.stats.rejected),
                count(row.stats.force_evaluations),
                row.failure.clone().unwrap_or_default(),
            ]
        };
        let methods = ScalingStudy::methods();
        let rows: Vec<_> = methods
            .iter()
            .flat_map(|method| self.rows_of(method).iter().enumerate().map(cells).collect::<Vec<_>>())
            .collect();
        let head =
            ["integrator", "sites", "wall s", "ns/bond/period", "runs", "steps", "rejected", "forces", "failure"];
        format!("{}\n{}\nForces: evaluations by each bond, at most.\n", table(&head, &rows), how(self))
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        Ok(named([("scaling.csv", rows_csv(COLUMNS, &rows(self), missing)), ("scaling.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("scaling.png", picture(self)?)]))
    }
}

fn rows(study: &ScalingStudy) -> Vec<Value> {
    let row = |row: &ScalingRow| {
        json!({
            "integrator": row.method.name(),
            "sites": row.sites,
            "wall": row.wall,
            "per_bond_period": row.per_bond_period,
            "runs": row.repeats,
            "steps": row.stats.steps,
            "rejected": row.stats.rejected,
            "force_evaluations": row.stats.force_evaluations,
            "failure": row.failure,
        })
    };
    study.rows.iter().map(row).collect()
}

/// What was measured, in words.
fn how(study: &ScalingStudy) -> String {
    format!(
        "Median wall time of runs that record nothing, on one thread, over {} periods of the wave of scene tw-q15 (strain ring, \
         q = pi/5, alpha = 1.5, kappa = 1, rho = 1/3),\nevery entry of the initial state moved by up to {} of the largest of its \
         kind (seed {}); tolerance {:e}: of the sum of all local errors for collocation, of the end for corrected (whose trial runs count), of a step for dop853,\nin the mean over all sites, so \
         that on a long ring no single contact counts: equal tolerances are not equal errors.",
        study.periods, study.perturbation, study.seed, study.tol,
    )
}

/// Nanoseconds per bond and period against the number of sites.
#[cfg(feature = "plot")]
fn picture(study: &ScalingStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Curve, Point, WorkPrecision, work_precision};
    let methods = ScalingStudy::methods();
    let point = |row: &ScalingRow| {
        let time = row.per_bond_period?;
        Some(Point { work: row.sites as f64, error: 1e9 * time, below_reference: false })
    };
    let (families, family_of) = crate::study::families(&methods);
    let curve = |(nth, method): (usize, &crate::run::method::Method)| Curve {
        name: method.name(),
        family: family_of[nth],
        points: study.rows_of(method).into_iter().filter_map(point).collect(),
        slope: None,
    };
    let how = how(study)
        .replace('\n', " ")
        .replace("pi", "π")
        .replace("alpha", "α")
        .replace("kappa", "κ")
        .replace("rho", "ρ");
    let figure = WorkPrecision {
        title: format!("Run time per bond and period, tolerance {:e}", study.tol),
        work_label: "number of sites N".to_owned(),
        error_label: "run time per bond and period (ns)".to_owned(),
        curves: methods.iter().enumerate().map(curve).collect(),
        caption: format!(
            "{how} Collocation alone would use all cores on chains of more than 256 bonds; here it has one, too. \
             The dashed line grows like N: the run time of the whole chain like N². hertzchain {}.",
            env!("CARGO_PKG_VERSION")
        ),
        floor: None,
        families,
        grey: None,
        guides: vec![(-1.0, "grows like N".to_owned())],
    };
    Ok(work_precision(&figure)?)
}
