//! A solitary wave that runs into a tapered chain of spheres of one material.
//!
//! | symbol | meaning |
//! |---|---|
//! | `s` | radius of a sphere over that of the one before it |
//! | `m_n, A_n` | masses `s^{3n}`; contact constants `(2 R_{n-1} R_n/(R_{n-1} + R_n))^{1/2}` |
//! | `V_n` | largest velocity of sphere `n` |
//! | growth | slope of `ln V_n` against `n` over the second half of the tapered spheres |
//!
//! As a sequence of collisions of two spheres the pulse grows by `V_n/V_{n-1} = 2/(1 + s^3)` (U.
//! Harbola, A. Rosas, M. Esposito & K. Lindenberg 2009, Phys. Rev. E 80, 031302). If it kept its
//! energy, `V_n` would be proportional to `m_n^{-1/2}`, which is `s^{-3/2}` a sphere. Both are
//! `1 - 3 (s - 1)/2` near `s = 1`.

use super::{CREST, Crests, LEAD, METHOD, STEP, ascending, follow, plain, pulse_energy, solitary_wave};
use crate::{
    error::{Result, require},
    report::{
        Digits::{Fixed, Hidden, Json},
        Kind, Line, Panel, Panels, Report, Table, rows,
    },
    study::{Progress, Study, Work, fit_line, options::options},
    sweep::{Engine, Grid},
};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Least and largest radius that a chain may have.
const LIMITS: (f64, f64) = (1e-3, 1e3);
/// Spheres after the last that is measured, so that the free end is not felt.
const BEYOND: usize = 8;
/// The duration of a contact is proportional to `R^{13/10}` for a pulse of given energy: to
/// `(m/A)^{1/2} g^{-1/4}`, with `g` proportional to `A^{-2/5}`.
const TIME: f64 = 1.3;

options! {
    /// The study of a pulse in tapered chains.
    pub struct TaperOptions {
        /// Smallest ratio of a radius to the one before it.
        ///
        /// Below 1 spheres shrink.
        from: f64 = 0.92, "S", (0.8 to 1.25);
        /// Largest ratio of a radius to the one before it.
        to: f64 = 1.08, "S", (0.8 to 1.25);
        /// Number of points.
        ///
        /// Ratios of radii, evenly spaced.
        points: usize = 33, "K", (2 to 1000);
        /// Number of tapered spheres whose velocity is measured.
        ///
        /// So few that all radii stay between 0.001 and 1000 times the first one.
        spheres: usize = 40, "N", (10 to 200);
    }
}

rows! {
    /// A pulse in a tapered chain.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct TaperRow {
        /// Radius over that of the sphere before it, `s`.
        ratio: f64 => Fixed(4),
        /// Growth of `ln V_n` a sphere.
        growth: f64 => Fixed(6),
        /// `ln(2/(1 + s^3))`, the growth by a sequence of collisions of two spheres.
        binary: f64 => Fixed(6),
        /// `-3/2 ln s`, the growth of a pulse that keeps its energy.
        adiabatic: f64 => Fixed(6),
        /// Share of the energy that the pulse has at the last sphere that is measured.
        energy: f64 => Fixed(4),
        /// `V_n` over the velocity in the uniform chain, sphere by sphere.
        velocity: Vec<f64> => Json,
    }
}

impl TaperOptions {
    fn check(&self) -> Result<()> {
        self.within_ranges()?;
        ascending(self.from, self.to)?;
        let last = |ratio: f64| ratio.powi((self.spheres + BEYOND) as i32);
        let rule = "so few that all radii stay between 0.001 and 1000";
        require(last(self.from) >= LIMITS.0 && last(self.to) <= LIMITS.1, "spheres", self.spheres, rule)
    }
}

impl Study for TaperOptions {
    const STORE: &'static str = "taper.store";

    fn outline() -> Option<Report> {
        Some(report(&[]))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|engine, progress| Ok(report(&taper(self, engine, progress)?))))
    }
}

/// The growth at every ratio of radii, on all cores. `progress` is told the share done.
///
/// # Errors
/// An option outside its rule; a run that fails; a signal.
pub fn taper(options: &TaperOptions, engine: &Engine, progress: Progress<'_>) -> Result<Vec<TaperRow>> {
    options.check()?;
    let &TaperOptions { from, to, points, spheres } = options;
    let ratios: Vec<f64> = (0..points).map(|k| from + (to - from) * k as f64 / (points - 1) as f64).collect();
    let settings = json!({"spheres": spheres, "step": STEP});
    let grid = Grid { store: TaperOptions::STORE, study: "taper", settings };
    let swept = engine.sweep(&grid, &ratios, progress, |&ratio| tapered(ratio, spheres))?;
    swept.all(&ratios, |ratio| format!("ratio of radii {ratio}"))
}

/// The solitary wave of speed 1 that runs into `spheres` spheres, each with the radius of the one
/// before it times `ratio`.
///
/// ```
/// use hertzchain::study::tapered;
/// // In a uniform chain it keeps its velocity and its energy.
/// let same = tapered(1.0, 10)?;
/// assert!(same.growth.abs() < 1e-6 && (same.energy - 1.0).abs() < 1e-5);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A ratio that is not positive; a run that fails; a signal.
pub fn tapered(ratio: f64, spheres: usize) -> Result<TaperRow> {
    let sites = LEAD + spheres + BEYOND;
    let radius: Vec<f64> = (0..sites).map(|i| ratio.powi((i + 1).saturating_sub(LEAD) as i32)).collect();
    let constant = |pair: &[f64]| (2.0 * pair[0] * pair[1] / (pair[0] + pair[1])).sqrt();
    let chain = plain(radius.iter().map(|r| r.powi(3)).collect(), radius.windows(2).map(constant).collect())?;
    let start = solitary_wave(&chain);
    let whole = pulse_energy(&chain, start.as_slice(), CREST);
    let layout = chain.layout();
    // Velocities are taken from a sphere of the uniform chain on, which is the reference. It is
    // not the last of them, whose velocity would depend on the first tapered sphere.
    let first = CREST + 2;
    let mut crests = Crests::new(LEAD + spheres - first);
    let mut energy = 0.0;
    let least = radius[sites - 1].min(1.0).powf(TIME);
    let end = 4.0 * (LEAD as f64 + radius.iter().map(|r| r.powf(TIME)).sum::<f64>());
    follow(&chain, start, (STEP * least, end), &mut |_, y| {
        crests.look(layout.u_dot(y)[first..LEAD + spheres].iter().copied(), |k| {
            if first + k + 1 == LEAD + spheres {
                energy = pulse_energy(&chain, y, first + k) / whole;
            }
        });
        crests.all_passed()
    })?;
    let velocity: Vec<f64> = crests.crest[LEAD - first..].iter().map(|v| v / crests.crest[0]).collect();
    let second_half: Vec<_> = (spheres / 2..spheres).map(|n| (n as f64, velocity[n].ln())).collect();
    let growth = fit_line(&second_half).map_or(f64::NAN, |(slope, _)| slope);
    let (binary, adiabatic) = ((2.0 / (1.0 + ratio.powi(3))).ln(), -1.5 * ratio.ln());
    Ok(TaperRow { ratio, growth, binary, adiabatic, energy, velocity })
}

fn report(rows: &[TaperRow]) -> Report {
    let table = TaperRow::table("taper", rows).done();
    let all = |row: &TaperRow| {
        let ratio = row.ratio;
        row.velocity.iter().enumerate().map(move |(n, velocity)| (ratio, n + 1, *velocity)).collect::<Vec<_>>()
    };
    let velocities = Table::of("velocities", &rows.iter().flat_map(all).collect::<Vec<_>>())
        .key("")
        .col("ratio", Hidden, "ratio of radii", |row| row.0)
        .col("sphere", Hidden, "number of the tapered sphere, from 1", |row| row.1)
        .col("velocity", Hidden, "largest velocity over that in the uniform chain", |row| row.2)
        .done();
    let label = "radius over that of the sphere before it";
    // Without a taper nothing grows.
    let over = |name: &str, of: fn(&TaperRow) -> f64| {
        let tapered = rows.iter().filter(|row| (row.ratio - 1.0).abs() > 1e-9);
        Line::new(name, tapered.map(|row| (row.ratio, of(row) / row.binary)))
    };
    let growth = vec![over("computed", |row| row.growth), over("same energy", |row| row.adiabatic)];
    let plots = vec![
        Panel::new(Kind::Parameter, [label, "growth over that by collisions"], growth),
        table.panel(
            Kind::Parameter,
            [label, "energy of the pulse"],
            "ratio",
            &[("share at the last sphere", "energy")],
        ),
    ];
    let caption = format!(
        "A solitary wave of the uniform chain, α = 3/2, without precompression, runs into spheres of one material whose \
             radii are a geometric sequence. Above: growth of ln Vₙ from sphere to sphere, Vₙ the largest velocity, over the second half of them, divided by \
             ln(2/(1 + s³)), that of a sequence of collisions of two spheres; the same of −3/2 ln s, of a pulse that keeps its energy. \
             Below: energy in {} sites about the crest when it is at the last of {} spheres. Integrator {METHOD}, steps of \
             {STEP}, shorter for small spheres.",
        2 * super::HALF_PULSE,
        rows.first().map_or(0, |row| row.velocity.len()),
    );
    Report::new("taper")
        .fact("integrator", METHOD)
        .fact("step", STEP)
        .table(table)
        .table(velocities)
        .picture(Panels::column("A pulse in a tapered chain", plots, caption))
}
