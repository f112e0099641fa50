//! Normal modes as text, JSON, CSV and a picture.

use super::ModeStudy;
use crate::{
    error::Result,
    orbits::{End, LinearMode, ModeBifurcation, ModePoint},
    output::csv,
    present::table,
    study::{File, Report, named, scene_json, word},
};
use serde_json::{Value, json};

/// Number of linear modes below and above the followed one, by frequency, that the text table
/// shows.
const NEIGHBOURS: usize = 3;

impl ModeStudy {
    /// Site of the largest share of a linear mode, and whether it is that of a resonator.
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

    fn last(&self) -> &ModePoint {
        &self.branch.points[self.branch.points.len() - 1]
    }

    /// The bifurcations as a table.
    fn events(&self) -> String {
        let row = |ModeBifurcation { kind, tau, point }: &ModeBifurcation| {
            let [a, omega] = [point.orbit.amplitude, point.orbit.omega].map(|x| format!("{x:.8}"));
            vec![word(kind), a, omega, format!("{tau:.8}")]
        };
        let rows: Vec<Vec<String>> = self.branch.bifurcations.iter().map(row).collect();
        let unresolved = match self.branch.unresolved {
            0 => String::new(),
            count => format!("stretches with several bifurcations that were not separated: {count}\n"),
        };
        if rows.is_empty() {
            return "no bifurcation\n".to_owned() + &unresolved;
        }
        table(&["bifurcation", "a", "omega", "tau"], &rows) + &unresolved
    }

    /// The numbers of a point in tables.
    fn row(point: &ModePoint) -> [f64; 7] {
        let ModePoint { orbit, energy, participation, least_overlap, spectrum } = point;
        let unstable = point.unstable() as f64;
        [orbit.amplitude, orbit.omega, *energy, *participation, *least_overlap, spectrum.largest(), unstable]
    }
}

impl Report for ModeStudy {
    fn json(&self) -> Value {
        let Self { scene, modes, branch } = self;
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
            let ModeBifurcation { kind, tau, point } = one;
            json!({ "kind": kind, "amplitude": point.orbit.amplitude, "omega": point.orbit.omega, "tau": tau })
        };
        let last = self.last();
        let [u, v] = self.displacements(last);
        let start = modes.state(&last.orbit);
        json!({
            "scene": scene.name(),
            "mode": branch.continuation.mode + 1,
            "linear": modes.linear().iter().map(|mode| self.linear_json(mode)).collect::<Vec<Value>>(),
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
            "scene_file": scene_json(scene),
            "version": env!("CARGO_PKG_VERSION"),
        })
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
            "{}{} linear modes, * the one that is followed\n\n{}\n{}\n{} points; the branch ended: {}\n",
            table(&["mode", "omega", "participation", "site"], &rows),
            linear.len(),
            table(&columns, &points),
            self.events(),
            branch.points.len(),
            branch.end.words()
        ) + "least overlap: at the two times of rest; outside: multipliers outside the unit circle by more than their error\n"
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let columns = ["amplitude", "omega", "energy", "participation", "least_overlap", "max_modulus", "unstable"];
        let points = csv(&columns, self.branch.points.iter().map(|point| Self::row(point).to_vec()));
        let linear = self.modes.linear().iter().enumerate().map(|(k, mode)| {
            let (site, resonator) = self.site_of(mode);
            vec![k as f64 + 1.0, mode.omega, mode.participation, site as f64, f64::from(u8::from(resonator))]
        });
        let linear = csv(&["mode", "omega", "participation", "site", "resonator"], linear);
        Ok(named([
            ("mode-branch.csv", points),
            ("linear-modes.csv", linear),
            ("mode.json", format!("{json}\n").into()),
        ]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("mode.png", picture(self)?)]))
    }

    fn remark(&self) -> Option<String> {
        (!self.succeeded()).then(|| format!("error: the branch ended: {}", self.branch.end.words()))
    }

    fn succeeded(&self) -> bool {
        matches!(self.branch.end, End::Reached | End::TurnedBack)
    }
}

#[cfg(feature = "plot")]
fn picture(study: &ModeStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let (branch, last) = (&study.branch, study.last());
    let mut lines = crate::study::stability_lines(
        &branch.points,
        |point: &ModePoint| (point.orbit.amplitude, point.orbit.omega),
        |point| point.unstable() == 0,
    );
    let near = study.modes.linear().iter().map(|mode| (0.0, mode.omega));
    lines.push(Line::new("linear modes", near));
    let place = |one: &ModeBifurcation| (one.point.orbit.amplitude, one.point.orbit.omega);
    lines.push(Line::new("bifurcation", branch.bifurcations.iter().map(place)));
    let share = branch.points.iter().map(|point| (point.orbit.amplitude, point.participation));
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
        Panel::new(Kind::Cloud, ["amplitude a", "participation number"], vec![Line::new("orbits", share)]),
    ];
    let right = vec![
        Panel::new(Kind::Sites, ["site n", "displacement at a"], profile),
        Panel::new(Kind::Plane, ["Re λ", "Im λ"], vec![multipliers]),
    ];
    let how = format!(
        "{} orbits; mode {} of {}, ω₀ = {:.6}; on the right a = {}, residual {:.1e}.",
        branch.points.len(),
        branch.continuation.mode + 1,
        study.modes.linear().len(),
        study.modes.linear()[branch.continuation.mode].omega,
        last.orbit.amplitude,
        last.orbit.residual
    );
    let title = format!("A nonlinear normal mode of {}", study.scene.name());
    let columns = vec![Column::new("", left), Column::new("", right)];
    Ok(panels(&Panels { title, columns, caption: crate::study::provenance(&study.scene, &how) })?)
}
