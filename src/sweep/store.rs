//! A file that grows by a line with every point that is computed.
//!
//! Every line is `CHECK JSON`, the check 16 hexadecimal digits of the FNV-1a hash of the JSON. The first line says whose points these are: study,
//! program and settings; its check is the fingerprint of the study, and the checks of all other lines go on from it, so that a line of another study
//! fits nowhere. A line is handed to the system in one piece. What a kill leaves of it has no end of line: it is dropped, and the point computed again. Anything else
//! that is not as it was written is refused, and never written over. Lines are synced once a second: a failure of the power costs the points of about that time.
//! A store belongs to one run at a time.

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

/// The version of the format.
const VERSION: u64 = 1;
/// Lines are brought to the disk so often.
const SYNC: Duration = Duration::from_secs(1);
/// The basis of FNV-1a, 64 bits.
const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
/// Its prime.
const PRIME: u64 = 0x0000_0100_0000_01b3;

/// The points of one study that were computed, in a file; see the [module](super).
#[derive(Debug)]
pub struct Store {
    folder: Folder,
    name: String,
    file: File,
    /// When it was last brought to the disk.
    synced: Instant,
    /// Bytes that are whole lines.
    length: u64,
    header: String,
    lines: Vec<Line>,
    at: HashMap<String, usize>,
}

/// A point and what came of it, as text.
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
    /// Opens the store `name` of a folder, or makes it. `settings`: all that results depend on beside the point.
    ///
    /// # Errors
    /// A file that is no store, is that of another study, or is not as it was written, with its line; one that another run has open; what the system says.
    pub fn open(folder: &Folder, name: &str, study: &str, settings: &Value) -> Result<Self> {
        let path = folder.path().join(name);
        let fail = |source| Error::File { path: path.clone(), source };
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(&path).map_err(fail)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(refused(&path, 1, "in use by another run")),
            // Where files cannot be locked, nobody can look.
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

    /// How many points it holds.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(&self.name)
    }

    fn fail(&self, source: std::io::Error) -> Error {
        Error::File { path: self.path(), source }
    }

    /// Takes what the file holds, and cuts off what a kill has left of a last line.
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

    /// Takes a line, of this number from 1 on.
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

    /// The row of a point, if it is there.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.at.get(key).map(|&k| self.lines[k].row.as_str())
    }

    /// The row of a point is none of this study.
    pub(super) fn corrupt(&self, key: &str, why: &str) -> Error {
        refused(&self.path(), self.at.get(key).map_or(1, |&k| k + 2), format!("no value of this study: {why}"))
    }

    /// Keeps the row of a point.
    pub(super) fn append(&mut self, key: &str, row: String) -> Result<()> {
        let line = Line { key: key.to_owned(), row };
        self.write(&self.written(&line))?;
        self.at.insert(key.to_owned(), self.lines.len());
        self.lines.push(line);
        Ok(())
    }

    /// Brings the lines of a finished grid into its order, before those of other grids: the same bytes, whatever the order of the work was.
    pub(super) fn settle(&mut self, keys: &[String]) -> Result<()> {
        let of_grid: HashSet<&String> = keys.iter().collect();
        let others = self.lines.iter().map(|line| &line.key).filter(|key| !of_grid.contains(key));
        let order: Vec<usize> = keys.iter().chain(others).filter_map(|key| self.at.get(key).copied()).collect();
        if order.is_sorted() {
            return Ok(());
        }
        let text = order.iter().fold(self.head(), |text, &k| text + &self.written(&self.lines[k]));
        self.folder.write(&self.name, text.as_bytes()).map(|_| ())
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
            // What a full disk took of the line is none: the next one must not go on from there.
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

/// FNV-1a, from where another left off: any one byte changed changes it.
fn fnv(from: u64, text: &str) -> u64 {
    text.bytes().fold(from, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

fn digits(check: u64) -> String {
    format!("{check:016x}")
}

/// In what the header of another store differs from ours.
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
