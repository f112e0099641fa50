//! NPZ archives, as NumPy writes and reads them: NPY files in a zip archive with a fixed date, not
//! compressed unless that is asked for.
//!
//! A text may be among the arrays: one string of bytes without axes. In Python,
//! `json.loads(numpy.load(file)["settings.json"].item())` reads the settings.

use crate::error::{Error, Result};
use std::{
    collections::BTreeMap,
    io::{self, BufReader, Cursor, Read, Seek, Write},
    path::{Path, PathBuf},
};
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter, write::SimpleFileOptions};

/// A named array of an archive, with its entries in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Array<'a> {
    /// Name without the extension.
    pub name: &'a str,
    /// Lengths along the axes.
    pub shape: Vec<u64>,
    /// Entries, the last axis fastest.
    pub values: Vec<f64>,
}

impl<'a> Array<'a> {
    /// An array with one axis.
    pub fn vector(name: &'a str, values: Vec<f64>) -> Self {
        Self { name, shape: vec![values.len() as u64], values }
    }

    /// An array with rows of the same length.
    pub fn matrix<'r>(name: &'a str, rows: impl IntoIterator<Item = &'r [f64]>) -> Self {
        let (mut count, mut values) = (0, Vec::new());
        for row in rows {
            count += 1;
            values.extend_from_slice(row);
        }
        let columns = (values.len() as u64).checked_div(count).unwrap_or(0);
        Self { name, shape: vec![count, columns], values }
    }
}

/// Name of the text in an archive that says how its numbers were computed.
pub const SETTINGS: &str = "settings.json";

/// The bytes of an archive.
///
/// # Errors
/// Errors of the archive writer.
pub fn npz(arrays: &[Array<'_>]) -> Result<Vec<u8>> {
    archive(None, arrays)
}

/// The bytes of an archive that begins with a text.
///
/// # Errors
/// Errors of the archive writer.
pub fn npz_with(name: &str, text: &str, arrays: &[Array<'_>]) -> Result<Vec<u8>> {
    archive(Some((name, text)), arrays)
}

fn archive(text: Option<(&str, &str)>, arrays: &[Array<'_>]) -> Result<Vec<u8>> {
    in_memory(|bytes| {
        let mut archive = NpzWriter::new(bytes, text)?;
        for array in arrays {
            archive.begin(array.name, &array.shape)?;
            archive.row(&array.values)?;
        }
        archive.finish()
    })
}

/// The bytes of an archive that `content` writes.
pub fn in_memory(content: impl FnOnce(&mut Cursor<Vec<u8>>) -> io::Result<()>) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    content(&mut bytes).map_err(|source| Error::File { path: "npz archive".into(), source })?;
    Ok(bytes.into_inner())
}

/// An archive that is written array by array, and each array row by row, without a second copy in
/// memory.
pub struct NpzWriter<W: Write + Seek> {
    zip: ZipWriter<ToFirstError<W>>,
    /// Buffer for the bytes of up to [`BLOCK`] numbers.
    block: Vec<u8>,
    method: CompressionMethod,
}

impl<W: Write + Seek> NpzWriter<W> {
    /// An archive that begins with a text, `(name, text)`, if one is given.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn new(to: W, text: Option<(&str, &str)>) -> std::io::Result<Self> {
        let mut zip = ZipWriter::new(ToFirstError { to, failed: false });
        if let Some((name, text)) = text {
            zip.start_file(file_name(name), options(CompressionMethod::Stored))?;
            zip.write_all(&npy_head(&bytes_type(text.len()), &[]))?;
            zip.write_all(text.as_bytes())?;
        }
        Ok(Self { zip, block: Vec::new(), method: CompressionMethod::Stored })
    }

    /// The arrays that follow are deflated, or stored as they are.
    #[must_use]
    pub fn compress(self, compress: bool) -> Self {
        Self { method: if compress { CompressionMethod::Deflated } else { CompressionMethod::Stored }, ..self }
    }

    /// Begins an array; its rows follow by calls of [`row`](Self::row).
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn begin(&mut self, name: &str, shape: &[u64]) -> std::io::Result<()> {
        self.zip.start_file(file_name(name), options(self.method))?;
        self.zip.write_all(&npy_head(DOUBLE, shape))
    }

    /// Writes the next entries of the array, with the last axis fastest.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn row(&mut self, values: &[f64]) -> std::io::Result<()> {
        for part in values.chunks(BLOCK) {
            self.block.clear();
            self.block.extend(part.iter().flat_map(|value| value.to_le_bytes()));
            self.zip.write_all(&self.block)?;
        }
        Ok(())
    }

    /// Writes an array with one axis.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn vector(&mut self, name: &str, values: &[f64]) -> std::io::Result<()> {
        self.begin(name, &[values.len() as u64])?;
        self.row(values)
    }

    /// Writes an array of words, with one axis.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn words(&mut self, name: &str, words: &[String]) -> std::io::Result<()> {
        let longest = words.iter().map(|word| word.chars().count()).max().unwrap_or(0).max(1);
        self.zip.start_file(file_name(name), options(self.method))?;
        self.zip.write_all(&npy_head(&format!("<U{longest}"), &[words.len() as u64]))?;
        for word in words {
            let letters = word.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest);
            self.zip.write_all(&letters.flat_map(u32::to_le_bytes).collect::<Vec<_>>())?;
        }
        Ok(())
    }

    /// Writes a file of another kind, as it is.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn file(&mut self, name: &str, bytes: &[u8]) -> std::io::Result<()> {
        self.zip.start_file(name, options(self.method))?;
        self.zip.write_all(bytes)
    }

    /// Ends the archive.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn finish(self) -> std::io::Result<()> {
        let end = self.zip.finish()?;
        if end.failed { Err(io::ErrorKind::WriteZero.into()) } else { Ok(()) }
    }
}

fn options(method: CompressionMethod) -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(method).last_modified_time(DateTime::default()).large_file(true)
}

/// Writes up to the first error, and nothing after it: a `ZipWriter` that is dropped then ends its
/// archive, and would print the next error itself.
struct ToFirstError<W> {
    to: W,
    failed: bool,
}

impl<W> ToFirstError<W> {
    fn unless_failed<T>(&mut self, instead: T, work: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<T> {
        if self.failed {
            return Ok(instead);
        }
        let done = work(&mut self.to);
        self.failed = done.as_ref().is_err_and(|why| why.kind() != io::ErrorKind::Interrupted);
        done
    }
}

impl<W: Write> Write for ToFirstError<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.unless_failed(bytes.len(), |to| to.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.unless_failed((), Write::flush)
    }
}

impl<W: Seek> Seek for ToFirstError<W> {
    fn seek(&mut self, place: io::SeekFrom) -> io::Result<u64> {
        self.unless_failed(0, |to| to.seek(place))
    }
}

/// Count of numbers that are converted to bytes together.
const BLOCK: usize = 1 << 13;

/// The name of the member that holds an array.
fn file_name(array: &str) -> String {
    format!("{array}.npy")
}

/// The NPY type of a little-endian double.
const DOUBLE: &str = "<f8";

/// The NPY type of a string of `length` bytes.
fn bytes_type(length: usize) -> String {
    format!("|S{length}")
}

/// Length of the header of a text.
const TEXT_HEAD: usize = 128;

/// The header of a file of numbers or text: format 1.0 of NPY, a Python dictionary padded to a
/// multiple of 64 bytes.
///
/// Source: NumPy, `numpy.lib.format`.
pub fn npy_head(of: &str, shape: &[u64]) -> Vec<u8> {
    const PREFIX: usize = 10;
    let shape: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let mut text = format!("{{'descr': '{of}', 'fortran_order': False, 'shape': ({shape}), }}");
    let padded = (PREFIX + text.len() + 1).next_multiple_of(64) - PREFIX;
    text.push_str(&" ".repeat(padded - text.len() - 1));
    text.push('\n');
    let length = u16::try_from(padded).expect("an array has few axes").to_le_bytes();
    [&b"\x93NUMPY\x01\x00"[..], &length, text.as_bytes()].concat()
}

/// An archive that was read, with the CRC-32 of every member checked.
#[derive(Debug)]
pub struct Archive {
    path: PathBuf,
    members: BTreeMap<String, Vec<u8>>,
}

impl Archive {
    /// Reads the file `path`.
    ///
    /// # Errors
    /// A file that cannot be opened; [`Error::Content`] for a file that is not such an archive, or
    /// is damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let (file, length) = super::opened(path, |file| file.metadata().map(|about| (file, about.len())))?;
        Self::unpack(path, BufReader::new(file), length)
    }

    /// The archive in `bytes`; `path` names it in errors.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        Self::unpack(path, Cursor::new(bytes), bytes.len() as u64)
    }

    fn unpack(path: &Path, from: impl Read + Seek, length: u64) -> Result<Self> {
        let mut out = Self { path: path.to_owned(), members: BTreeMap::new() };
        let mut archive = ZipArchive::new(from)
            .map_err(|why| out.refused("archive", format!("not an NPZ file, or not all of it: {why}")))?;
        if archive.has_duplicate_names() {
            return Err(out.refused("archive", "two of its members have the same name"));
        }
        // Members are not compressed: all together they are not longer than the file.
        let mut left = length;
        for k in 0..archive.len() {
            let mut bytes = Vec::new();
            let unnamed = |why: zip::result::ZipError| out.refused(&format!("member {k}"), why.to_string());
            let mut member = archive.by_index(k).map_err(unnamed)?;
            let name = member.name().map_err(unnamed)?.into_owned();
            let damaged = |why: &dyn std::fmt::Display| out.refused(&name, format!("not as it was written: {why}"));
            (&mut member).take(left + 1).read_to_end(&mut bytes).map_err(|why| damaged(&why))?;
            left = left.checked_sub(bytes.len() as u64).ok_or_else(|| damaged(&"longer than the file"))?;
            out.members.insert(name, bytes);
        }
        Ok(out)
    }

    /// The error for content at `place` that breaks a rule.
    pub fn refused(&self, place: &str, rule: impl Into<String>) -> Error {
        Error::Content { path: self.path.clone(), place: place.to_owned(), rule: rule.into() }
    }

    /// A text of the archive.
    ///
    /// # Errors
    /// No text of that name, or one that is not UTF-8.
    pub fn text(&self, name: &str) -> Result<&str> {
        let bytes = self.member(name)?;
        let (head, text) = bytes.split_at(TEXT_HEAD.min(bytes.len()));
        if head != npy_head(&bytes_type(text.len()), &[]) {
            return Err(self.refused(name, format!("{} bytes that are not a text", bytes.len())));
        }
        std::str::from_utf8(text).map_err(|why| self.refused(name, why.to_string()))
    }

    /// An array of the given shape. Memory is allocated only after the length of the member is
    /// checked.
    ///
    /// # Errors
    /// No array of that name, or one of another type or shape.
    pub fn array(&self, name: &str, shape: &[u64]) -> Result<Vec<f64>> {
        let bytes = self.member(name)?;
        let other = || self.refused(name, format!("{} bytes that are not an array of {shape:?} doubles", bytes.len()));
        let size = shape.iter().try_fold(8, |size: u64, length| size.checked_mul(*length));
        let size = size.filter(|size| *size < bytes.len() as u64).ok_or_else(other)?;
        // The header says type and shape; only the form that is written here is accepted.
        let head = npy_head(DOUBLE, shape);
        if head.len() as u64 + size != bytes.len() as u64 || !bytes.starts_with(&head) {
            return Err(other());
        }
        let (values, _) = bytes[head.len()..].as_chunks();
        Ok(values.iter().map(|value| f64::from_le_bytes(*value)).collect())
    }

    fn member(&self, name: &str) -> Result<&[u8]> {
        self.members.get(&file_name(name)).map(Vec::as_slice).ok_or_else(|| self.refused(name, "it is missing"))
    }
}
