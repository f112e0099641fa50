//! The checker: from a certificate it proves that a solution exists near a cosine sum, or refuses.
//!
//! | file | what it does |
//! |---|---|
//! | `system.rs` | the equations of waves and of breathers, with their factors `l_k` |
//! | `moments.rs` | encloses the Fourier coefficients of contact forces and stiffnesses |
//! | `block.rs` | linear equations on a few harmonics, and their approximate inverse |
//! | `bounds.rs` | the bounds `Y0`, `Z1` |
//! | `multiplier.rs` | real Floquet multipliers of breathers, complex ones of waves |
//! | `infinite.rs` | what a breather of the infinite chain has beside them |
//! | `branch.rs` | whether pieces of a branch make one, where its period doubles, and where it turns back |
//! | this file | the inequalities, from which the radii follow |

pub(crate) mod block;
pub(crate) mod bounds;
mod branch;
pub(crate) mod infinite;
pub(crate) mod moments;
pub(crate) mod multiplier;
pub(crate) mod system;

use system::System;

pub(crate) use block::solved;
pub use branch::{Gap, connected, doublings, turns};
pub use moments::{Moments, NARROWEST, moments};

use crate::{certificate::Certificate, interval::Interval};
use std::fmt;

/// Ratio of two radii that are tried, and their largest number.
pub const RUNG: f64 = 1.2;
const RUNGS: usize = 200;

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
    /// The same of the velocities `y_n'`; infinite where a `b_k` is not defined.
    pub radius_velocity_y: f64,
    /// No other solution of the same symmetry is nearer than this, in the norm of the proof.
    pub uniqueness_radius: f64,
    /// Bounds of the frequency, all along a piece.
    pub frequency: [f64; 2],
    /// Lower bound of the amplitude, the largest modulus of a first harmonic.
    pub amplitude: f64,
    /// The bounds.
    pub bounds: Bounds,
    /// `W_n`, the weights of the sites in the norm, and that of an unknown frequency.
    pub weights: Vec<f64>,
    /// Bounds of the modulus of the multiplier that the certificate has a line for; of -1 those of
    /// `g`, see [`doublings`].
    pub multiplier: Option<[f64; 2]>,
    /// Of a breather of the infinite chain `eta` and `C`, bounds from below and above: its strains
    /// are within `C e^{-eta |n|}` of those of the standing wave, on both sides.
    pub decay: Option<[f64; 2]>,
}

/// Upper bounds of the defect `Y0` and of `Z1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Norm of one Newton correction.
    pub y0: f64,
    /// Norm of the derivative of `T` at the cosine sum.
    pub z1: f64,
}

/// Why nothing is proved.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// The text is no certificate: the rule that it breaks.
    Certificate(String),
    /// This multiple of the frequency is not shown to be another one than that of the free
    /// oscillation of the resonators or, beyond the enclosed harmonics, a larger one.
    Resonance(usize),
    /// The check was asked to end.
    Stopped,
    /// The contact force could not be enclosed: the series does not converge, or is zero.
    Moments,
    /// The inequalities have no solution.
    Bounds(Bounds),
    /// The ball may hold the state at rest, or an orbit of a shorter period: the radius, and the
    /// first harmonic.
    Rest(f64, f64),
    /// A multiplier is not proved.
    Multiplier {
        /// Upper bound of `|1 - A M|`.
        z1: f64,
        /// If this is below 1, bounds of `g` at both growth rates; of a wave those of `|g|` in the
        /// centre of the disc, and of what is to be larger.
        g: Option<[[f64; 2]; 2]>,
    },
    /// The standing wave far from the centre of a breather is not proved.
    Background(Box<Self>),
    /// The approximate inverse `A` could have a kernel: the bound of `1 - B A`.
    Kernel(f64),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Certificate(rule) => write!(f, "no certificate: {rule}"),
            Self::Resonance(k) => {
                write!(
                    f,
                    "harmonic {k} is not separated from the free frequency of beads and resonators, which has to be \
                     below all harmonics that are not enclosed"
                )
            }
            Self::Stopped => f.write_str("the check was asked to end"),
            Self::Moments => f.write_str("the contact force of the cosine sum could not be enclosed"),
            Self::Bounds(Bounds { y0, z1 }) => {
                let why = match (y0 + z1).is_finite() {
                    true => "admit no radius: the cosine sum is too far from a solution, or the block too small",
                    false => "are not all finite",
                };
                write!(f, "Y0 = {y0:.2e}, Z1 = {z1:.2e} {why}")
            }
            Self::Multiplier { z1, g: None } => {
                write!(
                    f,
                    "the multiplier: perturbations are not separated from others, their Z1 = {z1:.2e} \
                     is not below 1"
                )
            }
            Self::Multiplier { g: Some([[a, b], [c, d]]), .. } => write!(
                f,
                "the multiplier: g is not shown to be 0 somewhere, by {a:.2e} to {b:.2e} and {c:.2e} to {d:.2e}"
            ),
            Self::Background(why) => write!(f, "the standing wave far from the centre: {why}"),
            Self::Kernel(bound) => {
                write!(f, "|1 - B A| < 1 is not shown, but {bound:.2e} as its bound: the band is too narrow")
            }
            Self::Rest(radius, first) => {
                write!(
                    f,
                    "the radius {radius:.2e} is not below the first harmonic {first:.2e}, so the solution could be at rest, \
                     or have a shorter period"
                )
            }
        }
    }
}

impl std::error::Error for Refused {}

/// Checks the text of a certificate.
///
/// # Errors
/// [`Refused`]; every reason is one that another certificate may not have.
pub fn check_text(text: &str) -> Result<(Certificate, Proof), Refused> {
    let certificate: Certificate = text.parse().map_err(Refused::Certificate)?;
    let proof = check(&certificate)?;
    Ok((certificate, proof))
}

/// Checks a certificate.
///
/// # Errors
/// As [`check_text`].
pub fn check(certificate: &Certificate) -> Result<Proof, Refused> {
    check_until(certificate, &|| false)
}

/// Checks a certificate, as long as the function says no.
///
/// # Errors
/// As [`check_text`].
pub fn check_until(certificate: &Certificate, stopped: &dyn Fn() -> bool) -> Result<Proof, Refused> {
    certificate.valid().map_err(Refused::Certificate)?;
    bounds::check(certificate, stopped)
}

/// A whole number as an interval.
fn of(k: usize) -> Interval {
    Interval::exact(k as f64)
}

/// The radius `r` of a ball that `T` maps into itself, and that of uniqueness, where `q(r)` bounds
/// its derivative on balls: `Y0 + q r' <= r'` with `q` of a ball of radius `r >= r'`, and `q < 1`
/// on that of uniqueness. Both are at most `largest`.
pub fn radii(y0: Interval, largest: f64, q: impl Fn(f64) -> Interval) -> Option<(Interval, f64)> {
    let (mut radius, mut unique, mut r) = (None, None, y0.hi());
    for _ in 0..RUNGS {
        let q = q(r);
        if !((Interval::ONE - q).is_positive() && r <= largest) {
            break;
        }
        let image = y0 / (Interval::ONE - q);
        if radius.is_none() && image.hi() <= r {
            radius = Some(Interval::exact(image.hi()));
        }
        unique = Some(r);
        r *= RUNG;
    }
    radius.zip(unique)
}
