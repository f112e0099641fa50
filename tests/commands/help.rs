//! What the program says of itself: commands, help that fits a terminal, examples, old names.

use super::program::{self, names};
use std::{collections::BTreeMap, process::Output};

/// Lines and columns of a terminal that `-h` must fit.
const SCREEN: (usize, usize) = (40, 79);

fn hertzchain(args: &[&str]) -> Output {
    program::command(args).env_remove("COLUMNS").output().unwrap()
}

pub(crate) fn help(path: &[String], flag: &str) -> String {
    let args: Vec<&str> = path.iter().map(String::as_str).chain([flag]).collect();
    let output = hertzchain(&args);
    assert!(output.status.success() && output.stderr.is_empty(), "{args:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The commands that the help of a command lists.
fn listed(help: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.map(|line| line.split_whitespace().next().unwrap().to_owned()).filter(|name| name != "help").collect()
}

/// Every command with those above it, as the help tells them.
pub(crate) fn commands() -> Vec<Vec<String>> {
    let mut all = vec![Vec::new()];
    let mut next = 0;
    while let Some(path) = all.get(next).cloned() {
        all.extend(listed(&help(&path, "-h")).into_iter().map(|name| [&path[..], &[name]].concat()));
        next += 1;
    }
    all
}

#[test]
fn short_help_fits_a_screen_and_long_help_has_examples() {
    let mut seen = 0;
    for path in commands() {
        let (short, long) = (help(&path, "-h"), help(&path, "--help"));
        assert!(short.lines().count() <= SCREEN.0, "{path:?}: {} lines", short.lines().count());
        for line in short.lines().chain(long.lines()) {
            assert!(line.chars().count() <= SCREEN.1, "{path:?}: {line}");
        }
        let example = format!("  hertzchain {}", path.join(" "));
        assert!(long.contains(example.trim_end()) && !short.contains("Example"), "{path:?}: {long}");
        assert!(long.len() > short.len(), "{path:?}: the long help says more");
        for decimals in ["0.00000", "0000000"] {
            assert!(!short.contains(decimals), "{path:?}: {short}");
        }
        seen += 1;
    }
    assert_eq!(seen, 45, "the program, thirteen commands, and those below them");
}

#[test]
fn help_is_as_narrow_as_the_terminal() {
    let output = program::command("run --help").env("COLUMNS", "50").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    // Names of flags and examples are never broken.
    let prose = text.lines().filter(|line| line.starts_with("          "));
    assert!(prose.clone().count() > 50 && prose.clone().all(|line| line.chars().count() <= 50), "{text}");
}

#[test]
fn nothing_is_written_unless_a_folder_is_given() {
    for line in [
        "run tw-q15 --until 3",
        "compare precompressed --integrators verlet --max-time 0.2",
        "study theorem --epsilons 0.3,0.2 --horizon 0.1",
        "study drift cradle --periods 5 --samples 3",
        "wave tw-q15 --until 3",
        "dps dark --sites 5",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let output = program::command(line).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !output.stdout.is_empty(), "{line}: {said}");
        assert!(!said.contains("written to") && names(folder.path()).is_empty(), "{line}");
    }
}

#[test]
fn without_a_command_it_names_three_to_start_with() {
    let output = hertzchain(&[]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && output.stderr.is_empty());
    let examples: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("  hertzchain ")).collect();
    let names = commands();
    assert_eq!(examples.len(), 3);
    for example in examples {
        assert!(names.iter().any(|path| !path.is_empty() && example.starts_with(&path.join(" "))), "{example}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= SCREEN.1), "{text}");
}

#[test]
fn completions_know_the_flags() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = hertzchain(&["shell", "completions", shell]);
        let script = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && script.contains("steps-per-period"), "{shell}");
    }
    assert_eq!(hertzchain(&["shell", "completions", "sh"]).status.code(), Some(2));
}

/// Flags that mean one thing in one command and another in the next.
const OF_THEIR_OWN: &[&str] =
    &["from", "to", "step", "epsilon", "amplitude", "turns", "only", "c", "instructions", "engine", "format", "tol"];

fn every(command: &clap::Command, path: &str, visit: &mut dyn FnMut(&str, &clap::Command)) {
    let path = format!("{path} {}", command.get_name());
    visit(&path, command);
    command.get_subcommands().filter(|one| one.get_name() != "help").for_each(|one| every(one, &path, visit));
}

#[test]
fn a_flag_is_said_in_the_same_words_everywhere() {
    let mut words: BTreeMap<(String, bool), (String, String)> = BTreeMap::new();
    let mut shared = 0;
    every(&hertzchain::cli::command(), "", &mut |path, command| {
        for arg in command.get_arguments() {
            let Some(long) = arg.get_long().filter(|long| !OF_THEIR_OWN.contains(long)) else { continue };
            let help = arg.get_help().expect("every flag is explained").to_string();
            let said = help.split(" [default").next().unwrap_or_default().to_owned();
            // Lists are not numbers.
            let key = (long.to_owned(), arg.get_value_delimiter().is_some());
            match words.get(&key) {
                Some((first, other)) => {
                    assert_eq!((&said, shared += 1), (other, ()), "--{long} of{path} and of{first}");
                }
                None => drop(words.insert(key, (path.to_owned(), said))),
            }
        }
    });
    assert!(shared > 50, "{shared} flags were compared");
}

#[test]
fn examples_are_commands_that_the_program_takes() {
    let mut seen = 0;
    every(&hertzchain::cli::command(), "", &mut |path, command| {
        let help = command.get_after_long_help().unwrap_or_else(|| panic!("{path} has no example")).to_string();
        let joined = help.replace("\\\n", " ");
        let examples = joined.lines().filter_map(|line| line.strip_prefix("  hertzchain "));
        let name = path.trim().trim_start_matches("hertzchain").trim();
        let mut own = 0;
        for example in examples {
            own += usize::from(example.starts_with(name));
            // What the shell does with the output is no argument.
            let words = example.split(" > ").next().unwrap_or_default();
            let words = words.split_whitespace().map(|word| word.trim_matches('\''));
            let taken = hertzchain::cli::command().try_get_matches_from(["hertzchain"].into_iter().chain(words));
            assert!(taken.is_ok(), "{example}: {}", taken.unwrap_err());
        }
        assert!(own > 0, "{path} has no example of its own: {help}");
        seen += own;
    });
    assert!(seen > 30, "{seen} examples were parsed");
}
