//! Time maps: variables in which a solution with a power singularity at an event is smooth.
//!
//! | symbol | meaning |
//! |---|---|
//! | `sigma` | the variable, from 0 to 1 |
//! | `tau` | time since the start of the leg, from 0 to its length `L` |
//! | `a, b` | powers at the start and at the end; 1 where the solution is not singular |

use crate::{clock::DoubleDouble, real::Real};
use std::fmt::Debug;

/// `tau = L I(sigma)`, `I' = c sigma^{a-1} (1 - sigma)^{b-1}`, `I(0) = 0`, `I(1) = 1`.
///
/// Near the start `tau` behaves like `sigma^a`, near the end `L - tau` like `(1 - sigma)^b`.
/// `a = b = 1` is linear, `b = 1` fits an onset at the start, `a = 1` a release at the end. `I` is
/// the regularised incomplete beta function, a polynomial. With `b = 1` the map may be continued
/// beyond `sigma = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeMap<R> {
    length: R,
    a: u32,
    b: u32,
}

impl<R: Real> TimeMap<R> {
    /// The map of a leg of this length; powers below 1 count as 1.
    pub fn new(length: R, a: u32, b: u32) -> Self {
        Self { length, a: a.max(1), b: b.max(1) }
    }

    /// The powers `(a, b)`.
    pub fn powers(&self) -> (u32, u32) {
        (self.a, self.b)
    }

    /// The length `L`.
    pub fn length(&self) -> R {
        self.length
    }

    /// `C(n, k) sigma^k (1 - sigma)^{n-k}` summed over `ks`, with `n = a + b - 1`. All terms are
    /// positive on `(0, 1)`.
    fn sum(&self, sigma: R, ks: impl Iterator<Item = u32>) -> R {
        let n = self.a + self.b - 1;
        let power = |x: R, k: u32| num_traits::pow(x, k as usize);
        let term = |k| R::of(binomial(n, k)) * power(sigma, k) * power(R::one() - sigma, n - k);
        ks.fold(R::zero(), |sum, k| sum + term(k))
    }

    /// `tau` at `sigma`, with a small relative error.
    pub fn at(&self, sigma: R) -> R {
        self.length * self.sum(sigma, self.a..=self.a + self.b - 1)
    }

    /// `L - tau` at `sigma`, with a small relative error.
    pub fn before_end(&self, sigma: R) -> R {
        self.length * self.sum(sigma, 0..=self.a - 1)
    }

    /// `d tau / d sigma`.
    pub fn rate(&self, sigma: R) -> R {
        let (a, b) = (self.a as usize, self.b as usize);
        let c = binomial(self.a + self.b - 1, self.a) * f64::from(self.a);
        self.length * R::of(c) * num_traits::pow(sigma, a - 1) * num_traits::pow(R::one() - sigma, b - 1)
    }

    /// The `sigma` of a `tau` in `[0, L]` (for `b = 1`, also beyond).
    pub fn inverse(&self, tau: R) -> R {
        let (zero, one) = (R::zero(), R::one());
        if tau <= zero || self.length <= zero {
            return zero;
        }
        if self.a == 1 && self.b == 1 {
            // The division of the crate `twofloat` loses digits in double-double, and times must
            // not lose digits.
            return DoubleDouble::new(tau).over(DoubleDouble::new(self.length)).value();
        }
        if self.b > 1 && tau >= self.length {
            return one;
        }
        // Newton's method from the nearer end, where the map is nearly a power; it starts beyond
        // the root of a convex branch. By halves where it leaves the stretch, as it may for large
        // powers at both ends.
        let n = self.a + self.b - 1;
        let share = tau / self.length;
        let near_start = self.b == 1 || share < R::of(0.5);
        let (rest, power, factor) =
            if near_start { (share, self.a, binomial(n, self.a)) } else { (one - share, self.b, binomial(n, self.b)) };
        let guess = (rest / R::of(factor)).powf(R::of(f64::from(power)).recip());
        let mut sigma = if near_start { guess } else { one - guess };
        let (mut low, mut high) = (zero, one);
        for _ in 0..60 {
            let gap = if near_start { self.at(sigma) - tau } else { (self.length - tau) - self.before_end(sigma) };
            (low, high) = if gap > zero { (low, sigma) } else { (sigma, high) };
            let next = sigma - gap / self.rate(sigma);
            if !next.is_finite() {
                break;
            }
            let next = match next {
                next if self.b > 1 && next >= one => R::of(0.5) * (low + high),
                next if next > zero => next,
                _ => R::of(0.5) * sigma,
            };
            let moved = (next - sigma).abs();
            sigma = next;
            if moved <= R::of(1e-20) * sigma || moved == zero {
                break;
            }
        }
        sigma
    }

    /// The factor between `sigma` and `s = tau^{1/q}` near a singular end (`s` is this many times
    /// `sigma`). Without a singular end, the length.
    pub fn unit(&self) -> R {
        let q = self.a.max(self.b);
        let near = if self.a > 1 { binomial(self.a + self.b - 1, self.a) } else { 1.0 };
        (self.length * R::of(near)).powf(R::of(f64::from(q)).recip())
    }
}

fn binomial(n: u32, k: u32) -> f64 {
    (0..k).fold(1.0, |c, i| c * f64::from(n - i) / f64::from(i + 1)).round()
}

/// The power `q` of the map for a field that behaves like `(g)_+^alpha` near events, with any of
/// these exponents, for a method of order `p`.
///
/// The smallest `q` for which each `q alpha` is an integer (the mapped solution is then analytic)
/// or `q (alpha + 1) >= p` (the step at the event then errs by no more than all others together).
/// For `p = 8`: 1 for integers, 2 for half-integers, 4 for 6/5. Larger powers increase the error of
/// the same number of steps.
///
/// ```
/// use hertzchain_integrators::regularised::common_power;
/// assert_eq!(common_power(&[1.5, 2.0], 8), 2);
/// assert_eq!(common_power(&[1.5, 4.0 / 3.0], 8), 4);
/// assert_eq!(common_power(&[], 8), 1);
/// ```
pub fn common_power(alphas: &[f64], p: u32) -> u32 {
    let analytic = |q: f64, alpha: f64| (q * alpha - (q * alpha).round()).abs() < 1e-12;
    let does = |q: f64, alpha: f64| analytic(q, alpha) || q * (alpha + 1.0) >= f64::from(p);
    (1..=64u32).find(|&q| alphas.iter().all(|&alpha| does(f64::from(q), alpha))).unwrap_or(64)
}
