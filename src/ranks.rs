//! One long chain over the ranks of an MPI job: each rank has one part, see
//! [`parts`].

use crate::{
    error::{Error, Result},
    parts::{self, Ranks, serve},
};
use mpi::{
    Threading,
    environment::Universe,
    point_to_point::send_receive_into,
    topology::SimpleCommunicator,
    traits::{Communicator, Destination, Root, Source},
};
use std::{fmt, sync::Arc};

/// Length in words of the first message of an order: the number of its words, then the words. If
/// they do not fit, a second message has all of them.
const WORDS: usize = 64;

/// Starts MPI for calls from one thread of this process.
///
/// # Errors
/// An MPI library that does not start beside other threads, or that was started before.
pub(crate) fn universe() -> Result<Universe> {
    let rule = "an MPI library that can be called from one thread beside others, once a process";
    match mpi::initialize_with_threading(Threading::Funneled) {
        Some((universe, level)) if level >= Threading::Funneled => Ok(universe),
        _ => Err(Error::parameter("engine", "mpi", rule)),
    }
}

/// The job that this process belongs to; one that `mpirun` has not started is a job of one rank.
///
/// Rank 0 makes the run. The other ranks [`serve`](Self::serve) it and end with it.
pub struct Job(Arc<World>);

struct World {
    universe: Universe,
    /// Threads of this rank.
    threads: usize,
}

impl World {
    fn world(&self) -> SimpleCommunicator {
        self.universe.world()
    }
}

impl Job {
    /// Joins the job. With contact collocation this rank solves its part on `threads` threads.
    ///
    /// # Errors
    /// An MPI library that does not start beside other threads, or that was started before.
    pub fn new(threads: usize) -> Result<Self> {
        universe().map(|universe| Self(Arc::new(World { universe, threads })))
    }

    /// Whether this is not rank 0.
    pub fn serves(&self) -> bool {
        self.0.world().rank() != 0
    }

    /// Integrates the sites that rank 0 assigns, until the job of rank 0 is dropped. Not for rank 0
    /// itself.
    pub fn serve(&self) {
        serve(&mut Messages(self.0.clone()));
    }
}

impl Ranks for Job {
    fn count(&self) -> usize {
        self.0.world().size() as usize
    }

    fn threads(&self) -> usize {
        self.0.threads
    }

    fn carrier(&self) -> Box<dyn parts::Communicator> {
        Box::new(Messages(self.0.clone()))
    }
}

impl fmt::Debug for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a job of {} ranks", self.count())
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        if !self.serves() {
            crate::parts::end(&mut Messages(self.0.clone()));
        }
    }
}

/// Carries numbers between ranks by messages.
struct Messages(Arc<World>);

impl parts::Communicator for Messages {
    fn part(&self) -> usize {
        self.0.world().rank() as usize
    }

    fn parts(&self) -> usize {
        self.0.world().size() as usize
    }

    fn threads(&self) -> usize {
        self.0.threads
    }

    fn broadcast(&mut self, words: &mut Vec<u64>) {
        let world = self.0.world();
        let root = world.process_at_rank(0);
        let mut message = [0; WORDS];
        if world.rank() == 0 {
            message[0] = words.len() as u64;
            message[1..].iter_mut().zip(words.iter()).for_each(|(to, word)| *to = *word);
        }
        root.broadcast_into(&mut message[..]);
        let len = message[0] as usize;
        words.resize(len, 0);
        if len < WORDS {
            words.copy_from_slice(&message[1..=len]);
        } else {
            root.broadcast_into(&mut words[..]);
        }
    }

    fn send(&mut self, to: usize, numbers: &[f64]) {
        self.0.world().process_at_rank(to as i32).send(numbers);
    }

    fn receive(&mut self, from: usize, numbers: &mut [f64]) {
        self.0.world().process_at_rank(from as i32).receive_into(numbers);
    }

    fn pass(&mut self, to: Option<(usize, &[f64])>, from: Option<(usize, &mut [f64])>) {
        let world = self.0.world();
        match (to, from) {
            (Some((to, sent)), Some((from, received))) => {
                let (to, from) = (world.process_at_rank(to as i32), world.process_at_rank(from as i32));
                send_receive_into(sent, &to, received, &from);
            }
            (to, from) => {
                to.into_iter().for_each(|(to, numbers)| self.send(to, numbers));
                from.into_iter().for_each(|(from, numbers)| self.receive(from, numbers));
            }
        }
    }
}
