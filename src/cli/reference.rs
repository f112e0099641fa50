//! Pages of the guide that are made of what `--help` says.

use super::args::Cli;
use clap::{Arg, Command, CommandFactory};

/// Flags that say the same in all commands that have them; `sweep` has them all.
const COMMON: [&str; 6] = ["out", "json", "format", "shard", "engine", "instructions"];

/// Calls `tell` with the name of each command, and the command.
fn each(command: &Command, path: &str, tell: &mut dyn FnMut(&str, &Command)) {
    for below in command.get_subcommands() {
        let path = format!("{path} {}", below.get_name());
        tell(path.trim_start(), below);
        each(below, &path, tell);
    }
}

/// The files of all commands with the columns of their tables, as `docs/columns.md` has them: what
/// `--help` says of `--out`.
pub fn columns() -> String {
    let mut text = "# Files and columns\n\nGenerated: what `--help` says of `--out`.\n".to_owned();
    each(&Cli::command(), "", &mut |path, command| {
        let out = command.get_arguments().find(|arg| arg.get_id() == "out").and_then(Arg::get_long_help);
        let files = out.map(ToString::to_string).unwrap_or_default();
        if let Some(at) = files.find("Files: ").filter(|_| files.contains(".npz with an array")) {
            text += &format!("\n## {path}\n\n{}\n", files[at..].trim_end());
        }
    });
    text
}

/// The flags of all commands with defaults and ranges, as `docs/options.md` has them.
pub fn options() -> String {
    let command = Cli::command();
    // A folder by default is that of one command.
    let own_folder = |arg: &Arg| arg.get_id() == "out" && !arg.get_default_values().is_empty();
    let common = |arg: &&Arg| COMMON.contains(&arg.get_id().as_str()) && !own_folder(arg);
    let mut text = "# Options\n\nGenerated: what `--help` says of the flags of each command.\n".to_owned();
    let sweep = command.find_subcommand("sweep").into_iter().flat_map(Command::get_arguments);
    text += &section("Common options", "", sweep.chain(command.get_arguments()).filter(common), false);
    each(&command, "", &mut |path, command| {
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let own = command.get_arguments().filter(|arg| !common(arg));
        text += &section(path, &about, own, true);
    });
    text
}

fn section<'a>(name: &str, about: &str, arguments: impl Iterator<Item = &'a Arg>, whole: bool) -> String {
    let rows: String = arguments.map(|arg| row(arg, whole)).collect();
    let about = if about.is_empty() { String::new() } else { format!("{about}.\n\n") };
    if rows.is_empty() {
        return String::new();
    }
    format!("\n## {name}\n\n{about}| flag | default | meaning |\n|---|---|---|\n{rows}")
}

/// A row of a table: the flag with its value, the default, and its help, `whole` or in short.
fn row(arg: &Arg, whole: bool) -> String {
    let values = arg.get_value_names().unwrap_or_default().join(" ");
    let flag = arg.get_long().map_or(String::new(), |long| format!("--{long} "));
    let value = if arg.get_action().takes_values() { &*values } else { "" };
    let default: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    let long = arg.get_long_help().filter(|_| whole);
    let help = long.or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
    let words: Vec<&str> = help.split_whitespace().collect();
    let one_of: Vec<_> = arg.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
    let told = value.is_empty() || one_of.iter().all(|name| help.contains(name.as_str()));
    let one_of = if told { String::new() } else { format!(" One of {}.", one_of.join(", ")) };
    let cells = [
        format!("`{}`", (flag + value).trim_end()),
        default.join(","),
        words.join(" ").trim_end_matches('.').to_owned() + "." + &one_of,
    ];
    format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | ").replace("|  |", "| |"))
}
