//! Contacts as events: when they begin and end, and what they did.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g_n` | overlap of bond `n`, which lies to the left of site `n` |
//! | onset, release | `g_n` becomes positive, and ceases to be |
//! | `f_n` | contact force `(g_n)_+^alpha` |

use super::{
    Chain, ContactLaw,
    gauss::{self, gauss},
};
use hertzchain_integrators::{
    Event, EventFunctions, Real,
    collocation::Piece,
    events::{Listener, Part},
    regularised::{TimeMap, power},
};
use std::{collections::BTreeMap, ops::ControlFlow};

/// The overlaps of all bonds that can close, as event functions.
#[derive(Clone, Debug)]
pub struct Overlaps<R> {
    chain: Chain<R>,
}

impl<R: Real> Overlaps<R> {
    /// The overlaps of a chain.
    pub fn new(chain: Chain<R>) -> Self {
        Self { chain }
    }

    /// The bond that function `index` stands for: the outer bonds of a free chain never close and
    /// have none.
    pub fn bond(&self, index: usize) -> usize {
        self.chain.touching().start + index
    }
}

impl<R: Real> EventFunctions<R> for Overlaps<R> {
    fn count(&self) -> usize {
        self.chain.touching().len()
    }

    fn values(&self, _t: R, y: &[R], g: &mut [R]) {
        let u = self.chain.layout.u(y);
        self.chain.across_bonds(self.chain.precompression, |i| u[i], g);
    }

    fn rates(&self, _t: R, y: &[R], _dy: &[R], rates: &mut [R]) {
        let u_dot = self.chain.layout.u_dot(y);
        self.chain.across_bonds(R::zero(), |i| u_dot[i], rates);
    }

    fn band(&self, y: &[R]) -> R {
        self.chain.dead_band(self.chain.layout.u(y).iter().copied())
    }
}

/// One contact of one bond, from onset to release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The bond: `n` lies to the left of site `n`.
    pub bond: usize,
    /// When it began; `None` if it was there at the start.
    pub onset: Option<f64>,
    /// When it ended; `None` if it lasted to the end. A contact whose overlap fades into the dead
    /// band and stays there ended when it came there, with no speed of separation.
    pub release: Option<f64>,
    /// `dg/dt` at the onset.
    pub approach: Option<f64>,
    /// `-dg/dt` at the release.
    pub separation: Option<f64>,
    /// The largest overlap.
    pub largest_overlap: f64,
    /// The impulse, `int f dt`.
    pub impulse: f64,
}

impl Contact {
    /// How many numbers say all of it.
    pub const NUMBERS: usize = 7;

    /// Bond, onset, release, approach, separation, largest overlap and impulse; NaN for what there
    /// is not.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Self { bond, onset, release, approach, separation, largest_overlap, impulse } = *self;
        let [onset, release, approach, separation] =
            [onset, release, approach, separation].map(|number| number.unwrap_or(f64::NAN));
        [bond as f64, onset, release, approach, separation, largest_overlap, impulse]
    }

    /// The contact of these numbers; `None` if there is none.
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Option<Self> {
        let [bond, times @ .., largest_overlap, impulse] = *numbers;
        let sound = bond.fract() == 0.0 && bond >= 0.0 && largest_overlap.is_finite() && impulse.is_finite();
        let [onset, release, approach, separation] = times.map(|number| (!number.is_nan()).then_some(number));
        let finite = times.iter().all(|number| !number.is_infinite());
        let bond = bond as usize;
        (sound && finite).then_some(Self { bond, onset, release, approach, separation, largest_overlap, impulse })
    }
}

/// The contacts of two runs, of which the second goes on at time `t` where the first ended: those
/// that go on are joined. One that only the first has at `t`, or only the second, is on the surface
/// there but for rounding, and ends or begins at `t` with no speed.
pub fn join(before: Vec<Contact>, after: Vec<Contact>, t: f64) -> Vec<Contact> {
    let (mut contacts, open): (Vec<_>, Vec<_>) = before.into_iter().partition(|contact| contact.release.is_some());
    // A bond is in one contact at a time.
    let mut open: BTreeMap<usize, Contact> = open.into_iter().map(|contact| (contact.bond, contact)).collect();
    for mut contact in after {
        if contact.onset.is_none() {
            contact = match open.remove(&contact.bond) {
                Some(Contact { onset, approach, largest_overlap, impulse, .. }) => Contact {
                    onset,
                    approach,
                    largest_overlap: contact.largest_overlap.max(largest_overlap),
                    impulse: contact.impulse + impulse,
                    ..contact
                },
                None => Contact { onset: Some(t), ..contact },
            };
        }
        contacts.push(contact);
    }
    contacts.extend(open.into_values().map(|contact| Contact { release: Some(t), ..contact }));
    in_order(contacts)
}

/// By onset; those that were there at the start come first, by bond.
fn in_order(mut contacts: Vec<Contact>) -> Vec<Contact> {
    let time = |contact: &Contact| contact.onset.unwrap_or(f64::NEG_INFINITY);
    contacts.sort_by(|x, y| time(x).total_cmp(&time(y)).then(x.bond.cmp(&y.bond)));
    contacts
}

/// A part whose overlap at an end is below this share of its largest one ends with an event.
/// Chosen, not measured.
const SINGULAR: f64 = 1e-6;

/// The listener that turns events into contacts.
#[derive(Clone, Debug)]
pub struct ContactLog {
    overlaps: Overlaps<f64>,
    law: ContactLaw<f64>,
    q: u32,
    rates: Vec<f64>,
    /// The contact that each bond is in.
    open: Vec<Option<Contact>>,
    /// Since when its overlap has been in the dead band.
    faded: Vec<Option<f64>>,
    ended: Vec<Contact>,
}

impl ContactLog {
    /// An empty log of a chain.
    pub fn new(chain: Chain<f64>) -> Self {
        let (law, overlaps) = (chain.law, Overlaps::new(chain));
        let count = overlaps.count();
        let q = power(law.alpha(), gauss::ORDER);
        Self {
            overlaps,
            law,
            q,
            rates: vec![0.0; count],
            open: vec![None; count],
            faded: vec![None; count],
            ended: Vec::new(),
        }
    }

    fn begin(&self, index: usize) -> Contact {
        Contact {
            bond: self.overlaps.bond(index),
            onset: None,
            release: None,
            approach: None,
            separation: None,
            largest_overlap: 0.0,
            impulse: 0.0,
        }
    }

    /// Takes what contact collocation says of a contact in a window that began at `start`: it needs
    /// no search.
    pub fn take(&mut self, piece: &Piece, start: f64) {
        let mut contact = self.open[piece.bond].take().unwrap_or_else(|| self.begin(piece.bond));
        contact.largest_overlap = contact.largest_overlap.max(piece.largest);
        contact.impulse += piece.impulse;
        if let Some((t, rate)) = piece.onset {
            (contact.onset, contact.approach) = (Some(start + t), Some(rate));
        }
        if let Some((t, rate)) = piece.release {
            (contact.release, contact.separation) = (Some(start + t), Some(-rate));
            self.ended.push(contact);
        } else {
            self.open[piece.bond] = Some(contact);
        }
    }

    /// All contacts in the order of their onsets; those that were there at the start come first, by
    /// bond.
    pub fn contacts(self) -> Vec<Contact> {
        let mut contacts = self.ended;
        let open = self.open.into_iter().zip(self.faded);
        contacts.extend(open.filter_map(|(contact, faded)| Some(Contact { release: faded, ..contact? })));
        in_order(contacts)
    }

    /// `int (g)_+^alpha dt` over a part, in a variable in which it is smooth at an end where `g`
    /// vanishes.
    fn impulse(&self, part: &Part<f64>, largest: f64) -> f64 {
        let (polynomial, small) = (&part.polynomial, SINGULAR * largest);
        let end = |s: f64| if polynomial.at(s) <= small { self.q } else { 1 };
        let share = TimeMap::new(1.0, end(0.0), end(1.0));
        let force = |s: f64| share.rate(s) * self.law.force(polynomial.at(share.at(s)));
        let [mean] = gauss(|s| [force(s)], 0.0, 1.0);
        mean * (part.span.1 - part.span.0)
    }
}

impl Listener<f64> for ContactLog {
    fn positive(&mut self, part: &Part<f64>) {
        // A contact that was there at the start has no event that begins it.
        let mut contact = self.open[part.index].unwrap_or_else(|| self.begin(part.index));
        let largest = part.polynomial.largest();
        contact.largest_overlap = contact.largest_overlap.max(largest);
        let faded = &mut self.faded[part.index];
        *faded = if largest > part.band { None } else { faded.or(Some(part.span.0)) };
        contact.impulse += self.impulse(part, largest);
        self.open[part.index] = Some(contact);
    }

    fn event(&mut self, event: Event<f64>, y: &[f64]) -> ControlFlow<()> {
        let mut rates = std::mem::take(&mut self.rates);
        self.overlaps.rates(event.t, y, &[], &mut rates);
        let rate = rates[event.index];
        self.rates = rates;
        let mut contact = self.open[event.index].take().unwrap_or_else(|| self.begin(event.index));
        if event.rising {
            (contact.onset, contact.approach) = (Some(event.t), Some(rate));
            self.open[event.index] = Some(contact);
        } else {
            (contact.release, contact.separation) = (Some(event.t), Some(-rate));
            self.ended.push(contact);
        }
        ControlFlow::Continue(())
    }
}
