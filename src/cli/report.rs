//! `hertzchain paper report`.

use super::{DONE, Exit, FAILED, columns, print, progress_bar, runner::Runs, say};
use crate::{
    error::{Error, Result},
    interrupt,
    output::{Folder, to_json},
    paper::{FIGURES, Figure, Verify},
    present::{Page, Section, Shown},
    report::Report,
    study::{ChartOptions, Charts, Compare, CompareOptions, OrderOptions, RhoLaw, Study, TheoremOptions, options},
    sweep::{Engine, Progress},
};
use serde_json::Value;
use std::{
    io::{IsTerminal, stderr},
    path::PathBuf,
    time::Instant,
};

options! {
    pub(crate) struct ReportArgs {
        /// Parts to make, separated by commas [default: all].
        ///
        /// Of compare, order, theorem, stability, verify, figures.
        only: Vec<String> = vec![], "A,B,..";
        /// Write the results to this folder.
        ///
        /// Files: report.html, the data in report.zip, and report.json.
        out: PathBuf = "out/report".into(), "DIR";
        /// Print JSON instead of text.
        ///
        /// What was made, wall times and failures.
        json: bool = false;
    }
}

/// A part of the report, in its short form.
struct Part {
    name: &'static str,
    title: &'static str,
    shows: &'static str,
    /// Approximate run time relative to the other parts, for the progress bar.
    share: f64,
    make: fn(Progress<'_>) -> Result<Vec<Report>>,
    /// What was found, for the top of the page.
    found: fn(&Value) -> Option<String>,
}

const PARTS: &[Part] = &[
    Part {
        name: "compare",
        title: "Error against run time",
        shows: "Which integrator buys which error for which run time, on the first run of the paper (scene tw-q15).",
        share: 0.15,
        make: comparison,
        found: fastest,
    },
    Part {
        name: "order",
        title: "Order through contacts",
        shows: "What contacts do to the order of every method, and which methods keep theirs.",
        share: 0.1,
        make: |tell| of(&OrderOptions::default(), tell),
        found: orders,
    },
    Part {
        name: "theorem",
        title: "Theorem 1",
        shows: "The errors of the DpS equation over their powers of ε stay bounded where resonators are as heavy as the theorem asks, and not where they are lighter.",
        share: 0.05,
        make: theorems,
        found: |_| None,
    },
    Part {
        name: "stability",
        title: "Stiff and extreme cases",
        shows: "Where every integrator is stable, drifts or is lost, and which step it needs: light resonators, stiff contacts and springs, other exponents, long chains and runs.",
        share: 0.15,
        make: stability,
        found: extremes,
    },
    Part {
        name: "verify",
        title: "The numbers of the paper",
        shows: "Every number and statement of the paper's text against ours, each with its verdict.",
        share: 0.1,
        make: |tell| of(&Verify { section: None }, tell),
        found: differences,
    },
    Part {
        name: "figures",
        title: "The figures of the paper",
        shows: "All figures of the paper, and some that it has not, made anew.",
        share: 0.6,
        make: figures,
        found: |_| None,
    },
];

/// Approximate duration of the comparison, in seconds.
const SHORT: f64 = 45.0;
/// The longest chain, the longest run in contact periods, and the most work of a run in the charts
/// of stability.
const SITES: usize = 1000;
const PERIODS: f64 = 1000.0;
const WORK: f64 = 1e6;

impl Runs for ReportArgs {
    fn run(&self) -> Exit {
        let parts = chosen(&self.only)?;
        let folder = Folder::own(&self.out, None)?;
        let bar = progress_bar();
        let whole: f64 = parts.iter().map(|part| part.share).sum();
        let mut page = Page::default();
        let mut before = 0.0;
        for part in &parts {
            bar.set_message(part.name);
            let tell = |share: f64, _: &str| {
                bar.set_position((1000.0 * (before + part.share * share.min(1.0)) / whole) as u64)
            };
            let section = part.section(&tell);
            if interrupt::asked() {
                bar.finish_and_clear();
                let kept = format!("{} of {} parts are in {}", page.sections.len(), parts.len(), self.out.display());
                return Err(Error::Stopped { kept });
            }
            if !stderr().is_terminal() {
                say(&format!("{}: {:.0} s", section.name, section.wall.as_secs_f64()));
            }
            page.sections.push(section);
            before += part.share;
            // If a later part is killed, the page with the parts so far is kept.
            for (name, bytes) in page.files()? {
                folder.write(name, &bytes)?;
            }
        }
        bar.finish_and_clear();
        let report = page.report();
        let json = to_json(&report.json()) + "\n";
        folder.write("report.json", json.as_bytes())?;
        let printed = print(&if self.json { json } else { report.text_in(columns()) });
        say(&format!("written to {}", folder.path().join("report.html").display()));
        let mut code = DONE;
        for section in &page.sections {
            for why in section.failures() {
                say(&format!("error: {}: {why}", section.name));
                code = FAILED;
            }
        }
        printed.map(|()| code)
    }
}

/// The parts that are asked for, in their order; all, if none is.
fn chosen(only: &[String]) -> Result<Vec<&'static Part>> {
    let known = || PARTS.iter().map(|part| part.name);
    if let Some(name) = only.iter().find(|name| !known().any(|known| known == name.trim())) {
        return Err(Error::unknown("part of the report", name, known()));
    }
    Ok(PARTS.iter().filter(|part| only.is_empty() || only.iter().any(|name| name.trim() == part.name)).collect())
}

impl Part {
    /// The section of this part on the page. A failure becomes a result of the section and does not
    /// stop other parts.
    fn section(&self, tell: Progress<'_>) -> Section {
        let clock = Instant::now();
        let mut found = None;
        let results = match (self.make)(tell) {
            Ok(reports) => {
                found = reports.first().and_then(|report| (self.found)(&report.json()));
                reports.into_iter().map(|report| Shown::new(report).map_err(|error| error.to_string())).collect()
            }
            Err(error) => vec![Err(error.to_string())],
        };
        let (name, title, shows) = (self.name, self.title, self.shows.to_owned());
        Section { name, title, shows, found, results, wall: clock.elapsed() }
    }
}

/// The numbers of a field of rows that are.
fn numbers<'a>(rows: impl Iterator<Item = &'a Value>, name: &str) -> Vec<f64> {
    rows.filter_map(|row| row[name].as_f64()).collect()
}

fn range(all: &[f64]) -> [f64; 2] {
    [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

/// The fastest method for each error, and what plain loops take.
fn fastest(compare: &Value) -> Option<String> {
    let rows = compare["fastest"].as_array().filter(|rows| !rows.is_empty())?;
    let told = |row: &Value| Some(format!("{:e} ({:.1e} s)", row["error"].as_f64()?, row["wall_s"].as_f64()?));
    let ranges = rows.chunk_by(|a, b| a["integrator"] == b["integrator"]).filter_map(|all| {
        let (name, first, last) = (all[0]["integrator"].as_str()?, told(&all[0])?, told(&all[all.len() - 1])?);
        Some(if all.len() == 1 { format!("{name} for {first}") } else { format!("{name} from {first} to {last}") })
    });
    let plain: Vec<&Value> = rows.iter().filter(|row| row["ratio"].is_f64()).collect();
    let [[least, most], [reached, _]] = ["ratio", "error"].map(|name| range(&numbers(plain.iter().copied(), name)));
    let plain = match plain.is_empty() {
        true => "Plain loops reach none of these errors".to_owned(),
        false => format!("Plain loops reach {reached:e} at best and take {least:.1} to {most:.1} times as long"),
    };
    Some(format!(
        "Fastest on the first run of the paper (tw-q15), by error: {}. {plain}.",
        ranges.collect::<Vec<_>>().join(", ")
    ))
}

/// The orders that methods show through contacts.
fn orders(order: &Value) -> Option<String> {
    let rows = order["rows"].as_array()?.iter().filter(|row| row["quantity"] == "state" && row["slope"].is_f64());
    let (plain, others): (Vec<&Value>, Vec<&Value>) = rows.partition(|row| row["mode"] == "plain");
    let [[_, most], [_, limit]] = ["slope", "slope_theory"].map(|name| range(&numbers(plain.iter().copied(), name)));
    let kept = others.iter().filter(|row| row["slope_theory"].as_f64() > Some(limit)).map(|row| {
        let (method, mode) = (row["method"].as_str()?, row["mode"].as_str()?);
        let name = if method == mode { method.to_owned() } else { format!("{method}-{mode}") };
        Some(format!("{name} {:.2} (theory {})", row["slope"].as_f64()?, row["slope_theory"].as_f64()?))
    });
    Some(format!(
        "Through contacts with α = {} the largest order of {} methods that cross them is {most:.2} (theory {limit}); above it \
         are {}.",
        order["alpha"],
        plain.len(),
        kept.collect::<Option<Vec<_>>>()?.join(", ")
    ))
}

/// The points of a method.
fn of_method<'a>(points: &'a [Value], name: &'a str) -> impl Iterator<Item = &'a Value> {
    points.iter().filter(move |point| point["integrator"] == name)
}

/// Which methods are stable on all stiff and extreme chains, and the price of collocation.
fn extremes(charts: &Value) -> Option<String> {
    let points = charts["points"].as_array()?;
    let mut names: Vec<&str> = points.iter().filter_map(|point| point["integrator"].as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let stable = names.iter().filter(|name| of_method(points, name).all(|point| point["verdict"] == "stable"));
    let worst = |name: &&str| format!("{name} ({:.1e})", range(&numbers(of_method(points, name), "energy_error"))[1]);
    // The chains of all methods are the same, in the same order.
    let prices = of_method(points, "collocation")
        .zip(of_method(points, "verlet"))
        .filter_map(|(it, verlet)| Some(it["cost"].as_f64()? / verlet["cost"].as_f64()?));
    let [least, most] = range(&prices.collect::<Vec<_>>());
    Some(format!(
        "Of {} methods these are stable on all of {} stiff and extreme chains, at 64 kicks a period of the fastest motion or \
         tolerance 1e-9, with their largest energy errors: {}. Collocation takes {least:.1} to {most:.1} times the force \
         evaluations of verlet.",
        names.len(),
        of_method(points, "collocation").count(),
        stable.map(worst).collect::<Vec<_>>().join(", ")
    ))
}

/// How the paper compares.
fn differences(verify: &Value) -> Option<String> {
    let items = verify["items"].as_array()?;
    let count =
        |verdicts: &[&str]| items.iter().filter(|item| verdicts.iter().any(|one| item["verdict"] == *one)).count();
    Some(format!(
        "The paper “Nonlinear waves in a strongly nonlinear resonant granular chain” (Liu, James, Kevrekidis and \
         Vainchtein): of {} numbers and statements in its text we confirm {}; {} cannot be decided from the text; {} are not what \
         we compute, which are {} misprints or errors of the paper, some of them repeated. They are no failures of this program.",
        items.len(),
        count(&["agrees", "holds"]),
        count(&["not decidable"]),
        count(&["differs", "fails"]),
        verify["misprints"],
    ))
}

fn of(study: &impl Study, tell: Progress<'_>) -> Result<Vec<Report>> {
    Ok(vec![study.begin()?(&Engine::threads(), tell)?])
}

fn comparison(tell: Progress<'_>) -> Result<Vec<Report>> {
    let options = CompareOptions { integrators: vec!["all".to_owned()], max_time: SHORT, ..CompareOptions::default() };
    of(&Compare { scene: Some("tw-q15".to_owned()), options, ..Compare::default() }, tell)
}

fn theorems(tell: Progress<'_>) -> Result<Vec<Report>> {
    let laws = [RhoLaw::Heavy, RhoLaw::Light];
    let reports = laws.into_iter().enumerate().map(|(k, rho_law)| {
        let options = TheoremOptions { rho_law, ..TheoremOptions::default() };
        of(&options, &|share, _| tell((k as f64 + share) / laws.len() as f64, ""))
    });
    Ok(reports.collect::<Result<Vec<_>>>()?.concat())
}

fn stability(tell: Progress<'_>) -> Result<Vec<Report>> {
    let options = ChartOptions { sites: SITES, periods: PERIODS, work: WORK, quick: true, ..ChartOptions::default() };
    of(&Charts { options, ..Charts::default() }, tell)
}

fn figures(tell: Progress<'_>) -> Result<Vec<Report>> {
    let report = |(k, figure): (usize, &'static Figure)| {
        let made = figure.report(&|share, _| tell((k as f64 + share) / FIGURES.len() as f64, ""));
        made.unwrap_or_else(|why| Report::new(figure.name).failure(Some(format!("{}: {why}", figure.name))))
    };
    Ok(FIGURES.iter().enumerate().map(report).collect())
}
