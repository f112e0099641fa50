//! Flags that ask work to end. Every [`Stepper`](crate::Stepper) reads them at each step and fails
//! with [`Error::Stopped`]; sweeps, branches and searches read them between runs, stop, and keep
//! what they have computed.
//!
//! The process has one flag, which a signal handler sets. A thread may have a flag of its own while
//! it does a piece of work, so that one piece can be stopped without the others.

use crate::error::Error;
use std::{
    cell::RefCell,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, RecvTimeoutError},
    },
    thread,
    time::{Duration, Instant},
};

/// Time between two looks at the flags.
const LOOK: Duration = Duration::from_millis(20);

static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();

thread_local! {
    static OWN: RefCell<Token> = const { RefCell::new(Token { flag: None, deadline: None, deaf: false }) };
}

/// Registers the flag of the process, which a signal handler sets. Only the first call has an
/// effect.
pub fn watch(flag: Arc<AtomicBool>) {
    let _ = FLAG.set(flag);
}

/// Whether the work of this thread is asked to end: by the flag of the thread or that of the
/// process.
pub fn asked() -> bool {
    OWN.with_borrow(Token::asked)
}

/// Fails if the work of this thread is asked to end; `t` is the time that a run has reached.
///
/// # Errors
/// [`Error::Stopped`].
pub fn check(t: f64) -> Result<(), Error> {
    if asked() { Err(Error::Stopped { t }) } else { Ok(()) }
}

/// The result of `work`, which reads no flag; `None` if the work of this thread is asked to end
/// meanwhile. The other then goes on, on a thread of its own, as long as the process.
pub fn unless_asked<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    let (done, result) = mpsc::channel();
    thread::spawn(move || done.send(work()));
    loop {
        match result.recv_timeout(LOOK) {
            Err(RecvTimeoutError::Timeout) if !asked() => {}
            result => return result.ok(),
        }
    }
}

/// The flag of the work of this thread: to read it often, or to hand it to threads that take part
/// in the work.
pub fn token() -> Token {
    OWN.with_borrow(Clone::clone)
}

/// A flag that asks a piece of work to end. The default has no flag of its own, only that of the
/// process.
#[derive(Clone, Debug, Default)]
pub struct Token {
    flag: Option<Arc<AtomicBool>>,
    deadline: Option<Instant>,
    deaf: bool,
}

impl Token {
    /// A flag that is never set: for work that is short and whose result is needed all the same.
    #[must_use]
    pub fn deaf() -> Self {
        Self { deaf: true, ..Self::default() }
    }

    /// A new flag, not set.
    ///
    /// ```
    /// use hertzchain_integrators::interrupt::{Token, asked};
    /// let (one, other) = (Token::new(), Token::new());
    /// one.ask();
    /// assert_eq!((one.within(asked), other.within(asked), asked()), (true, false, false));
    /// ```
    pub fn new() -> Self {
        Self { flag: Some(Arc::default()), ..Self::default() }
    }

    /// The flag of the work of this thread, which also asks to end once the time is over, in
    /// seconds of the wall clock.
    ///
    /// ```
    /// use hertzchain_integrators::interrupt::{Token, asked};
    /// assert!(Token::timed(0.0).within(asked) && !Token::timed(1e300).within(asked));
    /// ```
    #[must_use]
    pub fn timed(seconds: f64) -> Self {
        let time = Duration::try_from_secs_f64(seconds).ok();
        let end = time.and_then(|time| Instant::now().checked_add(time));
        let own = token();
        Self { deadline: own.deadline.into_iter().chain(end).min(), ..own }
    }

    /// Sets the token's own flag, if it has one; never that of the process.
    pub fn ask(&self) {
        self.flag.iter().for_each(|flag| flag.store(true, Ordering::Relaxed));
    }

    /// Whether this flag or that of the process is set, or its time is over.
    pub fn asked(&self) -> bool {
        let set = || self.flag.iter().chain(FLAG.get()).any(|flag| flag.load(Ordering::Relaxed));
        !self.deaf && (set() || self.deadline.is_some_and(|end| Instant::now() >= end))
    }

    /// Does a piece of work on this thread; within it, [`asked`] reads this flag.
    pub fn within<T>(&self, work: impl FnOnce() -> T) -> T {
        /// Gives the thread its flag back, also if the work panics.
        struct Before(Token);
        impl Drop for Before {
            fn drop(&mut self) {
                OWN.set(std::mem::take(&mut self.0));
            }
        }
        let _before = Before(OWN.replace(self.clone()));
        work()
    }
}
