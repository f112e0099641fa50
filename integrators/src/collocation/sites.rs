//! Sites along their exact linear paths, summed with their rounding errors kept.

use super::system::{ContactChain, Path};
use crate::clock::Twofold;
use std::cell::Cell;

/// `[R0, V, C, S]` of a site as unevaluated sums: `q(t) = R0 + V t + C cos theta + S sin theta`,
/// `theta = omega t` since the start of the run, `t` since the start of the window.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Site {
    pub(crate) hi: Path,
    pub(crate) lo: Path,
}

impl Site {
    /// Adds to one entry; the rounding goes to `lo`.
    #[inline(always)]
    fn add(&mut self, k: usize, value: f64) {
        let sum = self.hi[k] + value;
        let part = sum - self.hi[k];
        let error = (self.hi[k] - (sum - part)) + (value - part);
        self.hi[k] = sum;
        self.lo[k] += error;
    }

    /// Whether it rests at the origin.
    #[inline(always)]
    pub(crate) fn at_rest(&self) -> bool {
        self.hi == [0.0; 4] && self.lo == [0.0; 4]
    }

    /// Moves freely for `h`, with the impulses `path` (in the phase `(sin, cos)`) of a window of
    /// that length.
    #[inline(always)]
    pub(crate) fn advance(&mut self, path: &Path, h: f64, (sin, cos): (f64, f64)) {
        let by = [path[0], path[1], path[2] * cos - path[3] * sin, path[2] * sin + path[3] * cos];
        for k in 0..4 {
            self.add(k, by[k]);
        }
        // V h, its rounding too.
        let by = self.hi[1] * h;
        let rest = self.hi[1].mul_add(h, -by) + self.lo[1] * h;
        self.add(0, by);
        self.lo[0] += rest;
    }

    /// The path over a window that starts in phase `(sin, cos)`.
    #[inline(always)]
    pub(crate) fn path(&self, (sin, cos): (f64, f64)) -> Path {
        let [r, v, c, s] = std::array::from_fn(|k| self.hi[k] + self.lo[k]);
        [r, v, c * cos + s * sin, s * cos - c * sin]
    }
}

/// The path of an overlap over a window of length `h`, and the largest value that its terms may
/// have in it: a shift of the whole chain is in neither.
#[inline(always)]
pub(crate) fn overlap<C: ContactChain>(
    chain: &C,
    sites: &[Site],
    bond: usize,
    (sin, cos): (f64, f64),
    h: f64,
) -> (Path, f64) {
    let hi = chain.across(bond, |i| sites[i].hi);
    let lo = chain.across(bond, |i| sites[i].lo);
    let [r, v, c, s] = [hi[0] + lo[0], hi[1] + lo[1], hi[2] + lo[2], hi[3] + lo[3]];
    let largest = chain.rest() + r.abs() + v.abs() * h + c.abs() + s.abs();
    ([chain.rest() + r, v, c * cos + s * sin, s * cos - c * sin], largest)
}

/// Whether the sites of a bond rest at the origin.
#[inline(always)]
pub(crate) fn at_rest<C: ContactChain>(chain: &C, sites: &[Site], bond: usize) -> bool {
    let resting = Cell::new(true);
    chain.across(bond, |i| {
        resting.set(resting.get() && sites[i].at_rest());
        [0.0; 4]
    });
    resting.get()
}

/// The bonds of a chain as a window begins, for a solver that does not know its type.
pub(crate) trait Bonds: Sync {
    /// Whether the sites of a bond rest at the origin.
    fn at_rest(&self, bond: usize) -> bool;
    /// How a bond moves in a window of length `h` without forces.
    fn free(&self, bond: usize, h: f64) -> Free;
}

/// How a bond moves in a window without forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Free {
    /// The path of its overlap.
    pub(crate) path: Path,
    /// Overlaps up to this are rounding.
    pub(crate) band: f64,
}

/// Sites of a chain in a phase of this sine and cosine.
pub(crate) struct Sites<'a, C> {
    pub(crate) chain: &'a C,
    pub(crate) sites: &'a [Site],
    pub(crate) phase: (f64, f64),
}

impl<C: ContactChain> Bonds for Sites<'_, C> {
    fn at_rest(&self, bond: usize) -> bool {
        at_rest(self.chain, self.sites, bond)
    }

    fn free(&self, bond: usize, h: f64) -> Free {
        let (path, largest) = overlap(self.chain, self.sites, bond, self.phase, h);
        Free { path, band: self.chain.dead_band(largest) }
    }
}

/// The phase `omega t` kept to twice the working precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Phase {
    omega: Twofold<f64>,
    theta: Twofold<f64>,
    two_pi: Twofold<f64>,
}

impl Phase {
    pub(crate) fn new(omega: Twofold<f64>) -> Self {
        Self { omega, theta: Twofold::zero(), two_pi: Twofold::two_pi() }
    }

    pub(crate) fn advance(&mut self, h: f64) {
        self.theta = (self.theta + self.omega * Twofold::new(h)).reduced(self.two_pi);
    }

    pub(crate) fn sin_cos(&self) -> (f64, f64) {
        self.theta.sin_cos()
    }
}
