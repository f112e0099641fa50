//! The contact law, and the powers that sweeps are compiled for: those of the integrators.

pub use hertzchain_integrators::law::ContactLaw;
pub(crate) use hertzchain_integrators::{law::Power, vector::MOST_LANES as LANES, with_power};
