//! Cuts contacts into panels.

use super::{
    block::apart,
    bond::{Beside, Bond, Contact, known},
    panel::{Frame, Origin},
    panels::Panels,
    system::{Link, sort_by_time},
};
use crate::kernel;

/// Most cuts of a contact in one window; further ones are left out. Chosen: bonds that dissipate
/// see the contacts of six bonds.
const CUTS: usize = 16;

/// How contacts are cut into panels, and thresholds below which events and overlaps are negligible.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuts {
    /// Whether panels are also cut where a contact of a neighbour begins or ends.
    pub(crate) neighbours: bool,
    /// Shortest panel that a cut may leave, a time: a cut nearer to an end of the contact is left
    /// out.
    pub(crate) merge: f64,
    /// Largest distance from a panel to an event at which the panel's variable has its origin, in
    /// lengths of the panel.
    pub(crate) near: f64,
    /// An event is not moved if this would change the impulse of its contact by at most this change
    /// of velocity.
    pub(crate) event_impulse: f64,
    /// Overlaps of at most this value count as zero.
    pub(crate) least_overlap: f64,
    /// If an event moves by more than this time, panels of the neighbours are laid out anew.
    pub(crate) least_move_beside: f64,
}

impl Cuts {
    /// Whether the error of an event is negligible. The event is off by a time `by` and an overlap;
    /// or, where it is an event of `P`, by a time and a value of `P`, while beads overlap by at
    /// most `deepest`, see `loss.rs`.
    #[inline(always)]
    pub(super) fn negligible<const S: usize>(
        &self,
        link: &Link<S>,
        overlap: f64,
        by: f64,
        deepest: Option<f64>,
    ) -> bool {
        let impulse = if link.lossy() {
            link.law.impulse_besides(overlap.abs(), by.abs(), deepest)
        } else {
            link.elastic_force(overlap.abs()) * by.abs()
        };
        impulse * link.lightest() <= self.event_impulse
    }
}

impl<const M: usize, const S: usize> Bond<M, S> {
    /// Cuts the contacts into panels. For `S = 2` this is compiled apart from the kernels that call
    /// it; otherwise each of them would have a copy.
    #[inline(always)]
    pub(crate) fn lay_out(&mut self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2], old: &mut Panels<M, S>) {
        if const { S == 1 } {
            self.cut_all(frame, beside, old);
        } else {
            apart(kernel!(self.cut_all(frame, beside, old)));
        }
    }

    #[inline(always)]
    fn cut_all(&mut self, frame: &Frame<'_, M, S>, beside: [Beside<M, S>; 2], old: &mut Panels<M, S>) {
        std::mem::swap(&mut self.panels, old);
        self.panels.clear();
        self.panels.version = old.version + 1;
        (self.pending.layout, self.sweeps.age) = (false, 0);
        for i in 0..self.contacts.found.len() {
            let contact = self.contacts.found[i];
            let first = self.panels.len;
            // A contact that ends when the window begins has no panels, so that its end does not
            // move any more. Newton's method may have led it there from a contact that goes on.
            if contact.release > contact.onset.max(0.0) {
                self.cut(frame, contact, beside);
            } else {
                self.pending.search = true;
            }
            self.contacts.found[i].panels = (first, self.panels.len);
        }
        for panel in &mut self.panels.list[..self.panels.len] {
            panel.place(frame);
            if let Some(known) = known::<S>(&self.known) {
                panel.known = known.at(&panel.tau);
            }
            if S != 1 && frame.link.rated {
                panel.place_rates(frame, self.known.as_ref());
            } else {
                panel.rates = None;
            }
        }
    }

    #[inline(always)]
    fn cut(&mut self, frame: &Frame<'_, M, S>, contact: Contact, beside: [Beside<M, S>; 2]) {
        let cuts = frame.cuts;
        let (start, end) = (contact.onset.max(0.0), contact.release.min(frame.h));
        // The latest onset before a panel and the earliest release after it, of the bond and its
        // neighbours.
        let (mut behind, mut ahead) = (contact.onset, contact.release + self.singular_after());
        let mut points = [(0.0, f64::INFINITY); CUTS];
        let mut count = 0;
        let mut see = |c: &Contact, after: f64| {
            if c.onset <= start + cuts.merge {
                behind = behind.max(c.onset.min(start));
            } else if c.onset < end - cuts.merge && count < points.len() {
                points[count] = (c.onset, f64::INFINITY);
                count += 1;
            }
            if c.release >= end - cuts.merge {
                ahead = ahead.min(c.release.max(end) + after);
            } else if c.release > start + cuts.merge && count < points.len() {
                points[count] = (c.release, c.release + after);
                count += 1;
            }
        };
        if cuts.neighbours {
            for bond in beside.into_iter().flatten() {
                bond.contacts.found.iter().for_each(|c| see(c, bond.singular_after()));
            }
            self.contacts.beyond.iter().for_each(|(c, after)| see(c, *after));
        }
        let points = &mut points[..count];
        if count > 1 {
            sort_by_time(points);
        }
        let mut from = start;
        for i in 0..=count {
            let (to, origin) = if i < count { points[i] } else { (end, ahead) };
            if to > from + cuts.merge || i == count {
                let next = points[i..].iter().map(|p| p.1).find(|origin| *origin < f64::INFINITY).unwrap_or(ahead);
                self.piece(frame, (from, to), (behind, next));
                from = to;
            }
            if origin == f64::INFINITY {
                behind = to;
            }
        }
    }

    fn piece(&mut self, frame: &Frame<'_, M, S>, (from, to): (f64, f64), (onset, release): (f64, f64)) {
        let reach = frame.cuts.near * (to - from);
        let (early, late) = (frame.link.q > 1 && from - onset < reach, frame.link.q > 1 && release - to < reach);
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

    /// Lays out `2^halvings` panels from `from` to `to`, of equal lengths in their variable.
    fn halve(&mut self, frame: &Frame<'_, M, S>, from: f64, to: f64, origin: Origin) {
        let parts = 1 << self.resolution.halvings;
        let mut start = from;
        for i in 1..=parts {
            let end =
                if i == parts { to } else { origin.between(frame.link.q, from, to, f64::from(i) / f64::from(parts)) };
            self.panels.push(start, end, origin, frame.link.q);
            start = end;
        }
    }
}
