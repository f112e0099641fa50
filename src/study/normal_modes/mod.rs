//! A nonlinear normal mode of a conservative scene: the branch of orbits that begins as a linear
//! mode.

mod report;

use super::{
    Changes, InSi, Progress, SWITCHED_EVENTS, SWITCHED_TABLE, Study, Work, check_switch, crossing,
    si::Scale,
    stretches::{self, Known},
};
use crate::{
    error::{Error, Result},
    orbits::{Around, ModeBranch, ModeContinuation, ModePoint, ModeTrail, NormalModes},
    scene::{Quantity, Scene, Units},
    sweep::Engine,
};
use serde_json::json;

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
    /// The units of options and results.
    #[cfg_attr(feature = "cli", command(flatten))]
    pub si: InSi,
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
    /// The branch begins at this amplitude, or at a smaller one if the orbit found there is not near
    /// the linear mode [default: a twentieth of the last one].
    #[cfg_attr(feature = "cli", arg(long, value_name = "DA"))]
    pub step: Option<f64>,
    /// Points of the branch at most.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 200))]
    pub max_points: usize,
    /// Follow the branch that crosses at bifurcation K, too.
    ///
    /// A period doubling, for orbits of the doubled period, or a branch point; bifurcations are
    /// numbered from 1 as they are printed. It ends as the first branch does, or where orbits of
    /// doubled period come back to those of half the period.
    #[cfg_attr(feature = "cli", arg(long, value_name = "K"))]
    pub switch: Option<usize>,
}

/// The branch of a mode of a scene. All of its numbers are dimensionless; `si` is for its
/// report.
#[derive(Clone, Debug)]
pub struct ModeStudy {
    /// The scene.
    pub scene: Scene,
    /// Its equilibrium and linear modes.
    pub modes: NormalModes,
    /// The branch.
    pub branch: ModeBranch,
    /// Number of a bifurcation of the branch, from 1 on, and the branch that crosses there or, in
    /// words, why none was followed.
    pub switched: Option<(usize, std::result::Result<ModeBranch, String>)>,
    /// The units of the scene, if the report is in SI units.
    pub si: Option<Units>,
}

impl ModeWay {
    /// The way in the units of the chain.
    fn read(&self, scale: Scale<'_>) -> Self {
        let read = |amplitude: f64| scale.read(Quantity::Length, amplitude);
        Self { to: read(self.to), step: self.step.map(read), ..*self }
    }

    /// The modes of a scene, the continuation, and the units in which it was given and is told.
    fn for_scene(&self, scene: &Scene, si: InSi) -> Result<(NormalModes, ModeContinuation, Option<Units>)> {
        let si = si.units(scene)?;
        let (modes, scale) = (NormalModes::new(scene.chain())?, Scale(si.as_ref()));
        let &Self { to, step, .. } = self;
        let continuation = scale.given(self.read(scale).continuation(&modes), &[("to", Some(to)), ("step", step)])?;
        Ok((modes, continuation, si))
    }

    fn continuation(&self, modes: &NormalModes) -> Result<ModeContinuation> {
        let &Self { mode, to, step, max_points: most_points, switch } = self;
        check_switch(switch)?;
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
    const FILES: &'static str = "Files: mode.json, mode-branch.csv, bifurcations.csv, linear-modes.csv, neighbours.csv, mode.npz and mode.png, with --switch \
                                 switched-branch.csv and switched-bifurcations.csv. \
                                 mode-bifurcations.store and switched-bifurcations.store have bifurcations, from which the same command goes on. \
                                 Each part of --shard follows the first branch itself and locates its share of these.";
    const STOPS: bool = true;
    const SWEEPS: bool = true;

    fn sometimes() -> Vec<String> {
        [SWITCHED_TABLE, SWITCHED_EVENTS].map(str::to_owned).to_vec()
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = Scene::load_with(&self.scene, &self.changes.set)?;
        let (modes, continuation, si) = self.way.for_scene(&scene, self.si)?;
        Ok(Box::new(move |engine, progress| {
            Ok(Box::new(followed(scene, modes, si, &continuation, self.way.switch, engine, progress)?.report()))
        }))
    }
}

/// The branch of a normal mode of a conservative scene. In SI units, `to` and `step` of the way are
/// read, and the report is told, in these. `progress` is told the share done.
///
/// # Errors
/// A scene that dissipates or is driven, or whose contacts do not hold every bead, or without the
/// units that are asked for; a number outside its rule; a first orbit that is not found; a signal.
pub fn follow_mode(scene: Scene, way: &ModeWay, si: InSi, progress: Progress<'_>) -> Result<ModeStudy> {
    let (modes, continuation, si) = way.for_scene(&scene, si)?;
    followed(scene, modes, si, &continuation, way.switch, &Engine::threads(), progress)
}

/// Names of the stores of bifurcations.
const STORE: &str = "mode-bifurcations.store";
const SWITCHED_STORE: &str = "switched-bifurcations.store";

/// Share of the progress of a branch for its orbits and multipliers; the rest is for bifurcations,
/// which take most of the time where there are any.
const ORBITS: f64 = 0.3;

fn followed(
    scene: Scene,
    modes: NormalModes,
    si: Option<Units>,
    continuation: &ModeContinuation,
    switch: Option<usize>,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<ModeStudy> {
    let tell = |first: f64, share: f64| {
        let mut count = 0;
        move |point: &ModePoint| {
            count += 1;
            let a = point.orbit.amplitude;
            let done = first + ORBITS * share * (a.abs() / continuation.to).clamp(0.0, 1.0);
            let a = Scale(si.as_ref()).shown(Quantity::Length, a, 6);
            progress(done, &format!("point {count}, a = {a}"));
        }
    };
    let rest = |first: f64, share: f64| {
        move |part: f64, what: &str| progress(first + share * (ORBITS + (1.0 - ORBITS) * part), what)
    };
    let whole = if switch.is_some() { 0.5 } else { 1.0 };
    let trail = continuation.trail(&modes, tell(0.0, whole))?;
    let branch = located(&scene, &modes, trail, STORE, engine, &rest(0.0, whole))?;
    let Some(number) = switch else { return Ok(ModeStudy { scene, modes, branch, switched: None, si }) };
    let other = branch.switched_trail(&modes, number.wrapping_sub(1), tell(0.5, 0.5));
    let other = other.and_then(|trail| located(&scene, &modes, trail, SWITCHED_STORE, engine, &rest(0.5, 0.5)));
    Ok(ModeStudy { switched: crossing(number, other)?, scene, modes, branch, si })
}

/// Locates the bifurcations of a branch that was followed, as points of a sweep. The multipliers of
/// its orbits are known: without them the branch would have ended.
fn located(
    scene: &Scene,
    modes: &NormalModes,
    trail: ModeTrail,
    store: &'static str,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<ModeBranch> {
    let ModeContinuation { mode, to, step, .. } = trail.continuation;
    let settings =
        json!({ "scene": scene.file().to_toml(), "mode": mode, "to": to, "step": step, "first": trail.first });
    let known = Known::new(&trail.points, &|_| Ok(()));
    let branch = stretches::Branch { store, study: "orbit mode", settings, known: &known, joined: false };
    let determined = |point: &ModePoint| json!([point.orbit.amplitude, point.orbit.omega, point.orbit.shape]);
    let rows: Vec<Around> = branch.rows(engine, determined, |k| Ok(trail.around(modes, k)), progress)?;
    let (mut bifurcations, mut folds, mut unresolved) = (Vec::new(), Vec::new(), 0);
    for row in rows {
        bifurcations.extend(row.between);
        folds.extend(row.fold);
        unresolved += row.unresolved;
    }
    bifurcations.extend(folds);
    Ok(trail.with(bifurcations, unresolved))
}
