//! The step control that a user asks for, and the accuracy at which a window counts as solved.

use super::link::Link;

/// How the lengths of windows are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepControl {
    /// Windows of equal length, without control of the error.
    Windows {
        /// Number of windows in the span, at least 1.
        windows: u64,
        /// Nodes a panel: 4, 8 or 12.
        nodes: usize,
        /// Whether panels are also cut where a contact of a neighbour begins or ends; the full
        /// order needs these cuts.
        neighbours: bool,
    },
    /// Adaptive windows: a bound for the sum of local errors over the run, relative to the size of
    /// the state; from 1e-15 to 0.1.
    Tolerance(f64),
}

/// Largest last terms of a force that is resolved, as a share of its largest value. Measured with
/// `omega` from 0.01 to 10^4 times the frequency of contacts; `methods
/// resonators_much_faster_than_contacts_keep_loose_tolerances` measures the upper end again.
const RESOLVED: f64 = 0.3;

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
    /// The last terms of an impulse over those allowed, from the last terms, the largest value and
    /// the angle for a node; above 1 the panel must be halved.
    ///
    /// It is not enough that last terms are small beside the velocities: where resonators are much
    /// faster than contacts, the impulse of each of many windows is small, and would have an error
    /// of the same sign in all of them.
    #[inline(always)]
    pub(super) fn excess(&self, [last, largest, angle]: [f64; 3]) -> f64 {
        // The last terms of what is resolved also tell whether fewer nodes would do.
        let [total, own] = [last / self.tail, if angle > 1.0 { angle } else { last / (RESOLVED * largest) }];
        if largest > self.least_impulse && own > total { own } else { total }
    }
}

/// How contacts are cut into panels, and thresholds below which events and overlaps are negligible.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuts {
    /// Whether panels are also cut where a contact of a neighbour begins or ends.
    pub(crate) neighbours: bool,
    /// Shortest panel that a cut may leave, a time: a cut nearer to an end of the contact is left
    /// out. If an event moves by more than it, panels of the neighbours are laid out anew.
    pub(crate) merge: f64,
    /// Largest distance from a panel to an event at which the panel's variable has its origin, in
    /// lengths of the panel.
    pub(crate) near: f64,
    /// An event is not moved if this would change the impulse of its contact by at most this change
    /// of velocity.
    pub(crate) event_impulse: f64,
    /// Overlaps of at most this value count as zero.
    pub(crate) least_overlap: f64,
}

impl Cuts {
    /// Whether the error of an event is negligible. The event is off by a time `by` and an overlap;
    /// or, where it is an event of `P`, by a time and a value of `P`, while beads overlap by at
    /// most `deepest`, see `loss.rs`.
    #[inline(always)]
    pub(super) fn negligible<const S: usize>(
        &self,
        link: &Link<S>,
        overlap: f64,
        by: f64,
        deepest: Option<f64>,
    ) -> bool {
        let impulse = if link.lossy() {
            link.law.impulse_besides(overlap.abs(), by.abs(), deepest)
        } else {
            link.elastic_force(overlap.abs()) * by.abs()
        };
        self.negligible_impulse(link, impulse)
    }

    /// Whether an error of the impulse of a contact is negligible.
    #[inline(always)]
    pub(super) fn negligible_impulse<const S: usize>(&self, link: &Link<S>, impulse: f64) -> bool {
        impulse.abs() * link.lightest() <= self.event_impulse
    }
}
