//! The study of chains driven at both ends as text, JSON, CSV and a picture.

use super::{AFTER_RAMP, EndDriven, EndDrivenCase, EndDrivenPoint, EndDrivenStudy, Ends, RAMPS, RING, SETTLE};
use crate::{
    error::Result,
    orbits::DrivenBifurcation,
    output::csv,
    present::table,
    study::{File, Report, named},
};
use serde_json::{Value, json};

impl Ends {
    /// In words.
    pub fn words(self) -> &'static str {
        if self == Self::InPhase { "in phase" } else { "antiphase" }
    }
}

fn point(one: &EndDrivenPoint, free: f64) -> Value {
    json!({
        "amplitude": one.amplitude(),
        "background": one.background,
        "cosine": one.cosine,
        "centre": one.centre,
        "dark": one.dark(free),
        "max_modulus": one.point.spectrum.largest(),
        "unstable": one.point.spectrum.unstable(),
        "residual": one.point.orbit.residual,
    })
}

fn case_json(case: &EndDrivenCase) -> Value {
    let bifurcation =
        |one: &DrivenBifurcation| json!({ "kind": one.kind, "parameter": one.parameter, "multiplier": one.multiplier });
    let [first, stable] = case.first().map(|one| one.map(EndDrivenPoint::amplitude));
    let best = case.best.map(|k| {
        let one = &case.points[k];
        let mut value = point(one, case.free);
        value["u"] = json!(one.point.orbit.start().ok().map(|state| state.u().to_vec()));
        let harmonics = one.harmonics.iter().map(|c| json!({ "re": c.re, "im": c.im }));
        value["harmonics"] = json!(harmonics.collect::<Vec<Value>>());
        value["multipliers"] = json!(one.point.spectrum.multipliers);
        value
    });
    json!({
        "sites": case.sites,
        "ends": case.ends,
        "omega": case.omega,
        "k_x": case.free,
        "end": case.end,
        "first_dark": first,
        "first_stable_dark": stable,
        "best": best,
        "from_rest": case.from_rest,
        "points": case.points.iter().map(|one| point(one, case.free)).collect::<Vec<Value>>(),
        "bifurcations": case.bifurcations.iter().map(bifurcation).collect::<Vec<Value>>(),
    })
}

/// The ranges of the search, in words.
fn searched(options: &EndDriven) -> String {
    let list = |values: &[String]| values.join(", ");
    format!(
        "α = 3/2, κ = 1, ρ = {}, drag {}, dashpot {}; N = {}; ω_d = {}; a from {} to {}, at most {} points a branch",
        crate::study::shown(options.rho),
        options.drag,
        options.dashpot,
        list(&options.lengths.iter().map(ToString::to_string).collect::<Vec<_>>()),
        list(&options.omegas.iter().map(ToString::to_string).collect::<Vec<_>>()),
        options.step,
        options.to,
        options.max_points
    )
}

impl EndDrivenStudy {
    /// The answer of the search, in a sentence.
    pub fn answer(&self) -> String {
        let dark = self.cases.iter().filter(|case| case.first()[0].is_some()).count();
        let stable: Vec<&EndDrivenCase> = self.cases.iter().filter(|case| case.best.is_some()).collect();
        let least = stable.iter().filter_map(|case| {
            let one = case.first()[1]?;
            Some((one.amplitude(), *case))
        });
        let all = self.cases.len();
        match least.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((a, case)) => format!(
                "Dark breathers on {dark} of {all} branches, stable ones on {}; the least drive amplitude of a stable one is {a:.4} \
                 (N = {}, ends {}, ω_d = {}).",
                stable.len(),
                case.sites,
                case.ends.words(),
                case.omega
            ),
            None if dark > 0 => format!("Dark breathers on {dark} of {all} branches, none of them stable."),
            None => format!("No dark breather on {all} branches."),
        }
    }
}

impl Report for EndDrivenStudy {
    fn json(&self) -> Value {
        let options = &self.options;
        json!({
            "alpha": 1.5,
            "kappa": 1.0,
            "rho": options.rho,
            "drag": options.drag,
            "dashpot": options.dashpot,
            "from": options.step,
            "to": options.to,
            "step": options.step,
            "max_points": options.max_points,
            "settle": SETTLE,
            "ramps": RAMPS,
            "after_ramp": AFTER_RAMP,
            "ring": RING,
            "answer": self.answer(),
            "cases": self.cases.iter().map(case_json).collect::<Vec<Value>>(),
            "integrator": "dop853-regularised",
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let shown = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.4}"));
        let rows: Vec<Vec<String>> = self
            .cases
            .iter()
            .map(|case| {
                let [first, stable] = case.first().map(|one| one.map(EndDrivenPoint::amplitude));
                let best = case.best.map(|k| &case.points[k]);
                let reached = case.from_rest.iter().filter(|run| run.ramp.is_some()).count();
                let rest = match case.from_rest.len() {
                    0 => "–".to_owned(),
                    tried => format!("{reached} of {tried}"),
                };
                vec![
                    case.sites.to_string(),
                    case.ends.words().to_owned(),
                    case.omega.to_string(),
                    case.points.len().to_string(),
                    shown(first),
                    shown(stable),
                    shown(best.map(EndDrivenPoint::amplitude)),
                    best.map_or_else(|| "–".to_owned(), |one| format!("{:.3}", one.background / case.free)),
                    rest,
                ]
            })
            .collect();
        let head = ["N", "ends", "omega_d", "points", "dark from a", "stable from", "best a", "B/K_x", "from rest"];
        format!(
            "{}\n{}\nSearched: {}.\nDark: the background alternates with a kink in the middle, and B >= K_x/2, K_x being that of the \
             conservative\nbreather of the same frequency. Best: the stable one with the largest B. From rest: how many of the stable \
             ones\nwith the strongest background a chain at rest reaches, by a ramp of {} or {} periods.\n",
            table(&head, &rows),
            self.answer(),
            searched(&self.options),
            RAMPS[0],
            RAMPS[1]
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let rows = self.cases.iter().flat_map(|case| {
            case.points.iter().map(|one| {
                let sign = if case.ends == Ends::InPhase { 1.0 } else { -1.0 };
                vec![
                    case.sites as f64,
                    sign,
                    case.omega,
                    one.amplitude(),
                    one.background,
                    case.free,
                    one.cosine,
                    one.centre,
                    one.point.spectrum.largest(),
                    one.point.spectrum.unstable() as f64,
                ]
            })
        });
        let columns =
            ["sites", "ends", "omega", "amplitude", "background", "k_x", "cosine", "centre", "max_modulus", "unstable"];
        Ok(named([("end-driven.csv", csv(&columns, rows)), ("end-driven.json", format!("{json}\n").into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("end-driven.png", picture(self)?)]))
    }
}

/// For each length and way to drive it that has kinks: the background against the drive amplitude;
/// then the best stable breather, its strains and multipliers.
#[cfg(feature = "plot")]
fn picture(study: &EndDrivenStudy) -> Result<crate::figures::Picture> {
    use crate::{
        figures::{Column, Kind, Line, Panel, Panels, panels},
        study::{multipliers_panel, stability_lines},
    };
    let relative = |case: &EndDrivenCase, one: &EndDrivenPoint| (one.amplitude(), one.background / case.free);
    let mut branches = Vec::new();
    for &sites in &study.options.lengths {
        let kinked: Vec<(&EndDrivenCase, &EndDrivenPoint)> = study
            .cases
            .iter()
            .filter(|case| case.sites == sites)
            .flat_map(|case| case.points.iter().filter(|one| one.kinked()).map(move |one| (case, one)))
            .collect();
        if kinked.is_empty() {
            continue;
        }
        let mut lines = stability_lines(&kinked, |(case, one)| relative(case, one), |(_, one)| one.point.stable());
        for line in &mut lines {
            line.name = format!("N = {sites}, {}", line.name);
        }
        branches.push(Panel::new(Kind::Cloud, ["drive amplitude a", "background B/Kₓ"], lines));
    }
    let strongest = study.cases.iter().filter_map(|case| Some((case, &case.points[case.best?])));
    let strongest = strongest.max_by(|(c, a), (d, b)| (a.background / c.free).total_cmp(&(b.background / d.free)));
    let mut columns = vec![Column::new("", branches)];
    let mut best = String::new();
    if let Some((case, one)) = strongest {
        let strains = one.harmonics.iter().enumerate().map(|(b, c)| ((b + 1) as f64, c.re));
        let lines = vec![Line::new("part in phase with the left half", strains)];
        let profile = Panel::new(Kind::Sites, ["bond n", "first harmonic of the strain"], lines);
        columns.push(Column::new("", [profile, multipliers_panel(&one.point)]));
        best = format!(
            " Right: the stable one with the largest B/Kₓ = {:.3}: N = {}, ends {}, ω_d = {}, a = {:.4}.",
            one.background / case.free,
            case.sites,
            case.ends.words(),
            case.omega,
            one.amplitude()
        );
    }
    let caption = format!(
        "Left: background B of the orbits with a kink in the middle, over Kₓ of the conservative dark breather of the same \
         frequency, all frequencies together.{best} Searched: {}. hertzchain {}.",
        searched(&study.options),
        env!("CARGO_PKG_VERSION")
    );
    Ok(panels(&Panels { title: "Chains driven at both ends".to_owned(), columns, caption })?)
}
