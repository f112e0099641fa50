//! A leg, and the step lengths of a run.

use super::TimeMap;
use crate::{clock::DoubleDouble, dop853::step::Leap, events::sides::Crossing, real::Real, system::VectorField};

/// A field in the mapped variable: `dy/dsigma = tau'(sigma) f(t, y)`.
pub(super) struct Mapped<'a, R, F> {
    pub(super) field: &'a mut F,
    pub(super) map: TimeMap<R>,
    pub(super) origin: R,
}

impl<R: Real, F: VectorField<R>> VectorField<R> for Mapped<'_, R, F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    fn eval(&mut self, sigma: R, y: &[R], dy: &mut [R]) {
        self.field.eval(self.origin + self.map.at(sigma), y, dy);
        let rate = self.map.rate(sigma);
        for dy in dy {
            *dy *= rate;
        }
    }
}

/// A leg: its origin, its map, the present `sigma`, and the event expected at `sigma = 1`.
#[derive(Clone, Copy)]
pub(super) struct Leg<R> {
    pub(super) origin: DoubleDouble<R>,
    pub(super) map: TimeMap<R>,
    pub(super) sigma: R,
    pub(super) target: Option<Crossing>,
}

impl<R: Real> Leg<R> {
    pub(super) fn mapped<'a, F>(&self, field: &'a mut F) -> Mapped<'a, R, F> {
        Mapped { field, map: self.map, origin: self.origin.value() }
    }

    /// Time since the origin.
    pub(super) fn tau(&self) -> R {
        self.map.at(self.sigma)
    }

    /// Time since the origin at a share of a step.
    pub(super) fn tau_in(&self, leap: Leap<R>, share: f64) -> R {
        self.map.at(leap.from.value() + leap.h * R::of(share))
    }

    pub(super) fn time(&self, sigma: R) -> DoubleDouble<R> {
        self.origin + DoubleDouble::new(self.map.at(sigma))
    }

    pub(super) fn singular(&self) -> bool {
        self.map.powers() != (1, 1)
    }
}

/// Step lengths that the errors allow, in time and in the variable `s = tau^{1/q}` of singular
/// ends.
#[derive(Clone, Copy)]
pub(super) struct StepLengths<R> {
    pub(super) tau: R,
    pub(super) s: R,
}

impl<R: Real> StepLengths<R> {
    pub(super) fn of(&mut self, leg: &Leg<R>) -> &mut R {
        if leg.singular() { &mut self.s } else { &mut self.tau }
    }
}
