//! Scenes: named, complete set-ups with chain, initial state, time span and records.

/// Tables of a scene file; unknown keys are errors. `key?: type` may be left out: it is an
/// `Option`, and is not written if it is `None`. `as` names the quantity of the numbers of a key,
/// which decides their unit in a scene with `[units]`. `=> "words" Quantity` tells a list of the
/// details of a chain, which has the name of the key.
macro_rules! sections {
    ($($(#[$about:meta])* pub struct $name:ident {
        $($(#[$key:meta])* $field:ident $(?: $optional:ty $(as $of:ident)? $(=> $words:literal $own:ident)?)?
            $(: $type:ty $(as $quantity:ident)?)?,)*
    })*) => {$(
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, expecting = "a table of keys")]
        pub struct $name {
            $($(#[$key])*
            $(#[serde(skip_serializing_if = "Option::is_none")] pub $field: Option<$optional>)?
            $(pub $field: $type)?,)*
        }

        impl $name {
            /// The keys.
            pub const KEYS: &[&str] = &[$(stringify!($field)),*];

            /// The keys of lists of details, with quantity and words.
            #[allow(dead_code, reason = "most sections have none")]
            const LISTS: &[(&str, $crate::report::Quantity, &str)] = &[$($($((
                stringify!($field),
                $crate::report::Quantity::$own,
                $words,
            ),)?)?)*];

            /// Sets these lists, each of so many numbers.
            #[allow(dead_code, unused_variables, reason = "most sections have none")]
            fn set(&self, details: &mut $crate::chain::Details, count: usize) -> $crate::error::Result<()> {
                $($($(let _ = $words;
                details.$field = list(stringify!($field), &self.$field, count)?;)?)?)*
                Ok(())
            }
        }

        impl $crate::scene::values::Measured for $name {
            fn measured(&mut self, seen: $crate::scene::values::Seen<'_>) {
                let mut _all = |key, quantity, numbers: &mut dyn $crate::scene::values::Numbers| {
                    numbers.each(&mut |x| seen(key, quantity, x));
                };
                $($($(_all(stringify!($field), $crate::report::Quantity::$of, &mut self.$field);)?)?
                $($(_all(stringify!($field), $crate::report::Quantity::$quantity, &mut self.$field);)?)?)*
            }
        }
    )*};
}

mod builtin;
mod details;
mod file;
mod idle;
mod initial;
mod reader;
mod record;
mod units;
mod values;

pub use crate::report::{Quantity, Units};
pub(crate) use builtin::builtin;
pub use details::{BeadsSection, BondsSection, DriveSection, DriveSite, Shape, TableSection, TermSection};
pub(crate) use file::held;
pub use file::{ChainSection, Initial, MethodSection, SceneFile, Span, TrivialSection, UnitsSection};
pub(crate) use reader::read_table;
pub use record::{PlaceRange, Places, Record, Recorded, Selection};
pub use values::{Rule, Values};

use crate::{
    breathers::{BrightBreather, TrivialBreather},
    chain::{Chain, Details, Energy, Resonators, State},
    error::{Error, NOTHING, Result, beside, positive, refuse, require},
    memory::lacking,
    number::rounded,
    output::read,
    run::{AFTER_START, Method, Observables, Records, Run, Setting, checked_end},
    waves::{PerturbedWave, TravellingWave},
};
use builtin::BUILTIN;
use hertzchain_integrators::Error as Failure;
use initial::{initial_state, within_range};
use std::{f64::consts::PI, path::Path, sync::Arc};

/// Largest number of sites; a state of that size takes 3.2 GB.
pub(crate) const MOST_SITES: usize = 100_000_000;
/// Longest scene file in bytes; arrays of millions of sites fit.
const MOST_BYTES: u64 = 1 << 28;
/// Bytes of a run that every machine has.
const NEGLIGIBLE: u64 = 1 << 26;
const MOST_SAMPLES: usize = 1_000_000;
/// Most numbers of what `[record]` names: half a gigabyte.
const MOST_NUMBERS: usize = 1 << 26;

const NO_WAVE: &str = "a scene whose initial state is of kind travelling-wave";

/// A theory to compare a run with.
#[derive(Clone, Debug)]
pub enum Theory {
    /// The first-order wave (eq:xytw_app).
    Wave(TravellingWave),
    /// The first-order wave, perturbed (eq:dA0_ptb); its ansatz (eq:xy_app) needs a run of the
    /// modulation equations.
    PerturbedWave(PerturbedWave),
    /// The exact solution (uncpl).
    Breather(TrivialBreather),
    /// The long-lived breather (time-periodic_osc).
    Bright(BrightBreather),
}

/// A scene that has been checked and can be run.
#[derive(Clone, Debug)]
pub struct Scene {
    file: SceneFile,
    chain: Chain<f64>,
    units: Option<Units>,
    /// The method that the file names, with a dimensionless step.
    method: Option<MethodSection>,
    initial: Arc<State<f64>>,
    theory: Option<Theory>,
    period: f64,
    /// Time at which it begins, if it is a [part](Self::part) of a longer run.
    start: Option<f64>,
    end: f64,
    /// Whether the number of samples is given, not the default.
    says_samples: bool,
    selection: Option<Selection>,
}

impl Scene {
    /// A scene in TOML with every key and an explanation of each, as a start for new scenes.
    pub const TEMPLATE: &str = include_str!("template.toml");

    /// Names and one-line summaries of the built-in scenes.
    pub fn list() -> Vec<(&'static str, String)> {
        BUILTIN
            .iter()
            .map(|&(name, text)| (name, SceneFile::parse(text, name).map(|file| file.summary).unwrap_or_default()))
            .collect()
    }

    /// The TOML of a built-in scene or of a file; a text of several lines is the TOML itself.
    ///
    /// # Errors
    /// An unknown name (with the nearest one), or a file that cannot be read.
    pub fn source(name_or_file: &str) -> Result<String> {
        if name_or_file.contains('\n') {
            return Ok(name_or_file.to_owned());
        }
        if let Some((_, text)) = BUILTIN.iter().find(|(name, _)| *name == name_or_file) {
            return Ok((*text).to_owned());
        }
        let path = Path::new(name_or_file);
        if path.extension().is_some() || path.components().count() > 1 || path.exists() {
            return String::from_utf8(read(path, MOST_BYTES)?).map_err(|why| {
                let message = format!("not valid UTF-8: {why}");
                Error::Scene { file: name_or_file.to_owned(), message }
            });
        }
        Err(Error::unknown("scene", name_or_file, BUILTIN.iter().map(|(name, _)| *name)))
    }

    /// A built-in scene by name, or the scene in a file.
    ///
    /// # Errors
    /// See [`source`](Self::source), [`SceneFile::parse`] and [`build`](Self::build).
    pub fn load(name_or_file: &str) -> Result<Self> {
        Self::load_with(name_or_file, &[])
    }

    /// A built-in scene or a file with some keys changed; see [`SceneFile::parse_with`].
    ///
    /// # Errors
    /// As [`load`](Self::load).
    ///
    /// ```
    /// use hertzchain::scene::Scene;
    /// let heavy = Scene::load_with("tw-rho3", &["chain.rho=1000".to_owned()])?;
    /// assert_eq!(heavy.chain().params().rho, 1000.0);
    /// # Ok::<(), hertzchain::Error>(())
    /// ```
    pub fn load_with(name_or_file: &str, changes: &[String]) -> Result<Self> {
        Self::parse_with(&Self::source(name_or_file)?, name_or_file, changes)
    }

    /// The scene in `text`; messages call it `file`.
    ///
    /// # Errors
    /// See [`SceneFile::parse`] and [`build`](Self::build).
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        Self::parse_with(text, file, &[])
    }

    /// The scene in `text` with some keys changed; see [`SceneFile::parse_with`].
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn parse_with(text: &str, file: &str, changes: &[String]) -> Result<Self> {
        let file = file.split_once('\n').map_or(file, |(name, _)| name.trim_start_matches("name = ").trim_matches('"'));
        let refused = |error: Error| {
            let place = match &error {
                Error::Parameter { name, .. } | Error::Integration(Failure::Argument { name, .. }) => {
                    SceneFile::place(text, changes, name)
                }
                _ => None,
            };
            let message = place.map(|place| place + ": ").unwrap_or_default() + &error.to_string();
            Error::Scene { file: file.to_owned(), message }
        };
        Self::build(SceneFile::parse_with(text, file, changes)?).map_err(refused)
    }

    /// As [`load_with`](Self::load_with), for what does not depend on the initial state: a scene
    /// without `[initial]` begins at rest.
    ///
    /// # Errors
    /// As [`load_with`](Self::load_with).
    pub(crate) fn load_at_rest(name_or_file: &str, changes: &[String]) -> Result<Self> {
        let text = Self::source(name_or_file)?;
        let given = text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("initial"));
        let rest = (!given).then(|| "initial.kind = \"state\"".to_owned());
        Self::parse_with(&text, name_or_file, &rest.into_iter().chain(changes.iter().cloned()).collect::<Vec<_>>())
    }

    /// Checks a scene and computes its initial state.
    ///
    /// # Errors
    /// The first parameter outside its rule.
    pub fn build(file: SceneFile) -> Result<Self> {
        Self::build_from(file, None)
    }

    fn build_from(mut file: SceneFile, start: Option<f64>) -> Result<Self> {
        let units = file.units.is_some();
        file.drives.iter_mut().try_for_each(|drive| drive.in_hertz(units))?;
        require(file.chain.sites <= MOST_SITES, "sites", file.chain.sites, "at most 10^8")?;
        if file.units.is_some() {
            // All numbers of its beads are made dimensionless at once.
            let needed = Details::site_bytes() * file.chain.sites as u64;
            fits("sites", file.chain.sites, needed, "three states fit into the memory")?;
        }
        match file.dimensionless()? {
            None => Self::built(file, None, start),
            Some(plain) => {
                Self::built(file.clone(), Some(&plain), start).map_err(|error| file.restated(error, &plain.1))
            }
        }
    }

    /// The scene `given`, which begins at `start`. In SI units it is `plain` in dimensionless
    /// numbers.
    fn built(mut given: SceneFile, plain: Option<&(SceneFile, Units)>, start: Option<f64>) -> Result<Self> {
        let (file, units) = plain.map_or((&given, None), |(file, units)| (file, Some(*units)));
        let start = start.map(|start| units.map_or(start, |units| units.from_si(Quantity::Time, start)));
        let section = &file.chain;
        refuse("samples", file.record.samples.filter(|samples| *samples > MOST_SAMPLES), "at most 10^6")?;
        // The chain takes -0 as zero; in a file it is a mistake.
        let signed = |value: f64| value == 0.0 && value.is_sign_negative();
        let rule = "at least zero, and written without a sign";
        refuse("kappa", Some(section.kappa).filter(|value| signed(*value)), rule)?;
        refuse("rho", Some(section.rho).filter(|value| signed(*value)), rule)?;
        refuse("precompression", Some(section.precompression).filter(|value| signed(*value)), rule)?;
        let chain =
            Chain::new(section.params(), section.boundary, section.sites)?.precompressed(section.precompression)?;
        let tables = details::Tables {
            beads: file.beads.as_ref(),
            bonds: file.bonds.as_ref(),
            drives: &file.drives,
            gravity: section.along()?,
        };
        let of_beads = if tables.none() { 0 } else { Details::site_bytes() * chain.sites() as u64 };
        let needed = Self::least_memory(&chain) + of_beads;
        fits("sites", chain.sites(), needed, "three states fit into the memory")?;
        let chain = tables.apply(chain)?;
        // Beads that differ have no common frequency.
        let has_frequency = chain.params().resonators() != Resonators::None && chain.details().is_none();
        let named = has_frequency && section.params().resonators() != Resonators::None;
        let (initial, theory) = initial_state(&chain, &file.initial, start)?;
        within_range(&chain, initial.as_slice(), &file.initial)?;
        if chain.details().is_some_and(|details| !details.magnet.is_empty()) {
            chain.magnets_apart(initial.as_slice())?;
        }
        let period = match &theory {
            Some(Theory::Wave(wave)) => 2.0 * PI / wave.omega_tw(),
            Some(Theory::PerturbedWave(perturbed)) => 2.0 * PI / perturbed.wave().omega_tw(),
            Some(Theory::Bright(breather)) => breather.period(),
            _ if has_frequency && file.span.period.is_none() => 2.0 * PI / chain.params().omega(),
            _ => file.span.period.unwrap_or(1.0),
        };
        let rule = "this scene has a frequency of its own: leave `period` out";
        refuse("period", file.span.period.filter(|_| named), rule)?;
        let period = positive("period", period)?;
        let end = match (file.span.periods, file.span.until) {
            (Some(periods), None) => checked_end(positive("periods", periods)? * period)
                .map_err(|_| Error::parameter("periods", periods, "the end of a run is from 1e-100 to 1e100"))?,
            (None, Some(until)) => checked_end(until)?,
            (periods, _) => {
                let (name, value) =
                    periods.map_or(("span", NOTHING.to_owned()), |_| ("span.periods", beside("`until`")));
                return Err(Error::parameter(
                    name,
                    value,
                    "a span has one of `periods` and `until`; --until T is in place of either",
                ));
            }
        };
        let selection = file.record.selection(&chain)?;
        if let (Some(selection), samples) = (&selection, file.record.samples.unwrap_or(Record::FEWEST_SAMPLES)) {
            require(samples > 0, "record.samples", samples, "at least 1 where quantities are named")?;
            let numbers = selection.width().saturating_mul(samples);
            let rule = "at most 2^26 in all: name fewer quantities, sites or bonds, or take fewer samples";
            require(numbers <= MOST_NUMBERS, "record", format!("of {numbers} numbers"), rule)?;
        }
        let (says_samples, method) = (file.record.samples.is_some(), file.method.clone());
        if let (Some(Theory::PerturbedWave(drawn)), Initial::TravellingWave { seed, .. }) =
            (&theory, &mut given.initial)
        {
            *seed = Some(drawn.seed());
        }
        details::within(&chain, end, start.is_none())?;
        let mut scene = Self {
            chain,
            units,
            method,
            initial: initial.into(),
            theory,
            period,
            start,
            end,
            selection,
            file: given,
            says_samples,
        };
        scene.sample();
        scene.checked_run()?;
        Ok(scene)
    }

    /// Bytes that a run of a chain takes at least: the initial state, the recorded one, and that of
    /// the method.
    pub(crate) fn least_memory(chain: &Chain<f64>) -> u64 {
        3 * size_of::<f64>() as u64 * chain.layout().dim() as u64
    }

    /// Sets the number of samples to its default if it is not given.
    fn sample(&mut self) {
        if !self.says_samples {
            self.file.record.samples = Some(Record::by_default(self.has_period().then_some(self.end / self.period)));
        }
    }

    /// The scene with the amplitudes and the frequencies of its harmonic drives times these
    /// factors; constant forces stay.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn driven(&self, [amplitude, omega]: [f64; 2]) -> Result<Self> {
        let mut file = self.file.clone();
        for drive in &mut file.drives {
            if let (Some(a), Some(w)) = (&mut drive.amplitude, &mut drive.omega) {
                let (sizes, omegas) = (a.list("drive.amplitude")?, w.list("drive.omega")?);
                let scaled = sizes.iter().zip(&omegas).map(|(a, w)| if *w > 0.0 { a * amplitude } else { *a });
                *a = Values::List(scaled.collect());
                *w = Values::List(omegas.iter().map(|w| w * omega).collect());
            }
        }
        Self::build(file)
    }

    /// The scene with another end time, dimensionless as [`end`](Self::end).
    ///
    /// # Errors
    /// A time outside 1e-100 .. 1e100, or at which a drive has not yet acted.
    pub fn until(self, end: f64) -> Result<Self> {
        let own = self.in_file(Quantity::Time, end);
        self.until_in_file(own)
    }

    /// The scene with another end time in the units of its file: seconds with `[units]`.
    ///
    /// # Errors
    /// As [`until`](Self::until).
    pub fn until_in_file(mut self, end: f64) -> Result<Self> {
        (self.file.span.periods, self.file.span.until) = (None, Some(end));
        let own = self.of_file(Quantity::Time, end);
        let checked = checked_end(own).and_then(|end| {
            require(end > self.start_time(), "until", end, AFTER_START)?;
            details::within(&self.chain, end, self.start.is_none())
        });
        checked.map_err(|error| self.restated(error))?;
        self.end = own;
        self.sample();
        Ok(self)
    }

    /// A dimensionless number in the units of the file: SI units with `[units]`.
    pub fn in_file(&self, quantity: Quantity, value: f64) -> f64 {
        self.units.map_or(value, |units| units.to_si(quantity, value))
    }

    /// The dimensionless number of one in the units of the file.
    pub fn of_file(&self, quantity: Quantity, value: f64) -> f64 {
        self.units.map_or(value, |units| units.from_si(quantity, value))
    }

    /// An error of what is computed from the scene, in the units of the file.
    pub(crate) fn restated(&self, error: Error) -> Error {
        match &self.units {
            Some(units) => self.file.restated(error, units),
            None => error,
        }
    }

    /// A time for people, in the units of the file.
    pub(crate) fn in_words(&self, t: f64) -> String {
        self.units.map_or_else(|| t.to_string(), |units| format!("{} s", rounded(units.to_si(Quantity::Time, t))))
    }

    /// In words: sizes of numbers in SI units that are hardly meant, with the unit that is likely;
    /// and keys of the file that change nothing.
    pub fn doubts(&self) -> Vec<String> {
        self.file.doubts().into_iter().chain(self.idle()).collect()
    }

    /// The scene with another perturbation of the wave's amplitudes; none for `zeta = 0`. The
    /// default seed is 1.
    ///
    /// # Errors
    /// A scene that is not a travelling wave; `zeta` outside `[0, 1)`; a seed without a
    /// perturbation.
    pub fn perturbed(&self, zeta: f64, seed: Option<u64>) -> Result<Self> {
        let mut file = self.file.clone();
        let Initial::TravellingWave { zeta: own_zeta, seed: own_seed, .. } = &mut file.initial else {
            return Err(Error::parameter("scene", self.name(), NO_WAVE));
        };
        (*own_zeta, *own_seed) = (Some(zeta), seed);
        if !self.says_samples {
            file.record.samples = None;
        }
        Self::build(file)
    }

    /// The scene from another state, array by array, in the units of its file; an array left out is
    /// zero.
    ///
    /// # Errors
    /// Arrays of another length than the chain; a number that is not finite; no moving resonators,
    /// but arrays of them; a number other than 0 for a resonator that does not move.
    pub fn from_state(&self, u: Vec<f64>, v: Vec<f64>, u_dot: Vec<f64>, v_dot: Vec<f64>) -> Result<Self> {
        let until = self.file.span.until.unwrap_or_else(|| self.in_file(Quantity::Time, self.end));
        let span = Span { periods: None, until: Some(until), period: self.file.span.period };
        let initial = Initial::State { u, v, u_dot, v_dot };
        Self::build(SceneFile { initial, span, ..self.file.clone() })
    }

    /// A part of a longer run: the scene from a state at one time to another time, in the units of
    /// its file, with arrays as for [`from_state`](Self::from_state). Drives act as at these times,
    /// and need not come to their full height.
    ///
    /// # Errors
    /// As [`from_state`](Self::from_state); a bead that a drive moves with other numbers than 0 and
    /// those of the drive at the first time; a first time that is negative or not before the
    /// second.
    pub fn part(&self, [start, end]: [f64; 2], state: [Vec<f64>; 4]) -> Result<Self> {
        let span = Span { periods: None, until: Some(end), period: self.file.span.period };
        let [u, v, u_dot, v_dot] = state;
        let initial = Initial::State { u, v, u_dot, v_dot };
        Self::build_from(SceneFile { initial, span, ..self.file.clone() }, Some(start))
    }

    /// The travelling wave of the scene, without its perturbation.
    ///
    /// # Errors
    /// A scene that is not a travelling wave.
    pub fn wave(&self) -> Result<&TravellingWave> {
        match &self.theory {
            Some(Theory::Wave(wave)) => Ok(wave),
            Some(Theory::PerturbedWave(perturbed)) => Ok(perturbed.wave()),
            _ => Err(Error::parameter("scene", self.name(), NO_WAVE)),
        }
    }

    /// Short name.
    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// Its name and, if it has one, its summary.
    pub(crate) fn title(&self) -> String {
        let SceneFile { name, summary, .. } = &self.file;
        if summary.is_empty() { name.clone() } else { format!("{name}: {summary}") }
    }

    /// The scene file, with changes and defaults in place.
    pub fn file(&self) -> &SceneFile {
        &self.file
    }

    /// The chain.
    pub fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    /// The unit of each dimensionless quantity in SI units, if the scene has `[units]`.
    pub fn units(&self) -> Option<&Units> {
        self.units.as_ref()
    }

    /// The details of the chain besides its three parameters, in words, if it has any, in the units
    /// of the file.
    pub fn details_in_words(&self) -> Option<String> {
        details::words(&self.chain, self.units.as_ref())
    }

    /// The initial state.
    pub fn initial(&self) -> &State<f64> {
        &self.initial
    }

    /// The energy of the initial state, if it has one.
    pub(crate) fn initial_energy(&self) -> Option<Energy<f64>> {
        let (chain, y) = (&self.chain, self.initial.as_slice());
        chain.has_energy(y).then(|| chain.energy(y))
    }

    /// The theory to compare with, if there is one.
    pub fn theory(&self) -> Option<&Theory> {
        self.theory.as_ref()
    }

    /// The exact solution, if there is one: for the kind `trivial-breather`, and for states that
    /// belong to such a solution.
    pub fn exact(&self) -> Option<&TrivialBreather> {
        match &self.theory {
            Some(Theory::Breather(breather)) => Some(breather),
            _ => None,
        }
    }

    /// The unit of "steps per period".
    ///
    /// It is `2 pi/omega_tw` for waves, `T_b` for bright breathers, `2 pi/omega` with resonators
    /// (`2 pi/sqrt(kappa)` for the cradle), and otherwise the `period` of the file.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Whether the scene has a period: of a theory, of its resonators, or one that its file names.
    pub fn has_period(&self) -> bool {
        let frequency = self.chain.params().resonators() != Resonators::None && self.chain.details().is_none();
        self.theory.is_some() || frequency || self.file.span.period.is_some()
    }

    /// Period of the fastest motion, see [`Run::fast_period`]: the unit of steps that nobody gives,
    /// and of ladders of steps.
    pub fn fast_period(&self) -> f64 {
        self.run().fast_period()
    }

    /// The start of the time span: 0, but for [parts](Self::part) of a run.
    pub fn start_time(&self) -> f64 {
        self.start.unwrap_or(0.0)
    }

    /// The end of the time span; dimensionless, as all that a scene builds.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// The length of the time span.
    pub(crate) fn length(&self) -> f64 {
        self.end - self.start_time()
    }

    /// Number of equally spaced times at which energy and strains are kept; 0: the end only.
    pub fn samples(&self) -> usize {
        self.file.record.samples.unwrap_or(0)
    }

    /// What `[record]` selects to be kept in time; none if all is kept.
    pub fn selection(&self) -> Option<&Selection> {
        self.selection.as_ref()
    }

    /// The amplitude that errors are divided by, if theory gives one: `2 epsilon kappa a` for
    /// waves, `2 epsilon |a_0|` for bright breathers.
    pub fn amplitude(&self) -> Option<f64> {
        match &self.theory {
            Some(Theory::Wave(wave)) => Some(wave.amplitude()),
            Some(Theory::PerturbedWave(perturbed)) => Some(perturbed.wave().amplitude()),
            Some(Theory::Bright(breather)) => Some(breather.site(breather.origin(), 0.0).u.abs()),
            _ => None,
        }
    }

    /// The strains of a state, see [`Chain::strains`].
    pub fn strains(&self, y: &[f64]) -> Vec<f64> {
        self.chain.strains(y)
    }

    /// The scene as a run, with the method that the scene names, or else the one that suits its
    /// chain.
    pub fn run(&self) -> Run {
        self.checked_run().expect("a scene is checked when it is built")
    }

    /// The same run, which keeps `records` and looks for the largest values of what `[record]`
    /// names.
    ///
    /// # Errors
    /// Records that do not fit into the memory.
    pub fn observed_run(&self, records: Records) -> Result<Run> {
        let run = self.run().records(records);
        let kept = self.selection.as_ref().map_or(0, Selection::width) * size_of::<f64>() * self.samples();
        let needed = Self::least_memory(&self.chain) + run.record_bytes() + kept as u64;
        fits("samples", self.samples(), needed, "what a run keeps fits into the memory")?;
        let Some(selection) = self.selection.clone() else { return Ok(run) };
        let chain = self.chain.clone();
        let places = selection.quantities.iter().map(|one| selection.places(*one).len()).enumerate();
        let kinds: Vec<usize> = places.flat_map(|(kind, count)| std::iter::repeat_n(kind, count)).collect();
        Ok(run.observables(Observables::new(move |y, to| selection.take(&chain, y, to)).of_kinds(kinds)))
    }

    /// Method and setting, if the scene names a method.
    pub fn choice(&self) -> Option<(Method, Setting)> {
        self.file.method.as_ref()?;
        self.run().choice().ok()
    }

    fn checked_run(&self) -> Result<Run> {
        let run = Run::new(self.chain.clone(), self.initial.clone()).with_period(self.period);
        let run = run.until(self.end)?.starting_at(self.start_time())?.samples(self.samples())?;
        match &self.method {
            Some(method) => method.of(run),
            None => Ok(run),
        }
    }

    /// In words: what is evaluated and what is left out where the scene has an [exact](Self::exact)
    /// solution and no integrator is asked for.
    pub fn plan_in_closed_form(&self) -> Vec<String> {
        vec![
            self.plan_of_sites(),
            "closed form (uncpl): evaluated at each time that is asked for, exact at all; no integrator, no steps".to_owned(),
            "contact force: none to compute, beads never press each other (constraint2); a contact log is empty".to_owned(),
            "energy: conserved, checked along the run".to_owned(),
            self.plan_of_span(),
            self.plan_of_records(),
            "left out: integrator, contact force, search for contacts, tangent map, dense output; --integrator integrates all the same".to_owned(),
        ]
    }

    fn plan_of_span(&self) -> String {
        let [end, period] = [self.end, self.period].map(|t| self.in_words(t));
        format!("t from 0 to {end}, period {period}")
    }

    fn plan_of_records(&self) -> String {
        match self.samples() {
            0 => "records: the end only; nothing is allocated per step".to_owned(),
            samples => match self.selection.as_ref().map(Selection::width) {
                Some(width) => format!("records: energy and what `record` names, {width} numbers, at {samples} times"),
                None => {
                    format!(
                        "records: energy and strains at {samples} times; strains only when an output folder is given"
                    )
                }
            },
        }
    }

    fn plan_of_sites(&self) -> String {
        let (params, n, dim) = (self.chain.params(), self.chain.sites(), self.chain.layout().dim());
        if let Some(words) = self.details_in_words() {
            let each = if self.chain.layout().resonators() { 4 } else { 2 };
            let ledger = if self.chain.open() { ", with the work of dampers and drives" } else { "" };
            return format!("{n} beads that differ ({words}): {each} numbers a site{ledger}, {dim} in all");
        }
        let why = match params.resonators() {
            Resonators::Moving => return format!("{n} beads with resonators: 4 numbers a site, {dim} in all"),
            Resonators::Fixed => "rho = inf: resonators",
            Resonators::None if params.rho == 0.0 => "rho = 0: resonators",
            Resonators::None => "kappa = 0: nothing ties the resonators,",
        };
        format!("{n} beads; {why} left out, 2 numbers a site, {dim} in all")
    }

    /// In words, one line each: what an integrator does and what is left out. `events`: whether
    /// contacts are logged.
    pub fn plan(&self, events: bool) -> Vec<String> {
        let law = match self.chain.params().alpha {
            _ if self.chain.details().is_some() => "contact force bond by bond, each with its own law",
            1.5 => "contact force as g sqrt(g), vectorised",
            a if a.fract() == 0.0 && a <= 3.0 => "contact force by multiplications, vectorised",
            a if a.fract() == 0.0 && a <= 64.0 => "contact force by multiplications",
            a if a.fract() == 0.5 && a <= 64.0 => "contact force by multiplications and a square root",
            _ => "contact force by powf: slower than a half-integer alpha",
        };
        let energy = match (self.initial_energy(), self.chain.open()) {
            (Some(_), true) => "energy: energy + dissipated - driven is conserved, checked along the run",
            (Some(_), false) => "energy: conserved, checked along the run",
            (None, _) => "energy: none on this strain ring (sum x != sum y); the size of the state is checked instead",
        };
        let wave = |wave: &TravellingWave| {
            format!("ansatz: travelling wave, epsilon = {}, omega_tw = {}", wave.epsilon(), wave.omega_tw())
        };
        let theory = self.theory.as_ref().map(|theory| match theory {
            Theory::Wave(own) => wave(own),
            Theory::PerturbedWave(own) => {
                let (zeta, seed) = (own.zeta(), own.seed());
                wave(own.wave())
                    + &format!(", perturbed by zeta = {zeta}, seed {seed}; the command `wave` compares them")
            }
            Theory::Breather(_) => {
                "exact solution (uncpl): the reference of `compare`; `run` without an integrator evaluates it".into()
            }
            Theory::Bright(own) => {
                let (omega, horizon) = (own.omega_b(), own.horizon());
                let command = "the command `breather bright` compares them";
                format!("ansatz: bright breather, Omega_b = {omega}, horizon {horizon}; {command}")
            }
        });
        let logged = "contacts: logged; collocation knows them, for any other method every step is sampled eight times and searched";
        let left = "left out: contact log, tangent map, dense output (made only where a sample asks for it)";
        let [contacts, left] = match events {
            true => [logged, "left out: tangent map"],
            false => ["contacts: not logged; --events does", left],
        };
        let first = [self.plan_of_sites(), law.to_owned(), energy.to_owned()].into_iter().chain(theory);
        first.chain([self.plan_of_span(), self.plan_of_records(), contacts.to_owned(), left.to_owned()]).collect()
    }
}

/// Refuses a value for which so many bytes of memory are needed, if there are fewer.
fn fits(name: &'static str, value: usize, needed: u64, rule: &'static str) -> Result<()> {
    // Little is not worth a look at the files of the system.
    let lacks = (needed > NEGLIGIBLE).then(|| lacking(needed)).flatten();
    refuse(name, lacks.map(|words| format!("{value}, which need {words},")), rule)
}
