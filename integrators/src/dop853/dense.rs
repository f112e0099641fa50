//! Dense output: a polynomial of degree 7 over the last step, of order 7 uniformly.

use super::{
    step::{Leap, Row, Step, row, stages},
    tableau,
};
use crate::{real::Real, system::VectorField};

/// The polynomial `y0 + s (q1 + (1-s) (q2 + s (q3 + (1-s) (q4 + s (q5 + (1-s) (q6 + s q7))))))`
/// over a step, `0 <= s <= 1`.
///
/// `q1`, `q2` and `q3` make it match the states and slopes at both ends.
pub(crate) struct Dense<R> {
    stages: Vec<(R, Row<R>)>,
    d: Vec<Row<R>>,
    q: [Vec<R>; 7],
    ready: bool,
}

impl<R: Real> Dense<R> {
    pub(crate) fn new(padded: usize) -> Self {
        Self {
            stages: stages(&tableau::DENSE_STAGES),
            d: tableau::DENSE.map(row).into(),
            q: std::array::from_fn(|_| vec![R::zero(); padded]),
            ready: false,
        }
    }

    /// Discards the polynomial.
    pub(crate) fn clear(&mut self) {
        self.ready = false;
    }

    /// Computes the polynomial of the last step, unless it is computed already. Returns the number
    /// of evaluations.
    pub(crate) fn prepare<F: VectorField<R>>(&mut self, step: &mut Step<R>, field: &mut F, leap: Leap<R>) -> u64 {
        if self.ready {
            return 0;
        }
        self.ready = true;
        let h = leap.h;
        for (extra, (c, a)) in self.stages.iter().enumerate() {
            step.slope_inside(field, leap, (*c, a), 13 + extra);
        }
        let [q1, q2, q3, high @ ..] = &mut self.q;
        let ends = step.before().iter().zip(step.state()).zip(step.slope(0).iter().zip(step.slope(12)));
        let low = q1.iter_mut().zip(q2).zip(q3);
        for (((q1, q2), q3), ((&y0, &y1), (&slope0, &slope1))) in low.zip(ends) {
            *q1 = y1 - y0;
            *q2 = h * slope0 - *q1;
            *q3 = *q1 - h * slope1 - *q2;
        }
        for (q, d) in high.iter_mut().zip(&self.d) {
            step.combine(q, h, d);
        }
        self.stages.len() as u64
    }

    /// Writes the polynomial at `s`, the share of the step, into `y`.
    pub(crate) fn eval(&self, before: &[R], s: R, y: &mut [R]) {
        let r = R::one() - s;
        let [q1, q2, q3, q4, q5, q6, q7] = &self.q;
        for (i, (y, &y0)) in y.iter_mut().zip(before).enumerate() {
            let upper = q4[i] + s * (q5[i] + r * (q6[i] + s * q7[i]));
            *y = y0 + s * (q1[i] + r * (q2[i] + s * (q3[i] + r * upper)));
        }
    }
}
