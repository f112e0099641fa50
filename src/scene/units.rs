//! Spheres in SI units, and the dimensionless chain that follows from them.
//!
//! | symbol | meaning |
//! |---|---|
//! | `R, rho_s, E, nu` | radius, density, Young's modulus, Poisson's ratio of a sphere |
//! | `A` | contact constant of Hertz's law, `F = A delta^{3/2}`, `A = 4/3 E* sqrt(R*)` |
//! | `E*` | `1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2` |
//! | `R*` | `1/R* = 1/R_1 + 1/R_2`; a flat wall has `1/R = 0` |
//!
//! Units are the radius `R` and the mass `m` of the first bead, the constant `A` of two such beads,
//! and the time `(m/(A R^{1/2}))^{1/2}`.
//!
//! K. L. Johnson, *Contact Mechanics*, Cambridge University Press 1985, section 4.2.

use super::values::Values;
use crate::{
    error::{Error, Result, require},
    report::Units,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

sections! {
    /// The section `[units]`: the material of spheres and walls, in SI units.
    pub struct UnitsSection {
        /// Radii in metres.
        radius: Values,
        /// Densities in kilograms per cubic metre.
        density: Values,
        /// Young's moduli in pascals.
        young: Values,
        /// Poisson's ratios.
        poisson: Values,
        /// Young's modulus of walls (that of the bead beside it if left out).
        wall_young?: f64,
        /// Poisson's ratio of walls (that of the bead beside it if left out).
        wall_poisson?: f64,
        /// Static load in newtons, the same in all contacts (0 if left out).
        static_load?: f64,
    }
}

/// A sphere or, with an infinite radius, a wall.
#[derive(Clone, Copy, Debug)]
struct Body {
    radius: f64,
    density: f64,
    young: f64,
    poisson: f64,
}

impl Body {
    fn mass(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3) * self.density
    }

    /// `(1 - nu^2)/E`.
    fn compliance(&self) -> f64 {
        (1.0 - self.poisson * self.poisson) / self.young
    }

    /// The contact constant `A` of two bodies.
    fn hertz(&self, other: &Self) -> f64 {
        let (modulus, radius) =
            ((self.compliance() + other.compliance()).recip(), (self.radius.recip() + other.radius.recip()).recip());
        4.0 / 3.0 * modulus * radius.sqrt()
    }
}

/// Units, masses, contact constants and static overlaps that follow from `[units]`.
pub(super) struct Material {
    pub(super) units: Units,
    pub(super) mass: Vec<f64>,
    pub(super) contact: Vec<f64>,
    pub(super) overlap: Vec<f64>,
}

impl UnitsSection {
    /// Units, masses, contact constants and static overlaps of a chain of `sites` sites; `ends` are
    /// the sites on the two sides of each bond that can touch.
    ///
    /// # Errors
    /// A value outside its rule.
    pub(super) fn material(&self, sites: usize, ends: &[[Option<usize>; 2]]) -> Result<Material> {
        let bodies = self.bodies(sites)?;
        let first = bodies[0];
        let (length, mass, constant) = (first.radius, first.mass(), first.hertz(&first));
        let time = (mass / (constant * length.sqrt())).sqrt();
        let units = Units {
            length_m: length,
            mass_kg: mass,
            time_s: time,
            velocity_m_per_s: length / time,
            force_n: constant * length.powf(1.5),
            energy_j: mass * (length / time).powi(2),
        };
        let load = self.static_load.unwrap_or(0.0);
        require(load.is_finite() && load >= 0.0, "units.static_load", load, "a load is finite and at least zero")?;
        let of = |ends: &[Option<usize>; 2]| match *ends {
            [Some(a), Some(b)] => bodies[a].hertz(&bodies[b]),
            [Some(a), None] | [None, Some(a)] => bodies[a].hertz(&self.wall(bodies[a])),
            [None, None] => 0.0,
        };
        let constants: Vec<f64> = ends.iter().map(of).collect();
        Ok(Material {
            units,
            mass: bodies.iter().map(|body| body.mass() / mass).collect(),
            overlap: constants.iter().map(|a| (load / a).powf(2.0 / 3.0) / length).collect(),
            contact: constants.iter().map(|a| a / constant).collect(),
        })
    }

    fn bodies(&self, sites: usize) -> Result<Vec<Body>> {
        let list = |name, values: &Values, good: fn(f64) -> bool, rule| {
            let values = values.of(name, sites)?;
            match values.iter().find(|&&value| !good(value)) {
                Some(value) => Err(Error::parameter(name, value, rule)),
                None => Ok(values),
            }
        };
        let positive: fn(f64) -> bool = |x| x.is_finite() && x > 0.0;
        let rule = "finite and positive";
        let radius = list("units.radius", &self.radius, positive, rule)?;
        let density = list("units.density", &self.density, positive, rule)?;
        let young = list("units.young", &self.young, positive, rule)?;
        let (ratio, ratios) = (|x: f64| x > -1.0 && x <= 0.5, "Poisson's ratio is above -1 and at most 1/2");
        let poisson = list("units.poisson", &self.poisson, ratio, ratios)?;
        self.wall_young.map(|young| crate::error::positive("units.wall_young", young)).transpose()?;
        if let Some(poisson) = self.wall_poisson.filter(|&poisson| !ratio(poisson)) {
            return Err(Error::parameter("units.wall_poisson", poisson, ratios));
        }
        let body = |i| Body { radius: radius[i], density: density[i], young: young[i], poisson: poisson[i] };
        Ok((0..sites).map(body).collect())
    }

    /// The wall beside a bead.
    fn wall(&self, beside: Body) -> Body {
        let (young, poisson) = (self.wall_young.unwrap_or(beside.young), self.wall_poisson.unwrap_or(beside.poisson));
        Body { radius: f64::INFINITY, young, poisson, ..beside }
    }
}
