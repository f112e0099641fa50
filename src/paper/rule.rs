//! Rules: the condition under which a value agrees with a claim, and its notation.

use crate::number::double;
use std::str::FromStr;

/// A condition on a value. As text, it is what [`words`](Rule::words) returns and
/// [`parse`](str::parse) reads.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// `rounds to 0.057`: the value rounds to these printed digits, here from 0.0565 to 0.0575.
    Digits(String),
    /// `= 2.5 to 1e-2`: the value is this number up to a relative error.
    Equal {
        /// The number, not zero.
        to: f64,
        /// Largest relative error.
        within: f64,
    },
    /// `<= 8`: the value is at most this.
    AtMost(f64),
    /// `>= 1.3`: the value is at least this.
    AtLeast(f64),
    /// `undefined`: the value is not a number.
    Undefined,
}

impl FromStr for Rule {
    type Err = String;

    /// # Errors
    /// A text of none of the five forms, or with numbers that cannot be read.
    fn from_str(text: &str) -> Result<Self, String> {
        let rule = || {
            if let Some(digits) = text.strip_prefix("rounds to ") {
                return double(digits).map(|_| Self::Digits(digits.to_owned()));
            }
            if let Some((to, within)) = text.strip_prefix("= ").and_then(|equal| equal.split_once(" to ")) {
                return Ok(Self::Equal { to: double(to)?, within: double(within)? });
            }
            match text.split_once(' ') {
                Some(("<=", bound)) => double(bound).map(Self::AtMost),
                Some((">=", bound)) => double(bound).map(Self::AtLeast),
                None if text == "undefined" => Ok(Self::Undefined),
                _ => Err("none of `rounds to`, `= .. to ..`, `<=`, `>=` and `undefined`".to_owned()),
            }
        };
        rule().map_err(|why| format!("the rule {text:?}: {why}"))
    }
}

impl Rule {
    /// Whether a value obeys the rule; NaN obeys only [`Undefined`](Self::Undefined).
    ///
    /// ```
    /// use hertzchain::paper::Rule;
    /// let printed: Rule = "rounds to 6.37e-4".parse()?;
    /// assert!(printed.met_by(6.366e-4) && !printed.met_by(6.364e-4));
    /// # Ok::<(), String>(())
    /// ```
    pub fn met_by(&self, value: f64) -> bool {
        match self {
            Self::Digits(printed) => {
                let unit = 10f64.powi(-places(printed));
                // Half a unit of the last digit, plus the rounding of decimal numbers.
                printed.parse::<f64>().is_ok_and(|number| (value - number).abs() <= unit * (0.5 + 1e-9))
            }
            Self::Equal { to, within } => (value / to - 1.0).abs() <= *within,
            Self::AtMost(bound) => value <= *bound,
            Self::AtLeast(bound) => value >= *bound,
            Self::Undefined => value.is_nan(),
        }
    }

    /// The rule in words.
    pub fn words(&self) -> String {
        match self {
            Self::Digits(printed) => format!("rounds to {printed}"),
            Self::Equal { to, within } => format!("= {to} to {within:e}"),
            Self::AtMost(bound) => format!("<= {}", short(*bound)),
            Self::AtLeast(bound) => format!(">= {}", short(*bound)),
            Self::Undefined => "undefined".to_owned(),
        }
    }

    /// The value with the digits that matter for the rule: two more than are printed, or five.
    pub(super) fn show(&self, value: f64) -> String {
        match self {
            Self::Digits(printed) if printed.contains('e') => {
                format!("{value:.*e}", digits_behind_the_point(printed) + 2)
            }
            Self::Digits(printed) => format!("{value:.*}", digits_behind_the_point(printed) + 2),
            _ if value == 0.0 => "0".to_owned(),
            _ if plain(value) => {
                // Rounding may add a digit (0.999999 becomes 1.0000): the logarithm is taken of a
                // value half a unit larger.
                let digits = 4.0 - (value.abs() * (1.0 + 5e-6)).log10().floor();
                format!("{value:.*}", digits.max(0.0) as usize)
            }
            _ => format!("{value:.2e}"),
        }
    }
}

/// Whether a number is easier to read without an exponent.
fn plain(value: f64) -> bool {
    value == 0.0 || (1e-3..1e5).contains(&value.abs())
}

fn short(value: f64) -> String {
    if plain(value) { value.to_string() } else { format!("{value:e}") }
}

fn digits_behind_the_point(printed: &str) -> usize {
    let mantissa = printed.split('e').next().unwrap_or(printed);
    mantissa.split_once('.').map_or(0, |(_, behind)| behind.len())
}

/// Number of decimals of the last printed digit; negative left of the point.
fn places(printed: &str) -> i32 {
    let exponent = printed.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or(0);
    digits_behind_the_point(printed) as i32 - exponent
}
