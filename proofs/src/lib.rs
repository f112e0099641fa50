//! Existence of periodic travelling waves and dark breathers, proved by the computer.
//!
//! | module | what it is |
//! |---|---|
//! | [`interval`] | intervals with bounds in doubles, rounded outward, and elementary functions |
//! | [`exact`] | parameters as exact fractions |
//! | [`certificate`] | what is to be proved, with a cosine sum near the solution, read from a text |
//! | [`check`] | the checker, which proves or refuses a certificate |
//! | [`untrusted`] | what makes and reads certificates, and chooses numbers; nothing rests on it |
//!
//! The theorems, their proofs and constants are in `README.md` of this package. [`check`] relies on
//! nothing in [`untrusted`].

pub mod certificate;
pub mod check;
pub mod exact;
pub mod interval;
pub mod untrusted;

/// Kernels that are private otherwise, for the tests of this package: no part of its interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::{
        check::{
            bloch::check as bloch,
            existence::Terms,
            factors::{modulated, rated},
            further::Terms as Perturbed,
            infinite::Far,
            moments::{NARROWEST_ALONG, NODES, Sums, fejer},
            multiplier::{check as multipliers, g},
            newton::{Block, Derivative, Equations, radii},
            perturbed::Perturbations,
            system::System,
        },
        untrusted::{RUNG, matrix, rate},
    };
}
