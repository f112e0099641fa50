//! Section 7: dark breathers as exact orbits of a ring of 41 bonds, and their Floquet multipliers.
//!
//! | symbol | meaning |
//! |---|---|
//! | `lambda` | Floquet multiplier |
//! | `\|lambda\|^m` | growth of rounding errors over `m` periods, with the largest multiplier |
//! | e-folds | `ln` of the growth `\|lambda\|^m` up to `t = 1500`, see [`e_folds`] |
//! | bond, site | position of the kink |

mod doubled;
mod evolutions;
mod mass_ratio;

use super::{Group, Quantity, Runs};
use crate::{
    chain::Params,
    dps::Center,
    error::Result,
    orbits::{
        Bifurcation, BifurcationKind, Continuation, Extent, Kind, Multiplier, Orbit, Parameter, Shooting, Spectrum,
    },
    paper::figures::orbits::{between, breather, orbit},
    study::{Evolution, Kick, OrbitStudy, evolve, orbit_study},
    sweep::map,
};
use std::f64::consts::PI;

pub(super) const GROUPS: &[Group] = &[
    Group::of(profiles),
    Group::of(family),
    Group::of(multipliers),
    Group::of(frequencies),
    Group::of(oscillatory_onset),
    Group::of(evolutions::site),
    Group::of(evolutions::bond),
    Group::of(doubled::period_doubling),
    Group::of(mass_ratio::three),
    Group::of(mass_ratio::ten),
    Group::of(mass_ratio::continued),
];

const THIRD: f64 = 1.0 / 3.0;
/// Quartets with a modulus of at most one plus this are weak.
const WEAK: f64 = 0.02;

/// The orbits from one on to the value `to` of a parameter, in steps of at most `step`.
fn follow(orbit: Orbit, parameter: Parameter, to: f64, step: f64) -> Result<Vec<Orbit>> {
    let shooting = Shooting::default();
    let continuation = Continuation { parameter, to, step, most_points: 100, shooting };
    Ok(continuation.follow(orbit, |_| {})?.0)
}

fn study(rho: f64, center: Center, omega_b: f64) -> Result<OrbitStudy> {
    orbit_study(orbit(rho, center, omega_b)?, &Shooting::default())
}

fn spectrum(rho: f64, center: Center, omega_b: f64) -> Result<Spectrum> {
    orbit(rho, center, omega_b)?.spectrum(&Shooting::default())
}

fn spectra(rho: f64, center: Center, omega_b: &[f64]) -> Result<Vec<Spectrum>> {
    map(omega_b, |&omega_b| spectrum(rho, center, omega_b)).into_iter().collect()
}

/// Evolution of an orbit on the chain, with a kick along its most unstable mode if `kick` is given.
/// If the run fails, the last `E_b` and the last position are NaN.
fn released(rho: f64, center: Center, omega_b: f64, until: f64, kick: Option<f64>) -> Result<Evolution> {
    let kick = kick.map(|size| Kick { size, mode: 0 });
    let mut run = evolve(&orbit(rho, center, omega_b)?, until, kick, &Shooting::default(), &|_, _| {})?;
    if run.failure.is_some() {
        run.e_b.push(f64::NAN);
        run.position.push(f64::NAN);
    }
    Ok(run)
}

/// The largest value; NaN if one of them is NaN, or if there is none.
fn most(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().reduce(|a, b| if a.is_nan() || a >= b { a } else { b }).unwrap_or(f64::NAN)
}

/// The smallest value; NaN if one of them is NaN, or if there is none.
fn least(values: impl IntoIterator<Item = f64>) -> f64 {
    -most(values.into_iter().map(|value| -value))
}

/// The largest modulus of the multipliers of some kinds; 1 if there are none.
fn largest(spectrum: &Spectrum, chosen: impl Fn(&Multiplier) -> bool) -> f64 {
    spectrum.multipliers.iter().filter(|m| chosen(m)).map(|m| m.modulus).fold(1.0, f64::max)
}

/// The end of the longest run of a dark breather whose length the paper gives.
const LONGEST: f64 = 1500.0;

/// The `e`-folds of an instability of the given modulus up to [`LONGEST`].
fn e_folds(modulus: f64, omega_b: f64) -> f64 {
    LONGEST * omega_b / (2.0 * PI) * modulus.ln()
}

fn real(m: &Multiplier) -> bool {
    matches!(m.kind, Kind::Real | Kind::Negative)
}

fn quartet(m: &Multiplier) -> bool {
    m.kind == Kind::Quartet
}

/// The sample profiles at `omega_b = 2.05`.
fn profiles(_: &Runs) -> Result<Vec<Quantity>> {
    let (bond, site) = (study(THIRD, Center::Bond, 2.05)?, study(THIRD, Center::Site, 2.05)?);
    let both = |of: &dyn Fn(&OrbitStudy) -> f64| of(&bond).max(of(&site));
    let near_one = |m: &&Multiplier| (m.re - 1.0).hypot(m.im) < 1e-4;
    Ok(vec![
        ("s7-pair", site.spectrum.multipliers.iter().filter(near_one).count() as f64),
        ("s7-Cx", both(&|study| study.extent.c_x.abs() / study.extent.k_x)),
        ("s7-omega", Params::new(1.5, 1.0, THIRD)?.omega()),
        ("s7-Eb", both(&|study| study.e_b)),
        ("s7-seed", seed(Center::Bond)?.max(seed(Center::Site)?)),
    ])
}

/// The distance of (eq:xy_sw) from the orbit divided by the largest strain.
fn seed(center: Center) -> Result<f64> {
    let (seed, orbit) = (breather(THIRD, center, 2.005).seed()?, orbit(THIRD, center, 2.005)?);
    Ok(most(seed.iter().zip(&orbit.z).map(|(a, b)| (a - b).abs())) / orbit.amplitude())
}

/// Size of the breathers against their frequency.
fn family(_: &Runs) -> Result<Vec<Quantity>> {
    let extents = |center| -> Result<Vec<Extent>> {
        let frequencies = [2.001, 2.01, 2.03, 2.05, 2.07, 2.09];
        frequencies.into_iter().map(|omega_b| orbit(THIRD, center, omega_b)?.extent(1e-13)).collect()
    };
    let both = [extents(Center::Bond)?, extents(Center::Site)?];
    let steps = |of: fn(&Extent) -> f64| {
        let ratios = both.iter().flat_map(|all| all.windows(2)).map(move |two| of(&two[1]) / of(&two[0]));
        ratios.fold(f64::INFINITY, f64::min)
    };
    Ok(vec![
        ("s7-Kx", steps(|extent| extent.k_x)),
        ("s7-Ky", steps(|extent| extent.k_y)),
        ("s7-zero", both.iter().map(|all| all[0].k_x / all[1].k_x).fold(0.0, f64::max)),
    ])
}

/// The multipliers at `omega_b = 2.09`.
fn multipliers(_: &Runs) -> Result<Vec<Quantity>> {
    let (bond, site) = (spectrum(THIRD, Center::Bond, 2.09)?, spectrum(THIRD, Center::Site, 2.09)?);
    let signed = |spectrum: &Spectrum, sign: f64| largest(spectrum, |m| real(m) && m.re * sign > 0.0);
    Ok(vec![
        ("s7-bond-real", signed(&bond, 1.0)),
        ("s7-bond-negative", signed(&bond, -1.0)),
        ("s7-site-quartet", largest(&site, |m| quartet(m) && m.re < -0.5)),
        (
            "s7-site-around",
            most(site.multipliers.iter().filter(|m| quartet(m) && m.re < -0.5).map(|m| (m.re + 1.0).hypot(m.im))),
        ),
    ])
}

/// The instabilities at the beginning of the branches and later.
fn frequencies(_: &Runs) -> Result<Vec<Quantity>> {
    const EARLY: [f64; 3] = [2.005, 2.05, 2.06];
    let (bond, early) = (spectra(THIRD, Center::Bond, &EARLY)?, spectra(THIRD, Center::Site, &EARLY)?);
    let (weak, late) = (spectra(THIRD, Center::Site, &[2.07, 2.077])?, spectra(THIRD, Center::Site, &[2.08, 2.1])?);
    let ratio = |(bond, site)| (largest(bond, real) - 1.0) / (largest(site, quartet) - 1.0);
    let weak_e_folds = early.iter().chain(&weak).zip([2.005, 2.05, 2.06, 2.07, 2.077]);
    Ok(vec![
        (
            "s7-site-only-oscillatory",
            most(early.iter().chain(&weak).chain(&late).map(|site| largest(site, real) - 1.0)),
        ),
        ("s7-site-emerge", largest(&early[0], quartet) - 1.0),
        ("s7-site-weak", most(weak_e_folds.map(|(site, omega_b)| e_folds(largest(site, quartet), omega_b)))),
        ("s7-bond-only-real", most(bond.iter().map(|bond| largest(bond, quartet) - 1.0))),
        ("s7-real-over-oscillatory", least(bond.iter().zip(&early).map(ratio))),
    ])
}

/// The bifurcations of a kind between two frequencies at `rho = 1/3`.
fn bifurcations(center: Center, range: [f64; 2], kind: BifurcationKind) -> Result<Vec<Bifurcation>> {
    let branch = between(THIRD, center, range, 1, Some(WEAK), &|_, _| {})?;
    Ok(branch.bifurcations.into_iter().filter(|one| one.kind == kind).collect())
}

fn first(found: &[Bifurcation]) -> f64 {
    found.first().map_or(f64::NAN, |one| one.parameter)
}

/// The strong instability of the site-centred family.
fn oscillatory_onset(_: &Runs) -> Result<Vec<Quantity>> {
    let found = bifurcations(Center::Site, [2.077, 2.079], BifurcationKind::KreinCollision)?;
    Ok(vec![
        ("s7-onset", first(&found)),
        ("s7-onset-place", found.first().map_or(f64::NAN, |one| (2.0 * (1.0 + one.critical.tau)).sqrt())),
    ])
}
