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
    error::{Error, Result},
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
/// Steps of the corrector at most, and the number that a good `ds` takes.
const MOST_CORRECTIONS: usize = 10;
const GOOD_CORRECTIONS: usize = 4;
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

impl Continuation {
    /// Checks its numbers.
    fn validate(&self, from: f64) -> Result<()> {
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
        let from = start.setting.get(self.parameter);
        self.validate(from)?;
        let direction = (self.to - from).signum();
        let mut tangent = DVector::zeros(start.z.len() + 1);
        tangent[start.z.len()] = direction;
        let mut place = Place { orbit: start, tangent };
        let mut orbits = vec![place.orbit.clone()];
        let first = self.step / (self.to - from).abs();
        let mut ds = first;
        let end = loop {
            let now = place.orbit.setting.get(self.parameter);
            if orbits.len() >= self.most_points {
                break End::MostPoints;
            }
            let scales = self.scales(&place.orbit, from);
            let Ok(tangent) = self.tangent(&place.orbit, scales, &place.tangent) else { break End::Lost };
            place.tangent = tangent;
            let rate = place.tangent[place.tangent.len() - 1] * scales.parameter;
            ds = ds.min(LONGEST).min(self.step / rate.abs());
            // The last step lands on the end.
            let left = self.to - now;
            let lands = rate * direction > 0.0 && left.abs() <= 1.001 * (rate * ds).abs();
            let next = if lands || self.natural {
                let to = if lands { self.to } else { now + rate.abs() * ds * direction };
                self.naturally(&place, scales, to)
            } else {
                self.step(&place, scales, ds)
            };
            match next {
                Ok((orbit, corrections)) => {
                    seen(&orbit);
                    let reached = lands || (orbit.setting.get(self.parameter) - self.to) * direction >= 0.0;
                    let back = (orbit.setting.get(self.parameter) - from) * direction < 0.0;
                    orbits.push(orbit.clone());
                    place.orbit = orbit;
                    if reached || back {
                        break if reached { End::Reached } else { End::TurnedBack };
                    }
                    ds *= if corrections < GOOD_CORRECTIONS {
                        1.5
                    } else if corrections > GOOD_CORRECTIONS + 1 {
                        0.6
                    } else {
                        1.0
                    };
                }
                Err(_) if ds > SHORTEST * first => ds *= 0.5,
                Err(_) => break End::Lost,
            }
        };
        Ok((orbits, end))
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
