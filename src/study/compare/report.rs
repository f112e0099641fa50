//! The report of a comparison.

use super::{Candidate, Comparison, Row};
use crate::{
    present::machine_json,
    report::{
        Curve,
        Digits::{Fixed, Hidden, Power, Short},
        Point, Quantity, Report, Table, WorkPrecision,
    },
    study::{families, scene_caption, scene_json},
};
use serde_json::{Map, Value, json};

/// The methods in the picture if there are many: more curves would hide each other.
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

impl Comparison {
    /// The report.
    pub fn report(&self) -> Report {
        let Self { scene, amplitude, reference, stopped, left_out, .. } = self;
        let map = |entries: Vec<(String, Value)>| entries.into_iter().collect::<Map<String, Value>>();
        let slopes =
            self.candidates().iter().map(|candidate| (candidate.name(), json!(self.slope(candidate)))).collect();
        let ended = stopped.iter().map(|(candidate, why)| (candidate.name(), json!(why))).collect();
        let missing = left_out.iter().map(|(method, why)| (method.name(), json!(why))).collect();
        let list = |names: Vec<(String, String)>| {
            names.iter().map(|(name, why)| format!("{name}: {why}")).collect::<Vec<_>>().join("; ")
        };
        let ended_words = list(stopped.iter().map(|(candidate, why)| (candidate.name(), why.clone())).collect());
        let missing_words = list(left_out.iter().map(|(method, why)| (method.name(), (*why).to_owned())).collect());
        let [end, period] = [scene.end(), scene.fast_period()].map(|t| scene.in_file(Quantity::Time, t));
        let amplitude = scene.in_file(Quantity::Length, *amplitude);
        let listed = |what: &str, list: String| if list.is_empty() { list } else { format!("{what}: {list}.") };
        Report::new("compare")
            .si(scene.units())
            .fact("scene", scene.name())
            .fact("period", period)
            .fact("amplitude", amplitude)
            .fact("reference", json!({"method": reference.method, "error_estimate": reference.error_estimate}))
            .table(self.table())
            .words(format!(
                "scene {}; errors are max |x - x_ref| / {amplitude:.6e} at t = {}; reference {}, good to {:.1e}; a period \
                 of the fastest motion is {:.6e}.",
                scene.title(),
                end,
                reference.method,
                reference.error_estimate,
                period,
            ))
            .fact("slopes", map(slopes))
            .fact("stopped", map(ended))
            .words(listed("ladders of steps or tolerances that ended early (a larger --max-time makes them longer)", ended_words))
            .fact("left_out", map(missing))
            .words(listed("left out", missing_words))
            .words("fastest to reach an error (its own and that of the reference together):")
            .finding()
            .table(self.fastest_table())
            .finding()
            .fact("scene_file", scene_json(scene))
            .warnings(scene.doubts())
            .fact("machine", machine_json())
            .picture(self.picture())
    }

    fn table(&self) -> Table {
        let below = "whether the error is below 3 times the error estimate of the reference: an upper bound at best";
        Table::of("compare", &self.rows)
            .si(self.scene.units())
            .col("integrator", Short, "", |row| row.candidate.name())
            .col("setting", Short, "", |row| row.setting.clone())
            .col("step", Power(3), "", |row| row.step)
            .kind(Quantity::Time)
            .col("error", Power(1), "", |row| row.error)
            .col("energy_error", Power(1), "", |row| row.energy_error)
            .col("wall_s", Power(2), "median wall time of a run, in seconds", |row| row.wall)
            .col("runs", Hidden, "runs whose median it is", |row| row.repeats)
            .col("force_evaluations", Short, "", |row| row.stats.force_evaluations)
            .head("forces")
            .col("steps", Hidden, "", |row| row.stats.steps)
            .col("rejected", Short, "", |row| row.stats.rejected)
            .col("below_reference", Short, below, |row| row.below_reference)
            .head("below")
            .col("failure", Short, "", |row| row.failure.clone())
            .col("step_cost", Fixed(1), "wall time of a step, in steps of plain Verlet", |row| self.step_cost(row))
            .head("cost")
            .col("order", Fixed(2), "slope of log error against log step", |row| self.slope(&row.candidate))
            .done()
    }

    /// The fastest method for each of a few errors, and the fastest plain loop beside it.
    fn fastest_table(&self) -> Table {
        let errors = (1..=14).map(|digits| 10f64.powi(-digits));
        let rows: Vec<(f64, &Row, Option<&Row>)> =
            errors.filter_map(|error| self.fastest(error).map(|row| (error, row, self.fastest_plain(error)))).collect();
        Table::of("fastest", &rows)
            .key("fastest")
            .col("error", Power(0), "", |row| row.0)
            .col("integrator", Short, "", |row| row.1.candidate.name())
            .col("setting", Short, "", |row| row.1.setting.clone())
            .col("wall_s", Power(2), "wall time, in seconds", |row| row.1.wall)
            .col("plain_loop", Short, "fastest plain loop", |row| row.2.map(|plain| plain.candidate.name()))
            .col("plain_wall_s", Power(2), "its wall time", |row| row.2.and_then(|plain| plain.wall))
            .col("ratio", Fixed(1), "of the two times", |row| {
                row.2.and_then(|plain| plain.wall).zip(row.1.wall).map(|(plain, ours)| plain / ours)
            })
            .done()
    }

    fn picture(&self) -> WorkPrecision {
        let (mut methods, mut loops) = (Vec::new(), Vec::new());
        for candidate in self.candidates() {
            match candidate {
                Candidate::Method(method) => methods.push(method),
                Candidate::Plain(_) => loops.push(candidate),
            }
        }
        let all = methods.len();
        if all > PICTURED.len() {
            methods.retain(|method| PICTURED.contains(&method.name().as_str()));
        }
        let chosen = if methods.len() < all { format!("{} of {all} methods. ", methods.len()) } else { String::new() };
        let (mut families, mut family_of) = families(&methods);
        let grey = families.len();
        families.push("plain loops".to_owned());
        family_of.resize(methods.len() + loops.len(), grey);
        let curve = |(candidate, family): (Candidate, usize)| {
            let points = self.rows_of(&candidate).into_iter().filter_map(|row| {
                Some(Point { work: row.wall?, error: row.error?, below_reference: row.below_reference })
            });
            Curve { name: candidate.name(), family, points: points.collect(), slope: self.slope(&candidate) }
        };
        let how = format!(
            "{chosen}t = {:.6}. Reference: {}, good to {:.1e} (grey line); hollow points are too near to it to be trusted.",
            self.scene.in_file(Quantity::Time, self.scene.end()),
            self.reference.method,
            self.reference.error_estimate,
        );
        WorkPrecision {
            title: format!("{}: error against run time", self.scene.name()),
            work_label: "wall time (s), median of runs".to_owned(),
            error_label: "error max |xₙ − xₙ(ref)| / amplitude".to_owned(),
            curves: methods.into_iter().map(Candidate::Method).chain(loops).zip(family_of).map(curve).collect(),
            floor: Some(self.reference.error_estimate),
            caption: scene_caption(&self.scene, &how),
            families,
            grey: Some(grey),
            lit: vec![],
            guides: Vec::new(),
        }
    }
}
