//! Steps that end where contacts begin and end.

use super::{First, Scheme, scheme::Pair, steps::check};
use crate::{
    clock::{Breaks, DoubleDouble},
    drive::Stepper,
    error::Error,
    events::root::bracketed,
    interrupt,
    real::Real,
    stats::Stats,
    system::ContactFlow,
};

/// Events closer than this share of the step are treated as simultaneous.
const TOGETHER: f64 = 1e-9;

/// The state of a bond during a step.
#[derive(Clone, Copy)]
struct Bond<R> {
    /// `1` in contact, `-1` apart, `0` at rest inside the dead band.
    side: R,
    /// Overlap and its rate at the start of the step.
    start: (R, R),
    /// Overlap and its rate at the end of the step.
    end: (R, R),
    /// Whether the search of this step is finished for the bond.
    settled: bool,
}

/// An estimated change of side of a bond.
struct Crossing<R> {
    bond: usize,
    /// Estimated time since the start of the step.
    about: R,
    /// A time at which the bond is estimated to be on the other side.
    beyond: R,
}

/// A splitting scheme whose steps end on events: a step in which a contact begins or ends is
/// repeated with its end on the event.
///
/// The time of an event is a zero of the overlap along the numerical flow itself. It counts if the
/// overlap leaves the dead band of the flow on the other side. Inside a step, overlaps are
/// estimated by the cubics that match values and rates at both ends.
pub struct Landed<R, S> {
    flow: S,
    /// The flow at the start of the last step.
    before: S,
    mirror: S,
    pairs: Vec<Pair<R>>,
    bonds: Vec<Bond<R>>,
    overlaps: Vec<R>,
    rates: Vec<R>,
    band: R,
    h: DoubleDouble<R>,
    from: DoubleDouble<R>,
    time: DoubleDouble<R>,
    end: DoubleDouble<R>,
    /// Times at which the flow is not smooth: steps end there, too.
    breaks: Breaks,
    stats: Stats,
}

impl<R: Real, S: ContactFlow<R>> Landed<R, S> {
    /// Runs `scheme` on `flow`, which holds the state at `start`, to `end` in steps of
    /// `(end - start)/steps`, shortened by events.
    ///
    /// `first` is the flow with which compositions begin.
    ///
    /// # Errors
    /// As [`Splitting::new`](super::Splitting::new).
    pub fn new(scheme: &Scheme, first: First, flow: S, (start, end): (R, R), steps: u64) -> Result<Self, Error> {
        check((start, end), steps)?;
        let (start, end) = (DoubleDouble::new(start), DoubleDouble::new(end));
        let (zero, count) = (R::zero(), flow.bonds());
        let bond = Bond { side: zero, start: (zero, zero), end: (zero, zero), settled: false };
        let mut landed = Self {
            before: flow.duplicate(),
            mirror: flow.duplicate(),
            breaks: Breaks::new(flow.breaks()),
            flow,
            pairs: scheme.pairs(first),
            bonds: vec![bond; count],
            overlaps: vec![zero; count],
            rates: vec![zero; count],
            band: zero,
            h: (end - start).over(DoubleDouble::new(R::of(steps.max(1) as f64))),
            from: start,
            time: start,
            end,
            stats: Stats::default(),
        };
        landed.look();
        let band = landed.band;
        for bond in &mut landed.bonds {
            // Inside the band the side is the one to which the overlap moves.
            let (g, rate) = bond.end;
            bond.side = if g.abs() > band { sign(g) } else { sign(rate) };
        }
        Ok(landed)
    }

    /// Computes the state after a step of this length from the start of the last one, and its
    /// overlaps.
    fn advance(&mut self, length: R) {
        self.flow.copy_from(&self.before);
        step(&mut self.flow, &self.pairs, length, &mut self.stats);
        self.look();
    }

    fn look(&mut self) {
        // The band is that of the largest state so far, as rounding errors stay when a state passes
        // through zero.
        self.band = self.band.max(self.flow.overlaps(&mut self.overlaps, &mut self.rates));
        for (bond, (&g, &rate)) in self.bonds.iter_mut().zip(self.overlaps.iter().zip(&self.rates)) {
            bond.end = (g, rate);
        }
    }

    /// The overlap of a bond, multiplied by its side, after a step of this length.
    fn towards(&mut self, bond: usize, length: R) -> R {
        self.mirror.copy_from(&self.before);
        step(&mut self.mirror, &self.pairs, length, &mut self.stats);
        self.mirror.overlaps(&mut self.overlaps, &mut self.rates);
        self.bonds[bond].side * self.overlaps[bond]
    }

    /// The earliest estimated change of side in a step of this length.
    fn first_crossing(&self, length: R) -> Option<Crossing<R>> {
        let crossings = self.bonds.iter().enumerate().filter_map(|(k, bond)| {
            let (about, beyond) = crossing(bond, length, self.band)?;
            Some(Crossing { bond: k, about, beyond })
        });
        crossings.reduce(|first, next| if next.about < first.about { next } else { first })
    }

    /// The length of the step that ends on a crossing, if the crossing exists.
    fn landing(&mut self, Crossing { bond, beyond, .. }: Crossing<R>) -> Option<R> {
        let (start, end) = (self.bonds[bond].side * self.bonds[bond].start.0, self.towards(bond, beyond));
        if end >= R::zero() {
            return None;
        }
        if start <= R::zero() {
            return Some(R::zero());
        }
        Some(bracketed(|length| self.towards(bond, length), (R::zero(), start), (beyond, end)))
    }
}

impl<R: Real, S: ContactFlow<R>> Stepper<R> for Landed<R, S> {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn time(&self) -> R {
        self.time.value()
    }

    fn done(&self) -> bool {
        self.time == self.end
    }

    fn step(&mut self) -> Result<(), Error> {
        interrupt::check(self.time().f64())?;
        let near = R::of(TOGETHER) * self.h.value();
        let stop = self.breaks.or_end(self.time.value(), self.end);
        let left = stop - self.time;
        let full = if left.value() <= self.h.value() + near { left } else { self.h };
        self.from = self.time;
        self.before.copy_from(&self.flow);
        for bond in &mut self.bonds {
            (bond.start, bond.settled) = (bond.end, false);
        }
        let (mut length, mut target) = (full.value(), None);
        self.advance(length);
        // Each iteration settles one bond for this step.
        while let Some(crossing) = self.first_crossing(length) {
            let bond = crossing.bond;
            self.bonds[bond].settled = true;
            match self.landing(crossing) {
                // The event lies at the start of the step, where the last step has landed.
                Some(zero) if zero <= near => self.bonds[bond].side = -self.bonds[bond].side,
                Some(zero) => {
                    (length, target) = (zero, Some(bond));
                    self.stats.rejected += 1;
                    self.advance(length);
                }
                None => {}
            }
        }
        for (k, bond) in self.bonds.iter_mut().enumerate() {
            let (g, rate) = bond.end;
            let about_to = bond.side * rate < R::zero() && g.abs() <= near * rate.abs();
            if target == Some(k) || (target.is_some() && about_to) {
                bond.side = -bond.side;
            } else if g.abs() > self.band {
                bond.side = sign(g);
            }
        }
        self.time = if target.is_none() { self.from + full } else { self.from + DoubleDouble::new(length) };
        if target.is_none() && full == left {
            self.time = stop;
        }
        self.stats.steps += 1;
        Ok(())
    }

    /// For times inside the last step, one shorter step is made from its start.
    fn sample(&mut self, t: R, y: &mut [R]) {
        let reached = self.time.value();
        if (t - reached).abs() <= R::of(4.0) * R::epsilon() * t.abs() {
            self.flow.store(y);
            return;
        }
        self.mirror.copy_from(&self.before);
        let length = (DoubleDouble::new(t) - self.from).value();
        step(&mut self.mirror, &self.pairs, length, &mut self.stats);
        self.mirror.store(y);
    }

    fn stats(&self) -> Stats {
        self.stats
    }
}

/// One whole step.
fn step<R: Real, S: ContactFlow<R>>(flow: &mut S, pairs: &[Pair<R>], length: R, stats: &mut Stats) {
    let length = DoubleDouble::new(length);
    for &(kick, drift) in pairs {
        if kick == DoubleDouble::zero() {
            flow.drift(drift * length);
        } else {
            flow.kick_drift((kick * length).value(), drift * length);
            stats.force_evaluations += 1;
        }
    }
}

/// `1`, `-1` or `0`.
fn sign<R: Real>(x: R) -> R {
    if x == R::zero() { x } else { x.signum() }
}

/// Estimated time of a change of side in a step, and a time at which the bond is on the other side.
fn crossing<R: Real>(bond: &Bond<R>, length: R, band: R) -> Option<(R, R)> {
    let (zero, one) = (R::zero(), R::one());
    if bond.settled || bond.side == zero {
        return None;
    }
    let scaled = |(g, rate): (R, R)| (bond.side * g, bond.side * rate * length);
    let cubic = Cubic::new(scaled(bond.start), scaled(bond.end));
    let lowest = cubic.minimum().filter(|&s| zero < s && s < one && cubic.at(s) < -band);
    let beyond = lowest.or((bond.side * bond.end.0 < -band).then_some(one))?;
    let start = cubic.at(zero);
    let about = if start > zero { bracketed(|s| cubic.at(s), (zero, start), (beyond, cubic.at(beyond))) } else { zero };
    Some((about * length, beyond * length))
}

/// The cubic on `[0, 1]` with given values and slopes at the ends:
/// `c_0 + c_1 s + c_2 s^2 + c_3 s^3`.
pub struct Cubic<R>([R; 4]);

impl<R: Real> Cubic<R> {
    /// From value and slope at 0, and at 1.
    pub fn new((g0, r0): (R, R), (g1, r1): (R, R)) -> Self {
        let (two, three, rise) = (R::of(2.0), R::of(3.0), g1 - g0);
        Self([g0, r0, three * rise - two * r0 - r1, r0 + r1 - two * rise])
    }

    /// Its value at `s`.
    pub fn at(&self, s: R) -> R {
        let [c0, c1, c2, c3] = self.0;
        c0 + s * (c1 + s * (c2 + s * c3))
    }

    /// The position of its local minimum: the zero of `c_1 + 2 c_2 s + 3 c_3 s^2` at which the
    /// slope rises.
    pub fn minimum(&self) -> Option<R> {
        let [_, c1, c2, c3] = self.0;
        let discriminant = c2 * c2 - R::of(3.0) * c1 * c3;
        if discriminant < R::zero() {
            return None;
        }
        let root = discriminant.sqrt();
        // The form of the solution without cancellation.
        let s = if c2 > R::zero() { -c1 / (c2 + root) } else { (root - c2) / (R::of(3.0) * c3) };
        s.is_finite().then_some(s)
    }
}
