//! Section 3: the modulation equations, their limit of heavy resonators, and the theorem on this
//! limit.
//!
//! | symbol | meaning |
//! |---|---|
//! | `F` | left factor of the DpS equations, `F dA/dtau = delta^+ [h D]` |
//! | `A(0)` | initial state of the theorem: random numbers times a Gaussian, [`Initial::Generic`] |

use super::{
    Group, Quantity, Runs,
    measure::{measured_slow_frequency, slope, small_wave},
};
use crate::{
    breathers::BrightBreather,
    chain::{Boundary, Chain, Params, Site, State, max_norm},
    dps::{Averages, Center, Constraint, Dps, Ends, Form, Layout, per_gamma},
    error::Result,
    run::state_at,
    study::{self, Initial, Norm, RhoLaw, TheoremOptions},
    waves::{Modulation, Shape},
};
use hertzchain_integrators::collocation::Pace;
use num_complex::Complex64;
use std::f64::consts::PI;

pub(super) const GROUPS: &[Group] =
    &[Group::of(expansion), Group::of(factor), Group::of(heavy_resonators), Group::of(theorem)];

/// Spring constant other than 1, so that wrong powers of kappa are noticed.
const KAPPA: f64 = 2.5;

/// `c_alpha`, as printed below (disp).
pub(super) fn c_alpha(alpha: f64) -> f64 {
    per_gamma(0.5 * (alpha + 1.0) + 1.0) / (PI * per_gamma(0.5) * per_gamma(0.5 * alpha + 1.0))
}

/// The steps of Sec. 3.1 to the equations.
fn expansion(_: &Runs) -> Result<Vec<Quantity>> {
    let params = Params::new(1.5, KAPPA, 0.7)?;
    Ok(vec![
        ("s3.1-harmonics", (2..=50).map(|j| determinant(params, f64::from(j)).abs()).fold(f64::INFINITY, f64::min)),
        ("s3.1-D1", second_projection(params)),
        ("s3.1-averages", projections()?),
    ])
}

/// `det_j / omega^4` of the system of the `j`-th harmonic.
fn determinant(params: Params, j: f64) -> f64 {
    let Params { kappa, rho, .. } = params;
    let square = (j * params.omega()).powi(2);
    ((kappa - square) * (kappa / rho - square) - kappa * kappa / rho) / params.omega().powi(4)
}

/// `-rho D^1 / (C^1 + 2 i omega dA/dtau)`, with `D^1` from
/// `-(kappa/rho) C^1 - kappa D^1 = (2 kappa/rho) i omega dA/dtau`.
fn second_projection(params: Params) -> f64 {
    let Params { kappa, rho, .. } = params;
    let (c, slope) = (Complex64::new(0.4, -1.1), Complex64::new(0.3, 0.8));
    let source = 2.0 * params.omega() * Complex64::i() * slope;
    let d = -(source * (kappa / rho) + c * (kappa / rho)) / kappa;
    (-rho * d / (c + source)).re
}

/// Largest difference of `g` and `z h` from the mean and the first harmonic of the force, which the
/// midpoint rule computes.
fn projections() -> Result<f64> {
    const COUNT: u32 = 20_000;
    let (averages, z) = (Averages::new(1.5, KAPPA)?, Complex64::from_polar(0.6, 0.9));
    let apart = |b: f64| {
        let nodes = (0..COUNT).map(|k| 2.0 * PI * (f64::from(k) + 0.5) / f64::from(COUNT));
        let (mean, first) = nodes.fold((0.0, Complex64::ZERO), |(mean, first), t| {
            let force =
                (-b + 2.0 * KAPPA * (z * Complex64::from_polar(1.0, t)).re).max(0.0).powf(1.5) / f64::from(COUNT);
            (mean + force, first + Complex64::from_polar(force, -t))
        });
        (mean - averages.g(b, z.norm())).abs().max((first - z * averages.h(b, z.norm())).norm())
    };
    Ok([-5.0, -2.0, 0.0, 1.5, 3.5].map(apart).into_iter().fold(0.0, f64::max))
}

/// The factor of (eq:S1), measured on the chain.
fn factor(_: &Runs) -> Result<Vec<Quantity>> {
    let wave = small_wave(KAPPA, 0.3)?;
    let corrected = (wave.omega_tw() - wave.params().omega()) / wave.slow_time(1.0);
    Ok(vec![("s3.1-factor", corrected / measured_slow_frequency(&wave)?)])
}

/// The formulas of Sec. 3.2 up to the theorem.
fn heavy_resonators(_: &Runs) -> Result<Vec<Quantity>> {
    let rigid = |rho: f64| Params::new(1.5, KAPPA, rho);
    let omega_0 = |alpha: f64| {
        2f64.powf(alpha - 2.0) * per_gamma(0.5 * (alpha + 1.0) + 1.0) / (PI.sqrt() * per_gamma(0.5 * alpha + 1.0))
    };
    let worst = |ratio: &dyn Fn(f64) -> Result<f64>| -> Result<f64> {
        let ratios = [1.2, 1.5, 2.0, 3.0].into_iter().map(ratio).collect::<Result<Vec<_>>>()?;
        Ok(ratios.into_iter().max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs())).unwrap_or(f64::NAN))
    };
    let shape = Shape { q: 0.2 * PI, a: 1.0, b: 0.0, phi: 0.0 };
    Ok(vec![
        ("s3.2-omega", rigid(1e12)?.omega() / KAPPA.sqrt()),
        ("s3.2-critical", 1e6 * (rigid(1e6)?.omega() / KAPPA.sqrt() - 1.0)),
        ("s3.2-V1", resonator_share(rigid(1e6)?)?),
        ("s3.2-cradle", resonators_at_rest()?),
        ("s3.2-limit", heavy_limit(rigid(1e12)?)?),
        ("s3.2-omega0", worst(&|alpha| Ok(Averages::new(alpha, 1.0)?.h(0.0, 1.0) / (2.0 * omega_0(alpha))))?),
        ("s3.2-omega0-c", worst(&|alpha| Ok(omega_0(alpha) / (2f64.powf(alpha - 2.0) * c_alpha(alpha))))?),
        (
            "s3.2-tau0",
            4.0 * omega_0(1.5)
                / Modulation::new(Params::new(1.5, 1.0, f64::INFINITY)?, Shape { q: PI, ..shape })?.slow_frequency(),
        ),
    ])
}

/// `-rho V / U` for the amplitudes of the linear oscillation of one site, from a run of the chain
/// over half a period.
fn resonator_share(params: Params) -> Result<f64> {
    let chain = Chain::new(params, Boundary::Free, 1)?;
    let u = 1.0;
    let start = State::from_fn(&chain, |_| Site { u, v: -u / params.rho, u_dot: 0.0, v_dot: 0.0 })?;
    let half = PI / params.omega();
    let mut run = chain.collocation(start.as_slice(), (0.0, half), Pace::Tolerance(1e-13))?;
    let y = state_at(&mut run, half)?;
    // Differences between the start and half a period later: the mean cancels, and there is no
    // drift.
    Ok(-params.rho * (y[1] - start.as_slice()[1]) / (y[0] - u))
}

/// Largest `rho |v|` divided by the largest `|u|`, at 200 times up to the horizon, of a breather
/// with very heavy resonators that start at rest.
fn resonators_at_rest() -> Result<f64> {
    let params = Params::new(1.5, 1.0, 1e9)?;
    let breather = BrightBreather::new(params, Center::Bond, 0.01, 40)?;
    let chain = Chain::new(params, Boundary::Free, 40)?;
    let start = State::from_fn(&chain, |n| breather.site(n, 0.0))?;
    let mut run = chain.collocation(start.as_slice(), (0.0, breather.horizon()), Pace::Tolerance(1e-10))?;
    let largest = |values: &[f64]| max_norm(values.iter().copied());
    let (mut u, mut v) = (0.0f64, 0.0f64);
    for k in 0..=200 {
        let y = state_at(&mut run, breather.horizon() * f64::from(k) / 200.0)?;
        (u, v) = (u.max(largest(&y[..40])), v.max(largest(&y[40..80])));
    }
    Ok(params.rho * v / u)
}

/// `F / (2 i kappa^{3/2})`: the slope of the DpS equation divided by that of the generalised ones,
/// for a wave with `b = 0`.
fn heavy_limit(params: Params) -> Result<f64> {
    let layout = Layout { sites: 10, ends: Ends::Ring, form: Form::Strains };
    let phase = |n: u32| -0.2 * PI * f64::from(n);
    let z: Vec<f64> = (0..10).map(|n| phase(n).cos()).chain((0..10).map(|n| phase(n).sin())).collect();
    let force = Averages::new(params.alpha, params.kappa)?.g(0.0, 1.0);
    let plain = slope(Dps::plain(params.alpha, params.kappa, layout)?, &z);
    let general = slope(Dps::generalised(params, Constraint::Force(force), layout)?, &z);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    Ok(dot(&plain, &general) / dot(&general, &general))
}

/// Theorem 1 in the norm `l_inf`, also with resonators that are lighter than it requires.
fn theorem(_: &Runs) -> Result<Vec<Quantity>> {
    // Growth of sup / epsilon^power over a decade of epsilon: 1 for a sharp bound, less for a
    // bound that is not sharp.
    let decade = |rho_law: RhoLaw| -> Result<[f64; 3]> {
        let (initial, epsilons) = (Initial::Generic, vec![1e-4, 1e-5]);
        let options = TheoremOptions { horizon: 2.0, rho_law, initial, epsilons, ..TheoremOptions::default() };
        let study = study::theorem(&options, None, &|_| {})?;
        let [coarse, fine] = [0, 1].map(|k| study.scaled(&study.runs[k], Norm::Infinity).0);
        Ok([0, 1, 2].map(|k| fine[k] / coarse[k]))
    };
    let [u, v, v_dot] = decade(RhoLaw::Heavy)?;
    let [u_light, ..] = decade(RhoLaw::Light)?;
    Ok(vec![("s3.2-theorem-u", u), ("s3.2-theorem-v", v), ("s3.2-theorem-vdot", v_dot), ("s3.2-theorem-rho", u_light)])
}
