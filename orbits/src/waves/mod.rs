//! Time-periodic travelling waves of the strain ring, to first order (Sec. 4).
//!
//! | symbol | meaning |
//! |---|---|
//! | `q, a, b, phi` | wave number, amplitude, mean strain, phase of (eq:An_tw) |
//! | `epsilon` | size: `x_n` has the mean `epsilon b` and the amplitude `2 kappa epsilon a` |
//! | `omega_tw` | frequency of the wave (eq:w_tw) |

pub(crate) mod exact;
mod modes;
mod nls;
mod perturbed;
mod solitary;
mod stability;

pub use exact::Start;
pub use exact::{
    ExactWave, Given, MeanStrain, Profile, Search, WaveBase, WaveBranch, WaveContinuation, WaveKind, WaveMeasures,
    WaveMultiplier, WaveNumber, WaveParameter, WavePoint, WaveQuality, WaveSetting, WaveSpectrum, ansatz,
};
pub use modes::Mode;
pub use modes::strains;
pub use nls::{Nls, Soliton};
pub use perturbed::PerturbedWave;
pub use solitary::{LinePulse, SolitaryWave, best_ring, wake_of_line};
pub use stability::{Eigenvalue, Modulation, ModulationStability};

use crate::{
    chain::{Params, Resonators, Site, max_norm},
    dps::Averages,
    error::{Error, Result, finite, require},
};
use std::f64::consts::PI;

/// A wave `x_n = epsilon b + 2 kappa epsilon a cos(n q - omega_tw t + phi)` (eq:xytw_app).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TravellingWave {
    params: Params,
    shape: Shape,
    epsilon: f64,
    omega_tw: f64,
}

/// The numbers of a wave except for its size.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Shape {
    /// Wave number, radians per site.
    pub q: f64,
    /// Amplitude `a > 0`.
    pub a: f64,
    /// Mean strain `b < 2 kappa a`.
    pub b: f64,
    /// Phase.
    pub phi: f64,
}

/// The number that determines the size of a wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// The size `epsilon`.
    Epsilon(f64),
    /// The detuning `omega_tw - omega > 0`.
    Detuning(f64),
}

/// `2 sin^2(q/2) h_alpha(b, a) / omega^3`, the detuning of a wave of size 1 (eq:w_tw).
fn detuning(omega: f64, q: f64, h_alpha: f64) -> f64 {
    2.0 / omega.powi(3) * (0.5 * q).sin().powi(2) * h_alpha
}

impl TravellingWave {
    /// The wave of the given shape and size, where `epsilon` and `omega_tw` satisfy (eq:w_tw):
    /// `omega_tw = omega + 2 epsilon^{alpha-1} / omega^3 sin^2(q/2) h_alpha(b, a)`.
    ///
    /// The paper prints `kappa omega^3` for `omega^3`; the two agree at `kappa = 1`.
    ///
    /// # Errors
    /// No moving resonators; a detuning with `alpha = 1` (the frequency does not depend on the
    /// size) or with `q = 0`; a number that is not finite or outside its rule.
    pub fn new(params: Params, shape: Shape, size: Size) -> Result<Self> {
        params.validate()?;
        let rule = "travelling waves need resonators: 0 < rho < inf, kappa > 0";
        require(params.resonators() == Resonators::Moving, "rho", params.rho, rule)?;
        let Shape { q, a, b, phi } = shape;
        [("q", q), ("b", b), ("phi", phi)].into_iter().try_for_each(|(name, value)| finite(name, value).map(drop))?;
        require(q.abs() <= PI, "q", q, "the wave number is from -pi to pi: a lattice knows no other")?;
        require(a.is_finite() && a > 0.0, "a", a, "the amplitude is finite and positive")?;
        let rule = "the mean strain is below 2 kappa a, or no contact ever closes";
        require(b < 2.0 * params.kappa * a, "b", b, rule)?;
        let omega = params.omega();
        let h_alpha = Averages::new(params.alpha, params.kappa)?.h(b, a);
        let per_size = detuning(omega, q, h_alpha);
        let power = params.alpha - 1.0;
        let (epsilon, detuning) = match size {
            Size::Epsilon(epsilon) if epsilon.is_finite() && epsilon > 0.0 => (epsilon, per_size * epsilon.powf(power)),
            Size::Epsilon(epsilon) => return Err(Error::parameter("epsilon", epsilon, "finite and positive")),
            Size::Detuning(d) if d.is_finite() && d > 0.0 && power != 0.0 && per_size > 0.0 => {
                ((d / per_size).powf(power.recip()), d)
            }
            Size::Detuning(d) => {
                let rule = "finite and positive, with alpha != 1 and sin(q/2) != 0, or no epsilon has this frequency";
                return Err(Error::parameter("detuning", d, rule));
            }
        };
        let rule = "the size of the wave is a normal number";
        require(epsilon.is_normal() && detuning.is_finite(), "epsilon", epsilon, rule)?;
        Ok(Self { params, shape, epsilon, omega_tw: omega + detuning })
    }

    /// Exponent, spring constant and mass ratio of the chain.
    pub fn params(&self) -> Params {
        self.params
    }

    /// Wave number, amplitude, mean strain and phase.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The slow time `epsilon^{alpha-1} t`.
    pub fn slow_time(&self, t: f64) -> f64 {
        self.epsilon.powf(self.params.alpha - 1.0) * t
    }

    /// `epsilon`.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// `omega_tw` (eq:w_tw).
    pub fn omega_tw(&self) -> f64 {
        self.omega_tw
    }

    /// The amplitude of the strain about its mean, `2 epsilon kappa a`.
    pub fn amplitude(&self) -> f64 {
        2.0 * self.epsilon * self.params.kappa * self.shape.a
    }

    /// The strains of site `n` at time `t` and their rates (eq:xytw_app); at `t = 0` the initial
    /// data (eq:ini_tw).
    pub fn site(&self, n: usize, t: f64) -> Site<f64> {
        let Shape { q, b, phi, .. } = self.shape;
        let (sin, cos) = (n as f64 * q - self.omega_tw * t + phi).sin_cos();
        let (mean, x, rho) = (self.epsilon * b, self.amplitude(), self.params.rho);
        let rate = self.omega_tw * x * sin;
        Site { u: mean + x * cos, v: mean - x / rho * cos, u_dot: rate, v_dot: -rate / rho }
    }

    /// The relative errors `(E_x, E_y)` of the ansatz at time `t` with respect to strains `x, y`
    /// (eq:relerr_tw).
    pub fn errors(&self, t: f64, x: &[f64], y: &[f64]) -> (f64, f64) {
        let largest = |values: &[f64], ansatz: fn(Site<f64>) -> f64| {
            max_norm(values.iter().enumerate().map(|(n, value)| ansatz(self.site(n, t)) - value))
        };
        let scale = self.amplitude();
        (largest(x, |site| site.u) / scale, largest(y, |site| site.v) * self.params.rho / scale)
    }
}
