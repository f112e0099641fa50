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

    /// An interval that holds an integer.
    pub fn of_integer(n: i128) -> Self {
        let x = n as f64;
        if n.unsigned_abs() < 1 << 53 { Self::exact(x) } else { Self::outward(x, x) }
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

    /// Whether it holds a number.
    pub fn holds(self, x: f64) -> bool {
        self.lo <= x && x <= self.hi
    }

    /// Whether nothing is known.
    pub fn is_nan(self) -> bool {
        self.lo.is_nan()
    }

    /// Whether all its numbers are positive.
    pub fn is_positive(self) -> bool {
        self.lo > 0.0
    }

    /// Both bounds by a function; NaN if one of them or of these is NaN, which `f64::max` passes
    /// over.
    fn joined(self, other: Self, of: fn(f64, f64) -> f64, and: fn(f64, f64) -> f64) -> Self {
        let known = !(self.is_nan() || other.is_nan());
        if known { Self::new(of(self.lo, other.lo), and(self.hi, other.hi)) } else { NAN }
    }

    /// The larger of two.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        self.joined(other, f64::max, f64::max)
    }

    /// The smaller of two.
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        self.joined(other, f64::min, f64::min)
    }

    /// All numbers of two intervals, and those between them.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        self.joined(other, f64::min, f64::max)
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
            (n @ 1..=8, 2) => product(x, n / 2) * Self::exact(x).sqrt(),
            (1.., _) => (Self::exact(x).ln() * p.enclosed()).exp(),
            _ => NAN,
        };
        if self.lo >= 0.0 { at(self.lo).hull(at(self.hi)).positive_part() } else { NAN }
    }

    /// The exponential function, for `|x| <= 700`; NaN for others.
    pub fn exp(self) -> Self {
        exp(self.lo).hull(exp(self.hi))
    }

    /// The natural logarithm of normal numbers; NaN for others.
    pub fn ln(self) -> Self {
        ln(self.lo).hull(ln(self.hi))
    }

    /// `sin x`, `cos x`; what is known of any angle for `|x| > 1000`. The derivatives of both are
    /// at most 1.
    pub fn sin_cos(self) -> [Self; 2] {
        let middle = Self::exact(self.mid());
        let radius = (Self::exact(self.hi) - middle).max(middle - Self::exact(self.lo)).ball();
        sin_cos(middle.lo).map(|value| (value + radius).max(-Self::ONE).min(Self::ONE))
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
        hull([self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi])
    }
}

impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let apart = other.lo > 0.0 || other.hi < 0.0;
        if apart { hull([self.lo / other.lo, self.lo / other.hi, self.hi / other.lo, self.hi / other.hi]) } else { NAN }
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

/// The hull of rounded numbers; NaN if one is NaN, which `min` and `max` would pass over.
fn hull(all: [f64; 4]) -> Interval {
    let [a, b, c, d] = all;
    if all.iter().any(|x| x.is_nan()) {
        return NAN;
    }
    let least = |a: f64, b: f64| if a < b { a } else { b };
    let most = |a: f64, b: f64| if a > b { a } else { b };
    Interval::outward(least(least(a, b), least(c, d)), most(most(a, b), most(c, d)))
}

/// `x - n c` for a constant `c`, with `n` the integer nearest to `x/c`.
fn reduced(x: f64, c: Interval) -> (f64, Interval) {
    let n = (x / c.lo).round();
    (n, Interval::exact(x) - Interval::exact(n) * c)
}

/// `e^x = 2^n (1 + r (1 + r/2 (1 + r/3 (...))))`. For `|r| <= 1/2` the last bracket is between 1/2
/// and 2.
fn exp(x: f64) -> Interval {
    let (n, r) = reduced(x, Interval::LN_2);
    if !(x.abs() <= 700.0 && r.abs().hi <= 0.5) {
        return NAN;
    }
    let last = Interval { lo: 0.5, hi: 2.0 };
    let series = (1..=20).rev().fold(last, |sum, j| Interval::ONE + r / Interval::of_integer(j) * sum);
    series * Interval::exact(f64::from_bits(((1023 + n as i64) as u64) << 52))
}

/// `ln x = y + ln e`, `e = x e^{-y}`, `1 - 1/e <= ln e <= e - 1`, for any `y`: that of the library.
fn ln(x: f64) -> Interval {
    let (near, e) = (Interval::exact(x.ln()), Interval::exact(x) * exp(-x.ln()));
    near + (Interval::ONE - Interval::ONE / e).hull(e - Interval::ONE)
}

/// `sin` and `cos` of a double. The series of `r = x - n pi/2`, `|r| < 1`, alternate with terms
/// that decrease, so each rest is between 0 and its first term.
fn sin_cos(x: f64) -> [Interval; 2] {
    let (n, r) = reduced(x, Interval { lo: 0.5 * Interval::PI.lo, hi: 0.5 * Interval::PI.hi });
    if !(x.abs() <= 1e3 && r.abs().hi < 1.0) {
        return [if x.is_nan() { NAN } else { Interval { lo: -1.0, hi: 1.0 } }; 2];
    }
    let series = |first: i128| {
        let part = |j: i128| r.square() / Interval::of_integer((2 * j + first) * (2 * j + first + 1));
        (0..11).rev().fold(Interval { lo: 0.0, hi: 1.0 }, |sum, j| Interval::ONE - part(j) * sum)
    };
    let (sin, cos) = (r * series(2), series(1));
    [[sin, cos], [cos, -sin], [-sin, -cos], [-cos, sin]][n.rem_euclid(4.0) as usize]
}
