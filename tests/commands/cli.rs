//! The program as people and machines use it: what it prints, writes and refuses.
#![cfg(feature = "cli")]

use hertzchain::output::Archive;
use serde_json::Value;
use std::{
    path::Path,
    process::{Command, Output},
};

fn hertzchain(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn json(args: &[&str]) -> Value {
    let output = hertzchain(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "no bar off a terminal: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_str(&stdout(&output)).unwrap()
}

/// The one line of a refusal, with a non-zero exit code.
fn refusal(args: &[&str]) -> String {
    let output = hertzchain(args);
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(!output.status.success(), "{args:?} must be refused");
    assert!(!text.contains("panicked"), "{args:?}: {text}");
    text
}

fn scene_file(folder: &Path, from: &str, to: &str) -> String {
    let text = stdout(&hertzchain(&["scenes", "show", "tw-q15"]));
    assert!(text.contains(from), "{from}");
    let path = folder.join("scene.toml");
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn run_json_keeps_its_contract() {
    let ring = json(&["run", "tw-q15", "--until", "3", "--json"]);
    for key in ["x", "y", "vx", "vy"] {
        assert_eq!(ring[key].as_array().unwrap().len(), 50, "{key}");
    }
    assert_eq!(ring["scene"], "tw-q15");
    assert_eq!(ring["integrator"], "collocation");
    assert!(ring["reason"].as_str().unwrap().contains("Omega_c"));
    for key in ["t", "energy", "energy_error", "wall_s"] {
        assert!(ring[key].is_f64(), "{key}: {}", ring[key]);
    }
    for key in ["force_evaluations", "steps", "rejected"] {
        assert!(ring[key].is_u64(), "{key}");
    }
    // Samples are a part of the run, and take time.
    let [wall, sampling] = ["wall_s", "sampling_s"].map(|key| ring[key].as_f64().unwrap());
    assert!(0.0 < sampling && sampling < wall, "{sampling} of {wall}");
    let unsampled = json(&["run", "tw-q15", "--until", "3", "--samples", "0", "--json"]);
    assert!(unsampled["sampling_s"].as_f64().unwrap() < sampling);
    assert!(stdout(&hertzchain(&["run", "tw-q15", "--until", "3"])).contains(" s, of which sampling "));
    let chain = json(&["run", "cradle", "--until", "3", "--json", "--integrator", "dop853"]);
    assert_eq!(chain["u"].as_array().unwrap().len(), 20);
    assert_eq!(chain["pu"].as_array().unwrap().len(), 20);
    assert_eq!(chain["v"].as_array().unwrap().len(), 0);
}

#[test]
fn a_strain_ring_without_balance_has_no_energy() {
    let folder = tempfile::tempdir().unwrap();
    let initial = "[initial]\nkind = \"state\"\nu = [-0.1, 0.2, 0.3]\n[span]\nuntil = 2.0\n";
    let chain = "name = \"odd\"\n[chain]\nsites = 3\nalpha = 1.5\nkappa = 1.0\nrho = 1.0\nboundary = \"strain-ring\"\n";
    let path = folder.path().join("odd.toml");
    std::fs::write(&path, format!("{chain}{initial}")).unwrap();
    let run = json(&["run", path.to_str().unwrap(), "--json"]);
    assert!(run["energy"].is_null() && run["energy_error"].is_null());
    assert!(run["x"][0].is_f64());
}

#[test]
fn numbers_have_seventeen_significant_digits() {
    let text = stdout(&hertzchain(&["run", "tw-q15", "--until", "3", "--json"]));
    let t = text.split("\"t\": ").nth(1).unwrap().split(',').next().unwrap();
    assert_eq!(t, "3.0000000000000000e0");
}

#[test]
fn what_the_order_study_cannot_do_is_refused() {
    assert!(refusal(&["study", "order", "--beads", "1"]).contains("beads = 1"));
    assert!(refusal(&["study", "order", "--alpha", "nan"]).contains("alpha = NaN"));
}

#[test]
fn a_contact_log_is_written_and_summed_up() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let args =
        ["run", "impact", "--until", "10", "--integrator", "dop853-regularised", "--events", "--json", "--out", out];
    let run = hertzchain(&args);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let totals = &serde_json::from_str::<Value>(&stdout(&run)).unwrap()["contacts"];
    let csv = std::fs::read_to_string(folder.path().join("contacts.csv")).unwrap();
    assert_eq!(
        csv.lines().next().unwrap(),
        "bond,onset,release,approach,separation,largest_overlap,impulse,t_largest,onset_overlap,release_overlap,\
         force_end"
    );
    assert_eq!(totals["contacts"].as_u64().unwrap() as usize, csv.lines().count() - 1);
    // The first contact: struck with speed one, at once.
    let first: Vec<f64> = csv.lines().nth(1).unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert_eq!((first[0], first[1], first[3]), (1.0, 0.0, 1.0));
    let file = std::fs::File::open(folder.path().join("contacts.npz")).unwrap();
    assert_eq!(zip::ZipArchive::new(file).unwrap().len(), 11, "a member a column");
    assert!(folder.path().join("contacts.png").exists() == cfg!(feature = "plot"));
    // Nobody asked, nobody gets.
    let silent = json(&["run", "impact", "--until", "10", "--json"]);
    assert!(silent.get("contacts").is_none());
}

#[test]
fn maxima_are_written_on_request_beside_the_same_contacts() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "precompressed", "--until", "20", "--tol", "1e-8", "--json", "--out"];
    let out = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let ran = |more: &[&str]| {
        let run = hertzchain(&[&run[..], more].concat());
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        serde_json::from_str::<Value>(&stdout(&run)).unwrap()
    };
    ran(&[&out("a"), "--events"]);
    let value = ran(&[&out("b"), "--maxima", "1e-6"]);
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(read("a/contacts.csv") == read("b/contacts.csv") && !folder.path().join("a/maxima.csv").exists());
    assert!(read("a/final.csv") == read("b/final.csv"));
    let csv = String::from_utf8(read("b/maxima.csv")).unwrap();
    assert!(csv.starts_with("bond,t,overlap\n") && csv.lines().nth(1).unwrap().split(',').next().unwrap().len() < 3);
    assert!(csv.lines().count() as u64 > 1 + value["contacts"]["contacts"].as_u64().unwrap());
    let file = std::fs::File::open(folder.path().join("b/maxima.npz")).unwrap();
    assert_eq!(zip::ZipArchive::new(file).unwrap().len(), 3, "a member a column");
    // What an earlier run has left is removed.
    ran(&[&out("b")]);
    assert!(!folder.path().join("b/maxima.csv").exists() && !folder.path().join("b/maxima.npz").exists());
    assert!(refusal(&["run", "trivial-breather", "--maxima", "1e-6"]).contains("an exact solution has no log"));
    assert!(refusal(&["run", "cradle", "--plan", "--maxima", "2"]).contains("from 2.3e-13 to 0.5"));
    let legs = hertzchain(&["run", "cradle", "--maxima", "1e-6", "--checkpoint", "1", "--out", &out("c")]);
    assert!(!legs.status.success() && String::from_utf8_lossy(&legs.stderr).contains("--checkpoint"));
}

#[test]
fn compare_json_keeps_its_contract_and_writes_nothing_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hertzchain"))
        .args(["compare", "precompressed", "--integrators", "verlet,srkn11-6-linear", "--max-time", "1", "--json"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let value: Value = serde_json::from_str(&stdout(&output)).unwrap();
    for key in ["scene", "period", "amplitude", "reference", "rows"] {
        assert!(!value[key].is_null(), "{key}");
    }
    assert!(value["reference"]["method"].is_string() && value["reference"]["error_estimate"].is_f64());
    for key in ["integrator", "setting", "step", "error", "energy_error", "wall_s", "force_evaluations", "step_cost"] {
        assert!(!value["rows"][0][key].is_null(), "{key}");
    }
    assert!(value["stopped"].is_object());
    // The plain loops come last; those of a chain with resonators are two.
    let names: Vec<&str> = value["slopes"].as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(names, ["verlet", "srkn11-6-linear", "plain Verlet", "plain rotation + kick"]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn compare_writes_table_csv_and_png() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/er");
    let args = ["compare", "cradle", "--integrators", "verlet,strang-linear,dop853", "--max-time", "2", "--out"];
    let output = hertzchain(&[&args[..], &[out.to_str().unwrap()]].concat());
    let text = stdout(&output);
    assert!(output.status.success() && text.contains("strang-linear") && text.contains("fastest to reach"), "{text}");
    let csv = std::fs::read_to_string(out.join("compare.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().skip(1).all(|line| line.split(',').count() == columns), "{csv}");
    let png = std::fs::read(out.join("compare.png"));
    assert_eq!(png.is_ok(), cfg!(feature = "plot"));
    assert!(png.is_ok_and(|png| png.starts_with(b"\x89PNG")) || !cfg!(feature = "plot"));
}

#[test]
fn run_writes_files_that_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = json(&["run", "impact", "--until", "5", "--json"]);
    let output = hertzchain(&["run", "impact", "--until", "5", "--out", out]);
    assert!(output.status.success());
    // CSV: what was printed, to the last digit.
    let csv = std::fs::read_to_string(folder.path().join("final.csv")).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("n,u,pu"));
    let first: Vec<f64> = lines.next().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert_eq!((first[1], first[2]), (run["u"][0].as_f64().unwrap(), run["pu"][0].as_f64().unwrap()));
    // NPZ: the last profile is the final state.
    let archive = Archive::read(&folder.path().join("profiles.npz")).unwrap();
    let u = archive.array("u", &[401, 100]).unwrap();
    assert_eq!(u[400 * 100], first[1]);
    // The scene that was written is the scene that ran.
    let again = folder.path().join("scene.toml");
    assert_eq!(json(&["run", again.to_str().unwrap(), "--json"])["u"], run["u"]);
}

#[test]
fn scenes_and_integrators_are_listed() {
    let scenes = json(&["scenes", "--json"]);
    assert_eq!(scenes["scenes"].as_array().unwrap().len(), 22);
    for scene in scenes["scenes"].as_array().unwrap() {
        let name = scene["name"].as_str().unwrap();
        assert!(!scene["summary"].as_str().unwrap().is_empty());
        assert_eq!(json(&["scenes", "show", name, "--json"])["name"], name);
        assert!(stdout(&hertzchain(&["run", name, "--plan"])).contains("left out"));
    }
    let integrators = json(&["integrators", "--json"]);
    assert_eq!(integrators["integrators"].as_array().unwrap().len(), 33);
}

#[test]
fn unknown_names_are_answered_with_the_nearest() {
    assert!(refusal(&["run", "tw-q51"]).contains("did you mean \"tw-q15\"?"));
    assert!(refusal(&["run", "tw-q15", "--integrator", "yosida4"]).contains("did you mean \"yoshida4\"?"));
    assert!(
        refusal(&["compare", "tw-q15", "--integrators", "verlet,strang"]).contains("unknown integrator \"strang\"")
    );
    let folder = tempfile::tempdir().unwrap();
    let file = scene_file(folder.path(), "alpha =", "alhpa =");
    assert!(refusal(&["run", &file]).contains("line 6: unknown field `alhpa`"), "{}", refusal(&["run", &file]));
    assert!(refusal(&["run", &file]).contains("did you mean `alpha`?"));
}

#[test]
fn bad_numbers_are_refused_by_name_and_rule() {
    let rules = [
        ("sites = 50", "sites = 0", "sites = 0 is not valid: a chain has at least one bead"),
        ("sites = 50", "sites = 1000000000000000000", "at most 10^8"),
        (
            "sites = 50",
            "sites = -3",
            "line 5: `chain.sites`: invalid value: number `-3`, expected a whole number, at least zero",
        ),
        ("alpha = 1.5", "alpha = -1.5", "line 6: `chain.alpha`: alpha = -1.5 is not valid"),
        ("sites = 50", "sites = 51", "a whole number of waves fits the ring"),
        ("alpha = 1.5", "alpha = nan", "alpha = NaN is not valid"),
        ("alpha = 1.5", "alpha = 0.0", "alpha = 0 is not valid"),
        ("kappa = 1.0", "kappa = -1.0", "kappa = -1 is not valid"),
        ("rho = 0.3333333333333333", "rho = -0.5", "rho = -0.5 is not valid"),
        ("rho = 0.3333333333333333", "rho = inf", "travelling waves need resonators"),
        ("rho = 0.3333333333333333", "rho = 1e-310", "rho = 0 leaves the resonators out"),
        ("detuning = 0.001", "detuning = -0.001", "detuning = -0.001 is not valid"),
        ("detuning = 0.001", "detuning = 0.001\nepsilon = 0.1", "exactly one of `epsilon` and `detuning`"),
        ("b = 1.0", "b = 2.5", "below 2 kappa a"),
        ("periods = 100", "periods = 100\nuntil = 3.0", "exactly one of `periods` and `until`"),
        ("periods = 100", "periods = 0", "periods = 0 is not valid"),
        ("periods = 100", "periods = 100\nperiod = 2.0", "a frequency of its own"),
        ("samples = 400", "samples = 100000000", "at most 10^6"),
        ("boundary = \"strain-ring\"", "boundary = \"ring\"", "lives on a strain-ring"),
        ("boundary = \"strain-ring\"", "boundary = \"rings\"", "did you mean `ring`?"),
        ("alpha = 1.5", "alpha = 1.5\nalpha = 1.5", "duplicate key"),
    ];
    for (from, to, rule) in rules {
        let folder = tempfile::tempdir().unwrap();
        let message = refusal(&["run", &scene_file(folder.path(), from, to)]);
        assert!(message.contains(rule) && message.lines().count() == 1, "{to}: {message}");
    }
    // A key that would do nothing is an error, too.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.toml");
    let text = "name = \"plain\"\n[chain]\nsites = 2\nalpha = 1.5\nkappa = 1.0\nrho = 0.0\nboundary = \"free\"\n\
                [initial]\nkind = \"state\"\nv = [0.1, 0.2]\n[span]\nuntil = 1.0\n";
    std::fs::write(&path, text).unwrap();
    assert!(refusal(&["run", path.to_str().unwrap()]).contains("leave `v` and `v_dot` out"));
    for (flag, value, rule) in [
        ("--step", "0", "step = 0 is not valid"),
        ("--step", "nan", "step = NaN is not valid"),
        ("--step", "1e-30", "at most 1e15 steps"),
        ("--steps-per-period", "-3", "steps-per-period = -3 is not valid"),
        ("--until", "-1", "until = -1 is not valid"),
        ("--until", "inf", "until = inf is not valid"),
        ("--tol", "0", "tol = 0"),
        ("--tol", "nan", "tol = NaN is not valid"),
        ("--tol", "-1", "tol = -1 is not valid"),
        ("--tol", "1e18", "tol = 1e18 is not valid: from 1e-15 to 0.1"),
        ("--tol", "0.2", "tol = 0.2 is not valid: from 1e-15 to 0.1"),
        ("--windows-per-period", "-2", "windows-per-period = -2 is not valid: finite and positive"),
        ("--windows-per-period", "0", "windows-per-period = 0 is not valid"),
        ("--windows-per-period", "nan", "windows-per-period = NaN is not valid"),
        ("--windows-per-period", "1e18", "windows = 1e20 is not valid: at most 1e15 windows"),
        ("--windows-per-period", "1e300", "at most 1e15 windows"),
    ] {
        let message = refusal(&["run", "tw-q15", flag, value]);
        assert!(message.contains(rule), "{flag} {value}: {message}");
    }
    let message = refusal(&["run", "tw-q15", "--integrator", "verlet", "--tol", "1e-9"]);
    assert!(message.contains("a method with equal steps takes"), "{message}");
    for nodes in ["0", "2", "7", "14", "18"] {
        let message = refusal(&["run", "tw-q15", "--windows-per-period", "10", "--nodes", nodes]);
        assert!(message.contains(&format!("nodes = {nodes}")) && message.contains("4, 6, 8, 10 or 12"), "{message}");
    }
    for nodes in ["-4", "99999999999999999999", "1e3"] {
        let message = refusal(&["run", "tw-q15", "--windows-per-period", "10", &format!("--nodes={nodes}")]);
        assert!(message.contains(&format!("invalid value '{nodes}' for '--nodes")), "{message}");
    }
    assert!(refusal(&["run", "tw-q15", "--nodes", "8"]).contains("--windows-per-period"));
    let message = refusal(&["run", "tw-q15", "--integrator", "verlet", "--windows-per-period", "10"]);
    assert!(message.contains("only collocation takes windows"), "{message}");
    for (value, rule) in [("0", "tol = 0"), ("-1", "tol = -1"), ("nan", "tol = NaN")] {
        assert!(refusal(&["run", "tw-q15", "--integrator", "dop853", "--tol", value]).contains(rule));
    }
    assert!(refusal(&["compare", "tw-q15", "--max-time", "0"]).contains("max-time = 0 is not valid"));
    assert!(refusal(&["run", "no/such/file.toml"]).contains("no/such/file.toml"));
}

#[test]
fn nodes_beside_a_tolerance_are_refused() {
    assert!(refusal(&["run", "tw-q15", "--tol", "1e-6", "--nodes", "8", "--json"]).contains("--nodes"));
}

#[test]
fn a_plan_refuses_what_a_run_refuses() {
    for flags in [&["--windows-per-period", "5", "--nodes", "18"][..], &["--tol", "5"]] {
        refusal(&[&["run", "tw-q15", "--plan"], flags].concat());
    }
}

#[test]
fn windows_for_another_method_are_refused_by_the_value_given() {
    let message = refusal(&["run", "tw-q15", "--integrator", "dop853", "--windows-per-period", "5"]);
    assert!(message.contains("windows-per-period = 5 "), "{message}");
}

#[test]
fn an_unstable_step_is_reported_with_time_and_step_and_keeps_what_it_had() {
    // Velocity Verlet needs h omega < 2: omega = 2 here, and two steps a period are h omega = pi.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let message = refusal(&["run", "tw-q15", "--integrator", "verlet", "--steps-per-period", "2", "--out", out]);
    assert!(message.contains("unstable: energy went from") && message.contains("step"), "{message}");
    let energies = std::fs::read_to_string(folder.path().join("energy.csv")).unwrap();
    assert!(energies.lines().count() > 1, "what it had is kept");
    let summary = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    assert!(summary["failure"].as_str().unwrap().contains("unstable"));
}

#[test]
fn a_folder_that_cannot_be_written_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "in the way").unwrap();
    let out = file.join("under");
    for command in ["run", "compare"] {
        let message = refusal(&[command, "tw-q15", "--out", out.to_str().unwrap()]);
        assert!(message.contains("under") && message.lines().count() == 1, "{message}");
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "in the way");
}

#[test]
fn chains_of_one_and_two_beads_run_with_every_method() {
    let folder = tempfile::tempdir().unwrap();
    for sites in [1, 2] {
        for boundary in ["free", "fixed", "ring", "strain-ring"] {
            let path = folder.path().join("short.toml");
            let u = vec!["0.1"; sites].join(", ");
            let text = format!(
                "name = \"short\"\n[chain]\nsites = {sites}\nalpha = 1.5\nkappa = 1.0\nrho = 1.0\nboundary = \"{boundary}\"\n\
                 [initial]\nkind = \"state\"\nu = [{u}]\nv = [{u}]\n[span]\nperiods = 3\n"
            );
            std::fs::write(&path, text).unwrap();
            for method in ["verlet", "strang-linear", "dop853"] {
                json(&["run", path.to_str().unwrap(), "--integrator", method, "--json"]);
            }
        }
    }
}

/// What people see instead of JSON. Truth: the names in the JSON.
#[test]
fn tables_name_what_the_json_names() {
    for (command, list, name) in [("integrators", "integrators", "name"), ("scenes", "scenes", "name")] {
        let (table, json) = (stdout(&hertzchain(&[command])), json(&[command, "--json"]));
        let rows = json[list].as_array().unwrap();
        assert!(rows.len() > 10 && rows.iter().all(|row| table.contains(row[name].as_str().unwrap())), "{table}");
    }
    let homoclinic = ["dps", "homoclinic", "--alpha", "1.5", "--center", "site"];
    let (table, json) = (stdout(&hertzchain(&homoclinic)), json(&[&homoclinic[..], &["--json"]].concat()));
    for a in json["a"].as_array().unwrap() {
        assert!(table.contains(&format!("{:.16e}", a.as_f64().unwrap())), "{a}: {table}");
    }
    let table = stdout(&hertzchain(&["paper", "verify", "--section", "3"]));
    assert!(table.contains("holds") && table.contains("all as known"), "{table}");
}

#[test]
fn dps_integrals_keep_their_contract() {
    let of =
        |b: &str, r: &str| json(&["dps", "integrals", "--alpha", "2", "--kappa", "0.5", "--b", b, "--r", r, "--json"]);
    // alpha = 2, never open: g = b^2 + (2 kappa r)^2 / 2, r h = -b (2 kappa r).
    let closed = of("-3", "2");
    let want = [
        ("g", 11.0),
        ("h", 3.0),
        ("dg_db", -6.0),
        ("dg_dr", 2.0),
        ("dh_db", -1.0),
        ("dh_dr", 0.0),
        ("drh_db", -2.0),
        ("drh_dr", 3.0),
    ];
    for (key, want) in want {
        assert!((closed[key].as_f64().unwrap() - want).abs() < 1e-14, "{key}: {}", closed[key]);
    }
    let open = of("2", "2");
    assert!(want.iter().all(|(key, _)| open[key] == 0.0), "no contact, no force: {open}");
    let given = ["alpha", "kappa", "b", "r"].map(|key| open[key].as_f64());
    assert_eq!(given, [2.0, 0.5, 2.0, 2.0].map(Some));
    assert_eq!(open["version"], env!("CARGO_PKG_VERSION"));
    let singular = json(&["dps", "integrals", "--alpha", "0.5", "--b", "-2", "--r", "1", "--json"]);
    assert_eq!((&singular["dg_db"], &singular["dh_db"]), (&Value::from("-inf"), &Value::from("inf")));
    let text = stdout(&hertzchain(&["dps", "integrals", "--b", "0", "--r", "1"]));
    assert!(text.contains("mean contact force") && text.contains("6.47223121426055"), "{text}");
    for (flag, value, rule) in [
        ("--r", "-1", "r = -1 is not valid: finite and at least 0"),
        ("--r", "inf", "r = inf"),
        ("--b", "nan", "b = NaN is not valid: a finite number"),
        ("--alpha", "0", "alpha = 0 is not valid: above 0 and at most 10"),
        ("--alpha", "10.5", "alpha = 10.5"),
        ("--kappa", "0", "kappa = 0 is not valid: finite and positive"),
    ] {
        let mut args = vec!["dps", "integrals", "--json"];
        for pair in [["--b", "0"], ["--r", "1"]] {
            if pair[0] != flag {
                args.extend(pair);
            }
        }
        args.extend([flag, value]);
        assert!(refusal(&args).contains(rule), "{}", refusal(&args));
    }
}
#[cfg(feature = "plot")]
#[test]
fn pictures_are_written_in_the_formats_that_are_asked_for_and_in_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = |formats: &str| {
        let output = hertzchain(&["run", "impact", "--until", "5", "--out", out, "--format", formats]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let summary: Value =
            serde_json::from_str(&std::fs::read_to_string(folder.path().join("summary.json")).unwrap()).unwrap();
        let mut names: Vec<String> =
            std::fs::read_dir(out).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        names.retain(|name| name.ends_with("g"));
        names.sort_unstable();
        let told: Vec<&str> = summary["files"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert!(names.iter().all(|name| told.contains(&name.as_str())), "{told:?}");
        assert_eq!(told.iter().filter(|name| name.ends_with("g")).count(), names.len());
        names
    };
    let names = |end: &str| ["energy", "profile", "spacetime"].map(|stem| format!("{stem}.{end}"));
    assert_eq!(run("png"), names("png"));
    let mut both = [names("png"), names("svg")].concat();
    both.sort_unstable();
    assert_eq!(run("svg,png"), both);
    assert_eq!(run("svg"), names("svg"));
    let other = hertzchain(&["dps", "dark", "--out", out, "--format", "jpg"]);
    assert_eq!(other.status.code(), Some(2));
    let why = String::from_utf8_lossy(&other.stderr);
    assert!(why.contains("jpg") && why.contains("svg"), "{why}");
}
