//! Branches of orbits: pseudo-arclength continuation.
//!
//! | symbol | meaning |
//! |---|---|
//! | `X = (Z/s, p/P)` | strains in units of their size `s` and `sqrt(2N)`, parameter in units `P` of the range asked for |
//! | `F(X) = 0` | the equations of the orbit ([`shooting`](super::Shooting)) |
//! | `t` | unit tangent of the branch, `F_X t = 0` |
//! | `ds` | length of the predictor `X + ds t`; the corrector solves `F(X) = 0` with `t . (X - predictor) = 0` |
//!
//! The parameter may turn back at a fold; the equations with the arclength stay regular there. Source: Keller 1977, in *Applications of
//! Bifurcation Theory*, pp. 359-384.

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

/// How a branch is followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Continuation {
    /// The parameter that varies.
    pub parameter: Parameter,
    /// Where it is to go.
    pub to: f64,
    /// Its largest change from point to point, positive.
    pub step: f64,
    /// Points at most.
    pub most_points: usize,
    /// Whether the parameter itself counts the way, in place of the arclength: such a branch ends at a fold.
    pub natural: bool,
    /// How orbits are solved for.
    pub shooting: Shooting,
}

/// Why a branch ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// The parameter is where it was to go.
    Reached,
    /// As many points as were asked for.
    MostPoints,
    /// It turned back and left by the side where it began.
    TurnedBack,
    /// No orbit at the shortest step.
    Lost,
    /// The eigenvalues of the next orbit did not converge.
    NoMultipliers,
}

/// `ds` at most: strains may change by half their size from point to point.
const LONGEST: f64 = 0.5;
/// `ds` at least, in units of the first one.
const SHORTEST: f64 = 1e-6;
/// Steps of the corrector at most, and the numbers that a good `ds` takes.
const MOST_CORRECTIONS: usize = 10;
const GOOD_CORRECTIONS: usize = 4;
const MANY_CORRECTIONS: usize = GOOD_CORRECTIONS + 1;
/// A correction below this is the last.
const LAST_CORRECTION: f64 = 1e-9;
/// Residuals above this, over the size of the strains, are no orbit.
const SOLVED: f64 = 1e-12;
/// Relative change of a parameter for differences of `F`.
const DIFFERENCE: f64 = 1e-6;

/// A point of a branch, and its tangent.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) orbit: Orbit,
    pub(super) tangent: DVector<f64>,
}

/// Scales of `X`.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    pub(super) strain: f64,
    pub(super) parameter: f64,
}

/// A branch as far as it was followed, and all that it takes to go on.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// How it is followed.
    pub continuation: Continuation,
    /// Its orbits, one at least, in their order along it.
    pub orbits: Vec<Orbit>,
    /// Length of the next predictor.
    pub ds: f64,
    /// Why it ended; `None` while it goes on.
    pub end: Option<End>,
    /// What its breathers are symmetric about, if they are breathers.
    pub center: Option<Center>,
    /// Collisions of multipliers of which no modulus above `1 + weak` comes are not located; no bifurcation is, if `None`.
    pub weak: Option<f64>,
}

impl Trail {
    /// The branch through `start`, not yet followed.
    ///
    /// # Errors
    /// Numbers of the continuation outside their rules.
    pub fn new(continuation: Continuation, start: Orbit) -> Result<Self> {
        let from = start.setting.get(continuation.parameter);
        continuation.validate(from)?;
        let ds = continuation.step / (continuation.to - from).abs();
        Ok(Self { continuation, orbits: vec![start], ds, end: None, center: None, weak: None })
    }

    /// Where it began, and where it is.
    fn ends(&self) -> Option<[&Orbit; 2]> {
        Some([self.orbits.first()?, self.orbits.last()?])
    }

    /// Asks it to go on: to another end, by other steps, up to another number of points. One that reached its end, or turned back,
    /// and is given no other end stays as it is.
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

    /// Follows it from its last orbit to where its parameter is to go; `seen` is told after every new orbit. A branch that was stopped on the way goes on
    /// with the same bits.
    ///
    /// # Errors
    /// Numbers outside their rules; [`Error::Stopped`] if the process was asked to end: the branch goes on from there. One that ends early is no error: it says why.
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
            // Told with the end: what is kept of a branch that is whole is whole.
            seen(self);
        };
        self.end = Some(end);
        Ok(end)
    }

    /// The next orbit, and the length of the predictor after it.
    fn next(&self, from: f64, direction: f64) -> Option<(Orbit, f64)> {
        let orbit = self.orbits.last()?;
        let scales = self.continuation.scales(orbit, from);
        // The tangent is on the side of the last step, or of the parameter's end.
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
    /// Checks its numbers.
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

    /// Follows the branch through `start` to where its parameter is to go; `seen` is told of every new orbit.
    ///
    /// # Errors
    /// Numbers outside their rules. A branch that ends early is no error: it says why.
    pub fn follow(&self, start: Orbit, mut seen: impl FnMut(&Orbit)) -> Result<(Vec<Orbit>, End)> {
        let mut trail = Trail::new(*self, start)?;
        let end = trail.extend(|trail| trail.orbits.last().into_iter().for_each(&mut seen))?;
        Ok((trail.orbits, end))
    }

    /// The next point beyond `place` by a predictor of length `ds`, or half of it, and so on; and the length for the one after it.
    fn next(&self, place: &Place, scales: Scales, direction: f64, ds: f64) -> Option<(Orbit, f64)> {
        let now = place.orbit.setting.get(self.parameter);
        let rate = place.tangent[place.tangent.len() - 1] * scales.parameter;
        let shortest = SHORTEST * self.step / scales.parameter;
        let mut ds = ds.min(LONGEST).min(self.step / rate.abs());
        loop {
            // The last step lands on the end.
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

    /// From one orbit to another.
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

    /// The unit tangent on the side of `before`.
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

    /// The next point, by arclength; and the steps of the corrector.
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
            // The hyperplane is the predictor's, and is never left.
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

    /// The orbit at the value `to` of the parameter, from the tangent; and the steps of Newton's method.
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
