//! Kicks of a short chain in a row.
//!
//! The speed of a chain that stays in the nearest cache is limited by square roots, provided that
//! nothing waits for them. Therefore the forces of a kick are known before its pass begins. The
//! pass gives each register of sites the forces of this kick and, from the new positions, which are
//! still in the register, computes the forces of the next kick. No register waits for another of
//! the same pass.
//!
//! On a ring a pass begins a register after the one before it. Its first registers then do not need
//! the forces that were computed last. Forces are loaded in the registers in which they were
//! stored, since a load that spans two stores waits until both have left the processor. Each number
//! is computed as by kicks one at a time, so that the bits are the same. Of chains
//! [abreast](super::lanes) a register has the numbers of one site of each.

use super::{
    Chain,
    aligned::Aligned,
    law::{ContactLaw, LANES, Power, with_force},
    sweep::{Sites, Visit, overlaps, push},
};
use hertzchain_integrators::{Column, DoubleDouble, Real, Vector, law::ThreeHalves, with_registers};
use std::ops::Range;

/// Largest number of sites of a chain whose kicks are made in rows: its columns take at most 768
/// KiB. Timed with AVX2 on rings of 1000 sites (least of many samples), a step takes 0.73
/// (`strang-linear`) and 0.89 (`verlet`) of the time of kicks made one at a time; with AVX-512 and
/// 1 MiB of second cache on rings of 10^4 sites (medians) 0.79 and 1.05 with resonators, 0.94 and
/// 0.92 without.
pub(super) const SHORT: usize = 1 << 14;
/// Numbers before the force of the first bond.
const PAD: usize = LANES;

/// The moments of kicks in a row, in order of time.
pub(crate) trait Clock<R: Real> {
    /// What a kick and its drift depend on.
    type Moment: Copy;
    /// Returns the moment of the next kick, then moves the clock on by its drift. Called once for
    /// each kick.
    fn next(&mut self) -> Self::Moment;
    /// The moment for positions at the present time, with a kick of duration zero.
    fn now(&self) -> Self::Moment;
}

/// `kicks` kicks in a row, at most as many as the clock has.
pub(crate) struct InRow<'a, R: Real, C: Clock<R>> {
    pub(crate) forces: &'a mut RowForces<R>,
    pub(crate) clock: C,
    pub(crate) kicks: usize,
}

impl<R: Real, C: Clock<R>> Visit<R, C::Moment> for InRow<'_, R, C> {
    type Output = ();

    // Not inlined: the kernel is compiled once for each kind of sites.
    #[inline(never)]
    fn visit<S: Sites<R, Moment = C::Moment>>(self, chain: &Chain<R>, sites: S, _now: C::Moment) {
        if chain.count() > 1 {
            with_registers!(V<R> => kicks::<V<R>, V<R>, _, _, _>((chain, ThreeHalves), sites, self))
        } else {
            with_force!(chain.law, power, V<R> => kicks::<R, V<R>, _, _, _>((chain, power), sites, self))
        }
    }
}

/// Forces of bonds at one kick and at the next, from index `PAD` on, with one more register on
/// either side.
#[derive(Debug)]
pub(crate) struct RowForces<R>([Aligned<R>; 2]);

impl<R: Real> RowForces<R> {
    /// Buffers for the forces of a chain, if it is short; else empty.
    pub(crate) fn new(chain: &Chain<R>) -> Self {
        let n = chain.sites();
        Self(if n <= SHORT { Aligned::between(PAD + n + 1 + 2 * LANES) } else { Aligned::between(0) })
    }

    /// Empty buffers.
    pub(crate) fn none() -> Self {
        Self(Aligned::between(0))
    }

    /// Whether kicks are made in rows.
    pub(crate) fn used(&self) -> bool {
        !self.0[0].is_empty()
    }
}

#[inline(always)]
fn kicks<T: Vector<R>, V: Vector<R>, P: Power<R>, R: Real, S: Sites<R>>(
    of: (&Chain<R>, P),
    sites: S,
    row: InRow<'_, R, impl Clock<R, Moment = S::Moment>>,
) {
    if of.0.topology.strains() {
        kick::<T, V, P, true, R, S>(of, sites, row)
    } else {
        kick::<T, V, P, false, R, S>(of, sites, row)
    }
}

#[inline(always)]
fn kick<T: Vector<R>, V: Vector<R>, P: Power<R>, const STRAIN: bool, R: Real, S: Sites<R>>(
    (chain, power): (&Chain<R>, P),
    mut sites: S,
    InRow { forces, mut clock, kicks }: InRow<'_, R, impl Clock<R, Moment = S::Moment>>,
) {
    let (n, ring) = (chain.sites(), chain.topology.ring());
    let registers = n.next_multiple_of(V::LANES);
    let [here, there] = &mut forces.0;
    let (mut here, mut there) = (here.column(), there.column());
    assert!(sites.room() >= registers, "columns are whole registers");
    assert!([&here, &there].iter().all(|column| column.len() > PAD + registers + V::LANES));
    // The clock is one moment ahead, so that no position waits for it.
    let mut now = clock.next();
    let mut next = if kicks > 1 { clock.next() } else { now };
    let mut pass = Pass { chain, rest: V::all(chain.precompression()), start: 0 };
    let law = chain.law;
    // SAFETY: columns have room, as asserted.
    unsafe { pass.go::<T, _, _, STRAIN, false>(&mut sites, [&now; 2], &here, Raised { law, power, to: &mut there }) };
    (here, there) = (there, here);
    for left in (1..kicks).rev() {
        let ahead = if left > 1 { clock.next() } else { next };
        if ring {
            pass.start = (pass.start + V::LANES) % registers;
        }
        // SAFETY: as above.
        unsafe {
            pass.go::<T, _, _, STRAIN, true>(&mut sites, [&now, &next], &here, Raised { law, power, to: &mut there })
        };
        (here, there) = (there, here);
        (now, next) = (next, ahead);
    }
    for at in (0..n).step_by(V::LANES) {
        // SAFETY: as above.
        unsafe { sites.update(at, forces_on::<R, T, V, STRAIN>(&here, n, at), &now) };
    }
}

/// The forces of the bonds at the next kick.
struct Raised<'a, 'b, R, P> {
    law: ContactLaw<R>,
    power: P,
    to: &'a mut Column<'b, R>,
}

impl<R: Real, P: Power<R>> Raised<'_, '_, R, P> {
    /// Stores the forces of the bonds to the left of the sites from `at` on.
    ///
    /// # Safety
    /// The column has room for a register from `PAD + at` on.
    #[inline(always)]
    unsafe fn take<V: Vector<R>>(&mut self, at: usize, overlaps: V) {
        let force = self.law.force_by(self.power, overlaps);
        // SAFETY: the caller's promise.
        unsafe { self.to.store(PAD + at, force) }
    }
}

/// A pass over all registers of a chain; `T` as in [`overlaps`].
struct Pass<'a, R, V> {
    chain: &'a Chain<R>,
    /// Static overlap.
    rest: V,
    /// The site at which it begins: 0, except on rings.
    start: usize,
}

impl<R: Real, V: Vector<R>> Pass<'_, R, V> {
    /// Kicks the sites by `forces` if `KICK`, and hands the overlaps at the next kick to `bonds`;
    /// `times` are the moments of this kick and of the next.
    ///
    /// # Safety
    /// The columns of sites are whole registers; those of bonds have a register more than these on
    /// either side.
    #[inline(always)]
    unsafe fn go<T: Vector<R>, S: Sites<R>, P: Power<R>, const STRAIN: bool, const KICK: bool>(
        &self,
        sites: &mut S,
        times: [&S::Moment; 2],
        forces: &Column<'_, R>,
        mut bonds: Raised<'_, '_, R, P>,
    ) {
        let Self { chain, rest, start } = *self;
        let (n, ring) = (chain.sites(), chain.topology.ring());
        let last = n.next_multiple_of(V::LANES) - V::LANES;
        let (left, right) = chain.topology.ghosts(R::zero(), R::zero());
        let (mut q, mut first, mut at) = (V::all(left), V::all(left), start);
        // Overlaps need no neighbour on a strain ring. On another ring the first register waits for
        // the last.
        let wait = ring && !STRAIN;
        // SAFETY: the caller's promise.
        unsafe {
            if wait {
                first = moved::<R, V, S, KICK>(sites, start, forces_on::<R, T, V, STRAIN>(forces, n, start), times);
                (q, at) = (first, start + V::LANES);
            }
            q = self.whole::<T, S, P, STRAIN, KICK>(at..last, q, sites, times, forces, &mut bonds);
            if at <= last {
                let here = moved::<R, V, S, KICK>(sites, last, forces_on::<R, T, V, STRAIN>(forces, n, last), times);
                bonds.take(last, overlaps::<R, T, V, STRAIN>(rest, q, here));
                q = here;
            }
            if !STRAIN && T::LANES == 1 {
                q = q.spread(n - 1 - last);
            }
            q = self.whole::<T, S, P, STRAIN, KICK>(0..start, q, sites, times, forces, &mut bonds);
            if wait {
                bonds.take(start, overlaps::<R, T, V, STRAIN>(rest, q, first));
            }
            let beyond = last + V::LANES;
            if ring {
                bonds.to.store::<T>(PAD - T::LANES, bonds.to.load(PAD + n - T::LANES));
                bonds.to.store::<T>(PAD + beyond, bonds.to.load(PAD));
            } else {
                bonds.take(beyond, overlaps::<R, T, V, STRAIN>(rest, q, V::all(right)));
            }
        }
    }

    /// The pass over some registers without the last of the chain. `q` are the positions of the
    /// register before; returns those of the last one here.
    ///
    /// # Safety
    /// As [`go`](Self::go).
    #[inline(always)]
    unsafe fn whole<T: Vector<R>, S: Sites<R>, P: Power<R>, const STRAIN: bool, const KICK: bool>(
        &self,
        registers: Range<usize>,
        mut q: V,
        sites: &mut S,
        times: [&S::Moment; 2],
        forces: &Column<'_, R>,
        bonds: &mut Raised<'_, '_, R, P>,
    ) -> V {
        let (rest, mut at) = (self.rest, registers.start);
        const { assert!(!std::mem::needs_drop::<S>(), "sites own nothing") };
        // SAFETY: as asserted. Of a copy, addresses of columns stay in registers.
        let mut sites = unsafe { std::ptr::read(sites) };
        // SAFETY: the caller's promise.
        let [mut before, mut f] = unsafe { [force_before::<R, T, V>(forces, at), forces.load(PAD + at)] };
        while at < registers.end {
            // SAFETY: as above.
            unsafe {
                let after = forces.load(PAD + at + V::LANES);
                let here = moved::<R, V, S, KICK>(&mut sites, at, push::<R, T, V, STRAIN>(before, f, after), times);
                bonds.take(at, overlaps::<R, T, V, STRAIN>(rest, q, here));
                (q, before, f) = (here, f, after);
            }
            at += V::LANES;
        }
        q
    }
}

/// Positions of the sites from `at` on: at the `next` kick, after the kick by `force`, if `KICK`;
/// else at the present time.
///
/// # Safety
/// There is room for `at + LANES` numbers.
#[inline(always)]
unsafe fn moved<R: Real, V: Vector<R>, S: Sites<R>, const KICK: bool>(
    sites: &mut S,
    at: usize,
    force: V,
    [now, next]: [&S::Moment; 2],
) -> V {
    // SAFETY: the caller's promise.
    unsafe { if KICK { sites.advance(at, force, now, next) } else { sites.positions::<V>(at, now) } }
}

/// The force of the bond before that of the site at `at`, in the lane of its neighbour; of chains
/// abreast, the forces of all.
///
/// # Safety
/// The column has forces of bonds from `PAD` on, and a register before.
#[inline(always)]
pub(crate) unsafe fn force_before<R: Real, T: Vector<R>, V: Vector<R>>(forces: &Column<'_, R>, at: usize) -> V {
    // SAFETY: the caller's promise.
    unsafe { if T::LANES > 1 { forces.load(PAD + at - T::LANES) } else { V::all(forces.load(PAD + at - 1)) } }
}

/// Contact forces on the sites from `at` on, from those of bonds; zero beyond the last site.
///
/// # Safety
/// The column has the forces of bonds from `PAD` on, that of the bond before the first before it,
/// and that of the bond after the last site in the register after the last.
#[inline(always)]
pub(crate) unsafe fn forces_on<R: Real, T: Vector<R>, V: Vector<R>, const STRAIN: bool>(
    forces: &Column<'_, R>,
    n: usize,
    at: usize,
) -> V {
    // SAFETY: the caller's promise.
    let (before, f): (V, V) = unsafe { (force_before::<R, T, V>(forces, at), forces.load(PAD + at)) };
    let after = PAD + at + V::LANES;
    if T::LANES > 1 || at + V::LANES < n {
        // SAFETY: as above.
        return push::<R, T, V, STRAIN>(before, f, unsafe { forces.load(after) });
    }
    // SAFETY: as above.
    let (sites, beyond) = (n - at, V::all(unsafe { forces.load(after) }));
    push::<R, T, V, STRAIN>(before, f.first(sites, beyond), beyond).first(sites, V::all(R::zero()))
}

/// (Kick, drift) pairs in order of time.
pub(crate) type Pairs<'a, R> = std::slice::Iter<'a, (R, DoubleDouble<R>)>;
