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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Array, npz};

    /// The tag at `at`, small or not: type, range of its data, and where the next one is.
    fn tag(bytes: &[u8], at: usize) -> (u32, std::ops::Range<usize>, usize) {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        match word(at) >> 16 {
            0 => {
                let end = at + 8 + word(at + 4) as usize;
                (word(at), at + 8..end, end.next_multiple_of(8))
            }
            length => (word(at) & 0xffff, at + 4..at + 4 + length as usize, at + 8),
        }
    }

    #[test]
    fn a_file_has_the_arrays_of_the_archive_column_by_column() {
        let folder = tempfile::tempdir().unwrap();
        let from = folder.path().join("a.npz");
        let rows = [[1.0, 2.0, 3.0], [4.0, 5.0, f64::NAN]];
        let arrays = [Array::vector("t", vec![0.5, -1.0]), Array::matrix("strain", rows.iter().map(|row| &row[..]))];
        std::fs::write(&from, npz(&arrays).unwrap()).unwrap();
        let to = folder.path().join("a.mat");
        mat(&from, &mut File::create(&to).unwrap()).unwrap();
        let bytes = std::fs::read(to).unwrap();
        // Truth: the format, as its documentation has it.
        assert!(bytes.starts_with(b"MATLAB 5.0 MAT-file") && bytes[124..128] == *b"\x00\x01IM");
        let mut at = 128;
        let columns = [1.0, 4.0, 2.0, 5.0, 3.0, f64::NAN];
        for (name, lengths, values) in [("t", [2, 1], &[0.5, -1.0][..]), ("strain", [2, 3], &columns)] {
            let (kind, whole, next) = tag(&bytes, at);
            assert_eq!(kind, 14);
            let (kind, flags, at_lengths) = tag(&bytes, whole.start);
            assert_eq!((kind, &bytes[flags]), (6, &[6, 0, 0, 0, 0, 0, 0, 0][..]));
            let (kind, data, at_name) = tag(&bytes, at_lengths);
            assert_eq!((kind, &bytes[data]), (5, &[lengths[0], 0, 0, 0, lengths[1], 0, 0, 0][..]));
            let (kind, data, at_values) = tag(&bytes, at_name);
            assert_eq!((kind, &bytes[data]), (1, name.as_bytes()));
            let (kind, data, end) = tag(&bytes, at_values);
            let read: Vec<f64> = bytes[data].as_chunks().0.iter().map(|value| f64::from_le_bytes(*value)).collect();
            assert_eq!((kind, format!("{read:?}")), (9, format!("{values:?}")));
            assert_eq!((end, next), (whole.end, whole.end));
            at = next;
        }
        assert_eq!(at, bytes.len());
    }
}
