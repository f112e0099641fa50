//! The ledger, at the end of a state: energies dissipated and work of drives since the start.

use super::super::Layout;
use hertzchain_integrators::Real;

/// Number of entries of a ledger.
pub(crate) const LEDGER: usize = 4;

/// Energies that a chain has dissipated and the work that drives have done on it, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger<R> {
    /// Energy dissipated by drag on beads.
    pub drag: R,
    /// Energy dissipated by dashpots of resonators.
    pub dashpots: R,
    /// Energy dissipated by contacts.
    pub contacts: R,
    /// Work of drives.
    pub driven: R,
}

impl<R: Real> Ledger<R> {
    /// Energy dissipated in all.
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
