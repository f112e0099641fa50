//! The file of a branch, written while the branch is followed.

use crate::{
    error::Result,
    interrupt,
    output::{Folder, say},
};
use std::time::{Duration, Instant};

/// Longest time between two writings.
const LATEST: Duration = Duration::from_secs(10);
/// Points after which the file is written in any case.
const POINTS: usize = 20;

/// Writes the file of a branch: with every twentieth point, whenever 10 s have gone by, at its end,
/// and when the process is asked to end.
pub(super) struct Autosave<'a> {
    folder: Option<&'a Folder>,
    file: &'static str,
    /// Files that an earlier run may have left: they belong to another branch.
    stale: Vec<String>,
    last: Instant,
    begun: bool,
}

impl<'a> Autosave<'a> {
    /// A keeper that writes to `folder`, if there is one.
    pub(super) fn new(folder: Option<&'a Folder>, file: &'static str, stale: Vec<String>) -> Self {
        Self { folder, file, stale, last: Instant::now(), begun: false }
    }

    /// Writes the file if it is due. `points` is the number of points of the branch so far, `bytes`
    /// makes the content of the file.
    pub(super) fn keep(&mut self, points: usize, ended: bool, bytes: impl FnOnce() -> Result<Vec<u8>>) {
        let Some(folder) = self.folder else { return };
        let late = self.last.elapsed() >= LATEST;
        if late || points.is_multiple_of(POINTS) || ended || interrupt::asked() {
            self.last = Instant::now();
            let cleared = if self.begun { Ok(()) } else { folder.remove(self.stale.iter().map(String::as_str)) };
            self.begun = true;
            let kept = cleared.and_then(|()| folder.write(self.file, &bytes()?));
            // A failed write does not stop the branch: its results are written at the end, or that
            // fails.
            kept.err().into_iter().for_each(|why| say(&format!("not kept so far: {why}")));
        }
    }
}
