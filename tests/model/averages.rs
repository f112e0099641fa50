//! The averages of the modulation equations against 30-digit values and identities.

use crate::{numbers::random, properties::properties};
use hertzchain::dps::{Averages, Values};
use proptest::prelude::*;
use std::{fs, path::PathBuf};

/// Relative errors. Measured: 1.2e-14, and 6.9e-14 for `dh_dr` at `alpha = 0.001`, `s = -0.999`,
/// next to its zero.
const BOUNDS: [f64; 6] = [2.4e-14, 2.4e-14, 2.4e-14, 2.4e-14, 2.4e-14, 1e-13];
const NAMES: [&str; 6] = ["g", "h", "dg_db", "dg_dr", "dh_db", "dh_dr"];

fn array(v: &Values) -> [f64; 6] {
    [v.g, v.h, v.dg_db, v.dg_dr, v.dh_db, v.dh_dr]
}

/// The scale of each value. For a slope near its zero the scale is the integral without the cosine.
fn natural(v: &[f64; 6], kappa: f64, r: f64) -> [f64; 6] {
    let slope = v[2].abs();
    [v[0], v[1], slope, 2.0 * kappa * slope, slope / r, 2.0 * kappa * slope / r]
}

#[test]
fn values_agree_with_thirty_digits() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference/averages.csv");
    let text = fs::read_to_string(path).unwrap();
    let (mut worst, mut rows) = ([0f64; 6], 0);
    for line in text.lines().filter(|line| !line.starts_with(['#', 'a'])) {
        let numbers: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let ([alpha, kappa, b, r], want) =
            (numbers[..4].try_into().unwrap(), <[f64; 6]>::try_from(&numbers[4..]).unwrap());
        let averages = Averages::new(alpha, kappa).unwrap();
        let got = averages.values(b, r);
        let place = format!("alpha = {alpha}, kappa = {kappa}, b = {b:e}, r = {r:e}, s = {:e}", b / (2.0 * kappa * r));
        for (i, (got, want)) in array(&got).into_iter().zip(want).enumerate() {
            if want.is_normal() {
                let zero = natural(&<[f64; 6]>::try_from(&numbers[4..]).unwrap(), kappa, r)[i];
                let slack = if zero.is_finite() { 4e-16 * zero } else { 0.0 };
                let error = ((got - want).abs() - slack).max(0.0) / want.abs();
                worst[i] = worst[i].max(error);
                assert!(error <= BOUNDS[i], "{}: {place}: {got:e}, want {want:e}: {error:e}", NAMES[i]);
            } else if want != 0.0 && want.abs() < f64::MIN_POSITIVE {
                assert!(got.abs() < 2.0 * f64::MIN_POSITIVE, "{}: {place}: {got:e}", NAMES[i]);
            } else {
                let zero = natural(&<[f64; 6]>::try_from(&numbers[4..]).unwrap(), kappa, r)[i];
                assert!(
                    got == want || (want == 0.0 && got.abs() <= 4e-16 * zero),
                    "{}: {place}: {got:e}, want {want}",
                    NAMES[i]
                );
            }
        }
        let (g, rh) = averages.force(b, r);
        assert!(g == got.g || (g / got.g - 1.0).abs() < 2e-15, "{place}");
        if (rh.is_normal() && got.h.is_normal()) && (r * got.h).is_normal() {
            assert!((rh / (r * got.h) - 1.0).abs() < 1e-14, "{place}");
        }
        rows += 1;
    }
    println!("{rows} rows; largest relative errors {worst:?}");
    assert!(rows >= 378);
}

#[test]
fn slopes_are_the_averages_of_alpha_less_one() {
    for alpha in [1.2, 1.5, 2.0, 2.75, 4.0, 9.5] {
        let (kappa, r) = (0.6, 1.3);
        let (averages, less) = (Averages::new(alpha, kappa).unwrap(), Averages::new(alpha - 1.0, kappa).unwrap());
        for k in -60..20 {
            let b = 0.05 * f64::from(k) * 2.0 * kappa * r;
            let v = averages.values(b, r);
            let (g, rh) = less.force(b, r);
            // d/db = -alpha, the average of cos t gives d/dr, and the last is Euler's identity.
            for (got, want) in [
                (v.dg_db, -alpha * g),
                (v.drh_db, -alpha * rh),
                (v.dh_db, -alpha * rh / r),
                (v.dg_dr, 2.0 * kappa * alpha * rh),
            ] {
                // Measured: 1.3e-14.
                assert!((got - want).abs() <= 3e-14 * want.abs(), "alpha = {alpha}, b = {b}: {got:e}, {want:e}");
            }
            let parts = [b * v.dg_db, r * v.dg_dr, -alpha * v.g];
            let size: f64 = parts.iter().map(|part| part.abs()).sum();
            assert!(parts.iter().sum::<f64>().abs() <= 2e-14 * size);
            let parts = [v.h, r * v.dh_dr, -v.drh_dr];
            let size: f64 = parts.iter().map(|part| part.abs()).sum();
            assert!(parts.iter().sum::<f64>().abs() <= 2e-14 * size);
        }
    }
}

#[test]
fn mean_strain_inverts_g_everywhere() {
    let mut next = random(7);
    let (mut alikes, mut alike_total) = (0u64, 0u64);
    let (mut most, mut total, mut worst, mut count, mut searched) = (0, 0u64, 0f64, 0u64, 0u64);
    for _ in 0..100 {
        let alpha = if next() < 0.2 { 1.5 } else { 0.05 + 9.95 * next() * next() };
        let kappa = (8.0 * next() - 4.0).exp();
        let averages = Averages::new(alpha, kappa).unwrap();
        for _ in 0..1000 {
            let r = (40.0 * next() - 20.0).exp();
            // Extreme scales; half of the cases have scales of one size. s lies between -3 and 1.
            let (far, s) = ((60.0 * next() - 30.0).exp(), 4.0 * next() - 3.0);
            let alike = next() < 0.5;
            let c = if alike { averages.g(s * 2.0 * kappa * r, r) } else { far };
            let (b, steps) = averages.mean_strain_counted(c, r);
            let v = averages.values(b, r);
            // The attainable accuracy is one rounding of b or of the swing.
            let ulp = f64::EPSILON * (b.abs() + 2.0 * kappa * r);
            let lower = averages.g(b + 2.0 * ulp, r);
            let upper = averages.g(b - 2.0 * ulp, r);
            let near = lower <= c * (1.0 + 1e-13) && c * (1.0 - 1e-13) <= upper;
            assert!(
                near,
                "alpha = {alpha}, kappa = {kappa}, c = {c:e}, r = {r:e}: b = {b:e}, g = {:e}, {steps} steps",
                v.g
            );
            let conditioned = (v.g - c).abs() / (f64::EPSILON * (c + v.dg_db.abs() * (b.abs() + 2.0 * kappa * r)));
            if v.g > 0.0 && v.dg_db.is_finite() && ulp * v.dg_db.abs() < 1e-3 * c {
                worst = worst.max(conditioned);
            }
            (most, total, count) = (most.max(steps), total + u64::from(steps), count + 1);
            searched += u64::from(steps > 0);
            if alike {
                (alikes, alike_total) = (alikes + 1, alike_total + u64::from(steps));
            }
        }
    }
    let mean = total as f64 / searched as f64;
    println!("scales alike: {:.2} in the mean", alike_total as f64 / alikes as f64);
    println!(
        "{count} pairs, {searched} of them searched: at most {most} evaluations, {mean:.2} in the mean; |g(b) - c| at most {worst:.1} roundings"
    );
    // Measured: 44 and 3.3 (4.0 for scales alike); 3.8 roundings.
    assert!(most <= 88 && mean < 6.6, "{most}, {mean}");
    assert!(worst < 8.0, "{worst}");
}

#[test]
fn limits_of_the_mean_strain() {
    let averages = Averages::new(1.5, 0.7).unwrap();
    assert!((averages.mean_strain(8.0, 0.0) + 4.0).abs() < 2e-15);
    assert_eq!(averages.mean_strain(0.0, 2.0), 2.0 * 0.7 * 2.0);
    assert!(averages.mean_strain(-1.0, 1.0).is_nan() && averages.mean_strain(1.0, -1.0).is_nan());
    assert!(averages.mean_strain(f64::NAN, 1.0).is_nan());
}

#[test]
fn arguments_outside_their_rule() {
    let averages = Averages::new(1.5, 1.0).unwrap();
    for (b, r) in [(0.0, -1.0), (f64::NAN, 1.0), (0.0, f64::NAN), (-5.0, -1.0)] {
        assert!(averages.g(b, r).is_nan() && averages.r_h(b, r).is_nan());
        assert!(array(&averages.values(b, r)).iter().all(|x| x.is_nan()), "b = {b}, r = {r}");
        assert!(averages.checked(b, r).is_err());
    }
    for (alpha, kappa) in [(0.0, 1.0), (10.1, 1.0), (f64::NAN, 1.0), (1.5, 0.0), (1.5, -1.0), (1.5, f64::INFINITY)] {
        assert!(Averages::new(alpha, kappa).is_err(), "alpha = {alpha}, kappa = {kappa}");
    }
}

proptest! {
    #![proptest_config(properties(400))]

    #[test]
    fn g_and_r_h_are_homogeneous(alpha in 0.05..10.0f64, s in -4.0..1.0f64, k in -60..60i32) {
        let averages = Averages::new(alpha, 0.8).unwrap();
        let (b, scale) = (s * 1.6, f64::from(k).exp2());
        let ((g, rh), (far_g, far_rh)) = (averages.force(b, 1.0), averages.force(scale * b, scale));
        let factor = scale.powf(alpha);
        prop_assert!((far_g - factor * g).abs() <= 2e-13 * far_g && (far_rh - factor * rh).abs() <= 2e-13 * far_rh);
    }

    #[test]
    fn g_falls_with_b_and_grows_with_r(alpha in 0.05..10.0f64, s in -4.0..1.0f64, step in 1e-9..1.0f64) {
        let averages = Averages::new(alpha, 0.5).unwrap();
        let g = averages.g(s, 1.0);
        prop_assert!(averages.g(s - step, 1.0) > g);
        prop_assert!(averages.g(s + step, 1.0) < g || g == 0.0);
        // Convex powers only: the mean of a concave one decreases as the swing grows while the
        // contact stays closed.
        if alpha >= 1.0 + 1e-3 {
            prop_assert!(averages.g(s, 1.0 + step.max(1e-3)) > g);
        }
    }
}
