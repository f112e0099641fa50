//! `hertzchain paper figures`: one figure after the other, each with its files.

use super::{DONE, Exit, FAILED, formats::Formats, print, progress_bar, runner::Runs, say};
use crate::{
    error::{Error, Result},
    interrupt,
    output::{Folder, to_json},
    paper::{FIGURES, Figure},
    report::{Fixed, Json, Report, Short, Table},
    study::options,
};
use std::{path::PathBuf, time::Instant};

options! {
    pub(crate) struct FiguresArgs {
        /// Figures to make, separated by commas [default: all].
        only: Vec<String> = vec![], "A,B,..", [long_help = figures_help()];
        /// Write the results to this folder.
        ///
        /// Files: NAME.png (or .svg, as --format says), the tables NAME-….csv, and NAME.json, which
        /// says what made them.
        out: PathBuf = "out/figures".into(), "DIR";
        formats: Formats = Formats::default();
        /// Print JSON instead of text.
        ///
        /// Name, source, title, files, caption and wall time of every figure.
        json: bool = false;
    }
}

fn figures_help() -> String {
    let names: Vec<_> = crate::paper::FIGURES.iter().map(|figure| figure.name).collect();
    format!("Figures to make, separated by commas [default: all].\n\nOf {}.", names.join(", "))
}

/// A figure, and what was made of it or why nothing was.
type Drawn = (&'static Figure, Result<Made>);

struct Made {
    caption: String,
    files: Vec<String>,
    wall_s: f64,
}

impl Runs for FiguresArgs {
    fn run(&self) -> Exit {
        let chosen = chosen(&self.only)?;
        let (folder, bar, count) = (Folder::own(&self.out, None)?, progress_bar(), chosen.len() as f64);
        let draw = |(k, figure): (usize, &'static Figure)| {
            bar.set_message(figure.name);
            let tell = |share: f64| bar.set_position((1000.0 * (k as f64 + share.min(1.0)) / count) as u64);
            (figure, self.made(figure, &folder, &tell))
        };
        let drawn: Vec<Drawn> = chosen.into_iter().enumerate().map(draw).collect();
        bar.finish_and_clear();
        told(&drawn, self.json, &folder)
    }
}

impl FiguresArgs {
    /// Computes a figure, and writes its tables and its picture.
    fn made(&self, figure: &Figure, folder: &Folder, tell: &(dyn Fn(f64) + Sync)) -> Result<Made> {
        let clock = Instant::now();
        let stopped = || Error::Stopped { kept: "nothing of this figure".to_owned() };
        let report = if interrupt::asked() { Err(stopped()) } else { figure.report(&|share, _| tell(share)) };
        // Computations that were asked to end may have returned a part of their results.
        let report = if interrupt::asked() { Err(stopped()) } else { report }?;
        let caption = report.json()["caption"].as_str().unwrap_or_default().to_owned();
        let mut files = self.formats.write(folder, &report.drawn()?)?;
        let json = (format!("{}.json", figure.name), to_json(&report.json()).into_bytes());
        for (name, bytes) in report.csv().chain([json]) {
            folder.write(&name, &bytes)?;
            files.push(name);
        }
        Ok(Made { caption, files, wall_s: clock.elapsed().as_secs_f64() })
    }
}

/// The figures that are asked for, each once and in the order of the paper; all, if none is.
fn chosen(only: &[String]) -> Result<Vec<&'static Figure>> {
    let wanted: Vec<_> = only.iter().map(|name| Figure::named(name.trim())).collect::<Result<_>>()?;
    Ok(FIGURES.iter().filter(|figure| only.is_empty() || wanted.iter().any(|one| one.name == figure.name)).collect())
}

/// What was drawn, a row for each figure.
fn figures_report(drawn: &[Drawn]) -> Report {
    let outcome = |(_, made): &Drawn| match made {
        Ok(_) => "ok",
        Err(Error::Stopped { .. }) => "missing",
        Err(_) => "FAILED",
    };
    let table = Table::of("figures", drawn)
        .key("figures")
        .col("name", Short, "", |one| one.0.name)
        .head("figure")
        .col("outcome", Short, "", outcome)
        .col("wall_s", Fixed(2), "", |one| one.1.as_ref().ok().map(|made| made.wall_s))
        .head("wall (s)")
        .col("source", Short, "", |one| one.0.source)
        .col("title", Json, "", |one| one.0.title)
        .col("files", Json, "", |one| one.1.iter().flat_map(|made| made.files.clone()).collect::<serde_json::Value>())
        .col("caption", Json, "", |one| one.1.as_ref().ok().map(|made| made.caption.clone()))
        .col("failure", Json, "", |one| one.1.as_ref().err().map(ToString::to_string));
    Report::new("figures").table(table)
}

/// Prints what was drawn, and says what failed or is missing.
fn told(drawn: &[Drawn], json: bool, folder: &Folder) -> Exit {
    let report = figures_report(drawn);
    let printed = print(&if json { to_json(&report.json()) + "\n" } else { report.text_in(super::columns()) });
    let (mut code, mut missing) = (DONE, Vec::new());
    for (figure, made) in drawn {
        match made {
            Err(Error::Stopped { .. }) => missing.push(figure.name),
            Err(why) => {
                say(&format!("error: figure {}: {why}", figure.name));
                code = FAILED;
            }
            Ok(_) => {}
        }
    }
    if !missing.is_empty() {
        let (some, count) = (missing.len(), drawn.len());
        say(&format!("{some} of {count} figures are missing: --only {} makes them", missing.join(",")));
    }
    say(&format!("written to {}", folder.path().display()));
    printed.map(|()| code)
}
