//! The modulation (DpS) equations: so far the two integrals that travelling waves need.

mod integrals;

pub use integrals::{g_alpha, r_h_alpha};
