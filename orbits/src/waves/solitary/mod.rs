//! Solitary waves: the Hertz pulse of the plain chain, and its tails where resonators move.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g_n = -x_n` | overlap; the pulse has its crest `g` at site 0, `t = 0` |
//! | `c` | speed, sites per unit of time |
//! | `G, C` | pulse of unit speed on the line; `c = C g^{(alpha-1)/2}` ([`LinePulse`]) |
//! | `N` | sites of the ring: the pulse is back after the time `N/c` |
//! | `D_n = x_n - y_n` | strain of beads against that of resonators |
//! | `k = omega/c` | phase of a resonator from site to site of a pulse |
//! | `W` | amplitude of `D` that one passage of the pulse leaves behind |
//!
//! On a ring a solitary wave is an exact wave ([`ExactWave`]) with `q = 2 pi/N`, `omega_tw = 2 pi
//! c/N`, no strain at the far side, and `x_{n+1}(t + 1/c) = x_n(t)`.
//!
//! # Tails
//!
//! `D'' + omega^2 D = f`, where `f` is the second difference of the contact forces. If `f` repeats
//! after every `P = N/c`, and is zero between the pulses, the amplitude of `D` between them is
//!
//! `delta = W/(2 |sin(omega P/2)|)`, `W = |int f e^{i omega t} dt|/omega`.
//!
//! So the tails of the ring depend on its length, and `W = 2 |sin(omega P/2)| delta` does not. For
//! a pulse whose resonators follow their beads, mass `1 + rho` and the overlap `g(xi)`, `W = (1 +
//! rho) k |int g e^{i k xi} d xi|` by its equation `(1 + rho) c^2 g'' = D(g^alpha)`. Its factor
//! `sin^2(k/2)` vanishes at `k = 2 pi j`, whatever the shape: there are pulses without tails
//! (Kevrekidis, Stefanov and Xu 2016, "anti-resonances").

mod line;

pub use line::LinePulse;

use super::{ExactWave, Given, MeanStrain, Search, WaveNumber, WaveSetting};
use crate::{
    chain::{Params, Resonators},
    error::{Result, positive, require},
    numerics::largest_by,
};
use std::f64::consts::PI;

/// Exponents of pulses. Nearer to 1 a pulse is wider than the line of [`LinePulse`].
const EXPONENTS: std::ops::RangeInclusive<f64> = 1.2..=5.0;
/// Least `|sin(omega P/2)|` of a ring: nearer to resonance its wave is not unique, up to rounding.
const OFF_RESONANCE: f64 = 1e-4;
/// Sites of a ring of solitary waves.
const SITES: std::ops::RangeInclusive<usize> = 8..=64;

/// A solitary wave on a ring; where resonators radiate, the exact wave with tails in its place.
///
/// ```
/// use hertzchain_orbits::{chain::Params, waves::{LinePulse, Search, SolitaryWave}};
/// let hertz = Params { alpha: 1.5, kappa: 0.0, rho: 0.0 };
/// let line = LinePulse::new(1.5);
/// let one = SolitaryWave::new(hertz, 1.0, 12, &line, &Search::default())?;
/// assert!((one.coefficient() / line.coefficient() - 1.0).abs() < 1e-8);
/// # Ok::<(), hertzchain_orbits::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SolitaryWave {
    /// The wave of the ring.
    pub wave: ExactWave,
    /// Speed `c`, in sites per unit of time.
    pub speed: f64,
}

/// `(1 + rho)^{1/2} c` to the power `2/(alpha - 1)`: the size of a pulse whose resonators, if they
/// move, follow their beads.
fn size(params: Params, speed: f64) -> f64 {
    (mass(params) * speed * speed).powf((params.alpha - 1.0).recip())
}

/// Mass of a bead with its resonator.
fn mass(params: Params) -> f64 {
    if params.resonators() == Resonators::Moving { 1.0 + params.rho } else { 1.0 }
}

impl SolitaryWave {
    /// The wave of this speed, from the pulse of the line.
    ///
    /// # Errors
    /// Fixed resonators, with which a pulse spreads; an exponent that is not from 1.2 to 5; a speed
    /// that is not finite and positive; fewer than 8 or more than 64 sites; a ring in resonance
    /// with the tails; [`Error::Stalled`](crate::Error::Stalled) where Newton's method does not
    /// converge.
    pub fn new(params: Params, speed: f64, sites: usize, line: &LinePulse, search: &Search) -> Result<Self> {
        let setting = ring(params, speed, sites)?;
        let size = size(params, speed);
        let from_crest = |n: usize| if 2 * n > sites { n as f64 - sites as f64 } else { n as f64 };
        let pulse: Vec<[f64; 2]> = (0..sites).map(|n| line.at(from_crest(n))).collect();
        let strains: Vec<f64> = pulse.iter().map(|[g, _]| -size * g).collect();
        let rates: Vec<f64> = pulse.iter().map(|[_, slope]| speed * size * slope).collect();
        let copies = setting.numbers() / (2 * sites);
        let seed = [strains.repeat(copies), rates.repeat(copies)].concat();
        Ok(Self { wave: search.solve(&setting, Given::Frequency, &seed)?, speed })
    }

    /// The largest overlap.
    pub fn crest(&self) -> f64 {
        -self.wave.z[0]
    }

    /// The coefficient `C = c/g^{(alpha-1)/2}`.
    pub fn coefficient(&self) -> f64 {
        self.speed * self.crest().powf(-0.5 * (self.wave.setting.params.alpha - 1.0))
    }

    /// The amplitude `delta` of `D` at the site farthest from the crest; 0 without resonators.
    pub fn tail(&self) -> f64 {
        let WaveSetting { params, q, .. } = self.wave.setting;
        let (m, z) = (q.cell(), &self.wave.z);
        if params.resonators() != Resonators::Moving {
            return 0.0;
        }
        let n = m / 2;
        let (strain, rate) = (z[n] - z[m + n], z[2 * m + n] - z[3 * m + n]);
        strain.hypot(rate / params.omega())
    }

    /// The wake `W`, from the tail of this ring.
    pub fn wake(&self) -> f64 {
        2.0 * ring_phase(self.wave.setting.params, self.speed, self.wave.setting.q.cell()) * self.tail()
    }
}

/// The wake `W` of the pulse whose resonators follow their beads.
pub fn wake_of_line(params: Params, speed: f64, line: &LinePulse) -> f64 {
    let k = params.omega() / speed;
    mass(params) * k * size(params, speed) * line.transform(k).abs()
}

/// `|sin(omega P/2)|`.
fn ring_phase(params: Params, speed: f64, sites: usize) -> f64 {
    (0.5 * params.omega() * sites as f64 / speed).sin().abs()
}

/// Of four lengths from `sites` on, the one whose ring is farthest from resonance with the tails.
pub fn best_ring(params: Params, speed: f64, sites: usize) -> usize {
    largest_by(sites..sites + 4, |&n| ring_phase(params, speed, n)).unwrap_or(sites)
}

fn ring(params: Params, speed: f64, sites: usize) -> Result<WaveSetting> {
    params.validate()?;
    let rule = "resonators at rest pull every bead back, and a pulse spreads: take a finite rho";
    require(params.resonators() != Resonators::Fixed, "rho", params.rho, rule)?;
    require(EXPONENTS.contains(&params.alpha), "alpha", params.alpha, "from 1.2 to 5 for a solitary wave")?;
    positive("speed", speed)?;
    require(SITES.contains(&sites), "sites", sites, "from 8 to 64 for a solitary wave")?;
    let apart = params.resonators() != Resonators::Moving || ring_phase(params, speed, sites) >= OFF_RESONANCE;
    let rule = "a ring that is not in resonance with the tails: omega N/speed is no multiple of 2 pi";
    require(apart, "sites", sites, rule)?;
    let omega_tw = 2.0 * PI * speed / sites as f64;
    let q = WaveNumber::on_ring(2.0 / sites as f64, sites)?;
    Ok(WaveSetting { params, q, omega_tw, mean: MeanStrain::Background(0.0) })
}
