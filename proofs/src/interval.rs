//! Intervals of real numbers with bounds in doubles, rounded outward.
//!
//! IEEE 754 rounds the basic operations and the square root to one of the two doubles beside the
//! exact result, so the next double below and the next one above enclose it, in every rounding mode
//! without flush to zero. (x87 code rounds twice: within one unit in the last place, so this holds
//! there too.) Elementary functions are power series with their remainders.
//!
//! An operation without a result (a division by an interval with zero, the root of a negative
//! number, infinity less infinity) gives the interval NaN, and so does every operation with it.
//! All comparisons with it are false: it proves nothing.

use crate::exact::Exact;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `[lo, hi]`, or NaN.
///
/// ```
/// use hertzchain_proofs::interval::Interval;
/// let third = Interval::exact(1.0) / Interval::exact(3.0);
/// assert!(third.lo() < third.hi() && (third * Interval::exact(3.0)).holds(1.0));
/// assert!((third / (third - third)).is_nan());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    lo: f64,
    hi: f64,
}

const NAN: Interval = Interval { lo: f64::NAN, hi: f64::NAN };

impl Interval {
    /// `[0, 0]`.
    pub const ZERO: Self = Self { lo: 0.0, hi: 0.0 };
    /// `[1, 1]`.
    pub const ONE: Self = Self { lo: 1.0, hi: 1.0 };
    /// The two doubles beside `ln 2`.
    const LN_2: Self = Self { lo: std::f64::consts::LN_2, hi: 0.693_147_180_559_945_4 };
    /// The two doubles beside pi.
    pub const PI: Self = Self { lo: std::f64::consts::PI, hi: 3.141_592_653_589_793_6 };

    /// `[lo, hi]`; NaN unless `lo <= hi`.
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi { Self { lo, hi } } else { NAN }
    }

    /// The interval that holds only this double; NaN if it is not finite.
    pub fn exact(x: f64) -> Self {
        if x.is_finite() { Self { lo: x, hi: x } } else { NAN }
    }

    fn outward(lo: f64, hi: f64) -> Self {
        Self::new(lo.next_down(), hi.next_up())
    }

    /// `[-radius, radius]` for the upper bound of an interval.
    pub fn ball(self) -> Self {
        Self::new(-self.hi, self.hi)
    }

    /// Lower bound.
    pub fn lo(self) -> f64 {
        self.lo
    }

    /// Upper bound.
    pub fn hi(self) -> f64 {
        self.hi
    }

    /// A double in the interval, near its middle.
    pub fn mid(self) -> f64 {
        (0.5 * self.lo + 0.5 * self.hi).max(self.lo).min(self.hi)
    }

    /// Whether nothing is known.
    pub fn is_nan(self) -> bool {
        self.lo.is_nan()
    }

    /// Whether all its numbers are positive.
    pub fn is_positive(self) -> bool {
        self.lo > 0.0
    }

    /// The larger of two.
    pub fn max(self, other: Self) -> Self {
        if self.is_nan() { NAN } else { Self::new(most(self.lo, other.lo), most(self.hi, other.hi)) }
    }

    /// The smaller of two.
    pub fn min(self, other: Self) -> Self {
        -(-self).max(-other)
    }

    /// All numbers of two intervals, and those between them.
    pub fn hull(self, other: Self) -> Self {
        if self.is_nan() { NAN } else { Self::new(-most(-self.lo, -other.lo), most(self.hi, other.hi)) }
    }

    /// `max(x, 0)`.
    pub fn positive_part(self) -> Self {
        self.max(Self::ZERO)
    }

    /// `|x|`.
    pub fn abs(self) -> Self {
        self.max(-self).positive_part()
    }

    /// `x^2`.
    pub fn square(self) -> Self {
        let x = self.abs();
        Self::outward(x.lo * x.lo, x.hi * x.hi).positive_part()
    }

    /// The square root; NaN if a number is negative.
    pub fn sqrt(self) -> Self {
        if self.lo >= 0.0 { Self::outward(self.lo.sqrt(), self.hi.sqrt()).positive_part() } else { NAN }
    }

    /// `x^p` for numbers `x >= 0` and `p > 0`; NaN for others.
    pub fn pow(self, p: Exact) -> Self {
        let product = |x: f64, n: i64| (0..n).fold(Self::ONE, |product, _| product * Self::exact(x));
        let at = |x: f64| match (p.num(), p.den()) {
            (1.., _) if x == 0.0 => Self::ZERO,
            (n @ 1..=8, 1) => product(x, n),
            (n @ 1..=8, 2) if n % 2 == 1 => product(x, n / 2) * Self::exact(x).sqrt(),
            (1.., _) => (ln(x) * p.enclosed()).exp(),
            _ => NAN,
        };
        if self.lo >= 0.0 { at(self.lo).hull(at(self.hi)).positive_part() } else { NAN }
    }

    /// `e^x = 2^n (1 + r (1 + r/2 (1 + r/3 (...))))`, `r = x - n ln 2`, for `|x| <= 700`; NaN for
    /// others. For `|r| <= 1/2` the last bracket is between 1/2 and 2.
    pub fn exp(self) -> Self {
        let at = |x: f64| {
            let (n, r) = reduced(x, Self::LN_2);
            if !(x.abs() <= 700.0 && r.abs().hi <= 0.5) {
                return NAN;
            }
            let series = (1..=20).rev().fold(Self { lo: 0.5, hi: 2.0 }, |sum, j| Self::ONE + r / of(j) * sum);
            series * Self::exact(f64::from_bits(((1023 + n as i64) as u64) << 52))
        };
        at(self.lo).hull(at(self.hi))
    }

    /// `sin x`, `cos x`, for `|x| <= 1000`; NaN for others. The derivatives of both are at most 1.
    /// In the middle the series of `r = x - n pi/2`, `|r| < 1`, alternate with terms that decrease,
    /// so each rest is between 0 and its first term.
    pub fn sin_cos(self) -> [Self; 2] {
        let x = self.mid();
        let (n, r) = reduced(x, Self { lo: 0.5 * Self::PI.lo, hi: 0.5 * Self::PI.hi });
        if !(x.abs() <= 1e3 && r.abs().hi < 1.0) {
            return [NAN; 2];
        }
        let series = |first: usize| {
            let part = |j: usize| r.square() / of((2 * j + first) * (2 * j + first + 1));
            (0..11).rev().fold(Self { lo: 0.0, hi: 1.0 }, |sum, j| Self::ONE - part(j) * sum)
        };
        let (sin, cos) = (r * series(2), series(1));
        let all = [[sin, cos], [cos, -sin], [-sin, -cos], [-cos, sin]][n.rem_euclid(4.0) as usize];
        let radius = (self - Self::exact(x)).abs().ball();
        all.map(|value| (value + radius).max(-Self::ONE).min(Self::ONE))
    }

    /// The hull of an operation on the bounds; NaN if one of the results is NaN.
    fn by_bounds(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let [a, b, c, d] = [of(self.lo, other.lo), of(self.lo, other.hi), of(self.hi, other.lo), of(self.hi, other.hi)];
        if a.is_nan() || b.is_nan() || c.is_nan() || d.is_nan() {
            return NAN;
        }
        Self::outward(-most(most(-a, -b), most(-c, -d)), most(most(a, b), most(c, d)))
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::outward(self.lo + other.lo, self.hi + other.hi)
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.by_bounds(other, |x, y| x * y)
    }
}

impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if other.lo > 0.0 || other.hi < 0.0 { self.by_bounds(other, |x, y| x / y) } else { NAN }
    }
}

impl std::iter::Sum for Interval {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::ZERO, Add::add)
    }
}

/// The square root of the sum of squares.
pub fn norm(all: impl IntoIterator<Item = Interval>) -> Interval {
    all.into_iter().map(Interval::square).sum::<Interval>().positive_part().sqrt()
}

/// A whole number, below `2^53`.
pub(crate) fn of(k: usize) -> Interval {
    Interval::exact(k as f64)
}

/// The larger number; `b` if one is NaN.
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `x - n c` for a constant `c`, with `n` the integer nearest to `x/c`.
fn reduced(x: f64, c: Interval) -> (f64, Interval) {
    let n = (x / c.lo).round();
    (n, Interval::exact(x) - Interval::exact(n) * c)
}

/// `ln x = y + ln e`, `e = x e^{-y}`, `1 - 1/e <= ln e <= e - 1`, for any `y`: that of the library.
/// NaN for numbers that are not normal.
pub fn ln(x: f64) -> Interval {
    let near = Interval::exact(x.ln());
    let e = Interval::exact(x) * (-near).exp();
    near + (Interval::ONE - Interval::ONE / e).hull(e - Interval::ONE)
}
