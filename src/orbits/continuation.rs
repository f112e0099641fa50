//! Branches of orbits: pseudo-arclength continuation.
//!
//! | symbol | meaning |
//! |---|---|
//! | `X = (Z/s, p/P)` | strains and parameter, scaled |
//! | `s, P` | `sqrt(2N) max abs(Z)` for `2N` strains, and the range of the parameter |
//! | `F(X) = 0` | the equations of the orbit ([`shooting`](super::Shooting)) |
//!
//! Predictor and corrector are those of `arclength`.

use super::{
    arclength::{
        self, BasePoint, BranchState, ContinuationOptions, End, FARTHEST, Family, MOST_CORRECTIONS, Scales, Solution,
    },
    setting::{Parameter, Setting},
    shooting::{Equations, NewtonStep, Orbit, Shooting},
};
use crate::{
    dps::Center,
    error::{Error, Result},
};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Settings of a continuation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Continuation {
    /// The parameter that varies.
    pub parameter: Parameter,
    /// The value of the parameter at which the branch ends.
    pub to: f64,
    /// The largest change of the parameter from point to point, positive.
    pub step: f64,
    /// Largest number of points.
    pub most_points: usize,
    /// Whether steps are taken in the parameter, not in the arclength; such a branch ends at a
    /// fold.
    pub natural: bool,
    /// How orbits are solved for.
    pub shooting: Shooting,
}

/// Largest residual of an orbit, in units of the largest strain.
const SOLVED: f64 = 1e-12;

/// A point of a branch, and its tangent.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) orbit: Orbit,
    pub(super) tangent: DVector<f64>,
}

/// The orbits of settings that differ in one parameter.
struct Varying<'a> {
    continuation: &'a Continuation,
    setting: Setting,
}

impl Varying<'_> {
    fn at(&self, p: f64) -> Setting {
        self.setting.with(self.continuation.parameter, p)
    }

    fn orbit(&self, Solution { z, p, residual, newton }: Solution) -> Orbit {
        Orbit { setting: self.at(p), z, residual, newton }
    }
}

impl Family for Varying<'_> {
    fn equations(&self, z: &[f64], p: f64, derivative: bool) -> Result<Equations> {
        self.continuation.shooting.equations(&self.at(p), z, derivative)
    }

    fn solve(&self, seed: &[f64], p: f64) -> Result<Solution> {
        let shooting = Shooting { most_steps: MOST_CORRECTIONS, ..self.continuation.shooting };
        let Orbit { z, residual, newton, .. } = shooting.solve(&self.at(p), seed)?;
        Ok(Solution { z, p, residual, newton })
    }

    /// Steps in the mass ratio are long where these branches bend: only what would be a jump with
    /// the shortest step is one.
    fn strays(&self, chord: f64, predictor: f64, _newton: &[NewtonStep]) -> bool {
        chord > FARTHEST * predictor
    }

    fn solved(&self, _z: &[f64], _p: f64) -> f64 {
        SOLVED
    }
}

/// A branch up to its last orbit, with everything needed to continue it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// How the branch is followed.
    pub continuation: Continuation,
    /// The orbits, at least one, in their order along the branch.
    pub orbits: Vec<Orbit>,
    /// Length of the next predictor.
    pub ds: f64,
    /// Why the branch ended; `None` while it can continue.
    pub end: Option<End>,
    /// Symmetry of the breathers, if the orbits are breathers.
    pub center: Option<Center>,
    /// Bound for collisions of multipliers: those that lead to no modulus above `1 + weak` are not
    /// located. `None`: no bifurcations are located.
    pub weak: Option<f64>,
}

impl Trail {
    /// A branch that has only its first orbit, `start`.
    ///
    /// # Errors
    /// Numbers of the continuation outside their rules.
    pub fn new(continuation: Continuation, start: Orbit) -> Result<Self> {
        let from = start.setting.get(continuation.parameter);
        continuation.validate(from)?;
        let ds = continuation.step / (continuation.to - from).abs();
        Ok(Self { continuation, orbits: vec![start], ds, end: None, center: None, weak: None })
    }

    /// The first and the last orbit.
    fn ends(&self) -> Option<[&Orbit; 2]> {
        Some([self.orbits.first()?, self.orbits.last()?])
    }

    /// Changes the settings so that the branch can continue: the end, the step and the largest
    /// number of points.
    ///
    /// A branch that reached its end or turned back stays as it is unless another end is given.
    ///
    /// # Errors
    /// An end that is not beyond the last point, seen from the first; numbers outside their rules.
    pub fn onward(mut self, to: Option<f64>, step: Option<f64>, most_points: usize) -> Result<Self> {
        let whole = to.is_none() && self.end.is_some_and(End::is_complete);
        let Continuation { parameter, to: old, step: by, .. } = self.continuation;
        let (to, step) = (to.unwrap_or(old), step.unwrap_or(by));
        self.continuation = Continuation { to, step, most_points, ..self.continuation };
        let Some([from, last]) = self.ends().map(|ends| ends.map(|orbit| orbit.setting.get(parameter))) else {
            return Err(Error::parameter("orbits", 0, "at least one"));
        };
        self.continuation.validate(from)?;
        if !whole {
            arclength::check_onward([from, last], to)?;
            self.end = None;
        }
        Ok(self)
    }

    /// Follows the branch from its last orbit to the final value of the parameter.
    ///
    /// `seen` is called after every new orbit. A branch that was stopped on the way continues with
    /// the same bits.
    ///
    /// # Errors
    /// Numbers outside their rules; [`Error::Stopped`] if the process was asked to end, after which
    /// the branch can continue. A branch that ends early is not an error: the [`End`] says why.
    pub fn extend(&mut self, mut seen: impl FnMut(&Self)) -> Result<End> {
        let (continuation, Some([first, last])) = (self.continuation, self.ends()) else {
            return Err(Error::parameter("orbits", 0, "at least one"));
        };
        let Continuation { parameter, to, step, most_points, natural, .. } = continuation;
        let place = |orbit: &Orbit| (orbit.z.clone(), orbit.setting.get(parameter));
        let back = first.setting.get(parameter);
        continuation.validate(back)?;
        let previous = self.orbits.iter().rev().nth(1).map(place);
        let course = BranchState { back, previous, last: place(last), ds: self.ds, points: self.orbits.len() };
        let way = ContinuationOptions { to, step, natural, direction: (to - back).signum() };
        let family = continuation.varying(first.setting);
        self.end = None;
        let end = arclength::follow(&family, course, way, most_points, &mut |solution, ds, end| {
            self.orbits.push(family.orbit(solution.clone()));
            // `end` is set before the call, so that a branch saved by `seen` has it.
            (self.ds, self.end) = (ds, end);
            seen(self);
            Ok(None)
        })?;
        self.end = Some(end);
        Ok(end)
    }
}

impl Continuation {
    pub(super) fn validate(&self, from: f64) -> Result<()> {
        arclength::check([from, self.to], self.step, self.most_points)
    }

    /// Follows the branch from `start` to the final value of the parameter; `seen` is called with
    /// every new orbit.
    ///
    /// # Errors
    /// As [`Trail::extend`].
    pub fn follow(&self, start: Orbit, mut seen: impl FnMut(&Orbit)) -> Result<(Vec<Orbit>, End)> {
        let mut trail = Trail::new(*self, start)?;
        let end = trail.extend(|trail| trail.orbits.last().into_iter().for_each(&mut seen))?;
        Ok((trail.orbits, end))
    }

    fn varying(&self, setting: Setting) -> Varying<'_> {
        Varying { continuation: self, setting }
    }

    fn spot<'a>(&self, place: &'a Place) -> BasePoint<'a> {
        let Place { orbit, tangent } = place;
        BasePoint { z: &orbit.z, p: orbit.setting.get(self.parameter), tangent }
    }

    pub(super) fn scales(&self, orbit: &Orbit, from: f64) -> Scales {
        Scales::new(&orbit.z, (self.to - from).abs())
    }

    /// The unit tangent with a positive product with `before`.
    pub(super) fn tangent(&self, orbit: &Orbit, scales: Scales, before: &DVector<f64>) -> Result<DVector<f64>> {
        let family = self.varying(orbit.setting);
        arclength::tangent(&family, (&orbit.z, orbit.setting.get(self.parameter)), scales, before)
    }

    /// The orbit that the corrector finds at the distance `ds` along the tangent of `place`.
    pub(super) fn step(&self, place: &Place, scales: Scales, ds: f64) -> Result<Orbit> {
        let family = self.varying(place.orbit.setting);
        Ok(family.orbit(arclength::correct(&family, self.spot(place), scales, ds)?))
    }
}
