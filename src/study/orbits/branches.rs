//! Branches of orbits: their options, files and work, and what reports have of them: points,
//! bifurcations, the end, and the branch that crosses.

use crate::study::{
    Progress, Proving, ResultUnits, Study, Work, keeper::Autosave, options::options, part, run::state_arrays, segments,
    si::Scale,
};
use crate::{
    chain::State,
    error::{Error, NOTHING, Result},
    number::counted,
    orbits::{AnalysisLevel, Bifurcation, BifurcationKind, Branch, End, Point, Problem, Range},
    output::{Archive, Array, SETTINGS},
    report::{Line, Panel, Report, Rows, Short},
    scene::{Quantity, Scene, SceneFile, Units},
    sweep::Engine,
};
use hertzchain_proofs::certificate::Certificate;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::{Value, json};
use std::{
    fmt::Debug,
    iter::repeat,
    path::{Path, PathBuf},
};

/// Share of the progress of a branch for its orbits; the rest is for multipliers and bifurcations.
pub(crate) const ORBITS: f64 = 0.4;
/// Share of the progress of a branch that is proved before the proof.
const PROVED: f64 = 0.3;
/// Largest step as a share of the range of the parameter, if none is given.
const STEP: f64 = 0.05;

/// The tables of a branch that crosses the one that was asked for: points and bifurcations.
pub(crate) const SWITCHED: [&str; 2] = ["switched-branch", "switched-bifurcations"];
/// The file and the store of such a branch.
const SWITCHED_NAMES: [&str; 2] = ["switched-branch.npz", "switched-spectra.store"];
/// All files of such a branch but its store.
pub(crate) const SWITCHED_FILES: [&str; 3] = ["switched-branch.csv", "switched-bifurcations.csv", SWITCHED_NAMES[0]];

/// Words on the file and the store of a branch, and on further files.
macro_rules! files_of_branch {
    ($file:literal, $store:literal, $more:literal) => {
        concat!(
            $file,
            " has every orbit, and is written every 20 points or 10 s as well. ",
            $more,
            $store,
            " has what was found about them, from which the same command goes on. Each part of --shard follows the \
             branch itself and computes its share of this."
        )
    };
}
pub(crate) use files_of_branch;

/// A branch that crosses another one at the bifurcation of a number or, in words, why none was
/// followed.
pub(crate) type Switched<B> = Option<(usize, std::result::Result<B, String>)>;

options! {
    /// What every branch asks for.
    #[derive(PartialEq)]
    pub struct BranchOptions {
        /// Value of the parameter at which the branch ends.
        ///
        /// It begins with that of the scene or of other options.
        to: Option<f64> = None, "P", (finite);
        /// Largest change of the parameter from point to point.
        ///
        /// By default a twentieth of the range, of dark breathers a hundredth.
        step: Option<f64> = None, "DP", (positive);
        /// Points of the branch at most.
        ///
        /// With those of a branch that is resumed.
        max_points: usize = 1000, "N", (2 or more);
        /// Compute multipliers, or not (=false).
        ///
        /// On by default where they take less time than the orbits: not of dark breathers.
        multipliers: Option<bool> = None, "BOOL";
        /// Go on with what this file, or the file in this folder, has kept.
        ///
        /// A file of a branch, from its last point: to another --to, by another --step; then
        /// multipliers and bifurcations are computed anew. The results are written beside it unless
        /// --out says where.
        resume: Option<PathBuf> = None, "PATH";
    }
}

options! {
    /// What a branch of a scene asks for about its bifurcations.
    #[derive(Copy, PartialEq, Eq)]
    pub struct BifurcationOptions {
        /// Locate bifurcations, or not (=false).
        ///
        /// They need multipliers. On by default where they take less time than the orbits: not of
        /// normal modes.
        bifurcations: Option<bool> = None, "BOOL";
        /// Follow the branch that crosses at bifurcation K, too.
        ///
        /// A period doubling, for orbits of the doubled period, or a branch point; bifurcations are
        /// numbered from 1 as they are printed. It ends as the first branch does, or where orbits
        /// of doubled period come back to those of half the period. Its files are
        /// switched-branch.csv, switched-bifurcations.csv and switched-branch.npz.
        switch: Option<usize> = None, "K", (1 or more);
    }
}

impl BranchOptions {
    /// What is found about a branch.
    ///
    /// # Errors
    /// Bifurcations without multipliers; a number outside its range.
    pub(crate) fn level<P: Kept>(&self, more: BifurcationOptions) -> Result<AnalysisLevel> {
        more.within_ranges()?;
        let bifurcations = more.bifurcations.or(more.switch.map(|_| true));
        match (self.multipliers, bifurcations) {
            (Some(false), Some(true)) => Err(Error::parameter("bifurcations", true, "they need --multipliers")),
            (Some(false), _) => Ok(AnalysisLevel::Orbits),
            (_, Some(true)) => Ok(AnalysisLevel::Bifurcations),
            (None, _) if P::USUAL == AnalysisLevel::Orbits => Ok(P::USUAL),
            (_, None) if P::USUAL == AnalysisLevel::Bifurcations => Ok(P::USUAL),
            _ => Ok(AnalysisLevel::Multipliers),
        }
    }

    /// What `make` makes of the last value and the largest step, of this quantity, in the units of
    /// the chain. A refusal has them as they were given.
    fn read<T>(
        &self,
        (si, quantity): (Option<&Units>, Quantity),
        make: impl FnOnce(Option<f64>, Option<f64>) -> Result<T>,
    ) -> Result<T> {
        let (scale, &Self { to, step, .. }) = (Scale(si), self);
        let [a, b] = [to, step].map(|given| given.map(|value| scale.read(quantity, value)));
        scale.given(make(a, b), &[("to", to), ("step", step)])
    }

    /// The same for a branch that begins with the value `from`.
    pub(crate) fn continuation<P>(
        &self,
        units: (Option<&Units>, Quantity),
        from: f64,
        make: impl FnOnce(f64, f64) -> Result<P>,
    ) -> Result<P> {
        self.within_ranges()?;
        self.read(units, |to, step| {
            let to = to.ok_or_else(|| Error::parameter("--to", NOTHING, "a branch needs a value at which it ends"))?;
            make(to, step.unwrap_or(STEP * (to - from).abs()))
        })
    }

    /// The branch of a file that goes on.
    fn resumed<P: Kept>(&self, path: &Path, results: ResultUnits) -> Result<Begun<P>> {
        let path = if path.is_dir() { &*path.join(P::NAMES[0]) } else { path };
        let (about, branch) = load_branch::<P>(path)?;
        let units = P::units(&about);
        let quantity = branch.continuation.quantity(&branch.setting);
        let branch = self.read((units.as_ref(), quantity), |to, step| branch.onward(to, step, self.max_points))?;
        Ok((about, branch, units.filter(|_| !results.dimensionless)))
    }
}

/// A branch with what a report needs of its scene, and the units of the report.
pub type Begun<P> = (<P as Kept>::About, Branch<P>, Option<Units>);

/// A command that follows a branch.
pub trait FollowCommand {
    /// The kind of orbits.
    type Problem: Kept;

    /// The options of the branch, of its bifurcations and of units.
    fn options(&self) -> (&BranchOptions, BifurcationOptions, ResultUnits);
    /// A new branch, of which the work finds the first orbit.
    ///
    /// # Errors
    /// Numbers outside their rules.
    fn first(&self) -> Result<Work<'_, Begun<Self::Problem>>>;
    /// A branch from a file as further options say.
    ///
    /// # Errors
    /// An end outside its rule.
    fn with_options(&self, branch: Branch<Self::Problem>) -> Result<Branch<Self::Problem>> {
        Ok(branch)
    }
    /// Whether the branch is to be proved, of kinds of orbits that can be.
    fn proving(&self) -> Option<&Proving> {
        None
    }
    /// The cosine sums near the orbits of a branch that is to be proved.
    ///
    /// # Errors
    /// An integration that fails; numbers that are not exact.
    fn near(&self, _branch: &Branch<Self::Problem>) -> Result<Vec<Certificate>> {
        Ok(Vec::new())
    }
    /// The branch, and the one that crosses it if it is asked for. All options are checked before
    /// the work.
    ///
    /// # Errors
    /// Numbers outside their rules; a file that is no branch.
    fn follow(&self) -> Result<Work<'_, BranchStudy<Self::Problem>>> {
        let (options, more, si) = self.options();
        options.within_ranges()?;
        let level = options.level::<Self::Problem>(more)?;
        let first = match &options.resume {
            None => self.first()?,
            Some(path) => {
                let (about, branch, si) = options.resumed(path, si)?;
                let branch = self.with_options(branch)?;
                Box::new(move |_: &Engine, _: Progress<'_>| Ok((about, branch, si)))
            }
        };
        Ok(Box::new(move |engine, progress| begun(first, level, more.switch, engine, progress)))
    }
}

impl<C: FollowCommand> Study for C {
    const FILES: &'static str = C::Problem::FILES;
    const INTERRUPTIBLE: bool = true;
    const SWEEPS: bool = true;

    fn optional_files() -> Vec<String> {
        C::Problem::OPTIONAL.iter().map(ToString::to_string).collect()
    }

    fn outline() -> Option<Report> {
        Some(C::Problem::outline())
    }

    fn begin(&self) -> Result<Work<'_>> {
        let work = self.follow()?;
        let proving = self.proving().filter(|proving| proving.prove);
        proving.map(Proving::file).transpose()?;
        let orbits = if proving.is_some() { PROVED } else { 1.0 };
        // Without multipliers the strips of the proof are what shards and ranks have to share.
        let (options, more, _) = self.options();
        let strips = proving.is_some() && options.level::<C::Problem>(more)? == AnalysisLevel::Orbits;
        Ok(Box::new(move |engine, progress| {
            let alone = engine.alone();
            let study = work(if strips { &alone } else { engine }, &part(progress, 0.0, orbits))?;
            let report = study.report()?;
            match proving {
                Some(proving) if study.branch.ended() != End::Stopped || engine.its_shard().is_some() => {
                    proving.added_of_branch(report, &self.near(&study.branch)?, engine, &part(progress, orbits, 1.0))
                }
                _ => Ok(report),
            }
        }))
    }

    /// The folder of the branch that is gone on with, unless it is one that crosses another.
    fn default_folder(&self) -> Option<PathBuf> {
        let path = self.options().0.resume.as_deref()?;
        (!path.ends_with(SWITCHED_NAMES[0])).then(|| folder_of(path))
    }
}

/// The folder `path` or, if `path` is a file, the folder that has it.
pub(crate) fn folder_of(path: &Path) -> PathBuf {
    if path.is_dir() {
        return path.to_owned();
    }
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned()
}

/// A kind of orbits whose branches are kept while they are followed.
pub trait Kept: Problem {
    /// What a report needs of the scene.
    type About: Clone + Debug;
    /// What the file has of the setting and of this.
    type Source: Serialize + DeserializeOwned;
    /// Names of the file, of the store of multipliers, and of the command.
    const NAMES: [&'static str; 3];
    /// Words on these and on further files, for the help.
    const FILES: &'static str;
    /// Names of files that only some branches have.
    const OPTIONAL: &'static [&'static str] = &[];
    /// What is found about a branch unless something else is asked for.
    const USUAL: AnalysisLevel = AnalysisLevel::Bifurcations;
    /// Share of the progress after which the first orbit is found.
    const FIRST: f64 = 0.0;

    /// What the file has of a branch, and arrays for the readers of the file.
    fn source(about: &Self::About, branch: &Branch<Self>) -> (Self::Source, Vec<Array<'static>>);
    /// What a report needs, and the setting, of a branch that begins at such a bifurcation.
    ///
    /// # Errors
    /// The rule that a number breaks.
    fn made(source: Self::Source, birth: Option<BifurcationKind>) -> Result<(Self::About, Self::Setting)>;
    /// The units of the scene, if it has some.
    fn units(_about: &Self::About) -> Option<Units> {
        None
    }
    /// The kind of number that the parameter is.
    fn quantity(&self, _setting: &Self::Setting) -> Quantity {
        Quantity::Number
    }
    /// The report without rows.
    fn outline() -> Report;
    /// The report.
    ///
    /// # Errors
    /// Errors of the archive writer.
    fn report(study: &BranchStudy<Self>) -> Result<Report>;
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
pub(crate) fn alone<P: Kept>(continuation: P, setting: &P::Setting, point: Point<P>) -> Result<Branch<P>> {
    let p = continuation.solution(setting, &point.orbit).p;
    // The branch has ended, as near as it can.
    let continuation = continuation.with_range(Range { to: p.next_up(), step: STEP * p.abs(), most_points: 2 });
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

/// What the file of a branch has of its scene.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSource {
    /// The scene as TOML.
    scene: String,
    /// Periods of the drive in one of an orbit.
    pub(crate) turns: u32,
}

impl SceneSource {
    /// What the file has of a scene, and the arrays of the states at the start of the orbits.
    pub(crate) fn of(
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

    pub(crate) fn scene(&self) -> Result<Scene> {
        SceneFile::parse(&self.scene, SETTINGS).and_then(Scene::build)
    }
}

/// Continues a branch, unless it has ended, keeps it meanwhile, and finds what is asked for about
/// it. `second`: whether it crosses another one. The orbits are a result also if the process was
/// asked to end meanwhile.
pub(crate) fn followed<P: Kept>(
    (about, si): (&P::About, Option<&Units>),
    mut branch: Branch<P>,
    second: bool,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<Branch<P>> {
    let [file, _] = names::<P>(second);
    // Files that an earlier run may have left: they belong to another branch.
    let stale = if second { Vec::new() } else { stale::<P>()? };
    let mut keeper = Autosave::new(segments::folder(engine), file, stale);
    if branch.end.is_none() {
        let (back, to) = (branch.back, branch.continuation.range().to);
        let quantity = branch.continuation.quantity(&branch.setting);
        let extended = branch.extend(|branch| {
            keeper.keep(branch.orbits.len(), branch.end.is_some(), || branch_npz(about, branch));
            let Some(p) = branch.orbits.last().map(|last| branch.parameter(last)) else { return };
            let share = ((p - back) / (to - back)).clamp(0.0, 1.0);
            let (count, name, p) = (branch.orbits.len(), branch.continuation.name(), Scale(si).shown(quantity, p, 6));
            progress(ORBITS * share, &format!("point {count}, {name} = {p}"));
        });
        keeper.keep(branch.orbits.len(), branch.end.is_some(), || branch_npz(about, &branch));
        extended.map(drop).or_else(|why| if matches!(why, Error::Stopped { .. }) { Ok(()) } else { Err(why) })?;
    }
    analysed(about, branch, second, engine, progress)
}

/// Names of the file and of the store of a branch, or of one that crosses it.
fn names<P: Kept>(second: bool) -> [&'static str; 2] {
    if second { SWITCHED_NAMES } else { [P::NAMES[0], P::NAMES[1]] }
}

/// Finds what is asked for about a branch.
pub(crate) fn analysed<P: Kept>(
    about: &P::About,
    branch: Branch<P>,
    second: bool,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<Branch<P>> {
    let [_, store] = names::<P>(second);
    // The largest number of points has no influence on those that there are.
    let range = Range { most_points: 0, ..branch.continuation.range() };
    let Branch { weak, birth, level, .. } = branch;
    let source = P::source(about, &branch).0;
    let settings = json!([source, branch.continuation.with_range(range), weak, birth, level]);
    segments::analysed(branch, [store, P::NAMES[2]], &settings, engine, &part(progress, ORBITS, 1.0))
}

/// Names of the files of a branch and of one that crosses it, but for its own file.
fn stale<P: Kept>() -> Result<Vec<String>> {
    let names: Vec<String> = P::outline().files()?.into_iter().map(|(name, _)| name).collect();
    let pictures = names.iter().filter_map(|name| Some(format!("{}.png", name.strip_suffix(".json")?)));
    let optional = P::OPTIONAL.iter().map(ToString::to_string);
    Ok(pictures.chain(optional).chain(names.clone()).filter(|name| name != P::NAMES[0]).collect())
}

/// A branch of which `first` finds the first orbit, and the one that crosses it at bifurcation
/// number `switch`, if one is asked for. Without such a branch there is the reason in words: the
/// branch that is known is a result all the same.
fn begun<P: Kept>(
    first: Work<'_, Begun<P>>,
    level: AnalysisLevel,
    switch: Option<usize>,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<BranchStudy<P>> {
    let (scene, branch, si) = first(engine, &part(progress, 0.0, P::FIRST))?;
    let middle = if switch.is_some() { 0.5 * (P::FIRST + 1.0) } else { 1.0 };
    let work =
        |branch, second, progress: Progress<'_>| followed((&scene, si.as_ref()), branch, second, engine, progress);
    let branch = work(Branch { level, ..branch }, false, &part(progress, P::FIRST, middle))?;
    let switched = match switch.filter(|_| branch.ended() != End::Stopped) {
        None => None,
        Some(number) => {
            let crossing = branch.switched(number.wrapping_sub(1));
            match crossing.and_then(|other| work(other, true, &part(progress, middle, 1.0))) {
                Err(stopped @ Error::Stopped { .. }) => return Err(stopped),
                found => Some((number, found.map_err(|error| error.to_string()))),
            }
        }
    };
    Ok(BranchStudy { scene, branch, switched, si })
}

/// A branch of orbits. All of its numbers are dimensionless; `si` is for its report.
#[derive(Clone, Debug)]
pub struct BranchStudy<P: Kept> {
    /// The scene, or what a report needs of it.
    pub scene: P::About,
    /// The branch.
    pub branch: Branch<P>,
    /// Number of a bifurcation of the branch, from 1 on, and the branch that crosses there or, in
    /// words, why none was followed.
    pub switched: Switched<Branch<P>>,
    /// The units of the scene, if the report is in SI units.
    pub si: Option<Units>,
}

impl<P: Kept> BranchStudy<P> {
    /// The report.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn report(&self) -> Result<Report> {
        P::report(self)
    }
}

/// The branch that crosses, if one was followed, and the number of its bifurcation.
pub(crate) fn crossed<B>(switched: &Switched<B>) -> Option<(usize, &B)> {
    switched.as_ref().and_then(|(number, other)| Some((*number, other.as_ref().ok()?)))
}

/// A branch and, if it was followed, the one that crosses it, with the number of its bifurcation.
pub(crate) fn both<'a, B>(branch: &'a B, switched: &'a Switched<B>) -> impl Iterator<Item = (Option<usize>, &'a B)> {
    [(None, branch)].into_iter().chain(crossed(switched).map(|(at, other)| (Some(at), other)))
}

/// The numbers of bifurcations, by which a branch that crosses is asked for.
pub(crate) fn numbered<P: Problem>(table: Rows<'_, Bifurcation<P>>) -> Rows<'_, Bifurcation<P>> {
    table.counted("number", Short, "")
}

/// An orbit of a branch, with what is known about it.
pub(crate) struct BranchRow<'a, P: Problem> {
    pub(crate) orbit: &'a P::Orbit,
    pub(crate) measures: Option<&'a P::Measures>,
    pub(crate) spectrum: Option<&'a P::Spectrum>,
}

/// The rows of a branch: its points and, if their multipliers were not asked for or are not known
/// yet, also its other orbits.
pub(crate) fn rows<P: Problem>(branch: &Branch<P>) -> Vec<BranchRow<'_, P>> {
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
pub(crate) fn shows<P: Problem>(branch: &Branch<P>) -> bool {
    rows(branch).iter().any(|row| row.measures.is_some())
}

/// How a branch ended, in words.
pub(crate) fn ended<P: Problem>(branch: &Branch<P>) -> String {
    let (end, points) = (branch.ended(), rows(branch).len());
    let none = match (branch.bifurcations.is_empty(), end) {
        _ if branch.level < AnalysisLevel::Bifurcations => "",
        (true, End::Stopped) => ", bifurcations were not located",
        (false, End::Stopped) => ", further bifurcations were not located",
        (true, _) => ", no bifurcation",
        _ => "",
    };
    format!("{}{none}; the branch ended: {}.", counted(points, "point"), end.words())
}

/// Adds a branch of a scene, whose fields are those of the report, and its file. One that crosses
/// another at its bifurcation `at` has the field `switched` for them.
pub(crate) fn tell<P: Kept>(
    report: Report,
    scene: &P::About,
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
    let ([file, _], bytes) = (names::<P>(at.is_some()), branch_npz(scene, branch)?);
    Ok(report.words(heading).table(points).table(bifurcations).words(words).file(file, bytes))
}

/// Orbits without multipliers, in words.
pub(crate) fn gaps<P: Problem>(branch: &Branch<P>) -> String {
    let places: Vec<String> = branch.gaps.iter().map(|p| format!("{p:.8}")).collect();
    match places.len() {
        0 => String::new(),
        _ => format!(" Orbits without multipliers at {} = {}.", branch.continuation.name(), places.join(", ")),
    }
}

/// Says what is missing: a branch is complete if it reached its end or turned back, or came back to
/// the branch of half its period.
pub(crate) fn checked<P: Problem>(report: Report, branch: &Branch<P>, switched: &Switched<Branch<P>>) -> Report {
    let short = both(branch, switched).map(|(_, branch)| branch.ended()).find(|end| !end.is_complete());
    let report = report.failure(short.map(|end| format!("the branch ended: {}", end.words())));
    match switched {
        Some((at, Err(why))) => report.fact("switched", json!({ "failure": why, "at": at })).failure(Some(why.clone())),
        _ => report,
    }
}

/// The points of a branch and of the one that crosses it, and the bifurcations of both.
pub(crate) fn lines<'a, P: Problem>(
    branch: &'a Branch<P>,
    switched: &'a Switched<Branch<P>>,
    place: impl Fn(&BranchRow<'a, P>) -> (f64, f64),
    stable: impl Fn(&P::Spectrum) -> bool,
    mark: impl Fn(&'a Bifurcation<P>) -> (f64, f64),
) -> Vec<Line> {
    // Stable and unstable orbits and, if there are any, those of which neither is known.
    let of = |branch: &'a Branch<P>| {
        let of = |row: &&BranchRow<'a, P>, wanted| row.spectrum.map(&stable) == wanted;
        let (rows, kinds) = (rows(branch), [("stable", Some(true)), ("unstable", Some(false)), ("orbits", None)]);
        let line = |(name, wanted)| Line::new(name, rows.iter().filter(|row| of(row, wanted)).map(&place));
        kinds.map(line).into_iter().filter(|line| line.name != "orbits" || !line.points.is_empty()).collect::<Vec<_>>()
    };
    let mut lines = of(branch);
    let marks = both(branch, switched).flat_map(|(_, branch)| &branch.bifurcations);
    lines.insert(2, Line::new("bifurcation", marks.map(mark)));
    let other = crossed(switched).map(|(_, other)| of(other));
    lines.extend(other.into_iter().flatten().map(|line| Line { name: line.name + ", switched", ..line }));
    lines
}

/// The panels that have a point.
pub(crate) fn filled(panels: impl IntoIterator<Item = Panel>) -> Vec<Panel> {
    let point = |line: &Line| line.points.iter().any(|(x, y)| x.is_finite() && y.is_finite());
    panels.into_iter().filter(|panel| panel.lines.iter().any(point)).collect()
}

/// The branch that crosses, with its bifurcation, number of orbits and end, for a caption.
pub(crate) fn from<P: Problem>(switched: &Switched<Branch<P>>) -> String {
    crossed(switched).map_or(String::new(), |(at, branch)| {
        format!(" From bifurcation {at}: {} orbits; {}.", branch.points.len(), branch.ended().words())
    })
}
