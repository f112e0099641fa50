//! Coefficients of kernels: a number for all lanes of a register, or one for each.

use crate::{
    clock::DoubleDouble,
    real::Real,
    vector::{MOST_LANES, Vector},
};

/// A number for all lanes, or [`Each`].
pub trait Coefficient<R: Real>: Copy + PartialEq + 'static {
    /// Whether each lane has a number of its own.
    const EACH: bool;
    /// What it is computed with: a number, or a register.
    type In<V: Vector<R>>: Vector<R>;
    /// Its value, to compute with.
    fn get<V: Vector<R>>(self) -> Self::In<V>;
    /// The coefficient that was computed.
    fn kept<V: Vector<R>>(value: Self::In<V>) -> Self;
    /// Its value in all lanes.
    fn in_lanes<V: Vector<R>>(self) -> V;
    /// The number of a lane.
    fn lane(self, lane: usize) -> R;
    /// Zero in all lanes.
    fn zero() -> Self;
    /// Several coefficients from their numbers in each lane.
    fn by_lane<const N: usize>(numbers: impl Fn(usize) -> [R; N]) -> [Self; N];

    /// The same number in all lanes.
    #[inline(always)]
    fn all(x: R) -> Self {
        let [all] = Self::by_lane(|_| [x]);
        all
    }

    /// A coefficient to twice the working precision from its number in each lane.
    #[inline(always)]
    fn twofold(number: impl Fn(usize) -> DoubleDouble<R>) -> DoubleDouble<Self> {
        let [hi, lo] = Self::by_lane(|lane| {
            let DoubleDouble { hi, lo } = number(lane);
            [hi, lo]
        });
        DoubleDouble { hi, lo }
    }

    /// The number of a lane of such a coefficient.
    #[inline(always)]
    fn of_lane(twofold: DoubleDouble<Self>, lane: usize) -> DoubleDouble<R> {
        DoubleDouble { hi: twofold.hi.lane(lane), lo: twofold.lo.lane(lane) }
    }
}

/// A number for each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Each<R>([R; MOST_LANES]);

impl<R: Real> Coefficient<R> for R {
    const EACH: bool = false;
    type In<V: Vector<R>> = R;

    #[inline(always)]
    fn get<V: Vector<R>>(self) -> R {
        self
    }

    #[inline(always)]
    fn kept<V: Vector<R>>(value: R) -> R {
        value
    }

    #[inline(always)]
    fn in_lanes<V: Vector<R>>(self) -> V {
        V::all(self)
    }

    #[inline(always)]
    fn lane(self, _lane: usize) -> R {
        self
    }

    #[inline(always)]
    fn zero() -> R {
        R::zero()
    }

    #[inline(always)]
    fn by_lane<const N: usize>(numbers: impl Fn(usize) -> [R; N]) -> [R; N] {
        numbers(0)
    }
}

impl<R: Real> Coefficient<R> for Each<R> {
    const EACH: bool = true;
    type In<V: Vector<R>> = V;

    #[inline(always)]
    fn get<V: Vector<R>>(self) -> V {
        // SAFETY: there are as many numbers as the largest number of lanes.
        unsafe { V::load(self.0.as_ptr()) }
    }

    #[inline(always)]
    fn kept<V: Vector<R>>(value: V) -> Self {
        let mut numbers = [R::zero(); MOST_LANES];
        // SAFETY: as above.
        unsafe { value.store(numbers.as_mut_ptr()) };
        Self(numbers)
    }

    #[inline(always)]
    fn in_lanes<V: Vector<R>>(self) -> V {
        self.get::<V>()
    }

    fn lane(self, lane: usize) -> R {
        self.0[lane]
    }

    #[inline(always)]
    fn zero() -> Self {
        Self([R::zero(); MOST_LANES])
    }

    fn by_lane<const N: usize>(numbers: impl Fn(usize) -> [R; N]) -> [Self; N] {
        let lanes: [[R; N]; MOST_LANES] = std::array::from_fn(numbers);
        std::array::from_fn(|k| Self(lanes.map(|numbers| numbers[k])))
    }
}
