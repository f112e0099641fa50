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
pub(crate) struct Window {
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
    pub(crate) blocks: Blocks,
    /// For each [group], whether anything moves in it or beside it.
    pub(crate) near: &'a [bool],
}

/// The bonds of a chain, in blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks {
    pub(crate) bonds: usize,
    pub(crate) ring: bool,
}

impl Blocks {
    /// Number of blocks.
    pub(crate) fn count(self) -> usize {
        self.bonds.div_ceil(OWN)
    }

    /// The bonds of a block whose solution counts.
    pub(crate) fn own(self, block: usize) -> Range<usize> {
        group(block, self.bonds)
    }

    /// The first bond that a block with these own bonds solves for, and their number. On a ring the
    /// first bond follows the last.
    pub(super) fn along(self, own: &Range<usize>) -> (usize, usize) {
        if own.len() == self.bonds {
            (0, own.len())
        } else if self.ring {
            ((own.start + self.bonds - ALONG) % self.bonds, own.len() + 2 * ALONG)
        } else {
            let first = own.start.saturating_sub(ALONG);
            (first, (own.end + ALONG).min(self.bonds) - first)
        }
    }
}

/// The indices, below `count`, of a group of bonds or sites: of [`OWN`], so that each block is a
/// group.
pub(crate) fn group(group: usize, count: usize) -> Range<usize> {
    (group * OWN).min(count)..((group + 1) * OWN).min(count)
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
    /// Time and value of the largest overlap.
    pub largest: (f64, f64),
    /// Error of a largest overlap inside a window of collocation, relative to the size of positions;
    /// zero at the ends of a window, and for other methods.
    pub error: f64,
    /// Time and value of the largest force, of a contact that dissipates; zero of others.
    pub peak: (f64, f64),
    /// The overlap as a function of time; `None` for a piece without a length in time.
    pub curve: Option<Curve>,
}

/// The outcome of solving a window: its cost, its resolution, and whether it failed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WindowOutcome {
    /// Number of sweeps; the largest number of a block.
    pub(crate) sweeps: u64,
    /// Cost, in the units of [`BOND`](super::sweep::BOND).
    pub(crate) work: u64,
    /// The largest stiffness `f'(g) h^2/m` of a bond.
    pub(crate) stiffness: f64,
    /// The largest last terms of a series over those allowed; at most 1 if the window is solved.
    pub(crate) tail: f64,
    /// Number of bonds that are open at some time in the window.
    pub(crate) open: usize,
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
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            sweeps: self.sweeps.max(other.sweeps),
            work: self.work + other.work,
            stiffness: self.stiffness.max(other.stiffness),
            tail: self.tail.max(other.tail),
            open: self.open + other.open,
            touching: self.touching + other.touching,
            halved: self.halved + other.halved,
            failure: self.failure.or(other.failure),
        }
    }

    /// Adds what the bonds say of a window of length `h`.
    pub(super) fn count<const M: usize, const S: usize>(&mut self, bonds: &[Bond<M, S>], h: f64) {
        for bond in bonds {
            self.tail = bond.resolution.tail.max(self.tail);
            let closed =
                matches!(bond.contacts.found[..], [Contact { onset, release, .. }] if onset <= 0.0 && release >= h);
            self.open += usize::from(!closed);
            self.touching += usize::from(!bond.contacts.found.is_empty());
            self.halved += usize::from(bond.resolution.halvings > 0);
            self.stiffness = bond.sweeps.stiffness.max(self.stiffness);
        }
    }
}
