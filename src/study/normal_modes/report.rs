//! Normal modes as text, JSON, CSV and a picture.

use super::ModeStudy;
#[cfg(feature = "plot")]
use crate::study::shown;
use crate::{
    error::Result,
    orbits::{End, LinearMode, ModeBifurcation, ModeBranch, ModePoint},
    output::csv,
    present::table,
    scene::Quantity::{self, Energy, Frequency, Length, Number, Omega},
    study::{File, Report, SWITCHED_TABLE, named, scene_json, si::Scale, word},
};
use serde_json::{Value, json};

/// Number of linear modes below and above the followed one, by frequency, that the text table
/// shows.
const NEIGHBOURS: usize = 3;

/// The kinds of the numbers in a row of a table of points; see [`ModeStudy::row`].
const KINDS: [Quantity; 7] = [Length, Omega, Energy, Number, Length, Number, Number];

impl ModeStudy {
    fn scale(&self) -> Scale<'_> {
        Scale(self.si.as_ref())
    }

    /// The kind and the heading of the column with a frequency in text tables and pictures:
    /// `omega`, in SI units the frequency in hertz.
    fn frequency(&self) -> (Quantity, String) {
        match self.si {
            None => (Omega, "omega".to_owned()),
            Some(_) => (Frequency, self.scale().label("frequency", Frequency)),
        }
    }

    /// An angular frequency as a last column, in hertz; none unless in SI units.
    fn hertz(&self, omega: f64) -> Option<f64> {
        self.si.map(|units| units.to_si(Frequency, omega))
    }

    /// Names of columns, with `frequency` in SI units.
    fn with_hertz(&self, columns: &[&'static str]) -> Vec<&'static str> {
        columns.iter().copied().chain(self.si.map(|_| "frequency")).collect()
    }

    /// Site of the coordinate with the largest share of a linear mode, and whether this coordinate
    /// is that of a resonator.
    fn site_of(&self, mode: &LinearMode) -> (usize, bool) {
        self.modes.place(mode.leading)
    }

    fn linear_json(&self, mode: &LinearMode) -> Value {
        let (site, resonator) = self.site_of(mode);
        let omega = self.scale().told(Omega, mode.omega);
        let mut value =
            json!({ "omega": omega, "participation": mode.participation, "site": site, "resonator": resonator });
        self.scale().put_frequency(mode.omega, &mut value);
        value
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
    fn events(&self, branch: &ModeBranch) -> String {
        let (scale, frequency) = (self.scale(), self.frequency());
        let row = |(k, ModeBifurcation { kind, tau, point, .. }): (usize, &ModeBifurcation)| {
            let [a, omega] = [(Length, point.orbit.amplitude), (frequency.0, point.orbit.omega)]
                .map(|(quantity, x)| scale.shown(quantity, x, 8));
            vec![(k + 1).to_string(), word(kind), a, omega, format!("{tau:.8}")]
        };
        let rows: Vec<Vec<String>> = branch.bifurcations.iter().enumerate().map(row).collect();
        let unresolved = match branch.unresolved {
            0 => String::new(),
            count => format!("stretches with several bifurcations that were not separated: {count}\n"),
        };
        if branch.end == End::Stopped {
            return "bifurcations were not located\n".to_owned();
        }
        if rows.is_empty() {
            return "no bifurcation\n".to_owned() + &unresolved;
        }
        table(&["number", "bifurcation", &scale.label("a", Length), &frequency.1, "tau"], &rows) + &unresolved
    }

    /// The row of a point in a table, in the units of the chain.
    fn row(point: &ModePoint) -> [f64; 7] {
        let ModePoint { orbit, energy, participation, least_overlap, spectrum } = point;
        let unstable = point.unstable() as f64;
        [orbit.amplitude, orbit.omega, *energy, *participation, *least_overlap, spectrum.largest(), unstable]
    }

    /// Points, bifurcations and the last orbit of a branch.
    fn branch_json(&self, branch: &ModeBranch) -> Value {
        let scale = self.scale();
        let points = branch.points.iter().map(|point| {
            let mut value = json!({
                "amplitude": scale.told(Length, point.orbit.amplitude),
                "omega": scale.told(Omega, point.orbit.omega),
                "energy": scale.told(Energy, point.energy),
                "participation": point.participation,
                "least_overlap": scale.told(Length, point.least_overlap),
                "residual": point.orbit.residual,
                "max_modulus": point.spectrum.largest(),
                "unstable": point.unstable(),
            });
            scale.put_frequency(point.orbit.omega, &mut value);
            value
        });
        let bifurcation = |one: &ModeBifurcation| {
            let ModeBifurcation { kind, tau, point, .. } = one;
            let (amplitude, omega) = (scale.told(Length, point.orbit.amplitude), point.orbit.omega);
            let mut value =
                json!({ "kind": kind, "amplitude": amplitude, "omega": scale.told(Omega, omega), "tau": tau });
            scale.put_frequency(omega, &mut value);
            value
        };
        let last = last(branch);
        let [u, v] = self.displacements(last).map(|values| scale.all(Length, &values));
        let start = self.modes.state(&last.orbit);
        let start = [Some(start.u()), start.v()].map(|values| values.map(|values| scale.all(Length, values)));
        json!({
            "end": branch.end,
            "points": points.collect::<Vec<Value>>(),
            "bifurcations": branch.bifurcations.iter().map(bifurcation).collect::<Vec<Value>>(),
            "unresolved": branch.unresolved,
            "last": {
                "u": u,
                "v": v,
                "start": { "u": start[0], "v": start[1] },
                "newton": last.orbit.newton,
                "multipliers": last.spectrum.multipliers,
                "quality": last.spectrum.quality,
            },
        })
    }

    /// Points and bifurcations of a branch as tables.
    fn branch_text(&self, branch: &ModeBranch) -> String {
        let (scale, frequency) = (self.scale(), self.frequency());
        let points: Vec<Vec<String>> = branch
            .points
            .iter()
            .map(|point| {
                let [a, omega, energy, participation, least, largest, unstable] = Self::row(point);
                vec![
                    scale.shown(Length, a, 6),
                    scale.shown(frequency.0, omega, 10),
                    format!("{:.6e}", scale.told(Energy, energy)),
                    format!("{participation:.4}"),
                    scale.shown(Length, least, 4),
                    format!("{largest:.8}"),
                    unstable.to_string(),
                ]
            })
            .collect();
        let labels = [("a", Length), ("energy", Energy), ("least overlap", Length)];
        let [a, energy, least] = labels.map(|(name, kind)| scale.label(name, kind));
        let columns = [&*a, &*frequency.1, &*energy, "participation", &*least, "largest |lambda|", "outside"];
        format!(
            "{}\n{}\n{} points; the branch ended: {}\n",
            table(&columns, &points),
            self.events(branch),
            branch.points.len(),
            branch.end.words()
        )
    }

    /// Columns that are told in SI units only come last.
    fn branch_csv(&self, branch: &ModeBranch) -> Vec<u8> {
        let columns = ["amplitude", "omega", "energy", "participation", "least_overlap", "max_modulus", "unstable"];
        let told = |(value, quantity)| self.scale().told(quantity, value);
        let row = |point| Self::row(point).into_iter().zip(KINDS).map(told).chain(self.hertz(point.orbit.omega));
        csv(&self.with_hertz(&columns), branch.points.iter().map(|point| row(point).collect()))
    }
}

/// The last point of a branch.
fn last(branch: &ModeBranch) -> &ModePoint {
    &branch.points[branch.points.len() - 1]
}

impl Report for ModeStudy {
    fn json(&self) -> Value {
        let Self { scene, modes, branch, switched, .. } = self;
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
        self.scale().put_units(&mut value);
        value
    }

    fn text(&self) -> String {
        let (branch, linear, frequency) = (&self.branch, self.modes.linear(), self.frequency());
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
                    self.scale().shown(frequency.0, mode.omega, 12),
                    format!("{:.4}", mode.participation),
                    format!("{}{site}", if resonator { "resonator " } else { "" }),
                ]
            })
            .collect();
        let other = self.crossing().map_or(String::new(), |(number, other)| {
            format!("\nThe branch that crosses at bifurcation {number}:\n\n{}", self.branch_text(other))
        });
        format!(
            "{}{} linear modes, * the one that is followed\n\n{}{other}",
            table(&["mode", &frequency.1, "participation", "site"], &rows),
            linear.len(),
            self.branch_text(branch),
        ) + "least overlap: at the two times of rest; outside: multipliers outside the unit circle by more than their error\n"
            + &self.scale().line()
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let linear = self.modes.linear().iter().enumerate().map(|(k, mode)| {
            let (site, resonator) = self.site_of(mode);
            let omega = self.scale().told(Omega, mode.omega);
            let row = [k as f64 + 1.0, omega, mode.participation, site as f64, f64::from(u8::from(resonator))];
            row.into_iter().chain(self.hertz(mode.omega)).collect()
        });
        let linear = csv(&self.with_hertz(&["mode", "omega", "participation", "site", "resonator"]), linear);
        let mut files = named([
            ("mode-branch.csv", self.branch_csv(&self.branch)),
            ("linear-modes.csv", linear),
            ("mode.json", format!("{json}\n").into()),
        ]);
        files.extend(self.crossing().map(|(_, other)| (SWITCHED_TABLE.to_owned(), self.branch_csv(other))));
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

/// The frequency of the linear mode and the amplitude of the last orbit, for a caption.
#[cfg(feature = "plot")]
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

#[cfg(feature = "plot")]
fn picture(study: &ModeStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let (branch, last) = (&study.branch, last(&study.branch));
    let scale = study.scale();
    let frequency = study.frequency().0;
    let amplitude = |point: &ModePoint| scale.told(Length, point.orbit.amplitude.abs());
    let place = |point: &ModePoint| (amplitude(point), scale.told(frequency, point.orbit.omega));
    let points =
        |branch: &ModeBranch| crate::study::stability_lines(&branch.points, place, |point| point.unstable() == 0);
    let mut lines = points(branch);
    let near = study.modes.linear().iter().map(|mode| (0.0, scale.told(frequency, mode.omega)));
    lines.push(Line::new("linear modes", near));
    let marks = study.branches().flat_map(|branch| &branch.bifurcations);
    lines.push(Line::new("bifurcation", marks.map(|one| place(&one.point))));
    if let Some((_, other)) = study.crossing() {
        let names = ["stable, switched", "unstable, switched"];
        lines.extend(points(other).into_iter().zip(names).map(|(line, name)| Line { name: name.to_owned(), ..line }));
    }
    let share = |branch: &ModeBranch| {
        branch.points.iter().map(|point| (amplitude(point), point.participation)).collect::<Vec<_>>()
    };
    let mut shares = vec![Line::new("orbits", share(branch))];
    if let Some((_, other)) = study.crossing() {
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
    if let Some((number, other)) = study.crossing() {
        how += &format!(" From bifurcation {number}: {} orbits; {}.", other.points.len(), other.end.words());
    }
    let title = format!("A nonlinear normal mode of {}", study.scene.name());
    let columns = vec![Column::new("", left), Column::new("", right)];
    Ok(panels(&Panels { title, columns, caption: crate::study::provenance(&study.scene, &how) })?)
}
