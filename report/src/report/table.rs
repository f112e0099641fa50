//! A table told once: each column has a name, a heading, a description, a kind and a value for each
//! row. Text, JSON, CSV, NPZ, lines of a picture and the help follow from that.

use super::{Kind, Line, Panel, Quantity, Units, text};
use crate::{number::format_fixed, output::NpzWriter};
use serde_json::{Map, Value, json};
use std::io::{self, Seek, Write};

/// Width of a text table from which it is cut into two, in characters.
pub(super) const WIDE: usize = 120;
/// Width of paragraphs, and of the legend below a text table.
pub(super) const LEGEND: usize = 100;

/// A number as JSON: `null` for not-a-number, `"inf"` and `"-inf"` for infinity, which JSON lacks.
pub fn number(x: f64) -> Value {
    if x.is_infinite() { json!(x.to_string()) } else { json!(x) }
}

/// A value of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number; not-a-number stands for a value that does not exist.
    Number(f64),
    /// A whole number.
    Count(u64),
    /// Whether something holds.
    Flag(bool),
    /// A word or a sentence; `None` without one.
    Word(Option<String>),
    /// A list or a table of its own, which only JSON shows.
    Nested(Value),
}

macro_rules! cells {
    ($($kind:ty: $value:ident => $cell:expr;)*) => {$(
        impl From<$kind> for Cell {
            fn from($value: $kind) -> Self {
                $cell
            }
        }
    )*};
}
cells! {
    f64: x => Self::Number(x);
    Option<f64>: x => Self::Number(x.unwrap_or(f64::NAN));
    usize: n => Self::Count(n as u64);
    Option<usize>: n => n.map_or(Self::Number(f64::NAN), Self::from);
    u64: n => Self::Count(n);
    bool: holds => Self::Flag(holds);
    &str: word => Self::Word(Some(word.to_owned()));
    String: word => Self::Word(Some(word));
    Option<String>: word => Self::Word(word);
    Value: value => Self::Nested(value);
    Vec<f64>: list => Self::Nested(list.into_iter().map(number).collect());
}

/// How a number is written in text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// So many decimals.
    Fixed(usize),
    /// So many decimals and a power of ten.
    Power(usize),
    /// As many digits as it needs.
    Short,
    /// The column stands in files only.
    Hidden,
    /// Lists, or words of a sentence, which stand in JSON only.
    Json,
}

/// A column and its values.
#[derive(Clone, Debug)]
struct Column {
    name: String,
    head: String,
    about: String,
    quantity: Quantity,
    digits: Digits,
    cells: Vec<Cell>,
}

/// Rows and their columns.
///
/// ```
/// use hertzchain_report::report::{Digits::{Fixed, Hidden, Power}, Table};
/// let rows = [(0.5, 1e-3, 7_u64), (1.0, f64::NAN, 9)];
/// let table = Table::of("errors", &rows)
///     .col("step", Fixed(2), "length of a step", |row| row.0)
///     .col("error", Power(1), "", |row| row.1)
///     .col("evaluations", Hidden, "evaluations of the force", |row| row.2)
///     .done();
/// assert_eq!(table.csv(), "step,error,evaluations\n5e-1,1e-3,7\n1e0,nan,9\n");
/// assert_eq!(table.text(), "step   error\n----  ------\n0.50  1.0e-3\n1.00       –\n\nstep: length of a step.\n");
/// assert_eq!(table.json()[1].to_string(), r#"{"step":1.0,"error":null,"evaluations":9}"#);
/// ```
#[derive(Clone, Debug)]
pub struct Table {
    name: String,
    key: String,
    columns: Vec<Column>,
    rows: usize,
    in_text: Vec<usize>,
    units: Option<Units>,
}

/// A table whose columns are being told.
pub struct Rows<'a, T> {
    rows: &'a [T],
    table: Table,
}

impl Table {
    /// The table of some rows; its columns follow. `name` is that of its CSV file.
    pub fn of<T>(name: impl Into<String>, rows: &[T]) -> Rows<'_, T> {
        let (name, key) = (name.into(), "rows".to_owned());
        let table =
            Self { name, key, columns: Vec::new(), rows: rows.len(), in_text: (0..rows.len()).collect(), units: None };
        Rows { rows, table }
    }
}

impl<T> Rows<'_, T> {
    /// A column with its name in files, its digits in text, what it is, for the legend, and its
    /// value in a row. A name `a.b` is the field `b` of the field `a` in JSON, and `a_b` in CSV.
    /// The heading in text is the name with blanks for underscores.
    #[must_use]
    pub fn col<C: Into<Cell>>(
        self,
        name: impl Into<String>,
        digits: Digits,
        about: impl Into<String>,
        value: impl Fn(&T) -> C,
    ) -> Self {
        self.put(name, digits, about, &|row| value(row).into())
    }

    #[inline(never)]
    fn put(
        mut self,
        name: impl Into<String>,
        digits: Digits,
        about: impl Into<String>,
        of: &dyn Fn(&T) -> Cell,
    ) -> Self {
        self.table.push(name.into(), digits, about.into(), &|row| of(&self.rows[row]));
        self
    }

    /// A column with the number of the row, from 1 on.
    #[must_use]
    pub fn counted(self, name: &str, digits: Digits, about: &str) -> Self {
        let count = self.rows.len();
        self.col(name, digits, about, |_| 0_usize).last(|column| column.cells = (1..=count).map(Cell::from).collect())
    }

    /// Changes the last column.
    fn last(mut self, change: impl FnOnce(&mut Column)) -> Self {
        self.table.columns.last_mut().map(change);
        self
    }

    /// The text has these rows only; without rows it has no table.
    #[must_use]
    pub fn in_text(mut self, rows: impl IntoIterator<Item = usize>) -> Self {
        self.table.in_text = rows.into_iter().filter(|row| *row < self.rows.len()).collect();
        self
    }

    /// About how many rows the text has: evenly spaced ones, and the last.
    #[must_use]
    pub fn few(self, rows: usize) -> Self {
        let (all, every) = (self.rows.len(), self.rows.len().div_ceil(rows).max(1));
        self.in_text((0..all).filter(|row| row % every == 0 || row + 1 == all))
    }

    /// Another heading for the last column.
    #[must_use]
    pub fn head(self, head: impl Into<String>) -> Self {
        self.last(|column| column.head = head.into())
    }

    /// The kind of the numbers in the last column: in SI units they are converted, and its heading
    /// names the unit. An angular frequency has the column `frequency` beside it then.
    #[must_use]
    pub fn kind(self, quantity: Quantity) -> Self {
        self.last(|column| column.quantity = quantity)
    }

    /// The field of the JSON output that has the rows, `rows` unless named; empty for none.
    #[must_use]
    pub fn key(mut self, key: &str) -> Self {
        self.table.key = key.to_owned();
        self
    }

    /// Converts all numbers to SI units, if they are asked for.
    #[must_use]
    pub fn si(mut self, units: Option<&Units>) -> Self {
        self.table.units = units.copied();
        self
    }

    /// The table.
    pub fn done(self) -> Table {
        self.table.with_frequencies()
    }
}

impl<T> From<Rows<'_, T>> for Table {
    fn from(rows: Rows<'_, T>) -> Self {
        rows.done()
    }
}

impl Table {
    /// Adds a column. Not generic, so that it is compiled once and not for each column of the
    /// program.
    fn push(&mut self, name: String, digits: Digits, about: String, cell: &dyn Fn(usize) -> Cell) {
        let head = nested(&name).map_or_else(|| name.replace('_', " "), |_| name.replace(['_', '.'], " "));
        let cells = (0..self.rows).map(cell).collect();
        self.columns.push(Column { name, head, about, quantity: Quantity::Number, digits, cells });
    }

    /// With SI units, a column in Hz for each angular frequency.
    fn with_frequencies(mut self) -> Self {
        if self.units.is_some() {
            let omegas = self.columns.iter().filter(|column| column.quantity == Quantity::Omega);
            let hertz = |column: &Column| Column {
                name: column.name.replace("omega", "frequency"),
                head: column.head.replace("omega", "frequency"),
                about: column.about.replace("frequency", "frequency omega/(2 pi)"),
                quantity: Quantity::Frequency,
                ..column.clone()
            };
            let hertz: Vec<Column> = omegas.map(hertz).collect();
            self.columns.extend(hertz);
        }
        self
    }

    /// Its name, that of its CSV file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The table under another name, in files only.
    pub fn filed(self, name: String) -> Self {
        Self { name, key: String::new(), in_text: Vec::new(), ..self }
    }

    /// Values in time, a column for each site from `first` on, such as `x_-20`; in files only.
    pub fn matrix(name: impl Into<String>, (symbol, first): (&str, i64), t: &[f64], values: &[f64]) -> Self {
        let sites = values.len() / t.len().max(1);
        let rows: Vec<_> = t.iter().zip(values.chunks(sites.max(1))).collect();
        let mut table = Self::of(name, &rows).key("").col("t", Digits::Hidden, "", |row| *row.0);
        for (i, n) in (0..sites).zip(first..) {
            table = table.col(format!("{symbol}_{n}"), Digits::Hidden, "", |row| row.1[i]);
        }
        table.done()
    }

    /// The field of the JSON output that has the rows; empty for none.
    pub(super) fn key_in_json(&self) -> &str {
        &self.key
    }

    fn told(&self, column: &Column, x: f64) -> f64 {
        self.units.map_or(x, |units| units.to_si(column.quantity, x))
    }

    /// The heading of a column, with its unit in SI units.
    fn head(&self, column: &Column) -> String {
        let unit = column.quantity.unit();
        if self.units.is_none() || unit.is_empty() { column.head.clone() } else { format!("{} ({unit})", column.head) }
    }

    /// The rows as JSON.
    pub fn json(&self) -> Vec<Value> {
        (0..self.rows).map(|row| Value::Object(self.object(row))).collect()
    }

    fn object(&self, row: usize) -> Map<String, Value> {
        let mut object = Map::new();
        for column in &self.columns {
            let value = match &column.cells[row] {
                Cell::Number(x) => number(self.told(column, *x)),
                Cell::Count(n) => json!(n),
                Cell::Flag(holds) => json!(holds),
                Cell::Word(word) => json!(word),
                Cell::Nested(value) => value.clone(),
            };
            match nested(&column.name) {
                None => _ = object.insert(column.name.clone(), value),
                Some((outer, inner)) => {
                    object.entry(outer).or_insert_with(|| json!({}))[inner] = value;
                }
            }
        }
        object
    }

    /// The columns that files besides JSON have.
    fn flat(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(|column| column.digits != Digits::Json)
    }

    /// The rows as CSV: every number reads back to the same double, no word holds a comma.
    pub fn csv(&self) -> String {
        let columns: Vec<&Column> = self.flat().collect();
        let cell = |column: &Column, row: usize| match &column.cells[row] {
            Cell::Number(x) if x.is_nan() => "nan".to_owned(),
            Cell::Number(x) => format!("{:e}", self.told(column, *x)),
            Cell::Count(n) => n.to_string(),
            Cell::Flag(holds) => u8::from(*holds).to_string(),
            Cell::Word(word) => word.clone().unwrap_or_default().replace(',', ";").replace('\n', " "),
            Cell::Nested(_) => String::new(),
        };
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let head = line(columns.iter().map(|column| file_name(&column.name)).collect());
        let rows = (0..self.rows).map(|row| line(columns.iter().map(|column| cell(column, row)).collect()));
        head + &rows.collect::<String>()
    }

    /// Adds an array for each column to an archive, named `table.column`.
    pub(super) fn npz(&self, archive: &mut NpzWriter<impl Write + Seek>) -> io::Result<()> {
        for column in self.flat() {
            let name = format!("{}.{}", self.name, file_name(&column.name));
            if let Some(Cell::Word(_)) = column.cells.first() {
                let word = |cell: &Cell| if let Cell::Word(Some(word)) = cell { word.clone() } else { String::new() };
                archive.words(&name, &column.cells.iter().map(word).collect::<Vec<_>>())?;
            } else {
                archive.vector(&name, &self.numbers(column))?;
            }
        }
        Ok(())
    }

    fn numbers(&self, column: &Column) -> Vec<f64> {
        let number = |cell: &Cell| match cell {
            Cell::Number(x) => self.told(column, *x),
            Cell::Count(n) => *n as f64,
            Cell::Flag(holds) => f64::from(u8::from(*holds)),
            _ => f64::NAN,
        };
        column.cells.iter().map(number).collect()
    }

    /// The columns of the text; of a frequency in SI units the one in hertz.
    fn shown(&self) -> impl Iterator<Item = &Column> {
        let twice = |column: &&Column| self.units.is_some() && column.quantity == Quantity::Omega;
        let shown = |column: &&Column| !matches!(column.digits, Digits::Hidden | Digits::Json);
        self.columns.iter().filter(move |column| shown(column) && !twice(column))
    }

    /// Headings and cells of the text.
    pub fn cells(&self) -> (Vec<String>, Vec<Vec<String>>) {
        let cell = |column: &Column, row: usize| match &column.cells[row] {
            Cell::Number(x) if x.is_nan() => "–".to_owned(),
            Cell::Number(x) => {
                // Adding zero takes the sign of -0.
                let (x, si) =
                    (self.told(column, *x) + 0.0, self.units.is_some() && column.quantity != Quantity::Number);
                match column.digits {
                    Digits::Fixed(digits) if !si => format_fixed(x, digits),
                    Digits::Fixed(digits) | Digits::Power(digits) => format!("{x:.digits$e}"),
                    Digits::Short | Digits::Hidden | Digits::Json => x.to_string(),
                }
            }
            Cell::Count(n) => n.to_string(),
            Cell::Flag(holds) => if *holds { "yes" } else { "no" }.to_owned(),
            Cell::Word(word) => word.clone().unwrap_or_default(),
            Cell::Nested(value) => value.to_string(),
        };
        let rows = self.in_text.iter().map(|&row| self.shown().map(|column| cell(column, row)).collect());
        (self.shown().map(|column| self.head(column)).collect(), rows.collect())
    }

    /// What the columns of the text are, in a paragraph; empty if no column says so.
    pub fn legend(&self) -> String {
        let told = self.shown().filter(|column| !column.about.is_empty());
        let all: Vec<String> = told.map(|column| format!("{}: {}", column.head, column.about)).collect();
        if all.is_empty() { String::new() } else { all.join("; ") + "." }
    }

    /// The table as text, with its legend; empty without rows or columns. A wide table is cut into
    /// two, which both begin with its first column.
    pub fn text(&self) -> String {
        self.text_in(WIDE)
    }

    /// The text in lines of so many characters, `WIDE` at most. On a narrow terminal headings are
    /// cut into lines, and then cells with words if the table fits with them.
    pub(super) fn text_in(&self, wide: usize) -> String {
        let (head, rows) = self.cells();
        if head.is_empty() || rows.is_empty() {
            return String::new();
        }
        let count = |words: &str| words.chars().count();
        let longest = |cell: &String| cell.split_whitespace().map(count).max().unwrap_or(0);
        let widths = |k: usize| {
            let most = |of: &dyn Fn(&String) -> usize| rows.iter().map(|row| of(&row[k])).max().unwrap_or(0);
            let cells = most(&|cell| count(cell));
            [cells.max(count(&head[k])), cells.max(longest(&head[k])), most(&longest).max(longest(&head[k]))]
        };
        let columns: Vec<[usize; 3]> = (0..head.len()).map(widths).collect();
        let total = |level: usize, gap: usize| columns.iter().map(|widths| widths[level] + gap).sum::<usize>() - gap;
        let narrow = wide < WIDE && total(0, 2) > wide;
        let gap = if narrow { 1 } else { 2 };
        let mut widths: Vec<usize> = columns.iter().map(|widths| widths[usize::from(narrow)]).collect();
        while narrow && total(2, 1) <= wide && widths.iter().sum::<usize>() + widths.len() > wide + 1 {
            let saved = |k: &usize| widths[*k] - columns[*k][2];
            let k = (0..widths.len()).max_by_key(saved).unwrap_or_default();
            widths[k] = columns[k][2];
        }
        let mut parts = vec![vec![0]];
        let mut taken = widths[0];
        for (k, width) in widths.iter().enumerate().skip(1) {
            if taken + gap + width > wide {
                parts.push(vec![0]);
                taken = widths[0];
            }
            taken += gap + width;
            parts.last_mut().expect("at least one part").push(k);
        }
        let part = |columns: &Vec<usize>| {
            let cell = |cell: &String, k: usize| {
                if narrow { filled(cell, widths[k]).trim_end().to_owned() } else { cell.clone() }
            };
            let of = |cells: &[String]| columns.iter().map(|&k| cell(&cells[k], k)).collect::<Vec<_>>();
            text::table(&of(&head), &rows.iter().map(|row| of(row)).collect::<Vec<_>>(), gap)
        };
        let tables = parts.iter().map(part).collect::<Vec<_>>().join("\n");
        let legend = self.legend();
        if legend.is_empty() { tables } else { format!("{tables}\n{}", filled(&legend, LEGEND.min(wide))) }
    }

    /// Names of its columns in files, and their values.
    pub fn values(&self) -> impl Iterator<Item = (String, Vec<Cell>)> {
        let told = |column: &Column, cell: &Cell| match cell {
            Cell::Number(x) => Cell::Number(self.told(column, *x)),
            cell => cell.clone(),
        };
        self.flat()
            .map(move |column| (file_name(&column.name), column.cells.iter().map(|cell| told(column, cell)).collect()))
    }

    /// Names of its columns in files, and what they are.
    pub fn columns(&self) -> impl Iterator<Item = (String, &str)> {
        self.flat().map(|column| (file_name(&column.name), column.about.as_str()))
    }

    fn column(&self, name: &str) -> &Column {
        let found = self.columns.iter().find(|column| column.name == name);
        found.unwrap_or_else(|| panic!("the table {} has no column {name}", self.name))
    }

    /// A line through the points of two columns, `y` over `x`, without those that do not exist.
    pub fn line(&self, name: &str, [x, y]: [&str; 2]) -> Line {
        let points = self.numbers(self.column(x)).into_iter().zip(self.numbers(self.column(y)));
        Line::new(name, points.filter(|(x, y)| !(x.is_nan() || y.is_nan())))
    }

    /// Columns over the column `x`: each with its name in the legend.
    pub fn panel(&self, kind: Kind, labels: [&str; 2], x: &str, lines: &[(&str, &str)]) -> Panel {
        Panel::new(kind, labels, lines.iter().map(|(name, y)| self.line(name, [x, y])).collect())
    }
}

/// Field and field within it, of a name `a.b`; a number is no such name.
fn nested(name: &str) -> Option<(&str, &str)> {
    name.split_once('.').filter(|(outer, _)| outer.starts_with(char::is_alphabetic))
}

/// The name of a column in CSV and NPZ.
fn file_name(name: &str) -> String {
    if nested(name).is_some() { name.replace('.', "_") } else { name.to_owned() }
}

/// Rows whose fields are the columns of a table, each told once: its documentation is its legend.
///
/// `field: type => digits; kind,` has digits and kind as in [`Rows::col`] and [`Rows::kind`].
/// Without them the column stands in files only. `Row::table(name, &rows)` is the table.
#[macro_export]
macro_rules! rows {
    ($(#[$attribute:meta])* pub struct $row:ident {
        $($(#[doc = $doc:literal])* $field:ident: $type:ty $(=> $digits:expr)? $(; $kind:ident)?,)*
    }) => {
        $(#[$attribute])*
        pub struct $row {
            $($(#[doc = $doc])* pub $field: $type,)*
        }

        impl $row {
            /// The table of some rows, which has its fields as columns.
            pub fn table(name: impl Into<String>, rows: &[Self]) -> $crate::report::Rows<'_, Self> {
                $crate::report::Table::of(name, rows)$(
                    .col(
                        stringify!($field),
                        { #[allow(unused)] let digits = $crate::report::Digits::Hidden; $(let digits = $digits;)? digits },
                        $crate::report::told(concat!($($doc),*)),
                        |row| row.$field.clone(),
                    )
                    $(.kind($crate::report::Quantity::$kind))?
                )*
            }
        }
    };
}
pub use rows;

/// The documentation of a field as a legend: without code marks, capital and full stop.
pub fn told(doc: &str) -> String {
    let words = doc.trim().trim_end_matches('.').replace('`', "");
    let (mut first, second) = (words.chars(), words.chars().nth(1));
    let capital = !doc.trim().starts_with('`') && second.is_some_and(char::is_lowercase);
    match first.next() {
        Some(letter) if capital => letter.to_lowercase().chain(first).collect(),
        _ => words,
    }
}

/// A paragraph in lines of so many characters at most.
pub fn filled(words: &str, width: usize) -> String {
    let mut lines = vec![String::new()];
    for word in words.split_whitespace() {
        let line = lines.last_mut().expect("at least one line");
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.to_owned());
        } else {
            *line += " ";
            *line += word;
        }
    }
    lines.join("\n") + "\n"
}
