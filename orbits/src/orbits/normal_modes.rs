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
    arclength::{self, Range, Solution},
    bifurcation::{self, BifurcationKind, CriticalPair},
    branch::{At, Branch, Located, Problem, ranged},
    driven::returns,
    floquet::{Frame, Kind, Spectrum},
    shooting::{Equations, NewtonStep, least_squares},
    touching,
};
use crate::{
    chain::{Chain, Details, Drive, DriveKind, State, Variations, max_norm},
    dps::Center,
    error::{Error, Result, require},
    numerics::{leading, least_by},
    output::FileFormat,
};
use hertzchain_integrators::VectorField;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

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
    chain: Chain<f64>,
    /// Entries of a state that are coordinates `q`.
    free: Vec<usize>,
    masses: Vec<f64>,
    /// The state at rest in the equilibrium.
    rest: Vec<f64>,
    /// Largest overlap in the equilibrium.
    overlap: f64,
    /// Whether equal displacements of all coordinates change no force, as on a ring.
    translates: bool,
    vacuum: bool,
    /// Where breathers of beads that just touch have their centre.
    pub(super) center: Option<Center>,
    pub(super) linear: Vec<LinearMode>,
}

/// Largest number of sites.
const MOST_SITES: usize = 256;
/// Steps of Newton's method to the equilibrium.
const MOST_STEPS: usize = 1000;
/// Least share of a step of Newton's method to the equilibrium.
const LEAST_SHARE: f64 = 1e-3;
/// A step to the equilibrium below this share of the largest overlap is the last one.
const AT_REST: f64 = 1e-13;
/// Squares of frequencies below this share of the largest are zero.
const ZERO: f64 = 1e-12;
/// Tolerances of a step of the flow and of the tangent map.
const TOL: f64 = 1e-14;
const TANGENT_TOL: f64 = 1e-12;
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

impl NormalModes {
    /// The linear modes of a chain about its equilibrium, the lowest frequency first.
    ///
    /// ```
    /// use hertzchain_orbits::{chain::{Boundary, Chain, Params}, orbits::NormalModes};
    /// // Two beads between walls: in phase and in antiphase; each contact has the stiffness 2 d.
    /// let params = Params::new(2.0, 0.0, 0.0)?;
    /// let chain = Chain::new(params, Boundary::Fixed, 2)?.precompressed(0.5)?;
    /// let modes = NormalModes::new(&chain)?;
    /// let squares: Vec<f64> = modes.linear().iter().map(|mode| mode.omega.powi(2)).collect();
    /// assert!((squares[0] - 1.0).abs() < 1e-14 && (squares[1] - 3.0).abs() < 1e-14);
    /// # Ok::<(), hertzchain_orbits::Error>(())
    /// ```
    ///
    /// # Errors
    /// A chain that dissipates or is driven, except by gravity and constant forces; a strain ring;
    /// `alpha <= 1`; more than 256 sites; no equilibrium near, or one in which contacts do not hold
    /// all beads.
    pub fn new(chain: &Chain<f64>) -> Result<Self> {
        require(chain.conservative(), "chain", "damped or driven", "normal modes need a conservative chain")?;
        if chain.tied() || !touching::touch(chain) {
            return Self::held(chain, &[]);
        }
        let loaded = Self::held(&touching::loaded(chain, 1.0)?, &[])?;
        let rest = State::rest(chain).as_slice().to_vec();
        Ok(Self { chain: chain.clone(), rest, overlap: 0.0, vacuum: true, ..loaded })
    }

    /// Whether beads just touch and no spring holds them; [`linear`](Self::linear) then has the
    /// modes of the chain with the overlap 1 at every contact.
    pub fn vacuum(&self) -> bool {
        self.vacuum
    }

    /// The linear modes of a chain about its static state, without its damping and those drives
    /// that vary in time, and with some beads held in their places: those in `held`, and those that
    /// drives move.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn held(chain: &Chain<f64>, held: &[usize]) -> Result<Self> {
        let n = chain.sites();
        require(n <= MOST_SITES, "sites", n, "at most 256 sites, whose stiffnesses are one dense matrix")?;
        let drives = chain.details().map_or(&[][..], |details| &details.drives);
        let moved = drives.iter().filter(|drive| drive.kind == DriveKind::Displacement).map(|drive| drive.site);
        let held: Vec<usize> = held.iter().copied().chain(moved).collect();
        let chain = &conservative(chain)?;
        let resonators = (0..n).filter(|&i| chain.resonator_moves(i));
        let coordinates = (0..n).filter(|i| !held.contains(i));
        let free: Vec<usize> = coordinates.clone().chain(resonators.clone().map(|i| n + i)).collect();
        require(!free.is_empty(), "chain", "all beads are held", "at least one bead that can move")?;
        let beads = coordinates.map(|i| chain.masses(i)[0]);
        let masses: Vec<f64> = beads.chain(resonators.map(|i| chain.masses(i)[1])).collect();
        // Newton's method finds the equilibrium from the unloaded chain only where this has
        // stiffness.
        let loaded = chain.open() && !chain.tied();
        let rest = if loaded { State::equilibrium(chain)? } else { State::rest(chain) }.as_slice().to_vec();
        let (overlap, translates, vacuum, center, linear) = (0.0, false, false, None, Vec::new());
        let mut modes = Self { chain: chain.clone(), free, masses, rest, overlap, translates, vacuum, center, linear };
        modes.settle()?;
        modes.linear = modes.linear_modes()?;
        modes.center = modes.local();
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

    /// The state at rest in the equilibrium, in the layout of the chain without a ledger.
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// The number, from 0 on, of the linear mode with the least participation number; in a chain
    /// with breathers that of the middle bead.
    pub fn most_localised(&self) -> usize {
        if self.center.is_some() {
            return (self.linear.len() - 1) / 2;
        }
        least_by(0..self.linear.len(), |&k| self.linear[k].participation).unwrap_or(0)
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.free.len()
    }

    /// Site of a coordinate, and whether the coordinate is that of a resonator.
    pub fn place(&self, coordinate: usize) -> (usize, bool) {
        let n = self.chain.sites();
        (self.free[coordinate] % n, self.free[coordinate] >= n)
    }

    /// Accelerations `q''` at a state, and their derivative by `q`.
    pub(super) fn linearised(&self, state: &[f64]) -> Result<(DVector<f64>, DMatrix<f64>)> {
        linearised(&self.chain, &self.free, state, false)
    }

    /// Moves the state at rest to the equilibrium, by Newton's method.
    fn settle(&mut self) -> Result<()> {
        let mut here = self.linearised(&self.rest)?;
        for _ in 0..MOST_STEPS {
            let overlaps = self.chain.overlaps(self.chain.layout().u(&self.rest));
            self.overlap = overlaps.into_iter().fold(0.0, f64::max);
            // Springs may hold beads apart.
            let reach = if self.overlap > 0.0 { self.overlap } else { max_norm(self.rest.iter().copied()) };
            let (mut force, mut slope) = here;
            let (size, before) = (force.norm(), self.rest.clone());
            self.translates = slope.column_sum().amax() < ZERO * slope.amax();
            if self.translates {
                let rows = slope.nrows();
                slope = slope.insert_row(rows, 0.0);
                slope.set_row(rows, &DVector::from_column_slice(&self.masses).transpose());
                force = force.push(0.0);
            }
            let Some(step) = least_squares(slope, &force) else { return Err(not_held()) };
            let mut share = 1.0;
            loop {
                for (&i, step) in self.free.iter().zip(&step) {
                    self.rest[i] = before[i] - share * step;
                }
                if step.amax() <= AT_REST * reach {
                    return Ok(());
                }
                here = self.linearised(&self.rest)?;
                // Full steps may go to and fro over overlaps where the stiffness comes to zero.
                if here.0.norm() < size || share < LEAST_SHARE {
                    break;
                }
                share *= 0.5;
            }
        }
        Err(not_held())
    }

    /// `M^{-1/2} K M^{-1/2}` at the equilibrium, which is symmetric.
    pub(super) fn stiffness(&self) -> Result<DMatrix<f64>> {
        let (_, slope) = self.linearised(&self.rest)?;
        let root: Vec<f64> = self.masses.iter().map(|m| m.sqrt()).collect();
        let scaled = |i: usize, j: usize| -slope[(i, j)] * root[i] / root[j];
        Ok(DMatrix::from_fn(root.len(), root.len(), |i, j| 0.5 * (scaled(i, j) + scaled(j, i))))
    }

    fn linear_modes(&self) -> Result<Vec<LinearMode>> {
        let root: Vec<f64> = self.masses.iter().map(|m| m.sqrt()).collect();
        let eigen = self.stiffness()?.symmetric_eigen();
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
                let shares = shape.iter().zip(&self.masses).map(|(s, m)| m * s * s);
                let leading = leading(shares).unwrap_or(0);
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
    pub(super) fn tangent(&self, start: &[f64], t: f64, directions: &[usize]) -> Result<DMatrix<f64>> {
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

/// The drives that are part of the static state: constant forces.
pub(super) fn steady(details: &Details) -> Vec<Drive> {
    let steady = |drive: &&Drive| drive.kind == DriveKind::Force && drive.signal.is_constant();
    details.drives.iter().filter(steady).cloned().collect()
}

/// The chain without damping, dissipation and drives that vary; with the same static overlaps.
pub(super) fn conservative(chain: &Chain<f64>) -> Result<Chain<f64>> {
    match chain.details().filter(|_| chain.open()) {
        None => Ok(chain.clone()),
        Some(details) => {
            let (drag, dashpot, drives) = (Vec::new(), Vec::new(), steady(details));
            with(chain, Details { drag, dashpot, dissipation: None, drives, ..details.clone() })
        }
    }
}

/// The chain with other details, and the same static overlaps.
pub(super) fn with(chain: &Chain<f64>, details: Details) -> Result<Chain<f64>> {
    let overlap = chain.overlaps(&vec![0.0; chain.sites()])[chain.touching()].to_vec();
    let details = Details { overlap, ..details };
    Chain::new(chain.params(), chain.boundary(), chain.sites())?.with(&details)
}

/// Accelerations `q''` of the coordinates `free` at a state, and their derivative by `q`, or by
/// `q'`.
pub(super) fn linearised(
    chain: &Chain<f64>,
    free: &[usize],
    state: &[f64],
    by_velocities: bool,
) -> Result<(DVector<f64>, DMatrix<f64>)> {
    let (m, half) = (free.len(), chain.layout().half());
    let first = if by_velocities { half } else { 0 };
    let mut field = Variations::new(chain, m)?;
    let mut y = state.to_vec();
    y.resize(state.len() + field.rows() * m, 0.0);
    for (j, &i) in free.iter().enumerate() {
        y[state.len() + (first + i) * m + j] = 1.0;
    }
    let mut rates = vec![0.0; y.len()];
    field.eval(0.0, &y, &mut rates);
    let columns = &rates[state.len()..];
    let acceleration = free.iter().map(|&i| rates[half + i]);
    Ok((DVector::from_iterator(m, acceleration), DMatrix::from_fn(m, m, |k, j| columns[(half + free[k]) * m + j])))
}

fn not_held() -> Error {
    let why = "a bead is not held: closed contacts hold every bead, as those with a static overlap between walls do";
    Error::Options(why.to_owned())
}

fn participation(shape: &[f64], masses: &[f64]) -> f64 {
    let shares = || shape.iter().zip(masses).map(|(s, m)| m * s * s);
    shares().sum::<f64>().powi(2) / shares().map(|share| share * share).sum::<f64>()
}

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

impl Spectrum {
    /// Real part, imaginary part and error of the modulus of each multiplier.
    pub(super) fn numbers(&self) -> Vec<[f64; 3]> {
        self.multipliers.iter().map(|one| [one.re, one.im, one.error]).collect()
    }

    /// Number of multipliers that lie outside the unit circle by more than their error.
    pub fn unstable(&self) -> usize {
        self.multipliers.iter().filter(|one| one.modulus - one.error > 1.0).count()
    }
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
        let localised = modes.localised()?;
        if modes.vacuum {
            return self.unloaded(modes);
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

impl LinearMode {
    /// Shape `xi` and frequency `omega` for the unknowns `z`.
    pub(super) fn parts(&self, z: &[f64]) -> (Vec<f64>, f64) {
        let mut shape = z[..z.len() - 1].to_vec();
        shape.insert(self.leading, 1.0);
        (shape, self.omega * z[z.len() - 1].exp())
    }

    /// The unknowns for a shape and `w`.
    pub(super) fn unknowns(&self, shape: &[f64], w: f64) -> Vec<f64> {
        let mut z = shape.to_vec();
        z.remove(self.leading);
        z.push(w);
        z
    }
}

impl NormalModes {
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
    type Spectrum = Spectrum;
    type Measures = ModeMeasures;
    type Critical = CriticalPair;
    const FORMAT: FileFormat = FileFormat("hertzchain mode branch", 1);
    const NEAR: f64 = 5e-8;
    /// Chosen: long chains have many weaker collisions.
    const WEAK: Option<f64> = Some(1e-3);

    fn name(&self) -> &'static str {
        "amplitude"
    }

    ranged!();

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
            return self.symmetric(modes, z, a, derivative);
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

    fn multipliers(spectrum: &Spectrum) -> Vec<[f64; 3]> {
        spectrum.numbers()
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

    fn between(branch: &Branch<Self>, ends: [At<'_, Self>; 2]) -> (Vec<Located<Self>>, usize) {
        bifurcation::between(branch, ends)
    }

    fn fold(branch: &Branch<Self>, three: [At<'_, Self>; 3]) -> Option<Located<Self>> {
        bifurcation::fold(branch, three)
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
