//! The chain as contact collocation sees it.

use super::{Boundary, Chain, ContactLaw, Resonators};
use hertzchain_integrators::{
    Collocation, Error,
    collocation::{ContactChain, Pace, Path, Response, monodromy},
};

impl Chain<f64> {
    /// A run of this chain by contact collocation.
    ///
    /// # Errors
    /// A state, a span or a pace outside its rule.
    pub fn collocation(&self, y0: &[f64], span: (f64, f64), pace: Pace) -> Result<Collocation<Self>, Error> {
        Collocation::new(self.clone(), y0, span, pace)
    }

    /// The derivative of the end of such a run by its start: `dim x dim`, column by column, see [`monodromy`].
    ///
    /// # Errors
    /// As [`collocation`](Self::collocation); also a chain of more than 256 bonds.
    pub fn monodromy(&self, y0: &[f64], span: (f64, f64), pace: Pace) -> Result<Vec<f64>, Error> {
        monodromy(self.clone(), y0, span, pace)
    }
}

impl ContactChain for Chain<f64> {
    fn dim(&self) -> usize {
        self.layout.dim()
    }

    fn sites(&self) -> usize {
        self.layout.sites()
    }

    fn bonds(&self) -> usize {
        self.touching().len()
    }

    fn ring(&self) -> bool {
        matches!(self.boundary, Boundary::Ring | Boundary::StrainRing)
    }

    fn law(&self) -> ContactLaw<f64> {
        self.law
    }

    fn response(&self) -> Response {
        let rho = self.params.rho;
        let (m, mu) = match self.params.resonators() {
            Resonators::None => (1.0, 0.0),
            Resonators::Fixed => (0.0, 1.0),
            Resonators::Moving => (1.0 / (1.0 + rho), 1.0 / (1.0 + 1.0 / rho)),
        };
        Response { m, mu, omega: self.params.omega_twofold() }
    }

    fn rest(&self) -> f64 {
        self.precompression
    }

    #[inline(always)]
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> Path) -> Path {
        let n = self.sites();
        match self.boundary {
            Boundary::Free => minus(quantity(bond), quantity(bond + 1)),
            Boundary::Fixed if bond == 0 => minus([0.0; 4], quantity(0)),
            Boundary::Fixed if bond == n => quantity(n - 1),
            Boundary::Fixed => minus(quantity(bond - 1), quantity(bond)),
            Boundary::Ring => minus(quantity(if bond == 0 { n - 1 } else { bond - 1 }), quantity(bond)),
            Boundary::StrainRing => minus([0.0; 4], quantity(bond)),
        }
    }

    #[inline(always)]
    fn push(&self, site: usize, force: impl Fn(usize) -> Path) -> Path {
        let n = self.sites();
        let next = if site + 1 == n { 0 } else { site + 1 };
        match self.boundary {
            Boundary::Free if n == 1 => [0.0; 4],
            Boundary::Free if site == 0 => minus([0.0; 4], force(0)),
            Boundary::Free if site + 1 == n => force(site - 1),
            Boundary::Free => minus(force(site - 1), force(site)),
            Boundary::Fixed => minus(force(site), force(site + 1)),
            Boundary::Ring => minus(force(site), force(next)),
            Boundary::StrainRing => {
                let before = if site == 0 { n - 1 } else { site - 1 };
                minus(minus(force(site), force(next)), minus(force(before), force(site)))
            }
        }
    }

    fn path(&self, y: &[f64], i: usize) -> Path {
        let (layout, omega) = (self.layout, self.params.omega());
        let (u, u_dot) = (layout.u(y)[i], layout.u_dot(y)[i]);
        match (layout.v(y), layout.v_dot(y), self.params.resonators()) {
            (Some(v), Some(v_dot), _) => {
                let Response { m, mu, .. } = self.response();
                [m * u + mu * v[i], m * u_dot + mu * v_dot[i], mu * (u - v[i]), mu * (u_dot - v_dot[i]) / omega]
            }
            (_, _, Resonators::Fixed) => [0.0, 0.0, u, u_dot / omega],
            _ => [u, u_dot, 0.0, 0.0],
        }
    }

    fn place(&self, [r, r_dot, p, p_dot]: [f64; 4], i: usize, y: &mut [f64]) {
        let (n, half, rho) = (self.sites(), self.layout.dim() / 2, self.params.rho);
        y[i] = r + p;
        y[half + i] = r_dot + p_dot;
        if self.layout.resonators() {
            y[n + i] = r - p / rho;
            y[half + n + i] = r_dot - p_dot / rho;
        }
    }

    fn dead_band(&self, largest: f64) -> f64 {
        Chain::dead_band(self, std::iter::once(largest))
    }
}

#[inline(always)]
fn minus(a: Path, b: Path) -> Path {
    // No closure: it would be a call for each of the four.
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}
