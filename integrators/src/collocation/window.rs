//! A window: the bonds that are solved for together, what is given and what comes out.

use super::{
    bond::{Bond, Contact},
    chain::Path,
    goal::Goal,
    link::Links,
    sites::Bonds,
};
use crate::events::Curve;
use std::ops::Range;

/// A window to be solved.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Length, a time.
    pub(crate) h: f64,
    /// Nodes a panel.
    pub(crate) nodes: usize,
    /// Whether to keep a [`Piece`] for each panel.
    pub(crate) log: bool,
    pub(crate) goal: Goal,
}

/// Number of bonds of a block, and number of its neighbours' bonds on either side that it solves
/// for too. 256 is chosen; 12 is held by `methods any_number_of_threads_gives_the_same_bits`, which
/// measures the momentum that blocks lose to each other.
pub(crate) const OWN: usize = 256;
pub(crate) const ALONG: usize = 12;

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
    /// For each [group](Share::group), whether anything moves in it or beside it.
    pub(crate) near: &'a [bool],
}

/// The bonds of a chain that one [`Section`](super::Section) solves for, as local indices.
#[derive(Clone, Debug)]
pub struct Share {
    /// Bonds whose solution counts; blocks are counted from the first.
    pub(crate) own: Range<usize>,
    /// The own bonds, and the bonds on either side of them that blocks may solve for too.
    pub(super) reach: Range<usize>,
    /// Whether these are all bonds of a ring.
    pub(super) ring: bool,
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

    /// The indices, below `count`, of a group of bonds or sites: of [`OWN`], so that each block is
    /// a group. The first group is before the own bonds.
    pub(crate) fn group(&self, group: usize, count: usize) -> Range<usize> {
        let start = |group: usize| (self.own.start + group * OWN).saturating_sub(OWN).min(count);
        start(group)..start(group + 1)
    }

    /// The group of an index.
    pub(crate) fn group_of(&self, index: usize) -> usize {
        (index + OWN - self.own.start) / OWN
    }

    /// The number of groups of indices below `count`.
    pub(crate) fn groups(&self, count: usize) -> usize {
        (count + OWN - self.own.start).div_ceil(OWN)
    }

    /// The index in the whole chain of a local bond.
    pub(super) fn number(&self, bond: usize) -> usize {
        let (first, all) = self.place;
        (first + all + bond - self.own.start) % all
    }

    /// The first bond that a block with these own bonds solves for, and their number. On a ring the
    /// first bond follows the last.
    pub(super) fn along(&self, own: &Range<usize>) -> (usize, usize) {
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
    /// Cost, in the units of [`BOND`](super::sweep::BOND).
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
    /// The outcome of two groups of bonds, `other` after `self`. Only sums of integers and maxima
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
    pub(super) fn count<const M: usize, const S: usize>(&mut self, bonds: &[Bond<M, S>]) {
        for bond in bonds {
            self.touching += usize::from(!bond.contacts.found.is_empty());
            self.halved += usize::from(bond.resolution.halvings > 0);
            self.stiffness = bond.sweeps.stiffness.max(self.stiffness);
        }
    }
}

/// Solves windows of given lengths and keeps the state of the chain: in one place, or in parts of
/// the chain on other threads or processes.
pub trait Windows: Send + Sized {
    /// Number of components of the state.
    fn dim(&self) -> usize;
    /// Two bounds for the length of the next window: the time until the signal of a drive is not
    /// smooth, and the longest time over which the series of damped sites are resolved.
    fn longest(&self) -> [f64; 2] {
        [f64::INFINITY; 2]
    }
    /// Prepares what drives do in the next window, of length `h`. Returns a shorter length if their
    /// series are not resolved to the tolerance `tol`, else infinity.
    fn predict_drives(&mut self, _h: f64, _tol: f64) -> f64 {
        f64::INFINITY
    }
    /// Solves the window that begins at the current state; the state stays there.
    fn solve(&mut self, window: &Window) -> WindowOutcome;
    /// Moves the state to the end of the window that was solved last.
    fn advance(&mut self);
    /// A copy in the same state.
    fn duplicate(&self) -> Self;
    /// Takes the state of `other`, which is of the same chain, and the window that it solved last.
    fn copy_from(&mut self, other: &Self);
    /// Writes the current state into `y`.
    fn store(&self, y: &mut [f64]);
    /// Calls `told` with every [`Piece`] of the window that was solved last, in the order of bonds,
    /// if the window was logged.
    fn tell(&self, told: &mut dyn FnMut(&Piece));
}
