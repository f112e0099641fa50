//! Maps of time, and the powers of their variables.

use hertzchain_integrators::regularised::{TimeMap, common_power};

#[test]
fn the_four_maps_of_the_square_are_what_they_are_called() {
    let s = 0.3f64;
    for ((a, b), expected) in [((1, 1), s), ((2, 1), s * s), ((1, 2), 1.0 - 0.49), ((2, 2), s * s * (3.0 - 2.0 * s))] {
        let map = TimeMap::new(2.0, a, b);
        assert!((map.at(s) - 2.0 * expected).abs() < 1e-15, "{a} {b}");
        assert!((map.before_end(s) - 2.0 * (1.0 - expected)).abs() < 1e-15, "{a} {b}");
    }
}

#[test]
fn the_inverse_inverts_and_the_rate_is_the_derivative() {
    for (a, b) in [(1, 1), (2, 1), (1, 2), (2, 2), (5, 1), (1, 5), (5, 5), (7, 3), (8, 8), (8, 3)] {
        let map = TimeMap::new(0.7, a, b);
        // With powers 8 and 8, Newton's method alone ended at 1/2 for times in the middle.
        for tau in [1e-12, 1e-5, 0.01, 0.3, 0.32, 0.34, 0.35, 0.36, 0.38, 0.6, 0.7 - 1e-6, 0.7] {
            let sigma = map.inverse(tau);
            // A power of n has n roundings.
            let rounding = if a + b > 10 { 0.5 * f64::EPSILON * f64::from(a + b) } else { 4e-16 };
            assert!((map.at(sigma) - tau).abs() < rounding * 0.7, "{a} {b} {tau}: {}", map.at(sigma) - tau);
            let d = 1e-5 * sigma.min(1.0 - sigma);
            if d > 0.0 {
                let slope = (map.at(sigma + d) - map.at(sigma - d)) / (2.0 * d);
                assert!((slope / map.rate(sigma) - 1.0).abs() < 1e-6 + 2e-16 / (d * map.rate(sigma)), "{a} {b} {tau}");
            }
        }
    }
}

#[test]
fn the_power_follows_the_exponent() {
    for (alpha, q) in [(1.0, 1), (2.0, 1), (3.0, 1), (1.5, 2), (2.5, 2), (0.5, 2), (1.2, 4), (4.0 / 3.0, 3), (8.3, 1)] {
        assert_eq!(common_power(&[alpha], 8), q, "{alpha}");
    }
    // Irrational exponent: the second condition applies.
    assert_eq!(common_power(&[std::f64::consts::SQRT_2], 8), 4);
}
