//! Multipliers and bifurcations of a branch of driven orbits that was followed.

use crate::{
    error::{Error, Result},
    orbits::{
        BifurcationKind, DrivenBifurcation, DrivenBranch, DrivenMultiplier, DrivenOrbit, DrivenPoint, DrivenSpectrum,
        DrivenTrail, NewtonStep,
    },
    scene::Scene,
    study::{Progress, stretches},
    sweep::{Engine, Row},
};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// An orbit of a branch, as its row.
#[derive(Serialize, Deserialize)]
struct Studied {
    /// What was measured, or why there are no multipliers.
    measured: Row<Measured>,
    /// Bifurcations between the orbit before and this one.
    bifurcations: Vec<Located>,
    /// Number of changes of stability there that were not resolved.
    unresolved: usize,
}

/// A [`DrivenPoint`] without its orbit.
#[derive(Serialize, Deserialize)]
struct Measured {
    spectrum: DrivenSpectrum,
    amplitude: f64,
    least_turns: u32,
}

/// A [`DrivenBifurcation`], with the numbers of its orbit that differ from orbit to orbit.
#[derive(Serialize, Deserialize)]
struct Located {
    kind: BifurcationKind,
    parameter: f64,
    multiplier: DrivenMultiplier,
    z: Vec<f64>,
    residual: f64,
    newton: Vec<NewtonStep>,
    measured: Measured,
    after: usize,
}

impl Measured {
    fn of(&DrivenPoint { ref spectrum, amplitude, least_turns, .. }: &DrivenPoint) -> Self {
        Self { spectrum: spectrum.clone(), amplitude, least_turns }
    }

    fn point(self, orbit: DrivenOrbit) -> DrivenPoint {
        let Self { spectrum, amplitude, least_turns } = self;
        DrivenPoint { orbit, spectrum, amplitude, least_turns }
    }
}

impl Located {
    fn of(DrivenBifurcation { kind, parameter, multiplier, point, after }: DrivenBifurcation) -> Self {
        let measured = Measured::of(&point);
        let DrivenOrbit { z, residual, newton, .. } = point.orbit;
        Self { kind, parameter, multiplier, z, residual, newton, measured, after }
    }

    fn bifurcation(self, trail: &DrivenTrail) -> DrivenBifurcation {
        let Self { kind, parameter, multiplier, z, residual, newton, measured, after } = self;
        let setting = trail.orbits[after].setting.with(trail.continuation.parameter, parameter);
        let point = measured.point(DrivenOrbit { setting, z, residual, newton });
        DrivenBifurcation { kind, parameter, multiplier, point, after }
    }
}

/// The orbits of a branch with their multipliers.
type Known<'a> = stretches::Known<'a, DrivenOrbit, DrivenPoint>;

/// Computes multipliers and bifurcations of a branch of this scene, as points of a sweep.
///
/// # Errors
/// No multipliers of the first orbit; as [`Engine::sweep`].
pub(super) fn studied(
    scene: &Scene,
    trail: DrivenTrail,
    store: &'static str,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<DrivenBranch> {
    let (continuation, orbits) = (trail.continuation, &trail.orbits);
    let settings = settings(scene, &trail);
    let point = |orbit: &DrivenOrbit| DrivenPoint::new(orbit.clone(), &continuation.shooting);
    let known = Known::new(orbits, &point);
    let branch = stretches::Branch { store, study: "orbit continue", settings, known: &known, joined: true };
    let determined = |orbit: &DrivenOrbit| json!([orbit.setting.get(continuation.parameter), orbit.z]);
    let rows = branch.rows(engine, determined, |k| Ok(row(&trail, &known, k)), progress)?;
    assembled(trail, rows)
}

/// All that multipliers and bifurcations of a branch depend on besides its orbits.
fn settings(scene: &Scene, trail: &DrivenTrail) -> Value {
    let continuation = trail.continuation;
    json!({
        "scene": scene.file().to_toml(),
        "turns": trail.orbits.first().map(|orbit| orbit.setting.turns()),
        "parameter": continuation.parameter,
        "to": continuation.to,
        "step": continuation.step,
        "shooting": continuation.shooting,
        "birth": trail.birth,
    })
}

/// The row of orbit `k`.
fn row(trail: &DrivenTrail, known: &Known<'_>, k: usize) -> Studied {
    let here = known.at(k);
    let before = k.checked_sub(1).and_then(|after| Some((after, known.at(after).ok()?)));
    let (found, unresolved) = match (before, here) {
        (Some((after, before)), Ok(here)) => trail.bifurcations_after(after, [before, here]),
        _ => (Vec::new(), 0),
    };
    let bifurcations = found.into_iter().map(Located::of).collect();
    Studied { measured: here.map(Measured::of).map_err(String::clone), bifurcations, unresolved }
}

/// The branch from its rows, up to the first orbit without multipliers.
fn assembled(trail: DrivenTrail, rows: Vec<Studied>) -> Result<DrivenBranch> {
    let (mut points, mut bifurcations, mut unresolved) = (Vec::new(), Vec::new(), 0);
    for (orbit, row) in trail.orbits.iter().zip(rows) {
        match row.measured {
            Ok(measured) => points.push(measured.point(orbit.clone())),
            Err(why) if points.is_empty() => {
                return Err(Error::Point { point: "the first orbit of the branch".to_owned(), why });
            }
            Err(_) => break,
        }
        bifurcations.extend(row.bifurcations.into_iter().map(|one| one.bifurcation(&trail)));
        unresolved += row.unresolved;
    }
    Ok(trail.with(points, bifurcations, unresolved))
}
