//! Largest values of functions of the state over a run, also between steps.

use hertzchain_integrators::{
    Error as Failure, Stats, Stepper,
    events::{Part, SHARES},
};
use std::{fmt, mem::replace, sync::Arc};

/// Parts of a step are at most this share of the period of the fastest motion.
const PART: f64 = 1.0 / 16.0;
/// Most parts of a step, however long it is.
const MOST_PARTS: f64 = 256.0;
/// A maximum inside a part is above its ends by at most this times what the value has changed in it
/// and in the part before: for a sine, whose parts are a 16th of its period or shorter, by 0.13.
const ABOVE: f64 = 1.0;
/// Changes below this share of the largest value of all are rounding errors of what is at rest.
const ROUNDING: f64 = 1e-13;
/// Places beside the ends of a part, at which slopes are looked at, as a share of the part.
const BESIDE: f64 = 1e-6;

/// Appends the values of some functions of the state. Clones share them.
#[derive(Clone)]
pub struct Observables(Arc<Values>);

type Values = dyn Fn(&[f64], &mut Vec<f64>) + Send + Sync;

impl Observables {
    /// The functions, by one that appends their values at a state.
    pub fn new(values: impl Fn(&[f64], &mut Vec<f64>) + Send + Sync + 'static) -> Self {
        Self(Arc::new(values))
    }

    fn at(&self, y: &[f64]) -> Vec<f64> {
        let mut values = Vec::new();
        (self.0)(y, &mut values);
        values
    }
}

impl fmt::Debug for Observables {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Observables")
    }
}

/// A stepper whose steps are searched for the largest values, by modulus.
///
/// A part of a step is searched where one of them rises from its start and falls to its end: its
/// maximum is that of the polynomial through eight samples, as for the overlaps of contacts.
pub(super) struct Searched<'a, S: ?Sized> {
    run: &'a mut S,
    observables: Option<&'a Observables>,
    part: f64,
    /// Time and value of each: the largest so far.
    pub(super) largest: Vec<(f64, f64)>,
    /// Values at the starts of this part and of the one before.
    before: Vec<f64>,
    earlier: Vec<f64>,
    y: Vec<f64>,
}

impl<'a, S: Stepper<f64> + ?Sized> Searched<'a, S> {
    /// Goes on from the `largest` values of earlier legs.
    pub(super) fn new(
        run: &'a mut S,
        observables: Option<&'a Observables>,
        fast: f64,
        largest: Vec<(f64, f64)>,
    ) -> Self {
        let (y, t) = (vec![0.0; if observables.is_some() { run.dim() } else { 0 }], run.time());
        let (before, earlier) = (Vec::new(), Vec::new());
        let mut searched = Self { run, observables, part: PART * fast, largest, before, earlier, y };
        searched.before = searched.at(t);
        // The first part is searched in any case.
        searched.earlier = vec![f64::INFINITY; searched.before.len()];
        if searched.largest.is_empty() {
            searched.largest = searched.before.iter().map(|value| (t, *value)).collect();
        }
        searched
    }

    fn at(&mut self, t: f64) -> Vec<f64> {
        let Some(observables) = self.observables else { return Vec::new() };
        self.run.sample(t, &mut self.y);
        observables.at(&self.y)
    }

    /// Searches a part of the last step.
    fn search(&mut self, from: f64, to: f64) {
        let after = self.at(to);
        let before = replace(&mut self.before, after.clone());
        let earlier = replace(&mut self.earlier, before.clone());
        let least = ROUNDING * self.largest.iter().fold(0.0, |most: f64, one| most.max(one.1.abs()));
        let near = |k: usize| {
            let change = (after[k] - before[k]).abs() + (before[k] - earlier[k]).abs();
            change > least && before[k].abs().max(after[k].abs()) + ABOVE * change > self.largest[k].1.abs()
        };
        let near: Vec<usize> = (0..after.len()).filter(|&k| near(k)).collect();
        for (largest, after) in self.largest.iter_mut().zip(&after).filter(|(one, after)| after.abs() > one.1.abs()) {
            *largest = (to, *after);
        }
        if near.is_empty() {
            return;
        }
        let at = |share: f64| (from + (to - from) * share).min(to);
        let [early, late] = [at(BESIDE), at(1.0 - BESIDE)].map(|t| self.at(t));
        let inside = |k: usize| early[k].abs() > before[k].abs() && late[k].abs() > after[k].abs();
        let any = near.iter().any(|&k| inside(k));
        let samples: Vec<Vec<f64>> = if any { SHARES.map(|share| self.at(at(share))).to_vec() } else { Vec::new() };
        for k in near.into_iter().filter(|&k| inside(k)) {
            let sign = 1f64.copysign(after[k]);
            let values = std::array::from_fn(|j| sign * samples[j][k]);
            let (t, value) = Part { index: k, span: (from, to), values }.curve().largest();
            if value > self.largest[k].1.abs() {
                self.largest[k] = (t, sign * value);
            }
        }
    }
}

impl<S: Stepper<f64> + ?Sized> Stepper<f64> for Searched<'_, S> {
    fn dim(&self) -> usize {
        self.run.dim()
    }

    fn time(&self) -> f64 {
        self.run.time()
    }

    fn done(&self) -> bool {
        self.run.done()
    }

    fn step(&mut self) -> Result<(), Failure> {
        let from = self.run.time();
        self.run.step()?;
        if self.observables.is_some() {
            let to = self.run.time();
            let parts = ((to - from) / self.part).ceil().clamp(1.0, MOST_PARTS) as u64;
            let end = |k: u64| if k == parts { to } else { from + (to - from) * (k as f64 / parts as f64) };
            (0..parts).for_each(|k| self.search(end(k), end(k + 1)));
        }
        Ok(())
    }

    fn steps(&mut self, wanted: Option<f64>) -> Result<(), Failure> {
        if self.observables.is_some() { self.step() } else { self.run.steps(wanted) }
    }

    fn sample(&mut self, t: f64, y: &mut [f64]) {
        self.run.sample(t, y);
    }

    fn stats(&self) -> Stats {
        self.run.stats()
    }
}
