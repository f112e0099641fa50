//! Commands, and the flags of those that are no studies.
//!
//! The first paragraph of a comment is what `-h` prints, the whole is what `--help` prints. A flag
//! that several commands have is said in the same words by each; what differs between commands
//! stands in the second paragraph.

mod run;
mod studies;

use run::RUN_EXAMPLES;
pub(super) use run::RunArgs;
use studies::{BreatherAction, DpsAction, OrbitAction, StudyAction, WaveArgs};

use super::{
    figures::FiguresArgs, integrators::IntegratorsArgs, report::ReportArgs, runner::StudyCommand, scenes::ScenesArgs,
    shell::ShellAction,
};
use crate::{
    paper::Verify,
    study::{Compare, PlanFile, Prove},
};
use clap::Parser;
use hertzchain_integrators::Instructions;

/// Commands, each with its help, its flags, and examples of it for the long help.
macro_rules! commands {
    ($name:ident; $($(#[$help:meta])* $command:ident($args:ty) $(=> $($example:literal),+)?;)*) => {
        #[derive(clap::Subcommand)]
        pub(crate) enum $name {
            $($(#[$help])* $(#[command(after_long_help = $crate::cli::args::examples(&[$($example),+]))])?
            $command($args),)*
        }

        impl $crate::cli::runner::Runs for $name {
            fn run(&self) -> $crate::cli::Exit {
                match self {
                    $(Self::$command(args) => args.run(),)*
                }
            }

            fn report(&self, progress: $crate::study::Progress<'_>) -> $crate::error::Result<$crate::report::Report> {
                match self {
                    $(Self::$command(args) => args.report(progress),)*
                }
            }
        }
    };
}
use commands;

fn examples(all: &[&str]) -> String {
    let head = if all.len() == 1 { "Example:" } else { "Examples:" };
    all.iter().fold(head.to_owned(), |text, example| text + "\n  hertzchain " + example)
}

/// Columns of the widest help; narrower terminals get narrower help.
const COLUMNS: usize = 79;

/// Nonlinear waves in locally resonant Hertzian chains.
///
/// Runs chains of beads in Hertzian contact, each with a resonator on a spring, compares
/// integrators by error and run time, and computes the waves and breathers of the paper. Quantities
/// are in SI units where a scene has a table `[units]`; else they are dimensionless, in the units of
/// the paper: bead mass 1, contact constant 1.
#[derive(Parser)]
#[command(
    version,
    arg_required_else_help = true,
    max_term_width = COLUMNS,
    after_help = "`hertzchain COMMAND -h` is a summary of a command, `--help` has details and examples.",
    after_long_help = "\
Examples:
  hertzchain run tw-q15
  hertzchain run tw-q15 --tol 1e-9 --out out/tw-q15
  hertzchain compare cradle --max-time 20
  hertzchain scenes template"
)]
pub(super) struct Cli {
    /// Vector instructions of inner loops: portable, avx2 or avx512.
    ///
    /// Results have the same bits with each [default: the widest of this machine].
    #[arg(
        long,
        global = true,
        value_name = "SET",
        value_parser = instructions,
        display_order = 1000,
        hide_short_help = true
    )]
    pub(super) instructions: Option<Instructions>,
    #[command(subcommand)]
    pub(super) command: Command,
}

fn instructions(text: &str) -> Result<Instructions, String> {
    let named = Instructions::ALL.into_iter().find(|set| set.to_string() == text);
    let set = named.ok_or_else(|| format!("one of {}", Instructions::ALL.map(|set| set.to_string()).join(", ")))?;
    if set.available() { Ok(set) } else { Err("this machine does not have them".to_owned()) }
}

commands! {
    Command;

    /// Run one scene with one integrator.
    ///
    /// Prints time, energy and work at the end of the run; with --out it also writes the state,
    /// energies and strains at the sample times, and pictures.
    #[command(after_long_help = RUN_EXAMPLES)]
    Run(RunArgs);
    /// Compare integrators on a scene: error against run time.
    ///
    /// Every integrator runs with smaller and smaller steps or tolerances until the time of
    /// --max-time is used up. Errors are those that --error names, against a reference that a second
    /// method checks. The fastest run at each error comes first.
    Compare(StudyCommand<Compare>) =>
        "compare tw-q15 --out out/compare",
        "compare cradle --integrators verlet,corrected,collocation",
        "compare impact --integrators all --max-time 60";
    /// Run a scene at every point of a grid that a plan describes.
    ///
    /// The plan names a scene, axes (any keys of the scene: lists, ranges, seeds) and the
    /// quantities to keep of each run; `hertzchain scenes` lists those that come with the program. Prints a table; with --out also writes a picture, and a
    /// store from which an interrupted sweep resumes.
    Sweep(StudyCommand<PlanFile>) =>
        "sweep dimer --out out/dimer",
        "sweep --template > plan.toml",
        "sweep plan.toml --out out/plan",
        "sweep plan.toml --out out/plan --shard 2/8";
    /// List the built-in scenes and plans, show a scene as TOML, or print a template.
    Scenes(ScenesArgs) =>
        "scenes",
        "scenes show tw-q15",
        "scenes template > my-scene.toml";
    /// List the integrators with order, stages and source.
    ///
    /// Collocation has M = 4, 8 or 12 nodes a panel, M stages, and order 2M.
    Integrators(IntegratorsArgs) => "integrators --json";
    /// Studies of integrators and of theory, over grids of parameters.
    #[command(subcommand)]
    Study(StudyAction) =>
        "study order --alpha 2",
        "study stability --charts light --quick";
    /// Travelling waves, their stability, exact waves and solitary waves.
    ///
    /// Without a subcommand: runs the travelling wave of a scene on the chain and compares it with
    /// its first-order ansatz; with a perturbation (--zeta) it shows whether the wave is stable.
    /// `wave modulation` computes how fast modulations of the wave grow, `wave exact` the exact
    /// wave beside the ansatz.
    Wave(Box<WaveArgs>) =>
        "wave tw-q15",
        "wave tw-q15 --zeta 0.01 --seeds 20 --out out/wave",
        "wave modulation tw-q15",
        "wave exact tw-q15";
    /// Breathers: bright, trivial and dark, and branches of dark ones.
    #[command(subcommand)]
    Breather(BreatherAction) =>
        "breather bright --center bond --epsilon 0.01",
        "breather dark --center bond --omega-b 2.05 --out out/dark";
    /// Periodic orbits of driven scenes, normal modes of conservative ones.
    #[command(subcommand)]
    Orbit(OrbitAction) =>
        "orbit driven granular-crystal",
        "orbit mode defect --to 1.5 --out out/mode";
    /// Averages and profiles of the modulation (DpS) equations.
    #[command(subcommand)]
    Dps(DpsAction) =>
        "dps integrals --b 0 --r 1",
        "dps homoclinic --center site";
    /// Check the certificate of a wave, a breather or a branch: prove that it exists.
    ///
    /// By interval arithmetic, from the numbers of the certificate alone. Exit code 1 if nothing is
    /// proved.
    Prove(StudyCommand<Prove>) =>
        "wave exact tw-q15 --prove --certificate out/wave.cert",
        "prove out/wave.cert";
    /// Figures and numbers of the paper, and a report on one page.
    #[command(subcommand)]
    Paper(PaperAction) =>
        "paper figures --only tw-q15",
        "paper verify --section 3";
    /// Completions of a shell.
    #[command(subcommand)]
    Shell(ShellAction) => "shell completions bash";
}

commands! {
    PaperAction;

    /// Compute the figures of the paper: pictures, and their numbers as CSV.
    ///
    /// Files are what this command is for: without --out they go to out/figures.
    Figures(FiguresArgs) =>
        "paper figures --only tw-q15,tw-rho3",
        "paper figures --out out/all";
    /// Compare every number in the text of the paper with ours.
    ///
    /// For every number in Sec. 2 to 8: what the paper says, what we get, the verdict, and why if
    /// they differ. Exit code 0: every verdict is the known one, and where the paper is known to
    /// differ our numbers have not changed. Exit code 1: a verdict or such a number is another one,
    /// or a run failed.
    Verify(StudyCommand<Verify>) => "paper verify --section 3 --out out/verify";
    /// Run everything in its short form and write one HTML page.
    ///
    /// The page has findings first, then pictures, then tables; the data are beside it. Files are
    /// what this command is for: without --out they go to out/report.
    Report(ReportArgs) =>
        "paper report --out out/report",
        "paper report --only compare,order";
}
