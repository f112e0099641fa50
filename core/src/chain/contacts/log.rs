//! The listener that turns events into contacts.

use super::{
    super::{Chain, gauss},
    Contact, FAINT, Overlaps, ROUNDING, STEEP, TOUCH,
    impulse::Quadrature,
    in_order,
    pending::{Pending, Push},
};
use crate::numerics::{golden, largest_by};
use hertzchain_integrators::{
    Event, EventFunctions, Stepper,
    collocation::Piece,
    events::{Curve, Listener, Part, bracketed},
};
use std::{convert::Infallible, ops::ControlFlow};

/// A maximum of the polynomial of a step is made exact if it is above this share of the largest
/// overlap so far. Chosen.
const NEAR: f64 = 1.0 - 1e-3;

/// The contacts of a run so far: those that have ended, and those under way, with the data that a
/// later leg of the run needs to continue them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Contacts that have ended, in the order of their ends.
    pub ended: Vec<Contact>,
    open: Vec<Pending>,
}

impl Contacts {
    /// Those that have ended, then those under way as far as they have come.
    pub fn all(&self) -> impl Iterator<Item = Contact> {
        self.ended.iter().copied().chain(self.open.iter().map(|contact| contact.finish(None)))
    }

    /// All contacts in the order of their onsets; those without an onset come first, by bond.
    /// Contacts that are rounding errors in comparison with the largest one are left out, and those
    /// with next to no overlap and impulse.
    pub fn list(&self) -> Vec<Contact> {
        let all: Vec<Contact> = self.all().collect();
        let largest = all.iter().fold(0.0f64, |largest, contact| largest.max(contact.largest_overlap));
        let speeds = all.iter().flat_map(|contact| [contact.approach, contact.separation]).flatten();
        let fastest = speeds.fold(0.0f64, f64::max);
        let hardest = all.iter().fold(0.0f64, |hardest, contact| hardest.max(contact.impulse));
        let faint = |contact: &Contact| {
            let Contact { onset, release, approach, largest_overlap, impulse, t_largest, .. } = *contact;
            let lasts = t_largest - onset.unwrap_or(f64::NEG_INFINITY);
            let drifts = approach.is_some_and(|rate| rate <= 0.0 || rate * lasts >= STEEP * largest_overlap);
            let light = if release.is_some() {
                impulse <= FAINT * hardest
            } else {
                drifts && largest_overlap <= FAINT * fastest * lasts
            };
            light && largest_overlap <= FAINT * largest
        };
        let kept = |contact: &Contact| contact.largest_overlap > ROUNDING * largest && !faint(contact);
        in_order(all.into_iter().filter(kept).collect())
    }

    /// The contacts that have not ended, as numbers.
    pub fn store_open(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.open.iter().for_each(|contact| contact.store(&mut numbers));
        numbers
    }

    /// The contacts of a chain from those that have `ended`, and from the numbers of
    /// [`store_open`](Self::store_open); `None` for numbers that are not those of contacts.
    pub fn restore(chain: &Chain<f64>, ended: Vec<Contact>, open: &[f64]) -> Option<Self> {
        let (mut numbers, touching) = (open.iter().copied().peekable(), chain.touching());
        let mut contacts = Self { ended, ..Self::default() };
        while numbers.peek().is_some() {
            let contact = Pending::read(&mut numbers, true).filter(|contact| touching.contains(&contact.bond))?;
            contacts.open.push(contact);
        }
        Some(contacts)
    }
}

/// The listener that turns events into contacts.
#[derive(Clone, Debug)]
pub struct ContactLog {
    chain: Chain<f64>,
    overlaps: Overlaps<f64>,
    quadrature: Quadrature,
    /// A state of the run.
    y: Vec<f64>,
    /// The contact under way in each bond that can touch.
    open: Vec<Option<Pending>>,
    ended: Vec<Contact>,
    /// Start time of the leg; `None` for the first leg of a run.
    leg: Option<f64>,
}

impl ContactLog {
    /// An empty log of a chain.
    pub fn new(chain: Chain<f64>) -> Self {
        let quadrature = Quadrature::new(chain.powers_at_events(gauss::ORDER).1, chain.dissipative_contacts());
        let overlaps = Overlaps::new(chain.clone());
        let count = overlaps.count();
        Self { chain, overlaps, quadrature, y: Vec::new(), open: vec![None; count], ended: Vec::new(), leg: None }
    }

    /// The log of a leg that starts at time `t`; `contacts` are those of the legs before. Contacts
    /// that are closed at the start of the first leg have no onset; those that are closed at the
    /// start of a later leg had theirs in an earlier leg.
    #[must_use]
    pub fn go_on(mut self, contacts: Contacts, t: f64) -> Self {
        if t == 0.0 {
            return self;
        }
        let first = self.overlaps.bond(0);
        for mut contact in contacts.open {
            contact.seen = false;
            let index = contact.bond - first;
            self.open[index] = Some(contact);
        }
        (self.ended, self.leg) = (contacts.ended, Some(t));
        self
    }

    /// The contacts that have ended, in the order of their ends.
    pub fn ended(&self) -> &[Contact] {
        &self.ended
    }

    /// Takes the piece of a contact that a method reports for a step from `start` to `end`; no
    /// search for events is needed.
    pub fn take(&mut self, piece: &Piece, (start, end): (f64, f64)) {
        let at = |(t, rate): (f64, f64)| ((start + t).max(start).min(end), rate);
        if let Some(onset) = piece.onset {
            self.close(piece.bond, at(onset));
        }
        if let Some(curve) = &piece.curve {
            let curve = curve.later(start, (start, end));
            let [largest, peak] = [piece.largest, piece.peak].map(at);
            let dissipates = self.chain.dissipates(self.overlaps.bond(piece.bond));
            let last = (dissipates && piece.impulse != 0.0).then(|| curve.end()[0]);
            self.press(piece.bond, &curve, Push { impulse: piece.impulse, last, peak }, largest);
        }
        if let Some(release) = piece.release {
            self.part(piece.bond, at(release));
        }
    }

    /// The contacts at the end of a leg.
    pub fn into_contacts(mut self) -> Contacts {
        // The overlap of a contact that only the leg before has seen is zero between the two legs,
        // but for rounding errors: it ends there with no speed.
        if let Some(t) = self.leg {
            for index in 0..self.open.len() {
                if self.open[index].as_ref().is_some_and(|contact| !contact.seen) {
                    self.part(index, (t, 0.0));
                }
            }
        }
        Contacts { ended: self.ended, open: self.open.into_iter().flatten().collect() }
    }

    /// A bond closes at `zero`. If a step before has reported its contact without an event, this is
    /// the contact's onset.
    fn close(&mut self, index: usize, zero: (f64, f64)) {
        if !self.overlaps.has_contact(index) {
            return;
        }
        let bond = self.overlaps.bond(index);
        if self.open[index].as_ref().is_some_and(|contact| !contact.seen)
            && let Some(t) = self.leg
        {
            self.part(index, (t, 0.0));
        }
        let contact = self.open[index].get_or_insert_with(|| Pending::new(bond, Some(zero)));
        contact.begin(zero);
        // To this value the force of a dashpot jumps.
        contact.jump((zero.0, self.chain.bond_force(bond, f64::MIN_POSITIVE, zero.1)));
    }

    /// Adds a stretch of overlap, the push in it, and time and value of its largest overlap to the
    /// contact of a closed bond. A stretch in which the overlap nearly vanishes is two.
    fn press(&mut self, index: usize, curve: &Curve, push: Push, largest: (f64, f64)) {
        if !self.overlaps.has_contact(index) {
            return;
        }
        // A contact without an event at its start was there at the start of the run, or began
        // between two legs.
        let (bond, leg) = (self.overlaps.bond(index), self.leg);
        let contact = self.open[index].get_or_insert_with(|| Pending::new(bond, leg.map(|t| (t, 0.0))));
        let (chain, dissipates) = (&self.chain, self.chain.dissipates(bond));
        let force = |g: f64| chain.bond_force(bond, g, 0.0);
        if let Some(halves) = curve.cut_below(TOUCH * contact.largest_with(largest.1)) {
            let impulses = halves.map(|half| half.integral(force));
            for (half, impulse) in halves.iter().zip(impulses) {
                let here = |t: f64| half.start() <= t && t <= half.end()[0];
                let push = Push {
                    impulse: push.impulse * impulse / (impulses[0] + impulses[1]).max(f64::MIN_POSITIVE),
                    last: push.last.filter(|t| here(*t)),
                    peak: if here(push.peak.0) { push.peak } else { Default::default() },
                };
                self.press(index, half, push, if here(largest.0) { largest } else { half.largest() });
            }
            return;
        }
        let elastic = |g: f64| if dissipates { 0.0 } else { force(g) };
        self.ended.extend(contact.press(curve, (push, largest), &elastic));
    }

    /// A bond opens at `zero`: its contact ends.
    fn part(&mut self, index: usize, zero: (f64, f64)) {
        if let Some(contact) = self.open[index].take() {
            self.ended.push(contact.finish(Some(zero)));
        }
    }
}

/// Time of the largest force on a stretch of overlap, if it may be larger than the force that is
/// `known`: that of golden sections about the largest of nine values.
fn peak(curve: &Curve, known: f64, force: impl Fn(f64, f64) -> f64) -> Option<f64> {
    let at = |x: f64| {
        let [_, g, rate] = curve.at(x);
        force(g, rate)
    };
    let x = largest_by((0..=8).map(|k| f64::from(k) / 8.0), |&x| at(x)).filter(|&x| at(x) >= 0.9 * known)?;
    let around = [(x - 0.125).max(0.0), (x + 0.125).min(1.0)];
    let Ok((inside, _)) = golden(around, |apart| apart > 1e-8, |x| Ok::<_, Infallible>(at(x)), |force| *force);
    Some(curve.at(if at(inside) > at(x) { inside } else { x })[0])
}

/// The last point of `[0, 1]` at which something holds, where it has held for an eighth or longer.
fn last(holds: impl Fn(f64) -> bool) -> Option<f64> {
    let k = (0..=8).rev().find(|&k| holds(f64::from(k) / 8.0))?;
    let [from, to] = [k, 8.min(k + 1)].map(|k| f64::from(k) / 8.0);
    let sign = |x: f64| if holds(x) { 1.0 } else { -1.0 };
    Some(bracketed(sign, (from, 1.0), (to, sign(to))))
}

impl Listener<f64> for ContactLog {
    fn positive(&mut self, part: &Part<f64>, run: &mut dyn Stepper<f64>) {
        let bond = self.overlaps.bond(part.index);
        let force = |g: f64, rate: f64| self.chain.bond_force(bond, g, rate);
        let impulse = self.quadrature.integral(part, force);
        let (curve, known) = (part.curve(), self.open[part.index].as_ref().map_or([0.0; 2], Pending::known));
        self.y.resize(run.dim(), 0.0);
        let mut at = |t: f64| {
            run.sample(t, &mut self.y);
            self.overlaps.of(bond, &self.y)
        };
        let mut push = Push { impulse, ..Push::default() };
        if self.chain.dissipates(bond) {
            let pushes = |x: f64| {
                let [_, g, rate] = curve.at(x);
                force(g, rate) != 0.0
            };
            push.last = last(pushes).map(|x| curve.at(x)[0]);
            // At the onset the force of a dashpot jumps to this value.
            let closed = |g: f64, rate: f64| force(g.max(f64::MIN_POSITIVE), rate);
            // The rate by the state: that of the polynomial over a tiny step is a rounding error.
            if let Some(t) = peak(&curve, known[1], closed) {
                let [g, rate] = at(t);
                push.peak = (t, closed(g, rate));
            }
        }
        let mut largest = curve.largest();
        if largest.1 > NEAR * known[0] && part.span.0 < largest.0 && largest.0 < part.span.1 {
            largest.1 = at(largest.0)[0];
        }
        self.press(part.index, &curve, push, largest);
    }

    fn event(&mut self, event: Event<f64>, y: &[f64]) -> ControlFlow<()> {
        let zero = (event.t, self.overlaps.of(self.overlaps.bond(event.index), y)[1]);
        if event.rising {
            self.close(event.index, zero)
        } else {
            self.part(event.index, zero)
        }
        ControlFlow::Continue(())
    }
}
