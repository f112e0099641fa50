//! NPZ archives, as NumPy writes and reads them: NPY files in a zip archive, not compressed, with a fixed date.

use crate::error::{Error, Result};
use npyz::{WriterBuilder, npz::file_name_from_array_name};
use std::io::Cursor;
use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

/// A named array of an archive, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Array<'a> {
    /// Name.
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

/// The bytes of an archive.
///
/// # Errors
/// What the archive writer says.
pub fn npz(arrays: &[Array<'_>]) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    write(&mut bytes, arrays).map_err(|source| Error::File { path: "npz archive".into(), source })?;
    Ok(bytes.into_inner())
}

fn write(bytes: &mut Cursor<Vec<u8>>, arrays: &[Array<'_>]) -> std::io::Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .large_file(true);
    let mut archive = ZipWriter::new(bytes);
    for array in arrays {
        archive.start_file(file_name_from_array_name(array.name), options)?;
        let mut writer =
            npyz::WriteOptions::new().default_dtype().shape(&array.shape).writer(&mut archive).begin_nd()?;
        writer.extend(&array.values)?;
        writer.finish()?;
    }
    archive.finish()?;
    Ok(())
}
