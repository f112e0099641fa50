//! A chain whose beads differ, as contact collocation sees it: every bond between two sites that
//! answer impulses in their own ways.

use super::super::{Chain, ContactLaw, Layout, Modes, Params, Resonators};
use hertzchain_integrators::{
    Error,
    collocation::{ContactChain, Path, Response},
};

/// Overlap of a bond with the contact constant zero where all sites are at the origin: it never
/// closes.
const APART: f64 = -1e100;

/// A chain with [`Details`](super::Details) that neither dissipates nor is driven.
#[derive(Clone, Debug)]
pub struct Differing {
    chain: Chain<f64>,
    sites: Vec<Motion>,
}

/// The two motions of a site.
#[derive(Clone, Copy, Debug)]
struct Motion {
    modes: Modes<f64>,
    moving: bool,
    response: Response,
}

impl Differing {
    /// The chain.
    ///
    /// # Errors
    /// A chain without details, or one that dissipates or is driven.
    pub fn new(chain: Chain<f64>) -> Result<Self, Error> {
        let closed = chain.parts().filter(|parts| !parts.open());
        let Some(parts) = closed else {
            let rule = "a chain whose beads differ, without damping, dissipation and drives";
            return Err(Error::Argument { name: "sites", value: chain.sites() as f64, rule });
        };
        let motion = |site: &super::SiteParts<f64>| {
            let modes = Modes::new(Params { alpha: 1.0, kappa: site.kappa / site.mass, rho: site.rho });
            let (m, mu) = (modes.m / site.mass, modes.mu / site.mass);
            let response = Response { m, mu, omega: modes.omega };
            Motion { modes, moving: site.resonators == Resonators::Moving, response }
        };
        let sites = parts.sites.iter().map(motion).collect();
        Ok(Self { chain, sites })
    }

    fn layout(&self) -> Layout {
        self.chain.layout()
    }

    /// The contact of a bond, counted from the first that can touch.
    fn contact(&self, bond: usize) -> &super::Contact<f64> {
        let parts = self.chain.parts().expect("a chain with details");
        &parts.bonds[self.chain.topology().first() + bond]
    }
}

impl ContactChain<2> for Differing {
    fn dim(&self) -> usize {
        self.layout().dim()
    }

    fn sites(&self) -> usize {
        self.sites.len()
    }

    fn bonds(&self) -> usize {
        self.chain.touching().len()
    }

    fn ring(&self) -> bool {
        self.chain.topology().ring()
    }

    fn law(&self, bond: usize) -> ContactLaw<f64> {
        self.contact(bond).law()
    }

    fn constant(&self, bond: usize) -> f64 {
        self.contact(bond).constant()
    }

    fn response(&self, site: usize) -> Response {
        self.sites[site].response
    }

    #[inline(always)]
    fn ends(&self, bond: usize) -> [Option<usize>; 2] {
        let topology = self.chain.topology();
        match topology.ends(topology.first() + bond) {
            // A ring of one site, which no force moves.
            [Some(before), Some(behind)] if before == behind => [None, None],
            ends => ends,
        }
    }

    fn rest(&self, bond: usize) -> f64 {
        let contact = self.contact(bond);
        if contact.constant() > 0.0 { contact.rest } else { APART }
    }

    #[inline(always)]
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> Path) -> [Path; 2] {
        let [before, behind] = self.ends(bond);
        let mut sides = [[0.0; 4]; 2];
        if let Some(site) = before {
            sides[0] = quantity(site);
        }
        if let Some(site) = behind {
            let path = quantity(site);
            for k in 0..4 {
                sides[1][k] = -path[k];
            }
        }
        sides
    }

    #[inline(always)]
    fn push(&self, site: usize, force: impl Fn(usize) -> [Path; 2]) -> Path {
        let topology = self.chain.topology();
        let ([before, behind], first) = (topology.bonds(site), topology.first());
        let mut push = [0.0; 4];
        if let Some(bond) = before {
            push = force(bond - first)[1];
        }
        if let Some(bond) = behind {
            let path = force(bond - first)[0];
            for k in 0..4 {
                push[k] -= path[k];
            }
        }
        push
    }

    fn path(&self, y: &[f64], i: usize) -> Path {
        let (layout, modes) = (self.layout(), &self.sites[i].modes);
        let of = |array: Option<&[f64]>| array.map_or(0.0, |array| array[i]);
        let [r, r_dot, p, p_dot] =
            modes.split([layout.u(y)[i], of(layout.v(y)), layout.u_dot(y)[i], of(layout.v_dot(y))]);
        let omega = modes.omega.value();
        [r, r_dot, p, if omega > 0.0 { p_dot / omega } else { p_dot }]
    }

    fn place(&self, parts: [f64; 4], i: usize, y: &mut [f64]) {
        let (n, layout) = (self.sites.len(), self.layout());
        let Motion { modes, moving, .. } = &self.sites[i];
        let [u, v, u_dot, v_dot] = modes.join(parts);
        let half = layout.half();
        (y[i], y[half + i]) = (u, u_dot);
        if layout.resonators() {
            (y[n + i], y[half + n + i]) = if *moving { (v, v_dot) } else { (0.0, 0.0) };
        }
    }

    fn dead_band(&self, largest: f64) -> f64 {
        64.0 * f64::EPSILON * largest
    }
}
