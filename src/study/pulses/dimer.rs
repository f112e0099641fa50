//! A pulse in a 1:1 dimer: how much of it a chain of heavy and light beads in turn lets through.
//!
//! | symbol | meaning |
//! |---|---|
//! | `m` | mass of the light beads over that of the heavy ones |
//! | `F_1, F_2` | largest contact force of a bond near the struck end and of one `cells` cells on |
//! | `T = F_2/F_1` | transmission; 1 for a solitary wave, which keeps its shape |
//!
//! At most mass ratios the light beads ring behind the pulse, which loses energy to them. At a
//! sequence of ratios they are at rest again when the pulse has passed, and it is a solitary wave:
//! the maxima at which `T` is 1. K. R. Jayaprakash, Y. Starosvetsky & A. F. Vakakis 2011, Phys.
//! Rev. E 83, 036606.

use super::{Crests, METHOD, STEP, ascending, follow, geometric, plain};
use crate::{
    chain::State,
    error::Result,
    numerics::{golden, least_by},
    report::{Digits::Fixed, Kind, Panel, Panels, Report, rows},
    study::{Progress, Study, Work, options::options, part},
    sweep::{Engine, Grid},
};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Mass ratios at which solitary waves were found, in the article cited above.
pub const PUBLISHED: [f64; 4] = [1.0, 0.3428, 0.1548, 0.0901];

/// Cells that the pulse passes before it is measured: it has then its own shape. Measured at m =
/// 0.3428: a pulse that starts as a strike loses 8e-4 of its force between cell 12 and cell 36,
/// and 1e-5 in the next 72. With 12 cells the maximum is found at 0.3414, 0.3419 and 0.3426 over
/// 24, 48 and 96 cells.
const FIRST_CELL: usize = 36;
/// Cells beyond the last that is measured, so that the end of the chain is not felt.
const BEYOND: usize = 4;
/// Accuracy of the mass ratios at maxima.
const NEAR: f64 = 2e-5;

options! {
    /// The study of a pulse in dimers.
    pub struct DimerOptions {
        /// Smallest mass ratio.
        ///
        /// Mass of the light beads over that of the heavy ones.
        from: f64 = 0.07, "M", (0.02 to 1);
        /// Largest mass ratio.
        ///
        /// Mass of the light beads over that of the heavy ones.
        to: f64 = 1.0, "M", (0.02 to 1);
        /// Number of points.
        ///
        /// Mass ratios, evenly spaced in their logarithm.
        points: usize = 120, "K", (3 to 10_000);
        /// Distance of the two bonds whose forces are compared, in cells.
        ///
        /// A cell is a heavy and a light bead.
        cells: usize = 24, "N", (4 to 1000);
    }
}

impl Study for DimerOptions {
    const FILES: &'static str = "dimer-maxima.store keeps the maxima.";
    const STORE: &'static str = "dimer.store";

    fn outline() -> Option<Report> {
        Some(DimerStudy { cells: 0, rows: Vec::new(), maxima: Vec::new() }.report())
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|engine, progress| Ok(dimer(self, engine, progress)?.report())))
    }
}

rows! {
    /// A pulse in a dimer.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    pub struct DimerRow {
        /// Mass of the light beads over that of the heavy ones.
        ratio: f64 => Fixed(4),
        /// Largest contact force near the struck end.
        first: f64,
        /// The same, the cells farther on.
        last: f64,
        /// Last over first, 1 for a solitary wave.
        transmission: f64 => Fixed(5),
    }
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct DimerStudy {
    /// Cells between the two bonds that are compared.
    pub cells: usize,
    /// A row a mass ratio, ascending.
    pub rows: Vec<DimerRow>,
    /// The maxima of the transmission inside the range, ascending; where it is 1 the pulse is a
    /// solitary wave.
    pub maxima: Vec<DimerRow>,
}

impl DimerStudy {
    /// The report.
    pub fn report(&self) -> Report {
        let known = |row: &DimerRow| PUBLISHED.into_iter().find(|known| (row.ratio / known - 1.0).abs() < 0.1);
        let rows = DimerRow::table("dimer", &self.rows).in_text([]).done();
        let source = "Jayaprakash, Starosvetsky & Vakakis 2011";
        let maxima =
            DimerRow::table("maxima", &self.maxima).key("maxima").col("published", Fixed(4), source, known).done();
        let least = least_by(&self.rows, |row| row.transmission);
        let least = least.map_or_else(String::new, |row| {
            format!("; the least of {} mass ratios is {:.5}, at {:.4}", self.rows.len(), row.transmission, row.ratio)
        });
        let range = self.rows.first().zip(self.rows.last());
        let inside = |ratio: &f64| range.is_some_and(|(low, high)| (low.ratio..=high.ratio).contains(ratio));
        let lines =
            vec![rows.line("computed", ["ratio", "transmission"]), maxima.line("maxima", ["ratio", "transmission"])];
        let mark = Some(("published, F₂/F₁ = 1".to_owned(), PUBLISHED.into_iter().filter(inside).collect()));
        let labels = ["mass ratio m, light over heavy", "transmission F₂/F₁"];
        let panel = Panel { mark, ..Panel::new(Kind::LogCloud, labels, lines) };
        let caption = format!(
            "Largest contact force of a pulse {} cells after the {FIRST_CELL}th cell, over that there, in a 1:1 dimer without \
             precompression, α = 3/2, struck by a heavy bead of speed 1; at T = 1 the pulse is a solitary wave. Published: \
             Jayaprakash, Starosvetsky & Vakakis 2011. Integrator {METHOD}, steps of {STEP}.",
            self.cells,
        );
        Report::new("dimer")
            .fact("cells", self.cells)
            .fact("first_cell", FIRST_CELL)
            .fact("integrator", METHOD)
            .fact("step", STEP)
            .table(rows)
            .table(maxima)
            .words(format!("Maxima of the transmission of a pulse over {} cells of a 1:1 dimer{least}.", self.cells))
            .picture(Panels::column(format!("A pulse through {} cells of a dimer", self.cells), vec![panel], caption))
    }
}

impl DimerOptions {
    fn check(&self) -> Result<()> {
        self.within_ranges()?;
        ascending(self.from, self.to)
    }
}

/// The transmission at every mass ratio, and its maxima. `progress` is told the share done.
///
/// ```
/// use hertzchain::study::pulse;
/// // Equal beads let a solitary wave through; at m = 0.59 the pulse decays.
/// assert!(pulse(1.0, 12)?.transmission > 0.999);
/// assert!(pulse(0.59, 12)?.transmission < 0.8);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// An option outside its rule; a run that fails; a signal.
pub fn dimer(options: &DimerOptions, engine: &Engine, progress: Progress<'_>) -> Result<DimerStudy> {
    options.check()?;
    let &DimerOptions { from, to, points, cells } = options;
    let ratios = geometric(from, to, points);
    let grid = Grid { store: DimerOptions::STORE, study: "dimer", settings: json!({"cells": cells, "step": STEP}) };
    let swept = engine.sweep(&grid, &ratios, &part(progress, 0.0, 0.8), |&ratio| pulse(ratio, cells))?;
    let rows = swept.all(&ratios, |ratio| format!("mass ratio {ratio}"))?;
    let peaks = rows.windows(3).filter(|row| {
        let [a, b, c] = [0, 1, 2].map(|k| row[k].transmission);
        a < b && b >= c
    });
    let brackets: Vec<[f64; 2]> = peaks.map(|row| [row[0].ratio, row[2].ratio]).collect();
    let grid = Grid { store: "dimer-maxima.store", ..grid };
    let swept = engine.sweep(&grid, &brackets, &part(progress, 0.8, 1.0), |&bracket| {
        Ok(golden(bracket, |apart| apart > NEAR, |ratio| pulse(ratio, cells), |row| row.transmission)?.1)
    })?;
    let maxima = swept.all(&brackets, |[low, _]| format!("maximum above the mass ratio {low}"))?;
    Ok(DimerStudy { cells, rows, maxima })
}

/// A pulse of a heavy bead with speed 1 that strikes a dimer at rest.
///
/// # Errors
/// A mass ratio that is not positive; a run that fails; a signal.
pub fn pulse(ratio: f64, cells: usize) -> Result<DimerRow> {
    pulse_by(ratio, cells, STEP)
}

/// As [`pulse`], with another step.
///
/// # Errors
/// As [`pulse`]; a step that is not positive.
pub fn pulse_by(ratio: f64, cells: usize, step: f64) -> Result<DimerRow> {
    let sites = 2 * (FIRST_CELL + cells + BEYOND);
    let chain = plain((0..sites).map(|i| if i % 2 == 0 { 1.0 } else { ratio }).collect(), Vec::new())?;
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    let bonds = [2 * FIRST_CELL, 2 * (FIRST_CELL + cells)];
    let mut crests = Crests::new(2);
    // A pulse in equal beads takes at most 1.6 units of time a bead; slower pulses have decayed.
    follow(&chain, state, (step, 8.0 * sites as f64), &mut |_, y| {
        let overlaps = chain.overlaps(chain.layout().u(y));
        crests.look(bonds.map(|bond| overlaps[bond]), |_| ());
        crests.all_passed()
    })?;
    let [first, last] = [0, 1].map(|k| chain.law().force(crests.crest[k]));
    Ok(DimerRow { ratio, first, last, transmission: last / first })
}
