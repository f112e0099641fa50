//! Functions of modulation theory.

use hertzchain_core::{
    dps::per_gamma,
    internals::{BasePoint, Hypergeometric, Parameters},
};
use std::f64::consts::PI;

#[test]
fn gamma_has_its_known_values() {
    for (x, gamma) in [(1.0, 1.0), (5.0, 24.0), (0.5, PI.sqrt()), (-0.5, -2.0 * PI.sqrt()), (11.0, 3_628_800.0)] {
        assert!((per_gamma(x) * gamma - 1.0).abs() < 4e-15, "{x}: {:e}", per_gamma(x) * gamma - 1.0);
    }
    assert_eq!((per_gamma(0.0), per_gamma(-3.0)), (0.0, 0.0));
}

#[test]
fn closed_forms_hold_up_to_the_singularity() {
    // F(1/2, 1; 3/2; w) = artanh(x)/x with w = x^2, p = 0 (a logarithm);
    // F(-1/2, b; b; w) = v^{1/2}.
    let of = |a: f64, b: f64, c: f64| Parameters { a, b, c, end: per_gamma(c - a) * per_gamma(c - b) };
    let log = Hypergeometric::new([of(0.5, 1.0, 1.5)], 0, 0.0);
    let root = Hypergeometric::new([of(-0.5, 1.3, 1.3)], 1, -0.5);
    let mut worst = [0f64; 2];
    for k in 0..600 {
        let v = 0.93f64.powi(k).min(1.0 - 1e-9);
        let w = 1.0 - v;
        let x = w.sqrt();
        let truth = [if w < 0.5 { x.atanh() } else { 0.5 * ((1.0 + x).powi(2) / v).ln() } / x, v.sqrt()];
        let got = [log.at(BasePoint::new(w, v, 0.0))[0], root.at(BasePoint::new(w, v, -0.5))[0]];
        for i in 0..2 {
            worst[i] = worst[i].max((got[i] / truth[i] - 1.0).abs());
        }
    }
    // Measured: 2.2e-15.
    assert!(worst[0] < 4.5e-15 && worst[1] < 4.5e-15, "{worst:?}");
    assert_eq!(log.at(BasePoint::new(1.0, 0.0, 0.0)), [f64::INFINITY]);
    assert_eq!(root.at(BasePoint::new(1.0, 0.0, -0.5)), [0.0]);
}
