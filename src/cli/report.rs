//! `hertzchain paper report`.

use super::{DONE, Exit, FAILED, print, progress_bar, runner::Runs, say};
use crate::{
    error::{Error, Result},
    interrupt,
    output::{Folder, to_json},
    paper::{FIGURES, Figure, Verify},
    present::{Page, Section, Shown},
    report::Report,
    study::{ChartOptions, Charts, Compare, CompareOptions, OrderOptions, RhoLaw, Study, TheoremOptions},
    sweep::{Engine, Progress},
};
use clap::Args;
use std::{path::PathBuf, time::Instant};

#[derive(Args)]
pub(crate) struct ReportArgs {
    /// Parts to make, separated by commas [default: all].
    ///
    /// Of compare, order, theorem, stability, verify, figures.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    only: Vec<String>,
    /// Write the results to this folder.
    ///
    /// Files: report.html, the data in report.zip, and report.json.
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    out: PathBuf,
    /// Print JSON instead of text.
    ///
    /// What was made, wall times and failures.
    #[arg(long)]
    json: bool,
}

/// A part of the report, in its short form.
struct Part {
    name: &'static str,
    title: &'static str,
    shows: &'static str,
    /// Approximate run time relative to the other parts, for the progress bar.
    share: f64,
    make: fn(Progress<'_>) -> Result<Vec<Report>>,
}

const PARTS: &[Part] = &[
    Part {
        name: "compare",
        title: "Error against run time",
        shows: "Which integrator buys which error for which run time, on the first run of the paper (scene tw-q15).",
        share: 0.15,
        make: comparison,
    },
    Part {
        name: "order",
        title: "Order through contacts",
        shows: "What contacts do to the order of every method, and which methods keep theirs.",
        share: 0.1,
        make: |tell| of(&OrderOptions::default(), tell),
    },
    Part {
        name: "theorem",
        title: "Theorem 1",
        shows: "The errors of the DpS equation over their powers of ε stay bounded where resonators are as heavy as the theorem asks, and not where they are lighter.",
        share: 0.05,
        make: theorems,
    },
    Part {
        name: "stability",
        title: "Stiff and extreme cases",
        shows: "Where every integrator is stable, drifts or is lost, and which step it needs: light resonators, stiff contacts and springs, other exponents, long chains and runs.",
        share: 0.15,
        make: stability,
    },
    Part {
        name: "verify",
        title: "The numbers of the paper",
        shows: "Every number and statement of the paper's text against ours, each with its verdict.",
        share: 0.1,
        make: |tell| of(&Verify { section: None }, tell),
    },
    Part {
        name: "figures",
        title: "The figures of the paper",
        shows: "All figures of the paper, and some that it has not, made anew.",
        share: 0.6,
        make: figures,
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
        let printed = print(&if self.json { json } else { report.text() });
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
        let results = match (self.make)(tell) {
            Ok(reports) => {
                reports.into_iter().map(|report| Shown::new(report).map_err(|error| error.to_string())).collect()
            }
            Err(error) => vec![Err(error.to_string())],
        };
        let (name, title, shows) = (self.name, self.title, self.shows.to_owned());
        Section { name, title, shows, results, wall: clock.elapsed() }
    }
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
