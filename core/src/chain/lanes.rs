//! Chains abreast: one in each lane of a register.
//!
//! The sites of a chain alone fill the lanes, and all have its parameters. Chains abreast have a
//! lane each, with parameters of their own: all but the exponent, the boundary and the kind of
//! resonators, for which kernels are compiled. No lane sees another one, and each number is
//! computed as in a chain alone, so that the bits are the same.
//!
//! Chains with [details](super::Details) abreast are one such chain, whose beads and bonds are
//! those of the members in turn, and whose neighbours are as many numbers apart as there are
//! members.

use super::{Chain, details::CheckedDetails, rows::SHORT};
pub(crate) use hertzchain_integrators::lanes::Coefficient;
use hertzchain_integrators::{Real, Vector, with_registers};
use std::sync::Arc;

impl Chain<f64> {
    /// The largest number of such chains that are moved abreast: that of the lanes of the
    /// instructions in use; one for a chain with so many sites that columns do not stay in the
    /// nearest cache. Timed with AVX-512 (least of seven samples), an equal chain abreast takes
    /// 0.43 of the time of one alone with 16 sites, 0.78 with 50, 0.95 with 200, 1.03 with 400; one
    /// with details as long as alone with 256.
    pub(crate) fn most_abreast(&self) -> usize {
        let lanes = with_registers!(V => V::LANES);
        if self.sites() * lanes <= SHORT / 8 { lanes } else { 1 }
    }

    /// What chains must have in common to be moved abreast.
    pub(crate) fn kind(&self) -> impl PartialEq + '_ {
        let equal_beads = (self.params.alpha, self.params.resonators());
        let parts = self.parts().zip(self.details());
        let details = parts.map(|(parts, given)| (parts.joined(), &given.terms, given.gravity));
        (self.topology, self.layout, details.ok_or(equal_beads))
    }

    /// Chains abreast: number `i` of member `m` is number `i lanes + m`.
    ///
    /// # Panics
    /// More than [`most_abreast`](Self::most_abreast).
    pub(crate) fn abreast(members: Vec<Self>) -> Self {
        let (first, lanes) = (&members[0], with_registers!(V => V::LANES));
        assert!(members.len() <= first.most_abreast(), "more chains than can be moved together");
        let parts: Option<Vec<_>> = members.iter().map(Self::parts).collect();
        let details = parts.map(|parts| Arc::new(CheckedDetails::abreast(&parts)));
        let topology = first.topology.abreast(details.as_ref().map_or(lanes, |_| members.len()));
        let all = first.with_sites(first.boundary(), topology.sites());
        Self { topology, members, details, ..all }
    }
}

impl<R: Real> Chain<R> {
    /// Distance of the numbers of neighbouring sites in columns.
    #[inline(always)]
    pub(super) fn stride<K: Coefficient<R>>(&self) -> usize {
        if K::EACH { self.topology.apart() } else { 1 }
    }

    /// The chain of a lane; lanes without a member are like the last one.
    pub(super) fn member(&self, lane: usize) -> &Self {
        self.members.get(lane).or(self.members.last()).unwrap_or(self)
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
