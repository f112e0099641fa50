//! The modulation (DpS) equations of small oscillations: the averages that couple amplitudes `A_n` and mean strains `B_n`, and their flows.

mod flow;
mod hypergeometric;
mod integrals;

pub use flow::{Constraint, Dps, Ends, Form, Layout};
pub use integrals::{Averages, Values};
