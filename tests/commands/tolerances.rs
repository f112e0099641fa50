//! Ranges of options, tolerances above all: every command says and keeps the same range; what a run
//! says where its energy or a second method contradicts its tolerance.

use super::{
    help::{commands, help},
    program::{hertzchain, json, numbers, read_json, refused},
};
use serde_json::Value;

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// What a command needs beside its tolerance.
fn operands(command: &str) -> &'static [&'static str] {
    match command {
        "run" => &["impact"],
        "wave" => &["tw-q15"],
        "wave exact" => &["tw-q15", "--prove"],
        "wave continue" => &["tw-q15", "--to", "2.01"],
        "breather evolve" => &["dark-breather.npz"],
        "compare" => &["impact"],
        "breather continue" => &["--bifurcations"],
        "orbit mode" | "orbit continue" => &["--to", "0.01"],
        "wave modulation" => &["--measure"],
        "dps integrals" => &["--b", "0.5", "--r", "1"],
        _ => &[],
    }
}

/// Values outside the range that the help of a flag ends with, and its rule.
fn outside(help: &str) -> Option<(String, Vec<String>)> {
    let rule = help.split(" [default").next()?.trim_end_matches('.').rsplit(". ").next()?;
    let rule = rule.trim_start_matches("Each is ");
    let rule = format!("{}{}", rule.get(..1)?.to_lowercase(), &rule[1..]);
    let words: Vec<&str> = rule.split(' ').collect();
    let number = |k: usize| words.get(k).and_then(|word| word.parse::<f64>().ok());
    let values = match &words[..] {
        ["from", _, "to", most, ..] => {
            let (whole, least, most) = (most.parse::<u64>().is_ok(), number(1)?, number(3)?);
            if whole && least >= 0.0 {
                let odd = ["1e18", "1000000000000000000", "-1", "nan"].map(str::to_owned).to_vec();
                return Some((rule, [vec![(least - 1.0).to_string(), (most + 1.0).to_string()], odd].concat()));
            }
            [(least > 0.0).then_some(0.5 * least), Some(1.5 * most)]
        }
        ["a", "finite", "number"] => [Some(f64::INFINITY), Some(f64::NAN)],
        ["finite", "and", "positive"] => [Some(0.0), Some(f64::INFINITY)],
        ["finite", "and", "at", "least", _] => [Some(number(4)? - 1.0), Some(f64::INFINITY)],
        ["at", "least", _] => [Some(number(2)? - 1.0), None],
        ["above", _, "and", "at", "most", _] => [number(1), Some(1.5 * number(5)?)],
        ["above", _, "and", "below", _] => [number(1), number(4)],
        _ => return None,
    };
    // What no double is, and no number.
    let odd = ["1e400", "1e-400", "one"].map(str::to_owned);
    let values = values.into_iter().flatten().map(|value| value.to_string()).chain(odd).collect();
    Some((rule, values))
}

#[test]
fn every_study_refuses_what_the_help_of_a_flag_excludes() {
    let mut seen = 0;
    for path in commands() {
        let name = path.join(" ");
        if name == "run" || name == "breather evolve" {
            continue;
        }
        let help = help(&path, "--help");
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        for flag in help.split("\n      --").skip(1) {
            let (flag, said) = flag.split_once(char::is_whitespace).unwrap();
            let said = said.split_whitespace().skip(1).collect::<Vec<_>>().join(" ");
            let Some((rule, values)) = outside(&said) else { continue };
            // A flag is given once.
            let given = operands(&name);
            let at = given.iter().position(|one| one.strip_prefix("--") == Some(flag)).unwrap_or(given.len());
            let others = [&given[..at], given.get(at + 2..).unwrap_or_default()].concat();
            for value in values {
                let run = hertzchain(&[&path[..], &others[..], &[&format!("--{flag}={value}")]].concat());
                let said = text(&run.stderr);
                let good = said.contains(&format!("--{flag} = ")) && said.contains(" is not valid: ");
                // The exponent has other rules in some studies, and their words.
                let good = good && (flag == "alpha" || said.contains(&rule));
                // Clap refuses what it cannot read.
                let good = good || said.contains(&format!("invalid value '{value}' for '--{flag} "));
                assert!(run.status.code() == Some(2) && good, "{name} --{flag}={value}, {rule}: {said}");
            }
            seen += 1;
        }
    }
    assert!(seen >= 60, "{seen}");
}

#[test]
fn a_method_has_one_range_for_the_command_line_a_scene_and_the_library() {
    use hertzchain::{Method, Scene};
    for name in ["collocation", "corrected", "dop853", "dop853-landed", "dop853-regularised"] {
        let method = Method::named(name).unwrap();
        let range = method.tolerances();
        for (tol, good) in [(range.least, true), (0.9 * range.least, false), (range.most, true), (0.5, false)] {
            let set = [format!("method.integrator={name}"), format!("method.tol={tol:e}"), "span.until=0.1".into()];
            let scene = Scene::load_with("impact", &set);
            let run = Scene::load("impact").unwrap().until(0.1).unwrap().run().method(method).tolerance(tol);
            let (by_scene, by_run) =
                (scene.err().map(|error| error.to_string()), run.err().map(|error| error.to_string()));
            let plan =
                ["run", "impact", "--plan", "--until", "0.1", "--integrator", name, "--tol", &format!("{tol:e}")];
            let plan = hertzchain(&plan);
            let by_flag = (!plan.status.success()).then(|| text(&plan.stderr));
            for said in [by_scene, by_run, by_flag] {
                assert_eq!(said.is_none(), good, "{name} at {tol:e}: {said:?}");
                assert!(said.is_none_or(|said| said.contains("tol = ") && said.contains(range.rule)), "{name}");
            }
        }
    }
}

/// Two beads that meet head-on, 10^8 from the origin: positions there have a spacing of 1.5e-8, so
/// that no method keeps the energy to 1e-10.
const FAR: &str = r#"
name = "far"
chain = { sites = 2, alpha = 1.5, kappa = 0.0, rho = 0.0, boundary = "free" }
initial = { kind = "state", u = [1e8, 1e8], u_dot = [1.0, -1.0] }
span = { until = 10.0 }
"#;

#[test]
fn a_run_whose_energy_error_is_not_explained_fails_and_keeps_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let (out, scene) = (folder.path().join("out"), folder.path().join("far.toml"));
    std::fs::write(&scene, FAR).unwrap();
    let far = |more: &[&str]| {
        let run = ["run", scene.to_str().unwrap(), "--integrator", "dop853-regularised", "--json"];
        hertzchain(&[&run[..], more].concat())
    };
    let run = far(&["--tol", "1e-13", "--out", out.to_str().unwrap()]);
    let (json, said): (Value, _) = (serde_json::from_slice(&run.stdout).unwrap(), text(&run.stderr));
    let error = json["energy_error"].as_f64().unwrap();
    assert!(run.status.code() == Some(1) && error > 1e-10, "{said}{error}");
    let warning = json["warnings"][0].as_str().unwrap();
    assert!(warning.contains("the tolerance 1e-13 explains at most 1.0e-10") && said.contains(warning), "{warning}");
    assert!(json["failure"].is_null());
    assert_eq!(read_json(&out.join("summary.json"))["warnings"], json["warnings"]);
    // The same motion at the origin.
    std::fs::write(&scene, FAR.replace("1e8", "0.0")).unwrap();
    let run = far(&["--tol", "1e-13"]);
    let json: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(run.status.success() && json["warnings"] == serde_json::json!([]), "{}", text(&run.stderr));
    // Equal steps, too long for the contact.
    let two = ["run", "impact", "--set", "chain.sites=2", "--until", "13"];
    let long = hertzchain(&[&two[..], &["--integrator", "verlet", "--step", "1.3"]].concat());
    let (summary, said) = (text(&long.stdout), text(&long.stderr));
    assert!(long.status.code() == Some(1) && said.contains("no order explains more than half"), "{said}");
    assert!(summary.contains("WARNING     the energy is off by"), "{summary}");
}

#[test]
fn a_point_of_a_sweep_whose_energy_is_lost_has_failed() {
    use hertzchain::{
        study::{Plan, planned},
        sweep::Engine,
    };
    let plan = r#"
        scene = "impact"
        set = ["chain.sites=2", "span.until=13", "method.integrator=verlet"]
        axis = [{ key = "method.step", values = [0.01, 1.3] }]
    "#;
    let plan = Plan::parse(plan, "plan.toml".as_ref()).unwrap();
    let study = planned(&plan, &Engine::threads(), &|_, _| ()).unwrap();
    assert!(study.failures == 1 && study.failed[0].0 == 1, "{:?}", study.failed);
    assert!(study.failed[0].1.contains("the energy is off by"), "{:?}", study.failed);
}

/// Eight beads between walls, the first one struck. Changes of 1e-12 and 1e-13 of the initial state
/// are 3.5e11 and 4.7e11 times larger at t = 320; those of 1e-10 have the size of the state.
const EIGHT: [&str; 7] =
    ["impact", "--set", "chain.sites=8", "--set", "chain.boundary=fixed", "--set", "record.samples=5"];

#[test]
fn amplification_bounds_the_error_by_the_tolerance() {
    let run = |more: &[&str]| json(&[&["run"], &EIGHT[..], &["--until", "320"], more].concat());
    let [coarse, fine] = [["--amplification", "--tol", "1e-10"], ["--integrator=dop853-regularised", "--tol", "1e-15"]]
        .map(|more| run(&more));
    let factor = coarse["amplification"].as_f64().unwrap();
    assert!((1e9..1e11).contains(&factor), "{factor:e}");
    let (coarse, fine) = (numbers(&coarse["u"]), numbers(&fine["u"]));
    let size = fine.iter().fold(0.0, |size: f64, u| size.max(u.abs()));
    let error = coarse.iter().zip(&fine).fold(0.0, |error: f64, (a, b)| error.max((a - b).abs())) / size;
    // The tolerance alone does not bound the error; times the factor it does.
    assert!(error > 1e5 * 1e-10 && error < 3.0 * factor * 1e-10, "{error:e}, {factor:e}");
    assert!(refused("run trivial-breather --amplification", 2).contains("no error grows"));
}

#[test]
fn references_that_contradict_each_other_end_a_comparison() {
    // Far beyond t = 320 the two references share no digit.
    let run = [&["compare"], &EIGHT[..], &["--set", "span.until=1500", "--max-time", "20", "--integrators", "verlet"]];
    let said = refused(&run.concat(), 1);
    assert!(
        said.contains("collocation at tol 1e-14 and dop853-regularised")
            && said.contains("in strains, velocities of beads and stretches of resonators"),
        "{said}"
    );
}
