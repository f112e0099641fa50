//! Chains abreast: one in each lane of a register.
//!
//! The sites of a chain alone fill the lanes, and all have its parameters. Chains abreast have a
//! lane each, with parameters of their own: all but the exponent, the boundary and the kind of
//! resonators, for which kernels are compiled. No lane sees another one, and each number is
//! computed as in a chain alone, so that the bits are the same.

use super::{Chain, rows::SHORT};
pub(crate) use hertzchain_integrators::lanes::Coefficient;
use hertzchain_integrators::{Real, Vector, with_registers};

impl Chain<f64> {
    /// The largest number of such chains that are moved abreast: that of the lanes of the
    /// instructions in use; one for a chain with details, or with so many sites that columns do not
    /// stay in the nearest cache. Timed with AVX-512 (least of seven samples), a chain abreast takes
    /// 0.43 of the time of one alone with 16 sites, 0.78 with 50, 0.95 with 200, 1.03 with 400.
    pub(crate) fn most_abreast(&self) -> usize {
        let lanes = with_registers!(V => V::LANES);
        if self.details().is_none() && self.sites() * lanes <= SHORT / 8 { lanes } else { 1 }
    }

    /// Chains abreast: number `i` of member `m` is number `i lanes + m`.
    ///
    /// # Panics
    /// More than [`most_abreast`](Self::most_abreast).
    pub(crate) fn abreast(members: Vec<Self>) -> Self {
        let (first, lanes) = (&members[0], with_registers!(V => V::LANES));
        assert!(members.len() <= first.most_abreast(), "more chains than can be moved together");
        let all = first.with_sites(first.boundary(), lanes * first.sites());
        Self { members, ..all }
    }
}

impl<R: Real> Chain<R> {
    /// Distance of the numbers of neighbouring sites in columns.
    #[inline(always)]
    pub(super) fn stride<K: Coefficient<R>>(&self) -> usize {
        if K::EACH { self.sites() / self.members[0].sites() } else { 1 }
    }

    /// The chain of a lane; lanes without a member are like the last one.
    pub(super) fn member(&self, lane: usize) -> &Self {
        self.members.get(lane).or(self.members.last()).unwrap_or(self)
    }

    /// Number of components of the states of all members, one after the other.
    pub(super) fn full_dim(&self) -> usize {
        self.members.len().max(1) * self.member(0).layout.dim()
    }
}
