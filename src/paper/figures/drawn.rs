//! The result of drawing figures, one line for each.

use super::Figure;
use crate::{
    output::to_json,
    present::table,
    sweep::{Row, STOPPED},
};
use serde_json::{Value, json};
use std::time::Duration;

/// The result of drawing a figure.
#[derive(Debug)]
pub struct Drawn {
    /// The figure.
    pub figure: &'static Figure,
    /// Caption and files of the figure, or why there are none.
    pub outcome: Row<(String, Vec<String>)>,
    /// Wall time of computing and drawing, in the run that did it; `None` if that failed.
    pub wall: Option<Duration>,
}

/// The results as JSON, an object for each figure: `name`, `source`, `title`, `files`, `caption`,
/// `wall_s`, `failure`. The wall time is that of the run that made the figure, and `null` if it was
/// not made.
pub fn figures_json(drawn: &[Drawn]) -> String {
    let row = |Drawn { figure, outcome, wall }: &Drawn| {
        let done = outcome.as_ref().ok();
        json!({
            "name": figure.name,
            "source": figure.source,
            "title": figure.title,
            "files": done.map_or(&[][..], |(_, files)| &files[..]),
            "caption": done.map(|(caption, _)| caption),
            "wall_s": wall.map(|wall| wall.as_secs_f64()),
            "failure": outcome.as_ref().err(),
        })
    };
    to_json(&json!({ "figures": drawn.iter().map(row).collect::<Vec<Value>>(), "version": env!("CARGO_PKG_VERSION") }))
}

/// The results as a table.
pub fn figures_table(drawn: &[Drawn]) -> String {
    let row = |Drawn { figure, outcome, wall }: &Drawn| {
        let files = match outcome {
            Ok((_, files)) => files.len().to_string(),
            Err(why) if why == STOPPED => "missing".to_owned(),
            Err(_) => "FAILED".to_owned(),
        };
        let wall = wall.map_or_else(String::new, |wall| format!("{:.2}", wall.as_secs_f64()));
        vec![figure.name.to_owned(), files, wall, figure.source.to_owned(), figure.title.to_owned()]
    };
    table(&["figure", "files", "wall (s)", "source", "title"], &drawn.iter().map(row).collect::<Vec<_>>())
}
