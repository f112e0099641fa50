//! What exact orbits and their branches report.

use super::{DarkStudy, DoubledStudy, OrbitStudy};
use crate::{
    error::Result,
    numerics::least_by,
    orbits::{Bifurcation, Branch, Continuation, Extent, Kind, Multiplier, Parameter, Setting, Spectrum},
    report::{self, Column, Fixed, Hidden, Json, Line, Panel, Panels, Power, Report, Short, Table, fields},
    study::{
        center_word,
        orbits::branches::{BranchRow, branch_npz, ended, filled, gaps, lines, rows, shows},
        params_words,
    },
};
use serde_json::json;

/// Largest number of multipliers outside the circle in the JSON of each point of a branch.
const LEADING: usize = 8;
/// Moduli above which an orbit is drawn as unstable: roundings of multipliers on the circle stay
/// below.
const UNSTABLE: f64 = 1.0 + 1e-6;
/// Kinds of multipliers, and their names in legends.
pub(crate) const KINDS: [(Kind, &str); 4] = [
    (Kind::Circle, "on the circle"),
    (Kind::Real, "positive real"),
    (Kind::Negative, "negative real"),
    (Kind::Quartet, "quartet"),
];

impl DarkStudy {
    /// The report: the orbit and its multipliers, with measured errors of both.
    pub fn report(&self) -> Report {
        let center = center_word(self.center);
        let title = format!("Dark breather about a {center}");
        self.study.facts(Report::new("dark-breather").fact("center", center)).picture(self.study.picture(title))
    }
}

/// The multipliers outside the circle.
pub(super) fn outside(multipliers: &[Multiplier]) -> Table {
    let all: Vec<&Multiplier> = multipliers.iter().filter(|one| one.modulus > 1.0).collect();
    Table::of("multipliers-outside", &all)
        .key("")
        .col("re", Fixed(12), "real part", |one| one.re)
        .col("im", Fixed(12), "imaginary part", |one| one.im)
        .col("modulus", Fixed(12), "", |one| one.modulus)
        .col("error", Power(1), "of the modulus", |one| one.error)
        .col("kind", Short, "", |one| one.kind.name())
        .done()
}

impl OrbitStudy {
    /// Adds the orbit to a report.
    fn facts(&self, report: Report) -> Report {
        let Self { orbit, spectrum, extent, e_b, forces, shooting } = self;
        let Setting { params, sites, omega_b, .. } = orbit.setting;
        let half = (sites / 2) as i64;
        report
            .fact("format", "hertzchain orbit")
            .fact("format_version", 1)
            .facts(params)
            .fact("omega", params.omega())
            .fact("omega_b", omega_b)
            .fact("sites", sites)
            .fact("turns", orbit.setting.turns)
            .fact("n", (-half..=half).collect::<Vec<_>>())
            .facts(fields!(orbit => x(), y(); orbit.setting => period(); orbit => residual))
            .facts(extent)
            .fact("c_x_asked", orbit.setting.c_x)
            .fact("e_b", e_b)
            .fact("mean_force", forces.mean())
            .fact("mean_force_spread", forces.spread())
            .facts(fields!(orbit => newton; spectrum => multipliers))
            .fact("max_modulus", spectrum.largest())
            .fact("tau", spectrum.tau.iter().map(|tau| json!({ "re": tau.re, "im": tau.im })).collect::<Vec<_>>())
            .fact("quality", spectrum.quality)
            .fact("integrator", "collocation")
            .fact("shooting", shooting)
            .words(self.words())
            .table(outside(&spectrum.multipliers))
    }

    fn words(&self) -> String {
        let Self { orbit, spectrum, extent: Extent { k_x, k_y, c_x, c_y }, e_b, forces, .. } = self;
        let (Setting { params, sites, omega_b, .. }, quality) = (orbit.setting, spectrum.quality);
        let newton: Vec<String> = orbit.newton.iter().map(|one| format!("{:.1e}", one.residual)).collect();
        let circle = spectrum.multipliers.iter().filter(|one| one.kind == Kind::Circle).count();
        let (turning, two) = match orbit.y().is_empty() {
            true => (String::new(), ""),
            false => (format!(" |tau - cos(omega T)| of one {:.1e};", quality.linear), ", 2 that are exp(+-i omega T)"),
        };
        // A centre at zero is a rounding.
        let digits = if c_x.abs() > 1e-9 * k_x { 15 } else { 1 };
        format!(
            "{sites} sites, n = -N .. N; alpha = {}, kappa = {}, rho = {}; omega = {}, omega_b = {omega_b}, period T = {:.15}; \
             K_x = {k_x:.15e}, K_y = {k_y:.15e}, C_x = {c_x:.digits$e}, C_y = {c_y:.digits$e}. Residual max |F| / max |Z| {:.1e}, before each step of Newton's \
             method {}; E_b(T) {e_b:.1e}; mean contact force {:e}, its spread {:.1e}. Largest |lambda| {:.12}; \
             symplectic defect {:.1e}; |tau - 1| of the two that are 1 {:.1e} and {:.1e};{turning} distance to \
             the eigenvalues of M(T) {:.1e}. {circle} multipliers on the circle, 4 that are 1{two}; \
             of those off it the inverses are left out.",
            params.alpha,
            params.kappa,
            params.rho,
            params.omega(),
            orbit.setting.period(),
            orbit.residual,
            newton.join(", "),
            forces.mean(),
            forces.spread(),
            spectrum.largest(),
            quality.symplectic_defect,
            quality.trivial[0],
            quality.trivial[1],
            quality.pairing,
        )
    }

    /// Strains of the orbit at rest, with the sign of odd sites changed, and its multipliers in the
    /// complex plane.
    fn picture(&self, title: String) -> Panels {
        let Setting { params, sites, omega_b, .. } = self.orbit.setting;
        let half = (sites / 2) as i64;
        let strains = |label: &str, values: &[f64]| {
            let points = (-half..=half).map(|n| n as f64).zip(values.iter().copied());
            let label = format!("(−1)ⁿ {label}");
            Panel::new(report::Kind::Sites, ["site n", &label], vec![Line::new(&label, points).staggered()])
        };
        let marks = |name: &str, kind: Kind| {
            let all = self.spectrum.multipliers.iter().filter(|one| one.kind == kind);
            Line::new(name, all.map(|one| (one.re, one.im)))
        };
        let kinds = KINDS.map(|(kind, name)| marks(name, kind)).into();
        let above = format!("{title}, ω_b = {omega_b}");
        let plane = Panel { title: above, ..Panel::new(report::Kind::Plane, ["Re λ", "Im λ"], kinds) };
        let caption = format!(
            "N = {sites}, {}. ω_b = {omega_b}: largest modulus of a multiplier {:.9}.",
            params_words(params),
            self.spectrum.largest(),
        );
        let all = [("strain xₙ", self.orbit.x()), ("strain yₙ", self.orbit.y())];
        let strains =
            all.into_iter().filter(|(_, values)| !values.is_empty()).map(|(label, values)| strains(label, values));
        let columns = vec![Column::new("", strains), Column::new("", [plane])];
        Panels { title, columns, caption }
    }
}

impl DoubledStudy {
    /// The report: the branch, the period doubling at which it begins, and its last orbit.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn report(&self) -> Result<Report> {
        let birth = &self.birth;
        let words = format!(
            "The period doubles at omega_b = {:.10}: orbits of doubled period from {:.10} on.",
            birth.parameter,
            0.5 * birth.parameter
        );
        let report = Report::new("branch").fact("birth", &bifurcations("", std::slice::from_ref(birth)).json()[0]);
        let report = reported(&self.branch, report.words(words))?;
        let orbit = self.last.as_ref().map(|last| last.facts(Report::new("")).json());
        let report = report.fact("orbit", orbit);
        Ok(match &self.last {
            Some(last) => {
                report.words(format!("The last orbit: {}", last.words())).table(outside(&last.spectrum.multipliers))
            }
            None => report,
        })
    }
}

fn bifurcations(name: &str, all: &[Bifurcation]) -> Table {
    Table::of(name, all)
        .key("bifurcations")
        .col("kind", Short, "", |one| one.kind.name())
        .col("parameter", Fixed(10), "", |one| one.parameter)
        .col("period", Fixed(10), "", |one| one.orbit.setting.period())
        .col("tau", Fixed(8), "half trace of the two multipliers that meet", |one| one.critical.tau)
        .col("omega_b", Hidden, "", |one| one.orbit.setting.omega_b)
        .col("mode", Json, "", |one| json!(one.critical.mode))
        .done()
}

fn points(parameter: Parameter, rows: &[BranchRow<'_, Continuation>]) -> Table {
    let off = |kind: Kind| {
        move |row: &BranchRow<'_, Continuation>| {
            let strongest = row.spectrum?.multipliers.iter().find(|one| one.kind == kind && one.modulus > 1.0);
            strongest.map(|one| one.modulus)
        }
    };
    let leading = |spectrum: &Spectrum| -> Vec<Multiplier> {
        let all = spectrum.multipliers.iter().filter(|one| one.modulus > 1.0 && one.im >= 0.0);
        all.take(LEADING).copied().collect()
    };
    let place = |row: &BranchRow<'_, Continuation>| row.orbit.setting.get(parameter);
    // The parameter has the name that the measured centre has elsewhere.
    let centre = if parameter == Parameter::Cx { "c_x_measured" } else { "c_x" };
    Table::of("branch", rows)
        .key("points")
        .col(parameter.name(), Fixed(8), "", place)
        .col("k_x", Power(8), "amplitude of the background, of beads", |row| Some(row.measures?.extent.k_x))
        .col("k_y", Power(8), "and of resonators", |row| Some(row.measures?.extent.k_y))
        .col(centre, Hidden, "centre of the background, of beads", |row| Some(row.measures?.extent.c_x))
        .col("c_y", Hidden, "and of resonators", |row| Some(row.measures?.extent.c_y))
        .col("max_modulus", Hidden, "largest modulus of a multiplier", |row| Some(row.spectrum?.largest()))
        .col("real", Fixed(8), "largest modulus of the real multipliers above 1", off(Kind::Real))
        .col("negative", Fixed(8), "of those below -1", off(Kind::Negative))
        .col("quartet", Fixed(8), "of quartets", off(Kind::Quartet))
        .col("parameter", Json, "", place)
        .col("omega_b", Json, "", |row| row.orbit.setting.omega_b)
        .col("rho", Json, "", |row| row.orbit.setting.params.rho)
        .col("residual", Json, "", |row| row.orbit.residual)
        .col("leading", Json, "", |row| json!(row.spectrum.map(leading)))
        .col("symplectic_defect", Json, "", |row| Some(row.spectrum?.quality.symplectic_defect))
        .done()
}

pub(super) fn outline() -> Report {
    Report::new("branch").table(points(Parameter::OmegaB, &[])).table(bifurcations("bifurcations", &[]))
}

/// The report of a branch.
///
/// # Errors
/// Errors of the archive writer.
pub fn branch_report(branch: &Branch) -> Result<Report> {
    reported(branch, Report::new("branch"))
}

/// Adds the branch to a report. `branch.npz` is what
/// [`Branch::load`] reads back, and all multipliers of every point.
fn reported(branch: &Branch, report: Report) -> Result<Report> {
    let parameter = branch.continuation.parameter;
    let table = points(parameter, &rows(branch));
    let end = ended(branch);
    let picture = picture(branch, &table);
    let report = report
        .fact("parameter", parameter.name())
        .fact("end", branch.ended())
        .fact("gaps", &branch.gaps)
        .fact("settings", json!(branch.settings()))
        .fact("integrator", "collocation")
        .table(table)
        .table(bifurcations("bifurcations", &branch.bifurcations))
        .words(end + &gaps(branch))
        .file("branch.npz", branch_npz(&(), branch)?)
        .failure(branch.shortfall().filter(|_| !branch.ended().is_complete()).map(|why| format!("the branch {why}")));
    Ok(if !shows(branch) { report } else { report.picture(picture) })
}

/// The amplitude along the branch, with stability and bifurcations marked, and the largest
/// modulus.
fn picture(branch: &Branch, table: &Table) -> Panels {
    let parameter = branch.continuation.parameter;
    let rows: Vec<_> = rows(branch).into_iter().filter(|row| row.measures.is_some()).collect();
    let place = |row: &BranchRow<'_, Continuation>| {
        let amplitude = row.measures.map_or(f64::NAN, |measures| measures.extent.k_x);
        (row.orbit.setting.get(parameter), amplitude)
    };
    // A bifurcation is drawn at the height of the nearest point.
    let mark = |one: &Bifurcation| {
        let nearest = least_by(rows.iter().map(place), |(p, _)| (p - one.parameter).abs());
        (one.parameter, nearest.map_or(f64::NAN, |(_, amplitude)| amplitude))
    };
    let lines = lines(branch, &None, place, |spectrum| spectrum.largest() <= UNSTABLE, mark);
    let symbol = parameter.symbol();
    let moduli = [("largest |λ|", "max_modulus")];
    let plots = filled([
        Panel::new(report::Kind::Cloud, [symbol, "amplitude K_x"], lines),
        table.panel(report::Kind::Parameter, [symbol, "largest modulus |λ|"], parameter.name(), &moduli),
    ]);
    let ring = rows.first().map_or(String::new(), |row| {
        let Setting { params, sites, .. } = row.orbit.setting;
        let varied = !matches!(parameter, Parameter::OmegaB | Parameter::Cx);
        format!(" N = {sites}, {}{}.", params_words(params), if varied { " at its first point" } else { "" })
    });
    let known = rows.iter().any(|row| row.spectrum.is_some());
    let unstable = if known { " Unstable: a multiplier with |λ| > 1 + 10⁻⁶." } else { "" };
    let caption = format!("{} orbits.{ring}{unstable}{}", rows.len(), gaps(branch));
    Panels::column(format!("Branch of periodic orbits in {symbol}"), plots, caption)
}
