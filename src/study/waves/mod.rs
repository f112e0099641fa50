//! Studies of waves: modulated, exact, solitary; the theory of small amplitudes and its bounds.

pub(crate) mod dps;
pub(crate) mod evolve;
pub(crate) mod exact;
pub(crate) mod modulation;
pub(crate) mod solitary;
pub(crate) mod theorem;
pub(crate) mod wave;

pub use dps::*;
pub use evolve::*;
pub use exact::*;
pub use modulation::*;
pub use solitary::*;
pub use theorem::{
    Bound, Errors as TheoremErrors, Initial, Norm, RhoLaw, Sampling, TheoremOptions, TheoremRun, TheoremSlope,
    TheoremStudy, theorem,
};
pub use wave::*;
