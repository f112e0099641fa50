//! Registers of two, four and eight numbers, and columns that are read and written by them.

use crate::real::{Kernel, Real, Vector, inlined};
use num_traits::One;
use std::{
    marker::PhantomData,
    ops::{Add, Div, Mul, Sub},
};

/// A column of numbers that is read and written by registers.
///
/// It borrows a slice, so that several columns of a chain cannot overlap.
pub struct Column<'a, R> {
    start: *mut R,
    len: usize,
    numbers: PhantomData<&'a mut [R]>,
}

impl<'a, R> Column<'a, R> {
    /// The column of a whole slice.
    pub fn new(numbers: &'a mut [R]) -> Self {
        Self { start: numbers.as_mut_ptr(), len: numbers.len(), numbers: PhantomData }
    }

    /// How many numbers it has.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The numbers from `at` on.
    ///
    /// # Safety
    /// The column has at least `at + LANES` numbers.
    #[inline(always)]
    pub unsafe fn load<V: Vector<R>>(&self, at: usize) -> V {
        debug_assert!(at + V::LANES <= self.len);
        // SAFETY: the caller's promise.
        unsafe { V::load(self.start.add(at)) }
    }

    /// Writes a register from `at` on.
    ///
    /// # Safety
    /// The column has at least `at + LANES` numbers.
    #[inline(always)]
    pub unsafe fn store<V: Vector<R>>(&mut self, at: usize, values: V) {
        debug_assert!(at + V::LANES <= self.len);
        // SAFETY: the caller's promise.
        unsafe { values.store(self.start.add(at)) }
    }
}

/// The operators lane by lane, and the number one in all lanes.
macro_rules! operations {
    ($vector:ident: $($trait:ident $method:ident $body:expr),*) => {
        $(impl $trait for $vector {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where its instructions do.
                #[allow(unused_unsafe, reason = "pairs need no instructions of their own")]
                unsafe { Self($body(self.0, other.0)) }
            }
        })*

        impl One for $vector {
            #[inline(always)]
            fn one() -> Self {
                Self::all(1.0)
            }
        }
    };
}

/// What is the same for all registers; `each` by way of an array.
macro_rules! each_lane {
    () => {
        #[inline(always)]
        fn each(self, f: impl Fn(f64) -> f64) -> Self {
            let mut lanes = [0.0; Self::LANES];
            // SAFETY: the array has as many numbers as lanes.
            unsafe {
                self.store(lanes.as_mut_ptr());
                lanes.iter_mut().for_each(|x| *x = f(*x));
                Self::load(lanes.as_ptr())
            }
        }

        #[inline(always)]
        fn inverse(self) -> Self {
            Self::one() / self
        }

        #[inline(always)]
        fn negative(self) -> Self {
            // The compiler changes the sign.
            self * Self::all(-1.0)
        }

        #[inline(always)]
        fn positive(self) -> u64 {
            self.exceeds(Self::all(0.0))
        }
    };
}

/// Two numbers, for the instructions of every machine: the compiler makes registers of pairs.
#[derive(Clone, Copy)]
pub struct Pair([f64; 2]);

#[inline(always)]
fn pairwise([a, b]: [f64; 2], [c, d]: [f64; 2], f: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    [f(a, c), f(b, d)]
}

operations!(Pair:
    Add add |x, y| pairwise(x, y, |x, y| x + y),
    Sub sub |x, y| pairwise(x, y, |x, y| x - y),
    Mul mul |x, y| pairwise(x, y, |x, y| x * y),
    Div div |x, y| pairwise(x, y, |x, y| x / y)
);

impl Vector<f64> for Pair {
    const LANES: usize = 2;
    each_lane!();

    #[inline(always)]
    unsafe fn load(start: *const f64) -> Self {
        // SAFETY: the caller's promise.
        unsafe { Self(*start.cast()) }
    }

    #[inline(always)]
    unsafe fn store(self, start: *mut f64) {
        // SAFETY: the caller's promise.
        unsafe { *start.cast() = self.0 }
    }

    // By lanes, as numbers.
    inlined! {
        fn all(x: f64) -> Self { Self([x; 2]) }
        fn by_lane(number: impl Fn(usize) -> f64) -> Self { Self([number(0), number(1)]) }
        fn fused(self, by: Self, plus: Self) -> Self {
            Self([self.0[0].fused(by.0[0], plus.0[0]), self.0[1].fused(by.0[1], plus.0[1])])
        }
        fn larger(self, other: Self) -> Self { Self(pairwise(self.0, other.0, f64::larger)) }
        fn root(self) -> Self { Self([self.0[0].root(), self.0[1].root()]) }
        fn floor(self) -> Self { Self(self.0.map(f64::floor)) }
        fn size(self) -> Self { Self([self.0[0].size(), self.0[1].size()]) }
        fn above(self, bound: f64, then: Self) -> Self {
            Self(pairwise(self.0, then.0, |x, then| x.above(bound, then)))
        }
        fn exceeds(self, other: Self) -> u64 {
            self.0[0].exceeds(other.0[0]) | self.0[1].exceeds(other.0[1]) << 1
        }
        fn at_most(self, other: Self) -> u64 {
            self.0[0].at_most(other.0[0]) | self.0[1].at_most(other.0[1]) << 1
        }
        fn or(self, bits: u64, others: Self) -> Self {
            Self([self.0[0].or(bits, others.0[0]), self.0[1].or(bits >> 1, others.0[1])])
        }
        fn before(self, next: Self) -> Self { Self([self.0[1], next.0[0]]) }
        fn after(self, previous: Self) -> Self { Self([previous.0[1], self.0[0]]) }
        fn first(self, n: usize, others: Self) -> Self {
            Self([self.0[0].first(n, others.0[0]), self.0[1].first(n.saturating_sub(1), others.0[1])])
        }
        fn spread(self, lane: usize) -> Self { Self([self.0[lane]; 2]) }
    }
}

#[cfg(target_arch = "x86_64")]
use wide::{Eight, Four};

/// Registers of four and of eight numbers.
///
/// Their functions are inlined into kernels that are compiled for these instructions, and are
/// called where the machine has been asked for them, see
/// [`with_registers!`](crate::with_registers).
#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Add, Div, Mul, One, Sub, Vector};
    use crate::instructions::Instructions;
    use std::arch::x86_64::*;

    /// Four numbers, for AVX2.
    #[derive(Clone, Copy)]
    pub struct Four(__m256d);

    operations!(Four: Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

    /// Eight numbers, for AVX-512.
    #[derive(Clone, Copy)]
    pub struct Eight(__m512d);

    operations!(Eight: Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

    /// Both registers from a table: for each function of [`Vector`] its body for AVX2, then that
    /// for AVX-512.
    macro_rules! registers {
        ($(fn $name:ident($($argument:tt)*) -> $to:ty $four:block $eight:block)*) => {
            registers!(Four 4 _mm256_loadu_pd _mm256_storeu_pd $(fn $name($($argument)*) -> $to $four)*);
            registers!(Eight 8 _mm512_loadu_pd _mm512_storeu_pd $(fn $name($($argument)*) -> $to $eight)*);
        };
        ($register:ident $lanes:literal $load:ident $store:ident
            $(fn $name:ident($($argument:tt)*) -> $to:ty $body:block)*) => {
            impl $register {
                const SET: Instructions = if $lanes == 4 { Instructions::Avx2 } else { Instructions::Avx512 };
            }

            impl Vector<f64> for $register {
                const LANES: usize = $lanes;
                each_lane!();

                #[inline(always)]
                unsafe fn load(start: *const f64) -> Self {
                    // SAFETY: as below; the address is the caller's promise.
                    unsafe { Self($load(start)) }
                }

                #[inline(always)]
                unsafe fn store(self, start: *mut f64) {
                    // SAFETY: as below; the address is the caller's promise.
                    unsafe { $store(start, self.0) }
                }

                $(#[inline(always)]
                fn $name($($argument)*) -> $to {
                    debug_assert!(Self::SET.available());
                    // SAFETY: the instructions exist: `with_registers!` alone names the type, where
                    // the machine has them.
                    unsafe { $body }
                })*
            }
        };
    }

    registers! {
        fn all(x: f64) -> Self { Self(_mm256_set1_pd(x)) } { Self(_mm512_set1_pd(x)) }
        fn by_lane(n: impl Fn(usize) -> f64) -> Self
            { Self(_mm256_setr_pd(n(0), n(1), n(2), n(3))) }
            { Self(_mm512_setr_pd(n(0), n(1), n(2), n(3), n(4), n(5), n(6), n(7))) }
        fn fused(self, by: Self, plus: Self) -> Self
            { Self(_mm256_fmadd_pd(self.0, by.0, plus.0)) }
            { Self(_mm512_fmadd_pd(self.0, by.0, plus.0)) }
        fn larger(self, other: Self) -> Self
            { Self(_mm256_max_pd(other.0, self.0)) }
            { Self(_mm512_max_pd(other.0, self.0)) }
        fn root(self) -> Self { Self(_mm256_sqrt_pd(self.0)) } { Self(_mm512_sqrt_pd(self.0)) }
        fn floor(self) -> Self
            { Self(_mm256_floor_pd(self.0)) }
            { Self(_mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0)) }
        fn above(self, bound: f64, then: Self) -> Self
            { Self(_mm256_and_pd(then.0, _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, _mm256_set1_pd(bound)))) }
            { Self(_mm512_maskz_mov_pd(_mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, _mm512_set1_pd(bound)), then.0)) }
        fn exceeds(self, other: Self) -> u64
            { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0)) as u64 }
            { u64::from(_mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0)) }
        fn at_most(self, other: Self) -> u64
            { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)) as u64 }
            { u64::from(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0)) }
        fn or(self, bits: u64, others: Self) -> Self
            {
                let lane = _mm256_set_epi64x(8, 4, 2, 1);
                let mask = _mm256_cmpeq_epi64(_mm256_and_si256(_mm256_set1_epi64x(bits as i64), lane), lane);
                Self(_mm256_blendv_pd(others.0, self.0, _mm256_castsi256_pd(mask)))
            }
            { Self(_mm512_mask_mov_pd(others.0, bits as u8, self.0)) }
        fn size(self) -> Self { Self(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0)) } { Self(_mm512_abs_pd(self.0)) }
        fn before(self, next: Self) -> Self
            { Self(_mm256_shuffle_pd::<0b0101>(self.0, _mm256_permute2f128_pd::<0x21>(self.0, next.0))) }
            {
                let (now, next) = (_mm512_castpd_si512(self.0), _mm512_castpd_si512(next.0));
                Self(_mm512_castsi512_pd(_mm512_alignr_epi64::<1>(next, now)))
            }
        fn after(self, previous: Self) -> Self
            { Self(_mm256_shuffle_pd::<0b0101>(_mm256_permute2f128_pd::<0x21>(previous.0, self.0), self.0)) }
            {
                let (previous, now) = (_mm512_castpd_si512(previous.0), _mm512_castpd_si512(self.0));
                Self(_mm512_castsi512_pd(_mm512_alignr_epi64::<7>(now, previous)))
            }
        fn first(self, n: usize, others: Self) -> Self
            {
                let mask = _mm256_cmpgt_epi64(_mm256_set1_epi64x(n as i64), _mm256_set_epi64x(3, 2, 1, 0));
                Self(_mm256_blendv_pd(others.0, self.0, _mm256_castsi256_pd(mask)))
            }
            { Self(_mm512_mask_mov_pd(others.0, ((1u32 << n.min(8)) - 1) as u8, self.0)) }
        fn spread(self, lane: usize) -> Self
            {
                // Both halves of the number, as there is no such instruction for whole ones.
                let lanes = _mm256_set1_epi64x((((2 * lane + 1) << 32) | (2 * lane)) as i64);
                Self(_mm256_castps_pd(_mm256_permutevar8x32_ps(_mm256_castpd_ps(self.0), lanes)))
            }
            { Self(_mm512_permutexvar_pd(_mm512_set1_epi64(lane as i64), self.0)) }
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
