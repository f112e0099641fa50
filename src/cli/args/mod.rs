//! Commands, and the flags of those that are no studies.
//!
//! The first paragraph of a comment is what `-h` prints, the whole is what `--help` prints. A flag
//! that several commands have is said in the same words by each; what differs between commands
//! stands in the second paragraph.

mod run;
mod studies;

use run::RUN_EXAMPLES;
pub(super) use run::RunArgs;
use studies::{BREATHERS, DPS, ORBITS, STUDIES, WAVES};

use super::{
    figures::FiguresArgs,
    integrators::IntegratorsArgs,
    report::ReportArgs,
    runner::{Asked, Runs, STUDY, StudyCommand},
    scenes::{List, Show, Template},
    shell::Completions,
};
use crate::{
    paper::Verify,
    study::{
        Compare, PlanFile, Prove, Wave,
        options::{Field, Flag, one, options, paragraphs},
    },
};
use clap::{ArgMatches, Command};
use hertzchain_integrators::Instructions;

/// A row of [`commands!`]: a command, a group of commands, or both.
pub(super) struct Row {
    name: &'static str,
    /// The lines of its help.
    docs: &'static [&'static str],
    /// The end of its long help.
    after: fn() -> String,
    /// Its flags, and what reads them; none of a mere group.
    own: Option<Own>,
    /// The commands of the group.
    below: &'static [Row],
}

const NONE: &[Row] = &[];

type Own = (fn(Command) -> Command, fn(&ArgMatches) -> Box<dyn Runs>);

/// A table of commands, each with its help, its flags, the table of the commands below it, and
/// examples for its long help.
macro_rules! commands {
    ($table:ident; $($(#[doc = $doc:literal])* $name:literal: ($($args:ty)?) $($below:ident)?
        $(=> $($example:literal),+)? $(, after $after:expr)?;)*) => {
        pub(super) const $table: &[Row] = &[$(Row {
            name: $name,
            docs: &[$($doc),*],
            after: $(|| examples(&[$($example),+]))? $($after)?,
            own: commands!(@own $($args)?),
            below: [$($below,)? NONE][0],
        }),*];
    };
    (@own) => { None };
    (@own $args:ty) => {
        Some((<$args as Asked>::flags, |matches| Box::new(<$args as Asked>::read(matches))))
    };
}
use commands;

fn examples(all: &[&str]) -> String {
    let head = if all.len() == 1 { "Example:" } else { "Examples:" };
    all.iter().fold(head.to_owned(), |text, example| text + "\n  hertzchain " + example)
}

/// Columns of the widest help; narrower terminals get narrower help.
const COLUMNS: usize = 79;

options! {
    /// Flags of all commands.
    struct Everywhere {
        /// Vector instructions of inner loops: portable, avx2 or avx512.
        ///
        /// Results have the same bits with each [default: the widest of this machine].
        instructions: Option<Instructions> = None, "SET", [global = true, display_order = 1000, hide_short_help = true];
    }
}
one!(Instructions: instructions);

fn instructions(text: &str) -> Result<Instructions, String> {
    let named = Instructions::ALL.into_iter().find(|set| set.to_string() == text);
    let set = named.ok_or_else(|| format!("one of {}", Instructions::ALL.map(|set| set.to_string()).join(", ")))?;
    if set.available() { Ok(set) } else { Err("this machine does not have them".to_owned()) }
}

/// The program: its flags and commands.
pub(super) fn program() -> Command {
    let after = "`hertzchain COMMAND -h` is a summary of a command, `--help` has details and examples.";
    let command = PROGRAM[0].command().version(env!("CARGO_PKG_VERSION")).max_term_width(COLUMNS).after_help(after);
    Everywhere::default().add(command, &Flag::GROUP)
}

/// The command line: the flag of all commands, and the command.
pub(super) fn read(matches: &ArgMatches) -> (Option<Instructions>, Box<dyn Runs>) {
    (Everywhere::default().read(matches, "").instructions, PROGRAM[0].read(matches))
}

impl Row {
    fn command(&self) -> Command {
        let (short, long) = paragraphs(self.docs);
        let command = self.own.map_or_else(|| Command::new(self.name), |(flags, _)| flags(Command::new(self.name)));
        let command = long.into_iter().fold(command.about(short), Command::long_about);
        let command = command.after_long_help((self.after)()).subcommands(self.below.iter().map(Self::command));
        // A study has flags that its group does not share.
        let apart = !self.below.is_empty() && command.get_groups().any(|group| group.get_id() == STUDY);
        let command = command.args_conflicts_with_subcommands(apart).subcommand_negates_reqs(apart);
        command.subcommand_required(self.own.is_none()).arg_required_else_help(self.own.is_none())
    }

    fn read(&self, matches: &ArgMatches) -> Box<dyn Runs> {
        let below = matches
            .subcommand()
            .and_then(|(name, matches)| Some((self.below.iter().find(|row| row.name == name)?, matches)));
        match (below, self.own) {
            (Some((row, matches)), _) => row.read(matches),
            (None, Some((_, read))) => read(matches),
            (None, None) => unreachable!("clap has refused the line"),
        }
    }
}

commands! {
    PROGRAM;

    /// Nonlinear waves in locally resonant Hertzian chains.
    ///
    /// Runs chains of beads in Hertzian contact, each with a resonator on a spring, compares
    /// integrators by error and run time, and computes the waves and breathers of the paper.
    /// Quantities are in SI units where a scene has a table `[units]`; else they are dimensionless,
    /// in the units of the paper: bead mass 1, contact constant 1.
    "hertzchain": () COMMANDS =>
        "run tw-q15",
        "run tw-q15 --tol 1e-9 --out out/tw-q15",
        "compare cradle --max-time 20",
        "scenes template";
}

commands! {
    COMMANDS;

    /// Run one scene with one integrator.
    ///
    /// Prints time, energy and work at the end of the run; with --out it also writes the state,
    /// energies and strains at the sample times, and pictures.
    "run": (RunArgs), after || RUN_EXAMPLES.to_owned();
    /// Compare integrators on a scene: error against run time.
    ///
    /// Every integrator runs with smaller and smaller steps or tolerances until the time of
    /// --max-time is used up. Errors are those that --error names, against a reference that a second
    /// method checks. The fastest run at each error comes first.
    "compare": (StudyCommand<Compare>) =>
        "compare tw-q15 --out out/compare",
        "compare cradle --integrators verlet,corrected,collocation",
        "compare impact --integrators all --max-time 60";
    /// Run a scene at every point of a grid that a plan describes.
    ///
    /// The plan names a scene, axes (any keys of the scene: lists, ranges, seeds) and the
    /// quantities to keep of each run; `hertzchain scenes` lists those that come with the program.
    /// Prints a table; with --out also writes a picture, and a store from which an interrupted
    /// sweep resumes.
    "sweep": (StudyCommand<PlanFile>) =>
        "sweep dimer --out out/dimer",
        "sweep --template > plan.toml",
        "sweep plan.toml --out out/plan",
        "sweep plan.toml --out out/plan --shard 2/8";
    /// List the built-in scenes and plans, show a scene as TOML, or print a template.
    "scenes": (List) SCENES =>
        "scenes",
        "scenes show tw-q15",
        "scenes template > my-scene.toml";
    /// List the integrators with order, stages and source.
    ///
    /// Collocation has M = 4, 8 or 12 nodes a panel, M stages, and order 2M.
    "integrators": (IntegratorsArgs) => "integrators --json";
    /// Studies of integrators and of theory, over grids of parameters.
    "study": () STUDIES =>
        "study order --alpha 2",
        "study stability --charts light --quick";
    /// Travelling waves, their stability, exact waves and solitary waves.
    ///
    /// Without a subcommand: runs the travelling wave of a scene on the chain and compares it with
    /// its first-order ansatz; with a perturbation (--zeta) it shows whether the wave is stable.
    /// `wave modulation` computes how fast modulations of the wave grow, `wave exact` the exact
    /// wave beside the ansatz.
    "wave": (StudyCommand<Wave>) WAVES =>
        "wave tw-q15",
        "wave tw-q15 --zeta 0.01 --seeds 20 --out out/wave",
        "wave modulation tw-q15",
        "wave exact tw-q15";
    /// Breathers: bright, trivial and dark, and branches of dark ones.
    "breather": () BREATHERS =>
        "breather bright --center bond --epsilon 0.01",
        "breather dark --center bond --omega-b 2.05 --out out/dark";
    /// Periodic orbits of driven scenes, normal modes of conservative ones.
    "orbit": () ORBITS =>
        "orbit driven granular-crystal",
        "orbit mode defect --to 1.5 --out out/mode";
    /// Averages and profiles of the modulation (DpS) equations.
    "dps": () DPS =>
        "dps integrals --b 0 --r 1",
        "dps homoclinic --center site";
    /// Check the certificate of a wave, a breather or a branch: prove that it exists.
    ///
    /// By interval arithmetic, from the numbers of the certificate alone. Exit code 1 if nothing is
    /// proved.
    "prove": (StudyCommand<Prove>) =>
        "wave exact tw-q15 --prove --certificate out/wave.cert",
        "prove out/wave.cert";
    /// Figures and numbers of the paper, and a report on one page.
    "paper": () PAPER =>
        "paper figures --only tw-q15",
        "paper verify --section 3";
    /// Completions of a shell.
    "shell": () SHELL => "shell completions bash";
}

commands! {
    PAPER;

    /// Compute the figures of the paper: pictures, and their numbers as CSV.
    ///
    /// Files are what this command is for: without --out they go to out/figures.
    "figures": (FiguresArgs) =>
        "paper figures --only tw-q15,tw-rho3",
        "paper figures --out out/all";
    /// Compare every number in the text of the paper with ours.
    ///
    /// For every number in Sec. 2 to 8: what the paper says, what we get, the verdict, and why if
    /// they differ. Exit code 0: every verdict is the known one, and where the paper is known to
    /// differ our numbers have not changed. Exit code 1: a verdict or such a number is another one,
    /// or a run failed.
    "verify": (StudyCommand<Verify>) => "paper verify --section 3 --out out/verify";
    /// Run everything in its short form and write one HTML page.
    ///
    /// The page has findings first, then pictures, then tables; the data are beside it. Files are
    /// what this command is for: without --out they go to out/report.
    "report": (ReportArgs) =>
        "paper report --out out/report",
        "paper report --only compare,order";
}

commands! {
    SCENES;

    /// Print the TOML of a scene: a start for your own.
    "show": (Show) => "scenes show tw-q15 > my-scene.toml";
    /// Print a scene with every key, each explained: a start for your own.
    "template": (Template) => "scenes template > my-scene.toml";
}

commands! {
    SHELL;

    /// Print a script that completes commands and flags in a shell.
    ///
    /// Each shell has a place of its own for it; for bash that is a file called hertzchain in
    /// ~/.local/share/bash-completion/completions.
    "completions": (Completions) => "shell completions fish > ~/.config/fish/completions/hertzchain.fish";
}
