//! The levels that `compare` leaves out.

use hertzchain::{
    Method, Scene,
    internals::{Ladder, ReferenceState, Refinement},
    study::{Candidate, ErrorNorm, Row},
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
    let reference = ReferenceState::find(&scene, ErrorNorm::All, 1.0, &|_| ()).unwrap();
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
