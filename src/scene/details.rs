//! The tables `[beads]`, `[bonds]` and `[[drive]]` of a scene, and the details of a chain that they
//! and `[units]` give.

use super::{
    Quantity,
    values::{Numbers, Values},
};
use crate::{
    chain::{
        Boundary, Chain, Course, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Params, Signal,
        Spline, Table, Term,
    },
    error::{EQUAL_BEADS, Error, GIVEN, NOTHING, Result, beside, one_line, refuse, require},
    number::format_short,
    output::read,
    random::uniform,
    report::Units,
};
use serde::{Deserialize, Serialize};
use std::{f64::consts::PI, path::Path, sync::Arc};

/// Longest file of a drive in bytes.
const MOST_BYTES: u64 = 1 << 28;
/// Number of harmonics in band-limited noise.
const NOISE: usize = 64;

sections! {
    /// The section `[beads]`: one number for each site.
    #[derive(Default)]
    pub struct BeadsSection {
        /// Masses (1, or those of the spheres of `[units]`, if left out).
        mass?: Values => "masses" Mass,
        /// Spring constants (`chain.kappa` if left out).
        kappa?: Values as Stiffness => "spring constants" Stiffness,
        /// Mass ratios resonator to bead (`chain.rho` if left out).
        rho?: Values => "mass ratios" Number,
        /// Springs that tie beads to their places at rest, force `-onsite u` (none if left out).
        onsite?: Values as Stiffness => "on-site springs" Stiffness,
        /// Masses of resonators, in place of their ratios.
        resonator?: Values as Mass,
        /// Drag on beads, `-drag u'` (none if left out).
        drag?: Values as Damping => "drag" Damping,
        /// Damping times, in place of drag: `-mass u'/tau`; `inf` for no drag.
        tau?: Values as Time,
        /// Dashpots beside the springs of resonators, `-dashpot (u' - v')` (none if left out).
        dashpot?: Values as Damping => "dashpots" Damping,
    }

    /// The section `[bonds]`: one number for each bond that can touch, from left to right.
    #[derive(Default)]
    pub struct BondsSection {
        /// Contact constants (1, or those of Hertz for the spheres of `[units]`, if left out); 0:
        /// no contact.
        contact?: Values,
        /// Contact constant of walls (that of `contact` if left out).
        wall?: f64,
        /// Exponents (`chain.alpha` if left out).
        alpha?: Values => "exponents" Number,
        /// Further powers of the overlap in the forces of contacts (none if left out).
        terms?: Vec<TermSection>,
        /// Overlaps and forces of contacts in place of the first power, which the constants
        /// multiply (none if left out).
        table?: TableSection,
        /// Static overlaps (`chain.precompression` if left out); negative: beads apart.
        overlap?: Values as Length => "static overlaps" Length,
        /// Constants of linear springs between beads, relaxed at the static overlap (none if left
        /// out).
        spring?: Values as Stiffness => "springs between beads" Stiffness,
        /// Forces at rest of magnets on two beads that repel (none if left out).
        magnet?: Values as Force => "magnets with forces" Force,
        /// Distances of these magnets at rest.
        distance?: Values as Length => "" Length,
        /// Power of the distance with which the force of magnets decays.
        decay?: f64,
        /// Dissipation constants of viscoelastic contacts, in units of time.
        viscoelastic?: Values as Time,
        /// Dashpot constants of contacts, force over velocity.
        dashpot?: Values as Damping,
        /// Power of the overlap in the resistance of dashpots, whose constants then are a force
        /// over a velocity and a length to this power (0 if left out).
        beta?: f64,
        /// Power of the rate in the force of dashpots, at least 1, whose constants then are a force
        /// over a velocity to this power and a length to the power `beta` (1 if left out).
        rate_power?: f64,
        /// Constants of contacts by the law of Hunt and Crossley, time over length.
        hunt_crossley?: Values as Slowness,
        /// Whether contacts that dissipate may pull while beads overlap (`false` if left out).
        pull?: bool,
    }

    /// One entry of `terms` in `[bonds]`.
    pub struct TermSection {
        /// Constants, as those of contacts.
        contact: Values,
        /// The exponent.
        alpha: f64,
    }

    /// The key `table` of `[bonds]`.
    pub struct TableSection {
        /// Overlaps of the rows, from 0 on.
        overlap: Vec<f64> as Length,
        /// Their forces.
        force: Vec<f64> as Force,
    }

    /// One entry of `[[drive]]`.
    pub struct DriveSection {
        /// The bead, counted from 0, or a wall.
        site: DriveSite,
        /// Whether the signal is its displacement or a force on it.
        kind: DriveKind,
        /// Amplitudes, one a harmonic; the root mean square of noise; without frequencies, a
        /// constant.
        amplitude?: Values,
        /// Angular frequencies, one a harmonic.
        omega?: Values as Omega,
        /// Frequencies in hertz, in place of `omega`; only with `[units]`. A scene that is built
        /// has the numbers in `omega` instead.
        frequency?: Values as Frequency,
        /// Last angular frequency of a chirp, which rises or falls linearly from `omega` over
        /// `length`.
        omega_end?: f64 as Omega,
        /// Phases, one a harmonic, in radians (0 if left out).
        phase?: Values,
        /// Noise: the least and the largest angular frequency, in place of `omega` and `phase`.
        band?: [f64; 2] as Omega,
        /// Seed of noise (1 if left out).
        seed?: u64,
        /// Velocity of a bead that is moved steadily, in place of `amplitude`.
        velocity?: f64 as Velocity,
        /// File with lines `time, value`, in place of `amplitude`; relative to the file of the
        /// scene. A scene that is read has the numbers in `times` and `values` instead.
        file?: String,
        /// Times of the values of a signal, which increase.
        times?: Vec<f64> as Time,
        /// Values at these times, with a cubic spline between them.
        values?: Vec<f64>,
        /// Time in which the signal rises to its full amplitude (no ramp if left out).
        ramp?: f64 as Time,
        /// Start of a burst, or of the change of a chirp (0 if left out).
        start?: f64 as Time,
        /// Length of a burst, or of the change of a chirp.
        length?: f64 as Time,
        /// Shape of a burst (`"smooth"` if left out).
        shape?: Shape,
    }
}

/// What a drive moves or pushes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a site, counted from 0, \"left-wall\" or \"right-wall\"")]
pub enum DriveSite {
    /// A bead.
    Bead(usize),
    /// The bead at an end, which stands for this wall.
    Wall(Boundary),
}

/// The shape of a burst, `x = (t - start)/length`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// `(4 x (1 - x))^4`.
    Smooth,
    /// `sin(pi x)`.
    HalfSine,
}

/// The tables of a scene from which the details of its chain are built.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tables<'a> {
    pub(super) beads: Option<&'a BeadsSection>,
    pub(super) bonds: Option<&'a BondsSection>,
    pub(super) drives: &'a [DriveSection],
    pub(super) gravity: f64,
}

impl Tables<'_> {
    /// Whether there is nothing in them.
    pub(super) fn none(&self) -> bool {
        self.beads.is_none() && self.bonds.is_none() && self.drives.is_empty() && self.gravity == 0.0
    }

    /// The chain with its details; unchanged without tables.
    ///
    /// # Errors
    /// A value outside its rule.
    pub(super) fn apply(self, chain: Chain<f64>) -> Result<Chain<f64>> {
        if self.none() {
            return Ok(chain);
        }
        let built = self.details(&chain).and_then(|details| {
            let uniform = equal(&chain, &details);
            Ok(uniform.unwrap_or(chain.with(&details)?))
        });
        built.map_err(|error| self.named(error))
    }

    fn details(self, chain: &Chain<f64>) -> Result<Details> {
        let Self { beads, bonds, drives, gravity } = self;
        if chain.topology().strains() {
            let first = |name: &str, table: Option<toml::Table>| Some(format!("{name}.{}", table?.keys().next()?));
            let of_beads = first("beads", beads.and_then(|beads| toml::Table::try_from(beads).ok()));
            let key = of_beads.or_else(|| first("bonds", bonds.and_then(|bonds| toml::Table::try_from(bonds).ok())));
            let key = key.unwrap_or(if drives.is_empty() { "chain.gravity" } else { "drive" }.to_owned());
            return Err(Error::parameter(key.leak(), GIVEN, EQUAL_BEADS));
        }
        let touching = chain.touching().len();
        let mut details = Details { gravity, ..Details::default() };
        if let Some(beads) = beads {
            beads.apply(chain, &mut details)?;
        }
        if let Some(bonds) = bonds {
            bonds.apply(chain, touching, &mut details)?;
        }
        let open = chain.boundary().walls() != [true; 2] && !chain.topology().ring();
        if open && gravity == 0.0 && drives.is_empty() && details.overlap.iter().any(|overlap| *overlap > 0.0) {
            let rule = "only two walls, a ring, or beads that are pushed or moved hold a static overlap; else the chain flies apart";
            let value = format!("positive, boundary = \"{}\"", chain.boundary());
            return Err(Error::parameter("bonds.overlap", value, rule));
        }
        details.drives = drives.iter().map(|drive| drive.build(chain)).collect::<Result<_>>()?;
        Ok(details)
    }

    /// An error of a chain with its parameter named by the key of the scene.
    fn named(self, error: Error) -> Error {
        let Error::Parameter { name, value, rule } = error else { return error };
        let key = name.split('.').next().unwrap_or(name);
        let given = |table: Option<toml::Table>| table.is_some_and(|table| table.contains_key(key));
        let bonds = || given(self.bonds.and_then(|bonds| toml::Table::try_from(bonds).ok()));
        // Those of the chain also stand in its own table.
        let other = !["alpha", "kappa", "rho"].contains(&key);
        let name = match key {
            "dissipation" => self.bonds.and_then(|bonds| bonds.losses().next()).map_or(name, |(key, ..)| key),
            _ if given(self.beads.and_then(|beads| toml::Table::try_from(beads).ok())) => {
                format!("beads.{name}").leak()
            }
            _ if BondsSection::KEYS.contains(&key) && (other || bonds()) => format!("bonds.{name}").leak(),
            _ => name,
        };
        Error::Parameter { name, value, rule }
    }
}

/// The numbers of a key; none if it is left out.
fn list(name: &'static str, values: &Option<Values>, count: usize) -> Result<Vec<f64>> {
    values.as_ref().map_or(Ok(Vec::new()), |values| values.of(name, count))
}

/// The chain of equal beads that has these details, if its beads and bonds are equal and there is
/// nothing else.
fn equal(chain: &Chain<f64>, details: &Details) -> Option<Chain<f64>> {
    let all = |list: &[f64], otherwise: f64| {
        let first = list.first().copied().unwrap_or(otherwise);
        list.iter().all(|x| *x == first).then_some(first)
    };
    let ones = all(&details.mass, 1.0)? == 1.0 && all(&details.contact, 1.0)? == 1.0;
    let mut more = details.clone();
    [&mut more.mass, &mut more.kappa, &mut more.rho, &mut more.contact, &mut more.alpha, &mut more.overlap]
        .into_iter()
        .for_each(Vec::clear);
    let Params { alpha, kappa, rho } = chain.params();
    let params = Params::new(all(&details.alpha, alpha)?, all(&details.kappa, kappa)?, all(&details.rho, rho)?).ok()?;
    let rest = all(&details.overlap, chain.precompression())?;
    let uniform = || Chain::new(params, chain.boundary(), chain.sites()).ok()?.precompressed(rest).ok();
    (ones && more == Details::default()).then(uniform)?
}

impl BeadsSection {
    fn apply(&self, chain: &Chain<f64>, details: &mut Details) -> Result<()> {
        let rho = self.rho.is_some() || chain.params().rho != 0.0;
        for (name, given, other, is_given, rule) in [
            ("beads.resonator", &self.resonator, "rho", rho, "masses of resonators are in place of `rho`"),
            ("beads.tau", &self.tau, "drag", self.drag.is_some(), "damping times are in place of `drag`"),
        ] {
            require(given.is_none() || !is_given, name, beside(other), rule)?;
        }
        self.set(details, chain.sites())?;
        let mass = |i: usize| details.mass.get(i).copied().unwrap_or(1.0);
        let of = |name, values: &Option<Values>, good: fn(f64) -> bool, rule, of: fn(f64, f64) -> f64| {
            let values = list(name, values, chain.sites())?;
            refuse(name, values.iter().find(|value| !good(**value)), rule)?;
            Result::Ok(values.iter().enumerate().map(|(i, value)| of(*value, mass(i))).collect())
        };
        if self.resonator.is_some() {
            let rule = "the mass of a resonator is in [0, inf]";
            details.rho = of("beads.resonator", &self.resonator, |x| x >= 0.0, rule, |value, mass| value / mass)?;
        }
        if self.tau.is_some() {
            let rule = "a damping time is positive; inf for no drag";
            details.drag = of("beads.tau", &self.tau, |x| x > 0.0, rule, |value, mass| mass / value)?;
        }
        Ok(())
    }
}

impl BondsSection {
    fn apply(&self, chain: &Chain<f64>, touching: usize, details: &mut Details) -> Result<()> {
        self.set(details, touching)?;
        details.contact = list("bonds.contact", &self.contact, touching)?;
        for TermSection { contact, alpha } in self.terms.iter().flatten() {
            details.terms.push(Term { contact: contact.of("bonds.terms.contact", touching)?, alpha: *alpha });
        }
        if let Some(TableSection { overlap, force }) = &self.table {
            details.table = Some(Arc::new(Table::new(overlap.clone(), force.clone())?));
        }
        details.decay = self.decay.unwrap_or(0.0);
        let whole = self.magnet.is_some() || self.distance.is_none() && self.decay.is_none();
        let rule = "`distance` and `decay` are those of magnets: give their force at rest";
        require(whole, "bonds.magnet", NOTHING, rule)?;
        if self.wall.is_some() {
            details.contact.resize(touching, 1.0);
            self.walls(chain.boundary(), &mut details.contact)?;
        }
        let mut losses = self.losses();
        if let Some((key, kind, values)) = losses.next() {
            let rule = "contacts dissipate by one law: `viscoelastic`, `dashpot` or `hunt_crossley`";
            refuse(key, losses.next().map(|(_, other, _)| beside(other.name())), rule)?;
            details.dissipation = Some(Dissipation { kind, strength: values.of(key, touching)? });
        }
        (details.beta, details.pull) = (self.beta.unwrap_or(0.0), self.pull == Some(true));
        details.rate_power = self.rate_power;
        for (name, power) in [("bonds.beta", self.beta), ("bonds.rate_power", self.rate_power)] {
            let rule = "it is a power in the force of `dashpot`, which is not given";
            require(power.is_none() || self.dashpot.is_some(), name, power.unwrap_or(0.0), rule)?;
        }
        let rule =
            "what may pull is a contact that dissipates: `dashpot`, `viscoelastic` or `hunt_crossley` is not given";
        require(!details.pull || details.dissipation.is_some(), "bonds.pull", true, rule)
    }

    /// Sets the contact constants of walls, if they have their own.
    pub(super) fn walls(&self, boundary: Boundary, contact: &mut [f64]) -> Result<()> {
        match (self.wall, contact) {
            (Some(wall), _) if boundary.walls() == [false; 2] => {
                let rule = "only boundary = \"fixed\", \"left-wall\" and \"right-wall\" have walls";
                Err(Error::parameter("bonds.wall", wall, rule))
            }
            (Some(wall), contact) => {
                let [left, right] = boundary.walls();
                contact.first_mut().filter(|_| left).into_iter().for_each(|first| *first = wall);
                contact.last_mut().filter(|_| right).into_iter().for_each(|last| *last = wall);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The laws of dissipation that are given, with their keys and constants.
    fn losses(&self) -> impl Iterator<Item = (&'static str, Kind, &Values)> {
        let all = [
            ("bonds.viscoelastic", Kind::Viscoelastic, &self.viscoelastic),
            ("bonds.dashpot", Kind::Dashpot, &self.dashpot),
            ("bonds.hunt_crossley", Kind::HuntCrossley, &self.hunt_crossley),
        ];
        all.into_iter().filter_map(|(key, kind, values)| values.as_ref().map(|values| (key, kind, values)))
    }
}

impl DriveSection {
    /// The quantity of its amplitudes.
    pub(super) fn quantity(&self) -> Quantity {
        match self.kind {
            DriveKind::Displacement => Quantity::Length,
            DriveKind::Force => Quantity::Force,
        }
    }

    /// The bead, and whether it stands for a wall.
    pub(super) fn place(&self, chain: &Chain<f64>) -> Result<(usize, bool)> {
        let wall = match self.site {
            DriveSite::Bead(site) => return Ok((site, false)),
            DriveSite::Wall(wall) => wall,
        };
        let [left, right] = [0, 1].map(|k| wall.walls()[k] && !chain.boundary().walls()[k]);
        let good = left != right && wall != Boundary::Fixed && !chain.topology().ring();
        let rule =
            "a wall that is moved is the bead at this end, counted in `sites`: without another one in `boundary`";
        require(good && self.kind == DriveKind::Displacement, "drive.site", wall, rule)?;
        Ok((if left { 0 } else { chain.sites() - 1 }, true))
    }

    /// Replaces frequencies in hertz by angular ones.
    pub(super) fn in_hertz(&mut self, units: bool) -> Result<()> {
        let Some(frequency) = self.frequency.take() else { return Ok(()) };
        require(self.omega.is_none(), "drive.frequency", beside("omega"), "it is in place of `omega`")?;
        require(units, "drive.frequency", GIVEN, "in hertz, and only with [units]: else give `omega`")?;
        let mut omega = frequency;
        omega.each(&mut |x| *x *= 2.0 * PI);
        self.omega = Some(omega);
        Ok(())
    }

    fn build(&self, chain: &Chain<f64>) -> Result<Drive> {
        let course = self.course()?;
        let harmonics = if course.is_some() { Vec::new() } else { self.harmonics()? };
        let burst = self.length.filter(|_| self.omega_end.is_none());
        let (start, shape) = (self.start.is_none() || self.length.is_some(), self.shape.is_none() || burst.is_some());
        require(start, "drive.start", GIVEN, "`start` belongs to a burst with a `length`")?;
        require(shape, "drive.shape", GIVEN, "`shape` belongs to a burst with a `length`")?;
        let envelope = match (self.ramp, burst) {
            (None, None) => Envelope::None,
            (Some(ramp), None) => Envelope::Ramp(ramp),
            (None, Some(length)) => {
                let start = self.start.unwrap_or(0.0);
                match self.shape {
                    Some(Shape::HalfSine) => Envelope::HalfSine { start, length },
                    Some(Shape::Smooth) | None => Envelope::Burst { start, length },
                }
            }
            (Some(ramp), Some(_)) => {
                return Err(Error::parameter("drive.ramp", ramp, "a burst has no ramp: `ramp` or `length`"));
            }
        };
        Ok(Drive { site: self.place(chain)?.0, kind: self.kind, signal: Signal { harmonics, course, envelope } })
    }

    /// The function that is no sum of harmonics: a steady motion, a chirp, or values at times.
    fn course(&self) -> Result<Option<Course>> {
        require(self.file.is_none(), "drive.file", GIVEN, "a scene in memory has `times` and `values`")?;
        let [tabulated, steady] = [self.times.is_some() || self.values.is_some(), self.velocity.is_some()];
        let harmonic = self.amplitude.is_some() || self.omega.is_some() || self.phase.is_some();
        let harmonic = harmonic || self.omega_end.is_some() || self.band.is_some() || self.seed.is_some();
        let ways = [tabulated, steady, harmonic].into_iter().filter(|given| *given).count();
        let rule = "a drive has one of `velocity`, `file` (or `times` and `values`), and `amplitude` with its keys";
        require(ways <= 1, "drive", "[[drive]]", rule)?;
        if tabulated {
            let list = |list: &Option<Vec<f64>>| list.clone().unwrap_or_default();
            return Ok(Some(Course::Table(Arc::new(Spline::new(list(&self.times), list(&self.values))?))));
        }
        if let Some(velocity) = self.velocity {
            return Ok(Some(Course::Steady { velocity }));
        }
        let Some(last) = self.omega_end else { return Ok(None) };
        let Some(length) = self.length else {
            return Err(Error::parameter("drive.omega_end", last, "a chirp changes its frequency over a `length`"));
        };
        let harmonics = if self.omega.is_some() { self.harmonics()? } else { Vec::new() };
        let &[Harmonic { amplitude, omega, phase }] = &harmonics[..] else {
            return Err(Error::parameter("drive.omega_end", last, "a chirp has one `amplitude` and one `omega`"));
        };
        Ok(Some(Course::Chirp { amplitude, omega: [omega, last], phase, start: self.start.unwrap_or(0.0), length }))
    }

    /// Replaces the file of the drive, in a folder unless its path is absolute, by its numbers.
    ///
    /// # Errors
    /// The file and the line of a number that is not finite, of times that do not increase, of
    /// another number of columns than two; fewer than two lines.
    pub(super) fn read(&mut self, folder: &Path) -> Result<()> {
        let Some(file) = self.file.take() else { return Ok(()) };
        let rule = "numbers are in a file, or in `times` and `values`";
        require(self.times.is_none() && self.values.is_none(), "drive.file", &file, rule)?;
        let path = folder.join(file);
        let text = String::from_utf8_lossy(&read(&path, MOST_BYTES)?).into_owned();
        let (mut times, mut values) = (Vec::new(), Vec::new());
        let refused =
            |line: usize, rule: String| Err(Error::Content { path: path.clone(), place: format!("line {line}"), rule });
        for (line, text) in text.lines().enumerate() {
            let text = text.split('#').next().unwrap_or_default().trim();
            let fields: Vec<&str> = text.split([',', ';', '\t', ' ']).filter(|field| !field.is_empty()).collect();
            let numbers: Vec<f64> = fields.iter().filter_map(|field| field.parse().ok()).collect();
            match (&numbers[..], fields.len()) {
                (_, 0) => {}
                // Names of the columns.
                ([], 2) if times.is_empty() => {}
                (&[t, value], 2) if t.is_finite() && value.is_finite() => {
                    if let Some(last) = times.last().filter(|&&last| t <= last) {
                        return refused(line + 1, format!("time {t} after {last}: times increase from line to line"));
                    }
                    times.push(t);
                    values.push(value);
                }
                // Numbers are in the units of the scene, whatever a name says.
                ([], _) if times.is_empty() => {
                    let rule = "names of the columns are two words, without units: numbers are in those of the scene";
                    return refused(line + 1, format!("`{}`: {rule}", one_line(text)));
                }
                _ => {
                    let rule = "a line is a time and a value, both finite";
                    return refused(line + 1, format!("`{}`: {rule}", one_line(text)));
                }
            }
        }
        if times.len() < 2 {
            return refused(text.lines().count().max(1), "at least two lines with a time and a value".to_owned());
        }
        (self.times, self.values) = (Some(times), Some(values));
        Ok(())
    }

    fn harmonics(&self) -> Result<Vec<Harmonic>> {
        let Some(amplitude) = &self.amplitude else {
            let rule = "a drive has an `amplitude`, a `velocity`, or a `file`";
            return Err(Error::parameter("drive.amplitude", NOTHING, rule));
        };
        let amplitudes = amplitude.list("drive.amplitude")?;
        if let Some([low, high]) = self.band {
            return self.noise(&amplitudes, low, high);
        }
        refuse("drive.seed", self.seed, "a seed belongs to noise with a `band`")?;
        let Some(omega) = &self.omega else {
            require(self.phase.is_none(), "drive.phase", GIVEN, "a phase belongs to an `omega`")?;
            return Ok(amplitudes.into_iter().flat_map(|value| Signal::constant(value).harmonics).collect());
        };
        let omegas = omega.list("drive.omega")?;
        let phases = match &self.phase {
            Some(phase) => phase.list("drive.phase")?,
            None => vec![0.0; omegas.len()],
        };
        let each = amplitudes.len() == omegas.len() && phases.len() == omegas.len();
        let value = format!("{} for {} frequencies", amplitudes.len().max(phases.len()), omegas.len());
        require(each, "drive.amplitude", value, "one amplitude and one phase a frequency")?;
        let of = |k: usize| Harmonic { amplitude: amplitudes[k], omega: omegas[k], phase: phases[k] };
        Ok((0..omegas.len()).map(of).collect())
    }

    /// Harmonics of equal amplitude: one in each of equal parts of the band, at a frequency and a
    /// phase drawn from the seed.
    fn noise(&self, amplitudes: &[f64], low: f64, high: f64) -> Result<Vec<Harmonic>> {
        let &[amplitude] = amplitudes else {
            return Err(Error::parameter("drive.amplitude", "a list", "noise has one amplitude"));
        };
        let rule = "noise has a `band` only";
        require(self.omega.is_none() && self.phase.is_none(), "drive.band", beside("omega or phase"), rule)?;
        let rule = "a band is from its least to its largest frequency, at least zero";
        let good = 0.0 <= low && low < high && high.is_finite();
        require(good, "drive.band", format!("[{low}, {high}]"), rule)?;
        let mut draw = uniform(self.seed.unwrap_or(1));
        let (part, each) = ((high - low) / NOISE as f64, amplitude * (2.0 / NOISE as f64).sqrt());
        Ok((0..NOISE)
            .map(|k| {
                let omega = low + part * (k as f64 + 0.5 * (1.0 + draw()));
                Harmonic { amplitude: each, omega, phase: PI * draw() }
            })
            .collect())
    }
}

/// Refuses drives that have not come to their full height, or to their end, by the end of a scene.
pub(super) fn within(chain: &Chain<f64>, end: f64, whole: bool) -> Result<()> {
    for drive in chain.details().iter().flat_map(|details| &details.drives) {
        if let Some(Course::Table(spline)) = &drive.signal.course {
            let [first, last] = [spline.times()[0], spline.times()[spline.times().len() - 1]];
            let covered = first <= 0.0 && last >= end * (1.0 - 1e-12);
            let value = format!("from {first} to {last}");
            require(covered, "drive.times", value, "the times of a drive cover the run")?;
        }
        if whole && drive.signal.settled() > end {
            let name = match drive.signal.envelope {
                Envelope::Burst { .. } | Envelope::HalfSine { .. } => "drive.length",
                _ => "drive.ramp",
            };
            let rule = "a drive comes to its full height, or to its end, within the scene";
            return Err(Error::parameter(name, format!("until t = {}", drive.signal.settled()), rule));
        }
    }
    Ok(())
}

/// The details of a chain besides its parameters, in words, in SI units if there are units; `None`
/// if it has none.
pub(super) fn words(chain: &Chain<f64>, units: Option<&Units>) -> Option<String> {
    let details = chain.details()?;
    let told = |of: Quantity, x: f64| match units {
        Some(units) => format!("{} {}", format_short(units.to_si(of, x)), of.unit()).trim_end().to_owned(),
        None => format_short(x),
    };
    let between = |name: &str, list: &[f64], told: &dyn Fn(f64) -> String| {
        let (low, high) = crate::numerics::extremes(list.iter().copied());
        match list {
            [] => None,
            _ if low == high => Some(format!("{name} {}", told(low))),
            _ => Some(format!("{name} from {} to {}", told(low), told(high))),
        }
    };
    let range = |name: &str, list: &[f64], of: Quantity| between(name, list, &|x| told(of, x));
    let alpha = |k: usize| details.alpha.get(k).copied().unwrap_or(chain.params().alpha);
    let unit = |alpha: f64| units.map_or(1.0, |units| units.force_n / units.length_m.powf(alpha));
    let constant = |x: f64| format_short(x) + units.map_or("", |_| " N/m^α");
    let contact: Vec<f64> = details.contact.iter().enumerate().map(|(k, x)| x * unit(alpha(k))).collect();
    let contacts = match &details.table {
        None => between("contact constants", &contact, &constant),
        Some(table) => Some(format!(
            "forces of {} rows up to the overlap {}{}",
            table.overlap().len(),
            told(Quantity::Length, table.end()),
            range(", times", &details.contact, Quantity::Number).unwrap_or_default(),
        )),
    };
    let lists = details.lists().concat();
    let row = |(key, of, words): &(&str, Quantity, &str)| {
        range(words, lists.iter().find(|(name, _)| name == key)?.1, *of).filter(|_| !words.is_empty())
    };
    let (damping, beads): (Vec<_>, Vec<_>) = BeadsSection::LISTS.iter().partition(|row| row.1 == Quantity::Damping);
    let rows = beads.into_iter().filter_map(row).chain(contacts).chain(BondsSection::LISTS.iter().filter_map(row));
    let mut all: Vec<String> = rows.chain(damping.into_iter().filter_map(row)).collect();
    all.extend(details.terms.iter().filter_map(|Term { contact, alpha }| {
        let contact: Vec<f64> = contact.iter().map(|x| x * unit(*alpha)).collect();
        let words = between("terms with contact constants", &contact, &constant)?;
        Some(format!("{words} and exponent {}", format_short(*alpha)))
    }));
    if let Some(Dissipation { kind, strength }) = &details.dissipation {
        let of = match kind {
            Kind::Viscoelastic => Quantity::Time,
            Kind::Dashpot => Quantity::Damping,
            Kind::HuntCrossley => Quantity::Slowness,
        };
        let power = details.rate_power.unwrap_or(1.0);
        let by = units.map_or(1.0, |units| units.powers(details.beta, power));
        let strength: Vec<f64> = strength.iter().map(|x| x / by).collect();
        all.extend(range(kind.words(), &strength, of));
        all.extend((details.beta != 0.0).then(|| match units {
            Some(_) => format!("beta {0}: N s/m times m^(-{0})", format_short(details.beta)),
            None => format!("beta {}", format_short(details.beta)),
        }));
        all.extend((power != 1.0).then(|| match units {
            Some(_) => format!("power {0} of the rate: times (m/s)^(1 - {0})", format_short(power)),
            None => format!("power {} of the rate", format_short(power)),
        }));
        all.extend(details.pull.then(|| "contacts may pull".to_owned()));
    }
    for drive in &details.drives {
        let how = if drive.kind == DriveKind::Displacement { "moved" } else { "pushed" };
        let by = match (&drive.signal.course, drive.signal.harmonics.len()) {
            (Some(Course::Steady { velocity }), _) => format!("with velocity {}", told(Quantity::Velocity, *velocity)),
            (Some(Course::Chirp { .. }), _) => "by a chirp".to_owned(),
            (Some(Course::Table(spline)), _) => format!("by {} values", spline.times().len()),
            (None, 1) => "by 1 harmonic".to_owned(),
            (None, count) => format!("by {count} harmonics"),
        };
        all.push(format!("bead {} {how} {by}", drive.site));
    }
    if details.gravity != 0.0 {
        all.push(format!("gravity {} along the chain", told(Quantity::Acceleration, details.gravity)));
    }
    Some(all.join(", "))
}
