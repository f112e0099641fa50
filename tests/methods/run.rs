//! The interface `Run`: runs that are built by hand.

use hertzchain::{
    Boundary, Chain, Method, Params, Result, Run, Scene, Setting, State,
    run::{Records, Regime, regime},
};

/// A free chain of beads with resonators, the first one struck.
fn struck(sites: usize) -> Run {
    let chain = Chain::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::Free, sites).unwrap();
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    Run::new(chain, state)
}

#[test]
fn states_at_times_are_those_of_the_run() {
    let run = struck(6).until(9.0).unwrap().tolerance(1e-11).unwrap();
    let times = [0.0, 0.3, 0.3, 4.5, 9.0];
    let states: Vec<State<f64>> = run.at(&times).unwrap().collect::<Result<_>>().unwrap();
    assert_eq!(states.len(), times.len());
    assert_eq!(states[0].as_slice(), run.initial().as_slice());
    assert_eq!(states[1], states[2]);
    let end = run.records(Records::End).start().unwrap();
    assert_eq!(states[4].as_slice(), end.state);
    // States at intermediate times too. Truth: another method.
    let other =
        struck(6).until(9.0).unwrap().method(Method::named("dop853-regularised").unwrap()).tolerance(1e-12).unwrap();
    for (state, other) in states.iter().zip(other.at(&times).unwrap()) {
        let other = other.unwrap();
        let gap = state.as_slice().iter().zip(other.as_slice()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(gap < 1e-9, "{gap:e}");
    }
}

#[test]
fn what_is_not_said_is_chosen() {
    let run = struck(4).until(5.0).unwrap();
    let Regime { method, setting, .. } = regime(&run).unwrap();
    assert_eq!(run.choice().unwrap(), (method, setting));
    assert_eq!(method, Method::Collocation);
    assert_eq!(run.clone().step(0.01).unwrap().choice().unwrap(), (Method::CORRECTED, Setting::Steps(500)));
    assert_eq!(run.clone().tolerance(1e-8).unwrap().choice().unwrap().0, Method::Collocation);
    let verlet = Method::named("verlet").unwrap();
    assert!(matches!(run.method(verlet).choice().unwrap(), (_, Setting::Steps(steps)) if steps >= 512));
}

#[test]
fn what_makes_no_sense_is_refused_where_it_enters() {
    let message = |result: Result<Run>| result.unwrap_err().to_string();
    assert!(message(struck(3).until(-1.0)).contains("until = -1"));
    assert!(message(struck(3).until(f64::NAN)).contains("until = NaN"));
    assert!(message(struck(3).tolerance(1.0)).contains("tol = 1 is not valid: from 1e-15 to 0.1"));
    assert!(message(struck(3).until(1.0).unwrap().step(0.0)).contains("step = 0"));
    assert!(message(struck(3).step(0.1)).contains("a run needs an end"));
    assert!(message(struck(3).until(1.0).unwrap().step(1e-300)).contains("at most 1e15 steps"));
    assert!(message(struck(3).samples(2_000_000)).contains("at most 10^6"));
    let error = struck(3).start().unwrap_err().to_string();
    assert!(error.contains("a run needs an end"), "{error}");
    let run = struck(3).until(2.0).unwrap();
    for (times, part) in [(&[1.0, 0.5][..], "ascending"), (&[3.0], "the end of the run"), (&[-0.1], "from zero")] {
        let error = run.at(times).err().unwrap().to_string();
        assert!(error.contains(part), "{error}");
    }
    // A state of another chain.
    let other = Run::new(struck(3).chain().clone(), struck(4).initial().clone()).until(1.0).unwrap();
    let error = other.start().unwrap_err().to_string();
    assert!(error.contains("as many numbers as the chain has"), "{error}");
}

#[test]
fn a_scene_names_its_method_and_is_refused_where_that_makes_no_sense() {
    let text = |method: &str| format!("{}\n[method]\n{method}", Scene::source("impact").unwrap());
    let scene = |method: &str| Scene::parse(&text(method), "mine.toml");
    let named = scene("integrator = \"corrected\"\nstep = 0.05").unwrap();
    let steps = (named.end() / 0.05 * (1.0 - 1e-12)).ceil() as u64;
    assert_eq!(named.choice(), Some((Method::CORRECTED, Setting::Steps(steps))));
    // The same bits as a run by hand.
    let end = |run: Run| run.records(Records::End).start().unwrap().state;
    let by_hand = Scene::load("impact").unwrap().run().method(Method::CORRECTED).step(0.05).unwrap();
    assert_eq!(end(named.run()), end(by_hand));
    // Another span, the same step.
    let longer = named.until(10.0).unwrap();
    assert_eq!(longer.choice(), Some((Method::CORRECTED, Setting::Steps(200))));
    assert_eq!(Scene::load("impact").unwrap().choice(), None);
    for (method, part) in [
        ("integrator = \"colocation\"", "did you mean \"collocation\"?"),
        ("integrator = \"collocation\"\ntol = 7.0", "tol = 7 is not valid: from 1e-15 to 0.1"),
        ("integrator = \"collocation\"\nstep = 0.1", "takes `tol`"),
        ("integrator = \"verlet\"\ntol = 1e-6", "takes `step`"),
        ("integrator = \"verlet\"\nsteps_per_period = -4.0", "steps_per_period = -4"),
        ("integrator = \"verlet\"\nsteps_per_period = nan", "steps_per_period = NaN"),
        ("integrator = \"verlet\"\nsteps_per_period = inf", "step = 0"),
        ("integrator = \"verlet\"\nstep = 1e-300", "at most 1e15 steps"),
        ("integrator = \"corrected\"\nstep = 0.1\ntol = 1e-6", "give one of"),
        ("tol = 1e-6", "integrator"),
    ] {
        let error = scene(method).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("mine.toml"), "{method}: {error}");
    }
}

#[test]
fn no_scene_of_the_program_has_a_warning() {
    for (name, _) in Scene::list() {
        let scene = Scene::load(name).unwrap();
        assert_eq!(scene.clone().until(scene.end()).unwrap().end(), scene.end(), "{name}");
        // Truth: the rule of `[record]`; with fewer than a few samples a period waves seem to stand
        // still.
        if scene.has_period() && scene.file().span.period.is_none() {
            assert_eq!(scene.clone().until(400.0 * scene.period()).unwrap().samples(), 6400, "{name}");
        }
        // Some drives come to their full height later.
        let short = scene.clone().until(scene.end().min(60.0)).unwrap_or(scene);
        let end = short.run().start().unwrap();
        assert!(end.failure.is_none() && end.warnings.is_empty(), "{name}: {:?}", end.warnings);
    }
}

#[test]
fn rounding_errors_and_energy_that_flows_through_are_no_warning() {
    // The smallest tolerance: what remains is rounding.
    let run = struck(8).until(400.0).unwrap().method(Method::named("dop853-regularised").unwrap());
    let end = run.tolerance(1e-15).unwrap().start().unwrap();
    assert!(end.energy_error.unwrap() > 1e-15 && end.warnings.is_empty(), "{:?}", end.warnings);
    // A motion of 1e-8 of the overlaps: what their forces round is not sought with 2e5 short steps.
    let weak = ["chain.precompression=1.0", "chain.boundary=ring", "initial.velocity=1e-8"].map(str::to_owned);
    let run = Scene::load_with("impact", &weak).unwrap().until(5.0).unwrap().run();
    let run = run.method(Method::named("dop853-regularised").unwrap()).tolerance(1e-12).unwrap();
    let end = run.start().unwrap();
    assert!(end.stats.steps < 100 && end.warnings.iter().any(|it| it.to_string().contains("by 2.2e-8 of the motion")));
    // Almost at rest, then driven: the error is far above the initial energy, and small beside the
    // work.
    let scene = r#"
        chain = { sites = 3, alpha = 1.5, kappa = 0.0, rho = 0.0, boundary = "fixed" }
        drive = [{ site = 0, kind = "pushed", amplitude = 0.5, omega = 2.0, ramp = 4.0 }]
        initial = { kind = "state", u_dot = [0.0, 1e-9, 0.0] }
        span = { until = 30.0 }
    "#;
    let run = Scene::parse(scene, "pushed").unwrap().run();
    let end = run.method(Method::Collocation).tolerance(1e-6).unwrap().start().unwrap();
    assert!(end.energy_error.unwrap() < 1e-6 && end.warnings.is_empty(), "{:?} {:?}", end.energy_error, end.warnings);
}

/// Truth: `Omega_c = sqrt(2 alpha A^(alpha-1))`, `A^(alpha+1) = (alpha+1) V^2`, for two beads that
/// meet with speed `V` each; Hertz' law scales.
#[test]
fn steps_are_counted_against_the_fastest_motion() {
    use std::f64::consts::TAU;
    let period = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
        Scene::load_with("impact", &changes).unwrap().fast_period()
    };
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-13, "{a:e}, {b:e}");
    let hertz = TAU / (3.0 * 2.5f64.powf(0.2)).sqrt();
    for changes in [&[][..], &["span.period=32"], &["chain.boundary=ring"], &["chain.boundary=fixed"]] {
        close(period(changes), hertz);
    }
    // Equal beads with details are equal beads. Masses and constants of contacts scale.
    close(period(&["beads.mass=1.0"]), hertz);
    close(period(&["beads.mass=8.0", "bonds.contact=8.0"]), hertz);
    close(period(&["beads.mass=8.0"]), hertz * 8f64.powf(0.4));
    // A static overlap of 0.3 between beads that hardly move; a faster drive.
    let still = ["initial.velocity=1e-9", "chain.boundary=ring", "chain.precompression=0.3"];
    let stiff = TAU / (3.0 * 0.3f64.sqrt()).sqrt();
    assert!((period(&still) / stiff - 1.0).abs() < 1e-6);
    close(period(&["drive=[{site=0,kind=\"pushed\",amplitude=1e-3,omega=50.0}]"]), TAU / 50.0);
    // Nothing moves: the period of the scene.
    let rest = State::rest(struck(4).chain());
    let plain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 4).unwrap();
    assert_eq!(Run::new(plain.clone(), State::rest(&plain)).with_period(7.0).fast_period(), 7.0);
    // Resonators at rest.
    close(Run::new(struck(4).chain().clone(), rest).fast_period(), TAU / 2.0);
}

#[test]
fn the_waves_and_breathers_of_the_paper_keep_their_period() {
    let faster = |name: &str| Scene::load(name).unwrap().fast_period() / Scene::load(name).unwrap().period();
    for (name, _) in Scene::list() {
        let scene = Scene::load(name).unwrap();
        let uniform = scene.chain().details().is_none() && scene.units().is_none();
        match name {
            "tw-breakdown-q15" => assert!((0.9..0.95).contains(&faster(name))),
            "precompressed" => assert!((0.94..0.96).contains(&faster(name))),
            "impact" => assert!((3.3..3.32).contains(&faster(name))),
            _ if uniform => assert_eq!(faster(name), 1.0, "{name}"),
            _ => (),
        }
    }
}
