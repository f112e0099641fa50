//! Periodic orbits of a chain: shooting, Floquet multipliers, continuation (Sec. 7); orbits of
//! driven, damped chains under the stroboscopic map are in `driven`, those of conservative chains
//! that begin as linear modes in `normal_modes`.
//!
//! | symbol | meaning |
//! |---|---|
//! | `Z = (x, y)` | strains: the state is `(Z, Z')`, and `Z'(0) = 0` |
//! | `T, omega_b` | period and frequency, `T = 2 pi/omega_b` |
//! | `M(t)` | derivative of the state at `t` by the state at 0; `M(T)` is the monodromy matrix |
//! | `lambda, tau` | multipliers, and `(lambda + 1/lambda)/2` |
//! | `R` | time reversal, `diag(1, -1)` on `(Z, Z')` |

pub(crate) mod arclength;
mod bands;
mod bifurcation;
pub(crate) mod branch;
mod chord;
mod continuation;
mod driven;
mod driven_branch;
pub(crate) mod eigen;
mod file;
mod floquet;
mod flow;
mod linear_modes;
mod normal_modes;
mod orbit;
mod response;
mod setting;
mod shooting;
mod switching;
mod touching;

pub use arclength::{End, MOST_CORRECTIONS, Range, Solution, check};
pub use bands::Bands;
pub use bifurcation::CriticalPair;
pub use branch::{AnalysisLevel, At, BifurcationKind, Located, Point, Problem, Spectra};
pub use continuation::{Continuation, OrbitMeasures};
pub use driven::{
    DriveParameter, DrivenMultiplier, DrivenOrbit, DrivenSetting, DrivenShooting, DrivenSpectrum, returns,
};
pub use driven_branch::{DrivenContinuation, DrivenCritical, DrivenMeasures, DrivenPoint};
pub use eigen::{Eigenpair, eigen, hessenberg};
pub use file::Pick;
pub use floquet::{Frame, Kind, Multiplier, Quality, Spectrum, known, or_nan};
pub use flow::flow;
pub use linear_modes::{LinearMode, NormalModes};
pub use normal_modes::{ModeContinuation, ModeMeasures, ModeOrbit};
pub use orbit::Extent;
pub use response::Response;
pub use setting::{Parameter, Setting};
pub use shooting::{Equations, Formulation, NewtonStep, Orbit, Shooting, least_squares};

/// A branch; where no problem is named, of orbits of a conservative ring.
pub type Branch<P = Continuation> = branch::Branch<P>;
/// A bifurcation of a branch; where no problem is named, of orbits of a conservative ring.
pub type Bifurcation<P = Continuation> = branch::Bifurcation<P>;
/// An orbit of a conservative ring with its multipliers.
pub type OrbitPoint = Point<Continuation>;
/// A branch of driven orbits.
pub type DrivenBranch = Branch<DrivenContinuation>;
/// A branch of normal modes.
pub type ModeBranch = Branch<ModeContinuation>;
