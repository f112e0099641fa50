//! Contacts of a chain with details: their dissipation, and forces that are sums of powers of the
//! overlap or go through the rows of a table.

pub use hertzchain_integrators::law::Kind;

use super::Table;
use hertzchain_integrators::{Real, law::BondLaw};
use std::{iter::once, ops::Deref, sync::Arc};

/// The dissipation of contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Dissipation {
    /// Which law.
    pub kind: Kind,
    /// `gamma`, one number for each bond that can touch.
    pub strength: Vec<f64>,
}

/// One more power of the overlap in the forces of contacts, `contact (g)_+^alpha`.
///
/// It adds to the first power, which [`Details`](super::Details) have, or to their table, of bonds
/// where the constant of this one is positive. The energy of a contact is the sum of those of its
/// powers.
///
/// ```
/// use hertzchain_core::{Boundary, Chain, Params, chain::{Details, Term}};
/// // A bead pressed by 0.25 into a wall, f = g^{3/2} + 2 g^{5/2}.
/// let terms = vec![Term { contact: vec![2.0], alpha: 2.5 }];
/// let details = Details { terms, ..Details::default() };
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::RightWall, 1)?.with(&details)?;
/// assert_eq!(chain.bond_force(1, 0.25, 0.0), 0.125 + 2.0 * 0.03125);
/// // The energy is (2/5) g^{5/2} + (2/7) 2 g^{7/2}.
/// let energy = chain.energy(&[0.25, 0.0]).contacts;
/// assert!((energy - (0.4 / 32.0 + 4.0 / 7.0 / 128.0)).abs() < 1e-17);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Constants, at least zero: one for each bond that can touch, or none for 1.
    pub contact: Vec<f64>,
    /// The exponent, positive.
    pub alpha: f64,
}

impl Term {
    /// The law of this power alone for the `k`-th bond that can touch.
    pub fn law<R: Real>(&self, k: usize) -> BondLaw<R> {
        BondLaw::new(entry(&self.contact, k, 1.0), self.alpha, 0.0, None)
    }
}

/// The number of entry `i` of a list, or the value of the uniform chain.
pub(super) fn entry(list: &[f64], i: usize, otherwise: f64) -> f64 {
    list.get(i).copied().unwrap_or(otherwise)
}

/// The law of a bond: that of the first power of its force, and further powers, of a contact that
/// does not dissipate.
#[derive(Clone, Debug)]
pub(crate) struct Bond<R> {
    first: BondLaw<R>,
    further: Vec<BondLaw<R>>,
    /// A factor and the table in place of the first power, which then is a linear force that is
    /// nowhere smaller or less steep.
    table: Option<(R, Arc<Table>)>,
}

/// The first power has the static overlap and the dissipation.
impl<R> Deref for Bond<R> {
    type Target = BondLaw<R>;

    fn deref(&self) -> &BondLaw<R> {
        &self.first
    }
}

impl<R: Real> Bond<R> {
    /// The law of the `k`-th bond that can touch; terms and the table, times the constant of the
    /// contact, count if it has one.
    pub(crate) fn new(
        first: BondLaw<R>,
        (terms, table, contact): (&[Term], Option<&Arc<Table>>, &[f64]),
        k: usize,
    ) -> Self {
        let acts = |law: &BondLaw<R>| first.constant > R::zero() && law.constant > R::zero();
        let table = table.filter(|_| acts(&first)).map(|table| (R::of(entry(contact, k, 1.0)), table.clone()));
        Self { first, further: terms.iter().map(|term| term.law(k)).filter(acts).collect(), table }
    }

    /// Whether it has a contact.
    pub(crate) fn pushes_ever(&self) -> bool {
        self.first.constant > R::zero() || self.first.dissipates()
    }

    /// Whether its force is one power of the overlap.
    pub(crate) fn one_power(&self) -> bool {
        self.further.is_empty() && self.table.is_none()
    }

    /// The law of each power.
    pub(crate) fn laws(&self) -> impl Iterator<Item = &BondLaw<R>> {
        once(&self.first).chain(&self.further)
    }

    /// The sum of what the powers have at an overlap; the table has it as its `k`-th number.
    #[inline]
    fn sum(&self, g: R, k: usize, of: impl Fn(&BondLaw<R>) -> R) -> R {
        let first = match &self.table {
            None => of(&self.first),
            Some((factor, table)) => *factor * table.at(self.first.power.positive_part(g))[k],
        };
        self.further.iter().fold(first, |sum, law| sum + of(law))
    }

    /// The elastic force of all powers.
    #[inline]
    pub(crate) fn elastic(&self, g: R) -> R {
        self.sum(g, 0, |law| law.elastic(g))
    }

    /// The derivative of the elastic force.
    #[inline]
    pub(crate) fn stiffness(&self, g: R) -> R {
        self.sum(g, 1, |law| law.stiffness(g))
    }

    /// The energy.
    pub(crate) fn potential(&self, g: R) -> R {
        self.sum(g, 2, |law| law.potential(g))
    }

    /// The force at an overlap and its rate.
    #[inline]
    pub(crate) fn force(&self, g: R, rate: R) -> R {
        self.sum(g, 0, |law| law.force(g, rate))
    }
}
