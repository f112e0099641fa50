//! Linear modes of conservative chains about their equilibrium.
//!
//! | symbol | meaning |
//! |---|---|
//! | `q` | displacements from the equilibrium, of beads and of resonators that move |
//! | `m` | masses of these beads and resonators |
//! | `K` | stiffness, `m q'' = -K q + O(q^{3/2})`; `K s = omega_0^2 m s` for a linear mode |

use super::shooting::least_squares;
use crate::{
    chain::{Chain, Details, Drive, DriveKind, State, Variations, max_norm},
    dps::Center,
    error::{Error, Result, require},
    numerics::{leading, least_by},
};
use hertzchain_integrators::VectorField;
use nalgebra::{DMatrix, DVector};

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
    pub(super) masses: Vec<f64>,
    /// The state at rest in the equilibrium.
    pub(super) rest: Vec<f64>,
    /// Largest overlap in the equilibrium.
    pub(super) overlap: f64,
    /// Whether equal displacements of all coordinates change no force, as on a ring.
    pub(super) translates: bool,
    pub(super) vacuum: bool,
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
/// Tolerance of a step of the tangent map.
pub(super) const TANGENT_TOL: f64 = 1e-12;

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
        if chain.tied() || !touch(chain) {
            return Self::held(chain, &[]);
        }
        let loaded = Self::held(&loaded(chain, 1.0)?, &[])?;
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

    /// The middle of a chain in which each bead just touches its neighbours and has an equal spring
    /// of its own: a site of an odd number of beads, a bond of an even one. There breathers begin.
    fn local(&self) -> Option<Center> {
        let ([first, .., last], chain) = (self.linear(), self.chain()) else { return None };
        let (n, [left, right]) = (self.coordinates(), chain.boundary().walls());
        let same = |list: &[f64]| list.windows(2).all(|pair| pair[0] == pair[1]);
        let details = chain.details().is_none_or(|details| {
            let lists = [&details.mass, &details.contact, &details.alpha, &details.onsite];
            details.own_law().is_none() && lists.into_iter().all(|list| same(list))
        });
        let alone = self.linear().iter().all(|mode| mode.participation < 1.0 + f64::EPSILON);
        let symmetric = n == chain.sites() && left == right && details && first.omega == last.omega;
        let center = if n % 2 == 1 { Center::Site } else { Center::Bond };
        (symmetric && alone && touch(chain)).then_some(center)
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

/// Whether all beads just touch, without loads.
fn touch(chain: &Chain<f64>) -> bool {
    !chain.open() && chain.overlaps(&vec![0.0; chain.sites()])[chain.touching()].iter().all(|overlap| *overlap == 0.0)
}

/// The chain with this static overlap at every contact.
pub(super) fn loaded(chain: &Chain<f64>, overlap: f64) -> Result<Chain<f64>> {
    let details = chain.details().cloned().unwrap_or_default();
    let details = Details { overlap: vec![overlap; chain.touching().len()], ..details };
    Chain::new(chain.params(), chain.boundary(), chain.sites())?.with(&details)
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

pub(super) fn participation(shape: &[f64], masses: &[f64]) -> f64 {
    let shares = || shape.iter().zip(masses).map(|(s, m)| m * s * s);
    shares().sum::<f64>().powi(2) / shares().map(|share| share * share).sum::<f64>()
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
