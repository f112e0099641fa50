//! The state of sites, as exact linear paths, in sums that keep their rounding errors.

use super::{
    chain::{ContactChain, Path, swing},
    flow::Flow,
    link::Links,
    open::{Open, Signals},
    prescribed::Prescribed,
};
use crate::clock::DoubleDouble;
use std::{cell::Cell, collections::HashMap, sync::Arc};

/// `[R0, V, C, S]` of a site, each as the unevaluated sum of `hi` and `lo`: `q = R0 + V t +
/// C cos theta + S sin theta`. The time `t` counts from the start of the window; in the phase
/// `theta = omega t` time counts from the start of the run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Site {
    pub(crate) hi: Path,
    pub(crate) lo: Path,
}

impl Site {
    /// Adds to one entry; the rounding goes to `lo`.
    #[inline(always)]
    fn add(&mut self, k: usize, value: f64) {
        let sum = self.hi[k] + value;
        let part = sum - self.hi[k];
        let error = (self.hi[k] - (sum - part)) + (value - part);
        self.hi[k] = sum;
        self.lo[k] += error;
    }

    /// Whether the site rests at the origin.
    #[inline(always)]
    pub(crate) fn at_rest(&self) -> bool {
        self.hi == [0.0; 4] && self.lo == [0.0; 4]
    }

    /// Adds to all entries.
    #[inline(always)]
    pub(crate) fn take(&mut self, by: &Path) {
        for k in 0..4 {
            self.add(k, by[k]);
        }
    }

    /// Moves the site over a window of length `h`, which starts in phase `(sin, cos)`; `path` is
    /// the path by the impulses in the window.
    #[inline(always)]
    pub(crate) fn advance(&mut self, path: &Path, h: f64, (sin, cos): (f64, f64)) {
        self.take(&[path[0], path[1], path[2] * cos - path[3] * sin, path[2] * sin + path[3] * cos]);
        // V h, with its rounding error.
        let by = self.hi[1] * h;
        let rest = self.hi[1].mul_add(h, -by) + self.lo[1] * h;
        self.add(0, by);
        self.lo[0] += rest;
    }

    /// Moves a damped site over a window of length `h`; `path` is the path by the impulses in the
    /// window.
    pub(crate) fn flow(&mut self, path: &Path, flow: &Flow, h: f64) {
        self.take(path);
        if !self.at_rest() {
            let moved = flow.moved(&self.path((0.0, 1.0)), h);
            self.take(&moved);
        }
    }

    /// The path over a window that starts in phase `(sin, cos)`.
    #[inline(always)]
    pub(crate) fn path(&self, (sin, cos): (f64, f64)) -> Path {
        let [r, v, c, s] = std::array::from_fn(|k| self.hi[k] + self.lo[k]);
        [r, v, c * cos + s * sin, s * cos - c * sin]
    }
}

/// The state of a chain at the start of a window.
pub(crate) struct Sites<'a, C, const S: usize> {
    pub(crate) chain: &'a C,
    pub(crate) sites: &'a [Site],
    pub(crate) phases: &'a Phases<S>,
    /// Damping and drives, if there are any, and what drives do in the current window.
    pub(crate) open: Option<(&'a Open, &'a Signals)>,
}

impl<C: ContactChain<S>, const S: usize> Sites<'_, C, S> {
    /// The path of an overlap over a window of length `h`, and a bound of its terms in the window.
    /// Both do not depend on a shift of the whole chain. The first side has the free motion of both
    /// sides, unless drag acts on one: then each side has its own velocity.
    #[inline(always)]
    pub(crate) fn overlap(&self, bond: usize, h: f64) -> ([Path; S], f64) {
        let Self { chain, sites, phases, open } = *self;
        let hi = chain.across(bond, |i| sites[i].hi);
        let lo = chain.across(bond, |i| sites[i].lo);
        let ends = chain.ends(bond);
        let (mut free_hi, mut free_lo) = ([hi[0][0], hi[0][1]], [lo[0][0], lo[0][1]]);
        for side in 1..S {
            for k in 0..2 {
                free_hi[k] += hi[side][k];
                free_lo[k] += lo[side][k];
            }
        }
        let (r, v) = (free_hi[0] + free_lo[0], free_hi[1] + free_lo[1]);
        let rest = chain.bond(bond).rest;
        let mut largest = rest.abs() + r.abs() + v.abs() * h;
        let mut path = [[0.0; 4]; S];
        for side in 0..S {
            let (c, s) = (hi[side][2] + lo[side][2], hi[side][3] + lo[side][3]);
            let (sin, cos) = ends[side].map_or((0.0, 1.0), |site| phases.sin_cos(site));
            let turn = ends[side].map_or(0.0, |site| chain.response(site).omega.value() * h);
            largest = largest + c.abs() + s.abs() * swing(sin.abs() + turn);
            path[side] = [0.0, 0.0, c * cos + s * sin, s * cos - c * sin];
        }
        (path[0][0], path[0][1]) = (rest + r, v);
        if S != 1
            && let Some((open, _)) = open
        {
            let lags = |site: usize| open.damped(site).is_some_and(|flow| flow.lags());
            if ends.into_iter().flatten().any(lags) {
                // Drag acts on the velocity of each side with its own coefficient.
                for side in 0..S {
                    path[side][1] = hi[side][1] + lo[side][1];
                }
            }
        }
        (path, largest)
    }

    /// The overlap of a bond at the start of a window and its rate, and a bound of the terms of the
    /// overlap.
    pub(crate) fn now(&self, links: &Links<S>, bond: usize) -> ([f64; 2], f64) {
        let (path, largest) = self.overlap(bond, 0.0);
        let known = self.known(bond).map_or([0.0; 2], |known| known.ends[0]);
        let overlap = path.iter().fold(0.0, |sum, [r, _, c, _]| sum + r + c) + known[0];
        let rates = path.iter().zip(&links.link(bond).sides).map(|(path, side)| path[1] + side.omega * path[3]);
        ([overlap, rates.sum::<f64>() + known[1]], largest)
    }
}

/// The bonds of a chain at the start of a window, for a solver that does not know the chain's type.
pub(crate) trait Bonds<const S: usize>: Sync {
    /// Whether the sites of a bond rest at the origin and are not driven.
    fn at_rest(&self, bond: usize) -> bool;
    /// The overlap of a bond in a window of length `h` without contact forces and drives.
    fn free(&self, bond: usize, h: f64) -> Free<S>;
    /// The part of the overlap of a bond that drives prescribe.
    fn known(&self, bond: usize) -> Option<Prescribed>;
    /// The path of a site in the window.
    fn site(&self, site: usize) -> Path;
    /// The signal of a site's drive, see [`ContactChain::signal`], at a time since the start of the
    /// window.
    fn signal(&self, site: usize, t: f64) -> [f64; 3];
}

/// An overlap in a window without contact forces and drives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Free<const S: usize> {
    /// The path of the overlap.
    pub(crate) path: [Path; S],
    /// Overlaps of at most this size are rounding.
    pub(crate) band: f64,
}

impl<C: ContactChain<S>, const S: usize> Bonds<S> for Sites<'_, C, S> {
    fn at_rest(&self, bond: usize) -> bool {
        let driven = |site: usize| self.open.is_some_and(|(open, _)| open.drive(site).is_some());
        if S != 1 && self.chain.ends(bond).into_iter().flatten().any(driven) {
            return false;
        }
        let resting = Cell::new(true);
        self.chain.across(bond, |i| {
            resting.set(resting.get() && self.sites[i].at_rest());
            [0.0; 4]
        });
        resting.get()
    }

    fn free(&self, bond: usize, h: f64) -> Free<S> {
        let (path, mut largest) = self.overlap(bond, h);
        if S != 1
            && self.open.is_some()
            && let Some(known) = self.known(bond)
        {
            largest += known.reach()[0];
        }
        Free { path, band: self.chain.dead_band(largest) }
    }

    fn known(&self, bond: usize) -> Option<Prescribed> {
        let (open, window) = self.open?;
        let of = |site: Option<usize>| Some(window.driven[open.drive(site?)?].known);
        let ends = self.chain.ends(bond);
        let (before, behind) = (of(ends[0]), of(ends[S - 1]).map(Prescribed::minus));
        match (before, behind) {
            (Some(before), Some(behind)) => Some(before.plus(behind)),
            (before, behind) => before.or(behind),
        }
    }

    fn site(&self, site: usize) -> Path {
        self.sites[site].path(self.phases.sin_cos(site))
    }

    fn signal(&self, site: usize, t: f64) -> [f64; 3] {
        self.chain.signal(site, self.open.map_or(0.0, |(_, window)| window.start) + t)
    }
}

/// The phase `theta = omega t` of sites with one frequency, in twice the working precision.
#[derive(Clone, Copy, Debug)]
struct Phase {
    omega: DoubleDouble<f64>,
    theta: DoubleDouble<f64>,
    sin_cos: (f64, f64),
}

/// The phases `omega t` of all sites: one for each frequency.
#[derive(Clone, Debug)]
pub(crate) struct Phases<const S: usize> {
    list: Vec<Phase>,
    /// Index in `list` for each site; for `S = 1` all sites have the first.
    of: Arc<[u32]>,
    two_pi: DoubleDouble<f64>,
}

impl<const S: usize> Phases<S> {
    /// The phases of a chain at the start of a run, all zero.
    pub(crate) fn new<C: ContactChain<S>>(chain: &C) -> Self {
        let (mut list, mut known) = (Vec::new(), HashMap::new());
        let mut of = |site: usize| {
            // The state of a damped site is its path in the current window, without a phase.
            let turns = S == 1 || chain.damping(site) == [0.0; 2];
            let omega = if turns { chain.response(site).omega } else { DoubleDouble::zero() };
            *known.entry([omega.hi, omega.lo].map(f64::to_bits)).or_insert_with(|| {
                list.push(Phase { omega, theta: DoubleDouble::zero(), sin_cos: (0.0, 1.0) });
                list.len() as u32 - 1
            })
        };
        let of: Vec<u32> = (0..if S == 1 { 1 } else { chain.sites() }).map(&mut of).collect();
        Self { list, of: of.into(), two_pi: DoubleDouble::two_pi() }
    }

    pub(crate) fn advance(&mut self, h: f64) {
        for phase in &mut self.list {
            phase.theta = (phase.theta + phase.omega * DoubleDouble::new(h)).reduced(self.two_pi);
            phase.sin_cos = phase.theta.sin_cos();
        }
    }

    /// Sine and cosine of the phase of a site.
    #[inline(always)]
    pub(crate) fn sin_cos(&self, site: usize) -> (f64, f64) {
        self.list[if S == 1 { 0 } else { self.of[site] as usize }].sin_cos
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.list.copy_from_slice(&other.list);
    }
}
