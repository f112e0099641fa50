//! The report of a plan: text, JSON, an archive and a picture.

use super::{NumberColumn, Plan, PlanStudy, file::in_json};
use crate::{
    error::Result,
    number::counted,
    output::{Array, npz, to_json},
    report::{
        CellMap, Figure, Kind, Line, Matrix, Panel, Panels, Power, Report, Short, SpaceTime, Table, fields, text::table,
    },
    study::{format_short, scene_caption},
};
use serde_json::{Value, json};

/// Lines of the printed table.
const LINES: usize = 40;
/// Most letters of a line of a printed table with heads of one line.
const WIDE: usize = 80;
/// Most numbers of the printed JSON; those of a larger grid are in the files.
const MOST_PRINTED: usize = 1_000_000;
/// Most rows and columns of a map whose cells have their numbers in them.
const NOTED: usize = 12;
/// Most rows and columns of a map that have names.
const NAMED: usize = 40;
/// Most distributions in one picture, and in all.
const CURVES: usize = 8;
const SPREADS: usize = 10_000;
/// Shares of the seeds below which the numbers of a table and of a picture lie.
const SHARES: [(&str, &str, f64); 5] = [
    ("least", "least", 0.0),
    ("quartile_1", "25 %", 0.25),
    ("median", "median", 0.5),
    ("quartile_3", "75 %", 0.75),
    ("largest", "largest", 1.0),
];

/// A quantity at all seeds, the other keys being those of one point.
struct Spread<'a> {
    point: usize,
    quantity: &'a NumberColumn,
    /// The numbers there are, in ascending order.
    numbers: Vec<f64>,
}

impl Spread<'_> {
    /// The number below which a share of the numbers lies, between two of them on a straight line.
    fn at(&self, share: f64) -> f64 {
        let place = share * self.numbers.len().saturating_sub(1) as f64;
        let of = |place: f64| self.numbers.get(place as usize).copied().unwrap_or(f64::NAN);
        of(place.floor()) + place.fract() * (of(place.ceil()) - of(place.floor()))
    }
}

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
        let report = Report::new("sweep").lines(format!("{}\n", self.plan.name));
        let report = if self.seeds().is_some() { report.table(self.spread_table()) } else { report };
        report
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
        let mut text = if self.seeds().is_some() { String::new() } else { table(&head, &rows, 2) };
        if text.lines().any(|line| line.chars().count() > WIDE) {
            // Heads of several lines, so that columns are as wide as their numbers.
            let broken = |name: &&str| {
                let (name, place) =
                    name.split_once('[').map_or((*name, String::new()), |(a, b)| (a, format!("\n[{b}")));
                name.replace('.', ".\n") + &place
            };
            text = table(&head.iter().map(broken).collect::<Vec<_>>(), &rows, 2);
        }
        if points > LINES && !text.is_empty() {
            text += &format!("and {} points more; --out writes all\n", points - LINES);
        }
        for (k, why) in &self.failed {
            text += &format!("{}: {why}\n", words(&self.plan, *k, |key| Some(key.to_owned())));
        }
        let end = format!(
            "{}{}: {computed} computed, {} resumed, {} failed, {:.1} s\n",
            if text.is_empty() { "" } else { "\n" },
            counted(points, "point"),
            self.resumed,
            self.failures,
            self.wall.as_secs_f64()
        );
        text + &end
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

/// The keys of a point, or what `word` makes of them, with their values.
fn words(plan: &Plan, k: usize, word: impl Fn(&str) -> Option<String>) -> String {
    let said = |(key, value): (String, _)| Some(format!("{} = {}", word(&key)?, plain(&in_json(&value))));
    plan.point(k).0.into_iter().filter_map(said).collect::<Vec<_>>().join(", ")
}

impl PlanStudy {
    /// The axis of seeds, if there is one.
    fn seeds(&self) -> Option<usize> {
        let of_seeds = |axis: &super::Axis| matches!(&axis.keys[..], [key] if key == "seed" || key.ends_with(".seed"));
        let points = |axis: &super::Axis| self.plan.points() / axis.values.len();
        self.plan.axes.iter().position(|axis| of_seeds(axis) && axis.values.len() > 1 && points(axis) <= SPREADS)
    }

    /// Each quantity that is a number over the seeds, for each point of the other axes.
    fn spreads<'a>(&'a self) -> Vec<Spread<'a>> {
        let Some(seeds) = self.seeds() else { return Vec::new() };
        let count = self.plan.axes[seeds].values.len();
        let stride: usize = self.plan.axes[seeds + 1..].iter().map(|axis| axis.values.len()).product();
        let firsts = (0..self.plan.points()).filter(|k| (k / stride).is_multiple_of(count));
        let quantities = self.columns[self.plan.keys().count()..].iter().filter(|column| column.width == 1);
        let spread = |point: usize, quantity: &'a NumberColumn| {
            let all = (0..count).map(|seed| quantity.numbers[point + seed * stride]);
            let mut numbers: Vec<f64> = all.filter(|number| !number.is_nan()).collect();
            numbers.sort_by(f64::total_cmp);
            Spread { point, quantity, numbers }
        };
        firsts.flat_map(|point| quantities.clone().map(move |quantity| spread(point, quantity))).collect()
    }

    /// What a point says but for the seed, with these words for keys.
    fn others(&self, point: usize, word: impl Fn(&str) -> String) -> String {
        let seed = self.seeds().map(|axis| &*self.plan.axes[axis].keys[0]);
        words(&self.plan, point, |key| (Some(key) != seed).then(|| word(key)))
    }

    fn spread_table(&self) -> Table {
        let spreads = self.spreads();
        let mut table = Table::of("seeds", &spreads).key("seeds").in_text(0..LINES);
        if self.plan.axes.len() > 1 {
            table = table.col("point", Short, "", |row| self.others(row.point, str::to_owned));
        }
        table = table.col("quantity", Short, "", |row| row.quantity.name.clone());
        table = table.col("seeds", Short, "that have it", |row| row.numbers.len());
        for (name, head, share) in SHARES {
            table = table.col(name, Power(2), "", move |row| row.at(share)).head(head);
        }
        table.done()
    }

    /// How the quantity of the picture is distributed over the seeds, if the points without them
    /// are few.
    fn distribution(&self, column: &NumberColumn) -> Option<Figure> {
        let spreads: Vec<Spread<'_>> =
            self.spreads().into_iter().filter(|one| one.quantity.name == column.name).collect();
        let shares = |spread: &Spread<'_>| {
            let count = spread.numbers.len() as f64;
            let steps = spread.numbers.iter().enumerate();
            let steps = steps.flat_map(|(k, x)| [(*x, k as f64 / count), (*x, (k + 1) as f64 / count)]);
            Line::new(&self.others(spread.point, |key| self.plan.word(key).to_owned()), steps.collect::<Vec<_>>())
        };
        let labels = [self.plan.word(&column.name), "share of the seeds with this at most"];
        let panel = Panel::new(Kind::Parameter, labels, spreads.iter().map(shares).collect());
        let caption = format!("{} {} seeds.", self.caption(), self.plan.axes[self.seeds()?].values.len());
        (spreads.len() <= CURVES).then(|| Panels::column(&self.plan.name, vec![panel], caption).into())
    }

    /// The picture, if it shows a number: of seeds their distribution; else of one axis a line, of
    /// two a map; where its numbers are not positive, or an axis has words, cells with names.
    fn picture(&self) -> Option<Figure> {
        let column = &self.columns[self.plan.keys().count() + self.plan.picture];
        let finite = column.numbers.iter().any(|number| number.is_finite());
        if column.width != 1 || !finite {
            return None;
        }
        self.distribution(column).or_else(|| match self.plan.axes.len() {
            1 => Some(self.curve(column)),
            2 => Some(self.map(column)),
            _ => None,
        })
    }

    /// The numbers on an axis, if they are numbers.
    fn numbers(&self, axis: usize) -> Option<Vec<f64>> {
        self.plan.axes[axis].values.iter().map(|row| in_json(&row[0]).as_f64()).collect()
    }

    fn names(&self, axis: usize) -> Vec<String> {
        self.plan.axes[axis].values.iter().map(|row| plain(&in_json(&row[0]))).collect()
    }

    fn label(&self, axis: usize) -> String {
        self.plan.axes[axis].keys.iter().map(|key| self.plan.word(key)).collect::<Vec<_>>().join(", ")
    }

    fn caption(&self) -> String {
        let how = format!("These are the parameters of the first of {}.", counted(self.plan.points(), "point"));
        self.plan.scene(&self.plan.point(0)).map_or(how.clone(), |scene| scene_caption(&scene, &how))
    }

    fn curve(&self, column: &NumberColumn) -> Figure {
        let values = &column.numbers;
        let x = self.numbers(0).unwrap_or_else(|| (0..values.len()).map(|k| k as f64).collect());
        let positive = x.iter().chain(values).all(|number| *number > 0.0);
        let kind = if positive { Kind::LogLog } else { Kind::Parameter };
        let name = self.plan.word(&column.name);
        let lines = vec![Line::new(name, x.into_iter().zip(values.iter().copied()))];
        let panel = Panel::new(kind, [&self.label(0), name], lines);
        Panels::column(&self.plan.name, vec![panel], self.caption()).into()
    }

    fn map(&self, column: &NumberColumn) -> Figure {
        let (rows, columns) = (self.plan.axes[0].values.len(), self.plan.axes[1].values.len());
        let few = |most: usize| rows <= most && columns <= most;
        let note = |value: &f64| if few(NOTED) && value.is_finite() { format_short(*value) } else { String::new() };
        let ascending = |axis: &Vec<f64>| axis[0] > 0.0 && axis.windows(2).all(|two| two[0] < two[1]);
        let [y, x] = [0, 1].map(|axis| self.numbers(axis).filter(ascending));
        let (title, caption) = (self.plan.name.clone(), self.caption());
        let (name, values) = (self.plan.word(&column.name).to_owned(), column.numbers.clone());
        let notes = || values.iter().map(note).collect();
        let all_positive = values.iter().all(|value| value.is_nan() || *value > 0.0);
        if let (Some(x), Some(y), true) = (x, y, all_positive) {
            let labels = [self.label(1), self.label(0), name];
            let map = CellMap { labels, x, y, notes: notes(), values, ..CellMap::default() };
            return Panels::column(title, vec![map], caption).into();
        }
        if few(NAMED) && all_positive {
            let (rows, columns) = (self.names(0), self.names(1));
            let labels = [format!("{} (rows: {})", self.label(1), self.label(0)), name];
            return Matrix { title, rows, columns, labels, notes: notes(), values, caption }.into();
        }
        let nth = |axis: usize| format!("{}, index of the value", self.label(axis));
        let signed = values.iter().any(|value| *value < 0.0);
        let map = SpaceTime {
            site_label: nth(1),
            time_label: nth(0),
            value_label: name,
            values,
            sites: columns,
            first_site: 1.0,
            times: (1.0, rows as f64),
            most: None,
            signed,
        };
        Panels::column(title, vec![map], caption).into()
    }
}
