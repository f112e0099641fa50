//! Multipliers and bifurcations of a branch as points of a sweep.
//!
//! A branch is followed orbit by orbit, each from the one before. Its multipliers and bifurcations
//! are computed afterwards, and need only the orbits. A point of this sweep is a *stretch*: a few
//! consecutive orbits with their multipliers, and the bifurcations between them and the orbit
//! before. In one process all multipliers are computed once. Processes that share the stretches
//! compute those of the orbit before each stretch once more: with four orbits a stretch, a quarter
//! more multipliers. Where rows do not need the multipliers of the orbit before, a stretch has one
//! orbit.
//!
//! The key of a stretch has a digest of all settings that its row depends on, and of all orbits of
//! the branch up to its last one. So a store can have rows of several branches, and a branch that
//! is followed with other settings finds none of another one.

use super::Progress;
use crate::{
    error::{Error, Result},
    interrupt,
    output::Folder,
    sweep::{Engine, Grid, Row, digest, map},
};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Value, json};
use std::{ops::Range, sync::OnceLock};

/// Orbits of a stretch whose rows need the orbit before; the last one of a branch may have fewer.
const ORBITS: usize = 4;

/// What is known of each orbit of a branch, computed when it is first asked for, or why it is not.
pub(super) struct Known<'a, O, K> {
    orbits: &'a [O],
    compute: &'a (dyn Fn(&O) -> Result<K> + Sync),
    all: Vec<OnceLock<Row<K>>>,
}

impl<'a, O, K> Known<'a, O, K> {
    pub(super) fn new(orbits: &'a [O], compute: &'a (dyn Fn(&O) -> Result<K> + Sync)) -> Self {
        Self { orbits, compute, all: orbits.iter().map(|_| OnceLock::new()).collect() }
    }

    /// What is known of orbit `k`.
    pub(super) fn at(&self, k: usize) -> std::result::Result<&K, &String> {
        let compute = || (self.compute)(&self.orbits[k]).map_err(|why| why.to_string());
        self.all[k].get_or_init(compute).as_ref()
    }

    /// The nearest orbit before `k` that is known, and what is known of it.
    pub(super) fn before(&self, k: usize) -> Option<(usize, &K)> {
        (0..k).rev().find_map(|k| Some((k, self.at(k).ok()?)))
    }
}

/// A stretch of a branch, as the key of its row.
#[derive(Debug, PartialEq, Serialize)]
struct Stretch {
    /// Numbers of its orbits.
    orbits: Range<usize>,
    /// Digest of the settings, and of all orbits of the branch up to the last one of the stretch.
    digest: String,
}

/// The stretches of a branch, of `length` orbits each. `settings` has all that rows depend on
/// besides the orbits, and `orbit` all numbers that determine an orbit.
fn stretches<O>(orbits: &[O], length: usize, settings: &Value, orbit: impl Fn(&O) -> Value) -> Vec<Stretch> {
    let mut before = digest(&settings.to_string());
    let stretch = |first: usize| {
        let numbers = first..orbits.len().min(first + length);
        for one in &orbits[numbers.clone()] {
            before = digest(&format!("{before} {}", orbit(one)));
        }
        Stretch { orbits: numbers, digest: before.clone() }
    };
    (0..orbits.len()).step_by(length).map(stretch).collect()
}

/// A branch whose rows are wanted.
pub(super) struct Branch<'a, O, K> {
    /// Name of the store.
    pub(super) store: &'static str,
    /// Name of the command.
    pub(super) study: &'static str,
    /// All that rows depend on besides the orbits.
    pub(super) settings: Value,
    /// The orbits, and what rows are made from.
    pub(super) known: &'a Known<'a, O, K>,
    /// Whether rows need what is known of the orbit before.
    pub(super) joined: bool,
}

impl<O: Sync, K: Send + Sync> Branch<'_, O, K> {
    /// A row for every orbit, from the store or computed: `row` makes that of the orbit with a
    /// number. `orbit` has all numbers that determine an orbit. If the process was asked to end,
    /// the rows are those before the first one that is missing.
    ///
    /// # Errors
    /// Errors of `row`; [`Error::Stopped`] in a shard; as [`Engine::sweep`].
    pub(super) fn rows<U: Serialize + DeserializeOwned + Send>(
        &self,
        engine: &Engine,
        orbit: impl Fn(&O) -> Value,
        row: impl Fn(usize) -> Result<U> + Sync,
        progress: Progress<'_>,
    ) -> Result<Vec<U>> {
        let Self { store, study, ref settings, known, joined } = *self;
        let points = stretches(known.orbits, if joined { ORBITS } else { 1 }, settings, orbit);
        let grid = Grid { store, study, settings: json!({}) };
        let tell = |share: f64, _: &str| progress(share, "multipliers and bifurcations");
        let work = |stretch: &Stretch| {
            let Range { start, end } = stretch.orbits;
            // Several threads may want the orbit before: all multipliers come first.
            map(&(start.saturating_sub(usize::from(joined))..end).collect::<Vec<_>>(), |&k| {
                unless_asked(|| Ok(known.at(k).is_ok()))
            });
            let rows = map(&(start..end).collect::<Vec<_>>(), |&k| unless_asked(|| row(k)));
            rows.into_iter().collect::<Result<Vec<U>>>()
        };
        let alone = engine.its_shard().is_none();
        if !alone && interrupt::asked() {
            // A shard of a part of the branch is not the shard that was asked for.
            return Err(Error::Stopped { kept: "what this shard had before".to_owned() });
        }
        let swept = engine.sweep(&grid, &points, &tell, work)?;
        if swept.missing > 0 && !alone {
            let (kept, total) = (swept.rows.iter().filter(|row| row.is_ok()).count(), points.len());
            return Err(Error::Stopped { kept: format!("multipliers of {kept} of {total} stretches of the branch") });
        }
        let mut all = Vec::with_capacity(known.orbits.len());
        for (Stretch { orbits, .. }, row) in points.iter().zip(swept.rows) {
            let point = || format!("points {} to {} of the branch", orbits.start, orbits.end - 1);
            if row.is_err() && swept.missing > 0 {
                break;
            }
            all.extend(row.map_err(|why| Error::Point { point: point(), why })?);
        }
        Ok(all)
    }
}

/// The result of `work`, unless the process was asked to end before or meanwhile: what was computed
/// meanwhile may be incomplete.
pub(super) fn unless_asked<U>(work: impl FnOnce() -> Result<U>) -> Result<U> {
    let stopped = || Error::Stopped { kept: "nothing of this point".to_owned() };
    if interrupt::asked() {
        return Err(stopped());
    }
    let result = work();
    if interrupt::asked() { Err(stopped()) } else { result }
}

/// The results that were made by [`unless_asked`]; those that were finished, after the process was
/// asked to end.
pub(super) fn finished<U>(results: Vec<Result<U>>) -> Result<Vec<U>> {
    let any = results.iter().any(Result::is_ok);
    let stopped = |result: &Result<U>| any && matches!(result, Err(Error::Stopped { .. }));
    results.into_iter().filter(|result| !stopped(result)).collect()
}

/// The folder in which a branch is kept while it is followed. A shard follows the branch for itself
/// and keeps its points only, since other shards may be at another orbit.
pub(super) fn folder(engine: &Engine) -> Option<&Folder> {
    engine.folder().filter(|_| engine.its_shard().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_has_another_key_if_an_orbit_before_it_or_a_setting_differs() {
        let keys = |orbits: &[f64], setting: f64| stretches(orbits, 4, &json!({ "to": setting }), |x| json!(x));
        let branch: Vec<f64> = (0..10).map(f64::from).collect();
        let all = keys(&branch, 1.0);
        let numbers: Vec<Range<usize>> = all.iter().map(|one| one.orbits.clone()).collect();
        assert_eq!(numbers, [0..4, 4..8, 8..10]);
        assert_eq!(keys(&branch, 1.0), all);
        // A longer branch has the same stretches but for the last one.
        let longer: Vec<f64> = (0..11).map(f64::from).collect();
        assert_eq!(keys(&longer, 1.0)[..2], all[..2]);
        for (k, later) in [(0, 0), (3, 0), (4, 1), (9, 2)] {
            let mut other = branch.clone();
            other[k] = other[k].next_up();
            let same: Vec<bool> = keys(&other, 1.0).iter().zip(&all).map(|(a, b)| a == b).collect();
            assert_eq!(same, [0, 1, 2].map(|stretch| stretch < later));
        }
        assert!(keys(&branch, 1.0_f64.next_up()).iter().zip(&all).all(|(a, b)| a != b));
    }

    #[test]
    fn what_is_known_is_computed_once_and_gaps_are_passed_over() {
        let calls = std::sync::atomic::AtomicUsize::new(0);
        let root = |x: &f64| {
            calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if *x < 0.0 { Err(Error::parameter("x", x, "at least zero")) } else { Ok(x.sqrt()) }
        };
        let orbits = [4.0, -1.0, -1.0, 9.0];
        let known = Known::new(&orbits, &root);
        assert_eq!((known.before(3), known.before(0)), (Some((0, &2.0)), None));
        assert_eq!((known.at(3), known.at(0)), (Ok(&3.0), Ok(&2.0)));
        assert!(known.at(2).is_err());
        assert_eq!(calls.into_inner(), 4);
    }
}
