//! Kicks of a short chain in a row.
//!
//! A chain that stays in the nearest cache is limited by square roots, if nothing waits for them.
//! So forces are known before a pass begins: it gives each register of sites the forces of this
//! kick, and computes from the new positions, which it has at hand, those of the next kick. No
//! register waits for another of the same pass.
//!
//! On a ring a pass begins two registers after the one before it. Its first registers then need no
//! force that was computed last. Each number is computed as by one kick after the other, so that
//! the bits are the same.

use super::{
    Chain,
    aligned::Aligned,
    law::{ContactLaw, LANES, Power, with_power},
    sweep::{Sites, overlaps},
};
use hertzchain_integrators::{Column, Real, Twofold, Vector, VectorKernel};

/// Sites up to which kicks are made in rows. Timed with AVX2 on rings (least of many samples), a
/// step takes 0.73 (`strang-linear`) and 0.89 (`verlet`) of the time of one kick after the other
/// with 1000 sites; docs/decisions.md has 50.
const SHORT: usize = 4096;
/// Numbers before the force of the first bond.
const PAD: usize = LANES;

/// Sites whose kicks and drifts are known one after the other.
pub(crate) trait Moving<R: Real>: Sites<R> {
    /// What a kick and its drift depend on.
    type Moment: Copy;
    /// Goes on to the next kick.
    fn turn_to(&mut self, moment: Self::Moment);
    /// Updates the sites from `at` on, and returns their positions at the next kick.
    ///
    /// # Safety
    /// There is room for `at + LANES` numbers.
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, next: &Self::Moment) -> V;
}

/// What kicks in a row depend on, one after the other.
pub(crate) trait Clock {
    /// What a kick and its drift depend on.
    type Moment: Copy;
    /// That of the next kick, and then the drift. Called once for each kick.
    fn next(&mut self) -> Self::Moment;
    /// Positions now, with a kick of no duration.
    fn now(&self) -> Self::Moment;
}

/// What is done with the sites of a flow, and with the clock of some kicks in a row.
pub(crate) trait InRow<R: Real> {
    /// What it returns.
    type Output;
    /// Does it, with at most as many `kicks` as the clock has.
    fn run<S: Moving<R>, C: Clock<Moment = S::Moment>>(
        self,
        chain: &Chain<R>,
        sites: S,
        clock: C,
        kicks: usize,
    ) -> Self::Output;
}

/// Kicks and no more.
impl<R: Real> InRow<R> for &mut RowForces<R> {
    type Output = ();

    #[inline(always)]
    fn run<S: Moving<R>, C: Clock<Moment = S::Moment>>(self, chain: &Chain<R>, sites: S, clock: C, kicks: usize) {
        Row { chain, forces: self, sites, clock, kicks }.make();
    }
}

/// Forces of bonds at a kick and the next, from `PAD` on, with a register more on either side.
#[derive(Debug)]
pub(crate) struct RowForces<R>([Aligned<R>; 2]);

impl<R: Real> RowForces<R> {
    /// Room for the forces of a chain, if it is short.
    pub(crate) fn new(chain: &Chain<R>) -> Self {
        let n = chain.sites();
        Self(if n <= SHORT { Aligned::between(PAD + n + 1 + 2 * LANES) } else { Aligned::between(0) })
    }

    /// No room.
    pub(crate) fn none() -> Self {
        Self(Aligned::between(0))
    }

    /// Whether kicks are made in rows.
    pub(crate) fn used(&self) -> bool {
        !self.0[0].is_empty()
    }
}

/// So many kicks in a row.
pub(crate) struct Row<'a, R, S, C> {
    pub(crate) chain: &'a Chain<R>,
    pub(crate) forces: &'a mut RowForces<R>,
    pub(crate) sites: S,
    pub(crate) clock: C,
    pub(crate) kicks: usize,
}

impl<R: Real, S: Moving<R>, C: Clock<Moment = S::Moment>> Row<'_, R, S, C> {
    /// Makes the kicks.
    // Not inlined: the kernel is compiled once for each kind of sites.
    #[inline(never)]
    pub(crate) fn make(self) {
        R::run_vector(self);
    }
}

impl<R: Real, S: Moving<R>, C: Clock<Moment = S::Moment>> VectorKernel<R> for Row<'_, R, S, C> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector<R>>(self) {
        with_power!(self.chain.law, power => {
            if self.chain.topology.strains() {
                self.lanes::<V, _, true>(power);
            } else {
                self.lanes::<V, _, false>(power);
            }
        });
    }
}

impl<R: Real, S: Moving<R>, C: Clock<Moment = S::Moment>> Row<'_, R, S, C> {
    #[inline(always)]
    fn lanes<V: Vector<R>, P: Power<R>, const STRAIN: bool>(self, power: P) {
        let Self { chain, forces, mut sites, mut clock, kicks } = self;
        let (n, ring) = (chain.sites(), chain.topology.ring());
        let registers = n.next_multiple_of(V::LANES);
        let [here, there] = &mut forces.0;
        let (mut here, mut there) = (here.column(), there.column());
        assert!(sites.room() >= registers, "columns are whole registers");
        assert!([&here, &there].iter().all(|column| column.len() > PAD + registers + V::LANES));
        // One moment ahead, so that no position waits for it.
        let mut now = clock.next();
        let mut next = if kicks > 1 { clock.next() } else { now };
        sites.turn_to(now);
        let mut pass = Pass { chain, start: 0 };
        let law = chain.law;
        // SAFETY: columns have room, as asserted.
        unsafe { pass.go::<V, _, _, STRAIN, false>(&mut sites, &now, &here, Raised { law, power, to: &mut there }) };
        (here, there) = (there, here);
        for left in (1..kicks).rev() {
            let ahead = if left > 1 { clock.next() } else { next };
            if ring {
                pass.start = (pass.start + 2 * V::LANES) % registers;
            }
            // SAFETY: as above.
            unsafe {
                pass.go::<V, _, _, STRAIN, true>(&mut sites, &next, &here, Raised { law, power, to: &mut there })
            };
            (here, there) = (there, here);
            (now, next) = (next, ahead);
            sites.turn_to(now);
        }
        for at in (0..n).step_by(V::LANES) {
            // SAFETY: as above.
            unsafe { sites.update(at, given::<R, V, STRAIN>(&here, n, at)) };
        }
    }
}

/// What is done with bonds whose overlaps are known.
trait Bonds<R: Real> {
    /// Takes the bonds to the left of the sites from `at` on.
    ///
    /// # Safety
    /// `at` begins a register of sites, or is the last bond of a chain with ends.
    unsafe fn take<V: Vector<R>>(&mut self, at: usize, positions: V, overlaps: V);
    /// Copies what lies beyond the ends of a ring of `n` sites.
    ///
    /// # Safety
    /// All bonds were taken.
    unsafe fn join(&mut self, n: usize);
}

/// Forces alone.
struct Raised<'a, 'b, R, P> {
    law: ContactLaw<R>,
    power: P,
    to: &'a mut Column<'b, R>,
}

impl<R: Real, P: Power<R>> Bonds<R> for Raised<'_, '_, R, P> {
    #[inline(always)]
    unsafe fn take<V: Vector<R>>(&mut self, at: usize, _positions: V, overlaps: V) {
        let force = self.power.raise(self.law.positive_part(overlaps));
        // SAFETY: the caller's promise.
        unsafe { self.to.store(PAD + at, force) }
    }

    #[inline(always)]
    unsafe fn join(&mut self, n: usize) {
        // SAFETY: the caller's promise.
        unsafe {
            self.to.store::<R>(PAD - 1, self.to.load(PAD + n - 1));
            self.to.store::<R>(PAD + n, self.to.load(PAD));
        }
    }
}

/// A pass over all registers of a chain.
struct Pass<'a, R> {
    chain: &'a Chain<R>,
    /// Where it begins: at 0, but on rings.
    start: usize,
}

impl<R: Real> Pass<'_, R> {
    /// Gives sites their forces, if there are any, and hands on the overlaps at the `next` kick.
    ///
    /// # Safety
    /// The columns of sites are whole registers; those of bonds have a register more than these on
    /// either side.
    #[inline(always)]
    unsafe fn go<V: Vector<R>, S: Moving<R>, B: Bonds<R>, const STRAIN: bool, const KICK: bool>(
        &self,
        sites: &mut S,
        next: &S::Moment,
        forces: &Column<'_, R>,
        mut bonds: B,
    ) {
        let Self { chain, start } = *self;
        let (n, ring) = (chain.sites(), chain.topology.ring());
        let last = n.next_multiple_of(V::LANES) - V::LANES;
        // Overlaps of strains need no neighbour; on a ring the first register waits for the last.
        let wait = ring && !STRAIN;
        let (left, right) = chain.topology.ghosts(R::zero(), R::zero());
        let (mut q, mut first) = (V::all(left), V::all(left));
        let mut at = start;
        // SAFETY, here and below: the caller's promise.
        unsafe {
            loop {
                let here = if KICK {
                    sites.advance(at, given::<R, V, STRAIN>(forces, n, at), next)
                } else {
                    sites.positions::<V>(at)
                };
                if wait && at == start {
                    first = here;
                } else {
                    bonds.take(at, here, overlaps::<R, V, STRAIN>(chain, q, here));
                }
                q = here;
                if at == last {
                    if !STRAIN {
                        let mut lanes = [R::zero(); LANES];
                        here.store(lanes.as_mut_ptr());
                        q = V::all(lanes[n - 1 - last]);
                    }
                    at = 0;
                } else {
                    at += V::LANES;
                }
                if at == start {
                    break;
                }
            }
            if wait {
                bonds.take(start, first, overlaps::<R, V, STRAIN>(chain, q, first));
            }
            if ring {
                bonds.join(n);
            } else {
                let mut lanes = [R::zero(); LANES];
                q.store(lanes.as_mut_ptr());
                bonds.take::<R>(n, right, overlaps::<R, R, STRAIN>(chain, lanes[0], right));
            }
        }
    }
}

/// What the forces of bonds give to the sites from `at` on; nothing to those beyond the last.
///
/// # Safety
/// The column has a register before that of the first bond, and one after the last.
#[inline(always)]
unsafe fn given<R: Real, V: Vector<R>, const STRAIN: bool>(forces: &Column<'_, R>, n: usize, at: usize) -> V {
    // SAFETY: the caller's promise.
    let [before, here, next]: [V; 3] =
        unsafe { [forces.load(PAD + at - 1), forces.load(PAD + at), forces.load(PAD + at + 1)] };
    let force = if STRAIN { (here - before) - (next - here) } else { here - next };
    if at + V::LANES > n { force.first(n - at, V::all(R::zero())) } else { force }
}

/// Kicks and their drifts, one after the other.
pub(crate) type Pairs<'a, R> = std::slice::Iter<'a, (R, Twofold<R>)>;

#[cfg(test)]
mod tests {
    use super::super::{Boundary, KineticFlow, LinearFlow, Params};
    use super::*;
    use hertzchain_integrators::{Instructions, SplitFlow};

    /// The state after kicks in rows, and after one after the other.
    fn both_ways<F: SplitFlow<f64>>(mut flow: F, y: &[f64], pairs: &[(f64, Twofold<f64>)]) -> [Vec<u64>; 2] {
        flow.load(y);
        let mut other = flow.duplicate();
        pairs.chunks(40).for_each(|row| flow.kick_drifts(row));
        pairs.iter().for_each(|&(kick, drift)| other.kick_drift(kick, drift));
        [&flow, &other].map(|flow| {
            let mut state = y.to_vec();
            flow.store(&mut state);
            state.iter().map(|x| x.to_bits()).collect()
        })
    }

    #[test]
    fn kicks_in_rows_have_the_bits_of_one_after_the_other() {
        // Truth: one kick at a time; all lengths around a few registers, and more kicks than there
        // are between two anchors.
        let _alone = crate::chain::one_set_at_a_time();
        let used = Instructions::used();
        let pairs: Vec<_> = (0..70).map(|k| (0.01 + 1e-4 * f64::from(k % 3), Twofold::new(0.02))).collect();
        for set in Instructions::ALL.into_iter().filter(|set| set.select()) {
            for boundary in [Boundary::Free, Boundary::Fixed, Boundary::Ring, Boundary::StrainRing] {
                for (n, rho) in (1..36).flat_map(|n| [0.0, 1.0 / 3.0, f64::INFINITY].map(|rho| (n, rho))) {
                    let params = Params::new([1.2, 1.5, 2.0, 2.5][n % 4], 1.0, rho).unwrap();
                    let Ok(chain) = Chain::<f64>::new(params, boundary, n) else { continue };
                    let chain = chain.clone().precompressed(0.1).unwrap_or(chain);
                    let y: Vec<f64> = (0..chain.layout().dim()).map(|i| (0.7 * (i * i) as f64 + 0.3).sin()).collect();
                    let [got, want] = both_ways(KineticFlow::new(chain.clone()), &y, &pairs);
                    assert!(got == want, "kinetic {boundary:?} {n} {rho} {set}");
                    let [got, want] = both_ways(LinearFlow::new(chain), &y, &pairs);
                    assert!(got == want, "linear {boundary:?} {n} {rho} {set}");
                }
            }
        }
        assert!(used.select());
    }
}
