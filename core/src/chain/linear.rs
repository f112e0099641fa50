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
    phase::Phase,
    sweep::{MOST_KICKS, Sites, Step, Swept, Visit, follow, long},
};
use hertzchain_integrators::{Column, Real, SplitFlow, Twofold, Vector};

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
    pub(super) phase: Phase<R>,
    pub(super) tau: R,
    kicks: u32,
    /// What averaged kicks work with; empty until there is one.
    pub(super) bonds: Bonds<R>,
}

impl<R: Real> LinearFlow<R> {
    /// The chain at rest; load a state into it.
    ///
    /// # Panics
    /// A chain with details: [`SitewiseFlow`](super::SitewiseFlow) is made for it.
    pub fn new(chain: Chain<R>) -> Self {
        assert!(chain.details().is_none(), "a chain with details flows site by site");
        let n = chain.sites();
        let (modes, resonators) = (chain.modes(), chain.params().resonators());
        let none = || Aligned::together(0);
        let (centre, oscillation) = match resonators {
            Resonators::None => (Aligned::together(n), none()),
            Resonators::Fixed => (none(), Aligned::together(n)),
            Resonators::Moving => {
                let [r0, v, c, s] = Aligned::together(n);
                ([r0, v], [c, s])
            }
        };
        Self {
            centre,
            oscillation,
            mu_over_omega: modes.mu_over_omega(),
            phase: Phase::new(modes.omega),
            tau: R::zero(),
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

    /// `omega`.
    pub(super) fn omega(&self) -> R {
        self.phase.omega.value()
    }

    /// `[R, R', P, P']` of site `i`, now.
    #[inline]
    pub(super) fn motions(&self, i: usize, phase: (R, R)) -> [R; 4] {
        let (r, r_dot) = match &self.centre {
            [r0, v] if !r0.is_empty() => (r0[i] + v[i] * self.tau, v[i]),
            _ => (R::zero(), R::zero()),
        };
        let [p, p_dot] = match &self.oscillation {
            [c, s] if !c.is_empty() => turned([c[i], s[i]], phase, self.omega()),
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
        let (layout, modes, omega) = (self.chain.layout(), self.chain.modes(), self.omega());
        self.phase.reset();
        (self.tau, self.kicks) = (R::zero(), 0);
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
        let phase = self.phase.sin_cos();
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
        let (v, v_dot, omega, tau) = (&mut v[..n], &mut v_dot[..n], self.omega(), self.tau);
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
        self.phase.copy_from(&other.phase);
        (self.tau, self.kicks) = (other.tau, other.kicks);
    }

    #[inline]
    fn drift(&mut self, dt: Twofold<R>) {
        self.phase.advance(dt);
        self.tau += dt.value();
    }

    fn kick_drift(&mut self, kick: R, drift: Twofold<R>) {
        // The drift changes no number of a site: its rotation is computed beside the pass.
        self.count_kick();
        let now = self.begin(kick, drift);
        self.visit(now, Step);
    }

    fn kick_drifts(&mut self, pairs: &[(R, Twofold<R>)]) {
        let mut rest = pairs;
        while long(&self.chain) && rest.len() > 1 {
            self.count_kick();
            // No anchor between kicks that follow each other.
            let most = (1 + KICKS_BETWEEN_ANCHORS - self.kicks) as usize;
            let (now, later) = rest.split_at(rest.len().min(MOST_KICKS).min(most));
            self.kicks += now.len() as u32 - 1;
            follow(self, now);
            rest = later;
        }
        rest.iter().for_each(|&(kick, drift)| self.kick_drift(kick, drift));
    }
}

impl<R: Real> Swept<R> for LinearFlow<R> {
    type Moment = Now<R>;

    fn swept(&self) -> &Chain<R> {
        &self.chain
    }

    #[inline]
    fn begin(&mut self, kick: R, drift: Twofold<R>) -> Now<R> {
        let now = self.now(kick);
        self.drift(drift);
        now
    }

    #[inline(always)]
    fn visit(&mut self, ((sin, cos), tau, kick): Now<R>, work: impl Visit<R>) {
        let (kick_v, per_omega) = (kick * self.m(), kick * self.mu_over_omega);
        let Self { chain, centre: [r0, v], oscillation: [c, s], .. } = self;
        let centre = Centre { r0: r0.column(), v: v.column(), tau, kick_r0: -(kick_v * tau), kick_v };
        let (kick_c, kick_s) = (-(per_omega * sin), per_omega * cos);
        let oscillation = Oscillation { c: c.column(), s: s.column(), cos, sin, kick_c, kick_s };
        match chain.params().resonators() {
            Resonators::None => work.visit(chain, centre),
            Resonators::Fixed => work.visit(chain, oscillation),
            Resonators::Moving => work.visit(chain, Both { centre, oscillation }),
        }
    }
}

/// Sine and cosine of the phase, `tau`, and the duration of the kick.
pub(super) type Now<R> = ((R, R), R, R);

impl<R: Real> LinearFlow<R> {
    /// What positions, and a kick over `kick`, depend on.
    #[inline]
    pub(super) fn now(&self, kick: R) -> Now<R> {
        (self.phase.sin_cos(), self.tau, kick)
    }
}

/// Sites that move freely: all of a plain chain.
struct Centre<'a, R> {
    r0: Column<'a, R>,
    v: Column<'a, R>,
    tau: R,
    kick_r0: R,
    kick_v: R,
}

/// Sites that oscillate: all of a cradle.
struct Oscillation<'a, R> {
    c: Column<'a, R>,
    s: Column<'a, R>,
    cos: R,
    sin: R,
    kick_c: R,
    kick_s: R,
}

/// Sites that do both.
struct Both<'a, R> {
    centre: Centre<'a, R>,
    oscillation: Oscillation<'a, R>,
}

impl<R: Real> Sites<R> for Centre<'_, R> {
    #[inline(always)]
    fn room(&self) -> usize {
        self.r0.len().min(self.v.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize) -> V {
        // SAFETY: the caller's promise.
        let (r0, v): (V, V) = unsafe { (self.r0.load(at), self.v.load(at)) };
        r0 + v * V::all(self.tau)
    }

    #[inline(always)]
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V) {
        // SAFETY: the caller's promise.
        unsafe {
            self.r0.add(at, V::all(self.kick_r0) * force);
            self.v.add(at, V::all(self.kick_v) * force);
        }
    }
}

impl<R: Real> Sites<R> for Oscillation<'_, R> {
    #[inline(always)]
    fn room(&self) -> usize {
        self.c.len().min(self.s.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize) -> V {
        // SAFETY: the caller's promise.
        let (c, s): (V, V) = unsafe { (self.c.load(at), self.s.load(at)) };
        c * V::all(self.cos) + s * V::all(self.sin)
    }

    #[inline(always)]
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V) {
        // SAFETY: the caller's promise.
        unsafe {
            self.c.add(at, V::all(self.kick_c) * force);
            self.s.add(at, V::all(self.kick_s) * force);
        }
    }
}

impl<R: Real> Sites<R> for Both<'_, R> {
    #[inline(always)]
    fn room(&self) -> usize {
        self.centre.room().min(self.oscillation.room())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.centre.positions::<V>(at) + self.oscillation.positions::<V>(at) }
    }

    #[inline(always)]
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V) {
        // SAFETY: the caller's promise.
        unsafe {
            self.centre.update(at, force);
            self.oscillation.update(at, force);
        }
    }
}
