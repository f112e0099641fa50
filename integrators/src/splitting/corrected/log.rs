//! The log of contacts: times of events, impulses and overlaps.

use super::{
    bonds::{BondFlow, Correction},
    graze::Graze,
};
use crate::{collocation::Piece, events::Curve};

/// The log's data of one bond.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    /// Overlap, rate and modified force at the last kick; the force is zero where the bond is open.
    overlap: f64,
    rate: f64,
    force: f64,
    /// Acceleration by the forces of that kick.
    acceleration: f64,
    /// Impulse of the present contact: the sum of kicks, with half of the last one, and of
    /// corrections.
    sum: f64,
    /// The part of `sum` that pieces have reported.
    told: f64,
    /// Events of this step: time relative to its end, and rate of the overlap there.
    onset: Option<(f64, f64)>,
    release: Option<(f64, f64)>,
    /// Largest overlap of a contact between two kicks.
    hidden: f64,
}

/// A log of contacts, step by step.
///
/// The impulse of a contact is the sum of its kicks and corrections: the quadrature that moves the
/// chain. While a contact goes on, half of the last kick counts, minus `(h^2/12) f'`, the term of
/// Euler and Maclaurin. Between kicks the overlap is the cubic through overlaps and rates at both:
/// times of largest overlaps have an error of order three.
#[derive(Clone, Debug)]
pub(super) struct Log {
    entries: Vec<Entry>,
    pieces: Vec<Piece>,
    h: f64,
    alpha: f64,
}

impl Log {
    /// The log of a flow after its first half kick.
    pub(super) fn new<S: BondFlow>(flow: &S, h: f64) -> Self {
        let mut log = Self {
            entries: vec![Entry::default(); flow.bonds()],
            pieces: Vec::with_capacity(flow.bonds()),
            h,
            alpha: flow.exponent(),
        };
        for bond in 0..log.entries.len() {
            log.look(flow, bond, 0.0);
            let entry = &mut log.entries[bond];
            entry.sum = log.alpha * entry.force / entry.overlap.max(f64::MIN_POSITIVE) * entry.rate * h * h / 12.0;
            entry.told = 0.0;
        }
        log
    }

    pub(super) fn pieces(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter()
    }

    /// Stores overlap, rate and force of a bond, processed, at the middle of the last kick: half of
    /// the duration `kick` is taken back.
    fn look<S: BondFlow>(&mut self, flow: &S, bond: usize, kick: f64) {
        let path = flow.path(bond);
        let (force, acceleration) = flow.force(bond);
        let moved = self.h * self.h / 12.0 * acceleration;
        let entry = &mut self.entries[bond];
        entry.force = force + if force > 0.0 { self.alpha * force / path.overlap * moved } else { 0.0 };
        (entry.overlap, entry.rate) = (path.overlap + moved, path.rate - 0.5 * kick * acceleration);
        entry.acceleration = acceleration;
    }

    pub(super) fn event(&mut self, bond: usize, onset: bool, correction: Option<Correction>) {
        let entry = &mut self.entries[bond];
        let (at, rate, impulse) = correction.map_or((0.0, 0.0, 0.0), |c| (c.at, c.rate, c.impulse));
        entry.sum += impulse;
        *(if onset { &mut entry.onset } else { &mut entry.release }) = Some((at, rate));
    }

    /// Adds the correction at a turning point to a contact that goes on, or a contact that no kick
    /// has seen.
    pub(super) fn graze(&mut self, bond: usize, graze: &Graze) {
        let entry = &mut self.entries[bond];
        if let Some([half, overlap, impulse]) = graze.hidden {
            let (at, speed) = (graze.correction.at, 2.0 * overlap / half);
            (entry.onset, entry.release) = (Some((at - half, speed)), Some((at + half, -speed)));
            entry.hidden = overlap;
            entry.sum += impulse;
        } else if entry.force != 0.0 {
            entry.sum += graze.correction.impulse;
        }
    }

    /// Makes the pieces of a step, after the kick at its end, `time`. Not inlined, to keep it out
    /// of the code of runs without a log.
    #[inline(never)]
    pub(super) fn step<S: BondFlow>(&mut self, flow: &S, time: f64) {
        self.pieces.clear();
        for bond in 0..self.entries.len() {
            let before = self.entries[bond];
            self.look(flow, bond, self.h);
            let entry = &mut self.entries[bond];
            if before.force == 0.0 && entry.force == 0.0 && entry.release.is_none() {
                continue;
            }
            entry.sum += 0.5 * self.h * (before.force + entry.force);
            let closed = entry.force != 0.0;
            let end = if closed {
                self.alpha * entry.force / entry.overlap.max(f64::MIN_POSITIVE) * entry.rate * self.h * self.h / 12.0
            } else {
                0.0
            };
            let unit = flow.unit(bond);
            let at = |event: Option<(f64, f64)>| event.map(|(at, rate)| (time + at, rate / unit));
            let (onset, release) = (at(entry.onset.take()), at(entry.release.take()));
            let curve = match (std::mem::take(&mut entry.hidden), onset, release) {
                (hidden, Some((from, _)), Some((to, _))) if hidden > 0.0 => {
                    Curve::over((from, to), [(0.0, 0.0), (0.5, hidden / unit), (1.0, 0.0)])
                }
                _ => {
                    // Processing moves rates by -(h^2/12) times the rate of the acceleration.
                    let moved = self.h / 12.0 * (entry.acceleration - before.acceleration);
                    let [start, end] =
                        [before, *entry].map(|entry| (entry.overlap / unit, (entry.rate - moved) / unit));
                    cubic(start, end, (time - self.h, time))
                }
            };
            let (impulse, largest, peak) = (entry.sum - end - entry.told, curve.largest(), (0.0, 0.0));
            self.pieces.push(Piece { bond, onset, release, impulse, largest, error: 0.0, peak, curve: Some(curve) });
            entry.told = entry.sum - end;
            if !closed {
                (entry.sum, entry.told) = (0.0, 0.0);
            }
        }
    }
}

/// The cubic with these values and slopes at the ends of a span.
fn cubic((g0, r0): (f64, f64), (g1, r1): (f64, f64), (from, to): (f64, f64)) -> Curve {
    let (h, rise) = (to - from, g1 - g0);
    let (b, c) = (3.0 * rise - h * (2.0 * r0 + r1), h * (r0 + r1) - 2.0 * rise);
    let at = |x: f64| (x, g0 + x * (h * r0 + x * (b + x * c)));
    Curve::over((from, to), [(0.0, g0), at(1.0 / 3.0), at(2.0 / 3.0), (1.0, g1)])
}
