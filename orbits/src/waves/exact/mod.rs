//! Exact periodic travelling waves `x_n(t) = X(q n - omega t)` of the strain ring, as relative
//! periodic orbits (Sec. 4 has their first-order approximations).
//!
//! | symbol | meaning |
//! |---|---|
//! | `X, Y` | profiles of the strains, `2 pi`-periodic and even; `X` has its crest at 0 |
//! | `q = 2 pi l/m` | wave number in lowest terms: the wave repeats after a cell of `m` sites |
//! | `omega_tw, T` | frequency, and period `T = 2 pi/omega_tw` |
//! | `r` | sites with `r l = 1 (mod m)`: after the time `T/m` the wave has moved on by `r` sites |
//! | `B` | the relative map `S^{-r} Phi_{T/m}`; `S` shifts by a site, `Phi_t` is the flow |
//! | `z` | state of a cell at `t = 0`: `x, y, x', y'`, or `x, x'` where no resonator moves |
//!
//! A state with `B z = z` is a wave. It also shifts by one site in the time `q/omega_tw`, since
//! `(S^{-r} Phi_{T/m})^l = S^{-1} Phi_{q/omega_tw}` on cells. For `l = 1` both maps are the same;
//! for `l > 1` the fixed points of the second include waves whose profile has the period `2 pi l`.
//!
//! # The equations
//!
//! The derivative of `B - 1` has the null vectors `z'` (shift of the phase) and `dz/dmean`, and two
//! left null vectors, from the conservation of energy and of `sum (x' + rho y')`. Two equations
//! remove the null vectors: the phase of the first harmonic, `sum (x_n sin(q n) - x_n'/omega_tw
//! cos(q n)) = 0`, and the mean strain. So there are two equations more than unknowns, and the
//! least-squares solution satisfies all of them.

mod branch;
pub(crate) mod eigen;
mod newton;
mod profile;
mod search;
mod seed;
mod spectrum;

pub use branch::{WaveBase, WaveBranch, WaveContinuation, WaveMeasures, WaveParameter, WavePoint};
pub use newton::{Given, Search};
pub use profile::Profile;
pub use seed::Start;
pub use seed::ansatz;
pub use spectrum::{WaveKind, WaveMultiplier, WaveQuality, WaveSpectrum};

use crate::{
    chain::{Boundary, Chain, Params, Resonators, max_norm},
    error::{Result, SMOOTH, finite, positive, require},
    orbits::Orbit,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Largest ring for which the tangent map of contact collocation is made.
pub(super) const MOST_SITES: usize = 256;
/// Largest distance of `N q/(2 pi)` from a whole number.
const WHOLE: f64 = 1e-9;

/// A wave number `q = 2 pi l/m` with `l/m` in lowest terms.
///
/// ```
/// use hertzchain_orbits::waves::WaveNumber;
/// let q = WaveNumber::on_ring(0.8, 50)?;
/// assert_eq!((q.turns(), q.cell()), (2, 5));
/// assert!(WaveNumber::on_ring(0.21, 50).unwrap_err().to_string().contains("the nearest is 0.2"));
/// # Ok::<(), hertzchain_orbits::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WaveNumber {
    turns: usize,
    cell: usize,
}

impl WaveNumber {
    /// The wave number `q_over_pi pi` on a ring of `sites` sites.
    ///
    /// # Errors
    /// A ring with fewer than 3 or more than 256 sites; a wave number that is not above 0 and at
    /// most `pi`, or with a part of a wave on the ring: the message has the nearest that fits.
    pub fn on_ring(q_over_pi: f64, sites: usize) -> Result<Self> {
        require((3..=MOST_SITES).contains(&sites), "sites", sites, "from 3 to 256 sites")?;
        require(q_over_pi > 0.0 && q_over_pi <= 1.0, "q_over_pi", q_over_pi, "above 0 and at most 1")?;
        let waves = 0.5 * sites as f64 * q_over_pi;
        let whole = waves.round().clamp(1.0, (sites / 2) as f64);
        let value = format!("{q_over_pi} on {sites} sites (the nearest is {})", 2.0 * whole / sites as f64);
        let rule = "a ring holds whole waves: N q is a multiple of 2 pi";
        require((waves - whole).abs() <= WHOLE, "q_over_pi", value, rule)?;
        let (waves, common) = (whole as usize, gcd(whole as usize, sites));
        Ok(Self { turns: waves / common, cell: sites / common })
    }

    /// `l`, waves in a cell.
    pub fn turns(self) -> usize {
        self.turns
    }

    /// `m`, sites of a cell.
    pub fn cell(self) -> usize {
        self.cell
    }

    /// `q`, radians per site.
    pub fn q(self) -> f64 {
        2.0 * PI * self.turns as f64 / self.cell as f64
    }

    /// `r`, with `r l = 1 (mod m)`.
    pub fn shift(self) -> usize {
        (1..=self.cell).find(|r| r * self.turns % self.cell == 1 % self.cell).unwrap_or(1)
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The condition that determines the mean of `X`, which is also that of `Y`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeanStrain {
    /// The mean is this number.
    Value(f64),
    /// The mean is this share of the height of the crest above it: `b/(2 kappa a)` in the ansatz,
    /// 1/2 in the paper. Waves of the same shape have the same share, whatever their size.
    OfAmplitude(f64),
    /// The strain at the site farthest from the crest, or the mean over the two farthest sites, is
    /// this number: a pulse on a background. The strain of a site is here `(x + rho y)/(1 + rho)`,
    /// as in the mean; oscillations of a bead against its resonator do not change it.
    Background(f64),
}

impl MeanStrain {
    /// The number in the condition.
    fn value(self) -> f64 {
        match self {
            Self::Value(value) | Self::OfAmplitude(value) | Self::Background(value) => value,
        }
    }

    /// The mean strain of a wave of this amplitude.
    fn at(self, amplitude: f64) -> f64 {
        match self {
            Self::Value(value) | Self::Background(value) => value,
            Self::OfAmplitude(share) => share * amplitude,
        }
    }

    /// The condition for a wave of the same shape whose strains are `factor` times as large.
    fn times(self, factor: f64) -> Self {
        match self {
            Self::Value(value) => Self::Value(factor * value),
            Self::Background(value) => Self::Background(factor * value),
            share @ Self::OfAmplitude(_) => share,
        }
    }
}

/// The numbers that determine a wave, except for the choice of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WaveSetting {
    /// Exponent, spring constant, mass ratio.
    pub params: Params,
    /// Wave number.
    pub q: WaveNumber,
    /// Frequency.
    pub omega_tw: f64,
    /// Mean strain.
    pub mean: MeanStrain,
}

impl WaveSetting {
    /// `T = 2 pi/omega_tw`.
    pub fn period(&self) -> f64 {
        2.0 * PI / self.omega_tw
    }

    /// The ring of `cells` cells, after all numbers are checked.
    ///
    /// # Errors
    /// `alpha` at most 1; a frequency that is not finite and positive; a mean strain that is not
    /// finite.
    pub fn chain(&self, cells: usize) -> Result<Chain<f64>> {
        let Self { params, q, omega_tw, mean } = *self;
        params.validate()?;
        require(params.alpha > 1.0, "alpha", params.alpha, SMOOTH)?;
        positive("omega_tw", omega_tw)?;
        finite("mean", mean.value())?;
        Chain::new(params, Boundary::StrainRing, cells * q.cell)
    }

    /// Length of the state of a cell: strains and rates of beads, and of resonators that move.
    pub fn numbers(&self) -> usize {
        let arrays = if self.params.resonators() == Resonators::Moving { 4 } else { 2 };
        arrays * self.q.cell
    }

    /// Cells of the smallest ring with at least three sites.
    fn least_cells(&self) -> usize {
        3_usize.div_ceil(self.q.cell)
    }
}

/// An exact travelling wave: `z` is `[x, y, x', y']` of a cell at `t = 0`, or `[x, x']` where no
/// resonator moves; the residual is `max |B z - z|` in units of the amplitude, with velocities
/// divided by `omega_tw`.
pub type ExactWave = Orbit<WaveSetting>;

impl ExactWave {
    /// One of `x, y, x', y'` of the cell; empty for resonators that do not move.
    fn array(&self, k: usize) -> &[f64] {
        let m = self.setting.q.cell;
        match self.z.len() / m {
            2 if k % 2 == 1 => &[],
            2 => &self.z[k / 2 * m..(k / 2 + 1) * m],
            _ => &self.z[k * m..(k + 1) * m],
        }
    }

    /// `[x, y, x', y']` of a ring at `t = 0`; `y` and `y'` are empty where no resonator moves.
    ///
    /// # Panics
    /// If `sites` is not a multiple of the cell.
    pub fn on_ring(&self, sites: usize) -> [Vec<f64>; 4] {
        let m = self.setting.q.cell;
        assert!(sites.is_multiple_of(m), "a ring of whole cells");
        [0, 1, 2, 3].map(|k| self.array(k).repeat(sites / m))
    }

    /// Mean strain.
    pub fn mean(&self) -> f64 {
        mean(&self.z, &self.setting)
    }

    /// Height of the crest of `X` above the mean strain; `2 kappa epsilon a` of (eq:xytw_app).
    pub fn amplitude(&self) -> f64 {
        self.z[0] - self.mean()
    }
}

/// The state of a ring of `cells` cells of `m` sites, each in the state `z`.
pub(super) fn repeated(z: &[f64], m: usize, cells: usize) -> Vec<f64> {
    z.chunks_exact(m).flat_map(|array| array.repeat(cells)).collect()
}

/// The row of the mean strain in the equations.
fn mean_row(setting: &WaveSetting) -> Vec<f64> {
    let m = setting.q.cell();
    strain_row(setting, |n| n < m).into_iter().map(|weight| weight / m as f64).collect()
}

/// The row of the sum of `(x + rho y)/(1 + rho)` over some sites; of `x` where no resonator moves.
fn strain_row(setting: &WaveSetting, of: impl Fn(usize) -> bool) -> Vec<f64> {
    let (m, rho) = (setting.q.cell(), setting.params.rho);
    let weights = match setting.params.resonators() {
        Resonators::Moving => [1.0 / (1.0 + rho), rho / (1.0 + rho), 0.0, 0.0],
        _ => [1.0, 0.0, 0.0, 0.0],
    };
    (0..setting.numbers()).map(|i| if of(i % m) { weights[i / m] } else { 0.0 }).collect()
}

/// Mean of `(x + rho y)/(1 + rho)` over a cell, of `x` where no resonator moves.
fn mean(z: &[f64], setting: &WaveSetting) -> f64 {
    z.iter().zip(mean_row(setting)).map(|(z, weight)| weight * z).sum()
}

/// `max |x - mean|` over the strains of a cell.
fn swing(z: &[f64], setting: &WaveSetting) -> f64 {
    let mean = mean(z, setting);
    max_norm(z[..setting.q.cell].iter().map(|x| x - mean))
}
