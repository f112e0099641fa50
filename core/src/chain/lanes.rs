//! Chains with details abreast: one such chain, whose beads and bonds are those of the members in
//! turn, and whose neighbours are as many numbers apart as there are members. No member sees another
//! one, and each number is computed as in a chain alone, so that the bits are the same.

use super::{Chain, details::CheckedDetails, rows::SHORT};
use hertzchain_integrators::{Real, Vector, with_registers};
use std::sync::Arc;

impl Chain<f64> {
    /// The largest number of such chains that are moved abreast: that of the lanes of the
    /// instructions in use; one for a chain without details, or with so many sites that columns do
    /// not stay in the nearest cache. Timed with AVX-512 (least of seven runs of 16 rings whose
    /// masses differ), one abreast takes 0.28 of the time of one alone with 10 sites, 0.36 with 20,
    /// 0.47 with 32, 0.53 with 50, 0.68 with 100, 0.88 with 200.
    pub(crate) fn most_abreast(&self) -> usize {
        let lanes = with_registers!(V => V::LANES);
        if self.details.is_some() && self.sites() * lanes <= SHORT / 8 { lanes } else { 1 }
    }

    /// What chains with details must have in common to be moved abreast.
    pub(crate) fn kind(&self) -> impl PartialEq + '_ {
        let parts = self.parts().zip(self.details());
        (self.topology, self.layout, parts.map(|(parts, given)| (parts.joined(), &given.terms, given.gravity)))
    }

    /// Chains with details abreast: number `i` of member `m` is number `i members + m`.
    ///
    /// # Panics
    /// More than [`most_abreast`](Self::most_abreast).
    pub(crate) fn abreast(members: Vec<Self>) -> Self {
        let (first, count) = (&members[0], members.len());
        assert!(count <= first.most_abreast(), "more chains than can be moved together");
        let parts: Vec<_> = members.iter().filter_map(Self::parts).collect();
        let details = Some(Arc::new(CheckedDetails::abreast(&parts)));
        let all = first.with_sites(first.boundary(), first.sites() * count);
        Self { details, members, ..all }
    }
}

impl<R: Real> Chain<R> {
    /// A member; the chain itself, if it is alone.
    pub(super) fn member(&self, number: usize) -> &Self {
        self.members.get(number).unwrap_or(self)
    }

    /// The number of members; 1 of a chain alone.
    pub(super) fn count(&self) -> usize {
        self.members.len().max(1)
    }

    /// Number of components of the states of all members, one after the other.
    pub(super) fn full_dim(&self) -> usize {
        self.count() * self.member(0).layout.dim()
    }
}
