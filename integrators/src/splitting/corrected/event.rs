//! The correction at one onset or release.

use super::{
    bonds::{BondView, Correction},
    zeta::ZetaTable,
};
use crate::real::{Kernel, Real};

/// What corrections need to know of the law and the step.
#[derive(Clone, Debug)]
pub(super) struct Corrector {
    alpha: f64,
    table: ZetaTable,
    h: f64,
    /// `h^{alpha+2}`.
    h2: f64,
}

struct Event<'a> {
    corrector: &'a Corrector,
    view: &'a BondView,
    onset: bool,
}

impl Kernel for Event<'_> {
    type Output = Option<Correction>;

    #[inline(always)]
    fn run(self) -> Option<Correction> {
        self.corrector.correction(self.view, self.onset)
    }
}

/// A path near its zero, in time that runs into the contact.
struct Local {
    /// Rate at the zero, positive.
    rate: f64,
    acceleration: f64,
    /// Steps from the zero to the nearest kick inside.
    theta: f64,
}

impl Corrector {
    pub(super) fn new(alpha: f64, h: f64) -> Self {
        Self { alpha, table: ZetaTable::new(alpha), h, h2: h.powf(alpha + 2.0) }
    }

    /// The correction of a bond that has changed its side since the kick before; `None` where the path is too flat to have a time of change.
    pub(super) fn event(&self, view: &BondView, onset: bool) -> Option<Correction> {
        f64::run(Event { corrector: self, view, onset })
    }

    #[inline(always)]
    fn correction(&self, view: &BondView, onset: bool) -> Option<Correction> {
        let (at, rate, acceleration) = view.path.zero(self.h, onset)?;
        let sign = if onset { 1.0 } else { -1.0 };
        let theta = if onset { -at / self.h } else { 1.0 + at / self.h };
        let local = Local { rate: sign * rate, acceleration, theta: theta.clamp(0.0, 1.0) };
        let mut z = self.zeta(local.theta);
        let start = self.gradient(&local, 0.0, 0.0, &mut z);
        // One iteration of the implicit midpoint rule: the next would change it by a factor of the size of f' h^2 less.
        let half = 0.5 * view.mobility;
        let (by_overlap, by_rate) = self.gradient(&local, -half * sign * start.1, half * sign * start.0, &mut z);
        let (impulse, displacement) = (-by_overlap, sign * by_rate);
        let correction = Correction { impulse, displacement, at, rate };
        (impulse.is_finite() && displacement.is_finite()).then_some(correction)
    }

    /// `dW/dg` and `dW/dr` where overlap and rate at the time of `local` differ by `overlap` and `rate` from those of `local`; `z` are the zeta functions
    /// at `local.theta`, and are moved along.
    #[inline(always)]
    fn gradient(&self, local: &Local, overlap: f64, rate: f64, z: &mut [f64; ZetaTable::COUNT]) -> (f64, f64) {
        let Self { alpha, h, .. } = *self;
        let a = local.acceleration;
        let r = local.rate + rate;
        // The zero moves by delta, theta by `moved`.
        let delta =
            if overlap == 0.0 { 0.0 } else { -2.0 * overlap / (r + (r * r - 2.0 * a * overlap).max(0.0).sqrt()) };
        let moved = -delta / h;
        for k in (1..ZetaTable::COUNT).rev() {
            z[k] += moved * (alpha + k as f64 - 1.0) * z[k - 1];
        }
        let [_, z0, z1, z2] = *z;
        let c = r + a * delta;
        let per_c = 1.0 / c;
        let force = c * slope(alpha, c);
        let turn = a * h * per_c;
        let fade = 1.0 / (1.0 + turn * turn);
        // W = h^{alpha+2} [ c^{alpha+1} z1/(alpha+1) + fade c^alpha (a h/2) z2 ]
        let first = 0.5 * fade * force * turn;
        let by_c = self.h2 * (force * z1 + first * z2 * (alpha + 2.0 * fade * turn * turn));
        let by_theta = self.h2 * c * (force * z0 + (alpha + 2.0) * first * z1);
        let by_zero = (by_c * a - by_theta / h) * per_c;
        (-by_zero, by_c - by_zero * delta)
    }

    /// `zeta(-alpha - k, theta)` for `k = -1 .. 2`.
    #[inline(always)]
    fn zeta(&self, theta: f64) -> [f64; ZetaTable::COUNT] {
        let mut z = self.table.beyond(theta);
        let mut power = slope(self.alpha, theta);
        for z in &mut z {
            *z += power;
            power *= theta;
        }
        z
    }
}

/// `x^{alpha-1}`.
#[inline(always)]
fn slope(alpha: f64, x: f64) -> f64 {
    if alpha == 1.5 { x.sqrt() } else { x.powf(alpha - 1.0) }
}

#[cfg(test)]
mod tests {
    use super::{super::path::BondPath, *};

    /// `h sum f(t_k) p(t_k) - int f p dt` over kicks at `(theta + k) h`, by direct summation, with the end terms of Euler and Maclaurin where the force
    /// is smooth.
    fn quadrature_error(f: impl Fn(f64) -> f64, theta: f64, h: f64) -> f64 {
        const KICKS: i32 = 60;
        let at = |k: i32| (theta + f64::from(k)) * h;
        let end = at(KICKS);
        let sum: f64 = (0..KICKS).map(|k| h * f(at(k))).sum::<f64>() + 0.5 * h * f(end);
        let d = 0.1 * h;
        let slope = (8.0 * (f(end + d) - f(end - d)) - (f(end + 2.0 * d) - f(end - 2.0 * d))) / (12.0 * d);
        let third = (f(end + 2.0 * d) - 2.0 * f(end + d) + 2.0 * f(end - d) - f(end - 2.0 * d)) / (2.0 * d * d * d);
        // The integral in a variable in which the force is smooth: t = end s^4, Gauss and Legendre with two points on 20 000 parts.
        const PARTS: i32 = 20_000;
        let integral: f64 = (0..PARTS)
            .flat_map(|i| [-1.0, 1.0].map(|side| (f64::from(i) + 0.5 + side / 12f64.sqrt()) / f64::from(PARTS)))
            .map(|s| f(end * s.powi(4)) * end * 4.0 * s.powi(3) / f64::from(2 * PARTS))
            .sum();
        sum - integral - h * h / 12.0 * slope + h.powi(4) / 720.0 * third
    }

    fn view(rate: f64, acceleration: f64, overlap: f64) -> BondView {
        let path = BondPath { overlap, rate, acceleration: [acceleration, 0.0], jerk: [0.0; 2], omega: 0.0 };
        // Without mobility, so that the midpoint rule is Euler's: the error of the quadrature itself.
        BondView { path, mobility: 0.0 }
    }

    #[test]
    fn a_straight_path_is_corrected_by_what_its_sum_misses() {
        // Truth: sums and integrals of the force itself.
        let (h, c): (f64, f64) = (0.1, 1.3);
        for alpha in [1.0, 1.1, 1.5, 2.0, 2.5, 3.0] {
            let corrector = Corrector::new(alpha, h);
            for theta in [0.05, 0.3, 0.5, 0.9, 1.0] {
                let force = |tau: f64| (c * tau).powf(alpha);
                let scale = c.powf(alpha) * h.powf(alpha + 1.0);
                let onset = corrector.event(&view(c, 0.0, c * theta * h), true).unwrap();
                assert!((onset.at + theta * h).abs() < 1e-15 && (onset.rate - c).abs() < 1e-15);
                let (missed, moment) =
                    (quadrature_error(force, theta, h), quadrature_error(|tau| tau * force(tau), theta, h));
                assert!(
                    (onset.impulse + missed).abs() < 1e-7 * scale,
                    "{alpha} {theta}: {:e}",
                    (onset.impulse + missed) / scale
                );
                assert!(
                    (onset.displacement - moment).abs() < 1e-6 * scale * h,
                    "{alpha} {theta}: {:e} {:e}",
                    onset.displacement / (scale * h),
                    moment / (scale * h)
                );
                // A release is the mirror image.
                let release = corrector.event(&view(-c, 0.0, -c * (1.0 - theta) * h), false).unwrap();
                assert!((release.impulse - onset.impulse).abs() < 1e-12 * scale);
                assert!((release.displacement + onset.displacement).abs() < 1e-12 * scale * h);
            }
        }
    }

    #[test]
    fn a_curved_path_is_corrected_but_for_two_powers_of_the_step() {
        let (c, a): (f64, f64) = (1.3, -0.8);
        for alpha in [1.2, 1.5, 2.5] {
            let error = |h: f64| {
                let theta = 0.4;
                let tau = theta * h;
                let path = view(c + a * tau, a, tau * (c + 0.5 * a * tau));
                let got = Corrector::new(alpha, h).event(&path, true).unwrap();
                // Sums to the same distance whatever the step, so that only the onset is in it.
                let force = |tau: f64| (tau * (c + 0.5 * a * tau)).max(0.0).powf(alpha);
                (got.impulse + quadrature_error(force, theta, h)).abs() / h.powf(alpha + 1.0)
            };
            let (coarse, fine) = (error(4e-3), error(2e-3));
            let order = (coarse / fine).log2();
            assert!((order - 2.0).abs() < 0.1, "{alpha}: {coarse:e} {fine:e} {order}");
        }
    }

    #[test]
    fn impulse_and_displacement_are_derivatives_of_one_function() {
        // Mixed derivatives of W agree: -d(impulse)/dg' = d(displacement)/dg.
        let corrector = Corrector::new(1.5, 0.2);
        for (rate, acceleration, theta) in [(1.0, 0.5, 0.3), (0.4, -0.9, 0.8), (0.1, 2.0, 0.5)] {
            let local = Local { rate, acceleration, theta };
            let d = 1e-6;
            let by = |overlap, rate| corrector.gradient(&local, overlap, rate, &mut corrector.zeta(theta));
            let mixed = (by(0.0, d).0 - by(0.0, -d).0) / (2.0 * d);
            let other = (by(d, 0.0).1 - by(-d, 0.0).1) / (2.0 * d);
            assert!((mixed - other).abs() < 1e-10, "{mixed} {other}");
        }
    }

    #[test]
    fn paths_without_a_time_of_change_are_left_alone() {
        let corrector = Corrector::new(1.5, 0.1);
        for path in [view(0.0, 0.0, 1e-3), view(f64::NAN, 0.0, 1e-3), view(-1.0, 0.0, 1e-3), view(1e-200, 0.0, 1e-200)]
        {
            let correction = corrector.event(&path, true);
            assert!(correction.is_none_or(|c| c.impulse.abs() < 1e-200), "{correction:?}");
        }
        // A grazing path bends back at once: what it gets stays of the size of what it does.
        let grazing = corrector.event(&view(-1e-6, -1.0, 5e-10), true).unwrap();
        assert!(grazing.impulse.abs() < 1e-6, "{grazing:?}");
    }
}
