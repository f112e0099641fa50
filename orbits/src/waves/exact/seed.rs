//! Starts of the search for an exact wave: the first-order ansatz (eq:xytw_app), or a wave of one
//! harmonic where there is no ansatz.
//!
//! | symbol | meaning |
//! |---|---|
//! | `A, m` | amplitude and mean strain: `x_n = m + A cos(q n - omega_tw t)` |
//! | `K` | `-4 sin^2(q/2) F_1/A`, where `F_1` is the first harmonic of `(-m - A cos)_+^alpha` |
//!
//! # One harmonic
//!
//! Waves without resonators (`rho = 0`), with fixed ones (`rho = inf`), and those below the gap of
//! frequencies that resonators make, `omega_tw^2 < kappa/rho`, are not near `omega`. The first
//! harmonic of the equations of motion is solved by
//!
//! `omega_tw^2 (1 + kappa rho/(kappa - rho omega_tw^2)) = K`,
//!
//! `omega_tw^2 = K` without resonators, and `omega_tw^2 = kappa + K` with fixed ones. Under a
//! precompression `-m >> A` this is the dispersion relation of the linear chain.

use super::{Given, MeanStrain, WaveSetting};
use crate::{
    chain::{Params, Resonators},
    dps::Averages,
    error::{Error, Result},
    numerics::least_above,
    waves::{Shape, Size, TravellingWave, detuning},
};

/// The approximate wave from which the search for a wave starts.
#[derive(Clone, Copy, Debug)]
pub enum Start {
    /// The ansatz with the wanted mean strain, and the wanted frequency or amplitude.
    Ansatz(TravellingWave),
    /// The wave of one harmonic with the same numbers.
    Harmonic(Harmonic),
}

/// A wave of one harmonic.
#[derive(Clone, Copy, Debug)]
pub struct Harmonic {
    /// `A`.
    pub(super) amplitude: f64,
    pub(super) mean: f64,
    pub(super) omega_tw: f64,
}

impl Start {
    /// The start of a search.
    ///
    /// # Errors
    /// As [`ansatz`]; fixed resonators with a mean strain other than 0; a frequency that no wave of
    /// one harmonic has.
    pub fn new(setting: &WaveSetting, given: Given) -> Result<Self> {
        let Params { kappa, rho, .. } = setting.params;
        let below = given == Given::Frequency && rho * setting.omega_tw.powi(2) < kappa;
        match setting.params.resonators() {
            Resonators::Moving if !below => ansatz(setting, given).map(Self::Ansatz),
            Resonators::Fixed if setting.mean.value() != 0.0 => {
                let rule = "fixed resonators (rho = inf) hold the mean strain of a wave at 0";
                Err(Error::parameter("mean", setting.mean.value(), rule))
            }
            _ => Harmonic::new(setting, given).map(Self::Harmonic),
        }
    }

    pub(super) fn amplitude(self) -> f64 {
        match self {
            Self::Ansatz(wave) => wave.amplitude(),
            Self::Harmonic(harmonic) => harmonic.amplitude,
        }
    }

    /// The ansatz; `None` for a wave of one harmonic.
    pub fn ansatz(self) -> Option<TravellingWave> {
        match self {
            Self::Ansatz(wave) => Some(wave),
            Self::Harmonic(_) => None,
        }
    }
}

impl Harmonic {
    pub(super) fn new(setting: &WaveSetting, given: Given) -> Result<Self> {
        setting.chain(1)?;
        if let MeanStrain::Background(background) = setting.mean {
            return Err(background_rule(background));
        }
        let averages = Averages::new(setting.params.alpha, 0.5)?;
        let stiffness = |amplitude: f64| {
            8.0 * (0.5 * setting.q.q()).sin().powi(2) * averages.h(setting.mean.at(amplitude), amplitude)
        };
        let amplitude = match given {
            Given::Amplitude(amplitude) => amplitude,
            Given::Frequency => amplitude_of(setting, stiffness)?,
        };
        let mean = setting.mean.at(amplitude);
        if !(amplitude.is_finite() && amplitude > 0.0 && mean < amplitude) {
            return Err(amplitude_rule(amplitude));
        }
        let omega_tw = match given {
            Given::Amplitude(_) => frequency(setting.params, stiffness(amplitude)),
            Given::Frequency => setting.omega_tw,
        };
        Ok(Self { amplitude, mean, omega_tw })
    }

    /// The state of a cell at `t = 0`.
    pub(super) fn state(&self, setting: &WaveSetting) -> Vec<f64> {
        let Self { amplitude, mean, omega_tw } = *self;
        let Params { kappa, rho, .. } = setting.params;
        let heights = match setting.params.resonators() {
            Resonators::Moving => vec![1.0, kappa / (kappa - rho * omega_tw.powi(2))],
            _ => vec![1.0],
        };
        let array = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let phases = (0..setting.q.cell()).map(|n| n as f64 * setting.q.q());
            heights
                .iter()
                .flat_map(|&height| phases.clone().map(move |phase| (height, phase)))
                .map(|(h, p)| of(h, p))
                .collect()
        };
        let strains = array(&|height, phase| mean + height * amplitude * phase.cos());
        let rates = array(&|height, phase| height * amplitude * omega_tw * phase.sin());
        [strains, rates].concat()
    }
}

/// The frequency of a wave of one harmonic; the lower one if resonators move.
fn frequency(Params { kappa, rho, .. }: Params, stiffness: f64) -> f64 {
    if rho.is_infinite() {
        return (kappa + stiffness).sqrt();
    }
    // rho w^4 - (rho K + kappa (1 + rho)) w^2 + kappa K = 0, without cancellation.
    if rho == 0.0 || kappa == 0.0 {
        return stiffness.sqrt();
    }
    let half = 0.5 * (rho * stiffness + kappa * (1.0 + rho));
    (kappa * stiffness / (half + (half * half - rho * kappa * stiffness).sqrt())).sqrt()
}

/// The amplitude at which a wave of one harmonic has the frequency of the setting.
fn amplitude_of(setting: &WaveSetting, stiffness: impl Fn(f64) -> f64) -> Result<f64> {
    let WaveSetting { params, omega_tw, mean, .. } = *setting;
    let Params { alpha, kappa, rho } = params;
    let square = omega_tw * omega_tw;
    let wanted = match params.resonators() {
        Resonators::None => square,
        Resonators::Fixed => square - kappa,
        Resonators::Moving => square * (1.0 + kappa * rho / (kappa - rho * square)),
    };
    if wanted <= 0.0 {
        return Err(frequency_rule(omega_tw, params));
    }
    match mean {
        MeanStrain::Value(m) if m != 0.0 => {
            // With a positive mean strain no contact closes below an amplitude of m.
            let first = if m > 0.0 { m } else { -1e-6 * m };
            least_size(first, |amplitude| stiffness(amplitude) > wanted)
                .map_err(|rule| Error::parameter("omega_tw", omega_tw, rule))
        }
        // If the mean strain is zero or a share of the amplitude, K is proportional to A^{alpha-1}.
        _ => Ok((wanted / stiffness(1.0)).powf((alpha - 1.0).recip())),
    }
}

/// The ansatz (eq:xytw_app) with the wave number and the mean strain of the setting, and with its
/// frequency or the given amplitude.
///
/// # Errors
/// A frequency at or below `omega`, where waves of small amplitude are not; an amplitude that is
/// not positive, or at which no contact closes; parameters outside their rules.
pub fn ansatz(setting: &WaveSetting, given: Given) -> Result<TravellingWave> {
    let WaveSetting { params, q, mean, omega_tw } = *setting;
    if let MeanStrain::Background(background) = mean {
        return Err(background_rule(background));
    }
    let wave = |b: f64, size: Size| TravellingWave::new(params, Shape { q: q.q(), a: 1.0, b, phi: 0.0 }, size);
    if let Given::Amplitude(amplitude) = given {
        let share = match mean {
            MeanStrain::OfAmplitude(share) => share,
            given => given.value() / amplitude,
        };
        if !(amplitude.is_finite() && amplitude > 0.0 && share < 1.0) {
            return Err(amplitude_rule(amplitude));
        }
        return wave(2.0 * params.kappa * share, Size::Epsilon(0.5 * amplitude / params.kappa));
    }
    if omega_tw.partial_cmp(&params.omega()) != Some(std::cmp::Ordering::Greater) {
        return Err(frequency_rule(omega_tw, params));
    }
    let size = Size::Detuning(omega_tw - params.omega());
    match mean {
        MeanStrain::OfAmplitude(share) => wave(2.0 * params.kappa * share, size),
        given if given.value() == 0.0 => wave(0.0, size),
        given => {
            let mean = given.value();
            let epsilon = size_under(mean, setting)?;
            wave(mean / epsilon, Size::Epsilon(epsilon))
        }
    }
}

/// The size of the ansatz with `a = 1` that has the frequency of the setting under this mean
/// strain, which is not zero.
fn size_under(mean: f64, setting: &WaveSetting) -> Result<f64> {
    let WaveSetting { params, q, omega_tw, .. } = *setting;
    params.validate()?;
    let (averages, omega) = (Averages::new(params.alpha, params.kappa)?, params.omega());
    let above = |epsilon: f64| {
        let per_size = detuning(omega, q.q(), averages.h(mean / epsilon, 1.0));
        per_size * epsilon.powf(params.alpha - 1.0) > omega_tw - omega
    };
    // With a positive mean strain no contact closes at the first size or below. With a negative
    // one, a precompression, much smaller waves are those of the linear chain.
    let first = mean.abs() * if mean > 0.0 { 0.5 / params.kappa } else { 1e-6 };
    least_size(first, above).map_err(|rule| Error::parameter("omega_tw", omega_tw, rule))
}

/// The size above which the frequency of a wave is higher than the wanted one, by bisection; at the
/// size `first` it must not be. The error is the rule that is broken.
fn least_size(first: f64, above: impl Fn(f64) -> bool) -> std::result::Result<f64, &'static str> {
    if above(first) {
        return Err("under this mean strain the first approximation has only waves of higher frequency");
    }
    least_above(first, above).ok_or("a frequency that the first approximation has at some size")
}

fn frequency_rule(omega_tw: f64, params: Params) -> Error {
    let value = format!("{omega_tw}, where omega = {}", params.omega());
    let rule = match params.resonators() {
        Resonators::Moving => "above omega: contacts raise the frequency of a wave; or below (kappa/rho)^(1/2)",
        _ => "above omega: contacts raise the frequency of a wave",
    };
    Error::parameter("omega_tw", value, rule)
}

fn background_rule(background: f64) -> Error {
    let rule = "a pulse on a background has no first-order ansatz: give the mean strain";
    Error::parameter("mean", background, rule)
}

pub(super) fn amplitude_rule(amplitude: f64) -> Error {
    let rule = "finite, positive and above the mean strain, or no contact ever closes";
    Error::parameter("amplitude", amplitude, rule)
}

/// The state of a cell at `t = 0` in the ansatz.
pub(super) fn state(wave: &TravellingWave, cell: usize) -> Vec<f64> {
    let sites: Vec<_> = (0..cell).map(|n| wave.site(n, 0.0)).collect();
    let quarter = |of: fn(&crate::chain::Site<f64>) -> f64| sites.iter().map(of).collect::<Vec<_>>();
    [quarter(|s| s.u), quarter(|s| s.v), quarter(|s| s.u_dot), quarter(|s| s.v_dot)].concat()
}
