//! The solitary wave of the plain chain on the infinite line, from its integral equation.
//!
//! In units of its speed the overlap `G(xi)`, `xi = n - t`, obeys `G'' = D (G^alpha)` with the
//! second difference `D`, which is (English and Pego 2005)
//!
//! `G = Lambda * G^alpha`, `Lambda(xi) = (1 - |xi|)_+`.
//!
//! A pulse of speed `c` is `c^{2/(alpha-1)} G`. No flow of the chain is involved.

use std::f64::consts::PI;

/// Half the length of the interval that stands for the line, in sites. At its ends `G` is below the
/// smallest double for `alpha >= 1.5`, and below 1e-16 for `alpha >= 1.1`.
const HALF: usize = 16;
/// Samples a site.
const SAMPLES: usize = 24;
/// Largest number of steps of the iteration, and the relative change at which it ends.
const MOST_STEPS: usize = 500;
const LAST_STEP: f64 = 2e-16;
/// The profile by cosines has lost its relative accuracy beyond this place; farther out it is the
/// integral of its own values nearer to the crest.
const CORE: f64 = 2.0;
/// Samples a site of the tail.
const TAIL_SAMPLES: usize = 1024;
/// Largest number of sweeps of the integral equation over the tail. A sweep changes ever shorter
/// parts of it, those nearest to the crest.
const SWEEPS: usize = 20;
/// Relative change of a value of the tail that counts as none.
const SETTLED: f64 = 1e-15;

/// `G` as a series of cosines.
#[derive(Clone, Debug, PartialEq)]
pub struct LinePulse {
    alpha: f64,
    /// `G(xi) = sum f_j cos(pi j xi/16)`.
    cosines: Vec<f64>,
    /// Relative change in the last step of the iteration.
    pub last_step: f64,
}

/// `sin^2(k/2)/(k/2)^2`, the Fourier transform of `Lambda`.
fn hat(k: f64) -> f64 {
    if k == 0.0 { 1.0 } else { ((0.5 * k).sin() / (0.5 * k)).powi(2) }
}

/// Coefficients of `sum f_j cos(pi j i/n)` from the values at `i = 0 .. n`, and back.
struct Cosines {
    table: Vec<f64>,
}

impl Cosines {
    fn new(n: usize) -> Self {
        Self { table: (0..2 * n).map(|i| (PI * i as f64 / n as f64).cos()).collect() }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.table[i * j % self.table.len()]
    }

    fn values(&self, coefficients: &[f64]) -> Vec<f64> {
        let value = |i: usize| coefficients.iter().enumerate().map(|(j, f)| f * self.at(i, j)).sum();
        (0..coefficients.len()).map(value).collect()
    }

    fn coefficients(&self, values: &[f64]) -> Vec<f64> {
        let n = values.len() - 1;
        let end = |i: usize| if i == 0 || i == n { 0.5 } else { 1.0 };
        let of = |j: usize| {
            let sum: f64 = values.iter().enumerate().map(|(i, value)| end(i) * value * self.at(i, j)).sum();
            2.0 * end(j) * sum / n as f64
        };
        (0..=n).map(of).collect()
    }
}

impl LinePulse {
    /// `G` by Petviashvili's iteration, `G <- M^{alpha/(alpha-1)} Lambda * G^alpha` with the factor
    /// `M = <G, G>/<G, Lambda * G^alpha>`, from the pulse of the long-wave limit.
    pub fn new(alpha: f64) -> Self {
        let n = HALF * SAMPLES;
        let cosines = Cosines::new(n);
        let place = |i: usize| i as f64 / SAMPLES as f64;
        let mut values: Vec<f64> = (0..=n).map(|i| long_wave(alpha, place(i))).collect();
        let mut last_step = f64::INFINITY;
        let mut coefficients = Vec::new();
        for _ in 0..MOST_STEPS {
            let force: Vec<f64> = values.iter().map(|g| g.max(0.0).powf(alpha)).collect();
            coefficients = cosines.coefficients(&force);
            coefficients.iter_mut().enumerate().for_each(|(j, f)| *f *= hat(PI * j as f64 / HALF as f64));
            let next = cosines.values(&coefficients);
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let factor = (product(&values, &values) / product(&values, &next)).powf(alpha / (alpha - 1.0));
            coefficients.iter_mut().for_each(|f| *f *= factor);
            let apart = values.iter().zip(&next).map(|(before, next)| (before - factor * next).abs());
            last_step = apart.fold(0.0, f64::max) / values[0];
            values = next.into_iter().map(|value| factor * value).collect();
            if last_step <= LAST_STEP {
                break;
            }
        }
        Self { alpha, cosines: coefficients, last_step }
    }

    /// `G(xi)` and `G'(xi)`, with an absolute error of a rounding of the crest.
    pub fn at(&self, xi: f64) -> [f64; 2] {
        let k = PI / HALF as f64;
        let terms = self.cosines.iter().enumerate().map(|(j, f)| {
            let (sin, cos) = (k * j as f64 * xi).sin_cos();
            [f * cos, -f * k * j as f64 * sin]
        });
        terms.fold([0.0; 2], |sum, term| [sum[0] + term[0], sum[1] + term[1]])
    }

    /// The coefficient `C` of `c = C g^{(alpha-1)/2}`, with the speed `c` in sites per unit of time
    /// and the largest overlap `g`.
    ///
    /// ```
    /// // Hertz contacts. In the largest force, c = C F^{1/6}, the coefficient is the same.
    /// let pulse = hertzchain_orbits::waves::LinePulse::new(1.5);
    /// assert!((pulse.coefficient() - 0.905_515_776).abs() < 1e-9);
    /// ```
    pub fn coefficient(&self) -> f64 {
        self.at(0.0)[0].powf(-0.5 * (self.alpha - 1.0))
    }

    /// `int G e^{i k xi} d xi`.
    pub fn transform(&self, k: f64) -> f64 {
        // The rule of rectangles: G is smooth and falls to nothing at both ends.
        let (h, n) = (1.0 / SAMPLES as f64, HALF * SAMPLES);
        let term = |i: usize| self.at(i as f64 * h)[0] * (k * i as f64 * h).cos();
        h * (term(0) + 2.0 * (1..n).map(term).sum::<f64>())
    }

    /// `G(0), G(1), ..` down to the smallest normal double. The error relative to each grows from
    /// 1e-12 to about 1e-3, where a step of the rule is no longer short for a tail that falls so
    /// fast.
    ///
    /// Beyond `xi = 2` the integral equation gives `G` from larger values nearer to the crest, by
    /// the trapezoidal rule with the term `h^2/12` of the kinks of `Lambda`.
    pub fn at_sites(&self) -> Vec<f64> {
        let per = TAIL_SAMPLES;
        let first = (CORE * per as f64) as usize;
        let last = HALF * per;
        let mut g: Vec<f64> = (0..=first).map(|i| self.at(i as f64 / per as f64)[0]).collect();
        g.resize(last + per + 1, 0.0);
        let mut force: Vec<f64> = g.iter().map(|g| g.powf(self.alpha)).collect();
        let h = 1.0 / per as f64;
        for _ in 0..SWEEPS {
            let mut settled = 0;
            for i in first + 1..=last {
                let hat = |k: usize| 1.0 - k as f64 * h;
                let sum = |k: usize| hat(k) * (force[i - k] + force[i + k]);
                let kinks = force[i - per] - 2.0 * force[i] + force[i + per];
                let value = h * (force[i] + (1..per).map(sum).sum::<f64>()) + h * h / 12.0 * kinks;
                settled = if (value - g[i]).abs() <= SETTLED * value { settled + 1 } else { 0 };
                if value < f64::MIN_POSITIVE || settled > per {
                    break;
                }
                (g[i], force[i]) = (value, value.powf(self.alpha));
            }
        }
        g.into_iter().step_by(per).take_while(|g| *g >= f64::MIN_POSITIVE).collect()
    }
}

/// The pulse of the long-wave limit at unit speed, `F^{1/alpha} = F + F''/12` for `F = G^alpha`:
/// `G = a cos^{2/(alpha-1)}(xi/w)` within its first zeros.
fn long_wave(alpha: f64, xi: f64) -> f64 {
    let size = ((alpha + 1.0) / (2.0 * alpha)).powf(-(alpha - 1.0).recip());
    let phase = xi * 3.0_f64.sqrt() * (alpha - 1.0) / alpha;
    if phase.abs() < 0.5 * PI { size * phase.cos().powf(2.0 / (alpha - 1.0)) } else { 0.0 }
}
