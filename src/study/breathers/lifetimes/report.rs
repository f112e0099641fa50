//! The report of the map of lifetimes.

use super::{Fate, Life, LifetimePoint, LifetimeStudy, PowerLaw};
use crate::{
    output::to_json,
    report::{CellMap, Column, Fixed, Hidden, Line, Panels, Power, Report, Short, Table, fields},
    study::{RhoLaw, center_word},
    sweep::STOPPED,
};
use serde_json::{Value, json};

/// Values of `x = rho epsilon^(2(alpha-1))` with a line on the maps.
const CONTOURS: [f64; 4] = [0.1, 1.0, 10.0, 100.0];

/// The table of the points.
pub(super) fn points(points: &[LifetimePoint]) -> Table {
    let of = |value: fn(&Life) -> Option<f64>| move |point: &LifetimePoint| point.life.as_ref().ok().and_then(value);
    Table::of("lifetimes", points)
        .key("points")
        .col("epsilon", Short, "", |point| point.epsilon)
        .col("rho", Short, "", |point| point.rho)
        .col("lifetime", Fixed(1), "until the core has less than 0.9 of the energy", lifetime)
        .col("not_before", Fixed(1), "end of the run, where it lives longer", not_before)
        .col("fate", Short, "", fate)
        .col("end", Hidden, "time until which it was followed", of(|life| Some(life.end)))
        .col("decoupled", Hidden, "time at which contact fell below 1/3", of(|life| life.decoupled))
        .col("core_share", Fixed(3), "share of the energy in the core, at the end", of(|life| Some(life.core_share)))
        .col("contact", Fixed(2), "share of the last ten periods in which a bond of the core is closed", {
            of(|life| Some(life.contact))
        })
        .col("x", Hidden, "rho epsilon^(2(alpha-1))", |point| point.x)
        .col("horizon", Power(3), "T epsilon^(1-alpha)", |point| point.horizon)
        .col("omega_b", Hidden, "frequency of the ansatz", |point| point.omega_b)
        .col("sites", Hidden, "sites of the chain", |point| point.life.as_ref().ok().map(|life| life.sites))
        .col("ends_felt", Fixed(1), "time from which the ends of the chain may be felt", of(|life| life.ends_felt))
        .col("failure", Short, "", |point| point.life.as_ref().err().cloned())
        .done()
}

fn lifetime(point: &LifetimePoint) -> Option<f64> {
    point.life.as_ref().ok()?.lifetime
}

fn not_before(point: &LifetimePoint) -> Option<f64> {
    point.life.as_ref().ok().filter(|life| life.lifetime.is_none()).map(|life| life.end)
}

/// Its fate; `stopped` or `failed` for a point without a life.
fn fate(point: &LifetimePoint) -> &'static str {
    match &point.life {
        Ok(life) => life.fate.name(),
        Err(why) if why == STOPPED => "stopped",
        Err(_) => "failed",
    }
}

fn fit_words(fit: Option<PowerLaw>) -> String {
    let Some(fit) = fit else {
        return "no power law: it takes four breathers that radiate with rho epsilon^(2(alpha-1)) >= 10, of several sizes and mass ratios".to_owned();
    };
    let PowerLaw { points, factor, rho_power, epsilon_power, largest_ratio, x_power, x_largest_ratio } = fit;
    let verdict =
        if fit.holds() { "a power law" } else { "no power law: the best one is off by more than a factor of 1.25" };
    format!(
        "{verdict}, over {points} points that radiate with x = rho epsilon^(2(alpha-1)) >= 10: lifetime ~ {factor:.3} \
         rho^{rho_power:.3} epsilon^{epsilon_power:.3} within a factor of {largest_ratio:.3}; as a function of x alone, \
         T epsilon^(1-alpha) x^{x_power:.3}, within a factor of {x_largest_ratio:.3}"
    )
}

impl LifetimeStudy {
    /// The report. Its files have the same bytes whether points were resumed or not, and on any
    /// number of cores.
    pub fn report(&self) -> Report {
        let Self { options, fit, computed, resumed, .. } = self;
        let fit_json = |fit: PowerLaw| -> Value {
            let mut value = json!(fit);
            value["holds"] = json!(fit.holds());
            value["region"] = json!("rho epsilon^(2(alpha-1)) >= 10, fate radiates");
            value
        };
        let report = Report::new("lifetimes")
            .words(format!(
                "bright breathers u(0) = 2 epsilon a about a {}, alpha = {}; lifetime: until the core has less than 0.9 of the energy",
                center_word(options.center),
                options.alpha
            ))
            .facts(fields!(options => alpha, center, epsilons, rhos))
            .table(points(&self.points))
            .words(
                "radiates: the core fell below 0.9 of the energy while contact was at least 1/3. decouples: contact fell \
                 below 1/3 before that; gaps open, each site oscillates on its own, and the energy stays.",
            )
            .fact("fit", fit.map(fit_json))
            .words(fit_words(*fit))
            .facts(fields!(options => sites, until))
            .fact("integrator", options.solver.method.name())
            .fact("tolerance", options.solver.tol)
            .picture(self.picture());
        let json = to_json(&report.json()) + "\n";
        let wall = self.wall.as_secs_f64();
        report
            .file("lifetimes.json", json.into_bytes())
            .fact("computed", computed)
            .fact("resumed", resumed)
            .fact("wall_s", wall)
            .words(format!("{computed} points computed, {resumed} resumed, {wall:.1} s"))
    }

    /// Lifetimes over size and mass ratio, and the same over the time scale of the theorem; in each
    /// cell its number, and `>` where the run ended before.
    fn picture(&self) -> Panels {
        let options = &self.options;
        let ascending = |values: &[f64]| {
            let mut values = values.to_vec();
            values.sort_by(f64::total_cmp);
            values
        };
        let (x, y) = (ascending(&options.epsilons), ascending(&options.rhos));
        let point =
            |rho: f64, epsilon: f64| self.points.iter().find(move |point| (point.epsilon, point.rho) == (epsilon, rho));
        let cells: Vec<_> = y.iter().flat_map(|&rho| x.iter().map(move |&epsilon| (rho, epsilon))).collect();
        let cells: Vec<Option<&LifetimePoint>> = cells.into_iter().map(|(rho, epsilon)| point(rho, epsilon)).collect();
        let seen = |point: &LifetimePoint| lifetime(point).or(not_before(point));
        let note = |point: &LifetimePoint, time: f64| {
            let digits = if time < 10.0 { 2 } else { usize::from(time < 100.0) };
            format!("{}{time:.digits$}", if lifetime(point).is_none() { "> " } else { "" })
        };
        let decoupled = |point: &LifetimePoint| point.life.as_ref().is_ok_and(|life| life.fate == Fate::Decouples);
        let longer = |point: &LifetimePoint| !decoupled(point) && not_before(point).is_some();
        let which = |name: &str, wanted: &dyn Fn(&LifetimePoint) -> bool| {
            let those = (0..cells.len()).filter(|&k| cells[k].is_some_and(wanted));
            (name.to_owned(), those.collect())
        };
        let apart = vec![which("longer than the run", &longer), which("gaps open: no breather", &decoupled)];
        let (first, last) = (x[0] / 10.0, x[x.len() - 1] * 10.0);
        let contour = |value: f64| {
            let sizes = (0..=400).map(|k| first * (last / first).powf(f64::from(k) / 400.0));
            let heavy = |epsilon: f64| (epsilon, value * RhoLaw::Heavy.rho(options.alpha, epsilon));
            Line::new(&format!("x = {value}"), sizes.map(heavy))
        };
        let map = |label: &str, scale: fn(&LifetimePoint) -> f64| {
            let scaled = |point: &LifetimePoint| seen(point).map(|time| time / scale(point));
            CellMap {
                labels: ["size ε", "mass ratio ρ", label].map(str::to_owned),
                values: cells.iter().map(|point| point.and_then(scaled).unwrap_or(f64::NAN)).collect(),
                notes: cells
                    .iter()
                    .map(|point| {
                        point.and_then(|point| Some(note(point, scaled(point)?))).unwrap_or("failed".to_owned())
                    })
                    .collect(),
                lines: CONTOURS.map(contour).into(),
                apart: apart.clone(),
                x: x.clone(),
                y: y.clone(),
            }
        };
        let maps = [map("lifetime", |_| 1.0), map("lifetime / (T ε^(1−α))", |point| point.horizon)];
        let caption = format!(
            "Bright breathers u(0) = 2εa about a {}, at rest, α = {}, κ = 1; lifetime: until the core has less than 0.9 of the energy. Followed to \
             t = {}; >: it is more. No breather: gaps have opened between the central sites, and what lives on is beads that \
             oscillate alone. Lines: x = ρ ε^(2(α−1)), which the theorem wants bounded from below. By {}, tol {:e}.",
            center_word(options.center),
            options.alpha,
            options.until.map_or("25 T ε^(1−α)".to_owned(), |until| until.to_string()),
            options.solver.method.name(),
            options.solver.tol,
        );
        let columns = maps.map(|map| Column::new("", [map])).into();
        Panels { title: "Lifetimes of bright breathers".to_owned(), columns, caption }
    }
}
