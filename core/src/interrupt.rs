//! Flags that ask work to end. Runs, sweeps and branches read them, stop, and keep what they have
//! computed.
//!
//! The process has one flag, which a signal handler sets. A thread may have a flag of its own while
//! it does a piece of work, so that one piece can be stopped without the others.

use std::{
    cell::RefCell,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
};

static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();

thread_local! {
    static OWN: RefCell<Token> = const { RefCell::new(Token(None)) };
}

/// Registers the flag of the process, which a signal handler sets. Only the first call has an
/// effect.
pub fn watch(flag: Arc<AtomicBool>) {
    let _ = FLAG.set(flag);
}

/// Whether the work of this thread is asked to end: by the flag of the thread or that of the
/// process.
pub fn asked() -> bool {
    token().asked()
}

/// The flag of the work of this thread: to read it often, or to hand it to threads that take part
/// in the work.
pub fn token() -> Token {
    OWN.with_borrow(Clone::clone)
}

/// A flag that asks a piece of work to end. The default has no flag of its own, only that of the
/// process.
#[derive(Clone, Debug, Default)]
pub struct Token(Option<Arc<AtomicBool>>);

impl Token {
    /// A new flag, not set.
    ///
    /// ```
    /// use hertzchain_core::interrupt::{Token, asked};
    /// let (one, other) = (Token::new(), Token::new());
    /// one.ask();
    /// assert_eq!((one.within(asked), other.within(asked), asked()), (true, false, false));
    /// ```
    pub fn new() -> Self {
        Self(Some(Arc::default()))
    }

    /// Sets the token's own flag, if it has one; never that of the process.
    pub fn ask(&self) {
        self.0.iter().for_each(|flag| flag.store(true, Ordering::Relaxed));
    }

    /// Whether this flag or that of the process is set.
    pub fn asked(&self) -> bool {
        self.0.iter().chain(FLAG.get()).any(|flag| flag.load(Ordering::Relaxed))
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
