//! Relative multipliers of an exact wave, by Bloch wave number.
//!
//! | symbol | meaning |
//! |---|---|
//! | `theta` | phase from cell to cell, `w_{n+m} = e^{i theta} w_n`; `2 pi j/c` on `c` cells |
//! | `B_theta` | the derivative of `B` on such perturbations, `4m x 4m` |
//! | `nu` | eigenvalue of `B_theta` |
//! | `p, lambda` | of `w_n(t) = e^{i p n + lambda t} W(q n - omega_tw t)`: wave number, exponent |
//! | `mu` | relative multiplier of the shift by one site, `mu = e^{i p + lambda q/omega_tw}` |
//!
//! # Labels
//!
//! A perturbation with `W` of period `2 pi` has `nu = e^{i p r + lambda T/m}`, and `theta = p m`.
//! `W e^{-i k phi}` with `p + k q` and `lambda + i k omega_tw` is the same perturbation, so one of
//! its labels has `|Im lambda| <= omega_tw/2`, and this one is given. Perturbations of the
//! modulation equations (see [`Modulation`](crate::waves::Modulation)) have `lambda` of order
//! `epsilon^{alpha-1}`, so there `p` and `lambda` are those of this label. The multiplier of the
//! whole period is `e^{lambda T}`.
//!
//! # The symplectic form
//!
//! The flow of strains with sum zero conserves `w^* J w'`, `J = [0 G; -G 0]` with the momenta
//! `G w'`: masses times the inverse of `-delta^+ delta^-`. So `1/conj(nu)` is an eigenvalue of
//! `B_theta` with `nu`, and `J` times its eigenvector is the left eigenvector of `nu`. This gives
//! condition numbers, and the Krein signature `Im(z_1^* G z_2)` of `z = (z_1, z_2)` on the circle:
//! positive for `e^{i omega t}` of a linear oscillator.

use super::{ExactWave, Search, eigen, newton::moved, repeated};
use crate::{
    chain::{Field, Resonators},
    error::{Error, Result, require},
    named::named,
    numerics::least_by,
    orbits::{self, Eigenpair, flow},
};
use hertzchain_integrators::VectorField;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

type Matrix = DMatrix<Complex<f64>>;

/// Error that `B` is taken to have, in units of the larger of its two measured errors.
const MARGIN: f64 = 10.0;

named! {
    /// The kind of a multiplier.
    pub enum WaveKind {
        /// One of the four that equal 1: shift of the phase, change of frequency, change of the
        /// mean strain, and drift. Beads on springs, `rho = inf`, have the first two.
        Trivial = "trivial",
        /// `lambda = +-i omega` up to multiples of `i omega_tw`: the sum of all beads relative to
        /// that of all resonators is a linear oscillator. None without resonators.
        Linear = "linear",
        /// On the unit circle, to the estimated error.
        Circle = "circle",
        /// Off the unit circle.
        Off = "off",
    }
}

/// A relative multiplier.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct WaveMultiplier {
    /// Bloch wave number `p`, above `-pi` and at most `pi`.
    pub bloch: f64,
    /// Real part of `mu`.
    pub re: f64,
    /// Imaginary part of `mu`.
    pub im: f64,
    /// `|mu|`; 1 for the kinds other than `Off`.
    pub modulus: f64,
    /// Estimated error of `|mu|`.
    pub error: f64,
    /// Krein signature on the circle; 0 elsewhere.
    pub krein: i8,
    /// `Re lambda`, per unit of time.
    pub growth: f64,
    /// `Im lambda`, at most `omega_tw/2` in modulus.
    pub frequency: f64,
    /// Its kind.
    pub kind: WaveKind,
}

/// Measured errors of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct WaveQuality {
    /// `max |B^* J B - J| / max |J|` over all `theta`, on perturbations of sum zero.
    pub symplectic_defect: f64,
    /// `max |B z - nu z| / |B|` over all eigenvectors of length 1.
    pub eigen_residual: f64,
    /// `max |B z' - z'| / max |z'|`: the rate of the wave is an eigenvector of 1.
    pub phase_shift: f64,
    /// `|mean - 1|` for the mean of the `nu` that are 1 in theory. They form Jordan blocks,
    /// which the solver splits by the square root of a rounding; their mean keeps all digits.
    pub trivial: f64,
    /// Larger `|nu - e^{+-i omega T/m}|` of the two that are this in theory.
    pub linear: f64,
    /// Largest distance of a `1/conj(nu)` from the nearest eigenvalue; the trivial four are left
    /// out.
    pub pairing: f64,
}

/// The multipliers of a wave on a ring.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct WaveSpectrum {
    /// Sites of the ring.
    pub sites: usize,
    /// All `4 N` multipliers, `2 N` where no resonator moves, by Bloch wave number, the largest
    /// modulus first at each.
    pub multipliers: Vec<WaveMultiplier>,
    /// Measured errors.
    pub quality: WaveQuality,
}

impl WaveSpectrum {
    /// The fastest growing multiplier, if one grows.
    pub fn fastest(&self) -> Option<&WaveMultiplier> {
        let growing = self.multipliers.iter().filter(|m| m.kind == WaveKind::Off && m.growth > 0.0);
        growing.max_by(|a, b| a.growth.total_cmp(&b.growth).then(a.bloch.total_cmp(&b.bloch)))
    }

    /// The largest growth at the Bloch wave number `p`; 0 where nothing grows.
    pub fn growth(&self, p: f64) -> f64 {
        let here = self.multipliers.iter().filter(|m| (m.bloch.abs() - p.abs()).abs() < 1e-6);
        here.map(|m| m.growth).fold(0.0, f64::max)
    }

    /// How many multipliers grow.
    pub fn growing(&self) -> usize {
        self.multipliers.iter().filter(|m| m.kind == WaveKind::Off && m.growth > 0.0).count()
    }
}

impl ExactWave {
    /// The relative multipliers on a ring of `sites` sites.
    ///
    /// # Errors
    /// A ring that is not of whole cells, with fewer than three sites or too long; an integration
    /// that fails; eigenvalues that do not converge.
    pub fn spectrum(&self, sites: usize, search: &Search) -> Result<WaveSpectrum> {
        let m = self.setting.q.cell();
        let good = (3..=super::MOST_SITES).contains(&sites) && sites.is_multiple_of(m);
        let value = format!("{sites}, where the wave repeats after {m}");
        require(good, "sites", value, "from 3 to 256, and a multiple of the cell")?;
        let cells = sites / m;
        let blocks = self.responses(cells, search)?;
        let mut multipliers = Vec::with_capacity(4 * sites);
        let mut qualities = Vec::with_capacity(cells / 2 + 1);
        // Blocks of -theta are the conjugates.
        for j in 0..=cells / 2 {
            let block = Block::new(self, &blocks, j, cells);
            let (found, own) = block.multipliers().ok_or_else(|| {
                let rule = "no multipliers: the eigenvalues did not converge";
                Error::parameter("omega_tw", self.setting.omega_tw, rule)
            })?;
            qualities.push(own);
            if j > 0 && 2 * j < cells {
                multipliers.extend(found.iter().map(WaveMultiplier::conjugate));
            }
            multipliers.extend(found);
        }
        multipliers.sort_by(|a, b| {
            // Numbers that differ by a rounding are one Bloch wave number.
            let place = |m: &WaveMultiplier| (m.bloch * sites as f64 / (2.0 * PI)).round();
            let order = |m: &WaveMultiplier| (-m.modulus, m.frequency);
            let (a_key, b_key) = (order(a), order(b));
            place(a).total_cmp(&place(b)).then(a_key.0.total_cmp(&b_key.0)).then(a_key.1.total_cmp(&b_key.1))
        });
        let quality = qualities[1..].iter().fold(qualities[0], WaveQuality::with);
        Ok(WaveSpectrum { sites, multipliers, quality })
    }

    /// The derivative of `B` by the state of the first cell: a block for the response of each cell.
    fn responses(&self, cells: usize, search: &Search) -> Result<Vec<DMatrix<f64>>> {
        let (setting, z) = (&self.setting, &self.z);
        let m = setting.q.cell();
        let entry = |i: usize| moved(i, m, cells, 0);
        let mut columns = DMatrix::zeros(z.len() * cells, z.len());
        (0..z.len()).for_each(|i| columns[(entry(i), i)] = 1.0);
        let time = setting.period() / m as f64;
        let end = flow(&setting.chain(cells)?, &repeated(z, m, cells), time, columns, search.tol, |_| {})?;
        let block = |cell: usize| {
            let from = |i: usize| moved(i, m, cells, setting.q.shift() + cell * m);
            DMatrix::from_fn(z.len(), z.len(), |i, j| end.columns[(from(i), j)])
        };
        Ok((0..cells).map(block).collect())
    }

    /// `z'` at `t = 0`.
    fn rate(&self) -> Result<Vec<f64>> {
        let (m, cells) = (self.setting.q.cell(), self.setting.least_cells());
        let mut rates = vec![0.0; self.z.len() * cells];
        Field::new(self.setting.chain(cells)?).eval(0.0, &repeated(&self.z, m, cells), &mut rates);
        Ok((0..self.z.len()).map(|i| rates[moved(i, m, cells, 0)]).collect())
    }
}

/// `B_theta`, with the numbers that make multipliers of its eigenvalues.
struct Block<'a> {
    wave: &'a ExactWave,
    theta: f64,
    matrix: Matrix,
    /// `G`.
    metric: Matrix,
}

impl<'a> Block<'a> {
    fn new(wave: &'a ExactWave, responses: &[DMatrix<f64>], j: usize, cells: usize) -> Self {
        let theta = 2.0 * PI * j as f64 / cells as f64;
        let turn = |cell: usize| {
            // Exactly real where theta is a multiple of pi.
            let part = (j * cell) % cells;
            let angle = 2.0 * PI * part as f64 / cells as f64;
            let sin = if (2 * part).is_multiple_of(cells) { 0.0 } else { angle.sin() };
            Complex::new(angle.cos(), -sin)
        };
        let size = wave.z.len();
        let matrix = responses
            .iter()
            .enumerate()
            .fold(Matrix::zeros(size, size), |sum, (cell, response)| sum + response.map(|entry| turn(cell) * entry));
        Self { wave, theta, matrix, metric: metric(wave, theta) }
    }

    /// `J z`.
    fn dual(&self, z: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        let half = z.len() / 2;
        let mut dual = DVector::zeros(z.len());
        dual.rows_mut(0, half).copy_from(&(&self.metric * z.rows(half, half)));
        dual.rows_mut(half, half).copy_from(&-(&self.metric * z.rows(0, half)));
        dual
    }

    fn symplectic_defect(&self) -> f64 {
        let mut free = self.matrix.clone();
        if self.theta == 0.0 {
            let m = self.wave.setting.q.cell();
            for first in (0..free.ncols()).step_by(m) {
                let mean = free.columns(first, m).column_sum() / Complex::from(m as f64);
                free.columns_mut(first, m).column_iter_mut().for_each(|mut column| column -= &mean);
            }
        }
        let size = free.ncols();
        let j = |matrix: &Matrix| {
            let columns: Vec<_> = matrix.column_iter().map(|column| self.dual(&column.into_owned())).collect();
            Matrix::from_columns(&columns)
        };
        let form = j(&Matrix::identity(size, size));
        let largest = |matrix: &Matrix| matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
        largest(&(free.adjoint() * j(&free) - &form)) / largest(&form)
    }

    /// All multipliers, and their measured errors.
    fn multipliers(&self) -> Option<(Vec<WaveMultiplier>, WaveQuality)> {
        // At theta = 0 and pi the matrix is real, and its eigenvalues take a quarter of the work.
        let real = self.matrix.iter().all(|entry| entry.im == 0.0);
        let pairs = if real { orbits::eigen(&self.matrix.map(|z| z.re))? } else { eigen::eigen(&self.matrix)? };
        let size = self.matrix.norm();
        let residual = |(nu, z): &Eigenpair| (&self.matrix * z - z * *nu).norm() / size;
        let mut quality = WaveQuality {
            symplectic_defect: self.symplectic_defect(),
            eigen_residual: pairs.iter().map(residual).fold(0.0, f64::max),
            phase_shift: 0.0,
            trivial: 0.0,
            linear: 0.0,
            pairing: 0.0,
        };
        let mut kinds: Vec<Option<WaveKind>> = vec![None; pairs.len()];
        if self.theta == 0.0 {
            self.known(&pairs, &mut kinds, &mut quality).ok()?;
        }
        let rounding = MARGIN * size * quality.symplectic_defect.max(quality.eigen_residual).max(f64::EPSILON);
        let mut found = Vec::with_capacity(pairs.len());
        for (k, kind) in kinds.iter().enumerate() {
            let (multiplier, apart) = self.multiplier(&pairs, k, *kind, rounding);
            if *kind != Some(WaveKind::Trivial) {
                quality.pairing = quality.pairing.max(apart);
            }
            found.push(multiplier);
        }
        Some((found, quality))
    }

    /// Finds the eigenvalues that are known in theory.
    fn known(&self, pairs: &[Eigenpair], kinds: &mut [Option<WaveKind>], quality: &mut WaveQuality) -> Result<()> {
        let setting = &self.wave.setting;
        let angle = setting.params.omega() * setting.period() / setting.q.cell() as f64;
        let mut take = |value: Complex<f64>, kind: WaveKind| {
            let apart = |k: &usize| (pairs[*k].0 - value).norm();
            let free = (0..pairs.len()).filter(|&k| kinds[k].is_none());
            least_by(free, apart).map_or(Complex::from(f64::NAN), |k| {
                kinds[k] = Some(kind);
                pairs[k].0 - value
            })
        };
        // Without resonators there is no linear oscillator. Beads on springs have neither another
        // mean strain nor a drift.
        let (linear, trivial) = match setting.params.resonators() {
            Resonators::None => (0, 4),
            Resonators::Fixed => (2, 2),
            Resonators::Moving => (2, 4),
        };
        let signs = [1.0, -1.0].into_iter().take(linear);
        let linear = signs.map(|sign| take(Complex::from_polar(1.0, sign * angle), WaveKind::Linear).norm());
        quality.linear = linear.fold(0.0, f64::max);
        let ones: Complex<f64> = (0..trivial).map(|_| take(Complex::ONE, WaveKind::Trivial)).sum();
        quality.trivial = ones.norm() / f64::from(trivial);
        let rate = DVector::from_vec(self.wave.rate()?).map(Complex::from);
        let moved = &self.matrix * &rate - &rate;
        let largest = |z: &DVector<Complex<f64>>| z.iter().map(|z| z.norm()).fold(0.0, f64::max);
        quality.phase_shift = largest(&moved) / largest(&rate);
        Ok(())
    }

    /// Multiplier `k`, and the distance of its `1/conj(nu)` from the nearest eigenvalue.
    fn multiplier(
        &self,
        pairs: &[Eigenpair],
        k: usize,
        kind: Option<WaveKind>,
        rounding: f64,
    ) -> (WaveMultiplier, f64) {
        let (nu, z) = &pairs[k];
        let other = nu.conj().inv();
        let apart = |(nu, _): &&Eigenpair| (nu - other).norm();
        let partner = least_by(pairs, apart).unwrap_or(&pairs[k]);
        let dual = self.dual(&partner.1);
        // The error of |nu| by the condition number of nu.
        let condition = dual.norm() / dual.dotc(z).norm();
        let size = nu.norm();
        let error = (rounding * condition).min(1.0);
        let kind = kind.unwrap_or(if (size - 1.0).abs() <= error { WaveKind::Circle } else { WaveKind::Off });
        let setting = &self.wave.setting;
        let per = setting.q.cell() as f64 / setting.period();
        let growth = if kind == WaveKind::Off { size.ln() * per } else { 0.0 };
        let (bloch, frequency) = if kind == WaveKind::Trivial { (0.0, 0.0) } else { self.label(nu.arg()) };
        let time = setting.q.q() / setting.omega_tw;
        let mu = Complex::from_polar((growth * time).exp(), bloch + frequency * time);
        let krein = match kind {
            WaveKind::Circle => {
                let half = z.len() / 2;
                z.rows(0, half).dotc(&(&self.metric * z.rows(half, half))).im.signum() as i8
            }
            _ => 0,
        };
        // nu is the multiplier of T/m, mu that of q/omega_tw = l T/m.
        let exact = matches!(kind, WaveKind::Trivial | WaveKind::Linear);
        let error = if exact { 0.0 } else { error * setting.q.turns() as f64 * mu.norm() / size };
        let Complex { re, im } = mu;
        let multiplier = WaveMultiplier { bloch, re, im, modulus: mu.norm(), error, krein, growth, frequency, kind };
        let modulus = if kind == WaveKind::Off { multiplier.modulus } else { 1.0 };
        (WaveMultiplier { modulus, ..multiplier }, apart(&partner))
    }

    /// `p` and `Im lambda` of an eigenvalue with this argument.
    fn label(&self, argument: f64) -> (f64, f64) {
        let setting = &self.wave.setting;
        let (m, shift) = (setting.q.cell(), setting.q.shift() as f64);
        let per = m as f64 / setting.period();
        let at = |k: usize| {
            let p = wrapped((self.theta + 2.0 * PI * k as f64) / m as f64);
            (p, wrapped(argument - p * shift) * per)
        };
        least_by((0..m).map(at), |label| label.1.abs()).unwrap_or((0.0, 0.0))
    }
}

impl WaveMultiplier {
    /// The multiplier of the conjugate perturbation.
    fn conjugate(&self) -> Self {
        let &Self { bloch, im, krein, frequency, .. } = self;
        Self { bloch: wrapped(-bloch), im: -im, krein: -krein, frequency: -frequency, ..*self }
    }
}

impl WaveQuality {
    /// The larger errors of two blocks; the errors that only `theta = 0` has are those of `self`.
    fn with(self, other: &Self) -> Self {
        Self {
            symplectic_defect: self.symplectic_defect.max(other.symplectic_defect),
            eigen_residual: self.eigen_residual.max(other.eigen_residual),
            pairing: self.pairing.max(other.pairing),
            ..self
        }
    }
}

/// The angle above `-pi` and at most `pi`.
fn wrapped(angle: f64) -> f64 {
    let turns = (angle / (2.0 * PI)).round();
    let angle = angle - 2.0 * PI * turns;
    // An angle of -pi to a rounding is pi.
    if angle <= -PI * (1.0 - 1e-12) { angle + 2.0 * PI } else { angle }
}

/// `G` on perturbations with the phase `theta` from cell to cell: masses times the inverse of
/// `-delta^+ delta^-`, and 0 on uniform ones.
fn metric(wave: &ExactWave, theta: f64) -> Matrix {
    let (m, rho) = (wave.setting.q.cell(), wave.setting.params.rho);
    let inverse = |d: f64| {
        let of = |k: usize| {
            let wave = (theta + 2.0 * PI * k as f64) / m as f64;
            let chord = 4.0 * (0.5 * wave).sin().powi(2);
            if theta == 0.0 && k == 0 { Complex::ZERO } else { Complex::from_polar(1.0 / chord, wave * d) }
        };
        (0..m).map(of).sum::<Complex<f64>>() / m as f64
    };
    let half = wave.z.len() / 2;
    Matrix::from_fn(half, half, |i, j| match (i < m, j < m) {
        (true, true) => inverse(i as f64 - j as f64),
        (false, false) => inverse(i as f64 - j as f64) * rho,
        _ => Complex::ZERO,
    })
}
