//! A folder for results.

use crate::error::{Error, Result};
use std::{
    fs::File,
    io::Write,
    path::{Path, PathBuf},
};
use tempfile::{Builder, NamedTempFile};

/// What begins the name of a file that is being written.
const UNFINISHED: &str = ".hertzchain-";

/// A folder that can be written to. Its files appear whole or not at all.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Makes the folder, and those above it, unless they are there; and checks that a file can be written.
    ///
    /// Call it before the work whose results it shall hold. What a process that was killed had not finished writing is removed.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self> {
        let folder = Self { path: path.into() };
        let fail = |source| Error::File { path: folder.path.clone(), source };
        std::fs::create_dir_all(&folder.path).map_err(fail)?;
        folder.unfinished().map_err(fail)?;
        folder.sweep();
        Ok(folder)
    }

    /// A file to be written, held by a lock as long as its process lives.
    fn unfinished(&self) -> std::io::Result<NamedTempFile> {
        let file = Builder::new().prefix(UNFINISHED).tempfile_in(&self.path)?;
        // Where files cannot be locked, leftovers stay.
        let _ = file.as_file().try_lock();
        Ok(file)
    }

    /// Removes the files that nobody is writing any more.
    fn sweep(&self) {
        let entries = std::fs::read_dir(&self.path).into_iter().flatten().flatten();
        for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(UNFINISHED)) {
            if File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok()) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file whole: a temporary file beside it, synced, then renamed.
    ///
    /// # Errors
    /// What the system says; the file is then as it was before.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf> {
        self.write_with(name, |file| file.write_all(bytes))
    }

    /// The same with a file that is written bit by bit, by `content`.
    ///
    /// # Errors
    /// What the system says, or `content`; the file is then as it was before.
    pub fn write_with(&self, name: &str, content: impl FnOnce(&mut File) -> std::io::Result<()>) -> Result<PathBuf> {
        let path = self.path.join(name);
        let fail = |source| Error::File { path: path.clone(), source };
        let mut file = self.unfinished().map_err(fail)?;
        content(file.as_file_mut()).and_then(|()| file.as_file().sync_all()).map_err(fail)?;
        #[cfg(unix)]
        {
            // A temporary file is for its owner only; a result is for whom the folder is.
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644)).map_err(fail)?;
        }
        file.persist(&path).map_err(|error| fail(error.error))?;
        Ok(path)
    }
}
