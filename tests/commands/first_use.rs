//! What a new user meets: output that cannot be written, folders that are used again, wrong inputs.

use super::program::{command, names, read_json, refused, stdout, table};
use hertzchain::output::Archive;
use std::{
    collections::BTreeSet,
    fs::{self, File, OpenOptions},
    process::Stdio,
};

/// Every kind of command that prints, as briefly as it can be had; `paper verify` is in the next
/// test.
const PRINTING: [&str; 34] = [
    "--help",
    "-h",
    "--version",
    "help wave",
    "run tw-q15 --until 1",
    "run tw-q15 --until 1 --json",
    "run tw-q15 --plan",
    "run tw-q15 --plan --json",
    "run trivial-breather --help",
    "compare precompressed --integrators verlet --max-time 0.2",
    "scenes",
    "scenes --json",
    "scenes show cradle",
    "scenes show cradle --json",
    "scenes template",
    "scenes template --json",
    "integrators",
    "integrators --json",
    "study drift cradle --periods 5 --samples 3",
    "study stability --charts length --quick --integrators verlet --periods 1 --sites 10",
    "study theorem --epsilons 0.3,0.2 --horizon 0.1",
    "study lifetimes --epsilons 0.3 --rhos 5 --sites 20 --until 12",
    "wave tw-q15 --until 3",
    "wave modulation --sites 10",
    "breather bright --sites 10 --until 3",
    "breather dark --sites 5 --omega-b 2.03",
    "breather continue --sites 5 --from 2.03 --to 2.04 --step 5e-3",
    "orbit driven granular-crystal --settle 5 --set chain.sites=3 --set initial.site=1",
    "orbit continue granular-crystal --set chain.sites=3 --set initial.site=1 --settle 5 --to 1e-4 --max-points 3",
    "orbit mode defect --to 0.01 --max-points 3",
    "dps integrals --b 0 --r 1",
    "dps integrals --b 0 --r 1 --json",
    "dps homoclinic",
    "dps dark --sites 5",
];

/// A disk without any room, which Linux has as a device.
#[cfg(target_os = "linux")]
fn full_disk() -> File {
    OpenOptions::new().write(true).open("/dev/full").unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn every_command_whose_output_is_lost_says_so_and_fails() {
    for line in PRINTING {
        let output = command(line).stdout(full_disk()).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}: {said}");
        assert!(said.contains("error: standard output: No space left on device"), "{line}: {said}");
    }
}

/// What was computed is in the files, and nobody has to run it again.
#[cfg(target_os = "linux")]
#[test]
fn files_are_written_whether_anybody_can_read_what_is_printed_or_not() {
    let folder = tempfile::tempdir().unwrap();
    for (name, line, file) in [
        ("run", "run tw-q15 --until 1", "summary.json"),
        ("wave", "wave tw-q15 --until 3", "wave.json"),
        ("verify", "paper verify --section 3", "verify.json"),
    ] {
        // `paper verify` takes two seconds.
        let streams = [("stdout", 1), ("stderr", 0)];
        for (full, code) in streams.into_iter().take(if name == "verify" { 1 } else { 2 }) {
            let out = folder.path().join(name).join(full);
            let mut command = command(line);
            command.arg("--out").arg(&out);
            if full == "stdout" {
                command.stdout(full_disk())
            } else {
                command.stderr(full_disk())
            };
            assert_eq!(command.output().unwrap().status.code(), Some(code), "{name}, {full}");
            assert!(out.join(file).exists(), "{name}, {full}");
        }
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    for line in ["scenes template", "--help", "run tw-q15 --until 1 --json"] {
        let mut process = command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(process.stdout.take());
        let output = process.wait_with_output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "{line}: {output:?}");
    }
}

#[test]
fn a_second_run_leaves_nothing_of_the_first_beside_its_own_files_and_lists_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let listed = || -> BTreeSet<String> {
        let summary = read_json(&folder.path().join("summary.json"));
        summary["files"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let run = ["run", "cradle", "--until", "3", "--tol", "1e-6", "--out", out];
    stdout(&[&run[..], &["--events", "--checkpoint", "2"]].concat());
    let first = names(folder.path());
    assert_eq!(first, listed());
    let of_contacts = ["contacts.csv", "contacts.npz", "checkpoint.npz"].map(str::to_owned);
    assert!(of_contacts.iter().all(|name| first.contains(name)), "{first:?}");
    assert_eq!(first.contains("contacts.png"), cfg!(feature = "plot"));
    // What is not the program's stays, whatever it is called.
    for own in ["notes.txt", "contacts.txt", "old-contacts.csv"] {
        fs::write(folder.path().join(own), "mine").unwrap();
    }
    stdout(&run);
    let second = names(folder.path());
    assert!(listed().is_subset(&second) && !listed().iter().any(|name| name.starts_with("contacts")), "{second:?}");
    let ours = listed();
    let own: Vec<&str> = second.difference(&ours).map(String::as_str).collect();
    assert_eq!(own, ["contacts.txt", "notes.txt", "old-contacts.csv"]);
    // What a run refuses costs nothing of what is there.
    assert!(refused(&[&run[..], &["--samples", "99999999"]].concat(), 2).contains("at most 10^6"));
    assert_eq!(names(folder.path()), second);
}

#[test]
fn studies_remove_what_only_some_of_their_runs_write() {
    let folder = tempfile::tempdir().unwrap();
    let wave = folder.path().join("wave");
    let wave_out = ["wave", "tw-q15", "--until", "3", "--out", wave.to_str().unwrap()];
    stdout(&[&wave_out[..], &["--zeta", "0.01"]].concat());
    assert!(["ensemble.csv", "spread.csv"].iter().all(|name| names(&wave).contains(*name)));
    stdout(&wave_out);
    let left = names(&wave);
    let pictures: &[&str] = if cfg!(feature = "plot") { &["wave.png"] } else { &[] };
    let files = ["errors.csv", "profile.csv", "summary.csv", "wave.json", "wave.npz"];
    assert!(left.iter().eq([&files, pictures].concat()), "{left:?}");

    let charts = folder.path().join("charts");
    let chart = |name: &str, method: &str| {
        let line = "study stability --quick --periods 1 --sites 10 --work 1e4 --out";
        stdout(&format!("{line} {} --charts {name} --integrators {method}", charts.display()));
        names(&charts)
    };
    let first = chart("light", "verlet");
    assert!(first.contains("light.csv") && first.contains("light-ladder.csv"), "{first:?}");
    assert_eq!(first.contains("light-verlet.png"), cfg!(feature = "plot"), "{first:?}");
    let second = chart("length", "strang-linear");
    let left: Vec<_> = second.iter().filter(|name| name.starts_with("light")).collect();
    assert!(second.contains("length.csv") && left.is_empty(), "{second:?}");
}

#[test]
fn what_is_refused_leaves_no_folder_behind() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a/b");
    for line in [
        "study drift --periods 0",
        "study order --beads 1",
        "study theorem --epsilons 0",
        "study lifetimes --sites 1",
        "study stability --charts light --periods 0",
        "wave cradle",
        "wave tw-q15 --seeds 0",
        "wave modulation --sites 7",
        "breather bright --integrator verlet",
        "breather dark --omega-b 1",
        "breather doubled --step 0",
        "dps dark --sites 4",
        "run tw-q15 --tol 5",
        "paper verify --section 9",
        "paper figures --only tw-q16",
        "paper report --only all",
    ] {
        refused(&format!("{line} --out {}", out.display()), 2);
        assert!(names(folder.path()).is_empty(), "{line}");
    }
    // A folder that was there stays, also an empty one.
    fs::create_dir_all(&out).unwrap();
    refused(&format!("study drift --periods 0 --out {}", out.display()), 2);
    assert!(out.exists());
}

#[test]
fn profiles_are_arrays_only_and_the_same_numbers_as_csv() {
    let folder = tempfile::tempdir().unwrap();
    stdout(&["run", "cradle", "--until", "3", "--events", "--samples", "7", "--out", folder.path().to_str().unwrap()]);
    let (names, rows) = table(&folder.path().join("profiles.csv"));
    // A free chain of 20 sites has the bonds 1 to 19: bonds count as the sites to their right.
    let head: Vec<String> = ["t".to_owned()].into_iter().chain((1..20).map(|bond| format!("x{bond}"))).collect();
    assert_eq!(names, head.join(","));
    let archive = Archive::read(&folder.path().join("profiles.npz")).unwrap();
    let (t, strain) = (archive.array("t", &[8]).unwrap(), archive.array("strain", &[8, 19]).unwrap());
    let wanted: Vec<Vec<f64>> = t.iter().zip(strain.chunks(19)).map(|(t, x)| [&[*t], x].concat()).collect();
    assert_eq!(rows, wanted);
    for name in ["profiles.npz", "contacts.npz"] {
        let bytes = fs::read(folder.path().join(name)).unwrap();
        let members = bytes.windows(4).filter(|four| four == b"PK\x01\x02").count();
        let arrays = bytes.windows(6).filter(|six| six == b"\x93NUMPY").count();
        assert!(members == arrays && arrays >= 4, "{name}: {arrays} arrays, {members} members");
    }
}

#[test]
fn wrong_inputs_are_refused_in_words_that_help() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let write = |name: &str, text: &[u8]| {
        fs::write(folder.path().join(name), text).unwrap();
        path(name)
    };
    let toml = "[chain]\nsites = 3\nalpha = 1.5\nboundary = \"free\"\nname = \"x\"\n[initial]\nkind = \"state\"\n\
                u = [1.0, 2.0]\n[span]\nuntil = 1.0\n";
    let astray = write("astray.toml", toml.as_bytes());
    let short = write("short.toml", toml.replace("name = \"x\"\n", "").as_bytes());
    // Only the first site has a resonator that moves: that of the second is fixed.
    let alone =
        toml.replace("name = \"x\"", "kappa = 1.0\n[beads]\nrho = [1.0, inf, 0.0]").replace("2.0]", "2.0, 0.0]");
    let alone = write("alone.toml", alone.as_bytes());
    let (csv, empty, bytes) = (write("x.csv", b"a,b\n1,2\n"), write("empty", b""), write("bytes", b"\xff\xfe\0"));
    let (below, nowhere) = (path("empty/below"), path("nowhere.json"));
    for (args, code, words) in [
        (&["run", "tw-q15", "--until", "1", "--out", &csv][..], 1, "results are written to a folder, and"),
        (&["run", "tw-q15", "--until", "1", "--out", &below], 1, "empty is none"),
        (&["run", &astray], 2, "line 5: unknown field `name`"),
        (&["run", &astray], 2, "`name` stands above all tables"),
        (&["run", &short], 2, "line 7: `initial.u`: u = 2 numbers for 3 sites is not valid"),
        (&["run", &csv], 2, "line 1: `a,b`"),
        (&["run", &bytes], 2, "not valid UTF-8"),
        (&["run", ""], 2, "unknown scene \"\"; one of tw-q15,"),
        (&["run", "tw-q15", "--set", "rho=3"], 2, "did you mean `chain.rho`?"),
        (&["run", "tw-q15", "--set", "epsilon=3"], 2, "did you mean `initial.epsilon`?"),
        (&["run", "cradle", "--set", "initial.epsilon=3"], 2, "expected one of `site`, `displacement`, `velocity`\n"),
        (&["run", "tw-q15", "--set", "chain.span=3"], 2, "unknown field `span`, expected one of"),
        (&["run", "impact", "--set", "initial.velocity=1e200"], 2, "`initial.velocity`: velocity = 1e200 is not"),
        (&["run", "impact", "--set", "initial.displacement=1e200"], 2, "displacement = 1e200 is not valid: overflow"),
        (&["run", &short, "--set", "initial.u=[0, 0, 1e-200]"], 2, "`initial.u`: u = 1e-200 is not valid: underflow"),
        (
            &["run", &alone, "--set", "initial.v=[0, 0.1, 0]"],
            2,
            "`initial.v`: v = 0.1 at site 1 is not valid: no reson",
        ),
        (&["run", &alone, "--set", "initial.v_dot=[0, 0, -1]"], 2, "v_dot = -1 at site 2 is not valid: no resonator"),
        (
            &["run", &short, "--set", "initial.u=[0, 0, 0]", "--set", "initial.v=[0.1, 0, 0]"],
            2,
            "no resonator moves in this chain: leave `v` and `v_dot` out",
        ),
        (&["run", "tw-q15", "--until", "10s"], 2, "invalid value '10s' for '--until <T>': not a number"),
        (&["run", "tw-q15", "--integrator", "Verlet"], 2, "did you mean \"verlet\"?"),
        (&["run", "--resume", &empty], 2, "not an NPZ file"),
        (&["breather", "evolve", &astray], 2, "archive: not an NPZ file"),
        (&["breather", "evolve", &csv], 2, "archive: not an NPZ file"),
        (&["breather", "evolve", &empty], 2, "archive: not an NPZ file"),
        (&["breather", "evolve", &csv, "--tol", "0.5"], 2, "error: --tol = 0.5 is not valid: from 1e-15 to 0.1"),
        (&["breather", "evolve", &nowhere], 1, "nowhere.json: No such file"),
        (&["breather", "evolve", &csv, "--point", "x"], 2, "'--point <K>': not a whole number"),
    ] {
        let said = refused(args, code);
        assert!(said.contains(words), "{args:?}: {said}\n  wanted: {words}");
    }
}

/// Words that are no Unicode must not be a panic, wherever they stand.
#[cfg(unix)]
#[test]
fn arguments_that_are_no_text_are_refused() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt};
    let odd = OsStr::from_bytes(b"\xff");
    for (args, code) in
        [(&["run"][..], 2), (&["nosuch"], 2), (&["run", "tw-q15", "--set"], 2), (&["scenes", "show"], 2)]
    {
        let output = command(args).arg(odd).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && said.starts_with("error: "), "{args:?}: {said}");
    }
}
