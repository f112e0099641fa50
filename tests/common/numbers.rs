//! Differences of numbers, and numbers that look random.
#![allow(dead_code, reason = "each binary of tests uses some of it")]

/// The largest size of some numbers; what is no number is the largest, and violates every bound.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a: f64, b| if a.is_nan() || b.abs() <= a { a } else { b.abs() })
}

pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    largest(a.iter().zip(b).map(|(a, b)| a - b))
}

/// The distance as a share of the largest of `b`.
pub(crate) fn error(a: &[f64], b: &[f64]) -> f64 {
    distance(a, b) / largest(b.iter().copied())
}

/// Numbers in [0, 1), the same in every run: splitmix64.
pub(crate) fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Numbers in [-1, 1).
pub(crate) fn random_signed(seed: u64) -> impl FnMut() -> f64 {
    let mut next = random(seed);
    move || 2.0 * next() - 1.0
}

/// A unit-sized vector without symmetries, another for each `k`.
pub(crate) fn direction(dim: usize, k: usize) -> Vec<f64> {
    (0..dim).map(|i| ((2.399_963 + 0.618 * k as f64) * i as f64 + 1.0).sin()).collect()
}

pub(crate) fn assert_below(value: f64, bound: f64, what: &str) {
    println!("{what}: {value:.2e}, bound {bound:.1e}");
    assert!(value <= bound, "{what}: {value:e} > {bound:e}");
}

/// One step of the classical method of Runge and Kutta; rates are asked for at shares of the step.
pub(crate) fn runge_kutta(y: &mut [f64], h: f64, rates: impl Fn(f64, &[f64]) -> Vec<f64>) {
    let after = |k: &[f64], by: f64| -> Vec<f64> { y.iter().zip(k).map(|(y, k)| y + by * k).collect() };
    let k1 = rates(0.0, y);
    let k2 = rates(0.5, &after(&k1, 0.5 * h));
    let k3 = rates(0.5, &after(&k2, 0.5 * h));
    let k4 = rates(1.0, &after(&k3, h));
    for (i, y) in y.iter_mut().enumerate() {
        *y += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
}

/// The state after one step where rates do not depend on time.
pub(crate) fn rk4(rates: &impl Fn(&[f64]) -> Vec<f64>, y: &[f64], h: f64) -> Vec<f64> {
    let mut y = y.to_vec();
    runge_kutta(&mut y, h, |_, y| rates(y));
    y
}
