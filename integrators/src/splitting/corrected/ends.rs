//! End terms of events near a time at which a run begins, ends or is sampled.
//!
//! A sum of kicks with half a kick at its end has an error at that end. For a smooth force the
//! processor removes it: `(h^2/12) f'` of the impulse, `(h^2/12) f` of the displacement. A force
//! `c^alpha tau^alpha` that has begun `x h` before, or will end `x h` after, is not smooth. Its
//! error is
//!
//! ```text
//! c^alpha h^{alpha+1} Z_alpha(x),   Z_z(x) = zeta(-z, 1 + x) + x^z/2 + x^{z+1}/(z + 1)  ->  -(z/12) x^{z-1} + O(x^{z-3})
//! ```

use super::{
    CHANGE,
    bonds::{BondFlow, BondView, Correction, Dependence},
    path::BondPath,
    zeta::hurwitz,
};

/// Largest distance of an event that is corrected, in steps: farther ones leave less than 3e-5 of
/// `c^alpha h^{alpha+1}`.
const REACH: f64 = 6.0;

/// Smallest distance of an event, in steps, at which the processor corrects the impulse. For nearer
/// ones it would take the derivative of the force at another overlap.
const TOO_NEAR: f64 = 2.0;

/// How the end terms of a sum of kicks treat one bond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Open: it has no end terms.
    Open,
    /// Closed, with an event so near that only the closed form corrects its impulse, not the
    /// processor.
    Near,
    /// Closed.
    Closed,
}

/// Maps the state of the solution to that of the kernel, where a run begins. `events`: whether the
/// end terms of nearby events are included.
pub(super) fn to_kernel<S: BondFlow>(flow: &mut S, h: f64, events: bool, sides: &mut [Side]) {
    if events {
        classify(flow, h, sides);
        finish(flow, h, 1.0, sides);
    } else {
        sides.fill(Side::Closed);
    }
    flow.process(-h * h / 12.0, sides);
}

/// Maps the state of the kernel at the middle of a kick to that of the solution.
pub(super) fn to_solution<S: BondFlow>(flow: &mut S, h: f64, events: bool, sides: &mut [Side]) {
    if events {
        classify(flow, h, sides);
    } else {
        sides.fill(Side::Closed);
    }
    flow.process(h * h / 12.0, sides);
    if events {
        flow.survey();
        finish(flow, h, -1.0, sides);
    }
}

fn classify<S: BondFlow>(flow: &S, h: f64, sides: &mut [Side]) {
    for (bond, side) in sides.iter_mut().enumerate() {
        let path = flow.path(bond);
        *side = if path.overlap <= 0.0 {
            Side::Open
        } else if near(&path, TOO_NEAR * h).iter().any(Option::is_some) {
            Side::Near
        } else {
            Side::Closed
        };
    }
}

/// Gives every closed bond with an event within reach the part of the end terms that the processor
/// leaves out.
fn finish<S: BondFlow>(flow: &mut S, h: f64, sign: f64, sides: &[Side]) {
    let alpha = flow.exponent();
    for (bond, &side) in sides.iter().enumerate() {
        let path = flow.path(bond);
        if side == Side::Open || path.overlap <= 0.0 {
            continue;
        }
        for (time, opened) in near(&path, REACH * h).into_iter().zip([true, false]) {
            if let Some(t) = time {
                let correction = given(alpha, &path, t, h, opened, side, sign);
                if S::CARRIES {
                    let of = |views: &[BondView], out: &mut Vec<Option<Correction>>| {
                        out.extend(views.iter().map(|view| {
                            let t = near(&view.path, REACH * h)[usize::from(!opened)]?;
                            Some(given(alpha, &view.path, t, h, opened, side, sign))
                        }));
                    };
                    flow.depends(bond, Dependence { h: 0.0, change: CHANGE, kicks: false, of: &of });
                }
                flow.correct([(bond, &correction)].into_iter());
            }
        }
    }
}

/// The correction of a bond for an event at `t`.
fn given(alpha: f64, path: &BondPath, t: f64, h: f64, opened: bool, side: Side, sign: f64) -> Correction {
    let [impulse, displacement] = missed(alpha, path, t, h, opened, side);
    let (impulse, displacement) = (-sign * impulse, sign * displacement);
    Correction { impulse, displacement, at: 0.0, rate: path.rate, turn: [0.0, 1.0] }
}

/// The last zero of the path before now and the first one after, if they are within reach. Newton's
/// method finds them from the zeros of the parabola.
fn near(path: &BondPath, reach: f64) -> [Option<f64>; 2] {
    let jet = path.at(0.0);
    let (g, r, a) = (jet.value, jet.rate, jet.acceleration);
    let root = (r * r - 2.0 * a * g).sqrt();
    // In this form the nearer zero suffers no cancellation. NaN where there is no zero.
    let zeros = [-2.0 * g / (r + root), -2.0 * g / (r - root)];
    let nearest = |past: bool| {
        let inside = |t: &f64| (*t < 0.0) == past && t.abs() < reach;
        let first = zeros.into_iter().filter(inside).min_by(|s, t| s.abs().total_cmp(&t.abs()))?;
        let refined = (0..3).fold(first, |t, _| t - path.at(t).value / path.at(t).rate);
        inside(&refined).then_some(refined)
    };
    [nearest(true), nearest(false)]
}

/// Error of a sum of kicks that begins now, for the force of an event at `t`, without the part that
/// the processor removes: of the impulse and of the first moment.
fn missed(alpha: f64, path: &BondPath, t: f64, h: f64, opened: bool, side: Side) -> [f64; 2] {
    let jet = path.at(t);
    let (c, x) = (jet.rate.abs(), t.abs() / h);
    let turn = jet.acceleration * h / c;
    let z = |z: f64| hurwitz(z, 1.0 + x) + 0.5 * x.powf(z) + x.powf(z + 1.0) / (z + 1.0);
    let (z0, z1) = (z(alpha), z(alpha + 1.0));
    let below = x.powf(alpha - 1.0) / 12.0;
    let scale = c.powf(alpha) * h.powf(alpha + 1.0);
    // The processor's share of the impulse.
    let known = if side == Side::Near { 0.0 } else { below };
    let curved = if turn.abs() < 1.0 { 0.5 * alpha * turn * (z1 + (alpha + 1.0) * known * x) } else { 0.0 };
    let sign = if opened { 1.0 } else { -1.0 };
    [sign * scale * (z0 + alpha * known + curved), scale * h * (z1 - x * z0 + below * x)]
}
