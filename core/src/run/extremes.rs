//! Largest values of functions of the state over a run, also between steps.

use crate::chain::{Chain, Overlaps};
use hertzchain_integrators::{
    EventFunctions, Stepper,
    events::{Curve, NODES, SHARES, bracketed, parts},
};
use std::{fmt, iter::once, mem::replace, sync::Arc};

/// Parts of a step are at most this share of the period of the fastest motion.
pub(super) const PART: f64 = 1.0 / 16.0;
/// A maximum inside a part is above its ends by at most this times what the value has changed in it
/// and in the part before: for a sine, whose parts are a 16th of its period or shorter, by 0.13.
const ABOVE: f64 = 1.0;
/// Changes below this share of the largest value of a kind are rounding errors of what is at rest.
const ROUNDING: f64 = 1e-13;
/// Distance from the zero of an overlap at which the force before it and after it is taken, as a
/// share of the part. Chosen.
const BESIDE: f64 = 1e-12;

/// A polynomial is that of the values if it has the value at its maximum up to this share, whose
/// square is the error of the maximum; if not, it is taken anew on a third of its stretch, at most
/// this number of times. Chosen.
const AGREED: f64 = 1e-8;
const ROUNDS: usize = 8;

/// Order of the root of the time after a cut in which forces are smooth. Chosen.
const ORDER: u32 = 4;

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
/// polynomial through eight samples, which may overshoot where the motion is not smooth. Where a
/// contact that dissipates closes or opens, its force may jump: parts are cut there, and what
/// follows is a polynomial in a root of the time since.
pub(super) struct Search {
    /// The overlaps of a chain, the bonds of it that dissipate, and which root.
    cuts: Option<(Overlaps<f64>, Vec<usize>, u32)>,
    /// Overlaps of these bonds at the start of this part, the value up to which they are rounding
    /// errors, and the time of the last cut.
    overlaps: Vec<f64>,
    band: f64,
    cut: f64,
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
        run: &mut dyn Stepper<f64>,
        observables: &Observables,
        part: f64,
        largest: Vec<(f64, f64)>,
    ) -> Self {
        let (y, t) = (vec![0.0; run.dim()], run.time());
        let mut search = Self {
            cuts: None,
            overlaps: Vec::new(),
            band: 0.0,
            cut: f64::NEG_INFINITY,
            observables: observables.clone(),
            part,
            largest,
            before: Vec::new(),
            earlier: Vec::new(),
            y,
        };
        search.begin(run, t);
        search
    }

    /// Cuts parts at the events of contacts of a chain that dissipate.
    pub(super) fn cut_at_events(mut self, chain: &Chain<f64>) -> Self {
        let (overlaps, bonds) = (Overlaps::new(chain.clone()), chain.lossy());
        self.overlaps = bonds.iter().map(|&bond| overlaps.of(bond, &self.y)[0]).collect();
        self.cuts = Some((overlaps, bonds, chain.powers_at_events(ORDER).1));
        self
    }

    /// Begins anew at a time: the part after it is searched in any case.
    fn begin(&mut self, run: &mut dyn Stepper<f64>, t: f64) {
        self.before = self.at(run, t);
        self.earlier = vec![f64::INFINITY; self.before.len()];
        self.largest.resize(self.before.len(), (t, 0.0));
        self.take(t);
    }

    /// Takes the values at the start of a part.
    fn take(&mut self, t: f64) {
        let larger = |(one, value): &(&mut (f64, f64), &f64)| value.abs() > one.1.abs();
        self.largest.iter_mut().zip(&self.before).filter(larger).for_each(|(one, value)| *one = (t, *value));
    }

    /// The times before and after each zero of an overlap that dissipates, in order of time.
    fn zeros(&mut self, run: &mut dyn Stepper<f64>, (from, to): (f64, f64)) -> Vec<[f64; 2]> {
        let Self { cuts: Some((overlaps, bonds, _)), y, .. } = self else { return Vec::new() };
        let (mut zeros, before) = (Vec::new(), self.overlaps.clone());
        run.sample(to, y);
        self.overlaps = bonds.iter().map(|&bond| overlaps.of(bond, y)[0]).collect();
        self.band = self.band.max(overlaps.band(y));
        for ((&bond, &before), &after) in bonds.iter().zip(&before).zip(&self.overlaps) {
            let band = self.band;
            if (before > band) == (after > band) {
                continue;
            }
            let mut at = |t: f64| {
                run.sample(t.clamp(from, to), y);
                overlaps.of(bond, y)[0] - band
            };
            let zero = bracketed(&mut at, (from, before - band), (to, after - band));
            let mut by = BESIDE * (to - from) + 4.0 * f64::EPSILON * to.abs();
            while by < to - from && (at(zero - by) > 0.0) == (at(zero + by) > 0.0) {
                by *= 2.0;
            }
            zeros.push([zero - by, zero + by].map(|t| t.clamp(from, to)));
        }
        zeros.sort_by(|a, b| a[0].total_cmp(&b[0]));
        zeros
    }

    /// Searches the last step of the run, which began at `from`.
    pub(super) fn step(&mut self, run: &mut dyn Stepper<f64>, from: f64) {
        let to = run.time();
        // Not more than 256, however long the step is.
        parts((from, to), self.part.max((to - from) / 256.0)).for_each(|part| self.search(run, part));
    }

    fn at(&mut self, run: &mut dyn Stepper<f64>, t: f64) -> Vec<f64> {
        run.sample(t, &mut self.y);
        self.observables.at(&self.y)
    }

    /// Searches a part of the last step, after those before it.
    pub(super) fn search(&mut self, run: &mut dyn Stepper<f64>, (mut from, to): (f64, f64)) {
        for [before, after] in self.zeros(run, (from, to)) {
            if before > from {
                self.search_between(run, (from, before));
            }
            from = from.max(after);
            self.begin(run, from);
            self.cut = from;
        }
        if from < to {
            self.search_between(run, (from, to));
        }
    }

    /// Searches a part between cuts.
    fn search_between(&mut self, run: &mut dyn Stepper<f64>, (from, to): (f64, f64)) {
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
        self.take(to);
        if near.is_empty() {
            return;
        }
        // Far from the cut the variable is time.
        let (origin, q) = match &self.cuts {
            Some((.., q)) if from - self.cut < to - from => (self.cut, *q),
            _ => (from, 1),
        };
        let sigma = |t: f64| (t - origin).powf(f64::from(q).recip());
        let times =
            |[first, last]: [f64; 2]| SHARES.map(|share| origin + (first + (last - first) * share).powi(q as i32));
        let [_, inner @ .., _] = times([from, to].map(sigma));
        let samples: Vec<_> = once(before).chain(inner.map(|t| self.at(run, t))).chain(once(after)).collect();
        for k in near {
            let sign = 1f64.copysign(samples[NODES - 1][k]);
            let (mut stretch, mut values) = ([from, to].map(sigma), std::array::from_fn(|i| samples[i][k]));
            for _ in 0..ROUNDS {
                let points = SHARES.into_iter().zip(values.map(|value: f64| sign * value));
                let (t, most) = Curve::new((origin, 1.0, q), stretch, (from, to), points).largest();
                if most <= self.largest[k].1.abs() {
                    break;
                }
                let value = self.at(run, t)[k];
                if value.abs() > self.largest[k].1.abs() {
                    self.largest[k] = (t, value);
                }
                if (value.abs() - most).abs() <= AGREED * most {
                    break;
                }
                let ([first, last], middle) = (stretch, sigma(t));
                let by = (last - first) / 6.0;
                stretch = [(middle - by).max(first), (middle + by).min(last)];
                values = times(stretch).map(|t| self.at(run, t.clamp(from, to))[k]);
            }
        }
    }
}
