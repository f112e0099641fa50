//! Mean contact forces: the quantity of Theorem nobreath.
//!
//! | symbol | meaning |
//! |---|---|
//! | `Fbar_n` | mean force of bond `n`, to the left of site `n`: `1/T int_0^T (g_n)_+^alpha dt` |
//! | `p_n` | momentum of a site with its resonator, `u_n' + rho v_n'` |
//!
//! `p_n(T) - p_n(0) = T (Fbar_n - Fbar_{n+1})`, and so `Fbar_n` does not depend on `n` where the
//! motion has the period `T`. For a localised motion of this period it is zero.

use super::Chain;
use crate::error::Result;
use hertzchain_integrators::{Stepper, collocation::StepControl};

/// Mean contact forces over some time, of all bonds that can touch.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanForces {
    /// Index of the first of these bonds; it lies to the left of the site of the same index.
    pub first_bond: usize,
    /// `Fbar_n`, bond by bond.
    pub forces: Vec<f64>,
}

impl MeanForces {
    /// The mean over the bonds; zero if none can touch.
    pub fn mean(&self) -> f64 {
        self.forces.iter().sum::<f64>() / self.forces.len().max(1) as f64
    }

    /// The largest minus the smallest; zero if the time is a period of the motion.
    pub fn spread(&self) -> f64 {
        let (low, high) = self.range();
        high - low
    }

    /// The smallest and the largest; zeros if no bond can touch.
    pub fn range(&self) -> (f64, f64) {
        let range = self.forces.iter().fold((f64::INFINITY, 0.0f64), |(low, high), &f| (low.min(f), high.max(f)));
        if self.forces.is_empty() { (0.0, 0.0) } else { range }
    }
}

impl Chain<f64> {
    /// `Fbar_n` of the motion from the state `y` over a time `period` (Theorem nobreath): the
    /// impulses of contacts, by collocation, divided by this time.
    ///
    /// ```
    /// use hertzchain_core::{chain::{Boundary, Chain, Params, State}, integrators::collocation::StepControl};
    /// // At rest under an overlap of 1/4: Fbar = (1/4)^{3/2} in every bond.
    /// let chain = Chain::new(Params::new(1.5, 1.0, 1.0)?, Boundary::Ring, 5)?.precompressed(0.25)?;
    /// let forces = chain.mean_contact_forces(State::rest(&chain).as_slice(), 3.0, StepControl::Tolerance(1e-12))?;
    /// assert!((forces.mean() - 0.125).abs() < 1e-12 && forces.spread() < 1e-12);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// A state or a step control outside its rule, `period` not finite and positive, a run that
    /// fails.
    pub fn mean_contact_forces(&self, y: &[f64], period: f64, control: StepControl) -> Result<MeanForces> {
        let mut run = self.collocation(y, (0.0, period), control)?.logged();
        let bonds = self.touching();
        let mut forces = vec![0.0; bonds.len()];
        while !run.done() {
            run.step()?;
            for piece in run.pieces().1 {
                forces[piece.bond] += piece.impulse / period;
            }
        }
        Ok(MeanForces { first_bond: bonds.start, forces })
    }
}
