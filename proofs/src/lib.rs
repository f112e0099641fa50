//! Existence of periodic travelling waves and dark breathers, proved by the computer.
//!
//! | module | what it is |
//! |---|---|
//! | [`interval`] | intervals with bounds in doubles, rounded outward, and elementary functions |
//! | [`exact`] | parameters as exact fractions |
//! | [`certificate`] | what is to be proved, with a cosine sum near the solution, as a text |
//! | [`check`] | the checker, which proves or refuses a certificate |
//! | [`solve`] | Newton's method in doubles, which makes certificates; nothing rests on it |
//!
//! The theorems, their proofs and constants are in `README.md` of this package. [`check`] uses none
//! of [`solve`].

pub mod certificate;
pub mod check;
pub mod exact;
pub mod interval;
pub mod solve;

/// Kernels that are private otherwise, for the tests of this package: no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::check::{
        RUNG,
        block::{Block, Place, dot, product, weight},
        bounds::{Terms, b},
        infinite::Far,
        moments::{NARROWEST_ALONG, NODES, Sums, fejer},
        multiplier::{Equations, Factors, Terms as Perturbed, check as multipliers},
        radii,
        system::System,
    };
}
