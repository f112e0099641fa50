//! The split into exact linear flow and contact kick, in variables that the linear flow does not
//! change.
//!
//! | symbol | meaning |
//! |---|---|
//! | `R, P` | the two motions of a site, and `m, mu` the shares of an impulse that they take, see [`Modes`](super::Modes) |
//! | `R0, V; C, S` | `R(t) = R0 + V tau`, `P(t) = C cos theta + S sin theta` |
//! | `theta, tau` | phase `omega t`; time since `R0` was last moved |
//!
//! An impulse `j` on a bead changes `R'` by `m j` and `P'` by `mu j`; so it adds `m j` to `V`, `-m
//! j tau` to `R0`, `-mu j sin(theta)/omega` to `C` and `mu j cos(theta)/omega` to `S`. Between
//! kicks nothing is computed for a site: no rotation of it is repeated, so that no rounding errors
//! of rotations add up, and `V, C, S` of a site on which no contact acts keep their bits. The phase
//! is one number for the whole chain, kept to twice the working precision.
//!
//! For a spring that is weak for the time of a run, `S = P'/omega` is large, and `S sin(theta)` is
//! exact to a rounding all the same: the flow goes over into the free flight. Bounds of
//! displacements, and of their roundings, must therefore not take `S` for its motion.

use super::{
    Chain, Resonators,
    aligned::Aligned,
    divisible::Divisible,
    phase::Phase,
    rows::{Clock, InRow, RowForces},
    sweep::{MOST_KICKS, Sites, Swept, Visit, follow, long, step},
};
use hertzchain_integrators::{Column, DoubleDouble, Real, SplitFlow, Vector, with_narrow};

/// Number of kicks after which `R0` is set to the present position and `tau` to zero, so that `V
/// tau` stays of the size of `R0`. Chosen, not measured.
const KICKS_BETWEEN_ANCHORS: u32 = 64;

/// A chain split into its exact linear flow and its contacts.
pub struct LinearFlow<R> {
    pub(super) chain: Chain<R>,
    /// `[R0, V]`; empty for the cradle.
    pub(super) centre: [Aligned<R>; 2],
    /// `[C, S]`; empty for a plain chain.
    pub(super) oscillation: [Aligned<R>; 2],
    pub(super) m: R,
    pub(super) mu_over_omega: R,
    pub(super) phase: Phase<R>,
    pub(super) tau: R,
    pub(super) kicks: u32,
    /// Buffers for kicks in a row.
    forces: RowForces<R>,
}

impl<R: Real> LinearFlow<R> {
    /// The chain at rest; load a state into it.
    ///
    /// # Panics
    /// A chain with details: [`SitewiseFlow`](super::SitewiseFlow) is made for it.
    pub fn new(chain: Chain<R>) -> Self {
        assert!(chain.details().is_none(), "a chain with details flows site by site");
        let n = chain.sites();
        let none = || Aligned::together(0);
        let (centre, oscillation) = match chain.params().resonators() {
            Resonators::None => (Aligned::together(n), none()),
            Resonators::Fixed => (none(), Aligned::together(n)),
            Resonators::Moving => {
                let [r0, v, c, s] = Aligned::together(n);
                ([r0, v], [c, s])
            }
        };
        let modes = chain.modes;
        let (m, mu_over_omega, phase) = (modes.m, modes.mu_over_omega(), Phase::new(modes.omega));
        let (tau, kicks, forces) = (R::zero(), 0, RowForces::new(&chain));
        Self { chain, centre, oscillation, m, mu_over_omega, phase, tau, kicks, forces }
    }

    /// `mu`.
    pub(super) fn mu(&self) -> R {
        self.chain.modes().mu
    }

    /// `omega`.
    pub(super) fn omega(&self) -> R {
        self.phase.omega()
    }

    /// `R0 <- R0 + V tau`, `tau <- 0`.
    fn anchor(&mut self) {
        let (tau, [mut r0, v]) = (self.tau, self.centre.each_mut().map(Aligned::column));
        with_narrow!(V<R> => {
            for at in (0..r0.len()).step_by(V::<R>::LANES) {
                // SAFETY: both columns have the same whole registers.
                unsafe { r0.store(at, r0.load::<V<R>>(at) + v.load::<V<R>>(at) * V::<R>::all(tau)) }
            }
        });
        self.tau = R::zero();
        self.kicks = 0;
    }

    /// Counts a kick; before it, sets `R0` to the present position every [`KICKS_BETWEEN_ANCHORS`]
    /// kicks.
    pub(super) fn count_kick(&mut self) {
        if self.kicks == KICKS_BETWEEN_ANCHORS {
            self.anchor();
        }
        self.kicks += 1;
    }

    /// Number of kicks, including the one just counted, that may follow without an anchor between
    /// them.
    pub(super) fn kicks_to_anchor(&self) -> usize {
        (1 + KICKS_BETWEEN_ANCHORS - self.kicks) as usize
    }

    /// `[R, R', P, P']` at place `i` of the columns at the present time, with the phase there.
    #[inline(always)]
    pub(super) fn motions(&self, i: usize, phase: (R, R)) -> [R; 4] {
        let (r, r_dot) = match &self.centre {
            [r0, v] if !r0.is_empty() => (r0[i] + v[i] * self.tau, v[i]),
            _ => (R::zero(), R::zero()),
        };
        let [p, p_dot] = match &self.oscillation {
            [c, s] if !c.is_empty() => turned([c[i], s[i]], phase, self.phase.omega()),
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
        self.chain.full_dim()
    }

    fn load(&mut self, y: &[R]) {
        let layout = self.chain.member(0).layout();
        y.chunks(layout.dim()).enumerate().for_each(|(m, y)| self.read(m, layout.arrays(y)));
    }

    fn store(&self, y: &mut [R]) {
        let layout = self.chain.member(0).layout();
        y.chunks_mut(layout.dim()).enumerate().for_each(|(m, y)| self.write(m, layout.arrays_mut(y)));
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
    fn drift(&mut self, dt: DoubleDouble<R>) {
        self.phase.advance(dt);
        self.tau += dt.hi;
    }

    fn kick_drift(&mut self, kick: R, drift: DoubleDouble<R>) {
        // The drift changes no number of a site, only the phase and `tau`, before the pass.
        self.count_kick();
        if self.chain.count() > 1 { self.row(&[(kick, drift)]) } else { step(self, kick, drift) }
    }

    fn kick_drifts(&mut self, pairs: &[(R, DoubleDouble<R>)]) {
        let mut rest = pairs;
        let (long, short) = (long(&self.chain), self.forces.used());
        while (long || short) && rest.len() > 1 {
            self.count_kick();
            // No anchor may fall between kicks that are made together.
            let most = self.kicks_to_anchor();
            let (now, later) = rest.split_at(rest.len().min(if short { most } else { most.min(MOST_KICKS) }));
            self.kicks += now.len() as u32 - 1;
            if short {
                self.row(now)
            } else {
                follow(self, now)
            }
            rest = later;
        }
        rest.iter().for_each(|&(kick, drift)| self.kick_drift(kick, drift));
    }
}

impl<R: Real> Divisible<R> for LinearFlow<R> {
    fn rest(chain: Chain<R>) -> Self {
        Self::new(chain)
    }

    fn columns(&mut self) -> [&mut [R]; 4] {
        let ([r0, v], [c, s]) = (&mut self.centre, &mut self.oscillation);
        [r0, v, c, s]
    }

    fn read(&mut self, first: usize, [u, v, u_dot, v_dot]: [&[R]; 4]) {
        let (modes, omega) = (self.chain.modes(), self.phase.omega());
        self.phase.reset();
        (self.tau, self.kicks) = (R::zero(), 0);
        let ([r0, v0], [c, s]) = (&mut self.centre, &mut self.oscillation);
        for i in 0..u.len() {
            let of = |array: &[R]| array.get(i).copied().unwrap_or(R::zero());
            let [r, r_dot, p, p_dot] = modes.split([u[i], of(v), u_dot[i], of(v_dot)]);
            let to = first + i * self.chain.count();
            if !v0.is_empty() {
                (r0[to], v0[to]) = (r, r_dot);
            }
            if !s.is_empty() {
                (c[to], s[to]) = (p, p_dot / omega);
            }
        }
    }

    fn write(&self, first: usize, [u, v, u_dot, v_dot]: [&mut [R]; 4]) {
        let (n, modes, phase, members) = (u.len(), self.chain.modes(), self.phase.sin_cos(), self.chain.count());
        let ([r0, v0], [c, s]) = (&self.centre, &self.oscillation);
        if members == 1 && self.chain.layout().resonators() {
            // Both motions of one chain, without branches.
            let [r0, v0, c, s] = [r0, v0, c, s].map(|column| &column[first..][..n]);
            let [v, u_dot, v_dot] = [v, u_dot, v_dot].map(|array| &mut array[..n]);
            for i in 0..n {
                let [p, p_dot] = turned([c[i], s[i]], phase, self.phase.omega());
                [u[i], v[i], u_dot[i], v_dot[i]] = modes.join([r0[i] + v0[i] * self.tau, v0[i], p, p_dot]);
            }
            return;
        }
        for i in 0..n {
            let site = modes.join(self.motions(first + i * members, phase));
            [u[i], _, u_dot[i], _] = site;
            if let Some(v) = v.get_mut(i) {
                [_, *v, _, v_dot[i]] = site;
            }
        }
    }
}

impl<R: Real> Swept<R> for LinearFlow<R> {
    type Moment = Now<R>;

    fn swept(&self) -> &Chain<R> {
        &self.chain
    }

    #[inline]
    fn begin(&mut self, kick: R, drift: DoubleDouble<R>) -> Now<R> {
        let now = self.now(kick);
        self.drift(drift);
        now
    }

    #[inline(always)]
    fn visit<W: Visit<R, Now<R>>>(&mut self, now: Now<R>, work: W) -> W::Output {
        hand_over(&self.chain, [&mut self.centre, &mut self.oscillation], now, work)
    }
}

/// Hands over the sites in the columns `[R0, V]` and `[C, S]`.
#[inline(always)]
fn hand_over<R: Real, W: Visit<R, Now<R>>>(
    chain: &Chain<R>,
    [[r0, v], [c, s]]: [&mut [Aligned<R>; 2]; 2],
    now: Now<R>,
    work: W,
) -> W::Output {
    let centre = Centre { r0: r0.column(), v: v.column() };
    let oscillation = Oscillation { c: c.column(), s: s.column() };
    match chain.params().resonators() {
        Resonators::None => work.visit(chain, centre, now),
        Resonators::Fixed => work.visit(chain, oscillation, now),
        Resonators::Moving => work.visit(chain, Both { centre, oscillation }, now),
    }
}

/// What positions and a kick of the sites depend on at one time.
#[derive(Clone, Copy)]
pub(crate) struct Now<R> {
    tau: R,
    /// Sine and cosine of the phase.
    sin: R,
    cos: R,
    /// What a unit force adds to `R0`, `V`, `C` and `S` in the kick.
    kick_r0: R,
    kick_v: R,
    kick_c: R,
    kick_s: R,
}

impl<R: Real> Now<R> {
    /// For a kick of some duration, with the shares `m` and `mu/omega` of an impulse.
    #[inline(always)]
    fn new((sin, cos): (R, R), tau: R, kick: R, [m, mu_over_omega]: [R; 2]) -> Self {
        let (kick_v, per_omega) = (kick * m, kick * mu_over_omega);
        Self { tau, sin, cos, kick_r0: -(kick_v * tau), kick_v, kick_c: -(per_omega * sin), kick_s: per_omega * cos }
    }
}

impl<R: Real> LinearFlow<R> {
    /// What positions and a kick of duration `kick` depend on at the present time.
    #[inline]
    pub(super) fn now(&self, kick: R) -> Now<R> {
        Now::new(self.phase.sin_cos(), self.tau, kick, [self.m, self.mu_over_omega])
    }

    /// Does the work that `work` makes of a clock of the (kick, drift) pairs in a row. Only the
    /// first kick may have an anchor before it.
    #[inline(always)]
    pub(super) fn in_row<'a, W: Visit<R, Now<R>>, I>(
        &'a mut self,
        pairs: I,
        work: impl FnOnce(Phases<'a, R, I>) -> W,
    ) -> W::Output {
        let shares = [self.m, self.mu_over_omega];
        let now = Now::new(self.phase.sin_cos(), self.tau, R::zero(), shares);
        let Self { chain, centre, oscillation, phase, tau, .. } = self;
        hand_over(chain, [centre, oscillation], now, work(Phases { phase, tau, shares, pairs }))
    }

    /// Kicks of a short chain in a row, each followed by its drift.
    fn row(&mut self, pairs: &[(R, DoubleDouble<R>)]) {
        let mut forces = std::mem::replace(&mut self.forces, RowForces::none());
        self.in_row(pairs.iter().copied(), |clock| InRow { forces: &mut forces, clock, kicks: pairs.len() });
        self.forces = forces;
    }
}

/// The clock of (kick, drift) pairs in a row.
pub(super) struct Phases<'a, R, I> {
    phase: &'a mut Phase<R>,
    tau: &'a mut R,
    shares: [R; 2],
    pairs: I,
}

impl<R: Real, I: Iterator<Item = (R, DoubleDouble<R>)>> Clock<R> for Phases<'_, R, I> {
    type Moment = Now<R>;

    #[inline(always)]
    fn next(&mut self) -> Now<R> {
        let (kick, drift) = self.pairs.next().expect("a pair for each kick");
        let now = Now::new(self.phase.sin_cos(), *self.tau, kick, self.shares);
        self.phase.advance_inside(drift);
        *self.tau += drift.hi;
        now
    }

    #[inline(always)]
    fn now(&self) -> Now<R> {
        Now::new(self.phase.sin_cos(), *self.tau, R::zero(), self.shares)
    }
}

/// Sites that move freely: all of a plain chain.
struct Centre<'a, R> {
    r0: Column<'a, R>,
    v: Column<'a, R>,
}

/// Sites that oscillate: all of a cradle.
struct Oscillation<'a, R> {
    c: Column<'a, R>,
    s: Column<'a, R>,
}

/// Sites that do both.
struct Both<'a, R> {
    centre: Centre<'a, R>,
    oscillation: Oscillation<'a, R>,
}

impl<R: Real> Sites<R> for Centre<'_, R> {
    type Moment = Now<R>;

    #[inline(always)]
    fn room(&self) -> usize {
        self.r0.len().min(self.v.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Now<R>) -> V {
        // SAFETY: the caller's promise.
        let (r0, v): (V, V) = unsafe { (self.r0.load(at), self.v.load(at)) };
        r0 + v * V::all(now.tau)
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Now<R>, next: &Now<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            let r0 = self.r0.load::<V>(at) + V::all(now.kick_r0) * force;
            let v = self.v.load::<V>(at) + V::all(now.kick_v) * force;
            self.r0.store(at, r0);
            self.v.store(at, v);
            r0 + v * V::all(next.tau)
        }
    }
}

impl<R: Real> Sites<R> for Oscillation<'_, R> {
    type Moment = Now<R>;

    #[inline(always)]
    fn room(&self) -> usize {
        self.c.len().min(self.s.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Now<R>) -> V {
        // SAFETY: the caller's promise.
        let (c, s): (V, V) = unsafe { (self.c.load(at), self.s.load(at)) };
        c * V::all(now.cos) + s * V::all(now.sin)
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Now<R>, next: &Now<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            let c = self.c.load::<V>(at) + V::all(now.kick_c) * force;
            let s = self.s.load::<V>(at) + V::all(now.kick_s) * force;
            self.c.store(at, c);
            self.s.store(at, s);
            c * V::all(next.cos) + s * V::all(next.sin)
        }
    }
}

impl<R: Real> Sites<R> for Both<'_, R> {
    type Moment = Now<R>;

    #[inline(always)]
    fn room(&self) -> usize {
        self.centre.room().min(self.oscillation.room())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Now<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.centre.positions::<V>(at, now) + self.oscillation.positions::<V>(at, now) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Now<R>, next: &Now<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.centre.advance(at, force, now, next) + self.oscillation.advance(at, force, now, next) }
    }
}
