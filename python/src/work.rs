//! Work without the interpreter's lock: on a thread of its own, while the thread that asked for it
//! looks for signals and tells of progress.

use crate::error::panicked;
use hertzchain::interrupt::Token;
use pyo3::prelude::*;
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Condvar, Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    thread,
    time::Duration,
};

/// How long a signal waits at most until the work is asked to end.
const POLL: Duration = Duration::from_millis(50);

/// The share of the work that is done, and the flag that asks it to end.
pub(crate) struct Watched {
    share: AtomicU64,
    token: Token,
}

impl Watched {
    pub(crate) fn tell(&self, share: f64) {
        self.share.store(share.to_bits(), Ordering::Relaxed);
    }

    /// Asks the work to end.
    pub(crate) fn ask(&self) {
        self.token.ask();
    }
}

/// Where a thread leaves what it has computed.
struct Slot<T>(Mutex<Option<T>>, Condvar);

impl<T> Slot<T> {
    fn put(&self, value: T) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
        self.1.notify_one();
    }

    /// What is there, after waiting for it for a while.
    fn take(&self) -> Option<T> {
        let guard = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.1.wait_timeout_while(guard, POLL, |value| value.is_none());
        waited.unwrap_or_else(PoisonError::into_inner).0.take()
    }
}

/// Does work that takes less than a millisecond, in which nobody has to look for signals.
pub(crate) fn brief<T: Send>(py: Python<'_>, work: impl FnOnce(&Watched) -> T + Send) -> PyResult<T> {
    let watched = Watched { share: AtomicU64::new(0), token: Token::new() };
    let outcome = py.detach(|| catch_unwind(AssertUnwindSafe(|| watched.token.within(|| work(&watched)))));
    outcome.map_err(|panic| panicked(py, &*panic))
}

/// Does `work`, and calls `progress` with the share that is done a few times a second. The second
/// result is an exception that came meanwhile, such as KeyboardInterrupt: the work was then asked
/// to end, and the first result is what it had.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watched) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let watched = Watched { share: AtomicU64::new(0), token: Token::new() };
    let slot = Slot(Mutex::new(None), Condvar::new());
    let mut raised = None;
    let outcome = thread::scope(|scope| {
        scope.spawn(|| {
            let work = || watched.token.within(|| work(&watched));
            slot.put(catch_unwind(AssertUnwindSafe(work)));
        });
        loop {
            if let Some(outcome) = py.detach(|| slot.take()) {
                break outcome;
            }
            let told = || -> PyResult<()> {
                py.check_signals()?;
                let share = f64::from_bits(watched.share.load(Ordering::Relaxed));
                progress.map_or(Ok(()), |progress| progress.call1((share,)).map(|_| ()))
            };
            if let (Err(error), true) = (told(), raised.is_none()) {
                watched.ask();
                raised = Some(error);
            }
        }
    });
    outcome.map(|value| (value, raised)).map_err(|panic| panicked(py, &*panic))
}

/// As [`watched`], for work that leaves nothing when it is stopped.
pub(crate) fn finished<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watched) -> hertzchain::Result<T> + Send,
) -> PyResult<T> {
    use crate::error::OrRaise;
    match watched(py, progress, work)? {
        (_, Some(raised)) => Err(raised),
        (outcome, None) => outcome.or_raise(py),
    }
}
