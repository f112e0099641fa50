//! Kicks with modified forces, each with its drift and the survey after it, in one pass.
//!
//! A pass kicks sites by their modified forces, drifts them and computes overlaps, forces and
//! derivatives at the new positions, as in [`rows`](super::super::rows). Modified forces are not
//! stored: those of a register of bonds are computed from the forces of the survey before in this
//! register and its two neighbours, which are kept from one register to the next. Forces beyond the
//! ends are loaded bond by bond, so that no register is loaded that was written in parts.
//!
//! For each register a cheap test finds whether a bond in it may have changed its side or turned
//! near zero. Only after a pass in which one may have, the exact test follows. One call makes steps
//! until a bond has. Sites that sleep, see [`awake`](super::awake), are left out: a pass goes over
//! each stretch of awake sites.

use super::{
    super::{
        Chain, ContactLaw, Topology,
        law::{Power, with_hertz},
        rows::{Clock, InRow, Moving},
        sweep::{overlaps, push},
    },
    PAD, WORD,
    awake::Stretch,
    forces::{lanes, mark},
};
use hertzchain_integrators::{Column, Real, Vector, VectorKernel};

/// Factor by which the cheap test of a pass widens `reach`, so that no rounding hides a turn.
const WIDER: f64 = 1.0 + 1e-9;

/// Settings and arrays of kicks that are followed by drift and survey in one pass.
pub struct Fused<'a> {
    /// The factor `c` of the modified force `f + c f' s`.
    pub(super) c: f64,
    /// As in [`Forces`](super::Forces).
    pub(super) reach: f64,
    /// Whether to end after the first pass in which a bond has changed its side or turned near
    /// zero.
    pub(super) watched: bool,
    /// The sites that are worked on.
    pub(super) awake: &'a [Stretch],
    /// Positions, from `PAD` on.
    pub(super) q: Column<'a, f64>,
    /// Overlaps at the last survey and at the two before, latest first. Each survey exchanges the
    /// columns, and those of forces and derivatives.
    pub(super) overlaps: [Column<'a, f64>; 3],
    /// Forces and derivatives, from `PAD` on: those of the last survey, and room for the next.
    pub(super) forces: [Column<'a, f64>; 2],
    pub(super) slopes: [Column<'a, f64>; 2],
    /// A bit for each bond: whether it was closed and whether it had turned near zero at the last
    /// survey, and whether it was closed at the last call of `changed`.
    pub(super) closed: &'a mut [u64],
    pub(super) turning: &'a mut [u64],
    pub(super) told: &'a [u64],
}

impl InRow<f64> for Fused<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Moving<f64>, C: Clock<Moment = S::Moment>>(
        self,
        chain: &Chain<f64>,
        sites: S,
        clock: C,
        kicks: usize,
    ) -> usize {
        f64::run_vector(Kernel { chain, sites, clock, kicks, fused: self })
    }
}

struct Kernel<'a, S, C> {
    chain: &'a Chain<f64>,
    sites: S,
    clock: C,
    kicks: usize,
    fused: Fused<'a>,
}

impl<S: Moving<f64>, C: Clock<Moment = S::Moment>> VectorKernel<f64> for Kernel<'_, S, C> {
    type Output = usize;

    #[inline(always)]
    fn run<V: Vector<f64>>(self) -> usize {
        with_hertz!(self.chain.law(), power => {
            if self.chain.topology().strains() {
                self.lanes::<V, _, true>(power)
            } else {
                self.lanes::<V, _, false>(power)
            }
        })
    }
}

impl<S: Moving<f64>, C: Clock<Moment = S::Moment>> Kernel<'_, S, C> {
    /// Makes the kicks, and returns how many.
    #[inline(always)]
    fn lanes<V: Vector<f64>, P: Power<f64>, const STRAIN: bool>(self, power: P) -> usize {
        let Self { chain, mut sites, mut clock, kicks, fused } = self;
        let (topology, n) = (chain.topology(), chain.sites());
        fused.check(n, V::LANES, sites.room());
        let Fused { c, reach, watched, awake, mut q, overlaps, forces, slopes, closed, turning, told } = fused;
        let ([mut g, mut g1, mut g0], [mut f, mut f1], [mut slope, mut slope1]) = (overlaps, forces, slopes);
        // SAFETY, here and below: columns have room, as checked.
        let same = unsafe { sides::<V>(&g, topology, awake, told) };
        let kicks = if watched && !same { 1 } else { kicks };
        let (mut start, mut made) = (0, 0);
        let whole = matches!(awake, [Stretch { from, to }] if from == to);
        loop {
            (g, g1, g0, f, f1, slope, slope1) = (g0, g, g1, f1, f, slope1, slope);
            sites.turn_to(clock.next());
            let next = clock.now();
            let mut seen = false;
            for &Stretch { from, to } in awake {
                seen |= unsafe {
                    let pushes = Pushes::<V, STRAIN>::new(topology, c, &f1, &slope1);
                    let (read, write) = ([&g1, &g0], [&mut q, &mut g, &mut f, &mut slope]);
                    let survey = Survey {
                        chain,
                        law: chain.law(),
                        rest: chain.precompression(),
                        power,
                        reach: reach * WIDER,
                        read,
                        write,
                    };
                    pass::<V, _, _, STRAIN>(&mut sites, &next, [from + start, to + start], pushes, survey)
                };
            }
            made += 1;
            if made == kicks || watched && seen {
                // No closure: it would not be compiled for the registers of the pass.
                for bonds in awake.iter().flat_map(|stretch| stretch.bonds(n)) {
                    unsafe { mark::<V>(bonds, reach, [&g, &g1, &g0], [&mut *closed, &mut *turning]) };
                }
                if made == kicks || tells(topology, [&*closed, &*turning, told]) {
                    break;
                }
            }
            if topology.ring() && whole {
                // The first registers of the next pass then need no force that was computed last.
                start += if STRAIN { V::LANES } else { 2 * V::LANES };
                while start >= n {
                    start -= n.next_multiple_of(V::LANES);
                }
            }
        }
        if STRAIN {
            for bonds in awake.iter().flat_map(|stretch| stretch.bonds(n)) {
                for at in (bonds.start..bonds.end.min(n)).step_by(V::LANES) {
                    unsafe { q.store(PAD + at, V::all(0.0) - g.load(at)) };
                }
            }
        }
        made
    }
}

/// Kicks and drifts sites and surveys their bonds, from the register at `start` up to, and without,
/// that at `stop`; all of them if both are the same. Returns whether a bond may have changed its
/// side or turned near zero.
///
/// # Safety
/// Columns have room.
#[inline(always)]
unsafe fn pass<V: Vector<f64>, S: Moving<f64>, P: Power<f64>, const STRAIN: bool>(
    sites: &mut S,
    next: &S::Moment,
    [start, stop]: [usize; 2],
    mut pushes: Pushes<'_, '_, V, STRAIN>,
    mut survey: Survey<'_, '_, P>,
) -> bool {
    let chain = survey.chain;
    let (n, ring) = (chain.sites(), chain.topology().ring());
    let last = n.next_multiple_of(V::LANES) - V::LANES;
    // Overlaps of strains need no neighbour. In a pass over a whole ring the first register is
    // surveyed last, since its first overlap needs the site before it.
    let wait = ring && !STRAIN && start == stop;
    let (left, right) = chain.topology().ghosts(0.0, 0.0);
    let (mut q, mut first) = (V::all(left), V::all(left));
    let (mut seen, mut at) = (0, start);
    // SAFETY, here and below: the caller's promise.
    unsafe {
        if !STRAIN && start != stop && (ring || start > 0) {
            // The site before sleeps: nothing pushes it.
            q = V::all(sites.advance(if start > 0 { start - 1 } else { n - 1 }, 0.0, next));
        }
        pushes.begin(at);
        // The register that moved last is surveyed when the next has moved: so the next does not
        // wait for the square roots of its forces.
        let (mut moved, mut here) = (at, sites.advance(at, pushes.next(at), next));
        if wait {
            first = here;
        }
        loop {
            at += V::LANES;
            if at > last {
                at = 0;
            }
            if at == stop {
                break;
            }
            if at == 0 {
                pushes.begin(at);
            }
            let there = sites.advance(at, pushes.next(at), next);
            if !wait || moved != start {
                seen |= survey.bonds::<V, STRAIN>(moved, q, here);
            }
            q = if STRAIN || moved != last { here } else { here.spread(n - 1 - last) };
            (moved, here) = (at, there);
        }
        if !wait || moved != start {
            seen |= survey.bonds::<V, STRAIN>(moved, q, here);
        }
        if !STRAIN {
            q = if moved != last { here } else { here.spread(n - 1 - last) };
        }
        if wait {
            seen |= survey.bonds::<V, STRAIN>(start, q, first);
        } else if !ring && moved == last {
            seen |= survey.bonds::<f64, STRAIN>(n, lanes(q)[0], right);
        }
    }
    seen != 0
}

impl Fused<'_> {
    /// Asserts that columns have room for registers that begin at most at the last bond.
    fn check(&self, n: usize, lanes: usize, sites: usize) {
        let room = (n + 1).next_multiple_of(lanes);
        assert!(self.awake.iter().all(|stretch| stretch.from.max(stretch.to) < n), "stretches are of the chain");
        assert!(sites >= n.next_multiple_of(lanes), "columns are whole registers");
        assert!(self.overlaps.iter().all(|column| column.len() >= room));
        let padded = self.forces.iter().chain(&self.slopes).chain([&self.q]);
        assert!(padded.into_iter().all(|column| column.len() >= PAD + room));
    }
}

/// Whether all bonds that can touch and are awake are on the sides of which `changed` told last.
///
/// # Safety
/// The column has whole registers up to the last bond.
#[inline(always)]
unsafe fn sides<V: Vector<f64>>(
    overlaps: &Column<'_, f64>,
    topology: Topology,
    awake: &[Stretch],
    told: &[u64],
) -> bool {
    let mut differences = 0;
    for bonds in awake.iter().flat_map(|stretch| stretch.bonds(topology.sites())) {
        let end = bonds.end.min(topology.touching().end);
        for at in (bonds.start..end).step_by(V::LANES) {
            // SAFETY: the caller's promise.
            let closed = unsafe { overlaps.load::<V>(at) }.positive();
            let (word, bit) = (at / WORD, at % WORD);
            differences |= (closed ^ told[word] >> bit) & low(end - at) & low(V::LANES);
        }
    }
    differences == 0
}

/// Whether `changed` or `turned` have a bond to tell of: one that can touch, and is not on the side
/// told last or turns near zero.
#[inline(always)]
fn tells(topology: Topology, [closed, turning, told]: [&[u64]; 3]) -> bool {
    let end = topology.touching().end;
    let tells = |(word, ((closed, turning), told)): (usize, ((&u64, &u64), &u64))| {
        end > word * WORD && (closed ^ told | turning) & low(end - word * WORD) != 0
    };
    closed.iter().zip(turning).zip(told).enumerate().any(tells)
}

/// The lowest bits, at least one of them.
#[inline(always)]
fn low(bits: usize) -> u64 {
    u64::MAX >> WORD.saturating_sub(bits)
}

/// The pushes of modified forces on the sites of a pass, register by register.
struct Pushes<'a, 'b, V, const STRAIN: bool> {
    n: usize,
    c: f64,
    force: &'a Column<'b, f64>,
    slope: &'a Column<'b, f64>,
    /// Force that stands before that of bond 0, and force of the bond beyond the last site.
    left: f64,
    right: f64,
    /// Modified force of the bond beyond the last site, and that of the last bond of a strain ring.
    beyond: f64,
    last: f64,
    /// Forces of the present register of bonds and of the next; modified forces of the register
    /// before and of the present one.
    f: [V; 2],
    modified: [V; 2],
}

impl<'a, 'b, V: Vector<f64>, const STRAIN: bool> Pushes<'a, 'b, V, STRAIN> {
    /// # Safety
    /// The columns have all bonds.
    #[inline(always)]
    unsafe fn new(topology: Topology, c: f64, force: &'a Column<'b, f64>, slope: &'a Column<'b, f64>) -> Self {
        let (n, ring) = (topology.sites(), topology.ring());
        // SAFETY: the caller's promise.
        let of = |b: usize| unsafe { force.load::<f64>(PAD + b) };
        let modified = |f: [f64; 3], b: usize| modified(c, f, unsafe { slope.load::<f64>(PAD + b) });
        let none = [V::all(0.0); 2];
        let mut new =
            Self { n, c, force, slope, left: 0.0, right: 0.0, beyond: 0.0, last: 0.0, f: none, modified: none };
        if ring {
            (new.left, new.right) = (of(n - 1), of(0));
            new.beyond = modified([new.left, new.right, of(if n > 1 { 1 } else { 0 })], 0);
        } else {
            (new.left, new.right) = (of(0), of(n));
            new.beyond = modified([of(n - 1), new.right, new.right], n);
        }
        if STRAIN {
            new.last = modified([of(if n > 1 { n - 2 } else { 0 }), new.left, new.right], n - 1);
        }
        new
    }

    /// The forces of the bonds from `at` on.
    #[inline(always)]
    unsafe fn forces(&self, at: usize) -> V {
        let whole = at + V::LANES <= self.n;
        if !whole && at >= self.n {
            return V::all(self.right);
        }
        // SAFETY: columns have room for registers that begin at a site.
        let f: V = unsafe { self.force.load(PAD + at) };
        if whole { f } else { f.first(self.n - at, V::all(self.right)) }
    }

    /// The modified forces of the bonds from `at` on, from the forces of three registers: the one
    /// before, that at `at`, and the one after.
    #[inline(always)]
    unsafe fn modified(&self, at: usize, [before, f, next]: [V; 3]) -> V {
        let whole = at + V::LANES <= self.n;
        if !whole && at >= self.n {
            return V::all(self.beyond);
        }
        // SAFETY: as above.
        let slope: V = unsafe { self.slope.load(PAD + at) };
        let modified = modified(self.c, [f.after(before), f, f.before(next)], slope);
        if whole { modified } else { modified.first(self.n - at, V::all(self.beyond)) }
    }
}

/// `f + c f' s` of bonds, from the forces of three neighbouring bonds each.
#[inline(always)]
fn modified<V: Vector<f64>>(c: f64, [before, f, behind]: [V; 3], slope: V) -> V {
    f + V::all(c) * slope * ((before - f) - (f - behind))
}

impl<V: Vector<f64>, const STRAIN: bool> Pushes<'_, '_, V, STRAIN> {
    #[inline(always)]
    unsafe fn begin(&mut self, at: usize) {
        // SAFETY: the caller's promise, and that of `new`.
        unsafe {
            let of = |b: usize| self.force.load::<f64>(PAD + b);
            let mut before = V::all(if at > 0 { of(at - 1) } else { self.left });
            self.f = [self.forces(at), self.forces(at + V::LANES)];
            let here = self.modified(at, [before, self.f[0], self.f[1]]);
            if STRAIN {
                // Of the register before, the last bond.
                before = V::all(if at > 0 {
                    let f = [if at > 1 { of(at - 2) } else { self.left }, of(at - 1), of(at)];
                    modified(self.c, f, self.slope.load(PAD + at - 1))
                } else {
                    self.last
                });
            }
            self.modified = [before, here];
        }
    }

    #[inline(always)]
    unsafe fn next(&mut self, at: usize) -> V {
        // SAFETY: the caller's promise.
        let (f, next) = unsafe {
            let f = self.forces(at + 2 * V::LANES);
            (f, self.modified(at + V::LANES, [self.f[0], self.f[1], f]))
        };
        let force = push::<f64, V, STRAIN>(self.modified[0], self.modified[1], next);
        self.f = [self.f[1], f];
        self.modified = [self.modified[1], next];
        if at + V::LANES > self.n { force.first(self.n - at, V::all(0.0)) } else { force }
    }
}

/// The survey of a pass, register by register.
struct Survey<'a, 'b, P> {
    chain: &'a Chain<f64>,
    law: ContactLaw<f64>,
    /// Overlap at rest.
    rest: f64,
    power: P,
    reach: f64,
    /// Overlaps at the two surveys before, later one first.
    read: [&'a Column<'b, f64>; 2],
    /// Positions (not written if they are strains, which follow from the overlaps), overlaps,
    /// forces and derivatives.
    write: [&'a mut Column<'b, f64>; 4],
}

impl<P: Power<f64>> Survey<'_, '_, P> {
    /// Surveys the bonds to the left of the sites from `at` on; `q` are the positions of these
    /// sites and `before` those of the register before. Returns bits, which are not all zero where
    /// a bond has changed its side or may have turned near zero.
    #[inline(always)]
    unsafe fn bonds<V: Vector<f64>, const STRAIN: bool>(&mut self, at: usize, before: V, q: V) -> u64 {
        let g = overlaps::<f64, V, STRAIN>(self.rest, before, q);
        let (f, slope) = self.law.force_and_slope(self.power, g);
        let [positions, overlap, force, derivative] = &mut self.write;
        // SAFETY: the caller's promise.
        let [g1, g0]: [V; 2] = unsafe {
            if !STRAIN {
                positions.store(PAD + at, q);
            }
            overlap.store(at, g);
            force.store(PAD + at, f);
            derivative.store(PAD + at, slope);
            [self.read[0].load(at), self.read[1].load(at)]
        };
        // An overlap that turns near zero is near zero: the test for a turn itself is left out.
        let bend = ((g - g1) - (g1 - g0)).size();
        let seen = g.positive() ^ g1.positive() | (V::all(self.reach) * bend).exceeds(g1.size());
        let n = self.chain.sites();
        if V::LANES > 1 && at + V::LANES > n { seen & low(n - at) } else { seen }
    }
}
