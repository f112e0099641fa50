//! The one door to standard output, and the progress bar. A lint keeps all other code from
//! printing.

use crate::{
    error::{Error, Result},
    output::harmless,
};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{ErrorKind, Result as Written, Write, stdout};
use terminal_size::{Width, terminal_size_of};

/// Writes results to standard output. A reader that closes the pipe early, as `head` does, is no
/// error.
///
/// # Errors
/// An error that keeps the text from being written whole, such as a full disk.
pub(super) fn print(text: &str) -> Result<()> {
    checked(stdout().lock().write_all(harmless(text).as_bytes()))
}

/// Characters of a line of standard output: those of the terminal, or as many as one likes.
pub(super) fn columns() -> usize {
    terminal_size_of(stdout()).map_or(usize::MAX, |(Width(width), _)| usize::from(width.max(1)))
}

/// Writes help or the version, in colours where the terminal has them.
///
/// # Errors
/// As [`print`].
pub(super) fn print_help(help: &clap::Error) -> Result<()> {
    checked(help.print())
}

fn checked(written: Written<()>) -> Result<()> {
    match written.and_then(|()| stdout().flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(Error::File { path: "standard output".into(), source })
        }
        _ => Ok(()),
    }
}

/// A bar on standard error, seen only on a terminal.
pub(super) fn progress_bar() -> ProgressBar {
    let bar = ProgressBar::new(1000);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    bar
}
