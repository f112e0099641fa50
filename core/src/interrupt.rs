//! Whether this process was asked to end: runs, sweeps and branches look here, end where they are and keep what they have.

use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};

static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Gives the flag that asks, once set by whoever hears signals. A second flag is not looked at.
pub fn watch(flag: Arc<AtomicBool>) {
    let _ = FLAG.set(flag);
}

/// Whether the flag is set.
pub fn asked() -> bool {
    FLAG.get().is_some_and(|flag| flag.load(Ordering::Relaxed))
}
