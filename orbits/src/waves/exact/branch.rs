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
    ExactWave, Given, MeanStrain, Search, WaveSetting, WaveSpectrum, ansatz,
    newton::{DIFFERENCE, SOLVED, amplitude_row},
    seed::amplitude_rule,
    swing,
};
use crate::{
    chain::{Params, Resonators, max_norm},
    error::{Error, Result, SMOOTH, require},
    named::named,
    orbits::{
        Branch, End, Equations, MOST_CORRECTIONS, Point, Problem, Range, Solution, branch::ranged, check, returns,
    },
    output::FileFormat,
    waves::Modulation,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Samples of a profile for largest values.
const SAMPLES: usize = 256;
/// Steps in the range of the parameter, if no largest step is given.
const STEPS: f64 = 20.0;
/// Relative distance of `omega_tw` from `omega` below which a wave with a crest no higher than its
/// mean strain is free of contacts: then both are equal up to roundings.
const FREE: f64 = 1e-11;
/// The same distance, and the amplitude over that of the first wave, below which a branch has come
/// to the linear waves.
const LINEAR: f64 = 1e-8;

named! {
    /// A number of a wave that can vary along a branch.
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    #[cfg_attr(feature = "cli", value(rename_all = "snake_case"))]
    pub enum WaveParameter {
        /// Frequency `omega_tw` of the wave.
        OmegaTw = "omega_tw",
        /// Height of the crest above the mean strain.
        Amplitude = "amplitude",
        /// Mean strain.
        Mean = "mean",
        /// Mass ratio resonator to bead.
        Rho = "rho",
        /// Spring constant of the resonators.
        Kappa = "kappa",
        /// Exponent of the contact force.
        Alpha = "alpha",
    }
}

impl WaveParameter {
    /// Symbol, a number below all values, and the rule in words.
    fn told(self) -> (&'static str, f64, &'static str) {
        match self {
            Self::OmegaTw => ("ω_tw", 0.0, "a frequency is positive"),
            Self::Amplitude => ("amplitude", 0.0, "an amplitude is positive"),
            Self::Mean => ("mean strain", f64::NEG_INFINITY, "a finite number"),
            Self::Rho => ("ρ", 0.0, "a mass ratio is positive; a wave without resonators has a branch of its own"),
            Self::Kappa => ("κ", 0.0, "a spring constant is positive"),
            Self::Alpha => ("α", 1.0, SMOOTH),
        }
    }

    /// The symbol in pictures.
    pub fn symbol(self) -> &'static str {
        self.told().0
    }

    /// The value that a wave has.
    pub fn of(self, wave: &ExactWave) -> f64 {
        match self {
            Self::Amplitude => wave.amplitude(),
            Self::Mean => wave.mean(),
            _ => self.free(&wave.setting),
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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

/// What does not vary along a branch of waves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaveBase {
    /// The setting of the first wave.
    pub setting: WaveSetting,
    /// `s`.
    pub size: f64,
    /// Sites of the ring of the multipliers, a multiple of the cell.
    pub sites: usize,
}

/// Measurements of a wave of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WaveMeasures {
    /// `E_x` and `E_y` of the ansatz with the same frequency and mean strain, if there is one.
    pub errors: Option<[f64; 2]>,
    /// Largest growth of the ansatz by the linearised modulation equations, at the wave numbers of
    /// the ring.
    pub modulation: Option<f64>,
    /// Share of the period in which a contact is closed.
    pub closed: f64,
}

/// An exact wave with its multipliers.
pub type WavePoint = Point<WaveContinuation>;

/// A branch of exact waves.
pub type WaveBranch = Branch<WaveContinuation>;

/// `m`.
fn offset(setting: &WaveSetting) -> f64 {
    match setting.mean {
        MeanStrain::Value(mean) | MeanStrain::Background(mean) => mean,
        MeanStrain::OfAmplitude(_) => 0.0,
    }
}

impl WaveContinuation {
    /// The setting and the state for these unknowns.
    fn at(&self, WaveBase { setting: first, size, .. }: &WaveBase, z: &[f64], p: f64) -> (WaveSetting, Vec<f64>) {
        let setting = match self.parameter {
            WaveParameter::Amplitude => {
                WaveSetting { omega_tw: first.omega_tw * (z[z.len() - 1] / size).exp(), ..*first }
            }
            parameter => parameter.with(first, p),
        };
        let (numbers, omega) = (setting.numbers(), setting.omega_tw);
        let (strains, rates) = z[..numbers].split_at(numbers / 2);
        let strains = strains.iter().map(|z| z + offset(&setting));
        (setting, strains.chain(rates.iter().map(|z| z * omega)).collect())
    }
}

impl Problem for WaveContinuation {
    type Setting = WaveBase;
    type Orbit = ExactWave;
    type Spectrum = WaveSpectrum;
    type Measures = WaveMeasures;
    type Critical = ();
    const FORMAT: FileFormat = FileFormat("hertzchain wave branch", 1);

    fn name(&self) -> &'static str {
        self.parameter.name()
    }

    ranged!();

    fn check_value(&self, base: &WaveBase, p: f64) -> Result<()> {
        self.parameter.with(&base.setting, p).chain(base.setting.least_cells()).map(|_| ())
    }

    fn equations(&self, base: &WaveBase, z: &[f64], p: f64, derivative: bool) -> Result<Equations> {
        let (setting, state) = self.at(base, z, p);
        let row = amplitude_row(&setting);
        let amplitude = row.iter().zip(&state).map(|(row, z)| row * z).sum::<f64>();
        if amplitude <= 0.0 {
            // Beyond the linear waves another branch begins; the step is halved.
            return Err(amplitude_rule(amplitude));
        }
        let Equations { mut residual, mut jacobian } = self.search.equations(&setting, &state, derivative)?;
        let (n, rows) = (state.len(), residual.len());
        if derivative {
            jacobian.columns_mut(n / 2, n / 2).scale_mut(setting.omega_tw);
        }
        if self.parameter == WaveParameter::Amplitude {
            residual = residual.push(amplitude - p);
            if derivative {
                let by = DIFFERENCE * base.size;
                let at = |w: f64| self.equations(base, &[&z[..n], &[z[n] + w]].concat(), p, false);
                let slope = (at(by)?.residual - at(-by)?.residual) / (2.0 * by);
                jacobian = jacobian.insert_row(rows, 0.0).insert_column(n, 0.0);
                jacobian.view_mut((rows, 0), (1, n)).copy_from_slice(&row);
                jacobian.set_column(n, &slope);
            }
        }
        Ok(Equations { residual, jacobian })
    }

    fn solve(&self, base: &WaveBase, seed: &[f64], p: f64) -> Result<Solution> {
        let (setting, seed) = self.at(base, seed, p);
        let given = match self.parameter {
            WaveParameter::Amplitude => Given::Amplitude(p),
            _ => Given::Frequency,
        };
        let search = Search { most_steps: MOST_CORRECTIONS, ..self.search };
        let solution = self.solution(base, &search.solve(&setting, given, &seed)?);
        Ok(Solution { p, ..solution })
    }

    fn size(&self, base: &WaveBase, z: &[f64], p: f64) -> f64 {
        let (setting, state) = self.at(base, z, p);
        swing(&state, &setting)
    }

    fn solved(&self, _base: &WaveBase, _z: &[f64], _p: f64) -> f64 {
        SOLVED
    }

    fn orbit(&self, base: &WaveBase, solution: &Solution) -> ExactWave {
        let (setting, z) = self.at(base, &solution.z, solution.p);
        ExactWave { z, ..solution.orbit(setting) }
    }

    fn solution(&self, base: &WaveBase, wave: &ExactWave) -> Solution {
        let ExactWave { setting, z, .. } = wave;
        let (strains, rates) = z.split_at(z.len() / 2);
        let strains = strains.iter().map(|z| z - offset(setting));
        let w = (setting.omega_tw / base.setting.omega_tw).ln() * base.size;
        let w = (self.parameter == WaveParameter::Amplitude).then_some(w);
        let z = strains.chain(rates.iter().map(|z| z / setting.omega_tw)).chain(w).collect();
        Solution { z, ..wave.solution(self.parameter.of(wave)) }
    }

    fn ends(&self, base: &WaveBase, wave: &ExactWave) -> Option<End> {
        let off = (wave.setting.omega_tw / wave.setting.params.omega() - 1.0).abs();
        if wave.amplitude() <= wave.mean() && off <= FREE {
            return Some(End::NoContact);
        }
        (off <= LINEAR && wave.amplitude() <= LINEAR * base.size).then_some(End::Vanished)
    }

    fn spectrum(&self, base: &WaveBase, wave: &ExactWave) -> Result<WaveSpectrum> {
        wave.spectrum(base.sites, &self.search)
    }

    fn measures(&self, base: &WaveBase, wave: &ExactWave) -> Result<WaveMeasures> {
        let profile = wave.profile(SAMPLES, &self.search)?;
        let setting = WaveSetting { mean: MeanStrain::Value(wave.mean()), ..wave.setting };
        let ansatz = ansatz(&setting, Given::Frequency).ok();
        let modulation = ansatz.and_then(|ansatz| {
            let modulation = Modulation::new(ansatz.params(), ansatz.shape()).ok()?;
            let at = |j: usize| modulation.growth(2.0 * PI * j as f64 / base.sites as f64);
            Some(ansatz.slow_time(1.0) * (0..=base.sites / 2).map(at).fold(0.0, f64::max))
        });
        Ok(WaveMeasures { errors: ansatz.map(|ansatz| profile.errors(&ansatz)), modulation, closed: profile.closed() })
    }
    /// The state of a cell, and the number of the setting that differs from wave to wave.
    fn arrays(base: &WaveBase) -> Vec<(&'static str, usize)> {
        let m = base.setting.q.cell();
        let arrays: &[_] = if base.setting.numbers() == 4 * m { &["x", "y", "vx", "vy"] } else { &["x", "vx"] };
        arrays.iter().map(|name| (*name, m)).chain([("setting", 1)]).collect()
    }

    fn numbers(&self, base: &WaveBase, wave: &ExactWave) -> Solution {
        let z = wave.z.iter().copied().chain([self.parameter.free(&wave.setting)]).collect();
        Solution { z, ..self.solution(base, wave) }
    }

    fn restored(&self, base: &WaveBase, mut numbers: Solution) -> ExactWave {
        let free = numbers.z.pop().unwrap_or(f64::NAN);
        numbers.orbit(self.parameter.with(&base.setting, free))
    }

    fn multipliers(spectrum: &WaveSpectrum) -> Vec<[f64; 3]> {
        spectrum.multipliers.iter().map(|one| [one.re, one.im, one.error]).collect()
    }

    fn verify(&self, base: &WaveBase, wave: &ExactWave) -> Result<()> {
        let setting = &wave.setting;
        setting.chain(setting.least_cells())?;
        let contacts = 4.0 * setting.params.alpha * max_norm(wave.z.iter().copied()).powf(setting.params.alpha - 1.0);
        let rate = contacts.sqrt().max(setting.params.omega()) / setting.omega_tw;
        let Solution { z, p, .. } = self.solution(base, wave);
        returns(rate, || Ok(self.equations(base, &z, p, false)?.residual.amax() / swing(&wave.z, setting)))
    }
}

impl WaveContinuation {
    /// The branch that has only its first wave, with multipliers on a ring of `sites` sites. The
    /// rule for the mean strain is that of `start`.
    ///
    /// # Errors
    /// An end at the start or outside the range of the parameter, a step that is not positive,
    /// fewer than two waves.
    pub fn begin(&self, start: ExactWave, sites: usize) -> Result<WaveBranch> {
        let (parameter, from, setting) = (self.parameter, self.parameter.of(&start), start.setting);
        self.check(from, &setting)?;
        if let (WaveParameter::Mean, MeanStrain::OfAmplitude(share)) = (parameter, setting.mean) {
            return Err(Error::parameter("mean", share, "a share of the amplitude does not vary: give a value"));
        }
        let step = if self.step.is_finite() { self.step } else { (self.to - from).abs() / STEPS };
        let base = WaveBase { setting, size: swing(&start.z, &setting), sites };
        WaveBranch::new(Self { step, ..*self }, base, start)
    }

    /// Refuses numbers outside their rules, for a branch from a wave of this setting, with the
    /// parameter at `from`.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
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
        let (.., least, rule) = self.parameter.told();
        require(self.to > least, "to", self.to, rule)?;
        // An infinite step is a default.
        check([from, self.to], if self.step == f64::INFINITY { 1.0 } else { self.step }, self.most_points)
    }
}
