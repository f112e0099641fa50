//! A window to be solved, and the accuracy at which it counts as solved.

use super::layout::Cuts;

/// Largest last terms of a force that is resolved, as a share of its largest value. Measured with
/// `omega` from 0.01 to 10^4 times the frequency of contacts; `methods
/// resonators_much_faster_than_contacts_keep_loose_tolerances` measures the upper end again.
const RESOLVED: f64 = 0.3;

/// A window to be solved.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Length, a time.
    pub(crate) h: f64,
    /// Nodes a panel.
    pub(crate) nodes: usize,
    /// Whether to keep a [`Piece`](super::Piece) for each panel.
    pub(crate) log: bool,
    pub(crate) goal: Goal,
}

/// The accuracy at which a window counts as solved. Impulses are measured as changes of velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Sweeps end when the next one would change impulses by at most this.
    pub(crate) change: f64,
    /// Changes of an impulse up to this are rounding.
    pub(crate) rounded: f64,
    /// Largest last terms of the series of an impulse; infinite if panels are not to be halved.
    pub(crate) tail: f64,
    /// Factor, at least 1, on the last terms of a force that falls to almost nothing within a
    /// panel, since its series converges slowly.
    pub(crate) slow: f64,
    /// Impulses up to this are within the tolerance: their force need not be resolved.
    pub(crate) least_impulse: f64,
    /// Largest stiffness `f'(g) h^2/m` of a window; a window with more is given up. Infinite if the
    /// lengths of windows are given.
    pub(crate) stiffest: f64,
    pub(crate) cuts: Cuts,
}

impl Goal {
    /// The last terms of an impulse over those allowed, from the last terms and the largest value;
    /// above 1 the panel must be halved.
    ///
    /// It is not enough that last terms are small beside the velocities: where resonators are much
    /// faster than contacts, the impulse of each of many windows is small, and would have an error
    /// of the same sign in all of them.
    #[inline(always)]
    pub(super) fn excess(&self, [last, largest]: [f64; 2]) -> f64 {
        let [total, own] = [last / self.tail, last / (RESOLVED * largest)];
        if largest > self.least_impulse && own > total { own } else { total }
    }
}
