//! The tables `[beads]`, `[bonds]` and `[[drive]]` of a scene, and the details of a chain that they
//! and `[units]` give.

use super::{Units, UnitsSection, values::Values};
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
        /// Masses (1 if left out).
        mass?: Values,
        /// Spring constants (`chain.kappa` if left out).
        kappa?: Values,
        /// Mass ratios resonator to bead (`chain.rho` if left out).
        rho?: Values,
        /// Drag on beads, `-drag u'` (none if left out).
        drag?: Values,
        /// Dashpots beside the springs of resonators, `-dashpot (u' - v')` (none if left out).
        dashpot?: Values,
    }

    /// The section `[bonds]`: one number for each bond that can touch, from left to right.
    #[derive(Default)]
    pub struct BondsSection {
        /// Contact constants (1 if left out); 0: no contact.
        contact?: Values,
        /// Contact constant of the two walls (that of `contact` if left out).
        wall?: f64,
        /// Exponents (`chain.alpha` if left out).
        alpha?: Values,
        /// Static overlaps (`chain.precompression` if left out); negative: beads apart.
        overlap?: Values,
        /// Dissipation constants of viscoelastic contacts, in units of time.
        viscoelastic?: Values,
        /// Dashpot constants of contacts, force over velocity.
        dashpot?: Values,
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
        omega?: Values,
        /// Phases, one a harmonic, in radians (0 if left out).
        phase?: Values,
        /// Noise: the least and the largest angular frequency, in place of `omega` and `phase`.
        band?: [f64; 2],
        /// Seed of noise (1 if left out).
        seed?: u64,
        /// Time in which the signal rises to its full amplitude (no ramp if left out).
        ramp?: f64,
        /// Start of a burst (0 if left out).
        start?: f64,
        /// Length of a burst.
        length?: f64,
    }
}

/// The tables of a scene from which the details of its chain are built.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tables<'a> {
    pub(super) beads: Option<&'a BeadsSection>,
    pub(super) bonds: Option<&'a BondsSection>,
    pub(super) drives: &'a [DriveSection],
    pub(super) units: Option<&'a UnitsSection>,
}

impl Tables<'_> {
    /// The chain with its details, and its units; unchanged without tables.
    ///
    /// # Errors
    /// A value outside its rule.
    pub(super) fn apply(self, chain: Chain<f64>) -> Result<(Chain<f64>, Option<Units>)> {
        let Self { beads, bonds, drives, units } = self;
        if beads.is_none() && bonds.is_none() && drives.is_empty() && units.is_none() {
            return Ok((chain, None));
        }
        let (n, touching) = (chain.sites(), chain.touching().len());
        let mut details = Details::default();
        if let Some(beads) = beads {
            let list = |name, values: &Option<Values>| list(name, values, n);
            details.mass = list("beads.mass", &beads.mass)?;
            details.kappa = list("beads.kappa", &beads.kappa)?;
            details.rho = list("beads.rho", &beads.rho)?;
            details.drag = list("beads.drag", &beads.drag)?;
            details.dashpot = list("beads.dashpot", &beads.dashpot)?;
        }
        if let Some(bonds) = bonds {
            bonds.apply(&chain, touching, &mut details)?;
        }
        let units = units.map(|section| section.apply(&chain, &mut details)).transpose()?;
        details.drives = drives.iter().map(|drive| drive.build(units.as_ref())).collect::<Result<_>>()?;
        Ok((chain.with(&details).map_err(|error| named(error, beads, bonds))?, units))
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

impl BondsSection {
    fn apply(&self, chain: &Chain<f64>, touching: usize, details: &mut Details) -> Result<()> {
        let list = |name, values: &Option<Values>| list(name, values, touching);
        details.contact = list("bonds.contact", &self.contact)?;
        details.alpha = list("bonds.alpha", &self.alpha)?;
        details.overlap = list("bonds.overlap", &self.overlap)?;
        if let Some(wall) = self.wall {
            require(chain.boundary() == Boundary::Fixed, "bonds.wall", wall, "only boundary = \"fixed\" has walls")?;
            details.contact.resize(touching, 1.0);
            (details.contact[0], details.contact[touching - 1]) = (wall, wall);
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

    /// The laws of dissipation that are given, with their keys and constants.
    fn losses(&self) -> impl Iterator<Item = (&'static str, Kind, &Values)> {
        let all = [
            ("bonds.viscoelastic", Kind::Viscoelastic, &self.viscoelastic),
            ("bonds.dashpot", Kind::Dashpot, &self.dashpot),
        ];
        all.into_iter().filter_map(|(key, kind, values)| values.as_ref().map(|values| (key, kind, values)))
    }
}

impl UnitsSection {
    fn apply(&self, chain: &Chain<f64>, details: &mut Details) -> Result<Units> {
        if chain.params().alpha != 1.5 || !details.alpha.is_empty() {
            return Err(Error::parameter("units.radius", "given", "spheres have alpha = 1.5 in all bonds"));
        }
        for (name, list) in
            [("beads.mass", &details.mass), ("bonds.contact", &details.contact), ("bonds.overlap", &details.overlap)]
        {
            require(list.is_empty(), name, "given", "it follows from [units]: leave it out")?;
        }
        let ends: Vec<_> = chain.touching().map(|bond| chain.topology().ends(bond)).collect();
        let material = self.material(chain.sites(), &ends)?;
        (details.mass, details.contact) = (material.mass, material.contact);
        if self.static_load.is_some() {
            details.overlap = material.overlap;
        }
        Ok(material.units)
    }
}

impl DriveSection {
    /// The drive; with units, amplitude, frequencies and times are in SI.
    fn build(&self, units: Option<&Units>) -> Result<Drive> {
        let (height, time) = match (units, self.kind) {
            (None, _) => (1.0, 1.0),
            (Some(units), DriveKind::Displacement) => (units.length_m, units.time_s),
            (Some(units), DriveKind::Force) => (units.force_n, units.time_s),
        };
        let mut harmonics = self.harmonics()?;
        for harmonic in &mut harmonics {
            harmonic.amplitude /= height;
            harmonic.omega *= time;
        }
        let envelope = match (self.ramp, self.length) {
            (None, None) if self.start.is_some() => {
                return Err(Error::parameter("drive.start", "given", "`start` belongs to a burst with a `length`"));
            }
            (None, None) => Envelope::None,
            (Some(ramp), None) => Envelope::Ramp(ramp / time),
            (None, Some(length)) => Envelope::Burst { start: self.start.unwrap_or(0.0) / time, length: length / time },
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
pub(super) fn within(chain: &Chain<f64>, end: f64) -> Result<()> {
    for drive in chain.details().iter().flat_map(|details| &details.drives) {
        if drive.signal.settled() > end {
            let name = match drive.signal.envelope {
                Envelope::Burst { .. } => "drive.length",
                _ => "drive.ramp",
            };
            let value = format!("until t = {}", drive.signal.settled());
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
