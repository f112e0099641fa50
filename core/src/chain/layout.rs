//! The places of the parts of a state: the arrays of all sites, and the ledger after them.

use hertzchain_integrators::Real;

/// Number of entries of a ledger.
pub(crate) const LEDGER: usize = 4;

/// The places of the arrays of a state: `[u, v, u', v']`, or `[u, u']` without moving resonators.
///
/// On a strain ring read `x, y` for `u, v`. Velocities, not momenta: `p_u = u'`, `p_v = rho v'`.
/// The state of a chain that dissipates or is driven ends with its [`Ledger`](super::Ledger).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    sites: usize,
    resonators: bool,
    ledger: bool,
}

impl Layout {
    pub(crate) fn new(sites: usize, resonators: bool) -> Self {
        Self { sites, resonators, ledger: false }
    }

    pub(crate) fn with_ledger(self, ledger: bool) -> Self {
        Self { ledger, ..self }
    }

    /// Whether a state has a ledger at its end.
    pub fn has_ledger(self) -> bool {
        self.ledger
    }

    /// Number of positions, which is also the number of velocities.
    pub fn half(self) -> usize {
        if self.resonators { 2 * self.sites } else { self.sites }
    }

    /// Number of sites.
    pub fn sites(self) -> usize {
        self.sites
    }

    /// Whether resonators move.
    pub fn resonators(self) -> bool {
        self.resonators
    }

    /// Number of entries of a state.
    pub fn dim(self) -> usize {
        2 * self.half() + if self.ledger { LEDGER } else { 0 }
    }

    /// Displacements of the beads (strains, on a strain ring).
    pub fn u<R>(self, y: &[R]) -> &[R] {
        &y[..self.sites]
    }

    /// Displacements of the resonators, if they move.
    pub fn v<R>(self, y: &[R]) -> Option<&[R]> {
        self.resonators.then(|| &y[self.sites..2 * self.sites])
    }

    /// Velocities of the beads.
    pub fn u_dot<R>(self, y: &[R]) -> &[R] {
        let start = self.half();
        &y[start..start + self.sites]
    }

    /// Velocities of the resonators, if they move.
    pub fn v_dot<R>(self, y: &[R]) -> Option<&[R]> {
        self.resonators.then(|| &y[3 * self.sites..4 * self.sites])
    }

    /// The arrays `[u, v, u', v']`; `v` and `v'` are empty unless resonators move.
    pub fn arrays<R>(self, y: &[R]) -> [&[R]; 4] {
        let none = &y[..0];
        [self.u(y), self.v(y).unwrap_or(none), self.u_dot(y), self.v_dot(y).unwrap_or(none)]
    }

    /// Index in the whole state of a site's entry in the array `[u, v, u', v'][array]`.
    pub fn entry(self, array: usize, site: usize) -> usize {
        [0, self.sites, self.half(), self.half() + self.sites][array] + site
    }

    /// The arrays `[u, v, u', v']`, to be changed.
    pub fn arrays_mut<R>(self, y: &mut [R]) -> [&mut [R]; 4] {
        let (positions, velocities) = y.split_at_mut(self.dim() / 2);
        let ((u, v), (u_dot, v_dot)) = (positions.split_at_mut(self.sites), velocities.split_at_mut(self.sites));
        [u, v, u_dot, v_dot]
    }

    /// The ledger of a state, if its chain is open.
    pub fn ledger<R: Real>(self, y: &[R]) -> Option<Ledger<R>> {
        self.has_ledger().then(|| Ledger::of(&y[2 * self.half()..]))
    }
}

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
