//! The exact solutions without contact force (uncpl); by Theorem nobreath the only localised
//! solutions that are periodic.
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_n, phi_n` | amplitude and phase of the oscillation of `u_n - v_n` |
//! | `b_n` | mean position; `b_n - b_{n-1}` is at least `l_n` (constraint2) |
//! | `l_n` | least gap, `rho/(1+rho) |a_n e^{i phi_n} - a_{n-1} e^{i phi_{n-1}}|` |
//! | `d_n` | `b_n` minus the sum of the `l_k`, `k <= n`: nondecreasing |

use crate::{
    chain::{Boundary, Chain, Params, Resonators, Site},
    error::{Error, Result, finite, refuse, require},
};
use hertzchain_integrators::{DoubleDouble, Stats, Stepper};

/// Tolerance of gaps, in roundings of the mean positions: a `b_n` is a sum and has rounding errors.
const ROUNDINGS: f64 = 4.0;

/// `u_n = rho/(1+rho) a_n cos(omega t + phi_n) + b_n`,
/// `v_n = -1/(1+rho) a_n cos(omega t + phi_n) + b_n` (uncpl).
///
/// ```
/// use hertzchain_orbits::{breathers::TrivialBreather, chain::Params};
/// // Neighbours in antiphase: b_n = d_n + rho/(1+rho) (a_n + 2 a_{n-1} + 2 a_{n-2} + ..).
/// let params = Params::new(1.5, 1.0, 1.0)?;
/// let (a, phi) = (vec![0.2, 0.4], vec![0.0, std::f64::consts::PI]);
/// let breather = TrivialBreather::new(params, a, phi, &[0.0, 0.1])?;
/// assert!((breather.means()[0] - 0.1).abs() < 1e-15 && (breather.means()[1] - 0.5).abs() < 1e-15);
/// # Ok::<(), hertzchain_orbits::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TrivialBreather {
    params: Params,
    amplitudes: Vec<f64>,
    phases: Vec<f64>,
    means: Vec<f64>,
}

/// The lengths of two arrays that should be the same, in words for an error message.
fn counts(numbers: &[f64], amplitudes: &[f64]) -> String {
    format!("{} numbers for {} amplitudes", numbers.len(), amplitudes.len())
}

impl TrivialBreather {
    /// The breather with amplitudes `a_n >= 0`, phases `phi_n` and offsets `d_n`.
    ///
    /// `b_n = d_n + sum_{k <= n} l_k`, with `a = 0` before the first site.
    ///
    /// # Errors
    /// No moving resonators; arrays of different lengths; negative amplitudes, decreasing offsets,
    /// numbers that are not finite.
    pub fn new(params: Params, amplitudes: Vec<f64>, phases: Vec<f64>, offsets: &[f64]) -> Result<Self> {
        require(offsets.len() == amplitudes.len(), "d", counts(offsets, &amplitudes), "as many offsets as amplitudes")?;
        offsets.iter().try_for_each(|&d| finite("d", d).map(drop))?;
        let fall = (1..offsets.len()).find(|&n| offsets[n] < offsets[n - 1]);
        let fall = fall.map(|n| format!("{} after {} at site {n}", offsets[n], offsets[n - 1]));
        refuse("d", fall, "the offsets do not decrease (constraint2)")?;
        let mut breather = Self::oscillating(params, amplitudes, phases)?;
        let mut sum = 0.0;
        for (n, offset) in offsets.iter().enumerate() {
            sum += breather.least_gap(n);
            breather.means[n] = offset + sum;
        }
        Ok(breather)
    }

    /// The breather with given mean positions `b_n`.
    ///
    /// # Errors
    /// As [`new`](Self::new); a bond at which `b_n - b_{n-1}` is less than `l_n` by more than
    /// rounding errors.
    pub fn with_means(params: Params, amplitudes: Vec<f64>, phases: Vec<f64>, means: Vec<f64>) -> Result<Self> {
        require(means.len() == amplitudes.len(), "b", counts(&means, &amplitudes), "as many means as amplitudes")?;
        means.iter().try_for_each(|&b| finite("b", b).map(drop))?;
        let breather = Self { means, ..Self::oscillating(params, amplitudes, phases)? };
        let rounding = |n: usize| ROUNDINGS * f64::EPSILON * breather.means[n - 1].abs().max(breather.means[n].abs());
        match (1..breather.means.len()).find(|&n| breather.slack(n) < -rounding(n)) {
            None => Ok(breather),
            Some(n) => {
                let gap = breather.means[n] - breather.means[n - 1];
                let value = format!("{gap:e} at bond {n}, where at least {:e} is needed,", breather.least_gap(n));
                Err(Error::parameter("b_n - b_{n-1}", value, "beads may touch but not press (constraint2)"))
            }
        }
    }

    /// The breather that has the given state at time zero, if there is one: with free ends, centres
    /// of mass at rest, and gaps that satisfy (constraint2).
    pub fn of_state(chain: &Chain<f64>, y: &[f64]) -> Option<Self> {
        let (params, layout) = (chain.params(), chain.layout());
        let (v, v_dot) = (layout.v(y)?, layout.v_dot(y)?);
        if chain.boundary() != Boundary::Free {
            return None;
        }
        let (u, u_dot, rho, omega) = (layout.u(y), layout.u_dot(y), params.rho, params.omega());
        let rests = |n: usize| (u_dot[n] + rho * v_dot[n]).abs() <= 2.0 * f64::EPSILON * u_dot[n].abs();
        if !(0..u.len()).all(rests) {
            return None;
        }
        let swing = |n: usize| (u[n] - v[n], (v_dot[n] - u_dot[n]) / omega);
        let amplitudes = (0..u.len()).map(|n| swing(n).0.hypot(swing(n).1)).collect();
        let phases = (0..u.len()).map(|n| swing(n).1.atan2(swing(n).0)).collect();
        let means = (0..u.len()).map(|n| v[n] + (u[n] - v[n]) / (1.0 + rho)).collect();
        Self::with_means(params, amplitudes, phases, means).ok()
    }

    /// Checks amplitudes and phases; the mean positions are zero.
    fn oscillating(params: Params, amplitudes: Vec<f64>, phases: Vec<f64>) -> Result<Self> {
        params.validate()?;
        let rule = "a trivial breather needs moving resonators: 0 < rho < inf and kappa > 0";
        require(params.resonators() == Resonators::Moving, "rho", params.rho, rule)?;
        let rule = "as many phases as amplitudes";
        require(amplitudes.len() == phases.len(), "phases", counts(&phases, &amplitudes), rule)?;
        let odd = amplitudes.iter().find(|a| !(a.is_finite() && **a >= 0.0));
        refuse("amplitude", odd, "finite and at least zero")?;
        phases.iter().try_for_each(|&phi| finite("phase", phi).map(drop))?;
        Ok(Self { means: vec![0.0; amplitudes.len()], params, amplitudes, phases })
    }

    /// The breather moved as a whole, so that the mean of the `b_n` is zero.
    #[must_use]
    pub fn centred(mut self) -> Self {
        let middle = self.means.iter().sum::<f64>() / self.means.len().max(1) as f64;
        self.means.iter_mut().for_each(|b| *b -= middle);
        self
    }

    /// Exponent, spring constant and mass ratio.
    pub fn params(&self) -> Params {
        self.params
    }

    /// `a_n`.
    pub fn amplitudes(&self) -> &[f64] {
        &self.amplitudes
    }

    /// `phi_n`.
    pub fn phases(&self) -> &[f64] {
        &self.phases
    }

    /// `b_n`.
    pub fn means(&self) -> &[f64] {
        &self.means
    }

    /// `l_n`, the least gap of the bond to the left of site `n`, with `a = 0` before the first
    /// site.
    pub fn least_gap(&self, n: usize) -> f64 {
        let a = self.amplitudes[n];
        let Some(k) = n.checked_sub(1) else { return self.share() * a };
        let (before, half) = (self.amplitudes[k], 0.5 * (self.phases[n] - self.phases[k]));
        self.share() * (a - before).hypot(2.0 * (a * before).sqrt() * half.sin())
    }

    /// `b_n - b_{n-1} - l_n` for `n >= 1`: the distance of the beads when they are closest.
    pub fn slack(&self, n: usize) -> f64 {
        self.means[n] - self.means[n - 1] - self.least_gap(n)
    }

    /// `rho/(1+rho) a_n`, the amplitude of bead `n`.
    pub fn swing(&self, n: usize) -> f64 {
        self.share() * self.amplitudes[n]
    }

    /// `rho/(1+rho)`.
    fn share(&self) -> f64 {
        1.0 / (1.0 + 1.0 / self.params.rho)
    }

    /// The state of site `n` at time `t`, exact to rounding: the phase `omega t` is formed in twice
    /// the working precision.
    pub fn site(&self, n: usize, t: f64) -> Site<f64> {
        let omega = self.params.omega_twofold::<f64>();
        let turn = DoubleDouble::two_pi();
        let phase = (omega * DoubleDouble::new(t)).reduced(turn) + DoubleDouble::new(self.phases[n]);
        let (sin, cos) = phase.reduced(turn).sin_cos();
        let (a, b) = (self.amplitudes[n], self.means[n]);
        let (u, v) = (self.swing(n), a / (1.0 + self.params.rho));
        let omega = omega.value();
        Site { u: u * cos + b, v: b - v * cos, u_dot: -omega * u * sin, v_dot: omega * v * sin }
    }
}

/// A trivial breather as a stepper, for [`Run::observe_by`](crate::run::Run::observe_by).
///
/// One step goes to the end; samples are exact at any time.
pub struct ClosedForm<'a> {
    breather: &'a TrivialBreather,
    end: f64,
    t: f64,
}

impl<'a> ClosedForm<'a> {
    /// The stepper of a breather up to the time `end`.
    pub fn new(breather: &'a TrivialBreather, end: f64) -> Self {
        Self { breather, end, t: 0.0 }
    }
}

impl Stepper<f64> for ClosedForm<'_> {
    fn dim(&self) -> usize {
        4 * self.breather.means().len()
    }

    fn time(&self) -> f64 {
        self.t
    }

    fn done(&self) -> bool {
        self.t == self.end
    }

    fn step(&mut self) -> std::result::Result<(), hertzchain_integrators::Error> {
        self.t = self.end;
        Ok(())
    }

    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let n = self.breather.means().len();
        for i in 0..n {
            let site = self.breather.site(i, t);
            (y[i], y[n + i], y[2 * n + i], y[3 * n + i]) = (site.u, site.v, site.u_dot, site.v_dot);
        }
    }

    fn stats(&self) -> Stats {
        Stats::default()
    }
}
