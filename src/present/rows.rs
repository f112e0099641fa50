//! Rows of JSON as CSV.

use serde_json::Value;

/// Rows as CSV: `names` are the keys of the rows and the first line. Every number reads back
/// exactly; no cell holds a comma.
///
/// `missing` gives the text of a null under a key.
pub(crate) fn rows_csv(names: &str, rows: &[Value], missing: fn(&str) -> &'static str) -> Vec<u8> {
    let keys: Vec<&str> = names.split(',').collect();
    let mut text = format!("{names}\n");
    for row in rows {
        let cells: Vec<String> = keys.iter().map(|key| cell(&row[*key], missing(key))).collect();
        text += &(cells.join(",") + "\n");
    }
    text.into_bytes()
}

pub(crate) fn cell(value: &Value, missing: &str) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn cells_are_whole_numbers_numbers_words_or_missing() {
        let rows = [json!({"a": 3, "b": 0.1, "c": "x, y"}), json!({"a": true, "b": null, "c": null})];
        let csv = rows_csv("c,a,b", &rows, |key| if key == "c" { "" } else { "nan" });
        assert_eq!(String::from_utf8(csv).unwrap(), "c,a,b\nx; y,3,1e-1\n,1,nan\n");
    }
}
