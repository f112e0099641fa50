//! Cuts contacts into panels.

use super::{
    bond::{Beside, Bond, Contact, known},
    chain::beside,
    detect::sort_by_time,
    kernels::apart,
    panel::{Frame, Origin},
    panels::Panels,
};
use crate::kernel;

/// Most cuts of a contact in one window; further ones are left out. Chosen: bonds that dissipate
/// see the contacts of six bonds.
const CUTS: usize = 16;

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

/// Panels are cut at the events of so many bonds on either side where contacts dissipate, see
/// [`look_beyond`]. Struck chains of beads that touch miss 1e-12 by 20 with 1, by 11 with 2, and
/// keep it with 3.
const FAR: usize = 3;

/// Lists the contacts beyond the neighbours of a bond at whose ends its panels are cut too, for
/// contacts that dissipate.
///
/// A force that begins with the power `p` of time, 1/2 or 0, adds the power `p + 1` to the rate of
/// the next overlap and, by its resistance, to the next force: one power more from bond to bond.
/// Elastic contacts have two powers more, and begin with 3/2.
pub(super) fn look_beyond<const M: usize, const S: usize>(bonds: &mut [Bond<M, S>], b: usize, ring: bool) {
    let mut found = std::mem::take(&mut bonds[b].contacts.beyond);
    found.clear();
    for side in [0, 1] {
        let next = |b: usize| beside(b, bonds.len(), ring)[side];
        let mut at = next(b);
        for _ in 1..FAR {
            at = at.and_then(next);
            let Some(bond) = at.map(|at| &bonds[at]) else { break };
            found.extend(bond.contacts.found.iter().map(|&contact| (contact, bond.singular_after())));
        }
    }
    bonds[b].contacts.beyond = found;
}
