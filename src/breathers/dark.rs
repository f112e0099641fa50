//! Dark breathers: exact orbits of the chain of strains, from the profiles of the DpS equations (Sec. 7).

use crate::{
    chain::{Params, max_norm},
    dps::{Center, DarkProfile},
    error::{Error, Result},
    orbits::{Continuation, Orbit, Parameter, Setting, Shooting},
};

/// Where the seed is good for every mass ratio: `omega_b = (1 + NEAR) omega`.
const NEAR: f64 = 2.5e-3;
/// Share of the way from there to `omega_b` that a step of continuation takes at most.
const STEP: f64 = 0.1;
const MOST_POINTS: usize = 500;
/// Frequency of the contacts of a seed over its own, at most: with 6 there is an orbit nearby (`rho = 0.01`), with 35 there is none (`rho = 0.001`).
const FASTEST: f64 = 10.0;

/// A dark breather to be found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DarkBreather {
    /// Exponent, spring constant, mass ratio.
    pub params: Params,
    /// Whether the kink is on a site or a bond of the DpS lattice.
    pub center: Center,
    /// Bonds on the ring: an odd number.
    pub sites: usize,
    /// Its frequency, above `omega`.
    pub omega_b: f64,
    /// Vertical centre of the background; 0 in the paper.
    pub c_x: f64,
}

impl DarkBreather {
    /// What an orbit of it is an orbit of.
    pub fn setting(&self) -> Setting {
        let Self { params, sites, omega_b, c_x, .. } = *self;
        Setting { params, sites, omega_b, c_x, turns: 1 }
    }

    /// Gives one of its numbers another value, unchecked.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        let Setting { params, omega_b, c_x, .. } = self.setting().with(parameter, value);
        (self.params, self.omega_b, self.c_x) = (params, omega_b, c_x);
    }

    /// `[x(0), y(0)]` to first order, (eq:xy_sw).
    ///
    /// # Errors
    /// As [`DarkProfile::new`] and [`DarkProfile::seed`]; strains beyond all that is small, where contacts are 10 times as fast as the breather.
    pub fn seed(&self) -> Result<Vec<f64>> {
        let Self { params, center, sites, omega_b, c_x } = *self;
        let unit = DarkProfile::new(params, center, sites, 0.0)?;
        let size = unit.mu(omega_b)?.powf((params.alpha - 1.0).recip());
        let profile = if c_x == 0.0 { unit } else { DarkProfile::new(params, center, sites, c_x / size)? };
        let (mut z, y) = profile.seed(omega_b)?;
        z.extend(y);
        // A background that presses so hard is no small oscillation, and Newton's method wanders about for minutes.
        if self.setting().haste(&z) > FASTEST {
            let rule = "the first-order breather has contacts at most 10 times as fast as it is: take a larger rho, or omega_b nearer to omega";
            return Err(Error::parameter("strains", max_norm(z), rule));
        }
        Ok(z)
    }

    /// The orbit: by Newton's method from the seed; where that does not converge, along the branch from a frequency near `omega`.
    ///
    /// # Errors
    /// Numbers outside their rules, and [`Error::Stalled`] with the best iterate where neither leads there.
    pub fn orbit(&self, shooting: &Shooting) -> Result<Orbit> {
        let stalled = match shooting.solve(&self.setting(), &self.seed()?) {
            Err(error @ Error::Stalled { .. }) => error,
            solved => return solved,
        };
        let near = Self { omega_b: self.params.omega() * (1.0 + NEAR), ..*self };
        if self.omega_b <= near.omega_b {
            return Err(stalled);
        }
        let continuation = Continuation {
            parameter: Parameter::OmegaB,
            to: self.omega_b,
            step: STEP * (self.omega_b - near.omega_b),
            most_points: MOST_POINTS,
            natural: false,
            shooting: *shooting,
        };
        let (mut orbits, _) = continuation.follow(shooting.solve(&near.setting(), &near.seed()?)?, |_| {})?;
        orbits.pop().filter(|orbit| orbit.setting.omega_b == self.omega_b).ok_or(stalled)
    }
}
