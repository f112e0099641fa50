//! Exact travelling waves, which Sec. 8 of the paper leaves open.

use crate::{
    chain::Params,
    error::Result,
    number::{shown, written},
    output::csv,
    study::{
        Barrier, BarrierStudy, ContinueWave, ExactStudy, File, Moving, MovingStudy, Progress, Solitary, SolitaryStudy,
        Wanted, WaveBranchStudy, exact_study, fit_line,
    },
    waves::{
        Given, MeanStrain, Search, Shape, Size, TravellingWave, WaveNumber, WaveParameter, WavePoint, WaveSetting,
    },
};
/// Sites of the ring for waves of decreasing size, `q = pi/5`.
const SITES: usize = 10;

/// Kind and parameters of a figure of exact travelling waves.
#[derive(Debug)]
pub enum ExactRecipe {
    /// The exact companion of the wave of a scene.
    Wave {
        /// Name of a built-in scene.
        scene: &'static str,
    },
    /// Branches in the frequency, with the ratio of mean strain to amplitude of the scene.
    Branches {
        /// The branches: name of a built-in scene, heading, ends as differences from `omega`.
        runs: &'static [(&'static str, &'static str, [f64; 2])],
    },
    /// Waves of decreasing size, `q = pi/5`, `a = b = 1`, against the modulation equations.
    Limits {
        /// Mass ratios.
        rhos: &'static [f64],
        /// Sizes.
        epsilons: &'static [f64],
    },
    /// Solitary waves at `alpha = 3/2`, `kappa = 1`.
    Solitary,
    /// The barrier between dark breathers, on rings of 41 sites.
    Barrier {
        /// Mass ratio, ends of the frequency, and number of frequencies.
        runs: &'static [(f64, [f64; 2], usize)],
    },
    /// Moving dark breathers at `rho = 1/3`, on rings of 41 sites.
    Moving {
        /// Frequencies and turns of each run, and the end of its kicked run.
        runs: &'static [(&'static [f64], &'static [u32], f64)],
    },
}

/// The numbers of a figure of exact travelling waves.
#[derive(Debug)]
pub enum ExactData {
    /// A wave.
    Wave(Box<ExactStudy>),
    /// Branches with their headings.
    Branches(Vec<(&'static str, WaveBranchStudy)>),
    /// Waves of decreasing size.
    Limits(Vec<LimitWave>),
    /// Solitary waves.
    Solitary(Box<SolitaryStudy>),
    /// The barrier at each mass ratio.
    Barrier(Vec<BarrierStudy>),
    /// Moving breathers.
    Moving(Vec<MovingStudy>),
}

/// An exact wave against the modulation equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitWave {
    /// Mass ratio.
    pub rho: f64,
    /// `epsilon` of the ansatz.
    pub epsilon: f64,
    /// `E_x` and `E_y` of the ansatz.
    pub errors: [f64; 2],
    /// Growth at the Bloch wave number `pi`, per unit of time.
    pub growth: f64,
    /// The growth there by the modulation equations, per unit of time.
    pub modulation: f64,
}

impl LimitWave {
    /// Relative difference of the growth from that of the modulation equations.
    pub fn apart(&self) -> f64 {
        self.growth / self.modulation - 1.0
    }
}

/// The exact companion of the wave `q = pi/5`, `a = b = 1`, `alpha = 3/2`, `kappa = 1` of this
/// size.
pub(in super::super) fn limit_wave(rho: f64, epsilon: f64) -> Result<LimitWave> {
    let (params, q, search) = (Params::new(1.5, 1.0, rho)?, WaveNumber::on_ring(0.2, SITES)?, Search::default());
    let shape = Shape { q: q.q(), a: 1.0, b: 1.0, phi: 0.0 };
    let wave = TravellingWave::new(params, shape, Size::Epsilon(epsilon))?;
    let setting = WaveSetting { params, q, omega_tw: wave.omega_tw(), mean: MeanStrain::Value(epsilon) };
    let (exact, ansatz) = search.wave(&setting, Given::Frequency)?;
    let study = exact_study("", exact, ansatz, SITES, &search)?;
    let last = study.growth.last().copied();
    let growth = last.map_or(f64::NAN, |row| row.exact);
    let modulation = last.and_then(|row| row.modulation).unwrap_or(f64::NAN);
    Ok(LimitWave { rho, epsilon, errors: study.errors.unwrap_or([f64::NAN; 2]), growth, modulation })
}

impl ExactRecipe {
    pub(super) fn data(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<ExactData> {
        match *self {
            Self::Wave { scene } => Ok(ExactData::Wave(Box::new(Wanted::of(scene).study()?))),
            Self::Branches { runs } => {
                let of = |&(scene, heading, above): &(&str, &'static str, [f64; 2]), tell: Progress<'_>| {
                    Ok((heading, branch(scene, above)?.branch(tell)?))
                };
                each(runs, progress, of).map(ExactData::Branches)
            }
            Self::Limits { rhos, epsilons } => {
                let both = rhos.iter().flat_map(|&rho| epsilons.iter().map(move |&epsilon| (rho, epsilon)));
                both.map(|(rho, epsilon)| limit_wave(rho, epsilon)).collect::<Result<_>>().map(ExactData::Limits)
            }
            Self::Solitary => Ok(ExactData::Solitary(Box::new(Solitary::default().study()?))),
            Self::Barrier { runs } => {
                each(runs, progress, |&(rho, ends, points), tell| Barrier::of(rho, ends, points).study(tell))
                    .map(ExactData::Barrier)
            }
            Self::Moving { runs } => {
                let of = |&(omega_b, turns, until): &(&[f64], &[u32], f64), tell: Progress<'_>| {
                    let (omega_b, turns) = (omega_b.to_vec(), turns.to_vec());
                    Moving { omega_b, turns, until, ..Moving::default() }.study(tell)
                };
                each(runs, progress, of).map(ExactData::Moving)
            }
        }
    }
}

/// A study for each run.
fn each<R, S>(
    runs: &[R],
    progress: &(dyn Fn(f64) + Sync),
    study: impl Fn(&R, Progress<'_>) -> Result<S>,
) -> Result<Vec<S>> {
    let count = runs.len() as f64;
    let of = |(k, run)| study(run, &|share, _| progress((k as f64 + share) / count));
    runs.iter().enumerate().map(of).collect()
}

/// The branch between two differences of `omega_tw` from `omega`.
fn branch(scene: &str, [from, to]: [f64; 2]) -> Result<ContinueWave> {
    let omega = crate::scene::Scene::load(scene)?.chain().params().omega();
    let wanted = Wanted { omega_tw: Some(omega + from), ..Wanted::of(scene) };
    Ok(ContinueWave { wanted, vary: WaveParameter::OmegaTw, to: Some(omega + to), step: None, waves: 500 })
}

/// Slope of the logarithms over all sizes.
fn slope(waves: &[LimitWave], of: impl Fn(&LimitWave) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = waves.iter().map(|wave| (wave.epsilon.ln(), of(wave).ln())).collect();
    fit_line(&points).map_or(f64::NAN, |(slope, _)| slope)
}

/// The waves of each mass ratio.
fn by_rho(waves: &[LimitWave]) -> impl Iterator<Item = &[LimitWave]> {
    waves.chunk_by(|a, b| a.rho == b.rho)
}

pub(super) fn exact_words(data: &ExactData) -> String {
    let words = match data {
        ExactData::Wave(study) => study.caption(),
        ExactData::Branches(branches) => {
            let words = |(heading, study): &(&str, WaveBranchStudy)| {
                let fast = |one: &&WavePoint| {
                    one.spectrum
                        .fastest()
                        .is_some_and(|fastest| fastest.growth > 2.0 * one.measures.modulation.unwrap_or(0.0))
                };
                let grows = study.branch.points.iter().find(fast).map_or("growth near that of DpS".to_owned(), |one| {
                    let (omega_tw, amplitude) = (one.orbit.setting.omega_tw, shown(one.orbit.amplitude()));
                    format!("growth more than twice that of DpS from ω_tw = {omega_tw:.5}, amplitude {amplitude}, on")
                });
                format!("{heading}: {} waves, {grows}. ", study.branch.points.len())
            };
            let params = branches.first().and_then(|(_, study)| study.branch.points.first());
            let params = params.map_or(String::new(), |one| crate::study::params_words(one.orbit.setting.params));
            let sites = branches.first().map_or(0, |(_, study)| study.branch.setting.sites);
            format!(
                "{params}, N = {sites}, mean strain half the amplitude. {}",
                branches.iter().map(words).collect::<String>().trim_end()
            )
        }
        ExactData::Limits(waves) => {
            let words = |waves: &[LimitWave]| {
                let [x, y, growth] = [
                    slope(waves, |wave| wave.errors[0]),
                    slope(waves, |wave| wave.errors[1]),
                    slope(waves, |wave| wave.apart().abs()),
                ];
                format!("ρ = {}: {x:.3}, {y:.3}, {growth:.3}; ", written(waves[0].rho))
            };
            let slopes = by_rho(waves).map(words).collect::<String>();
            format!(
                "q = π/5, a = b = 1, α = 3/2, κ = 1, ring of {SITES} sites. Slopes of E_x, E_y and of the difference of the growth at p = π: {}.",
                slopes.trim_end_matches("; ")
            )
        }
        ExactData::Solitary(study) => study.caption(),
        ExactData::Barrier(studies) => studies.iter().map(BarrierStudy::caption).collect::<Vec<_>>().join(" "),
        ExactData::Moving(studies) => studies.iter().map(MovingStudy::caption).collect::<Vec<_>>().join(" "),
    };
    format!("{words} hertzchain {}.", env!("CARGO_PKG_VERSION"))
}

pub(super) fn exact_files(data: &ExactData) -> Vec<(String, Vec<File>)> {
    match data {
        ExactData::Wave(study) => vec![(String::new(), study.report().csv().collect())],
        ExactData::Branches(branches) => {
            branches.iter().map(|(_, study)| (study.scene.clone(), study.report().csv().collect())).collect()
        }
        ExactData::Limits(waves) => {
            let row = |wave: &LimitWave| {
                let &LimitWave { rho, epsilon, errors: [e_x, e_y], growth, modulation } = wave;
                vec![rho, epsilon, e_x, e_y, growth, modulation]
            };
            let names = ["rho", "epsilon", "e_x", "e_y", "growth", "modulation"];
            vec![(String::new(), vec![("limits.csv".to_owned(), csv(&names, waves.iter().map(row)))])]
        }
        ExactData::Solitary(study) => vec![(String::new(), study.report().csv().collect())],
        ExactData::Barrier(studies) => {
            let tag = |study: &BarrierStudy| format!("rho{:.2}", study.options.ring.rho);
            studies.iter().map(|study| (tag(study), study.report().csv().collect())).collect()
        }
        ExactData::Moving(studies) => {
            let tag = |k: usize| if k == 0 { String::new() } else { "frequencies".to_owned() };
            studies.iter().enumerate().map(|(k, study)| (tag(k), study.report().csv().collect())).collect()
        }
    }
}

/// The panels of a figure of exact waves.
#[cfg(feature = "plot")]
pub(super) fn exact_panels(title: &str, data: &ExactData, caption: String) -> crate::figures::Panels {
    use crate::figures::{Column, Kind, Line, Panel, Panels};
    let columns = match data {
        ExactData::Wave(study) => study.columns(),
        ExactData::Branches(branches) => {
            let column = |(heading, study): &(&str, WaveBranchStudy)| Column::new(*heading, study.panels());
            branches.iter().map(column).collect()
        }
        ExactData::Limits(waves) => {
            let panel = |label: &str, of: &dyn Fn(&LimitWave) -> f64| {
                let line = |waves: &[LimitWave]| {
                    let name = format!("ρ = {}", written(waves[0].rho));
                    Line::new(&name, waves.iter().map(|wave| (wave.epsilon, of(wave))))
                };
                let mut lines: Vec<Line> = by_rho(waves).map(line).collect();
                let root = by_rho(waves).next().unwrap_or_default();
                lines.push(Line::new("√ε/10", root.iter().map(|wave| (wave.epsilon, 0.1 * wave.epsilon.sqrt()))));
                Panel::new(Kind::LogLog, ["size ε", label], lines)
            };
            let errors = panel("E_x of the ansatz", &|wave| wave.errors[0]);
            let growth = panel("|growth / DpS growth − 1| at p = π", &|wave| wave.apart().abs());
            vec![Column::new("", [errors]), Column::new("", [growth])]
        }
        ExactData::Solitary(study) => study.columns(),
        ExactData::Barrier(studies) => studies.iter().map(BarrierStudy::column).collect(),
        // Of the first study profiles, tails and depths; of the others tails and depths only.
        ExactData::Moving(studies) => {
            let columns = |(k, study)| MovingStudy::columns(study).into_iter().skip(k);
            studies.iter().enumerate().flat_map(|(k, study)| columns((usize::from(k > 0), study))).collect()
        }
    };
    Panels { title: title.to_owned(), columns, caption }
}
