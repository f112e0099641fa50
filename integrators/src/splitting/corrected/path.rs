//! The path of one overlap near a kick.

use super::pack::Pack;
use crate::real::{MOST_LANES, Vector};

/// Largest phase `omega t` for which the functions of the path are summed as series.
pub const SERIES: f64 = 0.5;
/// Largest phase for which they follow from the series at an eighth of it.
const DOUBLED: f64 = 8.0 * SERIES;
/// Largest number of iterations of Halley's method; then bisection takes over.
const HALLEY: u32 = 6;
/// The iteration ends with a change of at most this many steps of the run: the next change would be
/// of the size of its third power.
const ENOUGH: f64 = 1e-2;
/// Number of bisections.
const HALVINGS: u32 = 53;
/// Share of a step by which processing may move an event across an end of its step.
const MOVED: f64 = 0.25;

/// The overlap of one bond as a function of the time `t` since a kick: the smooth path through the
/// kicks, without the bond's own force:
///
/// ```text
/// g(t) = g + r t + t^2 (a/2 + b c2(omega t)) + t^3 (j/6 + k s3(omega t)),   c2(x) = (1 - cos x)/x^2,  s3(x) = (x - sin x)/x^3
/// ```
///
/// `a, j` are acceleration and jerk of the part that moves freely, `b, k` those of the part that
/// oscillates with `omega`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondPath {
    /// Overlap `g`.
    pub overlap: f64,
    /// Rate `r`.
    pub rate: f64,
    /// Steady and oscillating part of the acceleration, `a` and `b`.
    pub acceleration: [f64; 2],
    /// Steady and oscillating part of the jerk, `j` and `k`.
    pub jerk: [f64; 2],
    /// Frequency of the oscillation; 0 if there is none.
    pub omega: f64,
}

/// Value and derivatives of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jet<T = f64> {
    pub(super) value: T,
    pub(super) rate: T,
    pub(super) acceleration: T,
}

/// A zero of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Zero<P> {
    /// Its time; NaN if there is none.
    pub(super) at: P,
    pub(super) rate: P,
    pub(super) acceleration: P,
}

impl BondPath {
    /// Sine and cosine of the phase `omega t`.
    pub(super) fn turn(&self, t: f64) -> [f64; 2] {
        let [sin, cos] = Paths::<f64>::of(&[self], |path| path).turn(Pack(t));
        [sin.0, cos.0]
    }

    /// Value and derivatives at `t`.
    pub(super) fn at(&self, t: f64) -> Jet {
        let jet = Paths::<f64>::of(&[self], |path| path).at(Pack(t));
        Jet { value: jet.value.0, rate: jet.rate.0, acceleration: jet.acceleration.0 }
    }

    /// The zero in `[-h, 0]` with rate and acceleration there, by bisection.
    #[cold]
    fn bracketed(&self, h: f64, rising: bool) -> Option<Jet> {
        let inside = |t: f64| (self.at(t).value > 0.0) == rising;
        let (mut lo, mut hi) = (-h, 0.0);
        if inside(lo) || !inside(hi) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (lo + hi);
            *(if inside(middle) { &mut hi } else { &mut lo }) = middle;
        }
        let jet = self.at(hi);
        ((jet.rate > 0.0) == rising).then_some(Jet { value: hi, ..jet })
    }
}

/// Some paths side by side.
pub(super) struct Paths<V> {
    pub(super) overlap: Pack<V>,
    rate: Pack<V>,
    acceleration: [Pack<V>; 2],
    jerk: [Pack<V>; 2],
    omega: Pack<V>,
}

impl<V: Vector<f64>> Paths<V> {
    /// The paths of some things, see [`Pack::of`]; all have the frequency of the first.
    #[inline(always)]
    pub(super) fn of<S>(things: &[S], path: impl Fn(&S) -> &BondPath) -> Self {
        // Each by itself, as a closure would not be compiled for the registers of a kernel.
        Self {
            overlap: Pack::of(things, |thing| path(thing).overlap),
            rate: Pack::of(things, |thing| path(thing).rate),
            acceleration: [
                Pack::of(things, |thing| path(thing).acceleration[0]),
                Pack::of(things, |thing| path(thing).acceleration[1]),
            ],
            jerk: [Pack::of(things, |thing| path(thing).jerk[0]), Pack::of(things, |thing| path(thing).jerk[1])],
            omega: Pack::all(path(&things[0]).omega),
        }
    }

    /// One of the paths.
    #[inline(always)]
    fn path(&self, k: usize) -> BondPath {
        let of = |pack: Pack<V>| pack.lanes()[k];
        BondPath {
            overlap: of(self.overlap),
            rate: of(self.rate),
            acceleration: self.acceleration.map(of),
            jerk: self.jerk.map(of),
            omega: of(self.omega),
        }
    }

    /// Values and derivatives at `t`.
    #[inline(always)]
    pub(super) fn at(&self, t: Pack<V>) -> Jet<Pack<V>> {
        let ([a, b], [j, k]) = (self.acceleration, self.jerk);
        let Oscillation { cos, sinc, c2, s3 } = oscillation(self.omega * t);
        Jet {
            value: self.overlap + t * (self.rate + t * ((a * 0.5 + b * c2) + t * (j * (1.0 / 6.0) + k * s3))),
            rate: self.rate + t * ((a + b * sinc) + t * (j * 0.5 + k * c2)),
            acceleration: (a + b * cos) + t * (j + k * sinc),
        }
    }

    /// Sine and cosine of the phases `omega t`.
    #[inline(always)]
    pub(super) fn turn(&self, t: Pack<V>) -> [Pack<V>; 2] {
        let x = self.omega * t;
        let Oscillation { cos, sinc, .. } = oscillation(x);
        [x * sinc, cos]
    }

    /// The zeros in the step that ends now: in `[-h, 0]`, or beyond its ends by as much as
    /// processing may move them. Halley's method starts from the zero of the parabola.
    #[inline(always)]
    pub(super) fn zeros(&self, h: f64, rising: u64) -> Zero<Pack<V>> {
        let (g, r, a) = (self.overlap, self.rate, self.acceleration[0] + self.acceleration[1]);
        let (one, all) = (Pack::all(1.0), u64::MAX >> (u64::BITS as usize - V::LANES));
        let sign = one.or(rising, Pack::all(-1.0));
        let root = (r * r - a * g * 2.0).sqrt();
        let mut found = Zero { at: -(g * 2.0) / (r + sign * root), rate: r, acceleration: a };
        let mut done = 0;
        for _ in 0..HALLEY {
            let jet = self.at(found.at);
            // Halley's step: the acceleration is known already.
            let per_rate = one / jet.rate;
            let newton = -jet.value * per_rate;
            let change = newton * (one - newton * 0.5 * (jet.acceleration * per_rate));
            found.at = found.at.or(done, found.at + change);
            found.rate = found.rate.or(done, jet.rate + jet.acceleration * change);
            found.acceleration = found.acceleration.or(done, jet.acceleration);
            done |= change.abs().at_most(ENOUGH * h);
            if done == all {
                break;
            }
        }
        let inside = found.at.at_most(MOVED * h) & (-found.at).at_most((1.0 + MOVED) * h);
        let diverged = (found.rate.0.positive() ^ rising) | !inside | !done;
        if diverged & all != 0 {
            self.bracket(&mut found, diverged, h, rising);
        }
        found
    }

    /// The last zeros before now and the first ones after, of paths that are positive now; NaN
    /// where there is none within reach. Newton's method finds them from the zeros of the parabola.
    #[inline(always)]
    pub(super) fn nearest_zeros(&self, reach: f64) -> [Pack<V>; 2] {
        let (g, r, a) = (self.overlap, self.rate, self.acceleration[0] + self.acceleration[1]);
        let root = (r * r - a * g * 2.0).sqrt();
        // In this form the nearer zero suffers no cancellation. NaN where there is no zero.
        let zeros = [-(g * 2.0) / (r + root), -(g * 2.0) / (r - root)];
        let none = Pack::all(f64::NAN);
        [-1.0, 1.0].map(|side| {
            let within = |t: Pack<V>| (t * side).at_most(reach) & (t * -side).at_most(0.0);
            let [first, second] = zeros.map(|t| t.or(within(t), none));
            let nearer = first.abs().0.at_most(second.abs().0) | !within(second);
            let mut t = first.or(nearer, second);
            for _ in 0..3 {
                let jet = self.at(t);
                t = t - jet.value / jet.rate;
            }
            t.or(within(t), none)
        })
    }

    /// Finds zeros by bisection in the lanes in which Halley's method has not found one.
    #[inline(always)]
    fn bracket(&self, found: &mut Zero<Pack<V>>, diverged: u64, h: f64, rising: u64) {
        let mut lanes = [found.at, found.rate, found.acceleration].map(Pack::lanes);
        for k in (0..V::LANES).filter(|k| diverged >> k & 1 > 0) {
            let none = Jet { value: f64::NAN, rate: f64::NAN, acceleration: f64::NAN };
            let jet = self.path(k).bracketed(h, rising >> k & 1 > 0).unwrap_or(none);
            (lanes[0][k], lanes[1][k], lanes[2][k]) = (jet.value, jet.rate, jet.acceleration);
        }
        let [at, rate, acceleration] = lanes;
        *found = Zero {
            at: Pack::from_lanes(&at),
            rate: Pack::from_lanes(&rate),
            acceleration: Pack::from_lanes(&acceleration),
        };
    }
}

/// `cos x, sin x / x, (1 - cos x)/x^2, (x - sin x)/x^3`.
pub struct Oscillation<P> {
    pub cos: P,
    pub sinc: P,
    pub c2: P,
    pub s3: P,
}

/// These functions of `x`, at any phase.
#[inline(always)]
pub fn oscillation<V: Vector<f64>>(x: Pack<V>) -> Oscillation<Pack<V>> {
    let one = Pack::all(1.0);
    let y = x * x;
    let (mut c2, mut s3) = (y.polynomial(&C2), y.polynomial(&S3));
    let far = y.0.exceeds(V::all(SERIES * SERIES));
    if far != 0 {
        let (by_half, farther) = (doubled(y), y.0.exceeds(V::all(DOUBLED * DOUBLED)));
        (c2, s3) = (by_half.0.or(far, c2), by_half.1.or(far, s3));
        if farther != 0 {
            let [x, y] = [x, y].map(Pack::lanes);
            let of = |f: fn(f64, f64) -> f64| {
                let mut lanes = [0.0; MOST_LANES];
                (0..V::LANES).for_each(|k| lanes[k] = f(x[k], y[k]));
                Pack::from_lanes(&lanes)
            };
            c2 = of(|x, y| (1.0 - x.cos()) / y).or(farther, c2);
            s3 = of(|x, y| (x - x.sin()) / (x * y)).or(farther, s3);
        }
    }
    Oscillation { cos: one - y * c2, sinc: one - y * s3, c2, s3 }
}

/// `(1 - cos x)/x^2` and `(x - sin x)/x^3` from the series at `x/8`, by doubling `x` three times;
/// `y = x^2`.
#[inline(always)]
fn doubled<V: Vector<f64>>(y: Pack<V>) -> (Pack<V>, Pack<V>) {
    let mut part = y * (1.0 / 64.0);
    let (mut c2, mut s3) = (part.polynomial(&C2), part.polynomial(&S3));
    for _ in 0..3 {
        let sinc = Pack::all(1.0) - part * s3;
        (c2, s3, part) = (sinc * sinc * 0.5, (s3 + c2 * sinc) * 0.25, part * 4.0);
    }
    (c2, s3)
}

/// `(-1)^k/(2k+2)!` and `(-1)^k/(2k+3)!`, in pairs: at `x = 1/2` the next terms are 3e-15 and
/// 2e-16.
const C2: [[f64; 2]; 3] =
    [[1.0 / 2.0, -1.0 / 24.0], [1.0 / 720.0, -1.0 / 40_320.0], [1.0 / 3_628_800.0, -1.0 / 479_001_600.0]];
const S3: [[f64; 2]; 3] =
    [[1.0 / 6.0, -1.0 / 120.0], [1.0 / 5040.0, -1.0 / 362_880.0], [1.0 / 39_916_800.0, -1.0 / 6_227_020_800.0]];
