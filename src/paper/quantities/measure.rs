//! Measurements on the full chain that several sections use.

use crate::{
    chain::{Boundary, Chain, Params, Site, State},
    error::Result,
    run::state_at,
    study::fit_line,
    waves::{Shape, Size, TravellingWave, strains},
};
use hertzchain_integrators::{Stepper, VectorField, collocation::StepControl};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Slow time during which a frequency is measured.
const SLOW_TIME: f64 = 30.0;
/// Size `epsilon` of the wave. Here the next order of the theory, `epsilon^{1/2}`, is below 0.4 %
/// of the frequency shift.
const SIZE: f64 = 1e-5;
/// Sites of the ring, which hold two waves with `q = 4 pi/5`.
const SITES: usize = 5;

/// A small wave with `alpha = 3/2, rho = 1, q = 4 pi/5, a = 1`.
pub(super) fn small_wave(kappa: f64, b: f64) -> Result<TravellingWave> {
    let shape = Shape { q: 0.8 * PI, a: 1.0, b, phi: 0.0 };
    TravellingWave::new(Params::new(1.5, kappa, 1.0)?, shape, Size::Epsilon(SIZE))
}

/// The run to `end`, by collocation, of a chain that starts from `site(n)`.
pub(super) fn started(
    params: Params,
    (boundary, sites): (Boundary, usize),
    site: &dyn Fn(usize) -> Site<f64>,
    (end, tol): (f64, f64),
) -> Result<impl Stepper<f64> + use<>> {
    let chain = Chain::new(params, boundary, sites)?;
    let start = State::from_fn(&chain, site)?;
    Ok(chain.collocation(start.as_slice(), (0.0, end), StepControl::Tolerance(tol))?)
}

/// Calls `look` with the states of a run at `count + 1` equally spaced times from 0 to `end`.
pub(super) fn sampled(
    mut run: impl Stepper<f64>,
    (end, count): (f64, u32),
    mut look: impl FnMut(f64, &[f64]) -> Result<()>,
) -> Result<()> {
    (0..=count).map(|k| end * f64::from(k) / f64::from(count)).try_for_each(|t| look(t, &state_at(&mut run, t)?))
}

/// A number of samples that are not in step with an oscillation, so that its harmonics average out:
/// 1.3 times `each` in a period.
pub(super) fn off_beat(each: f64, end: f64, omega: f64) -> u32 {
    (1.3 * each * end * omega / (2.0 * PI)).ceil() as u32
}

/// `Omega` measured on the chain: the slope, in the slow time, of the phase of `sum_n D_n e^{iqn}`.
pub(super) fn measured_slow_frequency(wave: &TravellingWave) -> Result<f64> {
    let (params, q, end) = (wave.params(), wave.shape().q, SLOW_TIME / wave.slow_time(1.0));
    let run = started(params, (Boundary::StrainRing, SITES), &|n| wave.site(n, 0.0), (end, 1e-10))?;
    let (mut phase, mut points) = (0.0, Vec::new());
    sampled(run, (end, off_beat(1.0, end, params.omega())), |t, y| {
        let part = |k: usize| &y[k * SITES..(k + 1) * SITES];
        let envelope = strains(wave, t, [part(0), part(1), part(2), part(3)]);
        let turned = envelope.iter().enumerate().map(|(n, d)| d * Complex64::from_polar(1.0, q * n as f64));
        phase += (turned.sum::<Complex64>().arg() - phase + PI).rem_euclid(2.0 * PI) - PI;
        points.push((wave.slow_time(t), phase));
        Ok(())
    })?;
    Ok(fit_line(&points).map_or(f64::NAN, |line| line.0))
}

/// The right-hand side `dz/dtau` of a modulation equation at the state `z`.
pub(super) fn slope(mut flow: impl VectorField<f64>, z: &[f64]) -> Vec<f64> {
    let mut dz = vec![0.0; z.len()];
    flow.eval(0.0, z, &mut dz);
    dz
}

/// Quadratic mean of a profile minus its mean and its sinusoid with `waves` waves, divided by that
/// of the sinusoid.
pub fn distortion(profile: &[f64], waves: f64) -> f64 {
    let count = profile.len() as f64;
    let mean = profile.iter().sum::<f64>() / count;
    let turn = |n: usize| Complex64::from_polar(1.0, -2.0 * PI * waves * n as f64 / count);
    let mode = profile.iter().enumerate().map(|(n, x)| (x - mean) * turn(n)).sum::<Complex64>() * (2.0 / count);
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let sinusoid = |n: usize| (mode * turn(n).conj()).re;
    let rest = square(&mut profile.iter().enumerate().map(|(n, x)| x - mean - sinusoid(n)));
    (rest / square(&mut (0..profile.len()).map(sinusoid))).sqrt()
}
