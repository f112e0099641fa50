//! The number of nodes a panel.

use super::super::rule::{MOST_NODES, NODES, NODES_APART};

/// Share of contacts whose panels may be halved before panels have more nodes, or windows become
/// shorter. Chosen, not measured.
pub(super) const MOST_HALVED: f64 = 0.3;
/// Windows between two changes of the number of nodes. Chosen, not measured.
const PATIENCE: u32 = 16;
/// Factor by which last terms are assumed to grow with four nodes less. Chosen, not measured; too
/// small a value shows as windows given up in `methods hardly_a_window_is_given_up`.
const FEWER_NODES: f64 = 3600.0;

/// The fewest nodes for a force that is not analytic in the panels' variable. With fewer nodes the
/// power `q` of the variable, 5 for `alpha = 1.2`, causes halved panels and short windows. Chosen;
/// `methods chains_at_rest_keep_loose_tolerances` holds the cost.
const LEAST: usize = 8;

/// Whether a force of this exponent is analytic in the square root of time from an event.
pub(super) fn analytic(alpha: f64) -> bool {
    (2.0 * alpha).fract() == 0.0
}

/// The number of nodes a panel: more where panels are often halved, fewer where the last terms are
/// far below what is allowed.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeChoice {
    count: usize,
    /// The least number to choose: fewer have led to too many halvings.
    least: usize,
    /// Number of windows since the last choice, and their largest last terms over those allowed.
    since: u32,
    tail: f64,
}

impl NodeChoice {
    /// The first choice, for a tolerance and forces that are [`analytic`] or not: the number at
    /// which most runs end. Chosen, not measured.
    pub(super) fn new(tol: f64, analytic: bool) -> Self {
        let count: usize = match tol {
            1e-3.. => NODES[0],
            1e-7.. => NODES[1],
            _ => MOST_NODES,
        };
        // The last terms say less about a force that is not analytic.
        let (count, least) = if analytic { (count, NODES[0]) } else { (count.max(LEAST), count.max(LEAST)) };
        Self { count, least, since: 0, tail: 0.0 }
    }

    /// From now on never fewer nodes than now.
    pub(super) fn keep(&mut self) {
        self.least = self.count;
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Takes the last terms of a window and the mean share of contacts whose panels were halved;
    /// returns whether the number changed.
    pub(super) fn choose(&mut self, tail: f64, halved: f64) -> bool {
        self.since += 1;
        self.tail = self.tail.max(tail);
        let count = if self.since < PATIENCE {
            return false;
        } else if halved > MOST_HALVED && self.count < MOST_NODES {
            self.least = self.count + NODES_APART;
            self.least
        } else if self.tail * FEWER_NODES < 1.0 && self.count > self.least {
            self.count - NODES_APART
        } else {
            self.count
        };
        let changed = count != self.count;
        (self.count, self.since, self.tail) = (count, 0, 0.0);
        changed
    }
}
