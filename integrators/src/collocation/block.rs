//! A block: consecutive bonds that one thread solves over one window.
//!
//! A long chain is cut into blocks, so that each thread needs memory for one block only. A block
//! also solves for some bonds on either side that belong to its neighbours (halo), and discards
//! their solution. The errors at the outer ends of the halo do not reach the block's own bonds,
//! since a force acts across one bond with a factor of a few hundredths. Blocks share nothing,
//! which makes the result the same for any number of threads. A block whose sites and halo are all
//! at rest is skipped.

use super::{
    bond::{BOND, Beside, Bond, Change, Contact, LAYOUT},
    goal::Goal,
    panel::Frames,
    panels::Panels,
    predict::{Rotation, turn},
    sites::Bonds,
    system::{Links, Path, beside},
};
use crate::{
    events::Curve,
    kernel,
    real::{Kernel, Real, run_narrow},
};
use std::ops::{Range, RangeInclusive};

/// Number of bonds of a block, and number of its neighbours' bonds on either side that it solves
/// for too. 256 is chosen; 12 is held by `methods any_number_of_threads_gives_the_same_bits`, which
/// measures the momentum that blocks lose to each other.
pub(crate) const OWN: usize = 256;
pub(crate) const ALONG: usize = 12;
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
/// Panels are cut at the events of so many bonds on either side where contacts dissipate, see
/// [`look_beyond`]. Struck chains of beads that touch miss 1e-12 by 20 with 1, by 11 with 2, and
/// keep it with 3.
const FAR: usize = 3;

/// The state of the chain at the start of a window.
pub(crate) struct Start<'a, const S: usize> {
    pub(crate) links: &'a Links<S>,
    pub(crate) bonds: &'a dyn Bonds<S>,
    /// The contact that each bond is in, if it is closed.
    pub(crate) ongoing: &'a [Option<Contact>],
    /// For each bond, minus the second derivative of its overlap by a unit force in it: 2 between
    /// two sites of mass 1, 1 at a wall.
    pub(crate) mobility: &'a [f64],
    pub(crate) share: &'a Share,
}

/// The bonds of a chain that one [`Section`](super::Section) solves for, as local indices.
#[derive(Clone, Debug)]
pub struct Share {
    /// Bonds whose solution counts; blocks are counted from the first.
    pub(crate) own: Range<usize>,
    /// The own bonds, and the bonds on either side of them that blocks may solve for too.
    reach: Range<usize>,
    /// Whether these are all bonds of a ring.
    ring: bool,
    /// Index of the first own bond in the whole chain, and the number of bonds there.
    place: (usize, usize),
}

impl Share {
    /// All `bonds` bonds of a chain with ends, or of a ring.
    pub fn whole(bonds: usize, ring: bool) -> Self {
        Self { own: 0..bonds, reach: 0..bonds, ring, place: (0, bonds) }
    }

    /// A part of a chain: the `own` bonds, the own bonds with those around them that blocks may
    /// solve for too, and the index of the first own bond and the number of bonds in the whole
    /// chain.
    pub fn part(own: Range<usize>, reach: Range<usize>, place: (usize, usize)) -> Self {
        Self { own, reach, ring: false, place }
    }

    /// The own bonds, and the bonds around them that blocks may solve for too.
    pub(crate) fn reach(&self) -> Range<usize> {
        self.reach.clone()
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.own.len().div_ceil(OWN)
    }

    /// The bonds of a block whose solution counts.
    pub(crate) fn own(&self, block: usize) -> Range<usize> {
        let first = self.own.start + block * OWN;
        first..self.own.end.min(first + OWN)
    }

    /// The index in the whole chain of a local bond.
    fn number(&self, bond: usize) -> usize {
        let (first, all) = self.place;
        (first + all + bond - self.own.start) % all
    }

    /// The first bond that a block with these own bonds solves for, and their number. On a ring the
    /// first bond follows the last.
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

/// The result of a window for one bond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Left<const S: usize> {
    /// The paths by the bond's force in the window, on each side of the bond.
    pub(crate) path: [Path; S],
    /// The contact that the bond is in at the window's end.
    pub(crate) ongoing: Option<Contact>,
    /// Energies by which the ledger grows, of the sites that are assigned to this bond.
    pub(crate) ledger: Path,
}

impl<const S: usize> Left<S> {
    /// No force, no contact, no energy.
    pub(crate) const NONE: Self = Self { path: [[0.0; 4]; S], ongoing: None, ledger: [0.0; 4] };
}

/// A part of a contact within one step; the pieces of a contact come in order of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The bond.
    pub bond: usize,
    /// Zero of the overlap with which the piece begins, if it begins with one: time since the start
    /// of the step, and `dg/dt` (to six digits and more).
    pub onset: Option<(f64, f64)>,
    /// Zero of the overlap with which the piece ends, if it ends with one: time since the start of
    /// the step, and `dg/dt`.
    pub release: Option<(f64, f64)>,
    /// Impulse `int f dt` of the piece.
    pub impulse: f64,
    /// The overlap as a function of time; `None` for a piece without a length in time.
    pub curve: Option<Curve>,
}

/// The outcome of solving a window: its cost, its resolution, and whether it failed.
#[derive(Clone, Copy, Debug, Default)]
pub struct WindowOutcome {
    /// Number of sweeps; the largest number of a block.
    pub(crate) sweeps: u64,
    /// Cost, in the units of [`BOND`].
    pub(crate) work: u64,
    /// The largest stiffness `f'(g) h^2/m` of a bond.
    pub(crate) stiffness: f64,
    /// The largest last terms of a series over those allowed; at most 1 if the window is solved.
    pub(crate) tail: f64,
    /// Number of bonds with a contact, and of bonds whose panels were halved.
    pub(crate) touching: usize,
    pub(crate) halved: usize,
    /// If the window was given up: a bond and its residual, which is the last change of its
    /// impulse, its stiffness if this is above the limit, or infinity.
    pub(crate) failure: Option<(usize, f64)>,
}

impl WindowOutcome {
    /// The verdict of two groups of bonds, `other` after `self`. Only sums of integers and maxima
    /// are taken, so that the result does not depend on how bonds are grouped.
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

    /// Adds the numbers of bonds with contacts and with halved panels, and their largest stiffness.
    fn count<const M: usize, const S: usize>(&mut self, bonds: &[Bond<M, S>]) {
        for bond in bonds {
            self.touching += usize::from(!bond.contacts.found.is_empty());
            self.halved += usize::from(bond.resolution.halvings > 0);
            self.stiffness = bond.sweeps.stiffness.max(self.stiffness);
        }
    }
}

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
        let (links, all, share) = (start.links, start.links.bonds, start.share);
        let whole = own.len() == share.reach.len();
        // Local index i stands for bond (first + i) mod all.
        let (first, len) = share.along(&own);
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
                failure: Some((share.number(first + b), stiffness)),
                work: BOND * len as u64,
                ..WindowOutcome::default()
            };
        }
        let ring = whole && share.ring && all > 1;
        let mut verdict =
            Work { interval: Interval { bonds: &mut *bonds, ring }, old: &mut self.old, frames, goal }.run();
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
                log_contacts(share, frames, (&*bonds, i, ring), &mut self.pieces);
            }
        }
        verdict
    }
}

/// Appends the pieces of the contacts of bond `i` of a block.
fn log_contacts<const M: usize, const S: usize>(
    share: &Share,
    frames: &Frames<'_, M, S>,
    (bonds, i, ring): (&[Bond<M, S>], usize, bool),
    pieces: &mut Vec<Piece>,
) {
    let bond = &bonds[i];
    let beside = beside(i, bonds.len(), ring).map(|i| i.map(|i| &bonds[i]));
    bond.pieces((&frames.of(bond.initial.bond), share.number(bond.initial.bond)), beside, pieces);
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

/// Runs a kernel of the solver. For `S = 2` AVX-512 is left out: it would gain 4 % at most (50
/// sites, tolerances from 1e-4 to 1e-11), and take a fifth of the program's time to compile.
#[inline(always)]
pub(super) fn run<const S: usize, K: Kernel>(kernel: K) -> K::Output {
    if const { S == 1 } { f64::run(kernel) } else { run_narrow(kernel) }
}

/// Runs a kernel that another kernel calls, for `S = 2`. It is not inlined, so that there is less
/// to compile.
#[inline(never)]
pub(super) fn apart<K: Kernel>(kernel: K) -> K::Output {
    run_narrow(kernel)
}

/// Lists the contacts beyond the neighbours of a bond at whose ends its panels are cut too, for
/// contacts that dissipate.
///
/// A force that begins with the power `p` of time, 1/2 or 0, adds the power `p + 1` to the rate of
/// the next overlap and, by its resistance, to the next force: one power more from bond to bond.
/// Elastic contacts have two powers more, and begin with 3/2.
pub(super) fn look_beyond<const M: usize, const S: usize>(bonds: &mut [Bond<M, S>], b: usize, ring: bool) {
    let mut found = std::mem::take(&mut bonds[b].contacts.beyond);
    found.clear();
    for side in [0, 1] {
        let next = |b: usize| beside(b, bonds.len(), ring)[side];
        let mut at = next(b);
        for _ in 1..FAR {
            at = at.and_then(next);
            let Some(bond) = at.map(|at| &bonds[at]) else { break };
            found.extend(bond.contacts.found.iter().map(|&contact| (contact, bond.singular_after())));
        }
    }
    bonds[b].contacts.beyond = found;
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

/// The bonds of a block over a window, from the prediction to a verdict.
struct Work<'a, const M: usize, const S: usize> {
    interval: Interval<'a, M, S>,
    old: &'a mut Panels<M, S>,
    frames: &'a Frames<'a, M, S>,
    goal: &'a Goal,
}

impl<const M: usize, const S: usize> Work<'_, M, S> {
    fn run(self) -> WindowOutcome {
        let Self { mut interval, old, frames, goal } = self;
        let mut verdict = WindowOutcome::default();
        let bonds = interval.again();
        if !run::<S, _>(kernel!(predict(bonds, frames))) {
            verdict.failure = Some((0, f64::INFINITY));
            return verdict;
        }
        let mut levels = 0..=LEVELS;
        let mut rounds = 0;
        loop {
            let done = run::<S, _>(Pass { interval: interval.again(), old: &mut *old, frames, goal, levels });
            levels = 1..=1;
            verdict.sweeps += done.deepest as u64;
            verdict.work += done.work;
            verdict.failure = done.failure;
            if verdict.failure.is_some() {
                return verdict;
            }
            if done.deepest == 0 {
                let Some(b) = unsettled(&mut interval, frames, goal, &mut verdict) else { return verdict };
                rounds += 1;
                if rounds > MOST_ROUNDS {
                    verdict.failure = Some((b, f64::INFINITY));
                    return verdict;
                }
            } else if verdict.sweeps >= MOST_SWEEPS {
                verdict.failure = busiest(interval.bonds);
                return verdict;
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
        // not resolve the force. A force that jumps shows the error of its event at first order.
        let unsure = anew && frame.link.lossy() && me.resolution.halvings > 0;
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
        let far = change.moved > self.frames.cuts.least_move_beside;
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
    verdict: &mut WindowOutcome,
) -> Option<usize> {
    let mut anew = None;
    verdict.tail = 0.0;
    let bonds = &mut *interval.bonds;
    run::<S, _>(kernel!(judge(bonds, frames, goal)));
    let per = 0.5 * frames.h * frames.h;
    for b in 0..interval.bonds.len() {
        let (me, beside) = interval.at(b);
        let frame = &frames.of(me.initial.bond);
        let of = |bond: Beside<M, S>| bond.map_or(0.0, |bond| bond.prediction.predictor_error);
        let others = Bond::driven(frame, of(beside[0]), of(beside[1]));
        let off = per * (others + me.initial.mobility * me.prediction.predictor_error);
        if off > me.prediction.margin || me.pending.search || me.pending.diverged {
            match me.verify(frame, beside) {
                None => verdict.failure = Some((b, f64::INFINITY)),
                Some(true) => {
                    (me.pending.layout, anew) = (true, Some(b));
                    // As where an event moves far, see [`Pass::tell`].
                    for side in super::system::beside(b, interval.bonds.len(), interval.ring).into_iter().flatten() {
                        let other = &mut interval.bonds[side];
                        other.pending.layout |= frames.links.lossy() && !other.contacts.found.is_empty();
                    }
                }
                Some(false) => {}
            }
        }
        let me = &mut interval.bonds[b];
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
