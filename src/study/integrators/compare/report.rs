//! The report of a comparison.

use super::{Candidate, Comparison, ErrorNorm, Row};
use crate::{
    present::machine_json,
    report::{
        Curve,
        Digits::{Fixed, Hidden, Power, Short},
        Point, Quantity, Report, Table, WorkPrecision,
    },
    run::Method,
    study::{families, scene_caption, scene_json},
};
use serde_json::{Map, Value, json};

impl Comparison {
    /// The report.
    pub fn report(&self) -> Report {
        let Self { scene, norm, reference, stopped, left_out, .. } = self;
        let slopes: Map<String, Value> =
            self.candidates().iter().map(|candidate| (candidate.name(), json!(self.slope(candidate)))).collect();
        let reasons = |all: Vec<(String, String)>| all.into_iter().map(|(name, why)| (name, json!(why))).collect();
        let ended: Map<String, Value> = reasons(stopped.iter().map(|(one, why)| (one.name(), why.clone())).collect());
        let missing: Map<String, Value> =
            reasons(left_out.iter().map(|(one, why)| (one.name(), (*why).to_owned())).collect());
        let listed = |what: &str, all: &Map<String, Value>| {
            let words: Vec<String> =
                all.iter().map(|(name, why)| format!("{name}: {}", why.as_str().unwrap())).collect();
            if words.is_empty() { String::new() } else { format!("{what}: {}.", words.join("; ")) }
        };
        let [end, period] = [scene.end(), scene.fast_period()].map(|t| scene.in_file(Quantity::Time, t));
        let largest = self.largest();
        let scales: Vec<String> = largest.iter().map(|(name, value)| format!("{name} {value:.6e}")).collect();
        let measure = match norm {
            ErrorNorm::Energy => "max |E - E(0)| / |E(0)| along the run".to_owned(),
            _ => format!(
                "the largest at t = {end} of {}, each relative to its largest in the reference: {}",
                norm.words(),
                scales.join(", ")
            ),
        };
        Report::new("compare")
            .si(scene.units())
            .fact("scene", scene.name())
            .fact("period", period)
            .fact("norm", norm.name())
            .fact("largest", largest.into_iter().collect::<std::collections::BTreeMap<_, _>>())
            .fact("reference", json!({"method": reference.method, "error_estimate": reference.error_estimate}))
            .table(self.table())
            .words(format!(
                "scene {}; errors (--error {}) are {measure}; reference {}, good to {:.1e}; a period of the fastest \
                 motion is {period:.6e}.",
                scene.title(),
                norm.name(),
                reference.method,
                reference.error_estimate,
            ))
            .fact("slopes", slopes)
            .words(listed(
                "ladders of steps or tolerances that ended early (a larger --max-time makes them longer)",
                &ended,
            ))
            .fact("stopped", ended)
            .words(listed("left out", &missing))
            .fact("left_out", missing)
            .words(format!(
                "fastest to reach an error in {} (its own and that of the reference together; all finer settings reach \
                 it, too, and have converged by a factor of two):",
                norm.words()
            ))
            .finding()
            .table(self.fastest_table())
            .finding()
            .fact("scene_file", scene_json(scene))
            .warnings(scene.doubts())
            .fact("machine", machine_json())
            .picture(self.picture())
    }

    /// The largest values that errors are relative to, by name, in the units of the file.
    fn largest(&self) -> Vec<(&'static str, f64)> {
        let quantities = [Quantity::Length, Quantity::Velocity, Quantity::Length];
        let all = [ErrorNorm::Strain, ErrorNorm::Velocity, ErrorNorm::Resonator].into_iter().zip(quantities);
        let named = all.zip(self.largest).map(|((norm, of), value)| (norm.name(), self.scene.in_file(of, value)));
        named.enumerate().filter(|(k, _)| self.norm.parts().contains(k)).map(|(_, named)| named).collect()
    }

    fn table(&self) -> Table {
        let below = "whether the error is below 3 times the error estimate of the reference: an upper bound at best";
        Table::of("compare", &self.rows)
            .si(self.scene.units())
            .col("integrator", Short, "", |row| row.candidate.name())
            .col("setting", Short, "", |row| row.setting.clone())
            .col("step", Power(3), "", |row| row.step)
            .kind(Quantity::Time)
            .col("error", Power(1), "in the chosen norm (--error)", |row| row.error)
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
    fn winners(&self) -> Vec<(f64, &Row, Option<&Row>)> {
        let errors = (1..=14).map(|digits| 10f64.powi(-digits));
        errors
            .filter_map(|error| self.fastest(error, false).map(|row| (error, row, self.fastest(error, true))))
            .collect()
    }

    fn fastest_table(&self) -> Table {
        Table::of("fastest", &self.winners())
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
        // All methods there are would hide each other: those of the selection, and the fastest.
        let drawn = Method::default_comparison_set();
        let fastest: Vec<Candidate> = self.winners().into_iter().map(|(_, row, _)| row.candidate).collect();
        let hidden: Vec<String> = methods
            .extract_if(.., |method| {
                let few = self.candidates().len() <= drawn.len() + 2;
                !(few || drawn.contains(method) || fastest.contains(&Candidate::Method(*method)))
            })
            .map(|method| method.name())
            .collect();
        let chosen = if hidden.is_empty() { String::new() } else { format!("Not drawn: {}. ", hidden.join(", ")) };
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
            "{chosen}t = {}. Reference: {}, good to {:.1e} (grey line); hollow points are too near to it to be trusted.",
            self.scene.in_words(self.scene.end()),
            self.reference.method,
            self.reference.error_estimate,
        );
        WorkPrecision {
            title: format!("{}: error against run time", self.scene.name()),
            work_label: "wall time (s), median of runs".to_owned(),
            error_label: match self.norm {
                ErrorNorm::Energy => "largest |E − E(0)| / |E(0)|".to_owned(),
                norm => format!("relative error of {}", norm.words()),
            },
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
