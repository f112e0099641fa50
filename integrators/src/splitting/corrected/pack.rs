//! A register of numbers with the operations of one number: events are corrected a register at a
//! time.

use crate::real::{MOST_LANES, Vector};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A register of numbers.
#[derive(Clone, Copy)]
pub struct Pack<V>(pub V);

impl<V: Vector<f64>> Pack<V> {
    /// The same number in all lanes.
    #[inline(always)]
    pub(super) fn all(x: f64) -> Self {
        Self(V::all(x))
    }

    /// One number for each of `things`, of which there are at most as many as lanes; the other
    /// lanes get the number of the first.
    #[inline(always)]
    pub fn of<S>(things: &[S], number: impl Fn(&S) -> f64) -> Self {
        Self(V::by_lane(|k| number(things.get(k).unwrap_or(&things[0]))))
    }

    #[inline(always)]
    pub(super) fn from_lanes(lanes: &[f64; MOST_LANES]) -> Self {
        // SAFETY: the array is as long as the largest number of lanes.
        Self(unsafe { V::load(lanes.as_ptr()) })
    }

    /// The numbers, and zeros after the last lane.
    #[inline(always)]
    pub(super) fn lanes(self) -> [f64; MOST_LANES] {
        let mut lanes = [0.0; MOST_LANES];
        // SAFETY: as above.
        unsafe { self.0.store(lanes.as_mut_ptr()) };
        lanes
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self(self.0.root())
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        Self(self.0.size())
    }

    /// The fractional parts, `x - floor(x)`.
    #[inline(always)]
    pub(super) fn fraction(self) -> Self {
        self - Self(self.0.floor())
    }

    /// These numbers where they are above zero, zero elsewhere.
    #[inline(always)]
    pub(super) fn positive(self) -> Self {
        self.where_positive(self)
    }

    /// These numbers where others are above zero, zero elsewhere.
    #[inline(always)]
    pub(super) fn where_positive(self, others: Self) -> Self {
        Self(others.0.above(0.0, self.0))
    }

    /// A bit for each lane: whether its number is at most `bound`; NaN is not.
    #[inline(always)]
    pub(super) fn at_most(self, bound: f64) -> u64 {
        self.0.at_most(V::all(bound))
    }

    /// These numbers in lanes whose bit is set, others elsewhere.
    #[inline(always)]
    pub(super) fn or(self, bits: u64, others: Self) -> Self {
        Self(self.0.or(bits, others.0))
    }

    /// The polynomial with these coefficients, lowest first. Even and odd powers are two sums, of
    /// which neither waits for the other.
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
        impl<V: Vector<f64>> $trait for Pack<V> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }

        impl<V: Vector<f64>> $trait<f64> for Pack<V> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::all(other))
            }
        }
    };
}

operation!(Add, add);
operation!(Sub, sub);
operation!(Mul, mul);
operation!(Div, div);

impl<V: Vector<f64>> Neg for Pack<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}
