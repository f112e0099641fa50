//! The number of nodes a panel.

use super::super::{
    rule::{MOST_NODES, NODES, NODES_APART},
    window::WindowOutcome,
};

/// Share of contacts whose panels may be halved before panels have more nodes, or windows become
/// shorter. Chosen, not measured.
pub(super) const MOST_HALVED: f64 = 0.3;
/// Windows between two changes of the number of nodes. Chosen, not measured.
const PATIENCE: u32 = 16;
/// Factor by which last terms are taken to grow with four nodes less, where all bonds are closed.
/// Those of a smooth force grow by `(4/h)^4 M!/(M - 4)!`, at least 7e6 for eight nodes and the
/// longest windows, `f'(g) h^2 = 1/4`.
const FEWER_NODES: f64 = 1e6;
/// The least tolerance for four nodes. Four resolve the linear motion of a closed chain to some
/// 1e-6 over a run, whatever the last terms of its small waves are. Measured.
const COARSE: f64 = 1e-5;
/// The least tolerance for fewer nodes. The series of tangent maps end later than those of the
/// solution: at 1e-12 with four nodes less a map was off by 58 tolerances, at 1e-10 by 3. Measured.
const FINE: f64 = 1e-10;
/// The fewest nodes for a smaller tolerance, and for a force that is not analytic in the panels'
/// variable. With fewer nodes the power `q` of that variable, 5 for `alpha = 1.2`, causes halved
/// panels and short windows. Chosen; `methods chains_at_rest_keep_loose_tolerances` holds the cost.
const LEAST: usize = 8;

/// Whether a force of this exponent is analytic in the square root of time from an event.
pub(super) fn analytic(alpha: f64) -> bool {
    (2.0 * alpha).fract() == 0.0
}

/// The number of nodes a panel: more where panels are often halved, fewer while all bonds are
/// closed and the last terms are far below those allowed.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeChoice {
    count: usize,
    /// The first choice, and the least number to choose: fewer have led to too many halvings.
    first: usize,
    least: usize,
    /// Number of windows since the last choice, and their largest last terms over those allowed.
    since: u32,
    tail: f64,
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
        let count = if analytic { count } else { count.max(LEAST) };
        let least = match tol {
            COARSE.. if analytic => NODES[0],
            FINE.. => LEAST.min(count),
            _ => count,
        };
        Self { count, first: count, least, since: 0, tail: 0.0 }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Takes a window and the mean share of contacts whose panels were halved; returns whether the
    /// number changed.
    pub(super) fn choose(&mut self, outcome: &WindowOutcome, halved: f64) -> bool {
        let before = self.count;
        self.since += 1;
        self.tail = self.tail.max(outcome.tail);
        if outcome.open > 0 {
            (self.tail, self.count) = (f64::INFINITY, self.count.max(self.first));
        }
        if self.since < PATIENCE {
            return self.count != before;
        }
        if halved > MOST_HALVED && self.count < MOST_NODES {
            self.count += NODES_APART;
            self.least = self.count;
        } else if self.tail * FEWER_NODES < 1.0 && self.count > self.least {
            self.count -= NODES_APART;
        }
        (self.since, self.tail) = (0, 0.0);
        self.count != before
    }
}
