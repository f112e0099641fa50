//! Sweeps in shards: the files of one process, also after kills and signals.

use std::{
    fs,
    path::Path,
    process::{Child, Command, Output, Stdio},
    thread::sleep,
    time::Duration,
};

const PROGRAM: &str = env!("CARGO_BIN_EXE_hertzchain");
const LIFETIMES: &str = "study lifetimes --epsilons 0.1,0.2,0.3,0.4,0.5 --rhos 5,10,20,40,80 --sites 20 --until 25";
const WAVES: &str = "wave tw-q45 --zeta 0.01 --seeds 200 --until 1 --samples-per-period 4 --tol 1e-6";

fn command(line: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(line.split(' ')).arg("--out").arg(out).args(more).env("RAYON_NUM_THREADS", "1");
    command
}

fn output(line: &str, out: &Path, more: &[&str]) -> Output {
    command(line, out, more).output().unwrap()
}

/// All files that do not tell how long something took.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let mut files: Vec<(String, Vec<u8>)> = entries
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()))
        .filter(|(name, _)| name != "wave.json")
        .collect();
    files.sort();
    files
}

fn lines(store: &Path) -> usize {
    fs::read(store).map_or(0, |text| text.iter().filter(|byte| **byte == b'\n').count())
}

/// Runs the loop of the guide over three shards, merges them, and holds all files against those of
/// one process.
fn in_shards(line: &str) {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    assert!(output(line, whole, &[]).status.success());
    let script = "for k in 1 2 3; do \"$0\" \"$@\" --shard $k/3 || exit 1; done";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, PROGRAM]).args(line.split(' ')).arg("--out").arg(parts);
    let said = String::from_utf8(shell.output().unwrap().stdout).unwrap();
    assert!(said.starts_with("shard 1/3: ") && said.contains("the same command without --shard"), "{said}");
    assert_eq!(files(parts).len(), 3, "shards write their stores only");
    assert!(output(line, parts, &[]).status.success());
    assert!(files(whole) == files(parts), "{line}");
}

#[test]
fn lifetimes_and_waves_in_three_shards_have_the_files_of_one_process() {
    in_shards("study lifetimes --epsilons 0.3,0.4 --rhos 5,10 --sites 20 --until 6");
    in_shards(WAVES);
}

#[test]
#[ignore = "nightly: the map of five by five"]
fn a_map_in_three_shards_has_the_files_of_one_process() {
    in_shards(LIFETIMES);
}

/// Numbers from 0 to 1, the same in every run.
fn random() -> impl FnMut() -> f64 {
    let mut seed = 11u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Waits until a shard has kept so many lines, or has ended.
fn wait(process: &mut Child, store: &Path, count: usize) {
    while lines(store) < count && process.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(1));
    }
}

/// Kills a shard at random moments, each after it has kept something new; nothing that was kept is
/// computed again, and the merge has the files of one process.
fn killed(kills: usize) {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    assert!(output(WAVES, whole, &[]).status.success());
    let store = parts.join("ensemble.shard-1-of-2.store");
    let mut random = random();
    for nth in 0..kills {
        let before = lines(&store);
        let mut process =
            command(WAVES, parts, &["--shard", "1/2"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // Evenly over the shard of 99 points, the last one before its end.
        wait(&mut process, &store, (90 * (nth + 1)).div_ceil(kills).max(before + 1));
        sleep(Duration::from_micros((4000.0 * random()) as u64));
        process.kill().unwrap();
        assert!(!process.wait().unwrap().success(), "kill {nth} came too late");
        assert!(lines(&store) > before, "kill {nth}");
    }
    let kept = lines(&store) - 1;
    let part = output(WAVES, parts, &["--shard", "1/2", "--json"]);
    let part: serde_json::Value = serde_json::from_slice(&part.stdout).unwrap();
    assert_eq!((&part["points"], &part["kept"]), (&99.into(), &99.into()));
    // A line that was cut is not kept.
    assert_eq!(part["computed"].as_u64(), Some(99 - kept as u64));
    assert!(output(WAVES, parts, &[]).status.success());
    assert!(files(whole) == files(parts));
}

#[test]
fn a_shard_that_is_killed_repeats_what_was_in_flight_only() {
    killed(3);
}

#[test]
#[ignore = "nightly: twenty kills"]
fn a_shard_that_is_killed_twenty_times_repeats_what_was_in_flight_only() {
    killed(20);
}

#[test]
fn a_shard_that_is_asked_to_end_keeps_what_it_has_and_goes_on() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    let store = parts.join("ensemble.shard-2-of-2.store");
    let mut process = command(WAVES, parts, &["--shard", "2/2"]).stderr(Stdio::piped()).spawn().unwrap();
    wait(&mut process, &store, 20);
    assert!(Command::new("kill").args(["-TERM", &process.id().to_string()]).status().unwrap().success());
    let ended = process.wait_with_output().unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    let kept = lines(&store) - 1;
    assert_eq!(ended.status.code(), Some(143), "{said}");
    assert!(kept < 100 && said.contains(&format!("{kept} points are kept of 100")), "{said}");
    assert!(said.contains("the same command goes on"), "{said}");
    assert!(output(WAVES, parts, &[]).status.success() && output(WAVES, whole, &[]).status.success());
    assert!(files(whole) == files(parts));
}

#[test]
fn shards_that_cannot_be_are_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |line: &str, shard: &str, words: &str| {
        let output = output(line, folder.path(), &["--shard", shard]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(words), "{line} {shard}: {said}");
    };
    refused(LIFETIMES, "0/3", "K/N with whole numbers 1 <= K <= N, as in 2/8");
    refused(LIFETIMES, "4/3", "K/N with whole numbers 1 <= K <= N, as in 2/8");
    refused(LIFETIMES, "1/26", "1/26 of a grid of 25 points");
    refused("wave tw-q45 --until 3", "1/2", "there is no grid to divide: leave --shard out");
    let homeless = Command::new(PROGRAM).args(LIFETIMES.split(' ')).args(["--shard", "1/3"]).output().unwrap();
    assert!(String::from_utf8(homeless.stderr).unwrap().contains("give --out DIR, the same for all shards"));
    let none = Command::new(PROGRAM).args(["run", "impact", "--shard", "1/3"]).output().unwrap();
    assert_eq!(none.status.code(), Some(2));
}
