//! Nonlinear normal modes of conservative chains: periodic orbits that begin as [linear
//! modes](super::linear_modes) about the equilibrium. Modes of defects, and of the gaps of dimers,
//! are among them.
//!
//! | symbol | meaning |
//! |---|---|
//! | `q, m` | displacements from the equilibrium of what moves, and its masses |
//! | `a` | amplitude: displacement `q_j(0)`; `j` has the largest share `m s^2` of the linear mode |
//! | `xi` | shape, `q(0) = a xi` with `xi_j = 1` |
//! | `w` | logarithm of the frequency, `omega = omega_0 exp(w)` |
//! | `M_h` | derivative of the flow over half of the period, `T/2 = pi/omega` |
//!
//! Orbits begin at rest. By reversibility a state at rest is on a periodic orbit if the chain is at
//! rest again after half of the period. So the equations are `q'(T/2)/(a omega) = 0`, with the
//! unknowns `w` and `xi` without `xi_j`, at a given `a`. For `a -> 0` their solution is the linear
//! mode. A ring can move as a whole: there one more equation fixes the centre of mass.

use super::{
    arclength::{self, Range, Solution},
    bifurcation::{self, reversible},
    branch::{At, BifurcationKind, Branch, Located, Problem, ranged},
    driven::returns,
    floquet::{Frame, Kind, Spectrum},
    linear_modes::{LinearMode, NormalModes, TANGENT_TOL, participation},
    shooting::{Equations, NewtonStep, least_squares},
    touching,
};
use crate::{
    chain::{State, Variations, max_norm},
    error::{Error, Result, require},
    output::FileFormat,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Tolerance of a step of the flow.
const TOL: f64 = 1e-14;
/// Error of a tangent map over half a period in this unit. Chosen; measured, where `tau = -1`: 2.3.
const STEPS: f64 = 10.0;
/// Largest residual of an orbit.
const SOLVED: f64 = 1e-11;
/// Share of the largest static overlap that is the least unit of residuals: [`SOLVED`] is then some
/// 450 roundings of the overlap.
const ROUNDED: f64 = 1e-2;
/// Most times that the first amplitude is halved.
const MOST_HALVINGS: u32 = 10;
/// Largest relative difference of two frequencies that are taken for one.
const DEGENERATE: f64 = 1e-8;
/// A step of Newton's method below this is the last one.
const LAST_STEP: f64 = 1e-9;
/// Least unit of the amplitude for the interval between two points, as a share of the amplitude:
/// beside a fold both points have nearly the same amplitude.
const LEAST_CHANGE: f64 = 1e-3;

/// An orbit of a nonlinear normal mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeOrbit {
    /// Amplitude `a`; negative on some branches of doubled period.
    pub amplitude: f64,
    /// Frequency `omega`.
    pub omega: f64,
    /// `w`, its logarithm less that of the frequency of the linear mode.
    pub w: f64,
    /// Shape `xi`, of beads and of resonators that move.
    pub shape: Vec<f64>,
    /// Largest residual of the equations, in units of the largest of: 1, the unknowns, and a
    /// hundredth of the largest static overlap over the amplitude or, if it is smaller, over the
    /// largest step of the branch.
    pub residual: f64,
    /// Steps of Newton's method.
    pub newton: Vec<NewtonStep>,
}

/// Energy, participation number and least overlap of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeMeasures {
    /// Energy above that of the equilibrium.
    pub energy: f64,
    /// `(sum m xi^2)^2 / sum (m xi^2)^2`.
    pub participation: f64,
    /// The least overlap of all contacts at the two times of rest; negative if beads are apart.
    pub least_overlap: f64,
}

/// Settings of a branch of orbits that begins as a linear mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeContinuation {
    /// Number of the linear mode.
    pub mode: usize,
    /// The amplitude at which the branch ends.
    pub to: f64,
    /// The largest change of the amplitude from point to point, and the first amplitude, unless the
    /// orbit of this amplitude that is found differs much from the linear mode: see
    /// [`begin`](Self::begin).
    pub step: f64,
    /// Largest number of points.
    pub most_points: usize,
}

impl ModeContinuation {
    /// Refuses numbers outside their rules.
    ///
    /// # Errors
    /// No such mode; amplitudes that are not positive; fewer than two points.
    pub fn check(&self, modes: &NormalModes) -> Result<()> {
        // Any amplitude: the rule for the last one is below.
        self.check_value(modes, 1.0)?;
        require(self.to.is_finite() && self.to > 0.0, "to", self.to, "an amplitude is finite and positive")?;
        arclength::check([self.step, self.to], self.step, self.most_points)?;
        require(self.step <= self.to, "step", self.step, "at most the last amplitude")
    }

    /// The branch with its first orbit only. Collisions of multipliers that lead to no modulus
    /// above 1.001 are not located on it.
    ///
    /// The first orbit is sought from the linear mode, at the amplitude `step`. While Newton's
    /// corrections do not contract, or shape and frequency turn by more than 25 degrees from those
    /// of the linear mode, in the space of the unknowns, the amplitude is halved.
    ///
    /// # Errors
    /// Numbers outside their rules; a first orbit that is not found.
    pub fn begin(&self, modes: &NormalModes) -> Result<Branch<Self>> {
        self.check(modes)?;
        let first = self.first(modes)?;
        let ds = first.p / (self.to - first.p);
        let branch = Branch::new(*self, modes.clone(), self.orbit(modes, &first))?;
        Ok(Branch { ds, ..branch })
    }

    /// The orbit near the linear mode, or near the breather of the DpS equation, at the amplitude
    /// `step` or a smaller one.
    pub(super) fn first(&self, modes: &NormalModes) -> Result<Solution> {
        let linear = &modes.linear[self.mode];
        let localised = touching::localised(modes)?;
        if modes.vacuum {
            return touching::unloaded(modes, self.mode, self.step, |modes, seed| self.solve(modes, seed, self.step));
        }
        let shape = localised.as_ref().map_or(&linear.shape, |one| &one.shape);
        let w = |a: f64| localised.as_ref().map_or(0.0, |one| one.w(a));
        // Modes of one frequency, as on a ring, may have any shape among theirs: an orthonormal
        // basis.
        let one = |mode: &&LinearMode| (mode.omega / linear.omega - 1.0).abs() < DEGENERATE;
        let same = modes.linear.iter().filter(one).map(|mode| &mode.shape);
        let shapes: Vec<_> = if localised.is_some() { vec![shape] } else { same.collect() };
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for shape in shapes {
            basis.push(outside(&basis, DVector::from_column_slice(shape)).normalize());
        }
        let near = |found: &Solution| {
            let (shape, omega) = linear.parts(&found.z);
            let shape = DVector::from_vec(shape);
            let apart = outside(&basis, shape.clone()).norm().hypot((omega / linear.omega).ln() - w(found.p));
            let size = (shape.norm_squared() - apart * apart).max(0.0).sqrt();
            // Newton's method is slow along modes of one frequency.
            let newton = if basis.len() > 1 { &[] } else { &found.newton[..] };
            !arclength::strays(size.hypot(apart), size, newton)
        };
        let at = |k: u32| {
            let a = self.step * 0.5f64.powf(f64::from(k));
            self.solve(modes, &linear.unknowns(shape, w(a)), a).ok().filter(near)
        };
        (0..=MOST_HALVINGS).find_map(at).ok_or_else(|| {
            let rule = "there is no orbit near the linear mode, down to a thousandth of the step";
            Error::parameter("step", self.step, rule)
        })
    }
}

/// The part of a vector that is orthogonal to an orthonormal basis.
fn outside(basis: &[DVector<f64>], x: DVector<f64>) -> DVector<f64> {
    basis.iter().fold(x, |x, b| &x - b * b.dot(&x))
}

impl NormalModes {
    /// The state of an orbit at `t = 0`.
    pub fn state(&self, orbit: &ModeOrbit) -> State<f64> {
        let mut state = State::rest(&self.chain);
        state.as_mut_slice().copy_from_slice(&self.start(orbit.amplitude, &orbit.shape));
        state
    }

    /// The state of an orbit half a period after its start, at its second time of rest.
    fn turning_point(&self, orbit: &ModeOrbit) -> Result<Vec<f64>> {
        let start = self.start(orbit.amplitude, &orbit.shape);
        Ok(Variations::flow(&self.chain, &start, (0.0, PI / orbit.omega), &[], TOL)?.state)
    }

    /// The displacements from the equilibrium at that time.
    fn turned(&self, orbit: &ModeOrbit) -> Result<DVector<f64>> {
        let end = self.turning_point(orbit)?;
        Ok(DVector::from_iterator(self.free.len(), self.free.iter().map(|&i| end[i] - self.rest[i])))
    }
}

impl Problem for ModeContinuation {
    type Setting = NormalModes;
    type Orbit = ModeOrbit;
    type Measures = ModeMeasures;
    const FORMAT: FileFormat = FileFormat("hertzchain mode branch", 1);
    const NEAR: f64 = 5e-8;
    /// Chosen: long chains have many weaker collisions.
    const WEAK: Option<f64> = Some(1e-3);

    fn name(&self) -> &'static str {
        "amplitude"
    }

    ranged!();
    reversible!();

    fn check_value(&self, modes: &NormalModes, a: f64) -> Result<()> {
        let count = modes.linear.len();
        let value = format!("{} of {count}", self.mode.wrapping_add(1));
        require(self.mode < count, "linear_mode", value, "linear modes are numbered from 1, by frequency")?;
        let rule = "breathers of beads that just touch are in the middle of the chain";
        let middle = modes.center.is_none() || self.mode == modes.most_localised();
        require(middle, "linear_mode", self.mode + 1, rule)?;
        require(a.is_finite() && a != 0.0, "amplitude", a, "finite and not zero")
    }

    fn equations(&self, modes: &NormalModes, z: &[f64], a: f64, derivative: bool) -> Result<Equations> {
        if modes.center.is_some() {
            return touching::symmetric(modes, &modes.linear[self.mode], z, a, derivative);
        }
        let (linear, m) = (&modes.linear[self.mode], modes.free.len());
        let (shape, omega) = linear.parts(z);
        let (start, half) = (modes.start(a, &shape), PI / omega);
        let end = Variations::flow(&modes.chain, &start, (0.0, half), &[], TOL)?.state;
        let velocities = modes.free.iter().map(|&i| end[modes.chain.layout().half() + i]);
        let mut residual = DVector::from_iterator(m, velocities) / (a * omega);
        let mut jacobian = DMatrix::zeros(m, 0);
        if derivative {
            let others: Vec<usize> = (0..m).filter(|&k| k != linear.leading).collect();
            let (acceleration, _) = modes.linearised(&end)?;
            jacobian = modes.tangent(&start, half, &others)?.rows(m, m) / omega;
            jacobian = jacobian.insert_column(m - 1, 0.0);
            jacobian.set_column(m - 1, &(-acceleration * (half / (a * omega)) - &residual));
        }
        if modes.translates {
            let total: f64 = modes.masses.iter().sum();
            let weight = |k: usize| modes.masses[k] / total;
            residual = residual.push((0..m).map(|k| weight(k) * shape[k]).sum());
            let columns = jacobian.ncols();
            jacobian = jacobian.insert_row(m, 0.0);
            for (column, k) in (0..m).filter(|&k| k != linear.leading).enumerate().take(columns) {
                jacobian[(m, column)] = weight(k);
            }
        }
        Ok(Equations { residual, jacobian })
    }

    fn solve(&self, modes: &NormalModes, seed: &[f64], a: f64) -> Result<Solution> {
        let (mut z, mut newton) = (DVector::from_column_slice(seed), Vec::new());
        while newton.len() < arclength::MOST_CORRECTIONS {
            let Equations { residual, jacobian } = self.equations(modes, z.as_slice(), a, true)?;
            let Some(by) = least_squares(jacobian, &residual) else { break };
            newton.push(NewtonStep { residual: residual.amax() / self.size(modes, z.as_slice(), a), step: by.amax() });
            z -= &by;
            if by.amax() <= LAST_STEP {
                let residual =
                    self.equations(modes, z.as_slice(), a, false)?.residual.amax() / self.size(modes, z.as_slice(), a);
                if residual <= SOLVED {
                    return Ok(Solution { z: z.as_slice().to_vec(), p: a, residual, newton });
                }
                break;
            }
        }
        Err(Error::Stalled { steps: newton.len(), best: None })
    }

    fn size(&self, modes: &NormalModes, z: &[f64], a: f64) -> f64 {
        max_norm(z.iter().copied()).max(1.0).max(ROUNDED * modes.overlap / a.abs().min(self.step))
    }

    fn solved(&self, _modes: &NormalModes, _z: &[f64], _a: f64) -> f64 {
        SOLVED
    }

    fn orbit(&self, modes: &NormalModes, Solution { z, p, residual, newton }: &Solution) -> ModeOrbit {
        let (shape, omega) = modes.linear[self.mode].parts(z);
        ModeOrbit { amplitude: *p, omega, w: z[z.len() - 1], shape, residual: *residual, newton: newton.clone() }
    }

    fn solution(&self, modes: &NormalModes, orbit: &ModeOrbit) -> Solution {
        let &ModeOrbit { amplitude: p, w, ref shape, residual, ref newton, .. } = orbit;
        let z = modes.linear[self.mode].unknowns(shape, w);
        Solution { z, p, residual, newton: newton.clone() }
    }

    fn spectrum(&self, modes: &NormalModes, orbit: &ModeOrbit) -> Result<Spectrum> {
        let trivial = [(1.0, Kind::Trivial); 2];
        let exact = &trivial[..1 + usize::from(modes.translates)];
        let start = modes.start(orbit.amplitude, &orbit.shape);
        let m = modes.free.len();
        let mut tangent = modes.tangent(&start, PI / orbit.omega, &(0..2 * m).collect::<Vec<_>>())?;
        // Of `q'/omega`, so that rows and columns have the same unit.
        tangent.rows_mut(m, m).scale_mut(orbit.omega.recip());
        tangent.columns_mut(m, m).scale_mut(orbit.omega);
        Spectrum::new(&Frame::of_masses(&modes.masses), &tangent, STEPS * TANGENT_TOL, exact).ok_or_else(|| {
            let rule = "no multipliers: the eigenvalues did not converge";
            Error::parameter("amplitude", orbit.amplitude, rule)
        })
    }

    fn measures(&self, modes: &NormalModes, orbit: &ModeOrbit) -> Result<ModeMeasures> {
        let (start, end) = (modes.start(orbit.amplitude, &orbit.shape), modes.turning_point(orbit)?);
        let energy = |state: &[f64]| modes.chain.energy(state).total() - modes.chain.work_of_loads(state);
        let bonds = modes.chain.touching();
        let overlaps = [&start, &end].map(|state| modes.chain.overlaps(modes.chain.layout().u(state)));
        let overlaps = overlaps.iter().flat_map(|overlaps| &overlaps[bonds.clone()]);
        Ok(ModeMeasures {
            energy: energy(&start) - energy(&modes.rest),
            participation: participation(&orbit.shape, &modes.masses),
            least_overlap: overlaps.copied().fold(f64::INFINITY, f64::min),
        })
    }

    fn arrays(modes: &NormalModes) -> Vec<(&'static str, usize)> {
        vec![("z", modes.free.len())]
    }

    fn verify(&self, modes: &NormalModes, orbit: &ModeOrbit) -> Result<()> {
        let details = modes.chain.details().cloned().unwrap_or_default();
        let further = details.terms.iter().map(|term| term.alpha);
        let alpha = details.alpha.into_iter().chain(further).fold(modes.chain.params().alpha, f64::max);
        let unit = if modes.overlap > 0.0 { modes.overlap } else { 1.0 };
        let most = modes.overlap + 2.0 * orbit.amplitude.abs() * max_norm(orbit.shape.iter().copied());
        let highest = modes.linear.last().map_or(0.0, |mode| mode.omega);
        let highest = if modes.center.is_some() { highest.hypot((4.0 * alpha).sqrt()) } else { highest };
        let Solution { z, p, .. } = self.solution(modes, orbit);
        returns(highest * (most / unit).powf(0.5 * (alpha - 1.0)) / orbit.omega, || {
            Ok(self.equations(modes, &z, p, false)?.residual.amax() / self.size(modes, &z, p))
        })
    }

    fn least_change(&self, a: f64) -> f64 {
        LEAST_CHANGE * a.abs()
    }

    /// An orbit is at rest twice in a period, at `t = 0` and `t = T/2`. The orbits of doubled
    /// period that begin at a period doubling are at rest near one of these two times, and again a
    /// period `T` later. So both times are tried as the start of the new orbits.
    fn crossing(
        &self,
        modes: &NormalModes,
        kind: BifurcationKind,
    ) -> Result<std::result::Result<(NormalModes, usize), &'static str>> {
        if modes.center.is_some() {
            return Ok(Err("none is followed from breathers that are symmetric about their centre"));
        }
        Ok(match kind {
            BifurcationKind::PeriodDoubling => Ok((modes.clone(), 2)),
            BifurcationKind::PlusOne => Ok((modes.clone(), 1)),
            _ => Err("a period doubling or a branch point where one other branch crosses"),
        })
    }

    /// At `T/2` the leading coordinate may have the other sign; the amplitude is then negative.
    fn crossed(
        &self,
        modes: &NormalModes,
        orbit: &ModeOrbit,
        kind: BifurcationKind,
        way: usize,
    ) -> Result<(Vec<f64>, f64)> {
        let (linear, doubled) = (&modes.linear[self.mode], kind == BifurcationKind::PeriodDoubling);
        let w = if doubled { (0.5 * orbit.omega / linear.omega).ln() } else { orbit.w };
        if way == 0 {
            return Ok((linear.unknowns(&orbit.shape, w), orbit.amplitude));
        }
        let q = modes.turned(orbit)?;
        let amplitude = q[linear.leading];
        Ok((linear.unknowns((q / amplitude).as_slice(), w), amplitude))
    }

    /// Displacements, divided by the amplitude.
    fn halves_apart(&self, modes: &NormalModes, orbit: &ModeOrbit) -> Result<DVector<f64>> {
        Ok(modes.turned(orbit)? / orbit.amplitude - DVector::from_column_slice(&orbit.shape))
    }
}
