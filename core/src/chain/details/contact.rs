//! The force of one contact: constant, exponent, static overlap and dissipation of its own.

use super::super::ContactLaw;
use hertzchain_integrators::Real;
use serde::{Deserialize, Serialize};

/// How contacts dissipate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Viscoelastic spheres, `f = A (g^alpha + gamma d/dt g^alpha)_+` for `g > 0`: Kuwabara & Kono
    /// 1987, Jpn. J. Appl. Phys. 26, 1230; Brilliantov, Spahn, Hertzsch & Poeschel 1996, Phys. Rev.
    /// E 53, 5382. `gamma` is a time.
    Viscoelastic,
    /// A linear dashpot, `f = (A g^alpha + gamma g')_+` for `g > 0`; `gamma` is a force over a
    /// velocity.
    Dashpot,
}

/// The dissipation of contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Dissipation {
    /// Which law.
    pub kind: Kind,
    /// `gamma`, one number for each bond that can touch.
    pub strength: Vec<f64>,
}

/// One contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact<R> {
    law: ContactLaw<R>,
    constant: R,
    /// Static overlap.
    pub(crate) rest: R,
    loss: Option<(Kind, R)>,
}

impl<R: Real> Contact<R> {
    pub(crate) fn new(constant: f64, alpha: f64, rest: f64, loss: Option<(Kind, f64)>) -> Self {
        let loss = loss.filter(|(_, gamma)| *gamma > 0.0 && constant > 0.0).map(|(kind, gamma)| (kind, R::of(gamma)));
        Self { law: ContactLaw::new(alpha), constant: R::of(constant), rest: R::of(rest), loss }
    }

    pub(crate) fn law(&self) -> ContactLaw<R> {
        self.law
    }

    /// `A`.
    pub(crate) fn constant(&self) -> R {
        self.constant
    }

    /// The kind and `gamma` of its dissipation, if it dissipates.
    pub(crate) fn loss(&self) -> Option<(Kind, R)> {
        self.loss
    }

    pub(crate) fn dissipates(&self) -> bool {
        self.loss.is_some()
    }

    /// `A (g)_+^alpha`.
    #[inline]
    pub(crate) fn elastic(&self, g: R) -> R {
        self.constant * self.law.force(g)
    }

    /// `A alpha (g)_+^{alpha-1}`.
    #[inline]
    pub(crate) fn stiffness(&self, g: R) -> R {
        self.constant * self.law.stiffness(g)
    }

    /// The force at an overlap and its rate; never negative.
    #[inline]
    pub(crate) fn force(&self, g: R, rate: R) -> R {
        let elastic = self.elastic(g);
        if self.loss.is_none() || g <= R::zero() {
            return elastic;
        }
        self.push(g, rate).max(R::zero())
    }

    /// The force of a contact that is known to push: smooth through its onset and its end.
    #[inline]
    pub(crate) fn push(&self, g: R, rate: R) -> R {
        self.elastic(g) + self.resistance(g) * rate
    }

    /// `c(g)`, the dissipative part `c(g) g'` of the force of a contact that pushes over the rate
    /// of its overlap.
    #[inline]
    pub(crate) fn resistance(&self, g: R) -> R {
        match self.loss {
            Some((Kind::Viscoelastic, gamma)) => self.constant * self.law.stiffness(g) * gamma,
            Some((Kind::Dashpot, gamma)) => gamma,
            None => R::zero(),
        }
    }

    /// `A (g)_+^{alpha+1} / (alpha+1)`.
    pub(crate) fn potential(&self, g: R) -> R {
        if g <= R::zero() { R::zero() } else { self.constant * self.law.potential(g) }
    }

    /// A function that is positive where a closed contact pushes: `g + gamma alpha g'` for
    /// viscoelastic ones, `A (g)_+^alpha + gamma g'` for dashpots; `None` without dissipation.
    pub(crate) fn pushes(&self, g: R, rate: R) -> Option<R> {
        self.loss.map(|(kind, gamma)| match kind {
            Kind::Viscoelastic => g + gamma * self.law.alpha() * rate,
            Kind::Dashpot => self.elastic(g) + gamma * rate,
        })
    }

    /// The rate of [`pushes`](Self::pushes), from overlap, rate and second derivative.
    pub(crate) fn pushes_rate(&self, g: R, rate: R, second: R) -> Option<R> {
        self.loss.map(|(kind, gamma)| match kind {
            Kind::Viscoelastic => rate + gamma * self.law.alpha() * second,
            Kind::Dashpot => self.constant * self.law.stiffness(g) * rate + gamma * second,
        })
    }

    /// The powers of time with which the force begins or ends.
    pub(crate) fn powers(&self) -> impl Iterator<Item = f64> {
        self.elastic_power().into_iter().chain(self.power_of_resistance())
    }

    /// The powers of time with which stiffness and resistance begin or end.
    pub(crate) fn powers_of_columns(&self) -> impl Iterator<Item = f64> {
        let stiffness = self.elastic_power().map(|alpha| alpha - 1.0);
        stiffness.into_iter().chain(self.power_of_resistance())
    }

    /// The exponent, if beads can touch.
    pub(crate) fn elastic_power(&self) -> Option<f64> {
        (self.constant > R::zero()).then(|| self.law.alpha().f64())
    }

    fn power_of_resistance(&self) -> Option<f64> {
        self.loss.map(|(kind, _)| match kind {
            Kind::Viscoelastic => self.law.alpha().f64() - 1.0,
            Kind::Dashpot => 0.0,
        })
    }
}
