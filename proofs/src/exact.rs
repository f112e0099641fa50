//! Parameters as exact fractions.

use crate::interval::Interval;
use std::{fmt, str::FromStr};

/// The fraction `num/den` in lowest terms, with `den > 0`.
///
/// ```
/// use hertzchain_proofs::exact::Exact;
/// assert_eq!("2.001".parse::<Exact>()?.to_string(), "2001/1000");
/// assert_eq!("1.5".parse::<Exact>()?, "3/2".parse()?);
/// assert!("1/0".parse::<Exact>().unwrap_err().contains("1/0"));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exact {
    num: i128,
    den: i128,
}

impl Exact {
    /// `num/den`; `None` if `den` is zero.
    pub fn new(num: i64, den: i64) -> Option<Self> {
        Self::reduced(num.into(), den.into())
    }

    fn reduced(num: i128, den: i128) -> Option<Self> {
        let common = i128::try_from(gcd(num.unsigned_abs(), den.unsigned_abs())).ok()?;
        let sign = den.signum();
        // The least integer has no modulus.
        (den != 0 && num != i128::MIN && den != i128::MIN).then_some(())?;
        Some(Self { num: num.checked_mul(sign)? / common, den: den.checked_mul(sign)? / common })
    }

    /// The fraction with the smallest denominator up to 1000 whose nearest double this is, else the
    /// shortest decimal that reads as this double; `None` if it has more than 38 digits.
    ///
    /// ```
    /// use hertzchain_proofs::exact::Exact;
    /// let text = |x: f64| Exact::of_double(x).unwrap().to_string();
    /// assert_eq!([text(1.0 / 3.0), text(0.333), text(-2.5)], ["1/3", "333/1000", "-5/2"]);
    /// ```
    pub fn of_double(x: f64) -> Option<Self> {
        let fraction = (1..=1000_i64).find_map(|den| {
            let num = (x * den as f64).round();
            (num.abs() < 1e6 && num / den as f64 == x).then(|| Self::new(num as i64, den)).flatten()
        });
        fraction.or_else(|| x.to_string().parse().ok())
    }

    /// The numerator.
    pub fn num(self) -> i128 {
        self.num
    }

    /// The denominator.
    pub fn den(self) -> i128 {
        self.den
    }

    /// An interval that holds the fraction.
    pub fn enclosed(self) -> Interval {
        let num = Interval::of_integer(self.num);
        if self.den == 1 { num } else { num / Interval::of_integer(self.den) }
    }

    /// 0.
    pub const ZERO: Self = Self { num: 0, den: 1 };
    /// 1.
    pub const ONE: Self = Self { num: 1, den: 1 };

    /// `den/num`; `None` for zero.
    pub fn inverse(self) -> Option<Self> {
        Self::reduced(self.den, self.num)
    }

    /// The fraction less 1; `None` if it has too many digits.
    pub fn less_one(self) -> Option<Self> {
        Self::reduced(self.num.checked_sub(self.den)?, self.den)
    }
}

fn gcd(a: u128, b: u128) -> u128 {
    if b == 0 { a.max(1) } else { gcd(b, a % b) }
}

/// A decimal as integer and power of ten below it.
fn decimal(text: &str) -> Option<(i128, i128)> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let unsigned = whole.strip_prefix('-').unwrap_or(whole);
    (digits(unsigned) && digits(part) && !(unsigned.is_empty() && part.is_empty())).then_some(())?;
    Some((format!("{whole}{part}").parse().ok()?, 10_i128.checked_pow(part.len().try_into().ok()?)?))
}

impl FromStr for Exact {
    type Err = String;

    /// Reads `2.001`, `-3` or `1/3`.
    fn from_str(text: &str) -> Result<Self, String> {
        let of = || {
            let (above, below) = text.split_once('/').unwrap_or((text, "1"));
            let ((a, b), (c, d)) = (decimal(above.trim())?, decimal(below.trim())?);
            Self::reduced(a.checked_mul(d)?, b.checked_mul(c)?)
        };
        of().ok_or_else(|| {
            format!("\"{text}\" is no decimal or fraction of at most 38 digits with a denominator but 0")
        })
    }
}

impl fmt::Display for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.den == 1 { write!(f, "{}", self.num) } else { write!(f, "{}/{}", self.num, self.den) }
    }
}
