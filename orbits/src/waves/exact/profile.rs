//! The profiles `X, Y` of an exact wave, and their Fourier coefficients.

use super::{ExactWave, Search, repeated};
use crate::{error::Result, run::state_at, waves::TravellingWave};
use hertzchain_integrators::collocation::StepControl;
use std::f64::consts::PI;

/// Largest harmonic of [`Profile::fourier`].
const HARMONICS: usize = 128;

/// Equally spaced samples of the profiles from `phi = 0` on, over a period.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// `X`.
    pub x: Vec<f64>,
    /// `Y`; empty where no resonator moves.
    pub y: Vec<f64>,
}

impl ExactWave {
    /// At least `samples` values of the profiles, from the motion of every site of a cell over the
    /// time `T/m`.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn profile(&self, samples: usize, search: &Search) -> Result<Profile> {
        let (setting, m) = (&self.setting, self.setting.q.cell());
        let (cells, parts) = (setting.least_cells(), 2 * samples.div_ceil(2 * m).max(1));
        let (ring, total) = (cells * m, parts * m);
        let time = setting.period() / m as f64;
        let start = repeated(&self.z, m, cells);
        let mut run = setting.chain(cells)?.collocation(&start, (0.0, time), StepControl::Tolerance(search.tol))?;
        let moving = start.len() == 4 * ring;
        let mut profile = Profile { x: vec![0.0; total], y: vec![0.0; if moving { total } else { 0 }] };
        for part in 0..parts {
            let state = state_at(&mut run, time * part as f64 / parts as f64)?;
            // phi = q n - omega_tw t in units of 2 pi/total.
            for n in 0..m {
                let phi = (setting.q.turns() * n * parts + total - part) % total;
                profile.x[phi] = state[n];
                if moving {
                    profile.y[phi] = state[ring + n];
                }
            }
        }
        Ok(profile)
    }
}

impl Profile {
    /// `phi` of each sample.
    pub fn phases(&self) -> impl Iterator<Item = f64> + '_ {
        let step = 2.0 * PI / self.x.len() as f64;
        (0..self.x.len()).map(move |k| step * k as f64)
    }

    /// `f_0 .. f_128` of `X = sum f_k cos(k phi)`, of `Y`, and the largest coefficient of a sine: a
    /// rounding, since the profiles are even.
    pub fn fourier(&self) -> ([Vec<f64>; 2], f64) {
        let total = self.x.len();
        let mut odd = 0.0_f64;
        let of = |values: &Vec<f64>, odd: &mut f64| {
            let harmonic = |k: usize| {
                let angle = |j: usize| 2.0 * PI * ((j * k) % total) as f64 / total as f64;
                let sum = |turn: fn(f64) -> f64| {
                    values.iter().enumerate().map(|(j, value)| value * turn(angle(j))).sum::<f64>() / total as f64
                };
                *odd = odd.max(2.0 * sum(f64::sin).abs());
                sum(f64::cos) * if k == 0 { 1.0 } else { 2.0 }
            };
            (0..=HARMONICS.min(total / 8)).map(harmonic).collect::<Vec<f64>>()
        };
        let both = [of(&self.x, &mut odd), of(&self.y, &mut odd)];
        (both, odd)
    }

    /// `E_x` and `E_y` of an ansatz (eq:relerr_tw), at all phases.
    pub fn errors(&self, ansatz: &TravellingWave) -> [f64; 2] {
        let (amplitude, rho) = (ansatz.amplitude(), ansatz.params().rho);
        let mean = ansatz.epsilon() * ansatz.shape().b;
        let largest = |values: &[f64], height: f64| {
            let apart = self.phases().zip(values).map(|(phi, value)| (mean + height * phi.cos() - value).abs());
            apart.fold(0.0, f64::max)
        };
        [largest(&self.x, amplitude) / amplitude, largest(&self.y, -amplitude / rho) * rho / amplitude]
    }

    /// The share of the period in which a contact is closed, `X < 0`, by linear interpolation
    /// between the samples.
    pub fn closed(&self) -> f64 {
        let next = self.x.iter().skip(1).chain(self.x.first());
        let share = |(a, b): (&f64, &f64)| match (*a < 0.0, *b < 0.0) {
            (true, true) => 1.0,
            (false, false) => 0.0,
            _ => a.min(*b) / (a.min(*b) - a.max(*b)),
        };
        self.x.iter().zip(next).map(share).sum::<f64>() / self.x.len() as f64
    }
}
