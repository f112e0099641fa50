//! Beads on the exact paths of the linear flow, as contact-corrected splitting moves them.

use super::{
    super::{Chain, LinearFlow, sweep::Swept},
    forces::{Forces, Modified},
    fused::{Fused, FusedRow},
};
use hertzchain_integrators::{DoubleDouble, splitting::corrected::Correction};

impl LinearFlow<f64> {
    pub(super) fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    /// Writes the positions of sites into `forces`, and computes overlaps and forces from them.
    pub(super) fn evaluate(&mut self, forces: Forces<'_>) {
        self.visit(self.now(0.0), forces);
    }

    /// Position and velocity of a bead.
    pub(super) fn bead(&self, site: usize) -> (f64, f64) {
        let [r, r_dot, p, p_dot] = self.motions(site, self.phase.sin_cos());
        (r + p, r_dot + p_dot)
    }

    /// `[velocity, p, p']` of a bead; `p` is the part of its position that oscillates with `omega`
    /// in the drift.
    #[inline]
    pub(super) fn motion(&self, site: usize) -> [f64; 3] {
        let [_, v, p, p_dot] = self.motions(site, self.phase.sin_cos());
        [v + p_dot, p, p_dot]
    }

    /// `[r, r', p, p'/omega]` of a bead: position and velocity of its free motion, position and
    /// velocity over `omega` of its oscillation.
    pub(super) fn rest(&self, site: usize) -> [f64; 4] {
        let [r, r_dot, p, p_dot] = self.motions(site, self.phase.sin_cos());
        [r, r_dot, p, if p_dot == 0.0 { p_dot } else { p_dot / self.omega() }]
    }

    /// `(m, mu, omega)`: a unit impulse on a bead changes the velocity of its free motion by `m`
    /// and that of its oscillation with `omega` in the drift by `mu`.
    #[inline(always)]
    pub(super) fn response(&self) -> (f64, f64, f64) {
        (self.m, self.mu(), self.omega())
    }

    /// Change of a bead's position at the present time by a correction.
    #[inline(always)]
    pub(super) fn shift(&self, correction: &Correction) -> f64 {
        let &Correction { impulse, displacement, at, turn: [sin, cos], .. } = correction;
        self.m * (displacement - impulse * at)
            + (self.mu() * (displacement * cos) - self.mu_over_omega * (impulse * sin))
    }

    /// Gives each bead of the list, of sites and weights, the correction times its weight.
    #[inline(always)]
    pub(super) fn give(&mut self, beads: &[(usize, f64)], correction: &Correction) {
        let [by_r0, by_v, by_c, by_s] = self.shares(correction);
        let [r0, v] = self.centre.each_mut().map(|column| &mut column[..]);
        if !v.is_empty() {
            for &(site, weight) in beads {
                r0[site] += weight * by_r0;
                v[site] += weight * by_v;
            }
        }
        let [c, s] = self.oscillation.each_mut().map(|column| &mut column[..]);
        if !s.is_empty() {
            for &(site, weight) in beads {
                c[site] += weight * by_c;
                s[site] += weight * by_s;
            }
        }
    }

    /// Kicks beads by `kick` times modified forces.
    pub(super) fn push(&mut self, kick: f64, forces: Modified<'_>) {
        self.count_kick();
        self.visit(self.now(kick), forces);
    }

    /// [`push`](Self::push), drift and [`evaluate`](Self::evaluate) in one pass; at most once for
    /// each of `pairs`, the durations of a kick and a drift. Returns how many passes were made.
    pub(super) fn push_and_evaluate(&mut self, pairs: &[(f64, DoubleDouble<f64>)], fused: Fused<'_>) -> usize {
        self.count_kick();
        let most = self.kicks_to_anchor().min(pairs.len());
        let made = self.in_row(pairs[..most].iter().copied(), |clock| FusedRow { fused, clock, kicks: most });
        self.kicks += made as u32 - 1;
        made
    }

    /// The numbers that a correction adds to `R0, V, C, S` of a bead.
    #[inline(always)]
    fn shares(&self, correction: &Correction) -> [f64; 4] {
        let &Correction { impulse, displacement, at, turn: [turn_sin, turn_cos], .. } = correction;
        let (m, mu, mu_over_omega) = (self.m, self.mu(), self.mu_over_omega);
        let (sin, cos) = self.phase.sin_cos();
        let (sin, cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
        [
            m * (displacement - impulse * (self.tau + at)),
            m * impulse,
            mu * (displacement * cos) - mu_over_omega * (impulse * sin),
            mu * (displacement * sin) + mu_over_omega * (impulse * cos),
        ]
    }
}
