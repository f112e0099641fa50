//! Tables in plain text, and such text read again.

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

/// A part of a text.
#[cfg(feature = "cli")]
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Part {
    /// Lines that belong to no table.
    Words(String),
    /// A [`table`]; each row has a cell for each name.
    Table { head: Vec<String>, rows: Vec<Vec<String>> },
}

/// Words and [tables](table) of a text: a table is a line of names above a line of dashes, and ends
/// at an empty line.
#[cfg(feature = "cli")]
pub(super) fn parts(text: &str) -> Vec<Part> {
    let lines: Vec<&str> = text.lines().collect();
    let (mut parts, mut words, mut at) = (Vec::new(), String::new(), 0);
    while at < lines.len() {
        match lines.get(at + 1).and_then(|rule| columns(rule)) {
            Some(columns) if !lines[at].is_empty() => {
                let cells = |line: &str| -> Vec<String> {
                    let letters: Vec<char> = line.chars().collect();
                    let cell = |&(from, to): &(usize, usize)| {
                        let end = to.min(letters.len());
                        letters.get(from..end).unwrap_or_default().iter().collect::<String>().trim().to_owned()
                    };
                    columns.iter().map(cell).collect()
                };
                let rows: Vec<Vec<String>> =
                    lines[at + 2..].iter().take_while(|line| !line.is_empty()).map(|line| cells(line)).collect();
                parts.extend(paragraph(&mut words));
                at += 2 + rows.len();
                parts.push(Part::Table { head: cells(lines[at - rows.len() - 2]), rows });
            }
            _ => {
                words += lines[at];
                words.push('\n');
                at += 1;
            }
        }
    }
    parts.extend(paragraph(&mut words));
    parts
}

#[cfg(feature = "cli")]
fn paragraph(words: &mut String) -> Option<Part> {
    let text = std::mem::take(words).trim().to_owned();
    (!text.is_empty()).then_some(Part::Words(text))
}

/// Where columns begin and end, if a line is the rule of a table; the last column has no end.
#[cfg(feature = "cli")]
fn columns(rule: &str) -> Option<Vec<(usize, usize)>> {
    let dashes = rule.starts_with('-') && rule.chars().all(|c| c == '-' || c == ' ');
    let mut starts: Vec<usize> = Vec::new();
    let mut before = ' ';
    for (at, c) in rule.chars().enumerate().take_while(|_| dashes) {
        if c == '-' && before == ' ' {
            starts.push(at);
        }
        before = c;
    }
    let ends = starts.iter().skip(1).map(|start| start - 2).chain([usize::MAX]);
    (!starts.is_empty()).then(|| starts.iter().copied().zip(ends).collect())
}

#[cfg(all(test, feature = "cli"))]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let rows = [["α", "", "1.5"], ["a b", "-3", "no number"], ["", "12", ""]];
        let rows: Vec<Vec<String>> = rows.map(|row| row.map(str::to_owned).to_vec()).into();
        let head = ["name", "κ", "what it is"];
        let text = format!("Above.\n\n{}\n- one\n- two\n{}", table(&head, &rows), table(&["x"], &[]));
        let head: Vec<String> = head.map(str::to_owned).into();
        let words = |text: &str| Part::Words(text.to_owned());
        let expected = vec![
            words("Above."),
            Part::Table { head, rows },
            words("- one\n- two"),
            Part::Table { head: vec!["x".to_owned()], rows: vec![] },
        ];
        assert_eq!(parts(&text), expected);
    }
}
