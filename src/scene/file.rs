//! The contents of a scene file in TOML.

use super::{
    BeadsSection, BondsSection, DriveSection, Quantity, Record, Scene, Values,
    builtin::BUILTIN,
    reader::read_table,
    values::{Measured, Numbers, Seen},
};
use crate::{
    chain::{Boundary, Params},
    dps::Center,
    error::{Error, Result, brief, in_words, listed, nearest, one_line, refuse, require},
    number::double,
    run::{Method, Run},
};
use serde::{Deserialize, Serialize};
use std::{ops::Range, path::Path};
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error as Broken};

/// Largest number of characters of a line or a number in a message.
const SHOWN: usize = 60;

sections! {
    /// The whole file. Unknown keys are errors.
    pub struct SceneFile {
        /// Short name; if left out, the name of the file without its extension, or `scene`.
        #[serde(default)]
        name: String,
        /// One line on what the scene shows.
        #[serde(default)]
        summary: String,
        /// The chain.
        chain: ChainSection,
        /// What differs from bead to bead.
        beads?: BeadsSection,
        /// What differs from bond to bond.
        bonds?: BondsSection,
        /// What moves or pushes beads.
        #[serde(default, rename = "drive", skip_serializing_if = "Vec::is_empty")]
        drives: Vec<DriveSection>,
        /// That all numbers are in SI units, and the spheres.
        units?: UnitsSection,
        /// The initial state.
        initial: Initial,
        /// The time span.
        span: Span,
        /// The records.
        #[serde(default)]
        record: Record,
        /// The method; if left out, it follows from the regime of the chain. A method named by the
        /// caller has precedence.
        method?: MethodSection,
    }

    /// The section `[chain]`.
    pub struct ChainSection {
        /// Number of beads.
        sites: usize,
        /// Exponent.
        alpha: f64,
        /// Spring constant (0, no springs, if left out).
        #[serde(default)]
        kappa: f64 as Stiffness,
        /// Mass ratio resonator to bead (0, no resonators, if left out); `inf` for the cradle.
        #[serde(default)]
        rho: f64,
        /// The conditions at the ends.
        boundary: Boundary,
        /// Static overlap of each bond.
        #[serde(default)]
        precompression: f64 as Length,
        /// Acceleration of gravity (0 if left out). Displacements of resonators are then counted
        /// from where they hang at rest.
        gravity?: f64 as Acceleration,
        /// Angle of the chain below the horizontal, in degrees: at 90 (if left out) its right end
        /// is at the bottom, at -90 its left end.
        tilt?: f64,
    }
}

impl ChainSection {
    /// The three parameters.
    pub fn params(&self) -> Params {
        Params { alpha: self.alpha, kappa: self.kappa, rho: self.rho }
    }

    /// The acceleration of gravity along the chain, `gravity sin(tilt)`, towards the right end.
    ///
    /// # Errors
    /// A tilt without gravity, or not from -90 to 90.
    pub(super) fn along(&self) -> Result<f64> {
        let tilt = self.tilt.unwrap_or(90.0);
        require((-90.0..=90.0).contains(&tilt), "tilt", tilt, "an angle in degrees from -90 to 90")?;
        match (self.gravity, self.tilt) {
            (None, Some(tilt)) => Err(Error::parameter("tilt", tilt, "a tilt belongs to `gravity`")),
            (gravity, _) => Ok(gravity.unwrap_or(0.0) * tilt.to_radians().sin()),
        }
    }
}

/// The section `[initial]`; the key `kind` names the variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Initial {
    /// The wave (eq:ini_tw) on a strain ring, with exactly one of `epsilon` and
    /// `detuning = omega_tw - omega`.
    TravellingWave {
        /// Wave number divided by pi.
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
        /// Frequency minus `omega`.
        #[serde(skip_serializing_if = "Option::is_none")]
        detuning: Option<f64>,
        /// Largest relative perturbation of the amplitudes (eq:dA0_ptb), from 0 (none; the default)
        /// to below 1.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        zeta: Option<f64>,
        /// Seed of the perturbation (1 if left out).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        seed: Option<u64>,
    },
    /// All sites at rest except for one bead.
    SingleBead {
        /// The bead, counted from 0.
        site: usize,
        /// Displacement of the bead.
        #[serde(default)]
        displacement: f64,
        /// Velocity of the bead.
        #[serde(default)]
        velocity: f64,
    },
    /// `u_n = v_n = amplitude sin(pi mode (n+1)/(N+1))` at rest, a mode of a precompressed chain
    /// between walls.
    NormalMode {
        /// Number of half waves.
        mode: u32,
        /// Amplitude.
        amplitude: f64,
    },
    /// The exact solution (uncpl) without contact force.
    TrivialBreather(TrivialSection),
    /// The state (ini_num): beads displaced by `2 epsilon a_n`, a homoclinic solution of (dpsstat),
    /// with everything else at zero.
    BrightBreather {
        /// The symmetry of the profile: about a `site` (`a^1`) or a `bond` (`a^2`).
        center: Center,
        /// Size of the breather.
        epsilon: f64,
    },
    /// A soliton of the nonlinear Schrodinger equation of the loaded chain, see
    /// [`Nls`](crate::waves::Nls).
    Envelope {
        /// Phase of the wave from bead to bead divided by pi, above 0 and at most 1.
        q_over_pi: f64,
        /// The band, from 1 (the lowest).
        band: usize,
        /// Largest displacement of beads.
        amplitude: f64,
        /// Site of the centre, between sites if fractional (the middle of the chain if left out).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        center: Option<f64>,
    },
    /// At rest under gravity, constant forces, static overlaps and walls; one bead may be displaced
    /// from there or struck.
    Equilibrium {
        /// The bead, counted from 0.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        site: Option<usize>,
        /// Displacement of the bead (0 if left out).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        displacement: Option<f64>,
        /// Velocity of the bead (0 if left out).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        velocity: Option<f64>,
    },
    /// Any state, array by array; an array left out is zero. On a strain ring the arrays are
    /// strains and their rates.
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

sections! {
    /// The section `[initial]` of kind `trivial-breather`: amplitudes, phases and mean positions,
    /// each given in one way.
    #[derive(Default)]
    pub struct TrivialSection {
        /// `a_n`, site by site; otherwise `a_n = amplitude e^{-|n - center| / decay}` from the next
        /// three keys.
        amplitudes?: Vec<f64> as Length,
        /// Site of the centre, between sites if fractional.
        center?: f64,
        /// Largest `a_n`.
        amplitude?: f64 as Length,
        /// Decay length, in sites.
        decay?: f64,
        /// `phi_n`, site by site, in radians.
        phases?: Vec<f64>,
        /// `(phi_n - phi_{n-1}) / pi`, the same for all bonds (1, antiphase, if left out).
        phase_step_over_pi?: f64,
        /// Mean positions `b_n`, site by site.
        b?: Vec<f64> as Length,
        /// `d_n`, site by site: the mean positions are `b_n = d_n + sum l_k`. Where `d_n` is
        /// constant the beads touch but do not press.
        d?: Vec<f64> as Length,
        /// Increase of `d_n` from site to site, the same for all bonds (0 if left out); the mean of
        /// the `b_n` is then zero.
        gap?: f64 as Length,
    }

    /// The section `[units]`: all numbers of the scene are in SI units. Spheres give the masses and
    /// contact constants that `[beads]` and `[bonds]` do not.
    pub struct UnitsSection {
        /// `"SI"`. It must be given: in scenes without it only drives were in SI units.
        system?: String,
        /// Radii in metres; `inf` for a flat body.
        radius?: Values,
        /// Densities in kilograms per cubic metre.
        density?: Values,
        /// Young's moduli in pascals.
        young?: Values,
        /// Poisson's ratios.
        poisson?: Values,
        /// Young's modulus of walls (that of the bead beside it if left out).
        wall_young?: f64,
        /// Poisson's ratio of walls (that of the bead beside it if left out).
        wall_poisson?: f64,
        /// Static load in newtons, the same in all contacts (0 if left out).
        static_load?: f64,
    }

    /// The section `[span]`, with exactly one of `periods` and `until`.
    pub struct Span {
        /// Length in periods of the scene.
        periods?: f64,
        /// End time.
        until?: f64 as Time,
        /// Unit of time for steps per period, for scenes without a frequency of their own (1 if
        /// left out).
        period?: f64 as Time,
    }

    /// The section `[method]`: an integrator, and at most one of the other keys.
    pub struct MethodSection {
        /// Name of the integrator.
        integrator: String,
        /// Tolerance, for an integrator that takes one.
        tol?: f64,
        /// Step; it is reduced where a whole number of steps must fit the span.
        step?: f64 as Time,
        /// Steps per period of the scene.
        steps_per_period?: f64,
    }
}

impl MethodSection {
    /// The run with this method and setting.
    ///
    /// # Errors
    /// An unknown integrator; more than one setting; a setting that the integrator does not take or
    /// that is outside its rule.
    pub fn of(&self, run: Run) -> Result<Run> {
        let &Self { ref integrator, tol, step, steps_per_period } = self;
        let method = Method::named(integrator)?;
        let given = [tol.is_some(), step.is_some(), steps_per_period.is_some()].into_iter().filter(|one| *one).count();
        require(given <= 1, "method", "[method]", "give one of `tol`, `step` and `steps_per_period`")?;
        let tolerance = tol.filter(|_| !method.tolerant());
        refuse("tol", tolerance, "this integrator takes `step` or `steps_per_period`")?;
        refuse("step", step.filter(|_| method.adaptive()), "this integrator takes `tol`")?;
        let count = steps_per_period.filter(|count| method.adaptive() || count.is_nan() || *count <= 0.0);
        refuse("steps_per_period", count, "positive, and for an integrator that takes steps; others take `tol`")?;
        let run = run.method(method);
        let step = step.or_else(|| steps_per_period.map(|count| run.period() / count));
        match (tol, step) {
            (Some(tol), _) => run.tolerance(tol),
            (None, Some(step)) => run.step(step),
            (None, None) => Ok(run),
        }
    }
}

impl Measured for Initial {
    fn measured(&mut self, seen: Seen<'_>) {
        let mut one = |key, quantity, numbers: &mut dyn Numbers| numbers.each(&mut |x| seen(key, quantity, x));
        match self {
            // Strain rings are without units.
            Self::TravellingWave { .. } => {}
            Self::SingleBead { displacement, velocity, .. } => {
                one("displacement", Quantity::Length, displacement);
                one("velocity", Quantity::Velocity, velocity);
            }
            Self::Equilibrium { displacement, velocity, .. } => {
                one("displacement", Quantity::Length, displacement);
                one("velocity", Quantity::Velocity, velocity);
            }
            Self::NormalMode { amplitude, .. } | Self::Envelope { amplitude, .. } => {
                one("amplitude", Quantity::Length, amplitude)
            }
            Self::TrivialBreather(section) => section.measured(seen),
            Self::BrightBreather { epsilon, .. } => one("epsilon", Quantity::Length, epsilon),
            Self::State { u, v, u_dot, v_dot } => {
                one("u", Quantity::Length, u);
                one("v", Quantity::Length, v);
                one("u_dot", Quantity::Velocity, u_dot);
                one("v_dot", Quantity::Velocity, v_dot);
            }
        }
    }
}

impl SceneFile {
    /// Shows the numbers that have a unit, but for masses and contact constants, which `[units]`
    /// gives or lets a scene give.
    pub(super) fn quantities(&mut self, seen: Seen<'_>) {
        let Self { chain, beads, bonds, drives, initial, span, method, .. } = self;
        let tables: [Option<&mut dyn Measured>; 6] = [
            Some(chain),
            beads.as_mut().map(|table| table as &mut dyn Measured),
            bonds.as_mut().map(|table| table as &mut dyn Measured),
            Some(initial),
            Some(span),
            method.as_mut().map(|table| table as &mut dyn Measured),
        ];
        tables.into_iter().flatten().for_each(|table| table.measured(&mut *seen));
        let table = bonds.as_mut().and_then(|bonds| bonds.table.as_mut());
        table.into_iter().for_each(|table| table.measured(&mut *seen));
        for drive in drives {
            let quantity = drive.quantity();
            drive.amplitude.each(&mut |x| seen("amplitude", quantity, x));
            drive.values.each(&mut |x| seen("values", quantity, x));
            drive.measured(&mut *seen);
        }
    }
}

impl SceneFile {
    /// Reads a scene from `text`; messages call it `file`.
    ///
    /// # Errors
    /// The line, the key and the rule, with the nearest known key for an unknown one; a number that
    /// a double cannot hold.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        Self::parse_with(text, file, &[])
    }

    /// Reads a scene with some keys changed.
    ///
    /// A change is a line of TOML with a dotted key, such as `chain.rho=3`. A value that is not
    /// TOML is taken as a string, so that `chain.boundary=ring` needs no quotation marks.
    ///
    /// # Errors
    /// As [`parse`](Self::parse); the message names the change instead of a line if the change
    /// causes the error.
    pub fn parse_with(text: &str, file: &str, changes: &[String]) -> Result<Self> {
        let fail = |message| Error::Scene { file: file.to_owned(), message };
        let source = Source { text, changes };
        let lines = source.lines().map_err(fail)?;
        let broken = |error: Broken| fail(explain(error.message(), error.span(), &source, None));
        let mut table = DeTable::parse(text).map_err(broken)?;
        for line in &lines {
            let change = DeTable::parse(line).map_err(broken)?;
            let merged = merge(table.get_mut(), change.into_inner());
            merged.map_err(|(at, rule)| fail(format!("{}: {rule}", source.place(at))))?;
        }
        held(table.get_ref()).map_err(|(at, rule)| fail(format!("{}: {rule}", source.place(at))))?;
        let mut scene: Self = read_table(&table)
            .map_err(|(message, span)| fail(explain(&message, Some(span), &source, Some(table.get_ref()))))?;
        if scene.name.is_empty() {
            scene.name = Path::new(file).file_stem().map_or("scene".into(), |stem| one_line(&stem.to_string_lossy()));
        }
        let folder = Path::new(file).parent().unwrap_or(Path::new(""));
        for (k, drive) in scene.drives.iter_mut().enumerate() {
            drive.read(folder).map_err(|error| fail(format!("[[drive]] {}, `file`: {error}", k + 1)))?;
        }
        Ok(scene)
    }

    /// The place of the parameter `name` for messages: its line, or the change that set it, and its
    /// key.
    pub(super) fn place(text: &str, changes: &[String], name: &str) -> Option<String> {
        let source = Source { text, changes };
        let lines = source.lines().ok()?;
        let mut table = DeTable::parse(text).ok()?;
        for line in &lines {
            merge(table.get_mut(), DeTable::parse(line).ok()?.into_inner()).ok()?;
        }
        let leaves = leaves(table.get_ref(), "");
        let found: Vec<_> = leaves.iter().filter(|leaf| leaf.is(name)).collect();
        // Of several drives or terms only a changed one is known.
        let unknown = found.len() > 1 && ["drive.", "bonds.terms"].iter().any(|list| name.starts_with(list));
        let changed = || found.iter().rfind(|leaf| leaf.value.span().start >= text.len());
        let leaf = if unknown { changed() } else { found.first() }?;
        Some(format!("{}: `{}`", source.place(leaf.value.span().start), leaf.key))
    }

    /// The scene as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }
}

/// The sources of a scene: the text of a file and the changes. Positions in bytes are counted
/// through all of them.
struct Source<'a> {
    text: &'a str,
    changes: &'a [String],
}

impl Source<'_> {
    /// Each change with its first position in the count of bytes. After each change `QUOTES`
    /// positions are reserved.
    fn starts(&self) -> impl Iterator<Item = (usize, &String)> {
        self.changes.iter().scan(self.text.len() + 1, |next, change| {
            let start = *next;
            *next += change.len() + QUOTES + 1;
            Some((start, change))
        })
    }

    /// The changes as TOML, each after as many blanks as its position, so that the parser reports
    /// positions in the whole source.
    fn lines(&self) -> std::result::Result<Vec<String>, String> {
        let line = |(start, change): (usize, &String)| {
            let Some((key, value)) = change.split_once('=') else {
                return Err(format!("--set {}: not KEY=VALUE, as in chain.rho=3", short(change)));
            };
            if DeTable::parse(change).is_ok() {
                return Ok(" ".repeat(start) + change);
            }
            // A number or a place in a list that TOML would write otherwise is not meant as a text.
            let why = match value.trim().parse::<f64>() {
                _ if key.contains('[') => {
                    "an entry of a list has its number after a dot, as in drive.0.amplitude".into()
                }
                Ok(number) => format!("TOML writes this number {}", brief(&number.to_string().to_lowercase())),
                Err(_) => return Ok(format!("{}{key}={}", " ".repeat(start), toml::Value::from(value.trim()))),
            };
            Err(format!("--set {}: {why}", short(change)))
        };
        self.starts().map(line).collect()
    }

    /// The line or the change that holds the byte `at`.
    fn place(&self, at: usize) -> String {
        match self.starts().take_while(|(start, _)| *start <= at).last() {
            Some((_, change)) => format!("--set {}", short(change)),
            None => format!("line {}", 1 + line(self.text, at)),
        }
    }
}

/// Bytes reserved for the quotation marks and escapes that a change may get.
const QUOTES: usize = 1 << 12;

/// The place in a list that a key is, if it is a whole number.
fn place_in_list(key: &str) -> Option<usize> {
    let place: usize = key.parse().ok()?;
    (place.to_string() == key).then_some(place)
}

/// Inserts the entries of `change` into `table`; they replace entries of the same keys. Refuses a
/// place that a list does not have, with the position of the key in the source.
fn merge<'a>(table: &mut DeTable<'a>, change: DeTable<'a>) -> std::result::Result<(), (usize, String)> {
    for (key, value) in change {
        match table.get_mut(&key) {
            Some(old) => replace(old, value)?,
            None => drop(table.insert(key, value)),
        }
    }
    Ok(())
}

/// Replaces a value by `change`; of a table and a list only what `change` has. In a list the key is
/// the place of an entry, from 0 on.
fn replace<'a>(
    old: &mut Spanned<DeValue<'a>>,
    change: Spanned<DeValue<'a>>,
) -> std::result::Result<(), (usize, String)> {
    let of_list = |of: &DeTable| !of.is_empty() && of.keys().all(|key| place_in_list(key.get_ref()).is_some());
    let whole = match (old.get_ref(), change.get_ref()) {
        (DeValue::Table(_), DeValue::Table(_)) => false,
        (DeValue::Array(_), DeValue::Table(of)) => !of_list(of),
        _ => true,
    };
    if whole {
        *old = change;
        return Ok(());
    }
    match (old.get_mut(), change.into_inner()) {
        (DeValue::Table(below), DeValue::Table(change)) => merge(below, change),
        (DeValue::Array(list), DeValue::Table(change)) => change.into_iter().try_for_each(|(key, change)| {
            let count = list.len();
            match place_in_list(key.get_ref()).and_then(|place| list.as_mut().get_mut(place)) {
                Some(entry) => replace(entry, change),
                None => Err((
                    key.span().start,
                    format!("{} is no entry of this list: it has {count}, counted from 0", key.get_ref()),
                )),
            }
        }),
        _ => Ok(()),
    }
}

/// A key whose value is not a table.
struct Leaf<'a> {
    /// The dotted key, such as `chain.alpha`.
    key: String,
    value: &'a Spanned<DeValue<'a>>,
}

/// Checks that doubles can hold the numbers of a table, and that its texts and keys have no control
/// characters, which a terminal would obey. An error is the place in the source, and key and rule.
pub(crate) fn held(table: &DeTable<'_>) -> std::result::Result<(), (usize, String)> {
    fn of(value: &Spanned<DeValue<'_>>) -> std::result::Result<(), (usize, String)> {
        let held = match value.get_ref() {
            DeValue::Float(x) => double(x.as_str()).map(drop).map_err(|rule| format!("{}: {rule}", short(x.as_str()))),
            DeValue::String(text) => plain(text),
            DeValue::Array(list) => return list.iter().try_for_each(of),
            DeValue::Table(table) => return table.values().try_for_each(of),
            _ => Ok(()),
        };
        held.map_err(|rule| (value.span().start, rule))
    }
    leaves(table, "").into_iter().try_for_each(|Leaf { key, value }| {
        let held = plain(&key).map_err(|rule| (value.span().start, rule)).and_then(|()| of(value));
        held.map_err(|(at, rule)| (at, format!("`{}`: {rule}", one_line(&key))))
    })
}

/// The beginning of a text of the user, for a message.
fn short(text: &str) -> String {
    let rest = text.chars().nth(SHOWN).map(|_| '\u{2026}');
    one_line(&text.chars().take(SHOWN).chain(rest).collect::<String>())
}

/// Refuses a text with control characters.
fn plain(text: &str) -> std::result::Result<(), String> {
    if !text.contains(char::is_control) {
        return Ok(());
    }
    let shown: String = text.escape_debug().take(SHOWN).collect();
    Err(format!("\"{shown}\": a text here has no control characters"))
}

fn leaves<'a>(table: &'a DeTable<'a>, above: &str) -> Vec<Leaf<'a>> {
    let below = |(name, value): (&Spanned<_>, &'a Spanned<DeValue<'a>>)| {
        let key = format!("{above}{}", name.get_ref());
        match value.get_ref() {
            DeValue::Table(table) => leaves(table, &(key + ".")),
            DeValue::Array(tables)
                if ["drive", "bonds.terms"].contains(&&*key) && tables.iter().all(|one| one.get_ref().is_table()) =>
            {
                let tables = tables.iter().filter_map(|one| one.get_ref().as_table()).enumerate();
                tables.flat_map(|(k, table)| leaves(table, &format!("{key}.{k}."))).collect()
            }
            _ => vec![Leaf { key, value }],
        }
    };
    table.iter().flat_map(below).collect()
}

impl Leaf<'_> {
    /// Whether `name` means this key. A name without a dot is the last part of the key. A dotted
    /// name is the whole key without places in lists, or a table that holds it.
    fn is(&self, name: &str) -> bool {
        let mut parts = self.key.split('.').filter(|part| place_in_list(part).is_none());
        match name.contains('.') {
            true => name.split('.').all(|part| parts.next() == Some(part)),
            false => parts.next_back() == Some(name),
        }
    }
}

/// The number, from 0, of the line in which the byte `at` is.
fn line(text: &str, at: usize) -> usize {
    text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

/// The message of an error of the reader, with the line and the key of its cause.
///
/// `table` is the scene, if it could be read as TOML.
fn explain(error: &str, span: Option<Range<usize>>, source: &Source<'_>, table: Option<&DeTable<'_>>) -> String {
    let text = source.text;
    let message = in_words(&error.lines().collect::<Vec<_>>().join("; "));
    // Form of the message of serde: unknown field `x`, expected one of `a`, `b`.
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let [missing, unknown] = ["missing field", "unknown field"].map(|what| message.starts_with(what));
    let span = span.filter(|span| *span != (0..text.len()));
    let leaves = table.map(|table| leaves(table, "")).unwrap_or_default();
    let hint = names.split_first().filter(|_| message.starts_with("unknown")).and_then(|(name, known)| {
        let plural = |key: &&str| key.trim_end_matches('s') == name.trim_end_matches('s');
        let belongs = if unknown && !known.iter().any(plural) { elsewhere(name, &leaves) } else { None };
        belongs.or_else(|| Some(format!("; did you mean `{}`?", nearest(name, known.iter().copied())?)))
    });
    let message = match message.split_once("expected one of ") {
        Some((found, _)) if hint.is_some() => found.trim_end_matches(", ").to_owned(),
        Some((found, known)) => format!("{found}expected one of {}", listed(known.split(", "))),
        None => message,
    };
    let hint = hint.unwrap_or_default();
    let there = |leaf: &&Leaf<'_>| span.as_ref().is_some_and(|span| leaf.value.span().contains(&span.start));
    let cause = || culprit(error, table?).and_then(|key| leaves.iter().find(|leaf| leaf.key == key));
    let leaf = leaves.iter().find(there).or_else(cause).filter(|_| !missing);
    let message = match leaf.map(|leaf| leaf.value.span().start).or(span.map(|span| span.start)) {
        None => message + &hint,
        Some(at) => {
            let place = match leaf {
                _ if unknown => String::new(),
                Some(leaf) => format!("`{}`: ", leaf.key),
                None if at > text.len() => String::new(),
                None => format!("`{}`: ", short(text.lines().nth(line(text, at)).unwrap_or_default())),
            };
            format!("{}: {place}{message}{hint}", source.place(at))
        }
    };
    one_line(&message)
}

/// A hint for an unknown key `name`: the table that has such a key in a built-in scene or in the
/// template. `here` are the keys of the scene.
fn elsewhere(name: &str, here: &[Leaf<'_>]) -> Option<String> {
    let texts = BUILTIN.iter().map(|(_, text)| *text).chain([Scene::TEMPLATE]);
    let key = texts.filter_map(|text| DeTable::parse(text).ok()).find_map(|table| {
        let all = leaves(table.get_ref(), "");
        // A key of `[initial]` may be unknown because its kind is another one: its table is right.
        let is_there = |key: &String| key.starts_with("initial.") && here.iter().any(|leaf| leaf.key == *key);
        let other = |key: &String| key.rsplit('.').next() == Some(name) && !is_there(key);
        all.into_iter().map(|leaf| leaf.key).find(other)
    })?;
    let inside = key.contains('.');
    Some(if inside { format!("; did you mean `{key}`?") } else { format!("; `{key}` stands above all tables") })
}

/// The key of `[initial]` that causes a message.
///
/// A table with a `kind` is read as a whole, without the place of an error. Here the keys are
/// inserted one after the other; the first with which the message appears is the cause.
fn culprit(message: &str, table: &DeTable<'_>) -> Option<String> {
    let initial = table.get("initial")?.get_ref().as_table()?;
    let mut some = Spanned::new(0..0, DeTable::new());
    let kind = initial.get_key_value("kind");
    kind.into_iter().chain(initial).find_map(|(key, value)| {
        some.get_mut().insert(key.clone(), value.clone());
        let (error, _) = read_table::<Initial>(&some).err()?;
        (error == message).then(|| format!("initial.{}", key.get_ref()))
    })
}
