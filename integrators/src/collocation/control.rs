//! How long windows are, how many nodes panels have, and when a window counts as solved.

use super::{
    block::{Goal, Verdict},
    bond::Cuts,
    sites::Site,
    system::{ContactChain, PairLaw},
};
use crate::{clock::Twofold, error::Error};

/// How finely to work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Equal windows, without control of the error.
    Windows {
        /// How many.
        windows: u64,
        /// Nodes a panel: even, from 4 to 16.
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
/// Share of a change that the next sweep may leave: windows are made short enough for that.
const MOST_SHARE: f64 = 0.08;
/// Sweeps that a good window takes.
const GOOD_SWEEPS: u64 = 5;
/// Share of the tolerance of a window that sweeps may leave undone; a tenth let single windows through that broke the tolerance.
const UNDONE: f64 = 3e-3;
/// A change that is rounding, in units of velocities, and last terms that are.
const ROUNDING: f64 = 1e-15;
const ROUNDED_TAIL: f64 = 1e-14;
/// Share of contacts whose panels may be halved before windows become shorter.
const MOST_HALVED: f64 = 0.3;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    pace: Pace,
    nodes: usize,
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
                if !(4..=16).contains(&nodes) || nodes % 2 == 1 {
                    return Err(rule("nodes", nodes as f64, "an even number from 4 to 16"));
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
                    1e-8.. => 8,
                    3e-11.. => 10,
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
            h,
            given_up: 0.0,
            equal: h,
            rest: h,
            span: span.value(),
            size,
            done: 0,
            halved: 0.0,
            finished: span.value() <= 0.0,
            alpha: law.exponent(),
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
        let (change, tail) = match self.pace {
            // All that sweeps can do.
            Pace::Windows { .. } => (0.1 * ROUNDING, f64::INFINITY),
            Pace::Tolerance(tol) => {
                let share = tol * (h / self.span).max(1e-6);
                ((UNDONE * share).max(ROUNDING), (TAIL * share).powf(POWER).max(ROUNDED_TAIL))
            }
        };
        let lost = |power: f64| h * change.max(ROUNDING).powf(1.0 / power);
        Goal {
            change: change * self.size,
            tail: tail * self.size,
            cuts: Cuts {
                neighbours: !matches!(self.pace, Pace::Windows { neighbours: false, .. }),
                merge: lost(self.alpha + 3.0),
                near: 0.75,
                missed: 0.1 * change * self.size,
                unfelt: (0.1 * change * self.size / h).powf(1.0 / self.alpha),
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
                // Sweeps must contract.
                if verdict.share > 0.0 {
                    self.h = self.h.min(h * (MOST_SHARE / verdict.share).sqrt());
                }
            }
        }
    }

    /// A window of length `h` was given up: whether a shorter one may be tried.
    pub(crate) fn reject(&mut self, h: f64) -> bool {
        self.given_up = self.given_up.max(h);
        self.h = 0.5 * h;
        self.h > 1e-13 * self.span
    }
}
