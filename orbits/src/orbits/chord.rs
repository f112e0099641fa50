//! The part of a branch between two of its orbits, on which bifurcations are sought.

use super::{
    arclength::{self, BasePoint, Scales, Solution},
    branch::{At, BifurcationKind, Branch, Located, Problem},
};
use crate::error::Result;
use nalgebra::DVector;

/// Largest number of evaluations of a test function.
const MOST_TRIALS: u32 = 60;

/// The part of a branch between two orbits, parametrised by their chord from 0 to 1.
pub(super) struct Chord<'a, P: Problem> {
    branch: &'a Branch<P>,
    from: Solution,
    chord: DVector<f64>,
    scales: Scales,
    length: f64,
}

/// An orbit on a chord with its multipliers.
pub(super) type OnChord<P> = (<P as Problem>::Orbit, <P as Problem>::Spectrum);
/// Two places on a chord with the values of a function there.
type Values = [(f64, f64); 2];

impl<'a, P: Problem> Chord<'a, P> {
    pub(super) fn new(branch: &'a Branch<P>, from: &P::Orbit, to: &P::Orbit) -> Self {
        let [from, to] = [from, to].map(|orbit| branch.solution(orbit));
        let change = (to.p - from.p).abs().max(branch.continuation.least_change(from.p));
        let scales = Scales::new(&from.z, change);
        let chord = scales.chord((&from.z, from.p), (&to.z, to.p));
        let length = chord.norm();
        Self { branch, from, chord: chord / length, scales, length }
    }

    /// The orbit that the corrector finds at a place on the chord.
    pub(super) fn point(&self, s: f64) -> Result<OnChord<P>> {
        let Branch { continuation, setting, .. } = self.branch;
        let base = BasePoint { z: &self.from.z, p: self.from.p, tangent: &self.chord };
        let solution = arclength::correct(&self.branch.family(), base, self.scales, s * self.length)?;
        let orbit = continuation.orbit(setting, &solution);
        let spectrum = continuation.spectrum(setting, &orbit)?;
        Ok((orbit, spectrum))
    }

    /// The component along the parameter of the unit tangent of the branch at an orbit.
    pub(super) fn slope(&self, at: &P::Orbit) -> Result<f64> {
        let Solution { z, p, .. } = self.branch.solution(at);
        let tangent = arclength::tangent(&self.branch.family(), (&z, p), self.scales, &self.chord)?;
        Ok(tangent[tangent.len() - 1])
    }

    /// The zero of `psi` by the rule of false position (Illinois variant), with the values at both
    /// `ends` known: the last orbit of the search, and the last two places with their values. The
    /// search ends at `|psi|` up to `small`, or where the place is known to `located`.
    pub(super) fn zero(
        &self,
        ends: [f64; 2],
        (small, located): (f64, f64),
        mut psi: impl FnMut(At<'_, P>) -> Option<f64>,
    ) -> Option<(OnChord<P>, Values)> {
        let [mut left, mut right] = [(0.0, ends[0]), (1.0, ends[1])];
        let (mut last, mut values) = (None, [left, right]);
        for _ in 0..MOST_TRIALS {
            let s = (left.0 * right.1 - right.0 * left.1) / (right.1 - left.1);
            let Ok(point) = self.point(s) else {
                last = last.filter(|_| right.1.abs() <= P::NEAR);
                break;
            };
            let value = psi((&point.0, &point.1))?;
            last = Some(point);
            if value * right.1 < 0.0 {
                left = right;
            } else {
                left.1 *= 0.5;
            }
            let by = (s - right.0).abs();
            right = (s, value);
            values = [values[1], right];
            if value.abs() <= small || by <= located || (left.0 - right.0).abs() <= located {
                break;
            }
        }
        Some((last?, values))
    }

    /// A bifurcation at an orbit on the chord.
    pub(super) fn located(&self, kind: BifurcationKind, critical: P::Critical, at: &P::Orbit) -> Located<P> {
        Located { kind, critical, solution: self.branch.solution(at), after: 0 }
    }
}
