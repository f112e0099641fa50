//! Results as values: facts, tables and pictures, told once. Text, JSON, CSV, NPZ, pictures and the
//! page of a report follow from them. Knows no physics.

mod figure;
mod table;
pub mod text;
mod units;

pub use figure::{
    Bar, CellMap, Column, Curve, Figure, GrowthMap, Kind, Line, Matrix, Panel, Panels, Plot, Point, Raster, SpaceTime,
    WorkPrecision,
};
pub use table::{
    Cell,
    Digits::{self, Fixed, Hidden, Json, Power, Short},
    Rows, Table, filled, number, rows, told,
};
pub use units::{Quantity, Units};

use crate::{
    error::Result,
    output::{NpzWriter, PROGRAM, SETTINGS, in_memory, to_json},
};
use serde::Serialize;
use serde_json::{Map, Value, json};

/// Fields of JSON that have the names of fields or methods of values: `fields!(line => to, len();
/// point => x)`.
#[macro_export]
macro_rules! fields {
    ($($of:expr => $($field:ident $(($($argument:tt)*))?),+);+) => {
        serde_json::json!({ $($(stringify!($field): $of.$field $(($($argument)*))?,)+)+ })
    };
}
pub use fields;

/// A paragraph or a table.
#[derive(Clone, Debug)]
pub enum Block {
    /// Lines, with an end of line after each; or a paragraph, without any.
    Words(String),
    /// A table.
    Table(Table),
}

/// The result of a study.
///
/// Facts and tables are the fields of its JSON output, words and tables its text, both in the order
/// in which they are added. Files are `NAME.json`, `NAME.npz` with an array for each column of all
/// tables, and a CSV file for each table.
#[derive(Clone, Debug)]
pub struct Report {
    name: &'static str,
    facts: Map<String, Value>,
    blocks: Vec<Block>,
    findings: Vec<usize>,
    pictures: Vec<(String, Figure)>,
    files: Vec<(String, Vec<u8>)>,
    remark: Option<String>,
    failure: Option<String>,
    units: Option<Units>,
}

impl Report {
    /// A result without anything, by the name of its files.
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            facts: Map::new(),
            blocks: Vec::new(),
            findings: Vec::new(),
            pictures: Vec::new(),
            files: Vec::new(),
            remark: None,
            failure: None,
            units: None,
        }
    }

    /// A field of the JSON output.
    #[must_use]
    pub fn fact(mut self, name: &str, value: impl Serialize) -> Self {
        // Values here have string keys: serialisation cannot fail.
        self.facts.insert(name.to_owned(), serde_json::to_value(value).unwrap_or_default());
        self
    }

    /// Fields of the JSON output, those of a structure.
    #[must_use]
    pub fn facts(mut self, fields: impl Serialize) -> Self {
        if let Ok(Value::Object(fields)) = serde_json::to_value(fields) {
            self.facts.extend(fields);
        }
        self
    }

    /// A table; its rows are a field of the JSON output.
    #[must_use]
    pub fn table(self, table: impl Into<Table>) -> Self {
        self.with(table.into())
    }

    fn with(mut self, table: Table) -> Self {
        if !table.key_in_json().is_empty() {
            self.facts.insert(table.key_in_json().to_owned(), Value::Array(table.json()));
        }
        self.blocks.push(Block::Table(table));
        self
    }

    /// A paragraph of the text.
    #[must_use]
    pub fn words(mut self, words: impl AsRef<str>) -> Self {
        if !words.as_ref().is_empty() {
            self.blocks.push(Block::Words(words.as_ref().trim_end().to_owned()));
        }
        self
    }

    /// Makes the last paragraph or table a finding, which the page of a report shows first.
    #[must_use]
    pub fn finding(mut self) -> Self {
        self.findings.extend(self.blocks.len().checked_sub(1));
        self
    }

    /// Lines of the text, as they are.
    #[must_use]
    pub fn lines(mut self, lines: String) -> Self {
        self.blocks.push(Block::Words(lines));
        self
    }

    /// A picture, `NAME.png`. The program is named at the end of its caption.
    #[must_use]
    pub fn picture(self, figure: impl Into<Figure>) -> Self {
        let name = self.name;
        self.picture_named(name, figure)
    }

    /// A picture with a name of its own.
    #[must_use]
    pub fn picture_named(mut self, name: &str, figure: impl Into<Figure>) -> Self {
        let mut figure = figure.into();
        *figure.words()[1] += &format!(" {PROGRAM}.");
        self.pictures.push((format!("{name}.png"), figure));
        self
    }

    /// Marks abscissas in all panels of its pictures.
    #[must_use]
    pub fn marked(mut self, name: &str, places: &[f64]) -> Self {
        for (_, figure) in &mut self.pictures {
            let Figure::Panels(figure) = figure else { continue };
            for plot in figure.columns.iter_mut().flat_map(|column| &mut column.panels) {
                let Plot::Panel(panel) = plot else { continue };
                panel.mark = Some((name.to_owned(), places.to_vec()));
            }
        }
        self
    }

    /// A file with a format of its own; in place of `NAME.json` or `NAME.npz`, if it has this name.
    #[must_use]
    pub fn file(mut self, name: &str, bytes: Vec<u8>) -> Self {
        self.files.push((name.to_owned(), bytes));
        self
    }

    /// Why the study has not done what it was asked for: the command fails.
    #[must_use]
    pub fn failure(mut self, words: Option<String>) -> Self {
        self.failure = words.or(self.failure);
        self
    }

    /// A remark beside the results, which is no error.
    #[must_use]
    pub fn remark(mut self, words: Option<String>) -> Self {
        let all: Vec<String> = self.remark.into_iter().chain(words).collect();
        self.remark = (!all.is_empty()).then(|| all.join("\n"));
        self
    }

    /// What makes the results doubtful, if anything does: a field of the JSON output, and remarks.
    #[must_use]
    pub fn warnings(self, all: Vec<String>) -> Self {
        let lines = all.iter().map(|words| format!("WARNING     {words}")).collect::<Vec<_>>().join("\n");
        if all.is_empty() { self } else { self.fact("warnings", all).remark(Some(lines)) }
    }

    /// Says that all numbers are in SI units, if they are.
    #[must_use]
    pub fn si(mut self, units: Option<&Units>) -> Self {
        self.units = units.copied();
        self
    }

    /// The JSON output.
    pub fn json(&self) -> Value {
        let mut facts = self.facts.clone();
        facts.insert("version".to_owned(), json!(env!("CARGO_PKG_VERSION")));
        if let Some(units) = &self.units {
            facts.insert("units".to_owned(), json!(units));
            facts.insert("si".to_owned(), json!(true));
        }
        Value::Object(facts)
    }

    /// The text: paragraphs and tables with an empty line between them.
    pub fn text(&self) -> String {
        self.text_in(table::WIDE)
    }

    /// The text for a terminal with lines of so many characters, if they are fewer than those of
    /// [`text`](Self::text).
    pub fn text_in(&self, width: usize) -> String {
        let width = width.min(table::WIDE);
        let block = |block: &Block| match block {
            Block::Words(words) if words.ends_with('\n') => words.clone(),
            Block::Words(words) => filled(words, table::LEGEND.min(width)),
            Block::Table(table) => table.text_in(width),
        };
        let si = self.units.map(|units| format!("units: {}; all numbers here are in SI units\n", units.words()));
        let parts = self.blocks.iter().map(block).chain(si).filter(|text| !text.is_empty());
        parts.collect::<Vec<_>>().join("\n")
    }

    /// Paragraphs and tables, from the top, each with whether it is a finding.
    pub fn blocks(&self) -> impl Iterator<Item = (&Block, bool)> {
        self.blocks.iter().enumerate().map(|(k, block)| (block, self.findings.contains(&k)))
    }

    /// The tables.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks.iter().filter_map(|block| if let Block::Table(table) = block { Some(table) } else { None })
    }

    /// The CSV files, one a table.
    pub fn csv(&self) -> impl Iterator<Item = (String, Vec<u8>)> {
        self.tables().map(|table| (format!("{}.csv", table.name()), table.csv().into_bytes()))
    }

    /// All files but pictures.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let program = json!({ "program": PROGRAM }).to_string();
        let npz = in_memory(|bytes| {
            let mut archive = NpzWriter::new(bytes, Some((SETTINGS, &program)))?;
            self.tables().try_for_each(|table| table.npz(&mut archive))?;
            archive.finish()
        })?;
        let json = (format!("{}.json", self.name), (to_json(&self.json()) + "\n").into_bytes());
        let npz = (format!("{}.npz", self.name), npz);
        let own = |(name, _): &(String, Vec<u8>)| self.files.iter().any(|(own, _)| own == name);
        Ok(self
            .csv()
            .chain([json, npz].into_iter().filter(|file| !own(file)))
            .chain(self.files.iter().cloned())
            .collect())
    }

    /// Its files, and the columns of its tables, for the help of a command; `others` says what else
    /// there is, perhaps another archive of its name.
    pub fn files_in_words(&self, others: &str) -> String {
        let name = self.name;
        if self.tables().next().is_none() && self.pictures.is_empty() {
            return format!("Files: {name}.json, {name}.npz.\n\n");
        }
        let columns = |table: &Table| {
            let told = |(column, about): (String, &str)| {
                if about.is_empty() { column } else { format!("{column} ({about})") }
            };
            format!("{}.csv: {}", table.name(), table.columns().map(told).collect::<Vec<_>>().join(", "))
        };
        let tables = self.tables().map(columns).collect::<Vec<_>>().join(".\n\n");
        let pictures: Vec<&str> = self.pictures.iter().map(|(picture, _)| picture.as_str()).collect();
        let pictures = if pictures.is_empty() { format!("{name}.png") } else { pictures.join(", ") };
        let archive = match others.contains(&format!("{name}.npz")) {
            true => ", and tables with their columns:",
            false => &format!("; {name}.npz with an array TABLE.COLUMN for each column of"),
        };
        format!("Files: {name}.json, {pictures}{archive}\n\n{tables}.\n\n")
    }

    /// The pictures, by the name of their PNG file.
    pub fn pictures(&self) -> &[(String, Figure)] {
        &self.pictures
    }

    /// Its tables, in files only, their names after those `before`, and its pictures: for another
    /// report, which names the program itself.
    pub fn parts(self, before: &[&str]) -> (Vec<Table>, Vec<Figure>) {
        let filed = |block| {
            let Block::Table(table) = block else { return None };
            let names = before.iter().copied().chain([table.name()]).filter(|name| !name.is_empty());
            let name = names.collect::<Vec<_>>().join("-");
            Some(table.filed(name))
        };
        let tables = self.blocks.into_iter().filter_map(filed);
        let unnamed = |(_, mut figure): (String, Figure)| {
            let [_, caption] = figure.words();
            caption.truncate(caption.trim_end_matches(&format!(" {PROGRAM}.")).len());
            figure
        };
        (tables.collect(), self.pictures.into_iter().map(unnamed).collect())
    }

    /// What is remarkable, if anything.
    pub fn remarks(&self) -> Option<&str> {
        self.remark.as_deref()
    }

    /// Why the study has not done what it was asked for, if it has not.
    pub fn error(&self) -> Option<&str> {
        self.failure.as_deref()
    }
}
