//! Multipliers and bifurcations of a branch as points of a sweep.
//!
//! A branch is followed orbit by orbit, each from the one before. Its multipliers and bifurcations
//! are computed afterwards, and need only the orbits. A point of this sweep is a *segment*: a few
//! consecutive orbits with their multipliers, and the bifurcations between them and the orbit
//! before. In one process all multipliers are computed once. Processes that share the segments
//! compute those of the orbit before each segment once more: with four orbits a segment, a quarter
//! more multipliers. Where rows do not need the multipliers of the orbit before, a segment has one
//! orbit.
//!
//! The key of a segment has a digest of all settings that its row depends on, and of all orbits of
//! the branch up to its last one. So a store can have rows of several branches, and a branch that
//! is followed with other settings finds none of another one.

use crate::study::Progress;
use crate::{
    error::{Error, Result},
    interrupt,
    orbits::{AnalysisLevel, Branch, Problem, Spectra},
    output::Folder,
    sweep::{Engine, Grid, digest, map},
};
use serde::Serialize;
use serde_json::{Value, json};
use std::ops::Range;

/// Orbits of a segment whose rows need the orbit before; the last one of a branch may have fewer.
const ORBITS: usize = 4;

/// A segment of a branch, as the key of its row.
#[derive(Debug, PartialEq, Serialize)]
pub struct Segment {
    /// Numbers of its orbits.
    pub orbits: Range<usize>,
    /// Digest of the settings, and of all orbits of the branch up to the last one of the segment.
    digest: String,
}

/// The segments of a branch, of `length` orbits each. `settings` has all that rows depend on
/// besides the orbits; `orbits` are all numbers that determine them.
pub fn segments<O: Serialize>(orbits: &[O], length: usize, settings: &Value) -> Vec<Segment> {
    let mut before = digest(&settings.to_string());
    let segment = |first: usize| {
        let numbers = first..orbits.len().min(first + length);
        for one in &orbits[numbers.clone()] {
            before = digest(&format!("{before} {}", json!(one)));
        }
        Segment { orbits: numbers, digest: before.clone() }
    };
    (0..orbits.len()).step_by(length).map(segment).collect()
}

/// The branch with multipliers and bifurcations, from the store of a name or computed, for the
/// command `study`. `settings` has all that rows depend on besides the orbits. If the process was
/// asked to end, there are those before the first segment that is missing.
///
/// # Errors
/// [`Error::Stopped`] in a shard; as [`Engine::sweep`].
pub(crate) fn analysed<P: Problem>(
    branch: Branch<P>,
    [store, study]: [&'static str; 2],
    settings: &Value,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<Branch<P>> {
    let (spectra, joined, needed) = (Spectra::new(&branch), branch.joined(), branch.level > AnalysisLevel::Orbits);
    let orbits: Vec<_> = branch.orbits.iter().map(|orbit| branch.numbers(orbit)).collect();
    let points = segments(&orbits, if joined { ORBITS } else { 1 }, settings);
    let grid = Grid { store, study, settings: json!({}) };
    let tell = |share: f64, _: &str| progress(share, "multipliers and bifurcations");
    let work = |segment: &Segment| {
        let Range { start, end } = segment.orbits;
        // Several threads may want the orbit before: all multipliers come first.
        map(&(start.saturating_sub(usize::from(joined))..end).collect::<Vec<_>>(), |&k| {
            unless_asked(|| Ok(needed && spectra.at(k).is_ok()))
        });
        let rows = map(&(start..end).collect::<Vec<_>>(), |&k| unless_asked(|| Ok(spectra.analysis(k))));
        rows.into_iter().collect::<Result<Vec<_>>>()
    };
    let swept = engine.sweep(&grid, &points, &tell, work)?;
    let mut rows = Vec::with_capacity(orbits.len());
    for (Segment { orbits, .. }, row) in points.iter().zip(swept.rows) {
        let point = || format!("points {} to {} of the branch", orbits.start, orbits.end - 1);
        if row.is_err() && swept.missing > 0 {
            break;
        }
        rows.extend(row.map_err(|why| Error::Point { point: point(), why })?);
    }
    Ok(branch.with(rows))
}

/// The result of `work`, unless the process was asked to end before or meanwhile: what was computed
/// meanwhile may be incomplete.
pub(crate) fn unless_asked<U>(work: impl FnOnce() -> Result<U>) -> Result<U> {
    let stopped = || Error::Stopped { kept: "nothing of this point".to_owned() };
    if interrupt::asked() {
        return Err(stopped());
    }
    let result = work();
    if interrupt::asked() { Err(stopped()) } else { result }
}

/// The folder in which a branch is kept while it is followed. A shard follows the branch for itself
/// and keeps its points only, since other shards may be at another orbit.
pub(crate) fn folder(engine: &Engine) -> Option<&Folder> {
    engine.folder().filter(|_| engine.its_shard().is_none())
}
