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
        let mut seconds = seconds(&step, &slope);
        // What values elsewhere add falls by about a quarter from time to time. Below a rounding of
        // the values it is zero, so that a signal that is zero for long is, to the last digit.
        let size = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        for (k, second) in seconds.iter_mut().enumerate() {
            let h = step[k.saturating_sub(1)].max(step[k.min(n - 2)]);
            if second.abs() * h * h < ROUNDING * size {
                *second = 0.0;
            }
        }
        let cubic = |k: usize| {
            let ([a, b], h) = ([seconds[k], seconds[k + 1]], step[k]);
            [values[k], slope[k] - h * (2.0 * a + b) / 6.0, 0.5 * a, (b - a) / (6.0 * h)]
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

/// The second derivatives at all times, from the intervals and the slopes of the chords. Inside
/// `h_{k-1} s_{k-1} + 2 (h_{k-1} + h_k) s_k + h_k s_{k+1} = 6 (d_k - d_{k-1})`; the first and the
/// last follow from the third derivative, which is that of the next interval.
fn seconds(step: &[f64], slope: &[f64]) -> Vec<f64> {
    let n = step.len() + 1;
    match n {
        2 => return vec![0.0; 2],
        3 => return vec![2.0 * (slope[1] - slope[0]) / (step[0] + step[1]); 3],
        _ => {}
    }
    let (mut s, mut above) = (vec![0.0; n], vec![0.0; n]);
    for k in 1..n - 1 {
        let (h, next) = (step[k - 1], step[k]);
        let (mut below, mut here, mut over) = (h, 2.0 * (h + next), next);
        if k == 1 {
            (below, here, over) = (0.0, here + h + h * h / next, over - h * h / next);
        }
        if k == n - 2 {
            (below, here, over) = (below - next * next / h, here + next + next * next / h, 0.0);
        }
        let pivot = here - below * above[k - 1];
        above[k] = over / pivot;
        s[k] = (6.0 * (slope[k] - slope[k - 1]) - below * s[k - 1]) / pivot;
    }
    for k in (1..n - 2).rev() {
        s[k] -= above[k] * s[k + 1];
    }
    s[0] = s[1] - step[0] / step[1] * (s[2] - s[1]);
    s[n - 1] = s[n - 2] + step[n - 2] / step[n - 3] * (s[n - 2] - s[n - 3]);
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_errs_by_the_fourth_power_of_the_intervals() {
        // Truth: the sine, also at uneven times.
        let off = |n: u32, uneven: f64| {
            let t: Vec<f64> = (0..=n).map(|k| 3.0 * f64::from(k) / f64::from(n)).collect();
            let t: Vec<f64> = t.iter().map(|t| t + uneven * (5.0 * t).sin() / f64::from(n)).collect();
            let spline = Spline::new(t.clone(), t.iter().map(|t| t.sin()).collect()).unwrap();
            let all = (0..1000).map(|k| t[0] + (t[n as usize] - t[0]) * f64::from(k) / 999.0);
            all.map(|t| (spline.at(t)[0] - t.sin()).abs()).fold(0.0, f64::max)
        };
        for uneven in [0.0, 0.4] {
            let order = (off(128, uneven) / off(256, uneven)).log2();
            assert!((order - 4.0).abs() < 0.25, "{uneven} {order}");
        }
    }

    #[test]
    fn it_is_zero_where_values_are_zero_for_long() {
        // Truth: the values; without the cut it falls to 1e-170 there, and states to subnormal
        // numbers.
        let value = |k: i32| if (300..350).contains(&k) { f64::from(k - 300).sin() } else { 0.0 };
        let spline = Spline::new((0..1000).map(f64::from).collect(), (0..1000).map(value).collect()).unwrap();
        assert_eq!([0.5, 100.3, 260.7, 600.1, 998.5].map(|t| spline.at(t)), [[0.0; 3]; 5]);
        assert!(spline.at(298.5)[0].abs() > 1e-3);
    }

    #[test]
    fn few_values_are_met_by_a_line_a_parabola_and_a_cubic() {
        // Truth: the polynomials themselves.
        let t = [0.0, 0.4, 1.0, 1.1];
        for n in 2..=4 {
            let of = |t: f64| (0..n as i32).map(|k| t.powi(k) / f64::from(k + 1)).sum::<f64>();
            let spline = Spline::new(t[..n].to_vec(), t[..n].iter().map(|&t| of(t)).collect()).unwrap();
            for x in [-0.1, 0.2, 0.9] {
                assert!((spline.at(x)[0] - of(x)).abs() < 1e-14, "{n} {x}");
            }
            let (low, high) = (spline.values()[0], spline.values()[n - 1]);
            assert!(spline.size() >= low.max(high) && spline.speed() > 0.0);
        }
    }
}
