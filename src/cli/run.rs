//! `hertzchain run`.

use super::{DONE, Exit, args::RunArgs, print, progress_bar, runner::Runs, say};
use crate::{
    error::{Error, Result, require},
    interrupt::Token,
    number::format_short,
    output::{Folder, to_json},
    run::{Method, Records, Trajectory},
    scene::Scene,
    study::{self, Condition, LongRun, MethodChoice, RunView, Signals, orbits::branches::folder_of},
};
use hertzchain_integrators::Error as Failure;
use indicatif::ProgressBar;
use std::{path::Path, time::Instant};

const NO_EVENTS: &str = "this run was begun without --events: its first contacts are not known";
const SEARCHED: &str = "crossings: looked for at 32 times in a period of the fastest motion";

/// Sites times periods of the fastest motion below which no run takes a minute.
const FEW: f64 = 1e6;
/// Seconds of the trial of a run that a hundredth of it shows to be long, and of runs that are told
/// before their first step; also from one line on their progress to the next.
const TRIAL: f64 = 0.3;
const LONG: f64 = 60.0;

impl Runs for RunArgs {
    fn run(&self) -> Exit {
        if let Some(path) = &self.resume {
            return resume(self, path);
        }
        let mut changes = self.set.set.clone();
        changes.extend(self.samples.map(|samples| format!("record.samples={samples}")));
        let name = self.scene.as_deref().unwrap_or_default();
        let mut scene = Scene::load_with(name, &changes)?;
        if let Some(until) = self.until {
            scene = scene.until_in_file(until)?;
        }
        let how = MethodChoice::new(&self.method, &scene)?;
        let (name, wording) = how.words();
        let reason = how.reason().map(str::to_owned);
        let reason = reason.as_deref();
        let say_why = || {
            if reason.is_some() && !self.json {
                let setting = wording.replacen("tol ", "tolerance ", 1);
                say(&format!("method: {name} ({setting}); --integrator chooses another"));
            }
        };
        let conditions = conditions(self, &scene)?;
        conditions.iter().try_for_each(|one| one.found_by(&how))?;
        if self.plan {
            // `MethodChoice::plan` refuses what a run would refuse.
            let mut plan = how.plan(&scene, self.events, self.threads)?;
            plan.extend((!conditions.is_empty()).then(|| SEARCHED.to_owned()));
            let text = if self.json {
                to_json(&serde_json::json!({"scene": scene.name(), "integrator": name, "reason": reason, "plan": plan}))
                    + "\n"
            } else {
                format!("{}, {name}, {wording}\n  {}\n", scene.name(), plan.join("\n  "))
            };
            say_why();
            return print(&text).map(|()| DONE);
        }
        how.takes(&scene, self.threads)?;
        forecast(&scene, &how).iter().for_each(|words| say(words));
        if let Some(interval) = self.checkpoint {
            let long = how.in_legs(scene, self.events, interval, self.threads)?;
            let folder = Folder::own(self.out.as_deref().unwrap_or(".".as_ref()), None)?;
            say_why();
            return go_on(self, long, &folder);
        }
        let kept = if self.out.is_some() && scene.selection().is_none() { Records::Profiles } else { Records::Energy };
        let run = scene.observed_run(kept)?.threads(self.threads);
        let again = self.amplification.then(|| how.integrated(run.clone())).transpose()?;
        let folder = self.out.as_ref().map(|out| Folder::own(out, None)).transpose()?;
        say_why();
        let mut signals = Signals::new(&scene);
        let bar = progress_bar();
        let run = if self.events { run.contacts() } else { run };
        let run = study::with_conditions(run, &conditions, |_, _| false);
        let mut progress = progress(&bar, scene.end());
        let mut seen = |t: f64, y: &[f64]| {
            progress(t);
            signals.iter_mut().for_each(|signals| signals.take(&scene, t, y));
        };
        let outcome = how.observe(run, &mut seen, &mut |_| ());
        bar.finish_and_clear();
        let outcome = outcome?;
        let again = again.filter(|_| outcome.failure.is_none());
        // The results of the run count, also if the second run fails.
        let unknown = |why: &Error| say(&format!("amplification unknown: {why}"));
        let amplification = again.and_then(|run| run.amplification(&outcome.state).inspect_err(unknown).ok());
        report(self, &scene, (&name, &wording, reason), (outcome, amplification, signals, &conditions), folder.as_ref())
    }
}

/// Of a run that takes more than a minute: its steps and how long it takes, from a short trial.
fn forecast(scene: &Scene, how: &MethodChoice) -> Option<String> {
    let run = how.integrated(scene.run()).ok()?.records(Records::End);
    if scene.length() / scene.fast_period() * (scene.chain().sites() as f64) < FEW {
        return None;
    }
    let trial = |seconds: f64| {
        let clock = Instant::now();
        let trial = Token::timed(seconds).within(|| run.start()).ok()?;
        let share = (trial.t - scene.start_time()) / scene.length();
        let stopped = matches!(trial.failure?.cause, Failure::Stopped { .. });
        stopped.then(|| [clock.elapsed().as_secs_f64() / share, trial.stats.steps as f64 / share])
    };
    let [seconds, steps] = trial(0.01 * TRIAL).filter(|all| all[0] >= 0.5 * LONG).and_then(|_| trial(TRIAL))?;
    let units = [("years", 365.25 * 86_400.0), ("days", 86_400.0), ("hours", 3600.0), ("minutes", 60.0)];
    let (unit, size) = units.into_iter().find(|(_, size)| seconds >= 1.5 * size).unwrap_or(units[3]);
    let words = || {
        let what =
            if run.choice().is_ok_and(|(method, _)| method == Method::Collocation) { "windows" } else { "steps" };
        format!("this run makes about {steps:.1e} {what} and takes about {} {unit}", format_short(seconds / size))
    };
    (LONG..f64::INFINITY).contains(&seconds).then(words)
}

/// Shows the progress of a run up to `end`: by the bar or, where there is no terminal, by a line in
/// a minute.
fn progress(bar: &ProgressBar, end: f64) -> impl FnMut(f64) + '_ {
    let mut told = Instant::now();
    move |t| {
        bar.set_position((1000.0 * t / end) as u64);
        if bar.is_hidden() && told.elapsed().as_secs_f64() >= LONG {
            told = Instant::now();
            say(&format!("{:.1} % of the time span", 100.0 * t / end));
        }
    }
}

/// What the run looks for.
fn conditions(args: &RunArgs, scene: &Scene) -> Result<Vec<Condition>> {
    let read = |text, ends| Condition::read(text, scene, scene.chain().touching().start, ends);
    let crossings = args.crossings.iter().map(|text| read(text, false));
    crossings.chain(args.stop.iter().map(|text| read(text, true))).collect()
}

/// Prints and writes the results of a run, also of one that failed.
fn report(
    args: &RunArgs,
    scene: &Scene,
    (name, wording, reason): (&str, &str, Option<&str>),
    (outcome, amplification, signals, conditions): (Trajectory, Option<f64>, Option<Signals>, &[Condition]),
    folder: Option<&Folder>,
) -> Exit {
    let units = args.results.of(scene);
    let (si, setting) = (units.as_ref(), wording);
    let outcome = study::in_units(outcome, scene.chain().layout(), si);
    let signals = signals.map(|signals| signals.reported(&outcome, si));
    let (integrator, signals, outcome, files) = (name, signals.as_ref(), &outcome, &[]);
    let ran = RunView { scene, integrator, setting, reason, outcome, amplification, si, signals, conditions, files };
    // JSON has the whole state. For a long chain it takes more memory than the run, so it is made
    // only if it is asked for.
    let text = if args.json { to_json(&ran) + "\n" } else { study::run_summary(&ran) };
    // Files are written even if printing fails, and results are printed before a file can fail.
    let printed = print(&text);
    if let Some(folder) = folder {
        let in_legs = args.checkpoint.is_some() || args.resume.is_some();
        let pictures = study::run_pictures(&ran).drawn().and_then(|all| args.formats.files(&all));
        study::run_files(folder, &ran, pictures.as_deref().unwrap_or_default(), in_legs)?;
        match pictures {
            // The error of the command is the failure of the run, not that there is too little to
            // draw.
            Err(why) if outcome.failure.is_some() => say(&format!("no pictures: {why}")),
            Err(why) => return Err(why),
            Ok(_) => {}
        }
        say(&format!("written to {}", folder.path().display()));
    }
    let doubt = outcome.warnings.iter().find(|one| one.fatal()).cloned().map(Error::from);
    outcome.failure.clone().map(Error::from).or(doubt).map_or(printed, Err).map(|()| DONE)
}

fn resume(args: &RunArgs, path: &Path) -> Exit {
    // Before a folder is made or locked for a checkpoint that is not there.
    std::fs::metadata(path).map_err(|source| Error::File { path: path.to_owned(), source })?;
    let folder = Folder::own(folder_of(path), None)?;
    let long = LongRun::load(path, args.threads)?;
    let scene = args.scene.as_deref().map(Scene::load).transpose()?;
    long.is(path, scene.as_ref(), args.method.integrator.as_deref().map(Method::named).transpose()?)?;
    require(!args.events || long.has_contacts(), "events", true, NO_EVENTS)?;
    go_on(args, long, &folder)
}

/// Runs the remaining legs of a run, and reports its results.
fn go_on(args: &RunArgs, long: LongRun, folder: &Folder) -> Exit {
    // Results of an earlier run must not stand beside a new checkpoint.
    folder.remove(study::RUN_FILES.split(' '))?;
    let (scene, name, wording) = (long.scene().clone(), long.method().name(), long.wording().to_owned());
    let bar = progress_bar();
    let outcome = long.run(folder, &mut progress(&bar, scene.end()));
    bar.finish_and_clear();
    let mut outcome = outcome?;
    let signals = Signals::of(&scene, &outcome.profiles);
    if signals.is_some() {
        outcome.profiles.clear();
    }
    report(args, &scene, (&name, &wording, None), (outcome, None, signals, &[]), Some(folder))
}
