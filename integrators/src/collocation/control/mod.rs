//! The control of windows: what each is held to, how long the next one is, and how many nodes its
//! panels have.
//!
//! | part | what it decides |
//! |---|---|
//! | [`Accuracy`] | from the tolerance for the run, the [`Goal`] of one window |
//! | [`Lengths`] | the length of the next window |
//! | [`NodeChoice`] | the number of nodes a panel |

mod accuracy;
mod lengths;
mod nodes;

use super::{
    block::Verdict,
    goal::Goal,
    solver::NODES,
    system::{ContactChain, Links, Path},
};
use crate::{clock::Twofold, error::Error};
use accuracy::Accuracy;
use lengths::Lengths;
use nodes::NodeChoice;

/// How finely to work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Equal windows, without control of the error.
    Windows {
        /// How many.
        windows: u64,
        /// Nodes a panel: 4, 6, 8, 10 or 12.
        nodes: usize,
        /// Whether panels are cut where a contact of a neighbour begins or ends as well: that gives
        /// the order its full height.
        neighbours: bool,
    },
    /// The error at the end, relative to the size of the state, that local errors may add up to.
    Tolerance(f64),
}

/// Decides what windows are tried, and what they are held to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    accuracy: Accuracy,
    plan: Plan,
    /// Whether the end is reached.
    finished: bool,
}

/// Where the lengths of windows come from.
#[derive(Clone, Copy, Debug)]
enum Plan {
    Equal(Equal),
    Adapted(Adapted),
}

/// Equal windows. One that does not settle is done in parts.
#[derive(Clone, Copy, Debug)]
struct Equal {
    windows: u64,
    nodes: usize,
    /// Windows done, and the length of each.
    done: u64,
    length: f64,
    /// The length to try next, and what is left of the window at hand.
    h: f64,
    rest: f64,
}

/// Windows as long, and nodes as many, as they are cheapest.
#[derive(Clone, Copy, Debug)]
struct Adapted {
    lengths: Lengths,
    nodes: NodeChoice,
    /// Running mean of the share of contacts whose panels were halved.
    halved: f64,
}

/// Weight of the last window in the running mean of halved panels. Chosen, not measured.
const RECENT: f64 = 0.2;

fn rule(name: &'static str, value: f64, rule: &'static str) -> Error {
    Error::Argument { name, value, rule }
}

impl Control {
    /// For a chain whose sites have the paths `start` at first.
    pub(crate) fn new<const S: usize, C: ContactChain<S>>(
        chain: (&C, &Links<S>),
        start: &dyn Fn(usize) -> Path,
        pace: Pace,
        span: Twofold<f64>,
    ) -> Result<Self, Error> {
        let accuracy = Accuracy::new(chain, start, pace, span.value());
        let plan = match pace {
            Pace::Windows { windows, nodes, .. } => {
                if windows == 0 {
                    return Err(rule("windows", 0.0, "at least one window"));
                }
                if !NODES.contains(&nodes) {
                    return Err(rule("nodes", nodes as f64, "4, 6, 8, 10 or 12"));
                }
                let length = span.over(Twofold::new(windows as f64)).value().min(span.value());
                Plan::Equal(Equal { windows, nodes, done: 0, length, h: length, rest: length })
            }
            Pace::Tolerance(tol) => {
                if !(1e-15..=0.1).contains(&tol) {
                    return Err(rule("tol", tol, "from 1e-15 to 0.1"));
                }
                let lengths = Lengths::new(chain, start, span.value());
                let nodes = NodeChoice::new(tol, accuracy.contacts().analytic);
                Plan::Adapted(Adapted { lengths, nodes, halved: 0.0 })
            }
        };
        Ok(Self { accuracy, plan, finished: span.value() <= 0.0 })
    }

    pub(crate) fn nodes(&self) -> usize {
        match &self.plan {
            Plan::Equal(equal) => equal.nodes,
            Plan::Adapted(adapted) => adapted.nodes.count(),
        }
    }

    pub(crate) fn done(&self) -> bool {
        self.finished
    }

    /// The length of the next window, when so much time is left.
    pub(crate) fn propose(&self, left: f64) -> f64 {
        match &self.plan {
            Plan::Equal(equal) => equal.h.min(equal.rest),
            Plan::Adapted(adapted) => adapted.lengths.propose(left),
        }
    }

    /// What a window of length `h` is held to.
    pub(crate) fn goal(&self, h: f64) -> Goal {
        self.accuracy.goal(h)
    }

    /// A window of this verdict is done; `last` if it reached the end.
    pub(crate) fn accept(&mut self, verdict: &Verdict, h: f64, last: bool) {
        match &mut self.plan {
            Plan::Equal(equal) => self.finished = equal.accept(h),
            Plan::Adapted(adapted) => {
                adapted.accept(verdict, h);
                self.finished = last;
            }
        }
    }

    /// A window of length `h` was given up: whether a shorter one may be tried.
    pub(crate) fn reject(&mut self, h: f64) -> bool {
        let h = match &mut self.plan {
            Plan::Equal(equal) => {
                equal.h = 0.5 * h;
                equal.h
            }
            Plan::Adapted(adapted) => adapted.lengths.reject(h),
        };
        h > 1e-13 * self.accuracy.span()
    }
}

impl Equal {
    /// A window, or a part of one, is done. Returns whether it was the last.
    fn accept(&mut self, h: f64) -> bool {
        self.rest -= h;
        if self.rest <= 1e-9 * self.length {
            self.done += 1;
            (self.h, self.rest) = (self.length, self.length);
        }
        self.done == self.windows
    }
}

impl Adapted {
    fn accept(&mut self, verdict: &Verdict, h: f64) {
        let halved = verdict.halved as f64 / verdict.touching.max(1) as f64;
        self.halved += RECENT * (halved - self.halved);
        self.lengths.count(verdict, h);
        if self.nodes.choose(verdict.tail, self.halved) {
            self.halved = 0.0;
        }
        self.lengths.adapt(verdict, h, self.halved);
    }
}
