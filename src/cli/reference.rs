//! Pages of the guide that are made of what `--help` says.

use super::args::Cli;
use clap::{Arg, Command, CommandFactory};

/// Flags that say the same in many commands; `sweep` has them all.
const COMMON: [&str; 6] = ["--format", "--out", "--json", "--shard", "--engine", INSTRUCTIONS];
/// The flag that every command has.
const INSTRUCTIONS: &str = "--instructions";
const HEAD: &str = "| flag | default | meaning |\n|---|---|---|\n";
const ABOUT: &str = "\
Generated: what `--help` says of the flags of each command. Every command has `--help` and
`--instructions`; the other common options are named where a command has them.
";

/// Calls `tell` with the name of each command, and the command.
pub(super) fn each<'a>(command: &'a Command, path: &str, tell: &mut dyn FnMut(&str, &'a Command)) {
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
        // Columns stand after the name of their table.
        if let Some(at) = files.find("Files: ").filter(|_| files.contains(".csv: ")) {
            text += &format!("\n## {path}\n\n{}\n", files[at..].trim_end());
        }
    });
    text
}

/// The program without the flags that clap adds; its commands have the global flags of those above.
pub(super) fn built() -> Command {
    let mut command = Cli::command().disable_help_flag(true).disable_help_subcommand(true).disable_version_flag(true);
    command.build();
    command
}

/// The flags of all commands with defaults and ranges, as `docs/options.md` has them.
pub fn options() -> String {
    let command = built();
    let name = |arg: &Arg| format!("--{}", arg.get_long().unwrap_or_default());
    let sweep = command.find_subcommand("sweep").into_iter().flat_map(Command::get_arguments);
    let rows: Vec<String> = sweep.filter(|arg| COMMON.contains(&&*name(arg))).map(|arg| row(arg, false)).collect();
    let common = |arg: &&Arg| rows.contains(&row(arg, false));
    let mut text = format!("# Options\n\n{ABOUT}\n## Common options\n\n{HEAD}{}", rows.concat());
    each(&command, "", &mut |path, command| {
        if command.is_subcommand_required_set() {
            return;
        }
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let names = command.get_arguments().filter(|arg| common(arg) && name(arg) != INSTRUCTIONS);
        let names: Vec<String> = names.map(|arg| format!("`{}`", name(arg))).collect();
        let names = if names.is_empty() { String::new() } else { format!(" Common options: {}.", names.join(", ")) };
        let own: String = command.get_arguments().filter(|arg| !common(arg)).map(|arg| row(arg, true)).collect();
        let table = if own.is_empty() { own } else { format!("\n{HEAD}{own}") };
        text += &format!("\n## {path}\n\n{about}.{names}\n{table}");
    });
    text
}

/// A row of a table: the flag with its value, the default, and its help, `whole` or in short.
fn row(arg: &Arg, whole: bool) -> String {
    let values = arg.get_value_names().unwrap_or_default().join(" ");
    let flag = arg.get_long().map_or(String::new(), |long| format!("--{long} "));
    let value = if arg.get_action().takes_values() { &*values } else { "" };
    let default = arg.get_default_values().iter().filter(|_| !value.is_empty());
    let default: Vec<_> = default.map(|value| value.to_string_lossy()).collect();
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
    let cell =
        |text: &String| if text.is_empty() { " |".to_owned() } else { format!(" {} |", text.replace('|', "\\|")) };
    format!("|{}\n", cells.iter().map(cell).collect::<String>())
}
