//! `hertzchain paper figures`.

use super::{DONE, Exit, FAILED, args::FiguresArgs, print, progress_bar, say};
use crate::{
    error::Result,
    output::Folder,
    paper::{Drawn, FIGURES, Figure, figures_json, figures_table},
};
use std::time::Instant;

pub(super) fn main(args: &FiguresArgs) -> Exit {
    let chosen = chosen(&args.only)?;
    let folder = Folder::create(&args.out)?;
    let bar = progress_bar();
    let draw = |(k, figure): (usize, &'static Figure)| {
        let clock = Instant::now();
        bar.set_message(figure.name);
        let tell = |share: f64| bar.set_position((1000.0 * (k as f64 + share.min(1.0)) / chosen.len() as f64) as u64);
        Drawn { figure, outcome: files(figure, args, &folder, &tell), wall: clock.elapsed() }
    };
    let drawn: Vec<Drawn> = chosen.iter().copied().enumerate().map(draw).collect();
    bar.finish_and_clear();
    let printed = print(&if args.json { figures_json(&drawn) + "\n" } else { figures_table(&drawn) });
    let mut code = DONE;
    for Drawn { figure, outcome, .. } in &drawn {
        if let Err(error) = outcome {
            say(&format!("error: figure {}: {error}", figure.name));
            code = FAILED;
        }
    }
    say(&format!("written to {}", folder.path().display()));
    printed.map(|()| code)
}

/// The figures that are asked for, each once and in the order of the paper; all, if none is.
fn chosen(only: &[String]) -> Result<Vec<&'static Figure>> {
    let wanted: Vec<_> = only.iter().map(|name| Figure::named(name.trim())).collect::<Result<_>>()?;
    Ok(FIGURES.iter().filter(|figure| only.is_empty() || wanted.iter().any(|one| one.name == figure.name)).collect())
}

/// Computes a figure and writes its tables and its picture. Returns its caption and the names of
/// the files.
#[cfg_attr(not(feature = "plot"), allow(unused_variables, reason = "formats are those of pictures"))]
fn files(
    figure: &Figure,
    args: &FiguresArgs,
    folder: &Folder,
    tell: &(dyn Fn(f64) + Sync),
) -> Result<(String, Vec<String>)> {
    let data = figure.data(tell)?;
    let files = figure.tables(&data);
    #[cfg(feature = "plot")]
    let drawings = [(format!("{}.png", figure.name), figure.picture(&data)?)];
    #[cfg(feature = "plot")]
    let pictures = args.formats.write(folder, &drawings)?;
    let caption = figure.caption(&data);
    let origin = (format!("{}.json", figure.name), figure.origin(&caption).into_bytes());
    let files = [files, vec![origin]].concat();
    for (name, bytes) in &files {
        folder.write(name, bytes)?;
    }
    let names = files.into_iter().map(|(name, _)| name);
    #[cfg(feature = "plot")]
    let names = pictures.into_iter().chain(names);
    Ok((caption, names.collect()))
}
