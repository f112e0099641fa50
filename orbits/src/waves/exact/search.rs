//! The search for an exact wave from its start, by other exact waves where that is too far away.

use super::{
    ExactWave, Given, MeanStrain, Search, WaveContinuation, WaveParameter, WaveSetting,
    seed::{Harmonic, Start, state},
};
use crate::{
    chain::{Params, Resonators},
    error::{Error, Result},
    waves::TravellingWave,
};

/// Growth of waves up to the wanted one, whose ansatz is too far away: size of the first wave in
/// units of the wanted one; the first factor from one wave to the next, which is also the largest;
/// and the factor at which the search gives up.
const SMALL: f64 = 1e-3;
const FACTOR: f64 = 2.0;
const LEAST_FACTOR: f64 = 1.002;
/// Precompression in units of the amplitude, times `sin^2(q/2)/alpha`, under which a wave of one
/// harmonic is near an exact one: long waves have little dispersion.
const PRESSED: f64 = 6.0;
/// Largest precompression, in units of the amplitude.
const MOST_PRESSED: f64 = 1000.0;
/// Steps by which the precompression is reduced, in units of half the larger of precompression and
/// amplitude: the first, which is also the largest; that at which the search gives up; and the
/// largest number of steps.
const STEP: f64 = 1.0;
const LEAST_STEP: f64 = 0.02;
const MOST_STEPS: usize = 60;
/// Largest number of steps of Newton's method for a wave without resonators.
const NEAR_STEPS: usize = 8;
/// Largest number of waves on the way to a frequency.
const MOST_FOLLOWED: usize = 200;

impl ExactWave {
    /// The state of a wave of the same shape and another frequency, in a chain without resonators,
    /// which has no time scale of its own.
    fn scaled(&self, omega_tw: f64) -> Vec<f64> {
        let faster = omega_tw / self.setting.omega_tw;
        let larger = faster.powf(2.0 / (self.setting.params.alpha - 1.0));
        let half = self.z.len() / 2;
        let factor = |i: usize| if i < half { larger } else { larger * faster };
        self.z.iter().enumerate().map(|(i, z)| factor(i) * z).collect()
    }
}

impl Search {
    /// The exact companion of the ansatz with the same mean strain, and the same frequency or
    /// amplitude; the exact wave near one harmonic, where there is no ansatz.
    ///
    /// Newton's method starts from the ansatz or the harmonic. Where it does not converge and there
    /// are resonators, waves of the same shape grow in steps from a thousandth of the size of the
    /// ansatz; each wave is scaled up to start the next. Two other ways come before a harmonic:
    /// without resonators, waves under a precompression that is reduced in steps; with moving ones,
    /// a wave of the chain without resonators.
    ///
    /// # Errors
    /// A setting outside its rules; as `ansatz` and [`Search::solve`]; [`Error::Stalled`] where
    /// no way leads to the wave.
    pub fn wave(&self, setting: &WaveSetting, given: Given) -> Result<(ExactWave, Option<TravellingWave>)> {
        let start = Start::new(setting, given)?;
        let resonators = setting.params.resonators();
        // Newton's method can lead from one harmonic to other waves; a wave of the chain without
        // resonators is nearer.
        let plain = match start {
            Start::Harmonic(harmonic) if resonators == Resonators::None => self.plain(setting, given, &harmonic),
            Start::Harmonic(_) if resonators == Resonators::Moving => self.laden(setting),
            _ => None,
        };
        let wave = match plain.map_or_else(|| self.from(setting, given, start), Ok) {
            Err(error @ Error::Stalled { .. }) if resonators != Resonators::None => {
                self.grown(setting, given, start.amplitude()).ok_or(error)
            }
            solved => solved,
        };
        Ok((wave?, start.ansatz()))
    }

    /// The wave of a chain without resonators: found for the amplitude of the harmonic, and then
    /// scaled. It is connected to the linear wave under a precompression, unless that way fails.
    fn plain(&self, setting: &WaveSetting, given: Given, harmonic: &Harmonic) -> Option<ExactWave> {
        // More steps of Newton's method lead to other waves.
        let near = Self { most_steps: NEAR_STEPS.min(self.most_steps), ..*self };
        near.released(setting, given, harmonic).or_else(|| {
            let wave = near.from(setting, Given::Amplitude(harmonic.amplitude), Start::Harmonic(*harmonic)).ok()?;
            self.landed(setting, given, wave)
        })
    }

    /// The wave near the start itself.
    fn from(&self, setting: &WaveSetting, given: Given, start: Start) -> Result<ExactWave> {
        match start {
            Start::Ansatz(ansatz) => {
                let omega_tw = if given == Given::Frequency { setting.omega_tw } else { ansatz.omega_tw() };
                self.solve(&WaveSetting { omega_tw, ..*setting }, given, &state(&ansatz, setting.q.cell()))
            }
            Start::Harmonic(harmonic) => {
                let setting = WaveSetting { omega_tw: harmonic.omega_tw, ..*setting };
                self.solve(&setting, given, &harmonic.state(&setting))
            }
        }
    }

    /// The wave from smaller ones of the same shape, which grow in steps.
    fn grown(&self, setting: &WaveSetting, given: Given, amplitude: f64) -> Option<ExactWave> {
        let first = WaveSetting { mean: setting.mean.times(SMALL), ..*setting };
        let small = Given::Amplitude(SMALL * amplitude);
        let mut wave = self.from(&first, small, Start::new(&first, small).ok()?).ok()?;
        let (mut size, mut factor) = (SMALL, FACTOR);
        while size < 1.0 {
            let next = (size * factor).min(1.0);
            let setting = WaveSetting { mean: setting.mean.times(next), ..wave.setting };
            let seed: Vec<f64> = wave.z.iter().map(|z| z * next / size).collect();
            match self.solve(&setting, Given::Amplitude(next * amplitude), &seed) {
                Ok(found) => (wave, size, factor) = (found, next, (factor * 1.2).min(FACTOR)),
                Err(_) if factor > LEAST_FACTOR => factor = factor.sqrt(),
                Err(_) => return None,
            }
        }
        self.landed(setting, given, wave)
    }

    /// The wave whose resonators move with their beads, from a wave of a chain without resonators.
    /// The beads of that chain have the mass of both, `1 + kappa rho/(kappa - rho omega_tw^2)` in
    /// the first harmonic.
    fn laden(&self, setting: &WaveSetting) -> Option<ExactWave> {
        let WaveSetting { params, omega_tw, .. } = *setting;
        let height = params.kappa / (params.kappa - params.rho * omega_tw * omega_tw);
        let faster = (1.0 + params.rho * height).sqrt();
        let plain = WaveSetting { params: Params { rho: 0.0, ..params }, omega_tw: omega_tw * faster, ..*setting };
        let (wave, _) = self.wave(&plain, Given::Frequency).ok()?;
        let mean = wave.mean();
        let (x, rates) = wave.z.split_at(wave.z.len() / 2);
        let y = x.iter().map(|x| mean + height * (x - mean));
        let [vx, vy] = [1.0, height].map(|height| rates.iter().map(move |rate| height * rate / faster));
        let seed: Vec<f64> = x.iter().copied().chain(y).chain(vx).chain(vy).collect();
        self.solve(setting, Given::Frequency, &seed).ok()
    }

    /// The wave from waves of the same amplitude under a precompression, which is reduced in steps.
    fn released(&self, setting: &WaveSetting, given: Given, harmonic: &Harmonic) -> Option<ExactWave> {
        let (amplitude, to) = (harmonic.amplitude, harmonic.mean);
        let at = |mean: f64| WaveSetting { mean: MeanStrain::Value(mean), ..*setting };
        let pressed = PRESSED * setting.params.alpha / (0.5 * setting.q.q()).sin().powi(2);
        let mut mean = to.min(-pressed.min(MOST_PRESSED) * amplitude);
        let first = Harmonic::new(&at(mean), Given::Amplitude(amplitude)).ok()?;
        let mut wave = self.from(&at(mean), Given::Amplitude(amplitude), Start::Harmonic(first)).ok()?;
        let mut step = STEP;
        for _ in 0..MOST_STEPS {
            if mean >= to {
                break;
            }
            let next = (mean + 0.5 * step * amplitude.max(-mean)).min(to);
            let setting = WaveSetting { omega_tw: wave.setting.omega_tw, ..at(next) };
            // The oscillation of the last wave about the next mean strain.
            let half = wave.z.len() / 2;
            let seed: Vec<f64> = (0..2 * half).map(|i| wave.z[i] + if i < half { next - mean } else { 0.0 }).collect();
            match self.solve(&setting, Given::Amplitude(amplitude), &seed) {
                Ok(found) => (wave, mean, step) = (found, next, (step * 1.5).min(STEP)),
                Err(_) if step > LEAST_STEP => step *= 0.5,
                Err(_) => return None,
            }
        }
        if mean < to { None } else { self.landed(setting, given, wave) }
    }

    /// The wave asked for, from one that has the amplitude of the start. If the frequency is given,
    /// this wave is scaled or serves as a seed, and if that fails its branch is followed.
    fn landed(&self, setting: &WaveSetting, given: Given, wave: ExactWave) -> Option<ExactWave> {
        match given {
            Given::Amplitude(_) => {
                Some(ExactWave { setting: WaveSetting { mean: setting.mean, ..wave.setting }, ..wave })
            }
            Given::Frequency => {
                let seed = if setting.params.resonators() == Resonators::None {
                    wave.scaled(setting.omega_tw)
                } else {
                    wave.z.clone()
                };
                self.solve(setting, given, &seed).ok().or_else(|| self.followed(setting, wave))
            }
        }
    }

    /// The wave of the frequency asked for, along the branch from one of another frequency.
    fn followed(&self, setting: &WaveSetting, wave: ExactWave) -> Option<ExactWave> {
        let continuation = WaveContinuation {
            parameter: WaveParameter::OmegaTw,
            to: setting.omega_tw,
            step: f64::INFINITY,
            most_points: MOST_FOLLOWED,
            search: *self,
        };
        let start = ExactWave { setting: WaveSetting { mean: setting.mean, ..wave.setting }, ..wave };
        let mut branch = continuation.begin(start, setting.q.cell()).ok()?;
        branch.extend(|_| {}).ok()?;
        branch.orbits.pop().filter(|wave| wave.setting.omega_tw == setting.omega_tw)
    }
}
