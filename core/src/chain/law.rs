//! The contact law of the integrators, and the powers that sweeps are compiled for.

pub use hertzchain_integrators::law::ContactLaw;
pub(crate) use hertzchain_integrators::{law::Power, vector::MOST_LANES as LANES, with_hertz};
