//! Splits of a chain that can be moved in parts.

use super::Chain;
use hertzchain_integrators::{Real, SplitFlow};

/// The two ways to split the Hamiltonian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Kinetic energy and potential energy.
    Kinetic,
    /// Linear part, whose flow is exact, and contact potential.
    Linear,
}

/// A split of the chain that can be divided: the kick of a site depends on this site and its two
/// neighbours only, and the drift of a site on this site only.
///
/// Data that do not belong to a site, such as a phase, depend on durations alone. They are the same
/// in all parts that make the same kicks and drifts.
pub trait Divisible<R: Real>: SplitFlow<R> {
    /// The chain at rest.
    fn rest(chain: Chain<R>) -> Self;
    /// The arrays of the flow's variables, with one number for each site; empty for variables that
    /// the model does not have.
    fn columns(&mut self) -> [&mut [R]; 4];
    /// Sets the sites from `first` on to arrays `[u, v, u', v']` of their states, at time 0 of the
    /// flow; the arrays of resonators are used only where these move.
    fn read(&mut self, first: usize, arrays: [&[R]; 4]);
    /// Writes the states of the sites from `first` on, as many as the arrays are long.
    fn write(&self, first: usize, arrays: [&mut [R]; 4]);
}
