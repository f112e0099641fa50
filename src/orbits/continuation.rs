//! Branches of orbits: pseudo-arclength continuation.
//!
//! | symbol | meaning |
//! |---|---|
//! | `X = (Z/s, p/P)` | strains and parameter, scaled |
//! | `s, P` | `sqrt(2N) max abs(Z)` for `2N` strains, and the range of the parameter |
//! | `F(X) = 0` | the equations of the orbit ([`shooting`](super::Shooting)) |
//! | `t` | unit tangent of the branch, `F_X t = 0` |
//! | `ds` | length of the predictor `X + ds t` |
//!
//! The corrector solves `F(X) = 0` with `t . (X - predictor) = 0`. At a fold the parameter turns
//! back; the equations with the arclength stay regular there. Source: Keller 1977, in *Applications
//! of Bifurcation Theory*, pp. 359-384.

use super::{
    setting::{Parameter, Setting},
    shooting::{Equations, NewtonStep, Orbit, Shooting, least_squares},
};
use crate::{
    chain::max_norm,
    dps::Center,
    error::{Error, Result},
    interrupt,
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
    /// Whether the branch is followed in the parameter itself, not in arclength; such a branch ends
    /// at a fold.
    pub natural: bool,
    /// How orbits are solved for.
    pub shooting: Shooting,
}

/// The reason why a branch ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// The parameter has its final value.
    Reached,
    /// The branch has the largest number of points.
    MostPoints,
    /// The branch turned back and the parameter passed its first value.
    TurnedBack,
    /// No orbit was found with the shortest step.
    Lost,
    /// The multipliers of the last orbit are not known.
    NoMultipliers,
}

impl End {
    /// The reason in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reached => "the parameter has its final value",
            Self::MostPoints => "it has the largest number of points",
            Self::TurnedBack => "it turned back and passed its first value",
            Self::Lost => "no orbit was found with the shortest step",
            Self::NoMultipliers => "the multipliers of its last orbit are not known",
        }
    }
}

/// Largest `ds`: strains may change by half their size from point to point.
const LONGEST: f64 = 0.5;
/// Smallest `ds`, in units of the first one.
const SHORTEST: f64 = 1e-6;
/// Largest number of corrector steps; `ds` grows below `GOOD_CORRECTIONS` of them, and shrinks
/// above `MANY_CORRECTIONS`.
const MOST_CORRECTIONS: usize = 10;
const GOOD_CORRECTIONS: usize = 4;
const MANY_CORRECTIONS: usize = GOOD_CORRECTIONS + 1;
/// A correction below this is the last one.
const LAST_CORRECTION: f64 = 1e-9;
/// Largest residual of an orbit, in units of the largest strain.
const SOLVED: f64 = 1e-12;
/// Relative change of the parameter for difference quotients of `F`.
const DIFFERENCE: f64 = 1e-6;

/// A point of a branch, and its tangent.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) orbit: Orbit,
    pub(super) tangent: DVector<f64>,
}

/// Units of `X`: `s` and `P`.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    pub(super) strain: f64,
    pub(super) parameter: f64,
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
        let whole = to.is_none() && matches!(self.end, Some(End::Reached | End::TurnedBack));
        let Continuation { parameter, to: old, step: by, .. } = self.continuation;
        let (to, step) = (to.unwrap_or(old), step.unwrap_or(by));
        self.continuation = Continuation { to, step, most_points, ..self.continuation };
        let Some([from, last]) = self.ends().map(|ends| ends.map(|orbit| orbit.setting.get(parameter))) else {
            return Err(Error::parameter("orbits", 0, "at least one"));
        };
        self.continuation.validate(from)?;
        if !whole {
            if (to - last) * (to - from) <= 0.0 || (last - from) * (to - from) < 0.0 {
                return Err(Error::parameter("to", to, "a branch goes on beyond its last point, seen from its first"));
            }
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
        let Continuation { parameter, to, most_points, .. } = self.continuation;
        let Some([first, _]) = self.ends() else { return Err(Error::parameter("orbits", 0, "at least one")) };
        let from = first.setting.get(parameter);
        self.continuation.validate(from)?;
        let direction = (to - from).signum();
        self.end = None;
        let end = loop {
            if let Some(end) = self.end {
                break end;
            }
            if self.orbits.len() >= most_points {
                break End::MostPoints;
            }
            if interrupt::asked() {
                return Err(Error::Stopped { kept: format!("{} points of the branch", self.orbits.len()) });
            }
            let Some((orbit, ds)) = self.next(from, direction) else { break End::Lost };
            let p = orbit.setting.get(parameter);
            self.orbits.push(orbit);
            self.ds = ds;
            let back = (p - from) * direction < 0.0;
            self.end = if (p - to) * direction >= 0.0 { Some(End::Reached) } else { back.then_some(End::TurnedBack) };
            // `end` is set before the call, so that a branch saved by `seen` has it.
            seen(self);
        };
        self.end = Some(end);
        Ok(end)
    }

    /// The next orbit, and the length of the predictor after it.
    fn next(&self, from: f64, direction: f64) -> Option<(Orbit, f64)> {
        let orbit = self.orbits.last()?;
        let scales = self.continuation.scales(orbit, from);
        // The tangent points along the last step or, at the first orbit, towards the final value of
        // the parameter.
        let before = match &self.orbits[..] {
            [.., a, b] => self.continuation.chord(a, b, scales).normalize(),
            _ => {
                let mut along = DVector::zeros(orbit.z.len() + 1);
                along[orbit.z.len()] = direction;
                along
            }
        };
        let tangent = self.continuation.tangent(orbit, scales, &before).ok()?;
        self.continuation.next(&Place { orbit: orbit.clone(), tangent }, scales, direction, self.ds)
    }
}

impl Continuation {
    pub(super) fn validate(&self, from: f64) -> Result<()> {
        if !self.to.is_finite() || self.to == from {
            return Err(Error::parameter("to", self.to, "a finite number, not where the branch begins"));
        }
        if !(self.step.is_finite() && self.step > 0.0) {
            return Err(Error::parameter("step", self.step, "finite and positive"));
        }
        if self.most_points < 2 {
            return Err(Error::parameter("points", self.most_points, "at least two"));
        }
        Ok(())
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

    /// The next point after `place`, and the length `ds` for the point after it.
    ///
    /// The predictor has the length `ds` at first; the length is halved until the corrector
    /// converges.
    fn next(&self, place: &Place, scales: Scales, direction: f64, ds: f64) -> Option<(Orbit, f64)> {
        let now = place.orbit.setting.get(self.parameter);
        let rate = place.tangent[place.tangent.len() - 1] * scales.parameter;
        let shortest = SHORTEST * self.step / scales.parameter;
        let mut ds = ds.min(LONGEST).min(self.step / rate.abs());
        loop {
            // The last step ends at the final value.
            let lands = rate * direction > 0.0 && (self.to - now).abs() <= 1.001 * (rate * ds).abs();
            let next = if lands || self.natural {
                let to = if lands { self.to } else { now + rate.abs() * ds * direction };
                self.naturally(place, scales, to)
            } else {
                self.step(place, scales, ds)
            };
            match next {
                Ok((orbit, corrections)) => {
                    let factor = match corrections {
                        ..GOOD_CORRECTIONS => 1.5,
                        GOOD_CORRECTIONS | MANY_CORRECTIONS => 1.0,
                        _ => 0.6,
                    };
                    return Some((orbit, ds * factor));
                }
                Err(_) if ds > shortest => ds *= 0.5,
                Err(_) => return None,
            }
        }
    }

    /// The difference of two orbits in the units of `X`.
    pub(super) fn chord(&self, a: &Orbit, b: &Orbit, scales: Scales) -> DVector<f64> {
        let along = (b.setting.get(self.parameter) - a.setting.get(self.parameter)) / scales.parameter;
        let chord = a.z.iter().zip(&b.z).map(|(a, b)| (b - a) / scales.strain);
        DVector::from_iterator(a.z.len() + 1, chord.chain([along]))
    }

    pub(super) fn scales(&self, orbit: &Orbit, from: f64) -> Scales {
        let root = (orbit.z.len() as f64).sqrt();
        Scales { strain: max_norm(orbit.z.iter().copied()) * root, parameter: (self.to - from).abs() }
    }

    /// `F` and `[F_Z s, F_p P]` at an orbit.
    fn extended(&self, setting: &Setting, z: &[f64], scales: Scales) -> Result<Equations> {
        let Equations { residual, jacobian } = self.shooting.equations(setting, z, true)?;
        let (p, columns) = (setting.get(self.parameter), z.len());
        let by = DIFFERENCE * p.abs().max(scales.parameter);
        let at = |p: f64| self.shooting.equations(&setting.with(self.parameter, p), z, false);
        let slope = (at(p + by)?.residual - at(p - by)?.residual) / (2.0 * by);
        let mut jacobian = (jacobian * scales.strain).insert_column(columns, 0.0);
        jacobian.set_column(columns, &(slope * scales.parameter));
        Ok(Equations { residual, jacobian })
    }

    /// The unit tangent with a positive product with `before`.
    pub(super) fn tangent(&self, orbit: &Orbit, scales: Scales, before: &DVector<f64>) -> Result<DVector<f64>> {
        let Equations { residual, jacobian } = self.extended(&orbit.setting, &orbit.z, scales)?;
        let rows = residual.len();
        let mut bordered = jacobian.insert_row(rows, 0.0);
        bordered.set_row(rows, &before.transpose());
        let mut right = DVector::zeros(rows + 1);
        right[rows] = 1.0;
        let tangent = least_squares(bordered, &right).ok_or(Error::Stalled { steps: 0, best: None })?;
        Ok(tangent.normalize())
    }

    /// The next point by arclength, and the number of corrector steps.
    pub(super) fn step(&self, place: &Place, scales: Scales, ds: f64) -> Result<(Orbit, usize)> {
        let columns = place.orbit.z.len();
        let t = &place.tangent;
        let mut z = DVector::from_column_slice(&place.orbit.z) + t.rows(0, columns) * (ds * scales.strain);
        let mut setting = place.orbit.setting;
        setting = setting.with(self.parameter, setting.get(self.parameter) + ds * t[columns] * scales.parameter);
        let (mut newton, mut before) = (Vec::new(), f64::INFINITY);
        loop {
            let Equations { residual, jacobian } = self.extended(&setting, z.as_slice(), scales)?;
            let rows = residual.len();
            let mut bordered = jacobian.insert_row(rows, 0.0);
            bordered.set_row(rows, &t.transpose());
            let size = z.amax();
            let relative = residual.amax() / size;
            let stalled = Error::Stalled { steps: newton.len(), best: None };
            // All iterates are in the hyperplane of the predictor: its equation has the residual
            // zero.
            let Some(by) = least_squares(bordered, &residual.push(0.0)) else { return Err(stalled) };
            let step = by.norm();
            newton.push(NewtonStep { residual: relative, step });
            z -= by.rows(0, columns) * scales.strain;
            setting = setting.with(self.parameter, setting.get(self.parameter) - by[columns] * scales.parameter);
            if step <= LAST_CORRECTION {
                let residual = self.shooting.equations(&setting, z.as_slice(), false)?.residual.amax() / z.amax();
                let corrections = newton.len();
                let orbit = Orbit { setting, z: z.as_slice().to_vec(), residual, newton };
                return if residual <= SOLVED { Ok((orbit, corrections)) } else { Err(stalled) };
            }
            if newton.len() >= MOST_CORRECTIONS || step > LONGEST && step > before {
                return Err(stalled);
            }
            before = step;
        }
    }

    /// The orbit at the value `to` of the parameter, and the number of steps of Newton's method;
    /// the guess is on the tangent.
    pub(super) fn naturally(&self, place: &Place, scales: Scales, to: f64) -> Result<(Orbit, usize)> {
        let columns = place.orbit.z.len();
        let by = (to - place.orbit.setting.get(self.parameter)) / (place.tangent[columns] * scales.parameter);
        let z: Vec<f64> = place.orbit.z.iter().zip(&place.tangent).map(|(z, t)| z + by * t * scales.strain).collect();
        let shooting = Shooting { most_steps: MOST_CORRECTIONS, ..self.shooting };
        let orbit = shooting.solve(&place.orbit.setting.with(self.parameter, to), &z)?;
        let corrections = orbit.newton.len();
        Ok((orbit, corrections))
    }
}
