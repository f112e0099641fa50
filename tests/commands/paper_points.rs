//! `paper verify` as a sweep; `paper figures` and signals.

use super::{
    program::{lines, terminate, wait},
    shards::{command, in_shards},
};
use hertzchain::{breathers::MovingBreather, chain::Params, error::Error, interrupt::Token};
use serde_json::Value;
use std::{process::Stdio, thread::sleep, time::Duration};

#[test]
fn verdicts_in_three_shards_have_the_files_of_one_process() {
    in_shards("paper verify --section 3");
}

#[test]
fn figures_that_are_asked_to_end_keep_what_is_finished_and_no_part_of_the_rest() {
    let (parts, line) = (tempfile::tempdir().unwrap(), "paper figures --only homoclinics,lifetime-map");
    let parts = parts.path();
    let mut process = command(line, parts, &["--json"]);
    let mut process = process.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait(&mut process, &parts.join("homoclinics.json"), 1);
    // The map takes seconds, and gives what it has of its points when it is asked to end.
    sleep(Duration::from_millis(200));
    terminate(&process);
    let ended = process.wait_with_output().unwrap();
    let told = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(143), "{told}");
    assert!(told.contains("1 of 2 figures are missing: --only lifetime-map makes them"), "{told}");
    let study: Value = serde_json::from_slice(&ended.stdout).unwrap();
    let [done, missing] = [&study["figures"][0], &study["figures"][1]];
    assert!(done["failure"].is_null() && missing["caption"].is_null() && missing["wall_s"].is_null(), "{study}");
    assert!(missing["failure"].as_str().unwrap().contains("stopped by a signal"), "{study}");
    assert!(
        parts.join("homoclinics-site-homoclinic.csv").exists() && !parts.join("lifetime-map-lifetimes.csv").exists()
    );
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
