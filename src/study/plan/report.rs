//! The outcome of a plan as text, JSON, an archive and a picture.

use super::{NumberColumn, Plan, PlanStudy, file::in_json};
use crate::{
    error::Result,
    output::{Array, npz},
    present::table,
    study::{File, Report, named, shown},
};
use serde_json::{Value, json};

/// Lines of the printed table.
const LINES: usize = 40;
/// Most numbers of the printed JSON; those of a larger grid are in the files.
const MOST_PRINTED: usize = 1_000_000;

/// The template, which is printed as it is.
pub(super) struct Template;

impl Report for Template {
    fn json(&self) -> Value {
        json!({"template": Plan::TEMPLATE})
    }

    fn text(&self) -> String {
        Plan::TEMPLATE.to_owned()
    }

    fn files(&self, _: &str) -> Result<Vec<File>> {
        Ok(named([("plan.toml", Plan::TEMPLATE.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(Vec::new())
    }
}

impl Report for PlanStudy {
    /// The results with the numbers column by column, the numbers of computed and resumed points,
    /// and the wall time.
    fn json(&self) -> Value {
        let mut value = self.value();
        value["computed"] = json!(self.plan.points() - self.resumed - self.missing);
        value["resumed"] = json!(self.resumed);
        value["wall_s"] = json!(self.wall.as_secs_f64());
        value
    }

    fn text(&self) -> String {
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
            "\n{points} points: {} computed, {} resumed, {} failed, {:.1} s\n",
            points - self.resumed - self.missing,
            self.resumed,
            self.failures,
            self.wall.as_secs_f64()
        )
    }

    /// The same bytes whether points were resumed or not, and for any number of cores and shards.
    fn files(&self, _: &str) -> Result<Vec<File>> {
        let points = self.plan.points() as u64;
        let shape = |column: &NumberColumn| match column.width {
            1 => vec![points],
            width => vec![points, width as u64],
        };
        let json = crate::output::to_json(&self.value());
        let arrays =
            self.columns.iter().map(|one| Array { name: &one.name, shape: shape(one), values: one.numbers.clone() });
        Ok(named([("sweep.json", json.into()), ("sweep.npz", npz(&arrays.collect::<Vec<_>>())?)]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        let picture = picture::of(self)?;
        Ok(picture.map(|picture| ("sweep.png".to_owned(), picture)).into_iter().collect())
    }

    fn remark(&self) -> Option<String> {
        (self.missing > 0)
            .then(|| format!("stopped by a signal: {} points of {} were not run", self.missing, self.plan.points()))
    }
}

impl PlanStudy {
    fn value(&self) -> Value {
        let numbers: usize = self.columns.iter().map(|column| column.numbers.len()).sum();
        let column = |column: &NumberColumn| match column.width {
            1 => json!(column.numbers),
            width => column.numbers.chunks(width).map(|row| json!(row)).collect(),
        };
        let columns = self.columns.iter().map(|one| (one.name.clone(), column(one))).collect();
        let axis = |axis: &super::Axis| json!({"keys": axis.keys, "places": axis.values.len()});
        let failed = |(k, why): &(usize, String)| json!({"point": self.plan.point(*k), "failure": why});
        json!({
            "name": self.plan.name,
            "points": self.plan.points(),
            "axes": self.plan.axes.iter().map(axis).collect::<Vec<_>>(),
            "keep": self.plan.keep.iter().map(|kept| &kept.name).collect::<Vec<_>>(),
            "columns": if numbers > MOST_PRINTED { Value::Null } else { Value::Object(columns) },
            "failures": self.failures,
            "failed": self.failed.iter().map(failed).collect::<Vec<_>>(),
            "missing": self.missing,
            "settings": self.plan.settings(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// The cells of a point.
    fn line(&self, k: usize) -> Vec<String> {
        let keys = self.plan.point(k).0.into_iter().map(|(_, value)| plain(&in_json(&value)));
        let cell = |column: &NumberColumn| match (column.width, column.numbers[k * column.width]) {
            (1, number) if number.is_nan() => "–".to_owned(),
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
        Value::Number(number) if number.is_f64() => shown(number.as_f64().unwrap_or(f64::NAN)),
        value => value.to_string(),
    }
}

/// The keys of a point with their values.
fn words(plan: &Plan, k: usize) -> String {
    let parts = plan.point(k).0.into_iter().map(|(key, value)| format!("{key} = {}", plain(&in_json(&value))));
    parts.collect::<Vec<_>>().join(", ")
}

#[cfg(feature = "plot")]
mod picture {
    //! One axis: a line. Two axes: a map; where its numbers are not positive, or an axis has words,
    //! cells with names.

    use super::{PlanStudy, Value, in_json, plain, shown};
    use crate::{
        error::Result,
        figures::{CellMap, Kind, Line, Maps, Matrix, Panel, Panels, SpaceTime, maps, matrix, panels, space_time},
    };

    /// Most rows and columns whose cells have their numbers in them.
    const NOTED: usize = 12;
    /// Most rows and columns with names.
    const NAMED: usize = 40;

    /// The picture, if the plan has one or two axes and shows a number.
    pub(super) fn of(study: &PlanStudy) -> Result<Option<crate::figures::Picture>> {
        let column = &study.columns[study.plan.keys().count() + study.plan.picture];
        let finite = column.numbers.iter().any(|number| number.is_finite());
        if column.width != 1 || !finite {
            return Ok(None);
        }
        match study.plan.axes.len() {
            1 => line(study, &column.name, &column.numbers).map(Some),
            2 => map(study, &column.name, &column.numbers).map(Some),
            _ => Ok(None),
        }
    }

    /// The numbers on an axis, if they are numbers.
    fn numbers(study: &PlanStudy, axis: usize) -> Option<Vec<f64>> {
        study.plan.axes[axis].values.iter().map(|row| in_json(&row[0]).as_f64()).collect()
    }

    fn names(study: &PlanStudy, axis: usize) -> Vec<String> {
        study.plan.axes[axis].values.iter().map(|row| plain(&in_json(&row[0]))).collect()
    }

    fn label(study: &PlanStudy, axis: usize) -> String {
        study.plan.axes[axis].keys.join(", ")
    }

    fn caption(study: &PlanStudy) -> String {
        let of = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let settings = study.plan.settings();
        let scene = settings["scene"]["name"].as_str().unwrap_or("of the plan").to_owned();
        format!("Scene {scene}, changed by {}. hertzchain {}.", of(&settings["set"]), env!("CARGO_PKG_VERSION"))
    }

    fn line(study: &PlanStudy, name: &str, values: &[f64]) -> Result<crate::figures::Picture> {
        let x = numbers(study, 0).unwrap_or_else(|| (0..values.len()).map(|k| k as f64).collect());
        let positive = x.iter().chain(values).all(|number| *number > 0.0);
        let kind = if positive { Kind::LogLog } else { Kind::Parameter };
        let (key, lines) = (label(study, 0), vec![Line::new(name, x.into_iter().zip(values.iter().copied()))]);
        let panel = Panel::new(kind, [&key, name], lines);
        Ok(panels(&Panels::column(study.plan.name.clone(), vec![panel], caption(study)))?)
    }

    fn map(study: &PlanStudy, name: &str, values: &[f64]) -> Result<crate::figures::Picture> {
        let (rows, columns) = (study.plan.axes[0].values.len(), study.plan.axes[1].values.len());
        let few = |most: usize| rows <= most && columns <= most;
        let note = |value: &f64| if few(NOTED) && value.is_finite() { shown(*value) } else { String::new() };
        let ascending = |axis: &Vec<f64>| axis[0] > 0.0 && axis.windows(2).all(|two| two[0] < two[1]);
        let [y, x] = [0, 1].map(|axis| numbers(study, axis).filter(ascending));
        let all_positive = values.iter().all(|value| value.is_nan() || *value > 0.0);
        let (title, caption) = (study.plan.name.clone(), caption(study));
        if let (Some(x), Some(y), true) = (x, y, all_positive) {
            let labels = [label(study, 1), label(study, 0), name.to_owned()];
            let (values, notes) = (values.to_vec(), values.iter().map(note).collect());
            let map = CellMap { labels, x, y, values, notes, ..CellMap::default() };
            return Ok(maps(&Maps { title, maps: vec![map], caption })?);
        }
        if few(NAMED) && all_positive {
            let (rows, columns) = (names(study, 0), names(study, 1));
            let (values, notes) = (values.to_vec(), values.iter().map(note).collect());
            let labels = [format!("{} (rows: {})", label(study, 1), label(study, 0)), name.to_owned()];
            return Ok(matrix(&Matrix { title, rows, columns, labels, values, notes, caption })?);
        }
        let nth = |axis: usize| format!("{}, index of the value", label(study, axis));
        Ok(space_time(&SpaceTime {
            title,
            site_label: nth(1),
            time_label: nth(0),
            value_label: name.to_owned(),
            values: values.to_vec(),
            sites: columns,
            first_site: 1.0,
            times: (1.0, rows as f64),
            most: None,
            signed: values.iter().any(|value| *value < 0.0),
            caption,
        })?)
    }
}
