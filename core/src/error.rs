//! The error type of the library.

use std::{borrow::Cow, path::PathBuf};

/// Largest number of characters of foreign text in a message.
const MOST_SHOWN: usize = 300;
/// Largest number of characters of a number without an exponent.
const MOST_DIGITS: usize = 20;
/// Longest list in a message, and how much of a longer one is shown.
const LISTED: usize = 8;
const FIRST: usize = 5;
/// Begins the values of parameters whose presence is refused: no value of a user begins so.
const PRESENCE: char = '\u{1}';
/// The value of a parameter that is missing.
pub const NOTHING: &str = "\u{1}is missing";
/// The value of a parameter that does not belong where it is.
pub const GIVEN: &str = "\u{1}does not belong here";

/// An error of the library. Each variant has the value and the rule it broke, where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter outside its range.
    #[error("{}: {rule}", refused(name, value))]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value, as it was given, or why its presence is refused: [`NOTHING`], [`GIVEN`] or
        /// that of [`beside`].
        value: String,
        /// The rule it broke.
        rule: &'static str,
    },
    /// A name that is not known.
    #[error("unknown {kind} \"{name}\"{hint}")]
    Unknown {
        /// Kind of the named thing, such as "integrator".
        kind: Cow<'static, str>,
        /// The name.
        name: String,
        /// The most similar known name; without one, known names.
        hint: String,
    },
    /// A scene file with a missing or wrong entry.
    #[error("scene {file}: {message}")]
    Scene {
        /// File, or name of the built-in scene.
        file: String,
        /// The key and the rule it broke.
        message: String,
    },
    /// An integration that could not go on.
    #[error(transparent)]
    Integration(#[from] hertzchain_integrators::Error),
    /// A run that could not go on, with its mean step and the place on the chain.
    #[error(transparent)]
    Run(#[from] Failed),
    /// A result that must not be trusted.
    #[error(transparent)]
    Doubtful(#[from] Warning),
    /// A point of a study that failed.
    #[error("{point}: {why}")]
    Point {
        /// Name of the point.
        point: String,
        /// Reason of the failure.
        why: String,
    },
    /// A signal asked the process to end.
    #[error("stopped by a signal: {kept}")]
    Stopped {
        /// What was kept of the work, in words.
        kept: String,
    },
    /// A search for a periodic orbit that did not converge.
    #[error("no periodic orbit after {steps} steps of Newton's method: {}", best_residual(.best.as_deref()))]
    Stalled {
        /// Steps taken.
        steps: usize,
        /// The iterate with the smallest residual, if one could be integrated.
        best: Option<Box<Iterate>>,
    },
    /// A file that could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A file whose content is not valid: broken, altered, of another study or version.
    #[error("{}, {}: {}", path.display(), one_line(place), one_line(&in_words(rule)))]
    Content {
        /// The file.
        path: PathBuf,
        /// The key, array or line.
        place: String,
        /// The rule that the content broke.
        rule: String,
    },
    /// Options or a chain that a study does not take, in words.
    #[error("{0}")]
    Options(String),
    /// A figure that could not be drawn.
    #[error("figure: {0}")]
    Figure(Box<dyn std::error::Error + Send + Sync>),
}

/// An iterate of Newton's method.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// The unknowns, `[x(0), y(0)]` of an orbit.
    pub z: Vec<f64>,
    /// Residual of the iterate.
    pub residual: f64,
    /// Largest residual of a solution.
    pub solved: f64,
    /// Parameters of the problem, in words.
    pub place: String,
}

/// Why a run could not go on, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{cause}{}", self.beside())]
pub struct Failed {
    /// The cause of the failure.
    pub cause: hertzchain_integrators::Error,
    /// Mean step since the start of the leg, for causes without a step of their own.
    pub h: Option<f64>,
    /// Place on the chain, in words.
    pub place: Option<String>,
    /// Index and value of the largest entry of an unstable state, which is at that place.
    pub largest: Option<Box<(usize, f64)>>,
    /// Whether the numbers are in SI units.
    pub si: bool,
}

impl Failed {
    fn beside(&self) -> String {
        let h = self.h.map(|h| format!("; steps of {h:.6e}"));
        let place = self.place.as_ref().map(|place| format!("; {place}"));
        let largest = self.largest.as_ref().map(|largest| format!(" = {:e}", largest.1));
        let si = self.si.then(|| "; in SI units".to_owned());
        [h, place, largest, si].into_iter().flatten().collect()
    }
}

/// A parameter and what is wrong with it.
fn refused(name: &str, value: &str) -> String {
    match value.strip_prefix(PRESENCE) {
        Some(why) => format!("{name} {why}"),
        None => format!("{name} = {value} is not valid"),
    }
}

/// The value of a parameter that stands next to another, which excludes it.
pub fn beside(other: &str) -> String {
    format!("{PRESENCE}beside {other} is not valid")
}

/// Foreign text for one line of a message: shortened, without control characters.
pub fn one_line(text: &str) -> String {
    let shown = text.chars().take(MOST_SHOWN).map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c });
    shown.chain((text.chars().nth(MOST_SHOWN).is_some()).then_some('\u{2026}')).collect()
}

/// Names or numbers, after the first few of which the message about them says how many there are.
pub fn listed<'a>(all: impl IntoIterator<Item = &'a str>) -> String {
    let all: Vec<&str> = all.into_iter().collect();
    if all.len() <= LISTED { all.join(", ") } else { format!("{}, ... of {}", all[..FIRST].join(", "), all.len()) }
}

/// Words with long numbers written with an exponent, or the beginning of a list.
pub fn brief(words: &str) -> String {
    if let Some(list) = words.strip_prefix('[').and_then(|list| list.strip_suffix(']')) {
        return format!("[{}]", listed(list.split(", ").map(brief).collect::<Vec<_>>().iter().map(String::as_str)));
    }
    let word = |word: &str| {
        let number = word.trim_matches(['[', ']', ',']);
        match number.parse::<f64>() {
            Ok(x) if number.len() > MOST_DIGITS => word.replace(number, &format!("{x:e}")),
            _ => word.to_owned(),
        }
    };
    words.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// The message of a file parser, with plain words in place of the names of Rust types.
pub fn in_words(message: &str) -> String {
    [
        ("expected usize", "expected a whole number, at least zero"),
        ("expected u64", "expected a whole number, at least zero"),
        ("expected u32", "expected a whole number, at least zero"),
        ("expected f64", "expected a number"),
        ("invalid boolean, expected", "text stands in quotation marks; without them expected"),
        ("floating point `", "number `"),
        ("integer `", "number `"),
    ]
    .iter()
    .fold(message.to_owned(), |message, (rust, word)| message.replace(rust, word))
}

/// A result whose error is an [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Refuses a parameter unless it keeps its rule.
///
/// # Errors
/// [`Error::Parameter`], with the value and the rule.
pub fn require(keeps: bool, name: &'static str, value: impl ToString, rule: &'static str) -> Result<()> {
    if keeps { Ok(()) } else { Err(Error::parameter(name, value, rule)) }
}

/// Refuses a value that breaks a rule, if there is one.
///
/// # Errors
/// [`Error::Parameter`], with the value and the rule.
///
/// ```
/// use hertzchain_core::error::refuse;
/// let negative = |values: &[f64]| refuse("mass", values.iter().find(|mass| **mass < 0.0), "at least zero");
/// assert!(negative(&[1.0]).is_ok());
/// assert_eq!(negative(&[1.0, -2.0]).unwrap_err().to_string(), "mass = -2 is not valid: at least zero");
/// ```
pub fn refuse(name: &'static str, breaks: Option<impl ToString>, rule: &'static str) -> Result<()> {
    breaks.map_or(Ok(()), |value| Err(Error::parameter(name, value, rule)))
}

/// The rule for exponents of contacts whose stiffness is asked for.
pub const SMOOTH: &str = "above 1 (that of a table is 1): else the stiffness of a contact jumps where it opens";

/// The rule for strain rings.
pub const EQUAL_BEADS: &str = "a strain ring has equal beads without damping, drives and gravity: leave these out, or take \
                               another boundary and initial state";

/// A value that must be finite and positive.
///
/// # Errors
/// Another value, by its name.
pub fn positive(name: &'static str, value: f64) -> Result<f64> {
    require(value.is_finite() && value > 0.0, name, value, "finite and positive").map(|()| value)
}

/// A value that must be finite.
///
/// # Errors
/// Another value, by its name.
pub fn finite(name: &'static str, value: f64) -> Result<f64> {
    require(value.is_finite(), name, value, "a finite number").map(|()| value)
}

fn best_residual(best: Option<&Iterate>) -> String {
    best.map_or("it broke down".to_owned(), |Iterate { residual, solved, place, .. }| {
        format!("the smallest residual is {residual:.1e} at {place}; it must be {solved:.0e}")
    })
}

impl Error {
    /// A parameter outside its range.
    pub fn parameter(name: &'static str, value: impl ToString, rule: &'static str) -> Self {
        Self::Parameter { name, value: brief(&value.to_string()), rule }
    }

    /// The refusal of a parameter under another name, such as that of its flag.
    #[must_use]
    pub fn named(self, name: &'static str) -> Self {
        if let Self::Parameter { value, rule, .. } = self { Self::Parameter { name, value, rule } } else { self }
    }

    /// An unknown name, with the most similar known name, or with known names.
    pub fn unknown<'a>(
        kind: impl Into<Cow<'static, str>>,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        let hint = match nearest(name, known.iter().copied()) {
            Some(nearest) => format!("; did you mean \"{nearest}\"?"),
            None => format!("; one of {}", listed(known)),
        };
        Self::Unknown { kind: kind.into(), name: one_line(name), hint }
    }
}

/// The known name most similar to `name`, if its similarity (Jaro and Winkler) exceeds 0.8:
/// a letter is missing, wrong or misplaced. Below that, names are different ones.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    known
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate.to_owned())
}

/// What makes the result of a run doubtful, as a sentence for the user.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// An energy error that the setting does not explain.
    #[error("the energy is off by {error:.1e} of itself, and {why}: check with another integrator")]
    Energy {
        /// Largest error of the energy, relative to the initial energy; for a chain that dissipates
        /// or is driven, of the balance, relative to the largest of energy, dissipated energy and
        /// work of the drives.
        error: f64,
        /// What the setting explains, in words.
        why: String,
    },
    /// Steps of a given length that pass over the ramp or the burst of a drive. Methods that choose
    /// their steps, or their windows, end them where a signal is not smooth.
    #[error(
        "drive {drive}, of bead {site}, has {kind} of length {length:e}, which steps of {step:e} pass over: take \
         shorter steps, or --tol"
    )]
    Unresolved {
        /// Number of the drive, from 0.
        drive: usize,
        /// Its site.
        site: usize,
        /// `a ramp`, `a burst` or `an interval of times`.
        kind: &'static str,
        /// Length of the ramp, the burst or the shortest interval.
        length: f64,
        /// Length of a step.
        step: f64,
    },
    /// A motion so weak that forces of static overlaps are rounded by more than the tolerance.
    #[error(
        "forces of the static overlaps are rounded by {share:.1e} of the motion, which is more than the tolerance \
         {tol:e}: errors are about as large, or larger"
    )]
    Weak {
        /// The rounding of static overlaps over the size of the motion.
        share: f64,
        /// The tolerance.
        tol: f64,
    },
}

impl Warning {
    /// Whether the result must not be taken for one that met its setting: `run` then ends with exit
    /// code 1, and the point of a sweep has failed.
    pub fn fatal(&self) -> bool {
        matches!(self, Self::Energy { .. })
    }
}
