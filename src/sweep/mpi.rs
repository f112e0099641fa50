//! Computation on the ranks of an MPI job.
//!
//! Rank 0 has the grid, the store and the results. It deals points to ranks that have none. It
//! computes points itself too, on other threads than the one that deals. The other ranks compute
//! what they are given. A rank whose points take less than a tenth of a second is given the next
//! ones before it asks, so that it does not wait for rank 0.
//!
//! | message | from, to | content |
//! |---|---|---|
//! | `READY` | rank to 0 | number of its threads |
//! | `POINT` | 0 to rank | number of a point |
//! | `ROW` | rank to 0 | number of the point, microseconds that it took, text of the row |
//! | `END` | 0 to rank | nothing |

use super::{Backend, Done, Task, locked};
use crate::error::{Error, Result};
use mpi::{
    Tag, Threading,
    environment::Universe,
    point_to_point::{MatchedReceiveVec, Message, Status},
    topology::SimpleCommunicator,
    traits::{Communicator, Destination, Source},
};
use std::{
    cell::Cell,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc,
    },
    thread,
    time::{Duration, Instant},
};

const READY: Tag = 1;
const POINT: Tag = 2;
const ROW: Tag = 3;
const END: Tag = 4;
/// Time between two polls for messages. A wait inside MPI would keep a core busy.
const LOOK: Duration = Duration::from_micros(100);
/// A rank whose last point took less than this is given points ahead.
const QUICK: Duration = Duration::from_millis(100);

/// The ranks of the MPI job that this process belongs to.
///
/// Every rank has as many threads as the environment variable `RAYON_NUM_THREADS` says, one without
/// it. The grid must be the same on all ranks. The other ranks end with the first sweep; further
/// ones are computed by rank 0 alone.
pub struct Mpi {
    universe: Universe,
    threads: usize,
    ended: Cell<bool>,
}

/// What rank 0 knows of another rank.
#[derive(Clone, Default)]
struct Rank {
    threads: usize,
    /// Number of points that it was given and whose rows have not arrived.
    given: usize,
    quick: bool,
}

impl Mpi {
    /// Joins the job; a process that `mpirun` has not started is a job of one rank.
    ///
    /// # Errors
    /// An MPI library that does not start beside other threads, or that was started before.
    pub fn new() -> Result<Self> {
        let rule = "an MPI library that can be called from one thread beside others, once a process";
        let universe = match mpi::initialize_with_threading(Threading::Funneled) {
            Some((universe, level)) if level >= Threading::Funneled => universe,
            _ => return Err(Error::parameter("engine", "mpi", rule)),
        };
        let given = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok());
        let threads = given.filter(|threads| *threads > 0).unwrap_or(1);
        // Parallel loops inside a point have the same number of threads. If the process has a pool
        // already, that pool stays.
        drop(rayon::ThreadPoolBuilder::new().num_threads(threads).build_global());
        Ok(Self { universe, threads, ended: Cell::new(false) })
    }

    fn world(&self) -> SimpleCommunicator {
        self.universe.world()
    }

    /// As rank 0, ends the other ranks, once.
    fn end(&self) {
        let world = self.world();
        if world.rank() == 0 && !self.ended.replace(true) {
            (1..world.size()).for_each(|rank| world.process_at_rank(rank).send_with_tag(&[0u8; 0][..], END));
        }
    }

    /// Deals points and computes some, as rank 0.
    fn deal(&self, todo: &[usize], work: Task<'_>, done: Done<'_>) -> Result<()> {
        let world = self.world();
        let (next, failed, failure) = (AtomicUsize::new(0), AtomicBool::new(false), Mutex::new(None));
        let take = || {
            let open = !failed.load(Ordering::Relaxed);
            open.then(|| todo.get(next.fetch_add(1, Ordering::Relaxed)).copied()).flatten()
        };
        let keep = |k: usize, text: String| {
            if let Err(why) = done(k, text) {
                failed.store(true, Ordering::Relaxed);
                locked(&failure).get_or_insert(why);
            }
        };
        let compute = || {
            while let Some(k) = take() {
                keep(k, work(k));
            }
        };
        let mut ranks = vec![Rank::default(); world.size() as usize];
        thread::scope(|scope| {
            let own: Vec<_> = (0..self.threads).map(|_| scope.spawn(compute)).collect();
            // A rank that came late to a sweep before this one, when all its points were dealt, has
            // ended, although its `READY` is first heard now.
            let hear = || if self.ended.get() { None } else { world.any_process().immediate_matched_probe() };
            loop {
                if let Some(message) = hear() {
                    let number = message.1.source_rank();
                    let rank = &mut ranks[number as usize];
                    if let Some((k, text)) = rank.hear(message) {
                        keep(k, text);
                    }
                    while rank.given < rank.threads * if rank.quick { 2 } else { 1 } {
                        let Some(k) = take() else { break };
                        world.process_at_rank(number).send_with_tag(&[k as u64], POINT);
                        rank.given += 1;
                    }
                } else if own.iter().all(|one| one.is_finished()) && ranks.iter().all(|rank| rank.given == 0) {
                    break;
                } else {
                    thread::sleep(LOOK);
                }
            }
        });
        failure.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    /// Computes the points that rank 0 gives, until it sends `END`.
    fn serve(&self, work: Task<'_>) {
        let world = self.world();
        let root = world.process_at_rank(0);
        root.send_with_tag(&[self.threads as u64], READY);
        let (points, queue) = mpsc::channel();
        let (queue, (rows, made)) = (Mutex::new(queue), mpsc::channel());
        let compute = |rows: mpsc::Sender<(usize, Duration, String)>| {
            loop {
                let next = locked(&queue).recv();
                let Ok(k) = next else { break };
                let clock = Instant::now();
                let text = work(k);
                // If rank 0 has ended, nobody waits for the row.
                drop(rows.send((k, clock.elapsed(), text)));
            }
        };
        thread::scope(|scope| {
            for _ in 0..self.threads {
                let rows = rows.clone();
                scope.spawn(move || compute(rows));
            }
            // Dropped on return, which closes the queue and so ends the threads.
            let points = points;
            loop {
                while let Some(message) = root.immediate_matched_probe() {
                    if message.1.tag() == END {
                        message.matched_receive_vec::<u8>();
                        return;
                    }
                    let (numbers, _) = message.matched_receive_vec::<u64>();
                    // The receiver outlives this loop, so that the send succeeds.
                    numbers.iter().for_each(|k| points.send(*k as usize).unwrap_or(()));
                }
                if let Ok((k, time, text)) = made.recv_timeout(LOOK) {
                    let mut message = [k as u64, time.as_micros() as u64].map(u64::to_le_bytes).concat();
                    message.extend(text.into_bytes());
                    root.send_with_tag(&message[..], ROW);
                }
            }
        });
    }
}

impl Rank {
    /// Receives a message of this rank. Returns the number and the row of the point that it brings.
    fn hear(&mut self, message: (Message, Status)) -> Option<(usize, String)> {
        if message.1.tag() == READY {
            self.threads = message.matched_receive_vec::<u64>().0.first().map_or(0, |threads| *threads as usize);
            return None;
        }
        let (bytes, _) = message.matched_receive_vec::<u8>();
        let number = |at: usize| bytes[at..].first_chunk().map_or(0, |number| u64::from_le_bytes(*number));
        self.given -= 1;
        self.quick = number(8) < QUICK.as_micros() as u64;
        Some((number(0) as usize, String::from_utf8_lossy(&bytes[16..]).into_owned()))
    }
}

impl Backend for Mpi {
    fn run(&self, todo: &[usize], work: Task<'_>, done: Done<'_>) -> Result<()> {
        if self.serves() {
            self.serve(work);
            return Ok(());
        }
        let dealt = self.deal(todo, work, done);
        self.end();
        dealt
    }

    fn serves(&self) -> bool {
        self.world().rank() != 0
    }
}

impl Drop for Mpi {
    fn drop(&mut self) {
        self.end();
    }
}
