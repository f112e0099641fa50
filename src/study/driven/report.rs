//! Orbits of driven scenes and their branches as text, JSON, CSV and pictures.

use super::{BRANCH_FILE, DrivenBranchStudy, DrivenStudy, SWITCHED_FILE, SWITCHED_TABLE, driven_branch_npz, quantity};
#[cfg(feature = "plot")]
use crate::study::shown;
use crate::{
    error::Result,
    orbits::{DriveParameter, DrivenBifurcation, DrivenBranch, DrivenMultiplier, DrivenPoint, DrivenSetting},
    output::csv,
    present::table,
    scene::Quantity,
    study::{File, Report, named, scene_json, si::Scale, word},
};
use serde_json::{Value, json};

/// Number of leading multipliers, one of each conjugate pair, that text and JSON show.
const LEADING: usize = 6;
/// Multipliers are shown with ten decimals; smaller ones, and those below their error, by a bound.
const SHOWN: f64 = 5e-11;
/// Name of the integrator of driven orbits.
const METHOD: &str = "dop853-regularised";

/// A parameter of a setting as it is told.
fn parameter(setting: &DrivenSetting, parameter: DriveParameter, scale: Scale<'_>) -> f64 {
    scale.told(quantity(parameter, setting), setting.get(parameter))
}

fn parameters(point: &DrivenPoint, scale: Scale<'_>) -> Value {
    let setting = &point.orbit.setting;
    let mut value = json!({
        "amplitude": parameter(setting, DriveParameter::Amplitude, scale),
        "omega": parameter(setting, DriveParameter::Omega, scale),
        "damping": setting.get(DriveParameter::Damping),
        "turns": setting.turns(),
        "least_turns": point.least_turns,
        "period": scale.told(Quantity::Time, setting.period()),
    });
    scale.put_frequency(setting.omega(), &mut value);
    value
}

impl DrivenStudy {
    fn scale(&self) -> Scale<'_> {
        Scale(self.si.as_ref())
    }

    /// Amplitude and frequency of the drive as rows of a table; in SI units the frequency is both
    /// `omega` and in hertz.
    fn drive(&self) -> Vec<(String, String)> {
        let setting = &self.point.orbit.setting;
        let amplitude = setting.get(DriveParameter::Amplitude);
        if self.si.is_none() {
            let name = "drive amplitude, frequency".to_owned();
            return vec![(name, format!("{amplitude}, {}", setting.omega()))];
        }
        let row = |name: &str, quantity: Quantity, value: f64| {
            (self.scale().label(name, quantity), self.scale().shown(quantity, value, 12))
        };
        vec![
            row("drive amplitude", quantity(DriveParameter::Amplitude, setting), amplitude),
            row("drive omega", Quantity::Omega, setting.omega()),
            row("drive frequency", Quantity::Frequency, setting.omega()),
        ]
    }
}

impl Report for DrivenStudy {
    fn json(&self) -> Value {
        let Self { scene, point, samples, driven, dissipated, .. } = self;
        let scale = self.scale();
        let ranges = point.orbit.ranges(samples);
        let [beads, strains] = ranges.map(|ranges| scale.all(Quantity::Length, &ranges));
        let start = point.orbit.start().ok();
        let numbers = |quantity: Quantity, of: fn(&crate::chain::State<f64>) -> &[f64]| {
            start.as_ref().map(|state| scale.all(quantity, of(state)))
        };
        let mut value = json!({
            "scene": scene.name(),
            "drive": parameters(point, scale),
            "u": numbers(Quantity::Length, |state| state.u()),
            "v": numbers(Quantity::Length, |state| state.v().unwrap_or_default()),
            "u_dot": numbers(Quantity::Velocity, |state| state.u_dot()),
            "v_dot": numbers(Quantity::Velocity, |state| state.v_dot().unwrap_or_default()),
            "response": scale.told(Quantity::Length, point.amplitude),
            "bead_ranges": beads,
            "strain_ranges": strains,
            "driven": scale.told(Quantity::Energy, *driven),
            "dissipated": scale.told(Quantity::Energy, *dissipated),
            "residual": point.orbit.residual,
            "newton": point.orbit.newton,
            "multipliers": point.spectrum.multipliers,
            "max_modulus": point.spectrum.largest(),
            "unstable": point.spectrum.unstable(),
            "liouville": point.spectrum.liouville,
            "integrator": METHOD,
            "scene_file": scene_json(scene),
            "version": env!("CARGO_PKG_VERSION"),
        });
        scale.put_units(&mut value);
        value
    }

    fn text(&self) -> String {
        let Self { point, driven, dissipated, .. } = self;
        let (setting, scale) = (&point.orbit.setting, self.scale());
        let period = scale.shown(Quantity::Time, setting.period(), 12);
        let [driven, dissipated] = [driven, dissipated].map(|energy| scale.told(Quantity::Energy, *energy));
        let response = scale.told(Quantity::Length, point.amplitude);
        let least = match point.least_turns {
            least if least == setting.turns() => String::new(),
            least => format!("; its least period: {least}"),
        };
        let labelled = |name: &str, quantity: Quantity, value: String| (scale.label(name, quantity), value);
        let measured = [
            labelled(
                "period of the orbit",
                Quantity::Time,
                format!("{period} ({} of the drive{least})", setting.turns()),
            ),
            labelled("largest half range of a free bead", Quantity::Length, format!("{response:.9e}")),
            labelled("driven, dissipated over the orbit", Quantity::Energy, format!("{driven:.9e}, {dissipated:.9e}")),
        ];
        let checked = [
            ("residual of P(z) = z", format!("{:.1e}", point.orbit.residual)),
            ("steps of Newton's method", point.orbit.newton.len().to_string()),
            ("error of ln |det M| by Liouville", format!("{:.1e}", point.spectrum.liouville)),
            ("multipliers outside the circle", point.spectrum.unstable().to_string()),
        ];
        let checked = checked.map(|(name, value)| (name.to_owned(), value));
        let rows: Vec<_> =
            self.drive().into_iter().chain(measured).chain(checked).map(|(name, value)| vec![name, value]).collect();
        let leading = point.spectrum.multipliers.iter().filter(|one| one.im >= 0.0).take(LEADING);
        let leading: Vec<_> = leading
            .map(|one| match one.error.max(SHOWN) {
                least if one.modulus > least => [one.re, one.im, one.modulus].map(|x| format!("{x:.10}")).to_vec(),
                least => vec![String::new(), String::new(), format!("below 1e{:.0}", least.log10().ceil())],
            })
            .collect();
        format!(
            "{}\n{}\nThe leading multipliers, one of each conjugate pair; the orbit is {}.\n{}",
            table(&["quantity", "value"], &rows),
            table(&["Re lambda", "Im lambda", "|lambda|"], &leading),
            if point.stable() { "stable" } else { "unstable" },
            scale.line()
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let (n, scale) = (self.scene.chain().sites(), self.scale());
        let period = scale.told(Quantity::Time, self.point.orbit.setting.period());
        let count = self.samples.len() - 1;
        let names: Vec<String> = std::iter::once("t".to_owned()).chain((0..n).map(|i| format!("u{i}"))).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let rows = self.samples.iter().enumerate().map(|(k, state)| {
            let t = period * k as f64 / count as f64;
            std::iter::once(t).chain(scale.all(Quantity::Length, &state[..n])).collect()
        });
        Ok(named([("driven-orbit.csv", csv(&names, rows)), ("driven-orbit.json", format!("{json}\n").into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("driven-orbit.png", orbit_picture(self)?)]))
    }
}

/// Points and bifurcations of a branch.
fn branch_json(branch: &DrivenBranch, scale: Scale<'_>) -> Value {
    let points = branch.points.iter().map(|point| {
        let leading: Vec<&DrivenMultiplier> =
            point.spectrum.multipliers.iter().filter(|one| one.im >= 0.0).take(LEADING).collect();
        let mut value = parameters(point, scale);
        value["response"] = json!(scale.told(Quantity::Length, point.amplitude));
        value["residual"] = json!(point.orbit.residual);
        value["max_modulus"] = json!(point.spectrum.largest());
        value["unstable"] = json!(point.spectrum.unstable());
        value["leading"] = json!(leading);
        value["liouville"] = json!(point.spectrum.liouville);
        value
    });
    let bifurcation = |one: &DrivenBifurcation| {
        let setting = &one.point.orbit.setting;
        let mut value = json!({
            "kind": one.kind,
            "parameter": scale.told(quantity(branch.continuation.parameter, setting), one.parameter),
            "multiplier": one.multiplier,
            "response": scale.told(Quantity::Length, one.point.amplitude),
        });
        scale.put_frequency(setting.omega(), &mut value);
        value
    };
    json!({
        "end": branch.end,
        "points": points.collect::<Vec<Value>>(),
        "bifurcations": branch.bifurcations.iter().map(bifurcation).collect::<Vec<Value>>(),
        "unresolved": branch.unresolved,
    })
}

/// The columns that have the parameter of a branch, by name and kind: in SI units a frequency is both
/// `omega` and in hertz.
fn parameter_columns(branch: &DrivenBranch, scale: Scale<'_>) -> Vec<(&'static str, Quantity)> {
    let parameter = branch.continuation.parameter;
    let kind = branch.points.first().map_or(Quantity::Number, |point| quantity(parameter, &point.orbit.setting));
    let hertz = (scale.0.is_some() && kind == Quantity::Omega).then_some(("frequency", Quantity::Frequency));
    std::iter::once((parameter.name(), kind)).chain(hertz).collect()
}

/// Points and bifurcations of a branch as tables.
fn branch_text(branch: &DrivenBranch, scale: Scale<'_>) -> String {
    let parameter = branch.continuation.parameter;
    let columns = parameter_columns(branch, scale);
    let headings: Vec<String> = columns.iter().map(|&(name, kind)| scale.label(name, kind)).collect();
    let cells = |value: f64| columns.iter().map(move |&(_, kind)| scale.shown(kind, value, 8));
    let rows: Vec<Vec<String>> = branch
        .points
        .iter()
        .map(|point| {
            let numbers = [
                format!("{:.6e}", scale.told(Quantity::Length, point.amplitude)),
                format!("{:.8}", point.spectrum.largest()),
                point.spectrum.unstable().to_string(),
            ];
            cells(point.orbit.setting.get(parameter)).chain(numbers).collect()
        })
        .collect();
    let event = |(k, one): (usize, &DrivenBifurcation)| {
        let DrivenMultiplier { re, im, .. } = one.multiplier;
        let multiplier = [re, im].map(|x| format!("{x:.6}"));
        [(k + 1).to_string(), word(&one.kind)].into_iter().chain(cells(one.parameter)).chain(multiplier).collect()
    };
    let events: Vec<Vec<String>> = branch.bifurcations.iter().enumerate().map(event).collect();
    let events = if events.is_empty() {
        "no bifurcation\n".to_owned()
    } else {
        table(&between(&["number", "bifurcation"], &headings, &["Re lambda", "Im lambda"]), &events)
    };
    let unresolved = match branch.unresolved {
        0 => String::new(),
        count => format!("changes of stability that were not resolved into single bifurcations: {count}\n"),
    };
    let response = scale.label("response", Quantity::Length);
    table(&between(&[], &headings, &[&response, "largest |lambda|", "outside"]), &rows)
        + "\n"
        + &events
        + &format!("\n{} points; the branch ended: {}\n{unresolved}", branch.points.len(), branch.end.words())
}

/// Headings of a table: some before those of the parameter, some after them.
fn between<'a>(before: &[&'a str], parameter: &'a [String], after: &[&'a str]) -> Vec<&'a str> {
    before.iter().copied().chain(parameter.iter().map(String::as_str)).chain(after.iter().copied()).collect()
}

/// Columns that are told in SI units only come last.
fn branch_csv(branch: &DrivenBranch, scale: Scale<'_>) -> Vec<u8> {
    let columns = parameter_columns(branch, scale);
    let (first, more) = columns.split_at(1);
    let rows = branch.points.iter().map(|point| {
        let value = point.orbit.setting.get(branch.continuation.parameter);
        let told = |&(_, kind): &(&str, Quantity)| scale.told(kind, value);
        let response = scale.told(Quantity::Length, point.amplitude);
        let numbers = [response, point.spectrum.largest(), point.spectrum.unstable() as f64];
        first.iter().map(told).chain(numbers).chain(more.iter().map(told)).collect()
    });
    let name = |&(name, _): &(&'static str, Quantity)| name;
    let names = ["response", "max_modulus", "unstable"];
    csv(&first.iter().map(name).chain(names).chain(more.iter().map(name)).collect::<Vec<_>>(), rows)
}

impl DrivenBranchStudy {
    fn scale(&self) -> Scale<'_> {
        Scale(self.si.as_ref())
    }

    /// The branch that crosses, if one was followed, and the number of its bifurcation.
    fn crossing(&self) -> Option<(usize, &DrivenBranch)> {
        let (number, other) = self.switched.as_ref()?;
        Some((*number, other.as_ref().ok()?))
    }

    /// The branch and, if it was followed, the one that crosses it.
    fn branches(&self) -> impl Iterator<Item = &DrivenBranch> {
        std::iter::once(&self.branch).chain(self.crossing().map(|(_, other)| other))
    }
}

impl Report for DrivenBranchStudy {
    fn json(&self) -> Value {
        let Self { scene, branch, switched, .. } = self;
        let scale = self.scale();
        let mut value = branch_json(branch, scale);
        value["scene"] = json!(scene.name());
        value["parameter"] = json!(branch.continuation.parameter.name());
        if let Some((number, other)) = switched {
            match other {
                Ok(other) => value["switched"] = branch_json(other, scale),
                Err(why) => value["switched"]["failure"] = json!(why),
            }
            value["switched"]["at"] = json!(number);
        }
        value["integrator"] = json!(METHOD);
        value["scene_file"] = scene_json(scene);
        value["version"] = json!(env!("CARGO_PKG_VERSION"));
        scale.put_units(&mut value);
        value
    }

    fn text(&self) -> String {
        let other = self.crossing().map_or(String::new(), |(number, other)| {
            let turns = other.points.first().map_or(1, |point| point.orbit.setting.turns());
            let periods = if turns == 1 { "the period".to_owned() } else { format!("{turns} periods") };
            format!(
                "\nThe branch that crosses at bifurcation {number}, of {periods} of the drive:\n\n{}",
                branch_text(other, self.scale())
            )
        });
        branch_text(&self.branch, self.scale())
            + &other
            + "response: largest half range of a free bead; outside: multipliers outside the unit circle\n"
            + &self.scale().line()
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let Self { scene, branch, .. } = self;
        let mut files = named([
            ("driven-branch.csv", branch_csv(branch, self.scale())),
            ("driven-branch.json", format!("{json}\n").into()),
            (BRANCH_FILE, driven_branch_npz(scene, &branch.trail)?),
        ]);
        if let Some((_, other)) = self.crossing() {
            files.extend(named([
                (SWITCHED_TABLE, branch_csv(other, self.scale())),
                (SWITCHED_FILE, driven_branch_npz(scene, &other.trail)?),
            ]));
        }
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("driven-branch.png", branch_picture(self)?)]))
    }

    fn remark(&self) -> Option<String> {
        if let Some((_, Err(why))) = &self.switched {
            return Some(format!("error: {why}"));
        }
        let short = self.branches().find(|branch| !branch.end.answers())?;
        Some(format!("error: the branch ended: {}", short.end.words()))
    }

    /// A branch succeeds if it reached its end or turned back, or if it came back to the branch of
    /// half its period.
    fn succeeded(&self) -> bool {
        !matches!(self.switched, Some((_, Err(_)))) && self.branches().all(|branch| branch.end.answers())
    }
}

/// The multipliers in the complex plane, with a line each for those inside or on the circle, and
/// for those outside.
pub(crate) fn multipliers_panel(point: &DrivenPoint) -> crate::report::Panel {
    use crate::report::{Kind, Line, Panel};
    let outside = point.spectrum.unstable();
    let at = |one: &DrivenMultiplier| (one.re, one.im);
    let (out, inside) = point.spectrum.multipliers.split_at(outside);
    let mut lines = vec![Line::new("inside or on the circle", inside.iter().map(at))];
    if outside > 0 {
        lines.push(Line::new("outside", out.iter().map(at)));
    }
    Panel::new(Kind::Plane, ["Re λ", "Im λ"], lines)
}

/// Amplitude and frequency of a drive, for a caption.
#[cfg(feature = "plot")]
fn drive_words(setting: &DrivenSetting, scale: Scale<'_>) -> String {
    let amplitude = setting.get(DriveParameter::Amplitude);
    if scale.0.is_none() {
        return format!("a = {amplitude}, ω = {}", setting.omega());
    }
    let kind = quantity(DriveParameter::Amplitude, setting);
    let [a, frequency] = [(kind, amplitude), (Quantity::Frequency, setting.omega())]
        .map(|(kind, value)| format!("{} {}", shown(scale.told(kind, value)), kind.unit()));
    format!("a = {a}, ω/2π = {frequency}")
}

#[cfg(feature = "plot")]
fn orbit_picture(study: &DrivenStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let DrivenStudy { scene, point, samples, .. } = study;
    let [beads, strains] = point.orbit.ranges(samples);
    let scale = study.scale();
    let sites = |label: &str, values: &[f64], first: f64| {
        let values = values.iter().map(|value| scale.told(Quantity::Length, *value));
        let points = values.enumerate().map(|(i, value)| (i as f64 + first, value));
        Panel::new(Kind::Sites, ["site n", &scale.label(label, Quantity::Length)], vec![Line::new(label, points)])
    };
    let profile = [sites("half range of uₙ", &beads, 0.0), sites("half range of uₙ − uₙ₋₁", &strains, 1.0)];
    let setting = &point.orbit.setting;
    let how = format!(
        "Orbit of {} period{} of the drive, {}; largest |λ| = {:.6}; residual {:.1e}.",
        setting.turns(),
        if setting.turns() == 1 { "" } else { "s" },
        drive_words(setting, scale),
        point.spectrum.largest(),
        point.orbit.residual
    );
    let caption = crate::study::provenance(scene, &how);
    let columns = vec![Column::new("", profile), Column::new("", [multipliers_panel(point)])];
    Ok(panels(&Panels { title: format!("Driven orbit of {}", scene.name()), columns, caption })?)
}

#[cfg(feature = "plot")]
fn branch_picture(study: &DrivenBranchStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Kind, Line, Panel, Panels, panels};
    let DrivenBranchStudy { scene, branch, .. } = study;
    let (parameter, scale) = (branch.continuation.parameter, study.scale());
    // The last column is the one in hertz, if there is one.
    let kind = parameter_columns(branch, scale).last().map_or(Quantity::Number, |column| column.1);
    let symbol = if kind == Quantity::Frequency { "drive frequency ω/2π" } else { parameter.symbol() };
    let place = |point: &DrivenPoint| scale.told(kind, point.orbit.setting.get(parameter));
    let response = |point: &DrivenPoint| scale.told(Quantity::Length, point.amplitude);
    let responses = |branch: &DrivenBranch| {
        crate::study::stability_lines(&branch.points, |point| (place(point), response(point)), DrivenPoint::stable)
    };
    let mut lines = responses(branch);
    let marks = study.branches().flat_map(|branch| &branch.bifurcations);
    lines.push(Line::new("bifurcation", marks.map(|one| (scale.told(kind, one.parameter), response(&one.point)))));
    let moduli = |name: &str, branch: &DrivenBranch| {
        Line::new(name, branch.points.iter().map(|point| (place(point), point.spectrum.largest())))
    };
    let mut largest = vec![moduli("largest |λ|", branch)];
    let mut how = format!("{} orbits; {}.", branch.points.len(), branch.end.words());
    if let Some((number, other)) = study.crossing() {
        let names = ["stable, switched", "unstable, switched"];
        lines
            .extend(responses(other).into_iter().zip(names).map(|(line, name)| Line { name: name.to_owned(), ..line }));
        largest.push(moduli("switched", other));
        how += &format!(" From bifurcation {number}: {} orbits; {}.", other.points.len(), other.end.words());
    }
    let along = scale.label(symbol, kind);
    let range = scale.label("largest half range of a bead", Quantity::Length);
    let plots = vec![
        Panel::new(Kind::Cloud, [&*along, &*range], lines),
        Panel::new(Kind::Cloud, [&*along, "largest |λ|"], largest),
    ];
    let title = format!("Driven orbits of {} over the {symbol}", scene.name());
    Ok(panels(&Panels::column(title, plots, crate::study::provenance(scene, &how)))?)
}
