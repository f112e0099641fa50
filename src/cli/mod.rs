//! The command line: raw flags in `args`, their meaning in one file a command.

mod args;
mod breather;
mod compare;
mod dps;
mod drift;
mod figures;
mod integrators;
mod lifetimes;
mod orbits;
mod order;
mod report;
mod run;
mod scaling;
mod scenes;
mod signals;
mod stability;
mod theorem;
mod verify;
mod wave;

use crate::error::Result;
use args::{Cli, Command};
use clap::{CommandFactory, FromArgMatches, builder::ValueParser, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use std::{io::Write, process::ExitCode};

/// Reads the arguments, runs the command, says what went wrong.
pub fn main() -> ExitCode {
    let matches = doubles_checked(Cli::command()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    if let Some(set) = cli.instructions {
        // Sets that the machine lacks are no argument.
        let _ = set.select();
    }
    let outcome = match cli.command {
        Command::Compare(args) => compare::main(&args),
        Command::Run(args) => run::main(&args),
        Command::Order(args) => order::main(&args),
        Command::Scaling(args) => scaling::main(&args),
        Command::Drift(args) => drift::main(&args),
        Command::Dps(args) => dps::main(&args),
        Command::Breather(args) => breather::main(&args),
        Command::Dark(args) => orbits::dark(&args),
        Command::Continue(args) => orbits::branch(&args),
        Command::Doubled(args) => orbits::doubled(&args),
        Command::Lifetimes(args) => lifetimes::main(&args),
        Command::Evolve(args) => orbits::evolve(&args),
        Command::Stability(args) => stability::main(&args),
        Command::Wave(args) => wave::main(&args),
        Command::Theorem(args) => theorem::main(&args),
        Command::Verify(args) => verify::main(&args),
        Command::Figures(args) => figures::main(&args),
        Command::Report(args) => report::main(&args),
        Command::Scenes(args) => scenes::main(&args),
        Command::Integrators(args) => integrators::main(&args),
    };
    let code = outcome.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        ExitCode::FAILURE
    });
    signals::exit_code().map_or(code, ExitCode::from)
}

/// The command with every flag that takes a double refusing what a double cannot hold.
fn doubles_checked(command: clap::Command) -> clap::Command {
    let double = ValueParser::from(value_parser!(f64)).type_id();
    let command = command.mut_args(|arg| {
        if arg.get_value_parser().type_id() == double { arg.value_parser(crate::number::double) } else { arg }
    });
    command.mut_subcommands(doubles_checked)
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

/// Where results go: the folder asked for; `out/COMMAND-SCENE` by default.
fn default_folder(command: &str, scene: &str) -> String {
    let safe: String =
        scene.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '_' }).collect();
    format!("out/{command}-{safe}")
}

type Exit = Result<ExitCode>;
