//! Branches of orbits in reports: points, bifurcations, the end, and the branch that crosses.

use super::{Progress, options::options};
use crate::{
    error::{Error, Result},
    orbits::{Bifurcation, Branch, End, Point, Problem},
    report::{Digits::Short, Line, Report, Rows},
    scene::{Scene, Units},
};
use serde_json::{Value, json};

/// Share of the progress of a branch for its orbits; the rest is for multipliers and bifurcations.
pub(super) const ORBITS: f64 = 0.4;

/// The tables of a branch that crosses the one that was asked for: points and bifurcations.
pub(super) const SWITCHED: [&str; 2] = ["switched-branch", "switched-bifurcations"];

/// Called with the branch so far after every new point, to write it to a file.
pub(super) type Keep<'a, P> = &'a mut dyn FnMut(&Branch<P>);

/// A branch that crosses another one at the bifurcation of a number or, in words, why none was
/// followed.
pub(super) type Switched<B> = Option<(usize, std::result::Result<B, String>)>;

options! {
    /// How long a branch is, and the one that crosses it.
    #[derive(Copy, PartialEq, Eq)]
    pub struct BranchOptions {
        /// Points of the branch at most.
        max_points: usize = 200, "N", (2 or more);
        /// Follow the branch that crosses at bifurcation K, too.
        ///
        /// A period doubling, for orbits of the doubled period, or a branch point; bifurcations are
        /// numbered from 1 as they are printed. It ends as the first branch does, or where orbits
        /// of doubled period come back to those of half the period.
        switch: Option<usize> = None, "K", (1 or more);
    }
}

/// Continues a branch, unless it has ended. The orbits are a result also if the process was asked
/// to end meanwhile. `shown` is the parameter of an orbit as it is told.
pub(super) fn followed<P: Problem>(
    mut branch: Branch<P>,
    keep: Keep<'_, P>,
    shown: impl Fn(&P::Orbit, f64) -> String,
    progress: Progress<'_>,
) -> Result<Branch<P>> {
    if branch.end.is_some() {
        return Ok(branch);
    }
    let (back, to) = (branch.back, branch.continuation.range().to);
    let extended = branch.extend(|branch| {
        keep(branch);
        let Some(last) = branch.orbits.last() else { return };
        let p = branch.parameter(last);
        let share = ((p - back) / (to - back)).clamp(0.0, 1.0);
        let (count, name) = (branch.orbits.len(), branch.continuation.name());
        progress(ORBITS * share, &format!("point {count}, {name} = {}", shown(last, p)));
    });
    keep(&branch);
    match extended {
        Err(Error::Stopped { .. }) => Ok(branch),
        extended => extended.map(|_| branch),
    }
}

/// A branch and the one that crosses it at bifurcation number `switch`, if one is asked for, each
/// made by `work`, which is told whether it is the second one. Without such a branch there is the
/// reason in words: the branch that is known is a result all the same.
pub(super) fn with_switched<P: Problem>(
    branch: Branch<P>,
    switch: Option<usize>,
    work: impl Fn(Branch<P>, bool, Progress<'_>) -> Result<Branch<P>>,
    progress: Progress<'_>,
) -> Result<(Branch<P>, Switched<Branch<P>>)> {
    let whole = if switch.is_some() { 0.5 } else { 1.0 };
    let branch = work(branch, false, &|share, what| progress(whole * share, what))?;
    let Some(number) = switch.filter(|_| branch.ended() != End::Stopped) else { return Ok((branch, None)) };
    let second = |share: f64, what: &str| progress(0.5 + 0.5 * share, what);
    match branch.switched(number.wrapping_sub(1)).and_then(|other| work(other, true, &second)) {
        Err(stopped @ Error::Stopped { .. }) => Err(stopped),
        found => Ok((branch, Some((number, found.map_err(|error| error.to_string()))))),
    }
}

/// A branch of orbits of a scene. All of its numbers are dimensionless; `si` is for its report.
#[derive(Clone, Debug)]
pub struct BranchStudy<P: Problem> {
    /// The scene.
    pub scene: Scene,
    /// The branch.
    pub branch: Branch<P>,
    /// Number of a bifurcation of the branch, from 1 on, and the branch that crosses there or, in
    /// words, why none was followed.
    pub switched: Switched<Branch<P>>,
    /// The units of the scene, if the report is in SI units.
    pub si: Option<Units>,
}

/// The branch that crosses, if one was followed, and the number of its bifurcation.
pub(super) fn crossed<B>(switched: &Switched<B>) -> Option<(usize, &B)> {
    switched.as_ref().and_then(|(number, other)| Some((*number, other.as_ref().ok()?)))
}

/// A branch and, if it was followed, the one that crosses it, with the number of its bifurcation.
pub(super) fn both<'a, B>(branch: &'a B, switched: &'a Switched<B>) -> impl Iterator<Item = (Option<usize>, &'a B)> {
    [(None, branch)].into_iter().chain(crossed(switched).map(|(at, other)| (Some(at), other)))
}

/// The numbers of bifurcations, by which a branch that crosses is asked for.
pub(super) fn numbered<P: Problem>(table: Rows<'_, Bifurcation<P>>) -> Rows<'_, Bifurcation<P>> {
    table.counted("number", Short, "")
}

/// An orbit of a branch, and the point with its multipliers if these are known.
pub(super) type BranchRow<'a, P> = (&'a <P as Problem>::Orbit, Option<&'a Point<P>>);

/// The rows of a branch: its points and, if the process was asked to end before their multipliers
/// were known, also its other orbits.
pub(super) fn rows<P: Problem>(branch: &Branch<P>) -> Vec<BranchRow<'_, P>> {
    let later = &branch.orbits[branch.points.len() + branch.gaps.len()..];
    let later = if branch.ended() == End::Stopped { later } else { &[] };
    let points = branch.points.iter().map(|point| (&point.orbit, Some(point)));
    points.chain(later.iter().map(|orbit| (orbit, None))).collect()
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
pub(super) fn tell<P: Problem>(
    report: Report,
    at: Option<usize>,
    branch: &Branch<P>,
    (points, bifurcations): (Rows<'_, BranchRow<'_, P>>, Rows<'_, Bifurcation<P>>),
    mut facts: Value,
) -> Report {
    let (end, unresolved) = (branch.ended(), branch.unresolved);
    let [points, bifurcations] = [points.key("").done(), bifurcations.key("").done()];
    let [all, found] = [&points, &bifurcations].map(|table| table.json());
    let mut words = ended(all.len(), found.len(), end);
    if unresolved > 0 {
        words += &format!(" Places with bifurcations that were not located one by one: {unresolved}.");
    }
    words += &gaps(branch);
    for (name, fact) in
        [("end", json!(end)), ("unresolved", json!(unresolved)), ("points", all.into()), ("bifurcations", found.into())]
    {
        facts[name] = fact;
    }
    let report = match (at, facts) {
        (None, facts) => report.facts(facts),
        (at, mut facts) => {
            facts["at"] = json!(at);
            report.fact("switched", facts)
        }
    };
    let heading = at.map_or(String::new(), |at| format!("The branch that crosses at bifurcation {at}:"));
    report.words(heading).table(points).table(bifurcations).words(words)
}

/// Orbits without multipliers, in words.
pub(super) fn gaps<P: Problem>(branch: &Branch<P>) -> String {
    let places: Vec<String> = branch.gaps.iter().map(|p| format!("{p:.8}")).collect();
    match places.len() {
        0 => String::new(),
        _ => format!(" Orbits without multipliers at {} = {}.", branch.continuation.name(), places.join(", ")),
    }
}

/// Says what is missing: a branch is complete if it reached its end or turned back, or came back to
/// the branch of half its period.
pub(super) fn checked<P: Problem>(report: Report, branch: &Branch<P>, switched: &Switched<Branch<P>>) -> Report {
    let short = both(branch, switched).map(|(_, branch)| branch.ended()).find(|end| !end.is_complete());
    let report = report.failure(short.map(|end| format!("the branch ended: {}", end.words())));
    match switched {
        Some((at, Err(why))) => report.fact("switched", json!({ "failure": why, "at": at })).failure(Some(why.clone())),
        _ => report,
    }
}

/// The points of a branch and of the one that crosses it, and the bifurcations of both.
pub(super) fn lines<'a, P: Problem>(
    branch: &'a Branch<P>,
    switched: &'a Switched<Branch<P>>,
    place: impl Fn(&'a Point<P>) -> (f64, f64),
    stable: impl Fn(&'a Point<P>) -> bool,
    mark: impl Fn(&'a Bifurcation<P>) -> (f64, f64),
) -> Vec<Line> {
    let mut lines = stability_lines(&branch.points, &place, &stable);
    let marks = both(branch, switched).flat_map(|(_, branch)| &branch.bifurcations);
    lines.push(Line::new("bifurcation", marks.map(mark)));
    let other = crossed(switched).map(|(_, other)| stability_lines(&other.points, &place, &stable));
    lines.extend(other.into_iter().flatten().map(|line| Line { name: line.name + ", switched", ..line }));
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
pub(super) fn from<P: Problem>(switched: &Switched<Branch<P>>) -> String {
    crossed(switched).map_or(String::new(), |(at, branch)| {
        format!(" From bifurcation {at}: {} orbits; {}.", branch.points.len(), branch.ended().words())
    })
}
