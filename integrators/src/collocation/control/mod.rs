//! The control of windows: the accuracy that each must reach, the length of the next one, and the
//! number of nodes a panel.
//!
//! | part | it computes |
//! |---|---|
//! | [`Accuracy`] | from the tolerance for the run, the [`Goal`] of one window |
//! | [`Lengths`] | the length of the next window |
//! | [`NodeChoice`] | the number of nodes a panel |

mod accuracy;
mod lengths;
mod nodes;

use super::{
    chain::{ContactChain, Path},
    goal::{Goal, StepControl},
    link::Links,
    rule::NODES,
    window::WindowOutcome,
};
use crate::{clock::DoubleDouble, error::Error, tolerance::Tolerance};
use accuracy::Accuracy;
use lengths::Lengths;
use nodes::NodeChoice;

/// Chooses the windows that are tried, and the accuracy that they must reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    accuracy: Accuracy,
    plan: Plan,
    /// Whether the end of the span is reached.
    finished: bool,
}

/// Where the lengths of windows come from.
#[derive(Clone, Copy, Debug)]
enum Plan {
    Equal(Equal),
    Adapted(Adapted),
}

/// Windows of equal length. A window that does not converge is done in shorter parts.
#[derive(Clone, Copy, Debug)]
struct Equal {
    windows: u64,
    nodes: usize,
    /// Number of windows done, and the length of each.
    done: u64,
    length: f64,
    /// The length to try next, and the time left in the current window.
    h: f64,
    rest: f64,
}

/// Windows whose length and number of nodes are those of least cost.
#[derive(Clone, Copy, Debug)]
struct Adapted {
    lengths: Lengths,
    nodes: NodeChoice,
    /// Running mean of the share of touching bonds whose panels were halved, from 0 to 1.
    halved: f64,
}

/// Weight of the last window in the running mean of halved panels. Chosen, not measured.
const RECENT: f64 = 0.2;

fn rule(name: &'static str, value: f64, rule: &'static str) -> Error {
    Error::Argument { name, value, rule }
}

impl Control {
    /// For a chain whose sites have the paths `start` at the beginning of the run.
    pub(crate) fn new<const S: usize, C: ContactChain<S>>(
        chain: (&C, &Links<S>),
        start: &dyn Fn(usize) -> Path,
        step_control: StepControl,
        span: DoubleDouble<f64>,
    ) -> Result<Self, Error> {
        let accuracy = Accuracy::new(chain, start, step_control, span.value());
        let plan = match step_control {
            StepControl::Windows { windows, nodes, .. } => {
                if windows == 0 {
                    return Err(rule("windows", 0.0, "at least one window"));
                }
                if !NODES.contains(&nodes) {
                    return Err(rule("nodes", nodes as f64, "4, 8 or 12"));
                }
                let length = span.over(DoubleDouble::new(windows as f64)).value().min(span.value());
                Plan::Equal(Equal { windows, nodes, done: 0, length, h: length, rest: length })
            }
            StepControl::Tolerance(tol) => {
                Tolerance::RUN.check(tol)?;
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

    /// The length of the next window, when the time `left` is left.
    pub(crate) fn propose(&self, left: f64) -> f64 {
        match &self.plan {
            Plan::Equal(equal) => equal.h.min(equal.rest),
            Plan::Adapted(adapted) => adapted.lengths.propose(left),
        }
    }

    /// The accuracy that a window of length `h` must reach.
    pub(crate) fn goal(&self, h: f64) -> Goal {
        self.accuracy.goal(h)
    }

    /// Takes note of a window that was solved; `last` if it reached the end of the span.
    pub(crate) fn accept(&mut self, outcome: &WindowOutcome, h: f64, last: bool) {
        match &mut self.plan {
            Plan::Equal(equal) => self.finished = equal.accept(h),
            Plan::Adapted(adapted) => {
                adapted.accept(outcome, h);
                self.finished = last;
            }
        }
    }

    /// Takes note of a window of length `h` that was given up. Returns whether a shorter one may be
    /// tried.
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
    /// Takes note of a window, or a part of one, that was solved. Returns whether it was the last.
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
    fn accept(&mut self, outcome: &WindowOutcome, h: f64) {
        let halved = outcome.halved as f64 / outcome.touching.max(1) as f64;
        self.halved += RECENT * (halved - self.halved);
        self.lengths.count(outcome, h);
        if self.nodes.choose(outcome, self.halved) {
            self.halved = 0.0;
        }
        self.lengths.adapt(outcome, h, self.halved);
    }
}
