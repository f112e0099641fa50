//! What `--json` prints, key by key and number by number, against a stored set
//! (`tests/reference/json`).
//!
//! The set guards against changes of the house: whoever changes a number or a key on purpose makes
//! it again with `HERTZCHAIN_STORE=1 cargo test --release --test commands stored` and says why in
//! the commit. Keys may be added.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::{env, fs, path::PathBuf, process::Command};

/// Name in the store, and the command line without `--json`.
const SET: [(&str, &str); 26] = [
    ("run-tw-q15", "run tw-q15 --integrator strang-linear --steps-per-period 32 --set span.periods=2 --samples 9"),
    ("run-impact", "run impact --tol 1e-9 --events --samples 9"),
    ("run-cradle", "run cradle --integrator dop853-regularised --tol 1e-9 --samples 9 --set span.periods=2"),
    (
        "compare",
        "compare impact --integrators verlet,strang-linear,corrected,collocation --set span.until=4 --max-time 600",
    ),
    ("integrators", "integrators"),
    ("scenes", "scenes"),
    ("wave", "wave tw-q45 --until 30"),
    ("wave-exact", "wave exact tw-q45 --sites 10"),
    ("wave-continue", "wave continue tw-q45 --sites 10 --to 2.002"),
    ("wave-solitary", "wave solitary --sites 14 --rhos 0.02,0.04"),
    ("wave-modulation", "wave modulation --sites 10 --q-over-pi 0.2 --epsilon 0.01"),
    ("mode", "orbit mode defect --to 1 --step 0.2 --bifurcations"),
    ("dps-integrals", "dps integrals --b 0.3 --r 1.2"),
    ("dps-homoclinic", "dps homoclinic --center bond"),
    ("dps-dark", "dps dark --sites 11 --omega-b 2.02"),
    ("dark", "breather dark --sites 9 --omega-b 2.02"),
    ("bright", "breather bright --sites 10 --epsilon 0.05 --rho 100 --until 60"),
    ("trivial", "breather trivial --until 20"),
    ("continue", "breather continue --sites 9 --from 2.01 --to 2.03 --bifurcations"),
    ("barrier", "breather barrier --sites 9 --from 2.02 --to 2.04 --frequencies 2"),
    ("theorem", "study theorem --epsilons 0.1,0.05"),
    ("lifetimes", "study lifetimes --epsilons 0.05,0.1 --rhos 10,100 --sites 20 --until 300"),
    ("drift", "study drift bright-breather-16 --periods 20 --samples 5"),
    ("stability", "study stability --charts light --quick --integrators verlet,collocation"),
    ("verify-3", "paper verify --section 3"),
    ("verify-6", "paper verify --section 6"),
];
/// Two numbers are equal when they differ by less than this share of the larger: the libraries of
/// two systems round sines and powers differently, and solvers carry that along.
const SAME: f64 = 1e-6;
/// Numbers below this are rounding (residuals, errors at the floor), and only their size is.
const ROUNDING: f64 = 1e-9;

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference/json").join(format!("{name}.json"))
}

fn output(line: &str) -> String {
    let run = Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(line.split(' ')).output().unwrap();
    assert!(!run.stdout.is_empty(), "{line}: {}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}

/// Differences from the stored JSON of this name, which is stored again if asked for.
fn changes(name: &str, now: &Value) -> Vec<String> {
    if env::var_os("HERTZCHAIN_STORE").is_some() {
        fs::create_dir_all(path(name).parent().unwrap()).unwrap();
        fs::write(path(name), serde_json::to_string(now).unwrap() + "\n").unwrap();
    }
    let stored: Value = serde_json::from_slice(&fs::read(path(name)).unwrap()).unwrap();
    let mut found = Vec::new();
    differences(name, &stored, now, &mut found);
    found
}

/// Whether a value under this key depends on the machine or the version.
fn varies(key: &str) -> bool {
    ["version", "wall", "machine", "sampling_s", "runs", "step_cost", "fastest"].iter().any(|word| key.contains(word))
}

/// Paths at which `now` differs from what was stored; new keys are no difference.
fn differences(path: &str, stored: &Value, now: &Value, found: &mut Vec<String>) {
    match (stored, now) {
        (Value::Object(stored), Value::Object(now)) => {
            for (key, value) in stored.iter().filter(|(key, _)| !varies(key)) {
                match now.get(key) {
                    Some(other) => differences(&format!("{path}.{key}"), value, other, found),
                    None => found.push(format!("{path}.{key} is gone")),
                }
            }
        }
        (Value::Array(stored), Value::Array(now)) if stored.len() == now.len() => {
            for (i, (a, b)) in stored.iter().zip(now).enumerate() {
                differences(&format!("{path}[{i}]"), a, b, found);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            if (a - b).abs() > ROUNDING.max(SAME * a.abs().max(b.abs())) {
                found.push(format!("{path}: {a} was stored, now {b}"));
            }
        }
        (a, b) if a == b => {}
        (a, b) => found.push(format!("{path}: {a} was stored, now {b}")),
    }
}

fn assert_none(found: &[String]) {
    assert!(found.is_empty(), "{} differences:\n{}", found.len(), found[..found.len().min(40)].join("\n"));
}

#[test]
fn json_of_every_command_is_that_of_the_stored_set() {
    let now = |line: &str| serde_json::from_str(&output(&format!("{line} --json"))).unwrap();
    assert_none(&SET.iter().flat_map(|(name, line)| changes(name, &now(line))).collect::<Vec<_>>());
}

/// The study with the most runs: its table, files and JSON from one of it.
#[test]
fn the_order_study_keeps_its_table_its_files_and_its_stored_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let short = "study order --beads 3 --alpha 2 --integrators verlet,kahan-li8-linear,corrected,dop853";
    let table = output(&format!("{short} --out {}", folder.path().display()));
    assert!(table.contains("regularised") && table.contains("theory"), "{table}");
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("order.csv").starts_with(b"method,"));
    for picture in ["order-state.png", "order-tangent.png"] {
        assert!(!cfg!(feature = "plot") || read(picture).starts_with(b"\x89PNG"), "{picture}");
    }
    let study: Value = serde_json::from_slice(&read("order.json")).unwrap();
    assert_eq!((study["alpha"].as_f64(), study["beads"].as_u64()), (Some(2.0), Some(3)));
    assert!(study["events"].as_u64().unwrap() > 0);
    let rows = study["rows"].as_array().unwrap();
    for row in rows {
        assert!(["plain", "landed", "corrected", "regularised"].contains(&row["mode"].as_str().unwrap()));
        assert!(["state", "tangent"].contains(&row["quantity"].as_str().unwrap()));
        assert!(row["slope"].is_f64() || row["slope"].is_null());
        assert!(row["slope_theory"].is_f64());
        assert_eq!(row["errors"].as_array().unwrap().len(), row["steps"].as_array().unwrap().len());
    }
    let integrators: Value = serde_json::from_str(&output("integrators --json")).unwrap();
    let names: Vec<&str> =
        integrators["integrators"].as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert!(rows.iter().all(|row| names.contains(&row["method"].as_str().unwrap())));
    assert_none(&changes("order", &study));
}

#[test]
fn a_changed_number_a_lost_key_and_a_longer_list_are_differences() {
    let stored = serde_json::json!({"a": 1.0, "b": [1, 2], "wall": 3.0, "c": "x"});
    let cases = [
        (serde_json::json!({"a": 1.0, "b": [1, 2], "wall": 9.0, "c": "x", "new": 1}), 0),
        (serde_json::json!({"a": 1.00001, "b": [1, 2], "c": "x"}), 1),
        (serde_json::json!({"b": [1, 2, 3], "c": "y"}), 3),
    ];
    for (now, count) in cases {
        let mut found = Vec::new();
        differences("", &stored, &now, &mut found);
        assert_eq!(found.len(), count, "{found:?}");
    }
}
