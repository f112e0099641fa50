//! Studies as people and machines use them: `study scaling`, `study drift`, breathers and their
//! branches.
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

// Measured: collocation 820, 1150, 1530 for 10, 50, 500 sites; dop853-regularised 5259 and 19383
// for 10 and 50.
#[test]
fn scaling_json_keeps_its_contract_and_collocation_works_no_more_a_bond_on_a_longer_ring() {
    let study = json(&["study", "scaling", "--sites", "500,10,50", "--seed", "7", "--max-time", "1", "--json"]);
    assert!(near(&study["tol"], 1e-9) && study["seed"] == 7);
    let periods = study["periods"].as_f64().unwrap();
    let rows = study["rows"].as_array().unwrap();
    let order: Vec<(&str, u64)> =
        rows.iter().map(|row| (row["integrator"].as_str().unwrap(), row["sites"].as_u64().unwrap())).collect();
    let methods = ["collocation", "corrected", "dop853", "dop853-regularised"];
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
    let output = hertzchain(&["study", "scaling", "--sites", "10,20", "--tol", "1e-6", "--out", out.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("per bond period") && text.contains("one thread"), "{text}");
    let csv = std::fs::read_to_string(out.join("scaling.csv")).unwrap();
    assert_eq!(csv.lines().count(), 9);
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    let study: Value = serde_json::from_slice(&std::fs::read(out.join("scaling.json")).unwrap()).unwrap();
    assert!(near(&study["tol"], 1e-6));
    let png = std::fs::read(out.join("scaling.png"));
    assert_eq!(png.is_ok_and(|png| png.starts_with(b"\x89PNG")), cfg!(feature = "plot"));
}

#[test]
fn drift_json_keeps_its_contract() {
    let study = json(&["study", "drift", "--periods", "150", "--samples", "40", "--json"]);
    assert_eq!((study["scene"].as_str(), study["periods"].as_f64()), (Some("bright-breather-16"), Some(150.0)));
    let period = study["period"].as_f64().unwrap();
    let rows = study["rows"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["integrator"].as_str().unwrap()).collect();
    assert_eq!(names, ["collocation", "corrected", "strang-linear", "yoshida4-linear"]);
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
    // The tolerance of the first is 1e-13; 64 kicks a period of the others see contacts that last a
    // tenth of it.
    let last = |row: &Value| numbers(&row["energy_error"])[39];
    assert!(last(&rows[0]) < 1e-12, "{:e}", last(&rows[0]));
    assert!(rows[1..].iter().all(|row| (1e-6..0.1).contains(&last(row))));
    assert_eq!(rows[1]["steps"], 64 * 150);
}

#[test]
fn drift_writes_table_csv_json_and_png() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let args = [
        "study",
        "drift",
        "tw-q15",
        "--periods",
        "5",
        "--integrators",
        "verlet,dop853",
        "--samples",
        "9",
        "--out",
        out,
    ];
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

#[test]
fn bad_numbers_and_names_are_refused() {
    for (flag, value, rule) in [
        ("--sites", "0", "sites = 0 is not valid: from 10 to 1000000"),
        ("--sites", "50,55", "sites = 55 is not valid: a multiple of 10"),
        ("--sites", "1000000000000", "from 10 to 1000000"),
        ("--sites", "-50", "--sites"),
        ("--sites", "", "--sites"),
        ("--tol", "0", "tol = 0 is not valid: from 2.3e-15 to 0.1"),
        ("--tol", "-1", "tol = -1"),
        ("--tol", "nan", "tol = NaN"),
        ("--tol", "1e30", "tol = 1e30"),
        ("--tol", "1e-15", "from 2.3e-15 to 0.1"),
        ("--sites", "nan", "invalid value 'nan' for '--sites"),
        ("--sites", "1e18", "invalid value '1e18' for '--sites"),
        ("--max-time", "-5", "max-time = -5 is not valid"),
        ("--seed", "99999999999999999999", "--seed"),
        ("--max-time", "0", "max-time = 0 is not valid"),
        ("--max-time", "nan", "max-time = NaN"),
        ("--max-time", "inf", "max-time = inf"),
        ("--seed", "-1", "--seed"),
    ] {
        let message = refusal(&["study", "scaling", flag, value, "--json"]);
        assert!(message.contains(rule), "{flag} {value}: {message}");
    }
    for (flag, value, rule) in [
        ("--periods", "0", "periods = 0 is not valid: from 1 to 1e9"),
        ("--periods", "-3", "periods = -3"),
        ("--periods", "nan", "periods = NaN"),
        ("--periods", "1e300", "periods = 1e300"),
        ("--periods", "inf", "periods = inf"),
        ("--periods", "0.5", "periods = 0.5 is not valid: from 1 to 1e9"),
        ("--samples", "1", "samples = 1 is not valid: from 2 to 100000"),
        ("--samples", "nan", "invalid value 'nan' for '--samples"),
        ("--samples", "0", "samples = 0 is not valid: from 2 to 100000"),
        ("--samples", "1000000000", "samples = 1000000000"),
        ("--samples", "-1", "--samples"),
        ("--integrators", "colocation", "did you mean \"collocation\"?"),
        ("--integrators", "", "unknown integrator"),
    ] {
        let message = refusal(&["study", "drift", flag, value, "--json"]);
        assert!(message.contains(rule), "{flag} {value}: {message}");
    }
    assert!(
        refusal(&["study", "drift", "bright-breather-61", "--json"]).contains("did you mean \"bright-breather-16\"?")
    );
    assert!(refusal(&["study", "drift", "no/such/file.toml", "--json"]).contains("no/such/file.toml"));
    // A strain ring out of balance has no energy that could drift.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.toml");
    let text = "name = \"odd\"\n[chain]\nsites = 3\nalpha = 1.5\nkappa = 1.0\nrho = 1.0\nboundary = \"strain-ring\"\n\
                [initial]\nkind = \"state\"\nu = [-0.1, 0.2, 0.3]\n[span]\nuntil = 2.0\n";
    std::fs::write(&path, text).unwrap();
    assert!(refusal(&["study", "drift", path.to_str().unwrap(), "--json"]).contains("a state with an energy"));
    // A folder that cannot be written is refused before the work.
    for command in ["scaling", "drift"] {
        let out = path.join("under");
        assert!(refusal(&["study", command, "--out", out.to_str().unwrap()]).contains("under"));
    }
}

const BRIGHT: [&str; 7] = ["breather", "bright", "--until", "200", "--samples-per-period", "2", "--json"];

#[test]
fn breather_bright_json_keeps_its_contract() {
    let study = json(&BRIGHT);
    assert_eq!((study["center"].as_str(), study["boundary"].as_str()), (Some("bond"), Some("free")));
    assert!(study["sites"] == 40 && near(&study["rho"], 1000.0) && near(&study["epsilon"], 0.01));
    for (key, value) in [("slow_period", 19.4158), ("horizon", 194.158), ("period", 6.0862), ("mass_condition", 0.1)] {
        assert!((study[key].as_f64().unwrap() / value - 1.0).abs() < 5e-6, "{key}: {}", study[key]);
    }
    assert_eq!(study["core"], serde_json::json!({"first": 17, "last": 22, "sites": 6}));
    let periods = &study["periods"];
    for key in ["t", "e_u", "e_udot", "e_v", "e_vdot", "participation", "core_share"] {
        // 200 = 32.9 T_b.
        assert_eq!(numbers(&periods[key]).len(), 33, "{key}");
    }
    assert_eq!(periods["e_u"][30], study["at_30_periods"]["e_u"]);
    for key in ["e_u", "e_udot", "e_v", "e_vdot"] {
        let [at, to_horizon, all] =
            ["at_horizon", "largest_to_horizon", "largest"].map(|of| study[of][key].as_f64().unwrap());
        assert!(0.0 < at && at <= to_horizon && to_horizon <= all, "{key}");
    }
    assert_eq!(study["profiles"].as_array().unwrap().len(), 3);
    assert_eq!(numbers(&study["profiles"][1]["v"]).len(), 40);
    assert!(study["tenth_left"].is_null() && study["kink"]["height_v"].as_f64().unwrap() > 1e-5);
    let forces = &study["mean_forces_first_period"];
    assert_eq!((forces["first_bond"].as_u64(), numbers(&forces["forces"]).len()), (Some(1), 39));
    assert!(study["final"]["core_share"].as_f64().unwrap() > 0.99 && study["energy_error"].as_f64().unwrap() < 1e-11);
    // A run that ends before.
    let short =
        json(&["breather", "bright", "--center", "site", "--sites", "41", "--rho", "inf", "--until", "10", "--json"]);
    assert!(short["at_horizon"].is_null() && short["largest_to_horizon"].is_null() && short["at_30_periods"].is_null());
    assert!(short["rho"] == "inf" && short["center"] == "site" && short["profiles"].as_array().unwrap().len() == 2);
    assert!(short["core"]["sites"] == 7 && short["final"]["e_v"].as_f64() == Some(0.0));
}

#[test]
fn breather_bright_writes_tables_that_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/er");
    let output = hertzchain(&[&BRIGHT[..6], &["--out", out.to_str().unwrap()]].concat());
    let text = String::from_utf8(output.stdout).unwrap().replace('\n', " ");
    assert!(output.status.success() && text.contains("T_b") && text.contains("Kink at the end"), "{text}");
    for (name, head, lines) in [
        ("norms.csv", "t,e_u,e_udot,e_v,e_vdot,participation,core_share,energy", 69),
        (
            "periods.csv",
            "t,e_u,e_udot,e_v,e_vdot,participation,core_share,energy,e_u_max,e_udot_max,e_v_max,e_vdot_max",
            34,
        ),
        ("profiles.csv", "t,n,u,v,u_ansatz", 121),
        ("forces.csv", "bond,first_period,after_end", 40),
    ] {
        let csv = std::fs::read_to_string(out.join(name)).unwrap();
        assert_eq!((csv.lines().next().unwrap(), csv.lines().count()), (head, lines), "{name}");
    }
    let study: Value = serde_json::from_slice(&std::fs::read(out.join("breather.json")).unwrap()).unwrap();
    assert!(study["periods"]["t"].is_array());
}

#[test]
fn breather_trivial_holds_the_closed_form_against_an_integrator() {
    let study = json(&["breather", "trivial", "--json"]);
    assert!(near(&study["omega"], 2.0) && study["sites"] == 40 && study["samples"] == 401);
    assert!((study["least_slack"]["slack"].as_f64().unwrap() - 1e-3).abs() < 1e-15);
    assert!(study["deviation_max"].as_f64().unwrap() < 1e-12 && study["energy_error"].as_f64().unwrap() < 1e-14);
    assert_eq!(
        (study["mean_forces"]["mean"].as_f64(), study["mean_forces"]["spread"].as_f64()),
        (Some(0.0), Some(0.0))
    );
    let own = ["breather", "trivial", "--amplitudes", "0.1,0.2,0.1", "--phases", "0,1.5,-3", "--until", "20", "--json"];
    let tight = json(&[&own[..], &["--offsets", "0,0,0.1"]].concat());
    assert_eq!((numbers(&tight["amplitudes"]), numbers(&tight["phases"])), (vec![0.1, 0.2, 0.1], vec![0.0, 1.5, -3.0]));
    assert_eq!(tight["least_slack"]["bond"], 1);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let means = hertzchain(&[&own[..8], &["--means", "0,1,2", "--out", out]].concat());
    assert!(
        means.status.success()
            && String::from_utf8(means.stdout).unwrap().replace('\n', " ").contains("b rises by 2.0")
    );
    let sites = std::fs::read_to_string(folder.path().join("sites.csv")).unwrap();
    assert_eq!((sites.lines().next(), sites.lines().count()), (Some("n,a,phi,b,slack"), 4));
    assert_eq!(std::fs::read_to_string(folder.path().join("deviation.csv")).unwrap().lines().count(), 402);
}

// Truth: the closed form has no steps; an integrator that is named has.
#[test]
fn a_scene_with_an_exact_solution_runs_without_integrator_unless_one_is_asked_for() {
    let exact = json(&["run", "trivial-breather", "--events", "--json"]);
    assert_eq!((exact["integrator"].as_str(), exact["steps"].as_u64()), (Some("closed-form"), Some(0)));
    assert_eq!(exact["contacts"]["contacts"], 0);
    assert!(exact["failure"].is_null() && exact["energy_error"].as_f64().unwrap() < 1e-15);
    for flags in
        [&["--integrator", "strang-linear"][..], &["--tol", "1e-9"], &["--steps-per-period", "3"], &["--step", "1"]]
    {
        let run = json(&[&["run", "trivial-breather", "--json"], flags].concat());
        assert!(run["integrator"] != "closed-form" && run["steps"].as_u64().unwrap() > 0, "{flags:?}");
        let plan = json(&[&["run", "trivial-breather", "--plan", "--json"], flags].concat());
        assert!(plan["plan"].as_array().unwrap().iter().all(|line| !line.as_str().unwrap().contains("no steps")));
    }
    let plan = json(&["run", "trivial-breather", "--plan", "--json"]);
    assert_eq!(plan["integrator"], "closed-form");
    assert!(
        plan["plan"].as_array().unwrap().iter().any(|line| line.as_str().unwrap().contains("no integrator, no steps"))
    );
}

#[test]
fn breathers_outside_their_rules_are_refused() {
    for (flag, value, rule) in [
        ("--epsilon", "0", "epsilon = 0 is not valid: the size of the breather is finite and positive"),
        ("--epsilon", "-1", "epsilon = -1"),
        ("--epsilon", "nan", "epsilon = NaN"),
        ("--rho", "0", "rho = 0 is not valid: a bright breather needs resonators"),
        ("--rho", "-2", "rho = -2"),
        ("--kappa", "0", "kappa = 0 is not valid"),
        ("--alpha", "1", "alpha = 1 is not valid: homoclinics are computed for alpha from 1.01 to 10"),
        ("--sites", "4", "sites = 4 is not valid: the chain holds the breather"),
        ("--sites", "0", "sites = 0"),
        ("--until", "-3", "until = -3"),
        ("--until", "1e300", "the end of a run is from 1e-100 to 1e100"),
        ("--samples-per-period", "0", "samples-per-period = 0 is not valid: from 1 to 1000"),
        ("--tol", "0", "tol = 0"),
        ("--integrator", "verlet", "integrator = verlet is not valid: an adaptive method: collocation or a dop853"),
        ("--integrator", "colocation", "did you mean \"collocation\"?"),
        ("--center", "bead", "invalid value 'bead'"),
        ("--boundary", "strain-ring", "invalid value 'strain-ring'"),
    ] {
        let message = refusal(&["breather", "bright", flag, value, "--json"]);
        assert!(message.contains(rule), "{flag} {value}: {message}");
    }
    for (flags, rule) in [
        (&["bright-breather"][..], "a scene of kind trivial-breather, or a state that is one"),
        (&["tw-q15", "--gap", "0"], "these flags need a scene of kind trivial-breather"),
        (&["--amplitudes", "0.1,-0.2"], "amplitude = -0.2"),
        (&["--amplitudes", "0.1,0.2", "--means", "0,0.01"], "at bond 1, where at least 7.5"),
        (&["--amplitudes", "0.1,0.2", "--offsets", "0,-1"], "d = -1 after 0 at site 1"),
        (&["--amplitudes", "0.1,0.2", "--offsets", "0,0,0"], "d = 3 numbers"),
        (&["--phases", "0,1"], "phases = 2 numbers for 40 sites is not valid: one number a site"),
        (&["--gap", "-1"], "gap = -1"),
        (&["--gap", "1", "--means", "0,1"], "cannot be used with"),
    ] {
        let message = refusal(&[&["breather", "trivial", "--json"], flags].concat());
        assert!(message.contains(rule), "{flags:?}: {message}");
    }
}

#[test]
fn dark_json_keeps_its_contract() {
    let one = json(&["breather", "dark", "--center", "bond", "--omega-b", "2.05", "--json"]);
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
    let args = [
        "breather",
        "continue",
        "--center",
        "bond",
        "--from",
        "2.062",
        "--to",
        "2.064",
        "--step",
        "1e-3",
        "--bifurcations",
        "--json",
        "--out",
        out,
    ];
    let branch: Value = serde_json::from_slice(&hertzchain(&args).stdout).unwrap();
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
fn branches_are_the_same_to_the_last_bit_on_any_number_of_threads() {
    let doubling = ["--from", "2.062", "--to", "2.064"];
    for args in [
        &[
            &[
                "breather",
                "continue",
                "--center",
                "bond",
                "--step",
                "1e-3",
                "--sites",
                "21",
                "--bifurcations",
                "--json",
            ],
            &doubling[..],
        ]
        .concat()[..],
        &["breather", "doubled", "--sites", "21", "--step", "0.02", "--most", "2.066", "--omega-b", "1.0325", "--json"],
    ] {
        let on = |threads: &str| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_hertzchain"));
            let output = command.args(args).env("RAYON_NUM_THREADS", threads).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            output.stdout
        };
        let one = on("1");
        let branch: Value = serde_json::from_slice(&one).unwrap();
        assert!(
            branch["points"].as_array().unwrap().len() > 2 && branch["points"][0]["leading"][0]["modulus"].is_f64()
        );
        assert!(args[1] == "doubled" || !branch["bifurcations"].as_array().unwrap().is_empty());
        assert!(one == on("3"), "{args:?}");
    }
}

#[test]
fn a_branch_goes_along_other_parameters_too() {
    // The mass ratio at fixed frequency: rho = 0.5 has omega = 1.732.
    let branch = json(&[
        "breather",
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
fn dark_breathers_outside_their_rules_are_refused() {
    assert!(refusal(&["breather", "dark", "--sites", "40"]).contains("sites = 40"));
    assert!(refusal(&["breather", "dark", "--omega-b", "2"]).contains("--omega-b = 2"));
    assert!(refusal(&["breather", "dark", "--tol", "1"]).contains("tol"));
    assert!(refusal(&["breather", "dark", "--rho", "inf"]).contains("rho = inf"));
    assert!(refusal(&["breather", "continue", "--parameter", "omega"]).contains("did you mean \"omega_b\""));
    assert!(refusal(&["breather", "continue", "--parameter", "rho"]).contains("--from"));
    assert!(refusal(&["breather", "continue", "--omega-b", "2.05"]).contains("--from"));
    assert!(refusal(&["breather", "continue", "--from", "2.05", "--to", "2.05"]).contains("to = 2.05"));
    assert!(refusal(&["breather", "continue", "--step", "0"]).contains("step = 0"));
    assert!(refusal(&["breather", "continue", "--to", "1.9"]).contains("to = 1.9"));
    assert!(refusal(&["breather", "doubled", "--most", "2.02", "--step", "0.01"]).contains("no period doubling"));
}

#[test]
fn an_orbit_is_written_read_back_and_let_go() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    assert!(
        hertzchain(&["breather", "dark", "--center", "bond", "--omega-b", "2.05", "--sites", "21", "--out", out])
            .status
            .success()
    );
    let file = folder.path().join("dark-breather.json");
    let name = file.to_str().unwrap();
    let study = json(&["breather", "evolve", name, "--until", "62", "--kick", "1e-3", "--mode", "0", "--json"]);
    for key in ["t", "e_b", "position"] {
        assert_eq!(study[key].as_array().unwrap().len(), 21, "{key}");
    }
    assert_eq!(study["motion"].as_array().unwrap().len(), 3);
    assert!(study["e_b"][20].as_f64().unwrap() > 1e-3 && study["failure"].is_null());
    // What is no orbit is refused.
    let text = std::fs::read_to_string(&file).unwrap();
    let altered = |from: &str, to: &str| {
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        refusal(&["breather", "evolve", name])
    };
    assert!(altered("\"rho\": 3.3", "\"rho\": 3.4").contains("residual"));
    assert!(altered("\"rho\"", "\"roh\"").contains("missing field `rho`"));
    assert!(altered("\"x\": [", "\"x\": [1.0, ").contains("x = 22 numbers"));
    assert!(altered("{", "").contains("dark-breather.json"));
    std::fs::write(&file, &text).unwrap();
    assert!(refusal(&["breather", "evolve", name, "--until", "1"]).contains("until = 1"));
    assert!(refusal(&["breather", "evolve", name, "--kick", "0"]).contains("kick = 0"));
    assert!(refusal(&["breather", "evolve", name, "--kick", "1e-3", "--mode", "84"]).contains("mode = 84"));
    assert!(refusal(&["breather", "evolve", "no-such-file.json"]).contains("no-such-file.json"));
}

/// Short runs of the studies, all but those whose files have a test of their own.
#[cfg(feature = "plot")]
const SHORT: [&str; 9] = [
    "study theorem --epsilons 0.1,0.05",
    "study lifetimes --epsilons 0.05 --rhos 10 --sites 20 --until 100",
    "wave tw-q45 --until 5",
    "wave modulation --sites 10",
    "breather bright --sites 10 --epsilon 0.05 --rho 100 --until 20",
    "breather trivial --until 5",
    "breather dark --sites 5 --omega-b 2.02",
    "breather continue --sites 5 --from 2.01 --to 2.02 --step 0.005",
    "dps dark --sites 5",
];

// Truth: the help itself, in its sentence about files.
#[cfg(feature = "plot")]
#[test]
fn studies_write_the_pictures_that_their_help_names() {
    for line in SHORT {
        let folder = tempfile::tempdir().unwrap();
        let words: Vec<&str> = line.split(' ').collect();
        let flags = words.iter().position(|word| word.starts_with("--")).unwrap();
        let help = hertzchain(&[&words[..flags], &["--help"]].concat()).stdout;
        let help = String::from_utf8(help).unwrap();
        let files = help.split("Files: ").nth(1).unwrap().split("--json").next().unwrap();
        let names = files.split_whitespace().map(|word| word.trim_matches([',', '.', ';']));
        let pictures: Vec<&str> = names.filter(|name| name.ends_with(".png")).collect();
        assert!(!pictures.is_empty(), "{line}: {files}");
        let output = hertzchain(&[&words[..], &["--out", folder.path().to_str().unwrap()]].concat());
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        for name in pictures {
            let png = std::fs::read(folder.path().join(name)).unwrap_or_else(|why| panic!("{line}: {name}: {why}"));
            assert!(png.starts_with(b"\x89PNG"), "{line}: {name}");
        }
    }
}

#[test]
fn a_rule_of_the_library_that_a_flag_breaks_is_told_in_its_words() {
    for (args, words) in [
        (&["study", "theorem", "--rho-law", "eps^-3"][..], "error: --rho-law = eps^-3 is not valid"),
        (&["study", "stability", "--charts", "lite"], "error: unknown chart \"lite\"; one of light, stiffness"),
        (&["breather", "bright", "--integrator", "xx"], "`hertzchain integrators` lists all"),
        (&["run", "impact", "--integrator", "xx"], "`hertzchain integrators` lists all"),
    ] {
        let output = hertzchain(args);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && text.contains(words), "{args:?}: {text}");
    }
}

// Truth: the names that the help gives, and the exit code that it promises: at omega/c = 2 pi every
// ring is in resonance, and no wave is found.
#[test]
fn solitary_waves_and_barriers_write_their_files_and_fail_where_an_orbit_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = |args: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args).args(["--json", "--out", out]).output();
        let output = output.unwrap();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap(), json)
    };
    let (code, text, json) = run(&["wave", "solitary", "--sites", "12", "--rhos", "0.03187690,0.02"]);
    assert!(code == Some(1) && text.contains("no wave was found at rho = 0.03188"), "{text}");
    assert!(json["tails"][0]["wake"].is_null() && json["tails"][1]["wake"].as_f64().unwrap() > 0.0);
    assert!((json["coefficient"].as_f64().unwrap() - 0.905_515_776_419).abs() < 1e-12);
    let (code, text, json) =
        run(&["breather", "barrier", "--sites", "9", "--from", "2.02", "--to", "2.03", "--frequencies", "2"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(json["points"][1]["at_action_and_length"].as_f64().unwrap() > 0.0);
    assert_eq!(json["sign_changes"]["at_frequency"].as_array().unwrap().len(), 0);
    let names = ["solitary.json", "pulse.csv", "tails.csv", "barrier.json", "barrier.csv"];
    assert!(names.iter().all(|name| folder.path().join(name).exists()));
    let pictures = ["solitary.png", "barrier.png"];
    assert!(!cfg!(feature = "plot") || pictures.iter().all(|name| folder.path().join(name).exists()));
}

// Truth: the theorem has the same number for the same orbit, alone and on a branch.
#[test]
fn a_branch_tells_how_near_exact_orbits_are_if_asked() {
    let json = |more: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(more).args(["--sites", "9", "--json"]).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()
    };
    let branch = ["breather", "continue", "--from", "2.05", "--to", "2.06", "--step", "0.01"];
    let with = json(&[&branch[..], &["--bound"]].concat());
    let points = with["points"].as_array().unwrap();
    assert!(points.iter().all(|point| point["kantorovich"]["radius"].as_f64().unwrap() < 1e-9), "{points:?}");
    let alone = json(&["breather", "dark", "--omega-b", "2.05"]);
    let [a, b] = [&points[0], &alone].map(|one| one["kantorovich"]["inverse"].as_f64().unwrap());
    assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    assert!(json(&branch)["points"][0]["kantorovich"].is_null());
}

// Truth: the names that the help gives, and what the numbers are: the velocity is 1/T_m, half a
// period and 11 whole ones. A kick that is not asked for leaves no file of an earlier one.
#[test]
fn moving_breathers_write_their_files_and_fail_where_none_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = |args: &[&str]| {
        let args = [&["breather", "moving", "--sites", "15", "--json", "--out", out], args].concat();
        Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args).output().unwrap()
    };
    let output = run(&["--omega-b", "2.1", "--turns", "8", "--until", "100"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let point = &json["points"][0];
    let passage = 8.5 * 2.0 * std::f64::consts::PI / 2.1;
    assert!((point["passage"].as_f64().unwrap() - passage).abs() < 1e-12);
    assert!((point["velocity"].as_f64().unwrap() * passage - 1.0).abs() < 1e-12);
    assert!(point["residual"].as_f64().unwrap() < 1e-12 && point["return_error"].as_f64().unwrap() < 1e-10);
    assert!(!json["kicked"]["position"].as_array().unwrap().is_empty());
    let exists = |name: &str| folder.path().join(name).exists();
    assert!(["moving.json", "moving.csv", "envelope.csv", "passages.csv"].iter().all(|name| exists(name)));
    assert!(!cfg!(feature = "plot") || exists("moving.png"));
    let output = run(&["--omega-b", "2.1", "--turns", "8,1", "--until", "0"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && text.contains("2.1 with 1 turns"), "{text}");
    assert!(!exists("passages.csv") && exists("moving.csv"));
    let output = run(&["--omega-b", "1.9"]);
    assert!(output.status.code() == Some(2) && String::from_utf8_lossy(&output.stderr).contains("above omega"));
}

// Truth: the message and the file of the best iterate; an earlier result does not stay beside it.
#[test]
fn a_search_for_an_exact_wave_that_stalls_keeps_its_best_iterate() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = |more: &[&str]| {
        let args = ["wave", "exact", "--sites", "10", "--out", out];
        Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args.iter().chain(more)).output().unwrap()
    };
    let names = || {
        let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|one| one.unwrap().file_name()).collect();
        names.sort();
        names
    };
    assert!(run(&[]).status.success());
    assert!(names().iter().any(|name| name == "exact.json"), "{:?}", names());
    let stalled = run(&["--omega-tw", "1.5"]);
    let text = String::from_utf8_lossy(&stalled.stderr).into_owned();
    assert!(stalled.status.code() == Some(1) && text.contains("no periodic orbit after"), "{text}");
    assert_eq!(names(), ["stalled.json"]);
    let kept: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("stalled.json")).unwrap()).unwrap();
    assert!(kept["residual"].as_f64().unwrap() > 1e-12 && kept["x"].as_array().unwrap().len() == 10, "{kept}");
}

#[test]
fn a_branch_is_kept_if_no_other_one_crosses_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mode = ["orbit", "mode", "defect", "--to", "0.2", "--step", "0.1", "--switch", "99"];
    let driven = ["orbit", "continue", "--to", "2e-6", "--settle", "20", "--max-points", "3", "--switch", "99"];
    for (args, table, whole) in
        [(&mode[..], "mode-branch.csv", "mode.json"), (&driven[..], "driven-branch.csv", "driven-branch.json")]
    {
        let output = hertzchain(&[args, &["--json", "--out", out.to_str().unwrap()]].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.starts_with("error: switch = 99 of 0 is not valid: the branch has no bifurcation"), "{error}");
        let result: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(result["points"].as_array().unwrap().len() > 1);
        assert!(result["switched"]["at"] == 99 && error.contains(result["switched"]["failure"].as_str().unwrap()));
        assert!(out.join(table).exists() && out.join(whole).exists() && !out.join("switched-branch.csv").exists());
    }
}
