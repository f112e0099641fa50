//! The scalar type of the methods, and numbers side by side in a register.
//!
//! Most loops are left to the compiler, see [`Kernel`]. A pass over a chain also combines the
//! number of each site with that of the next site, which may lie in the next register; compilers
//! split such loops. They are therefore written with a [`Vector`], whose width is that of the
//! instruction set in use. Only [`Vector::before`] and [`Vector::after`] move numbers between
//! lanes, and only [`Vector::fused`] contracts a product and a sum, so that all widths give the
//! same bits.

use num_traits::{Float, FloatConst, NumAssign, One};
use std::ops::{Add, Div, Mul, Sub};

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

/// As [`with_registers!`](crate::with_registers), with registers of at most four numbers: for
/// kernels that gain less than a tenth from wider ones. Each copy takes time to compile.
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
                // SAFETY: `used` returns a set of this machine, and AVX-512 is used with AVX2 only.
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

/// Largest number of lanes.
pub const MOST_LANES: usize = 8;

/// As many numbers as a register holds. A number is a vector with one lane.
pub trait Vector<R>:
    Copy + One + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Number of lanes.
    const LANES: usize;
    /// The same number in all lanes.
    fn all(x: R) -> Self;
    /// The numbers from `start` on.
    ///
    /// # Safety
    /// `LANES` numbers can be read there.
    unsafe fn load(start: *const R) -> Self;
    /// The values of a function of the lane's index.
    fn by_lane(number: impl Fn(usize) -> R) -> Self;
    /// Writes all lanes from `start` on.
    ///
    /// # Safety
    /// `LANES` numbers can be written there.
    unsafe fn store(self, start: *mut R);
    /// `self by + plus`, rounded once.
    fn fused(self, by: Self, plus: Self) -> Self;
    /// The larger number of each pair; that of `self` where one is NaN.
    fn larger(self, other: Self) -> Self;
    /// Square roots.
    fn root(self) -> Self;
    /// The largest whole numbers that are not above these.
    fn floor(self) -> Self;
    /// `1/x`.
    fn inverse(self) -> Self;
    /// `-x`.
    fn negative(self) -> Self;
    /// `then` in lanes above `bound`, zero in others.
    fn above(self, bound: R, then: Self) -> Self;
    /// A bit for each lane, the first lane's lowest: whether its number is above zero.
    fn positive(self) -> u64;
    /// A bit for each lane: whether its number exceeds that of `other`.
    fn exceeds(self, other: Self) -> u64;
    /// A bit for each lane: whether its number is at most that of `other`; NaN is not.
    fn at_most(self, other: Self) -> u64;
    /// The numbers of `self` in lanes whose bit is set, those of `others` elsewhere.
    fn or(self, bits: u64, others: Self) -> Self;
    /// Absolute values.
    fn size(self) -> Self;
    /// The lanes moved by one towards the first; the first of `next` comes last.
    fn before(self, next: Self) -> Self;
    /// The lanes moved by one towards the last; the last of `previous` comes first.
    fn after(self, previous: Self) -> Self;
    /// The numbers of `self` in the first `n` lanes, those of `others` in the lanes after these.
    fn first(self, n: usize, others: Self) -> Self;
    /// The number of one lane in all lanes.
    fn spread(self, lane: usize) -> Self;
    /// A function of each lane.
    fn each(self, f: impl Fn(R) -> R) -> Self;
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

/// Functions that are inlined into kernels.
macro_rules! inlined {
    ($(fn $name:ident($($argument:tt)*) -> $to:ty $body:block)*) => {$(
        #[inline(always)]
        fn $name($($argument)*) -> $to $body
    )*};
}

pub(crate) use inlined;

impl<R: Real> Vector<R> for R {
    const LANES: usize = 1;

    #[inline(always)]
    unsafe fn load(start: *const R) -> Self {
        // SAFETY: the caller's promise.
        unsafe { *start }
    }

    #[inline(always)]
    unsafe fn store(self, start: *mut R) {
        // SAFETY: the caller's promise.
        unsafe { *start = self }
    }

    inlined! {
        fn all(x: R) -> Self { x }
        fn by_lane(number: impl Fn(usize) -> R) -> Self { number(0) }
        fn fused(self, by: Self, plus: Self) -> Self { self.mul_add(by, plus) }
        fn larger(self, other: Self) -> Self { if other > self { other } else { self } }
        fn root(self) -> Self { self.sqrt() }
        fn floor(self) -> Self { num_traits::Float::floor(self) }
        fn inverse(self) -> Self { self.recip() }
        fn negative(self) -> Self { -self }
        fn above(self, bound: R, then: Self) -> Self { if self > bound { then } else { R::zero() } }
        fn positive(self) -> u64 { u64::from(self > R::zero()) }
        fn exceeds(self, other: Self) -> u64 { u64::from(self > other) }
        fn at_most(self, other: Self) -> u64 { u64::from(self <= other) }
        fn or(self, bits: u64, others: Self) -> Self { if bits & 1 > 0 { self } else { others } }
        fn size(self) -> Self { self.abs() }
        fn before(self, next: Self) -> Self { next }
        fn after(self, previous: Self) -> Self { previous }
        fn first(self, n: usize, others: Self) -> Self { if n > 0 { self } else { others } }
        fn spread(self, _lane: usize) -> Self { self }
        fn each(self, f: impl Fn(R) -> R) -> Self { f(self) }
    }
}
