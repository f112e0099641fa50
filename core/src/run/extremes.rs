//! Largest values of functions of the state over a run, also between steps.

use hertzchain_integrators::{
    Stepper,
    events::{Part, SHARES, parts},
};
use std::{fmt, iter::once, mem::replace, sync::Arc};

/// Parts of a step are at most this share of the period of the fastest motion.
pub(super) const PART: f64 = 1.0 / 16.0;
/// A maximum inside a part is above its ends by at most this times what the value has changed in it
/// and in the part before: for a sine, whose parts are a 16th of its period or shorter, by 0.13.
const ABOVE: f64 = 1.0;
/// Changes below this share of the largest value of a kind are rounding errors of what is at rest.
const ROUNDING: f64 = 1e-13;

/// Appends the values of some functions of the state. Clones share them.
#[derive(Clone)]
pub struct Observables {
    values: Arc<Values>,
    kinds: Arc<[usize]>,
}

type Values = dyn Fn(&[f64], &mut Vec<f64>) + Send + Sync;

impl Observables {
    /// The functions, by one that appends their values at a state.
    pub fn new(values: impl Fn(&[f64], &mut Vec<f64>) + Send + Sync + 'static) -> Self {
        Self { values: Arc::new(values), kinds: Arc::default() }
    }

    /// Numbers the kinds of the values, such as lengths and forces, in the order of values: only
    /// those of one kind are compared with each other. Without this all are of one kind.
    #[must_use]
    pub fn of_kinds(mut self, kinds: impl Into<Arc<[usize]>>) -> Self {
        self.kinds = kinds.into();
        self
    }

    pub(super) fn kind(&self, k: usize) -> Option<usize> {
        self.kinds.get(k).copied()
    }

    pub(super) fn at(&self, y: &[f64]) -> Vec<f64> {
        let mut values = Vec::new();
        (self.values)(y, &mut values);
        values
    }
}

impl fmt::Debug for Observables {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Observables")
    }
}

/// The search of the steps of a run for the largest values, by modulus.
///
/// A part of a step in which one of them may have risen and fallen is sampled at the maximum of the
/// polynomial through eight samples, which may overshoot where the motion is not smooth.
pub(super) struct Search {
    observables: Observables,
    /// Longest part of a step.
    part: f64,
    /// Time and value of each: the largest so far.
    pub(super) largest: Vec<(f64, f64)>,
    /// Values at the starts of this part and of the one before.
    before: Vec<f64>,
    earlier: Vec<f64>,
    y: Vec<f64>,
}

impl Search {
    /// Goes on from the `largest` values of earlier legs; `part` is the longest part of a step that
    /// is searched at once.
    pub(super) fn new(
        run: &mut (impl Stepper<f64> + ?Sized),
        observables: &Observables,
        part: f64,
        largest: Vec<(f64, f64)>,
    ) -> Self {
        let (y, t) = (vec![0.0; run.dim()], run.time());
        let mut search =
            Self { observables: observables.clone(), part, largest, before: Vec::new(), earlier: Vec::new(), y };
        search.before = search.at(run, t);
        // The first part is searched in any case.
        search.earlier = vec![f64::INFINITY; search.before.len()];
        if search.largest.is_empty() {
            search.largest = search.before.iter().map(|value| (t, *value)).collect();
        }
        search
    }

    /// Searches the last step of the run, which began at `from`.
    pub(super) fn step(&mut self, run: &mut (impl Stepper<f64> + ?Sized), from: f64) {
        let to = run.time();
        // Not more than 256, however long the step is.
        parts((from, to), self.part.max((to - from) / 256.0)).for_each(|part| self.search(run, part));
    }

    fn at(&mut self, run: &mut (impl Stepper<f64> + ?Sized), t: f64) -> Vec<f64> {
        run.sample(t, &mut self.y);
        self.observables.at(&self.y)
    }

    /// Searches a part of the last step, after those before it.
    pub(super) fn search(&mut self, run: &mut (impl Stepper<f64> + ?Sized), (from, to): (f64, f64)) {
        let after = self.at(run, to);
        let before = replace(&mut self.before, after.clone());
        let earlier = replace(&mut self.earlier, before.clone());
        let mut most = vec![0.0f64; self.observables.kinds.iter().max().map_or(1, |last| last + 1)];
        for (k, one) in self.largest.iter().enumerate() {
            let of_kind = &mut most[self.observables.kind(k).unwrap_or(0)];
            *of_kind = of_kind.max(one.1.abs());
        }
        let near = |k: usize| {
            let change = (after[k] - before[k]).abs() + (before[k] - earlier[k]).abs();
            change > ROUNDING * most[self.observables.kind(k).unwrap_or(0)]
                && before[k].abs().max(after[k].abs()) + ABOVE * change > self.largest[k].1.abs()
        };
        let near: Vec<usize> = (0..after.len()).filter(|&k| near(k)).collect();
        for (largest, after) in self.largest.iter_mut().zip(&after).filter(|(one, after)| after.abs() > one.1.abs()) {
            *largest = (to, *after);
        }
        if near.is_empty() {
            return;
        }
        let [_, inner @ .., _] = SHARES;
        let inner = inner.map(|share| self.at(run, from + (to - from) * share));
        let samples = || once(&before).chain(&inner).chain(once(&after));
        for k in near {
            let sign = 1f64.copysign(after[k]);
            let mut values = [0.0; SHARES.len()];
            values.iter_mut().zip(samples()).for_each(|(value, sample)| *value = sign * sample[k]);
            let (t, most) = Part { index: k, span: (from, to), values }.curve().largest();
            if most > self.largest[k].1.abs() {
                let value = self.at(run, t)[k];
                if value.abs() > self.largest[k].1.abs() {
                    self.largest[k] = (t, value);
                }
            }
        }
    }
}
