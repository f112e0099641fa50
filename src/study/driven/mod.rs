//! Orbits of a driven scene under the stroboscopic map: one with its multipliers, or a branch with
//! its bifurcations.

mod report;

use super::{Changes, Progress, Study, Work};
use crate::{
    error::{Error, Result},
    orbits::{
        DriveParameter, DrivenBranch, DrivenContinuation, DrivenOrbit, DrivenPoint, DrivenSetting, DrivenShooting,
    },
    scene::Scene,
};
#[cfg(feature = "plot")]
pub(crate) use report::{multipliers_panel, stability_lines};

/// A driven scene, by name, and the search for its orbit.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct DrivenScene {
    /// Name of a built-in scene, or a TOML file.
    ///
    /// One with a `[[drive]]`: harmonics of one frequency, with or without a ramp. The orbit is
    /// that of the drive at its full height.
    #[cfg_attr(feature = "cli", arg(default_value = "granular-crystal"))]
    pub scene: String,
    /// Changes to the scene.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub changes: Changes,
    /// The search.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub search: DrivenSearch,
}

impl DrivenScene {
    fn load(&self) -> Result<Scene> {
        Scene::load_with(&self.scene, &self.changes.set)
    }
}

/// The search for the orbit to which a driven scene leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct DrivenSearch {
    /// Periods of the drive in a period of the orbit.
    ///
    /// From 1 to 64; 2 for orbits of doubled period.
    #[cfg_attr(feature = "cli", arg(long, value_name = "M", default_value_t = 1))]
    pub turns: u32,
    /// Periods of the orbit for which the scene runs before the search.
    ///
    /// After its ramp, from 0 to 10^6. The search starts from the state that the scene has then; it
    /// starts earlier if the scene has become periodic.
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", default_value_t = 300))]
    pub settle: u32,
}

impl Default for DrivenSearch {
    fn default() -> Self {
        Self { turns: 1, settle: 300 }
    }
}

const MOST_PERIODS: u32 = 1_000_000;

impl DrivenSearch {
    fn setting(&self, scene: &Scene) -> Result<DrivenSetting> {
        if self.settle > MOST_PERIODS {
            return Err(Error::parameter("settle", self.settle, "at most 10^6 periods"));
        }
        DrivenSetting::new(scene.chain(), self.turns)
    }

    fn orbit(&self, scene: &Scene, setting: &DrivenSetting, progress: Progress<'_>) -> Result<DrivenOrbit> {
        let shooting = DrivenShooting::default();
        let seen = |share: f64| progress(share, "the scene settles");
        let seed = shooting.settle(setting, scene.chain(), scene.initial(), self.settle, seen)?;
        shooting.solve(setting, &seed)
    }
}

/// The orbit of a driven scene.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct Driven {
    /// The scene.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub told: DrivenScene,
}

/// An orbit of a driven scene with its multipliers, samples and energy balance.
#[derive(Clone, Debug)]
pub struct DrivenStudy {
    /// The scene.
    pub scene: Scene,
    /// The orbit with its multipliers.
    pub point: DrivenPoint,
    /// States at 64 times of each period of the drive.
    pub samples: Vec<Vec<f64>>,
    /// Energy that drives put in over the orbit.
    pub driven: f64,
    /// Energy that is dissipated over the orbit.
    pub dissipated: f64,
}

impl Study for Driven {
    const FILES: &'static str = "Files: driven-orbit.json, driven-orbit.csv and driven-orbit.png.";
    const STOPS: bool = true;

    fn begin(&self) -> Result<Work<'_>> {
        let scene = self.told.load()?;
        self.told.search.setting(&scene)?;
        Ok(Box::new(move |_, progress| Ok(Box::new(driven_orbit(scene, &self.told.search, progress)?))))
    }
}

/// The orbit to which a driven scene leads. `progress` is told the share done.
///
/// # Errors
/// A scene without a periodic drive; an orbit that is not found; a signal.
pub fn driven_orbit(scene: Scene, search: &DrivenSearch, progress: Progress<'_>) -> Result<DrivenStudy> {
    let orbit = search.orbit(&scene, &search.setting(&scene)?, progress)?;
    DrivenStudy::new(scene, orbit)
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
        Ok(Self { point: DrivenPoint::new(orbit, &shooting)?, scene, samples, driven, dissipated })
    }
}

/// A branch of orbits of a driven scene.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct DrivenContinue {
    /// The scene.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub told: DrivenScene,
    /// The way.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub way: DrivenWay,
}

/// The way of a branch of driven orbits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct DrivenWay {
    /// What varies along the branch.
    #[cfg_attr(feature = "cli", arg(long, value_name = "P", value_enum, default_value_t = DriveParameter::Amplitude))]
    pub vary: DriveParameter,
    /// Where it ends.
    ///
    /// It begins with the scene's own value (with 1 for `damping`).
    #[cfg_attr(feature = "cli", arg(long, value_name = "P"))]
    pub to: f64,
    /// Its largest change from point to point.
    ///
    /// [default: a twentieth of the range]
    #[cfg_attr(feature = "cli", arg(long, value_name = "DP"))]
    pub step: Option<f64>,
    /// Points of the branch at most.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 200))]
    pub max_points: usize,
}

/// A branch of a driven scene.
#[derive(Clone, Debug)]
pub struct DrivenBranchStudy {
    /// The scene.
    pub scene: Scene,
    /// The branch.
    pub branch: DrivenBranch,
}

impl Study for DrivenContinue {
    const FILES: &'static str = "Files: driven-branch.json, driven-branch.csv and driven-branch.png.";
    const STOPS: bool = true;

    fn begin(&self) -> Result<Work<'_>> {
        let scene = self.told.load()?;
        self.way.continuation(&self.told.search.setting(&scene)?)?;
        Ok(Box::new(move |_, progress| Ok(Box::new(driven_branch(scene, &self.told.search, &self.way, progress)?))))
    }
}

impl DrivenWay {
    /// The continuation from the scene's own value.
    fn continuation(&self, setting: &DrivenSetting) -> Result<DrivenContinuation> {
        let &Self { vary: parameter, to, step, max_points: most_points } = self;
        let from = setting.get(parameter);
        let step = step.unwrap_or(0.05 * (to - from).abs());
        let continuation = DrivenContinuation { parameter, to, step, most_points, shooting: DrivenShooting::default() };
        continuation.check(from)?;
        setting.with(parameter, to).chain()?;
        Ok(continuation)
    }
}

/// The branch of the orbit to which a driven scene leads, in one parameter. `progress` is told the
/// share done.
///
/// # Errors
/// A scene without a periodic drive; a number outside its rule; a first orbit that is not found; a
/// signal.
pub fn driven_branch(
    scene: Scene,
    search: &DrivenSearch,
    way: &DrivenWay,
    progress: Progress<'_>,
) -> Result<DrivenBranchStudy> {
    let setting = search.setting(&scene)?;
    let continuation = way.continuation(&setting)?;
    let (name, from) = (way.vary.name(), setting.get(way.vary));
    let orbit = search.orbit(&scene, &setting, &|share, what| progress(0.2 * share, what))?;
    let mut count = 0;
    let seen = |point: &DrivenPoint| {
        count += 1;
        let p = point.orbit.setting.get(way.vary);
        let share = ((p - from) / (way.to - from)).clamp(0.0, 1.0);
        progress(0.2 + 0.8 * share, &format!("point {count}, {name} = {p:.6}"));
    };
    Ok(DrivenBranchStudy { branch: continuation.follow(orbit, seen)?, scene })
}
