//! Branches of orbits in reports: points, bifurcations, the end, and the branch that crosses.

use super::options::options;
use crate::{
    error::{Error, Result},
    orbits::End,
    report::{Digits::Short, Line, Report, Rows},
};
use serde_json::{Value, json};

/// The tables of a branch that crosses the one that was asked for: points and bifurcations.
pub(super) const SWITCHED: [&str; 2] = ["switched-branch", "switched-bifurcations"];

/// A branch that crosses another one at the bifurcation of a number or, in words, why none was
/// followed.
pub(super) type Switched<B> = Option<(usize, std::result::Result<B, String>)>;

options! {
    /// How long a branch is, and the one that crosses it.
    #[derive(Copy, PartialEq, Eq)]
    pub struct BranchOptions {
        /// Points of the branch at most.
        max_points: usize = 200, "N";
        /// Follow the branch that crosses at bifurcation K, too.
        ///
        /// A period doubling, for orbits of the doubled period, or a branch point; bifurcations are
        /// numbered from 1 as they are printed. It ends as the first branch does, or where orbits
        /// of doubled period come back to those of half the period.
        switch: Option<usize> = None, "K", (1 or more);
    }
}

/// The branch that crosses another one at its bifurcation `number`. Without such a branch, the
/// reason in words: the branch that is known is a result all the same.
pub(super) fn crossing<B>(number: usize, found: Result<B>) -> Result<Switched<B>> {
    match found {
        Err(stopped @ Error::Stopped { .. }) => Err(stopped),
        found => Ok(Some((number, found.map_err(|error| error.to_string())))),
    }
}

/// The branch that crosses, if one was followed, and the number of its bifurcation.
pub(super) fn crossed<B>(switched: &Switched<B>) -> Option<(usize, &B)> {
    switched.as_ref().and_then(|(number, other)| Some((*number, other.as_ref().ok()?)))
}

/// A branch and, if it was followed, the one that crosses it.
pub(super) fn followed<'a, B>(branch: &'a B, switched: &'a Switched<B>) -> impl Iterator<Item = &'a B> {
    std::iter::once(branch).chain(crossed(switched).map(|(_, other)| other))
}

/// The numbers of bifurcations, by which a branch that crosses is asked for.
pub(super) fn numbered<B>(table: Rows<'_, B>) -> Rows<'_, B> {
    table.counted("number", Short, "")
}

/// An orbit of a branch, and the point with its multipliers if these are known.
pub(super) type Told<'a, O, P> = (&'a O, Option<&'a P>);

/// The rows of a branch: its points and, if the process was asked to end before their multipliers
/// were known, also its other orbits, `later`.
pub(super) fn told<'a, O, P>(
    points: &'a [P],
    orbit: impl Fn(&'a P) -> &'a O,
    later: &'a [O],
    end: End,
) -> Vec<Told<'a, O, P>> {
    let later = if end == End::Stopped { later } else { &[] };
    points.iter().map(|point| (orbit(point), Some(point))).chain(later.iter().map(|orbit| (orbit, None))).collect()
}

/// The orbits of a branch are a result also if the process was asked to end while it was followed.
pub(super) fn kept<T>(followed: Result<T>) -> Result<()> {
    match followed {
        Err(Error::Stopped { .. }) => Ok(()),
        followed => followed.map(|_| ()),
    }
}

/// How a branch ended, in words.
pub(super) fn ended(points: usize, bifurcations: usize, end: End) -> String {
    let none = match (end, bifurcations) {
        (End::Stopped, 0) => ", bifurcations were not located",
        (End::Stopped, _) => ", further bifurcations were not located",
        (_, 0) => ", no bifurcation",
        _ => "",
    };
    format!("{points} points{none}; the branch ended: {}.", end.words())
}

/// Adds a branch, whose fields are those of the report. One that crosses another at its bifurcation
/// `at` has the field `switched` for them.
pub(super) fn tell<P, B>(
    report: Report,
    at: Option<usize>,
    (points, bifurcations): (Rows<'_, P>, Rows<'_, B>),
    mut facts: Value,
    (end, unresolved): (End, usize),
) -> Report {
    let [points, bifurcations] = [points.key("").done(), bifurcations.key("").done()];
    let [all, found] = [&points, &bifurcations].map(|table| table.json());
    let mut words = ended(all.len(), found.len(), end);
    if unresolved > 0 {
        words += &format!(" Places with bifurcations that were not located one by one: {unresolved}.");
    }
    for (name, fact) in
        [("end", json!(end)), ("unresolved", json!(unresolved)), ("points", all.into()), ("bifurcations", found.into())]
    {
        facts[name] = fact;
    }
    let report = match (at, facts) {
        (None, Value::Object(facts)) => facts.into_iter().fold(report, |report, (name, fact)| report.fact(&name, fact)),
        (at, mut facts) => {
            facts["at"] = json!(at);
            report.fact("switched", facts)
        }
    };
    let heading = at.map_or(String::new(), |at| format!("The branch that crosses at bifurcation {at}:"));
    report.words(heading).table(points).table(bifurcations).words(words)
}

/// Says what is missing: a branch answers if it reached its end or turned back, or came back to the
/// branch of half its period.
pub(super) fn checked<B>(report: Report, branch: &B, switched: &Switched<B>, end: impl Fn(&B) -> End) -> Report {
    let short = followed(branch, switched).map(end).find(|end| !end.is_complete());
    let report = report.failure(short.map(|end| format!("the branch ended: {}", end.words())));
    match switched {
        Some((at, Err(why))) => report.fact("switched", json!({ "failure": why, "at": at })).failure(Some(why.clone())),
        _ => report,
    }
}

/// The points of a branch, its bifurcations, and the points of the branch that crosses it.
pub(super) fn lines<'a, P: 'a>(
    branch: &'a [P],
    other: Option<&'a [P]>,
    place: impl Fn(&'a P) -> (f64, f64),
    stable: impl Fn(&'a P) -> bool,
    marks: impl IntoIterator<Item = (f64, f64)>,
) -> Vec<Line> {
    let mut lines = stability_lines(branch, &place, &stable);
    lines.push(Line::new("bifurcation", marks));
    let other = other.map(|points| stability_lines(points, &place, &stable)).unwrap_or_default();
    lines.extend(other.into_iter().map(|line| Line { name: line.name + ", switched", ..line }));
    lines
}

/// Points as two lines of a picture, one for stable and one for unstable ones.
pub(super) fn stability_lines<'a, P: 'a>(
    points: &'a [P],
    place: impl Fn(&'a P) -> (f64, f64),
    stable: impl Fn(&'a P) -> bool,
) -> Vec<Line> {
    let chosen = |wanted: bool| points.iter().filter(|point| stable(point) == wanted).map(&place).collect::<Vec<_>>();
    [("stable", true), ("unstable", false)].map(|(name, wanted)| Line::new(name, chosen(wanted))).to_vec()
}

/// The branch that crosses, with its bifurcation, number of orbits and end, for a caption.
pub(super) fn from(other: Option<(usize, usize, End)>) -> String {
    let words =
        |(at, orbits, end): (usize, usize, End)| format!(" From bifurcation {at}: {orbits} orbits; {}.", end.words());
    other.map_or(String::new(), words)
}
