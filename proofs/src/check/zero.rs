//! Chapter: a piece of a branch that goes down to amplitude zero, where its limit is the wave or
//! breather of the DpS equation.
//!
//! The unknowns are `b` in `a = lambda^{1/(alpha-1)} b`, at the frequency with
//! `L_1(omega) = lambda L_1(omega_1)`, `omega_1` that of the certificate. Forces are homogeneous,
//! so `b` has the equations of `a` with `lambda l_k` in place of `l_k`. For `0 <= lambda <= 1`
//! these are smooth, and that for `k = 1` does not change; at `lambda = 0` only this one is not 0.

use super::{
    Refused,
    existence::Terms,
    newton::{Derivative, dot},
    of,
    system::{Factors, each, edge, inverse, poles},
};
use crate::{certificate::Model, interval::Interval};

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

/// `p`; `omega_1^2 - p`, which is to be positive; `-L_1(omega_1) c/r`, of the resonant term of
/// `1/L = sum c/(p - r omega^2 k^2)`; and the largest `1 + c_0 (omega^2 - p) r/(c omega^2)`, which
/// is at least 1, where the other term is `-c_0/(omega k)^2`.
fn descent(model: &Model) -> Result<[Interval; 4], Refused> {
    let (poles, end) = (poles(model), model.omega.enclosed().square());
    let [c, p, r] = poles[poles.len() - 1];
    let (free, above) = (p / r, end - p / r);
    if !(free.is_positive() && above.is_positive()) {
        return Err(Refused::Resonance(1));
    }
    let others: Interval = poles[..poles.len() - 1].iter().map(|other| other[0]).sum();
    let most = Interval::ONE + others * r / c * above / free;
    Ok([free, above, c / r / (others / end + c / (r * above)), most])
}

/// The factors `lambda/L_k` in the middle, `lambda = 1/2`, and halves of their derivatives: as
/// `delta = omega^2 - p` is `lambda scale (1 + c_0 delta r/(c omega^2))`,
/// `lambda d delta/d lambda` is between 0 and `delta most`.
pub(super) fn factors(model: &Model, enclosed: usize) -> Result<Factors, Refused> {
    let ([free, above, _, most], poles) = (descent(model)?, poles(model));
    let (omega, half) = (model.omega.enclosed(), Interval::ONE / of(2));
    let middle = [omega + free.sqrt(), omega - free.sqrt()].map(|it| half * it);
    let all = (middle[0] + middle[1].ball()).square();
    let by = half * above * most;
    let law = |k: usize| match (k, inverse(&poles, all, k)) {
        (1, _) => [inverse(&poles, omega.square(), 1)[0], Interval::ZERO],
        (_, [value, slope]) => [half * value, half * value + Interval::new(0.0, 1.0) * by * slope],
    };
    let [value, slope] = edge(&poles, all, enclosed)?;
    Ok(Factors { middle, each: each(enclosed, law)?, decay: [value, half * value + by * slope] })
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
        let turned = self.turned();
        let turns: Vec<Interval> = self.block.all.iter().map(|&(n, k)| system.turn(n, k)).collect();
        let rows = self.block.image(&turns, |n| self.turned_beyond(n) + dot(&turned[n], &forces));
        let rate = of(2) * it.norm(&rows) / (Interval::ONE - q);
        let first = system.a.iter().zip(near).map(|(a, r)| a[1].abs() + r.ball());
        let first = first.reduce(|all, one| Interval::new(all.lo().max(one.lo()), all.hi().max(one.hi())))?;
        let [_, _, scale, most] = descent(model).ok()?;
        let coefficient = scale * Interval::ONE.hull(most) / first.pow(model.alpha.less_one()?);
        let constant = rate / Interval::exact(first.lo()).pow(model.alpha);
        Some(Zero { epsilon: first.lo(), constant: constant.hi(), coefficient: [coefficient.lo(), coefficient.hi()] })
    }
}
