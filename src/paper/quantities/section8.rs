//! Section 8: what the paper leaves open, where it has become a number.

use super::{Group, Quantity, Runs};
use crate::{
    breathers::{DarkBreather, MovingBreather},
    chain::Params,
    dps::Center,
    error::Result,
    orbits::Shooting,
    paper::figures::limit_wave,
    study::{Barrier, BarrierPoint, Wanted, orbits::proof},
    sweep::Engine,
};

pub(super) const GROUPS: &[Group] =
    &[Group::of(waves), Group::of(limits), Group::of(existence), Group::of(barrier), Group::of(moving)];

/// Exact travelling waves at the parameters of Sec. 4.
fn waves(_: &Runs) -> Result<Vec<Quantity>> {
    let studies = ["tw-q15", "tw-q45", "tw-rho3"].map(|scene| Wanted::of(scene).study());
    let [first, short, third] = studies;
    let studies = [first?, short?, third?];
    let worst = |of: fn(&crate::study::ExactStudy) -> f64| studies.iter().map(of).fold(0.0, f64::max);
    let near = worst(|study| study.errors.map_or(f64::INFINITY, |errors| errors[0]));
    Ok(vec![("s8-waves-exact", worst(|study| study.wave.residual)), ("s8-waves-near", near)])
}

/// Limits of small waves, as slopes over two decades of `epsilon`.
fn limits(_: &Runs) -> Result<Vec<Quantity>> {
    let [small, large] = [1e-6, 1e-4].map(|epsilon| limit_wave(1.0 / 3.0, epsilon));
    let (small, large) = (small?, large?);
    let slope = |small: f64, large: f64| (large / small).ln() / 100.0_f64.ln();
    Ok(vec![
        ("s8-waves-slope", slope(small.errors[0], large.errors[0])),
        ("s8-modulation", slope(small.apart().abs(), large.apart().abs())),
    ])
}

/// Radii within which a wave and the breathers at `omega_b = 2.05` are proved to exist, in units of
/// the amplitude.
fn existence(_: &Runs) -> Result<Vec<Quantity>> {
    let study = Wanted::of("tw-q15").study()?;
    let wave = proof::radius(proof::WAVE, |more| proof::of_wave(&study.wave, &study.fourier[0], None, &[], more))?;
    let breather = |center| {
        let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
        let breather = DarkBreather { params, center, sites: 41, omega_b: 2.05, c_x: 0.0 };
        let shooting = Shooting { tol: 1e-15, ..Shooting::default() };
        let orbit = breather.orbit(&shooting)?;
        proof::radius(proof::BREATHER, |more| proof::of_breather(&orbit, shooting.tol, more))
    };
    let breathers = breather(Center::Site)?.max(breather(Center::Bond)?);
    Ok(vec![("s8-waves-bound", wave), ("s8-breathers-bound", breathers)])
}

/// The barrier between dark breathers at `rho = 1/3`.
fn barrier(_: &Runs) -> Result<Vec<Quantity>> {
    let study = Barrier::of(1.0 / 3.0, [2.01, 2.1], 10).study(&Engine::threads(), &|_, _| {})?;
    let share = |point: &BarrierPoint| point.barrier() / point.kinks[0].kink_energy.abs();
    let least = study.points.iter().map(share).fold(f64::INFINITY, f64::min);
    let site = study.points.iter().map(|point| point.kinks[0].real).fold(0.0, f64::max);
    Ok(vec![("s8-barrier", least), ("s8-barrier-site", site)])
}

/// A moving dark breather at `rho = 1/3` on a short ring.
fn moving(_: &Runs) -> Result<Vec<Quantity>> {
    const TOL: f64 = 1e-14;
    let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
    let orbit = MovingBreather { params, sites: 21, omega_b: 2.094, turns: 11 }.orbit(TOL)?;
    let envelope = orbit.envelope(TOL)?;
    Ok(vec![("s8-moving-exact", orbit.return_error(TOL)?), ("s8-moving-tail", envelope.tail)])
}
