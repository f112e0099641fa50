//! Experiments: data in, data out; nothing is drawn or printed here.

mod compare;
mod run;

pub use compare::{CompareOptions, Comparison, Reference, Row, compare};
pub use run::{Outcome, Profile, Records, Sample, run};
