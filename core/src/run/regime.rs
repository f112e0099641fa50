//! Which method, which step: what `run` takes when nobody says.

use super::{Method, Run, Setting, method::Split};
use crate::{
    chain::{Chain, max_norm},
    error::Result,
};
use hertzchain_integrators::splitting::tables;

/// `chi = omega/Omega_c` above which resonators are light: Strang's splitting on the exact linear flow then errs below 10^-6 at a tenth of the run time of
/// collocation, or less.
const LIGHT: f64 = 1e4;
/// Its energy error is at most `0.036 (h omega)^2/chi` there (measured), as long as steps stay below the first resonance, at `h omega = pi`: the largest of the charts `light` and
/// `stiffness`, where springs hold as much energy as contacts.
const ERROR: f64 = 0.04;
const GOAL: f64 = 1e-6;
/// The longest step, times `omega`.
const LONGEST: f64 = 2.0;
/// Tolerance of methods that take one.
pub(super) const TOLERANCE: f64 = 1e-10;
/// Steps a period of the others.
pub(super) const STEPS_PER_PERIOD: f64 = 512.0;

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

/// How far beads overlap: the largest strain, or what two beads that meet at the largest speed each turn into overlap.
pub fn overlap_scale(chain: &Chain<f64>, y: &[f64]) -> f64 {
    let (strain, power) = (max_norm(chain.strains(y)), chain.params().alpha + 1.0);
    let speed = max_norm(chain.layout().u_dot(y).iter().copied());
    strain.max((speed * speed * power).powf(power.recip()))
}

/// `Omega_c = sqrt(2 alpha (A + delta_0)^{alpha-1})`.
pub fn contact_frequency(alpha: f64, overlap: f64) -> f64 {
    (2.0 * alpha * overlap.powf(alpha - 1.0)).sqrt()
}

/// The method for a run, from the charts of stability.
///
/// | regime | method | setting | energy error measured there |
/// |---|---|---|---|
/// | `omega <= 10^4 Omega_c` | `collocation` | tolerance 10^-10 | below 10^-9 |
/// | above: light resonators, or contacts that hardly press | `strang-linear` | `h omega = min(2, sqrt(chi)/200)` | below 10^-6 |
///
/// # Errors
/// A run without an end.
pub fn regime(run: &Run) -> Result<Regime> {
    let (chain, end, overlap) = (run.chain(), run.end()?, overlap_scale(run.chain(), run.initial().as_slice()));
    let (params, omega) = (chain.params(), chain.params().omega());
    let contact = contact_frequency(params.alpha, overlap + chain.precompression());
    let known = format!("omega = {omega:.3e}, Omega_c = {contact:.3e} of contacts that overlap by {overlap:.1e}");
    if omega > LIGHT * contact {
        let h_omega = (GOAL * omega / (ERROR * contact)).sqrt().min(LONGEST);
        let steps = (end * omega / h_omega).ceil().max(1.0);
        let step = end / steps;
        return Ok(Regime {
            method: Method::Splitting(&tables::STRANG, Split::Linear),
            setting: Setting::Steps(steps as u64),
            wording: format!("{steps} steps of {step:e} (h omega = {:.3})", step * omega),
            reason: format!(
                "{known}: above 10^4 Omega_c this errs by 1e-6 at a tenth of the cost of collocation (--tol chooses that), below the first resonance"
            ),
        });
    }
    Ok(Regime {
        method: Method::Collocation,
        setting: Setting::Tolerance(TOLERANCE),
        wording: format!("tol {TOLERANCE:e}"),
        reason: format!("{known}: up to 10^4 Omega_c collocation keeps this tolerance at all times"),
    })
}
