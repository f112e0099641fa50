//! Branches of orbits in reports: points, bifurcations, the end, and the branch that crosses.

use crate::{
    orbits::End,
    report::{Digits::Short, Line, Report, Rows},
};
use serde_json::{Value, json};

/// Adds a branch, whose fields are those of the report. One that crosses another at its bifurcation
/// `at` has the field `switched` for them.
pub(super) fn tell<P, B>(
    report: Report,
    at: Option<usize>,
    (points, bifurcations): (Rows<'_, P>, Rows<'_, B>),
    mut facts: Value,
    end: End,
) -> Report {
    let [points, bifurcations] = [points.key("").done(), bifurcations.key("").done()];
    let [all, found] = [&points, &bifurcations].map(|table| table.json());
    let none = match (end, found.is_empty()) {
        (End::Stopped, _) => "bifurcations were not located",
        (_, true) => "no bifurcation",
        (_, false) => "",
    };
    let unresolved = match facts["unresolved"].as_u64() {
        None | Some(0) => String::new(),
        Some(count) => format!("; stretches with several bifurcations that were not separated: {count}"),
    };
    let end = format!("{} points; the branch ended: {}{unresolved}", all.len(), end.words());
    facts["points"] = all.into();
    facts["bifurcations"] = found.into();
    let report = match (at, facts) {
        (None, Value::Object(facts)) => facts.into_iter().fold(report, |report, (name, fact)| report.fact(&name, fact)),
        (at, mut facts) => {
            facts["at"] = json!(at);
            report.fact("switched", facts)
        }
    };
    let heading = at.map_or(String::new(), |at| format!("The branch that crosses at bifurcation {at}:"));
    report.words(heading).table(points).table(bifurcations).words(none).words(end)
}

/// Says why no branch was followed that crosses another one where it was asked for.
pub(super) fn not_crossed<B>(report: Report, switched: Option<&(usize, Result<B, String>)>) -> Report {
    match switched {
        Some((at, Err(why))) => report.fact("switched", json!({ "failure": why, "at": at })).failure(Some(why.clone())),
        _ => report,
    }
}

/// The numbers of bifurcations, by which a branch that crosses is asked for.
pub(super) fn numbered<B>(table: Rows<'_, B>) -> Rows<'_, B> {
    table.counted("number", Short, "")
}

/// The points of a branch, its bifurcations, and the points of the branch that crosses it.
pub(super) fn lines<'a, P: 'a>(
    branch: &'a [P],
    other: Option<&'a [P]>,
    place: impl Fn(&'a P) -> (f64, f64),
    stable: impl Fn(&'a P) -> bool,
    marks: impl IntoIterator<Item = (f64, f64)>,
) -> Vec<Line> {
    let mut lines = super::stability_lines(branch, &place, &stable);
    lines.push(Line::new("bifurcation", marks));
    let other = other.map(|points| super::stability_lines(points, &place, &stable)).unwrap_or_default();
    lines.extend(other.into_iter().map(|line| Line { name: line.name + ", switched", ..line }));
    lines
}

/// The branch that crosses, with its bifurcation, number of orbits and end, for a caption.
pub(super) fn from(other: Option<(usize, usize, &str)>) -> String {
    other.map_or(String::new(), |(at, orbits, end)| format!(" From bifurcation {at}: {orbits} orbits; {end}."))
}
