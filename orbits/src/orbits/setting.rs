//! The numbers that determine a periodic orbit on a given branch: chain, frequency and centre.

use crate::{
    chain::{Boundary, Chain, Params, Resonators},
    dps::Center,
    error::{Result, SMOOTH, positive, require},
    named::named,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

named! {
    /// A number of the setting that can vary along a branch of orbits.
    pub enum Parameter {
        /// Frequency `omega_b`.
        OmegaB = "omega_b", "ω_b";
        /// Mass ratio `rho`.
        Rho = "rho", "ρ";
        /// Spring constant `kappa`.
        Kappa = "kappa", "κ";
        /// Exponent `alpha`.
        Alpha = "alpha", "α";
        /// Vertical centre `C_x`.
        Cx = "c_x", "C_x";
    }
    /// The symbol in pictures.
    pub fn symbol
}

/// A ring of strains (eq:HertzS), and the frequency and centre of an orbit on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Exponent, spring constant, mass ratio.
    pub params: Params,
    /// Bonds on the ring, `n = -N .. N`.
    pub sites: usize,
    /// Frequency `omega_b = 2 pi/T`.
    pub omega_b: f64,
    /// Vertical centre of the first site (eq:center): the mean of its strains `x` at `t = 0` and
    /// `T/(2 turns)`.
    pub c_x: f64,
    /// Oscillations of the background in a period: 1, or 2 where the period is doubled.
    pub turns: u32,
    /// The symmetry about the middle of the ring, if there is one: `x_{-n}(t) = x_n(t + T/2)` (site)
    /// or `x_{1-n} = x_n` (bond). Where the period is doubled, that of the orbits of half the
    /// period.
    #[serde(deserialize_with = "Option::deserialize")]
    pub about: Option<Center>,
}

/// Largest number of sites for which the tangent map of contact collocation is computed.
const MOST_SITES: usize = 256;

impl Setting {
    /// The chain, after all numbers are checked.
    ///
    /// # Errors
    /// The first number that breaks its rule: no fixed resonators, and `alpha > 1`; 3 to 256 sites;
    /// `omega_b` positive; a finite centre; `turns` 1 or 2.
    pub fn chain(&self) -> Result<Chain<f64>> {
        let Self { params, sites, omega_b, c_x, turns, .. } = *self;
        params.validate()?;
        let rule = "an orbit of this kind has resonators that move, or none: 0 <= rho < inf";
        require(params.resonators() != Resonators::Fixed, "rho", params.rho, rule)?;
        require(params.alpha > 1.0, "alpha", params.alpha, SMOOTH)?;
        require((3..=MOST_SITES).contains(&sites), "sites", sites, "from 3 to 256 sites")?;
        positive("omega_b", omega_b)?;
        require(c_x.is_finite(), "c_x", c_x, "a finite number")?;
        require((1..=2).contains(&turns), "turns", turns, "1, or 2 for a doubled period")?;
        Chain::new(params, Boundary::StrainRing, sites)
    }

    /// Strains of an orbit at `t = 0`: `x`, and `y` where resonators move.
    pub fn numbers(&self) -> usize {
        if self.params.resonators() == Resonators::Moving { 2 * self.sites } else { self.sites }
    }

    /// The mirror image of an entry of `[x, y]`, if the orbit has a symmetry.
    pub(super) fn mirror(&self) -> Option<(Center, impl Fn(usize) -> usize + use<>)> {
        let sites = self.sites;
        self.about.filter(|_| self.turns == 1).map(|about| {
            let image = move |i: usize| match about {
                Center::Site => sites - 1 - i,
                Center::Bond => (sites - i) % sites,
            };
            (about, move |k: usize| k / sites * sites + image(k % sites))
        })
    }

    /// Frequency `(alpha |x|^{alpha-1})^{1/2}` of a contact with the largest of the given strains,
    /// or that of the resonators if it is higher, in units of `omega_b`.
    ///
    /// Infinite for strains that are not finite.
    pub fn fastest_rate(&self, strains: &[f64]) -> f64 {
        let Self { params, omega_b, .. } = *self;
        let size =
            strains.iter().fold(0.0, |size: f64, x| if x.is_finite() { size.max(x.abs()) } else { f64::INFINITY });
        (params.alpha * size.powf(params.alpha - 1.0)).sqrt().max(params.omega()) / omega_b
    }

    /// `T = 2 pi/omega_b`.
    pub fn period(&self) -> f64 {
        2.0 * PI / self.omega_b
    }

    /// The value of a parameter.
    pub fn get(&self, parameter: Parameter) -> f64 {
        match parameter {
            Parameter::OmegaB => self.omega_b,
            Parameter::Rho => self.params.rho,
            Parameter::Kappa => self.params.kappa,
            Parameter::Alpha => self.params.alpha,
            Parameter::Cx => self.c_x,
        }
    }

    /// The setting with another value of a parameter, which is not checked.
    #[must_use]
    pub fn with(mut self, parameter: Parameter, value: f64) -> Self {
        *match parameter {
            Parameter::OmegaB => &mut self.omega_b,
            Parameter::Rho => &mut self.params.rho,
            Parameter::Kappa => &mut self.params.kappa,
            Parameter::Alpha => &mut self.params.alpha,
            Parameter::Cx => &mut self.c_x,
        } = value;
        self
    }
}
