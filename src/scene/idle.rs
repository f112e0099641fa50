//! Keys of a scene that change nothing.

use super::Scene;
use crate::chain::{Field, max_norm};
use hertzchain_integrators::VectorField;
use toml::{Table, Value};

/// Longest chain whose keys are tried.
const MOST_SITES: usize = 2000;
/// Tables whose keys are tried; those of other tables say how a run is made and what it keeps.
const TABLES: [&str; 6] = ["chain", "beads", "bonds", "drive", "units", "initial"];
/// Keys that must be given also where they have no effect.
const NEEDED: [&str; 3] = ["chain.alpha", "initial.site", "beads.mass.except"];
/// Distances from the initial state at which motions are compared, in units of length, and in units
/// of the largest overlap or gap.
const DISTANCES: [f64; 8] = [0.0, 1e-6, 1e-3, 1.0, 1e-6, 1e-3, 1.0, 10.0];

impl Scene {
    /// The keys that are given and change nothing, in words: with another value of the key all
    /// states move in the same way. Zeros, words, and numbers of the chain in whose place tables
    /// have others are not tried.
    pub(crate) fn idle(&self) -> Vec<String> {
        let (text, mut keys) = (self.file.to_toml(), Vec::new());
        let table = text.parse::<Table>().unwrap_or_default();
        for (name, value) in table.iter().filter(|(name, _)| TABLES.contains(&name.as_str())) {
            varied(value, name, &mut keys);
        }
        let own =
            |name: &str| ["beads", "bonds"].iter().any(|of| table.get(*of).is_some_and(|of| of.get(name).is_some()));
        keys.retain(|(key, value)| {
            let other = || Self::parse_with(&text, self.name(), &[format!("{key}={value}")]);
            let tried = self.chain.sites() <= MOST_SITES && !NEEDED.contains(&key.as_str());
            let tried = tried && !key.strip_prefix("chain.").is_some_and(own);
            tried && other().is_ok_and(|other| self.moves_as(&other, key.starts_with("drive")))
        });
        let words = keys.into_iter().map(|(key, _)| {
            let tied = ["kappa", "rho", "resonator"].iter().any(|name| key.ends_with(name));
            let why = if tied { ": a resonator needs a spring and a mass, kappa and rho above 0" } else { "" };
            format!("{key} changes nothing in this scene{why}")
        });
        words.collect()
    }

    /// Whether another scene has the same units, span and motion, and the same drives if they are
    /// asked for.
    fn moves_as(&self, other: &Self, drives: bool) -> bool {
        let course = |scene: &Self| scene.chain.details().map(|details| details.drives.clone()).unwrap_or_default();
        let span = |scene: &Self| (scene.units, scene.end, scene.period);
        let overlaps = self.chain.overlaps(self.chain.layout().u(self.initial.as_slice()));
        let largest = max_norm(overlaps.into_iter().filter(|overlap| overlap.is_finite()));
        let moves = |(k, share)| {
            let mut distances = [share, share * largest].into_iter();
            distances.all(|distance| self.motion(k, distance) == other.motion(k, distance))
        };
        span(self) == span(other)
            && (!drives || course(self) == course(other))
            && DISTANCES.into_iter().enumerate().all(moves)
    }

    /// State and accelerations at a distance from the initial state, at one of a few times.
    fn motion(&self, k: usize, distance: f64) -> Vec<f64> {
        let (mut y, t) = (self.initial.as_slice().to_vec(), self.end * k as f64 / DISTANCES.len() as f64);
        let mut dy = vec![0.0; y.len()];
        y.iter_mut().enumerate().for_each(|(i, y)| *y += distance * ((1.7 + 1.9 * k as f64) * (1.0 + i as f64)).sin());
        Field::new(self.chain.clone()).eval(t, &y, &mut dy);
        y.extend_from_slice(&dy[self.chain.layout().half()..]);
        y
    }
}

/// The keys below `path` that have numbers other than zero or `true`, with other values.
fn varied(value: &Value, path: &str, keys: &mut Vec<(String, Value)>) {
    match value {
        Value::Table(table) => table.iter().for_each(|(key, value)| varied(value, &format!("{path}.{key}"), keys)),
        Value::Array(all) if all.iter().any(Value::is_table) => {
            all.iter().enumerate().for_each(|(k, value)| varied(value, &format!("{path}.{k}"), keys));
        }
        _ => keys.extend(other(value).filter(|other| other != value).map(|other| (path.to_owned(), other))),
    }
}

/// The value with numbers other than zero, and `true`, changed; none for words.
fn other(value: &Value) -> Option<Value> {
    match value {
        Value::Integer(x) => Some(if *x == 0 { 0 } else { x + 1 }.into()),
        Value::Float(x) => Some(if x.is_finite() { 0.75 * x } else { 1.0 }.into()),
        Value::Boolean(_) => Some(false.into()),
        Value::Array(all) => all.iter().map(other).collect::<Option<Vec<_>>>().map(Value::Array),
        _ => None,
    }
}
