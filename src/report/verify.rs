//! Reports of the paper's numbers against ours.

use super::table;
use crate::{
    experiments::{Item, Verdict, Verification},
    output::to_json,
};
use serde_json::{Value, json};

const VERDICTS: [Verdict; 4] = [Verdict::Agrees, Verdict::Differs, Verdict::Holds, Verdict::Fails];

fn count(verification: &Verification, verdict: Verdict) -> usize {
    verification.items.iter().filter(|item| item.verdict() == verdict).count()
}

/// The table as JSON. `value` is null where there is none; `instead` is the rule of a number that is known to differ from the paper's.
pub fn verify_json(verification: &Verification) -> String {
    let item = |item: &Item| {
        json!({
            "id": item.id,
            "section": item.section,
            "label": item.label,
            "quantity": item.quantity,
            "paper": item.paper,
            "rule": item.rule.words(),
            "value": item.value,
            "shown": item.shown(),
            "verdict": item.verdict().word(),
            "expected": item.expected().word(),
            "instead": item.instead.map(|rule| rule.words()),
            "as_expected": item.as_expected(),
            "why": item.why,
        })
    };
    let counts = VERDICTS.map(|verdict| (verdict.word().to_owned(), json!(count(verification, verdict))));
    to_json(&json!({
        "as_expected": verification.unexpected().next().is_none(),
        "counts": Value::Object(counts.into_iter().collect()),
        "items": verification.items.iter().map(item).collect::<Vec<Value>>(),
        "wall_s": verification.wall.as_secs_f64(),
        "version": env!("CARGO_PKG_VERSION"),
    }))
}

/// The table as CSV, a line an item; texts in quotation marks.
pub fn verify_csv(verification: &Verification) -> Vec<u8> {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let mut text = String::from("id,section,label,quantity,paper,rule,value,verdict,expected,as_expected,why\n");
    for item in &verification.items {
        let (verdict, expected) = (item.verdict().word(), item.expected().word());
        let [label, quantity, paper, rule, why] =
            [item.label, item.quantity, item.paper, &item.rule.words(), item.why].map(quoted);
        let (id, section, value, as_expected) = (item.id, item.section, item.value, item.as_expected());
        text += &format!(
            "{id},{section},{label},{quantity},{paper},{rule},{value:e},{verdict},{expected},{as_expected},{why}\n"
        );
    }
    text.into_bytes()
}

/// A table for each section, remarks and reasons below it.
pub fn verify_table(verification: &Verification) -> String {
    let sections = verification.items.chunk_by(|one, next| one.section == next.section);
    let tables: Vec<String> = sections.map(section_table).collect();
    let counts = VERDICTS.map(|verdict| format!("{} {}", count(verification, verdict), verdict.word())).join(", ");
    let unexpected = verification.unexpected().count();
    let known = if unexpected == 0 { "all as known".to_owned() } else { format!("{unexpected} not as known") };
    format!("{}\n{} items: {counts}; {known}.\n", tables.join("\n"), verification.items.len())
}

fn section_table(items: &[Item]) -> String {
    let row = |item: &Item| {
        let verdict = item.verdict().word();
        let verdict = if item.as_expected() { verdict.to_owned() } else { format!("{verdict} (!)") };
        [item.id, item.label, item.quantity, item.paper, &item.rule.words(), &item.shown(), &verdict]
            .map(str::to_owned)
            .to_vec()
    };
    let rows: Vec<Vec<String>> = items.iter().map(row).collect();
    let head = ["item", "where", "quantity", "the paper says", "as a rule", "we get", "verdict"];
    let remarks: Vec<Vec<String>> = items
        .iter()
        .filter(|item| !item.why.is_empty())
        .map(|item| vec![item.id.to_owned(), item.verdict().word().to_owned(), item.why.to_owned()])
        .collect();
    let section = items.first().map_or(0, |item| item.section);
    let mut text = format!("Section {section}\n\n{}", table(&head, &rows));
    if !remarks.is_empty() {
        text += &format!("\n{}", table(&["item", "verdict", "why, or a remark"], &remarks));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::Rule;

    #[test]
    fn csv_keeps_commas_and_quotation_marks_in_their_cells() {
        let item = Item {
            id: "x",
            section: 3,
            label: "eq:a, eq:b",
            quantity: "a \"wave\"",
            paper: "2",
            rule: Rule::Digits("2"),
            statement: false,
            value: 2.0,
            instead: None,
            why: "",
        };
        let csv = verify_csv(&Verification { items: vec![item], wall: std::time::Duration::ZERO });
        let line = String::from_utf8(csv).unwrap().lines().nth(1).unwrap().to_owned();
        assert_eq!(line, "x,3,\"eq:a, eq:b\",\"a \"\"wave\"\"\",\"2\",\"rounds to 2\",2e0,agrees,agrees,true,\"\"");
    }
}
