//! The change of variables `(u, v) <-> (R, P)` that parts a site into two independent motions
//! between contacts.
//!
//! | symbol | meaning |
//! |---|---|
//! | `R = (u + rho v)/(1 + rho)` | centre of mass of a bead and its resonator; moves freely |
//! | `P = rho (u - v)/(1 + rho)` | oscillates with `omega`; `u = R + P`, `v = R - P/rho` |
//! | `m, mu` | `1/(1 + rho)`, `rho/(1 + rho)`: the shares of an impulse on a bead that `R'` and `P'` take |
//!
//! A plain chain has `R` only, with `m = 1`; the cradle has `P` only, with `mu = 1`.

use super::{Params, Resonators};
use hertzchain_integrators::{DoubleDouble, Real};

/// The two motions of a site.
#[derive(Clone, Copy, Debug)]
pub struct Modes<R> {
    resonators: Resonators,
    rho: R,
    /// Share of an impulse that moves freely.
    pub m: R,
    /// Share of an impulse that oscillates; `m + mu = 1`.
    pub mu: R,
    /// Frequency; zero for a plain chain.
    pub omega: DoubleDouble<R>,
}

impl<R: Real> Modes<R> {
    /// The modes of a site of a chain with such parameters.
    pub fn new(params: Params) -> Self {
        let (one, rho, resonators) = (R::one(), R::of(params.rho), params.resonators());
        let (m, mu) = match resonators {
            Resonators::None => (one, R::zero()),
            Resonators::Fixed => (R::zero(), one),
            Resonators::Moving => (one / (one + rho), one / (one + one / rho)),
        };
        Self { resonators, rho, m, mu, omega: params.omega_twofold() }
    }

    /// `mu/omega`: the amplitude of the oscillation that a unit impulse starts.
    pub fn mu_over_omega(&self) -> R {
        if self.resonators == Resonators::None { self.mu } else { self.mu / self.omega.value() }
    }

    /// `[R, R', P, P']` from `[u, v, u', v']`; `v` and `v'` are used only where resonators move.
    #[inline(always)]
    pub fn split(&self, [u, v, u_dot, v_dot]: [R; 4]) -> [R; 4] {
        let (zero, m, mu) = (R::zero(), self.m, self.mu);
        match self.resonators {
            Resonators::None => [u, u_dot, zero, zero],
            Resonators::Fixed => [zero, zero, u, u_dot],
            Resonators::Moving => [m * u + mu * v, m * u_dot + mu * v_dot, mu * (u - v), mu * (u_dot - v_dot)],
        }
    }

    /// `[R, R', P, P'/omega]` from `[u, v, u', v']`; `P'` itself, which is zero, without a
    /// frequency.
    #[inline(always)]
    pub fn path(&self, site: [R; 4]) -> [R; 4] {
        let ([r, r_dot, p, p_dot], omega) = (self.split(site), self.omega.value());
        [r, r_dot, p, if omega > R::zero() { p_dot / omega } else { p_dot }]
    }

    /// `[u, v, u', v']` from `[R, R', P, P']`; without branches. `v` and `v'` have no meaning
    /// unless resonators move.
    #[inline(always)]
    pub fn join(&self, [r, r_dot, p, p_dot]: [R; 4]) -> [R; 4] {
        [r + p, r - p / self.rho, r_dot + p_dot, r_dot - p_dot / self.rho]
    }
}
