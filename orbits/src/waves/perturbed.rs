//! Perturbed travelling waves (eq:dA0_ptb): the amplitude of each site is drawn at random near that
//! of the wave.
//!
//! | symbol | meaning |
//! |---|---|
//! | `D_n` | `delta^- A_n`, complex amplitude of strain `n` |
//! | `b_n` | `delta^- B_n`, mean of strain `n` |
//! | `zeta` | largest relative change of real and imaginary part of `D_n` |
//! | `C` | mean force `g_alpha(b, a)` of the wave, and of all bonds when perturbed (eq:g_alpha) |
//!
//! The initial state of the chain is (eq:xy_app), (eq:xy_v_app) at `t = 0`; at later times the
//! ansatz follows the flow (eq:S1newS).
//!
//! # The choice of the mean strains
//!
//! The paper holds `C` constant. A ring conserves the mean of `x_n' + rho y_n'` instead, so the
//! mean of `(x_n + rho y_n) / (1 + rho)`, which is that of `epsilon b_n` to leading order, moves at
//! its constant initial speed. With constant `C` the mean of the `b_n` follows that of the `r_n`,
//! which the perturbation changes at second order in `zeta`. In the first run of the paper the
//! change is 1.3e-6 at `zeta = 0.01` and 1.4e-4 at 0.1, and the chain follows a hundredth of it.
//! There a given mean strain is right and a given force is not, but the two ansatzes differ by 3e-5
//! of the amplitude where both are 8e-2 from the chain. Scenes therefore make the paper's choice.

use super::{Shape, TravellingWave};
use crate::{
    chain::Site,
    dps::{Ansatz, Averages, Constraint, Dps, Ends, Form, Layout},
    error::{Result, require},
    random::uniform,
};

/// A travelling wave and one draw of its perturbation.
#[derive(Clone, Debug, PartialEq)]
pub struct PerturbedWave {
    wave: TravellingWave,
    zeta: f64,
    seed: u64,
    sites: usize,
    force: f64,
    amplitudes: Vec<f64>,
}

impl PerturbedWave {
    /// The wave on a ring of `sites` sites, perturbed (eq:dA0_ptb).
    ///
    /// `D_n(0) = a [(1 + zeta_n^(1)) cos(nq + phi) - i (1 + zeta_n^(2)) sin(nq + phi)]`, where all
    /// `zeta_n` are independent, uniform in `[-zeta, zeta)`, and determined by the seed.
    ///
    /// # Errors
    /// `zeta` outside `(0, 1)`, fewer than two sites, a mean force that underflows.
    pub fn new(wave: TravellingWave, sites: usize, zeta: f64, seed: u64) -> Result<Self> {
        require(zeta > 0.0 && zeta < 1.0, "zeta", zeta, "the relative size of a perturbation is above 0 and below 1")?;
        require(sites >= 2, "sites", sites, "a perturbed ring has at least two sites")?;
        let Shape { q, a, b, phi } = wave.shape;
        let force = Averages::new(wave.params.alpha, wave.params.kappa)?.g(b, a);
        require(force.is_normal(), "C", force, "the mean force g_alpha(b, a) is a normal number")?;
        let mut random = uniform(seed);
        let mut amplitudes = vec![0.0; 2 * sites];
        for n in 0..sites {
            let (sin, cos) = (n as f64 * q + phi).sin_cos();
            amplitudes[n] = a * (1.0 + zeta * random()) * cos;
            amplitudes[sites + n] = -a * (1.0 + zeta * random()) * sin;
        }
        Ok(Self { wave, zeta, seed, sites, force, amplitudes })
    }

    /// The wave without perturbation.
    pub fn wave(&self) -> &TravellingWave {
        &self.wave
    }

    /// The largest relative change `zeta`.
    pub fn zeta(&self) -> f64 {
        self.zeta
    }

    /// The seed of the random numbers.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// `D_n(0)`, the state of the flow at `tau = 0`: real parts, then imaginary parts.
    pub fn amplitudes(&self) -> &[f64] {
        &self.amplitudes
    }

    /// The constraint of the paper (eq:g_alpha): the mean force is `C = g_alpha(b, a)` at all
    /// times.
    pub fn constraint(&self) -> Constraint {
        Constraint::Force(self.force)
    }

    /// The flow of the `D_n` (eq:S1newS) under a constraint.
    ///
    /// # Errors
    /// As [`Dps::generalised`].
    pub fn flow(&self, constraint: Constraint) -> Result<Dps> {
        Dps::generalised(self.wave.params, constraint, self.layout())
    }

    /// The map from the `D_n` to the chain (eq:xy_app).
    ///
    /// # Errors
    /// As [`Ansatz::generalised`].
    pub fn ansatz(&self, constraint: Constraint) -> Result<Ansatz> {
        Ansatz::generalised(self.wave.params, constraint, self.layout(), self.wave.epsilon)
    }

    /// The strains and their rates at `t = 0`.
    ///
    /// # Errors
    /// As [`ansatz`](Self::ansatz).
    pub fn initial(&self, constraint: Constraint) -> Result<Vec<Site<f64>>> {
        Ok(self.ansatz(constraint)?.sites(0.0, &self.amplitudes))
    }

    fn layout(&self) -> Layout {
        Layout { sites: self.sites, ends: Ends::Ring, form: Form::Strains }
    }
}
