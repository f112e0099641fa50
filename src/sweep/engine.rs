//! The engine, with which all studies compute their grids.

use super::{Backend, Job, Progress, Rows, Shard, Store, Swept, Threads, check, collected, counted, key, text};
use crate::{
    error::{Error, Result},
    interrupt,
    output::Folder,
};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;
use std::{cell::RefCell, path::PathBuf};

/// Where the points of a study are computed, all of them or a shard, and where their rows are kept.
///
/// A study sweeps one grid, or several in turn. An engine with a shard computes the points of its
/// shard that are not in the store of the whole grid, and keeps their rows in a store of the shard
/// in the same folder. An engine without a shard merges the stores of shards into that of the grid,
/// and computes the missing rows.
///
/// ```
/// use hertzchain::{output::Folder, sweep::{Engine, Grid}};
/// let folder = Folder::create(std::env::temp_dir().join(format!("engine-{}", std::process::id())))?;
/// let grid = Grid { store: "roots.store", study: "roots", settings: serde_json::json!({}) };
/// let roots = |engine: &Engine| engine.sweep(&grid, &[1.0, 4.0, 9.0], &|_, _| (), |x: &f64| Ok(x.sqrt()));
/// let shard = Engine::threads().keeping(&folder).shard("2/3".parse()?);
/// assert!(roots(&shard).unwrap_err().to_string().contains("1 point is kept"));
/// let all = roots(&Engine::threads().keeping(&folder))?;
/// assert_eq!((all.resumed, all.rows), (1, vec![Ok(1.0), Ok(2.0), Ok(3.0)]));
/// # std::fs::remove_dir_all(folder.path()).unwrap();
/// # Ok::<(), hertzchain::Error>(())
/// ```
pub struct Engine {
    backend: Box<dyn Backend>,
    folder: Option<Folder>,
    shard: Option<Shard>,
    /// Result of the shard, once it was swept.
    part: RefCell<Option<Part>>,
}

/// The store of a grid: its name, and what it checks when it is opened.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Name of the file, with the extension `store`.
    pub store: &'static str,
    /// Name of the study.
    pub study: &'static str,
    /// All that values depend on besides the point.
    pub settings: Value,
}

/// Result of a sweep over a shard.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The shard.
    pub shard: Shard,
    /// Number of its points.
    pub points: usize,
    /// Number of these points that have a row, here or in the store of the whole grid.
    pub kept: usize,
    /// Number of rows that this sweep computed.
    pub computed: usize,
    /// Path of the store of the shard.
    pub store: PathBuf,
}

impl Part {
    /// Points and store in words, and what to do next.
    pub fn words(&self) -> String {
        let Self { points, kept, store, .. } = self;
        let are = if *kept == 1 { "1 point is".to_owned() } else { format!("{kept} points are") };
        let next = if kept == points {
            "once all shards have ended, the same command without --shard merges them and shows the results"
        } else {
            "the same command goes on"
        };
        format!("{are} kept of {points}, in {}; {next}", store.display())
    }
}

impl Engine {
    /// The threads of this process, and no store.
    pub fn threads() -> Self {
        Self::new(Box::new(Threads))
    }

    /// Any backend, and no store.
    pub fn new(backend: Box<dyn Backend>) -> Self {
        Self { backend, folder: None, shard: None, part: RefCell::new(None) }
    }

    /// The engine, with a store in a folder.
    #[must_use]
    pub fn keeping(self, folder: &Folder) -> Self {
        Self { folder: Some(folder.clone()), ..self }
    }

    /// The engine, for the points of a shard; it needs a folder.
    #[must_use]
    pub fn shard(self, shard: Shard) -> Self {
        Self { shard: Some(shard), ..self }
    }

    /// The threads of this process, for points that each shard and each rank computes for itself;
    /// with the store, but in a shard.
    pub(crate) fn alone(&self) -> Self {
        Self { folder: self.folder.clone().filter(|_| self.shard.is_none()), ..Self::threads() }
    }

    /// The folder.
    pub fn folder(&self) -> Option<&Folder> {
        self.folder.as_ref()
    }

    /// Whether this process computes points for another one, and has no results.
    pub fn serves(&self) -> bool {
        self.backend.serves()
    }

    /// The shard.
    pub fn its_shard(&self) -> Option<Shard> {
        self.shard
    }

    /// Result of the shard, once it was swept.
    pub fn part(&self) -> Option<Part> {
        self.part.borrow().clone()
    }

    /// Computes the points of a grid that are not in the store, keeps each row as soon as it is
    /// there, and returns the rows in the order of the grid. `progress` is told the share that is
    /// done and how many points that is.
    ///
    /// A point whose work fails or panics gives a failed row with the reason. A failed row is kept
    /// like any other, unless the process was asked to end. A point whose line is removed from the
    /// store is computed again. Values pass through JSON, with or without a store, so that resumed
    /// and new rows are the same; they hold finite numbers only.
    ///
    /// # Errors
    /// A point that is in the grid twice; a store that cannot be written, or whose lines do not
    /// hold such values; a row that the backend changed or left out. An engine with a shard always
    /// returns an error, since it does not have all rows: its result is in the error and in
    /// [`part`](Self::part). A process that computes for another one returns an error too.
    pub fn sweep<T: Serialize + Sync, U: Serialize + DeserializeOwned + Send>(
        &self,
        grid: &Grid,
        points: &[T],
        progress: Progress<'_>,
        work: impl Fn(&T) -> Result<U> + Sync,
    ) -> Result<Swept<U>> {
        let job = Job {
            count: points.len(),
            key: &|k| key(&points[k]),
            work: &|ks| ks.iter().map(|&k| text(work(&points[k]))).collect(),
            together: 1,
            check: check::<U>,
            progress: &counted(progress),
        };
        let mut store = self.open(grid, job.count)?;
        let (rows, fresh) = self.rows(grid, &job, store.as_mut())?;
        collected(rows, fresh)
    }

    /// Computes the points of a grid that need not be in memory. `take` is called with all rows,
    /// which stay in the store. Returns its result, and the number of rows that were in the store
    /// before.
    ///
    /// # Errors
    /// As [`sweep`](Self::sweep); errors of `take`.
    pub(crate) fn each<R>(
        &self,
        grid: &Grid,
        job: &Job<'_>,
        take: impl FnOnce(&mut Rows<'_>) -> Result<R>,
    ) -> Result<(R, usize)> {
        let mut store = self.open(grid, job.count)?;
        let (mut rows, fresh) = self.rows(grid, job, store.as_mut())?;
        rows.settle()?;
        Ok((take(&mut rows)?, job.count - fresh.len()))
    }

    /// Opens the store of the whole grid and merges the stores of shards into it. `None` without a
    /// folder or points, with a shard, and for a process that computes for another one.
    fn open(&self, grid: &Grid, points: usize) -> Result<Option<Store>> {
        // A grid without points leaves no store.
        if points == 0 || self.shard.is_some() || self.backend.serves() {
            return Ok(None);
        }
        let Some(folder) = &self.folder else { return Ok(None) };
        let Grid { store, study, settings } = grid;
        let mut store = Store::open(folder, store, study, settings)?;
        store.merge(study, settings)?;
        Ok(Some(store))
    }

    /// Computes the missing rows. Returns all rows, and the points whose rows were missing.
    fn rows<'s>(&self, grid: &Grid, job: &Job<'_>, store: Option<&'s mut Store>) -> Result<(Rows<'s>, Vec<usize>)> {
        if self.backend.serves() {
            let none = Rows { store: None, texts: Vec::new(), places: Vec::new() };
            job.compute(none, &[], 0, &*self.backend)?;
            let why = "a process that computes for another one has no results of its own".to_owned();
            return Err(Error::Point { point: grid.study.to_owned(), why });
        }
        if let Some(shard) = self.shard {
            return Err(self.part_of(shard.of(job.count)?, grid, job)?);
        }
        let rows = Rows::find(job, store)?;
        let todo = rows.missing(|_| true);
        Ok((job.compute(rows, &todo, job.count - todo.len(), &*self.backend)?, todo))
    }

    /// Computes a shard. Returns the error with its result.
    fn part_of(&self, shard: Shard, grid: &Grid, job: &Job<'_>) -> Result<Error> {
        if interrupt::asked() {
            // The points may be those of a part of a branch: not the shard that was asked for.
            return Err(Error::Stopped { kept: "what this shard had before".to_owned() });
        }
        let Some(folder) = &self.folder else {
            return Err(Error::parameter("shard", shard, "a shard keeps its points in a folder: give the engine one"));
        };
        let Grid { store: name, study, settings } = grid;
        let there = Store::look(folder, name, study, settings)?.map(|mut all| {
            let rows = Rows::find(job, Some(&mut all))?;
            Ok::<_, Error>(rows.places.iter().map(Option::is_some).collect::<Vec<bool>>())
        });
        let there = there.transpose()?;
        let mine = |k: usize| shard.has(k) && !there.as_ref().is_some_and(|there| there[k]);
        let mut store = Store::open(folder, &shard.name(name), study, settings)?;
        let path = store.path();
        let rows = Rows::find(job, Some(&mut store))?;
        let todo = rows.missing(mine);
        let count = (0..job.count).filter(|&k| shard.has(k)).count();
        let resumed = count - todo.len();
        let mut rows = job.compute(rows, &todo, resumed, &*self.backend)?;
        rows.settle()?;
        let left = rows.missing(mine).len();
        let part = Part { shard, points: count, kept: count - left, computed: todo.len() - left, store: path };
        let ended = Error::Point { point: format!("shard {shard}"), why: part.words() };
        *self.part.borrow_mut() = Some(part);
        Ok(ended)
    }
}
