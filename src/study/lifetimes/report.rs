//! The map of lifetimes as text, JSON, CSV and a picture.

use super::{Criterion, Fate, Life, LifetimePoint, LifetimeStudy, PowerLaw};
use crate::{
    error::Result,
    number::written,
    output::to_json,
    present::{rows_csv, table},
    study::{File, Report, dps::center_word, named},
    sweep::STOPPED,
};
use serde_json::{Value, json};

impl Report for LifetimeStudy {
    /// Each point has its lifetime by the criterion of the study, or null and `not_before`; and by
    /// all three.
    fn json(&self) -> Value {
        let mut value = value(self);
        value["computed"] = json!(self.computed);
        value["resumed"] = json!(self.resumed);
        value["wall_s"] = json!(self.wall.as_secs_f64());
        value
    }

    /// Lifetimes, fates, and the power law.
    fn text(&self) -> String {
        text(self)
    }

    /// The same bytes whether points were resumed or not, and on any number of cores.
    fn files(&self, _: &str) -> Result<Vec<File>> {
        Ok(named([("lifetimes.json", to_json(&value(self)).into()), ("lifetimes.csv", csv(self))]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("lifetimes.png", picture(self)?)]))
    }
}

/// The results, without wall time and the numbers of computed and resumed points.
fn value(study: &LifetimeStudy) -> Value {
    let options = &study.options;
    json!({
        "alpha": options.alpha,
        "center": options.center,
        "criterion": options.criterion,
        "epsilons": options.epsilons,
        "rhos": options.rhos,
        "points": study.points.iter().map(|point| point_json(point, options.criterion)).collect::<Vec<_>>(),
        "fit": study.fit.map(fit_json),
        "sites": options.sites,
        "until": options.until,
        "integrator": options.method.name(),
        "tolerance": options.tolerance,
        "version": env!("CARGO_PKG_VERSION"),
    })
}

fn text(study: &LifetimeStudy) -> String {
    let options = &study.options;
    let (criterion, meaning) = criterion_words(options.criterion);
    let center = center_word(options.center);
    let mut text = format!(
        "bright breathers u(0) = 2 epsilon a about a {center}, alpha = {}; lifetime by {criterion}: {meaning}\n\n",
        options.alpha
    );
    text += &map_of(study, "epsilon \\ rho", |point| lifetime_cell(point, options.criterion));
    text += "\n> t: not before t, where the run ended. ";
    text += "!: past the time from which the ends of the chain may be felt.\n\n";
    text += &map_of(study, "fate", fate_cell);
    text += "\nradiates: the core fell below 0.9 of the energy while contact was at least 1/3. decouples: contact fell below 1/3 before that; gaps open, each site\n\
             oscillates on its own, and the energy stays. contact: share of the last ten periods in which a bond of the core is closed. In brackets:\n\
             contact, and the share of the energy in the core, at the end.\n\n";
    text += &map_of(study, "over T epsilon^(1-alpha)", |point| {
        let lifetime = point.life.as_ref().ok().and_then(|life| life.lifetime(options.criterion));
        lifetime.map_or_else(|| "–".to_owned(), |lifetime| format!("{:.3}", lifetime / point.horizon))
    });
    text += &format!("\n{}\n", fit_lines(study.fit));
    let failures = study.points.iter().filter_map(|point| Some((point, point.life.as_ref().err()?)));
    for (point, why) in failures {
        let [epsilon, rho] = [point.epsilon, point.rho].map(written);
        text += &format!("epsilon = {epsilon}, rho = {rho} {}: {why}\n", without_life(why));
    }
    text +=
        &format!("{} points computed, {} resumed, {:.1} s\n", study.computed, study.resumed, study.wall.as_secs_f64());
    text
}

fn point_json(point: &LifetimePoint, criterion: Criterion) -> Value {
    let LifetimePoint { epsilon, rho, x, horizon, omega_b, life } = point;
    let of = |value: fn(&Life) -> Value| life.as_ref().map_or(Value::Null, value);
    let lifetime = life.as_ref().ok().and_then(|life| life.lifetime(criterion));
    let not_before = life.as_ref().ok().filter(|_| lifetime.is_none()).map(|life| life.end);
    json!({
        "epsilon": epsilon,
        "rho": rho,
        "lifetime": lifetime,
        "not_before": not_before,
        "fate": life.as_ref().map_or_else(|why| json!(without_life(why)), |life| json!(life.fate)),
        "energy": of(|life| json!(life.energy)),
        "distance": of(|life| json!(life.distance)),
        "frequency": of(|life| json!(life.frequency)),
        "end": of(|life| json!(life.end)),
        "decoupled": of(|life| json!(life.decoupled)),
        "core_share": of(|life| json!(life.core_share)),
        "contact": of(|life| json!(life.contact)),
        "x": x,
        "horizon": horizon,
        "omega_b": omega_b,
        "sites": of(|life| json!(life.sites)),
        "ends_felt": of(|life| json!(life.ends_felt)),
        "failure": life.as_ref().err(),
    })
}

fn fit_json(fit: PowerLaw) -> Value {
    let mut value = json!(fit);
    value["holds"] = json!(fit.holds());
    value["region"] = json!("rho epsilon^(2(alpha-1)) >= 10, fate radiates");
    value
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

/// A table with a row for each epsilon and a column for each rho.
fn map_of(study: &LifetimeStudy, corner: &str, cell: impl Fn(&LifetimePoint) -> String) -> String {
    let heads: Vec<String> = study.options.rhos.iter().map(|rho| format!("{rho:e}")).collect();
    let head: Vec<&str> = [corner].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let row = |points: &[LifetimePoint]| {
        let first = points.first().map(|point| format!("{:e}", point.epsilon)).unwrap_or_default();
        [first].into_iter().chain(points.iter().map(&cell)).collect()
    };
    table(&head, &study.points.chunks(heads.len()).map(row).collect::<Vec<_>>())
}

fn lifetime_cell(point: &LifetimePoint, criterion: Criterion) -> String {
    let life = match &point.life {
        Ok(life) => life,
        Err(why) => return without_life(why).to_owned(),
    };
    let lifetime = life.lifetime(criterion);
    let seen = lifetime.unwrap_or(life.end);
    let felt = if life.ends_felt.is_some_and(|felt| felt < seen) { "!" } else { "" };
    let relation = if lifetime.is_some() { "" } else { "> " };
    format!("{relation}{seen:.1}{felt}")
}

/// The word for a point without a life: `stopped` or `failed`.
fn without_life(why: &str) -> &'static str {
    if why == STOPPED { "stopped" } else { "failed" }
}

fn fate_cell(point: &LifetimePoint) -> String {
    match &point.life {
        Err(why) => without_life(why).to_owned(),
        Ok(life) => match life.fate {
            Fate::Radiates => "radiates".to_owned(),
            Fate::Decouples => format!("decouples ({:.2}, {:.3})", life.contact, life.core_share),
            Fate::Persists => "persists".to_owned(),
        },
    }
}

fn fit_lines(fit: Option<PowerLaw>) -> String {
    let Some(fit) = fit else {
        return "no power law: it takes four breathers that radiate with rho epsilon^(2(alpha-1)) >= 10, of several sizes and mass ratios".to_owned();
    };
    let PowerLaw { points, factor, rho_power, epsilon_power, largest_ratio, x_power, x_largest_ratio } = fit;
    let verdict =
        if fit.holds() { "a power law" } else { "no power law: the best one is off by more than a factor of 1.25" };
    format!(
        "{verdict}, over {points} points that radiate with x = rho epsilon^(2(alpha-1)) >= 10:\n\
         lifetime ~ {factor:.3} rho^{rho_power:.3} epsilon^{epsilon_power:.3} within a factor of {largest_ratio:.3};\n\
         as a function of x alone, T epsilon^(1-alpha) x^{x_power:.3}, within a factor of {x_largest_ratio:.3}"
    )
}

/// A line a point; a cell without a value is empty.
pub(crate) fn csv(study: &LifetimeStudy) -> Vec<u8> {
    const COLUMNS: &str = "epsilon,rho,lifetime,not_before,fate,energy,distance,frequency,end,decoupled,core_share,contact,x,horizon,omega_b,sites,ends_felt";
    let rows: Vec<Value> = study.points.iter().map(|point| point_json(point, study.options.criterion)).collect();
    rows_csv(COLUMNS, &rows, |_| "")
}

/// Lifetimes over mass ratio and size, each with its number and the first letter of its fate.
#[cfg(feature = "plot")]
fn picture(study: &LifetimeStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{CellMap, Maps, maps};
    let options = &study.options;
    let ascending = |values: &[f64]| {
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        values
    };
    let (x, y) = (ascending(&options.rhos), ascending(&options.epsilons));
    let (mut values, mut notes) = (Vec::new(), Vec::new());
    for epsilon in &y {
        for rho in &x {
            let point = study.points.iter().find(|point| (point.epsilon, point.rho) == (*epsilon, *rho));
            let life = point.and_then(|point| point.life.as_ref().ok());
            values.push(life.map_or(0.0, |life| life.lifetime(options.criterion).unwrap_or(life.end)));
            notes.push(point.map(note(options.criterion)).unwrap_or_default());
        }
    }
    let labels = ["mass ratio ρ", "size ε", "lifetime, or how long it was followed"].map(str::to_owned);
    let caption = format!(
        "Bright breathers u(0) = 2εa about a {}, α = {}; lifetime by {}. In cells: the lifetime, > where the run ended before; r: radiates, d: decouples, p: persists. hertzchain {}.",
        center_word(options.center),
        options.alpha,
        criterion_words(options.criterion).0,
        env!("CARGO_PKG_VERSION")
    );
    let map = CellMap { labels, x, y, values, notes, ..CellMap::default() };
    Ok(maps(&Maps { title: "Lifetimes of bright breathers".to_owned(), maps: vec![map], caption })?)
}

#[cfg(feature = "plot")]
fn note(criterion: Criterion) -> impl Fn(&LifetimePoint) -> String {
    move |point| {
        let fate = fate_cell(point).chars().next().unwrap_or_default();
        format!("{} {fate}", lifetime_cell(point, criterion))
    }
}
