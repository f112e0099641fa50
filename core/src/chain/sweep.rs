//! One pass over the chain: positions, contact forces, update, a register of sites at a time.
//!
//! Forces stay in registers. The bond to the left of a site has its lane; neighbours come from the
//! register before, moved by a lane. A register of sites is updated when the forces of the next
//! are known, so that a pass reads and writes each array once, and no load waits for a store of the
//! same pass. [`Real::run_vector`] compiles the pass for the vector unit at hand.

use super::{
    Chain,
    law::{Power, with_power},
};
use hertzchain_integrators::{Real, Vector, VectorKernel};

/// What a sweep visits: sites in columns that are whole registers long.
pub(crate) trait Sites<R: Real> {
    /// Length of the columns.
    fn room(&self) -> usize;
    /// The positions of the sites from `at` on.
    ///
    /// # Safety
    /// There is room for `at + LANES` numbers.
    unsafe fn positions<V: Vector<R>>(&self, at: usize) -> V;
    /// Gives the sites from `at` on their contact forces, and may then move them. Sites beyond the
    /// last get no force.
    ///
    /// # Safety
    /// There is room for `at + LANES` numbers.
    unsafe fn update<V: Vector<R>>(&mut self, at: usize, force: V);
}

/// What is done with the sites of a flow, whatever its model.
pub(crate) trait Visit<R: Real> {
    fn visit<S: Sites<R>>(self, chain: &Chain<R>, sites: S);
}

/// Visits every site of `chain` once.
pub(crate) fn sweep<R: Real, S: Sites<R>>(chain: &Chain<R>, sites: S) {
    R::run_vector(Sweep { chain, sites });
}

struct Sweep<'a, R, S> {
    chain: &'a Chain<R>,
    sites: S,
}

impl<R: Real, S: Sites<R>> VectorKernel<R> for Sweep<'_, R, S> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector<R>>(self) {
        assert!(self.sites.room() >= self.chain.sites().next_multiple_of(V::LANES), "columns are whole registers");
        with_power!(self.chain.law, power => {
            if self.chain.topology.strains() {
                pass::<R, V, S, _, true>(self.chain, power, self.sites);
            } else {
                pass::<R, V, S, _, false>(self.chain, power, self.sites);
            }
        });
    }
}

#[inline(always)]
fn pass<R: Real, V: Vector<R>, S: Sites<R>, P: Power<R>, const STRAIN: bool>(chain: &Chain<R>, power: P, mut sites: S) {
    let n = chain.sites();
    let (rest, end) = (n % V::LANES, n - n % V::LANES);
    // SAFETY, here and below: a register of sites that begins before `n` ends within the columns,
    // by the check of `run`.
    let (first, last) = unsafe { (sites.positions::<R>(0), sites.positions::<R>(n - 1)) };
    let (left, right) = chain.topology.ghosts(first, last);
    let mut q = V::all(left);
    // Forces of the register to be updated next, and of that before.
    let (mut before, mut f) = (V::all(R::zero()), bonds::<R, V, P, STRAIN>(chain, power, q, q));
    for at in (0..end).step_by(V::LANES) {
        let here = unsafe { sites.positions::<V>(at) };
        let next = bonds::<R, V, P, STRAIN>(chain, power, q, here);
        if at > 0 {
            unsafe { sites.update(at - V::LANES, push::<R, V, STRAIN>(before, f, next)) };
        }
        (q, before, f) = (here, f, next);
    }
    // The sites that fill no register, and what lies beyond the last.
    let beyond = V::all(right);
    let here = if rest > 0 { unsafe { sites.positions::<V>(end) }.first(rest, beyond) } else { beyond };
    let next = bonds::<R, V, P, STRAIN>(chain, power, q, here);
    if end > 0 {
        unsafe { sites.update(end - V::LANES, push::<R, V, STRAIN>(before, f, next)) };
    }
    if rest > 0 {
        let none = V::all(R::zero());
        unsafe { sites.update(end, push::<R, V, STRAIN>(f, next, none).first(rest, none)) };
    }
}

// Functions, as closures would not be compiled for the registers of the pass.

/// The forces of bonds to the left of sites, `(delta_0 + q_{i-1} - q_i)_+^alpha` from positions or
/// `(-x_i)_+^alpha` from strains.
#[inline(always)]
fn bonds<R: Real, V: Vector<R>, P: Power<R>, const STRAIN: bool>(chain: &Chain<R>, power: P, before: V, q: V) -> V {
    let overlaps = if STRAIN { V::all(R::zero()) - q } else { V::all(chain.precompression) + (q.after(before) - q) };
    power.raise(chain.law.positive_part(overlaps))
}

/// What forces `f` of bonds to the left of sites do to these, `f_i - f_{i+1}`, or to strains.
#[inline(always)]
pub(crate) fn push<R: Real, V: Vector<R>, const STRAIN: bool>(before: V, f: V, next: V) -> V {
    if STRAIN { (f - f.after(before)) - (f.before(next) - f) } else { f - f.before(next) }
}

#[cfg(test)]
mod tests {
    use super::super::{Boundary, Field, Params};
    use super::*;
    use hertzchain_integrators::{Instructions, VectorField};

    #[test]
    fn a_pass_is_the_topology_site_by_site() {
        // Truth: overlaps and pushes as `topology` has them, one number at a time, to the bit; all
        // lengths around one register and two, all boundaries, and every way to compute a power.
        let used = Instructions::used();
        for boundary in [Boundary::Free, Boundary::Fixed, Boundary::Ring, Boundary::StrainRing] {
            for (n, alpha) in (1..20).flat_map(|n| [0.5, 1.2, 1.5, 2.0, 3.5, 5.0].map(|alpha| (n, alpha))) {
                let Ok(chain) = Chain::<f64>::new(Params::new(alpha, 0.0, 0.0).unwrap(), boundary, n) else { continue };
                let chain = chain.clone().precompressed(0.1).unwrap_or(chain);
                let y: Vec<f64> = (0..chain.layout().dim()).map(|i| (0.7 * (i * i) as f64).sin()).collect();
                let (topology, law, delta) = (chain.topology(), chain.law(), chain.precompression());
                let force = |b| [law.force(delta + topology.across(b, |i| [y[i]])[0])];
                let want: Vec<f64> = (0..n).map(|i| topology.push(i, force)[0]).collect();
                for set in Instructions::ALL.into_iter().filter(|set| set.select()) {
                    let mut dy = y.clone();
                    Field::new(chain.clone()).eval(0.0, &y, &mut dy);
                    assert_eq!(dy[n..], want, "{boundary:?} {n} {alpha} {set}");
                }
            }
        }
        assert!(used.select());
    }
}
