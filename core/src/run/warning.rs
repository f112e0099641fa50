//! What makes the result of a run doubtful, though nothing failed.

use super::{Method, Run, Setting, Warning};
use crate::chain::{Course, Drive, Envelope};
use hertzchain_integrators::Stats;

/// An energy error is explained up to this many times the tolerance or the rounding errors.
const MARGIN: f64 = 1e3;
/// Error of a step across a contact, in units of the tolerance of a step. Measured on `tw-q15`: the
/// errors of whole runs by `dop853` are 400 to 20 000 times the tolerance.
const CROSSING: f64 = 100.0;
/// An energy error of a larger share of the energy is never explained.
const MOST: f64 = 0.5;

/// The warnings of a run, whose largest energy error is `error` if it has an energy.
pub(super) fn warnings(run: &Run, error: Option<f64>, stats: Stats) -> Vec<Warning> {
    energy(run, error, stats).into_iter().chain(weak(run)).chain(unresolved(run)).collect()
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

/// A tolerance below the rounding of static overlaps.
fn weak(run: &Run) -> Option<Warning> {
    let Ok((_, Setting::Tolerance(tol))) = run.choice() else { return None };
    let natural = run.chain.natural(run.initial().as_slice());
    let share = f64::EPSILON * run.chain.largest_rest() / (natural.length * natural.size.max(natural.driven));
    (share > tol).then_some(Warning::Weak { share, tol })
}

/// The drives that the steps of a run do not resolve.
fn unresolved(run: &Run) -> Vec<Warning> {
    let Ok((Method::Splitting(..), Setting::Steps(steps))) = run.choice() else {
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
