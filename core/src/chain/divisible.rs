//! What a chain in parts asks of a split.

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

/// A split of the chain that can be divided: a kick of a site depends on this site and its two
/// neighbours, and a drift on nothing but the site.
///
/// What does not belong to a site, such as a phase, depends on durations alone. So it is the same
/// in all parts that make the same kicks and drifts.
pub trait Divisible<R: Real>: SplitFlow<R> {
    /// The chain at rest.
    fn rest(chain: Chain<R>) -> Self;
    /// The variables of the flow, a number a site in each; empty where the model has none.
    fn columns(&mut self) -> [&mut [R]; 4];
    /// Sets the sites from `first` on to arrays `[u, v, u', v']` of their states, at time 0 of the
    /// flow; those of resonators count only where these move.
    fn read(&mut self, first: usize, arrays: [&[R]; 4]);
    /// Writes the states of the sites from `first` on, as many as the arrays are long.
    fn write(&self, first: usize, arrays: [&mut [R]; 4]);
}
