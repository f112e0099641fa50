//! The vector instructions that inner loops are compiled for and run with.
//!
//! Loops give the same bits with all instruction sets: no product and sum is contracted unless the
//! code says so, and then with all sets. Only `sin`, `cos` and `powf` may differ between machines:
//! the system's library chooses its code by the processor, and is accurate to the last bit or two.

use std::{
    fmt,
    sync::atomic::{AtomicU8, Ordering},
};

/// An instruction set, in ascending order of vector width.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// The instructions of every machine of the target: two doubles on x86-64.
    Portable = 1,
    /// Four doubles.
    Avx2 = 2,
    /// Eight doubles.
    Avx512 = 3,
}

/// The set in use; zero before the first call of `used` or `select`.
static USED: AtomicU8 = AtomicU8::new(0);

impl Instructions {
    /// All sets.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// Whether this machine has the set.
    pub fn available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// The set in use: the widest of this machine, unless [`select`](Self::select) chose another.
    #[inline]
    pub fn used() -> Self {
        match USED.load(Ordering::Relaxed) {
            3 => Self::Avx512,
            2 => Self::Avx2,
            1 => Self::Portable,
            _ => Self::widest(),
        }
    }

    #[cold]
    fn widest() -> Self {
        let widest = Self::ALL.into_iter().rev().find(|set| set.available()).unwrap_or(Self::Portable);
        USED.store(widest as u8, Ordering::Relaxed);
        widest
    }

    /// Uses this set from now on, in all threads. Returns false and does nothing if the machine
    /// lacks it.
    #[must_use]
    pub fn select(self) -> bool {
        let available = self.available();
        if available {
            USED.store(self as u8, Ordering::Relaxed);
        }
        available
    }
}

impl fmt::Display for Instructions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        })
    }
}
