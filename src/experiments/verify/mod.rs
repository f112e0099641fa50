//! The paper's own numbers and statements, section by section, against ours.
//!
//! | word | meaning |
//! |---|---|
//! | item | a number or a statement of the paper, our number, and the rule by which they agree |
//! | group | a function that makes items, and the runs of the full chain that it looks at |
//! | expected | what is known of an item: that it agrees, or our number where the paper's differs |
//!
//! A group of another section is one more line of [`GROUPS`]; an item is one more line of its group.

mod item;
mod measure;
mod section3;
mod section4;
mod section5;
mod section6;
mod section7;

pub use item::{Item, Rule, Verdict};

use super::{WaveOptions, WaveStudy, wave};
use crate::{
    error::{Error, Result},
    run::method::Method,
    scene::{Initial, Scene},
    sweep::Tally,
};
use std::time::{Duration, Instant};

/// Perturbed waves of a run: what grows is judged by the median.
const SEEDS: u32 = 8;
/// Tolerance of the runs: their numbers are good to 1e-8.
const TOLERANCE: f64 = 1e-10;

/// A run of the paper: a scene, its mean strain if that is another one, its perturbation.
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

/// The runs that were made, each once.
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

/// Items of one section that come from the same numbers.
struct Group {
    section: u32,
    runs: &'static [Run],
    items: fn(&Runs) -> Result<Vec<Item>>,
}

/// All groups, in the order of the paper.
const GROUPS: &[&[Group]] = &[section3::GROUPS, section4::GROUPS, section5::GROUPS, section6::GROUPS, section7::GROUPS];

/// The table.
#[derive(Clone, Debug)]
pub struct Verification {
    /// Items in the order of the paper.
    pub items: Vec<Item>,
    /// Wall time of all of it.
    pub wall: Duration,
}

impl Verification {
    /// The items whose verdict, or number, is not the one that is known.
    pub fn unexpected(&self) -> impl Iterator<Item = &Item> {
        self.items.iter().filter(|item| !item.as_expected())
    }
}

/// Makes every number of a section, or of all sections, and holds it against the paper's. `progress` is told how many pieces of work are done of how many.
///
/// Runs that several items look at are made once; runs, then groups of items, on all cores. No number depends on how many those are.
///
/// # Errors
/// A section without items; a run that fails.
pub fn verify(section: Option<u32>, progress: &(dyn Fn(u64, u64) + Sync)) -> Result<Verification> {
    let clock = Instant::now();
    let groups = || GROUPS.iter().copied().flatten();
    let chosen: Vec<&Group> = groups().filter(|group| section.is_none_or(|section| section == group.section)).collect();
    if let (Some(section), true) = (section, chosen.is_empty()) {
        return Err(Error::parameter("section", section, "a section of the paper that has items: 3, 4, 5, 6 or 7"));
    }
    let mut wanted: Vec<Run> = Vec::new();
    for run in chosen.iter().flat_map(|group| group.runs) {
        if !wanted.contains(run) {
            wanted.push(*run);
        }
    }
    let tally = Tally::new(wanted.len() + chosen.len(), progress);
    let studies = tally.map(&wanted, |run| Ok((*run, run.study()?)));
    let runs = Runs(studies.into_iter().collect::<Result<_>>()?);
    let made = tally.map(&chosen, |group| {
        let items = (group.items)(&runs)?;
        Ok(items.into_iter().map(|item| Item { section: group.section, ..item }).collect::<Vec<_>>())
    });
    let items = made.into_iter().collect::<Result<Vec<_>>>()?.concat();
    Ok(Verification { items, wall: clock.elapsed() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_in_the_order_of_the_paper() {
        let sections: Vec<u32> = GROUPS.iter().copied().flatten().map(|group| group.section).collect();
        assert!(sections.is_sorted());
    }
}
