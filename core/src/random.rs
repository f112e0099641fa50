//! Pseudo-random numbers from a seed, the same on every machine.

/// Pseudo-random numbers, uniform in [-1, 1), by splitmix64.
pub fn uniform(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::uniform;

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
}
