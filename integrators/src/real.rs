//! The scalar type of the methods.

#[cfg(target_arch = "x86_64")]
use crate::vector::{Eight, Four};
use crate::vector::{Pair, Vector};
use num_traits::{Float, FloatConst, NumAssign};

/// A computation whose inner loops the compiler may vectorise, see [`kernel!`](crate::kernel); or a
/// struct, if the computation has functions of its own.
///
/// [`Real::run`] chooses the instruction set. Mark `run` `#[inline(always)]`, or the choice does
/// not reach the loops.
pub trait Kernel {
    /// What the computation returns.
    type Output;
    /// Does the computation.
    fn run(self) -> Self::Output;
}

impl<T, F: FnOnce() -> T> Kernel for F {
    type Output = T;

    #[inline(always)]
    fn run(self) -> T {
        self()
    }
}

/// An expression as a [`Kernel`]. What it uses is moved into it; so the compiler knows that numbers
/// do not change when an array is written. Functions that it calls must be `#[inline(always)]`, or
/// the instruction set does not reach them.
#[macro_export]
macro_rules! kernel {
    ($body:expr) => {
        $crate::real::kernel(
            #[inline(always)]
            move || $body,
        )
    };
}

/// The closure itself, of a kind that is called once: the call of another kind is a function of its
/// own, which is compiled without the instruction set.
#[doc(hidden)]
#[inline(always)]
pub fn kernel<T, F: FnOnce() -> T>(body: F) -> F {
    body
}

/// Computes `$body` with the widest registers in use, see [`Instructions`](crate::Instructions):
/// `$V` is their type, see [`Vector`](crate::Vector), for `f64` or for the given [`Real`]. All
/// widths give the same bits. The body is a [`kernel!`](crate::kernel).
#[macro_export]
macro_rules! with_registers {
    ($V:ident => $body:expr) => {
        $crate::with_registers!(f64, ($V), $body)
    };
    ($V:ident<$R:ident> => $body:expr) => {
        $crate::with_registers!($R, ($V<$R>), $body)
    };
    ($R:ty, $V:tt, $body:expr) => {
        match $crate::Instructions::used() {
            #[cfg(target_arch = "x86_64")]
            $crate::Instructions::Avx512 if const { <<$R as $crate::Real>::Pair as $crate::Vector<$R>>::LANES > 1 } => {
                let kernel = $crate::with_registers!($V = <$R as $crate::Real>::Eight, $body);
                // SAFETY: `used` returns a set that this machine has.
                unsafe { $crate::real::avx512(kernel) }
            }
            _ => $crate::with_narrow!($R, $V, $body),
        }
    };
    (($($V:tt)+) = $register:ty, $body:expr) => {
        $crate::kernel!({
            type $($V)+ = $register;
            $body
        })
    };
}

/// As [`with_registers!`](crate::with_registers), with registers of at most four numbers: for kernels
/// that gain less than a tenth from wider ones. Each further copy of a kernel costs time to compile.
#[macro_export]
macro_rules! with_narrow {
    ($V:ident => $body:expr) => {
        $crate::with_narrow!(f64, ($V), $body)
    };
    ($V:ident<$R:ident> => $body:expr) => {
        $crate::with_narrow!($R, ($V<$R>), $body)
    };
    ($R:ty, $V:tt, $body:expr) => {
        match $crate::Instructions::used() {
            #[cfg(target_arch = "x86_64")]
            $crate::Instructions::Avx512 | $crate::Instructions::Avx2
                if const { <<$R as $crate::Real>::Pair as $crate::Vector<$R>>::LANES > 1 } =>
            {
                let kernel = $crate::with_registers!($V = <$R as $crate::Real>::Four, $body);
                // SAFETY: `used` returns a set that this machine has, and AVX-512 is used with AVX2 only.
                unsafe { $crate::real::avx2(kernel) }
            }
            _ => $crate::Kernel::run($crate::with_registers!($V = <$R as $crate::Real>::Pair, $body)),
        }
    };
}

/// Runs a kernel compiled for AVX-512.
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
pub fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// Runs a kernel compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
#[target_feature(enable = "avx2,fma")]
pub fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
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

    /// The register of each instruction set. They are for
    /// [`with_registers!`](crate::with_registers): their functions may be called only where the
    /// machine has their instructions.
    #[doc(hidden)]
    type Pair: Vector<Self>;
    #[doc(hidden)]
    type Four: Vector<Self>;
    #[doc(hidden)]
    type Eight: Vector<Self>;

    /// Runs a kernel with the vector instructions in use, see [`crate::Instructions`]. All
    /// instruction sets give the same bits.
    #[inline(always)]
    fn run<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
}

impl Real for f64 {
    type Pair = Pair;
    #[cfg(target_arch = "x86_64")]
    type Four = Four;
    #[cfg(target_arch = "x86_64")]
    type Eight = Eight;
    #[cfg(not(target_arch = "x86_64"))]
    type Four = Pair;
    #[cfg(not(target_arch = "x86_64"))]
    type Eight = Pair;

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
    fn run<K: Kernel>(kernel: K) -> K::Output {
        crate::with_registers!(_V => kernel.run())
    }
}

/// As [`Real::run`], with registers of at most four numbers, see [`with_narrow!`](crate::with_narrow).
#[inline(always)]
pub(crate) fn run_narrow<K: Kernel>(kernel: K) -> K::Output {
    crate::with_narrow!(_V => kernel.run())
}

impl Real for twofloat::TwoFloat {
    type Pair = Self;
    type Four = Self;
    type Eight = Self;

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
