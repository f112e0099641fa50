//! The explicit scheme of energy quadratisation.
//!
//! The potential `V` of all contacts is written as `psi^2/2`, and `psi` is carried along:
//!
//! ```text
//! q_{n+1} = q_n + h v_{n+1/2}
//! v_{n+1/2} = v_{n-1/2} - h M^{-1} [K q_n + gamma (psi_{n+1/2} + psi_{n-1/2})/2],   gamma = grad V/(2 V)^{1/2} at q_n
//! psi_{n+1/2} = psi_{n-1/2} + h gamma . (v_{n+1/2} + v_{n-1/2})/2
//! ```
//!
//! The equations are linear in the unknowns and coupled by one number, so that a step is explicit.
//! They conserve `v_{n+1/2} M v_{n+1/2}/2 + q_n K q_{n+1}/2 + psi_{n+1/2}^2/2`, positive for `h
//! omega < 2`. Only at the start is `psi^2/2` set to the potential of the positions. Later the two
//! differ by `O(h^2)`, and while no contact acts `psi` keeps its value.
//!
//! S. Bilbao, M. Ducceschi and F. Zama, *J. Comput. Phys.* 472 (2023) 111697, with the springs as
//! the part that is not quadratised.

use super::{Modal, Sites, Steps};
use crate::{collocation::ContactChain, drive::Stepper, error::Error, interrupt, stats::Stats};

/// The quadratised scheme at work, in equal steps.
pub struct Quadratised<C> {
    chain: Modal<C>,
    /// Positions now, velocities half a step later.
    sites: Sites,
    /// The velocities half a step ago, `[r', p']`.
    before: Vec<[f64; 2]>,
    psi: f64,
    /// Contact forces of bonds.
    force: Vec<f64>,
    /// Contact forces on sites, divided by `(2V)^{1/2}`: `-gamma`.
    pushes: Vec<f64>,
    steps: Steps,
}

impl<C: ContactChain> Quadratised<C> {
    /// Runs `chain` from the state `y0`.
    ///
    /// # Errors
    /// `end < start`, times that are not finite, or no step for a span that is not empty.
    pub fn new(chain: C, y0: &[f64], span: (f64, f64), steps: u64) -> Result<Self, Error> {
        let (steps, chain) = (Steps::new(span, steps)?, Modal::new(chain));
        let (sites, force) = (chain.load(y0), vec![0.0; chain.recoil.len()]);
        let before = sites.iter().map(|&[_, r_dot, _, p_dot]| [r_dot, p_dot]).collect();
        let pushes = vec![0.0; sites.len()];
        let mut new = Self { chain, sites, before, psi: 0.0, force, pushes, steps };
        new.begin();
        Ok(new)
    }

    /// Sets velocities and `psi` to their values half a step after the start, to second order.
    fn begin(&mut self) {
        let half = 0.5 * self.steps.h.value();
        self.forces();
        for i in 0..self.sites.len() {
            let push = self.chain.push(i, &self.force);
            let [_, r_dot, p, p_dot] = &mut self.sites[i];
            *r_dot += half * self.chain.m * push;
            *p_dot += half * (self.chain.mu * push - self.chain.stiffness * *p);
            // The mean of both velocities is then the velocity at the start.
            let [r_before, p_before] = &mut self.before[i];
            (*r_before, *p_before) = (2.0 * *r_before - *r_dot, 2.0 * *p_before - *p_dot);
        }
        let (chain, sites) = (&self.chain, &self.sites);
        let ahead = |i: usize| (sites[i][0] + half * sites[i][1]) + (sites[i][2] + half * sites[i][3]);
        let potential: f64 = (0..self.force.len()).map(|b| chain.law.potential(chain.overlap(b, ahead))).sum();
        self.psi = (2.0 * potential).sqrt();
    }

    /// Forces of all bonds at the positions of now; returns `V`.
    fn forces(&mut self) -> f64 {
        let Self { chain, sites, force, .. } = self;
        let mut potential = 0.0;
        for (b, force) in force.iter_mut().enumerate() {
            let g = chain.overlap(b, |i| sites[i][0] + sites[i][2]);
            *force = chain.law.force(g);
            potential += chain.law.potential(g);
        }
        potential
    }

    /// The energy that the scheme conserves, for a chain of displacements. It may be asked for
    /// before the first step and after each step.
    pub fn conserved(&self) -> f64 {
        let (h, Modal { m, mu, stiffness, .. }) = (self.steps.h.value(), &self.chain);
        let over = |square: f64, share: f64| if share > 0.0 { square / share } else { 0.0 };
        let site = |&[_, r_dot, p, p_dot]: &[f64; 4]| {
            over(r_dot * r_dot, *m) + over(p_dot * p_dot + stiffness * p * (p + h * p_dot), *mu)
        };
        0.5 * (self.sites.iter().map(site).sum::<f64>() + self.psi * self.psi)
    }
}

impl<C: ContactChain> Stepper<f64> for Quadratised<C> {
    fn dim(&self) -> usize {
        self.chain.chain.dim()
    }

    fn time(&self) -> f64 {
        self.steps.reached().value()
    }

    fn done(&self) -> bool {
        self.steps.taken == self.steps.total
    }

    fn step(&mut self) -> Result<(), Error> {
        interrupt::check(self.time())?;
        let h = self.steps.h.value();
        for [r, r_dot, p, p_dot] in &mut self.sites {
            *r += h * *r_dot;
            *p += h * *p_dot;
        }
        let potential = self.forces();
        let scale = if potential > 0.0 { 1.0 / (2.0 * potential).sqrt() } else { 0.0 };
        let Self { chain, sites, before, psi, force, pushes, .. } = self;
        for (i, push) in pushes.iter_mut().enumerate() {
            *push = scale * chain.push(i, force);
        }
        // `gamma` times a velocity, by bonds: on a ring of strains sites have no momenta of their own.
        let free = |i: usize| 2.0 * (sites[i][1] + sites[i][3]) - h * chain.stiffness * sites[i][2];
        let (mut work, mut size) = (0.0, 0.0);
        for (b, force) in force.iter().enumerate().filter(|(_, force)| **force > 0.0) {
            work += scale * force * chain.rate(b, free);
            size -= scale * force * (chain.m + chain.mu) * chain.rate(b, |i| pushes[i]);
        }
        let rise = 0.5 * h * (work - h * size * *psi) / (1.0 + 0.25 * h * h * size);
        let mean = *psi + 0.5 * rise;
        *psi += rise;
        for (([_, r_dot, p, p_dot], push), before) in sites.iter_mut().zip(&*pushes).zip(before) {
            *before = [*r_dot, *p_dot];
            *r_dot += h * chain.m * mean * push;
            *p_dot += h * (chain.mu * mean * push - chain.stiffness * *p);
        }
        self.steps.taken += 1;
        Ok(())
    }

    /// Velocities at the end of a step are the means of those half a step before and after. Times
    /// inside the last step are reached by a step of the discrete gradient.
    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let mut sites = self.sites.clone();
        for ([_, r_dot, _, p_dot], [r_before, p_before]) in sites.iter_mut().zip(&self.before) {
            *r_dot = 0.5 * (*r_dot + r_before);
            *p_dot = 0.5 * (*p_dot + p_before);
        }
        let phi = vec![0.0; self.force.len()];
        self.chain.sample(sites, &phi, self.steps.since(t), y);
    }

    fn stats(&self) -> Stats {
        Stats { steps: self.steps.taken, rejected: 0, force_evaluations: self.steps.taken + 1 }
    }
}
