//! How properties draw their cases.

use proptest::test_runner::{Config, RngSeed};

/// So many cases, the same ones in every run: a failure is reproducible, and bounds can be twice
/// what was measured. With `HERTZCHAIN_SEED`, which `.ci/nightly` sets and prints, there are four
/// times as many, drawn from that seed.
pub(crate) fn properties(cases: u32) -> Config {
    let night = std::env::var("HERTZCHAIN_SEED").ok().map(|seed| seed.parse().expect("HERTZCHAIN_SEED: a number"));
    let cases = if night.is_some() { 4 * cases } else { cases };
    Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(night.unwrap_or(1)), ..Config::default() }
}
