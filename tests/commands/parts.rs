//! One long chain in parts: the files of one thread, for any number of them, also where a run goes
//! on in another number; and what is refused.
#![cfg(feature = "cli")]

use hertzchain::{
    output::{Archive, Array, Folder, npz, npz_with},
    parts::Parts,
    run::method::{Method, Setting},
    scene::Scene,
    study::LongRun,
};
use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    process::{Command, Output},
};

const PROGRAM: &str = env!("CARGO_BIN_EXE_hertzchain");

/// Chains with ends and rings, with resonators and without, on both splits; and seven blocks of
/// bonds by contact collocation.
pub(crate) const RUNS: [&str; 6] = [
    "run impact --set chain.sites=1000 --integrator verlet --until 20 --samples 7",
    "run tw-q15 --integrator strang-linear --until 30 --samples 7",
    "run cradle --integrator aba864-linear --until 5 --samples 7 --events",
    "run tw-q15 --integrator yoshida4 --until 3 --samples 7 --checkpoint 1",
    "run impact --set chain.sites=1800 --tol 1e-6 --until 20 --samples 7 --events",
    "run tw-q15 --set chain.sites=1800 --tol 1e-5 --until 1.5 --samples 7 --checkpoint 0.6",
];

/// The files of a run, but for wall times and the checkpoint that holds them.
pub(crate) fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = super::shards::files(folder);
    files.retain(|(name, _)| name != "checkpoint.npz");
    let wall = |line: &&str| !line.contains("wall_s") && !line.contains("sampling_s");
    for (_, bytes) in files.iter_mut().filter(|(name, _)| name == "summary.json") {
        let lines = String::from_utf8(bytes.clone()).unwrap();
        *bytes = lines.lines().filter(wall).collect::<Vec<_>>().join("\n").into_bytes();
    }
    assert!(files.iter().any(|(name, _)| name == "summary.json") && files.len() > 5);
    files
}

/// Runs a command line with a folder and more flags.
pub(crate) fn output(line: &str, folder: &Path, more: &[&str]) -> Output {
    Command::new(PROGRAM).args(line.split(' ')).arg("--out").arg(folder).args(more).output().unwrap()
}

#[test]
fn threads_have_the_files_of_one() {
    for line in RUNS {
        let whole = tempfile::tempdir().unwrap();
        assert!(output(line, whole.path(), &[]).status.success(), "{line}");
        for threads in ["1", "2", "3", "7"] {
            let parts = tempfile::tempdir().unwrap();
            let ended = output(line, parts.path(), &["--threads", threads]);
            assert!(ended.status.success(), "{line}: {}", String::from_utf8_lossy(&ended.stderr));
            assert!(files(whole.path()) == files(parts.path()), "{line} in {threads}");
        }
    }
}

/// Begins a run, breaks it off three times in other numbers of parts, and ends it in two.
fn goes_on(begin: impl Fn() -> LongRun) {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let [whole, broken] = folders.each_ref().map(|folder| Folder::create(folder.path()).unwrap());
    let want = begin().run(&whole, &mut |_| ()).unwrap();
    for (threads, limit) in [(3, 2.5), (1, 4.0), (5, 7.0)] {
        let begun = LongRun::load(broken.path()).unwrap_or_else(|_| begin());
        let begun = begun.in_parts(Parts::Threads(threads)).unwrap();
        let breaks = catch_unwind(AssertUnwindSafe(|| begun.run(&broken, &mut |t| assert!(t < limit, "enough"))));
        assert!(breaks.is_err() && LongRun::load(broken.path()).unwrap().time() > 0.0);
    }
    let last = LongRun::load(broken.path()).unwrap().in_parts(Parts::Threads(2)).unwrap();
    let got = last.run(&broken, &mut |_| ()).unwrap();
    assert!((got.t, got.state, got.samples, got.stats) == (want.t, want.state, want.samples, want.stats));
    assert!(got.contacts == want.contacts);
}

#[test]
fn a_run_goes_on_in_another_number_of_parts() {
    // Truth: the same legs in one process, not interrupted.
    let long = |scene: Scene, name, setting| {
        let (scene, method) = (scene.until(8.0).unwrap(), Method::named(name).unwrap());
        LongRun::new(scene, method, setting, "words".to_owned(), 1.5, Parts::Whole).unwrap()
    };
    goes_on(|| long(Scene::load("tw-q15").unwrap(), "strang-linear", Setting::Steps(1000)));
    let impact = || Scene::load_with("impact", &["chain.sites=1300".to_owned()]).unwrap();
    goes_on(|| long(impact(), "collocation", Setting::Tolerance(1e-6)).with_contacts());
}

/// Runs in legs whose parts may keep what is their own: displacements and strains, with resonators
/// and without, by kicks and by windows; with samples inside legs.
pub(crate) const BY_PART: [&str; 4] = [
    "run impact --set chain.sites=1000 --integrator verlet --until 20 --samples 7 --checkpoint 6",
    "run tw-q15 --integrator strang-linear --until 9 --samples 7 --checkpoint 4",
    "run tw-q15 --set chain.sites=1800 --integrator collocation --tol 1e-5 --until 1.5 --samples 7 --checkpoint 0.6",
    "run impact --set chain.sites=1800 --integrator collocation --tol 1e-6 --until 9 --samples 7 --checkpoint 5",
];

/// Joins what parts have left in a folder.
pub(crate) fn join(folder: &Path) {
    let ended = Command::new(PROGRAM).args(["run", "--resume"]).arg(folder).output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
}

/// The names of the files of parts.
pub(crate) fn pieces(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder.join("parts")).into_iter().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn what_parts_keep_is_joined_to_the_files_of_one_process() {
    // Truth: the same legs in one process, byte by byte, but for wall times.
    for line in BY_PART {
        let whole = tempfile::tempdir().unwrap();
        assert!(output(line, whole.path(), &[]).status.success(), "{line}");
        for threads in ["1", "2", "3"] {
            let parts = tempfile::tempdir().unwrap();
            let ended = output(line, parts.path(), &["--threads", threads, "--by-part"]);
            let said = String::from_utf8_lossy(&ended.stderr);
            assert!(ended.status.success() && said.contains("joined by"), "{line}: {said}");
            let named = |name: &str| parts.path().join(name).exists();
            assert!(named("energy.csv") && !named("final.csv") && !named("profiles.npz"), "{line}");
            let states = pieces(parts.path()).iter().filter(|name| name.starts_with("state-")).count();
            assert_eq!(states.to_string(), threads, "states of the last leg only: {:?}", pieces(parts.path()));
            join(parts.path());
            assert!(files(whole.path()) == files(parts.path()), "{line} in {threads}");
        }
    }
}

/// Begins a run by part, breaks it off in other numbers of parts, and ends it in one process.
fn goes_on_by_part(begin: impl Fn(Parts, bool) -> LongRun) {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let [whole, broken] = folders.each_ref().map(|folder| Folder::create(folder.path()).unwrap());
    let want = begin(Parts::Whole, false).run(&whole, &mut |_| ()).unwrap();
    for (threads, limit) in [(3, 2.5), (1, 4.0), (5, 5.5), (2, 7.0)] {
        let parts = Parts::Threads(threads);
        let begun = match LongRun::load_in(broken.path(), parts.clone(), true) {
            Ok(begun) => begun,
            Err(_) => begin(parts, true),
        };
        let breaks = catch_unwind(AssertUnwindSafe(|| begun.run(&broken, &mut |t| assert!(t < limit, "enough"))));
        assert!(breaks.is_err() && LongRun::load(broken.path()).unwrap().time() > 0.0);
    }
    let got = LongRun::load(broken.path()).unwrap().run(&broken, &mut |_| ()).unwrap();
    assert!((got.t, got.state, got.samples, got.stats) == (want.t, want.state, want.samples, want.stats));
    assert!(got.profiles == want.profiles && got.profiles.len() > 5);
    // The last leg was written in one piece: of the parts nothing is left.
    assert!(pieces(broken.path()).is_empty(), "{:?}", pieces(broken.path()));
}

#[test]
fn a_run_by_part_goes_on_in_another_number_of_parts() {
    // Truth: the same legs in one process, not interrupted.
    let long = |scene: Scene, name, setting, parts: Parts, by_part: bool| {
        let (scene, method, words) = (scene.until(8.0).unwrap(), Method::named(name).unwrap(), "words".to_owned());
        let long = if by_part {
            LongRun::by_part(scene, method, setting, words, 1.5, &parts)
        } else {
            LongRun::new(scene, method, setting, words, 1.5, parts)
        };
        long.unwrap()
    };
    let wave = || Scene::load_by_part("tw-q15", &[]).unwrap();
    goes_on_by_part(|parts, by_part| long(wave(), "strang-linear", Setting::Steps(1000), parts, by_part));
    let impact = || Scene::load_by_part("impact", &["chain.sites=1300".to_owned()]).unwrap();
    goes_on_by_part(|parts, by_part| long(impact(), "collocation", Setting::Tolerance(1e-6), parts, by_part));
}

/// What going on says of a folder that is refused: in one process and, if `count` is 2, by part.
fn refusals(folder: &Path, count: usize) -> Vec<String> {
    let ways = [&[][..], &["--by-part", "--threads", "2"]];
    let said = |more: &&[&str]| {
        let ended = Command::new(PROGRAM).args(["run", "--resume"]).arg(folder).args(*more).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(!ended.status.success() && !said.contains("panicked"), "{said}");
        said
    };
    ways[..count].iter().map(said).collect()
}

#[test]
fn what_is_not_whole_of_what_parts_keep_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(output(BY_PART[0], folder.path(), &["--threads", "3", "--by-part"]).status.success());
    let names = pieces(folder.path());
    let damaged = |prefix: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let name = names.iter().find(|name| name.starts_with(prefix) && name.contains("-1-of-3")).unwrap();
        let path = folder.path().join("parts").join(name);
        let good = fs::read(&path).unwrap();
        let mut bytes = good.clone();
        change(&mut bytes);
        if bytes.is_empty() {
            fs::remove_file(&path).unwrap()
        } else {
            fs::write(&path, &bytes).unwrap()
        }
        let said = refusals(folder.path(), 2);
        fs::write(&path, &good).unwrap();
        (name.clone(), said)
    };
    // In turn: a changed bit of a number, a file cut short, none.
    let middle = |bytes: &mut Vec<u8>| *bytes.get_mut(1000).unwrap() ^= 1;
    for change in [&middle as &dyn Fn(&mut Vec<u8>), &|bytes| bytes.truncate(900), &Vec::clear] {
        let (name, said) = damaged("state-", change);
        assert!(said.iter().all(|said| said.contains(&name)), "{said:?}");
    }
    // Another file of the same run in its place.
    let other = names.iter().find(|name| name.starts_with("state-") && name.contains("-2-of-3")).unwrap();
    let other = fs::read(folder.path().join("parts").join(other)).unwrap();
    let (_, said) = damaged("state-", &|bytes| bytes.clone_from(&other));
    assert!(said.iter().all(|said| said.contains("this one begins at site 333")), "{said:?}");
    join(folder.path());
}

#[test]
fn parts_that_end_early_or_are_not_finite_are_refused() {
    // Of 999 sites in three parts the last part begins where that of 1000 does, at site 666.
    let [folder, shorter] = ["1000", "999"].map(|sites| {
        let (folder, line) = (tempfile::tempdir().unwrap(), BY_PART[0].replace("1000", sites));
        assert!(output(&line, folder.path(), &["--threads", "3", "--by-part"]).status.success());
        folder
    });
    let state = |folder: &Path, part: usize| {
        let end = format!("-{part}-of-3.npz");
        let names = pieces(folder);
        let name = names.iter().find(|name| name.starts_with("state-") && name.ends_with(&end)).unwrap();
        folder.join("parts").join(name)
    };
    let last = state(folder.path(), 2);
    let good = fs::read(&last).unwrap();
    fs::copy(state(shorter.path(), 2), &last).unwrap();
    let said = refusals(folder.path(), 2);
    assert!(said.iter().all(|said| said.contains("the parts end at site 999 of 1000")), "{said:?}");
    fs::write(&last, good).unwrap();
    let names = pieces(folder.path());
    for (kind, refusing) in [("profiles-", 1), ("state-", 2)] {
        let name = names.iter().rfind(|name| name.starts_with(kind) && name.ends_with("-1-of-3.npz")).unwrap();
        let path = folder.path().join("parts").join(name);
        let file = Archive::read(&path).unwrap();
        let rows = (1..99).find(|rows| file.array("u", &[*rows, 333]).is_ok());
        let shape = rows.map_or(vec![333], |rows| vec![rows, 333]);
        let sites = Array::vector("sites", file.array("sites", &[2]).unwrap());
        let arrays = ["u", "u_dot"].map(|name| {
            let mut values = file.array(name, &shape).unwrap();
            if name == "u_dot" {
                values[7] = f64::NAN;
            }
            let rows: Vec<f64> = values;
            match shape.len() {
                1 => Array::vector(name, rows),
                _ => Array::matrix(name, rows.chunks_exact(333)),
            }
        });
        let good = fs::read(&path).unwrap();
        fs::write(&path, npz(&[sites].into_iter().chain(arrays).collect::<Vec<_>>()).unwrap()).unwrap();
        // Parts that go on need no profiles.
        let said = &refusals(folder.path(), refusing);
        assert!(said.iter().all(|said| said.contains("u_dot: NaN at entry 7: all are finite")), "{said:?}");
        fs::write(&path, good).unwrap();
    }
}

#[test]
fn legs_of_parts_that_cannot_be_are_refused_by_rule() {
    let folder = tempfile::tempdir().unwrap();
    assert!(output(BY_PART[0], folder.path(), &["--threads", "3", "--by-part"]).status.success());
    let path = folder.path().join("checkpoint.npz");
    let text = Archive::read(&path).unwrap().text("settings.json").unwrap().to_owned();
    let settings: serde_json::Value = serde_json::from_str(&text).unwrap();
    let legs = &settings["by_part"];
    let last = legs.as_array().unwrap().len() - 1;
    let with = |key: &str, number: u64| {
        let mut legs = legs.clone();
        legs[last][key] = number.into();
        legs
    };
    let profiles = legs[last]["profiles"].as_u64().unwrap();
    for (legs, rule) in [
        (serde_json::json!([]), "no leg"),
        (with("parts", 0), "0 parts of 1000 sites"),
        (with("parts", 1001), "1001 parts of 1000 sites"),
        (with("profiles", profiles + 1), "other numbers of its legs"),
        (with("profiles", u64::MAX), "other numbers of its legs"),
    ] {
        let altered = serde_json::Value::Object(
            settings.as_object().unwrap().clone().into_iter().chain([("by_part".to_owned(), legs)]).collect(),
        );
        fs::write(&path, npz_with("settings.json", &altered.to_string(), &[]).unwrap()).unwrap();
        let said = refusals(folder.path(), 2);
        assert!(said.iter().all(|said| said.contains("settings.json, by_part: ") && said.contains(rule)), "{said:?}");
    }
}

#[test]
fn files_of_a_run_that_ended_early_are_not_those_of_the_run_before_it() {
    // The second run writes leg 1 over that of the first, and ends before its checkpoint.
    let folder = tempfile::tempdir().unwrap();
    let line = |until: u32| format!("run impact --integrator verlet --until {until} --samples 7 --checkpoint {until}");
    assert!(output(&line(20), folder.path(), &["--threads", "3", "--by-part"]).status.success());
    let middle = folder.path().join("parts/state-1-1-of-3.npz");
    fs::remove_file(&middle).unwrap();
    fs::create_dir(&middle).unwrap();
    let ended = output(&line(10), folder.path(), &["--threads", "3", "--by-part"]);
    let said = String::from_utf8(ended.stderr).unwrap();
    assert!(ended.status.code() == Some(1) && said.contains("part 1: "), "{said}");
    assert!(!folder.path().join("checkpoint.npz").exists(), "no checkpoint names files of another run");
}

#[test]
fn what_has_no_parts_of_its_own_is_refused() {
    let whole = tempfile::tempdir().unwrap();
    assert!(output(BY_PART[0], whole.path(), &[]).status.success());
    let path = whole.path().to_str().unwrap();
    for (line, words) in [
        ("run impact --until 1 --integrator verlet --by-part", "--checkpoint"),
        ("run impact --until 1 --checkpoint 1 --out nowhere --by-part", "give --integrator"),
        ("run impact --until 1 --checkpoint 1 --out nowhere --by-part --integrator dop853", "only splitting schemes"),
        ("run dimer --until 1 --checkpoint 1 --out nowhere --by-part --integrator verlet --threads 2", "in one part"),
        ("run impact --until 1 --checkpoint 1 --out nowhere --by-part --integrator verlet --events", "--events"),
        (&format!("run --resume {path} --by-part"), "keeps whole states: leave --by-part out"),
    ] {
        let ended = Command::new(PROGRAM).args(line.split(' ')).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(2) && said.contains(words), "{line}: {said}");
    }
    assert!(fs::metadata("nowhere").is_err(), "nothing is written for what is refused");
}

#[test]
fn what_cannot_run_in_parts_is_refused() {
    let impact = "run impact --until 1 --threads 2";
    for (line, words) in [
        ("run impact --until 1 --integrator verlet --threads 0", "threads = 0 is not valid: from 1 to 1024 threads"),
        ("run impact --until 1 --integrator verlet --threads 101", "at most as many parts as sites"),
        ("run impact --until 1 --tol 1e-6 --threads 2", "threads = 2 > 1 is not valid: a part has at least one site"),
        ("run impact --until 1 --integrator dop853 --threads 2", "integrator = dop853 is not valid: only splitting"),
        ("run dimer --until 1 --tol 1e-6 --set chain.sites=600 --threads 2", "run in one part"),
        ("run impact --until 1 --step 0.01 --integrator corrected --threads 2", "only splitting schemes"),
        ("run trivial-breather --threads 2", "an exact solution has no parts"),
        ("run impact --plan --ranks 0 --integrator verlet", "from 1 to the number of sites"),
        ("run impact --plan --ranks 2 --integrator dop853", "only splitting schemes"),
        ("run impact --plan --ranks 2 --integrator collocation", "ranks = 2 > 1"),
        ("run impact --ranks 2", "--plan"),
        (&format!("{impact} --checkpoint 0.5 --out nowhere --tol 1e-6"), "2 > 1"),
    ] {
        let ended = Command::new(PROGRAM).args(line.split(' ')).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(2) && said.contains(words), "{line}: {said}");
    }
    assert!(fs::metadata("nowhere").is_err(), "nothing is written for what is refused");
}

#[test]
fn a_plan_says_what_parts_need() {
    let said = |line: &str| {
        let ended = Command::new(PROGRAM).args(line.split(' ')).output().unwrap();
        assert!(ended.status.success(), "{line}: {}", String::from_utf8_lossy(&ended.stderr));
        String::from_utf8(ended.stdout).unwrap()
    };
    // More sites than memory: from the numbers of the scene alone.
    let large = said("run tw-q15 --plan --ranks 1024 --set chain.sites=1000000000");
    assert!(large.contains("at most 976563 each") && large.contains("refused if run"), "{large}");
    let windows = said("run impact --plan --ranks 3 --set chain.sites=1000 --integrator collocation");
    assert!(windows.contains("1000 sites in 3 parts: at most 487 each, and 13 bonds of each"), "{windows}");
    assert!(windows.contains("every window an order of 136 B goes to all; a part sends 728 B"), "{windows}");
    let by_part = said("run impact --set chain.sites=1000 --integrator verlet --plan --ranks 4 --by-part");
    assert!(by_part.contains("no part has a whole state") && by_part.contains("4.000 kB for its state"), "{by_part}");
    let own = said("run impact --integrator strang-linear --plan --threads 3");
    assert!(own.contains("100 sites in 3 parts: at most 34 each, and 33 of each neighbour"), "{own}");
    assert!(own.contains("t from 0 to 100"), "what is said of any run is there too: {own}");
}
