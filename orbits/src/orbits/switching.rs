//! The first solution on the branch that crosses a known branch at a bifurcation.
//!
//! | symbol | meaning |
//! |---|---|
//! | `X_0` | scaled unknowns and parameter at the bifurcation |
//! | `t` | direction of the known branch |
//! | `v` | unit vector with `F_X v = 0` and `t . v = 0` |
//!
//! Where two branches cross, `F_X` has two null vectors. A period doubling is such a crossing for
//! the equations of the doubled period, which the known branch solves as well. The first solution
//! of the other branch is sought in the hyperplane `v . (X - X_0) = delta`. Near `X_0` this
//! hyperplane is parallel to the known branch, so that it meets the other branch only. Source:
//! Keller 1977, in *Applications of Bifurcation Theory*, pp. 359-384.

use super::arclength::{self, BasePoint, FARTHEST, Family, Scales, Solution};
use crate::{
    error::{Error, Result},
    numerics::leading,
};
use nalgebra::DVector;

/// Values of `delta`, tried in this order.
const DISTANCES: [f64; 5] = [0.02, 0.01, 5e-3, 2.5e-3, 1.25e-3];
/// Two branches cross if the least singular value of `(F_X, t)` is at most this share of the next.
const SINGULAR: f64 = 1e-2;

/// Bifurcation `k` of a branch, from 0; in messages they are numbered from 1.
pub(super) fn numbered<T>(bifurcations: &[T], k: usize) -> Result<&T> {
    let rule = match bifurcations.len() {
        0 => "the branch has no bifurcation",
        _ => "bifurcations of the branch are numbered from 1",
    };
    let value = || format!("{} of {}", k.saturating_add(1), bifurcations.len());
    bifurcations.get(k).ok_or_else(|| Error::parameter("switch", value(), rule))
}

/// The vector `v` at a solution, with the first of its largest entries positive; `along` is `t`.
/// `None` if no other branch crosses there, or more than one.
pub(super) fn crossing(
    family: &dyn Family,
    (z, p): (&[f64], f64),
    scales: Scales,
    along: &DVector<f64>,
) -> Result<Option<DVector<f64>>> {
    let jacobian = arclength::extended(family, z, p, scales)?.jacobian;
    let rows = jacobian.nrows();
    let mut bordered = jacobian.insert_row(rows, 0.0);
    bordered.set_row(rows, &along.transpose());
    let svd = bordered.svd(false, true);
    let (values, Some(vectors)) = (svd.singular_values, svd.v_t) else { return Ok(None) };
    let last = values.len() - 1;
    let crosses = values[last] <= SINGULAR * values[last - 1];
    Ok(crosses.then(|| {
        let v = vectors.row(last).transpose();
        let sign = leading(v.iter().map(|entry| entry.abs())).map_or(1.0, |k| v[k].signum());
        v * sign
    }))
}

/// The first solution on the branch that leaves `X_0` in the direction `v`, and its `delta`.
pub(super) fn first(
    family: &dyn Family,
    (z, p): (&[f64], f64),
    scales: Scales,
    v: &DVector<f64>,
) -> Result<(Solution, f64)> {
    let base = BasePoint { z, p, tangent: v };
    let near = |delta: f64| {
        let solution = arclength::correct(family, base, scales, delta).ok()?;
        let chord = scales.chord((z, p), (&solution.z, solution.p)).norm();
        // A solution farther away may be one of the known branch.
        (chord <= FARTHEST * delta).then_some((solution, delta))
    };
    DISTANCES.into_iter().find_map(near).ok_or(Error::Stalled { steps: arclength::MOST_CORRECTIONS, best: None })
}

/// Whether a branch passed through zero between two points: one of doubled period through the
/// branch of half the period, where `before` and `now` are the state in the middle of each orbit
/// less the one at its start, or any branch through the state at rest. They have opposite signs on
/// the two sides.
pub(super) fn changed_places(before: &DVector<f64>, now: &DVector<f64>) -> bool {
    before.dot(now) < -0.5 * before.norm() * now.norm()
}
