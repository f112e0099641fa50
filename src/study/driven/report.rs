//! Orbits of driven scenes and their branches as text, JSON, CSV and pictures.

use super::{BRANCH_FILE, DrivenBranchStudy, DrivenStudy, SWITCHED_FILE, SWITCHED_TABLE, npz};
use crate::{
    error::Result,
    orbits::{DriveParameter, DrivenBifurcation, DrivenBranch, DrivenMultiplier, DrivenPoint},
    output::csv,
    present::table,
    study::{File, Report, named, scene_json, word},
};
use serde_json::{Value, json};

/// Number of leading multipliers, one of each conjugate pair, that text and JSON show.
const LEADING: usize = 6;
/// Name of the integrator of driven orbits.
const METHOD: &str = "dop853-regularised";

fn parameters(point: &DrivenPoint) -> Value {
    let setting = &point.orbit.setting;
    json!({
        "amplitude": setting.get(DriveParameter::Amplitude),
        "omega": setting.omega(),
        "damping": setting.get(DriveParameter::Damping),
        "turns": setting.turns(),
        "period": setting.period(),
    })
}

impl Report for DrivenStudy {
    fn json(&self) -> Value {
        let Self { scene, point, samples, driven, dissipated } = self;
        let [beads, strains] = point.orbit.ranges(samples);
        let start = point.orbit.start().ok();
        let numbers = |of: fn(&crate::chain::State<f64>) -> &[f64]| start.as_ref().map(|state| of(state).to_vec());
        json!({
            "scene": scene.name(),
            "drive": parameters(point),
            "u": numbers(|state| state.u()),
            "v": numbers(|state| state.v().unwrap_or_default()),
            "u_dot": numbers(|state| state.u_dot()),
            "v_dot": numbers(|state| state.v_dot().unwrap_or_default()),
            "response": point.amplitude,
            "bead_ranges": beads,
            "strain_ranges": strains,
            "driven": driven,
            "dissipated": dissipated,
            "residual": point.orbit.residual,
            "newton": point.orbit.newton,
            "multipliers": point.spectrum.multipliers,
            "max_modulus": point.spectrum.largest(),
            "unstable": point.spectrum.unstable(),
            "liouville": point.spectrum.liouville,
            "integrator": METHOD,
            "scene_file": scene_json(scene),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let Self { point, driven, dissipated, .. } = self;
        let setting = &point.orbit.setting;
        let numbers = [
            ("drive amplitude, frequency", format!("{}, {}", setting.get(DriveParameter::Amplitude), setting.omega())),
            ("period of the orbit", format!("{:.12} ({} of the drive)", setting.period(), setting.turns())),
            ("largest half range of a free bead", format!("{:.9e}", point.amplitude)),
            ("driven, dissipated over the orbit", format!("{driven:.9e}, {dissipated:.9e}")),
            ("residual of P(z) = z", format!("{:.1e}", point.orbit.residual)),
            ("steps of Newton's method", point.orbit.newton.len().to_string()),
            ("error of ln |det M| by Liouville", format!("{:.1e}", point.spectrum.liouville)),
            ("multipliers outside the circle", point.spectrum.unstable().to_string()),
        ];
        let rows: Vec<_> = numbers.map(|(name, value)| vec![name.to_owned(), value]).to_vec();
        let leading = point.spectrum.multipliers.iter().filter(|one| one.im >= 0.0).take(LEADING);
        let leading: Vec<_> = leading
            .map(|one| vec![format!("{:.10}", one.re), format!("{:.10}", one.im), format!("{:.10}", one.modulus)])
            .collect();
        format!(
            "{}\n{}\nThe leading multipliers, one of each conjugate pair; the orbit is {}.\n",
            table(&["quantity", "value"], &rows),
            table(&["Re lambda", "Im lambda", "|lambda|"], &leading),
            if point.stable() { "stable" } else { "unstable" }
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let n = self.scene.chain().sites();
        let period = self.point.orbit.setting.period();
        let count = self.samples.len() - 1;
        let names: Vec<String> = std::iter::once("t".to_owned()).chain((0..n).map(|i| format!("u{i}"))).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let rows = self.samples.iter().enumerate().map(|(k, state)| {
            let t = period * k as f64 / count as f64;
            std::iter::once(t).chain(state[..n].iter().copied()).collect()
        });
        Ok(named([("driven-orbit.csv", csv(&names, rows)), ("driven-orbit.json", format!("{json}\n").into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("driven-orbit.png", orbit_picture(self)?)]))
    }
}

/// Points and bifurcations of a branch.
fn branch_json(branch: &DrivenBranch) -> Value {
    let points = branch.points.iter().map(|point| {
        let leading: Vec<&DrivenMultiplier> =
            point.spectrum.multipliers.iter().filter(|one| one.im >= 0.0).take(LEADING).collect();
        let mut value = parameters(point);
        value["response"] = json!(point.amplitude);
        value["residual"] = json!(point.orbit.residual);
        value["max_modulus"] = json!(point.spectrum.largest());
        value["unstable"] = json!(point.spectrum.unstable());
        value["leading"] = json!(leading);
        value["liouville"] = json!(point.spectrum.liouville);
        value
    });
    let bifurcation = |one: &DrivenBifurcation| {
        json!({
            "kind": one.kind,
            "parameter": one.parameter,
            "multiplier": one.multiplier,
            "response": one.point.amplitude,
        })
    };
    json!({
        "end": branch.end,
        "points": points.collect::<Vec<Value>>(),
        "bifurcations": branch.bifurcations.iter().map(bifurcation).collect::<Vec<Value>>(),
        "unresolved": branch.unresolved,
    })
}

/// Points and bifurcations of a branch as tables.
fn branch_text(branch: &DrivenBranch) -> String {
    let parameter = branch.continuation.parameter;
    let rows: Vec<Vec<String>> = branch
        .points
        .iter()
        .map(|point| {
            vec![
                format!("{:.8}", point.orbit.setting.get(parameter)),
                format!("{:.6e}", point.amplitude),
                format!("{:.8}", point.spectrum.largest()),
                point.spectrum.unstable().to_string(),
            ]
        })
        .collect();
    let event = |(k, one): (usize, &DrivenBifurcation)| {
        let DrivenMultiplier { re, im, .. } = one.multiplier;
        let numbers = [format!("{:.8}", one.parameter), format!("{re:.6}"), format!("{im:.6}")];
        [(k + 1).to_string(), word(&one.kind)].into_iter().chain(numbers).collect()
    };
    let events: Vec<Vec<String>> = branch.bifurcations.iter().enumerate().map(event).collect();
    let events = if events.is_empty() {
        "no bifurcation\n".to_owned()
    } else {
        table(&["number", "bifurcation", parameter.name(), "Re lambda", "Im lambda"], &events)
    };
    let unresolved = match branch.unresolved {
        0 => String::new(),
        count => format!("changes of stability that were not resolved into single bifurcations: {count}\n"),
    };
    table(&[parameter.name(), "response", "largest |lambda|", "outside"], &rows)
        + "\n"
        + &events
        + &format!("\n{} points; the branch ended: {}\n{unresolved}", branch.points.len(), branch.end.words())
}

fn branch_csv(branch: &DrivenBranch) -> Vec<u8> {
    let parameter = branch.continuation.parameter;
    let rows = branch.points.iter().map(|point| {
        let unstable = point.spectrum.unstable() as f64;
        vec![point.orbit.setting.get(parameter), point.amplitude, point.spectrum.largest(), unstable]
    });
    csv(&[parameter.name(), "response", "max_modulus", "unstable"], rows)
}

impl DrivenBranchStudy {
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
        let Self { scene, branch, switched } = self;
        let mut value = branch_json(branch);
        value["scene"] = json!(scene.name());
        value["parameter"] = json!(branch.continuation.parameter.name());
        if let Some((number, other)) = switched {
            match other {
                Ok(other) => value["switched"] = branch_json(other),
                Err(why) => value["switched"]["failure"] = json!(why),
            }
            value["switched"]["at"] = json!(number);
        }
        value["integrator"] = json!(METHOD);
        value["scene_file"] = scene_json(scene);
        value["version"] = json!(env!("CARGO_PKG_VERSION"));
        value
    }

    fn text(&self) -> String {
        let other = self.crossing().map_or(String::new(), |(number, other)| {
            let turns = other.points.first().map_or(1, |point| point.orbit.setting.turns());
            let periods = if turns == 1 { "the period".to_owned() } else { format!("{turns} periods") };
            format!(
                "\nThe branch that crosses at bifurcation {number}, of {periods} of the drive:\n\n{}",
                branch_text(other)
            )
        });
        branch_text(&self.branch)
            + &other
            + "response: largest half range of a free bead; outside: multipliers outside the unit circle\n"
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let Self { scene, branch, .. } = self;
        let mut files = named([
            ("driven-branch.csv", branch_csv(branch)),
            ("driven-branch.json", format!("{json}\n").into()),
            (BRANCH_FILE, npz(scene, &branch.trail)?),
        ]);
        if let Some((_, other)) = self.crossing() {
            files.extend(named([(SWITCHED_TABLE, branch_csv(other)), (SWITCHED_FILE, npz(scene, &other.trail)?)]));
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
#[cfg(feature = "plot")]
pub(crate) fn multipliers_panel(point: &DrivenPoint) -> crate::figures::Panel {
    use crate::figures::{Kind, Line, Panel};
    let outside = point.spectrum.unstable();
    let at = |one: &DrivenMultiplier| (one.re, one.im);
    let (out, inside) = point.spectrum.multipliers.split_at(outside);
    let mut lines = vec![Line::new("inside or on the circle", inside.iter().map(at))];
    if outside > 0 {
        lines.push(Line::new("outside", out.iter().map(at)));
    }
    Panel::new(Kind::Plane, ["Re λ", "Im λ"], lines)
}

/// The points of a branch as two lines of a picture, one for stable and one for unstable ones.
#[cfg(feature = "plot")]
pub(crate) fn stability_lines<'a, T: 'a>(
    points: &'a [T],
    place: impl Fn(&'a T) -> (f64, f64),
    stable: impl Fn(&'a T) -> bool,
) -> Vec<crate::figures::Line> {
    let chosen = |wanted: bool| points.iter().filter(|point| stable(point) == wanted).map(&place).collect::<Vec<_>>();
    [("stable", true), ("unstable", false)]
        .into_iter()
        .map(|(name, wanted)| crate::figures::Line::new(name, chosen(wanted)))
        .collect()
}

#[cfg(feature = "plot")]
fn orbit_picture(study: &DrivenStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let DrivenStudy { scene, point, samples, .. } = study;
    let [beads, strains] = point.orbit.ranges(samples);
    let sites = |label: &str, values: &[f64], first: f64| {
        let points = values.iter().enumerate().map(|(i, value)| (i as f64 + first, *value));
        Panel::new(Kind::Sites, ["site n", label], vec![Line::new(label, points)])
    };
    let profile = [sites("half range of uₙ", &beads, 0.0), sites("half range of uₙ − uₙ₋₁", &strains, 1.0)];
    let setting = &point.orbit.setting;
    let how = format!(
        "Orbit of {} period{} of the drive, a = {}, ω = {}; largest |λ| = {:.6}; residual {:.1e}.",
        setting.turns(),
        if setting.turns() == 1 { "" } else { "s" },
        setting.get(DriveParameter::Amplitude),
        setting.omega(),
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
    let parameter = branch.continuation.parameter;
    let place = |point: &DrivenPoint| point.orbit.setting.get(parameter);
    let responses = |branch: &DrivenBranch| {
        stability_lines(&branch.points, |point| (place(point), point.amplitude), DrivenPoint::stable)
    };
    let mut lines = responses(branch);
    let marks = study.branches().flat_map(|branch| &branch.bifurcations);
    lines.push(Line::new("bifurcation", marks.map(|one| (one.parameter, one.point.amplitude))));
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
    let plots = vec![
        Panel::new(Kind::Cloud, [parameter.symbol(), "largest half range of a bead"], lines),
        Panel::new(Kind::Cloud, [parameter.symbol(), "largest |λ|"], largest),
    ];
    let title = format!("Driven orbits of {} over the {}", scene.name(), parameter.symbol());
    Ok(panels(&Panels::column(title, plots, crate::study::provenance(scene, &how)))?)
}
