//! Equal steps over a span.

use crate::{clock::DoubleDouble, error::Error, kernel, real::Real};

/// Equal steps over a span, and how many have been taken.
pub(crate) struct Steps<R> {
    start: DoubleDouble<R>,
    span: DoubleDouble<R>,
    pub(crate) h: DoubleDouble<R>,
    pub(crate) taken: u64,
    /// Zero for an empty span.
    pub(crate) total: u64,
}

impl<R: Real> Steps<R> {
    /// # Errors
    /// `end < start`, times that are not finite, or no step for a span that is not empty.
    pub(crate) fn new((start, end): (R, R), steps: u64) -> Result<Self, Error> {
        check((start, end), steps)?;
        let total = if end > start { steps } else { 0 };
        let span = DoubleDouble::new(end) - DoubleDouble::new(start);
        let h = span.over(DoubleDouble::new(R::of(total.max(1) as f64)));
        Ok(Self { start: DoubleDouble::new(start), span, h, taken: 0, total })
    }

    /// The time after this many steps.
    pub(crate) fn after(&self, steps: u64) -> DoubleDouble<R> {
        let Self { start, span, h, total, .. } = *self;
        if steps == total {
            return start + span;
        }
        // A kernel: a product of `DoubleDouble`s needs a fused product, which is a call to a
        // library in code that is not compiled for the machine's own.
        let after = DoubleDouble::new(R::of(steps as f64));
        R::run(kernel!(start + h * after))
    }

    /// The time reached.
    pub(crate) fn reached(&self) -> DoubleDouble<R> {
        self.after(self.taken)
    }

    pub(crate) fn done(&self) -> bool {
        self.taken == self.total
    }

    /// Whether a time is not that reached. Times that differ by rounding only are the same.
    pub(crate) fn inside(&self, t: R) -> bool {
        (t - self.reached().value()).abs() > R::of(4.0) * R::epsilon() * t.abs()
    }

    /// The number of steps to make in a row: at least one, at most `most`; none of them follows one
    /// that ends at the time `wanted` or later.
    pub(crate) fn in_row(&self, wanted: Option<R>, most: usize) -> usize {
        // Two steps less than the quotient says, so that no rounding leads beyond.
        let before = |t: R| (((t - self.reached().value()) / self.h.value()).f64() - 2.0) as u64;
        wanted.map_or(most as u64, before).min(most as u64).min(self.total - self.taken).max(1) as usize
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
