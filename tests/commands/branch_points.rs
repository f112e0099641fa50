//! Multipliers and bifurcations of branches as points: shards on other threads, kills, signals,
//! branches that changed.

use super::{
    program::{files, lines, printed, read_json, terminate, wait},
    refusals::rows,
    shards::{command, in_shards, output},
};
use serde_json::Value;
use std::{fs, path::Path, process::Stdio};

/// A branch with period doublings and a collision, in six segments.
pub(crate) const DARK: &str =
    "breather continue --center bond --sites 9 --from 2.03 --to 2.1 --step 0.004 --bifurcations";
/// One that takes seconds.
const LONG: &str = "breather continue --center bond --sites 15 --from 2.03 --to 2.1 --step 0.001 --bifurcations";
const STORE: &str = "spectra.store";

/// A branch with a period doubling; the branch that crosses there has two folds and one more.
pub(crate) const DRIVEN: &str = concat!(
    "orbit continue ",
    env!("CARGO_MANIFEST_DIR"),
    "/tests/reference/pushed-bead.toml --to 2 --step 0.1 --switch 1"
);
/// A branch with two period doublings, and the one that crosses at the first.
pub(crate) const MODE: &str = concat!(
    "orbit mode ",
    env!("CARGO_MANIFEST_DIR"),
    "/tests/reference/two-beads.toml --linear-mode 2 --to 0.32 --step 0.02 --switch 1"
);

/// A branch of exact waves in a cradle, whose mass ratio is infinite.
const CRADLE: &str = "wave continue --sites 10 --rho inf --vary amplitude --amplitude 0.1 --to 0.12 --step 0.004";

/// A branch that is proved, in three strips.
pub(crate) const PROVED: &str = "wave continue --sites 10 --to 2.00103 --step 1e-5 --multipliers=false --prove";

fn run(line: &str, out: &Path, more: &[&str]) -> String {
    printed(output(line, out, more))
}

/// All files but the store, which may have rows of other branches.
fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    files(folder).into_iter().filter(|(name, _)| !name.ends_with(".store")).collect()
}

#[test]
fn branches_in_three_shards_have_the_files_of_one_process() {
    [DARK, DRIVEN, MODE, PROVED].into_iter().for_each(in_shards);
    // Strips are what is shared where no multipliers are asked for.
    let folder = tempfile::tempdir().unwrap();
    for (line, store) in [(PROVED, "proof"), (&PROVED.replace("s=false", "s"), "wave-spectra")] {
        let part: Value = serde_json::from_str(&run(line, folder.path(), &["--shard", "2/3", "--json"])).unwrap();
        assert!(part["store"].as_str().unwrap().ends_with(&format!("{store}.shard-2-of-3.store")), "{part}");
    }
}

fn points(folder: &Path, name: &str) -> Vec<Value> {
    let told: Value = serde_json::from_slice(&fs::read(folder.join(name)).unwrap()).unwrap();
    let points = if name == "waves.json" { "waves" } else { "points" };
    told[points].as_array().unwrap().clone()
}

// Truth: the branch that was followed at once, with its multipliers.
#[test]
fn orbits_of_modes_and_waves_alone_go_on_from_their_file_to_the_same_bytes() {
    let mode = MODE.replace("0.32 --step 0.02 --switch 1", "0.14 --step 0.02");
    // Its waves vanish at omega, before the last value.
    let vanished = "wave continue --sites 10 --omega-tw 2.0002 --to 1.9 --step 0.001";
    go_on_to_the_same_bytes([mode, CRADLE.to_owned(), vanished.to_owned()].into_iter());
}

#[test]
#[ignore = "nightly: a minute"]
fn orbits_alone_of_every_family_and_scene_go_on_from_their_file_to_the_same_bytes() {
    let place = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/");
    go_on_to_the_same_bytes(rows(include_str!("../reference/branches.txt")).map(|row| row.replace('@', place)));
}

/// Goes on from the file of a part of each branch, and from that of the whole, which stays as it is.
fn go_on_to_the_same_bytes(lines: impl Iterator<Item = String>) {
    for line in lines {
        let line = line.as_str();
        let (json, growth) = match line.split_once(' ').unwrap().0 {
            "wave" => ("waves.json", "growth"),
            "breather" => ("branch.json", "max_modulus"),
            _ if line.starts_with("orbit mode") => ("mode.json", "max_modulus"),
            _ => ("driven-branch.json", "max_modulus"),
        };
        let [whole, parts, again] = [0; 3].map(|_| tempfile::tempdir().unwrap());
        let [whole, parts, again] = [&whole, &parts, &again].map(|folder| folder.path());
        let code = output(line, whole, &[]).status.code();
        // Orbits alone, up to the fourth.
        let alone = line.replace(" --switch 1", "").replace(" --bifurcations", "");
        let ended = output(&alone, parts, &["--multipliers=false", "--max-points", "4"]);
        assert_eq!(ended.status.code(), Some(1), "{line}: {}", String::from_utf8_lossy(&ended.stderr));
        let (some, all) = (points(parts, json), points(whole, json));
        assert!(some.len() == 4 && all.len() > 5 && all[0][growth].is_number(), "{line}: {some:?}");
        for (one, other) in some.iter().zip(&all) {
            assert!(one[growth].is_null() && one["residual"] == other["residual"], "{line}: {one}");
            for measured in ["k_x", "response", "energy", "closed", "parameter", "amplitude"] {
                assert_eq!(one[measured], other[measured], "{line}: {measured}");
            }
        }
        let command = line.split(' ').take(2).collect::<Vec<_>>().join(" ");
        let more = [["--switch", "1"].as_slice(), &["--bifurcations"], &["--dimensionless"]];
        let more = more.into_iter().find(|more| line.contains(&more.join(" "))).unwrap_or_default();
        for (from, out) in [(parts, parts), (whole, again)] {
            let resumed = output(&format!("{command} --resume {}", from.display()), out, more);
            assert_eq!(resumed.status.code(), code, "{line}: {}", String::from_utf8_lossy(&resumed.stderr));
            assert!(results(whole) == results(out), "{line}");
        }
    }
}

#[test]
fn a_branch_in_the_mass_ratio_begins_with_the_usual_frequency_at_its_first_value() {
    let folder = tempfile::tempdir().unwrap();
    let line = "breather continue --vary rho --from 3 --to 3.001 --step 0.001 --sites 5 --json";
    let told: Value = serde_json::from_str(&run(line, folder.path(), &[])).unwrap();
    let omega_b = told["points"][0]["omega_b"].as_f64().unwrap();
    assert!((omega_b / (1.025 * (1.0_f64 + 1.0 / 3.0).sqrt()) - 1.0).abs() < 1e-15, "{omega_b}");
}

#[test]
fn a_single_orbit_is_a_branch_of_one_that_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    run("breather dark --center bond --sites 9 --omega-b 2.03", out, &[]);
    let line = format!("breather continue --resume {}/dark-breather.npz --to 2.1 --step 0.004", out.display());
    let branch: Value = serde_json::from_str(&run(&line, &out.join("branch"), &["--bifurcations", "--json"])).unwrap();
    assert!(branch["points"].as_array().unwrap().len() > 15 && branch["end"] == "reached", "{branch}");
    assert_eq!(branch["bifurcations"].as_array().unwrap().len(), 3);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/pushed-bead.toml");
    run(&format!("orbit driven {scene}"), out, &[]);
    let line = format!("orbit continue --resume {}/driven-orbit.npz --to 2 --step 0.1", out.display());
    let branch: Value = serde_json::from_str(&run(&line, &out.join("driven"), &["--json"])).unwrap();
    assert!(branch["bifurcations"][0]["kind"] == "period-doubling" && branch["end"] == "reached", "{branch}");
    let exact: Value = serde_json::from_str(&run("wave exact --sites 10 --json", out, &[])).unwrap();
    let line = format!("wave continue --resume {}/exact-wave.npz --to 2.002 --step 0.0005", out.display());
    let branch: Value = serde_json::from_str(&run(&line, &out.join("wave"), &["--json"])).unwrap();
    let waves = branch["waves"].as_array().unwrap();
    assert!(waves.len() > 2 && branch["end"] == "reached" && waves[0]["omega_tw"] == exact["omega_tw"], "{branch}");
    let mean = |wave: &Value| wave["mean_strain"].as_f64().unwrap();
    assert!(waves.iter().all(|wave| (mean(wave) / mean(&exact) - 1.0).abs() < 1e-9), "{branch}");
}

#[test]
fn multipliers_that_are_asked_to_end_go_on_with_and_without_resume() {
    let (whole, parts, other) =
        (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    run(LONG, whole.path(), &[]);
    let store = parts.path().join(STORE);
    let process = command(LONG, parts.path(), &[]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut process = process.unwrap();
    wait(&mut process, &store, 4);
    terminate(&process);
    let ended = process.wait_with_output().unwrap();
    let told = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(143), "{told}");
    let kept = lines(&store) - 1;
    assert!(kept >= 3 && told.contains("the process was asked to end"), "{told}");
    // All orbits are told, not all with multipliers.
    let [told, all] = [&parts, &whole].map(|folder| -> Vec<Value> {
        read_json(&folder.path().join("branch.json"))["points"].as_array().unwrap().clone()
    });
    let known = told.iter().filter(|point| point["max_modulus"].is_number()).count();
    assert!(told.len() == all.len() && known < all.len() && !ended.stdout.is_empty(), "{known}: {told:?}");
    let there = fs::read_to_string(&store).unwrap();
    for name in [STORE, "branch.npz"] {
        fs::copy(parts.path().join(name), other.path().join(name)).unwrap();
    }
    run(LONG, parts.path(), &[]);
    run(&format!("breather continue --bifurcations --resume {}", other.path().display()), other.path(), &[]);
    for folder in [parts.path(), other.path()] {
        let now = fs::read_to_string(folder.join(STORE)).unwrap();
        assert!(there.lines().all(|line| now.contains(line)), "{}", folder.display());
        assert!(files(folder) == files(whole.path()), "{}", folder.display());
    }
}

#[test]
#[ignore = "nightly: nine seconds"]
fn another_branch_in_the_same_folder_reads_no_rows_of_the_first() {
    let shared = tempfile::tempdir().unwrap();
    let shared = shared.path();
    run(DARK, shared, &[]);
    let mut count = lines(&shared.join(STORE));
    // Another end, way, tolerance and measurement: each branch differs from those before.
    for other in [
        DARK.replace("2.1", "2.09"),
        DARK.replace("0.004", "0.0041"),
        format!("{DARK} --weak 0.5"),
        format!("{DARK} --tol 1e-12"),
        format!("{DARK} --rho 0.34"),
    ] {
        let alone = tempfile::tempdir().unwrap();
        run(other.trim(), alone.path(), &[]);
        run(other.trim(), shared, &[]);
        assert!(results(shared) == results(alone.path()), "{other}");
        let now = lines(&shared.join(STORE));
        assert_eq!(now - count, lines(&alone.path().join(STORE)) - 1, "{other}");
        count = now;
    }
    // Fewer points: only the last segment differs.
    assert_eq!(output(&format!("{DARK} --max-points 14"), shared, &[]).status.code(), Some(1));
    assert_eq!(lines(&shared.join(STORE)), count + 1);
}

#[test]
#[ignore = "nightly: fourteen seconds"]
fn another_scene_in_the_same_folder_reads_no_rows_of_the_first() {
    for (line, change, stores) in [
        (DRIVEN, "beads.drag=0.16", ["driven-spectra.store", "switched-spectra.store"]),
        (MODE, "bonds.contact=[1.0, 2.01, 1.0]", ["mode-spectra.store", "switched-spectra.store"]),
    ] {
        let (shared, alone) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let (shared, alone) = (shared.path(), alone.path());
        run(line, shared, &[]);
        let before = stores.map(|store| lines(&shared.join(store)));
        run(line, alone, &["--set", change]);
        run(line, shared, &["--set", change]);
        assert!(results(shared) == results(alone), "{line}");
        for (store, before) in stores.into_iter().zip(before) {
            assert!(before > 1);
            assert_eq!(lines(&shared.join(store)), before + lines(&alone.join(store)) - 1, "{store}");
        }
        run(line, shared, &[]);
        run(line, alone, &[]);
        assert!(results(shared) == results(alone), "{line}");
    }
}
