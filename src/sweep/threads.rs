//! Computation on the threads of this process.

use super::{Backend, Done, GroupTask, Task};
use crate::{
    error::Result,
    interrupt,
    run::{self, Run, Trajectory},
};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// All cores, or as many threads as the environment variable `RAYON_NUM_THREADS` says.
#[derive(Clone, Copy, Debug, Default)]
pub struct Threads;

impl Backend for Threads {
    fn run(&self, todo: &[usize], work: Task<'_>, done: Done<'_>) -> Result<()> {
        let groups: Vec<&[usize]> = todo.chunks(1).collect();
        self.run_groups(&groups, &|ks| ks.iter().map(|&k| work(k)).collect(), done)
    }

    fn run_groups(&self, groups: &[&[usize]], work: GroupTask<'_>, done: Done<'_>) -> Result<()> {
        let group = |ks: &&[usize]| ks.iter().zip(work(ks)).try_for_each(|(&k, text)| done(k, text));
        let token = interrupt::token();
        groups.par_iter().with_max_len(1).try_for_each(|ks| token.within(|| group(ks)))
    }
}

/// The results of `f` for all items, in the order of the items, computed on all cores.
pub fn map<T: Sync, U: Send>(items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
    let results: Vec<_> = items.iter().map(|_| Mutex::new(None)).collect();
    each(items.len(), &|k| *super::locked(&results[k]) = Some(f(&items[k])));
    let filled = results.into_iter().map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner));
    filled.map(|result| result.expect("every item has a result")).collect()
}

/// Starts runs on all cores; each result is that of [`Run::start`], with the same bits. `seen` is
/// called, on any thread, with the number of a run, the time of each of its samples and the state
/// there. Runs that are alike are made side by side, see [`run::start_all`].
pub fn start_all(runs: &[Run], seen: &(dyn Fn(usize, f64, &[f64]) + Sync)) -> Vec<Result<Trajectory>> {
    // A lane for each run, but no core without a run.
    let mut first = 0;
    let groups = run::groups(runs, runs.len().div_ceil(cores()).max(1)).into_iter().map(|group| {
        first += group.len();
        (first - group.len(), group)
    });
    let ends =
        map(&groups.collect::<Vec<_>>(), |&(first, group)| run::start_all(group, &mut |k, t, y| seen(first + k, t, y)));
    ends.into_iter().flatten().collect()
}

/// Number of threads.
pub(crate) fn cores() -> usize {
    rayon::current_num_threads()
}

/// Calls `work` for all numbers below `count`, on all cores. This is not generic: `rayon` would be
/// compiled again for every closure.
fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    let token = interrupt::token();
    (0..count).into_par_iter().for_each(|k| token.within(|| work(k)));
}

/// Sorts items on all cores; equal items may change their order.
pub(super) fn sort<T: Ord + Send>(items: &mut [T]) {
    items.par_sort_unstable();
}
