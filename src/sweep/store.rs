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

use crate::{
    error::{Error, Result},
    output::Folder,
};
use serde::Deserialize;
use serde_json::{Value, json, value::RawValue};
use std::{
    collections::{HashMap, HashSet},
    fs::{File, OpenOptions, TryLockError},
    io::{Read, Write},
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

/// The computed points of one study, in a file; see the [module](super).
#[derive(Debug)]
pub struct Store {
    folder: Folder,
    name: String,
    file: File,
    /// Time of the last sync to the disk.
    synced: Instant,
    /// Length of the whole lines, in bytes.
    length: u64,
    header: String,
    lines: Vec<Line>,
    at: HashMap<String, usize>,
}

/// A point and its row, as text.
#[derive(Debug)]
struct Line {
    key: String,
    row: String,
}

/// The JSON of a line.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Payload<'a> {
    #[serde(borrow)]
    point: &'a RawValue,
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
        let path = folder.path().join(name);
        let fail = |source| Error::File { path: path.clone(), source };
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(&path).map_err(fail)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(refused(&path, 1, "in use by another run")),
            // Where files cannot be locked, no check is possible.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(fail)?;
        let program = concat!("hertzchain ", env!("CARGO_PKG_VERSION"));
        let header = json!({"sweep": VERSION, "study": study, "program": program, "settings": settings}).to_string();
        let mut store = Self {
            folder: folder.clone(),
            name: name.to_owned(),
            file,
            synced: Instant::now(),
            length: 0,
            header,
            lines: Vec::new(),
            at: HashMap::new(),
        };
        store.load(&bytes)?;
        Ok(store)
    }

    /// Number of points in the store.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether the store has no points.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(&self.name)
    }

    fn fail(&self, source: std::io::Error) -> Error {
        Error::File { path: self.path(), source }
    }

    /// Reads the content of the file, and removes a partial last line.
    fn load(&mut self, bytes: &[u8]) -> Result<()> {
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        let head = self.head();
        if whole == 0 && !head.as_bytes().starts_with(bytes) {
            return Err(refused(&self.path(), 1, "not the store of a sweep"));
        }
        for (number, line) in bytes[..whole].split_inclusive(|&byte| byte == b'\n').enumerate() {
            self.take(number + 1, line).map_err(|rule| refused(&self.path(), number + 1, rule))?;
        }
        self.length = whole as u64;
        if whole < bytes.len() {
            self.file.set_len(self.length).map_err(|source| self.fail(source))?;
        }
        if whole == 0 { self.write(&head) } else { Ok(()) }
    }

    /// Reads the line with the given number, counted from 1.
    fn take(&mut self, number: usize, line: &[u8]) -> std::result::Result<(), String> {
        let altered = || "not as it was written: its check does not fit".to_owned();
        let text = std::str::from_utf8(line).ok().and_then(|line| line.strip_suffix('\n')).ok_or_else(altered)?;
        let (check, json) = text.split_once(' ').ok_or_else(altered)?;
        let from = if number == 1 { BASIS } else { fnv(BASIS, &self.header) };
        if check != digits(fnv(from, json)) {
            return Err(altered());
        }
        if number == 1 {
            return if json == self.header { Ok(()) } else { Err(difference(&self.header, json)) };
        }
        let Payload { point, row } = serde_json::from_str(json).map_err(|why| format!("no point and row: {why}"))?;
        let known = self.at.insert(point.get().to_owned(), self.lines.len());
        self.lines.push(Line { key: point.get().to_owned(), row: row.get().to_owned() });
        known.map_or(Ok(()), |before| Err(format!("the point of line {} again", before + 2)))
    }

    /// The row of a point, if the store has it.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.at.get(key).map(|&k| self.lines[k].row.as_str())
    }

    /// The error for a row that does not hold a value of this study.
    pub(super) fn corrupt(&self, key: &str, why: &str) -> Error {
        refused(&self.path(), self.at.get(key).map_or(1, |&k| k + 2), format!("no value of this study: {why}"))
    }

    pub(super) fn append(&mut self, key: &str, row: String) -> Result<()> {
        let line = Line { key: key.to_owned(), row };
        self.write(&self.written(&line))?;
        self.at.insert(key.to_owned(), self.lines.len());
        self.lines.push(line);
        Ok(())
    }

    /// Rewrites the file in the order of the grid, with points of other grids at the end.
    ///
    /// The bytes are then the same for any order of the work.
    pub(super) fn settle(&mut self, keys: &[String]) -> Result<()> {
        let of_grid: HashSet<&String> = keys.iter().collect();
        let others = self.lines.iter().map(|line| &line.key).filter(|key| !of_grid.contains(key));
        let order: Vec<usize> = keys.iter().chain(others).filter_map(|key| self.at.get(key).copied()).collect();
        if order.is_sorted() {
            return Ok(());
        }
        let text = order.iter().fold(self.head(), |text, &k| text + &self.written(&self.lines[k]));
        self.folder.write(&self.name, text.as_bytes())?;
        // What is appended later belongs into the new file, after its lines.
        self.file = OpenOptions::new().read(true).append(true).open(self.path()).map_err(|source| self.fail(source))?;
        drop(self.file.try_lock());
        self.length = text.len() as u64;
        let mut lines: Vec<Option<Line>> = self.lines.drain(..).map(Some).collect();
        self.lines.extend(order.iter().filter_map(|&k| lines[k].take()));
        self.at = self.lines.iter().enumerate().map(|(k, line)| (line.key.clone(), k)).collect();
        Ok(())
    }

    fn head(&self) -> String {
        format!("{} {}\n", digits(fnv(BASIS, &self.header)), self.header)
    }

    fn written(&self, Line { key, row }: &Line) -> String {
        let json = format!(r#"{{"point":{key},"row":{row}}}"#);
        format!("{} {json}\n", digits(fnv(fnv(BASIS, &self.header), &json)))
    }

    fn write(&mut self, line: &str) -> Result<()> {
        if let Err(source) = self.file.write_all(line.as_bytes()) {
            // A full disk may have taken a part of the line: remove it, so that the next line does
            // not continue it.
            drop(self.file.set_len(self.length));
            return Err(self.fail(source));
        }
        self.length += line.len() as u64;
        if self.synced.elapsed() > SYNC {
            self.file.sync_data().map_err(|source| self.fail(source))?;
            self.synced = Instant::now();
        }
        Ok(())
    }
}

fn refused(path: &Path, line: usize, rule: impl Into<String>) -> Error {
    Error::Content { path: path.to_owned(), place: format!("line {line}"), rule: rule.into() }
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
