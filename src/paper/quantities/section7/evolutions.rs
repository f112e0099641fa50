//! Evolutions of the breathers at `rho = 1/3` on the chain.
//!
//! Rounding errors of a run grow by `|lambda|^m` over `m` periods. Once they have the size of the
//! breather, only sizes are properties of the chain; other numbers depend on the rounding errors.

use super::{
    super::{Quantity, Runs},
    THIRD, least, most, released,
};
use crate::{dps::Center, error::Result, study::Evolution, sweep::map};

const UNTIL: f64 = 1200.0;
/// The range of `E_b` over which its growth rate is measured: from slightly above rounding errors
/// to a value that is no longer small.
const SMALL: [f64; 2] = [1e-12, 1e-2];

/// Several runs in parallel, each with frequency, end and kick.
fn runs<const N: usize>(center: Center, of: [(f64, f64, Option<f64>); N]) -> Result<[Evolution; N]> {
    let run = |&(omega_b, until, kick): &_| released(THIRD, center, omega_b, until, kick);
    let runs: Vec<Evolution> = map(&of, run).into_iter().collect::<Result<_>>()?;
    Ok(runs.try_into().unwrap_or_else(|_| unreachable!("each has its run")))
}

fn last(run: &Evolution) -> f64 {
    run.e_b.last().copied().unwrap_or(f64::NAN)
}

fn largest(run: &Evolution) -> f64 {
    most(run.e_b.iter().copied())
}

/// The rate at which `E_b` grows while it is small, divided by `ln abs(lambda)`.
fn rate(run: &Evolution) -> f64 {
    let at = |bound: f64| run.e_b.iter().position(|&e_b| e_b > bound);
    let [Some(from), Some(to)] = SMALL.map(at) else { return f64::NAN };
    let per_period = run.amplification.ln() / (run.times.len() - 1) as f64;
    (run.e_b[to] / run.e_b[from]).ln() / (to - from) as f64 / per_period
}

/// Displacement of the kink at the end, in sites.
fn gone(run: &Evolution) -> f64 {
    run.position.last().map_or(f64::NAN, |end| (end - run.position[0]).abs())
}

/// Time at which the kink is displaced by a site.
fn leaves(run: &Evolution) -> f64 {
    let away = |position: &f64| (position - run.position[0]).abs() >= 1.0;
    run.position.iter().position(away).map_or(f64::NAN, |m| run.times[m])
}

/// Return errors of the site-centred breathers.
pub(in super::super) fn site(_: &Runs) -> Result<Vec<Quantity>> {
    let runs = runs(Center::Site, [2.05, 2.07, 2.077, 2.08, 2.09].map(|omega_b| (omega_b, UNTIL, None)))?;
    let [long_lived, _, before, after, broken] = &runs;
    Ok(vec![
        ("s7-Eb1200", most(runs[..3].iter().map(last))),
        ("s7-Eb1200-multipliers", most(runs[..3].iter().map(|run| last(run) / run.amplification))),
        ("s7-Eb1200-growth", after.amplification / before.amplification),
        ("s7-Eb1200-after", largest(after)),
        ("s7-Eb-rate", rate(after)),
        ("s7-long-lived", largest(long_lived)),
        ("s7-site-breaks", largest(broken)),
    ])
}

/// Return errors and motion of the bond-centred breathers.
pub(in super::super) fn bond(_: &Runs) -> Result<Vec<Quantity>> {
    let runs = runs(
        Center::Bond,
        [(2.05, 2.0 * UNTIL, None), (2.05, UNTIL, Some(0.01)), (2.08, UNTIL, None), (2.1, UNTIL, None)],
    )?;
    let [alone, kicked, broken @ ..] = &runs;
    Ok(vec![
        ("s7-bond-moves", gone(alone)),
        ("s7-bond-kick", leaves(alone) / leaves(kicked)),
        ("s7-bond-velocity", alone.motion.last().map_or(f64::NAN, |motion| motion.misfit)),
        ("s7-bond-breaks", least(broken.iter().map(largest))),
    ])
}
