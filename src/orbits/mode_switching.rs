//! The branch of orbits that crosses a branch of normal modes at a bifurcation.
//!
//! An orbit of a normal mode is at rest twice in a period, at `t = 0` and `t = T/2`. The orbits of
//! doubled period that begin at a period doubling are at rest near one of these two times, and
//! again a period `T` later. So both times are tried as the start of the new orbits. At `T/2` the
//! leading coordinate may have the other sign; the amplitude `a` is then negative.

use super::{
    arclength::{self, BranchState, ContinuationOptions, End, Scales, Solution},
    bifurcation::BifurcationKind,
    mode_trail::ModeTrail,
    normal_modes::{ModeBifurcation, ModeBranch, ModeContinuation, ModeFamily, ModeOrbit, ModePoint, NormalModes, TOL},
    switching,
};
use crate::{
    chain::Variations,
    error::{Error, Result},
};
use nalgebra::DVector;
use std::f64::consts::PI;

/// Unknowns and amplitude.
type Place = (Vec<f64>, f64);

impl ModeFamily<'_> {
    /// The displacements from the equilibrium at the second time of rest, half a period after the
    /// start.
    fn turning_point(&self, orbit: &ModeOrbit) -> Result<DVector<f64>> {
        let (modes, span) = (self.modes, (0.0, PI / orbit.omega));
        let start = modes.start(orbit.amplitude, &orbit.shape);
        let end = Variations::flow(&modes.chain, &start, span, &[], TOL)?.state;
        Ok(DVector::from_iterator(modes.free.len(), modes.free.iter().map(|&i| end[i] - modes.rest[i])))
    }

    /// Unknowns and amplitude of the same orbit, with `turns` of its periods counted as one. If
    /// `later`, it begins at the second time of rest.
    fn told(&self, orbit: &ModeOrbit, turns: u32, later: bool) -> Result<Place> {
        let omega = orbit.omega / f64::from(turns);
        if !later {
            return Ok((self.unknowns(&ModeOrbit { omega, ..orbit.clone() }), orbit.amplitude));
        }
        let q = self.turning_point(orbit)?;
        let amplitude = q[self.linear.leading];
        let shape = (q / amplitude).as_slice().to_vec();
        Ok((self.unknowns(&ModeOrbit { omega, amplitude, shape, ..orbit.clone() }), amplitude))
    }

    /// Displacements after half of the period less those at the start, divided by the amplitude.
    fn halves_apart(&self, orbit: &ModeOrbit) -> Result<DVector<f64>> {
        let end = self.turning_point(orbit)? / orbit.amplitude;
        Ok(end - DVector::from_column_slice(&orbit.shape))
    }
}

impl ModeBranch {
    /// The branch that crosses this one at bifurcation `k`, from 0 on: of doubled period at a
    /// period doubling, of the same period at a branch point. Its first orbit is the one at the
    /// crossing, from which it is followed in one of its two directions. It ends where the size of
    /// the amplitude reaches this branch's final value or falls below its first one. A branch of
    /// doubled period also ends where it comes back to this one.
    ///
    /// # Errors
    /// No such bifurcation; one at which no other branch crosses, or whose orbits are not at rest
    /// twice in a period; no orbit on it; multipliers that cannot be computed; a signal.
    pub fn switched(&self, modes: &NormalModes, k: usize, seen: impl FnMut(&ModePoint)) -> Result<Self> {
        self.switched_trail(modes, k, seen).map(|trail| trail.located(modes))
    }

    /// The branch of [`switched`](Self::switched) without its bifurcations.
    pub(crate) fn switched_trail(
        &self,
        modes: &NormalModes,
        k: usize,
        mut seen: impl FnMut(&ModePoint),
    ) -> Result<ModeTrail> {
        let birth = switching::numbered(&self.bifurcations, k)?;
        let continuation = self.continuation;
        let ModeContinuation { to, step, most_points, .. } = continuation;
        let family = ModeFamily::new(modes, &continuation);
        let Some(((z, a), scales, v)) = self.crossing(&family, birth)? else {
            let rule =
                "a period doubling or a branch point where one other branch crosses, of orbits at rest twice a period";
            return Err(Error::parameter("switch", format!("{}, {}", k + 1, birth.kind.words()), rule));
        };
        let (first, ds) = switching::first(&family, (&z, a), scales, &v)?;
        let direction = a.signum();
        let way = ContinuationOptions { to: direction * to, step, natural: false, direction };
        let last = (first.z.clone(), first.p);
        let course = BranchState { back: direction * step, previous: Some((z.clone(), a)), last, ds, points: 2 };
        let start = Solution { z, p: a, residual: birth.point.orbit.residual, newton: Vec::new() };
        let mut points = vec![family.point(&start)?, family.point(&first)?];
        points.iter().for_each(&mut seen);
        let mut apart = family.halves_apart(&points[1].orbit)?;
        let end = arclength::follow(&family, course, way, most_points, &mut |solution, _, _| {
            let Ok(point) = family.point(solution) else { return Ok(Some(End::NoMultipliers)) };
            if birth.kind == BifurcationKind::PeriodDoubling {
                let now = family.halves_apart(&point.orbit)?;
                if switching::changed_places(&apart, &now) {
                    return Ok(Some(End::Rejoined));
                }
                apart = now;
            }
            seen(&point);
            points.push(point);
            Ok(None)
        });
        let end = arclength::kept(end)?;
        Ok(ModeTrail { continuation, points, end, first: 1 })
    }

    /// At a bifurcation: unknowns and amplitude of its orbit as one of the branch that crosses, the
    /// units of `X`, and the direction in which that branch leaves. `None` if no branch is found.
    fn crossing(
        &self,
        family: &ModeFamily<'_>,
        birth: &ModeBifurcation,
    ) -> Result<Option<(Place, Scales, DVector<f64>)>> {
        let (turns, starts): (u32, &[bool]) = match birth.kind {
            BifurcationKind::PeriodDoubling => (2, &[false, true]),
            BifurcationKind::PlusOne => (1, &[false]),
            _ => return Ok(None),
        };
        for &later in starts {
            let told = |orbit: &ModeOrbit| family.told(orbit, turns, later);
            let place = told(&birth.point.orbit)?;
            let scales = Scales::new(&place.0, self.continuation.to - self.continuation.step);
            let (a, b) = (told(&self.points[birth.after].orbit)?, told(&self.points[birth.after + 1].orbit)?);
            let along = scales.chord((&a.0, a.1), (&b.0, b.1)).normalize();
            if let Some(v) = switching::crossing(family, (&place.0, place.1), scales, &along)? {
                return Ok(Some((place, scales, v)));
            }
        }
        Ok(None)
    }
}
