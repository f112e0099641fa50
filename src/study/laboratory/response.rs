//! Linear response of a scene: transfer functions from a driven site.

use crate::study::{Changes, ResultUnits, Study, Work, options::options, scene_caption, scene_json, si::Scale};
use crate::{
    chain::{Drive, DriveKind},
    error::{Result, refuse, require},
    numerics::extremes,
    orbits,
    report::{Fixed, Kind, Line, Panel, Panels, Power, Report, Table},
    scene::{Quantity, Scene, Units},
    sweep::map,
};
use nalgebra::Complex;

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
        changes: Changes = Changes::default();
        /// Site that is driven [default: that of the scene's first drive, or 0].
        site: Option<usize> = None, "N";
        /// Whether the site is moved or pushed [default: as by the scene's first drive, or pushed].
        ///
        /// moved: the response is a displacement over that of the driven bead. pushed: it is a
        /// displacement over the force. Other beads that drives of the scene move are held.
        kind: Option<String> = None, "KIND", [value_parser = ["moved", "pushed"]];
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
        /// The units of options and results.
        results: ResultUnits = ResultUnits::default();
    }
}

/// A frequency, and the responses at it.
type Row = (f64, Vec<Complex<f64>>);

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
    fn outline() -> Option<Report> {
        let setting = Setting { site: 0, kind: DriveKind::Displacement, at: vec![9] };
        Some(Report::new("response").table(table(&[], &setting, None)))
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
        let omega = move |k: usize| from + (to - from) * k as f64 / (self.points - 1) as f64;
        Ok(Box::new(move |_, _| {
            let omegas: Vec<f64> = (0..self.points).map(omega).collect();
            // Not-a-number at the frequency of an undamped mode.
            let finite = |z: Complex<f64>| if z.is_finite() { z } else { Complex::new(f64::NAN, f64::NAN) };
            let rows = map(&omegas, |&omega| (omega, response.at(omega).into_iter().map(finite).collect()));
            Ok(told(&scene, (&setting, &response), &rows, si.as_ref()))
        }))
    }
}

/// The responses.
fn table(rows: &[Row], setting: &Setting, si: Option<&Units>) -> Table {
    let mut table = Table::of("response", rows).si(si).few(21).col("omega", Power(6), "", |row| row.0);
    table = table.kind(Quantity::Omega);
    let what = match setting.kind {
        DriveKind::Force => "displacement over the force on the driven bead",
        DriveKind::Displacement => "displacement over that of the driven bead",
    };
    for (k, at) in setting.at.iter().enumerate() {
        let about = |words: String| if k == 0 { words } else { String::new() };
        table = table
            .col(format!("gain_{at}"), Power(6), about(format!("amplitude of the {what}, and so on")), |row| {
                row.1[*at].norm()
            })
            .kind(setting.quantity())
            .col(format!("phase_{at}"), Fixed(4), about("phase ahead of the drive, in radians".to_owned()), |row| {
                row.1[*at].arg()
            });
    }
    table.done()
}

fn told(scene: &Scene, (setting, response): (&Setting, &orbits::Response), rows: &[Row], si: Option<&Units>) -> Report {
    let scale = Scale(si);
    let (kind, omega) = scale.frequency();
    let table = table(rows, setting, si);
    let x = if si.is_some() { "frequency" } else { "omega" };
    let (mut gains, mut phases) = (Vec::new(), Vec::new());
    for at in &setting.at {
        let line = |of: &str| table.line(&format!("site {at}"), [x, &format!("{of}_{at}")]);
        gains.push(line("gain"));
        phases.push(line("phase"));
    }
    let all = gains.iter().flat_map(|line| &line.points).map(|point| point.1);
    let (least, most) = extremes(all.filter(|gain| *gain > 0.0));
    let span = rows.first().zip(rows.last()).map_or(0.0..=0.0, |(first, last)| first.0..=last.0);
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
