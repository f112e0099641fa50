//! The quantities that decide the claims of the paper: `id -> number`, section by section.
//!
//! | word | meaning |
//! |---|---|
//! | quantity | the id of a claim and our number |
//! | group | a function that computes quantities, and the runs of the full chain that it uses |
//!
//! A new quantity needs an entry in its group and a row in `claims.toml`.

mod measure;
mod section2;
mod section3;
mod section4;
mod section5;
mod section6;
mod section7;
mod section8;

use crate::{
    error::Result,
    run::method::Method,
    scene::{Initial, Scene},
    study::{WaveOptions, WaveStudy, wave},
    sweep::Tally,
};

/// The id of a claim, and our number.
pub(super) type Quantity = (&'static str, f64);

/// Number of perturbed waves of a run; the growth of a perturbation is the median over them.
const SEEDS: u32 = 8;
/// Tolerance of the runs; it gives numbers with errors of about 1e-8.
const TOLERANCE: f64 = 1e-10;

/// A run of the paper: a scene, a mean strain if it is not that of the scene, and a perturbation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    scene: &'static str,
    mean_strain: Option<f64>,
    zeta: f64,
}

impl Run {
    const fn of(scene: &'static str, zeta: f64) -> Self {
        Self { scene, mean_strain: None, zeta }
    }

    fn study(&self) -> Result<WaveStudy> {
        let mut file = Scene::load(self.scene)?.file().clone();
        if let (Initial::TravellingWave { b, .. }, Some(mean_strain)) = (&mut file.initial, self.mean_strain) {
            *b = mean_strain;
        }
        let scene = Scene::build(file)?.perturbed(self.zeta, None)?;
        let seeds = (self.zeta > 0.0).then_some(SEEDS);
        let method = Method::Collocation;
        wave(&scene, &WaveOptions { method, tolerance: TOLERANCE, samples_per_period: 50, seeds }, &|_, _| {})
    }
}

/// The finished runs, each once.
struct Runs(Vec<(Run, WaveStudy)>);

impl Runs {
    /// The study of a run.
    ///
    /// # Panics
    /// If the group did not name the run.
    fn of(&self, run: Run) -> &WaveStudy {
        let found = self.0.iter().find(|(key, _)| *key == run);
        &found.unwrap_or_else(|| panic!("a group names its runs: {run:?}")).1
    }
}

/// Quantities from the same computation.
struct Group {
    runs: &'static [Run],
    quantities: fn(&Runs) -> Result<Vec<Quantity>>,
}

impl Group {
    /// A group that uses none of the runs.
    const fn of(quantities: fn(&Runs) -> Result<Vec<Quantity>>) -> Self {
        Self { runs: &[], quantities }
    }

    const fn on(runs: &'static [Run], quantities: fn(&Runs) -> Result<Vec<Quantity>>) -> Self {
        Self { runs, quantities }
    }
}

/// The groups of each section, in the order of the paper.
const SECTIONS: [(u32, &[Group]); 7] = [
    (2, section2::GROUPS),
    (3, section3::GROUPS),
    (4, section4::GROUPS),
    (5, section5::GROUPS),
    (6, section6::GROUPS),
    (7, section7::GROUPS),
    (8, section8::GROUPS),
];

/// The quantities of a section, or of all sections, in the order of the claims.
///
/// `progress` is called with the finished and the total number of pieces of work. First the runs
/// and then the groups are computed on all cores; the results do not depend on their number.
///
/// # Errors
/// A run that fails.
pub(super) fn quantities(section: Option<u32>, progress: &(dyn Fn(u64, u64) + Sync)) -> Result<Vec<Quantity>> {
    let chosen = SECTIONS.iter().filter(|(number, _)| section.is_none_or(|section| section == *number));
    let groups: Vec<&Group> = chosen.flat_map(|(_, groups)| *groups).collect();
    let mut wanted: Vec<Run> = Vec::new();
    for run in groups.iter().flat_map(|group| group.runs) {
        if !wanted.contains(run) {
            wanted.push(*run);
        }
    }
    let tally = Tally::new(wanted.len() + groups.len(), progress);
    let studies = tally.map(&wanted, |run| Ok((*run, run.study()?)));
    let runs = Runs(studies.into_iter().collect::<Result<_>>()?);
    let made = tally.map(&groups, |group| (group.quantities)(&runs));
    Ok(made.into_iter().collect::<Result<Vec<_>>>()?.concat())
}
