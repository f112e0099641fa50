//! The step of contact-corrected splitting from a tolerance of the whole run.
//!
//! Two runs over the whole span, at `n` and `sqrt(2) n` steps, differ by three times the error of the finer one, since the order is four. The steps that the
//! tolerance needs follow from that; runs are repeated, nearer to these, until they are at most twice those of the finer run.

use super::{Method, Setting};
use crate::{
    chain::{Layout, max_norm},
    error::{Error, Result},
    interrupt,
    scene::Scene,
};
use hertzchain_integrators::{Error as Failure, Observer, Stats, drive};
use std::{f64::consts::SQRT_2, ops::ControlFlow};

/// Tolerances that can be met: below are roundings.
const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-13..=0.1;
/// Steps a period of the scene in the first run.
const FIRST: f64 = 16.0;
/// The error that steps are chosen for, in units of the tolerance: so much less, as estimates are no bounds.
const GOAL: f64 = 0.25;
/// The order.
const ORDER: f64 = 4.0;
/// Steps of the run, at most, in units of those of the last one that told its error.
const FARTHEST: f64 = 2.0;
/// The number of steps grows by no more than this factor from one pair of runs to the next.
const FASTEST: f64 = 16.0;
/// More steps than a run of years takes.
const MOST_STEPS: f64 = 1e12;

/// The number of steps with which the largest relative error of a column of the state at the end, `u, v, u', v'`, is at most `tol`, by the estimate above.
///
/// # Errors
/// A tolerance below 1e-13 or above 0.1, one that estimates do not reach, or what ends a run.
pub(super) fn steps(scene: &Scene, method: Method, y: &[f64], span: (f64, f64), tol: f64) -> Result<u64> {
    if !TOLERANCES.contains(&tol) {
        return Err(Error::parameter("tol", tol, "contact-corrected splitting takes tolerances from 1e-13 to 0.1"));
    }
    let layout = scene.chain().layout();
    let end = |steps: f64| -> Result<Vec<f64>> {
        let mut stepper = method.start_leg(scene, y, span, Setting::Steps(steps as u64))?;
        let mut end = y.to_vec();
        drive(&mut *stepper, &mut Interruptible, &mut end)?;
        Ok(end)
    };
    let mut steps = (FIRST * (span.1 - span.0) / scene.period()).ceil().max(FIRST);
    let mut last = f64::INFINITY;
    loop {
        let finer = (SQRT_2 * steps).round();
        let error = distance(layout, &end(steps)?, &end(finer)?) / (SQRT_2.powf(ORDER) - 1.0);
        let factor = (error / (GOAL * tol)).powf(1.0 / ORDER);
        if factor <= FARTHEST {
            return Ok(at_samples(scene, span, (finer * factor.max(0.5)).ceil() as u64));
        }
        // Below the tolerance, finer steps only add roundings.
        if error > last && error < tol {
            return Ok(at_samples(scene, span, finer as u64));
        }
        last = if error.is_finite() { error } else { last };
        steps = (finer * if factor.is_finite() { (factor / FARTHEST).clamp(SQRT_2, FASTEST) } else { FASTEST }).ceil();
        if steps > MOST_STEPS {
            return Err(Error::parameter("tol", tol, "no number of steps up to 1e12 reaches this tolerance"));
        }
    }
}

/// As many steps or more, so that the samples of a whole run are at ends of steps: one inside a step costs as much as many steps.
fn at_samples(scene: &Scene, span: (f64, f64), steps: u64) -> u64 {
    let whole = span == (0.0, scene.end());
    match scene.samples() as u64 {
        samples @ 1.. if whole => steps.next_multiple_of(samples),
        _ => steps,
    }
}

/// The largest relative difference of a column of the state.
fn distance(layout: Layout, a: &[f64], b: &[f64]) -> f64 {
    let n = layout.sites();
    let columns = a.chunks(n).zip(b.chunks(n));
    columns.fold(0.0, |largest, (a, b)| {
        let gap = a
            .iter()
            .zip(b)
            .fold(0.0, |gap: f64, (a, b)| if (a - b).is_nan() { f64::INFINITY } else { gap.max((a - b).abs()) });
        let size = max_norm(b.iter().copied());
        if gap == 0.0 { largest } else { f64::max(largest, gap / size) }
    })
}

/// Sees nothing, and stops when the process is asked to.
struct Interruptible;

impl Observer<f64> for Interruptible {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _: f64, _: &[f64], _: Stats) -> std::result::Result<ControlFlow<()>, Failure> {
        Ok(ControlFlow::Continue(()))
    }

    fn stop(&self) -> bool {
        interrupt::asked()
    }
}
