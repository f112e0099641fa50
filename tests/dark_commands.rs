//! `dark`, `continue` and `doubled` as machines read them.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::process::{Command, Output};

fn hertzchain(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args).output().unwrap()
}

fn json(args: &[&str]) -> Value {
    let output = hertzchain(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refusal(args: &[&str]) -> String {
    let output = hertzchain(args);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && !text.contains("panicked"), "{args:?}: {text}");
    text
}

#[test]
fn dark_keeps_its_contract() {
    let one = json(&["dark", "--center", "bond", "--omega-b", "2.05", "--json"]);
    for (key, count) in [("x", 41), ("y", 41), ("n", 41), ("multipliers", 164), ("tau", 82)] {
        assert_eq!(one[key].as_array().unwrap().len(), count, "{key}");
    }
    for key in ["period", "residual", "k_x", "k_y", "c_x", "c_y", "e_b", "max_modulus", "mean_force"] {
        assert!(one[key].is_f64(), "{key}");
    }
    assert!((one["k_x"].as_f64().unwrap() - 0.149_644_582_321).abs() < 1e-12);
    assert!((one["max_modulus"].as_f64().unwrap() - 1.075_209_459_199).abs() < 1e-9);
    // Theorem nobreath: the mean force does not depend on the bond.
    assert!(one["mean_force_spread"].as_f64().unwrap() < 1e-12 * one["mean_force"].as_f64().unwrap());
    for key in ["re", "im", "modulus", "error", "kind", "krein"] {
        assert!(!one["multipliers"][0][key].is_null(), "{key}");
    }
    assert!(one["newton"].as_array().unwrap().iter().all(|step| step["residual"].is_f64() && step["step"].is_f64()));
    assert!(one["quality"]["symplectic_defect"].as_f64().unwrap() < 1e-12);
}

#[test]
fn a_branch_is_written_and_says_what_happens_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let args =
        ["continue", "--center", "bond", "--from", "2.062", "--to", "2.064", "--step", "1e-3", "--json", "--out", out];
    let branch = json(&args);
    let points = branch["points"].as_array().unwrap();
    assert_eq!(points.last().unwrap()["parameter"], 2.064);
    assert!(points.iter().all(|point| point["k_x"].is_f64() && point["k_y"].is_f64() && point["leading"].is_array()));
    assert_eq!(branch["bifurcations"][0]["kind"], "period-doubling");
    assert!((branch["bifurcations"][0]["parameter"].as_f64().unwrap() - 2.063_258_452).abs() < 1e-9);
    assert!(branch["bifurcations"][0]["period"].is_f64());
    for name in ["branch.json", "branch.csv", "branch.npz"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
}

#[test]
fn a_branch_goes_along_other_parameters_too() {
    // The mass ratio at fixed frequency: rho = 0.5 has omega = 1.732.
    let branch = json(&[
        "continue",
        "--parameter",
        "rho",
        "--from",
        "0.5",
        "--to",
        "0.52",
        "--omega-b",
        "1.75",
        "--sites",
        "21",
        "--json",
    ]);
    let points = branch["points"].as_array().unwrap();
    assert_eq!((points[0]["rho"].as_f64(), points.last().unwrap()["rho"].as_f64()), (Some(0.5), Some(0.52)));
    assert!(points.iter().all(|point| point["omega_b"] == 1.75));
    assert_eq!(branch["end"], "reached");
}

#[test]
fn what_cannot_be_is_refused_by_name_and_rule() {
    assert!(refusal(&["dark", "--sites", "40"]).contains("sites = 40"));
    assert!(refusal(&["dark", "--omega-b", "2"]).contains("omega_b = 2"));
    assert!(refusal(&["dark", "--tol", "1"]).contains("tol"));
    assert!(refusal(&["dark", "--rho", "inf"]).contains("rho = inf"));
    assert!(refusal(&["continue", "--parameter", "omega"]).contains("did you mean \"omega_b\""));
    assert!(refusal(&["continue", "--parameter", "rho"]).contains("--from"));
    assert!(refusal(&["continue", "--omega-b", "2.05"]).contains("--from"));
    assert!(refusal(&["continue", "--from", "2.05", "--to", "2.05"]).contains("to = 2.05"));
    assert!(refusal(&["continue", "--step", "0"]).contains("step = 0"));
    assert!(refusal(&["doubled", "--most", "2.02", "--step", "0.01"]).contains("no period doubling"));
}
