//! The split into kinetic and potential energy: springs and contacts kick, beads and resonators
//! drift freely.

use super::{
    Chain, Resonators,
    aligned::Aligned,
    divisible::Divisible,
    rows::{Clock, InRow, Pairs, RowForces},
    sweep::{MOST_KICKS, Sites, Swept, Visit, follow, long, step},
};
use hertzchain_integrators::{Column, DoubleDouble, Real, SplitFlow, Vector};

/// A chain split into kinetic and potential energy; Strang's scheme on it is velocity Verlet.
///
/// Its steps must resolve the springs: it is stable for `h omega < 2` only.
pub struct KineticFlow<R> {
    chain: Chain<R>,
    /// `[kappa, rho]`.
    springs: [R; 2],
    /// Positions and velocities of beads, `[u, u']`.
    beads: [Aligned<R>; 2],
    /// Positions and velocities of moving resonators, `[v, v']`; empty without them.
    resonators: [Aligned<R>; 2],
    /// Buffers for kicks in a row, see [`InRow`].
    forces: RowForces<R>,
}

impl<R: Real> KineticFlow<R> {
    /// The chain at rest; load a state into it.
    ///
    /// # Panics
    /// A chain with details: [`SitewiseFlow`](super::SitewiseFlow) is made for it.
    pub fn new(chain: Chain<R>) -> Self {
        assert!(chain.details().is_none(), "a chain with details flows site by site");
        let n = chain.sites();
        let (beads, resonators) = if chain.layout().resonators() {
            let [u, u_dot, v, v_dot] = Aligned::together(n);
            ([u, u_dot], [v, v_dot])
        } else {
            (Aligned::together(n), Aligned::together(0))
        };
        let springs = [chain.params.kappa, chain.params.rho].map(R::of);
        Self { forces: RowForces::new(&chain), chain, springs, beads, resonators }
    }

    fn arrays(&self) -> [&[R]; 4] {
        let ([u, u_dot], [v, v_dot]) = (&self.beads, &self.resonators);
        [u, v, u_dot, v_dot]
    }
}

impl<R: Real> SplitFlow<R> for KineticFlow<R> {
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
        for (to, from) in self.columns().into_iter().zip(other.arrays()) {
            to.copy_from_slice(from);
        }
    }

    fn drift(&mut self, dt: DoubleDouble<R>) {
        for [q, q_dot] in [&mut self.beads, &mut self.resonators] {
            q.iter_mut().zip(q_dot.iter()).for_each(|(q, &q_dot)| *q += dt.hi * q_dot);
        }
    }

    fn kick_drift(&mut self, kick: R, drift: DoubleDouble<R>) {
        if self.chain.count() > 1 { self.row(&[(kick, drift)]) } else { step(self, kick, drift) }
    }

    fn kick_drifts(&mut self, pairs: &[(R, DoubleDouble<R>)]) {
        if self.forces.used() && pairs.len() > 1 {
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

impl<R: Real> Divisible<R> for KineticFlow<R> {
    fn rest(chain: Chain<R>) -> Self {
        Self::new(chain)
    }

    fn columns(&mut self) -> [&mut [R]; 4] {
        let ([u, u_dot], [v, v_dot]) = (&mut self.beads, &mut self.resonators);
        [u, v, u_dot, v_dot]
    }

    fn read(&mut self, first: usize, arrays: [&[R]; 4]) {
        let members = self.chain.count();
        for (to, from) in self.columns().into_iter().zip(arrays).filter(|(to, _)| !to.is_empty()) {
            to[first..].iter_mut().step_by(members).zip(from).for_each(|(to, from)| *to = *from);
        }
    }

    fn write(&self, first: usize, arrays: [&mut [R]; 4]) {
        for (from, to) in self.arrays().into_iter().zip(arrays).filter(|(from, _)| !from.is_empty()) {
            to.iter_mut().zip(from[first..].iter().step_by(self.chain.count())).for_each(|(to, from)| *to = *from);
        }
    }
}

impl<R: Real> Swept<R> for KineticFlow<R> {
    type Moment = Durations<R>;

    fn swept(&self) -> &Chain<R> {
        &self.chain
    }

    #[inline]
    fn begin(&mut self, kick: R, drift: DoubleDouble<R>) -> Durations<R> {
        durations(self.springs, kick, drift)
    }

    #[inline(always)]
    fn visit<W: Visit<R, Durations<R>>>(&mut self, now: Durations<R>, work: W) -> W::Output {
        let Self { chain, beads: [u, u_dot], resonators: [v, v_dot], springs: [kappa, _], .. } = self;
        let (beads, kappa) = (Beads { u: u.column(), u_dot: u_dot.column() }, *kappa);
        match chain.params().resonators() {
            Resonators::None => work.visit(chain, beads, now),
            Resonators::Fixed => work.visit(chain, Cradle { beads, kappa }, now),
            Resonators::Moving => {
                work.visit(chain, Resonant { beads, v: v.column(), v_dot: v_dot.column(), kappa }, now)
            }
        }
    }
}

impl<R: Real> KineticFlow<R> {
    /// Kicks of a short chain in a row, each followed by its drift.
    fn row(&mut self, pairs: &[(R, DoubleDouble<R>)]) {
        let mut forces = std::mem::replace(&mut self.forces, RowForces::none());
        let clock = Drifts { springs: self.springs, pairs: pairs.iter() };
        self.visit([R::zero(); 3], InRow { forces: &mut forces, clock, kicks: pairs.len() });
        self.forces = forces;
    }
}

/// Duration of the kick; duration of the drift; change of a resonator's velocity in the kick by a
/// unit of stretch `u - v`.
pub(crate) type Durations<R> = [R; 3];

#[inline(always)]
fn durations<R: Real>([kappa, rho]: [R; 2], kick: R, drift: DoubleDouble<R>) -> Durations<R> {
    [kick, drift.hi, kick * kappa / rho]
}

/// The clock of (kick, drift) pairs in a row.
struct Drifts<'a, R> {
    /// `[kappa, rho]`.
    springs: [R; 2],
    pairs: Pairs<'a, R>,
}

impl<R: Real> Clock<R> for Drifts<'_, R> {
    type Moment = Durations<R>;

    #[inline(always)]
    fn next(&mut self) -> Durations<R> {
        let &(kick, drift) = self.pairs.next().expect("a pair for each kick");
        durations(self.springs, kick, drift)
    }

    #[inline(always)]
    fn now(&self) -> Durations<R> {
        // Positions do not depend on the moment.
        [R::zero(); 3]
    }
}

/// Beads that only contacts push: all of a plain chain.
struct Beads<'a, R> {
    u: Column<'a, R>,
    u_dot: Column<'a, R>,
}

/// Beads with springs to fixed resonators.
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
}

impl<R: Real> Sites<R> for Beads<'_, R> {
    type Moment = Durations<R>;

    #[inline(always)]
    fn room(&self) -> usize {
        self.u.len().min(self.u_dot.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, _now: &Durations<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.u.load(at) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Durations<R>, _next: &Durations<R>) -> V {
        let [kick, dt, _] = *now;
        // SAFETY: the caller's promise.
        unsafe {
            let u_dot = self.u_dot.load::<V>(at) + V::all(kick) * force;
            let u = self.u.load::<V>(at) + V::all(dt) * u_dot;
            self.u_dot.store(at, u_dot);
            self.u.store(at, u);
            u
        }
    }
}

impl<R: Real> Sites<R> for Cradle<'_, R> {
    type Moment = Durations<R>;

    #[inline(always)]
    fn room(&self) -> usize {
        self.beads.room()
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Durations<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.beads.positions(at, now) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Durations<R>, next: &Durations<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            let u: V = self.beads.positions(at, now);
            self.beads.advance(at, force - V::all(self.kappa) * u, now, next)
        }
    }
}

impl<R: Real> Sites<R> for Resonant<'_, R> {
    type Moment = Durations<R>;

    #[inline(always)]
    fn room(&self) -> usize {
        self.beads.room().min(self.v.len()).min(self.v_dot.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Durations<R>) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.beads.positions(at, now) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Durations<R>, next: &Durations<R>) -> V {
        let [_, dt, kick_v] = *now;
        // SAFETY: the caller's promise.
        unsafe {
            let v: V = self.v.load(at);
            let d = self.beads.positions::<V>(at, now) - v;
            let u = self.beads.advance(at, force - V::all(self.kappa) * d, now, next);
            let v_dot = self.v_dot.load::<V>(at) + V::all(kick_v) * d;
            self.v_dot.store(at, v_dot);
            self.v.store(at, v + V::all(dt) * v_dot);
            u
        }
    }
}
