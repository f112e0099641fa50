//! What was dissipated and driven since the start, at the end of a state.

use super::super::Layout;
use hertzchain_integrators::Real;

/// Number of entries.
pub(crate) const LEDGER: usize = 4;

/// Work that has left a chain and that drives have put in, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger<R> {
    /// Dissipated by drag on beads.
    pub drag: R,
    /// Dissipated by dashpots of resonators.
    pub dashpots: R,
    /// Dissipated by contacts.
    pub contacts: R,
    /// Put in by drives.
    pub driven: R,
}

impl<R: Real> Ledger<R> {
    /// All that was dissipated.
    pub fn dissipated(&self) -> R {
        self.drag + self.dashpots + self.contacts
    }

    pub(crate) fn of(entries: &[R]) -> Self {
        Self { drag: entries[0], dashpots: entries[1], contacts: entries[2], driven: entries[3] }
    }

    pub(crate) fn entries(&self) -> [R; LEDGER] {
        [self.drag, self.dashpots, self.contacts, self.driven]
    }
}

impl Layout {
    /// The ledger of a state, if its chain is open.
    pub fn ledger<R: Real>(self, y: &[R]) -> Option<Ledger<R>> {
        self.has_ledger().then(|| Ledger::of(&y[2 * self.half()..]))
    }
}
