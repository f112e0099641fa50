//! A contact that has not ended.

use super::{Contact, ROUNDING, STEEP, TOUCH};
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
    pub(super) fn new(bond: usize, began: Option<Instant>) -> Self {
        let largest = (began.map_or(0.0, |zero| zero.0), 0.0);
        Self { bond, began, push: Push::default(), largest, rise: Vec::new(), lull: None, seen: true }
    }

    /// The largest force so far.
    pub(super) fn largest_force(&self) -> f64 {
        self.push.peak.1
    }

    /// Becomes the contact that may follow a stretch in which the overlap had its least value. The
    /// memory is kept: a lull may last for thousands of stretches.
    fn rise_after(&mut self, curve: &Curve) {
        let mut rise = std::mem::take(&mut self.rise);
        rise.clear();
        rise.push(*curve);
        let [t, overlap, _] = curve.end();
        *self = Self { largest: (t, overlap), rise, ..Self::new(self.bond, Some((curve.least().0, 0.0))) };
    }

    /// Sets the zero at which the contact began, unless one with a speed is known.
    pub(super) fn begin(&mut self, zero: Instant) {
        if self.began.is_none_or(|(_, rate)| rate == 0.0) {
            self.began = Some(zero);
        }
    }

    /// Takes the next stretch of the overlap and the push in it, and the force as a function of the
    /// overlap, for its peak; zero of a contact that dissipates, whose push has the peak. Returns
    /// the contact under way if it turns out to have ended; the next one then takes its place.
    pub(super) fn press(&mut self, curve: &Curve, push: Push, elastic: &dyn Fn(f64) -> f64) -> Option<Contact> {
        self.seen = true;
        // The rate of an overlap that is a rounding error is not known, nor whether it pushes.
        let push = Push { last: push.last.filter(|_| curve.range().1 > ROUNDING * self.largest.1), ..push };
        let Some(lull) = &mut self.lull else {
            self.grow(curve, push, elastic);
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
                lull.next.push = push;
                self.push = self.push.and(before);
            } else {
                self.push = self.push.and(before.and(push));
            }
        } else {
            lull.next.grow(curve, push, elastic);
        }
        let Some(lull) = &self.lull else { return None };
        let (largest, second) = (self.largest.1, lull.next.largest.1);
        if TOUCH * second > lull.least && second > ROUNDING * largest {
            let next = lull.next.as_ref().clone();
            let over = std::mem::replace(self, next).without_next();
            self.fall(curve);
            return Some(over.finish(None));
        }
        if curve.falls_to(TOUCH * largest).is_some() {
            // The rise in between is a part of this contact.
            self.push = self.push.and(lull.next.push);
            self.lull = None;
            self.fall(curve);
        }
        None
    }

    /// Adds the push of a stretch, and keeps the stretch if the overlap reaches a new largest
    /// value in it.
    fn grow(&mut self, curve: &Curve, push: Push, elastic: &dyn Fn(f64) -> f64) {
        self.push = self.push.and(push);
        // Between nodes the overlap may be larger than at all nodes.
        if curve.range().1 < (1.0 - 1e-3) * self.largest.1 {
            return;
        }
        let largest = curve.largest();
        if largest.1 > self.largest.1 {
            self.largest = largest;
            self.push = self.push.and(Push { peak: (largest.0, elastic(largest.1)), ..Push::default() });
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

#[cfg(test)]
mod tests {
    use super::*;

    fn push(impulse: f64, last: Option<f64>) -> Push {
        Push { impulse, last, ..Push::default() }
    }

    /// The contacts of an overlap that is given in stretches of length `h`: those that end on the
    /// way, and the one under way at the end. `rates` are those at its zeros at start and end, if
    /// there are any.
    fn contacts(g: impl Fn(f64) -> f64, (start, end): (f64, f64), rates: [Option<f64>; 2], h: f64) -> Vec<Contact> {
        let mut pending = Pending::new(3, rates[0].map(|rate| (start, rate)));
        let count = ((end - start) / h).round() as usize;
        let mut all = Vec::new();
        for k in 0..count {
            let [from, to] = [k, k + 1].map(|k| start + (end - start) * k as f64 / count as f64);
            let points = (0..8).map(|k| f64::from(k) / 7.0).map(|x| (x, g(from + (to - from) * x)));
            all.extend(pending.press(&Curve::over((from, to), points), push(0.25, None), &f64::sqrt));
        }
        all.push(pending.finish(rates[1].map(|rate| (end, rate))));
        assert!((all.iter().map(|contact| contact.impulse).sum::<f64>() - 0.25 * count as f64).abs() < 1e-12);
        all
    }

    #[test]
    fn a_contact_that_comes_through_zero_begins_and_ends_there() {
        for h in [0.1, 0.3, 3.0] {
            let [contact] = contacts(|t| t * (3.0 - t), (0.0, 3.0), [Some(3.0), Some(-3.0)], h)[..] else { panic!() };
            let Contact { onset, release, approach, separation, t_largest, .. } = contact;
            assert_eq!([onset, release, approach, separation], [Some(0.0), Some(3.0), Some(3.0), Some(3.0)]);
            assert_eq!([contact.onset_overlap, contact.release_overlap], [Some(0.0); 2]);
            assert!((t_largest - 1.5).abs() < 1e-13 && (contact.largest_overlap - 2.25).abs() < 1e-14);
            assert!(contact.t_peak == t_largest && (contact.peak_force - 1.5).abs() < 1e-14);
        }
    }

    #[test]
    fn beads_that_touch_begin_to_press_at_a_share_of_the_largest_overlap() {
        // Closed form: exp(-cosh t) has its largest value 1/e at 0, and TOUCH of it where cosh t =
        // 1 + ln(1/TOUCH). The times that are given as its zeros do not matter.
        let t = (1.0 - TOUCH.ln()).acosh();
        for (from, to, noise) in [(-6.0, 6.0, 0.0), (-4.0, 5.0, 1e-8), (-5.0, 4.0, -1e-8)] {
            for h in [0.02, 0.1] {
                let got = contacts(|t| f64::exp(-t.cosh()), (from, to), [Some(noise), Some(noise)], h);
                let [contact] = got[..] else { panic!("{got:?}") };
                let (onset, release) = (contact.onset.unwrap(), contact.release.unwrap());
                let bound = if h > 0.05 { 3e-8 } else { 1e-12 };
                assert!((onset + t).abs() < bound && (release - t).abs() < bound, "{h}: {contact:?}");
                assert!((contact.approach.unwrap() - contact.separation.unwrap()).abs() < 10.0 * bound);
                let level = TOUCH * contact.largest_overlap;
                assert_eq!([contact.onset_overlap, contact.release_overlap], [Some(level); 2]);
            }
        }
        // At the end of the run the contact has faded, or not yet; one that is about to open has
        // not.
        let at_end = |end: f64| contacts(|t| f64::exp(-t.cosh()), (-4.0, end), [Some(0.0), None], 0.02)[0];
        assert!((at_end(4.0).release.unwrap() - t).abs() < 1e-12);
        assert_eq!(at_end(t - 0.02).release, None);
        let opens = contacts(|t| t * (3.0 - t), (0.0, 2.9995), [Some(3.0), None], 0.00857);
        assert_eq!(opens[0].release, None);
    }

    #[test]
    fn an_overlap_that_nearly_vanishes_between_two_large_values_is_two_contacts() {
        let two = |least: f64| move |t: f64| f64::exp(-t.cosh()) + f64::exp(-(t - 8.0).cosh()) + least;
        for (least, count) in [(0.0, 2), (1e-4, 2), (1e-3, 1)] {
            let got = contacts(two(least), (-4.0, 12.0), [Some(0.0), Some(0.0)], 0.02);
            assert_eq!(got.len(), count, "{least:e}: {got:?}");
            if let [first, second] = got[..] {
                // Each is the mirror image of the other.
                let mirror = |a: Option<f64>, b: Option<f64>| (a.unwrap() + b.unwrap() - 8.0).abs();
                assert!(mirror(first.onset, second.release) < 1e-11, "{got:?}");
                assert!(mirror(first.release, second.onset) < 1e-11, "{got:?}");
                assert!((first.t_largest + second.t_largest - 8.0).abs() < 1e-12);
            }
        }
        // A low contact after a high one: the stretch in which the first ends begins above the
        // level at which the second does, and the second must not begin there.
        let low = |t: f64| f64::exp(-t.cosh()) + 0.02 * f64::exp(-(t - 6.6).cosh());
        let apart = (1.0 - TOUCH.ln()).acosh();
        for h in [0.1, 0.5, 0.8] {
            let [first, second] = contacts(low, (-4.0, 12.0), [Some(0.0), Some(0.0)], h)[..] else { panic!("{h}") };
            let (release, onset) = (first.release.unwrap(), second.onset.unwrap());
            // The tail of the first moves the onset of the second by 1.3e-6. Measured: 2.0e-7 and
            // 1.6e-5, with the longest stretches.
            let (early, late) = ((release - apart).abs(), (onset - 6.6 + apart).abs());
            assert!(release < onset && early < 4e-7 && late < 3e-5, "{h}: {early:e} {late:e}");
        }
        // A ripple whose overlap stays above `TOUCH` of its own largest value is no contact.
        let ripple = |t: f64| f64::exp(-t.cosh()) + 1e-5 * (1.2 + (9.0 * t).cos());
        assert_eq!(contacts(ripple, (-5.0, 5.0), [Some(0.0), Some(0.0)], 0.02).len(), 1);
    }

    #[test]
    fn the_stretch_with_the_least_overlap_gives_its_impulse_to_the_larger_side() {
        // An error of a stretch of 1e-9, then a real contact that begins with it.
        let stretch =
            |from: f64, to: f64, values: [f64; 3]| Curve::over((from, to), [0.0, 0.5, 1.0].into_iter().zip(values));
        let mut pending = Pending::new(3, Some((0.0, 1.0)));
        assert!(pending.press(&stretch(0.0, 0.1, [1e-9, 2e-10, 1e-13]), push(1e-13, None), &f64::sqrt).is_none());
        let over = pending.press(&stretch(0.1, 5.0, [1e-14, 0.1, 1.0]), push(0.4, None), &f64::sqrt).unwrap();
        assert_eq!([over.impulse, pending.finish(None).impulse], [1e-13, 0.4]);
    }

    /// The contact as it is read back: not seen in this leg.
    fn unseen(pending: Pending) -> Pending {
        let lull = pending.lull.map(|lull| Lull { next: Box::new(unseen(*lull.next)), ..lull });
        Pending { seen: false, lull, ..pending }
    }

    #[test]
    fn what_is_stored_is_read_back() {
        let mut pending = Pending::new(3, Some((-4.0, 0.0)));
        for k in 0..75 {
            let from = -4.0 + 0.1 * f64::from(k);
            let points = [0.0, 0.3, 0.7, 1.0].map(|x| (x, f64::exp(-(from + 0.1 * x).cosh())));
            pending.press(&Curve::over((from, from + 0.1), points), push(0.1, Some(from)), &f64::sqrt);
            let mut numbers = Vec::new();
            pending.store(&mut numbers);
            let mut iterator = numbers.iter().copied();
            let read = Pending::read(&mut iterator, true).unwrap();
            assert_eq!(read, unseen(pending.clone()));
            assert!(iterator.next().is_none());
            for cut in [0, 1, 6, 7, 9, 20, numbers.len() - 1] {
                assert!(Pending::read(&mut numbers[..cut].iter().copied(), true).is_none());
            }
        }
        assert!(pending.lull.is_some());
    }
}
