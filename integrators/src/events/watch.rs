//! A stepper that is searched for events.

use super::{
    Curve, Event, EventFunctions,
    bernstein::{NODES, SHARES},
    root::bracketed,
    sides::{Crossing, Sides},
};
use crate::{drive::Stepper, error::Error, real::Real, stats::Stats};
use std::ops::ControlFlow;

/// A listener for events. It selects directions and terminal events itself: it ignores the events
/// it does not need, and ends the run by returning `Break`.
pub trait Listener<R> {
    /// Receives an event, with the state at its time.
    fn event(&mut self, event: Event<R>, y: &[R]) -> ControlFlow<()>;

    /// Receives a part of a step in which a function is positive: after the event that begins it,
    /// before the event that ends it. The run can be sampled in that step.
    fn positive(&mut self, _part: &Part<R>, _run: &mut dyn Stepper<R>) {}
}

/// A part of a step in which a function is positive.
#[derive(Clone, Copy, Debug)]
pub struct Part<R> {
    /// Index of the function.
    pub index: usize,
    /// Start and end time.
    pub span: (R, R),
    /// The function at [`SHARES`] of the span; over the span it is the polynomial through these
    /// values.
    pub values: [f64; NODES],
}

impl<R: Real> Part<R> {
    /// The function over the span, to be kept.
    pub fn curve(&self) -> Curve {
        let span = (self.span.0.f64(), self.span.1.f64());
        Curve::over(span, SHARES.into_iter().zip(self.values))
    }
}

/// The time at a share of a step, not before its start or after its end.
fn at<R: Real>(share: f64, (from, to): (R, R)) -> R {
    let t = from + (to - from) * R::of(share.max(0.0));
    if share < 1.0 && t < to { t } else { to }
}

/// Equal parts of a step that are at most so long.
pub fn parts<R: Real>((from, to): (R, R), longest: f64) -> impl Iterator<Item = (R, R)> {
    let count = ((to - from).f64() / longest).ceil().max(1.0) as u64;
    let end = move |k: u64| at(k as f64 / count as f64, (from, to));
    (0..count).map(move |k| (end(k), end(k + 1)))
}

/// A search of the steps of a stepper `S`.
pub trait Search<R, S> {
    /// Searches a part of the last step. Returns the time at which the run ends, if it ends there.
    ///
    /// # Errors
    /// What makes the run fail there.
    fn part(&mut self, stepper: &mut S, part: (R, R)) -> Result<Option<R>, Error>;
}

/// A stepper whose steps are searched, in [parts].
pub struct Searched<R, S, F> {
    stepper: S,
    search: F,
    /// Longest part of a step that is searched at once.
    longest: f64,
    /// The time at which the search ended the run.
    ended: Option<R>,
}

impl<R: Real, S: Stepper<R>, F: Search<R, S>> Searched<R, S, F> {
    /// Searches the steps of a stepper that has not begun, each as a whole.
    pub fn by(search: F, stepper: S) -> Self {
        Self { stepper, search, longest: f64::INFINITY, ended: None }
    }

    /// Searches [parts] of steps that are at most this long.
    #[must_use]
    pub fn in_parts(mut self, longest: f64) -> Self {
        self.longest = longest;
        self
    }
}

impl<R: Real, S: Stepper<R>, F: Search<R, S>> Stepper<R> for Searched<R, S, F> {
    fn dim(&self) -> usize {
        self.stepper.dim()
    }

    fn time(&self) -> R {
        self.ended.unwrap_or_else(|| self.stepper.time())
    }

    fn done(&self) -> bool {
        self.ended.is_some() || self.stepper.done()
    }

    fn step(&mut self) -> Result<(), Error> {
        let from = self.stepper.time();
        self.stepper.step()?;
        let mut parts = parts((from, self.stepper.time()), self.longest);
        let ended = parts.find_map(|part| self.search.part(&mut self.stepper, part).transpose());
        self.ended = ended.transpose()?;
        Ok(())
    }

    fn sample(&mut self, t: R, y: &mut [R]) {
        self.stepper.sample(t, y);
    }

    fn stats(&self) -> Stats {
        self.stepper.stats()
    }
}

/// A stepper whose steps are searched for events. Each step is sampled at eight times, all changes
/// of side of the polynomial through the samples are found, and their times are refined on the
/// sampled solution.
///
/// The search costs nothing in runs that do not use this type.
pub type Watch<R, S, E, L> = Searched<R, S, Events<R, E, L>>;

/// The search of a [`Watch`].
pub struct Events<R, E, L> {
    functions: E,
    listener: L,
    sides: Sides,
    crossings: Vec<Crossing>,
    /// Share of the step since which each function is positive.
    since: Vec<f64>,
    y: Vec<R>,
    g: Vec<R>,
}

impl<R: Real, S: Stepper<R>, E: EventFunctions<R>, L: Listener<R>> Watch<R, S, E, L> {
    /// Watches a stepper that has not begun.
    pub fn new(mut stepper: S, functions: E, listener: L) -> Self {
        let count = functions.count();
        let (mut y, mut g) = (vec![R::zero(); stepper.dim()], vec![R::zero(); count]);
        let mut sides = Sides::new(count);
        let t = stepper.time();
        stepper.sample(t, &mut y);
        functions.values(t, &y, &mut g);
        sides.put(0, &g);
        sides.set_band(functions.band(&y).f64());
        sides.begin(false);
        sides.put(NODES - 1, &g);
        let since = vec![0.0; count];
        Self::by(Events { functions, listener, sides, crossings: Vec::new(), since, y, g }, stepper)
    }

    /// Ends the watch and returns the listener.
    pub fn into_listener(self) -> L {
        self.search.listener
    }
}

impl<R: Real, E: EventFunctions<R>, L: Listener<R>> Events<R, E, L> {
    fn values_at<S: Stepper<R>>(&mut self, stepper: &mut S, t: R) {
        stepper.sample(t, &mut self.y);
        self.functions.values(t, &self.y, &mut self.g);
    }

    /// Reports the part of the step in which function `index` was positive, up to `end`.
    fn report_part<S: Stepper<R>>(&mut self, run: &mut S, (index, end): (usize, f64), step: (R, R)) {
        let start = std::mem::replace(&mut self.since[index], 0.0);
        let values = self.sides.over(index, (start, end));
        self.listener.positive(&Part { index, span: (at(start, step), at(end, step)), values }, run);
    }

    /// The time of a crossing: a root of the sampled solution near the root of the polynomial.
    fn refine<S: Stepper<R>>(&mut self, stepper: &mut S, crossing: Crossing, (from, to): (R, R)) -> R {
        let index = crossing.index;
        let guess = at(crossing.zero, (from, to));
        if guess <= from || guess >= to {
            return guess;
        }
        let mut width = 1e-9;
        while width < 1.0 {
            let (low, high) = (at(crossing.zero - width, (from, to)), at(crossing.zero + width, (from, to)));
            self.values_at(stepper, low);
            let before = self.g[index];
            self.values_at(stepper, high);
            let after = self.g[index];
            let rises = before <= R::zero() && after >= R::zero();
            let falls = before >= R::zero() && after <= R::zero();
            if (crossing.rising && rises) || (!crossing.rising && falls) {
                let value = |t| {
                    self.values_at(stepper, t);
                    self.g[index]
                };
                return bracketed(value, (low, before), (high, after));
            }
            width *= 32.0;
        }
        guess
    }
}

impl<R: Real, S: Stepper<R>, E: EventFunctions<R>, L: Listener<R>> Search<R, S> for Events<R, E, L> {
    fn part(&mut self, stepper: &mut S, (from, to): (R, R)) -> Result<Option<R>, Error> {
        self.sides.carry();
        for (k, share) in SHARES.into_iter().enumerate().skip(1) {
            let t = at(share, (from, to));
            self.values_at(stepper, t);
            self.sides.put(k, &self.g);
            // A state that is lost has no events; the observer of the run ends it.
            if !self.g.iter().all(|g| g.is_finite()) {
                return Ok(None);
            }
        }
        self.sides.set_band(self.functions.band(&self.y).f64());
        let mut crossings = std::mem::take(&mut self.crossings);
        self.sides.all_crossings(&mut crossings);
        self.crossings = crossings;
        for k in 0..self.crossings.len() {
            let crossing = self.crossings[k];
            if crossing.rising {
                self.since[crossing.index] = crossing.zero;
            } else {
                self.report_part(stepper, (crossing.index, crossing.zero), (from, to));
            }
            let t = self.refine(stepper, crossing, (from, to));
            stepper.sample(t, &mut self.y);
            let event = Event { index: crossing.index, rising: crossing.rising, t };
            if self.listener.event(event, &self.y).is_break() {
                return Ok(Some(t));
            }
        }
        for index in 0..self.since.len() {
            if self.sides.positive(index) {
                self.report_part(stepper, (index, 1.0), (from, to));
            }
        }
        Ok(None)
    }
}
