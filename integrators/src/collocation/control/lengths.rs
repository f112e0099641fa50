//! The length of the next window.

use super::super::{
    chain::{ContactChain, Path, swing},
    link::Links,
    window::WindowOutcome,
};
use super::nodes::MOST_HALVED;

/// The largest `f'(g) h^2/m` of a window at the start of a run, and its range: shorter windows need
/// fewer sweeps, longer ones have fewer panels. Chosen; runs adapt it to the cost of their windows,
/// and `benches/collocation.rs` times such runs.
const STIFFNESS: f64 = 0.04;
const STIFFNESSES: [f64; 2] = [0.02, 0.25];
/// A trial of longer or shorter windows changes `f'(g) h^2` by this factor. Chosen, not measured.
const TRIAL: f64 = 1.25;
/// Windows between two trials. Chosen, not measured.
const PATIENCE: u32 = 16;
/// Windows become shorter if they need more sweeps than this. Chosen, not measured.
const GOOD_SWEEPS: u64 = 5;
/// Length of the first window, as a share of the shortest time scale. Chosen, not measured.
const FIRST: f64 = 0.3;
/// Frequency of resonators above which they do not shorten the first window further. Chosen, not
/// measured.
const FASTEST: f64 = 1e3;

/// The length of the next window.
///
/// It grows while windows converge in few sweeps and few panels are halved, and shrinks otherwise.
/// The stiffness `f'(g) h^2/m` is limited to a value that is moved towards least cost, so that
/// sweeps contract.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lengths {
    /// The length to try next.
    h: f64,
    /// Length of the longest window given up since the last one that was solved; zero if none.
    given_up: f64,
    stiffness: Stiffness,
}

/// A search for the `f'(g) h^2/m` at which a unit of time costs least. It goes up or down as long
/// as the cost falls, and changes its direction when the cost rises.
#[derive(Clone, Copy, Debug)]
struct Stiffness {
    /// The largest `f'(g) h^2/m` allowed.
    value: f64,
    /// The factor of the last trial: [`TRIAL`] or its reciprocal.
    trial: f64,
    /// Number of windows since the last trial, the sum of their lengths and of their work.
    windows: u32,
    time: f64,
    work: f64,
    /// Work for a unit of time before the last trial.
    cost: f64,
}

impl Lengths {
    pub(super) fn new<const S: usize, C: ContactChain<S>>(
        (chain, links): (&C, &Links<S>),
        start: &dyn Fn(usize) -> Path,
        span: f64,
    ) -> Self {
        let reach = (0..chain.sites()).fold(0.0f64, |far, i| {
            let [r, _, c, s] = start(i);
            far.max(r.abs() + c.hypot(s * swing(chain.response(i).omega.value() * span)))
        });
        let kinds = |all: usize| if S == 1 { 1 } else { all };
        let stiffness = |b: usize| links.link(b).stiffness(chain.bond(b).rest + 2.0 * reach) * links.link(b).lightest();
        let stiffness = (0..kinds(chain.bonds())).map(stiffness).fold(0.0, f64::max);
        let omega = (0..kinds(chain.sites())).map(|i| chain.response(i).omega.value()).fold(0.0, f64::max);
        let rate = stiffness.sqrt().max(omega.min(FASTEST)).max(1.0 / span);
        Self { h: (FIRST / rate).min(span), given_up: 0.0, stiffness: Stiffness::new() }
    }

    pub(super) fn propose(&self, left: f64) -> f64 {
        // The last two windows have equal lengths.
        if left <= self.h { left } else { self.h.min(0.5 * left) }
    }

    /// Takes note of a window that was given up; returns the length to try instead.
    pub(super) fn reject(&mut self, h: f64) -> f64 {
        self.given_up = self.given_up.max(h);
        self.h = 0.5 * h;
        self.h
    }

    /// Counts the work of a window that was solved.
    pub(super) fn count(&mut self, outcome: &WindowOutcome, h: f64) {
        // A window that is given up for one bond says little about the windows after it.
        self.h = self.h.max(0.9 * self.given_up);
        self.given_up = 0.0;
        self.stiffness.count(outcome, h);
    }

    /// Chooses the next length after a window of length `h`, with the mean share of contacts whose
    /// panels were halved.
    pub(super) fn adapt(&mut self, outcome: &WindowOutcome, h: f64, halved: f64) {
        self.h *= if outcome.touching == 0 {
            2.0
        } else if outcome.sweeps > GOOD_SWEEPS || halved > MOST_HALVED {
            0.9
        } else if halved < 0.5 * MOST_HALVED {
            1.06
        } else {
            1.0
        };
        // The limit of the stiffness makes sweeps contract.
        if outcome.stiffness > 0.0 {
            self.h = self.h.min(h * (self.stiffness.value / outcome.stiffness).sqrt());
        }
    }
}

impl Stiffness {
    fn new() -> Self {
        Self { value: STIFFNESS, trial: TRIAL, windows: 0, time: 0.0, work: 0.0, cost: f64::INFINITY }
    }

    fn count(&mut self, outcome: &WindowOutcome, h: f64) {
        self.windows += 1;
        self.time += h;
        self.work += outcome.work as f64;
        if self.windows == PATIENCE {
            let cost = self.work / self.time;
            if cost > self.cost {
                self.trial = self.trial.recip();
            }
            self.value = (self.value * self.trial).clamp(STIFFNESSES[0], STIFFNESSES[1]);
            (self.windows, self.time, self.work, self.cost) = (0, 0.0, 0.0, cost);
        }
    }
}
