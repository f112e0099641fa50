//! What a new user meets: output that cannot be written, folders that are used again, wrong inputs.

use super::program::{command, names, read_json, refused, stdout};
use std::{
    collections::BTreeSet,
    fs::{self, File, OpenOptions},
    process::Stdio,
};

/// Commands that print, by clap, as text, as JSON and as a page; `paper verify` is in the next test.
const PRINTING: [&str; 10] = [
    "--help",
    "--version",
    "run tw-q15 --until 1",
    "run tw-q15 --until 1 --json",
    "run tw-q15 --plan",
    "scenes show cradle --json",
    "scenes template",
    "study theorem --epsilons 0.3,0.2 --horizon 0.1",
    "orbit mode defect --to 0.01 --max-points 3",
    "dps integrals --b 0 --r 1",
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
