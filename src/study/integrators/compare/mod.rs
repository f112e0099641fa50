//! Error against run time: every integrator over a ladder of steps or tolerances on one scene, and
//! beside them the plain loops that anybody would write.

pub(crate) mod ladder;
pub(crate) mod reference;
mod report;

pub(crate) use reference::steps;

use crate::study::{
    Changes, Progress, Study, Work,
    integrators::order::{self, Mode},
    methods,
    options::{one, options},
};
use crate::{
    chain::Resonators,
    error::{Result, require},
    named::named,
    numerics::least_by,
    plain::Loop,
    report::Report,
    run::method::Method,
    scene::Scene,
};
use hertzchain_integrators::{Stats, splitting::Parts};
use ladder::Refinement;
use reference::ReferenceState;

/// Share of the time that references may take.
const REFERENCE_SHARE: f64 = 0.3;

options! {
    /// The comparison of integrators on a scene.
    pub struct Compare {
        /// Name of a built-in scene, or a TOML file.
        scene: Option<String> = None, [required = true];
        /// Changes to it.
        set: Changes = Changes::default();
        /// What is compared.
        options: CompareOptions = CompareOptions::default();
    }
}

named! {
    /// What the error of a run is measured in.
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    pub enum ErrorNorm {
        /// Strains.
        Strain = "strain", "strains";
        /// Velocities of beads; on a strain ring, rates of strains.
        Velocity = "velocity", "velocities of beads";
        /// Stretches of the springs of resonators.
        Resonator = "resonator", "stretches of resonators";
        /// The energy, which is constant: the largest error along the run.
        Energy = "energy", "the energy";
        /// The largest of the first three.
        All = "all", "strains, velocities of beads and stretches of resonators";
    }
    /// What is measured, in words.
    pub fn words
}
one!(ErrorNorm);

impl ErrorNorm {
    /// Which of strains, velocities and stretches it looks at.
    fn parts(self) -> std::ops::Range<usize> {
        match self {
            Self::Strain => 0..1,
            Self::Velocity => 1..2,
            Self::Resonator => 2..3,
            Self::Energy => 0..0,
            Self::All => 0..3,
        }
    }

    /// Refuses a scene that does not have what is measured.
    fn check(self, scene: &Scene) -> Result<()> {
        let tied = !scene.chain().stretches(scene.initial().as_slice()).is_empty();
        require(self != Self::Resonator || tied, "error", self.name(), "a chain with resonators")?;
        if self == Self::Energy { has_energy(scene) } else { Ok(()) }
    }
}

/// Refuses a scene whose state has no energy.
pub(crate) fn has_energy(scene: &Scene) -> Result<()> {
    let rule = "a state with an energy: on a strain ring the strains of beads and resonators add up to the same";
    require(scene.chain().has_energy(scene.initial().as_slice()), "scene", scene.name(), rule)
}

options! {
    /// What to compare.
    pub struct CompareOptions {
        /// What errors are measured in: the state at the end, or the energy.
        ///
        /// Of strains, velocities and stretches each is relative to its largest, of all sites at
        /// 101 times of the reference run.
        error: ErrorNorm = ErrorNorm::All, "NORM";
        /// Integrators, separated by commas, or all [default: a selection].
        ///
        /// None: those of [`Method::default_comparison_set`].
        integrators: Vec<String> = vec![], "A,B,..", [long_help = integrators_help()];
        /// Wall time for all runs, in seconds; what would not fit is left out.
        ///
        /// Runs are also left out if they take more than a 400th of this time and are expected to
        /// be beaten in error and in time.
        max_time: f64 = 10.0, "S", (positive);
    }
}

#[cfg(feature = "cli")]
fn integrators_help() -> String {
    let names: Vec<_> = Method::default_comparison_set().iter().map(Method::name).collect();
    format!(
        "Integrators, separated by commas, or all.\n\nBy default integrators that are the fastest at some error on a \
         built-in scene, and those that serve as a standard of comparison: {}.",
        names.join(", ")
    )
}

impl CompareOptions {
    /// The methods and plain loops that can run the scene, and those that cannot, with the reason.
    /// All methods that are named must be able to run it.
    fn candidates(&self, scene: &Scene) -> Result<(Vec<Candidate>, Vec<LeftOut>)> {
        self.error.check(scene)?;
        let methods = methods(&self.integrators, Method::default_comparison_set)?;
        if matches!(&self.integrators[..], [name, ..] if name.trim() != "all") {
            methods.iter().try_for_each(|method| method.runs(scene.chain()))?;
        }
        let loops = [Loop::VERLET, Loop::ROTATION].map(Candidate::Plain);
        let (mut can, mut cannot) = (Vec::new(), Vec::new());
        for candidate in methods.into_iter().map(Candidate::Method).chain(loops) {
            match self.missing(scene, candidate) {
                Some(why) => cannot.push((candidate, why)),
                None => can.push(candidate),
            }
        }
        Ok((can, cannot))
    }

    /// Why a method or loop cannot be compared on a scene.
    fn missing(&self, scene: &Scene, candidate: Candidate) -> Option<&'static str> {
        match candidate {
            Candidate::Method(method) => method.unsupported_reason(scene.chain()),
            Candidate::Plain(_) if scene.chain().details().is_some() => {
                Some("it is for equal beads of mass 1 whose contacts are alike, without damping, drives and gravity")
            }
            Candidate::Plain(_) if self.error == ErrorNorm::Energy => Some("it does not compute the energy"),
            Candidate::Plain(Loop::ROTATION) if scene.chain().params().resonators() == Resonators::None => {
                Some("without resonators nothing rotates: it is plain Verlet")
            }
            Candidate::Plain(_) => None,
        }
    }
}

impl Study for Compare {
    const INTERRUPTIBLE: bool = true;

    fn outline() -> Option<Report> {
        let reference = Reference { method: String::new(), error_estimate: 0.0 };
        let (rows, stopped, left_out) = (Vec::new(), Vec::new(), Vec::new());
        let scene = Scene::load("impact").ok()?;
        let (norm, largest) = (ErrorNorm::All, [1.0; 3]);
        Some(Comparison { scene, norm, largest, opens: true, reference, rows, stopped, left_out }.report())
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = Scene::load_with(self.scene.as_deref().unwrap_or_default(), &self.set.set)?;
        self.options.candidates(&scene)?;
        Ok(Box::new(move |_, progress| Ok(compare(&scene, &self.options, progress)?.report())))
    }
}

/// A method or loop that cannot run the scene, and why.
pub type LeftOut = (Candidate, &'static str);

/// The reference that errors are measured against.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Method and setting, in words.
    pub method: String,
    /// The difference of two references by different methods in the norm of the comparison: an
    /// estimate of the larger error; for the energy, the energy error of the reference.
    pub error_estimate: f64,
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Candidate {
    /// A method of the library.
    Method(Method),
    /// A plain loop.
    Plain(Loop),
}

impl Candidate {
    /// Its name.
    pub fn name(&self) -> String {
        match self {
            Self::Method(method) => method.name(),
            Self::Plain(plain) => plain.name.to_owned(),
        }
    }

    /// Whether its levels are tolerances, and not steps.
    pub fn adaptive(&self) -> bool {
        matches!(self, Self::Method(method) if method.adaptive())
    }
}

/// One method or loop at one setting.
#[derive(Clone, Debug)]
pub struct Row {
    /// The method or loop.
    pub candidate: Candidate,
    /// The setting, in words.
    pub setting: String,
    /// Step size; the mean one for adaptive methods.
    pub step: f64,
    /// Error in the norm of the comparison; `None` if the run failed.
    pub error: Option<f64>,
    /// Largest relative energy error; `None` if the run failed or the state has no energy, and for
    /// plain loops, which do not compute the energy.
    pub energy_error: Option<f64>,
    /// Median wall time of several runs that record nothing, in seconds; `None` if the run failed.
    pub wall: Option<f64>,
    /// Number of runs whose median is `wall`.
    pub repeats: usize,
    /// Work of one such run.
    pub stats: Stats,
    /// Whether the error is too near to that of the reference to be trusted.
    pub below_reference: bool,
    /// Why the run failed.
    pub failure: Option<String>,
}

impl Row {
    /// The row of a run that did not begin.
    pub fn failed(candidate: Candidate, setting: String, why: String) -> Self {
        Self {
            candidate,
            setting,
            step: f64::NAN,
            error: None,
            energy_error: None,
            wall: None,
            repeats: 0,
            stats: Stats::default(),
            below_reference: false,
            failure: Some(why),
        }
    }

    /// Wall time a step, in seconds.
    fn wall_of_step(&self) -> Option<f64> {
        self.wall.map(|wall| wall / self.stats.steps.max(1) as f64)
    }
}

/// The row that reaches an error, and the time in seconds to that error.
pub type Fastest<'a> = (&'a Row, f64);

/// The outcome of a comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Scene.
    pub scene: Scene,
    /// What errors are measured in.
    pub norm: ErrorNorm,
    /// The largest strain, velocity and stretch of the reference, which errors are divided by.
    pub largest: [f64; 3],
    /// Whether some contact is open and some closed, at the same or at different times.
    pub opens: bool,
    /// The reference that errors are measured against.
    pub reference: Reference,
    /// Rows, method by method, coarse to fine.
    pub rows: Vec<Row>,
    /// Methods and loops whose ladders ended before the last level, and why.
    pub stopped: Vec<(Candidate, String)>,
    /// Methods and loops that cannot run the scene. They have no rows.
    pub left_out: Vec<LeftOut>,
}

impl Comparison {
    /// The rows of one method or loop.
    pub fn rows_of(&self, candidate: &Candidate) -> Vec<&Row> {
        self.rows.iter().filter(|row| row.candidate == *candidate).collect()
    }

    /// The methods and loops, in the order of their first rows.
    pub fn candidates(&self) -> Vec<Candidate> {
        let mut candidates: Vec<Candidate> = self.rows.iter().map(|row| row.candidate).collect();
        candidates.dedup();
        candidates
    }

    /// Wall time of a step of a row over that of a step of plain Verlet. The latter is taken from
    /// Verlet's row of the same level, which was timed just after, or else from its last row.
    pub fn step_cost(&self, row: &Row) -> Option<f64> {
        let level = self.rows_of(&row.candidate).iter().position(|other| std::ptr::eq(*other, row))?;
        let verlet = self.rows_of(&Candidate::Plain(Loop::VERLET));
        let verlet = verlet.get(level).or(verlet.last())?.wall_of_step()?;
        row.wall_of_step().map(|wall| wall / verlet)
    }

    /// The order that theory gives a method or loop here; none for adaptive methods, and for
    /// contacts or beads that are not alike.
    pub fn order(&self, candidate: &Candidate) -> Option<f64> {
        let chain = self.scene.chain();
        let known = chain.details().is_none() && !candidate.adaptive();
        let theory = |method: Method| {
            let mode = match method {
                Method::Corrected(Parts::ALL) => Mode::Corrected,
                _ => Mode::Plain,
            };
            order::theory(method, chain.params().alpha, mode, order::Quantity::State)
        };
        known.then(|| match candidate {
            Candidate::Plain(_) => 2.0,
            Candidate::Method(method) if self.opens => theory(*method),
            Candidate::Method(method) => f64::from(method.info().order),
        })
    }

    /// The fastest method, or plain loop, to an error: the row that reaches it, and the time.
    pub fn fastest(&self, error: f64, plain: bool) -> Option<Fastest<'_>> {
        let of = |candidate: &Candidate| matches!(candidate, Candidate::Plain(_)) == plain;
        let all = self.candidates().into_iter().filter(of).filter_map(|candidate| self.time_to(candidate, error));
        least_by(all, |(_, wall)| *wall)
    }

    /// The coarsest row of a method or loop that reaches an error, and the time that the error
    /// takes: on the line of log time over log error to the coarser row, if both converge, or that
    /// of a finer row which took less.
    fn time_to(&self, candidate: Candidate, error: f64) -> Option<Fastest<'_>> {
        let off = |row: &Row| row.error.unwrap_or(f64::MAX) + self.reference.error_estimate;
        let (all, reaching) = (self.reaching(candidate, f64::MAX), self.reaching(candidate, error));
        let (first, before) = (*reaching.first()?, all.len() - reaching.len());
        let coarser = before.checked_sub(1).and_then(|k| all.get(k)).and_then(|row| Some((off(row), row.wall?)));
        let wall = reaching.iter().filter_map(|row| row.wall).fold(f64::MAX, f64::min);
        let between = coarser.zip(first.wall).map_or(f64::MAX, |((coarse, quick), slow)| {
            quick * (slow / quick).powf((coarse / error).ln() / (coarse / off(first)).ln())
        });
        Some((first, between.min(wall)))
    }

    /// The rows of a method or loop that reach an error by converging: with that of the reference,
    /// neither their errors nor those of finer rows exceed it, and they are not before the first
    /// row that is below the reference or twice all finer ones. A row without finer ones may have a
    /// small error by chance, such as strains between which fast resonators average out.
    fn reaching(&self, candidate: Candidate, most: f64) -> Vec<&Row> {
        let mut rows = self.rows_of(&candidate);
        rows.retain(|row| row.error.is_some());
        let errors: Vec<f64> = rows.iter().filter_map(|row| row.error).collect();
        let converges = |k: usize| {
            let finer = errors[k + 1..].iter().copied().reduce(f64::max);
            rows[k].below_reference || finer.is_some_and(|finer| 2.0 * finer <= errors[k])
        };
        let first = (0..errors.len()).find(|&k| converges(k)).unwrap_or(errors.len());
        let above = errors.iter().rposition(|error| {
            let off = error + self.reference.error_estimate;
            off.is_nan() || off > most
        });
        rows.split_off(first.max(above.map_or(0, |last| last + 1)))
    }
}

/// Compares methods on a scene. `progress` is told the share of the time budget that is used, and
/// what runs.
///
/// Errors and energies come from runs on all cores; wall times from runs that record nothing, one
/// at a time.
///
/// # Errors
/// A budget outside its rule, no method, or references that cannot be computed or contradict each
/// other.
pub fn compare(scene: &Scene, options: &CompareOptions, progress: Progress<'_>) -> Result<Comparison> {
    let (candidates, left_out) = options.candidates(scene)?;
    let budget = options.max_time;
    options.within_ranges()?;
    let mut refinement = Refinement::new(scene, candidates, budget, progress);
    let tell = |words: &str| progress(0.0, words);
    let reference = ReferenceState::find(scene, options.error, budget * REFERENCE_SHARE, &tell)?;
    reference.good()?;
    refinement.run(&reference);
    let (rows, stopped) = refinement.finish();
    Ok(Comparison {
        scene: scene.clone(),
        norm: options.error,
        largest: reference.largest(),
        opens: reference.opens(),
        reference: Reference { method: reference.method, error_estimate: reference.error_estimate },
        rows,
        stopped,
        left_out,
    })
}
