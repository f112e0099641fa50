//! Studies as people and machines use them: `study drift`, breathers and their
//! branches. Names and formats of all results are those of the golden net.

use super::program::{command, hertzchain, json, names, numbers, printed, read_json, refused, stdout};
use serde_json::Value;
use std::fs;

#[test]
fn collocation_works_no_more_a_bond_on_a_longer_ring() {
    // Counted, not timed: evaluations of a ring whose contacts begin and end at times of their own.
    // The count of collocation is that of the block with the most sweeps.
    let forces = |integrator: &str, sites: usize| {
        let changes = format!("--set chain.sites={sites} --set initial.zeta=0.1 --set span.periods=3");
        let run = json(&format!("run tw-q15 --integrator {integrator} --tol 1e-9 {changes}"));
        run["force_evaluations"].as_f64().unwrap()
    };
    assert!(forces("collocation", 500) < 2.0 * forces("collocation", 50));
    assert!(forces("dop853-regularised", 50) > 2.0 * forces("dop853-regularised", 10));
}

#[test]
fn a_sweep_keeps_what_an_open_chain_dissipates() {
    // Truth: a bead that flies away with the speed v has lost v^2 (1 - exp(-2 c t))/2 to its drag
    // c.
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    let scene = "[scene]\nchain = { sites = 2, alpha = 1.5, boundary = \"free\" }\nbeads.drag = 0.1\n\
                 initial = { kind = \"state\", u_dot = [0, 0.5] }\nspan.until = 5\n";
    let axis = "[[axis]]\nkey = \"beads.drag\"\nvalues = [0.1, 0.3]\n";
    fs::write(&plan, format!("keep = [\"dissipated.total\", \"driven\"]\n{scene}{axis}")).unwrap();
    let swept = json(&format!("sweep {}", plan.display()));
    for (lost, drag) in numbers(&swept["columns"]["dissipated.total"]).into_iter().zip([0.1, 0.3]) {
        assert!((lost - 0.125 * (1.0 - f64::exp(-10.0 * drag))).abs() < 1e-9, "{drag}: {lost}");
    }
    assert_eq!(numbers(&swept["columns"]["driven"]), [0.0; 2]);
}

#[test]
fn a_pulse_has_the_speed_of_the_exact_wave_with_its_force() {
    // Truth: the solitary wave of Newton's method, c = C F^((alpha - 1)/(2 alpha)), printed with
    // ten digits and more. A pulse becomes one within a few bonds of the strike.
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    let keep = "[\"speed[20..40]\", \"bonds.peak_force[30]\", \"bonds.contacts[30]\"]";
    let axis = "[[axis]]\nkey = \"chain.alpha\"\nvalues = [1.5, 2.0]\n";
    fs::write(&plan, format!("scene = \"impact\"\nkeep = {keep}\n{axis}")).unwrap();
    let swept = json(&format!("sweep {}", plan.display()));
    for (point, (alpha, constant)) in [(1.5, 0.905_515_776_419), (2.0, 0.845_853_642_350)].into_iter().enumerate() {
        let of = |name: &str| numbers(&swept["columns"][name])[point];
        let speed = constant * of("bonds.peak_force[30]").powf((alpha - 1.0) / (2.0 * alpha));
        assert!((of("speed[20..40]") / speed - 1.0).abs() < 1e-7, "{alpha}");
        assert_eq!(of("bonds.contacts[30]"), 1.0);
    }
    let text = stdout("run impact --events");
    assert!(text.contains("pulse       8.405088e-1 bonds per unit of time from bond 40 to bond 80"), "{text}");
    for bad in ["speed[20]", "speed[20..20]", "speed[20..999]", "bonds.impulse[999]"] {
        fs::write(&plan, format!("scene = \"impact\"\nkeep = [\"{bad}\"]\n{axis}")).unwrap();
        let said = refused(&format!("sweep {}", plan.display()), 2);
        assert!(said.contains(bad) && said.contains("`keep`"), "{said}");
    }
}

#[test]
fn the_largest_energy_error_so_far_never_falls_and_is_that_of_the_method() {
    let study = json("study drift --periods 150 --samples 40");
    let period = study["period"].as_f64().unwrap();
    let rows = study["rows"].as_array().unwrap();
    for row in rows {
        let (t, errors) = (numbers(&row["t"]), numbers(&row["energy_error"]));
        assert_eq!((t.len(), errors.len()), (40, 40));
        assert!(t[0] == period && (t[39] / (150.0 * period) - 1.0).abs() < 1e-15);
        let ratio = t[1] / t[0];
        assert!(t.windows(2).all(|pair| (pair[1] / pair[0] / ratio - 1.0).abs() < 1e-12));
        assert!(errors.windows(2).all(|pair| pair[0] <= pair[1]), "the largest so far never falls");
    }
    // The tolerance of the first is 1e-13; 64 kicks a period of the others see contacts that last a
    // tenth of it.
    let last = |row: &Value| numbers(&row["energy_error"])[39];
    assert!(rows[0]["integrator"] == "collocation" && last(&rows[0]) < 1e-12, "{:e}", last(&rows[0]));
    assert!(rows[1..].iter().all(|row| (1e-6..0.1).contains(&last(row))));
    assert_eq!(rows[1]["steps"], 64 * 150);
    let short = json("study drift tw-q15 --periods 5 --integrators verlet --samples 9");
    assert!(short["rows"][0]["slope"].is_null(), "five periods are less than two decades");
}

// Truth: the closed form has no steps; an integrator that is named has. The energy of each of its
// samples, a sum over 40 sites, is rounded.
#[test]
fn a_scene_with_an_exact_solution_runs_without_integrator_unless_one_is_asked_for() {
    let exact = json(&["run", "trivial-breather", "--events", "--json"]);
    assert_eq!((exact["integrator"].as_str(), exact["steps"].as_u64()), (Some("closed-form"), Some(0)));
    assert_eq!(exact["contacts"]["contacts"], 0);
    assert!(exact["failure"].is_null() && exact["energy_error"].as_f64().unwrap() < 2e-15);
    for flags in
        [&["--integrator", "strang-linear"][..], &["--tol", "1e-9"], &["--steps-per-period", "3"], &["--step", "1"]]
    {
        let run = json(&[&["run", "trivial-breather", "--json"], flags].concat());
        assert!(run["integrator"] != "closed-form" && run["steps"].as_u64().unwrap() > 0, "{flags:?}");
    }
    let plan = json(&["run", "trivial-breather", "--plan", "--json"]);
    assert_eq!(plan["integrator"], "closed-form");
    assert!(
        plan["plan"].as_array().unwrap().iter().any(|line| line.as_str().unwrap().contains("no integrator, no steps"))
    );
}

// Those of other branches: `branch_points.rs`.
#[test]
fn doubled_branches_are_the_same_to_the_last_bit_on_any_number_of_threads() {
    let line = "breather doubled --sites 21 --step 0.02 --most 2.066 --omega-b 1.0325 --json";
    let on = |threads: &str| printed(command(line).env("RAYON_NUM_THREADS", threads).output().unwrap());
    let one = on("1");
    let branch: Value = serde_json::from_str(&one).unwrap();
    assert!(branch["points"].as_array().unwrap().len() > 2 && branch["points"][0]["leading"][0]["modulus"].is_f64());
    assert!(one == on("3"));
}

#[test]
fn an_orbit_is_written_read_back_and_let_go() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    stdout(&format!("breather dark --center bond --omega-b 2.05 --sites 21 --out {out}"));
    let file = folder.path().join("dark-breather.npz");
    let name = file.to_str().unwrap();
    let study = json(&format!("breather evolve {name} --until 62 --kick 1e-3 --mode 0"));
    for key in ["t", "e_b", "position"] {
        assert_eq!(study[key].as_array().unwrap().len(), 21, "{key}");
    }
    assert_eq!(study["motion"].as_array().unwrap().len(), 3);
    assert!(study["e_b"][20].as_f64().unwrap() > 1e-3 && study["failure"].is_null());
    for (more, rule) in [("--until 1", "until = 1"), ("--kick 0", "kick = 0"), ("--kick 1e-3 --mode 84", "mode = 84")] {
        assert!(refused(&format!("breather evolve {name} {more}"), 2).contains(rule), "{more}");
    }
}

// Truth: the exit code that the help promises: at omega/c = 2 pi every ring is in resonance, and no
// wave is found.
#[test]
fn solitary_waves_fail_where_a_ring_is_in_resonance() {
    let output = hertzchain("wave solitary --sites 12 --rhos 0.03187690,0.02 --json");
    let (said, json) =
        (String::from_utf8_lossy(&output.stderr), serde_json::from_slice::<Value>(&output.stdout).unwrap());
    assert!(output.status.code() == Some(1) && said.contains("no wave was found at rho = 0.03188"), "{said}");
    assert!(json["tails"][0]["wake"].is_null() && json["tails"][1]["wake"].as_f64().unwrap() > 0.0);
    assert!((json["coefficient"].as_f64().unwrap() - 0.905_515_776_419).abs() < 1e-12);
}

// Truth: the parameter has a column of its own, whatever else the branch measures.
#[test]
fn branches_in_every_parameter_of_a_breather_have_their_files() {
    let folder = tempfile::tempdir().unwrap();
    for (vary, from, to) in [("rho", 0.33, 0.332), ("kappa", 1.0, 1.002), ("alpha", 1.5, 1.502), ("c_x", 0.0, -1e-4)] {
        let out = folder.path().join(vary);
        let line = format!("breather continue --sites 5 --omega-b 2.1 --vary {vary} --from={from} --to={to}");
        let output = hertzchain(&format!("{line} --out {}", out.display()));
        assert!(output.status.success(), "{vary}: {}", String::from_utf8_lossy(&output.stderr));
        let csv = fs::read_to_string(out.join("branch.csv")).unwrap();
        let head: Vec<&str> = csv.lines().find(|line| !line.starts_with('#')).unwrap().split(',').collect();
        let first = csv.lines().filter(|line| !line.starts_with('#')).nth(1).unwrap();
        assert_eq!((head[0], first.split(',').next().unwrap().parse::<f64>().unwrap()), (vary, from));
        assert_eq!(head.iter().filter(|name| name.starts_with("c_x")).count(), if vary == "c_x" { 2 } else { 1 });
    }
}

// Truth: what the numbers are: the velocity is 1/T_m, half a period and 11 whole ones. A kick that
// is not asked for leaves no file of an earlier one.
#[test]
fn moving_breathers_have_their_velocity_and_fail_where_none_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let moving = format!("breather moving --sites 15 --json --out {}", folder.path().display());
    let json = json(&format!("{moving} --omega-b 2.1 --turns 8 --until 100"));
    let point = &json["points"][0];
    let passage = 8.5 * 2.0 * std::f64::consts::PI / 2.1;
    assert!((point["passage"].as_f64().unwrap() - passage).abs() < 1e-12);
    assert!((point["velocity"].as_f64().unwrap() * passage - 1.0).abs() < 1e-12);
    assert!(point["residual"].as_f64().unwrap() < 1e-12 && point["return_error"].as_f64().unwrap() < 1e-10);
    assert!(!json["kicked"]["position"].as_array().unwrap().is_empty());
    let exists = |name: &str| folder.path().join(name).exists();
    assert!(exists("passages.csv"));
    let output = hertzchain(&format!("{moving} --omega-b 2.1 --turns 8,1 --until 0"));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && text.contains("2.1 with 1 turns"), "{text}");
    assert!(!exists("passages.csv") && exists("moving.csv"));
    assert!(refused(&format!("{moving} --omega-b 1.9"), 2).contains("above omega"));
}

// Truth: the message and the file of the best iterate; an earlier result does not stay beside it.
#[test]
fn a_search_for_an_exact_wave_that_stalls_keeps_its_best_iterate() {
    let folder = tempfile::tempdir().unwrap();
    let exact = format!("wave exact --sites 10 --out {}", folder.path().display());
    stdout(&exact);
    assert!(folder.path().join("exact.json").exists());
    let stalled = hertzchain(&format!("{exact} --omega-tw 1.5"));
    let text = String::from_utf8_lossy(&stalled.stderr).into_owned();
    assert!(stalled.status.code() == Some(1) && text.contains("no periodic orbit after"), "{text}");
    assert_eq!(names(folder.path()), ["stalled.json".to_owned()].into());
    let kept = read_json(&folder.path().join("stalled.json"));
    assert!(kept["residual"].as_f64().unwrap() > 1e-12 && kept["x"].as_array().unwrap().len() == 10, "{kept}");
}

#[test]
fn a_branch_is_kept_if_no_other_one_crosses_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mode = "orbit mode defect --to 0.2 --step 0.1 --switch 99";
    let driven = "orbit continue --to 2e-6 --settle 20 --max-points 3 --switch 99";
    for (line, table, whole) in
        [(mode, "mode-branch.csv", "mode.json"), (driven, "driven-branch.csv", "driven-branch.json")]
    {
        let output = hertzchain(&format!("{line} --json --out {}", out.display()));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.starts_with("error: switch = 99 of 0 is not valid: the branch has no bifurcation"), "{error}");
        let result: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(result["points"].as_array().unwrap().len() > 1);
        assert!(result["switched"]["at"] == 99 && error.contains(result["switched"]["failure"].as_str().unwrap()));
        assert!(out.join(table).exists() && out.join(whole).exists() && !out.join("switched-branch.csv").exists());
    }
}
