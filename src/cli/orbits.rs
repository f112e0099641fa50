//! `hertzchain breather dark`, `breather continue`, `breather doubled` and `breather evolve`.

use super::{
    Exit,
    args::{ContinueArgs, DarkBreatherArgs, DoubledArgs, EvolveArgs, RingArgs},
    print, progress_bar, signals,
};
use crate::{
    breathers::DarkBreather,
    chain::Params,
    dps::Center,
    error::{Error, Result},
    experiments::{self, Branch, Kick, orbit_study},
    interrupt,
    orbits::{Continuation, End, Orbit, Parameter, Pick, Shooting, Trail},
    output::Folder,
    report,
};
use indicatif::ProgressBar;
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    time::{Duration, Instant},
};

/// Frequencies over `omega`, where none is given: a breather as in the paper, and the ends of a branch.
const ONE: f64 = 1.025;
const RANGE: [f64; 2] = [1.005, 1.05];

impl RingArgs {
    fn shooting(&self) -> Shooting {
        Shooting { formulation: self.formulation, tol: self.tol, ..Shooting::default() }
    }

    /// A breather of this frequency, by default `omega` times `ratio`.
    fn breather(&self, center: Center, omega_b: Option<f64>, ratio: f64) -> Result<DarkBreather> {
        let params = Params::new(self.alpha, self.kappa, self.rho)?;
        let omega_b = omega_b.unwrap_or(ratio * params.omega());
        Ok(DarkBreather { params, center, sites: self.sites, omega_b, c_x: self.c_x })
    }
}

pub(super) fn dark(args: &DarkBreatherArgs) -> Exit {
    let (breather, shooting) = (args.ring.breather(args.center, args.omega_b, ONE)?, args.ring.shooting());
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let study = orbit_study(breather.orbit(&shooting)?, &shooting)?;
    let json = report::dark_breather_json(&breather, &study) + "\n";
    print(&if args.json { json.clone() } else { report::dark_breather_table(&breather, &study) });
    if let Some(folder) = folder {
        folder.write("dark-breather.json", json.as_bytes())?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}

pub(super) fn branch(args: &ContinueArgs) -> Exit {
    let beside = args.resume.as_deref().map(|path| if path.is_dir() { path.to_owned() } else { folder_of(path) });
    let trail = match &args.resume {
        Some(file) => Trail::load(&kept(file, "branch.npz"))?.onward(args.to, args.step, args.points)?,
        None => begin(args)?,
    };
    let folder = args.out.clone().or(beside).map(Folder::create).transpose()?;
    signals::ask()?;
    let branch = with_bar(|progress| experiments::go_on(trail, &mut keeper(folder.as_ref()), progress))?;
    let json = report::branch_json(&branch) + "\n";
    print(&if args.json { json.clone() } else { report::branch_table(&branch) });
    write(folder, &branch, &json)?;
    Ok(code(&branch))
}

/// The branch that is asked for, at its first point.
fn begin(args: &ContinueArgs) -> Result<Trail> {
    let Some(&(_, parameter)) = Parameter::ALL.iter().find(|(name, _)| *name == args.parameter) else {
        return Err(Error::unknown("parameter", &args.parameter, Parameter::ALL.map(|(name, _)| name)));
    };
    let mut breather = args.ring.breather(args.center, args.omega_b, ONE)?;
    let varies = parameter == Parameter::OmegaB;
    if varies && args.omega_b.is_some() {
        let rule = "it is the parameter that varies: give --from and --to";
        return Err(Error::parameter("omega-b", args.omega_b.unwrap_or_default(), rule));
    }
    let end = |given: Option<f64>, ratio: f64, name: &'static str| match given {
        Some(value) => Ok(value),
        None if varies => Ok(ratio * breather.params.omega()),
        None => Err(Error::parameter(name, "nothing", "a parameter other than omega_b needs --from and --to")),
    };
    let (from, to) = (end(args.from, RANGE[0], "from")?, end(args.to, RANGE[1], "to")?);
    breather.set(parameter, from);
    let continuation = Continuation {
        parameter,
        to,
        step: args.step.unwrap_or(0.01 * (to - from).abs()),
        most_points: args.points,
        natural: args.natural,
        shooting: args.ring.shooting(),
    };
    experiments::begin(&breather, &continuation, args.weak)
}

pub(super) fn doubled(args: &DoubledArgs) -> Exit {
    let (breather, shooting) = (args.ring.breather(Center::Bond, None, RANGE[0])?, args.ring.shooting());
    let most = args.most.unwrap_or(RANGE[1] * breather.params.omega());
    // Before the main branch, which takes its time.
    for (name, value) in args.most.map(|most| ("most", most)).into_iter().chain([("omega-b", args.omega_b)]) {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::parameter(name, value, "a frequency is finite and positive"));
        }
    }
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let doubled = with_bar(|progress| {
        let half = |share: f64, what: &str| progress(0.5 * share, what);
        let main = match &args.branch {
            Some(file) => experiments::study(Trail::load(file)?, &half)?,
            None => experiments::main_branch(&breather, most, args.step, &shooting, &half)?,
        };
        let half = |share: f64, what: &str| progress(0.5 + 0.5 * share, what);
        experiments::doubled_from(&main, args.omega_b, args.step, &mut keeper(folder.as_ref()), &half)
    })?;
    let last = doubled.branch.points.last().map(|point| orbit_study(point.orbit.clone(), &shooting)).transpose()?;
    let json = report::doubled_json(&doubled, last.as_ref()) + "\n";
    print(&if args.json { json.clone() } else { report::doubled_table(&doubled, last.as_ref()) });
    write(folder, &doubled.branch, &json)?;
    Ok(code(&doubled.branch))
}

pub(super) fn evolve(args: &EvolveArgs) -> Exit {
    let shooting = Shooting { tol: args.tol, ..Shooting::default() };
    let pick = args.point.map(Pick::Point).or(args.at.map(Pick::At));
    let orbit = Orbit::load(&args.orbit, pick, &shooting)?;
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let kick = args.kick.map(|size| Kick { size, mode: args.mode });
    let study = with_bar(|progress| experiments::evolve(&orbit, args.until, kick, &shooting, progress))?;
    let json = report::evolution_json(&study) + "\n";
    print(&if args.json { json.clone() } else { report::evolution_table(&study) });
    if let Some(folder) = folder {
        folder.write("evolution.json", json.as_bytes())?;
        folder.write("evolution.csv", &report::evolution_csv(&study))?;
        for (name, table) in report::swing_csv(&study) {
            folder.write(&format!("evolution-{name}"), &table)?;
        }
        #[cfg(feature = "plot")]
        folder.write("evolution.png", &report::evolution_png(&study)?)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(if study.failure.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What there is of a branch is written, but one that did not get there is a failure.
fn code(branch: &Branch) -> ExitCode {
    if branch.end == End::Reached { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The file of this name in the folder `path`, or `path` itself where it is no folder.
fn kept(path: &Path, name: &str) -> PathBuf {
    if path.is_dir() { path.join(name) } else { path.to_owned() }
}

pub(super) fn folder_of(file: &Path) -> PathBuf {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned()
}

/// Writes `branch.npz` while a branch is followed: with every twentieth point, whenever 10 s have gone by, at its end, and when it is asked to end.
fn keeper(folder: Option<&Folder>) -> impl FnMut(&Trail) {
    let mut last = Instant::now();
    move |trail| {
        let Some(folder) = folder else { return };
        let late = last.elapsed() >= Duration::from_secs(10);
        if late || trail.orbits.len().is_multiple_of(20) || trail.end.is_some() || interrupt::asked() {
            last = Instant::now();
            let kept = trail.npz(Vec::new()).and_then(|bytes| folder.write("branch.npz", &bytes));
            // What cannot be kept now is still computed: it is written at the end, or that is the error.
            kept.err().into_iter().for_each(|why| eprintln!("not kept so far: {why}"));
        }
    }
}

fn write(folder: Option<Folder>, branch: &Branch, json: &str) -> Result<()> {
    let Some(folder) = folder else { return Ok(()) };
    folder.write("branch.json", json.as_bytes())?;
    folder.write("branch.csv", &report::branch_csv(branch))?;
    folder.write("branch.npz", &report::branch_npz(branch)?)?;
    eprintln!("written to {}", folder.path().display());
    Ok(())
}

fn with_bar<T>(work: impl FnOnce(experiments::Progress<'_>) -> Result<T>) -> Result<T> {
    let bar: ProgressBar = progress_bar();
    let result = work(&|share, what| {
        bar.set_position((1000.0 * share.min(1.0)) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    result
}
