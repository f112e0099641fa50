//! The module `hertzchain.studies` of the Python package, made of what `--help` says, and the names
//! that flags have in Python.

use super::runner::STUDY;
use crate::report::filled;
use clap::{Arg, ArgAction, Command, builder::ValueParser, value_parser};
use std::path::PathBuf;

const HEAD: &str = include_str!("studies_head.py");

/// Options of a process, and those of what is printed.
const OUTSIDE: [&str; 3] = ["engine", "instructions", "json"];

/// The text of the module.
pub fn studies() -> String {
    // Without the flags that clap adds; commands have the global flags of those above them.
    let mut program = super::command().disable_help_flag(true).disable_help_subcommand(true).disable_version_flag(true);
    program.build();
    HEAD.to_owned() + &functions("", &program)
}

/// The functions of the studies below a command.
fn functions(path: &str, command: &Command) -> String {
    let below = command.get_subcommands().map(|below| {
        let path = format!("{path} {}", below.get_name());
        let study = below.get_groups().any(|group| group.get_id() == STUDY);
        let own = if study { function(path.trim_start(), below) } else { String::new() };
        own + &functions(&path, below)
    });
    below.collect()
}

fn function(path: &str, command: &Command) -> String {
    let name = path.strip_prefix("study ").unwrap_or(path).replace([' ', '-'], "_");
    let options = || command.get_arguments().filter(|arg| !OUTSIDE.contains(&arg.get_long().unwrap_or_default()));
    let told = |first: bool| options().filter(move |arg| arg.is_positional() == first).map(parameter);
    let (operands, flags): (String, String) = (told(true).collect(), told(false).collect());
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let about: Vec<String> = about.split("\n\n").map(|words| paragraph(words, "    ")).collect();
    let helps: String = options()
        .map(|arg| {
            let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
            format!("    {} : {}\n{}", option_name(arg), kind(arg), paragraph(&help, "        "))
        })
        .collect();
    format!(
        "\n\ndef {name}(\n{operands}    *,\n{flags}    progress: Progress = False,\n) -> Study:\n    \"\"\"{}\n    \
         Parameters\n    ----------\n{helps}    progress : bool or callable\n        As in :func:`hertzchain.run`.\n    \
         \"\"\"\n    return called(\"{path}\", {name}, locals())\n",
        about.join("\n").trim_start(),
    )
}

/// A paragraph of a docstring, ended by a full stop.
fn paragraph(words: &str, indent: &str) -> String {
    let words = in_python(words.trim()).replace('\\', "\\\\");
    let end = if words.ends_with(['.', ':']) { "" } else { "." };
    filled(&(words + end), 100 - indent.len()).lines().map(|line| format!("{indent}{line}\n")).collect()
}

/// The type of the values of an option.
fn kind(arg: &Arg) -> String {
    let is = |parser: ValueParser| arg.get_value_parser().type_id() == parser.type_id();
    let whole: [ValueParser; 4] =
        [value_parser!(usize).into(), value_parser!(u32).into(), value_parser!(u64).into(), value_parser!(i64).into()];
    let names: Vec<String> = arg.get_possible_values().iter().map(|value| format!("{:?}", value.get_name())).collect();
    let one = match arg.get_id().as_str() {
        "scene" => "Scene | Chain | str".to_owned(),
        "set" => return "Mapping[str, Any] | Sequence[str]".to_owned(),
        _ if !arg.get_action().takes_values() || is(value_parser!(bool)) => "bool".to_owned(),
        _ if !names.is_empty() => format!("Literal[{}]", names.join(", ")),
        _ if is(value_parser!(f64).into()) => "float".to_owned(),
        _ if whole.into_iter().any(is) => "int".to_owned(),
        _ if is(value_parser!(PathBuf)) => "str | os.PathLike[str]".to_owned(),
        _ => "str".to_owned(),
    };
    if matches!(arg.get_action(), ArgAction::Append) { format!("{one} | Sequence[{one}]") } else { one }
}

/// A parameter of a function: name, type and default.
fn parameter(arg: &Arg) -> String {
    let (name, kind) = (option_name(arg), kind(arg));
    let number = |text: &str| kind.starts_with(['f', 'i']) && text.parse().is_ok_and(f64::is_finite);
    let value = |text: &str| if number(text) { text.to_owned() } else { format!("{text:?}") };
    let texts = arg.get_default_values().iter().map(|text| text.to_string_lossy());
    let default = match &*texts.collect::<Vec<_>>().join(",") {
        _ if !arg.get_action().takes_values() => " = False".to_owned(),
        "" if arg.is_required_set() => String::new(),
        "" => " | None = None".to_owned(),
        list if kind.contains("Sequence") => {
            let list: Vec<String> = list.split(',').map(value).collect();
            format!(" = ({}{})", list.join(", "), if list.len() == 1 { "," } else { "" })
        }
        text => format!(" = {}", value(text)),
    };
    format!("    {name}: {kind}{default},\n")
}

fn option_name(arg: &Arg) -> String {
    in_python_name(arg.get_long().unwrap_or(arg.get_id().as_str()))
}

fn in_python_name(flag: &str) -> String {
    if flag == "from" { "from_".to_owned() } else { flag.replace('-', "_") }
}

/// A text of the program with the names that options have in Python in place of flags.
///
/// ```
/// let text = "omega-b = 1 is not valid: give --from and --to";
/// assert_eq!(hertzchain::cli::in_python(text), "omega_b = 1 is not valid: give `from_` and `to`");
/// assert_eq!(hertzchain::cli::in_python("from is missing: give it"), "from_ is missing: give it");
/// ```
pub fn in_python(text: &str) -> String {
    let named = [" = ", " is missing: "].into_iter().find_map(|sign| {
        let (name, rest) = text.split_once(sign)?;
        let refused = !name.contains(' ') && (sign != " = " || rest.contains(" is not valid: "));
        refused.then(|| format!("{}{sign}{rest}", in_python_name(name)))
    });
    let text = named.unwrap_or_else(|| text.to_owned());
    let mut parts = text.split("--");
    let mut told = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(part.len());
        let (flag, rest) = part.split_at(end);
        let quoted = told.ends_with(['\'', '`']);
        let quote = if quoted { "" } else { "`" };
        // Elsewhere between backticks there is a command line.
        let plain = quoted || told.matches('`').count().is_multiple_of(2);
        let is_flag = plain && !flag.is_empty() && !told.ends_with(char::is_alphanumeric);
        told += &if is_flag { format!("{quote}{}{quote}{rest}", in_python_name(flag)) } else { format!("--{part}") };
    }
    told
}
