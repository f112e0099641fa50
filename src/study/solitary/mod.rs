//! Solitary waves: the Hertz pulse, and its tails as resonators are switched on.

mod report;

#[cfg(feature = "plot")]
pub(crate) use report::columns as solitary_columns;
pub(crate) use report::{caption as solitary_caption, tables as solitary_tables};

#[cfg(feature = "cli")]
use super::OF_WAVE;
use super::{
    Study, Work, fit_line,
    stretches::{finished, unless_asked},
};
use crate::{
    chain::Params,
    error::{Error, Result},
    sweep::map,
    waves::{LinePulse, Search, SolitaryWave, best_ring, wake_of_line},
};
use hertzchain_integrators::Tolerance;
use std::f64::consts::PI;

/// Phases `k/(2 pi)` of resonators from site to site of the default mass ratios. At whole ones
/// there is no wake, and every ring is in resonance: its wave is not unique.
const PHASES: [f64; 25] = [
    0.75, 0.8, 0.85, 0.9, 0.94, 0.96, 0.98, 0.99, 1.01, 1.02, 1.04, 1.06, 1.1, 1.15, 1.2, 1.25, 1.3, 1.35, 1.4, 1.45,
    1.5, 1.55, 1.6, 1.7, 1.8,
];
/// Wakes of the fit, in units of the crest: smaller ones are near rounding; with larger ones the
/// pulse is no longer that of the plain chain.
const FITTED: std::ops::RangeInclusive<f64> = 1e-12..=1e-3;
/// Least `|sin(k/2)|` of the fit.
const OFF_RESONANCE: f64 = 0.1;

/// Solitary waves and their tails.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct Solitary {
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 1.2 to 5.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A", default_value = "1.5"))]
    pub alpha: f64,
    /// Spring constant of the resonators, positive.
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", default_value = "1"))]
    pub kappa: f64,
    /// Speed of the pulses, in sites per unit of time.
    ///
    /// [default: that of the pulse of overlap 1 without resonators]
    #[cfg_attr(feature = "cli", arg(long, value_name = "C"))]
    pub speed: Option<f64>,
    /// Mass ratios resonator to bead, separated by commas.
    ///
    /// Positive [default: ratios with omega/speed from 1.5 pi to 3.6 pi].
    #[cfg_attr(feature = "cli", arg(long, value_name = "A,B,..", value_delimiter = ','))]
    pub rhos: Vec<f64>,
    /// Number of sites.
    ///
    /// Length of the ring, from 8 to 60. A pulse with tails is computed on a ring that is up to
    /// three sites longer, the one that is farthest from resonance with the tails.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 20))]
    pub sites: usize,
    /// Tolerance.
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "T", default_value = "1e-14", help = Tolerance::WAVE.help(), long_help = Tolerance::WAVE.long_help(OF_WAVE))
    )]
    pub tol: f64,
}

impl Default for Solitary {
    fn default() -> Self {
        Self { alpha: 1.5, kappa: 1.0, speed: None, rhos: Vec::new(), sites: 20, tol: Search::default().tol }
    }
}

impl Study for Solitary {
    const FILES: &'static str = "Files: solitary.json, solitary.png, pulse.csv and tails.csv.";
    const STOPS: bool = true;

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(move |_, _| Ok(Box::new(self.study()?))))
    }
}

/// A pulse where resonators move.
#[derive(Clone, Debug, PartialEq)]
pub struct Tail {
    /// Mass ratio.
    pub rho: f64,
    /// `k = omega/c`.
    pub k: f64,
    /// The exact wave of the ring, if Newton's method has found it.
    pub wave: Option<SolitaryWave>,
    /// `W` of the pulse whose resonators follow their beads.
    pub line: f64,
}

/// A fit `ln(W k/(4 sin^2(k/2) g)) = constant - width k`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct TailFit {
    /// Pulses of the fit.
    pub points: usize,
    /// The constant.
    pub constant: f64,
    /// The decay, in sites.
    pub width: f64,
    /// Largest residual of the logarithm.
    pub residual: f64,
}

/// The Hertz pulse, and pulses with tails.
#[derive(Clone, Debug)]
pub struct SolitaryStudy {
    /// The options.
    pub options: Solitary,
    /// The pulse of the line.
    pub line: LinePulse,
    /// `G` at sites from the crest on, in units of the crest.
    pub decay: Vec<f64>,
    /// The exact wave of the ring without resonators.
    pub hertz: SolitaryWave,
    /// Pulses where resonators move, by mass ratio.
    pub tails: Vec<Tail>,
    /// Fit of the wakes against `k`; `None` with fewer than three that can be fitted.
    pub fit: Option<TailFit>,
}

impl Solitary {
    fn check(&self) -> Result<()> {
        Params::new(self.alpha, self.kappa, 1.0)?;
        if let Some(&rho) = self.rhos.iter().find(|rho| !(rho.is_finite() && **rho > 0.0)) {
            return Err(Error::parameter("rhos", rho, "finite and positive"));
        }
        if self.kappa == 0.0 {
            return Err(Error::parameter("kappa", self.kappa, "positive: without springs there are no resonators"));
        }
        Tolerance::WAVE.check(self.tol)?;
        if !(8..=60).contains(&self.sites) {
            return Err(Error::parameter("sites", self.sites, "from 8 to 60 for a solitary wave"));
        }
        if !(1.2..=5.0).contains(&self.alpha) {
            return Err(Error::parameter("alpha", self.alpha, "from 1.2 to 5 for a solitary wave"));
        }
        match self.speed.filter(|speed| !(speed.is_finite() && *speed > 0.0)) {
            Some(speed) => Err(Error::parameter("speed", speed, "finite and positive")),
            None => Ok(()),
        }
    }

    /// Computes the pulses.
    ///
    /// # Errors
    /// Numbers outside their rules; [`Error::Stalled`] where there is no pulse without resonators; a
    /// signal before the first tail. A later one leaves the other tails out.
    pub fn study(&self) -> Result<SolitaryStudy> {
        self.check()?;
        let (line, search) = (LinePulse::new(self.alpha), Search { tol: self.tol, ..Search::default() });
        let speed = self.speed.unwrap_or(line.coefficient());
        let plain = Params { alpha: self.alpha, kappa: 0.0, rho: 0.0 };
        let hertz = SolitaryWave::new(plain, speed, self.sites, &line, &search)?;
        let rhos = if self.rhos.is_empty() { self.default_rhos(speed) } else { self.rhos.clone() };
        let tail = |&rho: &f64| {
            let params = Params { alpha: self.alpha, kappa: self.kappa, rho };
            let sites = best_ring(params, speed, self.sites);
            unless_asked(|| {
                Ok(Tail {
                    rho,
                    k: params.omega() / speed,
                    wave: SolitaryWave::new(params, speed, sites, &line, &search).ok(),
                    line: wake_of_line(params, speed, &line),
                })
            })
        };
        let tails = finished(map(&rhos, tail))?;
        let sites = line.at_sites();
        let decay = sites.iter().map(|g| g / sites[0]).collect();
        Ok(SolitaryStudy { options: self.clone(), line, decay, hertz, fit: fit(&tails), tails })
    }

    /// Mass ratios of [`PHASES`], `rho = kappa/((k c)^2 - kappa)`; those that exist.
    fn default_rhos(&self, speed: f64) -> Vec<f64> {
        let stiffness = |phase: &f64| (2.0 * PI * phase * speed).powi(2) - self.kappa;
        PHASES.iter().map(stiffness).filter(|above| *above > 0.0).map(|above| self.kappa / above).collect()
    }
}

fn fit(tails: &[Tail]) -> Option<TailFit> {
    let point = |tail: &Tail| {
        let (wave, sin) = (tail.wave.as_ref()?, (0.5 * tail.k).sin());
        let share = wave.wake() / wave.crest();
        let used = FITTED.contains(&share) && sin.abs() >= OFF_RESONANCE;
        used.then(|| (tail.k, (share * tail.k / (4.0 * sin * sin)).ln()))
    };
    let points: Vec<(f64, f64)> = tails.iter().filter_map(point).collect();
    let (slope, residual) = fit_line(&points).filter(|_| points.len() >= 3)?;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let constant = mean(|point| point.1) - slope * mean(|point| point.0);
    Some(TailFit { points: points.len(), constant, width: -slope, residual })
}

impl SolitaryStudy {
    /// `ln|ln(g_{n+1}/g_0)| - ln|ln(g_n/g_0)|` between the last two sites; `ln alpha` in the limit.
    pub fn decay_slope(&self) -> f64 {
        let double_log = |g: &f64| g.ln().abs().ln();
        match self.decay.as_slice() {
            [.., before, last] if *before < 1.0 => double_log(last) - double_log(before),
            _ => f64::NAN,
        }
    }

    /// Largest distance of the exact wave from the pulse of the line, over all sites, in units of
    /// the crest.
    pub fn apart(&self) -> f64 {
        let (z, sites) = (&self.hertz.wave.z, self.options.sites);
        let scale = self.hertz.speed.powf(2.0 / (self.options.alpha - 1.0));
        let off = |n: usize| (-z[n] - scale * self.line.at(n.min(sites - n) as f64)[0]).abs();
        (0..sites).map(off).fold(0.0, f64::max) / self.hertz.crest()
    }
}
