//! Integrators for Hamiltonian chains. The package itself contains no chain.
//!
//! | module | what it holds |
//! |---|---|
//! | [`instructions`] | the vector instructions of inner loops |
//! | [`real`] | the scalar type, `f64` or double-double; numbers side by side in a register |
//! | [`vector`] | the registers of `f64`, by instruction set |
//! | [`clock`] | times and coefficients to twice the working precision |
//! | [`law`] | the force of a bond as a power of its overlap |
//! | [`system`] | the interfaces between methods and problems |
//! | [`splitting`] | splitting schemes as const data, and the loop that runs them |
//! | [`dop853`] | the 8(5,3) pair of Dormand and Prince with 7th-order dense output |
//! | [`conserving`] | the discrete gradient, which conserves the energy exactly |
//! | [`events`] | changes of sign of functions of the state |
//! | [`regularised`] | DOP853 through events, in a variable in which the solution is smooth |
//! | [`drive`](mod@drive) | the loop over time: advance, record, stop |
//! | [`tolerance`](mod@tolerance) | the ranges of tolerances |
//! | [`stats`], [`error`] | counts of work; the error type |

pub mod clock;
pub mod collocation;
pub mod conserving;
pub mod dop853;
pub mod drive;
pub mod error;
pub mod events;
pub mod instructions;
pub mod interrupt;
pub mod law;
pub mod real;
pub mod regularised;
pub mod splitting;
pub mod stats;
pub mod system;
pub mod tolerance;
pub mod vector;

pub use clock::{DoubleDouble, Rotation};
pub use collocation::Collocation;
pub use dop853::Dop853;
pub use drive::{Observer, Silent, Stepper, Stop, drive};
pub use error::Error;
pub use events::{Event, EventFunctions, Watch};
pub use instructions::Instructions;
pub use real::{Kernel, Real, Vector};
pub use regularised::Regularised;
pub use splitting::{Scheme, Splitting};
pub use stats::Stats;
pub use system::{SplitFlow, VectorField};
pub use tolerance::Tolerance;
pub use vector::Column;

/// Kernels that are private otherwise, for the tests of this package: no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::{
        collocation::{flow::Flow, loss::solve},
        events::{
            bernstein::{Interpolation, Polynomial},
            sides::Sides,
        },
        splitting::corrected::{
            ends::{end_terms, nearest_zeros},
            event::Corrector,
            graze::{Extrema, Extremum},
            pack::Pack,
            path::{SERIES, oscillation},
        },
    };
}
