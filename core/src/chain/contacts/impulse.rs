//! The impulse of a stretch of overlap, `int f dt`.

use super::super::gauss::{NODES as POINTS, nodes};
use hertzchain_integrators::{
    events::{Curve, NODES, Part, SHARES},
    regularised::TimeMap,
};

/// A stretch whose overlap at an end is below this share of its largest one ends with an event.
/// Chosen, not measured.
const SINGULAR: f64 = 1e-6;

/// Quadrature of functions of an overlap and its rate over a stretch of time, in a variable in
/// which they are smooth at ends where the overlap vanishes.
#[derive(Clone, Debug)]
pub(super) struct Quadrature {
    /// The rules for stretches whose overlap vanishes at neither end, at the end, at the start, at
    /// both.
    rules: [Rule; 4],
    /// Whether functions depend on the rate.
    rated: bool,
}

/// The rule for one kind of stretch. Matrices have a row for each node of a stretch and a column
/// for each point of the rule.
#[derive(Clone, Debug)]
struct Rule {
    weights: [f64; POINTS],
    /// From values at nodes to values at points.
    values: [[f64; POINTS]; NODES],
    /// From values at nodes to derivatives at points.
    slopes: [[f64; POINTS]; NODES],
}

impl Quadrature {
    /// The quadrature of functions that are smooth in `t^{1/q}`, where `t` is the time since the
    /// overlap was zero. `rated`: whether they depend on the rate.
    pub(super) fn new(q: u32, rated: bool) -> Self {
        let power = |singular: bool| if singular { q } else { 1 };
        let rule = |ends| Rule::new(TimeMap::new(1.0, power(ends > 1), power(ends % 2 > 0)));
        Self { rules: std::array::from_fn(rule), rated }
    }

    /// `int f dt`; `f` gets the overlap and its rate, which is zero if functions do not depend on
    /// it.
    pub(super) fn integral(&self, part: &Part<f64>, f: impl Fn(f64, f64) -> f64) -> f64 {
        let duration = part.span.1 - part.span.0;
        if duration == 0.0 {
            // A rate of the overlap would be no number.
            return 0.0;
        }
        let small = SINGULAR * part.values.iter().fold(0.0, |largest, &g| f64::max(largest, g));
        let [start, end] = [part.values[0], part.values[NODES - 1]].map(|g| usize::from(g <= small));
        let Rule { weights, values, slopes } = &self.rules[2 * start + end];
        let g = at_points(values, &part.values);
        let slope = if self.rated { at_points(slopes, &part.values) } else { [0.0; POINTS] };
        duration * (0..POINTS).map(|k| weights[k] * f(g[k], slope[k] / duration)).sum::<f64>()
    }
}

impl Rule {
    fn new(share: TimeMap<f64>) -> Self {
        let points = nodes(0.0, 1.0).map(|(s, weight)| (share.at(s), weight * share.rate(s)));
        // Lagrange's polynomial of each node, and its derivative.
        let value = |j: usize, k: usize| (SHARES[k], f64::from(u8::from(j == k)));
        let basis: [_; NODES] = std::array::from_fn(|j| Curve::over((0.0, 1.0), (0..NODES).map(|k| value(j, k))));
        Self {
            weights: points.map(|(_, weight)| weight),
            values: basis.map(|curve| points.map(|(x, _)| curve.at(x)[1])),
            slopes: basis.map(|curve| points.map(|(x, _)| curve.at(x)[2])),
        }
    }
}

/// The sum of rows, each times the value at its node.
fn at_points(rows: &[[f64; POINTS]; NODES], values: &[f64; NODES]) -> [f64; POINTS] {
    let mut sums = [0.0; POINTS];
    for (row, value) in rows.iter().zip(values) {
        for (sum, entry) in sums.iter_mut().zip(row) {
            *sum += entry * value;
        }
    }
    sums
}
