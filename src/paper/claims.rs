//! The claims of the paper: the table `claims.toml`, whose head explains its keys.

use super::rule::Rule;
use std::sync::OnceLock;
use toml::{Table, Value};

/// A claim in the text of the paper, and the rule by which a value agrees with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Unique name: `s`, the number of the subsection, and words.
    pub id: String,
    /// Section of the paper, the first digit of the id.
    pub section: u32,
    /// Label in the paper.
    pub label: String,
    /// The computed quantity, in words.
    pub quantity: String,
    /// Whether the paper prints a number, a formula or a statement.
    pub kind: Kind,
    /// The claim as printed.
    pub paper: String,
    /// The claim as a rule.
    pub rule: Rule,
    /// The rule for our value where the claim of the paper is known to be false, or cannot be
    /// decided.
    pub instead: Option<Rule>,
    /// Of a claim that cannot be decided: the information that the paper does not give.
    pub open: Option<String>,
    /// The claim whose misprint this one repeats.
    pub same: Option<String>,
    /// The reason of the difference, or a remark; may be empty.
    pub why: String,
}

/// The form of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A printed number.
    Number,
    /// A printed formula, evaluated.
    Formula,
    /// A statement in words.
    Statement,
}

/// All claims, in the order of the paper.
///
/// # Panics
/// If the table, which is part of the program, cannot be read.
pub fn claims() -> &'static [Claim] {
    static CLAIMS: OnceLock<Vec<Claim>> = OnceLock::new();
    CLAIMS.get_or_init(|| read(include_str!("claims.toml")).unwrap_or_else(|why| panic!("claims.toml: {why}")))
}

/// The keys of a claim. Their values are texts.
const KEYS: [&str; 11] =
    ["id", "label", "quantity", "number", "formula", "statement", "rule", "instead", "open", "same", "why"];

/// The claims in a text like that of `claims.toml`.
pub fn read(text: &str) -> Result<Vec<Claim>, String> {
    let file: Table = text.parse().map_err(|error: toml::de::Error| error.to_string())?;
    let part = |name| file.get(name).ok_or_else(|| format!("no `{name}`"));
    let (rules, rows) = (part("rules")?, part("claim")?.as_array());
    rows.into_iter().flatten().map(|row| Claim::read(row, rules)).collect()
}

impl Claim {
    /// A claim of the table; `named` are the rules that claims refer to by name.
    fn read(row: &Value, named: &Value) -> Result<Self, String> {
        let text = |key: &str| row.get(key)?.as_str().map(str::to_owned);
        let told = |key| text(key).ok_or_else(|| format!("{row}: no `{key}`"));
        let (id, label, quantity) = (told("id")?, told("label")?, told("quantity")?);
        let fault = |why: &str| format!("{id}: {why}");
        let wrong = row.as_table().into_iter().flatten().find(|(key, it)| !KEYS.contains(&&***key) || !it.is_str());
        wrong.map_or(Ok(()), |(key, _)| Err(fault(&format!("`{key}` is no key, or no text"))))?;
        let section = id.strip_prefix('s').and_then(|rest| rest.chars().next()).and_then(|digit| digit.to_digit(10));
        let section = section.ok_or_else(|| fault("an id begins with s and a section"))?;
        let (kind, paper) = match (text("number"), text("formula"), text("statement")) {
            (Some(paper), None, None) => (Kind::Number, paper),
            (None, Some(paper), None) => (Kind::Formula, paper),
            (None, None, Some(paper)) => (Kind::Statement, paper),
            _ => return Err(fault("one of number, formula and statement")),
        };
        let read = |rule: String| -> Result<Rule, String> {
            named.get(&rule).and_then(Value::as_str).unwrap_or(&rule).parse().map_err(|why: String| fault(&why))
        };
        let rule = match (kind, text("rule")) {
            (Kind::Number, None) => read(format!("rounds to {paper}"))?,
            (Kind::Number, Some(_)) => return Err(fault("the rule of a number is its digits")),
            (_, Some(rule)) => read(rule)?,
            (_, None) => return Err(fault("no rule")),
        };
        let (instead, open, same) = (text("instead").map(read).transpose()?, text("open"), text("same"));
        let why = text("why").unwrap_or_default();
        if open.is_some() && instead.is_none() {
            return Err(fault("what is left open needs the rule of our value, `instead`"));
        }
        Ok(Claim { id, section, label, quantity, kind, paper, rule, instead, open, same, why })
    }
}
