//! Measurements of an orbit: states, extent, error of periodicity, multipliers.

use super::{
    floquet::{Frame, Spectrum, known},
    shooting::{Orbit, Shooting},
};
use crate::{
    chain::max_norm,
    error::{Error, Result},
    run::state_at,
};
use hertzchain_integrators::collocation::StepControl;
use serde::{Deserialize, Serialize};

/// Samples per period for the extremes; a multiple of 4.
const SAMPLES: u32 = 64;

/// Vertical centres (eq:center) and amplitudes (eq:amp) of the first site, `n = -N`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Extent {
    /// `K_x`.
    pub k_x: f64,
    /// `K_y`.
    pub k_y: f64,
    /// `C_x`.
    pub c_x: f64,
    /// `C_y`.
    pub c_y: f64,
}

impl Orbit {
    /// Strains of the contacts, `x_n(0)`.
    pub fn x(&self) -> &[f64] {
        &self.z[..self.setting.sites]
    }

    /// Strains of the resonators, `y_n(0)`; empty without them.
    pub fn y(&self) -> &[f64] {
        &self.z[self.setting.sites..]
    }

    /// `max |Z(0)|`.
    pub fn amplitude(&self) -> f64 {
        max_norm(self.z.iter().copied())
    }

    /// The state `(Z, Z')` at `t = 0`.
    pub fn start(&self) -> Vec<f64> {
        let mut start = self.z.clone();
        start.resize(2 * self.z.len(), 0.0);
        start
    }

    /// States at the given times, which increase.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn states(&self, tol: f64, times: &[f64]) -> Result<Vec<Vec<f64>>> {
        let Some(&end) = times.last() else { return Ok(Vec::new()) };
        let mut run = self.setting.chain()?.collocation(&self.start(), (0.0, end), StepControl::Tolerance(tol))?;
        times.iter().map(|&t| Ok(state_at(&mut run, t)?)).collect()
    }

    /// Centres and amplitudes of the first site: extremes of 64 samples a period, each refined by a
    /// parabola.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn extent(&self, tol: f64) -> Result<Extent> {
        // By reversibility the second half of the period repeats the first one backwards.
        let times: Vec<f64> =
            (0..=SAMPLES / 2).map(|k| self.setting.period() * f64::from(k) / f64::from(SAMPLES)).collect();
        let states = self.states(tol, &times)?;
        let [(k_x, c_x), (k_y, c_y)] = [0, self.setting.sites].map(|entry| {
            if entry >= self.z.len() {
                return (0.0, 0.0);
            }
            let mut values: Vec<f64> = states.iter().map(|state| state[entry]).collect();
            // Strains are even about both ends.
            values.insert(0, values[1]);
            values.push(values[values.len() - 2]);
            let top = values.windows(3).map(summit).fold(f64::NEG_INFINITY, f64::max);
            let bottom = -values.windows(3).map(|w| summit(&[-w[0], -w[1], -w[2]])).fold(f64::NEG_INFINITY, f64::max);
            (0.5 * (top - bottom), 0.5 * (top + bottom))
        });
        Ok(Extent { k_x, k_y, c_x, c_y })
    }

    /// `E_b(m T) = max |Z(m T) - Z(0)| / max |Z(0)|` (eq:relerr).
    ///
    /// # Errors
    /// An integration that fails.
    pub fn e_b(&self, tol: f64, periods: u32) -> Result<f64> {
        let end = self.states(tol, &[f64::from(periods) * self.setting.period()])?;
        let apart = self.z.iter().zip(&end[0]).map(|(a, b)| a - b);
        Ok(max_norm(apart) / self.amplitude())
    }

    /// The Floquet multipliers of the orbit.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    pub fn spectrum(&self, shooting: &Shooting) -> Result<Spectrum> {
        let chain = self.setting.chain()?;
        let half = shooting.flow(&chain, &self.z, 0.5 * self.setting.period(), 2 * self.z.len(), |_| {})?;
        let linear = (self.setting.params.omega() * self.setting.period()).cos();
        // Without resonators no bead turns against one.
        let known = &known(linear)[usize::from(self.y().is_empty())..];
        Spectrum::new(&Frame::at_rest(&chain), &half.columns, 0.0, known).ok_or_else(|| {
            Error::parameter("omega_b", self.setting.omega_b, "no multipliers: the eigenvalues did not converge")
        })
    }
}

/// The top of the parabola through three values if it lies next to the middle one; otherwise the
/// middle value.
fn summit(w: &[f64]) -> f64 {
    let (slope, bend) = (0.5 * (w[2] - w[0]), w[0] - 2.0 * w[1] + w[2]);
    if bend < 0.0 && slope.abs() < -0.5 * bend { w[1] - 0.5 * slope * slope / bend } else { w[1] }
}
