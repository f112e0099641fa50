//! Branches of driven orbits as files, read back to the bit.
//!
//! An NPZ file: `settings.json` with the scene and the numbers that hold for the whole branch, and
//! the arrays `parameter`, `residual` and `z`, with a row for each orbit.

use crate::{
    error::{Error, Result},
    orbits::{
        BifurcationKind, DriveParameter, DrivenContinuation, DrivenOrbit, DrivenSetting, DrivenShooting, DrivenTrail,
        End,
    },
    output::{Archive, Array, SETTINGS, npz_with, to_json},
    scene::{Scene, SceneFile},
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Format and version of the file.
const FORMAT: (&str, u64) = ("hertzchain driven branch", 1);
/// Largest residual of an orbit in a file, measured when the file is read; orbits are solved to
/// 1e-11.
const ORBIT: f64 = 1e-8;
/// Largest rate of contacts, resonators, damping and drives in units of the frequency of the orbit,
/// so that the residual is measured within seconds on a short chain.
const FASTEST: f64 = 1e5;

/// Format and version of a file.
#[derive(Deserialize)]
#[serde(expecting = "the settings of a driven branch")]
struct Stamp {
    format: String,
    version: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "the settings of a driven branch")]
struct Settings {
    format: String,
    version: u64,
    program: String,
    /// The scene as TOML.
    scene: String,
    turns: u32,
    parameter: DriveParameter,
    to: f64,
    step: f64,
    most_points: usize,
    shooting: DrivenShooting,
    back: f64,
    #[serde(deserialize_with = "Option::deserialize")]
    birth: Option<BifurcationKind>,
    points: u64,
    ds: f64,
    #[serde(deserialize_with = "Option::deserialize")]
    end: Option<End>,
}

/// The bytes of the file for a branch of this scene.
///
/// # Errors
/// Errors of the archive writer.
pub fn driven_branch_npz(scene: &Scene, trail: &DrivenTrail) -> Result<Vec<u8>> {
    let DrivenTrail { continuation, back, birth, orbits, ds, end } = trail;
    let &DrivenContinuation { parameter, to, step, most_points, shooting } = continuation;
    let settings = Settings {
        format: FORMAT.0.to_owned(),
        version: FORMAT.1,
        program: concat!("hertzchain ", env!("CARGO_PKG_VERSION")).to_owned(),
        scene: scene.file().to_toml(),
        turns: orbits.first().map_or(1, |orbit| orbit.setting.turns()),
        parameter,
        to,
        step,
        most_points,
        shooting,
        back: *back,
        birth: *birth,
        points: orbits.len() as u64,
        ds: *ds,
        end: *end,
    };
    let arrays = [
        Array::vector("parameter", orbits.iter().map(|orbit| orbit.setting.get(parameter)).collect()),
        Array::vector("residual", orbits.iter().map(|orbit| orbit.residual).collect()),
        Array::matrix("z", orbits.iter().map(|orbit| orbit.z.as_slice())),
    ];
    npz_with(SETTINGS, &to_json(&settings), &arrays)
}

/// Reads a branch and its scene: the orbits have the bits they had when written; their Newton steps
/// are not in the file.
///
/// # Errors
/// A file that cannot be read; [`Error::Content`], with the place and the rule, for a file with
/// another structure or version, or with numbers outside their rules.
pub fn load_driven_branch(path: &Path) -> Result<(Scene, DrivenTrail)> {
    let file = Archive::read(path)?;
    let (scene, trail) = driven_branch_from_archive(&file)?;
    for (k, orbit) in trail.orbits.iter().enumerate() {
        let refused = |why: &dyn std::fmt::Display| file.refused("z", format!("point {k}: {why}"));
        let off = orbit.measured(&trail.continuation.shooting).map_err(|why| refused(&why))?;
        if off.is_nan() || off > ORBIT {
            return Err(refused(&format!("an orbit returns to 1e-8: this comes back to {off:e}")));
        }
    }
    Ok((scene, trail))
}

/// Reads a branch and its scene from an archive, with all checks that need no integration.
///
/// [`load_driven_branch`] checks in addition that the orbits return.
///
/// # Errors
/// As [`load_driven_branch`].
pub fn driven_branch_from_archive(file: &Archive) -> Result<(Scene, DrivenTrail)> {
    let refused = |key: &str, why: &dyn std::fmt::Display| file.refused(&format!("{SETTINGS}, {key}"), why.to_string());
    let text = file.text(SETTINGS)?;
    let Stamp { format, version } = serde_json::from_str(text).map_err(|why| refused("format", &why))?;
    if (format.as_str(), version) != FORMAT {
        let rule = format!("{format}, version {version}; read is {}, version {}", FORMAT.0, FORMAT.1);
        return Err(refused("format", &rule));
    }
    let settings: Settings = serde_json::from_str(text).map_err(|why| refused("keys", &why))?;
    let Settings { scene, turns, parameter, to, step, most_points, shooting, back, birth, points, ds, end, .. } =
        settings;
    let scene = SceneFile::parse(&scene, SETTINGS).and_then(Scene::build).map_err(|why| refused("scene", &why))?;
    let setting = DrivenSetting::new(scene.chain(), turns).map_err(|why| refused("scene", &why))?;
    let continuation = DrivenContinuation { parameter, to, step, most_points, shooting };
    continuation.check(back).map_err(|why| refused("to", &why))?;
    let doubling = BifurcationKind::PeriodDoubling;
    for (name, value, good, rule) in [
        ("points", points as f64, points > 0, "at least one"),
        ("ds", ds, ds.is_finite() && ds > 0.0, "finite and positive"),
        ("turns", f64::from(turns), birth != Some(doubling) || turns.is_multiple_of(2), "even after a period doubling"),
    ] {
        if !good {
            return Err(refused(name, &Error::parameter(name, value, rule)));
        }
    }
    let orbits = orbits(file, points, &setting, &continuation)?;
    Ok((scene, DrivenTrail { continuation, back, birth, orbits, ds, end }))
}

/// The orbits in a file, each within the rules of its parameters.
fn orbits(
    file: &Archive,
    points: u64,
    setting: &DrivenSetting,
    continuation: &DrivenContinuation,
) -> Result<Vec<DrivenOrbit>> {
    let unknowns = setting.unknowns();
    let [values, residuals] = [file.array("parameter", &[points])?, file.array("residual", &[points])?];
    let z = file.array("z", &[points, unknowns as u64])?;
    let mut orbits = Vec::new();
    for (k, ((&p, &residual), z)) in values.iter().zip(&residuals).zip(z.chunks_exact(unknowns)).enumerate() {
        let refused = |name: &str, why: &dyn std::fmt::Display| file.refused(name, format!("point {k}: {why}"));
        if !z.iter().chain([&residual]).all(|value| value.is_finite()) {
            return Err(refused("z", &"numbers of an orbit are finite"));
        }
        let setting = setting.with(continuation.parameter, p);
        let rate = setting.fastest_rate(z).map_err(|why| refused("parameter", &why))?;
        if rate > FASTEST {
            let rule = "contacts, resonators, damping and drives of an orbit are at most 10^5 times as fast as it is";
            return Err(refused("z", &format!("{rule}: these may be {rate:.1e} times")));
        }
        orbits.push(DrivenOrbit { setting, z: z.to_vec(), residual, newton: Vec::new() });
    }
    Ok(orbits)
}
