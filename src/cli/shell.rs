//! `hertzchain shell`: what a shell can be given.

use super::{DONE, Exit, args::Cli, print, runner::Runs};
use clap::{CommandFactory, Subcommand};
use clap_complete::Shell;

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
}

impl Runs for ShellAction {
    fn run(&self) -> Exit {
        let (Self::Completions { shell }, mut script) = (self, Vec::new());
        clap_complete::generate(*shell, &mut Cli::command(), "hertzchain", &mut script);
        print(&String::from_utf8_lossy(&script)).map(|()| DONE)
    }
}
