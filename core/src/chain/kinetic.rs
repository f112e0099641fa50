//! The split kinetic + potential energy: springs and contacts kick, everything drifts freely.

use super::{
    Chain, Resonators,
    aligned::Aligned,
    sweep::{MOST_KICKS, Sites, Step, Swept, Visit, follow, long},
};
use hertzchain_integrators::{Column, Real, SplitFlow, Twofold, Vector};

/// A chain split into kinetic and potential energy; Strang's scheme on it is velocity Verlet.
///
/// Its steps must resolve the springs: it is stable for `h omega < 2` only.
pub struct KineticFlow<R> {
    pub(super) chain: Chain<R>,
    /// Positions and velocities of beads, `[u, u']`.
    pub(super) beads: [Aligned<R>; 2],
    /// Those of resonators that move, `[v, v']`.
    pub(super) resonators: [Aligned<R>; 2],
}

impl<R: Real> KineticFlow<R> {
    /// The chain at rest; load a state into it.
    ///
    /// # Panics
    /// A chain with details: [`SitewiseFlow`](super::SitewiseFlow) is made for it.
    pub fn new(chain: Chain<R>) -> Self {
        assert!(chain.details().is_none(), "a chain with details flows site by site");
        let n = chain.sites();
        let moving = if chain.layout().resonators() { n } else { 0 };
        let [u, u_dot] = Aligned::together(n);
        Self { chain, beads: [u, u_dot], resonators: Aligned::together(moving) }
    }

    /// The chain, and its beads for a kick by contacts and a drift.
    pub(super) fn beads(&mut self, kick: R, dt: R) -> (&Chain<R>, Beads<'_, R>) {
        let Self { chain, beads: [u, u_dot], .. } = self;
        (chain, Beads { u: u.column(), u_dot: u_dot.column(), kick, dt })
    }

    fn columns(&self) -> [&Aligned<R>; 4] {
        let ([u, u_dot], [v, v_dot]) = (&self.beads, &self.resonators);
        [u, v, u_dot, v_dot]
    }

    fn columns_mut(&mut self) -> [&mut Aligned<R>; 4] {
        let ([u, u_dot], [v, v_dot]) = (&mut self.beads, &mut self.resonators);
        [u, v, u_dot, v_dot]
    }
}

impl<R: Real> SplitFlow<R> for KineticFlow<R> {
    fn dim(&self) -> usize {
        self.chain.layout().dim()
    }

    fn load(&mut self, y: &[R]) {
        let mut from = y;
        for column in self.columns_mut() {
            let (head, tail) = from.split_at(column.len());
            column.copy_from_slice(head);
            from = tail;
        }
    }

    fn store(&self, y: &mut [R]) {
        let mut to = y;
        for column in self.columns() {
            let (head, tail) = to.split_at_mut(column.len());
            head.copy_from_slice(column);
            to = tail;
        }
    }

    fn duplicate(&self) -> Self {
        let mut copy = Self::new(self.chain.clone());
        copy.copy_from(self);
        copy
    }

    fn copy_from(&mut self, other: &Self) {
        for (to, from) in self.columns_mut().into_iter().zip(other.columns()) {
            to.copy_from_slice(from);
        }
    }

    fn drift(&mut self, dt: Twofold<R>) {
        for [q, q_dot] in [&mut self.beads, &mut self.resonators] {
            for (q, &q_dot) in q.iter_mut().zip(q_dot.iter()) {
                *q += dt.value() * q_dot;
            }
        }
    }

    fn kick_drift(&mut self, kick: R, drift: Twofold<R>) {
        let now = self.begin(kick, drift);
        self.visit(now, Step);
    }

    fn kick_drifts(&mut self, pairs: &[(R, Twofold<R>)]) {
        for now in pairs.chunks(if long(&self.chain) { MOST_KICKS } else { 1 }) {
            match now {
                &[(kick, drift)] => self.kick_drift(kick, drift),
                _ => follow(self, now),
            }
        }
    }
}

impl<R: Real> Swept<R> for KineticFlow<R> {
    /// The durations of kick and drift: a pass does both.
    type Moment = [R; 2];

    fn swept(&self) -> &Chain<R> {
        &self.chain
    }

    #[inline]
    fn begin(&mut self, kick: R, drift: Twofold<R>) -> [R; 2] {
        [kick, drift.value()]
    }

    #[inline(always)]
    fn visit(&mut self, [kick, dt]: [R; 2], work: impl Visit<R>) {
        let Self { chain, beads: [u, u_dot], resonators: [v, v_dot] } = self;
        let beads = Beads { u: u.column(), u_dot: u_dot.column(), kick, dt };
        let (params, kappa) = (chain.params(), R::of(chain.params().kappa));
        match params.resonators() {
            Resonators::None => work.visit(chain, beads),
            Resonators::Fixed => work.visit(chain, Cradle { beads, kappa }),
            Resonators::Moving => {
                let kick_v = kick * kappa / R::of(params.rho);
                work.visit(chain, Resonant { beads, v: v.column(), v_dot: v_dot.column(), kappa, kick_v });
            }
        }
    }
}

/// Beads that only contacts push: all of a plain chain.
pub(super) struct Beads<'a, R> {
    u: Column<'a, R>,
    u_dot: Column<'a, R>,
    kick: R,
    dt: R,
}

impl<R: Real> Beads<'_, R> {
    /// Kicks by a force, and moves on.
    ///
    /// # Safety
    /// There is room for `at + LANES` numbers.
    #[inline(always)]
    unsafe fn kick_and_move<V: Vector<R>>(&mut self, at: usize, force: V) {
        // SAFETY: the caller's promise.
        unsafe {
            self.u_dot.add(at, V::all(self.kick) * force);
            self.u.add(at, V::all(self.dt) * self.u_dot.load(at));
        }
    }
}

/// Beads with springs to the ground.
struct Cradle<'a, R> {
    beads: Beads<'a, R>,
    kappa: R,
}

/// Beads with springs to resonators.
struct Resonant<'a, R> {
    beads: Beads<'a, R>,
    v: Column<'a, R>,
    v_dot: Column<'a, R>,
    kappa: R,
    kick_v: R,
}

impl<R: Real> Sites<R> for Beads<'_, R> {
    #[inline(always)]
    fn room(&self) -> usize {
        self.u.len().min(self.u_dot.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.u.load(at) }
    }

    #[inline(always)]
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V) {
        // SAFETY: the caller's promise.
        unsafe { self.kick_and_move(at, force) }
    }
}

impl<R: Real> Sites<R> for Cradle<'_, R> {
    #[inline(always)]
    fn room(&self) -> usize {
        self.beads.room()
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.beads.positions(at) }
    }

    #[inline(always)]
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V) {
        // SAFETY: the caller's promise.
        unsafe {
            let u: V = self.beads.positions(at);
            self.beads.kick_and_move(at, force - V::all(self.kappa) * u);
        }
    }
}

impl<R: Real> Sites<R> for Resonant<'_, R> {
    #[inline(always)]
    fn room(&self) -> usize {
        self.beads.room().min(self.v.len()).min(self.v_dot.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.beads.positions(at) }
    }

    #[inline(always)]
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V) {
        // SAFETY: the caller's promise.
        unsafe {
            let d = self.beads.positions::<V>(at) - self.v.load(at);
            self.beads.kick_and_move(at, force - V::all(self.kappa) * d);
            self.v_dot.add(at, V::all(self.kick_v) * d);
            self.v.add(at, V::all(self.beads.dt) * self.v_dot.load(at));
        }
    }
}
