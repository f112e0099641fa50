//! The period doubling at `rho = 1/3`, and the branch of doubled period.

use super::{
    super::{Quantity, Runs},
    THIRD, bifurcations, first, follow, largest, least, most, quartet, real, spectrum,
};
use crate::{
    dps::Center,
    error::{Error, Result},
    orbits::{Bifurcation, BifurcationKind, Orbit, Parameter, Shooting, Spectrum},
    sweep::map,
};

/// Size of the first orbit after the bifurcation, along its mode.
const FIRST: f64 = 0.02;
/// A frequency beyond the end of the paper's branch, 1.051.
const BEYOND: f64 = 1.0525;
/// Least distance from the kink, in sites, that counts as far.
const FAR: usize = 10;

/// The period doubling of the bond-centred family.
pub(in super::super) fn period_doubling(_: &Runs) -> Result<Vec<Quantity>> {
    let birth = bifurcations(Center::Bond, [2.062, 2.064], BifurcationKind::PeriodDoubling)?;
    let meeting = bifurcations(Center::Bond, [2.0953, 2.0957], BifurcationKind::RealCollision)?;
    // The real multiplier of a tau < -1 that is outside the circle.
    let outside =
        meeting.first().map_or(f64::NAN, |one| (one.critical.tau * one.critical.tau - 1.0).sqrt() - one.critical.tau);
    let arc = vec![
        ("s7-period-doubling", first(&birth)),
        ("s7-toward", outside / largest(&spectrum(THIRD, Center::Bond, 2.09)?, |m| real(m) && m.re < 0.0)),
        ("s7-collision", first(&meeting)),
        ("s7-return", outside),
    ];
    let birth = birth.first().ok_or_else(|| Error::parameter("omega_b", 2.064, "a period doubling below"))?;
    Ok([arc, branch_of(birth, first(&meeting))?].concat())
}

/// Distances of `Z(T/2)` from `Z(0)` and from its reflection `n -> 1 - n`, divided by the largest
/// strain.
fn half_way(orbit: &Orbit) -> Result<[f64; 2]> {
    let n = orbit.setting.sites;
    let half = orbit.states(1e-13, &[0.5 * orbit.setting.period()])?.remove(0);
    let apart = |image: &dyn Fn(usize) -> usize| {
        most((0..2 * n).map(|i| (half[i] - orbit.z[i / n * n + image(i % n)]).abs())) / orbit.amplitude()
    };
    Ok([apart(&|i| i), apart(&|i| (n - i) % n)])
}

/// The statements on the doubled branch that begins at `birth`.
fn branch_of(birth: &Bifurcation, meeting: f64) -> Result<Vec<Quantity>> {
    let shooting = Shooting::default();
    let born = birth.doubled(&shooting, FIRST)?;
    let sample = follow(born.clone(), Parameter::OmegaB, 1.032, 1e-3)?.pop().unwrap_or(born);
    let orbits = follow(sample.clone(), Parameter::OmegaB, BEYOND, 4e-3)?;
    let spectra = map(&orbits, |orbit| orbit.spectrum(&shooting)).into_iter().collect::<Result<Vec<_>>>()?;
    let [other, reflected] = half_way(&sample)?;
    let n = birth.orbit.setting.sites;
    let far = |i: &usize| (i % n).abs_diff(n / 2) > FAR;
    let oscillatory = |spectrum: &Spectrum| largest(spectrum, quartet) - 1.0;
    let last = orbits.last().filter(|orbit| orbit.setting.omega_b >= BEYOND);
    let [last_e_b, last_other] = match last {
        Some(orbit) => [orbit.e_b(1e-13, 1)?, half_way(orbit)?[0]],
        None => [f64::NAN; 2],
    };
    Ok(vec![
        ("s7-doubled-mode", most((0..2 * n).filter(far).map(|i| birth.critical.mode[i].abs()))),
        ("s7-doubled-from", 0.5 * birth.parameter),
        ("s7-doubled-Eb", sample.e_b(1e-13, 1)?),
        ("s7-doubled-other", other),
        ("s7-doubled-reflected", reflected),
        ("s7-doubled-arc", 0.5 * meeting),
        ("s7-doubled-to", last_e_b),
        ("s7-doubled-to-other", last_other),
        ("s7-doubled-real", least(spectra.iter().map(|spectrum| largest(spectrum, real) - 1.0))),
        ("s7-doubled-oscillatory", least(spectra[1..].iter().map(oscillatory))),
        ("s7-doubled-sample", oscillatory(&spectra[0])),
    ])
}
