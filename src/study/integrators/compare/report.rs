//! The report of a comparison.

use super::{Candidate, Comparison, ErrorNorm, Fastest};
use crate::{
    present::{machine_json, timed},
    report::{Curve, Fixed, Hidden, Point, Power, Quantity, Report, Short, Table, WorkPrecision},
    run::Method,
    study::{format_short, scene_caption, scene_json},
};
use serde_json::{Map, Value, json};

impl Comparison {
    /// The report.
    pub fn report(&self) -> Report {
        let Self { scene, norm, reference, stopped, left_out, .. } = self;
        let reasons = |all: &[(String, String)]| -> Map<String, Value> {
            all.iter().map(|(name, why)| (name.clone(), json!(why))).collect()
        };
        let ended: Vec<_> = stopped.iter().map(|(one, why)| (one.name(), why.clone())).collect();
        let missing: Vec<_> = left_out.iter().map(|(one, why)| (one.name(), (*why).to_owned())).collect();
        let failed = self.rows.iter().filter_map(|row| {
            let why = row.failure.as_ref()?.split(';').next()?.split(": energy went").next()?;
            Some((format!("{} at {}", row.candidate.name(), row.setting), why.to_owned()))
        });
        let short = |(name, why): &(String, String)| {
            let why = why.split_once(" at ").map_or(why.as_str(), |(why, _)| why);
            (name.clone(), why.to_owned())
        };
        let early = "ended early, longer with a larger --max-time (beaten: by a setting that takes less time than the next \
                     one, and has no larger error than is expected of it)";
        let apart = [
            (early, grouped(ended.iter().map(short))),
            ("left out", grouped(missing.clone())),
            ("failed", grouped(failed)),
        ];
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
        let report = Report::new("compare")
            .si(scene.units())
            .fact("scene", scene.name())
            .fact("period", period)
            .fact("norm", norm.name())
            .fact("largest", largest.into_iter().collect::<std::collections::BTreeMap<_, _>>())
            .fact("reference", json!({"method": reference.method, "error_estimate": reference.error_estimate}))
            .words(match self.winners().is_empty() {
                true => "no setting has reached an error of 0.1; with a larger --max-time ladders go on".to_owned(),
                false => format!(
                    "fastest to reach an error in {} (its own and that of the reference together; all finer settings \
                     reach it, too, and have converged by a factor of two):",
                    norm.words()
                ),
            })
            .finding()
            .table(self.fastest_table())
            .finding()
            .table(self.table())
            .words(format!(
                "scene {}; errors (--error {}) are {measure}; reference {}, good to {:.1e}; a period of the fastest \
                 motion is {period:.6e}.",
                scene.title(),
                norm.name(),
                reference.method,
                reference.error_estimate,
            ))
            .fact("stopped", reasons(&ended))
            .fact("left_out", reasons(&missing));
        let apart = apart.iter().filter(|(_, all)| !all.is_empty());
        apart
            .fold(report, |report, (what, all)| report.words(format!("{what}: {}.", all.join("; "))))
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
            .col("setting", Short, "kicks in a period of the fastest motion, or tolerance", |row| row.setting.clone())
            .col("step", Hidden, "", |row| row.step)
            .kind(Quantity::Time)
            .col("error", Power(1), "in the chosen norm (--error)", |row| row.error)
            .col("energy_error", Power(1), "", |row| row.energy_error)
            .col("wall_s", Power(2), "median wall time of a run, in seconds", |row| row.wall)
            .col("runs", Hidden, "runs whose median it is", |row| row.repeats)
            .col("force_evaluations", Short, "", |row| row.stats.force_evaluations)
            .head("forces")
            .col("steps", Hidden, "", |row| row.stats.steps)
            .col("rejected", Hidden, "", |row| row.stats.rejected)
            .col("below_reference", Short, below, |row| row.below_reference)
            .head("below")
            .col("failure", Hidden, "", |row| row.failure.clone())
            .col("step_cost", Fixed(1), "wall time of a step, in steps of plain Verlet", |row| self.step_cost(row))
            .head("cost")
            .col("order", Hidden, "of the method through contacts, by theory", |row| self.order(&row.candidate))
            .done()
    }

    /// For each of a few errors, the fastest method and the fastest plain loop.
    fn winners(&self) -> Vec<(f64, Fastest<'_>, Option<Fastest<'_>>)> {
        let errors = (1..=14).map(|digits| 10f64.powi(-digits));
        errors.filter_map(|error| Some((error, self.fastest(error, false)?, self.fastest(error, true)))).collect()
    }

    fn fastest_table(&self) -> Table {
        let wall = "seconds to this error, between settings on a straight line in log error and log time";
        Table::of("fastest", &self.winners())
            .key("fastest")
            .col("error", Power(0), "", |row| row.0)
            .col("integrator", Short, "", |row| row.1.0.candidate.name())
            .col("setting", Short, "the coarsest that reaches it", |row| row.1.0.setting.clone())
            .col("wall_s", Power(2), wall, |row| row.1.1)
            .col("plain_loop", Short, "fastest plain loop", |row| row.2.map(|plain| plain.0.candidate.name()))
            .col("plain_wall_s", Power(2), "its time", |row| row.2.map(|plain| plain.1))
            .col("ratio", Fixed(1), "of the two times", |row| row.2.map(|plain| plain.1 / row.1.1))
            .done()
    }

    fn picture(&self) -> WorkPrecision {
        // All methods there are would hide each other: those of the selection, and the fastest.
        let all = self.candidates();
        let chosen = Method::default_comparison_set();
        let fastest: Vec<Candidate> = self.winners().into_iter().map(|(_, (row, _), _)| row.candidate).collect();
        let drawn = |candidate: &Candidate| match candidate {
            Candidate::Method(method) => {
                all.len() <= chosen.len() + 2 || chosen.contains(method) || fastest.contains(candidate)
            }
            Candidate::Plain(_) => true,
        };
        let (drawn, hidden): (Vec<_>, Vec<_>) = all.iter().copied().partition(drawn);
        let curve = |candidate: &Candidate| {
            let points = self.rows_of(candidate).into_iter().filter_map(|row| {
                Some(Point { work: row.wall?, error: row.error?, below_reference: row.below_reference })
            });
            Curve {
                name: candidate.name(),
                note: self.order(candidate).map_or(String::new(), |order| format!(", order {order}")),
                group: match candidate {
                    Candidate::Method(method) => method.info().family.to_owned(),
                    Candidate::Plain(_) => "plain loops".to_owned(),
                },
                points: undominated(points.collect()),
            }
        };
        let hidden: Vec<String> = hidden.iter().map(Candidate::name).collect();
        let how = format!(
            "t = {}{}. Reference: {}, good to {:.1e} (grey line); hollow points are too near to it to be trusted. Not drawn: \
             {}settings that take longer than one of the same method with a smaller error. Orders are those of theory \
             {}. {}",
            format_short(self.scene.in_file(Quantity::Time, self.scene.end())),
            if self.scene.units().is_some() { " s" } else { "" },
            self.reference.method,
            self.reference.error_estimate,
            if hidden.is_empty() { String::new() } else { format!("{}; ", hidden.join(", ")) },
            if self.opens { "through contacts" } else { "for smooth forces" },
            timed(),
        );
        WorkPrecision {
            title: format!("{}: error against run time", self.scene.name()),
            work_label: "wall time (s), median of runs".to_owned(),
            error_label: match self.norm {
                ErrorNorm::Energy => "largest |E − E(0)| / |E(0)|".to_owned(),
                norm => format!("relative error of {}", norm.words()),
            },
            curves: drawn.iter().map(curve).collect(),
            floor: Some(self.reference.error_estimate),
            caption: scene_caption(&self.scene, &how),
        }
    }
}

/// Reasons, each after the names that it is for.
fn grouped(all: impl IntoIterator<Item = (String, String)>) -> Vec<String> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for (name, why) in all {
        match groups.iter_mut().find(|(known, _)| *known == why) {
            Some((_, names)) => names.push(name),
            None => groups.push((why, vec![name])),
        }
    }
    groups.into_iter().map(|(why, names)| format!("{}: {why}", names.join(", "))).collect()
}

/// The points of a method without those that another beats in error and in work, coarse to fine.
fn undominated(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.work.total_cmp(&b.work));
    let mut least = f64::INFINITY;
    points.retain(|point| {
        let better = point.error < least;
        least = least.min(point.error);
        better
    });
    points
}
