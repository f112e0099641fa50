//! Normal modes as text, JSON, CSV and a picture.

use super::ModeStudy;
use crate::{
    error::Result,
    orbits::{LinearMode, ModeBifurcation, ModeBranch, ModePoint},
    output::csv,
    present::table,
    study::{File, Report, SWITCHED_TABLE, named, scene_json, word},
};
use serde_json::{Value, json};

/// Number of linear modes below and above the followed one, by frequency, that the text table
/// shows.
const NEIGHBOURS: usize = 3;

impl ModeStudy {
    /// Site of the coordinate with the largest share of a linear mode, and whether this coordinate
    /// is that of a resonator.
    fn site_of(&self, mode: &LinearMode) -> (usize, bool) {
        self.modes.place(mode.leading)
    }

    fn linear_json(&self, mode: &LinearMode) -> Value {
        let (site, resonator) = self.site_of(mode);
        json!({ "omega": mode.omega, "participation": mode.participation, "site": site, "resonator": resonator })
    }

    /// Displacements of beads and of resonators at the start of an orbit, from the equilibrium;
    /// zero where no resonator moves.
    fn displacements(&self, point: &ModePoint) -> [Vec<f64>; 2] {
        let n = self.scene.chain().sites();
        let mut both = [vec![0.0; n], vec![0.0; n]];
        for (k, xi) in point.orbit.shape.iter().enumerate() {
            let (site, resonator) = self.modes.place(k);
            both[usize::from(resonator)][site] = point.orbit.amplitude * xi;
        }
        both
    }

    /// The branch that crosses, if one was followed, and the number of its bifurcation.
    fn crossing(&self) -> Option<(usize, &ModeBranch)> {
        let (number, other) = self.switched.as_ref()?;
        Some((*number, other.as_ref().ok()?))
    }

    /// The branch and, if it was followed, the one that crosses it.
    fn branches(&self) -> impl Iterator<Item = &ModeBranch> {
        std::iter::once(&self.branch).chain(self.crossing().map(|(_, other)| other))
    }

    /// The bifurcations of a branch as a table.
    fn events(branch: &ModeBranch) -> String {
        let row = |(k, ModeBifurcation { kind, tau, point, .. }): (usize, &ModeBifurcation)| {
            let [a, omega] = [point.orbit.amplitude, point.orbit.omega].map(|x| format!("{x:.8}"));
            vec![(k + 1).to_string(), word(kind), a, omega, format!("{tau:.8}")]
        };
        let rows: Vec<Vec<String>> = branch.bifurcations.iter().enumerate().map(row).collect();
        let unresolved = match branch.unresolved {
            0 => String::new(),
            count => format!("stretches with several bifurcations that were not separated: {count}\n"),
        };
        if rows.is_empty() {
            return "no bifurcation\n".to_owned() + &unresolved;
        }
        table(&["number", "bifurcation", "a", "omega", "tau"], &rows) + &unresolved
    }

    /// The row of a point in a table.
    fn row(point: &ModePoint) -> [f64; 7] {
        let ModePoint { orbit, energy, participation, least_overlap, spectrum } = point;
        let unstable = point.unstable() as f64;
        [orbit.amplitude, orbit.omega, *energy, *participation, *least_overlap, spectrum.largest(), unstable]
    }

    /// Points, bifurcations and the last orbit of a branch.
    fn branch_json(&self, branch: &ModeBranch) -> Value {
        let points = branch.points.iter().map(|point| {
            json!({
                "amplitude": point.orbit.amplitude,
                "omega": point.orbit.omega,
                "energy": point.energy,
                "participation": point.participation,
                "least_overlap": point.least_overlap,
                "residual": point.orbit.residual,
                "max_modulus": point.spectrum.largest(),
                "unstable": point.unstable(),
            })
        });
        let bifurcation = |one: &ModeBifurcation| {
            let ModeBifurcation { kind, tau, point, .. } = one;
            json!({ "kind": kind, "amplitude": point.orbit.amplitude, "omega": point.orbit.omega, "tau": tau })
        };
        let last = last(branch);
        let [u, v] = self.displacements(last);
        let start = self.modes.state(&last.orbit);
        json!({
            "end": branch.end,
            "points": points.collect::<Vec<Value>>(),
            "bifurcations": branch.bifurcations.iter().map(bifurcation).collect::<Vec<Value>>(),
            "unresolved": branch.unresolved,
            "last": {
                "u": u,
                "v": v,
                "start": { "u": start.u(), "v": start.v() },
                "newton": last.orbit.newton,
                "multipliers": last.spectrum.multipliers,
                "quality": last.spectrum.quality,
            },
        })
    }

    /// Points and bifurcations of a branch as tables.
    fn branch_text(branch: &ModeBranch) -> String {
        let points: Vec<Vec<String>> = branch
            .points
            .iter()
            .map(|point| {
                let [a, omega, energy, participation, least, largest, unstable] = Self::row(point);
                vec![
                    format!("{a:.6}"),
                    format!("{omega:.10}"),
                    format!("{energy:.6e}"),
                    format!("{participation:.4}"),
                    format!("{least:.4}"),
                    format!("{largest:.8}"),
                    unstable.to_string(),
                ]
            })
            .collect();
        let columns = ["a", "omega", "energy", "participation", "least overlap", "largest |lambda|", "outside"];
        format!(
            "{}\n{}\n{} points; the branch ended: {}\n",
            table(&columns, &points),
            Self::events(branch),
            branch.points.len(),
            branch.end.words()
        )
    }

    fn branch_csv(branch: &ModeBranch) -> Vec<u8> {
        let columns = ["amplitude", "omega", "energy", "participation", "least_overlap", "max_modulus", "unstable"];
        csv(&columns, branch.points.iter().map(|point| Self::row(point).to_vec()))
    }
}

/// The last point of a branch.
fn last(branch: &ModeBranch) -> &ModePoint {
    &branch.points[branch.points.len() - 1]
}

impl Report for ModeStudy {
    fn json(&self) -> Value {
        let Self { scene, modes, branch, switched } = self;
        let mut value = self.branch_json(branch);
        value["scene"] = json!(scene.name());
        value["mode"] = json!(branch.continuation.mode + 1);
        value["linear"] = modes.linear().iter().map(|mode| self.linear_json(mode)).collect();
        if let Some((number, other)) = switched {
            match other {
                Ok(other) => value["switched"] = self.branch_json(other),
                Err(why) => value["switched"]["failure"] = json!(why),
            }
            value["switched"]["at"] = json!(number);
        }
        value["scene_file"] = scene_json(scene);
        value["version"] = json!(env!("CARGO_PKG_VERSION"));
        value
    }

    fn text(&self) -> String {
        let (branch, linear) = (&self.branch, self.modes.linear());
        let chosen = branch.continuation.mode;
        let first = chosen.saturating_sub(NEIGHBOURS).min(linear.len().saturating_sub(2 * NEIGHBOURS + 1));
        let rows: Vec<Vec<String>> = linear
            .iter()
            .enumerate()
            .skip(first)
            .take(2 * NEIGHBOURS + 1)
            .map(|(k, mode)| {
                let (site, resonator) = self.site_of(mode);
                vec![
                    format!("{}{}", k + 1, if k == chosen { " *" } else { "" }),
                    format!("{:.12}", mode.omega),
                    format!("{:.4}", mode.participation),
                    format!("{}{site}", if resonator { "resonator " } else { "" }),
                ]
            })
            .collect();
        let other = self.crossing().map_or(String::new(), |(number, other)| {
            format!("\nThe branch that crosses at bifurcation {number}:\n\n{}", Self::branch_text(other))
        });
        format!(
            "{}{} linear modes, * the one that is followed\n\n{}{other}",
            table(&["mode", "omega", "participation", "site"], &rows),
            linear.len(),
            Self::branch_text(branch),
        ) + "least overlap: at the two times of rest; outside: multipliers outside the unit circle by more than their error\n"
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let linear = self.modes.linear().iter().enumerate().map(|(k, mode)| {
            let (site, resonator) = self.site_of(mode);
            vec![k as f64 + 1.0, mode.omega, mode.participation, site as f64, f64::from(u8::from(resonator))]
        });
        let linear = csv(&["mode", "omega", "participation", "site", "resonator"], linear);
        let mut files = named([
            ("mode-branch.csv", Self::branch_csv(&self.branch)),
            ("linear-modes.csv", linear),
            ("mode.json", format!("{json}\n").into()),
        ]);
        files.extend(self.crossing().map(|(_, other)| (SWITCHED_TABLE.to_owned(), Self::branch_csv(other))));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("mode.png", picture(self)?)]))
    }

    fn remark(&self) -> Option<String> {
        if let Some((_, Err(why))) = &self.switched {
            return Some(format!("error: {why}"));
        }
        let short = self.branches().find(|branch| !branch.end.answers())?;
        Some(format!("error: the branch ended: {}", short.end.words()))
    }

    fn succeeded(&self) -> bool {
        !matches!(self.switched, Some((_, Err(_)))) && self.branches().all(|branch| branch.end.answers())
    }
}

#[cfg(feature = "plot")]
fn picture(study: &ModeStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let (branch, last) = (&study.branch, last(&study.branch));
    let points = |branch: &ModeBranch| {
        crate::study::stability_lines(
            &branch.points,
            |point: &ModePoint| (point.orbit.amplitude.abs(), point.orbit.omega),
            |point| point.unstable() == 0,
        )
    };
    let mut lines = points(branch);
    let near = study.modes.linear().iter().map(|mode| (0.0, mode.omega));
    lines.push(Line::new("linear modes", near));
    let place = |one: &ModeBifurcation| (one.point.orbit.amplitude.abs(), one.point.orbit.omega);
    lines.push(Line::new("bifurcation", study.branches().flat_map(|branch| &branch.bifurcations).map(place)));
    if let Some((_, other)) = study.crossing() {
        let names = ["stable, switched", "unstable, switched"];
        lines.extend(points(other).into_iter().zip(names).map(|(line, name)| Line { name: name.to_owned(), ..line }));
    }
    let share = |branch: &ModeBranch| {
        branch.points.iter().map(|point| (point.orbit.amplitude.abs(), point.participation)).collect::<Vec<_>>()
    };
    let mut shares = vec![Line::new("orbits", share(branch))];
    if let Some((_, other)) = study.crossing() {
        shares.push(Line::new("switched", share(other)));
    }
    let [u, v] = study.displacements(last);
    let sites =
        |name: &str, values: &[f64]| Line::new(name, values.iter().enumerate().map(|(i, value)| (i as f64, *value)));
    let mut profile = vec![sites("beads", &u)];
    if v.iter().any(|v| *v != 0.0) {
        profile.push(sites("resonators", &v));
    }
    let at = |one: &crate::orbits::Multiplier| (one.re, one.im);
    let multipliers = Line::new("multipliers", last.spectrum.multipliers.iter().map(at));
    let left = vec![
        Panel::new(Kind::Cloud, ["amplitude a", "frequency ω"], lines),
        Panel::new(Kind::Cloud, ["amplitude a", "participation number"], shares),
    ];
    let right = vec![
        Panel::new(Kind::Sites, ["site n", "displacement at a"], profile),
        Panel::new(Kind::Plane, ["Re λ", "Im λ"], vec![multipliers]),
    ];
    let mut how = format!(
        "{} orbits; mode {} of {}, ω₀ = {:.6}; on the right a = {}, residual {:.1e}.",
        branch.points.len(),
        branch.continuation.mode + 1,
        study.modes.linear().len(),
        study.modes.linear()[branch.continuation.mode].omega,
        last.orbit.amplitude,
        last.orbit.residual
    );
    if let Some((number, other)) = study.crossing() {
        how += &format!(" From bifurcation {number}: {} orbits; {}.", other.points.len(), other.end.words());
    }
    let title = format!("A nonlinear normal mode of {}", study.scene.name());
    let columns = vec![Column::new("", left), Column::new("", right)];
    Ok(panels(&Panels { title, columns, caption: crate::study::provenance(&study.scene, &how) })?)
}
