//! Section 3: the modulation equations, their limit of heavy resonators, and the theorem on this
//! limit.
//!
//! | symbol | meaning |
//! |---|---|
//! | `F` | left factor of the DpS equations, `F dA/dtau = delta^+ [h D]` |
//! | `A(0)` | initial state of the theorem: random numbers times a Gaussian, [`Initial::Generic`] |

use super::{
    Group, Quantity, Runs,
    measure::{measured_slow_frequency, off_beat, sampled, slope, small_wave, started},
};
use crate::{
    breathers::BrightBreather,
    chain::{Boundary, Params, Site, max_norm},
    dps::{Averages, Center, Constraint, Dps, Ends, Form, Layout, per_gamma},
    error::{Error, Result},
    numerics::largest_by,
    run::state_at,
    study::{self, Initial, Norm, RhoLaw, TheoremOptions},
    sweep::Engine,
    waves::{Modulation, Shape},
};
use hertzchain_integrators::{Dop853, VectorField, dop853::Options};
use num_complex::Complex64;
use std::f64::consts::PI;

pub(super) const GROUPS: &[Group] =
    &[Group::of(expansion), Group::of(factor), Group::of(heavy_resonators), Group::of(theorem), Group::of(proof)];

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
        Ok(largest_by(ratios, |ratio| (ratio - 1.0).abs()).unwrap_or(f64::NAN))
    };
    let shape = Shape { q: 0.2 * PI, a: 1.0, b: 0.0, phi: 0.0 };
    Ok(vec![
        ("s3.2-omega", rigid(1e12)?.omega() / KAPPA.sqrt()),
        ("s3.2-critical", 1e6 * (rigid(1e6)?.omega() / KAPPA.sqrt() - 1.0)),
        ("s3.2-V1", resonator_share(rigid(1e6)?)?),
        ("s3.2-critical-flow", distance_from(Critical, 1e-5)? / distance_from(Critical, 1e-4)?),
        ("s3.2-critical-term", distance_from(|plain| plain, 1e-5)? / distance_from(|plain| plain, 1e-4)?),
        ("s3.2-cradle", resonators_at_rest(1e8)?[1] / resonators_at_rest(1e9)?[1]),
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
    let (u, v, half) = (1.0, -params.rho.recip(), PI / params.omega());
    let mut run = started(params, (Boundary::Free, 1), &|_| Site { u, v, u_dot: 0.0, v_dot: 0.0 }, (half, 1e-13))?;
    let y = state_at(&mut run, half)?;
    // Differences between the start and half a period later: the mean cancels, and there is no
    // drift.
    Ok(-params.rho * (y[1] - v) / (y[0] - u))
}

/// Largest `|v|` up to half of the horizon and up to the horizon, at 200 times, of a breather with
/// heavy resonators that start at rest.
fn resonators_at_rest(rho: f64) -> Result<[f64; 2]> {
    let params = Params::new(1.5, 1.0, rho)?;
    let breather = BrightBreather::new(params, Center::Bond, 0.01, 40)?;
    let end = breather.horizon();
    let run = started(params, (Boundary::Free, 40), &|n| breather.site(n, 0.0), (end, 1e-10))?;
    let mut largest = Vec::new();
    sampled(run, (end, 200), |_, y| {
        largest.push(max_norm(y[40..80].iter().copied()));
        Ok(())
    })?;
    Ok([100, 200].map(|last| max_norm(largest[..=last].iter().copied())))
}

/// The critical equation `2 i kappa^{3/2} dA/dtau + kappa^2 A = J[G(U^0)]` with `B = 0`, for
/// strains: the DpS equation, and a turn of `A` at the rate `kappa^2 / (2 kappa^{3/2})`.
struct Critical(Dps);

impl VectorField<f64> for Critical {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn eval(&mut self, tau: f64, z: &[f64], dz: &mut [f64]) {
        self.0.eval(tau, z, dz);
        let (half, rate) = (z.len() / 2, 0.5 * KAPPA.sqrt());
        for n in 0..half {
            dz[n] -= rate * z[half + n];
            dz[half + n] += rate * z[n];
        }
    }
}

/// Largest distance of the beads of a chain with `rho = epsilon^{1-alpha}` from the flow of an
/// equation, over `epsilon^alpha`, up to the slow time 2: a wave with `q = 4 pi/5` and `b = 0`.
fn distance_from<F: VectorField<f64>>(flow: impl Fn(Dps) -> F, epsilon: f64) -> Result<f64> {
    const SITES: usize = 5;
    let (slowness, omega) = (epsilon.sqrt(), KAPPA.sqrt());
    let layout = Layout { sites: SITES, ends: Ends::Ring, form: Form::Strains };
    let wave = |n: usize| Complex64::from_polar(1.0, -0.8 * PI * n as f64);
    let z: Vec<f64> = (0..SITES).map(|n| wave(n).re).chain((0..SITES).map(|n| wave(n).im)).collect();
    let mut flow = Dop853::new(flow(Dps::plain(1.5, KAPPA, layout)?), &z, (0.0, 2.0), Options::new(1e-11))?;
    let site = |n| {
        let swing = 2.0 * KAPPA * epsilon * wave(n);
        // V^1 = -kappa A e^{i sqrt(kappa) t} + c.c.: no mean velocity, so that B stays zero.
        let (u, u_dot) = (swing.re, -omega * swing.im);
        Site { u, v: -slowness * u, u_dot, v_dot: -slowness * u_dot }
    };
    let (params, end, mut worst) = (Params::new(1.5, KAPPA, slowness.recip())?, 2.0 / slowness, 0.0f64);
    let run = started(params, (Boundary::StrainRing, SITES), &site, (end, 1e-10))?;
    sampled(run, (end, off_beat(7.0, end, omega)), |t, y| {
        let z = state_at(&mut flow, (slowness * t).min(2.0))?;
        let turn = Complex64::from_polar(2.0 * KAPPA * epsilon, omega * t);
        let off = (0..SITES).map(|n| y[n] - (turn * Complex64::new(z[n], z[SITES + n])).re);
        worst = worst.max(max_norm(off));
        Ok(())
    })?;
    Ok(worst / epsilon.powf(1.5))
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

/// Growth of the suprema of Theorem 1 over the powers of `epsilon` that bound them, over a decade
/// of `epsilon`: 1 for a sharp bound, less for a bound that is not sharp.
pub(super) fn decade(rho_law: RhoLaw, initial: Initial, norm: Norm) -> Result<[f64; 3]> {
    let epsilons = vec![1e-4, 1e-5];
    let options = TheoremOptions { horizon: 2.0, rho_law, initial, epsilons, ..TheoremOptions::default() };
    let study = study::theorem(&options, &Engine::threads(), &|_, _| {})?;
    // A study that is asked to end has fewer runs.
    let [coarse, fine] = &study.runs[..] else {
        return Err(Error::Stopped { kept: "nothing of this decade".to_owned() });
    };
    let [coarse, fine] = [coarse, fine].map(|run| study.scaled(run, norm).0);
    Ok([0, 1, 2].map(|k| fine[k] / coarse[k]))
}

/// Theorem 1, also with resonators that are lighter than it requires, and the estimate (estimr1) of
/// its proof with these.
fn theorem(_: &Runs) -> Result<Vec<Quantity>> {
    let [u, v, v_dot] = decade(RhoLaw::Heavy, Initial::Generic, Norm::Infinity)?;
    let [u_light, v_light, _] = decade(RhoLaw::Light, Initial::Generic, Norm::Infinity)?;
    let [half, whole] = resonators_at_rest(1e9)?;
    // With sigma = epsilon^{alpha-1}, (estimr1) has the power sigma epsilon^{2-alpha} = epsilon in
    // place of epsilon^alpha.
    let secular = v_light * 0.1f64.powf(0.5);
    Ok(vec![
        ("s3.2-theorem-u", u),
        ("s3.2-theorem-v", v),
        ("s3.2-theorem-vdot", v_dot),
        ("s3.2-theorem-rho", u_light),
        ("s3.2-quadratic", whole / half),
        ("s3.2-estimr1", secular),
    ])
}

/// The estimate of the proof for Newton's cradle.
fn proof(_: &Runs) -> Result<Vec<Quantity>> {
    let cradle = RhoLaw::Value(f64::INFINITY);
    Ok(vec![("s3.2-estimerrqa", decade(cradle, Initial::Generic, Norm::Infinity)?[0])])
}
