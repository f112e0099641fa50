//! `paper figures` and `paper verify` as sweeps: shards, kills, signals, files that were changed.

use super::{
    program::{lines, terminate, wait},
    shards::{command, files, in_shards, killed_at, output},
};
use hertzchain::{
    breathers::{MovingBreather, Relative},
    chain::Params,
    error::Error,
    interrupt::Token,
};
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Stdio,
    sync::OnceLock,
    thread::sleep,
    time::Duration,
};

const FIGURES: &str = "paper figures --only homoclinics,dark-profiles,exact-wave,exact-limits";

fn said(line: &str, out: &Path) -> String {
    let output = output(line, out, &[]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{line}: {said}");
    said
}

const MAP: &str = "paper figures --only homoclinics,lifetime-map";

/// The folder of [`MAP`], made once for all tests.
pub(super) fn with_map() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("with-map");
        let _ = fs::remove_dir_all(&folder);
        said(MAP, &folder);
        folder
    })
}

/// The lines of a store, sorted.
fn kept(store: &Path) -> Vec<String> {
    let text = fs::read_to_string(store).unwrap();
    let mut lines: Vec<String> = text.lines().skip(1).map(str::to_owned).collect();
    lines.sort();
    lines
}

#[test]
fn figures_and_verdicts_in_three_shards_have_the_files_of_one_process() {
    in_shards(FIGURES);
    in_shards("paper verify --section 3");
}

// A line has the wall time of its figure: if the figure were made again, its line would be another.
#[test]
fn figures_that_are_killed_repeat_what_was_in_flight_only() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    assert!(!said(FIGURES, whole).contains("remove it to make them anew"));
    let store = parts.join("figures.store");
    let before = killed_at(FIGURES, parts, &store, &[2, 3, 4]);
    let told = said(FIGURES, parts);
    assert!(told.contains(&format!("{} of 4 figures are from", before.len())), "{told}");
    let now = fs::read_to_string(&store).unwrap();
    assert!(before.iter().all(|line| now.contains(line.as_str())));
    assert!(files(whole) == files(parts));
}

#[test]
fn figures_that_are_asked_to_end_keep_what_is_finished_and_no_part_of_the_rest() {
    let (parts, line) = (tempfile::tempdir().unwrap(), MAP);
    let parts = parts.path();
    let store = parts.join("figures.store");
    let mut process = command(line, parts, &["--json"]);
    let mut process = process.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait(&mut process, &store, 2);
    // The map takes seconds, and gives what it has of its points when it is asked to end.
    sleep(Duration::from_millis(200));
    terminate(&process);
    let ended = process.wait_with_output().unwrap();
    let told = String::from_utf8(ended.stderr).unwrap();
    assert_eq!((ended.status.code(), lines(&store)), (Some(143), 2), "{told}");
    assert!(told.contains("1 of 2 figures are missing: the same command goes on"), "{told}");
    let study: Value = serde_json::from_slice(&ended.stdout).unwrap();
    let [done, missing] = [&study["figures"][0], &study["figures"][1]];
    assert!(done["failure"].is_null() && missing["caption"].is_null() && missing["wall_s"].is_null(), "{study}");
    assert!(missing["failure"].as_str().unwrap().contains("stopped by a signal"), "{study}");
    assert!(parts.join("homoclinics-site-homoclinic.csv").exists() && parts.join("homoclinics.json").exists());
    assert!(!parts.join("lifetime-map-lifetimes.csv").exists());
    let first = kept(&store);
    assert!(said(line, parts).contains("1 of 2 figures are from"));
    assert!(kept(&store).contains(&first[0]));
    assert!(files(with_map()) == files(parts));
}

#[test]
fn files_of_figures_that_were_changed_or_removed_are_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let (out, line) = (folder.path(), "paper figures --only dark-profiles,exact-wave");
    said(line, out);
    let whole = files(out);
    let name = |end: &str| whole.iter().map(|(name, _)| name).find(|name| name.ends_with(end)).unwrap();
    let modified = |name: &str| fs::metadata(out.join(name)).unwrap().modified().unwrap();
    let (changed, removed) = (name(".csv").clone(), "exact-wave.json");
    let untouched = whole.iter().map(|(name, _)| name).rfind(|name| name.ends_with(".csv")).unwrap();
    assert_ne!(&changed, untouched);
    let before = modified(untouched);
    let mut bytes = fs::read(out.join(&changed)).unwrap();
    // Of the same length.
    bytes[0] ^= 1;
    fs::write(out.join(&changed), bytes).unwrap();
    fs::remove_file(out.join(removed)).unwrap();
    assert!(said(line, out).contains("2 of 2 figures are from"));
    assert!(files(out) == whole && modified(untouched) == before);
    // Nothing of a store that was altered is used, and it is not overwritten.
    let store = out.join("figures.store");
    let altered = fs::read_to_string(&store).unwrap().replacen("caption", "capture", 1);
    fs::write(&store, &altered).unwrap();
    let refused = output(line, out, &[]);
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(
        refused.status.code() == Some(2) && told.contains("figures.store, line 2: not as it was written"),
        "{told}"
    );
    assert!(fs::read_to_string(&store).unwrap() == altered && refused.stdout.is_empty());
}

#[cfg(feature = "plot")]
#[test]
fn a_figure_in_another_format_is_another_point() {
    let folder = tempfile::tempdir().unwrap();
    let (out, line) = (folder.path(), "paper figures --only dark-profiles");
    let names = |out: &Path| {
        let names = files(out).into_iter().map(|(name, _)| name);
        names.filter(|name| name.ends_with(".png") || name.ends_with(".svg")).collect::<Vec<_>>()
    };
    said(line, out);
    let whole = files(out);
    assert_eq!(names(out), ["dark-profiles.png"]);
    let svg = format!("{line} --format svg");
    assert!(!said(&svg, out).contains("are from"));
    assert_eq!(names(out), ["dark-profiles.svg"]);
    assert!(said(line, out).contains("1 of 1 figures are from"));
    assert!(files(out) == whole && lines(&out.join("figures.store")) == 3);
    assert!(said(&svg, out).contains("1 of 1 figures are from"));
}

#[test]
fn verdicts_that_are_asked_to_end_say_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (out, line) = (folder.path(), "paper verify --section 4");
    let store = out.join("verify.store");
    let mut process = command(line, out, &[]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait(&mut process, &store, 1);
    sleep(Duration::from_millis(500));
    terminate(&process);
    let ended = process.wait_with_output().unwrap();
    let told = String::from_utf8(ended.stderr).unwrap();
    let there = lines(&store) - 1;
    assert_eq!(ended.status.code(), Some(143), "{told}");
    assert!(told.contains(&format!("{there} of 3 points are computed; those in --out are kept")), "{told}");
    assert!(ended.stdout.is_empty() && !out.join("verify.csv").exists());
}

// The figure `moving` takes long, and a search for a moving breather is most of it.
#[test]
fn a_search_for_a_moving_breather_ends_when_it_is_asked_to() {
    let params = Params::new(1.5, 1.0, 1.0 / 3.0).unwrap();
    let breather = MovingBreather { params, sites: 9, omega_b: 2.05, turns: 20 };
    let start: Vec<f64> = (0..36).map(|k| (0.1 * f64::from(k)).sin()).collect();
    let token = Token::new();
    token.ask();
    assert!(matches!(token.within(|| breather.solve(&start, 1e-10)), Err(Error::Stopped { .. })));
    assert!(!matches!(breather.solve(&start, 1e-10), Err(Error::Stopped { .. })));
}
