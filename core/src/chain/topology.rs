//! Which bond joins which sites.
//!
//! | symbol | meaning |
//! |---|---|
//! | bond `n` | lies to the left of site `n`: `g_n = delta_0 + q_{n-1} - q_n`, and `f_n` pushes site `n` forward |
//! | *across* | difference `q_{n-1} - q_n` over a bond, the part of its overlap that varies |
//! | *push* | `f_n - f_{n+1}`, the contact force on a site from the forces in bonds |
//!
//! Sites count from 0. A chain with ends has `n + 1` bonds, of which the outer two join a site to a
//! wall or to nothing; on a ring bond `n` is bond 0. On a strain ring the unknowns are `x_n = u_n -
//! u_{n-1}`, one a bond: the difference over bond `n` is `-x_n`, and the push on `x_n` is that on
//! site `n` minus that on site `n - 1`.

use super::Boundary;
use hertzchain_integrators::Real;
use std::ops::Range;

/// A row of sites with its boundary condition; or rows abreast, one in each lane of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topology {
    boundary: Boundary,
    sites: usize,
}

impl Topology {
    /// A topology of `sites` sites, at least one.
    pub fn new(boundary: Boundary, sites: usize) -> Self {
        Self { boundary, sites }
    }

    /// The boundary condition.
    pub fn boundary(self) -> Boundary {
        self.boundary
    }

    /// Number of sites.
    pub fn sites(self) -> usize {
        self.sites
    }

    /// Whether the last bond and the first share a site.
    pub fn ring(self) -> bool {
        matches!(self.boundary, Boundary::Ring | Boundary::StrainRing)
    }

    /// Whether the unknowns are strains.
    pub fn strains(self) -> bool {
        self.boundary == Boundary::StrainRing
    }

    /// The bonds that can ever touch: an outer one can if it joins a wall.
    pub fn touching(self) -> Range<usize> {
        if self.ring() {
            return 0..self.sites;
        }
        let [left, right] = self.boundary.walls();
        usize::from(!left)..self.sites + usize::from(right)
    }

    /// The first bond that can touch.
    #[inline(always)]
    pub fn first(self) -> usize {
        self.touching().start
    }

    #[inline(always)]
    fn previous(self, n: usize) -> usize {
        (if n == 0 { self.sites } else { n }) - 1
    }

    #[inline(always)]
    fn next(self, n: usize) -> usize {
        if n + 1 == self.sites { 0 } else { n + 1 }
    }

    /// The unknowns on the two sides of a bond: its overlap is the first minus the second. A wall
    /// has no unknown (`None`), and a bond of a strain ring has its own strain as the second.
    #[inline(always)]
    pub fn ends(self, bond: usize) -> [Option<usize>; 2] {
        match self.boundary {
            Boundary::Ring => [Some(self.previous(bond)), Some(bond)],
            Boundary::StrainRing => [None, Some(bond)],
            _ => [bond.checked_sub(1), if bond < self.sites { Some(bond) } else { None }],
        }
    }

    /// The bonds on the two sides of a site that can touch.
    #[inline(always)]
    pub fn bonds(self, site: usize) -> [Option<usize>; 2] {
        if self.ring() {
            return [Some(site), Some(self.next(site))];
        }
        let [left, right] = self.boundary.walls();
        [
            if left || site > 0 { Some(site) } else { None },
            if right || site + 1 < self.sites { Some(site + 1) } else { None },
        ]
    }

    /// The bonds that can touch and share a site with a bond.
    #[inline(always)]
    pub fn beside(self, bond: usize) -> [Option<usize>; 2] {
        if self.ring() {
            return [Some(self.previous(bond)), Some(self.next(bond))];
        }
        let Range { start, end } = self.touching();
        [if bond > start { Some(bond - 1) } else { None }, if bond + 1 < end { Some(bond + 1) } else { None }]
    }

    /// Whether a bond joins a site to a wall.
    #[inline(always)]
    pub fn at_wall(self, bond: usize) -> bool {
        let [left, right] = self.boundary.walls();
        left && bond == 0 || right && bond >= self.sites
    }

    /// Amount by which a unit force in a bond reduces the second derivative of its own overlap: 2
    /// between two sites, 1 at a wall.
    #[inline(always)]
    pub fn mobility(self, bond: usize) -> f64 {
        if self.at_wall(bond) { 1.0 } else { 2.0 }
    }

    /// The differences of quantities over a bond.
    #[inline(always)]
    pub fn across<R: Real, const K: usize>(self, bond: usize, quantity: impl Fn(usize) -> [R; K]) -> [R; K] {
        difference(self.ends(bond), quantity)
    }

    /// The contact force on a site (on a strain, on a strain ring) from the forces in bonds:
    /// [`across`](Self::across) transposed, with the other sign.
    #[inline(always)]
    pub fn push<R: Real, const K: usize>(self, site: usize, force: impl Fn(usize) -> [R; K]) -> [R; K] {
        let push = difference(self.bonds(site), &force);
        if self.strains() { minus(push, difference(self.bonds(self.previous(site)), &force)) } else { push }
    }

    /// The unknowns that a unit force in a bond pushes, each with its weight.
    #[inline(always)]
    pub fn pushed(self, bond: usize) -> Pushed {
        let (none, n) = ((0, 0.0), bond);
        if self.strains() {
            return Pushed { list: [(n, 2.0), (self.next(n), -1.0), (self.previous(n), -1.0)], len: 3 };
        }
        match self.ends(bond) {
            [Some(before), Some(behind)] => Pushed { list: [(before, -1.0), (behind, 1.0), none], len: 2 },
            [Some(before), None] => Pushed { list: [(before, -1.0), none, none], len: 1 },
            [None, Some(behind)] => Pushed { list: [(behind, 1.0), none, none], len: 1 },
            [None, None] => Pushed { list: [none; 3], len: 0 },
        }
    }

    /// Positions beyond the two ends, from those of the first and the last site, for loops over
    /// arrays: with them every overlap is a difference of neighbours. A bond to an infinite
    /// position never touches.
    #[inline(always)]
    pub fn ghosts<R: Real>(self, first: R, last: R) -> (R, R) {
        if self.ring() {
            return (last, first);
        }
        let [left, right] = self.boundary.walls();
        (if left { R::zero() } else { R::neg_infinity() }, if right { R::zero() } else { R::infinity() })
    }
}

/// The unknowns that a force in a bond pushes, each with its weight.
#[derive(Clone, Copy, Debug)]
pub struct Pushed {
    list: [(usize, f64); 3],
    len: usize,
}

impl std::ops::Deref for Pushed {
    type Target = [(usize, f64)];

    #[inline(always)]
    fn deref(&self) -> &[(usize, f64)] {
        &self.list[..self.len]
    }
}

/// The quantity on one side minus that on the other; it is zero on a side without an unknown.
// This is a function, as a closure would not be compiled for the instruction set of the kernel that
// it is in.
#[inline(always)]
fn difference<R: Real, const K: usize>(sides: [Option<usize>; 2], quantity: impl Fn(usize) -> [R; K]) -> [R; K] {
    match sides {
        [Some(before), Some(behind)] => minus(quantity(before), quantity(behind)),
        [Some(before), None] => quantity(before),
        [None, Some(behind)] => minus([R::zero(); K], quantity(behind)),
        [None, None] => [R::zero(); K],
    }
}

#[inline(always)]
fn minus<R: Real, const K: usize>(a: [R; K], b: [R; K]) -> [R; K] {
    let mut out = a;
    for k in 0..K {
        out[k] = a[k] - b[k];
    }
    out
}
