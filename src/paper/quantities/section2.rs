//! Section 2: the limits of light and of heavy resonators, on the chain.

use super::{Group, Quantity, Runs, measure::started};
use crate::{
    chain::{Boundary, Params, Site, max_norm},
    error::Result,
    run::state_at,
};

pub(super) const GROUPS: &[Group] = &[Group::of(limits)];

const SITES: usize = 8;
/// End of the runs: an impact on the first bead has reached the last.
const END: f64 = 10.0;

/// Displacements of the beads at the end. The first bead starts with velocity 1, and its resonator
/// with it if `along`; all else is at rest.
fn impact(rho: f64, along: bool) -> Result<Vec<f64>> {
    let site = |n| {
        let u_dot = f64::from(n == 0);
        Site { u: 0.0, v: 0.0, u_dot, v_dot: if along { u_dot } else { 0.0 } }
    };
    let mut run = started(Params::new(1.5, 1.0, rho)?, (Boundary::Free, SITES), &site, (END, 1e-11))?;
    Ok(state_at(&mut run, END)?[..SITES].to_vec())
}

/// The distance of the beads from those of the limit `rho = limit`, at the second mass ratio
/// divided by that at the first.
fn nearer(limit: f64, rhos: [f64; 2]) -> Result<f64> {
    let along = limit == 0.0;
    let end = impact(limit, along)?;
    let distance = |rho| -> Result<f64> { Ok(max_norm(impact(rho, along)?.iter().zip(&end).map(|(a, b)| a - b))) };
    Ok(distance(rhos[1])? / distance(rhos[0])?)
}

/// The limits below (eq:HertzS).
fn limits(_: &Runs) -> Result<Vec<Quantity>> {
    Ok(vec![("s2-light", nearer(0.0, [1e-3, 1e-4])?), ("s2-heavy", nearer(f64::INFINITY, [1e3, 1e4])?)])
}
