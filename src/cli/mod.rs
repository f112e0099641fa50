//! The command line. Commands and their examples are in `args`, and `runner` runs all studies. The
//! flags of a study are the options that it declares itself.

mod args;
mod figures;
mod formats;
mod integrators;
mod python;
mod report;
mod run;
mod runner;
mod scenes;
mod shell;
mod signals;
mod terminal;

use crate::{
    error::{Error, Result},
    output::{PROGRAM, say},
    report::Report,
    study::Progress,
};
use clap::{
    ArgMatches, Command,
    error::{ContextKind, ContextValue, ErrorKind},
};
use hertzchain_integrators::{Error as Failure, Instructions};
pub use python::{in_python, studies};
use runner::Runs;
use std::{env, ffi::OsString};
use terminal::{columns, print, print_help, progress_bar};

/// Exit code of a command that is refused: because the command line is not understood (clap has the
/// same code), or because a value, a name or an input file breaks its rule.
const REFUSED: u8 = 2;
/// Exit code of a command that failed.
const FAILED: u8 = 1;
const DONE: u8 = 0;

/// Reads the arguments, the name of the program first, runs the command, says what went wrong, and
/// returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    if arguments.len() <= 1 {
        return print(&format!("{PROGRAM}{}", include_str!("first_steps.txt"))).map_or(FAILED, |()| DONE);
    }
    let ended =
        parsed(&arguments).map_or_else(|error| not_begun(&error, &arguments), |(set, command)| begun(set, &*command));
    // A signal has an exit code of its own, also if it has ended the command with an error.
    let code = ended.unwrap_or_else(|error| {
        say(&format!("error: {}", words(&error, &arguments)));
        code(&error)
    });
    signals::exit_code().unwrap_or(code)
}

/// The program as `clap` knows it: its commands, flags, and what `--help` says of them.
///
/// ```
/// assert!(hertzchain::cli::command().find_subcommand("run").is_some());
/// ```
pub fn command() -> Command {
    args::program()
}

/// The instructions that a command line names, and the command with its flags.
type Parsed = (Option<Instructions>, Box<dyn Runs>);

fn parsed(
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> std::result::Result<Parsed, clap::Error> {
    let command = command();
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    let matches =
        command.clone().try_get_matches_from(&arguments).map_err(|error| told(error, &command, &arguments))?;
    lists_checked(&command, &matches)?;
    Ok(args::read(&matches))
}

/// Flags and commands that left, and what to use instead: a line each.
const LEFT: &str = include_str!("left.txt");

/// A refusal of clap with a tip that helps: what is in the place of what left, or the commands
/// there are.
fn told(mut error: clap::Error, command: &Command, arguments: &[OsString]) -> clap::Error {
    let kind = match error.kind() {
        ErrorKind::UnknownArgument => ContextKind::InvalidArg,
        ErrorKind::InvalidSubcommand => ContextKind::InvalidSubcommand,
        _ => return error,
    };
    let below = arguments.iter().skip(1).map_while(|word| word.to_str());
    let reached = below.scan(command, |at, word| at.find_subcommand(word).inspect(|below| *at = below)).last();
    let all = reached.unwrap_or(command).get_subcommands().map(Command::get_name).collect::<Vec<_>>().join(", ");
    let left = error.get(kind).and_then(|name| LEFT.lines().find_map(|line| line.strip_prefix(&format!("{name}: "))));
    let tip = match left {
        Some(instead) => Some(format!("it has left; instead: {instead}")),
        None if kind == ContextKind::InvalidArg || error.get(ContextKind::SuggestedSubcommand).is_some() => None,
        None => Some(format!("one of {all}")),
    };
    error.remove(ContextKind::Suggested);
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Does the study of a command line, the name of the program first, and returns its report. Files
/// go to the folder of --out, as those of the command do, and to no other; nothing is printed. A
/// scene may be named by its TOML.
///
/// ```
/// let line = ["hertzchain", "dps", "integrals", "--b", "0.5", "--r", "0"].map(Into::into);
/// assert_eq!(hertzchain::cli::study(line, &|_, _| ())?.json()["g"], 0.0);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A command line that is refused, or that is no study; the errors of the study.
pub fn study(arguments: impl IntoIterator<Item = OsString>, progress: Progress<'_>) -> Result<Report> {
    let (set, command) = parsed(arguments).map_err(|error| refused(&error))?;
    prepare(set)?;
    command.report(progress)
}

/// What clap refuses, as an error of the library.
fn refused(error: &clap::Error) -> Error {
    if let Some(Error::Unknown { kind, name, hint }) = refusal(error) {
        return Error::Unknown { kind: kind.clone(), name: name.clone(), hint: hint.clone() };
    }
    let told =
        [ContextKind::InvalidArg, ContextKind::InvalidValue, ContextKind::ValidValue].map(|kind| error.get(kind));
    if let [Some(ContextValue::String(arg)), Some(ContextValue::String(value)), Some(ContextValue::Strings(known))] =
        told
    {
        let name = arg.trim_start_matches('-').split(' ').next().unwrap_or_default();
        return Error::unknown(name.to_owned(), value, known.iter().map(String::as_str));
    }
    let text = refusal(error).map_or_else(|| error.to_string(), ToString::to_string);
    let words = text.trim_start_matches("error: ").split("\n\n").next().unwrap_or_default();
    Error::Options(words.split_whitespace().collect::<Vec<_>>().join(" "))
}

fn begun(set: Option<Instructions>, command: &dyn Runs) -> Exit {
    prepare(set)?;
    signals::outlive_file_limits();
    signals::ask()?;
    command.run()
}

/// Settings of the whole process.
fn prepare(set: Option<Instructions>) -> Result<()> {
    threads_checked()?;
    if let Some(set) = set {
        // The flag's parser has refused sets that the machine lacks.
        let _ = set.select();
    }
    Ok(())
}

/// Refuses a number of threads that is none, for which the thread pool would take all cores.
fn threads_checked() -> Result<()> {
    const NAME: &str = "RAYON_NUM_THREADS";
    let text = env::var_os(NAME).unwrap_or_default();
    if text.is_empty() || text.to_str().is_some_and(|text| text.parse::<usize>().is_ok()) {
        return Ok(());
    }
    Err(Error::parameter(NAME, text.to_string_lossy(), "a whole number of threads, 0 for all cores"))
}

/// The message of an error. A value that a flag has given and that is refused is named as the flag.
fn words(error: &Error, arguments: &[OsString]) -> String {
    let text = error.to_string();
    let Some((name, rest)) = text.split_once(" = ").filter(|(_, rest)| rest.contains(" is not valid")) else {
        return text;
    };
    let flag = format!("--{}", name.replace('_', "-"));
    let given = |word: &str| word.strip_prefix(&flag).is_some_and(|rest| rest.is_empty() || rest.starts_with('='));
    if !arguments.iter().any(|word| word.to_str().is_some_and(given)) {
        return text;
    }
    rest.strip_prefix("true ").map_or_else(|| format!("{flag} = {rest}"), |rest| format!("{flag} {rest}"))
}

/// Prints help or the version, or says what is wrong with the command line.
fn not_begun(error: &clap::Error, arguments: &[OsString]) -> Exit {
    if !error.use_stderr() {
        return print_help(error).map(|()| DONE);
    }
    match refusal(error) {
        Some(refusal) => say(&format!("error: {}", words(refusal, arguments))),
        // The message repeats words of the command line.
        None if arguments.iter().any(|word| word.to_string_lossy().contains(char::is_control)) => {
            say(error.render().to_string().trim_end());
        }
        // An error here cannot be reported: standard error cannot be written.
        None => drop(error.print()),
    }
    Ok(REFUSED)
}

/// The exit code of an error: [`REFUSED`] for a value, a name or a file that was refused, otherwise
/// [`FAILED`].
fn code(error: &Error) -> u8 {
    match error {
        Error::Parameter { .. } | Error::Unknown { .. } | Error::Scene { .. } | Error::Content { .. } => REFUSED,
        Error::Integration(Failure::Argument { .. }) | Error::Options(_) => REFUSED,
        _ => FAILED,
    }
}

/// The library's own error inside an error of clap, if the library has refused a value.
fn refusal(error: &clap::Error) -> Option<&Error> {
    std::error::Error::source(error)?.downcast_ref()
}

/// Refuses a list that has an entry twice.
fn lists_checked(command: &clap::Command, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
    for arg in command.get_arguments().filter(|arg| arg.get_value_delimiter().is_some()) {
        let given = matches.get_raw(arg.get_id().as_str()).into_iter().flatten();
        let texts: Vec<String> = given.map(|text| text.to_string_lossy().trim().to_owned()).collect();
        let number = |text: &String| text.parse::<f64>().ok();
        let same = |a: &String, b: &String| a == b || number(a).is_some_and(|value| number(b) == Some(value));
        if let Some((_, twice)) =
            texts.iter().enumerate().find(|(k, text)| texts[..*k].iter().any(|one| same(one, text)))
        {
            let words = format!("--{}: {twice} is there twice", arg.get_long().unwrap_or_default());
            return Err(clap::Error::raw(ErrorKind::ValueValidation, words + "\n"));
        }
    }
    let below = matches.subcommand().and_then(|(name, below)| Some((command.find_subcommand(name)?, below)));
    below.map_or(Ok(()), |(command, matches)| lists_checked(command, matches))
}

/// An exit code, or the error that ended the command.
type Exit = Result<u8>;
