//! What the log gets of a bond in a window: the parts in which beads overlap, with or without a
//! force.
//!
//! The sweeps know the ends of a contact as well as its force needs them. Where the force near an
//! end is negligible, the zero of the overlap may be far from it, even in another window. But the
//! overlap at the ends of a window is as exact as the state. Where its sign there is not that of
//! the contacts, the overlap is evaluated inside the window, too.

use super::{
    bond::{Beside, Bond, Initial, known},
    detect::sort_by_time,
    motion::{ROUNDING, overlap_at, rate_at},
    panel::{Frame, Panel},
    panels::Panels,
    window::Piece,
};
use crate::events::{Curve, root::bracketed};
use std::f64::consts::FRAC_PI_2;

/// Number of equal steps at whose ends an overlap in doubt is evaluated, in addition to the nodes
/// of its panels. Chosen.
const PARTS: usize = 12;
/// Number of Chebyshev's points at which the log gets an overlap by all forces, as many as a curve
/// takes.
const POINTS: usize = 14;
/// Ratio of the smallest to the largest overlap on a panel below which the log gets the overlap by
/// all forces: an end of the contact may be there. Chosen.
const FADING: f64 = 0.5;
/// The log leaves out parts of an overlap up to this share of the window, and takes a panel as a
/// whole if no more of it is missing. Chosen.
const SHORT: f64 = 1e-6;
/// Overlaps inside a window have a sign if they exceed this number of errors by series. Chosen.
const SURE: f64 = 4.0;
/// Overlaps above this number of roundings have the same sign in the window before. Chosen.
const ALIKE: f64 = 16.0;
/// The largest step that makes an event more exact, as a share of the window. Chosen.
const REFINED: f64 = 0.01;
/// Newton's method has found a zero if it has made the overlap smaller by this factor. Chosen.
const CLOSER: f64 = 1e-3;
/// Distance of the points from which speeds at events are difference quotients, as a share of the
/// window. Chosen; `methods contacts_are_those_that_a_search_of_every_step_finds` measures the
/// speeds.
const SPEED_STEP: f64 = 1e-4;

/// A time and the rate of the overlap there.
type Instant = (f64, f64);

/// The sign of a value that is larger than its error.
fn sign(value: f64, error: f64) -> Option<bool> {
    (value.abs() > error).then_some(value > 0.0)
}

/// A bond in a window, as the log looks at it. Overlaps up to `band` are rounding at the ends of
/// the window, and `curvature` is a bound of the second derivative.
struct Looked<'a, 'f, const M: usize, const S: usize> {
    of: &'a Bond<M, S>,
    frame: &'a Frame<'f, M, S>,
    beside: [Beside<'a, M, S>; 2],
    band: f64,
    curvature: f64,
    /// The overlap at the end of the window.
    end: f64,
}

/// Zeros of the overlap in a window, in order of time.
struct Zeros {
    events: Vec<Instant>,
    /// Whether beads overlap before the first.
    positive: bool,
    /// Whether the contacts may not say it all: overlaps without a force are looked for, too.
    doubt: bool,
    /// Overlaps inside the window up to this are errors.
    noise: f64,
}

/// First and second derivative of a function at a time of the window: those of the parabola through
/// three points nearby.
fn slopes(g: impl Fn(f64) -> f64, t: f64, h: f64) -> [f64; 2] {
    let near = SPEED_STEP * h;
    let (a, c) = ((t - near).max(0.0), (t + near).min(h));
    let b = 0.5 * (a + c);
    let [ga, gb, gc] = [a, b, c].map(g);
    let (first, second) = ((gb - ga) / (b - a), (gc - gb) / (c - b));
    [0.5 * (first + second) + (second - first) * (t - b) / (b - a), (second - first) / (b - a)]
}

impl<const M: usize, const S: usize> Bond<M, S> {
    /// Appends the pieces of this window in which beads overlap, with the index of the bond.
    pub(super) fn pieces(
        &self,
        (frame, bond): (&Frame<'_, M, S>, usize),
        beside: [Beside<M, S>; 2],
        out: &mut Vec<Piece>,
    ) {
        let (h, [value, slope]) = (frame.h, self.initial.overlap);
        let driven = Self::driven_up_to(frame, beside, (&self.panels, self.initial.mobility), h);
        let band = self.initial.band.max(ROUNDING * driven * h * h);
        let curvature = self.linear(frame) + driven;
        let most = value + slope.max(0.0) * h + 0.5 * curvature * h * h;
        let stays_open = most <= 0.0 && value < -ALIKE * band || [value, slope, most] == [0.0; 3];
        if !stays_open || !self.contacts.found.is_empty() {
            let mut looked = Looked { of: self, frame, beside, band, curvature, end: 0.0 };
            looked.end = looked.overlap(h.next_up());
            looked.pieces(bond, out);
        }
    }
}

impl<const M: usize, const S: usize> Looked<'_, '_, M, S> {
    /// The overlap at a time, by all forces.
    fn overlap(&self, t: f64) -> f64 {
        let Bond { initial, known: motion, panels, .. } = self.of;
        overlap_at((&initial.path, known::<S>(motion)), (panels, initial.own()), self.frame, self.beside, t)
    }

    /// The overlap at a time; at the ends of the window as exact as the state.
    fn at(&self, t: f64) -> f64 {
        let [start, _] = self.of.initial.overlap;
        if t <= 0.0 {
            return start;
        }
        if t < self.frame.h { self.overlap(t) } else { self.end }
    }

    /// The error of overlaps inside the window: the series of a panel has errors, which show at its
    /// ends.
    fn noise(&self) -> f64 {
        let bonds = [Some(self.of), self.beside[0], self.beside[1]].into_iter().flatten();
        let ends = bonds.flat_map(|bond| bond.panels.as_slice()).flat_map(|panel| [panel.start, panel.end]);
        let jump = |t: f64| (self.overlap(t.next_up()) - self.overlap(t.next_down())).abs();
        self.band.max(SURE * ends.map(jump).fold(0.0, f64::max))
    }

    /// The zero near an event, and whether there is one; a step to it is shorter than `most`. The
    /// force is zero at an event, so that near it the overlap follows the path by the panels
    /// before, whose values have no errors of a series.
    fn event(&self, (found, rising): (f64, bool), most: f64) -> (Instant, bool) {
        let (h, panels, own) = (self.frame.h, self.of.panels.as_slice(), self.of.initial.own());
        let before = panels.partition_point(|panel| if rising { panel.end <= found } else { panel.start < found });
        let (left, none, mut path) = (self.of.panels.before(before), Panels::new(), self.of.initial.path);
        for side in 0..S {
            for i in 0..4 {
                path[side][i] -= own * left[side][i];
            }
        }
        let motion = (&path, known::<S>(&self.of.known));
        let g = |t: f64| overlap_at(motion, (&none, own), self.frame, self.beside, t);
        let speed = |t: f64| {
            let rate = || rate_at(motion, (&none, own), self.frame, self.beside, t);
            if self.frame.link.lossy() { rate() } else { slopes(g, t, h)[0] }
        };
        let mut t = found;
        for _ in 0..2 {
            let by = -g(t) / speed(t);
            t = if by.abs() < most { (t + by).clamp(0.0, h) } else { t };
        }
        ((t, speed(t)), g(t).abs() <= (ALIKE * self.band).max(CLOSER * g(found).abs()))
    }

    /// The zeros that the contacts have; where the sign of the overlap contradicts them, those that
    /// a search finds.
    fn zeros(&self) -> Zeros {
        let (h, band, panels, found) = (self.frame.h, self.band, self.of.panels.as_slice(), &self.of.contacts.found);
        let Initial { overlap: [value, _], ongoing, .. } = self.of.initial;
        let starts = sign(value, ALIKE * band);
        let edges = found.iter().flat_map(|contact| {
            let [begins, ends] = contact.events(h);
            [begins.then_some((contact.onset, true)), ends.then_some((contact.release, false))]
        });
        let (mut events, mut all) = (Vec::new(), true);
        for (zero, found) in edges.flatten().map(|edge| self.event(edge, f64::INFINITY)) {
            events.push(zero);
            all &= found;
        }
        let mut positive = starts.unwrap_or(ongoing.is_some());
        let ends = found.last().is_some_and(|contact| contact.release > h);
        let least = panels.iter().flat_map(|panel| panel.overlap).fold(0.0, f64::min);
        let doubt = positive != ongoing.is_some()
            || sign(self.end, band).is_some_and(|positive| positive != ends)
            || found.is_empty()
            || self.frame.link.lossy() && !events.is_empty()
            || !all
            || least < -band && least < -self.noise();
        let throughout = found.is_empty() && starts == Some(true) && self.end > band;
        if !doubt || throughout {
            return Zeros { events, positive, doubt, noise: band };
        }
        let noise = self.noise();
        let (mut side, mut last) = (starts, (0.0, value));
        events.clear();
        for (t, g) in self.samples() {
            let now = sign(g, if t == h { band } else { noise });
            match (side, now) {
                (None, Some(now)) => (positive, side) = (now, Some(now)),
                (Some(before), Some(now)) if before != now => {
                    // Far from a zero that was found there is another one, or none.
                    let zero = bracketed(|t| self.overlap(t), last, (t, g));
                    events.push(self.event((zero, now), REFINED * h).0);
                    side = Some(now);
                }
                _ => {}
            }
            if side == Some(g > 0.0) {
                last = (t, g);
            }
        }
        Zeros { events, positive, doubt, noise }
    }

    /// Times in the window and overlaps there, in order of time.
    fn samples(&self) -> Vec<(f64, f64)> {
        let h = self.frame.h;
        let nodes = self.of.panels.as_slice().iter().flat_map(|panel| panel.tau.into_iter().zip(panel.overlap));
        let inner = (1..PARTS).map(|k| h * k as f64 / PARTS as f64).map(|t| (t, self.overlap(t)));
        let mut samples: Vec<(f64, f64)> = nodes.chain(inner).chain([(h, self.end)]).collect();
        sort_by_time(&mut samples);
        samples
    }

    /// The overlap by all forces as a curve. Not inlined: it is called in four places.
    #[inline(never)]
    fn through(&self, (origin, sign, q): (f64, f64, u32), [from, to]: [f64; 2], span: (f64, f64)) -> Curve {
        let time = |x: f64| origin + sign * (from + (to - from) * x).powi(q as i32);
        let count = if self.curvature > 0.0 { POINTS } else { 2 };
        let share = |k: usize| (FRAC_PI_2 * k as f64 / (count - 1) as f64).sin().powi(2);
        Curve::new((origin, sign, q), [from, to], span, (0..count).map(share).map(|x| (x, self.at(time(x)))))
    }

    /// The overlap on a panel. The polynomial through the values at the nodes is worst at the ends
    /// of a panel. Where it decides on a time, and is worse there than displacements, the overlap
    /// by all forces takes its place.
    fn over(&self, panel: &Panel<M, S>) -> Option<Curve> {
        let curve = panel.curve(self.frame.rule, &panel.overlap)?;
        let (values, (low, high)) = (curve.values(), curve.range());
        let decides = low < FADING * high || values[0] < high && curve.last() < high;
        let off = |[inside, outside]: [f64; 2], value: f64| {
            let [inside, outside] = [self.overlap(inside), self.overlap(outside)];
            (value - outside).abs() > self.band.max(SURE * (inside - outside).abs())
        };
        let Panel { start, end, .. } = *panel;
        let exact = !decides
            || !off([start.next_up(), start.next_down()], values[0])
                && !off([end.next_down(), end.next_up()], curve.last());
        Some(if exact { curve } else { self.through(panel.map(), panel.sigmas(), (start, end)) })
    }

    /// Time and value of the largest overlap of a curve, by all forces, and the share of the overlap's
    /// terms that its error is.
    fn largest(&self, curve: &Curve) -> (Instant, f64) {
        let (h, (t, _), [from, to]) = (self.frame.h, curve.largest(), [curve.start(), curve.end()[0]]);
        let step = || {
            let [slope, bend] = slopes(|t| self.at(t), t, h);
            Some(-slope / bend).filter(|by| by.abs() < REFINED * h)
        };
        if !(from < t && t < to) {
            return ((t.clamp(0.0, h), self.at(t)), 0.0);
        }
        let t = (t + step().unwrap_or(0.0)).clamp(from, to);
        ((t.clamp(0.0, h), self.at(t)), ROUNDING * self.noise() / self.band)
    }

    /// Time and value of the largest force on a panel: the time by the polynomial through the
    /// forces at its nodes, the value from the overlap and its rate there, by all forces.
    fn peak(&self, panel: &Panel<M, S>) -> Instant {
        let Bond { initial, known: motion, panels, .. } = self.of;
        let force = || panel.curve(self.frame.rule, &panel.force);
        let Some(curve) = self.frame.link.lossy().then(force).flatten() else { return (0.0, 0.0) };
        let ((t, _), motion) = (curve.largest(), (&initial.path, known::<S>(motion)));
        let rate = rate_at(motion, (panels, initial.own()), self.frame, self.beside, t);
        (t.clamp(0.0, self.frame.h), self.frame.link.law.force(self.at(t).max(f64::MIN_POSITIVE), rate))
    }

    /// Appends the pieces, with the index of the bond. Not inlined, to keep it away from bonds that
    /// stay open.
    #[inline(never)]
    fn pieces(&self, bond: usize, out: &mut Vec<Piece>) {
        let (h, rule, panels) = (self.frame.h, self.frame.rule, self.of.panels.as_slice());
        let Zeros { events, positive, doubt, noise } = self.zeros();
        let piece = |impulse: f64, curve: Option<Curve>| {
            let (largest, error) = curve.map_or(((0.0, 0.0), 0.0), |curve| self.largest(&curve));
            Piece { bond, onset: None, release: None, impulse, largest, error, peak: (0.0, 0.0), curve }
        };
        let freely = |a: f64, b: f64| {
            let long = doubt && b - a > SHORT * h;
            long.then(|| self.through((a, 1.0, 1), [0.0, b - a], (a, b))).filter(|curve| curve.range().1 > noise)
        };
        // The side on which the last window ended is not known here: near zero it is told again.
        let [value, slope] = self.of.initial.overlap;
        let again = sign(value, ALIKE * self.band).is_none().then_some((0.0, slope));
        if !positive && again.is_some() {
            out.push(Piece { release: again, ..piece(0.0, None) });
        }
        let (mut from, mut given) = (positive.then_some((0.0, again)), 0);
        for zero in events.into_iter().map(Some).chain([None]) {
            let Some((from, onset)) = from.take() else {
                from = zero.map(|zero| (zero.0, Some(zero)));
                continue;
            };
            let (to, first, mut at) = (zero.map_or(h, |zero| zero.0), out.len(), from);
            for (k, panel) in panels.iter().enumerate().filter(|(_, panel)| panel.start < to && panel.end > from) {
                out.extend(freely(at, panel.start).map(|curve| piece(0.0, Some(curve))));
                let (a, b) = (panel.start.max(at), panel.end.min(to));
                let whole = !doubt || (panel.end - panel.start) - (b - a) <= SHORT * h;
                // A panel gives its impulse, once, to the contact in which its force is largest;
                // if that is between two contacts, to the second.
                let most = (1..M).fold(0, |most, j| if panel.force[j] > panel.force[most] { j } else { most });
                let here = k >= given && (!doubt || panel.tau[most] <= to);
                let (impulse, peak) = if here { (panel.impulse(rule), self.peak(panel)) } else { (0.0, (0.0, 0.0)) };
                given = if here { k + 1 } else { given };
                out.push(Piece { peak, ..piece(impulse, if whole { self.over(panel) } else { freely(a, b) }) });
                at = at.max(b);
            }
            out.extend(freely(at, to).map(|curve| piece(0.0, Some(curve))));
            if out.len() == first {
                out.push(piece(0.0, None));
            }
            let last = out.len() - 1;
            (out[first].onset, out[last].release) = (onset, zero);
        }
    }
}
