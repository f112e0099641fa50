//! The package by itself: kernels, flows, and runs on several threads or side by side.

mod chain;
mod contacts;
mod details;
mod kicks;
mod numbers;
mod parts;
mod runs;
mod theory;

use hertzchain_integrators::{DoubleDouble, Instructions, SplitFlow};
use std::sync::{Mutex, PoisonError};

/// Calls `test` with every instruction set of this machine, once it is chosen. A choice holds for
/// all threads, so that one test at a time makes it; the set that was used before comes back.
fn on_every_set(test: impl FnMut(Instructions)) {
    static ONE: Mutex<()> = Mutex::new(());
    let _alone = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let used = Instructions::used();
    Instructions::ALL.into_iter().filter(|set| set.select()).for_each(test);
    assert!(used.select());
}

/// The bits of a state after kicks, each followed by its drift, in rows of so many, and after the
/// same kicks one at a time.
fn both_ways<F: SplitFlow<f64>>(
    mut flow: F,
    y: &[f64],
    pairs: &[(f64, DoubleDouble<f64>)],
    row: usize,
) -> [Vec<u64>; 2] {
    flow.load(y);
    let mut other = flow.duplicate();
    pairs.chunks(row).for_each(|row| flow.kick_drifts(row));
    pairs.iter().for_each(|&(kick, drift)| other.kick_drift(kick, drift));
    [&flow, &other].map(|flow| bits(flow, y))
}

/// The bits of the state of a flow, as long as `y`.
fn bits(flow: &impl SplitFlow<f64>, y: &[f64]) -> Vec<u64> {
    let mut state = y.to_vec();
    flow.store(&mut state);
    state.into_iter().map(f64::to_bits).collect()
}
