//! Kicks with modified forces, each with its drift and the evaluation after it, in one pass.
//!
//! A pass kicks sites by their modified forces, drifts them and computes overlaps, forces and
//! derivatives at the new positions, as in [`rows`](super::super::rows). Modified forces are
//! computed before it, in a loop of their own, from the evaluation before: so operations of the
//! pass wait for fewer others. Forces beyond the ends are loaded bond by bond, so that no register
//! is loaded that was written in parts.
//!
//! For each register a cheap test finds whether a bond in it may have changed its side or turned
//! near zero. Only after a pass in which one may have, the exact test follows, of the registers
//! from the first such one to the last, and of all at the end of a row. One call makes steps until
//! a bond has. Sites that sleep, see [`awake`](super::awake), are left out: a pass goes over each
//! range of awake sites.

use super::{
    super::{
        Chain, ContactLaw, Topology,
        law::{Power, with_force},
        rows::{Clock, force_before, forces_on},
        sweep::{Sites, Visit, overlaps, push},
    },
    forces::{PAD, WORD, lanes, mark, modified},
};
use hertzchain_integrators::{Column, Vector};
use std::ops::Range;

/// Factor by which the cheap test of a pass widens `reach`, so that no rounding hides a turn.
const WIDER: f64 = 1.0 + 1e-9;

/// A range of sites that are awake, from `from` up to `to`; both are multiples of the widest
/// register. If `to` is smaller than `from`, the range goes up to the end of the chain and on from
/// site 0 up to `to`. If both are the same, it has all sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ActiveRange {
    pub(super) from: usize,
    pub(super) to: usize,
}

impl ActiveRange {
    /// Its bonds as ranges, in a chain with so many.
    #[inline(always)]
    pub(super) fn bonds(self, all: usize) -> [Range<usize>; 2] {
        let Self { from, to } = self;
        if from == to {
            [0..all, 0..0]
        } else if from < to {
            [from..to, 0..0]
        } else {
            [from..all, 0..to]
        }
    }
}

/// Settings and arrays of kicks that are followed by drift and evaluation in one pass.
pub(super) struct Fused<'a> {
    /// The factor `c` of the modified force `f + c f' s`.
    pub(super) c: f64,
    /// As in [`Forces`](super::forces::Forces).
    pub(super) reach: f64,
    /// Whether to end after the first pass in which a bond has changed its side or turned near
    /// zero.
    pub(super) watched: bool,
    /// The sites that are worked on.
    pub(super) awake: &'a [ActiveRange],
    /// Positions, from `PAD` on.
    pub(super) q: Column<'a, f64>,
    /// Overlaps at the last evaluation and at the two before, latest first. Each evaluation
    /// exchanges the columns, and those of forces and derivatives.
    pub(super) overlaps: [Column<'a, f64>; 3],
    /// Forces, from `PAD` on: those of the last evaluation, and room for the next.
    pub(super) forces: [Column<'a, f64>; 2],
    /// Derivatives, from `PAD` on.
    pub(super) slope: Column<'a, f64>,
    /// Modified forces, from `PAD` on, with those of neighbours beyond either end; zeros where
    /// sites sleep.
    pub(super) modified: Column<'a, f64>,
    /// A bit for each bond: whether it was closed and whether it had turned near zero at the last
    /// evaluation, and whether it was closed at the last call of `changed`.
    pub(super) closed: &'a mut [u64],
    pub(super) turning: &'a mut [u64],
    pub(super) told: &'a [u64],
}

/// At most as many `kicks` as the clock has; returns how many were made.
pub(super) struct FusedRow<'a, C> {
    pub(super) fused: Fused<'a>,
    pub(super) clock: C,
    pub(super) kicks: usize,
}

impl<C: Clock<f64>> Visit<f64, C::Moment> for FusedRow<'_, C> {
    type Output = usize;

    #[inline(always)]
    fn visit<S: Sites<f64, Moment = C::Moment>>(self, chain: &Chain<f64>, sites: S, _now: C::Moment) -> usize {
        with_force!(chain.law(), power, V => if chain.topology().strains() {
            self.kick::<V, _, _, true>((chain, power), sites)
        } else {
            self.kick::<V, _, _, false>((chain, power), sites)
        })
    }
}

impl<C: Clock<f64>> FusedRow<'_, C> {
    /// Makes the kicks, and returns how many.
    #[inline(always)]
    fn kick<V: Vector<f64>, P: Power<f64>, S: Sites<f64, Moment = C::Moment>, const STRAIN: bool>(
        self,
        (chain, power): (&Chain<f64>, P),
        mut sites: S,
    ) -> usize {
        let Self { fused, mut clock, kicks } = self;
        let (topology, n) = (chain.topology(), chain.sites());
        let bonds = n + 1;
        fused.check(n, V::LANES, sites.room());
        let Fused { c, reach, watched, awake, mut q, overlaps, forces, mut slope, mut modified, .. } = fused;
        let Fused { closed, turning, told, .. } = fused;
        let ([mut g, mut g1, mut g0], [mut f, mut f1]) = (overlaps, forces);
        // SAFETY: columns have room, as checked.
        let same = unsafe { sides::<V>(&g, topology, awake, told) };
        let kicks = if watched && !same { 1 } else { kicks };
        let mut made = 0;
        loop {
            (g, g1, g0, f, f1) = (g0, g, g1, f1, f);
            // The next moment is known after the clock has moved on.
            let (now, next, mut seen) = (clock.next(), clock.now(), bonds..0);
            for &range in awake {
                // SAFETY: as above.
                unsafe { modify::<V>(topology, c, range, [&f1, &slope], &mut modified) };
            }
            for &range in awake {
                let (read, write) = ([&g1, &g0], [&mut q, &mut g, &mut f, &mut slope]);
                let (law, rest, reach) = (chain.law(), chain.precompression(), reach * WIDER);
                let seen = &mut seen;
                let evaluation = Evaluation { n, law, rest, power, watched, reach, read, write, seen };
                // SAFETY: as above.
                unsafe { pass::<V, _, _, STRAIN>(topology, &mut sites, [&now, &next], range, &modified, evaluation) };
            }
            made += 1;
            if made == kicks || seen.end > 0 {
                let looked_at = if made == kicks {
                    0..usize::MAX
                } else {
                    turning.fill(0);
                    seen.start / V::LANES * V::LANES..seen.end
                };
                // No closure: it would not be compiled for the registers of the pass.
                for bonds in awake.iter().flat_map(|range| range.bonds(bonds)) {
                    let bonds = bonds.start.max(looked_at.start)..bonds.end.min(looked_at.end);
                    // SAFETY: as above.
                    unsafe { mark::<V>(bonds, reach, [&g, &g1, &g0], [&mut *closed, &mut *turning]) };
                }
                if made == kicks || tells(topology, [&*closed, &*turning, told]) {
                    break;
                }
            }
        }
        if STRAIN {
            for bonds in awake.iter().flat_map(|range| range.bonds(bonds)) {
                for at in (bonds.start..bonds.end.min(n)).step_by(V::LANES) {
                    // SAFETY: as above.
                    unsafe { q.store(PAD + at, V::all(0.0) - g.load(at)) };
                }
            }
        }
        made
    }
}

/// Stores the modified forces of the bonds of a range, and those beyond the ends of the chain,
/// from forces and derivatives.
///
/// # Safety
/// Columns have room.
#[inline(always)]
unsafe fn modify<V: Vector<f64>>(
    topology: Topology,
    c: f64,
    range: ActiveRange,
    [force, slope]: [&Column<'_, f64>; 2],
    to: &mut Column<'_, f64>,
) {
    let (n, ring) = (topology.sites(), topology.ring());
    // SAFETY: the caller's promise.
    let of = |b: usize| unsafe { force.load::<f64>(PAD + b) };
    // Forces beyond the ends: on a ring those of the neighbours, else copies of the outer ones.
    let (left, right, after) = if ring { (of(n - 1), of(0), of(1 % n)) } else { (of(0), of(n), of(n)) };
    for Range { start, end } in range.bonds(n + 1) {
        let mut before = V::all(if start > 0 { of(start - 1) } else { left });
        let mut at = start;
        // SAFETY: as above.
        let mut f: V = unsafe { forces_from::<V>(n, at, right, force) };
        while at < end.min(n) {
            // SAFETY: as above.
            unsafe {
                let next = forces_from::<V>(n, at + V::LANES, right, force);
                to.store(PAD + at, modified::<V>(c, [before, f, next], slope.load(PAD + at)));
                (before, f, at) = (f, next, at + V::LANES);
            }
        }
        if end > n {
            // SAFETY: as above.
            let slope = unsafe { slope.load(PAD + if ring { 0 } else { n }) };
            let beyond = modified::<f64>(c, [of(n - 1), right, after], slope);
            // SAFETY: as above.
            unsafe {
                to.store(PAD + n.next_multiple_of(V::LANES), V::all(beyond));
                to.store::<f64>(PAD - 1, to.load(PAD + n - 1));
            }
        }
    }
}

/// The forces of the bonds from `at` on, `right` in lanes after the last site. No register is
/// loaded that was written in parts.
///
/// # Safety
/// The column has room for registers that begin at a site.
#[inline(always)]
unsafe fn forces_from<V: Vector<f64>>(n: usize, at: usize, right: f64, force: &Column<'_, f64>) -> V {
    if at >= n {
        return V::all(right);
    }
    // SAFETY: the caller's promise.
    let f: V = unsafe { force.load(PAD + at) };
    if at + V::LANES <= n { f } else { f.first(n - at, V::all(right)) }
}

/// Kicks and drifts the sites of a range by modified `forces`, and evaluates their bonds.
///
/// # Safety
/// Columns have room.
#[inline(always)]
unsafe fn pass<V: Vector<f64>, S: Sites<f64>, P: Power<f64>, const STRAIN: bool>(
    topology: Topology,
    sites: &mut S,
    [now, next]: [&S::Moment; 2],
    ActiveRange { from, to }: ActiveRange,
    forces: &Column<'_, f64>,
    mut evaluation: Evaluation<'_, '_, P>,
) {
    let (n, ring) = (topology.sites(), topology.ring());
    let end = n.next_multiple_of(V::LANES);
    // Overlaps of strains need no neighbour. In a pass over a whole ring the first register is
    // evaluated last, since its first overlap needs the site before it.
    let wait = ring && !STRAIN && from == to;
    let (left, right) = topology.ghosts(0.0, 0.0);
    let (mut q, mut first, mut at) = (V::all(left), V::all(left), from);
    // SAFETY: the caller's promise.
    unsafe {
        if wait {
            first = sites.advance(at, forces_on::<f64, f64, V, STRAIN>(forces, n, at), now, next);
            let whole = at + V::LANES < n;
            (q, at) = (if whole { first } else { first.spread(n - 1 - at) }, at + V::LANES);
        } else if !STRAIN && from != to && (ring || from > 0) {
            // The site before sleeps: nothing pushes it.
            let site = if from > 0 { from - 1 } else { n - 1 };
            let before = sites.advance(site, 0.0, now, next);
            evaluation.write[0].store(PAD + site, before);
            q = V::all(before);
        }
        let wraps = to <= from;
        for registers in [at..if wraps { end } else { to }, 0..if wraps { to } else { 0 }] {
            q = part::<V, S, P, STRAIN>(sites, [now, next], registers, q, forces, &mut evaluation);
        }
        if wait {
            evaluation.bonds::<V, STRAIN>(from, q, first);
        } else if !ring && (from == to || to == 0) {
            evaluation.bonds::<f64, STRAIN>(n, lanes(q)[0], right)
        }
    }
}

/// [`pass`] over registers that follow each other. `q` are the positions of the register before;
/// returns those of the last one.
///
/// # Safety
/// Columns have room.
#[inline(always)]
unsafe fn part<V: Vector<f64>, S: Sites<f64>, P: Power<f64>, const STRAIN: bool>(
    sites: &mut S,
    [now, next]: [&S::Moment; 2],
    registers: Range<usize>,
    mut q: V,
    forces: &Column<'_, f64>,
    evaluation: &mut Evaluation<'_, '_, P>,
) -> V {
    let (n, mut at) = (evaluation.n, registers.start);
    if registers.is_empty() {
        return q;
    }
    // SAFETY: the caller's promise.
    unsafe {
        let (mut before, mut f) = (force_before::<f64, f64, V>(forces, at), forces.load::<V>(PAD + at));
        while at < registers.end && at + V::LANES < n {
            let after = forces.load(PAD + at + V::LANES);
            let force = push::<f64, f64, V, STRAIN>(before, f, after);
            let here = sites.advance(at, force, now, next);
            evaluation.bonds::<V, STRAIN>(at, q, here);
            (q, before, f) = (here, f, after);
            at += V::LANES;
        }
        if at < registers.end {
            let here = sites.advance(at, forces_on::<f64, f64, V, STRAIN>(forces, n, at), now, next);
            evaluation.bonds::<V, STRAIN>(at, q, here);
            q = here.spread(n - 1 - at);
        }
    }
    q
}

impl Fused<'_> {
    /// Asserts that columns have room for registers that begin at most at the last bond.
    fn check(&self, n: usize, lanes: usize, sites: usize) {
        let room = (n + 1).next_multiple_of(lanes);
        assert!(self.awake.iter().all(|range| range.from.max(range.to) < n), "ranges are of the chain");
        assert!(sites >= n.next_multiple_of(lanes), "columns are whole registers");
        assert!(self.overlaps.iter().all(|column| column.len() >= room));
        let padded = self.forces.iter().chain([&self.slope, &self.q, &self.modified]);
        assert!(padded.into_iter().all(|column| column.len() >= PAD + room + lanes));
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
    awake: &[ActiveRange],
    told: &[u64],
) -> bool {
    let mut differences = 0;
    for bonds in awake.iter().flat_map(|range| range.bonds(topology.sites() + 1)) {
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

/// The evaluation of a pass, register by register.
struct Evaluation<'a, 'b, P> {
    n: usize,
    law: ContactLaw<f64>,
    /// Overlap at rest.
    rest: f64,
    power: P,
    /// Whether bonds are tested.
    watched: bool,
    reach: f64,
    /// Where bonds have changed their sides or may have turned near zero.
    seen: &'a mut Range<usize>,
    /// Overlaps at the two evaluations before, later one first.
    read: [&'a Column<'b, f64>; 2],
    /// Positions (not written if they are strains, which follow from the overlaps), overlaps,
    /// forces and derivatives.
    write: [&'a mut Column<'b, f64>; 4],
}

impl<P: Power<f64>> Evaluation<'_, '_, P> {
    /// Evaluates the bonds to the left of the sites from `at` on; `q` are the positions of these
    /// sites and `before` those of the register before.
    #[inline(always)]
    unsafe fn bonds<V: Vector<f64>, const STRAIN: bool>(&mut self, at: usize, before: V, q: V) {
        let g = overlaps::<f64, f64, V, STRAIN>(V::all(self.rest), before, q);
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
            if !self.watched {
                return;
            }
            [self.read[0].load(at), self.read[1].load(at)]
        };
        // An overlap that turns near zero is near zero: the test for a turn itself is left out.
        let curvature = ((g - g1) - (g1 - g0)).size();
        let seen = g.positive() ^ g1.positive() | (V::all(self.reach) * curvature).exceeds(g1.size());
        let inside = if V::LANES > 1 && at + V::LANES > self.n { low(self.n - at) } else { u64::MAX };
        if seen & inside != 0 {
            *self.seen = self.seen.start.min(at)..self.seen.end.max(at + V::LANES);
        }
    }
}
