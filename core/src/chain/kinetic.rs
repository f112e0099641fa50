//! The split into kinetic and potential energy: springs and contacts kick, beads and resonators
//! drift freely.

use super::{
    Chain, Resonators,
    aligned::Aligned,
    divisible::Divisible,
    lanes::Coefficient,
    rows::{Clock, InRow, Pairs, RowForces},
    sweep::{MOST_KICKS, Sites, Swept, Visit, follow, long, step},
};
use hertzchain_integrators::{Column, DoubleDouble, Real, SplitFlow, Vector};
use std::marker::PhantomData;

/// A chain split into kinetic and potential energy; Strang's scheme on it is velocity Verlet.
///
/// Its steps must resolve the springs: it is stable for `h omega < 2` only.
pub struct KineticFlow<R, K = R> {
    pub(super) chain: Chain<R>,
    /// `[kappa, rho]`.
    pub(super) springs: [K; 2],
    /// Static overlap.
    rest: K,
    /// Positions and velocities of beads, `[u, u']`.
    pub(super) beads: [Aligned<R>; 2],
    /// Positions and velocities of moving resonators, `[v, v']`; empty without them.
    pub(super) resonators: [Aligned<R>; 2],
    /// Buffers for kicks in a row, see [`InRow`].
    forces: RowForces<R>,
}

impl<R: Real> KineticFlow<R> {
    /// The chain at rest; load a state into it.
    ///
    /// # Panics
    /// A chain with details: [`SitewiseFlow`](super::SitewiseFlow) is made for it.
    pub fn new(chain: Chain<R>) -> Self {
        Self::of(chain)
    }
}

impl<R: Real, K: Coefficient<R>> KineticFlow<R, K> {
    fn of(chain: Chain<R>) -> Self {
        assert!(chain.details().is_none(), "a chain with details flows site by site");
        let n = chain.sites();
        let (beads, resonators) = if chain.layout().resonators() {
            let [u, u_dot, v, v_dot] = Aligned::together(n);
            ([u, u_dot], [v, v_dot])
        } else {
            (Aligned::together(n), Aligned::together(0))
        };
        let [kappa, rho, rest] = K::by_lane(|lane| {
            let member = chain.member(lane);
            [R::of(member.params.kappa), R::of(member.params.rho), member.precompression]
        });
        Self { forces: RowForces::new(&chain), chain, springs: [kappa, rho], rest, beads, resonators }
    }

    fn arrays(&self) -> [&[R]; 4] {
        let ([u, u_dot], [v, v_dot]) = (&self.beads, &self.resonators);
        [u, v, u_dot, v_dot]
    }
}

impl<R: Real, K: Coefficient<R>> SplitFlow<R, K> for KineticFlow<R, K> {
    fn dim(&self) -> usize {
        self.chain.full_dim()
    }

    fn load(&mut self, y: &[R]) {
        let layout = self.chain.member(0).layout();
        y.chunks(layout.dim()).enumerate().for_each(|(lane, y)| self.read(lane, layout.arrays(y)));
    }

    fn store(&self, y: &mut [R]) {
        let layout = self.chain.member(0).layout();
        y.chunks_mut(layout.dim()).enumerate().for_each(|(lane, y)| self.write(lane, layout.arrays_mut(y)));
    }

    fn duplicate(&self) -> Self {
        let mut copy = Self::of(self.chain.clone());
        copy.copy_from(self);
        copy
    }

    fn copy_from(&mut self, other: &Self) {
        for (to, from) in self.columns().into_iter().zip(other.arrays()) {
            to.copy_from_slice(from);
        }
    }

    fn drift(&mut self, dt: DoubleDouble<K>) {
        let stride = self.chain.stride::<K>();
        for [q, q_dot] in [&mut self.beads, &mut self.resonators] {
            for (i, (q, &q_dot)) in q.iter_mut().zip(q_dot.iter()).enumerate() {
                *q += dt.hi.lane(i % stride) * q_dot;
            }
        }
    }

    fn kick_drift(&mut self, kick: K, drift: DoubleDouble<K>) {
        if K::EACH {
            return self.row(&[(kick, drift)]);
        }
        step(self, kick, drift);
    }

    fn kick_drifts(&mut self, pairs: &[(K, DoubleDouble<K>)]) {
        if K::EACH || self.forces.used() && pairs.len() > 1 {
            return self.row(pairs);
        }
        for now in pairs.chunks(if long(&self.chain) { MOST_KICKS } else { 1 }) {
            match now {
                &[(kick, drift)] => self.kick_drift(kick, drift),
                _ => follow(self, now),
            }
        }
    }
}

impl<R: Real, K: Coefficient<R>> Divisible<R, K> for KineticFlow<R, K> {
    fn rest(chain: Chain<R>) -> Self {
        Self::of(chain)
    }

    fn columns(&mut self) -> [&mut [R]; 4] {
        let ([u, u_dot], [v, v_dot]) = (&mut self.beads, &mut self.resonators);
        [u, v, u_dot, v_dot]
    }

    fn read(&mut self, first: usize, arrays: [&[R]; 4]) {
        let stride = self.chain.stride::<K>();
        for (to, from) in self.columns().into_iter().zip(arrays).filter(|(to, _)| !to.is_empty()) {
            if K::EACH {
                to[first..].iter_mut().step_by(stride).zip(from).for_each(|(to, from)| *to = *from);
            } else {
                to[first..][..from.len()].copy_from_slice(from);
            }
        }
    }

    fn write(&self, first: usize, arrays: [&mut [R]; 4]) {
        let stride = self.chain.stride::<K>();
        for (from, to) in self.arrays().into_iter().zip(arrays).filter(|(from, _)| !from.is_empty()) {
            if K::EACH {
                to.iter_mut().zip(from[first..].iter().step_by(stride)).for_each(|(to, from)| *to = *from);
            } else {
                to.copy_from_slice(&from[first..][..to.len()]);
            }
        }
    }
}

impl<R: Real, K: Coefficient<R>> Swept<R, K> for KineticFlow<R, K> {
    type Moment = Durations<K>;

    fn swept(&self) -> &Chain<R> {
        &self.chain
    }

    #[inline]
    fn begin(&mut self, kick: K, drift: DoubleDouble<K>) -> Durations<K> {
        durations::<R, K, R>(self.springs, kick, drift)
    }

    #[inline(always)]
    fn visit<W: Visit<R, Durations<K>>>(&mut self, now: Durations<K>, work: W) -> W::Output {
        let Self { chain, beads: [u, u_dot], resonators: [v, v_dot], springs: [kappa, _], .. } = self;
        let (beads, kappa) = (Beads { u: u.column(), u_dot: u_dot.column(), of: PhantomData }, *kappa);
        match chain.params().resonators() {
            Resonators::None => work.visit(chain, beads, now),
            Resonators::Fixed => work.visit(chain, Cradle { beads, kappa }, now),
            Resonators::Moving => {
                work.visit(chain, Resonant { beads, v: v.column(), v_dot: v_dot.column(), kappa }, now)
            }
        }
    }
}

impl<R: Real, K: Coefficient<R>> KineticFlow<R, K> {
    /// Hands over the beads for a kick by contacts, without their springs and without a drift.
    pub(super) fn visit_beads<W: Visit<R, Durations<K>>>(&mut self, kick: K, work: W) -> W::Output {
        let Self { chain, beads: [u, u_dot], springs, .. } = self;
        let now = durations::<R, K, R>(*springs, kick, DoubleDouble { hi: K::zero(), lo: K::zero() });
        work.visit(chain, Beads { u: u.column(), u_dot: u_dot.column(), of: PhantomData }, now)
    }

    /// Kicks of a short chain in a row, each followed by its drift.
    fn row(&mut self, pairs: &[(K, DoubleDouble<K>)]) {
        if pairs.is_empty() {
            return;
        }
        let mut forces = std::mem::replace(&mut self.forces, RowForces::none());
        let (clock, rest) = (Drifts { springs: self.springs, pairs: pairs.iter() }, self.rest);
        self.visit([K::zero(); 3], InRow { forces: &mut forces, rest, clock, kicks: pairs.len() });
        self.forces = forces;
    }
}

/// Duration of the kick; duration of the drift; change of a resonator's velocity in the kick by a
/// unit of stretch `u - v`.
pub(crate) type Durations<K> = [K; 3];

#[inline(always)]
fn durations<R: Real, K: Coefficient<R>, V: Vector<R>>(
    [kappa, rho]: [K; 2],
    kick: K,
    drift: DoubleDouble<K>,
) -> Durations<K> {
    [kick, drift.hi, K::kept::<V>(kick.get::<V>() * kappa.get::<V>() / rho.get::<V>())]
}

/// The clock of (kick, drift) pairs in a row.
pub(super) struct Drifts<'a, K> {
    /// `[kappa, rho]`.
    pub(super) springs: [K; 2],
    pub(super) pairs: Pairs<'a, K>,
}

impl<R: Real, K: Coefficient<R>> Clock<R> for Drifts<'_, K> {
    type Coefficient = K;
    type Moment = Durations<K>;

    #[inline(always)]
    fn next<V: Vector<R>>(&mut self) -> Durations<K> {
        let &(kick, drift) = self.pairs.next().expect("a pair for each kick");
        durations::<R, K, V>(self.springs, kick, drift)
    }

    #[inline(always)]
    fn now<V: Vector<R>>(&self) -> Durations<K> {
        // Positions do not depend on the moment.
        [K::zero(); 3]
    }
}

/// Beads that only contacts push: all of a plain chain.
struct Beads<'a, R, K> {
    u: Column<'a, R>,
    u_dot: Column<'a, R>,
    of: PhantomData<K>,
}

/// Beads with springs to fixed resonators.
struct Cradle<'a, R, K> {
    beads: Beads<'a, R, K>,
    kappa: K,
}

/// Beads with springs to resonators.
struct Resonant<'a, R, K> {
    beads: Beads<'a, R, K>,
    v: Column<'a, R>,
    v_dot: Column<'a, R>,
    kappa: K,
}

impl<R: Real, K: Coefficient<R>> Sites<R> for Beads<'_, R, K> {
    type Moment = Durations<K>;
    type Coefficient = K;

    #[inline(always)]
    fn room(&self) -> usize {
        self.u.len().min(self.u_dot.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, _now: &Durations<K>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.u.load(at) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Durations<K>, _next: &Durations<K>) -> V {
        let [kick, dt, _] = *now;
        // SAFETY: the caller's promise.
        unsafe {
            let u_dot = self.u_dot.load::<V>(at) + kick.in_lanes::<V>() * force;
            let u = self.u.load::<V>(at) + dt.in_lanes::<V>() * u_dot;
            self.u_dot.store(at, u_dot);
            self.u.store(at, u);
            u
        }
    }
}

impl<R: Real, K: Coefficient<R>> Sites<R> for Cradle<'_, R, K> {
    type Moment = Durations<K>;
    type Coefficient = K;

    #[inline(always)]
    fn room(&self) -> usize {
        self.beads.room()
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Durations<K>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.beads.positions(at, now) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Durations<K>, next: &Durations<K>) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            let u: V = self.beads.positions(at, now);
            self.beads.advance(at, force - self.kappa.in_lanes::<V>() * u, now, next)
        }
    }
}

impl<R: Real, K: Coefficient<R>> Sites<R> for Resonant<'_, R, K> {
    type Moment = Durations<K>;
    type Coefficient = K;

    #[inline(always)]
    fn room(&self) -> usize {
        self.beads.room().min(self.v.len()).min(self.v_dot.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Durations<K>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.beads.positions(at, now) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Durations<K>, next: &Durations<K>) -> V {
        let [_, dt, kick_v] = *now;
        // SAFETY: the caller's promise.
        unsafe {
            let v: V = self.v.load(at);
            let d = self.beads.positions::<V>(at, now) - v;
            let u = self.beads.advance(at, force - self.kappa.in_lanes::<V>() * d, now, next);
            let v_dot = self.v_dot.load::<V>(at) + kick_v.in_lanes::<V>() * d;
            self.v_dot.store(at, v_dot);
            self.v.store(at, v + dt.in_lanes::<V>() * v_dot);
            u
        }
    }
}
