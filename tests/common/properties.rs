//! How properties draw their cases.

use proptest::test_runner::{Config, RngSeed};

/// So many cases, drawn from the seed in `HERTZCHAIN_SEED`, by default 1. With the same cases in
/// every run a failure is reproducible, and bounds can be twice what was measured. `.ci/nightly`
/// gives another seed each night and prints it.
pub(crate) fn properties(cases: u32) -> Config {
    let seed = std::env::var("HERTZCHAIN_SEED").map_or(1, |seed| seed.parse().expect("HERTZCHAIN_SEED: a number"));
    Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(seed), ..Config::default() }
}
