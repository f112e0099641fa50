//! `hertzchain paper figures`: a sweep whose points are figures.
//!
//! The row of a figure has its caption and the contents of its files, so that a shard or another
//! rank needs no folder for them. Files in the folder are written from rows only. Those that were
//! changed or removed since an earlier run are so written again.

use super::{
    DONE, Exit, FAILED, print, progress_bar,
    runner::{EngineArgs, Runs, part_report},
    say,
};
use crate::{
    error::{Error, Result},
    interrupt,
    output::{Folder, to_json},
    paper::{FIGURES, Figure},
    report::{
        Digits::{Fixed, Json, Short},
        Report, Table,
    },
    sweep::{self, Engine, Grid, Job, Row, STOPPED},
};
use base64::{Engine as _, engine::general_purpose::STANDARD};
use clap::Args;
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{
    path::PathBuf,
    sync::atomic::{AtomicU64, Ordering},
    time::Instant,
};

#[derive(Args)]
pub(crate) struct FiguresArgs {
    #[arg(
        long,
        value_name = "A,B,..",
        value_delimiter = ',',
        help = "Figures to make, separated by commas [default: all]",
        long_help = figures_help()
    )]
    only: Vec<String>,
    /// Write the results to this folder.
    ///
    /// Files: NAME.png (or .svg, as --format says), the tables NAME-….csv, and NAME.json, which
    /// says what made them; figures.store, which keeps every finished figure for the next run.
    #[arg(long, value_name = "DIR", default_value = "out/figures")]
    out: PathBuf,
    #[command(flatten)]
    engine_args: EngineArgs,
    #[cfg(feature = "plot")]
    #[command(flatten)]
    formats: super::formats::Formats,
    /// Print JSON instead of text.
    ///
    /// Name, source, title, files, caption and wall time of every figure.
    #[arg(long)]
    json: bool,
}

fn figures_help() -> String {
    let names: Vec<_> = crate::paper::FIGURES.iter().map(|figure| figure.name).collect();
    format!("Figures to make, separated by commas [default: all].\n\nOf {}.", names.join(", "))
}

const STORE: &str = "figures.store";

#[derive(Serialize)]
struct Point {
    figure: &'static str,
    /// The formats of its picture; none in a build without pictures.
    formats: Vec<&'static str>,
}

/// A figure, and what was made of it or why nothing was.
type Drawn = (&'static Figure, Row<Made>);

#[derive(Debug, Serialize, Deserialize)]
struct Made {
    caption: String,
    files: Vec<MadeFile>,
    wall_s: f64,
}

/// Makes a figure, and tells the share that is done.
type Make<'a> = dyn Fn(&Figure, &(dyn Fn(f64) + Sync)) -> Result<Made> + Sync + 'a;

/// A file of a figure: its name and what is in it.
#[derive(Debug, Serialize, Deserialize)]
struct MadeFile {
    name: String,
    #[serde(flatten)]
    content: Content,
}

/// Bytes as they stand in JSON.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Content {
    Text(String),
    Base64(String),
}

impl Runs for FiguresArgs {
    fn run(&self) -> Exit {
        let engine = self.engine_args.engine(Engine::in_turn)?;
        let formats = formats(self);
        let make = |figure: &Figure, tell: &(dyn Fn(f64) + Sync)| made(figure, self, tell);
        if engine.serves() {
            // Rank 0 reports errors.
            let sweep = |chosen: Vec<_>| sweep(&chosen, &formats, &engine, &ProgressBar::hidden(), &make).map(drop);
            let _ = chosen(&self.only).and_then(sweep);
            return Ok(DONE);
        }
        let chosen = chosen(&self.only)?;
        let folder = self.engine_args.own(&self.out)?;
        let engine = self.engine_args.keeping(engine, Some(&folder))?;
        let bar = progress_bar();
        let swept = sweep(&chosen, &formats, &engine, &bar, &make);
        bar.finish_and_clear();
        match engine.part() {
            Some(part) if part.kept == part.points => {
                let report = part_report(&part);
                print(&if self.json { to_json(&report.json()) + "\n" } else { report.text() }).map(|()| DONE)
            }
            _ => swept.and_then(|(drawn, resumed)| told(&drawn, resumed, self.json, &folder)),
        }
    }
}

/// The figures that are asked for, each once and in the order of the paper; all, if none is.
fn chosen(only: &[String]) -> Result<Vec<&'static Figure>> {
    let wanted: Vec<_> = only.iter().map(|name| Figure::named(name.trim())).collect::<Result<_>>()?;
    Ok(FIGURES.iter().filter(|figure| only.is_empty() || wanted.iter().any(|one| one.name == figure.name)).collect())
}

/// Makes the figures that the store does not have by `make`, and brings the files of all into the
/// folder. Returns the number of figures that the store had.
fn sweep(
    chosen: &[&'static Figure],
    formats: &[&'static str],
    engine: &Engine,
    bar: &ProgressBar,
    make: &Make<'_>,
) -> Result<(Vec<Drawn>, usize)> {
    let grid = Grid { store: STORE, study: "figures", settings: serde_json::json!({}) };
    let key = |k: usize| sweep::key(&Point { figure: chosen[k].name, formats: formats.to_vec() });
    let (count, done) = (chosen.len() as f64, AtomicU64::new(0));
    let position = |done: f64| bar.set_position((1000.0 * done / count) as u64);
    let progress = |made: u64, _| {
        done.store(made, Ordering::Relaxed);
        position(made as f64);
    };
    let folder = engine.folder();
    let at_once = folder.filter(|_| engine.its_shard().is_none());
    let work = |figure: &Figure| {
        bar.set_message(figure.name);
        let made = make(figure, &|share| position(done.load(Ordering::Relaxed) as f64 + share.min(1.0)))?;
        // A finished figure can be looked at while others are computed. An error here is met again
        // when all is done.
        if let Some(folder) = at_once {
            drop(written(figure, &made, folder));
        }
        Ok(made)
    };
    let each = |ks: &[usize]| ks.iter().map(|&k| sweep::text(work(chosen[k]))).collect();
    let check = sweep::check::<Made>;
    let job = Job { count: chosen.len(), key: &key, work: &each, together: 1, check, progress: &progress };
    engine.each(&grid, &job, |rows| {
        let mut drawn = Vec::with_capacity(chosen.len());
        let bring = |k: usize, row: Row<Made>| brought(chosen[k], row, folder);
        rows.each(&bring, &mut |one| {
            drawn.push(one);
            Ok(())
        })?;
        Ok(drawn)
    })
}

#[cfg(feature = "plot")]
fn formats(args: &FiguresArgs) -> Vec<&'static str> {
    args.formats.chosen().map(crate::figures::Format::extension).collect()
}

#[cfg(not(feature = "plot"))]
fn formats(_: &FiguresArgs) -> Vec<&'static str> {
    Vec::new()
}

/// Computes a figure, its tables and its picture.
#[cfg_attr(not(feature = "plot"), allow(unused_variables, reason = "formats are those of pictures"))]
fn made(figure: &Figure, args: &FiguresArgs, tell: &(dyn Fn(f64) + Sync)) -> Result<Made> {
    let clock = Instant::now();
    let report = figure.report(&|share, _| tell(share))?;
    if interrupt::asked() {
        // Computations that were asked to end may have returned a part of their results.
        return Err(Error::Stopped { kept: "nothing of this figure".to_owned() });
    }
    let caption = report.json()["caption"].as_str().unwrap_or_default().to_owned();
    #[cfg(feature = "plot")]
    let mut files = args.formats.files(&report.drawn()?)?;
    #[cfg(not(feature = "plot"))]
    let mut files = Vec::new();
    files.extend(report.csv());
    files.push((format!("{}.json", figure.name), to_json(&report.json()).into_bytes()));
    Ok(Made { caption, files: files.into_iter().map(MadeFile::of).collect(), wall_s: clock.elapsed().as_secs_f64() })
}

impl MadeFile {
    fn of((name, bytes): (String, Vec<u8>)) -> Self {
        let content =
            String::from_utf8(bytes).map_or_else(|why| Content::Base64(STANDARD.encode(why.as_bytes())), Content::Text);
        Self { name, content }
    }

    fn bytes(&self) -> Result<Vec<u8>> {
        match &self.content {
            Content::Text(text) => Ok(text.as_bytes().to_vec()),
            Content::Base64(text) => STANDARD
                .decode(text)
                .map_err(|why| Error::parameter("base64", why, "the store of figures has files in base64")),
        }
    }
}

/// A figure whose files are in the folder; what is in them is dropped.
fn brought(figure: &'static Figure, row: Row<Made>, folder: Option<&Folder>) -> Drawn {
    let row = row.and_then(|mut made| {
        folder.map_or(Ok(()), |folder| written(figure, &made, folder)).map_err(|error| error.to_string())?;
        made.files.iter_mut().for_each(|file| file.content = Content::Text(String::new()));
        Ok(made)
    });
    (figure, row)
}

/// What was drawn, a row for each figure. The wall time is that of the run that made the figure.
fn figures_report(drawn: &[Drawn]) -> Report {
    let files = |one: &Drawn| -> Vec<String> {
        one.1.iter().flat_map(|made| &made.files).map(|file| file.name.clone()).collect()
    };
    let outcome = |(_, row): &Drawn| match row {
        Ok(_) => "ok",
        Err(why) if why == STOPPED => "missing",
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
        .col("files", Json, "", |one| json!(files(one)))
        .col("caption", Json, "", |one| one.1.as_ref().ok().map(|made| made.caption.clone()))
        .col("failure", Json, "", |one| one.1.as_ref().err().cloned());
    Report::new("figures").table(table)
}

/// Writes the files of a figure, unless they are there with the same bytes, and removes its picture
/// in formats that are not asked for.
fn written(figure: &Figure, made: &Made, folder: &Folder) -> Result<()> {
    #[cfg(feature = "plot")]
    {
        let pictures = super::formats::names(&format!("{}.png", figure.name));
        let left: Vec<&String> =
            pictures.iter().filter(|name| made.files.iter().all(|file| file.name != **name)).collect();
        folder.remove(left.into_iter().map(String::as_str))?;
    }
    #[cfg(not(feature = "plot"))]
    let _ = figure;
    made.files.iter().try_for_each(|file| {
        let bytes = file.bytes()?;
        let there = std::fs::read(folder.path().join(&file.name)).is_ok_and(|there| there == bytes);
        if there { Ok(()) } else { folder.write(&file.name, &bytes).map(drop) }
    })
}

/// Prints what was drawn, and says what failed or is missing.
fn told(drawn: &[Drawn], resumed: usize, json: bool, folder: &Folder) -> Exit {
    let report = figures_report(drawn);
    let printed = print(&if json { to_json(&report.json()) + "\n" } else { report.text() });
    let (mut code, mut missing) = (DONE, 0);
    for (figure, row) in drawn {
        match row {
            Err(why) if why == STOPPED => missing += 1,
            Err(why) => {
                say(&format!("error: figure {}: {why}", figure.name));
                code = FAILED;
            }
            Ok(_) => {}
        }
    }
    let (count, store) = (drawn.len(), folder.path().join(STORE));
    if resumed > 0 {
        say(&format!("{resumed} of {count} figures are from {}: remove it to make them anew", store.display()));
    }
    if missing > 0 {
        say(&format!("{missing} of {count} figures are missing: the same command goes on"));
    }
    say(&format!("written to {}", folder.path().display()));
    printed.map(|()| code)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    // Rows of their own: the table of all figures would compile all studies for these two tests.
    static FIRST: Figure = Figure::named_only("first");
    static SECOND: Figure = Figure::named_only("second");
    static THIRD: Figure = Figure::named_only("third");

    fn small(name: &str) -> Made {
        let file = |name: String| MadeFile::of((name, vec![0xff, 0x00, 0xfe]));
        Made { caption: name.to_owned(), files: vec![file(format!("{name}.csv"))], wall_s: 1.5 }
    }

    #[test]
    fn a_figure_that_panics_or_fails_is_a_row_of_its_own_and_the_others_go_on() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Folder::create(folder.path()).unwrap();
        let engine = Engine::in_turn().keeping(&folder);
        let chosen = [&FIRST, &SECOND, &THIRD];
        let made = Mutex::new(Vec::new());
        let make = |figure: &Figure, _: &(dyn Fn(f64) + Sync)| {
            made.lock().unwrap().push(figure.name);
            match figure.name {
                "first" => panic!("on purpose"),
                "second" => Err(Error::parameter("size", 7, "smaller")),
                name => Ok(small(name)),
            }
        };
        for resumed in [0, 3] {
            let (drawn, before) = sweep(&chosen, &["png"], &engine, &ProgressBar::hidden(), &make).unwrap();
            assert_eq!(before, resumed);
            let [panicked, failed, done] = &drawn[..] else { panic!("{drawn:?}") };
            assert_eq!(panicked.1.as_ref().unwrap_err(), "panicked: on purpose");
            assert!(failed.1.as_ref().is_err_and(|why| why.contains("size = 7")));
            let Made { caption, files, wall_s } = done.1.as_ref().unwrap();
            assert_eq!((caption.as_str(), &*files[0].name, *wall_s), ("third", "third.csv", 1.5));
            assert_eq!(std::fs::read(folder.path().join("third.csv")).unwrap(), [0xff, 0x00, 0xfe]);
            assert_eq!(told(&drawn, before, false, &folder).unwrap(), FAILED);
            let report = figures_report(&drawn);
            let (json, table) = (to_json(&report.json()), report.text());
            assert!(json.contains("panicked: on purpose") && json.contains("\"wall_s\": null"), "{json}");
            assert_eq!(table.matches("FAILED").count(), 2, "{table}");
        }
        // A failed row is kept as any other, so that each figure was made once.
        assert_eq!(*made.lock().unwrap(), ["first", "second", "third"]);
    }

    #[test]
    fn a_figure_whose_file_cannot_be_written_does_not_lose_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Folder::create(folder.path()).unwrap();
        let engine = Engine::in_turn().keeping(&folder);
        let chosen = [&FIRST, &SECOND];
        // A folder in the place of a file, which was not there when the command began.
        std::fs::create_dir_all(folder.path().join("first.csv/in the way")).unwrap();
        let make = |figure: &Figure, _: &(dyn Fn(f64) + Sync)| Ok(small(figure.name));
        let (drawn, _) = sweep(&chosen, &["png"], &engine, &ProgressBar::hidden(), &make).unwrap();
        assert!(drawn[0].1.as_ref().is_err_and(|why| why.contains("first.csv")), "{drawn:?}");
        assert!(drawn[1].1.is_ok() && folder.path().join("second.csv").is_file(), "{drawn:?}");
        assert_eq!(told(&drawn, 0, false, &folder).unwrap(), FAILED);
    }
}
