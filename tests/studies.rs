//! The studies `scaling` and `drift` as people and machines use them.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::process::{Command, Output};

fn hertzchain(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args).output().unwrap()
}

fn json(args: &[&str]) -> Value {
    let output = hertzchain(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "no bar off a terminal: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The line of a refusal, with a non-zero exit code.
fn refusal(args: &[&str]) -> String {
    let output = hertzchain(args);
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(!output.status.success(), "{args:?} must be refused");
    assert!(!text.contains("panicked") && output.stdout.is_empty(), "{args:?}: {text}");
    text
}

/// Equal but for the rounding of who reads it.
fn near(value: &Value, number: f64) -> bool {
    (value.as_f64().unwrap() / number - 1.0).abs() < 1e-15
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// The one row of an integrator with so many sites.
fn row<'a>(study: &'a Value, integrator: &str, sites: u64) -> &'a Value {
    let mut rows = study["rows"].as_array().unwrap().iter();
    rows.find(|row| row["integrator"] == integrator && row["sites"] == sites).unwrap()
}

// Measured: collocation 820, 1150, 1530 for 10, 50, 500 sites; dop853-regularised 5259 and 19383 for 10 and 50.
#[test]
fn scaling_json_keeps_its_contract_and_collocation_works_no_more_a_bond_on_a_longer_ring() {
    let study = json(&["scaling", "--sites", "500,10,50", "--seed", "7", "--max-time", "1", "--json"]);
    assert!(near(&study["tol"], 1e-9) && study["seed"] == 7);
    let periods = study["periods"].as_f64().unwrap();
    let rows = study["rows"].as_array().unwrap();
    let order: Vec<(&str, u64)> =
        rows.iter().map(|row| (row["integrator"].as_str().unwrap(), row["sites"].as_u64().unwrap())).collect();
    let methods = ["collocation", "dop853", "dop853-regularised"];
    assert_eq!(order, methods.map(|method| [10, 50, 500].map(|sites| (method, sites))).concat());
    for row in rows {
        assert!(row["steps"].is_u64() && row["rejected"].is_u64());
        match row["failure"].as_str() {
            None => {
                let per_bond_period = row["wall"].as_f64().unwrap() / (row["sites"].as_f64().unwrap() * periods);
                assert!((row["per_bond_period"].as_f64().unwrap() / per_bond_period - 1.0).abs() < 1e-12);
                assert!(row["steps"].as_u64().unwrap() > 0 && row["runs"].as_u64().unwrap() > 0);
            }
            Some(why) => assert!(why.contains("left out") && row["wall"].is_null() && row["per_bond_period"].is_null()),
        }
    }
    // Counted, not timed. The count of collocation is that of the block with the most sweeps.
    let forces = |integrator, sites| row(&study, integrator, sites)["force_evaluations"].as_f64().unwrap();
    assert!(row(&study, "collocation", 500)["failure"].is_null());
    assert!(forces("collocation", 500) < 2.0 * forces("collocation", 50));
    assert!(forces("dop853-regularised", 50) > 2.0 * forces("dop853-regularised", 10));
}

#[test]
fn scaling_writes_table_csv_json_and_png() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/er");
    let output = hertzchain(&["scaling", "--sites", "10,20", "--tol", "1e-6", "--out", out.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("ns/bond/period") && text.contains("one thread"), "{text}");
    let csv = std::fs::read_to_string(out.join("scaling.csv")).unwrap();
    assert_eq!(csv.lines().count(), 7);
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    let study: Value = serde_json::from_slice(&std::fs::read(out.join("scaling.json")).unwrap()).unwrap();
    assert!(near(&study["tol"], 1e-6));
    let png = std::fs::read(out.join("scaling.png"));
    assert_eq!(png.is_ok_and(|png| png.starts_with(b"\x89PNG")), cfg!(feature = "plot"));
}

#[test]
fn drift_json_keeps_its_contract() {
    let study = json(&["drift", "--periods", "150", "--samples", "40", "--json"]);
    assert_eq!((study["scene"].as_str(), study["periods"].as_f64()), (Some("bright-breather-16"), Some(150.0)));
    let period = study["period"].as_f64().unwrap();
    let rows = study["rows"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["integrator"].as_str().unwrap()).collect();
    assert_eq!(names, ["collocation", "strang-linear", "yoshida4-linear"]);
    for row in rows {
        let (t, errors) = (numbers(&row["t"]), numbers(&row["energy_error"]));
        assert_eq!((t.len(), errors.len()), (40, 40));
        assert!(t[0] == period && (t[39] / (150.0 * period) - 1.0).abs() < 1e-15);
        let ratio = t[1] / t[0];
        assert!(t.windows(2).all(|pair| (pair[1] / pair[0] / ratio - 1.0).abs() < 1e-12));
        assert!(errors.windows(2).all(|pair| pair[0] <= pair[1]), "the largest so far never falls");
        assert!(
            row["slope"].is_f64() && row["wall"].is_f64() && row["setting"].is_string() && row["failure"].is_null()
        );
    }
    // The tolerance of the first is 1e-13; 64 kicks a period of the others see contacts that last a tenth of it.
    let last = |row: &Value| numbers(&row["energy_error"])[39];
    assert!(last(&rows[0]) < 1e-12, "{:e}", last(&rows[0]));
    assert!(rows[1..].iter().all(|row| (1e-6..0.1).contains(&last(row))));
    assert_eq!(rows[1]["steps"], 64 * 150);
}

#[test]
fn drift_writes_table_csv_json_and_png() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let args = ["drift", "tw-q15", "--periods", "5", "--integrators", "verlet,dop853", "--samples", "9", "--out", out];
    let output = hertzchain(&args);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("64 kicks/period") && text.contains("tol 1e-13"), "{text}");
    let csv = std::fs::read_to_string(folder.path().join("drift.csv")).unwrap();
    assert_eq!(csv.lines().next().unwrap(), "integrator,setting,t,energy_error");
    assert_eq!(csv.lines().count(), 1 + 2 * 9);
    let study: Value = serde_json::from_slice(&std::fs::read(folder.path().join("drift.json")).unwrap()).unwrap();
    assert!(study["rows"][0]["slope"].is_null(), "five periods are less than two decades");
    let png = std::fs::read(folder.path().join("drift.png"));
    assert_eq!(png.is_ok_and(|png| png.starts_with(b"\x89PNG")), cfg!(feature = "plot"));
}

// Between walls and pressed by 10, the contacts swing at about 4; 64 steps of a "period" of 100 are unstable.
#[test]
fn a_method_that_fails_keeps_what_it_had() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stiff.toml");
    let text = "name = \"stiff\"\n[chain]\nsites = 3\nalpha = 1.5\nkappa = 0.0\nrho = 0.0\nboundary = \"fixed\"\n\
                precompression = 10.0\n[initial]\nkind = \"state\"\nu = [0.1, 0.2, -0.1]\n[span]\nperiods = 1\nperiod = 100.0\n";
    std::fs::write(&path, text).unwrap();
    let args = ["drift", path.to_str().unwrap(), "--periods", "30", "--integrators", "verlet,dop853", "--json"];
    let study = json(&args);
    let [failed, other] = [&study["rows"][0], &study["rows"][1]];
    assert!(failed["failure"].as_str().is_some_and(|why| why.contains("unstable") || why.contains("not finite")));
    assert_eq!(numbers(&failed["t"]).len(), numbers(&failed["energy_error"]).len());
    assert!(failed["slope"].is_null());
    assert!(other["failure"].is_null() && numbers(&other["t"]).len() == 200);
}

#[test]
fn bad_numbers_and_names_are_refused() {
    for (flag, value, rule) in [
        ("--sites", "0", "sites = 0 is not valid: a multiple of 10"),
        ("--sites", "50,55", "sites = 55 is not valid"),
        ("--sites", "1000000000000", "10^6"),
        ("--sites", "-50", "--sites"),
        ("--sites", "", "--sites"),
        ("--tol", "0", "tol = 0 is not valid: from 1e-15 to 0.1"),
        ("--tol", "-1", "tol = -1"),
        ("--tol", "nan", "tol = NaN"),
        ("--tol", "1e30", "tol = 1e30"),
        ("--tol", "1e-16", "from 1e-15 to 0.1"),
        ("--sites", "nan", "invalid value 'nan' for '--sites"),
        ("--sites", "1e18", "invalid value '1e18' for '--sites"),
        ("--max-time", "-5", "max-time = -5 is not valid"),
        ("--seed", "99999999999999999999", "--seed"),
        ("--max-time", "0", "max-time = 0 is not valid"),
        ("--max-time", "nan", "max-time = NaN"),
        ("--max-time", "inf", "max-time = inf"),
        ("--seed", "-1", "--seed"),
    ] {
        let message = refusal(&["scaling", flag, value, "--json"]);
        assert!(message.contains(rule), "{flag} {value}: {message}");
    }
    for (flag, value, rule) in [
        ("--periods", "0", "periods = 0 is not valid: from 1 to 10^9"),
        ("--periods", "-3", "periods = -3"),
        ("--periods", "nan", "periods = NaN"),
        ("--periods", "1e300", "periods = 1e300"),
        ("--periods", "inf", "periods = inf"),
        ("--periods", "0.5", "periods = 0.5 is not valid: from 1 to 10^9"),
        ("--samples", "1", "samples = 1 is not valid: from 2 to 10^5"),
        ("--samples", "nan", "invalid value 'nan' for '--samples"),
        ("--samples", "0", "samples = 0 is not valid: from 2 to 10^5"),
        ("--samples", "1000000000", "samples = 1000000000"),
        ("--samples", "-1", "--samples"),
        ("--integrators", "colocation", "did you mean \"collocation\"?"),
        ("--integrators", "", "unknown integrator"),
    ] {
        let message = refusal(&["drift", flag, value, "--json"]);
        assert!(message.contains(rule), "{flag} {value}: {message}");
    }
    assert!(refusal(&["drift", "bright-breather-61", "--json"]).contains("did you mean \"bright-breather-16\"?"));
    assert!(refusal(&["drift", "no/such/file.toml", "--json"]).contains("no/such/file.toml"));
    // A strain ring out of balance has no energy that could drift.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.toml");
    let text = "name = \"odd\"\n[chain]\nsites = 3\nalpha = 1.5\nkappa = 1.0\nrho = 1.0\nboundary = \"strain-ring\"\n\
                [initial]\nkind = \"state\"\nu = [-0.1, 0.2, 0.3]\n[span]\nuntil = 2.0\n";
    std::fs::write(&path, text).unwrap();
    assert!(refusal(&["drift", path.to_str().unwrap(), "--json"]).contains("a state with an energy"));
    // A folder that cannot be written is refused before the work.
    for command in ["scaling", "drift"] {
        let out = path.join("under");
        assert!(refusal(&[command, "--out", out.to_str().unwrap()]).contains("under"));
    }
}
