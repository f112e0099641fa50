//! The one error type of the library.

use std::path::PathBuf;

/// So much of a text that is not ours is shown in a message.
const MOST_SHOWN: usize = 300;
/// So many names are all listed to somebody who gives another.
const MOST_LISTED: usize = 16;

/// What can go wrong, always with the value and the rule it broke.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter outside its rule.
    #[error("{name} = {value} is not valid: {rule}")]
    Parameter {
        /// Which parameter.
        name: &'static str,
        /// Its value, as it was given.
        value: String,
        /// The rule it broke.
        rule: &'static str,
    },
    /// A name nobody knows.
    #[error("unknown {kind} \"{name}\"{hint}")]
    Unknown {
        /// Kind of thing that was named.
        kind: &'static str,
        /// The name.
        name: String,
        /// The known name most like it; if there is none, and names are few, all of them.
        hint: String,
    },
    /// A scene file that does not say what a scene must say.
    #[error("scene {file}: {message}")]
    Scene {
        /// File, or name of the built-in scene.
        file: String,
        /// Key and rule.
        message: String,
    },
    /// An integration that could not go on.
    #[error(transparent)]
    Integration(#[from] hertzchain_integrators::Error),
    /// A run that could not go on, with its step and the place on the chain.
    #[error(transparent)]
    Run(#[from] Failed),
    /// A point of a study that failed.
    #[error("{point}: {why}")]
    Point {
        /// Which point.
        point: String,
        /// Why.
        why: String,
    },
    /// Somebody outside asked the work to end.
    #[error("stopped by a signal: {kept}")]
    Stopped {
        /// What there is of it.
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
        /// What the system said.
        source: std::io::Error,
    },
    /// A file that is there but does not hold what it must: broken, altered, of another study or version.
    #[error("{}, {}: {}", path.display(), one_line(place), one_line(&in_words(rule)))]
    Content {
        /// The file.
        path: PathBuf,
        /// The key, array or line.
        place: String,
        /// What is wrong with it.
        rule: String,
    },
    /// A figure that could not be drawn.
    #[error("figure: {0}")]
    Figure(Box<dyn std::error::Error + Send + Sync>),
}

/// An iterate of Newton's method.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// The unknowns, `[x(0), y(0)]` of an orbit.
    pub z: Vec<f64>,
    /// Its residual.
    pub residual: f64,
    /// The parameters it is for, in words.
    pub place: String,
}

/// Why a run could not go on, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{cause}{}", beside(.h, .place))]
pub struct Failed {
    /// What happened.
    pub cause: hertzchain_integrators::Error,
    /// Mean step of the run so far, where the cause does not know its own.
    pub h: Option<f64>,
    /// Where on the chain.
    pub place: Option<String>,
}

fn beside(h: &Option<f64>, place: &Option<String>) -> String {
    let h = h.map(|h| format!("; steps of {h:.6e}"));
    let place = place.as_ref().map(|place| format!("; {place}"));
    h.into_iter().chain(place).collect()
}

/// What may hold words of a file, fit for one line of a message.
pub fn one_line(text: &str) -> String {
    let shown = text.chars().take(MOST_SHOWN).map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c });
    shown.chain((text.chars().nth(MOST_SHOWN).is_some()).then_some('\u{2026}')).collect()
}

/// A message of a reader of files, in which numbers are called numbers and not types of Rust.
pub fn in_words(message: &str) -> String {
    [
        ("expected usize", "expected a whole number, at least zero"),
        ("expected u64", "expected a whole number, at least zero"),
        ("expected u32", "expected a whole number, at least zero"),
        ("expected f64", "expected a number"),
        ("floating point `", "number `"),
        ("integer `", "number `"),
        ("` as i128", "`"),
        ("` as u128", "`"),
    ]
    .iter()
    .fold(message.to_owned(), |message, (rust, word)| message.replace(rust, word))
}

/// The result of whatever may end in an [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

fn best_residual(best: Option<&Iterate>) -> String {
    best.map_or("it broke down".to_owned(), |Iterate { residual, place, .. }| {
        format!("the smallest residual is {residual:.1e} at {place}; it must be 1e-12")
    })
}

impl Error {
    /// A parameter outside its rule.
    pub fn parameter(name: &'static str, value: impl ToString, rule: &'static str) -> Self {
        let mut value = value.to_string();
        // 1e300 is not told with 300 digits.
        if let (true, Ok(number)) = (value.len() > 20, value.parse::<f64>()) {
            value = format!("{number:e}");
        }
        Self::Parameter { name, value, rule }
    }

    /// An unknown name, with the nearest of the `known` ones, or all of them where they are few.
    pub fn unknown<'a>(kind: &'static str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        let hint = match nearest(name, known.iter().copied()) {
            Some(nearest) => format!("; did you mean \"{nearest}\"?"),
            None if known.len() <= MOST_LISTED => format!("; one of {}", known.join(", ")),
            None => String::new(),
        };
        Self::Unknown { kind, name: one_line(name), hint }
    }
}

/// The known name most like `name`, if one is like it at all.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    known
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate.to_owned())
}
