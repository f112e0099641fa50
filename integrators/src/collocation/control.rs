//! How long windows are, how many nodes panels have, and when a window counts as solved.

use super::{
    block::{Goal, Verdict},
    layout::Cuts,
    sites::Site,
    solver::{MOST_NODES, NODES},
    system::ContactChain,
};
use crate::{clock::Twofold, error::Error};

/// How finely to work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Equal windows, without control of the error.
    Windows {
        /// How many.
        windows: u64,
        /// Nodes a panel: 4, 6, 8, 10 or 12.
        nodes: usize,
        /// Whether panels are cut where a contact of a neighbour begins or ends as well: that gives the order its full height.
        neighbours: bool,
    },
    /// The error at the end, relative to the size of the state, that local errors may add up to.
    Tolerance(f64),
}

/// A share `e` of the tolerance allows last terms of a series up to `(TAIL e)^POWER`: measured, on waves, impacts and random chains.
const TAIL: f64 = 4e3;
const POWER: f64 = 0.8;
/// The same where terms fall slowly, as of a force that nearly goes out: `SLOW_TAIL e`.
const SLOW_TAIL: f64 = 2e2;
/// Where panels feel an event: without control of the error, and with halvings to make good for what is felt beyond.
const NEAR: [f64; 2] = [0.75, 0.5];
/// The largest `f'(g) h^2` at first, and its range: shorter windows need fewer sweeps, longer ones have fewer panels.
const STIFFNESS: f64 = 0.04;
const STIFFNESSES: [f64; 2] = [0.02, 0.25];
/// A trial of longer or shorter windows changes `f'(g) h^2` by this factor.
const TRIAL: f64 = 1.25;
/// Sweeps that a good window takes.
const GOOD_SWEEPS: u64 = 5;
/// Share of the tolerance of a window that sweeps may leave undone.
const UNDONE: f64 = 1e-2;
/// What sweeps leave undone and what events are off by comes from one side: it adds up over windows, unlike roundings.
const BIAS: f64 = 1e-18;
/// A change that is rounding, in units of velocities, and last terms that are.
const ROUNDING: f64 = 1e-15;
const ROUNDED_TAIL: f64 = 1e-14;
/// Share of contacts whose panels may be halved before panels have more nodes, or windows become shorter.
const MOST_HALVED: f64 = 0.3;
/// Windows between two changes of the number of nodes, and two trials of their length.
const PATIENCE: u32 = 16;
/// Two nodes less cost the last terms about this factor.
const TWO_NODES: f64 = 60.0;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    pace: Pace,
    nodes: usize,
    /// Fewer were too few.
    least_nodes: usize,
    /// Windows since the number of nodes was changed, and the largest last terms in them in units of those allowed.
    since: u32,
    tail: f64,
    /// The largest `f'(g) h^2`, and the factor of the last trial.
    stiffness: f64,
    trial: f64,
    /// Windows, their length and work since that trial, and what a unit of time cost before it.
    tried: u32,
    time: f64,
    work: f64,
    cost: f64,
    /// The length to try next.
    h: f64,
    /// The longest window given up since the last good one; zero if none.
    given_up: f64,
    /// Equal windows: their length, and what is left of the one at hand.
    equal: f64,
    rest: f64,
    span: f64,
    /// Size of velocities.
    size: f64,
    done: u64,
    /// Running mean of the share of contacts whose panels were halved.
    halved: f64,
    /// Whether the end is reached.
    finished: bool,
    alpha: f64,
}

/// Whether a force of this exponent is analytic in the square root of time from an event.
fn analytic(alpha: f64) -> bool {
    (2.0 * alpha).fract() == 0.0
}

fn rule(name: &'static str, value: f64, rule: &'static str) -> Error {
    Error::Argument { name, value, rule }
}

impl Control {
    pub(crate) fn new<C: ContactChain>(
        chain: &C,
        sites: &[Site],
        pace: Pace,
        span: Twofold<f64>,
    ) -> Result<Self, Error> {
        let law = chain.law();
        let omega = chain.response().omega.value();
        let mut size = 0.0f64;
        for site in sites {
            size = size.max(site.hi[1].abs() + omega * site.hi[2].hypot(site.hi[3]));
        }
        let reach = sites.iter().fold(0.0f64, |far, site| far.max(site.hi[0].abs() + site.hi[2].hypot(site.hi[3])));
        let stiffness = law.stiffness(chain.rest() + 2.0 * reach);
        for b in 0..chain.bonds() {
            let [r, _, c, _] = chain.across(b, |i| sites[i].hi);
            let now = chain.rest() + r + c;
            if now > 0.0 {
                size = size.max((2.0 * law.force(now) * now).sqrt());
            }
        }
        let size = if size > 0.0 { size } else { 1.0 };
        let (nodes, h) = match pace {
            Pace::Windows { windows, nodes, .. } => {
                if windows == 0 {
                    return Err(rule("windows", 0.0, "at least one window"));
                }
                if !NODES.contains(&nodes) {
                    return Err(rule("nodes", nodes as f64, "4, 6, 8, 10 or 12"));
                }
                (nodes, span.over(Twofold::new(windows as f64)).value())
            }
            Pace::Tolerance(tol) => {
                if !(1e-15..=0.1).contains(&tol) {
                    return Err(rule("tol", tol, "from 1e-15 to 0.1"));
                }
                let nodes = match tol {
                    1e-3.. => 4,
                    1e-5.. => 6,
                    1e-6.. => 8,
                    1e-8.. => 10,
                    _ => 12,
                };
                let rate = stiffness.sqrt().max(omega.min(1e3)).max(1.0 / span.value());
                (nodes, 0.3 / rate)
            }
        };
        let h = h.min(span.value());
        Ok(Self {
            pace,
            nodes,
            // Where no variable makes the force analytic, its last terms tell less.
            least_nodes: if analytic(law.alpha()) { 4 } else { nodes },
            since: 0,
            tail: 0.0,
            stiffness: STIFFNESS,
            trial: TRIAL,
            tried: 0,
            time: 0.0,
            work: 0.0,
            cost: f64::INFINITY,
            h,
            given_up: 0.0,
            equal: h,
            rest: h,
            span: span.value(),
            size,
            done: 0,
            halved: 0.0,
            finished: span.value() <= 0.0,
            alpha: law.alpha(),
        })
    }

    pub(crate) fn nodes(&self) -> usize {
        self.nodes
    }

    pub(crate) fn done(&self) -> bool {
        self.finished
    }

    /// The next window, when so much time is left.
    pub(crate) fn propose(&self, left: f64) -> f64 {
        match self.pace {
            Pace::Windows { .. } => self.h.min(self.rest),
            // The last windows share what is left.
            Pace::Tolerance(_) if left <= self.h => left,
            Pace::Tolerance(_) => self.h.min(0.5 * left),
        }
    }

    pub(crate) fn goal(&self, h: f64) -> Goal {
        let (share, change, tail, slow) = match self.pace {
            // All that sweeps can do.
            Pace::Windows { .. } => (f64::INFINITY, 0.0, f64::INFINITY, 1.0),
            Pace::Tolerance(tol) => {
                let share = tol * (h / self.span).max(1e-6);
                let tail = (TAIL * share).powf(POWER).max(ROUNDED_TAIL);
                (share, UNDONE * share, tail, (tail / (SLOW_TAIL * share)).max(1.0))
            }
        };
        let least = change.max(if let Pace::Windows { .. } = self.pace { 0.1 * ROUNDING } else { BIAS });
        let lost = |power: f64| h * least.powf(1.0 / power);
        Goal {
            change: change.max(BIAS) * self.size,
            rounded: 0.1 * ROUNDING * self.size,
            tail: tail * self.size,
            slow,
            felt: share * self.size,
            cuts: Cuts {
                neighbours: !matches!(self.pace, Pace::Windows { neighbours: false, .. }),
                merge: lost(self.alpha + 3.0),
                near: match self.pace {
                    Pace::Tolerance(_) if analytic(self.alpha) => NEAR[1],
                    _ => NEAR[0],
                },
                missed: 0.1 * least * self.size,
                unfelt: (0.1 * least * self.size / h).powf(1.0 / self.alpha),
                frozen_beside: lost(self.alpha + 3.0),
            },
        }
    }

    /// A window of this verdict is done; `last` if it reached the end.
    pub(crate) fn accept(&mut self, verdict: &Verdict, h: f64, last: bool) {
        match self.pace {
            Pace::Windows { windows, .. } => {
                self.rest -= h;
                if self.rest <= 1e-9 * self.equal {
                    self.done += 1;
                    (self.h, self.rest) = (self.equal, self.equal);
                }
                self.finished = self.done == windows;
            }
            Pace::Tolerance(_) => {
                self.finished = last;
                // One bond in trouble for a moment says little about the windows after it.
                self.h = self.h.max(0.9 * self.given_up);
                self.given_up = 0.0;
                let halved = verdict.halved as f64 / verdict.touching.max(1) as f64;
                self.halved += 0.2 * (halved - self.halved);
                self.try_lengths(verdict, h);
                self.choose_nodes(verdict.tail);
                let halved = self.halved;
                self.h *= if verdict.touching == 0 {
                    2.0
                } else if verdict.sweeps > GOOD_SWEEPS || halved > MOST_HALVED {
                    0.9
                } else if halved < 0.5 * MOST_HALVED {
                    1.06
                } else {
                    1.0
                };
                // Sweeps are to contract.
                if verdict.stiffness > 0.0 {
                    self.h = self.h.min(h * (self.stiffness / verdict.stiffness).sqrt());
                }
            }
        }
    }

    /// Longer or shorter windows, whichever way the work for a unit of time went down.
    fn try_lengths(&mut self, verdict: &Verdict, h: f64) {
        self.tried += 1;
        self.time += h;
        self.work += verdict.work as f64;
        if self.tried == PATIENCE {
            let cost = self.work / self.time;
            if cost > self.cost {
                self.trial = self.trial.recip();
            }
            self.stiffness = (self.stiffness * self.trial).clamp(STIFFNESSES[0], STIFFNESSES[1]);
            (self.tried, self.time, self.work, self.cost) = (0, 0.0, 0.0, cost);
        }
    }

    /// More nodes where panels are halved, fewer where the last terms are far below what is allowed.
    fn choose_nodes(&mut self, tail: f64) {
        self.since += 1;
        self.tail = self.tail.max(tail);
        let nodes = if self.since < PATIENCE {
            return;
        } else if self.halved > MOST_HALVED && self.nodes < MOST_NODES {
            self.least_nodes = self.nodes + 2;
            self.least_nodes
        } else if self.tail * TWO_NODES < 1.0 && self.nodes > self.least_nodes {
            self.nodes - 2
        } else {
            self.nodes
        };
        if nodes != self.nodes {
            (self.nodes, self.halved) = (nodes, 0.0);
        }
        (self.since, self.tail) = (0, 0.0);
    }

    /// A window of length `h` was given up: whether a shorter one may be tried.
    pub(crate) fn reject(&mut self, h: f64) -> bool {
        self.given_up = self.given_up.max(h);
        self.h = 0.5 * h;
        self.h > 1e-13 * self.span
    }
}
