//! Integrators on the chain. All tests are in one binary, so that generic code is compiled once.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/numbers.rs"]
mod numbers;
#[path = "../common/properties.rs"]
mod properties;

mod collocation;
mod collocation_at_rest;
mod collocation_cases;
mod conserving;
mod contact_times;
mod contacts;
mod corrected;
mod crossings;
mod details;
mod heterogeneous;
mod loads;
mod lossy;
mod lossy_random;
mod lossy_tangent;
mod main_job;
mod open;
mod order;
mod plain;
mod pulses;
mod run;
mod signals;
mod similarity;
mod splitting;
mod springs;
mod table;
mod tangent;
mod terms;
mod variations;
mod weak_springs;

/// Equal windows, with panels cut at events of neighbours.
fn windows(windows: u64, nodes: usize) -> hertzchain::integrators::collocation::StepControl {
    hertzchain::integrators::collocation::StepControl::Windows { windows, nodes, neighbours: true }
}
