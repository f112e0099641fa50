//! A comparison as people and machines read it.

use super::{Comparison, Row};
use crate::{
    error::Result,
    present::{machine_json, rows_csv, table},
    study::{File, Report, named, scene_json},
};
use serde_json::{Value, json};

/// Columns of the CSV: keys of the rows.
const COLUMNS: &str =
    "integrator,setting,step,error,energy_error,wall_s,runs,force_evaluations,steps,rejected,below_reference,failure";

/// What stands for a number or words that there are not.
fn missing(key: &str) -> &'static str {
    match key {
        "failure" => "",
        "step" => "NaN",
        _ => "nan",
    }
}

impl Report for Comparison {
    fn json(&self) -> Value {
        let slopes: serde_json::Map<String, Value> =
            self.methods().iter().map(|method| (method.name(), json!(self.slope(method)))).collect();
        json!({
            "scene": self.scene.name(),
            "period": self.scene.period(),
            "amplitude": self.amplitude,
            "reference": {
                "method": self.reference.method,
                "error_estimate": self.reference.error_estimate,
            },
            "rows": rows(self),
            "slopes": slopes,
            "scene_file": scene_json(&self.scene),
            "machine": machine_json(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// All rows, and the fastest method for each of a few errors.
    fn text(&self) -> String {
        let number =
            |value: Option<f64>, digits: usize| value.map(|value| format!("{value:.digits$e}")).unwrap_or_default();
        let mut rows = Vec::new();
        for method in self.methods() {
            let slope = self.slope(&method);
            for (i, row) in self.rows_of(&method).into_iter().enumerate() {
                let error = match (&row.failure, row.below_reference) {
                    (Some(_), _) => "failed".to_owned(),
                    (None, below) => number(row.error, 1) + if below { " *" } else { "" },
                };
                rows.push(vec![
                    if i == 0 { method.name() } else { String::new() },
                    row.setting.clone(),
                    format!("{:.3e}", row.step),
                    error,
                    number(row.energy_error, 1),
                    number(row.wall, 2),
                    row.stats.force_evaluations.to_string(),
                    row.stats.rejected.to_string(),
                    slope.filter(|_| i == 0).map(|slope| format!("{slope:.2}")).unwrap_or_default(),
                    row.failure.clone().unwrap_or_default(),
                ]);
            }
        }
        let head = [
            "integrator",
            "setting",
            "step",
            "error",
            "energy error",
            "wall s",
            "forces",
            "rejected",
            "order",
            "failure",
        ];
        let mut text = table(&head, &rows);
        let Comparison { scene, amplitude, reference, rungs, .. } = self;
        text += &format!(
            "\nscene {}: {}\nerror = max |x - x_ref| / {amplitude:.6e} at t = {}; reference {}, good to {:.1e}.\n",
            scene.name(),
            scene.file().summary,
            scene.end(),
            reference.method,
            reference.error_estimate,
        );
        if self.rows.iter().any(|row| row.below_reference) {
            text += "* nearer to the reference than 3 times its own error estimate: an upper bound at best.\n";
        }
        if rungs.0 < rungs.1 {
            text += &format!("the time allowed {} of {} rungs; --max-time gives it more.\n", rungs.0, rungs.1);
        }
        text += "\nfastest to reach an error (its own and that of the reference together):\n";
        text += &fastest(self);
        text
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        Ok(named([("compare.csv", rows_csv(COLUMNS, &rows(self), missing)), ("compare.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<File>> {
        Ok(named([("compare.png", picture(self)?)]))
    }
}

fn rows(comparison: &Comparison) -> Vec<Value> {
    let row = |row: &Row| {
        json!({
            "integrator": row.method.name(),
            "setting": row.setting,
            "step": row.step,
            "error": row.error,
            "energy_error": row.energy_error,
            "wall_s": row.wall,
            "runs": row.repeats,
            "force_evaluations": row.stats.force_evaluations,
            "steps": row.stats.steps,
            "rejected": row.stats.rejected,
            "below_reference": row.below_reference,
            "failure": row.failure,
        })
    };
    comparison.rows.iter().map(row).collect()
}

fn fastest(comparison: &Comparison) -> String {
    let line = |error: f64, row: &Row| {
        vec![
            format!("{error:.0e}"),
            row.method.name(),
            row.setting.clone(),
            row.wall.map(|wall| format!("{:.3} ms", 1e3 * wall)).unwrap_or_default(),
        ]
    };
    let rows: Vec<_> = (1..=14)
        .map(|digits| 10f64.powi(-digits))
        .filter_map(|error| comparison.fastest(error).map(|row| line(error, row)))
        .collect();
    table(&["error", "integrator", "setting", "wall time"], &rows)
}

/// The methods in the picture if there are many: more curves would hide each other.
#[cfg(feature = "plot")]
const PICTURED: [&str; 12] = [
    "verlet",
    "yoshida4",
    "aba864",
    "srkn14-6",
    "strang-linear",
    "yoshida4-linear",
    "aba1064-linear",
    "srkn14-6-linear",
    "aba1064-linear-landed",
    "corrected",
    "dop853-regularised",
    "collocation",
];

/// The work-precision diagram.
#[cfg(feature = "plot")]
fn picture(comparison: &Comparison) -> Result<Vec<u8>> {
    use crate::figures::{Curve, Point, WorkPrecision, work_precision};
    let mut methods = comparison.methods();
    let all = methods.len();
    if all > PICTURED.len() {
        methods.retain(|method| PICTURED.contains(&method.name().as_str()));
    }
    let chosen = if methods.len() < all { format!("{} of {all} methods. ", methods.len()) } else { String::new() };
    let (families, family_of) = crate::study::families(&methods);
    let curves = methods
        .iter()
        .zip(family_of)
        .map(|(method, family)| {
            let points = comparison.rows_of(method).into_iter().filter_map(|row| {
                Some(Point { work: row.wall?, error: row.error?, below_reference: row.below_reference })
            });
            Curve { name: method.name(), family, points: points.collect(), slope: comparison.slope(method) }
        })
        .collect();
    let scene = &comparison.scene;
    let how = format!(
        "{chosen}t = {:.6}. Reference: {}, good to {:.1e} (grey line); hollow points are too near to it to be trusted.",
        scene.end(),
        comparison.reference.method,
        comparison.reference.error_estimate,
    );
    let figure = WorkPrecision {
        title: format!("{}: error against run time", scene.name()),
        work_label: "wall time (s), median of runs".to_owned(),
        error_label: "error max |xₙ − xₙ(ref)| / amplitude".to_owned(),
        curves,
        floor: Some(comparison.reference.error_estimate),
        caption: crate::study::provenance(scene, &how),
        families,
        guides: Vec::new(),
    };
    Ok(work_precision(&figure)?)
}
