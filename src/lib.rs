//! Nonlinear waves in locally resonant Hertzian chains.
//!
//! Beads push each other only while in contact, with force (overlap)_+^alpha, and each may carry a linear resonator
//! (Liu, James, Kevrekidis, Vainchtein, *Nonlinear waves in a strongly nonlinear resonant granular chain*; equation
//! labels in this documentation are those of that paper).
//!
//! | module | what it holds |
//! |---|---|
//! | [`chain`] | parameters, boundary, contact law, energy, and the two splittings |
//! | [`dps`], [`waves`], [`breathers`] | theory and solution families |
//! | [`orbits`] | periodic orbits: shooting, Floquet multipliers, continuation |
//! | [`scene`] | a named, complete set-up, read from TOML; what it needs and what it leaves out |
//! | [`run`] | the one door: a chain, a state, a span, a method; the integrators by name |
//! | [`sweep`] | grids of independent points: threads, progress, a store that resumes |
//! | [`study`] | what is asked of chains: options, work, and what people and machines read of it |
//! | [`present`] | rows and words as text |
//! | [`paper`] | what the paper says, our numbers and figures for it |
//! | [`output`] | files and text, written whole or not at all |
//! | `cli` | the command line (feature `cli`) |
//! | `figures` | every PNG (feature `plot`) |
//! | [`interrupt`] | whether the process was asked to end |
//! | [`error`] | the one error type |

pub mod breathers;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "plot")]
pub mod figures;
mod number;
pub mod orbits;
pub mod output;
pub mod paper;
pub mod present;
mod random;
pub mod scene;
pub mod study;
pub mod sweep;
pub mod waves;

pub use hertzchain_core::{chain, dps, error, interrupt, run};

pub use chain::{Boundary, Chain, Params, State};
pub use error::{Error, Result};
pub use hertzchain_integrators as integrators;
pub use run::{Method, Run, Setting, Trajectory};
pub use scene::Scene;

/// The example of the README, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The example of the guide, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
struct Guide;
