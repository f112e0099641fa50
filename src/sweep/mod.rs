//! Grids of independent points: distribution over threads, storage of results, and their order.
//!
//! | word | meaning |
//! |---|---|
//! | *point* | input of an independent computation: parameters, a seed, a method |
//! | *row* | result of a point: a value, or the reason why there is none |
//! | *store* | a file with a line for each computed point; see [`Store`] |
//! | *backend* | threads or other workers that compute points; see [`Backend`] |
//! | *shard* | a part of a grid, for a process of its own; see [`Shard`] |
//! | *engine* | a backend, the folder of the store and the shard; see [`Engine`] |
//!
//! [`map`] is for points in memory whose computations end together. [`Engine::sweep`] is for points
//! that may fail one by one or take long, in runs that may be interrupted and resumed. Results are
//! in the order of the grid, for any order of the work, and the same for any number of threads,
//! shards and processes. A study gives points, a function from a point to its value, and what its
//! values depend on besides; the engine does the rest.

mod engine;
#[cfg(feature = "mpi")]
mod mpi;
mod shard;
mod store;
mod threads;

#[cfg(feature = "mpi")]
pub use self::mpi::Mpi;
pub use engine::{Engine, Grid, Part};
pub use shard::Shard;
pub use store::Store;
pub(crate) use threads::cores;
pub use threads::{Threads, map, start_all};

use crate::{
    error::{Error, Result, require},
    interrupt,
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
};
use store::{Hash, Offset};

/// A digest of a text, of 128 bits in hexadecimal digits.
pub(crate) fn digest(text: &str) -> String {
    let [high, low] = store::hash(text);
    format!("{high:016x}{low:016x}")
}

/// The reason for the missing value of a point that was not begun, or was interrupted.
pub(crate) const STOPPED: &str = "not computed: stopped by a signal";

/// Points that one thread takes at a time, to hash them or to read their rows.
const PIECE: usize = 1 << 9;
/// Most of these pieces in memory at a time.
const PIECES: usize = 1 << 6;
/// Bytes of rows at which those that were read so far are handed out.
const TEXT: usize = 1 << 22;

/// Callback that receives the share that is done, from 0 to 1, and words on what is being done.
pub type Progress<'a> = &'a (dyn Fn(f64, &str) + Sync);

/// A callback for numbers of points, done and all, that tells a [`Progress`].
pub(crate) fn counted(progress: Progress<'_>) -> impl Fn(u64, u64) + Sync {
    move |done, total| progress(done as f64 / total.max(1) as f64, &format!("{done} of {total} points"))
}

/// The result of a point: a value, or the reason why there is none.
pub type Row<U> = std::result::Result<U, String>;

/// Makes the row of the point of this number, as text; see [`Backend`].
pub type Task<'a> = &'a (dyn Fn(usize) -> String + Sync);

/// Makes the rows of a few points at once.
pub type GroupTask<'a> = &'a (dyn Fn(&[usize]) -> Vec<String> + Sync);

/// Takes the number of a point and its row; see [`Backend`].
pub type Done<'a> = &'a (dyn Fn(usize, String) -> Result<()> + Sync);

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
    fn run(&self, todo: &[usize], work: Task<'_>, done: Done<'_>) -> Result<()>;

    /// As [`run`](Self::run), for points that are computed a few at a time where that is possible;
    /// the rows do not depend on that.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    fn run_groups(&self, groups: &[&[usize]], work: GroupTask<'_>, done: Done<'_>) -> Result<()> {
        self.run(&groups.concat(), &|k| work(&[k]).concat(), done)
    }

    /// Whether this process computes points for another one, which has the store and the results:
    /// [`run`](Self::run) then takes points from there, and calls `done` for none.
    fn serves(&self) -> bool {
        false
    }
}

/// Counts finished points, on any thread, and reports the count.
struct Tally<'a> {
    done: AtomicU64,
    total: u64,
    tell: &'a (dyn Fn(u64, u64) + Sync),
}

impl<'a> Tally<'a> {
    /// A count of zero out of `total`; `tell` is called with the count and the total.
    fn new(total: usize, tell: &'a (dyn Fn(u64, u64) + Sync)) -> Self {
        Self { done: AtomicU64::new(0), total: total as u64, tell }
    }

    fn add(&self, count: usize) {
        let count = count as u64;
        (self.tell)(self.done.fetch_add(count, Ordering::Relaxed) + count, self.total);
    }
}

/// The rows of a grid, and their origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept<U> {
    /// A row for each point, in the order of the grid.
    pub rows: Vec<Row<U>>,
    /// Number of rows that were in the store.
    pub resumed: usize,
    /// Numbers of the points whose rows were not in the store, in order.
    pub fresh: Vec<usize>,
    /// Number of points not computed because the process was asked to end; their rows are failures
    /// and are not kept.
    pub missing: usize,
}

impl<U> Swept<U> {
    /// Number of rows that were computed in this call.
    pub fn computed(&self) -> usize {
        self.rows.len() - self.resumed - self.missing
    }

    /// The values, each with its point, of a grid whose points do not fail; those that were
    /// computed before the process was asked to end.
    ///
    /// # Errors
    /// The first failed point, called as `name` says; the process was asked to end before any point
    /// was computed.
    pub fn values<T>(self, points: &[T], name: impl Fn(&T) -> String) -> Result<Vec<(&T, U)>> {
        let mut values = Vec::with_capacity(points.len());
        for (point, row) in points.iter().zip(self.rows) {
            match row {
                Ok(value) => values.push((point, value)),
                Err(_) if self.missing > 0 => {}
                Err(why) => return Err(Error::Point { point: name(point), why }),
            }
        }
        if values.is_empty() && self.missing > 0 {
            return Err(Error::Stopped { kept: "no point was computed".to_owned() });
        }
        Ok(values)
    }

    /// As [`values`](Self::values), without points.
    ///
    /// # Errors
    /// As [`values`](Self::values); the process was asked to end before all points were computed.
    pub fn all<T>(self, points: &[T], name: impl Fn(&T) -> String) -> Result<Vec<U>> {
        if self.missing > 0 {
            return Err(self.stopped());
        }
        Ok(self.values(points, name)?.into_iter().map(|(_, value)| value).collect())
    }

    /// The error of a study that needs the missing rows.
    pub fn stopped(&self) -> Error {
        let (all, done) = (self.rows.len(), self.rows.len() - self.missing);
        Error::Stopped { kept: format!("{done} of {all} points are computed; those in --out are kept") }
    }
}

/// A row as it is stored and sent.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Outcome<U> {
    Value(U),
    Failure(String),
}

/// Reads all rows into memory, in the order of the grid.
fn collected<U: DeserializeOwned + Send>(mut rows: Rows<'_>, fresh: Vec<usize>) -> Result<Swept<U>> {
    rows.settle()?;
    let mut all = Vec::with_capacity(rows.places.len());
    let missing = rows.each(&|_, row| row, &mut |row| {
        all.push(row);
        Ok(())
    })?;
    Ok(Swept { resumed: all.len() - fresh.len(), rows: all, fresh, missing })
}

/// The points of a grid by their number, so that a large grid need not be in memory, and what is
/// done with them.
pub(crate) struct Job<'a> {
    pub(crate) count: usize,
    /// A point as JSON text, which identifies it in the store; see [`key`].
    pub(crate) key: &'a (dyn Fn(usize) -> Result<String> + Sync),
    /// The results of a few points, up to `together` of them, each as a [`text`].
    pub(crate) work: &'a (dyn Fn(&[usize]) -> Vec<String> + Sync),
    pub(crate) together: usize,
    pub(crate) check: Reads<()>,
    pub(crate) progress: &'a (dyn Fn(u64, u64) + Sync),
}

impl Job<'_> {
    /// The hashes of all points, sorted, each with the number of its point. Refuses a point that is
    /// in the grid twice.
    fn hashes(&self) -> Result<Vec<(Hash, usize)>> {
        let mut hashes = Vec::with_capacity(self.count);
        for first in (0..self.count).step_by(PIECES * PIECE) {
            let pieces: Vec<usize> = (first..self.count.min(first + PIECES * PIECE)).step_by(PIECE).collect();
            let hashed = map(&pieces, |&first| {
                let numbers = first..self.count.min(first + PIECE);
                numbers.map(|k| Ok((store::hash(&(self.key)(k)?), k))).collect::<Result<Vec<_>>>()
            });
            hashed.into_iter().try_for_each(|piece| piece.map(|piece| hashes.extend(piece)))?;
        }
        threads::sort(&mut hashes);
        match hashes.windows(2).find(|two| two[0].0 == two[1].0) {
            Some(twice) => Err(Error::parameter("point", (self.key)(twice[0].1)?, "a grid has every point once")),
            None => Ok(hashes),
        }
    }

    /// The rows of points as text; empty if the process was asked to end.
    fn texts(&self, ks: &[usize]) -> Vec<String> {
        let made = attempt(|| (self.work)(ks));
        // A computation that was asked to end may have a part of its result, or a wrong one: what
        // fails on the way is an answer to some.
        if interrupt::asked() {
            return vec![String::new(); ks.len()];
        }
        match made {
            Ok(texts) => texts,
            Err(why) if ks.len() == 1 => vec![failed(&why)],
            // Whose panic it was is seen one by one.
            Err(_) => ks.iter().flat_map(|&k| self.texts(&[k])).collect(),
        }
    }

    /// Computes the points `todo` and keeps their rows. `resumed` is the number of rows that were
    /// in the store.
    fn compute<'s>(&self, rows: Rows<'s>, todo: &[usize], resumed: usize, backend: &dyn Backend) -> Result<Rows<'s>> {
        let tally = Tally::new(resumed + todo.len(), self.progress);
        tally.add(resumed);
        let (left, stopped) = (AtomicU64::new(todo.len() as u64), AtomicBool::new(false));
        let rows = Mutex::new(rows);
        let groups: Vec<&[usize]> = todo.chunks(self.together).collect();
        backend.run_groups(&groups, &|ks| self.texts(ks), &|k, text| {
            if text.is_empty() {
                stopped.store(true, Ordering::Relaxed);
                return Ok(());
            }
            (self.check)(&text).map_err(|_| changed(text.clone()))?;
            locked(&rows).keep(k, &(self.key)(k)?, text)?;
            left.fetch_sub(1, Ordering::Relaxed);
            tally.add(1);
            Ok(())
        })?;
        let whole = left.into_inner() == 0 || stopped.into_inner() || interrupt::asked() || backend.serves();
        require(whole, "rows", "incomplete", "a backend computes every point it is given")?;
        Ok(rows.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The number of a point, and what is kept of it.
type Kept<'a> = (usize, &'a str);

/// The rows of a grid: in a store, or in memory.
pub(crate) struct Rows<'s> {
    store: Option<&'s mut Store>,
    /// The rows as text, without a store.
    texts: Vec<String>,
    /// Where the row of each point is: in the store, or its number in `texts`, counted from 1.
    places: Vec<Option<Offset>>,
}

impl<'s> Rows<'s> {
    /// The rows that the store has. Of these only the first one is read, so that a store of other
    /// values is refused before anything is computed: all have been written by one study.
    fn find(job: &Job<'_>, store: Option<&'s mut Store>) -> Result<Self> {
        let hashes = job.hashes()?;
        let places = store.as_ref().map_or_else(|| vec![None; job.count], |store| store.places(&hashes));
        let rows = Self { store, texts: Vec::new(), places };
        if let Some(k) = rows.places.iter().position(Option::is_some) {
            let mut text = String::new();
            rows.reader()?(k, &mut text)?;
            rows.row(k, &text, job.check)?;
        }
        Ok(rows)
    }

    /// The numbers of the points of a part of the grid that have no row.
    fn missing(&self, part: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.places.len()).filter(|&k| part(k) && self.places[k].is_none()).collect()
    }

    fn keep(&mut self, k: usize, key: &str, text: String) -> Result<()> {
        self.places[k] = match &mut self.store {
            Some(store) => Some(store.append(key, &text)?),
            None => {
                self.texts.push(text);
                Offset::new(self.texts.len() as u64)
            }
        };
        Ok(())
    }

    /// Brings the store into the order of the grid.
    fn settle(&mut self) -> Result<()> {
        self.store.as_mut().map_or(Ok(()), |store| store.settle(&mut self.places))
    }

    /// Calls `make` with every row, on all cores, and `take` with the results in the order of the
    /// grid. Returns the number of missing rows.
    pub(crate) fn each<U: DeserializeOwned, V: Send>(
        &self,
        make: &(dyn Fn(usize, Row<U>) -> V + Sync),
        take: &mut dyn FnMut(V) -> Result<()>,
    ) -> Result<usize> {
        self.texts(&mut |texts| {
            let pieces: Vec<&[Kept<'_>]> = texts.chunks(PIECE).collect();
            let row = |&(k, text): &Kept<'_>| {
                Ok(make(k, self.row(k, text, read)?.unwrap_or_else(|| Err(STOPPED.to_owned()))))
            };
            let made = map(&pieces, |piece| piece.iter().map(row).collect::<Result<Vec<V>>>());
            made.into_iter().try_for_each(|piece| piece?.into_iter().try_for_each(&mut *take))
        })
    }

    /// Calls `take` with what is kept of every point, many at a time. Returns the number of missing
    /// rows.
    fn texts(&self, take: &mut dyn FnMut(&[Kept<'_>]) -> Result<()>) -> Result<usize> {
        let (count, mut read) = (self.places.len(), self.reader()?);
        let (mut text, mut ends) = (String::new(), Vec::new());
        for k in 0..count {
            read(k, &mut text)?;
            ends.push((k, text.len()));
            if text.len() < TEXT && ends.len() < PIECES * PIECE && k + 1 < count {
                continue;
            }
            let mut start = 0;
            let texts: Vec<Kept<'_>> =
                ends.drain(..).map(|(k, end)| (k, &text[std::mem::replace(&mut start, end)..end])).collect();
            take(&texts)?;
            text.clear();
        }
        Ok(self.places.iter().filter(|place| place.is_none()).count())
    }

    /// A function that appends to a text what is kept of a point: its line in the store, or its row
    /// if there is no store.
    fn reader(&self) -> Result<impl FnMut(usize, &mut String) -> Result<()>> {
        let mut lines = self.store.as_ref().map(|store| store.lines()).transpose()?;
        Ok(move |k: usize, text: &mut String| {
            match (self.places[k], &mut lines, &self.store) {
                (Some(place), Some(lines), Some(store)) => {
                    lines.line(place, text).map_err(|source| store.fail(source))?
                }
                (Some(place), ..) => *text += &self.texts[place.get() as usize - 1],
                (None, ..) => {}
            }
            Ok(())
        })
    }

    /// The row of a point, from the text that [`reader`](Self::reader) gives for it.
    fn row<X>(&self, k: usize, text: &str, read: Reads<X>) -> Result<Option<X>> {
        let row = match (self.places[k], &self.store) {
            (None, _) => return Ok(None),
            (Some(place), Some(store)) => store::row(text).and_then(read).map_err(|why| store.corrupt(place, &why)),
            (Some(_), None) => read(text).map_err(changed),
        };
        row.map(Some)
    }
}

fn changed(text: String) -> Error {
    Error::parameter("row", text, "a backend gives back what work made")
}

/// The row of a point, also if its work fails or panics. No work is begun after the process was
/// asked to end.
fn attempt<X>(work: impl FnOnce() -> X) -> Row<X> {
    if interrupt::asked() {
        return Err(STOPPED.to_owned());
    }
    // Unwinding is safe: what points share is read only, and what a point made is dropped.
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| format!("panicked: {}", message(&*panic)))
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// A point as JSON text.
pub(crate) fn key<T: Serialize>(point: &T) -> Result<String> {
    let refused = |why| Error::parameter("point", why, "a point of a grid can be written as JSON");
    serde_json::to_string(point).map_err(refused)
}

/// A row as text that reads back to the same type; a row for which this fails becomes a failed row.
pub(crate) fn text<U: Serialize + DeserializeOwned>(row: Result<U>) -> String {
    let value = match row {
        Ok(value) => value,
        Err(failure) => return failed(&failure.to_string()),
    };
    let tried = serde_json::to_string(&Outcome::Value(value)).map_err(|why| why.to_string());
    let good = tried.and_then(|text| read::<U>(&text).map(|_| text));
    good.unwrap_or_else(|why| failed(&format!("the result cannot be kept: {why}")))
}

/// A failed row as text.
fn failed(why: &str) -> String {
    format!(r#"{{"failure":{}}}"#, serde_json::Value::from(why))
}

/// What reads a row from its text, or refuses the text with a reason.
type Reads<X> = fn(&str) -> std::result::Result<X, String>;

fn read<U: DeserializeOwned>(text: &str) -> std::result::Result<Row<U>, String> {
    match serde_json::from_str(text) {
        Ok(Outcome::Value(value)) => Ok(Ok(value)),
        Ok(Outcome::Failure(failure)) => Ok(Err(failure)),
        Err(why) => Err(why.to_string()),
    }
}

/// Whether a text is a row with such a value.
pub(crate) fn check<U: DeserializeOwned>(text: &str) -> std::result::Result<(), String> {
    read::<U>(text).map(drop)
}

/// Locks a mutex, also after a panic of another thread: its data are consistent between two calls.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
