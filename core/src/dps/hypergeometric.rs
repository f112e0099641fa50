//! Gauss's `F(a, b; c; w)` on `0 <= w <= 1`, tabulated for several `(a, b, c)` with the same
//! `p = c - a - b`.
//!
//! | symbol | meaning |
//! |---|---|
//! | `w, v` | the argument and `v = 1 - w`, each accurate to its own last digit |
//! | `p = m + epsilon` | power of the singular branch `v^p` at `w = 1` |
//! | `m, epsilon` | an integer, and a number in `[-3/4, 1/4)` |
//! | `E(v)` | `(v^epsilon - 1) / epsilon`; `ln v` at `epsilon = 0` |
//! | `sigma_n, beta_n` | `F = sum_n v^n (sigma_n + beta_n E(v))`; `beta_n = 0` for `n < m` |
//!
//! Near `w = 1` the connection formula reads `F = A F_1(v) + B v^p F_2(v)`. At integer `p` the two
//! branches have poles that cancel and leave a logarithm. The sums with `sigma_n` and `beta_n` have
//! no poles, and one form holds for every `p`.

use std::f64::consts::PI;

/// Pieces of equal width in `w`. The last [`NEAR`] of them, `v <= 1/4`, hold the two series in `v`.
const PIECES: usize = 16;
const NEAR: usize = 4;
/// Coefficients of a piece. The singularity `w = 1` is nine half-widths away from the centre of the
/// nearest piece that tabulates `F` itself: its Chebyshev coefficients fall like 17.9^{-n},
/// and 17.9^{-13} = 5e-17.
const COEFFICIENTS: usize = 13;

/// The parameters of `F(a, b; c; w)`.
#[derive(Clone, Copy)]
pub struct Parameters {
    /// `a`.
    pub a: f64,
    /// `b`.
    pub b: f64,
    /// `c`.
    pub c: f64,
    /// `1 / (Gamma(c - a) Gamma(c - b))`. The caller computes it: the zeros cannot be found from
    /// the rounded `c`.
    pub end: f64,
}
/// For each of `K` functions, a polynomial in the local variable of a piece, `|t| <= 1`.
type Piece<const K: usize> = [[f64; K]; COEFFICIENTS];

/// A position in the tables; the same for all functions with the same `epsilon`.
#[derive(Clone, Copy)]
pub struct BasePoint {
    piece: usize,
    t: f64,
    v: f64,
    /// `E(v)` for `v <= 1/4`, zero otherwise.
    e: f64,
}

impl BasePoint {
    /// The place of `0 <= w <= 1`, `v = 1 - w`; `v` may be far below the unit roundoff.
    #[inline]
    pub fn new(w: f64, v: f64, epsilon: f64) -> Self {
        let near = v <= NEAR as f64 / PIECES as f64;
        let x = PIECES as f64 * if near { v } else { w };
        let last = if near { NEAR } else { PIECES - NEAR } - 1;
        let index = (x as usize).min(last);
        let piece = if near { PIECES - 1 - index } else { index };
        let e = if near { power_quotient(v, epsilon) } else { 0.0 };
        Self { piece, t: 2.0 * (x - index as f64) - 1.0, v, e }
    }
}

/// `E(v) = (v^epsilon - 1) / epsilon`.
fn power_quotient(v: f64, epsilon: f64) -> f64 {
    if epsilon == 0.0 { v.ln() } else { (epsilon * v.ln()).exp_m1() / epsilon }
}

/// Tables of `K` functions `F(a, b; c; w)` with the same `p`.
#[derive(Clone, Debug)]
pub struct Hypergeometric<const K: usize> {
    m: i32,
    /// `F` in `w`, then `sum_{n >= 2} sigma_n v^{n-2}` in `v`.
    regular: [Piece<K>; PIECES],
    /// `sigma_0` and `sigma_1`, kept apart: where they vanish, a fitted polynomial would leave a
    /// rounding error larger than `v^p`.
    leading: [[f64; K]; 2],
    /// `sum_{n >= m} beta_n v^{n-m}` in `v`; the last piece is the one at `v = 0`.
    singular: [Piece<K>; NEAR],
}

impl<const K: usize> Hypergeometric<K> {
    /// Tables for `p = m + epsilon`. The relative error is a few 1e-15 (of the largest term of the
    /// series, where `F` changes sign).
    pub fn new(parameters: [Parameters; K], m: usize, epsilon: f64) -> Self {
        let mut tables = Self {
            m: m as i32,
            leading: [[0.0; K]; 2],
            regular: [[[0.0; K]; COEFFICIENTS]; PIECES],
            singular: [[[0.0; K]; COEFFICIENTS]; NEAR],
        };
        for (k, parameters) in parameters.into_iter().enumerate() {
            let branches = Branches::new(parameters, m, epsilon);
            for piece in 0..PIECES {
                let far = piece < PIECES - NEAR;
                let place = |t: f64| {
                    let index = if far { piece } else { PIECES - 1 - piece };
                    (index as f64 + 0.5 * (1.0 + t)) / PIECES as f64
                };
                let regular = fit(|t| {
                    if far { power_series(parameters, place(t)) } else { polynomial(&branches.sigma[2..], place(t)) }
                });
                put(&mut tables.regular[piece], k, regular);
                if !far {
                    put(&mut tables.singular[piece + NEAR - PIECES], k, fit(|t| polynomial(&branches.beta, place(t))));
                }
            }
            for (leading, sigma) in tables.leading.iter_mut().zip(&branches.sigma) {
                leading[k] = *sigma;
            }
        }
        tables
    }

    /// The `K` values at a place; infinite, with a sign, at `v = 0` where `p <= 0`.
    #[inline]
    pub fn at(&self, place: BasePoint) -> [f64; K] {
        let mut values = horner(&self.regular[place.piece], place.t);
        if place.piece >= PIECES - NEAR {
            // v^m E(v) -> 0 at v = 0 for every m > 0; the product 0 * inf would be NaN.
            let factor = match self.m {
                0 => place.e,
                _ if place.v == 0.0 => 0.0,
                m => place.v.powi(m) * place.e,
            };
            let singular = horner(&self.singular[place.piece + NEAR - PIECES], place.t);
            for k in 0..K {
                values[k] =
                    self.leading[0][k] + place.v * (self.leading[1][k] + place.v * values[k]) + factor * singular[k];
            }
        }
        values
    }
}

fn put<const K: usize>(piece: &mut Piece<K>, k: usize, coefficients: [f64; COEFFICIENTS]) {
    for (row, c) in piece.iter_mut().zip(coefficients) {
        row[k] = c;
    }
}

/// The polynomials of a piece at `t`, with even and odd powers apart: this halves the chain of
/// dependent operations.
#[inline]
fn horner<const K: usize>(piece: &Piece<K>, t: f64) -> [f64; K] {
    let square = t * t;
    let (mut even, mut odd) = (piece[COEFFICIENTS - 1], [0.0; K]);
    for pair in piece[..COEFFICIENTS - 1].chunks_exact(2).rev() {
        for k in 0..K {
            even[k] = even[k] * square + pair[0][k];
            odd[k] = odd[k] * square + pair[1][k];
        }
    }
    for k in 0..K {
        even[k] += t * odd[k];
    }
    even
}

/// The powers of the polynomial in `t` that interpolates `f` at the Chebyshev nodes of `[-1, 1]`.
///
/// Its Chebyshev coefficients fall by at least 17.9 each, and the powers in `T_n` grow by
/// `1 + sqrt 2` each, so there is no cancellation.
fn fit(f: impl Fn(f64) -> f64) -> [f64; COEFFICIENTS] {
    let n = COEFFICIENTS as f64;
    let angle = |j: usize| PI * (j as f64 + 0.5) / n;
    let values: [f64; COEFFICIENTS] = std::array::from_fn(|j| f(angle(j).cos()));
    let mut powers = [0.0; COEFFICIENTS];
    // T_k and T_{k+1} as polynomials in t: T_{k+1} = 2 t T_k - T_{k-1}.
    let (mut now, mut next) = ([0.0; COEFFICIENTS], [0.0; COEFFICIENTS]);
    (now[0], next[1]) = (1.0, 1.0);
    for k in 0..COEFFICIENTS {
        let sum: f64 = values.iter().enumerate().map(|(j, value)| value * (k as f64 * angle(j)).cos()).sum();
        let c = if k == 0 { sum / n } else { 2.0 * sum / n };
        for (power, t) in powers.iter_mut().zip(now) {
            *power += c * t;
        }
        let after = std::array::from_fn(|i| if i == 0 { 0.0 } else { 2.0 * next[i - 1] } - now[i]);
        (now, next) = (next, after);
    }
    powers
}

/// `F(a, b; c; w)` by its series about zero, `0 <= w <= 3/4`.
fn power_series(Parameters { a, b, c, .. }: Parameters, w: f64) -> f64 {
    geometric(|n| {
        let n = n as f64;
        (a + n) * (b + n) / ((c + n) * (1.0 + n)) * w
    })
}

/// `1 + q_0 + q_0 q_1 + ..`, up to the last term that matters; the quotients tend to 3/4 at most.
fn geometric(quotient: impl Fn(usize) -> f64) -> f64 {
    let (mut sum, mut term, mut n) = (1.0, 1.0, 0);
    // A small parameter can make an early term small; the test therefore starts with the tenth.
    while n < 10 || f64::abs(term) > 1e-18 * f64::abs(sum) {
        term *= quotient(n);
        sum += term;
        n += 1;
    }
    sum
}

/// The coefficients of the two series in `v`.
struct Branches {
    sigma: Vec<f64>,
    /// `beta_m, beta_{m+1}, ..`.
    beta: Vec<f64>,
}

impl Branches {
    /// Terms of either series: 32 terms leave `4^{-32}` at `v = 1/4`, and `m <= 11` of them precede
    /// the singular branch.
    const TERMS: usize = 44;

    fn new(parameters: Parameters, m: usize, epsilon: f64) -> Self {
        let Parameters { a, b, c, end } = parameters;
        let p = m as f64 + epsilon;
        // For the powers v^n: n(n - p) y_n = (n-1+a)(n-1+b) y_{n-1}; for the powers v^{n+epsilon}
        // the same with n + epsilon.
        let numerator = |x: f64| (x - 1.0 + a) * (x - 1.0 + b);
        let below = |n: f64| n * (n - p);
        let above = |n: f64| (n + epsilon) * (n - m as f64);
        let ratio = |n: f64| numerator(n) / below(n);
        // (numerator/above at n + epsilon - numerator/below at n) / epsilon, with the difference
        // formed in closed form.
        let ratio_quotient = |n: f64| {
            let (slope, bend) = (2.0 * n - 2.0 + a + b + epsilon, 2.0 * n - p + epsilon);
            (slope * below(n) - numerator(n) * bend) / (below(n) * above(n))
        };

        // beta_m = epsilon B, B = Gamma(c) Gamma(-p) / (Gamma(a) Gamma(b)), the pole of Gamma(-p)
        // divided out.
        let poles: f64 = (1..=m).map(|j| -(epsilon + j as f64)).product();
        let first = -per_gamma(a) * per_gamma(b) / (per_gamma(c) * per_gamma(1.0 - epsilon) * poles);
        let mut beta = vec![first];
        for n in m + 1..Self::TERMS {
            let n = n as f64;
            beta.push(beta.last().unwrap_or(&0.0) * numerator(n + epsilon) / above(n));
        }

        // For n < m, sigma_n is the regular branch, which starts with A = Gamma(c) Gamma(p) /
        // (Gamma(c-a) Gamma(c-b)). The recurrence has a pole near n = m. Therefore sigma_m follows
        // from the value of F at v = 1/4, the end of these tables; its error falls with v.
        let mut sigma = vec![0.0; Self::TERMS];
        if m > 0 {
            sigma[0] = end / (per_gamma(c) * per_gamma(p));
        }
        for n in 1..m {
            sigma[n] = ratio(n as f64) * sigma[n - 1];
        }
        let mut homogeneous = vec![0.0; Self::TERMS];
        homogeneous[m] = 1.0;
        for n in m + 1..Self::TERMS {
            let x = n as f64;
            sigma[n] = ratio(x) * sigma[n - 1] + ratio_quotient(x) * beta[n - 1 - m];
            homogeneous[n] = ratio(x) * homogeneous[n - 1];
        }
        let v = NEAR as f64 / PIECES as f64;
        let singular = v.powi(m as i32) * power_quotient(v, epsilon) * polynomial(&beta, v);
        let missing = power_series(parameters, 1.0 - v) - polynomial(&sigma, v) - singular;
        let sigma_m = missing / polynomial(&homogeneous, v);
        for (sigma, y) in sigma.iter_mut().zip(homogeneous) {
            *sigma += sigma_m * y;
        }
        Self { sigma, beta }
    }
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// `1 / Gamma(x)`, zero at the poles; relative error about 2e-15 for `|x| < 20`.
pub fn per_gamma(x: f64) -> f64 {
    /// Stirling's series with the terms below has an error of 1e-18 from here on.
    const FAR: f64 = 20.0;
    let (mut product, mut x) = (1.0, x);
    while x < FAR {
        product *= x;
        x += 1.0;
    }
    let y = (x * x).recip();
    let series = 1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y * (1.0 / 1680.0 - y / 1188.0)));
    product * (x - series / x).exp() * x.powf(0.5 - x) / (2.0 * PI).sqrt()
}
