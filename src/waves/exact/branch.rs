//! Branches of exact waves, by the pseudo-arclength continuation of [`orbits`](crate::orbits).
//!
//! | symbol | meaning |
//! |---|---|
//! | `p` | the parameter: a number of the setting, or the amplitude |
//! | `m` | mean or background strain of the setting; 0 if it is a share of the amplitude |
//! | `(x - m, y - m, x'/omega_tw, y'/omega_tw)` | the unknowns |
//! | `w` | on a branch in the amplitude one more: `omega_tw` is `exp(w/s)` times the first one |
//! | `s` | `max |x - mean|` of the first wave |
//!
//! On a branch in the amplitude there is also one equation more: the crest minus the mean strain is
//! `p`.

use super::{
    ExactWave, Given, MeanStrain, Search, WaveSetting,
    newton::{DIFFERENCE, SOLVED, amplitude_row},
    swing,
};
use crate::{
    chain::{Params, Resonators},
    error::{Error, Result},
    orbits::{BranchState, ContinuationOptions, End, Equations, Family, MOST_CORRECTIONS, Solution, follow, kept},
};
use serde::Serialize;

/// Steps in the range of the parameter, if no largest step is given.
const STEPS: f64 = 20.0;
/// Relative distance of `omega_tw` from `omega` below which a wave with a crest no higher than its
/// mean strain is free of contacts: then both are equal up to roundings.
const FREE: f64 = 1e-11;

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
    /// Largest change of the parameter from wave to wave. Infinite: a twentieth of the range.
    pub step: f64,
    /// Largest number of waves.
    pub most_points: usize,
    /// Settings of the search for each wave.
    pub search: Search,
}

/// A branch of waves.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveBranch {
    /// The waves, at least one, in their order along the branch.
    pub waves: Vec<ExactWave>,
    /// Why it ended.
    pub end: End,
}

impl ExactWave {
    /// Whether no contact closes.
    fn free_of_contacts(&self) -> bool {
        let omega = self.setting.params.omega();
        self.amplitude() <= self.mean() && (self.setting.omega_tw / omega - 1.0).abs() <= FREE
    }
}

/// The waves of settings that differ in one parameter.
struct Waves<'a> {
    continuation: &'a WaveContinuation,
    /// The setting of the first wave.
    setting: WaveSetting,
    /// `s`.
    size: f64,
}

impl Waves<'_> {
    /// The setting and the state for these unknowns.
    fn at(&self, z: &[f64], p: f64) -> (WaveSetting, Vec<f64>) {
        let first = &self.setting;
        let setting = match self.continuation.parameter {
            WaveParameter::Amplitude => {
                WaveSetting { omega_tw: first.omega_tw * (z[z.len() - 1] / self.size).exp(), ..*first }
            }
            parameter => parameter.with(first, p),
        };
        let (numbers, omega) = (setting.numbers(), setting.omega_tw);
        let (strains, rates) = z[..numbers].split_at(numbers / 2);
        let strains = strains.iter().map(|z| z + offset(&setting));
        (setting, strains.chain(rates.iter().map(|z| z * omega)).collect())
    }

    fn unknowns(&self, ExactWave { setting, z, .. }: &ExactWave) -> Vec<f64> {
        let (strains, rates) = z.split_at(z.len() / 2);
        let strains = strains.iter().map(|z| z - offset(setting));
        let w = (setting.omega_tw / self.setting.omega_tw).ln() * self.size;
        let w = (self.continuation.parameter == WaveParameter::Amplitude).then_some(w);
        strains.chain(rates.iter().map(|z| z / setting.omega_tw)).chain(w).collect()
    }

    fn wave(&self, Solution { z, p, residual, newton }: &Solution) -> ExactWave {
        let (setting, z) = self.at(z, *p);
        ExactWave { setting, z, residual: *residual, newton: newton.clone() }
    }
}

/// `m`.
fn offset(setting: &WaveSetting) -> f64 {
    match setting.mean {
        MeanStrain::Value(mean) | MeanStrain::Background(mean) => mean,
        MeanStrain::OfAmplitude(_) => 0.0,
    }
}

impl Family for Waves<'_> {
    fn equations(&self, z: &[f64], p: f64, derivative: bool) -> Result<Equations> {
        let (setting, state) = self.at(z, p);
        let Equations { mut residual, mut jacobian } =
            self.continuation.search.equations(&setting, &state, derivative)?;
        let (n, rows) = (state.len(), residual.len());
        if derivative {
            jacobian.columns_mut(n / 2, n / 2).scale_mut(setting.omega_tw);
        }
        if self.continuation.parameter == WaveParameter::Amplitude {
            let row = amplitude_row(&setting);
            residual = residual.push(row.iter().zip(&state).map(|(row, z)| row * z).sum::<f64>() - p);
            if derivative {
                let by = DIFFERENCE * self.size;
                let at = |w: f64| self.equations(&[&z[..n], &[z[n] + w]].concat(), p, false);
                let slope = (at(by)?.residual - at(-by)?.residual) / (2.0 * by);
                jacobian = jacobian.insert_row(rows, 0.0).insert_column(n, 0.0);
                jacobian.view_mut((rows, 0), (1, n)).copy_from_slice(&row);
                jacobian.set_column(n, &slope);
            }
        }
        Ok(Equations { residual, jacobian })
    }

    fn solve(&self, seed: &[f64], p: f64) -> Result<Solution> {
        let (setting, seed) = self.at(seed, p);
        let given = match self.continuation.parameter {
            WaveParameter::Amplitude => Given::Amplitude(p),
            _ => Given::Frequency,
        };
        let search = Search { most_steps: MOST_CORRECTIONS, ..self.continuation.search };
        let wave = search.solve(&setting, given, &seed)?;
        Ok(Solution { z: self.unknowns(&wave), p, residual: wave.residual, newton: wave.newton })
    }

    fn size(&self, z: &[f64], p: f64) -> f64 {
        let (setting, state) = self.at(z, p);
        swing(&state, &setting)
    }

    fn solved(&self, _z: &[f64], _p: f64) -> f64 {
        SOLVED
    }
}

impl WaveContinuation {
    /// Follows the branch from `start`; `seen` is called with every wave. The rule for the mean
    /// strain is that of `start`.
    ///
    /// # Errors
    /// An end at the start or outside the range of the parameter, a step that is not positive,
    /// fewer than two waves. A branch that ends early is no error.
    pub fn follow(&self, start: ExactWave, mut seen: impl FnMut(&ExactWave)) -> Result<WaveBranch> {
        let &Self { parameter, to, step, most_points, .. } = self;
        let from = parameter.of(&start);
        self.check(from, &start.setting)?;
        if let (WaveParameter::Mean, MeanStrain::OfAmplitude(share)) = (parameter, start.setting.mean) {
            return Err(Error::parameter("mean", share, "a share of the amplitude does not vary: give a value"));
        }
        seen(&start);
        let no_contact = |wave: &ExactWave| wave.free_of_contacts().then_some(End::NoContact);
        if let Some(end) = no_contact(&start) {
            return Ok(WaveBranch { waves: vec![start], end });
        }
        let range = (to - from).abs();
        let step = if step.is_finite() { step } else { range / STEPS };
        let family = Waves { continuation: self, setting: start.setting, size: swing(&start.z, &start.setting) };
        let last = (family.unknowns(&start), from);
        let state = BranchState { back: from, previous: None, last, ds: step / range, points: 1 };
        let options = ContinuationOptions { to, step, natural: false, direction: (to - from).signum() };
        let mut waves = vec![start];
        let end = follow(&family, state, options, most_points, &mut |solution, _, end| {
            let wave = family.wave(solution);
            seen(&wave);
            let end = end.or(no_contact(&wave));
            waves.push(wave);
            Ok(end)
        });
        Ok(WaveBranch { waves, end: kept(end)? })
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
}
