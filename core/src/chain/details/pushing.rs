//! Which contacts push, as told by a method that stops at events.

use super::super::Chain;
use hertzchain_integrators::Real;

/// The contacts that push, told by the signs of the functions of
/// [`Overlaps::with_pushes`](super::super::Overlaps::with_pushes).
///
/// A contact pushes where its overlap is positive and, if it dissipates, the function that is
/// positive where it pushes is positive, too. Signs that are told, and not computed, keep force and
/// stiffness smooth up to an event and from there on: at the event itself the value is zero up to
/// rounding, of either sign. The stiffness of an overlap of 1e-17 is no rounding: after a release
/// it would carry 1e-11 of the first stage of a step into columns.
#[derive(Clone, Debug)]
pub(crate) struct Pushing {
    /// The first bond that can touch, and the number of these.
    first: usize,
    count: usize,
    /// Bonds that dissipate, in the order of their functions.
    lossy: Vec<usize>,
    /// For each bond: whether the overlap is positive, and the other function; bonds that do not
    /// dissipate have none, which counts as positive.
    signs: Vec<[bool; 2]>,
}

/// A contact that begins or ceases to push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Switched {
    pub(crate) bond: usize,
    /// Whether it pushes from here on.
    pub(crate) pushes: bool,
    /// Whether beads meet or part, so that the overlap is zero.
    pub(crate) meeting: bool,
}

impl Pushing {
    /// Of no contact, until it is told.
    pub(crate) fn new<R: Real>(chain: &Chain<R>) -> Self {
        let (bonds, lossy) = (chain.touching(), chain.lossy());
        let mut signs = vec![[false, true]; bonds.end];
        lossy.iter().for_each(|&bond| signs[bond] = [false; 2]);
        Self { first: bonds.start, count: bonds.len(), lossy, signs }
    }

    /// Whether the contact of a bond pushes.
    pub(crate) fn pushes(&self, bond: usize) -> bool {
        self.signs[bond] == [true; 2]
    }

    /// Bonds that dissipate.
    pub(crate) fn lossy(&self) -> &[usize] {
        &self.lossy
    }

    /// Bonds that dissipate and push.
    pub(crate) fn bonds(&self) -> impl Iterator<Item = usize> + '_ {
        self.lossy.iter().copied().filter(|&bond| self.pushes(bond))
    }

    /// Takes the sign of function `index`. `None` if no contact begins or ceases to push by it.
    pub(crate) fn turn(&mut self, index: usize, positive: bool) -> Option<Switched> {
        let (bond, which) = match index.checked_sub(self.count) {
            None => (self.first + index, 0),
            Some(k) => (self.lossy[k], 1),
        };
        let before = self.pushes(bond);
        self.signs[bond][which] = positive;
        let pushes = self.pushes(bond);
        (pushes != before).then_some(Switched { bond, pushes, meeting: which == 0 })
    }
}
