//! `hertzchain shell`: what a shell can be given.

use super::{DONE, Exit, command, print, runner::Runs};
use crate::study::options::{one, options};
use clap_complete::Shell;

options! {
    pub(crate) struct Completions {
        /// The shell: bash, elvish, fish, powershell or zsh.
        shell: Option<Shell> = None, [required = true, hide_possible_values = true];
    }
}
one!(Shell);

impl Runs for Completions {
    fn run(&self) -> Exit {
        let mut script = Vec::new();
        self.shell.iter().for_each(|of| clap_complete::generate(*of, &mut command(), "hertzchain", &mut script));
        print(&String::from_utf8_lossy(&script)).map(|()| DONE)
    }
}
