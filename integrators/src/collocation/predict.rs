//! The contacts of a bond in a window: predicted from the forces at the window's start, and
//! searched for again with the forces after the sweeps.

use super::{
    bond::{Beside, Bond, Contact, Contacts, Initial, known},
    detect::{Search, Start},
    motion::{
        AHEAD, Drive, ROUNDING, Rotation, Rotations, just_after, overlap_at, predicted, predicted_at, ramps, rate_at,
    },
    panel::Frame,
    panels::Panels,
};

/// A window's share of the tolerance over the change of an impulse for which no event is moved. See
/// `control/accuracy.rs`.
const SHARE: f64 = 1e3;
/// The shortest chord by which a release after the window is estimated, as a share of the window.
/// Chosen: a step of Newton's method errs by about its square.
const CHORD: f64 = 1e-6;

/// The zero of a function with values of both signs at the two `ends` of a window of length `h`,
/// and its slope there, by a few steps of the Illinois method. They are enough for a prediction,
/// which is not exact itself.
#[inline(always)]
fn crossing(h: f64, ends: [f64; 2], g: impl Fn(f64) -> f64) -> [f64; 2] {
    let (mut a, mut b, mut slope) = ((0.0, ends[0]), (h, ends[1]), (ends[1] - ends[0]) / h);
    for _ in 0..4 {
        let t = b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1);
        let value = g(t);
        if value == 0.0 || t <= 0.0 || t >= h {
            break;
        }
        slope = (value - b.1) / (t - b.0);
        a = if (value > 0.0) == (b.1 > 0.0) { (a.0, 0.5 * a.1) } else { b };
        b = (t, value);
    }
    [b.0 - b.1 / slope, slope]
}

impl<const M: usize, const S: usize> Bond<M, S> {
    /// The sum of forces for each side of the bond, from those of the left and right neighbour and
    /// the bond's own.
    #[inline(always)]
    pub(super) fn pushes(&self, left: f64, right: f64, own: f64) -> [f64; S] {
        let mut pushes = [0.0; S];
        if S == 1 {
            pushes[0] = left + right - self.initial.mobility * own;
        } else {
            (pushes[0], pushes[S - 1]) = (left - own, right - own);
        }
        pushes
    }

    /// The [`Drive`] of this bond's overlap: forces at the start of the window and their rates.
    #[inline(always)]
    pub(super) fn drive(&self, [left, right]: [Beside<M, S>; 2]) -> Drive<S> {
        let mut drive = [[0.0; 2]; S];
        for k in 0..2 {
            let left = left.map_or(0.0, |bond| bond.initial.force[k]);
            let right = right.map_or(0.0, |bond| bond.initial.force[k]);
            let pushes = self.pushes(left, right, self.initial.force[k]);
            for side in 0..S {
                drive[side][k] = pushes[side];
            }
        }
        drive
    }

    /// The second derivative of the overlap by the forces `left` and `right` of the neighbours.
    #[inline(always)]
    pub(super) fn driven(frame: &Frame<'_, M, S>, left: f64, right: f64) -> f64 {
        frame.link.weight(0) * left + frame.link.weight(S - 1) * right
    }

    /// Finds the contacts of the window from the forces at its start; `false` if the search needs
    /// too many subdivisions.
    #[inline(always)]
    pub(crate) fn predict(&mut self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2], turn: &Rotations<S>) -> bool {
        if frame.link.lossy() {
            self.predict_dissipative(frame, beside);
            return true;
        }
        let h = frame.h;
        let Initial { path, band, overlap: [start, start_rate], force, ongoing, .. } = self.initial;
        let drive = &self.drive(beside);
        let motion = (&path, known::<S>(&self.known));
        let end = predicted_at(frame, motion, drive, h, turn);
        let rate = self.predicted_rate(frame, drive, turn);
        self.prediction.at_end = end;
        let last = if end > 0.0 { frame.link.elastic_force(end) } else { 0.0 };
        self.prediction.curvature = (last - (force[0] + force[1] * h)) / (h * h);
        // Hermite's cubic, whose error G t^2 (h - t)^2/24 touches only the middle coefficient in
        // Bernstein's basis of degree 4.
        let (second, fourth) = self.bounds(frame, drive);
        let error = fourth * (h * h) * (h * h) * (1.0 / 144.0);
        let (b1, b2) = (start + h * start_rate * (1.0 / 3.0), end - h * rate * (1.0 / 3.0));
        let sign = if ongoing.is_some() { 1.0 } else { -1.0 };
        let (c1, c2) = (sign * (0.25 * (start + 3.0 * b1)), sign * (0.5 * (b1 + b2)));
        let (c3, c4) = (sign * (0.25 * (3.0 * b2 + end)), sign * end);
        let still = |c: f64| c.abs() <= band;
        if still(start) && still(b1) && still(b2) && still(end) && error <= band {
            // The overlap is rounding in the whole window: the bond stays closed or open.
            self.prediction.margin = 0.0;
            self.contacts.found.extend(ongoing.map(|contact| Contact { release: f64::INFINITY, ..contact }));
            return true;
        }
        let least = |a: f64, b: f64| if a < b { a } else { b };
        if c1 > band && c2 > error + band && c3 > band && c4 > band && sign * start > -band {
            self.prediction.margin = least(least(c1, c2 - error), least(c3, c4));
            let Some(contact) = ongoing else { return true };
            self.contacts.found.push(Contact { release: f64::INFINITY, ..contact });
            self.look_ahead(frame, drive, (end, rate));
            return true;
        }
        // One change of sign among the coefficients, also if each is changed by the error and by a
        // margin.
        let more = |a: f64, b: f64| if a > b { a } else { b };
        let margin = least(least(-c4, more(c1, -c2 - error)), least(more(c1, -c3), more(c2 - error, -c3)));
        let once = sign * start > band && margin > band;
        if !once {
            return self.look(frame, drive, (end, rate));
        }
        let [t, slope] = crossing(h, [start, end], |t| predicted(frame, motion, drive, t));
        // Near its zero, as far as its error reaches, the overlap must be monotonic.
        let unsure = slope * slope / second - error;
        self.prediction.margin = least(margin, unsure);
        if !(sign * slope < 0.0 && t > 0.0 && t < h && unsure > 0.0) {
            return self.look(frame, drive, (end, rate));
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

    /// Bounds of the second and the fourth derivative of the predicted overlap.
    #[inline(always)]
    pub(super) fn bounds(&self, frame: &Frame<'_, M, S>, drive: &Drive<S>) -> (f64, f64) {
        let (mut second, mut fourth) = (0.0, 0.0);
        if frame.link.damped() {
            return self.bounds_damped(frame, drive);
        }
        for side in 0..S {
            let [_, _, c, s] = self.initial.path[side];
            let (omega, weight) = (frame.link.sides[side].omega, frame.link.weight(side));
            let square = omega * omega;
            let by =
                square * (c.abs() + s.abs()) + weight * drive[side][0].abs() + weight * drive[side][1].abs() * frame.h;
            second += by;
            fourth += square * by;
        }
        if let Some(known) = known::<S>(&self.known) {
            second += known.curvature_bounds[0];
            fourth += known.curvature_bounds[1];
        }
        (second, fourth)
    }

    /// As [`bounds`](Self::bounds) where a site is damped.
    #[inline(never)]
    fn bounds_damped(&self, frame: &Frame<'_, M, S>, drive: &Drive<S>) -> (f64, f64) {
        let [mut second, mut fourth] = known::<S>(&self.known).map_or([0.0; 2], |known| known.curvature_bounds);
        for side in 0..S {
            let (path, [d0, d1]) = (&self.initial.path[side], drive[side].map(f64::abs));
            let by_forces = frame.link.weight(side) * (d0 + d1 * frame.h);
            if let Some(flow) = frame.link.flow(side) {
                let [k2, k3] = flow.curvature_bounds(frame.h);
                second += flow.curvature_bound(path, frame.h) + by_forces;
                fourth += flow.curvature_bound(&flow.rates(&flow.rates(path)), frame.h) + k3 * d0 + k2 * d1;
            } else {
                let square = frame.link.sides[side].omega.powi(2);
                let by = square * (path[2].abs() + path[3].abs()) + by_forces;
                (second, fourth) = (second + by, fourth + square * by);
            }
        }
        (second, fourth)
    }

    /// A bound of the second derivative of the overlap along its path.
    #[inline(always)]
    pub(super) fn linear(&self, frame: &Frame<'_, M, S>) -> f64 {
        let mut linear = 0.0;
        for side in 0..S {
            let ([_, _, c, s], omega) = (self.initial.path[side], frame.link.sides[side].omega);
            linear += match frame.link.flow(side) {
                Some(flow) => flow.curvature_bound(&self.initial.path[side], frame.h),
                None => omega * omega * (c.abs() + s.abs()),
            };
        }
        known::<S>(&self.known).map_or(linear, |known| linear + known.curvature_bounds[0])
    }

    /// The rate of the predicted overlap at the end of the window.
    #[inline(always)]
    fn predicted_rate(&self, frame: &Frame<'_, M, S>, drive: &Drive<S>, turn: &Rotations<S>) -> f64 {
        let h = frame.h;
        let mut rate = 0.0;
        for path in &self.initial.path {
            rate += path[1];
        }
        if frame.link.damped() {
            return rate + self.rate_damped(frame, drive, turn);
        }
        for side in 0..S {
            let (path, kernel, Rotation { sin, cos, .. }) =
                (&self.initial.path[side], &frame.link.sides[side], turn[side]);
            let k1 = if kernel.omega == 0.0 {
                frame.link.weight(side) * h
            } else {
                kernel.m * h + kernel.mu * sin / kernel.omega
            };
            let (k2, _) = ramps(frame, side, h, turn[side]);
            rate += kernel.omega * (path[3] * cos - path[2] * sin);
            rate = rate + drive[side][0] * k1 + drive[side][1] * k2;
        }
        known::<S>(&self.known).map_or(rate, |known| rate + known.ends[1][1])
    }

    /// The predicted rate without the free velocities, where a site is damped.
    #[inline(never)]
    fn rate_damped(&self, frame: &Frame<'_, M, S>, drive: &Drive<S>, turn: &Rotations<S>) -> f64 {
        let (h, mut rate) = (frame.h, known::<S>(&self.known).map_or(0.0, |known| known.ends[1][1]));
        for side in 0..S {
            let (path, kernel, [d0, d1]) = (&self.initial.path[side], &frame.link.sides[side], drive[side]);
            let Rotation { sin, cos, lag, ramps: [k1, k2, _] } = turn[side];
            if let Some(flow) = frame.link.flow(side) {
                let [_, v, c, s] = flow.rates(path);
                rate += v * (h + lag) + (c * cos + s * sin) + d0 * k1 + d1 * k2;
            } else {
                let swing = if kernel.omega == 0.0 { kernel.mu * h } else { kernel.mu * sin / kernel.omega };
                let (k2, _) = ramps(frame, side, h, turn[side]);
                rate += kernel.omega * (path[3] * cos - path[2] * sin) + d0 * (kernel.m * h + swing) + d1 * k2;
            }
        }
        rate
    }

    /// Searches the predicted overlap for contacts, and estimates a release after the window;
    /// `false` if the search needs too many subdivisions.
    #[inline(never)]
    fn look(&mut self, frame: &Frame<'_, M, S>, drive: &Drive<S>, end: (f64, f64)) -> bool {
        let (path, given, linear) = (self.initial.path, self.known, self.linear(frame));
        let driven = |t: f64| {
            let by = |side: usize| frame.link.weight(side) * (drive[side][0].abs() + drive[side][1].abs() * t);
            (1..S).fold(by(0), |sum, side| sum + by(side))
        };
        let rounding = ROUNDING * driven(frame.h) * frame.h * frame.h;
        let g = |t| predicted(frame, (&path, known::<S>(&given)), drive, t);
        let found = self.search(frame.h, frame.cuts.least_overlap.max(rounding), |t| linear + driven(t), g);
        if self.contacts.found.last().is_some_and(|contact| contact.release > frame.h) {
            self.look_ahead(frame, drive, end);
        }
        found
    }

    /// Estimates the release of a contact that continues after the window.
    #[inline(always)]
    fn look_ahead(&mut self, frame: &Frame<'_, M, S>, drive: &Drive<S>, (end, rate): (f64, f64)) {
        let (h, motion) = (frame.h, (&self.initial.path, known::<S>(&self.known)));
        if rate >= 0.0 || end + AHEAD * h * rate > 0.0 {
            return;
        }
        let (mut b, mut slope) = ((h, end), rate);
        for _ in 0..2 {
            let t = b.0 - b.1 / slope;
            // Earlier only if the overlap counts as zero in the whole window.
            if !(t > 0.5 * h && t < (1.0 + AHEAD) * h) {
                return;
            }
            // A shorter chord is rounding; and an overlap that counts as zero may be below it.
            if t <= h || (t - b.0).abs() <= CHORD * h {
                break;
            }
            let c = (t, predicted(frame, motion, drive, t));
            slope = (c.1 - b.1) / (c.0 - b.0);
            b = c;
            if slope >= 0.0 {
                return;
            }
        }
        if let Some(contact) = self.contacts.found.last_mut() {
            (contact.release, contact.slopes[1]) = ((b.0 - b.1 / slope).max(just_after(h)), slope);
        }
    }

    /// A bound of the second derivative of the overlap by the forces up to a time; those of the
    /// bond are in `panels`.
    pub(super) fn driven_up_to(
        frame: &Frame<'_, M, S>,
        beside: [Beside<M, S>; 2],
        (panels, mobility): (&Panels<M, S>, f64),
        t: f64,
    ) -> f64 {
        // Between nodes a force may be a little larger than at any.
        let largest = |panels: &Panels<M, S>| 1.2 * panels.largest_force(t);
        let of = |bond: Beside<M, S>| bond.map_or(0.0, |bond| largest(&bond.panels));
        Self::driven(frame, of(beside[0]), of(beside[1])).max(mobility * largest(panels))
    }

    /// Overlaps of at most this value count as zero.
    pub(super) fn band(&self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2], panels: &Panels<M, S>) -> f64 {
        let driven = Self::driven_up_to(frame, beside, (panels, self.initial.mobility), frame.h);
        let rounding = ROUNDING * driven * frame.h * frame.h;
        frame.cuts.least_overlap.max(rounding).max(self.initial.band)
    }

    /// Finds the contacts of the window from all forces computed so far. Returns whether they
    /// differ from the contacts assumed before; `None` if the search needs too many subdivisions.
    pub(crate) fn verify(&mut self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2]) -> Option<bool> {
        let Initial { path, mobility, .. } = self.initial;
        let given = self.known;
        let (linear, own) = (self.linear(frame), self.initial.own());
        std::mem::swap(&mut self.contacts.found, &mut self.contacts.assumed);
        let panels = std::mem::replace(&mut self.panels, Panels::new());
        let motion = (&path, known::<S>(&given));
        let g = |t: f64| overlap_at(motion, (&panels, own), frame, beside, t);
        let driven = |t: f64| Self::driven_up_to(frame, beside, (&panels, mobility), t);
        let band = self.band(frame, beside, &panels);
        let (sure, on_surface) = if frame.link.lossy() {
            (true, self.search_again(frame, beside, (&panels, band)))
        } else {
            let on_surface = g(frame.h).abs() <= band;
            (self.search(frame.h, band, |t| linear + driven(t), g), on_surface)
        };
        self.pending.search = false;
        // Two contacts are one if they share half of the longer one's time in the window, or if the
        // force between does not matter. Newton's method may find other zeros than the search: it
        // may lead a contact to next to no time, with all its forces.
        let shared = |a: &Contact, b: &Contact| {
            let [[a0, a1], [b0, b1]] = [a, b].map(|c| [c.onset.max(0.0), c.release.min(frame.h)]);
            let (longer, middle) = ((a1 - a0).max(b1 - b0), 0.5 * (b0 + b1));
            let nothing = || {
                let rate =
                    if frame.link.lossy() { rate_at(motion, (&panels, own), frame, beside, middle) } else { 0.0 };
                let force = frame.link.law.force(g(middle), rate);
                g(middle) <= band || force * longer * frame.link.lightest() <= SHARE * frame.cuts.event_impulse
            };
            2.0 * (a1.min(b1) - a0.max(b0)) >= longer || nothing()
        };
        // If the overlap is zero at the end of the window, the contact may or may not have ended.
        let alike = |(a, b): (&Contact, &Contact)| {
            let ([begins, ends], [begun, ended]) = (a.events(frame.h), b.events(frame.h));
            begins == begun && (ends == ended || on_surface) && shared(a, b)
        };
        let Contacts { assumed, found, .. } = &mut self.contacts;
        // Newton's method may have diverged, or led to contacts of which one begins before
        // another has ended, so that its force counts twice.
        let twice = |pair: &[Contact]| {
            let (from, to) = (pair[1].onset.max(0.0), pair[0].release);
            from < to && !frame.cuts.negligible(frame.link, g(from).abs().max(g(to).abs()), to - from, None)
        };
        let sound = !self.pending.diverged
            && assumed.iter().all(|a| a.release >= a.onset.max(0.0))
            && !assumed.windows(2).any(twice);
        let same = sound && assumed.len() == found.len() && assumed.iter().zip(found.iter()).all(alike);
        self.panels = panels;
        if same {
            std::mem::swap(found, assumed);
        } else if let (Some(old), Some(new)) = (assumed.last(), found.last_mut())
            && new.release > frame.h
            && old.release < f64::INFINITY
        {
            // A contact that was assumed to end in the window ends soon after it.
            (new.release, new.slopes[1]) = (old.release.max(just_after(frame.h)), old.slopes[1]);
        }
        self.pending.diverged = false;
        sure.then_some(!same)
    }

    /// Computes [`Prediction::predictor_error`](super::bond::Prediction::predictor_error): how far
    /// the force is from the predicted one.
    #[inline(always)]
    pub(crate) fn set_predictor_error(&mut self, h: f64) {
        let force = self.initial.force;
        let predicted = |t: f64| force[0] + force[1] * t;
        // The prediction goes on after a release, when there is no force.
        let mut predictor_error = match self.contacts.found.last() {
            Some(contact) if contact.release > h => 0.0,
            Some(_) => predicted(h).abs(),
            None => predicted(0.0).abs().max(predicted(h).abs()),
        };
        for panel in self.panels.as_slice() {
            for j in 0..M {
                let off = (panel.force[j] - predicted(panel.tau[j])).abs();
                predictor_error = if off > predictor_error { off } else { predictor_error };
            }
        }
        self.prediction.predictor_error = predictor_error;
    }

    /// Finds the contacts of an overlap `g` whose second derivative up to a time has the bound
    /// `curvature`; `false` if the search needs too many subdivisions.
    fn search(&mut self, h: f64, band: f64, curvature: impl Fn(f64) -> f64, g: impl FnMut(f64) -> f64) -> bool {
        let Initial { band: rounding, overlap: [value, slope], ongoing, .. } = self.initial;
        let start = Start { value, slope, rounding, positive: ongoing.is_some() };
        let Contacts { found, crossings, .. } = &mut self.contacts;
        let margin = Search::new(g, curvature, band.max(rounding), crossings).run(start, h);
        self.prediction.margin = margin.unwrap_or(0.0);
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
        margin.is_some()
    }
}
