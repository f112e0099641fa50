//! Grids of independent points: distribution over threads, storage of results, and their order.
//!
//! | word | meaning |
//! |---|---|
//! | *point* | input of an independent computation: parameters, a seed, a method |
//! | *row* | result of a point: a value, or the reason why there is none |
//! | *store* | a file with a line for each computed point; see [`Store`] |
//! | *backend* | threads or other workers that compute points; see [`Backend`] |
//!
//! [`map`] is for points in memory whose computations end together. [`sweep`] is for points that
//! may fail one by one or take long, in runs that may be interrupted and resumed. Results are in
//! the order of the grid, for any order of the work, and the same for any number of threads.

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

/// The reason for the missing value of a point that was not begun, or was interrupted.
pub(crate) const STOPPED: &str = "not computed: stopped by a signal";

/// The result of a point: a value, or the reason why there is none.
pub type Row<U> = std::result::Result<U, String>;

/// Computes points.
///
/// The input is the number of a point in the grid and the output is text, so a worker may be
/// another process that has the same grid.
pub trait Backend {
    /// Calls `done(k, work(k))` once for every `k` of `todo`, in any order, as soon as `work(k)`
    /// has returned.
    ///
    /// `done` is called in this process; `work` may run anywhere.
    ///
    /// # Errors
    /// The first error of `done`; then the backend stops as soon as it can.
    fn run(
        &self,
        todo: &[usize],
        work: &(dyn Fn(usize) -> String + Sync),
        done: &(dyn Fn(usize, String) -> Result<()> + Sync),
    ) -> Result<()>;
}

/// Counts finished points, on any thread, and reports the count.
pub struct Tally<'a> {
    done: AtomicU64,
    total: u64,
    tell: &'a (dyn Fn(u64, u64) + Sync),
}

impl<'a> Tally<'a> {
    /// A count of zero out of `total`; `tell` is called with the count and the total.
    pub fn new(total: usize, tell: &'a (dyn Fn(u64, u64) + Sync)) -> Self {
        Self { done: AtomicU64::new(0), total: total as u64, tell }
    }

    /// Counts one more point.
    pub fn tick(&self) {
        self.add(1);
    }

    fn add(&self, count: usize) {
        let count = count as u64;
        (self.tell)(self.done.fetch_add(count, Ordering::Relaxed) + count, self.total);
    }

    /// [`map`] that counts each item.
    pub fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        map(items, |item| {
            let result = f(item);
            self.tick();
            result
        })
    }
}

/// The rows of a grid, and their origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept<U> {
    /// A row for each point, in the order of the grid.
    pub rows: Vec<Row<U>>,
    /// Number of rows that were in the store.
    pub resumed: usize,
    /// Number of points not computed because the process was asked to end; their rows are failures
    /// and are not kept.
    pub missing: usize,
}

impl<U> Swept<U> {
    /// Number of rows that were computed in this call.
    pub fn computed(&self) -> usize {
        self.rows.len() - self.resumed - self.missing
    }
}

/// A row as it is stored and sent.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kept<U> {
    Value(U),
    Failure(String),
}

/// Computes the points of a grid that are not in the store, keeps each row as soon as it is there,
/// and returns the rows in the order of the grid.
///
/// A point whose work fails or panics gives a failed row with the reason. A failed row is kept like
/// any other, unless the process was asked to end; without its line in the store the point is
/// computed again. Values pass through JSON, with or without a store, so that resumed and new rows
/// are the same; they hold finite numbers only.
///
/// ```
/// use hertzchain::sweep::{Threads, sweep};
/// let halves = sweep(&[1.0, 4.0, 9.0], None, &Threads, &|_, _| (), |x: &f64| Ok(x.sqrt()))?;
/// assert_eq!(halves.rows, [Ok(1.0), Ok(2.0), Ok(3.0)]);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A point that is in the grid twice; a store that cannot be written, or whose lines do not hold
/// such values; a row that the backend changed or left out.
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
        // An interrupted computation has no result.
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

/// The points as JSON text, which identifies them in the store.
fn keys<T: Serialize>(points: &[T]) -> Result<Vec<String>> {
    let refused = |why: serde_json::Error| Error::parameter("point", why, "a point of a grid can be written as JSON");
    let keys = points.iter().map(|point| serde_json::to_string(point).map_err(refused)).collect::<Result<Vec<_>>>()?;
    let mut known = HashSet::new();
    match keys.iter().find(|key| !known.insert(*key)) {
        Some(twice) => Err(Error::parameter("point", twice, "a grid has every point once")),
        None => Ok(keys),
    }
}

/// The row of a point, also if its work fails or panics. No work is begun after the process was
/// asked to end.
fn attempt<U>(work: impl FnOnce() -> Result<U>) -> Row<U> {
    if interrupt::asked() {
        return Err(STOPPED.to_owned());
    }
    // Unwinding is safe: what points share is read only, and what a point made is dropped.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.map_err(|error| error.to_string()),
        Err(panic) => Err(format!("panicked: {}", message(&*panic))),
    }
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// A row as text that reads back to the same type; a row for which this fails becomes a failed row.
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

/// Locks a mutex, also after a panic of another thread: its data are consistent between two calls.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
