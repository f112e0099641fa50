//! A folder for results.

use crate::error::{Error, Result};
use std::{
    fs::File,
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
    sync::Arc,
};
use tempfile::{Builder, NamedTempFile};

/// First characters of the name of a file that is being written.
const UNFINISHED: &str = ".hertzchain-";

/// A folder for results. Its files appear whole or not at all; a folder that was created for them
/// and got none is removed when it is dropped.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    _created: Arc<Created>,
}

/// The folders that were created, the innermost first. Those that are empty are removed on drop.
#[derive(Debug)]
struct Created(Vec<PathBuf>);

impl Drop for Created {
    fn drop(&mut self) {
        // A folder that holds something is not removed.
        self.0.iter().for_each(|path| drop(std::fs::remove_dir(path)));
    }
}

impl Folder {
    /// Creates the folder and those above it, unless they exist, and checks that a file can be
    /// written in it.
    ///
    /// Call it before the computation whose results it shall hold. Unfinished files of killed
    /// processes are removed.
    ///
    /// # Errors
    /// A file that has the name of the folder, or of one above it; errors of the system.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        let missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let created = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        let folder = Self { path, _created: Arc::new(Created(created)) };
        let fail = |source| Error::File { path: folder.path.clone(), source };
        if let Some(other) = folder.path.ancestors().find(|path| path.exists() && !path.is_dir()) {
            let rule = format!("results are written to a folder, and {} is none", other.display());
            return Err(fail(std::io::Error::other(rule)));
        }
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

    /// Removes the files of these names that are there: what an earlier run has left.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn remove<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<()> {
        names.into_iter().try_for_each(|name| {
            let path = self.path.join(name);
            match std::fs::remove_file(&path) {
                Err(source) if source.kind() != ErrorKind::NotFound => Err(Error::File { path, source }),
                _ => Ok(()),
            }
        })
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
