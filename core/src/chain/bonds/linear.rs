//! Beads on the exact paths of the linear flow, as contact-corrected splitting moves them.

use super::{
    super::{Chain, LinearFlow, sweep::Swept},
    Forces, Fused, Lanes, Modified, SiteFlow,
    fused::FusedRow,
    gathered,
};
use hertzchain_integrators::{DoubleDouble, Vector, splitting::corrected::Correction};

impl SiteFlow for LinearFlow<f64> {
    fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    fn evaluate(&mut self, forces: Forces<'_>) {
        self.visit(self.now(0.0), forces);
    }

    fn bead(&self, site: usize) -> (f64, f64) {
        let [r, r_dot, p, p_dot] = self.motions(site, self.phase.sin_cos());
        (r + p, r_dot + p_dot)
    }

    #[inline(always)]
    fn motions_at<V: Vector<f64>>(&self, sites: &Lanes) -> [V; 3] {
        let ([_, v], [c, s], (sin, cos)) = (&self.centre, &self.oscillation, self.phase.sin_cos());
        let (v, c, s): (V, V, V) = (gathered(v, sites), gathered(c, sites), gathered(s, sites));
        let (sin, cos, omega) = (V::all(sin), V::all(cos), V::all(self.omega()));
        let p_dot = omega * (s * cos - c * sin);
        [v + p_dot, c * cos + s * sin, p_dot]
    }

    const RESTS: bool = true;

    fn rest(&self, site: usize) -> [f64; 4] {
        let [r, r_dot, p, p_dot] = self.motions(site, self.phase.sin_cos());
        [r, r_dot, p, if p_dot == 0.0 { p_dot } else { p_dot / self.omega() }]
    }

    #[inline(always)]
    fn response(&self) -> (f64, f64, f64) {
        (self.m, self.mu(), self.omega())
    }

    fn spring(&self, _site: usize) -> (f64, f64) {
        (0.0, 0.0)
    }

    #[inline(always)]
    fn shift(&self, correction: &Correction) -> f64 {
        let &Correction { impulse, displacement, at, turn: [sin, cos], .. } = correction;
        self.m * (displacement - impulse * at)
            + (self.mu() * (displacement * cos) - self.mu_over_omega * (impulse * sin))
    }

    #[inline(always)]
    fn give(&mut self, beads: &[(usize, f64)], correction: &Correction) {
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

    fn give_resonator(&mut self, _site: usize, _impulse: f64, _displacement: f64) {}

    fn push(&mut self, kick: f64, forces: Modified<'_>, _a: &[f64]) {
        self.count_kick();
        self.visit(self.now(kick), forces);
    }

    fn push_and_evaluate(&mut self, pairs: &[(f64, DoubleDouble<f64>)], fused: Fused<'_>) -> usize {
        self.count_kick();
        let most = self.kicks_to_anchor().min(pairs.len());
        let made = self.in_row(pairs[..most].iter().copied(), |clock| FusedRow { fused, clock, kicks: most });
        self.kicks += made as u32 - 1;
        made
    }
}

impl LinearFlow<f64> {
    /// The numbers that a correction adds to `R0, V, C, S` of a bead.
    #[inline(always)]
    pub(super) fn shares(&self, correction: &Correction) -> [f64; 4] {
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
