//! One long chain in parts: threads of one process, or processes that send each other messages.
//!
//! | word | meaning |
//! |---|---|
//! | *part* | neighbouring sites that one thread or process integrates; together, the chain |
//! | *ghosts* | sites of both neighbours that a part integrates as well: [`Division::ghosts`] |
//! | *carrier* | sends numbers from part to part; see [`Communicator`] |
//! | *order* | message of part 0 that says what the other parts do next |
//!
//! A kick of a site depends on the site and its two neighbours. So a part with `g` ghosts on either
//! side can make `g` kicks without a message: each kick makes one more ghost wrong, from the cut
//! inwards, and after `g` kicks all sites of the part itself are still right. Then neighbouring
//! parts exchange their outermost `g` sites, in the variables of the flow. So one message serves
//! `g` kicks.
//!
//! Windows of contact collocation are solved in blocks of 256 bonds. A block also works on 12 bonds
//! of each neighbouring block, and needs nothing else from its neighbours. A part has whole blocks,
//! and the sites of those 12 bonds on either side. After each window a part sends its neighbours
//! the results of 13 bonds at either end: the path that the forces of a bond leave behind, and its
//! contact. With them a part advances the sites of its neighbours that it has, so that they are
//! right at the start of the next window. Part 0 alone decides which windows are solved, from sums
//! of integers and from maxima over all parts, which do not depend on the order of the parts.
//!
//! The results have the bits of a run in one process. A kernel does the same operations for a site
//! at any place of an array, messages copy numbers, and phase and time depend on durations alone.
//! Part 0 controls the run: it sends the orders, collects the whole state whenever it is looked at,
//! and computes energies from it. So nothing that is computed depends on the number of
//! parts, and no sums of parts are added up.

mod bonds;
mod demand;
mod division;
mod flow;
mod order;
mod part;
mod serve;
mod threads;

pub use demand::Estimate;
pub use division::{Division, GHOSTS};
pub use flow::Parted;
pub use serve::{end, serve};

use crate::{
    chain::{Split, Topology},
    error::{Error, Result, require},
};
use hertzchain_integrators::collocation::{BLOCK, EDGE};
use std::{fmt::Debug, sync::Arc};

/// How a part integrates its sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// By kicks and drifts on one of the two splits.
    Kicks(Split),
    /// Over windows of contact collocation.
    Windows,
}

impl Motion {
    /// The largest number of parts that a chain has.
    pub fn most_parts(self, topology: Topology) -> usize {
        match self {
            Self::Kicks(_) => topology.sites(),
            // A part has at least EDGE bonds, the number that it sends to each neighbour.
            Self::Windows => ((topology.touching().len() + BLOCK - EDGE) / BLOCK).max(1),
        }
    }

    /// Refuses a count above [`most_parts`](Self::most_parts); the error calls it `name`.
    ///
    /// # Errors
    /// A number outside its rule.
    pub fn check(self, name: &'static str, count: usize, topology: Topology) -> Result<()> {
        let most = self.most_parts(topology);
        if count <= most {
            return Ok(());
        }
        let rule = "a part has at least one site, by collocation one block of 256 bonds: ask for fewer";
        Err(Error::parameter(name, format!("{count} > {most}"), rule))
    }
}

/// Sends numbers from one part of a chain to another. Each part has a carrier of its own.
///
/// Numbers between the same two parts arrive in the order in which they were sent.
///
/// # Panics
/// All methods may panic if another part has ended too early.
pub trait Communicator: Send {
    /// Number of this part, from 0.
    fn part(&self) -> usize;
    /// Number of parts.
    fn parts(&self) -> usize;
    /// Most threads on which this part solves blocks of contact collocation.
    fn threads(&self) -> usize {
        1
    }
    /// Replaces `words` in all other parts by those of part 0. Every part calls it.
    fn broadcast(&mut self, words: &mut Vec<u64>);
    /// Sends numbers to another part.
    fn send(&mut self, to: usize, numbers: &[f64]);
    /// Receives as many numbers from another part as it has sent.
    fn receive(&mut self, from: usize, numbers: &mut [f64]);
    /// Sends numbers to one part and receives as many from another, in either order; `None` leaves
    /// one of the two out.
    fn pass(&mut self, to: Option<(usize, &[f64])>, from: Option<(usize, &mut [f64])>);
}

/// Processes of a job, in which this one is part 0 and the others [`serve`] it.
pub trait Ranks: Debug + Send + Sync {
    /// Number of processes, this one included.
    fn count(&self) -> usize;
    /// Threads of this process, see [`Communicator::threads`].
    fn threads(&self) -> usize {
        1
    }
    /// The carrier of this process. It is for one run at a time.
    fn carrier(&self) -> Box<dyn Communicator>;
}

/// The threads or processes that integrate the sites of a run.
///
/// ```
/// use hertzchain_core::{Boundary, Chain, Method, Params, Run, State, parts::Decomposition};
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Ring, 100)?;
/// let mut state = State::rest(&chain);
/// state.u_dot_mut()[0] = 1.0;
/// let run = Run::new(chain, state).until(30.0)?.method(Method::named("verlet")?).step(0.1)?;
/// let [one, three] = [run.clone(), run.in_parts(Decomposition::Threads(3))?].map(|run| run.start());
/// assert_eq!(one?.state, three?.state);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub enum Decomposition {
    /// One part, in this process.
    #[default]
    Whole,
    /// This number of parts, each in a thread; the calling thread is one of them.
    Threads(usize),
    /// A part in this process and in each process that serves it.
    Ranks(Arc<dyn Ranks>),
}

impl Decomposition {
    /// Number of parts.
    pub fn count(&self) -> usize {
        match self {
            Self::Whole => 1,
            Self::Threads(count) => *count,
            Self::Ranks(ranks) => ranks.count(),
        }
    }

    /// The processes, if the parts are in processes.
    fn ranks(&self) -> Option<&dyn Ranks> {
        match self {
            Self::Ranks(ranks) => Some(&**ranks),
            Self::Whole | Self::Threads(_) => None,
        }
    }

    /// Whether the chain is not divided.
    pub fn whole(&self) -> bool {
        matches!(self, Self::Whole | Self::Threads(1))
    }

    /// Name of the parameter that sets the number of parts, for errors.
    fn name(&self) -> &'static str {
        if self.ranks().is_some() { "ranks" } else { "threads" }
    }

    /// Refuses more parts than sites, and a number of threads outside 1 to 1024: of parts, or of a
    /// rank.
    ///
    /// # Errors
    /// A number outside its rule.
    pub fn check(&self, sites: usize) -> Result<()> {
        let count = self.count();
        let threads = self.ranks().map_or(count, Ranks::threads);
        require((1..=MOST_THREADS).contains(&threads), "threads", threads, "from 1 to 1024 threads")?;
        let rule = "a chain has at most as many parts as sites: ask for fewer";
        require(count <= sites, self.name(), count, rule)?;
        Ok(())
    }

    /// As [`check`](Self::check); also refuses more parts than [`Motion::most_parts`], and several
    /// threads a rank for kicks.
    ///
    /// # Errors
    /// A number outside its rule.
    pub fn check_for(&self, motion: Motion, topology: Topology) -> Result<()> {
        self.check(topology.sites())?;
        if let (Some(ranks), Motion::Kicks(_)) = (self.ranks(), motion)
            && ranks.threads() > 1
        {
            let rule = "by a splitting scheme a rank moves its part on one thread: take more ranks";
            return Err(Error::parameter("threads", ranks.threads(), rule));
        }
        motion.check(self.name(), self.count(), topology)
    }

    /// The carrier of part 0.
    fn carrier(&self) -> Box<dyn Communicator> {
        match self {
            Self::Whole => threads::start(1),
            Self::Threads(count) => threads::start(*count),
            Self::Ranks(ranks) => ranks.carrier(),
        }
    }
}

/// The rule for chains with [`Details`](crate::chain::Details), for errors.
pub(crate) const ONE_PART: &str =
    "beads that differ, are damped or driven run in one part: leave --threads and ranks out";
/// Most threads. Chosen: more than any machine has cores for.
const MOST_THREADS: usize = 1024;
