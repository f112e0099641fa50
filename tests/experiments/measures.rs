//! What studies measure in series of numbers.

use hertzchain::{
    breathers::Norms,
    internals::{Local, falls_to, member, passages, segments, slope, spaced, spread, unwrapped},
    study::{BrightSample, Spread, XAndY},
};
use num_complex::Complex64;
use serde_json::json;
use std::{f64::consts::PI, ops::Range};

#[test]
fn arguments_go_on_where_they_would_jump() {
    let z: Vec<_> = (0..40).map(|k| Complex64::from_polar(2.0, -0.7 * f64::from(k))).collect();
    let turned = unwrapped(&z);
    assert!((turned[39] + 0.7 * 39.0).abs() < 1e-12 && turned[0] == 0.0);
}

#[test]
fn a_tenth_has_left_between_the_samples_that_say_so() {
    let sample = |t, share| BrightSample { t, share, norms: Norms::default(), participation: 1.0, energy: 1.0 };
    let samples = [sample(0.0, 1.0), sample(1.0, 0.95), sample(2.0, 0.85), sample(3.0, 0.99)];
    assert!((falls_to(&samples, 0.9).unwrap() - 1.5).abs() < 1e-14);
    assert_eq!(falls_to(&samples, 0.8), None);
}

#[test]
fn times_are_spaced_evenly_and_end_at_the_end() {
    let times = spaced(2.0, 2e4, 5);
    assert_eq!((times[0], times[4]), (2.0, 2e4));
    assert!(times.windows(2).all(|pair| (pair[1] / pair[0] - 10.0).abs() < 1e-12));
    assert_eq!(spaced(3.0, 3.0, 2), [3.0, 3.0]);
}

#[test]
fn slopes_are_of_the_last_two_decades() {
    let t = spaced(1.0, 1e4, 81);
    // Flat first, then like a random walk.
    let errors: Vec<f64> = t.iter().map(|t| 1e-15 * (t / 100.0).sqrt().max(1.0)).collect();
    assert!((slope(&t, &errors).unwrap() - 0.5).abs() < 1e-12);
    assert!(slope(&t, &vec![0.0; 81]).is_none());
    assert!(slope(&t[..39], &errors[..39]).is_none());
    assert!(slope(&t[..41], &errors[..41]).unwrap().abs() < 1e-12);
}

#[test]
fn a_segment_has_another_key_if_an_orbit_before_it_or_a_setting_differs() {
    let keys = |orbits: &[f64], setting: f64| segments(orbits, 4, &json!({ "to": setting }));
    let branch: Vec<f64> = (0..10).map(f64::from).collect();
    let all = keys(&branch, 1.0);
    let numbers: Vec<Range<usize>> = all.iter().map(|one| one.orbits.clone()).collect();
    assert_eq!(numbers, [0..4, 4..8, 8..10]);
    assert_eq!(keys(&branch, 1.0), all);
    // A longer branch has the same segments but for the last one.
    let longer: Vec<f64> = (0..11).map(f64::from).collect();
    assert_eq!(keys(&longer, 1.0)[..2], all[..2]);
    for (k, later) in [(0, 0), (3, 0), (4, 1), (9, 2)] {
        let mut other = branch.clone();
        other[k] = other[k].next_up();
        let same: Vec<bool> = keys(&other, 1.0).iter().zip(&all).map(|(a, b)| a == b).collect();
        assert_eq!(same, [0, 1, 2].map(|segment| segment < later));
    }
    assert!(keys(&branch, 1.0_f64.next_up()).iter().zip(&all).all(|(a, b)| a != b));
}

#[test]
fn quartiles_are_those_of_the_sorted_values() {
    let all = spread(vec![5.0, 1.0, 2.0, 4.0, 3.0]);
    assert_eq!(all, Spread { low: 1.0, lower: 2.0, median: 3.0, upper: 4.0, high: 5.0 });
    let even = spread(vec![4.0, 1.0]);
    assert_eq!((even.lower, even.median, even.upper), (1.75, 2.5, 3.25));
}

#[test]
fn growth_and_rate_are_those_of_an_exponential() {
    // 20 samples a period of 1, twenty periods, a fast oscillation that growth must not see.
    let t: Vec<f64> = (0..=400).map(|k| 0.05 * f64::from(k)).collect();
    let x: Vec<f64> = t.iter().map(|t| (0.1 * t).exp() * (2.0 * PI * t).cos().abs()).collect();
    let of = member(1, &t, 1.0, &XAndY { y: x.iter().map(|x| 3.0 * x).collect(), x });
    assert!((of.growth_x.unwrap() / 1.9f64.exp() - 1.0).abs() < 1e-12);
    assert!((of.growth_x.unwrap() / of.growth_y.unwrap() - 1.0).abs() < 1e-14);
    // Maxima of a period are where its end is.
    assert!((of.rate.unwrap() - 0.1).abs() < 1e-3 && of.rate_residual.unwrap() < 1e-2);
    assert!(member(1, &t[..39], 1.0, &XAndY { x: vec![1.0; 39], y: vec![1.0; 39] }).growth_x.is_none());
}

// Truth: a gap that is put where a given motion is.
#[test]
fn passages_of_a_given_motion_are_found_in_both_directions() {
    for sign in [1.0, -1.0] {
        let local: Vec<Local> = (0..400)
            .map(|m| {
                let t = f64::from(m);
                let position = 10.5 + sign * 0.01 * t * (1.0 + 1e-3 * t);
                let amplitudes = (0..21).map(|i| ((f64::from(i) - position) / 2.0).tanh().abs()).collect();
                Local { t, position, amplitudes }
            })
            .collect();
        let found = passages(&local);
        assert_eq!(found.len(), 5);
        assert_eq!(found[0].bond, sign as i64);
        for one in &found {
            let way = 0.01 * one.t * (1.0 + 1e-3 * one.t);
            assert!((way - sign * one.bond as f64).abs() < 1e-4);
            assert!((one.depth - 0.25_f64.tanh()).abs() < 1e-3, "{one:?}");
            let velocity = 0.01 * (1.0 + 2e-3 * one.t);
            assert!(one.velocity.is_none_or(|v| (v / velocity - 1.0).abs() < 0.02), "{one:?}");
        }
    }
}
