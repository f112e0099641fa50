//! Moving dark breathers as exact orbits, and kicked breathers held against them (Sec. 8).
//!
//! | symbol | meaning |
//! |---|---|
//! | `k, T_m, v` | turns; time in which the kink moves on by a site; velocity `1/T_m` |
//! | depth | local amplitude of the two sites of a kink on a bond, over that of the background |
//! | tail | largest less smallest local amplitude far from the kink, over that of the background |
//! | resonant | linear wave of the background that keeps its phase in the frame of the kink |
//!
//! Moving breathers of one background are a family, in which depth and velocity belong to each
//! other. A kicked breather that moves as one of them has the depth that belongs to its velocity.

pub(crate) mod kicked;
mod report;

pub use kicked::{KickedRun, Passage};

use crate::study::{ChainParams, Progress, Study, Work, options::options, part};
use crate::{
    breathers::{Band, Envelope, KinkEnergy, LinearWave, LinearWaves, MovingBreather, MovingOrbit, Tail},
    error::{Error, Result},
    number::format_short,
    numerics::least_by,
    orbits::{Shooting, Spectrum},
    report::Report,
    sweep::{Engine, Grid, Row},
};
use serde_json::json;

/// Default frequency, in units of `omega`.
const RATIO: f64 = 1.025;
/// Shares of the progress after orbits, and after multipliers; the kicked run is the rest.
const ORBITS: f64 = 0.45;
const MULTIPLIERS: f64 = 0.9;

options! {
    /// Moving dark breathers as relative periodic orbits, and a kicked one.
    pub struct Moving {
        /// Frequencies of the background, in radians per unit of time [default: 1.025 omega].
        ///
        /// Separated by commas, each above omega = sqrt(kappa (1 + 1/rho)).
        omega_b: Vec<f64> = vec![], "W,..";
        /// Whole periods of the background for each site that the kink moves on.
        ///
        /// Separated by commas. With K the kink needs K + 1/2 periods for a site, so that its
        /// velocity is omega_b/(2 pi (K + 1/2)).
        turns: Vec<u32> = vec![18, 22, 26], "K,..", (1 to 100);
        /// Number of sites.
        ///
        /// The ring has an odd number of sites, from 9 to 255. The tails of the breather depend on
        /// it.
        sites: usize = 41, "N";
        /// The chain.
        params: ChainParams = ChainParams::default();
        /// End time, in units of time.
        ///
        /// End of the run of the kicked breather, from one period of the background to 10^5 of
        /// them; 0 for no such run. It starts from the bond-centred breather at rest with the first
        /// frequency.
        until: f64 = 1200.0, "T";
        /// Size of a kick along one mode, in units of the orbit's amplitude.
        ///
        /// The largest change of an entry of the initial state, along the mode that grows most; of
        /// either sign, not zero, at most 1 in modulus.
        kick: f64 = 1e-2, "SIZE";
        /// Tolerance.
        tol: f64 = 1e-14, "T", (RUN), [long_help = crate::study::OF_WINDOWS];
    }
}

/// A moving breather with its envelope, multipliers, tail and energy.
#[derive(Clone, Debug)]
pub struct MovingPoint {
    /// The orbit.
    pub orbit: MovingOrbit,
    /// See [`MovingOrbit::return_error`].
    pub return_error: f64,
    /// Local amplitudes.
    pub envelope: Envelope,
    /// Relative multipliers.
    pub spectrum: Spectrum,
    /// The wave that fits the tail best.
    pub tail: Tail,
    /// Linear waves that keep their phase in the frame of the kink; none where the background was
    /// not found.
    pub resonant: Vec<LinearWave>,
    /// Energies of the kink ([`MovingOrbit::kink_energy`]); NaN where the background was not found.
    pub energy: KinkEnergy,
}

impl MovingPoint {
    /// Growth per unit of time of the largest multiplier.
    pub fn growth(&self) -> f64 {
        self.spectrum.largest().ln() * self.orbit.setting.velocity()
    }

    /// Wave number of the resonant modulation of the background that is nearest to that of the
    /// tail; NaN if there is none.
    pub fn resonant_wave(&self) -> f64 {
        let apart = |wave: &f64| (wave - self.tail.wave_number).abs();
        let waves = self.resonant.iter().filter(|wave| wave.band == Band::Modulation).map(|wave| wave.wave_number);
        least_by(waves, apart).unwrap_or(f64::NAN)
    }
}

/// Moving breathers of some frequencies and velocities.
#[derive(Clone, Debug)]
pub struct MovingStudy {
    /// The options.
    pub options: Moving,
    /// The breathers that were found, by frequency, then by turns, as asked for.
    pub points: Vec<MovingPoint>,
    /// Frequencies and turns at which none was found, with the reason.
    pub missing: Vec<(f64, u32, String)>,
    /// The kicked run.
    pub kicked: Option<KickedRun>,
}

/// An orbit with its local amplitudes.
type Measured = (MovingOrbit, Envelope);
/// Return error, multipliers, resonant waves and energy of a point.
type Analysis = (f64, Spectrum, Vec<LinearWave>, KinkEnergy);

/// A breather in words.
fn name(omega_b: f64, turns: u32) -> String {
    format!("omega_b = {} with {turns} turns", format_short(omega_b))
}

impl Study for Moving {
    const FILES: &'static str = "moving-multipliers.store keeps multipliers and energies.";
    const STORE: &'static str = "moving.store";

    fn outline() -> Option<Report> {
        let tables = [report::points(&[]), report::envelopes(&[]), report::passages(&[])];
        Some(tables.into_iter().fold(Report::new("moving"), Report::table))
    }

    fn optional_files() -> Vec<String> {
        vec!["passages.csv".to_owned()]
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.breathers()?;
        Ok(Box::new(move |engine, progress| Ok(self.study(engine, progress)?.report())))
    }
}

impl Moving {
    /// The breathers that are asked for.
    ///
    /// # Errors
    /// Numbers outside their rules.
    pub fn breathers(&self) -> Result<Vec<MovingBreather>> {
        self.within_ranges()?;
        let params = self.params.checked()?;
        let frequencies = if self.omega_b.is_empty() { vec![RATIO * params.omega()] } else { self.omega_b.clone() };
        let sites = self.sites;
        let of = |omega_b: f64| self.turns.iter().map(move |&turns| MovingBreather { params, sites, omega_b, turns });
        let breathers: Vec<MovingBreather> = frequencies.into_iter().flat_map(of).collect();
        for breather in &breathers {
            breather.chain()?;
            breather.at_rest().seed()?;
        }
        if self.until != 0.0 {
            kicked::check(self, breathers[0].at_rest().setting().period())?;
        }
        Ok(breathers)
    }

    /// Computes the breathers with all numbers of the study, and the kicked run.
    ///
    /// # Errors
    /// Numbers outside their rules; an integration that fails; not one breather found; the process
    /// was asked to end.
    pub fn study(&self, engine: &Engine, progress: Progress<'_>) -> Result<MovingStudy> {
        let breathers = self.breathers()?;
        let settings = json!({ "params": breathers[0].params, "sites": self.sites, "tol": self.tol });
        let grid = Grid { store: Self::STORE, study: "moving", settings };
        let orbit = |breather: &MovingBreather| self.measured(breather.orbit(self.tol)?);
        let swept = engine.sweep(&grid, &breathers, &part(progress, 0.0, ORBITS), orbit)?;
        if swept.missing > 0 {
            return Err(swept.stopped());
        }
        let mut found = swept.rows;
        self.follow(&breathers, &mut found);
        let (mut orbits, mut missing) = (Vec::new(), Vec::new());
        for (&MovingBreather { omega_b, turns, .. }, found) in breathers.iter().zip(found) {
            match found {
                Ok(measured) => orbits.push(measured),
                Err(why) => missing.push((omega_b, turns, why)),
            }
        }
        if let ([], Some((omega_b, turns, why))) = (&orbits[..], missing.last()) {
            return Err(Error::Point { point: name(*omega_b, *turns), why: why.clone() });
        }
        let grid = Grid { store: "moving-multipliers.store", ..grid };
        let swept = engine.sweep(&grid, &orbits, &part(progress, ORBITS, MULTIPLIERS), |orbit| self.analysis(orbit))?;
        let all = swept.all(&orbits, |(orbit, _)| name(orbit.setting.omega_b, orbit.setting.turns))?;
        let point = |((orbit, envelope), analysis): (Measured, Analysis)| {
            let (return_error, spectrum, resonant, energy) = analysis;
            MovingPoint { return_error, spectrum, resonant, energy, tail: envelope.tail_wave(), envelope, orbit }
        };
        let points = orbits.into_iter().zip(all).map(point).collect();
        let rest = || breathers[0].at_rest().orbit(&Shooting::default());
        let kicked = (self.until != 0.0).then(|| KickedRun::of(&rest()?, self)).transpose()?;
        Ok(MovingStudy { options: self.clone(), points, missing, kicked })
    }

    fn analysis(&self, (orbit, envelope): &Measured) -> Result<Analysis> {
        let (breather, tail) = (&orbit.setting, envelope.tail_wave());
        // The frequency is that of the ring's background. A search of its own looks for the
        // background, and the orbit is kept even if that search fails.
        let waves = LinearWaves::new(breather.params, breather.omega_b + tail.twist / breather.passage());
        Ok((
            orbit.return_error(self.tol)?,
            orbit.spectrum(self.tol)?,
            waves.map_or(Vec::new(), |waves| waves.resonant(breather.passage())),
            orbit.kink_energy(tail.twist, self.tol).unwrap_or(KinkEnergy { energy: f64::NAN, free: f64::NAN }),
        ))
    }

    fn measured(&self, orbit: MovingOrbit) -> Result<Measured> {
        let envelope = orbit.envelope(self.tol)?;
        Ok((orbit, envelope))
    }

    /// Looks for each breather again from its neighbour in the list of frequencies, with the same
    /// turns, upwards and downwards. Keeps the orbit with the smaller tail.
    fn follow(&self, breathers: &[MovingBreather], found: &mut [Row<Measured>]) {
        let mut pairs: Vec<(usize, usize)> =
            (self.turns.len()..breathers.len()).map(|k| (k - self.turns.len(), k)).collect();
        pairs.extend(pairs.clone().into_iter().rev().map(|(a, b)| (b, a)));
        for (from, to) in pairs {
            let Ok((neighbour, envelope)) = &found[from] else { continue };
            let least = found[to].as_ref().map_or(f64::INFINITY, |(_, envelope)| envelope.tail);
            if least <= envelope.tail {
                continue;
            }
            let other = breathers[to].solve(&neighbour.z, self.tol).and_then(|orbit| self.measured(orbit));
            if let Some(other) = other.ok().filter(|(_, envelope)| envelope.tail < least) {
                found[to] = Ok(other);
            }
        }
    }
}

impl MovingStudy {
    /// The depth that belongs to a velocity, by straight lines between the breathers of the first
    /// frequency; `None` beyond their velocities.
    pub fn depth(&self, velocity: f64) -> Option<f64> {
        let first = self.points.first()?.orbit.setting.omega_b;
        let mut family: Vec<(f64, f64)> = self
            .points
            .iter()
            .filter(|point| point.orbit.setting.omega_b == first)
            .map(|point| (point.orbit.setting.velocity(), point.envelope.depth))
            .collect();
        family.sort_by(|a, b| a.0.total_cmp(&b.0));
        let pair = family.windows(2).find(|pair| (pair[0].0..=pair[1].0).contains(&velocity))?;
        let share = (velocity - pair[0].0) / (pair[1].0 - pair[0].0);
        Some(pair[0].1 + share * (pair[1].1 - pair[0].1))
    }

    /// Largest difference of the depths of a kicked run from those that belong to its velocities;
    /// `None` where no passage has a velocity among those of the breathers.
    pub fn apart(&self) -> Option<f64> {
        let passages = self.kicked.as_ref()?.passages.iter();
        let differences = passages.filter_map(|one| Some((one.depth - self.depth(one.velocity?)?).abs()));
        differences.reduce(f64::max)
    }
}
