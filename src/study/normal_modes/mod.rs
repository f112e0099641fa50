//! A nonlinear normal mode of a conservative scene: its branch from the linear mode on.

mod report;

use super::{Changes, Progress, Study, Work};
use crate::{
    error::{Error, Result},
    orbits::{ModeBranch, ModeContinuation, NormalModes},
    scene::Scene,
};

/// A conservative scene, and a mode of it that is followed.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct FollowMode {
    /// Name of a built-in scene, or a TOML file.
    ///
    /// All contacts of the scene must be closed at rest: a static overlap, between walls or on a
    /// ring. Beads may differ. The initial state of the scene does not matter.
    #[cfg_attr(feature = "cli", arg(default_value = "defect"))]
    pub scene: String,
    /// Changes to the scene.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub changes: Changes,
    /// The branch.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub way: ModeWay,
}

/// The branch of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct ModeWay {
    /// Number of the linear mode, from 1 on, the lowest frequency first.
    ///
    /// [default: the most localised one]
    #[cfg_attr(feature = "cli", arg(long = "linear-mode", value_name = "K"))]
    pub mode: Option<usize>,
    /// Amplitude at which the branch ends.
    ///
    /// The amplitude is the displacement, at the start of the period, of the bead or resonator that
    /// moves most in the linear mode.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A"))]
    pub to: f64,
    /// Largest change of the amplitude from point to point.
    ///
    /// The branch begins at this amplitude [default: a twentieth of the last one].
    #[cfg_attr(feature = "cli", arg(long, value_name = "DA"))]
    pub step: Option<f64>,
    /// Points of the branch at most.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 200))]
    pub max_points: usize,
}

/// The branch of a mode of a scene.
#[derive(Clone, Debug)]
pub struct ModeStudy {
    /// The scene.
    pub scene: Scene,
    /// Its linear modes.
    pub modes: NormalModes,
    /// The branch.
    pub branch: ModeBranch,
}

impl ModeWay {
    fn continuation(&self, modes: &NormalModes) -> Result<ModeContinuation> {
        let &Self { mode, to, step, max_points: most_points } = self;
        let mode = match mode {
            None => modes.most_localised(),
            Some(0) => {
                return Err(Error::parameter("linear_mode", 0, "linear modes are numbered from 1, by frequency"));
            }
            Some(number) => number - 1,
        };
        let continuation = ModeContinuation { mode, to, step: step.unwrap_or(0.05 * to), most_points };
        continuation.check(modes).map(|()| continuation)
    }
}

impl Study for FollowMode {
    const FILES: &'static str = "Files: mode.json, mode-branch.csv, linear-modes.csv and mode.png.";
    const STOPS: bool = true;

    fn begin(&self) -> Result<Work<'_>> {
        let scene = Scene::load_with(&self.scene, &self.changes.set)?;
        let modes = NormalModes::new(scene.chain())?;
        let continuation = self.way.continuation(&modes)?;
        Ok(Box::new(move |_, progress| Ok(Box::new(followed(scene, modes, &continuation, progress)?))))
    }
}

/// The branch of a normal mode of a conservative scene. `progress` is told the share done.
///
/// # Errors
/// A scene that dissipates, is driven, or whose beads contacts do not hold; a number outside its
/// rule; a first orbit that is not found; a signal.
pub fn follow_mode(scene: Scene, way: &ModeWay, progress: Progress<'_>) -> Result<ModeStudy> {
    let modes = NormalModes::new(scene.chain())?;
    let continuation = way.continuation(&modes)?;
    followed(scene, modes, &continuation, progress)
}

fn followed(
    scene: Scene,
    modes: NormalModes,
    continuation: &ModeContinuation,
    progress: Progress<'_>,
) -> Result<ModeStudy> {
    let mut count = 0;
    let branch = continuation.follow(&modes, |point| {
        count += 1;
        let a = point.orbit.amplitude;
        progress((a / continuation.to).clamp(0.0, 1.0), &format!("point {count}, a = {a:.6}"));
    })?;
    Ok(ModeStudy { scene, modes, branch })
}
