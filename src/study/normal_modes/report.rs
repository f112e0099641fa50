//! What normal modes report.

use super::ModeStudy;
use crate::{
    orbits::{LinearMode, ModeBranch, ModePoint},
    report::{
        Column,
        Digits::{Fixed, Json, Power, Short},
        Kind, Line, Panel, Panels, Report, Rows, Table,
    },
    scene::Quantity::{Energy, Frequency, Length, Omega},
    study::{
        branch_end, branch_failure, followed_branches, scene_caption, scene_json, shown, si::Scale, stability_lines,
        word,
    },
};
use serde_json::{Value, json};

/// Number of linear modes below and above the followed one, by frequency, that the text shows.
const NEIGHBOURS: usize = 3;

impl ModeStudy {
    fn scale(&self) -> Scale<'_> {
        Scale(self.si.as_ref())
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

    /// Some linear modes, with their numbers.
    fn linear<'a>(
        &self,
        name: &str,
        key: &str,
        modes: &'a [(usize, &'a LinearMode)],
    ) -> Rows<'a, (usize, &'a LinearMode)> {
        Table::of(name, modes)
            .key(key)
            .si(self.si.as_ref())
            .col("mode", Short, "number of the linear mode", |row| row.0)
            .col("omega", Fixed(12), "", |row| row.1.omega)
            .kind(Omega)
            .col("participation", Fixed(4), "", |row| row.1.participation)
            .col("site", Short, "site that moves most", |row| self.modes.place(row.1.leading).0)
            .col("resonator", Short, "whether its resonator does", |row| self.modes.place(row.1.leading).1)
    }

    /// Points and bifurcations of a branch, in tables with these names and fields of the JSON.
    fn tables(&self, branch: &ModeBranch, names: [&str; 2], keys: [&str; 2]) -> [Table; 2] {
        let numbered: Vec<_> = (1_u64..).zip(&branch.bifurcations).collect();
        let bifurcations = Table::of(names[1], &numbered)
            .key(keys[1])
            .si(self.si.as_ref())
            .col("number", Short, "", |row| row.0)
            .col("kind", Short, "", |row| word(&row.1.kind))
            .col("amplitude", Fixed(8), "", |row| row.1.point.orbit.amplitude)
            .kind(Length)
            .col("omega", Fixed(8), "", |row| row.1.point.orbit.omega)
            .kind(Omega)
            .col("tau", Fixed(8), "half trace of the two multipliers that meet", |row| row.1.tau);
        let points = Table::of(names[0], &branch.points)
            .key(keys[0])
            .si(self.si.as_ref())
            .col("amplitude", Fixed(6), "", |point| point.orbit.amplitude)
            .kind(Length)
            .col("omega", Fixed(10), "", |point| point.orbit.omega)
            .kind(Omega)
            .col("energy", Power(6), "", |point| point.energy)
            .kind(Energy)
            .col("participation", Fixed(4), "", |point| point.participation)
            .col("least_overlap", Fixed(4), "at the two times of rest", |point| point.least_overlap)
            .kind(Length)
            .col("max_modulus", Fixed(8), "largest modulus of a multiplier", |point| point.spectrum.largest())
            .col("unstable", Short, "multipliers outside the unit circle by more than their error", ModePoint::unstable)
            .col("residual", Json, "", |point| point.orbit.residual);
        [points.done(), bifurcations.done()]
    }

    /// The last orbit of a branch.
    fn last(&self, branch: &ModeBranch) -> Value {
        let (scale, last) = (self.scale(), last(branch));
        let [u, v] = self.displacements(last).map(|values| scale.all(Length, &values));
        let start = self.modes.state(&last.orbit);
        let start = [Some(start.u()), start.v()].map(|values| values.map(|values| scale.all(Length, values)));
        json!({
            "u": u,
            "v": v,
            "start": { "u": start[0], "v": start[1] },
            "newton": last.orbit.newton,
            "multipliers": last.spectrum.multipliers,
            "quality": last.spectrum.quality,
        })
    }

    /// The report.
    pub fn report(&self) -> Report {
        let Self { scene, modes, branch, switched, si } = self;
        let ended = |branch: &ModeBranch| {
            let unresolved = match branch.unresolved {
                0 => String::new(),
                count => format!(" Stretches with several bifurcations that were not separated: {count}."),
            };
            branch_end(branch.points.len(), branch.bifurcations.len(), branch.end) + &unresolved
        };
        let linear: Vec<(usize, &LinearMode)> = (1..).zip(modes.linear()).collect();
        let chosen = branch.continuation.mode;
        let first = chosen.saturating_sub(NEIGHBOURS).min(linear.len().saturating_sub(2 * NEIGHBOURS + 1));
        let near = &linear[first..linear.len().min(first + 2 * NEIGHBOURS + 1)];
        let [points, bifurcations] = self.tables(branch, ["mode-branch", "bifurcations"], ["points", "bifurcations"]);
        let mut report = Report::new("mode")
            .fact("scene", scene.name())
            .fact("mode", chosen + 1)
            .fact("end", branch.end)
            .fact("unresolved", branch.unresolved)
            .fact("last", self.last(branch))
            .fact("scene_file", scene_json(scene))
            .table(self.linear("neighbours", "", near).done())
            .table(self.linear("linear-modes", "linear", &linear).hidden())
            .words(format!("{} linear modes; number {} is followed.", linear.len(), chosen + 1))
            .table(points)
            .table(bifurcations)
            .words(ended(branch));
        match switched {
            Some((number, Ok(other))) => {
                let [points, bifurcations] = self.tables(other, ["switched-branch", "switched-bifurcations"], ["", ""]);
                let json = json!({
                    "at": number,
                    "end": other.end,
                    "points": points.json(),
                    "bifurcations": bifurcations.json(),
                    "unresolved": other.unresolved,
                    "last": self.last(other),
                });
                report = report
                    .fact("switched", json)
                    .words(format!("The branch that crosses at bifurcation {number}:"))
                    .table(points)
                    .table(bifurcations)
                    .words(ended(other));
            }
            Some((number, Err(why))) => report = report.fact("switched", json!({ "at": number, "failure": why })),
            None => {}
        }
        let ends = followed_branches(branch, switched).map(|branch| branch.end);
        report.si(si.as_ref()).failure(branch_failure(switched, ends)).picture(picture(self))
    }
}

/// The last point of a branch.
fn last(branch: &ModeBranch) -> &ModePoint {
    &branch.points[branch.points.len() - 1]
}

/// The frequency of the linear mode and the amplitude of the last orbit, for a caption.
fn frequency_words(study: &ModeStudy) -> String {
    let omega = study.modes.linear()[study.branch.continuation.mode].omega;
    let a = last(&study.branch).orbit.amplitude;
    match study.si {
        None => format!("ω₀ = {omega:.6}; on the right a = {a}"),
        Some(units) => {
            let [hertz, metres] = [(Frequency, omega), (Length, a)].map(|(kind, x)| shown(units.to_si(kind, x)));
            format!("ω₀/2π = {hertz} Hz; on the right a = {metres} m")
        }
    }
}

fn picture(study: &ModeStudy) -> Panels {
    let (branch, last) = (&study.branch, last(&study.branch));
    let scale = study.scale();
    let frequency = if study.si.is_some() { Frequency } else { Omega };
    let amplitude = |point: &ModePoint| scale.told(Length, point.orbit.amplitude.abs());
    let place = |point: &ModePoint| (amplitude(point), scale.told(frequency, point.orbit.omega));
    let points = |branch: &ModeBranch| stability_lines(&branch.points, place, |point| point.unstable() == 0);
    let mut lines = points(branch);
    let near = study.modes.linear().iter().map(|mode| (0.0, scale.told(frequency, mode.omega)));
    lines.push(Line::new("linear modes", near));
    let marks = followed_branches(branch, &study.switched).flat_map(|branch| &branch.bifurcations);
    lines.push(Line::new("bifurcation", marks.map(|one| place(&one.point))));
    if let Some((_, Ok(other))) = &study.switched {
        let names = ["stable, switched", "unstable, switched"];
        lines.extend(points(other).into_iter().zip(names).map(|(line, name)| Line { name: name.to_owned(), ..line }));
    }
    let share = |branch: &ModeBranch| {
        branch.points.iter().map(|point| (amplitude(point), point.participation)).collect::<Vec<_>>()
    };
    let mut shares = vec![Line::new("orbits", share(branch))];
    if let Some((_, Ok(other))) = &study.switched {
        shares.push(Line::new("switched", share(other)));
    }
    let [u, v] = study.displacements(last).map(|values| scale.all(Length, &values));
    let sites =
        |name: &str, values: &[f64]| Line::new(name, values.iter().enumerate().map(|(i, value)| (i as f64, *value)));
    let mut profile = vec![sites("beads", &u)];
    if v.iter().any(|v| *v != 0.0) {
        profile.push(sites("resonators", &v));
    }
    let at = |one: &crate::orbits::Multiplier| (one.re, one.im);
    let multipliers = Line::new("multipliers", last.spectrum.multipliers.iter().map(at));
    let symbol = if frequency == Frequency { "frequency ω/2π" } else { "frequency ω" };
    let labels = [("amplitude a", Length), (symbol, frequency), ("displacement at a", Length)];
    let [a, omega, displacement] = labels.map(|(name, kind)| scale.label(name, kind));
    let left = vec![
        Panel::new(Kind::Cloud, [&*a, &*omega], lines),
        Panel::new(Kind::Cloud, [&*a, "participation number"], shares),
    ];
    let right = vec![
        Panel::new(Kind::Sites, ["site n", &*displacement], profile),
        Panel::new(Kind::Plane, ["Re λ", "Im λ"], vec![multipliers]),
    ];
    let mut how = format!(
        "{} orbits; mode {} of {}, {}, residual {:.1e}.",
        branch.points.len(),
        branch.continuation.mode + 1,
        study.modes.linear().len(),
        frequency_words(study),
        last.orbit.residual
    );
    if let Some((number, Ok(other))) = &study.switched {
        how += &format!(" From bifurcation {number}: {} orbits; {}.", other.points.len(), other.end.words());
    }
    let title = format!("A nonlinear normal mode of {}", study.scene.name());
    let columns = vec![Column::new("", left), Column::new("", right)];
    Panels { title, columns, caption: scene_caption(&study.scene, &how) }
}
