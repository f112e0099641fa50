//! Grids of independent points: order, failures, and a store of a run that is killed, resumed or
//! damaged.

use hertzchain::{
    Error, Result,
    output::Folder,
    sweep::{Backend, Engine, Grid, Progress, Store, Swept, Threads, map},
};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::{
    fs,
    path::Path,
    sync::atomic::{AtomicU64, AtomicUsize, Ordering},
    time::{Duration, Instant},
};

#[derive(Clone, Copy, Debug, Serialize, PartialEq)]
struct Point {
    k: u32,
    x: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
struct Root {
    root: f64,
    above: Option<f64>,
}

/// Points with numbers that need all their digits.
fn grid(points: u32) -> Vec<Point> {
    (0..points).map(|k| Point { k, x: 1.0 / f64::from(3 + 7 * k) }).collect()
}

fn root(point: &Point) -> Result<Root> {
    let root = point.x.sqrt();
    Ok(Root { root, above: (root > 0.3).then_some(root * 1e-300) })
}

/// A backend that computes backwards on one thread and ends after the given number of points;
/// results pass through text.
struct Backwards(usize);

impl Backend for Backwards {
    fn run(
        &self,
        todo: &[usize],
        work: &(dyn Fn(usize) -> String + Sync),
        done: &(dyn Fn(usize, String) -> Result<()> + Sync),
    ) -> Result<()> {
        todo.iter().rev().take(self.0).try_for_each(|&k| done(k, work(k)))
    }
}

const ALL: usize = usize::MAX;

fn settings() -> Value {
    json!({"alpha": 1.5, "rule": "energy", "tolerance": 1e-9})
}

fn open(folder: &Path) -> Result<Store> {
    Store::open(&Folder::create(folder).unwrap(), "roots.store", "roots", &settings())
}

/// The rows of the grid through a store in the folder, and the number of points computed.
fn stored(folder: &Path, points: &[Point], backend: impl Backend + 'static) -> Result<(Swept<Root>, usize)> {
    let computed = AtomicUsize::new(0);
    let engine = Engine::new(Box::new(backend)).keeping(&Folder::create(folder).unwrap());
    let swept = engine.sweep(&roots(), points, SILENT, |point| {
        computed.fetch_add(1, Ordering::Relaxed);
        root(point)
    })?;
    Ok((swept, computed.into_inner()))
}

const SILENT: Progress<'_> = &|_, _| ();

fn bytes(folder: &Path) -> Vec<u8> {
    fs::read(folder.join("roots.store")).unwrap()
}

fn refusal(folder: &Path) -> String {
    open(folder).unwrap_err().to_string()
}

#[test]
fn rows_are_in_the_order_of_the_grid_whoever_works_in_whatever_order() {
    let points = grid(40);
    let expected: Vec<_> = points.iter().map(|point| Ok(root(point).unwrap())).collect();
    for backend in [Box::new(Threads) as Box<dyn Backend>, Box::new(Backwards(ALL))] {
        let swept = Engine::new(backend).sweep(&roots(), &points, SILENT, root).unwrap();
        assert_eq!(swept.rows, expected);
        assert_eq!((swept.resumed, swept.computed()), (0, 40));
    }
    assert_eq!(map(&points, |point| Ok(root(point).unwrap())), expected);
    let incomplete = Engine::new(Box::new(Backwards(7))).sweep(&roots(), &points, SILENT, root);
    let incomplete = incomplete.unwrap_err().to_string();
    assert!(incomplete.contains("a backend computes every point"), "{incomplete}");
}

#[test]
fn a_point_that_fails_or_panics_is_a_failed_row_and_the_others_go_on() {
    let points = grid(5);
    let work = |point: &Point| match point.k {
        1 => Err(Error::parameter("x", point.x, "not this one")),
        2 => panic!("point {} is a bug", point.k),
        // JSON has no form for this number.
        3 => Ok(Root { root: f64::NAN, above: None }),
        _ => root(point),
    };
    let folder = tempfile::tempdir().unwrap();
    for resumed in [0, 5] {
        let swept = engine(folder.path()).sweep(&roots(), &points, SILENT, work).unwrap();
        assert_eq!(swept.resumed, resumed);
        let why = |k: usize| swept.rows[k].as_ref().unwrap_err().as_str();
        assert!(why(1).starts_with("x = 0.1 is not valid"), "{}", why(1));
        assert_eq!(why(2), "panicked: point 2 is a bug");
        assert!(why(3).starts_with("the result cannot be kept"), "{}", why(3));
        assert_eq!([&swept.rows[0], &swept.rows[4]], [0, 4].map(|k: usize| Ok(root(&points[k]).unwrap())).each_ref());
    }
}

#[test]
fn progress_begins_with_what_is_there_and_ends_with_all() {
    let folder = tempfile::tempdir().unwrap();
    stored(folder.path(), &grid(4), Threads).unwrap();
    let told = std::sync::Mutex::new(Vec::new());
    let tell = |share: f64, words: &str| told.lock().unwrap().push((share, words.to_owned()));
    let backwards = Engine::new(Box::new(Backwards(ALL))).keeping(&Folder::create(folder.path()).unwrap());
    backwards.sweep(&roots(), &grid(6), &tell, root).unwrap();
    let expected = [4, 5, 6].map(|done| (f64::from(done) / 6.0, format!("{done} of 6 points")));
    assert_eq!(told.into_inner().unwrap(), expected);
}

#[test]
fn a_store_cut_off_anywhere_loses_the_torn_line_only_and_ends_with_the_same_bytes() {
    let (folder, points) = (tempfile::tempdir().unwrap(), grid(2));
    let (whole, computed) = stored(folder.path(), &points, Threads).unwrap();
    let written = bytes(folder.path());
    assert_eq!(computed, 2);
    // A kill at any moment, also while the header is written.
    for length in 0..=written.len() {
        fs::write(folder.path().join("roots.store"), &written[..length]).unwrap();
        let lines = written[..length].iter().filter(|&&byte| byte == b'\n').count();
        let (swept, computed) = stored(folder.path(), &points, Backwards(ALL)).unwrap();
        assert_eq!(swept.rows, whole.rows, "cut at {length}");
        assert_eq!((computed, swept.computed()), (2 - lines.saturating_sub(1), computed), "cut at {length}");
        assert!(bytes(folder.path()) == written, "cut at {length}");
    }
}

#[test]
fn a_run_that_is_left_repeats_nothing_and_a_larger_grid_adds_its_own_points() {
    let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for taken in [2, 3] {
        assert!(stored(folder.path(), &grid(9), Backwards(taken)).is_err(), "the backend left");
    }
    let (swept, computed) = stored(folder.path(), &grid(9), Threads).unwrap();
    assert_eq!((swept.resumed, computed), (5, 4));
    assert_eq!(stored(other.path(), &grid(9), Threads).unwrap().0.rows, swept.rows);
    assert_eq!(bytes(folder.path()), bytes(other.path()));
    let (larger, computed) = stored(folder.path(), &grid(12), Threads).unwrap();
    assert_eq!((larger.resumed, computed), (9, 3));
    // Computed backwards, the file is written anew at its end.
    stored(other.path(), &grid(12), Backwards(ALL)).unwrap();
    assert_eq!(bytes(folder.path()), bytes(other.path()));
    let (smaller, computed) = stored(folder.path(), &grid(2), Threads).unwrap();
    assert_eq!((smaller.resumed, computed, open(folder.path()).unwrap().len()), (2, 0, 12));
}

#[test]
fn any_byte_of_a_store_that_is_not_as_it_was_written_is_refused_with_its_line_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("roots.store");
    stored(folder.path(), &grid(3), Threads).unwrap();
    let written = bytes(folder.path());
    // The last byte ends the last line; without it the line is incomplete.
    for (k, flip) in (0..written.len() - 1).flat_map(|k| [1, 0x20, 0x80].map(|flip| (k, flip))) {
        let mut altered = written.clone();
        altered[k] ^= flip;
        fs::write(&path, &altered).unwrap();
        let text = refusal(folder.path());
        let line = 1 + written[..k].iter().filter(|&&byte| byte == b'\n').count();
        assert!(text.starts_with(&format!("{}, line {line}: ", path.display())), "byte {k}: {text}");
        assert!(bytes(folder.path()) == altered, "byte {k}");
    }
}

#[test]
fn stores_of_others_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("roots.store");
    stored(folder.path(), &grid(3), Threads).unwrap();
    let written = bytes(folder.path());
    let home = Folder::create(folder.path()).unwrap();
    let with =
        |study: &str, settings: Value| Store::open(&home, "roots.store", study, &settings).unwrap_err().to_string();
    let text = with("roots", json!({"alpha": 2.0, "rule": "energy", "tolerance": 1e-9}));
    assert!(text.contains("line 1: of another study: alpha is 1.5 there and 2.0 here"), "{text}");
    let text = with("powers", settings());
    assert!(text.contains("study is \"roots\" there and \"powers\" here"), "{text}");
    assert_eq!(bytes(folder.path()), written);

    // A line of another study among ours, and a line of ours twice.
    let (other, lines) = (tempfile::tempdir().unwrap(), |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap());
    engine(other.path()).sweep(&Grid { study: "powers", ..roots() }, &grid(4), SILENT, root).unwrap();
    let stranger = lines(&bytes(other.path())).lines().last().unwrap().to_owned() + "\n";
    fs::write(&path, lines(&written) + &stranger).unwrap();
    assert!(refusal(folder.path()).contains("line 5: not as it was written"));
    let twice = lines(&written).lines().nth(2).unwrap().to_owned() + "\n";
    fs::write(&path, lines(&written) + &twice).unwrap();
    assert!(refusal(folder.path()).contains("line 5: the point of line 3 again"));

    for text in
        ["", "\n", "epsilon,rho\n", "half a line", "\u{0}\u{0}\n"].map(str::as_bytes).into_iter().chain([&[0xff][..]])
    {
        fs::write(&path, text).unwrap();
        match open(folder.path()) {
            Ok(store) => assert!(text.is_empty() && store.is_empty()),
            Err(error) => {
                assert!(error.to_string().contains("roots.store, line 1: not "), "{error}");
                assert_eq!(bytes(folder.path()), text);
            }
        }
    }
}

#[test]
fn rows_of_another_shape_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    engine(folder.path()).sweep(&roots(), &grid(3), SILENT, |point| Ok(point.k)).unwrap();
    let error = stored(folder.path(), &grid(3), Threads).unwrap_err().to_string();
    assert!(error.contains("roots.store, line 2: no value of this study"), "{error}");
    // The first row is a value of this study, the second one is not.
    let folder = tempfile::tempdir().unwrap();
    let mixed = |point: &Point| Ok(if point.k == 1 { json!(1.0) } else { json!(root(point)?) });
    engine(folder.path()).sweep(&roots(), &grid(3), SILENT, mixed).unwrap();
    let error = stored(folder.path(), &grid(3), Threads).unwrap_err().to_string();
    assert!(error.contains("roots.store, line 3: no value of this study"), "{error}");
}

// Truth: the rows that were computed, and the lines counted here. A store is read in blocks of
// 8 MiB, each of which is cut into pieces that are checked side by side.
#[test]
fn a_store_of_several_blocks_is_resumed_repaired_and_refused_by_line() {
    let (folder, points) = (tempfile::tempdir().unwrap(), grid(150_000));
    let (whole, _) = stored(folder.path(), &points, Backwards(ALL)).unwrap();
    let (path, written) = (folder.path().join("roots.store"), bytes(folder.path()));
    assert!(written.len() > (1 << 23) + (1 << 20), "{}", written.len());
    let (swept, computed) = stored(folder.path(), &points, Threads).unwrap();
    assert!(swept.rows == whole.rows && computed == 0 && bytes(folder.path()) == written);
    fs::write(&path, &written[..written.len() - 7]).unwrap();
    let (swept, computed) = stored(folder.path(), &points, Threads).unwrap();
    assert!(swept.rows == whole.rows && computed == 1 && bytes(folder.path()) == written);
    for k in [written.len() / 3, (1 << 23) + 1, written.len() - 9] {
        let mut altered = written.clone();
        altered[k] ^= 1;
        fs::write(&path, &altered).unwrap();
        let line = 1 + written[..k].iter().filter(|&&byte| byte == b'\n').count();
        assert!(refusal(folder.path()).contains(&format!("line {line}: not as it was written")), "byte {k}");
    }
}

#[test]
fn a_store_belongs_to_one_run_at_a_time_and_a_grid_has_every_point_once() {
    let folder = tempfile::tempdir().unwrap();
    let first = open(folder.path()).unwrap();
    assert!(refusal(folder.path()).contains("in use by another run"));
    drop(first);
    assert!(open(folder.path()).is_ok());
    let twice = [grid(2), grid(1)].concat();
    let error = stored(folder.path(), &twice, Threads).unwrap_err().to_string();
    assert!(error.contains("has every point once") && error.contains("\"k\":0"), "{error}");
}

fn roots() -> Grid {
    Grid { store: "roots.store", study: "roots", settings: settings() }
}

fn engine(folder: &Path) -> Engine {
    Engine::threads().keeping(&Folder::create(folder).unwrap())
}

/// Sweeps a shard of 40 points: how many of its points are kept and how many were computed.
fn shard(folder: &Path, shard: &str) -> Result<(usize, usize)> {
    let engine = engine(folder).shard(shard.parse()?);
    let ended = engine.sweep(&roots(), &grid(40), SILENT, root).unwrap_err();
    engine.part().map(|part| (part.kept, part.computed)).ok_or(ended)
}

fn merged(folder: &Path) -> Result<Swept<Root>> {
    engine(folder).sweep(&roots(), &grid(40), SILENT, root)
}

// Truth: the store and the rows of one process.
#[test]
fn shards_merged_are_one_process_to_the_byte_whatever_is_missing_or_there_already() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (whole, parts) = (whole.path(), parts.path());
    let expected = merged(whole).unwrap();
    let names = || {
        let mut names: Vec<String> =
            fs::read_dir(parts).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort_unstable();
        names
    };
    // The third shard of four was never run; the second one was cut in its last line.
    assert_eq!(shard(parts, "1/4").unwrap(), (10, 10));
    assert_eq!(shard(parts, "2/4").unwrap(), (10, 10));
    assert_eq!(shard(parts, "4/4").unwrap(), (10, 10));
    assert_eq!(names(), [1, 2, 4].map(|k| format!("roots.shard-{k}-of-4.store")));
    let second = parts.join("roots.shard-2-of-4.store");
    let text = fs::read(&second).unwrap();
    fs::write(&second, &text[..text.len() - 7]).unwrap();
    let all = merged(parts).unwrap();
    assert_eq!((all.resumed, all.computed()), (29, 11));
    assert_eq!(all.rows, expected.rows);
    assert!(bytes(parts) == bytes(whole) && names() == ["roots.store"]);
    // Shards of what is there compute nothing, and their stores change nothing.
    assert_eq!(shard(parts, "2/3").unwrap(), (14, 0));
    assert_eq!(merged(parts).unwrap().resumed, 40);
    assert!(bytes(parts) == bytes(whole) && names() == ["roots.store"]);
    // Shards of other numbers, some points twice: what a kill between merging and removing leaves.
    fs::remove_file(parts.join("roots.store")).unwrap();
    for one in ["1/4", "1/3", "3/3"] {
        shard(parts, one).unwrap();
    }
    fs::copy(parts.join("roots.shard-1-of-4.store"), parts.join("roots.shard-4-of-4.store")).unwrap();
    assert_eq!(merged(parts).unwrap().rows, expected.rows);
    assert!(bytes(parts) == bytes(whole) && names() == ["roots.store"]);
}

#[test]
fn stores_of_shards_that_are_altered_foreign_or_in_use_are_refused_and_nothing_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    shard(folder, "1/2").unwrap();
    let path = folder.join("roots.shard-1-of-2.store");
    let written = fs::read(&path).unwrap();
    let refused = || merged(folder).unwrap_err().to_string();
    let mut altered = written.clone();
    altered[written.len() - 9] ^= 1;
    fs::write(&path, &altered).unwrap();
    assert!(refused().contains("roots.shard-1-of-2.store, line 21: not as it was written"), "{}", refused());
    assert!(fs::read(&path).unwrap() == altered);
    let home = Folder::create(folder).unwrap();
    fs::remove_file(&path).unwrap();
    drop(Store::open(&home, "roots.shard-1-of-2.store", "roots", &json!({"alpha": 2.0})).unwrap());
    assert!(refused().contains("line 1: of another study: alpha is 2.0 there and 1.5 here"), "{}", refused());
    fs::write(&path, &written).unwrap();
    // A shard that runs, and a merge beside another one.
    let running = Store::open(&home, "roots.shard-1-of-2.store", "roots", &settings()).unwrap();
    assert!(refused().contains("roots.shard-1-of-2.store, line 1: in use by another run"), "{}", refused());
    drop(running);
    let merging = Store::open(&home, "roots.store", "roots", &settings()).unwrap();
    assert!(refused().contains("roots.store, line 1: in use by another run"), "{}", refused());
    let text = shard(folder, "2/2").unwrap_err().to_string();
    assert!(text.contains("roots.store, line 1: in use by another run"), "{text}");
    drop(merging);
    assert_eq!(merged(folder).unwrap().resumed, 20);
}

/// Sweeps points of 1 ms and gives the share of the threads' time that is not in points.
fn overhead(points: u64) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let (busy, grid): (_, Vec<u64>) = (AtomicU64::new(0), (0..points).collect());
    let clock = Instant::now();
    let swept = engine(folder.path()).sweep(&roots(), &grid, &|_, _| (), |k| {
        let clock = Instant::now();
        while clock.elapsed() < Duration::from_millis(1) {
            std::hint::spin_loop();
        }
        busy.fetch_add(clock.elapsed().as_nanos() as u64, Ordering::Relaxed);
        Ok(*k)
    });
    assert_eq!(swept.unwrap().computed(), grid.len());
    let threads = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok());
    let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().unwrap().get());
    1.0 - busy.into_inner() as f64 / (threads as f64 * clock.elapsed().as_nanos() as f64)
}

// Truth: the time that points say they took. Measured on two threads: see docs/sweeps.md.
#[test]
#[ignore = "nightly: points of 1 ms"]
fn a_sweep_costs_less_than_a_twentieth_of_points_of_one_millisecond() {
    let share = overhead(20_000);
    println!("{:.2} % beside the points", 100.0 * share);
    assert!(share < 0.05, "{share}");
}

#[test]
#[ignore = "nightly: a million points"]
fn a_million_points_are_resumed_in_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let grid: Vec<u32> = (0..1_000_000).collect();
    let value = |k: &u32| Ok([1, 2, 3, 5, 7, 11].map(|n| (f64::from(*k) / f64::from(n)).sqrt()));
    for resumed in [0, grid.len()] {
        let clock = Instant::now();
        open(folder.path()).unwrap();
        assert!(clock.elapsed() < Duration::from_secs(60));
        let swept = engine(folder.path()).sweep(&roots(), &grid, SILENT, value).unwrap();
        assert_eq!(swept.resumed, resumed);
    }
}
