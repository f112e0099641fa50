//! One pass over the chain: positions, contact forces, update, a block of sites at a time.
//!
//! A block stays in the first-level cache, so that a sweep reads and writes each array once. Inner
//! loops have no branch; [`Real::run`] compiles them for the vector unit at hand.

use super::{
    Chain,
    law::{Power, with_power},
};
use hertzchain_integrators::{Kernel, Real};

/// Sites in a block: it stays in the first-level cache, and its buffers cost little to clear on a
/// short chain. Timed by `benches/kernels.rs`.
const BLOCK: usize = 128;

/// What a sweep visits: something that has positions and takes forces.
pub(crate) trait Sites<R> {
    /// The position of site `i`.
    fn position(&self, i: usize) -> R;
    /// The positions of the sites from `start` on, as many as `scratch` holds; written there unless
    /// they are at hand.
    fn positions<'a>(&'a self, start: usize, scratch: &'a mut [R]) -> &'a [R];
    /// Hands over the contact force on each of `len` sites from `start` on, and may then move them.
    fn update(&mut self, start: usize, len: usize, force: impl Fn(usize) -> R);
}

/// The positions of a flow that holds them as they are.
macro_rules! positions_are_u {
    () => {
        #[inline(always)]
        fn position(&self, i: usize) -> R {
            self.u[i]
        }

        #[inline(always)]
        fn positions<'a>(&'a self, start: usize, scratch: &'a mut [R]) -> &'a [R] {
            &self.u[start..start + scratch.len()]
        }
    };
}
pub(crate) use positions_are_u;

/// Visits every site of `chain` once.
pub(crate) fn sweep<R: Real, S: Sites<R>>(chain: &Chain<R>, sites: &mut S) {
    R::run(Sweep { chain, sites });
}

struct Sweep<'a, R, S> {
    chain: &'a Chain<R>,
    sites: &'a mut S,
}

impl<R: Real, S: Sites<R>> Kernel for Sweep<'_, R, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        with_power!(self.chain.law, power => {
            if self.chain.topology.strains() {
                blocks::<R, S, _, true>(self.chain, power, self.sites);
            } else {
                blocks::<R, S, _, false>(self.chain, power, self.sites);
            }
        });
    }
}

#[inline(always)]
fn blocks<R: Real, S: Sites<R>, P: Power<R>, const STRAIN: bool>(chain: &Chain<R>, power: P, sites: &mut S) {
    let n = chain.sites();
    let (mut q, mut f) = ([R::zero(); BLOCK], [R::zero(); BLOCK + 2]);
    let (mut left, last) = chain.topology.ghosts(sites.position(0), sites.position(n - 1));
    for start in (0..n).step_by(BLOCK) {
        let len = BLOCK.min(n - start);
        let right = if start + len < n { sites.position(start + len) } else { last };
        let q = sites.positions(start, &mut q[..len]);
        let neighbours = (left, q, right);
        // The next block needs this position as it was before the update.
        left = q[len - 1];
        if STRAIN {
            let f = &mut f[..len + 2];
            strain_forces(chain, power, neighbours, f);
            sites.update(start, len, |i| (f[i + 1] - f[i]) - (f[i + 2] - f[i + 1]));
        } else {
            let f = &mut f[..len + 1];
            bond_forces(chain, power, neighbours, f);
            sites.update(start, len, |i| f[i] - f[i + 1]);
        }
    }
}

/// `f_i = (delta_0 + q_{i-1} - q_i)_+^alpha` for a block of displacements and its two neighbours.
#[inline(always)]
fn bond_forces<R: Real, P: Power<R>>(chain: &Chain<R>, power: P, (left, q, right): (R, &[R], R), f: &mut [R]) {
    let delta = chain.precompression;
    let law = |before: R, after: R| power.raise(chain.law.positive_part(delta + (before - after)));
    let len = q.len();
    f[0] = law(left, q[0]);
    for ((f, &before), &after) in f[1..len].iter_mut().zip(&q[..len - 1]).zip(&q[1..]) {
        *f = law(before, after);
    }
    f[len] = law(q[len - 1], right);
}

/// `f_i = (-x_i)_+^alpha` for a block of strains and its two neighbours.
#[inline(always)]
fn strain_forces<R: Real, P: Power<R>>(chain: &Chain<R>, power: P, (left, q, right): (R, &[R], R), f: &mut [R]) {
    let law = |x: R| power.raise(chain.law.positive_part(-x));
    let len = q.len();
    f[0] = law(left);
    for (f, &x) in f[1..=len].iter_mut().zip(q) {
        *f = law(x);
    }
    f[len + 1] = law(right);
}
