//! Reasons as a text, and doubles as fractions.

use crate::{check::Bounds, exact::Exact, interval::Interval};
use std::fmt::{Display, Formatter, Result};

impl Interval {
    /// Whether it holds a number.
    pub fn holds(self, x: f64) -> bool {
        self.lo() <= x && x <= self.hi()
    }
}

impl Exact {
    /// A fraction whose nearest double this is: the one with the smallest denominator up to 1000,
    /// else the shortest decimal, else one by a continued fraction; `None` if it needs more than 64
    /// bits.
    ///
    /// ```
    /// use hertzchain_proofs::exact::Exact;
    /// let text = |x: f64| Exact::of_double(x).unwrap().to_string();
    /// assert_eq!([text(1.0 / 3.0), text(0.333), text(-2.5)], ["1/3", "333/1000", "-5/2"]);
    /// ```
    pub fn of_double(x: f64) -> Option<Self> {
        let fraction = (1..=1000_i64).find_map(|den| {
            let num = (x * den as f64).round();
            (num.abs() < 1e6 && num / den as f64 == x).then(|| Self::new(num as i64, den)).flatten()
        });
        let decimal = || {
            let text = x.to_string();
            let (whole, part) = text.split_once('.').unwrap_or((&text, ""));
            Self::new(format!("{whole}{part}").parse().ok()?, 10_i64.checked_pow(part.len().try_into().ok()?)?)
        };
        let (mut rest, mut last, mut this) = (x.abs(), [0_i64, 1], [1_i64, 0]);
        let mut convergent = || {
            let whole = rest.floor();
            rest = 1.0 / (rest - whole);
            let [num, den] = [0, 1].map(|i| (whole as i64).checked_mul(this[i]).and_then(|it| it.checked_add(last[i])));
            (last, this) = (this, [num?, den?]);
            Self::new(if x < 0.0 { -this[0] } else { this[0] }, this[1])
        };
        let mut convergents = (0..40).map_while(|_| convergent());
        fraction.or_else(decimal).or_else(|| convergents.find(|it| it.num() as f64 / it.den() as f64 == x))
    }
}

/// Why nothing is proved.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// The text is no certificate: the rule that it breaks.
    Certificate(String),
    /// This multiple of the frequency is not shown to be another one than that of the free
    /// oscillation of the resonators or, beyond the enclosed harmonics, a larger one.
    Resonance(usize),
    /// The check was asked to end.
    Stopped,
    /// The contact force could not be enclosed: the series does not converge, or is zero.
    Moments,
    /// The inequalities have no solution.
    Bounds(Bounds),
    /// The ball, of this radius, may hold the state at rest, or an orbit of a shorter period, since
    /// the first harmonic is only this one.
    Rest(f64, f64),
    /// A multiplier is not proved.
    Multiplier {
        /// Upper bound of `|1 - A M|`.
        z1: f64,
        /// If this is below 1, bounds of `g` at both growth rates.
        g: Option<[[f64; 2]; 2]>,
    },
    /// A perturbation of a wave is not proved.
    Bloch {
        /// Where its piece begins.
        p_over_pi: Exact,
        /// Upper bound of the derivative of `T`.
        q: f64,
        /// If this is below 1, the radius about `lambda` that is needed.
        radius: f64,
    },
    /// The standing wave far from the centre of a breather is not proved.
    Background(Box<Self>),
    /// The approximate inverse `A` could have a kernel: the bound of `1 - B A`.
    Kernel(f64),
}

impl Display for Refused {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Certificate(rule) => write!(f, "no certificate: {rule}"),
            Self::Resonance(k) => write!(
                f,
                "harmonic {k} is not separated from the free frequency of beads and resonators, which has to be below \
                 all harmonics that are not enclosed"
            ),
            Self::Stopped => f.write_str("the check was asked to end"),
            Self::Moments => f.write_str("the contact force of the cosine sum could not be enclosed"),
            Self::Bounds(Bounds { y0, z1 }) => {
                let why = match (y0 + z1).is_finite() {
                    true => "admit no radius: the cosine sum is too far from a solution, or the block too small",
                    false => "are not all finite",
                };
                write!(f, "Y0 = {y0:.2e}, Z1 = {z1:.2e} {why}")
            }
            Self::Multiplier { z1, g: None } => write!(
                f,
                "the multiplier: perturbations are not separated from others, their Z1 = {z1:.2e} is not below 1"
            ),
            Self::Multiplier { g: Some([[a, b], [c, d]]), .. } => write!(
                f,
                "the multiplier: g is not shown to be 0 somewhere, by {a:.2e} to {b:.2e} and {c:.2e} to {d:.2e}"
            ),
            Self::Bloch { p_over_pi, q, radius } => write!(
                f,
                "the perturbations from p = {p_over_pi} pi on: q = {q:.2e} is not below 1, or the radius is to be {radius:.2e}"
            ),
            Self::Background(why) => write!(f, "the standing wave far from the centre: {why}"),
            Self::Kernel(bound) => {
                write!(f, "|1 - B A| < 1 is not shown, but {bound:.2e} as its bound: the band is too narrow")
            }
            Self::Rest(radius, first) => write!(
                f,
                "the radius {radius:.2e} is not below the first harmonic {first:.2e}, so the solution could be at \
                 rest, or have a shorter period"
            ),
        }
    }
}

impl std::error::Error for Refused {}

/// Why a piece does not continue the one before it.
#[derive(Clone, Debug, PartialEq)]
pub enum Gap {
    /// It is not proved.
    Refused(Refused),
    /// It is of another chain or kind of orbit.
    Other,
    /// It does not begin where the one before it ends.
    Nodes,
    /// No ball lies within the other's ball of uniqueness: the radius that is needed, and that of
    /// uniqueness.
    Apart(f64, f64),
}

impl Display for Gap {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Refused(why) => why.fmt(f),
            Self::Other => f.write_str("it is of another chain or kind of orbit than the piece before it"),
            Self::Nodes => f.write_str("it does not begin where the piece before it ends"),
            Self::Apart(needed, unique) => write!(
                f,
                "the ball of the piece before it needs a radius of uniqueness of {needed:.2e} here, not {unique:.2e}"
            ),
        }
    }
}
