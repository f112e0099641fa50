//! Dark breathers as exact orbits: one orbit with its multipliers, a branch of orbits with its
//! bifurcations, and the branch of doubled period (Sec. 7).

mod report;

pub(crate) use report::KINDS;
pub use report::branch_report;

use crate::study::{
    ChainParams, Progress, ResultUnits, Study, Work,
    options::options,
    orbits::branches::{
        self, Begun, BifurcationOptions, BranchOptions, BranchStudy, FollowCommand, Kept, files_of_branch,
    },
    orbits::proof::{self, Proving, near_breather, near_doubling, of_infinite, of_unstable},
    part,
};
use crate::{
    breathers::DarkBreather,
    chain::MeanForces,
    dps::Center,
    error::{Error, NOTHING, Result, refuse, require},
    interrupt,
    orbits::{
        AnalysisLevel, Bifurcation, BifurcationKind, Branch, Continuation, Extent, Formulation, Orbit, OrbitMeasures,
        OrbitPoint, Parameter, Setting, Shooting, Spectrum,
    },
    output::Array,
    report::Report,
    sweep::{Engine, map},
};
use hertzchain_integrators::collocation::StepControl;
use hertzchain_proofs::certificate::Certificate;
use std::path::PathBuf;

/// Default frequencies in units of `omega`: of a single breather, as in the paper, and at the ends
/// of a branch; and amplitudes of backgrounds under a precompression, in units of it.
pub(crate) const ONE: [f64; 2] = [1.025, 0.5];
const RANGE: [[f64; 2]; 2] = [[1.005, 0.4], [1.05, 0.9]];
/// Largest step as a share of the range of the parameter, if none is given: bifurcations of dark
/// breathers lie near each other.
const STEP: f64 = 0.01;

options! {
    /// The ring and the breather on it.
    pub struct Ring {
        /// Number of sites.
        ///
        /// The ring has an odd number of sites, n = -N .. N; about a site at least 5. Weak quartets
        /// of multipliers, and their number, depend on it.
        sites: usize = 41, "N", (3 to 255);
        /// The chain.
        params: ChainParams = ChainParams::default();
        /// Static overlap D of the contacts.
        ///
        /// The background has the vertical centre C_x = -D (eq:center); below 0 contacts have gaps.
        precompression: f64 = 0.0, "D", (finite);
        /// Equations of Newton's method.
        formulation: Formulation = Formulation::HalfPeriod, "F", [default_value = "half-period"];
        /// Tolerance.
        tol: f64 = Shooting::default().tol, "T", (RUN), [long_help = crate::study::OF_WINDOWS];
    }
}

impl Ring {
    pub(crate) fn shooting(&self) -> Shooting {
        Shooting { formulation: self.formulation, tol: self.tol, ..Shooting::default() }
    }

    /// `C_x`, of a positive zero.
    pub(crate) fn c_x(&self) -> f64 {
        0.0 - self.precompression
    }

    /// A breather of this frequency, by default the [usual](DarkBreather::usual_frequency) one.
    pub(crate) fn breather(&self, center: Center, omega_b: Option<f64>, usual: [f64; 2]) -> Result<DarkBreather> {
        self.within_ranges()?;
        require((center, self.sites) != (Center::Site, 3), "sites", 3, "a breather about a site needs 5 sites")?;
        let params = self.params.checked()?;
        let breather = DarkBreather { params, center, sites: self.sites, omega_b: f64::NAN, c_x: self.c_x() };
        let own = breather.usual_frequency(usual);
        require(!own.is_nan(), "precompression", self.precompression, "one whose bands are numbers")?;
        Ok(DarkBreather { omega_b: omega_b.unwrap_or(own), ..breather })
    }
}

options! {
    /// A dark breather as an exact periodic orbit.
    pub struct Dark {
        /// What the profile is symmetric about.
        ///
        /// The kink is on the site 0, or on the bond between the sites 0 and 1.
        center: Center = Center::Site, "C";
        /// Frequency of the breather, in radians per unit of time [default: 1.025 omega].
        ///
        /// Above omega = sqrt(kappa (1 + 1/rho)). Under a precompression below the upper edge of a
        /// band, by default that at which the background has half its strain.
        omega_b: Option<f64> = None, "W";
        /// The ring.
        ring: Ring = Ring::default();
        /// Prove the breather of the infinite chain near that of the ring.
        ///
        /// Far from its centre it converges to standing waves of opposite phase, with the mean
        /// strain of the far end of the ring.
        infinite: bool = false, [requires = "prove", conflicts_with = "to_zero"];
        /// The proof.
        proving: Proving = Proving::default();
    }
}

/// A dark breather with its multipliers and measurements.
#[derive(Clone, Debug)]
pub struct DarkStudy {
    /// The centre of its symmetry, a site or a bond.
    pub center: Center,
    /// The orbit and its multipliers, with measured errors of both.
    pub study: OrbitStudy,
}

impl Study for Dark {
    const FILES: &'static str =
        "dark-breather.npz has the orbit, for `breather evolve` and `breather continue --resume`.";

    fn outline() -> Option<Report> {
        Some(Report::new("dark-breather").table(report::outside(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let breather = self.breather()?;
        self.proving.file()?;
        Ok(Box::new(move |_, _| {
            let study = self.study(&breather)?;
            let report = study.report().file("dark-breather.npz", study.npz()?);
            let (OrbitStudy { orbit, spectrum, .. }, tol) = (&study.study, self.ring.tol);
            let why = if self.infinite { "; the ring may be too short: --sites" } else { "" };
            self.proving.added(report, proof::BREATHER, why, &[], |times| match self.infinite {
                true => of_infinite(orbit, tol, times),
                false => of_unstable(orbit, spectrum.largest_real(), tol, times),
            })
        }))
    }
}

impl DarkStudy {
    /// The file of the orbit, which may go on as a branch in its frequency.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn npz(&self) -> Result<Vec<u8>> {
        let OrbitStudy { orbit, spectrum, extent, shooting, .. } = &self.study;
        let (parameter, shooting) = (Parameter::OmegaB, *shooting);
        let continuation = Continuation { parameter, to: 0.0, step: 0.0, most_points: 0, shooting };
        let measures = OrbitMeasures { extent: *extent };
        let point = OrbitPoint { orbit: orbit.clone(), spectrum: spectrum.clone(), measures };
        let branch = branches::alone(continuation, &orbit.setting, point)?;
        branches::branch_npz(&(), &Branch { weak: Some(Continue::default().weak), ..branch })
    }
}

impl Dark {
    /// The breather that the options describe.
    ///
    /// # Errors
    /// Parameters of the chain outside their rules.
    pub fn breather(&self) -> Result<DarkBreather> {
        self.ring.breather(self.center, self.omega_b, ONE)
    }

    /// The orbit of a breather, with its multipliers and measurements.
    ///
    /// # Errors
    /// As [`DarkBreather::orbit`] and [`orbit_study`].
    pub fn study(&self, breather: &DarkBreather) -> Result<DarkStudy> {
        let shooting = self.ring.shooting();
        let study = orbit_study(breather.orbit(&shooting)?, &shooting)?;
        Ok(DarkStudy { center: breather.center, study })
    }
}

options! {
    /// A branch of dark breathers in one parameter.
    pub struct Continue {
        /// What the profile is symmetric about.
        ///
        /// The kink is on the site 0, or on the bond between the sites 0 and 1.
        center: Center = Center::Site, "C";
        /// What varies along the branch.
        ///
        /// omega_b, rho, kappa, alpha or c_x, which is minus the precompression.
        vary: String = "omega_b".to_owned(), "P", [alias = "parameter"];
        /// First value of the parameter [default for omega_b: 1.005 omega].
        from: Option<f64> = None, "P", (finite);
        /// What every branch asks for.
        branch: BranchOptions = BranchOptions::default();
        /// Locate bifurcations, or not (=false).
        ///
        /// They need multipliers. Not by default.
        bifurcations: Option<bool> = None, "BOOL";
        /// Do not locate collisions of multipliers that stay below 1 + WEAK.
        ///
        /// The moduli of the multipliers are compared with 1 + WEAK.
        weak: f64 = 0.01, "WEAK", (from 0), [requires = "bifurcations", hide_short_help = true];
        /// Frequency of the breather, in radians per unit of time [default: 1.025 omega].
        ///
        /// For branches in another parameter. Above omega = sqrt(kappa (1 + 1/rho)).
        omega_b: Option<f64> = None, "W", [hide_short_help = true];
        /// The ring.
        ring: Ring = Ring::default();
        /// The proof.
        proving: Proving = Proving::default();
    } command |command| command.mut_arg("to", |arg| arg.help("Last value of the parameter [default for omega_b: 1.05 omega]")).mut_arg("resume", |arg| arg.conflicts_with_all([
            "center", "vary", "from", "weak", "omega_b",
            "sites", "alpha", "kappa", "rho", "precompression", "formulation", "tol",
        ]))
}

impl Continue {
    /// The branch with its first orbit only.
    fn new_branch(&self) -> Result<Branch> {
        let Some(parameter) = Parameter::ALL.into_iter().find(|one| one.name() == self.vary) else {
            return Err(Error::unknown("vary", &self.vary, Parameter::ALL.map(Parameter::name)));
        };
        let mut breather = self.ring.breather(self.center, self.omega_b, ONE)?;
        let varies = parameter == Parameter::OmegaB;
        let (own, usual) = (self.ring.params, ChainParams::default());
        let beside = |value: f64, usual: f64| Some(value).filter(|value| *value != usual);
        let (name, given) = match parameter {
            Parameter::OmegaB => ("omega-b", self.omega_b),
            Parameter::Rho => ("rho", beside(own.rho, usual.rho)),
            Parameter::Kappa => ("kappa", beside(own.kappa, usual.kappa)),
            Parameter::Alpha => ("alpha", beside(own.alpha, usual.alpha)),
            Parameter::Cx => ("precompression", beside(self.ring.precompression, 0.0)),
        };
        refuse(name, given, "it is the parameter that varies: give --from and --to")?;
        let end = |given: Option<f64>, usual: [f64; 2], name: &'static str| match given {
            Some(value) => Ok(value),
            None if varies => Ok(breather.usual_frequency(usual)),
            None => Err(Error::parameter(name, NOTHING, "a parameter other than omega_b needs --from and --to")),
        };
        let (from, to) = (end(self.from, RANGE[0], "--from")?, end(self.branch.to, RANGE[1], "--to")?);
        breather.set(parameter, from);
        if !varies {
            breather.omega_b = self.omega_b.unwrap_or_else(|| breather.usual_frequency(ONE));
        }
        let continuation = Continuation {
            parameter,
            to,
            step: self.branch.step.unwrap_or(STEP * (to - from).abs()),
            most_points: self.branch.max_points,
            shooting: self.ring.shooting(),
        };
        let of_from = |why: &Error| matches!(why, Error::Parameter { name, .. } if *name == parameter.name());
        stays_dark(&breather.setting(), &continuation)?;
        let first = breather.orbit(&continuation.shooting);
        let branch = first.and_then(|first| Branch::new(continuation, breather.setting(), first));
        let branch = branch.map_err(|why| if of_from(&why) { why.named("from") } else { why })?;
        Ok(Branch { weak: Some(self.weak), ..branch })
    }
}

impl FollowCommand for Continue {
    type Problem = Continuation;

    fn options(&self) -> (&BranchOptions, BifurcationOptions, ResultUnits) {
        let more = BifurcationOptions { bifurcations: self.bifurcations, switch: None };
        (&self.branch, more, ResultUnits::default())
    }

    fn first(&self) -> Result<Work<'_, Begun<Continuation>>> {
        self.within_ranges()?;
        let branch = self.with_options(self.new_branch()?)?;
        Ok(Box::new(|_, _| Ok(((), branch, None))))
    }

    fn with_options(&self, branch: Branch) -> Result<Branch> {
        self.proving.of_branch(branch.continuation.parameter.name(), Parameter::OmegaB.name())?;
        stays_dark(&branch.setting, &branch.continuation)?;
        Ok(branch)
    }

    fn proving(&self) -> Option<&Proving> {
        Some(&self.proving)
    }

    fn near(&self, branch: &Branch) -> Result<Vec<Certificate>> {
        let tol = branch.continuation.shooting.tol;
        let near = |&k: &usize| -> Result<Vec<Certificate>> {
            let orbit = &branch.orbits[k];
            let mut near = vec![near_breather(orbit, tol)?];
            let after = |it: &&Bifurcation| it.after == k && it.kind == BifurcationKind::PeriodDoubling;
            for it in branch.bifurcations.iter().filter(after) {
                near.extend(near_doubling(&it.orbit, tol, orbit.setting.omega_b)?);
            }
            Ok(near)
        };
        let all = map(&(0..branch.orbits.len()).collect::<Vec<_>>(), near);
        let mut all = all.into_iter().collect::<Result<Vec<_>>>()?.concat();
        // From its end: where a branch of doubled period begins, its inequalities have no solution.
        if branch.setting.turns > 1 {
            all.reverse();
        }
        Ok(all)
    }
}

options! {
    /// The branch of doubled period.
    pub struct Doubled {
        /// Frequency of the breather, in radians per unit of time.
        ///
        /// The frequency at which the branch of doubled period ends: that of the whole period,
        /// about half of the frequency of the main branch.
        omega_b: f64 = 1.056, "W", (positive);
        /// Frequency up to which a period doubling is searched for [default: 1.05 omega].
        ///
        /// The main branch is followed no further without one.
        most: Option<f64> = None, "W", (positive);
        /// Largest change of the frequency from point to point.
        ///
        /// On the main branch; on the doubled one half of it.
        step: f64 = 0.002, "DW", (positive);
        /// File branch.npz of the main branch [default: it is computed here].
        ///
        /// A file that `breather continue --center bond` has written.
        branch: Option<PathBuf> = None, "FILE",
            [conflicts_with_all = ["most", "sites", "alpha", "kappa", "rho", "precompression", "formulation", "tol"]];
        /// The ring.
        ring: Ring = Ring::default();
        /// The proof.
        proving: Proving = Proving::default();
    }
}

/// The branch of doubled period, with the measurements of its last orbit.
#[derive(Clone, Debug)]
pub struct DoubledStudy {
    /// The period doubling of the main branch.
    pub birth: Bifurcation,
    /// The orbits of doubled period, the last one at the frequency asked for if the branch gets
    /// there.
    pub branch: Branch,
    /// Its last orbit, if there is one.
    pub last: Option<OrbitStudy>,
}

impl Study for Doubled {
    const FILES: &'static str = "branch.npz has every orbit; it is written every 20 points or 10 s as well. \
                                 spectra.store has multipliers, from which the same command goes on.";
    const INTERRUPTIBLE: bool = true;

    fn outline() -> Option<Report> {
        Some(report::outline().table(report::outside(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        // Before the main branch is followed, which takes long.
        self.ring.breather(Center::Bond, None, RANGE[0])?;
        self.within_ranges()?;
        self.proving.file()?;
        Ok(Box::new(move |engine, progress| {
            let half = part(progress, 0.0, 0.5);
            let main = match &self.branch {
                Some(file) => study(Branch::load(file)?, &Engine::threads(), &half)?,
                None => {
                    let (to, step, ring) = (self.most, Some(self.step), self.ring.clone());
                    let branch = BranchOptions { to, step, max_points: 10_000, ..BranchOptions::default() };
                    let (center, bifurcations) = (Center::Bond, Some(true));
                    let main = Continue { center, bifurcations, branch, ring, ..Continue::default() };
                    main.follow()?(&Engine::threads(), &half)?.branch
                }
            };
            let half = part(progress, 0.5, 1.0);
            let (birth, branch) = match doubled_from(&main, self.omega_b, self.step, engine, &half) {
                Err(_) if interrupt::asked() => return branch_report(&main),
                doubled => doubled?,
            };
            let last = branch.points.last().map(|point| orbit_study(point.orbit.clone(), &self.ring.shooting()));
            let last = last.filter(|last| last.is_ok() || !interrupt::asked()).transpose()?;
            let study = DoubledStudy { birth, branch, last };
            let report = study.report()?;
            self.proving.added(report, proof::DOUBLED, "", &[], |times| match &study.last {
                Some(OrbitStudy { orbit, spectrum, shooting, .. }) => {
                    of_unstable(orbit, spectrum.largest_real(), shooting.tol, times)
                }
                None => Ok(None),
            })
        }))
    }
}

impl Kept for Continuation {
    type About = ();
    type Source = Setting;
    const NAMES: [&'static str; 3] = ["branch.npz", "spectra.store", "breather continue"];
    const FILES: &'static str = files_of_branch!("branch.npz", "spectra.store", "");
    /// Multipliers take longer than the orbits.
    const USUAL: AnalysisLevel = AnalysisLevel::Orbits;

    fn source((): &(), branch: &Branch) -> (Setting, Vec<Array<'static>>) {
        (branch.source(), branch.values())
    }

    fn made(setting: Setting, _birth: Option<BifurcationKind>) -> Result<((), Setting)> {
        setting.checked().map(|()| ((), setting))
    }

    fn outline() -> Report {
        report::outline()
    }

    fn report(study: &BranchStudy<Self>) -> Result<Report> {
        branch_report(&study.branch)
    }
}

/// An orbit with its multipliers and measurements.
#[derive(Clone, Debug)]
pub struct OrbitStudy {
    /// The orbit.
    pub orbit: Orbit,
    /// Its multipliers.
    pub spectrum: Spectrum,
    /// Centres and amplitudes of the first bond.
    pub extent: Extent,
    /// `E_b(T)`, the relative error of periodicity (eq:relerr).
    pub e_b: f64,
    /// Mean contact force of every bond over a period, constant along the chain (Theorem nobreath).
    pub forces: MeanForces,
    /// Settings of the search for the orbit; its tolerance is also that of the measurements.
    pub shooting: Shooting,
}

/// Computes the multipliers and all measurements of an orbit.
///
/// # Errors
/// An integration that fails.
pub fn orbit_study(orbit: Orbit, shooting: &Shooting) -> Result<OrbitStudy> {
    let (chain, period) = (orbit.setting.chain()?, orbit.setting.period());
    Ok(OrbitStudy {
        spectrum: orbit.spectrum(shooting)?,
        extent: orbit.extent(shooting.tol)?,
        e_b: orbit.e_b(shooting.tol, 1)?,
        forces: chain.mean_contact_forces(&orbit.start(), period, StepControl::Tolerance(shooting.tol))?,
        shooting: *shooting,
        orbit,
    })
}

/// Refuses a final value at which there are no dark breathers: without a precompression their
/// frequency is above `omega`.
fn stays_dark(setting: &Setting, continuation: &Continuation) -> Result<()> {
    let last = setting.with(continuation.parameter, continuation.to);
    let dark = last.c_x < 0.0 || f64::from(last.turns) * last.omega_b > last.params.omega();
    let rule =
        "a branch of dark breathers ends where they vanish: omega_b > omega = sqrt(kappa (1 + 1/rho)) up to its end";
    require(dark, "to", continuation.to, rule)
}

/// Continues a branch, unless it has ended, keeps it in the folder of the engine meanwhile, and
/// computes what is asked for about it.
///
/// # Errors
/// Numbers outside their rules.
pub fn go_on(branch: Branch, engine: &Engine, progress: Progress<'_>) -> Result<Branch> {
    if branch.end.is_none() {
        stays_dark(&branch.setting, &branch.continuation)?;
    }
    branches::followed((&(), None), branch, false, engine, progress)
}

/// Computes what is asked for about a branch that was followed.
///
/// # Errors
/// As [`Engine::sweep`].
pub fn study(branch: Branch, engine: &Engine, progress: Progress<'_>) -> Result<Branch> {
    branches::analysed(&(), branch, false, engine, progress)
}

/// Distance of the first orbit of doubled period from the period doubling, along the mode that
/// grows there, in units of the largest strain. Below 0.005 Newton's method falls back on the main
/// branch.
const FIRST_SIZE: f64 = 0.02;

/// Leaves a main branch at its first period doubling, and follows the branch of doubled period to
/// `omega_b` (that of the whole period): the period doubling, and the branch. Bifurcations of the
/// branch of doubled period are not located: the background of its orbits is unstable, and has
/// bands full of collisions.
///
/// # Errors
/// No period doubling on the main branch, or numbers outside their rules.
pub fn doubled_from(
    main: &Branch,
    omega_b: f64,
    step: f64,
    engine: &Engine,
    progress: Progress<'_>,
) -> Result<(Bifurcation, Branch)> {
    let rule = "only bond-centred breathers double their period: a site-centred one is the square of half its period";
    require(main.setting.about != Some(Center::Site), "center", "site", rule)?;
    let main_branch = main.points.iter().all(|point| point.orbit.setting.turns == 1);
    require(main_branch, "turns", 2, "the main branch has one turn a period: this one is doubled")?;
    let Continuation { to, ref shooting, .. } = main.continuation;
    let name = main.continuation.parameter.name();
    require(name == Parameter::OmegaB.name(), "branch", format!("one in {name}"), "a main branch in omega_b")?;
    let birth = main.bifurcations.iter().find(|one| one.kind == BifurcationKind::PeriodDoubling).cloned();
    let rule = "the main branch has no period doubling up to there";
    let birth = birth.ok_or_else(|| Error::parameter("most", to, rule))?;
    let rule =
        "the branch of doubled period goes up from half the frequency of the period doubling, 1.0316 at rho = 1/3";
    require(omega_b > birth.orbit.setting.omega_b / 2.0, "omega-b", omega_b, rule)?;
    let continuation =
        Continuation { parameter: Parameter::OmegaB, to: omega_b, step: 0.5 * step, ..main.continuation };
    let start = birth.doubled(shooting, FIRST_SIZE)?;
    let branch = Branch::new(continuation, start.setting, start)?;
    Ok((birth, go_on(branch, engine, progress)?))
}
