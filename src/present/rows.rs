//! Values of JSON as cells of CSV.

use serde_json::Value;

/// A value as a cell of CSV, which reads back exactly and holds no comma.
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
        let values = [json!("x, y"), json!(3), json!(0.1), json!(true), json!(null)];
        assert_eq!(values.map(|value| cell(&value, "nan")), ["x; y", "3", "1e-1", "1", "nan"]);
    }
}
