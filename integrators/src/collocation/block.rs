//! A block: consecutive bonds that one thread solves over one window.
//!
//! A long chain is cut into blocks, so that each thread needs memory for one block only. A block
//! also solves for some bonds on either side that belong to its neighbours (halo), and discards
//! their solution. The errors at the outer ends of the halo do not reach the block's own bonds,
//! since a force acts across one bond with a factor of a few hundredths. Blocks share nothing,
//! which makes the result the same for any number of threads. A block whose sites and halo are all
//! at rest is skipped.

use super::{
    bond::{Beside, Bond},
    chain::beside,
    goal::Goal,
    kernels::run,
    layout::look_beyond,
    motion::{Rotation, turn},
    panel::Frames,
    panels::Panels,
    sweep::{BOND, Change, LAYOUT},
    window::{Left, OWN, Piece, Start, WindowOutcome},
};
use crate::{kernel, real::Kernel};
use std::ops::{Range, RangeInclusive};

/// Sweeps after which a window is given up. Chosen, not measured.
const MOST_SWEEPS: u64 = 40;
/// Number of sweeps of the first pass, which are interleaved along the bonds, see [`Pass`]. Chosen:
/// most windows take no more, see `GOOD_SWEEPS`.
const LEVELS: usize = 5;
/// Number of times that contacts may be found anew, or panels halved, before a window is given up.
/// Chosen, not measured.
const MOST_ROUNDS: u32 = 10;
/// Number of times that the panels of a bond may be halved. Chosen, not measured.
const MOST_HALVINGS: u32 = 4;

/// The memory of a thread, for one block at a time.
pub(crate) struct Workspace<const M: usize, const S: usize> {
    pub(crate) bonds: Vec<Bond<M, S>>,
    old: Panels<M, S>,
    pub(crate) pieces: Vec<Piece>,
}

impl<const M: usize, const S: usize> Workspace<M, S> {
    pub(crate) fn new() -> Self {
        Self { bonds: Vec::new(), old: Panels::new(), pieces: Vec::new() }
    }

    /// Solves for the bonds of `own` and writes their results into `left`.
    pub(crate) fn solve(
        &mut self,
        start: &Start<S>,
        frames: &Frames<'_, M, S>,
        goal: &Goal,
        own: Range<usize>,
        left: &mut [Left<S>],
        log: bool,
    ) -> WindowOutcome {
        let (links, all, blocks) = (start.links, start.links.bonds, start.blocks);
        let whole = own.len() == all;
        // Local index i stands for bond (first + i) mod all.
        let (first, len) = blocks.along(&own);
        if !start.near[own.start / OWN] {
            return WindowOutcome::default();
        }
        let asleep = |b: usize| start.ongoing[b].is_none() && start.bonds.at_rest(b);
        if !whole && !links.precompressed && (first..first + len).all(|b| asleep(b % all)) {
            left.fill(Left::NONE);
            return WindowOutcome::default();
        }
        let offset = (own.start + all - first) % all;
        while self.bonds.len() < len {
            self.bonds.push(Bond::new());
        }
        let bonds = &mut self.bonds[..len];
        let mut b = first;
        for bond in bonds.iter_mut() {
            if S != 1 && links.open.is_some() {
                bond.known = start.bonds.known(b);
            }
            bond.begin(&frames.of(b), start.bonds.free(b, frames.h), start.ongoing[b], (b, start.mobility[b]));
            b = if b + 1 == all { 0 } else { b + 1 };
        }
        // A window that is far too long for a contact in it is given up before anything is solved.
        let approach = |bond: &Bond<M, S>| bond.approach(&frames.of(bond.initial.bond), goal.stiffest);
        if let Some((b, stiffness)) = too_stiff(bonds.iter().map(approach), goal) {
            return WindowOutcome {
                failure: Some(((first + b) % all, stiffness)),
                work: BOND * len as u64,
                ..WindowOutcome::default()
            };
        }
        let ring = whole && blocks.ring && all > 1;
        let mut outcome =
            Work { interval: Interval { bonds: &mut *bonds, ring }, old: &mut self.old, frames, goal }.run();
        outcome.failure = outcome.failure.map(|(b, residual)| ((first + b) % all, residual));
        let mine = offset..offset + own.len();
        outcome.work += BOND * len as u64;
        outcome.count(&bonds[mine.clone()], frames.h);
        for (left, bond) in left.iter_mut().zip(&bonds[mine.clone()]) {
            *left = Left { path: bond.panels.total, ongoing: bond.outlasting(frames.h), ledger: [0.0; 4] };
        }
        if outcome.failure.is_none() {
            let found = bonds[mine.clone()].iter().map(|bond| bond.sweeps.stiffness);
            outcome.failure = too_stiff(found, goal).map(|(b, stiffness)| (own.start + b, stiffness));
        }
        if const { S != 1 } && outcome.failure.is_none() {
            keep_ledger(start, frames, (&*bonds, mine.start, ring), left);
        }
        if log && outcome.failure.is_none() {
            for i in mine {
                log_contacts(frames, (&*bonds, i, ring), &mut self.pieces);
            }
        }
        outcome
    }
}

/// Appends the pieces of the contacts of bond `i` of a block.
fn log_contacts<const M: usize, const S: usize>(
    frames: &Frames<'_, M, S>,
    (bonds, i, ring): (&[Bond<M, S>], usize, bool),
    pieces: &mut Vec<Piece>,
) {
    let bond = &bonds[i];
    let beside = beside(i, bonds.len(), ring).map(|i| i.map(|i| &bonds[i]));
    bond.pieces((&frames.of(bond.initial.bond), bond.initial.bond), beside, pieces);
}

/// Writes the gains of the ledger into `left`, for the bonds of a block from `first` on.
fn keep_ledger<const M: usize, const S: usize>(
    start: &Start<S>,
    frames: &Frames<'_, M, S>,
    (bonds, first, ring): (&[Bond<M, S>], usize, bool),
    left: &mut [Left<S>],
) {
    let Some(open) = &start.links.open else { return };
    for (i, left) in (first..).zip(left) {
        let (bond, beside) = (&bonds[i], beside(i, bonds.len(), ring).map(|i| i.map(|i| &bonds[i])));
        left.ledger = open.gains_beside((start.bonds, frames.h), bond, beside[1].map(|next| &next.panels));
        let frame = &frames.of(bond.initial.bond);
        if frame.link.lossy() {
            left.ledger[2] += bond.let_go(frame, beside);
        }
    }
}

/// Consecutive bonds; on a whole ring the first and the last are neighbours too.
struct Interval<'a, const M: usize, const S: usize> {
    bonds: &'a mut [Bond<M, S>],
    ring: bool,
}

impl<const M: usize, const S: usize> Interval<'_, M, S> {
    fn again(&mut self) -> Interval<'_, M, S> {
        Interval { bonds: &mut *self.bonds, ring: self.ring }
    }

    /// A bond and its neighbours.
    #[inline(always)]
    fn at(&mut self, b: usize) -> (&mut Bond<M, S>, [Beside<'_, M, S>; 2]) {
        let (head, rest) = self.bonds.split_at_mut(b);
        let (me, tail) = rest.split_first_mut().expect("a bond of the block");
        let left = head.last().or(if self.ring { tail.last() } else { None });
        let right = tail.first().or(if self.ring { head.first() } else { None });
        (me, [left, right])
    }
}

/// Finds the contacts of all bonds from the forces at the start of the window; `false` if a search
/// needs too many subdivisions of the window.
#[inline(always)]
fn predict<const M: usize, const S: usize>(mut interval: Interval<'_, M, S>, frames: &Frames<'_, M, S>) -> bool {
    let (mut sure, mut end) = (true, [Rotation::NONE; S]);
    for b in 0..interval.bonds.len() {
        let (me, beside) = interval.at(b);
        let frame = &frames.of(me.initial.bond);
        if b == 0 || S != 1 {
            end = turn(frame, frame.h);
        }
        sure &= me.predict(frame, beside, &end);
    }
    sure
}

/// Computes for all bonds how far the forces are from the predicted ones, and the last terms of
/// their series over the allowed ones.
#[inline(always)]
fn judge<const M: usize, const S: usize>(bonds: &mut [Bond<M, S>], frames: &Frames<'_, M, S>, goal: &Goal) {
    for bond in bonds {
        bond.set_predictor_error(frames.h);
        let frame = &frames.of(bond.initial.bond);
        let mut tail = 0.0;
        for panel in bond.panels.as_slice() {
            let excess = goal.excess(panel.tail(frame, goal.slow));
            tail = if excess > tail { excess } else { tail };
        }
        bond.resolution.tail = tail;
    }
}

/// The first bond whose stiffness is above the limit for a window, and its stiffness.
fn too_stiff(stiffness: impl Iterator<Item = f64>, goal: &Goal) -> Option<(usize, f64)> {
    stiffness.enumerate().find(|(_, stiffness)| *stiffness > goal.stiffest)
}

/// The bonds of a block over a window, from the prediction to an outcome.
struct Work<'a, const M: usize, const S: usize> {
    interval: Interval<'a, M, S>,
    old: &'a mut Panels<M, S>,
    frames: &'a Frames<'a, M, S>,
    goal: &'a Goal,
}

impl<const M: usize, const S: usize> Work<'_, M, S> {
    fn run(self) -> WindowOutcome {
        let Self { mut interval, old, frames, goal } = self;
        let mut outcome = WindowOutcome::default();
        let bonds = interval.again();
        if !run(kernel!(predict(bonds, frames))) {
            outcome.failure = Some((0, f64::INFINITY));
            return outcome;
        }
        let mut levels = 0..=LEVELS;
        let mut rounds = 0;
        loop {
            let done = run(Pass { interval: interval.again(), old: &mut *old, frames, goal, levels });
            levels = 1..=1;
            outcome.sweeps += done.deepest as u64;
            outcome.work += done.work;
            outcome.failure = done.failure;
            if outcome.failure.is_some() {
                return outcome;
            }
            if done.deepest == 0 {
                let Some(b) = unsettled(&mut interval, frames, goal, &mut outcome) else { return outcome };
                rounds += 1;
                if rounds > MOST_ROUNDS {
                    outcome.failure = Some((b, f64::INFINITY));
                    return outcome;
                }
            } else if outcome.sweeps >= MOST_SWEEPS {
                outcome.failure = busiest(interval.bonds);
                return outcome;
            }
        }
    }
}

/// Among the bonds that wait for a sweep, that with the largest last change of its impulse, and
/// this change.
fn busiest<const M: usize, const S: usize>(bonds: &[Bond<M, S>]) -> Option<(usize, f64)> {
    let change = |bond: &Bond<M, S>| if bond.pending.sweep || bond.pending.layout { bond.sweeps.change } else { 0.0 };
    let worst = (0..bonds.len()).max_by(|&a, &b| change(&bonds[a]).total_cmp(&change(&bonds[b])));
    worst.map(|b| (b, bonds[b].sweeps.change))
}

/// Takes the bonds through some levels. Level 0 lays panels out and computes forces from the
/// prediction; every other level is one sweep over the bonds that wait for one.
///
/// Levels are interleaved: each follows one bond after the level before it, so that a bond is swept
/// several times while it and its neighbours are in the cache. Each level also starts one bond
/// further on. On a ring the first bond then comes after its neighbour at the end, and a sweep sees
/// the same forces as if the levels were done one after the other.
struct Pass<'a, const M: usize, const S: usize> {
    interval: Interval<'a, M, S>,
    /// Room for panels that are replaced.
    old: &'a mut Panels<M, S>,
    frames: &'a Frames<'a, M, S>,
    goal: &'a Goal,
    levels: RangeInclusive<usize>,
}

/// The outcome of a pass.
#[derive(Clone, Copy, Debug, Default)]
struct Passed {
    /// The last level on which a bond was swept; zero if none was.
    deepest: usize,
    /// Cost, in the units of [`BOND`].
    work: u64,
    /// A bond whose change of impulse is not finite, and this change.
    failure: Option<(usize, f64)>,
}

impl<const M: usize, const S: usize> Kernel for Pass<'_, M, S> {
    type Output = Passed;

    #[inline(always)]
    fn run(mut self) -> Passed {
        let (n, from, to) = (self.interval.bonds.len(), *self.levels.start(), *self.levels.end());
        let mut passed = Passed::default();
        for place in 0..n + 2 * to {
            // Levels that have begun and are not done: 2 level <= place < n + 2 level.
            let first = from.max((place + 2).saturating_sub(n) / 2);
            let last = to.min(place / 2);
            // Each level is one bond behind the level before it.
            let mut b = (place - first.min(place)) % n;
            for level in first..=last {
                if level == 0 {
                    self.start(b, &mut passed);
                } else if self.interval.bonds[b].waits() {
                    self.sweep(b, level, &mut passed);
                }
                b = if b == 0 { n - 1 } else { b - 1 };
            }
        }
        passed
    }
}

impl<const M: usize, const S: usize> Pass<'_, M, S> {
    #[inline(always)]
    fn look_beyond(&mut self, b: usize) {
        if S != 1 && self.frames.links.lossy() {
            look_beyond(self.interval.bonds, b, self.interval.ring);
        }
    }

    /// Lays out the panels of a bond and computes its forces from the prediction.
    #[inline(always)]
    fn start(&mut self, b: usize, passed: &mut Passed) {
        self.look_beyond(b);
        let (me, beside) = self.interval.at(b);
        let frame = &self.frames.of(me.initial.bond);
        me.lay_out(frame, beside, self.old);
        me.start(frame, beside);
        me.pending.sweep = true;
        passed.work += LAYOUT * me.panels.len as u64;
    }

    /// Sweeps a bond, and marks its neighbours if they must be swept again.
    #[inline(always)]
    fn sweep(&mut self, b: usize, level: usize, passed: &mut Passed) {
        if self.interval.bonds[b].pending.layout {
            self.look_beyond(b);
        }
        let Self { frames, goal, .. } = *self;
        let (me, beside) = self.interval.at(b);
        let frame = &frames.of(me.initial.bond);
        let anew = me.pending.layout;
        // A bond whose contact turned out to be none is swept once more, with no panels.
        if !anew && me.contacts.found.is_empty() {
            me.pending.sweep = false;
            return;
        }
        if anew {
            me.lay_out(frame, beside, self.old);
        }
        passed.deepest = passed.deepest.max(level);
        let change = me.sweep(frame, beside, anew.then_some(&*self.old));
        let age = me.sweeps.age;
        passed.work += change.work;
        let unsettled = change.impulse > goal.rounded;
        // The first sweep over halved panels takes overlaps, and the events, from panels that did
        // not resolve the force. A force that jumps, its own or a neighbour's, shows the error of
        // its event at first order.
        let unsure = anew && frames.links.lossy() && me.resolution.halvings > 0;
        me.pending.sweep = unsettled && change.impulse * me.answer(age) > goal.change || change.moved > 0.0 || unsure;
        if !change.impulse.is_finite() {
            passed.failure = Some((b, change.impulse));
        }
        self.tell(b, &change, (age, unsettled));
    }

    /// Marks the neighbours of bond `b` that its change concerns: for a sweep, or for new panels
    /// too.
    #[inline(always)]
    fn tell(&mut self, b: usize, change: &Change, (age, unsettled): (u32, bool)) {
        let far = change.moved > self.frames.cuts.merge;
        let Interval { bonds, ring } = &mut self.interval;
        for beside in beside(b, bonds.len(), *ring).into_iter().flatten() {
            let other = &mut bonds[beside];
            other.sweeps.age = other.sweeps.age.min(age);
            let acts = far || unsettled && change.impulse * other.answer(age) > self.goal.change;
            if acts && !other.contacts.found.is_empty() {
                other.pending.sweep = true;
                other.pending.layout |= far;
            }
        }
    }
}

/// After the sweeps: searches the contacts of bonds whose overlaps may be too far from the
/// prediction again, and halves panels that do not resolve their force. Returns the last bond that
/// must be swept again for one of these reasons, if there is one.
fn unsettled<const M: usize, const S: usize>(
    interval: &mut Interval<'_, M, S>,
    frames: &Frames<'_, M, S>,
    goal: &Goal,
    outcome: &mut WindowOutcome,
) -> Option<usize> {
    let mut anew = None;
    let bonds = &mut *interval.bonds;
    run(kernel!(judge(bonds, frames, goal)));
    let per = 0.5 * frames.h * frames.h;
    for b in 0..interval.bonds.len() {
        let (me, beside) = interval.at(b);
        let frame = &frames.of(me.initial.bond);
        let of = |bond: Beside<M, S>| bond.map_or(0.0, |bond| bond.prediction.predictor_error);
        let others = Bond::driven(frame, of(beside[0]), of(beside[1]));
        let off = per * (others + me.initial.mobility * me.prediction.predictor_error);
        if off > me.prediction.margin || me.pending.search || me.pending.diverged {
            match me.verify(frame, beside) {
                None => outcome.failure = Some((b, f64::INFINITY)),
                Some(true) => {
                    (me.pending.layout, anew) = (true, Some(b));
                    // As where an event moves far, see [`Pass::tell`].
                    for side in super::chain::beside(b, interval.bonds.len(), interval.ring).into_iter().flatten() {
                        let other = &mut interval.bonds[side];
                        other.pending.layout |= frames.links.lossy() && !other.contacts.found.is_empty();
                    }
                }
                Some(false) => {}
            }
        }
        let me = &mut interval.bonds[b];
        if me.resolution.tail > 1.0 {
            me.resolution.halvings += 1;
            (me.pending.layout, anew) = (true, Some(b));
            if me.resolution.halvings > MOST_HALVINGS {
                outcome.failure = Some((b, f64::INFINITY));
            }
        }
    }
    anew.filter(|_| outcome.failure.is_none())
}
