//! Section 6: standing waves of the modulation equations with a kink, and the dark breathers that
//! they approximate.
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_n, b_n` | `delta^- a_n, delta^- b_n` of (eq:DpSsw2), `mu = 1` |
//! | `R` | largest residual of (eq:DpSsw2), relative to the amplitude at `-N` and to the force |

mod ring;

use super::{
    Group, Quantity, Runs,
    measure::{off_beat, sampled, started},
};
use crate::{
    chain::{Boundary, Params, Site},
    dps::{Averages, Center, DarkProfile, project},
    error::Result,
    run::state_at,
};
use hertzchain_integrators::Stepper;
use nalgebra::DMatrix;
use ring::Ring;
use std::f64::consts::PI;

pub(super) const GROUPS: &[Group] = &[Group::of(equations), Group::of(newton), Group::of(breathers)];

const FIGURE: Params = Params { alpha: 1.5, kappa: 1.0, rho: 1.0 / 3.0 };
const SITES: usize = 41;

/// The profile of Fig. sw_anbn.
fn figure(center: Center) -> Result<DarkProfile> {
    DarkProfile::new(FIGURE, center, SITES, 0.0)
}

/// Amplitudes and mean strains of all sites multiplied by `scale`.
fn strains(profile: &DarkProfile, scale: f64) -> [Vec<f64>; 2] {
    [profile.sites().map(|n| scale * profile.a(n)).collect(), profile.sites().map(|n| scale * profile.b(n)).collect()]
}

/// The fluxes `h_alpha(b_n, abs(a_n)) a_n` and the mean forces.
fn fluxes(averages: &Averages, [a, b]: &[Vec<f64>; 2]) -> [Vec<f64>; 2] {
    let bond = |(a, b): (&f64, &f64)| (a.signum() * averages.r_h(*b, a.abs()), averages.g(*b, a.abs()));
    a.iter().zip(b).map(bond).unzip::<_, _, Vec<_>, Vec<_>>().into()
}

/// `R` for the equations with the factor `mu`, computed on the whole ring without symmetries.
fn residual(averages: &Averages, strains: &[Vec<f64>; 2], mu: f64) -> f64 {
    let ([a, _], [flux, g]) = (strains, fluxes(averages, strains));
    let count = a.len();
    let at = |n: usize| {
        let (before, after) = ((n + count - 1) % count, (n + 1) % count);
        let first = (mu * a[n] + flux[after] - 2.0 * flux[n] + flux[before]) / (mu * a[0]);
        first.abs().max((g[after] / g[n] - 1.0).abs())
    };
    (0..count).map(at).fold(0.0, f64::max)
}

/// The larger value of the two symmetries.
fn worst(of: impl Fn(Center) -> Result<f64>) -> Result<f64> {
    Ok(of(Center::Site)?.max(of(Center::Bond)?))
}

/// The statements on the stationary equations.
fn equations(_: &Runs) -> Result<Vec<Quantity>> {
    const KAPPA: f64 = 2.5;
    let averages = Averages::new(1.5, 1.0)?;
    let renormalised = |center| {
        let mu: f64 = 0.3;
        Ok(residual(&averages, &strains(&figure(center)?, mu * mu), mu))
    };
    let heavy = DarkProfile::new(Params::new(1.5, KAPPA, 1.0)?, Center::Site, 11, 0.0)?;
    Ok(vec![
        ("s6-mu", measured_detuning(&heavy, 1e-3)?.recip()),
        ("s6-renormalised", worst(renormalised)?),
        ("s6-mu-positive", vanishing(&averages, figure(Center::Site)?.background().0)),
    ])
}

/// The largest `abs(a_n)` that Newton's iteration with `mu = -1` leads to, relative to the
/// background with `mu = 1`; the larger value of the guesses about a site and about a bond.
fn vanishing(averages: &Averages, background: f64) -> f64 {
    let sizes = [0.0, 0.5].map(|n_0| {
        // At zero the Jacobian is singular: steps of the size of rounding errors need not fall
        // below the tolerance. So convergence is not asked for.
        let mut ring = Ring::guess(averages, n_0, -1.0);
        ring.iterate();
        ring.size()
    });
    sizes[0].max(sizes[1]) / background
}

/// Newton's method and the profiles that it converges to.
fn newton(_: &Runs) -> Result<Vec<Quantity>> {
    let averages = Averages::new(1.5, 1.0)?;
    let off = |center| -> Result<f64> { Ok(residual(&averages, &strains(&figure(center)?, 1.0), 1.0)) };
    let n_0 = |center| if center == Center::Site { 0.0 } else { 0.5 };
    let extremes = |matrix: DMatrix<f64>| {
        let values = matrix.singular_values();
        values.min() / values.max()
    };
    let from_one = |center| Ok(Ring::settled(&averages, n_0(center))?.apart(&figure(center)?, 0));
    let moved = |center| Ok(Ring::settled(&averages, n_0(center) + 3.0)?.apart(&figure(center)?, 3));
    let site = Ring::settled(&averages, 0.0)?;
    let bond = Ring::settled(&averages, 0.5)?;
    let between = [0.1, 0.2, 0.3, 0.4].map(|n_0| Ok(Ring::settled(&averages, n_0)?.apart(&figure(Center::Site)?, 0)));
    let between = between.into_iter().collect::<Result<Vec<f64>>>()?.into_iter().fold(0.0, f64::max);
    Ok(vec![
        ("s6-singular", extremes(site.jacobian()).max(extremes(bond.jacobian()))),
        ("s6-sufficient", extremes(site.reduced()).min(extremes(bond.reduced()))),
        ("s6-guess", worst(from_one)?),
        ("s6-translation", worst(moved)?),
        ("s6-between", between),
        ("s6-site", off(Center::Site)?),
        ("s6-bond", off(Center::Bond)?),
    ])
}

/// The breathers on the chain.
fn breathers(_: &Runs) -> Result<Vec<Quantity>> {
    let nearer = |center| {
        let profile = DarkProfile::new(FIGURE, center, 11, 0.0)?;
        Ok(distance(&profile, 0.002)? / distance(&profile, 0.02)?)
    };
    Ok(vec![("s6-first-order", worst(nearer)?)])
}

/// The strain ring that starts from a profile at `omega_b = omega + detuning`, up to `end`.
fn start(profile: &DarkProfile, detuning: f64, end: f64) -> Result<(Vec<f64>, impl Stepper<f64> + use<>)> {
    let params = profile.params();
    let (x, y) = profile.seed(params.omega() + detuning)?;
    let site = |n: usize| Site { u: x[n], v: y[n], u_dot: 0.0, v_dot: 0.0 };
    let run = started(params, (Boundary::StrainRing, x.len()), &site, (end, 1e-10))?;
    Ok(([x, y].concat(), run))
}

/// Largest distance of the chain from (eq:xy_sw) up to `t = 1 / (omega_b - omega)`, which is a
/// sixth of a slow period, divided by the largest strain.
fn distance(profile: &DarkProfile, detuning: f64) -> Result<f64> {
    let Params { rho, kappa, .. } = profile.params();
    let (omega_b, end) = (profile.params().omega() + detuning, detuning.recip());
    let (z, run) = start(profile, detuning, end)?;
    let scale = profile.mu(omega_b)?.powi(2);
    let [a, b] = strains(profile, scale);
    let (count, largest) = (a.len(), z.iter().fold(0.0, |most: f64, z| most.max(z.abs())));
    let mut worst = 0.0f64;
    sampled(run, (end, off_beat(7.0, end, omega_b)), |t, state| {
        let turn = 2.0 * kappa * (omega_b * t).cos();
        let off = |(i, z): (usize, &f64)| {
            let swing = if i < count { turn } else { -turn / rho };
            (z - b[i % count] - swing * a[i % count]).abs() / largest
        };
        worst = state[..2 * count].iter().enumerate().map(off).fold(worst, f64::max);
        Ok(())
    })?;
    Ok(worst)
}

/// `(measured omega_b - omega) / (omega_b - omega)`, for a relative `detuning`, from the phases of
/// the background one period after the start and about half a slow period later.
fn measured_detuning(profile: &DarkProfile, detuning: f64) -> Result<f64> {
    let (params, omega) = (profile.params(), profile.params().omega());
    let (period, detuning) = (2.0 * PI / omega, detuning * omega);
    let times = [1.01 * period, 3.0 / detuning];
    let (z, mut run) = start(profile, detuning, times[1] + 2.0 * period)?;
    let mut phase = |t: f64| {
        let envelope = project(params, 1.0, t, |t| Ok(state_at(&mut run, t)?))?;
        Ok(envelope.amplitudes[z.len() / 2].atan2(envelope.amplitudes[0]))
    };
    let [from, to]: [Result<f64>; 2] = [phase(times[0]), phase(times[1])];
    Ok((to? - from?).rem_euclid(2.0 * PI) / (times[1] - times[0]) / detuning)
}
