//! A bond in a window: its contacts, their panels, and one sweep over them.

use super::{
    detect::Crossing,
    layout::Cuts,
    panel::{Frame, along, dot},
    panels::Panels,
    sites::Free,
    system::Path,
};
use crate::law::ContactLaw;

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
    pub(super) fn new(onset: f64, release: f64, slopes: [f64; 2]) -> Self {
        Self { onset, release, slopes, panels: (0, 0) }
    }

    /// The contact of a bond that is closed when the run begins.
    pub(crate) fn from_the_start() -> Self {
        Self::new(f64::NEG_INFINITY, f64::INFINITY, [0.0; 2])
    }

    /// Whether it begins and whether it ends inside the window.
    pub(super) fn events(&self, h: f64) -> [bool; 2] {
        [self.onset >= 0.0, self.release <= h]
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
    pub(super) assumed: Vec<Contact>,
    pub(crate) panels: Panels<M>,
    /// The contact that it is in when the window begins.
    pub(crate) ongoing: Option<Contact>,
    /// The largest `f'(g) h^2`, and the largest overlap at a node.
    pub(crate) stiffness: f64,
    largest: f64,
    /// What the last sweep changed of an impulse.
    pub(crate) change: f64,
    /// Sweeps since panels were laid out, here or where the change came from.
    pub(crate) age: u32,
    /// Overlap at the end of the window, as last used to look ahead.
    pub(super) at_end: f64,
    /// See [`Search::slack`].
    pub(crate) slack: f64,
    /// How far the force is from the prediction.
    pub(crate) surprise: f64,
    /// Last terms of its series, in units of those allowed.
    pub(crate) tail: f64,
    pub(crate) stale: bool,
    pub(crate) dirty: bool,
    pub(crate) suspicious: bool,
    /// Every panel is halved so many times in its variable.
    pub(crate) halvings: u32,
    pub(super) crossings: Vec<Crossing>,
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
pub(super) fn ramps<const M: usize>(frame: &Frame<'_, M>, t: f64, cos: f64, sin: f64) -> (f64, f64) {
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

/// Contacts of a bond in one window that are foreseen; more cost an allocation.
const CONTACTS: usize = 4;

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
            change: 0.0,
            age: 0,
            slack: 0.0,
            surprise: 0.0,
            tail: 0.0,
            stale: false,
            dirty: false,
            suspicious: false,
            halvings: 0,
            crossings: Vec::with_capacity(2 * CONTACTS),
        }
    }

    /// Takes the linear path of a new window.
    pub(crate) fn begin(&mut self, frame: &Frame<'_, M>, law: &ContactLaw<f64>, free: Free) {
        let Free { path, band } = free;
        (self.path, self.band) = (path, band);
        self.overlap = [path[0] + path[2], path[1] + frame.omega * path[3]];
        self.force = [0.0; 2];
        if self.overlap[0] > 0.0 {
            let rate = law.stiffness(self.overlap[0]) * self.overlap[1];
            // Right after an onset under alpha < 1 the force has no rate to speak of.
            self.force = [law.force(self.overlap[0]), if law.alpha() < 1.0 { 0.0 } else { rate }];
        }
        self.contacts.clear();
        self.panels.clear();
        (self.surprise, self.suspicious, self.stale, self.dirty, self.halvings) = (0.0, false, false, false, 0);
        (self.stiffness, self.largest) = (0.0, 0.0);
    }

    /// The contact that outlasts the window, in the time of the next one.
    pub(crate) fn outlasting(&self, h: f64) -> Option<Contact> {
        let contact = self.contacts.last().filter(|contact| contact.release > h)?;
        Some(Contact { onset: contact.onset - h, release: f64::INFINITY, ..*contact })
    }

    /// The first forces, from the overlaps that the forces at the start of the window predict.
    #[inline(always)]
    pub(crate) fn start(&mut self, frame: &Frame<'_, M>, law: &ContactLaw<f64>, left: Beside<M>, right: Beside<M>) {
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

    /// One sweep: overlaps from all forces, forces from the overlaps, and where contacts begin and end. If panels have been laid out since the
    /// last one, those before them are `old`.
    #[inline(always)]
    pub(crate) fn sweep(
        &mut self,
        frame: &Frame<'_, M>,
        law: &ContactLaw<f64>,
        beside: [Beside<M>; 2],
        cuts: Cuts,
        old: Option<&Panels<M>>,
    ) -> Change {
        let anew = old.is_some();
        let panels = self.panels.len as u64;
        let mut change = Change { work: panels * if anew { LAYOUT + SWEEP } else { SWEEP }, ..Change::default() };
        let total = old.map_or(self.panels.total, |old| old.total);
        let mut before = [0.0; 4];
        let mut largest = 0.0;
        for c in 0..self.contacts.len() {
            let (first, last) = self.contacts[c].panels;
            for k in first..last {
                let panel = &self.panels.list[k];
                let at = (&panel.tau, &panel.cos, &panel.sin);
                let mut g = [0.0; M];
                if let Some(old) = old {
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
                if let Some(bond) = beside[0] {
                    change.work += VIEW * bond.panels.act(panel, 0, &mut g);
                }
                if let Some(bond) = beside[1] {
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
                    let slope = panel.chord(&g, 0, 1..M);
                    change.moved = change.moved.max(self.shift_onset(c, (at_start, slope), law, cuts));
                }
                if k + 1 == last {
                    let panel = &self.panels.list[k];
                    let at_end = dot(&frame.rule.ends[1], &g);
                    let slope = panel.chord(&g, M - 1, (0..M - 1).rev());
                    change.moved = change.moved.max(self.shift_release(c, (at_end, slope), frame.h, law, cuts));
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
        self.age = if law.alpha() < 1.0 { 1 } else { self.age + 1 };
        self.panels.total = before;
        self.stale |= change.moved > 0.0;
        change
    }

    /// Moves an onset by Newton's method; returns by how much, zero if that is too little to matter.
    #[inline(always)]
    fn shift_onset(&mut self, c: usize, (overlap, slope): (f64, f64), law: &ContactLaw<f64>, cuts: Cuts) -> f64 {
        let contact = &mut self.contacts[c];
        if contact.onset < 0.0 {
            return 0.0;
        }
        if slope > 0.0 {
            contact.slopes[0] = slope;
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
    fn shift_release(
        &mut self,
        c: usize,
        (overlap, slope): (f64, f64),
        h: f64,
        law: &ContactLaw<f64>,
        cuts: Cuts,
    ) -> f64 {
        let contact = &mut self.contacts[c];
        if contact.release == f64::INFINITY {
            self.suspicious |= overlap < -self.band;
            return 0.0;
        }
        let (inside, ahead) = (contact.release <= h, contact.release - h);
        if inside && slope < 0.0 {
            contact.slopes[1] = slope;
        }
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
