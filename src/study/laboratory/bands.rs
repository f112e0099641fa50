//! Bands of a scene: the frequencies of linear waves on the infinite chain of its cell.

use crate::study::{Changes, ResultUnits, Study, Work, options::options, scene_caption, scene_json, si::Scale};
use crate::{
    error::Result,
    interrupt, orbits,
    report::{Fixed, Kind, Line, Panel, Panels, Power, Report, Short, Table},
    scene::{Quantity, Scene, Units},
    waves::Nls,
};
use std::f64::consts::PI;

options! {
    /// The bands of a scene.
    pub struct Bands {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// A cell of beads, found by the program, repeats between the ends, and contacts have a
        /// static overlap. Damping and drives do not matter; `[initial]`
        /// may be left out. Gravity is refused.
        scene: String = "precompressed".to_owned();
        /// Changes to the scene.
        changes: Changes = Changes::default();
        /// Number of points.
        ///
        /// Wave numbers, equally spaced from 0 to the edge of the zone.
        points: usize = 101, "K", (2 to 10_000);
        /// The units of results.
        results: ResultUnits = ResultUnits::default();
    }
}

#[derive(Clone, Copy, Debug)]
struct Band {
    number: usize,
    edges: [f64; 2],
    /// Width of the gap to the next band, zero if they overlap or touch.
    gap: f64,
}

impl Study for Bands {
    fn outline() -> Option<Report> {
        Some(Report::new("bands").table(edges(&[], None)).table(waves(&[], 1, None)).table(envelopes(&[], None)))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.within_ranges()?;
        let scene = Scene::load_at_rest(&self.scene, &self.changes.set)?;
        let bands = orbits::Bands::new(scene.chain());
        let bands = Scale(scene.units()).given(bands, &[("gravity", scene.file().chain.gravity)])?;
        let si = self.results.of(&scene);
        Ok(Box::new(move |_, progress| {
            let wave = |k: usize| {
                interrupt::check(0.0)?;
                progress(k as f64 / self.points as f64, "waves");
                let theta = PI * k as f64 / (self.points - 1) as f64;
                Ok((theta, bands.at(theta)))
            };
            let waves = (0..self.points).map(wave).collect::<Result<Vec<_>>>()?;
            let of = |wave: &(f64, Vec<f64>)| {
                let (overlap, all) = bands.envelopes(wave.0)?;
                Some(all.into_iter().enumerate().map(|(k, nls)| (k + 1, wave.0, overlap, nls)).collect::<Vec<_>>())
            };
            let mut all: Vec<Envelope> = waves.iter().filter_map(of).flatten().collect();
            all.sort_by_key(|envelope| envelope.0);
            let report = told(&scene, &bands, &waves, si.as_ref());
            Ok(if all.is_empty() { report } else { report.table(envelopes(&all, si.as_ref())) })
        }))
    }
}

fn edges(bands: &[Band], si: Option<&Units>) -> Table {
    Table::of("band-edges", bands)
        .key("bands")
        .si(si)
        .col("band", Short, "", |band| band.number)
        .col("omega_from", Power(9), "lowest frequency", |band| band.edges[0])
        .kind(Quantity::Omega)
        .col("omega_to", Power(9), "highest frequency", |band| band.edges[1])
        .kind(Quantity::Omega)
        .col("omega_gap", Power(3), "width of the gap above, to the next band", |band| band.gap)
        .kind(Quantity::Omega)
        .done()
}

/// The frequencies of waves, each with its phase from cell to cell; the text has about ten.
fn waves(waves: &[(f64, Vec<f64>)], bands: usize, si: Option<&Units>) -> Table {
    let mut table = Table::of("bands", waves).si(si).few(11).col(
        "theta_over_pi",
        Fixed(4),
        "phase from a cell to the next, over pi",
        |wave| wave.0 / PI,
    );
    for k in 0..bands {
        table = table
            .col(
                format!("omega_{}", k + 1),
                Power(6),
                if k == 0 { "frequency of the first band, and so on" } else { "" },
                |wave| wave.1[k],
            )
            .kind(Quantity::Omega);
    }
    table.done()
}

/// The nonlinear Schrodinger equation of a wave: its band, its phase, and the static overlap.
type Envelope = (usize, f64, f64, Nls);

/// The envelopes of small waves on chains of equal beads.
fn envelopes(all: &[Envelope], si: Option<&Units>) -> Table {
    Table::of("envelopes", all)
        .key("envelopes")
        .si(si)
        .few(11)
        .col("band", Short, "", |row| row.0)
        .col("theta_over_pi", Fixed(4), "", |row| row.1 / PI)
        .col("group_velocity", Power(6), "of envelopes, in beads per unit of time", |row| row.3.group_velocity)
        .kind(Quantity::Rate)
        .col("dispersion", Power(6), "second derivative of the frequency by theta", |row| row.3.dispersion)
        .kind(Quantity::Rate)
        .col(
            "nonlinearity",
            Power(6),
            "beta d^2 of i A_t + dispersion/2 A_xx + beta |A|^2 A = 0, with the static overlap d and displacements \
             2 |A|",
            |row| row.3.nonlinearity * row.2 * row.2,
        )
        .kind(Quantity::Rate)
        .col("focusing", Short, "whether dispersion times nonlinearity is positive: envelopes are bright", |row| {
            row.3.focusing()
        })
        .done()
}

fn told(scene: &Scene, bands: &orbits::Bands, all: &[(f64, Vec<f64>)], si: Option<&Units>) -> Report {
    let ends = bands.edges();
    let above = |k: usize| ends.get(k + 1).map_or(f64::NAN, |next| (next[0] - ends[k][1]).max(0.0));
    let rows: Vec<Band> = (0..ends.len()).map(|k| Band { number: k + 1, edges: ends[k], gap: above(k) }).collect();
    let scale = Scale(si);
    let (kind, label) = scale.frequency();
    let line = |k: usize| {
        let points = all.iter().map(|(theta, omegas)| (theta / PI, scale.reported(kind, omegas[k])));
        Line::new(&format!("band {}", k + 1), points)
    };
    let panel = Panel::new(Kind::Time, ["θ/π", &label], (0..ends.len()).map(line).collect());
    let how = format!(
        "Linear waves with the phase θ from cell to cell, on the infinite chain; beads of a cell: {}.",
        bands.cell()
    );
    let title = format!("Bands of {}", scene.name());
    Report::new("bands")
        .si(si)
        .fact("scene", scene.name())
        .fact("cell", bands.cell())
        .words(format!("Beads of a cell: {}; bands: {}.", bands.cell(), ends.len()))
        .table(edges(&rows, si))
        .table(waves(all, ends.len(), si))
        .fact("scene_file", scene_json(scene))
        .warnings(scene.doubts())
        .picture(Panels::column(title, vec![panel], scene_caption(scene, &how)))
}
