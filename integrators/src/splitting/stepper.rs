//! The loop that runs all schemes.

use super::{
    scheme::{First, Pair, Scheme},
    steps::Steps,
};
use crate::{
    clock::DoubleDouble, drive::Stepper, error::Error, interrupt, lanes::Coefficient, real::Real, stats::Stats,
    system::SplitFlow,
};

/// Largest number of steps made in a row, without a look at the observer in between.
const STEPS_A_ROW: usize = 64;
/// Largest number of components times kicks in such a row: about a tenth of a second of work.
const NUMBERS_A_ROW: usize = 1 << 30;

/// A splitting scheme with a fixed number of equal steps.
///
/// The last pair of each step is kept back and merged with the first of the next.
/// [`sample`](Stepper::sample) applies it to a copy, so that samples do not change the bits of a
/// run.
pub struct Splitting<R, S, K = R> {
    flow: S,
    /// The copy of the flow for samples; made at the first sample.
    mirror: Option<S>,
    pairs: Vec<Pair<K>>,
    /// The (kick, drift) pairs of as many steps as are made in a row. Each step begins with the
    /// seam, its first pair merged with the last one of the step before; its inner pairs follow.
    row: Vec<(K, DoubleDouble<K>)>,
    /// Number of pairs of `row` that belong to one step.
    inner: usize,
    steps: Steps<R>,
    kicks: u64,
}

impl<R: Real, S: SplitFlow<R>> Splitting<R, S> {
    /// Runs `scheme` on `flow`, which holds the state at `start`, to `end` in `steps` equal steps.
    ///
    /// `first` is the flow with which compositions begin.
    ///
    /// # Errors
    /// `end < start`, times that are not finite, or no step for a span that is not empty.
    pub fn new(scheme: &Scheme, first: First, flow: S, span: (R, R), steps: u64) -> Result<Self, Error> {
        Self::abreast(scheme, first, flow, &[span], steps)
    }
}

impl<R: Real, K: Coefficient<R>, S: SplitFlow<R, K>> Splitting<R, S, K> {
    /// As [`new`](Splitting::new), for systems abreast, each over a span of its own in equally many
    /// steps. Times are those of the first system. Samples inside steps have no meaning unless all
    /// spans are equal.
    ///
    /// # Errors
    /// As [`new`](Splitting::new).
    pub fn abreast(scheme: &Scheme, first: First, flow: S, spans: &[(R, R)], steps: u64) -> Result<Self, Error> {
        let mut all = spans.iter().map(|&span| Steps::new(span, steps)).collect::<Result<Vec<_>, _>>()?;
        let h = |lane: usize| all[lane.min(all.len() - 1)].h;
        let part = |share: DoubleDouble<R>| K::twofold(|lane| share * h(lane));
        let both = |a: DoubleDouble<R>, b: DoubleDouble<R>| K::twofold(|lane| a * h(lane) + b * h(lane));
        let shares = scheme.pairs(first);
        let pairs: Vec<Pair<K>> = shares.iter().map(|&(kick, drift)| (part(kick), part(drift))).collect();
        let (head, tail) = (shares[0], shares[shares.len() - 1]);
        let seam = if head.0 == DoubleDouble::zero() {
            (part(tail.0), both(tail.1, head.1))
        } else {
            (both(tail.0, head.0), part(head.1))
        };
        let inner = pairs.len() - 1;
        let in_row = steps_a_row(flow.moved() * inner);
        let step = [seam].into_iter().chain(pairs[1..inner].iter().copied()).map(|(kick, drift)| (kick.hi, drift));
        let row = step.cycle().take(in_row * inner).collect();
        Ok(Self { flow, mirror: None, pairs, row, inner, steps: all.swap_remove(0), kicks: 0 })
    }

    /// Makes `steps` steps. The first step of the run begins with its own first pair, not with a
    /// seam.
    fn run(&mut self, steps: usize) {
        let mut row = &self.row[..steps * self.inner];
        if self.steps.taken == 0 {
            apply(&mut self.flow, self.pairs[0], &mut self.kicks);
            row = &row[1..];
        }
        self.flow.kick_drifts(row);
        self.kicks += row.len() as u64;
        self.steps.taken += steps as u64;
    }
}

/// Number of steps made in a row, where `numbers` is that of components times kicks in one step.
pub(crate) fn steps_a_row(numbers: usize) -> usize {
    (NUMBERS_A_ROW / numbers.max(1)).clamp(1, STEPS_A_ROW)
}

/// The copy of a flow, which is made at its first use.
pub(super) fn mirrored<'a, R: Real, K: Copy, S: SplitFlow<R, K>>(mirror: &'a mut Option<S>, flow: &S) -> &'a mut S {
    match mirror {
        Some(mirror) => {
            mirror.copy_from(flow);
            mirror
        }
        empty => empty.insert(flow.duplicate()),
    }
}

/// Applies one pair and counts its kick. Only the first pair of a drift-first step has no kick.
#[inline]
fn apply<R: Real, K: Coefficient<R>, S: SplitFlow<R, K>>(flow: &mut S, (kick, drift): Pair<K>, kicks: &mut u64) {
    if K::of_lane(kick, 0) == DoubleDouble::zero() {
        flow.drift(drift);
    } else {
        flow.kick_drift(kick.hi, drift);
        *kicks += 1;
    }
}

impl<R: Real, K: Coefficient<R>, S: SplitFlow<R, K>> Stepper<R> for Splitting<R, S, K> {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn time(&self) -> R {
        self.steps.reached().value()
    }

    fn done(&self) -> bool {
        self.steps.done()
    }

    fn step(&mut self) -> Result<(), Error> {
        interrupt::check(self.time().f64())?;
        self.run(1);
        Ok(())
    }

    fn steps(&mut self, wanted: Option<R>) -> Result<(), Error> {
        interrupt::check(self.time().f64())?;
        self.run(self.steps.in_row(wanted, self.row.len() / self.inner));
        Ok(())
    }

    /// At the end of a step the last pair is applied to a copy. For times inside the last step, one
    /// shorter step of the same scheme goes back from its end, which is as accurate as the run.
    fn sample(&mut self, t: R, y: &mut [R]) {
        let share = (DoubleDouble::new(t) - self.steps.reached()).over(self.steps.h);
        let mirror = mirrored(&mut self.mirror, &self.flow);
        if self.steps.taken > 0 {
            apply(mirror, self.pairs[self.pairs.len() - 1], &mut self.kicks);
        }
        if self.steps.inside(t) {
            let part = |whole: DoubleDouble<K>| K::twofold(|lane| K::of_lane(whole, lane) * share);
            for &(kick, drift) in &self.pairs {
                apply(mirror, (part(kick), part(drift)), &mut self.kicks);
            }
        }
        mirror.store(y);
    }

    fn stats(&self) -> Stats {
        Stats { steps: self.steps.taken, rejected: 0, force_evaluations: self.kicks }
    }
}
