//! The tables `[beads]`, `[bonds]` and `[[drive]]` of a scene, and the details of a chain that they
//! and `[units]` give.

use super::{Quantity, values::Values};
use crate::{
    chain::{Boundary, Chain, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Signal},
    error::{Error, Result, require},
    number::format_short,
    random::uniform,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Number of harmonics in band-limited noise.
const NOISE: usize = 64;

sections! {
    /// The section `[beads]`: one number for each site.
    #[derive(Default)]
    pub struct BeadsSection {
        /// Masses (1, or those of the spheres of `[units]`, if left out).
        mass?: Values,
        /// Spring constants (`chain.kappa` if left out).
        kappa?: Values as Stiffness,
        /// The same by another name.
        stiffness?: Values as Stiffness,
        /// Mass ratios resonator to bead (`chain.rho` if left out).
        rho?: Values,
        /// Masses of resonators, in place of their ratios.
        resonator?: Values as Mass,
        /// Drag on beads, `-drag u'` (none if left out).
        drag?: Values as Damping,
        /// Damping times, in place of drag: `-mass u'/tau`; `inf` for no drag.
        tau?: Values as Time,
        /// Dashpots beside the springs of resonators, `-dashpot (u' - v')` (none if left out).
        dashpot?: Values as Damping,
    }

    /// The section `[bonds]`: one number for each bond that can touch, from left to right.
    #[derive(Default)]
    pub struct BondsSection {
        /// Contact constants (1, or those of Hertz for the spheres of `[units]`, if left out); 0: no
        /// contact.
        contact?: Values,
        /// Contact constant of walls (that of `contact` if left out).
        wall?: f64,
        /// Exponents (`chain.alpha` if left out).
        alpha?: Values,
        /// Static overlaps (`chain.precompression` if left out); negative: beads apart.
        overlap?: Values as Length,
        /// Dissipation constants of viscoelastic contacts, in units of time.
        viscoelastic?: Values as Time,
        /// Dashpot constants of contacts, force over velocity.
        dashpot?: Values as Damping,
    }

    /// One entry of `[[drive]]`.
    pub struct DriveSection {
        /// The bead, counted from 0.
        site: usize,
        /// Whether the signal is its displacement or a force on it.
        kind: DriveKind,
        /// Amplitudes, one a harmonic; the root mean square of noise.
        amplitude: Values,
        /// Angular frequencies, one a harmonic.
        omega?: Values as Omega,
        /// Phases, one a harmonic, in radians (0 if left out).
        phase?: Values,
        /// Noise: the least and the largest angular frequency, in place of `omega` and `phase`.
        band?: [f64; 2] as Omega,
        /// Seed of noise (1 if left out).
        seed?: u64,
        /// Time in which the signal rises to its full amplitude (no ramp if left out).
        ramp?: f64 as Time,
        /// Start of a burst (0 if left out).
        start?: f64 as Time,
        /// Length of a burst.
        length?: f64 as Time,
    }
}

/// The tables of a scene from which the details of its chain are built.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tables<'a> {
    pub(super) beads: Option<&'a BeadsSection>,
    pub(super) bonds: Option<&'a BondsSection>,
    pub(super) drives: &'a [DriveSection],
}

impl Tables<'_> {
    /// The chain with its details; unchanged without tables.
    ///
    /// # Errors
    /// A value outside its rule.
    pub(super) fn apply(self, chain: Chain<f64>) -> Result<Chain<f64>> {
        let Self { beads, bonds, drives } = self;
        if beads.is_none() && bonds.is_none() && drives.is_empty() {
            return Ok(chain);
        }
        let touching = chain.touching().len();
        let mut details = Details::default();
        if let Some(beads) = beads {
            beads.apply(&chain, &mut details)?;
        }
        if let Some(bonds) = bonds {
            bonds.apply(&chain, touching, &mut details)?;
        }
        details.drives = drives.iter().map(DriveSection::build).collect::<Result<_>>()?;
        chain.with(&details).map_err(|error| named(error, beads, bonds))
    }
}

/// The numbers of a key; none if it is left out.
fn list(name: &'static str, values: &Option<Values>, count: usize) -> Result<Vec<f64>> {
    values.as_ref().map_or(Ok(Vec::new()), |values| values.of(name, count))
}

/// An error of the chain with its parameter named by the key of the scene.
fn named(error: Error, beads: Option<&BeadsSection>, bonds: Option<&BondsSection>) -> Error {
    let Error::Parameter { name, value, rule } = error else { return error };
    let name = match name {
        "mass" => "beads.mass",
        "drag" => "beads.drag",
        "kappa" if beads.is_some_and(|beads| beads.stiffness.is_some()) => "beads.stiffness",
        "dashpot" => "beads.dashpot",
        "kappa" if beads.is_some_and(|beads| beads.kappa.is_some()) => "beads.kappa",
        "rho" if beads.is_some_and(|beads| beads.rho.is_some()) => "beads.rho",
        "contact" => "bonds.contact",
        "overlap" => "bonds.overlap",
        "alpha" if bonds.is_some_and(|bonds| bonds.alpha.is_some()) => "bonds.alpha",
        "dissipation" => bonds.and_then(|bonds| bonds.losses().next()).map_or(name, |(key, ..)| key),
        other => other,
    };
    Error::Parameter { name, value, rule }
}

impl BeadsSection {
    fn apply(&self, chain: &Chain<f64>, details: &mut Details) -> Result<()> {
        let list = |name, values: &Option<Values>| list(name, values, chain.sites());
        let rho = self.rho.is_some() || chain.params().rho != 0.0;
        for (name, given, beside, other, rule) in [
            ("beads.stiffness", &self.stiffness, "beside kappa", self.kappa.is_some(), "it is another name of `kappa`"),
            ("beads.resonator", &self.resonator, "beside rho", rho, "masses of resonators are in place of `rho`"),
            ("beads.tau", &self.tau, "beside drag", self.drag.is_some(), "damping times are in place of `drag`"),
        ] {
            if given.is_some() && other {
                return Err(Error::parameter(name, beside, rule));
            }
        }
        details.mass = list("beads.mass", &self.mass)?;
        details.kappa = list("beads.kappa", &self.kappa)?;
        details.rho = list("beads.rho", &self.rho)?;
        details.drag = list("beads.drag", &self.drag)?;
        details.dashpot = list("beads.dashpot", &self.dashpot)?;
        if self.stiffness.is_some() {
            details.kappa = list("beads.stiffness", &self.stiffness)?;
        }
        let mass = |i: usize| details.mass.get(i).copied().unwrap_or(1.0);
        let of = |name, values: &Option<Values>, good: fn(f64) -> bool, rule, of: fn(f64, f64) -> f64| {
            let values = list(name, values)?;
            match values.iter().find(|value| !good(**value)) {
                Some(value) => Err(Error::parameter(name, value, rule)),
                None => Ok(values.iter().enumerate().map(|(i, value)| of(*value, mass(i))).collect()),
            }
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
        let list = |name, values: &Option<Values>| list(name, values, touching);
        details.contact = list("bonds.contact", &self.contact)?;
        details.alpha = list("bonds.alpha", &self.alpha)?;
        details.overlap = list("bonds.overlap", &self.overlap)?;
        if self.wall.is_some() {
            details.contact.resize(touching, 1.0);
            self.walls(chain.boundary(), &mut details.contact)?;
        }
        let mut losses = self.losses();
        if let Some((key, kind, values)) = losses.next() {
            if let Some((_, other, _)) = losses.next() {
                let rule = "contacts dissipate by one law: `viscoelastic` or `dashpot`";
                return Err(Error::parameter(key, format!("beside {}", other.name()), rule));
            }
            details.dissipation = Some(Dissipation { kind, strength: values.of(key, touching)? });
        }
        Ok(())
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

    fn build(&self) -> Result<Drive> {
        let harmonics = self.harmonics()?;
        let envelope = match (self.ramp, self.length) {
            (None, None) if self.start.is_some() => {
                return Err(Error::parameter("drive.start", "given", "`start` belongs to a burst with a `length`"));
            }
            (None, None) => Envelope::None,
            (Some(ramp), None) => Envelope::Ramp(ramp),
            (None, Some(length)) => Envelope::Burst { start: self.start.unwrap_or(0.0), length },
            (Some(ramp), Some(_)) => {
                return Err(Error::parameter("drive.ramp", ramp, "a burst has no ramp: `ramp` or `length`"));
            }
        };
        Ok(Drive { site: self.site, kind: self.kind, signal: Signal { harmonics, envelope } })
    }

    fn harmonics(&self) -> Result<Vec<Harmonic>> {
        let amplitudes = self.amplitude.list("drive.amplitude")?;
        if let Some([low, high]) = self.band {
            return self.noise(&amplitudes, low, high);
        }
        if let Some(seed) = self.seed {
            return Err(Error::parameter("drive.seed", seed, "a seed belongs to noise with a `band`"));
        }
        let Some(omega) = &self.omega else {
            return Err(Error::parameter("drive.omega", "nothing", "a drive has `omega` or a `band`"));
        };
        let omegas = omega.list("drive.omega")?;
        let phases = match &self.phase {
            Some(phase) => phase.list("drive.phase")?,
            None => vec![0.0; omegas.len()],
        };
        if amplitudes.len() != omegas.len() || phases.len() != omegas.len() {
            let value = format!("{} for {} frequencies", amplitudes.len().max(phases.len()), omegas.len());
            return Err(Error::parameter("drive.amplitude", value, "one amplitude and one phase a frequency"));
        }
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
        require(self.omega.is_none() && self.phase.is_none(), "drive.band", "beside omega or phase", rule)?;
        if !(low.is_finite() && high.is_finite() && 0.0 <= low && low < high) {
            let rule = "a band is from its least to its largest frequency, at least zero";
            return Err(Error::parameter("drive.band", format!("[{low}, {high}]"), rule));
        }
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
/// `told` turns a time into that of the scene.
pub(super) fn within(chain: &Chain<f64>, end: f64, told: impl Fn(f64) -> f64) -> Result<()> {
    for drive in chain.details().iter().flat_map(|details| &details.drives) {
        if drive.signal.settled() > end {
            let name = match drive.signal.envelope {
                Envelope::Burst { .. } => "drive.length",
                _ => "drive.ramp",
            };
            let value = format!("until t = {}", told(drive.signal.settled()));
            return Err(Error::parameter(
                name,
                value,
                "a drive comes to its full height, or to its end, within the scene",
            ));
        }
    }
    Ok(())
}

/// The details of a chain besides its parameters, in words; `None` if it has none.
pub(super) fn words(chain: &Chain<f64>) -> Option<String> {
    let details = chain.details()?;
    let range = |name: &str, list: &[f64]| {
        let (low, high) = crate::numerics::extremes(list.iter().copied());
        match list {
            [] => None,
            _ if low == high => Some(format!("{name} {}", format_short(low))),
            _ => Some(format!("{name} from {} to {}", format_short(low), format_short(high))),
        }
    };
    let mut all: Vec<String> = [
        range("masses", &details.mass),
        range("spring constants", &details.kappa),
        range("mass ratios", &details.rho),
        range("contact constants", &details.contact),
        range("exponents", &details.alpha),
        range("static overlaps", &details.overlap),
        range("drag", &details.drag),
        range("dashpots", &details.dashpot),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let Some(Dissipation { kind, strength }) = &details.dissipation {
        all.extend(range(kind.words(), strength));
    }
    for drive in &details.drives {
        let count = drive.signal.harmonics.len();
        let how = if drive.kind == DriveKind::Displacement { "moved" } else { "pushed" };
        all.push(format!("bead {} {how} by {count} harmonic{}", drive.site, if count == 1 { "" } else { "s" }));
    }
    Some(all.join(", "))
}
