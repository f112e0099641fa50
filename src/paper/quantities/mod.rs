//! The quantities that decide the claims of the paper: `id -> number`, section by section.
//!
//! | word | meaning |
//! |---|---|
//! | quantity | the id of a claim and our number |
//! | group | a function that computes quantities, and the runs of the full chain that it uses |
//!
//! A new quantity needs an entry in its group and a row in `claims.toml`.

pub(crate) mod measure;
mod section2;
mod section3;
mod section4;
mod section5;
mod section6;
mod section7;
mod section8;

use crate::{
    error::{Error, Result},
    interrupt,
    paper::figures::wave_study,
    study::WaveStudy,
    sweep::{Engine, Grid, Progress, map},
};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// The id of a claim, and our number.
pub(super) type Quantity = (&'static str, f64);

/// Number of perturbed waves of a run; the growth of a perturbation is the median over them.
const SEEDS: u32 = 8;

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
        wave_study(self.scene, self.mean_strain, (self.zeta > 0.0).then_some((self.zeta, SEEDS)), &|_, _| {})
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

/// The store of the points that were computed.
const STORE: &str = "verify.store";

/// A point of the sweep: groups of a section, by their numbers in its list. Groups that use runs of
/// the full chain are together, as they share these runs; each other group is a point of its own.
#[derive(Serialize)]
struct Point {
    section: u32,
    groups: Vec<usize>,
}

/// A quantity as it is kept: its number by its bits, since a number that is not finite is one too.
#[derive(Serialize, Deserialize)]
struct Memo {
    id: String,
    bits: u64,
}

impl Point {
    /// The points of a section.
    fn of(&(section, groups): &(u32, &[Group])) -> Vec<Self> {
        let (alone, together): (Vec<usize>, Vec<usize>) =
            (0..groups.len()).partition(|&number| groups[number].runs.is_empty());
        // The longest is begun first.
        let points = [together].into_iter().chain(alone.into_iter().map(|number| vec![number]));
        points.filter(|groups| !groups.is_empty()).map(|groups| Self { section, groups }).collect()
    }

    /// The quantities of each group. First the runs and then the groups are computed on all cores;
    /// the results do not depend on their number.
    fn quantities(&self) -> Result<Vec<Vec<Memo>>> {
        let all = SECTIONS.iter().filter(|(section, _)| *section == self.section).flat_map(|(_, groups)| *groups);
        let all: Vec<&Group> = all.collect();
        let groups: Vec<&Group> = self.groups.iter().map(|&number| all[number]).collect();
        let mut wanted: Vec<Run> = Vec::new();
        for run in groups.iter().flat_map(|group| group.runs) {
            if !wanted.contains(run) {
                wanted.push(*run);
            }
        }
        let runs = map(&wanted, |run| Ok((*run, run.study()?)));
        let runs = Runs(runs.into_iter().collect::<Result<_>>()?);
        let made = map(&groups, |group| (group.quantities)(&runs));
        let made = made.into_iter().collect::<Result<Vec<_>>>()?;
        if interrupt::asked() {
            // Computations that were asked to end may have returned a part of their results.
            return Err(Error::Stopped { kept: "nothing of these quantities".to_owned() });
        }
        let kept = |(id, value): (&str, f64)| Memo { id: id.to_owned(), bits: value.to_bits() };
        Ok(made.into_iter().map(|group| group.into_iter().map(kept).collect()).collect())
    }
}

/// The quantities of a section, or of all sections, in the order of the claims.
///
/// `progress` is told the share done.
///
/// # Errors
/// A run that fails, after all other points were computed; errors of the store.
pub(super) fn quantities(section: Option<u32>, engine: &Engine, progress: Progress<'_>) -> Result<Vec<(String, f64)>> {
    let chosen = SECTIONS.iter().filter(|(number, _)| section.is_none_or(|section| section == *number));
    let points: Vec<Point> = chosen.flat_map(Point::of).collect();
    let grid = Grid { store: STORE, study: "verify", settings: json!({}) };
    let swept = engine.sweep(&grid, &points, progress, Point::quantities)?;
    let rows = swept.all(&points, |Point { section, groups }| format!("section {section}, groups {groups:?}"))?;
    let mut made: Vec<((u32, usize), Vec<Memo>)> = Vec::new();
    for (Point { section, groups }, row) in points.iter().zip(rows) {
        made.extend(groups.iter().map(|&number| (*section, number)).zip(row));
    }
    made.sort_unstable_by_key(|(place, _)| *place);
    let quantity = |Memo { id, bits }: Memo| (id, f64::from_bits(bits));
    Ok(made.into_iter().flat_map(|(_, group)| group).map(quantity).collect())
}
