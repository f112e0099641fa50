//! Claims and our values side by side.

use super::{
    claims::{Claim, Kind, claims},
    quantities::quantities,
};
use crate::{
    error::{Error, Result},
    named::named,
    study::Progress,
    sweep::Engine,
};
use std::time::{Duration, Instant};

named! {
    /// The result of comparing a claim with our value.
    pub enum Verdict {
        /// Our number agrees with the printed one.
        Agrees = "agrees",
        /// Our number does not agree: a misprint, or a rough statement.
        Differs = "differs",
        /// The statement is true.
        Holds = "holds",
        /// The statement is false.
        Fails = "fails",
        /// The paper does not give the information that would decide.
        NotDecidable = "not decidable",
    }
}

/// A claim of the paper and our value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item<'a> {
    /// The claim.
    pub claim: &'a Claim,
    /// Our value.
    pub value: f64,
}

impl Item<'_> {
    fn say(&self, good: bool) -> Verdict {
        match (self.claim.kind, good) {
            _ if self.claim.open.is_some() => Verdict::NotDecidable,
            (Kind::Number | Kind::Formula, true) => Verdict::Agrees,
            (Kind::Number | Kind::Formula, false) => Verdict::Differs,
            (Kind::Statement, true) => Verdict::Holds,
            (Kind::Statement, false) => Verdict::Fails,
        }
    }

    /// The verdict that follows from our value.
    pub fn verdict(&self) -> Verdict {
        self.say(self.claim.rule.met_by(self.value))
    }

    /// The verdict that is known from earlier computations.
    pub fn expected(&self) -> Verdict {
        self.say(self.claim.instead.is_none())
    }

    /// Whether the verdict is the expected one and, where the claim is known to be false or cannot
    /// be decided, our value obeys the rule given instead.
    pub fn as_expected(&self) -> bool {
        self.verdict() == self.expected() && self.claim.instead.as_ref().is_none_or(|rule| rule.met_by(self.value))
    }

    /// Our value with the digits that matter.
    pub fn shown(&self) -> String {
        self.claim.instead.as_ref().unwrap_or(&self.claim.rule).show(self.value)
    }
}

/// Items of one section or of all sections.
#[derive(Clone, Debug)]
pub struct Verification {
    /// Items in the order of the paper.
    pub items: Vec<Item<'static>>,
    /// Wall time of the computation.
    pub wall: Duration,
}

impl Verification {
    /// The items whose verdict or value is not the expected one.
    pub fn unexpected(&self) -> impl Iterator<Item = &Item<'static>> {
        self.items.iter().filter(|item| !item.as_expected())
    }

    /// Number of claims that differ or fail. A misprint that several claims repeat counts once.
    pub fn misprints(&self) -> usize {
        let wrong = |item: &&Item| matches!(item.verdict(), Verdict::Differs | Verdict::Fails);
        let mut first: Vec<&str> = self
            .items
            .iter()
            .filter(wrong)
            .map(|item| item.claim.same.as_ref().unwrap_or(&item.claim.id).as_str())
            .collect();
        first.sort_unstable();
        first.dedup();
        first.len()
    }

    /// Number of claims of a kind with the given verdict.
    pub fn count(&self, kind: Kind, verdict: Verdict) -> usize {
        self.items.iter().filter(|item| item.claim.kind == kind && item.verdict() == verdict).count()
    }
}

/// Computes the quantities of a section, or of all sections, and compares them with the claims.
///
/// The numbers of a group that shares its runs are a point: in a folder of the engine they are kept
/// as soon as they are computed. `progress` is told the share done.
///
/// # Errors
/// A section without claims; a run that fails, after all other points were computed; a store of
/// another version, or one that was altered.
pub fn verify(section: Option<u32>, engine: &Engine, progress: Progress<'_>) -> Result<Verification> {
    let clock = Instant::now();
    let claims = of_section(section)?;
    let items = pair(claims.into_iter(), &quantities(section, engine, progress)?);
    Ok(Verification { items, wall: clock.elapsed() })
}

/// The claims of a section, or all.
pub(super) fn of_section(section: Option<u32>) -> Result<Vec<&'static Claim>> {
    let of = |claim: &&Claim| section.is_none_or(|section| section == claim.section);
    let found: Vec<&Claim> = claims().iter().filter(of).collect();
    match section.filter(|_| found.is_empty()) {
        Some(section) => {
            let rule = "a section of the paper that has items: 2, 3, 4, 5, 6, 7 or 8";
            Err(Error::parameter("section", section, rule))
        }
        None => Ok(found),
    }
}

/// Each claim with its value.
///
/// # Panics
/// If the ids of both are not the same, in the same order.
pub fn pair<'a>(claims: impl Iterator<Item = &'a Claim>, quantities: &[(impl AsRef<str>, f64)]) -> Vec<Item<'a>> {
    let claims: Vec<&Claim> = claims.collect();
    let (said, computed): (Vec<&str>, Vec<&str>) = (
        claims.iter().map(|claim| claim.id.as_str()).collect(),
        quantities.iter().map(|(id, _)| id.as_ref()).collect(),
    );
    assert_eq!(said, computed, "each claim has its quantity");
    claims.into_iter().zip(quantities).map(|(claim, (_, value))| Item { claim, value: *value }).collect()
}
