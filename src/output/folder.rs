//! A folder for results.

use crate::error::{Error, Result};
use std::{
    fs::File,
    io::Write,
    path::{Path, PathBuf},
};
use tempfile::{Builder, NamedTempFile};

/// First characters of the name of a file that is being written.
const UNFINISHED: &str = ".hertzchain-";

/// A folder for results. Its files appear whole or not at all.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Creates the folder and those above it, unless they exist, and checks that a file can be
    /// written in it.
    ///
    /// Call it before the computation whose results it shall hold. Unfinished files of killed
    /// processes are removed.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self> {
        let folder = Self { path: path.into() };
        let fail = |source| Error::File { path: folder.path.clone(), source };
        std::fs::create_dir_all(&folder.path).map_err(fail)?;
        folder.unfinished().map_err(fail)?;
        folder.sweep();
        Ok(folder)
    }

    /// A temporary file, locked as long as its process lives.
    fn unfinished(&self) -> std::io::Result<NamedTempFile> {
        let file = Builder::new().prefix(UNFINISHED).tempfile_in(&self.path)?;
        // Where files cannot be locked, unfinished files stay.
        let _ = file.as_file().try_lock();
        Ok(file)
    }

    /// Removes temporary files whose process has ended.
    fn sweep(&self) {
        let entries = std::fs::read_dir(&self.path).into_iter().flatten().flatten();
        for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(UNFINISHED)) {
            if File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok()) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// The path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file whole: a temporary file in the same folder is written, synced and renamed.
    ///
    /// # Errors
    /// Errors of the system; the file is then as it was before.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf> {
        self.write_with(name, |file| file.write_all(bytes))
    }

    /// Writes a file whole, with the closure `content` writing it in parts.
    ///
    /// # Errors
    /// Errors of the system or of `content`; the file is then as it was before.
    pub fn write_with(&self, name: &str, content: impl FnOnce(&mut File) -> std::io::Result<()>) -> Result<PathBuf> {
        let path = self.path.join(name);
        let fail = |source| Error::File { path: path.clone(), source };
        let mut file = self.unfinished().map_err(fail)?;
        content(file.as_file_mut()).and_then(|()| file.as_file().sync_all()).map_err(fail)?;
        #[cfg(unix)]
        {
            // A temporary file is readable by its owner only; a result is readable by everybody.
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644)).map_err(fail)?;
        }
        file.persist(&path).map_err(|error| fail(error.error))?;
        Ok(path)
    }
}
