//! One pass over the chain: positions, contact forces, update, a register of sites at a time.
//!
//! Forces stay in registers. The bond to the left of a site has its lane; neighbours come from the
//! register before, moved by a lane. A register of sites is updated some registers after the forces
//! on it are known: so few operations wait for square roots, a pass goes through memory once, and
//! no load waits for a store of the same pass. The pass is compiled for the vector unit
//! at hand.
//!
//! # Several kicks at once
//!
//! Several kicks of a short chain are made in rows, see [`rows`](super::rows). On a long chain,
//! which does not fit into the cache, the kicks follow each other through it: kick `k` works on a
//! piece that kick `k - 1` has just left, a register behind it. On a ring the first bond of a pass
//! joins the first site to the last, which the kick before reaches at its end. So kick `k` begins
//! `8 k` sites from the first, goes on to the last, and then does those before its own first. Each
//! number is computed as by kicks one at a time, so that the bits are the same.

use super::{
    Chain,
    law::{LANES, Power, with_force},
};
use hertzchain_integrators::{DoubleDouble, Real, Vector};

/// The sites that a pass visits, in columns that are whole registers long; they own nothing.
pub(crate) trait Sites<R: Real> {
    /// What positions, a kick and its drift depend on.
    type Moment: Copy;
    /// Length of the columns.
    fn room(&self) -> usize;
    /// The positions of the sites from `at` on.
    ///
    /// # Safety
    /// There is room for `at + LANES` numbers.
    unsafe fn positions<V: Vector<R>>(&self, at: usize, now: &Self::Moment) -> V;
    /// Gives the sites from `at` on their contact forces, and may then move them; returns their
    /// positions at the `next` kick. Sites beyond the last get no force.
    ///
    /// # Safety
    /// There is room for `at + LANES` numbers.
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &Self::Moment, next: &Self::Moment) -> V;
    /// [`advance`](Self::advance), where nobody asks for positions.
    ///
    /// # Safety
    /// There is room for `at + LANES` numbers.
    #[inline(always)]
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V, now: &Self::Moment) {
        // SAFETY: the caller's promise.
        unsafe { self.advance(at, force, now, now) };
    }
}

/// Work on the sites of a flow, for each kind of resonators; `M` is the type of what a kick depends
/// on.
pub(crate) trait Visit<R: Real, M> {
    /// Result of the work.
    type Output;
    fn visit<S: Sites<R, Moment = M>>(self, chain: &Chain<R>, sites: S, now: M) -> Self::Output;
}

/// Largest number of kicks that follow each other through a chain.
pub(crate) const MOST_KICKS: usize = 64;
/// Number of sites that each kick moves on by in its turn: chosen so that the sites of all kicks
/// that follow each other stay in the second cache (8192 sites with resonators take 256 KiB).
/// Shorter pieces, in the nearest cache, cost more in calls than they gain.
const PIECE: usize = 1024 * LANES;
/// Smallest number of sites of a chain whose kicks follow each other. Timed on one core, with
/// resonators, against kicks one at a time (least of two samples, a busy machine): on 10^6 sites a
/// run takes 0.49 (`verlet`) and 0.57 (`strang-linear`) of the time, on 10^5 sites 0.93 and 0.96,
/// on 20 000 and 50 000 sites 0.89 to 1.04.
const LONG: usize = 1 << 16;

/// Sites are updated so many registers after the forces on them were computed. With 0 most
/// operations of a pass wait for square roots, and the processor has no place for those of further
/// registers: 3 takes 0.77 of the time of 0 with `strang-linear` on 30 000 sites with resonators,
/// 0.93 to 1.01 with other chains (medians, AVX-512).
const LATE: usize = 3;

/// A flow whose kicks are sweeps.
pub(crate) trait Swept<R: Real> {
    /// What a kick and its drift depend on, beside the columns.
    type Moment: Copy;
    /// The chain.
    fn swept(&self) -> &Chain<R>;
    /// Returns what the next kick depends on, then makes the part of the drift that does not change
    /// columns.
    fn begin(&mut self, kick: R, drift: DoubleDouble<R>) -> Self::Moment;
    /// Hands over the sites at the time of a kick.
    fn visit<W: Visit<R, Self::Moment>>(&mut self, moment: Self::Moment, work: W) -> W::Output;
}

/// A kick and its drift.
pub(crate) fn step<R: Real, F: Swept<R>>(flow: &mut F, kick: R, drift: DoubleDouble<R>) {
    let (now, to) = (flow.begin(kick, drift), flow.swept().sites());
    flow.visit(now, Piece { pass: &mut Pass::new(0), to });
}

/// Whether kicks of a chain are to follow each other.
pub(crate) fn long<R: Real>(chain: &Chain<R>) -> bool {
    chain.sites() >= LONG
}

/// Kicks and drifts, at most [`MOST_KICKS`], on a [`long`] chain: kick `k` is 8 sites behind kick
/// `k - 1`.
pub(crate) fn follow<R: Real, F: Swept<R>>(flow: &mut F, pairs: &[(R, DoubleDouble<R>)]) {
    let (n, count, ring) = (flow.swept().sites(), pairs.len(), flow.swept().topology.ring());
    let mut kicks: [Option<(F::Moment, Pass<R>)>; MOST_KICKS] = [None; MOST_KICKS];
    // The first pieces of all kicks, long enough that the sites around the start of the next kick
    // are moved.
    for (k, &(kick, drift)) in pairs.iter().enumerate() {
        let (moment, mut pass) = (flow.begin(kick, drift), Pass::new(if ring { k * LANES } else { 0 }));
        flow.visit(moment, Piece { pass: &mut pass, to: (2 * count - k) * LANES });
        kicks[k] = Some((moment, pass));
    }
    for front in (2 * count * LANES + PIECE..n).step_by(PIECE) {
        for (k, (moment, pass)) in kicks.iter_mut().flatten().enumerate() {
            flow.visit(*moment, Piece { pass, to: front - k * LANES });
        }
    }
    for (moment, mut pass) in kicks.into_iter().flatten() {
        flow.visit(moment, Piece { pass: &mut pass, to: n });
        if pass.began > 0 {
            flow.visit(moment, Piece { pass: &mut pass.again(), to: pass.began });
        }
    }
}

/// Visits every site of `chain` once.
pub(crate) fn sweep<R: Real, S: Sites<R>>(chain: &Chain<R>, sites: S, now: S::Moment) {
    Piece { pass: &mut Pass::new(0), to: chain.sites() }.go_on(chain, sites, now);
}

/// A pass under way, between two pieces of it.
#[derive(Clone, Copy)]
pub(crate) struct Pass<R> {
    /// The site at which the pass began; it begins a register of any width.
    began: usize,
    /// The next site to be visited; it begins a register of any width.
    next: usize,
    /// Position of the site before the next.
    q: R,
    /// Position beyond the last site.
    right: R,
    /// Forces of the last register, whose sites are updated next.
    f: [R; LANES],
    /// Force of the bond before that register.
    before: R,
    /// Force of the bond at which the pass began.
    first: R,
    /// Whether the pass has reached the end of a ring and goes on from site 0 to where it began.
    closing: bool,
}

impl<R: Real> Pass<R> {
    /// A pass that begins at this site; the kick before has moved the sites around it already.
    fn new(began: usize) -> Self {
        let zero = R::zero();
        let f = [zero; LANES];
        Self { began, next: began, q: zero, right: zero, f, before: zero, first: zero, closing: false }
    }

    /// The rest of a pass that has come to the end of a ring.
    fn again(&self) -> Self {
        Self { q: self.q, first: self.first, closing: true, ..Self::new(0) }
    }

    /// The position to the left of the first site.
    #[inline(always)]
    fn begin<S: Sites<R>>(&mut self, chain: &Chain<R>, sites: &S, now: &S::Moment) -> R {
        if self.began > 0 {
            // SAFETY: a pass begins at a site.
            return unsafe { sites.positions::<R>(self.began - 1, now) };
        }
        if !self.closing {
            (self.q, self.right) = ghosts(chain, sites, now);
        }
        self.q
    }

    /// Keeps the force of the first bond, if the pass will end at this bond.
    #[inline(always)]
    fn begun<V: Vector<R>>(&mut self, f: V) {
        if self.began > 0 {
            // SAFETY: arrays are as long as the largest number of lanes.
            unsafe { f.store(self.f.as_mut_ptr()) };
            self.first = self.f[0];
        }
    }

    /// Keeps the numbers with which the next piece begins.
    #[inline(always)]
    fn keep<V: Vector<R>>(&mut self, next: usize, [q, f, before]: [V; 3]) {
        let mut lanes = [R::zero(); LANES];
        self.next = next;
        // SAFETY: arrays are as long as the largest number of lanes.
        unsafe {
            f.store(self.f.as_mut_ptr());
            q.store(lanes.as_mut_ptr());
            self.q = lanes[V::LANES - 1];
            before.store(lanes.as_mut_ptr());
            self.before = lanes[V::LANES - 1];
        }
    }
}

/// A piece of a pass: up to the site `to`, or to the end of the chain.
struct Piece<'a, R> {
    pass: &'a mut Pass<R>,
    to: usize,
}

impl<R: Real> Piece<'_, R> {
    #[inline(always)]
    fn go_on<S: Sites<R>>(self, chain: &Chain<R>, sites: S, now: S::Moment) {
        let Self { pass, to } = self;
        with_force!(chain.law, power, V<R> => {
            assert!(sites.room() >= chain.sites().next_multiple_of(V::<R>::LANES), "columns are whole registers");
            if chain.topology.strains() {
                pass_up_to::<R, V<R>, S, _, true>(chain, power, (sites, now), pass, to);
            } else {
                pass_up_to::<R, V<R>, S, _, false>(chain, power, (sites, now), pass, to);
            }
        });
    }
}

impl<R: Real, M> Visit<R, M> for Piece<'_, R> {
    type Output = ();

    // Not inlined: the kernel would be compiled again for every call.
    #[inline(never)]
    fn visit<S: Sites<R, Moment = M>>(self, chain: &Chain<R>, sites: S, now: M) {
        self.go_on(chain, sites, now);
    }
}

/// The pass from where it is to the site `to`, or to the end of the chain.
#[inline(always)]
fn pass_up_to<R: Real, V: Vector<R>, S: Sites<R>, P: Power<R>, const STRAIN: bool>(
    chain: &Chain<R>,
    power: P,
    (mut sites, now): (S, S::Moment),
    pass: &mut Pass<R>,
    to: usize,
) {
    let n = chain.sites();
    let (rest, end) = (n % V::LANES, n - n % V::LANES);
    let (none, stop) = (V::all(R::zero()), to.min(end));
    let mut at = pass.next;
    // Positions and forces of the last register, which is updated next; forces of the register
    // before it.
    let (mut q, mut f, mut before);
    // SAFETY: a register of sites that begins before `n` ends within the columns, by the check of
    // `Piece::go_on`.
    if at > pass.began {
        // SAFETY: as above.
        (q, f, before) = (V::all(pass.q), unsafe { V::load(pass.f.as_ptr()) }, V::all(pass.before));
    } else {
        let left = pass.begin(chain, &sites, &now);
        let zero = R::zero();
        (q, before) = (V::all(left), none);
        f = V::all(if STRAIN { bonds::<R, R, P, STRAIN>(chain, power, zero, left) } else { zero });
        if at < stop {
            // SAFETY: as above.
            let here = unsafe { sites.positions::<V>(at, &now) };
            (before, f) = (f, bonds::<R, V, P, STRAIN>(chain, power, q, here));
            (q, at) = (here, at + V::LANES);
            pass.begun(f);
        }
    }
    // Forces on the registers whose sites are updated next.
    let (mut late, begin) = ([none; LATE], at);
    while at < stop {
        // SAFETY: as above.
        let here = unsafe { sites.positions::<V>(at, &now) };
        let next = bonds::<R, V, P, STRAIN>(chain, power, q, here);
        if at >= begin + LATE * V::LANES {
            // SAFETY: as above.
            unsafe { sites.update(at - (LATE + 1) * V::LANES, late[0], &now) };
        }
        late = [late[1], late[2], push::<R, R, V, STRAIN>(before, f, next)];
        (q, before, f, at) = (here, f, next, at + V::LANES);
    }
    for (k, force) in late.into_iter().enumerate() {
        let behind = (LATE - k) * V::LANES;
        if at >= begin + behind {
            // SAFETY: as above.
            unsafe { sites.update(at - behind - V::LANES, force, &now) };
        }
    }
    if to < n {
        if pass.closing {
            // SAFETY: as above.
            unsafe { sites.update(to - V::LANES, push::<R, R, V, STRAIN>(before, f, V::all(pass.first)), &now) };
        } else {
            pass.keep(to, [q, f, before]);
        }
        return;
    }
    if pass.began > 0 {
        // On a ring, where the pass goes on from these positions.
        (pass.q, pass.right) = ghosts(chain, &sites, &now);
    }
    // The sites that do not fill a register, and the position beyond the last.
    let beyond = V::all(pass.right);
    // SAFETY: as above.
    let here = if rest > 0 { unsafe { sites.positions::<V>(end, &now) }.first(rest, beyond) } else { beyond };
    let next = bonds::<R, V, P, STRAIN>(chain, power, q, here);
    if end > 0 {
        // SAFETY: as above.
        unsafe { sites.update(end - V::LANES, push::<R, R, V, STRAIN>(before, f, next), &now) };
    }
    if rest > 0 {
        // SAFETY: as above.
        unsafe { sites.update(end, push::<R, R, V, STRAIN>(f, next, none).first(rest, none), &now) };
    }
}

/// Positions beyond the two ends.
#[inline(always)]
fn ghosts<R: Real, S: Sites<R>>(chain: &Chain<R>, sites: &S, now: &S::Moment) -> (R, R) {
    // SAFETY: a chain has a site.
    let (first, last) = unsafe { (sites.positions::<R>(0, now), sites.positions::<R>(chain.sites() - 1, now)) };
    chain.topology.ghosts(first, last)
}

// These are functions, as closures would not be compiled for the registers of the pass.

/// Forces of the bonds to the left of sites, from the positions `before` these sites and the
/// positions `q` of the sites.
#[inline(always)]
fn bonds<R: Real, V: Vector<R>, P: Power<R>, const STRAIN: bool>(chain: &Chain<R>, power: P, before: V, q: V) -> V {
    chain.law.force_by(power, overlaps::<R, R, V, STRAIN>(V::all(chain.precompression), before, q))
}

/// Overlaps of the bonds to the left of sites, `rest + q_{i-1} - q_i` from positions or `-x_i` from
/// strains. `T` has the numbers of a site: one, or those of chains abreast, which fill a register.
#[inline(always)]
pub(crate) fn overlaps<R: Real, T: Vector<R>, V: Vector<R>, const STRAIN: bool>(rest: V, before: V, q: V) -> V {
    let neighbour = if T::LANES > 1 { before } else { q.after(before) };
    if STRAIN { V::all(R::zero()) - q } else { rest + (neighbour - q) }
}

/// Contact forces `f_i - f_{i+1}` on sites, from the forces `f` of the bonds to their left; or the
/// differences of two such, on strains.
#[inline(always)]
pub(crate) fn push<R: Real, T: Vector<R>, V: Vector<R>, const STRAIN: bool>(before: V, f: V, next: V) -> V {
    let (before, next) = if T::LANES > 1 { (before, next) } else { (f.after(before), f.before(next)) };
    if STRAIN { (f - before) - (next - f) } else { f - next }
}
