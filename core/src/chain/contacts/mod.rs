//! Contacts as events: their onset, release, largest overlap and impulse.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g_n` | overlap of bond `n`, which lies to the left of site `n` |
//! | `f_n` | contact force `(g_n)_+^alpha` |
//! | `G` | the largest overlap of a contact |
//! | onset, release | where a contact begins and ends, see [`Contact`] |
//!
//! Beads that touch at rest have no gap from which a contact could begin: ahead of a wave their
//! overlap falls like a double exponential and is zero nowhere. A zero that a method finds there
//! depends on its rounding errors or on its tolerance. Onsets and releases are therefore zeros of
//! the overlap only where it comes through zero. Elsewhere they are crossings of a share of `G`,
//! which are the same for every method that is more accurate than that share.

mod impulse;
mod log;
mod pending;

pub use log::{ContactLog, Contacts};

use super::{Chain, natural::Natural};
use hertzchain_integrators::{EventFunctions, Real};

/// Share of the largest overlap of a contact up to which its beads only touch. Chosen: errors of a
/// method, in units of that overlap, are multiplied by a thousand in the times at which beads that
/// touch begin to press.
pub const TOUCH: f64 = 1e-3;

/// An overlap comes through a zero if its rate there is at least this share of the mean rate
/// between the zero and [`TOUCH`] of its largest value. Chosen: times of such zeros are then at
/// most ten times as sensitive to errors as times at that value.
const STEEP: f64 = 0.1;

/// Contacts whose largest overlap is at most this share of the largest one in the log are rounding
/// errors, and so is a rise of an overlap without a gap: positions are rounded too, in every step,
/// and may be larger than overlaps. Chosen.
const ROUNDING: f64 = 1024.0 * f64::EPSILON;

/// Contacts whose overlap is at most this share of the largest one in the log are left out if their
/// impulse is at most this share of the largest one, too; or, if they have not ended, if their
/// beads drift together at most at this share of the largest speed. An overlap that falls to this
/// share of its largest value and rises again makes two contacts. Chosen: at a tolerance of 1e-6 a
/// method does not know whether such beads part or meet.
const FAINT: f64 = 1e-5;

/// The overlaps of all bonds that can close, as event functions; and, if they are asked for, a
/// function for each bond that dissipates, which is positive where the contact pushes, and the rate
/// of the overlap where the force has a kink at zero.
#[derive(Clone, Debug)]
pub struct Overlaps<R> {
    chain: Chain<R>,
    /// Bonds that dissipate, if their functions are asked for, with factors that make these
    /// lengths; and whether the function is the rate.
    lossy: Vec<(usize, R, bool)>,
    told: bool,
}

impl<R: Real> Overlaps<R> {
    /// The overlaps of a chain.
    pub fn new(chain: Chain<R>) -> Self {
        Self { chain, lossy: Vec::new(), told: false }
    }

    /// All events of a chain, for methods that stop at each: contacts close or open, and contacts
    /// that dissipate begin or cease to push while beads overlap. `told`: see
    /// [`EventFunctions::told`].
    pub(crate) fn with_pushes(chain: Chain<R>, natural: &Natural<R>, told: bool) -> Self {
        let laws = chain.lossy().into_iter().flat_map(|bond| Some((bond, &chain.parts()?.bonds[bond])));
        let pushes = laws.clone().map(|(bond, law)| (bond, natural.per_push(law), false));
        let kinks = laws.filter(|(_, law)| law.kink().is_some()).map(|(bond, _)| (bond, R::of(natural.time), true));
        Self { lossy: pushes.chain(kinks).collect(), told, chain }
    }

    /// The bond of function `index`. The outer bonds of a free chain never close and have no
    /// function.
    pub fn bond(&self, index: usize) -> usize {
        self.chain.touching().start + index
    }

    /// Whether the bond of function `index` has a contact. Its overlap is an event in any case.
    fn has_contact(&self, index: usize) -> bool {
        self.chain.parts().is_none_or(|parts| parts.bonds[self.bond(index)].pushes_ever())
    }

    /// The overlap of a bond and its rate.
    pub(crate) fn of(&self, bond: usize, y: &[R]) -> [R; 2] {
        let Self { chain: Chain { layout, precompression, .. }, .. } = self;
        let rest = self.chain.parts().map_or(*precompression, |parts| parts.bonds[bond].rest);
        let across = |q: &[R]| self.chain.across(bond, |i| q[i]);
        [rest + across(layout.u(y)), across(layout.u_dot(y))]
    }
}

// States may be followed by other numbers, as the columns of variations are.
impl<R: Real> EventFunctions<R> for Overlaps<R> {
    fn count(&self) -> usize {
        self.chain.touching().len() + self.lossy.len()
    }

    fn values(&self, _t: R, y: &[R], g: &mut [R]) {
        let (overlaps, pushes) = g.split_at_mut(self.chain.touching().len());
        for (overlap, bond) in overlaps.iter_mut().zip(self.chain.touching()) {
            *overlap = self.of(bond, y)[0];
        }
        let Some(parts) = self.chain.parts() else { return };
        for (value, &(bond, factor, turns)) in pushes.iter_mut().zip(&self.lossy) {
            let [overlap, rate] = self.of(bond, y);
            *value = factor * if turns { rate } else { parts.bonds[bond].pushes(overlap, rate).unwrap_or(R::zero()) };
        }
    }

    fn kinks(&self, index: usize) -> bool {
        index.checked_sub(self.chain.touching().len()).is_some_and(|k| self.lossy[k].2)
    }

    fn rates(&self, _t: R, y: &[R], dy: &[R], rates: &mut [R]) {
        let (chain, half) = (&self.chain, self.chain.layout.half());
        let (of_overlaps, pushes) = rates.split_at_mut(chain.touching().len());
        for (rate, bond) in of_overlaps.iter_mut().zip(chain.touching()) {
            *rate = self.of(bond, y)[1];
        }
        let Some(parts) = chain.parts() else { return };
        for (value, &(bond, factor, turns)) in pushes.iter_mut().zip(&self.lossy) {
            let [overlap, rate] = self.of(bond, y);
            let second = chain.across(bond, |i| dy[half + i]);
            let pushes = || parts.bonds[bond].pushes_rate(overlap, rate, second).unwrap_or(R::zero());
            *value = factor * if turns { second } else { pushes() };
        }
    }

    fn band(&self, y: &[R]) -> R {
        self.chain.dead_band(self.chain.layout.u(y).iter().copied())
    }

    fn told(&self) -> bool {
        self.told
    }
}

/// One contact of one bond, from onset to release.
///
/// With `G` the largest overlap, follow the overlap from there back to the last time `t` at which
/// it has the value [`TOUCH`]` G`, and on to its zero at `t_0`. The onset is `t_0` if the overlap
/// comes through zero: if its rate there is at least a tenth of the mean rate from `t_0` to `t`.
/// Otherwise the beads touched before they pressed, and the onset is `t`. The release is the same
/// in time reversed. An overlap that falls below [`TOUCH`]` G` and rises again makes two contacts
/// if its least value between them is below 1e-5 of the smaller of their largest ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The bond: `n` lies to the left of site `n`.
    pub bond: usize,
    /// Time of the onset; `None` if the bond was closed at the start of the run.
    pub onset: Option<f64>,
    /// Time of the release; `None` if the contact lasted to the end of the run.
    pub release: Option<f64>,
    /// `dg/dt` at the onset.
    pub approach: Option<f64>,
    /// `-dg/dt` at the release.
    pub separation: Option<f64>,
    /// The largest overlap.
    pub largest_overlap: f64,
    /// The impulse, `int f dt`, including that of beads that touch before the onset.
    pub impulse: f64,
    /// Time of the largest overlap.
    pub t_largest: f64,
    /// The overlap at the onset: zero, or [`TOUCH`] of the largest for beads that touched before.
    pub onset_overlap: Option<f64>,
    /// The overlap at the release: zero, or [`TOUCH`] of the largest for beads that touch after it.
    pub release_overlap: Option<f64>,
    /// Time at which the force ends: the release of an elastic contact, and of one that may pull. A
    /// contact that dissipates and never pulls has a force that ends while the beads still overlap.
    /// `None` without a release.
    pub force_end: Option<f64>,
    /// The largest force, `f`, dissipation included.
    pub peak_force: f64,
    /// Time of the largest force: that of the largest overlap, of an elastic contact.
    pub t_peak: f64,
}

impl Contact {
    /// Length of the array of [`numbers`](Self::numbers).
    pub const NUMBERS: usize = 13;

    /// The contact as plain numbers, in the order of the fields; NaN for `None`.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let number = |number: Option<f64>| number.unwrap_or(f64::NAN);
        [
            self.bond as f64,
            number(self.onset),
            number(self.release),
            number(self.approach),
            number(self.separation),
            self.largest_overlap,
            self.impulse,
            self.t_largest,
            number(self.onset_overlap),
            number(self.release_overlap),
            number(self.force_end),
            self.peak_force,
            self.t_peak,
        ]
    }

    /// The contact with these [`numbers`](Self::numbers); `None` if they are not those of a
    /// contact.
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Option<Self> {
        let number = |k: usize| Some(numbers[k]).filter(|number| !number.is_nan());
        let contact = Self {
            bond: numbers[0] as usize,
            onset: number(1),
            release: number(2),
            approach: number(3),
            separation: number(4),
            largest_overlap: numbers[5],
            impulse: numbers[6],
            t_largest: numbers[7],
            onset_overlap: number(8),
            release_overlap: number(9),
            force_end: number(10),
            peak_force: numbers[11],
            t_peak: numbers[12],
        };
        let sound =
            numbers[0].fract() == 0.0 && numbers[0] >= 0.0 && !numbers.iter().any(|number| number.is_infinite());
        (sound && [5, 6, 7, 11, 12].iter().all(|&k| numbers[k].is_finite())).then_some(contact)
    }
}

/// Sorts contacts by onset; those without one come first, by bond.
fn in_order(mut contacts: Vec<Contact>) -> Vec<Contact> {
    let time = |contact: &Contact| contact.onset.unwrap_or(f64::NEG_INFINITY);
    contacts.sort_by(|x, y| time(x).total_cmp(&time(y)).then(x.bond.cmp(&y.bond)));
    contacts
}
