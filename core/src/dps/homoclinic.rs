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
//! extended site by site, and Newton's method refines both to [`PRECISION`] bits. The Newton matrix
//! has three diagonals, and in the tail its diagonal is nearly one; the elimination starts there.

use super::Averages;
use crate::error::{Error, Result, require};
use dashu_float::{FBig, round::mode::HalfEven};
use serde::{Deserialize, Serialize};

/// Range of exponents. Below 1.01 the uniform solution and the width of the middle leave the
/// range of doubles; the tables of [`Averages`] end at 10.
const ALPHAS: std::ops::RangeInclusive<f64> = 1.01..=10.0;
/// Bits in Newton's method: those of a double, and those that the tail loses.
const PRECISION: usize = 128;
/// Share of its height below which the guess of the middle ends; the exact solution is narrower.
const MIDDLE: f64 = 1e-30;
/// Share of the largest `b_n` below which the middle is not accurate enough to be kept.
const GOOD: f64 = 1e-8;
/// The tail ends at this multiple of the smallest normal double, so that the zero after its end has
/// no effect.
const BEYOND: f64 = 1e-40;
/// Largest number of iterations for the middle; below it, of steps of Newton's method.
const MOST: usize = 100_000;
const MOST_NEWTON: usize = 20;

type Big = FBig<HalfEven, 2>;

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
        let mut b: Vec<Big> = good.map(|b| big(*b)).collect();
        let beyond = big(f64::MIN_POSITIVE) * big(BEYOND);
        // For alpha near one the appended tail is too small and its refined end is not beyond; then
        // append again.
        while b.last().is_none_or(|last| *last > beyond) {
            extend(alpha, &mut b, &beyond);
            b = refined(alpha, center, b)?;
        }
        let half = b.iter().map(|b| b.to_f64().value()).take_while(|b| b.is_normal()).collect();
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

/// Appends `b_{n+1} = b_n^alpha` until the last value is not above `beyond`.
fn extend(alpha: f64, b: &mut Vec<Big>, beyond: &Big) {
    let power = big(alpha);
    while let Some(last) = b.last()
        && last > beyond
    {
        b.push(last.powf(&power));
    }
}

/// Newton's method in [`PRECISION`] bits.
fn refined(alpha: f64, center: Center, mut b: Vec<Big>) -> Result<Vec<Big>> {
    let (power, zero) = (big(alpha), big(0.0));
    // The error that remains is the square of this, times the amplification in the tail.
    let enough = big(2.0f64.powi(-64));
    for _ in 0..MOST_NEWTON {
        let n = b.len();
        // Forces and stiffnesses of the bonds. Bond k is before site k; bond 0 closes the half
        // chain by symmetry.
        let closing = b[inner(center)].clone();
        let bonds: Vec<(Big, Big)> = (0..=n)
            .map(|k| {
                let before = if k == 0 { &closing } else { &b[k - 1] };
                let sum = before + b.get(k).unwrap_or(&zero);
                let force = sum.powf(&power);
                let stiffness = &power * &force / sum;
                (force, stiffness)
            })
            .collect();
        // Elimination from the tail: pivot d_k, right side r_k.
        let mut pivots = vec![zero.clone(); n];
        let mut sides = vec![zero.clone(); n];
        for k in (0..n).rev() {
            pivots[k] = big(1.0) - &bonds[k].1 - &bonds[k + 1].1;
            sides[k] = &bonds[k].0 + &bonds[k + 1].0 - &b[k];
            // Bond 0 adds to the pivot or, about a site, to the upper entry.
            let mut upper = -bonds[k + 1].1.clone();
            if k == 0 && center == Center::Bond {
                pivots[0] -= &bonds[0].1;
            } else if k == 0 {
                upper -= &bonds[0].1;
            }
            if k + 1 < n {
                let factor = upper / &pivots[k + 1];
                let lower = -bonds[k + 1].1.clone();
                pivots[k] -= &factor * &lower;
                let side = &factor * &sides[k + 1];
                sides[k] -= side;
            }
        }
        let mut largest = zero.clone();
        let mut before = zero.clone();
        for k in 0..n {
            let coupled = if k == 0 { sides[0].clone() } else { &sides[k] + &bonds[k].1 * &before };
            let step = coupled / &pivots[k];
            let relative = abs(&step / &b[k]);
            b[k] += &step;
            if b[k] <= zero {
                return Err(Error::parameter("alpha", alpha, "Newton's method for a homoclinic stays positive"));
            }
            if relative > largest {
                largest = relative;
            }
            before = step;
        }
        if largest <= enough {
            return Ok(b);
        }
    }
    Err(Error::parameter("alpha", alpha, "Newton's method for a homoclinic settles"))
}

fn big(x: f64) -> Big {
    Big::try_from(x).unwrap_or(Big::ZERO).with_precision(PRECISION).value()
}

fn abs(x: Big) -> Big {
    if x < Big::ZERO { -x } else { x }
}
