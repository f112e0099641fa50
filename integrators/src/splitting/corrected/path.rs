//! The path of one overlap near a kick.

use super::pack::Pack;

/// Turns `omega h` up to which the functions of the path are summed as series.
const SERIES: f64 = 0.5;
/// Steps of Halley's method before bisection takes over, and the change, in steps of a run, that is
/// the last: the next is of the size of its third power.
const HALLEY: u32 = 6;
const ENOUGH: f64 = 1e-2;
const HALVINGS: u32 = 53;
/// Share of a step by which processing may move an event across an end.
const MOVED: f64 = 0.25;

/// The overlap of one bond near a kick, as the smooth path through the kicks that its own force
/// takes no part in:
///
/// ```text
/// g(t) = g + r t + t^2 (a/2 + b c2(omega t)) + t^3 (j/6 + k s3(omega t)),   c2(x) = (1 - cos x)/x^2,  s3(x) = (x - sin x)/x^3
/// ```
///
/// `a, j` are accelerations and jerks of what moves freely, `b, k` of what oscillates with `omega`.
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

/// Where a path is zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Zero<const M: usize> {
    /// When; NaN where there is none.
    pub(super) at: Pack<M>,
    pub(super) rate: Pack<M>,
    pub(super) acceleration: Pack<M>,
}

impl BondPath {
    /// Sine and cosine of the phase at `t`.
    pub(super) fn turn(&self, t: f64) -> [f64; 2] {
        Paths::new(&[*self]).turn(Pack([t])).map(|turn| turn.0[0])
    }

    /// Value and derivatives at `t`.
    pub(super) fn at(&self, t: f64) -> Jet {
        let jet = Paths::new(&[*self]).at(Pack([t]));
        Jet { value: jet.value.0[0], rate: jet.rate.0[0], acceleration: jet.acceleration.0[0] }
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
pub(super) struct Paths<'a, const M: usize> {
    paths: &'a [BondPath; M],
    overlap: Pack<M>,
    rate: Pack<M>,
    acceleration: [Pack<M>; 2],
    jerk: [Pack<M>; 2],
    omega: Pack<M>,
}

impl<'a, const M: usize> Paths<'a, M> {
    #[inline(always)]
    pub(super) fn new(paths: &'a [BondPath; M]) -> Self {
        Self {
            overlap: Pack::of(paths, |path| path.overlap),
            rate: Pack::of(paths, |path| path.rate),
            acceleration: [Pack::of(paths, |path| path.acceleration[0]), Pack::of(paths, |path| path.acceleration[1])],
            jerk: [Pack::of(paths, |path| path.jerk[0]), Pack::of(paths, |path| path.jerk[1])],
            omega: Pack::of(paths, |path| path.omega),
            paths,
        }
    }

    /// Values and derivatives at `t`.
    #[inline(always)]
    pub(super) fn at(&self, t: Pack<M>) -> Jet<Pack<M>> {
        let ([a, b], [j, k]) = (self.acceleration, self.jerk);
        let Oscillation { cos, sinc, c2, s3 } = oscillation(self.omega * t);
        Jet {
            value: self.overlap + t * (self.rate + t * ((a * 0.5 + b * c2) + t * (j * (1.0 / 6.0) + k * s3))),
            rate: self.rate + t * ((a + b * sinc) + t * (j * 0.5 + k * c2)),
            acceleration: (a + b * cos) + t * (j + k * sinc),
        }
    }

    /// Sine and cosine of the phase at `t`.
    #[inline(always)]
    pub(super) fn turn(&self, t: Pack<M>) -> [Pack<M>; 2] {
        let x = self.omega * t;
        let Oscillation { cos, sinc, .. } = oscillation(x);
        [x * sinc, cos]
    }

    /// The zeros of the step that ends now, in `[-h, 0]` but for what processing moves: Halley's
    /// method from the zero of the parabola.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "a loop over lanes reads like the formula, and vectorises")]
    pub(super) fn zeros(&self, h: f64, rising: &[bool; M]) -> Zero<M> {
        let (g, r, a) = (self.overlap, self.rate, self.acceleration[0] + self.acceleration[1]);
        let sign = Pack::of(rising, |&rising| if rising { 1.0 } else { -1.0 });
        let root = (r * r - a * g * 2.0).sqrt();
        let mut found = Zero { at: -(g * 2.0) / (r + sign * root), rate: r, acceleration: a };
        let mut done = Pack([false; M]);
        for _ in 0..HALLEY {
            let jet = self.at(found.at);
            // The bend is at hand.
            let per_rate = Pack::all(1.0) / jet.rate;
            let newton = -jet.value * per_rate;
            let change = newton * (Pack::all(1.0) - newton * 0.5 * (jet.acceleration * per_rate));
            found.at = found.at.or(done, found.at + change);
            found.rate = found.rate.or(done, jet.rate + jet.acceleration * change);
            found.acceleration = found.acceleration.or(done, jet.acceleration);
            let settled = change.abs().at_most(ENOUGH * h);
            for k in 0..M {
                done.0[k] |= settled.0[k];
            }
            if done.0 == [true; M] {
                break;
            }
        }
        for k in 0..M {
            let t = found.at.0[k];
            let inside = -(1.0 + MOVED) * h <= t && t <= MOVED * h && (found.rate.0[k] > 0.0) == rising[k];
            if !(done.0[k] && inside) {
                // Halley's method has led away.
                let jet = self.paths[k].bracketed(h, rising[k]);
                let Jet { value, rate, acceleration } =
                    jet.unwrap_or(Jet { value: f64::NAN, rate: f64::NAN, acceleration: f64::NAN });
                (found.at.0[k], found.rate.0[k], found.acceleration.0[k]) = (value, rate, acceleration);
            }
        }
        found
    }
}

/// `cos x, sin x / x, (1 - cos x)/x^2, (x - sin x)/x^3`.
struct Oscillation<const M: usize> {
    cos: Pack<M>,
    sinc: Pack<M>,
    c2: Pack<M>,
    s3: Pack<M>,
}

#[inline(always)]
fn oscillation<const M: usize>(x: Pack<M>) -> Oscillation<M> {
    let one = Pack::all(1.0);
    let y = x * x;
    let (mut c2, mut s3) = (y.polynomial(&C2), y.polynomial(&S3));
    for k in 0..M {
        let (x, y) = (x.0[k], y.0[k]);
        if y > SERIES * SERIES {
            (c2.0[k], s3.0[k]) = ((1.0 - x.cos()) / y, (x - x.sin()) / (x * y));
        }
    }
    Oscillation { cos: one - y * c2, sinc: one - y * s3, c2, s3 }
}

/// `(-1)^k/(2k+2)!` and `(-1)^k/(2k+3)!`, in pairs: enough terms for a rounding at `x = 1/2`.
const C2: [[f64; 2]; 3] =
    [[1.0 / 2.0, -1.0 / 24.0], [1.0 / 720.0, -1.0 / 40_320.0], [1.0 / 3_628_800.0, -1.0 / 479_001_600.0]];
const S3: [[f64; 2]; 3] =
    [[1.0 / 6.0, -1.0 / 120.0], [1.0 / 5040.0, -1.0 / 362_880.0], [1.0 / 39_916_800.0, -1.0 / 6_227_020_800.0]];
