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

impl Window {
    /// How many numbers say all of it.
    pub const NUMBERS: usize = 15;

    /// These numbers.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Self { h, nodes, log, goal } = *self;
        let Goal { change, rounded, tail, slow, least_impulse, stiffest, cuts } = goal;
        let Cuts { neighbours, merge, near, event_impulse, least_overlap, least_move_beside } = cuts;
        let [nodes, log, neighbours] = [nodes as f64, f64::from(u8::from(log)), f64::from(u8::from(neighbours))];
        let goal = [change, rounded, tail, slow, least_impulse, stiffest];
        let cuts = [neighbours, merge, near, event_impulse, least_overlap, least_move_beside];
        let mut numbers = [h; Self::NUMBERS];
        let all = [nodes, log].into_iter().chain(goal).chain(cuts);
        numbers[1..].iter_mut().zip(all).for_each(|(number, value)| *number = value);
        numbers
    }

    /// The window of these numbers.
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Self {
        let [h, nodes, log, change, rounded, tail, slow, least_impulse, stiffest, cuts @ ..] = *numbers;
        let [neighbours, merge, near, event_impulse, least_overlap, least_move_beside] = cuts;
        let neighbours = neighbours != 0.0;
        let cuts = Cuts { neighbours, merge, near, event_impulse, least_overlap, least_move_beside };
        let goal = Goal { change, rounded, tail, slow, least_impulse, stiffest, cuts };
        Self { h, nodes: nodes as usize, log: log != 0.0, goal }
    }
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
