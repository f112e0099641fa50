//! The tail of a moving dark breather: which linear waves of its background can be in it, and
//! which one is.
//!
//! | symbol | meaning |
//! |---|---|
//! | `x_n = X(pi n - omega_b t)` | background: an exact wave with `q = pi` |
//! | `p, Omega` | wave number and frequency of `w_n = e^{i (p n + Omega t)} W(pi n - omega_b t)` |
//! | `T_m` | time in which the kink moves on by a site: `k + 1/2` periods of the background |
//! | `c, delta` | local amplitude and twist of the background on the ring |
//!
//! # Resonance
//!
//! A wave of the background keeps its phase in the frame of the kink if `w_{n+1}(t + T_m) =
//! w_n(t)`. Since `omega_b T_m` is an odd multiple of `pi`, `W` has the same argument on both
//! sides, and the condition is `p + Omega T_m = 2 pi j`. Frequencies come from the relative
//! multipliers of the exact wave. Each wave number has two bands: acoustic waves, in which
//! resonators follow their beads, and modulations of the background, up to `omega_b - omega` at `p
//! = pi`. With `Omega(2 pi - p) = Omega(p)` the condition for modulations is `p = Omega T_m`, for
//! `p` up to `2 pi`: a phase velocity `Omega/p` that is the velocity of the kink.
//!
//! # The tail
//!
//! In the half of the ring that is far from the kink the local amplitudes are fitted by
//!
//! `(-1)^n a_n = e^{i delta s} (c + A cos(p s) + i B sin(p s))`,
//!
//! where `s` counts sites from the one opposite to the kink; the parts with the other parity vanish
//! by the symmetry of the orbit. Waves of which the half holds less than two wavelengths are left
//! out, since they cannot be told from a twist.

use super::{Envelope, energy::background};
use crate::{
    chain::Params,
    error::Result,
    numerics::{largest_by, least_by},
    waves::{Given, Search},
};
use nalgebra::Complex;
use std::f64::consts::PI;

/// Wave numbers `2 pi j/SITES` at which frequencies are computed.
const SITES: usize = 256;
/// Grids of the fit, in radians per site: step of twists, step of wave numbers, and largest twist.
const TWIST: f64 = 1e-3;
const WAVE: f64 = 2e-3;
const MOST_TWIST: f64 = 0.4;
/// Rounds in which wave number and twist are improved in turn, and golden sections in each.
const ROUNDS: usize = 4;
const SECTIONS: usize = 30;

/// A band of linear waves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Band {
    /// Beads and resonators move together.
    Acoustic,
    /// The background is modulated.
    Modulation,
}

/// A linear wave of the background that keeps its phase in the frame of a kink.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LinearWave {
    /// `p`, above 0 and at most `pi`.
    pub wave_number: f64,
    /// `Omega`.
    pub frequency: f64,
    /// Its band.
    pub band: Band,
}

/// The linear waves of a background.
#[derive(Clone, Debug)]
pub struct LinearWaves {
    /// `p`, and the four frequencies there from the lowest to the highest.
    bands: Vec<(f64, [f64; 4])>,
}

impl LinearWaves {
    /// The linear waves of the background with the frequency `omega_b`.
    ///
    /// # Errors
    /// As [`Search::wave`] and [`ExactWave::spectrum`](crate::waves::ExactWave::spectrum).
    pub fn new(params: Params, omega_b: f64) -> Result<Self> {
        let search = Search::default();
        let (wave, _) = search.wave(&background(params, omega_b)?, Given::Frequency)?;
        let multipliers = wave.spectrum(SITES, &search)?.multipliers;
        let at = |j: usize| {
            let p = 2.0 * PI * j as f64 / SITES as f64;
            let here = multipliers.iter().filter(|one| (one.bloch - p).abs() < 1e-6);
            let mut frequencies: Vec<f64> = here.map(|one| one.frequency).collect();
            frequencies.sort_by(f64::total_cmp);
            // Where a frequency is near omega_b/2, one of the four is labelled with another wave
            // number; such wave numbers are left out.
            frequencies.try_into().ok().map(|four: [f64; 4]| (p, four))
        };
        Ok(Self { bands: (1..=SITES / 2).filter_map(at).collect() })
    }

    /// The waves that keep their phase in the frame of a kink that moves on by a site in the time
    /// `passage`, in order of wave number. Frequencies are interpolated linearly between the wave
    /// numbers of the grid.
    pub fn resonant(&self, passage: f64) -> Vec<LinearWave> {
        let mut found = Vec::new();
        for pair in self.bands.windows(2).filter(|pair| pair[1].0 - pair[0].0 < 3.0 * PI / SITES as f64) {
            let [(p, from), (q, to)] = [pair[0], pair[1]];
            for (k, (low, high)) in from.into_iter().zip(to).enumerate() {
                let [a, b] = [p + low * passage, q + high * passage].map(|phase| phase / (2.0 * PI));
                let band = if k == 0 || k == 3 { Band::Acoustic } else { Band::Modulation };
                for j in a.min(b).ceil() as i64..=a.max(b).floor() as i64 {
                    let share = if a == b { 0.0 } else { (j as f64 - a) / (b - a) };
                    let [wave_number, frequency] = [p + share * (q - p), low + share * (high - low)];
                    found.push(LinearWave { wave_number, frequency, band });
                }
            }
        }
        found.sort_by(|a, b| a.wave_number.total_cmp(&b.wave_number));
        found
    }
}

/// The wave in the tail of an envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tail {
    /// `delta`, radians per site.
    pub twist: f64,
    /// `p` of the best fit.
    pub wave_number: f64,
    /// `A/c`.
    pub amplitude: f64,
    /// Share of the sum of squares of the tail, about its mean, that the fit explains.
    pub share: f64,
}

/// Local amplitudes of the half of the ring that is far from the kink: `s`, and `(-1)^n a_n`.
struct Far(Vec<(f64, Complex<f64>)>);

/// The least-squares fit of a tail by a wave of one wave number.
#[derive(Clone, Copy)]
struct Fit {
    /// `A`.
    amplitude: f64,
    /// Correction of the twist, radians per site.
    slope: f64,
    /// Sum of squares of the residual.
    left: f64,
}

impl Far {
    fn new(envelope: &Envelope) -> Self {
        let n = envelope.amplitude.len();
        let reach = (n / 4) as i64;
        // The sign of (-1)^n jumps where the odd ring closes, at site 0.
        let local = |s: i64| {
            let i = s.rem_euclid(n as i64) as usize;
            let sign = if s < 0 { -1.0 } else { 1.0 };
            Complex::from_polar(sign * envelope.amplitude[i], envelope.phase[i])
        };
        Self((-reach..=reach).map(|s| (s as f64, local(s))).collect())
    }

    /// The amplitudes with a twist removed, and rotated together so that their mean is positive.
    fn turned(&self, twist: f64) -> Vec<(f64, Complex<f64>)> {
        let turned = self.0.iter().map(|(s, a)| (*s, a * Complex::from_polar(1.0, -twist * s)));
        let turned: Vec<_> = turned.collect();
        let sum: Complex<f64> = turned.iter().map(|(_, a)| a).sum();
        turned.into_iter().map(|(s, a)| (s, a * sum.conj() / sum.norm())).collect()
    }

    /// The twist on the grid whose removal makes the modulus of the sum of amplitudes largest.
    fn twist(&self) -> f64 {
        let steps = (MOST_TWIST / TWIST) as i32;
        let sum = |twist: f64| self.turned(twist).iter().map(|(_, a)| a).sum::<Complex<f64>>().norm();
        let twists = (-steps..=steps).map(|k| f64::from(k) * TWIST);
        largest_by(twists, |twist| sum(*twist)).unwrap_or(0.0)
    }
}

impl Envelope {
    /// The twist, and the wave of one wave number, that fit the tail best.
    pub fn tail_wave(&self) -> Tail {
        let far = Far::new(self);
        let mut twist = far.twist();
        let turned = far.turned(twist);
        let waves = (1..).map(|k| f64::from(k) * WAVE).skip_while(|p| p * turned.len() as f64 <= 4.0 * PI);
        let fits = waves.take_while(|p| *p < PI).map(|p| (p, fit(&turned, p).left));
        let mut wave_number = least_by(fits, |fit| fit.1).map_or(f64::NAN, |(p, _)| p);
        for _ in 0..ROUNDS {
            let turned = far.turned(twist);
            wave_number = least(wave_number, WAVE, |p| fit(&turned, p).left);
            twist += fit(&turned, wave_number).slope;
        }
        let turned = far.turned(twist);
        let mean = turned.iter().map(|(_, a)| a.re).sum::<f64>() / turned.len() as f64;
        let whole: f64 = turned.iter().map(|(_, a)| (a - mean).norm_sqr()).sum();
        let Fit { amplitude, left, .. } = fit(&turned, wave_number);
        Tail { twist, wave_number, amplitude: amplitude / mean, share: 1.0 - left / whole }
    }
}

/// The minimum point of a function within `2 reach` of `x`, by golden sections.
fn least(x: f64, reach: f64, of: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (x - 2.0 * reach, x + 2.0 * reach);
    for _ in 0..SECTIONS {
        let [a, b] = [high - golden * (high - low), low + golden * (high - low)];
        if of(a) < of(b) {
            high = b;
        } else {
            low = a;
        }
    }
    0.5 * (low + high)
}

/// The least-squares fit by `c (1 + i slope s) + A cos(p s) + i B sin(p s)`.
fn fit(far: &[(f64, Complex<f64>)], p: f64) -> Fit {
    let sum = |of: &dyn Fn(f64, Complex<f64>) -> f64| far.iter().map(|(s, a)| of(*s, *a)).sum::<f64>();
    let count = far.len() as f64;
    let [cos, mean] = [sum(&|s, _| (p * s).cos()) / count, sum(&|_, a| a.re) / count];
    let spread = sum(&|s, _| ((p * s).cos() - cos).powi(2));
    let amplitude = sum(&|s, a| ((p * s).cos() - cos) * a.re) / spread;
    // The imaginary part: rows s and sin(p s).
    let [ss, sw, ww] = [sum(&|s, _| s * s), sum(&|s, _| s * (p * s).sin()), sum(&|s, _| (p * s).sin().powi(2))];
    let [sa, wa] = [sum(&|s, a| s * a.im), sum(&|s, a| (p * s).sin() * a.im)];
    let determinant = ss * ww - sw * sw;
    let [slope, odd] = [(sa * ww - wa * sw) / determinant, (wa * ss - sa * sw) / determinant];
    let left = sum(&|s, a| {
        let re = a.re - mean - amplitude * ((p * s).cos() - cos);
        let im = a.im - slope * s - odd * (p * s).sin();
        re * re + im * im
    });
    Fit { amplitude, slope: slope / mean, left }
}
