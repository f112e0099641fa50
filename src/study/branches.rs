//! Branches of orbits: their options, files and work, and what reports have of them: points,
//! bifurcations, the end, and the branch that crosses.

use super::{
    InSi, Progress, Work, folder_of, keeper::Autosave, options::options, run::state_arrays, segments, si::Scale,
};
use crate::{
    chain::State,
    error::{Error, Result},
    orbits::{Asked, Bifurcation, BifurcationKind, Branch, End, Point, Problem, Range, Stored},
    output::{Archive, Array, SETTINGS},
    report::{Digits::Short, Line, Panel, Report, Rows},
    scene::{Quantity, Scene, SceneFile, Units},
    sweep::Engine,
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::{Value, json};
use std::{
    iter::repeat,
    path::{Path, PathBuf},
};

/// Share of the progress of a branch for its orbits; the rest is for multipliers and bifurcations.
pub(super) const ORBITS: f64 = 0.4;
/// Largest step as a share of the range of the parameter, if none is given.
pub(super) const STEP: f64 = 0.05;

/// The tables of a branch that crosses the one that was asked for: points and bifurcations.
pub(super) const SWITCHED: [&str; 2] = ["switched-branch", "switched-bifurcations"];
/// The file of such a branch.
pub(super) const SWITCHED_FILE: &str = "switched-branch.npz";

/// A branch that crosses another one at the bifurcation of a number or, in words, why none was
/// followed.
pub(super) type Switched<B> = Option<(usize, std::result::Result<B, String>)>;

options! {
    /// What every branch asks for.
    #[derive(PartialEq)]
    pub struct BranchOptions {
        /// Value of the parameter at which the branch ends.
        ///
        /// It begins with that of the scene or of other options.
        to: Option<f64> = None, "P", (finite);
        /// Largest change of the parameter from point to point [default: a twentieth of the range].
        step: Option<f64> = None, "DP", (positive);
        /// Points of the branch at most.
        ///
        /// With those of a branch that is resumed.
        max_points: usize = 1000, "N", (2 or more);
        /// Compute multipliers, or not (=false).
        ///
        /// On by default where they take less time than the orbits: not of dark breathers.
        multipliers: Option<bool> = None, "BOOL", [arg(require_equals = true, num_args = 0..=1, default_missing_value = "true", hide_possible_values = true)];
        /// Go on with what this file, or the file in this folder, has kept.
        ///
        /// A file of a branch, from its last point: to another --to, by another --step; then
        /// multipliers and bifurcations are computed anew. The results are written beside it unless
        /// --out says where.
        resume: Option<PathBuf> = None, "PATH";
    }
}

options! {
    /// What a branch with bifurcations asks for.
    #[derive(Copy, PartialEq, Eq)]
    pub struct BifurcationOptions {
        /// Locate bifurcations, or not (=false).
        ///
        /// They need multipliers. On by default where they take less time than the orbits: not of
        /// normal modes.
        bifurcations: Option<bool> = None, "BOOL", [arg(require_equals = true, num_args = 0..=1, default_missing_value = "true", hide_possible_values = true)];
        /// Follow the branch that crosses at bifurcation K, too.
        ///
        /// A period doubling, for orbits of the doubled period, or a branch point; bifurcations are
        /// numbered from 1 as they are printed. It ends as the first branch does, or where orbits
        /// of doubled period come back to those of half the period.
        switch: Option<usize> = None, "K", (1 or more);
    }
}

/// The value of the parameter at which the branch ends was not given.
pub(super) fn without_end() -> Error {
    Error::parameter("to", "nothing", "a branch needs a value at which it ends")
}

impl BifurcationOptions {
    /// Whether bifurcations are asked for, if the options say so.
    pub(super) fn wanted(self) -> Option<bool> {
        self.bifurcations.or(self.switch.map(|_| true))
    }
}

impl BranchOptions {
    /// What is asked for, of a kind of branches for which one of these is usual.
    pub(super) fn asked(&self, bifurcations: Option<bool>, usual: Asked) -> Result<Asked> {
        match (self.multipliers, bifurcations) {
            (Some(false), Some(true)) => Err(Error::parameter("bifurcations", true, "they need --multipliers")),
            (Some(false), _) => Ok(Asked::Orbits),
            (_, Some(true)) => Ok(Asked::Bifurcations),
            (None, _) if usual == Asked::Orbits => Ok(usual),
            (_, None) if usual == Asked::Bifurcations => Ok(usual),
            _ => Ok(Asked::Multipliers),
        }
    }

    /// The options in the units of the chain, if `to` and `step` are of this quantity.
    pub(super) fn read(&self, scale: Scale<'_>, quantity: Quantity) -> Self {
        let read = |value: f64| scale.read(quantity, value);
        Self { to: self.to.map(read), step: self.step.map(read), ..self.clone() }
    }

    /// A refusal of a number with its value as it was given.
    pub(super) fn as_given<T>(&self, si: Option<&Units>, result: Result<T>) -> Result<T> {
        Scale(si).given(result, &[("to", self.to), ("step", self.step)])
    }

    /// The branch that is gone on with, and what its file has of its setting.
    pub(super) fn resumed<P: Kept>(&self) -> Option<Result<(P::About, Branch<P>)>> {
        let path = self.resume.as_ref()?;
        if let Err(why) = self.within_ranges() {
            return Some(Err(why));
        }
        Some(load_branch(&if path.is_dir() { path.join(P::NAMES[0]) } else { path.clone() }))
    }

    /// Goes on with a branch of a scene.
    pub(super) fn go_on<P: OfScene + 'static>(
        &self,
        (scene, branch): (Scene, Branch<P>),
        more: BifurcationOptions,
        si: InSi,
        report: impl FnOnce(&BranchStudy<P>) -> Result<Report> + 'static,
    ) -> Result<Work<'static>> {
        more.within_ranges()?;
        let si = si.units(&scene)?;
        let read = self.read(Scale(si.as_ref()), branch.continuation.quantity(&branch.setting));
        let branch = self.as_given(si.as_ref(), branch.onward(read.to, read.step, read.max_points))?;
        let branch = Branch { asked: self.asked(more.wanted(), P::USUAL)?, ..branch };
        Ok(Box::new(move |engine, progress| report(&of_scene(scene, branch, si, more.switch, engine, progress)?)))
    }

    /// The folder of the branch that is gone on with, unless it is one that crosses another.
    pub(super) fn default_folder(&self) -> Option<PathBuf> {
        self.resume.as_deref().filter(|path| !path.ends_with(SWITCHED_FILE)).map(folder_of)
    }
}

/// A kind of orbits whose branches are kept while they are followed.
pub trait Kept: Stored {
    /// What a report needs besides the branch.
    type About;
    /// What the file has of the setting and of this.
    type Source: Serialize + DeserializeOwned;
    /// Names of the file, of the store of multipliers, and of the study.
    const NAMES: [&'static str; 3];
    /// The same of a branch that crosses another one.
    const CROSSING: [&'static str; 3] = Self::NAMES;
    /// What is found about a branch unless something else is asked for.
    const USUAL: Asked = Asked::Bifurcations;

    /// What the file has of a branch, and arrays for the readers of the file.
    fn source(about: &Self::About, branch: &Branch<Self>) -> (Self::Source, Vec<Array<'static>>);
    /// What a report needs, and the setting, of a branch that begins at such a bifurcation.
    ///
    /// # Errors
    /// The rule that a number breaks.
    fn made(source: Self::Source, birth: Option<BifurcationKind>) -> Result<(Self::About, Self::Setting)>;
    /// The report without rows.
    fn outline() -> Report;
}

/// The bytes of the file of a branch.
///
/// # Errors
/// Errors of the archive writer.
pub fn branch_npz<P: Kept>(about: &P::About, branch: &Branch<P>) -> Result<Vec<u8>> {
    let (source, more) = P::source(about, branch);
    branch.npz_of(source, more)
}

/// A single orbit as a branch, which `--resume` may continue to another end.
pub(super) fn alone<P: Kept>(continuation: P, setting: &P::Setting, point: Point<P>) -> Result<Branch<P>> {
    let (p, range) = (continuation.solution(setting, &point.orbit).p, continuation.range());
    // The branch has ended, as near as it can.
    let continuation =
        continuation.with_range(Range { to: p.next_up(), step: STEP * p.abs(), most_points: 2, ..range });
    let branch = Branch::new(continuation, setting.clone(), point.orbit.clone())?;
    Ok(Branch { end: Some(End::Reached), points: vec![point], ..branch })
}

/// Reads a branch: the orbits have the bits they had when written; their Newton steps are not in
/// the file.
///
/// # Errors
/// A file that cannot be read; [`Error::Content`], with the place and the rule, for a file with
/// another structure or version, or with numbers outside their rules.
pub fn load_branch<P: Kept>(path: &Path) -> Result<(P::About, Branch<P>)> {
    let file = Archive::read(path)?;
    let (about, branch) = branch_from_archive(&file)?;
    Ok((about, branch.verified(&file)?))
}

/// Reads a branch from an archive, with all checks that need no integration; [`load_branch`] checks
/// in addition that the orbits return.
///
/// # Errors
/// As [`load_branch`].
pub fn branch_from_archive<P: Kept>(file: &Archive) -> Result<(P::About, Branch<P>)> {
    Branch::read(file, P::made)
}

/// A kind of orbits of a scene.
pub trait OfScene: Kept<About = Scene, Source = SceneSource> {
    /// The kind of number that the parameter is.
    fn quantity(&self, setting: &Self::Setting) -> Quantity;
}

/// What the file of a branch has of its scene.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSource {
    /// The scene as TOML.
    scene: String,
    /// Periods of the drive in one of an orbit.
    pub(super) turns: u32,
}

impl SceneSource {
    /// What the file has of a scene, and the arrays of the states at the start of the orbits.
    pub(super) fn of(
        scene: &Scene,
        turns: u32,
        starts: impl Iterator<Item = State<f64>>,
    ) -> (Self, Vec<Array<'static>>) {
        let states: Vec<_> = starts.map(|state| state_arrays(scene, state.as_slice(), None)).collect();
        let named = states.first().into_iter().flatten().enumerate().filter(|(_, (_, values))| !values.is_empty());
        let arrays =
            named.map(|(k, (name, _))| Array::matrix(name, states.iter().map(|arrays| arrays[k].1.as_slice())));
        let arrays = arrays.collect();
        (Self { scene: scene.file().to_toml(), turns }, arrays)
    }

    /// The scene.
    pub(super) fn scene(&self) -> Result<Scene> {
        SceneFile::parse(&self.scene, SETTINGS).and_then(Scene::build)
    }
}

/// Continues a branch, unless it has ended, keeps it meanwhile, and finds what is asked for about
/// it. `second`: whether it crosses another one; `shown` is the parameter of an orbit as it is
/// told. The orbits are a result also if the process was asked to end meanwhile.
pub(super) fn followed<P: Kept>(
    about: &P::About,
    mut branch: Branch<P>,
    second: bool,
    shown: impl Fn(&P::Orbit, f64) -> String,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<Branch<P>> {
    let [file, ..] = if second { P::CROSSING } else { P::NAMES };
    // Files that an earlier run may have left: they belong to another branch.
    let stale = if second { Vec::new() } else { stale::<P>()? };
    let mut keeper = Autosave::new(segments::folder(engine), file, stale);
    if branch.end.is_none() {
        let (back, to) = (branch.back, branch.continuation.range().to);
        let extended = branch.extend(|branch| {
            keeper.keep(branch.orbits.len(), branch.end.is_some(), || branch_npz(about, branch));
            let Some(last) = branch.orbits.last() else { return };
            let p = branch.parameter(last);
            let share = ((p - back) / (to - back)).clamp(0.0, 1.0);
            let (count, name) = (branch.orbits.len(), branch.continuation.name());
            progress(ORBITS * share, &format!("point {count}, {name} = {}", shown(last, p)));
        });
        keeper.keep(branch.orbits.len(), branch.end.is_some(), || branch_npz(about, &branch));
        extended.map(drop).or_else(|why| if matches!(why, Error::Stopped { .. }) { Ok(()) } else { Err(why) })?;
    }
    analysed(about, branch, second, engine, progress)
}

/// Finds what is asked for about a branch.
pub(super) fn analysed<P: Kept>(
    about: &P::About,
    branch: Branch<P>,
    second: bool,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<Branch<P>> {
    let [_, store, study] = if second { P::CROSSING } else { P::NAMES };
    // The largest number of points has no influence on those that there are.
    let range = Range { most_points: 0, ..branch.continuation.range() };
    let Branch { weak, birth, bounded, asked, .. } = branch;
    let source = P::source(about, &branch).0;
    let settings = json!([source, branch.continuation.with_range(range), weak, birth, bounded, asked]);
    segments::analysed(branch, [store, study], &settings, engine, progress)
}

/// Names of the files of a branch and of one that crosses it, but for its own file.
fn stale<P: Kept>() -> Result<Vec<String>> {
    let names: Vec<String> = P::outline().files()?.into_iter().map(|(name, _)| name).collect();
    let pictures = names.iter().filter_map(|name| Some(format!("{}.png", name.strip_suffix(".json")?)));
    let crossing = SWITCHED.map(|name| format!("{name}.csv")).into_iter().chain([SWITCHED_FILE.to_owned()]);
    Ok(pictures.chain(crossing).chain(names.clone()).filter(|name| name != P::NAMES[0]).collect())
}

/// A branch of orbits of a scene, and the one that crosses it at bifurcation number `switch`, if
/// one is asked for.
pub(super) fn of_scene<P: OfScene>(
    scene: Scene,
    branch: Branch<P>,
    si: Option<Units>,
    switch: Option<usize>,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<BranchStudy<P>> {
    let quantity = branch.continuation.quantity(&branch.setting);
    let shown = |_: &P::Orbit, p: f64| Scale(si.as_ref()).shown(quantity, p, 6);
    let work = |branch, second, progress: Progress<'_>| followed(&scene, branch, second, shown, engine, progress);
    let (branch, switched) = with_switched(branch, switch, work, progress)?;
    Ok(BranchStudy { scene, branch, switched, si })
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

/// An orbit of a branch, with what is known about it.
pub(super) struct BranchRow<'a, P: Problem> {
    pub(super) orbit: &'a P::Orbit,
    pub(super) measures: Option<&'a P::Measures>,
    pub(super) spectrum: Option<&'a P::Spectrum>,
}

/// The rows of a branch: its points and, if their multipliers were not asked for or are not known
/// yet, also its other orbits.
pub(super) fn rows<P: Problem>(branch: &Branch<P>) -> Vec<BranchRow<'_, P>> {
    let known = if branch.points.is_empty() { 0 } else { branch.points.len() + branch.gaps.len() };
    let points = branch.points.iter().map(|Point { orbit, spectrum, measures }| BranchRow {
        orbit,
        measures: Some(measures),
        spectrum: Some(spectrum),
    });
    let measured = branch.measured.iter().map(Option::as_ref).chain(repeat(None));
    let later = branch.orbits[known..].iter().zip(measured);
    points.chain(later.map(|(orbit, measures)| BranchRow { orbit, measures, spectrum: None })).collect()
}

/// Whether anything was measured of the orbits, so that there is a picture.
pub(super) fn shows<P: Problem>(branch: &Branch<P>) -> bool {
    rows(branch).iter().any(|row| row.measures.is_some())
}

/// How a branch ended, in words.
pub(super) fn ended<P: Problem>(branch: &Branch<P>) -> String {
    let (end, points) = (branch.ended(), rows(branch).len());
    let none = match (branch.bifurcations.is_empty(), end) {
        _ if branch.asked < Asked::Bifurcations => "",
        (true, End::Stopped) => ", bifurcations were not located",
        (false, End::Stopped) => ", further bifurcations were not located",
        (true, _) => ", no bifurcation",
        _ => "",
    };
    format!("{points} points{none}; the branch ended: {}.", end.words())
}

/// Adds a branch of a scene, whose fields are those of the report, and its file. One that crosses
/// another at its bifurcation `at` has the field `switched` for them.
pub(super) fn tell<P: OfScene>(
    report: Report,
    scene: &Scene,
    (at, branch): (Option<usize>, &Branch<P>),
    (points, bifurcations): (Rows<'_, BranchRow<'_, P>>, Rows<'_, Bifurcation<P>>),
    mut facts: Value,
) -> Result<Report> {
    let (end, unresolved) = (branch.ended(), branch.unresolved);
    let [points, bifurcations] = [points.key("").done(), bifurcations.key("").done()];
    let [all, found] = [&points, &bifurcations].map(|table| table.json());
    let mut words = ended(branch);
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
    let [file, ..] = if at.is_some() { P::CROSSING } else { P::NAMES };
    let file = (file, branch_npz(scene, branch)?);
    Ok(report.words(heading).table(points).table(bifurcations).words(words).file(file.0, file.1))
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
    place: impl Fn(&BranchRow<'a, P>) -> (f64, f64),
    stable: impl Fn(&P::Spectrum) -> bool,
    mark: impl Fn(&'a Bifurcation<P>) -> (f64, f64),
) -> Vec<Line> {
    let of = |branch| stability_lines(&rows(branch), &place, |row| row.spectrum.map(&stable));
    let mut lines = of(branch);
    let marks = both(branch, switched).flat_map(|(_, branch)| &branch.bifurcations);
    lines.insert(2, Line::new("bifurcation", marks.map(mark)));
    let other = crossed(switched).map(|(_, other)| of(other));
    lines.extend(other.into_iter().flatten().map(|line| Line { name: line.name + ", switched", ..line }));
    lines
}

/// Points as lines of a picture: stable and unstable ones and, if there are any, those of which
/// neither is known.
pub(super) fn stability_lines<T>(
    points: &[T],
    place: impl Fn(&T) -> (f64, f64),
    stable: impl Fn(&T) -> Option<bool>,
) -> Vec<Line> {
    let chosen = |wanted| points.iter().filter(|point| stable(point) == wanted).map(&place).collect::<Vec<_>>();
    let lines = [("stable", Some(true)), ("unstable", Some(false)), ("orbits", None)];
    let lines = lines.map(|(name, wanted)| Line::new(name, chosen(wanted))).into_iter();
    lines.filter(|line| line.name != "orbits" || !line.points.is_empty()).collect()
}

/// The panels that have a point.
pub(super) fn filled(panels: impl IntoIterator<Item = Panel>) -> Vec<Panel> {
    let point = |line: &Line| line.points.iter().any(|(x, y)| x.is_finite() && y.is_finite());
    panels.into_iter().filter(|panel| panel.lines.iter().any(point)).collect()
}

/// The branch that crosses, with its bifurcation, number of orbits and end, for a caption.
pub(super) fn from<P: Problem>(switched: &Switched<Branch<P>>) -> String {
    crossed(switched).map_or(String::new(), |(at, branch)| {
        format!(" From bifurcation {at}: {} orbits; {}.", branch.points.len(), branch.ended().words())
    })
}
