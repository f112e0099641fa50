//! The report of the map of lifetimes.

use super::{Criterion, Life, LifetimePoint, LifetimeStudy, PowerLaw};
use crate::{
    output::to_json,
    report::{
        CellMap,
        Digits::{Fixed, Hidden, Power, Short},
        Maps, Report, Table,
    },
    study::{dps::center_word, word},
    sweep::STOPPED,
};
use serde_json::{Value, json};

/// The table of the points, with their lifetimes by a criterion and by all three.
pub(super) fn points(points: &[LifetimePoint], criterion: Criterion) -> Table {
    let of = |value: fn(&Life) -> Option<f64>| move |point: &LifetimePoint| point.life.as_ref().ok().and_then(value);
    Table::of("lifetimes", points)
        .key("points")
        .col("epsilon", Short, "", |point| point.epsilon)
        .col("rho", Short, "", |point| point.rho)
        .col("lifetime", Fixed(1), "by the criterion", move |point| lifetime(point, criterion))
        .col("not_before", Fixed(1), "end of the run, where it lives longer", move |point| not_before(point, criterion))
        .col("fate", Short, "", fate)
        .col("energy", Hidden, "lifetime by energy", of(|life| life.energy))
        .col("distance", Hidden, "lifetime by distance", of(|life| life.distance))
        .col("frequency", Hidden, "lifetime by frequency", of(|life| life.frequency))
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

fn lifetime(point: &LifetimePoint, criterion: Criterion) -> Option<f64> {
    point.life.as_ref().ok()?.lifetime(criterion)
}

fn not_before(point: &LifetimePoint, criterion: Criterion) -> Option<f64> {
    point.life.as_ref().ok().filter(|life| life.lifetime(criterion).is_none()).map(|life| life.end)
}

/// Its fate; `stopped` or `failed` for a point without a life.
fn fate(point: &LifetimePoint) -> String {
    match &point.life {
        Ok(life) => word(&life.fate),
        Err(why) => if why == STOPPED { "stopped" } else { "failed" }.to_owned(),
    }
}

/// Name and meaning of a criterion.
fn criterion_words(criterion: Criterion) -> (&'static str, &'static str) {
    match criterion {
        Criterion::Energy => ("energy", "the core has less than 0.9 of the energy"),
        Criterion::Distance => ("distance", "|A - A~|_1/|A~|_1 is above 0.5, A = u + i u', phase included"),
        Criterion::Frequency => {
            ("frequency", "the central oscillation is nearer to omega than to Omega_b, over four periods")
        }
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
    /// The table of the points.
    pub(crate) fn table(&self) -> Table {
        points(&self.points, self.options.criterion)
    }

    /// The report. Its files have the same bytes whether points were resumed or not, and on any
    /// number of cores.
    pub fn report(&self) -> Report {
        let Self { options, fit, computed, resumed, .. } = self;
        let (criterion, meaning) = criterion_words(options.criterion);
        let fit_json = |fit: PowerLaw| -> Value {
            let mut value = json!(fit);
            value["holds"] = json!(fit.holds());
            value["region"] = json!("rho epsilon^(2(alpha-1)) >= 10, fate radiates");
            value
        };
        let report = Report::new("lifetimes")
            .words(format!(
                "bright breathers u(0) = 2 epsilon a about a {}, alpha = {}; lifetime by {criterion}: {meaning}",
                center_word(options.center),
                options.alpha
            ))
            .fact("alpha", options.alpha)
            .fact("center", options.center)
            .fact("criterion", options.criterion)
            .fact("epsilons", &options.epsilons)
            .fact("rhos", &options.rhos)
            .table(self.table())
            .words(
                "radiates: the core fell below 0.9 of the energy while contact was at least 1/3. decouples: contact fell \
                 below 1/3 before that; gaps open, each site oscillates on its own, and the energy stays.",
            )
            .fact("fit", fit.map(fit_json))
            .words(fit_words(*fit))
            .fact("sites", options.sites)
            .fact("until", options.until)
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

    /// Lifetimes over mass ratio and size, each with its number and the first letter of its fate.
    fn picture(&self) -> Maps {
        let options = &self.options;
        let ascending = |values: &[f64]| {
            let mut values = values.to_vec();
            values.sort_by(f64::total_cmp);
            values
        };
        let (x, y) = (ascending(&options.rhos), ascending(&options.epsilons));
        let (mut values, mut notes) = (Vec::new(), Vec::new());
        for epsilon in &y {
            for rho in &x {
                let point = self.points.iter().find(|point| (point.epsilon, point.rho) == (*epsilon, *rho));
                let known = point.and_then(|point| lifetime(point, options.criterion));
                let seen = known.or(point.and_then(|point| not_before(point, options.criterion)));
                values.push(seen.unwrap_or(0.0));
                let letter = point.and_then(|point| fate(point).chars().next()).unwrap_or_default();
                let relation = if known.is_some() { "" } else { "> " };
                notes.push(seen.map_or_else(String::new, |seen| format!("{relation}{seen:.1} {letter}")));
            }
        }
        let labels = ["mass ratio ρ", "size ε", "lifetime, or how long it was followed"].map(str::to_owned);
        let caption = format!(
            "Bright breathers u(0) = 2εa about a {}, α = {}; lifetime by {}. In cells: the lifetime, > where the run ended \
             before; r: radiates, d: decouples, p: persists.",
            center_word(options.center),
            options.alpha,
            criterion_words(options.criterion).0,
        );
        let map = CellMap { labels, x, y, values, notes, ..CellMap::default() };
        Maps { title: "Lifetimes of bright breathers".to_owned(), maps: vec![map], caption }
    }
}
