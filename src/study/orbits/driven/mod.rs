//! Orbits of a driven scene under the stroboscopic map: one with its multipliers, or a branch with
//! its bifurcations.

mod report;

use crate::study::{
    Changes, Progress, ResultUnits, Study, Work,
    options::options,
    orbits::branches::{
        self, Begun, BifurcationOptions, BranchOptions, BranchStudy, FollowCommand, Kept, SWITCHED_FILES, SceneSource,
        branch_npz, files_of_branch,
    },
    run::error_in_file,
};
use crate::{
    chain::DriveKind,
    error::{Error, Result, require},
    orbits::{
        BifurcationKind, DriveParameter, DrivenBranch, DrivenContinuation, DrivenOrbit, DrivenPoint, DrivenSetting,
        DrivenShooting, Problem,
    },
    output::Array,
    report::Report,
    scene::{Quantity, Scene, Units},
};

options! {
    /// The orbit of a driven scene.
    pub struct Driven {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// The scene must have a `[[drive]]`: harmonics of one frequency, with or without a ramp.
        /// The orbit is that of the drive at its full height.
        scene: String = "granular-crystal".to_owned();
        /// Changes to the scene.
        changes: Changes = Changes::default();
        /// Amplitude of the drive [default: that of the scene].
        ///
        /// In the units of the scene, of its first harmonic with a frequency; the others keep their
        /// ratio to it.
        amplitude: Option<f64> = None, "A", (finite);
        /// Frequency of the drive, in radians per unit of time [default: that of the scene].
        ///
        /// The fundamental one; all harmonics keep their ratio to it. In the units of the scene.
        omega: Option<f64> = None, "W", (positive);
        /// Periods of the drive in a period of the orbit.
        ///
        /// 2 for orbits of doubled period.
        turns: u32 = 1, "M", (1 to 64);
        /// Periods of the orbit for which the scene runs before the search.
        ///
        /// After its ramp. The search starts from the state that the scene has then; it starts
        /// earlier if the scene has become periodic. If no orbit is found from there, the search
        /// starts from the state after the ramp.
        settle: u32 = 300, "K", (0 to 1_000_000);
        /// The units of options and results.
        results: ResultUnits = ResultUnits::default();
    }
}

impl Driven {
    /// The scene, the setting of its orbits, and the units of results.
    fn load(&self) -> Result<(Scene, DrivenSetting, Option<Units>)> {
        let mut scene = Scene::load_with(&self.scene, &self.changes.set)?;
        let si = self.results.of(&scene);
        self.within_ranges()?;
        let mut setting = DrivenSetting::new(scene.chain(), self.turns)?;
        let factor = |parameter: DriveParameter, given: Option<f64>| {
            let own = scene.in_file(quantity(parameter, &setting), setting.get(parameter));
            let value = given.unwrap_or(own);
            parameter.check(value).map(|()| value / own)
        };
        let amplitude = factor(DriveParameter::Amplitude, self.amplitude)?;
        let factors = [amplitude, factor(DriveParameter::Omega, self.omega)?];
        if factors != [1.0; 2] {
            scene = scene.driven(factors)?;
            setting = DrivenSetting::new(scene.chain(), self.turns)?;
        }
        Ok((scene, setting, si))
    }

    /// The study of the orbit to which the scene leads. All options are checked before the work.
    ///
    /// # Errors
    /// A scene without a periodic drive; a number outside its rule.
    pub fn study(&self) -> Result<Work<'_, DrivenStudy>> {
        let (scene, setting, si) = self.load()?;
        Ok(Box::new(move |_, progress| {
            let orbit = self.orbit(&scene, &setting, progress)?;
            Ok(DrivenStudy { si, ..DrivenStudy::new(scene, orbit)? })
        }))
    }

    fn orbit(&self, scene: &Scene, setting: &DrivenSetting, progress: Progress<'_>) -> Result<DrivenOrbit> {
        let shooting = DrivenShooting::default();
        let seen = |share: f64| progress(share, "the scene settles");
        let from = |periods| {
            let seed = shooting.settle(setting, scene.chain(), scene.initial(), periods, seen)?;
            shooting.solve(setting, &seed)
        };
        // A chain that leaves an unstable orbit may have been nearer to it before.
        let orbit = match from(self.settle) {
            Err(stalled @ Error::Stalled { .. }) if self.settle > 0 => from(0).map_err(|_| stalled),
            other => other,
        };
        orbit.map_err(|error| error_in_file(error, scene))
    }
}

/// An orbit of a driven scene with its multipliers, samples and energy balance. All of its numbers
/// are dimensionless; `si` is for its [`Report`](crate::study::Report).
#[derive(Clone, Debug)]
pub struct DrivenStudy {
    /// The scene.
    pub scene: Scene,
    /// The orbit with its multipliers.
    pub point: DrivenPoint,
    /// States at 64 times of each period of the drive.
    pub samples: Vec<Vec<f64>>,
    /// Half ranges of all displacements, and of all strains between neighbours.
    pub ranges: [Vec<f64>; 2],
    /// Work of the drives over the orbit.
    pub driven: f64,
    /// Energy that is dissipated over the orbit.
    pub dissipated: f64,
    /// The units of the scene, if the report is in SI units.
    pub si: Option<Units>,
}

impl Study for Driven {
    const FILES: &'static str = "driven-orbit.csv has the displacements of all beads over a period; driven-orbit.npz has the orbit, from which \
                                 `orbit continue --resume` goes on.";
    const INTERRUPTIBLE: bool = true;

    fn outline() -> Option<Report> {
        Some(Report::new("driven-orbit").table(report::multipliers(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let work = self.study()?;
        Ok(Box::new(move |engine, progress| {
            let study = work(engine, progress)?;
            Ok(study.report().file("driven-orbit.npz", study.npz()?))
        }))
    }
}

impl DrivenStudy {
    /// The file of the orbit, which may go on as a branch in the amplitude of the drive.
    fn npz(&self) -> Result<Vec<u8>> {
        let (parameter, shooting) = (DriveParameter::Amplitude, DrivenShooting::default());
        let continuation = DrivenContinuation { parameter, to: 0.0, step: 0.0, most_points: 0, shooting };
        let branch = branches::alone(continuation, &self.point.orbit.setting, self.point.clone())?;
        branch_npz(&self.scene, &branch)
    }

    /// Computes multipliers, samples and energy balance of an orbit.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    pub fn new(scene: Scene, orbit: DrivenOrbit) -> Result<Self> {
        let shooting = DrivenShooting::default();
        let samples = orbit.samples(&shooting)?;
        let ranges = orbit.ranges(&samples, &shooting)?;
        let ledger = samples.last().and_then(|state| orbit.setting.chain().ok()?.layout().ledger(state));
        let (driven, dissipated) = ledger.map_or((0.0, 0.0), |ledger| (ledger.driven, ledger.dissipated()));
        Ok(Self { point: DrivenPoint::new(orbit, &shooting)?, scene, samples, ranges, driven, dissipated, si: None })
    }
}

options! {
    /// A branch of orbits of a driven scene.
    pub struct DrivenContinue {
        /// The scene and the search for its orbit.
        driven: Driven = Driven::default();
        /// What varies along the branch.
        vary: DriveParameter = DriveParameter::Amplitude, "P";
        /// What every branch asks for.
        branch: BranchOptions = BranchOptions::default();
        /// What is asked for about its bifurcations.
        more: BifurcationOptions = BifurcationOptions::default();
    } command |command| command.mut_arg("resume", |arg| arg.conflicts_with_all([
            "scene", "set", "amplitude", "omega", "turns", "settle", "vary",
        ]))
}

/// A branch of a driven scene.
pub type DrivenBranchStudy = BranchStudy<DrivenContinuation>;

impl Kept for DrivenContinuation {
    type About = Scene;
    type Source = SceneSource;
    const NAMES: [&'static str; 3] = ["driven-branch.npz", "driven-spectra.store", "orbit continue"];
    const FILES: &'static str = files_of_branch!("driven-branch.npz", "driven-spectra.store", "");
    const OPTIONAL: &'static [&'static str] = &SWITCHED_FILES;
    /// The scene settles first.
    const FIRST: f64 = 0.2;

    fn source(scene: &Scene, branch: &DrivenBranch) -> (SceneSource, Vec<Array<'static>>) {
        let starts = branch.orbits.iter().filter_map(|orbit| orbit.start().ok());
        SceneSource::of(scene, branch.setting.turns(), starts)
    }

    fn made(source: SceneSource, birth: Option<BifurcationKind>) -> Result<(Scene, DrivenSetting)> {
        let (scene, turns) = (source.scene()?, source.turns);
        let fits = birth != Some(BifurcationKind::PeriodDoubling) || turns.is_multiple_of(2);
        require(fits, "turns", turns, "even after a period doubling")?;
        let setting = DrivenSetting::new(scene.chain(), turns)?;
        Ok((scene, setting))
    }

    fn units(scene: &Scene) -> Option<Units> {
        scene.units().copied()
    }

    fn quantity(&self, setting: &DrivenSetting) -> Quantity {
        quantity(self.parameter, setting)
    }

    fn outline() -> Report {
        report::outline()
    }

    fn report(study: &DrivenBranchStudy) -> Result<Report> {
        report::branch(study)
    }
}

impl FollowCommand for DrivenContinue {
    type Problem = DrivenContinuation;

    fn options(&self) -> (&BranchOptions, BifurcationOptions, ResultUnits) {
        (&self.branch, self.more, self.driven.results)
    }

    fn first(&self) -> Result<Work<'_, Begun<DrivenContinuation>>> {
        let (parameter, (scene, setting, si)) = (self.vary, self.driven.load()?);
        let (kind, from) = (quantity(parameter, &setting), setting.get(parameter));
        let continuation = self.branch.continuation((scene.units(), kind), from, |to, step| {
            let (most_points, shooting) = (self.branch.max_points, DrivenShooting::default());
            let continuation = DrivenContinuation { parameter, to, step, most_points, shooting };
            continuation.check_range(&setting, from).map(|()| continuation)
        })?;
        Ok(Box::new(move |_, progress| {
            let orbit = self.driven.orbit(&scene, &setting, progress)?;
            Ok((scene, DrivenBranch::new(continuation, setting, orbit)?, si))
        }))
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
