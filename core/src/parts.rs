//! One long chain in parts, which threads move side by side by a splitting scheme.
//!
//! | word | meaning |
//! |---|---|
//! | *part* | neighbouring sites that one thread moves; together, the chain |
//! | *ghosts* | sites of both neighbours that a part moves as well |
//!
//! A kick of a site depends on the site and its two neighbours. So a part with `g` ghosts on either
//! side can make `g` kicks without its neighbours: each kick makes one more ghost wrong, from the
//! cut inwards, and after `g` kicks all sites of the part itself are still right. Then neighbouring
//! parts copy their outermost `g` sites to each other, in the variables of the flow.
//!
//! The results have the bits of a run in one part. A kernel does the same operations for a site at
//! any place of an array, and phase and time depend on durations alone.

use crate::{
    chain::{Chain, Divisible, Layout},
    error::{Result, require},
};
use hertzchain_integrators::{DoubleDouble, SplitFlow};
use std::{ops::Range, thread};

/// Most ghosts on either side of a part, and so most kicks from one exchange to the next. Chosen:
/// with a part of 10^5 sites they are a thousandth of the work.
pub const GHOSTS: usize = 64;
/// Kicks of so many sites, or more, are made by threads; fewer take less time than starting them.
/// Chosen.
const WORTH_A_THREAD: usize = 1 << 18;

/// A chain in parts, on one of its two splits. The bits are those of the flow `F` of the whole
/// chain, for any number of parts.
pub struct Parted<F> {
    layout: Layout,
    ring: bool,
    parts: Vec<Part<F>>,
    ghosts: usize,
    /// Number of further kicks for which the ghosts are valid.
    fresh: usize,
}

/// Refuses numbers of parts that a chain does not have.
///
/// # Errors
/// No part, or more parts than sites; several parts of a chain with
/// [`Details`](crate::chain::Details).
pub fn divides(chain: &Chain<f64>, count: usize) -> Result<()> {
    let rule = "by a splitting scheme at most as many threads as sites: ask for fewer";
    require((1..=chain.sites()).contains(&count), "threads", count, rule)?;
    let rule = "by a splitting scheme beads that differ, are damped or driven move on one: leave --threads out";
    require(count == 1 || chain.details().is_none(), "threads", count, rule)
}

struct Part<F> {
    flow: F,
    /// Number of ghosts on the left.
    left: usize,
    /// Its own sites, as the chain counts them.
    own: Range<usize>,
}

impl<F: Divisible<f64> + Send> Parted<F> {
    /// The chain at rest, in `count` parts of nearly the same length; load a state into it.
    ///
    /// # Panics
    /// Fewer than two parts; what [`divides`] refuses.
    pub fn new(chain: &Chain<f64>, count: usize) -> Self {
        let (sites, ring) = (chain.sites(), chain.topology().ring());
        assert!(count > 1 && divides(chain, count).is_ok(), "a chain in two parts or more");
        let ghosts = GHOSTS.min(sites / count);
        let start = |part: usize| (sites as u128 * part as u128 / count as u128) as usize;
        let part = |part: usize| {
            let (left, right) = (ring || part > 0, ring || part + 1 < count);
            let (own, [left, right]) =
                (start(part)..start(part + 1), [left, right].map(|cut| usize::from(cut) * ghosts));
            Part { flow: F::rest(chain.cut(left + own.len() + right)), left, own }
        };
        Self { layout: chain.layout(), ring, parts: (0..count).map(part).collect(), ghosts, fresh: 0 }
    }

    /// Copies the outermost sites of neighbouring parts to each other.
    fn exchange(&mut self) {
        let Self { ref mut parts, ghosts, ring, .. } = *self;
        for part in 0..parts.len() - usize::from(!ring) {
            let next = (part + 1) % parts.len();
            let [before, after] = parts.get_disjoint_mut([part, next]).expect("a chain in parts has two or more");
            let cut = before.left + before.own.len();
            let columns = before.flow.columns().into_iter().zip(after.flow.columns());
            for (one, other) in columns.filter(|(one, _)| !one.is_empty()) {
                other[..ghosts].copy_from_slice(&one[cut - ghosts..cut]);
                one[cut..][..ghosts].copy_from_slice(&other[after.left..][..ghosts]);
            }
        }
        self.fresh = ghosts;
    }

    /// Does the work of so many kicks in every part.
    fn each(&mut self, kicks: usize, work: impl Fn(&mut F) + Sync) {
        let (own, others) = self.parts.split_first_mut().expect("a chain in parts has two or more");
        if kicks * own.own.len() < WORTH_A_THREAD {
            work(&mut own.flow);
            return others.iter_mut().for_each(|part| work(&mut part.flow));
        }
        thread::scope(|scope| {
            for part in others {
                scope.spawn(|| work(&mut part.flow));
            }
            work(&mut own.flow);
        });
    }
}

impl<F: Divisible<f64> + Send> SplitFlow<f64> for Parted<F> {
    fn dim(&self) -> usize {
        self.layout.dim()
    }

    fn moved(&self) -> usize {
        self.layout.dim().div_ceil(self.parts.len())
    }

    fn load(&mut self, y: &[f64]) {
        let arrays = self.layout.arrays(y);
        for Part { flow, left, own } in &mut self.parts {
            flow.read(*left, arrays.map(|array| array.get(own.clone()).unwrap_or_default()));
        }
        self.fresh = 0;
    }

    fn store(&self, y: &mut [f64]) {
        for Part { flow, left, own } in &self.parts {
            let arrays = self.layout.arrays_mut(y);
            flow.write(*left, arrays.map(|array| array.get_mut(own.clone()).unwrap_or_default()));
        }
    }

    fn duplicate(&self) -> Self {
        let part = |part: &Part<F>| Part { flow: part.flow.duplicate(), own: part.own.clone(), ..*part };
        Self { parts: self.parts.iter().map(part).collect(), ..*self }
    }

    fn copy_from(&mut self, other: &Self) {
        self.parts.iter_mut().zip(&other.parts).for_each(|(part, other)| part.flow.copy_from(&other.flow));
        self.fresh = other.fresh;
    }

    fn drift(&mut self, dt: DoubleDouble<f64>) {
        self.each(1, |flow| flow.drift(dt));
    }

    fn kick_drift(&mut self, kick: f64, drift: DoubleDouble<f64>) {
        self.kick_drifts(&[(kick, drift)]);
    }

    fn kick_drifts(&mut self, pairs: &[(f64, DoubleDouble<f64>)]) {
        let mut rest = pairs;
        while !rest.is_empty() {
            if self.fresh == 0 {
                self.exchange();
            }
            let (now, later) = rest.split_at(rest.len().min(self.fresh));
            self.each(now.len(), |flow| flow.kick_drifts(now));
            (self.fresh, rest) = (self.fresh - now.len(), later);
        }
    }
}
