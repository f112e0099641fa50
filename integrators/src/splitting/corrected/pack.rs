//! Some numbers side by side, with the operations of one: events are worked on several at a time.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `M` numbers, or `M` answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pack<const M: usize, T = f64>(pub(super) [T; M]);

// Loops, not maps of arrays: those are calls, out of the vector code.
impl<const M: usize> Pack<M> {
    /// The same number `M` times.
    #[inline(always)]
    pub(super) fn all(x: f64) -> Self {
        Self([x; M])
    }

    /// One number for each of `M` things.
    #[inline(always)]
    pub(super) fn of<S>(things: &[S; M], number: impl Fn(&S) -> f64) -> Self {
        let mut out = [0.0; M];
        for k in 0..M {
            out[k] = number(&things[k]);
        }
        Self(out)
    }

    #[inline(always)]
    pub(super) fn each(mut self, f: impl Fn(f64) -> f64) -> Self {
        for x in &mut self.0 {
            *x = f(*x);
        }
        self
    }

    #[inline(always)]
    fn both(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x = f(*x, y);
        }
        self
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        self.each(f64::sqrt)
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        self.each(f64::abs)
    }

    /// What is above the next lower whole number.
    #[inline(always)]
    pub(super) fn fraction(self) -> Self {
        self.each(|x| x - x.floor())
    }

    /// These numbers, or zero where they are below it.
    #[inline(always)]
    pub(super) fn positive(self) -> Self {
        self.each(|x| if x > 0.0 { x } else { 0.0 })
    }

    /// These numbers where others are above zero, zero elsewhere.
    #[inline(always)]
    pub(super) fn where_positive(self, others: Self) -> Self {
        self.both(others, |x, y| if y > 0.0 { x } else { 0.0 })
    }

    /// Where numbers are at most `bound`; NaN is not.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "a loop over lanes reads like the formula, and vectorises")]
    pub(super) fn at_most(self, bound: f64) -> Pack<M, bool> {
        let mut out = [false; M];
        for k in 0..M {
            out[k] = self.0[k] <= bound;
        }
        Pack(out)
    }

    /// These numbers where `which`, others elsewhere.
    #[inline(always)]
    pub(super) fn or(mut self, which: Pack<M, bool>, others: Self) -> Self {
        for k in 0..M {
            self.0[k] = if which.0[k] { self.0[k] } else { others.0[k] };
        }
        self
    }

    /// The polynomial with these coefficients, lowest first: even and odd powers are two sums that
    /// do not wait for each other.
    #[inline(always)]
    pub(super) fn polynomial<const K: usize>(self, coefficients: &[[f64; 2]; K]) -> Self {
        let square = self * self;
        let [even, odd] = coefficients[K - 1];
        let (mut even, mut odd) = (Self::all(even), Self::all(odd));
        for &[to_even, to_odd] in coefficients[..K - 1].iter().rev() {
            even = even * square + to_even;
            odd = odd * square + to_odd;
        }
        even + self * odd
    }
}

macro_rules! operation {
    ($trait:ident, $method:ident) => {
        impl<const M: usize> $trait for Pack<M> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.both(other, |x, y| x.$method(y))
            }
        }

        impl<const M: usize> $trait<f64> for Pack<M> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.each(|x| x.$method(other))
            }
        }
    };
}

operation!(Add, add);
operation!(Sub, sub);
operation!(Mul, mul);
operation!(Div, div);

impl<const M: usize> Neg for Pack<M> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}
