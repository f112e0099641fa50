//! The claims of the paper: the table `claims.toml`, whose head explains its keys.

use super::rule::Rule;
use serde::Deserialize;
use std::{collections::BTreeMap, sync::OnceLock};

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

/// The contents of `claims.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// Rules that claims refer to by name.
    rules: BTreeMap<String, Rule>,
    claim: Vec<Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    id: String,
    label: String,
    quantity: String,
    number: Option<String>,
    formula: Option<String>,
    statement: Option<String>,
    rule: Option<String>,
    instead: Option<String>,
    open: Option<String>,
    same: Option<String>,
    #[serde(default)]
    why: String,
}

/// The claims in a text like that of `claims.toml`.
pub fn read(text: &str) -> Result<Vec<Claim>, String> {
    let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
    file.claim.into_iter().map(|row| row.claim(&file.rules)).collect()
}

impl Row {
    fn claim(self, named: &BTreeMap<String, Rule>) -> Result<Claim, String> {
        let Self { id, label, quantity, number, formula, statement, rule, instead, open, same, why } = self;
        let fault = |why: &str| format!("{id}: {why}");
        let section = id.strip_prefix('s').and_then(|rest| rest.chars().next()).and_then(|digit| digit.to_digit(10));
        let section = section.ok_or_else(|| fault("an id begins with s and a section"))?;
        let (kind, paper) = match (number, formula, statement) {
            (Some(paper), None, None) => (Kind::Number, paper),
            (None, Some(paper), None) => (Kind::Formula, paper),
            (None, None, Some(paper)) => (Kind::Statement, paper),
            _ => return Err(fault("one of number, formula and statement")),
        };
        let read = |rule: &str| match named.get(rule) {
            Some(rule) => Ok(rule.clone()),
            None => rule.parse().map_err(|why: String| fault(&why)),
        };
        let rule = match (kind, rule) {
            (Kind::Number, None) => read(&format!("rounds to {paper}"))?,
            (Kind::Number, Some(_)) => return Err(fault("the rule of a number is its digits")),
            (_, Some(rule)) => read(&rule)?,
            (_, None) => return Err(fault("no rule")),
        };
        let instead = instead.as_deref().map(read).transpose()?;
        if open.is_some() && instead.is_none() {
            return Err(fault("what is left open needs the rule of our value, `instead`"));
        }
        Ok(Claim { id, section, label, quantity, kind, paper, rule, instead, open, same, why })
    }
}
