//! Which vector instructions inner loops are compiled for, and which of those run.
//!
//! Loops have the same bits on every path, since no product and sum is contracted unless the code says so, and then on all of them. What may differ between two
//! machines are `sin`, `cos` and `powf`: the system's library picks its own code by the processor, and promises the last bit or two, not more.

use std::{
    fmt,
    sync::atomic::{AtomicU8, Ordering},
};

/// A path through inner loops, narrowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// What every machine of the target has: two doubles on x86-64.
    Portable = 1,
    /// Four doubles.
    Avx2 = 2,
    /// Eight doubles.
    Avx512 = 3,
}

/// The path in use; zero before anybody asked.
static USED: AtomicU8 = AtomicU8::new(0);

impl Instructions {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// Whether this machine has them.
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

    /// Those in use: the widest of this machine, unless [`select`](Self::select) said otherwise.
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

    /// Uses these from now on, in all threads; false, and nothing done, where the machine lacks them.
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
