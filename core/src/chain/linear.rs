//! The split exact linear flow + contact kick, in variables that the linear flow leaves alone.
//!
//! | symbol | meaning |
//! |---|---|
//! | `R, P` | the two motions of a site, and `m, mu` the shares of an impulse that they take, see [`Modes`](super::Modes) |
//! | `R0, V; C, S` | `R(t) = R0 + V tau`, `P(t) = C cos theta + S sin theta` |
//! | `theta, tau` | phase `omega t`; time since `R0` was last moved |
//!
//! An impulse `j` on a bead changes `R'` by `m j` and `P'` by `mu j`; so it adds `m j` to `V`,
//! `-m j tau` to `R0`, `-mu j sin(theta)/omega` to `C` and `mu j cos(theta)/omega` to `S`. Between
//! kicks nothing is computed at all: no rotation is repeated, so no rounding of one piles up, and
//! where no contact acts the state keeps its bits for ever. The phase is one number for the whole
//! chain, kept to twice the working precision.

use super::{
    Chain, Resonators,
    aligned::Aligned,
    averaged::Bonds,
    sweep::{Sites, sweep},
};
use hertzchain_integrators::{Real, SplitFlow, Twofold};

/// Kicks after which `R0` is moved along, so that `V tau` stays of the size of `R0`. Chosen, not
/// measured.
const KICKS_BETWEEN_ANCHORS: u32 = 64;

/// A chain split into its exact linear flow and its contacts.
pub struct LinearFlow<R> {
    pub(super) chain: Chain<R>,
    /// `[R0, V]`, without the cradle's.
    pub(super) centre: [Aligned<R>; 2],
    /// `[C, S]`, without the plain chain's.
    pub(super) oscillation: [Aligned<R>; 2],
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
        let (modes, resonators) = (chain.modes(), chain.params().resonators());
        Self {
            centre: arrays(resonators != Resonators::Fixed),
            oscillation: arrays(resonators != Resonators::None),
            mu_over_omega: modes.mu_over_omega(),
            omega: modes.omega,
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

    /// `m`.
    pub(super) fn m(&self) -> R {
        self.chain.modes().m
    }

    /// `mu`.
    pub(super) fn mu(&self) -> R {
        self.chain.modes().mu
    }

    /// Moves `R0` along when it is time to.
    pub(super) fn count_kick(&mut self) {
        if self.kicks == KICKS_BETWEEN_ANCHORS {
            self.anchor();
        }
        self.kicks += 1;
    }

    /// `[R, R', P, P']` of site `i`, now.
    #[inline]
    pub(super) fn motions(&self, i: usize, phase: (R, R)) -> [R; 4] {
        let (r, r_dot) = match &self.centre {
            [r0, v] if !r0.is_empty() => (r0[i] + v[i] * self.tau, v[i]),
            _ => (R::zero(), R::zero()),
        };
        let [p, p_dot] = match &self.oscillation {
            [c, s] if !c.is_empty() => turned([c[i], s[i]], phase, self.omega.value()),
            _ => [R::zero(); 2],
        };
        [r, r_dot, p, p_dot]
    }
}

/// `P` and `P'` from `C` and `S`.
#[inline(always)]
fn turned<R: Real>([c, s]: [R; 2], (sin, cos): (R, R), omega: R) -> [R; 2] {
    [c * cos + s * sin, omega * (s * cos - c * sin)]
}

impl<R: Real> SplitFlow<R> for LinearFlow<R> {
    fn dim(&self) -> usize {
        self.chain.layout().dim()
    }

    fn load(&mut self, y: &[R]) {
        let (layout, modes, omega) = (self.chain.layout(), self.chain.modes(), self.omega.value());
        (self.theta, self.tau, self.kicks) = (Twofold::zero(), R::zero(), 0);
        self.phase = (R::zero(), R::one());
        let (u, u_dot, v, v_dot) = (layout.u(y), layout.u_dot(y), layout.v(y), layout.v_dot(y));
        for i in 0..u.len() {
            let of = |array: Option<&[R]>| array.map_or(R::zero(), |array| array[i]);
            let [r, r_dot, p, p_dot] = modes.split([u[i], of(v), u_dot[i], of(v_dot)]);
            if let [r0, v] = &mut self.centre
                && !v.is_empty()
            {
                (r0[i], v[i]) = (r, r_dot);
            }
            if let [c, s] = &mut self.oscillation
                && !s.is_empty()
            {
                (c[i], s[i]) = (p, p_dot / omega);
            }
        }
    }

    fn store(&self, y: &mut [R]) {
        let (n, half, modes) = (self.chain.sites(), self.dim() / 2, self.chain.modes());
        let phase = self.theta.sin_cos();
        let (positions, velocities) = y.split_at_mut(half);
        let (u, v) = positions.split_at_mut(n);
        let (u_dot, v_dot) = velocities.split_at_mut(n);
        if !self.chain.layout().resonators() {
            for i in 0..n {
                [u[i], _, u_dot[i], _] = modes.join(self.motions(i, phase));
            }
            return;
        }
        // Both motions are there: a loop without branches, with what `motions` says of a site.
        let ([r0, v0], [c, s]) = (&self.centre, &self.oscillation);
        let (r0, v0, c, s) = (&r0[..n], &v0[..n], &c[..n], &s[..n]);
        let (v, v_dot, omega, tau) = (&mut v[..n], &mut v_dot[..n], self.omega.value(), self.tau);
        for i in 0..n {
            let [p, p_dot] = turned([c[i], s[i]], phase, omega);
            [u[i], v[i], u_dot[i], v_dot[i]] = modes.join([r0[i] + v0[i] * tau, v0[i], p, p_dot]);
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
        let (kick_v, per_omega) = (kick * self.m(), kick * self.mu_over_omega);
        let Self { chain, centre: [r0, v], oscillation: [c, s], .. } = self;
        let centre = Centre { r0, v, tau, kick_r0: -(kick_v * tau), kick_v };
        let oscillation = Oscillation { c, s, cos, sin, kick_c: -(per_omega * sin), kick_s: per_omega * cos };
        match chain.params().resonators() {
            Resonators::None => sweep(chain, &mut Moved::<R, true, false> { centre, oscillation }),
            Resonators::Fixed => sweep(chain, &mut Moved::<R, false, true> { centre, oscillation }),
            Resonators::Moving => sweep(chain, &mut Moved::<R, true, true> { centre, oscillation }),
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
struct Moved<'a, R, const CENTRE: bool, const OSCILLATION: bool> {
    centre: Centre<'a, R>,
    oscillation: Oscillation<'a, R>,
}

impl<R: Real, const CENTRE: bool, const OSCILLATION: bool> Sites<R> for Moved<'_, R, CENTRE, OSCILLATION> {
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
