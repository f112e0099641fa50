//! References that `compare` measures errors against, and the levels that it leaves out.

use hertzchain::{
    Method, Scene,
    internals::{
        End, FINEST, Ladder, RESOLVED, ReferenceState, Refinement, STORED, Stored, distance, number_of_start, what,
    },
    study::{Candidate, Row},
    sweep::map,
};

/// A ladder with levels of these errors, each of which took as many seconds as its number.
fn ladder(name: &str, errors: &[f64]) -> Ladder {
    let candidate = Candidate::Method(Method::named(name).unwrap());
    let row = |(i, &error): (usize, &f64)| Row {
        error: Some(error),
        wall: Some((i + 1) as f64),
        failure: None,
        ..Row::failed(candidate, String::new(), String::new())
    };
    Ladder { candidate, rows: errors.iter().enumerate().map(row).collect(), stopped: None }
}

#[test]
fn a_ladder_promises_the_better_of_its_last_gains_and_the_nominal_one_at_first() {
    let promised = |name: &str, errors: &[f64]| ladder(name, errors).expected();
    let near = |promised: Option<f64>, error: f64| assert!((promised.unwrap() / error - 1.0).abs() < 1e-12);
    assert!(promised("verlet", &[]).is_none());
    // Order two, then what was seen, if that is more.
    near(promised("verlet", &[1.0]), 0.25);
    near(promised("verlet", &[1.0, 0.5]), 0.125);
    near(promised("verlet", &[1.0, 0.1]), 0.01);
    near(promised("verlet", &[8.0, 1.0, 0.5]), 0.0625);
    // A gain from before that is forgotten; an error that grew promises no growth.
    near(promised("verlet", &[80.0, 1.0, 0.5, 0.25]), 0.125);
    near(promised("verlet", &[1.0, 2.0, 3.0]), 3.0);
    near(promised("dop853", &[1.0]), 0.1);
}

#[test]
fn a_level_is_left_out_if_another_method_is_as_exact_in_less_time() {
    let scene = Scene::load("impact").unwrap();
    let reference = ReferenceState::find(&scene, 1.0, &|_| ()).unwrap();
    let reason = |budget: f64, other: &[f64]| {
        let mut refinement = Refinement::new(&scene, Vec::new(), budget, &|_, _| ());
        refinement.ladders = vec![ladder("verlet", &[1.0, 0.25, 0.0625]), ladder("corrected", other)];
        refinement.dominated(0, &reference)
    };
    // The next level promises 1.6e-2 after at least 3 s.
    assert!(reason(10.0, &[0.1, 0.02]).is_none());
    assert!(reason(10.0, &[0.1, 0.01]).unwrap().starts_with("corrected at "));
    assert!(reason(10.0, &[0.1, 0.1, 0.1, 0.01]).is_none(), "a slower one");
    // A level that costs next to nothing is never left out.
    assert!(reason(1e4, &[0.1, 0.01]).is_none());
}

/// The scenes with a stored reference.
fn scenes() -> Vec<Scene> {
    STORED.iter().map(|(name, _)| Scene::load(name).unwrap()).collect()
}

/// Truth: the stored runs are repeated. The bound is the error estimate of the pair twice: on
/// the machine that made them nothing differs, elsewhere sines may round differently.
fn is_repeated(scene: &Scene) {
    let stored = ReferenceState::find(scene, 1.0, &|_| ()).unwrap();
    assert!(stored.method.starts_with("stored"), "{}: {}", scene.name(), stored.method);
    for (end, run) in stored.ends.iter().zip([FINEST, RESOLVED]) {
        let again = End::by_tolerance(scene, run).unwrap();
        assert_eq!((&end.method, &end.setting), (&again.method, &again.setting));
        let gap = distance(&end.strains, &again.strains) / stored.amplitude;
        assert!(gap <= 2.0 * stored.error_estimate, "{}, {}: {gap:e}", scene.name(), end.method);
    }
}

#[test]
fn every_builtin_scene_has_a_reference_made_for_it() {
    for (name, _) in Scene::list() {
        let scene = Scene::load(name).unwrap();
        // References of other chains, and of scenes in SI units, are computed.
        if scene.chain().details().is_some() || scene.units().is_some() {
            continue;
        }
        assert!(scene.exact().is_some() || Stored::of(&scene).is_some(), "{name}");
    }
    // A scene that was changed is another scene.
    let changed = Scene::load_with("impact", &["initial.velocity=1.0000001".into()]).unwrap();
    assert!(Stored::of(&changed).is_none());
    assert!(Stored::of(&Scene::load("impact").unwrap().until(99.0).unwrap()).is_none());
}

#[test]
fn stored_references_of_short_scenes_are_what_the_methods_give() {
    for name in ["tw-breakdown-q15", "cradle", "precompressed"] {
        is_repeated(&Scene::load(name).unwrap());
    }
}

/// `HERTZCHAIN_STORE=1` stores them anew.
#[test]
#[ignore = "nightly: half a minute"]
fn stored_references_are_what_the_methods_give() {
    if std::env::var_os("HERTZCHAIN_STORE").is_some() {
        return scenes().iter().for_each(store);
    }
    scenes().iter().for_each(is_repeated);
}

fn store(scene: &Scene) {
    let ends = map(&[FINEST, RESOLVED], |run| End::by_tolerance(scene, *run).unwrap());
    let provenance = format!(
        "hertzchain {}, {}: HERTZCHAIN_STORE=1 cargo test --release --test experiments stored_references -- --ignored",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::ARCH
    );
    let stored = Stored { provenance, scene: what(scene), start: number_of_start(scene).0, ends };
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/study/compare/stored");
    let text = serde_json::to_string(&stored).unwrap() + "\n";
    std::fs::write(folder.join(format!("{}.json", scene.name())), text).unwrap();
}
