//! `hertzchain paper report`.

use super::{DONE, Exit, FAILED, args::ReportArgs, print, progress_bar, say};
use crate::{
    error::{Error, Result},
    interrupt,
    output::Folder,
    paper::{FIGURES, Figure, verify, verify_report},
    present::{Block, Page, Section},
    report,
    scene::Scene,
    study::{
        ChartOptions, CompareOptions, OrderOptions, Problem, RhoLaw, TheoremOptions, charts, compare, order, theorem,
    },
    sweep::Engine,
};
#[cfg(feature = "plot")]
use crate::{figures::Format, study::Drawing};
use std::time::Instant;

/// Callback that receives the share of a part that is done, from 0 to 1.
type Tell<'a> = &'a (dyn Fn(f64) + Sync);

/// A part of the report, in its short form.
struct Part {
    name: &'static str,
    title: &'static str,
    shows: &'static str,
    /// Approximate run time relative to the other parts, for the progress bar.
    share: f64,
    blocks: fn(Tell<'_>) -> Result<Vec<Block>>,
}

const PARTS: &[Part] = &[
    Part {
        name: "compare",
        title: "Error against run time",
        shows: "Which integrator buys which error for which run time, on the first run of the paper (scene tw-q15).",
        share: 0.15,
        blocks: comparison,
    },
    Part {
        name: "order",
        title: "Order through contacts",
        shows: "What contacts do to the order of every method, and which methods keep theirs.",
        share: 0.1,
        blocks: orders,
    },
    Part {
        name: "theorem",
        title: "Theorem 1",
        shows: "The errors of the DpS equation over their powers of ε stay bounded where resonators are as heavy as the theorem asks, and not where they are lighter.",
        share: 0.05,
        blocks: theorems,
    },
    Part {
        name: "stability",
        title: "Stiff and extreme cases",
        shows: "Where every integrator is stable, drifts or is lost, and which step it needs: light resonators, stiff contacts and springs, other exponents, long chains and runs.",
        share: 0.15,
        blocks: stability,
    },
    Part {
        name: "verify",
        title: "The numbers of the paper",
        shows: "Every number and statement of the paper's text against ours, each with its verdict.",
        share: 0.1,
        blocks: verdicts,
    },
    Part {
        name: "figures",
        title: "The figures of the paper",
        shows: "All figures of the paper, and some that it has not, made anew.",
        share: 0.6,
        blocks: figures,
    },
];

/// Approximate duration of the comparison, in seconds.
const SHORT: f64 = 45.0;
/// The longest chain, the longest run in contact periods, and the most work of a run in the charts
/// of stability.
const SITES: usize = 1000;
const PERIODS: f64 = 1000.0;
const WORK: f64 = 1e6;
/// Sizes of Theorem 1.
const EPSILONS: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

pub(super) fn main(args: &ReportArgs) -> Exit {
    let parts = chosen(&args.only)?;
    let folder = Folder::own(&args.out, None)?;
    let bar = progress_bar();
    let whole: f64 = parts.iter().map(|part| part.share).sum();
    let mut page = Page::default();
    let mut before = 0.0;
    for part in &parts {
        bar.set_message(part.name);
        let tell = |share: f64| bar.set_position((1000.0 * (before + part.share * share.min(1.0)) / whole) as u64);
        let section = part.section(&tell);
        if interrupt::asked() {
            bar.finish_and_clear();
            let kept = format!("{} of {} parts are in {}", page.sections.len(), parts.len(), args.out.display());
            return Err(Error::Stopped { kept });
        }
        page.sections.push(section);
        before += part.share;
        // If a later part is killed, the page with the parts so far is kept.
        folder.write("report.html", page.html().as_bytes())?;
    }
    bar.finish_and_clear();
    let json = page.json() + "\n";
    folder.write("report.json", json.as_bytes())?;
    let printed = print(&if args.json { json } else { page.table() });
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

/// The parts that are asked for, in their order; all, if none is.
fn chosen(only: &[String]) -> Result<Vec<&'static Part>> {
    let known = || PARTS.iter().map(|part| part.name);
    if let Some(name) = only.iter().find(|name| !known().any(|known| known == name.trim())) {
        return Err(Error::unknown("part of the report", name, known()));
    }
    Ok(PARTS.iter().filter(|part| only.is_empty() || only.iter().any(|name| name.trim() == part.name)).collect())
}

impl Part {
    /// The section of this part on the page. A failure becomes a block of the section and does not
    /// stop other parts.
    fn section(&self, tell: Tell<'_>) -> Section {
        let clock = Instant::now();
        let blocks = (self.blocks)(tell).unwrap_or_else(|error| vec![Block::Failure(error.to_string())]);
        let (name, title, shows) = (self.name, self.title, self.shows.to_owned());
        Section { name, title, shows, blocks, wall: clock.elapsed() }
    }
}

fn comparison(tell: Tell<'_>) -> Result<Vec<Block>> {
    let scene = Scene::load("tw-q15")?;
    let options = CompareOptions { integrators: vec!["all".to_owned()], max_time: SHORT };
    told(&compare(&scene, &options, &|share, _| tell(share))?.report())
}

fn orders(tell: Tell<'_>) -> Result<Vec<Block>> {
    told(
        &order(&OrderOptions { alpha: 1.5, beads: 6, integrators: vec![] }, &Engine::threads(), &|share, _| {
            tell(share)
        })?
        .report(),
    )
}

fn theorems(tell: Tell<'_>) -> Result<Vec<Block>> {
    let laws = [RhoLaw::Heavy, RhoLaw::Light];
    let blocks = |(k, rho_law): (usize, RhoLaw)| {
        let options = TheoremOptions { rho_law, epsilons: EPSILONS.to_vec(), ..TheoremOptions::default() };
        let study = theorem(&options, &Engine::threads(), &|share, _| tell((k as f64 + share) / laws.len() as f64))?;
        told(&study.report())
    };
    let laws: Vec<Vec<Block>> = laws.into_iter().enumerate().map(blocks).collect::<Result<_>>()?;
    Ok(laws.concat())
}

fn stability(tell: Tell<'_>) -> Result<Vec<Block>> {
    let options = ChartOptions {
        charts: Vec::new(),
        integrators: Vec::new(),
        sites: SITES,
        periods: PERIODS,
        work: WORK,
        quick: true,
    };
    told(&charts(&Problem::built_in(), &options, &Engine::threads(), &|share, _| tell(share))?.report())
}

fn verdicts(tell: Tell<'_>) -> Result<Vec<Block>> {
    let verification = verify(None, &Engine::threads(), &|share, _| tell(share))?;
    let unexpected: Vec<&str> = verification.unexpected().map(|item| item.claim.id.as_str()).collect();
    let mut blocks = told(&verify_report(&verification))?;
    if !unexpected.is_empty() {
        blocks.push(Block::Failure(format!("not as known: {}", unexpected.join(", "))));
    }
    Ok(blocks)
}

fn figures(tell: Tell<'_>) -> Result<Vec<Block>> {
    let blocks = |(k, figure): (usize, &'static Figure)| {
        let made = figure.report(&|share| tell((k as f64 + share) / FIGURES.len() as f64));
        let made = made.and_then(|report| told(&report));
        made.unwrap_or_else(|error| vec![Block::Failure(format!("{}: {error}", figure.name))])
    };
    Ok(FIGURES.iter().enumerate().flat_map(blocks).collect())
}

/// Pictures, text and numbers of a study.
fn told(report: &report::Report) -> Result<Vec<Block>> {
    #[cfg(feature = "plot")]
    let pictures = report.drawn()?.iter().map(drawn).collect::<Result<Vec<_>>>()?;
    #[cfg(not(feature = "plot"))]
    let pictures = vec![];
    let all = report.blocks().iter().cloned().map(Block::Told);
    Ok(pictures.into_iter().chain(all).chain([Block::Data(report.csv().collect())]).collect())
}

/// A picture with its own title and caption.
#[cfg(feature = "plot")]
fn drawn((_, picture): &Drawing) -> Result<Block> {
    let (title, caption) = (picture.title().to_owned(), picture.caption().to_owned());
    Ok(Block::Picture { title, caption, svg: picture.file(Format::Svg)? })
}
