//! Loops over all bonds: forces from positions, and what modified forces give to sites.

use super::{
    super::{
        ContactLaw, Topology,
        law::{LANES, Lanes},
    },
    PAD, WORD,
};
use hertzchain_integrators::Kernel;

/// Overlaps, forces and derivatives, and which bonds are closed, from positions.
pub struct Forces<'a> {
    pub(super) rest: f64,
    pub(super) law: &'a ContactLaw<f64>,
    pub(super) topology: Topology,
    /// From `PAD` on; the others from the first bond on.
    pub(super) q: &'a mut [f64],
    pub(super) overlap: &'a mut [Lanes<f64>],
    pub(super) force: &'a mut [Lanes<f64>],
    pub(super) slope: &'a mut [Lanes<f64>],
    pub(super) closed: &'a mut [u64],
}

impl Forces<'_> {
    /// Where positions are to be written.
    pub(super) fn positions(&mut self) -> &mut [f64] {
        &mut self.q[PAD..][..self.topology.sites()]
    }

    /// After positions are written.
    #[inline(always)]
    pub(super) fn compute(self) {
        let Self { rest, law, topology, q, overlap, force, slope, closed } = self;
        let last = PAD + topology.sites() - 1;
        (q[PAD - 1], q[last + 1]) = topology.ghosts(q[PAD], q[last]);
        let g = overlap.as_flattened_mut();
        if topology.strains() {
            reversed(&q[PAD..], g);
        } else {
            overlaps(rest, &q[PAD - 1..], &q[PAD..], g);
        }
        law.forces_with_slopes(overlap, force, slope);
        for (closed, overlaps) in closed.iter_mut().zip(overlap.chunks(WORD / LANES)) {
            *closed = 0;
            for (block, g) in overlaps.iter().enumerate() {
                let mut bits = [0; LANES];
                for k in 0..LANES {
                    bits[k] = ((0.0 - g[k]).to_bits() >> (u64::BITS - 1)) << k;
                }
                *closed |= bits.iter().fold(0, |all, bit| all | bit) << (block * LANES);
            }
        }
    }
}

impl Kernel for Forces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.compute();
    }
}

// Loops over slices that are arguments, so that the compiler knows them to be apart.

#[inline(always)]
fn reversed(q: &[f64], g: &mut [f64]) {
    for (g, q) in g.iter_mut().zip(q) {
        *g = -q;
    }
}

#[inline(always)]
fn overlaps(rest: f64, left: &[f64], right: &[f64], g: &mut [f64]) {
    for ((g, left), right) in g.iter_mut().zip(left).zip(right) {
        *g = rest + (left - right);
    }
}

/// Modified forces `F = f + c f' s` of bonds, and what they give to sites.
pub struct Modified<'a> {
    pub(super) c: f64,
    pub(super) topology: Topology,
    /// From `PAD` on, as `spring` and `modified`.
    pub(super) force: &'a [f64],
    pub(super) slope: &'a [f64],
    pub(super) spring: &'a [f64],
    pub(super) modified: &'a mut [f64],
    /// On sites.
    pub(super) push: &'a mut [f64],
}

impl Modified<'_> {
    #[inline(always)]
    pub(super) fn compute(&mut self) {
        let &mut Self { c, topology, force, slope, spring, ref mut modified, ref mut push } = self;
        let (n, strain) = (topology.sites(), topology.strains());
        let f = [&force[PAD - 1..][..n + 1], &force[PAD..][..n + 1], &force[PAD + 1..][..n + 1]];
        let (slope, to) = (&slope[PAD..][..n + 1], &mut modified[PAD..][..n + 1]);
        if spring.is_empty() {
            modify(c, f, slope, to);
        } else {
            modify_with_springs(c, strain, f, slope, [&spring[PAD - 1..][..n + 1], &spring[PAD..][..n + 1]], to);
        }
        if topology.ring() {
            modified[PAD - 1] = modified[PAD + n - 1];
        }
        if strain {
            on_strains([&modified[PAD - 1..], &modified[PAD..], &modified[PAD + 1..]], push);
        } else {
            on_sites([&modified[PAD..], &modified[PAD + 1..]], push);
        }
    }
}

#[inline(always)]
fn modify(c: f64, [f0, f1, f2]: [&[f64]; 3], slope: &[f64], to: &mut [f64]) {
    let n = to.len();
    let (f0, f1, f2, slope) = (&f0[..n], &f1[..n], &f2[..n], &slope[..n]);
    for i in 0..n {
        to[i] = f1[i] + c * slope[i] * ((f0[i] - f1[i]) - (f1[i] - f2[i]));
    }
}

/// The springs of a strain ring act on strains, not on sites.
#[inline(always)]
fn modify_with_springs(
    c: f64,
    strain: bool,
    [f0, f1, f2]: [&[f64]; 3],
    slope: &[f64],
    [p0, p1]: [&[f64]; 2],
    to: &mut [f64],
) {
    let n = to.len();
    let (f0, f1, f2, slope, p0, p1) = (&f0[..n], &f1[..n], &f2[..n], &slope[..n], &p0[..n], &p1[..n]);
    for i in 0..n {
        let across = if strain { -p1[i] } else { p0[i] - p1[i] };
        to[i] = f1[i] + c * slope[i] * (((f0[i] - f1[i]) - (f1[i] - f2[i])) + across);
    }
}

#[inline(always)]
fn on_sites([here, after]: [&[f64]; 2], push: &mut [f64]) {
    for ((push, here), after) in push.iter_mut().zip(here).zip(after) {
        *push = here - after;
    }
}

#[inline(always)]
fn on_strains([before, here, after]: [&[f64]; 3], push: &mut [f64]) {
    for (((push, before), here), after) in push.iter_mut().zip(before).zip(here).zip(after) {
        *push = (here - after) - (before - here);
    }
}

#[inline(always)]
pub(super) fn add(by: f64, push: &[f64], to: &mut [f64]) {
    for (to, push) in to.iter_mut().zip(push) {
        *to += by * push;
    }
}

/// Finds which overlaps turn near zero.
pub(super) struct Turned<'a> {
    pub(super) g: [&'a [f64]; 3],
    pub(super) first: usize,
    pub(super) reach: f64,
    pub(super) out: &'a mut Vec<(usize, bool)>,
}

impl Kernel for Turned<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { g: [g0, g1, g2], first, reach, out } = self;
        let turns = |g0: f64, g1: f64, g2: f64| {
            let (before, after) = (g1 - g0, g2 - g1);
            (before * after < 0.0) & (g1.abs() < reach * (after - before).abs())
        };
        let n = g2.len();
        let (g0, g1) = (&g0[..n], &g1[..n]);
        for start in (0..n).step_by(WORD) {
            let end = (start + WORD).min(n);
            if perhaps(reach, [&g0[start..end], &g1[start..end], &g2[start..end]]) {
                let turned = (start.max(first)..end).filter(|&i| turns(g0[i], g1[i], g2[i]));
                out.extend(turned.map(|i| (i - first, g1[i] > 0.0)));
            }
        }
    }
}

/// Whether any overlap of some may turn, by the signs of both conditions: in vector registers.
#[inline(always)]
fn perhaps(reach: f64, [g0, g1, g2]: [&[f64]; 3]) -> bool {
    let mut signs = 0;
    for ((g0, g1), g2) in g0.iter().zip(g1).zip(g2) {
        let (before, after) = (g1 - g0, g2 - g1);
        signs |= (before * after).to_bits() & (g1.abs() - reach * (after - before).abs()).to_bits();
    }
    signs >> (u64::BITS - 1) == 1
}
