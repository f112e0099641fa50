//! Parts of the study of Theorem 1: laws, initial states, suprema, slopes.

use hertzchain::{
    chain::{Boundary, Chain, Params},
    internals::{SlopePoint, Start, limit, theorem_errors},
    study::{Bound, Initial, Norm, RhoLaw, Sampling, TheoremOptions},
};

#[test]
fn laws_are_read_as_they_are_written() {
    for (text, law) in [
        ("eps^-2(alpha-1)", RhoLaw::Heavy),
        ("eps^-(alpha-1)", RhoLaw::Light),
        ("1000", RhoLaw::Value(1e3)),
        ("inf", RhoLaw::Value(f64::INFINITY)),
    ] {
        assert_eq!(RhoLaw::named(text).unwrap(), law);
        assert_eq!(law.name(), text);
    }
    for text in ["eps^-3", "0", "-1", "nan", ""] {
        assert!(RhoLaw::named(text).unwrap_err().to_string().contains("eps^-(alpha-1)"), "{text}");
    }
    assert!((RhoLaw::Heavy.rho(1.5, 1e-2) / 100.0 - 1.0).abs() < 1e-14);
    assert!((RhoLaw::Light.rho(2.0, 1e-2) / 100.0 - 1.0).abs() < 1e-14);
}

// Truth: (condciu) and (condciv), with the equality sign in l_1 and the inequality in the
// others.
#[test]
fn departures_are_on_the_boundary_of_what_is_allowed() {
    let (epsilon, c_i, alpha): (f64, f64, f64) = (1e-3, 0.7, 1.5);
    let options = TheoremOptions { alpha, initial: Initial::Generic, c_i, seed: Some(5), ..TheoremOptions::default() };
    let start = Start::new(&options).unwrap();
    let chain = Chain::new(Params::new(alpha, 1.0, 1e3).unwrap(), Boundary::Free, start.sites()).unwrap();
    let state = start.state(&chain, epsilon, c_i).unwrap();
    let found = theorem_errors(chain.layout(), state.as_slice(), &start.amplitudes, epsilon, 0.0);
    for norm in Norm::ALL {
        for (k, power) in [alpha, alpha, 2.0 * alpha - 1.0].into_iter().enumerate() {
            let size = found[norm.index()].0[k] / epsilon.powf(power);
            let bound = if norm == Norm::One { (size / c_i - 1.0).abs() < 1e-12 } else { size < c_i };
            assert!(bound && size > 0.1 * c_i, "{norm:?} {k}: {size}");
        }
    }
}

/// Errors `epsilon^power (1 + c epsilon^{1/2})` at half decades from 0.1 on.
fn decades(power: f64, c: f64, count: i32, missed: f64) -> Vec<SlopePoint> {
    let epsilon = |k: i32| 10f64.powf(-1.0 - 0.5 * f64::from(k));
    let error = |epsilon: f64| epsilon.powf(power) * (1.0 + c * epsilon.sqrt());
    (0..count).map(|k| SlopePoint { epsilon: epsilon(k), error: error(epsilon(k)), missed }).collect()
}

fn at(points: &[SlopePoint]) -> Option<(f64, f64)> {
    limit(&TheoremOptions::default(), 1.5, points)
}

fn verdict(points: &[SlopePoint]) -> Bound {
    Bound::from(at(points))
}

// Truth: the law that the errors were made with.
#[test]
fn the_limit_is_that_of_the_law_and_the_verdict_follows_it() {
    for power in [1.0, 1.4, 1.5, 2.0] {
        let (s, d) = at(&decades(power, 3.0, 11, 1e-3)).unwrap();
        assert!((s + 1.5 - power).abs() < d && d < 0.015, "{power}: {s} {d}");
    }
    assert_eq!(verdict(&decades(1.5, 3.0, 11, 1e-3)), Bound::Bounded);
    assert_eq!(verdict(&decades(2.0, 3.0, 11, 1e-3)), Bound::Bounded);
    assert_eq!(verdict(&decades(1.4, 3.0, 11, 1e-3)), Bound::Violated);
    assert_eq!(verdict(&decades(1.0, 3.0, 11, 1e-3)), Bound::Violated);
}

#[test]
fn what_cannot_be_told_is_not_told() {
    // Too few, too large, between the two verdicts, too coarse, still on their way.
    assert_eq!(verdict(&decades(1.5, 3.0, 2, 0.0)), Bound::Undecided);
    assert_eq!(verdict(&decades(1.5, 0.0, 3, 0.0)), Bound::Undecided);
    assert_eq!(verdict(&decades(1.47, 1.0, 11, 1e-3)), Bound::Undecided);
    assert_eq!(verdict(&decades(1.5, 0.0, 11, 0.2)), Bound::Undecided);
    assert_eq!(verdict(&decades(1.5, -3.0, 6, 1e-3)), Bound::Undecided);
    assert_eq!(verdict(&[]), Bound::Undecided);
}

#[test]
fn norms_are_those_of_a_right_triangle() {
    let of = |norm: Norm| norm.of([3.0, 0.0, -4.0].into_iter());
    assert_eq!(Norm::ALL.map(of), [7.0, 5.0, 4.0]);
    assert!(Norm::ALL.iter().all(|norm| norm.of(std::iter::empty()).is_sign_positive()));
    assert_eq!(Norm::Two.of([3e-200, 4e-200].into_iter()), 5e-200);
}

#[test]
fn times_increase_from_zero_to_the_end() {
    let sampling = Sampling { points: 8, periods: 4, periods_per_slow_time: 2 };
    for (end, horizon, count) in [(0.3, 1.0, 5), (25.0, 1.0, 33), (26.0, 1.0, 36), (1e6, 1.0, 36), (1e6, 9.0, 18 * 9)] {
        let times = sampling.periods(end, horizon).concat();
        assert_eq!((times[0], times[times.len() - 1], times.len()), (0.0, end, count));
        assert!(times.is_sorted_by(|a, b| a < b), "{end} {horizon}: {times:?}");
    }
}
