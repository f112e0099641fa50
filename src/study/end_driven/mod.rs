//! Damped resonant chains driven at both ends: are there dark breathers (Sec. 8)?
//!
//! | symbol | meaning |
//! |---|---|
//! | `a, omega_d` | amplitude and frequency of the end beads: `a cos(omega_d t)`, and plus or minus that |
//! | `c_b` | first harmonic of the strain of bond `b`, a complex amplitude |
//! | `L, R` | means of `(-1)^b c_b` over the bonds of the left and of the right half |
//! | `B` | background, the smaller of the moduli of `L` and `R` |
//! | `C` | modulus of the mean of `(-1)^b c_b` over the one or two bonds in the middle |
//! | `K_x` | background amplitude of the conservative dark breather of frequency `omega_d` |
//!
//! The background of a dark breather alternates from bond to bond, with opposite signs on the two
//! sides of its kink. `L` and `R` leave out two bonds at each end and the three or four in the
//! middle. An orbit counts as a dark breather if `L` and `R` have opposite phases (cosine below
//! -0.9), `C <= B/10` and `B >= K_x/2`.
//!
//! The reflection of the chain maps a strain to that of the mirrored bond. With ends in antiphase
//! it is a symmetry: the strains of an odd number of bonds have no kink, those of an even number
//! have one about the bead in the middle. With ends in phase it is one together with half a period:
//! an odd number of bonds has a kink about the bond in the middle, an even number has none.

mod report;

use super::{
    Progress, Study, Work,
    stretches::{finished, unless_asked},
};
use crate::{
    breathers::DarkBreather,
    chain::{Boundary, Chain, Details, Drive, Envelope, Harmonic, Means, Params, Signal, State, max_norm},
    dps::Center,
    error::{Error, Result},
    orbits::{
        DriveParameter, DrivenBifurcation, DrivenContinuation, DrivenOrbit, DrivenPoint, DrivenSetting, DrivenShooting,
        End, Shooting,
    },
    sweep::map,
};
use nalgebra::Complex;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// Bonds at each end that are left out of the background.
const ENDS: usize = 2;
/// Sites of the ring of the conservative breather that gives `K_x`.
const RING: usize = 21;
/// Periods that the chain runs before its first orbit is sought.
const SETTLE: u32 = 400;
/// Ramps of runs from rest, in periods, and the periods that a run takes after its ramp.
const RAMPS: [u32; 2] = [20, 800];
const AFTER_RAMP: u32 = 4000;
/// Largest number of orbits of a branch for which runs from rest are made: those with the strongest
/// background.
const MOST_TRIED: usize = 4;
/// Distance from an orbit, in units of its largest unknown, at which a run has reached it.
const REACHED: f64 = 1e-3;
const SITES: std::ops::RangeInclusive<usize> = 10..=60;

/// Damped resonant chains driven at both ends.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct EndDriven {
    /// Numbers of sites, ends included.
    ///
    /// Separated by commas, each from 10 to 60. A chain with an even number has a kink about a bond
    /// if its ends move in phase; one with an odd number has a kink about a bead if they move in
    /// antiphase.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N,..", value_delimiter = ',', default_value = "10,11"))]
    pub lengths: Vec<usize>,
    /// Drive frequencies.
    ///
    /// Separated by commas, in radians per unit of time; above omega = sqrt(1 + 1/rho).
    #[cfg_attr(feature = "cli", arg(long, value_name = "W,..", value_delimiter = ',', default_value = "2.03,2.05"))]
    pub omegas: Vec<f64>,
    /// Mass ratio resonator to bead, positive.
    #[cfg_attr(feature = "cli", arg(long, value_name = "R", default_value_t = 1.0 / 3.0))]
    pub rho: f64,
    /// Drag on beads: force per velocity of a bead.
    #[cfg_attr(feature = "cli", arg(long, value_name = "C", default_value = "0.01"))]
    pub drag: f64,
    /// Dashpots beside the springs of resonators: force per relative velocity.
    #[cfg_attr(feature = "cli", arg(long, value_name = "D", default_value = "0.001"))]
    pub dashpot: f64,
    /// Largest drive amplitude.
    ///
    /// The displacement amplitude of the end beads at which a branch ends.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A", default_value = "0.2"))]
    pub to: f64,
    /// Largest change of the drive amplitude from point to point.
    #[cfg_attr(feature = "cli", arg(long, value_name = "DA", default_value = "0.01"))]
    pub step: f64,
    /// Points of the branch at most.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 30))]
    pub max_points: usize,
}

impl Default for EndDriven {
    fn default() -> Self {
        Self {
            lengths: vec![10, 11],
            omegas: vec![2.03, 2.05],
            rho: 1.0 / 3.0,
            drag: 0.01,
            dashpot: 0.001,
            to: 0.2,
            step: 0.01,
            max_points: 30,
        }
    }
}

/// How the ends move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ends {
    /// Both `a cos(omega_d t)`.
    InPhase,
    /// `a cos(omega_d t)` and `-a cos(omega_d t)`.
    Antiphase,
}

/// A point of a branch, with the background and the kink of its strains.
#[derive(Clone, Debug)]
pub struct EndDrivenPoint {
    /// The orbit with its multipliers.
    pub point: DrivenPoint,
    /// Background amplitude `B`.
    pub background: f64,
    /// Cosine of the angle between `L` and `R`.
    pub cosine: f64,
    /// Amplitude `C` in the middle.
    pub centre: f64,
    /// `c_b`, bond by bond, from the left, turned by the phase of `L`: a bond is in phase with the
    /// left half if `(-1)^b c_b` is real and positive.
    pub harmonics: Vec<Complex<f64>>,
}

/// A branch of orbits in the drive amplitude, for one length, one motion of the ends and one
/// frequency.
#[derive(Clone, Debug)]
pub struct EndDrivenCase {
    /// Number of sites.
    pub sites: usize,
    /// How the ends move.
    pub ends: Ends,
    /// Frequency of the drive.
    pub omega: f64,
    /// `K_x` of the conservative dark breather of this frequency.
    pub free: f64,
    /// The points, in their order along the branch.
    pub points: Vec<EndDrivenPoint>,
    /// Bifurcations between them.
    pub bifurcations: Vec<DrivenBifurcation>,
    /// Why the branch ended; `None` if the chain did not settle to a first orbit.
    pub end: Option<End>,
    /// Index of the stable dark breather with the strongest background.
    pub best: Option<usize>,
    /// Runs from rest to stable dark breathers, the strongest background first.
    pub from_rest: Vec<FromRest>,
}

/// Whether a chain at rest comes to an orbit when its drive is switched on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FromRest {
    /// Drive amplitude.
    pub amplitude: f64,
    /// The ramp that leads to the orbit, in periods; the shortest of 20 and 800. `None`: neither.
    pub ramp: Option<u32>,
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct EndDrivenStudy {
    /// The options.
    pub options: EndDriven,
    /// The branches, ordered by length, then by the motion of the ends, then by frequency.
    pub cases: Vec<EndDrivenCase>,
}

impl Study for EndDriven {
    const FILES: &'static str = "Files: end-driven.csv, end-driven.json and end-driven.png.";
    const STOPS: bool = true;

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|_, progress| Ok(Box::new(self.study(progress)?))))
    }
}

impl Ends {
    /// The sign of the right end.
    fn sign(self) -> f64 {
        if self == Self::InPhase { 1.0 } else { -1.0 }
    }
}

impl EndDrivenPoint {
    /// Whether the background alternates, with a kink in the middle.
    pub fn kinked(&self) -> bool {
        self.cosine <= -0.9 && self.centre <= 0.1 * self.background
    }

    /// Whether it counts as a dark breather, where `free` is the background amplitude `K_x` of the
    /// conservative one.
    pub fn dark(&self, free: f64) -> bool {
        self.kinked() && self.background >= 0.5 * free
    }

    /// Measures the background and the kink in the strains of an orbit.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn measured(point: DrivenPoint) -> Result<Self> {
        let samples = point.orbit.samples(&DrivenShooting::default())?;
        let n = samples.first().map_or(0, |_| point.orbit.setting.sites());
        let staggered: Vec<Complex<f64>> = (1..n)
            .map(|b| {
                let sign = if b % 2 == 0 { 1.0 } else { -1.0 };
                first_harmonic(samples[1..].iter().map(|state| state[b] - state[b - 1])) * sign
            })
            .collect();
        let bonds = staggered.len();
        let mean = |range: std::ops::Range<usize>| {
            let count = range.len() as f64;
            staggered[range].iter().sum::<Complex<f64>>() / count
        };
        // The middle is one bond of an odd number, or two of an even one. `L` and `R` also leave
        // out the bond on either side of it.
        let (low, high) = ((bonds - 1) / 2, bonds / 2 + 1);
        let (left, right) = (mean(ENDS..low - 1), mean(high + 1..bonds - ENDS));
        let cosine = (left * right.conj()).re / (left.norm() * right.norm()).max(f64::MIN_POSITIVE);
        let turn = (left / left.norm().max(f64::MIN_POSITIVE)).conj();
        let sign = |b: usize| if b.is_multiple_of(2) { -1.0 } else { 1.0 };
        let harmonics = staggered.iter().enumerate().map(|(b, c)| c * turn * sign(b)).collect();
        Ok(Self { background: left.norm().min(right.norm()), cosine, centre: mean(low..high).norm(), harmonics, point })
    }

    /// The drive amplitude.
    pub fn amplitude(&self) -> f64 {
        self.point.orbit.setting.get(DriveParameter::Amplitude)
    }
}

/// The amplitude of the first harmonic of equal samples of a period.
fn first_harmonic(samples: impl ExactSizeIterator<Item = f64>) -> Complex<f64> {
    let count = samples.len() as f64;
    let turned = samples.enumerate().map(|(k, x)| Complex::from_polar(x, -2.0 * PI * (k + 1) as f64 / count));
    turned.sum::<Complex<f64>>() * (2.0 / count)
}

impl EndDriven {
    fn check(&self) -> Result<()> {
        let params = Params::new(1.5, 1.0, self.rho)?;
        if let Some(sites) = self.lengths.iter().find(|sites| !SITES.contains(sites)) {
            return Err(Error::parameter("lengths", sites, "from 10 to 60 sites"));
        }
        if let Some(omega) = self.omegas.iter().find(|omega| !(omega.is_finite() && **omega > params.omega())) {
            return Err(Error::parameter("omegas", omega, "finite, and above sqrt(1 + 1/rho)"));
        }
        for (name, value) in [("drag", self.drag), ("dashpot", self.dashpot)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::parameter(name, value, "finite and at least zero"));
            }
        }
        if self.drag + self.dashpot == 0.0 {
            return Err(Error::parameter("drag", 0, "a chain without drag has a dashpot"));
        }
        for (name, value) in [("to", self.to), ("step", self.step)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::parameter(name, value, "finite and positive"));
            }
        }
        if self.step >= self.to {
            return Err(Error::parameter("step", self.step, "below the largest amplitude"));
        }
        if !(2..=10_000).contains(&self.max_points) {
            return Err(Error::parameter("max-points", self.max_points, "from 2 to 10000"));
        }
        Ok(())
    }

    /// The chain.
    ///
    /// # Errors
    /// Numbers outside their rules.
    pub fn chain(&self, sites: usize, ends: Ends, omega: f64, amplitude: f64, ramp: f64) -> Result<Chain<f64>> {
        let inner = |value: f64| (0..sites).map(|i| if i == 0 || i + 1 == sites { 0.0 } else { value }).collect();
        let envelope = if ramp > 0.0 { Envelope::Ramp(ramp) } else { Envelope::None };
        let drive = |site: usize, amplitude: f64| Drive {
            site,
            means: Means::Moved,
            signal: Signal { harmonics: vec![Harmonic { amplitude, omega, phase: FRAC_PI_2 }], envelope },
        };
        let details = Details {
            rho: inner(self.rho),
            drag: inner(self.drag),
            dashpot: inner(self.dashpot),
            drives: vec![drive(0, amplitude), drive(sites - 1, ends.sign() * amplitude)],
            ..Details::default()
        };
        Chain::new(Params::new(1.5, 1.0, self.rho)?, Boundary::Free, sites)?.with(&details)
    }

    fn study(&self, progress: Progress<'_>) -> Result<EndDrivenStudy> {
        self.check()?;
        let mut cases = Vec::new();
        for &sites in &self.lengths {
            for ends in [Ends::InPhase, Ends::Antiphase] {
                cases.extend(self.omegas.iter().map(|&omega| (sites, ends, omega)));
            }
        }
        let done = std::sync::atomic::AtomicUsize::new(0);
        let one = |&(sites, ends, omega): &(usize, Ends, f64)| {
            let case = unless_asked(|| self.case(sites, ends, omega));
            let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            progress(count as f64 / cases.len() as f64, &format!("N = {sites}, omega = {omega}"));
            case
        };
        let found = finished(map(&cases, one))?;
        Ok(EndDrivenStudy { options: self.clone(), cases: found })
    }

    /// `K_x` of the conservative breather of this frequency.
    fn free(&self, omega: f64) -> Result<f64> {
        let params = Params::new(1.5, 1.0, self.rho)?;
        let breather = DarkBreather { params, center: Center::Site, sites: RING, omega_b: omega, c_x: 0.0 };
        let shooting = Shooting::default();
        Ok(breather.orbit(&shooting)?.extent(shooting.tol)?.k_x)
    }

    /// The branch of one case.
    ///
    /// # Errors
    /// Numbers outside their rules; an integration that fails; a signal.
    pub fn case(&self, sites: usize, ends: Ends, omega: f64) -> Result<EndDrivenCase> {
        let (shooting, free) = (DrivenShooting::default(), self.free(omega)?);
        let chain = self.chain(sites, ends, omega, self.step, 0.0)?;
        let setting = DrivenSetting::new(&chain, 1)?;
        let mut case = EndDrivenCase {
            sites,
            ends,
            omega,
            free,
            points: Vec::new(),
            bifurcations: Vec::new(),
            end: None,
            best: None,
            from_rest: Vec::new(),
        };
        let rest = State::rest(&chain).driven(&chain);
        let seed = shooting.settle(&setting, &chain, &rest, SETTLE, |_| {})?;
        let start = match shooting.solve(&setting, &seed) {
            Ok(orbit) => orbit,
            Err(Error::Stalled { .. }) => return Ok(case),
            Err(error) => return Err(error),
        };
        let continuation = DrivenContinuation {
            parameter: DriveParameter::Amplitude,
            to: self.to,
            step: self.step,
            most_points: self.max_points,
            shooting,
        };
        let branch = continuation.follow(start, |_| {})?;
        case.points = branch.points.into_iter().map(EndDrivenPoint::measured).collect::<Result<_>>()?;
        (case.bifurcations, case.end) = (branch.bifurcations, Some(branch.end));
        let stable = |k: &usize| case.points[*k].dark(free) && case.points[*k].point.stable();
        let mut candidates: Vec<usize> = (0..case.points.len()).filter(stable).collect();
        candidates.sort_by(|&a, &b| case.points[b].background.total_cmp(&case.points[a].background));
        case.best = candidates.first().copied();
        let tried = candidates.iter().take(MOST_TRIED);
        case.from_rest =
            tried.map(|&k| self.reached_from_rest(&case, &case.points[k].point.orbit)).collect::<Result<_>>()?;
        Ok(case)
    }

    /// Whether a chain at rest comes to an orbit.
    fn reached_from_rest(&self, case: &EndDrivenCase, orbit: &DrivenOrbit) -> Result<FromRest> {
        let amplitude = orbit.setting.get(DriveParameter::Amplitude);
        let size = max_norm(orbit.z.iter().copied());
        let reaches = |ramp: u32| -> Result<bool> {
            let length = f64::from(ramp) * orbit.setting.period();
            let chain = self.chain(case.sites, case.ends, case.omega, amplitude, length)?;
            let state = State::rest(&chain).driven(&chain);
            let z = DrivenShooting::default().settle(&orbit.setting, &chain, &state, AFTER_RAMP, |_| {})?;
            Ok(z.iter().zip(&orbit.z).all(|(a, b)| (a - b).abs() <= REACHED * size))
        };
        for ramp in RAMPS {
            if reaches(ramp)? {
                return Ok(FromRest { amplitude, ramp: Some(ramp) });
            }
        }
        Ok(FromRest { amplitude, ramp: None })
    }
}

impl EndDrivenCase {
    /// The points at which orbits begin to be dark breathers: the first, and the first stable one.
    pub fn first(&self) -> [Option<&EndDrivenPoint>; 2] {
        let dark = |one: &&EndDrivenPoint| one.dark(self.free);
        [self.points.iter().find(dark), self.points.iter().find(|one| dark(one) && one.point.stable())]
    }
}
