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
    arclength::{MOST_CORRECTIONS, Range, Solution},
    branch::{At, BifurcationKind, Branch, Located, Point, Problem, ranged},
    chord::Chord,
    driven::{DriveParameter, DrivenMultiplier, DrivenOrbit, DrivenSetting, DrivenShooting, DrivenSpectrum, MARGIN},
    shooting::Equations,
};
use crate::{error::Result, numerics::least_by, output::FileFormat};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Settings of a continuation of driven orbits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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

/// Measurements of a driven orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivenMeasures {
    /// Half the range of the displacement of the free bead that moves most.
    pub amplitude: f64,
    /// Periods of the drive in the least period of the orbit.
    pub least_turns: u32,
}

/// What crosses the unit circle at a bifurcation of driven orbits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivenCritical {
    /// The multiplier; of a pair, the one in the upper half plane.
    pub multiplier: DrivenMultiplier,
    /// Half the range of the displacement of the free bead that moves most.
    pub amplitude: f64,
}

/// An orbit of a driven chain with its multipliers.
pub type DrivenPoint = Point<DrivenContinuation>;

/// Least unit of unknowns, in that of residuals.
const NEARLY: f64 = 1e-2;
/// Largest number of times that an interval is halved until each part has one bifurcation.
const MOST_CUTS: u32 = 12;
/// Largest distance of the zero of `chi` from that of `psi`, as a share of the interval.
const BESIDE: f64 = 0.1;
/// Error of a located bifurcation, as a share of the interval.
const LOCATED: f64 = 1e-9;
/// Most steps of the secant method from the zero of `psi` to that of `chi`; two are usual.
const MOST_SECANTS: u32 = 6;
/// A multiplier with a smaller imaginary part counts as real.
const REAL: f64 = 1e-5;

impl DrivenPoint {
    /// An orbit with its multipliers and measures.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    pub fn new(orbit: DrivenOrbit, shooting: &DrivenShooting) -> Result<Self> {
        Ok(Self { spectrum: orbit.spectrum(shooting)?, measures: DrivenMeasures::of(&orbit, shooting)?, orbit })
    }

    /// Whether no multiplier is outside the unit circle.
    pub fn stable(&self) -> bool {
        self.spectrum.unstable() == 0
    }
}

impl DrivenMeasures {
    fn of(orbit: &DrivenOrbit, shooting: &DrivenShooting) -> Result<Self> {
        let samples = orbit.samples(shooting)?;
        let [beads, _] = orbit.ranges(&samples, shooting)?;
        Ok(Self { amplitude: orbit.amplitude(&beads), least_turns: orbit.least_turns(&samples)? })
    }
}

impl Problem for DrivenContinuation {
    type Setting = DrivenSetting;
    type Orbit = DrivenOrbit;
    type Spectrum = DrivenSpectrum;
    type Measures = DrivenMeasures;
    type Critical = DrivenCritical;
    const FORMAT: FileFormat = FileFormat("hertzchain driven branch", 2);
    const NEAR: f64 = 1e-6;
    const WEAK: Option<f64> = Some(0.0);

    fn name(&self) -> &'static str {
        self.parameter.name()
    }

    ranged!();

    fn check_value(&self, setting: &DrivenSetting, p: f64) -> Result<()> {
        setting.with(self.parameter, p).chain().map(|_| ())
    }

    fn equations(&self, setting: &DrivenSetting, z: &[f64], p: f64, derivative: bool) -> Result<Equations> {
        self.shooting.equations(&setting.with(self.parameter, p), z, derivative)
    }

    fn solve(&self, setting: &DrivenSetting, seed: &[f64], p: f64) -> Result<Solution> {
        let shooting = DrivenShooting { most_steps: MOST_CORRECTIONS, ..self.shooting };
        Ok(shooting.solve(&setting.with(self.parameter, p), seed)?.solution(p))
    }

    fn size(&self, setting: &DrivenSetting, z: &[f64], _p: f64) -> f64 {
        setting.size(z)
    }

    fn least(&self, setting: &DrivenSetting, z: &[f64]) -> f64 {
        NEARLY * setting.size(z)
    }

    fn solved(&self, setting: &DrivenSetting, z: &[f64], p: f64) -> f64 {
        setting.with(self.parameter, p).solved(z, self.shooting.tol)
    }

    fn orbit(&self, setting: &DrivenSetting, solution: &Solution) -> DrivenOrbit {
        solution.orbit(setting.with(self.parameter, solution.p))
    }

    fn solution(&self, _setting: &DrivenSetting, orbit: &DrivenOrbit) -> Solution {
        orbit.solution(orbit.setting.get(self.parameter))
    }

    fn spectrum(&self, _setting: &DrivenSetting, orbit: &DrivenOrbit) -> Result<DrivenSpectrum> {
        orbit.spectrum(&self.shooting)
    }

    fn measures(&self, _setting: &DrivenSetting, orbit: &DrivenOrbit) -> Result<DrivenMeasures> {
        DrivenMeasures::of(orbit, &self.shooting)
    }

    fn arrays(setting: &DrivenSetting) -> Vec<(&'static str, usize)> {
        vec![("z", setting.unknowns())]
    }

    fn multipliers(spectrum: &DrivenSpectrum) -> Vec<[f64; 3]> {
        spectrum.multipliers.iter().map(|one| [one.re, one.im, one.error]).collect()
    }

    fn verify(&self, _setting: &DrivenSetting, orbit: &DrivenOrbit) -> Result<()> {
        orbit.verify(&self.shooting)
    }

    fn least_change(&self, _p: f64) -> f64 {
        self.step
    }

    fn between(branch: &Branch<Self>, ends: [At<'_, Self>; 2]) -> (Vec<Located<Self>>, usize) {
        let mut found = Vec::new();
        let unresolved = search(branch, ends, MOST_CUTS, &mut found);
        (found, unresolved)
    }

    fn crossing(
        &self,
        setting: &DrivenSetting,
        kind: BifurcationKind,
    ) -> Result<std::result::Result<(DrivenSetting, usize), &'static str>> {
        Ok(match kind {
            BifurcationKind::PeriodDoubling => Ok((setting.doubled()?, 1)),
            BifurcationKind::PlusOne => Ok((setting.clone(), 1)),
            BifurcationKind::Torus => Err("the orbits that begin there are not periodic: none is followed"),
            _ => Err("a branch turns there, and no other one crosses it"),
        })
    }

    fn halves_apart(&self, _setting: &DrivenSetting, orbit: &DrivenOrbit) -> Result<DVector<f64>> {
        orbit.halves_apart(&self.shooting)
    }
}

/// Adds the bifurcations between two orbits; returns the number of changes of stability that were
/// not resolved.
fn search(
    branch: &Branch<DrivenContinuation>,
    [a, b]: [At<'_, DrivenContinuation>; 2],
    cuts: u32,
    out: &mut Vec<Located<DrivenContinuation>>,
) -> usize {
    let unstable = [a, b].map(|(_, spectrum)| spectrum.unstable());
    let change = unstable[0].abs_diff(unstable[1]);
    if change == 0 {
        return 0;
    }
    let chord = Chord::new(branch, a.0, b.0);
    if change <= 2
        && let Some(found) = chord.locate(&branch.continuation, [a.1, b.1], unstable[0].min(unstable[1]))
        && (change == 2) == (found.kind == BifurcationKind::Torus)
    {
        out.push(found);
        return 0;
    }
    let (1.., Ok((orbit, spectrum))) = (cuts, chord.point(0.5)) else { return 1 };
    let middle = (&orbit, &spectrum);
    search(branch, [a, middle], cuts - 1, out) + search(branch, [middle, b], cuts - 1, out)
}

impl Chord<'_, DrivenContinuation> {
    /// The zero of `psi`, and then that of `chi`.
    fn locate(
        &self,
        continuation: &DrivenContinuation,
        ends: [&DrivenSpectrum; 2],
        k: usize,
    ) -> Option<Located<DrivenContinuation>> {
        let psi = |spectrum: &DrivenSpectrum| spectrum.multipliers[k].modulus - 1.0 - MARGIN;
        let (found, values) =
            self.zero(ends.map(psi), (1e-2 * MARGIN, LOCATED), |(_, spectrum)| Some(psi(spectrum)))?;
        let (mut orbit, spectrum) =
            Some(found).filter(|(_, spectrum)| psi(spectrum).abs() <= DrivenContinuation::NEAR)?;
        let mut multiplier = spectrum.multipliers[k];
        let [mut old, mut new] = values.map(|(s, psi)| (s, psi + MARGIN));
        for _ in 0..MOST_SECANTS {
            let s = new.0 - new.1 * (new.0 - old.0) / (new.1 - old.1);
            let beside = (s - new.0).abs() <= BESIDE;
            if !beside || new.1.abs() <= multiplier.error {
                break;
            }
            let Ok((next, spectrum)) = self.point(s) else { break };
            let apart = |one: &DrivenMultiplier| (one.re - multiplier.re).hypot(one.im - multiplier.im);
            let Some(nearest) =
                least_by(spectrum.multipliers, apart).filter(|one| (one.modulus - 1.0).abs() < new.1.abs())
            else {
                break;
            };
            (old, new) = (new, (s, nearest.modulus - 1.0));
            (orbit, multiplier) = (next, nearest);
        }
        let multiplier = DrivenMultiplier { im: multiplier.im.abs(), ..multiplier };
        let kind = if multiplier.im > REAL {
            BifurcationKind::Torus
        } else if multiplier.re < 0.0 {
            BifurcationKind::PeriodDoubling
        } else if self.slope(&orbit).ok()?.abs() <= ACROSS {
            BifurcationKind::Fold
        } else {
            BifurcationKind::PlusOne
        };
        let amplitude = DrivenMeasures::of(&orbit, &continuation.shooting).ok()?.amplitude;
        Some(self.located(kind, DrivenCritical { multiplier, amplitude }, &orbit))
    }
}

/// Largest component along the parameter of the unit tangent of a branch at a fold.
const ACROSS: f64 = 1e-3;
