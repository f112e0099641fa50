//! The checker: from a certificate it proves that a solution exists near a cosine sum, or refuses.
//! The table of files is in `README.md` of this package.

pub(crate) mod bloch;
mod branch;
mod distances;
pub(crate) mod existence;
pub(crate) mod factors;
pub(crate) mod fold;
pub(crate) mod further;
pub(crate) mod infinite;
pub(crate) mod moments;
pub(crate) mod multiplier;
pub(crate) mod newton;
pub(crate) mod perturbed;
pub(crate) mod system;
mod zero;

use system::System;

pub use crate::untrusted::text::{Gap, Refused};
pub use branch::{Pieces, connected, doublings};
pub use fold::turns;
pub use moments::{Moments, NARROWEST, moments};
pub use zero::Zero;

pub(crate) use crate::interval::of;
use crate::{
    certificate::Certificate,
    untrusted::read::{RULES, limits},
};

/// What is proved: within `radius` of the cosine sum of the certificate there is a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// Upper bound of `|x_n(t) - xbar_n(t)|` for all sites and times.
    pub radius: f64,
    /// The same of `y_n`, about the sum with `b_k = kappa a_k/(kappa - rho omega^2 k^2)` in place
    /// of `a_k`; infinite where a `b_k` is not defined.
    pub radius_y: f64,
    /// The same of the velocities `x_n'`.
    pub radius_velocity: f64,
    /// The same of the velocities `y_n'`.
    pub radius_velocity_y: f64,
    /// No other solution of the same symmetry is nearer than this, in the norm of the proof.
    pub uniqueness_radius: f64,
    /// Bounds of the frequency, all along a piece.
    pub frequency: [f64; 2],
    /// Lower bound of the amplitude, the largest modulus of a first harmonic of the cosine sum.
    pub amplitude: f64,
    /// The bounds.
    pub bounds: Bounds,
    /// `q(r)`, a bound of the derivative of `T` on the ball of the proof, of radius
    /// `Y0/(1 - q(r))`.
    pub contraction: f64,
    /// `W_n`, the weights of the sites in the norm, and that of an unknown frequency.
    pub weights: Vec<f64>,
    /// Bounds of the modulus of the multiplier of the certificate, the largest one of pieces; of -1
    /// those of `g` ([`doublings`]).
    pub multiplier: Option<[f64; 2]>,
    /// Bounds of the growth rates of the perturbations of a wave, of the largest one of these, and
    /// of their frequencies.
    pub growth: Option<[[f64; 2]; 3]>,
    /// Of a breather of the infinite chain `eta` and `C`, bounds from below and above: its strains
    /// are within `C e^{-eta |n|}` of those of the standing wave, on both sides.
    pub decay: Option<[f64; 2]>,
    /// Of a piece down to amplitude zero.
    pub zero: Option<Zero>,
}

/// Upper bounds of the defect `Y0` and of `Z1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Norm of one Newton correction.
    pub y0: f64,
    /// Norm of the derivative of `T` at the cosine sum.
    pub z1: f64,
}

/// Checks a certificate, as long as the function says no.
///
/// # Errors
/// [`Refused`]; every reason is one that another certificate may not have.
pub fn check_until(certificate: &Certificate, stopped: &dyn Fn() -> bool) -> Result<Proof, Refused> {
    if let Some(broken) = certificate.rules().iter().position(|holds| !holds) {
        return Err(Refused::Certificate(RULES[broken].to_owned()));
    }
    limits(certificate).map_err(Refused::Certificate)?;
    existence::check(certificate, stopped)
}
