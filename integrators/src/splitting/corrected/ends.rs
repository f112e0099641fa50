//! Where a run begins, ends or is looked at: what is left of an event nearby.
//!
//! The processor takes away what a sum of kicks with half a kick at its end misses of a smooth
//! force: `(h^2/12) f'` of the impulse, `(h^2/12) f` of the displacement. A force `c^alpha
//! tau^alpha` that has begun `x h` before, or will end `x h` after, is not smooth. What is missed
//! of it is
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

/// Events up to so many steps away are seen to: farther ones leave less than 3e-5 of `c^alpha
/// h^{alpha+1}`.
const REACH: f64 = 6.0;

/// Events nearer than so many steps are too near for the processor, whose derivative of the force
/// is then that at another place.
const TOO_NEAR: f64 = 2.0;

/// What the ends of a sum of kicks do to one bond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Open: nothing.
    Open,
    /// Closed, with an event so near that the processor leaves it to the closed form.
    Near,
    /// Closed.
    Closed,
}

/// Leads the solution's state to the kernel's, where a run begins. `events`: also near events.
pub(super) fn to_kernel<S: BondFlow>(flow: &mut S, h: f64, events: bool, sides: &mut [Side]) {
    if events {
        classify(flow, h, sides);
        finish(flow, h, 1.0, sides);
    } else {
        sides.fill(Side::Closed);
    }
    flow.process(-h * h / 12.0, sides);
}

/// Leads the kernel's state at the middle of a kick to the solution's.
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

/// Gives every closed bond with an event within reach what processing leaves out.
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

/// What a bond is given for an event at `t`.
fn given(alpha: f64, path: &BondPath, t: f64, h: f64, opened: bool, side: Side, sign: f64) -> Correction {
    let [impulse, displacement] = missed(alpha, path, t, h, opened, side);
    let (impulse, displacement) = (-sign * impulse, sign * displacement);
    Correction { impulse, displacement, at: 0.0, rate: path.rate, turn: [0.0, 1.0] }
}

/// The last zero before now and the first after, if they are within reach: of the parabola, then of
/// the path.
fn near(path: &BondPath, reach: f64) -> [Option<f64>; 2] {
    let jet = path.at(0.0);
    let (g, r, a) = (jet.value, jet.rate, jet.acceleration);
    let root = (r * r - 2.0 * a * g).sqrt();
    // Both forms without cancellation; NaN where there is none.
    let zeros = [-2.0 * g / (r + root), -2.0 * g / (r - root)];
    let nearest = |past: bool| {
        let inside = |t: &f64| (*t < 0.0) == past && t.abs() < reach;
        let first = zeros.into_iter().filter(inside).min_by(|s, t| s.abs().total_cmp(&t.abs()))?;
        let refined = (0..3).fold(first, |t, _| t - path.at(t).value / path.at(t).rate);
        inside(&refined).then_some(refined)
    };
    [nearest(true), nearest(false)]
}

/// What a sum of kicks that begins now misses of the force of an event at `t`, above what
/// processing knows: of its impulse and of its moment.
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
