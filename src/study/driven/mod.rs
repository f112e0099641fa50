//! Orbits of a driven scene under the stroboscopic map: one with its multipliers, or a branch with
//! its bifurcations.

mod file;
mod report;

use super::{
    Changes, InSi, Progress, Study, Work,
    branches::{self, BranchOptions, BranchStudy, SWITCHED},
    keeper::Autosave,
    options::options,
    segments,
    si::Scale,
};
use crate::{
    chain::DriveKind,
    error::{Error, Result},
    orbits::{
        DriveParameter, DrivenBranch, DrivenContinuation, DrivenOrbit, DrivenPoint, DrivenSetting, DrivenShooting,
        Problem,
    },
    report::Report,
    scene::{Quantity, Scene, Units},
    sweep::Engine,
};
pub use file::{driven_branch_from_archive, driven_branch_npz, load_driven_branch};
pub(crate) use report::multipliers_panel;
use serde_json::json;
use std::path::PathBuf;

options! {
    /// The orbit of a driven scene.
    pub struct Driven {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// The scene must have a `[[drive]]`: harmonics of one frequency, with or without a ramp.
        /// The orbit is that of the drive at its full height.
        scene: String = "granular-crystal".to_owned();
        /// Changes to the scene.
        changes: Changes = Changes::default(), [command(flatten)];
        /// The search.
        search: DrivenSearch = DrivenSearch::default(), [command(flatten)];
        /// The units of options and results.
        si: InSi = InSi::default(), [command(flatten)];
    }
}

impl Driven {
    fn load(&self) -> Result<Scene> {
        Scene::load_with(&self.scene, &self.changes.set)
    }
}

options! {
    /// The search for the orbit to which a driven scene leads.
    #[derive(Copy, PartialEq, Eq)]
    pub struct DrivenSearch {
        /// Periods of the drive in a period of the orbit.
        ///
        /// 2 for orbits of doubled period.
        turns: u32 = 1, "M", (1 to 64);
        /// Periods of the orbit for which the scene runs before the search.
        ///
        /// After its ramp. The search starts from the state that the scene has then; it starts
        /// earlier if the scene has become periodic.
        settle: u32 = 300, "K", (0 to 1_000_000);
    }
}

impl DrivenSearch {
    fn setting(&self, scene: &Scene) -> Result<DrivenSetting> {
        self.within_ranges()?;
        DrivenSetting::new(scene.chain(), self.turns)
    }

    fn orbit(&self, scene: &Scene, setting: &DrivenSetting, progress: Progress<'_>) -> Result<DrivenOrbit> {
        let shooting = DrivenShooting::default();
        let seen = |share: f64| progress(share, "the scene settles");
        let seed = shooting.settle(setting, scene.chain(), scene.initial(), self.settle, seen)?;
        shooting.solve(setting, &seed)
    }
}

/// An orbit of a driven scene with its multipliers, samples and energy balance. All of its numbers
/// are dimensionless; `si` is for its [`Report`](super::Report).
#[derive(Clone, Debug)]
pub struct DrivenStudy {
    /// The scene.
    pub scene: Scene,
    /// The orbit with its multipliers.
    pub point: DrivenPoint,
    /// States at 64 times of each period of the drive.
    pub samples: Vec<Vec<f64>>,
    /// Work of the drives over the orbit.
    pub driven: f64,
    /// Energy that is dissipated over the orbit.
    pub dissipated: f64,
    /// The units of the scene, if the report is in SI units.
    pub si: Option<Units>,
}

impl Study for Driven {
    const FILES: &'static str = "driven-orbit.csv has the displacements of all beads over a period.";
    const INTERRUPTIBLE: bool = true;

    fn outline() -> Option<Report> {
        Some(Report::new("driven-orbit").table(report::multipliers(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = self.load()?;
        self.si.units(&scene)?;
        self.search.setting(&scene)?;
        Ok(Box::new(move |_, progress| Ok(driven_orbit(scene, &self.search, self.si, progress)?.report())))
    }
}

/// The orbit to which a driven scene leads. `progress` is told the share done.
///
/// # Errors
/// A scene without a periodic drive, or without the units that are asked for; an orbit that is not
/// found; a signal.
pub fn driven_orbit(scene: Scene, search: &DrivenSearch, si: InSi, progress: Progress<'_>) -> Result<DrivenStudy> {
    let si = si.units(&scene)?;
    let orbit = search.orbit(&scene, &search.setting(&scene)?, progress)?;
    Ok(DrivenStudy { si, ..DrivenStudy::new(scene, orbit)? })
}

impl DrivenStudy {
    /// Computes multipliers, samples and energy balance of an orbit.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    pub fn new(scene: Scene, orbit: DrivenOrbit) -> Result<Self> {
        let shooting = DrivenShooting::default();
        let samples = orbit.samples(&shooting)?;
        let ledger = samples.last().and_then(|state| orbit.setting.chain().ok()?.layout().ledger(state));
        let (driven, dissipated) = ledger.map_or((0.0, 0.0), |ledger| (ledger.driven, ledger.dissipated()));
        Ok(Self { point: DrivenPoint::new(orbit, &shooting)?, scene, samples, driven, dissipated, si: None })
    }
}

options! {
    /// A branch of orbits of a driven scene.
    pub struct DrivenContinue {
        /// The scene.
        driven: Driven = Driven::default(), [command(flatten)];
        /// The way.
        way: DrivenWay = DrivenWay::default(), [command(flatten)];
        /// Go on with what this file, or the file in this folder, has kept.
        ///
        /// A file driven-branch.npz or switched-branch.npz, from its last point: to another --to,
        /// by another --step; then multipliers and bifurcations are computed anew. Results of a
        /// file driven-branch.npz are written beside it unless --out says where. The file is the
        /// same with and without --si, and goes on with either.
        resume: Option<PathBuf> = None, "PATH",
            [arg(conflicts_with_all = ["scene", "set", "turns", "settle", "vary"])];
    }
}

options! {
    /// The way of a branch of driven orbits.
    #[derive(Copy, PartialEq)]
    pub struct DrivenWay {
        /// What varies along the branch.
        vary: DriveParameter = DriveParameter::Amplitude, "P";
        /// Value of the parameter at which the branch ends.
        ///
        /// It begins with the scene's own value (with 1 for `damping`).
        to: Option<f64> = None, "P", (finite), [arg(required_unless_present = "resume")];
        /// Largest change of the parameter from point to point [default: a twentieth of the range].
        step: Option<f64> = None, "DP", (positive);
        /// What every branch asks for.
        branch: BranchOptions = BranchOptions::default(), [command(flatten)];
    }
}

/// A branch of a driven scene.
pub type DrivenBranchStudy = BranchStudy<DrivenContinuation>;

/// Names of the files in which branches are kept, and from which they are continued.
const BRANCH_FILE: &str = "driven-branch.npz";
const SWITCHED_FILE: &str = "switched-branch.npz";
/// Names of the stores of their multipliers.
const STORE: &str = "driven-spectra.store";
const SWITCHED_STORE: &str = "switched-spectra.store";

impl Study for DrivenContinue {
    const FILES: &'static str = "driven-branch.npz has every orbit. With --switch also switched-branch.csv, switched-bifurcations.csv and \
                                 switched-branch.npz; the npz files are written every 20 points or 10 s as well. \
                                 driven-spectra.store and switched-spectra.store have multipliers and bifurcations, from which the same command goes on. \
                                 Each part of --shard follows the first branch itself and computes its share of these.";
    const INTERRUPTIBLE: bool = true;
    const SWEEPS: bool = true;

    fn optional_files() -> Vec<String> {
        SWITCHED.map(|name| format!("{name}.csv")).into_iter().chain([SWITCHED_FILE.to_owned()]).collect()
    }

    fn outline() -> Option<Report> {
        Some(report::outline())
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.way.within_ranges()?;
        self.way.branch.within_ranges()?;
        let Some(path) = &self.resume else {
            let scene = self.driven.load()?;
            let Driven { search, si, .. } = &self.driven;
            self.way.for_scene(&scene, search, *si)?;
            return Ok(Box::new(move |engine, progress| {
                driven_branch(scene, search, &self.way, *si, engine, progress)?.report()
            }));
        };
        let file = if path.is_dir() { path.join(BRANCH_FILE) } else { path.clone() };
        let (scene, branch) = load_driven_branch(&file)?;
        let si = self.driven.si.units(&scene)?;
        let parameter = branch.continuation.parameter;
        let way = self.way.read(Scale(si.as_ref()), parameter, &branch.setting);
        let branch = self.way.as_given(si, branch.onward(way.to, way.step, way.branch.max_points))?;
        Ok(Box::new(move |engine, progress| followed(scene, branch, si, way.branch.switch, engine, progress)?.report()))
    }

    fn default_folder(&self) -> Option<PathBuf> {
        let path = self.resume.as_deref()?;
        (path.is_dir() || path.ends_with(BRANCH_FILE)).then(|| super::folder_of(path))
    }
}

/// The kind of number that a parameter of a drive is.
fn quantity(parameter: DriveParameter, setting: &DrivenSetting) -> Quantity {
    match (parameter, setting.drive_kind()) {
        (DriveParameter::Amplitude, DriveKind::Displacement) => Quantity::Length,
        (DriveParameter::Amplitude, DriveKind::Force) => Quantity::Force,
        (DriveParameter::Omega, _) => Quantity::Omega,
        (DriveParameter::Damping, _) => Quantity::Number,
    }
}

impl DrivenWay {
    /// The way in the units of the chain, of one that was given for a branch in `parameter`.
    fn read(&self, scale: Scale<'_>, parameter: DriveParameter, setting: &DrivenSetting) -> Self {
        let read = |value: f64| scale.read(quantity(parameter, setting), value);
        Self { to: self.to.map(read), step: self.step.map(read), ..*self }
    }

    /// A refusal of a number with its value as it was given.
    fn as_given<T>(&self, si: Option<Units>, result: Result<T>) -> Result<T> {
        let &Self { to, step, .. } = self;
        Scale(si.as_ref()).given(result, &[("to", to), ("step", step)])
    }

    /// The continuation from a scene, and the units in which it was given and is reported.
    fn for_scene(
        &self,
        scene: &Scene,
        search: &DrivenSearch,
        si: InSi,
    ) -> Result<(DrivenSetting, DrivenContinuation, Option<Units>)> {
        self.within_ranges()?;
        self.branch.within_ranges()?;
        let si = si.units(scene)?;
        let setting = search.setting(scene)?;
        let read = self.read(Scale(si.as_ref()), self.vary, &setting);
        let continuation = self.as_given(si, read.continuation(&setting))?;
        Ok((setting, continuation, si))
    }

    /// The continuation from the scene's own value.
    fn continuation(&self, setting: &DrivenSetting) -> Result<DrivenContinuation> {
        let &Self { vary: parameter, to, step, branch, .. } = self;
        let to = to.ok_or_else(|| Error::parameter("to", "nothing", "a branch needs a value at which it ends"))?;
        let from = setting.get(parameter);
        let step = step.unwrap_or(0.05 * (to - from).abs());
        let (most_points, shooting) = (branch.max_points, DrivenShooting::default());
        let continuation = DrivenContinuation { parameter, to, step, most_points, shooting };
        continuation.check_range(setting, from)?;
        Ok(continuation)
    }
}

/// Share of the progress at which the scene has settled.
const SETTLING: f64 = 0.2;

/// The branch, in one parameter, that begins with the orbit to which a driven scene leads. In SI
/// units, `to` and `step` of the way are read, and the report is written, in these. `progress` is
/// told the share done.
///
/// # Errors
/// A scene without a periodic drive, or without the units that are asked for; a number outside its
/// rule; a first orbit that is not found; a signal.
pub fn driven_branch(
    scene: Scene,
    search: &DrivenSearch,
    way: &DrivenWay,
    si: InSi,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<DrivenBranchStudy> {
    let (setting, continuation, si) = way.for_scene(&scene, search, si)?;
    let orbit = search.orbit(&scene, &setting, &|share, what| progress(SETTLING * share, what))?;
    let branch = DrivenBranch::new(continuation, setting, orbit)?;
    let rest = |share: f64, what: &str| progress(SETTLING + (1.0 - SETTLING) * share, what);
    followed(scene, branch, si, way.branch.switch, engine, &rest)
}

/// Continues and studies a branch, and the one that crosses it at bifurcation `switch`, if given.
fn followed(
    scene: Scene,
    branch: DrivenBranch,
    si: Option<Units>,
    switch: Option<usize>,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<DrivenBranchStudy> {
    let stale = ["driven-branch.json", "driven-branch.csv", "bifurcations.csv", "driven-branch.png"].map(str::to_owned);
    let stale: Vec<String> = stale.into_iter().chain(DrivenContinue::optional_files()).collect();
    let (scale, toml) = (Scale(si.as_ref()), scene.file().to_toml());
    let work = |branch: DrivenBranch, second: bool, progress: Progress<'_>| {
        let (file, store, stale) = match second {
            false => (BRANCH_FILE, STORE, stale.clone()),
            true => (SWITCHED_FILE, SWITCHED_STORE, Vec::new()),
        };
        let mut keeper = Autosave::new(segments::folder(engine), file, stale);
        let mut keep = |branch: &DrivenBranch| {
            keeper.keep(branch.orbits.len(), branch.end.is_some(), || driven_branch_npz(&scene, branch));
        };
        let parameter = branch.continuation.parameter;
        let shown = |orbit: &DrivenOrbit, p: f64| scale.shown(quantity(parameter, &orbit.setting), p, 6);
        let branch = branches::followed(branch, &mut keep, shown, progress)?;
        // The largest number of points has no influence on those that there are.
        let continuation = DrivenContinuation { most_points: 0, ..branch.continuation };
        let settings = json!([toml, branch.setting.turns(), continuation, branch.birth]);
        segments::analysed(branch, [store, "orbit continue"], &settings, engine, progress)
    };
    let (branch, switched) = branches::with_switched(branch, switch, work, progress)?;
    Ok(DrivenBranchStudy { scene, branch, switched, si })
}
