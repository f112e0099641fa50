//! Grids of independent points: the one place that hands them out, keeps what was computed and brings results into order.
//!
//! | word | meaning |
//! |---|---|
//! | *point* | where something is computed that asks no other point: parameters, a seed, a method |
//! | *row* | what came of a point: a value, or why there is none |
//! | *store* | a file with a line for every point that was computed; see [`Store`] |
//! | *backend* | who computes: the threads of this process, or whoever takes numbers and gives back text; see [`Backend`] |
//!
//! [`map`] is for points that live in memory and end together; [`sweep`] for those that may fail one by one, take long, are killed and go on.
//! Results are in the order of the grid, whatever the order of the work, and the same for any number of threads.

mod store;
mod threads;

pub use store::Store;
pub(crate) use threads::on_one_thread;
pub use threads::{Threads, map};

use crate::{
    error::{Error, Result},
    interrupt,
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::{
    any::Any,
    collections::HashSet,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

/// Why there is no value of a point that was not begun, or broken off.
const STOPPED: &str = "not computed: stopped by a signal";

/// What came of a point: a value, or why there is none.
pub type Row<U> = std::result::Result<U, String>;

/// Who computes points.
///
/// Points go out as their numbers in the grid and come back as text: a worker may be another process that has the same grid.
pub trait Backend {
    /// Calls `done(k, work(k))` for every `k` of `todo`, once, in any order, as soon as `work(k)` is there; `done` in this process, `work` anywhere.
    ///
    /// # Errors
    /// The first of `done`, and then as little more as can be.
    fn run(
        &self,
        todo: &[usize],
        work: &(dyn Fn(usize) -> String + Sync),
        done: &(dyn Fn(usize, String) -> Result<()> + Sync),
    ) -> Result<()>;
}

/// Counts what is done, on any thread, and tells it.
pub struct Tally<'a> {
    done: AtomicU64,
    total: u64,
    tell: &'a (dyn Fn(u64, u64) + Sync),
}

impl<'a> Tally<'a> {
    /// Nothing of `total` is done; `tell` hears how many of how many.
    pub fn new(total: usize, tell: &'a (dyn Fn(u64, u64) + Sync)) -> Self {
        Self { done: AtomicU64::new(0), total: total as u64, tell }
    }

    /// One more is done.
    pub fn tick(&self) {
        self.add(1);
    }

    fn add(&self, count: usize) {
        let count = count as u64;
        (self.tell)(self.done.fetch_add(count, Ordering::Relaxed) + count, self.total);
    }

    /// [`map`], counted.
    pub fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        map(items, |item| {
            let result = f(item);
            self.tick();
            result
        })
    }
}

/// The rows of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept<U> {
    /// A row for each point, in the order of the grid.
    pub rows: Vec<Row<U>>,
    /// How many of them were in the store.
    pub resumed: usize,
    /// How many were not computed, since the process was asked to end: failed rows that are not kept.
    pub missing: usize,
}

impl<U> Swept<U> {
    /// How many were computed now.
    pub fn computed(&self) -> usize {
        self.rows.len() - self.resumed - self.missing
    }
}

/// A row as it is kept and as it travels.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kept<U> {
    Value(U),
    Failure(String),
}

/// Computes every point of a grid that is not in the store, keeps each as soon as it is there, and gives the rows in the order of the grid.
///
/// A point whose work fails or panics is a failed row with the reason; the others go on. A failed row is kept like any other: take its line out of
/// the store, and it is computed again. Values travel as JSON, in the store or not, so that a row is the same whether it was resumed or not: they hold no
/// number that is not finite.
///
/// ```
/// use hertzchain::sweep::{Threads, sweep};
/// let halves = sweep(&[1.0, 4.0, 9.0], None, &Threads, &|_, _| (), |x: &f64| Ok(x.sqrt()))?;
/// assert_eq!(halves.rows, [Ok(1.0), Ok(2.0), Ok(3.0)]);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A point that is twice in the grid; a store that cannot be written, or whose lines do not hold such values.
pub fn sweep<T, U>(
    points: &[T],
    store: Option<&mut Store>,
    backend: &dyn Backend,
    progress: &(dyn Fn(u64, u64) + Sync),
    work: impl Fn(&T) -> Result<U> + Sync,
) -> Result<Swept<U>>
where
    T: Serialize + Sync,
    U: Serialize + DeserializeOwned + Send,
{
    let keys = keys(points)?;
    let mut rows = Vec::with_capacity(points.len());
    for key in &keys {
        let kept = store.as_ref().and_then(|store| Some((store, store.get(key)?)));
        rows.push(kept.map(|(store, row)| read(row).map_err(|why| store.corrupt(key, &why))).transpose()?);
    }
    let todo: Vec<usize> = (0..points.len()).filter(|&k| rows[k].is_none()).collect();
    let resumed = points.len() - todo.len();
    let tally = Tally::new(points.len(), progress);
    tally.add(resumed);

    let compute = |k: usize| text(attempt(|| work(&points[k])));
    let state = Mutex::new((rows, store));
    backend.run(&todo, &compute, &|k, text| {
        let row: Row<U> =
            read(&text).map_err(|_| Error::parameter("row", &text, "a backend gives back what work made"))?;
        // What was broken off is no result.
        if row.is_err() && interrupt::asked() {
            return Ok(());
        }
        let (rows, store) = &mut *locked(&state);
        if let Some(store) = store {
            store.append(&keys[k], text)?;
        }
        rows[k] = Some(row);
        tally.tick();
        Ok(())
    })?;
    let (rows, store) = state.into_inner().unwrap_or_else(PoisonError::into_inner);
    let missing = rows.iter().filter(|row| row.is_none()).count();
    if missing > 0 && !interrupt::asked() {
        return Err(Error::parameter("rows", "incomplete", "a backend computes every point it is given"));
    }
    let rows = rows.into_iter().map(|row| row.unwrap_or_else(|| Err(STOPPED.to_owned()))).collect();
    if let Some(store) = store {
        store.settle(&keys)?;
    }
    Ok(Swept { rows, resumed, missing })
}

/// Points as text, by which the store knows them.
fn keys<T: Serialize>(points: &[T]) -> Result<Vec<String>> {
    let refused = |why: serde_json::Error| Error::parameter("point", why, "a point of a grid can be written as JSON");
    let keys = points.iter().map(|point| serde_json::to_string(point).map_err(refused)).collect::<Result<Vec<_>>>()?;
    let mut known = HashSet::new();
    match keys.iter().find(|key| !known.insert(*key)) {
        Some(twice) => Err(Error::parameter("point", twice, "a grid has every point once")),
        None => Ok(keys),
    }
}

/// The row of a point, whatever its work does. None is begun once the process was asked to end.
fn attempt<U>(work: impl FnOnce() -> Result<U>) -> Row<U> {
    if interrupt::asked() {
        return Err(STOPPED.to_owned());
    }
    // Nothing that a point has begun outlives its panic: all it shares with others is read only.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.map_err(|error| error.to_string()),
        Err(panic) => Err(format!("panicked: {}", message(&*panic))),
    }
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// A row as text that reads back; one that does not is a failed row.
fn text<U: Serialize + DeserializeOwned>(row: Row<U>) -> String {
    let kept = match row {
        Ok(value) => Kept::Value(value),
        Err(failure) => Kept::Failure(failure),
    };
    let tried = serde_json::to_string(&kept).map_err(|why| why.to_string());
    let good = tried.and_then(|text| read::<U>(&text).map(|_| text));
    good.unwrap_or_else(|why| {
        let failure = serde_json::Value::from(format!("the result cannot be kept: {why}"));
        format!(r#"{{"failure":{failure}}}"#)
    })
}

fn read<U: DeserializeOwned>(text: &str) -> std::result::Result<Row<U>, String> {
    match serde_json::from_str(text) {
        Ok(Kept::Value(value)) => Ok(Ok(value)),
        Ok(Kept::Failure(failure)) => Ok(Err(failure)),
        Err(why) => Err(why.to_string()),
    }
}

/// A lock that a panic elsewhere does not take from us: what it guards is whole between two calls.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
