//! Exact orbits and their branches as text, JSON, CSV, NPZ and pictures.

use super::{Branch, DarkStudy, DoubledStudy, OrbitStudy};
use crate::{
    error::Result,
    orbits::{Bifurcation, End, Extent, Kind, Multiplier, ORBIT_FORMAT, Setting},
    output::{Array, csv},
    present::table,
    study::{File, Report, dps::center_word, named, word},
};
use serde_json::{Value, json};

/// Largest number of multipliers outside the circle in the JSON of each point of a branch.
const LEADING: usize = 8;

impl Report for DarkStudy {
    /// The orbit and its multipliers, with measured errors of both.
    fn json(&self) -> Value {
        let mut fields = json(&self.study);
        fields["center"] = json!(center_word(self.center));
        fields
    }

    fn text(&self) -> String {
        format!("dark breather about a {}\n", center_word(self.center)) + &orbit_table(&self.study)
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        Ok(named([("dark-breather.json", format!("{json}\n").into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        let title = format!("Dark breather about a {}", center_word(self.center));
        Ok(named([("dark-breather.png", orbit_picture(title, &self.study)?)]))
    }
}

impl Report for Branch {
    fn json(&self) -> Value {
        branch_value(self)
    }

    fn text(&self) -> String {
        branch_table(self)
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let json = format!("{json}\n").into();
        Ok(named([("branch.json", json), ("branch.csv", branch_csv(self)), ("branch.npz", branch_npz(self)?)]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("branch.png", branch_picture(self)?)]))
    }

    /// An error message, if the branch did not reach its end.
    fn remark(&self) -> Option<String> {
        self.shortfall().map(|why| format!("error: the branch {why}"))
    }

    /// Whether the branch reached its end. Its files are written in any case.
    fn succeeded(&self) -> bool {
        self.end == End::Reached
    }
}

impl Report for DoubledStudy {
    /// The branch, the period doubling at which it begins, and its last orbit.
    fn json(&self) -> Value {
        let mut value = branch_value(&self.doubled.branch);
        value["birth"] = bifurcation(&self.doubled.birth);
        value["orbit"] = self.last.as_ref().map_or(Value::Null, json);
        value
    }

    fn text(&self) -> String {
        let birth = self.doubled.birth.parameter;
        format!("the period doubles at omega_b = {birth:.10}: orbits of doubled period from {:.10} on\n\n", 0.5 * birth)
            + &branch_table(&self.doubled.branch)
            + &self.last.as_ref().map_or(String::new(), |study| format!("\nthe last orbit\n{}", orbit_table(study)))
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        self.doubled.branch.files(json)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        self.doubled.branch.pictures()
    }

    fn remark(&self) -> Option<String> {
        self.doubled.branch.remark()
    }

    fn succeeded(&self) -> bool {
        self.doubled.branch.succeeded()
    }
}

pub(crate) fn json(study: &OrbitStudy) -> Value {
    let OrbitStudy { orbit, spectrum, extent, e_b, forces, kantorovich, shooting } = study;
    let Setting { params, sites, omega_b, .. } = orbit.setting;
    let half = (sites / 2) as i64;
    let (format, version) = ORBIT_FORMAT;
    json!({
        "format": format,
        "format_version": version,
        "alpha": params.alpha,
        "kappa": params.kappa,
        "rho": params.rho,
        "omega": params.omega(),
        "omega_b": omega_b,
        "sites": sites,
        "turns": orbit.setting.turns,
        "n": (-half..=half).collect::<Vec<_>>(),
        "x": orbit.x(),
        "y": orbit.y(),
        "period": orbit.setting.period(),
        "residual": orbit.residual,
        "k_x": extent.k_x,
        "k_y": extent.k_y,
        "c_x": extent.c_x,
        "c_y": extent.c_y,
        "c_x_asked": orbit.setting.c_x,
        "e_b": e_b,
        "mean_force": forces.mean(),
        "mean_force_spread": forces.spread(),
        "newton": orbit.newton,
        "multipliers": spectrum.multipliers,
        "max_modulus": spectrum.largest(),
        "tau": spectrum.tau.iter().map(|tau| json!({ "re": tau.re, "im": tau.im })).collect::<Vec<_>>(),
        "quality": spectrum.quality,
        "integrator": "collocation",
        "kantorovich": kantorovich,
        "shooting": shooting,
        "version": env!("CARGO_PKG_VERSION"),
    })
}

fn orbit_table(study: &OrbitStudy) -> String {
    let OrbitStudy { orbit, spectrum, extent: Extent { k_x, k_y, c_x, c_y }, e_b, forces, .. } = study;
    let Setting { params, sites, omega_b, .. } = orbit.setting;
    let quality = spectrum.quality;
    let steps: Vec<Vec<String>> = (1..)
        .zip(&orbit.newton)
        .map(|(k, one)| vec![format!("{k}"), format!("{:.1e}", one.residual), format!("{:.1e}", one.step)])
        .collect();
    let numbers = [
        ("sites, n = -N .. N", sites.to_string()),
        ("alpha, kappa, rho", format!("{}, {}, {}", params.alpha, params.kappa, params.rho)),
        ("omega, omega_b", format!("{}, {omega_b}", params.omega())),
        ("period T", format!("{:.15}", orbit.setting.period())),
        ("K_x, K_y", format!("{k_x:.15e}, {k_y:.15e}")),
        ("C_x, C_y", format!("{c_x:.1e}, {c_y:.1e}")),
        ("residual max |F| / max |Z|", format!("{:.1e}", orbit.residual)),
        ("E_b(T)", format!("{e_b:.1e}")),
        ("mean contact force, its spread", format!("{:e}, {:.1e}", forces.mean(), forces.spread())),
        ("largest |lambda|", format!("{:.12}", spectrum.largest())),
        ("symplectic defect", format!("{:.1e}", quality.symplectic_defect)),
        ("|tau - 1| of the two that are 1", format!("{:.1e}, {:.1e}", quality.trivial[0], quality.trivial[1])),
        ("|tau - cos(omega T)| of one", format!("{:.1e}", quality.linear)),
        ("distance to the eigenvalues of M(T)", format!("{:.1e}", quality.pairing)),
    ];
    let rows: Vec<Vec<String>> = numbers.map(|(name, value)| vec![name.to_owned(), value]).to_vec();
    let circle = spectrum.multipliers.iter().filter(|one| one.kind == Kind::Circle).count();
    table(&["quantity", "value"], &rows)
        + "\n"
        + &table(&["step", "residual", "change of Z"], &steps)
        + "\n"
        + &multiplier_table(spectrum.multipliers.iter().filter(|one| one.modulus > 1.0))
        + &format!("\n{}\n", crate::study::exact::nearness(study.kantorovich))
        + &format!(
            "\n{circle} multipliers on the circle, 4 that are 1, 2 that are exp(+-i omega T); of those off it the inverses are left out\n"
        )
}

fn multiplier_table<'a>(multipliers: impl Iterator<Item = &'a Multiplier>) -> String {
    let rows: Vec<Vec<String>> = multipliers
        .map(|one| {
            let number = |value: f64| format!("{value:.12}");
            vec![number(one.re), number(one.im), number(one.modulus), format!("{:.1e}", one.error), word(&one.kind)]
        })
        .collect();
    if rows.is_empty() {
        return "no multiplier is off the unit circle\n".to_owned();
    }
    table(&["Re lambda", "Im lambda", "|lambda|", "error", "kind"], &rows)
}

fn branch_value(branch: &Branch) -> Value {
    let parameter = branch.continuation.parameter;
    let points: Vec<Value> = branch
        .points
        .iter()
        .map(|point| {
            let Extent { k_x, k_y, c_x, c_y } = point.extent;
            let leading: Vec<&Multiplier> = point
                .spectrum
                .multipliers
                .iter()
                .filter(|one| one.modulus > 1.0 && one.im >= 0.0)
                .take(LEADING)
                .collect();
            json!({
                "parameter": point.orbit.setting.get(parameter),
                "omega_b": point.orbit.setting.omega_b,
                "rho": point.orbit.setting.params.rho,
                "k_x": k_x,
                "k_y": k_y,
                "c_x": c_x,
                "c_y": c_y,
                "residual": point.orbit.residual,
                "max_modulus": point.spectrum.largest(),
                "leading": leading,
                "symplectic_defect": point.spectrum.quality.symplectic_defect,
                "kantorovich": point.kantorovich,
            })
        })
        .collect();
    json!({
        "parameter": parameter.name(),
        "end": branch.end,
        "gaps": branch.gaps,
        "points": points,
        "bifurcations": branch.bifurcations.iter().map(bifurcation).collect::<Vec<_>>(),
        "settings": branch.trail.settings().ok(),
        "integrator": "collocation",
        "version": env!("CARGO_PKG_VERSION"),
    })
}

fn bifurcation(one: &Bifurcation) -> Value {
    let Setting { omega_b, .. } = one.orbit.setting;
    json!({
        "kind": one.kind,
        "parameter": one.parameter,
        "period": one.orbit.setting.period(),
        "omega_b": omega_b,
        "tau": one.tau,
        "mode": one.mode,
    })
}

/// A branch as a table.
fn branch_table(branch: &Branch) -> String {
    let parameter = branch.continuation.parameter;
    let rows: Vec<Vec<String>> = branch
        .points
        .iter()
        .map(|point| {
            let off = |kind: Kind| {
                let strongest = point.spectrum.multipliers.iter().find(|one| one.kind == kind && one.modulus > 1.0);
                strongest.map_or(String::new(), |one| format!("{:.8}", one.modulus))
            };
            vec![
                format!("{:.8}", point.orbit.setting.get(parameter)),
                format!("{:.8e}", point.extent.k_x),
                format!("{:.8e}", point.extent.k_y),
                off(Kind::Real),
                off(Kind::Negative),
                off(Kind::Quartet),
            ]
        })
        .collect();
    let head = [parameter.name(), "K_x", "K_y", "|lambda| real", "negative", "quartet"];
    let events: Vec<Vec<String>> = branch
        .bifurcations
        .iter()
        .map(|one| {
            let period = one.orbit.setting.period();
            vec![word(&one.kind), format!("{:.10}", one.parameter), format!("{period:.10}"), format!("{:.8}", one.tau)]
        })
        .collect();
    let bifurcations = if events.is_empty() {
        "no bifurcation\n".to_owned()
    } else {
        table(&["bifurcation", parameter.name(), "period", "tau"], &events)
    };
    table(&head, &rows)
        + "\n"
        + &bifurcations
        + &format!("\n{} points; the branch ended: {}\n", rows.len(), branch.end.words())
        + &gaps(branch)
        + &bounds(branch)
}

/// A line of text with the parameters of orbits without multipliers; empty if there are none.
fn gaps(branch: &Branch) -> String {
    let places: Vec<String> = branch.gaps.iter().map(|p| format!("{p:.8}")).collect();
    let name = branch.continuation.parameter.name();
    if places.is_empty() {
        String::new()
    } else {
        format!("orbits without multipliers at {name} = {}\n", places.join(", "))
    }
}

/// A line of text with the bounds for distances to exact orbits; empty if none were computed.
fn bounds(branch: &Branch) -> String {
    let found = branch.points.iter().map(|point| point.kantorovich);
    if branch.bounded { crate::study::exact::bounds(found) + "\n" } else { String::new() }
}

/// `branch.csv`: for every point its parameter, amplitudes and centres, the largest modulus, and
/// the bound for the distance to an exact orbit.
pub(crate) fn branch_csv(branch: &Branch) -> Vec<u8> {
    let parameter = branch.continuation.parameter;
    let rows = branch.points.iter().map(|point| {
        let Extent { k_x, k_y, c_x, c_y } = point.extent;
        let radius = point.kantorovich.and_then(|found| found.radius).unwrap_or(f64::NAN);
        vec![point.orbit.setting.get(parameter), k_x, k_y, c_x, c_y, point.spectrum.largest(), radius]
    });
    csv(&[parameter.name(), "k_x", "k_y", "c_x", "c_y", "max_modulus", "radius"], rows)
}

/// `branch.npz`: what [`Trail::load`](crate::orbits::Trail::load) reads back, and all multipliers
/// of every point.
fn branch_npz(branch: &Branch) -> Result<Vec<u8>> {
    let parts = |part: &dyn Fn(&Multiplier) -> f64| -> Vec<Vec<f64>> {
        branch.points.iter().map(|point| point.spectrum.multipliers.iter().map(part).collect()).collect()
    };
    let (re, im, error) = (parts(&|one| one.re), parts(&|one| one.im), parts(&|one| one.error));
    branch.trail.npz(vec![
        Array::matrix("multipliers_re", re.iter().map(Vec::as_slice)),
        Array::matrix("multipliers_im", im.iter().map(Vec::as_slice)),
        Array::matrix("modulus_error", error.iter().map(Vec::as_slice)),
    ])
}

/// Strains of the orbit at rest, and its multipliers in the complex plane.
#[cfg(feature = "plot")]
fn orbit_picture(title: String, study: &OrbitStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{self, Column, Line, Panel, Panels, panels};
    let Setting { params, sites, omega_b, .. } = study.orbit.setting;
    let half = (sites / 2) as i64;
    let strains = |label: &str, values: &[f64]| {
        let points = (-half..=half).map(|n| n as f64).zip(values.iter().copied());
        Panel::new(figures::Kind::Sites, ["site n", label], vec![Line::new(label, points)])
    };
    let marks = |name: &str, kinds: &[Kind]| {
        let all = study.spectrum.multipliers.iter().filter(|one| kinds.contains(&one.kind));
        Line::new(name, all.map(|one| (one.re, one.im)))
    };
    let kinds = vec![
        marks("on the circle", &[Kind::Circle]),
        marks("real", &[Kind::Real, Kind::Negative]),
        marks("quartet", &[Kind::Quartet]),
    ];
    let plane = Panel::new(figures::Kind::Plane, ["Re λ", "Im λ"], kinds);
    let caption = format!(
        "Strains at rest, and Floquet multipliers; the largest modulus is {:.9}. N = {sites}, {}, ω_b = {omega_b}, residual {:.1e}. hertzchain {}.",
        study.spectrum.largest(),
        crate::study::params_words(params),
        study.orbit.residual,
        env!("CARGO_PKG_VERSION")
    );
    let strains = [strains("strain xₙ", study.orbit.x()), strains("strain yₙ", study.orbit.y())];
    let columns = vec![Column::new("", strains), Column::new("", [plane])];
    Ok(panels(&Panels { title, columns, caption })?)
}

/// Moduli above which an orbit is drawn as unstable: roundings of multipliers on the circle stay
/// below.
#[cfg(feature = "plot")]
const UNSTABLE: f64 = 1.0 + 1e-6;

/// The amplitude along the branch, with stability and bifurcations marked, and the largest modulus.
#[cfg(feature = "plot")]
fn branch_picture(branch: &Branch) -> Result<crate::figures::Picture> {
    use crate::figures::{self, Line, Panel, Panels, panels};
    let parameter = branch.continuation.parameter;
    use super::BranchPoint;
    let place = |point: &BranchPoint| point.orbit.setting.get(parameter);
    let marks = |name: &str, unstable: bool| {
        let chosen = branch.points.iter().filter(|point| (point.spectrum.largest() > UNSTABLE) == unstable);
        Line::new(name, chosen.map(|point| (place(point), point.extent.k_x)))
    };
    let at = |one: &Bifurcation| {
        let near = |a: &&BranchPoint, b: &&BranchPoint| {
            (place(a) - one.parameter).abs().total_cmp(&(place(b) - one.parameter).abs())
        };
        branch.points.iter().min_by(near).map(|point| (one.parameter, point.extent.k_x))
    };
    let bifurcations = Line::new("bifurcation", branch.bifurcations.iter().filter_map(at));
    let panel = |kind, label: &str, lines| Panel::new(kind, [parameter.symbol(), label], lines);
    let moduli = branch.points.iter().map(|point| (place(point), point.spectrum.largest()));
    let moduli = vec![Line::new("largest |λ|", moduli)];
    let amplitudes = vec![marks("stable", false), marks("unstable", true), bifurcations];
    let plots = vec![
        panel(figures::Kind::Cloud, "amplitude K_x", amplitudes),
        panel(figures::Kind::Parameter, "largest modulus |λ|", moduli),
    ];
    let setting = branch.points.first().map(|point| point.orbit.setting);
    let ring = setting.map_or(String::new(), |Setting { params, sites, .. }| {
        format!("N = {sites}, {} at its first point. ", crate::study::params_words(params))
    });
    let caption = format!(
        "{} orbits; unstable: a multiplier with |λ| > 1 + 10⁻⁶. {ring}hertzchain {}.",
        branch.points.len(),
        env!("CARGO_PKG_VERSION")
    );
    Ok(panels(&Panels::column(format!("Branch of periodic orbits in {}", parameter.symbol()), plots, caption))?)
}
