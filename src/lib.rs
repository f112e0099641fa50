//! Nonlinear waves in locally resonant Hertzian chains.
//!
//! Beads push each other only while in contact, with force (overlap)_+^alpha, and each may carry a
//! linear resonator (Liu, James, Kevrekidis, Vainchtein, *Nonlinear waves in a strongly nonlinear
//! resonant granular chain*; equation labels in this documentation are those of that paper).
//!
//! | module | contents |
//! |---|---|
//! | [`chain`] | parameters, boundary, contact law, energy, and the two splittings |
//! | [`dps`], [`waves`], [`breathers`] | theory and solution families |
//! | [`orbits`] | periodic orbits: shooting, Floquet multipliers, continuation |
//! | [`scene`] | named, complete set-ups, read from TOML; what their runs compute and leave out |
//! | [`run`] | a run: a chain, a state, a span, a method; the integrators by name |
//! | [`parts`] | one long chain in parts, which threads move |
//! | [`sweep`] | grids of independent points: threads, progress, a store that resumes |
//! | [`study`] | studies: their options, their computations, and their reports |
//! | [`report`] | results as values: facts, tables, pictures, and what they become |
//! | [`present`] | the HTML page of reports |
//! | [`paper`] | claims of the paper, and our numbers and figures for them |
//! | [`output`] | files, written whole or not at all, and text |
//! | `cli` | the command line (feature `cli`) |
//! | `figures` | pictures as PNG (feature `plot`) |
//! | [`interrupt`] | whether the process was asked to end |
//! | [`numerics`] | lines and planes through points, bisection, golden sections, extremes |
//! | [`plain`] | the loops that anybody would write, as a yardstick |
//! | [`error`] | the error type |

// All output goes through one place, which handles full disks and closed pipes.
#![warn(clippy::print_stdout, clippy::print_stderr)]

#[cfg(feature = "cli")]
pub mod cli;
mod memory;
pub mod paper;
pub mod scene;
pub mod study;
pub mod sweep;

pub use hertzchain_core::{chain, dps, error, interrupt, numerics, parts, plain, run};
pub use hertzchain_orbits::{breathers, orbits, waves};
#[cfg(feature = "plot")]
pub use hertzchain_report::figures;
pub use hertzchain_report::{output, present, report};

use hertzchain_core::random;
use hertzchain_report::{named, number};

pub use chain::{Boundary, Chain, Params, State};
pub use error::{Error, Result};
pub use hertzchain_integrators as integrators;
pub use run::{Method, Run, Setting, Trajectory};
pub use scene::Scene;

/// Kernels that are private otherwise, for the tests of this package: no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::{
        memory::{available, bytes, lacking},
        paper::{claims::read as read_claims, quantities::measure::distortion, verify::pair},
        study::{
            breathers::breather::falls_to,
            breathers::moving::kicked::{Local, passages},
            integrators::compare::{
                ladder::{Ladder, Refinement},
                reference::ReferenceState,
            },
            integrators::drift::{slope, spaced},
            orbits::segments::segments,
            run::contacts::{bond_columns, pulse_line},
            waves::modulation::unwrapped,
            waves::theorem::{
                slopes::{Point as SlopePoint, limit},
                start::Start,
                suprema::errors as theorem_errors,
            },
            waves::wave::{member, spread},
        },
    };
}

/// The example of the README, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The examples of the guide, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
struct Guide;
