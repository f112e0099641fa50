//! Nonlinear normal modes of conservative chains: periodic orbits that begin as linear modes about
//! the equilibrium. Modes of defects, and of the gaps of dimers, are among them.
//!
//! | symbol | meaning |
//! |---|---|
//! | `q` | displacements from the equilibrium, of beads and of resonators that move |
//! | `m` | masses of these beads and resonators |
//! | `K` | stiffness, `m q'' = -K q + O(q^{3/2})`; `K s = omega_0^2 m s` for a linear mode |
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
    arclength::{self, BasePoint, BranchState, ContinuationOptions, End, Family, Scales, Solution},
    bifurcation::{self, BifurcationKind},
    floquet::{Frame, Kind, Spectrum},
    mode_trail::ModeTrail,
    shooting::{Equations, NewtonStep, least_squares},
};
use crate::{
    chain::{Chain, State, Variations, max_norm},
    error::{Error, Result},
};
use hertzchain_integrators::VectorField;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A linear mode about the equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMode {
    /// Frequency `omega_0`.
    pub omega: f64,
    /// Displacements `s`, scaled to `s_j = 1`.
    pub shape: Vec<f64>,
    /// `j`, the first coordinate with the largest share `m s^2`.
    pub leading: usize,
    /// Participation number `(sum m s^2)^2 / sum (m s^2)^2`: 1 if only one coordinate moves.
    pub participation: f64,
}

/// A conservative chain at its equilibrium, and its linear modes.
#[derive(Clone, Debug)]
pub struct NormalModes {
    pub(super) chain: Chain<f64>,
    /// Entries of a state that are coordinates `q`.
    pub(super) free: Vec<usize>,
    masses: Vec<f64>,
    /// The state at rest in the equilibrium.
    pub(super) rest: Vec<f64>,
    /// Largest overlap in the equilibrium.
    overlap: f64,
    /// Whether equal displacements of all coordinates change no force, as on a ring.
    translates: bool,
    linear: Vec<LinearMode>,
}

/// Largest number of sites.
const MOST_SITES: usize = 256;
/// Steps of Newton's method to the equilibrium.
const MOST_STEPS: usize = 50;
/// A step to the equilibrium below this share of the largest overlap is the last one.
const AT_REST: f64 = 1e-13;
/// Squares of frequencies below this share of the largest are zero.
const ZERO: f64 = 1e-12;
/// Tolerances of a step of the flow and of the tangent map.
pub(super) const TOL: f64 = 1e-14;
const TANGENT_TOL: f64 = 1e-12;
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
/// Least unit of the amplitude for the stretch between two points, as a share of the amplitude:
/// beside a fold both points have nearly the same amplitude.
const LEAST_CHANGE: f64 = 1e-3;
/// Collisions that lead to no modulus above `1 + WEAK` are not located. Chosen: long chains have
/// many weaker ones.
pub(super) const WEAK: f64 = 1e-3;

impl NormalModes {
    /// The linear modes of a chain about its equilibrium, the lowest frequency first.
    ///
    /// ```
    /// use hertzchain::{chain::{Boundary, Chain, Params}, orbits::NormalModes};
    /// // Two beads between walls: in phase and in antiphase; each contact has the stiffness 2 d.
    /// let params = Params::new(2.0, 0.0, 0.0)?;
    /// let chain = Chain::new(params, Boundary::Fixed, 2)?.precompressed(0.5)?;
    /// let modes = NormalModes::new(&chain)?;
    /// let squares: Vec<f64> = modes.linear().iter().map(|mode| mode.omega.powi(2)).collect();
    /// assert!((squares[0] - 1.0).abs() < 1e-14 && (squares[1] - 3.0).abs() < 1e-14);
    /// # Ok::<(), hertzchain::Error>(())
    /// ```
    ///
    /// # Errors
    /// A chain that dissipates or is driven; a strain ring; `alpha <= 1`; more than 256 sites; no
    /// equilibrium near, or one in which contacts do not hold all beads.
    pub fn new(chain: &Chain<f64>) -> Result<Self> {
        if chain.open() {
            return Err(Error::parameter("chain", "damped or driven", "normal modes need a conservative chain"));
        }
        let n = chain.sites();
        if n > MOST_SITES {
            return Err(Error::parameter("sites", n, "at most 256 sites for a tangent map"));
        }
        let resonators = (0..n).filter(|&i| chain.resonator_moves(i));
        let free: Vec<usize> = (0..n).chain(resonators.clone().map(|i| n + i)).collect();
        let beads = (0..n).map(|i| chain.masses(i)[0]);
        let masses: Vec<f64> = beads.chain(resonators.map(|i| chain.masses(i)[1])).collect();
        let rest = State::rest(chain).as_slice().to_vec();
        let mut modes =
            Self { chain: chain.clone(), free, masses, rest, overlap: 0.0, translates: false, linear: Vec::new() };
        modes.settle()?;
        modes.linear = modes.linear_modes()?;
        Ok(modes)
    }

    /// The linear modes, the lowest frequency first. The translation of a ring is not among them.
    pub fn linear(&self) -> &[LinearMode] {
        &self.linear
    }

    /// The chain.
    pub fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    /// The number, from 0 on, of the linear mode with the least participation number.
    pub fn most_localised(&self) -> usize {
        let participation = |k: &usize| self.linear[*k].participation;
        (0..self.linear.len()).min_by(|a, b| participation(a).total_cmp(&participation(b))).unwrap_or(0)
    }

    /// Site of a coordinate, and whether the coordinate is that of a resonator.
    pub fn place(&self, coordinate: usize) -> (usize, bool) {
        let n = self.chain.sites();
        (self.free[coordinate] % n, self.free[coordinate] >= n)
    }

    /// Accelerations `q''` at a state, and their derivative by `q`.
    fn linearised(&self, state: &[f64]) -> Result<(DVector<f64>, DMatrix<f64>)> {
        let (m, half) = (self.free.len(), self.chain.layout().half());
        let mut field = Variations::new(&self.chain, m)?;
        let mut y = state.to_vec();
        y.resize(state.len() + field.rows() * m, 0.0);
        for (j, &i) in self.free.iter().enumerate() {
            y[state.len() + i * m + j] = 1.0;
        }
        let mut rates = vec![0.0; y.len()];
        field.eval(0.0, &y, &mut rates);
        let columns = &rates[state.len()..];
        let acceleration = self.free.iter().map(|&i| rates[half + i]);
        Ok((
            DVector::from_iterator(m, acceleration),
            DMatrix::from_fn(m, m, |k, j| columns[(half + self.free[k]) * m + j]),
        ))
    }

    /// Moves the state at rest to the equilibrium, by Newton's method.
    fn settle(&mut self) -> Result<()> {
        for _ in 0..MOST_STEPS {
            let overlaps = self.chain.overlaps(self.chain.layout().u(&self.rest));
            self.overlap = overlaps.into_iter().fold(0.0, f64::max);
            let (mut force, mut slope) = self.linearised(&self.rest)?;
            self.translates = slope.column_sum().amax() < ZERO * slope.amax();
            if self.translates {
                let rows = slope.nrows();
                slope = slope.insert_row(rows, 0.0);
                slope.set_row(rows, &DVector::from_column_slice(&self.masses).transpose());
                force = force.push(0.0);
            }
            let Some(step) = least_squares(slope, &force) else { return Err(not_held()) };
            for (&i, step) in self.free.iter().zip(&step) {
                self.rest[i] -= step;
            }
            if step.amax() <= AT_REST * self.overlap {
                return Ok(());
            }
        }
        Err(not_held())
    }

    fn linear_modes(&self) -> Result<Vec<LinearMode>> {
        let (_, slope) = self.linearised(&self.rest)?;
        let root: Vec<f64> = self.masses.iter().map(|m| m.sqrt()).collect();
        let scaled = |i: usize, j: usize| -slope[(i, j)] * root[i] / root[j];
        let stiffness = DMatrix::from_fn(root.len(), root.len(), |i, j| 0.5 * (scaled(i, j) + scaled(j, i)));
        let eigen = stiffness.symmetric_eigen();
        let largest = eigen.eigenvalues.amax();
        let mut order: Vec<usize> = (0..root.len()).filter(|&k| eigen.eigenvalues[k] > ZERO * largest).collect();
        if order.len() + usize::from(self.translates) < root.len() {
            return Err(not_held());
        }
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        Ok(order
            .into_iter()
            .map(|k| {
                let vector = eigen.eigenvectors.column(k);
                let shape: Vec<f64> = vector.iter().zip(&root).map(|(v, root)| v / root).collect();
                let leading = leading(&shape, &self.masses);
                let shape: Vec<f64> = shape.iter().map(|s| s / shape[leading]).collect();
                let participation = participation(&shape, &self.masses);
                LinearMode { omega: eigen.eigenvalues[k].sqrt(), shape, leading, participation }
            })
            .collect())
    }

    /// The state of an orbit at `t = 0`.
    pub fn state(&self, orbit: &ModeOrbit) -> State<f64> {
        let mut state = State::rest(&self.chain);
        state.as_mut_slice().copy_from_slice(&self.start(orbit.amplitude, &orbit.shape));
        state
    }

    /// The state at rest with the displacements `a shape`.
    pub(super) fn start(&self, a: f64, shape: &[f64]) -> Vec<f64> {
        let mut state = self.rest.clone();
        for (&i, shape) in self.free.iter().zip(shape) {
            state[i] += a * shape;
        }
        state
    }

    /// The derivative of the flow over the time `t`. Its rows are the displacements and then the
    /// velocities of the free coordinates; its columns are those with the numbers `directions`.
    fn tangent(&self, start: &[f64], t: f64, directions: &[usize]) -> Result<DMatrix<f64>> {
        let (half, k) = (self.chain.layout().half(), directions.len());
        let entry = |c: usize| self.free[c % self.free.len()] + half * (c / self.free.len());
        let mut columns = vec![0.0; 2 * half * k];
        for (j, &c) in directions.iter().enumerate() {
            columns[entry(c) * k + j] = 1.0;
        }
        let end = Variations::flow(&self.chain, start, (0.0, t), &columns, TANGENT_TOL)?.columns;
        Ok(DMatrix::from_fn(2 * self.free.len(), k, |c, j| end[entry(c) * k + j]))
    }
}

fn not_held() -> Error {
    let rule = "closed contacts hold every bead, as those with a static overlap between walls do";
    Error::parameter("chain", "a bead is not held", rule)
}

/// The coordinate with the largest share `m s^2`; the first of those that are equal up to rounding.
fn leading(shape: &[f64], masses: &[f64]) -> usize {
    let share = |k: &usize| masses[*k] * shape[*k] * shape[*k];
    let largest = max_norm((0..shape.len()).map(|k| share(&k)));
    (0..shape.len()).find(|k| share(k) >= (1.0 - 1e-9) * largest).unwrap_or(0)
}

fn participation(shape: &[f64], masses: &[f64]) -> f64 {
    let shares = || shape.iter().zip(masses).map(|(s, m)| m * s * s);
    shares().sum::<f64>().powi(2) / shares().map(|share| share * share).sum::<f64>()
}

/// An orbit of a nonlinear normal mode.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ModeOrbit {
    /// Amplitude `a`; negative on some branches of doubled period.
    pub amplitude: f64,
    /// Frequency `omega`.
    pub omega: f64,
    /// Shape `xi`, of beads and of resonators that move.
    pub shape: Vec<f64>,
    /// Largest residual of the equations, in units of the largest of: 1, the unknowns, and a
    /// hundredth of the largest static overlap over the amplitude or, if it is smaller, over the
    /// largest step of the branch.
    pub residual: f64,
    /// Steps of Newton's method.
    pub newton: Vec<NewtonStep>,
}

/// An orbit of a branch with its energy, participation number, least overlap and multipliers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ModePoint {
    /// The orbit.
    pub orbit: ModeOrbit,
    /// Energy above that of the equilibrium.
    pub energy: f64,
    /// `(sum m xi^2)^2 / sum (m xi^2)^2`.
    pub participation: f64,
    /// The least overlap of all contacts at the two times of rest; negative if beads are apart.
    pub least_overlap: f64,
    /// The multipliers.
    pub spectrum: Spectrum,
}

impl ModePoint {
    /// Number of multipliers that lie outside the unit circle by more than their error.
    pub fn unstable(&self) -> usize {
        self.spectrum.multipliers.iter().filter(|one| one.modulus - one.error > 1.0).count()
    }
}

/// Settings of a branch of orbits that begins as a linear mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeContinuation {
    /// Number of the linear mode.
    pub mode: usize,
    /// The amplitude at which the branch ends.
    pub to: f64,
    /// The largest change of the amplitude from point to point, and the first amplitude, unless the
    /// orbit of this amplitude that is found differs much from the linear mode: see
    /// [`follow`](Self::follow).
    pub step: f64,
    /// Largest number of points.
    pub most_points: usize,
}

/// A bifurcation of a branch of orbits.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ModeBifurcation {
    /// The kind of bifurcation.
    pub kind: BifurcationKind,
    /// `tau = (lambda + 1/lambda)/2` of the multipliers that meet; 1 at a fold.
    pub tau: f64,
    /// The orbit there.
    pub point: ModePoint,
    /// Number of the point of the branch before it, from 0 on.
    pub after: usize,
}

/// A branch of orbits in the amplitude.
#[derive(Clone, Debug)]
pub struct ModeBranch {
    /// How it was followed.
    pub continuation: ModeContinuation,
    /// Its points, at least one.
    pub points: Vec<ModePoint>,
    /// The bifurcations between them, in their order, with the folds last.
    pub bifurcations: Vec<ModeBifurcation>,
    /// Number of stretches with several bifurcations that were not separated.
    pub unresolved: usize,
    /// Why it ended.
    pub end: End,
}

impl ModeContinuation {
    /// Refuses numbers outside their rules.
    ///
    /// # Errors
    /// No such mode; amplitudes that are not positive; fewer than two points.
    pub fn check(&self, modes: &NormalModes) -> Result<()> {
        let count = modes.linear.len();
        if self.mode >= count {
            let value = format!("{} of {count}", self.mode.wrapping_add(1));
            return Err(Error::parameter("linear_mode", value, "linear modes are numbered from 1, by frequency"));
        }
        if !(self.to.is_finite() && self.to > 0.0) {
            return Err(Error::parameter("to", self.to, "an amplitude is finite and positive"));
        }
        arclength::check([self.step, self.to], self.step, self.most_points)?;
        if self.step > self.to {
            return Err(Error::parameter("step", self.step, "at most the last amplitude"));
        }
        Ok(())
    }

    /// Follows the branch, past folds, and locates the bifurcations between its points; `seen` is
    /// called with every point. Collisions of multipliers that lead to no modulus above 1.001 are
    /// left out.
    ///
    /// The first orbit is sought from the linear mode, at the amplitude `step`. While Newton's
    /// corrections do not contract, or shape and frequency turn by more than 25 degrees from those
    /// of the linear mode, in the space of the unknowns, the amplitude is halved.
    ///
    /// # Errors
    /// Numbers outside their rules; a first orbit that is not found; multipliers that cannot be
    /// computed; a signal before the second point. A later one ends the branch.
    pub fn follow(&self, modes: &NormalModes, seen: impl FnMut(&ModePoint)) -> Result<ModeBranch> {
        self.trail(modes, seen).map(|trail| trail.located(modes))
    }

    /// The branch of [`follow`](Self::follow) without its bifurcations.
    pub(crate) fn trail(&self, modes: &NormalModes, mut seen: impl FnMut(&ModePoint)) -> Result<ModeTrail> {
        self.check(modes)?;
        let family = ModeFamily::new(modes, self);
        let mut seed = family.linear.shape.clone();
        seed.remove(family.linear.leading);
        seed.push(0.0);
        let first = family.first(&seed, self.step)?;
        let mut points = vec![family.point(&first)?];
        seen(&points[0]);
        let way = ContinuationOptions { to: self.to, step: self.step, natural: false, direction: 1.0 };
        let ds = first.p / (self.to - first.p);
        let course = BranchState { back: first.p, previous: None, last: (first.z, first.p), ds, points: 1 };
        let end = arclength::follow(&family, course, way, self.most_points, &mut |solution, _, _| {
            let Ok(point) = family.point(solution) else { return Ok(Some(End::NoMultipliers)) };
            seen(&point);
            points.push(point);
            Ok(None)
        });
        let end = arclength::kept(end)?;
        Ok(ModeTrail { continuation: *self, points, end, first: 0 })
    }
}

/// The part of a vector that is orthogonal to an orthonormal basis.
fn outside(basis: &[DVector<f64>], x: DVector<f64>) -> DVector<f64> {
    basis.iter().fold(x, |x, b| &x - b * b.dot(&x))
}

/// The orbits of a mode, with the amplitude as parameter.
pub(super) struct ModeFamily<'a> {
    pub(super) modes: &'a NormalModes,
    pub(super) linear: &'a LinearMode,
    /// [`ROUNDED`] times the largest static overlap; over the amplitude it is the least unit of
    /// residuals.
    floor: f64,
    /// Largest amplitude in that unit.
    step: f64,
}

impl<'a> ModeFamily<'a> {
    pub(super) fn new(modes: &'a NormalModes, continuation: &ModeContinuation) -> Self {
        let linear = &modes.linear[continuation.mode];
        Self { modes, linear, floor: ROUNDED * modes.overlap, step: continuation.step }
    }

    /// The orbit near the linear mode, whose unknowns are `seed`, at the amplitude `step` or a
    /// smaller one.
    fn first(&self, seed: &[f64], step: f64) -> Result<Solution> {
        // Modes of one frequency, as on a ring, may have any shape among theirs: an orthonormal
        // basis.
        let one = |mode: &&LinearMode| (mode.omega / self.linear.omega - 1.0).abs() < DEGENERATE;
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for mode in self.modes.linear.iter().filter(one) {
            let shape = DVector::from_column_slice(&mode.shape);
            basis.push(outside(&basis, shape).normalize());
        }
        let near = |found: &Solution| {
            let (shape, omega) = self.parts(&found.z);
            let shape = DVector::from_vec(shape);
            let apart = outside(&basis, shape.clone()).norm().hypot((omega / self.linear.omega).ln());
            let size = (shape.norm_squared() - apart * apart).max(0.0).sqrt();
            // Newton's method is slow along modes of one frequency.
            let newton = if basis.len() > 1 { &[] } else { &found.newton[..] };
            !arclength::strays(size.hypot(apart), size, newton)
        };
        let at = |k: u32| self.solve(seed, step * 0.5f64.powf(f64::from(k))).ok().filter(near);
        (0..=MOST_HALVINGS).find_map(at).ok_or_else(|| {
            Error::parameter("step", step, "there is no orbit near the linear mode, down to a thousandth of the step")
        })
    }

    /// Shape `xi` and frequency `omega` for the unknowns `z`.
    fn parts(&self, z: &[f64]) -> (Vec<f64>, f64) {
        let mut shape = z[..z.len() - 1].to_vec();
        shape.insert(self.linear.leading, 1.0);
        (shape, self.linear.omega * z[z.len() - 1].exp())
    }

    /// The unknowns of an orbit.
    pub(super) fn unknowns(&self, orbit: &ModeOrbit) -> Vec<f64> {
        let mut z = orbit.shape.clone();
        z.remove(self.linear.leading);
        z.push((orbit.omega / self.linear.omega).ln());
        z
    }

    pub(super) fn point(&self, solution: &Solution) -> Result<ModePoint> {
        let (modes, m) = (self.modes, self.modes.free.len());
        let (shape, omega) = self.parts(&solution.z);
        let (start, half) = (modes.start(solution.p, &shape), std::f64::consts::PI / omega);
        let end = Variations::flow(&modes.chain, &start, (0.0, half), &[], TOL)?.state;
        let energy = |state: &[f64]| modes.chain.energy(state).total();
        let overlaps = [&start, &end].map(|state| modes.chain.overlaps(modes.chain.layout().u(state)));
        let bonds = modes.chain.touching();
        let least =
            overlaps.iter().flat_map(|overlaps| &overlaps[bonds.clone()]).copied().fold(f64::INFINITY, f64::min);
        let trivial = [(1.0, Kind::Trivial); 2];
        let exact = &trivial[..1 + usize::from(modes.translates)];
        let tangent = modes.tangent(&start, half, &(0..2 * m).collect::<Vec<_>>())?;
        let spectrum = Spectrum::new(&Frame::of_masses(&modes.masses), &tangent, exact);
        let none = || Error::parameter("amplitude", solution.p, "no multipliers: the eigenvalues did not converge");
        Ok(ModePoint {
            energy: energy(&start) - energy(&modes.rest),
            participation: participation(&shape, &modes.masses),
            least_overlap: least,
            spectrum: spectrum.ok_or_else(none)?,
            orbit: ModeOrbit {
                amplitude: solution.p,
                omega,
                shape,
                residual: solution.residual,
                newton: solution.newton.clone(),
            },
        })
    }
}

impl Family for ModeFamily<'_> {
    fn equations(&self, z: &[f64], a: f64, derivative: bool) -> Result<Equations> {
        let (modes, m) = (self.modes, self.modes.free.len());
        let (shape, omega) = self.parts(z);
        let (start, half) = (modes.start(a, &shape), std::f64::consts::PI / omega);
        let end = Variations::flow(&modes.chain, &start, (0.0, half), &[], TOL)?.state;
        let velocities = modes.free.iter().map(|&i| end[modes.chain.layout().half() + i]);
        let mut residual = DVector::from_iterator(m, velocities) / (a * omega);
        let mut jacobian = DMatrix::zeros(m, 0);
        if derivative {
            let others: Vec<usize> = (0..m).filter(|&k| k != self.linear.leading).collect();
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
            for (column, k) in (0..m).filter(|&k| k != self.linear.leading).enumerate().take(columns) {
                jacobian[(m, column)] = weight(k);
            }
        }
        Ok(Equations { residual, jacobian })
    }

    fn solve(&self, seed: &[f64], a: f64) -> Result<Solution> {
        let (mut z, mut newton) = (DVector::from_column_slice(seed), Vec::new());
        while newton.len() < arclength::MOST_CORRECTIONS {
            let Equations { residual, jacobian } = self.equations(z.as_slice(), a, true)?;
            let Some(by) = least_squares(jacobian, &residual) else { break };
            newton.push(NewtonStep { residual: residual.amax() / self.size(z.as_slice(), a), step: by.amax() });
            z -= &by;
            if by.amax() <= LAST_STEP {
                let residual = self.equations(z.as_slice(), a, false)?.residual.amax() / self.size(z.as_slice(), a);
                if residual <= SOLVED {
                    return Ok(Solution { z: z.as_slice().to_vec(), p: a, residual, newton });
                }
                break;
            }
        }
        Err(Error::Stalled { steps: newton.len(), best: None })
    }

    fn size(&self, z: &[f64], a: f64) -> f64 {
        max_norm(z.iter().copied()).max(1.0).max(self.floor / a.abs().min(self.step))
    }

    fn solved(&self, _z: &[f64], _a: f64) -> f64 {
        SOLVED
    }
}

impl bifurcation::Branch for ModeFamily<'_> {
    type Point = ModePoint;
    const NEAR: f64 = 5e-8;

    fn spectrum<'a>(&self, point: &'a ModePoint) -> &'a Spectrum {
        &point.spectrum
    }

    fn place(&self, ModePoint { orbit, .. }: &ModePoint) -> (Vec<f64>, f64) {
        (self.unknowns(orbit), orbit.amplitude)
    }

    fn scales(&self, (z, a): (&[f64], f64), change: f64) -> Scales {
        Scales::new(z, change.abs().max(LEAST_CHANGE * a.abs()))
    }

    fn step(&self, from: &ModePoint, chord: &DVector<f64>, scales: Scales, ds: f64) -> Result<ModePoint> {
        let z = self.unknowns(&from.orbit);
        let spot = BasePoint { z: &z, p: from.orbit.amplitude, tangent: chord };
        self.point(&arclength::correct(self, spot, scales, ds)?)
    }

    fn tangent(&self, at: &ModePoint, scales: Scales, before: &DVector<f64>) -> Result<DVector<f64>> {
        let z = self.unknowns(&at.orbit);
        arclength::tangent(self, (&z, at.orbit.amplitude), scales, before)
    }
}
