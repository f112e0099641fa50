//! `hertzchain run`.

use super::{DONE, Exit, args::RunArgs, print, progress_bar, say, signals};
use crate::{
    breathers::{self, TrivialBreather},
    error::{Error, Result},
    output::{Folder, to_json},
    run::{Method, Records, Regime, Setting, Trajectory, method::NO_TOLERANCE, regime},
    scene::Scene,
    study::{self, LongRun, folder_of},
};
use std::path::Path;

const DEFAULT_STEPS_PER_PERIOD: f64 = 512.0;
const DEFAULT_TOLERANCE: f64 = 1e-10;
const DEFAULT_NODES: usize = 10;
/// More steps than a run of years takes.
const MOST_STEPS: f64 = 1e15;
const NO_EVENTS: &str = "this run was begun without --events: its first contacts are not known";

pub(super) fn main(args: &RunArgs) -> Exit {
    if let Some(path) = &args.resume {
        return resume(args, path);
    }
    let mut changes = args.set.set.clone();
    changes.extend(args.samples.map(|samples| format!("record.samples={samples}")));
    let mut scene = Scene::load_with(args.scene.as_deref().unwrap_or_default(), &changes)?;
    if let Some(until) = args.until {
        scene = scene.until(until)?;
    }
    let how = How::new(args, &scene)?;
    let (name, wording) = how.words();
    let reason = how.reason().map(str::to_owned);
    let reason = reason.as_deref();
    let say_why = || reason.filter(|_| !args.json).iter().for_each(|why| say(&format!("{name}, {wording}: {why}")));
    if args.plan {
        // What a run refuses is not planned.
        let plan = how.plan(&scene, args.events)?;
        let text = if args.json {
            to_json(&serde_json::json!({"scene": scene.name(), "integrator": name, "reason": reason, "plan": plan}))
                + "\n"
        } else {
            format!("{}, {name}, {wording}\n  {}\n", scene.name(), plan.join("\n  "))
        };
        say_why();
        return print(&text).map(|()| DONE);
    }
    if let Some(interval) = args.checkpoint {
        let long = how.in_legs(scene, args.events, interval)?;
        let folder = Folder::create(args.out.as_deref().unwrap_or(".".as_ref()))?;
        say_why();
        return go_on(args, long, &folder);
    }
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    say_why();
    signals::ask()?;
    let records = if folder.is_some() { Records::Profiles } else { Records::Energy };
    let bar = progress_bar();
    let mut progress = |t| bar.set_position((1000.0 * t / scene.end()) as u64);
    let outcome = how.run(&scene, args.events, records, &mut progress);
    bar.finish_and_clear();
    report(args, &scene, (&name, &wording, reason), outcome?, folder.as_ref())
}

/// Prints and writes what a run has left behind, also one that failed.
fn report(
    args: &RunArgs,
    scene: &Scene,
    (name, wording, reason): (&str, &str, Option<&str>),
    outcome: Trajectory,
    folder: Option<&Folder>,
) -> Exit {
    let json = study::run_json(scene, name, wording, reason, &outcome);
    let text = if args.json { to_json(&json) + "\n" } else { study::run_summary(scene, name, wording, &outcome) };
    // Of results that cannot be printed the files are written, and of files that cannot be written
    // the results are printed.
    let printed = print(&text);
    if let Some(folder) = folder {
        let in_legs = args.checkpoint.is_some() || args.resume.is_some();
        #[cfg(feature = "plot")]
        let pictures = study::run_pictures(scene, name, wording, &outcome);
        #[cfg(not(feature = "plot"))]
        let pictures: Result<Vec<_>> = Ok(Vec::new());
        study::run_files(folder, scene, &outcome, &json, pictures.as_deref().unwrap_or_default(), in_legs)?;
        match pictures {
            // What stopped the run is the error, not that there is too little of it to draw.
            Err(why) if outcome.failure.is_some() => say(&format!("no pictures: {why}")),
            Err(why) => return Err(why),
            Ok(_) => {}
        }
        say(&format!("written to {}", folder.path().display()));
    }
    outcome.failure.map_or(printed, |failure| Err(failure.into())).map(|()| DONE)
}

/// Goes on from a checkpoint.
fn resume(args: &RunArgs, path: &Path) -> Exit {
    let long = LongRun::load(path)?;
    let scene = args.scene.as_deref().map(Scene::load).transpose()?;
    long.is(path, scene.as_ref(), args.integrator.as_deref().map(Method::named).transpose()?)?;
    if args.events && !long.has_contacts() {
        return Err(Error::parameter("events", true, NO_EVENTS));
    }
    go_on(args, long, &Folder::create(folder_of(path))?)
}

/// Runs what is left of a run in legs.
fn go_on(args: &RunArgs, long: LongRun, folder: &Folder) -> Exit {
    // Before the first new checkpoint is beside them.
    folder.remove(study::RUN_FILES)?;
    signals::ask()?;
    let (scene, name, wording) = (long.scene().clone(), long.method().name(), long.wording().to_owned());
    let bar = progress_bar();
    let outcome = long.run(folder, &mut |t| bar.set_position((1000.0 * t / scene.end()) as u64));
    bar.finish_and_clear();
    report(args, &scene, (&name, &wording, None), outcome?, Some(folder))
}

/// How a scene runs.
enum How {
    /// By an integrator, with the setting in words, and why it is this one where nobody asked for
    /// it.
    Integrated(Method, Setting, String, Option<String>),
    /// By its exact solution.
    ClosedForm(TrivialBreather),
}

impl How {
    /// An integrator where one is named or a flag asks for its accuracy; else the exact solution,
    /// if one is known, else what the regime asks for.
    fn new(args: &RunArgs, scene: &Scene) -> Result<Self> {
        // A tolerance asks for the method that keeps it best.
        let adaptive = args.tol.is_some() || args.windows_per_period.is_some();
        let asked = args.integrator.is_some() || adaptive || args.step.is_some() || args.steps_per_period.is_some();
        if let (Some((method, setting)), false) = (scene.choice(), asked) {
            let wording = in_words(scene, setting);
            return Ok(Self::Integrated(method, setting, wording, Some("the scene names it".to_owned())));
        }
        if let (Some(exact), false) = (scene.exact(), asked) {
            return Ok(Self::ClosedForm(exact.clone()));
        }
        if !asked {
            let Regime { method, setting, wording, reason } = regime(&scene.run())?;
            return Ok(Self::Integrated(method, setting, wording, Some(reason)));
        }
        let default = if adaptive { "collocation" } else { "strang-linear" };
        let method = Method::named(args.integrator.as_deref().unwrap_or(default))?;
        let (setting, wording) = setting(args, method, scene)?;
        Ok(Self::Integrated(method, setting, wording, None))
    }

    /// Name and setting.
    fn words(&self) -> (String, String) {
        match self {
            Self::Integrated(method, _, wording, _) => (method.name(), wording.clone()),
            Self::ClosedForm(_) => ("closed-form".to_owned(), "exact solution (uncpl), no integrator".to_owned()),
        }
    }

    /// Why an integrator that nobody named was chosen.
    fn reason(&self) -> Option<&str> {
        match self {
            Self::Integrated(.., reason) => reason.as_deref(),
            Self::ClosedForm(_) => None,
        }
    }

    /// The same in legs that are kept.
    fn in_legs(self, scene: Scene, events: bool, interval: f64) -> Result<LongRun> {
        match self {
            Self::Integrated(method, setting, wording, _) => {
                let wording = format!("{wording}, in legs of {interval}");
                let long = LongRun::new(scene, method, setting, wording, interval)?;
                Ok(if events { long.with_contacts() } else { long })
            }
            Self::ClosedForm(_) => {
                let rule =
                    "an exact solution is evaluated at once and needs none: name an --integrator to run it in legs";
                Err(Error::parameter("checkpoint", interval, rule))
            }
        }
    }

    fn plan(&self, scene: &Scene, events: bool) -> Result<Vec<String>> {
        match self {
            Self::Integrated(method, setting, ..) => {
                scene.run().method(*method).setting(*setting).stepper()?;
                Ok(scene.plan(events))
            }
            Self::ClosedForm(_) => Ok(scene.plan_in_closed_form()),
        }
    }

    fn run(&self, scene: &Scene, events: bool, records: Records, progress: &mut dyn FnMut(f64)) -> Result<Trajectory> {
        match self {
            Self::Integrated(method, setting, ..) => {
                let run = scene.run().method(*method).setting(*setting).records(records);
                if events { run.contacts() } else { run }.start_with(progress)
            }
            Self::ClosedForm(exact) => {
                let run = scene.run().records(records);
                let run = if events { run.contacts() } else { run };
                run.start_by(&mut breathers::ClosedForm::new(exact, scene.end()), progress)
            }
        }
    }
}

/// What the flags mean for this method on this scene, and in words.
fn setting(args: &RunArgs, method: Method, scene: &Scene) -> Result<(Setting, String)> {
    let positive = |name, value: f64| {
        let good = value.is_finite() && value > 0.0;
        if good { Ok(value) } else { Err(Error::parameter(name, value, "finite and positive")) }
    };
    if let Some(per_period) = args.windows_per_period {
        if method != Method::Collocation {
            return Err(Error::parameter("windows-per-period", per_period, "only collocation takes windows"));
        }
        let nodes = args.nodes.unwrap_or(DEFAULT_NODES);
        let windows = (scene.end() / scene.period() * positive("windows-per-period", per_period)?).ceil().max(1.0);
        if windows > MOST_STEPS {
            return Err(Error::parameter("windows", windows, "at most 1e15 windows"));
        }
        let setting = Setting::Windows(windows as u64, nodes);
        return Ok((setting, in_words(scene, setting)));
    }
    if method.adaptive() || method.tolerant() && args.tol.is_some() {
        if let Some(value) = args.step.or(args.steps_per_period) {
            return Err(Error::parameter("step", value, "an adaptive method chooses its steps: give it --tol"));
        }
        let tol = positive("tol", args.tol.unwrap_or(DEFAULT_TOLERANCE))?;
        return Ok((Setting::Tolerance(tol), in_words(scene, Setting::Tolerance(tol))));
    }
    if let Some(tol) = args.tol {
        return Err(Error::parameter("tol", tol, NO_TOLERANCE));
    }
    let steps = match args.step {
        Some(step) => scene.end() / positive("step", step)?,
        None => {
            let per_period = args.steps_per_period.unwrap_or(DEFAULT_STEPS_PER_PERIOD);
            scene.end() / scene.period() * positive("steps-per-period", per_period)?
        }
    };
    let setting = Setting::steps(steps)?;
    Ok((setting, in_words(scene, setting)))
}

fn in_words(scene: &Scene, setting: Setting) -> String {
    let (end, period) = (scene.end(), scene.period());
    let per_period = |count: u64| count as f64 * period / end;
    match setting {
        Setting::Tolerance(tol) => format!("tol {tol:e}"),
        Setting::Steps(steps) => {
            format!("{steps} steps of {:e} ({:.6} a period)", end / steps as f64, per_period(steps))
        }
        Setting::Windows(windows, nodes) => {
            format!("{windows} windows ({:.6} a period), {nodes} nodes", per_period(windows))
        }
    }
}
