//! A sweep over a bond: overlaps from all forces, then forces from overlaps, and the ends of its
//! contacts by Newton's method.

use super::{
    bond::{Beside, Bond, Contact, Initial, Pending, known},
    chain::Path,
    motion::ramped,
    panel::{Frame, Panel},
    panels::Panels,
    series::dot,
    sites::Free,
};

/// The changes by one sweep over a bond.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Change {
    /// Largest change of an impulse, as a change of velocity.
    pub(crate) impulse: f64,
    /// Largest time by which an event moved. If positive, panels of this bond must be laid out
    /// anew.
    pub(crate) moved: f64,
    /// Cost of the sweep, in the units of [`BOND`].
    pub(crate) work: u64,
}

/// Cost of parts of a window, in units of about 10 ns: of each bond, of each panel that is laid
/// out, of each panel that is swept, and of each panel of a neighbour that acts on it. From timings
/// of such parts on one machine, which no bench repeats one by one. The lengths of windows depend
/// on these numbers; `benches/collocation.rs` times the cost of windows.
pub(crate) const BOND: u64 = 12;
pub(crate) const LAYOUT: u64 = 11;
const SWEEP: u64 = 8;
const VIEW: u64 = 3;

impl<const M: usize, const S: usize> Panel<M, S> {
    /// Overlaps at the nodes from the linear path, from the forces of the bond and from those
    /// beside it; without damping and drives. `before` is the path by earlier panels of the bond,
    /// `own` the weight of its forces, `old` its panels of the last sweep if it has been laid out
    /// since. Also the path that is one for all nodes, which the overlaps contain, and the work.
    #[inline(always)]
    fn overlaps(
        &mut self,
        (linear, before, own): (&[Path; S], &[Path; S], f64),
        beside: [Beside<M, S>; 2],
        old: Option<&Panels<M, S>>,
    ) -> ([Path; S], [f64; M], u64) {
        let (mut path, mut g, mut work) = (*linear, [0.0; M], 0);
        if let Some(old) = old {
            old.own_influence_at_nodes(self.times(), -own, &mut g);
        } else {
            for side in 0..S {
                for i in 0..4 {
                    path[side][i] -= own * before[side][i];
                }
            }
            for j in 0..M {
                g[j] = -own * self.local[0][j];
            }
            for side in 1..S {
                for j in 0..M {
                    g[j] -= own * self.local[side][j];
                }
            }
        }
        for (side, bond) in beside.into_iter().enumerate() {
            if let Some(bond) = bond {
                work += VIEW * bond.panels.act(self, side, &mut path, &mut g);
            }
        }
        for j in 0..M {
            g[j] += self.times().along(&path, j);
        }
        (path, g, work)
    }
}

/// A step of an event at `t` that does not lead it before the window. Not a number stays so.
#[inline(always)]
fn not_before(t: f64, by: f64) -> f64 {
    if by < -t { -t } else { by }
}

impl<const M: usize, const S: usize> Bond<M, S> {
    /// Begins a new window: takes the linear path in it and the contact that continues into it.
    pub(crate) fn begin(
        &mut self,
        frame: &Frame<'_, M, S>,
        free: Free<S>,
        ongoing: Option<Contact>,
        (bond, mobility): (usize, f64),
    ) {
        let (Free { path, band }, link) = (free, frame.link);
        let mut overlap = [path[0][0], path[0][1]];
        for side in 1..S {
            overlap[1] += path[side][1];
        }
        for side in 0..S {
            overlap[0] += path[side][2];
            overlap[1] += link.sides[side].omega * path[side][3];
        }
        if let Some(known) = known::<S>(&self.known) {
            for k in 0..2 {
                overlap[k] += known.ends[0][k];
            }
        }
        let mut force = [0.0; 2];
        if overlap[0] > 0.0 {
            let rate = link.stiffness(overlap[0]) * overlap[1];
            // Right after an onset with alpha < 1 the rate has no bound and predicts nothing of the
            // forces that follow.
            force = [link.elastic_force(overlap[0]), if link.law.alpha() < 1.0 { 0.0 } else { rate }];
        }
        self.initial = Initial {
            bond,
            mobility,
            path,
            band,
            overlap,
            force,
            ongoing,
            singular_after: link.singular_after(0.0, 0.0),
        };
        if link.lossy() {
            self.initial.force = self.resisting(frame);
        }
        self.contacts.found.clear();
        self.panels.clear();
        self.prediction.predictor_error = 0.0;
        (self.sweeps.stiffness, self.sweeps.largest, self.resolution.halvings) = (0.0, 0.0, 0);
        self.sweeps.resistance = 0.0;
        self.pending = Pending::default();
    }

    /// An estimate of the stiffness `f'(g) t^2/m` of a contact that the bond is in, or comes into
    /// along its free path: `t` is the time that the contact may last in the window, `g` the
    /// largest overlap that the bond may reach by itself.
    ///
    /// Two bounds hold for `g`: the largest overlap of the free path; and the overlap at which the
    /// bond's own force has stopped an approach with speed `w`, `w^2/2 = mobility (g^{alpha+1} -
    /// g_0^{alpha+1})/(alpha+1)`. Overlaps due to neighbours are of the size of the neighbours' own
    /// overlaps, for which this estimate is made too.
    pub(crate) fn approach(&self, frame: &Frame<'_, M, S>, most: f64) -> f64 {
        let Initial { mobility, path, overlap: [now, rate], .. } = self.initial;
        let (h, link, power) = (frame.h, frame.link, frame.link.law.alpha() + 1.0);
        let ([r, mut v, ..], mut swing, mut swings) = (path[0], 0.0, 0.0);
        for side in 1..S {
            v += path[side][1];
        }
        for ([_, _, c, s], kernel) in path.iter().zip(&link.sides) {
            // The squares of `c` and `s` may overflow where omega is small.
            let [c, s] = [c, s].map(|part| kernel.omega * part);
            let fast = (c * c + s * s).sqrt();
            swing += fast * kernel.per_omega;
            swings += fast;
        }
        if let Some(known) = known::<S>(&self.known) {
            let [far, fast] = known.reach();
            (swing, swings) = (swing + far, swings + fast);
        }
        let speed = rate.abs().max(v.abs() + swings);
        let reached = (r + v.max(0.0) * h + swing).min(now + speed * h);
        if reached <= 0.0 {
            return 0.0;
        }
        let lasts = if now < 0.0 { h + now / speed } else { h };
        let stiffness = link.stiffness_over(reached, lasts);
        if stiffness <= most && power >= 2.0 {
            return stiffness;
        }
        let opens = mobility * link.constant();
        let stopped = (speed * speed * power / (2.0 * opens) + now.max(0.0).powf(power)).powf(1.0 / power);
        link.stiffness_over(reached.min(stopped), lasts)
    }

    /// The contact that outlasts the window, in the time of the next one.
    pub(crate) fn outlasting(&self, h: f64) -> Option<Contact> {
        let contact = self.contacts.found.last().filter(|contact| contact.release > h)?;
        let steps = [contact.steps[0], f64::INFINITY];
        Some(Contact { onset: contact.onset - h, release: f64::INFINITY, steps, ..*contact })
    }

    /// Computes the first forces at the nodes, from the overlaps that the forces at the start of
    /// the window predict.
    #[inline(always)]
    pub(crate) fn start(&mut self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2]) {
        let drive = self.drive(beside);
        let of = |bond: Beside<M, S>| bond.map_or(0.0, |bond| bond.prediction.curvature);
        let curvature = self.pushes(of(beside[0]), of(beside[1]), self.prediction.curvature);
        let (mut path, [mut a, mut b, mut c]) = (self.initial.path, [0.0; 3]);
        for side in 0..S {
            let rates = [drive[side][0], drive[side][1], 2.0 * curvature[side]];
            let (own, by) = ramped(frame, side, path[side], rates);
            path[side] = own;
            a += by[0];
            b += by[1];
            c += by[2];
        }
        let (mut before, mut largest) = ([[0.0; 4]; S], 0.0);
        for panel in &mut self.panels.list[..self.panels.len] {
            let mut g = [0.0; M];
            for j in 0..M {
                let t = panel.tau[j];
                let driven = (t * t) * t.mul_add(t.mul_add(c, b), a);
                g[j] = panel.times().along(&path, j) + driven;
            }
            if S != 1 && (frame.link.lags || self.known.is_some()) {
                g = panel.besides(self.known.is_some(), path, g);
            }
            for j in 0..M {
                largest = if g[j] > largest { g[j] } else { largest };
            }
            panel.force = if frame.link.lossy() {
                panel.resist_ahead(frame, (&path, [a, b, c]), &g)
            } else {
                frame.link.forces(&g)
            };
            panel.before = before;
            before = panel.integrate(frame);
        }
        (self.panels.total, self.sweeps.largest) = (before, largest);
    }

    /// Contraction factor, at most 1: the change of this bond's impulse in the next sweep is below
    /// this factor times the last change, of age `age`, of its own impulse or a neighbour's.
    ///
    /// Three forces of stiffness `f'` answer a change, with weights of 4 in all, through
    /// `K(t) <= t`. A change of age `n` is an integral taken `2 n` times over and grows like
    /// `t^{2n}`, so that the next is smaller by `4 f' h^2/((2n + 1)(2n + 2))`.
    #[inline(always)]
    pub(crate) fn answer(&self, age: u32) -> f64 {
        let age = f64::from(age.min(self.sweeps.age));
        let mut answer = 4.0 * self.sweeps.stiffness / ((2.0 * age + 1.0) * (2.0 * age + 2.0));
        if S != 1 {
            answer += 2.0 * self.sweeps.resistance / (2.0 * age + 1.0);
        }
        if answer < 1.0 { answer } else { 1.0 }
    }

    /// Whether the next sweep must include this bond.
    #[inline(always)]
    pub(crate) fn waits(&self) -> bool {
        self.pending.layout || self.pending.sweep
    }

    /// One sweep: overlaps from all forces, forces from the overlaps, and a Newton step for the
    /// times at which contacts begin and end. If panels have been laid out since the last sweep,
    /// `old` are the panels before that.
    #[inline(always)]
    pub(crate) fn sweep(
        &mut self,
        frame: &Frame<'_, M, S>,
        beside: [Beside<M, S>; 2],
        old: Option<&Panels<M, S>>,
    ) -> Change {
        let (linear, own) = (self.initial.path, self.initial.own());
        let anew = old.is_some();
        self.pending.diverged = false;
        let panels = self.panels.len as u64;
        let mut change = Change { work: panels * if anew { LAYOUT + SWEEP } else { SWEEP }, ..Change::default() };
        let total = old.map_or(self.panels.total, |old| old.total);
        let mut before = [[0.0; 4]; S];
        let mut largest = 0.0;
        for c in 0..self.contacts.found.len() {
            let (first, last) = self.contacts.found[c].panels;
            for k in first..last {
                let panel = &mut self.panels.list[k];
                let (path, mut g, work) = panel.overlaps((&linear, &before, own), beside, old);
                change.work += work;
                if S != 1 && (frame.link.lags || self.known.is_some()) {
                    g = panel.besides(self.known.is_some(), path, g);
                }
                let force = if frame.link.lossy() {
                    // Rates are those of the new panels also where overlaps are of the old ones.
                    let earlier = if anew { before } else { [[0.0; 4]; S] };
                    panel.resist(frame, beside, [&path, &earlier], &g)
                } else {
                    frame.link.forces(&g)
                };
                let mut by = [0.0; M];
                for j in 0..M {
                    by[j] = (force[j] - panel.force[j]).abs();
                }
                if !anew {
                    // Not a number counts as large.
                    let by = dot(&by, &panel.rate);
                    change.impulse = if by <= change.impulse { change.impulse } else { by };
                }
                for j in 0..M {
                    largest = if g[j] > largest { g[j] } else { largest };
                }
                panel.overlap = g;
                panel.force = force;
                panel.before = before;
                before = panel.integrate(frame);
                if k == first {
                    let (at_start, slope) = if S != 1 && self.contacts.found[c].overlaps_at_onset {
                        panel.pushes(frame, 0)
                    } else {
                        (dot(&frame.rule.ends[0], &g), panel.chord(&g, 0, 1..M))
                    };
                    change.moved = change.moved.max(self.shift_onset(frame, c, (at_start, slope)));
                }
                if k + 1 == last {
                    let panel = &self.panels.list[k];
                    let (at_end, slope) = if frame.link.lossy() {
                        panel.pushes(frame, 1)
                    } else {
                        (dot(&frame.rule.ends[1], &g), panel.chord(&g, M - 1, (0..M - 1).rev()))
                    };
                    change.moved = change.moved.max(self.shift_release(frame, c, (at_end, slope)));
                }
            }
        }
        self.end_sweep(frame, [&before, &total], (largest, anew), change)
    }

    /// Keeps what a sweep has found: paths `[after, before]` that all panels leave behind, and the
    /// largest overlap; completes its `change`.
    #[inline(always)]
    fn end_sweep(
        &mut self,
        frame: &Frame<'_, M, S>,
        [after, before]: [&[Path; S]; 2],
        (largest, anew): (f64, bool),
        mut change: Change,
    ) -> Change {
        if anew {
            // Nodes have moved, so that forces at them cannot be compared: compare total impulses.
            for side in 0..S {
                let ([_, v, c, s], [_, v0, c0, s0]) = (after[side], before[side]);
                change.impulse += (v - v0).abs() + frame.link.sides[side].omega * ((c - c0).abs() + (s - s0).abs());
            }
        } else if S != 1 {
            change.impulse *= frame.link.lightest();
        }
        let sweeps = &mut self.sweeps;
        // After a sweep all overlaps may be zero or less: the largest of the last sweep counts too.
        let was = std::mem::replace(&mut sweeps.largest, largest);
        let most = if was > largest { was } else { largest };
        sweeps.stiffness = frame.link.stiffness_over(most, frame.h);
        if frame.link.lossy() {
            sweeps.resistance = frame.link.resistance_if_closed(most) * frame.h * frame.link.lightest();
        }
        // For alpha < 1 the stiffness is largest at small overlaps, and has no bound.
        sweeps.age = if frame.link.law.alpha() < 1.0 { 1 } else { sweeps.age + 1 };
        sweeps.change = change.impulse;
        self.panels.total = *after;
        self.pending.layout |= change.moved > 0.0;
        change
    }

    /// Moves an onset by one step of Newton's method, from the interpolated overlap and slope at
    /// it. Returns the size of the step, a time; zero if it is negligible and was not done.
    #[inline(always)]
    fn shift_onset(&mut self, frame: &Frame<'_, M, S>, c: usize, (overlap, slope): (f64, f64)) -> f64 {
        let contact = &mut self.contacts.found[c];
        if contact.onset < 0.0 {
            return 0.0;
        }
        if slope > 0.0 {
            contact.slopes[0] = slope;
        }
        // At the start the overlap is known without the error of a series.
        let known = frame.link.lossy() && contact.onset == 0.0 && !contact.overlaps_at_onset;
        let overlap = if known { self.initial.overlap[0] } else { overlap };
        // What pushes at the start has begun before: also where `P` falls.
        if contact.onset == 0.0 && overlap >= 0.0 {
            return 0.0;
        }
        let by = not_before(contact.onset, -overlap / contact.slopes[0]);
        // The impulse of a force that jumps is of first order in the error of its onset, so that a
        // step may be rounding and not negligible.
        let rounding = overlap.abs() <= self.initial.band && by.abs() >= 0.5 * contact.steps[0];
        let deepest = contact.overlaps_at_onset.then_some(self.sweeps.largest);
        if rounding || frame.cuts.negligible(frame.link, overlap, by, deepest) {
            return 0.0;
        }
        let moved = contact.onset + by;
        if moved.is_nan() || moved > frame.h {
            self.pending.diverged = true;
            return 0.0;
        }
        (contact.onset, contact.steps[0]) = (moved, by.abs());
        self.pending.search |= contact.onset > contact.release;
        by.abs()
    }

    /// As [`shift_onset`](Self::shift_onset) for a release, in the window or after it.
    #[inline(always)]
    fn shift_release(&mut self, frame: &Frame<'_, M, S>, c: usize, (overlap, slope): (f64, f64)) -> f64 {
        let h = frame.h;
        let contact = &mut self.contacts.found[c];
        if contact.release == f64::INFINITY {
            self.pending.search |= overlap < -self.initial.band;
            return 0.0;
        }
        let (inside, ahead) = (contact.release <= h, contact.release - h);
        if inside && slope < 0.0 {
            contact.slopes[1] = slope;
        }
        let by = if inside {
            // A release does not move before the window, where the overlap is already known.
            not_before(contact.release, -overlap / contact.slopes[1])
        } else if ahead < 0.1 * h {
            -overlap / contact.slopes[1] - ahead
        } else {
            (self.prediction.at_end - overlap) / contact.slopes[1]
        };
        // A force that jumps at its end as one that jumps at its onset.
        let rounding =
            frame.link.law.pulls && inside && overlap.abs() <= self.initial.band && by.abs() >= 0.5 * contact.steps[1];
        // A release after the window must be known the better the nearer it is.
        let deepest = frame.link.lossy().then_some(self.sweeps.largest);
        if rounding
            || by.abs() <= 0.01 * ahead
            || frame.cuts.negligible(frame.link, contact.slopes[1] * by, by, deepest)
        {
            return 0.0;
        }
        if by.is_nan() {
            self.pending.diverged = true;
            return 0.0;
        }
        self.prediction.at_end = overlap;
        (contact.release, contact.steps[1]) = (contact.release + by, by.abs());
        self.pending.search |= contact.onset > contact.release || inside != (contact.release <= h);
        by.abs()
    }
}
