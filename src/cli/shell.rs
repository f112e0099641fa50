//! `hertzchain shell`: what a shell and `man` can be given.

use super::{DONE, Exit, args::Cli, print, runner::Runs, say};
use crate::output::Folder;
use clap::{Command, CommandFactory, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;

#[derive(Subcommand)]
pub(crate) enum ShellAction {
    /// Print a script that completes commands and flags in a shell.
    ///
    /// Each shell has a place of its own for it; for bash that is a file called hertzchain in
    /// ~/.local/share/bash-completion/completions.
    #[command(
        after_long_help = "Example:\n  hertzchain shell completions fish > ~/.config/fish/completions/hertzchain.fish"
    )]
    Completions {
        /// The shell: bash, elvish, fish, powershell or zsh.
        #[arg(value_name = "SHELL", hide_possible_values = true)]
        shell: Shell,
    },
    /// Write manual pages: one for the program, one for each command.
    ///
    /// Files: hertzchain.1, hertzchain-run.1 and so on, for `man -l` or a folder man1 on the path
    /// of manuals.
    #[command(after_long_help = "Example:\n  hertzchain shell man --out ~/.local/share/man/man1")]
    Man {
        /// Write the results to this folder.
        #[arg(long, value_name = "DIR", default_value = "out/man")]
        out: PathBuf,
    },
}

impl Runs for ShellAction {
    fn run(&self) -> Exit {
        match self {
            Self::Completions { shell } => {
                let mut script = Vec::new();
                clap_complete::generate(*shell, &mut Cli::command(), "hertzchain", &mut script);
                print(&String::from_utf8_lossy(&script))?;
            }
            Self::Man { out } => {
                let folder = Folder::own(out, None)?;
                // A page shows the long help. Subcommands know their full name only after `build`.
                let mut program = Cli::command().disable_help_subcommand(true);
                program.build();
                let count = pages(&program, &folder)?;
                say(&format!("{count} pages written to {}", folder.path().display()));
            }
        }
        Ok(DONE)
    }
}

/// Writes a page for the program and for every command.
fn pages(command: &Command, folder: &Folder) -> crate::error::Result<usize> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name());
    let page = clap_mangen::Man::new(command.clone()).manual("hertzchain");
    folder.write_with(&format!("{name}.1"), |file| page.render(file))?;
    command.get_subcommands().try_fold(1, |count, below| Ok(count + pages(below, folder)?))
}

/// Text that is printed if no command is given.
pub(super) const FIRST_STEPS: &str = concat!(
    "hertzchain ",
    env!("CARGO_PKG_VERSION"),
    ": nonlinear waves in locally resonant Hertzian chains

Three commands to start with:
  hertzchain run impact --out out/impact   a struck chain: numbers, pictures
  hertzchain compare tw-q15                errors and times of the integrators
  hertzchain paper figures --only tw-q15   a figure of the paper, made anew

`hertzchain --help` lists all commands, `hertzchain COMMAND --help` its flags.
"
);
