//! The one way in which studies run: folder, progress bar, signals, what is printed, files, exit
//! code.

use super::{DONE, Exit, FAILED, print, progress_bar, say, signals};
use crate::{
    error::Result,
    output::{Folder, to_json},
    study::{Report, Study, Work},
};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, value_parser};
use std::path::PathBuf;

/// What `--out` says everywhere.
const OUT: &str = "Write the results to this folder; without it, no file is written";

/// A study with where its results go.
pub(super) struct Told<S> {
    study: S,
    out: Option<PathBuf>,
    json: bool,
}

impl<S: Study> Told<S> {
    pub(super) fn run(&self) -> Exit {
        let work = self.study.begin()?;
        let folder = self.out.clone().or_else(|| self.study.beside()).map(Folder::create).transpose()?;
        if S::STOPS {
            signals::ask()?;
        }
        carry_out(work, folder, self.json, &S::sometimes())
    }
}

impl<S: Study + Args> Args for Told<S> {
    fn augment_args(command: Command) -> Command {
        with_outputs(S::augment_args(command), S::FILES)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: FromArgMatches> FromArgMatches for Told<S> {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        let out = matches.try_get_one("out").ok().flatten().cloned();
        Ok(Self { study: S::from_arg_matches(matches)?, out, json: matches.get_flag("json") })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
        Self::from_arg_matches(matches).map(|told| *self = told)
    }
}

/// Adds `--out`, for a study that writes files, and `--json`.
fn with_outputs(command: Command, files: &'static str) -> Command {
    let out = Arg::new("out").long("out").value_name("DIR").value_parser(value_parser!(PathBuf)).help(OUT);
    let json = Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print JSON instead of text");
    if files.is_empty() {
        return command.arg(json);
    }
    command.arg(out.long_help(format!("{OUT}.\n\n{files}"))).arg(json)
}

/// Does the work of a study, prints what came of it and writes its files, in place of those that an
/// earlier run may have `left`.
fn carry_out(work: Work<'_>, folder: Option<Folder>, json: bool, left: &[String]) -> Exit {
    let bar = progress_bar();
    let report = work(folder.as_ref(), &|share, what| {
        bar.set_position((1000.0 * share.min(1.0)) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    let report = report?;
    if let Some(remark) = report.remark() {
        say(&remark);
    }
    let text = to_json(&report.json());
    // What was computed is not lost if a file cannot be written, nor if it cannot be printed.
    let printed = print(&if json { format!("{text}\n") } else { report.text() });
    if let Some(folder) = folder {
        folder.remove(left.iter().map(String::as_str))?;
        write(&folder, &*report, &text)?;
    }
    printed.map(|()| if report.succeeded() { DONE } else { FAILED })
}

fn write(folder: &Folder, report: &dyn Report, json: &str) -> Result<()> {
    for (name, bytes) in report.files(json)? {
        folder.write(&name, &bytes)?;
    }
    #[cfg(feature = "plot")]
    for (name, bytes) in report.pictures()? {
        folder.write(&name, &bytes)?;
    }
    say(&format!("written to {}", folder.path().display()));
    Ok(())
}
