//! Exact travelling waves: one with its multipliers, beside its first-order ansatz; branches of
//! them.

mod report;

use crate::study::{
    Changes, ResultUnits, Study, Work,
    options::options,
    orbits::branches::{
        self, Begun, BifurcationOptions, BranchOptions, BranchStudy, FollowCommand, Kept, branch_npz, files_of_branch,
    },
    orbits::proof::{self, Proving, near_wave, of_wave},
};
use crate::{
    chain::{Params, Resonators},
    error::{Error, Iterate, Result, positive, require},
    orbits::{AnalysisLevel, BifurcationKind, Problem},
    output::{Array, Folder, to_json},
    report::Report,
    scene::{Quantity, Scene},
    waves::{
        ExactWave, Given, MeanStrain, Modulation, Profile, Search, Start, TravellingWave, WaveBase, WaveBranch,
        WaveContinuation, WaveNumber, WaveParameter, WavePoint, WaveSetting, WaveSpectrum,
    },
};
use hertzchain_proofs::certificate::Certificate;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::f64::consts::PI;

/// Samples of a profile. Coefficients of `X` fall like `k^{-(alpha+3)}`, so at `alpha = 3/2` those
/// beyond the samples change a coefficient by 1e-15 of the first.
const SAMPLES: usize = 2048;
/// The default scene.
const SCENE: &str = "tw-q15";
/// File with a wave as a branch of its own.
const ALONE: &str = "exact-wave.npz";
/// File with the best iterate of a search that did not converge.
const STALLED: &str = "stalled.json";

options! {
    /// The wave that is looked for.
    pub struct Wanted {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// The scene must have an initial state of kind travelling-wave. Numbers of the wave that
        /// no flag gives are taken from it [default: tw-q15].
        scene: Option<String> = None;
        /// Changes to it.
        set: Changes = Changes::default();
        /// Wave number over pi, with a whole number of waves on the ring.
        q_over_pi: Option<f64> = None, "Q", (above 0 to 1);
        /// Frequency of the wave, in radians per unit of time.
        ///
        /// Above omega = sqrt(kappa (1 + 1/rho)), or below sqrt(kappa/rho).
        omega_tw: Option<f64> = None, "W", [conflicts_with = "amplitude"];
        /// Height of the crest above the mean strain, in place of the frequency.
        amplitude: Option<f64> = None, "A", (positive);
        /// Mean strain [default: in proportion to the amplitude, as in the scene].
        mean: Option<f64> = None, "M", (finite);
        /// Mass ratio resonator to bead [default: the scene's].
        ///
        /// At least 0: 0 for no resonators, inf for fixed ones (Newton's cradle). Unless a
        /// frequency is given, the wave has the amplitude of the scene's wave. With fixed
        /// resonators its mean strain is 0.
        rho: Option<f64> = None, "R";
        /// Number of sites [default: the scene's].
        ///
        /// The multipliers are computed for a ring of this length, from 3 to 256.
        sites: Option<usize> = None, "N";
        /// Tolerance.
        tol: f64 = Search::default().tol, "T", (WAVE), [long_help = crate::study::OF_WAVE];
    }
}

/// The numbers of a wave, checked.
#[derive(Clone, Debug)]
struct Numbers {
    scene: String,
    setting: WaveSetting,
    given: Given,
    sites: usize,
    search: Search,
}

impl Wanted {
    /// The wave of a scene.
    pub fn of(scene: &str) -> Self {
        Self { scene: Some(scene.to_owned()), ..Self::default() }
    }

    /// The exact wave, and all numbers of the study of it.
    ///
    /// # Errors
    /// Numbers outside their rules; [`Error::Stalled`] where no wave is found.
    pub fn study(&self) -> Result<ExactStudy> {
        self.numbers()?.study()
    }

    fn numbers(&self) -> Result<Numbers> {
        let name = self.scene.as_deref().unwrap_or(SCENE);
        let scene = Scene::load_with(name, &self.set.set)?;
        let wave = scene.wave()?;
        let shape = wave.shape();
        let params = Params { rho: self.rho.unwrap_or(wave.params().rho), ..wave.params() };
        params.validate()?;
        self.within_ranges()?;
        let sites = self.sites.unwrap_or(scene.chain().sites());
        let q = WaveNumber::on_ring(self.q_over_pi.unwrap_or(shape.q.abs() / PI), sites)?;
        let share = match params.resonators() {
            Resonators::Fixed => MeanStrain::Value(0.0),
            _ => MeanStrain::OfAmplitude(0.5 * shape.b / (params.kappa * shape.a)),
        };
        let mean = self.mean.map_or(share, MeanStrain::Value);
        let given = match (self.amplitude, self.omega_tw, self.rho) {
            (Some(amplitude), ..) => Given::Amplitude(amplitude),
            (None, None, Some(_)) => Given::Amplitude(wave.amplitude()),
            _ => Given::Frequency,
        };
        let setting = WaveSetting { params, q, omega_tw: self.omega_tw.unwrap_or(wave.omega_tw()), mean };
        let search = Search { tol: self.tol, ..Search::default() };
        let numbers = Numbers { scene: name.to_owned(), setting: companion(setting, given)?, given, sites, search };
        numbers.setting.chain(1)?;
        Ok(numbers)
    }
}

impl Numbers {
    /// Whether resonators move.
    fn moving(&self) -> bool {
        self.setting.params.resonators() == Resonators::Moving
    }

    fn study(&self) -> Result<ExactStudy> {
        let (wave, ansatz) = self.search.wave(&self.setting, self.given)?;
        exact_study(&self.scene, wave, ansatz, self.sites, &self.search)
    }
}

/// The setting with the mean strain of the ansatz as a value: an exact wave is the companion of the
/// ansatz with the same frequency and the same mean strain. If the amplitude is given, a mean
/// strain in proportion to it is the same for both.
fn companion(setting: WaveSetting, given: Given) -> Result<WaveSetting> {
    // One harmonic has another mean strain than the exact wave of the same shape.
    let Some(ansatz) = Start::new(&setting, given)?.ansatz() else { return Ok(setting) };
    let mean = MeanStrain::Value(ansatz.epsilon() * ansatz.shape().b);
    Ok(WaveSetting { mean, ..setting })
}

options! {
    /// An exact wave, with or without a proof that it exists.
    pub struct Exact {
        /// The wave.
        wanted: Wanted = Wanted::default();
        /// The proof.
        proving: Proving = Proving::default();
        /// Prove that a perturbation grows at all Bloch wave numbers over pi between these two.
        ///
        /// Also proves bounds of the largest growth rate of these. The proof goes in pieces from
        /// multipliers of the ring, and fails where growth ends. It takes the place of the proof
        /// for the multiplier that grows fastest.
        modulation: Vec<f64> = Vec::new(), "A,B", (above 0 to 1), [requires = "prove", conflicts_with = "to_zero"];
    }
}

impl Study for Exact {
    const FILES: &'static str = "exact-wave.npz has the wave, from which `wave continue --resume` goes on. \
        stalled.json, in place of all files, with the best iterate of a search that did not converge.";

    fn optional_files() -> Vec<String> {
        vec![STALLED.to_owned()]
    }

    fn begin(&self) -> Result<Work<'_>> {
        let numbers = self.wanted.numbers()?;
        self.within_ranges()?;
        let two = self.modulation.is_empty() || matches!(self.modulation[..], [from, to] if from < to);
        require(
            two,
            "modulation",
            self.modulation.iter().map(f64::to_string).collect::<Vec<_>>().join(","),
            "two numbers, the first one below the second",
        )?;
        self.proving.file()?;
        Ok(Box::new(move |engine, _| {
            let keep = |why: &Error| keep_iterate(engine.folder(), numbers.moving(), why);
            let study = numbers.study().inspect_err(keep)?;
            let report = study.report().file(ALONE, study.npz(&numbers.search)?);
            let ExactStudy { wave, fourier, spectrum, .. } = &study;
            let certificate = |times| of_wave(wave, &fourier[0], Some(spectrum), &self.modulation, times);
            self.proving.added(report, proof::WAVE, "", &self.modulation, certificate)
        }))
    }

    fn outline() -> Option<Report> {
        Some(report::outline())
    }
}

/// Writes the best iterate of a search that did not converge, in place of what an earlier run has
/// left.
fn keep_iterate(folder: Option<&Folder>, resonators: bool, why: &Error) {
    let (Some(folder), Error::Stalled { steps, best: Some(best) }) = (folder, why) else { return };
    let Iterate { z, residual, place, .. } = &**best;
    let half = z.len() / 2;
    let arrays = if resonators { 2 } else { 1 };
    let [x, vx] = [0, half].map(|from| &z[from..from + half / arrays]);
    let [y, vy] = [0, half].map(|from| &z[from + half / arrays..from + half]);
    let kept = json!({ "steps": steps, "residual": residual, "place": place, "x": x, "y": y, "vx": vx, "vy": vy });
    let results = [report::outline(), report::branch_outline()].map(|outline| outline.files().unwrap_or_default());
    let results = results.iter().flatten().map(|(name, _)| name.as_str());
    // An error of writing is ignored: the command reports that of the search.
    let _ = folder.remove(results.chain(["exact.png", "waves.png", ALONE, WaveContinuation::NAMES[0]]));
    let _ = folder.write(STALLED, to_json(&kept).as_bytes());
}

/// An exact wave with its ansatz, profiles, multipliers and growth rates.
#[derive(Clone, Debug)]
pub struct ExactStudy {
    /// Name of the scene.
    pub scene: String,
    /// The wave.
    pub wave: ExactWave,
    /// The ansatz of the same frequency or amplitude, and of the same mean strain; `None` where
    /// resonators do not move, and below `(kappa/rho)^{1/2}`.
    pub ansatz: Option<TravellingWave>,
    /// The profiles `X` and `Y`.
    pub profile: Profile,
    /// Fourier coefficients of `X` and `Y`.
    pub fourier: [Vec<f64>; 2],
    /// Largest coefficient of a sine.
    pub odd: f64,
    /// `E_x` and `E_y` of the ansatz, over all phases.
    pub errors: Option<[f64; 2]>,
    /// Multipliers.
    pub spectrum: WaveSpectrum,
    /// Growth at the Bloch wave numbers of the ring from 0 to `pi`.
    pub growth: Vec<BlochGrowth>,
}

impl ExactStudy {
    /// The file of the wave, which may go on as a branch in its frequency, at its mean strain.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn npz(&self, search: &Search) -> Result<Vec<u8>> {
        let Self { wave, spectrum, .. } = self;
        let (parameter, omega) = (WaveParameter::OmegaTw, wave.setting.omega_tw);
        let continuation =
            WaveContinuation { parameter, to: omega.next_up(), step: omega, most_points: 2, search: *search };
        let WaveBranch { setting, continuation, .. } = continuation.begin(wave.clone(), spectrum.sites)?;
        let measures = continuation.measures(&setting, wave)?;
        let point = WavePoint { orbit: wave.clone(), spectrum: spectrum.clone(), measures };
        branch_npz(&self.scene, &branches::alone(continuation, &setting, point)?)
    }
}

/// The largest growth at a Bloch wave number, per unit of time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct BlochGrowth {
    /// Bloch wave number.
    pub bloch: f64,
    /// Growth of the exact wave.
    pub exact: f64,
    /// Growth of the ansatz, by the linearised modulation equations; `None` without an ansatz.
    pub modulation: Option<f64>,
}

/// Computes everything in [`ExactStudy`] for an exact wave.
///
/// # Errors
/// An integration that fails; a ring that does not fit the wave.
pub fn exact_study(
    scene: &str,
    wave: ExactWave,
    ansatz: Option<TravellingWave>,
    sites: usize,
    search: &Search,
) -> Result<ExactStudy> {
    let profile = wave.profile(SAMPLES, search)?;
    let (fourier, odd) = profile.fourier();
    let spectrum = wave.spectrum(sites, search)?;
    let slow = |ansatz: TravellingWave| {
        Ok::<_, Error>((Modulation::new(ansatz.params(), ansatz.shape())?, ansatz.slow_time(1.0)))
    };
    let modulation = ansatz.map(slow).transpose()?;
    let at = |j: usize| {
        let bloch = 2.0 * PI * j as f64 / sites as f64;
        let modulation = modulation.as_ref().map(|(modulation, slow)| slow * modulation.growth(bloch));
        BlochGrowth { bloch, exact: spectrum.growth(bloch), modulation }
    };
    let growth = (0..=sites / 2).map(at).collect();
    let errors = ansatz.map(|ansatz| profile.errors(&ansatz));
    let scene = scene.to_owned();
    Ok(ExactStudy { scene, wave, ansatz, profile, fourier, odd, errors, spectrum, growth })
}

options! {
    /// A branch of exact travelling waves.
    pub struct ContinueWave {
        /// The wave.
        wanted: Wanted = Wanted::default();
        /// What varies along the branch.
        ///
        /// A parameter of the wave or of the chain.
        vary: WaveParameter = WaveParameter::OmegaTw, "P", [default_value = "omega_tw"];
        /// What every branch asks for.
        branch: BranchOptions = BranchOptions::default();
        /// The proof.
        proving: Proving = Proving::default();
    } command |command| command.mut_arg("resume", |arg| arg.conflicts_with_all([
            "scene", "set", "q_over_pi", "omega_tw", "amplitude", "mean", "rho", "sites", "tol", "vary",
        ]))
}

impl FollowCommand for ContinueWave {
    type Problem = WaveContinuation;

    fn options(&self) -> (&BranchOptions, BifurcationOptions, ResultUnits) {
        (&self.branch, BifurcationOptions::default(), ResultUnits::default())
    }

    fn proving(&self) -> Option<&Proving> {
        Some(&self.proving)
    }

    fn near(&self, branch: &WaveBranch) -> Result<Vec<Certificate>> {
        let search = &branch.continuation.search;
        let near = |wave: &ExactWave| near_wave(wave, &wave.profile(SAMPLES, search)?.fourier().0[0]);
        branch.orbits.iter().map(near).collect()
    }

    fn with_options(&self, branch: WaveBranch) -> Result<WaveBranch> {
        let parameter = branch.continuation.parameter.name();
        self.proving.of_branch(parameter, WaveParameter::OmegaTw.name()).map(|()| branch)
    }

    fn first(&self) -> Result<Work<'_, Begun<WaveContinuation>>> {
        self.proving.of_branch(self.vary.name(), WaveParameter::OmegaTw.name())?;
        let mut numbers = self.wanted.numbers()?;
        // Waves of a branch keep their shape, unless the mean strain is given or varies.
        if self.wanted.mean.is_none()
            && self.vary != WaveParameter::Mean
            && let Some(ansatz) = Start::new(&numbers.setting, numbers.given)?.ansatz()
        {
            let (shape, kappa) = (ansatz.shape(), numbers.setting.params.kappa);
            numbers.setting.mean = MeanStrain::OfAmplitude(0.5 * shape.b / (kappa * shape.a));
        }
        // The value at the first wave is not known yet: a default step is infinite.
        let continuation = self.branch.continuation((None, Quantity::Number), f64::INFINITY, |to, step| {
            let (parameter, most_points, search) = (self.vary, self.branch.max_points, numbers.search);
            let continuation = WaveContinuation { parameter, to, step, most_points, search };
            continuation.check(f64::NAN, &numbers.setting).map(|()| continuation)
        })?;
        Ok(Box::new(move |engine, _| {
            let found = numbers.search.wave(&numbers.setting, numbers.given);
            let (wave, _) = found.inspect_err(|why| keep_iterate(engine.folder(), numbers.moving(), why))?;
            Ok((numbers.scene, continuation.begin(wave, numbers.sites)?, None))
        }))
    }
}

/// A branch of exact waves of a scene, of which the name is known.
pub type WaveBranchStudy = BranchStudy<WaveContinuation>;

/// What the file of a branch has of its first wave.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaveSource {
    scene: String,
    wave: WaveBase,
    /// Whether the mass ratio is infinite, which JSON has no number for.
    fixed: bool,
}

impl Kept for WaveContinuation {
    /// Name of the scene.
    type About = String;
    type Source = WaveSource;
    const NAMES: [&'static str; 3] = ["wave-branch.npz", "wave-spectra.store", "wave continue"];
    const FILES: &'static str = files_of_branch!(
        "wave-branch.npz",
        "wave-spectra.store",
        "stalled.json is there, in place of all files, if there is no first wave. "
    );
    const OPTIONAL: &'static [&'static str] = &[STALLED];
    /// Waves have no test functions of bifurcations.
    const USUAL: AnalysisLevel = AnalysisLevel::Multipliers;

    fn source(scene: &String, branch: &WaveBranch) -> (WaveSource, Vec<Array<'static>>) {
        let of = |value: fn(&WaveSetting) -> f64| branch.orbits.iter().map(|wave| value(&wave.setting)).collect();
        let arrays = vec![
            Array::vector("omega_tw", of(|one| one.omega_tw)),
            Array::vector("alpha", of(|one| one.params.alpha)),
            Array::vector("kappa", of(|one| one.params.kappa)),
            Array::vector("rho", of(|one| one.params.rho)),
        ];
        let (mut wave, fixed) = (branch.setting, branch.setting.setting.params.rho.is_infinite());
        if fixed {
            wave.setting.params.rho = 0.0;
        }
        (WaveSource { scene: scene.clone(), wave, fixed }, arrays)
    }

    fn made(source: WaveSource, _birth: Option<BifurcationKind>) -> Result<(String, WaveBase)> {
        let WaveSource { scene, mut wave, fixed } = source;
        let WaveBase { setting, size, sites } = &mut wave;
        if fixed {
            setting.params.rho = f64::INFINITY;
        }
        setting.q = WaveNumber::on_ring(setting.q.q() / PI, *sites)?;
        setting.chain(*sites / setting.q.cell())?;
        positive("size", *size)?;
        Ok((scene, wave))
    }

    fn outline() -> Report {
        report::branch_outline()
    }

    fn report(study: &WaveBranchStudy) -> Result<Report> {
        report::branch(study)
    }
}
