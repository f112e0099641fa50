//! Heavier resonators: `rho = 3` and 10, and the branches in `rho` at fixed frequency.

use super::{
    super::{Quantity, Runs},
    LONGEST, WEAK, e_folds, follow, largest, least, most, orbit, quartet, real, released, spectra,
};
use crate::{
    chain::Params,
    dps::Center,
    error::Result,
    orbits::{Kind, Multiplier, Parameter, Shooting, Spectrum},
    sweep::map,
};
use std::f64::consts::PI;

const CENTERS: [Center; 2] = [Center::Bond, Center::Site];

fn omega(rho: f64) -> Result<f64> {
    Ok(Params::new(1.5, 1.0, rho)?.omega())
}

/// The largest `|lambda| - 1` of quartets divided by that of real multipliers.
fn share(bond: &Spectrum) -> f64 {
    (largest(bond, quartet) - 1.0) / (largest(bond, real) - 1.0)
}

/// The largest modulus of multipliers with `Re lambda < -1/2`.
fn behind(spectrum: &Spectrum) -> f64 {
    largest(spectrum, |m| m.re < -0.5)
}

/// Frequencies of Fig. r3floq, over its whole range, less `omega`.
const RANGE: [f64; 8] = [0.001, 0.03, 0.06, 0.09, 0.1, 0.13, 0.165, 0.2];

/// The breathers at `rho = 3`.
pub(in super::super) fn three(_: &Runs) -> Result<Vec<Quantity>> {
    const RHO: f64 = 3.0;
    let omega = omega(RHO)?;
    let range = RANGE.map(|by| omega + by);
    let [bonds, sites] = CENTERS.map(|center| spectra(RHO, center, &range));
    let (bonds, sites) = (bonds?, sites?);
    let at = |by: f64| RANGE.iter().position(|one| *one == by).unwrap_or(0);
    let (near, figure) = (at(0.09), at(0.1));
    let marginal = |k: usize| e_folds(sites[k].largest(), range[k]);
    let long = |center| released(RHO, center, range[figure], LONGEST, None);
    let (held, moved) = (long(Center::Site)?, long(Center::Bond)?);
    let e_b = held.e_b.last().copied().unwrap_or(f64::NAN);
    let gone = moved.position.last().map_or(f64::NAN, |end| (end - moved.position[0]).abs());
    Ok(vec![
        ("s7-rho3-omega", omega),
        ("s7-rho3-omega-b", range[figure]),
        ("s7-rho3-time", 299.0 * 2.0 * PI / range[figure]),
        ("s7-rho3-Eb", e_b),
        ("s7-rho3-growth", e_b / held.amplification),
        ("s7-rho3-moves", gone),
        ("s7-rho3-bond", largest(&bonds[figure], |m| m.kind == Kind::Real)),
        ("s7-rho3-bond-only-real", share(&bonds[figure])),
        ("s7-rho3-site", marginal(figure)),
        ("s7-rho3-range-real", least(bonds.iter().map(|bond| largest(bond, |m| m.kind == Kind::Real) - 1.0))),
        ("s7-rho3-range-bond", most(bonds.iter().map(share))),
        ("s7-rho3-range-site", most((0..range.len()).map(marginal))),
        ("s7-rho3-range-only-oscillatory", most(sites.iter().map(|site| largest(site, real) - 1.0))),
        ("s7-rho3-distribution", behind(&bonds[near]).max(behind(&sites[near]))),
    ])
}

/// The breathers at `rho = 10`.
pub(in super::super) fn ten(_: &Runs) -> Result<Vec<Quantity>> {
    const RHO: f64 = 10.0;
    let omega = omega(RHO)?;
    let small = orbit(RHO, Center::Bond, omega + 0.01)?;
    let range = [omega + 0.01, omega + 0.04, omega + 0.09, 1.2];
    let [bonds, sites] = CENTERS.map(|center| spectra(RHO, center, &range));
    let (bonds, sites) = (bonds?, sites?);
    let quartets = |spectra: &[Spectrum], k: usize| e_folds(largest(&spectra[k], quartet), range[k]);
    Ok(vec![
        ("s7-rho10-omega", omega),
        ("s7-rho10-amplitude", small.amplitude()),
        ("s7-rho10-near-real", least((0..2).map(|k| largest(&bonds[k], |m| m.kind == Kind::Real) - 1.0))),
        ("s7-rho10-near", most((0..2).flat_map(|k| [quartets(&bonds, k), quartets(&sites, k)]))),
        ("s7-rho10-bond", quartets(&bonds, 3)),
        ("s7-rho10-site", quartets(&sites, 3)),
        ("s7-rho10-distribution", behind(&bonds[2]).max(behind(&sites[2]))),
    ])
}

/// Frequencies of Fig. rhocts, and the mass ratios at which our branches begin; the paper gives no
/// range.
const CONTINUED: [(f64, f64); 3] = [(1.5, 1.1), (1.75, 0.65), (2.05, 1.0 / 3.0)];
/// The mass ratio at which our branches end, and that up to which the real instability grows at all
/// three frequencies.
const LAST: f64 = 3.0;
const RISING: f64 = 1.9;

/// A branch in `rho` at fixed frequency: mass ratios and spectra.
struct Branch(Vec<(f64, Spectrum)>);

impl Branch {
    fn new(center: Center, omega_b: f64, from: f64) -> Result<Self> {
        let shooting = Shooting::default();
        let orbits = follow(orbit(from, center, omega_b)?, Parameter::Rho, LAST, LAST - from)?;
        let spectra = map(&orbits, |orbit| Ok((orbit.setting.params.rho, orbit.spectrum(&shooting)?)));
        Ok(Self(spectra.into_iter().collect::<Result<_>>()?))
    }

    fn spectra(&self) -> impl Iterator<Item = &Spectrum> {
        self.0.iter().map(|(_, spectrum)| spectrum)
    }

    /// Largest `lambda - 1` of real multipliers.
    fn growths(&self) -> impl Iterator<Item = f64> {
        self.spectra().map(|spectrum| largest(spectrum, |m| m.kind == Kind::Real) - 1.0)
    }

    fn last(&self) -> &Spectrum {
        &self.0[self.0.len() - 1].1
    }
}

/// `ln |lambda|` of the site-centred breather with `omega_b = 1.75` at `rho = 1.4`, divided by that
/// at `rho = 1.1`, on the branch from `rho = 0.65`.
fn on_the_way() -> Result<f64> {
    let mut orbit = orbit(0.65, Center::Site, 1.75)?;
    let mut rates = [0.0; 2];
    for (to, rate) in [1.1, 1.4].into_iter().zip(&mut rates) {
        orbit = follow(orbit.clone(), Parameter::Rho, to, 0.25)?.pop().unwrap_or(orbit);
        *rate = orbit.spectrum(&Shooting::default())?.largest().ln();
    }
    Ok(rates[1] / rates[0])
}

/// The least quotient of a value and the value before it.
fn least_growth(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    least(values.windows(2).map(|two| two[1] / two[0]))
}

/// The branches in `rho` at fixed frequency.
pub(in super::super) fn continued(_: &Runs) -> Result<Vec<Quantity>> {
    let jobs: Vec<_> = CENTERS.into_iter().flat_map(|center| CONTINUED.map(|branch| (center, branch))).collect();
    let made = map(&jobs, |&(center, (omega_b, from))| Branch::new(center, omega_b, from));
    let made: Vec<Branch> = made.into_iter().collect::<Result<_>>()?;
    let (bonds, sites) = made.split_at(CONTINUED.len());
    let rate = |site: &Spectrum| site.largest().ln();
    let marginal = |of: fn(&Branch) -> &Spectrum| {
        let e_folds = CONTINUED.iter().zip(sites).map(|((omega_b, _), site)| e_folds(of(site).largest(), *omega_b));
        e_folds.collect::<Vec<f64>>()
    };
    let rising = |bond: &Branch| {
        let up_to = bond.0.iter().take_while(|(rho, _)| *rho <= RISING).count();
        (least_growth(bond.growths().take(up_to)), least_growth(bond.growths().skip(up_to - 1)))
    };
    let chaos = map(&CENTERS, |&center| {
        let run = released(0.4, center, 2.05, 400.0, None)?;
        let strong = |m: &&Multiplier| quartet(m) && m.im > 0.0 && m.modulus > 1.0 + WEAK;
        let quartets = run.orbit.spectrum(&Shooting::default())?.multipliers.iter().filter(strong).count();
        Ok((quartets as f64, most(run.e_b)))
    });
    let chaos = chaos.into_iter().collect::<Result<Vec<_>>>()?;
    Ok(vec![
        ("s7-rho-bond", least(bonds.iter().flat_map(Branch::growths))),
        ("s7-rho-only-bond", most(sites.iter().flat_map(Branch::spectra).map(|site| largest(site, real) - 1.0))),
        ("s7-rho-rising", least(bonds.iter().map(|bond| rising(bond).0))),
        ("s7-rho-falling", least(bonds.iter().map(|bond| rising(bond).1))),
        ("s7-rho-site", most(marginal(|site| &site.0[0].1))),
        ("s7-rho-site-heavy", least(marginal(Branch::last))),
        ("s7-rho-lifetime", least(sites.iter().map(|site| rate(site.last()) / rate(&site.0[0].1)))),
        ("s7-rho-lifetime-always", on_the_way()?),
        ("s7-rho-quartets", least(chaos.iter().map(|one| one.0))),
        ("s7-rho-chaos", least(chaos.iter().map(|one| one.1))),
    ])
}
