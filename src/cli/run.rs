//! `hertzchain run`.

use super::{Exit, args::RunArgs, print, progress_bar};
use crate::{
    error::{Error, Result},
    experiments::{Outcome, Records, Regime, regime, run, run_in_closed_form, run_with_contacts},
    method::{Method, Setting},
    output::{Folder, to_json},
    report,
    scene::Scene,
};
use std::process::ExitCode;

const DEFAULT_STEPS_PER_PERIOD: f64 = 512.0;
const DEFAULT_TOLERANCE: f64 = 1e-10;
const DEFAULT_NODES: usize = 10;
/// More steps than a run of years takes.
const MOST_STEPS: f64 = 1e15;

pub(super) fn main(args: &RunArgs) -> Exit {
    let mut scene = Scene::load(&args.scene)?;
    if let Some(until) = args.until {
        scene = scene.until(until)?;
    }
    let how = How::new(args, &scene)?;
    let (name, wording) = how.words();
    let reason = how.reason();
    let say = || reason.filter(|_| !args.json).iter().for_each(|why| eprintln!("{name}, {wording}: {why}"));
    if args.plan {
        // What a run refuses is not planned.
        let plan = how.plan(&scene, args.events)?;
        let text = if args.json {
            to_json(&serde_json::json!({"scene": scene.name(), "integrator": name, "reason": reason, "plan": plan}))
                + "\n"
        } else {
            format!("{}, {name}, {wording}\n  {}\n", scene.name(), plan.join("\n  "))
        };
        say();
        print(&text);
        return Ok(ExitCode::SUCCESS);
    }
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    say();
    let records = if folder.is_some() { Records::Profiles } else { Records::Energy };
    let bar = progress_bar();
    let mut progress = |t| bar.set_position((1000.0 * t / scene.end()) as u64);
    let outcome = how.run(&scene, args.events, records, &mut progress);
    bar.finish_and_clear();
    let outcome = outcome?;
    let json = report::run_json(&scene, &name, &wording, reason, &outcome);
    print(&if args.json { json.clone() + "\n" } else { report::run_summary(&scene, &name, &wording, &outcome) });
    if let Some(folder) = folder {
        report::run_files(&folder, &scene, &outcome, &json)?;
        #[cfg(feature = "plot")]
        for (file, png) in report::run_pictures(&scene, &name, &wording, &outcome)? {
            folder.write(file, &png)?;
        }
        eprintln!("written to {}", folder.path().display());
    }
    outcome.failure.map_or(Ok(ExitCode::SUCCESS), |failure| Err(failure.into()))
}

/// How a scene runs.
enum How {
    /// By an integrator, with the setting in words, and why it is this one where nobody asked for it.
    Integrated(Method, Setting, String, Option<String>),
    /// By its exact solution.
    ClosedForm,
}

impl How {
    /// An integrator where one is named or a flag asks for its accuracy; else the exact solution, if one is known, else what the regime asks for.
    fn new(args: &RunArgs, scene: &Scene) -> Result<Self> {
        // A tolerance asks for the method that keeps it best.
        let adaptive = args.tol.is_some() || args.windows_per_period.is_some();
        let asked = args.integrator.is_some() || adaptive || args.step.is_some() || args.steps_per_period.is_some();
        if scene.exact().is_some() && !asked {
            return Ok(Self::ClosedForm);
        }
        if !asked {
            let Regime { method, setting, wording, reason } = regime(scene);
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
            Self::ClosedForm => ("closed-form".to_owned(), "exact solution (uncpl), no integrator".to_owned()),
        }
    }

    /// Why an integrator that nobody named was chosen.
    fn reason(&self) -> Option<&str> {
        match self {
            Self::Integrated(.., reason) => reason.as_deref(),
            Self::ClosedForm => None,
        }
    }

    fn plan(&self, scene: &Scene, events: bool) -> Result<Vec<String>> {
        match self {
            Self::Integrated(method, setting, ..) => {
                method.start(scene, *setting)?;
                Ok(scene.plan(events))
            }
            Self::ClosedForm => Ok(scene.plan_in_closed_form()),
        }
    }

    fn run(&self, scene: &Scene, events: bool, records: Records, progress: &mut dyn FnMut(f64)) -> Result<Outcome> {
        match self {
            Self::Integrated(method, setting, ..) => {
                let run = if events { run_with_contacts } else { run };
                run(scene, *method, *setting, records, progress)
            }
            Self::ClosedForm => {
                let outcome = run_in_closed_form(scene, records, progress)?;
                Ok(Outcome { contacts: events.then(Vec::new), ..outcome })
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
        let words =
            format!("{windows} windows ({:.6} a period), {nodes} nodes", windows * scene.period() / scene.end());
        return Ok((Setting::Windows(windows as u64, nodes), words));
    }
    if method.adaptive() {
        if let Some(value) = args.step.or(args.steps_per_period) {
            return Err(Error::parameter("step", value, "an adaptive method chooses its steps: give it --tol"));
        }
        let tol = positive("tol", args.tol.unwrap_or(DEFAULT_TOLERANCE))?;
        return Ok((Setting::Tolerance(tol), format!("tol {tol:e}")));
    }
    if let Some(tol) = args.tol {
        return Err(Error::parameter("tol", tol, "splitting schemes take --steps-per-period or --step"));
    }
    let steps = match args.step {
        Some(step) => scene.end() / positive("step", step)?,
        None => {
            let per_period = args.steps_per_period.unwrap_or(DEFAULT_STEPS_PER_PERIOD);
            scene.end() / scene.period() * positive("steps-per-period", per_period)?
        }
    };
    // A step that fits but for rounding is taken as it is.
    let steps = (steps * (1.0 - 1e-12)).ceil().max(1.0);
    if steps > MOST_STEPS {
        return Err(Error::parameter("steps", steps, "at most 1e15 steps"));
    }
    let words =
        format!("{} steps of {:e} ({:.6} a period)", steps, scene.end() / steps, steps * scene.period() / scene.end());
    Ok((Setting::Steps(steps as u64), words))
}
