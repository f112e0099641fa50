//! What contacts a bond has in a window: foreseen from the forces at its start, and looked for
//! again in what the sweeps found.

use super::{
    block::Piece,
    bond::{Beside, Bond, Contact, Contacts, Initial, ramps},
    detect::{Search, Start},
    panel::{Frame, along, sin_cos},
    panels::Panels,
    system::Path,
};

/// A release up to this many windows beyond the end is looked for. Chosen, not measured: beyond, a
/// release is too far to be felt.
const AHEAD: f64 = 1.5;
/// Share of a window over which speeds are differences. Chosen;
/// `methods contacts_are_those_that_a_search_of_every_step_finds` measures the speeds.
const SPEED_STEP: f64 = 1e-4;
/// What forces move over a window is rounded by less than this share. Chosen: a sum of some 64
/// terms.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// The overlap that the forces at the start of the window predict.
#[inline(always)]
fn predicted<const M: usize>(frame: &Frame<'_, M>, path: &Path, drive: [f64; 2], t: f64) -> f64 {
    let (sin, cos) = if frame.omega == 0.0 { (0.0, 1.0) } else { sin_cos(frame.omega * t) };
    let (k2, k3) = ramps(frame, t, cos, sin);
    along(path, t, cos, sin) + drive[0] * k2 + drive[1] * k3
}

/// The overlap at a time of the window, from all forces; the bond's own are in `panels`.
fn overlap_at<const M: usize>(
    path: &Path,
    (panels, recoil): (&Panels<M>, f64),
    frame: &Frame<'_, M>,
    beside: [Beside<M>; 2],
    t: f64,
) -> f64 {
    let mut own = [0.0];
    let (sin, cos) = if frame.omega == 0.0 { (0.0, 1.0) } else { (frame.omega * t).sin_cos() };
    panels.influence((&[t], &[cos], &[sin]), -recoil, &mut own);
    driven_at(path, frame, beside, t) + own[0]
}

/// The same without the bond's own forces.
fn driven_at<const M: usize>(path: &Path, frame: &Frame<'_, M>, beside: [Beside<M>; 2], t: f64) -> f64 {
    let (sin, cos) = if frame.omega == 0.0 { (0.0, 1.0) } else { (frame.omega * t).sin_cos() };
    let mut out = [along(path, t, cos, sin)];
    for bond in beside.into_iter().flatten() {
        bond.panels.influence((&[t], &[cos], &[sin]), 1.0, &mut out);
    }
    out[0]
}

impl<const M: usize> Bond<M> {
    /// What the forces at the start of the window, kept up to first order, do to this bond's
    /// overlap: its second and third rate.
    #[inline(always)]
    pub(super) fn drive(&self, [left, right]: [Beside<M>; 2]) -> [f64; 2] {
        let of = |bond: Beside<M>, k: usize| bond.map_or(0.0, |bond| bond.initial.force[k]);
        let drive = |k: usize| of(left, k) + of(right, k) - self.initial.recoil * self.initial.force[k];
        [drive(0), drive(1)]
    }

    /// Finds the contacts of the window from the forces at its start; `false` if there are too many
    /// to be sure.
    #[inline(always)]
    pub(crate) fn predict(&mut self, frame: &Frame<'_, M>, beside: [Beside<M>; 2], (sin, cos): (f64, f64)) -> bool {
        let (h, law) = (frame.h, frame.law);
        let Initial { path, band, overlap: [start, start_rate], force, ongoing, .. } = self.initial;
        let drive = self.drive(beside);
        let linear = frame.omega * frame.omega * (path[2].abs() + path[3].abs());
        let (k2, k3) = ramps(frame, h, cos, sin);
        let end = along(&path, h, cos, sin) + drive[0] * k2 + drive[1] * k3;
        let rate = self.predicted_rate(frame, drive, sin, cos, k2);
        self.forecast.at_end = end;
        let last = if end > 0.0 { law.force(end) } else { 0.0 };
        self.forecast.bend = (last - (force[0] + force[1] * h)) / (h * h);
        // Hermite's cubic, whose error G t^2 (h - t)^2/24 touches only the middle coefficient in
        // Bernstein's basis of degree 4.
        let square = frame.omega * frame.omega;
        let fourth = square * (linear + drive[0].abs() + drive[1].abs() * h);
        let error = fourth * (h * h) * (h * h) * (1.0 / 144.0);
        let (b1, b2) = (start + h * start_rate * (1.0 / 3.0), end - h * rate * (1.0 / 3.0));
        let sign = if ongoing.is_some() { 1.0 } else { -1.0 };
        let (c1, c2) = (sign * (0.25 * (start + 3.0 * b1)), sign * (0.5 * (b1 + b2)));
        let (c3, c4) = (sign * (0.25 * (3.0 * b2 + end)), sign * end);
        let still = |c: f64| c.abs() <= band;
        if still(start) && still(b1) && still(b2) && still(end) && error <= band {
            // Rounding only: it stays on its side.
            self.forecast.slack = 0.0;
            self.contacts.found.extend(ongoing.map(|contact| Contact { release: f64::INFINITY, ..contact }));
            return true;
        }
        let least = |a: f64, b: f64| if a < b { a } else { b };
        if c1 > band && c2 > error + band && c3 > band && c4 > band && sign * start > -band {
            self.forecast.slack = least(least(c1, c2 - error), least(c3, c4));
            let Some(contact) = ongoing else { return true };
            self.contacts.found.push(Contact { release: f64::INFINITY, ..contact });
            self.look_ahead(frame, drive, (end, rate));
            return true;
        }
        // One change of sign among the coefficients, whatever the error and a slack make of them.
        let more = |a: f64, b: f64| if a > b { a } else { b };
        let slack = least(least(-c4, more(c1, -c2 - error)), least(more(c1, -c3), more(c2 - error, -c3)));
        let once = sign * start > band && slack > band;
        if !once {
            return self.look(frame, drive, linear, (end, rate));
        }
        // A few steps of the Illinois method are better than the prediction deserves.
        let (mut a, mut b, mut slope) = ((0.0, start), (h, end), (end - start) / h);
        for _ in 0..4 {
            let t = b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1);
            let g = predicted(frame, &path, drive, t);
            if g == 0.0 || t <= 0.0 || t >= h {
                break;
            }
            slope = (g - b.1) / (t - b.0);
            a = if (g > 0.0) == (b.1 > 0.0) { (a.0, 0.5 * a.1) } else { b };
            b = (t, g);
        }
        let t = b.0 - b.1 / slope;
        // Within what is unsure about the overlap, its rate must not turn.
        let unsure = slope * slope / (linear + drive[0].abs() + drive[1].abs() * h) - error;
        self.forecast.slack = least(slack, unsure);
        if !(sign * slope < 0.0 && t > 0.0 && t < h && unsure > 0.0) {
            return self.look(frame, drive, linear, (end, rate));
        }
        match ongoing {
            Some(contact) => {
                self.contacts.found.push(Contact { release: t, slopes: [contact.slopes[0], slope], ..contact });
            }
            None => {
                self.contacts.found.push(Contact::new(t, f64::INFINITY, [slope, 0.0]));
                self.look_ahead(frame, drive, (end, rate));
            }
        }
        true
    }

    /// The rate of the predicted overlap at the end of the window.
    #[inline(always)]
    fn predicted_rate(&self, frame: &Frame<'_, M>, drive: [f64; 2], sin: f64, cos: f64, k2: f64) -> f64 {
        let (h, path) = (frame.h, &self.initial.path);
        let k1 = if frame.omega == 0.0 { h } else { frame.m * h + frame.mu * sin / frame.omega };
        path[1] + frame.omega * (path[3] * cos - path[2] * sin) + drive[0] * k1 + drive[1] * k2
    }

    /// Searches the prediction.
    #[inline(never)]
    fn look(&mut self, frame: &Frame<'_, M>, drive: [f64; 2], linear: f64, end: (f64, f64)) -> bool {
        let path = self.initial.path;
        let driven = |t: f64| drive[0].abs() + drive[1].abs() * t;
        let rounding = ROUNDING * driven(frame.h) * frame.h * frame.h;
        let g = |t| predicted(frame, &path, drive, t);
        let found = self.search(frame.h, frame.cuts.least_overlap.max(rounding), |t| linear + driven(t), g);
        if self.contacts.found.last().is_some_and(|contact| contact.release > frame.h) {
            self.look_ahead(frame, drive, end);
        }
        found
    }

    /// Estimates when a contact that outlasts the window will end.
    #[inline(always)]
    fn look_ahead(&mut self, frame: &Frame<'_, M>, drive: [f64; 2], (end, rate): (f64, f64)) {
        let (h, path) = (frame.h, self.initial.path);
        if rate >= 0.0 || end + AHEAD * h * rate > 0.0 {
            return;
        }
        let (mut b, mut slope) = ((h, end), rate);
        for _ in 0..2 {
            let t = b.0 - b.1 / slope;
            if !(t > h && t < (1.0 + AHEAD) * h) {
                return;
            }
            let c = (t, predicted(frame, &path, drive, t));
            slope = (c.1 - b.1) / (c.0 - b.0);
            b = c;
            if slope >= 0.0 {
                return;
            }
        }
        if let Some(contact) = self.contacts.found.last_mut() {
            let t = b.0 - b.1 / slope;
            if t > h {
                (contact.release, contact.slopes[1]) = (t, slope);
            }
        }
    }

    /// Finds the contacts of the window from what is known of all forces. Returns whether they
    /// differ from those assumed; `None` if there are too many to be sure.
    pub(crate) fn verify(&mut self, frame: &Frame<'_, M>, beside: [Beside<M>; 2]) -> Option<bool> {
        let Initial { path, recoil, .. } = self.initial;
        let linear = frame.omega * frame.omega * (path[2].abs() + path[3].abs());
        std::mem::swap(&mut self.contacts.found, &mut self.contacts.assumed);
        let panels = std::mem::replace(&mut self.panels, Panels::new());
        let g = |t: f64| overlap_at(&path, (&panels, recoil), frame, beside, t);
        // Between nodes a force may be a little larger than at any.
        let largest = |panels: &Panels<M>, t: f64| 1.2 * panels.largest_force(t);
        let of = |bond: Beside<M>, t: f64| bond.map_or(0.0, |bond| largest(&bond.panels, t));
        let driven = |t: f64| (of(beside[0], t) + of(beside[1], t)).max(recoil * largest(&panels, t));
        let rounding = ROUNDING * driven(frame.h) * frame.h * frame.h;
        let band = frame.cuts.least_overlap.max(rounding).max(self.initial.band);
        let on_surface = g(frame.h).abs() <= band;
        let sure = self.search(frame.h, band, |t| linear + driven(t), g);
        self.panels = panels;
        self.pending.search = false;
        // On the surface at the end of the window it may be said to have left or not.
        let alike = |(a, b): (&Contact, &Contact)| {
            let ([begins, ends], [begun, ended]) = (a.events(frame.h), b.events(frame.h));
            // Newton's method may have led astray.
            let sound = a.release >= a.onset.max(0.0) && a.onset <= frame.h;
            sound && begins == begun && (ends == ended || on_surface)
        };
        let Contacts { assumed, found, .. } = &mut self.contacts;
        let same = assumed.len() == found.len() && assumed.iter().zip(found.iter()).all(alike);
        if same {
            std::mem::swap(found, assumed);
        } else if let (Some(old), Some(new)) = (assumed.last(), found.last_mut())
            && new.release > frame.h
            && old.release < f64::INFINITY
        {
            // What was to end in the window ends soon after it.
            (new.release, new.slopes[1]) = (old.release.max(frame.h * (1.0 + f64::EPSILON)), old.slopes[1]);
        }
        sure.then_some(!same)
    }

    /// How far the force is from that predicted.
    #[inline(always)]
    pub(crate) fn surprised(&mut self, h: f64) {
        let force = self.initial.force;
        let predicted = |t: f64| force[0] + force[1] * t;
        // The prediction goes on after a release, when there is no force.
        let mut surprise = match self.contacts.found.last() {
            Some(contact) if contact.release > h => 0.0,
            Some(_) => predicted(h).abs(),
            None => predicted(0.0).abs().max(predicted(h).abs()),
        };
        for panel in self.panels.as_slice() {
            for j in 0..M {
                let off = (panel.force[j] - predicted(panel.tau[j])).abs();
                surprise = if off > surprise { off } else { surprise };
            }
        }
        self.forecast.surprise = surprise;
    }

    /// Finds contacts; `false` if there are too many to be sure.
    fn search(&mut self, h: f64, band: f64, curvature: impl Fn(f64) -> f64, g: impl FnMut(f64) -> f64) -> bool {
        let Initial { band: rounding, overlap: [value, slope], ongoing, .. } = self.initial;
        let start = Start { value, slope, rounding, positive: ongoing.is_some() };
        let Contacts { found, crossings, .. } = &mut self.contacts;
        let slack = Search::new(g, curvature, band.max(rounding), crossings).run(start, h);
        self.forecast.slack = slack.unwrap_or(0.0);
        found.clear();
        let mut open = ongoing.map(|contact| Contact { release: f64::INFINITY, ..contact });
        for crossing in crossings.iter() {
            if crossing.rising {
                open = Some(Contact::new(crossing.t, f64::INFINITY, [crossing.slope, 0.0]));
            } else if let Some(contact) = open.take() {
                let slopes = [contact.slopes[0], crossing.slope];
                found.push(Contact { release: crossing.t, slopes, ..contact });
            }
        }
        found.extend(open);
        slack.is_some()
    }

    /// What a contact did in this window, panel by panel, appended.
    pub(crate) fn pieces_of(
        &self,
        frame: &Frame<'_, M>,
        contact: &Contact,
        beside: [Beside<M>; 2],
        bond: usize,
        out: &mut Vec<Piece>,
    ) {
        let panels = &self.panels.list[contact.panels.0..contact.panels.1];
        let rule = &frame.rule;
        let [begins, ends] = contact.events(frame.h);
        // An event is known to the force that counts; for the record it is found to the last digit.
        // There is no force at it, so that the overlap goes on along the path on which the panels
        // before it leave the bond, whose values do not hang on any series.
        let event = |mut t: f64, before: usize| {
            let own = self.panels.before(before);
            let Initial { path, recoil, .. } = self.initial;
            let path = std::array::from_fn(|i| path[i] - recoil * own[i]);
            let g = |t: f64| driven_at(&path, frame, beside, t);
            // dg/dt of the parabola through three points nearby.
            let speed = |t: f64| {
                let near = SPEED_STEP * frame.h;
                let (a, c) = ((t - near).max(0.0), (t + near).min(frame.h));
                let b = 0.5 * (a + c);
                let [ga, gb, gc] = [a, b, c].map(g);
                let (first, second) = ((gb - ga) / (b - a), (gc - gb) / (c - b));
                0.5 * (first + second) + (second - first) * (t - b) / (b - a)
            };
            for _ in 0..2 {
                let slope = speed(t);
                if slope != 0.0 {
                    t = (t - g(t) / slope).clamp(0.0, frame.h);
                }
            }
            (t, speed(t))
        };
        let first = out.len();
        let piece = |impulse: f64, curve| Piece { bond, onset: None, release: None, impulse, curve };
        out.extend(panels.iter().map(|panel| piece(panel.impulse(rule), panel.curve(rule))));
        if panels.is_empty() {
            out.push(piece(0.0, None));
        }
        let last = out.len() - 1;
        out[first].onset = begins.then(|| event(contact.onset, contact.panels.0));
        out[last].release = ends.then(|| event(contact.release, contact.panels.1));
    }
}
