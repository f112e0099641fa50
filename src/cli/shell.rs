//! `hertzchain shell`: what a shell and `man` can be given.

use super::{
    DONE, Exit,
    args::{Cli, ManArgs, ShellAction, ShellArgs},
    print, say,
};
use crate::output::Folder;
use clap::{Command, CommandFactory};

pub(super) fn main(args: &ShellArgs) -> Exit {
    match &args.action {
        ShellAction::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "hertzchain", &mut script);
            print(&String::from_utf8_lossy(&script)).map(|()| DONE)
        }
        ShellAction::Man(args) => man(args),
    }
}

/// Writes a page for the program and for every command.
fn man(args: &ManArgs) -> Exit {
    let folder = Folder::own(&args.out, None)?;
    // A page shows the long help. Subcommands know their full name only after `build`.
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let count = pages(&program, &folder)?;
    say(&format!("{count} pages written to {}", folder.path().display()));
    Ok(DONE)
}

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
