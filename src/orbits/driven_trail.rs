//! Branches of driven orbits while they are followed, and the start of a branch that crosses one.

use super::{
    arclength::{self, BranchState, ContinuationOptions, End, Scales},
    bifurcation::BifurcationKind,
    driven::{DrivenFamily, DrivenOrbit},
    driven_branch::{DrivenBifurcation, DrivenBranch, DrivenContinuation, DrivenPoint},
    switching,
};
use crate::error::{Error, Result};

/// A branch of driven orbits up to its last one, with everything needed to continue it.
#[derive(Clone, Debug)]
pub struct DrivenTrail {
    /// How the branch is followed.
    pub continuation: DrivenContinuation,
    /// The value of the parameter at which the branch ends if it has turned back: that of its first
    /// orbit or, for a branch that was begun where it crosses another one, of the first orbit of
    /// the other branch.
    pub back: f64,
    /// The kind of the bifurcation at which the branch begins, if it was begun where it crosses
    /// another one; the first orbit is the one at that bifurcation. After a period doubling the
    /// branch ends where it comes back to the branch of half its period.
    pub birth: Option<BifurcationKind>,
    /// The orbits, at least one, in their order along the branch.
    pub orbits: Vec<DrivenOrbit>,
    /// Length of the next predictor.
    pub ds: f64,
    /// Why the branch ended; `None` while it can continue.
    pub end: Option<End>,
}

impl DrivenTrail {
    /// A branch that has only its first orbit.
    ///
    /// # Errors
    /// Numbers of the continuation outside their rules.
    pub fn new(continuation: DrivenContinuation, start: DrivenOrbit) -> Result<Self> {
        let back = start.setting.get(continuation.parameter);
        continuation.check(back)?;
        let ds = continuation.step / (continuation.to - back).abs();
        Ok(Self { continuation, back, birth: None, orbits: vec![start], ds, end: None })
    }

    fn last(&self) -> Result<&DrivenOrbit> {
        self.orbits.last().ok_or_else(|| Error::parameter("orbits", 0, "at least one"))
    }

    /// Changes the settings so that the branch can continue: the end, the step and the largest
    /// number of points.
    ///
    /// A branch that reached its end, turned back or came back to the branch of half its period
    /// stays as it is unless another end is given.
    ///
    /// # Errors
    /// An end that is not beyond the last point, seen from the first; numbers outside their rules.
    pub fn onward(mut self, to: Option<f64>, step: Option<f64>, most_points: usize) -> Result<Self> {
        let whole = to.is_none() && self.end.is_some_and(End::is_complete);
        let DrivenContinuation { parameter, to: old, step: by, .. } = self.continuation;
        let (to, step) = (to.unwrap_or(old), step.unwrap_or(by));
        self.continuation = DrivenContinuation { to, step, most_points, ..self.continuation };
        let last = &self.last()?.setting;
        self.continuation.check(self.back)?;
        last.with(parameter, to).chain()?;
        if !whole {
            arclength::check_onward([self.back, last.get(parameter)], to)?;
            self.end = None;
        }
        Ok(self)
    }

    /// Follows the branch from its last orbit, past folds, to the final value of the parameter.
    ///
    /// `seen` is called after every new orbit. A branch that was stopped on the way continues with
    /// the same bits.
    ///
    /// # Errors
    /// Numbers outside their rules; [`Error::Stopped`] if the process was asked to end, after which
    /// the branch can continue. A branch that ends early is not an error: the [`End`] says why.
    pub fn extend(&mut self, mut seen: impl FnMut(&Self)) -> Result<End> {
        let (continuation, back) = (self.continuation, self.back);
        let DrivenContinuation { parameter, to, step, most_points, shooting } = continuation;
        continuation.check(back)?;
        let last = self.last()?;
        let setting = last.setting.clone();
        let place = |orbit: &DrivenOrbit| (orbit.z.clone(), orbit.setting.get(parameter));
        let previous = self.orbits.iter().rev().nth(1).map(place);
        let course = BranchState { back, previous, last: place(last), ds: self.ds, points: self.orbits.len() };
        let way = ContinuationOptions { to, step, natural: false, direction: (to - back).signum() };
        let family = DrivenFamily { shooting: &shooting, setting: &setting, parameter };
        let doubled = self.birth == Some(BifurcationKind::PeriodDoubling);
        let mut apart = if doubled { Some(last.halves_apart(&shooting)?) } else { None };
        self.end = None;
        let end = arclength::follow(&family, course, way, most_points, &mut |solution, ds, end| {
            let orbit = family.orbit(solution.clone());
            if let Some(before) = &mut apart {
                let now = orbit.halves_apart(&shooting)?;
                if switching::changed_places(before, &now) {
                    return Ok(Some(End::Rejoined));
                }
                *before = now;
            }
            self.orbits.push(orbit);
            // `end` is set before the call, so that a branch saved by `seen` has it.
            (self.ds, self.end) = (ds, end);
            seen(self);
            Ok(None)
        })?;
        self.end = Some(end);
        Ok(end)
    }

    /// The branch with its bifurcations. `points` are its orbits with their multipliers, in order,
    /// up to the first orbit whose multipliers are not known.
    pub fn branch(self, points: Vec<DrivenPoint>) -> DrivenBranch {
        let (mut bifurcations, mut unresolved) = (Vec::new(), 0);
        for after in 0..points.len().saturating_sub(1) {
            let (found, left) = self.bifurcations_after(after, [&points[after], &points[after + 1]]);
            bifurcations.extend(found);
            unresolved += left;
        }
        self.with(points, bifurcations, unresolved)
    }

    /// The bifurcations between the points `after` and `after + 1` of the branch, and the number of
    /// changes of stability there that were not resolved.
    ///
    /// The orbit at a crossing is on both branches. Its multiplier 1 is no bifurcation of this one,
    /// so the stretch from it to the second orbit is not searched.
    pub(crate) fn bifurcations_after(&self, after: usize, ends: [&DrivenPoint; 2]) -> (Vec<DrivenBifurcation>, usize) {
        let crossing = after == 0 && self.birth.is_some();
        if crossing { (Vec::new(), 0) } else { self.continuation.bifurcations_between(ends, after) }
    }

    /// The branch with its points and all that is between them.
    pub(crate) fn with(
        self,
        points: Vec<DrivenPoint>,
        bifurcations: Vec<DrivenBifurcation>,
        unresolved: usize,
    ) -> DrivenBranch {
        let end = End::with_multipliers(self.end, points.len() == self.orbits.len());
        DrivenBranch { continuation: self.continuation, points, bifurcations, unresolved, end, trail: self }
    }
}

impl DrivenBranch {
    /// The branch that crosses this one at bifurcation `k`, from 0 on: of doubled period at a
    /// period doubling, of the same period at a branch point. Its first orbit is the one at the
    /// crossing, its second one is off this branch, in one of two directions. At a period doubling
    /// both directions have the same orbits, which begin half of the doubled period apart.
    ///
    /// # Errors
    /// No such bifurcation; a fold; a torus bifurcation, where no periodic orbits begin; a doubled
    /// period of more than 64 periods of the drive; no direction in which a branch leaves, or no
    /// orbit on it.
    pub fn switched(&self, k: usize) -> Result<DrivenTrail> {
        let birth = switching::numbered(&self.bifurcations, k)?;
        let refused =
            |rule: &'static str| Err(Error::parameter("switch", format!("{}, {}", k + 1, birth.kind.words()), rule));
        let setting = match birth.kind {
            BifurcationKind::PeriodDoubling => birth.point.orbit.setting.doubled()?,
            BifurcationKind::PlusOne => birth.point.orbit.setting.clone(),
            BifurcationKind::Torus => {
                return refused("the orbits that begin there are not periodic: none is followed");
            }
            _ => return refused("a branch turns there, and no other one crosses it"),
        };
        let continuation = self.continuation;
        let family =
            DrivenFamily { shooting: &continuation.shooting, setting: &setting, parameter: continuation.parameter };
        let back = self.trail.back;
        let place = continuation.place(&birth.point.orbit);
        let scales = Scales::new(place.0, (continuation.to - back).abs());
        let [a, b] = [0, 1].map(|j| continuation.place(&self.points[birth.after + j].orbit));
        let along = scales.chord(a, b).normalize();
        let Some(v) = switching::crossing(&family, place, scales, &along)? else {
            return refused("not exactly one other branch crosses there");
        };
        let (solution, ds) = switching::first(&family, place, scales, &v)?;
        let start = DrivenOrbit { setting: setting.clone(), ..birth.point.orbit.clone() };
        let orbits = vec![start, family.orbit(solution)];
        Ok(DrivenTrail { continuation, back, birth: Some(birth.kind), orbits, ds, end: None })
    }
}
