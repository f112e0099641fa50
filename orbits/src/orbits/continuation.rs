//! Branches of orbits of conservative rings: pseudo-arclength continuation.
//!
//! | symbol | meaning |
//! |---|---|
//! | `X = (Z/s, p/P)` | strains and parameter, scaled |
//! | `s, P` | `sqrt(2N) max abs(Z)` for `2N` strains, and the range of the parameter |
//! | `F(X) = 0` | the equations of the orbit ([`shooting`](super::Shooting)) |
//!
//! Predictor and corrector are those of `arclength`.

use super::{
    arclength::{self, BasePoint, End, FARTHEST, MOST_CORRECTIONS, Range, Scales, Solution},
    bifurcation::{self, reversible},
    branch::{At, Bifurcation, BifurcationKind, Branch, Located, Problem, ranged},
    floquet::Spectrum,
    orbit::Extent,
    setting::{Parameter, Setting},
    shooting::{Equations, Formulation, NewtonStep, Orbit, Shooting},
};
use crate::{
    error::{Error, Result, require},
    output::FileFormat,
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
    /// How orbits are solved for.
    pub shooting: Shooting,
}

/// Largest residual of an orbit, in units of the largest strain.
const SOLVED: f64 = 1e-12;

/// Largest residual, in the same units, of an orbit from a file, which may have been computed on
/// another machine.
const RESTORED: f64 = 1e-8;
/// Largest frequency of contacts and resonators of such an orbit, in units of that of the orbit.
/// The integration of strains far from any orbit may take too long.
const FASTEST: f64 = 1e3;

/// Measurements of a point of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrbitMeasures {
    /// Centres and amplitudes of the first bond.
    pub extent: Extent,
}

impl Problem for Continuation {
    type Setting = Setting;
    type Orbit = Orbit;
    type Measures = OrbitMeasures;
    const FORMAT: FileFormat = FileFormat("hertzchain branch", 1);

    fn name(&self) -> &'static str {
        self.parameter.name()
    }

    ranged!();
    reversible!();

    fn check_value(&self, setting: &Setting, p: f64) -> Result<()> {
        setting.with(self.parameter, p).checked()
    }

    fn equations(&self, setting: &Setting, z: &[f64], p: f64, derivative: bool) -> Result<Equations> {
        self.shooting.equations(&setting.with(self.parameter, p), z, derivative)
    }

    fn solve(&self, setting: &Setting, seed: &[f64], p: f64) -> Result<Solution> {
        let shooting = Shooting { most_steps: MOST_CORRECTIONS, ..self.shooting };
        Ok(shooting.solve(&setting.with(self.parameter, p), seed)?.solution(p))
    }

    /// Steps in the mass ratio are long where these branches bend: only what would be a jump with
    /// the shortest step is one.
    fn strays(&self, chord: f64, predictor: f64, _newton: &[NewtonStep]) -> bool {
        chord > FARTHEST * predictor
    }

    fn solved(&self, _setting: &Setting, _z: &[f64], _p: f64) -> f64 {
        SOLVED
    }

    fn orbit(&self, setting: &Setting, solution: &Solution) -> Orbit {
        solution.orbit(setting.with(self.parameter, solution.p))
    }

    fn solution(&self, _setting: &Setting, orbit: &Orbit) -> Solution {
        orbit.solution(orbit.setting.get(self.parameter))
    }

    fn swing(&self, _setting: &Setting, orbit: &Orbit) -> Option<DVector<f64>> {
        Some(DVector::from_iterator(orbit.z.len(), orbit.z.iter().map(|z| z - orbit.setting.c_x)))
    }

    fn spectrum(&self, _setting: &Setting, orbit: &Orbit) -> Result<Spectrum> {
        orbit.spectrum(&self.shooting)
    }

    fn kept(spectrum: Spectrum) -> Spectrum {
        spectrum.without_vectors()
    }

    fn measures(&self, _setting: &Setting, orbit: &Orbit) -> Result<OrbitMeasures> {
        Ok(OrbitMeasures { extent: orbit.extent(self.shooting.tol)? })
    }

    fn arrays(setting: &Setting) -> Vec<(&'static str, usize)> {
        vec![("x", setting.sites), ("y", setting.numbers() - setting.sites)]
    }

    /// An orbit that starts at rest is at rest after half a period, so the half-period equations
    /// apply to both formulations.
    fn verify(&self, _setting: &Setting, orbit: &Orbit) -> Result<()> {
        let rule = "contacts and resonators of an orbit are at most 1000 times as fast as it is";
        require(orbit.setting.fastest_rate(&orbit.z) <= FASTEST, "strains", orbit.amplitude(), rule)?;
        let shooting = Shooting { formulation: Formulation::HalfPeriod, ..self.shooting };
        let velocities = shooting.equations(&orbit.setting, &orbit.z, false)?.residual;
        let residual = velocities.rows(0, orbit.z.len()).amax() / orbit.amplitude();
        let rule = "the velocities of an orbit vanish after half a period, to 1e-8: this is none";
        require(residual <= RESTORED, "residual", residual, rule)
    }

    fn least_change(&self, p: f64) -> f64 {
        1e-3 * (self.to - p).abs()
    }
}

impl Continuation {
    /// Follows the branch from `start` to the final value of the parameter; `seen` is called with
    /// every new orbit.
    ///
    /// # Errors
    /// As `Branch::extend`.
    pub fn follow(&self, start: Orbit, mut seen: impl FnMut(&Orbit)) -> Result<(Vec<Orbit>, End)> {
        let mut branch = Branch::new(*self, start.setting, start)?;
        let end = branch.extend(|branch| branch.orbits.last().into_iter().for_each(&mut seen))?;
        Ok((branch.orbits, end))
    }
}

impl Branch<Continuation> {
    /// The branch, if it reached its end.
    ///
    /// # Errors
    /// [`Error::Point`] otherwise, with the reason.
    pub fn reached(self) -> Result<Self> {
        match self.shortfall() {
            None => Ok(self),
            Some(why) => Err(Error::Point { point: "branch of orbits".to_owned(), why }),
        }
    }

    /// Where and why the branch ended, if not at the final value of its parameter.
    pub fn shortfall(&self) -> Option<String> {
        let Continuation { parameter, to, .. } = self.continuation;
        let (last, end) = (self.parameter(self.orbits.last()?), self.ended());
        let (name, why) = (parameter.name(), end.words());
        let words = || match last == to {
            true => format!("is at {name} = {to}, but its multipliers are not complete: {why}"),
            false => format!("ended at {name} = {last}, not at {to}: {why}"),
        };
        (end != End::Reached).then(words)
    }
}

impl Bifurcation<Continuation> {
    /// The first orbit of doubled period after a period doubling.
    ///
    /// The guess is `Z + size max|Z| z`; it is corrected at fixed distance along `z`.
    ///
    /// # Errors
    /// A bifurcation of another kind, a size that is not in `(0, 1]`, or no convergence.
    pub fn doubled(&self, shooting: &Shooting, size: f64) -> Result<Orbit> {
        let doubles = self.kind == BifurcationKind::PeriodDoubling;
        require(doubles, "kind", format!("{:?}", self.kind), "the period doubles at a period doubling only")?;
        require(size > 0.0 && size <= 1.0, "size", size, "a share of the amplitude in (0, 1]")?;
        let omega_b = 0.5 * self.orbit.setting.omega_b;
        let orbit = Orbit { setting: Setting { omega_b, turns: 2, ..self.orbit.setting }, ..self.orbit.clone() };
        // Near a pitchfork the frequency changes with the square of the amplitude, so the scale of
        // the parameter does not matter.
        let (parameter, to) = (Parameter::OmegaB, 1.01 * omega_b);
        let continuation = Continuation { parameter, to, step: 0.01, most_points: 2, shooting: *shooting };
        let mode = &self.critical.mode;
        let mode = DVector::from_iterator(mode.len() + 1, mode.iter().copied().chain([0.0]));
        let scales = Scales::new(&orbit.z, (to - omega_b).abs());
        let ds = size * orbit.amplitude() * mode.norm() / scales.state;
        let branch = Branch::new(continuation, orbit.setting, orbit)?;
        let base = BasePoint { z: &branch.orbits[0].z, p: omega_b, tangent: &mode.normalize() };
        let solution = arclength::correct(&branch.family(), base, scales, ds)?;
        Ok(continuation.orbit(&branch.setting, &solution))
    }
}
