//! The levels that `compare` leaves out, and the times that it compares.

use hertzchain::{
    Method, Scene,
    internals::{Ladder, ReferenceState, Refinement},
    plain::Loop,
    study::{Candidate, Comparison, ErrorNorm, Reference, Row},
};

/// A ladder with levels of these errors, each of which took as many seconds as its number.
fn ladder(name: &str, errors: &[f64]) -> Ladder {
    ladder_of(Candidate::Method(Method::named(name).unwrap()), errors)
}

fn ladder_of(candidate: Candidate, errors: &[f64]) -> Ladder {
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
    assert!(reason(10.0, &[0.1, 0.01]).unwrap().starts_with("beaten by corrected at "));
    assert!(reason(10.0, &[0.1, 0.1, 0.1, 0.01]).is_none(), "a slower one");
    // A level that costs next to nothing is never left out.
    assert!(reason(1e4, &[0.1, 0.01]).is_none());
}

#[test]
fn times_to_an_error_lie_between_settings_and_no_whole_setting_is_missed() {
    // Errors and times of powers: error = c / time^p, so that the time to an error is known. The second
    // row of the first ladder misses 1e-6 by 0.13 %: its next setting takes 1.5 times as long.
    let powers = |c: f64, p: i32| [1.0, 2.0, 3.0, 4.0].map(|wall: f64| c / wall.powi(p));
    let (c, plain) = (1.0013e-6 * 16.0, 9e-7 * 9.0);
    let mut ladders =
        vec![ladder("verlet", &powers(c, 4)), ladder_of(Candidate::Plain(Loop::VERLET), &powers(plain, 2))];
    let rows = |ladders: &[Ladder]| ladders.iter().flat_map(|ladder| ladder.rows.clone()).collect();
    let of = |rows| Comparison {
        scene: Scene::load("impact").unwrap(),
        norm: ErrorNorm::All,
        largest: [1.0; 3],
        opens: true,
        reference: Reference { method: String::new(), error_estimate: 0.0 },
        rows,
        stopped: Vec::new(),
        left_out: Vec::new(),
    };
    let comparison = of(rows(&ladders));
    let time = |plain: bool| comparison.fastest(1e-6, plain).unwrap().1;
    assert!((time(false) / (c / 1e-6).powf(0.25) - 1.0).abs() < 1e-12, "{}", time(false));
    assert!((time(true) / (plain / 1e-6).sqrt() - 1.0).abs() < 1e-12, "{}", time(true));
    // A finer setting that takes less time counts with its own.
    ladders[0].rows[3].wall = Some(0.5);
    assert_eq!(of(rows(&ladders)).fastest(1e-6, false).unwrap().1, 0.5);
    // Theory: order two; of a scheme of order four, what contacts leave.
    let order = |name: &str| comparison.order(&Candidate::Method(Method::named(name).unwrap()));
    assert_eq!(["verlet", "yoshida4", "corrected", "dop853"].map(order), [Some(2.0), Some(2.5), Some(4.0), None]);
}
