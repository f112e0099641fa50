//! A scene as it stands in a TOML file.

use crate::{
    chain::{Boundary, Params},
    dps::Center,
    error::{Error, Result, in_words, nearest, one_line},
    number::double,
    run::{Method, Run},
};
use serde::{Deserialize, Serialize};
use std::{ops::Range, path::Path};
use toml::{
    Table,
    de::{DeTable, DeValue, Deserializer},
};

/// So much of a line or a number is shown in a message.
const SHOWN: usize = 60;

/// The whole file. Keys that nobody knows are errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Short name (that of the file without its extension if left out, else `scene`).
    #[serde(default)]
    pub name: String,
    /// One line that says what it shows.
    #[serde(default)]
    pub summary: String,
    /// The chain.
    pub chain: ChainSection,
    /// The initial state.
    pub initial: Initial,
    /// How long it runs.
    pub span: Span,
    /// What is recorded.
    #[serde(default)]
    pub record: Record,
    /// By which method it runs, unless somebody names another; by what its regime asks for, if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<MethodSection>,
}

/// `[chain]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainSection {
    /// Number of beads.
    pub sites: usize,
    /// Exponent.
    pub alpha: f64,
    /// Spring constant (0, no springs, if left out).
    #[serde(default)]
    pub kappa: f64,
    /// Mass ratio resonator to bead (0, no resonators, if left out); `inf` for the cradle.
    #[serde(default)]
    pub rho: f64,
    /// What holds the ends.
    pub boundary: Boundary,
    /// Static overlap of every bond.
    #[serde(default)]
    pub precompression: f64,
}

impl ChainSection {
    /// The three parameters.
    pub fn params(&self) -> Params {
        Params { alpha: self.alpha, kappa: self.kappa, rho: self.rho }
    }
}

/// `[initial]`, by `kind`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Initial {
    /// (eq:ini_tw) on a strain ring. Exactly one of `epsilon` and `detuning = omega_tw - omega`.
    TravellingWave {
        /// Wave number over pi.
        q_over_pi: f64,
        /// Amplitude.
        a: f64,
        /// Mean strain.
        b: f64,
        /// Phase.
        #[serde(default)]
        phi: f64,
        /// Size of the wave.
        #[serde(skip_serializing_if = "Option::is_none")]
        epsilon: Option<f64>,
        /// Frequency above `omega`.
        #[serde(skip_serializing_if = "Option::is_none")]
        detuning: Option<f64>,
        /// Largest relative perturbation of the amplitudes (eq:dA0_ptb), from 0 (none, as if left out) to below 1.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        zeta: Option<f64>,
        /// Seed of the perturbation (1 if left out).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        seed: Option<u64>,
    },
    /// Everything at rest but one bead.
    SingleBead {
        /// Which bead, from 0.
        site: usize,
        /// Its displacement.
        #[serde(default)]
        displacement: f64,
        /// Its velocity.
        #[serde(default)]
        velocity: f64,
    },
    /// `u_n = v_n = amplitude sin(pi mode (n+1)/(N+1))`, at rest: a mode of a precompressed chain between walls.
    NormalMode {
        /// Number of half waves.
        mode: u32,
        /// Amplitude.
        amplitude: f64,
    },
    /// (uncpl): beads that never touch.
    TrivialBreather(TrivialSection),
    /// (ini_num): beads displaced by `2 epsilon a_n`, a homoclinic solution of (dpsstat), all else at rest.
    BrightBreather {
        /// What the profile is symmetric about: `site` (`a^1`) or `bond` (`a^2`).
        center: Center,
        /// Size of the breather.
        epsilon: f64,
    },
    /// Any state, array by array; an array left out is zero. Strains and their rates on a strain ring.
    State {
        /// Displacements of the beads.
        #[serde(default)]
        u: Vec<f64>,
        /// Displacements of the resonators.
        #[serde(default)]
        v: Vec<f64>,
        /// Velocities of the beads.
        #[serde(default)]
        u_dot: Vec<f64>,
        /// Velocities of the resonators.
        #[serde(default)]
        v_dot: Vec<f64>,
    },
}

/// `[initial]` of kind `trivial-breather`: amplitudes, phases and mean positions, each said in one way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrivialSection {
    /// `a_n`, site by site; or `a_n = amplitude e^{-|n - center| / decay}` from the three below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitudes: Option<Vec<f64>>,
    /// Site of the centre, between sites if fractional.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub center: Option<f64>,
    /// Largest `a_n`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<f64>,
    /// Decay length, in sites.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decay: Option<f64>,
    /// `phi_n`, site by site, in radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phases: Option<Vec<f64>>,
    /// `(phi_n - phi_{n-1}) / pi`, the same for all (1, antiphase, if left out).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_step_over_pi: Option<f64>,
    /// Mean positions `b_n`, site by site.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub b: Option<Vec<f64>>,
    /// `d_n`, site by site: the mean positions are `b_n = d_n + sum l_k`, as close as contacts allow where it does not rise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub d: Option<Vec<f64>>,
    /// Gap beyond what contacts demand, the same for all bonds (0 if left out); the mean of the `b_n` is then zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
}

/// `[span]`: exactly one of `periods` and `until`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Span {
    /// Length in periods of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periods: Option<f64>,
    /// End time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
    /// The unit that steps per period refer to, for scenes without a frequency of their own (1 if left out).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
}

/// `[method]`: an integrator, and at most one of the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MethodSection {
    /// Name of the integrator.
    pub integrator: String,
    /// Tolerance, for one that takes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tol: Option<f64>,
    /// Step, made smaller where a whole number of steps must fit the span.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Steps a period of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_per_period: Option<f64>,
}

impl MethodSection {
    /// A run by this method.
    ///
    /// # Errors
    /// An unknown integrator; more than one of the settings, or one that the integrator does not take or that is outside its rule.
    pub fn of(&self, run: Run) -> Result<Run> {
        let &Self { ref integrator, tol, step, steps_per_period } = self;
        let method = Method::named(integrator)?;
        let run = run.method(method);
        match (tol, step, steps_per_period) {
            (None, None, None) => Ok(run),
            (Some(tol), None, None) if method.tolerant() => run.tolerance(tol),
            (Some(tol), None, None) => {
                Err(Error::parameter("tol", tol, "this integrator takes `step` or `steps_per_period`"))
            }
            (None, Some(step), None) if !method.adaptive() => run.step(step),
            (None, None, Some(count)) if !method.adaptive() && count > 0.0 => {
                let step = run.period() / count;
                run.step(step)
            }
            (None, Some(step), None) => Err(Error::parameter("step", step, "this integrator takes `tol`")),
            (None, None, Some(count)) => {
                let rule = "positive, and for an integrator that takes steps; others take `tol`";
                Err(Error::parameter("steps_per_period", count, rule))
            }
            _ => Err(Error::parameter("method", "[method]", "give one of `tol`, `step` and `steps_per_period`")),
        }
    }
}

/// `[record]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Number of equally spaced times at which energy and strains are kept; 0: the end only. If left out, a scene takes
    /// [`FEWEST_SAMPLES`](Self::FEWEST_SAMPLES), or more where its period is known, see [`by_default`](Self::by_default).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<usize>,
}

impl Record {
    /// Samples of a short run that does not say how many.
    pub const FEWEST_SAMPLES: usize = 400;
    /// Most samples of a run that does not say how many.
    pub const MOST_SAMPLES: usize = 10_000;
    /// Samples a period of a run that does not say how many, unless they are more than
    /// [`MOST_SAMPLES`](Self::MOST_SAMPLES) in all.
    pub const PER_PERIOD: f64 = 16.0;

    /// This many samples.
    pub fn of(samples: usize) -> Self {
        Self { samples: Some(samples) }
    }

    /// The number of samples of a run that does not say how many, by its length in periods, if a period is known.
    ///
    /// ```
    /// use hertzchain::scene::Record;
    /// assert_eq!(Record::by_default(None), 400);
    /// assert_eq!(Record::by_default(Some(10.0)), 400);
    /// assert_eq!(Record::by_default(Some(100.0)), 1600);
    /// assert_eq!(Record::by_default(Some(1e9)), 10_000);
    /// ```
    pub fn by_default(periods: Option<f64>) -> usize {
        let wanted = (Self::PER_PERIOD * periods.unwrap_or(0.0)).ceil().min(Self::MOST_SAMPLES as f64);
        (wanted as usize).max(Self::FEWEST_SAMPLES)
    }
}

impl SceneFile {
    /// Reads a scene; `file` is what messages call it.
    ///
    /// # Errors
    /// The line, the key and the rule; the nearest key, where one is unknown; a number that a double cannot hold.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        Self::parse_with(text, file, &[])
    }

    /// Reads a scene with some keys changed. A change is a line of TOML with a dotted key, such as `chain.rho=3`; a value
    /// that is no TOML is taken as a string, so that `chain.boundary=ring` needs no quotation marks.
    ///
    /// # Errors
    /// As [`parse`](Self::parse); a change in place of a line where it is to blame.
    pub fn parse_with(text: &str, file: &str, changes: &[String]) -> Result<Self> {
        let fail = |message| Error::Scene { file: file.to_owned(), message };
        let source = Source { text, changes };
        let lines = source.lines().map_err(fail)?;
        let mut table = DeTable::parse(text).map_err(|error| fail(explain(&error, &source, None)))?;
        for line in &lines {
            let change = DeTable::parse(line).map_err(|error| fail(explain(&error, &source, None)))?;
            merge(table.get_mut(), change.into_inner());
        }
        for leaf in leaves(table.get_ref(), "") {
            leaf.held().map_err(|rule| fail(format!("{}: `{}`: {rule}", source.place(leaf.span.start), leaf.key)))?;
        }
        let mut scene = Self::deserialize(Deserializer::from(table.clone()))
            .map_err(|error| fail(explain(&error, &source, Some(&table))))?;
        if scene.name.is_empty() {
            scene.name = Path::new(file).file_stem().map_or("scene".into(), |stem| stem.to_string_lossy().into_owned());
        }
        Ok(scene)
    }

    /// Where the value of the parameter `name` stands, for messages: its line, or the change that set it, and its key.
    pub(super) fn place(text: &str, changes: &[String], name: &str) -> Option<String> {
        let source = Source { text, changes };
        let lines = source.lines().ok()?;
        let mut table = DeTable::parse(text).ok()?;
        for line in &lines {
            merge(table.get_mut(), DeTable::parse(line).ok()?.into_inner());
        }
        let leaves = leaves(table.get_ref(), "");
        let leaf = leaves.iter().find(|leaf| leaf.key.rsplit('.').next() == Some(name))?;
        Some(format!("{}: `{}`", source.place(leaf.span.start), leaf.key))
    }

    /// The scene as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }
}

/// What a scene is read from: the text of a file and the changes to it. Bytes are counted through both.
struct Source<'a> {
    text: &'a str,
    changes: &'a [String],
}

impl Source<'_> {
    /// Where each change begins: one byte after the text or the change before it.
    fn starts(&self) -> impl Iterator<Item = (usize, &String)> {
        self.changes.iter().scan(self.text.len() + 1, |next, change| {
            let start = *next;
            *next += change.len() + QUOTES + 1;
            Some((start, change))
        })
    }

    /// The changes as TOML, each behind so many blanks that its bytes are counted from where it begins.
    fn lines(&self) -> std::result::Result<Vec<String>, String> {
        let line = |(start, change): (usize, &String)| {
            let Some((key, value)) = change.split_once('=') else {
                return Err(format!("--set {}: not KEY=VALUE, as in chain.rho=3", one_line(change)));
            };
            let is_toml = DeTable::parse(change).is_ok();
            let text = if is_toml { change.clone() } else { format!("{key}={}", toml::Value::from(value.trim())) };
            Ok(" ".repeat(start) + &text)
        };
        self.starts().map(line).collect()
    }

    /// The line, or the change, in which the byte `at` is.
    fn place(&self, at: usize) -> String {
        match self.starts().take_while(|(start, _)| *start <= at).last() {
            Some((_, change)) => format!("--set {}", one_line(change)),
            None => format!("line {}", 1 + line(self.text, at)),
        }
    }
}

/// Quotation marks and escapes that a change may get.
const QUOTES: usize = 1 << 12;

/// Puts the entries of `change` into `table`, in place of those of the same keys.
fn merge<'a>(table: &mut DeTable<'a>, change: DeTable<'a>) {
    for (key, value) in change {
        match (table.get_mut(&key).map(toml::Spanned::get_mut), value.get_ref()) {
            (Some(DeValue::Table(below)), DeValue::Table(_)) => {
                if let DeValue::Table(change) = value.into_inner() {
                    merge(below, change);
                }
            }
            _ => {
                table.insert(key, value);
            }
        }
    }
}

/// A key with a value that is no table.
struct Leaf<'a> {
    /// As in `chain.alpha`.
    key: String,
    value: &'a DeValue<'a>,
    /// Where the value is.
    span: Range<usize>,
}

fn leaves<'a>(table: &'a DeTable<'a>, above: &str) -> Vec<Leaf<'a>> {
    let below = |(name, value): (&toml::Spanned<_>, &'a toml::Spanned<DeValue<'a>>)| {
        let key = format!("{above}{}", name.get_ref());
        match value.get_ref() {
            DeValue::Table(table) => leaves(table, &(key + ".")),
            leaf => vec![Leaf { key, value: leaf, span: value.span() }],
        }
    };
    table.iter().flat_map(below).collect()
}

impl Leaf<'_> {
    /// That doubles can hold its numbers.
    fn held(&self) -> std::result::Result<(), String> {
        fn of(value: &DeValue<'_>) -> std::result::Result<(), String> {
            match value {
                DeValue::Float(float) => match double(float.as_str()) {
                    Ok(_) => Ok(()),
                    Err(rule) => Err(format!("{}: {rule}", float.as_str().chars().take(SHOWN).collect::<String>())),
                },
                DeValue::Array(array) => array.iter().try_for_each(|value| of(value.get_ref())),
                _ => Ok(()),
            }
        }
        of(self.value)
    }
}

/// The number, from 0, of the line in which the byte `at` is.
fn line(text: &str, at: usize) -> usize {
    text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

/// The message of an error of the reader, with the line and the key that it is about. `table` is the scene, where it could be read as TOML.
fn explain(error: &toml::de::Error, source: &Source<'_>, table: Option<&toml::Spanned<DeTable<'_>>>) -> String {
    let text = source.text;
    let message = in_words(&error.message().lines().collect::<Vec<_>>().join("; "));
    // serde says: unknown field `x`, expected one of `a`, `b`.
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let hint = match names.split_first() {
        Some((unknown, known)) if message.starts_with("unknown") => nearest(unknown, known.iter().copied()),
        _ => None,
    };
    let hint = hint.map(|name| format!("; did you mean `{name}`?")).unwrap_or_default();
    let [missing, unknown] = ["missing field", "unknown field"].map(|what| message.starts_with(what));
    let span = error.span().filter(|span| *span != (0..text.len()));
    let leaves = table.map(|table| leaves(table.get_ref(), "")).unwrap_or_default();
    let leaf = if missing {
        None
    } else {
        let there = |leaf: &&Leaf<'_>| span.as_ref().is_some_and(|span| leaf.span.contains(&span.start));
        leaves.iter().find(there).or_else(|| {
            let key = culprit(error.message(), table?)?;
            leaves.iter().find(|leaf| leaf.key == key)
        })
    };
    let message = match leaf.map(|leaf| leaf.span.start).or(span.map(|span| span.start)) {
        None => message + &hint,
        Some(at) => {
            let place = match leaf {
                _ if unknown => String::new(),
                Some(leaf) => format!("`{}`: ", leaf.key),
                None if at > text.len() => String::new(),
                None => format!(
                    "`{}`: ",
                    text.lines().nth(line(text, at)).unwrap_or_default().chars().take(SHOWN).collect::<String>()
                ),
            };
            format!("{}: {place}{message}{hint}", source.place(at))
        }
    };
    one_line(&message)
}

/// The key of `[initial]` that a message is about: the first with which it appears. A table of one kind or another is read as a whole, and of an error in it
/// nobody knows where it was.
fn culprit(message: &str, table: &toml::Spanned<DeTable<'_>>) -> Option<String> {
    let file = Table::deserialize(Deserializer::from(table.clone())).ok()?;
    let initial = file.get("initial")?.as_table()?;
    let mut some = Table::new();
    let kind = initial.get_key_value("kind");
    kind.into_iter().chain(initial).find_map(|(key, value)| {
        some.insert(key.clone(), value.clone());
        let error = some.clone().try_into::<Initial>().err()?;
        (error.message() == message).then(|| format!("initial.{key}"))
    })
}
