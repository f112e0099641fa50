//! Standing waves of the generalised DpS equations with a kink: the profiles of dark breathers
//! (Sec. 6).
//!
//! | symbol | meaning |
//! |---|---|
//! | `a_n, b_n` | `delta^- a_n, delta^- b_n` of (eq:ab_sw) at `mu = 1`, without the tilde |
//! | `c` | mean strain of the background, `b_{-N} = c` |
//! | `C` | mean force `g_alpha(b_n, abs(a_n))`, the same in every bond |
//! | `p_n` | `(-1)^n a_n > 0` on the half chain `n = 1, .., K` ahead of the kink |
//! | `G_n` | `h_alpha(b_n, p_n) p_n`, first harmonic of the force |
//! | `mu` | `2 omega^3 (omega_b - omega)`; the paper's `mu-bar` has the factor `2 kappa omega^3` |
//!
//! Neighbours are in antiphase, with one phase slip at the kink. So the stationary equations
//! (eq:DpSsw2) are equations between positive numbers,
//!
//! ```text
//! p_n = G_{n-1} + 2 G_n + G_{n+1},    g_alpha(b_n, p_n) = C,    b_K = c,
//! ```
//!
//! and symmetry closes them: `G_0 = 0`, `G_{K+1} = G_K`, `K = N` for a kink on a site;
//! `G_0 = -G_1`, `G_{K+1} = G_{K-1}`, `K = N + 1` for a kink on a bond, where site `N + 1` is the
//! site `-N` of the ring of `2N + 1` sites. A kink reverses the alternating signs, and so does one
//! turn round an odd ring. On an even ring there must be a second kink, and the background between
//! the two kinks is a different one.
//!
//! The unknowns of Newton's method are all `p_n` and `b_n`. The `b_n` are eliminated by
//! `delta G = phi delta p + w (delta C - e)` with `w = G_b / g_b`, `phi = G_p - w g_p > 0` and
//! `e = g - C`. The remaining matrix has three diagonals, `1/phi_n - 2` and `-1`. In the background
//! `1/phi > 4`, since at constant force `G` is concave in `p` and has the chord `h = 1/4`; the
//! elimination therefore starts in the background.

use super::{Averages, Center, Values};
use crate::{
    chain::{Params, Resonators},
    error::{Error, Result, require},
    numerics::least_above,
};

/// Range of exponents. The size of a profile is a power `1/(alpha-1)`; the tables of
/// [`Averages`] end at 10.
const ALPHAS: std::ops::RangeInclusive<f64> = 1.01..=10.0;
const MOST_SITES: usize = 100_001;
/// Largest number of steps of Newton's method.
const MOST: usize = 50;
/// Bound on the last step, relative to the background; the square of it is below rounding.
const ENOUGH: f64 = 1e-12;
/// Bound on the residual after the last step. A residual is a few roundings, and more for `alpha`
/// near one, where profiles are large powers.
const SETTLED: f64 = 1e-11;

/// A dark profile on a ring: real `a_n` and `b_n` with one kink (eq:DpSsw2), `mu = 1`.
///
/// ```
/// use hertzchain_core::{chain::Params, dps::{Center, DarkProfile}};
/// let profile = DarkProfile::new(Params::new(1.5, 1.0, 1.0 / 3.0)?, Center::Site, 41, 0.0)?;
/// // The amplitude of the background at c = 0 is (4 h_alpha(0, 1))^{-1/(alpha-1)}.
/// assert!((profile.a(-20).abs() - 0.149_201_081_120_233_7).abs() < 1e-12);
/// assert_eq!(profile.a(0), 0.0);
/// assert!(profile.residual() < 1e-13);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DarkProfile {
    params: Params,
    center: Center,
    sites: usize,
    c: f64,
    background: f64,
    /// `p_n` and `b_n` of the half chain.
    p: Vec<f64>,
    b: Vec<f64>,
    /// `b_0` if the kink is on a site.
    middle: f64,
    newton: Vec<f64>,
}

impl DarkProfile {
    /// The profile on a ring of `sites = 2N + 1` sites `-N, .., N`, with mean strain `c` in the
    /// background.
    ///
    /// The kink is on the site 0 or on the bond between the sites 0 and 1. Newton's method starts
    /// from `a_n = (-1)^n a tanh(n - n_0)` (eq:an_ini), where `a` is the amplitude of the
    /// background.
    ///
    /// # Errors
    /// `alpha` outside `[1.01, 10]`; no moving resonators; an even number of sites, or one outside
    /// `3 ..= 100001`; `c` not finite, or so far below zero that there is no background; a Newton
    /// iteration that does not converge to a profile with one kink.
    pub fn new(params: Params, center: Center, sites: usize, c: f64) -> Result<Self> {
        Self::from_guess(params, center, sites, c, None)
    }

    /// The same profile from an initial guess of the given amplitude; without one, the amplitude of
    /// the background (eq:an_ini).
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_guess(params: Params, center: Center, sites: usize, c: f64, amplitude: Option<f64>) -> Result<Self> {
        params.validate()?;
        if !ALPHAS.contains(&params.alpha) {
            return Err(Error::parameter(
                "alpha",
                params.alpha,
                "dark profiles are computed for alpha from 1.01 to 10",
            ));
        }
        let rule = "dark profiles need resonators: 0 < rho < inf, kappa > 0";
        require(params.resonators() == Resonators::Moving, "rho", params.rho, rule)?;
        require((3..=MOST_SITES).contains(&sites), "sites", sites, "a ring for a kink has 3 to 100001 sites")?;
        let rule = "a ring with one kink has an odd number of sites: round an even one the alternating signs need a second kink, and the background between two is another one";
        require(!sites.is_multiple_of(2), "sites", sites, rule)?;
        let averages = Averages::new(params.alpha, params.kappa)?;
        let background = background(&averages, c)?;
        let mut half = Half::start(&averages, center, sites, c, background, amplitude.unwrap_or(background));
        let newton = half.settle()?;
        let middle = averages.mean_strain(half.force, 0.0);
        let Half { p, b, .. } = half;
        Ok(Self { params, center, sites, c, background, p, b, middle, newton })
    }

    /// Exponent, spring constant and mass ratio of the chain.
    pub fn params(&self) -> Params {
        self.params
    }

    /// Position of the kink: on a site or on a bond.
    pub fn center(&self) -> Center {
        self.center
    }

    /// The mean strain of the background, `b_{-N}`.
    pub fn c(&self) -> f64 {
        self.c
    }

    /// The sites, `-N ..= N`.
    pub fn sites(&self) -> std::ops::RangeInclusive<i64> {
        let most = (self.sites / 2) as i64;
        -most..=most
    }

    /// The index in the half chain that holds site `n` or its mirror image, and whether `n` is the
    /// image; `None` on the kink.
    fn place(&self, n: i64) -> Option<(usize, bool)> {
        let (length, most) = (self.sites as i64, (self.sites / 2) as i64);
        let n = n.rem_euclid(length);
        let n = if n > most { n - length } else { n };
        match self.center {
            Center::Site if n == 0 => None,
            Center::Site => Some((n.unsigned_abs() as usize - 1, n < 0)),
            Center::Bond if n > 0 => Some((n as usize - 1, false)),
            Center::Bond => Some((n.unsigned_abs() as usize, true)),
        }
    }

    /// `delta^- a_n` at `mu = 1`; periodic in `n`. Odd about a site; `a_{1-n} = a_n` about a bond.
    pub fn a(&self, n: i64) -> f64 {
        let Some((k, image)) = self.place(n) else { return 0.0 };
        // The sign (-1)^n of the site n = k + 1 that the half chain holds.
        let a = if k % 2 == 0 { -self.p[k] } else { self.p[k] };
        if image && self.center == Center::Site { -a } else { a }
    }

    /// `delta^- b_n` at `mu = 1`; periodic in `n`, even about a site, `b_{1-n} = b_n` about a bond.
    pub fn b(&self, n: i64) -> f64 {
        self.place(n).map_or(self.middle, |(k, _)| self.b[k])
    }

    /// Amplitude `a` and mean strain `b = c` far from a kink.
    ///
    /// They solve `4 h_alpha(c, a) = 1`; at `c = 0` by the closed form of `h_alpha(0, 1)`.
    pub fn background(&self) -> (f64, f64) {
        (self.background, self.c)
    }

    /// The residual before each step of Newton's method and after the last; see
    /// [`residual`](Self::residual).
    pub fn newton(&self) -> &[f64] {
        &self.newton
    }

    /// The largest residual of (eq:DpSsw2).
    ///
    /// The first equation is taken relative to the amplitude of the background, the second relative
    /// to the mean force.
    pub fn residual(&self) -> f64 {
        self.newton.last().copied().unwrap_or(f64::NAN)
    }

    /// `mu = 2 omega^3 (omega_b - omega)`: the breather of frequency `omega_b` is the profile times
    /// `mu^{1/(alpha-1)}`.
    ///
    /// # Errors
    /// `omega_b` not finite or not above `omega`: `mu sum a_n^2 = sum h_alpha (delta^- a_n)^2` over
    /// a ring, so `mu` is positive.
    pub fn mu(&self, omega_b: f64) -> Result<f64> {
        let omega = self.params.omega();
        let rule = "a dark breather is faster than the linear oscillation: omega_b > omega = sqrt(kappa (1 + 1/rho))";
        require(omega_b.is_finite() && omega_b > omega, "omega_b", omega_b, rule)?;
        Ok(2.0 * omega.powi(3) * (omega_b - omega))
    }

    /// The strains `(x, y)` of the breather of frequency `omega_b` at rest, to first order
    /// (eq:xy_sw), on the sites `-N, .., N`:
    ///
    /// ```text
    /// x_n(0) = mu^{1/(alpha-1)} (b_n + 2 kappa a_n)
    /// y_n(0) = mu^{1/(alpha-1)} (b_n - 2 kappa/rho a_n)
    /// ```
    ///
    /// The velocities are zero. The error relative to the strains is of the order
    /// `(omega_b - omega) / omega`, with a large factor.
    ///
    /// # Errors
    /// As [`mu`](Self::mu); strains that a double cannot hold.
    pub fn seed(&self, omega_b: f64) -> Result<(Vec<f64>, Vec<f64>)> {
        let Params { alpha, kappa, rho } = self.params;
        let scale = self.mu(omega_b)?.powf((alpha - 1.0).recip());
        let strain = |n: i64, swing: f64| scale * (self.b(n) + 2.0 * kappa * swing * self.a(n));
        let strains: (Vec<f64>, Vec<f64>) = self.sites().map(|n| (strain(n, 1.0), strain(n, -rho.recip()))).unzip();
        let rule = "so near omega that its strains, which grow with mu^{1/(alpha-1)}, are finite";
        require(strains.0.iter().chain(&strains.1).all(|x| x.is_finite()), "omega_b", omega_b, rule)?;
        Ok(strains)
    }
}

/// The amplitude with `4 h_alpha(c, a) = 1` (neighbours in antiphase); the larger one where there
/// are two.
///
/// For `c < 0` and `alpha < 2`, `h_alpha(c, a)` decreases in `a` while the contact does not open
/// and increases later. The smaller amplitude then belongs to a nearly linear chain of contacts
/// that stay closed.
fn background(averages: &Averages, c: f64) -> Result<f64> {
    require(c.is_finite(), "c", c, "the mean strain of the background is finite")?;
    let (alpha, kappa) = (averages.alpha(), averages.kappa());
    let unstrained = (4.0 * averages.h(0.0, 1.0)).powf((1.0 - alpha).recip());
    if !unstrained.is_normal() {
        return Err(Error::parameter(
            "kappa",
            kappa,
            "the amplitude (4 h_alpha(0, 1))^{-1/(alpha-1)} is a normal number",
        ));
    }
    if c == 0.0 {
        return Ok(unstrained);
    }
    // The amplitude at which the contact begins to close (c > 0) or to open (c < 0).
    let edge = c.abs() / (2.0 * kappa);
    let least = if c > 0.0 {
        edge
    } else if averages.values(c, edge).dh_dr < 0.0 {
        least_above(edge, |r| averages.values(c, r).dh_dr > 0.0).unwrap_or(f64::INFINITY)
    } else {
        0.0
    };
    if averages.h(c, least) >= 0.25 {
        let rule = "the background has 4 h_alpha(c, a) = 1 for some amplitude a: c is less far below zero";
        return Err(Error::parameter("c", c, rule));
    }
    Ok(least_above(least.max(f64::EPSILON * unstrained), |r| averages.h(c, r) > 0.25).unwrap_or(f64::INFINITY))
}

/// State of Newton's method on the half chain.
struct Half<'a> {
    averages: &'a Averages,
    center: Center,
    sites: usize,
    c: f64,
    /// Amplitude of the background; residuals and steps are relative to it.
    size: f64,
    p: Vec<f64>,
    b: Vec<f64>,
    /// `C = g_alpha(c, p_K)`.
    force: f64,
}

impl<'a> Half<'a> {
    /// The guess (eq:an_ini) with an amplitude, and its `b_n`.
    fn start(averages: &'a Averages, center: Center, sites: usize, c: f64, size: f64, amplitude: f64) -> Self {
        let (count, n_0) = match center {
            Center::Site => (sites / 2, 0.0),
            Center::Bond => (sites / 2 + 1, 0.5),
        };
        let p: Vec<f64> = (1..=count).map(|n| amplitude * (n as f64 - n_0).tanh()).collect();
        let force = averages.g(c, p[count - 1]);
        let mut b: Vec<f64> = p.iter().map(|&p| averages.mean_strain(force, p)).collect();
        b[count - 1] = c;
        Self { averages, center, sites, c, size, p, b, force }
    }

    /// Runs Newton's method; returns the residual before each step and after the last.
    fn settle(&mut self) -> Result<Vec<f64>> {
        let (mut residuals, mut change) = (Vec::new(), f64::INFINITY);
        for _ in 0..=MOST {
            let bonds: Vec<Values> = self.p.iter().zip(&self.b).map(|(&p, &b)| self.averages.values(b, p)).collect();
            let defects = self.defects(&bonds);
            let residual = self.residual(&bonds, &defects);
            residuals.push(residual);
            if change <= ENOUGH && residual <= SETTLED {
                return Ok(residuals);
            }
            change = self.step(&bonds, &defects);
            if !self.p.iter().all(|p| *p > 0.0) {
                break;
            }
        }
        let rule = "Newton's method settles on one kink: on a longer ring, or with a c not so near its least";
        Err(Error::parameter("sites, c", format!("{}, {:e}", self.sites, self.c), rule))
    }

    /// `p_n - (G_{n-1} + 2 G_n + G_{n+1})`.
    fn defects(&self, bonds: &[Values]) -> Vec<f64> {
        let g: Vec<f64> = bonds.iter().zip(&self.p).map(|(bond, p)| bond.h * p).collect();
        let last = g.len() - 1;
        let (before, after) = match self.center {
            Center::Site => (0.0, g[last]),
            Center::Bond => (-g[0], g[last - 1]),
        };
        let at = |k: usize| {
            let (left, right) = (if k == 0 { before } else { g[k - 1] }, if k == last { after } else { g[k + 1] });
            self.p[k] - (left + 2.0 * g[k] + right)
        };
        (0..=last).map(at).collect()
    }

    fn residual(&self, bonds: &[Values], defects: &[f64]) -> f64 {
        let first = defects.iter().map(|defect| (defect / self.size).abs());
        let second = bonds.iter().map(|bond| (bond.g / self.force - 1.0).abs());
        first.chain(second).fold(0.0, f64::max)
    }

    /// Takes a step; returns the largest change of a `p_n` relative to the background.
    fn step(&mut self, bonds: &[Values], defects: &[f64]) -> f64 {
        let last = self.p.len() - 1;
        let w: Vec<f64> = bonds.iter().map(|bond| bond.drh_db / bond.dg_db).collect();
        let phi: Vec<f64> = bonds.iter().zip(&w).map(|(bond, w)| bond.drh_dr - w * bond.dg_dr).collect();
        let excess: Vec<f64> = bonds.iter().map(|bond| bond.g - self.force).collect();
        // delta G = delta_g[0] + delta C delta_g[1].
        let sides = (0..=last).map(|k| [-defects[k] - w[k] / phi[k] * excess[k], w[k] / phi[k]]).collect();
        let delta_g = self.eliminate(&phi, sides);
        let delta_p =
            |k: usize, force: f64| (delta_g[k][0] + force * delta_g[k][1] - w[k] * (force - excess[k])) / phi[k];
        // b_K stays c, hence delta C = g_p delta p_K, and delta p_K is linear in delta C.
        let (constant, slope) = (delta_p(last, 0.0), delta_p(last, 1.0) - delta_p(last, 0.0));
        let force = bonds[last].dg_dr * constant / (1.0 - bonds[last].dg_dr * slope);
        let mut change = 0.0f64;
        for k in 0..=last {
            let dp = delta_p(k, force);
            self.p[k] += dp;
            self.b[k] += (force - excess[k] - bonds[k].dg_dr * dp) / bonds[k].dg_db;
            change = change.max((dp / self.size).abs());
        }
        self.b[last] = self.c;
        self.force = self.averages.g(self.c, self.p[last]);
        change
    }

    /// Solves the system of three diagonals for two right sides, eliminating from the background to
    /// the kink.
    fn eliminate(&self, phi: &[f64], mut sides: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        let last = phi.len() - 1;
        let mut pivots: Vec<f64> = phi.iter().map(|phi| phi.recip() - 2.0).collect();
        // The symmetries change the last diagonal entry or the entry beside it, and the first
        // diagonal entry.
        let lower = |k: usize| if k == last && self.center == Center::Bond { -2.0 } else { -1.0 };
        match self.center {
            Center::Site => pivots[last] -= 1.0,
            Center::Bond => pivots[0] += 1.0,
        }
        for k in (0..last).rev() {
            let factor = -1.0 / pivots[k + 1];
            pivots[k] -= factor * lower(k + 1);
            sides[k] = [0, 1].map(|j| sides[k][j] - factor * sides[k + 1][j]);
        }
        for k in 0..=last {
            let before = if k == 0 { [0.0; 2] } else { sides[k - 1] };
            sides[k] = [0, 1].map(|j| (sides[k][j] - if k == 0 { 0.0 } else { lower(k) } * before[j]) / pivots[k]);
        }
        sides
    }
}
