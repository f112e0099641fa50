//! Tables in plain text, and cells of CSV.

use serde_json::Value;

/// A table in plain text, with `gap` spaces between columns; a cell may have several lines. Columns in
/// which all cells but `–` begin like numbers are aligned to the right, others to the left.
pub fn table(head: &[impl AsRef<str>], rows: &[Vec<String>], gap: usize) -> String {
    let head: Vec<&str> = head.iter().map(AsRef::as_ref).collect();
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).map(String::as_str).chain([head[column]]);
        cells.flat_map(str::lines).map(|line| line.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let numeric: Vec<bool> = (0..head.len())
        .map(|column| {
            let mut cells = rows.iter().filter_map(|row| row.get(column)).filter(|cell| !is_missing(cell)).peekable();
            cells.peek().is_some() && cells.all(|cell| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
        })
        .collect();
    let line = |cells: &[&str], line: usize| {
        let padded = cells.iter().zip(&widths).zip(&numeric).map(|((cell, &width), numeric)| {
            let cell = cell.lines().nth(line).unwrap_or_default();
            if *numeric { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        padded.collect::<Vec<_>>().join(&" ".repeat(gap)).trim_end().to_owned() + "\n"
    };
    let lines = |cells: Vec<&str>| {
        let height = cells.iter().map(|cell| cell.lines().count()).max().unwrap_or(0).max(1);
        (0..height).map(|k| line(&cells, k)).collect::<String>()
    };
    let rule: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
    let mut text = lines(head.clone()) + &lines(rule.iter().map(String::as_str).collect());
    for row in rows {
        text += &lines((0..head.len()).map(|column| row.get(column).map_or("", String::as_str)).collect());
    }
    text
}

/// Whether a cell stands for a value that does not exist.
fn is_missing(cell: &str) -> bool {
    cell.is_empty() || cell == "–"
}

/// A value as a cell of CSV, which reads back exactly and holds no comma.
pub fn cell(value: &Value, missing: &str) -> String {
    match value {
        Value::Null => missing.to_owned(),
        Value::Bool(holds) => u8::from(*holds).to_string(),
        Value::String(words) => words.replace(',', ";"),
        Value::Number(number) => match (number.as_u64(), number.as_f64()) {
            (Some(whole), _) => whole.to_string(),
            (None, Some(value)) => format!("{value:e}"),
            _ => number.to_string(),
        },
        other => other.to_string(),
    }
}
