//! Numbers: lines and planes through points, pseudo-random numbers; and texts of errors.

use hertzchain_core::{
    Error,
    error::{GIVEN, NOTHING, beside},
    numerics::{fit_line, fit_plane, leading},
    random::uniform,
};

#[test]
fn of_values_that_are_equal_but_for_roundings_the_first_leads() {
    assert_eq!(leading([0.5, 1.0 - 1e-12, 1.0].into_iter()), Some(1));
    assert_eq!(leading([0.5, 1.0 - 1e-3, 1.0].into_iter()), Some(2));
    assert_eq!(leading(std::iter::empty()), None);
}

#[test]
fn a_line_is_fitted_and_a_bend_is_seen() {
    let line: Vec<_> = (0..4).map(|i| (f64::from(i), 2.5 * f64::from(i) - 7.0)).collect();
    let (slope, residual) = fit_line(&line).unwrap();
    assert!((slope - 2.5).abs() < 1e-14 && residual < 1e-14);
    let bend = fit_line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 2.0)]).unwrap();
    assert!((bend.0 - 1.0).abs() < 1e-15 && (bend.1 - 2.0 / 3.0).abs() < 1e-15);
    assert!(fit_line(&[(1.0, 0.0)]).is_none());
}

#[test]
fn a_plane_is_fitted_a_bend_is_seen_and_a_line_refused() {
    let grid = || (0..9).map(|k| (f64::from(k / 3), f64::from(k % 3)));
    let plane: Vec<_> = grid().map(|(x, y)| [x, y, 2.0 - 0.5 * x + 3.0 * y]).collect();
    let ([c, p, q], residual) = fit_plane(&plane).unwrap();
    assert!([c - 2.0, p + 0.5, q - 3.0, residual].iter().all(|off| off.abs() < 1e-13));
    let bent: Vec<_> = grid().map(|(x, y)| [x, y, x * y]).collect();
    // The best plane of x y on this grid is x + y - 1, one off at the corners.
    assert!((fit_plane(&bent).unwrap().1 - 1.0).abs() < 1e-13);
    let line: Vec<_> = grid().map(|(x, _)| [x, 2.0 * x, x]).collect();
    assert!(fit_plane(&line).is_none() && fit_plane(&plane[..3]).is_none());
}

#[test]
fn a_text_of_the_user_is_no_absence() {
    for (value, said) in [
        (NOTHING.to_owned(), "stop is missing: a rule"),
        (format!("{NOTHING} (entry 2)"), "stop is missing (entry 2): a rule"),
        (GIVEN.to_owned(), "stop does not belong here: a rule"),
        (beside("rho"), "stop beside rho is not valid: a rule"),
        ("nothing > 0.5".to_owned(), "stop = nothing > 0.5 is not valid: a rule"),
        ("nothing".to_owned(), "stop = nothing is not valid: a rule"),
        ("given".to_owned(), "stop = given is not valid: a rule"),
        ("beside rho".to_owned(), "stop = beside rho is not valid: a rule"),
    ] {
        assert_eq!(Error::parameter("stop", value, "a rule").to_string(), said);
    }
}

#[test]
fn numbers_fill_the_interval_evenly_and_neighbouring_seeds_have_nothing_in_common() {
    let draw = |seed| {
        let mut next = uniform(seed);
        (0..10_000).map(|_| next()).collect::<Vec<f64>>()
    };
    let (first, second) = (draw(1), draw(2));
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / 1e4;
    // Four standard deviations of the means, which are 0.577, 0.298 and 0.333 over 100.
    assert!(mean(&mut first.iter().copied()).abs() < 0.024);
    assert!((mean(&mut first.iter().map(|x| x * x)) - 1.0 / 3.0).abs() < 0.012);
    assert!(mean(&mut first.iter().zip(&second).map(|(x, y)| x * y)).abs() < 0.014);
    assert!(first.iter().all(|x| x.abs() < 1.0));
}
