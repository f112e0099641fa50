//! Chapter: a piece of a branch that goes down to amplitude zero, where its limit is the wave or
//! breather of the DpS equation.
//!
//! The unknowns are `b` in `a = lambda^{1/(alpha-1)} b`, at the frequency with `L_1(omega) = lambda
//! L_1(omega_1)`, `omega_1` that of the certificate. Forces are homogeneous, so `b` has the equations of
//! `a` with `lambda l_k` in place of `l_k`. For `0 <= lambda <= 1` these are smooth, and that for `k = 1`
//! does not change; at `lambda = 0` only this one is not 0.

use super::{Refused, existence::Terms, newton::Derivative, newton::dot, of, system::poles};
use crate::{certificate::Model, interval::Interval};

/// What is proved of a piece down to amplitude zero, for all solutions `X` of the DpS equation of one
/// shape, whose largest first harmonic is `epsilon`.
#[derive(Clone, Debug, PartialEq)]
pub struct Zero {
    /// This holds for `0 < epsilon <=` this.
    pub epsilon: f64,
    /// `|x_n - X_n| <= constant epsilon^alpha` for a solution of the same frequency and mean strain.
    pub constant: f64,
    /// Bounds of `mu`: the frequency has `omega^2 = p + mu epsilon^{alpha-1}`.
    pub coefficient: [f64; 2],
}

/// How the frequency goes down to the free one.
pub(super) struct Descent {
    /// `p`, and `omega_1^2 - p`, which is to be positive.
    squares: [Interval; 2],
    /// `-L_1(omega_1) c/r`, of the resonant term of `1/L = sum c/(p - r omega^2 k^2)`.
    scale: Interval,
    /// `1 + c_0 (omega^2 - p) r/(c omega^2)` is from 1 to this, where the other term is `-c_0/(omega k)^2`.
    most: Interval,
}

impl Descent {
    pub(super) fn new(model: &Model) -> Result<Self, Refused> {
        let (poles, end) = (poles(model), model.omega.enclosed().square());
        let [c, p, r] = poles[poles.len() - 1];
        let (free, above) = (p / r, end - p / r);
        if !(free.is_positive() && above.is_positive()) {
            return Err(Refused::Resonance(1));
        }
        let others: Interval = poles[..poles.len() - 1].iter().map(|other| other[0]).sum();
        let most = Interval::ONE + others * r / c * above / free;
        let scale = c / r / (others / end + c / (r * above));
        Ok(Self { squares: [free, above], scale, most })
    }

    /// The middle of the frequencies, and half of their range.
    pub(super) fn middle(&self, model: &Model) -> [Interval; 2] {
        let [free, end] = [self.squares[0].sqrt(), model.omega.enclosed()].map(|omega| omega / of(2));
        [free + end, end - free]
    }

    /// The factors `lambda/L_k` up to `count` at `lambda = 1/2` (-1 for `k = 0`), and half of their
    /// derivatives for all `lambda`; for each of both `c` with `c/k^2` as a bound beyond.
    ///
    /// `delta = omega^2 - p` is `lambda scale (1 + c_0 delta r/(c omega^2))`, so `lambda d delta/d lambda` is
    /// between 0 and `delta most`. A term of `1/L_k` is `c/(p' - r k^2 omega^2)` with
    /// `r k^2 p > p'` for `k > 1`; so `k^2` times it, and times its derivative, fall with `k`.
    pub(super) fn inverses(&self, model: &Model, count: usize) -> ([Vec<Interval>; 2], [Interval; 2]) {
        let (poles, [free, above]) = (poles(model), self.squares);
        let unit = Interval::new(0.0, 1.0);
        let (all, rate) = (free + above * unit, above * self.most * unit);
        // The sums of the terms, and of their derivatives by omega^2.
        let sums = |square: Interval, k: usize| -> [Interval; 2] {
            let den = |&[_, p, r]: &[Interval; 3]| p - r * of(k * k) * square;
            let term = |pole: &[Interval; 3], power: Interval| pole[0] * power / den(pole);
            let slope = |pole: &[Interval; 3]| term(pole, pole[2] * of(k * k) / den(pole));
            [poles.iter().map(|pole| term(pole, Interval::ONE)).sum(), poles.iter().map(slope).sum()]
        };
        let own = |k: usize| match k {
            0 => [-Interval::ONE, Interval::ZERO],
            1 => [sums(free + above, 1)[0], Interval::ZERO],
            _ => {
                let [value, slope] = sums(all, k);
                [value / of(2), (value + rate * slope) / of(2)]
            }
        };
        let known: Vec<[Interval; 2]> = (0..=count).map(own).collect();
        let [value, slope] = sums(free, count + 1).map(|it| it.abs() * of((count + 1) * (count + 1)));
        let decay = [value, (value + rate.abs() * slope) / of(2)];
        ([0, 1].map(|i| known.iter().map(|it| it[i]).collect()), decay)
    }
}

impl Terms<'_> {
    /// What is proved of a piece down to amplitude zero with a ball of this radius, on which `q` bounds
    /// the derivative of `T`.
    ///
    /// With `T` at `lambda` and at 0, `|b(lambda) - b(0)| <= |T_lambda(b(0)) - T_0(b(0))|/(1 - q)`, and the
    /// factors change by at most `2 lambda` times `slopes`. So this is at most `rate lambda`, and the
    /// distance of `a` at most `rate lambda^{alpha/(alpha-1)}`.
    pub(super) fn zero(&self, it: &Derivative, [radius, q]: [Interval; 2]) -> Option<Zero> {
        let Self { certificate, system, block, tails, turned, beyond_block, .. } = self;
        let (model, sites) = (&certificate.model, system.a.len());
        let near = || it.weights[..sites].iter().map(|w| *w * radius);
        let forces: Vec<Interval> =
            system.known.iter().zip(near()).map(|(known, r)| known.force_change(model.alpha, r)).collect();
        let change = |n: usize, k: usize| system.slopes[k] * system.force(n, k);
        let changes: Vec<Interval> = block.all.iter().map(|&(n, k, _)| change(n, k)).collect();
        let mut rows = block.by_site(&|i| dot(&block.inverse[i], &changes).abs());
        for (n, row) in rows.iter_mut().enumerate() {
            let moduli = system.moduli(n);
            let contacts: Vec<Interval> =
                turned.iter().zip(&moduli).map(|(turned, e)| turned[n] + beyond_block[1] * *e).collect();
            let own = (certificate.block + 1..=certificate.enclosed).filter(|k| n < sites && system.has(n, *k));
            let beyond = moduli.iter().zip(tails).map(|(e, tail)| *e * tail[0]);
            *row = *row
                + dot(&contacts, &forces)
                + own.map(|k| change(n, k).abs()).sum()
                + system.tails()[1] * beyond.sum();
        }
        let rate = of(2) * it.norm(&rows) / (Interval::ONE - q);
        let first = system.a.iter().zip(near()).map(|(a, r)| a[1].abs() + r.ball());
        let first = first.reduce(|all, one| Interval::new(all.lo().max(one.lo()), all.hi().max(one.hi())))?;
        let power = model.alpha.less_one()?;
        let Descent { scale, most, .. } = Descent::new(model).ok()?;
        let coefficient = scale * Interval::ONE.hull(most) / first.pow(power);
        let constant = rate / (Interval::exact(first.lo()).pow(model.alpha));
        Some(Zero { epsilon: first.lo(), constant: constant.hi(), coefficient: [coefficient.lo(), coefficient.hi()] })
    }
}
