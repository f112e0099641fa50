//! Computation on the threads of this process, or on one thread without the feature `parallel`.

use super::{Backend, Done, Task};
use crate::error::Result;
#[cfg(feature = "parallel")]
use crate::interrupt;
use std::sync::{Mutex, PoisonError};

/// All cores, or as many threads as the environment variable `RAYON_NUM_THREADS` says.
#[derive(Clone, Copy, Debug, Default)]
pub struct Threads;

impl Backend for Threads {
    fn run(&self, todo: &[usize], work: Task<'_>, done: Done<'_>) -> Result<()> {
        #[cfg(not(feature = "parallel"))]
        return InTurn.run(todo, work, done);
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            let token = interrupt::token();
            todo.par_iter().with_max_len(1).try_for_each(|&k| token.within(|| done(k, work(k))))
        }
    }
}

/// One point after the other, in the order of the grid: for points whose own work is divided over
/// the threads.
#[derive(Clone, Copy, Debug, Default)]
pub struct InTurn;

impl Backend for InTurn {
    fn run(&self, todo: &[usize], work: Task<'_>, done: Done<'_>) -> Result<()> {
        todo.iter().try_for_each(|&k| done(k, work(k)))
    }
}

/// The results of `f` for all items, in the order of the items, computed on all cores.
pub fn map<T: Sync, U: Send>(items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
    let results: Vec<_> = items.iter().map(|_| Mutex::new(None)).collect();
    each(items.len(), &|k| *super::locked(&results[k]) = Some(f(&items[k])));
    let filled = results.into_iter().map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner));
    filled.map(|result| result.expect("every item has a result")).collect()
}

/// Calls `work` for all numbers below `count`, on all cores. This is not generic: `rayon` would be
/// compiled again for every closure.
fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    #[cfg(not(feature = "parallel"))]
    (0..count).for_each(work);
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let token = interrupt::token();
        (0..count).into_par_iter().for_each(|k| token.within(|| work(k)));
    }
}

/// Sorts items on all cores; equal items may change their order.
pub(super) fn sort<T: Ord + Send>(items: &mut [T]) {
    #[cfg(not(feature = "parallel"))]
    items.sort_unstable();
    #[cfg(feature = "parallel")]
    rayon::slice::ParallelSliceMut::par_sort_unstable(items);
}

/// Runs `work`, with all its parallel parts, on one thread.
#[cfg(feature = "parallel")]
pub(crate) fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T> {
    use crate::error::Error;
    let refused = |_| Error::parameter("threads", 1, "the system has room for one thread more");
    let (pool, token) = (rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(refused)?, interrupt::token());
    Ok(pool.install(|| token.within(work)))
}

#[cfg(not(feature = "parallel"))]
pub(crate) fn on_one_thread<T>(work: impl FnOnce() -> T) -> Result<T> {
    Ok(work())
}
