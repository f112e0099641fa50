//! A folder for results.

use super::is_at;
use crate::error::{Error, Result};
use std::{
    fs::{DirEntry, File, OpenOptions, TryLockError, read_to_string},
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
    sync::Arc,
};
use tempfile::{Builder, NamedTempFile};

/// First characters of the name of a file that is being written.
const UNFINISHED: &str = ".hertzchain-";
/// Name of the file that the owner of a folder has locked; with a dash and the name of a part, of
/// that of an owner of a part. It says who that is.
const LOCK: &str = ".hertzchain-lock";
/// Extensions of the files that are written to folders.
const KINDS: [&str; 10] = ["csv", "html", "json", "npz", "png", "store", "svg", "toml", "txt", "zip"];

/// A folder for results. Its files appear whole or not at all; a folder that was created for them
/// and got none is removed when it is dropped.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    kept: Arc<Claim>,
}

/// What ends with the last clone of a folder.
#[derive(Debug)]
struct Claim {
    /// The folders that were created, the innermost first. Those that are empty are removed.
    created: Vec<PathBuf>,
    /// Locked files. Those that no other process has locked are removed.
    locks: Vec<(PathBuf, File)>,
}

impl Drop for Claim {
    fn drop(&mut self) {
        for (path, file) in self.locks.drain(..).rev() {
            if file.try_lock().is_ok() {
                let _ = std::fs::remove_file(path);
            }
        }
        // A folder that holds something is not removed.
        self.created.iter().for_each(|path| drop(std::fs::remove_dir(path)));
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
    /// A file that has the name of the folder, or of one above it, or a link that leads nowhere;
    /// in the folder, anything else than a file, such as a folder or a pipe, with the extension of
    /// a file of results; errors of the system.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        let missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let created = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        let folder = Self { path, kept: Arc::new(Claim { created, locks: Vec::new() }) };
        let fail = |source| Error::File { path: folder.path.clone(), source };
        let there = |path: &&Path| path.exists() || path.is_symlink();
        if let Some(other) = folder.path.ancestors().filter(there).find(|path| !path.is_dir()) {
            let rule = format!("results are written to a folder, and {} is none", other.display());
            return Err(fail(std::io::Error::other(rule)));
        }
        std::fs::create_dir_all(&folder.path).map_err(fail)?;
        folder.unfinished().map_err(fail)?;
        folder.sweep();
        let in_the_way = |entry: &DirEntry| {
            let path = entry.path();
            path.extension().is_some_and(|kind| KINDS.iter().any(|known| kind == *known)) && !path.is_file()
        };
        if let Some(entry) = folder.entries("").find(in_the_way) {
            let source = std::io::Error::other("in the place of a file of results, and no file: move it away");
            return Err(Error::File { path: entry.path(), source });
        }
        Ok(folder)
    }

    /// As [`create`](Self::create), for this process alone, until the last clone of the folder is
    /// dropped or the process ends, however it ends. Owners of parts, such as the shard `1/2`,
    /// share the folder.
    ///
    /// # Errors
    /// As [`create`](Self::create); a folder, or a part, that another process owns, with its number
    /// and its machine.
    pub fn own(path: impl Into<PathBuf>, part: Option<&str>) -> Result<Self> {
        let mut folder = Self::create(path)?;
        let mut locks = vec![folder.lock(LOCK, if part.is_some() { File::try_lock_shared } else { File::try_lock })?];
        match part {
            Some(part) => locks.push(folder.lock(&format!("{LOCK}-{}", part.replace('/', "-of-")), File::try_lock)?),
            // No part has an owner now.
            None => folder.entries(&format!("{LOCK}-")).for_each(|entry| drop(std::fs::remove_file(entry.path()))),
        }
        // What is lost if this cannot be written is a name in the message of a refusal.
        locks.iter().for_each(|(_, file)| drop(file.set_len(0)));
        if let Some((_, file)) = locks.last_mut() {
            let machine = read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
            let who = format!("process {} on {}", std::process::id(), machine.trim());
            let _ = file.write_all(who.as_bytes());
        }
        if let Some(kept) = Arc::get_mut(&mut folder.kept) {
            kept.locks = locks;
        }
        Ok(folder)
    }

    /// Opens and locks a file of the folder.
    fn lock(&self, name: &str, lock: fn(&File) -> std::result::Result<(), TryLockError>) -> Result<(PathBuf, File)> {
        let path = self.path.join(name);
        loop {
            let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let file = open.map_err(|source| Error::File { path: path.clone(), source })?;
            match lock(&file) {
                Err(TryLockError::WouldBlock) => return Err(self.in_use()),
                // Where files cannot be locked, no check is possible.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            // Between opening and locking, the last owner may have removed it.
            if is_at(&file, &path) {
                return Ok((path, file));
            }
        }
    }

    /// The error for a folder that others own, with what their locked files say.
    fn in_use(&self) -> Error {
        let held = |path: &PathBuf| File::open(path).is_ok_and(|file| file.try_lock().is_err());
        let paths = self.entries(LOCK).map(|entry| entry.path()).filter(held);
        let mut owners: Vec<String> = paths.filter_map(|path| read_to_string(path).ok()).collect();
        owners.retain(|owner| !owner.is_empty());
        owners.sort_unstable();
        let who = if owners.is_empty() { String::new() } else { format!(" ({})", owners.join(", ")) };
        let rule = format!("in use by another run{who}: wait until it has ended");
        Error::Content { path: self.path.clone(), place: "folder".to_owned(), rule }
    }

    /// What is in the folder with a name that begins so.
    fn entries(&self, start: &str) -> impl Iterator<Item = DirEntry> {
        let here = if self.path.as_os_str().is_empty() { Path::new(".") } else { &self.path };
        let entries = std::fs::read_dir(here).into_iter().flatten().flatten();
        entries.filter(move |entry| entry.file_name().to_string_lossy().starts_with(start))
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
        let lock = |entry: &DirEntry| entry.file_name().to_string_lossy().starts_with(LOCK);
        for entry in self.entries(UNFINISHED).filter(|entry| !lock(entry)) {
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
