//! Reports of lifetimes.

use super::table;
use crate::{
    dps::Center,
    error::Result,
    experiments::{Criterion, Fate, Life, LifetimePoint, LifetimeStudy, PowerLaw},
    output::{Folder, to_json},
};
use serde_json::{Value, json};

/// The study as JSON. Each point has its lifetime by the criterion of the study, or null and `not_before`; and by all three.
pub fn lifetimes_json(study: &LifetimeStudy) -> String {
    to_json(&value(study))
}

/// The same with what it took: points `computed` and `resumed`, `wall_s`.
pub fn lifetimes_json_with_work(study: &LifetimeStudy) -> String {
    let mut value = value(study);
    value["computed"] = json!(study.computed);
    value["resumed"] = json!(study.resumed);
    value["wall_s"] = json!(study.wall.as_secs_f64());
    to_json(&value)
}

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
        "fate": life.as_ref().map_or(json!("failed"), |life| json!(life.fate)),
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

/// The study as tables: lifetimes, fates, and the power law.
pub fn lifetimes_table(study: &LifetimeStudy) -> String {
    let options = &study.options;
    let (criterion, meaning) = match options.criterion {
        Criterion::Energy => ("energy", "the core has less than 0.9 of the energy"),
        Criterion::Distance => ("distance", "|A - A~|_1/|A~|_1 is above 0.5, A = u + i u', phase included"),
        Criterion::Frequency => {
            ("frequency", "the central oscillation is nearer to omega than to Omega_b, over four periods")
        }
    };
    let center = if options.center == Center::Site { "site" } else { "bond" };
    let mut text = format!(
        "bright breathers u(0) = 2 epsilon a about a {center}, alpha = {}; lifetime by {criterion}: {meaning}\n\n",
        options.alpha
    );
    text += &map_of(study, "epsilon \\ rho", |point| lifetime_cell(point, options.criterion));
    text += "\n> t: not before t, where the run ended. ";
    text += "!: past the time from which the ends of the chain may be felt.\n\n";
    text += &map_of(study, "fate", fate_cell);
    text += "\nradiates: the core lost a tenth of its energy while its bonds were at work. decouples: contact fell below 1/3 before that, gaps open, sites swing for\n\
             themselves and energy stays, whatever the ansatz says; in brackets contact at the end and the share of energy in the core.\n\n";
    text += &map_of(study, "over T epsilon^(1-alpha)", |point| {
        let lifetime = point.life.as_ref().ok().and_then(|life| life.lifetime(options.criterion));
        lifetime.map_or_else(|| "–".to_owned(), |lifetime| format!("{:.3}", lifetime / point.horizon))
    });
    text += &format!("\n{}\n", fit_lines(study.fit));
    let failures = study.points.iter().filter_map(|point| Some((point, point.life.as_ref().err()?)));
    for (point, why) in failures {
        text += &format!("epsilon = {}, rho = {} failed: {why}\n", point.epsilon, point.rho);
    }
    text +=
        &format!("{} points computed, {} resumed, {:.1} s\n", study.computed, study.resumed, study.wall.as_secs_f64());
    text
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
    let Ok(life) = &point.life else { return "failed".to_owned() };
    let lifetime = life.lifetime(criterion);
    let seen = lifetime.unwrap_or(life.end);
    let felt = if life.ends_felt.is_some_and(|felt| felt < seen) { "!" } else { "" };
    let relation = if lifetime.is_some() { "" } else { "> " };
    format!("{relation}{seen:.1}{felt}")
}

fn fate_cell(point: &LifetimePoint) -> String {
    match &point.life {
        Err(_) => "failed".to_owned(),
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

/// A line a point: `epsilon,rho,lifetime,not_before,fate,energy,distance,frequency,end,decoupled,core_share,contact,x,horizon,omega_b,sites,ends_felt`; what there is not is empty.
pub fn lifetimes_csv(study: &LifetimeStudy) -> Vec<u8> {
    const COLUMNS: [&str; 17] = [
        "epsilon",
        "rho",
        "lifetime",
        "not_before",
        "fate",
        "energy",
        "distance",
        "frequency",
        "end",
        "decoupled",
        "core_share",
        "contact",
        "x",
        "horizon",
        "omega_b",
        "sites",
        "ends_felt",
    ];
    let cell = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(word) => word.clone(),
        Value::Number(number) => number.as_u64().map_or_else(
            || number.as_f64().map(|value| format!("{value:e}")).unwrap_or_default(),
            |whole| whole.to_string(),
        ),
        other => other.to_string(),
    };
    let mut text = COLUMNS.join(",") + "\n";
    for point in &study.points {
        let point = point_json(point, study.options.criterion);
        text += &(COLUMNS.map(|name| cell(&point[name])).join(",") + "\n");
    }
    text.into_bytes()
}

/// Writes `lifetimes.json` and `lifetimes.csv`: the same bytes whether points were resumed or not, and on any number of cores.
///
/// # Errors
/// A file that cannot be written.
pub fn lifetimes_files(folder: &Folder, study: &LifetimeStudy) -> Result<()> {
    folder.write("lifetimes.json", lifetimes_json(study).as_bytes())?;
    folder.write("lifetimes.csv", &lifetimes_csv(study))?;
    Ok(())
}
