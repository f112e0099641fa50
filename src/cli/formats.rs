//! `--format`: which files a picture becomes.

use crate::{
    error::Result,
    figures::Format,
    output::Folder,
    study::{
        Drawing, File,
        options::{one, options},
    },
};

options! {
    pub(super) struct Formats {
        /// Formats of pictures, separated by commas: png, svg
        format: Vec<Format> = vec![Format::Png], "F,..", [hide_short_help = true];
    }
}
one!(Format: |name: &str| name.parse::<Format>());

impl Formats {
    /// The formats that are asked for, each once.
    pub(super) fn chosen(&self) -> impl Iterator<Item = Format> {
        Format::ALL.into_iter().filter(|format| self.format.contains(format))
    }

    /// The files of pictures, in the formats that are asked for.
    pub(super) fn files(&self, drawings: &[Drawing]) -> Result<Vec<File>> {
        let pairs = drawings.iter().flat_map(|drawing| self.chosen().map(move |format| (drawing, format)));
        pairs.map(|((name, picture), format)| Ok((format.name(name), picture.file(format)?))).collect()
    }

    /// Writes pictures to a folder, and removes files of the same pictures in other formats that an
    /// earlier run has left. Returns the names of the files written.
    pub(super) fn write(&self, folder: &Folder, drawings: &[Drawing]) -> Result<Vec<String>> {
        let files = self.files(drawings)?;
        let all = drawings.iter().flat_map(|(name, _)| names(name));
        let left: Vec<String> = all.filter(|name| files.iter().all(|file| file.0 != *name)).collect();
        folder.remove(left.iter().map(String::as_str))?;
        files.iter().try_for_each(|(name, bytes)| folder.write(name, bytes).map(drop))?;
        Ok(files.into_iter().map(|(name, _)| name).collect())
    }
}

/// If `name` is the name of a PNG file, the names of that picture's file in every format; otherwise
/// `name` alone.
pub(super) fn names(name: &str) -> Vec<String> {
    if name.ends_with(".png") {
        Format::ALL.iter().map(|format| format.name(name)).collect()
    } else {
        vec![name.to_owned()]
    }
}
