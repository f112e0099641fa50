//! Branches of exact waves, by pseudo-arclength (as in [`orbits`](crate::orbits), Keller 1977).
//!
//! | symbol | meaning |
//! |---|---|
//! | `(z/s, p/P)` | state and parameter, scaled by `s = sqrt(4m) max abs(z - mean)` and `P` |
//! | `ds` | length of a step along the branch |
//!
//! On a branch in the amplitude the unknown parameter is the frequency: the amplitude follows from
//! the state.

use super::{
    ExactWave, Given, MeanStrain, Search, WaveSetting,
    newton::{Equations, stalled},
    swing,
};
use crate::{
    chain::{Params, Resonators},
    error::{Error, Result},
    interrupt,
    orbits::{NewtonStep, least_squares, strays},
};
use nalgebra::DVector;
use serde::Serialize;

/// Largest, first and smallest `ds`: the state changes by that share of its size.
const LONGEST: f64 = 0.25;
const FIRST: f64 = 0.02;
const SHORTEST: f64 = 1e-7;
/// Largest number of corrector steps, and the number up to which `ds` grows.
const MOST_CORRECTIONS: usize = 8;
const GOOD_CORRECTIONS: usize = 4;
/// A correction of at most this length, in scaled unknowns, is the last one.
const LAST_CORRECTION: f64 = 1e-9;
/// Least unit of the frequency, as a share of the frequency.
const LEAST_DETUNING: f64 = 1e-4;
/// Relative distance of `omega_tw` from `omega` below which a wave with a crest no higher than its
/// mean strain is free of contacts: then both are equal up to roundings.
const FREE: f64 = 1e-11;
/// Largest residual of a wave.
const SOLVED: f64 = 1e-12;

/// A number of a wave that can vary along a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "cli", value(rename_all = "snake_case"))]
pub enum WaveParameter {
    /// Frequency `omega_tw` of the wave.
    OmegaTw,
    /// Height of the crest above the mean strain.
    Amplitude,
    /// Mean strain.
    Mean,
    /// Mass ratio resonator to bead.
    Rho,
    /// Spring constant of the resonators.
    Kappa,
    /// Exponent of the contact force.
    Alpha,
}

impl WaveParameter {
    /// The symbol in pictures.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::OmegaTw => "ω_tw",
            Self::Amplitude => "amplitude",
            Self::Mean => "mean strain",
            Self::Rho => "ρ",
            Self::Kappa => "κ",
            Self::Alpha => "α",
        }
    }

    /// The value that a wave has.
    pub fn of(self, wave: &ExactWave) -> f64 {
        match self {
            Self::Amplitude => wave.amplitude(),
            Self::Mean => wave.mean(),
            _ => self.free(&wave.setting),
        }
    }

    /// A number below all of its values, and the rule in words.
    fn rule(self) -> (f64, &'static str) {
        match self {
            Self::Mean => (f64::NEG_INFINITY, "a finite number"),
            Self::Alpha => (1.0, "above 1: tangent maps need alpha > 1"),
            Self::OmegaTw => (0.0, "a frequency is positive"),
            Self::Amplitude => (0.0, "an amplitude is positive"),
            Self::Rho => (0.0, "a mass ratio is positive; a wave without resonators has a branch of its own"),
            Self::Kappa => (0.0, "a spring constant is positive"),
        }
    }

    /// The number of the setting that is the unknown parameter.
    fn free(self, setting: &WaveSetting) -> f64 {
        match self {
            Self::OmegaTw | Self::Amplitude => setting.omega_tw,
            Self::Mean => setting.mean.value(),
            Self::Rho => setting.params.rho,
            Self::Kappa => setting.params.kappa,
            Self::Alpha => setting.params.alpha,
        }
    }

    /// The setting with another value of this number.
    fn with(self, setting: &WaveSetting, value: f64) -> WaveSetting {
        let params = setting.params;
        match self {
            Self::OmegaTw | Self::Amplitude => WaveSetting { omega_tw: value, ..*setting },
            Self::Mean => WaveSetting { mean: MeanStrain::Value(value), ..*setting },
            Self::Rho => WaveSetting { params: Params { rho: value, ..params }, ..*setting },
            Self::Kappa => WaveSetting { params: Params { kappa: value, ..params }, ..*setting },
            Self::Alpha => WaveSetting { params: Params { alpha: value, ..params }, ..*setting },
        }
    }
}

/// Settings of a continuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveContinuation {
    /// The parameter that varies.
    pub parameter: WaveParameter,
    /// The value at which the branch ends.
    pub to: f64,
    /// Largest change of the parameter from wave to wave.
    pub step: f64,
    /// Largest number of waves.
    pub most_points: usize,
    /// Settings of the search for each wave.
    pub search: Search,
}

/// Why a branch ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WaveEnd {
    /// The parameter has its final value.
    Reached,
    /// It has the largest number of waves.
    MostPoints,
    /// It turned back and the parameter passed its first value.
    TurnedBack,
    /// No contact closes any more: every wave of frequency `omega` without contacts follows.
    NoContact,
    /// No wave was found with the shortest step.
    Lost,
    /// Newton's method leads to a wave of another branch, also with the shortest step.
    Jumped,
    /// The process was asked to end.
    Stopped,
}

impl WaveEnd {
    /// The reason in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reached => "the parameter has its final value",
            Self::MostPoints => "it has the largest number of points",
            Self::TurnedBack => "it turned back and passed its first value",
            Self::NoContact => "no contact closes any more, and the frequency is omega",
            Self::Lost => "no wave was found with the shortest step",
            Self::Jumped => "Newton's method leads to another branch, also with the shortest step",
            Self::Stopped => "the process was asked to end",
        }
    }
}

/// A branch of waves.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveBranch {
    /// The waves, at least one, in their order along the branch.
    pub waves: Vec<ExactWave>,
    /// Why it ended.
    pub end: WaveEnd,
}

/// The next wave, the length of the step after it, and whether it has the final value.
struct Next {
    wave: ExactWave,
    ds: f64,
    lands: bool,
}

impl ExactWave {
    /// Whether no contact closes.
    fn free_of_contacts(&self) -> bool {
        let omega = self.setting.params.omega();
        self.amplitude() <= self.mean() && (self.setting.omega_tw / omega - 1.0).abs() <= FREE
    }
}

/// Units of the unknowns.
#[derive(Clone, Copy)]
struct Scales {
    state: f64,
    parameter: f64,
}

impl WaveContinuation {
    /// Follows the branch from `start`; `seen` is called with every wave. The rule for the mean
    /// strain is that of `start`.
    ///
    /// # Errors
    /// An end at the start or outside the range of the parameter, a step that is not positive,
    /// fewer than two waves. A branch that ends early is no error.
    pub fn follow(&self, start: ExactWave, mut seen: impl FnMut(&ExactWave)) -> Result<WaveBranch> {
        let from = self.parameter.of(&start);
        self.check(from, &start.setting)?;
        if let (WaveParameter::Mean, MeanStrain::OfAmplitude(share)) = (self.parameter, start.setting.mean) {
            return Err(Error::parameter("mean", share, "a share of the amplitude does not vary: give a value"));
        }
        let direction = (self.to - from).signum();
        let mut waves = vec![start];
        let (mut ds, mut landed) = (FIRST, false);
        let end = loop {
            let Some(wave) = waves.last() else { break WaveEnd::Lost };
            seen(wave);
            let value = self.parameter.of(wave);
            match () {
                () if landed || (value - self.to) * direction > 0.0 => break WaveEnd::Reached,
                () if (value - from) * direction < 0.0 => break WaveEnd::TurnedBack,
                () if wave.free_of_contacts() => break WaveEnd::NoContact,
                () if waves.len() >= self.most_points => break WaveEnd::MostPoints,
                () if interrupt::asked() => break WaveEnd::Stopped,
                () => {}
            }
            let next = match self.next(&waves, direction, ds) {
                Ok(next) => next,
                Err(_) if interrupt::asked() => break WaveEnd::Stopped,
                Err(end) => break end,
            };
            waves.push(next.wave);
            (ds, landed) = (next.ds, next.lands);
        };
        Ok(WaveBranch { waves, end })
    }

    /// Refuses numbers outside their rules, for a branch from a wave of this setting, with the
    /// parameter at `from`.
    ///
    /// # Errors
    /// As [`follow`](Self::follow).
    pub fn check(&self, from: f64, setting: &WaveSetting) -> Result<()> {
        let resonators = setting.params.resonators();
        match self.parameter {
            WaveParameter::Rho if resonators != Resonators::Moving => {
                let rule = "rho varies where resonators move: 0 < rho < inf";
                return Err(Error::parameter("rho", setting.params.rho, rule));
            }
            WaveParameter::Kappa if resonators == Resonators::None => {
                let rule = "kappa varies where there are resonators: rho > 0";
                return Err(Error::parameter("rho", setting.params.rho, rule));
            }
            WaveParameter::Mean if resonators == Resonators::Fixed => {
                let rule = "fixed resonators (rho = inf) hold the mean strain of a wave at 0";
                return Err(Error::parameter("vary", "mean", rule));
            }
            _ => {}
        }
        if !self.to.is_finite() || self.to == from {
            return Err(Error::parameter("to", self.to, "a finite number, not where the branch begins"));
        }
        let (least, rule) = self.parameter.rule();
        if self.to <= least {
            return Err(Error::parameter("to", self.to, rule));
        }
        if self.step.is_nan() || self.step <= 0.0 {
            return Err(Error::parameter("step", self.step, "positive"));
        }
        if self.most_points < 2 {
            return Err(Error::parameter("max-points", self.most_points, "at least two"));
        }
        Ok(())
    }

    /// The next wave; otherwise why the branch ends.
    fn next(&self, waves: &[ExactWave], direction: f64, ds: f64) -> std::result::Result<Next, WaveEnd> {
        let wave = waves.last().ok_or(WaveEnd::Lost)?;
        let scales = self.scales(wave);
        let tangent = self.tangent(waves, scales, direction).ok_or(WaveEnd::Lost)?;
        let now = self.parameter.of(wave);
        let last = tangent.len() - 1;
        let rate = match self.parameter {
            WaveParameter::Amplitude => tangent[0] * scales.state,
            _ => tangent[last] * scales.parameter,
        };
        let mut ds = ds.min(LONGEST).min(self.step / rate.abs());
        loop {
            let lands = rate * direction > 0.0 && (self.to - now).abs() <= 1.001 * (rate * ds).abs();
            let length = if lands { (self.to - now) / rate } else { ds };
            match self.step(wave, &tangent, scales, length, lands) {
                Ok(next) if strays(self.chord(wave, &next, scales), length.abs(), &next.newton) => {
                    if ds <= SHORTEST {
                        return Err(WaveEnd::Jumped);
                    }
                    ds *= 0.5;
                }
                Ok(next) => {
                    let factor = if next.newton.len() <= GOOD_CORRECTIONS { 1.5 } else { 0.7 };
                    return Ok(Next { wave: next, ds: ds * factor, lands });
                }
                Err(_) if ds > SHORTEST => ds *= 0.5,
                Err(_) => return Err(WaveEnd::Lost),
            }
        }
    }

    /// The distance of two waves in scaled unknowns.
    fn chord(&self, from: &ExactWave, to: &ExactWave, scales: Scales) -> f64 {
        let parameter = self.parameter.free(&to.setting) - self.parameter.free(&from.setting);
        let state = from.z.iter().zip(&to.z).map(|(a, b)| ((b - a) / scales.state).powi(2)).sum::<f64>().sqrt();
        state.hypot(parameter / scales.parameter)
    }

    fn scales(&self, wave: &ExactWave) -> Scales {
        let setting = &wave.setting;
        let size = swing(&wave.z, setting);
        let parameter = match self.parameter {
            // About the change of frequency that changes the wave by its own size. Waves without
            // contacts have no detuning, and that of waves far below omega exceeds omega_tw.
            WaveParameter::OmegaTw | WaveParameter::Amplitude => {
                let detuning = (setting.omega_tw - setting.params.omega()).abs();
                detuning.clamp(LEAST_DETUNING * setting.omega_tw, setting.omega_tw)
            }
            WaveParameter::Mean => size,
            _ => self.parameter.free(setting),
        };
        Scales { state: size * (wave.z.len() as f64).sqrt(), parameter: parameter.abs() }
    }

    /// The equations and their derivative by the scaled unknowns.
    fn equations(&self, setting: &WaveSetting, z: &[f64], scales: Scales) -> Result<Equations> {
        let Equations { residual, jacobian } = self.search.equations(setting, z, true)?;
        let with = |value: f64| self.parameter.with(setting, value);
        let slope = self.search.slope(setting, z, self.parameter.free(setting), with)?;
        let mut jacobian = (jacobian * scales.state).insert_column(z.len(), 0.0);
        jacobian.set_column(z.len(), &(slope * scales.parameter));
        Ok(Equations { residual, jacobian })
    }

    /// The unit tangent along the last step; at the first wave towards the final value.
    fn tangent(&self, waves: &[ExactWave], scales: Scales, direction: f64) -> Option<DVector<f64>> {
        let wave = waves.last()?;
        let columns = wave.z.len() + 1;
        let mut along = DVector::zeros(columns);
        match waves {
            [.., before, _] => {
                let apart = wave.z.iter().zip(&before.z).map(|(now, before)| (now - before) / scales.state);
                apart.enumerate().for_each(|(i, apart)| along[i] = apart);
                let step = self.parameter.free(&wave.setting) - self.parameter.free(&before.setting);
                along[columns - 1] = step / scales.parameter;
            }
            _ if self.parameter == WaveParameter::Amplitude => along[0] = direction,
            _ => along[columns - 1] = direction,
        }
        let Equations { residual, jacobian } = self.equations(&wave.setting, &wave.z, scales).ok()?;
        let rows = residual.len();
        let mut matrix = jacobian.insert_row(rows, 0.0);
        matrix.set_row(rows, &along.normalize().transpose());
        let mut right = DVector::zeros(rows + 1);
        right[rows] = 1.0;
        least_squares(matrix, &right).map(|tangent| tangent.normalize())
    }

    /// The wave at the distance `ds` along the tangent or, if it is to land, with the final value.
    fn step(&self, wave: &ExactWave, t: &DVector<f64>, scales: Scales, ds: f64, lands: bool) -> Result<ExactWave> {
        let columns = wave.z.len();
        let z: Vec<f64> = wave.z.iter().zip(t).map(|(z, t)| z + ds * t * scales.state).collect();
        let free = self.parameter.free(&wave.setting) + ds * t[columns] * scales.parameter;
        let setting = self.parameter.with(&wave.setting, free);
        if lands {
            let (setting, given) = match self.parameter {
                WaveParameter::Amplitude => (setting, Given::Amplitude(self.to)),
                parameter => (parameter.with(&setting, self.to), Given::Frequency),
            };
            let search = Search { most_steps: MOST_CORRECTIONS + 1, ..self.search };
            return search.solve(&setting, given, &z);
        }
        self.correct(ExactWave { setting, z, residual: f64::INFINITY, newton: Vec::new() }, t, scales, ds)
    }

    /// Newton's method in the plane through the predictor, normal to the tangent.
    fn correct(&self, mut wave: ExactWave, t: &DVector<f64>, scales: Scales, ds: f64) -> Result<ExactWave> {
        let columns = wave.z.len();
        for _ in 0..MOST_CORRECTIONS {
            let Equations { residual, jacobian } = self.equations(&wave.setting, &wave.z, scales)?;
            let rows = residual.len();
            let mut matrix = jacobian.insert_row(rows, 0.0);
            matrix.set_row(rows, &t.transpose());
            let relative = residual.amax() / swing(&wave.z, &wave.setting);
            let Some(by) = least_squares(matrix, &residual.push(0.0)) else { break };
            let step = by.norm();
            // A correction longer than half of the step leads to another wave.
            if step.is_nan() || step > 0.5 * ds {
                break;
            }
            wave.newton.push(NewtonStep { residual: relative, step });
            wave.z.iter_mut().zip(&by).for_each(|(z, by)| *z -= by * scales.state);
            let free = self.parameter.free(&wave.setting) - by[columns] * scales.parameter;
            wave.setting = self.parameter.with(&wave.setting, free);
            if step <= LAST_CORRECTION {
                let residual = self.search.equations(&wave.setting, &wave.z, false)?.residual;
                wave.residual = residual.amax() / swing(&wave.z, &wave.setting);
                return if wave.residual <= SOLVED { Ok(wave) } else { Err(stalled(wave.newton.len(), Some(wave))) };
            }
        }
        Err(stalled(wave.newton.len(), None))
    }
}
