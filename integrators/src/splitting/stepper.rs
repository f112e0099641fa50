//! The loop that runs all schemes.

use super::{
    scheme::{First, Pair, Scheme},
    steps::Steps,
};
use crate::{
    clock::DoubleDouble, drive::Stepper, error::Error, interrupt, real::Real, stats::Stats, system::SplitFlow,
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
pub struct Splitting<R, S> {
    flow: S,
    /// The copy of the flow for samples; made at the first sample.
    mirror: Option<S>,
    pairs: Vec<Pair<R>>,
    /// The (kick, drift) pairs of as many steps as are made in a row. Each step begins with the
    /// seam, its first pair merged with the last one of the step before; its inner pairs follow.
    row: Vec<(R, DoubleDouble<R>)>,
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
        let steps = Steps::new(span, steps)?;
        let part = |share: DoubleDouble<R>| share * steps.h;
        let shares = scheme.pairs(first);
        let pairs: Vec<Pair<R>> = shares.iter().map(|&(kick, drift)| (part(kick), part(drift))).collect();
        let (head, tail) = (shares[0], shares[shares.len() - 1]);
        let seam = if head.0 == DoubleDouble::zero() {
            (part(tail.0), part(tail.1) + part(head.1))
        } else {
            (part(tail.0) + part(head.0), part(head.1))
        };
        let inner = pairs.len() - 1;
        let step = [seam].into_iter().chain(pairs[1..inner].iter().copied()).map(|(kick, drift)| (kick.hi, drift));
        let row = step.collect::<Vec<_>>().repeat(steps_a_row(flow.moved() * inner));
        Ok(Self { flow, mirror: None, pairs, row, inner, steps, kicks: 0 })
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
pub(super) fn mirrored<'a, R: Real, S: SplitFlow<R>>(mirror: &'a mut Option<S>, flow: &S) -> &'a mut S {
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
fn apply<R: Real, S: SplitFlow<R>>(flow: &mut S, (kick, drift): Pair<R>, kicks: &mut u64) {
    if kick == DoubleDouble::zero() {
        flow.drift(drift);
    } else {
        flow.kick_drift(kick.hi, drift);
        *kicks += 1;
    }
}

impl<R: Real, S: SplitFlow<R>> Stepper<R> for Splitting<R, S> {
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
            for &(kick, drift) in &self.pairs {
                apply(mirror, (kick * share, drift * share), &mut self.kicks);
            }
        }
        mirror.store(y);
    }

    fn stats(&self) -> Stats {
        Stats { steps: self.steps.taken, rejected: 0, force_evaluations: self.kicks }
    }
}
