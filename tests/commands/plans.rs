//! Plans of sweeps: what they say, and what is refused.

use super::refusals::rows;
use hertzchain::{
    report::{Figure, Plot},
    run::Records,
    study::{Plan, planned},
    sweep::Engine,
};
use std::path::Path;

fn parsed(text: &str) -> hertzchain::Result<Plan> {
    Plan::parse(text, Path::new("a/plan.toml"))
}

fn keys(plan: &Plan, number: usize) -> Vec<String> {
    plan.point(number).0.iter().map(|(key, value)| format!("{key}={value}")).collect()
}

#[test]
fn the_last_axis_goes_fastest_and_zipped_axes_move_together() {
    let plan = parsed(
        r#"
        axis = [
            { key = "chain.rho", from = 0.1, to = 10, count = 3, scale = "log" },
            { key = "chain.kappa", values = [1, 2.5, 4], zip = true },
            { key = "chain.sites", from = 10, to = 30, count = 3 },
        ]
        [scene]
        chain = { sites = 10, alpha = 1.5, kappa = 1, rho = 1, boundary = "free" }
        initial = { kind = "single-bead", site = 0, velocity = 1 }
        span = { until = 3 }"#,
    )
    .unwrap();
    assert_eq!((plan.points(), plan.name.as_str()), (9, "plan"));
    assert_eq!(keys(&plan, 0), ["chain.rho=0.1", "chain.kappa=1", "chain.sites=10"]);
    assert_eq!(keys(&plan, 1), ["chain.rho=0.1", "chain.kappa=1", "chain.sites=20"]);
    // Truth: the middle of 0.1 and 10 on a logarithmic axis.
    let (rho, rest) = (plan.point(4).0[0].1.as_float().unwrap(), keys(&plan, 4));
    assert!((rho - 1.0).abs() < 1e-15 && rest[1..] == ["chain.kappa=2.5", "chain.sites=20"]);
    assert_eq!(keys(&plan, 8), ["chain.rho=10.0", "chain.kappa=4", "chain.sites=30"]);
}

#[test]
fn the_template_is_a_plan_and_a_scene_may_be_inside() {
    let plan = Plan::parse(Plan::TEMPLATE, Path::new("template.toml")).unwrap();
    // Masses that repeat are equal at the last mass ratio of `dimer`, and only there.
    assert!(plan.points() > 1 && Plan::list().all(|(name, _)| Plan::load(name.as_ref()).unwrap().doubts.is_empty()));
    let inside = parsed(
        r#"
        [scene]
        chain = { sites = 4, alpha = 1.5, boundary = "free" }
        initial = { kind = "single-bead", site = 0, velocity = 1.0 }
        span = { until = 1.0 }
        [[axis]]
        key = "chain.sites"
        values = [4, 0]"#,
    );
    let why = inside.unwrap_err().to_string();
    assert!(why.starts_with("scene a/plan.toml [scene]: --set chain.sites=0: `chain.sites`"), "{why}");
}

#[test]
fn points_that_are_run_side_by_side_have_the_rows_of_each_alone() {
    // Truth: each run of its own. The first axis changes the exponent, so that some groups
    // are cut; a point whose scene is refused fails alone.
    let plan = r#"
        set = ["method.integrator=strang-linear", "method.step=0.05"]
        keep = ["energy_error", "u"]
        axis = [
            { key = "chain.alpha", values = [1.5, 2.0] },
            { key = "initial.velocity", values = [0.1, 0.2, 0.3, "fast", 0.5, 0.6, 0.7] },
            { key = "chain.kappa", from = 0.5, to = 2.0, count = 7, zip = true },
        ]
        [scene]
        chain = { sites = 12, alpha = 1.5, kappa = 1.0, rho = 0.4, boundary = "free" }
        initial = { kind = "single-bead", site = 0, velocity = 1.0 }
        span = { until = 5.0 }
    "#;
    let plan = Plan::parse(plan, "plan.toml".as_ref()).unwrap();
    let study = planned(&plan, &Engine::threads(), &|_, _| ()).unwrap();
    let column = |name: &str| study.columns.iter().find(|column| column.name == name).unwrap();
    for k in 0..plan.points() {
        let Ok(scene) = plan.scene(&plan.point(k)) else {
            assert!(k % 7 == 3 && column("energy_error").numbers[k].is_nan());
            continue;
        };
        let alone = scene.run().records(Records::Energy).start().unwrap();
        assert_eq!(column("energy_error").numbers[k], alone.energy_error.unwrap(), "{k}");
        assert_eq!(column("u").numbers[12 * k..][..12], *scene.chain().layout().u(&alone.state), "{k}");
    }
    assert_eq!(study.failures, 2);
}

#[test]
fn over_seeds_quartiles_are_told_and_the_picture_shows_every_seed() {
    let plan = r#"
        keep = ["energies.beads"]
        axis = [{ key = "beads.mass.seed", seeds = 6 }, { key = "chain.alpha", values = [1.5, 2.0] }]
        [scene]
        chain = { sites = 6, alpha = 1.5, boundary = "free" }
        beads = { mass = { random = "uniform", from = 0.5, to = 1.5, seed = 1 } }
        initial = { kind = "single-bead", site = 0, velocity = 1.0 }
        span = { until = 2.0 }
    "#;
    let study = planned(&parsed(plan).unwrap(), &Engine::threads(), &|_, _| ()).unwrap();
    let report = study.report().unwrap();
    for (k, row) in report.json()["seeds"].as_array().unwrap().iter().enumerate() {
        assert_eq!(row["point"], ["chain.alpha = 1.5", "chain.alpha = 2"][k]);
        let mut all: Vec<f64> = study.columns[2].numbers.iter().skip(k).step_by(2).copied().collect();
        all.sort_by(f64::total_cmp);
        // Truth: the sixth parts of the interval from the first to the last place.
        let truth =
            [all[0], 0.75 * all[1] + 0.25 * all[2], 0.5 * (all[2] + all[3]), 0.25 * all[3] + 0.75 * all[4], all[5]];
        for (name, truth) in ["least", "quartile_1", "median", "quartile_3", "largest"].iter().zip(truth) {
            assert!((row[*name].as_f64().unwrap() - truth).abs() < 1e-15, "{name}: {row}");
        }
        let Figure::Panels(figure) = &report.pictures()[0].1 else { panic!("not panels") };
        let Plot::Panel(panel) = &figure.columns[0].panels[0] else { panic!("not a panel") };
        assert_eq!(panel.lines[k].points.iter().map(|point| point.0).step_by(2).collect::<Vec<_>>(), all);
        assert_eq!(panel.lines[k].points[11].1, 1.0);
    }
    assert!(report.text().lines().count() < 12, "{}", report.text());
}

#[test]
fn a_plan_that_breaks_a_rule_is_refused_with_file_key_and_rule() {
    for row in rows(include_str!("../refusals/plans.txt")) {
        let (lines, words) = row.split_once(" => ").unwrap();
        let why = parsed(&match lines.split_once(' ').unwrap() {
            ("axis", axis) => format!("scene = \"impact\"\n[[axis]]\n{axis}"),
            (_, plan) => format!("{plan}\naxis = [{{ key = \"chain.rho\", values = [1] }}]"),
        });
        let why = why.unwrap_err().to_string();
        assert!(why.contains(words), "{row}: {why}");
    }
    let many = "[[axis]]\nkey = \"chain.rho\"\nvalues = [1]\n".repeat(1001);
    let why = parsed(&format!("scene = \"impact\"\n{many}")).unwrap_err().to_string();
    assert!(why.contains("`axis`: 1001 axes: a plan has at most 1000"), "{why}");
    assert!(parsed("scene = \"impact\"").unwrap_err().to_string().contains("at least one axis"));
}
