//! A contact that has not ended.

use super::{Contact, FAINT, ROUNDING, STEEP, TOUCH};
use hertzchain_integrators::events::Curve;

/// A time, and the rate of the overlap at that time.
type Instant = (f64, f64);

/// The force in a stretch of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Push {
    /// `int f dt`.
    pub(super) impulse: f64,
    /// The last time at which it pushes, of a contact that dissipates.
    pub(super) last: Option<f64>,
    /// Time and value of the largest force.
    pub(super) peak: (f64, f64),
}

impl Push {
    /// The push of two stretches, `later` after `self`.
    fn and(self, later: Self) -> Self {
        Self {
            impulse: self.impulse + later.impulse,
            last: later.last.or(self.last),
            peak: if later.peak.1 > self.peak.1 { later.peak } else { self.peak },
        }
    }
}

/// A contact under way, with the data that give its onset once its largest overlap is known.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pending {
    pub(super) bond: usize,
    /// The zero of the overlap from which it came; `None` if it was there at the start of the run.
    began: Option<Instant>,
    push: Push,
    /// Time and value of the largest overlap so far.
    largest: (f64, f64),
    /// The stretches in which the overlap reached new largest values, from [`TOUCH`] of its largest
    /// value on.
    rise: Vec<Curve>,
    lull: Option<Lull>,
    /// Whether this leg of the run has reported it.
    pub(super) seen: bool,
}

/// The state of a contact whose overlap has fallen below [`TOUCH`] of its largest value.
#[derive(Clone, Debug, PartialEq)]
struct Lull {
    /// When it fell below, with its rate.
    from: Instant,
    /// Time, overlap and rate at the end of the last stretch.
    end: [f64; 3],
    /// Its least value since.
    least: f64,
    /// The overlap after the least value: the next contact, if it becomes large enough.
    next: Box<Pending>,
}

/// Whether an overlap that has the value `level` at `t` comes through its zero, on either side: the
/// rate there is at least [`STEEP`] of the mean rate between the two.
fn through(zero: Instant, t: f64, level: f64) -> bool {
    zero.1 * (t - zero.0) >= STEEP * level
}

impl Pending {
    /// A contact of a bond, with the zero from which it came.
    pub(super) fn new(bond: usize, began: Option<Instant>) -> Self {
        let largest = (began.map_or(0.0, |zero| zero.0), 0.0);
        Self { bond, began, push: Push::default(), largest, rise: Vec::new(), lull: None, seen: true }
    }

    /// The largest overlap and the largest force that the next stretch may exceed.
    pub(super) fn known(&self) -> [f64; 2] {
        let Self { largest, push, .. } = self.lull.as_ref().map_or(self, |lull| &lull.next);
        [largest.1, push.peak.1]
    }

    /// The largest overlap with a stretch that has this one.
    pub(super) fn largest_with(&self, overlap: f64) -> f64 {
        self.largest.1.max(self.known()[0]).max(overlap)
    }

    /// Becomes the contact that may follow the least value of a stretch. The memory is kept: a lull
    /// may last for thousands of stretches.
    fn rise_after(&mut self, curve: &Curve) {
        let (mut rise, least) = (std::mem::take(&mut self.rise), curve.least());
        rise.clear();
        *self = Self { largest: least, rise, ..Self::new(self.bond, Some((least.0, 0.0))) };
    }

    /// Sets the zero at which the contact began, unless one with a speed is known.
    pub(super) fn begin(&mut self, zero: Instant) {
        if self.began.is_none_or(|(_, rate)| rate == 0.0) {
            self.began = Some(zero);
        }
    }

    /// Takes a time and the force there.
    pub(super) fn jump(&mut self, peak: Instant) {
        self.push = self.push.and(Push { peak, ..Push::default() });
    }

    /// Takes the next stretch of the overlap, the push in it, time and value of its largest
    /// overlap, and the force as a function of the overlap, for its peak; zero of a contact that
    /// dissipates, whose push has the peak. Returns the contact under way if it turns out to have
    /// ended; the next one then takes its place.
    pub(super) fn press(
        &mut self,
        curve: &Curve,
        (push, most): (Push, Instant),
        elastic: &dyn Fn(f64) -> f64,
    ) -> Option<Contact> {
        self.seen = true;
        // The rate of an overlap that is a rounding error is not known, nor whether it pushes.
        let push = Push { last: push.last.filter(|_| curve.range().1 > ROUNDING * self.largest.1), ..push };
        let Some(lull) = &mut self.lull else {
            self.grow(curve, (push, most), elastic);
            self.fall(curve);
            return None;
        };
        let least = curve.range().0;
        lull.end = curve.end();
        if least < lull.least {
            lull.least = least;
            let before = lull.next.push;
            lull.next.rise_after(curve);
            // The push is that of the side on which the overlap is larger.
            if curve.end()[1] > curve.values()[0] {
                lull.next.grow(curve, (push, most), elastic);
                self.push = self.push.and(before);
            } else {
                self.push = self.push.and(before.and(push));
            }
        } else {
            lull.next.grow(curve, (push, most), elastic);
        }
        let Some(lull) = &mut self.lull else { return None };
        let (largest, second) = (self.largest.1, lull.next.largest.1);
        let deep = |largest: f64| lull.least < FAINT * largest;
        if deep(largest) && deep(second) && second > ROUNDING * largest {
            let next = lull.next.as_ref().clone();
            let over = std::mem::replace(self, next).without_next();
            self.fall(curve);
            return Some(over.finish(None));
        }
        let resumes = !deep(largest) && second > TOUCH * largest;
        if resumes || curve.falls_to(TOUCH * largest).is_some() {
            // The rise in between is a part of this contact.
            self.push = self.push.and(lull.next.push);
            if second > largest {
                (self.largest, self.rise) = (lull.next.largest, std::mem::take(&mut lull.next.rise));
            }
            self.lull = None;
            self.fall(curve);
        }
        None
    }

    /// Adds the push of a stretch, and keeps the stretch if the overlap reaches a new largest
    /// value in it.
    fn grow(&mut self, curve: &Curve, (push, largest): (Push, Instant), elastic: &dyn Fn(f64) -> f64) {
        self.push = self.push.and(push);
        if largest.1 > self.largest.1 {
            self.largest = largest;
            self.jump((largest.0, elastic(largest.1)));
            if self.began.is_some() {
                let level = TOUCH * largest.1;
                let early = self.rise.iter().take_while(|curve| curve.range().1 < level).count();
                self.rise.drain(..early);
                self.rise.push(*curve);
            }
        }
    }

    /// Begins a lull if a stretch ends below [`TOUCH`] of the largest overlap.
    fn fall(&mut self, curve: &Curve) {
        if let Some(from) = curve.falls_to(TOUCH * self.largest.1) {
            let (least, mut next) = (curve.range().0, Box::new(Self::new(self.bond, None)));
            next.rise_after(curve);
            self.lull = Some(Lull { from, end: curve.end(), least, next });
        }
    }

    /// The contact without the rise after its lull.
    fn without_next(mut self) -> Self {
        if let Some(lull) = &mut self.lull {
            *lull.next = Self::new(self.bond, None);
            // The overlap then counts as one that stays below.
            (lull.end[1], lull.end[2]) = (0.0, 0.0);
        }
        self
    }

    /// The contact as a record; `zero` is the zero of the overlap at which it ended, `None` if it
    /// has not ended there.
    pub(super) fn finish(&self, zero: Option<Instant>) -> Contact {
        let level = TOUCH * self.largest.1;
        let onset = self.began.map(|zero| {
            let pressed = self.rise.iter().find_map(|curve| curve.rises_to(level, zero.0));
            match pressed {
                Some((t, rate)) if !through(zero, t, level) => [t, rate, level],
                _ => [zero.0, zero.1, 0.0],
            }
        });
        let release = match (&self.lull, zero) {
            (Some(Lull { from, .. }), Some(zero)) if !through(zero, from.0, level) => Some([from.0, from.1, level]),
            (_, Some(zero)) => Some([zero.0, zero.1, 0.0]),
            (Some(lull), None) => lull.faded(level).then_some([lull.from.0, lull.from.1, level]),
            (None, None) => None,
        };
        let start = onset.map_or(f64::NEG_INFINITY, |[t, ..]| t);
        // The events of a contact that is a rounding error may be in any order.
        let end = release.map(|[t, ..]| t.max(start));
        let push = self.lull.as_ref().map_or(self.push, |lull| self.push.and(lull.next.push));
        Contact {
            bond: self.bond,
            onset: onset.map(|[t, ..]| t),
            release: end,
            approach: onset.map(|[_, rate, _]| rate),
            separation: release.map(|[_, rate, _]| -rate),
            largest_overlap: self.largest.1,
            impulse: push.impulse,
            t_largest: self.largest.0,
            onset_overlap: onset.map(|[.., overlap]| overlap),
            release_overlap: release.map(|[.., overlap]| overlap),
            force_end: end.map(|t| push.last.map_or(t, |last| last.min(t))),
            peak_force: push.peak.1,
            t_peak: push.peak.0,
        }
    }

    /// Appends the contact as numbers.
    pub(super) fn store(&self, out: &mut Vec<f64>) {
        let began = self.began.unwrap_or((f64::NAN, f64::NAN));
        let Push { impulse, last, peak } = self.push;
        out.extend([self.bond as f64, began.0, began.1, impulse, last.unwrap_or(f64::NAN), peak.0, peak.1]);
        out.extend([self.largest.0, self.largest.1]);
        out.push(self.rise.len() as f64);
        out.extend(self.rise.iter().flat_map(Curve::numbers));
        out.push(f64::from(u8::from(self.lull.is_some())));
        if let Some(Lull { from, end, least, next }) = &self.lull {
            out.extend([from.0, from.1, end[0], end[1], end[2], *least]);
            next.store(out);
        }
    }

    /// Reads the numbers that [`store`](Self::store) has written; `None` for numbers that it does
    /// not write. `with_lull`: whether the contact may have a lull.
    pub(super) fn read(numbers: &mut impl Iterator<Item = f64>, with_lull: bool) -> Option<Self> {
        let count = |number: f64| (number.fract() == 0.0 && (0.0..1e9).contains(&number)).then_some(number as usize);
        let finite = |number: f64| number.is_finite().then_some(number);
        let mut next = || numbers.next();
        let bond = count(next()?)?;
        let began = (next()?, next()?);
        let began = if began.0.is_nan() { None } else { Some((finite(began.0)?, finite(began.1)?)) };
        let impulse = finite(next()?)?;
        let last = next()?;
        let last = if last.is_nan() { None } else { Some(finite(last)?) };
        let push = Push { impulse, last, peak: (finite(next()?)?, finite(next()?)?) };
        let largest = (finite(next()?)?, finite(next()?)?);
        let rise = (0..count(next()?)?).map(|_| {
            let mut curve = [0.0; Curve::NUMBERS];
            for number in &mut curve {
                *number = next()?;
            }
            Curve::of_numbers(&curve)
        });
        let rise: Vec<Curve> = rise.collect::<Option<_>>()?;
        let lull = match (count(next()?)?, with_lull) {
            (0, _) => None,
            (1, true) => {
                let [t, rate, end @ .., least] = [next()?, next()?, next()?, next()?, next()?, next()?];
                let sound = [t, rate, least].iter().chain(&end).all(|number| number.is_finite());
                let next = sound.then(|| Self::read(numbers, false))??;
                Some(Lull { from: (t, rate), end, least, next: Box::new(next) })
            }
            _ => return None,
        };
        Some(Self { bond, began, push, largest, rise, lull, seen: false })
    }
}

impl Lull {
    /// Whether the overlap has stayed below `level`, and is not about to come through zero.
    fn faded(&self, level: f64) -> bool {
        let [t, overlap, rate] = self.end;
        overlap < level && !(rate < 0.0 && through((t - overlap / rate, rate), self.from.0, level))
    }
}
