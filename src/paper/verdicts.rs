//! The verdicts as a table, as CSV and as JSON.

use super::{
    claims::{Claim, Kind},
    rule::Rule,
    verify::{Item, Verdict, Verification},
};
use crate::{output::to_json, present::table};
use serde_json::{Value, json};

const VERDICTS: [Verdict; 5] =
    [Verdict::Agrees, Verdict::Differs, Verdict::Holds, Verdict::Fails, Verdict::NotDecidable];

/// The name of the claims of each kind, and the verdicts that they can have.
const KINDS: [(Kind, &str, [Verdict; 3]); 3] = [
    (Kind::Number, "numbers", [Verdict::Agrees, Verdict::Differs, Verdict::NotDecidable]),
    (Kind::Formula, "formulas", [Verdict::Agrees, Verdict::Differs, Verdict::NotDecidable]),
    (Kind::Statement, "statements", [Verdict::Holds, Verdict::Fails, Verdict::NotDecidable]),
];

fn count(verification: &Verification, verdict: Verdict) -> usize {
    verification.items.iter().filter(|item| item.verdict() == verdict).count()
}

/// The verdicts as JSON.
///
/// `value` is null if it is not finite. `instead` is the rule of our value where it is known to
/// differ from that of the paper, or where the claim cannot be decided; `open` is the information
/// that the paper does not give.
pub fn verify_json(verification: &Verification) -> String {
    let item = |item: &Item| {
        let claim = item.claim;
        json!({
            "id": claim.id,
            "section": claim.section,
            "label": claim.label,
            "quantity": claim.quantity,
            "paper": claim.paper,
            "rule": claim.rule.words(),
            "value": item.value,
            "shown": item.shown(),
            "verdict": item.verdict().word(),
            "expected": item.expected().word(),
            "kind": format!("{:?}", claim.kind).to_lowercase(),
            "same": claim.same,
            "instead": claim.instead.as_ref().map(Rule::words),
            "open": claim.open,
            "as_expected": item.as_expected(),
            "why": claim.why,
        })
    };
    let counts = VERDICTS.map(|verdict| (verdict.word().to_owned(), json!(count(verification, verdict))));
    let kinds = KINDS.map(|(kind, name, verdicts)| {
        let counts = verdicts.map(|verdict| (verdict.word().to_owned(), json!(verification.count(kind, verdict))));
        (name.to_owned(), Value::Object(counts.into_iter().collect()))
    });
    to_json(&json!({
        "as_expected": verification.unexpected().next().is_none(),
        "counts": Value::Object(counts.into_iter().collect()),
        "kinds": Value::Object(kinds.into_iter().collect()),
        "misprints": verification.misprints(),
        "items": verification.items.iter().map(item).collect::<Vec<Value>>(),
        "wall_s": verification.wall.as_secs_f64(),
        "version": env!("CARGO_PKG_VERSION"),
    }))
}

/// The verdicts as CSV, one line for each item, with texts in quotation marks.
pub fn verify_csv(verification: &Verification) -> Vec<u8> {
    let quoted = |text: &String| format!("\"{}\"", text.replace('"', "\"\""));
    let mut text = String::from("id,section,label,quantity,paper,rule,value,verdict,expected,as_expected,why,open\n");
    for item in &verification.items {
        let claim = item.claim;
        let (verdict, expected) = (item.verdict().word(), item.expected().word());
        let open = claim.open.clone().unwrap_or_default();
        let [label, quantity, paper, rule, why, open] =
            [&claim.label, &claim.quantity, &claim.paper, &claim.rule.words(), &claim.why, &open].map(quoted);
        let (id, section, value, as_expected) = (&claim.id, claim.section, item.value, item.as_expected());
        text += &format!(
            "{id},{section},{label},{quantity},{paper},{rule},{value:e},{verdict},{expected},{as_expected},{why},{open}\n"
        );
    }
    text.into_bytes()
}

/// A table for each section, with remarks and reasons below it.
pub fn verify_table(verification: &Verification) -> String {
    let sections = verification.items.chunk_by(|one, next| one.claim.section == next.claim.section);
    let tables: Vec<String> = sections.map(section_table).collect();
    let unexpected = verification.unexpected().count();
    let known = if unexpected == 0 { "all as known".to_owned() } else { format!("{unexpected} not as known") };
    let kinds = KINDS.map(|(kind, name, verdicts)| {
        let [good, bad, open] =
            verdicts.map(|verdict| format!("{} {}", verification.count(kind, verdict), verdict_plural(verdict)));
        format!("{name}: {good}, {bad}, {open}")
    });
    let items = verification.items.len();
    let misprints = verification.misprints();
    format!(
        "{}\n{items} items; {}. {misprints} differences, each counted once however often it is repeated; {known}.\n",
        tables.join("\n"),
        kinds.join("; "),
    )
}

/// The verdict as a verb of several claims.
fn verdict_plural(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "agree",
        Verdict::Differs => "differ",
        Verdict::Holds => "hold",
        Verdict::Fails => "fail",
        Verdict::NotDecidable => "not decidable",
    }
}

fn section_table(items: &[Item]) -> String {
    let row = |item: &Item| {
        let (claim, verdict) = (item.claim, item.verdict().word());
        let verdict = if item.as_expected() { verdict.to_owned() } else { format!("{verdict} (!)") };
        let [id, label, quantity, paper] = [&claim.id, &claim.label, &claim.quantity, &claim.paper].map(String::clone);
        vec![id, label, quantity, paper, claim.rule.words(), item.shown(), verdict]
    };
    let rows: Vec<Vec<String>> = items.iter().map(row).collect();
    let head = ["item", "where", "quantity", "the paper says", "as a rule", "we get", "verdict"];
    let remarks: Vec<Vec<String>> = items
        .iter()
        .map(|item| vec![item.claim.id.clone(), item.verdict().word().to_owned(), remark(item.claim)])
        .filter(|row| !row[2].is_empty())
        .collect();
    let section = items.first().map_or(0, |item| item.claim.section);
    let mut text = format!("Section {section}\n\n{}", table(&head, &rows));
    if !remarks.is_empty() {
        text += &format!("\n{}", table(&["item", "verdict", "why, or a remark"], &remarks));
    }
    text
}

/// The reason or remark of a claim, after what the paper leaves open.
fn remark(claim: &Claim) -> String {
    let open = claim.open.as_ref().map(|open| format!("The paper does not give {open}."));
    [open.as_deref(), Some(&claim.why)]
        .into_iter()
        .flatten()
        .filter(|text| !text.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::verify::tests::claim;

    #[test]
    fn csv_keeps_commas_and_quotation_marks_in_their_cells() {
        let mut claim = claim(Kind::Number, "2", "rounds to 2");
        (claim.label, claim.quantity) = ("eq:a, eq:b".to_owned(), "a \"wave\"".to_owned());
        let item = Item { claim: Box::leak(Box::new(claim)), value: 2.0 };
        let csv = verify_csv(&Verification { items: vec![item], wall: std::time::Duration::ZERO });
        let line = String::from_utf8(csv).unwrap().lines().nth(1).unwrap().to_owned();
        assert_eq!(
            line,
            "s3-x,3,\"eq:a, eq:b\",\"a \"\"wave\"\"\",\"2\",\"rounds to 2\",2e0,agrees,agrees,true,\"\",\"\""
        );
    }
}
