//! What makes certificates and chooses numbers for the checker. Nothing rests on it: the checker
//! shows what it needs of these numbers, whatever they are.
//!
//! | module | what it is |
//! |---|---|
//! | [`solve`] | Newton's method in doubles for the coefficients of cosine sums |
//! | [`modulations`] | pieces of Bloch wave numbers of perturbations of waves |
//! | `choices` | approximate inverses and solutions, and weights, that the checker uses |
//! | `read` | certificates read from texts, and limits of their sizes |
//! | `text` | reasons as a text; doubles as fractions |

pub(crate) mod choices;
pub mod modulations;
pub(crate) mod read;
pub mod solve;
pub(crate) mod text;

#[doc(hidden)]
pub use choices::{RUNG, matrix, rate};
