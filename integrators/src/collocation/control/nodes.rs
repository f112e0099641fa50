//! The number of nodes a panel.

use super::super::rule::{MOST_NODES, NODES_APART};

/// Share of contacts whose panels may be halved before panels have more nodes, or windows become
/// shorter. Chosen, not measured.
pub(super) const MOST_HALVED: f64 = 0.3;
/// Windows between two changes of the number of nodes. Chosen, not measured.
const PATIENCE: u32 = 16;
/// The fewest nodes for a force that is not analytic in the panels' variable. With fewer nodes the
/// power `q` of the variable, 5 for `alpha = 1.2`, causes halved panels and short windows. Chosen;
/// `methods chains_at_rest_keep_loose_tolerances` holds the cost.
const LEAST: usize = 8;

/// Whether a force of this exponent is analytic in the square root of time from an event.
pub(super) fn analytic(alpha: f64) -> bool {
    (2.0 * alpha).fract() == 0.0
}

/// The number of nodes a panel: more where panels are often halved.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeChoice {
    count: usize,
    /// Number of windows since the last choice.
    since: u32,
}

impl NodeChoice {
    /// The first choice, for a tolerance and forces that are [`analytic`] or not. Chosen: with
    /// these numbers the errors of several scenes are reached in the least time.
    pub(super) fn new(tol: f64, analytic: bool) -> Self {
        let count = match tol {
            1e-3.. => 4,
            1e-6.. => 8,
            _ => MOST_NODES,
        };
        // The last terms say less about a force that is not analytic.
        Self { count: if analytic { count } else { count.max(LEAST) }, since: 0 }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Takes the mean share of contacts whose panels were halved in a window; returns whether the
    /// number changed.
    pub(super) fn choose(&mut self, halved: f64) -> bool {
        self.since += 1;
        if self.since < PATIENCE {
            return false;
        }
        self.since = 0;
        let more = halved > MOST_HALVED && self.count < MOST_NODES;
        self.count += if more { NODES_APART } else { 0 };
        more
    }
}
