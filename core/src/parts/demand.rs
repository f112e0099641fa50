//! What a run in parts will ask for, before anything is allocated.

use super::Division;
use crate::chain::{Boundary, Params, Resonators, Topology};

/// Whole states that part 0 has beside its sites: that of the scene, of the run, and of its record.
const WHOLE_STATES: u64 = 3;
/// Bytes of a number.
const NUMBER: u64 = size_of::<f64>() as u64;

/// Memory and messages of a run in parts, in bytes.
///
/// ```
/// use hertzchain_core::{Boundary, Params, parts::Demand};
/// let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
/// let demand = Demand::new(params, Boundary::Ring, 1_000_000_000, 1024);
/// assert_eq!((demand.sites, demand.ghosts, demand.message), (976_563, 64, 2048));
/// // The sites and the ghosts, with resonators, twice; three whole states.
/// assert_eq!(demand.memory, 2 * 4 * 8 * (976_563 + 128));
/// assert_eq!(demand.whole, 96_000_000_000);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// Sites of the longest part.
    pub sites: u64,
    /// Ghosts on a side where there is a neighbour, and kicks from one exchange to the next.
    pub ghosts: u64,
    /// Memory of a part: the variables of its sites and ghosts, and as much for samples.
    pub memory: u64,
    /// What part 0 holds besides.
    pub whole: u64,
    /// A message to a neighbour: each part sends one to either side in every exchange.
    pub message: u64,
    /// What a sample brings to part 0.
    pub sample: u64,
}

impl Demand {
    /// Of so many sites in so many parts, from one to as many as there are sites.
    pub fn new(params: Params, boundary: Boundary, sites: usize, parts: usize) -> Self {
        let numbers = if params.resonators() == Resonators::Moving { 4 } else { 2 };
        let division = Division::new(Topology::new(boundary, sites), parts);
        let (longest, ghosts) = (sites.div_ceil(parts) as u64, division.ghosts() as u64);
        let state = numbers * NUMBER * sites as u64;
        Self {
            sites: longest,
            ghosts,
            memory: 2 * numbers * NUMBER * (longest + 2 * ghosts),
            whole: WHOLE_STATES * state,
            message: numbers * NUMBER * ghosts,
            sample: state - numbers * NUMBER * division.sites(0).len() as u64,
        }
    }
}
