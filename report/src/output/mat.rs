//! MAT files of version 5, not compressed, which MATLAB, Octave, Julia and R read.
//!
//! Source: MathWorks, *MAT-File Format*, chapter 1.

use std::{
    fs::File,
    io::{self, BufWriter, Read, Write},
    path::Path,
};
use zip::ZipArchive;

// Types of data in a file, and classes of arrays.
const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const SINGLE: u32 = 7;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const DOUBLES: u32 = 6;
const SINGLES: u32 = 7;

/// Writes the arrays of an NPZ archive that the program has written, by their names and in their
/// precision; an array with one axis becomes a column.
///
/// # Errors
/// Errors of the system; an array of 4 GiB or more, which the format cannot hold.
pub fn mat(npz: &Path, out: &mut File) -> io::Result<()> {
    let mut archive = ZipArchive::new(File::open(npz)?)?;
    let mut out = BufWriter::new(out);
    let text = concat!("MATLAB 5.0 MAT-file, hertzchain ", env!("CARGO_PKG_VERSION"));
    write!(out, "{text:<116}")?;
    // No data of subsystems; version 1; little-endian.
    out.write_all(b"\0\0\0\0\0\0\0\0\0\x01IM")?;
    for k in 0..archive.len() {
        let (mut member, mut bytes) = (archive.by_index(k)?, Vec::new());
        member.read_to_end(&mut bytes)?;
        out.write_all(&matrix(member.name()?.trim_end_matches(".npy"), &bytes)?)?;
    }
    out.flush()
}

/// The element of an array, from its NPY file, whose entries are in row-major order.
fn matrix(name: &str, npy: &[u8]) -> io::Result<Vec<u8>> {
    let (head, entries) = npy.split_at(10 + usize::from(u16::from_le_bytes([npy[8], npy[9]])));
    let head = String::from_utf8_lossy(&head[10..]);
    let (_, shape) = head.split_once("'shape': (").unwrap_or_default();
    let mut shape = shape.split([',', ')']).map_while(|length| length.trim().parse::<usize>().ok());
    let (rows, columns) = (shape.next().unwrap_or(1), shape.next().unwrap_or(1));
    let (kind, class, size) = if head.contains("<f4") { (SINGLE, SINGLES, 4) } else { (DOUBLE, DOUBLES, 8) };
    let columnwise = (0..columns).flat_map(|j| (0..rows).map(move |i| size * (i * columns + j)));
    let values: Vec<u8> = columnwise.flat_map(|at| &entries[at..at + size]).copied().collect();
    let lengths = [rows, columns].map(|length| (length as u32).to_le_bytes()).concat();
    let parts = [
        element(UINT32, &[class.to_le_bytes(), [0; 4]].concat())?,
        element(INT32, &lengths)?,
        element(INT8, name.as_bytes())?,
        element(kind, &values)?,
    ];
    element(MATRIX, &parts.concat())
}

/// A tag with type and length, and the data up to a multiple of 8 bytes; up to 4 bytes of data are
/// inside the tag.
fn element(kind: u32, data: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(data.len()).map_err(|_| io::Error::other("a MAT file has no array of 4 GiB"))?;
    let small = (1..=4).contains(&length);
    let tag = if small { vec![kind | length << 16] } else { vec![kind, length] };
    let mut bytes: Vec<u8> = tag.into_iter().flat_map(u32::to_le_bytes).chain(data.iter().copied()).collect();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    Ok(bytes)
}
