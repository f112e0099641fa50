//! Errors at a time, the times at which they are sampled, and their suprema.

use crate::{
    chain::Layout,
    error::{Result, require},
    named::named,
};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

named! {
    /// Norms of sequences.
    pub enum Norm {
        /// `l_1`.
        One = "1",
        /// `l_2`.
        Two = "2",
        /// `l_inf`.
        Infinity = "inf",
    }
}

impl Norm {
    /// Its place in [`ALL`](Self::ALL).
    pub fn index(self) -> usize {
        self as usize
    }

    /// The norm of numbers.
    pub fn of(self, values: impl Iterator<Item = f64>) -> f64 {
        match self {
            // The sum of nothing would be -0.
            Self::One => values.map(f64::abs).fold(0.0, |sum, value| sum + value),
            // Squares of small values would be subnormal.
            Self::Two => values.fold(0.0, f64::hypot),
            Self::Infinity => values.map(f64::abs).fold(0.0, f64::max),
        }
    }
}

/// The three errors in one norm: that of `u` and `u'` together (estimu), `norm(v)`, `norm(v')`
/// (estimv).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors(pub [f64; 3]);

/// The errors of the state `y` at time `t` in all norms, against `A(epsilon^{alpha-1} t)`.
pub fn errors(layout: Layout, y: &[f64], a: &[Complex64], epsilon: f64, t: f64) -> [Errors; 3] {
    let ansatz: Vec<Complex64> = a.iter().map(|a| a * Complex64::from_polar(2.0 * epsilon, t)).collect();
    let off = |values: &[f64], ansatz: fn(&Complex64) -> f64, norm: Norm, all: &[Complex64]| {
        norm.of(values.iter().zip(all).map(|(value, a)| value - ansatz(a)))
    };
    Norm::ALL.map(|norm| {
        let u = off(layout.u(y), |a| a.re, norm, &ansatz) + off(layout.u_dot(y), |a| -a.im, norm, &ansatz);
        let size = |values: Option<&[f64]>| norm.of(values.unwrap_or_default().iter().copied());
        Errors([u, size(layout.v(y)), size(layout.v_dot(y))])
    })
}

/// The largest of a series, and what its samples miss: the parabola through a largest sample and
/// those beside it rises above it by no more than an eighth of their second difference.
#[derive(Clone, Copy, Default)]
struct Peak {
    /// The last two values, each with what it misses itself.
    before: [Option<(f64, f64)>; 2],
    largest: f64,
    missed: f64,
}

impl Peak {
    fn see(&mut self, value: f64, missed: f64) {
        let [first, middle] = self.before;
        if let Some(middle) = middle {
            self.compare(middle, first.map_or(value, |first| first.0), value);
        }
        self.before = [middle, Some((value, missed))];
    }

    /// `(largest, missed)`. Where a series is cut off, the next value is taken to be the one before
    /// the last; where time ends, nothing is missed.
    fn end(mut self, time_ends: bool) -> (f64, f64) {
        if let [before, Some(last)] = self.before {
            let beside = before.filter(|_| !time_ends).map_or(last.0, |before| before.0);
            self.compare(last, beside, beside);
        }
        (self.largest, self.missed)
    }

    fn compare(&mut self, (value, missed): (f64, f64), one: f64, other: f64) {
        if value >= self.largest {
            self.largest = value;
            self.missed = missed + 0.125 * (one - 2.0 * value + other).abs();
        }
    }
}

/// The largest errors of the present period, and of all periods that were sampled.
#[derive(Default)]
pub(crate) struct Suprema {
    period: [[Peak; 3]; 3],
    run: [[Peak; 3]; 3],
}

impl Suprema {
    /// Takes the errors of a sample.
    pub(crate) fn see(&mut self, now: &[Errors; 3]) {
        for (peaks, Errors(now)) in self.period.iter_mut().zip(now) {
            peaks.iter_mut().zip(now).for_each(|(peak, now)| peak.see(*now, 0.0));
        }
    }

    /// Ends a period; `last`: whether it is the last one of the run.
    pub(crate) fn close(&mut self, last: bool) {
        for (all, period) in self.run.iter_mut().flatten().zip(std::mem::take(&mut self.period).iter().flatten()) {
            let (largest, missed) = period.end(last);
            all.see(largest, missed);
        }
    }

    /// The suprema, and the share of each that samples miss.
    pub(crate) fn finish(self) -> [[Errors; 3]; 2] {
        let ends = self.run.map(|peaks| peaks.map(|peak| peak.end(true)));
        let share = |(largest, missed): (f64, f64)| if largest > 0.0 { missed / largest } else { 0.0 };
        [ends.map(|ends| Errors(ends.map(|end| end.0))), ends.map(|ends| Errors(ends.map(share)))]
    }
}

/// The times at which errors are sampled for their suprema.
///
/// To leading order an error is a function of two variables, the phase `t` and the slow time `tau`,
/// that is smooth where it is largest (norms have kinks where a value is zero, which is never a
/// maximum). So a run that is long enough is sampled in periods `2 pi` spread equally over it, the
/// first and the last among them; a shorter one throughout. What is missed falls with the squares
/// of both spacings, and is estimated from the curvature at the largest sample, in both variables.
/// (A comparison with half of the samples would not show it: two samples that are as far from the
/// maximum agree.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Sampling {
    /// Samples a period `2 pi`, at least 4.
    pub points: u32,
    /// Least number of periods that are sampled, at least 3.
    pub periods: u32,
    /// Number of periods a unit of slow time, if that makes more.
    pub periods_per_slow_time: u32,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { points: 128, periods: 64, periods_per_slow_time: 16 }
    }
}

impl Sampling {
    pub(super) fn checked(self) -> Result<()> {
        require(self.points >= 4, "points", self.points, "at least 4")?;
        require(self.periods >= 3, "periods", self.periods, "at least 3")?;
        Ok(())
    }

    /// The sample times of each period, or of the whole run: increasing, the first 0 and the last
    /// the end.
    pub fn periods(self, end: f64, horizon: f64) -> Vec<Vec<f64>> {
        let points = f64::from(self.points);
        let count = f64::from(self.periods).max(f64::from(self.periods_per_slow_time) * horizon).ceil();
        let equal = |first: f64, length: f64, points: f64| -> Vec<f64> {
            (0..=points as u64).map(|k| (first + length * (k as f64 / points)).min(end)).collect()
        };
        if end <= 2.0 * PI * count {
            return vec![equal(0.0, end, (points * (end / (2.0 * PI)).max(0.5)).ceil())];
        }
        let first = |k: u64| (end - 2.0 * PI) * (k as f64 / (count - 1.0));
        (0..count as u64).map(|k| equal(first(k), 2.0 * PI, points)).collect()
    }
}
