//! The contacts of a bond that dissipates: time intervals in which it pushes, `g > 0` and `P > 0`,
//! see `loss.rs`. Before and after them beads may overlap without a force.
//!
//! No bound of the second derivative of `P` is known where forces of neighbours begin like a root
//! of time. So `g` and `P` are evaluated at equally spaced times, and where the parabola through
//! three of them has its vertex on the other side of zero; after the sweeps also where a contact of
//! a neighbour begins or ends, since a force that jumps there turns `P`. A contact, or a pause of
//! one, that is missed is shorter than a fraction of this spacing. The sweeps and the last terms of
//! their series still see it if it has begun.

use super::{
    bond::{Beside, Bond, Contact, known},
    chain::Path,
    detect::sort_by_time,
    link::Link,
    motion::{AHEAD, ROUNDING, just_after, overlap_at, predicted, predicted_rate, rate_at},
    panel::Frame,
    panels::Panels,
};
use crate::events::root::bracketed;

/// Number of equal parts of a window at whose ends `g` and `P` are evaluated. Chosen.
const PARTS: usize = 12;
/// Distance of the points of difference quotients of `P`, as a share of the window. Chosen.
const STEP: f64 = 1e-4;

/// `[g, g']` at a time.
type Look = [f64; 2];

/// The smaller of `g` and `P`: positive where the bond pushes.
fn least([overlap, pushes]: [f64; 2]) -> f64 {
    overlap.min(pushes)
}

impl<const M: usize, const S: usize> Bond<M, S> {
    /// Force at the start of a window and its mean rate over the window, estimated without the
    /// forces of neighbours.
    pub(super) fn resisting(&self, frame: &Frame<'_, M, S>) -> [f64; 2] {
        let (link, [g, rate]) = (frame.link, self.initial.overlap);
        if self.initial.ongoing.is_none() {
            return [0.0; 2];
        }
        let force = link.law.force(g, rate);
        let swings = self.initial.path.iter().zip(&link.sides).map(|(path, side)| side.omega * side.omega * path[2]);
        let curvature = -swings.sum::<f64>() - self.initial.mobility * force;
        let end = link.law.force(g + frame.h * (rate + 0.5 * frame.h * curvature), rate + frame.h * curvature);
        [force, (end - force) / frame.h]
    }

    /// Finds the contacts of the window from the forces at its start.
    pub(super) fn predict_dissipative(&mut self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2]) {
        let (h, drive, path, given) = (frame.h, self.drive(beside), self.initial.path, self.known);
        let motion = (&path, known::<S>(&given));
        let overlap = |t: f64| predicted(frame, motion, &drive, t);
        let look = |t: f64| [overlap(t), predicted_rate(frame, motion, &drive, t)];
        let [end, rate] = look(h);
        self.prediction.at_end = frame.link.law.overlap_that_pushes(end, rate);
        let [force, by] = self.initial.force;
        self.prediction.curvature = (frame.link.law.force(end, rate) - (force + by * h)) / (h * h);
        // The overlap is below its chord plus the bound of its curvature times h^2/8.
        let most = self.initial.overlap[0].max(end) + 0.125 * self.bounds(frame, &drive).0 * h * h;
        if self.initial.ongoing.is_none() && most < -self.initial.band {
            self.contacts.found.clear();
            self.prediction.margin = -most;
            return;
        }
        self.gather(frame, self.initial.band, look, &[]);
        let Some(contact) = self.contacts.found.last_mut().filter(|contact| contact.release > h) else { return };
        // A release soon after the window's end.
        let pushes = |t: f64| {
            let [g, rate] = look(t);
            frame.link.law.overlap_that_pushes(g, rate)
        };
        let slope = (self.prediction.at_end - pushes(h * (1.0 - STEP))) / (STEP * h);
        let t = h - self.prediction.at_end / slope;
        if slope < 0.0 && t > 0.5 * h && t < (1.0 + AHEAD) * h {
            (contact.release, contact.slopes[1]) = (t.max(just_after(h)), slope);
            self.initial.singular_after = frame.link.singular_after(end, rate);
        }
    }

    /// Finds the contacts of the window from all forces. Returns whether the bond ceases or begins
    /// to push so near to the end of the window that the event may be counted in it or not.
    pub(super) fn search_again(
        &mut self,
        frame: &Frame<'_, M, S>,
        beside: [Beside<M, S>; 2],
        (panels, band): (&Panels<M, S>, f64),
    ) -> bool {
        let (path, given, own) = (self.initial.path, self.known, self.initial.own());
        let motion = (&path, known::<S>(&given));
        let h = frame.h;
        let look = |t: f64| {
            [overlap_at(motion, (panels, own), frame, beside, t), rate_at(motion, (panels, own), frame, beside, t)]
        };
        let contacts = beside.into_iter().flatten().flat_map(|bond| &bond.contacts.found);
        let events = contacts.flat_map(|contact| [contact.onset, contact.release]);
        let kinks: Vec<f64> = events.filter(|t| (0.0..h).contains(t)).collect();
        self.gather(frame, band, look, &kinks);
        let pushes = |t: f64| {
            let [g, rate] = look(t);
            frame.link.law.overlap_that_pushes(g, rate)
        };
        let ([overlap, rate], by) = (look(h), pushes(h) / slope(pushes, h, h));
        let impulse = frame.link.law.push(overlap, rate) * by;
        overlap.abs() <= band || frame.cuts.negligible_impulse(frame.link, impulse)
    }

    /// Energy dissipated while beads overlap without a force: the decrease of the elastic energy of
    /// the overlap.
    pub(super) fn let_go(&self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2]) -> f64 {
        let motion = (&self.initial.path, known::<S>(&self.known));
        // The next time after an event: there the forces before it are paths, whose values have no
        // errors of a series.
        let energy = |t: f64| {
            let overlap = overlap_at(motion, (&self.panels, self.initial.own()), frame, beside, t.next_up());
            frame.link.law.potential(overlap)
        };
        let found = &self.contacts.found;
        let ends = std::iter::once(0.0).chain(found.iter().map(|contact| contact.release));
        let starts = found.iter().map(|contact| contact.onset).chain([frame.h]);
        let free = ends.zip(starts).map(|(from, to)| (from.max(0.0), to.min(frame.h)));
        free.filter(|(from, to)| from < to).map(|(from, to)| energy(from) - energy(to)).sum()
    }

    /// Rates of the overlap up to this are rounding.
    fn rounding(&self, link: &Link<S>) -> f64 {
        let speed = |path: &Path, omega: f64| path[1].abs() + omega * (path[2].abs() + path[3].abs());
        let paths = self.initial.path.iter().zip(&link.sides);
        let speed = paths.map(|(path, side)| speed(path, side.omega)).sum::<f64>() + self.initial.overlap[1].abs();
        ROUNDING * speed
    }

    /// Finds the time intervals in which the bond pushes, from the function `look` that gives
    /// overlap and rate at a time; overlaps up to `band` count as zero. The rate has `kinks` where
    /// forces of neighbours jump.
    fn gather(&mut self, frame: &Frame<'_, M, S>, band: f64, look: impl Fn(f64) -> Look, kinks: &[f64]) {
        let (h, link) = (frame.h, frame.link);
        let of = |[g, rate]: Look| [g, link.law.overlap_that_pushes(g, rate)];
        let at = |t: f64| of(look(t));
        let mut looks = looks(h, link.law.kinked(), &look, &of, kinks);
        // At the start both are known, which tells the error of values by series.
        let start = self.initial.overlap;
        let by_series = std::mem::replace(&mut looks[0].1, start);
        let off = |k: usize, least: f64| least.max((by_series[k] - start[k]).abs());
        let off = [off(0, self.initial.band), off(1, self.rounding(link))];
        // A bound of the error of the overlap, over the window, that does not change whether the
        // bond pushes.
        let harmless = |[g, pushes]: [f64; 2]| g.abs().min(link.law.harmless(g, pushes.abs(), h));
        // `P` ascends with the overlap and with its rate. Overlaps up to `band` make next to no
        // force; where beads overlap, a `P` of this size makes more.
        let side = |[g, rate]: Look| {
            let by = |sign: f64| {
                let pushes = of([g + sign * off[0], rate + sign * off[1]])[1];
                least([g + sign * off[0].max(band), pushes])
            };
            if by(1.0) < 0.0 { Some(false) } else { (by(-1.0) > 0.0).then_some(true) }
        };
        // Beads that touch at the start, and push later, count as pushing from the start: their
        // overlap may rise so slowly that its first zero in floating point is anywhere.
        let touching = looks.iter().take_while(|(_, value)| side(*value).is_none()).count();
        let mut open = self.initial.ongoing.map(|contact| Contact { release: f64::INFINITY, ..contact });
        let found = &mut self.contacts.found;
        found.clear();
        let (mut last, mut margin) = ((looks[0].0, of(start)), f64::INFINITY);
        for (k, &(t, looked)) in looks.iter().enumerate() {
            let value = of(looked);
            margin = margin.min(harmless(value));
            if side(looked).is_none_or(|pushes| pushes == open.is_some()) {
                last = (t, value);
                continue;
            }
            // The bond has begun or ceased to push since the last evaluation.
            margin = 0.0;
            let (before, now) = (least(last.1), least(value));
            let event = match k {
                0 => 0.0,
                _ if k == touching && open.is_none() => 0.0,
                _ if (before > 0.0) == (now > 0.0) => last.0,
                _ => bracketed(|t| least(at(t)), (last.0, before), (t, now)),
            };
            // At the start without the error of a series, of which `P` of a dashpot takes the power
            // 1/alpha.
            let [g, rate] = if event == 0.0 { start } else { look(event) };
            // Whether `P` vanishes there, and not the overlap: it is less than without the rate, or
            // jumps to this value, where the rate of a dashpot comes to zero.
            let jumps = event > 0.0 && g > rate * h / PARTS as f64;
            let below = || of([g, rate])[1] < 0.5 * link.law.overlap_that_pushes(g, 0.0);
            let overlaps_at_onset = g > 0.0 && !link.law.pulls && (jumps || below());
            match open.take() {
                None => {
                    let slope = if overlaps_at_onset { slope(|t| at(t)[1], event, h) } else { rate };
                    open = Some(Contact { overlaps_at_onset, ..Contact::new(event, f64::INFINITY, [slope, 0.0]) });
                }
                Some(contact) => {
                    let slopes = [contact.slopes[0], slope(|t| at(t)[1], event, h)];
                    self.initial.singular_after = link.singular_after(g, rate);
                    found.push(Contact { release: event, slopes, ..contact });
                }
            }
            last = (t, value);
        }
        found.extend(open);
        self.prediction.margin = 0.5 * margin;
    }
}

/// The derivative of a function at a time of the window, as a difference quotient.
fn slope(of: impl Fn(f64) -> f64, t: f64, h: f64) -> f64 {
    let (a, b) = ((t - STEP * h).max(0.0), (t + STEP * h).min(h));
    (of(b) - of(a)) / (b - a)
}

/// Overlaps and rates at equally spaced times, and at the vertices of parabolas through three
/// values of `g` or of `P`, as `of` gives them, that lie on the other side of zero; and at `kinks`.
fn looks(
    h: f64,
    kinked: bool,
    look: &impl Fn(f64) -> Look,
    of: &impl Fn(Look) -> [f64; 2],
    kinks: &[f64],
) -> Vec<(f64, Look)> {
    let step = h / PARTS as f64;
    let mut looks: Vec<(f64, Look)> = (0..=PARTS)
        .map(|k| {
            let t = if k == PARTS { h } else { step * k as f64 };
            (t, look(t))
        })
        .collect();
    let turns = |k: usize, part: usize| {
        let [a, b, c] = [k - 1, k, k + 1].map(|k| of(looks[k].1)[part]);
        let (slope, curvature) = (0.5 * (c - a), a - 2.0 * b + c);
        let by = -slope / curvature;
        let beyond = (b > 0.0) != (b + 0.5 * slope * by > 0.0);
        (by.abs() < 1.0 && beyond).then(|| looks[k].0 + by * step)
    };
    // `P` of a dashpot falls abruptly where the overlap is largest: a time shortly before.
    let peak = |k: usize| {
        let [(a, [_, before]), (b, [_, after])] = [looks[k], looks[k + 1]];
        let largest = || bracketed(|t| look(t)[1], (a, before), (b, after));
        (kinked && before > 0.0 && after < 0.0).then(|| (largest() - STEP * step).max(a))
    };
    let turns = (1..PARTS).flat_map(|k| [turns(k, 0), turns(k, 1)]);
    let more: Vec<f64> = turns.chain((0..PARTS).map(peak)).flatten().chain(kinks.iter().copied()).collect();
    looks.extend(more.into_iter().map(|t| (t, look(t))));
    sort_by_time(&mut looks);
    looks
}
