//! The default method and setting of a run.

use super::{Method, Run, Setting, method::Split};
use crate::{
    chain::{Blocks, Chain, max_norm},
    error::Result,
};
use hertzchain_integrators::splitting::tables;

/// Value of `chi = omega/Omega_c` above which `regime` chooses Strang's splitting on the exact
/// linear flow: its energy error is then below 10^-6, at a tenth of the run time of collocation or
/// less.
const LIGHT: f64 = 1e4;
/// Coefficient `c` of the bound `c (h omega)^2/chi` for the energy error of Strang's splitting
/// above `LIGHT`. Measured: at most 0.036, over the charts `light` and `stiffness`, where springs
/// hold as much energy as contacts, for steps below the first resonance at `h omega = pi`.
const ERROR: f64 = 0.04;
const GOAL: f64 = 1e-6;
/// Longest step of Strang's splitting, times `omega`.
const LONGEST: f64 = 2.0;
/// Default tolerance of methods that take one.
pub(super) const TOLERANCE: f64 = 1e-10;
/// Default number of steps per period of the other methods.
pub(super) const STEPS_PER_PERIOD: f64 = 512.0;

/// Method and setting that `regime` chose, with its reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Regime {
    /// The method.
    pub method: Method,
    /// Its setting.
    pub setting: Setting,
    /// The setting in words.
    pub wording: String,
    /// The reason, in words.
    pub reason: String,
}

/// Scale of the overlaps: the largest strain (in absolute value) or, if larger, the greatest
/// overlap `A` of two beads that meet with the largest speed `V` each,
/// `A^(alpha+1) = (alpha+1) V^2`.
pub fn overlap_scale(chain: &Chain<f64>, y: &[f64]) -> f64 {
    let (strain, power) = (max_norm(chain.strains(y)), chain.params().alpha + 1.0);
    let speed = max_norm(chain.layout().u_dot(y).iter().copied());
    strain.max((speed * speed * power).powf(power.recip()))
}

/// The same of the initial state of a run, which need not be in memory: it is looked at in blocks.
fn overlap_scale_of(run: &Run) -> f64 {
    let (chain, rest) = (run.chain(), run.chain().precompression());
    if run.initial.made().is_some() || chain.sites() == 1 {
        return overlap_scale(chain, run.initial().as_slice());
    }
    let (mut strain, mut speed, mut last) = (0.0f64, 0.0f64, None);
    let mut across = |left: f64, right: f64| {
        let overlap = rest + (left - right);
        strain = if overlap.is_finite() { strain.max((rest - overlap).abs()) } else { strain };
    };
    let (mut first, end) = (0.0, run.initial.last());
    run.initial.each(&mut |_, [u, _, u_dot, _]| {
        speed = speed.max(max_norm(u_dot.iter().copied()));
        if chain.topology().strains() {
            u.iter().for_each(|&x| across(0.0, x));
            return;
        }
        let before = last.unwrap_or_else(|| {
            first = u[0];
            chain.topology().ghosts(u[0], end).0
        });
        across(before, u[0]);
        u.windows(2).for_each(|pair| across(pair[0], pair[1]));
        last = u.last().copied();
    });
    if !chain.topology().ring() {
        across(end, chain.topology().ghosts(first, end).1);
    }
    let power = chain.params().alpha + 1.0;
    strain.max((speed * speed * power).powf(power.recip()))
}

/// Contact frequency `Omega_c = sqrt(2 alpha (A + delta_0)^{alpha-1})`, with
/// `overlap = A + delta_0`.
pub fn contact_frequency(alpha: f64, overlap: f64) -> f64 {
    (2.0 * alpha * overlap.powf(alpha - 1.0)).sqrt()
}

/// Chooses method and setting from the stability charts.
///
/// | regime | method | setting | energy error measured there |
/// |---|---|---|---|
/// | `omega <= 10^4 Omega_c` | `collocation` | tolerance 10^-10 | below 10^-9 |
/// | `omega > 10^4 Omega_c` | `strang-linear` | `h omega = min(2, sqrt(chi)/200)` | below 10^-6 |
///
/// A chain with [`Details`](crate::chain::Details) takes `collocation` too, whatever its
/// frequencies.
///
/// The second row means light resonators, or weakly compressed contacts.
///
/// # Errors
/// A run without an end.
pub fn regime(run: &Run) -> Result<Regime> {
    if run.chain().details().is_some() {
        run.end()?;
        return Ok(of_details(run.chain()));
    }
    let (chain, end, overlap) = (run.chain(), run.end()?, overlap_scale_of(run));
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

/// The choice for a chain with details.
fn of_details(chain: &Chain<f64>) -> Regime {
    let sites = chain.sites();
    let what = if chain.dissipative_contacts() {
        "sites have contacts that dissipate"
    } else if chain.open() {
        "sites are damped or driven"
    } else {
        "sites differ in beads or bonds"
    };
    Regime {
        method: Method::by_tolerance(),
        setting: Setting::Tolerance(TOLERANCE),
        wording: format!("tol {TOLERANCE:e}"),
        reason: format!("{sites} {what}: collocation keeps this tolerance over the whole run"),
    }
}
