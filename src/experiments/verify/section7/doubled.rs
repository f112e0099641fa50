//! The period doubling at `rho = 1/3`, and the branch of doubled period.

use super::{THIRD, bifurcations, first, largest, least, most, quartet, real, spectrum};
use crate::{
    dps::Center,
    error::Result,
    experiments::verify::{
        Item, Rule, Runs,
        item::{claim, number},
    },
    orbits::{Bifurcation, BifurcationKind, Continuation, Orbit, Parameter, Shooting, Spectrum},
    sweep::map,
};

/// Size of the first orbit beyond the birth, along its mode.
const FIRST: f64 = 0.02;
/// Sites from the kink that are far.
const FAR: usize = 10;

/// The arc of the bond-centred family.
pub(in super::super) fn period_doubling(_: &Runs) -> Result<Vec<Item>> {
    let birth = bifurcations(Center::Bond, [2.062, 2.064], BifurcationKind::PeriodDoubling)?;
    let meeting = bifurcations(Center::Bond, [2.0953, 2.0957], BifurcationKind::RealCollision)?;
    let beyond = spectrum(THIRD, Center::Bond, 2.097)?;
    let mut items = vec![
        number(
            "s7-period-doubling",
            "above fig:PdoubleSln",
            "first omega_b at which a pair goes through -1, about a bond",
            "2.063",
            first(&birth),
        ),
        number(
            "s7-collision",
            "above fig:PdoubleSln",
            "omega_b at which the real multipliers collide",
            "2.096",
            first(&meeting),
        ),
        claim(
            "s7-return",
            "above fig:PdoubleSln",
            "largest |lambda| with Re lambda < -1/2 at omega_b = 2.097",
            "the pair of the period doubling collides there",
            Rule::AtMost(1.0 + 1e-6),
            largest(&beyond, |m| m.re < -0.5),
        )
        .but(
            Rule::AtLeast(1.05),
            "It does not come back to -1: a second pair leaves -1 at 2.09517, and the two pairs meet off the circle at 2.09554 and become a quartet.",
        ),
    ];
    let Some(birth) = birth.first() else { return Ok(items) };
    items.extend(branch_of(birth, first(&meeting))?);
    Ok(items)
}

/// The orbits from `orbit` to the frequency `to`.
fn follow(orbit: Orbit, to: f64, step: f64) -> Result<Vec<Orbit>> {
    let shooting = Shooting::default();
    let continuation =
        Continuation { parameter: Parameter::OmegaB, to, step, most_points: 100, natural: false, shooting };
    Ok(continuation.follow(orbit, |_| {})?.0)
}

/// Distances of `Z(T/2)` from `Z(0)`, and from its reflection `n -> 1 - n`, over the largest strain.
fn half_way(orbit: &Orbit) -> Result<[f64; 2]> {
    let n = orbit.setting.sites;
    let half = orbit.states(1e-13, &[0.5 * orbit.setting.period()])?.remove(0);
    let apart = |image: &dyn Fn(usize) -> usize| {
        most((0..2 * n).map(|i| (half[i] - orbit.z[i / n * n + image(i % n)]).abs())) / orbit.amplitude()
    };
    Ok([apart(&|i| i), apart(&|i| (n - i) % n)])
}

/// What is said of the doubled branch born at `birth`.
fn branch_of(birth: &Bifurcation, meeting: f64) -> Result<Vec<Item>> {
    let shooting = Shooting::default();
    let Some(sample) = follow(birth.doubled(&shooting, FIRST)?, 1.032, 1e-3)?.pop() else { return Ok(vec![]) };
    let orbits = follow(sample.clone(), 1.0525, 4e-3)?;
    let spectra = map(&orbits, |orbit| orbit.spectrum(&shooting)).into_iter().collect::<Result<Vec<_>>>()?;
    let [other, reflected] = half_way(&sample)?;
    let n = birth.orbit.setting.sites;
    let far = |i: &usize| (i % n).abs_diff(n / 2) > FAR;
    let oscillatory = |spectrum: &Spectrum| largest(spectrum, quartet) - 1.0;
    let highest = orbits.last().map_or(f64::NAN, |orbit| orbit.setting.omega_b);
    Ok(vec![
        claim(
            "s7-doubled-mode",
            "fig:PdoubleSln",
            "largest entry of the eigenvector of -1 more than 10 sites from the middle, the largest 1",
            "spatially localized at the middle of the chain",
            Rule::AtMost(5e-8),
            most((0..2 * n).filter(far).map(|i| birth.mode[i].abs())),
        ),
        number(
            "s7-doubled-from",
            "below fig:PdoubleSln",
            "omega_b at which the branch of doubled period begins",
            "1.032",
            0.5 * birth.parameter,
        ),
        claim(
            "s7-doubled-Eb",
            "fig:PdoubleFloq",
            "E_b(T_b) of the doubled orbit at omega_b = 1.032",
            "numerically exact",
            Rule::AtMost(4.5e-9),
            sample.e_b(1e-13, 1)?,
        ),
        claim(
            "s7-doubled-other",
            "fig:PdoubleFloq",
            "largest |Z(T_b/2) - Z(0)| over the largest strain, omega_b = 1.032",
            "the period of the new solution is doubled",
            Rule::AtLeast(0.09),
            other,
        ),
        claim(
            "s7-doubled-reflected",
            "fig:PdoubleFloq",
            "the same of Z(T_b/2) from the reflection n -> 1 - n of Z(0)",
            "the solution at t = T_b/2 beside that at t = 0",
            Rule::AtMost(5e-15),
            reflected,
        ),
        number(
            "s7-doubled-arc",
            "below fig:PdoubleSln",
            "half the omega_b at which the real multipliers of the main branch collide",
            "1.051",
            0.5 * meeting,
        )
        .but(Rule::Digits("1.0478"), "The arc ends at 2.096, as said above: the two statements do not fit."),
        number(
            "s7-doubled-to",
            "below fig:PdoubleSln",
            "largest omega_b to which the doubled branch was followed here",
            "1.051",
            highest,
        )
        .but(
            Rule::Digits("1.0525"),
            "The branch has no end there and was followed to 1.056 elsewhere; from 1.0525 to 1.0545 the Jacobian is nearly singular, as the band of the background reaches -1.",
        ),
        claim(
            "s7-doubled-real",
            "fig:PdoubleFloq",
            "least of the largest real |lambda| - 1 on the doubled branch",
            "all exhibit real instability",
            Rule::AtLeast(0.1),
            least(spectra.iter().map(|spectrum| largest(spectrum, real) - 1.0)),
        ),
        claim(
            "s7-doubled-oscillatory",
            "fig:PdoubleFloq",
            "least of the largest |lambda| - 1 of quartets there, from omega_b = 1.035 on",
            "all exhibit oscillatory instability",
            Rule::AtLeast(0.017),
            least(spectra[1..].iter().map(oscillatory)),
        ),
        claim(
            "s7-doubled-sample",
            "fig:PdoubleFloq",
            "the same at omega_b = 1.032",
            "all exhibit oscillatory instability",
            Rule::AtLeast(1e-6),
            oscillatory(&spectra[0]),
        )
        .but(
            Rule::AtMost(1e-6),
            "Not yet on this ring; on one of 61 sites |lambda| is 1.0026: quartets that weak depend on the ring.",
        ),
    ])
}
