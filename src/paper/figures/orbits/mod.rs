//! Figures of Sec. 7: dark breathers as exact orbits on rings of 41 bonds, with
//! `alpha = 3/2, kappa = 1`.

mod show;

#[cfg(feature = "plot")]
pub(super) use show::orbit_panels;
pub(super) use show::{orbit_caption, orbit_tables};

use crate::{
    breathers::DarkBreather,
    chain::Params,
    dps::Center,
    error::{Error, Result},
    orbits::{Bifurcation, BifurcationKind, Branch, Continuation, Orbit, Parameter, Setting, Shooting},
    study::{DoubledBranch, Evolution, Kick, OrbitStudy, doubled_from, evolve, go_on, orbit_study},
    sweep::Tally,
};

const SITES: usize = 41;
/// Collisions that lead to no modulus above one plus this are left out.
const WEAK: f64 = 0.01;
/// Branches in the mass ratio begin where `omega_b / omega` has this value.
const ABOVE: f64 = 1.004;
/// Branches in the mass ratio have short steps up to this multiple of the first mass ratio.
const NEAR: f64 = 5.0;
/// Size of the push along the mode at -1, in units of the amplitude, for a seed of doubled period.
const SEED: f64 = 0.1;

/// Kind and parameters of a figure of Sec. 7.
#[derive(Debug)]
pub enum OrbitRecipe {
    /// Exact profiles compared with those of the DpS equations and with themselves after a period.
    Profiles {
        /// Mass ratio.
        rho: f64,
        /// Frequency.
        omega_b: f64,
    },
    /// Multipliers against the frequency, and all multipliers at one frequency.
    Floquet {
        /// Mass ratio.
        rho: f64,
        /// Ends of the branch, as differences from `omega`.
        above: [f64; 2],
        /// Approximate number of points of a branch.
        points: u32,
        /// The frequency at which all multipliers are shown.
        at: f64,
        /// End of the enlarged part of the site-centred family, as difference from `omega`.
        zoom: Option<f64>,
        /// Whether bifurcations are located.
        bifurcations: bool,
    },
    /// `E_b` of site-centred breathers at a given time against the frequency, at `rho = 1/3`.
    ReturnErrors {
        /// Ends of the branch.
        omega_b: [f64; 2],
        /// Approximate number of points of the branch.
        points: u32,
        /// The time of `E_b`.
        until: f64,
    },
    /// Evolutions of orbits on the chain.
    Evolutions {
        /// Mass ratio.
        rho: f64,
        /// The runs.
        runs: &'static [EvolutionRun],
        /// Whether profiles at the end are shown.
        profiles: bool,
    },
    /// The mode at the period doubling at `rho = 1/3`, and an orbit of doubled period.
    Doubling {
        /// Frequency of the orbit of doubled period.
        omega_b: f64,
    },
    /// The branch of doubled period at `rho = 1/3`.
    Doubled {
        /// Frequency of the orbit that is shown.
        omega_b: f64,
        /// Frequency at which the branch ends.
        to: f64,
    },
    /// Multipliers against the mass ratio.
    MassRatios {
        /// Frequencies.
        omega_b: &'static [f64],
        /// Largest mass ratio.
        to: f64,
        /// Approximate number of points up to 5 times the first mass ratio, and beyond it.
        points: [u32; 2],
    },
}

/// An evolution of an orbit on the chain.
#[derive(Debug)]
pub struct EvolutionRun {
    /// Position of the kink.
    pub center: Center,
    /// Frequency.
    pub omega_b: f64,
    /// End time.
    pub until: f64,
    /// Size of a kick along the mode of the largest multiplier; `None` for no kick.
    pub kick: Option<f64>,
}

/// The numbers of a figure of Sec. 7.
#[derive(Debug)]
pub enum OrbitData {
    /// A profile for each centre.
    Profiles(Vec<ProfileData>),
    /// A branch and an orbit for each centre, and the end of the enlarged part.
    Floquet(Vec<FloquetData>, Option<f64>),
    /// The branch, `E_b` at each of its points, and the time of `E_b`.
    ReturnErrors(Branch, Vec<f64>, f64),
    /// The evolutions, and whether profiles are shown.
    Evolutions(Vec<(Center, Evolution)>, bool),
    /// The mode and the orbit.
    Doubling(DoublingData),
    /// The orbit of doubled period, its strains after half a period and after a period, and the
    /// branch.
    Doubled(Box<OrbitStudy>, [Vec<f64>; 2], Box<DoubledBranch>),
    /// Branches in the mass ratio: for each frequency, one for each centre.
    MassRatios(Vec<MassRatioData>),
}

/// An exact profile.
#[derive(Debug)]
pub struct ProfileData {
    /// Position of the kink.
    pub center: Center,
    /// The orbit and its multipliers.
    pub study: OrbitStudy,
    /// `Z` by the profile of the DpS equations.
    pub seed: Vec<f64>,
    /// `Z(T)`.
    pub after: Vec<f64>,
}

/// The branch of a family in the frequency.
#[derive(Debug)]
pub struct FloquetData {
    /// Position of the kink.
    pub center: Center,
    /// Orbits and their multipliers.
    pub branch: Branch,
    /// The orbit at one frequency.
    pub one: OrbitStudy,
}

/// A period doubling.
#[derive(Debug)]
pub struct DoublingData {
    /// The bifurcation, with its mode.
    pub birth: Bifurcation,
    /// The seed `Z`.
    pub seed: Vec<f64>,
    /// The orbit to which Newton's method converges from the seed.
    pub orbit: Orbit,
}

/// The branch of a family in the mass ratio.
#[derive(Debug)]
pub struct MassRatioData {
    /// Position of the kink.
    pub center: Center,
    /// Frequency of the branch.
    pub omega_b: f64,
    /// Orbits and their multipliers.
    pub branch: Branch,
}

const THIRD: f64 = 1.0 / 3.0;
/// The two centres in the order of the paper's panels.
const BOTH: [Center; 2] = [Center::Bond, Center::Site];

fn breather(rho: f64, center: Center, omega_b: f64) -> DarkBreather {
    DarkBreather { params: Params { alpha: 1.5, kappa: 1.0, rho }, center, sites: SITES, omega_b, c_x: 0.0 }
}

fn omega(rho: f64) -> f64 {
    Params { alpha: 1.5, kappa: 1.0, rho }.omega()
}

/// A continuation in steps of at most `step`.
fn along(parameter: Parameter, to: f64, step: f64) -> Continuation {
    Continuation { parameter, to, step, most_points: 2000, natural: false, shooting: Shooting::default() }
}

/// The results of `work` for all `items`, computed on all cores.
fn each<T: Sync, U: Send>(
    items: &[T],
    progress: &(dyn Fn(f64) + Sync),
    work: impl Fn(&T) -> Result<U> + Sync + Send,
) -> Result<Vec<U>> {
    let tell = |done: u64, total: u64| progress(done as f64 / total as f64);
    Tally::new(items.len(), &tell).map(items, work).into_iter().collect()
}

/// The branch from an orbit on to its end; bifurcations are located if `weak` is given.
fn follow(start: Orbit, continuation: &Continuation, weak: Option<f64>) -> Result<Branch> {
    go_on(Branch { weak, ..Branch::new(*continuation, start.setting, start)? }, &mut |_| {}, &|_, _| {})?.reached()
}

/// The branch of a family between two frequencies; bifurcations are located if `bifurcations`.
fn family(rho: f64, center: Center, [from, to]: [f64; 2], points: u32, bifurcations: bool) -> Result<Branch> {
    let continuation = along(Parameter::OmegaB, to, (to - from) / f64::from(points));
    let start = breather(rho, center, from).orbit(&continuation.shooting)?;
    follow(start, &continuation, bifurcations.then_some(WEAK))
}

/// The branch at a frequency from a mass ratio near `omega(rho) = omega_b` up to the mass ratio
/// `to`.
fn mass_ratios(center: Center, omega_b: f64, to: f64, points: [u32; 2], shooting: &Shooting) -> Result<Branch> {
    let from = ((omega_b / ABOVE).powi(2) - 1.0).recip();
    let start = breather(from, center, omega_b).orbit(shooting)?;
    let near = (NEAR * from).min(0.5 * (from + to));
    let leg = |start: Orbit, from: f64, to: f64, points: u32| {
        follow(start, &along(Parameter::Rho, to, (to - from) / f64::from(points)), None)
    };
    let mut branch = leg(start, from, near, points[0])?;
    // The last point of the first part is the first point of the second part.
    if let Some(last) = branch.points.pop() {
        let rest = leg(last.orbit, near, to, points[1])?;
        branch.points.extend(rest.points);
        branch.gaps.extend(rest.gaps);
        branch.continuation = rest.continuation;
    }
    Ok(branch)
}

impl OrbitRecipe {
    /// Computes the numbers of the figure; `progress` is called with the finished share of the
    /// work.
    pub(super) fn data(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<OrbitData> {
        let shooting = Shooting::default();
        match *self {
            Self::Profiles { rho, omega_b } => {
                let profile = |center: &Center| {
                    let breather = breather(rho, *center, omega_b);
                    let study = orbit_study(breather.orbit(&shooting)?, &shooting)?;
                    let after = strains_at(&study.orbit, 1.0)?;
                    Ok(ProfileData { center: *center, seed: breather.seed()?, after, study })
                };
                Ok(OrbitData::Profiles(each(&BOTH, progress, profile)?))
            }
            Self::Floquet { rho, above, points, at, zoom, bifurcations } => {
                let ends = above.map(|above| omega(rho) + above);
                let one = |center: &Center| {
                    let branch = family(rho, *center, ends, points, bifurcations)?;
                    let one = orbit_study(breather(rho, *center, at).orbit(&shooting)?, &shooting)?;
                    Ok(FloquetData { center: *center, branch, one })
                };
                Ok(OrbitData::Floquet(each(&BOTH, progress, one)?, zoom.map(|zoom| omega(rho) + zoom)))
            }
            Self::ReturnErrors { omega_b, points, until } => {
                let branch = family(THIRD, Center::Site, omega_b, points, true)?;
                let error = |orbit: &Orbit| orbit.e_b(shooting.tol, (until / orbit.setting.period()) as u32);
                let orbits: Vec<Orbit> = branch.points.iter().map(|point| point.orbit.clone()).collect();
                Ok(OrbitData::ReturnErrors(branch, each(&orbits, progress, error)?, until))
            }
            Self::Evolutions { rho, runs, profiles } => {
                let run = |run: &EvolutionRun| {
                    let orbit = breather(rho, run.center, run.omega_b).orbit(&shooting)?;
                    let kick = run.kick.map(|size| Kick { size, mode: 0 });
                    Ok((run.center, evolve(&orbit, run.until, kick, &shooting, &|_, _| {})?))
                };
                Ok(OrbitData::Evolutions(each(runs, progress, run)?, profiles))
            }
            Self::Doubling { omega_b } => Ok(OrbitData::Doubling(doubling(&about_doubling()?, omega_b, &shooting)?)),
            Self::Doubled { omega_b, to } => {
                let main = about_doubling()?;
                let study = orbit_study(doubling(&main, omega_b, &shooting)?.orbit, &shooting)?;
                let later = [strains_at(&study.orbit, 0.5)?, strains_at(&study.orbit, 1.0)?];
                let doubled = doubled_from(&main, to, 1e-3, &mut |_| {}, &|share, _| progress(share))?;
                let doubled = DoubledBranch { branch: doubled.branch.reached()?, ..doubled };
                Ok(OrbitData::Doubled(Box::new(study), later, Box::new(doubled)))
            }
            Self::MassRatios { omega_b, to, points } => {
                let pairs: Vec<(f64, Center)> = omega_b.iter().flat_map(|&w| BOTH.map(|center| (w, center))).collect();
                let one = |&(omega_b, center): &(f64, Center)| {
                    Ok(MassRatioData { center, omega_b, branch: mass_ratios(center, omega_b, to, points, &shooting)? })
                };
                Ok(OrbitData::MassRatios(each(&pairs, progress, one)?))
            }
        }
    }
}

/// `Z` after `periods` periods.
fn strains_at(orbit: &Orbit, periods: f64) -> Result<Vec<f64>> {
    let mut states = orbit.states(Shooting::default().tol, &[periods * orbit.setting.period()])?;
    Ok(states.remove(0)[..orbit.z.len()].to_vec())
}

/// The bond-centred family at `rho = 1/3` near its first period doubling.
fn about_doubling() -> Result<Branch> {
    family(THIRD, Center::Bond, [2.062, 2.064], 1, true)
}

/// The period doubling of a branch, and the orbit of doubled period at `omega_b` that is found from
/// a push along the mode.
fn doubling(main: &Branch, omega_b: f64, shooting: &Shooting) -> Result<DoublingData> {
    let birth = main.bifurcations.iter().find(|one| one.kind == BifurcationKind::PeriodDoubling).cloned();
    let birth = birth.ok_or_else(|| Error::parameter("omega_b", 2.064, "a period doubling below"))?;
    let by = SEED * birth.orbit.amplitude();
    let seed: Vec<f64> = birth.orbit.z.iter().zip(&birth.critical.mode).map(|(z, mode)| z + by * mode).collect();
    let orbit = shooting.solve(&Setting { omega_b, turns: 2, ..birth.orbit.setting }, &seed)?;
    Ok(DoublingData { birth, seed, orbit })
}
