//! Parameters as exact fractions.

use crate::interval::Interval;
use std::fmt::{Display, Formatter, Result};

/// The fraction `num/den` in lowest terms, with `den > 0` and `|num|` below `2^63`.
///
/// ```
/// use hertzchain_proofs::exact::Exact;
/// assert_eq!("6/-4".parse::<Exact>()?, "-3/2".parse()?);
/// assert_eq!(Exact::of_double(2.001).unwrap().to_string(), "2001/1000");
/// assert!("1/0".parse::<Exact>().unwrap_err().contains("1/0"));
/// # Ok::<(), String>(())
/// ```
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

    /// `num/den`; `None` if `den` is zero, or one of them the least integer, which has no modulus.
    pub fn new(num: i64, den: i64) -> Option<Self> {
        let gcd = |mut a: i64, mut b: i64| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        let common = gcd(num.checked_abs()?, den.checked_abs()?) * den.signum();
        (den != 0).then(|| Self { num: num / common, den: den / common })
    }

    /// The numerator.
    pub fn num(self) -> i64 {
        self.num
    }

    /// The denominator.
    pub fn den(self) -> i64 {
        self.den
    }

    /// An interval that holds the fraction.
    pub fn enclosed(self) -> Interval {
        let num = Interval::of_integer(self.num.into());
        if self.den == 1 { num } else { num / Interval::of_integer(self.den.into()) }
    }

    /// The fraction less 1.
    pub fn less_one(self) -> Option<Self> {
        Self::new(self.num.checked_sub(self.den)?, self.den)
    }
}

impl Display for Exact {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if self.den == 1 { write!(f, "{}", self.num) } else { write!(f, "{}/{}", self.num, self.den) }
    }
}
