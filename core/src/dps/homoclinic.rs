//! Homoclinic solutions of the stationary DpS equation (dpsstat): profiles of bright breathers
//! (Theorem homoclinic).
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_n` | real profile of `A_n = epsilon a_n e^{i omega_0 epsilon^{alpha-1} tau}` (solper) |
//! | `b_n` | `(-1)^n a_n > 0` |
//! | `K` | last site of the half chain whose `b_K` is a normal double |
//!
//! Neighbours are in antiphase, so that (dpsstat) is an equation between positive numbers,
//!
//! ```text
//! b_n = (b_n + b_{n+1})^alpha + (b_{n-1} + b_n)^alpha,
//! ```
//!
//! with `b_{-n} = b_n` about a site and `b_{1-n} = b_n` about a bond. The tail decays doubly
//! exponentially, `ln b_{n+1} / ln b_n -> alpha`, so a relative error of `b_n` becomes `alpha`
//! times as large in `b_{n+1}`: a tail down to the smallest double needs more digits in the middle
//! than a double has. Petviashvili's iteration computes the middle in double precision, the tail is
//! extended site by site, and Newton's method refines the logarithms of both in double-double. Its
//! matrix has three diagonals, and in the tail its diagonal is nearly one; the elimination starts
//! there.

use super::Averages;
use crate::error::{Error, Result, require};
use hertzchain_integrators::DoubleDouble;
use serde::{Deserialize, Serialize};

/// Range of exponents. Below 1.01 the uniform solution and the width of the middle leave the
/// range of doubles; the tables of [`Averages`] end at 10.
const ALPHAS: std::ops::RangeInclusive<f64> = 1.01..=10.0;
/// Share of its height below which the guess of the middle ends; the exact solution is narrower.
const MIDDLE: f64 = 1e-30;
/// Share of the largest `b_n` below which the middle is not accurate enough to be kept.
const GOOD: f64 = 1e-8;
/// The tail ends at this multiple of the smallest normal double, so that the zero after its end has
/// no effect.
const BEYOND: f64 = 1e-40;
/// The logarithm of that zero: below all others by more than a double can tell.
const NOTHING: f64 = -1e6;
/// Largest step of Newton's method after which there is none: the error that remains is smaller
/// than it by a rounding, times the amplification in the tail.
const ENOUGH: f64 = 1e-20;
/// Taylor's series of the exponential function are of numbers up to this one.
const PART: f64 = 1.0 / 64.0;
/// Largest number of iterations for the middle; below it, of steps of Newton's method.
const MOST: usize = 100_000;
const MOST_NEWTON: usize = 20;

type Double = DoubleDouble<f64>;

/// The symmetry of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Center {
    /// A site: `a^1_n = a^1_{-n}`.
    Site,
    /// A bond: `a^2_n = -a^2_{1-n}`.
    Bond,
}

/// A homoclinic solution, accurate to double precision in every `a_n` that is a normal double.
///
/// ```
/// use hertzchain_core::dps::{Center, Homoclinic};
/// let breather = Homoclinic::new(1.5, Center::Site)?;
/// let strain = |n: i64| breather.a(n) - breather.a(n - 1);
/// let f = |n: i64| strain(n).abs().powf(0.5) * strain(n);
/// assert!((breather.a(3) + f(4) - f(3)).abs() < 1e-15 * breather.a(3).abs());
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Homoclinic {
    alpha: f64,
    center: Center,
    omega_0: f64,
    /// `b_0, .., b_K` about a site, `b_1, .., b_K` about a bond.
    half: Vec<f64>,
}

impl Homoclinic {
    /// The solution of the given exponent and symmetry.
    ///
    /// # Errors
    /// `alpha` outside `[1.01, 10]`.
    pub fn new(alpha: f64, center: Center) -> Result<Self> {
        require(ALPHAS.contains(&alpha), "alpha", alpha, "homoclinics are computed for alpha from 1.01 to 10")?;
        let middle = middle(alpha, center)?;
        let good = middle.iter().take_while(|b| **b > GOOD * middle[0]);
        let mut logs: Vec<Double> = good.map(|b| Double::new(b.ln())).collect();
        let beyond = f64::MIN_POSITIVE.ln() + BEYOND.ln();
        // For alpha near one the appended tail is too small and its refined end is not beyond; then
        // append again.
        while logs.last().is_none_or(|last| last.hi > beyond) {
            extend(alpha, &mut logs, beyond);
            logs = refined(alpha, center, logs)?;
        }
        let half = logs.into_iter().map(rounded).take_while(|b| b.is_normal()).collect();
        let omega_0 = 0.5 * Averages::new(alpha, 1.0)?.h(0.0, 1.0);
        Ok(Self { alpha, center, omega_0, half })
    }

    /// The exponent.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// The symmetry.
    pub fn center(&self) -> Center {
        self.center
    }

    /// `a_n`; zero where it is too small for a normal double.
    pub fn a(&self, n: i64) -> f64 {
        let k = match self.center {
            Center::Bond if n > 0 => n.unsigned_abs() - 1,
            _ => n.unsigned_abs(),
        };
        let b = usize::try_from(k).ok().and_then(|k| self.half.get(k)).copied().unwrap_or(0.0);
        if n % 2 == 0 { b } else { -b }
    }

    /// The sites whose `a_n` is a normal double.
    pub fn sites(&self) -> std::ops::RangeInclusive<i64> {
        let count = self.half.len() as i64;
        match self.center {
            Center::Site => 1 - count..=count - 1,
            Center::Bond => 1 - count..=count,
        }
    }

    /// `omega_0` of (eq:defom0) at `kappa = 1`, the frequency of the breather in slow time.
    pub fn omega_0(&self) -> f64 {
        self.omega_0
    }

    /// The largest `|a_n + delta^+ [|delta^- a_n|^{alpha-1} delta^- a_n]| / |a_n|` of the rounded
    /// `a_n`; it contains their rounding errors.
    pub fn residual(&self) -> f64 {
        let force = |n: i64| (self.a(n).abs() + self.a(n - 1).abs()).powf(self.alpha);
        let off = |n: i64| (1.0 - (force(n + 1) + force(n)) / self.a(n).abs()).abs();
        // Forces of the last sites are subnormal; these sites are left out.
        self.sites().filter(|n| self.a(*n).abs() > f64::MIN_POSITIVE / f64::EPSILON).map(off).fold(0.0, f64::max)
    }
}

/// Index in the half chain of the site to the left of its first site.
fn inner(center: Center) -> usize {
    match center {
        Center::Site => 1,
        Center::Bond => 0,
    }
}

/// The right side of the equation on the half chain, with zero after its end.
fn forces(alpha: f64, center: Center, b: &[f64]) -> Vec<f64> {
    let at = |k: usize| b.get(k).copied().unwrap_or(0.0);
    let force = |k: usize, before: f64| (at(k) + at(k + 1)).powf(alpha) + (before + at(k)).powf(alpha);
    (0..b.len()).map(|k| force(k, if k == 0 { at(inner(center)) } else { at(k - 1) })).collect()
}

/// The middle by Petviashvili's iteration.
///
/// `b <- S^{alpha/(alpha-1)} F(b)` with `S = <b, b> / <b, F(b)>`, for an `F` homogeneous of degree
/// `alpha`.
fn middle(alpha: f64, center: Center) -> Result<Vec<f64>> {
    // Guess: the uniform solution b = 2 (2b)^alpha times a Gaussian as wide as a slow modulation
    // would be.
    let height = (-(alpha + 1.0) / (alpha - 1.0)).exp2();
    let shift = if center == Center::Site { 0.0 } else { 0.5 };
    let bell = |k: usize| height * (-0.5 * (alpha - 1.0).min(1.0) * (k as f64 + shift).powi(2)).exp();
    let mut b: Vec<f64> = (0..).map(bell).take_while(|b| *b > MIDDLE * height).collect();
    let weight = |k: usize| if k == 0 && center == Center::Site { 1.0 } else { 2.0 };
    let product =
        |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).enumerate().map(|(k, (x, y))| weight(k) * x * y).sum() };
    for _ in 0..MOST {
        let f = forces(alpha, center, &b);
        let scale = (product(&b, &b) / product(&b, &f)).powf(alpha / (alpha - 1.0));
        let change = b.iter().zip(&f).map(|(b, f)| (scale * f - b).abs()).fold(0.0, f64::max);
        for (b, f) in b.iter_mut().zip(&f) {
            *b = scale * f;
        }
        if change < 1e-12 * b[0] {
            return Ok(b);
        }
    }
    Err(Error::parameter("alpha", alpha, "the iteration for the middle of a homoclinic settles"))
}

/// Appends `ln b_{n+1} = alpha ln b_n` until the last value is not above `beyond`.
fn extend(alpha: f64, logs: &mut Vec<Double>, beyond: f64) {
    while let Some(last) = logs.last()
        && last.hi > beyond
    {
        logs.push(*last * Double::new(alpha));
    }
}

/// Newton's method for the logarithms. Its matrix is one of doubles; what remains is computed in
/// twice the precision, so that each step leaves a share of a rounding of its error.
fn refined(alpha: f64, center: Center, mut logs: Vec<Double>) -> Result<Vec<Double>> {
    let n = logs.len();
    for _ in 0..MOST_NEWTON {
        // Forces of the bonds, and their derivatives by the sites before and after. Bond k is
        // before site k; bond 0 closes the half chain by symmetry.
        let closing = logs[inner(center)];
        let bonds: Vec<(Double, [f64; 2])> = (0..=n)
            .map(|k| {
                let before = if k == 0 { closing } else { logs[k - 1] };
                let (sum, shares) = sum(before, logs.get(k).copied().unwrap_or(Double::new(NOTHING)));
                (sum * Double::new(alpha), shares.map(|share| alpha * share))
            })
            .collect();
        // Elimination from the tail: what multiplies the site before, and the right side.
        let mut rows = vec![[0.0; 2]; n];
        for k in (0..n).rev() {
            let (force, [left, right]) = sum(bonds[k].0, bonds[k + 1].0);
            let mut pivot = 1.0 - left * bonds[k].1[1] - right * bonds[k + 1].1[0];
            let mut lower = left * bonds[k].1[0];
            let mut upper = right * bonds[k + 1].1[1];
            if k == 0 {
                // The site before the first is the first about a bond, the second about a site.
                match center {
                    Center::Bond => pivot -= lower,
                    Center::Site => upper += lower,
                }
                lower = 0.0;
            }
            let [coupled, side] = rows.get(k + 1).copied().unwrap_or_default();
            pivot -= upper * coupled;
            rows[k] = [lower / pivot, ((force - logs[k]).hi + upper * side) / pivot];
        }
        let (mut largest, mut step) = (0.0f64, 0.0);
        for (log, [coupled, side]) in logs.iter_mut().zip(rows) {
            step = side + coupled * step;
            *log = *log + Double::new(step);
            largest = largest.max(step.abs());
        }
        if largest <= ENOUGH {
            return Ok(logs);
        }
    }
    Err(Error::parameter("alpha", alpha, "Newton's method for a homoclinic settles"))
}

/// `ln(e^a + e^b)`, and the shares of both numbers in the sum.
fn sum(a: Double, b: Double) -> (Double, [f64; 2]) {
    let small = exp(if a.hi < b.hi { a - b } else { b - a });
    let one_more = small + Double::new(1.0);
    // Newton's method for the logarithm of `one_more`; the square of the first error is nothing.
    let log = Double::new(small.hi.ln_1p());
    let log = log + (one_more * exp(-log) - Double::new(1.0));
    let [most, least] = [1.0 / one_more.hi, small.hi / one_more.hi];
    if a.hi < b.hi { (b + log, [least, most]) } else { (a + log, [most, least]) }
}

/// `e^x` for `x <= 0`, to 27 digits: Taylor's series of a small part, squared.
fn exp(x: Double) -> Double {
    if x.hi < f64::MIN_POSITIVE.ln() {
        return Double::zero();
    }
    let squarings = if x.hi > -PART { 0 } else { (-x.hi / PART).log2().ceil() as i32 };
    let part = scaled(x, -squarings);
    let (mut value, mut term, mut k) = (Double::new(1.0), Double::new(1.0), 0.0);
    while term.hi.abs() > f64::EPSILON * f64::EPSILON {
        k += 1.0;
        term = (term * part).over(Double::new(k));
        value = value + term;
    }
    (0..squarings).fold(value, |value, _| value * value)
}

/// The double nearest to `e^x`, for `x <= 0` and a normal `e^x`; its root is far from the smallest
/// double, below which the remainder of a product is lost.
fn rounded(x: Double) -> f64 {
    let root = scaled(exp(scaled(x, -1)), 300);
    (root * root).hi * 2.0f64.powi(-600)
}

fn scaled(x: Double, power: i32) -> Double {
    let by = 2.0f64.powi(power);
    Double { hi: x.hi * by, lo: x.lo * by }
}
