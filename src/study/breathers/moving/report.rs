//! The report of moving breathers.

use super::{MovingPoint, MovingStudy, Passage};
use crate::{
    chain::Params,
    number::format_short,
    numerics::{extremes, largest_by, least_by},
    report::{Column, Fixed, Hidden, Json, Kind, Line, Panel, Panels, Power, Report, Short, Table},
    study::params_words,
};
use serde_json::{Value, json};
use std::f64::consts::PI;

impl MovingStudy {
    /// Velocities of the kicked run in the second, third and fourth quarter.
    fn quarters(&self) -> Option<[f64; 3]> {
        let kicked = self.kicked.as_ref()?;
        let end = *kicked.times.last()?;
        Some([1.0, 2.0, 3.0].map(|k| kicked.mean_velocity(0.25 * k * end, 0.25 * (k + 1.0) * end)))
    }

    fn words(&self) -> String {
        let least = least_by(&self.points, |point| point.envelope.tail);
        let tail = least.map_or(String::new(), |point| {
            let (breather, tail) = (&point.orbit.setting, 100.0 * point.envelope.tail);
            format!("The smallest tail is {tail:.2} % of the background, at v = {:.5}.", breather.velocity())
        });
        let passages = self.kicked.iter().flat_map(|run| &run.passages).filter_map(|one| one.velocity);
        let kicked = match passages.collect::<Vec<_>>()[..] {
            [first, .., last] => {
                format!(" The kicked breather passes bonds with velocities from {first:.5} to {last:.5}.")
            }
            _ => String::new(),
        };
        let apart = self.apart().map_or(String::new(), |apart| {
            format!(" Its amplitude at the kink differs from that of the moving breather of its velocity by at most {apart:.3}.")
        });
        tail + &kicked + &apart
    }

    /// The report.
    pub fn report(&self) -> Report {
        let options = &self.options;
        let passages = self.kicked.as_ref().map(|run| {
            let family = |one: &Passage| (*one, one.velocity.and_then(|velocity| self.depth(velocity)));
            passages(&run.passages.iter().map(family).collect::<Vec<_>>())
        });
        let kicked = self.kicked.as_ref().zip(passages.as_ref()).map(|(run, passages)| {
            json!({
                "omega_b": run.omega_b,
                "kick": options.kick,
                "t": run.times,
                "position": run.position,
                "passages": passages.json(),
                "velocities": self.quarters(),
                "depth_apart": self.apart(),
            })
        });
        let missing = |(omega_b, turns, why): &(f64, u32, String)| -> Value {
            json!({ "omega_b": omega_b, "turns": turns, "reason": why })
        };
        let lost: Vec<String> = self
            .missing
            .iter()
            .map(|(omega_b, turns, _)| format!("{} with {turns} turns", format_short(*omega_b)))
            .collect();
        let title = "Moving dark breathers".to_owned();
        let report = Report::new("moving")
            .facts(Params::from(options.params))
            .fact("sites", options.sites)
            .words(self.caption())
            .table(points(&self.points))
            .table(envelopes(&self.points))
            .fact("missing", self.missing.iter().map(missing).collect::<Vec<_>>())
            .fact("kicked", kicked)
            .fact("tol", options.tol)
            .picture(Panels { title, columns: self.columns(), caption: self.caption() })
            .failure(
                (!lost.is_empty()).then(|| format!("no moving breather was found at omega_b = {}", lost.join(", "))),
            );
        passages.into_iter().fold(report, Report::table)
    }

    /// What the picture shows, with all numbers.
    fn caption(&self) -> String {
        let residual = self.points.iter().map(|point| point.orbit.residual).fold(0.0, f64::max);
        let span = |of: fn(&MovingPoint) -> f64| match extremes(self.points.iter().map(of)) {
            (least, most) if least < most => format!("{} to {}", format_short(least), format_short(most)),
            (one, _) => format_short(one),
        };
        format!(
            "{}, N = {}, ω_b = {}: {} moving breathers, a site in {} periods, largest residual {residual:.0e}. {}",
            params_words(self.options.params.into()),
            self.options.sites,
            span(|point| point.orbit.setting.omega_b),
            self.points.len(),
            span(|point| f64::from(point.orbit.setting.turns) + 0.5),
            self.words()
        )
    }

    /// Local amplitudes of the slowest and of the fastest breather; tails and depths over
    /// velocities, a line for each frequency, or over frequencies where all have the same turns.
    fn columns(&self) -> Vec<Column> {
        let middle = (self.options.sites / 2) as f64;
        let velocity = |point: &MovingPoint| point.orbit.setting.velocity();
        let ends = [least_by(&self.points, |one| velocity(one)), largest_by(&self.points, |one| velocity(one))];
        let profile = |of: &dyn Fn(&MovingPoint, usize) -> f64| -> Vec<Line> {
            let line = |point: &MovingPoint| {
                let values = (0..self.options.sites).map(|i| (i as f64 - middle, of(point, i)));
                Line::new(&format!("v = {:.5}", velocity(point)), values)
            };
            ends.into_iter().flatten().map(line).collect()
        };
        let amplitudes = profile(&|point, i| point.envelope.amplitude[i] / point.envelope.background);
        let phases = profile(&|point, i| point.envelope.phase[i] / PI);
        let one = self.options.turns.len() == 1;
        let same = |a: &MovingPoint, b: &MovingPoint| one || a.orbit.setting.omega_b == b.orbit.setting.omega_b;
        let several = one || self.points.chunk_by(same).count() > 1;
        let families = |what: &str, of: &dyn Fn(&MovingPoint) -> f64| -> Vec<Line> {
            let line = |points: &[MovingPoint]| {
                let first = &points[0].orbit.setting;
                let name = match several {
                    false => what.to_owned(),
                    _ if one => format!("{what}, {} turns", first.turns),
                    _ => format!("{what}, ω_b = {}", format_short(first.omega_b)),
                };
                let place = |point: &MovingPoint| if one { point.orbit.setting.omega_b } else { velocity(point) };
                let mut family: Vec<(f64, f64)> = points.iter().map(|point| (place(point), of(point))).collect();
                family.sort_by(|a, b| a.0.total_cmp(&b.0));
                Line::new(&name, family)
            };
            self.points.chunk_by(same).map(line).collect()
        };
        let mut depths = families("exact", &|point| point.envelope.depth);
        if let (Some(run), false) = (&self.kicked, one) {
            let passages = run.passages.iter().filter_map(|one| Some((one.velocity?, one.depth)));
            depths.push(Line::new("kicked", passages));
        }
        let mut waves = families("tail", &|point| point.tail.wave_number / PI);
        let resonant = families("resonant", &|point| point.resonant_wave() / PI);
        waves.extend(resonant.into_iter().map(|line| Line { law: true, ..line }));
        let tails = families("exact", &|point| point.envelope.tail);
        let over = if one { "ω_b" } else { "velocity, sites per unit of time" };
        vec![
            Column::new(
                "",
                [
                    Panel::new(Kind::Sites, ["site n", "amplitude / background"], amplitudes),
                    Panel::new(Kind::Sites, ["site n", "phase / π"], phases),
                    Panel::new(Kind::Parameter, [over, "wave number of the tail / π"], waves),
                ],
            ),
            Column::new(
                "",
                [
                    Panel::new(Kind::LogParameter, [over, "tail / background"], tails),
                    Panel::new(Kind::Parameter, [over, "amplitude at the kink / background"], depths),
                    Panel::new(
                        Kind::Parameter,
                        [over, "E − ωJ − vP of the kink"],
                        families("exact", &|point| point.energy.free),
                    ),
                ],
            ),
        ]
    }
}

pub(super) fn points(points: &[MovingPoint]) -> Table {
    Table::of("moving", points)
        .key("points")
        .col("omega_b", Fixed(6), "frequency of the background", |point| point.orbit.setting.omega_b)
        .col("turns", Short, "its whole periods for a site that the kink moves on", |point| {
            u64::from(point.orbit.setting.turns)
        })
        .col("passage", Hidden, "time for a site", |point| point.orbit.setting.passage())
        .col("velocity", Fixed(6), "in sites per unit of time", |point| point.orbit.setting.velocity())
        .col("residual", Power(1), "of the equations of the orbit", |point| point.orbit.residual)
        .col("return_error", Power(1), "distance from the orbit after a passage", |point| point.return_error)
        .head("return")
        .col("background", Fixed(6), "amplitude of the background", |point| point.envelope.background)
        .col("depth", Fixed(5), "local amplitude at the kink, in its units", |point| point.envelope.depth)
        .col("tail", Fixed(5), "range of the local amplitude far from the kink, in its units", |point| {
            point.envelope.tail
        })
        .col("max_modulus", Fixed(6), "largest modulus of a multiplier", |point| point.spectrum.largest())
        .col("real", Hidden, "largest real multiplier; 1 if none is above 1", |point| point.spectrum.largest_real())
        .col("growth", Power(2), "of the largest multiplier, per unit of time", MovingPoint::growth)
        .col("twist", Hidden, "change of the phase along the ring", |point| point.tail.twist)
        .col("tail_wave", Fixed(3), "wave number of the tail", |point| point.tail.wave_number)
        .col("tail_share", Hidden, "share of the tail that this wave explains", |point| point.tail.share)
        .col("tail_amplitude", Hidden, "amplitude of this wave", |point| point.tail.amplitude)
        .col(
            "resonant_wave",
            Fixed(3),
            "that of the modulation of the background which keeps its phase in the frame of the kink",
            MovingPoint::resonant_wave,
        )
        .col("energy", Power(3), "E of the kink", |point| point.energy.energy)
        .col("free_energy", Power(4), "its E - omega J - v P", |point| point.energy.free)
        .col("quality", Json, "", |point| json!(point.spectrum.quality))
        .col("newton", Json, "", |point| json!(point.orbit.newton))
        .col("resonant", Json, "", |point| json!(point.resonant))
        .done()
}

/// A row for each site of each breather.
pub(super) fn envelopes(points: &[MovingPoint]) -> Table {
    let sites = |point: &MovingPoint| {
        let (breather, envelope) = (point.orbit.setting, &point.envelope);
        let row = |i: usize| {
            let n = i as f64 - (breather.sites / 2) as f64;
            (breather.omega_b, breather.turns, n, [envelope.amplitude[i], envelope.phase[i], envelope.mean[i]])
        };
        (0..breather.sites).map(row).collect::<Vec<_>>()
    };
    Table::of("envelope", &points.iter().flat_map(sites).collect::<Vec<_>>())
        .key("")
        .col("omega_b", Hidden, "", |row| row.0)
        .col("turns", Hidden, "", |row| u64::from(row.1))
        .col("n", Hidden, "site", |row| row.2)
        .col("amplitude", Hidden, "local amplitude", |row| row.3[0])
        .col("phase", Hidden, "its phase", |row| row.3[1])
        .col("mean", Hidden, "mean strain", |row| row.3[2])
        .done()
}

/// A row for each bond that the kicked breather passes, with the depth that belongs to its
/// velocity.
pub(super) fn passages(rows: &[(Passage, Option<f64>)]) -> Table {
    Table::of("passages", rows)
        .key("")
        .col("t", Hidden, "time of the passage of the kicked breather", |row| row.0.t)
        .col("bond", Hidden, "bond that its kink passes", |row| row.0.bond as f64)
        .col("velocity", Hidden, "", |row| row.0.velocity)
        .col("depth", Hidden, "", |row| row.0.depth)
        .col("depth_of_moving", Hidden, "depth of the moving breather of this velocity", |row| row.1)
        .done()
}
