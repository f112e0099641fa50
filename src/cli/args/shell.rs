//! Flags of `shell`.

use clap::{Args, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct ShellArgs {
    #[command(subcommand)]
    pub(crate) action: ShellAction,
}

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
    Man(ManArgs),
}

#[derive(Args)]
pub(crate) struct ManArgs {
    /// Write the results to this folder.
    #[arg(long, value_name = "DIR", default_value = "out/man")]
    pub(crate) out: PathBuf,
}
