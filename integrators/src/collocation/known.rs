//! What drives make of positions over a window, known before anything is solved.
//!
//! A site that is moved is where its signal says, and answers no impulse. One that is pushed goes
//! on as `int_0^t K(t - s) F(s) ds` besides its path. Both are a Chebyshev series of the time
//! here, that the overlaps beside the site take as given. A window is so short that the series
//! resolves them to rounding, or to far below the tolerance.

use super::{
    flow::Flow,
    panel::clenshaw,
    rule::Rule,
    system::{Drive, Path},
};
use crate::real::Kernel;

/// Terms of a series. With a frequency `omega` windows may be as long as `1/omega` at all
/// tolerances.
pub(crate) const TERMS: usize = 12;
/// Last terms that are rounding, as a share of a signal; and as one of the time in it.
const ROUNDING: f64 = 4e-15;
const OF_TIME: f64 = 4e-16;
/// Share of the tolerance that last terms may have, relative to the size of a signal. Chosen, not
/// measured.
const SHARE: f64 = 1e-3;

/// What drives make of one position, or of an overlap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// Chebyshev series over the window.
    series: [f64; TERMS],
    h: f64,
    /// Value and rate where the window begins and where it ends.
    pub(crate) ends: [[f64; 2]; 2],
    /// Bounds of the second and the fourth derivative.
    pub(crate) bends: [f64; 2],
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

fn size(series: &[f64; TERMS]) -> f64 {
    series.iter().fold(0.0, |sum, c| sum + c.abs())
}

impl Known {
    fn new(values: &[f64; TERMS], h: f64, ends: [[f64; 2]; 2]) -> Self {
        let series = super::panel::product(&Rule::<TERMS>::shared().series, values);
        let second = derivative(&derivative(&series, h), h);
        let fourth = derivative(&derivative(&second, h), h);
        Self { series, h, ends, bends: [size(&second), size(&fourth)] }
    }

    /// The sum of what two drives make of an overlap.
    pub(crate) fn plus(self, other: Self) -> Self {
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            series: std::array::from_fn(|k| self.series[k] + other.series[k]),
            h: self.h,
            ends: [sum(self.ends[0], other.ends[0]), sum(self.ends[1], other.ends[1])],
            bends: sum(self.bends, other.bends),
        }
    }

    /// The same with the other sign.
    pub(crate) fn minus(mut self) -> Self {
        self.series = self.series.map(|c| -c);
        self.ends = self.ends.map(|end| end.map(|x| -x));
        self
    }

    /// At times of the window; beyond its end, where a release is only guessed, a straight line.
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

    /// Rates at times of the window; beyond its end that of its end.
    pub(crate) fn rates_at<const L: usize>(&self, t: &[f64; L]) -> [f64; L] {
        let x = t.map(|t| t.mul_add(2.0 / self.h, -1.0));
        let mut out = clenshaw(&derivative(&self.series, self.h), &x);
        for j in 0..L {
            out[j] = if t[j] > self.h { self.ends[1][1] } else { out[j] };
        }
        out
    }

    /// The largest value and the largest rate, or a little more.
    pub(crate) fn reach(&self) -> [f64; 2] {
        let [_, rate] = self.ends[0];
        [size(&self.series), rate.abs() + self.bends[0] * self.h]
    }
}

/// The drive of one site in a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Driven {
    pub(crate) known: Known,
    /// The path that a push leaves behind.
    pub(crate) left: Path,
}

/// Looks at a drive in a window: what it does, and the length of a shorter window if the series do
/// not resolve it in this one.
pub(crate) struct Foresight<'a> {
    pub(crate) drive: &'a Drive,
    /// The motion of a site that is pushed.
    pub(crate) flow: Option<&'a Flow>,
    /// The signal as a function of the time in the window.
    pub(crate) signal: &'a dyn Fn(f64) -> [f64; 3],
    /// Start and length of the window, and the tolerance.
    pub(crate) at: (f64, f64, f64),
}

impl Kernel for Foresight<'_> {
    type Output = (Driven, f64);

    #[inline(always)]
    fn run(self) -> (Driven, f64) {
        let Self { drive, flow, signal, at: (t, h, tol) } = self;
        let rule = Rule::<TERMS>::shared();
        let times = rule.nodes.map(|x| 0.5 * h * (1.0 + x));
        let values = times.map(|t| signal(t)[0]);
        let last = rule.tail.iter().map(|row| super::panel::dot(row, &values).abs()).fold(0.0, f64::max);
        let allowed = (SHARE * tol).max(ROUNDING) * drive.size + OF_TIME * t.abs() * drive.rate;
        let shorter = 0.9 * h * (allowed / last).powf(1.0 / TERMS as f64);
        let longest = if last <= allowed { f64::INFINITY } else { shorter };
        let Some(flow) = flow else {
            let [start, end] = [0.0, h].map(|t| [signal(t)[0], signal(t)[1]]);
            return (Driven { known: Known::new(&values, h, [start, end]), left: [0.0; 4] }, longest);
        };
        let impulses = values.map(|value| 0.5 * h * value);
        let parts = flow.answer(&times).map(|part| super::panel::times(&part, &impulses));
        let left = parts.map(|part| super::panel::dot(&rule.weights, &part));
        let [r, v, c, s] = parts.map(|part| super::panel::product(&rule.integral, &part));
        let [lag, cos, sin] = flow.position(&times);
        let position =
            std::array::from_fn(|j| (r[j] + v[j] * times[j]) + (v[j] * lag[j] + c[j] * cos[j] + s[j] * sin[j]));
        let end = flow.moved(&left, h);
        let y: Path = std::array::from_fn(|k| left[k] + end[k]);
        let rates = flow.rates(&y);
        let ends = [[0.0; 2], [y[0] + y[2], rates[0] + rates[2]]];
        (Driven { known: Known::new(&position, h, ends), left }, longest)
    }
}
