//! Coefficients of the kernels: a number for all lanes of a register, or one for each.
//!
//! The sites of a chain alone fill the lanes, and all have its parameters. Chains abreast have a
//! lane each, with parameters of their own: all but the exponent, the boundary and the kind of
//! resonators, for which kernels are compiled. No lane sees another one, and each number is computed
//! as in a chain alone, so that the bits are the same.

use super::{Chain, law::LANES, rows::SHORT};
use hertzchain_integrators::{Real, Vector, with_registers};

impl Chain<f64> {
    /// The largest number of such chains that can be moved abreast: that of the lanes of the
    /// instructions in use; one for a chain with details, or with so many sites that columns do not
    /// stay in the cache.
    pub(crate) fn most_abreast(&self) -> usize {
        let lanes = with_registers!(V => V::LANES);
        if self.details().is_none() && self.sites() * lanes <= SHORT { lanes } else { 1 }
    }

    /// Chains abreast: number `i` of member `m` is number `i lanes + m`.
    ///
    /// # Panics
    /// More than [`most_abreast`](Self::most_abreast).
    pub(super) fn abreast(members: &[Self]) -> Self {
        let (first, lanes) = (&members[0], with_registers!(V => V::LANES));
        assert!(members.len() <= first.most_abreast(), "more chains than can be moved together");
        Self { lanes, ..first.with_sites(first.boundary(), lanes * first.sites()) }
    }
}

impl<R: Real> Chain<R> {
    /// Distance of the numbers of neighbouring sites in columns.
    #[inline(always)]
    pub(super) fn stride<K: Coefficient<R>>(&self) -> usize {
        if K::EACH { self.lanes } else { 1 }
    }

    /// The chain of a lane; lanes without a member are like the last one. A chain alone has no
    /// members.
    pub(super) fn member<'a>(&'a self, members: &'a [Self], lane: usize) -> &'a Self {
        members.get(lane).or(members.last()).unwrap_or(self)
    }
}

/// A number for all lanes, or [`Each`].
pub trait Coefficient<R: Real>: Copy + 'static {
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
    /// Several coefficients from their numbers in each lane.
    fn by_lane<const N: usize>(numbers: impl Fn(usize) -> [R; N]) -> [Self; N];
}

/// A number for each lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Each<R>([R; LANES]);

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
        let mut numbers = [R::zero(); LANES];
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

    fn by_lane<const N: usize>(numbers: impl Fn(usize) -> [R; N]) -> [Self; N] {
        let lanes: [[R; N]; LANES] = std::array::from_fn(numbers);
        std::array::from_fn(|k| Self(lanes.map(|numbers| numbers[k])))
    }
}
