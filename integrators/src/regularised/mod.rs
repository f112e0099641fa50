//! DOP853 that stops at every event and continues in a variable in which the solution is smooth.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g, alpha` | event functions; near `g = 0` the field behaves like `(g)_+^alpha` |
//! | *leg* | time interval between two events; no function changes its sign inside |
//! | `tau, sigma` | time since the leg's origin, and the mapped variable, see [`TimeMap`] |
//! | `q` | power of the map at a singular end: a start at an onset, an end at a release |
//! | `s` | `tau^{1/q}`: step lengths of legs with a singular end are stored in this variable |
//!
//! At an onset `g` rises, at a release it falls. After an onset the force grows like `tau^alpha`,
//! which no polynomial in `tau` approximates to high order. In `sigma`, with `tau ~ sigma^q` and
//! `q alpha` an integer, it is analytic. With `q = 1` the method stops and restarts at events but
//! uses no map.
//!
//! Every trial step is searched for events, also one whose error is too large. If an event is
//! found, the trial is repeated in the map that this event needs, so that the step ends on the
//! first event; Newton's method moves the end of the leg until the function vanishes there. Events
//! close to an origin share it if the move changes the state by less than the tolerance:
//! simultaneous contacts then cost one stop and no tiny steps.

mod equal;
mod leg;
mod map;

pub use equal::{Division, Itinerary, equal_steps};
pub use map::{TimeMap, common_power};

use leg::{Leg, Mapped, StepLengths};

use crate::{
    clock::{Breaks, DoubleDouble},
    dop853::{
        Options,
        controller::{Controller, StepOutcome, round_off},
        dense::Dense,
        step::{Leap, Step},
    },
    drive::Stepper,
    error::Error,
    events::{
        Event, EventFunctions, SHARES,
        sides::{Crossing, Sides},
    },
    interrupt,
    real::Real,
    stats::Stats,
    system::VectorField,
};

/// Largest number of landings tried for one accepted step. After that, the event is given up and
/// the step is shortened.
const MOST_RETRIES: u32 = 24;

/// Smallest relative tolerance, in unit round-offs. It is below one because errors of steps add up:
/// a run of thousands of steps ends with an error of the size of rounding if each step errs by a
/// tenth of a unit round-off.
const FLOOR: f64 = 0.05;

/// Longest leg, in steps. A leg without a predicted event ends there, and the next one starts, so
/// that times since the origin stay accurate and the mapped variable stays well scaled.
const FAR: f64 = 64.0;

/// Errors of values of event functions in a step, in units of the absolute tolerance and of the
/// norm of the error of the step. Chosen: sums of several components, each with the tolerance of
/// its own.
const NOISE: f64 = 10.0;

/// Refuses a problem that cannot be integrated.
pub(crate) fn check_problem<R: Real>(
    dim: usize,
    y0: &[R],
    (start, end): (R, R),
    alpha: f64,
    q: u32,
) -> Result<(), Error> {
    crate::dop853::check_start(dim, y0, (start, end))?;
    if !(alpha.is_finite() && alpha > 0.0) {
        return Err(Error::Argument { name: "alpha", value: alpha, rule: "the exponent is finite and positive" });
    }
    if !(1..=64).contains(&q) {
        return Err(Error::Argument { name: "q", value: f64::from(q), rule: "the power of the map is from 1 to 64" });
    }
    Ok(())
}

/// Position of the end of a leg relative to its event.
enum Arrival<R> {
    /// On the event.
    There,
    /// This much time before the event; after it, if negative.
    Off(R),
    /// No event near the end.
    Lost,
}

/// DOP853 from event to event: landed on each (`q = 1`), or regularised at each.
pub struct Regularised<R, F, E> {
    field: F,
    functions: E,
    alpha: R,
    q: u32,
    options: Options<R>,
    /// Unit of the functions, and a bound of the factor of `(g)_+^alpha`.
    unit: R,
    strength: R,
    controller: Controller<R>,
    step: Step<R>,
    dense: Dense<R>,
    leg: Leg<R>,
    end: DoubleDouble<R>,
    /// Times at which the field is not smooth; start and end of the stretch between two of them.
    breaks: Breaks,
    start: R,
    stop: DoubleDouble<R>,
    steps: Option<StepLengths<R>>,
    /// The last step with its leg, until the next one.
    last: Option<(Leg<R>, Leap<R>)>,
    sides: Sides,
    crossings: Vec<Crossing>,
    events: Vec<Event<R>>,
    /// Events that happen at the present position.
    pending: Vec<Event<R>>,
    /// Functions whose events a trial has shown to be false.
    false_events: Vec<usize>,
    y: Vec<R>,
    dy: Vec<R>,
    g: Vec<R>,
    rates: Vec<R>,
    fired_here: usize,
    /// Mean length of the last legs.
    usual: R,
    done: bool,
    stats: Stats,
}

/// The first event of a trial.
#[derive(Clone, Copy)]
struct Landing<R> {
    crossing: Crossing,
    /// Time of the event since the origin of the leg.
    tau: R,
    /// Whether the event may be moved to the start of the trial. If so, it is pending, with all
    /// others that may be moved there.
    here: bool,
    /// Whether the event, or another that shares its place, is a release.
    released: bool,
}

/// The outcome of a trial.
enum Trial<R> {
    /// An event lies inside the step: the next trial ends there.
    Land(Landing<R>),
    /// The error is too large. Value: the step to try next.
    Smaller(R),
    /// The step ends near its event. Value: the time still missing.
    Miss(Crossing, R),
    /// The event is not near the end of the step.
    Lost,
    /// Events fired at this place or before it are false.
    TakeBack,
    /// Accepted. Value: the step that the error allows next.
    Good(R),
}

impl<R: Real, F: VectorField<R>, E: EventFunctions<R>> Regularised<R, F, E> {
    /// Integrates `field` from `y0` over the span; near `functions = 0` the field behaves like
    /// `(g)_+^alpha`. `q` is the power of the map at singular ends, see [`common_power`]; `q = 1`
    /// means no map.
    ///
    /// # Errors
    /// As [`Dop853::new`](crate::Dop853::new), but the relative tolerance may be as small as a
    /// twentieth of the unit round-off; or `alpha <= 0`, or a `q` below 1 or above 64.
    pub fn new(
        field: F,
        functions: E,
        (alpha, q): (f64, u32),
        y0: &[R],
        (start, end): (R, R),
        options: Options<R>,
    ) -> Result<Self, Error> {
        let options = options
            .checked((R::of(FLOOR), "a relative tolerance is finite and above a twentieth of the unit round-off"))?;
        check_problem(field.dim(), y0, (start, end), alpha, q)?;
        let count = functions.count();
        let step = Step::new(y0, options.atol);
        let breaks = Breaks::new(field.breaks());
        let stop = breaks.or_end(start, DoubleDouble::new(end));
        let mut regularised = Self {
            controller: Controller::new(R::infinity()),
            dense: Dense::new(step.padded()),
            step,
            leg: Leg {
                origin: DoubleDouble::new(start),
                map: TimeMap::new((stop - DoubleDouble::new(start)).value(), 1, 1),
                sigma: R::zero(),
                target: None,
            },
            end: DoubleDouble::new(end),
            breaks,
            start,
            stop,
            steps: None,
            last: None,
            sides: Sides::new(count),
            crossings: Vec::new(),
            events: Vec::new(),
            pending: Vec::new(),
            false_events: Vec::new(),
            y: y0.to_vec(),
            dy: y0.to_vec(),
            g: vec![R::zero(); count],
            rates: vec![R::zero(); count],
            fired_here: 0,
            usual: end - start,
            done: end <= start,
            stats: Stats::default(),
            alpha: R::of(alpha),
            field,
            functions,
            q,
            options,
            unit: R::one(),
            strength: R::one(),
        };
        regularised.functions.values(start, y0, &mut regularised.g);
        regularised.sides.put(0, &regularised.g);
        regularised.sides.set_band(regularised.functions.band(y0).f64());
        regularised.sides.begin(regularised.functions.told());
        let positive: Vec<usize> = (0..count).filter(|&index| regularised.sides.positive(index)).collect();
        regularised.tell(&positive);
        Ok(regularised)
    }

    /// As [`Dop853::in_units`](crate::Dop853::in_units), with the unit of the event functions. Near
    /// `g = 0` the field behaves like `strength (g)_+^alpha` at most, in these units.
    #[must_use]
    pub fn in_units(mut self, units: &[R], time: R, (unit, strength): (R, R)) -> Self {
        self.step.in_units(units, time);
        (self.unit, self.strength) = (unit, strength);
        self
    }

    /// Tells the field the sides of some functions. Returns whether field or state have changed.
    fn tell(&mut self, indices: &[usize]) -> bool {
        if indices.is_empty() {
            return false;
        }
        self.y.copy_from_slice(self.step.state());
        let mut changed = false;
        for &index in indices {
            changed |= self.field.turn(index, self.sides.positive(index), &mut self.y);
        }
        if changed {
            self.step.load(&self.y);
        }
        changed
    }

    /// The events of the last step, in the order in which they were found.
    pub fn events(&self) -> &[Event<R>] {
        &self.events
    }

    /// The field.
    pub fn field_mut(&mut self) -> &mut F {
        &mut self.field
    }

    fn not_finite(&self, index: usize) -> Error {
        Error::NotFinite { t: self.time().f64(), step: self.stats.steps, index }
    }

    /// Computes the slope at the present position of the leg, in its variable.
    fn slope(&mut self) -> Result<(), Error> {
        self.step.begin(&mut self.leg.mapped(&mut self.field), self.leg.sigma);
        self.stats.force_evaluations += 1;
        self.step.check(0).map_err(|index| self.not_finite(index))
    }

    /// Begins the run or, at a break, a new stretch: a leg with a first step as at the start.
    fn begin(&mut self) -> Result<StepLengths<R>, Error> {
        if self.leg.sigma == R::one() {
            let from = std::mem::replace(&mut self.start, self.stop.value());
            self.field.complete(from, self.start, self.step.state_mut());
            let origin = self.stop;
            self.stop = self.breaks.or_end(self.start, self.end);
            self.controller = Controller::new(R::infinity());
            let map = TimeMap::new((self.stop - origin).value(), 1, 1);
            self.leg = Leg { origin, map, sigma: R::zero(), target: None };
        }
        let steps = self.guess()?;
        self.slope()?;
        Ok(steps)
    }

    /// The first step, estimated as DOP853 does.
    fn guess(&mut self) -> Result<StepLengths<R>, Error> {
        // In time: the map of a leg of unit length and power 1.
        let span = (self.end - self.leg.origin).value();
        let natural = Leg { map: TimeMap::new(R::one(), 1, 1), sigma: R::zero(), ..self.leg };
        let mut field = natural.mapped(&mut self.field);
        self.step.begin(&mut field, R::zero());
        let tau = match self.options.first_step {
            Some(h) => h.min(span),
            None => self.step.first(&mut field, R::zero(), self.options.rtol, span),
        };
        self.stats.force_evaluations += 2;
        self.step.check(0).map_err(|index| self.not_finite(index))?;
        Ok(StepLengths { tau, s: tau.powf(R::of(f64::from(self.q)).recip()) })
    }

    /// Largest time by which an event of a function with this rate may be shifted. The force
    /// `strength (rate t)^alpha` left out then changes the state by about a hundredth of the
    /// absolute tolerance.
    fn cluster(&self, rate: R) -> R {
        let time = self.step.time_unit();
        let force = self.strength * (rate.abs() * time / self.unit).powf(self.alpha);
        (R::of(0.01) * self.options.atol / force).powf((self.alpha + R::one()).recip()) * time
    }

    /// Evaluates the functions at the nodes of the trial. The dense output must be prepared.
    fn look(&mut self, leg: &Leg<R>, leap: Leap<R>) {
        for (k, share) in SHARES.into_iter().enumerate() {
            let sigma = leap.from.value() + leap.h * R::of(share);
            let t = leg.time(sigma).value();
            let y = match k {
                0 => self.step.before(),
                _ if k + 1 == SHARES.len() => self.step.state(),
                _ => {
                    self.dense.eval(self.step.before(), R::of(share), &mut self.y);
                    &self.y
                }
            };
            self.functions.values(t, y, &mut self.g);
            self.sides.put(k, &self.g);
        }
        // The band of the state before the step: the state after a bad trial may be large.
        self.sides.set_band(self.functions.band(self.step.before()).f64());
    }

    /// Largest time by which the event of a crossing may be shifted; negative if it may not be.
    fn width(&self, leg: &Leg<R>, leap: Leap<R>, crossing: &Crossing) -> R {
        // An event that has fired at this place is not moved here again.
        if self.sides.late(crossing.index) {
            return -R::one();
        }
        // The rate is a difference quotient, not the slope at the crossing, because the map has no
        // inverse slope at a singular end.
        let (near, polynomial) = (crossing.zero, self.sides.polynomial(crossing.index));
        let far = if near < 0.5 { near + 0.05 } else { near - 0.05 };
        let change = R::of(polynomial.at(far) - polynomial.at(near));
        self.cluster(change / (leg.tau_in(leap, far) - leg.tau_in(leap, near)))
    }

    /// The first event in the trial. If it may be moved to the start of the trial, it becomes
    /// pending, with all others that may be moved there.
    fn first_event(&mut self, leg: &Leg<R>, leap: Leap<R>) -> Option<Landing<R>> {
        self.sides.first_crossings(&mut self.crossings);
        let earlier = |x: &&Crossing, y: &&Crossing| x.zero.total_cmp(&y.zero).then(x.index.cmp(&y.index));
        let crossing = *self.crossings.iter().min_by(earlier)?;
        let tau = leg.tau_in(leap, crossing.zero);
        let shares = |c: &Crossing, place: R| leg.tau_in(leap, c.zero) - place <= self.width(leg, leap, c);
        let ends = |c: &Crossing| !c.rising || self.functions.kinks(c.index);
        let released = self.crossings.iter().any(|other| ends(other) && shares(other, tau));
        let here = shares(&crossing, leg.tau());
        let event = |c: &Crossing| {
            let t = leg.origin + DoubleDouble::new(leg.tau_in(leap, c.zero));
            Event { index: c.index, rising: c.rising, t: t.value() }
        };
        let pending = self.crossings.iter().filter(|c| here && shares(c, leg.tau())).map(event).collect();
        self.pending = pending;
        Some(Landing { crossing, tau, here, released })
    }

    /// Makes one trial from the present position. `Good` leaves it accepted; otherwise it is
    /// undone.
    fn attempt(&mut self, to: R) -> Result<Trial<R>, Error> {
        let leg = self.leg;
        let [from, end] = [leg.sigma, to].map(DoubleDouble::new);
        let mut leap = Leap { from, to: end, h: to - leg.sigma, share_3: R::one() };
        // Of rates that are no parabola, the formula of order 3 errs by much more than of the
        // motion.
        if leg.map.powers().0 + leg.map.powers().1 > 4 {
            leap.share_3 = self.step.share_3(leap, |sigma| leg.map.rate(sigma));
        }
        self.dense.clear();
        let mut field = leg.mapped(&mut self.field);
        let error = self.step.attempt(&mut field, leap, Some(self.options.rtol));
        let error = match error.and_then(|error| self.step.accept(&mut field, to).map(|()| error)) {
            Ok(error) => error,
            // A step from free flight may end where forces overflow: it is shortened.
            Err(index) => return self.overflow(index, leap.h),
        };
        let dense = self.dense.prepare(&mut self.step, &mut field, leap);
        self.stats.force_evaluations += 12 + dense;
        self.look(&leg, leap);
        let arrives = leg.target.is_some() && to == R::one();
        let told = self.functions.told();
        if told {
            self.sides.set_noise((R::of(NOISE) * self.options.atol * self.unit).f64(), error.f64());
            self.sides.taken_back(&mut self.false_events);
            if !self.false_events.is_empty() {
                self.step.undo();
                return Ok(Trial::TakeBack);
            }
        }
        let event = self.first_event(&leg, leap);
        let verdict = self.controller.judge(leap.h, error);
        // The polynomial may place the event of this leg slightly before its end.
        let own = |crossing: &Crossing| arrives && leg.target.is_some_and(|target| target.index == crossing.index);
        let trial = match (event, verdict) {
            // The error is so large that the events of the trial mean nothing.
            (_, StepOutcome::Reject(h)) if error * self.options.rtol > R::of(1e-3) => Trial::Smaller(h),
            (Some(landing), _) if !own(&landing.crossing) => Trial::Land(landing),
            (_, StepOutcome::Reject(h)) => Trial::Smaller(h),
            (event, StepOutcome::Accept(h)) => match leg.target.filter(|_| arrives) {
                Some(target) => match self.arrival(&leg, target, event.map(|landing| landing.tau)) {
                    Arrival::There => Trial::Good(h),
                    Arrival::Off(miss) => Trial::Miss(target, miss),
                    Arrival::Lost => Trial::Lost,
                },
                None => Trial::Good(h),
            },
        };
        if let Trial::Good(_) = trial {
            self.last = Some((leg, leap));
        } else {
            self.step.undo();
            self.stats.rejected += u64::from(matches!(trial, Trial::Smaller(_)));
        }
        Ok(trial)
    }

    /// Takes false events back, at the present position.
    fn take_back(&mut self) -> Result<(), Error> {
        let origin = self.leg.time(self.leg.sigma);
        let event = |&index: &usize| Event { index, rising: !self.sides.positive(index), t: origin.value() };
        self.pending = self.false_events.iter().map(event).collect();
        self.fire()
    }

    /// A trial that is not finite: the next is a tenth as long, down to a smallest step.
    fn overflow(&mut self, index: usize, h: R) -> Result<Trial<R>, Error> {
        self.stats.force_evaluations += 11;
        self.stats.rejected += 1;
        if h <= R::of(1e-12) * self.leg.sigma.max(R::of(1e-12)) {
            return Err(self.not_finite(index));
        }
        Ok(Trial::Smaller(h * R::of(0.1)))
    }

    /// Whether the leg ends on its event; `seen` is the time of the event by the polynomial of the
    /// trial.
    fn arrival(&mut self, leg: &Leg<R>, target: Crossing, seen: Option<R>) -> Arrival<R> {
        let t = leg.time(R::one()).value();
        self.field.eval(t, self.step.state(), &mut self.dy);
        self.stats.force_evaluations += 1;
        self.functions.values(t, self.step.state(), &mut self.g);
        self.functions.rates(t, self.step.state(), &self.dy, &mut self.rates);
        let (g, rate) = (self.g[target.index], self.rates[target.index]);
        let finer = round_off::<R>() / R::of(f64::EPSILON);
        if g.abs() <= R::of(0.03) * self.functions.band(self.step.state()) * finer {
            return Arrival::There;
        }
        let (length, newton) = (leg.map.length() - leg.tau(), -(g / rate));
        // Newton's method would lead to another zero. The polynomial is used instead, if it has a
        // zero.
        let diverged = target.rising != (rate > R::zero()) || newton.abs() > R::of(0.5) * length;
        match seen {
            Some(at) if diverged => Arrival::Off(at - leg.map.length()),
            None if diverged => Arrival::Lost,
            _ if newton.abs() <= R::of(1e-9) * length && newton.abs() <= self.cluster(rate) => Arrival::There,
            _ => Arrival::Off(newton),
        }
    }

    /// Sets the target of the leg: an event at time `tau` since its origin.
    fn aim(&mut self, target: Crossing, tau: R, released: bool) -> Result<(), Error> {
        let (a, b) = (self.leg.map.powers().0, if released { self.q } else { 1 });
        let now = self.leg.tau();
        self.leg.map = TimeMap::new(tau, a, b);
        self.leg.sigma = self.leg.map.inverse(now);
        self.leg.target = Some(target);
        self.slope()
    }

    /// Starts a leg at `origin` with power `a`, up to the end of the stretch.
    fn set_out(&mut self, origin: DoubleDouble<R>, a: u32) -> Result<(), Error> {
        self.leg =
            Leg { origin, map: TimeMap::new((self.stop - origin).value(), a, 1), sigma: R::zero(), target: None };
        self.slope()
    }

    /// Drops the target of the leg, as no event was found there, and halves the step.
    fn give_up(&mut self, steps: &mut StepLengths<R>) -> Result<(), Error> {
        let (a, now) = (self.leg.map.powers().0, self.leg.tau());
        self.leg.map = TimeMap::new((self.stop - self.leg.origin).value(), a, 1);
        self.leg.sigma = self.leg.map.inverse(now);
        self.leg.target = None;
        *steps.of(&self.leg) *= R::of(0.5);
        self.slope()
    }

    /// Fires the pending events: their functions change sides, and a leg starts with the power that
    /// an onset at its origin needs.
    fn fire(&mut self) -> Result<(), Error> {
        let origin = self.leg.time(self.leg.sigma);
        self.fired_here += self.pending.len();
        if self.fired_here > 4 * self.g.len() + 4 {
            return Err(Error::StepUnderflow { t: origin.value().f64(), h: 0.0 });
        }
        let before = if self.leg.sigma == R::zero() { self.leg.map.powers().0 } else { 1 };
        let begins = |event: &Event<R>| event.rising || self.functions.kinks(event.index);
        let a = if self.pending.iter().any(begins) { self.q } else { before };
        let fired: Vec<usize> = self.pending.iter().map(|event| event.index).collect();
        fired.iter().for_each(|&index| self.sides.fire(index));
        self.tell(&fired);
        self.events.append(&mut self.pending);
        self.set_out(origin, a)
    }

    /// Fires the event on which the leg ended, and those that share its place.
    fn arrive(&mut self, target: Crossing) -> Result<(), Error> {
        let origin = self.leg.time(R::one());
        self.pending.clear();
        // Range of linear extrapolation; weak events beyond it may never happen.
        let sight = R::of(0.05) * self.leg.map.length();
        // Functions that do not leave the band within a usual leg count as at rest.
        let at_rest = self.functions.band(self.step.state()) / self.usual;
        for index in 0..self.g.len() {
            let (rising, rate) = (!self.sides.positive(index), self.rates[index]);
            let newton = if rate == R::zero() { R::zero() } else { -(self.g[index] / rate) };
            let turns = !self.sides.late(index) && rate.abs() > at_rest && rising == (rate > R::zero());
            if index == target.index || (turns && newton.abs() <= self.cluster(rate).min(sight)) {
                let t = (origin + DoubleDouble::new(newton)).value();
                self.pending.push(Event { index, rising, t });
            }
        }
        self.usual += R::of(0.2) * (self.leg.map.length() - self.usual);
        self.fire()
    }

    /// The `sigma` at which the next trial ends: as far as the error allows, stretched to the end
    /// of the leg or to half the rest so that no step is tiny.
    fn propose(&self, steps: &mut StepLengths<R>) -> Result<R, Error> {
        let leg = &self.leg;
        let h = *steps.of(leg) / leg.map.unit();
        // The trial covers at most twice a usual leg or the time since the origin, whichever is
        // longer.
        let reach = leg.tau().max(R::of(2.0) * self.usual);
        let h = if reach < leg.map.length() - leg.tau() {
            h.min(leg.map.inverse(leg.tau() + reach) - leg.sigma)
        } else {
            h
        };
        let rest = R::one() - leg.sigma;
        let to = if h * R::of(1.01) >= rest {
            R::one()
        } else if R::of(2.0) * h > rest {
            leg.sigma + R::of(0.5) * rest
        } else {
            leg.sigma + h
        };
        if self.stats.steps + self.stats.rejected >= self.options.max_steps {
            return Err(Error::TooManySteps { t: self.time().f64(), steps: self.stats.steps });
        }
        if to <= leg.sigma || !h.is_finite() {
            return Err(Error::StepUnderflow { t: self.time().f64(), h: h.f64() });
        }
        Ok(to)
    }

    /// Updates leg and step lengths after an accepted step to `to`; `next` is the step that its
    /// error allows.
    fn advance(&mut self, to: R, next: R, steps: &mut StepLengths<R>) -> Result<(), Error> {
        let leg = self.leg;
        let allowed = next * leg.map.unit();
        let tried = *steps.of(&leg);
        // A step that was cut short, and whose error allows the largest growth, does not reduce the
        // stored step length.
        let unbounded = next > R::of(5.9) * (to - leg.sigma);
        *steps.of(&leg) = if unbounded { allowed.max(tried) } else { allowed };
        self.stats.steps += 1;
        let turned = self.sides.settle();
        let changed = self.tell(&turned);
        self.leg.sigma = to;
        self.fired_here = 0;
        let arrived = to == R::one();
        match leg.target.filter(|_| arrived) {
            Some(target) => self.arrive(target),
            None if arrived => {
                self.done = self.stop == self.end;
                Ok(())
            }
            // Far from its origin the solution is smooth in time itself, and times since the origin
            // lose digits.
            None if leg.target.is_none() && self.leg.tau() > R::of(FAR) * steps.tau => {
                self.set_out(self.leg.time(to), 1)
            }
            None if changed => self.slope(),
            None => {
                self.step.advance();
                Ok(())
            }
        }
    }
}

impl<R: Real, F: VectorField<R>, E: EventFunctions<R>> Stepper<R> for Regularised<R, F, E> {
    fn dim(&self) -> usize {
        self.step.dim()
    }

    fn time(&self) -> R {
        if self.done { self.end.value() } else { self.leg.time(self.leg.sigma).value() }
    }

    fn done(&self) -> bool {
        self.done
    }

    fn step(&mut self) -> Result<(), Error> {
        self.events.clear();
        self.last = None;
        let mut steps = match self.steps {
            Some(steps) => steps,
            None => self.begin()?,
        };
        let mut retry = 0;
        loop {
            interrupt::check(self.time().f64())?;
            let to = self.propose(&mut steps)?;
            let trial = self.attempt(to)?;
            match trial {
                Trial::Good(next) => {
                    self.advance(to, next, &mut steps)?;
                    self.steps = (self.leg.sigma < R::one()).then_some(steps);
                    return Ok(());
                }
                Trial::Smaller(h) => *steps.of(&self.leg) = h * self.leg.map.unit(),
                Trial::Land(landing) => {
                    retry += 1;
                    // An event at a place where it has fired already is an error of the polynomial.
                    let again = !landing.here && landing.tau <= self.leg.tau();
                    if retry >= MOST_RETRIES || again {
                        self.give_up(&mut steps)?;
                    } else if landing.here {
                        self.fire()?;
                    } else {
                        self.aim(landing.crossing, landing.tau, landing.released)?;
                    }
                }
                Trial::Miss(target, miss) => {
                    retry += 1;
                    let tau = self.leg.map.length() + miss;
                    let beyond = tau >= (self.stop - self.leg.origin).value();
                    if retry >= MOST_RETRIES || tau <= self.leg.tau() || beyond {
                        self.give_up(&mut steps)?;
                    } else {
                        let released = self.leg.map.powers().1 > 1 || !target.rising;
                        self.aim(target, tau, released)?;
                    }
                }
                Trial::Lost => self.give_up(&mut steps)?,
                Trial::TakeBack => self.take_back()?,
            }
        }
    }

    /// Inside the last step the state is that of dense output, in the mapped variable.
    fn sample(&mut self, t: R, y: &mut [R]) {
        let t = match self.last {
            Some((leg, leap)) if t < self.time() => {
                let tau = (DoubleDouble::new(t) - leg.origin).value();
                let share = ((leg.map.inverse(tau) - leap.from.value()) / leap.h).max(R::zero()).min(R::one());
                self.dense.eval(self.step.before(), share, y);
                t
            }
            _ => {
                y.copy_from_slice(self.step.state());
                self.time()
            }
        };
        self.field.complete(self.start, t, y);
    }

    fn stats(&self) -> Stats {
        self.stats
    }
}
