//! The averages of a periodically opening contact, (eq:aux1) and (eq:aux2).
//!
//! | symbol | meaning |
//! |---|---|
//! | `b, r` | mean strain and amplitude of a bond with the overlap `-b + 2 kappa r cos t` |
//! | `S = 2 kappa r` | amplitude of the overlap; `q = S / (-b)` |
//! | `d = S - b` | largest overlap; there is no contact for `d <= 0` |
//! | `e = S + b` | minus the least overlap; the contact opens for `e > 0` only |
//! | `I_n` | `1/(2 pi) int_0^{2 pi} cos(n t) (-b + S cos t)_+^alpha dt` |
//! | `g_alpha, r h_alpha` | `I_0, I_1` |
//!
//! Every `I_n` is a hypergeometric function (Mehler's integral, and the binomial series averaged
//! term by term):
//!
//! ```text
//! opens:        I_n = Gamma(alpha+1) / (sqrt(pi) Gamma(alpha+3/2)) d^alpha sqrt(w)
//!                     F(1/2-n, 1/2+n; alpha+3/2; w),  w = d / (2S)
//! stays closed: I_n = (-b)^alpha (q/2)^n binomial(alpha, n)
//!                     F((n-alpha)/2, (n+1-alpha)/2; n+1; q^2)
//! ```
//!
//! Derivatives are the same with `alpha - 1`: `dI_n/db = -alpha I_n`,
//! `dI_n/dS = alpha (I_{n-1} + I_{n+1}) / 2`.

use super::hypergeometric::{BasePoint, Hypergeometric, Parameters, per_gamma};
use crate::error::{Result, require};
use std::f64::consts::PI;

/// `g_alpha` and `h_alpha` of (eq:aux1), (eq:aux2), for one `alpha` and `kappa`:
///
/// ```text
/// g_alpha(b, r)   = 1/(2 pi) int_0^{2 pi} (-b + 2 kappa r cos t)_+^alpha dt
/// r h_alpha(b, r) = 1/(2 pi) int_0^{2 pi} e^{-it} (-b + 2 kappa r cos t)_+^alpha dt
/// ```
///
/// They are the mean contact force and its first harmonic, and vanish for `b >= 2 kappa r`.
/// Relative errors are below 1e-13, up to the limits `r -> 0`, `b -> 2 kappa r` and
/// `b -> -2 kappa r`, wherever the result is a normal number. The arguments are finite with
/// `r >= 0`: the methods give `NaN` for `NaN` and for `r < 0`; [`Averages::checked`] returns an
/// error instead.
///
/// ```
/// use hertzchain_core::dps::Averages;
/// let averages = Averages::new(1.5, 1.0)?;
/// // Closed form at b = 0: h_{3/2}(0, 1) = 2^{1/2} Gamma(1/2) Gamma(7/4) / (pi Gamma(9/4)).
/// assert!((averages.h(0.0, 1.0) - 0.647_223_121_426_055_2).abs() < 1e-15);
/// // g = 1 at b = -1 without oscillation.
/// assert_eq!(averages.mean_strain(1.0, 0.0), -1.0);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Averages {
    alpha: f64,
    kappa: f64,
    /// `Gamma(alpha + 1) / (sqrt(pi) Gamma(alpha + 1/2))`, the factor of the derivatives.
    front: f64,
    /// `alpha + 1/2 - m` with the integer `m` for which it is in `[-3/4, 1/4)`.
    epsilon: f64,
    /// Tables for a contact that opens: `n = 0, 1` with `alpha`, and `n = 0, 1, 2` with
    /// `alpha - 1`.
    opening: (Hypergeometric<2>, Hypergeometric<3>),
    /// The same tables for a contact that stays closed.
    closed: (Hypergeometric<2>, Hypergeometric<3>),
}

/// `g_alpha`, `h_alpha` and their derivatives.
///
/// Near `b = -2 kappa r` the derivatives behave like `|b + 2 kappa r|^{alpha - 1/2}`: for
/// `alpha <= 1/2` they are infinite at `b = -2 kappa r`. For `alpha < 1/2` all but `g` and `h` also
/// diverge as `b -> 2 kappa r` from below; at `b >= 2 kappa r` all are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    /// `g_alpha`.
    pub g: f64,
    /// `h_alpha`; at `r = 0` its limit `kappa alpha (-b)^{alpha-1}`.
    pub h: f64,
    /// `d g_alpha / db = -alpha g_{alpha-1}`.
    pub dg_db: f64,
    /// `d g_alpha / dr`.
    pub dg_dr: f64,
    /// `d h_alpha / db`.
    pub dh_db: f64,
    /// `d h_alpha / dr`; zero at `r = 0`, as `h` is even in `r`.
    pub dh_dr: f64,
    /// `d (r h_alpha) / db`.
    pub drh_db: f64,
    /// `d (r h_alpha) / dr`.
    pub drh_dr: f64,
}

impl Values {
    /// Scales each value by `factor` of its degree of homogeneity in `(b, r)`, counted from
    /// `alpha`.
    fn scale(self, factor: impl Fn(i32) -> [f64; 2]) -> Self {
        let [same, one, two] = [0, -1, -2].map(|degree| {
            let [x, y] = factor(degree);
            move |value: f64| value * x * y
        });
        Self {
            g: same(self.g),
            h: one(self.h),
            dg_db: one(self.dg_db),
            dg_dr: one(self.dg_dr),
            dh_db: two(self.dh_db),
            dh_dr: two(self.dh_dr),
            drh_db: one(self.drh_db),
            drh_dr: one(self.drh_dr),
        }
    }
}

/// One bond, with its extreme overlaps computed without cancellation.
#[derive(Clone, Copy)]
struct Bond {
    b: f64,
    r: f64,
    swing: f64,
    /// `S - b`.
    d: f64,
    /// `S + b`.
    e: f64,
}

/// The contact stays open, opens in each period, or stays closed.
enum Contact {
    Never,
    Opens { root_w: f64, place: BasePoint },
    Always { q: f64, place: BasePoint },
}

impl Averages {
    /// Tables for one `alpha` and `kappa`; this takes about a millisecond.
    ///
    /// # Errors
    /// `alpha` outside `(0, 10]`; `kappa` not finite and positive.
    pub fn new(alpha: f64, kappa: f64) -> Result<Self> {
        require(alpha > 0.0 && alpha <= 10.0, "alpha", alpha, "the exponent is positive and at most 10")?;
        require(kappa.is_finite() && kappa > 0.0, "kappa", kappa, "the spring constant is finite and positive")?;
        // alpha + 1/2 = m + epsilon with -3/4 <= epsilon < 1/4, from differences that do not round.
        let m = (alpha + 0.75).round() as usize;
        let epsilon = alpha - (m as f64 - 0.5);
        // `less` is 1 for the exponent alpha - 1. With x = alpha - less + 1,
        // 1/Gamma(c - b) = (x-1) .. (x-n) / Gamma(x) has a zero at each integer alpha < n + less.
        let mehler = |n: u32, less: f64| {
            let (x, order) = (alpha - less + 1.0, f64::from(n));
            let zeros: f64 = (1..=n).map(|j| alpha - (less - 1.0 + f64::from(j))).product();
            Parameters { a: 0.5 - order, b: 0.5 + order, c: x + 0.5, end: zeros * per_gamma(x) * per_gamma(x + order) }
        };
        let binomial = |n: u32, less: f64| {
            let n = f64::from(n);
            let x = 0.5 * (n + 1.0 - less + alpha);
            let (a, b) = (0.5 * (n + less - alpha), 0.5 * (n + less + 1.0 - alpha));
            Parameters { a, b, c: n + 1.0, end: per_gamma(x) * per_gamma(x + 0.5) }
        };
        Ok(Self {
            alpha,
            kappa,
            front: per_gamma(alpha + 0.5) / (per_gamma(alpha + 1.0) * PI.sqrt()),
            epsilon,
            opening: (
                Hypergeometric::new([0, 1].map(|n| mehler(n, 0.0)), m, epsilon),
                Hypergeometric::new([0, 1, 2].map(|n| mehler(n, 1.0)), m - 1, epsilon),
            ),
            closed: (
                Hypergeometric::new([0, 1].map(|n| binomial(n, 0.0)), m, epsilon),
                Hypergeometric::new([0, 1, 2].map(|n| binomial(n, 1.0)), m - 1, epsilon),
            ),
        })
    }

    /// The exponent of the contact force.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// The spring constant.
    pub fn kappa(&self) -> f64 {
        self.kappa
    }

    /// `g_alpha(b, r)`.
    pub fn g(&self, b: f64, r: f64) -> f64 {
        self.force(b, r).0
    }

    /// `r h_alpha(b, r)`.
    pub fn r_h(&self, b: f64, r: f64) -> f64 {
        self.force(b, r).1
    }

    /// `h_alpha(b, r)`; at `r = 0` its limit, `kappa alpha (-b)^{alpha-1}` for `b < 0` and zero for
    /// `b >= 0`.
    pub fn h(&self, b: f64, r: f64) -> f64 {
        self.values(b, r).h
    }

    /// `(g_alpha, r h_alpha)`: both harmonics of the contact force in one evaluation.
    #[inline]
    pub fn force(&self, b: f64, r: f64) -> (f64, f64) {
        match self.exponent_shift(b, r) {
            0 => self.force_of(&self.bond(b, r)),
            k => {
                let (g, rh) = self.force_of(&self.bond(ldexp(b, k), ldexp(r, k)));
                let [x, y] = self.unscale(k, 0);
                (g * x * y, rh * x * y)
            }
        }
    }

    /// `g_alpha`, `h_alpha` and all first derivatives.
    #[inline]
    pub fn values(&self, b: f64, r: f64) -> Values {
        match self.exponent_shift(b, r) {
            0 => self.values_of(&self.bond(b, r)),
            k => self.values_of(&self.bond(ldexp(b, k), ldexp(r, k))).scale(|degree| self.unscale(k, degree)),
        }
    }

    /// [`values`](Self::values) with arguments that are checked first.
    ///
    /// # Errors
    /// `b` or `r` not finite; `r < 0`.
    pub fn checked(&self, b: f64, r: f64) -> Result<Values> {
        require(b.is_finite(), "b", b, "the mean strain is finite")?;
        require(r.is_finite() && r >= 0.0, "r", r, "the amplitude is finite and at least zero")?;
        Ok(self.values(b, r))
    }

    /// The mean strain `b` at which `g_alpha(b, r) = c`, for `c >= 0` and `r >= 0`.
    ///
    /// The result is `-c^{1/alpha}` at `r = 0`, and the least solution `2 kappa r` at `c = 0`. It
    /// is `NaN` for `c < 0`, for `r < 0`, and for a `2 kappa r` that overflows.
    ///
    /// Newton's method for `ln g` as a function of `ln d`, whose slope goes from `alpha + 1/2`
    /// (short contacts) to `alpha`, with bisection where its steps do not halve. Among 1e5 pairs it
    /// takes four evaluations in the mean and 44 at most. The largest counts are for `alpha` near
    /// zero, where `g` nearly jumps at `b = -2 kappa r`.
    pub fn mean_strain(&self, c: f64, r: f64) -> f64 {
        self.mean_strain_counted(c, r).0
    }

    /// [`mean_strain`](Self::mean_strain) and the number of evaluations it took.
    pub fn mean_strain_counted(&self, c: f64, r: f64) -> (f64, u32) {
        /// Three times the bisections from the widest bracket, which is 1400 wide in ln d.
        const MOST: u32 = 200;
        let (swing, height) = (2.0 * self.kappa * r, self.root(c));
        if !(c >= 0.0 && r >= 0.0 && swing.is_finite()) {
            return (f64::NAN, 0);
        }
        if swing == 0.0 || height == 0.0 || height.is_infinite() || swing < f64::EPSILON.powi(2) * height {
            return (swing - height, 0);
        }
        // The overlap at every time lies in [d - 2S, d], so height <= d <= height + 2S.
        let (mut low, mut high) = (height, height + 2.0 * swing);
        // Guess: g ~ d^alpha (d / 2S)^{1/2} where contacts are short; elsewhere g >= (-b)^alpha for
        // alpha >= 1.
        let short = (2.0 * swing / height).sqrt() * (self.alpha + 0.5) / self.front;
        let mut d = (height * short.powf((self.alpha + 0.5).recip())).clamp(low, height + swing);
        // Sizes of the last two steps in ln d; bisection follows where they do not halve.
        let (mut last, mut before) = (f64::INFINITY, f64::INFINITY);
        for count in 1..=MOST {
            let bond = Bond { b: swing - d, r, swing, d, e: 2.0 * swing - d };
            let Values { g, dg_db, .. } = self.values_of(&bond);
            *(if g < c { &mut low } else { &mut high }) = d;
            let step = (c / g).ln() * g / (-dg_db * d);
            if step.abs() <= 4.0 * f64::EPSILON || high - low <= 2.0 * f64::EPSILON * d {
                return (swing - d, count);
            }
            let newton = d * step.exp();
            let next = if newton > low && newton < high && step.abs() < 0.5 * before {
                newton
            } else {
                low.sqrt() * high.sqrt()
            };
            (before, last) = (last, (next / d).ln().abs());
            d = next;
        }
        (swing - d, MOST)
    }

    /// `c^{1/alpha}`. One step of Newton's method removes the error from the rounding of `1/alpha`,
    /// which `ln c` multiplies.
    fn root(&self, c: f64) -> f64 {
        let root = c.powf(self.alpha.recip());
        if root > 0.0 && root.is_finite() { root - root * (root.powf(self.alpha) / c - 1.0) / self.alpha } else { root }
    }

    /// The `k` for which `2^k (b, r)` has an amplitude well inside the range of doubles; zero
    /// except for extreme `kappa r`.
    #[inline]
    fn exponent_shift(&self, b: f64, r: f64) -> i32 {
        const FAR: f64 = 1e250;
        let swing = 2.0 * self.kappa * r;
        if swing > FAR {
            -500
        } else if swing < FAR.recip() && r > 0.0 && b.abs() < FAR.sqrt().recip() {
            // A tiny swing next to a much larger b needs no shift.
            500
        } else {
            0
        }
    }

    /// `2^{-k (alpha + degree)}`, as two factors.
    #[cold]
    fn unscale(&self, k: i32, degree: i32) -> [f64; 2] {
        // The sum alpha + degree would be rounded, and 2^k would magnify the error.
        let base = f64::from(-k / 2).exp2();
        [base.powf(self.alpha) * base.powi(degree); 2]
    }

    #[inline]
    fn bond(&self, b: f64, r: f64) -> Bond {
        let r = if r >= 0.0 { r } else { f64::NAN };
        let swing = 2.0 * self.kappa * r;
        let (mut d, mut e) = (swing - b, swing + b);
        if d.abs() < 0.5 * swing || e.abs() < 0.5 * swing {
            // Where the swing cancels against b, its own rounding error is added back.
            let lost = (2.0 * self.kappa).mul_add(r, -swing);
            (d, e) = (d + lost, e + lost);
        }
        Bond { b, r, swing, d, e }
    }

    #[inline]
    fn contact(&self, bond: &Bond) -> Contact {
        let &Bond { b, swing, d, e, .. } = bond;
        if d <= 0.0 {
            Contact::Never
        } else if e > 0.0 {
            let (w, v) = (0.5 * d / swing, 0.5 * e / swing);
            Contact::Opens { root_w: w.sqrt(), place: BasePoint::new(w, v, self.epsilon) }
        } else {
            let q = -swing / b;
            Contact::Always { q, place: BasePoint::new(q * q, (e / b) * (-d / b), self.epsilon) }
        }
    }

    /// `x^{(alpha-1)/2}`: multiplied one after the other, two of them stay in range where the
    /// result does.
    #[inline]
    fn half_power(&self, x: f64) -> f64 {
        // alpha - 1 would be rounded, and ln x would magnify the error.
        let root = x.sqrt();
        if self.alpha == 1.5 { root.sqrt() } else { x.powf(0.5 * self.alpha) / root }
    }

    #[inline]
    fn force_of(&self, bond: &Bond) -> (f64, f64) {
        match self.contact(bond) {
            Contact::Never => (0.0, 0.0),
            Contact::Opens { root_w, place } => {
                let [g, rh] = self.opening.0.at(place);
                let x = self.half_power(bond.d);
                let front = x * (self.front / (self.alpha + 0.5) * root_w) * bond.d;
                (front * g * x, front * rh * x)
            }
            Contact::Always { place, .. } => {
                let [g, rh] = self.closed.0.at(place);
                let x = self.half_power(-bond.b);
                (x * g * -bond.b * x, 0.5 * self.alpha * x * bond.swing * rh * x)
            }
        }
    }

    #[inline]
    fn values_of(&self, bond: &Bond) -> Values {
        let &Self { alpha, kappa, .. } = self;
        let &Bond { b, r, d, .. } = bond;
        let mut values = match self.contact(bond) {
            Contact::Never => Values::default(),
            Contact::Opens { root_w, place } => {
                let ([i0, i1], [j0, j1, j2]) = (self.opening.0.at(place), self.opening.1.at(place));
                let x = self.half_power(d);
                let slope = x * (self.front * root_w);
                let front = slope / (alpha + 0.5) * d;
                Values {
                    g: front * i0 * x,
                    h: front / r * i1 * x,
                    dg_db: -slope * j0 * x,
                    dg_dr: 2.0 * slope * kappa * j1 * x,
                    dh_db: -slope / r * j1 * x,
                    dh_dr: 2.0 * slope * kappa * j2 * (x / r),
                    drh_db: -slope * j1 * x,
                    drh_dr: 0.0,
                }
            }
            Contact::Always { q, place } => {
                let ([i0, i1], [j0, j1, j2]) = (self.closed.0.at(place), self.closed.1.at(place));
                let x = self.half_power(-b);
                let slope = alpha * x * kappa;
                let second = (alpha - 1.0) * j1;
                Values {
                    g: x * i0 * -b * x,
                    h: slope * i1 * x,
                    dg_db: -alpha * x * j0 * x,
                    dg_dr: slope * q * second * x,
                    dh_db: slope * second * (x / b),
                    dh_dr: 0.5 * slope * q * ((alpha - 1.0) * (alpha - 2.0) * j2) * (-x / b * kappa),
                    drh_db: -0.5 * alpha * x * q * second * x,
                    drh_dr: 0.0,
                }
            }
        };
        // Euler's identity for a function of degree alpha; h + r dh/dr would cancel.
        values.drh_dr = alpha * values.h - b * values.dh_db;
        values
    }
}

/// `x 2^k`.
fn ldexp(x: f64, k: i32) -> f64 {
    x * f64::from(k).exp2()
}
