//! Modulational stability of travelling waves, in closed form (Sec. 4; left open in Sec. 8).
//!
//! | symbol | meaning |
//! |---|---|
//! | `q, a, b` | wave number, amplitude, mean strain of the wave (eq:An_tw) |
//! | `Omega` | slow frequency of the wave (disp) |
//! | `p` | wave number of the perturbation, `2 pi j / N` on a ring of `N` sites |
//! | `sigma` | `h_alpha(b, a) / (2 omega^3)`, the coupling of a bond; `Omega = K(q) sigma` |
//! | `s` | `d ln sigma / d ln r` at `r = a`, the mean force `g_alpha(b, r)` held fixed |
//! | `K(k)` | `4 sin^2(k/2)`; `K_- = K(q-p)`, `K_+ = K(q+p)` |
//! | `lambda` | eigenvalue, per unit of the slow time `tau` |
//!
//! # The linear problem
//!
//! Let `D_n = (a + w_n) e^{i (Omega tau - q n)}` and `b_n = b + beta_n` in (eq:S1newS), (eq:S2new).
//! To first order the force in a bond changes by `g_b beta_n + g_r Re w_n`, which is the same for
//! all `n`. It is therefore zero for all perturbations that are not uniform, whether the force or
//! the mean strain of the ring is given. So `beta_n = -(g_r / g_b) Re w_n`, and `sigma` changes by
//! `s (sigma/a) Re w_n` with `s = (a/h) (h_r - h_b g_r / g_b)`. With
//! `w_n = U e^{ipn} + conj(V) e^{-ipn}` this is
//!
//! ```text
//! dU/dtau = -i alpha_- U + i (s sigma/2) K_- V        alpha_-+ = Omega - (1 + s/2) sigma K_-+
//! dV/dtau =  i alpha_+ V - i (s sigma/2) K_+ U
//! ```
//!
//! whose eigenvalues are `lambda = -i sigma (2 + s) sin q sin p +- sqrt(Q)`, with
//! `K_+ K_- = 4 (cos p - cos q)^2`, `K_+ + K_- = 4 (1 - cos p cos q)` and a difference of squares:
//!
//! ```text
//! Q = -16 sigma^2 sin^2(p/2) [cos q + s cos^2(q/2)] [cos q sin^2(p/2) + s sin^2(q/2) cos^2(p/2)]
//! ```
//!
//! A uniform perturbation (`p = 0`) has `lambda = 0` twice. One is a shift of the phase. The other
//! changes the amplitude and with it `Omega`, so that the phase grows like `tau`, not
//! exponentially: by `s` as above for a given force, and by `a h_r / h` in place of `s` for a given
//! mean strain.
//!
//! # Consequences
//!
//! - The wave is unstable if and only if `s cos q < 0` and `cos q + s cos^2(q/2) != 0`.
//! - Let the wave be unstable, and `tan(p_c/2) = sqrt(-s / cos q) |sin(q/2)|`. If
//!   `s (cos q + s cos^2(q/2)) < 0`, the discriminant at `p -> 0` is positive: long waves grow,
//!   with `0 < p < p_c`, and the fastest has `sin^2(p/2) = sin^2(p_c/2) / 2`. Otherwise short waves
//!   grow, with `p_c < p <= pi`, and the fastest has `p = pi`.
//! - `s = (<cos^2> - <cos>^2) / <sin^2> - 1`, where the means have the weight
//!   `(2 kappa a cos t - b)_+^{alpha-1}`. So `s > -1`, and `s` depends on `alpha` and
//!   `b / (2 kappa a)` only. Known values: at `b = 0`, `alpha - 1 - (alpha+1) <cos>^2` with
//!   `<cos> = Gamma((alpha+1)/2)^2 / (Gamma(alpha/2) Gamma(alpha/2 + 1))`; at `b = -2 kappa a`,
//!   `1/alpha - 1`; for `b -> -inf`, about `-alpha (alpha-1) / 4 (2 kappa a / b)^2`, where the
//!   chain is linear and each wave neutral; for `b -> 2 kappa a`, `-1`. On a grid `s` is negative
//!   for all `alpha > 1` (there is no proof): a larger amplitude pushes beads apart until the mean
//!   force has its old value, which weakens the contacts. So waves with `|q| > pi/2` are stable,
//!   and those with `|q| < pi/2` are unstable.
//! - `rho` and `kappa` change rates, not stability. `rho` enters only through `omega^3` in `sigma`:
//!   `lambda` is proportional to `(1 + 1/rho)^{-3/2}`. The growth `epsilon^{alpha-1} lambda` per
//!   unit of `t` is `kappa^{-1/2} X^{alpha-1} (1 + 1/rho)^{-3/2}` times a function of
//!   `q, p, alpha, b / (2 kappa a)`, where `X = 2 kappa epsilon a` is the amplitude of the strain.
//!   So `lambda / Omega` depends on these four numbers alone.
//! - The force is the same in each bond only if the mean strains follow it at once. They have the
//!   inertia of beads and resonators: in the full chain
//!   `(1 + rho) epsilon^{alpha-1} d^2 beta/dtau^2 = -delta^+ delta^- (g_b beta_n + g_r Re w_n)`. So
//!   `(1 + rho) epsilon^{alpha-1} |lambda|^2` must be small compared with `K(p) |g_b|`: for heavy
//!   resonators only very small waves obey this theory.
//! - The DpS equation of Newton's cradle (`rho = inf`, eq:DpSlr) has no mean strain,
//!   `sigma = omega_0 a^{alpha-1}` and `s = alpha - 1 > 0`; there the waves with `|q| > pi/2` are
//!   unstable.

use super::{Shape, Size, TravellingWave};
use crate::{
    chain::{Params, Resonators},
    dps::Averages,
    error::{Result, require},
};
use std::f64::consts::PI;

/// An eigenvalue `growth + i frequency`, per unit of the slow time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigenvalue {
    /// Real part.
    pub growth: f64,
    /// Imaginary part.
    pub frequency: f64,
}

/// The perturbations of a wave that grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModulationStability {
    /// No perturbation grows.
    Neutral,
    /// Perturbations with wave numbers from zero to an edge grow.
    LongWaves,
    /// Perturbations with wave numbers from an edge to `pi` grow.
    ShortWaves,
}

impl ModulationStability {
    /// The verdict in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Neutral => "neutrally stable",
            Self::LongWaves => "unstable to long waves",
            Self::ShortWaves => "unstable to short waves",
        }
    }
}

/// The linear problem of small modulations of a travelling wave.
///
/// ```
/// use hertzchain_orbits::{chain::Params, waves::{Modulation, Shape, ModulationStability}};
/// use std::f64::consts::PI;
/// let params = Params::new(1.5, 1.0, 3.0)?;
/// let wave = |q| Modulation::new(params, Shape { q, a: 1.0, b: 1.0, phi: 0.0 });
/// // The waves of the paper: q = 4 pi/5 is neutral; q = pi/5 is unstable, fastest at p = pi.
/// assert_eq!(wave(0.8 * PI)?.verdict(), ModulationStability::Neutral);
/// assert_eq!(wave(0.2 * PI)?.verdict(), ModulationStability::ShortWaves);
/// assert_eq!(wave(0.2 * PI)?.fastest().unwrap().0, PI);
/// # Ok::<(), hertzchain_orbits::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulation {
    shape: Shape,
    sigma: f64,
    slope: f64,
    mean_slope: f64,
    /// `cos q`.
    cos_q: f64,
}

impl Modulation {
    /// The problem for a wave of the given shape; for `rho = inf`, that of the DpS equation of
    /// Newton's cradle.
    ///
    /// # Errors
    /// As [`TravellingWave::new`] for parameters and shape, except that `rho = inf` is allowed with
    /// `b = 0`; `alpha > 10`; a coupling or a slope that is not a normal number: `b` too near
    /// `2 kappa a`, or at `-2 kappa a` for `alpha <= 1/2`.
    pub fn new(params: Params, shape: Shape) -> Result<Self> {
        let Shape { q, a, b, .. } = shape;
        let fixed = params.resonators() == Resonators::Fixed;
        // Waves of the cradle have the same rules for the shape.
        params.validate()?;
        TravellingWave::new(if fixed { Params { rho: 1.0, ..params } } else { params }, shape, Size::Epsilon(1.0))?;
        require(!fixed || b == 0.0, "b", b, "the DpS equation of rho = inf has no mean strain: b = 0")?;
        let values = Averages::new(params.alpha, params.kappa)?.checked(b, a)?;
        let sigma = values.h / (2.0 * params.omega().powi(3));
        let mean_slope = if fixed { 0.0 } else { -values.dg_dr / values.dg_db };
        let slope = a / values.h * (values.dh_dr + values.dh_db * mean_slope);
        let rule = "the slopes of g_alpha and h_alpha at (b, a) are normal numbers: b is not too near 2 kappa a, nor at -2 kappa a for alpha <= 1/2";
        require(sigma.is_normal() && slope.is_finite() && mean_slope.is_finite(), "b", b, rule)?;
        Ok(Self { shape, sigma, slope, mean_slope, cos_q: cosine(q) })
    }

    /// The problem for a wave of the same amplitude and mean strain with another, finite wave
    /// number.
    pub fn at(&self, q: f64) -> Self {
        Self { shape: Shape { q, ..self.shape }, cos_q: cosine(q), ..*self }
    }

    /// The shape of the wave.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// `sigma = h_alpha(b, a) / (2 omega^3)`.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// `s = d ln sigma / d ln r` at `r = a`, at fixed mean force.
    ///
    /// As `b -> 2 kappa a` it is the difference of two large slopes: the relative error grows like
    /// a rounding divided by `1 - b / (2 kappa a)`.
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// `db/dr = -g_r / g_b` at `r = a`, at fixed mean force.
    pub fn mean_slope(&self) -> f64 {
        self.mean_slope
    }

    /// `Omega = 4 sigma sin^2(q/2)`, the slow frequency of the wave (disp).
    pub fn slow_frequency(&self) -> f64 {
        self.sigma * chord(self.shape.q)
    }

    /// `cos q + s cos^2(q/2)`, the factor that does not depend on `p`.
    fn wave_factor(&self) -> f64 {
        self.cos_q + self.slope * (0.5 * self.shape.q).cos().powi(2)
    }

    /// `Q`, the square of the growth where it is positive.
    fn discriminant(&self, p: f64) -> f64 {
        let (sin2_p, sin2_q) = ((0.5 * p).sin().powi(2), (0.5 * self.shape.q).sin().powi(2));
        let perturbation = self.cos_q * sin2_p + self.slope * sin2_q * (0.5 * p).cos().powi(2);
        -16.0 * self.sigma.powi(2) * sin2_p * self.wave_factor() * perturbation
    }

    /// The two eigenvalues at wave number `p`: the growing one first; if none grows, that with the
    /// larger signed frequency first.
    ///
    /// `lambda(-p) = conj(lambda(p))`, and if `lambda` is an eigenvalue, so is `-conj(lambda)`. At
    /// `p = 0` both are zero.
    pub fn eigenvalues(&self, p: f64) -> [Eigenvalue; 2] {
        let (q, root) = (self.shape.q, self.discriminant(p).abs().sqrt());
        let frequency = -self.sigma * (2.0 + self.slope) * q.sin() * p.sin();
        [1.0, -1.0].map(|sign| {
            if self.discriminant(p) > 0.0 {
                Eigenvalue { growth: sign * root, frequency }
            } else {
                Eigenvalue { growth: 0.0, frequency: frequency + sign * root }
            }
        })
    }

    /// The growth rate at wave number `p`: the larger real part, zero where nothing grows.
    pub fn growth(&self, p: f64) -> f64 {
        self.eigenvalues(p)[0].growth
    }

    /// The kind of perturbations that grow on an infinite chain.
    pub fn verdict(&self) -> ModulationStability {
        let factor = self.wave_factor();
        // For a uniform wave the band of growing long waves is empty.
        let uniform = (0.5 * self.shape.q).sin() == 0.0;
        match () {
            () if self.slope * self.cos_q >= 0.0 || factor == 0.0 => ModulationStability::Neutral,
            () if self.slope * factor > 0.0 => ModulationStability::ShortWaves,
            () if uniform => ModulationStability::Neutral,
            () => ModulationStability::LongWaves,
        }
    }

    /// The ends of the band of growing wave numbers in `[0, pi]`, if there is one. The ends `0` and
    /// `p_c` do not grow themselves; `pi` does.
    pub fn band(&self) -> Option<(f64, f64)> {
        let edge = || 2.0 * ((-self.slope / self.cos_q).sqrt() * (0.5 * self.shape.q).sin().abs()).atan();
        match self.verdict() {
            ModulationStability::Neutral => None,
            ModulationStability::LongWaves => Some((0.0, edge())),
            ModulationStability::ShortWaves => Some((edge(), PI)),
        }
    }

    /// The fastest growing wave number in `[0, pi]` and its growth rate, if there is a growing one.
    pub fn fastest(&self) -> Option<(f64, f64)> {
        let (from, to) = self.band()?;
        // The square of the growth rate is a parabola in sin^2(p/2).
        let p = if from > 0.0 { PI } else { 2.0 * ((0.5 * to).sin() * 0.5_f64.sqrt()).asin() };
        Some((p, self.growth(p)))
    }

    /// The real matrix `M` of `d(U, V)/dtau = i M (U, V)`, by rows.
    pub(super) fn matrix(&self, p: f64) -> [[f64; 2]; 2] {
        let [minus, plus] = [-1.0, 1.0].map(|sign| self.sigma * chord(self.shape.q + sign * p));
        let (omega, s) = (self.slow_frequency(), self.slope);
        [[(1.0 + 0.5 * s) * minus - omega, 0.5 * s * minus], [-0.5 * s * plus, omega - (1.0 + 0.5 * s) * plus]]
    }
}

/// `cos q`, and zero where it is at most the rounding error of `q`, since its square root would
/// look like a growth rate.
fn cosine(q: f64) -> f64 {
    if q.cos().abs() <= f64::EPSILON * q.abs() { 0.0 } else { q.cos() }
}

/// `4 sin^2(k/2)`.
fn chord(k: f64) -> f64 {
    4.0 * (0.5 * k).sin().powi(2)
}
