//! Dark breathers as exact orbits: one with its multipliers, a branch with its bifurcations, the branch of doubled period (Sec. 7).

use crate::sweep::map;
use crate::{
    breathers::DarkBreather,
    chain::MeanForces,
    dps::Center,
    error::{Error, Result},
    interrupt,
    orbits::{
        Bifurcation, BifurcationKind, Continuation, End, Extent, Orbit, Parameter, Setting, Shooting, Spectrum, Trail,
    },
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
    /// How it was searched for and measured.
    pub shooting: Shooting,
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
        shooting: *shooting,
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
    /// All of its orbits, with what it takes to go on; more than points, where one has no multipliers.
    pub trail: Trail,
}

/// Given what there is of a branch after every point, to keep it.
pub type Keep<'a> = &'a mut dyn FnMut(&Trail);

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
    go_on(begin(breather, continuation, weak)?, &mut |_| {}, progress)
}

/// The first point of [`branch`].
///
/// # Errors
/// As there.
pub fn begin(breather: &DarkBreather, continuation: &Continuation, weak: f64) -> Result<Trail> {
    if !(weak.is_finite() && weak >= 0.0) {
        return Err(Error::parameter("weak", weak, "finite and at least zero"));
    }
    stays_dark(&breather.setting(), continuation)?;
    let trail = Trail::new(*continuation, breather.orbit(&continuation.shooting)?)?;
    Ok(Trail { center: Some(breather.center), weak: Some(weak), ..trail })
}

/// Where it is to go there are breathers.
fn stays_dark(setting: &Setting, continuation: &Continuation) -> Result<()> {
    let last = setting.with(continuation.parameter, continuation.to);
    if f64::from(last.turns) * last.omega_b <= last.params.omega() {
        let rule = "a branch of dark breathers ends where they vanish: omega_b > omega = sqrt(kappa (1 + 1/rho)) up to its end";
        return Err(Error::parameter("to", continuation.to, rule));
    }
    Ok(())
}

/// Follows a branch on, unless it has ended, and studies it.
///
/// # Errors
/// Numbers outside their rules, and no multipliers at its first point; `keep` was then given its orbits.
pub fn go_on(mut trail: Trail, keep: Keep<'_>, progress: Progress<'_>) -> Result<Branch> {
    if let (Some(first), None) = (trail.orbits.first(), trail.end) {
        let Continuation { parameter, to, .. } = trail.continuation;
        let from = first.setting.get(parameter);
        stays_dark(&first.setting, &trail.continuation)?;
        let extended = trail.extend(|trail| {
            keep(trail);
            let p = trail.orbits.last().map_or(from, |orbit| orbit.setting.get(parameter));
            let share = ((p - from) / (to - from)).clamp(0.0, 1.0);
            progress(ORBITS * share, &format!("{} = {p:.5}", parameter.name()));
        });
        keep(&trail);
        extended?;
    }
    study(trail, progress)
}

/// Multipliers, extents and bifurcations of a branch that was followed.
///
/// # Errors
/// No multipliers at its first point.
pub fn study(trail: Trail, progress: Progress<'_>) -> Result<Branch> {
    let (continuation, orbits) = (trail.continuation, &trail.orbits);
    let shooting = &continuation.shooting;
    let mut end = trail.end.unwrap_or(End::MostPoints);
    progress(ORBITS, "multipliers");
    // A point without multipliers costs what comes after it, not the branch.
    let mut spectra = Vec::with_capacity(orbits.len());
    let spectrum = |orbit: &Orbit| {
        let stopped =
            || Error::Stopped { kept: format!("all {} points of the branch, not yet its multipliers", orbits.len()) };
        if interrupt::asked() { Err(stopped()) } else { orbit.spectrum(shooting) }
    };
    for spectrum in map(orbits, spectrum) {
        match spectrum {
            Err(stopped @ Error::Stopped { .. }) => return Err(stopped),
            Ok(spectrum) => spectra.push(spectrum),
            Err(error) if spectra.is_empty() => return Err(error),
            Err(_) => {
                end = End::NoMultipliers;
                break;
            }
        }
    }
    let orbits = &orbits[..spectra.len()];
    let extents = map(orbits, |orbit| orbit.extent(shooting.tol)).into_iter().collect::<Result<Vec<_>>>()?;
    progress(0.5 * (1.0 + ORBITS), "bifurcations");
    let bifurcations = trail.weak.map_or(Vec::new(), |weak| continuation.bifurcations(orbits, &spectra, weak));
    let points = orbits.iter().cloned().zip(spectra).zip(extents);
    let points = points.map(|((orbit, spectrum), extent)| BranchPoint { orbit, spectrum, extent }).collect();
    Ok(Branch { continuation, points, bifurcations, end, trail })
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

/// Follows the main branch of bond-centred breathers up from the frequency of `breather`, by at most `step` a point, to `most` at the furthest;
/// at its first period doubling the branch of doubled period, as [`doubled_from`] does.
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
    let main = main_branch(breather, most, step, shooting, &|share, what| progress(0.5 * share, what))?;
    doubled_from(&main, omega_b, step, &mut |_| {}, &|share, what| progress(0.5 + 0.5 * share, what))
}

/// The main branch of bond-centred breathers, up from the frequency of `breather` to `most`.
///
/// # Errors
/// As [`branch`]; a site-centred breather.
pub fn main_branch(
    breather: &DarkBreather,
    most: f64,
    step: f64,
    shooting: &Shooting,
    progress: Progress<'_>,
) -> Result<Branch> {
    let continuation = Continuation {
        parameter: Parameter::OmegaB,
        to: most,
        step,
        most_points: 10_000,
        natural: false,
        shooting: *shooting,
    };
    bond_centred(Some(breather.center))?;
    branch(breather, &continuation, 0.01, progress)
}

fn bond_centred(center: Option<Center>) -> Result<()> {
    let rule = "only bond-centred breathers double their period: a site-centred one is the square of half its period";
    if center == Some(Center::Site) { Err(Error::parameter("center", "site", rule)) } else { Ok(()) }
}

/// Leaves a main branch at its first period doubling, and follows the branch of doubled period to `omega_b` (that of the whole period). Bifurcations of the
/// latter are not located: its background is unstable, and the bands of that are full of collisions.
///
/// # Errors
/// No period doubling on the main branch, or numbers outside their rules.
pub fn doubled_from(
    main: &Branch,
    omega_b: f64,
    step: f64,
    keep: Keep<'_>,
    progress: Progress<'_>,
) -> Result<DoubledBranch> {
    bond_centred(main.trail.center)?;
    if main.points.iter().any(|point| point.orbit.setting.turns > 1) {
        return Err(Error::parameter("turns", 2, "the main branch has one turn a period: this one is doubled"));
    }
    let Continuation { to, ref shooting, .. } = main.continuation;
    let birth = main.bifurcations.iter().find(|one| one.kind == BifurcationKind::PeriodDoubling).cloned();
    let Some(birth) = birth else {
        return Err(Error::parameter("most", to, "the main branch has no period doubling up to there"));
    };
    if omega_b <= birth.orbit.setting.omega_b / 2.0 {
        let rule =
            "the branch of doubled period goes up from half the frequency of the period doubling, 1.0316 at rho = 1/3";
        return Err(Error::parameter("omega-b", omega_b, rule));
    }
    let continuation =
        Continuation { parameter: Parameter::OmegaB, to: omega_b, step: 0.5 * step, ..main.continuation };
    let trail = Trail { center: main.trail.center, ..Trail::new(continuation, birth.doubled(shooting, FIRST_SIZE)?)? };
    Ok(DoubledBranch { birth, branch: go_on(trail, keep, progress)? })
}
