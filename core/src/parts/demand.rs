//! Memory and messages of a run in parts, computed before anything is allocated.

use super::{Division, Motion};
use crate::chain::{Boundary, Chain, Params, Resonators, Topology};
use hertzchain_integrators::collocation::{Section, Window, WindowOutcome};

/// Number of whole states that part 0 has besides its sites: the initial state, which a scene and
/// its run share, and the state of the record.
const WHOLE_STATES: u64 = 2;
/// Bytes of a number.
const NUMBER: u64 = size_of::<f64>() as u64;

/// Memory and messages of a run in parts, in bytes.
///
/// ```
/// use hertzchain_core::{Boundary, Params, chain::Split, parts::{Estimate, Motion}};
/// let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
/// let kicks = Motion::Kicks(Split::Linear);
/// let demand = Estimate::new(params, Boundary::Ring, 1_000_000_000, 1024, kicks);
/// assert_eq!((demand.sites, demand.ghosts, demand.message), (976_563, 64, 2048));
/// // The sites and the ghosts, with resonators, twice; two whole states.
/// assert_eq!(demand.memory, 2 * 4 * 8 * (976_563 + 128));
/// assert_eq!(demand.whole, 64_000_000_000);
/// // Whole blocks of 256 bonds; 13 of each neighbour, of which seven numbers say what they left.
/// let demand = Estimate::new(params, Boundary::Ring, 1_000_000_000, 1024, Motion::Windows);
/// assert_eq!((demand.sites, demand.ghosts, demand.message), (3815 * 256, 13, 728));
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// Number of sites of the longest part.
    pub sites: u64,
    /// Number of sites, or bonds for contact collocation, that come from each neighbour: see
    /// [`Division::ghosts`].
    pub ghosts: u64,
    /// Bytes that a part holds: all that changes with time of its sites and ghosts, and as much for
    /// samples. The panels of one block, which contact collocation needs too, are not counted.
    pub memory: u64,
    /// Bytes of the whole states that part 0 holds besides.
    pub whole: u64,
    /// Bytes of a message to a neighbour: each part sends one to either side in every exchange.
    pub message: u64,
    /// Bytes of an order to solve a window, and of the answer of each part; zero for kicks.
    pub window: [u64; 2],
    /// Bytes that the other parts send to part 0 for a sample.
    pub sample: u64,
}

impl Estimate {
    /// The demand of `sites` sites in `parts` parts, from one to [`Motion::most_parts`].
    pub fn new(params: Params, boundary: Boundary, sites: usize, parts: usize, motion: Motion) -> Self {
        let numbers = if params.resonators() == Resonators::Moving { 4 } else { 2 };
        let division = Division::new(Topology::new(boundary, sites), parts, motion);
        let ghosts = division.ghosts() as u64;
        let state = numbers * NUMBER * sites as u64;
        let (longest, site, message, window) = match motion {
            Motion::Kicks(_) => (sites.div_ceil(parts), 2 * numbers * NUMBER, numbers * NUMBER * ghosts, [0, 0]),
            Motion::Windows => {
                let longest = (0..parts).map(|part| division.sites(part).len()).max();
                let edge = if parts > 1 { Section::<Chain<f64>>::EDGE_NUMBERS } else { 0 };
                let window = [2 + Window::NUMBERS, WindowOutcome::NUMBERS].map(|count| NUMBER * count as u64);
                (longest.unwrap_or(0), Section::<Chain<f64>>::BYTES as u64, NUMBER * edge as u64, window)
            }
        };
        Self {
            sites: longest as u64,
            ghosts,
            memory: site * (longest as u64 + 2 * ghosts),
            whole: WHOLE_STATES * state,
            message,
            window,
            sample: state - numbers * NUMBER * division.sites(0).len() as u64,
        }
    }
}
