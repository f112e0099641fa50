//! Sweeps in shards: the files of one process, also after kills and signals.

use super::{
    numbers::random,
    program::{self, PROGRAM, files, lines, refused, stdout, terminate, wait},
};
use std::{
    fs,
    path::Path,
    process::{Command, Output, Stdio},
    thread::sleep,
    time::Duration,
};

pub(crate) const WAVES: &str = "wave tw-q45 --zeta 0.01 --seeds 200 --until 1 --samples-per-period 4 --tol 1e-6";

pub(crate) fn command(line: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = program::command(line);
    command.arg("--out").arg(out).args(more).env("RAYON_NUM_THREADS", "1");
    command
}

pub(crate) fn output(line: &str, out: &Path, more: &[&str]) -> Output {
    command(line, out, more).output().unwrap()
}

/// Runs the loop of the guide over three shards on three threads each, merges them, and holds all
/// files against those of one process on one thread.
pub(crate) fn in_shards(line: &str) {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    assert!(output(line, whole, &[]).status.success());
    let script = "for k in 1 2 3; do \"$0\" \"$@\" --shard $k/3 || exit 1; done";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, PROGRAM]).args(line.split(' ')).arg("--out").arg(parts).env("RAYON_NUM_THREADS", "3");
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
fn short_studies_over_a_grid_in_three_shards_have_the_files_of_one_process() {
    in_shards("breather barrier --frequencies 3 --sites 5");
    in_shards("wave modulation --sites 10 --rho 3 --measure --modes 1 --epsilon 0.01,0.02,0.04");
    in_shards("breather moving --sites 9 --until 20");
}

const PLAN: &str = r#"
scene = "impact"
set = ["span.until=0.4", "record.samples=1", "method.integrator=verlet", "method.step=0.1"]
keep = ["energy_error", "u[0]", "pu", "contacts.impulse"]
picture = "u[0]"

[[axis]]
key = "chain.sites"
values = [4, 0, 6]

[[axis]]
key = "chain.alpha"
from = 1.5
to = 3.0
count = COUNT
"#;

pub(crate) fn plan(folder: &Path, count: usize) -> String {
    let path = folder.join("plan.toml");
    fs::write(&path, PLAN.replace("COUNT", &count.to_string())).unwrap();
    format!("sweep {}", path.display())
}

#[test]
fn charts_are_resumed_point_by_point() {
    let folder = tempfile::tempdir().unwrap();
    let line =
        "study stability --charts light,time --integrators strang-linear --work 1e4 --sites 10 --periods 10 --quick";
    let [first, second] = [0; 2].map(|_| program::json(&format!("{line} --out {}", folder.path().display())));
    assert!(first["computed"].as_u64() > Some(4) && second["computed"] == 0 && first["points"] == second["points"]);
}

#[test]
fn a_plan_in_three_shards_has_the_files_of_one_process() {
    let folder = tempfile::tempdir().unwrap();
    in_shards(&plan(folder.path(), 10));
}

// Truth: `run` of the scene with the changes of a point.
#[test]
fn a_plan_has_the_numbers_of_its_runs_and_the_reasons_of_its_failures() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let study = output(&plan(folder.path(), 4), &out, &["--json"]);
    let study: serde_json::Value = serde_json::from_slice(&study.stdout).unwrap();
    assert_eq!((&study["points"], &study["failures"]), (&12.into(), &4.into()));
    let set = ["chain.sites=6", "chain.alpha=2.5", "span.until=0.4", "record.samples=1"];
    let set = set.iter().flat_map(|one| ["--set", one]);
    let args = ["run", "impact", "--integrator", "verlet", "--step", "0.1", "--events"];
    let run = program::json(&args.into_iter().chain(set).collect::<Vec<_>>());
    // The third value of 1.5, 2, 2.5, 3 on the third row.
    let columns = &study["columns"];
    assert_eq!((&columns["chain.sites"][10], &columns["chain.alpha"][10]), (&6.0.into(), &2.5.into()));
    assert_eq!(columns["energy_error"][10], run["energy_error"]);
    assert_eq!(columns["u[0]"][10], run["u"][0]);
    assert_eq!(columns["pu"][10], run["pu"]);
    assert_eq!(columns["contacts.impulse"][10], run["contacts"]["impulse"]);
    assert!(run["contacts"]["impulse"].as_f64().unwrap() > 0.0);
    // Rows with fewer sites end with what is no number.
    assert!(columns["pu"][0][3].is_number() && columns["pu"][0][4].is_null());
    assert!(study["failed"][0]["failure"].as_str().unwrap().contains("--set chain.sites=0: `chain.sites`"), "{study}");

    let csv = fs::read_to_string(out.join("sweep.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!((lines.len(), lines[11].split(',').nth(4)), (13, Some("6 numbers")));
    assert!(lines[5].contains("chain.sites=0") && lines[11].starts_with("6,2.5e0,"), "{csv}");
    let archive = hertzchain::output::Archive::from_bytes(&out, &fs::read(out.join("sweep.npz")).unwrap()).unwrap();
    assert_eq!(archive.array("u[0]", &[12]).unwrap()[10], run["u"][0].as_f64().unwrap());
    assert_eq!(archive.array("pu", &[12, 6]).unwrap()[65], run["pu"][5].as_f64().unwrap());
}

#[test]
fn a_plan_that_cannot_be_is_refused_with_file_key_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.toml");
    fs::write(&path, "scene = \"impact\"\n[[axis]]\nkey = \"chain.rho\"\nvalues = [1, -1]\n").unwrap();
    let out = folder.path().join("out");
    let line = format!("sweep {} --out {}", path.display(), out.display());
    let (said, words) = (refused(&line, 2), "error: scene impact: --set chain.rho=-1: `chain.rho`: rho = -1 is not");
    assert!(said.starts_with(words) && !out.exists(), "{said}");
    assert!(refused("sweep nothing.toml", 1).contains("nothing.toml"));
    // A method that can run no point is refused once; one that can run some is not.
    let plan = |integrators: &str| {
        let axes =
            [format!("method.integrator\"\nvalues = [{integrators}]"), "initial.velocity\"\nvalues = [1, 2]".into()];
        let set = "scene = \"impact\"\nset = [\"bonds.viscoelastic=0.1\", \"span.until=0.1\"]\n";
        fs::write(&path, axes.iter().fold(set.to_owned(), |plan, axis| plan + "[[axis]]\nkey = \"" + axis + "\n"))
            .unwrap();
    };
    plan("\"verlet\"");
    let (said, words) = (refused(&line, 2), "plan.toml, all points: integrator = verlet is not valid: its kicks");
    assert!(said.contains(words) && !out.exists(), "{said}");
    plan("\"verlet\", \"dop853\"");
    assert!(stdout(&line).contains("2 failed"));
    fs::remove_dir_all(&out).unwrap();
    fs::write(&path, stdout("sweep --template")).unwrap();
    stdout(&line);
}

/// Kills a shard at random moments, each after it has kept something new; nothing that was kept is
/// computed again, and the merge has the files of one process.
fn killed(kills: usize) {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    assert!(output(WAVES, whole, &[]).status.success());
    let store = parts.join("ensemble.shard-1-of-2.store");
    let mut random = random(11);
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
fn a_shard_that_is_asked_to_end_keeps_what_it_has_and_goes_on() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    let store = parts.join("ensemble.shard-2-of-2.store");
    let mut process = command(WAVES, parts, &["--shard", "2/2"]).stderr(Stdio::piped()).spawn().unwrap();
    wait(&mut process, &store, 20);
    terminate(&process);
    let ended = process.wait_with_output().unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    let kept = lines(&store) - 1;
    assert_eq!(ended.status.code(), Some(143), "{said}");
    assert!(kept < 100 && said.contains(&format!("{kept} points are kept of 100")), "{said}");
    assert!(said.contains("the same command goes on"), "{said}");
    assert!(output(WAVES, parts, &[]).status.success() && output(WAVES, whole, &[]).status.success());
    assert!(files(whole) == files(parts));
}

/// Truth: the same study in one process. Wall times are in the JSON only.
#[test]
fn the_drift_of_methods_is_a_sweep() {
    let line = "study drift --periods 30 --samples 12 --integrators verlet,strang-linear,dop853";
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    assert!(output(line, whole, &[]).status.success());
    for shard in ["1/2", "2/2"] {
        assert!(output(line, parts, &["--shard", shard]).status.success());
    }
    let stores: usize = files(parts).keys().map(|name| lines(&parts.join(name)) - 1).sum();
    assert_eq!(stores, 3, "each integrator once");
    assert!(output(line, parts, &[]).status.success());
    for name in ["drift.csv", "drift.png"] {
        assert!(fs::read(whole.join(name)).unwrap() == fs::read(parts.join(name)).unwrap(), "{name}");
    }
    // Another length is another study.
    let other = output(&line.replace("30", "40"), parts, &[]);
    assert!(String::from_utf8(other.stderr).unwrap().contains("drift.store"));
}
