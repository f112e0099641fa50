//! Linear response of a scene: transfer functions from a driven site.

use crate::study::{
    Changes, ResultUnits, Study, Work, options::options, run::error_in_file, scene_caption, scene_json, si::Scale,
};
use crate::{
    chain::{Drive, DriveKind},
    error::{Result, refuse, require},
    numerics::extremes,
    orbits,
    report::{
        Digits::{Fixed, Power},
        Kind, Line, Panel, Panels, Report, Table,
    },
    scene::{Quantity, Scene, Units},
    sweep::Grid,
};
use nalgebra::Complex;
use serde_json::json;

/// Share of the highest mode's frequency up to which responses go if no end is given.
const BEYOND: f64 = 1.2;

options! {
    /// The linear response of a scene.
    pub struct Responses {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// Its contacts hold every bead at rest: a static overlap, between walls or on a ring.
        /// Damping counts. `[initial]` may be left out.
        scene: String = "granular-crystal".to_owned();
        /// Changes to the scene.
        changes: Changes = Changes::default(), [command(flatten)];
        /// Site that is driven [default: that of the scene's first drive, or 0].
        site: Option<usize> = None, "N";
        /// Whether the site is moved or pushed [default: as by the scene's first drive, or pushed].
        ///
        /// moved: the response is a displacement over that of the driven bead. pushed: it is a
        /// displacement over the force. Other beads that drives of the scene move are held.
        kind: Option<String> = None, "KIND", [arg(value_parser = ["moved", "pushed"])];
        /// Sites whose responses are computed, separated by commas [default: the last that no drive
        /// moves].
        at: Vec<usize> = Vec::new(), "SITES";
        /// First frequency omega.
        from: f64 = 0.0, "W", (from 0);
        /// Last frequency omega [default: 1.2 times that of the highest mode].
        ///
        /// In rad/s for scenes with `[units]`, as --from.
        to: Option<f64> = None, "W", (end);
        /// Number of points.
        ///
        /// Frequencies, equally spaced.
        points: usize = 401, "K", (2 to 100_000);
        /// Run the chain as well, by a drive of this amplitude: of the displacement, or of the
        /// force.
        ///
        /// At every frequency above zero the chain starts from its static state, and the drive
        /// comes to its full height over the first quarter of --run-periods. The response is the
        /// Fourier coefficient over the last ten periods of the drive. In metres or newtons for
        /// scenes with `[units]`. Take few --points.
        by_runs: Option<f64> = None, "A", (end);
        /// Length of these runs, in periods of the drive.
        run_periods: usize = 200, "P", (20 to 1_000_000);
        /// The units of options and results.
        results: ResultUnits = ResultUnits::default(), [command(flatten)];
    }
}

/// Responses at a frequency: of the linear chain, and of runs.
struct Row {
    omega: f64,
    exact: Vec<Complex<f64>>,
    run: Option<Vec<Complex<f64>>>,
}

/// What is driven and where the response is taken.
struct Setting {
    site: usize,
    kind: DriveKind,
    at: Vec<usize>,
}

impl Setting {
    /// The kind of a response.
    fn quantity(&self) -> Quantity {
        if self.kind == DriveKind::Force { Quantity::Compliance } else { Quantity::Number }
    }
}

impl Study for Responses {
    const STORE: &'static str = "response.store";

    fn outline() -> Option<Report> {
        let setting = Setting { site: 0, kind: DriveKind::Displacement, at: vec![9] };
        Some(Report::new("response").table(table(&[], &setting, true, None)))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.within_ranges()?;
        let scene = Scene::load_at_rest(&self.scene, &self.changes.set)?;
        let chain = scene.chain();
        let first = chain.details().and_then(|details| details.drives.first());
        let kind = match self.kind.as_deref() {
            Some("moved") => DriveKind::Displacement,
            Some(_) => DriveKind::Force,
            None => first.map_or(DriveKind::Force, |drive| drive.kind),
        };
        let site = self.site.or(first.map(|drive| drive.site)).unwrap_or(0);
        let moves = |drive: &Drive| drive.kind == DriveKind::Displacement;
        let drives = || chain.details().into_iter().flat_map(|details| &details.drives);
        let held = |i: &usize| drives().any(|drive| moves(drive) && drive.site == *i);
        let last = (0..chain.sites()).rev().find(|i| !held(i)).unwrap_or(0);
        let at = if self.at.is_empty() { vec![last] } else { self.at.clone() };
        refuse("at", at.iter().find(|at| **at >= chain.sites()), "a site of the chain, counted from 0")?;
        let setting = Setting { site, kind, at };
        let response = orbits::Response::new(chain, site, kind)?;
        let (given, si) = (Scale(scene.units()), self.results.of(&scene));
        let highest = response.modes().linear().last().map_or(1.0, |mode| mode.omega);
        let from = given.read(Quantity::Omega, self.from);
        let to = self.to.map_or(BEYOND * highest, |to| given.read(Quantity::Omega, to));
        require(
            to > from,
            "to",
            format!("{} after --from {}", self.to.unwrap_or(f64::NAN), self.from),
            "above --from",
        )?;
        let of = if kind == DriveKind::Force { Quantity::Force } else { Quantity::Length };
        let amplitude = self.by_runs.map(|amplitude| given.read(of, amplitude));
        self.by_runs.map_or(Ok(()), |given| response.settles(given)).map_err(|error| error.named("by_runs"))?;
        let omega = move |k: usize| from + (to - from) * k as f64 / (self.points - 1) as f64;
        Ok(Box::new(move |engine, progress| {
            let omegas: Vec<f64> = (0..self.points).map(omega).collect();
            let settings = json!({
                "scene": scene_json(&scene), "site": setting.site, "force": kind == DriveKind::Force, "at": setting.at,
                "amplitude": amplitude, "periods": amplitude.map(|_| self.run_periods),
            });
            // Not-a-number at the frequency of an undamped mode, which JSON has no number for.
            let kept = |all: Vec<Complex<f64>>| -> Vec<Option<[f64; 2]>> {
                setting.at.iter().map(|at| all[*at].is_finite().then_some([all[*at].re, all[*at].im])).collect()
            };
            let work = |&omega: &f64| {
                let run = amplitude.filter(|_| omega > 0.0);
                let run = run.map(|amplitude| response.run(omega, amplitude, self.run_periods)).transpose();
                let run = run.map_err(|error| error_in_file(error, &scene))?;
                Ok([Some(kept(response.at(omega))), run.map(kept)])
            };
            let grid = Grid { store: Self::STORE, study: "response", settings };
            let swept = engine.sweep(&grid, &omegas, progress, work)?;
            let name = |omega: &f64| format!("omega = {}", scene.in_file(Quantity::Omega, *omega));
            let read = |kept: Vec<Option<[f64; 2]>>| -> Vec<Complex<f64>> {
                kept.into_iter()
                    .map(|one| one.map_or([f64::NAN; 2], |one| one))
                    .map(|[re, im]| Complex { re, im })
                    .collect()
            };
            let row = |(&omega, [exact, run]): (&f64, [Option<_>; 2])| Row {
                omega,
                exact: exact.map_or(Vec::new(), read),
                run: run.map(read),
            };
            let rows: Vec<Row> = swept.values(&omegas, name)?.into_iter().map(row).collect();
            Ok(told(&scene, (&setting, &response), &rows, si.as_ref()))
        }))
    }
}

/// The responses; with `runs` also those of runs.
fn table(rows: &[Row], setting: &Setting, runs: bool, si: Option<&Units>) -> Table {
    let mut table = Table::of("response", rows).si(si).few(21).col("omega", Power(6), "", |row| row.omega);
    table = table.kind(Quantity::Omega);
    let what = match setting.kind {
        DriveKind::Force => "displacement over the force on the driven bead",
        DriveKind::Displacement => "displacement over that of the driven bead",
    };
    for (k, at) in setting.at.iter().enumerate() {
        let about = |words: String| if k == 0 { words } else { String::new() };
        table = table
            .col(format!("gain_{at}"), Power(6), about(format!("amplitude of the {what}, and so on")), |row| {
                row.exact[k].norm()
            })
            .kind(setting.quantity())
            .col(format!("phase_{at}"), Fixed(4), about("phase ahead of the drive, in radians".to_owned()), |row| {
                row.exact[k].arg()
            });
        if runs {
            let of = |row: &Row| row.run.as_ref().map(|run| run[k]);
            table = table
                .col(format!("run_gain_{at}"), Power(6), about("the same of the run".to_owned()), move |row| {
                    of(row).map(|one| one.norm())
                })
                .kind(setting.quantity())
                .col(format!("run_phase_{at}"), Fixed(4), "", move |row| of(row).map(|one| one.arg()));
        }
    }
    table.done()
}

fn told(scene: &Scene, (setting, response): (&Setting, &orbits::Response), rows: &[Row], si: Option<&Units>) -> Report {
    let scale = Scale(si);
    let runs = rows.iter().any(|row| row.run.is_some());
    let (kind, omega) = scale.frequency();
    let table = table(rows, setting, runs, si);
    let x = if si.is_some() { "frequency" } else { "omega" };
    let (mut gains, mut phases) = (Vec::new(), Vec::new());
    for at in &setting.at {
        let line = |name: &str, of: &str| table.line(&format!("site {at}{name}"), [x, &format!("{of}_{at}")]);
        gains.push(line("", "gain"));
        gains.extend(runs.then(|| line(", runs", "run_gain")));
        phases.push(line("", "phase"));
    }
    let all = gains.iter().flat_map(|line| &line.points).map(|point| point.1);
    let (least, most) = extremes(all.filter(|gain| *gain > 0.0));
    let span = rows.first().zip(rows.last()).map_or(0.0..=0.0, |(first, last)| first.omega..=last.omega);
    let modes: Vec<f64> = response.modes().linear().iter().map(|mode| mode.omega).collect();
    let edges = orbits::Bands::new(scene.chain()).map_or(Vec::new(), |bands| bands.edges().concat());
    // Upright lines, with gaps between them; those of modes over a tenth of the height.
    let marks = |name: &str, omegas: &[f64], top: f64| {
        let within = omegas.iter().filter(|omega| span.contains(*omega)).map(|omega| scale.reported(kind, *omega));
        Line::new(name, within.flat_map(|omega| [(omega, least), (omega, top), (omega, f64::NAN)]))
    };
    gains.push(marks("modes", &modes, least * (most / least).powf(0.1)));
    gains.push(marks("edges of bands", &edges, most));
    gains.retain(|line| !line.points.is_empty());
    let modes = modes.iter().filter(|omega| span.contains(*omega)).count();
    let (verb, word) = match setting.kind {
        DriveKind::Force => ("pushed", "|u/F|"),
        DriveKind::Displacement => ("moved", "|u/s|"),
    };
    let label = scale.label(word, setting.quantity());
    let panels = vec![
        Panel::new(Kind::LogTime, [&omega, &label], gains),
        Panel::new(Kind::Time, [&omega, "phase (rad)"], phases),
    ];
    let how = format!("Linear response about the static state; site {} is {verb}.", setting.site);
    Report::new("response")
        .si(si)
        .fact("scene", scene.name())
        .fact("site", setting.site)
        .fact("kind", verb)
        .words(format!("{how} {modes} linear modes are between the first and the last frequency."))
        .table(table)
        .fact("scene_file", scene_json(scene))
        .warnings(scene.doubts())
        .picture(Panels::column(format!("Linear response of {}", scene.name()), panels, scene_caption(scene, &how)))
}
