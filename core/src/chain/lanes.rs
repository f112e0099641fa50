//! Chains abreast: one in each lane of a register.
//!
//! The sites of a chain alone fill the lanes, and all have its parameters. Chains abreast have a
//! lane each, with parameters of their own: all but the exponent, the boundary and the kind of
//! resonators, for which kernels are compiled. No lane sees another one, and each number is computed
//! as in a chain alone, so that the bits are the same.

use super::{Chain, rows::SHORT};
pub(crate) use hertzchain_integrators::lanes::{Coefficient, Each};
use hertzchain_integrators::{Real, Vector, with_registers};

impl Chain<f64> {
    /// The largest number of such chains that can be moved abreast: that of the lanes of the
    /// instructions in use; one for a chain with details, or with so many sites that columns do not
    /// stay in the cache.
    pub(crate) fn most_abreast(&self) -> usize {
        let lanes = with_registers!(V => V::LANES);
        if self.details().is_none() && self.sites() * lanes <= SHORT { lanes } else { 1 }
    }

    /// Chains abreast: number `i` of member `m` is number `i lanes + m`.
    ///
    /// # Panics
    /// More than [`most_abreast`](Self::most_abreast).
    pub(super) fn abreast(members: &[Self]) -> Self {
        let (first, lanes) = (&members[0], with_registers!(V => V::LANES));
        assert!(members.len() <= first.most_abreast(), "more chains than can be moved together");
        Self { lanes, ..first.with_sites(first.boundary(), lanes * first.sites()) }
    }
}

impl<R: Real> Chain<R> {
    /// Distance of the numbers of neighbouring sites in columns.
    #[inline(always)]
    pub(super) fn stride<K: Coefficient<R>>(&self) -> usize {
        if K::EACH { self.lanes } else { 1 }
    }

    /// The chain of a lane; lanes without a member are like the last one. A chain alone has no
    /// members.
    pub(super) fn member<'a>(&'a self, members: &'a [Self], lane: usize) -> &'a Self {
        members.get(lane).or(members.last()).unwrap_or(self)
    }
}
