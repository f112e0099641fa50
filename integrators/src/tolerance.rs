//! The tolerances that methods accept.

use crate::error::Error;

/// A kind of tolerance: the range that it is taken from, with its rule in words.
///
/// ```
/// use hertzchain_integrators::Tolerance;
/// assert!(Tolerance::RUN.check(1e-10).is_ok());
/// let refused = Tolerance::RUN.check(0.5).unwrap_err().to_string();
/// assert_eq!(refused, "tol = 0.5 is not valid: from 1e-15 to 0.1");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// The smallest one.
    pub least: f64,
    /// The largest one.
    pub most: f64,
    /// The range in words, as help and refusals say it.
    pub rule: &'static str,
}

/// Range and rule from the same two numbers, and what they hold for.
macro_rules! tolerance {
    ($least:literal, $most:literal, $of:literal) => {
        Tolerance { least: $least, most: $most, rule: concat!("from ", $least, " to ", $most, $of) }
    };
}

impl Tolerance {
    /// Of a run by contact collocation, for the sum of the errors of its windows, and of a step of
    /// DOP853 from event to event.
    pub const RUN: Self = tolerance!(1e-15, 0.1, "");
    /// Of the state at the end of a run by contact-corrected splitting. Rounding errors prevent
    /// smaller ones.
    pub const CORRECTED: Self = tolerance!(1e-13, 0.1, " for contact-corrected splitting");
    /// Of a step of DOP853 across events: at least ten units of the last place.
    pub const CROSSED: Self = tolerance!(2.3e-15, 0.1, " for dop853");
    /// Of the flow of an exact wave; above the largest, waves are not solved to 1e-12.
    pub const WAVE: Self = tolerance!(1e-15, 1e-12, " for an exact wave");

    /// The tolerance, if it is in the range.
    ///
    /// # Errors
    /// One outside the range, with the rule.
    pub fn check(&self, tol: f64) -> Result<f64, Error> {
        let good = (self.least..=self.most).contains(&tol);
        if good { Ok(tol) } else { Err(Error::Argument { name: "tol", value: tol, rule: self.rule }) }
    }
}
