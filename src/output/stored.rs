//! The stamp of files that are read again.

use super::{Archive, SETTINGS};
use crate::error::Result;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::{Map, Value};
use std::fmt::Display;

/// The program and its version, as its files name it.
pub const PROGRAM: &str = concat!("hertzchain ", env!("CARGO_PKG_VERSION"));

/// Name and version of a format. A version is read by the programs that write it, and by no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileFormat(pub &'static str, pub u64);

/// Settings with the keys that come before them.
#[derive(Serialize, Deserialize)]
#[serde(expecting = "the settings of a file")]
struct Stamped<T> {
    format: String,
    version: u64,
    program: String,
    #[serde(flatten)]
    settings: T,
}

impl FileFormat {
    /// Settings, with format, version and program as their first keys.
    pub(crate) fn stamped(self, settings: impl Serialize) -> impl Serialize {
        Stamped { format: self.0.to_owned(), version: self.1, program: PROGRAM.to_owned(), settings }
    }

    /// Refuses a file of another format or version.
    pub(crate) fn check(self, format: &str, version: u64) -> std::result::Result<(), String> {
        let Self(known, number) = self;
        if (format, version) == (known, number) {
            return Ok(());
        }
        Err(format!("{format}, version {version}; read is {known}, version {number}: compute it anew"))
    }

    /// The settings of an archive, and the program that has written it.
    pub(crate) fn read<T: DeserializeOwned>(self, file: &Archive) -> Result<(T, String)> {
        let refused = |why: &dyn Display| file.refused(SETTINGS, why.to_string());
        let read: Stamped<Map<String, Value>> =
            serde_json::from_str(file.text(SETTINGS)?).map_err(|why| refused(&why))?;
        self.check(&read.format, read.version).map_err(|why| refused(&why))?;
        // Only a type that is not flattened refuses unknown keys.
        let settings = T::deserialize(Value::Object(read.settings)).map_err(|why| refused(&why))?;
        Ok((settings, read.program))
    }
}
