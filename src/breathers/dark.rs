//! Dark breathers: exact orbits of the chain of strains, computed from the profiles of the DpS
//! equations (Sec. 7).

use crate::{
    chain::{Params, max_norm},
    dps::{Center, DarkProfile},
    error::{Error, Result},
    orbits::{Continuation, Orbit, Parameter, Setting, Shooting},
};

/// Relative distance of `omega_b` from `omega` at which continuation starts; the seed is accurate
/// enough there.
const NEAR: f64 = 2.5e-3;
/// Largest step of the continuation, as a share of the way to `omega_b`.
const STEP: f64 = 0.1;
const MOST_POINTS: usize = 500;
/// Largest frequency of contacts in a seed, in units of `omega_b`. At 6 there is an orbit near the
/// seed (`rho = 0.01`), at 35 there is none (`rho = 0.001`).
const FASTEST: f64 = 10.0;

/// The parameters of a dark breather.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DarkBreather {
    /// Exponent, spring constant, mass ratio.
    pub params: Params,
    /// Whether the kink is on a site or on a bond of the DpS lattice.
    pub center: Center,
    /// Sites on the ring of strains: an odd number.
    pub sites: usize,
    /// Frequency of the breather, above `omega`.
    pub omega_b: f64,
    /// Vertical centre of the background; 0 in the paper.
    pub c_x: f64,
}

impl DarkBreather {
    /// The setting of its orbit.
    pub fn setting(&self) -> Setting {
        let Self { params, sites, omega_b, c_x, .. } = *self;
        Setting { params, sites, omega_b, c_x, turns: 1 }
    }

    /// Changes the value of a parameter, unchecked.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        let Setting { params, omega_b, c_x, .. } = self.setting().with(parameter, value);
        (self.params, self.omega_b, self.c_x) = (params, omega_b, c_x);
    }

    /// `[x(0), y(0)]` to first order, (eq:xy_sw).
    ///
    /// # Errors
    /// As [`DarkProfile::new`] and [`DarkProfile::seed`]; strains so large that contacts are more
    /// than 10 times as fast as the breather.
    pub fn seed(&self) -> Result<Vec<f64>> {
        let Self { params, center, sites, omega_b, c_x } = *self;
        let unit = DarkProfile::new(params, center, sites, 0.0)?;
        let size = unit.mu(omega_b)?.powf((params.alpha - 1.0).recip());
        let profile = if c_x == 0.0 { unit } else { DarkProfile::new(params, center, sites, c_x / size)? };
        let (mut z, y) = profile.seed(omega_b)?;
        z.extend(y);
        // Such a strong background is not a small oscillation, and Newton's method would run for
        // minutes without result.
        if self.setting().fastest_rate(&z) > FASTEST {
            let rule = "the first-order breather has contacts at most 10 times as fast as it is: take a larger rho, or omega_b nearer to omega";
            return Err(Error::parameter("strains", max_norm(z), rule));
        }
        Ok(z)
    }

    /// The orbit of the breather.
    ///
    /// Newton's method starts from the seed. Where it does not converge, the branch is followed
    /// from a frequency near `omega`.
    ///
    /// # Errors
    /// Numbers outside their rules, and [`Error::Stalled`] with the best iterate where neither way
    /// leads to the orbit.
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
