//! Which sites belong to which part.

use crate::chain::Topology;
use std::ops::Range;

/// Most ghosts on either side of a part. Chosen: with a part of 10^5 sites they are a thousandth of
/// the work, and a message is sent every 64 kicks.
pub const GHOSTS: usize = 64;

/// A chain in parts of nearly the same length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Division {
    topology: Topology,
    parts: usize,
}

impl Division {
    /// So many parts, from one to as many as there are sites.
    pub fn new(topology: Topology, parts: usize) -> Self {
        debug_assert!((1..=topology.sites()).contains(&parts));
        Self { topology, parts }
    }

    /// Number of parts.
    pub fn parts(self) -> usize {
        self.parts
    }

    /// The sites of a part.
    pub fn sites(self, part: usize) -> Range<usize> {
        let start = |part: usize| (self.topology.sites() as u128 * part as u128 / self.parts as u128) as usize;
        start(part)..start(part + 1)
    }

    /// Number of ghosts on a side of a part that has a neighbour there, and so of kicks between two
    /// exchanges: all come from one neighbour, so there are at most as many as the shortest part
    /// has sites. None if the chain is not divided.
    ///
    /// ```
    /// use hertzchain_core::{Boundary, chain::Topology, parts::Division};
    /// let division = Division::new(Topology::new(Boundary::Ring, 50), 7);
    /// assert_eq!((division.sites(0), division.sites(6), division.ghosts()), (0..7, 42..50, 7));
    /// assert_eq!((division.before(0), division.after(0)), (Some(6), Some(1)));
    /// ```
    pub fn ghosts(self) -> usize {
        if self.parts == 1 { 0 } else { GHOSTS.min(self.topology.sites() / self.parts) }
    }

    /// The part before a part.
    pub fn before(self, part: usize) -> Option<usize> {
        match part {
            0 => (self.parts > 1 && self.topology.ring()).then(|| self.parts - 1),
            _ => Some(part - 1),
        }
    }

    /// The part after a part.
    pub fn after(self, part: usize) -> Option<usize> {
        let next = part + 1;
        if next < self.parts { Some(next) } else { (self.parts > 1 && self.topology.ring()).then_some(0) }
    }
}
