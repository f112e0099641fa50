//! Studies for programs, such as the Python package: by the words of their commands and the names
//! of their options, with a report in place of what is printed.

use super::{
    parsed, prepare, refusal,
    reference::{built, each},
    runner::{Runs, STUDY},
};
use crate::{
    error::{Error, Result},
    report::Report,
    study::Progress,
};
use clap::{Arg, ArgAction, Command, error::ContextKind};

/// Does a study and returns its report. Options are those of its command, with underscores; a
/// scene may also be its TOML. Files go to the folder of the option `out`, if it is given, as those
/// of the command do.
///
/// ```
/// use hertzchain::cli::study;
/// let report = study("dps integrals", &[("b", vec!["-1"]), ("r", vec!["0"])], &|_, _| ())?;
/// assert_eq!(report.json()["g"], 1.0);
/// let refused = study("dps integrals", &[("alpha", vec!["11"])], &|_, _| ()).unwrap_err();
/// assert!(refused.to_string().starts_with("alpha = 11 is not valid"));
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// An unknown study or option; values that are refused; the errors of the study.
pub fn study<S: AsRef<str>>(name: &str, options: &[(S, Vec<S>)], progress: Progress<'_>) -> Result<Report> {
    let program = built();
    let studies = studies(&program);
    let Some((_, command)) = studies.iter().find(|(path, _)| path == name) else {
        return Err(Error::unknown("study", name, studies.iter().map(|(path, _)| path.as_str())));
    };
    let mut line: Vec<String> = ["hertzchain"].into_iter().chain(name.split(' ')).map(str::to_owned).collect();
    let mut operands = Vec::new();
    for (option, values) in options {
        let mut values = values.iter().map(|value| value.as_ref().to_owned());
        let Some(arg) = options_of(command).find(|arg| option_name(arg) == option.as_ref()) else {
            let known: Vec<String> = options_of(command).map(option_name).collect();
            return Err(Error::unknown("option", option.as_ref(), known.iter().map(String::as_str)));
        };
        let (Some(flag), switch) = (arg.get_long(), matches!(arg.get_action(), ArgAction::SetTrue)) else {
            operands.extend(values);
            continue;
        };
        match arg.get_value_delimiter() {
            Some(comma) => line.push(format!("--{flag}={}", values.collect::<Vec<_>>().join(&comma.to_string()))),
            None if switch && values.all(|value| value == "false") => {}
            None if switch => line.push(format!("--{flag}")),
            None => line.extend(values.map(|value| format!("--{flag}={value}"))),
        }
    }
    if !operands.is_empty() {
        line.push("--".to_owned());
    }
    let cli = parsed(line.iter().chain(&operands)).map_err(|error| refused(&error))?;
    prepare(&cli)?;
    cli.command.report(progress)
}

/// The studies of the program, by the words of their commands.
pub(super) fn studies(program: &Command) -> Vec<(String, &Command)> {
    let mut all = Vec::new();
    each(program, "", &mut |path, command| {
        if command.get_groups().any(|group| group.get_id() == STUDY) {
            all.push((path.to_owned(), command));
        }
    });
    all
}

/// The options of a study. A program has JSON and text of the report.
pub(super) fn options_of(command: &Command) -> impl Iterator<Item = &Arg> {
    command.get_arguments().filter(|arg| arg.get_id() != "json")
}

/// The name of an option in a program: no word that Python has taken.
pub(super) fn option_name(arg: &Arg) -> String {
    in_python_name(arg.get_long().unwrap_or(arg.get_id().as_str()))
}

fn in_python_name(name: &str) -> String {
    if name == "from" { "from_".to_owned() } else { name.replace('-', "_") }
}

/// What clap refuses, in the words of the library.
fn refused(error: &clap::Error) -> Error {
    match refusal(error) {
        Some(Error::Parameter { name, value, rule }) => {
            return Error::Parameter { name, value: value.clone(), rule };
        }
        Some(Error::Unknown { kind, name, hint }) => {
            return Error::Unknown { kind, name: name.clone(), hint: hint.clone() };
        }
        _ => {}
    }
    let told = |kind| error.get(kind).map(ToString::to_string);
    let rule = std::error::Error::source(error).map(ToString::to_string);
    let rule = rule.or(told(ContextKind::ValidValue).map(|values| format!("one of {values}")));
    if let (Some(arg), Some(value), Some(rule)) =
        (told(ContextKind::InvalidArg), told(ContextKind::InvalidValue), rule)
    {
        let name = arg.trim_matches(['-', '<', '>', '[', ']']).split(' ').next().unwrap_or_default().to_lowercase();
        return Error::Options(format!("{name} = {value} is not valid: {rule}"));
    }
    let text = error.to_string();
    let words = text.trim_start_matches("error: ").split("\n\n").next().unwrap_or_default();
    Error::Options(words.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// A text of the program with the names that options have in Python in place of flags.
///
/// ```
/// use hertzchain::cli::in_python;
/// assert_eq!(in_python("omega-b = 1 is not valid: give --from and --to P"), "omega_b = 1 is not valid: give `from_` and `to`");
/// ```
pub fn in_python(text: &str) -> String {
    let named = text.split_once(" = ").filter(|(name, rest)| rest.contains(" is not valid: ") && !name.contains(' '));
    let (mut told, mut rest) = match named {
        Some((name, rest)) => (in_python_name(name) + " = ", rest),
        None => (String::new(), text),
    };
    while let Some((before, after)) = rest.split_once("--") {
        let end = after.find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(after.len());
        let (flag, more) = after.split_at(end);
        told += before;
        rest = more;
        if flag.is_empty() || before.ends_with(char::is_alphanumeric) {
            told = told + "--" + flag;
            continue;
        }
        let quote = if before.ends_with(['\'', '`']) { "" } else { "`" };
        told = told + quote + &in_python_name(flag) + quote;
        // The value that stands for all values of the flag.
        let next = more.strip_prefix(' ').unwrap_or_default();
        let word = &next[..next.find(|c: char| !c.is_ascii_uppercase() && !"<>/_".contains(c)).unwrap_or(next.len())];
        let whole = !next[word.len()..].starts_with(char::is_alphanumeric);
        if !word.is_empty() && whole {
            rest = &more[1 + word.len()..];
        }
    }
    told + rest
}
