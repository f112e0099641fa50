//! Times with twice the working precision.
//!
//! A run of 10^6 steps reaches a phase `omega t` of 10^5; one rounding of omega, of the step or of
//! a coefficient then costs 10^-11 in the phase. Scalars that describe times are therefore
//! unevaluated sums `hi + lo`. They are used once a stage, not once a site, so their cost is small.

use crate::{
    kernel,
    real::{Real, Vector},
};
use std::ops::{Add, Mul, Neg, Sub};

/// An unevaluated sum `hi + lo` with `|lo|` at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble<R> {
    /// The number rounded to the working precision.
    pub hi: R,
    /// The remainder of the rounding.
    pub lo: R,
}

// Of numbers, or of registers, lane by lane.

#[inline(always)]
fn two_sum<R: Real, V: Vector<R>>(a: V, b: V) -> DoubleDouble<V> {
    let hi = a + b;
    let part = hi - a;
    DoubleDouble { hi, lo: (a - (hi - part)) + (b - part) }
}

#[inline(always)]
fn fast_two_sum<R: Real, V: Vector<R>>(a: V, b: V) -> DoubleDouble<V> {
    let hi = a + b;
    DoubleDouble { hi, lo: b - (hi - a) }
}

#[inline(always)]
fn two_product<R: Real, V: Vector<R>>(a: V, b: V) -> DoubleDouble<V> {
    let hi = a * b;
    DoubleDouble { hi, lo: a.fused(b, hi.negative()) }
}

impl<R: Real> DoubleDouble<R> {
    /// The number `value`, with `lo = 0`.
    pub fn new(value: R) -> Self {
        Self { hi: value, lo: R::zero() }
    }

    /// Zero.
    pub fn zero() -> Self {
        Self::new(R::zero())
    }

    /// The number of a decimal, to about twice the precision of `f64` (31 digits).
    ///
    /// # Panics
    /// As [`Real::decimal`].
    pub fn decimal(text: &str) -> Self {
        // Nine digits at a time: each piece and its power of ten are exact.
        let (negative, digits) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let mut value = Self::new(R::decimal(whole));
        let mut scale = Self::new(R::one());
        for start in (0..fraction.len()).step_by(9) {
            let piece = &fraction[start..fraction.len().min(start + 9)];
            scale = scale * Self::new(R::of(10f64.powi(piece.len() as i32)));
            value = value + Self::new(R::decimal(piece)).over(scale);
        }
        if negative { -value } else { value }
    }

    /// The quotient `self / other`.
    #[inline(always)]
    pub fn over(self, other: Self) -> Self {
        let q0 = self.hi / other.hi;
        let rest = self - other * Self::new(q0);
        let q1 = rest.hi / other.hi;
        let rest = rest - other * Self::new(q1);
        fast_two_sum(q0, q1) + Self::new(rest.hi / other.hi)
    }

    /// The square root, for `self > 0`; zero gives zero.
    pub fn sqrt(self) -> Self {
        if self.hi <= R::zero() {
            return Self::zero();
        }
        let root = self.hi.sqrt();
        let rest = self - two_product(root, root);
        fast_two_sum(root, rest.hi / (root + root))
    }

    /// `2 pi`.
    pub fn two_pi() -> Self {
        let parts = [std::f64::consts::TAU, 2.4492935982947064e-16, -5.989539619436679e-33, 2.2249084417267306e-49];
        parts.into_iter().rev().fold(Self::zero(), |sum, part| sum + Self::new(R::of(part)))
    }

    /// The number minus the whole multiple of `modulus` that brings it into
    /// `[-modulus/2, modulus/2]`.
    #[inline]
    pub fn reduced(self, modulus: Self) -> Self {
        if self.hi.abs() <= modulus.hi * R::of(0.5) {
            return self;
        }
        let turns = (self.hi / modulus.hi).round();
        self - modulus * Self::new(turns)
    }

    /// `(sin, cos)` of the number, to the working precision. The number must be
    /// [`reduced`](Self::reduced).
    pub fn sin_cos(self) -> (R, R) {
        let (s, c) = self.hi.sin_cos();
        (s + c * self.lo, c - s * self.lo)
    }

    /// The nearest number of the working precision.
    pub fn value(self) -> R {
        self.hi
    }
}

impl<R: Real> Add for DoubleDouble<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let s = two_sum(self.hi, other.hi);
        let t = two_sum(self.lo, other.lo);
        let s = fast_two_sum(s.hi, s.lo + t.hi);
        fast_two_sum(s.hi, s.lo + t.lo)
    }
}

impl<R: Real> Neg for DoubleDouble<R> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl<R: Real> Sub for DoubleDouble<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<R: Real> Mul for DoubleDouble<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let p = two_product(self.hi, other.hi);
        fast_two_sum(p.hi, p.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Real for twofloat::TwoFloat {
    type Pair = Self;
    type Four = Self;
    type Eight = Self;

    fn decimal(text: &str) -> Self {
        // The division of the crate `twofloat` is accurate to one double only (version 0.8).
        let value = DoubleDouble::<f64>::decimal(text);
        Self::new_add(value.hi, value.lo)
    }

    fn of(value: f64) -> Self {
        Self::from(value)
    }

    fn f64(self) -> f64 {
        self.hi() + self.lo()
    }
}

/// Times nearer than this, relative to the time, count as the same.
const NEAR: f64 = 1e-12;

/// Times at which a problem is not smooth, where steps end.
#[derive(Clone, Debug)]
pub(crate) struct Breaks(Vec<f64>);

impl Breaks {
    /// The given times, in any order.
    pub(crate) fn new(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        Self(times)
    }

    /// The first of them after `t`; infinity if there is none.
    pub(crate) fn after(&self, t: f64) -> f64 {
        let next = self.0.partition_point(|&at| at <= t + NEAR * t.abs());
        self.0.get(next).copied().unwrap_or(f64::INFINITY)
    }

    /// The first of them after `t`, or the end of the run if that is earlier.
    pub(crate) fn or_end<R: Real>(&self, t: R, end: DoubleDouble<R>) -> DoubleDouble<R> {
        let at = self.after(t.f64());
        if at + NEAR * at.abs() < end.value().f64() { DoubleDouble::new(R::of(at)) } else { end }
    }
}

/// A rotation of the plane, as sine and cosine of its angle to twice the working precision.
#[derive(Clone, Copy, Debug)]
pub struct Rotation<R> {
    /// Sine.
    pub sin: DoubleDouble<R>,
    /// Cosine.
    pub cos: DoubleDouble<R>,
}

impl<R: Real> Rotation<R> {
    /// The rotation by the angle zero.
    pub fn none() -> Self {
        Self { sin: DoubleDouble::zero(), cos: DoubleDouble::new(R::one()) }
    }

    /// The rotation by `angle`, which must be [`reduced`](DoubleDouble::reduced): Taylor's series
    /// of 1/64 of the angle, which is then doubled six times.
    pub fn by(angle: DoubleDouble<R>) -> Self {
        R::run(kernel!({
            const DOUBLINGS: usize = 6;
            let part = angle.over(DoubleDouble::new(R::of(f64::from(1 << DOUBLINGS))));
            let square = part * part;
            // sin x = x - x^3/6 + ..; 1 - cos x = x^2/2 - x^4/24 + ..
            let (mut sin, mut versine) = (part, DoubleDouble::zero());
            let (mut term, mut k) = (part, 1.0);
            while term.hi.abs() > R::epsilon() * R::epsilon() * R::epsilon() {
                let even = (term * part).over(DoubleDouble::new(R::of(k + 1.0)));
                term = -(term * square).over(DoubleDouble::new(R::of((k + 1.0) * (k + 2.0))));
                (versine, sin, k) = (versine + even, sin + term, k + 2.0);
            }
            // Doubling v = 1 - cos x instead of cos x loses no digits of small angles:
            // v(2x) = 2 sin^2 x.
            for _ in 0..DOUBLINGS {
                let cos = DoubleDouble::new(R::one()) - versine;
                let (product, squared) = (sin * cos, sin * sin);
                (sin, versine) = (product + product, squared + squared);
            }
            Self { sin, cos: DoubleDouble::new(R::one()) - versine }
        }))
    }

    /// A rotation by almost `angle`, which must be [`reduced`](DoubleDouble::reduced): the angle
    /// has an error of a rounding, the length of what is turned is kept to twice the working
    /// precision. It costs far less than [`by`](Self::by), and is for a rotation that is not
    /// repeated.
    pub fn near(angle: DoubleDouble<R>) -> Self {
        let (sin, cos) = angle.sin_cos();
        let [s, c] = [sin, cos].map(|x| two_product(x, x));
        // (1 - sin^2 - cos^2)/2, by which both are too short.
        let short = (DoubleDouble::new(R::one()) - s - c).value() * R::of(0.5);
        Self { sin: fast_two_sum(sin, sin * short), cos: fast_two_sum(cos, cos * short) }
    }
}

impl<V: Copy> Rotation<V> {
    /// This rotation, followed by another; also in each lane of registers.
    #[inline(always)]
    #[must_use]
    pub fn then<R: Real>(&self, other: &Self) -> Self
    where
        V: Vector<R>,
    {
        let (a, b) = (self, other);
        let back = DoubleDouble { hi: b.sin.hi.negative(), lo: b.sin.lo.negative() };
        Self { sin: dot([a.sin, a.cos], [b.cos, b.sin]), cos: dot([a.cos, a.sin], [b.cos, back]) }
    }

    /// Sine and cosine to the working precision.
    #[inline(always)]
    pub fn sin_cos(&self) -> (V, V) {
        (self.sin.hi, self.cos.hi)
    }
}

/// `a_0 b_0 + a_1 b_1`, with an error of a unit in the last place of the larger product.
#[inline(always)]
fn dot<R: Real, V: Vector<R>>(a: [DoubleDouble<V>; 2], b: [DoubleDouble<V>; 2]) -> DoubleDouble<V> {
    let (p, q) = (two_product(a[0].hi, b[0].hi), two_product(a[1].hi, b[1].hi));
    let sum = two_sum(p.hi, q.hi);
    let mixed = (a[0].hi * b[0].lo + a[0].lo * b[0].hi) + (a[1].hi * b[1].lo + a[1].lo * b[1].hi);
    fast_two_sum(sum.hi, sum.lo + ((p.lo + q.lo) + mixed))
}
