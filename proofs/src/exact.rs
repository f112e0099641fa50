//! Parameters as exact fractions.

use crate::interval::Interval;
use std::str::FromStr;

/// What texts of fractions are.
pub(crate) const FRACTION: &str = "fraction of two integers of 64 bits with a denominator but 0";

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

impl FromStr for Exact {
    type Err = String;

    /// Reads `-3` or `1/3`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (num, den) = text.split_once('/').unwrap_or((text, "1"));
        let of = || Self::new(num.parse().ok()?, den.parse().ok()?);
        of().ok_or_else(|| format!("\"{text}\" is no {FRACTION}"))
    }
}
