//! The exact solutions without contact (uncpl).
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_n, phi_n` | amplitude and phase of the oscillation of `u_n - v_n` |
//! | `b_n` | mean position; the sum formula below (constraint2) makes it as small as contacts allow |

use crate::{
    chain::{Params, Resonators, Site},
    error::{Error, Result},
};
use hertzchain_integrators::Twofold;

/// `u_n = rho/(1+rho) a_n cos(omega t + phi_n) + b_n`, `v_n = -1/(1+rho) a_n cos(omega t + phi_n) + b_n` (uncpl).
#[derive(Clone, Debug, PartialEq)]
pub struct TrivialBreather {
    params: Params,
    amplitudes: Vec<f64>,
    phases: Vec<f64>,
    means: Vec<f64>,
}

impl TrivialBreather {
    /// The breather with amplitudes `a_n >= 0` and phases `phi_n`, and gaps larger by `gap` than contacts demand:
    /// `b_n - b_{n-1} = gap + rho/(1+rho) |a_n e^{i phi_n} - a_{n-1} e^{i phi_{n-1}}|` (constraint2). The means have mean zero.
    ///
    /// # Errors
    /// No moving resonators; `amplitudes` and `phases` of different lengths; negative or non-finite numbers.
    pub fn new(params: Params, amplitudes: Vec<f64>, phases: Vec<f64>, gap: f64) -> Result<Self> {
        params.validate()?;
        if params.resonators() != Resonators::Moving {
            let rule = "a trivial breather needs moving resonators: 0 < rho < inf and kappa > 0";
            return Err(Error::parameter("rho", params.rho, rule));
        }
        if amplitudes.len() != phases.len() {
            return Err(Error::parameter("phases", phases.len(), "as many phases as amplitudes"));
        }
        if !(gap.is_finite() && gap >= 0.0) {
            return Err(Error::parameter("gap", gap, "finite and at least zero"));
        }
        if let Some(&a) = amplitudes.iter().find(|a| !(a.is_finite() && **a >= 0.0)) {
            return Err(Error::parameter("amplitude", a, "finite and at least zero"));
        }
        if let Some(&phi) = phases.iter().find(|phi| !phi.is_finite()) {
            return Err(Error::parameter("phase", phi, "a finite number"));
        }
        let mut breather = Self { means: vec![0.0; amplitudes.len()], params, amplitudes, phases };
        for n in 1..breather.means.len() {
            breather.means[n] = breather.means[n - 1] + gap + breather.least_gap(n);
        }
        let middle = breather.means.iter().sum::<f64>() / breather.means.len().max(1) as f64;
        breather.means.iter_mut().for_each(|b| *b -= middle);
        Ok(breather)
    }

    /// `rho/(1+rho)`.
    fn share(&self) -> f64 {
        1.0 / (1.0 + 1.0 / self.params.rho)
    }

    fn least_gap(&self, n: usize) -> f64 {
        let (a, before) = (self.amplitudes[n], self.amplitudes[n - 1]);
        let half = 0.5 * (self.phases[n] - self.phases[n - 1]);
        self.share() * ((a - before).powi(2) + 4.0 * a * before * half.sin().powi(2)).sqrt()
    }

    /// The state of site `n` at time `t`, exactly: the phase `omega t` is formed to twice the working precision.
    pub fn site(&self, n: usize, t: f64) -> Site<f64> {
        let omega = self.params.omega_twofold::<f64>();
        let turn = Twofold::two_pi();
        let phase = (omega * Twofold::new(t)).reduced(turn) + Twofold::new(self.phases[n]);
        let (sin, cos) = phase.reduced(turn).sin_cos();
        let (a, b) = (self.amplitudes[n], self.means[n]);
        let (u, v) = (self.share() * a, a / (1.0 + self.params.rho));
        let omega = omega.value();
        Site { u: u * cos + b, v: b - v * cos, u_dot: -omega * u * sin, v_dot: omega * v * sin }
    }
}
