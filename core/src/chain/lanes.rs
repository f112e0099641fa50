//! Chains abreast: one chain, whose beads and bonds are those of the members in turn, and whose
//! neighbours are as many numbers apart as there are members. No member sees another one, and each
//! number is computed as in a chain alone, so that the bits are the same. Members with details may
//! differ in them; uniform ones have the same parameters, and as many as a register has lanes.

use super::{Chain, details::CheckedDetails, rows::SHORT};
use hertzchain_integrators::{Real, Vector, law::Exponent, with_registers};
use std::{ops::RangeInclusive, sync::Arc};

impl Chain<f64> {
    /// The numbers of such chains that are moved abreast: up to that of the lanes of the
    /// instructions in use, of uniform ones more than half of it; one for a uniform chain of
    /// another exponent than 3/2, or with so many sites that columns do not stay in the nearest
    /// cache. Timed with AVX-512 (least of seven runs of 16 rings whose masses differ), one abreast
    /// takes 0.28 of the time of one alone with 10 sites, 0.53 with 50, 0.68 with 100.
    pub(crate) fn abreast_at_once(&self) -> RangeInclusive<usize> {
        let lanes = with_registers!(V => V::LANES);
        let least = if self.details.is_some() { 1 } else { lanes / 2 + 1 };
        let hertz = self.details.is_some() || self.law.exponent() == Exponent::ThreeHalves;
        if hertz && self.sites() * lanes <= SHORT / 8 { least..=lanes } else { 1..=1 }
    }

    /// What chains must have in common to be moved abreast.
    pub(crate) fn kind(&self) -> impl PartialEq + '_ {
        let parts = self.parts().zip(self.details());
        let details = parts.map(|(parts, given)| (parts.joined(), &given.terms, given.gravity));
        (self.topology, self.layout, details.ok_or((self.params, self.precompression)))
    }

    /// Chains abreast: number `i` of member `m` is number `i members + m`. Lanes without a chain
    /// have copies of the first.
    ///
    /// # Panics
    /// More than can be moved [at once](Self::abreast_at_once).
    pub(crate) fn abreast(mut members: Vec<Self>) -> Self {
        let (first, most) = (members[0].clone(), *members[0].abreast_at_once().end());
        assert!(members.len() <= most, "more chains than can be moved together");
        let parts: Option<Vec<_>> = members.iter().map(Self::parts).collect();
        let details = parts.map(|parts| Arc::new(CheckedDetails::abreast(&parts)));
        members.resize(if details.is_some() { members.len() } else { most }, first.clone());
        let all = first.with_sites(first.boundary(), first.sites() * members.len());
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
    pub(crate) fn full_dim(&self) -> usize {
        self.count() * self.member(0).layout.dim()
    }
}
