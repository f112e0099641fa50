//! A kick with modified forces, the drift and the survey after it, in one call.
//!
//! Three loops: modified forces; the pass that gives them to sites, moves these on and computes the
//! forces there, as in [`rows`](super::super::rows); which bonds are closed or turn. In one loop
//! the operations that a processor sees ahead would be those of two registers, which then wait for
//! each other's square roots.

use super::{
    super::{
        Chain, ContactLaw,
        law::{Power, with_power},
        rows::{Bonds, Moving, Pass},
        sweep::Visit,
    },
    Forces, PAD,
};
use hertzchain_integrators::{Column, Real, Vector, VectorKernel};

/// What a kick that surveys works with.
pub struct Fused<'a> {
    /// The share of the modified force.
    pub(super) c: f64,
    /// Forces and derivatives of the survey before, from `PAD` on; those of neighbours beyond the
    /// ends are there.
    pub(super) force: Column<'a, f64>,
    pub(super) slope: Column<'a, f64>,
    /// Room for modified forces, from `PAD` on.
    pub(super) modified: Column<'a, f64>,
    /// What the survey writes.
    pub(super) forces: Forces<'a>,
    /// Site at which the pass begins: a register of any width does, and it is 0 but on rings.
    pub(super) start: usize,
}

/// Makes a kick on the sites of a flow, and surveys those at the time of the `next` kick.
pub(super) struct FusedTo<'a, M> {
    pub(super) next: M,
    pub(super) fused: Fused<'a>,
}

impl<M> Visit<f64, M> for FusedTo<'_, M> {
    #[inline(always)]
    fn visit<S: Moving<f64, Moment = M>>(self, chain: &Chain<f64>, sites: S) {
        f64::run_vector(Kernel { chain, sites, next: self.next, fused: self.fused });
    }
}

struct Kernel<'a, S: Moving<f64>> {
    chain: &'a Chain<f64>,
    sites: S,
    next: S::Moment,
    fused: Fused<'a>,
}

impl<S: Moving<f64>> VectorKernel<f64> for Kernel<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector<f64>>(self) {
        with_power!(self.chain.law(), power => {
            if self.chain.topology().strains() {
                self.lanes::<V, _, true>(power);
            } else {
                self.lanes::<V, _, false>(power);
            }
        });
    }
}

impl<S: Moving<f64>> Kernel<'_, S> {
    #[inline(always)]
    fn lanes<V: Vector<f64>, P: Power<f64>, const STRAIN: bool>(self, power: P) {
        let Self { chain, mut sites, next, fused } = self;
        let Fused { c, force, slope, mut modified, mut forces, start } = fused;
        let (n, law) = (chain.sites(), chain.law());
        let room = (n + 1).next_multiple_of(V::LANES);
        assert!(sites.room() >= n.next_multiple_of(V::LANES) && start < n);
        let Forces { q, overlap, before: [latest, first], .. } = &forces;
        assert!([overlap, latest, first].iter().all(|column| column.len() >= room));
        let padded = [q, &forces.force, &forces.slope, &force, &slope, &modified];
        assert!(padded.iter().all(|column| column.len() >= PAD + room + V::LANES));
        // SAFETY: columns have room, as asserted, for registers that begin at most at the last
        // bond, and more on either side.
        unsafe {
            // In the order in which they are wanted.
            let end = n / V::LANES * V::LANES;
            let mut at = start;
            loop {
                let [before, f, behind]: [V; 3] =
                    [force.load(PAD + at - 1), force.load(PAD + at), force.load(PAD + at + 1)];
                let pull = (before - f) - (f - behind);
                modified.store(PAD + at, f + V::all(c) * slope.load(PAD + at) * pull);
                at = if at == end { 0 } else { at + V::LANES };
                if at == start {
                    break;
                }
            }
            if STRAIN {
                modified.store::<f64>(PAD - 1, modified.load(PAD + n - 1));
            }
            let bonds = Surveyed { law, power, forces: &mut forces };
            Pass { chain, start }.go::<V, _, _, STRAIN, true>(&mut sites, &next, &modified, bonds);
            forces.mark::<V>(n);
        }
    }
}

/// Overlaps, forces and derivatives.
struct Surveyed<'a, 'b, P> {
    law: ContactLaw<f64>,
    power: P,
    forces: &'a mut Forces<'b>,
}

impl<P: Power<f64>> Bonds<f64> for Surveyed<'_, '_, P> {
    #[inline(always)]
    unsafe fn take<V: Vector<f64>>(&mut self, at: usize, positions: V, overlaps: V) {
        let Self { law, power, forces } = self;
        let (f, slope) = power.raise_with_slope(law.positive_part(overlaps));
        // SAFETY: the caller's promise.
        unsafe {
            forces.q.store(PAD + at, positions);
            forces.overlap.store(at, overlaps);
            forces.force.store(PAD + at, f);
            forces.slope.store(PAD + at, slope);
        }
    }

    #[inline(always)]
    unsafe fn join(&mut self, n: usize) {
        let Forces { q, overlap, force, slope, .. } = &mut self.forces;
        // SAFETY: the caller's promise.
        unsafe {
            q.store::<f64>(PAD - 1, q.load(PAD + n - 1));
            overlap.store::<f64>(n, overlap.load(0));
            for column in [q, force, slope] {
                column.store::<f64>(PAD + n, column.load(PAD));
            }
        }
    }
}
