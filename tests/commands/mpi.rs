//! Sweeps over the ranks of an MPI job: the files of one process, also after ranks were killed.

use super::{
    branch_points,
    numbers::random,
    program::{PROGRAM, files, lines},
    shards::{WAVES, output, plan},
};
use hertzchain::sweep::{Engine, Grid, Mpi};
use std::{
    ffi::OsStr,
    fs,
    path::Path,
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// A program on so many ranks.
fn job(count: usize, program: impl AsRef<OsStr>) -> Command {
    let mut mpirun = Command::new("mpirun");
    mpirun.args(["--oversubscribe", "--allow-run-as-root", "-n", &count.to_string()]).arg(program);
    mpirun
}

/// The command on so many ranks.
fn ranks(count: usize, line: &str, out: &Path) -> Command {
    let mut mpirun = job(count, PROGRAM);
    mpirun.args(line.split(' ')).args(["--engine", "mpi", "--out"]).arg(out).env_remove("RAYON_NUM_THREADS");
    mpirun
}

/// Holds the files of one, two and three ranks, and of two with two threads, against those of one
/// process.
fn on_ranks(line: &str) {
    let whole = tempfile::tempdir().unwrap();
    let whole = whole.path();
    assert!(output(line, whole, &[]).status.success());
    for (count, threads) in [(1, 1), (2, 1), (3, 1), (2, 2)] {
        let parts = tempfile::tempdir().unwrap();
        let mut mpirun = ranks(count, line, parts.path());
        let ended = mpirun.env("RAYON_NUM_THREADS", threads.to_string()).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.success(), "{line} on {count}: {said}");
        assert_eq!(said.matches("written to").count(), 1, "one rank speaks: {said}");
        assert!(files(whole) == files(parts.path()), "{line} on {count} ranks of {threads} threads");
    }
}

#[test]
fn ranks_have_the_files_of_one_process() {
    let folder = tempfile::tempdir().unwrap();
    on_ranks(&plan(folder.path(), 40));
    on_ranks(WAVES);
    on_ranks("study lifetimes --epsilons 0.3,0.4 --rhos 5,10 --sites 20 --until 6");
    on_ranks("paper verify --section 3");
    [branch_points::DARK, branch_points::DRIVEN, branch_points::MODE, branch_points::PROVED]
        .into_iter()
        .for_each(on_ranks);
}

/// The processes of the program below this one: ranks by their numbers.
fn rank(mpirun: u32, number: usize) -> Option<u32> {
    let processes = fs::read_dir("/proc").unwrap().flatten();
    processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).find(|id: &u32| {
        let status = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        let parent = status.rsplit(") ").next().and_then(|rest| rest.split(' ').nth(1)?.parse().ok());
        let told = fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
        let name = format!("OMPI_COMM_WORLD_RANK={number}");
        parent == Some(mpirun) && told.split(|byte| *byte == 0).any(|one| one == name.as_bytes())
    })
}

/// Kills a rank at random moments, each after something new was kept: the job ends, nothing that
/// was kept is lost, and at last the files are those of one process.
fn killed(waves: &str, number: usize, kills: usize) {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    assert!(output(waves, whole, &[]).status.success());
    let store = parts.join("ensemble.store");
    let mut random = random(11);
    let mut hits = 0;
    while hits < kills {
        let before = lines(&store);
        let mut mpirun = ranks(3, waves, parts).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // Found at once: looking for it takes as long as many points.
        let id = loop {
            match (rank(mpirun.id(), number), mpirun.try_wait().unwrap()) {
                (Some(id), None) => break Some(id),
                (_, Some(ended)) => {
                    assert!(ended.success(), "the job begins");
                    break None;
                }
                (None, None) => {}
            }
        };
        let Some(id) = id else {
            // It had nothing left that takes long: once more from the start.
            fs::remove_dir_all(parts).unwrap();
            continue;
        };
        let target = (120 * (hits + 1)).div_ceil(kills).max(before + 1);
        while lines(&store) < target && mpirun.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(1));
        }
        sleep(Duration::from_micros((4000.0 * random()) as u64));
        let hit = Command::new("kill").args(["-KILL", &id.to_string()]).status().unwrap().success();
        if mpirun.wait().unwrap().success() || !hit {
            // Killed too late: once more from the start.
            fs::remove_dir_all(parts).unwrap();
            continue;
        }
        assert!(lines(&store) > before, "kill {hits}");
        hits += 1;
    }
    let kept = lines(&store) - 1;
    let ended = ranks(2, waves, parts).arg("--json").output().unwrap();
    assert!(ended.status.success() && kept > 60, "{kept}");
    assert!(files(whole) == files(parts), "rank {number}");
}

#[test]
fn a_job_whose_rank_is_killed_goes_on_from_its_store() {
    killed(WAVES, 0, 2);
    killed(WAVES, 1, 2);
}

#[test]
fn a_refusal_is_said_once_and_ends_all_ranks() {
    let folder = tempfile::tempdir().unwrap();
    for (line, words) in [
        ("study lifetimes --epsilons -1", "--epsilons = -1 is not valid"),
        ("wave tw-q45 --until 0", "--until = 0 is not valid"),
        ("sweep nothing.toml", "nothing.toml"),
    ] {
        let ended = ranks(3, line, folder.path()).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(!ended.status.success() && said.matches(&format!("error: {words}")).count() == 1, "{said}");
    }
    // A store that another run has open: rank 0 ends all.
    let out = folder.path().join("held");
    assert!(output(WAVES, &out, &[]).status.success());
    let held = fs::File::open(out.join("ensemble.store")).unwrap();
    held.lock().unwrap();
    let ended = ranks(2, WAVES, &out).output().unwrap();
    assert!(String::from_utf8(ended.stderr).unwrap().contains("in use by another run"));
}

/// Set for the ranks that a test starts with this program of tests.
const INNER: &str = "HERTZCHAIN_TEST_RANK";

/// Runs a test of this program on two ranks. Returns false in a process that is one of them.
fn on_two_ranks(name: &str) -> bool {
    let outer = std::env::var_os(INNER).is_none();
    if outer {
        let mut mpirun = job(2, std::env::current_exe().unwrap());
        mpirun.args(["--exact", name, "--include-ignored", "--nocapture"]).env(INNER, "1");
        let ended = mpirun.env_remove("RAYON_NUM_THREADS").output().unwrap();
        println!("{}", String::from_utf8_lossy(&ended.stdout));
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    }
    outer
}

/// A rank that comes when the points of the first sweep are computed has no part in the second.
#[test]
fn a_rank_that_comes_late_ends_with_the_first_sweep() {
    if on_two_ranks("mpi::a_rank_that_comes_late_ends_with_the_first_sweep") {
        return;
    }
    let engine = Engine::new(Box::new(Mpi::new().unwrap()));
    let grid = Grid { store: "roots.store", study: "roots", settings: serde_json::json!({}) };
    let sweep = |points: &[f64], wait| {
        sleep(Duration::from_millis(wait));
        let root = |x: &f64| {
            sleep(Duration::from_millis(10));
            Ok(x.sqrt())
        };
        engine.sweep(&grid, points, &|_, _| (), root)
    };
    if engine.serves() {
        assert!(sweep(&[4.0], 300).is_err());
        return;
    }
    for (points, wait) in [(vec![4.0], 0), ((1..50).map(f64::from).collect(), 500)] {
        let roots: Vec<f64> = sweep(&points, wait).unwrap().rows.into_iter().map(Result::unwrap).collect();
        assert_eq!(roots, points.iter().map(|x| x.sqrt()).collect::<Vec<f64>>());
    }
}
