//! The split exact linear flow + contact kick, in variables that the linear flow leaves alone.
//!
//! | symbol | meaning |
//! |---|---|
//! | `R = (u + rho v)/(1 + rho)` | centre of mass of a bead and its resonator; moves freely |
//! | `P = rho (u - v)/(1 + rho)` | oscillates with `omega`; `u = R + P`, `v = R - P/rho` |
//! | `R0, V; C, S` | `R(t) = R0 + V tau`, `P(t) = C cos theta + S sin theta` |
//! | `theta, tau` | phase `omega t`; time since `R0` was last moved |
//! | `m, mu` | `1/(1 + rho)`, `rho/(1 + rho)` |
//!
//! An impulse `j` on a bead changes `R'` by `m j` and `P'` by `mu j`; so it adds `m j` to `V`, `-m j tau` to `R0`,
//! `-mu j sin(theta)/omega` to `C` and `mu j cos(theta)/omega` to `S`. Between kicks nothing is computed at all: no
//! rotation is repeated, so no rounding of one piles up, and where no contact acts the state keeps its bits for ever. The
//! phase is one number for the whole chain, kept to twice the working precision.
//!
//! A plain chain has `R` only, with `m = 1`; the cradle has `P` only, with `mu = 1`.

use super::{
    Chain, Resonators,
    aligned::Aligned,
    averaged::Bonds,
    sweep::{Sites, sweep},
};
use hertzchain_integrators::{Real, SplitFlow, Twofold};

/// Kicks after which `R0` is moved along, so that `V tau` stays of the size of `R0`.
const KICKS_BETWEEN_ANCHORS: u32 = 64;

/// A chain split into its exact linear flow and its contacts.
pub struct LinearFlow<R> {
    pub(super) chain: Chain<R>,
    /// `[R0, V]`, without the cradle's.
    pub(super) centre: [Aligned<R>; 2],
    /// `[C, S]`, without the plain chain's.
    pub(super) oscillation: [Aligned<R>; 2],
    /// `m, mu`: the shares of an impulse that go to `R'` and to `P'`.
    pub(super) m: R,
    mu: R,
    pub(super) mu_over_omega: R,
    pub(super) omega: Twofold<R>,
    two_pi: Twofold<R>,
    /// The last drift, and by how much it turned the phase.
    turn: (Twofold<R>, Twofold<R>),
    pub(super) theta: Twofold<R>,
    pub(super) tau: R,
    /// Sine and cosine of `theta`, where bonds are asked for.
    pub(super) phase: (R, R),
    kicks: u32,
    /// What averaged kicks work with; empty until there is one.
    pub(super) bonds: Bonds<R>,
}

impl<R: Real> LinearFlow<R> {
    /// The chain at rest; load a state into it.
    pub fn new(chain: Chain<R>) -> Self {
        let n = chain.sites();
        let arrays = |needed: bool| {
            let len = if needed { n } else { 0 };
            [Aligned::zeros(len), Aligned::zeros(len)]
        };
        let params = chain.params();
        let (one, rho, omega) = (R::one(), R::of(params.rho), params.omega_twofold());
        let (m, mu) = match params.resonators() {
            Resonators::None => (one, R::zero()),
            Resonators::Fixed => (R::zero(), one),
            Resonators::Moving => (one / (one + rho), one / (one + one / rho)),
        };
        Self {
            centre: arrays(params.resonators() != Resonators::Fixed),
            oscillation: arrays(params.resonators() != Resonators::None),
            m,
            mu,
            mu_over_omega: if params.resonators() == Resonators::None { mu } else { mu / omega.value() },
            omega,
            two_pi: Twofold::two_pi(),
            turn: (Twofold::zero(), Twofold::zero()),
            theta: Twofold::zero(),
            tau: R::zero(),
            phase: (R::zero(), R::one()),
            kicks: 0,
            bonds: Bonds::new(),
            chain,
        }
    }

    /// `R0 <- R0 + V tau`, `tau <- 0`.
    fn anchor(&mut self) {
        let tau = self.tau;
        let [r0, v] = &mut self.centre;
        for (r0, &v) in r0.iter_mut().zip(v.iter()) {
            *r0 += v * tau;
        }
        self.tau = R::zero();
        self.kicks = 0;
    }

    /// `mu`.
    pub(super) fn mu(&self) -> R {
        self.mu
    }

    /// Moves `R0` along when it is time to.
    pub(super) fn count_kick(&mut self) {
        if self.kicks == KICKS_BETWEEN_ANCHORS {
            self.anchor();
        }
        self.kicks += 1;
    }

    /// `(R, R', P, P')` of site `i`, now.
    #[inline]
    pub(super) fn modes(&self, i: usize, (sin, cos): (R, R)) -> (R, R, R, R) {
        let omega = self.omega.value();
        let (r, v) = match &self.centre {
            [r0, v] if !r0.is_empty() => (r0[i] + v[i] * self.tau, v[i]),
            _ => (R::zero(), R::zero()),
        };
        match &self.oscillation {
            [c, s] if !c.is_empty() => (r, v, c[i] * cos + s[i] * sin, omega * (s[i] * cos - c[i] * sin)),
            _ => (r, v, R::zero(), R::zero()),
        }
    }
}

impl<R: Real> SplitFlow<R> for LinearFlow<R> {
    fn dim(&self) -> usize {
        self.chain.layout().dim()
    }

    fn load(&mut self, y: &[R]) {
        let layout = self.chain.layout();
        let (u, u_dot) = (layout.u(y), layout.u_dot(y));
        let omega = self.omega.value();
        (self.theta, self.tau, self.kicks) = (Twofold::zero(), R::zero(), 0);
        self.phase = (R::zero(), R::one());
        match (layout.v(y), layout.v_dot(y)) {
            (Some(v), Some(v_dot)) => {
                let (m, mu) = (self.m, self.mu);
                for i in 0..u.len() {
                    self.centre[0][i] = m * u[i] + mu * v[i];
                    self.centre[1][i] = m * u_dot[i] + mu * v_dot[i];
                    self.oscillation[0][i] = mu * (u[i] - v[i]);
                    self.oscillation[1][i] = mu * (u_dot[i] - v_dot[i]) / omega;
                }
            }
            _ if self.oscillation[0].is_empty() => {
                self.centre[0].copy_from_slice(u);
                self.centre[1].copy_from_slice(u_dot);
            }
            _ => {
                self.oscillation[0].copy_from_slice(u);
                for (s, &u_dot) in self.oscillation[1].iter_mut().zip(u_dot) {
                    *s = u_dot / omega;
                }
            }
        }
    }

    fn store(&self, y: &mut [R]) {
        let (n, half, rho) = (self.chain.sites(), self.dim() / 2, R::of(self.chain.params().rho));
        let phase = self.theta.sin_cos();
        let (positions, velocities) = y.split_at_mut(half);
        let (u, v) = positions.split_at_mut(n);
        let (u_dot, v_dot) = velocities.split_at_mut(n);
        if !self.chain.layout().resonators() {
            for i in 0..n {
                let (r, r_dot, p, p_dot) = self.modes(i, phase);
                (u[i], u_dot[i]) = (r + p, r_dot + p_dot);
            }
            return;
        }
        // Both motions are there: a loop without branches, with what `modes` says of a site.
        let ([r0, v0], [c, s]) = (&self.centre, &self.oscillation);
        let (r0, v0, c, s) = (&r0[..n], &v0[..n], &c[..n], &s[..n]);
        let (v, v_dot, (sin, cos), (omega, tau)) =
            (&mut v[..n], &mut v_dot[..n], phase, (self.omega.value(), self.tau));
        for i in 0..n {
            let (r, r_dot) = (r0[i] + v0[i] * tau, v0[i]);
            let (p, p_dot) = (c[i] * cos + s[i] * sin, omega * (s[i] * cos - c[i] * sin));
            (u[i], u_dot[i]) = (r + p, r_dot + p_dot);
            (v[i], v_dot[i]) = (r - p / rho, r_dot - p_dot / rho);
        }
    }

    fn duplicate(&self) -> Self {
        let mut copy = Self::new(self.chain.clone());
        copy.copy_from(self);
        copy
    }

    fn copy_from(&mut self, other: &Self) {
        for (to, from) in self.centre.iter_mut().zip(&other.centre) {
            to.copy_from_slice(from);
        }
        for (to, from) in self.oscillation.iter_mut().zip(&other.oscillation) {
            to.copy_from_slice(from);
        }
        (self.theta, self.tau, self.kicks) = (other.theta, other.tau, other.kicks);
        self.phase = other.phase;
    }

    fn drift(&mut self, dt: Twofold<R>) {
        if self.turn.0 != dt {
            self.turn = (dt, self.omega * dt);
        }
        self.theta = (self.theta + self.turn.1).reduced(self.two_pi);
        self.tau += dt.value();
    }

    fn kick_drift(&mut self, kick: R, drift: Twofold<R>) {
        self.count_kick();
        let ((sin, cos), tau) = (self.theta.sin_cos(), self.tau);
        let (kick_v, per_omega) = (kick * self.m, kick * self.mu_over_omega);
        let Self { chain, centre: [r0, v], oscillation: [c, s], .. } = self;
        let centre = Centre { r0, v, tau, kick_r0: -(kick_v * tau), kick_v };
        let oscillation = Oscillation { c, s, cos, sin, kick_c: -(per_omega * sin), kick_s: per_omega * cos };
        match chain.params().resonators() {
            Resonators::None => sweep(chain, &mut Modes::<R, true, false> { centre, oscillation }),
            Resonators::Fixed => sweep(chain, &mut Modes::<R, false, true> { centre, oscillation }),
            Resonators::Moving => sweep(chain, &mut Modes::<R, true, true> { centre, oscillation }),
        }
        self.drift(drift);
    }
}

struct Centre<'a, R> {
    r0: &'a mut [R],
    v: &'a mut [R],
    tau: R,
    kick_r0: R,
    kick_v: R,
}

struct Oscillation<'a, R> {
    c: &'a mut [R],
    s: &'a mut [R],
    cos: R,
    sin: R,
    kick_c: R,
    kick_s: R,
}

/// The sites in the variables of the linear flow, compiled without the parts that a model lacks.
struct Modes<'a, R, const CENTRE: bool, const OSCILLATION: bool> {
    centre: Centre<'a, R>,
    oscillation: Oscillation<'a, R>,
}

impl<R: Real, const CENTRE: bool, const OSCILLATION: bool> Sites<R> for Modes<'_, R, CENTRE, OSCILLATION> {
    #[inline(always)]
    fn position(&self, i: usize) -> R {
        self.positions(i, &mut [R::zero()])[0]
    }

    #[inline(always)]
    fn positions<'b>(&'b self, start: usize, q: &'b mut [R]) -> &'b [R] {
        let (len, range) = (q.len(), start..start + q.len());
        let (centre, osc) = (&self.centre, &self.oscillation);
        match (CENTRE, OSCILLATION) {
            (true, true) => {
                let (r0, v) = (&centre.r0[range.clone()], &centre.v[range.clone()]);
                let (c, s) = (&osc.c[range.clone()], &osc.s[range]);
                for i in 0..len {
                    q[i] = (r0[i] + v[i] * centre.tau) + (c[i] * osc.cos + s[i] * osc.sin);
                }
            }
            (true, false) => {
                let (r0, v) = (&centre.r0[range.clone()], &centre.v[range]);
                for i in 0..len {
                    q[i] = r0[i] + v[i] * centre.tau;
                }
            }
            _ => {
                let (c, s) = (&osc.c[range.clone()], &osc.s[range]);
                for i in 0..len {
                    q[i] = c[i] * osc.cos + s[i] * osc.sin;
                }
            }
        }
        q
    }

    #[inline(always)]
    fn update(&mut self, start: usize, len: usize, force: impl Fn(usize) -> R) {
        let range = start..start + len;
        let (centre, osc) = (&mut self.centre, &mut self.oscillation);
        match (CENTRE, OSCILLATION) {
            (true, true) => {
                let (r0, v) = (&mut centre.r0[range.clone()], &mut centre.v[range.clone()]);
                let (c, s) = (&mut osc.c[range.clone()], &mut osc.s[range]);
                for i in 0..len {
                    let force = force(i);
                    r0[i] += centre.kick_r0 * force;
                    v[i] += centre.kick_v * force;
                    c[i] += osc.kick_c * force;
                    s[i] += osc.kick_s * force;
                }
            }
            (true, false) => {
                let (r0, v) = (&mut centre.r0[range.clone()], &mut centre.v[range]);
                for i in 0..len {
                    let force = force(i);
                    r0[i] += centre.kick_r0 * force;
                    v[i] += centre.kick_v * force;
                }
            }
            _ => {
                let (c, s) = (&mut osc.c[range.clone()], &mut osc.s[range]);
                for i in 0..len {
                    let force = force(i);
                    c[i] += osc.kick_c * force;
                    s[i] += osc.kick_s * force;
                }
            }
        }
    }
}
