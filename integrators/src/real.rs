//! The scalar type of the methods.

use crate::vector::{Pair, Vector};
#[cfg(target_arch = "x86_64")]
use crate::{
    instructions::Instructions,
    vector::{Eight, Four},
};
use num_traits::{Float, FloatConst, NumAssign};

/// A computation whose inner loops the compiler may vectorise.
///
/// [`Real::run`] chooses the instruction set. Mark `run` `#[inline(always)]`, or the choice does
/// not reach the loops.
pub trait Kernel {
    /// What the computation returns.
    type Output;
    /// Does the computation.
    fn run(self) -> Self::Output;
}

/// A computation that is written with registers, see [`Vector`].
///
/// [`Real::run_vector`] chooses the instruction set. Mark `run` `#[inline(always)]`, or the choice
/// does not reach the loops.
pub trait VectorKernel<R> {
    /// What the computation returns.
    type Output;
    /// Does the computation, with registers of a certain width.
    fn run<V: Vector<R>>(self) -> Self::Output;
}

/// A kernel that uses no registers.
struct Plain<K>(K);

impl<R, K: Kernel> VectorKernel<R> for Plain<K> {
    type Output = K::Output;

    #[inline(always)]
    fn run<V: Vector<R>>(self) -> K::Output {
        self.0.run()
    }
}

/// A real number: `f64`, or double-double (`twofloat::TwoFloat`).
pub trait Real: Float + FloatConst + NumAssign + std::fmt::Debug + std::fmt::Display + Send + Sync + 'static {
    /// The number nearest to a decimal such as `"-0.3336986162276780057"`, to the working
    /// precision.
    ///
    /// Coefficient tables hold decimals, so that they can be compared with their sources.
    ///
    /// # Panics
    /// If `text` is not a plain decimal. Texts come from the tables of this package only.
    fn decimal(text: &str) -> Self;

    /// The number with the value of an `f64`.
    fn of(value: f64) -> Self;

    /// The nearest `f64`.
    fn f64(self) -> f64;

    /// Runs a kernel with the vector instructions in use, see [`crate::Instructions`]. All
    /// instruction sets give the same bits.
    #[inline(always)]
    fn run<K: Kernel>(kernel: K) -> K::Output {
        Self::run_vector(Plain(kernel))
    }

    /// Runs a kernel with the widest registers in use, see [`crate::Instructions`]. All widths give
    /// the same bits.
    #[inline(always)]
    fn run_vector<K: VectorKernel<Self>>(kernel: K) -> K::Output {
        kernel.run::<Self>()
    }
}

impl Real for f64 {
    fn decimal(text: &str) -> Self {
        text.parse().expect("a table entry is a decimal")
    }

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn run_vector<K: VectorKernel<Self>>(kernel: K) -> K::Output {
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
            fn avx512<K: VectorKernel<f64>>(kernel: K) -> K::Output {
                kernel.run::<Eight>()
            }
            #[target_feature(enable = "avx2,fma")]
            fn avx2<K: VectorKernel<f64>>(kernel: K) -> K::Output {
                kernel.run::<Four>()
            }
            match Instructions::used() {
                // SAFETY: `used` returns a set that this machine has.
                Instructions::Avx512 => return unsafe { avx512(kernel) },
                // SAFETY: `used` returns a set that this machine has.
                Instructions::Avx2 => return unsafe { avx2(kernel) },
                Instructions::Portable => {}
            }
        }
        kernel.run::<Pair>()
    }
}

/// As [`Real::run`], with registers of at most four numbers: for kernels that gain next to nothing
/// from wider ones. Each further copy of a kernel costs time to compile.
#[inline(always)]
pub(crate) fn run_narrow<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2,fma")]
        fn avx2<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        if Instructions::used() != Instructions::Portable {
            // SAFETY: `used` returns a set that this machine has, and AVX-512 is used with AVX2
            // only.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run()
}

impl Real for twofloat::TwoFloat {
    fn decimal(text: &str) -> Self {
        // The division of the crate `twofloat` is accurate to one double only (version 0.8).
        let value = crate::clock::DoubleDouble::<f64>::decimal(text);
        Self::new_add(value.hi, value.lo)
    }

    fn of(value: f64) -> Self {
        Self::from(value)
    }

    fn f64(self) -> f64 {
        self.hi() + self.lo()
    }
}
