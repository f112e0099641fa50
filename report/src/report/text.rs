//! Tables in plain text, and cells of CSV.

use serde_json::Value;

/// A table in plain text, with two spaces between columns. Columns in which all cells but `–` begin
/// like numbers are aligned to the right, others to the left.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count());
        cells.chain([head[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let numeric: Vec<bool> = (0..head.len())
        .map(|column| {
            let mut cells = rows.iter().filter_map(|row| row.get(column)).filter(|cell| !is_missing(cell)).peekable();
            cells.peek().is_some() && cells.all(|cell| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
        })
        .collect();
    let line = |cells: Vec<&str>| {
        let padded = cells.iter().enumerate().map(|(column, cell)| {
            let width = widths[column];
            if numeric[column] { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    let rule: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
    let mut text = line(head.to_vec()) + &line(rule.iter().map(String::as_str).collect());
    for row in rows {
        text += &line((0..head.len()).map(|column| row.get(column).map_or("", String::as_str)).collect());
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
