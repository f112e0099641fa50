//! Beads on the exact paths of the linear flow, as contact-corrected splitting moves them.

use super::{
    super::{Chain, LinearFlow},
    Forces, Modified, SiteFlow,
    forces::add,
};
use hertzchain_integrators::{Kernel, Real, splitting::corrected::Correction};

impl SiteFlow for LinearFlow<f64> {
    fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    fn survey(&mut self, forces: Forces<'_>) {
        self.phase = self.theta.sin_cos();
        f64::run(Survey { flow: self, forces });
    }

    fn bead(&self, site: usize) -> (f64, f64) {
        let [r, r_dot, p, p_dot] = self.motions(site, self.phase);
        (r + p, r_dot + p_dot)
    }

    #[inline]
    fn motion(&self, site: usize) -> [f64; 3] {
        let [_, r_dot, p, p_dot] = self.motions(site, self.phase);
        [r_dot + p_dot, p, p_dot]
    }

    fn response(&self) -> (f64, f64, f64) {
        (self.m(), self.mu(), self.omega.value())
    }

    fn spring(&self, _site: usize) -> (f64, f64) {
        (0.0, 0.0)
    }

    fn shift(&self, correction: &Correction) -> f64 {
        let &Correction { impulse, displacement, at, turn: [sin, cos], .. } = correction;
        self.m() * (displacement - impulse * at)
            + (self.mu() * (displacement * cos) - self.mu_over_omega * (impulse * sin))
    }

    fn give(&mut self, beads: &[(usize, f64)], correction: &Correction) {
        let [by_r0, by_v, by_c, by_s] = self.shares(correction);
        if let [r0, v] = &mut self.centre
            && !v.is_empty()
        {
            for &(site, weight) in beads {
                r0[site] += weight * by_r0;
                v[site] += weight * by_v;
            }
        }
        if let [c, s] = &mut self.oscillation
            && !s.is_empty()
        {
            for &(site, weight) in beads {
                c[site] += weight * by_c;
                s[site] += weight * by_s;
            }
        }
    }

    fn give_resonator(&mut self, _site: usize, _impulse: f64, _displacement: f64) {}

    fn push(&mut self, kick: f64, forces: Modified<'_>, _a: &[f64]) {
        self.count_kick();
        f64::run(Push { flow: self, kick, forces });
    }
}

impl LinearFlow<f64> {
    /// What a correction adds to `R0, V, C, S` of a bead.
    #[inline]
    pub(super) fn shares(&self, correction: &Correction) -> [f64; 4] {
        let &Correction { impulse, displacement, at, turn: [turn_sin, turn_cos], .. } = correction;
        let (m, mu, (sin, cos)) = (self.m(), self.mu(), self.phase);
        let (sin, cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
        [
            m * (displacement - impulse * (self.tau + at)),
            m * impulse,
            mu * (displacement * cos) - self.mu_over_omega * (impulse * sin),
            mu * (displacement * sin) + self.mu_over_omega * (impulse * cos),
        ]
    }
}

struct Survey<'a> {
    flow: &'a LinearFlow<f64>,
    forces: Forces<'a>,
}

impl Kernel for Survey<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { flow, mut forces } = self;
        let ([r0, v], [c, s]) = (&flow.centre, &flow.oscillation);
        let ((sin, cos), tau) = (flow.phase, flow.tau);
        let u = forces.positions();
        match (r0.is_empty(), c.is_empty()) {
            (false, false) => sums_of_four([r0, v, c, s], [tau, cos, sin], u),
            (false, true) => sums_of_two([r0, v], [1.0, tau], u),
            _ => sums_of_two([c, s], [cos, sin], u),
        }
        forces.compute();
    }
}

#[inline(always)]
fn sums_of_four([r0, v, c, s]: [&[f64]; 4], [tau, cos, sin]: [f64; 3], u: &mut [f64]) {
    let n = u.len();
    let (r0, v, c, s) = (&r0[..n], &v[..n], &c[..n], &s[..n]);
    for i in 0..n {
        u[i] = (r0[i] + v[i] * tau) + (c[i] * cos + s[i] * sin);
    }
}

#[inline(always)]
fn sums_of_two([x, y]: [&[f64]; 2], [by_x, by_y]: [f64; 2], u: &mut [f64]) {
    for ((u, x), y) in u.iter_mut().zip(x).zip(y) {
        *u = x * by_x + y * by_y;
    }
}

struct Push<'a> {
    flow: &'a mut LinearFlow<f64>,
    kick: f64,
    forces: Modified<'a>,
}

impl Kernel for Push<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { flow, kick, mut forces } = self;
        forces.compute();
        let (sin, cos) = flow.phase;
        let (kick_v, per_omega) = (kick * flow.m(), kick * flow.mu_over_omega);
        let ([r0, v], [c, s]) = (&mut flow.centre, &mut flow.oscillation);
        add(-(kick_v * flow.tau), forces.push, r0);
        add(kick_v, forces.push, v);
        add(-(per_omega * sin), forces.push, c);
        add(per_omega * cos, forces.push, s);
    }
}
