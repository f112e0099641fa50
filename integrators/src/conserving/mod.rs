//! A scheme that conserves the energy exactly, as a rival of the symplectic ones: the
//! [`DiscreteGradient`].
//!
//! It has order two, also on smooth problems, and is not symplectic; the forces of a step are found
//! by iteration. Springs enter as forces, like contacts: it does not use the exact linear flow.
//!
//! | symbol | meaning |
//! |---|---|
//! | `[r, r', p, p']` | free and oscillating part of the position of a site, and their rates, see [`ContactChain`] |
//! | `m, mu` | shares of an impulse that these two parts take; their masses are `1/m` and `1/mu` |
//! | `g_b, f, V` | overlap of a bond; force `(g)_+^alpha` and potential of the contact law |
//! | `F_i` | contact force on a site |

mod gradient;

pub use gradient::DiscreteGradient;

use crate::{
    collocation::{ContactChain, Path},
    law::ContactLaw,
};

/// Sites as `[r, r', p, p']`.
type Sites = Vec<[f64; 4]>;

/// A chain with the constants that all its sites share.
struct Modal<C> {
    chain: C,
    law: ContactLaw<f64>,
    m: f64,
    mu: f64,
    /// `omega^2`.
    stiffness: f64,
    /// Decrease of each bond's overlap if a unit force of this bond displaces each of its sites by
    /// one unit.
    mobility: Vec<f64>,
    /// Overlaps at the start of a step, and at its end without contact forces.
    overlaps: [Vec<f64>; 2],
}

impl<C: ContactChain> Modal<C> {
    fn new(chain: C) -> Self {
        let response = chain.response(0);
        let omega = response.omega.value();
        let mobility = |b| -chain.across(b, |i| chain.push(i, |c| [path(f64::from(u8::from(c == b)))]))[0][0];
        let zeros = || vec![0.0; chain.bonds()];
        Self {
            mobility: (0..chain.bonds()).map(mobility).collect(),
            overlaps: [zeros(), zeros()],
            law: chain.bond(0).power,
            m: response.m,
            mu: response.mu,
            stiffness: omega * omega,
            chain,
        }
    }

    /// Sites of a state.
    fn load(&self, y: &[f64]) -> Sites {
        let omega = self.stiffness.sqrt();
        let site = |i| {
            let [r, r_dot, p, s] = self.chain.path(y, i);
            [r, r_dot, p, if omega > 0.0 { omega * s } else { s }]
        };
        (0..self.chain.sites()).map(site).collect()
    }

    /// Writes the state of `sites` into `y`, after a step of length `by` of the discrete gradient
    /// if `by` is not zero.
    fn sample(&mut self, mut sites: Sites, phi: &[f64], by: f64, y: &mut [f64]) {
        if by != 0.0 && self.discrete_gradient(&mut sites, &mut phi.to_vec(), by).is_err() {
            // The iteration failed: the sample is NaN rather than a wrong state.
            y.fill(f64::NAN);
            return;
        }
        sites.iter().enumerate().for_each(|(i, &site)| self.chain.place(site, i, y));
    }

    /// The overlap of a bond where sites are at given positions.
    fn overlap(&self, b: usize, position: impl Fn(usize) -> f64) -> f64 {
        self.chain.bond(b).rest + self.rate(b, position)
    }

    /// The rate of an overlap where sites have given velocities.
    fn rate(&self, b: usize, velocity: impl Fn(usize) -> f64) -> f64 {
        self.chain.across(b, |i| path(velocity(i)))[0][0]
    }

    /// The contact force on a site, from those of bonds.
    fn push(&self, i: usize, force: &[f64]) -> f64 {
        self.chain.push(i, |b| [path(force[b])])[0]
    }
}

/// A number as a [`Path`], the type that the functions of a chain take.
fn path(value: f64) -> Path {
    [value, 0.0, 0.0, 0.0]
}
