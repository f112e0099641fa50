//! A comparison as text, JSON, CSV and a picture.

#[cfg(feature = "plot")]
use super::Entrant;
use super::{Comparison, Row};
use crate::{
    error::Result,
    present::{machine_json, rows_csv, table},
    study::{File, Report, named, scene_json},
};
use serde_json::{Value, json};

/// Columns of the CSV: keys of the rows.
const COLUMNS: &str = "integrator,setting,step,error,energy_error,wall_s,runs,force_evaluations,steps,rejected,below_reference,failure,step_cost";

/// The text of a cell of the CSV without a value.
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
            self.entrants().iter().map(|entrant| (entrant.name(), json!(self.slope(entrant)))).collect();
        let stopped: serde_json::Map<String, Value> =
            self.stopped.iter().map(|(entrant, why)| (entrant.name(), json!(why))).collect();
        let left_out: serde_json::Map<String, Value> =
            self.left_out.iter().map(|(method, why)| (method.name(), json!(why))).collect();
        json!({
            "scene": self.scene.name(),
            "period": self.scene.fast_period(),
            "amplitude": self.amplitude,
            "reference": {
                "method": self.reference.method,
                "error_estimate": self.reference.error_estimate,
            },
            "rows": rows(self),
            "slopes": slopes,
            "stopped": stopped,
            "left_out": left_out,
            "scene_file": scene_json(&self.scene),
            "machine": machine_json(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// All rows, why ladders ended, the methods that were left out, and the fastest method for each
    /// of a few errors.
    fn text(&self) -> String {
        let Comparison { scene, amplitude, reference, .. } = self;
        let mut text = listed(self);
        text += &format!(
            "\nscene {}: {}\nerror = max |x - x_ref| / {amplitude:.6e} at t = {}; reference {}, good to {:.1e}.\n\
             a period of the fastest motion is {:.6e}; cost = wall time of a step, in steps of plain Verlet.\n",
            scene.name(),
            scene.file().summary,
            scene.end(),
            reference.method,
            reference.error_estimate,
            scene.fast_period(),
        );
        if self.rows.iter().any(|row| row.below_reference) {
            text +=
                "* below 3 times the error estimate of the reference, and so not resolved: an upper bound at best.\n";
        }
        if !self.stopped.is_empty() {
            text += "\nladders of steps or tolerances that ended early (a larger --max-time makes them longer):\n";
            let rows: Vec<_> = self.stopped.iter().map(|(entrant, why)| vec![entrant.name(), why.clone()]).collect();
            text += &table(&["integrator", "why"], &rows);
        }
        for (why, names) in left_out(self) {
            text += &format!("\nleft out, {why}:\n{}\n", names.join(", "));
        }
        text += "\nfastest to reach an error (its own and that of the reference together):\n";
        text += &fastest(self);
        text
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        Ok(named([("compare.csv", rows_csv(COLUMNS, &rows(self), missing)), ("compare.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("compare.png", picture(self)?)]))
    }
}

/// The names of the methods that were left out, by the reason.
fn left_out(comparison: &Comparison) -> Vec<(&'static str, Vec<String>)> {
    let mut reasons: Vec<(&'static str, Vec<String>)> = Vec::new();
    for (method, why) in &comparison.left_out {
        match reasons.iter_mut().find(|(reason, _)| reason == why) {
            Some((_, names)) => names.push(method.name()),
            None => reasons.push((why, vec![method.name()])),
        }
    }
    reasons
}

fn rows(comparison: &Comparison) -> Vec<Value> {
    let row = |row: &Row| {
        json!({
            "integrator": row.entrant.name(),
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
            "step_cost": comparison.step_cost(row),
        })
    };
    comparison.rows.iter().map(row).collect()
}

/// A line a row.
fn listed(comparison: &Comparison) -> String {
    let number =
        |value: Option<f64>, digits: usize| value.map(|value| format!("{value:.digits$e}")).unwrap_or_default();
    let mut rows = Vec::new();
    for entrant in comparison.entrants() {
        let slope = comparison.slope(&entrant);
        for (i, row) in comparison.rows_of(&entrant).into_iter().enumerate() {
            let error = match (&row.failure, row.below_reference) {
                (Some(_), _) => "failed".to_owned(),
                (None, below) => number(row.error, 1) + if below { " *" } else { "" },
            };
            rows.push(vec![
                if i == 0 { entrant.name() } else { String::new() },
                row.setting.clone(),
                format!("{:.3e}", row.step),
                error,
                number(row.energy_error, 1),
                number(row.wall, 2),
                comparison.step_cost(row).map(|cost| format!("{cost:.1}")).unwrap_or_default(),
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
        "cost",
        "forces",
        "rejected",
        "order",
        "failure",
    ];
    table(&head, &rows)
}

/// The fastest method for an error, and the fastest plain loop beside it.
fn fastest(comparison: &Comparison) -> String {
    let ms = |wall: Option<f64>| wall.map(|wall| format!("{:.3} ms", 1e3 * wall)).unwrap_or_default();
    let line = |error: f64, row: &Row| {
        let plain = comparison.fastest_plain(error);
        let wall = plain.and_then(|plain| plain.wall);
        let ratio = wall.zip(row.wall).map(|(plain, ours)| format!("{:.1}", plain / ours));
        vec![
            format!("{error:.0e}"),
            row.entrant.name(),
            row.setting.clone(),
            ms(row.wall),
            plain.map_or_else(|| "-".to_owned(), |plain| plain.entrant.name()),
            ms(wall),
            ratio.unwrap_or_default(),
        ]
    };
    let rows: Vec<_> = (1..=14)
        .map(|digits| 10f64.powi(-digits))
        .filter_map(|error| comparison.fastest(error).map(|row| line(error, row)))
        .collect();
    table(&["error", "integrator", "setting", "wall time", "plain loop", "its time", "ratio"], &rows)
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
fn picture(comparison: &Comparison) -> Result<crate::figures::Picture> {
    use crate::figures::{Curve, Point, WorkPrecision, work_precision};
    let (mut methods, mut loops) = (Vec::new(), Vec::new());
    for entrant in comparison.entrants() {
        match entrant {
            Entrant::Method(method) => methods.push(method),
            Entrant::Plain(_) => loops.push(entrant),
        }
    }
    let all = methods.len();
    if all > PICTURED.len() {
        methods.retain(|method| PICTURED.contains(&method.name().as_str()));
    }
    let chosen = if methods.len() < all { format!("{} of {all} methods. ", methods.len()) } else { String::new() };
    let (mut families, mut family_of) = crate::study::families(&methods);
    let grey = families.len();
    families.push("plain loops".to_owned());
    family_of.resize(methods.len() + loops.len(), grey);
    let curves = methods
        .into_iter()
        .map(Entrant::Method)
        .chain(loops)
        .zip(family_of)
        .map(|(entrant, family)| {
            let points = comparison.rows_of(&entrant).into_iter().filter_map(|row| {
                Some(Point { work: row.wall?, error: row.error?, below_reference: row.below_reference })
            });
            Curve { name: entrant.name(), family, points: points.collect(), slope: comparison.slope(&entrant) }
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
        grey: Some(grey),
        guides: Vec::new(),
    };
    Ok(work_precision(&figure)?)
}
