//! The report of a plan: text, JSON, an archive and a picture.

use super::{NumberColumn, Plan, PlanStudy, file::in_json};
use crate::{
    error::Result,
    number::counted,
    output::{Array, npz, to_json},
    report::{CellMap, Figure, Kind, Line, Maps, Matrix, Panel, Panels, Report, SpaceTime, fields, text::table},
    study::format_short,
};
use serde_json::{Value, json};

/// Lines of the printed table.
const LINES: usize = 40;
/// Most numbers of the printed JSON; those of a larger grid are in the files.
const MOST_PRINTED: usize = 1_000_000;
/// Most rows and columns of a map whose cells have their numbers in them.
const NOTED: usize = 12;
/// Most rows and columns of a map that have names.
const NAMED: usize = 40;

impl PlanStudy {
    /// The report: the numbers column by column, the numbers of computed and resumed points, and
    /// the wall time. Files have the same bytes whether points were resumed or not, and for any
    /// number of cores and shards.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn report(&self) -> Result<Report> {
        let points = self.plan.points();
        let computed = points - self.resumed - self.missing;
        let shape = |column: &NumberColumn| match column.width {
            1 => vec![points as u64],
            width => vec![points as u64, width as u64],
        };
        let arrays =
            self.columns.iter().map(|one| Array { name: &one.name, shape: shape(one), values: one.numbers.clone() });
        let report = self.facts();
        let json = to_json(&report.json());
        let report = report
            .file("sweep.json", json.into_bytes())
            .file("sweep.npz", npz(&arrays.collect::<Vec<_>>())?)
            .fact("computed", computed)
            .fact("resumed", self.resumed)
            .fact("wall_s", self.wall.as_secs_f64())
            .lines(self.text(computed))
            .failure((self.failures == points).then(|| "no point has a result".to_owned()))
            .remark(
                (self.missing > 0)
                    .then(|| format!("stopped by a signal: {} points of {points} were not run", self.missing)),
            );
        Ok(match self.picture() {
            Some(picture) => report.picture(picture),
            None => report,
        })
    }

    fn facts(&self) -> Report {
        let numbers: usize = self.columns.iter().map(|column| column.numbers.len()).sum();
        let column = |column: &NumberColumn| match column.width {
            1 => json!(column.numbers),
            width => column.numbers.chunks(width).map(|row| json!(row)).collect(),
        };
        let columns = self.columns.iter().map(|one| (one.name.clone(), column(one))).collect();
        let axis = |axis: &super::Axis| json!({"keys": axis.keys, "places": axis.values.len()});
        let failed = |(k, why): &(usize, String)| json!({"row": k, "point": self.plan.point(*k), "failure": why});
        Report::new("sweep")
            .facts(fields!(self.plan => name, points()))
            .fact("axes", self.plan.axes.iter().map(axis).collect::<Vec<_>>())
            .fact("keep", self.plan.keep.iter().map(|kept| &kept.name).collect::<Vec<_>>())
            .fact("columns", if numbers > MOST_PRINTED { Value::Null } else { Value::Object(columns) })
            .fact("failures", self.failures)
            .fact("failed", self.failed.iter().map(failed).collect::<Vec<_>>())
            .facts(fields!(self => missing; self.plan => settings()))
            .warnings(self.plan.doubts.clone())
    }

    fn text(&self, computed: usize) -> String {
        let points = self.plan.points();
        let head: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let rows: Vec<Vec<String>> = (0..points.min(LINES)).map(|k| self.line(k)).collect();
        let mut text = format!("{}\n\n{}", self.plan.name, table(&head, &rows));
        if points > LINES {
            text += &format!("and {} points more; --out writes all\n", points - LINES);
        }
        for (k, why) in &self.failed {
            text += &format!("{}: {why}\n", words(&self.plan, *k));
        }
        text + &format!(
            "\n{}: {computed} computed, {} resumed, {} failed, {:.1} s\n",
            counted(points, "point"),
            self.resumed,
            self.failures,
            self.wall.as_secs_f64()
        )
    }

    /// The cells of a point.
    fn line(&self, k: usize) -> Vec<String> {
        let keys = self.plan.point(k).0.into_iter().map(|(_, value)| plain(&in_json(&value)));
        let cell = |column: &NumberColumn| match (column.width, column.numbers[k * column.width]) {
            (width, _) if column.numbers[k * width..][..width].iter().all(|x| x.is_nan()) => "–".to_owned(),
            (1, number) if number.fract() == 0.0 && number.abs() < 1e9 => number.to_string(),
            (1, number) => format!("{number:.6e}"),
            (width, _) => format!("{width} numbers"),
        };
        let keyed = self.plan.keys().count();
        keys.chain(self.columns[keyed..].iter().map(cell)).collect()
    }
}

/// A value of a key without quotation marks.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => format_short(number.as_f64().unwrap_or(f64::NAN)),
        value => value.to_string(),
    }
}

/// The keys of a point with their values.
fn words(plan: &Plan, k: usize) -> String {
    let parts = plan.point(k).0.into_iter().map(|(key, value)| format!("{key} = {}", plain(&in_json(&value))));
    parts.collect::<Vec<_>>().join(", ")
}

impl PlanStudy {
    /// The picture, if the plan has one or two axes and shows a number: of one axis a line, of two
    /// a map; where its numbers are not positive, or an axis has words, cells with names.
    fn picture(&self) -> Option<Figure> {
        let column = &self.columns[self.plan.keys().count() + self.plan.picture];
        let finite = column.numbers.iter().any(|number| number.is_finite());
        match self.plan.axes.len() {
            _ if column.width != 1 || !finite => None,
            1 => Some(self.curve(column)),
            2 => Some(self.map(column)),
            _ => None,
        }
    }

    /// The numbers on an axis, if they are numbers.
    fn numbers(&self, axis: usize) -> Option<Vec<f64>> {
        self.plan.axes[axis].values.iter().map(|row| in_json(&row[0]).as_f64()).collect()
    }

    fn names(&self, axis: usize) -> Vec<String> {
        self.plan.axes[axis].values.iter().map(|row| plain(&in_json(&row[0]))).collect()
    }

    fn label(&self, axis: usize) -> String {
        self.plan.axes[axis].keys.join(", ")
    }

    fn caption(&self) -> String {
        let settings = self.plan.settings();
        let scene = settings["scene"]["name"].as_str().unwrap_or("of the plan");
        let changes = plain(&settings["set"]);
        if changes == "[]" { format!("Scene {scene}.") } else { format!("Scene {scene}, changed by {changes}.") }
    }

    fn curve(&self, column: &NumberColumn) -> Figure {
        let values = &column.numbers;
        let x = self.numbers(0).unwrap_or_else(|| (0..values.len()).map(|k| k as f64).collect());
        let positive = x.iter().chain(values).all(|number| *number > 0.0);
        let kind = if positive { Kind::LogLog } else { Kind::Parameter };
        let lines = vec![Line::new(&column.name, x.into_iter().zip(values.iter().copied()))];
        let panel = Panel::new(kind, [&self.label(0), &column.name], lines);
        Panels::column(&self.plan.name, vec![panel], self.caption()).into()
    }

    fn map(&self, column: &NumberColumn) -> Figure {
        let (rows, columns) = (self.plan.axes[0].values.len(), self.plan.axes[1].values.len());
        let few = |most: usize| rows <= most && columns <= most;
        let note = |value: &f64| if few(NOTED) && value.is_finite() { format_short(*value) } else { String::new() };
        let ascending = |axis: &Vec<f64>| axis[0] > 0.0 && axis.windows(2).all(|two| two[0] < two[1]);
        let [y, x] = [0, 1].map(|axis| self.numbers(axis).filter(ascending));
        let (title, caption) = (self.plan.name.clone(), self.caption());
        let (name, values) = (column.name.clone(), column.numbers.clone());
        let notes = || values.iter().map(note).collect();
        let all_positive = values.iter().all(|value| value.is_nan() || *value > 0.0);
        if let (Some(x), Some(y), true) = (x, y, all_positive) {
            let labels = [self.label(1), self.label(0), name];
            let map = CellMap { labels, x, y, notes: notes(), values, ..CellMap::default() };
            return Maps { title, maps: vec![map], caption }.into();
        }
        if few(NAMED) && all_positive {
            let (rows, columns) = (self.names(0), self.names(1));
            let labels = [format!("{} (rows: {})", self.label(1), self.label(0)), name];
            return Matrix { title, rows, columns, labels, notes: notes(), values, caption }.into();
        }
        let nth = |axis: usize| format!("{}, index of the value", self.label(axis));
        let signed = values.iter().any(|value| *value < 0.0);
        SpaceTime {
            title,
            site_label: nth(1),
            time_label: nth(0),
            value_label: name,
            values,
            sites: columns,
            first_site: 1.0,
            times: (1.0, rows as f64),
            most: None,
            signed,
            caption,
        }
        .into()
    }
}
