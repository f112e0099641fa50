//! Which sites belong to which part.

use super::Motion;
use crate::chain::Topology;
use hertzchain_integrators::collocation::{BLOCK, EDGE};
use std::ops::Range;

/// Most ghosts on either side of a part that is integrated by kicks. Chosen: with a part of 10^5
/// sites they are a thousandth of the work, and a message is sent every 64 kicks.
pub const GHOSTS: usize = 64;

/// A chain in parts of nearly the same length.
///
/// For kicks a part may begin at any site. For contact collocation a part has whole blocks of
/// bonds, see [`BLOCK`]; a last block of less than [`EDGE`] bonds belongs to the part of the block
/// before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Division {
    topology: Topology,
    parts: usize,
    motion: Motion,
}

impl Division {
    /// A division into `parts` parts, from one to [`Motion::most_parts`].
    pub fn new(topology: Topology, parts: usize, motion: Motion) -> Self {
        debug_assert!((1..=motion.most_parts(topology)).contains(&parts));
        Self { topology, parts, motion }
    }

    /// Number of parts.
    pub fn parts(self) -> usize {
        self.parts
    }

    /// Where a part begins, in sites or bonds, if units of `length` of them are shared out evenly:
    /// single sites for kicks, blocks of bonds for collocation.
    fn start(self, part: usize, length: usize) -> usize {
        let units = self.motion.most_parts(self.topology) as u128;
        length * (units * part as u128 / self.parts as u128) as usize
    }

    /// The sites of a part.
    pub fn sites(self, part: usize) -> Range<usize> {
        let start = |part: usize| match (part, self.motion) {
            (0, _) => 0,
            _ if part == self.parts => self.topology.sites(),
            (_, Motion::Kicks(_)) => self.start(part, 1),
            (_, Motion::Windows) => self.bonds(part).start,
        };
        start(part)..start(part + 1)
    }

    /// The bonds of a part for contact collocation: each is in the part of the site to its right,
    /// if it has one. The outermost bonds of a free chain belong to no part.
    pub fn bonds(self, part: usize) -> Range<usize> {
        let Range { start, end } = self.topology.touching();
        let last = part + 1 == self.parts;
        start + self.start(part, BLOCK)..if last { end } else { start + self.start(part + 1, BLOCK) }
    }

    /// The sites whose states a part must be given at its start. On a ring the numbers go on beyond
    /// that of the last site. For kicks these are its own sites, as ghosts come from the
    /// neighbours. For contact collocation they are the sites of all bonds that its blocks work on.
    pub fn held(self, part: usize) -> Range<usize> {
        let (n, topology) = (self.topology.sites(), self.topology);
        if self.parts == 1 || self.motion != Motion::Windows {
            return self.sites(part);
        }
        let Range { start, end } = self.bonds(part);
        let around = if topology.ring() { n } else { 0 };
        // EDGE bonds follow the last own one. A chain with walls has one bond more than sites, a
        // strain ring has as many.
        let behind = if topology.strains() { EDGE } else { EDGE - 1 };
        let first = self.before(part).map_or(0, |_| start + around - EDGE);
        first..self.after(part).map_or(n, |_| end + around + behind)
    }

    /// Number of sites (kicks) or bonds (collocation) that a part receives from each neighbour in
    /// an exchange. For kicks it is also the number of kicks from one exchange to the next. All
    /// come from one neighbour, so there are at most as many as the shortest part has. Zero if the
    /// chain is not divided.
    ///
    /// ```
    /// use hertzchain_core::{Boundary, chain::{Split, Topology}, parts::{Division, Motion}};
    /// let topology = Topology::new(Boundary::Ring, 50);
    /// let division = Division::new(topology, 7, Motion::Kicks(Split::Kinetic));
    /// assert_eq!((division.sites(0), division.sites(6), division.ghosts()), (0..7, 42..50, 7));
    /// assert_eq!((division.before(0), division.after(0)), (Some(6), Some(1)));
    /// // Blocks of 256 bonds, of which the last has 188.
    /// let topology = Topology::new(Boundary::Ring, 700);
    /// let division = Division::new(topology, 2, Motion::Windows);
    /// assert_eq!([division.sites(0), division.sites(1)], [0..256, 256..700]);
    /// assert_eq!(division.ghosts(), 13);
    /// ```
    pub fn ghosts(self) -> usize {
        match self.motion {
            _ if self.parts == 1 => 0,
            Motion::Kicks(_) => GHOSTS.min(self.topology.sites() / self.parts),
            Motion::Windows => EDGE,
        }
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
