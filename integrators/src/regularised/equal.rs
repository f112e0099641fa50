//! The regularised method without step-size control, for studies of its order.

use super::{Mapped, TimeMap, check_problem};
use crate::{
    clock::DoubleDouble,
    dop853::step::{Leap, Step},
    error::Error,
    events::{Event, EventFunctions},
    interrupt,
    real::Real,
    system::VectorField,
};

/// Largest number of Newton iterations for the end of a leg; a good guess needs two or three.
const MOST_PASSES: usize = 12;

/// The stops of a run: the approximate time of each, the function that vanishes there, and whether
/// an onset or a release happens there.
#[derive(Clone, Debug, PartialEq)]
pub struct Itinerary<R> {
    stops: Vec<Stop<R>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Stop<R> {
    event: Event<R>,
    onset: bool,
    release: bool,
}

impl<R: Real> Itinerary<R> {
    /// From the events of a run in the order of time; events closer than `together` share a stop.
    pub fn new(events: &[Event<R>], together: R) -> Self {
        let mut stops: Vec<Stop<R>> = Vec::new();
        for &event in events {
            match stops.last_mut().filter(|stop| event.t - stop.event.t <= together) {
                Some(stop) => {
                    stop.onset |= event.rising;
                    stop.release |= !event.rising;
                }
                None => stops.push(Stop { event, onset: event.rising, release: !event.rising }),
            }
        }
        Self { stops }
    }

    /// Number of stops.
    pub fn len(&self) -> usize {
        self.stops.len()
    }

    /// Whether there are no stops.
    pub fn is_empty(&self) -> bool {
        self.stops.is_empty()
    }
}

/// The division of a leg into steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Division<R> {
    /// Steps of this length in time, the last of each leg shorter, as without a map.
    Length(R),
    /// A number of equal steps in the mapped variable on every leg, with a map of power `q`.
    Count {
        /// Number of steps per leg.
        steps: u64,
        /// Power of the map.
        q: u32,
    },
}

impl<R: Real> Division<R> {
    fn check(&self) -> Result<(), Error> {
        match *self {
            Self::Length(h) if !(h.is_finite() && h > R::zero()) => {
                Err(Error::Argument { name: "h", value: h.f64(), rule: "a step is finite and above zero" })
            }
            Self::Count { steps: 0, .. } => {
                Err(Error::Argument { name: "steps", value: 0.0, rule: "at least one step" })
            }
            _ => Ok(()),
        }
    }

    fn q(&self) -> u32 {
        if let Self::Count { q, .. } = *self { q } else { 1 }
    }

    /// Number of steps on a leg of this length.
    fn count(&self, length: R) -> u64 {
        match *self {
            // A step that fits up to rounding is not split.
            Self::Length(h) => (length / h * R::of(1.0 - 1e-9)).ceil().max(R::one()).f64() as u64,
            Self::Count { steps, .. } => steps,
        }
    }

    /// The `sigma` at which step `k` of `count` begins.
    fn node(&self, k: u64, count: u64, length: R) -> R {
        match *self {
            _ if k == count => R::one(),
            Self::Length(h) => R::of(k as f64) * (h / length),
            Self::Count { .. } => R::of(k as f64) / R::of(count as f64),
        }
    }
}

/// Integrates with DOP853 from `y0` over the span, without error control. Returns the state at the
/// end and the number of steps.
///
/// The integration stops at each event, which Newton's method finds on the computed solution. The
/// itinerary gives the starting values only.
///
/// # Errors
/// A division or a problem that is not valid; a state that is not finite; steps so long that the
/// solution lacks an event of the itinerary.
pub fn equal_steps<R: Real, F: VectorField<R>, E: EventFunctions<R>>(
    mut field: F,
    functions: &E,
    y0: &[R],
    (start, end): (R, R),
    division: Division<R>,
    itinerary: &Itinerary<R>,
) -> Result<(Vec<R>, u64), Error> {
    division.check()?;
    let q = division.q();
    check_problem(field.dim(), y0, (start, end), 1.0, q)?;
    let mut origin = DoubleDouble::new(start);
    let (mut step, mut steps, mut onset) = (Step::new(y0, R::one()), 0, false);
    let mut from = y0.to_vec();
    let (mut dy, mut g) = (y0.to_vec(), vec![R::zero(); functions.count()]);
    let mut rates = g.clone();
    let power = |singular: bool| if singular { q } else { 1 };
    for stop in itinerary.stops.iter().map(Some).chain([None]) {
        let mut length = (stop.map_or(DoubleDouble::new(end), |stop| DoubleDouble::new(stop.event.t)) - origin).value();
        if length <= R::zero() {
            onset |= stop.is_some_and(|stop| stop.onset);
            continue;
        }
        let mut pass = 0;
        loop {
            interrupt::check(origin.value().f64())?;
            let map = TimeMap::new(length, power(onset), power(stop.is_some_and(|stop| stop.release)));
            step.load(&from);
            let taken = traverse(&mut Mapped { field: &mut field, map, origin: origin.value() }, &mut step, division)?;
            let Some(stop) = stop else {
                steps += taken;
                break;
            };
            let (t, y) = ((origin + DoubleDouble::new(length)).value(), step.state());
            field.eval(t, y, &mut dy);
            functions.values(t, y, &mut g);
            functions.rates(t, y, &dy, &mut rates);
            let g = g[stop.event.index];
            let miss = -(g / rates[stop.event.index]);
            if g.abs() <= functions.band(y) || miss.abs() <= R::of(1e-12) * length {
                steps += taken;
                break;
            }
            pass += 1;
            // The steps are too long for the solution to have this event.
            if pass == MOST_PASSES || miss.is_nan() || miss.abs() >= length {
                return Err(Error::StepUnderflow { t: t.f64(), h: miss.f64() });
            }
            length += miss;
        }
        origin = origin + DoubleDouble::new(length);
        onset = stop.is_some_and(|stop| stop.onset);
        from.copy_from_slice(step.state());
    }
    field.complete(start, end, &mut from);
    Ok((from, steps))
}

/// Integrates a leg from `sigma = 0` to 1; returns the number of steps.
fn traverse<R: Real, F: VectorField<R>>(
    field: &mut Mapped<'_, R, F>,
    step: &mut Step<R>,
    division: Division<R>,
) -> Result<u64, Error> {
    let (length, origin) = (field.map.length(), field.origin);
    let count = division.count(length);
    step.begin(field, R::zero());
    for k in 0..count {
        let (from, to) = (division.node(k, count, length), division.node(k + 1, count, length));
        let leap = Leap { from: DoubleDouble::new(from), to: DoubleDouble::new(to), h: to - from, share_3: R::one() };
        let done = step.attempt(field, leap, None).and_then(|_| step.accept(field, to));
        done.map_err(|index| Error::NotFinite { t: origin.f64(), step: k, index })?;
        step.advance();
    }
    Ok(count)
}
