//! Files and text: JSON with 17 significant digits, CSV, NPZ, and folders whose files are written
//! whole or not at all.

mod folder;
mod json;
mod npz;

pub use folder::Folder;
pub use json::to_json;
pub(crate) use json::write_json;
pub(crate) use npz::read_vectors;
pub use npz::{Archive, Array, NpzWriter, SETTINGS, npz, npz_with};

use crate::error::{Error, Result};
use std::{
    fs::File,
    io::{Read, Write, stderr},
    path::Path,
};

/// The bytes of a file with at most `most` bytes. A device, or a wrong file, is refused before it
/// fills the memory.
///
/// # Errors
/// Errors of the system; [`Error::Content`] for a file that is too long.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let fail = |source| Error::File { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    let length = File::open(path).map_err(fail)?.take(most + 1).read_to_end(&mut bytes).map_err(fail)?;
    if length as u64 > most {
        let rule = format!("longer than {} MiB, which it may have at most", most >> 20);
        return Err(Error::Content { path: path.to_owned(), place: "size".to_owned(), rule });
    }
    Ok(bytes)
}

/// Rows of numbers as CSV with a line of names; each number reads back to the same double.
pub fn csv(names: &[&str], rows: impl IntoIterator<Item = Vec<f64>>) -> Vec<u8> {
    let mut text = Vec::new();
    // Memory takes all that is written.
    let _ = write_csv(&mut text, names, rows);
    text
}

/// Writes the same text without having it in memory.
pub(crate) fn write_csv(
    mut to: impl Write,
    names: &[&str],
    rows: impl IntoIterator<Item = Vec<f64>>,
) -> std::io::Result<()> {
    writeln!(to, "{}", names.join(","))?;
    for row in rows {
        let cells: Vec<String> = row.iter().map(|value| format!("{value:e}")).collect();
        writeln!(to, "{}", cells.join(","))?;
    }
    Ok(())
}

/// A line on standard error, where all that is said beside results goes. If it cannot be written,
/// nobody can be told.
pub(crate) fn say(line: &str) {
    let _ = writeln!(stderr(), "{line}");
}
