//! Derivatives of a motion by numbers of its chain.
//!
//! With `y' = f(y, p)` the derivative `w = dy/dp` follows `w' = (df/dy) w + df/dp`: the equation of
//! a column of [`Variations`](crate::chain::Variations) with the source `df/dp`. Forces of contacts
//! that do not dissipate are continuous where contacts begin or end, so `w` is continuous there,
//! too.
//!
//! | `p` | source, in `u_n''` and `v_n''` |
//! |---|---|
//! | `alpha` | `(A_n g_n^alpha ln g_n - A_{n+1} g_{n+1}^alpha ln g_{n+1})/m_n` of closed bonds, 0 |
//! | `kappa` | `-(u_n - v_n)/m_n`, `(u_n - v_n)/(rho_n m_n)` |
//! | `rho` | 0, `-v_n''/rho_n` |
//! | `m_k` | `-u_k''/m_k`, `-v_k''/m_k` at bead `k` |

use super::{super::Chain, CheckedDetails, Resonators, contact::entry};
use crate::error::{Error, Result};
use hertzchain_integrators::Real;
use std::fmt;

/// A number of a chain by which a motion is differentiated. All others stay as they are, static
/// overlaps and masses of beads included; the mass of a resonator is `rho_n m_n`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// The exponent of all contacts.
    Alpha,
    /// The spring constant of all resonators.
    Kappa,
    /// The mass ratio of all resonators.
    Rho,
    /// The mass of a bead.
    Mass(usize),
}

impl fmt::Display for Parameter {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Alpha => out.write_str("alpha"),
            Self::Kappa => out.write_str("kappa"),
            Self::Rho => out.write_str("rho"),
            Self::Mass(site) => write!(out, "mass[{site}]"),
        }
    }
}

impl Parameter {
    /// Refuses a chain whose motion does not have this derivative.
    pub(in super::super) fn check<R: Real>(self, chain: &Chain<R>, parts: &CheckedDetails<R>) -> Result<()> {
        let (params, given) = (chain.params(), &parts.given);
        let refused = match self {
            _ if parts.dissipative => Some("of a chain whose contacts do not dissipate"),
            // Beads and resonators are counted from where they hang.
            _ if given.gravity != 0.0 => Some("of a chain without gravity"),
            Self::Alpha if !(given.alpha.is_empty() && given.own_law().is_none()) => {
                Some("bonds have exponents of their own")
            }
            Self::Kappa if params.kappa <= 0.0 => Some("resonators have no springs here"),
            Self::Kappa if !given.kappa.is_empty() => Some("beads have spring constants of their own"),
            Self::Rho if !chain.layout().resonators() => Some("no resonator moves"),
            Self::Rho if !given.rho.is_empty() => Some("beads have mass ratios of their own"),
            Self::Mass(site) if site >= chain.sites() => Some("a site of the chain, counted from 0"),
            _ => None,
        };
        refused.map_or(Ok(()), |rule| Err(Error::parameter("derivatives", self, rule)))
    }

    /// Adds the source at a state with these rates: `add` gets rows of the column and what is
    /// added.
    pub(in super::super) fn source<R: Real>(
        self,
        chain: &Chain<R>,
        parts: &CheckedDetails<R>,
        (state, rates): (&[R], &[R]),
        mut add: impl FnMut(usize, R),
    ) {
        let (n, half) = (chain.sites(), chain.layout().half());
        let mut accelerate = |entry: usize, by: R| {
            if entry >= n || !parts.sites[entry].moved {
                add(half + entry, by);
            }
        };
        match self {
            Self::Alpha => {
                for bond in chain.touching() {
                    let contact = &parts.bonds[bond];
                    let g = contact.rest + chain.across(bond, |i| state[i]);
                    if g > R::zero() {
                        let force = chain.bond_force(bond, g, R::zero()) * g.ln();
                        for &(site, weight) in chain.topology().pushed(bond).iter() {
                            accelerate(site, R::of(weight) * force / parts.sites[site].mass);
                        }
                    }
                }
            }
            Self::Mass(site) => {
                let mass = parts.sites[site].mass;
                accelerate(site, -rates[half + site] / mass);
                if chain.resonator_moves(site) {
                    accelerate(n + site, -rates[half + n + site] / mass);
                }
            }
            Self::Kappa | Self::Rho => {
                for (i, site) in parts.sites.iter().enumerate().filter(|(_, site)| site.resonators != Resonators::None)
                {
                    let moves = site.resonators == Resonators::Moving;
                    let stretch = state[i] - if moves { state[n + i] } else { R::zero() };
                    // Without a resonator the spring is one of the site's own.
                    if self == Self::Kappa && (moves || entry(&parts.given.rho, i, chain.params().rho).is_infinite()) {
                        accelerate(i, -stretch / site.mass);
                    }
                    if moves {
                        let by_rho = -rates[half + n + i] / site.rho;
                        accelerate(n + i, if self == Self::Rho { by_rho } else { stretch / site.resonator() });
                    }
                }
            }
        }
    }
}
