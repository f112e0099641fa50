//! Experiments: data in, data out; nothing is drawn or printed here.

mod breather;
mod charts;
mod checkpoint;
mod compare;
mod drift;
mod evolve;
mod lifetimes;
mod orbits;
mod order;
mod scaling;
mod stability;
mod theorem;
mod wave;

pub use breather::{
    BreatherOptions, BrightHistory, BrightSample, BrightStudy, Kink, Shown, TrivialStudy, bright_breather,
    bright_history, trivial_breather,
};
pub use charts::{
    BOUNDS, Chart, ChartOptions, ChartPoint, ChartStudy, Limit, Measured, Problem, Resonance, ResonancePoint, Trial,
    Variant, Verdict as ChartVerdict, charts, kick_sum, resonance,
};
pub use checkpoint::LongRun;
pub use compare::{CompareOptions, Comparison, Reference, Row, compare};
pub use drift::{DriftOptions, DriftRow, DriftStudy, drift};
pub use evolve::{Evolution, Kick, Motion, Swing, evolve};
pub use lifetimes::{Criterion, Fate, Life, LifetimeOptions, LifetimePoint, LifetimeStudy, PowerLaw, lifetimes};
pub use orbits::{Branch, BranchPoint, DoubledBranch, OrbitStudy, Progress, branch, doubled, orbit_study};
pub use orbits::{Keep, begin, doubled_from, go_on, main_branch, study};
pub use order::{Mode, OrderRow, OrderStudy, Quantity, generic_state, order, theory};
pub use scaling::{ScalingOptions, ScalingRow, ScalingStudy, scaling};
pub use stability::{MeasuredGrowth, Rates, StabilityChart, StabilityOptions, StabilityRow, StabilityStudy, stability};
pub use theorem::{
    Bound, Errors as TheoremErrors, Initial, Norm, RhoLaw, Sampling, TheoremOptions, TheoremRun, TheoremSlope,
    TheoremStudy, theorem,
};
pub use wave::{Ensemble, Envelopes, Errors, Member, PerturbedRun, Spread, Strains, WaveOptions, WaveStudy, wave};

/// Least-squares slope, and the largest residual.
pub(crate) fn fit_line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (sxx, sxy) =
        points.iter().fold((0.0, 0.0), |(xx, xy), p| (xx + (p.0 - mx).powi(2), xy + (p.0 - mx) * (p.1 - my)));
    let slope = (sxx > 0.0).then(|| sxy / sxx)?;
    let residual = points.iter().map(|p| (p.1 - my - slope * (p.0 - mx)).abs()).fold(0.0, f64::max);
    Some((slope, residual))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_fitted_and_a_bend_is_seen() {
        let line: Vec<_> = (0..4).map(|i| (f64::from(i), 2.5 * f64::from(i) - 7.0)).collect();
        let (slope, residual) = fit_line(&line).unwrap();
        assert!((slope - 2.5).abs() < 1e-14 && residual < 1e-14);
        assert!(fit_line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 2.0)]).unwrap().1 > 0.3);
        assert!(fit_line(&[(1.0, 0.0)]).is_none());
    }
}
