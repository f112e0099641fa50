//! Dark breathers: exact orbits of the chain of strains, computed from the profiles of the DpS
//! equations (Sec. 7), or, under a precompression `d = -C_x` that keeps contacts closed, from those
//! of the nonlinear Schrodinger equation at an edge `omega_e` of a band at `theta = pi`,
//!
//! ```text
//! x_n = C_x + b (|A|^2 - a^2) + (-1)^n 4 A cos(omega_b t),   A = a tanh((n - n_0)/w)
//! omega_b = omega_e - beta_0 a^2,   w = (-omega''/beta)^{1/2}/a,   b = 4 (alpha - 1)/d
//! ```
//!
//! with the coefficients of [`Nls`]; `b` is that of the slow strain. Kinks that are wider than a
//! few sites have no barrier above rounding; their symmetry holds them at their centre.

use crate::{
    chain::{Params, Resonators, max_norm},
    dps::{Center, DarkProfile},
    error::{Error, Result, require},
    orbits::{Continuation, Orbit, Parameter, Setting, Shooting},
    waves::Nls,
};
use std::f64::consts::PI;

/// Relative distance of `omega_b` from `omega` at which continuation starts; the seed is accurate
/// enough there.
const NEAR: f64 = 2.5e-3;
/// Largest step of the continuation, as a share of the way to `omega_b`.
const STEP: f64 = 0.1;
const MOST_POINTS: usize = 500;
/// Strains that differ by less than this, over their size, are those of a chain at rest.
const STILL: f64 = 1e-9;
/// Amplitude of the loaded background at which continuation starts, in units of the precompression.
const NEAR_EDGE: f64 = 0.5;
/// Largest distance of a kink from its centre, as a part of the background's strain there.
const CENTRED: f64 = 1e-2;
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
    /// Frequency of the breather: above `omega`, or near the edge of a band of the loaded chain.
    pub omega_b: f64,
    /// Vertical centre of the background, minus the precompression; 0 in the paper.
    pub c_x: f64,
}

/// The background of a loaded breather.
#[derive(Clone, Copy, Debug)]
struct Loaded {
    edge: Nls,
    /// `a`.
    a: f64,
}

impl DarkBreather {
    /// The setting of its orbit.
    pub fn setting(&self) -> Setting {
        let Self { params, center, sites, omega_b, c_x } = *self;
        Setting { params, sites, omega_b, c_x, turns: 1, about: Some(center) }
    }

    /// Changes the value of a parameter, unchecked.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        let Setting { params, omega_b, c_x, .. } = self.setting().with(parameter, value);
        (self.params, self.omega_b, self.c_x) = (params, omega_b, c_x);
    }

    /// The edges of the bands of the loaded chain at `theta = pi` that have dark breathers.
    fn edges(&self) -> Vec<Nls> {
        let all = if self.c_x < 0.0 { Nls::new(self.params, [1.0, -self.c_x], PI) } else { Ok(Vec::new()) };
        all.unwrap_or_default().into_iter().filter(|edge| !edge.focusing()).collect()
    }

    /// The background near the edge that has breathers of this frequency, the nearest of them.
    fn loaded(&self) -> Option<Loaded> {
        let of = |edge: Nls| Loaded { edge, a: ((edge.omega - self.omega_b) / edge.at_mean_strain).sqrt() };
        let all = self.edges().into_iter().map(of).filter(|background| background.a > 0.0);
        all.min_by(|a, b| a.a.total_cmp(&b.a))
    }

    /// The frequency at an edge of a background with this amplitude of strains, in units of the
    /// precompression.
    fn under_load(&self, edge: &Nls, share: f64) -> f64 {
        edge.omega - edge.at_mean_strain * (0.25 * share * self.c_x).powi(2)
    }

    /// The frequency of a breather if none is given: `ratio` times `omega`; under a precompression
    /// that of a background at the upper edge of the bands, with an amplitude of `share` of it.
    pub fn usual_frequency(&self, [ratio, share]: [f64; 2]) -> f64 {
        self.edges().last().map_or(ratio * self.params.omega(), |edge| self.under_load(edge, share))
    }

    /// The seed under a precompression that keeps contacts closed.
    fn loaded_seed(&self) -> Option<Vec<f64>> {
        let Loaded { edge, a } = self.loaded()?;
        let Self { params: Params { alpha, kappa, rho, .. }, sites, omega_b, c_x, center } = *self;
        if 4.0 * a >= -c_x {
            return None;
        }
        let width = (-edge.dispersion / edge.nonlinearity).sqrt() / a;
        let kink = if center == Center::Site { 0.0 } else { 0.5 };
        let half = (sites / 2) as i32;
        let array = |ratio: f64| {
            (-half..=half).map(move |n| {
                let share = ((f64::from(n) - kink) / width).tanh();
                let slow = -4.0 * (alpha - 1.0) / c_x * a * a * (share * share - 1.0);
                c_x + slow + ratio * if n % 2 == 0 { 4.0 } else { -4.0 } * a * share
            })
        };
        let mut z: Vec<f64> = array(1.0).collect();
        if self.params.resonators() == Resonators::Moving {
            z.extend(array(kappa / (kappa - rho * omega_b * omega_b)));
        }
        Some(z)
    }

    /// `[x(0), y(0)]` to first order, (eq:xy_sw), or under a precompression as at the head of this
    /// module.
    ///
    /// # Errors
    /// As [`DarkProfile::new`] and [`DarkProfile::seed`]; a centre that is not finite; strains so
    /// large that contacts are more than 10 times as fast as the breather.
    pub fn seed(&self) -> Result<Vec<f64>> {
        require(self.c_x.is_finite(), "c_x", self.c_x, "a finite number")?;
        if let Some(z) = self.loaded_seed() {
            return Ok(z);
        }
        let rule = "without resonators a dark breather is below the edge of the band, at first order in its amplitude";
        require(self.params.resonators() != Resonators::None || self.c_x >= 0.0, "omega_b", self.omega_b, rule)?;
        let Self { params, center, sites, omega_b, c_x } = *self;
        let unit = DarkProfile::new(params, center, sites, 0.0)?;
        let size = unit.mu(omega_b)?.powf((params.alpha - 1.0).recip());
        let profile = if c_x == 0.0 { unit } else { DarkProfile::new(params, center, sites, c_x / size)? };
        let (mut z, y) = profile.seed(omega_b)?;
        z.extend(y);
        // Such a strong background is not a small oscillation, and Newton's method would run for
        // minutes without result.
        let rule = "the first-order breather has contacts at most 10 times as fast as it is: take a larger rho, or omega_b nearer to omega";
        require(self.setting().fastest_rate(&z) <= FASTEST, "strains", max_norm(z.iter().copied()), rule).map(|()| z)
    }

    /// Refuses an orbit that is no dark breather about this centre: a chain at rest, a kink
    /// elsewhere, and under a precompression a background whose neighbours are not in antiphase.
    fn check(&self, orbit: &Orbit, tol: f64) -> Result<()> {
        let x = orbit.x();
        let swing = |x: f64| x - self.c_x;
        let (size, middle) = (swing(x[0]).abs(), self.sites / 2);
        let moves = x.iter().any(|one| (one - x[0]).abs() > STILL * orbit.amplitude());
        let rule = "no dark breather of this frequency was found: the chain is at rest";
        require(moves, "omega_b", self.omega_b, rule)?;
        // Strains of opposite phase about a site leave the first harmonic no part there; about a
        // bond they are even.
        let (off, rule) = match self.center {
            Center::Site => {
                let half = orbit.states(tol, &[0.5 * orbit.setting.period()])?;
                (half[0][middle] - x[middle], "no dark breather of this frequency was found about a site")
            }
            Center::Bond => (x[middle + 1] - x[middle], "no dark breather of this frequency was found about a bond"),
        };
        require(off.abs() < CENTRED * size, "omega_b", self.omega_b, rule)?;
        let alike = (0..self.sites).filter(|&n| swing(x[n]) * swing(x[(n + 1) % self.sites]) > 0.0).count();
        let rule = "no dark breather of this frequency was found: its background has more than one kink";
        require(self.c_x >= 0.0 || alike == 1, "omega_b", self.omega_b, rule)
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
        let loaded = self.loaded();
        let solve = |breather: &Self| {
            let orbit = shooting.solve(&breather.setting(), &breather.seed()?)?;
            breather.check(&orbit, shooting.tol).map(|()| orbit)
        };
        let stalled = match solve(self) {
            Err(_) if loaded.is_some() => {
                let rule = "no dark breather of this frequency was found from those near the edge of its band";
                Error::parameter("omega_b", self.omega_b, rule)
            }
            Err(error @ Error::Stalled { .. }) => error,
            solved => return solved,
        };
        let omega_b = match &loaded {
            Some(background) => self.under_load(&background.edge, NEAR_EDGE),
            None => self.params.omega() * (1.0 + NEAR),
        };
        let near = Self { omega_b, ..*self };
        if loaded.is_none() && self.omega_b <= near.omega_b {
            return Err(stalled);
        }
        let continuation = Continuation {
            parameter: Parameter::OmegaB,
            to: self.omega_b,
            step: STEP * (self.omega_b - near.omega_b).abs(),
            most_points: MOST_POINTS,
            shooting: *shooting,
        };
        let Ok(first) = solve(&near) else { return Err(stalled) };
        let (mut orbits, _) = continuation.follow(first, |_| {})?;
        orbits.pop().filter(|orbit| orbit.setting.omega_b == self.omega_b).ok_or(stalled)
    }
}
