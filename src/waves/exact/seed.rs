//! Where the search for an exact wave starts: the first-order ansatz (eq:xytw_app), and smaller
//! waves where that is too far away.

use super::{ExactWave, Given, MeanStrain, Search, WaveSetting};
use crate::{
    dps::Averages,
    error::{Error, Result},
    waves::{Shape, Size, TravellingWave, detuning},
};

/// Size of the first wave where the ansatz of the wanted one is too far away, relative to it, and
/// the first and the least factor from one wave to the next.
const SMALL: f64 = 1e-3;
const FACTOR: f64 = 2.0;
const LEAST_FACTOR: f64 = 1.002;

/// The ansatz (eq:xytw_app) with the wave number and the mean strain of the setting, and with its
/// frequency or the given amplitude.
///
/// # Errors
/// A frequency at or below `omega`, where waves of small amplitude are not; an amplitude that is
/// not positive, or at which no contact closes; parameters outside their rules.
pub fn ansatz(setting: &WaveSetting, given: Given) -> Result<TravellingWave> {
    let WaveSetting { params, q, mean, omega_tw } = *setting;
    if let MeanStrain::Background(background) = mean {
        let rule = "a pulse on a background has no first-order ansatz: give the mean strain";
        return Err(Error::parameter("mean", background, rule));
    }
    let wave = |b: f64, size: Size| TravellingWave::new(params, Shape { q: q.q(), a: 1.0, b, phi: 0.0 }, size);
    if let Given::Amplitude(amplitude) = given {
        let share = match mean {
            MeanStrain::OfAmplitude(share) => share,
            given => given.value() / amplitude,
        };
        if !(amplitude.is_finite() && amplitude > 0.0 && share < 1.0) {
            let rule = "finite, positive and above the mean strain, or no contact ever closes";
            return Err(Error::parameter("amplitude", amplitude, rule));
        }
        return wave(2.0 * params.kappa * share, Size::Epsilon(0.5 * amplitude / params.kappa));
    }
    if omega_tw.partial_cmp(&params.omega()) != Some(std::cmp::Ordering::Greater) {
        let value = format!("{omega_tw}, where omega = {}", params.omega());
        return Err(Error::parameter("omega_tw", value, "above omega: contacts raise the frequency of a wave"));
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
    // Under a gap, no contact closes at the first size or below. Under a precompression, much
    // smaller waves are those of the linear chain.
    let first = mean.abs() * if mean > 0.0 { 0.5 / params.kappa } else { 1e-6 };
    if above(first) {
        let rule = "under this mean strain the ansatz has only waves of higher frequency";
        return Err(Error::parameter("omega_tw", omega_tw, rule));
    }
    let (mut low, mut high) = (first, 2.0 * first);
    while !above(high) {
        (low, high) = (high, 2.0 * high);
        if !high.is_finite() {
            return Err(Error::parameter("omega_tw", omega_tw, "a frequency that the ansatz has at some size"));
        }
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Ok(high);
        }
        *(if above(middle) { &mut high } else { &mut low }) = middle;
    }
}

/// The state of a cell at `t = 0` in the ansatz.
fn state(wave: &TravellingWave, cell: usize) -> Vec<f64> {
    let sites: Vec<_> = (0..cell).map(|n| wave.site(n, 0.0)).collect();
    let quarter = |of: fn(&crate::chain::Site<f64>) -> f64| sites.iter().map(of).collect::<Vec<_>>();
    [quarter(|s| s.u), quarter(|s| s.v), quarter(|s| s.u_dot), quarter(|s| s.v_dot)].concat()
}

impl Search {
    /// The exact companion of the ansatz with the same mean strain, and the same frequency or
    /// amplitude.
    ///
    /// Newton's method starts from the ansatz. Where it does not converge, waves of the same shape
    /// grow from a thousandth of its size in steps, each wave scaled up to start the next.
    ///
    /// # Errors
    /// As [`ansatz`] and [`Search::solve`]; [`Error::Stalled`] where neither way leads to the wave.
    pub fn wave(&self, setting: &WaveSetting, given: Given) -> Result<(ExactWave, TravellingWave)> {
        let ansatz = ansatz(setting, given)?;
        let cell = setting.q.cell();
        let stalled = match self.solve(setting, given, &state(&ansatz, cell)) {
            Err(error @ Error::Stalled { .. }) => error,
            solved => return Ok((solved?, ansatz)),
        };
        let amplitude = ansatz.amplitude();
        let sized = |size: f64| -> Result<(WaveSetting, TravellingWave)> {
            let small = Size::Epsilon(size * ansatz.epsilon());
            let wave = TravellingWave::new(setting.params, ansatz.shape(), small)?;
            Ok((WaveSetting { mean: setting.mean.times(size), omega_tw: wave.omega_tw(), ..*setting }, wave))
        };
        let (first, small) = sized(SMALL)?;
        let mut wave = self.solve(&first, Given::Amplitude(SMALL * amplitude), &state(&small, cell))?;
        let (mut size, mut factor) = (SMALL, FACTOR);
        while size < 1.0 {
            let next = (size * factor).min(1.0);
            let setting = WaveSetting { mean: setting.mean.times(next), ..wave.setting };
            let seed: Vec<f64> = wave.z.iter().map(|z| z * next / size).collect();
            match self.solve(&setting, Given::Amplitude(next * amplitude), &seed) {
                Ok(found) => (wave, size, factor) = (found, next, (factor * 1.2).min(FACTOR)),
                Err(_) if factor > LEAST_FACTOR => factor = factor.sqrt(),
                Err(_) => return Err(stalled),
            }
        }
        match given {
            Given::Amplitude(_) => Ok((wave, ansatz)),
            // The amplitude is that of the ansatz, and the frequency is near that of the ansatz.
            Given::Frequency => Ok((self.solve(setting, given, &wave.z).map_err(|_| stalled)?, ansatz)),
        }
    }
}
