//! A nonlinear normal mode of a conservative scene: the branch of orbits that begins as a linear
//! mode.

use crate::study::{
    Changes, ResultUnits, Work, format_short,
    options::options,
    orbits::branches::{
        self, Begun, BifurcationOptions, BranchOptions, BranchRow, BranchStudy, FollowCommand, Kept, SWITCHED,
        SWITCHED_FILES, SceneSource, crossed, files_of_branch,
    },
    scene_caption, scene_json,
    si::Scale,
};
use crate::{
    error::Result,
    orbits::{
        AnalysisLevel, Bifurcation, BifurcationKind, LinearMode, ModeBranch, ModeContinuation, ModeOrbit, Multiplier,
        NormalModes,
    },
    output::Array,
    report::{Column, Fixed, Json, Kind, Line, Panel, Panels, Power, Report, Rows, Short, Table},
    scene::{Quantity, Scene, Units},
};
use serde_json::json;

options! {
    /// A conservative scene, and a mode of it that is followed.
    pub struct FollowMode {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// Contacts of the scene are closed at rest: a static overlap, between walls or on a ring;
        /// or all beads just touch. Beads may differ. The initial state of the scene does not
        /// matter.
        scene: String = "defect".to_owned();
        /// Changes to the scene.
        changes: Changes = Changes::default();
        /// Number of the linear mode, the lowest frequency first [default: the most localised one].
        ///
        /// The parameter of the branch is the amplitude: the displacement, at the start of the
        /// period, of the bead or resonator that moves most in this mode. The first amplitude is
        /// --step, or a smaller one if the orbit found there is not near the mode.
        ///
        /// Beads that just touch between walls have no linear modes: there it is the mode under the
        /// static overlap 1 from which the load is taken away. Where such beads have springs of
        /// their own, the branch is that of the breather in the middle of the chain: about a bead
        /// if their number is odd, about a bond if it is even.
        linear_mode: Option<usize> = None, "K", (1 or more);
        /// What every branch asks for.
        branch: BranchOptions = BranchOptions::default();
        /// What is asked for about its bifurcations.
        more: BifurcationOptions = BifurcationOptions::default();
        /// The units of options and results.
        results: ResultUnits = ResultUnits::default();
    } command |command| command.mut_arg("resume", |arg| arg.conflicts_with_all(["scene", "set", "linear_mode"]))
}

/// The branch of a mode of a scene, whose setting has the equilibrium and the linear modes.
pub type ModeStudy = BranchStudy<ModeContinuation>;

impl Kept for ModeContinuation {
    type About = Scene;
    type Source = SceneSource;
    const NAMES: [&'static str; 3] = ["mode-branch.npz", "mode-spectra.store", "orbit mode"];
    const FILES: &'static str = files_of_branch!("mode-branch.npz", "mode-spectra.store", "");
    const OPTIONAL: &'static [&'static str] = &SWITCHED_FILES;
    /// At large amplitudes bifurcations take ten times as long as the orbits.
    const USUAL: AnalysisLevel = AnalysisLevel::Multipliers;

    fn source(scene: &Scene, branch: &ModeBranch) -> (SceneSource, Vec<Array<'static>>) {
        SceneSource::of(scene, 1, branch.orbits.iter().map(|orbit| branch.setting.state(orbit)))
    }

    fn made(source: SceneSource, _birth: Option<BifurcationKind>) -> Result<(Scene, NormalModes)> {
        let scene = source.scene()?;
        let modes = NormalModes::new(scene.chain())?;
        Ok((scene, modes))
    }

    fn units(scene: &Scene) -> Option<Units> {
        scene.units().copied()
    }

    fn quantity(&self, _setting: &NormalModes) -> Quantity {
        Quantity::Length
    }

    fn outline() -> Report {
        let report = Report::new("mode").table(linear_modes(&[], 0, None));
        report.table(points(BRANCH[0], &[], None)).table(bifurcations(BRANCH[1], &[], None))
    }

    fn report(study: &ModeStudy) -> Result<Report> {
        let ModeStudy { scene, branch, switched, si } = study;
        let (chosen, modes) = (branch.continuation.mode, &branch.setting);
        let numbered = numbered(modes);
        let report = Report::new("mode").si(si.as_ref()).fact("scene", scene.name()).fact("mode", chosen + 1);
        let report = report.table(linear_modes(&numbered, chosen, si.as_ref()));
        let vacuum = if modes.vacuum() {
            " Beads just touch: these are the modes under an overlap of one unit of length."
        } else {
            ""
        };
        let words = format!("Mode {} of {} linear modes is followed.{vacuum}", chosen + 1, numbered.len());
        let report = report.words(words);
        let mut both = branches::both(branch, switched);
        let report = both.try_fold(report, |report, (at, branch)| study.tell(report, at, branch))?;
        let report =
            branches::checked(report, branch, switched).fact("scene_file", scene_json(scene)).warnings(scene.doubts());
        let rows = branches::rows(branch);
        Ok(match rows.iter().rfind(|row| row.measures.is_some()) {
            Some(last) => report.picture(study.panels(last)),
            None => report,
        })
    }
}

impl FollowCommand for FollowMode {
    type Problem = ModeContinuation;

    fn options(&self) -> (&BranchOptions, BifurcationOptions, ResultUnits) {
        (&self.branch, self.more, self.results)
    }

    fn first(&self) -> Result<Work<'_, Begun<ModeContinuation>>> {
        let scene = Scene::load_with(&self.scene, &self.changes.set)?;
        self.within_ranges()?;
        let (si, modes) = (self.results.of(&scene), NormalModes::new(scene.chain())?);
        let mode = self.linear_mode.map_or(modes.most_localised(), |number| number - 1);
        let continuation = self.branch.continuation((scene.units(), Quantity::Length), 0.0, |to, step| {
            let continuation = ModeContinuation { mode, to, step, most_points: self.branch.max_points };
            continuation.check(&modes).map(|()| continuation)
        })?;
        Ok(Box::new(move |_, _| {
            let step = scene.in_file(Quantity::Length, continuation.step);
            let branch = Scale(scene.units()).given(continuation.begin(&modes), &[("step", Some(step))]);
            Ok((scene, branch?, si))
        }))
    }
}

/// The tables of the branch: points and bifurcations.
const BRANCH: [&str; 2] = ["mode-branch", "mode-bifurcations"];
/// Number of linear modes below and above the followed one, by frequency, that the text shows.
const NEIGHBOURS: usize = 3;

/// A linear mode with its number, and the site of the coordinate with its largest share; whether
/// this is that of a resonator.
pub(crate) type Numbered<'a> = (usize, &'a LinearMode, (usize, bool));

pub(crate) fn numbered(modes: &NormalModes) -> Vec<Numbered<'_>> {
    (1..).zip(modes.linear()).map(|(k, mode)| (k, mode, modes.place(mode.leading))).collect()
}

/// The linear modes; the text has those near the followed one, the `chosen`-th from 0 on.
pub(crate) fn linear_modes<'a>(modes: &'a [Numbered<'a>], chosen: usize, si: Option<&Units>) -> Rows<'a, Numbered<'a>> {
    let first = chosen.saturating_sub(NEIGHBOURS).min(modes.len().saturating_sub(2 * NEIGHBOURS + 1));
    Table::of("linear-modes", modes)
        .key("linear")
        .si(si)
        .in_text(first..first + 2 * NEIGHBOURS + 1)
        .col("mode", Short, "number by frequency", |row| row.0)
        .col("omega", Fixed(12), "frequency", |row| row.1.omega)
        .kind(Quantity::Omega)
        .col("participation", Fixed(4), "number of sites that take part", |row| row.1.participation)
        .col("site", Short, "of the bead or resonator that moves most", |row| row.2.0)
        .col("resonator", Short, "whether that is a resonator", |row| row.2.1)
}

fn points<'a>(
    name: &str,
    points: &'a [BranchRow<'a, ModeContinuation>],
    si: Option<&Units>,
) -> Rows<'a, BranchRow<'a, ModeContinuation>> {
    Table::of(name, points)
        .si(si)
        .col("amplitude", Fixed(6), "", |row| row.orbit.amplitude)
        .kind(Quantity::Length)
        .col("omega", Fixed(10), "frequency", |row| row.orbit.omega)
        .kind(Quantity::Omega)
        .col("energy", Power(6), "above that of the equilibrium", |row| Some(row.measures?.energy))
        .kind(Quantity::Energy)
        .col("participation", Fixed(4), "number of sites that take part", |row| Some(row.measures?.participation))
        .col("least_overlap", Fixed(4), "of all contacts at the two times of rest", |row| {
            Some(row.measures?.least_overlap)
        })
        .kind(Quantity::Length)
        .col("max_modulus", Fixed(8), "largest |lambda|", |row| Some(row.spectrum?.largest()))
        .col("unstable", Short, "multipliers outside the unit circle by more than their error", |row| {
            Some(row.spectrum?.unstable())
        })
        .col("residual", Json, "", |row| row.orbit.residual)
}

fn bifurcations<'a>(
    name: &str,
    all: &'a [Bifurcation<ModeContinuation>],
    si: Option<&Units>,
) -> Rows<'a, Bifurcation<ModeContinuation>> {
    branches::numbered(Table::of(name, all).si(si))
        .col("kind", Short, "", |one| one.kind.name())
        .col("amplitude", Fixed(8), "", |one| one.orbit.amplitude)
        .kind(Quantity::Length)
        .col("omega", Fixed(8), "frequency", |one| one.orbit.omega)
        .kind(Quantity::Omega)
        .col("tau", Fixed(8), "(lambda + 1/lambda)/2 of the multipliers that meet", |one| one.critical.tau)
}

impl ModeStudy {
    /// Displacements of beads and of resonators at the start of an orbit, from the equilibrium, as
    /// they are reported; zero where no resonator moves.
    fn displacements(&self, orbit: &ModeOrbit) -> [Vec<f64>; 2] {
        let n = self.scene.chain().sites();
        let mut both = [vec![0.0; n], vec![0.0; n]];
        for (k, xi) in orbit.shape.iter().enumerate() {
            let (site, resonator) = self.branch.setting.place(k);
            both[usize::from(resonator)][site] = orbit.amplitude * xi;
        }
        both.map(|values| Scale(self.si.as_ref()).all(Quantity::Length, &values))
    }

    /// Adds points, bifurcations and the last orbit of a branch.
    fn tell(&self, report: Report, at: Option<usize>, branch: &ModeBranch) -> Result<Report> {
        let (si, rows) = (self.si.as_ref(), branches::rows(branch));
        let last = rows.last().map(|last| {
            let [u, v] = self.displacements(last.orbit);
            let start = branch.setting.state(last.orbit);
            let start = [Some(start.u()), start.v()].map(|all| all.map(|all| Scale(si).all(Quantity::Length, all)));
            json!({
                "u": u,
                "v": v,
                "start": { "u": start[0], "v": start[1] },
                "newton": last.orbit.newton,
                "multipliers": last.spectrum.map(|spectrum| &spectrum.multipliers),
                "quality": last.spectrum.map(|spectrum| spectrum.quality),
            })
        });
        let names = if at.is_some() { SWITCHED } else { BRANCH };
        let tables = (points(names[0], &rows, si), bifurcations(names[1], &branch.bifurcations, si));
        branches::tell(report, &self.scene, (at, branch), tables, json!({ "last": last }))
    }

    fn panels(&self, last: &BranchRow<'_, ModeContinuation>) -> Panels {
        let (branch, scale) = (&self.branch, Scale(self.si.as_ref()));
        let (linear, other) = (branch.setting.linear(), crossed(&self.switched));
        let (frequency, omega) = scale.frequency();
        let amplitude = |orbit: &ModeOrbit| scale.reported(Quantity::Length, orbit.amplitude.abs());
        let place = |orbit: &ModeOrbit| (amplitude(orbit), scale.reported(frequency, orbit.omega));
        let mut lines = branches::lines(
            branch,
            &self.switched,
            |row| place(row.orbit),
            |spectrum| spectrum.unstable() == 0,
            |one| place(&one.orbit),
        );
        let near = linear.iter().filter(|_| !branch.setting.vacuum());
        let near = near.map(|mode| (0.0, scale.reported(frequency, mode.omega)));
        lines.push(Line::new("linear modes", near));
        let share = |(name, branch): (&str, &ModeBranch)| {
            let rows = branches::rows(branch).into_iter();
            let rows = rows.filter_map(|row| Some((amplitude(row.orbit), row.measures?.participation)));
            Line::new(name, rows)
        };
        let both = [("orbits", branch)].into_iter().chain(other.map(|(_, other)| ("switched", other)));
        let [u, v] = self.displacements(last.orbit).map(|all| (0..).map(f64::from).zip(all).collect::<Vec<_>>());
        let moved = v.iter().any(|(_, v)| *v != 0.0);
        let profile = [("beads", u)].into_iter().chain(moved.then_some(("resonators", v)));
        let profile = profile.map(|(name, points)| Line::new(name, points)).collect();
        let at = |one: &Multiplier| (one.re, one.im);
        let multipliers = last.spectrum.iter().flat_map(|spectrum| &spectrum.multipliers);
        let multipliers = Line::new("multipliers", multipliers.map(at));
        let [a, displacement] =
            ["amplitude a", "displacement, largest a"].map(|name| scale.label(name, Quantity::Length));
        let left = [
            Panel::new(Kind::Cloud, [&*a, &*omega], lines),
            Panel::new(Kind::Cloud, [&*a, "participation number"], both.map(share).collect()),
        ];
        let right = [
            Panel::new(Kind::Sites, ["site n", &*displacement], profile),
            Panel::new(Kind::Plane, ["Re λ", "Im λ"], vec![multipliers]),
        ];
        let mode = branch.continuation.mode;
        let (omega, a) = (linear[mode].omega, last.orbit.amplitude);
        let frequency = match self.si {
            None => format!("ω₀ = {omega:.6}; on the right a = {a}"),
            Some(_) => {
                let [hertz, metres] =
                    [(frequency, omega), (Quantity::Length, a)].map(|(kind, x)| scale.reported(kind, x));
                format!("ω₀/2π = {} Hz; on the right a = {} m", format_short(hertz), format_short(metres))
            }
        };
        let how = format!(
            "{} orbits; mode {} of {}, {frequency}, residual {:.1e}.{}",
            branches::rows(branch).len(),
            mode + 1,
            linear.len(),
            last.orbit.residual,
            branches::from(&self.switched)
        );
        Panels {
            title: format!("{}: a nonlinear normal mode", self.scene.name()),
            columns: [left, right].map(|panels| Column::new("", branches::filled(panels))).into(),
            caption: scene_caption(&self.scene, &how),
        }
    }
}
