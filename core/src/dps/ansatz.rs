//! Maps between the modulation envelope and the state of the chain.
//!
//! | symbol | meaning |
//! |---|---|
//! | `epsilon` | size of the oscillations |
//! | `tau` | slow time `epsilon^{alpha-1} t` |
//! | `Z_n, M_n` | strain form: `delta^- A_n, delta^- B_n`; displacement form: `A_n, B_n` |
//! | `T` | `2 pi / omega`, the period of the linear oscillation |
//!
//! # Envelope to chain
//!
//! (eq:xy_app) and its exact derivative in `t` (eq:xy_v_app), in which "c.c." belongs to the terms
//! with `Z` only:
//!
//! ```text
//! x_n = epsilon (M_n + kappa (Z_n e^{i omega t} + c.c.))
//! y_n = epsilon (M_n - kappa/rho (Z_n e^{i omega t} + c.c.))
//! ```
//!
//! `dZ/dtau` is the right side of the flow. `dM/dtau` follows from the constraint on the `b_n`,
//! differentiated ([`Dps::mean_strain_rates`]).
//!
//! A chain that starts from the ansatz departs from it by `epsilon^{alpha-1}`, relative to the
//! oscillation, up to a fixed `t`, but by `epsilon^{(alpha-1)/2}` up to a fixed `tau`: in the next
//! order the mean strains have a velocity of size `epsilon^{alpha-1}`, and without that velocity
//! they swing about the constraint at a frequency of order `epsilon^{(alpha-1)/2}`. With resonators
//! `rho` times heavier these swings are `rho` times larger relative to `y`.
//!
//! # Chain to envelope
//!
//! Two combinations of `x` and `y` separate `Z` from `M` in the ansatz:
//! `x - y = epsilon omega^2 (Z e^{i omega t} + c.c.)` and `(x + rho y) / (1 + rho) = epsilon M`.
//! [`project`] integrates the first against `e^{-i omega t}` and the second against 1 over a
//! period, and averages over all periods that contain the time: in sum a triangular weight over two
//! periods. Its transform has a double zero at each harmonic, so slopes of the envelope cause no
//! error. Curvature causes an error of `epsilon^{2 (alpha-1)} T^2/12` times `d^2/dtau^2` of `M`,
//! and of `Z - 3/(4 pi^2) conj(Z) e^{-2 i omega t}`. The projection therefore inverts the ansatz to
//! the order `epsilon^{2 (alpha-1)}`. A *chain* follows the ansatz to the order `epsilon^{alpha-1}`
//! only, and its envelope is defined no better than that.

use super::{Constraint, Dps, Ends, Form, Layout};
use crate::{
    chain::{Params, Resonators, Site},
    error::{Error, Result, require},
};
use hertzchain_integrators::VectorField;
use num_complex::Complex64;
use std::f64::consts::PI;

/// The first-order chain state of an envelope of given size.
///
/// ```
/// use hertzchain_core::{chain::Params, dps::{Ansatz, Constraint, Ends, Form, Layout}};
/// let layout = Layout { sites: 2, ends: Ends::Ring, form: Form::Strains };
/// let (params, constraint) = (Params::new(1.5, 1.0, 1.0)?, Constraint::MeanStrain(0.5));
/// let mut ansatz = Ansatz::generalised(params, constraint, layout, 0.01)?;
/// // D = (1, -1): x = epsilon (1/2 +- 2), y = epsilon (1/2 -+ 2).
/// let sites = ansatz.sites(0.0, &[1.0, -1.0, 0.0, 0.0]);
/// assert!((sites[0].u - 0.025).abs() < 1e-15 && (sites[0].v + 0.015).abs() < 1e-15);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
pub struct Ansatz {
    params: Params,
    layout: Layout,
    epsilon: f64,
    dps: Dps,
}

impl Ansatz {
    /// The ansatz whose envelope obeys the generalised DpS equations (eq:xy_app).
    ///
    /// # Errors
    /// As [`Dps::generalised`]; `epsilon` not finite and positive; displacements on a ring, unless
    /// the constraint is `MeanStrain(0)`.
    pub fn generalised(params: Params, constraint: Constraint, layout: Layout, epsilon: f64) -> Result<Self> {
        if layout.form == Form::Displacements && layout.ends == Ends::Ring && constraint != Constraint::MeanStrain(0.0)
        {
            let rule = "displacements of a ring have strains with sum zero: give the mean strain 0";
            let given = match constraint {
                Constraint::Force(force) => format!("mean force {force}"),
                Constraint::MeanStrain(strain) => format!("mean strain {strain}"),
            };
            return Err(Error::parameter("constraint", given, rule));
        }
        Self::new(params, layout, epsilon, Dps::generalised(params, constraint, layout)?)
    }

    /// The ansatz of Newton's cradle, whose envelope obeys the DpS equation.
    ///
    /// `u_n = epsilon kappa (A_n e^{i omega t} + c.c.)` with `omega = sqrt(kappa)` (eq:approx_zn);
    /// the resonators are at rest.
    ///
    /// # Errors
    /// As [`Dps::plain`]; `epsilon` not finite and positive.
    pub fn plain(alpha: f64, kappa: f64, layout: Layout, epsilon: f64) -> Result<Self> {
        Self::new(Params::new(alpha, kappa, f64::INFINITY)?, layout, epsilon, Dps::plain(alpha, kappa, layout)?)
    }

    fn new(params: Params, layout: Layout, epsilon: f64, dps: Dps) -> Result<Self> {
        let rule = "the size of the oscillations is finite and positive";
        require(epsilon.is_finite() && epsilon > 0.0, "epsilon", epsilon, rule)?;
        Ok(Self { params, layout, epsilon, dps })
    }

    /// The slow time `tau = epsilon^{alpha-1} t`.
    pub fn slow_time(&self, t: f64) -> f64 {
        self.epsilon.powf(self.params.alpha - 1.0) * t
    }

    /// The state of the chain at time `t` (eq:xy_app), (eq:xy_v_app), from the state `z` of the
    /// flow at [`slow_time`](Self::slow_time)`(t)`.
    ///
    /// The sites hold strains `x, y` in the strain form and displacements otherwise; the mean
    /// displacements `B_n` have sum zero.
    ///
    /// # Panics
    /// If `z` is not of the length of the flow's state.
    pub fn sites(&mut self, t: f64, z: &[f64]) -> Vec<Site<f64>> {
        let mut dz = vec![0.0; self.dps.dim()];
        self.dps.eval(0.0, z, &mut dz);
        let rates = self.dps.mean_strain_rates(z, &dz);
        let strains = self.dps.mean_strains(z).to_vec();
        let (means, rates) = match self.layout.form {
            Form::Strains => (strains, rates),
            Form::Displacements => (self.layout.stacked(&strains), self.layout.stacked(&rates)),
        };
        let count = means.len();
        let complex = |z: &[f64], n: usize| Complex64::new(z[n], z[count + n]);
        let site = |n: usize| {
            let amplitude = [complex(z, n), complex(&dz, n)];
            first_order(self.params, self.epsilon, t, amplitude, [means[n], rates[n]])
        };
        (0..count).map(site).collect()
    }
}

/// State of one site at time `t`, from `Z`, `M` and their slow derivatives.
pub fn first_order(params: Params, epsilon: f64, t: f64, [z, dz]: [Complex64; 2], [m, dm]: [f64; 2]) -> Site<f64> {
    let (Params { alpha, kappa, rho }, omega) = (params, params.omega());
    let (slowness, turn) = (epsilon.powf(alpha - 1.0), Complex64::from_polar(2.0 * kappa * epsilon, omega * t));
    let swing = (z * turn).re;
    let rate = ((slowness * dz + Complex64::new(0.0, omega) * z) * turn).re;
    let (mean, mean_rate) = (epsilon * m, epsilon * slowness * dm);
    Site { u: mean + swing, v: mean - swing / rho, u_dot: mean_rate + rate, v_dot: mean_rate - rate / rho }
}

/// The envelope that [`project`] returns.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    /// `Z_n`: real parts, then imaginary parts, as the state of [`Dps`].
    pub amplitudes: Vec<f64>,
    /// `M_n`.
    pub means: Vec<f64>,
}

/// Samples per period. A contact force has `alpha` derivatives and positions have two more, so the
/// harmonics that alias to the first (the 63rd and higher) are below 1e-8 for spheres.
const SAMPLES: i32 = 64;

/// The envelope at time `t` of a motion of a chain with moving resonators, from its states between
/// `t - T` and `t + T`, `T = 2 pi/omega`.
///
/// `state` is called with increasing times and returns the state in the layout of the chain:
/// `[u, v, ..]`.
///
/// # Errors
/// No moving resonators; `epsilon` not finite and positive; any error of `state`.
///
/// # Panics
/// If states have different lengths.
pub fn project(
    params: Params,
    epsilon: f64,
    t: f64,
    mut state: impl FnMut(f64) -> Result<Vec<f64>>,
) -> Result<Envelope> {
    params.validate()?;
    let rule = "an envelope needs resonators: 0 < rho < inf, kappa > 0";
    require(params.resonators() == Resonators::Moving, "rho", params.rho, rule)?;
    let rule = "the size of the oscillations is finite and positive";
    require(epsilon.is_finite() && epsilon > 0.0, "epsilon", epsilon, rule)?;
    let (omega, rho) = (params.omega(), params.rho);
    let mut envelope = Envelope { amplitudes: Vec::new(), means: Vec::new() };
    for j in 1 - SAMPLES..SAMPLES {
        let share = f64::from(j) / f64::from(SAMPLES);
        let weight = (1.0 - share.abs()) / f64::from(SAMPLES) / epsilon;
        let now = t + 2.0 * PI / omega * share;
        let y = state(now)?;
        let sites = y.len() / 4;
        envelope.amplitudes.resize(2 * sites, 0.0);
        envelope.means.resize(sites, 0.0);
        let (sin, cos) = (omega * now).sin_cos();
        for n in 0..sites {
            let (u, v) = (y[n], y[sites + n]);
            let optical = weight * (u - v) / (omega * omega);
            envelope.amplitudes[n] += optical * cos;
            envelope.amplitudes[sites + n] -= optical * sin;
            envelope.means[n] += weight * (u + rho * v) / (1.0 + rho);
        }
    }
    Ok(envelope)
}
