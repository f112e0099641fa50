//! The figures of the paper, and some additional ones.
//!
//! A figure is a row of [`FIGURES`]. [`Figure::data`] computes its numbers; [`Figure::caption`],
//! [`Figure::tables`] and [`Figure::png`] turn them into text, CSV and a picture. Each of the other
//! files does all of this for one kind of figure.

mod dark;
mod drawn;
mod exact;
mod heavy;
mod orbits;
mod rows;
mod waves;

pub use drawn::{Drawn, figures_json, figures_table};
pub(super) use exact::limit_wave;
pub use exact::{ExactData, ExactRecipe, LimitWave};
pub use orbits::{DoublingData, EvolutionRun, FloquetData, MassRatioData, OrbitData, OrbitRecipe, ProfileData};
pub use rows::FIGURES;
pub use waves::{WaveColumn, WavePanel, WaveRun};

use crate::{
    dps::{DarkProfile, Homoclinic},
    error::{Error, Result},
    output::to_json,
    study::{BrightHistory, BrightStudy, LifetimeStudy, StabilityStudy, TheoremStudy, WaveStudy, center_word},
};
use serde_json::json;

/// Integrator of all runs of the chain.
const INTEGRATOR: &str = "collocation";

/// A figure of the paper.
#[derive(Debug)]
pub struct Figure {
    /// Short name of the figure on the command line and in file names.
    pub name: &'static str,
    /// Figure or section of the paper.
    pub source: &'static str,
    /// Title.
    pub title: &'static str,
    /// What the figure shows, in a sentence or two.
    pub claim: &'static str,
    /// Kind and parameters of the computation.
    pub recipe: Recipe,
}

/// Kind and parameters of the computation of a figure, and its layout.
#[derive(Debug)]
pub enum Recipe {
    /// Travelling waves on the chain.
    Waves {
        /// The runs.
        runs: &'static [WaveRun],
        /// The columns of panels.
        columns: &'static [WaveColumn],
    },
    /// Growth of the modulations of the wave `q = pi/5`, `a = b = 1`, on rings of 50 sites.
    Growth {
        /// Mass ratio.
        rho: f64,
        /// Sizes at which growth is measured on the full chain.
        epsilons: &'static [f64],
    },
    /// Dark profiles at `alpha = 3/2, kappa = 1`, with the kink on a site and on a bond.
    Dark {
        /// Sites of the ring.
        sites: usize,
        /// Mean strain of the background.
        c: f64,
    },
    /// Suprema of Theorem 1 for the breather about a bond, `T = 1`, with both laws of the mass
    /// ratio.
    Bounds {
        /// Exponents, and the sizes for each of them.
        cases: &'static [(f64, &'static [f64])],
    },
    /// Homoclinic solutions about a site and about a bond.
    Homoclinics {
        /// Exponent.
        alpha: f64,
    },
    /// The long-lived bright breather of Sec. 5 compared with its ansatz.
    Bright,
    /// The long-lived bright breather of Sec. 5 against site and time.
    BrightHistory,
    /// Lifetimes of bright breathers about a bond at `alpha = 3/2`, by the energy criterion.
    Lifetimes {
        /// Sizes.
        epsilons: &'static [f64],
        /// Mass ratios.
        rhos: &'static [f64],
        /// Longest time up to which a breather is followed.
        until: f64,
    },
    /// Dark breathers as exact orbits.
    Orbits(OrbitRecipe),
    /// Exact travelling waves.
    Exact(ExactRecipe),
}

/// The numbers of a figure.
#[derive(Debug)]
pub enum Data {
    /// Travelling waves, one study for each run.
    Waves(&'static [WaveColumn], Vec<(&'static WaveRun, WaveStudy)>),
    /// Growth of modulations.
    Growth(Box<StabilityStudy>),
    /// Dark profiles.
    Dark(Vec<DarkProfile>),
    /// Suprema of Theorem 1: for each exponent, a study for each law of the mass ratio.
    Bounds(Vec<[TheoremStudy; 2]>),
    /// Homoclinic solutions, about a site and about a bond.
    Homoclinics([Homoclinic; 2]),
    /// The bright breather.
    Bright(Box<BrightStudy>),
    /// The bright breather against site and time.
    BrightHistory(Box<BrightHistory>),
    /// Lifetimes.
    Lifetimes(Box<LifetimeStudy>),
    /// Exact orbits.
    Orbits(Box<OrbitData>),
    /// Exact travelling waves.
    Exact(Box<ExactData>),
}

/// Tables of a part of a figure: `(end of the file name, CSV)`.
type Tables = Vec<(&'static str, Vec<u8>)>;

impl Figure {
    /// The figure with the given name.
    ///
    /// # Errors
    /// An unknown name; the message has the nearest known one.
    pub fn named(name: &str) -> Result<&'static Self> {
        let known = || FIGURES.iter().map(|figure| figure.name);
        FIGURES.iter().find(|figure| figure.name == name).ok_or_else(|| Error::unknown("figure", name, known()))
    }

    /// Computes the numbers of the figure; they do not depend on the number of cores.
    ///
    /// `progress` is called with the finished share of the work.
    ///
    /// # Errors
    /// A run that fails.
    pub fn data(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<Data> {
        Ok(match self.recipe {
            Recipe::Waves { runs, columns } => Data::Waves(columns, waves::studies(runs, progress)?),
            Recipe::Growth { rho, epsilons } => Data::Growth(Box::new(waves::growth(rho, epsilons, progress)?)),
            Recipe::Dark { sites, c } => Data::Dark(dark::profiles(sites, c)?),
            Recipe::Bounds { cases } => Data::Bounds(heavy::bounds(cases, progress)?),
            Recipe::Homoclinics { alpha } => Data::Homoclinics(heavy::homoclinics(alpha)?),
            Recipe::Bright => Data::Bright(Box::new(heavy::bright(progress)?)),
            Recipe::BrightHistory => Data::BrightHistory(Box::new(heavy::history(progress)?)),
            Recipe::Lifetimes { epsilons, rhos, until } => {
                Data::Lifetimes(Box::new(heavy::lifetime_map(epsilons, rhos, until, progress)?))
            }
            Recipe::Orbits(ref recipe) => Data::Orbits(Box::new(recipe.data(progress)?)),
            Recipe::Exact(ref recipe) => Data::Exact(Box::new(recipe.data(progress)?)),
        })
    }

    /// The caption: what the figure shows, what was run and how, and what was measured.
    pub fn caption(&self, data: &Data) -> String {
        let what = match data {
            Data::Waves(columns, runs) => waves::waves_caption(columns, runs),
            Data::Growth(study) => format!("{} hertzchain {}.", study.caption(), env!("CARGO_PKG_VERSION")),
            Data::Dark(profiles) => dark::dark_caption(profiles),
            Data::Bounds(pairs) => heavy::bounds_caption(pairs),
            Data::Homoclinics(both) => heavy::homoclinics_caption(both),
            Data::Bright(study) => heavy::bright_caption(study),
            Data::BrightHistory(history) => heavy::history_caption(history),
            Data::Lifetimes(study) => heavy::lifetimes_caption(study),
            Data::Orbits(data) => orbits::orbit_caption(data),
            Data::Exact(data) => exact::exact_words(data),
        };
        format!("{} {what} Paper: {}.", self.claim, self.source)
    }

    /// The tables of the figure, `(file name, CSV)`: those of the command that computes the same
    /// data, or the profiles.
    pub fn tables(&self, data: &Data) -> Vec<(String, Vec<u8>)> {
        let told = |tag: &str, tables: Vec<(String, Vec<u8>)>| {
            let dash = if tag.is_empty() { "" } else { "-" };
            let name = |table: String| format!("{}{dash}{tag}-{table}", self.name);
            tables.into_iter().map(|(table, bytes)| (name(table), bytes)).collect::<Vec<_>>()
        };
        let named = |tag: &str, tables: Tables| {
            told(tag, tables.into_iter().map(|(table, bytes)| (table.to_owned(), bytes)).collect())
        };
        match data {
            Data::Waves(_, runs) => {
                let csv = |study: &WaveStudy| {
                    let tables = study.tables().into_iter();
                    tables.map(|table| (format!("{}.csv", table.name()), table.csv().into_bytes())).collect()
                };
                runs.iter().flat_map(|(run, study)| told(run.tag, csv(study))).collect()
            }
            Data::Growth(study) => told("", study.report().csv().collect()),
            Data::Dark(profiles) => {
                profiles.iter().flat_map(|one| named(center_word(one.center()), vec![dark::dark_csv(one)])).collect()
            }
            Data::Bounds(pairs) => {
                let tables = |study| named(&heavy::bounds_tag(study), heavy::bounds_csv(study));
                pairs.iter().flatten().flat_map(tables).collect()
            }
            Data::Homoclinics(both) => {
                let table = |one| named(center_word(Homoclinic::center(one)), vec![heavy::homoclinic_csv(one)]);
                both.iter().flat_map(table).collect()
            }
            Data::Bright(study) => {
                study.report().csv().map(|(table, bytes)| (format!("{}-{table}", self.name), bytes)).collect()
            }
            Data::BrightHistory(history) => named("", heavy::history_csv(history)),
            Data::Lifetimes(study) => vec![(format!("{}.csv", self.name), study.table().csv().into_bytes())],
            Data::Orbits(data) => {
                orbits::orbit_tables(data).into_iter().flat_map(|(tag, tables)| named(&tag, tables)).collect()
            }
            Data::Exact(data) => {
                exact::exact_files(data).into_iter().flat_map(|(tag, tables)| told(&tag, tables)).collect()
            }
        }
    }

    /// The origin of a figure and its tables as JSON: `name`, `source`, `title`, `caption` with all
    /// parameters, `version`.
    pub fn origin(&self, caption: &str) -> String {
        to_json(&json!({
            "name": self.name,
            "source": self.source,
            "title": self.title,
            "caption": caption,
            "version": env!("CARGO_PKG_VERSION"),
        }))
    }

    /// The picture.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    #[cfg(feature = "plot")]
    pub fn picture(&self, data: &Data) -> Result<crate::figures::Picture> {
        use crate::figures::{growth, maps, panels};
        let (title, caption) = (self.title, self.caption(data));
        Ok(match data {
            Data::Waves(columns, runs) => panels(&waves::wave_panels(title, columns, runs, caption))?,
            Data::Growth(study) => growth(&study.figure(caption))?,
            Data::Dark(profiles) => panels(&dark::dark_panels(title, profiles, caption))?,
            Data::Bounds(pairs) => panels(&heavy::bounds_panels(title, pairs, caption))?,
            Data::Homoclinics(both) => panels(&heavy::homoclinic_panels(title, both, caption))?,
            Data::Bright(study) => panels(&heavy::bright_panels(title, study, caption))?,
            Data::BrightHistory(history) => panels(&heavy::history_panels(title, history, caption))?,
            Data::Lifetimes(study) => maps(&heavy::lifetime_maps(title, study, caption))?,
            Data::Orbits(data) => panels(&orbits::orbit_panels(title, data, caption))?,
            Data::Exact(data) => panels(&exact::exact_panels(title, data, caption))?,
        })
    }
}
