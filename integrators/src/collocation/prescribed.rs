//! The displacements of driven sites over a window, which are known before anything is solved.
//!
//! A site that is moved has the position of its signal `s(t)`, and does not respond to impulses. A
//! site that is pushed by a force `F` has the displacement `int_0^t K(t - s) F(s) ds` in addition
//! to its path. Each is represented by a Chebyshev series in time over the window, which is a given
//! part of the overlaps beside the site. Windows are short enough for the series to be exact to
//! rounding, or to far below the tolerance.

use super::{
    chain::{Drive, Path},
    flow::Flow,
    kernels::apart,
    rule::Rule,
    series::{clenshaw, dot, product, times as by_node},
};
use crate::kernel;

/// Number of terms of a series. For a signal of frequency `omega` windows may be as long as
/// `1/omega` at all tolerances.
pub(crate) const TERMS: usize = 12;
/// Last terms that are rounding: a share of the signal's size, and, for the rounding of the time in
/// the signal, a share of the time times the signal's rate.
const ROUNDING: f64 = 4e-15;
const OF_TIME: f64 = 4e-16;
/// Largest last terms, relative to the size of a signal, as a share of the tolerance. Chosen, not
/// measured.
const SHARE: f64 = 1e-3;

/// The part of a position, or of an overlap, that drives prescribe, over one window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prescribed {
    /// Coefficients of its Chebyshev series over the window.
    series: [f64; TERMS],
    /// Length of the window.
    h: f64,
    /// Value and time derivative at the start and at the end of the window.
    pub(crate) ends: [[f64; 2]; 2],
    /// Bounds of the second and the fourth time derivative in the window.
    pub(crate) curvature_bounds: [f64; 2],
}

/// The derivative of a Chebyshev series over a window.
fn derivative(series: &[f64; TERMS], h: f64) -> [f64; TERMS] {
    let mut out = [0.0; TERMS];
    for k in (0..TERMS - 1).rev() {
        let next = if k + 2 < TERMS { out[k + 2] } else { 0.0 };
        out[k] = next + 2.0 * (k + 1) as f64 * series[k + 1] * 2.0 / h;
    }
    out[0] *= 0.5;
    out
}

/// A bound of a Chebyshev series on its interval: the sum of the sizes of its coefficients.
fn size(series: &[f64; TERMS]) -> f64 {
    series.iter().fold(0.0, |sum, c| sum + c.abs())
}

impl Prescribed {
    fn new(values: &[f64; TERMS], h: f64, ends: [[f64; 2]; 2]) -> Self {
        let series = product(&Rule::<TERMS>::shared().series, values);
        let second = derivative(&derivative(&series, h), h);
        let fourth = derivative(&derivative(&second, h), h);
        Self { series, h, ends, curvature_bounds: [size(&second), size(&fourth)] }
    }

    /// A steady motion between two values. Its derivatives have no rounding errors, which grow with
    /// the distance from the start.
    fn linear(h: f64, start: [f64; 2], end: [f64; 2]) -> Self {
        let mut series = [0.0; TERMS];
        (series[0], series[1]) = (0.5 * (start[0] + end[0]), 0.5 * h * start[1]);
        Self { series, h, ends: [start, end], curvature_bounds: [0.0; 2] }
    }

    /// The sum of the parts of an overlap that two drives prescribe.
    pub(crate) fn plus(self, other: Self) -> Self {
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            series: std::array::from_fn(|k| self.series[k] + other.series[k]),
            h: self.h,
            ends: [sum(self.ends[0], other.ends[0]), sum(self.ends[1], other.ends[1])],
            curvature_bounds: sum(self.curvature_bounds, other.curvature_bounds),
        }
    }

    /// The negative of this part.
    pub(crate) fn minus(mut self) -> Self {
        self.series = self.series.map(|c| -c);
        self.ends = self.ends.map(|end| end.map(|x| -x));
        self
    }

    /// Values at times of the window; after its end, where a release is only estimated, those of
    /// the tangent at the end.
    #[inline(always)]
    pub(crate) fn at<const L: usize>(&self, t: &[f64; L]) -> [f64; L] {
        let [value, rate] = self.ends[1];
        let per = 2.0 / self.h;
        let mut x = [0.0; L];
        for j in 0..L {
            x[j] = t[j].mul_add(per, -1.0);
        }
        let mut out = clenshaw(&self.series, &x);
        for j in 0..L {
            out[j] = if t[j] > self.h { value + rate * (t[j] - self.h) } else { out[j] };
        }
        out
    }

    /// Time derivatives at times of the window; after its end the derivative at the end.
    pub(crate) fn rates_at<const L: usize>(&self, t: &[f64; L]) -> [f64; L] {
        let x = t.map(|t| t.mul_add(2.0 / self.h, -1.0));
        let mut out = clenshaw(&derivative(&self.series, self.h), &x);
        for j in 0..L {
            out[j] = if t[j] > self.h { self.ends[1][1] } else { out[j] };
        }
        out
    }

    /// Bounds of the value and of the time derivative in the window.
    pub(crate) fn reach(&self) -> [f64; 2] {
        let [_, rate] = self.ends[0];
        [size(&self.series), rate.abs() + self.curvature_bounds[0] * self.h]
    }
}

/// The drive of one site in a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Driven {
    pub(crate) known: Prescribed,
    /// The path by a pushing force after the window; zero for a site that is moved.
    pub(crate) left: Path,
}

impl Driven {
    /// What a drive does in a window, and the length of a shorter window if the series do not
    /// resolve the drive in this one, else infinity. `flow` is `None` for a site that is moved;
    /// `signal` and two derivatives are functions of the time since the start of the window; `at`
    /// has start and length of the window, and the tolerance.
    pub(crate) fn ahead(
        drive: &Drive,
        flow: Option<&Flow>,
        signal: &dyn Fn(f64) -> [f64; 3],
        (t, h, tol): (f64, f64, f64),
    ) -> (Self, f64) {
        if t >= drive.linear_from {
            let [start, end] = [0.0, h].map(|t| [signal(t)[0], signal(t)[1]]);
            return (Driven { known: Prescribed::linear(h, start, end), left: [0.0; 4] }, f64::INFINITY);
        }
        apart(kernel!({
            let rule = Rule::<TERMS>::shared();
            let times = rule.nodes.map(|x| 0.5 * h * (1.0 + x));
            let values = times.map(|t| signal(t)[0]);
            let last = rule.tail.iter().map(|row| dot(row, &values).abs()).fold(0.0, f64::max);
            let allowed = (SHARE * tol).max(ROUNDING) * drive.size + OF_TIME * t.abs() * drive.rate;
            let shorter = 0.9 * h * (allowed / last).powf(1.0 / TERMS as f64);
            let longest = if last <= allowed { f64::INFINITY } else { shorter };
            let Some(flow) = flow else {
                // In a short ramp a contact does work that is not small, though its impulse is.
                let within = drive.varies.iter().filter(|[from, to]| *from <= t && t < *to);
                let quarter = within.map(|[from, to]| 0.25 * (to - from)).fold(f64::INFINITY, f64::min);
                let longest = if h > quarter { longest.min(quarter) } else { longest };
                let [start, end] = [0.0, h].map(|t| [signal(t)[0], signal(t)[1]]);
                return (Driven { known: Prescribed::new(&values, h, [start, end]), left: [0.0; 4] }, longest);
            };
            let impulses = values.map(|value| 0.5 * h * value);
            let ([lag, cos, sin], answer) = flow.position_and_answer(&times);
            let parts = answer.map(|part| by_node(&part, &impulses));
            let left = parts.map(|part| dot(&rule.weights, &part));
            let [r, v, c, s] = parts.map(|part| product(&rule.integral, &part));
            let position =
                std::array::from_fn(|j| (r[j] + v[j] * times[j]) + (v[j] * lag[j] + c[j] * cos[j] + s[j] * sin[j]));
            let end = flow.moved(&left, h);
            let y: Path = std::array::from_fn(|k| left[k] + end[k]);
            let rates = flow.rates(&y);
            let ends = [[0.0; 2], [y[0] + y[2], rates[0] + rates[2]]];
            (Driven { known: Prescribed::new(&position, h, ends), left }, longest)
        }))
    }
}
