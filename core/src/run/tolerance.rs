//! Number of steps of contact-corrected splitting for a tolerance of the whole run.
//!
//! The order is four. Two runs over the whole span, with `n` and `sqrt(2) n` steps, therefore
//! differ by three times the error of the finer run, and the number of steps for the tolerance
//! follows from this error; it is that of the finer run at least, since longer steps may have left
//! the order. If it is more than twice that, the pair is repeated with more steps.

use super::{Run, within::AnyStepper};
use crate::{
    chain::{Chain, max_norm},
    error::{Result, require},
};
use hertzchain_integrators::{Silent, drive};
use std::f64::consts::SQRT_2;

/// Number of steps in the first run per period of the fastest motion.
const FIRST: f64 = 16.0;
/// Error that the number of steps is chosen for, in units of the tolerance. It is less than one
/// because the estimate is not a bound.
const GOAL: f64 = 0.25;
/// Order of the method.
const ORDER: f64 = 4.0;
/// Largest accepted ratio of the number of steps to that of the finer run of the pair.
const FARTHEST: f64 = 2.0;
/// Largest growth of the number of steps from one pair of runs to the next.
const FASTEST: f64 = 16.0;
/// Runs with an error below this resolve their contacts: the error of the next pair, with at least
/// twice as many steps, is smaller unless it consists of rounding errors. Chosen, not measured.
const RESOLVED: f64 = 1e-3;
/// Number of pairs in a row without a smaller error after which the tolerance is refused. Chosen.
const STALLED: u32 = 2;
/// Largest number of steps in the coarser run of a pair.
const MOST_STEPS: f64 = 1e12;
/// Relative change of an initial state whose growth is measured.
const CHANGE: f64 = 1e-10;
/// Rounding errors are measured where those of a random walk, one in each step, are more than this
/// share of the tolerance. Chosen: in a chaotic chain they were 25 times as large.
const DOUBTFUL: f64 = 0.03;
/// Up to so many times the steps of the first run they are far below the errors of the method.
const COARSE: f64 = 6.0;

/// Adds a change to those entries whose absolute value is at least `least`, with signs that depend
/// on their index.
pub fn perturb(entries: &mut [f64], change: f64, least: f64) {
    for (i, entry) in entries.iter_mut().enumerate().filter(|(_, entry)| entry.abs() >= least) {
        *entry += if (i * i + 3 * i) % 7 < 3 { change } else { -change };
    }
}

/// The run from a state with so many steps.
type Start<'a> = dyn Fn(&[f64], u64) -> Result<AnyStepper> + 'a;

/// Number of steps for which the estimated error of the state at the end is at most `tol`: the
/// largest of a column `u, v, u', v'`, in the maximum norm and relative to the size of the column.
/// That of resonators is at least `1/(1 + rho)` of that of the beads, as if springs were rigid.
///
/// # Errors
/// A tolerance that no number of steps up to 1e12 reaches by
/// the estimate, or that rounding errors keep it from; the error that ends a run.
pub(super) fn steps(run: &Run, y: &[f64], span: (f64, f64), tol: f64, start: &Start<'_>) -> Result<u64> {
    // The end of a run whose initial state is changed by this share of its columns.
    let end_near = |change: f64, steps: f64| -> Result<Vec<f64>> {
        let mut end = y.to_vec();
        for column in end[..2 * run.chain().layout().half()].chunks_mut(run.chain().sites()) {
            perturb(column, change * max_norm(column.iter().copied()), 0.0);
        }
        let mut stepper = start(&end, steps as u64)?;
        drive(&mut *stepper, &mut Silent, &mut end)?;
        Ok(end)
    };
    let (end, apart) = (|steps: f64| end_near(0.0, steps), |a: &[f64], b: &[f64]| distance(run.chain(), a, b));
    let first = (FIRST * (span.1 - span.0) / run.fast_period()).ceil().max(FIRST);
    // What each event errs by through rounding grows as a change of the initial state does, and
    // depends on where in a step it falls: with one step more it is another.
    let rounded = |steps: f64, finer: &[f64]| -> Result<bool> {
        let growth = || -> Result<f64> { Ok(apart(&end_near(CHANGE, first)?, &end(first)?) / CHANGE) };
        if steps <= COARSE * first || f64::EPSILON * growth()? * steps.sqrt() <= DOUBTFUL * tol {
            return Ok(false);
        }
        let here = end(steps)?;
        Ok(apart(&here, finer) > tol && apart(&here, &end(steps + 1.0)?) > tol)
    };
    let above_rounding =
        |good| require(good, "tol", tol, "rounding errors of contact-corrected splitting are larger here");
    let mut steps = first;
    let (mut last, mut least, mut stalled) = (f64::INFINITY, f64::INFINITY, 0);
    loop {
        let finer = (SQRT_2 * steps).round();
        let (coarse, fine) = (end(steps)?, end(finer)?);
        let error = apart(&coarse, &fine) / (SQRT_2.powf(ORDER) - 1.0);
        let factor = (error / (GOAL * tol)).powf(1.0 / ORDER);
        let reached = factor <= FARTHEST;
        // An error below the tolerance that does not decrease consists of rounding errors.
        if reached || error > last && error < tol {
            let steps = if reached { (finer * factor.max(1.0)).ceil() } else { finer };
            above_rounding(!rounded(steps, &fine)?)?;
            return Ok(at_samples(run, span, steps as u64));
        }
        last = if error.is_finite() { error } else { last };
        stalled = if error < least || least > RESOLVED { 0 } else { stalled + 1 };
        least = least.min(error);
        above_rounding(stalled < STALLED)?;
        steps = (finer * if factor.is_finite() { (factor / FARTHEST).clamp(SQRT_2, FASTEST) } else { FASTEST }).ceil();
        require(steps <= MOST_STEPS, "tol", tol, "no number of steps up to 1e12 reaches this tolerance")?;
    }
}

/// Rounds the number of steps up to a multiple of the number of samples, for a run over the whole
/// span. Samples then fall on ends of steps; a sample inside a step costs as much as many steps.
fn at_samples(run: &Run, span: (f64, f64), steps: u64) -> u64 {
    let whole = run.end().is_ok_and(|end| span == (run.start, end));
    match run.sample_count() as u64 {
        samples @ 1.. if whole => steps.next_multiple_of(samples),
        _ => steps,
    }
}

/// Largest relative difference of a column of the state, see [`steps`].
fn distance(chain: &Chain<f64>, a: &[f64], b: &[f64]) -> f64 {
    let (n, share, mut beads) = (chain.sites(), 1.0 / (1.0 + chain.params().rho), 0.0);
    let [a, b] = [a, b].map(|y| &y[..2 * chain.layout().half()]);
    let columns = a.chunks(n).zip(b.chunks(n)).enumerate();
    columns.fold(0.0, |largest, (k, (a, b))| {
        let gap = a
            .iter()
            .zip(b)
            .fold(0.0, |gap: f64, (a, b)| if (a - b).is_nan() { f64::INFINITY } else { gap.max((a - b).abs()) });
        let mut size = max_norm(b.iter().copied());
        if chain.layout().resonators() && k % 2 == 1 {
            size = size.max(share * beads);
        }
        beads = size;
        if gap == 0.0 { largest } else { f64::max(largest, gap / size) }
    })
}
