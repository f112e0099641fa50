//! Beads on straight paths between kicks of contacts and springs, as contact-corrected splitting
//! moves them.

use super::{
    super::{Chain, KineticFlow, kinetic::Drifts},
    Forces, Fused, Lanes, Modified, SiteFlow,
    fused::FusedRow,
    gathered,
};
use hertzchain_integrators::{DoubleDouble, Vector, splitting::corrected::Correction};

impl SiteFlow for KineticFlow<f64> {
    fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    fn evaluate(&mut self, forces: Forces<'_>) {
        self.visit_beads(0.0, forces);
    }

    fn bead(&self, site: usize) -> (f64, f64) {
        (self.beads[0][site], self.beads[1][site])
    }

    #[inline(always)]
    fn motions_at<V: Vector<f64>>(&self, sites: &Lanes) -> [V; 3] {
        [gathered(&self.beads[1], sites), V::all(0.0), V::all(0.0)]
    }

    #[inline]
    fn response(&self) -> (f64, f64, f64) {
        (1.0, 0.0, 0.0)
    }

    fn spring(&self, site: usize) -> (f64, f64) {
        let kappa = self.chain.params().kappa;
        let (d, d_dot) = self.stretch(site);
        (-(kappa * d), -(kappa * d_dot))
    }

    #[inline]
    fn shift(&self, correction: &Correction) -> f64 {
        correction.displacement - correction.impulse * correction.at
    }

    #[inline]
    fn give(&mut self, beads: &[(usize, f64)], correction: &Correction) {
        let &Correction { impulse, displacement, at, .. } = correction;
        let [u, u_dot] = &mut self.beads;
        for &(site, weight) in beads {
            u[site] += weight * (displacement - impulse * at);
            u_dot[site] += weight * impulse;
        }
    }

    fn give_resonator(&mut self, site: usize, impulse: f64, displacement: f64) {
        if self.chain.layout().resonators() {
            let [v, v_dot] = &mut self.resonators;
            v[site] += displacement;
            v_dot[site] += impulse;
        }
    }

    fn push_and_evaluate(&mut self, pairs: &[(f64, DoubleDouble<f64>)], fused: Fused<'_>) -> usize {
        let clock = Drifts { springs: self.springs, pairs: pairs.iter() };
        self.visit_beads(0.0, FusedRow { fused, clock, kicks: pairs.len() })
    }

    #[allow(clippy::needless_range_loop, reason = "a loop over sites reads like the formula")]
    fn push(&mut self, kick: f64, forces: Modified<'_>, a: &[f64]) {
        let (n, params, c) = (self.chain.sites(), self.chain.params(), forces.c);
        self.visit_beads(kick, forces);
        let moving = self.chain.layout().resonators();
        let per_rho = if moving { params.kappa / params.rho } else { 0.0 };
        if params.omega() == 0.0 {
            return;
        }
        for i in 0..n {
            let d = self.stretch(i).0;
            let d = d + c * (a[i] - per_rho * d);
            self.beads[1][i] -= kick * (params.kappa * d);
            if moving {
                self.resonators[1][i] += kick * (per_rho * d);
            }
        }
    }
}

impl KineticFlow<f64> {
    /// The stretch of a spring, and its rate; zero without resonators.
    #[inline(always)]
    fn stretch(&self, site: usize) -> (f64, f64) {
        let (u, u_dot) = self.bead(site);
        if self.chain.layout().resonators() {
            (u - self.resonators[0][site], u_dot - self.resonators[1][site])
        } else if self.chain.params().omega() > 0.0 {
            (u, u_dot)
        } else {
            (0.0, 0.0)
        }
    }
}
