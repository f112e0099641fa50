//! Beads on straight paths between kicks of contacts and springs, as contact-corrected splitting
//! moves them.

use super::{
    super::{Chain, KineticFlow},
    Forces, Modified, SiteFlow,
    forces::add,
};
use hertzchain_integrators::{Kernel, Real, splitting::corrected::Correction};

impl SiteFlow for KineticFlow<f64> {
    fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    fn survey(&mut self, mut forces: Forces<'_>) {
        let u = forces.positions();
        u.copy_from_slice(&self.y[..u.len()]);
        f64::run(forces);
    }

    fn bead(&self, site: usize) -> (f64, f64) {
        (self.y[site], self.y[self.y.len() / 2 + site])
    }

    fn motion(&self, site: usize) -> [f64; 3] {
        [self.y[self.y.len() / 2 + site], 0.0, 0.0]
    }

    fn response(&self) -> (f64, f64, f64) {
        (1.0, 0.0, 0.0)
    }

    fn spring(&self, site: usize) -> (f64, f64) {
        let kappa = self.chain.params().kappa;
        let (d, d_dot) = self.stretch(site);
        (-(kappa * d), -(kappa * d_dot))
    }

    fn shift(&self, correction: &Correction) -> f64 {
        correction.displacement - correction.impulse * correction.at
    }

    fn give(&mut self, beads: &[(usize, f64)], correction: &Correction) {
        let &Correction { impulse, displacement, at, .. } = correction;
        let half = self.y.len() / 2;
        for &(site, weight) in beads {
            self.y[site] += weight * (displacement - impulse * at);
            self.y[half + site] += weight * impulse;
        }
    }

    fn give_resonator(&mut self, site: usize, impulse: f64, displacement: f64) {
        let (n, half) = (self.chain.sites(), self.y.len() / 2);
        if self.chain.layout().resonators() {
            self.y[n + site] += displacement;
            self.y[half + n + site] += impulse;
        }
    }

    #[allow(clippy::needless_range_loop, reason = "a loop over sites reads like the formula")]
    fn push(&mut self, kick: f64, forces: Modified<'_>, a: &[f64]) {
        let (n, half, params, c) = (self.chain.sites(), self.y.len() / 2, self.chain.params(), forces.c);
        f64::run(Kicks { kick, velocities: &mut self.y[half..half + n], forces });
        let moving = self.chain.layout().resonators();
        let per_rho = if moving { params.kappa / params.rho } else { 0.0 };
        if params.omega() == 0.0 {
            return;
        }
        for i in 0..n {
            let d = self.stretch(i).0;
            let d = d + c * (a[i] - per_rho * d);
            self.y[half + i] -= kick * (params.kappa * d);
            if moving {
                self.y[half + n + i] += kick * (per_rho * d);
            }
        }
    }
}

/// Forces times `kick`, added to velocities.
struct Kicks<'a> {
    kick: f64,
    velocities: &'a mut [f64],
    forces: Modified<'a>,
}

impl Kernel for Kicks<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        self.forces.compute();
        add(self.kick, self.forces.push, self.velocities);
    }
}

impl KineticFlow<f64> {
    /// The stretch of a spring, and its rate; zero without resonators.
    #[inline(always)]
    fn stretch(&self, site: usize) -> (f64, f64) {
        let (n, half) = (self.chain.sites(), self.y.len() / 2);
        if self.chain.layout().resonators() {
            (self.y[site] - self.y[n + site], self.y[half + site] - self.y[half + n + site])
        } else if self.chain.params().omega() > 0.0 {
            (self.y[site], self.y[half + site])
        } else {
            (0.0, 0.0)
        }
    }
}
