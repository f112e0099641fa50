//! Resonances of the step with multiples of half a period, in schemes on the exact linear flow: the
//! flow itself makes no error, the kicks between do.
//!
//! One bead between walls under the static overlap `delta` never leaves them: its contacts are
//! springs of `K = 2 alpha delta^{alpha-1}`, and a step of any method is a matrix. Where an
//! eigenvalue leaves the unit circle the step is unstable, however small its errors are elsewhere.
//! A scheme with kicks `b_j` at times `c_j h` has this, to first order in `K`, where the fast
//! motion resonates with itself, and where it resonates with the slow one, of frequency `Omega_s =
//! sqrt(K/(1 + rho))`:
//!
//! | near | half width in `h omega` | growth a step in the middle |
//! |---|---|---|
//! | `k pi - s`, `s = K rho h/(2 omega (1 + rho))` | `s abs(S_k)` | `s abs(S_k)` |
//! | `k pi - h Omega_s`, `k` even | `2 g abs(S_{k/2})` | `g abs(S_{k/2})`, `g = h/2 Omega_s^{3/2} sqrt(rho/omega)` |
//!
//! with `S_k = sum_j b_j e^{2 pi i k c_j}`, of modulus 1 for Strang's. The second is a sum
//! resonance; it exists where resonators move and wins for small `K`. For Newton's cradle (`rho =
//! inf`) the interval of Strang's is exactly `k pi - 2 arctan(K h/(2 omega)) < h omega < k pi`.

use super::{
    measure::trial,
    problem::{Problem, Variant},
};
use crate::{
    error::{Result, require},
    numerics::{golden, largest_by},
    run::Records,
    run::method::{Method, Setting, Split},
};
use hertzchain_integrators::splitting::First;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Offsets from `k pi` at which a resonance is looked for: the first and the last in tenths of
/// decades, and the number of offsets in a tenth. They are dense enough to meet every resonance
/// that is wider than a hundredth of its offset.
const OFFSETS: (i32, i32, i32) = (-70, 1, 24);
/// Least growth a step of a resonance; less may be rounding.
const LEAST_GROWTH: f64 = 1e-6;
/// Share of the largest growth at the edges: an edge is thereby off by `5e-5` of the half width.
const EDGE: f64 = 1e-2;
/// Golden sections in the search for the largest growth.
const SECTIONS: u32 = 30;
/// Displacement for central differences, in units of `delta`.
const SHIFT: f64 = 1e-5;
/// Runs inside and beside a resonance have as many steps as a growth by `e^FOLDS` takes, up to
/// `MOST_STEPS`.
const FOLDS: f64 = 10.0;
const MOST_STEPS: f64 = 1e5;

/// A resonance of a scheme on the exact linear flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resonance {
    /// `h omega` at its edges.
    pub edges: [f64; 2],
    /// `h omega` of the largest growth.
    pub centre: f64,
    /// The largest growth a step, `ln |lambda|`.
    pub growth: f64,
    /// Largest energy error of the charted chain, not of the bead, at this amplitude, with the step
    /// of the centre. The run has as many steps as `growth` takes for `e^10`, up to 10^5. `None` if
    /// the error is not bounded.
    pub inside: Option<f64>,
    /// The same error with a step half-way to the resonance before, at `h omega = (k - 1/2) pi`.
    pub beside: Option<f64>,
}

/// The strongest resonance near `h omega = k pi` at amplitude `delta`; `None` where none stands
/// apart, or none grows by more than 10^-6 a step.
///
/// # Errors
/// A chain without resonators, a method that takes no steps, or a run that cannot start.
pub fn resonance(problem: &Problem, method: Method, k: u32, delta: f64) -> Result<Option<Resonance>> {
    let params = problem.chain.params();
    let (omega, near) = (params.omega(), PI * f64::from(k));
    require(omega != 0.0, "kappa", params.kappa, "resonances are of resonators: kappa and rho above zero")?;
    let growth = |h_omega: f64| growth(problem, method, delta, h_omega / omega);
    let (from, to, each) = OFFSETS;
    let offsets = (from * each..=to * each).map(|j| 10f64.powf(0.1 * f64::from(j) / f64::from(each)));
    let mut scanned = Vec::new();
    for offset in offsets.flat_map(|offset| [offset, -offset]) {
        scanned.push((near + offset, growth(near + offset)?));
    }
    scanned.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(top) = largest_by(0..scanned.len(), |&k| scanned[k].1) else { return Ok(None) };
    if scanned[top].1 < LEAST_GROWTH || top == 0 || top + 1 == scanned.len() {
        return Ok(None);
    }
    let mut sections = 0..SECTIONS;
    let bracket = [scanned[top - 1].0, scanned[top + 1].0];
    let between = golden(bracket, |_| sections.next().is_some(), growth, |value| *value)?;
    // If the search between the neighbours misses a narrow maximum, the scanned point is taken.
    let (centre, largest) = if between.1 > scanned[top].1 { between } else { scanned[top] };
    let quiet = |at: &&(f64, f64)| at.1 < EDGE * largest;
    let (Some(below), Some(above)) = (scanned[..top].iter().rfind(quiet), scanned[top + 1..].iter().find(quiet)) else {
        // It has no edge on one side: the contacts alone are too stiff for such steps.
        return Ok(None);
    };
    let edge = |outside: f64| bisect(centre, outside, &|x| Ok(growth(x)? >= EDGE * largest));
    let edges = [edge(below.0)?, edge(above.0)?];
    let steps = (FOLDS / largest).clamp(100.0, MOST_STEPS).round();
    let error = |h_omega: f64| -> Result<Option<f64>> {
        let mut prepared = problem.prepare(&Variant { amplitude: Some(delta), ..Variant::default() })?;
        prepared.scene = prepared.scene.until(steps * h_omega / omega)?;
        Ok(trial(&prepared, method, h_omega / omega, f64::INFINITY)?.error)
    };
    let (inside, beside) = (error(centre)?, error(near - 0.5 * PI)?);
    Ok(Some(Resonance { edges, centre, growth: largest, inside, beside }))
}

/// Growth a step of length `h` of the bead between walls, `ln` of the spectral radius of the step's
/// matrix.
///
/// One step and two have the matrices `P K Q` and `P K^2 Q` where a kernel `K` is processed by `Q`
/// before and by `P` after: the second over the first has the spectrum of the kernel.
fn growth(problem: &Problem, method: Method, delta: f64, h: f64) -> Result<f64> {
    let one = step_matrix(problem, method, delta, h, 1)?;
    let matrix = match method {
        Method::Corrected(..) => {
            let two = step_matrix(problem, method, delta, h, 2)?;
            one.transpose().lu().solve(&two.transpose()).map_or(one, |kernel| kernel.transpose())
        }
        _ => one,
    };
    let radius = matrix.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max);
    Ok(radius.ln())
}

/// The derivative of the map of `steps` steps of length `h`, by central differences.
fn step_matrix(problem: &Problem, method: Method, delta: f64, h: f64, steps: u64) -> Result<DMatrix<f64>> {
    let span = steps as f64 * h;
    let dim = problem.pressed(1, delta, 0, 0.0, span)?.initial().as_slice().len();
    let mut matrix = DMatrix::zeros(dim, dim);
    for entry in 0..dim {
        for sign in [1.0, -1.0] {
            let shift = sign * SHIFT * delta;
            let scene = problem.pressed(1, delta, entry, shift, span)?;
            let run = scene.run().method(method).setting(Setting::Steps(steps)).records(Records::End);
            let y = run.start()?.complete()?.state;
            for (row, value) in y.iter().enumerate() {
                matrix[(row, entry)] += value / (2.0 * shift);
            }
        }
    }
    Ok(matrix)
}

/// `|S_k| = |sum_j b_j e^{2 pi i k c_j}|` of a scheme on the exact linear flow, kicks `b_j h` at
/// times `c_j h`; `None` for other methods.
pub fn kick_sum(method: &Method, k: u32) -> Option<f64> {
    if let Method::Corrected(_) = method {
        return Some(1.0);
    }
    let Method::Splitting(scheme, Split::Linear) = method else { return None };
    let (first, drifts, kicks) = scheme.flows::<f64>(First::Drift);
    let mut time = 0.0;
    let (mut re, mut im) = (0.0, 0.0);
    for (j, kick) in kicks.iter().enumerate() {
        let before = if first == First::Drift { Some(j) } else { j.checked_sub(1) };
        time += before.map_or(0.0, |j| drifts[j].value());
        let (sin, cos) = (2.0 * PI * f64::from(k) * time).sin_cos();
        (re, im) = (re + kick.value() * cos, im + kick.value() * sin);
    }
    Some(f64::hypot(re, im))
}

/// The place between `good` and `bad` where a condition that holds at `good` ends, by bisection.
fn bisect(mut good: f64, mut bad: f64, holds: &dyn Fn(f64) -> Result<bool>) -> Result<f64> {
    for _ in 0..40 {
        let middle = 0.5 * (good + bad);
        *(if holds(middle)? { &mut good } else { &mut bad }) = middle;
    }
    Ok(0.5 * (good + bad))
}
