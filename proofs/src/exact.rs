//! Parameters as exact fractions.

use crate::interval::Interval;
use std::fmt::{Display, Formatter, Result};

/// The fraction `num/den` with `den > 0` and `|num|` below `2^63`. Nothing needs it in lowest
/// terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exact {
    num: i64,
    den: i64,
}

impl Exact {
    /// `1`.
    pub const ONE: Self = Self { num: 1, den: 1 };
    /// `0`.
    pub const ZERO: Self = Self { num: 0, den: 1 };

    /// `num/den`; `None` unless `den` is positive and `num` has a modulus.
    #[doc(hidden)]
    pub fn of(num: i64, den: i64) -> Option<Self> {
        (den > 0 && num > i64::MIN).then_some(Self { num, den })
    }

    /// The numerator.
    pub fn num(self) -> i64 {
        self.num
    }

    /// The denominator.
    pub fn den(self) -> i64 {
        self.den
    }

    /// An interval that holds the fraction. Integers from `2^53` on are rounded to doubles.
    pub fn enclosed(self) -> Interval {
        let of = |n: i64| match n as f64 {
            x if n.abs() < 1 << 53 => Interval::exact(x),
            x => Interval::new(x.next_down(), x.next_up()),
        };
        if self.den == 1 { of(self.num) } else { of(self.num) / of(self.den) }
    }

    /// The fraction less 1.
    pub fn less_one(self) -> Option<Self> {
        Self::of(self.num.checked_sub(self.den)?, self.den)
    }
}

impl Display for Exact {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if self.den == 1 { write!(f, "{}", self.num) } else { write!(f, "{}/{}", self.num, self.den) }
    }
}
