//! Dark breathers as exact orbits: one with its multipliers, a branch with its bifurcations, the branch of doubled period (Sec. 7).

use crate::sweep::map;
use crate::{
    breathers::DarkBreather,
    chain::MeanForces,
    dps::Center,
    error::{Error, Result},
    orbits::{Bifurcation, BifurcationKind, Continuation, End, Extent, Orbit, Parameter, Shooting, Spectrum},
};
use hertzchain_integrators::collocation::Pace;

/// An orbit and what is asked of it.
#[derive(Clone, Debug)]
pub struct OrbitStudy {
    /// The orbit.
    pub orbit: Orbit,
    /// Its multipliers.
    pub spectrum: Spectrum,
    /// Centres and amplitudes of the first bond.
    pub extent: Extent,
    /// `E_b(T)` (eq:relerr).
    pub e_b: f64,
    /// Mean contact force of every bond over a period, constant along the chain (Theorem nobreath).
    pub forces: MeanForces,
}

/// All that is asked of an orbit.
///
/// # Errors
/// An integration that fails.
pub fn orbit_study(orbit: Orbit, shooting: &Shooting) -> Result<OrbitStudy> {
    let (chain, period) = (orbit.setting.chain()?, orbit.setting.period());
    Ok(OrbitStudy {
        spectrum: orbit.spectrum(shooting)?,
        extent: orbit.extent(shooting.tol)?,
        e_b: orbit.e_b(shooting.tol, 1)?,
        forces: chain.mean_contact_forces(&orbit.start(), period, Pace::Tolerance(shooting.tol))?,
        orbit,
    })
}

/// A point of a branch.
#[derive(Clone, Debug)]
pub struct BranchPoint {
    /// The orbit.
    pub orbit: Orbit,
    /// Its multipliers.
    pub spectrum: Spectrum,
    /// Centres and amplitudes of the first bond.
    pub extent: Extent,
}

/// A branch of orbits.
#[derive(Clone, Debug)]
pub struct Branch {
    /// How it was followed.
    pub continuation: Continuation,
    /// Its points, in their order along it.
    pub points: Vec<BranchPoint>,
    /// What happens between them.
    pub bifurcations: Vec<Bifurcation>,
    /// Why it ended.
    pub end: End,
}

/// Told of the share that is done, and of what is being done.
pub type Progress<'a> = &'a (dyn Fn(f64, &str) + Sync);

/// Share of the work of a branch that its orbits are; the rest are multipliers and bifurcations.
const ORBITS: f64 = 0.4;

/// The branch of dark breathers through `breather`, followed as `continuation` says; collisions of multipliers up to a modulus of `1 + weak` are passed over.
///
/// # Errors
/// Numbers outside their rules, and no orbit to begin with.
pub fn branch(
    breather: &DarkBreather,
    continuation: &Continuation,
    weak: f64,
    progress: Progress<'_>,
) -> Result<Branch> {
    if !(weak.is_finite() && weak >= 0.0) {
        return Err(Error::parameter("weak", weak, "finite and at least zero"));
    }
    let mut last = *breather;
    last.set(continuation.parameter, continuation.to);
    if last.omega_b <= last.params.omega() {
        let rule = "a branch of dark breathers ends where they vanish: omega_b > omega = sqrt(kappa (1 + 1/rho)) up to its end";
        return Err(Error::parameter("to", continuation.to, rule));
    }
    branch_from(breather.orbit(&continuation.shooting)?, continuation, Some(weak), progress)
}

/// Bifurcations are located if `weak` is given.
pub(super) fn branch_from(
    start: Orbit,
    continuation: &Continuation,
    weak: Option<f64>,
    progress: Progress<'_>,
) -> Result<Branch> {
    let Continuation { parameter, to, ref shooting, .. } = *continuation;
    let from = start.setting.get(parameter);
    let (mut orbits, mut end) = continuation.follow(start, |orbit| {
        let p = orbit.setting.get(parameter);
        progress(ORBITS * ((p - from) / (to - from)).clamp(0.0, 1.0), &format!("{} = {p:.5}", parameter.name()));
    })?;
    progress(ORBITS, "multipliers");
    // A point without multipliers costs what comes after it, not the branch.
    let mut spectra = Vec::with_capacity(orbits.len());
    for spectrum in map(&orbits, |orbit| orbit.spectrum(shooting)) {
        match spectrum {
            Ok(spectrum) => spectra.push(spectrum),
            Err(error) if spectra.is_empty() => return Err(error),
            Err(_) => {
                (orbits, end) = (orbits[..spectra.len()].to_vec(), End::NoMultipliers);
                break;
            }
        }
    }
    let extents = map(&orbits, |orbit| orbit.extent(shooting.tol)).into_iter().collect::<Result<Vec<_>>>()?;
    progress(0.5 * (1.0 + ORBITS), "bifurcations");
    let bifurcations = weak.map_or(Vec::new(), |weak| continuation.bifurcations(&orbits, &spectra, weak));
    let points = orbits.into_iter().zip(spectra).zip(extents);
    let points = points.map(|((orbit, spectrum), extent)| BranchPoint { orbit, spectrum, extent }).collect();
    Ok(Branch { continuation: *continuation, points, bifurcations, end })
}

/// The branch of doubled period: where it is born, and its points.
#[derive(Clone, Debug)]
pub struct DoubledBranch {
    /// The period doubling of the main branch.
    pub birth: Bifurcation,
    /// The orbits of doubled period, the last one at the frequency asked for if the branch gets there.
    pub branch: Branch,
}

/// Relative size of the first orbit beyond the period doubling along its mode: below 0.005 Newton's method falls back on the main branch.
const FIRST_SIZE: f64 = 0.02;

/// Follows the main branch of bond-centred breathers up from the frequency of `breather`, by at most `step` a point, to its first period doubling below `most`;
/// there the branch of doubled period, to `omega_b` (that of the whole period). Bifurcations of the latter are not located: its background is unstable, and
/// the bands of that are full of collisions.
///
/// # Errors
/// No period doubling on the way, or numbers outside their rules.
pub fn doubled(
    breather: &DarkBreather,
    most: f64,
    omega_b: f64,
    step: f64,
    shooting: &Shooting,
    progress: Progress<'_>,
) -> Result<DoubledBranch> {
    let main = Continuation {
        parameter: Parameter::OmegaB,
        to: most,
        step,
        most_points: 10_000,
        natural: false,
        shooting: *shooting,
    };
    if breather.center != Center::Bond {
        return Err(Error::parameter(
            "center",
            "site",
            "only bond-centred breathers double their period: a site-centred one is the square of half its period",
        ));
    }
    let main = branch(breather, &main, 0.01, &|share, what| progress(0.5 * share, what))?;
    let birth = main.bifurcations.into_iter().find(|one| one.kind == BifurcationKind::PeriodDoubling);
    let Some(birth) = birth else {
        return Err(Error::parameter("most", most, "the main branch has no period doubling up to there"));
    };
    if omega_b <= birth.orbit.setting.omega_b / 2.0 {
        let rule =
            "the branch of doubled period goes up from half the frequency of the period doubling, 1.0316 at rho = 1/3";
        return Err(Error::parameter("omega-b", omega_b, rule));
    }
    let continuation = Continuation { to: omega_b, step: 0.5 * step, ..main.continuation };
    let first = birth.doubled(shooting, FIRST_SIZE)?;
    let branch = branch_from(first, &continuation, None, &|share, what| progress(0.5 + 0.5 * share, what))?;
    Ok(DoubledBranch { birth, branch })
}
