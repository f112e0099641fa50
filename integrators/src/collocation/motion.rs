//! The overlap of a bond and its rate at a time of the window: without contact forces, as the
//! forces at the window's start predict it, and by all forces.

use super::{
    bond::Beside,
    chain::Path,
    flow::Ahead,
    kernels::apart,
    panel::{Frame, Times},
    panels::{Panels, Shared},
    prescribed::Prescribed,
    series::sin_cos,
};
use crate::kernel;

/// A release is looked for up to this number of window lengths after the window's end. Chosen, not
/// measured: a later release does not matter for the accuracy of the panels.
pub(super) const AHEAD: f64 = 1.5;

/// The earliest release after a window of length `h`: that of a contact which the search sees
/// closed at the end, though the overlap there is zero but for rounding.
pub(super) fn just_after(h: f64) -> f64 {
    h * (1.0 + f64::EPSILON)
}

/// Bound for the relative rounding error of displacements by forces in a window. Chosen: a sum of
/// some 64 terms.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// For each side of a bond, the sum of forces on it at the window's start and its time derivative;
/// one pair for both sides if `S = 1`.
pub(super) type Drive<const S: usize> = [[f64; 2]; S];

/// `sin`, `cos` and `lag` of one side at a time: `sin(omega t)`, `cos(omega t)` and 0, or the
/// functions of [`Flow`](super::flow::Flow) where the site is damped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rotation {
    pub(super) sin: f64,
    pub(super) cos: f64,
    pub(super) lag: f64,
    /// See [`Ahead`](super::flow::Ahead); set only where the site is damped.
    pub(super) ramps: [f64; 3],
}

impl Rotation {
    /// The values at `t = 0`.
    pub(super) const NONE: Self = Self { sin: 0.0, cos: 1.0, lag: 0.0, ramps: [0.0; 3] };
}

/// [`Rotation`] for each side of a bond.
pub(super) type Rotations<const S: usize> = [Rotation; S];

/// An overlap without contact forces: the sum of its linear path and of the part that drives
/// prescribe.
pub(super) type FreeMotion<'a, const S: usize> = (&'a [Path; S], Option<&'a Prescribed>);

/// The functions of [`Rotation`] at a time, for each side of a bond.
#[inline(always)]
pub(super) fn turn<const M: usize, const S: usize>(frame: &Frame<'_, M, S>, t: f64) -> Rotations<S> {
    let mut turn = [Rotation::NONE; S];
    for side in 0..S {
        let omega = frame.link.sides[side].omega;
        if omega != 0.0 {
            (turn[side].sin, turn[side].cos) = sin_cos(omega * t);
        }
    }
    if frame.link.damped() {
        let turn = &mut turn;
        apart(kernel!(for side in 0..S {
            if let Some(flow) = frame.link.flow(side) {
                let Ahead { position: [lag, cos, sin], ramps } = flow.ahead(t);
                turn[side] = Rotation { sin, cos, lag, ramps };
            }
        }));
    }
    turn
}

/// `int_0^t K(t - s) s^k/k! ds` for `k = 0, 1`, on a side.
#[inline(always)]
pub(super) fn ramps<const M: usize, const S: usize>(
    frame: &Frame<'_, M, S>,
    side: usize,
    t: f64,
    Rotation { sin, cos, .. }: Rotation,
) -> (f64, f64) {
    let (kernel, weight) = (&frame.link.sides[side], frame.link.weight(side));
    let (free2, free3) = (0.5 * t * t, t * t * t * (1.0 / 6.0));
    if kernel.omega * frame.h < 1e-3 {
        return (weight * free2, weight * free3);
    }
    let per_omega = kernel.per_omega;
    let scale = kernel.mu_per_omega * per_omega;
    (kernel.m * free2 + scale * (1.0 - cos), kernel.m * free3 + scale * (t - sin * per_omega))
}

/// `path + sum_k rates[k] int_0^t K(t - s) s^k/k! ds`, `k = 0, 1, 2`, on a side: a path, and
/// coefficients of `t^2, t^3, t^4`.
#[inline(always)]
pub(super) fn ramped<const M: usize, const S: usize>(
    frame: &Frame<'_, M, S>,
    side: usize,
    mut path: Path,
    rates: [f64; 3],
) -> (Path, [f64; 3]) {
    if let Some(flow) = frame.link.flow(side) {
        return (path, flow.ramped(rates));
    }
    let (kernel, weight) = (&frame.link.sides[side], frame.link.weight(side));
    let free = [0.5 * rates[0], rates[1] * (1.0 / 6.0), rates[2] * (1.0 / 24.0)];
    if kernel.omega * frame.h < 1e-2 {
        return (path, free.map(|free| weight * free));
    }
    // int K s^k/k!: m t^{k+2}/(k+2)!, and mu times the same integral of sin(omega t)/omega.
    let per_square = kernel.per_omega * kernel.per_omega;
    let swing = kernel.mu * per_square * (rates[0] - rates[2] * per_square);
    let moved = kernel.mu * per_square * rates[1];
    path[0] += swing;
    path[2] -= swing;
    path[1] += moved;
    path[3] -= moved * kernel.per_omega;
    let [a, b, c] = free;
    (path, [kernel.m * a + 0.5 * kernel.mu * per_square * rates[2], kernel.m * b, kernel.m * c])
}

impl<const S: usize> Times<'_, 1, S> {
    /// An overlap without contact forces.
    #[inline(always)]
    fn unforced(&self, (path, known): FreeMotion<S>) -> f64 {
        let mut overlap = self.along(path, 0);
        if S != 1 {
            overlap += self.lagging(path, 0);
            if let Some(known) = known {
                overlap += known.at(self.tau)[0];
            }
        }
        overlap
    }
}

/// An overlap without contact forces at the time `t`, with the functions of [`Rotation`] at `t`.
#[inline(always)]
fn along<const S: usize>((path, known): FreeMotion<S>, t: f64, turn: &Rotations<S>) -> f64 {
    let (mut lag, mut sin, mut cos) = ([[0.0]; S], [[0.0]; S], [[0.0]; S]);
    for side in 0..S {
        (lag[side], sin[side], cos[side]) = ([turn[side].lag], [turn[side].sin], [turn[side].cos]);
    }
    Times { tau: &[t], lag: &lag, cos: &cos, sin: &sin }.unforced((path, known))
}

/// The overlap that the forces at the start of the window predict.
#[inline(always)]
pub(super) fn predicted<const M: usize, const S: usize>(
    frame: &Frame<'_, M, S>,
    motion: FreeMotion<S>,
    drive: &Drive<S>,
    t: f64,
) -> f64 {
    predicted_at(frame, motion, drive, t, &turn(frame, t))
}

/// As [`predicted`], with the functions of [`Rotation`] at `t` given.
#[inline(always)]
pub(super) fn predicted_at<const M: usize, const S: usize>(
    frame: &Frame<'_, M, S>,
    motion: FreeMotion<S>,
    drive: &Drive<S>,
    t: f64,
    turn: &Rotations<S>,
) -> f64 {
    let mut overlap = along(motion, t, turn);
    if frame.link.damped() {
        return overlap + ramped_damped(frame, drive, t, turn);
    }
    for side in 0..S {
        let (k2, k3) = ramps(frame, side, t, turn[side]);
        overlap = overlap + drive[side][0] * k2 + drive[side][1] * k3;
    }
    overlap
}

/// The displacement by the extrapolated forces where a site is damped.
#[inline(never)]
fn ramped_damped<const M: usize, const S: usize>(
    frame: &Frame<'_, M, S>,
    drive: &Drive<S>,
    t: f64,
    turn: &Rotations<S>,
) -> f64 {
    let mut sum = 0.0;
    for side in 0..S {
        let (k2, k3) = match frame.link.flow(side) {
            Some(_) => (turn[side].ramps[1], turn[side].ramps[2]),
            None => ramps(frame, side, t, turn[side]),
        };
        sum += drive[side][0] * k2 + drive[side][1] * k3;
    }
    sum
}

/// The rate of the overlap that the forces at the start of the window predict.
pub(super) fn predicted_rate<const M: usize, const S: usize>(
    frame: &Frame<'_, M, S>,
    (path, known): FreeMotion<S>,
    drive: &Drive<S>,
    t: f64,
) -> f64 {
    let (turned, mut rate) = (turn(frame, t), known.map_or(0.0, |known| known.rates_at(&[t])[0]));
    for side in 0..S {
        let velocity = frame.link.velocity(side, &[t], &[turned[side].cos], &[turned[side].sin]);
        for k in 0..3 {
            rate += path[side][k + 1] * velocity[k][0];
        }
        let moved = match frame.link.flow(side) {
            Some(_) => turned[side].ramps[1],
            None => ramps(frame, side, t, turned[side]).0,
        };
        rate += drive[side][0] * frame.link.ramp(side, t, turned[side]) + drive[side][1] * moved;
    }
    rate
}

/// The overlap at a time of the window, from all forces; the bond's own are in `panels`.
pub(super) fn overlap_at<const M: usize, const S: usize>(
    motion: FreeMotion<S>,
    (panels, own): (&Panels<M, S>, f64),
    frame: &Frame<'_, M, S>,
    beside: [Beside<M, S>; 2],
    t: f64,
) -> f64 {
    let [lag, cos, sin] = exact_turn(frame, t);
    let times = Times { tau: &[t], lag: &lag, cos: &cos, sin: &sin };
    let (mut out, mut by_own) = ([times.unforced(motion)], [0.0]);
    panels.own_influence(times, -own, &mut by_own);
    for (k, bond) in beside.into_iter().enumerate() {
        if let Some(bond) = bond {
            bond.panels.influence(times, Shared::with::<S>(k), 1.0, &mut out);
        }
    }
    out[0] + by_own[0]
}

/// `lag`, `cos` and `sin` of each side at a time, see [`Rotation`], with the sine and cosine of the
/// standard library.
pub(super) fn exact_turn<const M: usize, const S: usize>(frame: &Frame<'_, M, S>, t: f64) -> [[[f64; 1]; S]; 3] {
    let mut turn = [[[0.0]; S], [[1.0]; S], [[0.0]; S]];
    for side in 0..S {
        let omega = frame.link.sides[side].omega;
        if let Some(flow) = frame.link.flow(side) {
            [turn[0][side], turn[1][side], turn[2][side]] = flow.position(&[t]);
        } else if omega != 0.0 {
            let (sin, cos) = (omega * t).sin_cos();
            (turn[1][side], turn[2][side]) = ([cos], [sin]);
        }
    }
    turn
}

/// The rate of the overlap at a time of the window, from all forces; the bond's own are in
/// `panels`.
pub(super) fn rate_at<const M: usize, const S: usize>(
    (path, known): FreeMotion<S>,
    (panels, own): (&Panels<M, S>, f64),
    frame: &Frame<'_, M, S>,
    beside: [Beside<M, S>; 2],
    t: f64,
) -> f64 {
    let [_, cos, sin] = exact_turn(frame, t);
    let mut rate = known.map_or(0.0, |known: &Prescribed| known.rates_at(&[t])[0]);
    for side in 0..S {
        let velocity = &frame.link.velocity(side, &[t], &cos[side], &sin[side]);
        for k in 0..3 {
            rate += path[side][k + 1] * velocity[k][0];
        }
        rate -= own * panels.velocity_at(t, velocity, side);
        // For two sides a neighbour's other side is the one that is shared.
        if let Some(bond) = beside[side] {
            rate += bond.panels.velocity_at(t, velocity, S - 1 - side);
        }
    }
    rate
}
