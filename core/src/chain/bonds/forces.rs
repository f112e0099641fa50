//! Loops over all bonds: forces from positions, and kicks of sites by modified forces.
//!
//! A bond has the lane of the site to its right, as in [`sweep`](super::super::sweep).

use super::super::{
    Chain, ContactLaw, Topology,
    law::{LANES, Power, with_force, with_hertz},
    rows::force_before,
    sweep::{Sites, Visit, overlaps, push},
};
use hertzchain_integrators::{Column, Real, Vector, with_narrow};
use std::ops::Range;

/// Numbers of an array before that of site or bond 0, so that a register can begin before it.
pub(super) const PAD: usize = LANES;
/// Bonds in a word of bits.
pub(super) const WORD: usize = 64;

/// The arrays of an evaluation: positions, and what follows from them, namely overlaps, forces and
/// their derivatives, and which bonds are closed or turn near zero.
///
/// Columns are whole registers long, with a register more at either end where they begin at `PAD`.
pub(super) struct Forces<'a> {
    /// A turn counts as near zero where the overlap is below this many times its second difference.
    pub(super) reach: f64,
    /// Positions, forces and derivatives begin at `PAD`, overlaps at 0.
    pub(super) q: Column<'a, f64>,
    pub(super) overlap: Column<'a, f64>,
    pub(super) force: Column<'a, f64>,
    pub(super) slope: Column<'a, f64>,
    /// Overlaps at the two evaluations before, later one first.
    pub(super) before: [Column<'a, f64>; 2],
    /// A bit for each bond, [`WORD`] of them in a number.
    pub(super) closed: &'a mut [u64],
    pub(super) turning: &'a mut [u64],
}

/// Evaluates the bonds of a chain.
impl<M: Copy> Visit<f64, M> for Forces<'_> {
    type Output = ();

    #[inline(always)]
    fn visit<S: Sites<f64, Moment = M>>(self, chain: &Chain<f64>, sites: S, now: M) {
        let (topology, law, rest) = (chain.topology(), chain.law(), chain.precompression());
        with_narrow!(V => with_hertz!(law, power => {
            if topology.strains() {
                self.evaluate::<V, _, _, true>(topology, (law, power, rest), sites, now);
            } else {
                self.evaluate::<V, _, _, false>(topology, (law, power, rest), sites, now);
            }
        }));
    }
}

impl Forces<'_> {
    /// Evaluates the registers at `registers` again, from the positions in `q`. The bits of closed
    /// bonds are not changed.
    pub(super) fn refresh(self, chain: &Chain<f64>, registers: &[usize]) {
        with_force!(chain.law(), power, V => self.refresh_by::<V, _>(power, chain, registers));
    }

    #[inline(always)]
    fn refresh_by<V: Vector<f64>, P: Power<f64>>(mut self, power: P, chain: &Chain<f64>, registers: &[usize]) {
        let (law, strain, rest) = (chain.law(), chain.topology().strains(), V::all(chain.precompression()));
        let room = (chain.sites() + 1).next_multiple_of(LANES);
        assert!(self.overlap.len() >= room && self.before.iter().all(|column| column.len() >= room));
        assert!([&self.q, &self.force, &self.slope].iter().all(|column| column.len() >= PAD + room));
        for &register in registers {
            assert!(register % LANES == 0 && register < room);
            let mut turns = 0;
            for at in (register..register + LANES).step_by(V::LANES) {
                // SAFETY: columns have room, as asserted.
                unsafe {
                    let here: V = self.q.load(PAD + at);
                    let g = if strain { V::all(0.0) - here } else { rest + (self.q.load::<V>(PAD + at - 1) - here) };
                    let (f, slope) = law.force_and_slope(power, g);
                    self.overlap.store(at, g);
                    self.force.store(PAD + at, f);
                    self.slope.store(PAD + at, slope);
                    let (g1, g0) = (self.before[0].load(at), self.before[1].load(at));
                    turns |= turning(self.reach, [g0, g1, g]) << (at - register);
                }
            }
            let (bits, first) = (&mut self.turning[register / WORD], register % WORD);
            *bits = *bits & !(u64::MAX >> (WORD - LANES) << first) | turns << first;
        }
    }

    #[inline(always)]
    fn evaluate<V: Vector<f64>, P: Power<f64>, S: Sites<f64>, const STRAIN: bool>(
        mut self,
        topology: Topology,
        (law, power, rest): (ContactLaw<f64>, P, f64),
        sites: S,
        now: S::Moment,
    ) {
        let n = topology.sites();
        let room = (n + 1).next_multiple_of(V::LANES);
        let Forces { q, overlap, force, slope, before: [latest, first], .. } = &self;
        assert!(sites.room() >= n.next_multiple_of(V::LANES));
        assert!([overlap, latest, first].iter().all(|column| column.len() >= room));
        assert!([q, force, slope].iter().all(|column| column.len() >= PAD + room));
        self.closed.fill(0);
        self.turning.fill(0);
        let (left, right) = topology.ghosts(0.0, 0.0);
        let (mut left, mut right) = (left, right);
        // SAFETY: registers begin at most at the last bond, and columns have room for them, as
        // asserted.
        unsafe {
            if topology.ring() {
                (left, right) = (sites.positions(n - 1, &now), sites.positions(0, &now));
            }
            self.q.store(PAD - 1, left);
        }
        let (mut before, beyond) = (V::all(left), V::all(right));
        for at in (0..=n).step_by(V::LANES) {
            let here = match n - at {
                0 => beyond,
                // SAFETY: as above.
                left => unsafe { sites.positions::<V>(at, &now) }.first(left.min(V::LANES), beyond),
            };
            let g = overlaps::<f64, f64, V, STRAIN>(V::all(rest), before, here);
            let (f, by_overlap) = power.raise_with_slope(law.positive_part(g));
            // SAFETY: as above.
            unsafe {
                self.q.store(PAD + at, here);
                self.overlap.store(at, g);
                self.force.store(PAD + at, f);
                self.slope.store(PAD + at, by_overlap);
            }
            // SAFETY: as above.
            let [g1, g0]: [V; 2] = unsafe { [self.before[0].load(at), self.before[1].load(at)] };
            self.closed[at / WORD] |= g.positive() << (at % WORD);
            self.turning[at / WORD] |= turning(self.reach, [g0, g1, g]) << (at % WORD);
            before = here;
        }
    }
}

/// The numbers of a register.
#[inline(always)]
pub(super) fn lanes<V: Vector<f64>>(register: V) -> [f64; LANES] {
    let mut lanes = [0.0; LANES];
    // SAFETY: there are at most so many lanes.
    unsafe { register.store(lanes.as_mut_ptr()) };
    lanes
}

/// Sets the bits of a range of bonds, which begins with a register: which of them are closed, and
/// which turn near zero. `overlaps` are those of now and of the two evaluations before, later one
/// first.
///
/// # Safety
/// The columns have whole registers of these bonds.
#[inline(always)]
pub(super) unsafe fn mark<V: Vector<f64>>(
    bonds: Range<usize>,
    reach: f64,
    overlaps: [&Column<'_, f64>; 3],
    [closed, turns]: [&mut [u64]; 2],
) {
    let mut at = bonds.start;
    while at < bonds.end {
        let (word, first) = (at / WORD, at % WORD);
        let (end, mut bits) = (bonds.end.min((word + 1) * WORD), [0; 2]);
        while at < end {
            // SAFETY: the caller's promise.
            let [g, g1, g0]: [V; 3] = overlaps.map(|column| unsafe { column.load(at) });
            bits[0] |= g.positive() << (at % WORD);
            bits[1] |= turning(reach, [g0, g1, g]) << (at % WORD);
            at += V::LANES;
        }
        let others = !(u64::MAX >> (WORD - (at - 1) % WORD - 1) & u64::MAX << first);
        closed[word] = closed[word] & others | bits[0];
        turns[word] = turns[word] & others | bits[1];
    }
}

/// The bits of bonds whose overlap turned near zero at the evaluation before: of three overlaps in
/// a row the middle one, `g_1`, is the largest or the smallest, and `abs(g_1)` is below `reach`
/// times the size of their second difference.
#[inline(always)]
pub(in crate::chain) fn turning<R: Real, V: Vector<R>>(reach: R, [g0, g1, g2]: [V; 3]) -> u64 {
    let (before, after) = (g1 - g0, g2 - g1);
    let near = V::all(reach) * (after - before).size() - g1.size();
    (V::all(R::zero()) - before * after).positive() & near.positive()
}

/// What the modified forces `F = f + c f' s` of bonds are computed from for a kick.
pub(super) struct Modified<'a> {
    pub(super) c: f64,
    /// From `PAD` on, like `slope`.
    pub(super) force: Column<'a, f64>,
    pub(super) slope: Column<'a, f64>,
}

/// Kicks the sites of a chain by these forces.
impl<M: Copy> Visit<f64, M> for Modified<'_> {
    type Output = ();

    #[inline(always)]
    fn visit<S: Sites<f64, Moment = M>>(self, chain: &Chain<f64>, sites: S, now: M) {
        let topology = chain.topology();
        with_narrow!(V => if topology.strains() {
            self.kick::<V, _, true>(topology, sites, now);
        } else {
            self.kick::<V, _, false>(topology, sites, now);
        });
    }
}

/// `f + c f' s` of bonds, from the forces of three neighbouring bonds each.
#[inline(always)]
pub(super) fn modified<V: Vector<f64>>(c: f64, registers: [V; 3], slope: V) -> V {
    let (f, before, behind) = (registers[1], registers[1].after(registers[0]), registers[1].before(registers[2]));
    f + V::all(c) * slope * ((before - f) - (f - behind))
}

impl Modified<'_> {
    /// `F` of the bonds from `at` on, from their forces `f` and those of the registers before and
    /// after.
    ///
    /// # Safety
    /// The columns have room for a register from `PAD + at` on.
    #[inline(always)]
    unsafe fn at<V: Vector<f64>>(&self, at: usize, registers: [V; 3]) -> V {
        // SAFETY: the caller's promise.
        modified(self.c, registers, unsafe { self.slope.load(PAD + at) })
    }

    #[inline(always)]
    fn kick<V: Vector<f64>, S: Sites<f64>, const STRAIN: bool>(self, topology: Topology, mut sites: S, now: S::Moment) {
        let n = topology.sites();
        let room = PAD + (n + 1).next_multiple_of(V::LANES) + V::LANES;
        assert!(sites.room() >= n.next_multiple_of(V::LANES));
        assert!(self.force.len() >= room && self.slope.len() >= room);
        let (mut before, mut wrapped) = (V::all(0.0), 0.0);
        // SAFETY: registers begin at most at the last bond, and one follows it in the columns, as
        // asserted.
        let mut f: [V; 2] = unsafe {
            if STRAIN {
                // The last bond of a ring pushes the first strain.
                let last = [PAD + n - 2, PAD + n - 1, PAD + n].map(|at| self.force.load(at));
                wrapped = self.at::<f64>(n - 1, last);
            }
            [force_before::<f64, f64, V>(&self.force, 0), self.force.load(PAD)]
        };
        let mut modified = V::all(wrapped);
        for at in (0..=n).step_by(V::LANES) {
            // SAFETY: as above.
            let next = unsafe { self.force.load(PAD + at + V::LANES) };
            // SAFETY: as above.
            let here = unsafe { self.at::<V>(at, [f[0], f[1], next]) };
            if at > 0 {
                // SAFETY: as above.
                unsafe { sites.update(at - V::LANES, push::<f64, f64, V, STRAIN>(before, modified, here), &now) };
            }
            (before, modified, f) = (modified, here, [f[1], next]);
        }
        let rest = n % V::LANES;
        if rest > 0 {
            let none = V::all(0.0);
            let last = push::<f64, f64, V, STRAIN>(before, modified, none).first(rest, none);
            // SAFETY: as above.
            unsafe { sites.update(n - rest, last, &now) };
        }
    }
}
