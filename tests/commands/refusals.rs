//! What a command line cannot say, of all commands: the value, the rule and what would be right.
//! Ranges that the help of a flag states are held by `tolerances.rs`, numbers that no flag can take
//! by `bad_files.rs`, whole messages by the golden net.

use super::program::{json, names, refused};
use std::fs;

#[test]
fn a_number_of_three_hundred_digits_is_said_in_a_few() {
    let digits = format!("1{}.0", "0".repeat(300));
    for (scene, set) in [
        ("impact", format!("initial.velocity={digits}")),
        ("impact", format!("chain.alpha=-{digits}")),
        ("impact", format!("beads.mass=-{digits}")),
        ("granular-crystal", format!("beads.tau=-{digits}")),
        ("granular-crystal", format!("bonds.contact=-{digits}")),
        ("end-driven", format!("drive=[{{site=0, kind=\"moved\", band=[{digits}, 1], amplitude=1}}]")),
    ] {
        let said = refused(&["run", scene, "--set", &set], 2);
        assert!(said.len() < 400 && said.contains("1e300"), "{set}: {said}");
    }
    let run = json(&["study", "bands", "granular-crystal", "--set", "units.radius=1e30"]);
    let doubt = run["warnings"][0].as_str().unwrap();
    assert!(doubt.contains("units.radius = 1e30 m: more than 1 m; if it is in mm, write 1e27"), "{doubt}");
}

#[test]
fn what_does_not_depend_on_the_initial_state_does_not_ask_for_it() {
    // Truth: the same with an initial state.
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, initial: &str| {
        let text = format!(
            "[chain]\nsites = 6\nalpha = 1.5\nboundary = \"fixed\"\nprecompression = 0.1\n{initial}[span]\nuntil = 1.0\n"
        );
        let path = folder.path().join(name).display().to_string();
        fs::write(&path, text).unwrap();
        path
    };
    let with = file("a.toml", "[initial]\nkind = \"single-bead\"\nsite = 3\nvelocity = 0.1\n");
    let without = file("b.toml", "");
    for (study, key) in [("bands", "bands"), ("modes", "linear"), ("response", "rows")] {
        let [a, b] = [&with, &without].map(|path| json(&["study", study, path])[key].clone());
        assert!(a == b && a.is_array(), "{study}: {a}");
    }
    assert!(refused(&["run", &without], 2).contains("missing field `initial`"));
    let set = ["study", "modes", &without, "--set", "initial.kind=single-bead", "--set", "initial.site=9"];
    assert!(refused(&set, 2).contains("site = 9 is not valid"));
}
/// The rows of a table in `tests/refusals`, without its comments; `\n` is the end of a line.
pub(crate) fn rows(table: &str) -> impl Iterator<Item = String> {
    table.lines().filter(|row| !row.is_empty() && !row.starts_with('#')).map(|row| row.replace("\\n", "\n"))
}

#[test]
fn what_a_command_line_cannot_say_is_refused_by_value_and_rule() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/refusals");
    let scratch = tempfile::tempdir().unwrap();
    let out = scratch.path().join("out").display().to_string();
    let mut wrong = Vec::new();
    for row in rows(include_str!("../refusals/commands.txt")) {
        let (line, words) = row.split_once(" => ").unwrap();
        let (code, line) = line.split_once(' ').unwrap();
        let word = |word: &str| match word.strip_prefix('@') {
            Some(file) => format!("{folder}/{file}"),
            None => word.replace("OUT", &out).replace('·', " "),
        };
        let args: Vec<String> = line.split(' ').map(word).collect();
        let said = refused(&args.iter().map(String::as_str).collect::<Vec<_>>(), code.parse().unwrap());
        // No word of the compiler; no folder for what is refused.
        let clean = !said.contains("f64") && !said.contains("usize") && names(scratch.path()).is_empty();
        if !clean || !said.contains(words) {
            wrong.push(format!("{row}\n  {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.concat());
}

#[test]
#[cfg(not(feature = "mpi"))]
fn ranks_are_refused_where_they_were_not_compiled() {
    let line = "study lifetimes --epsilons 0.1 --rhos 5,10 --sites 20 --until 25 --out nowhere --engine mpi";
    assert!(refused(line, 2).contains("cargo build --release --features mpi"));
}
