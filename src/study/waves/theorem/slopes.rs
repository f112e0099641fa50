//! Local slopes of the suprema, their limits, and the verdict on them.
//!
//! | symbol | meaning |
//! |---|---|
//! | `s_k` | `ln(E_k / E_{k+1}) / ln(epsilon_k / epsilon_{k+1})`, less the power of the theorem |
//! | `s` | its limit: a line in `epsilon^{alpha-1}`, the order of what the theorem leaves out, through the `s_k` of the last two decades, at zero |
//! | `d` | uncertainty of `s`: misfit of the line, or how far the last `s_k` is from `s` if that is more; sampling error; and what the end of the run cuts |
//! | | off: an error that grows until then has its maxima at phases, so its supremum may be that of a period `2 pi` earlier, a share `2 pi epsilon^{alpha-1}/T` |

use super::{Norm, TheoremOptions, TheoremRun, powers};
use crate::{named::named, study::fit_line};
use std::f64::consts::PI;

/// A scaled supremum may grow like `epsilon^-0.03` and count as bounded.
const LEAST: f64 = -0.03;
/// A limit is taken only if the smallest size has `max(1, T) epsilon^{alpha-1}` up to this, since
/// what the theorem leaves out is of the next order in `epsilon^{alpha-1}` and grows with `T`.
const NEAR: f64 = 0.02;
/// The line is fitted to sizes up to this many times the smallest, with a margin for rounding.
const DECADES: f64 = 100.0 * (1.0 + 1e-9);
/// Largest distance of the last slope from the limit. Farther away, slopes have not converged.
const SETTLED: f64 = 0.05;

named! {
    /// Whether a supremum over its power of `epsilon` is bounded as `epsilon` goes to zero: bounded
    /// if `s - d >= -0.03`, violated if `s + d < -0.03`, undecided otherwise, and where the sizes
    /// given do not tell, see [`RULE`](Bound::RULE). The largest of several is that of them all.
    #[derive(PartialOrd, Ord)]
    pub enum Bound {
        /// The scaled supremum is bounded.
        Bounded = "bounded",
        /// The sizes given do not tell.
        Undecided = "undecided",
        /// The scaled supremum grows.
        Violated = "violated",
    }
}

impl Bound {
    /// The rule in words.
    pub const RULE: &'static str = "Let s be the limit of the local slopes less the power of the theorem: the value at zero of a line in epsilon^(alpha-1) \
        through those of the last two decades of epsilon; and d its uncertainty: misfit of the line, or the distance of the last slope from s if that is \
        more, and what sampling and the end of the run, at any phase, make of a slope. Bounded: s - d >= -0.03. Violated: s + d < -0.03. Undecided: \
        otherwise, or fewer than two slopes there, or max(1, T) epsilon^(alpha-1) > 1/50 at the smallest epsilon, or the last slope more than 0.05 from s.";

    /// The verdict on a limit and its uncertainty.
    pub fn from(limit: Option<(f64, f64)>) -> Self {
        match limit {
            Some((s, d)) if s - d >= LEAST => Self::Bounded,
            Some((s, d)) if s + d < LEAST => Self::Violated,
            _ => Self::Undecided,
        }
    }
}

/// The local slopes of one error in one norm.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoremSlope {
    /// Norm.
    pub norm: Norm,
    /// 0, 1, 2 for `u, v, v'`.
    pub quantity: usize,
    /// The power that the theorem bounds the error with.
    pub power: f64,
    /// The power that its proof bounds the error with at this law of `rho`: (estimr1) and
    /// (estimrp); `None` if `rho` is constant.
    pub expected: Option<f64>,
    /// The local slopes, from large to small sizes; not a number where an error is zero.
    pub local: Vec<f64>,
    /// The limit of the slopes, and its uncertainty.
    pub limit: Option<(f64, f64)>,
    /// The verdict.
    pub bound: Bound,
}

pub(super) fn of_all(options: &TheoremOptions, runs: &[TheoremRun]) -> Vec<TheoremSlope> {
    let expected = options.rho_law.exponent(options.alpha).map(|gamma| {
        let secular = gamma + 2.0 - options.alpha;
        [secular, secular, gamma + 1.0]
    });
    let of = |norm: Norm, quantity: usize| {
        let power = powers(options.alpha)[quantity];
        let points = runs.iter().map(|run| Point {
            epsilon: run.epsilon,
            error: run.suprema[norm.index()].0[quantity],
            missed: run.sampling_errors[norm.index()].0[quantity],
        });
        let points: Vec<Point> = points.collect();
        let limit = limit(options, power, &points);
        // Errors of resonators that never move are zero, and so bounded.
        let still = points.iter().all(|point| point.error == 0.0);
        TheoremSlope {
            norm,
            quantity,
            power,
            expected: expected.map(|expected| expected[quantity]),
            local: points.windows(2).map(slope).collect(),
            limit: limit.map(|(s, d)| (s + power, d)),
            bound: if still { Bound::Bounded } else { Bound::from(limit) },
        }
    };
    Norm::ALL.into_iter().flat_map(|norm| (0..3).map(move |quantity| (norm, quantity))).map(|(n, q)| of(n, q)).collect()
}

/// An error at a size.
pub struct Point {
    /// Size.
    pub epsilon: f64,
    /// The error.
    pub error: f64,
    /// The share of it that samples miss.
    pub missed: f64,
}

fn slope(pair: &[Point]) -> f64 {
    (pair[0].error / pair[1].error).ln() / (pair[0].epsilon / pair[1].epsilon).ln()
}

/// The limit `s` of the local slopes less `power`, and its uncertainty `d`; `None` if the sizes do
/// not tell.
pub fn limit(options: &TheoremOptions, power: f64, points: &[Point]) -> Option<(f64, f64)> {
    let &TheoremOptions { alpha, horizon, .. } = options;
    let smallest = points.last()?.epsilon;
    let pairs: Vec<&[Point]> = points.windows(2).filter(|pair| pair[0].epsilon <= DECADES * smallest).collect();
    if horizon.max(1.0) * smallest.powf(alpha - 1.0) > NEAR * (1.0 + 1e-9) || pairs.len() < 2 {
        return None;
    }
    let middle = |pair: &[Point]| (pair[0].epsilon * pair[1].epsilon).sqrt().powf(alpha - 1.0);
    let line: Vec<(f64, f64)> = pairs.iter().map(|pair| (middle(pair), slope(pair) - power)).collect();
    let (rate, misfit) = fit_line(&line)?;
    let mean = |of: fn(&(f64, f64)) -> f64| line.iter().map(of).sum::<f64>() / line.len() as f64;
    let s = mean(|point| point.1) - rate * mean(|point| point.0);
    let off = (s - line.last()?.1).abs();
    let per_step = |share: f64, pair: &[Point]| share / (pair[0].epsilon / pair[1].epsilon).ln();
    let noise = pairs.iter().map(|pair| per_step(pair[0].missed.max(pair[1].missed), pair)).fold(0.0, f64::max);
    let cut = per_step(2.0 * PI * smallest.powf(alpha - 1.0) / horizon, pairs.last()?);
    (off <= SETTLED).then_some((s, misfit.max(off) + noise + cut))
}
