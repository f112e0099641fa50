//! The energy of the kink of a moving dark breather, relative to its background.
//!
//! | symbol | meaning |
//! |---|---|
//! | `E, K` | energy; kinetic energy, averaged over the time in which the kink moves on by a site |
//! | `omega', delta` | frequency `omega_b + delta/T_m` and twist of the background on the ring |
//! | `J, P` | action of the oscillation, and momentum of the kink: `2 K = omega' J + v P` |
//! | `L` | averaged Lagrangian; `E - 2 K = -L` |
//!
//! The difference of `E` and the energy of `N` sites of the background changes with `omega'` like
//! `N de/domega`, where `e` is the energy of a site. That is large, so a small error of the twist
//! makes a large error of this difference. `E - 2 K = E - omega' J - v P` changes with `omega'`
//! like `N j` only, where `j` is the action of a site, since `de = omega dj` along the background.
//! It is the energy of the kink at a given action and momentum up to `omega' J + v P`, and its
//! derivative by `v` is `-P`.

use super::MovingOrbit;
use crate::{
    chain::{Boundary, Chain, Energy, Params, Site, State},
    error::Result,
    orbits::or_nan,
    run::state_at,
    waves::{Given, MeanStrain, Search, WaveNumber, WaveSetting},
};
use hertzchain_integrators::collocation::StepControl;
use std::f64::consts::PI;

/// Intervals of the trapezoidal rule in a quarter of a period.
const PARTS: usize = 32;
/// Sites of the ring of a background.
const SITES: usize = 4;

/// Two energies of a kink, or of one site of a background.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct KinkEnergy {
    /// `E`.
    #[serde(deserialize_with = "or_nan")]
    pub energy: f64,
    /// `E - 2 K = E - omega' J - v P`.
    #[serde(deserialize_with = "or_nan")]
    pub free: f64,
}

/// The setting of the background with the frequency `omega_b`, `x_n = X(pi n - omega_b t)`.
pub(super) fn background(params: Params, omega_b: f64) -> Result<WaveSetting> {
    let q = WaveNumber::on_ring(1.0, SITES)?;
    Ok(WaveSetting { params, q, omega_tw: omega_b, mean: MeanStrain::Value(0.0) })
}

/// Energies of one site of the background with the frequency `omega_b`.
///
/// # Errors
/// As [`Search::wave`].
///
/// ```
/// use hertzchain_orbits::{Params, breathers::{KinkEnergy, background_energy}};
/// let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
/// let at = |omega: f64| background_energy(params, omega);
/// let (low, high) = (at(2.049)?, at(2.051)?);
/// // de = omega dj with omega j = e - free.
/// let action = |omega: f64, one: KinkEnergy| (one.energy - one.free) / omega;
/// let slope = (high.energy - low.energy) / (action(2.051, high) - action(2.049, low));
/// assert!((slope - 2.05).abs() < 1e-4);
/// # Ok::<(), hertzchain_orbits::Error>(())
/// ```
pub fn background_energy(params: Params, omega_b: f64) -> Result<KinkEnergy> {
    let search = Search::default();
    let (wave, _) = search.wave(&background(params, omega_b)?, Given::Frequency)?;
    let chain = Chain::new(params, Boundary::StrainRing, SITES)?;
    let [x, y, vx, vy] = wave.on_ring(SITES);
    let state = State::from_fn(&chain, |n| Site { u: x[n], v: y[n], u_dot: vx[n], v_dot: vy[n] })?;
    let whole = averaged(&chain, state.as_slice(), 0.5 * PI / omega_b, PARTS, search.tol)?;
    Ok(KinkEnergy { energy: whole.energy / SITES as f64, free: whole.free / SITES as f64 })
}

/// `E` and `E - 2 K` of a state, where `K` is averaged from 0 to `time` by the trapezoidal rule.
/// The kinetic energy is even about both ends of this interval.
fn averaged(chain: &Chain<f64>, start: &[f64], time: f64, parts: usize, tol: f64) -> Result<KinkEnergy> {
    let mut run = chain.collocation(start, (0.0, time), StepControl::Tolerance(tol))?;
    let mut kinetic = 0.0;
    for k in 0..=parts {
        let state = state_at(&mut run, time * k as f64 / parts as f64)?;
        let Energy { beads, resonators, .. } = chain.energy(&state);
        kinetic += (beads + resonators) * if k == 0 || k == parts { 0.5 } else { 1.0 } / parts as f64;
    }
    let energy = chain.energy(start).total();
    Ok(KinkEnergy { energy, free: energy - 2.0 * kinetic })
}

impl MovingOrbit {
    /// Energies of the kink: those of the ring less those of as many sites of a background without
    /// a twist, at the frequency `omega_b + delta/T_m` that the background has on the ring. The
    /// energy of the twist `delta` itself, of the order of `1/N`, is not subtracted.
    ///
    /// # Errors
    /// Those of [`background_energy`], and an integration that fails.
    pub fn kink_energy(&self, twist: f64, tol: f64) -> Result<KinkEnergy> {
        let breather = &self.setting;
        let site = background_energy(breather.params, breather.omega_b + twist / breather.passage())?;
        // By symmetry the kinetic energy is even about both ends of half a passage.
        let parts = PARTS * (2 * breather.turns as usize + 1);
        let ring = averaged(&breather.chain()?, &self.z, 0.5 * breather.passage(), parts, tol)?;
        let sites = breather.sites as f64;
        Ok(KinkEnergy { energy: ring.energy - sites * site.energy, free: ring.free - sites * site.free })
    }
}
