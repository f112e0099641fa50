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
//!
//! Zeros and errors are computed a register of bonds at a time, as a sample costs several of them
//! for every closed bond.

use super::{
    bonds::{BondFlow, Correction, Side},
    event::{Corrector, slope},
    pack::Pack,
    path::{BondPath, Paths},
};
use crate::{real::Vector, with_narrow};
use std::cell::OnceCell;

/// Largest distance of an event that is corrected, in steps: farther ones leave less than 3e-5 of
/// `c^alpha h^{alpha+1}`.
const REACH: u32 = 6;

/// Smallest distance of an event, in steps, at which the processor corrects the impulse. For nearer
/// ones it would take the derivative of the force at another overlap.
const TOO_NEAR: f64 = 2.0;

/// The ends of a run in steps of `h`: where it begins, ends or is sampled.
pub(super) struct Ends<'a> {
    pub(super) h: f64,
    /// The tables for nearby events, made at their first use; `None` if events have no end terms.
    pub(super) corrector: Option<&'a OnceCell<Corrector>>,
}

/// An event near an end.
#[derive(Clone, Copy, Debug)]
struct Event {
    path: BondPath,
    /// Time from now.
    t: f64,
    /// Whether it is an onset, in the past; else it is a release, in the future.
    onset: bool,
    /// Whether the processor leaves the impulse to the closed form.
    near: bool,
}

impl Ends<'_> {
    /// Maps the state of the solution to that of the kernel, where a run begins.
    pub(super) fn to_kernel<S: BondFlow>(&self, flow: &mut S, sides: &mut [Side]) {
        self.classify(flow, sides);
        self.finish(flow, 1.0, sides);
        flow.process(-self.h * self.h / 12.0, sides);
    }

    /// Maps the state of the kernel at the middle of a kick to that of the solution.
    pub(super) fn to_solution<S: BondFlow>(&self, flow: &mut S, sides: &mut [Side]) {
        self.classify(flow, sides);
        flow.process(self.h * self.h / 12.0, sides);
        if self.corrector.is_some() {
            flow.evaluate();
            self.finish(flow, -1.0, sides);
        }
    }

    fn classify<S: BondFlow>(&self, flow: &S, sides: &mut [Side]) {
        if self.corrector.is_none() {
            return sides.fill(Side::Closed);
        }
        let (bonds, paths) = closed(flow, 0..sides.len());
        sides.fill(Side::Open);
        for (bond, zeros) in bonds.into_iter().zip(nearest_zeros(&paths, TOO_NEAR * self.h)) {
            sides[bond] = if zeros == [None; 2] { Side::Closed } else { Side::Near };
        }
    }

    /// Gives every closed bond with an event within reach the part of the end terms that the
    /// processor leaves out.
    fn finish<S: BondFlow>(&self, flow: &mut S, sign: f64, sides: &[Side]) {
        let Some(corrector) = self.corrector else { return };
        let (closed, paths) = closed(flow, (0..sides.len()).filter(|&bond| sides[bond] != Side::Open));
        let reach = f64::from(REACH) * self.h;
        let (mut bonds, mut events) = (Vec::new(), Vec::new());
        for ((bond, path), zeros) in closed.into_iter().zip(&paths).zip(nearest_zeros(&paths, reach)) {
            for (t, onset) in zeros.into_iter().zip([true, false]) {
                let near = sides[bond] == Side::Near;
                if let Some(t) = t {
                    bonds.push(bond);
                    events.push(Event { path: *path, t, onset, near });
                }
            }
        }
        if events.is_empty() {
            return;
        }
        let corrector = corrector.get_or_init(|| Corrector::new(flow.exponent(), self.h));
        let corrections = given(corrector, &events, sign);
        flow.correct(bonds.into_iter().zip(&corrections));
    }
}

/// Those of some bonds that are closed now, and their paths.
fn closed<S: BondFlow>(flow: &S, bonds: impl Iterator<Item = usize>) -> (Vec<usize>, Vec<BondPath>) {
    bonds.map(|bond| (bond, flow.path(bond))).filter(|(_, path)| path.overlap > 0.0).unzip()
}

/// For each path, its last zero before now and the first one after, if they are within reach.
pub fn nearest_zeros(paths: &[BondPath], reach: f64) -> Vec<[Option<f64>; 2]> {
    let mut zeros = Vec::with_capacity(paths.len());
    let out = &mut zeros;
    with_narrow!(V => for paths in paths.chunks(V::LANES) {
        let zeros = Paths::<V>::of(paths, |path| path).nearest_zeros(reach).map(Pack::lanes);
        let of = |t: f64| Some(t).filter(|t| !t.is_nan());
        out.extend((0..paths.len()).map(|k| [of(zeros[0][k]), of(zeros[1][k])]));
    });
    zeros
}

/// The corrections of bonds for their events.
fn given(corrector: &Corrector, events: &[Event], sign: f64) -> Vec<Correction> {
    let mut corrections = Vec::with_capacity(events.len());
    let out = &mut corrections;
    with_narrow!(V => for events in events.chunks(V::LANES) {
        let [impulse, displacement] = missed::<V>(corrector, events).map(Pack::lanes);
        out.extend(events.iter().enumerate().map(|(k, event)| Correction {
            impulse: -sign * impulse[k],
            displacement: sign * displacement[k],
            at: 0.0,
            rate: event.path.rate,
            turn: [0.0, 1.0],
        }));
    });
    corrections
}

/// Errors of sums of kicks that begin now, for the forces of some events, without the part that the
/// processor removes: of the impulse and of the first moment.
#[inline(always)]
fn missed<V: Vector<f64>>(corrector: &Corrector, events: &[Event]) -> [Pack<V>; 2] {
    let (alpha, h) = (corrector.exponent(), corrector.step());
    let (mut onset, mut near) = (0, 0);
    for (k, event) in events.iter().enumerate() {
        onset |= u64::from(event.onset) << k;
        near |= u64::from(event.near) << k;
    }
    let (zero, one) = (Pack::all(0.0), Pack::all(1.0));
    let t = Pack::<V>::of(events, |event| event.t);
    let jet = Paths::of(events, |event| &event.path).at(t);
    let (c, x) = (jet.rate.abs(), t.abs() / h);
    let turn = jet.acceleration * h / c;
    let [z0, z1] = end_terms(corrector, x);
    let below = slope(alpha, x) * (1.0 / 12.0);
    let scale = c * slope(alpha, c) * (h * corrector.power());
    // The processor's share of the impulse.
    let known = zero.or(near, below);
    let bent = turn * (z1 + known * x * (alpha + 1.0)) * (0.5 * alpha);
    let bent = bent.where_positive(one - turn.abs());
    let impulse = scale * (z0 + known * alpha + bent);
    [impulse.or(onset, -impulse), scale * (z1 - x * z0 + below * x) * h]
}

/// `Z_alpha` and `Z_{alpha+1}`, for `x` up to `REACH`.
#[inline(always)]
pub fn end_terms<V: Vector<f64>>(corrector: &Corrector, x: Pack<V>) -> [Pack<V>; 2] {
    let alpha = corrector.exponent();
    let theta = x.fraction();
    let [_, mut z0, mut z1, _] = corrector.beyond(theta);
    // zeta(-z, 1 + x) = zeta(-z, 1 + theta) - sum (theta + j)^z over j from 1 to x - theta.
    for j in 1..=REACH {
        let base = theta + f64::from(j);
        let power = (base * slope(alpha, base)).where_positive(x - theta - (f64::from(j) - 0.5));
        (z0, z1) = (z0 - power, z1 - power * base);
    }
    let power = x * slope(alpha, x);
    let above = power * x;
    (z0, z1) = (z0 + power * 0.5, z1 + above * 0.5);
    [z0 + above * (1.0 / (alpha + 1.0)), z1 + above * x * (1.0 / (alpha + 2.0))]
}
