//! A stretch of neighbouring bonds, solved over one window by one thread.
//!
//! A long chain is cut into blocks, so that memory is needed for one a thread only. A block takes some bonds of its neighbours along and solves for them too, without
//! handing on what it finds: forces reach across one bond with a factor of a few hundredths, so that nothing of what is wrong
//! at the far end arrives. Blocks share nothing, which makes the result the same for any number of threads. A block at rest sleeps until something
//! moves in what it takes along.

use super::{
    bond::{BOND, Beside, Bond, Contact, LAYOUT},
    layout::Cuts,
    panel::{Frame, sin_cos},
    panels::Panels,
    sites::Bonds,
    system::{Links, Path},
};
use crate::{
    law::ContactLaw,
    real::{Kernel, Real},
};
use std::ops::{Range, RangeInclusive};

/// Bonds of a block, and those of its neighbours on either side that it takes along.
pub(crate) const OWN: usize = 256;
const ALONG: usize = 12;
/// A chain up to this is one block.
const WHOLE: usize = OWN;
/// Sweeps after which a window is given up.
const MOST_SWEEPS: u64 = 40;
/// Sweeps of the first pass.
const LEVELS: usize = 5;
/// Times that a window may turn out to be other than it was taken for.
const MOST_ROUNDS: u32 = 10;
/// Last terms of a force that is resolved at all, as a share of its largest value: measured, with `omega` from 0.01 to 10^4 times the frequency of contacts.
const RESOLVED: f64 = 0.3;
/// Times that panels may be halved.
const MOST_HALVINGS: u32 = 4;

/// What a window starts from.
pub(crate) struct Start<'a> {
    pub(crate) links: &'a Links,
    pub(crate) bonds: &'a dyn Bonds,
    pub(crate) ongoing: &'a [Option<Contact>],
}

/// When a window counts as solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Change of an impulse that another sweep may make.
    pub(crate) change: f64,
    /// A change of an impulse that is nothing but rounding.
    pub(crate) rounded: f64,
    /// Last terms of the series of an impulse; infinite if panels are not to be halved.
    pub(crate) tail: f64,
    /// How many times those of a force that nearly goes out count.
    pub(crate) slow: f64,
    /// An impulse that counts; what is smaller need not be resolved.
    pub(crate) felt: f64,
    pub(crate) cuts: Cuts,
}

impl Goal {
    /// How many times larger the last terms of an impulse are than allowed, from them and its largest value. Small beside the velocities is not enough: where
    /// resonators are much faster than contacts, the force moves little in any one of many windows, and would be wrong in all of them.
    #[inline(always)]
    fn excess(&self, [last, largest]: [f64; 2]) -> f64 {
        let [total, own] = [last / self.tail, last / (RESOLVED * largest)];
        if largest > self.felt && own > total { own } else { total }
    }
}

/// What a window leaves behind in a bond.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Left {
    pub(crate) path: Path,
    pub(crate) ongoing: Option<Contact>,
}

/// What a contact did within one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The bond.
    pub bond: usize,
    /// Onset in this window: time since its start, and `dg/dt` (to six digits and more).
    pub onset: Option<(f64, f64)>,
    /// Release in this window: time since its start, and `dg/dt`.
    pub release: Option<(f64, f64)>,
    /// `int f dt`.
    pub impulse: f64,
    /// Largest overlap.
    pub largest: f64,
}

/// How it went.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Verdict {
    pub(crate) sweeps: u64,
    /// What it cost, see [`BOND`].
    pub(crate) work: u64,
    /// The largest `f'(g) h^2`.
    pub(crate) stiffness: f64,
    /// The largest last terms of a series, in units of those allowed.
    pub(crate) tail: f64,
    /// Bonds that touched, and those whose panels were halved.
    pub(crate) touching: usize,
    pub(crate) halved: usize,
    /// Bond and change of impulse where it failed.
    pub(crate) failure: Option<(usize, f64)>,
}

impl Verdict {
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            sweeps: self.sweeps.max(other.sweeps),
            work: self.work + other.work,
            stiffness: self.stiffness.max(other.stiffness),
            tail: self.tail.max(other.tail),
            touching: self.touching + other.touching,
            halved: self.halved + other.halved,
            failure: self.failure.or(other.failure),
        }
    }
}

/// The number of blocks of a chain with so many bonds.
pub(crate) fn blocks(bonds: usize) -> usize {
    if bonds <= WHOLE { 1 } else { bonds.div_ceil(OWN) }
}

/// The bonds that block `k` answers for.
pub(crate) fn own(bonds: usize, k: usize) -> Range<usize> {
    if bonds <= WHOLE { 0..bonds } else { k * OWN..((k + 1) * OWN).min(bonds) }
}

/// Memory for one block at a time.
pub(crate) struct Workspace<const M: usize> {
    pub(crate) bonds: Vec<Bond<M>>,
    old: Panels<M>,
    pub(crate) pieces: Vec<Piece>,
}

impl<const M: usize> Workspace<M> {
    pub(crate) fn new() -> Self {
        Self { bonds: Vec::new(), old: Panels::new(), pieces: Vec::new() }
    }

    /// Solves for the bonds of `own` and leaves what they leave behind in `left`.
    pub(crate) fn solve(
        &mut self,
        start: &Start,
        frame: &Frame<'_, M>,
        goal: &Goal,
        own: Range<usize>,
        left: &mut [Left],
        log: bool,
    ) -> Verdict {
        let (links, all) = (start.links, start.links.bonds);
        let whole = own.len() == all;
        // Local index i stands for bond (first + i) mod all.
        let (first, len) = if whole {
            (0, all)
        } else if links.ring {
            ((own.start + all - ALONG) % all, own.len() + 2 * ALONG)
        } else {
            let first = own.start.saturating_sub(ALONG);
            (first, (own.end + ALONG).min(all) - first)
        };
        let asleep = |b: usize| start.ongoing[b].is_none() && start.bonds.at_rest(b);
        if !whole && !links.precompressed && (first..first + len).all(|b| asleep(b % all)) {
            left.fill(Left::default());
            return Verdict::default();
        }
        let offset = (own.start + all - first) % all;
        while self.bonds.len() < len {
            self.bonds.push(Bond::new());
        }
        let law = &links.law;
        let bonds = &mut self.bonds[..len];
        let mut b = first;
        for bond in bonds.iter_mut() {
            (bond.ongoing, bond.recoil) = (start.ongoing[b], links.recoil[b]);
            bond.begin(frame, law, start.bonds.free(b, frame.h));
            b = if b + 1 == all { 0 } else { b + 1 };
        }
        let ring = whole && links.ring && all > 1;
        let mut verdict = Work { bonds: &mut *bonds, old: &mut self.old, frame, law, goal, ring }.run();
        verdict.failure = verdict.failure.map(|(b, residual)| ((first + b) % all, residual));
        let mine = offset..offset + own.len();
        verdict.work += BOND * len as u64;
        verdict.touching = bonds[mine.clone()].iter().filter(|bond| !bond.contacts.is_empty()).count();
        verdict.stiffness = bonds[mine.clone()].iter().fold(0.0, |stiffness, bond| bond.stiffness.max(stiffness));
        verdict.halved = bonds[mine.clone()].iter().filter(|bond| bond.halvings > 0).count();
        for (left, bond) in left.iter_mut().zip(&bonds[mine.clone()]) {
            *left = Left { path: bond.panels.total, ongoing: bond.outlasting(frame.h) };
        }
        if log && verdict.failure.is_none() {
            for (b, i) in own.zip(mine) {
                let left = if i > 0 { Some(i - 1) } else { ring.then(|| len - 1) };
                let right = if i + 1 < len { Some(i + 1) } else { ring.then_some(0) };
                let beside = [left, right].map(|i| i.map(|i| &bonds[i]));
                let piece = |contact: &Contact| bonds[i].piece_of(frame, contact, beside, b);
                self.pieces.extend(bonds[i].contacts.iter().map(piece));
            }
        }
        verdict
    }
}

/// The bonds of a block over a window.
struct Work<'a, const M: usize> {
    bonds: &'a mut [Bond<M>],
    old: &'a mut Panels<M>,
    frame: &'a Frame<'a, M>,
    law: &'a ContactLaw<f64>,
    goal: &'a Goal,
    ring: bool,
}

/// Finds the contacts of all bonds from the forces at the start of the window; `false` where there are too many to be sure.
struct Predict<'a, const M: usize> {
    bonds: &'a mut [Bond<M>],
    frame: &'a Frame<'a, M>,
    law: &'a ContactLaw<f64>,
    cuts: Cuts,
    ring: bool,
}

impl<const M: usize> Kernel for Predict<'_, M> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { bonds, frame, law, cuts, ring } = self;
        let end = if frame.omega == 0.0 { (0.0, 1.0) } else { sin_cos(frame.omega * frame.h) };
        let mut sure = true;
        for b in 0..bonds.len() {
            let (me, left, right) = beside(bonds, b, ring);
            sure &= me.predict(frame, law, left, right, end, cuts);
        }
        sure
    }
}

/// Compares all forces with those that were predicted, and with what the nodes resolve.
struct Judge<'a, const M: usize> {
    bonds: &'a mut [Bond<M>],
    frame: &'a Frame<'a, M>,
    goal: &'a Goal,
}

impl<const M: usize> Kernel for Judge<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { bonds, frame, goal } = self;
        for bond in bonds {
            bond.surprised(frame.h);
            let mut tail = 0.0;
            for panel in bond.panels.as_slice() {
                let excess = goal.excess(panel.tail(frame, goal.slow));
                tail = if excess > tail { excess } else { tail };
            }
            bond.tail = tail;
        }
    }
}

impl<const M: usize> Work<'_, M> {
    fn run(self) -> Verdict {
        let Self { bonds, old, frame, law, goal, ring } = self;
        let n = bonds.len();
        let mut verdict = Verdict::default();
        if !f64::run(Predict { bonds: &mut *bonds, frame, law, cuts: goal.cuts, ring }) {
            verdict.failure = Some((0, f64::INFINITY));
            return verdict;
        }
        let mut levels = 0..=LEVELS;
        let mut rounds = 0;
        loop {
            let (bonds, old) = (&mut *bonds, &mut *old);
            let busy = f64::run(Pass { bonds, old, frame, law, goal, ring, levels, verdict: &mut verdict });
            levels = 1..=1;
            if verdict.failure.is_some() {
                return verdict;
            }
            if !busy {
                let Some(b) = unsettled(bonds, frame, goal, ring, &mut verdict) else { return verdict };
                rounds += 1;
                if rounds > MOST_ROUNDS {
                    verdict.failure = Some((b, f64::INFINITY));
                    return verdict;
                }
            } else if verdict.sweeps >= MOST_SWEEPS {
                let change = |b: &usize| if bonds[*b].dirty || bonds[*b].stale { bonds[*b].change } else { 0.0 };
                let worst = (0..n).max_by(|a, b| change(a).total_cmp(&change(b)));
                verdict.failure = worst.map(|b| (b, bonds[b].change));
                return verdict;
            }
        }
    }
}

/// Takes the bonds through some levels: level 0 lays panels out and starts from the prediction, every other is one sweep over those that have
/// something to do. Returns whether any had.
///
/// A level follows a bond behind the one before it, so that a bond is swept again and again while it and its neighbours are in the cache. It starts a bond
/// further on too: on a ring the first bond then comes after its neighbour at the end, and what a sweep sees is the same as if it went over all bonds alone.
struct Pass<'a, const M: usize> {
    bonds: &'a mut [Bond<M>],
    old: &'a mut Panels<M>,
    frame: &'a Frame<'a, M>,
    law: &'a ContactLaw<f64>,
    goal: &'a Goal,
    ring: bool,
    levels: RangeInclusive<usize>,
    verdict: &'a mut Verdict,
}

impl<const M: usize> Kernel for Pass<'_, M> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { bonds, old, frame, law, goal, ring, levels, verdict } = self;
        let n = bonds.len();
        let mut deepest = 0;
        for place in 0..n + 2 * levels.end() {
            for level in levels.clone() {
                if place < 2 * level || place >= n + 2 * level {
                    continue;
                }
                let mut b = place - level;
                while b >= n {
                    b -= n;
                }
                let (me, left, right) = beside(bonds, b, ring);
                let anew = level == 0 || me.stale;
                if anew {
                    me.lay_out(frame, [left, right], goal.cuts, old);
                }
                if level == 0 {
                    me.start(frame, law, left, right);
                    me.dirty = true;
                    verdict.work += LAYOUT * me.panels.len as u64;
                    continue;
                }
                // A contact that turned out to be none is swept once more, to be forgotten.
                if !(anew || me.dirty && !me.contacts.is_empty()) {
                    me.dirty = false;
                    continue;
                }
                deepest = deepest.max(level);
                let change = me.sweep(frame, law, [left, right], goal.cuts, anew.then_some(&*old));
                let age = me.age;
                verdict.work += change.work;
                let unsettled = change.impulse > goal.rounded;
                me.dirty = unsettled && change.impulse * me.answer(age) > goal.change || change.moved > 0.0;
                me.change = change.impulse;
                if !change.impulse.is_finite() {
                    verdict.failure = Some((b, change.impulse));
                }
                let far = change.moved > goal.cuts.frozen_beside;
                for beside in [
                    if b > 0 { Some(b - 1) } else { ring.then(|| n - 1) },
                    if b + 1 < n { Some(b + 1) } else { ring.then_some(0) },
                ]
                .into_iter()
                .flatten()
                {
                    let other = &mut bonds[beside];
                    other.age = other.age.min(age);
                    if !other.contacts.is_empty()
                        && (far || unsettled && change.impulse * other.answer(age) > goal.change)
                    {
                        other.dirty = true;
                        other.stale |= far;
                    }
                }
            }
        }
        verdict.sweeps += deepest as u64;
        deepest > 0
    }
}

/// Looks whether what was found is what there is: contacts that nobody predicted, and forces that the nodes do not resolve. The last bond
/// of which something must be done anew, if there is one.
fn unsettled<const M: usize>(
    bonds: &mut [Bond<M>],
    frame: &Frame<'_, M>,
    goal: &Goal,
    ring: bool,
    verdict: &mut Verdict,
) -> Option<usize> {
    let n = bonds.len();
    let mut anew = None;
    verdict.tail = 0.0;
    f64::run(Judge { bonds: &mut *bonds, frame, goal });
    let per = 0.5 * frame.h * frame.h;
    for b in 0..n {
        let (me, left, right) = beside(bonds, b, ring);
        let of = |bond: Beside<M>| bond.map_or(0.0, |bond| bond.surprise);
        let off = per * (of(left) + of(right) + me.recoil * me.surprise);
        if off > me.slack || me.suspicious {
            match me.verify(frame, left, right, goal.cuts) {
                None => verdict.failure = Some((b, f64::INFINITY)),
                Some(true) => (me.stale, anew) = (true, Some(b)),
                Some(false) => {}
            }
        }
        let tail = me.tail;
        verdict.tail = if tail > verdict.tail { tail } else { verdict.tail };
        if tail > 1.0 {
            me.halvings += 1;
            (me.stale, anew) = (true, Some(b));
            if me.halvings > MOST_HALVINGS {
                verdict.failure = Some((b, f64::INFINITY));
            }
        }
    }
    anew.filter(|_| verdict.failure.is_none())
}

/// A bond and its neighbours.
#[inline(always)]
fn beside<const M: usize>(bonds: &mut [Bond<M>], b: usize, ring: bool) -> (&mut Bond<M>, Beside<'_, M>, Beside<'_, M>) {
    let (head, rest) = bonds.split_at_mut(b);
    let (me, tail) = rest.split_first_mut().expect("a bond of the block");
    let left = head.last().or(if ring { tail.last() } else { None });
    let right = tail.first().or(if ring { head.first() } else { None });
    (me, left, right)
}
