//! Which method, which step: what `run` takes when nobody says.

use super::problem::{amplitude, contact_frequency};
use crate::{
    method::{Method, Setting, Split},
    scene::Scene,
};
use hertzchain_integrators::splitting::tables;

/// `chi = omega/Omega_c` above which resonators are light: a step of `2/omega` then changes a contact by so little that Strang's splitting errs below 10^-6,
/// at a fifth of the force evaluations of collocation.
const LIGHT: f64 = 1e3;
/// That step, times `omega`: below the first resonance, at `pi`.
const STEP: f64 = 2.0;
/// Tolerance of collocation.
const TOLERANCE: f64 = 1e-10;

/// A method at work, and why it is the one.
#[derive(Clone, Debug, PartialEq)]
pub struct Regime {
    /// The method.
    pub method: Method,
    /// Its setting.
    pub setting: Setting,
    /// The setting in words.
    pub wording: String,
    /// Why, in words.
    pub reason: String,
}

/// The method for a scene, from the charts of stability.
///
/// | regime | method | setting | energy error measured there |
/// |---|---|---|---|
/// | `omega <= 1000 Omega_c` | `collocation` | tolerance 10^-10 | below 10^-9 |
/// | above: light resonators, or contacts that hardly press | `strang-linear` | step `2/omega` | below 10^-6 |
pub fn regime(scene: &Scene) -> Regime {
    let (chain, overlap) = (scene.chain(), amplitude(scene));
    let (params, omega) = (chain.params(), chain.params().omega());
    let contact = contact_frequency(params.alpha, overlap + chain.precompression());
    let figures = format!("omega = {omega:.3e}, contacts of overlap {overlap:.1e} have Omega_c = {contact:.3e}");
    if omega > LIGHT * contact {
        let steps = (scene.end() * omega / STEP).ceil().max(1.0);
        return Regime {
            method: Method::Splitting(&tables::STRANG, Split::Linear),
            setting: Setting::Steps(steps as u64),
            wording: format!(
                "{steps} steps of {:e} (h omega = {:.3})",
                scene.end() / steps,
                scene.end() / steps * omega
            ),
            reason: format!(
                "{figures}: above 1000 Omega_c the linear flow is nearly all, and steps of 2/omega stay below its first resonance"
            ),
        };
    }
    Regime {
        method: Method::Collocation,
        setting: Setting::Tolerance(TOLERANCE),
        wording: format!("tol {TOLERANCE:e}"),
        reason: format!("{figures}: contacts count, and up to 1000 Omega_c nothing else is as exact at the cost"),
    }
}
