//! The verdicts as a report.

use super::{
    claims::{Claim, Kind},
    rule::Rule,
    verify::{Item, Verdict, Verification, of_section, verify},
};
use crate::{
    error::Result,
    report::{Hidden, Json, Report, Short, Table},
    study::{Study, Work, options},
};
use serde_json::{Map, Value, json};

options! {
    /// The numbers of the paper against ours.
    pub struct Verify {
        /// One section of the paper: 2, 3, 4, 5, 6, 7 or 8 [default: all].
        section: Option<u32> = None, "S";
    }
}

impl Study for Verify {
    const FILES: &'static str = "Files: verify.txt, verify.csv, verify.npz and verify.json; verify.store, which keeps what was computed for the next run.";
    const SWEEPS: bool = true;

    fn begin(&self) -> Result<Work<'_>> {
        of_section(self.section)?;
        Ok(Box::new(|engine, progress| Ok(verify_report(&verify(self.section, engine, progress)?))))
    }
}

/// The name of the claims of each kind, and the verdicts that they can have.
const KINDS: [(Kind, &str, [Verdict; 3]); 3] = [
    (Kind::Number, "numbers", [Verdict::Agrees, Verdict::Differs, Verdict::NotDecidable]),
    (Kind::Formula, "formulas", [Verdict::Agrees, Verdict::Differs, Verdict::NotDecidable]),
    (Kind::Statement, "statements", [Verdict::Holds, Verdict::Fails, Verdict::NotDecidable]),
];

/// The verdicts, with remarks and reasons.
///
/// In the JSON output `value` is null if it is not a number. `instead` is the rule of our value
/// where it is known to differ from that of the paper, or where the claim cannot be decided; `open`
/// is the information that the paper does not give.
pub fn verify_report(verification: &Verification) -> Report {
    let Verification { items, wall } = verification;
    let count = |verdict: Verdict| items.iter().filter(|item| item.verdict() == verdict).count();
    let counts: Map<String, Value> =
        Verdict::ALL.map(|verdict| (verdict.name().to_owned(), json!(count(verdict)))).into_iter().collect();
    let kinds = KINDS.map(|(kind, name, verdicts)| {
        let counts = verdicts.map(|verdict| (verdict.name().to_owned(), json!(verification.count(kind, verdict))));
        (name.to_owned(), Value::Object(counts.into_iter().collect()))
    });
    let kinds_words = KINDS.map(|(kind, name, verdicts)| {
        let [good, bad, open] = verdicts
            .map(|verdict| format!("{} {}", verification.count(kind, verdict), verdict.name().trim_end_matches('s')));
        format!("{name}: {good}, {bad}, {open}")
    });
    let misprints = verification.misprints();
    let unexpected: Vec<&str> = verification.unexpected().map(|item| item.claim.id.as_str()).collect();
    let known = match unexpected.len() {
        0 => "all as known".to_owned(),
        count => format!("{count} not as known"),
    };
    let table = Table::of("verify", items)
        .key("items")
        .col("id", Short, "", |item| item.claim.id.clone())
        .head("item")
        .col("section", Short, "", |item| item.claim.section as usize)
        .col("label", Short, "", |item| item.claim.label.clone())
        .head("where")
        .col("quantity", Short, "", |item| item.claim.quantity.clone())
        .col("paper", Short, "", |item| item.claim.paper.clone())
        .head("the paper says")
        .col("rule", Hidden, "what the paper says, as a rule", |item| item.claim.rule.words())
        .col("rule_in_words", Short, "", |item| rule_in_words(&item.claim.rule))
        .head("as a rule")
        .col("value", Hidden, "our value", |item| item.value)
        .col("shown", Short, "", Item::shown)
        .head("we get")
        .col("expected", Hidden, "known verdict", |item| item.expected().name())
        .col("kind", Json, "", |item| format!("{:?}", item.claim.kind).to_lowercase())
        .col("same", Json, "", |item| json!(item.claim.same))
        .col("instead", Json, "", |item| item.claim.instead.as_ref().map(Rule::words))
        .col("as_expected", Short, "whether the verdict is the known one", Item::as_expected)
        .head("as known")
        .col("why", Hidden, "reason or remark", |item| item.claim.why.clone())
        .col("open", Hidden, "what the paper does not give", |item| item.claim.open.clone())
        .col("verdict", Short, "", |item| item.verdict().name());
    let remarks = items.iter().filter_map(|item| {
        let differs = matches!(item.verdict(), Verdict::Differs | Verdict::Fails);
        Some((format!("{}: {}", item.claim.id, remark(item.claim)?), differs))
    });
    let report = Report::new("verify")
        .fact("as_expected", unexpected.is_empty())
        .fact("counts", counts)
        .fact("kinds", kinds.into_iter().collect::<Map<String, Value>>())
        .fact("misprints", misprints)
        .table(table)
        .finding();
    let report = remarks.fold(report, |report, (remark, differs)| {
        let report = report.words(remark);
        if differs { report.finding() } else { report }
    });
    let report = report.fact("wall_s", wall.as_secs_f64()).words(format!(
        "{} items; {}. {misprints} differences, each counted once however often it is repeated; {known}.",
        items.len(),
        kinds_words.join("; "),
    ));
    let report = report.finding();
    let text = report.text();
    let why = (!unexpected.is_empty()).then(|| format!("not as known: {}", unexpected.join(", ")));
    report.file("verify.txt", text.into_bytes()).failure(why)
}

/// A rule without symbols.
fn rule_in_words(rule: &Rule) -> String {
    let words = rule.words();
    match words.split_once(' ') {
        Some(("<=", bound)) => format!("at most {bound}"),
        Some((">=", bound)) => format!("at least {bound}"),
        Some(("=", rest)) => rest.replacen(" to ", " within ", 1),
        _ => words,
    }
}

/// The reason or remark of a claim, if there is one, after what the paper leaves open.
fn remark(claim: &Claim) -> Option<String> {
    let open = claim.open.as_ref().map(|open| format!("The paper does not give {open}."));
    let all: Vec<&str> =
        [open.as_deref(), Some(&claim.why)].into_iter().flatten().filter(|text| !text.is_empty()).collect();
    (!all.is_empty()).then(|| all.join(" "))
}
