//! The modulation (DpS) equations of small oscillations: the averages that couple amplitudes `A_n` and mean strains `B_n`.

mod hypergeometric;
mod integrals;

pub use integrals::{Averages, Values};
