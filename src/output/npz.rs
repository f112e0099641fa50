//! NPZ archives, as NumPy writes and reads them.

use crate::error::{Error, Result};
use npyz::{WriterBuilder, npz::NpzWriter};
use std::io::Cursor;

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
    let mut archive = NpzWriter::new(bytes);
    for array in arrays {
        let mut writer =
            archive.array(array.name, Default::default())?.default_dtype().shape(&array.shape).begin_nd()?;
        writer.extend(&array.values)?;
        writer.finish()?;
    }
    Ok(())
}
