//! A bond in a window: its contacts, their panels, and one sweep over them.

use super::{
    block::Piece,
    detect::{Crossing, Search, Start},
    panel::{Frame, Origin, Panel, View, along, dot, sin_cos},
    system::{PairLaw, Path},
};

/// A stretch of time in which the bond is closed. It may have begun before the window and may end after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    /// Onset, in the time of the window; minus infinity if it was there when the run began.
    pub(crate) onset: f64,
    /// Release; infinity where none is in sight.
    pub(crate) release: f64,
    /// `dg/dt` at onset and release.
    pub(crate) slopes: [f64; 2],
    /// Its panels in this window.
    pub(crate) panels: (usize, usize),
}

impl Contact {
    fn new(onset: f64, release: f64, slopes: [f64; 2]) -> Self {
        Self { onset, release, slopes, panels: (0, 0) }
    }

    /// The contact of a bond that is closed when the run begins.
    pub(crate) fn from_the_start() -> Self {
        Self::new(f64::NEG_INFINITY, f64::INFINITY, [0.0; 2])
    }

    /// Whether it begins and whether it ends inside the window.
    fn events(&self, h: f64) -> [bool; 2] {
        [self.onset >= 0.0, self.release <= h]
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Panels<const M: usize> {
    pub(crate) list: Vec<Panel<M>>,
    pub(crate) len: usize,
    /// Changes whenever panels are laid out.
    pub(crate) version: u64,
    /// The path that the whole window leaves behind.
    pub(crate) total: Path,
}

impl<const M: usize> Panels<M> {
    pub(crate) fn new() -> Self {
        Self { list: Vec::new(), len: 0, version: 0, total: [0.0; 4] }
    }

    #[inline(always)]
    fn clear(&mut self) {
        (self.len, self.total) = (0, [0.0; 4]);
    }

    #[inline(always)]
    fn push(&mut self, frame: &Frame<'_, M>, start: f64, end: f64, origin: Origin) {
        if self.len == self.list.len() {
            self.list.push(Panel::new());
        }
        for view in &mut self.list[self.len].views {
            view.version = 0;
        }
        self.list[self.len].place(frame, start, end, origin);
        self.len += 1;
    }

    /// The largest force at a node of a panel that starts before `t`.
    fn largest_force(&self, t: f64) -> f64 {
        let panels = self.as_slice().iter().take_while(|panel| panel.start < t);
        panels.flat_map(|panel| panel.force).fold(0.0, f64::max)
    }

    pub(crate) fn as_slice(&self) -> &[Panel<M>] {
        &self.list[..self.len]
    }

    /// The path left behind when panel `k` starts.
    #[inline(always)]
    pub(crate) fn before(&self, k: usize) -> &Path {
        if k < self.len { &self.list[k].before } else { &self.total }
    }

    /// Where ascending times are among these panels.
    #[inline(always)]
    fn look(&self, tau: &[f64; M], view: &mut View<M>) {
        view.version = self.version;
        view.place = [-1.0; M];
        for (k, panel) in self.as_slice().iter().enumerate() {
            if tau[M - 1] < panel.start {
                return;
            }
            let place = 2.0 * k as f64;
            for j in 0..M {
                view.place[j] = if tau[j] > panel.end { place + 1.0 } else { view.place[j] };
            }
            if tau[0] <= panel.end {
                let x = panel.variable(tau);
                for j in 0..M {
                    let inside = tau[j] >= panel.start && tau[j] <= panel.end;
                    view.place[j] = if inside { place } else { view.place[j] };
                    view.x[j] = if inside { x[j] } else { view.x[j] };
                }
            }
        }
    }

    /// Adds `int_0^t K(t - s) f(s) ds` at the nodes of a panel of a neighbour. Returns in how many pieces.
    #[inline(always)]
    fn act(&self, panel: &mut Panel<M>, side: usize, out: &mut [f64; M]) -> u64 {
        let Panel { tau, cos, sin, views, .. } = panel;
        let view = &mut views[side];
        if view.version != self.version {
            self.look(tau, view);
        }
        let (first, last) = view.span();
        let mut pieces = 0;
        for place in first.max(0)..=last {
            let k = (place / 2) as usize;
            let (path, moved) = if place % 2 == 0 {
                (&self.list[k].before, self.list[k].moved_at(&view.x))
            } else if view.place.contains(&f64::from(place)) {
                (self.before(k + 1), [0.0; M])
            } else {
                continue;
            };
            for j in 0..M {
                let value = along(path, tau[j], cos[j], sin[j]) + moved[j];
                out[j] += if view.place[j] == f64::from(place) { value } else { 0.0 };
            }
            pieces += 1;
        }
        pieces
    }

    /// Adds `weight int_0^t K(t - s) f(s) ds` at ascending times.
    #[inline(always)]
    pub(crate) fn influence<const L: usize>(
        &self,
        (tau, cos, sin): (&[f64; L], &[f64; L], &[f64; L]),
        weight: f64,
        out: &mut [f64; L],
    ) {
        let (first, last) = (tau[0], tau[L - 1]);
        for k in 0..self.len {
            let panel = &self.list[k];
            if last < panel.start {
                return;
            }
            let next = if k + 1 < self.len { self.list[k + 1].start } else { f64::INFINITY };
            if first >= next {
                continue;
            }
            let after = self.before(k + 1);
            let mut value = [0.0; L];
            for j in 0..L {
                value[j] = along(after, tau[j], cos[j], sin[j]);
            }
            if first <= panel.end {
                let moved = panel.moved(tau);
                for j in 0..L {
                    let inside = along(&panel.before, tau[j], cos[j], sin[j]) + moved[j];
                    value[j] = if tau[j] <= panel.end { inside } else { value[j] };
                }
            }
            for j in 0..L {
                let here = tau[j] >= panel.start && tau[j] < next;
                out[j] += if here { weight * value[j] } else { 0.0 };
            }
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Bond<const M: usize> {
    /// How strongly its own force opens it: 2 between two sites, 1 at a wall.
    pub(crate) recoil: f64,
    /// The overlap along the linear path.
    pub(crate) path: Path,
    /// Overlap and its rate, force and its rate at the start of the window.
    pub(crate) overlap: [f64; 2],
    pub(crate) force: [f64; 2],
    /// What the second power of time must add for the force predicted at the end of the window.
    pub(crate) bend: f64,
    /// Overlaps up to this are rounding.
    pub(crate) band: f64,
    pub(crate) contacts: Vec<Contact>,
    /// The contacts that a search replaced.
    assumed: Vec<Contact>,
    pub(crate) panels: Panels<M>,
    /// The contact that it is in when the window begins.
    pub(crate) ongoing: Option<Contact>,
    /// The largest `f'(g) h^2`, and the largest overlap at a node.
    pub(crate) stiffness: f64,
    largest: f64,
    /// Sweeps since panels were laid out, here or where the change came from.
    pub(crate) age: u32,
    /// Overlap at the end of the window, as last used to look ahead.
    at_end: f64,
    /// See [`Search::slack`].
    pub(crate) slack: f64,
    /// How far the force is from the prediction.
    pub(crate) surprise: f64,
    pub(crate) stale: bool,
    pub(crate) dirty: bool,
    pub(crate) suspicious: bool,
    /// Every panel is halved so many times in its variable.
    pub(crate) halvings: u32,
    crossings: Vec<Crossing>,
}

/// A neighbour that may not be there.
pub(crate) type Beside<'a, const M: usize> = Option<&'a Bond<M>>;

/// What a sweep did to a bond.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Change {
    /// Largest change of an impulse.
    pub(crate) impulse: f64,
    /// How far an event moved; panels of this bond must be laid out anew if it did.
    pub(crate) moved: f64,
    /// What it cost.
    pub(crate) work: u64,
}

/// What a window costs, measured, in units of about 10 ns: for each bond, each panel laid out, each panel swept, and each panel of a
/// neighbour that acts on it.
pub(crate) const BOND: u64 = 12;
pub(crate) const LAYOUT: u64 = 11;
const SWEEP: u64 = 8;
const VIEW: u64 = 3;

/// `int_0^t K(t - s) s^k/k! ds` for `k = 0, 1`.
#[inline(always)]
fn ramps<const M: usize>(frame: &Frame<'_, M>, t: f64, cos: f64, sin: f64) -> (f64, f64) {
    let (free2, free3) = (0.5 * t * t, t * t * t * (1.0 / 6.0));
    if frame.omega * frame.h < 1e-3 {
        return (free2, free3);
    }
    let per_omega = frame.per_omega;
    let scale = frame.mu_per_omega * per_omega;
    (frame.m * free2 + scale * (1.0 - cos), frame.m * free3 + scale * (t - sin * per_omega))
}

/// `int_0^t K(t - s) s^2 ds`.
#[inline(always)]
fn ramp2<const M: usize>(frame: &Frame<'_, M>, t: f64, cos: f64) -> f64 {
    let free = (t * t) * (t * t) * (1.0 / 12.0);
    if frame.omega * frame.h < 1e-2 {
        return free;
    }
    let square = frame.per_omega * frame.per_omega;
    frame.m * free + frame.mu * square * (t * t - 2.0 * square * (1.0 - cos))
}

/// A release up to this many windows beyond the end is looked for.
const AHEAD: f64 = 1.5;
/// Contacts of a bond in one window that are foreseen; more cost an allocation.
const CONTACTS: usize = 4;
/// Share of a window over which speeds are differences.
const SPEED_STEP: f64 = 1e-4;
/// What forces move over a window is rounded by less than this share.
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
    let (sin, cos) = if frame.omega == 0.0 { (0.0, 1.0) } else { (frame.omega * t).sin_cos() };
    let at = (&[t], &[cos], &[sin]);
    let mut out = [along(path, t, cos, sin)];
    panels.influence(at, -recoil, &mut out);
    for bond in beside.into_iter().flatten() {
        bond.panels.influence(at, 1.0, &mut out);
    }
    out[0]
}

impl<const M: usize> Bond<M> {
    pub(crate) fn new() -> Self {
        Self {
            recoil: 0.0,
            path: [0.0; 4],
            overlap: [0.0; 2],
            force: [0.0; 2],
            bend: 0.0,
            band: 0.0,
            contacts: Vec::with_capacity(CONTACTS),
            assumed: Vec::with_capacity(CONTACTS),
            panels: Panels::new(),
            ongoing: None,
            at_end: 0.0,
            stiffness: 0.0,
            largest: 0.0,
            age: 0,
            slack: 0.0,
            surprise: 0.0,
            stale: false,
            dirty: false,
            suspicious: false,
            halvings: 0,
            crossings: Vec::with_capacity(2 * CONTACTS),
        }
    }

    /// Takes the linear path of a new window.
    #[inline(always)]
    pub(crate) fn begin(&mut self, frame: &Frame<'_, M>, law: &impl PairLaw, path: Path, band: f64) {
        self.path = path;
        self.band = band;
        self.overlap = [path[0] + path[2], path[1] + frame.omega * path[3]];
        self.force = [0.0; 2];
        if self.overlap[0] > 0.0 {
            let rate = law.stiffness(self.overlap[0]) * self.overlap[1];
            // Right after an onset under alpha < 1 the force has no rate to speak of.
            self.force = [law.force(self.overlap[0]), if law.exponent() < 1.0 { 0.0 } else { rate }];
        }
        self.contacts.clear();
        self.panels.clear();
        (self.surprise, self.suspicious, self.stale, self.dirty, self.halvings) = (0.0, false, false, false, 0);
        (self.stiffness, self.largest) = (0.0, 0.0);
    }

    /// What the forces at the start of the window, kept up to first order, do to this bond's overlap: its second and third rate.
    #[inline(always)]
    fn drive(&self, left: Beside<M>, right: Beside<M>) -> [f64; 2] {
        let of = |bond: Beside<M>, k: usize| bond.map_or(0.0, |bond| bond.force[k]);
        [0, 1].map(|k| of(left, k) + of(right, k) - self.recoil * self.force[k])
    }

    /// Finds the contacts of the window from the forces at its start; `false` if there are too many to be sure.
    #[inline(always)]
    pub(crate) fn predict(
        &mut self,
        frame: &Frame<'_, M>,
        law: &impl PairLaw,
        left: Beside<M>,
        right: Beside<M>,
        (sin, cos): (f64, f64),
        cuts: Cuts,
    ) -> bool {
        let h = frame.h;
        let drive = self.drive(left, right);
        let linear = frame.omega * frame.omega * (self.path[2].abs() + self.path[3].abs());
        let (k2, k3) = ramps(frame, h, cos, sin);
        let end = along(&self.path, h, cos, sin) + drive[0] * k2 + drive[1] * k3;
        let start = self.overlap[0];
        let rate = self.predicted_rate(frame, drive, sin, cos, k2);
        self.at_end = end;
        let last = if end > 0.0 { law.force(end) } else { 0.0 };
        self.bend = (last - (self.force[0] + self.force[1] * h)) / (h * h);
        // Hermite's cubic, whose error G t^2 (h - t)^2/24 touches only the middle coefficient in Bernstein's basis of degree 4.
        let square = frame.omega * frame.omega;
        let fourth = square * (linear + drive[0].abs() + drive[1].abs() * h);
        let error = fourth * (h * h) * (h * h) * (1.0 / 144.0);
        let (b1, b2) = (start + h * self.overlap[1] * (1.0 / 3.0), end - h * rate * (1.0 / 3.0));
        let sign = if self.ongoing.is_some() { 1.0 } else { -1.0 };
        let [c1, c2, c3, c4] =
            [0.25 * (start + 3.0 * b1), 0.5 * (b1 + b2), 0.25 * (3.0 * b2 + end), end].map(|c| sign * c);
        let band = self.band;
        let still = |c: f64| c.abs() <= band;
        if still(start) && still(b1) && still(b2) && still(end) && error <= band {
            // Rounding only: it stays on its side.
            self.slack = 0.0;
            self.contacts.extend(self.ongoing.map(|contact| Contact { release: f64::INFINITY, ..contact }));
            return true;
        }
        let least = |a: f64, b: f64| if a < b { a } else { b };
        if c1 > band && c2 > error + band && c3 > band && c4 > band && sign * start > -band {
            self.slack = least(least(c1, c2 - error), least(c3, c4));
            let Some(contact) = self.ongoing else { return true };
            self.contacts.push(Contact { release: f64::INFINITY, ..contact });
            self.look_ahead(frame, drive, (end, rate));
            return true;
        }
        // One change of sign among the coefficients, whatever the error and a slack make of them.
        let more = |a: f64, b: f64| if a > b { a } else { b };
        let slack = least(least(-c4, more(c1, -c2 - error)), least(more(c1, -c3), more(c2 - error, -c3)));
        let once = sign * start > band && slack > band;
        if !once {
            return self.look(frame, drive, linear, cuts, (end, rate));
        }
        // A few steps of the Illinois method are better than the prediction deserves.
        let (mut a, mut b, mut slope) = ((0.0, start), (h, end), (end - start) / h);
        for _ in 0..4 {
            let t = b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1);
            let g = predicted(frame, &self.path, drive, t);
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
        self.slack = least(slack, unsure);
        if !(sign * slope < 0.0 && t > 0.0 && t < h && unsure > 0.0) {
            return self.look(frame, drive, linear, cuts, (end, rate));
        }
        match self.ongoing {
            Some(contact) => {
                self.contacts.push(Contact { release: t, slopes: [contact.slopes[0], slope], ..contact });
            }
            None => {
                self.contacts.push(Contact::new(t, f64::INFINITY, [slope, 0.0]));
                self.look_ahead(frame, drive, (end, rate));
            }
        }
        true
    }

    /// The rate of the predicted overlap at the end of the window.
    #[inline(always)]
    fn predicted_rate(&self, frame: &Frame<'_, M>, drive: [f64; 2], sin: f64, cos: f64, k2: f64) -> f64 {
        let h = frame.h;
        let k1 = if frame.omega == 0.0 { h } else { frame.m * h + frame.mu * sin / frame.omega };
        self.path[1] + frame.omega * (self.path[3] * cos - self.path[2] * sin) + drive[0] * k1 + drive[1] * k2
    }

    /// Searches the prediction.
    #[inline(never)]
    fn look(&mut self, frame: &Frame<'_, M>, drive: [f64; 2], linear: f64, cuts: Cuts, end: (f64, f64)) -> bool {
        let path = self.path;
        let driven = |t: f64| drive[0].abs() + drive[1].abs() * t;
        let rounding = ROUNDING * driven(frame.h) * frame.h * frame.h;
        let g = |t| predicted(frame, &path, drive, t);
        let found = self.search(frame.h, cuts.unfelt.max(rounding), |t| linear + driven(t), g);
        if self.contacts.last().is_some_and(|contact| contact.release > frame.h) {
            self.look_ahead(frame, drive, end);
        }
        found
    }

    /// Estimates when a contact that outlasts the window will end.
    #[inline(always)]
    fn look_ahead(&mut self, frame: &Frame<'_, M>, drive: [f64; 2], (end, rate): (f64, f64)) {
        let h = frame.h;
        if rate >= 0.0 || end + AHEAD * h * rate > 0.0 {
            return;
        }
        let (mut b, mut slope) = ((h, end), rate);
        for _ in 0..2 {
            let t = b.0 - b.1 / slope;
            if !(t > h && t < (1.0 + AHEAD) * h) {
                return;
            }
            let c = (t, predicted(frame, &self.path, drive, t));
            slope = (c.1 - b.1) / (c.0 - b.0);
            b = c;
            if slope >= 0.0 {
                return;
            }
        }
        if let Some(contact) = self.contacts.last_mut() {
            let t = b.0 - b.1 / slope;
            if t > h {
                (contact.release, contact.slopes[1]) = (t, slope);
            }
        }
    }

    /// Finds the contacts of the window from what is known of all forces. Returns whether they differ from those
    /// assumed; `None` if there are too many to be sure.
    pub(crate) fn verify(
        &mut self,
        frame: &Frame<'_, M>,
        left: Beside<M>,
        right: Beside<M>,
        cuts: Cuts,
    ) -> Option<bool> {
        let linear = frame.omega * frame.omega * (self.path[2].abs() + self.path[3].abs());
        std::mem::swap(&mut self.contacts, &mut self.assumed);
        let panels = std::mem::replace(&mut self.panels, Panels::new());
        let (path, recoil) = (self.path, self.recoil);
        let g = |t: f64| overlap_at(&path, (&panels, recoil), frame, [left, right], t);
        // Between nodes a force may be a little larger than at any.
        let largest = |panels: &Panels<M>, t: f64| 1.2 * panels.largest_force(t);
        let beside = |bond: Beside<M>, t: f64| bond.map_or(0.0, |bond| largest(&bond.panels, t));
        let driven = |t: f64| (beside(left, t) + beside(right, t)).max(recoil * largest(&panels, t));
        let rounding = ROUNDING * driven(frame.h) * frame.h * frame.h;
        let band = cuts.unfelt.max(rounding).max(self.band);
        let on_surface = g(frame.h).abs() <= band;
        let sure = self.search(frame.h, band, |t| linear + driven(t), g);
        self.panels = panels;
        self.suspicious = false;
        // On the surface at the end of the window it may be said to have left or not.
        let alike = |(a, b): (&Contact, &Contact)| {
            let ([begins, ends], [begun, ended]) = (a.events(frame.h), b.events(frame.h));
            // Newton's method may have led astray.
            let sound = a.release > a.onset.max(0.0) && a.onset <= frame.h;
            sound && begins == begun && (ends == ended || on_surface)
        };
        let (assumed, found) = (&self.assumed, &mut self.contacts);
        let same = assumed.len() == found.len() && assumed.iter().zip(&*found).all(alike);
        if same {
            std::mem::swap(&mut self.contacts, &mut self.assumed);
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
        let predicted = |t: f64| self.force[0] + self.force[1] * t;
        // The prediction goes on after a release, when there is no force.
        let mut surprise = match self.contacts.last() {
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
        self.surprise = surprise;
    }

    /// The contact that outlasts the window, in the time of the next one.
    pub(crate) fn outlasting(&self, h: f64) -> Option<Contact> {
        let contact = self.contacts.last().filter(|contact| contact.release > h)?;
        Some(Contact { onset: contact.onset - h, release: f64::INFINITY, ..*contact })
    }

    /// What a contact did in this window.
    pub(crate) fn piece_of(
        &self,
        frame: &Frame<'_, M>,
        contact: &Contact,
        beside: [Beside<M>; 2],
        bond: usize,
    ) -> Piece {
        let panels = &self.panels.list[contact.panels.0..contact.panels.1];
        let rule = &frame.rule;
        let [begins, ends] = contact.events(frame.h);
        // dg/dt of the parabola through three points nearby.
        let speed = |t: f64| {
            let near = SPEED_STEP * frame.h;
            let (a, c) = ((t - near).max(0.0), (t + near).min(frame.h));
            let b = 0.5 * (a + c);
            let [ga, gb, gc] = [a, b, c].map(|t| overlap_at(&self.path, (&self.panels, self.recoil), frame, beside, t));
            let (first, second) = ((gb - ga) / (b - a), (gc - gb) / (c - b));
            0.5 * (first + second) + (second - first) * (t - b) / (b - a)
        };
        // The last correction of t_e was too small for new panels, but not for the record.
        let event = |mut t: f64| {
            for _ in 0..2 {
                let slope = speed(t);
                if slope != 0.0 {
                    t = (t - overlap_at(&self.path, (&self.panels, self.recoil), frame, beside, t) / slope)
                        .clamp(0.0, frame.h);
                }
            }
            (t, speed(t))
        };
        Piece {
            bond,
            onset: begins.then(|| event(contact.onset)),
            release: ends.then(|| event(contact.release)),
            impulse: panels.iter().map(|panel| panel.impulse(rule)).sum(),
            largest: panels.iter().map(|panel| panel.largest(rule)).fold(0.0, f64::max),
        }
    }

    /// Finds contacts; `false` if there are too many to be sure.
    fn search(&mut self, h: f64, band: f64, curvature: impl Fn(f64) -> f64, g: impl FnMut(f64) -> f64) -> bool {
        let start = Start {
            value: self.overlap[0],
            slope: self.overlap[1],
            rounding: self.band,
            positive: self.ongoing.is_some(),
        };
        let slack = Search::new(g, curvature, band.max(self.band), &mut self.crossings).run(start, h);
        self.slack = slack.unwrap_or(0.0);
        self.contacts.clear();
        let mut open = self.ongoing.map(|contact| Contact { release: f64::INFINITY, ..contact });
        for crossing in &self.crossings {
            if crossing.rising {
                open = Some(Contact::new(crossing.t, f64::INFINITY, [crossing.slope, 0.0]));
            } else if let Some(contact) = open.take() {
                let slopes = [contact.slopes[0], crossing.slope];
                self.contacts.push(Contact { release: crossing.t, slopes, ..contact });
            }
        }
        self.contacts.extend(open);
        slack.is_some()
    }

    /// Cuts the contacts into panels.
    #[inline(always)]
    pub(crate) fn lay_out(
        &mut self,
        frame: &Frame<'_, M>,
        left: Beside<M>,
        right: Beside<M>,
        cuts: Cuts,
        old: &mut Panels<M>,
    ) {
        std::mem::swap(&mut self.panels, old);
        self.panels.clear();
        self.panels.version = old.version + 1;
        (self.stale, self.age) = (false, 0);
        for i in 0..self.contacts.len() {
            let contact = self.contacts[i];
            let first = self.panels.len;
            if contact.release > contact.onset {
                self.cut(frame, contact, [left, right], cuts);
            }
            self.contacts[i].panels = (first, self.panels.len);
        }
    }

    #[inline(always)]
    fn cut(&mut self, frame: &Frame<'_, M>, contact: Contact, beside: [Beside<M>; 2], cuts: Cuts) {
        let (start, end) = (contact.onset.max(0.0), contact.release.min(frame.h));
        // The latest onset behind a panel and the earliest release ahead of it, also of neighbours.
        let (mut behind, mut ahead) = (contact.onset, contact.release);
        let mut points = [(0.0, false); 8];
        let mut count = 0;
        if cuts.neighbours {
            for bond in beside.into_iter().flatten() {
                for c in &bond.contacts {
                    if c.onset <= start + cuts.merge {
                        behind = behind.max(c.onset.min(start));
                    } else if c.onset < end - cuts.merge && count < points.len() {
                        points[count] = (c.onset, true);
                        count += 1;
                    }
                    if c.release >= end - cuts.merge {
                        ahead = ahead.min(c.release.max(end));
                    } else if c.release > start + cuts.merge && count < points.len() {
                        points[count] = (c.release, false);
                        count += 1;
                    }
                }
            }
        }
        let points = &mut points[..count];
        if count > 1 {
            points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        }
        let mut from = start;
        for i in 0..=count {
            let (to, onset) = if i < count { points[i] } else { (end, false) };
            if to > from + cuts.merge || i == count {
                let next = points[i..].iter().find(|p| !p.1).map_or(ahead, |p| p.0);
                self.piece(frame, (from, to), (behind, next), cuts);
                from = to;
            }
            if onset {
                behind = to;
            }
        }
    }

    #[inline(always)]
    fn piece(&mut self, frame: &Frame<'_, M>, (from, to): (f64, f64), (onset, release): (f64, f64), cuts: Cuts) {
        let reach = cuts.near * (to - from);
        let (early, late) = (frame.q > 1 && from - onset < reach, frame.q > 1 && release - to < reach);
        match (early, late) {
            (true, true) => {
                let middle = 0.5 * (from + to);
                self.halve(frame, from, middle, Origin::Before(onset.min(from)));
                self.halve(frame, middle, to, Origin::After(release.max(to)));
            }
            (true, false) => self.halve(frame, from, to, Origin::Before(onset.min(from))),
            (false, true) => self.halve(frame, from, to, Origin::After(release.max(to))),
            (false, false) => self.halve(frame, from, to, Origin::None),
        }
    }

    /// Lays out one stretch, in equal parts of its variable where one panel is not enough.
    #[inline(always)]
    fn halve(&mut self, frame: &Frame<'_, M>, from: f64, to: f64, origin: Origin) {
        let parts = 1 << self.halvings;
        let mut start = from;
        for i in 1..=parts {
            let end = if i == parts { to } else { origin.between(frame.q, from, to, f64::from(i) / f64::from(parts)) };
            self.panels.push(frame, start, end, origin);
            start = end;
        }
    }

    /// The first forces, from the overlaps that the forces at the start of the window predict.
    #[inline(always)]
    pub(crate) fn start(&mut self, frame: &Frame<'_, M>, law: &impl PairLaw, left: Beside<M>, right: Beside<M>) {
        let drive = self.drive(left, right);
        let bend = |bond: Beside<M>| bond.map_or(0.0, |bond| bond.bend);
        let bend = bend(left) + bend(right) - self.recoil * self.bend;
        let (mut before, mut largest) = ([0.0; 4], 0.0);
        for panel in &mut self.panels.list[..self.panels.len] {
            let mut g = [0.0; M];
            for j in 0..M {
                let (t, cos, sin) = (panel.tau[j], panel.cos[j], panel.sin[j]);
                let (k2, k3) = ramps(frame, t, cos, sin);
                g[j] = along(&self.path, t, cos, sin) + (drive[0] * k2 + drive[1] * k3) + bend * ramp2(frame, t, cos);
            }
            for j in 0..M {
                largest = if g[j] > largest { g[j] } else { largest };
            }
            panel.force = law.forces(&g);
            panel.before = before;
            before = panel.integrate(frame);
        }
        (self.panels.total, self.largest) = (before, largest);
    }

    /// The share of a change of an impulse, here or beside and of that age, that the next sweep may change in this bond's own.
    ///
    /// Three forces of stiffness `f'` answer a change, four times in all, through `K(t) <= t`. A change of age `n` is an integral taken `2 n`
    /// times over and grows like `t^{2n}`, so that the next is less by `4 f' h^2/((2n + 1)(2n + 2))`.
    #[inline(always)]
    pub(crate) fn answer(&self, age: u32) -> f64 {
        let age = f64::from(age.min(self.age));
        let answer = 4.0 * self.stiffness / ((2.0 * age + 1.0) * (2.0 * age + 2.0));
        if answer < 1.0 { answer } else { 1.0 }
    }

    /// One sweep: overlaps from all forces, forces from the overlaps, and where contacts begin and end.
    #[inline(always)]
    pub(crate) fn sweep(
        &mut self,
        frame: &Frame<'_, M>,
        law: &impl PairLaw,
        left: Beside<M>,
        right: Beside<M>,
        cuts: Cuts,
        old: &mut Panels<M>,
    ) -> Change {
        let anew = self.stale;
        if anew {
            self.lay_out(frame, left, right, cuts, old);
        }
        let panels = self.panels.len as u64;
        let mut change = Change { work: panels * if anew { LAYOUT + SWEEP } else { SWEEP }, ..Change::default() };
        let total = if anew { old.total } else { self.panels.total };
        let mut before = [0.0; 4];
        let mut largest = 0.0;
        for c in 0..self.contacts.len() {
            let (first, last) = self.contacts[c].panels;
            for k in first..last {
                let panel = &self.panels.list[k];
                let at = (&panel.tau, &panel.cos, &panel.sin);
                let mut g = [0.0; M];
                if anew {
                    for j in 0..M {
                        g[j] = along(&self.path, panel.tau[j], panel.cos[j], panel.sin[j]);
                    }
                    old.influence(at, -self.recoil, &mut g);
                } else {
                    let mut path = self.path;
                    for i in 0..4 {
                        path[i] -= self.recoil * before[i];
                    }
                    for j in 0..M {
                        g[j] = along(&path, panel.tau[j], panel.cos[j], panel.sin[j]) - self.recoil * panel.local[j];
                    }
                }
                let panel = &mut self.panels.list[k];
                if let Some(bond) = left {
                    change.work += VIEW * bond.panels.act(panel, 0, &mut g);
                }
                if let Some(bond) = right {
                    change.work += VIEW * bond.panels.act(panel, 1, &mut g);
                }
                let force = law.forces(&g);
                let mut by = [0.0; M];
                for j in 0..M {
                    by[j] = (force[j] - panel.force[j]).abs();
                }
                if !anew {
                    change.impulse = change.impulse.max(dot(&by, &panel.rate));
                }
                for j in 0..M {
                    largest = if g[j] > largest { g[j] } else { largest };
                }
                panel.overlap = g;
                panel.force = force;
                panel.before = before;
                before = panel.integrate(frame);
                if k == first {
                    let at_start = dot(&frame.rule.ends[0], &g);
                    change.moved = change.moved.max(self.shift_onset(c, at_start, law, cuts));
                }
                if k + 1 == last {
                    let at_end = dot(&frame.rule.ends[1], &g);
                    change.moved = change.moved.max(self.shift_release(c, at_end, frame.h, law, cuts));
                }
            }
        }
        if anew {
            // Nodes have moved: what all of them did together tells.
            change.impulse = (before[1] - total[1]).abs()
                + frame.omega * ((before[2] - total[2]).abs() + (before[3] - total[3]).abs());
        }
        // A sweep may open all nodes: what it found before counts too.
        let was = std::mem::replace(&mut self.largest, largest);
        self.stiffness = law.stiffness(if was > largest { was } else { largest }) * frame.h * frame.h;
        // Where the stiffness has no bound its largest overlap tells little.
        self.age = if law.exponent() < 1.0 { 1 } else { self.age + 1 };
        self.panels.total = before;
        self.stale |= change.moved > 0.0;
        change
    }

    /// Moves an onset by Newton's method with the slope that is known; returns by how much, zero if that is too little to matter.
    #[inline(always)]
    fn shift_onset(&mut self, c: usize, overlap: f64, law: &impl PairLaw, cuts: Cuts) -> f64 {
        let contact = &mut self.contacts[c];
        if contact.onset < 0.0 {
            return 0.0;
        }
        let by = (-overlap / contact.slopes[0]).max(-contact.onset);
        if cuts.negligible(law, overlap, by) {
            return 0.0;
        }
        contact.onset += by;
        self.suspicious |= contact.onset > contact.release;
        by.abs()
    }

    /// The same for a release, in the window or ahead of it.
    #[inline(always)]
    fn shift_release(&mut self, c: usize, overlap: f64, h: f64, law: &impl PairLaw, cuts: Cuts) -> f64 {
        let contact = &mut self.contacts[c];
        if contact.release == f64::INFINITY {
            self.suspicious |= overlap < -self.band;
            return 0.0;
        }
        let (inside, ahead) = (contact.release <= h, contact.release - h);
        let by = if inside {
            -overlap / contact.slopes[1]
        } else if ahead < 0.1 * h {
            -overlap / contact.slopes[1] - ahead
        } else {
            (self.at_end - overlap) / contact.slopes[1]
        };
        // The nearer a release, the better it must be known.
        if by.abs() <= 0.01 * ahead || cuts.negligible(law, contact.slopes[1] * by, by) {
            return 0.0;
        }
        self.at_end = overlap;
        contact.release += by;
        self.suspicious |= contact.onset > contact.release || inside != (contact.release <= h);
        by.abs()
    }
}

/// How contacts are cut into panels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuts {
    /// Also where a contact of a neighbour begins or ends.
    pub(crate) neighbours: bool,
    /// Cuts nearer to an end than this are left out.
    pub(crate) merge: f64,
    /// A panel feels an event up to this many of its lengths away.
    pub(crate) near: f64,
    /// An event is where it is if what it misses of the impulse is less.
    pub(crate) missed: f64,
    /// Overlaps up to this make no force that counts.
    pub(crate) unfelt: f64,
    /// An event of a neighbour is where it is if it is that near.
    pub(crate) frozen_beside: f64,
}

impl Cuts {
    /// Whether an event may be off by a time and an overlap.
    #[inline(always)]
    fn negligible(&self, law: &impl PairLaw, overlap: f64, by: f64) -> bool {
        law.force(overlap.abs()) * by.abs() <= self.missed
    }
}
