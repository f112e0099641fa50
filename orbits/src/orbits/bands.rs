//! Bands: the frequencies of linear waves on the infinite periodic chain.
//!
//! | symbol | meaning |
//! |---|---|
//! | `p` | beads of a cell |
//! | `theta` | phase of a wave from a cell to the next, in radians; the wave number is `theta/p` |
//! | `S_j` | stiffness over root masses, `M^{-1/2} K M^{-1/2}`, between a cell and the `j`-th after it |
//! | `omega` | frequency: `omega^2` is an eigenvalue of `S_0 + S_1 e^{i theta} + S_{-1} e^{-i theta}` |
//!
//! The blocks are those of a ring of three cells at its equilibrium, with the exact derivatives of
//! the contact law. There all contacts have one force, and the static overlaps of a cell add up to
//! those of the chain. L. Brillouin, *Wave Propagation in Periodic Structures*, Dover 1953.

use super::linear_modes::NormalModes;
use crate::{
    chain::{Boundary, Chain, Details, Params},
    error::{Error, GIVEN, Result, require},
};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::PI;

/// Most beads of a cell: a ring of three has at most 256 sites.
const MOST_CELL: usize = 85;

/// The bands of a periodic chain.
#[derive(Clone, Debug)]
pub struct Bands {
    /// Blocks `S_0`, `S_1` and `S_{-1}`.
    blocks: [DMatrix<f64>; 3],
    cell: usize,
    /// Of a cell of one bead: its parameters over its mass, contact constant and static overlap.
    pub alike: Option<(Params, [f64; 2])>,
}

impl Bands {
    /// The bands of the infinite chain whose cell repeats along `chain`; walls, damping and drives
    /// are left out.
    ///
    /// ```
    /// use hertzchain_orbits::{chain::{Boundary, Chain, Params}, orbits::Bands};
    /// // Equal beads: omega = 2 sqrt(k) sin(theta/2), with the stiffness k = 2 d of their contacts.
    /// let params = Params::new(2.0, 0.0, 0.0)?;
    /// let chain = Chain::new(params, Boundary::Fixed, 40)?.precompressed(0.5)?;
    /// let bands = Bands::new(&chain)?;
    /// assert_eq!(bands.cell(), 1);
    /// assert!((bands.at(1.0)[0] - 2.0 * 0.5_f64.sin()).abs() < 1e-14);
    /// # Ok::<(), hertzchain_orbits::Error>(())
    /// ```
    ///
    /// # Errors
    /// Gravity; contacts with several powers; no cell of at most 85 beads repeats; contacts that do
    /// not hold the beads at rest.
    pub fn new(chain: &Chain<f64>) -> Result<Self> {
        let details = chain.details().cloned().unwrap_or_default();
        let rule = "bands are those of a periodic chain: under gravity no two contacts are alike";
        require(details.gravity == 0.0, "gravity", details.gravity, rule)?;
        let rule = "bands are those of contacts with one power of the overlap";
        require(details.own_law().is_none(), details.own_law().unwrap_or_default(), GIVEN, rule)?;
        let overlaps = chain.overlaps(&vec![0.0; chain.sites()])[chain.touching()].to_vec();
        let [start, ends] = chain.boundary().walls().map(usize::from);
        let sites = [&details.mass, &details.kappa, &details.rho, &details.onsite];
        let bonds = [&details.contact, &details.alpha, &overlaps, &details.spring, &details.magnet, &details.distance];
        let inner = bonds.map(|list| list.get(start..list.len().saturating_sub(ends)).unwrap_or_default());
        let repeats = |list: &[f64], p: usize| list.iter().zip(list.iter().skip(p)).all(|(a, b)| a == b);
        let all = || sites.map(Vec::as_slice).into_iter().chain(inner);
        let cell = (1..=MOST_CELL.min(chain.sites() / 2)).find(|&p| all().all(|list| repeats(list, p)));
        let Some(cell) = cell else {
            let rule = "bands are those of a periodic chain: a cell of at most 85 beads repeats";
            return Err(Error::parameter("chain", "no cell that repeats", rule));
        };
        // Bond `n` of a ring lies before site `n`; the first inner bond of a chain with ends lies
        // after site 0.
        let shift = usize::from(!chain.topology().ring());
        let ring = |list: &[f64], shift: usize| -> Vec<f64> {
            let cells = (0..3 * cell).filter(|_| !list.is_empty());
            cells.map(|n| list[(n + cell - shift) % cell]).collect()
        };
        let [mass, kappa, rho, onsite] = sites.map(|list| ring(list, 0));
        let [contact, alpha, overlap, spring, magnet, distance] = inner.map(|list| ring(list, shift));
        let params = chain.params();
        let first = |list: &[f64], otherwise: f64| list.first().copied().unwrap_or(otherwise);
        let (m, of_bond) = (first(&mass, 1.0), [first(&contact, 1.0), first(&overlap, 0.0)]);
        let one = Params {
            alpha: first(&alpha, params.alpha),
            kappa: first(&kappa, params.kappa) / m,
            rho: first(&rho, params.rho),
        };
        let contacts_alone = [&onsite, &spring, &magnet].iter().all(|list| list.iter().all(|&x| x == 0.0));
        let ring = Chain::new(params, Boundary::Ring, 3 * cell)?;
        let cell_of = Details { mass, kappa, rho, onsite, contact, alpha, overlap, spring, ..Details::default() };
        let ring = ring.with(&Details { magnet, distance, decay: details.decay, ..cell_of })?;
        let modes = NormalModes::held(&ring, &[])?;
        let stiffness = modes.stiffness()?;
        let places: [Vec<usize>; 3] =
            [0, 1, 2].map(|j| (0..stiffness.nrows()).filter(|&c| modes.place(c).0 / cell == j).collect());
        let n = places[0].len();
        let blocks = [0, 1, 2].map(|j| DMatrix::from_fn(n, n, |a, b| stiffness[(places[0][a], places[j][b])]));
        let alike = (cell == 1 && contacts_alone).then_some((one, [of_bond[0] / m, of_bond[1]]));
        Ok(Self { blocks, cell, alike })
    }

    /// Beads of a cell.
    pub fn cell(&self) -> usize {
        self.cell
    }

    /// The frequencies of waves with the phase `theta` from cell to cell, in ascending order, one a
    /// band.
    ///
    /// Squares of frequencies have the error of a few roundings of the largest; those below that
    /// error are zero.
    pub fn at(&self, theta: f64) -> Vec<f64> {
        let [here, after, before] = &self.blocks;
        let turn = Complex::from_polar(1.0, theta);
        let sum = here.map(Complex::from) + after.map(Complex::from) * turn + before.map(Complex::from) * turn.conj();
        let squares = sum.symmetric_eigenvalues();
        let error = 4.0 * squares.len() as f64 * f64::EPSILON * squares.amax();
        let mut frequencies: Vec<f64> =
            squares.iter().map(|square| if *square > error { square.sqrt() } else { 0.0 }).collect();
        frequencies.sort_by(f64::total_cmp);
        frequencies
    }

    /// The lowest and the highest frequency of each band.
    ///
    /// With contacts between neighbours only, both are at `theta = 0` and `theta = pi`.
    pub fn edges(&self) -> Vec<[f64; 2]> {
        let [long, short] = [0.0, PI].map(|theta| self.at(theta));
        long.into_iter().zip(short).map(|(a, b)| [a.min(b), a.max(b)]).collect()
    }
}
