//! Branches of driven orbits: continuation, stability, bifurcations.
//!
//! | symbol | meaning |
//! |---|---|
//! | `U` | number of multipliers outside the unit circle, with a modulus above `1 + MARGIN` |
//! | `psi(s)` | `abs(lambda_k) - 1 - MARGIN` over the chord of two points; moduli descend |
//! | `chi(s)` | `abs(lambda) - 1` of the multiplier nearest to that at the zero of `psi` |
//!
//! Where `U` differs between two points, `psi` changes its sign, with `k` (from 0) the smaller `U`:
//! ordered moduli are continuous. The multiplier at the zero gives the kind of the bifurcation: 1
//! at a fold or a branch point, -1 at a period doubling, a complex pair where a torus branches off
//! (Neimark-Sacker). The bifurcation is at the zero of `chi` beside that of `psi`: there a real
//! multiplier is 1 or -1, and a pair on the circle.

use super::{
    arclength::{self, BasePoint, End, Scales},
    bifurcation::BifurcationKind,
    driven::{DriveParameter, DrivenFamily, DrivenMultiplier, DrivenOrbit, DrivenShooting, DrivenSpectrum, MARGIN},
    driven_trail::DrivenTrail,
};
use crate::error::Result;
use nalgebra::DVector;

/// Settings of a continuation of driven orbits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenContinuation {
    /// The parameter that varies.
    pub parameter: DriveParameter,
    /// The value at which the branch ends.
    pub to: f64,
    /// The largest change of the parameter from point to point, positive.
    pub step: f64,
    /// Largest number of points.
    pub most_points: usize,
    /// How orbits are solved for.
    pub shooting: DrivenShooting,
}

/// An orbit of a branch with its multipliers.
#[derive(Clone, Debug)]
pub struct DrivenPoint {
    /// The orbit.
    pub orbit: DrivenOrbit,
    /// Its multipliers.
    pub spectrum: DrivenSpectrum,
    /// Half the range of the displacement of the free bead that moves most.
    pub amplitude: f64,
    /// Periods of the drive in the least period of the orbit.
    pub least_turns: u32,
}

/// A bifurcation of a branch.
#[derive(Clone, Debug)]
pub struct DrivenBifurcation {
    /// The kind of bifurcation.
    pub kind: BifurcationKind,
    /// Value of the parameter.
    pub parameter: f64,
    /// The multiplier that crosses the unit circle; of a pair, the one in the upper half plane.
    pub multiplier: DrivenMultiplier,
    /// The orbit at the bifurcation, with its multipliers.
    pub point: DrivenPoint,
    /// Number of the point of the branch before it, from 0 on.
    pub after: usize,
}

/// A branch of driven orbits.
#[derive(Clone, Debug)]
pub struct DrivenBranch {
    /// How it was followed.
    pub continuation: DrivenContinuation,
    /// Its points in their order along it: at least one, unless the process was asked to end.
    pub points: Vec<DrivenPoint>,
    /// The bifurcations between them, in the same order.
    pub bifurcations: Vec<DrivenBifurcation>,
    /// Number of changes of stability that were not resolved into single bifurcations.
    pub unresolved: usize,
    /// Why it ended.
    pub end: End,
    /// All of its orbits, with everything needed to continue it. It has more orbits than `points`
    /// if the multipliers of an orbit are not known.
    pub trail: DrivenTrail,
}

/// Largest number of times that a stretch is halved until each part has one bifurcation.
const MOST_CUTS: u32 = 12;
/// Largest number of evaluations of `psi`.
const MOST_TRIALS: u32 = 40;
/// Largest distance of the zero of `chi` from that of `psi`, as a share of the stretch.
const BESIDE: f64 = 0.1;
/// Error of a located bifurcation, as a share of the stretch.
const LOCATED: f64 = 1e-9;
/// Most steps of the secant method from the zero of `psi` to that of `chi`; two are usual.
const MOST_SECANTS: u32 = 6;
/// Largest `|psi|` of a located bifurcation.
const NEAR: f64 = 1e-6;
/// A multiplier with a smaller imaginary part counts as real.
const REAL: f64 = 1e-5;

impl DrivenPoint {
    /// An orbit with its multipliers and amplitude.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    pub fn new(orbit: DrivenOrbit, shooting: &DrivenShooting) -> Result<Self> {
        let (spectrum, samples) = (orbit.spectrum(shooting)?, orbit.samples(shooting)?);
        let least_turns = orbit.least_turns(&samples)?;
        Ok(Self { spectrum, amplitude: orbit.amplitude(&samples), least_turns, orbit })
    }

    /// Whether no multiplier is outside the unit circle.
    pub fn stable(&self) -> bool {
        self.spectrum.unstable() == 0
    }
}

impl DrivenContinuation {
    pub(crate) fn check(&self, from: f64) -> Result<()> {
        arclength::check([from, self.to], self.step, self.most_points)
    }

    /// Follows the branch from `start`, past folds, until the parameter has its final value or, if
    /// the branch has turned back, passes its first; `seen` is called after every new orbit.
    ///
    /// # Errors
    /// Numbers outside their rules; no multipliers of the first orbit; a signal.
    pub fn follow(&self, start: DrivenOrbit, seen: impl FnMut(&DrivenTrail)) -> Result<DrivenBranch> {
        let mut trail = DrivenTrail::new(*self, start)?;
        trail.extend(seen)?;
        let point = |orbit: &DrivenOrbit| DrivenPoint::new(orbit.clone(), &self.shooting);
        let first = point(&trail.orbits[0])?;
        let others = trail.orbits[1..].iter().map_while(|orbit| point(orbit).ok());
        let points = std::iter::once(first).chain(others).collect();
        Ok(trail.branch(points))
    }

    /// The bifurcations between two points of a branch, of which the first has the number `after`,
    /// and the number of changes of stability that were not resolved.
    pub(super) fn bifurcations_between(
        &self,
        [a, b]: [&DrivenPoint; 2],
        after: usize,
    ) -> (Vec<DrivenBifurcation>, usize) {
        let mut found = Vec::new();
        let unresolved = self.between(a, b, MOST_CUTS, &mut found);
        found.iter_mut().for_each(|one: &mut DrivenBifurcation| one.after = after);
        (found, unresolved)
    }

    fn family<'a>(&'a self, orbit: &'a DrivenOrbit) -> DrivenFamily<'a> {
        DrivenFamily { shooting: &self.shooting, setting: &orbit.setting, parameter: self.parameter }
    }

    pub(super) fn place<'a>(&self, orbit: &'a DrivenOrbit) -> (&'a [f64], f64) {
        (&orbit.z, orbit.setting.get(self.parameter))
    }

    /// Adds the bifurcations between two points; returns the number of changes of stability that
    /// were not resolved.
    fn between(&self, a: &DrivenPoint, b: &DrivenPoint, cuts: u32, out: &mut Vec<DrivenBifurcation>) -> usize {
        let unstable = [a, b].map(|point| point.spectrum.unstable());
        let change = unstable[0].abs_diff(unstable[1]);
        if change == 0 {
            return 0;
        }
        let stretch = Stretch::new(self, a, b);
        if change <= 2
            && let Some(found) = stretch.locate(a, b, unstable[0].min(unstable[1]))
            && (change == 2) == (found.kind == BifurcationKind::Torus)
        {
            out.push(found);
            return 0;
        }
        match (cuts, stretch.point(0.5)) {
            (1.., Some(middle)) => self.between(a, &middle, cuts - 1, out) + self.between(&middle, b, cuts - 1, out),
            _ => 1,
        }
    }
}

/// The part of a branch between two points, parametrised by their chord from 0 to 1.
struct Stretch<'a> {
    continuation: &'a DrivenContinuation,
    from: &'a DrivenOrbit,
    chord: DVector<f64>,
    scales: Scales,
    length: f64,
}

impl<'a> Stretch<'a> {
    fn new(continuation: &'a DrivenContinuation, a: &'a DrivenPoint, b: &'a DrivenPoint) -> Self {
        let [a, b] = [a, b].map(|point| &point.orbit);
        let ((z, p), there) = (continuation.place(a), continuation.place(b));
        // Beside a fold both ends may have the same value of the parameter.
        let scales = Scales::new(z, (there.1 - p).abs().max(continuation.step));
        let chord = scales.chord((z, p), there);
        let length = chord.norm();
        Self { continuation, from: a, chord: chord / length, scales, length }
    }

    fn point(&self, s: f64) -> Option<DrivenPoint> {
        let family = self.continuation.family(self.from);
        let (z, p) = self.continuation.place(self.from);
        let spot = BasePoint { z, p, tangent: &self.chord };
        let solution = arclength::correct(&family, spot, self.scales, s * self.length).ok()?;
        DrivenPoint::new(family.orbit(solution), &self.continuation.shooting).ok()
    }

    /// The zero of `psi` by the rule of false position (Illinois variant), and then that of `chi`.
    fn locate(&self, a: &DrivenPoint, b: &DrivenPoint, k: usize) -> Option<DrivenBifurcation> {
        let psi = |point: &DrivenPoint| point.spectrum.multipliers[k].modulus - 1.0 - MARGIN;
        let (mut left, mut right) = ((0.0, psi(a)), (1.0, psi(b)));
        let (mut last, mut before) = (None, [(0.0, psi(a)), (1.0, psi(b))]);
        for _ in 0..MOST_TRIALS {
            let s = (left.0 * right.1 - right.0 * left.1) / (right.1 - left.1);
            // At a branch point the corrector is singular and fails. Then the last point counts, if
            // it is close enough.
            let Some(point) = self.point(s) else { break };
            let value = psi(&point);
            last = Some(point);
            if value * right.1 < 0.0 {
                left = right;
            } else {
                left.1 *= 0.5;
            }
            let by = (s - right.0).abs();
            right = (s, value);
            before = [before[1], right];
            if value.abs() <= 1e-2 * MARGIN || by <= LOCATED || (left.0 - right.0).abs() <= LOCATED {
                break;
            }
        }
        let mut point = last.filter(|point| psi(point).abs() <= NEAR)?;
        let mut multiplier = point.spectrum.multipliers[k];
        let [mut old, mut new] = before.map(|(s, psi)| (s, psi + MARGIN));
        for _ in 0..MOST_SECANTS {
            let s = new.0 - new.1 * (new.0 - old.0) / (new.1 - old.1);
            let beside = (s - new.0).abs() <= BESIDE;
            if !beside || new.1.abs() <= multiplier.error {
                break;
            }
            let Some(next) = self.point(s) else { break };
            let apart = |one: &DrivenMultiplier| (one.re - multiplier.re).hypot(one.im - multiplier.im);
            let nearest = next.spectrum.multipliers.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let Some(&nearest) = nearest.filter(|one| (one.modulus - 1.0).abs() < new.1.abs()) else { break };
            (old, new) = (new, (s, nearest.modulus - 1.0));
            (point, multiplier) = (next, nearest);
        }
        let multiplier = DrivenMultiplier { im: multiplier.im.abs(), ..multiplier };
        let kind = if multiplier.im > REAL {
            BifurcationKind::Torus
        } else if multiplier.re < 0.0 {
            BifurcationKind::PeriodDoubling
        } else if self.turns_at(&point)? {
            BifurcationKind::Fold
        } else {
            BifurcationKind::PlusOne
        };
        Some(DrivenBifurcation {
            kind,
            parameter: point.orbit.setting.get(self.continuation.parameter),
            multiplier,
            point,
            after: 0,
        })
    }

    /// Whether a point is a fold: the unit tangent of the branch has no component along the
    /// parameter there, up to [`ACROSS`].
    fn turns_at(&self, point: &DrivenPoint) -> Option<bool> {
        let family = self.continuation.family(&point.orbit);
        let place = self.continuation.place(&point.orbit);
        let tangent = arclength::tangent(&family, place, self.scales, &self.chord).ok()?;
        Some(tangent[tangent.len() - 1].abs() <= ACROSS)
    }
}

/// Largest component along the parameter of a unit tangent at a fold.
const ACROSS: f64 = 1e-3;
