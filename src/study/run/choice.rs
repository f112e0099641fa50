//! Which integrator runs a scene, and with which accuracy: what the user asked for, else what the
//! scene names, else what suits its chain.

use super::LongRun;
use crate::{
    breathers::{self, TrivialBreather},
    chain::Contact,
    error::{Error, Result, refuse, require},
    memory,
    run::{Method, Regime, Run, Setting, Trajectory, method::NO_TOLERANCE, regime},
    scene::{Quantity, Scene},
    study::{options::options, si::Scale},
};

/// Default number of steps in a period of the fastest motion.
const DEFAULT_STEPS_PER_PERIOD: f64 = 512.0;
const DEFAULT_TOLERANCE: f64 = 1e-10;
const DEFAULT_NODES: usize = 12;
/// Most windows of a run. Chosen: more than a run of years takes.
const MOST_STEPS: f64 = 1e15;
/// A plan starts the method if the run takes fewer bytes than this.
const MOST_PLANNED: u64 = 1 << 24;

/// The help of the tolerance of a run, in full.
#[cfg(feature = "cli")]
fn tolerance() -> String {
    use hertzchain_integrators::Tolerance;
    let Tolerance { least, most, .. } = Tolerance::RUN;
    let [corrected, crossed] = [Tolerance::CORRECTED, Tolerance::CROSSED].map(|kind| kind.rule);
    let more = "--amplification measures this factor. ";
    format!(
        "{} It is relative, and absolute in units of the size of the motion. Contact-corrected \
         splitting aims at an error of T of the state at the end, and determines its step by runs over the whole span \
         [default: 1e-10].\n\nFrom {least:e} to {most}; {corrected}; {crossed}.",
        crate::study::tolerance_help(more)
    )
}

options! {
    /// Integrator and accuracy that the user asks for. What is `None` follows from the others, from
    /// the scene, or from a default.
    #[derive(PartialEq)]
    pub struct MethodRequest {
        /// Integrator; `hertzchain integrators` lists all.
        ///
        /// By default collocation with --tol or --windows-per-period, strang-linear with steps.
        /// Without any of these: the method that the scene names; else the exact solution, where
        /// one is known; else what the regime asks for, which is collocation, or strang-linear
        /// where omega is above 10^4 times the frequency of contacts. Which one, and why, is
        /// printed on stderr.
        integrator: Option<String> = None, "NAME";
        /// Tolerance.
        tol: Option<f64> = None, "T", [long_help = tolerance()];
        /// Steps per period of the scene, for splitting schemes.
        ///
        /// By default 512 steps per period of the fastest motion: of resonators, drives or
        /// contacts.
        steps_per_period: Option<f64> = None, "N", (positive), [conflicts_with_all = ["step", "tol"]];
        /// Step size, in units of time, for splitting schemes.
        ///
        /// In seconds for scenes with `[units]`. Made smaller where a whole number of steps must
        /// fit the span.
        step: Option<f64> = None, "H", (positive), [conflicts_with = "tol"];
        /// Equal windows per period, for collocation without error control.
        windows_per_period: Option<f64> = None, "N", (positive), [conflicts_with_all = ["step", "tol", "steps_per_period"]];
        /// Nodes per panel: 4, 8 or 12 [default: 12].
        ///
        /// For collocation with --windows-per-period.
        nodes: Option<usize> = None, "M",
            [hide_short_help = true, requires = "windows_per_period", conflicts_with_all = ["step", "tol", "steps_per_period"]];
    }
}

/// How a scene is computed.
#[derive(Clone, Debug)]
pub enum MethodChoice {
    /// By an integrator: method, setting, the setting in words, and the reason for the choice, if
    /// the user asked for neither integrator nor accuracy.
    Integrated(Method, Setting, String, Option<String>),
    /// By its exact solution.
    ClosedForm(TrivialBreather),
}

impl MethodChoice {
    /// An integrator where one is named or a flag asks for its accuracy; else the exact solution,
    /// if one is known, else what the regime asks for.
    ///
    /// # Errors
    /// An unknown integrator; a setting that it does not take or that is outside its rule.
    pub fn new(args: &MethodRequest, scene: &Scene) -> Result<Self> {
        // A tolerance or windows without an integrator stand for [`Method::by_tolerance`].
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
        let method = match &args.integrator {
            Some(name) => Method::named(name)?,
            None if adaptive => Method::by_tolerance(scene.chain()),
            None => Method::named("strang-linear")?,
        };
        method.runs(scene.chain())?;
        let (setting, wording) = setting(args, method, scene)?;
        Ok(Self::Integrated(method, setting, wording, None))
    }

    /// Name of the integrator, and its setting in words.
    pub fn words(&self) -> (String, String) {
        match self {
            Self::Integrated(method, _, wording, _) => (method.name(), wording.clone()),
            Self::ClosedForm(_) => ("closed-form".to_owned(), "exact solution (uncpl), no integrator".to_owned()),
        }
    }

    /// The reason for the choice of an integrator, if the user asked for neither integrator nor
    /// accuracy.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Integrated(.., reason) => reason.as_deref(),
            Self::ClosedForm(_) => None,
        }
    }

    /// The run of a scene in legs of length `interval`, in seconds for a scene with `[units]`, with
    /// a checkpoint after each.
    ///
    /// # Errors
    /// A closed form, which needs no legs; what [`LongRun::new`] refuses.
    pub fn in_legs(self, scene: Scene, events: bool, interval: f64, threads: Option<usize>) -> Result<LongRun> {
        let rule = "an exact solution is evaluated at once and needs none: name an --integrator to run it in legs";
        let (method, setting, wording) = self.integrator("checkpoint", interval, rule)?;
        let (units, own) = (scene.units().copied(), scene.of_file(Quantity::Time, interval));
        let wording = format!("{wording}, in legs of {}", scene.in_words(own));
        let long = LongRun::new(scene, method, setting, wording, own, threads);
        let long = Scale(units.as_ref()).given(long, &[("checkpoint", Some(interval))])?;
        Ok(if events { long.with_contacts() } else { long })
    }

    /// What the run computes and what it leaves out, in words.
    ///
    /// # Errors
    /// What the run would refuse.
    pub fn plan(&self, scene: &Scene, events: bool, threads: Option<usize>) -> Result<Vec<String>> {
        match self {
            Self::Integrated(method, setting, ..) => {
                self.takes(scene, threads)?;
                let run = scene.run().method(*method).setting(*setting);
                let needed = Scene::least_memory(scene.chain());
                // Some methods choose their steps by runs, which would take long for a long chain.
                match setting {
                    _ if needed < MOST_PLANNED => drop(run.stepper()?),
                    Setting::Tolerance(tol) => drop(run.tolerance(*tol)?),
                    _ => {}
                }
                let words = format!("memory: at least {}, for three states", memory::bytes(needed));
                Ok(scene.plan(events).into_iter().chain([words]).collect())
            }
            Self::ClosedForm(_) => self.takes(scene, threads).map(|()| scene.plan_in_closed_form()),
        }
    }

    /// Refuses threads if the scene does not run on so many this way.
    ///
    /// # Errors
    /// Several threads for an exact solution; what [`Method::takes`] refuses.
    pub fn takes(&self, scene: &Scene, threads: Option<usize>) -> Result<()> {
        if matches!(self, Self::ClosedForm(_)) && threads.is_none_or(|count| count == 1) {
            return Ok(());
        }
        let rule =
            "an exact solution is evaluated on one thread: name a splitting scheme, as --integrator strang-linear";
        self.integrator("integrator", "closed-form", rule)?.0.takes(threads, scene.chain())
    }

    /// Computes `run`, a run of the scene, which says what is recorded, as [`Run::observe`] does.
    ///
    /// # Errors
    /// A run that cannot start. A run that fails later returns what it has recorded.
    pub fn observe(
        &self,
        run: Run,
        seen: &mut dyn FnMut(f64, &[f64]),
        told: &mut dyn FnMut(&Contact),
    ) -> Result<Trajectory> {
        match self {
            Self::Integrated(method, setting, ..) => run.method(*method).setting(*setting).observe(seen, told),
            Self::ClosedForm(exact) => run.observe_by(&mut breathers::ClosedForm::new(exact, run.end()?), seen),
        }
    }

    /// Refuses what only an integrator finds.
    ///
    /// # Errors
    /// An exact solution.
    pub fn logs(&self, name: &'static str, value: impl ToString) -> Result<()> {
        let rule = "an exact solution has no log and no steps: name an --integrator";
        self.integrator(name, value, rule).map(|_| ())
    }

    /// Method, setting, and the setting in words; an exact solution is refused by this rule.
    fn integrator(
        &self,
        name: &'static str,
        value: impl ToString,
        rule: &'static str,
    ) -> Result<(Method, Setting, &str)> {
        match self {
            Self::Integrated(method, setting, wording, _) => Ok((*method, *setting, wording)),
            Self::ClosedForm(_) => Err(Error::parameter(name, value, rule)),
        }
    }

    /// The run with its method and setting.
    ///
    /// # Errors
    /// An exact solution, in which no error grows.
    pub fn integrated(&self, run: Run) -> Result<Run> {
        let rule = "an exact solution is evaluated, and no error grows: name an --integrator";
        let (method, setting, _) = self.integrator("amplification", true, rule)?;
        Ok(run.method(method).setting(setting))
    }
}

/// The setting that `args` mean for a method on a scene, and the setting in words.
fn setting(args: &MethodRequest, method: Method, scene: &Scene) -> Result<(Setting, String)> {
    args.within_ranges()?;
    if let Some(per_period) = args.windows_per_period {
        require(method == Method::Collocation, "windows-per-period", per_period, "only collocation takes windows")?;
        let nodes = args.nodes.unwrap_or(DEFAULT_NODES);
        let windows = (scene.length() / scene.period() * per_period).ceil().max(1.0);
        require(windows <= MOST_STEPS, "windows", windows, "at most 1e15 windows")?;
        let setting = Setting::Windows(windows as u64, nodes);
        return Ok((setting, in_words(scene, setting)));
    }
    if method.adaptive() || method.tolerant() && args.tol.is_some() {
        let rule = "an adaptive method chooses its steps: give it --tol";
        refuse("step", args.step.or(args.steps_per_period), rule)?;
        let tol = method.tolerances().check(args.tol.unwrap_or(DEFAULT_TOLERANCE))?;
        return Ok((Setting::Tolerance(tol), in_words(scene, Setting::Tolerance(tol))));
    }
    refuse("tol", args.tol, NO_TOLERANCE)?;
    let steps = match args.step {
        Some(step) => scene.length() / scene.of_file(Quantity::Time, step),
        None => match args.steps_per_period {
            Some(per_period) => scene.length() / scene.period() * per_period,
            None => scene.length() / scene.fast_period() * DEFAULT_STEPS_PER_PERIOD,
        },
    };
    let setting = Setting::steps(steps)?;
    Ok((setting, in_words(scene, setting)))
}

fn in_words(scene: &Scene, setting: Setting) -> String {
    let (length, period) = (scene.length(), scene.period());
    let per_period = |count: u64| match scene.has_period() {
        true => format!(" ({:.6} a period)", count as f64 * period / length),
        false => String::new(),
    };
    match setting {
        Setting::Tolerance(tol) => format!("tol {tol:e}"),
        Setting::Steps(steps) => {
            let step = match scene.units() {
                Some(_) => scene.in_words(length / steps as f64),
                None => format!("{:e}", format!("{:.6e}", length / steps as f64).parse::<f64>().unwrap_or_default()),
            };
            format!("{steps} steps of {step}{}", per_period(steps))
        }
        Setting::Windows(windows, nodes) => {
            format!("{windows} windows{}, {nodes} nodes", per_period(windows))
        }
    }
}
