//! A file that gets one more line for every computed point.
//!
//! A line is `CHECK JSON`, where the check is the FNV-1a hash of the JSON in 16 hexadecimal digits.
//! The first line says to which study the points belong: study, program and settings. The hashes of
//! all other lines continue that of the first, so that a line of another study is refused.
//!
//! A line is handed to the system in one call. If the process is killed, a partial line has no end
//! of line: it is dropped, and its point is computed again. All other content that is not as it was
//! written is refused and not overwritten. Lines are synced once a second, so a failure of the
//! power costs the points of about one second. A store belongs to one run at a time.
//!
//! Rows stay in the file. In memory a point takes the hash of its text and the place of its line,
//! 16 bytes; two points of the same hash are told apart by their lines.

use super::shard::Shard;
use crate::{
    error::{Error, Result},
    output::Folder,
};
use serde::Deserialize;
use serde_json::{Value, json, value::RawValue};
use std::{
    fs::{File, OpenOptions, TryLockError},
    io::{self, BufRead, BufReader, BufWriter, Read, Write},
    num::NonZeroU64,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

const VERSION: u64 = 1;
/// Time between two syncs to the disk.
const SYNC: Duration = Duration::from_secs(1);
/// The basis of FNV-1a, 64 bits.
const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
/// The prime of FNV-1a, 64 bits.
const PRIME: u64 = 0x0000_0100_0000_01b3;
/// Bytes that lines of another store are collected to before they are written.
const CHUNK: usize = 1 << 20;
const IN_USE: &str = "in use by another run: wait until it has ended";

/// The computed points of one study, in a file; see the [module](super).
#[derive(Debug)]
pub struct Store {
    folder: Folder,
    name: String,
    file: File,
    lines: Lines,
    /// Time of the last sync to the disk.
    synced: Instant,
    /// Length of the whole lines, in bytes.
    length: u64,
    header: String,
    /// The hash of the header, which the checks of all other lines continue.
    basis: u64,
    /// The lines by the hash of their point, in this order but for those appended last.
    index: Vec<Entry>,
    /// How many of the index are in order.
    sorted: usize,
}

/// Where a line begins, in bytes from the start of the file; no line of a point is the first.
pub(super) type Place = NonZeroU64;

/// A point of the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    hash: u64,
    place: Place,
}

/// Reads lines at any place of a file; one after the other without a call of the system each.
#[derive(Debug)]
struct Lines {
    reader: BufReader<File>,
    at: u64,
}

/// The JSON of a line.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Payload<'a> {
    #[serde(borrow)]
    point: &'a RawValue,
    #[serde(borrow)]
    row: &'a RawValue,
}

impl Store {
    /// Opens the store `name` of a folder, or creates it. `settings` holds all that results depend
    /// on besides the point.
    ///
    /// # Errors
    /// A file that is not a store, belongs to another study, or is not as it was written, with the
    /// line; a store that another run has open; errors of the system.
    pub fn open(folder: &Folder, name: &str, study: &str, settings: &Value) -> Result<Self> {
        let open = |path: &Path| OpenOptions::new().read(true).append(true).create(true).open(path);
        let mut store = Self::locked(folder, name, header(study, settings), open, File::try_lock)?;
        store.load()?;
        store.repair()?;
        Ok(store)
    }

    /// Opens the store for reading, beside others that read it; `None` if there is no such file.
    pub(super) fn look(folder: &Folder, name: &str, study: &str, settings: &Value) -> Result<Option<Self>> {
        if !folder.path().join(name).exists() {
            return Ok(None);
        }
        let open = |path: &Path| File::open(path);
        let mut store = Self::locked(folder, name, header(study, settings), open, File::try_lock_shared)?;
        store.load().map(|()| Some(store))
    }

    /// The store of a file, locked, before anything of it was read.
    fn locked(
        folder: &Folder,
        name: &str,
        header: String,
        open: impl Fn(&Path) -> io::Result<File>,
        lock: fn(&File) -> std::result::Result<(), TryLockError>,
    ) -> Result<Self> {
        let path = folder.path().join(name);
        let fail = |source| Error::File { path: path.clone(), source };
        let file = loop {
            let file = open(&path).map_err(fail)?;
            match lock(&file) {
                Err(TryLockError::WouldBlock) => return Err(refused(&path, 1, IN_USE)),
                // Where files cannot be locked, no check is possible.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            // Between opening and locking, another run may have put a new file in its place.
            if is_at(&file, &path) {
                break file;
            }
        };
        Ok(Self {
            folder: folder.clone(),
            name: name.to_owned(),
            file,
            lines: Lines::new(File::open(&path).map_err(fail)?),
            synced: Instant::now(),
            length: 0,
            basis: fnv(BASIS, &header),
            header,
            index: Vec::new(),
            sorted: 0,
        })
    }

    /// Number of points in the store.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Whether the store has no points.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// The file.
    pub fn path(&self) -> PathBuf {
        self.folder.path().join(&self.name)
    }

    /// Takes over what shards have kept beside this store, and removes their stores.
    ///
    /// A kill at any moment loses no line: the store of a shard is removed once its lines are on
    /// the disk here, and lines that are here already are not taken again.
    ///
    /// # Errors
    /// A store of a shard that is still in use, of another study, or altered; errors of the system.
    pub(super) fn merge(&mut self, study: &str, settings: &Value) -> Result<()> {
        for name in Shard::names(self.folder.path(), &self.name) {
            let mut other = Self::open(&self.folder, &name, study, settings)?;
            self.take_over(&mut other)?;
            self.folder.remove([name.as_str()])?;
        }
        Ok(())
    }

    /// Appends the lines of another store of the same study whose points are not here.
    fn take_over(&mut self, other: &mut Self) -> Result<()> {
        let (mut chunk, mut new) = (String::new(), Vec::new());
        other.index.sort_unstable_by_key(|entry| entry.place);
        for Entry { hash, place } in std::mem::take(&mut other.index) {
            let line = other.line(place)?;
            let (point, _) = parts(&line).map_err(|why| other.corrupt(place, &why))?;
            if self.find(hash, point)?.is_none() {
                new.push(Entry { hash, place: place_at(self.length + chunk.len() as u64) });
                chunk += &line;
            }
            if chunk.len() > CHUNK {
                self.write(&chunk)?;
                chunk.clear();
            }
        }
        self.write(&chunk)?;
        self.index.extend(new);
        self.sort();
        self.file.sync_data().map_err(|source| self.fail(source))
    }

    /// Reads and checks the whole lines of the file.
    fn load(&mut self) -> Result<()> {
        let mut line = Vec::new();
        for number in 1.. {
            line.clear();
            self.lines.at += self.lines.reader.read_until(b'\n', &mut line).map_err(|source| self.fail(source))? as u64;
            if line.last() != Some(&b'\n') {
                break;
            }
            self.take(number, &line).map_err(|rule| refused(&self.path(), number, rule))?;
            self.length += line.len() as u64;
        }
        if self.length == 0 && !self.head().as_bytes().starts_with(&line) {
            return Err(refused(&self.path(), 1, "not the store of a sweep"));
        }
        self.sort();
        self.refuse_twice()
    }

    /// Removes a partial last line, and writes the first one if there is none.
    fn repair(&mut self) -> Result<()> {
        if self.lines.at > self.length {
            self.file.set_len(self.length).map_err(|source| self.fail(source))?;
        }
        if self.length == 0 { self.write(&self.head()) } else { Ok(()) }
    }

    /// Reads the line with the given number, counted from 1.
    fn take(&mut self, number: usize, line: &[u8]) -> std::result::Result<(), String> {
        let altered = || "not as it was written: its check does not fit".to_owned();
        let text = std::str::from_utf8(line).map_err(|_| altered())?;
        let (check, json) = text.trim_end_matches('\n').split_once(' ').ok_or_else(altered)?;
        let from = if number == 1 { BASIS } else { self.basis };
        if check != digits(fnv(from, json)) {
            return Err(altered());
        }
        if number == 1 {
            return if json == self.header { Ok(()) } else { Err(difference(&self.header, json)) };
        }
        let (point, _) = parts(text)?;
        self.index.push(Entry { hash: hash(point), place: place_at(self.length) });
        Ok(())
    }

    /// Refuses a point that has two lines.
    fn refuse_twice(&mut self) -> Result<()> {
        for k in 1..self.index.len() {
            let mut before = k;
            // Points of the same hash are few.
            while before > 0 && self.index[before - 1].hash == self.index[k].hash {
                before -= 1;
                let [first, second] = [self.index[before].place, self.index[k].place];
                let (one, two) = (self.line(first)?, self.line(second)?);
                let same = parts(&one).map(|both| both.0) == parts(&two).map(|both| both.0);
                if same {
                    let again = format!("the point of line {} again", self.number(first));
                    return Err(refused(&self.path(), self.number(second), again));
                }
            }
        }
        Ok(())
    }

    fn sort(&mut self) {
        self.index.sort_unstable();
        self.sorted = self.index.len();
    }

    /// The place and the row of a point, if the store has it; of those that were there when the
    /// store was opened, merged or settled.
    pub(super) fn find(&mut self, hash: u64, point: &str) -> Result<Option<(Place, String)>> {
        let from = self.index[..self.sorted].partition_point(|entry| entry.hash < hash);
        for k in from..self.sorted {
            let Entry { hash: other, place } = self.index[k];
            if other != hash {
                break;
            }
            if let Ok((there, row)) = parts(&self.line(place)?)
                && there == point
            {
                return Ok(Some((place, row.to_owned())));
            }
        }
        Ok(None)
    }

    /// The row of the line at a place.
    pub(super) fn row(&mut self, place: Place) -> Result<String> {
        let line = self.line(place)?;
        let (_, row) = parts(&line).map_err(|why| self.corrupt(place, &why))?;
        Ok(row.to_owned())
    }

    fn line(&mut self, place: Place) -> Result<String> {
        self.lines.line(place).map_err(|source| self.fail(source))
    }

    /// The number of the line at a place, counted from 1.
    fn number(&self, place: Place) -> usize {
        let before = File::open(self.path()).map(|file| BufReader::new(file.take(place.get())));
        1 + before.map_or(0, |before| before.split(b'\n').count())
    }

    /// The error for a line that does not hold a value of this study.
    pub(super) fn corrupt(&self, place: Place, why: &str) -> Error {
        refused(&self.path(), self.number(place), format!("no value of this study: {why}"))
    }

    /// Appends a line; its place.
    pub(super) fn append(&mut self, point: &str, row: &str) -> Result<Place> {
        let json = format!(r#"{{"point":{point},"row":{row}}}"#);
        let place = place_at(self.length);
        self.write(&format!("{} {json}\n", digits(fnv(self.basis, &json))))?;
        self.index.push(Entry { hash: hash(point), place });
        Ok(place)
    }

    /// Rewrites the file in the order of the grid, whose lines are at `places`, with points of
    /// other grids at the end. The places are then those in the new file.
    ///
    /// The bytes are then the same for any order of the work.
    pub(super) fn settle(&mut self, places: &mut [Option<Place>]) -> Result<()> {
        let mut others = self.others(places);
        let order = || places.iter().flatten().chain(&others);
        if order().is_sorted() {
            self.sort();
            return Ok(());
        }
        let (name, head) = (self.name.clone(), self.head());
        let (lines, mut length) = (&mut self.lines, head.len() as u64);
        self.folder.write_with(&name, |file| {
            let mut out = BufWriter::new(file);
            out.write_all(head.as_bytes())?;
            for place in places.iter_mut().flatten().chain(&mut others) {
                let line = lines.line(*place)?;
                out.write_all(line.as_bytes())?;
                *place = place_at(length);
                length += line.len() as u64;
            }
            out.flush()
        })?;
        // What is appended later belongs into the new file, after its lines.
        let open = |path: &Path| OpenOptions::new().read(true).append(true).open(path);
        *self = Self::locked(&self.folder, &name, self.header.clone(), open, File::try_lock)?;
        self.load()
    }

    /// Places of the lines that are not among `places`, in their order.
    fn others(&self, places: &[Option<Place>]) -> Vec<Place> {
        if places.iter().flatten().count() == self.index.len() {
            return Vec::new();
        }
        let mut of_grid: Vec<Place> = places.iter().flatten().copied().collect();
        of_grid.sort_unstable();
        let all = self.index.iter().map(|entry| entry.place);
        let mut others: Vec<Place> = all.filter(|place| of_grid.binary_search(place).is_err()).collect();
        others.sort_unstable();
        others
    }

    fn head(&self) -> String {
        format!("{} {}\n", digits(self.basis), self.header)
    }

    fn fail(&self, source: io::Error) -> Error {
        Error::File { path: self.path(), source }
    }

    fn write(&mut self, lines: &str) -> Result<()> {
        if let Err(source) = self.file.write_all(lines.as_bytes()) {
            // A full disk may have taken a part of the line: remove it, so that the next line does
            // not continue it.
            drop(self.file.set_len(self.length));
            return Err(self.fail(source));
        }
        self.length += lines.len() as u64;
        if self.synced.elapsed() > SYNC {
            self.file.sync_data().map_err(|source| self.fail(source))?;
            self.synced = Instant::now();
        }
        Ok(())
    }
}

impl Lines {
    fn new(file: File) -> Self {
        Self { reader: BufReader::with_capacity(1 << 16, file), at: 0 }
    }

    /// The line that begins at a place, with its end.
    fn line(&mut self, place: Place) -> io::Result<String> {
        let place = place.get();
        self.reader.seek_relative(place.wrapping_sub(self.at).cast_signed())?;
        self.at = place;
        let mut line = String::new();
        self.at += self.reader.read_line(&mut line)? as u64;
        Ok(line)
    }
}

/// The first line of a store.
fn header(study: &str, settings: &Value) -> String {
    let program = concat!("hertzchain ", env!("CARGO_PKG_VERSION"));
    json!({"sweep": VERSION, "study": study, "program": program, "settings": settings}).to_string()
}

/// Point and row of a line, with its check.
fn parts(line: &str) -> std::result::Result<(&str, &str), String> {
    let json = line.split_once(' ').map_or(line, |(_, json)| json);
    let payload: Payload = serde_json::from_str(json).map_err(|why| format!("no point and row: {why}"))?;
    Ok((payload.point.get(), payload.row.get()))
}

/// Whether the open file is still the one of this path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::{fs::Metadata, os::unix::fs::MetadataExt};
    let inode = |file: io::Result<Metadata>| file.ok().map(|file| (file.dev(), file.ino()));
    inode(file.metadata()) == inode(std::fs::metadata(path))
}

/// Elsewhere a file that is open is not replaced.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

fn refused(path: &Path, line: usize, rule: impl Into<String>) -> Error {
    Error::Content { path: path.to_owned(), place: format!("line {line}"), rule: rule.into() }
}

/// A place after the first line.
fn place_at(bytes: u64) -> Place {
    Place::new(bytes).unwrap_or(Place::MIN)
}

/// The hash of a point by which the index finds it.
pub(super) fn hash(point: &str) -> u64 {
    fnv(BASIS, point)
}

/// FNV-1a, continued from the hash `from`. A change of one byte always changes the hash.
fn fnv(from: u64, text: &str) -> u64 {
    text.bytes().fold(from, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

fn digits(check: u64) -> String {
    format!("{check:016x}")
}

/// The first difference between the header of another store and ours, as a message.
fn difference(ours: &str, theirs: &str) -> String {
    let parsed = |text| serde_json::from_str::<Value>(text).unwrap_or_default();
    let (ours, theirs) = (parsed(ours), parsed(theirs));
    if theirs["sweep"].is_null() {
        return "not the store of a sweep".to_owned();
    }
    let both = |of: &dyn Fn(&Value) -> Value, name: &str| {
        let (ours, theirs) = (of(&ours), of(&theirs));
        (ours != theirs).then(|| format!("{name} is {theirs} there and {ours} here"))
    };
    let header = ["sweep", "study", "program"];
    let named = header.iter().find_map(|name| both(&|header| header[*name].clone(), name));
    let settings = ours["settings"].as_object().into_iter().flat_map(|settings| settings.keys());
    let set = || settings.map(|name| both(&|header| header["settings"][name].clone(), name)).find_map(|found| found);
    let what = named.or_else(set).unwrap_or_else(|| "its settings are other ones".to_owned());
    format!("of another study: {what}; take another folder, or move the file away")
}
