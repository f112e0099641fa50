//! One line of the table: what the paper says, what we get, and whether the two agree.

/// When a number of ours is what is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// It rounds to these digits: `"0.057"` is met from 0.0565 to 0.0575.
    Digits(&'static str),
    /// It is this number up to a relative error.
    Equal {
        /// The number, not zero.
        to: f64,
        /// Largest relative error.
        within: f64,
    },
    /// It is at most this.
    AtMost(f64),
    /// It is at least this.
    AtLeast(f64),
    /// There is no such number.
    Undefined,
}

impl Rule {
    /// Whether a value obeys the rule; not-a-number obeys [`Undefined`](Self::Undefined) alone.
    ///
    /// ```
    /// use hertzchain::experiments::Rule;
    /// assert!(Rule::Digits("0.057").met_by(0.0571) && !Rule::Digits("0.057").met_by(0.0576));
    /// assert!(Rule::Digits("6.37e-4").met_by(6.366e-4) && !Rule::Digits("6.37e-4").met_by(6.364e-4));
    /// ```
    pub fn met_by(&self, value: f64) -> bool {
        match *self {
            Self::Digits(printed) => {
                let unit = 10f64.powi(-places(printed));
                // The half unit, and the rounding of decimal numbers.
                printed.parse::<f64>().is_ok_and(|number| (value - number).abs() <= unit * (0.5 + 1e-9))
            }
            Self::Equal { to, within } => (value / to - 1.0).abs() <= within,
            Self::AtMost(bound) => value <= bound,
            Self::AtLeast(bound) => value >= bound,
            Self::Undefined => value.is_nan(),
        }
    }

    /// The rule in words.
    pub fn words(&self) -> String {
        match *self {
            Self::Digits(printed) => format!("rounds to {printed}"),
            Self::Equal { to, within } => format!("= {to} to {within:e}"),
            Self::AtMost(bound) => format!("<= {}", short(bound)),
            Self::AtLeast(bound) => format!(">= {}", short(bound)),
            Self::Undefined => "undefined".to_owned(),
        }
    }

    /// The value with the digits that the rule is about: two more than are printed, or five.
    pub(super) fn show(&self, value: f64) -> String {
        match *self {
            Self::Digits(printed) if printed.contains('e') => {
                format!("{value:.*e}", digits_behind_the_point(printed) + 2)
            }
            Self::Digits(printed) => format!("{value:.*}", digits_behind_the_point(printed) + 2),
            _ if value == 0.0 => "0".to_owned(),
            _ if plain(value) => {
                // Half a unit more, or 0.999999 would have one digit more than 1.
                let digits = 4.0 - (value.abs() * (1.0 + 5e-6)).log10().floor();
                format!("{value:.*}", digits.max(0.0) as usize)
            }
            _ => format!("{value:.2e}"),
        }
    }
}

/// Whether a number is read more easily without an exponent.
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

/// The power of ten of the last printed digit, with its sign changed.
fn places(printed: &str) -> i32 {
    let exponent = printed.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or(0);
    digits_behind_the_point(printed) as i32 - exponent
}

/// What is said of a number or a statement of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Our number is the printed one.
    Agrees,
    /// It is not: a misprint, or a looser statement.
    Differs,
    /// The statement is true.
    Holds,
    /// It is not.
    Fails,
}

impl Verdict {
    /// The verdict as a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Differs => "differs",
            Self::Holds => "holds",
            Self::Fails => "fails",
        }
    }
}

/// A number or a statement of the paper, held against ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// Short name, unique: subsection and words.
    pub id: &'static str,
    /// Section of the paper.
    pub section: u32,
    /// Label in the paper.
    pub label: &'static str,
    /// What is measured, in words.
    pub quantity: &'static str,
    /// What the paper says, as printed.
    pub paper: &'static str,
    /// The same as a rule.
    pub rule: Rule,
    /// Whether it is a statement, which holds or fails, not a number.
    pub statement: bool,
    /// Our number.
    pub value: f64,
    /// The rule that our number obeys where the paper's is known to be broken.
    pub instead: Option<Rule>,
    /// Why they differ, or a remark; may be empty.
    pub why: &'static str,
}

/// A printed number; our value agrees if it rounds to it.
pub(super) fn number(
    id: &'static str,
    label: &'static str,
    quantity: &'static str,
    printed: &'static str,
    value: f64,
) -> Item {
    formula(id, label, quantity, printed, Rule::Digits(printed), value)
}

/// A printed formula, evaluated.
pub(super) fn formula(
    id: &'static str,
    label: &'static str,
    quantity: &'static str,
    paper: &'static str,
    rule: Rule,
    value: f64,
) -> Item {
    Item { id, section: 0, label, quantity, paper, rule, statement: false, value, instead: None, why: "" }
}

/// A statement, and the number that decides it.
pub(super) fn claim(
    id: &'static str,
    label: &'static str,
    quantity: &'static str,
    paper: &'static str,
    rule: Rule,
    value: f64,
) -> Item {
    Item { statement: true, ..formula(id, label, quantity, paper, rule, value) }
}

impl Item {
    /// The item as one that is known to differ: what our number is instead, and why.
    pub(super) fn but(self, instead: Rule, why: &'static str) -> Self {
        Self { instead: Some(instead), why, ..self }
    }

    /// The item with a remark.
    pub(super) fn note(self, why: &'static str) -> Self {
        Self { why, ..self }
    }

    fn say(&self, good: bool) -> Verdict {
        match (self.statement, good) {
            (false, true) => Verdict::Agrees,
            (false, false) => Verdict::Differs,
            (true, true) => Verdict::Holds,
            (true, false) => Verdict::Fails,
        }
    }

    /// What our number says of the paper's.
    pub fn verdict(&self) -> Verdict {
        self.say(self.rule.met_by(self.value))
    }

    /// What it is known to say.
    pub fn expected(&self) -> Verdict {
        self.say(self.instead.is_none())
    }

    /// Whether the verdict is the expected one and, where the paper's number is known to be another, ours is still what it was.
    pub fn as_expected(&self) -> bool {
        self.verdict() == self.expected() && self.instead.is_none_or(|rule| rule.met_by(self.value))
    }

    /// Our number with as many digits as matter.
    pub fn shown(&self) -> String {
        self.instead.unwrap_or(self.rule).show(self.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_agrees_if_it_rounds_to_the_printed_digits() {
        for (printed, good, bad) in [
            ("0.057", [0.0565, 0.0571, 0.0575], [0.056_499, 0.0576]),
            ("2", [1.5, 2.0, 2.4], [1.4, 2.6]),
            ("314", [313.6, 314.0, 314.4], [313.4, 314.6]),
            ("6.37e-4", [6.366e-4, 6.37e-4, 6.374e-4], [6.364e-4, 6.376e-4]),
            ("-0.830", [-0.8304, -0.83, -0.8296], [-0.8306, 0.83]),
            ("3.140", [3.1396, 3.1399, 3.1404], [3.1394, 3.1406]),
        ] {
            let rule = Rule::Digits(printed);
            assert!(good.iter().all(|&value| rule.met_by(value)), "{printed}");
            assert!(bad.iter().all(|&value| !rule.met_by(value)), "{printed}");
            assert!(!rule.met_by(f64::NAN) && !rule.met_by(f64::INFINITY), "{printed}");
        }
        assert!(!Rule::Digits("about 3").met_by(3.0));
    }

    #[test]
    fn other_rules_take_no_number_that_is_none() {
        for rule in [Rule::Equal { to: 1.0, within: 0.1 }, Rule::AtMost(8.0), Rule::AtLeast(0.0)] {
            assert!(!rule.met_by(f64::NAN) && rule.met_by(1.0));
        }
        assert!(
            !Rule::Equal { to: 1.0, within: 0.1 }.met_by(1.2) && !Rule::Equal { to: 1.0, within: 0.1 }.met_by(-1.0)
        );
        assert!(!Rule::AtMost(8.0).met_by(8.1) && !Rule::AtLeast(2.0).met_by(1.9));
        assert!(Rule::Undefined.met_by(f64::NAN) && !Rule::Undefined.met_by(0.0));
    }

    #[test]
    fn a_known_difference_is_expected_and_a_changed_number_is_not() {
        let item = |value| number("", "", "", "3.126", value);
        let period = |value| item(value).but(Rule::Digits("3.140"), "a misprint");
        assert_eq!((period(3.14002).verdict(), period(3.14002).expected()), (Verdict::Differs, Verdict::Differs));
        assert!(period(3.14002).as_expected());
        // Another number of ours; the paper's; a difference nobody knows of; none.
        assert!(!period(3.2).as_expected() && !period(3.126).as_expected());
        assert!(!item(3.12).as_expected() && item(3.126).as_expected());
        let claim = |value| claim("", "", "", "", Rule::AtMost(8.0), value);
        assert_eq!((claim(7.0).verdict(), claim(9.0).verdict()), (Verdict::Holds, Verdict::Fails));
        assert!(claim(7.0).as_expected() && !claim(9.0).as_expected());
    }

    #[test]
    fn values_are_shown_with_the_digits_that_decide() {
        assert_eq!(Rule::Digits("0.057").show(0.057_113_1), "0.05711");
        assert_eq!(Rule::Digits("6.37e-4").show(6.365_609e-4), "6.3656e-4");
        assert_eq!(Rule::AtMost(8.0).show(4.938_420_48), "4.9384");
        assert_eq!(Rule::AtMost(1e-12).show(3.26e-15), "3.26e-15");
        assert_eq!(Rule::AtLeast(1.0).show(0.0), "0");
        assert_eq!(
            (Rule::AtMost(8.0).show(0.999_999_99), Rule::AtMost(8.0).show(1.0)),
            ("1.0000".into(), "1.0000".into())
        );
        assert_eq!((Rule::AtMost(1e-7).words(), Rule::AtLeast(1.5).words()), ("<= 1e-7".into(), ">= 1.5".into()));
    }
}
