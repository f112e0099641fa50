//! A cubic spline: a function through given values at given times.

use crate::error::{Error, Result, refuse};
use hertzchain_integrators::Real;

/// Changes of values below this share of the largest are rounding.
const ROUNDING: f64 = 1e-17;

/// The cubic spline through values at increasing times, with two continuous derivatives. At the
/// second time and at the last but one the third derivative is continuous, too (not-a-knot): four
/// values are interpolated by one cubic, three by a parabola, two by a line. It errs by the fourth
/// power of the intervals. Outside of its times it goes on as the first and the last cubic do.
///
/// C. de Boor, *A Practical Guide to Splines*, Springer 1978, chapter 4.
///
/// ```
/// use hertzchain_core::chain::Spline;
/// let t = vec![0.0, 0.5, 1.5, 2.0, 3.0];
/// let cube = Spline::new(t.clone(), t.iter().map(|t| t * t * t).collect())?;
/// let [value, rate, second] = cube.at(1.2);
/// assert!((value - 1.728).abs() < 1e-14 && (rate - 4.32).abs() < 1e-14 && (second - 7.2).abs() < 1e-13);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// For each interval, the coefficients of the powers of the time since its start.
    pub(super) cubics: Vec<[f64; 4]>,
}

impl Spline {
    /// The spline through these values.
    ///
    /// # Errors
    /// Fewer than two times, another number of values, numbers that are not finite, times that do
    /// not increase.
    pub fn new(times: Vec<f64>, values: Vec<f64>) -> Result<Self> {
        let n = times.len();
        if n < 2 || values.len() != n {
            let value = format!("{n} times, {} values", values.len());
            return Err(Error::parameter("drive.times", value, "at least two times, and a value for each"));
        }
        let odd = (0..n).find(|&k| !(times[k].is_finite() && values[k].is_finite()));
        let odd = odd.map(|k| format!("{}, values = {} (entry {k})", times[k], values[k]));
        refuse("drive.times", odd, "times and values are finite")?;
        let back = (1..n).find(|&k| times[k] <= times[k - 1]);
        let back = back.map(|k| format!("{} after {} (entry {k})", times[k], times[k - 1]));
        refuse("drive.times", back, "times increase")?;
        let step: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let slope: Vec<f64> = values.windows(2).zip(&step).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
        let size = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let (seconds, thirds) = bends(&step, &slope, size);
        let cubic = |k: usize| {
            let (h, [a, b]) = (step[k], [seconds[k], seconds[k + 1]]);
            let third = if k < 2 {
                thirds[0]
            } else if k + 3 >= n {
                thirds[1]
            } else {
                (b - a) / (6.0 * h)
            };
            [values[k], slope[k] - h * (2.0 * a + b) / 6.0, 0.5 * a, third]
        };
        let cubics = (0..n - 1).map(cubic).collect();
        Ok(Self { times, values, cubics })
    }

    /// The times.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The number of the cubic at a time.
    pub(super) fn interval<R: Real>(&self, t: R) -> usize {
        self.times.partition_point(|&from| from <= t.f64()).clamp(1, self.cubics.len()) - 1
    }

    /// Value, first and second derivative at a time.
    pub fn at<R: Real>(&self, t: R) -> [R; 3] {
        let k = self.interval(t);
        let (x, [a, b, c, d]) = (t - R::of(self.times[k]), self.cubics[k].map(R::of));
        let (two, three) = (R::of(2.0), R::of(3.0));
        [a + x * (b + x * (c + x * d)), b + x * (two * c + x * three * d), two * (c + x * three * d)]
    }

    /// A bound of the absolute value between the first time and the last: the largest coefficient
    /// by Bernstein's polynomials.
    pub(super) fn size(&self) -> f64 {
        self.largest(|h, [a, b, c, d]| {
            [a, a + h * b / 3.0, a + h * (2.0 * b + h * c) / 3.0, a + h * (b + h * (c + h * d))]
        })
    }

    /// The same of the first derivative.
    pub(super) fn speed(&self) -> f64 {
        self.largest(|h, [_, b, c, d]| [b, b + h * c, b + h * (2.0 * c + 3.0 * h * d), 0.0])
    }

    /// The shortest interval.
    pub(crate) fn shortest(&self) -> f64 {
        self.times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
    }

    fn largest(&self, of: impl Fn(f64, [f64; 4]) -> [f64; 4]) -> f64 {
        let intervals = self.times.windows(2).zip(&self.cubics);
        intervals.flat_map(|(pair, cubic)| of(pair[1] - pair[0], *cubic)).fold(0.0, |most, x| x.abs().max(most))
    }
}

/// The second derivatives `s_k` at all times, and the coefficients `c` of the cubes of the first and
/// of the last two intervals, from the intervals `h_k` and the slopes `d_k` of the chords; `size` is
/// that of the values. Inside `h_{k-1} s_{k-1} + 2 (h_{k-1} + h_k) s_k + h_k s_{k+1} = 6 (d_k -
/// d_{k-1})`.
///
/// The first two intervals have one cubic, through three values: with the second difference `b =
/// (d_1 - d_0)/H`, `H = h_0 + h_1`, it is `s_2 = 2 b + 2 c (H + h_1)`. So no difference is divided by
/// an interval but those of the values, and times that nearly coincide cost no digits.
fn bends(step: &[f64], slope: &[f64], size: f64) -> (Vec<f64>, [f64; 2]) {
    let n = step.len() + 1;
    if n == 2 {
        return (vec![0.0; 2], [0.0; 2]);
    }
    let bend = |k: usize| (slope[k] - slope[k - 1]) / (step[k - 1] + step[k]);
    let (mut s, mut above) = (vec![0.0; n], vec![0.0; n]);
    for k in 2..n - 2 {
        let (h, next, mut jump) = (step[k - 1], step[k], 6.0 * (slope[k] - slope[k - 1]));
        let (mut left, mut right) = ([h, 2.0 * h], [2.0 * next, next]);
        if k == 2 {
            let both = h + step[0];
            left = [0.0, 3.0 * h * both / (both + h)];
            jump -= 6.0 * bend(1) * h * h / (both + h);
        }
        if k + 3 == n {
            let both = next + step[k + 1];
            right = [3.0 * next * both / (both + next), 0.0];
            jump -= 6.0 * bend(n - 2) * next * next / (both + next);
        }
        let pivot = left[1] + right[0] - left[0] * above[k - 1];
        above[k] = right[1] / pivot;
        s[k] = (jump - left[0] * s[k - 1]) / pivot;
    }
    for k in (2..n - 3).rev() {
        s[k] -= above[k] * s[k + 1];
    }
    // What values elsewhere add falls by about a quarter from time to time. Below a rounding of the
    // values it is zero, so that a signal that is zero for long is, to the last digit.
    for k in 2..n - 2 {
        if s[k].abs() * step[k - 1].max(step[k]).powi(2) < ROUNDING * size {
            s[k] = 0.0;
        }
    }
    let of = |s: f64, bend: f64, h: f64, outer: f64| (s - 2.0 * bend) / (2.0 * (outer + 2.0 * h));
    let thirds = match n {
        3 | 4 => {
            let third = if n == 4 { (bend(2) - bend(1)) / (step[0] + step[1] + step[2]) } else { 0.0 };
            s[2] = 2.0 * (bend(1) + third * (step[0] + 2.0 * step[1]));
            [third; 2]
        }
        _ => [of(s[2], bend(1), step[1], step[0]), -of(s[n - 3], bend(n - 2), step[n - 3], step[n - 2])],
    };
    for k in [1, 0] {
        s[k] = s[k + 1] - 6.0 * thirds[0] * step[k];
    }
    for k in [n - 2, n - 1] {
        s[k] = s[k - 1] + 6.0 * thirds[1] * step[k - 1];
    }
    (s, thirds)
}
