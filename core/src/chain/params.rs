//! The three parameters of the model.

use crate::error::{Result, require};
use hertzchain_integrators::{DoubleDouble, Real};
use serde::{Deserialize, Serialize};

/// Exponent, spring constant and mass ratio of (eq:Hertz), all dimensionless.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Params {
    /// Exponent of the contact force, `alpha > 0`; 3/2 for spheres.
    pub alpha: f64,
    /// Spring constant of the resonators, `kappa >= 0`.
    pub kappa: f64,
    /// Mass of a resonator over that of a bead, in `[0, inf]`.
    pub rho: f64,
}

/// The role of the resonators in a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resonators {
    /// No resonators that act on beads: `rho = 0`, or `kappa = 0`. The plain Hertz chain.
    None,
    /// Infinitely heavy resonators, at rest: every bead has an on-site spring. Newton's cradle
    /// (eq:NC).
    Fixed,
    /// Resonators that move.
    Moving,
}

impl Params {
    /// Checked parameters.
    ///
    /// # Errors
    /// See [`validate`](Self::validate).
    ///
    /// ```
    /// use hertzchain_core::chain::Params;
    /// assert!(Params::new(1.5, 1.0, 1.0 / 3.0).is_ok());
    /// assert_eq!(
    ///     Params::new(1.5, -1.0, 0.0).unwrap_err().to_string(),
    ///     "kappa = -1 is not valid: the spring constant is finite and at least zero"
    /// );
    /// ```
    pub fn new(alpha: f64, kappa: f64, rho: f64) -> Result<Self> {
        let params = Self { alpha, kappa, rho };
        params.validate()?;
        Ok(params)
    }

    /// Checks the rules: `alpha` finite and positive, `kappa` finite and not negative, `rho` in
    /// `[0, inf]`, and not so small that `omega` overflows.
    ///
    /// # Errors
    /// The first value outside its rule.
    pub fn validate(&self) -> Result<()> {
        let rule = "the exponent is finite and positive";
        require(self.alpha.is_finite() && self.alpha > 0.0, "alpha", self.alpha, rule)?;
        let rule = "the spring constant is finite and at least zero";
        require(self.kappa.is_finite() && self.kappa >= 0.0, "kappa", self.kappa, rule)?;
        require(self.rho >= 0.0, "rho", self.rho, "the mass ratio is in [0, inf]")?;
        let finite = (self.kappa / self.rho + self.rho.recip()).is_finite();
        let rule = "1/rho and kappa/rho are finite numbers; rho = 0 leaves the resonators out";
        require(finite || self.resonators() != Resonators::Moving, "rho", self.rho, rule)
    }

    /// Which of the three models this is.
    pub fn resonators(&self) -> Resonators {
        if self.rho == 0.0 || self.kappa == 0.0 {
            Resonators::None
        } else if self.rho.is_infinite() {
            Resonators::Fixed
        } else {
            Resonators::Moving
        }
    }

    /// `omega = sqrt(kappa (1 + 1/rho))`; `sqrt(kappa)` for the cradle, 0 for the plain chain.
    pub fn omega(&self) -> f64 {
        self.omega_twofold::<f64>().value()
    }

    /// [`omega`](Self::omega) to twice the working precision: long runs multiply it by long times.
    pub fn omega_twofold<R: Real>(&self) -> DoubleDouble<R> {
        let kappa = DoubleDouble::new(R::of(self.kappa));
        match self.resonators() {
            Resonators::None => DoubleDouble::zero(),
            Resonators::Fixed => kappa.sqrt(),
            Resonators::Moving => (kappa + kappa.over(DoubleDouble::new(R::of(self.rho)))).sqrt(),
        }
    }
}
