//! The default method and setting of a run.

use super::{Method, Run, Setting, extremes::PART, method::Split};
use crate::{
    chain::{Chain, max_norm},
    error::Result,
};
use hertzchain_integrators::splitting::tables;
use std::f64::consts::PI;

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
/// Default number of steps of the other methods in a period of the fastest motion.
const STEPS_PER_PERIOD: f64 = 512.0;

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
    let ((strain, speed), power) = (scales(chain, y), chain.params().alpha + 1.0);
    strain.max((speed * speed * power).powf(power.recip()))
}

/// The largest strain, in absolute value, and the largest speed of a bead.
fn scales(chain: &Chain<f64>, y: &[f64]) -> (f64, f64) {
    let (u, topology) = (chain.layout().u(y), chain.topology());
    let (left, right) = topology.ghosts(u[0], u[u.len() - 1]);
    let ends = [u[0] - left, u[u.len() - 1] - right].into_iter().filter(|strain| strain.is_finite());
    let strain = match topology.strains() {
        true => max_norm(u.iter().copied()),
        false => max_norm(u.windows(2).map(|pair| pair[1] - pair[0]).chain(ends)),
    };
    (strain, max_norm(chain.layout().u_dot(y).iter().copied()))
}

impl Run {
    /// Period of the fastest motion: of resonators, contacts or drives. Steps that nobody gives are
    /// counted in it. A run with none of these, as at rest without precompression, has its own
    /// [period](Self::period).
    ///
    /// Contacts count with their static overlap and the [overlap](overlap_scale) that strains and
    /// speeds of the initial state and the drives give them. Where a frequency of resonators is the
    /// largest, it is the period of the run, which for waves and breathers is slightly shorter than
    /// that of the resonators.
    pub fn fast_period(&self) -> f64 {
        let (chain, initial) = (&self.chain, self.initial().as_slice());
        let (own, contacts) = match chain.parts() {
            None => {
                let (params, overlap) = (chain.params(), overlap_scale(chain, initial) + chain.precompression());
                (params.omega(), contact_frequency(params.alpha, overlap))
            }
            Some(parts) => {
                let (strain, speed) = scales(chain, initial);
                (0.0, parts.fast_frequency(chain.topology().ring(), strain, speed))
            }
        };
        match 2.0 * PI / own.max(contacts) {
            fast if own > 0.0 && self.period < fast => self.period,
            fast if fast > 0.0 && fast.is_finite() => fast,
            _ => self.period,
        }
    }

    /// The longest parts of steps that are searched.
    pub(super) fn part(&self) -> f64 {
        PART * self.fast_period()
    }

    /// Method and setting of the run. What was not given follows from what was given, or from
    /// [`regime`] if neither was given.
    ///
    /// # Errors
    /// No end was given, and the choice depends on it.
    pub fn choice(&self) -> Result<(Method, Setting)> {
        Ok(match (self.method, self.setting) {
            (Some(method), Some(setting)) => (method, setting),
            (None, Some(setting @ Setting::Steps(_))) => (Method::by_steps(&self.chain), setting),
            (None, Some(setting)) => (Method::by_tolerance(&self.chain), setting),
            (Some(method), None) if method.tolerant() => (method, Setting::Tolerance(TOLERANCE)),
            (Some(method), None) => (method, Setting::steps(STEPS_PER_PERIOD * self.length()? / self.fast_period())?),
            (None, None) => {
                let Regime { method, setting, .. } = regime(self)?;
                (method, setting)
            }
        })
    }
}

/// Contact frequency `Omega_c = sqrt(2 alpha (A + delta_0)^{alpha-1})`, with
/// `overlap = A + delta_0`.
pub fn contact_frequency(alpha: f64, overlap: f64) -> f64 {
    (2.0 * alpha * overlap.powf(alpha - 1.0)).sqrt()
}

const COLLOCATION: &str = "the errors of its windows add up to less than this tolerance";

/// Chooses method and setting from the stability charts.
///
/// | regime | method | setting | energy error measured there |
/// |---|---|---|---|
/// | `omega <= 10^4 Omega_c` | `collocation` | tolerance 10^-10 | below 10^-9 |
/// | `omega > 10^4 Omega_c` | `strang-linear` | `h omega = min(2, sqrt(chi)/200)` | below 10^-6 |
///
/// A chain with [`Details`](crate::chain::Details) takes `collocation` too, whatever its
/// frequencies; `dop853-regularised` if it is [beyond](Chain::beyond_collocation) collocation.
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
    let (chain, length, overlap) = (run.chain(), run.length()?, overlap_scale(run.chain(), run.initial().as_slice()));
    let (params, omega) = (chain.params(), chain.params().omega());
    let contact = contact_frequency(params.alpha, overlap + chain.precompression());
    let known = |relation: &str| {
        format!(
            "omega = {omega:.3e} is {relation} 10^4 times the frequency {contact:.3e} of contacts that overlap by {overlap:.1e}"
        )
    };
    if omega > LIGHT * contact {
        let h_omega = (GOAL * omega / (ERROR * contact)).sqrt().min(LONGEST);
        let steps = (length * omega / h_omega).ceil().max(1.0);
        let step = length / steps;
        return Ok(Regime {
            method: Method::Splitting(&tables::STRANG, Split::Linear),
            setting: Setting::Steps(steps as u64),
            wording: format!("{steps} steps of {step:e} (h omega = {:.3})", step * omega),
            reason: format!(
                "{}: an energy error below 1e-6 at a tenth of the cost of collocation, which --tol chooses",
                known("above")
            ),
        });
    }
    Ok(Regime {
        method: Method::Collocation,
        setting: Setting::Tolerance(TOLERANCE),
        wording: format!("tol {TOLERANCE:e}"),
        reason: match omega {
            0.0 => COLLOCATION.to_owned(),
            _ => format!("{COLLOCATION}; {}", known("at most")),
        },
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
    let method = Method::by_tolerance(chain);
    let kept =
        if method == Method::Collocation { COLLOCATION } else { "the error of each step is within this tolerance" };
    Regime {
        method,
        setting: Setting::Tolerance(TOLERANCE),
        wording: format!("tol {TOLERANCE:e}"),
        reason: format!("{sites} {what}: {kept}"),
    }
}
