//! Chapter: a piece of a branch that goes down to amplitude zero, where its limit is the wave or
//! breather of the DpS equation.
//!
//! The unknowns are `b` in `a = lambda^{1/(alpha-1)} b`, at the frequency with
//! `L_1(omega) = lambda L_1(omega_1)`. Forces are homogeneous, so `b` has the equations of `a` with
//! `lambda l_k` in place of `l_k` ("Down to amplitude zero" in `README.md`).

use super::{Refused, existence::Terms, newton::Derivative, of, system::poles};
use crate::{
    certificate::{Certificate, Model},
    exact::Exact,
    interval::Interval,
};

/// What is proved of a piece down to amplitude zero, for all solutions `X` of the DpS equation of
/// one shape, whose largest first harmonic is `epsilon`.
#[derive(Clone, Debug, PartialEq)]
pub struct Zero {
    /// This holds for `0 < epsilon <=` this.
    pub epsilon: f64,
    /// `|x_n - X_n| <= constant epsilon^alpha` for a solution of the same frequency and mean
    /// strain.
    pub constant: f64,
    /// Bounds of `mu`: the frequency has `omega^2 = p + mu epsilon^{alpha-1}`.
    pub coefficient: [f64; 2],
}

impl Certificate {
    /// Whether it is a piece of a branch down to amplitude zero.
    pub fn is_to_zero(&self) -> bool {
        self.to == Some([Exact::ZERO; 2])
    }
}

/// How the frequency goes down to the free one, `p^{1/2}`: with `delta = omega^2 - p` and the terms
/// `c/(p - r omega^2 k^2)`, the resonant one, and `-c_0/(omega k)^2` of `1/L` it is
/// `delta = lambda scale (1 + c_0 delta r/(c omega^2))`.
pub(super) struct Descent {
    /// The middle of the frequencies, and half of their range.
    pub middle: [Interval; 2],
    /// Half of the derivative of `lambda/L_k` by `lambda` is `1/L_k` and its derivative by
    /// `omega^2` times these: `lambda d delta/d lambda` is between 0 and `delta most`.
    pub rates: [Interval; 2],
    /// `delta/lambda`.
    quotient: Interval,
}

impl Descent {
    pub(super) fn new(model: &Model) -> Result<Self, Refused> {
        let (poles, omega) = (poles(model), model.omega.enclosed());
        let [c, p, r] = poles[poles.len() - 1];
        let (free, above) = (p / r, omega.square() - p / r);
        if !(free.is_positive() && above.is_positive()) {
            return Err(Refused::Resonance(1));
        }
        let others: Interval = poles[..poles.len() - 1].iter().map(|other| other[0]).sum();
        let most = Interval::ONE + others * r / c * above / free;
        let scale = c / r / (others / omega.square() + c / (r * above));
        let [start, end] = [free.sqrt(), omega].map(|omega| omega / of(2));
        let rates = [Interval::ONE, above * most * Interval::new(0.0, 1.0)].map(|it| it / of(2));
        Ok(Self { middle: [start + end, end - start], rates, quotient: scale * Interval::ONE.hull(most) })
    }
}

impl Terms<'_> {
    /// What is proved of a piece down to amplitude zero with a ball of this radius, on which `q`
    /// bounds the derivative of `T`.
    ///
    /// With `T` at `lambda` and at 0, `|b(lambda) - b(0)| <= |T_lambda(b(0)) - T_0(b(0))|/(1 - q)`,
    /// and the factors change by at most `2 lambda` times `slopes`. So this is at most
    /// `rate lambda`, and the distance of `a` at most `rate lambda^{alpha/(alpha-1)}`.
    pub(super) fn zero(&self, it: &Derivative, [radius, q]: [Interval; 2]) -> Option<Zero> {
        let (system, model) = (&self.system, &self.certificate.model);
        let near: Vec<Interval> = it.weights[..system.a.len()].iter().map(|w| *w * radius).collect();
        let forces = system.known.iter().zip(&near).map(|(known, r)| known.force_change(model.alpha, *r));
        let forces: Vec<Interval> = forces.collect();
        let rows = self.block.image(&|place| system.turn(place), []);
        let rows = self.turned(rows, (&self.contacts(), &forces));
        let rate = of(2) * it.norm(&rows) / (Interval::ONE - q);
        let first = system.a.iter().zip(near).map(|(a, r)| a[1].abs() + r.ball()).reduce(Interval::max)?;
        let coefficient = Descent::new(model).ok()?.quotient / first.pow(model.alpha.less_one()?);
        let constant = rate / Interval::exact(first.lo()).pow(model.alpha);
        Some(Zero { epsilon: first.lo(), constant: constant.hi(), coefficient: [coefficient.lo(), coefficient.hi()] })
    }
}
