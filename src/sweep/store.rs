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
//! 24 bytes. The hash has 128 bits and stands for the point: of 10^7 points, two would share one
//! with a probability of about 1e-25 if hashes were drawn at random.

use super::{shard::Shard, threads};
use crate::{
    error::{Error, Result},
    output::{Folder, PROGRAM, is_at},
};
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
/// The basis and the prime of FNV-1a, 128 bits.
const LONG_BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
const LONG_PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
/// Bytes of the file that are read at a time.
const BLOCK: u64 = 1 << 23;
/// Bytes of whole lines that one thread checks at a time.
const PIECE: usize = 1 << 18;
/// Lines whose checks are computed side by side, as in one check each byte waits for the byte
/// before it.
const LANES: usize = 4;
/// Lines of another store are written once more than this number of bytes is collected.
const CHUNK: usize = 1 << 20;
const IN_USE: &str = "in use by another run: wait until it has ended";

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
    /// Whether a partial line follows the whole ones.
    torn: bool,
    header: String,
    /// The hash of the header, which the checks of all other lines continue.
    basis: u64,
    /// The places of the lines with the hashes of their points, sorted by hash up to `sorted`;
    /// lines appended since then follow.
    index: Vec<Entry>,
    /// Number of entries of `index` that are sorted.
    sorted: usize,
}

/// Where a line begins, in bytes from the start of the file; no line of a point is the first.
pub(super) type Offset = NonZeroU64;

/// The hash of a point by which the index finds it, in two halves.
pub(super) type Hash = [u64; 2];

/// A point of the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    hash: Hash,
    place: Offset,
}

/// Reads lines at any place of a file. Lines that follow each other are read through a buffer.
pub(super) struct Lines {
    reader: BufReader<File>,
    at: u64,
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

    /// Opens and locks the file of a store. Nothing of it is read yet.
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
            synced: Instant::now(),
            length: 0,
            torn: false,
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
        let (mut lines, mut chunk, mut new) = (other.lines()?, String::new(), Vec::new());
        other.index.sort_unstable_by_key(|entry| entry.place);
        for Entry { hash, place } in std::mem::take(&mut other.index) {
            if !self.has(hash) {
                new.push(Entry { hash, place: place_at(self.length + chunk.len() as u64) });
                lines.line(place, &mut chunk).map_err(|source| other.fail(source))?;
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

    /// Reads and checks the whole lines of the file, on all cores.
    fn load(&mut self) -> Result<()> {
        let file = File::open(self.path()).map_err(|source| self.fail(source))?;
        let mut block = Vec::new();
        loop {
            let read = (&file).take(BLOCK).read_to_end(&mut block).map_err(|source| self.fail(source))?;
            let whole = block.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
            self.take(&block[..whole])?;
            block.drain(..whole);
            if read == 0 {
                break;
            }
        }
        self.torn = !block.is_empty();
        if self.length == 0 && !self.head().as_bytes().starts_with(&block) {
            return Err(refused(&self.path(), 1, "not the store of a sweep"));
        }
        self.sort();
        self.refuse_twice()
    }

    /// Removes a partial last line, and writes the first one if there is none.
    fn repair(&mut self) -> Result<()> {
        if self.torn {
            self.file.set_len(self.length).map_err(|source| self.fail(source))?;
        }
        if self.length == 0 { self.write(&self.head()) } else { Ok(()) }
    }

    /// Takes the next whole lines of the file.
    fn take(&mut self, lines: &[u8]) -> Result<()> {
        let mut rest = lines;
        if self.length == 0
            && let Some(end) = rest.iter().position(|byte| *byte == b'\n')
        {
            self.take_head(&rest[..=end]).map_err(|rule| refused(&self.path(), 1, rule))?;
            self.length += end as u64 + 1;
            rest = &rest[end + 1..];
        }
        let (basis, pieces) = (self.basis, pieces(rest, self.length));
        for (entries, rule) in threads::map(&pieces, |(piece, place)| entries(piece, *place, basis)) {
            self.index.extend(entries);
            if let Some(rule) = rule {
                return Err(refused(&self.path(), self.index.len() + 2, rule));
            }
        }
        self.length += rest.len() as u64;
        Ok(())
    }

    fn take_head(&self, line: &[u8]) -> std::result::Result<(), String> {
        let text = check_and_json(line);
        let json = fitting(text, fnv(BASIS, text.1))?;
        if json == self.header { Ok(()) } else { Err(difference(&self.header, json)) }
    }

    /// Refuses a point that has two lines.
    fn refuse_twice(&self) -> Result<()> {
        let twice = self.index.windows(2).filter(|two| two[0].hash == two[1].hash);
        // Of several such points, the one whose second line comes first in the file.
        let Some(two) = twice.min_by_key(|two| two[1].place) else { return Ok(()) };
        let [first, second] = [two[0], two[1]].map(|entry| self.number(entry.place));
        Err(refused(&self.path(), second, format!("the point of line {first} again")))
    }

    fn sort(&mut self) {
        threads::sort(&mut self.index);
        self.sorted = self.index.len();
    }

    /// Whether the store has a point. Lines appended since it was opened, merged or settled do not
    /// count.
    fn has(&self, hash: Hash) -> bool {
        self.index[..self.sorted].binary_search_by_key(&hash, |entry| entry.hash).is_ok()
    }

    /// Places of the points `0..hashes.len()` of a grid, `None` for a point without a line. Lines
    /// appended since the store was opened, merged or settled do not count. The hashes are sorted
    /// and differ, each with the number of its point.
    pub(super) fn places(&self, hashes: &[(Hash, usize)]) -> Vec<Option<Offset>> {
        let mut places = vec![None; hashes.len()];
        let mut index = self.index[..self.sorted].iter().peekable();
        for (hash, k) in hashes {
            while index.next_if(|entry| entry.hash < *hash).is_some() {}
            places[*k] = index.peek().filter(|entry| entry.hash == *hash).map(|entry| entry.place);
        }
        places
    }

    /// A reader of its lines.
    pub(super) fn lines(&self) -> Result<Lines> {
        let file = File::open(self.path()).map_err(|source| self.fail(source))?;
        Ok(Lines { reader: BufReader::with_capacity(1 << 16, file), at: 0 })
    }

    /// The number of the line at a place, counted from 1.
    fn number(&self, place: Offset) -> usize {
        let before = File::open(self.path()).map(|file| BufReader::new(file.take(place.get())));
        1 + before.map_or(0, |before| before.split(b'\n').count())
    }

    /// The error for a line that does not hold a value of this study.
    pub(super) fn corrupt(&self, place: Offset, why: &str) -> Error {
        refused(&self.path(), self.number(place), format!("no value of this study: {why}"))
    }

    /// Appends the line of a point. Returns its place.
    pub(super) fn append(&mut self, point: &str, row: &str) -> Result<Offset> {
        let json = format!(r#"{{"point":{point},"row":{row}}}"#);
        let place = place_at(self.length);
        self.write(&format!("{} {json}\n", digits(fnv(self.basis, &json)).escape_ascii()))?;
        self.index.push(Entry { hash: hash(point), place });
        Ok(place)
    }

    /// Rewrites the file in the order of the grid, whose lines are at `places`. Lines of points of
    /// other grids come last. `places` become those in the new file.
    ///
    /// So the bytes of the file do not depend on the order in which points were computed.
    pub(super) fn settle(&mut self, places: &mut [Option<Offset>]) -> Result<()> {
        let mut others = self.others(places);
        let order = || places.iter().flatten().chain(&others);
        if order().is_sorted() {
            self.sort();
            return Ok(());
        }
        let (name, head) = (self.name.clone(), self.head());
        let (mut lines, mut length) = (self.lines()?, head.len() as u64);
        self.folder.write_with(&name, |file| {
            let mut out = BufWriter::new(file);
            out.write_all(head.as_bytes())?;
            let mut line = String::new();
            for place in places.iter_mut().flatten().chain(&mut others) {
                line.clear();
                lines.line(*place, &mut line)?;
                out.write_all(line.as_bytes())?;
                *place = place_at(length);
                length += line.len() as u64;
            }
            out.flush()
        })?;
        // Lines that are appended later go to the new file.
        let open = |path: &Path| OpenOptions::new().read(true).append(true).open(path);
        *self = Self::locked(&self.folder, &name, self.header.clone(), open, File::try_lock)?;
        self.load()
    }

    /// Places of the lines that are not among `places`, in their order.
    fn others(&self, places: &[Option<Offset>]) -> Vec<Offset> {
        if places.iter().flatten().count() == self.index.len() {
            return Vec::new();
        }
        let mut of_grid: Vec<Offset> = places.iter().flatten().copied().collect();
        of_grid.sort_unstable();
        let all = self.index.iter().map(|entry| entry.place);
        let mut others: Vec<Offset> = all.filter(|place| of_grid.binary_search(place).is_err()).collect();
        others.sort_unstable();
        others
    }

    fn head(&self) -> String {
        format!("{} {}\n", digits(self.basis).escape_ascii(), self.header)
    }

    pub(super) fn fail(&self, source: io::Error) -> Error {
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
    /// Appends the line that begins at a place, with its end, to a text.
    pub(super) fn line(&mut self, place: Offset, text: &mut String) -> io::Result<()> {
        let place = place.get();
        self.reader.seek_relative(place.wrapping_sub(self.at).cast_signed())?;
        self.at = place + self.reader.read_line(text)? as u64;
        Ok(())
    }
}

/// Lines cut into pieces of whole lines, with the place of each; the first one is at `at`.
fn pieces(lines: &[u8], at: u64) -> Vec<(&[u8], Offset)> {
    let (mut pieces, mut rest) = (Vec::new(), lines);
    while !rest.is_empty() {
        let least = PIECE.min(rest.len() - 1);
        let end = rest[least..].iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| least + end + 1);
        pieces.push((&rest[..end], place_at(at + (lines.len() - rest.len()) as u64)));
        rest = &rest[end..];
    }
    pieces
}

/// The entries of whole lines, the first of which begins at `place`, up to the first line that is
/// refused; and why it is refused.
fn entries(lines: &[u8], place: Offset, basis: u64) -> (Vec<Entry>, Option<String>) {
    let (mut entries, mut place) = (Vec::new(), place);
    let lines: Vec<&[u8]> = lines.split_inclusive(|byte| *byte == b'\n').collect();
    for group in lines.chunks(LANES) {
        let mut texts = [("", ""); LANES];
        texts.iter_mut().zip(group).for_each(|(text, line)| *text = check_and_json(line));
        let hashes = side_by_side(basis, texts.map(|(_, json)| json.as_bytes()));
        for ((line, text), hashed) in group.iter().zip(texts).zip(hashes) {
            match fitting(text, hashed).and_then(parts) {
                Ok((point, _)) => entries.push(Entry { hash: hash(point), place }),
                Err(rule) => return (entries, Some(rule)),
            }
            place = place.saturating_add(line.len() as u64);
        }
    }
    (entries, None)
}

/// The two parts of a line, which are empty if it has not two.
fn check_and_json(line: &[u8]) -> (&str, &str) {
    let text = std::str::from_utf8(line).unwrap_or_default();
    text.trim_end_matches('\n').split_once(' ').unwrap_or_default()
}

/// The JSON of a line, if its check is this hash.
fn fitting<'a>((check, json): (&'a str, &'a str), hash: u64) -> std::result::Result<&'a str, String> {
    let altered = || "not as it was written: its check does not fit".to_owned();
    (check.as_bytes() == digits(hash)).then_some(json).ok_or_else(altered)
}

/// The first line of a store.
fn header(study: &str, settings: &Value) -> String {
    json!({"sweep": VERSION, "study": study, "program": PROGRAM, "settings": settings}).to_string()
}

/// Point and row of the JSON of a line. Only the point is parsed.
fn parts(json: &str) -> std::result::Result<(&str, &str), String> {
    const OTHER: &str = "no point and row";
    let rest = json.strip_prefix(r#"{"point":"#).ok_or(OTHER)?;
    let mut values = serde_json::Deserializer::from_str(rest).into_iter::<&RawValue>();
    let point = values.next().ok_or(OTHER)?.map_err(|why| format!("{OTHER}: {why}"))?;
    let row = rest[values.byte_offset()..].strip_prefix(r#","row":"#).and_then(|rest| rest.strip_suffix('}'));
    Ok((point.get(), row.ok_or(OTHER)?))
}

/// The row of a line that was checked.
pub(super) fn row(line: &str) -> std::result::Result<&str, String> {
    parts(check_and_json(line.as_bytes()).1).map(|(_, row)| row)
}

fn refused(path: &Path, line: usize, rule: impl Into<String>) -> Error {
    Error::Content { path: path.to_owned(), place: format!("line {line}"), rule: rule.into() }
}

/// A place after the first line.
fn place_at(bytes: u64) -> Offset {
    Offset::new(bytes).unwrap_or(Offset::MIN)
}

/// The hash of a point: FNV-1a, 128 bits.
pub(super) fn hash(point: &str) -> Hash {
    let step = |hash: u128, byte| (hash ^ u128::from(byte)).wrapping_mul(LONG_PRIME);
    let hash = point.bytes().fold(LONG_BASIS, step);
    [(hash >> 64) as u64, hash as u64]
}

/// FNV-1a, continued from the hash `from`. A change of one byte always changes the hash.
fn fnv(from: u64, text: &str) -> u64 {
    let [hash] = side_by_side(from, [text.as_bytes()]);
    hash
}

/// As [`fnv`], of several texts at once.
fn side_by_side<const N: usize>(from: u64, texts: [&[u8]; N]) -> [u64; N] {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(PRIME);
    let common = texts.iter().map(|text| text.len()).min().unwrap_or_default();
    let heads = texts.map(|text| &text[..common]);
    let mut hashes = [from; N];
    for k in 0..common {
        for (hash, head) in hashes.iter_mut().zip(heads) {
            *hash = step(*hash, &head[k]);
        }
    }
    std::array::from_fn(|lane| texts[lane][common..].iter().fold(hashes[lane], step))
}

/// The digits of a check, in hexadecimal.
fn digits(check: u64) -> [u8; 16] {
    std::array::from_fn(|k| b"0123456789abcdef"[(check >> (60 - 4 * k)) as usize & 15])
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
