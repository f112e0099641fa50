//! A folder for results.

use crate::error::{Error, Result};
use std::{
    io::Write,
    path::{Path, PathBuf},
};
use tempfile::NamedTempFile;

/// A folder that can be written to. Its files appear whole or not at all.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Makes the folder, and those above it, unless they are there; and checks that a file can be written.
    ///
    /// Call it before the work whose results it shall hold.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self> {
        let folder = Self { path: path.into() };
        let fail = |source| Error::File { path: folder.path.clone(), source };
        std::fs::create_dir_all(&folder.path).map_err(fail)?;
        NamedTempFile::new_in(&folder.path).map_err(fail)?;
        Ok(folder)
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
        let path = self.path.join(name);
        let fail = |source| Error::File { path: path.clone(), source };
        let mut file = NamedTempFile::new_in(&self.path).map_err(fail)?;
        file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(fail)?;
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
