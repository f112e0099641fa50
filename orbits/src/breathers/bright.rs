//! Long-lived bright breathers: homoclinic solutions of the stationary DpS equation as initial
//! states of the chain (Theorem longlivedb).
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_n` | homoclinic solution of (dpsstat), centred in the chain |
//! | `epsilon` | size: `u_n(0) = 2 epsilon a_n` |
//! | `mu` | `epsilon^{alpha-1} / kappa`, contact force over spring force |
//! | `Omega_b, T_b` | frequency `sqrt(kappa) (1 + omega_0 mu)` and period `2 pi/Omega_b` |
//! | `T` | `2 pi/omega_0`; the theorem speaks of times up to the horizon `T / (mu sqrt(kappa))` |
//! | core | fewest sites, symmetric about the centre, that hold a share of 0.999 of `sum a_n^2` |
//!
//! The paper has `kappa = 1`. With time in units of `1/sqrt(kappa)` and displacements in units of
//! `kappa^{1/(alpha-1)}` every chain has (eq:Hertz); the theorem is stated here in the chain's own
//! units.

use crate::{
    chain::{Chain, Layout, Params, Resonators, Site},
    dps::{Center, Homoclinic},
    error::{Error, Result, require},
};
use std::{cell::RefCell, f64::consts::PI, ops::Range};

/// Share of `sum a_n^2` that the core holds.
const CORE_SHARE: f64 = 0.999;
/// Share of `sum |a_n|` that may lie beyond the ends of the chain.
const CUT_OFF: f64 = 1e-6;

/// A bright breather of the DpS equation in the middle of a chain, and the distance of a state of
/// the chain from it.
///
/// ```
/// use hertzchain_orbits::{breathers::BrightBreather, chain::Params, dps::Center};
/// let breather = BrightBreather::new(Params::new(1.5, 1.0, 1000.0)?, Center::Bond, 0.01, 40)?;
/// // Sec. 5: T = 19.4158, T epsilon^{1-alpha} = 194.158, T_b = 6.0862.
/// assert!((breather.horizon() - 194.158).abs() < 5e-4);
/// assert!((breather.period() - 6.0862).abs() < 5e-5);
/// # Ok::<(), hertzchain_orbits::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BrightBreather {
    params: Params,
    epsilon: f64,
    profile: Homoclinic,
    sites: usize,
}

/// Distance of a state from the breather, in the units of the theorem's bounds (diff_u_l1norm),
/// (diff_v_l1norm).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Norms {
    /// `E_u = |u - u~|_1 / (epsilon mu)`; the divisor is `epsilon^alpha` at `kappa = 1`.
    pub u: f64,
    /// `E_u' = |u' - u~'|_1 / (epsilon mu sqrt(kappa))`; the divisor is `epsilon^alpha` at
    /// `kappa = 1`.
    pub u_dot: f64,
    /// `E_v = |v|_1 / (epsilon mu)`; the divisor is `epsilon^alpha` at `kappa = 1`. Zero where
    /// resonators are at rest.
    pub v: f64,
    /// `E_v' = |v'|_1 / (epsilon mu^2 sqrt(kappa))`; the divisor is `epsilon^{2 alpha - 1}` at
    /// `kappa = 1`.
    pub v_dot: f64,
}

impl Norms {
    /// `[E_u, E_u', E_v, E_v']`.
    pub fn all(&self) -> [f64; 4] {
        [self.u, self.u_dot, self.v, self.v_dot]
    }

    /// The larger value of each norm.
    #[must_use]
    pub fn max(&self, other: &Self) -> Self {
        let [u, u_dot, v, v_dot] = std::array::from_fn(|k| self.all()[k].max(other.all()[k]));
        Self { u, u_dot, v, v_dot }
    }
}

/// The profile, kept on each thread until another one is asked for: it takes 128-bit numbers and
/// most of the time of a short run, and is the same at all points of most sweeps.
fn profile(alpha: f64, center: Center) -> Result<Homoclinic> {
    thread_local!(static LAST: RefCell<Option<Homoclinic>> = const { RefCell::new(None) });
    LAST.with_borrow_mut(|last| match last {
        Some(last) if (last.alpha(), last.center()) == (alpha, center) => Ok(last.clone()),
        _ => Ok(last.insert(Homoclinic::new(alpha, center)?).clone()),
    })
}

impl BrightBreather {
    /// The breather `a^1` (about a site) or `a^2` (about a bond) of size `epsilon` in the middle of
    /// `sites` beads.
    ///
    /// Site `n = 0` is bead `(sites - 1) / 2`, rounded down. The state is symmetric about the
    /// middle of the chain for an odd (site) or even (bond) number of sites.
    ///
    /// # Errors
    /// No resonators (`rho = 0` or `kappa = 0`); `epsilon` not finite and positive; `alpha` outside
    /// `[1.01, 10]`; a chain that cuts off more than `10^-6` of `sum |a_n|`; an
    /// `epsilon^{alpha-1} / kappa` whose square overflows or underflows.
    pub fn new(params: Params, center: Center, epsilon: f64, sites: usize) -> Result<Self> {
        params.validate()?;
        if params.resonators() == Resonators::None {
            let (name, value) = if params.rho == 0.0 { ("rho", params.rho) } else { ("kappa", params.kappa) };
            return Err(Error::parameter(name, value, "a bright breather needs resonators: rho > 0 and kappa > 0"));
        }
        let rule = "the size of the breather is finite and positive";
        require(epsilon.is_finite() && epsilon > 0.0, "epsilon", epsilon, rule)?;
        let breather = Self { params, epsilon, profile: profile(params.alpha, center)?, sites };
        let mu = breather.mu();
        let rule = "epsilon^{alpha-1}/kappa and its square are finite and positive numbers";
        require(mu.is_finite() && mu * mu > 0.0, "epsilon", epsilon, rule)?;
        let share = |n: i64| breather.profile.a(n).abs();
        let on_chain = |n: &i64| u64::try_from(n + breather.origin() as i64).is_ok_and(|i| i < sites as u64);
        let held: f64 = breather.profile.sites().filter(on_chain).map(share).sum();
        let whole: f64 = breather.profile.sites().map(share).sum();
        let rule = "the chain holds the breather but for a share of 10^-6";
        require(whole - held <= CUT_OFF * whole, "sites", sites, rule)?;
        Ok(breather)
    }

    /// Exponent, spring constant and mass ratio.
    pub fn params(&self) -> Params {
        self.params
    }

    /// The size `epsilon`.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// The profile `a_n`.
    pub fn profile(&self) -> &Homoclinic {
        &self.profile
    }

    /// Number of beads of the chain.
    pub fn sites(&self) -> usize {
        self.sites
    }

    /// `omega_0` (eq:defom0) at `kappa = 1`.
    pub fn omega_0(&self) -> f64 {
        self.profile.omega_0()
    }

    /// `mu = epsilon^{alpha-1} / kappa`, a pure number.
    pub fn mu(&self) -> f64 {
        self.epsilon.powf(self.params.alpha - 1.0) / self.params.kappa
    }

    /// `Omega_b = sqrt(kappa) (1 + omega_0 mu)`; at `kappa = 1` it is
    /// `1 + omega_0 epsilon^{alpha-1}`.
    pub fn omega_b(&self) -> f64 {
        self.params.kappa.sqrt() * (1.0 + self.omega_0() * self.mu())
    }

    /// `T_b = 2 pi/Omega_b`.
    pub fn period(&self) -> f64 {
        2.0 * PI / self.omega_b()
    }

    /// `T = 2 pi/omega_0` in units of `1/sqrt(kappa)`: the period of the envelope in slow time.
    pub fn slow_period(&self) -> f64 {
        2.0 * PI / self.omega_0() / self.params.kappa.sqrt()
    }

    /// The horizon `T / (mu sqrt(kappa))`: the theorem bounds the norms up to this time. At
    /// `kappa = 1` it is `T epsilon^{1-alpha}`.
    pub fn horizon(&self) -> f64 {
        self.slow_period() / self.mu()
    }

    /// `1/(rho mu^2)`, which the theorem bounds by its constant `C_r`; at `kappa = 1` it is
    /// `rho^{-1} epsilon^{-2(alpha-1)}`.
    pub fn mass_condition(&self) -> f64 {
        (self.params.rho * self.mu().powi(2)).recip()
    }

    /// The bead of `n = 0`.
    pub fn origin(&self) -> usize {
        self.sites.saturating_sub(1) / 2
    }

    /// `a_n` of bead `i`.
    pub fn a(&self, i: usize) -> f64 {
        // The sum turns -0 outside the profile to 0.
        self.profile.a(i as i64 - self.origin() as i64) + 0.0
    }

    /// Bead `i` at time `t` by (time-periodic_osc); at `t = 0` it is the initial state (ini_num).
    ///
    /// `u~ = 2 epsilon a cos(Omega_b t)`, `u~' = -2 epsilon sqrt(kappa) a sin(Omega_b t)`,
    /// `v~ = v~' = 0`.
    pub fn site(&self, i: usize, t: f64) -> Site<f64> {
        let (sin, cos) = (self.omega_b() * t).sin_cos();
        let u = 2.0 * self.epsilon * self.a(i);
        Site { u: u * cos, v: 0.0, u_dot: -self.params.kappa.sqrt() * u * sin, v_dot: 0.0 }
    }

    /// Distance of the state `y` from the breather at time `t` (diff_u_l1norm), (diff_v_l1norm).
    ///
    /// # Panics
    /// If `layout` has another number of sites than the breather, or `y` another length.
    pub fn norms(&self, t: f64, layout: Layout, y: &[f64]) -> Norms {
        assert_eq!((layout.sites(), layout.dim()), (self.sites, y.len()), "a state of the breather's chain");
        let (mu, rate) = (self.mu(), self.params.kappa.sqrt());
        let distance = |values: &[f64], of: fn(Site<f64>) -> f64| -> f64 {
            values.iter().enumerate().map(|(i, value)| (value - of(self.site(i, t))).abs()).sum::<f64>() / self.epsilon
        };
        Norms {
            u: distance(layout.u(y), |site| site.u) / mu,
            u_dot: distance(layout.u_dot(y), |site| site.u_dot) / (mu * rate),
            v: layout.v(y).map_or(0.0, |v| distance(v, |site| site.v) / mu),
            v_dot: layout.v_dot(y).map_or(0.0, |v_dot| distance(v_dot, |site| site.v_dot) / (mu * mu * rate)),
        }
    }

    /// The core: the fewest beads, symmetric about the centre, that hold at least 0.999 of
    /// `sum a_n^2`.
    pub fn core(&self) -> Range<usize> {
        let energy = |n: i64| self.profile.a(n).powi(2);
        let whole: f64 = self.profile.sites().map(energy).sum();
        let last = i64::from(self.profile.center() == Center::Bond);
        let held = |m: i64| (-m..=m + last).map(energy).sum::<f64>();
        let m = (0..self.sites as i64).find(|&m| held(m) >= CORE_SHARE * whole).unwrap_or(0);
        let origin = self.origin();
        origin.saturating_sub(m as usize)..(origin + (m + last) as usize + 1).min(self.sites)
    }

    /// The share of the energy that is in the [`core`](Self::core). The energy of a contact is
    /// divided equally between its two beads ([`Chain::site_energies`]).
    pub fn core_share(&self, chain: &Chain<f64>, y: &[f64]) -> f64 {
        let energies = chain.site_energies(y);
        energies[self.core()].iter().sum::<f64>() / energies.iter().sum::<f64>()
    }
}
