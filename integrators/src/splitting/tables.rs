//! The coefficients. Numbers only.

use super::scheme::{Coefficients, Scheme};

/// Strang's splitting: velocity Verlet when the drift is the kinetic energy and the kick comes first.
pub const STRANG: Scheme = Scheme {
    name: "strang",
    order: 2,
    source: "Strang 1968; Verlet 1967",
    coefficients: Coefficients::Composition(&[]),
};

/// All schemes, by order.
pub const ALL: &[Scheme] = &[STRANG];
