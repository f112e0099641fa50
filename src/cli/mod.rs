//! The command line: commands with their examples in `args`; flags of studies are their options;
//! one way to run them in `runner`.

mod args;
mod figures;
mod integrators;
mod report;
mod run;
mod runner;
mod scenes;
mod signals;
mod verify;

use crate::error::{Error, Result};
use args::{BreatherAction, Cli, Command, DpsAction, PaperAction, StudyAction, WaveAction};
use clap::{
    CommandFactory, FromArgMatches,
    builder::ValueParser,
    error::{ContextKind, ErrorKind},
    value_parser,
};
use indicatif::{ProgressBar, ProgressStyle};
use std::{io::Write, process::ExitCode};

/// Exit code of a command line that is not understood, as clap has it.
const NOT_UNDERSTOOD: u8 = 2;

/// Reads the arguments, runs the command, says what went wrong.
pub fn main() -> ExitCode {
    let matches = match numbers_checked(Cli::command()).try_get_matches() {
        Ok(matches) => matches,
        Err(error) => {
            if let Some(refusal) = refusal(&error) {
                eprintln!("error: {refusal}");
                return ExitCode::FAILURE;
            }
            let Some(words) = moved(&error) else { error.exit() };
            eprintln!("error: {words}");
            return ExitCode::from(NOT_UNDERSTOOD);
        }
    };
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    if let Some(set) = cli.instructions {
        // Sets that the machine lacks are no argument.
        let _ = set.select();
    }
    let code = run_command(&cli.command).unwrap_or_else(|error| {
        eprintln!("error: {error}");
        ExitCode::FAILURE
    });
    signals::exit_code().map_or(code, ExitCode::from)
}

fn run_command(command: &Command) -> Exit {
    match command {
        Command::Run(args) => run::main(args),
        Command::Compare(told) => told.run(),
        Command::Scenes(args) => scenes::main(args),
        Command::Integrators(args) => integrators::main(args),
        Command::Study(args) => match &args.action {
            StudyAction::Order(told) => told.run(),
            StudyAction::Scaling(told) => told.run(),
            StudyAction::Drift(told) => told.run(),
            StudyAction::Stability(told) => told.run(),
            StudyAction::Theorem(told) => told.run(),
            StudyAction::Lifetimes(told) => told.run(),
        },
        Command::Wave(args) => match &args.action {
            Some(WaveAction::Modulation(told)) => told.run(),
            None => args.told.run(),
        },
        Command::Breather(args) => match &args.action {
            BreatherAction::Bright(told) => told.run(),
            BreatherAction::Trivial(told) => told.run(),
            BreatherAction::Dark(told) => told.run(),
            BreatherAction::Continue(told) => told.run(),
            BreatherAction::Doubled(told) => told.run(),
            BreatherAction::Evolve(told) => told.run(),
        },
        Command::Dps(args) => match &args.action {
            DpsAction::Integrals(told) => told.run(),
            DpsAction::Homoclinic(told) => told.run(),
            DpsAction::Dark(told) => told.run(),
        },
        Command::Paper(args) => match &args.action {
            PaperAction::Figures(args) => figures::main(args),
            PaperAction::Verify(args) => verify::main(args),
            PaperAction::Report(args) => report::main(args),
        },
    }
}

/// What the library says of a value that it refuses.
fn refusal(error: &clap::Error) -> Option<&Error> {
    std::error::Error::source(error)?.downcast_ref()
}

/// Where a command has gone that is no longer there, if that is the error.
fn moved(error: &clap::Error) -> Option<String> {
    if error.kind() != ErrorKind::InvalidSubcommand {
        return None;
    }
    let name = error.get(ContextKind::InvalidSubcommand)?.to_string();
    let given: Vec<String> = std::env::args().skip(1).collect();
    let above = given.iter().position(|word| *word == name)?.checked_sub(1).map(|k| given[k].as_str());
    let now = args::moved(above, &name)?;
    let above = above.filter(|above| *above == "dps").map(|above| format!("{above} ")).unwrap_or_default();
    Some(format!("`hertzchain {above}{name}` is now `hertzchain {now}`"))
}

/// The command with every flag that takes a number taking negative ones, and refusing in words what
/// is none or what a double cannot hold.
fn numbers_checked(command: clap::Command) -> clap::Command {
    let double = ValueParser::from(value_parser!(f64)).type_id();
    let size = ValueParser::from(value_parser!(usize)).type_id();
    let whole = ValueParser::from(value_parser!(u64)).type_id();
    let others = [ValueParser::from(value_parser!(u32)).type_id(), ValueParser::from(value_parser!(i64)).type_id()];
    let command = command.mut_args(|arg| match arg.get_value_parser().type_id() {
        id if id == double => arg.value_parser(crate::number::double).allow_negative_numbers(true),
        id if id == size => arg.value_parser(crate::number::whole::<usize>).allow_negative_numbers(true),
        id if id == whole => arg.value_parser(crate::number::whole::<u64>).allow_negative_numbers(true),
        id if others.contains(&id) => arg.allow_negative_numbers(true),
        _ => arg,
    });
    command.mut_subcommands(numbers_checked)
}

/// Writes to stdout. A reader that has gone away is no error of ours.
fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// A bar on stderr, seen only on a terminal.
fn progress_bar() -> ProgressBar {
    let bar = ProgressBar::new(1000);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    bar
}

type Exit = Result<ExitCode>;
