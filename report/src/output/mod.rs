//! Files and text: JSON with 17 significant digits, CSV, NPZ, and folders whose files are
//! written whole or not at all.

mod folder;
mod json;
pub(crate) mod npz;
mod stored;

pub use folder::Folder;
pub use json::to_json;
pub use json::write_json;
pub use npz::in_memory;
pub use npz::{Archive, Array, NpzWriter, SETTINGS, npz, npz_with};
pub use stored::{FileFormat, PROGRAM};

use crate::error::{Error, Result};
use hertzchain_core::interrupt;
use std::{
    borrow::Cow,
    fs::{File, metadata},
    io::{self, Read, Write, stderr},
    path::Path,
};

/// The bytes of a file with at most `most` bytes. A device, or a wrong file, is refused before it
/// fills the memory.
///
/// # Errors
/// Errors of the system; [`Error::Content`] for a file that is too long.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let bytes = opened(path, move |file| {
        let mut bytes = Vec::new();
        file.take(most + 1).read_to_end(&mut bytes).map(|_| bytes)
    })?;
    if bytes.len() as u64 > most {
        let rule = format!("longer than {} MiB, which it may have at most", most >> 20);
        return Err(Error::Content { path: path.to_owned(), place: "size".to_owned(), rule });
    }
    Ok(bytes)
}

/// What `work` makes of a file. A pipe without a writer is waited for until the process is asked to
/// end.
///
/// # Errors
/// Errors of the system, and of the work.
pub(crate) fn opened<T: Send + 'static>(
    path: &Path,
    work: impl FnOnce(File) -> io::Result<T> + Send + 'static,
) -> Result<T> {
    let whole = |path: &Path| File::open(path).and_then(work);
    let (own, at_once) = (path.to_owned(), metadata(path).map_or(true, |about| about.is_file()));
    let done = if at_once { Some(whole(path)) } else { interrupt::unless_asked(move || whole(&own)) };
    let stopped = || Err(io::Error::new(io::ErrorKind::Interrupted, "stopped by a signal before it was read"));
    done.unwrap_or_else(stopped).map_err(|source| Error::File { path: path.to_owned(), source })
}

/// Rows of numbers as CSV with a line of names; each number reads back to the same double.
pub fn csv(names: &[&str], rows: impl IntoIterator<Item = Vec<f64>>) -> Vec<u8> {
    let mut text = Vec::new();
    // Writing to memory cannot fail.
    let _ = write_csv(&mut text, names, rows);
    text
}

/// Writes the text of [`csv`] without holding it in memory.
pub fn write_csv(to: impl Write, names: &[&str], rows: impl IntoIterator<Item = Vec<f64>>) -> io::Result<()> {
    let mut to = io::BufWriter::new(to);
    writeln!(to, "{}", names.join(","))?;
    for row in rows {
        let cells: Vec<String> = row.iter().map(|value| format!("{value:e}").to_lowercase()).collect();
        writeln!(to, "{}", cells.join(","))?;
    }
    to.flush()
}

/// A text without characters that a terminal obeys: U+FFFD in place of control characters other
/// than tabs and ends of lines.
pub fn harmless(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| c.is_control() && c != '\n' && c != '\t';
    if text.contains(obeyed) { text.replace(obeyed, "\u{fffd}").into() } else { text.into() }
}

/// Writes a line to standard error, where all messages go that are not results. An error is
/// ignored, since it could not be reported.
pub fn say(line: &str) {
    let _ = writeln!(stderr(), "{}", harmless(line));
}

/// Whether the open file is still the one of this path.
#[cfg(unix)]
pub fn is_at(file: &File, path: &Path) -> bool {
    use std::{fs::Metadata, os::unix::fs::MetadataExt};
    let inode = |file: std::io::Result<Metadata>| file.ok().map(|file| (file.dev(), file.ino()));
    inode(file.metadata()) == inode(std::fs::metadata(path))
}

/// On other systems a file that is open is not replaced.
#[cfg(not(unix))]
pub fn is_at(_: &File, _: &Path) -> bool {
    true
}
