//! The module `hertzchain.studies` of the Python package: a function for each study, made of what
//! `--help` says.

use super::{
    door::{self, in_python, option_name, options_of},
    reference::built,
};
use crate::report::filled;
use clap::{Arg, ArgAction, Command, builder::ValueParser, value_parser};
use std::path::PathBuf;

const HEAD: &str = "\
\"\"\"The studies of the program, a function for each, with its options as arguments.

Generated: what ``--help`` says. Texts name tables and files that ``Study.tables`` and
``Study.save`` have. What is not given has the default of the program.

Examples
--------
>>> from hertzchain import studies
>>> studies.dps_integrals(b=-1.0, r=0.0).record[\"g\"]
1.0
\"\"\"

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from ._chain import Scene
from ._progress import Progress
from ._study import Study, called
";

/// Options of a process, not of a study in it.
const OUTSIDE: [&str; 2] = ["engine", "instructions"];

/// The text of the module.
pub fn studies() -> String {
    let program = built();
    let functions: Vec<String> = door::studies(&program).iter().map(|(path, command)| function(path, command)).collect();
    format!("{HEAD}{}", functions.concat())
}

fn function(path: &str, command: &Command) -> String {
    let name = path.strip_prefix("study ").unwrap_or(path).replace([' ', '-'], "_");
    let options: Vec<&Arg> = options_of(command).filter(|arg| !OUTSIDE.contains(&arg.get_id().as_str())).collect();
    let (operands, flags): (Vec<&Arg>, Vec<&Arg>) = options.iter().partition(|arg| arg.is_positional());
    let told = |args: &[&Arg]| args.iter().map(|arg| format!("    {},\n", parameter(arg))).collect::<String>();
    let (operands, flags) = (told(&operands), told(&flags));
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let about: Vec<String> = about.split("\n\n").map(|paragraph| paragraph_of(paragraph, "    ")).collect();
    let help = |arg: &&Arg| {
        let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
        format!("    {} : {}\n{}", option_name(arg), kind(arg), paragraph_of(help.trim_end_matches('.'), "        "))
    };
    let helps: String = options.iter().map(help).collect();
    format!(
        "\n\ndef {name}(\n{operands}    *,\n{flags}    progress: Progress = False,\n) -> Study:\n    \"\"\"{}\n    \
         Parameters\n    ----------\n{helps}    progress : bool or callable\n        As in :func:`hertzchain.run`.\n    \
         \"\"\"\n    return called(\"{path}\", {name}, locals())\n",
        about.join("\n").trim_start().to_owned() + "\n",
    )
}

/// A paragraph of a docstring, ended by a full stop.
fn paragraph_of(words: &str, indent: &str) -> String {
    let words = in_python(words.trim()).replace('\\', "\\\\");
    let end = if words.ends_with(['.', ':']) { "" } else { "." };
    filled(&(words + end), 100 - indent.len()).lines().map(|line| format!("{indent}{line}\n")).collect()
}

/// The type of the values of an option.
fn kind(arg: &Arg) -> String {
    let is = |parser: ValueParser| arg.get_value_parser().type_id() == parser.type_id();
    let whole = [is(value_parser!(usize).into()), is(value_parser!(u32).into()), is(value_parser!(u64).into())];
    let names: Vec<String> = arg.get_possible_values().iter().map(|value| format!("{:?}", value.get_name())).collect();
    let one = match arg.get_id().as_str() {
        "scene" => "Scene | str".to_owned(),
        "set" => return "Mapping[str, Any] | Sequence[str]".to_owned(),
        _ if !arg.get_action().takes_values() || is(value_parser!(bool)) => "bool".to_owned(),
        _ if !names.is_empty() => format!("Literal[{}]", names.join(", ")),
        _ if is(value_parser!(f64).into()) => "float".to_owned(),
        _ if whole.contains(&true) || is(value_parser!(i64).into()) => "int".to_owned(),
        _ if is(value_parser!(PathBuf)) => "str | os.PathLike[str]".to_owned(),
        _ => "str".to_owned(),
    };
    if matches!(arg.get_action(), ArgAction::Append) { format!("{one} | Sequence[{one}]") } else { one }
}

/// An argument of a function: name, type and default.
fn parameter(arg: &Arg) -> String {
    let (name, kind) = (option_name(arg), kind(arg));
    let number = kind.starts_with("float") || kind.starts_with("int");
    let value = |text: &str| match text {
        "true" if kind == "bool" => "True".to_owned(),
        "false" if kind == "bool" => "False".to_owned(),
        text if number && text.parse().is_ok_and(f64::is_finite) => text.to_owned(),
        text if number => format!("float({text:?})"),
        text => format!("{text:?}"),
    };
    let defaults = arg.get_default_values().iter().map(|text| text.to_string_lossy());
    let defaults = defaults.collect::<Vec<_>>().join(",");
    match &*defaults {
        _ if !arg.get_action().takes_values() => format!("{name}: {kind} = False"),
        "" if arg.is_required_set() => format!("{name}: {kind}"),
        "" => format!("{name}: {kind} | None = None"),
        list if kind.contains("Sequence") => {
            let values: String = list.split(',').map(|text| value(text) + ", ").collect();
            format!("{name}: {kind} = ({})", values.trim_end_matches(' '))
        }
        text => format!("{name}: {kind} = {}", value(text)),
    }
}
