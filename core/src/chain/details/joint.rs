//! Forces between two beads that are smooth where the beads meet: linear springs and magnets.
//!
//! | symbol | meaning |
//! |---|---|
//! | `x` | approach of two beads from their places at rest, `u_{b-1} - u_b` |
//! | `K` | constant of a linear spring |
//! | `F, d, p` | force of two magnets that repel at rest, their distance there, power of its decay |
//!
//! Repelling magnets: M. Moleron, A. Leonard, C. Daraio 2014, J. Appl. Phys. 115, 184901.

use hertzchain_integrators::Real;

/// A linear spring and two magnets between two beads: the force `K x + F (d/(d - x))^p`.
///
/// ```
/// use hertzchain_core::chain::Joint;
/// let joint = Joint { spring: 2.0, magnet: 0.5, distance: 3.0, decay: 4.0 };
/// assert_eq!([joint.force(0.0), joint.stiffness(0.0)], [0.5, 2.0 + 4.0 * 0.5 / 3.0]);
/// assert_eq!(joint.force(-3.0), -6.0 + 0.5 / 16.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint<R> {
    /// `K`, at least zero.
    pub spring: R,
    /// `F`, at least zero.
    pub magnet: R,
    /// `d`, positive.
    pub distance: R,
    /// `p`, above 1.
    pub decay: R,
}

impl<R: Real> Joint<R> {
    /// No spring and no magnets.
    pub(crate) fn none() -> Self {
        Self { spring: R::zero(), magnet: R::zero(), distance: R::one(), decay: R::of(2.0) }
    }

    /// `d/(d - x)`; not-a-number from `x = d` on.
    fn nearness(&self, x: R) -> R {
        let left = self.distance - x;
        if left > R::zero() { self.distance / left } else { R::nan() }
    }

    /// The force at an approach `x`; not-a-number for magnets from `x = d` on.
    pub fn force(&self, x: R) -> R {
        let force = self.spring * x;
        if self.magnet == R::zero() { force } else { force + self.magnet * self.nearness(x).powf(self.decay) }
    }

    /// The derivative of the force by `x`.
    pub fn stiffness(&self, x: R) -> R {
        if self.magnet == R::zero() {
            return self.spring;
        }
        let steep = self.nearness(x).powf(self.decay + R::one());
        self.spring + self.magnet * self.decay / self.distance * steep
    }

    /// The largest stiffness for approaches up to `x`, or up to half the distance of the magnets.
    pub fn stiffness_within(&self, x: R) -> R {
        self.stiffness(x.min(R::of(0.5) * self.distance))
    }

    /// The energy: `K x^2/2 + F d/(p - 1) (d/(d - x))^{p-1}`, that of magnets without bound apart
    /// is zero.
    pub fn potential(&self, x: R) -> R {
        let energy = R::of(0.5) * self.spring * x * x;
        if self.magnet == R::zero() {
            return energy;
        }
        let power = self.decay - R::one();
        energy + self.magnet * self.distance / power * self.nearness(x).powf(power)
    }
}
