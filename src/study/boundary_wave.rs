//! Travelling waves launched into a chain from one end.
//!
//! A chain under a static overlap lies between walls. Its first bead is moved as
//! `A sin(omega_d t)`, after a ramp, and sends a wave into the chain; dashpots in the last sites
//! absorb it. Far from both ends the strain is `X_b + Re(c_b exp(-i omega_d t))` and harmonics.
//!
//! | symbol | meaning |
//! |---|---|
//! | `omega_d` | frequency of the drive, above that of a free site, `omega` |
//! | `X, r` | mean strain and amplitude `abs(c_b)`, weighted means over the measured bonds |
//! | `q` | wave number: slope of the phase of `c_b`, by least squares |
//! | `q_tw` | wave number of the first-order wave with this frequency, `X` and `r` |
//!
//! By (eq:w_tw) with `epsilon = 1`,
//! `sin^2(q_tw/2) = (omega_d - omega) omega^3/(2 h(X, r/(2 kappa)))`. For a weak wave `h` is
//! `kappa alpha g_0^{alpha-1}`, `g_0` the static overlap.

use super::{Progress, Study, Work, options::options};
use crate::{
    chain::{Boundary, Chain, Details, Drive, DriveKind, Params, Signal, State},
    dps::Averages,
    error::{Error, Result, require},
    report::{
        Column,
        Digits::{Fixed, Power, Short},
        Kind, Panel, Panels, Report, fields, rows,
    },
    run::{Method, Run},
    sweep::{Engine, Grid, Missing},
};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{f64::consts::TAU, ops::Range};

const ALPHA: f64 = 1.5;
const KAPPA: f64 = 1.0;
/// Number of sites at the far end whose dashpots absorb the wave. They grow like the cube of the
/// distance, up to `DASHPOT` at the last site.
const ABSORBING: usize = 40;
const DASHPOT: f64 = 0.05;
/// Numbers of bonds that are not measured, beside the bead that is moved and before the dashpots.
const NEAR: usize = 10;
const BEFORE: usize = 5;
/// Periods of the drive in its ramp, periods over which the wave is measured at the end of the run,
/// and samples in each of these.
const RAMP: f64 = 30.0;
const PERIODS: usize = 40;
const SAMPLES: usize = 32;
/// Time between ramp and measurement, in units of the time that a weak wave takes to the dashpots.
const TRANSITS: f64 = 2.0;
const TOLERANCE: f64 = 1e-9;
/// Longest run, in periods of the drive.
const MOST_PERIODS: f64 = 1e5;
/// Largest frequency of contacts, in units of that of the drive.
const FASTEST: f64 = 100.0;

options! {
    /// Travelling waves launched into a chain from one end.
    pub struct BoundaryWave {
        /// Number of sites.
        ///
        /// The first bead is moved; the last 40 absorb the wave.
        sites: usize = 90, "N", (80 to 1000);
        /// Drive frequencies.
        ///
        /// Separated by commas, in radians per unit of time; above omega = sqrt(1 + 1/rho), and
        /// below the end of the band of weak waves.
        omegas: Vec<f64> = vec![2.002, 2.004, 2.006, 2.008, 2.01, 2.015, 2.02], "W,..";
        /// Displacement amplitude of the first bead.
        drive: f64 = 0.05, "A", (1e-10 to 100);
        /// Static overlap of all contacts.
        overlap: f64 = 0.05, "G", (positive);
        /// Mass ratio resonator to bead.
        rho: f64 = 1.0 / 3.0, "R", (positive);
    }
}

rows! {
    /// The strain of a bond, from the periods of the measurement.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    pub struct BondStrain {
        /// Frequency of the drive.
        omega: f64,
        /// Between the sites bond - 1 and bond.
        bond: usize,
        /// Mean of the strain.
        mean: f64,
        /// Amplitude of its first harmonic.
        amplitude: f64,
        /// Angle from this harmonic to that of the next bond, in radians.
        angle: f64,
    }
}

rows! {
    /// The wave that a drive of one frequency launches.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct LaunchedWave {
        /// Frequency of the drive.
        omega: f64 => Short,
        /// Wave number, measured, in radians per site.
        q: f64 => Fixed(4),
        /// That of the first-order wave, if the frequency is in its band.
        q_theory: Option<f64> => Fixed(4),
        /// Amplitude of the strain.
        amplitude: f64 => Power(3),
        /// Mean strain.
        mean_strain: f64 => Power(3),
        /// Standard deviation of the amplitude over the measured bonds, weighted, in its units.
        spread: f64 => Fixed(3),
        /// Whether a measured contact opens during the measurement.
        opens: bool => Short,
        /// Time at which the run ends.
        end: f64,
    }
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct BoundaryWaveStudy {
    /// The options of the study.
    pub options: BoundaryWave,
    /// The waves, in the order of the frequencies.
    pub waves: Vec<LaunchedWave>,
    /// The strains of all bonds between beads but the last, wave by wave.
    pub strains: Vec<BondStrain>,
    /// The frequencies without a wave.
    pub missing: Missing,
}

impl Study for BoundaryWave {
    const STORE: &'static str = "boundary-wave.store";

    fn outline() -> Option<Report> {
        Some(
            BoundaryWaveStudy { options: Self::default(), waves: Vec::new(), strains: Vec::new(), missing: Vec::new() }
                .report(),
        )
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|engine, progress| Ok(self.study(engine, progress)?.report())))
    }
}

/// `sin^2(q/2) = (omega_d - omega) omega^3/(2 h)`, if that is at most 1.
fn wave_number(omega: f64, omega_d: f64, h: f64) -> Option<f64> {
    let square = (omega_d - omega) * omega.powi(3) / (2.0 * h);
    (0.0..=1.0).contains(&square).then(|| 2.0 * square.sqrt().asin())
}

impl BoundaryWave {
    fn params(&self) -> Result<Params> {
        Params::new(ALPHA, KAPPA, self.rho)
    }

    fn check(&self) -> Result<()> {
        self.within_ranges()?;
        self.omegas.iter().try_for_each(|&omega_d| {
            self.weak_wave_number(omega_d)?;
            self.check_contacts(omega_d)?;
            self.end(omega_d).map(drop)
        })
    }

    /// Refuses contacts that are too fast for a run with this drive. Beads of mass 1 joined by
    /// springs `k` have frequencies up to `2 k^{1/2}`; here `k = alpha g^{alpha-1}`.
    fn check_contacts(&self, omega_d: f64) -> Result<()> {
        let largest = self.overlap + 2.0 * self.drive;
        let frequency = 2.0 * (ALPHA * largest.powf(ALPHA - 1.0)).sqrt();
        let rule =
            "contacts are at most 100 times as fast as the drive: 6^(1/2) (overlap + 2 drive)^(1/4) <= 100 omega";
        // The range of the drive alone leaves contacts slower.
        require(frequency <= FASTEST * omega_d, "overlap", self.overlap, rule)
    }

    fn weak_wave_number(&self, omega_d: f64) -> Result<f64> {
        let (omega, h) = (self.params()?.omega(), Averages::new(ALPHA, KAPPA)?.h(-self.overlap, 0.0));
        let rule = "above sqrt(1 + 1/rho), by at most 3 overlap^(1/2)/(1 + 1/rho)^(3/2)";
        wave_number(omega, omega_d, h).filter(|q| *q > 0.0).ok_or(Error::parameter("omegas", omega_d, rule))
    }

    /// The chain.
    ///
    /// # Errors
    /// Numbers outside their rules.
    pub fn chain(&self, omega_d: f64) -> Result<Chain<f64>> {
        let depth = |i: usize| (i + 1 + ABSORBING).saturating_sub(self.sites) as f64 / ABSORBING as f64;
        let signal = Signal::sine(self.drive, omega_d, RAMP * TAU / omega_d);
        let details = Details {
            rho: (0..self.sites).map(|i| if i == 0 { 0.0 } else { self.rho }).collect(),
            dashpot: (0..self.sites).map(|i| DASHPOT * depth(i).powi(3)).collect(),
            drives: vec![Drive { site: 0, kind: DriveKind::Displacement, signal }],
            ..Details::default()
        };
        Chain::new(self.params()?, Boundary::Fixed, self.sites)?.precompressed(self.overlap)?.with(&details)
    }

    fn measured(&self) -> Range<usize> {
        NEAR..self.sites - ABSORBING - BEFORE
    }

    /// Time at which the run ends: after the ramp, twice the time that a weak wave takes to the
    /// dashpots, and the measurement. The speed of this wave is
    /// `d omega/d q = (omega_d - omega) cot(q/2)`.
    fn end(&self, omega_d: f64) -> Result<f64> {
        let (omega, q) = (self.params()?.omega(), self.weak_wave_number(omega_d)?);
        let transit = (self.sites - ABSORBING) as f64 * (0.5 * q).tan() / (omega_d - omega);
        let end = (RAMP + PERIODS as f64) * TAU / omega_d + TRANSITS * transit;
        let periods = end * omega_d / TAU;
        let rule =
            "the wave is so slow that its run takes more than 10^5 periods of the drive: farther above sqrt(1 + 1/rho)";
        require(periods <= MOST_PERIODS, "omegas", omega_d, rule).map(|()| end)
    }

    /// The wave of a frequency, with the strains of its bonds.
    ///
    /// ```
    /// use hertzchain::study::BoundaryWave;
    /// let study = BoundaryWave { drive: 0.01, ..BoundaryWave::default() };
    /// let (wave, _) = study.wave(2.01)?;
    /// assert!((wave.q / wave.q_theory.unwrap() - 1.0).abs() < 0.02 && !wave.opens);
    /// # Ok::<(), hertzchain::Error>(())
    /// ```
    ///
    /// # Errors
    /// Numbers outside their rules; a run that fails; a signal.
    pub fn wave(&self, omega_d: f64) -> Result<(LaunchedWave, Vec<BondStrain>)> {
        self.check()?;
        let (chain, end) = (self.chain(omega_d)?, self.end(omega_d)?);
        let start = State::rest(&chain).driven(&chain);
        let (count, step) = (PERIODS * SAMPLES, TAU / omega_d / SAMPLES as f64);
        let times: Vec<f64> = (1..=count).map(|k| end - (count - k) as f64 * step).collect();
        let run = Run::new(chain.clone(), start).until(end)?.method(Method::Collocation).tolerance(TOLERANCE)?;
        let (mut sums, mut least) = (vec![(0.0, Complex::default()); self.sites], f64::INFINITY);
        for (state, t) in run.at(&times)?.zip(&times) {
            let overlaps = chain.overlaps(state?.u());
            for (b, (mean, c)) in sums.iter_mut().enumerate() {
                *mean -= overlaps[b] / count as f64;
                *c -= Complex::from_polar(2.0 * overlaps[b] / count as f64, omega_d * t);
            }
            least = overlaps[self.measured()].iter().copied().fold(least, f64::min);
        }
        let strain = |b: usize| {
            let (mean, c) = sums[b];
            BondStrain { omega: omega_d, bond: b, mean, amplitude: c.norm(), angle: (sums[b + 1].1 * c.conj()).arg() }
        };
        let bonds: Vec<BondStrain> = (1..self.sites - 1).map(strain).collect();
        Ok((self.launched(omega_d, end, least, &bonds)?, bonds))
    }

    /// Mean strain, amplitude and wave number of the wave, from the strains of its bonds.
    fn launched(&self, omega: f64, end: f64, least: f64, bonds: &[BondStrain]) -> Result<LaunchedWave> {
        let measured: Vec<&BondStrain> = bonds.iter().filter(|one| self.measured().contains(&one.bond)).collect();
        // Weights of the differences of phases in the slope of a straight line through all phases,
        // by least squares. Bonds at the ends count little, so that waves which the dashpots
        // reflect cancel.
        let count = measured.len();
        let weighted = |of: &dyn Fn(&BondStrain) -> f64, k: usize| ((k + 1) * (count - k)) as f64 * of(measured[k]);
        let sum = |of: &dyn Fn(&BondStrain) -> f64| (0..count).map(|k| weighted(of, k)).sum::<f64>();
        let mean = |of: &dyn Fn(&BondStrain) -> f64| sum(of) / sum(&|_| 1.0);
        let (mean_strain, amplitude, q) = (mean(&|one| one.mean), mean(&|one| one.amplitude), mean(&|one| one.angle));
        let spread = mean(&|one| (one.amplitude / amplitude - 1.0).powi(2)).sqrt();
        let h = Averages::new(ALPHA, KAPPA)?.h(mean_strain, 0.5 * amplitude / KAPPA);
        let q_theory = wave_number(self.params()?.omega(), omega, h);
        Ok(LaunchedWave { omega, end, mean_strain, amplitude, spread, opens: least < 0.0, q, q_theory })
    }

    fn study(&self, engine: &Engine, progress: Progress<'_>) -> Result<BoundaryWaveStudy> {
        let Self { sites, drive, overlap, rho, .. } = self;
        let settings = json!({"sites": sites, "drive": drive, "overlap": overlap, "rho": rho, "tolerance": TOLERANCE});
        let grid = Grid { store: Self::STORE, study: "boundary-wave", settings };
        let swept = engine.sweep(&grid, &self.omegas, progress, |&omega_d| self.wave(omega_d))?;
        let (all, missing) = swept.found(&self.omegas, |omega_d| format!("omega = {omega_d}"))?;
        let (waves, strains): (_, Vec<_>) = all.into_iter().unzip();
        Ok(BoundaryWaveStudy { options: self.clone(), waves, strains: strains.concat(), missing })
    }
}

impl BoundaryWaveStudy {
    /// The report. Pictures: wave number and mean strain against frequency; amplitude and mean
    /// strain along the chain.
    pub fn report(&self) -> Report {
        let waves = LaunchedWave::table("boundary-wave", &self.waves).key("waves").done();
        let strains = |rows: &[BondStrain]| BondStrain::table("strains", rows).key("").done();
        let along = |label: &str, column: &str| {
            let of_waves = self.strains.chunk_by(|a, b| a.omega == b.omega);
            let line = |rows: &[BondStrain]| strains(rows).line(&format!("ω = {}", rows[0].omega), ["bond", column]);
            Panel::new(Kind::Parameter, ["bond n", label], of_waves.map(line).collect())
        };
        let over = |label: &str, lines: &[(&str, &str)]| {
            waves.panel(Kind::Parameter, ["drive frequency ω", label], "omega", lines)
        };
        let left = [
            over("wave number q", &[("measured", "q"), ("first-order wave", "q_theory")]),
            over("mean strain", &[("measured", "mean_strain")]),
        ];
        let right = [along("amplitude of the strain", "amplitude"), along("mean strain", "mean")];
        let options = &self.options;
        let caption = format!(
            "N = {} sites between walls, α = {ALPHA}, κ = {KAPPA}, ρ = {:.4}, static overlap {}. The first bead has no \
             resonator and is moved with the amplitude {}, after a ramp of {RAMP} periods; dashpots in the last {ABSORBING} \
             sites. Means and first harmonics over the last {PERIODS} periods. Theory: (eq:w_tw) with the measured \
             frequency, amplitude and mean strain. Collocation, tolerance {TOLERANCE:e}.",
            options.sites, options.rho, options.overlap, options.drive
        );
        let title = "Travelling waves launched from one end".to_owned();
        let columns = vec![Column::new("", left), Column::new("", right)];
        Report::new("boundary-wave")
            .fact("alpha", ALPHA)
            .fact("kappa", KAPPA)
            .facts(fields!(options => rho, sites))
            .fact("drive_amplitude", options.drive)
            .fact("overlap", options.overlap)
            .fact("integrator", "collocation")
            .fact("tol", TOLERANCE)
            .table(waves)
            .table(strains(&self.strains))
            .missing(&self.missing)
            .picture(Panels { title, columns, caption })
    }
}
