//! The result of drawing figures, one line for each.

use super::Figure;
use crate::{error::Error, output::to_json, present::table};
use serde_json::{Value, json};
use std::time::Duration;

/// The result of drawing a figure.
#[derive(Debug)]
pub struct Drawn {
    /// The figure.
    pub figure: &'static Figure,
    /// Caption and files of the figure, or the error.
    pub outcome: Result<(String, Vec<String>), Error>,
    /// Wall time of computing and drawing.
    pub wall: Duration,
}

/// The results as JSON, an object for each figure: `name`, `source`, `title`, `files`, `caption`,
/// `wall_s`, `failure`.
pub fn figures_json(drawn: &[Drawn]) -> String {
    let row = |Drawn { figure, outcome, wall }: &Drawn| {
        let done = outcome.as_ref().ok();
        json!({
            "name": figure.name,
            "source": figure.source,
            "title": figure.title,
            "files": done.map_or(&[][..], |(_, files)| &files[..]),
            "caption": done.map(|(caption, _)| caption),
            "wall_s": wall.as_secs_f64(),
            "failure": outcome.as_ref().err().map(ToString::to_string),
        })
    };
    to_json(&json!({ "figures": drawn.iter().map(row).collect::<Vec<Value>>(), "version": env!("CARGO_PKG_VERSION") }))
}

/// The results as a table.
pub fn figures_table(drawn: &[Drawn]) -> String {
    let row = |Drawn { figure, outcome, wall }: &Drawn| {
        let files = match outcome {
            Ok((_, files)) => files.len().to_string(),
            Err(_) => "FAILED".to_owned(),
        };
        let wall = format!("{:.2}", wall.as_secs_f64());
        vec![figure.name.to_owned(), files, wall, figure.source.to_owned(), figure.title.to_owned()]
    };
    table(&["figure", "files", "wall (s)", "source", "title"], &drawn.iter().map(row).collect::<Vec<_>>())
}
