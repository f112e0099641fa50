//! What orbits of driven scenes and their branches report.

use super::{DrivenBranchStudy, DrivenStudy, quantity};
use crate::{
    error::Result,
    orbits::{
        Bifurcation, DriveParameter, DrivenBranch, DrivenContinuation, DrivenMultiplier, DrivenOrbit, DrivenSetting,
        DrivenSpectrum,
    },
    report::{Column, Fixed, Hidden, Json, Kind, Line, Panel, Panels, Power, Report, Rows, Short, Table, fields},
    scene::{Quantity, Units},
    study::{
        format_short,
        orbits::branches::{self, BranchRow, SWITCHED, crossed},
        scene_caption, scene_json,
        si::Scale,
    },
};
use serde_json::json;

/// Number of leading multipliers, one of each conjugate pair, that text and JSON show.
const LEADING: usize = 6;
/// Multipliers are shown with ten decimals; smaller ones, and those below their error, are not.
const SHOWN: f64 = 5e-11;
/// The tables of a branch: points and bifurcations.
const BRANCH: [&str; 2] = ["driven-branch", "bifurcations"];
/// What the first column of their numbers is.
const VARIED: &str = "what varies along the branch";
/// Name of the integrator of driven orbits.
const METHOD: &str = "dop853-regularised";

fn leading(spectrum: &DrivenSpectrum) -> Vec<&DrivenMultiplier> {
    spectrum.multipliers.iter().filter(|one| one.im >= 0.0).take(LEADING).collect()
}

/// The table of some orbits of a branch in a parameter.
fn points<'a>(
    name: &str,
    points: &'a [BranchRow<'a, DrivenContinuation>],
    varied: DriveParameter,
    si: Option<&Units>,
) -> Rows<'a, BranchRow<'a, DrivenContinuation>> {
    let mut table = Table::of(name, points).si(si);
    let all = [DriveParameter::Amplitude, DriveParameter::Omega, DriveParameter::Damping];
    for parameter in std::iter::once(varied).chain(all.into_iter().filter(|one| *one != varied)) {
        let (digits, about) = if parameter == varied { (Fixed(8), VARIED) } else { (Json, "") };
        let kind = points.first().map_or(Quantity::Number, |row| quantity(parameter, &row.orbit.setting));
        table = table.col(parameter.name(), digits, about, |row| row.orbit.setting.get(parameter)).kind(kind);
    }
    table
        .col("response", Power(6), "largest half range of a free bead", |row| Some(row.measures?.amplitude))
        .kind(Quantity::Length)
        .col("max_modulus", Fixed(8), "largest modulus of a multiplier", |row| Some(row.spectrum?.largest()))
        .col("unstable", Short, "multipliers outside the unit circle", |row| Some(row.spectrum?.unstable()))
        .col("turns", Json, "", |row| u64::from(row.orbit.setting.turns()))
        .col("least_turns", Json, "", |row| json!(row.measures.map(|measures| measures.least_turns)))
        .col("period", Json, "", |row| row.orbit.setting.period())
        .kind(Quantity::Time)
        .col("residual", Json, "", |row| row.orbit.residual)
        .col("leading", Json, "", |row| json!(row.spectrum.map(leading)))
        .col("liouville", Json, "", |row| Some(row.spectrum?.liouville))
}

/// The bifurcations of a branch in a parameter, whose values are of a kind.
fn bifurcations<'a>(
    name: &str,
    all: &'a [Bifurcation<DrivenContinuation>],
    (varied, kind): (DriveParameter, Quantity),
    si: Option<&Units>,
) -> Rows<'a, Bifurcation<DrivenContinuation>> {
    branches::numbered(Table::of(name, all).si(si))
        .col("kind", Short, "", |one| one.kind.name())
        .col(varied.name(), Fixed(8), VARIED, |one| one.parameter)
        .kind(kind)
        .col("response", Hidden, "largest half range of a free bead", |one| one.critical.amplitude)
        .kind(Quantity::Length)
        .col("re", Fixed(6), "real part of the multiplier", |one| one.critical.multiplier.re)
        .col("im", Fixed(6), "imaginary part", |one| one.critical.multiplier.im)
        .col("multiplier", Json, "", |one| json!(one.critical.multiplier))
        .col("parameter", Json, "", |one| Scale(si).reported(kind, one.parameter))
        .col("omega", Json, "", |one| one.orbit.setting.omega())
        .kind(Quantity::Omega)
}

pub(super) fn outline() -> Report {
    let varied = DriveParameter::Amplitude;
    let report = Report::new("driven-branch").table(points(BRANCH[0], &[], varied, None));
    report.table(bifurcations(BRANCH[1], &[], (varied, Quantity::Number), None))
}

/// Leading multipliers of an orbit.
pub(super) fn multipliers(rows: &[&DrivenMultiplier]) -> Table {
    let seen = |value: fn(&DrivenMultiplier) -> f64| {
        move |one: &&DrivenMultiplier| (one.modulus > one.error.max(SHOWN)).then_some(value(one))
    };
    Table::of("leading-multipliers", rows)
        .key("")
        .col(
            "re",
            Fixed(10),
            "real part of leading multipliers, one of each conjugate pair, without those below their error",
            seen(|one| one.re),
        )
        .col("im", Fixed(10), "imaginary part", seen(|one| one.im))
        .col("modulus", Fixed(10), "", seen(|one| one.modulus))
        .col("error", Hidden, "of the modulus", |one| one.error)
        .done()
}

impl DrivenStudy {
    fn scale(&self) -> Scale<'_> {
        Scale(self.si.as_ref())
    }

    /// The report.
    pub fn report(&self) -> Report {
        let Self { scene, point, samples, ranges, driven, dissipated, .. } = self;
        let (scale, si, n) = (self.scale(), self.si.as_ref(), scene.chain().sites());
        let [beads, strains] = ranges.each_ref().map(|ranges| scale.all(Quantity::Length, ranges));
        let start = point.orbit.start().ok();
        let numbers = |quantity: Quantity, of: fn(&crate::chain::State<f64>) -> &[f64]| {
            start.as_ref().map(|state| scale.all(quantity, of(state)))
        };
        let (measures, spectrum) = (Some(&point.measures), Some(&point.spectrum));
        let row = BranchRow { orbit: &point.orbit, measures, spectrum };
        let drive = points("", &[row], DriveParameter::Amplitude, si).done().json();
        let rows: Vec<(usize, &Vec<f64>)> = samples.iter().enumerate().collect();
        let (period, count) = (point.orbit.setting.period(), samples.len() - 1);
        let mut table = Table::of("driven-orbit", &rows)
            .key("")
            .si(si)
            .col("t", Hidden, "", |row| period * row.0 as f64 / count as f64)
            .kind(Quantity::Time);
        for i in 0..n {
            table = table.col(format!("u{i}"), Hidden, "", move |row| row.1[i]).kind(Quantity::Length);
        }
        Report::new("driven-orbit")
            .fact("scene", scene.name())
            .fact("drive", &drive[0])
            .fact("u", numbers(Quantity::Length, |state| state.u()))
            .fact("v", numbers(Quantity::Length, |state| state.v().unwrap_or_default()))
            .fact("u_dot", numbers(Quantity::Velocity, |state| state.u_dot()))
            .fact("v_dot", numbers(Quantity::Velocity, |state| state.v_dot().unwrap_or_default()))
            .fact("response", scale.reported(Quantity::Length, point.measures.amplitude))
            .fact("bead_ranges", beads)
            .fact("strain_ranges", strains)
            .fact("driven", scale.reported(Quantity::Energy, *driven))
            .fact("dissipated", scale.reported(Quantity::Energy, *dissipated))
            .facts(fields!(point.orbit => residual, newton; point.spectrum => multipliers))
            .fact("max_modulus", point.spectrum.largest())
            .facts(fields!(point.spectrum => unstable(), liouville))
            .fact("integrator", METHOD)
            .fact("scene_file", scene_json(scene))
            .warnings(scene.doubts())
            .words(self.words())
            .table(multipliers(&leading(&point.spectrum)))
            .table(table)
            .si(si)
            .picture(orbit_picture(self))
    }

    fn words(&self) -> String {
        let (point, setting, scale) = (&self.point, &self.point.orbit.setting, self.scale());
        let kind = quantity(DriveParameter::Amplitude, setting);
        let numbers = [
            ("drive amplitude", kind, setting.get(DriveParameter::Amplitude)),
            ("drive omega", Quantity::Omega, setting.omega()),
            ("period of the orbit", Quantity::Time, setting.period()),
            ("largest half range of a free bead", Quantity::Length, point.measures.amplitude),
            ("driven over the orbit", Quantity::Energy, self.driven),
            ("dissipated", Quantity::Energy, self.dissipated),
        ];
        let hertz = self.si.map(|_| ("drive frequency", Quantity::Frequency, setting.omega()));
        let words = |(name, kind, x)| format!("{} {:.9e}", scale.label(name, kind), scale.reported(kind, x));
        let numbers: Vec<String> = numbers.into_iter().chain(hertz).map(words).collect();
        let least = match point.measures.least_turns {
            least if least == setting.turns() => String::new(),
            least => format!("; its least period: {least}"),
        };
        format!(
            "{}. Periods of the drive in one of the orbit: {}{least}. Residual of P(z) = z {:.1e}, after {} steps of Newton's method; error of ln |det M| by \
             Liouville {:.1e}. {} multipliers are outside the circle: the orbit is {}.",
            numbers.join("; "),
            setting.turns(),
            point.orbit.residual,
            point.orbit.newton.len(),
            point.spectrum.liouville,
            point.spectrum.unstable(),
            if point.stable() { "stable" } else { "unstable" },
        )
    }
}

impl DrivenBranchStudy {
    fn kind(&self) -> Quantity {
        quantity(self.branch.continuation.parameter, &self.branch.setting)
    }

    /// Adds points, bifurcations and file of a branch.
    fn tell(&self, report: Report, at: Option<usize>, branch: &DrivenBranch) -> Result<Report> {
        let (varied, si) = (branch.continuation.parameter, self.si.as_ref());
        let (rows, turns) = (branches::rows(branch), branch.setting.turns());
        let (names, words) = match at {
            None => (BRANCH, String::new()),
            Some(_) => (SWITCHED, format!("Periods of the drive in one of its orbits: {turns}.")),
        };
        let bifurcations = bifurcations(names[1], &branch.bifurcations, (varied, self.kind()), si);
        let points = points(names[0], &rows, varied, si);
        Ok(branches::tell(report, &self.scene, (at, branch), (points, bifurcations), json!({}))?.words(words))
    }
}

pub(super) fn branch(study: &DrivenBranchStudy) -> Result<Report> {
    let DrivenBranchStudy { scene, branch, switched, si } = study;
    let report = Report::new("driven-branch")
        .fact("scene", scene.name())
        .fact("parameter", branch.continuation.parameter.name())
        .fact("integrator", METHOD)
        .fact("scene_file", scene_json(scene))
        .warnings(scene.doubts());
    let mut both = branches::both(branch, switched);
    let report = both.try_fold(report, |report, (at, branch)| study.tell(report, at, branch))?;
    let report = branches::checked(report, branch, switched).si(si.as_ref());
    Ok(if !branches::shows(branch) { report } else { report.picture(branch_picture(study)) })
}

/// The multipliers in the complex plane, with a line each for those inside or on the circle, and
/// for those outside.
fn multipliers_panel(spectrum: &DrivenSpectrum) -> Panel {
    let outside = spectrum.unstable();
    let at = |one: &DrivenMultiplier| (one.re, one.im);
    let (out, inside) = spectrum.multipliers.split_at(outside);
    let mut lines = vec![Line::new("inside or on the circle", inside.iter().map(at))];
    if outside > 0 {
        lines.push(Line::new("outside", out.iter().map(at)));
    }
    Panel::new(Kind::Plane, ["Re λ", "Im λ"], lines)
}

/// Amplitude and frequency of a drive, for a caption.
fn drive_words(setting: &DrivenSetting, scale: Scale<'_>) -> String {
    let amplitude = setting.get(DriveParameter::Amplitude);
    if scale.0.is_none() {
        return format!("a = {amplitude}, ω = {}", setting.omega());
    }
    let kind = quantity(DriveParameter::Amplitude, setting);
    let [a, frequency] = [(kind, amplitude), (Quantity::Frequency, setting.omega())]
        .map(|(kind, value)| format!("{} {}", format_short(scale.reported(kind, value)), kind.unit()));
    format!("a = {a}, ω/2π = {frequency}")
}

fn orbit_picture(study: &DrivenStudy) -> Panels {
    let DrivenStudy { scene, point, ranges: [beads, strains], .. } = study;
    let scale = study.scale();
    let sites = |label: &str, values: &[f64], first: f64| {
        let values = values.iter().map(|value| scale.reported(Quantity::Length, *value));
        let points = values.enumerate().map(|(i, value)| (i as f64 + first, value));
        Panel::new(Kind::Sites, ["site n", &scale.label(label, Quantity::Length)], vec![Line::new(label, points)])
    };
    let profile = [sites("half range of uₙ", beads, 0.0), sites("half range of uₙ − uₙ₋₁", strains, 1.0)];
    let setting = &point.orbit.setting;
    let how = format!(
        "Orbit of {} period{} of the drive, {}; largest |λ| = {:.6}; residual {:.1e}.",
        setting.turns(),
        if setting.turns() == 1 { "" } else { "s" },
        drive_words(setting, scale),
        point.spectrum.largest(),
        point.orbit.residual
    );
    let caption = scene_caption(scene, &how);
    let columns =
        vec![Column::new("", branches::filled(profile)), Column::new("", [multipliers_panel(&point.spectrum)])];
    Panels { title: format!("Driven orbit of {}", scene.name()), columns, caption }
}

fn branch_picture(study: &DrivenBranchStudy) -> Panels {
    let DrivenBranchStudy { scene, branch, .. } = study;
    let (parameter, scale) = (branch.continuation.parameter, Scale(study.si.as_ref()));
    let kind = match study.kind() {
        Quantity::Omega if study.si.is_some() => Quantity::Frequency,
        kind => kind,
    };
    let symbol = if kind == Quantity::Frequency { "drive frequency ω/2π" } else { parameter.symbol() };
    let place = |orbit: &DrivenOrbit| scale.reported(kind, orbit.setting.get(parameter));
    let response = |amplitude: f64| scale.reported(Quantity::Length, amplitude);
    let lines = branches::lines(
        branch,
        &study.switched,
        |row| (place(row.orbit), row.measures.map_or(f64::NAN, |measures| response(measures.amplitude))),
        |spectrum| spectrum.unstable() == 0,
        |one| (scale.reported(kind, one.parameter), response(one.critical.amplitude)),
    );
    let other = crossed(&study.switched).map(|(_, other)| ("switched", other));
    let moduli = |(name, branch): (&str, &DrivenBranch)| {
        Line::new(name, branch.points.iter().map(|point| (place(&point.orbit), point.spectrum.largest())))
    };
    let moduli = [("largest |λ|", branch)].into_iter().chain(other).map(moduli).collect();
    let (count, end, from) = (branches::rows(branch).len(), branch.ended().words(), branches::from(&study.switched));
    let how = format!("{count} orbits; {end}.{from}");
    let along = scale.label(symbol, kind);
    let range = scale.label("largest half range of a bead", Quantity::Length);
    let plots = branches::filled([
        Panel::new(Kind::Cloud, [&*along, &*range], lines),
        Panel::new(Kind::Cloud, [&*along, "largest |λ|"], moduli),
    ]);
    let title = format!("Driven orbits of {} over the {symbol}", scene.name());
    Panels::column(title, plots, scene_caption(scene, &how))
}
