//! The nonlinear Schrodinger equation of a loaded chain: slow envelopes of small waves.
//!
//! | symbol | meaning |
//! |---|---|
//! | `d` | static overlap of all contacts; `(d + s)^alpha = k_1 + k_2 s + k_3 s^2 + k_4 s^3 + ..` |
//! | `theta, omega(theta)` | phase from bead to bead, and frequency: `omega^2 M(omega) = k_2 a(theta)` |
//! | `M(omega)` | `1 + rho kappa/(kappa - rho omega^2)`: bead and resonator as one mass |
//! | `a(theta)` | `2 (1 - cos theta)` |
//! | `c, omega''` | group velocity and dispersion, first and second derivative of `omega(theta)` |
//! | `A(X, T)` | `u_n = epsilon (A e^{i(theta n - omega t)} + c.c.) + ..`, `X = epsilon (n - c t)`, `T = epsilon^2 t` |
//!
//! By multiple scales, with the slow strain and the second harmonic that the wave drives,
//!
//! ```text
//! i A_T + (omega''/2) A_XX + beta |A|^2 A = 0
//! beta = (a^2/D) (-3 k_4 + 2 k_3^2 a(2 theta)/L_2 + 4 k_3^2/(k_2 - (1 + rho) c^2))
//! D = d(omega^2 M)/d omega,    L_2 = k_2 a(2 theta) - (2 omega)^2 M(2 omega)
//! ```
//!
//! The last term of `beta` is that of the slow strain. It is absent with fixed resonators, and for
//! periodic waves whose mean strain is kept: these have the frequency `omega - beta_0 |A|^2` with
//! `beta_0` without it. The equation is focusing where `omega'' beta > 0`. G. Huang & B. Hu 1998,
//! Phys. Rev. B 57, 5746 (chains without resonators); L. Liu, G. James, P. Kevrekidis & A.
//! Vainchtein 2016, Physica D 331, 27 (with resonators).

use crate::{
    chain::{Params, Resonators, Site},
    error::{Result, positive, require},
    orbits::Bands,
};

/// Coefficients of the nonlinear Schrodinger equation of a wave.
///
/// ```
/// use hertzchain_orbits::{chain::Params, waves::Nls};
/// // A loaded chain of spheres at the edge of its band: k_2 = 3/2, k_3 = 3/8, k_4 = -1/16, and
/// // beta = (16/(2 omega)) (3/16 + 4 (9/64)/(3/2)) with omega = sqrt(6).
/// let edge = Nls::new(Params::new(1.5, 0.0, 0.0)?, [1.0, 1.0], std::f64::consts::PI)?[0];
/// assert!((edge.omega - 6.0_f64.sqrt()).abs() < 1e-14);
/// assert!((edge.nonlinearity - 8.0 / edge.omega * (3.0 / 16.0 + 0.375)).abs() < 1e-13);
/// assert!(!edge.focusing());
/// # Ok::<(), hertzchain_orbits::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nls {
    /// `theta`.
    pub theta: f64,
    /// `omega(theta)`.
    pub omega: f64,
    /// Displacement of a resonator over that of its bead, `kappa/(kappa - rho omega^2)`; 0 where
    /// resonators are fixed, 1 where there are none.
    pub resonator: f64,
    /// `c`.
    pub group_velocity: f64,
    /// `omega''`.
    pub dispersion: f64,
    /// `beta`; not finite where the wave is in resonance with its second harmonic or with long
    /// waves.
    pub nonlinearity: f64,
    /// `beta_0`: that of periodic waves whose mean strain is kept.
    pub at_mean_strain: f64,
}

impl Bands {
    /// The nonlinear Schrodinger equation of each band at a phase in `(0, pi]`, and the static
    /// overlap; `None` for a cell of more than one bead.
    pub fn envelopes(&self, theta: f64) -> Option<(f64, Vec<Nls>)> {
        let (params, bond) = self.alike?;
        Some((bond[1], Nls::new(params, bond, theta).ok()?))
    }
}

impl Nls {
    /// Of each band of a chain of equal beads of mass 1, the lowest first, at the phase `theta` in
    /// `(0, pi]`. Contacts have the force `contact (overlap + s)^alpha`, with both numbers
    /// positive.
    ///
    /// # Errors
    /// Parameters, an overlap or a phase outside their rules.
    pub fn new(params: Params, [contact, overlap]: [f64; 2], theta: f64) -> Result<Vec<Self>> {
        params.validate()?;
        positive("contact", contact)?;
        positive("overlap", overlap)?;
        let pi = std::f64::consts::PI;
        require(theta > 0.0 && theta <= pi, "theta", theta, "above 0 and at most pi")?;
        let Params { alpha, kappa, rho } = params;
        let k2 = contact * alpha * overlap.powf(alpha - 1.0);
        let k3 = k2 * (alpha - 1.0) / (2.0 * overlap);
        let k4 = k3 * (alpha - 2.0) / (3.0 * overlap);
        // `w M` as a function of `w = omega^2`, with its first and second derivative.
        let inertia = |w: f64| match params.resonators() {
            Resonators::None => [w, 1.0, 0.0],
            Resonators::Fixed => [w - kappa, 1.0, 0.0],
            Resonators::Moving => {
                let per = 1.0 / (kappa - rho * w);
                let first = rho * (kappa * per).powi(2);
                [w + w * rho * kappa * per, 1.0 + first, 2.0 * first * rho * per]
            }
        };
        let a = |theta: f64| 4.0 * (0.5 * theta).sin().powi(2);
        let push = k2 * a(theta);
        let squares = match params.resonators() {
            Resonators::None => vec![push],
            Resonators::Fixed => vec![push + kappa],
            Resonators::Moving => {
                // rho w^2 - b w + kappa push = 0
                let b = kappa + rho * (push + kappa);
                let root = b + (b * b - 4.0 * rho * kappa * push).sqrt();
                vec![2.0 * kappa * push / root, root / (2.0 * rho)]
            }
        };
        let of = |w: f64| {
            let omega = w.sqrt();
            let [_, first, second] = inertia(w);
            let slope = 2.0 * k2 * theta.sin() / first;
            let bend = (2.0 * k2 * theta.cos() - second * slope * slope) / first;
            let c = slope / (2.0 * omega);
            let twice = a(2.0 * theta);
            let by_harmonic = 2.0 * k3 * k3 * twice / (k2 * twice - inertia(4.0 * w)[0]);
            let by_strain =
                if params.resonators() == Resonators::Fixed { 0.0 } else { 4.0 * k3 * k3 / (k2 - (1.0 + rho) * c * c) };
            let share = a(theta).powi(2) / (2.0 * omega * first);
            let at_mean_strain = share * (by_harmonic - 3.0 * k4);
            let resonator = match params.resonators() {
                Resonators::Fixed => 0.0,
                Resonators::None => 1.0,
                Resonators::Moving => kappa / (kappa - rho * w),
            };
            Self {
                theta,
                omega,
                resonator,
                group_velocity: c,
                dispersion: (0.5 * bend - c * c) / omega,
                nonlinearity: at_mean_strain + share * by_strain,
                at_mean_strain,
            }
        };
        Ok(squares.into_iter().map(of).collect())
    }

    /// Whether `omega'' beta > 0`: plane waves are unstable, and envelopes are bright.
    pub fn focusing(&self) -> bool {
        self.dispersion * self.nonlinearity > 0.0
    }

    /// A soliton of the equation, to first order: bright where it is focusing, dark elsewhere.
    ///
    /// # Errors
    /// An amplitude that is not finite and positive; no dispersion, or no nonlinearity.
    pub fn soliton(&self, amplitude: f64) -> Result<Soliton> {
        positive("amplitude", amplitude)?;
        let per_width = 0.5 * amplitude * (self.nonlinearity / self.dispersion).abs().sqrt();
        let rule = "a soliton needs a wave with dispersion and nonlinearity, out of resonance";
        require(per_width.is_finite() && per_width > 0.0, "theta", self.theta, rule)?;
        Ok(Soliton { wave: *self, amplitude, per_width })
    }
}

/// A soliton of the nonlinear Schrodinger equation.
///
/// With `h = amplitude/2`, `s = h |beta/omega''|^{1/2}` and `x = n - c t`, displacements are
///
/// ```text
/// bright:  2 h sech(s x) cos(theta n - (omega - beta h^2/2) t)
/// dark:    2 h tanh(s x) cos(theta n - (omega - beta_0 h^2) t)
/// ```
///
/// and those of resonators are proportional; far from a dark one the mean strain is that of the
/// chain at rest. Strains of the chain differ from these by a part that is proportional to `h`
/// (`tests/experiments/nls.rs`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Soliton {
    wave: Nls,
    amplitude: f64,
    per_width: f64,
}

impl Soliton {
    /// `1/s`, in sites.
    pub fn width(&self) -> f64 {
        1.0 / self.per_width
    }

    /// The site at a distance `n` from the centre, at time `t`.
    pub fn site(&self, n: f64, t: f64) -> Site<f64> {
        let Self { wave, amplitude, per_width } = *self;
        let x = per_width * (n - wave.group_velocity * t);
        let (share, slope, shift) = match wave.focusing() {
            true => (1.0 / x.cosh(), -x.tanh() / x.cosh(), 0.5 * wave.nonlinearity),
            false => (x.tanh(), x.cosh().powi(-2), wave.at_mean_strain),
        };
        let omega = wave.omega - shift * (0.5 * amplitude).powi(2);
        let (sin, cos) = (wave.theta * n - omega * t).sin_cos();
        let u = amplitude * share * cos;
        let u_dot = amplitude * (omega * share * sin - wave.group_velocity * per_width * slope * cos);
        Site { u, v: wave.resonator * u, u_dot, v_dot: wave.resonator * u_dot }
    }
}
