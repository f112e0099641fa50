//! A window to be solved, and when it counts as solved.

use super::layout::Cuts;

/// Last terms of a force that is resolved at all, as a share of its largest value. Measured with
/// `omega` from 0.01 to 10^4 times the frequency of contacts; `methods
/// resonators_much_faster_than_contacts_keep_loose_tolerances` measures the upper end again.
const RESOLVED: f64 = 0.3;

/// A window to be solved.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Its length.
    pub(crate) h: f64,
    /// Nodes a panel.
    pub(crate) nodes: usize,
    /// Whether to keep what contacts do.
    pub(crate) log: bool,
    pub(crate) goal: Goal,
}

/// When a window counts as solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Largest change of an impulse that another sweep may make.
    pub(crate) change: f64,
    /// A change of an impulse up to this is rounding.
    pub(crate) rounded: f64,
    /// Largest last terms of the series of an impulse; infinite if panels are not to be halved.
    pub(crate) tail: f64,
    /// Factor on the last terms of a force that falls to almost nothing within a panel: its series
    /// falls slowly.
    pub(crate) slow: f64,
    /// Impulses up to this are within the tolerance: their force need not be resolved.
    pub(crate) least_impulse: f64,
    /// Largest `f'(g) h^2` of a window that may be solved; infinite if lengths are given.
    pub(crate) stiffest: f64,
    pub(crate) cuts: Cuts,
}

impl Goal {
    /// How many times larger the last terms of an impulse are than allowed, from them and its
    /// largest value.
    ///
    /// Last terms that are small beside the velocities are not enough: where resonators are much
    /// faster than contacts, the force moves little in any one of many windows, and would be wrong
    /// in all of them to the same side.
    #[inline(always)]
    pub(super) fn excess(&self, [last, largest]: [f64; 2]) -> f64 {
        let [total, own] = [last / self.tail, last / (RESOLVED * largest)];
        if largest > self.least_impulse && own > total { own } else { total }
    }
}
