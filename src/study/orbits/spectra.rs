//! Multipliers, extents and bifurcations of a branch of dark breathers that was followed.

use super::{Branch, BranchPoint, ORBITS};
use crate::{
    error::{Error, Result},
    orbits::{Bifurcation, Continuation, End, Extent, Kantorovich, Orbit, Spectrum, Trail},
    study::{Progress, stretches},
    sweep::{Engine, Row},
};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Name of the store.
const STORE: &str = "spectra.store";

/// An orbit of a branch, as its row.
#[derive(Serialize, Deserialize)]
struct Studied {
    /// What was measured, or why there are no multipliers.
    measured: Row<Measured>,
    /// Bifurcations between the nearest orbit before that has multipliers and this one.
    bifurcations: Vec<Bifurcation>,
    /// The fold at that orbit, if the branch turns there.
    fold: Option<Bifurcation>,
}

#[derive(Serialize, Deserialize)]
struct Measured {
    spectrum: Spectrum,
    extent: Extent,
    /// `None` also if no bound was asked for.
    kantorovich: Option<Kantorovich>,
}

/// The spectra of a branch.
type Known<'a> = stretches::Known<'a, Orbit, Spectrum>;

/// Computes multipliers, extents and bifurcations of a branch that was followed, as points of a
/// sweep, and if asked for also the distance of each orbit to an exact one.
///
/// # Errors
/// As [`study`](super::study) and [`Engine::sweep`].
pub(super) fn studied(trail: Trail, bounded: bool, engine: &Engine, progress: Progress<'_>) -> Result<Branch> {
    let Trail { continuation, ref orbits, weak, .. } = trail;
    // The largest number of points has no influence on those that there are.
    let settings = Continuation { most_points: 0, ..continuation };
    let spectrum = |orbit: &Orbit| orbit.spectrum(&continuation.shooting).map(Spectrum::without_vectors);
    let known = Known::new(orbits, &spectrum);
    let tell = |share: f64, what: &str| progress(ORBITS + (1.0 - ORBITS) * share, what);
    let branch = stretches::Branch {
        store: STORE,
        study: "breather continue",
        settings: json!({ "continuation": settings, "weak": weak, "bounded": bounded }),
        known: &known,
        joined: weak.is_some(),
    };
    let determined = |orbit: &Orbit| json!([orbit.setting, orbit.z]);
    let rows = branch.rows(engine, determined, |k| row(&trail, bounded, &known, k), &tell)?;
    assembled(trail, bounded, rows)
}

/// The row of orbit `k`.
fn row(trail: &Trail, bounded: bool, known: &Known<'_>, k: usize) -> Result<Studied> {
    let Trail { continuation, orbits, weak, .. } = trail;
    let (orbit, shooting) = (&orbits[k], &continuation.shooting);
    let spectrum = match known.at(k) {
        Ok(spectrum) => spectrum,
        Err(why) => return Ok(Studied { measured: Err(why.clone()), bifurcations: Vec::new(), fold: None }),
    };
    let measured = Measured {
        spectrum: spectrum.clone(),
        extent: orbit.extent(shooting.tol)?,
        kantorovich: if bounded { orbit.kantorovich(shooting)? } else { None },
    };
    let (mut bifurcations, mut fold) = (Vec::new(), None);
    if let (Some(weak), Some((j, before))) = (*weak, known.before(k)) {
        let (here, there) = ((orbit, spectrum), (&orbits[j], before));
        bifurcations = continuation.bifurcations_between([there, here], weak);
        // Where the branch does not turn, the multipliers of a third orbit are not needed.
        if continuation.turns(&orbits[..=k]) {
            fold = known.before(j).and_then(|(i, first)| continuation.fold_at([(&orbits[i], first), there, here]));
        }
    }
    Ok(Studied { measured: Ok(measured), bifurcations, fold })
}

/// The branch from its rows. An orbit without multipliers is no point of the branch; its parameter
/// is kept in `gaps`.
fn assembled(trail: Trail, bounded: bool, rows: Vec<Studied>) -> Result<Branch> {
    let Trail { continuation, ref orbits, .. } = trail;
    let (mut points, mut gaps, mut bifurcations, mut folds) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut failure = None;
    let stopped = rows.len() < orbits.len();
    for (orbit, row) in orbits.iter().zip(rows) {
        bifurcations.extend(row.bifurcations);
        folds.extend(row.fold);
        failure = row.measured.as_ref().err().cloned();
        match row.measured {
            Ok(Measured { spectrum, extent, kantorovich }) => {
                points.push(BranchPoint { orbit: orbit.clone(), spectrum, extent, kantorovich });
            }
            Err(_) => gaps.push(orbit.setting.get(continuation.parameter)),
        }
    }
    // Now the failure of the last orbit, if it failed.
    let end = match (points.is_empty(), failure) {
        (true, Some(why)) => return Err(Error::Point { point: "the last orbit of the branch".to_owned(), why }),
        (_, failure) => End::with_multipliers(trail.end, !stopped && failure.is_none()),
    };
    bifurcations.extend(folds);
    Ok(Branch { continuation, points, gaps, bifurcations, end, bounded, trail })
}
