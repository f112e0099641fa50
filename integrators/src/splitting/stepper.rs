//! The loop that runs all schemes.

use super::scheme::{First, Pair, Scheme};
use crate::{
    clock::Twofold,
    drive::Stepper,
    error::Error,
    real::{Kernel, Real},
    stats::Stats,
    system::SplitFlow,
};

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
    seam: Pair<R>,
    start: Twofold<R>,
    span: Twofold<R>,
    h: Twofold<R>,
    taken: u64,
    total: u64,
    kicks: u64,
}

impl<R: Real, S: SplitFlow<R>> Splitting<R, S> {
    /// Runs `scheme` on `flow`, which holds the state at `start`, to `end` in `steps` equal steps.
    ///
    /// `first` is the flow with which compositions begin.
    ///
    /// # Errors
    /// `end < start`, times that are not finite, or no step for a span that is not empty.
    pub fn new(scheme: &Scheme, first: First, flow: S, (start, end): (R, R), steps: u64) -> Result<Self, Error> {
        check((start, end), steps)?;
        let total = if end > start { steps } else { 0 };
        let span = Twofold::new(end) - Twofold::new(start);
        let h = span.over(Twofold::new(R::of(total.max(1) as f64)));
        let pairs: Vec<_> = scheme.pairs(first).into_iter().map(|(k, d)| (k * h, d * h)).collect();
        let (head, tail) = (pairs[0], pairs[pairs.len() - 1]);
        let zero = Twofold::zero();
        let seam = if head.0 == zero { (tail.0, tail.1 + head.1) } else { (tail.0 + head.0, head.1) };
        Ok(Self { flow, mirror: None, pairs, seam, start: Twofold::new(start), span, h, taken: 0, total, kicks: 0 })
    }

    /// The step size.
    pub fn step_size(&self) -> R {
        self.h.value()
    }

    fn time_after(&self, steps: u64) -> Twofold<R> {
        if steps == self.total { self.start + self.span } else { after(self.start, self.h, steps) }
    }
}

/// The time so many steps `h` after a start.
pub(crate) fn after<R: Real>(start: Twofold<R>, h: Twofold<R>, steps: u64) -> Twofold<R> {
    R::run(After { start, h, steps: R::of(steps as f64) })
}

/// A kernel, as it multiplies with a remainder: a call to a library where the machine's fused
/// product is not at hand.
struct After<R> {
    start: Twofold<R>,
    h: Twofold<R>,
    steps: R,
}

impl<R: Real> Kernel for After<R> {
    type Output = Twofold<R>;

    #[inline(always)]
    fn run(self) -> Twofold<R> {
        self.start + self.h * Twofold::new(self.steps)
    }
}

/// Refuses a span or a number of steps that cannot be integrated.
pub(crate) fn check<R: Real>((start, end): (R, R), steps: u64) -> Result<(), Error> {
    let argument = |name, value: R, rule| Err(Error::Argument { name, value: value.f64(), rule });
    if !start.is_finite() {
        return argument("start", start, "a time is finite");
    }
    if !(end.is_finite() && end >= start) {
        return argument("end", end, "the end is finite and not before the start");
    }
    if steps == 0 && end > start {
        return argument("steps", R::zero(), "at least one step");
    }
    Ok(())
}

/// Applies one pair and counts its kick. Only the first pair of a drift-first step has no kick.
#[inline]
fn apply<R: Real, S: SplitFlow<R>>(flow: &mut S, (kick, drift): Pair<R>, kicks: &mut u64) {
    if kick == Twofold::zero() {
        flow.drift(drift);
    } else {
        flow.kick_drift(kick.value(), drift);
        *kicks += 1;
    }
}

impl<R: Real, S: SplitFlow<R>> Stepper<R> for Splitting<R, S> {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn time(&self) -> R {
        self.time_after(self.taken).value()
    }

    fn done(&self) -> bool {
        self.taken == self.total
    }

    fn step(&mut self) -> Result<(), Error> {
        let head = if self.taken == 0 { self.pairs[0] } else { self.seam };
        apply(&mut self.flow, head, &mut self.kicks);
        for &pair in &self.pairs[1..self.pairs.len() - 1] {
            apply(&mut self.flow, pair, &mut self.kicks);
        }
        self.taken += 1;
        Ok(())
    }

    /// At the end of a step the last pair is applied to a copy. For times inside the last step, one
    /// shorter step of the same scheme goes back from its end, which is as accurate as the run.
    fn sample(&mut self, t: R, y: &mut [R]) {
        let reached = self.time_after(self.taken);
        let share = (Twofold::new(t) - reached).over(self.h);
        // Times that differ by rounding are taken as equal.
        let inside = (t - reached.value()).abs() > R::of(4.0) * R::epsilon() * t.abs();
        let mirror = match &mut self.mirror {
            Some(mirror) => {
                mirror.copy_from(&self.flow);
                mirror
            }
            empty => empty.insert(self.flow.duplicate()),
        };
        if self.taken > 0 {
            apply(mirror, self.pairs[self.pairs.len() - 1], &mut self.kicks);
        }
        if inside {
            for &(kick, drift) in &self.pairs {
                apply(mirror, (kick * share, drift * share), &mut self.kicks);
            }
        }
        mirror.store(y);
    }

    fn stats(&self) -> Stats {
        Stats { steps: self.taken, rejected: 0, force_evaluations: self.kicks }
    }
}
