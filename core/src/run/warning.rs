//! What makes the result of a run doubtful, though nothing failed.

use super::{Method, Run, Setting};
use crate::chain::{Course, Drive, Envelope};
use hertzchain_integrators::Stats;

/// An energy error is explained up to this many times the tolerance or the rounding errors.
const MARGIN: f64 = 1e3;
/// Error of a step across a contact, in units of the tolerance of a step. Measured on `tw-q15`: the
/// errors of whole runs by `dop853` are 400 to 20 000 times the tolerance.
const CROSSING: f64 = 100.0;
/// An energy error of a larger share of the energy is never explained.
const MOST: f64 = 0.5;

/// What makes the result of a run doubtful, as a sentence for the user.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// An energy error that the setting does not explain.
    #[error("the energy is off by {error:.1e} of itself, and {why}: check with another integrator")]
    Energy {
        /// Largest error of the energy, relative to the initial energy; for a chain that dissipates
        /// or is driven, of the balance, relative to the largest of energy, dissipated energy and
        /// work of the drives.
        error: f64,
        /// What the setting explains, in words.
        why: String,
    },
    /// Steps of a given length that pass over the ramp or the burst of a drive. Methods that choose
    /// their steps, or their windows, end them where a signal is not smooth.
    #[error(
        "drive {drive}, of bead {site}, has {kind} of length {length:e}, which steps of {step:e} pass over: take \
         shorter steps, or --tol"
    )]
    Unresolved {
        /// Number of the drive, from 0.
        drive: usize,
        /// Its site.
        site: usize,
        /// `a ramp`, `a burst` or `an interval of times`.
        kind: &'static str,
        /// Length of the ramp, the burst or the shortest interval.
        length: f64,
        /// Length of a step.
        step: f64,
    },
}

impl Warning {
    /// The warnings of a run, whose largest energy error is `error` if it has an energy.
    pub(super) fn of(run: &Run, error: Option<f64>, stats: Stats) -> Vec<Self> {
        energy(run, error, stats).into_iter().chain(unresolved(run)).collect()
    }

    /// Whether the result must not be taken for one that met its setting: `run` then ends with exit
    /// code 1, and the point of a sweep has failed.
    pub fn fatal(&self) -> bool {
        matches!(self, Self::Energy { .. })
    }
}

/// An energy error above a thousand times the tolerance, or above half of the energy.
///
/// Rounding errors of `n` steps are taken to add up to `sqrt(n)` units of the last place. Where the
/// tolerance is one of a step, errors of all steps may add up.
fn energy(run: &Run, error: Option<f64>, Stats { steps, .. }: Stats) -> Option<Warning> {
    let (error, (method, setting)) = (error?, run.choice().ok()?);
    let (bound, why) = match setting {
        Setting::Tolerance(tol) => {
            let rounding = f64::EPSILON * (steps as f64).sqrt();
            let steps = if method.tolerance_is_global() { MARGIN } else { MARGIN.max(CROSSING * steps as f64) };
            let bound = (steps * tol).max(MARGIN * rounding).min(MOST);
            (bound, format!("the tolerance {tol:e} explains at most {bound:.1e}"))
        }
        Setting::Steps(_) | Setting::Windows(..) => (MOST, "no order explains more than half of it".to_owned()),
    };
    (error > bound).then_some(Warning::Energy { error, why })
}

/// The drives that the steps of a run do not resolve.
fn unresolved(run: &Run) -> Vec<Warning> {
    let Ok((Method::Splitting(..) | Method::Landed(_), Setting::Steps(steps))) = run.choice() else {
        return Vec::new();
    };
    let step = (run.end - run.start) / steps as f64;
    let drives = run.chain.details().into_iter().flat_map(|details| &details.drives).enumerate();
    let short = drives.filter_map(|(drive, Drive { site, signal, .. })| {
        let (kind, length) = match (signal.envelope, &signal.course) {
            (_, Some(Course::Table(spline))) => ("an interval of times", spline.shortest()),
            (Envelope::Ramp(ramp), _) => ("a ramp", ramp),
            (Envelope::Burst { length, .. } | Envelope::HalfSine { length, .. }, _) => ("a burst", length),
            (Envelope::None, _) => return None,
        };
        (length < step).then_some(Warning::Unresolved { drive, site: *site, kind, length, step })
    });
    short.collect()
}
