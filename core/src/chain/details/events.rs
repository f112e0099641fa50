//! The events of a chain, for methods that stop at each event: contacts close or open, and contacts
//! that dissipate begin or cease to push while beads overlap.

use super::super::{Chain, Overlaps};
use hertzchain_integrators::{EventFunctions, Real};

/// The overlaps of all bonds that can touch, then, for each bond that dissipates, a function that
/// is positive where the contact pushes.
#[derive(Clone, Debug)]
pub struct ContactEvents<R> {
    chain: Chain<R>,
    overlaps: Overlaps<R>,
    /// Bonds that dissipate.
    lossy: Vec<usize>,
}

impl<R: Real> ContactEvents<R> {
    /// The events of a chain.
    pub fn new(chain: Chain<R>) -> Self {
        Self { overlaps: Overlaps::new(chain.clone()), lossy: chain.lossy(), chain }
    }
}

impl<R: Real> EventFunctions<R> for ContactEvents<R> {
    fn count(&self) -> usize {
        self.overlaps.count() + self.lossy.len()
    }

    fn values(&self, t: R, y: &[R], g: &mut [R]) {
        let (overlaps, pushes) = g.split_at_mut(self.overlaps.count());
        self.overlaps.values(t, y, overlaps);
        let (Some(parts), layout) = (self.chain.parts(), self.chain.layout()) else { return };
        for (value, &bond) in pushes.iter_mut().zip(&self.lossy) {
            let overlap = overlaps[bond - self.chain.touching().start];
            let rate = self.chain.across(bond, |i| layout.u_dot(y)[i]);
            *value = parts.bonds[bond].pushes(overlap, rate).unwrap_or(R::zero());
        }
    }

    fn rates(&self, t: R, y: &[R], dy: &[R], rates: &mut [R]) {
        let (first, pushes) = rates.split_at_mut(self.overlaps.count());
        self.overlaps.rates(t, y, dy, first);
        let (Some(parts), layout) = (self.chain.parts(), self.chain.layout()) else { return };
        for (value, &bond) in pushes.iter_mut().zip(&self.lossy) {
            let contact = &parts.bonds[bond];
            let g = contact.rest + self.chain.across(bond, |i| layout.u(y)[i]);
            let second = self.chain.across(bond, |i| dy[layout.half() + i]);
            let rate = first[bond - self.chain.touching().start];
            *value = contact.pushes_rate(g, rate, second).unwrap_or(R::zero());
        }
    }

    fn band(&self, y: &[R]) -> R {
        self.overlaps.band(y)
    }
}
