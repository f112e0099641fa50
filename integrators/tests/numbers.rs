//! Numbers in twice the precision, rotations, and the law of contacts.

use approx::assert_relative_eq;
use hertzchain_integrators::{DoubleDouble, Rotation, law::ContactLaw, with_power};

#[test]
fn a_decimal_keeps_thirty_digits() {
    // Compares division with the decimal: two independent computations of 1/7.
    let one: DoubleDouble<f64> = DoubleDouble::new(1.0);
    let by_division = one.over(DoubleDouble::new(7.0));
    let by_decimal = DoubleDouble::decimal("0.142857142857142857142857142857142857");
    let gap = by_division - by_decimal;
    assert!(gap.hi.abs() < 1e-32, "{gap:?}");
    assert!(by_division.lo != 0.0);
}

#[test]
fn a_phase_of_a_million_turns_keeps_its_last_digit() {
    // sin(10^6 * 2 pi + 1) = sin 1.
    let phase = DoubleDouble::<f64>::two_pi() * DoubleDouble::new(1e6) + DoubleDouble::new(1.0);
    let (s, c) = phase.reduced(DoubleDouble::two_pi()).sin_cos();
    assert!((s - 1f64.sin()).abs() < 2e-16 && (c - 1f64.cos()).abs() < 2e-16);
}

#[test]
fn a_rotation_has_thirty_digits() {
    // Truth: sin 1 and cos 1 to 40 digits; angles that add up to whole turns.
    let one = Rotation::<f64>::by(DoubleDouble::new(1.0));
    let sin = DoubleDouble::decimal("0.8414709848078965066525023216302989996226");
    let cos = DoubleDouble::decimal("0.5403023058681397174009366074429766037323");
    assert!((one.sin - sin).hi.abs() < 1e-31 && (one.cos - cos).hi.abs() < 1e-31, "{one:?}");
    for turns in [3, 7, 64] {
        let part = Rotation::by(DoubleDouble::<f64>::two_pi().over(DoubleDouble::new(f64::from(turns))));
        let whole = (0..turns).fold(Rotation::none(), |whole, _| whole.then(&part));
        let gap = whole.cos - DoubleDouble::new(1.0);
        assert!(whole.sin.hi.abs() < 5e-31 && gap.hi.abs() < 5e-31, "{turns}: {whole:?}");
    }
}

#[test]
fn a_rotation_by_almost_an_angle_keeps_lengths() {
    // Truth: Taylor's series, and cos^2 + sin^2 = 1.
    for k in -31..=31 {
        let angle = DoubleDouble::<f64>::new(f64::from(k)).over(DoubleDouble::new(10.0));
        let (near, by) = (Rotation::near(angle), Rotation::by(angle));
        let length = near.sin * near.sin + near.cos * near.cos - DoubleDouble::new(1.0);
        assert!(length.hi.abs() < 1e-31, "{k}: {length:?}");
        assert!((near.sin - by.sin).hi.abs() < 2.3e-16 && (near.cos - by.cos).hi.abs() < 2.3e-16, "{k}");
    }
}

#[test]
fn the_square_root_squares_back() {
    let two = DoubleDouble::<f64>::new(2.0);
    let gap = two.sqrt() * two.sqrt() - two;
    assert!(gap.hi.abs() < 1e-30);
}

#[test]
fn every_path_is_the_power_and_its_derivative() {
    // Reference: powf and central differences.
    for alpha in [0.5, 1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 7.0] {
        let law = ContactLaw::<f64>::new(alpha);
        // Overlaps up to here count as zero.
        let band = 1e-250_f64.powf(1.0 / alpha).max(f64::MIN_POSITIVE);
        for g in [1e-6, 0.3, 1.0, 2.7] {
            assert_relative_eq!(law.force(g), g.powf(alpha), max_relative = 1e-14);
            let (force, slope) = law.force_with_slope(g);
            assert_relative_eq!(force, law.force(g), max_relative = 4e-15);
            assert_relative_eq!(slope, law.stiffness(g), max_relative = 4e-15);
            let d = 1e-5 * g;
            assert_relative_eq!(
                law.stiffness(g),
                (law.force(g + d) - law.force(g - d)) / (2.0 * d),
                max_relative = 2e-9
            );
            assert_relative_eq!(
                law.force(g),
                (law.potential(g + d) - law.potential(g - d)) / (2.0 * d),
                max_relative = 2e-9
            );
        }
        for g in [0.0, -1.0, f64::NEG_INFINITY, band] {
            assert_eq!((law.force(g), law.potential(g), law.stiffness(g)), (0.0, 0.0, 0.0));
            assert_eq!(law.force_with_slope(g), (0.0, 0.0));
        }
        // Loops for one power and for any give the same bits, with masks before or after roots.
        for g in [-1.0, 0.0, band, 1e-100, 0.3, 2.7] {
            assert_eq!(law.force_and_slope(law.any_power(), g), law.force_with_slope(g));
            assert_eq!(with_power!(law, power => law.force_by(power, g)), law.force(g));
            assert_eq!(with_power!(law, power => law.force_and_slope(power, g)), law.force_with_slope(g));
        }
    }
}
