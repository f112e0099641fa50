//! Newton's method for exact travelling waves.

use super::{ExactWave, MeanStrain, WaveSetting, mean, mean_row, repeated, strain_row, swing};
use crate::{
    chain::max_norm,
    error::{Error, Iterate, Result, require},
    orbits::{Equations, NewtonStep, flow, least_squares},
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A step of at most this length, in units of the amplitude, is the last: by quadratic convergence
/// the next one would be below rounding.
const LAST_STEP: f64 = 1e-9;
/// Largest residual of a wave; the message of [`Error::Stalled`] names it.
pub(super) const SOLVED: f64 = 1e-12;
/// Longest step, in units of the amplitude.
const LONGEST_STEP: f64 = 0.5;
/// Largest amplitude of an iterate, in units of that of the seed.
const FARTHEST: f64 = 100.0;
/// Largest period of an iterate, in units of that of the seed.
const SLOWEST: f64 = 10.0;
/// Relative change of a parameter for difference quotients.
pub(super) const DIFFERENCE: f64 = 1e-6;

/// The number that is prescribed for a wave, besides its mean strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Given {
    /// The frequency of the setting.
    Frequency,
    /// This height of the crest above the mean strain; the frequency is an unknown.
    Amplitude(f64),
}

/// Settings of the search for a wave.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// Tolerance of the flow over `T/m`, relative to the size of the state.
    pub tol: f64,
    /// Largest number of steps of Newton's method.
    pub most_steps: usize,
}

impl Default for Search {
    fn default() -> Self {
        Self { tol: 1e-14, most_steps: 20 }
    }
}

impl Search {
    /// `B z - z` with velocities over `omega_tw`, the phase, and the mean strain minus that of the
    /// setting; with the derivative by `z` if `derivative`, else with a matrix of no columns.
    pub(super) fn equations(&self, setting: &WaveSetting, z: &[f64], derivative: bool) -> Result<Equations> {
        let (m, cells) = (setting.q.cell(), setting.least_cells());
        let chain = setting.chain(cells)?;
        let columns = DMatrix::identity(z.len(), if derivative { z.len() } else { 0 });
        let columns = DMatrix::from_fn(z.len() * cells, columns.ncols(), |i, j| columns[(of_ring(i, m, cells), j)]);
        let time = setting.period() / m as f64;
        let end = flow(&chain, &repeated(z, m, cells), time, columns.clone(), self.tol, |_| {})?;
        let scale = |i: usize| if 2 * i < z.len() { 1.0 } else { setting.omega_tw.recip() };
        let from = |i: usize| moved(i, m, cells, setting.q.shift());
        let mut residual = DVector::from_fn(z.len() + 2, |i, _| match z.get(i) {
            Some(z) => (end.state[from(i)] - z) * scale(i),
            None => 0.0,
        });
        let mut jacobian = DMatrix::from_fn(z.len() + 2, columns.ncols(), |i, j| match i < z.len() {
            true => (end.columns[(from(i), j)] - f64::from(u8::from(i == j))) * scale(i),
            false => 0.0,
        });
        for (i, row) in borders(setting).iter().enumerate() {
            residual[z.len() + i] = row.iter().zip(z).map(|(row, z)| row * z).sum::<f64>();
            if derivative {
                jacobian.row_mut(z.len() + i).copy_from_slice(row);
            }
        }
        if let MeanStrain::Value(mean) | MeanStrain::Background(mean) = setting.mean {
            residual[z.len() + 1] -= mean;
        }
        Ok(Equations { residual, jacobian })
    }

    /// The wave near the state `seed` of a cell.
    ///
    /// # Errors
    /// A setting outside its rules; a seed of another length, not finite or uniform; a seed whose
    /// flow fails; [`Error::Stalled`] with the best iterate where the residual does not fall to
    /// 1e-12.
    pub fn solve(&self, setting: &WaveSetting, given: Given, seed: &[f64]) -> Result<ExactWave> {
        let rule = "four numbers a site of the cell, two where no resonator moves";
        require(seed.len() == setting.numbers(), "seed", format!("{} numbers", seed.len()), rule)?;
        let good = swing(seed, setting) > 0.0 && seed.iter().all(|z| z.is_finite());
        require(good, "seed", max_norm(seed.iter().copied()), "finite, and not uniform")?;
        let mut wave = ExactWave { setting: *setting, z: seed.to_vec(), residual: f64::INFINITY, newton: Vec::new() };
        let mut best: Option<ExactWave> = None;
        for _ in 0..self.most_steps {
            let last = wave.newton.last().is_some_and(|step| step.step <= LAST_STEP);
            let Ok((residual, by)) = self.step(&wave, given, !last) else { break };
            wave.residual = residual;
            if best.as_ref().is_none_or(|best| residual < best.residual) {
                best = Some(wave.clone());
            }
            let Some(by) = by else { break };
            let size = swing(&wave.z, &wave.setting);
            // A wave of much longer period takes longer to integrate, and is not near the seed.
            if size > FARTHEST * swing(seed, setting) || wave.setting.omega_tw * SLOWEST < setting.omega_tw {
                break;
            }
            let faster = by.get(wave.z.len()).map_or(0.0, |by| (by / wave.setting.omega_tw).abs());
            let step = (by.rows(0, wave.z.len()).amax() / size).max(faster);
            wave.newton.push(NewtonStep { residual, step });
            wave.apply(&by, (LONGEST_STEP / step).min(1.0));
        }
        let newton = wave.newton;
        match best {
            Some(wave) if wave.residual <= SOLVED => Ok(ExactWave { newton, ..wave }),
            best => Err(stalled(newton.len(), best)),
        }
    }

    /// The residual of a wave and, if `derivative`, the vector that Newton's method subtracts from
    /// `z` and, if the frequency is an unknown, from the frequency.
    fn step(&self, wave: &ExactWave, given: Given, derivative: bool) -> Result<(f64, Option<DVector<f64>>)> {
        let ExactWave { setting, z, .. } = wave;
        let Equations { residual, jacobian } = self.equations(setting, z, derivative)?;
        let size = swing(z, setting);
        let (mut right, mut matrix) = (residual, jacobian);
        if let Given::Amplitude(amplitude) = given {
            let row = amplitude_row(setting);
            right = right.push(row.iter().zip(z).map(|(row, z)| row * z).sum::<f64>() - amplitude);
            let rows = matrix.nrows();
            matrix = matrix.insert_row(rows, 0.0);
            if derivative {
                matrix.row_mut(rows).copy_from_slice(&row);
                let (omega, by) = (setting.omega_tw, DIFFERENCE * setting.omega_tw);
                let at = |omega_tw: f64| self.equations(&WaveSetting { omega_tw, ..*setting }, z, false);
                let slope = (at(omega + by)?.residual - at(omega - by)?.residual) / (2.0 * by);
                matrix = matrix.insert_column(z.len(), 0.0);
                matrix.view_mut((0, z.len()), (rows, 1)).copy_from(&slope);
            }
        }
        let relative = right.amax() / size;
        if !derivative {
            return Ok((relative, None));
        }
        let by = least_squares(matrix, &right).ok_or_else(|| stalled(wave.newton.len(), None))?;
        Ok((relative, Some(by)))
    }
}

/// The row of the strain at the site farthest from the crest, the mean of both if there are two.
fn background_row(setting: &WaveSetting) -> Vec<f64> {
    let m = setting.q.cell();
    let farthest = [m / 2, m.div_ceil(2)];
    let row = strain_row(setting, |n| farthest.contains(&n));
    if m.is_multiple_of(2) { row } else { row.into_iter().map(|weight| 0.5 * weight).collect() }
}

/// The row of the amplitude: the crest minus the mean strain.
pub(super) fn amplitude_row(setting: &WaveSetting) -> Vec<f64> {
    let mut row: Vec<f64> = mean_row(setting).iter().map(|mean| -mean).collect();
    row[0] += 1.0;
    row
}

/// The rows of the phase and of the mean strain, which do not involve the flow.
fn borders(setting: &WaveSetting) -> [Vec<f64>; 2] {
    let (m, q, half) = (setting.q.cell(), setting.q.q(), setting.numbers() / 2);
    let mut phase = vec![0.0; setting.numbers()];
    for n in 0..m {
        let (sin, cos) = (q * n as f64).sin_cos();
        (phase[n], phase[half + n]) = (sin / m as f64, -cos / (m as f64 * setting.omega_tw));
    }
    let mean = match setting.mean {
        MeanStrain::Value(_) => mean_row(setting),
        MeanStrain::Background(_) => background_row(setting),
        MeanStrain::OfAmplitude(share) => {
            let both = mean_row(setting).into_iter().zip(amplitude_row(setting));
            both.map(|(mean, amplitude)| mean - share * amplitude).collect()
        }
    };
    [phase, mean]
}

impl ExactWave {
    /// Subtracts `share` times a step from the state and, if the step has the entry, from the
    /// frequency.
    fn apply(&mut self, by: &DVector<f64>, share: f64) {
        for (z, by) in self.z.iter_mut().zip(by) {
            *z -= share * by;
        }
        if let Some(by) = by.get(self.z.len()) {
            // At most half of the frequency is subtracted, so that it stays positive.
            self.setting.omega_tw -= (share * by).min(0.5 * self.setting.omega_tw);
        }
    }
}

/// Entry of the cell's state that is entry `i` of the ring's state.
fn of_ring(i: usize, m: usize, cells: usize) -> usize {
    let (array, site) = (i / (m * cells), i % (m * cells));
    array * m + site % m
}

/// Entry of the ring's state that `S^{-r}` moves to entry `i` of the cell's state.
pub(super) fn moved(i: usize, m: usize, cells: usize, shift: usize) -> usize {
    let (array, site) = (i / m, i % m);
    array * m * cells + (site + shift) % (m * cells)
}

fn stalled(steps: usize, best: Option<ExactWave>) -> Error {
    let iterate = |ExactWave { setting, z, residual, .. }: ExactWave| {
        let WaveSetting { omega_tw, q, .. } = setting;
        let q_over_pi = 2.0 * q.turns() as f64 / q.cell() as f64;
        let place = format!("q = {q_over_pi} pi, omega_tw = {omega_tw}, mean strain {}", mean(&z, &setting));
        Box::new(Iterate { z, residual, solved: SOLVED, place })
    };
    Error::Stalled { steps, best: best.map(iterate) }
}
