//! The stamp of files that are read again.

use super::{Archive, SETTINGS};
use crate::error::Result;
use serde::{Deserialize, de::DeserializeOwned};
use std::fmt::Display;

/// The program and its version, as its files name it.
pub const PROGRAM: &str = concat!("hertzchain ", env!("CARGO_PKG_VERSION"));

/// Name and version of a format. A version is read by the programs that write it, and by no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileFormat(pub &'static str, pub u64);

/// The keys of settings that say which programs may read them; they are read before all others.
#[derive(Deserialize)]
#[serde(expecting = "the settings of a file")]
struct Stamp {
    format: String,
    version: u64,
}

impl FileFormat {
    /// Refuses a file of another format or version.
    pub fn check(self, format: &str, version: u64) -> std::result::Result<(), String> {
        let Self(known, number) = self;
        if (format, version) == (known, number) {
            return Ok(());
        }
        let advice = if format == known { ": compute it anew" } else { "" };
        Err(format!("{format}, version {version}; read is {known}, version {number}{advice}"))
    }

    /// The settings of an archive, of which format and version are keys.
    pub fn read<T: DeserializeOwned>(self, file: &Archive) -> Result<T> {
        let refused = |why: &dyn Display| file.refused(SETTINGS, why.to_string());
        let text = file.text(SETTINGS)?;
        let stamp: Stamp = serde_json::from_str(text).map_err(|why| refused(&why))?;
        self.check(&stamp.format, stamp.version).map_err(|why| refused(&why))?;
        serde_json::from_str(text).map_err(|why| refused(&why))
    }
}
