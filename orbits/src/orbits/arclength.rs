//! Predictor and corrector of pseudo-arclength continuation, for equations with one parameter.
//!
//! | symbol | meaning |
//! |---|---|
//! | `X = (z/s, p/P)` | unknowns and parameter, scaled |
//! | `F(X) = 0` | the equations |
//! | `t` | unit tangent of the branch, `F_X t = 0` |
//! | `ds` | length of the predictor `X + ds t` |
//!
//! The corrector solves `F(X) = 0` with `t . (X - predictor) = 0`. At a fold the parameter turns
//! back; the equations with the arclength stay regular there. Source: Keller 1977, in *Applications
//! of Bifurcation Theory*, pp. 359-384.

use super::shooting::{Equations, NewtonStep, Orbit, least_squares};
use crate::{
    chain::max_norm,
    error::{Error, Result, positive, require},
    interrupt,
    named::named,
    numerics::unit,
};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Largest `ds`: the predictor changes the unknowns by at most half of the largest one, in the root
/// mean square. The corrector gives up after a correction that is longer than this and than the
/// one before it.
const LONGEST: f64 = 0.5;
/// Least unit of unknowns, in units of their last change. Above 2, so that unknowns in proportion
/// to the parameter pass through zero.
const THROUGH: f64 = 3.0;
/// Smallest `ds`, in units of the first one.
const SHORTEST: f64 = 1e-6;
/// Longest chord to the next point, in units of the predictor: the chord is 25 degrees from the
/// tangent.
const TURN: f64 = 1.1;
/// Longest chord that is not a jump, in units of the shortest predictor: a branch may have a
/// corner.
pub const FARTHEST: f64 = 4.0;
/// Largest second correction of Newton's method, in units of the first one. Where corrections
/// contract more slowly, Newton's method may lead to a solution far from its start (Deuflhard 2011,
/// *Newton Methods for Nonlinear Problems*, Sec. 5.1).
const CONTRACTION: f64 = 0.5;
/// Largest number of steps of the corrector. The next `ds` is longer if it took fewer than
/// `GOOD_CORRECTIONS`, and shorter if it took more than `MANY_CORRECTIONS`.
pub const MOST_CORRECTIONS: usize = 10;
const GOOD_CORRECTIONS: usize = 4;
const MANY_CORRECTIONS: usize = GOOD_CORRECTIONS + 1;
/// A correction below this, in units of `X`, is the last one.
const LAST_CORRECTION: f64 = 1e-9;
/// Relative change of the parameter for difference quotients of `F`.
const DIFFERENCE: f64 = 1e-6;

/// Equations `F(z, p) = 0` with a parameter.
pub trait Family {
    /// `F`, and its derivative by `z` if `derivative`; otherwise the Jacobian has no columns.
    fn equations(&self, z: &[f64], p: f64, derivative: bool) -> Result<Equations>;
    /// A solution at this value of the parameter, by at most [`MOST_CORRECTIONS`] steps of Newton's
    /// method from `seed`.
    fn solve(&self, seed: &[f64], p: f64) -> Result<Solution>;
    /// Unit of residuals: by default the largest unknown. It is larger where rounding errors are
    /// those of larger numbers.
    fn size(&self, z: &[f64], _p: f64) -> f64 {
        max_norm(z.iter().copied())
    }
    /// Least unit of unknowns, where they may be nearly zero: by default none.
    fn least(&self, _z: &[f64]) -> f64 {
        0.0
    }
    /// Whether a solution may be one of another branch, from the chord to it, the predictor and
    /// Newton's corrections; the step is then halved. By default as [`strays`].
    fn strays(&self, chord: f64, predictor: f64, newton: &[NewtonStep]) -> bool {
        strays(chord, predictor, newton)
    }
    /// Largest residual of a solution, in units of [`size`](Self::size).
    fn solved(&self, z: &[f64], p: f64) -> f64;
}

/// A solution, with its residual in its unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solution {
    /// The unknowns.
    pub z: Vec<f64>,
    /// The parameter.
    pub p: f64,
    /// The residual.
    pub residual: f64,
    /// Steps of Newton's method.
    pub newton: Vec<NewtonStep>,
}

impl Solution {
    /// The orbit of a setting whose unknowns these are.
    pub fn orbit<S>(&self, setting: S) -> Orbit<S> {
        Orbit { setting, z: self.z.clone(), residual: self.residual, newton: self.newton.clone() }
    }
}

impl<S> Orbit<S> {
    /// The orbit as a solution at a value of the parameter.
    pub fn solution(&self, p: f64) -> Solution {
        Solution { z: self.z.clone(), p, residual: self.residual, newton: self.newton.clone() }
    }
}

/// A point of a branch, and its tangent.
#[derive(Clone, Copy)]
pub(super) struct BasePoint<'a> {
    pub(super) z: &'a [f64],
    pub(super) p: f64,
    pub(super) tangent: &'a DVector<f64>,
}

named! {
    /// The reason why a branch ended.
    pub enum End {
        /// The parameter has its final value.
        Reached = "reached", "the parameter has its final value";
        /// The branch has the largest number of points.
        MostPoints = "most-points", "it has the largest number of points";
        /// The branch turned back and the parameter passed its first value. For a branch that was
        /// begun where it crosses another one, that is the first value of the other branch.
        TurnedBack = "turned-back", "it turned back and passed the first value";
        /// No orbit was found with the shortest step.
        Lost = "lost", "no orbit was found with the shortest step";
        /// Newton's method leads to an orbit of another branch, also with the shortest step.
        Jumped = "jumped", "Newton's method leads to another branch, also with the shortest step";
        /// The branch of doubled period came back to the branch of half its period.
        Rejoined = "rejoined", "it came back to the branch of half its period";
        /// The orbits vanish: beyond this point are those of the opposite phase.
        AtRest = "at-rest", "beyond its last point its orbits vanish: the chain is at rest";
        /// No contact of a wave closes any more: every wave of frequency `omega` without contacts
        /// follows.
        NoContact = "no-contact", "no contact closes any more, and the frequency is omega";
        /// The waves vanish: contacts no longer change their frequency `omega`.
        Vanished = "vanished", "its waves vanish where their frequency is omega";
        /// The multipliers of the last orbit are not known.
        NoMultipliers = "no-multipliers", "the multipliers of its last orbit are not known";
        /// The process was asked to end.
        Stopped = "stopped", "the process was asked to end";
    }
    /// The reason in words.
    pub fn words
}

impl End {
    /// Whether the branch was followed as far as it goes.
    pub fn is_complete(self) -> bool {
        matches!(self, Self::Reached | Self::TurnedBack | Self::Rejoined | Self::AtRest | Self::NoContact)
    }

    /// The end of a branch with multipliers, from that of its orbits, `None` while they can go on;
    /// `whole` if the multipliers of all orbits are known.
    pub fn with_multipliers(orbits: Option<Self>, whole: bool) -> Self {
        match orbits {
            Some(end) if whole => end,
            _ if interrupt::asked() => Self::Stopped,
            None if whole => Self::MostPoints,
            _ => Self::NoMultipliers,
        }
    }
}

/// Units of `X`.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    /// `s`, the unit of the unknowns.
    pub(super) state: f64,
    /// `P`, the unit of the parameter.
    pub(super) parameter: f64,
}

/// How far a branch is followed, and in which steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The value of the parameter at which the branch ends.
    pub to: f64,
    /// The largest change of the parameter from point to point, positive.
    pub step: f64,
    /// Largest number of points.
    pub most_points: usize,
}

impl Scales {
    /// Units for unknowns as large as those in `z`, and for a parameter that varies by `range`.
    pub(super) fn new(z: &[f64], range: f64) -> Self {
        let root = (z.len() as f64).sqrt();
        Self { state: max_norm(z.iter().copied()) * root, parameter: range }
    }

    /// The same with this unit of unknowns, if it is larger.
    fn at_least(self, state: f64) -> Self {
        Self { state: self.state.max(state), ..self }
    }

    /// The power of 2^8 next to `s`: rows of equations and that of the arclength have one unit.
    fn rows(self) -> f64 {
        unit(self.state)
    }

    /// The difference of two points in the units of `X`.
    pub(super) fn chord(self, (a, p): (&[f64], f64), (b, q): (&[f64], f64)) -> DVector<f64> {
        let along = (q - p) / self.parameter;
        let chord = a.iter().zip(b).map(|(a, b)| (b - a) / self.state);
        DVector::from_iterator(a.len() + 1, chord.chain([along]))
    }
}

/// Refuses numbers outside their rules, for a continuation from one value of the parameter to
/// another.
pub fn check([from, to]: [f64; 2], step: f64, most_points: usize) -> Result<()> {
    require(to.is_finite() && to != from, "to", to, "a finite number, not where the branch begins")?;
    positive("step", step)?;
    require(most_points >= 2, "max-points", most_points, "at least 2")?;
    Ok(())
}

/// Refuses a final value that is not beyond the last value of the parameter, seen from the first.
pub(super) fn check_onward([from, last]: [f64; 2], to: f64) -> Result<()> {
    let onward = (to - last) * (to - from) > 0.0 && (last - from) * (to - from) >= 0.0;
    require(onward, "to", to, "a branch goes on beyond its last point, seen from its first")
}

/// The unit vector along the parameter, with the sign `direction`: the direction of a branch of so
/// many `unknowns` at its first point.
fn along(unknowns: usize, direction: f64) -> DVector<f64> {
    let mut along = DVector::zeros(unknowns + 1);
    along[unknowns] = direction;
    along
}

/// `F/r` and `[F_z s, F_p P]/r` with the unit `r` of [`Scales::rows`].
pub(super) fn extended(family: &dyn Family, z: &[f64], p: f64, scales: Scales) -> Result<Equations> {
    let Equations { residual, jacobian } = family.equations(z, p, true)?;
    let columns = z.len();
    let by = DIFFERENCE * p.abs().max(scales.parameter);
    let at = |p: f64| family.equations(z, p, false);
    let slope = (at(p + by)?.residual - at(p - by)?.residual) / (2.0 * by);
    let mut jacobian = (jacobian * (scales.state / scales.rows())).insert_column(columns, 0.0);
    jacobian.set_column(columns, &(slope * (scales.parameter / scales.rows())));
    Ok(Equations { residual: residual / scales.rows(), jacobian })
}

/// The unit tangent with a positive product with `before`.
pub(super) fn tangent(
    family: &dyn Family,
    (z, p): (&[f64], f64),
    scales: Scales,
    before: &DVector<f64>,
) -> Result<DVector<f64>> {
    let Equations { residual, jacobian } = extended(family, z, p, scales)?;
    let rows = residual.len();
    let mut bordered = jacobian.insert_row(rows, 0.0);
    bordered.set_row(rows, &before.transpose());
    let mut right = DVector::zeros(rows + 1);
    right[rows] = 1.0;
    let tangent = least_squares(bordered, &right).ok_or(Error::Stalled { steps: 0, best: None })?;
    Ok(tangent.normalize())
}

/// The solution in the hyperplane that is orthogonal to the tangent at the distance `ds` from
/// `base`, by Newton's method from the predictor.
pub(super) fn correct(family: &dyn Family, base: BasePoint<'_>, scales: Scales, ds: f64) -> Result<Solution> {
    let columns = base.z.len();
    let t = base.tangent;
    let mut z = DVector::from_column_slice(base.z) + t.rows(0, columns) * (ds * scales.state);
    let mut p = base.p + ds * t[columns] * scales.parameter;
    let (mut newton, mut before) = (Vec::new(), f64::INFINITY);
    loop {
        let Equations { residual, jacobian } = extended(family, z.as_slice(), p, scales)?;
        let rows = residual.len();
        let mut bordered = jacobian.insert_row(rows, 0.0);
        bordered.set_row(rows, &t.transpose());
        let relative = residual.amax() * scales.rows() / family.size(z.as_slice(), p);
        let stalled = Error::Stalled { steps: newton.len(), best: None };
        // All iterates are in the hyperplane of the predictor: its equation has the residual zero.
        let Some(by) = least_squares(bordered, &residual.push(0.0)) else { return Err(stalled) };
        let step = by.norm();
        newton.push(NewtonStep { residual: relative, step });
        z -= by.rows(0, columns) * scales.state;
        p -= by[columns] * scales.parameter;
        if step <= LAST_CORRECTION {
            let z = z.as_slice();
            let residual = family.equations(z, p, false)?.residual.amax() / family.size(z, p);
            let solution = Solution { z: z.to_vec(), p, residual, newton };
            return if residual <= family.solved(&solution.z, p) { Ok(solution) } else { Err(stalled) };
        }
        if newton.len() >= MOST_CORRECTIONS || step > LONGEST && step > before {
            return Err(stalled);
        }
        before = step;
    }
}

/// The solution at the value `to` of the parameter. The initial guess is the point of the tangent
/// with this value.
fn naturally(family: &dyn Family, base: BasePoint<'_>, scales: Scales, to: f64) -> Result<Solution> {
    let by = (to - base.p) / (base.tangent[base.z.len()] * scales.parameter);
    let z: Vec<f64> = base.z.iter().zip(base.tangent).map(|(z, t)| z + by * t * scales.state).collect();
    family.solve(&z, to)
}

/// Whether a solution may be one of another branch, or beyond a fold: the chord to it is much
/// longer than the predictor, or Newton's corrections do not contract from the first one on.
pub fn strays(chord: f64, predictor: f64, newton: &[NewtonStep]) -> bool {
    let slow = |first: f64, second: f64| second > CONTRACTION * first && second > LAST_CORRECTION;
    chord > TURN * predictor + LAST_CORRECTION || matches!(newton, [first, second, ..] if slow(first.step, second.step))
}

/// The next point after `base`, and the length `ds` for the point after it; otherwise why the
/// branch ends.
///
/// The predictor has the length `ds` at first; the length is halved until the corrector converges
/// to a point that does not [stray](strays).
pub(super) fn next(
    family: &dyn Family,
    base: BasePoint<'_>,
    scales: Scales,
    Range { to, step, .. }: Range,
    (direction, ds): (f64, f64),
) -> std::result::Result<(Solution, f64), End> {
    let mut tangent = base.tangent.clone();
    let rate = |tangent: &DVector<f64>| tangent[tangent.len() - 1] * scales.parameter;
    let shortest = SHORTEST * step / scales.parameter;
    let mut ds = ds.min(LONGEST).min(step / rate(&tangent).abs());
    loop {
        let (base, rate) = (BasePoint { tangent: &tangent, ..base }, rate(&tangent));
        // The last step ends at the final value.
        let lands = rate * direction > 0.0 && (to - base.p).abs() <= 1.001 * (rate * ds).abs();
        let next = if lands { naturally(family, base, scales, to) } else { correct(family, base, scales, ds) };
        let length = if lands { ((to - base.p) / rate).abs() } else { ds };
        let chord = |to: &Solution| scales.chord((base.z, base.p), (&to.z, to.p)).norm();
        match next {
            Ok(solution) if ds > shortest && family.strays(chord(&solution), length, &solution.newton) => ds *= 0.5,
            Ok(solution) if chord(&solution) > FARTHEST * length + LAST_CORRECTION => return Err(End::Jumped),
            // The chord to a solution beyond the final value has a point with this value.
            Ok(solution) if !lands && (solution.p - to) * direction > 0.0 => {
                ds = chord(&solution);
                tangent = scales.chord((base.z, base.p), (&solution.z, solution.p)) / ds;
            }
            Ok(solution) => {
                let factor = match solution.newton.len() {
                    ..GOOD_CORRECTIONS => 1.5,
                    GOOD_CORRECTIONS | MANY_CORRECTIONS => 1.0,
                    _ => 0.6,
                };
                return Ok((solution, ds * factor));
            }
            Err(_) if ds > shortest => ds *= 0.5,
            Err(_) => return Err(End::Lost),
        }
    }
}

/// A branch so far: unknowns and parameter of its last two solutions, and the next step.
pub struct BranchState {
    /// The value of the parameter at which the branch ends if it has turned back.
    pub back: f64,
    /// The solution before the last. `None` if there is only one: the branch then begins in the
    /// direction of the final value.
    pub previous: Option<(Vec<f64>, f64)>,
    /// The last solution.
    pub last: (Vec<f64>, f64),
    /// Length of the next predictor.
    pub ds: f64,
    /// Number of solutions so far.
    pub points: usize,
}

/// Called with every new solution, the length of the next predictor, and the reason why the branch
/// ends with this solution, if it does. A reason that is returned ends the branch. The branch goes
/// on from the solution as it is left, which is that of the orbit that is kept, to the bit.
pub(super) type Keep<'a> = &'a mut dyn FnMut(&mut Solution, f64, Option<End>) -> Result<Option<End>>;

/// Continues a branch past folds until the parameter reaches its final value or, if the branch has
/// turned back, passes `back`; `direction` is the sign of the parameter's change from the first
/// point to the end. The points in `state` count among the most. A branch that was stopped on the
/// way continues with the same bits.
pub fn follow(family: &dyn Family, state: BranchState, range: Range, direction: f64, keep: Keep<'_>) -> Result<End> {
    let Range { to, most_points, .. } = range;
    let BranchState { back, mut previous, last: (mut z, mut p), mut ds, points } = state;
    for points in points.. {
        if points >= most_points {
            break;
        }
        // A step that fails after the branch was asked to end does not say that it is lost.
        let lost = || match interrupt::asked() {
            true => Err(Error::Stopped { kept: format!("{points} points of the branch") }),
            false => Ok(End::Lost),
        };
        if interrupt::asked() {
            return lost();
        }
        let scales = Scales::new(&z, (to - back).abs()).at_least(family.least(&z));
        let (scales, before) = match &previous {
            Some((before, q)) => {
                let change = before.iter().zip(&z).map(|(before, z)| (z - before).powi(2)).sum::<f64>().sqrt();
                let scales = scales.at_least(THROUGH * change);
                (scales, scales.chord((before, *q), (&z, p)).normalize())
            }
            None => (scales, along(z.len(), direction)),
        };
        let Ok(tangent) = tangent(family, (&z, p), scales, &before) else { return lost() };
        let base = BasePoint { z: &z, p, tangent: &tangent };
        let (mut solution, longer) = match next(family, base, scales, range, (direction, ds)) {
            Ok(next) => next,
            Err(End::Lost) => return lost(),
            Err(end) => return Ok(end),
        };
        let gone_back = ((solution.p - back) * direction < 0.0).then_some(End::TurnedBack);
        let end = if (solution.p - to) * direction >= 0.0 { Some(End::Reached) } else { gone_back };
        if let Some(end) = keep(&mut solution, longer, end)?.or(end) {
            return Ok(end);
        }
        previous = Some((std::mem::replace(&mut z, solution.z), p));
        (p, ds) = (solution.p, longer);
    }
    Ok(End::MostPoints)
}
