//! Tests of studies and orbits. They are one binary, so that generic code is compiled once.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/numbers.rs"]
mod numbers;
#[cfg(feature = "cli")]
#[path = "../common/program.rs"]
mod program;
#[path = "../common/properties.rs"]
mod properties;

mod bands;
mod barrier;
mod branch_files;
mod breathers;
mod charts;
mod claims;
mod driven;
mod exact_waves;
mod lifetimes;
mod measures;
mod moving;
mod nls;
mod normal_modes;
mod orbits;
mod references;
mod response;
mod solitary;
mod sweep;
mod switching;
mod theorem;
mod theorem_parts;
mod verify;
mod waves;
