//! The path of one overlap near a kick.

/// Turns `omega h` up to which the functions of the path are summed as series.
const SERIES: f64 = 0.5;
/// Steps of Halley's method before bisection takes over, and the change, in steps of a run, that is the last: the next is of the size of its third power.
const HALLEY: u32 = 6;
const ENOUGH: f64 = 1e-3;
const HALVINGS: u32 = 53;
/// Share of a step by which processing may move an event across an end.
const MOVED: f64 = 0.25;

/// The overlap of one bond near a kick, as the smooth path through the kicks that its own force takes no part in:
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
pub(super) struct Jet {
    pub(super) value: f64,
    pub(super) rate: f64,
    pub(super) acceleration: f64,
}

impl BondPath {
    /// Value and derivatives at `t`.
    #[inline(always)]
    pub(super) fn at(&self, t: f64) -> Jet {
        let ([a, b], [j, k]) = (self.acceleration, self.jerk);
        let (cos, sinc, c2, s3) = oscillation(self.omega * t);
        Jet {
            value: self.overlap + t * (self.rate + t * ((0.5 * a + b * c2) + t * (j / 6.0 + k * s3))),
            rate: self.rate + t * ((a + b * sinc) + t * (0.5 * j + k * c2)),
            acceleration: (a + b * cos) + t * (j + k * sinc),
        }
    }

    /// The zero of the step that ends now, `[-h, 0]` but for what processing moves, and rate and acceleration there: Halley's method from the
    /// zero of the parabola. `None` where there is none.
    #[inline(always)]
    pub(super) fn zero(&self, h: f64, rising: bool) -> Option<(f64, f64, f64)> {
        let (g, r, a) = (self.overlap, self.rate, self.acceleration[0] + self.acceleration[1]);
        let root = (r * r - 2.0 * a * g).sqrt();
        let mut t = -2.0 * g / (r + if rising { root } else { -root });
        for _ in 0..HALLEY {
            let jet = self.at(t);
            // Halley's method: the bend is at hand.
            let newton = -jet.value / jet.rate;
            let change = newton * (1.0 - 0.5 * newton * jet.acceleration / jet.rate);
            t += change;
            if change.abs() <= ENOUGH * h {
                let rate = jet.rate + jet.acceleration * change;
                let inside = -(1.0 + MOVED) * h <= t && t <= MOVED * h && (rate > 0.0) == rising;
                return if inside { Some((t, rate, jet.acceleration)) } else { self.bracketed(h, rising) };
            }
        }
        self.bracketed(h, rising)
    }

    /// The same by bisection, where Halley's method has led away.
    #[cold]
    fn bracketed(&self, h: f64, rising: bool) -> Option<(f64, f64, f64)> {
        let inside = |t: f64| (self.at(t).value > 0.0) == rising;
        let (mut lo, mut hi) = (-h, 0.0);
        if inside(lo) || !inside(hi) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (lo + hi);
            *(if inside(middle) { &mut hi } else { &mut lo }) = middle;
        }
        let Jet { rate, acceleration, .. } = self.at(hi);
        ((rate > 0.0) == rising).then_some((hi, rate, acceleration))
    }
}

/// `cos x, sin x / x, (1 - cos x)/x^2, (x - sin x)/x^3`.
#[inline(always)]
fn oscillation(x: f64) -> (f64, f64, f64, f64) {
    if x == 0.0 {
        return (1.0, 1.0, 0.5, 1.0 / 6.0);
    }
    let y = x * x;
    if x.abs() > SERIES {
        let (sin, cos) = x.sin_cos();
        return (cos, sin / x, (1.0 - cos) / y, (x - sin) / (x * y));
    }
    let (c2, s3) = (horner(y, &C2), horner(y, &S3));
    (1.0 - y * c2, 1.0 - y * s3, c2, s3)
}

/// `(-1)^k/(2k+2)!` and `(-1)^k/(2k+3)!`: enough terms for a rounding at `x = 1/2`.
const C2: [f64; 6] = [1.0 / 2.0, -1.0 / 24.0, 1.0 / 720.0, -1.0 / 40_320.0, 1.0 / 3_628_800.0, -1.0 / 479_001_600.0];
const S3: [f64; 6] =
    [1.0 / 6.0, -1.0 / 120.0, 1.0 / 5040.0, -1.0 / 362_880.0, 1.0 / 39_916_800.0, -1.0 / 6_227_020_800.0];

#[inline(always)]
fn horner<const K: usize>(y: f64, coefficients: &[f64; K]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * y + coefficient)
}
