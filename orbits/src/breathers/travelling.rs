//! Bright breathers that travel under a static load: relative periodic orbits of the strain ring.
//!
//! | symbol | meaning |
//! |---|---|
//! | `d` | static overlap of the contacts: far from the breather `x_n = -d` |
//! | `A, theta` | amplitude and phase of the soliton of the nonlinear Schrodinger equation ([`Nls`]) |
//! | `m` | turns: `omega_A T_m - theta = 2 pi m`, with the soliton's frequency `omega_A` |
//! | `T_m, v` | time in which the breather moves on by a site: `T_m = 1/c(theta)`, `v = 1/T_m` |
//!
//! The equations are those of [moving dark breathers](super::MovingBreather), with the same
//! symmetry about the middle bond: a breather that moves on by one site has the phase of its waves
//! there again. `A` and `m` give `theta` and `T_m`; the orbit is the one with this `T_m`. In the
//! frame of the breather it is in resonance with linear waves of both bands, so that it has a tail
//! of them. The tail falls faster than any power of `A`, and on a ring it depends on the distance
//! of these waves from those that fit the ring. L. Liu, G. James, P. Kevrekidis & A. Vainchtein
//! 2016, Physica D 331, 27, run such breathers.

use super::Relative;
use crate::{
    chain::{Boundary, Chain, Params, Resonators},
    dps::Center,
    error::{Error, Result, positive, require},
    numerics::least_above,
    orbits::{Orbit, Setting},
    waves::{Nls, Soliton},
};
use std::f64::consts::PI;

/// Phases among which that of a breather is sought.
const PHASES: u32 = 1000;
/// Largest tail of a breather.
const LOCALISED: f64 = 0.2;

/// The numbers that determine a travelling bright breather.
#[derive(Clone, Copy, Debug)]
pub struct TravellingBreather {
    setting: Setting,
    soliton: Soliton,
    wave: Nls,
}

/// A bright breather that travels to the right: `z` is `[x, y, x', y']` at `t = 0`, when it is
/// about the middle bond.
pub type TravellingOrbit = Orbit<TravellingBreather>;

/// Sizes of a travelling breather, from `r_n = ((x_n + d)^2 + (x_n'/omega_b)^2)^{1/2}` at `t = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Largest `r_n`: that of the soliton is `2 A sin(theta/2)`.
    pub amplitude: f64,
    /// `(sum r_n^2)^2/(3 sum r_n^4)`, which is `w` for `sech(n/w)`.
    pub width: f64,
    /// Largest `r_n` in the eighth of the ring that is farthest from the breather, over
    /// `amplitude`.
    pub tail: f64,
}

impl TravellingBreather {
    /// The breather of the upper band of a chain with resonators, under the overlap `load`, whose
    /// soliton has the amplitude `amplitude` in displacements of beads.
    ///
    /// # Errors
    /// Numbers outside their rules: resonators that move; an odd number of sites from 9 to 255; a
    /// positive load; contacts that stay closed; a phase `theta` of the focusing part of the band
    /// with these turns.
    ///
    /// ```
    /// use hertzchain_orbits::{Params, breathers::TravellingBreather};
    /// let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
    /// let breather = TravellingBreather::new(params, 61, 1.0, 1, 0.8)?;
    /// let orbit = breather.orbit(1e-13)?;
    /// // S^{-1} Phi_{T_m} z = z, with the flow over the whole time.
    /// assert!(orbit.return_error(1e-13)? < 1e-10);
    /// # Ok::<(), hertzchain_orbits::Error>(())
    /// ```
    pub fn new(params: Params, sites: usize, load: f64, turns: u32, amplitude: f64) -> Result<Self> {
        let rule = "a bright breather travels in the upper band of resonators that move: 0 < rho < inf";
        require(params.resonators() == Resonators::Moving, "rho", params.rho, rule)?;
        positive("precompression", load)?;
        positive("amplitude", amplitude)?;
        require((9..=255).contains(&sites) && !sites.is_multiple_of(2), "sites", sites, "an odd number from 9 to 255")?;
        require((1..=100).contains(&turns), "turns", turns, "from 1 to 100")?;
        let at = |theta: f64| -> Result<(Nls, f64)> {
            let wave = Nls::new(params, [1.0, load], theta)?[1];
            let omega = wave.omega - 0.125 * wave.nonlinearity * amplitude * amplitude;
            Ok((wave, omega / wave.group_velocity - theta - 2.0 * PI * f64::from(turns)))
        };
        // The turns fall along the band from infinity at its lower edge.
        let mut low = 0.0;
        for k in 1..PHASES {
            let theta = PI * f64::from(k) / f64::from(PHASES);
            let (wave, excess) = at(theta)?;
            if !wave.focusing() {
                break;
            }
            if excess > 0.0 {
                low = theta;
                continue;
            }
            let found = least_above(low.max(1e-9), |x| x >= theta || at(x).is_ok_and(|(_, excess)| excess <= 0.0));
            let wave = at(found.unwrap_or(theta))?.0;
            let omega_b = (2.0 * PI * f64::from(turns) + wave.theta) * wave.group_velocity;
            let rule = "contacts stay closed: strains of the soliton, 2 A sin(theta/2), below the precompression";
            require(2.0 * amplitude * (0.5 * wave.theta).sin() < load, "amplitude", amplitude, rule)?;
            let soliton = wave.soliton(amplitude)?;
            let rule = "a soliton at most a sixth of the ring wide: a larger amplitude, or more sites";
            require(6.0 * soliton.width() <= sites as f64, "amplitude", amplitude, rule)?;
            let about = Some(Center::Bond);
            return Ok(Self { setting: Setting { params, sites, omega_b, c_x: -load, turns, about }, soliton, wave });
        }
        let rule = "no bright breather of the upper band has these turns at this amplitude";
        Err(Error::parameter("turns", turns, rule))
    }

    /// The soliton, whose phase is that of the breather.
    pub fn soliton(&self) -> (Nls, Soliton) {
        (self.wave, self.soliton)
    }

    /// The state of the soliton, to first order.
    pub fn seed(&self) -> Vec<f64> {
        let Setting { sites, c_x, .. } = self.setting;
        let share = 2.0 * (0.5 * self.wave.theta).sin();
        let mut z = vec![0.0; 4 * sites];
        for i in 0..sites {
            let site = self.soliton.site(i as f64 - 0.5 * sites as f64, 0.0);
            (z[i], z[sites + i]) = (c_x + share * site.u, c_x + share * site.v);
            (z[2 * sites + i], z[3 * sites + i]) = (share * site.u_dot, share * site.v_dot);
        }
        z
    }

    /// The orbit.
    ///
    /// # Errors
    /// As [`Relative::solve`]; an orbit that is not localised.
    pub fn orbit(&self, tol: f64) -> Result<TravellingOrbit> {
        let orbit = self.solve(&self.seed(), tol)?;
        let rule = "a breather is localised: the tail of this orbit is above a fifth of its amplitude";
        require(orbit.sizes().tail <= LOCALISED, "tail", orbit.sizes().tail, rule)?;
        Ok(orbit)
    }
}

impl Relative for TravellingBreather {
    fn setting(&self) -> Setting {
        self.setting
    }

    fn passage(&self) -> f64 {
        1.0 / self.wave.group_velocity
    }

    fn chain(&self) -> Result<Chain<f64>> {
        Chain::new(self.setting.params, Boundary::StrainRing, self.setting.sites)
    }
}

impl TravellingOrbit {
    /// Amplitude, width and tail.
    pub fn sizes(&self) -> Sizes {
        let Setting { sites, c_x, omega_b, .. } = self.setting.setting;
        let r = |i: usize| (self.z[i] - c_x).hypot(self.z[2 * sites + i] / omega_b);
        let power = |k: i32| (0..sites).map(|i| r(i).powi(k)).sum::<f64>();
        let amplitude = (0..sites).map(r).fold(0.0, f64::max);
        // Site 0 is opposite to the breather.
        let far = (0..sites).filter(|i| 16 * i.min(&(sites - i)) <= sites).map(r).fold(0.0, f64::max);
        Sizes { amplitude, width: power(2).powi(2) / (3.0 * power(4)), tail: far / amplitude }
    }
}
