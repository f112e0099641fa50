//! `hertzchain figures`: every file is there, the numbers are those of `wave`, and one failure does not cost the others.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::{
    collections::BTreeSet,
    path::Path,
    process::{Command, Output},
};

fn hertzchain(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args).output().unwrap()
}

fn figures(only: &str, out: &Path) -> (Value, Output) {
    let output = hertzchain(&["figures", "--only", only, "--out", out.to_str().unwrap(), "--json"]);
    (serde_json::from_slice(&output.stdout).unwrap(), output)
}

fn files(folder: &Path) -> BTreeSet<String> {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn rows(csv: &str) -> Vec<Vec<f64>> {
    csv.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// Without pictures if there is nothing to draw them with.
fn expected(names: &[&str]) -> BTreeSet<String> {
    names.iter().filter(|name| cfg!(feature = "plot") || !name.ends_with(".png")).map(|name| name.to_string()).collect()
}

#[test]
fn each_figure_has_its_picture_and_its_tables_and_the_same_bytes_twice() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    // Asked for twice and out of order: drawn once, in the order of the paper.
    let runs = folders.each_ref().map(|folder| figures("tw-breakdown, tw-q15,tw-breakdown", folder.path()));
    for (study, output) in &runs {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let names: Vec<&str> =
            study["figures"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["tw-q15", "tw-breakdown"]);
    }
    let [one, other] = folders.each_ref().map(|folder| folder.path());
    let all = expected(&[
        "tw-q15.png",
        "tw-q15-errors.csv",
        "tw-q15-profile.csv",
        "tw-breakdown.png",
        "tw-breakdown-q15-errors.csv",
        "tw-breakdown-q15-profile.csv",
        "tw-breakdown-q45-errors.csv",
        "tw-breakdown-q45-profile.csv",
    ]);
    assert_eq!((files(one), files(other)), (all.clone(), all.clone()));
    let listed = runs[0].0["figures"].as_array().unwrap().iter().flat_map(|one| one["files"].as_array().unwrap());
    assert_eq!(listed.map(|name| name.as_str().unwrap().to_owned()).collect::<BTreeSet<_>>(), all);
    for name in all {
        let [first, second] = [one, other].map(|folder| std::fs::read(folder.join(&name)).unwrap());
        assert!(first == second, "{name} differs");
        assert!(!name.ends_with(".png") || first.starts_with(b"\x89PNG"));
    }
    let figure = &runs[0].0["figures"][0];
    assert!(figure["failure"].is_null() && figure["wall_s"].as_f64().is_some_and(|wall| wall > 0.0));
    let caption = figure["caption"].as_str().unwrap();
    let told = [
        "N = 50",
        "α = 1.5",
        "κ = 1",
        "ρ = 0.3333",
        "q = 0.2 π",
        "a = 1",
        "b = 1",
        "collocation, tol 1e-10",
        "fig:tw_r03_q15pi",
    ];
    assert!(told.iter().all(|what| caption.contains(what)), "{caption}");
}

// Truth: the command `wave`, and the definition of tilde E from the two profiles.
#[test]
fn the_numbers_of_a_perturbed_figure_are_those_of_wave() {
    let folder = tempfile::tempdir().unwrap();
    let (_, output) = figures("tw-rho3", folder.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let wave = hertzchain(&["wave", "tw-rho3", "--zeta", "0.01", "--seed", "1", "--json"]);
    let wave: Value = serde_json::from_slice(&wave.stdout).unwrap();
    let read = |table: &str| std::fs::read_to_string(folder.path().join(format!("tw-rho3-{table}.csv"))).unwrap();

    let errors = read("errors");
    assert_eq!(errors.lines().next().unwrap(), "t,e_x,e_y,e_x_perturbed,e_y_perturbed,tilde_e_x,tilde_e_y");
    let errors = rows(&errors);
    assert_eq!(errors.len() as u64, wave["samples"].as_u64().unwrap());
    let last = errors.last().unwrap();
    let of = |value: &Value, name: &str| value[name].as_f64().unwrap();
    let perturbed = &wave["perturbed"];
    let truth = [
        of(&wave, "t"),
        of(&wave, "e_x_final"),
        of(&wave, "e_y_final"),
        of(perturbed, "e_x_final"),
        of(perturbed, "e_y_final"),
        of(perturbed, "tilde_e_x_final"),
        of(perturbed, "tilde_e_y_final"),
    ];
    // Equal but for the rounding of who reads it.
    assert!(last.iter().zip(truth).all(|(a, b)| (a / b - 1.0).abs() < 1e-15), "{last:?} is not {truth:?}");

    let profile = read("profile");
    assert_eq!(
        profile.lines().next().unwrap(),
        "n,x,y,x_ansatz,y_ansatz,x_perturbed,y_perturbed,x_perturbed_ansatz,y_perturbed_ansatz"
    );
    let profile = rows(&profile);
    assert_eq!(profile.len(), 50);
    // 2 epsilon kappa a = 0.02, rho = 3.
    let distance = |one: usize, other: usize, scale: f64| {
        scale * profile.iter().map(|row| (row[one] - row[other]).abs()).fold(0.0, f64::max) / 0.02
    };
    for (value, truth) in [
        (distance(1, 3, 1.0), last[1]),
        (distance(2, 4, 3.0), last[2]),
        (distance(5, 7, 1.0), last[3]),
        (distance(6, 8, 3.0), last[4]),
        (distance(5, 1, 1.0), last[5]),
        (distance(6, 2, 3.0), last[6]),
    ] {
        assert!((value / truth - 1.0).abs() < 1e-12, "{value} is not {truth}");
    }

    // Every seed from 1 on, the one shown among them: it lies within the range at each time.
    let spread = rows(&read("spread"));
    assert_eq!((spread.len(), rows(&read("ensemble")).len()), (errors.len(), 12));
    assert!(errors.iter().zip(&spread).all(|(at, range)| range[1] <= at[5] && at[5] <= range[5]));
}

// Truth: the command `dps dark`, at c = 0 with 41 sites.
#[test]
fn the_dark_profiles_are_those_of_dps_dark() {
    let folder = tempfile::tempdir().unwrap();
    let (study, output) = figures("dps-dark", folder.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(
        files(folder.path()),
        expected(&["dps-dark.png", "dps-dark-site-profile.csv", "dps-dark-bond-profile.csv"])
    );
    let caption = study["figures"][0]["caption"].as_str().unwrap();
    for told in ["α = 1.5", "κ = 1", "c = 0", "ring of 41 sites", "δ⁻a = ±0.1492", "fig:sw_anbn"] {
        assert!(caption.contains(told), "{told}: {caption}");
    }
    for center in ["site", "bond"] {
        let dark = hertzchain(&["dps", "dark", "--center", center, "--json"]);
        let dark: Value = serde_json::from_slice(&dark.stdout).unwrap();
        let csv = std::fs::read_to_string(folder.path().join(format!("dps-dark-{center}-profile.csv"))).unwrap();
        assert_eq!((csv.lines().next(), csv.lines().count()), (Some("n,a,b"), 42));
        for (k, row) in rows(&csv).into_iter().enumerate() {
            for (value, name) in row.into_iter().zip(["n", "a", "b"]) {
                let truth = dark[name][k].as_f64().unwrap();
                assert!((value - truth).abs() <= 2.0 * f64::EPSILON * truth.abs(), "{center} {name} {k}");
            }
        }
    }
}

#[test]
fn unknown_names_are_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("none");
    for (name, hint) in
        [("tw-q51", "did you mean \"tw-q15\"?"), ("tw-q15,", "unknown figure \"\""), ("tw-rho10", "tw-rho10-1000")]
    {
        let output = hertzchain(&["figures", "--only", name, "--out", out.to_str().unwrap()]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && text.contains(hint) && output.stdout.is_empty(), "{name}: {text}");
    }
    assert!(!out.exists());
}

#[test]
fn a_figure_that_fails_does_not_lose_the_others() {
    let folder = tempfile::tempdir().unwrap();
    // A folder in the place of a file.
    std::fs::create_dir_all(folder.path().join("tw-q15-profile.csv/in the way")).unwrap();
    let (study, output) = figures("tw-q15,tw-breakdown", folder.path());
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && text.contains("error: figure tw-q15: ") && !text.contains("panicked"),
        "{text}"
    );
    let [failed, other] = [&study["figures"][0], &study["figures"][1]];
    assert!(
        failed["failure"].as_str().is_some_and(|why| why.contains("tw-q15-profile.csv")) && failed["caption"].is_null()
    );
    assert!(other["failure"].is_null());
    for name in other["files"].as_array().unwrap() {
        assert!(folder.path().join(name.as_str().unwrap()).is_file());
    }
}
