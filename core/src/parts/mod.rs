//! One long chain in parts: threads of one process, or processes that send each other messages.
//!
//! | word | meaning |
//! |---|---|
//! | *part* | neighbouring sites that are moved in one place; the parts make up the chain |
//! | *ghosts* | sites of both neighbours that a part moves as well, see [`Division::ghosts`] |
//! | *carrier* | what takes numbers from part to part; see [`Carrier`] |
//! | *order* | what part 0 tells the others to do next |
//!
//! A kick of a site depends on the site and its two neighbours. So a part that has `g` ghosts on
//! either side can make `g` kicks on its own: where the chain was cut the ghosts are wrong by one
//! more site with each kick, and after `g` kicks all its own sites are still right. Then the parts
//! hand each other the outermost `g` of their own sites, in the variables of the flow, and go on.
//! A message is paid once for many kicks.
//!
//! Windows of contact collocation are solved in blocks of 256 bonds that take 12 bonds of each
//! neighbour along, and need nothing else from them. A part has whole blocks, and the sites of the
//! bonds that these take along. After each window the parts hand each other what 13 bonds at either
//! end have left behind. With it a part moves those sites as well, so that it has them at the start
//! of the next window. Part 0 alone decides which windows are solved, from counts and largest
//! values of all parts: sums of integers and maxima, which do not depend on their order.
//!
//! The bits are those of one process. A kernel does the same operations for a site wherever in an
//! array it is, numbers that are handed over are copied, and phase and time depend on durations
//! alone. Part 0 has the run: it tells the others what to do, has the whole state wherever somebody
//! looks at it, and takes energies from it. A run [`Apart`] has the whole state nowhere: each part
//! keeps that of its own sites, and writes it, and part 0 sees the sites pass by, from the first to
//! the last. So nothing that is computed depends on the number of parts, and no sum has to be
//! brought together.

mod apart;
mod bonds;
mod demand;
mod division;
mod flow;
mod order;
mod own;
mod part;
mod serve;
mod threads;

pub use apart::Apart;
pub use demand::Demand;
pub use division::{Division, GHOSTS};
pub use flow::Parted;
pub use own::{Files, Own};
pub use serve::{end, serve};

use crate::{
    chain::{Split, Topology},
    error::{Error, Result},
};
use hertzchain_integrators::collocation::{BLOCK, EDGE};
use std::{fmt::Debug, sync::Arc};

/// How the sites of a part are moved.
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
            // A part tells its neighbours of as many bonds as it has at least.
            Self::Windows => ((topology.touching().len() + BLOCK - EDGE) / BLOCK).max(1),
        }
    }

    /// Refuses more parts than that, named `name`.
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

/// Takes numbers from one part of a chain to another. Each part has one of its own.
///
/// Numbers between the same two parts arrive in the order in which they were sent.
///
/// # Panics
/// All may panic if a part has ended that must not have.
pub trait Carrier: Send {
    /// Number of this part, from 0.
    fn part(&self) -> usize;
    /// Number of parts.
    fn parts(&self) -> usize;
    /// Most threads on which this part solves blocks of contact collocation.
    fn threads(&self) -> usize {
        1
    }
    /// Gives the words of part 0 to all others, in place of theirs. Every part calls it.
    fn broadcast(&mut self, words: &mut Vec<u64>);
    /// Sends numbers to another part.
    fn send(&mut self, to: usize, numbers: &[f64]);
    /// Receives as many numbers from another part as it has sent.
    fn receive(&mut self, from: usize, numbers: &mut [f64]);
    /// Sends numbers to one part and receives as many from another, whichever comes first.
    fn pass(&mut self, to: Option<(usize, &[f64])>, from: Option<(usize, &mut [f64])>);
}

/// Processes that [`serve`] this one.
pub trait Ranks: Debug + Send + Sync {
    /// Their number, with this process.
    fn count(&self) -> usize;
    /// Threads of this process, see [`Carrier::threads`].
    fn threads(&self) -> usize {
        1
    }
    /// What takes numbers to them and back. For one run at a time.
    fn carrier(&self) -> Box<dyn Carrier>;
}

/// Where the sites of a run are moved.
///
/// ```
/// use hertzchain_core::{Boundary, Chain, Method, Params, Run, State, parts::Parts};
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Ring, 100)?;
/// let mut state = State::rest(&chain);
/// state.u_dot_mut()[0] = 1.0;
/// let run = Run::new(chain, state).until(30.0)?.method(Method::named("verlet")?).step(0.1)?;
/// let [one, three] = [run.clone(), run.in_parts(Parts::Threads(3))?].map(|run| run.start());
/// assert_eq!(one?.state, three?.state);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub enum Parts {
    /// All in the thread that runs.
    #[default]
    Whole,
    /// In so many threads, this one among them.
    Threads(usize),
    /// In this process and those that serve it.
    Ranks(Arc<dyn Ranks>),
    /// In threads or processes, each with the state of its own sites, and none with all.
    Apart(Arc<Apart>),
}

impl Parts {
    /// Number of parts.
    pub fn count(&self) -> usize {
        match self {
            Self::Whole => 1,
            Self::Threads(count) => *count,
            Self::Ranks(ranks) => ranks.count(),
            Self::Apart(apart) => apart.parts().count(),
        }
    }

    /// The parts of a run that no process has as a whole.
    pub fn apart(&self) -> Option<&Arc<Apart>> {
        if let Self::Apart(apart) = self { Some(apart) } else { None }
    }

    /// Processes that serve this one.
    fn ranks(&self) -> Option<&dyn Ranks> {
        match self {
            Self::Ranks(ranks) => Some(&**ranks),
            Self::Apart(apart) => apart.parts().ranks(),
            Self::Whole | Self::Threads(_) => None,
        }
    }

    /// Whether there is nothing to divide.
    pub fn whole(&self) -> bool {
        matches!(self, Self::Whole | Self::Threads(1))
    }

    /// Name of what gives their number.
    fn name(&self) -> &'static str {
        if self.ranks().is_some() { "ranks" } else { "threads" }
    }

    /// Refuses more parts than sites, and none.
    ///
    /// # Errors
    /// A number outside its rule.
    pub fn check(&self, sites: usize) -> Result<()> {
        let count = self.count();
        let threads = self.ranks().map_or(count, Ranks::threads);
        if !(1..=MOST_THREADS).contains(&threads) {
            return Err(Error::parameter("threads", threads, "from 1 to 1024 threads"));
        }
        if count > sites {
            let rule = "a chain has at most as many parts as sites: ask for fewer";
            return Err(Error::parameter(self.name(), count, rule));
        }
        Ok(())
    }

    /// Refuses more parts than a chain has for this motion.
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

    /// The carrier of part 0; threads that are started for it keep their files so.
    fn carrier(&self, files: &Arc<dyn Files>) -> Box<dyn Carrier> {
        match self {
            Self::Whole => threads::start(1, files),
            Self::Threads(count) => threads::start(*count, files),
            Self::Ranks(ranks) => ranks.carrier(),
            Self::Apart(apart) => apart.parts().carrier(files),
        }
    }
}

/// What holds of chains with [`Details`](crate::chain::Details).
pub(crate) const ONE_PART: &str =
    "beads that differ, are damped or driven run in one part: leave threads and ranks out";
/// More than any machine has cores for.
const MOST_THREADS: usize = 1024;
