//! SIGINT and SIGTERM: the first asks the command to end and keep what it has, the second ends it
//! at once.

use crate::{error::Error, error::Result, interrupt};
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};
use std::sync::{
    Arc, LazyLock,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

/// The last signal that was caught; 0 for none.
static CAUGHT: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// From this call on, the first signal sets a flag that the computation checks, instead of ending
/// the process. Only for commands that check the flag.
pub(super) fn ask() -> Result<()> {
    let asked = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The shutdown is registered before the flag, so that the first signal finds the flag not
        // set.
        let registered = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&asked))
            .and_then(|_| flag::register_usize(signal, Arc::clone(&CAUGHT), signal as usize))
            .and_then(|_| flag::register(signal, Arc::clone(&asked)));
        registered
            .map_err(|why| Error::parameter("signal", why, "the system lets a program hear SIGINT and SIGTERM"))?;
    }
    interrupt::watch(asked);
    Ok(())
}

/// From this call on, a file that would grow beyond the limit of the process (`ulimit -f`) is an
/// error of writing it. The signal SIGXFSZ would end the process, and leave half a file.
pub(super) fn outlive_file_limits() {
    #[cfg(unix)]
    // Without it the signal ends the process: nothing to report.
    let _ = flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// The exit code of a command that was asked to end: 128 and the number of the signal, as shells
/// have it.
pub(super) fn exit_code() -> Option<u8> {
    match CAUGHT.load(Ordering::Relaxed) {
        0 => None,
        signal => Some(128 + signal as u8),
    }
}
