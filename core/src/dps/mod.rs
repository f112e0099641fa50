//! The modulation (DpS) equations of small oscillations.
//!
//! Averages that couple amplitudes `A_n` and mean strains `B_n`, the flows, their standing waves,
//! and the maps to the chain and back.

mod ansatz;
mod dark;
mod flow;
mod homoclinic;
pub(crate) mod hypergeometric;
mod integrals;

pub use ansatz::{Ansatz, Envelope, first_order, project};
pub use dark::DarkProfile;
pub use flow::{Constraint, Dps, Ends, Form, Layout};
pub use homoclinic::{Center, Homoclinic};
pub use hypergeometric::per_gamma;
pub use integrals::{Averages, Values};
