//! Studies of the figures of Sec. 7: dark breathers as exact orbits on rings of 41 bonds, with
//! `alpha = 3/2, kappa = 1`.

use crate::{
    breathers::DarkBreather,
    chain::{Params, max_norm},
    dps::Center,
    error::{Error, Result},
    orbits::{
        Bifurcation, BifurcationKind, Branch, Continuation, Kind, Multiplier, Orbit, OrbitPoint, Parameter, Setting,
        Shooting, Spectrum,
    },
    report::{self, Hidden, Line, Panel, Panels, Report, Short, Table},
    study::{
        DarkStudy, KINDS, Kick, Progress, branch_report, center_word, doubled_from, evolve, format_short, go_on,
        orbit_study,
    },
    sweep::{Engine, map},
};

const THIRD: f64 = 1.0 / 3.0;
const SITES: usize = 41;
/// Collisions that lead to no modulus above one plus this are left out.
const WEAK: f64 = 0.01;
/// Branches in the mass ratio begin where `omega_b / omega` has this value.
const ABOVE: f64 = 1.004;
/// Branches in the mass ratio have short steps up to this multiple of the first mass ratio.
const NEAR: f64 = 5.0;
/// Size of the push along the mode at -1, in units of the amplitude, for a seed of doubled period.
const SEED: f64 = 0.1;

pub(in crate::paper) fn breather(rho: f64, center: Center, omega_b: f64) -> DarkBreather {
    DarkBreather { params: Params { alpha: 1.5, kappa: 1.0, rho }, center, sites: SITES, omega_b, c_x: 0.0 }
}

pub(in crate::paper) fn orbit(rho: f64, center: Center, omega_b: f64) -> Result<Orbit> {
    breather(rho, center, omega_b).orbit(&Shooting::default())
}

/// The branch from an orbit on to its end, in steps of at most `step`; bifurcations are located if
/// `weak` is given.
fn follow(
    start: Orbit,
    parameter: Parameter,
    to: f64,
    step: f64,
    weak: Option<f64>,
    tell: Progress<'_>,
) -> Result<Branch> {
    let shooting = Shooting::default();
    let continuation = Continuation { parameter, to, step, most_points: 2000, shooting };
    go_on(Branch { weak, ..Branch::new(continuation, start.setting, start)? }, &Engine::threads(), tell)?.reached()
}

/// The branch of a family between two frequencies, with about so many points.
pub(in crate::paper) fn between(
    rho: f64,
    center: Center,
    [from, to]: [f64; 2],
    points: u32,
    weak: Option<f64>,
    tell: Progress<'_>,
) -> Result<Branch> {
    follow(orbit(rho, center, from)?, Parameter::OmegaB, to, (to - from) / f64::from(points), weak, tell)
}

/// Strains by site of several `Z` of an orbit: mark of the columns, and values.
fn strains(orbit: &Orbit, all: &[(&str, &[f64])]) -> Table {
    let sites = orbit.setting.sites;
    let rows: Vec<usize> = (0..sites).collect();
    let mut table = Table::of("profile", &rows).key("").col("n", Hidden, "site", |i| *i as f64 - (sites / 2) as f64);
    for (mark, z) in all {
        table = table.col(format!("x{mark}"), Hidden, "strain of the bead", |i| z[*i]);
        table = table.col(format!("y{mark}"), Hidden, "and of its resonator", |i| z[sites + i]);
    }
    table.done()
}

/// Panels of `(-1)^n x_n` and `(-1)^n y_n` of a table of strains: name in the legend, and mark of
/// the columns.
fn profiles(table: &Table, lines: &[(&str, &str)]) -> Vec<Panel> {
    let panel = |symbol: &str, label| {
        let lines = lines.iter().map(|(name, mark)| table.line(name, ["n", &format!("{symbol}{mark}")]).staggered());
        Panel::new(report::Kind::Sites, ["site n", label], lines.collect())
    };
    vec![panel("x", "(−1)ⁿ strain xₙ"), panel("y", "(−1)ⁿ strain yₙ")]
}

/// Adds a table and panels to a report.
fn with(report: Report, table: Table, panels: Vec<Panel>, caption: String) -> Report {
    report.table(table).picture(Panels::column("", panels, caption))
}

/// Multipliers, each at its value of a parameter.
fn multipliers(name: &str, parameter: &str, all: &[(f64, Multiplier)]) -> Table {
    Table::of(name, all)
        .key("")
        .col(parameter, Hidden, "", |row| row.0)
        .col("re", Hidden, "real part", |row| row.1.re)
        .col("im", Hidden, "imaginary part", |row| row.1.im)
        .col("modulus", Hidden, "", |row| row.1.modulus)
        .col("error", Hidden, "of the modulus", |row| row.1.error)
        .col("krein", Hidden, "Krein signature on the circle, 0 elsewhere", |row| f64::from(row.1.krein))
        .col("kind", Short, "", |row| row.1.kind.name())
        .done()
}

/// The moduli of all multipliers along a branch.
fn moduli(branch: &Branch, title: &str) -> Panel {
    let parameter = branch.continuation.parameter;
    let line = |(kind, name): (Kind, &str)| {
        let at = |point: &OrbitPoint| {
            let is = |one: &&Multiplier| if kind == Kind::Circle { one.modulus == 1.0 } else { one.kind == kind };
            let p = point.orbit.setting.get(parameter);
            point.spectrum.multipliers.iter().filter(is).map(|one| (p, one.modulus)).collect::<Vec<_>>()
        };
        let mut points: Vec<(f64, f64)> = branch.points.iter().flat_map(at).collect();
        points.dedup();
        Line::new(name, points)
    };
    let (kind, label) = match parameter {
        Parameter::Rho => (report::Kind::LogCloud, "mass ratio ρ"),
        _ => (report::Kind::Cloud, "frequency ω_b"),
    };
    Panel { title: title.to_owned(), ..Panel::new(kind, [label, "|λ|"], KINDS.map(line).into()) }
}

/// The largest moduli of each kind, such as “positive real 1.08, quartet 1.01”.
fn strongest(spectrum: &Spectrum) -> String {
    let word = |(kind, name): (Kind, &str)| {
        let off = spectrum.multipliers.iter().filter(|one| one.kind == kind && one.modulus > 1.0);
        Some(format!("{name} {:.4}", off.map(|one| one.modulus).reduce(f64::max)?))
    };
    KINDS.into_iter().filter_map(word).collect::<Vec<_>>().join(", ")
}

/// The report of a branch, with its multipliers off the circle; its third plot has the moduli of
/// all.
fn of_branch(branch: &Branch, title: &str) -> Result<Report> {
    let parameter = branch.continuation.parameter;
    let off = branch.points.iter().flat_map(|point| {
        let p = point.orbit.setting.get(parameter);
        point.spectrum.multipliers.iter().filter(|one| one.modulus != 1.0).map(move |one| (p, *one))
    });
    let table = multipliers("multipliers", parameter.name(), &off.collect::<Vec<_>>());
    let (Some(first), Some(last)) = (branch.points.first(), branch.points.last()) else { return branch_report(branch) };
    let events = |one: &Bifurcation| {
        format!("{:.7} ({})", one.parameter, one.kind.name().replace('-', " ").replace("krein", "Krein"))
    };
    let events: Vec<String> = branch.bifurcations.iter().map(events).collect();
    let events = match branch.weak {
        Some(weak) if !events.is_empty() => {
            format!(" Bifurcations, quartets with |λ| above {} only: {}.", 1.0 + weak, events.join(", "))
        }
        _ => String::new(),
    };
    let caption = format!(
        "From {} = {} to {}, amplitude K_x of the background from {} to {}; largest |λ| at its end: {}.{events}",
        parameter.symbol(),
        format_short(first.orbit.setting.get(parameter)),
        format_short(last.orbit.setting.get(parameter)),
        format_short(first.measures.extent.k_x),
        format_short(last.measures.extent.k_x),
        strongest(&last.spectrum),
    );
    Ok(with(branch_report(branch)?, table, vec![moduli(branch, title)], caption))
}

/// An orbit with all its multipliers; its third plot is their plane.
fn of_orbit(center: Center, orbit: Orbit) -> Result<Report> {
    let (omega_b, study) = (orbit.setting.omega_b, orbit_study(orbit, &Shooting::default())?);
    let all: Vec<(f64, Multiplier)> = study.spectrum.multipliers.iter().map(|one| (omega_b, *one)).collect();
    let table = multipliers("spectrum", "omega_b", &all);
    Ok(DarkStudy { center, study }.report().table(table))
}

/// The exact breather, that of the DpS equations, and the state after a period.
pub(super) fn profile(center: Center, omega_b: f64) -> Result<Report> {
    let breather = breather(THIRD, center, omega_b);
    let (orbit, seed) = (breather.orbit(&Shooting::default())?, breather.seed()?);
    let after = strains_at(&orbit, 1.0)?;
    let table = strains(&orbit, &[("", &orbit.z), ("_after", &after), ("_dps", &seed)]);
    let panels = profiles(&table, &[("at t = 0", ""), ("at t = T", "_after"), ("DpS", "_dps")]);
    let extent = orbit.extent(Shooting::default().tol)?;
    let caption = format!(
        "Background K_x = {:.6}, K_y = {:.6}; Newton's method from the DpS profile takes {} steps; return error E_b(T) = {:.1e}.",
        extent.k_x,
        extent.k_y,
        orbit.newton.len(),
        apart(&after, &orbit)
    );
    Ok(with(of_orbit(center, orbit)?, table, panels, caption))
}

/// A family of breathers between two differences of the frequency from `omega`; its fourth plot is
/// the part up to the difference `zoom`.
///
/// # Errors
/// An orbit that is not found; a branch that does not reach its end.
pub fn family(
    rho: f64,
    center: Center,
    above: [f64; 2],
    (points, bifurcations, zoom): (u32, bool, Option<f64>),
    tell: Progress<'_>,
) -> Result<Report> {
    let omega = Params::new(1.5, 1.0, rho)?.omega();
    let weak = bifurcations.then_some(WEAK);
    let branch = between(rho, center, above.map(|above| omega + above), points, weak, tell)?;
    let title = |what: &str| format!("{}-centred: {what}", center_word(center));
    let report = of_branch(&branch, &title("moduli along the branch"))?;
    Ok(zoom.into_iter().fold(report, |report, zoom| {
        let mut near = moduli(&branch, &title("near ω, enlarged"));
        near.lines.iter_mut().for_each(|line| line.points.retain(|point| point.0 <= omega + zoom));
        // A panel with the same label would get the range of the panel above.
        near.x_label += " near ω";
        report.picture(Panels::column("", vec![near], ""))
    }))
}

/// A breather with its multipliers; its third plot is their plane.
pub(super) fn one(rho: f64, center: Center, omega_b: f64) -> Result<Report> {
    of_orbit(center, orbit(rho, center, omega_b)?)
}

/// `E_b` of site-centred breathers at a given time against the frequency, at `rho = 1/3`, which is
/// the fourth plot; before it those of their branch.
///
/// # Errors
/// As of [`family`].
pub fn return_errors(omega_b: [f64; 2], points: u32, until: f64, tell: Progress<'_>) -> Result<Report> {
    let branch = between(THIRD, Center::Site, omega_b, points, Some(WEAK), tell)?;
    let row = |point: &OrbitPoint| {
        let periods = (until / point.orbit.setting.period()).floor();
        let e_b = point.orbit.e_b(Shooting::default().tol, periods as u32)?;
        Ok([point.orbit.setting.omega_b, e_b, point.spectrum.largest().powf(periods)])
    };
    let rows: Vec<[f64; 3]> = map(&branch.points, row).into_iter().collect::<Result<_>>()?;
    let table = Table::of("errors", &rows)
        .key("")
        .col("omega_b", Hidden, "frequency", |row| row[0])
        .col("e_b", Hidden, "return error at the last whole period", |row| row[1])
        .col("growth", Hidden, "|lambda|^m, growth of a rounding error over these m periods", |row| row[2])
        .done();
    let growth = Line::law("1e-16 |λ|^m", rows.iter().map(|row| (row[0], 1e-16 * row[2])));
    let lines = vec![table.line("E_b", ["omega_b", "e_b"]), growth];
    let panel = Panel::new(report::Kind::LogParameter, ["frequency ω_b", &format!("return error E_b({until})")], lines);
    let below = rows.iter().filter(|row| row[0] <= 2.077).map(|row| row[1]).fold(0.0, f64::max);
    let caption = format!(
        "E_b at the last whole period before t = {until}; dashed: 10⁻¹⁶ |λ|^m, the growth of a rounding over the m periods. \
         Largest E_b up to ω_b = 2.077: {below:.1e} (the paper: 7·10⁻⁷, grown from the errors of its own orbits). A \
         logarithmic ordinate takes the place of the paper's inset."
    );
    Ok(with(of_branch(&branch, "moduli along the branch")?, table, vec![panel], caption))
}

/// A run of a breather on the chain, kicked along the mode of its largest multiplier if a size is
/// given. After the plots of the run strains at the start and at the end.
pub(super) fn evolution(
    (rho, center, omega_b): (f64, Center, f64),
    until: f64,
    kick: Option<f64>,
    tell: Progress<'_>,
) -> Result<Report> {
    let orbit = orbit(rho, center, omega_b)?;
    let run = evolve(&orbit, until, kick.map(|size| Kick { size, mode: 0 }), &Shooting::default(), tell)?;
    let table = strains(&orbit, &[("", &orbit.z), ("_end", &run.end)]);
    let end = format!("at t = {:.0}", run.times.last().copied().unwrap_or_default());
    let panels = profiles(&table, &[("at t = 0", ""), (&*end, "_end")]);
    Ok(with(run.report(), table, panels, "Integrator collocation, tol 1e-13.".to_owned()))
}

/// The mode at the period doubling at `rho = 1/3`, and the orbit of doubled period to which a push
/// along it leads. Its plot is the mode.
///
/// # Errors
/// As of [`family`].
pub fn doubling(omega_b: f64) -> Result<Report> {
    let (birth, seed, orbit) = doubled_orbit(&about_doubling()?, omega_b)?;
    let table = strains(&orbit, &[("", &orbit.z), ("_seed", &seed), ("_mode", &birth.critical.mode)]);
    let lines = [("beads", "x_mode"), ("resonators", "y_mode")];
    let mode = table.panel(report::Kind::Sites, ["site n", "mode at −1, strain"], "n", &lines);
    let caption = format!(
        "The mode at the period doubling, ω_b = {:.10}, has the largest strain 1. The seed of the orbit of frequency \
         {omega_b} is the breather there with a tenth of its amplitude along the mode; Newton's method takes {} steps to a \
         residual of {:.1e}.",
        birth.parameter,
        orbit.newton.len(),
        orbit.residual
    );
    Ok(with(Report::new("doubling"), table, vec![mode], caption))
}

/// An orbit of doubled period at `rho = 1/3`. After those of the orbit, plots of its strains at
/// half of its period and after it.
pub(super) fn doubled(omega_b: f64) -> Result<Report> {
    let (_, _, orbit) = doubled_orbit(&about_doubling()?, omega_b)?;
    let [half, whole] = [strains_at(&orbit, 0.5)?, strains_at(&orbit, 1.0)?];
    let table = strains(&orbit, &[("", &orbit.z), ("_half", &half), ("_whole", &whole)]);
    let panels = profiles(&table, &[("at t = 0", ""), ("at t = T/2", "_half"), ("at t = T", "_whole")]);
    let sites = orbit.setting.sites;
    let reflected: Vec<f64> =
        (0..2 * sites).map(|k| half[k / sites * sites + (2 * sites - k % sites) % sites]).collect();
    let caption = format!(
        "T = 2π/ω_b = {:.6}, Z: all strains, S: n → 1 − n: max|Z(T/2) − Z(0)| = {:.1e}, max|S Z(T/2) − Z(0)| = {:.1e} and max|Z(T) − \
         Z(0)| = {:.1e} of its amplitude.",
        orbit.setting.period(),
        apart(&half, &orbit),
        apart(&reflected, &orbit),
        apart(&whole, &orbit),
    );
    Ok(with(of_orbit(Center::Bond, orbit)?, table, panels, caption))
}

/// The branch of doubled period at `rho = 1/3`; its third plot has the moduli.
///
/// # Errors
/// As of [`family`].
pub fn doubled_branch(to: f64, tell: Progress<'_>) -> Result<Report> {
    let (_, doubled) = doubled_from(&about_doubling()?, to, 1e-3, &Engine::threads(), tell)?;
    of_branch(&doubled.reached()?, "moduli along the branch")
}

/// The branch at a frequency from a mass ratio near `omega(rho) = omega_b` up to the mass ratio
/// `to`, with about so many points up to 5 times the first mass ratio, and beyond it; its third
/// plot has the moduli.
///
/// # Errors
/// As of [`family`].
pub fn mass_ratios(center: Center, omega_b: f64, to: f64, points: [u32; 2], tell: Progress<'_>) -> Result<Report> {
    let from = ((omega_b / ABOVE).powi(2) - 1.0).recip();
    let near = (NEAR * from).min(0.5 * (from + to));
    let leg = |start: Orbit, from: f64, to: f64, points: u32| {
        follow(start, Parameter::Rho, to, (to - from) / f64::from(points), None, tell)
    };
    let mut first = leg(orbit(from, center, omega_b)?, from, near, points[0])?;
    // The last point of the first part is the first point of the second part.
    let (Some(_), Some(last)) = (first.points.pop(), first.orbits.pop()) else { return branch_report(&first) };
    let mut branch = leg(last, near, to, points[1])?;
    branch.points.splice(..0, first.points);
    branch.gaps.splice(..0, first.gaps);
    branch.orbits.splice(..0, first.orbits);
    of_branch(&branch, &format!("{}-centred", center_word(center)))
}

/// `Z` after `periods` periods.
fn strains_at(orbit: &Orbit, periods: f64) -> Result<Vec<f64>> {
    let mut states = orbit.states(Shooting::default().tol, &[periods * orbit.setting.period()])?;
    Ok(states.remove(0)[..orbit.z.len()].to_vec())
}

/// The largest difference of strains from those of an orbit, over its amplitude.
fn apart(z: &[f64], orbit: &Orbit) -> f64 {
    max_norm(z.iter().zip(&orbit.z).map(|(a, b)| a - b)) / orbit.amplitude()
}

/// The bond-centred family at `rho = 1/3` near its first period doubling.
fn about_doubling() -> Result<Branch> {
    between(THIRD, Center::Bond, [2.062, 2.064], 1, Some(WEAK), &|_, _| {})
}

/// The period doubling of a branch, a push along its mode, and the orbit of doubled period at
/// `omega_b` that is found from it.
fn doubled_orbit(main: &Branch, omega_b: f64) -> Result<(Bifurcation, Vec<f64>, Orbit)> {
    let birth = main.bifurcations.iter().find(|one| one.kind == BifurcationKind::PeriodDoubling).cloned();
    let birth = birth.ok_or_else(|| Error::parameter("omega_b", 2.064, "a period doubling below"))?;
    let by = SEED * birth.orbit.amplitude();
    let seed: Vec<f64> = birth.orbit.z.iter().zip(&birth.critical.mode).map(|(z, mode)| z + by * mode).collect();
    let orbit = Shooting::default().solve(&Setting { omega_b, turns: 2, ..birth.orbit.setting }, &seed)?;
    Ok((birth, seed, orbit))
}
