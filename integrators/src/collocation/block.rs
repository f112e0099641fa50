//! A stretch of neighbouring bonds, solved over one window by one thread.
//!
//! A long chain is cut into blocks, so that memory is needed for one a thread only. A block takes
//! some bonds of its neighbours along and solves for them too, without handing on what it finds:
//! forces reach across one bond with a factor of a few hundredths, so that nothing of what is wrong
//! at the far end arrives. Blocks share nothing, which makes the result the same for any number of
//! threads. A block at rest sleeps until something moves in what it takes along.

use super::{
    bond::{BOND, Beside, Bond, Change, Contact, LAYOUT},
    foresee::{Turned, turn},
    goal::Goal,
    panel::Frames,
    panels::Panels,
    sites::Bonds,
    system::{Links, Path, beside},
};
use crate::{
    events::Curve,
    real::{Kernel, Real, run_narrow},
};
use std::ops::{Range, RangeInclusive};

/// Bonds of a block, and those of its neighbours on either side that it takes along. 256 is chosen;
/// 12 is held by `methods any_number_of_threads_gives_the_same_bits`, which measures the momentum
/// that blocks lose to each other.
pub(crate) const OWN: usize = 256;
pub(crate) const ALONG: usize = 12;
/// Sweeps after which a window is given up. Chosen, not measured.
const MOST_SWEEPS: u64 = 40;
/// Sweeps of the first pass, which go along the bonds together. Chosen: most windows take no more,
/// see `GOOD_SWEEPS`.
const LEVELS: usize = 5;
/// Times that contacts may be found anew, or panels halved, before a window is given up. Chosen,
/// not measured.
const MOST_ROUNDS: u32 = 10;
/// Times that panels may be halved. Chosen, not measured.
const MOST_HALVINGS: u32 = 4;

/// What a window starts from.
pub(crate) struct Start<'a, const S: usize> {
    pub(crate) links: &'a Links<S>,
    pub(crate) bonds: &'a dyn Bonds<S>,
    pub(crate) ongoing: &'a [Option<Contact>],
    /// How strongly a unit force of each bond opens it: 2 between two sites of mass 1, 1 at a wall.
    pub(crate) recoil: &'a [f64],
    pub(crate) share: &'a Share,
}

/// Which bonds of a chain are solved for in one place, as they are counted there.
#[derive(Clone, Debug)]
pub struct Share {
    /// Solved for; blocks are counted from the first.
    pub(crate) own: Range<usize>,
    /// Those, and bonds on either side of them, which may be taken along.
    reach: Range<usize>,
    /// Whether these are all bonds of a ring.
    ring: bool,
    /// Number of the first own bond in the whole chain, and of bonds there.
    place: (usize, usize),
}

impl Share {
    /// All of so many bonds, of a chain with ends or a ring.
    pub fn whole(bonds: usize, ring: bool) -> Self {
        Self { own: 0..bonds, reach: 0..bonds, ring, place: (0, bonds) }
    }

    /// Some bonds with those around them, which are within `reach` of their blocks; with the number
    /// of the first in the whole chain, and of bonds there.
    pub fn part(own: Range<usize>, reach: Range<usize>, place: (usize, usize)) -> Self {
        Self { own, reach, ring: false, place }
    }

    /// Those, and the bonds around them that blocks may take along.
    pub(crate) fn reach(&self) -> Range<usize> {
        self.reach.clone()
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.own.len().div_ceil(OWN)
    }

    /// The bonds that a block answers for.
    pub(crate) fn own(&self, block: usize) -> Range<usize> {
        let first = self.own.start + block * OWN;
        first..self.own.end.min(first + OWN)
    }

    /// How the whole chain counts a bond.
    fn number(&self, bond: usize) -> usize {
        let (first, all) = self.place;
        (first + all + bond - self.own.start) % all
    }

    /// The first bond that a block works on, and how many: beyond the last bond of a ring comes the
    /// first again.
    fn along(&self, own: &Range<usize>) -> (usize, usize) {
        let Range { start, end } = self.reach;
        if own.len() == self.reach.len() {
            (start, own.len())
        } else if self.ring {
            ((own.start + end - ALONG) % end, own.len() + 2 * ALONG)
        } else {
            let first = own.start.saturating_sub(ALONG).max(start);
            (first, (own.end + ALONG).min(end) - first)
        }
    }
}

/// What a window leaves behind in a bond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Left<const S: usize> {
    /// On each side of the bond.
    pub(crate) path: [Path; S],
    pub(crate) ongoing: Option<Contact>,
    /// What the ledger gains, of the sites that the bond keeps.
    pub(crate) ledger: Path,
}

impl<const S: usize> Left<S> {
    /// Nothing.
    pub(crate) const NONE: Self = Self { path: [[0.0; 4]; S], ongoing: None, ledger: [0.0; 4] };
}

/// What a contact did in a part of a step; the parts of a contact come in order of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The bond.
    pub bond: usize,
    /// Zero of the overlap with which the part begins: time since the start of the step, and
    /// `dg/dt` (to six digits and more).
    pub onset: Option<(f64, f64)>,
    /// Zero with which it ends: time since the start of the step, and `dg/dt`.
    pub release: Option<(f64, f64)>,
    /// `int f dt`.
    pub impulse: f64,
    /// The overlap; `None` in a contact that was over before the step began.
    pub curve: Option<Curve>,
}

/// How it went.
#[derive(Clone, Copy, Debug, Default)]
pub struct Verdict {
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
    /// This and that of bonds behind them. Numbers are added as integers and the largest taken, so
    /// that it is the same in whatever groups bonds are.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
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

    /// Counts what bonds did.
    fn count<const M: usize, const S: usize>(&mut self, bonds: &[Bond<M, S>]) {
        for bond in bonds {
            self.touching += usize::from(!bond.contacts.found.is_empty());
            self.halved += usize::from(bond.resolution.halvings > 0);
            self.stiffness = bond.sweeps.stiffness.max(self.stiffness);
        }
    }
}

/// Memory for one block at a time.
pub(crate) struct Workspace<const M: usize, const S: usize> {
    pub(crate) bonds: Vec<Bond<M, S>>,
    old: Panels<M, S>,
    pub(crate) pieces: Vec<Piece>,
}

impl<const M: usize, const S: usize> Workspace<M, S> {
    pub(crate) fn new() -> Self {
        Self { bonds: Vec::new(), old: Panels::new(), pieces: Vec::new() }
    }

    /// Solves for the bonds of `own` and leaves what they leave behind in `left`.
    pub(crate) fn solve(
        &mut self,
        start: &Start<S>,
        frames: &Frames<'_, M, S>,
        goal: &Goal,
        own: Range<usize>,
        left: &mut [Left<S>],
        log: bool,
    ) -> Verdict {
        let (links, all, share) = (start.links, start.links.bonds, start.share);
        let whole = own.len() == share.reach.len();
        // Local index i stands for bond (first + i) mod all.
        let (first, len) = share.along(&own);
        let asleep = |b: usize| start.ongoing[b].is_none() && start.bonds.at_rest(b);
        if !whole && !links.precompressed && (first..first + len).all(|b| asleep(b % all)) {
            left.fill(Left::NONE);
            return Verdict::default();
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
            bond.begin(&frames.of(b), start.bonds.free(b, frames.h), start.ongoing[b], (b, start.recoil[b]));
            b = if b + 1 == all { 0 } else { b + 1 };
        }
        // Contacts that begin in a window far too long for them are seen before anything is solved.
        let approach = |bond: &Bond<M, S>| bond.approach(&frames.of(bond.initial.bond), goal.stiffest);
        if let Some((b, stiffness)) = too_stiff(bonds.iter().map(approach), goal) {
            return Verdict {
                failure: Some((share.number(first + b), stiffness)),
                work: BOND * len as u64,
                ..Verdict::default()
            };
        }
        let ring = whole && share.ring && all > 1;
        let mut verdict =
            Work { stretch: Stretch { bonds: &mut *bonds, ring }, old: &mut self.old, frames, goal }.run();
        verdict.failure = verdict.failure.map(|(b, residual)| (share.number(first + b), residual));
        let mine = offset..offset + own.len();
        verdict.work += BOND * len as u64;
        verdict.count(&bonds[mine.clone()]);
        for (left, bond) in left.iter_mut().zip(&bonds[mine.clone()]) {
            *left = Left { path: bond.panels.total, ongoing: bond.outlasting(frames.h), ledger: [0.0; 4] };
        }
        if verdict.failure.is_none() {
            let found = bonds[mine.clone()].iter().map(|bond| bond.sweeps.stiffness);
            verdict.failure = too_stiff(found, goal).map(|(b, stiffness)| (share.number(own.start + b), stiffness));
        }
        if const { S != 1 } && verdict.failure.is_none() {
            keep_ledger(start, frames, (&*bonds, mine.start, ring), left);
        }
        if log && verdict.failure.is_none() {
            for i in mine {
                let beside = beside(i, len, ring).map(|i| i.map(|i| &bonds[i]));
                let (frame, number) = (&frames.of(bonds[i].initial.bond), share.number(bonds[i].initial.bond));
                if frame.link.lossy() {
                    bonds[i].pieces_over((frame, number), beside, &mut self.pieces);
                    continue;
                }
                for contact in &bonds[i].contacts.found {
                    bonds[i].pieces_of((frame, number), contact, beside, &mut self.pieces);
                }
            }
        }
        verdict
    }
}

/// Writes what the ledger gains, of bonds from `first` on among those of a block.
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

/// Runs a kernel of the solver. Where bonds see two sites AVX-512 would gain 4 % at most (50 sites,
/// tolerances from 1e-4 to 1e-11), and a fifth of the program's time to compile: it is left out.
#[inline(always)]
pub(super) fn run<const S: usize, K: Kernel>(kernel: K) -> K::Output {
    if const { S == 1 } { f64::run(kernel) } else { run_narrow(kernel) }
}

/// Runs a kernel inside another, of bonds that see two sites, without becoming a part of it: less
/// to compile.
#[inline(never)]
pub(super) fn apart<K: Kernel>(kernel: K) -> K::Output {
    run_narrow(kernel)
}

/// Neighbouring bonds; on a whole ring the first and the last are neighbours too.
struct Stretch<'a, const M: usize, const S: usize> {
    bonds: &'a mut [Bond<M, S>],
    ring: bool,
}

impl<const M: usize, const S: usize> Stretch<'_, M, S> {
    fn again(&mut self) -> Stretch<'_, M, S> {
        Stretch { bonds: &mut *self.bonds, ring: self.ring }
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

/// Finds the contacts of all bonds from the forces at the start of the window; `false` where there
/// are too many to be sure.
struct Predict<'a, const M: usize, const S: usize> {
    stretch: Stretch<'a, M, S>,
    frames: &'a Frames<'a, M, S>,
}

impl<const M: usize, const S: usize> Kernel for Predict<'_, M, S> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { mut stretch, frames } = self;
        let (mut sure, mut end) = (true, [Turned::NONE; S]);
        for b in 0..stretch.bonds.len() {
            let (me, beside) = stretch.at(b);
            let frame = &frames.of(me.initial.bond);
            if b == 0 || S != 1 {
                end = turn(frame, frame.h);
            }
            sure &= me.predict(frame, beside, &end);
        }
        sure
    }
}

/// Compares all forces with those that were predicted, and with what the nodes resolve.
struct Judge<'a, const M: usize, const S: usize> {
    bonds: &'a mut [Bond<M, S>],
    frames: &'a Frames<'a, M, S>,
    goal: &'a Goal,
}

impl<const M: usize, const S: usize> Kernel for Judge<'_, M, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { bonds, frames, goal } = self;
        for bond in bonds {
            bond.surprised(frames.h);
            let frame = &frames.of(bond.initial.bond);
            let mut tail = 0.0;
            for panel in bond.panels.as_slice() {
                let excess = goal.excess(panel.tail(frame, goal.slow));
                tail = if excess > tail { excess } else { tail };
            }
            bond.resolution.tail = tail;
        }
    }
}

/// The first bond whose stiffness is beyond what a window may have, and that.
fn too_stiff(stiffness: impl Iterator<Item = f64>, goal: &Goal) -> Option<(usize, f64)> {
    stiffness.enumerate().find(|(_, stiffness)| *stiffness > goal.stiffest)
}

/// The bonds of a block over a window, from the prediction to a verdict.
struct Work<'a, const M: usize, const S: usize> {
    stretch: Stretch<'a, M, S>,
    old: &'a mut Panels<M, S>,
    frames: &'a Frames<'a, M, S>,
    goal: &'a Goal,
}

impl<const M: usize, const S: usize> Work<'_, M, S> {
    fn run(self) -> Verdict {
        let Self { mut stretch, old, frames, goal } = self;
        let mut verdict = Verdict::default();
        if !run::<S, _>(Predict { stretch: stretch.again(), frames }) {
            verdict.failure = Some((0, f64::INFINITY));
            return verdict;
        }
        let mut levels = 0..=LEVELS;
        let mut rounds = 0;
        loop {
            let done = run::<S, _>(Pass { stretch: stretch.again(), old: &mut *old, frames, goal, levels });
            levels = 1..=1;
            verdict.sweeps += done.deepest as u64;
            verdict.work += done.work;
            verdict.failure = done.failure;
            if verdict.failure.is_some() {
                return verdict;
            }
            if done.deepest == 0 {
                let Some(b) = unsettled(&mut stretch, frames, goal, &mut verdict) else { return verdict };
                rounds += 1;
                if rounds > MOST_ROUNDS {
                    verdict.failure = Some((b, f64::INFINITY));
                    return verdict;
                }
            } else if verdict.sweeps >= MOST_SWEEPS {
                verdict.failure = busiest(stretch.bonds);
                return verdict;
            }
        }
    }
}

/// The bond of which most is still to change, and by how much its impulse changed last.
fn busiest<const M: usize, const S: usize>(bonds: &[Bond<M, S>]) -> Option<(usize, f64)> {
    let change = |bond: &Bond<M, S>| if bond.pending.sweep || bond.pending.layout { bond.sweeps.change } else { 0.0 };
    let worst = (0..bonds.len()).max_by(|&a, &b| change(&bonds[a]).total_cmp(&change(&bonds[b])));
    worst.map(|b| (b, bonds[b].sweeps.change))
}

/// Takes the bonds through some levels: level 0 lays panels out and starts from the prediction,
/// every other is one sweep over those that have something to do.
///
/// A level follows a bond after the one before it, so that a bond is swept again and again while it
/// and its neighbours are in the cache. It starts a bond further on too: on a ring the first bond
/// then comes after its neighbour at the end, and what a sweep sees is the same as if it went over
/// all bonds alone.
struct Pass<'a, const M: usize, const S: usize> {
    stretch: Stretch<'a, M, S>,
    /// Room for panels that are replaced.
    old: &'a mut Panels<M, S>,
    frames: &'a Frames<'a, M, S>,
    goal: &'a Goal,
    levels: RangeInclusive<usize>,
}

/// What a pass did.
#[derive(Clone, Copy, Debug, Default)]
struct Passed {
    /// The last level on which a bond had something to do; zero if none had.
    deepest: usize,
    /// What it cost, see [`BOND`].
    work: u64,
    /// A bond whose impulse is no number, and that.
    failure: Option<(usize, f64)>,
}

impl<const M: usize, const S: usize> Kernel for Pass<'_, M, S> {
    type Output = Passed;

    #[inline(always)]
    fn run(mut self) -> Passed {
        let (n, from, to) = (self.stretch.bonds.len(), *self.levels.start(), *self.levels.end());
        let mut passed = Passed::default();
        for place in 0..n + 2 * to {
            // Those that have begun and are not done: 2 level <= place < n + 2 level.
            let first = from.max((place + 2).saturating_sub(n) / 2);
            let last = to.min(place / 2);
            // A bond back for each level.
            let mut b = (place - first.min(place)) % n;
            for level in first..=last {
                if level == 0 {
                    self.start(b, &mut passed);
                } else if self.stretch.bonds[b].waits() {
                    self.sweep(b, level, &mut passed);
                }
                b = if b == 0 { n - 1 } else { b - 1 };
            }
        }
        passed
    }
}

impl<const M: usize, const S: usize> Pass<'_, M, S> {
    /// Lays out the panels of a bond and takes forces from the prediction.
    #[inline(always)]
    fn start(&mut self, b: usize, passed: &mut Passed) {
        let (me, beside) = self.stretch.at(b);
        let frame = &self.frames.of(me.initial.bond);
        me.lay_out(frame, beside, self.old);
        me.start(frame, beside);
        me.pending.sweep = true;
        passed.work += LAYOUT * me.panels.len as u64;
    }

    /// Sweeps a bond if it has something to do, and tells its neighbours what changed.
    #[inline(always)]
    fn sweep(&mut self, b: usize, level: usize, passed: &mut Passed) {
        let Self { frames, goal, .. } = *self;
        let (me, beside) = self.stretch.at(b);
        let frame = &frames.of(me.initial.bond);
        let anew = me.pending.layout;
        // A contact that turned out to be none is swept once more, to be forgotten.
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
        me.pending.sweep = unsettled && change.impulse * me.answer(age) > goal.change || change.moved > 0.0;
        if !change.impulse.is_finite() {
            passed.failure = Some((b, change.impulse));
        }
        self.tell(b, &change, (age, unsettled));
    }

    /// What a change of one bond leaves to be done for its neighbours.
    #[inline(always)]
    fn tell(&mut self, b: usize, change: &Change, (age, unsettled): (u32, bool)) {
        let far = change.moved > self.frames.cuts.least_move_beside;
        let Stretch { bonds, ring } = &mut self.stretch;
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

/// Looks whether what was found is what there is: contacts that nobody predicted, and forces that
/// the nodes do not resolve. The last bond of which something must be done anew, if there is one.
fn unsettled<const M: usize, const S: usize>(
    stretch: &mut Stretch<'_, M, S>,
    frames: &Frames<'_, M, S>,
    goal: &Goal,
    verdict: &mut Verdict,
) -> Option<usize> {
    let mut anew = None;
    verdict.tail = 0.0;
    run::<S, _>(Judge { bonds: &mut *stretch.bonds, frames, goal });
    let per = 0.5 * frames.h * frames.h;
    for b in 0..stretch.bonds.len() {
        let (me, beside) = stretch.at(b);
        let frame = &frames.of(me.initial.bond);
        let of = |bond: Beside<M, S>| bond.map_or(0.0, |bond| bond.forecast.surprise);
        let others = Bond::driven(frame, of(beside[0]), of(beside[1]));
        let off = per * (others + me.initial.recoil * me.forecast.surprise);
        if off > me.forecast.slack || me.pending.search {
            match me.verify(frame, beside) {
                None => verdict.failure = Some((b, f64::INFINITY)),
                Some(true) => (me.pending.layout, anew) = (true, Some(b)),
                Some(false) => {}
            }
        }
        let tail = me.resolution.tail;
        verdict.tail = if tail > verdict.tail { tail } else { verdict.tail };
        if tail > 1.0 {
            me.resolution.halvings += 1;
            (me.pending.layout, anew) = (true, Some(b));
            if me.resolution.halvings > MOST_HALVINGS {
                verdict.failure = Some((b, f64::INFINITY));
            }
        }
    }
    anew.filter(|_| verdict.failure.is_none())
}
