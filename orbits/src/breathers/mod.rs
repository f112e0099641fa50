//! Breathers: trivial ones without contact force, long-lived bright ones, which are approximate,
//! and dark ones, which are exact, at rest and moving.

mod bright;
mod dark;
mod energy;
pub(crate) mod moving;
mod tail;
mod trivial;

pub use bright::{BrightBreather, Norms};
pub use dark::DarkBreather;
pub use energy::{KinkEnergy, background_energy};
pub use moving::centre;
pub use moving::{Envelope, MovingBreather, MovingOrbit};
pub use tail::{Band, LinearWave, LinearWaves, Tail};
pub use trivial::{ClosedForm, TrivialBreather};
